//! Shapes that are cut, that move, and that are drawn in place of others.

use std::error::Error;

use cullet::bounds::{Aabb, Plane};
use cullet::cull::detail::Detail;
use cullet::lod::{LevelEye, Lod, PixelScale};
use cullet::view::EyeBall;
use cullet::{Culler, Handle, Instance, Scene, Stage, Transform, View, ViewState, Visible};
use cullet_cut::{CapOptions, CutInput, CutMesh, CutOptions, Keep, cut, cut_mesh};
use cullet_io::deform::{JointBoxes, MorphBounds, Morphs, Skin};
use cullet_mesh::Impostor;
use cullet_testkit::steps::Balls;
use cullet_testkit::{meshes, soups};

use crate::{Computed, Entry, end_of, number};

pub(crate) const ENTRIES: &[Entry] = &[
    ("merged-1", bound_of_a_level),
    ("merged-2", drawn_as_themselves),
    ("popping-1", share_of_pixels),
    ("popping-2", next_ball),
    ("impostors-1", bytes_of_shape),
    ("impostors-2", radius_of_an_impostor),
    ("cutting-1", volume_of_a_half),
    ("cutting-2", cap_of_two),
    ("moving-1", bounds_of_joints),
    ("moving-2", bounds_of_a_morph),
];

/// The third bound is four times the first, which the chapter states.
fn bound_of_a_level() -> Computed {
    let bound = 200.0 / 800.0 * 2.0 * 2.0;
    let fov = 60_f64.to_radians();
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], fov, 0.1, 1e5, [1280, 720])?;
    let scale = PixelScale::of(&view, false);
    let eye = LevelEye::new(&Lod::default(), &scale, &Transform::IDENTITY, None);
    let over = |distance: f64| eye.allowed([0.0, 0.0, -distance as f32], 0.0) < bound;
    number(end_of(1.0, 1e4, over))
}

/// Eight balls in a row, and a ninth that stands for them.
fn drawn_as_themselves() -> Computed {
    let mut scene = Scene::new();
    let [house, merged] =
        [&[12, 6, 3][..], &[9, 6, 3]].map(|r| Balls::new(r, 1.0).add_to(&mut scene));
    let place = |i: i32| Transform::from_translation([f64::from(i) * 3.0, 0.0, 0.0]);
    let houses = (0..8).map(|i| scene.add(Instance::new(house, place(i))));
    let houses = houses.collect::<Result<Vec<_>, _>>()?;
    let all = Transform::from_scale_translation([14.0; 3], [10.5, 0.0, 0.0]);
    let group = scene.add(Instance::new(merged, all))?;
    scene.stand_for(group, &houses)?;
    scene.commit(&Culler::default());
    let view =
        View::perspective([10.5, 0.0, 9000.0], [10.5, 0.0, 0.0], 1.0, 1.0, 1e5, [1280, 720])?;
    let culler = Culler::default().with_lod(Lod::default()).only(Stage::Lod);
    let drawn = |scene: &Scene, handles: &[Handle]| -> Result<usize, Box<dyn Error>> {
        let mut visible = Visible::default();
        culler.cull_one(scene, &view, &mut ViewState::default(), &mut visible);
        let slots = handles.iter().map(|&h| scene.slot(h)).collect::<Result<Vec<_>, _>>()?;
        Ok(visible.slots().filter(|slot| slots.contains(slot)).count())
    };
    assert_eq!([drawn(&scene, &houses)?, drawn(&scene, &[group])?], [0, 1], "the group is drawn");
    scene.set_transform(houses[3], place(20))?;
    assert_eq!(drawn(&scene, &[group])?, 0, "it is not drawn beside them");
    number(drawn(&scene, &houses)? as f64)
}

fn share_of_pixels() -> Computed {
    let detail = Detail::default().with_threshold_px(4.0).with_fade(0.5);
    number(detail.weight(Some([3.0, 5.0]), 1.0))
}

