//! Culling on the device in a program of one's own, with its device, its encoder and its textures.
//!
//! `cargo run --release -p cullet-gpu --example own_program`

use cullet::mesh::MeshData;
use cullet::{Instance, Mesh, Scene, Transform, View};
use cullet_gpu::{Culling, Gpu, IdPass, IdTarget, Passes, Phase, Pyramid, Tier};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A wall, four hundred things behind it, and one before it.
    let quad = MeshData {
        positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..MeshData::default()
    };
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(quad)?);
    let wall = Transform::from_scale_translation([20.0, 20.0, 1.0], [0.0, 0.0, -10.0]);
    scene.add(Instance::new(mesh, wall))?;
    scene.add(Instance::new(mesh, Transform::from_translation([0.0, 0.0, -5.0])))?;
    for i in 0..400_u32 {
        let at = [f64::from(i % 20) - 10.0, f64::from(i / 20) - 10.0, -20.0];
        scene.add(Instance::new(mesh, Transform::from_translation(at)))?;
    }
    scene.commit(&cullet::Culler::default());
    let size = [640, 360];
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, size)?;

    // The program's own. Of what wgpu finds, one that can read depth in compute passes.
    let gpu = match Gpu::open(Tier::Pyramid) {
        Ok(gpu) => gpu,
        Err(why) => {
            println!("{why}");
            return Ok(());
        }
    };
    let (device, queue) = (&gpu.device, &gpu.queue);
    println!("on {}", gpu.adapter.get_info().name);

    // Once.
    let passes = Passes::new(device)?;
    let mut culling = Culling::new(device, queue, &passes, &scene)?;
    // Its own pipelines would stand here; what they draw into has a depth texture that is reversed.
    let ids = IdPass::new(device)?;
    let target = IdTarget::new(device, &ids, &culling, size)?;
    let pyramid = Pyramid::new(device, &passes.pyramid, target.depth())?;

    for frame in 0..2 {
        // Each frame: numbers first, then everything in one encoder.
        culling.set(queue, &scene, &view, 1)?;
        target.set(queue, &view);
        let mut encoder = device.create_command_encoder(&Default::default());
        culling.record_early(&passes, &mut encoder);
        ids.draw(&mut encoder, &target, (&culling, &view), &[Phase::Early], true);
        culling.record_late(&passes, &mut encoder, &pyramid);
        let rest = [Phase::Late, Phase::Blended];
        ids.draw(&mut encoder, &target, (&culling, &view), &rest, false);
        queue.submit([encoder.finish()]);

        // Only to show what it did: a program that draws needs to read nothing back.
        let bits = gpu.read(culling.visible(), culling.visible().size())?;
        let visible: u32 = bits.iter().map(|byte| byte.count_ones()).sum();
        println!("frame {frame}: {visible} of {} instances are visible", scene.instance_count());
    }
    Ok(())
}
