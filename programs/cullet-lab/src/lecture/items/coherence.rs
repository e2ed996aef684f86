//! Frames before, curved surfaces, hardware and scenes that move: what the paper leaves to others.

use crate::methods::cluster::{
    Bound, ClusterBounds, ClusterFacing, ClusterTracker, NormalCone, TwoWay,
};
use crate::methods::{BezierPatch, Bulk};
use crate::reproduce::model::Subject;
use crate::reproduce::zhang_hoff::mask_to;
use crate::shapes::fibonacci;
use cullet::cull::backface::{
    ClusterPlanes, EllipticCone, Facing, NormalMask, NormalMasks, ViewCone,
};
use cullet::{Backface, Camera, Culler, Depth, Projection, Simd, View};
use cullet_draw::Selection;

use super::masks::{N, grid};
use super::subject::{bunny, dot, facings, knobs, lost, ones, percent};
use crate::lecture::finding::Finding;
use crate::lecture::item::{BLANK, Item, Live, zachmann, zhang_hoff};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{cull_triangles, draw_of, grouped, other, scene_of};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 42,
        title: "Clusters that are tracked from frame to frame",
        places: &[zhang_hoff("section 1"), zhang_hoff("section 5")],
        claim: "Kumar and others group polygons, and follow from frame to frame which groups face away: only groups near whose border the \
                eye is are tested again, so that a frame costs less than its polygons.",
        command: "cullet lecture 42",
        live: Some(Live { scene: "knobs", state: "study.by=elliptic&look.colour=clusters" }),
        chapter: "backface-clusters.md#trees-and-the-frame-before",
        check: tracked,
        ..BLANK
    },
    Item {
        number: 43,
        title: "Cones of normals, and curved patches",
        places: &[zhang_hoff("section 2.1")],
        claim: "Shirman and Abi-Ezzi put normals into cones. With one, a curved patch is culled whole, before it is made of triangles.",
        command: "cullet picture cones knobs --eye 1.55,2.1,2.0 --target 0,1.15,0",
        live: Some(Live { scene: "knobs", state: "study.by=cones&structure.cones=true" }),
        chapter: "backface-clusters.md#other-bounds",
        check: patches,
        ..BLANK
    },
    Item {
        number: 44,
        title: "Masks beside lists that hardware keeps",
        places: &[zhang_hoff("section 5")],
        claim: "Where hardware keeps lists of polygons, two bytes more for each polygon stay with the list, and a frame hands in no more than \
                its mask of 256 bytes.",
        said: Some("2 bytes a polygon"),
        command: "cullet bench backface",
        chapter: "gpu.md#triangles-one-by-one",
        check: retained,
        ..BLANK
    },
    Item {
        number: 45,
        title: "Normals that change",
        places: &[zhang_hoff("section 5")],
        claim: "Classes of normals that are made beforehand no longer hold where a mesh deforms, and the paper leaves that open. Only the \
                triangles that moved need their class anew.",
        command: "cullet verify moving --time 1.5 --path walk --views 4",
        live: Some(Live { scene: "moving", state: "look.colour=sides" }),
        chapter: "moving.md",
        check: deforming,
        ..BLANK
    },
    Item {
        number: 46,
        title: "Two polygons in five",
        places: &[zhang_hoff("section 1"), zhang_hoff("section 4"), zachmann("slide 19")],
        claim: "Masks cull more than 40 % of the polygons of a solid, of the half that faces away.",
        said: Some("more than 40 %"),
        command: "cullet verify knobs --no-occlusion --views 4",
        live: Some(Live { scene: "knobs", state: "look.colour=sides" }),
        chapter: "backface.md#what-can-be-reached",
        check: two_in_five,
        ..BLANK
    },
];

/// The planes of each cluster of a subject's mesh.
fn planes_of_clusters(subject: &Subject) -> Vec<ClusterPlanes> {
    let mesh = &subject.mesh;
    let of = |range: std::ops::Range<u32>| ClusterPlanes::new(range.map(|t| mesh.corners(t)));
    mesh.clusters().iter().map(|c| of(c.triangles())).collect()
}

fn tracked(_: &Lab) -> Result<Finding, LabError> {
    const FRAMES: usize = 120;
    const STEP: f64 = 0.01;
    let (subject, level) = (knobs(40)?, Simd::best());
    let bounds: Vec<Option<EllipticCone>> =
        planes_of_clusters(&subject).iter().map(EllipticCone::fit).collect();
    let batch: ClusterBounds<EllipticCone> = bounds.iter().copied().collect();
    let mut tracker: ClusterTracker<EllipticCone> = bounds.iter().copied().collect();
    let (mut looked, mut changes, mut culled, mut wrong) = (0, 0, 0, 0);
    let (mut expected, mut before) = (Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        // An orbit at three radii; each frame the eye moves by a hundredth of one.
        let (sin, cos) = (frame as f64 * STEP / 3.0).sin_cos();
        let eye = subject.eye([cos, 0.3, sin], 3.0);
        before.clone_from(&expected);
        batch.cull(level, eye, &mut expected);
        wrong += usize::from(tracker.update(level, eye) != expected);
        if frame > 0 {
            looked += tracker.looked_at();
            changes += tracker.changed().len();
            let differ: u32 = before.iter().zip(&expected).map(|(a, b)| (a ^ b).count_ones()).sum();
            wrong += usize::from(differ as usize != tracker.changed().len());
            culled += ones(&expected);
        }
    }
    let all = bounds.len() * (FRAMES - 1);
    Ok(Finding::if_so(
        wrong == 0 && changes > 0 && culled > 0 && looked * 10 < all && looked >= changes,
        format!(
            "an eye that moves by a hundredth of the radius a frame looks at {:.1} % of {} clusters, {:.1} % of which are culled, and finds \
             the same as a test of all; {changes} results change in {} frames",
            percent(looked, all),
            bounds.len(),
            percent(culled, all),
            FRAMES - 1
        ),
    ))
}

