//! Exercises on what occluders, queries, sets of scenes and the device's pyramid call hidden.

use std::error::Error;

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, ScreenBounds, Visibility};
use cullet::{Instance, Mesh, Scene, Simd, Transform, View};
use cullet_bake::occluders::{OccluderOptions, OccluderPolygon, Occluders, occluders};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledBake, SampledSettings, ScenePvs, ViewCells,
};
use cullet_cells::query::{
    BoxSight, EyeBox, RegionCuller, RegionState, RegionVisible, SightOptions, VolumeOptions,
    box_to_box, line_of_sight,
};
use cullet_testkit::{meshes, soups};

use crate::{Computed, Entry, end_of, number};

pub(crate) const ENTRIES: &[Entry] = &[
    ("occluders-1", room_turned_inside_out),
    ("occluders-2", height_above_a_slope),
    ("gpu-1", texels_of_a_level),
    ("gpu-2", texel_of_four),
    ("queries-1", through_a_back),
    ("queries-2", house_on_the_ground),
    ("region-1", width_of_a_smaller_body),
    ("region-2", cells_for_a_wall),
    ("pvs-scene-1", bytes_of_rows),
    ("pvs-scene-2", largest_angle),
];

fn room_turned_inside_out() -> Computed {
    let (positions, mut indices) = soups::block([0.0; 3], [4.0, 3.0, 5.0]);
    indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    let options = OccluderOptions { directions: 0, ..OccluderOptions::default() };
    let of =
        |mesh: &Mesh| -> Result<Occluders, Box<dyn Error>> { Ok(occluders(mesh, &options)?.0) };
    let soup = (positions, indices);
    let two_sided = of(&meshes::of_parts(soup.clone(), Vec::new()))?;
    assert!(!two_sided.boxes.is_empty(), "what is drawn from both sides has a box");
    let one_sided = of(&meshes::one_sided(soup))?;
    Ok(if one_sided.boxes.is_empty() { "no" } else { "yes" }.to_owned())
}

fn height_above_a_slope() -> Computed {
    let points = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
    let points = points.map(|p: [f32; 3]| p.map(|v| v * 1e-3)).to_vec();
    let polygon = OccluderPolygon { points, two_sided: true, tolerance: 1e-5 };
    let from = |height: f64| {
        let along = (32.0 * 32.0 - height * height).sqrt();
        polygon.holds_from([along, height, 0.0, 1.0])
    };
    number(end_of(0.0, 10.0, |height| !from(height)))
}

/// The passes need a device; a pixel's texel is what the chapter says.
fn texels_of_a_level() -> Computed {
    let level = 3;
    let texels = [447_u32, 319].map(|size| ((size - 1) >> (level + 1)) + 1);
    number(f64::from(texels[0] * texels[1]))
}

/// Four walls, each over a quarter of the picture. With a near plane at 1 that is reversed and
/// endless the depth is 1 over the distance, which is how the engine counts too.
fn texel_of_four() -> Computed {
    let (size, right_angle) = ([64, 64], std::f64::consts::FRAC_PI_2);
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], right_angle, 0.1, 1000.0, size)?;
    let mut buffer = OcclusionBuffer::new(size)?;
    buffer.begin(&view, [0.0; 3]);
    let quarters = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0_f32]];
    for (depth, side) in [0.5, 0.2, 0.9, 0.3_f32].into_iter().zip(quarters) {
        // To a little beyond the middle, so that the pixels there are covered.
        let (far, ends) = (1.0 / depth, side.map(|s| [-0.02 * s, 1.2 * s].map(|v| v / depth)));
        let [low, high] = [f32::min, f32::max].map(|of| ends.map(|[a, b]| of(a, b)));
        let wall = Aabb::new([low[0], low[1], -far - 1e-3], [high[0], high[1], -far]);
        Convex::from_box(&wall)?.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    let is_hidden = |nearness: f32| {
        let bounds = ScreenBounds { min: [0, 0], max: [63, 63], nearness };
        buffer.test_bounds(Simd::best(), &bounds) == Visibility::Hidden
    };
    assert!(is_hidden(0.19), "all of it is covered");
    Ok(if is_hidden(0.25) { "hidden" } else { "kept" }.to_owned())
}

fn through_a_back() -> Computed {
    // Its front is towards +x.
    let corners = [[0.0, -5.0, -5.0], [0.0, 5.0, -5.0], [0.0, 5.0, 5.0], [0.0, -5.0, 5.0]];
    let mut scene = Scene::new();
    let wall = scene.add_mesh(meshes::one_sided((corners.to_vec(), vec![0, 1, 2, 0, 2, 3])));
    scene.add(Instance::new(wall, Transform::IDENTITY))?;
    scene.commit(&cullet::Culler::default());
    let (guard, thief) = ([5.0, 0.5, 0.25], [-5.0, 0.5, 0.25]);
    let blocked = |from, to| line_of_sight(&scene, from, to, &SightOptions::default()).is_blocked();
    assert!(blocked(guard, thief), "the guard looks at its front");
    Ok(if blocked(thief, guard) { "blocked" } else { "clear" }.to_owned())
}

