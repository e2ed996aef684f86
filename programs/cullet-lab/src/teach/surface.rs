//! A model's surface in the colours of its clusters, and their cones of normals.

use std::collections::HashMap;

use crate::methods::cluster::{Bound, NormalCone};
use cullet::cull::backface::ClusterPlanes;
use cullet::{Mesh, Scene, View, view::CullFace};
use glam::{DMat3, DVec3};

use super::KEPT;
use cullet_draw::Picture;
use cullet_draw::caption;
use cullet_draw::palette::NEIGHBOURS;
use cullet_draw::picture::canvas::grouped;
use cullet_draw::picture::palette::{INK, PAPER, mix};
use cullet_draw::picture::shaded::{light_through, linear};
use cullet_draw::picture::space::{Space, Surfaces, corners, framing};
use cullet_draw::render;
use cullet_draw::{Frame, PixelId, RenderOptions, Selection};

/// The most cones of normals in a picture: those that are the largest in it.
const MOST_CONES: usize = 400;

/// A cone reaches at most so far on the picture, as a share of its height: one of a large cluster
/// would cover all.
const CONE_REACH: f64 = 0.07;

/// A cone of normals on a picture.
struct Glyph {
    depth: f64,
    /// Where it stands on its cluster.
    foot: [f64; 2],
    /// The end of its axis.
    tip: [f64; 2],
    /// Its rim.
    ring: Vec<[f64; 2]>,
}

/// The scene in the colours of its clusters: two that touch differ where eight colours suffice.
/// Both sides of every surface are drawn. Cost: two frames at twice the size.
#[must_use]
pub fn clusters(scene: &Scene, view: &View) -> Picture {
    let mut picture = clustered(scene, view).0.halved();
    let count: usize = scene.slots().map(|s| scene.mesh(s).clusters().len()).sum();
    caption(&mut picture, &format!("{} clusters", grouped(count as u64)));
    picture
}

/// [`clusters`] with the cone of normals of those that face the eye and have one: its axis, and a
/// disc across it as wide as its normals spread. Clusters whose normals fit no cone have none; of
/// more than 400 that would be seen, the largest in the picture are drawn, and the caption says so.
#[must_use]
pub fn cones(scene: &Scene, view: &View) -> Picture {
    let (picture, frame) = clustered(scene, view);
    let mut picture = picture.halved();
    let space = Space::new(view);
    let size = [picture.width, picture.height];
    let (mut with, mut all) = (0u64, 0u64);
    let mut glyphs: Vec<Glyph> = Vec::new();
    for slot in scene.slots() {
        let mesh = scene.mesh(slot);
        let transform = scene.transform(slot);
        let m = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
        let normal_matrix = m.inverse().transpose();
        let t = DVec3::from(transform.translation);
        for cluster in mesh.clusters() {
            all += 1;
            let planes = planes_of(mesh, cluster.first_triangle, cluster.triangle_count);
            let Some(cone) = NormalCone::fit(&planes) else { continue };
            with += 1;
            let axis = DVec3::from(cone.axis.map(f64::from));
            let middle = m * DVec3::from(planes.centre()) + t;
            if (normal_matrix * axis).dot(space.towards_eye(middle)) <= 0.15 {
                continue;
            }
            let length = planes.radius() * 0.6;
            let slope = f64::from(cone.cutoff).min(0.95).asin().tan().min(2.0);
            let (u, v) = axis.any_orthonormal_pair();
            let world = |p: DVec3| m * (p + DVec3::from(planes.centre())) + t;
            let ring = (0..28).filter_map(|i| {
                let (s, c) = (f64::from(i) / 28.0 * std::f64::consts::TAU).sin_cos();
                let p = (axis + (u * c + v * s) * slope).normalize() * length;
                space.project(world(p), size).map(|p| p.0)
            });
            let ring: Vec<_> = ring.collect();
            let ends = (space.project(middle, size), space.project(world(axis * length), size));
            let (Some((foot, depth)), Some((tip, _))) = ends else { continue };
            let (ring, tip) = within_reach(foot, ring, tip, CONE_REACH * f64::from(size[1]));
            if ring.len() == 28 && !is_hidden(&frame, &space, foot, middle, planes.radius()) {
                glyphs.push(Glyph { depth, foot, tip, ring });
            }
        }
    }
    let seen = glyphs.len();
    if seen > MOST_CONES {
        let size = |g: &Glyph| {
            let reach = |p: &[f64; 2]| (p[0] - g.foot[0]).hypot(p[1] - g.foot[1]);
            g.ring.iter().map(reach).fold(0.0, f64::max)
        };
        glyphs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        glyphs.truncate(MOST_CONES);
    }
    // Farthest first.
    glyphs.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    if !space.nearer(1.0, 0.0) {
        glyphs.reverse();
    }
    for Glyph { foot, tip, ring, .. } in glyphs {
        let mut hull = ring.clone();
        hull.push(foot);
        picture.fill_convex(&cullet_draw::picture::canvas::hull(&hull), PAPER, 0.30);
        picture.fill_convex(&ring, PAPER, 0.45);
        picture.outline(&ring, 1.0, INK, 0.8);
        picture.line(foot, tip, 1.6, INK, 1.0);
    }
    let mut words =
        format!("{} of {} clusters have a cone of normals", grouped(with), grouped(all));
    if seen > MOST_CONES {
        words +=
            &format!("; the largest {MOST_CONES} of {} in sight are drawn", grouped(seen as u64));
    }
    caption(&mut picture, &words);
    picture
}

