//! OBJ, and its MTL.

use std::io::{self, Write};
use std::path::Path;

use super::{Written, attributes, world_indices, world_normals};
use crate::Model;
use crate::attributes::srgb_byte;
use crate::place::world;

pub(super) fn write(all: &Written<'_>, path: &Path, out: &mut impl Write) -> io::Result<()> {
    let model = all.model;
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
    let (mut first, mut first_uv, mut first_normal) = (1u64, 1u64, 1u64);
    for &slot in &all.slots {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let name = scene.handle(slot).map(|h| model.instance_name(h));
        writeln!(out, "o {}", one_line(&name.unwrap_or_default()))?;
        let kept = attributes(model, scene.mesh_id(slot) as usize);
        for (v, &p) in mesh.positions().iter().enumerate() {
            write!(out, "v")?;
            for (a, v) in world(transform, p).into_iter().enumerate() {
                let own: f64 = (0..3)
                    .map(|c| (f64::from(transform.linear[c][a]) * f64::from(p[c])).abs())
                    .sum();
                // Digits of f32 say as much as the vertex does, unless it is far from zero for its
                // mesh.
                match v.abs() <= own * 2.0 {
                    true => write!(out, " {}", v as f32)?,
                    false => write!(out, " {v}")?,
                }
            }
            // Colours of the screen behind positions, as most programs have them; there is no
            // alpha.
            if let Some(c) = kept.colors.get(v) {
                let [r, g, b] = [0, 1, 2].map(|i| f32::from(srgb_byte(c[i])) / 255.0);
                write!(out, " {r} {g} {b}")?;
            }
            writeln!(out)?;
        }
        for [s, t] in &kept.uvs {
            // The first row of an image is at the bottom here.
            writeln!(out, "vt {s} {}", 1.0 - t)?;
        }
        for [x, y, z] in world_normals(transform, mesh, &kept) {
            writeln!(out, "vn {x} {y} {z}")?;
        }
        let corner = |v: u64| match (kept.uvs.is_empty(), kept.normals.is_empty()) {
            (true, true) => format!("{}", first + v),
            (false, true) => format!("{}/{}", first + v, first_uv + v),
            (true, false) => format!("{}//{}", first + v, first_normal + v),
            (false, false) => format!("{}/{}/{}", first + v, first_uv + v, first_normal + v),
        };
        let indices = world_indices(scene, slot);
        for part in mesh.parts() {
            if (part.material as usize) < model.materials.len() {
                writeln!(out, "usemtl {}", material(model, part.material as usize))?;
            }
            let range = part.first_triangle as usize * 3..;
            for t in indices[range].chunks_exact(3).take(part.triangle_count as usize) {
                let [a, b, c] = [0, 1, 2].map(|i| corner(t[i].into()));
                writeln!(out, "f {a} {b} {c}")?;
            }
        }
        first += mesh.positions().len() as u64;
        first_uv += kept.uvs.len() as u64;
        first_normal += kept.normals.len() as u64;
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
