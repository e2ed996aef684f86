//! Clipping before and after projection gives the picture that no clipping gives.

use cullet_draw::{ClipPlace, Frame, RenderOptions, Selection, render_clipped, render_ref};
use cullet_testkit::Rng;
use cullet_testkit::scenes::{city, mixed_scene};
use cullet_testkit::views::{look, mixed_view};

const PLACES: [ClipPlace; 2] = [ClipPlace::World, ClipPlace::Clip];

/// Rounding of depths: a few units of 1e-16 for each corner and each cut.
const DEPTH: f64 = 1e-12;

/// Pixels whose owners differ though one surface is clearly nearer: where the sample is on an edge.
fn on_edges(whole: &Frame, clipped: &Frame) -> usize {
    let owners = whole.ids.iter().zip(&clipped.ids);
    let depths = whole.depth.iter().zip(&clipped.depth);
    owners.zip(depths).filter(|((a, b), (p, q))| a != b && (*p - *q).abs() > DEPTH).count()
}

/// Scenes with surfaces that coincide, views of all kinds, eyes within instances.
#[test]
fn random_scenes_look_the_same_clipped_in_either_place() {
    let (mut cut, mut edges) = ([0; 2], 0);
    for seed in 0..150 {
        let mut rng = Rng(seed);
        let scene = mixed_scene(&mut rng);
        let view = mixed_view(&mut rng, [60, 40]);
        let options = RenderOptions::default();
        let whole = render_ref(&scene, &view, Selection::All, &options);
        for (i, place) in PLACES.into_iter().enumerate() {
            let clipped = render_clipped(&scene, &view, place, &options);
            edges += on_edges(&whole, &clipped);
            let ids = whole.ids.iter().zip(&clipped.ids);
            for ((p, q), (id, other)) in whole.depth.iter().zip(&clipped.depth).zip(ids) {
                assert!(id != other || (p - q).abs() < DEPTH, "seed {seed}, {place:?}: {p} {q}");
            }
            cut[i] += usize::from(clipped.depth != whole.depth);
        }
    }
    // Of 720,000 samples, one lies on an edge to the last bit.
    assert!(edges <= 1, "{edges} samples changed their owner");
    assert!(cut[0] > 40 && cut[1] > 40, "clipping did something in {cut:?} scenes");
}

/// A street seen from within, where nothing coincides: the same owners in every pixel.
#[test]
fn a_city_has_the_same_owners_wherever_it_is_clipped() {
    let scene = city(6, 2, 60);
    let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
    for (eye, target) in
        [([0.3, 1.7, 0.4], [40.0, 6.0, 13.0]), ([13.0, 0.8, 1.2], [-30.0, 9.0, -28.0])]
    {
        let view = look(eye, target, [120, 80]);
        let whole = render_ref(&scene, &view, Selection::All, &options);
        for place in PLACES {
            let clipped = render_clipped(&scene, &view, place, &options);
            assert!(clipped.ids == whole.ids, "{place:?}");
            assert!(clipped.layers == whole.layers, "no sample is covered twice, or falls between");
        }
    }
}