/// A cone on the picture, drawn smaller where it would reach farther than that.
fn within_reach(
    foot: [f64; 2],
    ring: Vec<[f64; 2]>,
    tip: [f64; 2],
    most: f64,
) -> (Vec<[f64; 2]>, [f64; 2]) {
    let reach = |p: &[f64; 2]| (p[0] - foot[0]).hypot(p[1] - foot[1]);
    let far = ring.iter().chain([&tip]).map(reach).fold(most, f64::max);
    let near = |p: [f64; 2]| [0, 1].map(|k| foot[k] + (p[k] - foot[k]) * (most / far));
    (ring.into_iter().map(near).collect(), near(tip))
}

/// A view of the whole scene from a direction; `None` for an empty scene.
pub(super) fn whole(scene: &Scene, from: DVec3, size: [u32; 2]) -> Option<View> {
    let extent = scene.extent();
    if extent.is_empty() {
        return None;
    }
    framing(&corners(scene, &extent), from, 0.68, size)
}

/// The middle of the scene in the world, and how far its extent reaches from there.
pub(super) fn ball_around(scene: &Scene) -> (DVec3, f64) {
    let extent = scene.extent();
    let middle = DVec3::from(scene.origin()) + DVec3::from(extent.center().map(f64::from));
    (middle, DVec3::from(extent.half_extent().map(f64::from)).length())
}

/// The planes of a range of a mesh's triangles.
pub(super) fn planes_of(mesh: &Mesh, first: u32, count: u32) -> ClusterPlanes {
    ClusterPlanes::new((first..first + count).map(|t| mesh.corners(t)))
}

fn clustered(scene: &Scene, view: &View) -> (Picture, Frame) {
    let colors: Vec<Vec<u8>> = scene.meshes().iter().map(cluster_colors).collect();
    let color = |slot: u32, t: u32| {
        let clusters = scene.mesh(slot).clusters();
        let i = clusters.partition_point(|c| c.first_triangle <= t).wrapping_sub(1);
        let of_mesh = &colors[scene.mesh_id(slot) as usize];
        of_mesh.get(i).map_or(KEPT, |&c| mix(NEIGHBOURS[c as usize], PAPER, 0.15))
    };
    colored(scene, view, &color)
}

/// A lit picture of the scene at twice the size of the view, both sides of everything, in the
/// colours of (slot, triangle).
pub(super) fn colored(
    scene: &Scene,
    view: &View,
    color: &(dyn Fn(u32, u32) -> [u8; 3] + Sync),
) -> (Picture, Frame) {
    let mut view = view.clone();
    view.cull_face = CullFace::None;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(scene, &view, Selection::All, &options);
    let surfaces = Surfaces::new(scene, &frame.ids);
    let of = |id: PixelId| {
        let color = surfaces.triangle(id).map_or(KEPT, |t| color(id.slot, t));
        DVec3::from(color.map(linear))
    };
    (light_through(0.0, scene, &frame, &view, &surfaces, &of), frame)
}

/// A colour for each cluster of a mesh, by number: the least used by the neighbours before it.
fn cluster_colors(mesh: &Mesh) -> Vec<u8> {
    let mut at: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
    let mut touched: Vec<Vec<[u32; 3]>> = vec![Vec::new(); mesh.clusters().len()];
    for (c, cluster) in (0..).zip(mesh.clusters()) {
        for t in cluster.first_triangle..cluster.first_triangle + cluster.triangle_count {
            for p in mesh.corners(t) {
                // Adding zero makes −0 into 0, which is the same place.
                let key = p.map(|v| (v + 0.0).to_bits());
                let there = at.entry(key).or_default();
                if there.last() != Some(&c) {
                    there.push(c);
                    touched[c as usize].push(key);
                }
            }
        }
    }
    let mut colors = vec![u8::MAX; touched.len()];
    for c in 0..colors.len() {
        let mut used = [0u32; NEIGHBOURS.len()];
        for other in touched[c].iter().flat_map(|key| &at[key]) {
            if let Some(n) = used.get_mut(colors[*other as usize] as usize) {
                *n += 1;
            }
        }
        // Begin elsewhere each time, so that all colours are used.
        let turn = |i: usize| (i + c) % NEIGHBOURS.len();
        let best = (0..NEIGHBOURS.len()).map(turn).min_by_key(|&i| used[i]);
        colors[c] = best.unwrap_or(0) as u8;
    }
    colors
}

fn is_hidden(frame: &Frame, space: &Space, at: [f64; 2], p: DVec3, radius: f64) -> bool {
    let [x, y] = at.map(|v| (v * 2.0).max(0.0) as u32);
    if x >= frame.width || y >= frame.height {
        return true;
    }
    let depth = frame.depth[y as usize * frame.width as usize + x as usize];
    // A little towards the eye, for the middle of a bent cluster is under its surface.
    let raised = p + space.towards_eye(p) * (radius * 0.6);
    space.project(raised, [frame.width, frame.height]).is_none_or(|(_, d)| space.nearer(depth, d))
}
