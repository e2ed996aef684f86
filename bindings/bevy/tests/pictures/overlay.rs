//! The overlay: it is drawn, in the colours of the house, and frozen pictures lack what is beside the frozen view.

use bevy::prelude::*;
use bevy_cullet::{CulletFate, CulletOverlay, CulletOverlayPlugin};

use crate::kit::Kit;
use crate::picture::{Picture, Studio};
use crate::{SIZE, has_device, listed, ours, scenes};

/// Number of pixels of `with`, other than those of `without`, that are nearly of a colour, which tone mapping shifts.
fn drawn(with: &Picture, without: &Picture, color: [u8; 3]) -> usize {
    let is_near = |p: &[u8; 4]| p.iter().zip(color).all(|(&a, b)| a.abs_diff(b) < 60);
    let pixels = with.pixels.iter().zip(&without.pixels);
    pixels.filter(|(a, b)| a != b && is_near(a)).count()
}

fn yard(more: impl FnOnce(&mut App)) -> Studio {
    let mut studio = Studio::new(SIZE, |app| {
        ours(app);
        more(app);
        scenes::plain(&mut Kit::new(app.world_mut()));
    });
    studio.settle();
    studio
}

#[test]
fn the_overlay_draws_bounds_and_text_and_can_be_hidden() {
    if !has_device() {
        return;
    }
    let without = yard(|_| {}).shoot();
    let mut studio = yard(|app| {
        app.add_plugins(CulletOverlayPlugin);
    });
    let occluded = CulletFate::Occluded.color();
    let with = studio.shoot();
    let bounds = drawn(&with, &without, occluded);
    assert!(bounds > 500, "{bounds} pixels of the bounds of what is hidden");
    let mut overlay = studio.world().resource_mut::<CulletOverlay>();
    (overlay.bounds, overlay.text) = (false, false);
    assert_eq!(studio.shoot().differing(&without), 0);
    studio.world().resource_mut::<CulletOverlay>().text = true;
    // Gizmos that are new reach the device a frame later.
    studio.settle();
    let written = studio.shoot().differing(&without);
    assert!((100..5000).contains(&written), "text of {written} pixels");
}

#[test]
fn a_frozen_view_stays_and_lets_go() {
    if !has_device() {
        return;
    }
    let mut studio = yard(|app| {
        app.add_plugins(CulletOverlayPlugin);
    });
    let mut overlay = studio.world().resource_mut::<CulletOverlay>();
    (overlay.bounds, overlay.text, overlay.frozen) = (false, false, true);
    studio.settle();
    let frozen = listed(studio.world());
    let mut cameras = studio.world().query_filtered::<&mut Transform, With<Camera3d>>();
    for mut at in cameras.iter_mut(studio.world()) {
        *at =
            Transform::from_xyz(30.0, 20.0, -10.0).looking_at(Vec3::new(0.0, 0.0, -50.0), Vec3::Y);
    }
    let held = studio.shoot();
    assert_eq!(listed(studio.world()), frozen);
    studio.world().resource_mut::<CulletOverlay>().frozen = false;
    studio.settle();
    let live = studio.shoot();
    assert_ne!(listed(studio.world()), frozen);
    assert!(held.differing(&live) > 1000, "what was hidden from the frozen view is missing");
}

/// The colours are written down twice, for this crate does not depend on the one that draws.
#[test]
fn colours_are_those_of_the_house() {
    let palette = include_str!("../../../../crates/cullet-draw/src/picture/palette.rs");
    for fate in CulletFate::ALL {
        let hex = fate.color().map(|c| format!("0x{c:02X}")).join(", ");
        assert!(palette.contains(&hex), "{}: [{hex}]", fate.label());
    }
}
