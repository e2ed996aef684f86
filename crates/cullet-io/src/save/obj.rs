//! OBJ, and its MTL.

use std::io::{self, Write};
use std::path::Path;

use super::{world, world_indices};
use crate::Model;

pub(super) fn write(model: &Model, path: &Path, out: &mut impl Write) -> io::Result<()> {
    let library = path.with_extension("mtl");
    writeln!(out, "# written by cullet")?;
    if !model.materials.is_empty() {
        let mut text = String::from("# written by cullet\n");
        for (i, m) in model.materials.iter().enumerate() {
            let [r, g, b, a] = m.color;
            text += &format!("newmtl {}\nKd {r} {g} {b}\nd {a}\n", material(model, i));
        }
        std::fs::write(&library, text)?;
        let name = library.file_name().unwrap_or_default().to_string_lossy();
        writeln!(out, "mtllib {name}")?;
    }
    let scene = &model.scene;
    // OBJ counts from 1.
    let mut first = 1u64;
    for slot in scene.slots() {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let name = scene.handle(slot).map(|h| model.instance_name(h));
        writeln!(out, "o {}", one_line(&name.unwrap_or_default()))?;
        for &p in mesh.positions() {
            let [x, y, z] = world(transform, p);
            writeln!(out, "v {x} {y} {z}")?;
        }
        let indices = world_indices(scene, slot);
        for part in mesh.parts() {
            if (part.material as usize) < model.materials.len() {
                writeln!(out, "usemtl {}", material(model, part.material as usize))?;
            }
            let range = part.first_triangle as usize * 3..;
            for t in indices[range].chunks_exact(3).take(part.triangle_count as usize) {
                let [a, b, c] = [0, 1, 2].map(|i| first + u64::from(t[i]));
                writeln!(out, "f {a} {b} {c}")?;
            }
        }
        first += mesh.positions().len() as u64;
    }
    Ok(())
}

/// The name of a material, which two might share otherwise.
fn material(model: &Model, index: usize) -> String {
    let name = one_line(&model.materials[index].name);
    let taken = model.materials[..index].iter().any(|m| one_line(&m.name) == name);
    if taken || name.is_empty() { format!("{name}_{index}") } else { name }
}

/// Names end at the line, and in many readers at a space.
fn one_line(name: &str) -> String {
    name.trim().chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}
