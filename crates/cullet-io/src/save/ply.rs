//! Binary PLY.

use std::io::{self, Write};

use super::{Written, attributes, world_indices, world_normals};
use crate::Attributes;
use crate::attributes::{NO_COLOR, NO_UV, srgb_byte};
use crate::place::world;

pub(super) fn write(all: &Written<'_>, out: &mut impl Write) -> io::Result<()> {
    let (model, scene) = (all.model, &all.model.scene);
    let kept: Vec<Attributes> =
        (0..scene.meshes().len()).map(|mesh| attributes(model, mesh)).collect();
    let of = |slot: u32| &kept[scene.mesh_id(slot) as usize];
    let solid = |slot: &u32| !scene.mesh(*slot).positions().is_empty();
    let filled = || all.slots.iter().copied().filter(solid);
    let normals = filled().next().is_some() && filled().all(|s| !of(s).normals.is_empty());
    let uvs = filled().any(|s| !of(s).uvs.is_empty());
    let colors = filled().any(|s| !of(s).colors.is_empty());
    let number = if all.is_far { "double" } else { "float" };
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment written by cullet\nelement vertex {}\n\
         property {number} x\nproperty {number} y\nproperty {number} z\n{}{}{}element face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        all.vertices,
        if normals { "property float nx\nproperty float ny\nproperty float nz\n" } else { "" },
        if uvs { "property float s\nproperty float t\n" } else { "" },
        if colors {
            "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        } else {
            ""
        },
        all.saved.triangles
    )?;
    for &slot in &all.slots {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let kept = of(slot);
        let turned = if normals { world_normals(transform, mesh, kept) } else { Vec::new() };
        for (v, &p) in mesh.positions().iter().enumerate() {
            let place = world(transform, p);
            if all.is_far {
                place.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
            }
            let mut write = |values: &[f32]| -> io::Result<()> {
                values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
            };
            if !all.is_far {
                write(&place.map(|v| v as f32))?;
            }
            if normals {
                write(&turned[v])?;
            }
            if uvs {
                let [s, t] = kept.uvs.get(v).copied().unwrap_or(NO_UV);
                // The first row of an image is at the bottom here.
                write(&[s, 1.0 - t])?;
            }
            if colors {
                let [r, g, b, a] = kept.colors.get(v).copied().unwrap_or(NO_COLOR);
                let alpha = (a * 255.0).round() as u8;
                out.write_all(&[srgb_byte(r), srgb_byte(g), srgb_byte(b), alpha])?;
            }
        }
    }
    let mut first = 0u32;
    for &slot in &all.slots {
        for t in world_indices(scene, slot).chunks_exact(3) {
            out.write_all(&[3])?;
            for &i in t {
                out.write_all(&(first + i).to_le_bytes())?;
            }
        }
        first += scene.mesh(slot).positions().len() as u32;
    }
    Ok(())
}
