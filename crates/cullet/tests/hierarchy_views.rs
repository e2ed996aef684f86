//! Several views at once, and the frustum around them.

mod common;

use common::Rng;
use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::{Cut, ViewMasks, ViewsError, cull_views};
use cullet::hierarchy::{Hierarchy, Nodes};
use cullet::{Camera, Frustum, Level, Projection};

fn world(rng: &mut Rng, len: usize) -> Hierarchy {
    let boxes: Vec<_> = (0..len)
        .map(|_| rng.vector(60.0).map(|v| v as f32))
        .map(|c| Aabb::new(c, c.map(|v| v + 1.0)))
        .collect();
    Hierarchy::build(&boxes).expect("few").0
}

#[test]
fn views_at_once_are_views_one_by_one() {
    let mut rng = Rng(21);
    let h = world(&mut rng, 9000);
    for views in [0, 1, 4, 32] {
        let planes: Vec<_> =
            (0..views).map(|_| Planes::new(&common::random_view(&mut rng).frustum())).collect();
        for level in common::levels() {
            let mut cuts = vec![Cut::new(); views];
            cull_views(level, &planes, h.nodes(), h.boxes(), &mut cuts).expect("as many");
            for (planes, cut) in planes.iter().zip(&cuts) {
                let mut alone = Cut::new();
                alone.cull(level, planes, h.nodes(), h.boxes());
                assert_eq!((cut.visible(), cut.inside()), (alone.visible(), alone.inside()));
                assert_eq!(cut.nodes_asked(), alone.nodes_asked());
            }
            let mut masks = ViewMasks::new();
            masks.gather(&cuts).expect("32 at most");
            assert!(masks.slots().is_sorted() && masks.slots().len() == masks.masks().len());
            for (view, cut) in cuts.iter().enumerate() {
                let with = masks.slots().iter().zip(masks.masks());
                let with = with.filter(|(_, m)| **m >> view & 1 == 1).map(|(&s, _)| s);
                let mut alone = Vec::new();
                cut.ranges(|first, count| alone.extend(first..first + count));
                assert!(with.eq(alone));
            }
            assert!(masks.masks().iter().all(|&m| m != 0));
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut rng = Rng(22);
    let h = world(&mut rng, 100);
    let planes = vec![Planes::new(&Frustum::everything()); 33];
    let mut cuts = vec![Cut::new(); 33];
    let two = cull_views(Level::new(), &planes, h.nodes(), h.boxes(), &mut cuts[..2]);
    assert_eq!(two, Err(ViewsError::Counts { views: 33, cuts: 2 }));
    cull_views(Level::new(), &planes, h.nodes(), h.boxes(), &mut cuts).expect("any number");
    let mut masks = ViewMasks::new();
    assert_eq!(masks.gather(&cuts), Err(ViewsError::TooMany(33)));
    let other = world(&mut rng, 50);
    cuts[1].cull(Level::new(), &planes[0], other.nodes(), other.boxes());
    let refused = masks.gather(&cuts[..2]);
    assert_eq!(refused, Err(ViewsError::Boxes { index: 1, len: 50, first: 100 }));
    assert!(masks.slots().is_empty());
}

#[test]
fn changes_lead_from_one_answer_to_the_next() {
    let mut rng = Rng(23);
    let h = world(&mut rng, 5000);
    let (mut now, mut before) = (Cut::new(), Cut::new());
    let (mut added, mut removed) = (Vec::new(), Vec::new());
    let mut held = std::collections::BTreeSet::new();
    for step in 0..40 {
        std::mem::swap(&mut now, &mut before);
        let planes = Planes::new(&common::random_view(&mut rng).frustum());
        if step == 20 {
            // Of fewer boxes.
            let boxes = Boxes::from_slice(&(0..900).map(|i| h.boxes().get(i)).collect::<Vec<_>>());
            now.cull(Level::new(), &planes, &Nodes::over(Level::new(), &boxes), &boxes);
        } else {
            now.cull(Level::new(), &planes, h.nodes(), h.boxes());
        }
        now.changes_since(&before, &mut added, &mut removed);
        assert!(added.is_sorted() && removed.is_sorted());
        assert!(added.iter().all(|&slot| held.insert(slot)));
        assert!(removed.iter().all(|slot| held.remove(slot)));
        let mut list = Vec::new();
        now.ranges(|first, count| list.extend(first..first + count));
        assert!(held.iter().copied().eq(list));
    }
}

#[test]
fn two_eyes_see_through_one_frustum() {
    let mut rng = Rng(24);
    let h = world(&mut rng, 20_000);
    for round in 0..20 {
        let direction = rng.vector(1.0);
        let eye = rng.vector(30.0);
        let side = glam::DVec3::from(direction).cross(glam::DVec3::Y).normalize() * 0.5;
        let eyes = [-1.0, 1.0].map(|s| {
            let far = if round % 2 == 0 { 40.0 } else { f64::INFINITY };
            let projection =
                Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far };
            let eye = (glam::DVec3::from(eye) + side * s).into();
            let camera = Camera { eye, direction, up: [0.0, 1.0, 0.0], projection };
            camera.frustum().expect("a camera")
        });
        let around = Frustum::around(&eyes);
        assert!((5..=6).contains(&around.planes().count()));
        let mut seen = 0;
        for _ in 0..2000 {
            let p = rng.vector(60.0);
            if eyes.iter().any(|f| f.contains(p)) {
                seen += 1;
                assert!(around.contains(p), "{p:?}");
            }
        }
        let mut wide = Cut::new();
        wide.cull(Level::new(), &Planes::new(&around), h.nodes(), h.boxes());
        for frustum in &eyes {
            let planes = Planes::new(frustum);
            let (mut own, mut refined) = (Cut::new(), Cut::new());
            own.cull(Level::new(), &planes, h.nodes(), h.boxes());
            refined.refine(Level::new(), &planes, h.boxes(), &wide);
            assert_eq!(refined.visible(), own.visible());
            assert_eq!(refined.inside(), own.inside());
            assert!(wide.count() >= own.count() && (seen < 100 || wide.count() < h.len() as usize));
        }
    }
    assert_eq!(Frustum::around(&[]).planes().count(), 0);
    assert_eq!(Frustum::around(&[Frustum::everything()]).planes().count(), 0);
}
