//! A cap: the triangles whose border is the outlines.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use crate::arrange::{Arrangement, arrange, side};
use crate::hash::QuickMap;
use crate::options::CapOptions;
use crate::result::CutReport;
use crate::section::{Places, Segment};
use crate::sides::CutPlane;

/// A place in the triangulation.
#[derive(Clone, Copy, Debug)]
struct Corner {
    place: u32,
    flat: [f32; 2],
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        // Doubling one axis is exact and turns no corner, but a round section becomes an ellipse:
        // points of one circle, of which no four decide an in-circle test, are what triangulating
        // takes longest over.
        Point2::new(f64::from(self.flat[0]) * 2.0, f64::from(self.flat[1]))
    }
}

/// The triangles of the cap, as places, counter-clockwise seen from where the plane's normal
/// points.
pub(crate) fn fill(
    outlines: &[Segment],
    places: &mut Places<'_>,
    plane: &CutPlane,
    report: &mut CutReport,
) -> Vec<[u32; 3]> {
    if outlines.is_empty() {
        return Vec::new();
    }
    let mut kept = *report;
    let filled = arrange(outlines, places, &mut kept)
        .and_then(|found| Some((sheets(&found, places, plane, outlines.len())?, found)));
    let Some((mut triangles, found)) = filled else {
        report.folded += 1;
        return fans(outlines, places.points().len());
    };
    *report = kept;
    for (segment, chain) in &found.split {
        // The border of the sheets runs along the chain; that of the cap must be the segment
        // itself.
        let sheets = segment.winding.max(i32::from(segment.flips));
        for w in chain[1..].windows(2) {
            for _ in 0..sheets {
                triangles.push([chain[0], w[1], w[0]]);
            }
        }
    }
    triangles
}

/// The faces of the triangulation, each as often as the surface winds around it. `None` where the
/// triangulation fails or the sheets are far too many.
fn sheets(
    found: &Arrangement,
    places: &Places<'_>,
    plane: &CutPlane,
    size: usize,
) -> Option<Vec<[u32; 3]>> {
    let mut number: QuickMap<u32, usize> = QuickMap::default();
    let mut corners: Vec<Corner> = Vec::new();
    let mut edges = Vec::with_capacity(found.order.len());
    for link in &found.order {
        edges.push(link.map(|place| {
            *number.entry(place).or_insert_with(|| {
                corners.push(Corner { place, flat: places.flat(place) });
                corners.len() - 1
            })
        }));
    }
    let mut conflicts = 0;
    let count = corners.len();
    let cdt = ConstrainedDelaunayTriangulation::<Corner>::try_bulk_load_cdt(corners, edges, |_| {
        conflicts += 1;
    })
    .ok()?;
    if conflicts > 0 || cdt.num_vertices() != count {
        return None;
    }
    // Left of a link in the plane's own coordinates is right of it where those are mirrored.
    let upright = plane.upright();
    let across = |from: u32, to: u32| {
        let (link, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
        let (winding, flips) = found.segments.get(&link).copied().unwrap_or_default();
        (if upright { way * winding } else { -way * winding }, flips)
    };
    let mut state: Vec<Option<(i32, bool)>> = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face();
    state[outer.fix().index()] = Some((0, false));
    let mut queue = vec![];
    // From the hull inward: each edge of the outer face has a face on its other side.
    for edge in cdt.convex_hull() {
        queue.push(edge.fix());
        queue.push(edge.rev().fix());
    }
    let mut triangles = Vec::new();
    let most = 64 * size + 4096;
    while let Some(edge) = queue.pop() {
        let edge = cdt.directed_edge(edge);
        let (own, other) = (edge.face(), edge.rev().face());
        let Some((winding, odd)) = state[own.fix().index()] else { continue };
        let to = other.fix().index();
        if state[to].is_some() {
            continue;
        }
        let place = |v: FixedVertexHandle| cdt.vertex(v).data().place;
        let (step, flips) = across(place(edge.from().fix()), place(edge.to().fix()));
        let (winding, odd) = (winding - step, odd ^ flips);
        state[to] = Some((winding, odd));
        let Some(inner) = other.as_inner() else { continue };
        let mut corners = inner.vertices().map(|v| v.data().place);
        for e in inner.adjacent_edges() {
            queue.push(e.fix());
        }
        debug_assert!(
            side(places.flat(corners[0]), places.flat(corners[1]), places.flat(corners[2])) > 0
        );
        // `corners` are counter-clockwise in flat coordinates.
        if !upright {
            corners.swap(1, 2);
        }
        let [a, b, c] = corners;
        let up = winding.max(0) + i32::from(odd);
        let down = (-winding).max(0);
        if triangles.len() + (up + down) as usize > most {
            return None;
        }
        triangles.extend((0..up).map(|_| [a, b, c]));
        triangles.extend((0..down).map(|_| [a, c, b]));
    }
    Some(triangles)
}

/// A fan around one place of each connected outline: its border is the outline, whatever that is
/// like.
fn fans(outlines: &[Segment], places: usize) -> Vec<[u32; 3]> {
    let mut hub: Vec<u32> = (0..places as u32).collect();
    fn find(hub: &mut [u32], mut of: u32) -> u32 {
        while hub[of as usize] != of {
            hub[of as usize] = hub[hub[of as usize] as usize];
            of = hub[of as usize];
        }
        of
    }
    for s in outlines {
        let (a, b) = (find(&mut hub, s.from), find(&mut hub, s.to));
        hub[a.max(b) as usize] = a.min(b);
    }
    let mut triangles = Vec::with_capacity(outlines.len());
    for s in outlines {
        let middle = find(&mut hub, s.from);
        if middle != s.from && middle != s.to {
            let sheets = s.winding.max(i32::from(s.flips));
            triangles.extend((0..sheets).map(|_| [middle, s.from, s.to]));
        }
    }
    triangles
}

/// Appends the attributes of a vertex of a cap.
pub(crate) fn attributes(
    plane: &CutPlane,
    point: [f32; 3],
    options: &CapOptions,
    stride: usize,
    list: &mut Vec<f32>,
) {
    let start = list.len();
    list.extend_from_slice(&options.template);
    list.resize(start + stride, 0.0);
    let frame = plane.frame();
    if let Some(at) = options.normal_at {
        list[start + at..][..3].copy_from_slice(&frame[2].map(|v| v as f32));
    }
    if let Some(at) = options.uv_at {
        let uv = CutPlane::frame_point(&frame, point);
        list[start + at..][..2].copy_from_slice(&uv.map(|v| v as f32));
    }
}