/// A bicubic sheet over a square of side 3 that bulges upward by `height`.
fn sheet(height: f32) -> Vec<[f32; 3]> {
    let at = |i: usize| ((i / 4) as f32, (i % 4) as f32);
    let bulge = |x: f32, y: f32| height * (x * (3.0 - x) + y * (3.0 - y));
    (0..16).map(at).map(|(x, y)| [x, y, bulge(x, y)]).collect()
}

fn patches(_: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 200;
    const SAMPLES: usize = 16;
    let mut wrong = 0;
    // Clusters: what the cone culls, all planes agree to.
    let subject = knobs(24)?;
    let planes = planes_of_clusters(&subject);
    let cones: Vec<Option<NormalCone>> = planes.iter().map(NormalCone::fit).collect();
    let (mut clusters, mut ideal) = (0, 0);
    for i in 0..VIEWS {
        let eye = subject.eye(fibonacci(i, VIEWS), 3.0);
        for (planes, cone) in planes.iter().zip(&cones) {
            let (behind, culled) =
                (planes.is_behind(eye), cone.is_some_and(|cone| cone.is_behind(eye)));
            ideal += usize::from(behind);
            clusters += usize::from(culled);
            wrong += usize::from(culled && !behind);
        }
    }
    // Patches: what the cone of the net culls, samples of the surface agree to.
    let (mut culled, mut behind) = (0, 0);
    for height in [0.0, 0.05, 0.2] {
        let net = sheet(height);
        let patch = BezierPatch::new([3, 3], &net).map_err(other)?;
        let bound = TwoWay::<NormalCone>::fit(&patch.surface_planes());
        for i in 0..VIEWS {
            let d = fibonacci(i, VIEWS);
            let eye = [1.5 + 6.0 * d[0], 1.5 + 6.0 * d[1], 6.0 * d[2]];
            let heights = (0..SAMPLES * SAMPLES).map(|k| {
                let along = |k: usize| k as f64 / (SAMPLES - 1) as f64;
                let (u, v) = (along(k / SAMPLES), along(k % SAMPLES));
                let p = patch.point(u, v);
                let to_eye = std::array::from_fn(|k| eye[k] - p[k]);
                dot(patch.normal(u, v), to_eye)
            });
            let (low, high) =
                heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            behind += usize::from(high < 0.0);
            match bound.facing([eye[0], eye[1], eye[2], 1.0]) {
                ClusterFacing::Back => {
                    culled += 1;
                    wrong += usize::from(high >= 0.0);
                }
                ClusterFacing::Front => wrong += usize::from(low <= 0.0),
                ClusterFacing::Mixed => {}
            }
        }
    }
    Ok(Finding::if_so(
        wrong == 0 && culled * 2 > behind && clusters * 2 > ideal,
        format!(
            "round cones cull {} of {} clusters that all of their planes would, and {culled} of {behind} times that {SAMPLES} × \
             {SAMPLES} samples of three patches face away, each without a triangle made; none of it wrongly",
            grouped(clusters),
            grouped(ideal)
        ),
    ))
}

fn retained(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 6;
    let subject = bunny(lab)?;
    let mut scene = scene_of(subject.mesh.clone())?;
    let culler = Culler { backface: Backface::Masks, occlusion: None, ..Culler::balanced() };
    scene.prepare(culler.preparation());
    let kept = |scene: &cullet::Scene| -> Vec<NormalMask> {
        let masks = scene.prepared_of(0).backfaces().and_then(|b| b.masks());
        masks.map_or_else(Vec::new, |m| (0..m.len()).map(|i| m.get(i)).collect())
    };
    let before = kept(&scene);
    let (mut drawn, mut bad) = (0, 0);
    for i in 0..VIEWS {
        let eye = subject.eye(fibonacci(i, VIEWS), 4.0);
        let projection = Projection::Perspective {
            fov_y_radians: 0.6,
            aspect: 1.6,
            near: subject.radius() * 0.5,
            far: f64::INFINITY,
        };
        let camera = Camera::look_at([eye[0], eye[1], eye[2]], subject.centre(), projection);
        let view = View::new(&camera, Depth::Reversed, [320, 200])?;
        let visible = cull_triangles(&culler, &scene, &view);
        drawn += visible.triangles.len();
        let [all, few] = [Selection::All, Selection::Visible(&visible)]
            .map(|selection| draw_of(&scene, &view, selection));
        bad += usize::from(all.ids != few.ids);
    }
    let triangles = subject.mesh.triangle_count() as usize;
    // In immediate mode each frame hands in what is left: three corners of three floats each.
    let immediate = drawn / VIEWS * 36;
    let mask =
        size_of_val(mask_to(&grid(N)?, subject.eye([1.0, 0.0, 0.0], 4.0), &subject.sphere).bytes());
    Ok(Finding::if_so(
        bad == 0
            && before.len() == triangles
            && before == kept(&scene)
            && drawn < triangles * VIEWS * 3 / 4
            && mask == 256,
        format!(
            "{} bytes stay with {}'s {} triangles and are the same after {VIEWS} frames, each of which hands in {mask} bytes; to hand in the \
             {} triangles that are left would take {}",
            grouped(before.len() * size_of::<NormalMask>()),
            subject.name,
            grouped(triangles),
            grouped(drawn / VIEWS),
            grouped(immediate)
        ),
    ))
}

