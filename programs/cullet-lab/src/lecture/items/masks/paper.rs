//! Masks at work, and what the paper measured: items 35 to 37 and 39 to 41.

use crate::methods::sectors::{MaskUse, corner_directions, mask_of_sectors};
use crate::methods::{Bulk, Groups};
use crate::reproduce::model::Subject;
use crate::reproduce::zhang_hoff::{Grids, PAPER, Pair, mask_to};
use crate::shapes::fibonacci;
use cullet::cull::Indices;
use cullet::cull::backface::{Facing, MaskGrid, NormalMasks, ViewCone};
use cullet::mesh::Cluster;
use cullet::{Camera, Depth, Projection, Simd, TriangleRange, View, Visible};
use cullet_draw::{RenderOptions, Selection, render};

use super::classes::{N, grid};
use crate::lecture::finding::Finding;
use crate::lecture::items::subject::{bit, bunny, facings, knobs, lost, ones, percent};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other, scene_of};

/// The classes of all triangles of a subject, in the order of its mesh.
fn encoded(subject: &Subject, grid: &MaskGrid) -> NormalMasks {
    let mut masks = NormalMasks::default();
    grid.encode_triangles(subject.mesh.positions(), subject.mesh.indices(), &mut masks);
    masks
}

pub(super) fn runtime_test(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 12;
    let (subject, grid) = (bunny(lab)?, grid(N)?);
    let masks = encoded(&subject, &grid);
    let (mut fronts, mut drawn, mut missing, mut batches) = (0, [0; 2], [0; 2], 0);
    for i in 0..VIEWS {
        let eye = subject.eye(fibonacci(i, VIEWS), 3.0);
        let mask = mask_to(&grid, eye, &subject.sphere);
        let sides = facings(&subject, eye);
        fronts += sides.iter().filter(|f| **f == Facing::Front).count();
        let and =
            |t: usize| mask.bytes()[masks.get(t).byte_offset as usize] & masks.get(t).bit_mask;
        // What each year's slides draw.
        for (year, draws) in [|bits: u8| bits == 1, |bits: u8| bits == 0].into_iter().enumerate() {
            drawn[year] += (0..masks.len()).filter(|&t| draws(and(t))).count();
            missing[year] += lost(|t| !draws(and(t)), &sides);
        }
        let expected = masks.cull_ref(&mask);
        for level in Simd::all() {
            let mut words = Vec::new();
            masks.cull(level, &mask, &mut words);
            batches += usize::from(words != expected);
        }
    }
    let whole = masks.len() * VIEWS;
    let measured = format!(
        "where the result is 1, {:.1} % of {} are drawn and {:.1} % of its front faces are missing; where it is 0, {:.1} % are drawn and \
         {} front faces are missing",
        percent(drawn[0], whole),
        subject.name,
        percent(missing[0], fronts),
        percent(drawn[1], whole),
        missing[1]
    );
    let shown = missing[0] * 10 > fronts * 9 && missing[1] == 0 && drawn[1] < whole && batches == 0;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn sectors(_: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 6;
    const SIDES: [usize; 4] = [1, 2, 4, 8];
    let (subject, grid, level) = (knobs(40)?, grid(N)?, Simd::best());
    let masks = encoded(&subject, &grid);
    let mesh = &subject.mesh;
    let ranges: Vec<_> = mesh.clusters().iter().map(Cluster::triangles).collect();
    let clusters = Groups::of_ranges(mesh.positions(), mesh.indices(), &ranges);
    let half = std::f64::consts::FRAC_PI_4;
    let projection = Projection::Perspective {
        fov_y_radians: 2.0 * half,
        aspect: 1.0,
        near: subject.radius() * 1e-3,
        far: f64::INFINITY,
    };
    let (mut culled, mut bad) = ([0; SIDES.len()], 0);
    for i in 0..VIEWS {
        // As near as the body fits into the window.
        let eye = subject.eye(fibonacci(i, VIEWS), half.sin().recip());
        let place = [eye[0], eye[1], eye[2]];
        let camera = Camera::look_at(place, subject.centre(), projection);
        let view = View::new(&camera, Depth::Reversed, [256, 256])?;
        let lines = corner_directions(&view.frustum());
        let lines = lines.ok_or_else(|| LabError::Other("a window without corners".into()))?;
        let sides = facings(&subject, eye);
        for (k, culled) in SIDES.into_iter().zip(&mut culled) {
            let sectors = mask_of_sectors(&grid, level, &lines, k, MaskUse::Camera);
            let sectors = sectors.map_err(other)?;
            for (sphere, range) in clusters.spheres().iter().zip(&ranges) {
                let Some(mask) = sectors.for_sphere(place, sphere) else { continue };
                for t in range.clone().filter(|&t| mask.culls(masks.get(t as usize))) {
                    *culled += 1;
                    bad += usize::from(sides[t as usize] == Facing::Front);
                }
            }
        }
    }
    let shares = culled.map(|n| percent(n, masks.len() * VIEWS));
    Ok(Finding::if_so(
        bad == 0 && shares.is_sorted() && shares[3] > shares[0] + 20.0,
        format!(
            "in a window of 90 degrees that a knobbly ball fills, 1, 4, 16 and 64 sectors cull {:.1}, {:.1}, {:.1} and {:.1} % of its \
             triangles, and no front face",
            shares[0], shares[1], shares[2], shares[3]
        ),
    ))
}

pub(super) fn groups(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 8;
    const COUNTS: [usize; 6] = [1, 4, 16, 64, 256, 1024];
    let (subject, grid, level) = (bunny(lab)?, grid(N)?, Simd::best());
    let mesh = &subject.mesh;
    let (mut culled, mut bad) = ([0; COUNTS.len()], 0);
    let eyes: Vec<[f64; 4]> = (0..VIEWS).map(|i| subject.eye(fibonacci(i, VIEWS), 3.0)).collect();
    let sides: Vec<Vec<Facing>> = eyes.iter().map(|&eye| facings(&subject, eye)).collect();
    for (count, culled) in COUNTS.into_iter().zip(&mut culled) {
        let groups = Groups::kd(mesh.positions(), mesh.indices(), count);
        let mut masks = NormalMasks::default();
        grid.encode_triangles(mesh.positions(), &groups.reorder(mesh.indices()), &mut masks);
        let mut words = Vec::new();
        for (&eye, sides) in eyes.iter().zip(&sides) {
            groups.cull(level, &grid, &masks, eye, &mut words);
            *culled += ones(&words);
            let front = |&(place, &t): &(usize, &u32)| {
                bit(&words, place) && sides[t as usize] == Facing::Front
            };
            bad += groups.order().iter().enumerate().filter(front).count();
        }
    }
    let whole = mesh.triangle_count() as usize * VIEWS;
    let shares = culled.map(|n| percent(n, whole));
    // Triangles that one more mask culls, between two numbers of groups.
    let more = |from: usize, to: usize| {
        (culled[to] - culled[from]) as f64 / (VIEWS * (COUNTS[to] - COUNTS[from])) as f64
    };
    let (early, late) = (more(0, 2), more(4, 5));
    let corners = 6 * (N + 1) * (N + 1);
    Ok(Finding::if_so(
        bad == 0 && shares.is_sorted() && early > 100.0 && late * 100.0 < early,
        format!(
            "from 3 radii 1, 16, 64 and 1,024 groups cull {:.1}, {:.1}, {:.1} and {:.1} % of {}; a mask more, a test of {} normals, \
             culls {early:.0} triangles more up to 16 groups and {late:.1} beyond 256",
            shares[0],
            shares[2],
            shares[3],
            shares[5],
            subject.name,
            grouped(corners)
        ),
    ))
}

pub(super) fn table(lab: &Lab) -> Result<Finding, LabError> {
    const DIRECTIONS: u32 = 24;
    let subject = bunny(lab)?;
    let (pair, grids) = (Pair::new(&subject), Grids::new(&subject));
    let radii = pair.fit(&grids, DIRECTIONS);
    let found = pair.shares(&grids, radii, DIRECTIONS, || ());
    let off: Vec<f64> =
        found.rows.iter().zip(PAPER).map(|(row, paper)| row.culled_percent - paper.1).collect();
    let fine = found.rows.iter().zip(&off).filter(|(row, _)| row.n >= 6).map(|(_, off)| off.abs());
    let fine = fine.fold(0.0, f64::max);
    let measured = format!(
        "two copies of {} from {radii:.1} radii: {:.1} % of {} triangles for N = 2 up to {:.1} % for 18, within {fine:.1} points of the \
         paper from N = 6 on and {:.1} below it at N = 2, where one view, as the paper's is, is farther from the mean of many; \
         {} front faces are lost",
        subject.name,
        found.rows[0].culled_percent,
        grouped(pair.triangles()),
        found.rows[8].culled_percent,
        -off[0],
        found.lost
    );
    let rises = found.rows.is_sorted_by(|a, b| a.back <= b.back);
    let alike =
        found.lost == 0 && found.rows.len() == 9 && rises && fine < 1.0 && off[0].abs() < 5.0;
    Ok(if alike { Finding::differs(measured) } else { Finding::fails(measured) })
}

pub(super) fn speed(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 24;
    /// Each so many of them is drawn.
    const DRAWN: usize = 12;
    let subject = bunny(lab)?;
    let n = grid(MaskGrid::MAX_CELLS)?;
    let masks = encoded(&subject, &n);
    let scene = scene_of(subject.mesh.clone())?;
    // Where the paper's shares are found again: 6 radii of the sphere around two copies.
    let radii = 12.0;
    let (mut kept, mut same) = (0, true);
    for i in 0..VIEWS {
        let eye = subject.eye(fibonacci(i, VIEWS), radii);
        let mask = mask_to(&n, eye, &subject.sphere);
        let mut list = Indices::new();
        masks.keep(Simd::best(), &mask, &mut list);
        kept += list.len();
        if i % DRAWN != 0 {
            continue;
        }
        let projection = Projection::Perspective {
            fov_y_radians: 0.18,
            aspect: 1.0,
            near: subject.radius(),
            far: f64::INFINITY,
        };
        let camera = Camera::look_at([eye[0], eye[1], eye[2]], subject.centre(), projection);
        let view = View::new(&camera, Depth::Reversed, [200, 200])?;
        let count = list.len() as u32;
        let visible = Visible {
            triangles: list.to_vec(),
            triangle_ranges: vec![TriangleRange { slot: 0, level: 0, first: 0, count }],
            ..Visible::default()
        };
        let options = RenderOptions::default();
        let [all, few] = [Selection::All, Selection::Visible(&visible)]
            .map(|selection| render(&scene, &view, selection, &options));
        same &= all.ids == few.ids && all.stats.covered_pixels > 1000;
    }
    let whole = masks.len() * VIEWS;
    let even = whole as f64 / kept as f64;
    // The same by the paper's own table: its frames take as long as they have triangles.
    let [first, last] = [PAPER[0], PAPER[8]];
    let by_times = first.2 / last.2;
    let by_counts = (100.0 - first.1) / (100.0 - last.1);
    let measured = format!(
        "the finest masks leave {:.1} % of {}'s triangles from {radii} radii, with the same pixels: at the most {even:.2} times as fast; in \
         the table N = 18 is {by_times:.2} times as fast as N = 2 and has {by_counts:.2} times as few triangles left, so that its 43 % are \
         {:.2} times",
        percent(kept, whole),
        subject.name,
        100.0 / (100.0 - last.1)
    );
    let shown = same && even > 1.5 && even < 1.8 && (by_times - by_counts).abs() < 0.05;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn interface(_: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 30;
    let (subject, grid) = (knobs(30)?, grid(N)?);
    // `Encode`, of each polygon's normal.
    let classes: Vec<_> = (0..subject.mesh.triangle_count())
        .map(|t| grid.encode_triangle(subject.mesh.corners(t)))
        .collect();
    let (mut culled, mut backs, mut bad) = (0, 0, 0);
    for i in 0..VIEWS {
        let direction = fibonacci(i, VIEWS);
        let eye = subject.eye(direction, 4.0);
        // `BuildBackfaceMask`, of a direction and an angle: that to the sphere around the body.
        let fov = 2.0 * 0.25_f64.asin();
        let cone = ViewCone::around(direction.map(|v| -v), fov * 0.5);
        let mask = grid.mask(Simd::best(), cone.as_ref());
        // `ISBACKFACING`.
        let culls = |t: usize| mask.culls(classes[t]);
        let sides = facings(&subject, eye);
        bad += lost(culls, &sides);
        culled += (0..classes.len()).filter(|&t| culls(t)).count();
        backs += sides.iter().filter(|f| **f == Facing::Back).count();
    }
    Ok(Finding::if_so(
        bad == 0 && culled * 2 > backs,
        format!(
            "the engine's three calls, encode, mask and culls, find {} of {} back faces of a knobbly ball in {VIEWS} views, and no front \
             face",
            grouped(culled),
            grouped(backs)
        ),
    ))
}
