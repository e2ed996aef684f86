//! The culler in a renderer of one's own: a static scene, movers, levels of detail, occlusion, cascaded shadows,
//! indirect draws. Calls of the graphics interface stand as comments where they belong; all else runs.
//! `cargo run --example renderer -p cullet`; the book's chapter *Put it into your renderer* goes through it.

use cullet::costs::Costs;
use cullet::cull::shadow::Light;
use cullet::lod::Lod;
use cullet::mesh::Part;
use cullet::{
    Culler, Depth, DrawList, Instance, InstanceFlags, Mesh, MeshData, Scene, ShadowView, Transform,
    View, ViewState, Visible, draw::MeshPlace,
};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const SCREEN: [u32; 2] = [1280, 720];

fn main() -> Result<()> {
    // Loading: each mesh once, with its coarser levels and how far they are off at the most.
    let mut scene = Scene::new();
    let pillar = scene.add_mesh(prism(32)?);
    for (sides, error) in [(16, 0.02), (6, 0.14)] {
        let coarse = scene.add_mesh(prism(sides)?);
        scene.add_lod(pillar, coarse, error)?;
    }
    let wall = scene.add_mesh(prism(4)?);
    // `places` says where each mesh lies in the renderer's buffers. Triangles are permuted into clusters:
    // upload `indices()`, or keep your own order with `Clustering::in_order`.
    let (mut places, mut next) = (Vec::new(), MeshPlace::default());
    for mesh in scene.meshes() {
        // queue.write_buffer(&vertices, next.base_vertex, mesh.positions());
        // queue.write_buffer(&indices, next.first_index, mesh.indices());
        places.push(next);
        next.first_index += mesh.indices().len() as u32;
        next.base_vertex += mesh.positions().len() as i32;
    }
    for i in 0..2000_u32 {
        let at = [f64::from(i % 50) * 4.0 - 100.0, 0.0, f64::from(i / 50) * -4.0];
        scene.add(Instance {
            user_data: u64::from(i),
            ..Instance::new(pillar, Transform::from_translation(at))
        })?;
    }
    let hides = Transform::from_scale_translation([30.0, 4.0, 0.5], [0.0, 0.0, -20.0]);
    scene.add(Instance::new(wall, hides))?;
    let flags = InstanceFlags { dynamic: true, ..InstanceFlags::default() };
    let mut movers = Vec::new();
    for i in 0..50 {
        let at = Transform::from_translation([f64::from(i), 5.0, -10.0]);
        movers.push(scene.add(Instance { flags, ..Instance::new(pillar, at) })?);
    }
    // What a draw and a triangle cost decides how far occlusion pays: give your renderer's.
    let costs = Costs { draw_ns: 2000.0, ..Costs::default() };
    let culler = Culler::default().with_lod(Lod::default()).with_costs(costs);
    scene.commit(&culler);
    upload_transforms(&scene);

    // One state for each view, as long as the view lives; results and lists are used again.
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let splits = [0.1, 15.0, 50.0, 200.0];
    let mut states: [ViewState; 3] = Default::default();
    let mut casters: [Visible; 3] = Default::default();
    let mut list = DrawList::default();
    for frame in 0..4 {
        // What moved. `refit` makes the hierarchy fit again: without it answers are right, but slower to find.
        for (i, &mover) in movers.iter().enumerate() {
            let at = [i as f64, 5.0 + f64::from(frame), -10.0];
            scene.set_transform(mover, Transform::from_translation(at))?;
        }
        scene.refit();
        for [_from, _to] in scene.commit_slice() {
            // encoder.copy_buffer_to_buffer(&transforms, from, &transforms, to, 64);
        }
        // The camera: your own matrix, world to clip space in f64, column-major, depth 0..1 (`from_gl_matrix`: −1..1).
        let camera = clip_from_world([f64::from(frame), 2.0, 20.0]);
        let view = View::from_matrix(camera, Depth::Reversed, SCREEN)?;
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        list.fill(&scene, &visible, &places)?;
        draw("camera", &list);
        // Shadows: what casts one on something that is visible, for each cascade.
        let sun = Light::Directional { direction: [0.3, -1.0, 0.2] };
        let cascades = ShadowView::cascades(&view, sun, &splits)?;
        let cascades = cascades.into_iter().map(|slice| slice.receiving(&scene, &visible));
        let cascades = cascades.collect::<std::result::Result<Vec<_>, _>>()?;
        culler.cull_shadows(&scene, &cascades, &mut states, &mut casters)?;
        for casters in &casters {
            list.fill(&scene, casters, &places)?;
            draw("  cascade", &list);
        }
    }
    Ok(())
}

/// One indirect draw for each command; a vertex shader finds its instance's slot in `instances`.
fn draw(pass: &str, list: &DrawList) {
    // queue.write_buffer(&indirect, 0, bytemuck::cast_slice(&list.commands));
    // queue.write_buffer(&instances, 0, bytemuck::cast_slice(&list.instances));
    // for run in list.keys.chunk_by(|a, b| a.state == b.state && a.material == b.material) {
    //     pass.set_pipeline(pipeline of run[0].state); pass.set_bind_group(material of run[0].material);
    //     pass.multi_draw_indexed_indirect(&indirect, offset of run, run.len());
    // }
    let instances: u32 = list.commands.iter().map(|c| c.instance_count).sum();
    let indices: u64 =
        list.commands.iter().map(|c| u64::from(c.index_count) * u64::from(c.instance_count)).sum();
    println!(
        "{pass}: {} draws, {instances} instances, {} triangles",
        list.commands.len(),
        indices / 3
    );
}

/// One matrix for each slot.
fn upload_transforms(scene: &Scene) {
    for slot in scene.slots() {
        let _matrix = scene.transform(slot).to_matrix();
        // queue.write_buffer(&transforms, slot * 64, matrix);
    }
}

/// A perspective matrix without a far plane, reversed depth, looking down −Z from `eye`.
fn clip_from_world(eye: [f64; 3]) -> [f64; 16] {
    let (scale, near) = (1.0 / 0.45_f64.tan(), 0.1);
    let aspect = f64::from(SCREEN[0]) / f64::from(SCREEN[1]);
    let [x, y, z] = eye;
    let [sx, sy] = [scale / aspect, scale];
    [sx, 0.0, 0.0, 0.0, 0.0, sy, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, -x * sx, -y * sy, near, z]
}

/// An upright prism, in place of what a loader reads.
fn prism(sides: u32) -> Result<Mesh> {
    let ring = |y: f32| {
        (0..sides).map(move |i| {
            let (sin, cos) = (std::f32::consts::TAU * i as f32 / sides as f32).sin_cos();
            [cos, y, sin]
        })
    };
    let positions: Vec<[f32; 3]> = ring(-1.0).chain(ring(4.0)).collect();
    let quad = |i: u32| {
        let [a, b] = [i, (i + 1) % sides];
        [a, a + sides, b, b, a + sides, b + sides]
    };
    let cap = |i: u32| [0, i, i + 1, sides, sides + i + 1, sides + i];
    let indices: Vec<u32> = (0..sides).flat_map(quad).chain((1..sides - 1).flat_map(cap)).collect();
    // One-sided, so that back faces are culled.
    let parts = vec![Part { triangle_count: indices.len() as u32 / 3, ..Part::default() }];
    Ok(Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() })?)
}