fn next_ball() -> Computed {
    let eye = |view: u32| [f64::from(view) * 0.45, 0.0, 0.0];
    let first = EyeBall { centre: eye(0), radius: 2.0 };
    let view = (1..100).find(|&view| first.follow(eye(view), 2.0) != first);
    number(f64::from(view.ok_or("it never is")?))
}

fn bytes_of_shape() -> Computed {
    let size = [8, 16];
    let texels = vec![0; Impostor::texel_count(size)?];
    let place = (Aabb::new([-1.0; 3], [1.0; 3]), 2.0);
    number(size_of_val(Impostor::new(size, place, 0.1, texels.clone(), texels)?.shape()) as f64)
}

/// Computes the radius in pixels of a mesh whose radius is 1, at the least distance at which its
/// impostor's error is within two pixels.
fn radius_of_an_impostor() -> Computed {
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 1e4, [1920, 1080])?;
    let (lod, scale) = (Lod::default().with_pixels(2.0), PixelScale::of(&view, false));
    let eye = LevelEye::new(&lod, &scale, &Transform::IDENTITY, None);
    let over = |distance: f64| eye.allowed([0.0, 0.0, -distance as f32], 0.0) < 0.05;
    number(scale.pixels / end_of(1.0, 1e4, over))
}

/// The volume that closed triangles enclose.
fn volume(of: &CutMesh) -> f64 {
    let corner = |i: u32| of.positions[i as usize].map(f64::from);
    let signed = |t: &[u32]| {
        let [a, b, c] = [t[0], t[1], t[2]].map(corner);
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
    };
    of.indices.chunks_exact(3).map(signed).sum()
}

fn volume_of_a_half() -> Computed {
    let cube = meshes::block([0.0; 3], [2.0; 3]);
    let options = CutOptions { keep: Keep::Outside, caps: Some(CapOptions::default()) };
    let done = cut_mesh(&cube, &[], 0, &[Plane::new([1.0, 0.0, 0.0], 0.5)], &options, 0)?;
    assert_eq!(done.cut.report.open_chains, 0, "it is closed");
    number(volume(&done.cut))
}

fn cap_of_two() -> Computed {
    let (mut positions, mut indices) = soups::block([0.0; 3], [2.0; 3]);
    let (others, own) = soups::block([1.0, 1.0, 0.0], [3.0, 3.0, 2.0]);
    indices.extend(own.iter().map(|i| i + positions.len() as u32));
    positions.extend(others);
    let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
    let plane = Plane::new([0.0, 0.0, 1.0], 1.0);
    let options = CutOptions { caps: Some(CapOptions::default()), ..CutOptions::default() };
    let done = cut(&input, &[plane], &options)?;
    number(done.caps.iter().map(|cap| done.cap_area(cap, &plane)).sum())
}

fn bounds_of_joints() -> Computed {
    let positions = [0.0, 1.0, 2.0, 3.0].map(|x| [x, 0.0, 0.0]);
    let joints = [[0; 4], [0; 4], [1, 0, 0, 0], [1, 0, 0, 0]];
    let (weights, inverse_binds) = ([[1.0, 0.0, 0.0, 0.0]; 4], [Transform::IDENTITY; 2]);
    let skin = Skin {
        positions: &positions,
        joints: &joints,
        weights: &weights,
        inverse_binds: &inverse_binds,
    };
    let moved = [Transform::from_translation([4.0, 0.0, 0.0]), Transform::IDENTITY];
    let bounds = JointBoxes::new(&skin)?.bounds(&moved, [0.0; 3]);
    number(f64::from(bounds.max[0] - bounds.min[0]))
}

fn bounds_of_a_morph() -> Computed {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0]];
    let target = [[2.0, 0.0, 0.0], [0.0; 3]];
    let morphs = Morphs { positions: &positions, targets: &[&target] };
    number(f64::from(MorphBounds::new(&morphs)?.bounds(&[-0.5]).min[0]))
}
