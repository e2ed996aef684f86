//! `cullet picture impostor`: a mesh beside its impostor.

use cullet_command::console::{Console, grouped};
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_draw::{ImpostorOptions, Picture, impostor_beside, make_impostor};
use cullet_mesh::Impostor;

use super::PictureArgs;
use cullet_cli::levels;
use cullet_cli::names::mesh_name;

/// Draws the impostor of the largest mesh that has one; where none has, of the largest mesh, with
/// one that is made now.
pub(super) fn draw(args: &PictureArgs, console: &Console) -> Result<Picture, Failure> {
    let model = inputs::load(&args.input.scene, console)?;
    let scene = &model.scene;
    let holders = levels::holders(scene);
    let largest = |with_impostor: bool| {
        let has = |mesh: u32| scene.levels(mesh).iter().any(|l| l.impostor.is_some());
        let all = (0..scene.meshes().len() as u32).filter(|&m| !holders[m as usize]);
        let fit = all.filter(|&m| !with_impostor || has(m));
        fit.max_by_key(|&m| (scene.meshes()[m as usize].triangle_count(), std::cmp::Reverse(m)))
    };
    let Some(number) = largest(true).or_else(|| largest(false)) else {
        return Err(Failure::input(format!("{}: has no mesh", model.name)));
    };
    let mesh = &scene.meshes()[number as usize];
    let failed = |problem: String| {
        Failure::input(format!("{}: mesh {}: {problem}", model.name, mesh_name(&model, number)))
    };
    let baked = scene.levels(number).iter().find_map(Impostor::of);
    let made = match baked {
        Some(_) => None,
        None => {
            let made = make_impostor(mesh, &ImpostorOptions::default());
            Some(made.map_err(|e| failed(e.to_string()))?.0)
        }
    };
    let Some(impostor) = baked.or(made.as_ref()) else {
        return Err(failed("has no impostor".to_owned()));
    };
    let radius = mesh.bounds().half_extent().iter().map(|v| v * v).sum::<f64>().sqrt();
    console.line(format!(
        "{}: {} triangles; {} x {} frames of {} x {} texels, off by {:.4} of the radius{}",
        mesh_name(&model, number),
        grouped(mesh.triangle_count().into()),
        impostor.grid(),
        impostor.grid(),
        impostor.texels(),
        impostor.texels(),
        f64::from(impostor.error()) / radius,
        if baked.is_some() { ", as baked" } else { "" },
    ));
    let colors = inputs::colors(&model);
    impostor_beside(mesh, impostor, &colors).map_err(|e| failed(e.to_string()))
}