fn deforming(_: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 12;
    let (subject, grid) = (knobs(30)?, grid(N)?);
    let mesh = &subject.mesh;
    let mut masks = NormalMasks::default();
    grid.encode_triangles(mesh.positions(), mesh.indices(), &mut masks);
    let stale = masks.clone();
    // The upper half is sheared, the more the higher.
    let bent: Vec<[f32; 3]> =
        mesh.positions().iter().map(|&[x, y, z]| [x + 1.2 * y.max(0.0).powi(2), y, z]).collect();
    let moves = |t: usize| {
        let corners = mesh.triangle(t as u32);
        corners.iter().any(|&v| bent[v as usize] != mesh.positions()[v as usize])
    };
    let mut moved = 0;
    for t in (0..masks.len()).filter(|&t| moves(t)) {
        grid.update(&bent, mesh.indices(), t..t + 1, &mut masks);
        moved += 1;
    }
    let mut anew = NormalMasks::default();
    grid.encode_triangles(&bent, mesh.indices(), &mut anew);
    let differ = (0..anew.len()).filter(|&t| anew.get(t) != masks.get(t)).count();
    let data = super::subject::one_sided(bent, mesh.indices().to_vec());
    let bent = Subject::new("a bent ball".into(), data).map_err(|e| LabError::Other(e.message))?;
    // Its triangles may lie in another order: by their numbers in the list that was bent.
    let original = bent.mesh.original_triangle();
    let (mut old, mut new) = (0, 0);
    for i in 0..VIEWS {
        let eye = bent.eye(fibonacci(i, VIEWS), 3.0);
        let cone = ViewCone::to_sphere(eye, &bent.sphere);
        let mask = grid.mask(Simd::best(), cone.as_ref());
        let sides = facings(&bent, eye);
        old += lost(|t| mask.culls(stale.get(original[t] as usize)), &sides);
        new += lost(|t| mask.culls(masks.get(original[t] as usize)), &sides);
    }
    Ok(Finding::if_so(
        differ == 0 && old > 0 && new == 0 && moved > 0 && moved < masks.len(),
        format!(
            "a knobbly ball's upper half is bent: with the classes that it had, {old} front faces are lost in {VIEWS} views; with those of its \
             {} moved triangles of {} replaced, none, and all classes are as if made anew",
            grouped(moved),
            grouped(masks.len())
        ),
    ))
}

fn two_in_five(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 16;
    const RADII: [f64; 3] = [1.5, 3.0, 12.0];
    let (subject, grid) = (bunny(lab)?, grid(N)?);
    let mut masks = NormalMasks::default();
    grid.encode_triangles(subject.mesh.positions(), subject.mesh.indices(), &mut masks);
    let (mut culled, mut backs, mut bad) = ([0; 3], [0; 3], 0);
    for (at, radii) in RADII.into_iter().enumerate() {
        for i in 0..VIEWS {
            let eye = subject.eye(fibonacci(i, VIEWS), radii);
            let mask = mask_to(&grid, eye, &subject.sphere);
            let sides = facings(&subject, eye);
            culled[at] += masks.count(Simd::best(), &mask) as usize;
            backs[at] += sides.iter().filter(|f| **f == Facing::Back).count();
            bad += lost(|t| mask.culls(masks.get(t)), &sides);
        }
    }
    let whole = masks.len() * VIEWS;
    let [culled, backs] = [culled, backs].map(|counts| counts.map(|n| percent(n, whole)));
    let measured = format!(
        "masks of 1,536 classes cull {:.1} % of {} from 12 radii, {:.1} % from 3 and {:.1} % from 1.5, where {:.1}, {:.1} and {:.1} % face \
         away: more than 40 % only from afar",
        culled[2], subject.name, culled[1], culled[0], backs[2], backs[1], backs[0]
    );
    let shown = bad == 0 && culled[2] > 40.0 && culled.is_sorted() && backs[2] > culled[2];
    Ok(if shown { Finding::differs(measured) } else { Finding::fails(measured) })
}
