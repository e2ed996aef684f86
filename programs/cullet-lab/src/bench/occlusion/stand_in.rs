//! A rasteriser in a few lines, to test the measurement with: strict, slow, and blind to what a
//! mesh's triangles cover together.

use cullet::View;
use cullet::bounds::{Aabb, Boxes, Side};
use cullet::cull::frustum::batch::Planes;
use cullet_maps::occscn::Occscn;

use super::rasteriser::{HIDDEN, OUTSIDE, Rasteriser, VISIBLE};

/// A buffer of the farthest depth of what covers a whole pixel; infinite where nothing does.
pub(super) struct StandIn<'a> {
    scene: &'a Occscn,
    view: Option<View>,
    depth: Vec<f64>,
    /// Calls every box hidden.
    pub(super) reckless: bool,
}

impl<'a> StandIn<'a> {
    pub(super) fn new(scene: &'a Occscn) -> Self {
        Self { scene, view: None, depth: Vec::new(), reckless: false }
    }

    /// x, y in pixels and depth; none in front of the near plane.
    fn project(view: &View, p: [f32; 3]) -> Option<[f64; 3]> {
        let m = view.clip_from_world();
        let p = p.map(f64::from);
        let c: [f64; 4] =
            std::array::from_fn(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
        let [width, height] = view.viewport().map(f64::from);
        (c[2] > 0.0 && c[3] > 0.0).then(|| {
            [(c[0] / c[3] + 1.0) * width / 2.0, (1.0 - c[1] / c[3]) * height / 2.0, c[2] / c[3]]
        })
    }

    fn triangle(&mut self, view: &View, corners: [[f64; 3]; 3]) {
        let [width, height] = view.viewport();
        let edge = |a: [f64; 3], b: [f64; 3], x: f64, y: f64| {
            (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
        };
        let [a, b, c] = corners;
        let area = edge(a, b, c[0], c[1]);
        let range = |k: usize, most: u32| {
            let low = corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
            let high = corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
            low.max(0.0) as u32..(high.max(0.0) as u32).saturating_add(1).min(most)
        };
        let farthest = corners.iter().map(|c| c[2]).fold(0.0, f64::max);
        for y in range(1, height) {
            for x in range(0, width) {
                let inside = [[0, 0], [0, 1], [1, 0], [1, 1]].iter().all(|[dx, dy]| {
                    let (x, y) = (f64::from(x + dx), f64::from(y + dy));
                    [edge(a, b, x, y), edge(b, c, x, y), edge(c, a, x, y)]
                        .iter()
                        .all(|e| e * area > 0.0)
                });
                if inside {
                    let at = &mut self.depth[(y * width + x) as usize];
                    *at = at.min(farthest);
                }
            }
        }
    }

    fn answer(&self, b: &Aabb) -> u8 {
        let Some(view) = &self.view else { return VISIBLE };
        if Planes::new(&view.frustum()).classify_box(b) == Side::Outside {
            return OUTSIDE;
        }
        let corners: Option<Vec<[f64; 3]>> =
            b.corners().into_iter().map(|p| Self::project(view, p)).collect();
        let Some(corners) = corners else { return VISIBLE };
        let [width, height] = view.viewport();
        let reach = |k: usize, most: u32| {
            let low = corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min);
            let high = corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
            (low - 1.0).max(0.0) as u32..((high + 2.0).max(0.0) as u32).min(most)
        };
        let nearest = corners.iter().map(|c| c[2]).fold(f64::INFINITY, f64::min);
        let covered = reach(1, height)
            .all(|y| reach(0, width).all(|x| self.depth[(y * width + x) as usize] < nearest));
        if covered || self.reckless { HIDDEN } else { VISIBLE }
    }
}

impl Rasteriser for StandIn<'_> {
    fn clear(&mut self, view: &View) {
        let [width, height] = view.viewport();
        self.depth.clear();
        self.depth.resize((width * height) as usize, f64::INFINITY);
        self.view = Some(view.clone());
    }

    fn draw(&mut self, meshes: &[u32]) {
        let Some(view) = self.view.clone() else { return };
        for &m in meshes {
            for t in self.scene.triangles_of(&self.scene.meshes[m as usize]) {
                let corners = t.map(|v| Self::project(&view, self.scene.vertices[v as usize]));
                if let [Some(a), Some(b), Some(c)] = corners {
                    self.triangle(&view, [a, b, c]);
                }
            }
        }
    }

    fn draw_unless_hidden(&mut self, meshes: &[u32]) -> usize {
        let drawn = |m: &&u32| {
            let seen = self.answer(&self.scene.mesh_bounds(**m as usize)) == VISIBLE;
            if seen {
                self.draw(&[**m]);
            }
            seen
        };
        meshes.iter().filter(drawn).count()
    }

    fn test(&mut self, boxes: &Boxes, answers: &mut [u8]) {
        for (i, answer) in answers.iter_mut().enumerate() {
            *answer = self.answer(&boxes.get(i));
        }
    }
}
