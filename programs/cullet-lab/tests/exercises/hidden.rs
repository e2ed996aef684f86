//! Exercises on what lies behind doors and walls, what casts a shadow, and what is known of cells
//! beforehand.

use cullet::bounds::{Aabb, Side};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, ScreenBounds, Visibility};
use cullet::cull::shadow::Light;
use cullet::{
    Camera, Culler, Depth, Instance, Projection, Scene, ShadowView, Simd, Transform, View,
    ViewState, Visible,
};
use cullet_bake::pvs::{PairState, PvsSettings, bake};
use cullet_cells::cell::{CellGraph, Portal};
use cullet_cells::portal::{PortalOptions, PortalView, Reached, walk_portals};
use cullet_draw::clip::{HalfSpace, Region, line};
use cullet_testkit::meshes;

use crate::{Computed, Entry, end_of, number};

pub(crate) const ENTRIES: &[Entry] = &[
    ("portals-1", through_a_door),
    ("portals-2", through_two_doors),
    ("portals-3", beside_two_doors),
    ("occlusion-1", hidden_region),
    ("occlusion-2", box_behind_a_wall),
    ("occlusion-3", gap_in_a_pixel),
    ("shadows-1", shadow_of_a_point),
    ("shadows-2", shadow_of_a_bird),
    ("pvs-1", bytes_of_a_row),
    ("pvs-2", four_rooms),
];

type Walked = Result<Reached, Box<dyn std::error::Error>>;

/// The cells that are seen through both doors: the room of the eye, that down to z = −20, and the
/// one beyond.
fn walked() -> Walked {
    // Counter-clockwise as seen from the eye.
    let door = |[left, right]: [f64; 2], z: f64| {
        vec![[left, -1.0, z], [right, -1.0, z], [right, 1.0, z], [left, 1.0, z]]
    };
    let portals = vec![
        Portal { cells: [0, 1], polygon: door([-1.0, 1.0], -5.0) },
        Portal { cells: [1, 2], polygon: door([3.0, 6.0], -20.0) },
    ];
    let graph = CellGraph::new(3, portals)?;
    let fov = std::f64::consts::FRAC_PI_2;
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], fov, 0.1, 100.0, [1280, 720])?;
    let view = PortalView::new(&view).ok_or("no eye")?;
    let mut reached = Reached::default();
    walk_portals(&graph, &view, &[0], &PortalOptions::default(), &mut reached);
    let cells: Vec<u32> = reached.visits().iter().map(|visit| visit.cell).collect();
    assert_eq!(cells, [0, 1, 2]);
    Ok(reached)
}

/// From where to where a cell is seen along x, in the middle of the far wall.
fn seen_of_the_wall(reached: &Reached, cell: u32) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let visit = reached.visits().iter().find(|visit| visit.cell == cell).ok_or("not reached")?;
    // The eye, which they are relative to, is in the origin.
    let planes = reached.planes(visit).map(|plane| HalfSpace::new(plane.normal, plane.d));
    let region = Region::new(planes.collect::<Result<Vec<_>, _>>()?)?;
    let (from, to) = ([-100.0, 0.0, -20.0], [100.0, 0.0, -20.0]);
    let ends = region.clip_line(&from, &to).ok_or("nothing is seen")?;
    Ok(ends.map(|t| line::at(&from, &to, t)[0]))
}

fn through_a_door() -> Computed {
    let [left, right] = seen_of_the_wall(&walked()?, 1)?;
    number(right - left)
}

fn through_two_doors() -> Computed {
    let [left, right] = seen_of_the_wall(&walked()?, 2)?;
    number(right - left)
}

fn beside_two_doors() -> Computed {
    let reached = walked()?;
    let visit = reached.visits().iter().find(|visit| visit.cell == 2).ok_or("not reached")?;
    let frustum = reached.frustum(visit, [0.0; 3], 100.0);
    let side = |low: f32| {
        let b = Aabb::new([low, -0.5, -41.0], [low + 1.0, 0.5, -40.0]);
        Planes::new(&frustum).classify_box(&b)
    };
    assert_ne!(side(7.0), Side::Outside, "one between 6 and 8 is seen");
    Ok(if side(9.0) == Side::Outside { "dropped" } else { "seen" }.to_owned())
}

/// The wall in a buffer as fine as there is, of a view 51 m wide and 10 m high at a distance of 50
/// m.
fn behind_the_wall() -> Result<OcclusionBuffer, Box<dyn std::error::Error>> {
    let size = [OcclusionBuffer::LIMIT, 256];
    let fov_y_radians = 2.0 * (5.0_f64 / 50.0).atan();
    let projection =
        Projection::Perspective { fov_y_radians, aspect: 51.0 / 10.0, near: 0.1, far: 1000.0 };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    let mut buffer = OcclusionBuffer::new(size)?;
    buffer.begin(&View::new(&camera, Depth::Reversed, size)?, [0.0; 3]);
    let wall = Convex::from_box(&Aabb::new([-5.0, -2.0, -10.1], [5.0, 2.0, -10.0]))?;
    wall.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    Ok(buffer)
}

/// Where posts without width stop being hidden to either side. A pixel is 12 mm wide there.
fn hidden_region() -> Computed {
    let buffer = behind_the_wall()?;
    let is_hidden = |x: f64| {
        let post = Aabb::new([x as f32, -0.1, -50.0], [x as f32, 0.1, -50.0]);
        buffer.test_box(&post) == Visibility::Hidden
    };
    let [left, right] = [-1.0, 1.0].map(|side| side * end_of(0.0, 25.4, |x| is_hidden(side * x)));
    number(right - left)
}