fn house_on_the_ground() -> Computed {
    let sight = |ground: f32| -> Result<BoxSight, Box<dyn Error>> {
        let mut scene = Scene::new();
        let house = scene.add_mesh(meshes::block([-5.0, ground, -50.0], [5.0, 30.0, 50.0]));
        scene.add(Instance::new(house, Transform::IDENTITY))?;
        scene.commit(&cullet::Culler::default());
        let [from, to] =
            [-19.0, 19.0].map(|x| Aabb::new([x - 1.0, 0.0, -1.0], [x + 1.0, 2.0, 1.0]));
        Ok(box_to_box(&scene, &from, &to, &VolumeOptions::default()))
    };
    assert!(matches!(sight(-1.0)?, BoxSight::Hidden(_)), "one that reaches into the ground hides");
    Ok(if sight(0.0)? == BoxSight::Visible { "visible" } else { "hidden" }.to_owned())
}

/// The slots that may be seen from a box of eyes.
fn seen(
    scene: &Scene,
    culler: &RegionCuller,
    half: [f64; 3],
) -> Result<RegionVisible, Box<dyn Error>> {
    let eyes = EyeBox::new(half.map(|v| -v), half);
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    culler.cull(scene, &eyes, &mut state, &mut visible)?;
    Ok(visible)
}

/// Posts in a row, 50 m away, and whether each is hidden. What the body that is drawn hides there
/// is five times as wide as its front, which is 10 m away.
fn width_of_a_smaller_body() -> Computed {
    const POSTS: i32 = 500;
    let place = |post: i32| f64::from(post) * 0.02 + 15.0;
    let mut scene = Scene::new();
    let house = scene.add_mesh(meshes::block([-5.0, -3.0, -17.5], [5.0, 3.0, -9.5]));
    scene.add(Instance::new(house, Transform::IDENTITY))?;
    let post = scene.add_mesh(meshes::block([-1e-3; 3], [1e-3; 3]));
    let at = |post| Transform::from_translation([place(post), 0.0, -50.0]);
    let posts = (0..POSTS).map(|number| scene.add(Instance::new(post, at(number))));
    let posts = posts.collect::<Result<Vec<_>, _>>()?;
    scene.commit(&cullet::Culler::default());
    let culler = RegionCuller { width: 2048, ..RegionCuller::default() };
    let visible = seen(&scene, &culler, [1.0, 0.2, 0.5])?;
    assert_eq!(visible.work.cells, 1);
    let mut slots = Vec::new();
    for handle in posts {
        slots.push(scene.slot(handle)?);
    }
    let first = slots.iter().position(|&slot| visible.has(slot)).ok_or("all are hidden")?;
    assert!(slots[first..].iter().all(|&slot| visible.has(slot)), "beside the house all are seen");
    number(2.0 * place(first as i32) * 10.0 / 50.0)
}

fn cells_for_a_wall() -> Computed {
    let mut scene = Scene::new();
    let wall = scene.add_mesh(meshes::block([-200.0, -100.0, -11.0], [200.0, 100.0, -10.0]));
    scene.add(Instance::new(wall, Transform::IDENTITY))?;
    let behind = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
    let place = Transform::from_translation([0.0, 0.0, -30.0]);
    let behind = scene.add(Instance::new(behind, place))?;
    scene.commit(&cullet::Culler::default());
    let mut hiding = Vec::new();
    for word in ["2", "1.5", "0.8"] {
        let culler = RegionCuller { cell_world: word.parse()?, ..RegionCuller::default() };
        // A box whose cells are as long as the setting.
        let half = [culler.cell_world, 0.2, culler.cell_world];
        if !seen(&scene, &culler, half)?.has(scene.slot(behind)?) {
            hiding.push(word);
        }
    }
    match hiding[..] {
        [only] => Ok(only.to_owned()),
        _ => Err(format!("{hiding:?} hide it").into()),
    }
}

/// Sets as they are before a line is drawn: with what the settings keep.
fn without_lines(
    scene: &Scene,
    cells: &ViewCells,
    settings: &SampledSettings,
) -> Result<ScenePvs, Box<dyn Error>> {
    let tree = RayTree::new(scene, &RayTreeOptions::default())?;
    Ok(SampledBake::new(&tree, cells, settings)?.finish())
}

fn bytes_of_rows() -> Computed {
    let mut scene = Scene::new();
    let stone = scene.add_mesh(meshes::block([-0.1; 3], [0.1; 3]));
    for i in 0..100 {
        let place = [f64::from(i % 10), 0.0, f64::from(i / 10)];
        scene.add(Instance::new(stone, Transform::from_translation(place)))?;
    }
    scene.commit(&cullet::Culler::default());
    let cells = ViewCells::grid([[0.0, 1.0, 0.0], [40.0, 2.0, 10.0]], [40, 1, 1])?;
    number(without_lines(&scene, &cells, &SampledSettings::default())?.rows_bytes().len() as f64)
}

fn largest_angle() -> Computed {
    let half = 1.0 / 3.0_f32.sqrt();
    let mut scene = Scene::new();
    let block = scene.add_mesh(meshes::block([-half; 3], [half; 3]));
    scene.add(Instance::new(block, Transform::from_translation([10.0, 0.0, 0.0])))?;
    scene.commit(&cullet::Culler::default());
    let cells = ViewCells::grid([[-5.0, -1.0, -1.0], [0.0, 1.0, 1.0]], [1, 1, 1])?;
    let is_kept = |degrees: f64| {
        let settings = SampledSettings::default().with_keep_angle(degrees.to_radians());
        let sets = without_lines(&scene, &cells, &settings).expect("a bake of one cell");
        sets.visible_pairs() == 1
    };
    number(end_of(1.0, 90.0, is_kept))
}
