//! Zhang & Hoff, *Fast Backface Culling Using Normal Masks* (1997): Table 1 and Graph 1 on this device, with its own back-face
//! culling on in every row; and what tests and triangles cost here.
//!
//! `cargo xtask bench-gpu masks [DIR]`, which writes `masks.json`, `masks-MODEL.svg` and `costs.json` into DIR. `CULLET_DATA` names a
//! folder with the bunny and the armadillo, which are left out where they are not there.

mod costs;
mod graph;
mod pair;
mod table;
mod timing;

use std::path::{Path, PathBuf};

use cullet::mesh::{MeshData, Part};
use cullet_gpu::{Gpu, GpuError, Tier, wait};
use cullet_scenes::knobbly_ball;
use serde_json::json;
use wgpu::{DeviceType, Features};

pub(crate) type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let wanted = Features::TIMESTAMP_QUERY | Features::INDIRECT_FIRST_INSTANCE;
    let gpu = match wait(Gpu::request(Tier::Pyramid, wanted, None)) {
        Ok(gpu) => gpu,
        Err(why @ GpuError::NoAdapter { .. }) => {
            println!("not measured: {why}");
            return Ok(());
        }
        Err(why) => return Err(why.into()),
    };
    let info = gpu.adapter.get_info();
    let kind = match info.device_type {
        DeviceType::Cpu => "a software device: the CPU draws",
        _ => "a graphics card",
    };
    let device = format!("{} ({:?}), {kind}", info.name, info.backend);
    println!("{device}");
    let out = std::env::args().skip(1).skip_while(|a| a != "--out").nth(1).map(PathBuf::from);
    if let Some(out) = &out {
        std::fs::create_dir_all(out)?;
    }
    let costs = costs::measure(&gpu)?;
    costs.print();
    let mut models = Vec::new();
    for (name, soup) in subjects()? {
        let found = table::measure(&gpu, name, one_sided(soup))?;
        found.print(costs.t_over_r());
        if let Some(out) = &out {
            std::fs::write(out.join(format!("masks-{name}.svg")), graph::svg(&found, &device))?;
        }
        models.push(found.json());
    }
    if let Some(out) = &out {
        let all = json!({"schema": 1, "device": device, "models": models});
        std::fs::write(out.join("masks.json"), serde_json::to_string_pretty(&all)? + "\n")?;
        let stored = serde_json::to_string_pretty(&costs.json(&device))?;
        std::fs::write(out.join("costs.json"), stored + "\n")?;
    }
    Ok(())
}

type Soup = (Vec<[f32; 3]>, Vec<u32>);

/// The paper's own model, another scanned one, and one that is always there.
fn subjects() -> Result<Vec<(&'static str, Soup)>, Failure> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let folder = PathBuf::from(std::env::var_os("CULLET_DATA").unwrap_or_else(beside));
    let mut found = Vec::new();
    for (name, file) in
        [("bunny", "stanford-bunny/bun_zipper.ply"), ("armadillo", "armadillo/armadillo.obj")]
    {
        match folder.join(file) {
            path if path.exists() => found.push((name, read_soup(&path)?)),
            _ => println!("{name}: CULLET_DATA names no folder with it"),
        }
    }
    found.push(("ball", knobbly_ball(76)));
    Ok(found)
}

fn read_soup(path: &Path) -> Result<Soup, Failure> {
    let model = cullet_maps::load(path, &Default::default())?;
    let mesh = model.scene.meshes().first().ok_or("a file without a mesh")?;
    Ok((mesh.positions().to_vec(), mesh.original_indices()))
}

fn one_sided((positions, indices): Soup) -> MeshData {
    let part = Part { triangle_count: (indices.len() / 3) as u32, ..Part::default() };
    MeshData { positions, indices, parts: vec![part], ..MeshData::default() }
}