fn box_behind_a_wall() -> Computed {
    let found = behind_the_wall()?.test_box(&Aabb::new([20.0, 0.0, -54.0], [24.0, 1.0, -50.0]));
    Ok(if found == Visibility::Hidden { "hidden" } else { "kept" }.to_owned())
}

/// A unit of this parallel view is a pixel, and the gap is in the column to the right of the
/// middle.
fn gap_in_a_pixel() -> Computed {
    let (size, column) = ([200, 200], 100);
    let view = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 200.0, 0.1, 100.0, size)?;
    let mut buffer = OcclusionBuffer::new(size)?;
    buffer.begin(&view, [0.0; 3]);
    for [left, right] in [[-90.0, 1.0 / 3.0], [2.0 / 3.0, 90.0]] {
        let wall = Convex::from_box(&Aabb::new([left, -110.0, -11.0], [right, 110.0, -10.0]))?;
        wall.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    // Boxes as far away as the view reaches, each behind one pixel.
    let hidden = |column: u32| {
        let is_hidden = |row: u32| {
            let pixel = [column, row];
            let bounds = ScreenBounds { min: pixel, max: pixel, nearness: 1e-3 };
            buffer.test_bounds(Simd::best(), &bounds) == Visibility::Hidden
        };
        (0..200).filter(|&row| is_hidden(row)).count()
    };
    assert_eq!([column - 1, column + 1].map(hidden), [200; 2], "beside the gap all is covered");
    number(hidden(column) as f64)
}

/// The way that the sun's light goes.
const SUN: [f64; 3] = [0.5, -1.0, 0.0];

/// The ray of light, cut by the ground.
fn shadow_of_a_point() -> Computed {
    let above = HalfSpace::new([0.0, -1.0, 0.0], 0.0)?;
    let from = [0.0, 20.0, 0.0];
    let to = std::array::from_fn(|axis| from[axis] + 100.0 * SUN[axis]);
    let [_, end] = above.clip_line(&from, &to).ok_or("it is below the ground")?;
    number(line::at(&from, &to, end)[0])
}

fn shadow_of_a_bird() -> Computed {
    let mut scene = Scene::new();
    let bird = scene.add_mesh(meshes::block([-0.1; 3], [0.1; 3]));
    // The second one's shadow falls at x = −10.
    let birds = [[-8.0, 20.0, 0.0], [-20.0, 20.0, 0.0]];
    let birds = birds.map(|at| scene.add(Instance::new(bird, Transform::from_translation(at))));
    let ground = scene.add_mesh(meshes::block([-50.0, -0.1, -50.0], [50.0, 0.0, 50.0]));
    scene.add(Instance::new(ground, Transform::IDENTITY))?;
    scene.commit(&Culler::default());
    // From above, onto the ground from 0 to 5.
    let projection = Projection::Orthographic {
        left: -2.5,
        right: 2.5,
        bottom: -2.5,
        top: 2.5,
        near: 0.1,
        far: 6.0,
    };
    let (direction, up) = ([0.0, -1.0, 0.0], [0.0, 0.0, -1.0]);
    let camera = Camera { eye: [2.5, 5.0, 0.0], direction, up, projection };
    let view = View::new(&camera, Depth::Reversed, [100, 100])?;
    let light = Light::Directional { direction: SUN };
    let receivers = Some(Aabb::new([0.0, -0.1, -2.5], [5.0, 0.0, 2.5]));
    let shadows = ShadowView { receivers, ..ShadowView::new(view.clone(), light) };
    let (culler, [mut seen, mut casters]) =
        (Culler::default(), [(); 2].map(|()| Visible::default()));
    culler.cull_one(&scene, &view, &mut ViewState::default(), &mut seen);
    culler.cull_shadow(&scene, &shadows, &mut ViewState::default(), &mut casters);
    let [first, second] = birds;
    let [first, second] = [scene.slot(first?)?, scene.slot(second?)?];
    let is_in = |visible: &Visible, slot: u32| visible.slots().any(|s| s == slot);
    assert!(!is_in(&seen, first), "it is outside the view");
    assert!(!is_in(&casters, second), "whose shadow nobody sees is dropped");
    Ok(if is_in(&casters, first) { "kept" } else { "dropped" }.to_owned())
}

/// The engine's own sets are shorter than plain rows, so that none of its functions has their size.
fn bytes_of_a_row() -> Computed {
    number(f64::from(1500_u32.div_ceil(8)))
}

fn four_rooms() -> Computed {
    let door = |cells, x: f64, y: f64| Portal {
        cells,
        polygon: vec![[x, y, 0.0], [x, y, 2.0], [x, y + 1.0, 2.0], [x, y + 1.0, 0.0]],
    };
    let doors = vec![door([0, 1], 0.0, 0.0), door([1, 2], 4.0, 0.0), door([2, 3], 8.0, 3.0)];
    let pvs = bake(&CellGraph::new(4, doors)?, &PvsSettings::default(), 1);
    assert_eq!(pvs.state(0, 2), PairState::Visible);
    Ok(if pvs.sets().sees(0, 3) { "visible" } else { "hidden" }.to_owned())
}
