//! The program in the README is one that runs: it is compiled here as it stands there.

use std::ops::Range;

/// The lines between `begin` and the end of the first Rust program of the README.
fn program(readme: &str) -> Vec<&str> {
    let lines = readme.lines().skip_while(|l| !l.starts_with("```rust"));
    lines.skip(1).take_while(|l| *l != "```").collect()
}

/// The same program, line by line.
#[rustfmt::skip]
fn run(
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    mut draw_indexed: impl FnMut(u32, Range<u32>, u32),
) -> Result<(), Box<dyn std::error::Error>> {
    // begin
    use cullet::*;

    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(MeshData { positions, indices, ..MeshData::default() })?);
    for x in 0..1000 {
        scene.add(Instance::new(mesh, Transform::from_translation([x as f64 * 4.0, 0.0, -20.0])))?;
    }
    let (culler, mut state, mut visible) = (Culler::default(), ViewState::default(), Visible::default());
    scene.commit(&culler);

    // Each frame:
    let projection = Projection::Perspective { fov_y_radians: 0.9, aspect: 1.6, near: 0.1, far: 500.0 };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    let view = View::new(&camera, Depth::Reversed, [1280, 720])?;
    culler.cull_one(&scene, &view, &mut state, &mut visible);
    for draw in visible.draws(&scene)? {
        draw_indexed(draw.mesh, draw.indices, draw.slot);
    }
    // end
    Ok(())
}

#[test]
fn the_readmes_program_runs_and_draws_what_is_before_the_eye() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md");
    let readme = std::fs::read_to_string(path).expect("the README lies at the root");
    let own = include_str!("readme.rs").lines().map(|l| l.strip_prefix("    ").unwrap_or(l));
    let own: Vec<_> =
        own.skip_while(|l| *l != "// begin").skip(1).take_while(|l| *l != "// end").collect();
    assert_eq!(program(&readme), own);

    let corners = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    let mut drawn = Vec::new();
    let draw = |mesh, indices, slot| {
        assert_eq!((mesh, indices), (0, 0..12));
        drawn.push(slot);
    };
    run(corners, vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], draw).expect("a program that runs");
    assert!((3..10).contains(&drawn.len()), "{drawn:?}");
}
