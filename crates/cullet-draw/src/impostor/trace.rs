//! A ray against an impostor.

use cullet_mesh::{Impostor, ImpostorFrame};
use glam::DVec3;

/// The least coverage, between texels, that counts as covered. Less than a half, for a point must
/// be covered in all three frames, and what is thin would be lost: of 0.5, 0.4, 0.3 and 0.2 this
/// has the least error on the armadillo.
const COVERED: f64 = 0.3;
/// Places along a ray that are looked at, for each texel of a frame's side.
const STEPS: u32 = 3;
/// Halvings of the step that comes upon the mesh.
const HALVINGS: u32 = 6;
/// Neighbouring texels are of one surface where their depths differ by no more than this many
/// texels.
const STEEP: f64 = 2.0;
/// Distance in texels behind everything any frame saw, beyond which a point counts as in their
/// shadow and not of the mesh.
const DEEP: f64 = 2.0;
/// Distance in texels that a point may lie in front of the surface and still be of it: the rounding
/// of a texel.
const TOLERANCE: f64 = 0.5;

/// An impostor made ready for rays.
#[derive(Clone, Debug)]
pub(crate) struct Tracer {
    pub(crate) impostor: Impostor,
    centre: DVec3,
    half: DVec3,
    frames: Vec<Frame>,
    /// Coverage and depth of each texel.
    texels: Vec<[f32; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct Frame {
    /// Rows that take an offset from the centre to the frame: −1 to 1 in each.
    rows: [DVec3; 3],
    /// A difference of depth of one texel.
    texel: f64,
    /// See [`TOLERANCE`], and the rounding of depth.
    tolerance: f64,
}

/// Where a ray meets an impostor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    pub(crate) point: DVec3,
    /// The texel that says best how it looks there.
    pub(crate) texel: u32,
}

/// A ray in one of the frames: a point for each place along it.
struct Line {
    first_texel: usize,
    from: DVec3,
    step: DVec3,
    frame: Frame,
    weight: f64,
}

/// The four texels around a place, how much each weighs, and coverage and depth between them.
struct Place {
    at: [usize; 4],
    weights: [f64; 4],
    coverage: f64,
    depth: f64,
}

impl Tracer {
    pub(crate) fn new(impostor: Impostor) -> Self {
        let bounds = impostor.bounds();
        let across = f64::from(impostor.texels());
        let frame = |f: ImpostorFrame| {
            let rows = [0, 1, 2].map(|a| DVec3::from(f.axes[a]) / f.half[a]);
            // Of the finer side, as far as both are of some size.
            let size = f.half[0].min(f.half[1]).max(f.half[0].max(f.half[1]) / 4.0);
            let texel = 2.0 * size / across / f.half[2];
            Frame { rows, texel, tolerance: TOLERANCE * texel + 1.5 / 255.0 }
        };
        let frames = Impostor::frames(impostor.grid(), &bounds, impostor.radius())
            .into_iter()
            .map(frame)
            .collect();
        let texels = (0..impostor.shape().len()).map(|i| impostor.texel(i));
        Self {
            centre: bounds.center().into(),
            half: bounds.half_extent().into(),
            frames,
            texels: texels.map(|t| [t.coverage as f32, t.depth as f32]).collect(),
            impostor,
        }
    }

    /// The first point of a ray from `from` onward, in the space of the mesh, that is drawn. Never
    /// outside of the mesh's box.
    ///
    /// Some microseconds.
    pub(crate) fn trace(&self, from: DVec3, direction: DVec3) -> Option<Hit> {
        let direction = direction.try_normalize()?;
        let offset = from - self.centre;
        let [near, far] = self.span(offset, direction)?;
        let around = self.impostor.frames_around((-direction).to_array());
        let across = self.impostor.texels() as usize;
        let lines = around.map(|(number, weight)| {
            let frame = self.frames[number as usize];
            let [from, step] =
                [offset, direction].map(|v| DVec3::from(frame.rows.map(|r| r.dot(v))));
            Line { first_texel: number as usize * across * across, from, step, frame, weight }
        });
        let is_mesh = |t: f64| {
            let mut nearest = f64::INFINITY;
            for line in &lines {
                let Some(behind) = self.behind(line, t) else { return false };
                nearest = nearest.min(behind);
            }
            nearest <= DEEP
        };
        let steps = STEPS * self.impostor.texels();
        let mut before = near;
        let mut hit = (0..=steps).find_map(|i| {
            let t = near + (far - near) * f64::from(i) / f64::from(steps);
            if is_mesh(t) {
                return Some(t);
            }
            before = t;
            None
        })?;
        for _ in 0..HALVINGS {
            let middle = (before + hit) * 0.5;
            if is_mesh(middle) { hit = middle } else { before = middle }
        }
        let texel = self.best(&lines, hit)?;
        Some(Hit { point: self.centre + offset + direction * hit, texel })
    }

    /// From where to where a ray is in the box.
    fn span(&self, offset: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let [mut near, mut far] = [0.0, f64::INFINITY];
        for a in 0..3 {
            if direction[a] == 0.0 {
                if offset[a].abs() > self.half[a] {
                    return None;
                }
                continue;
            }
            let ends = [-1.0, 1.0].map(|s| (s * self.half[a] - offset[a]) / direction[a]);
            near = f64::max(near, ends[0].min(ends[1]));
            far = f64::min(far, ends[0].max(ends[1]));
        }
        // NaN is in no box.
        (near <= far && far.is_finite()).then_some([near, far])
    }

    /// How many texels a place is behind what a frame saw; `None` where it sees past it.
    fn behind(&self, line: &Line, t: f64) -> Option<f64> {
        let p = line.from + line.step * t;
        let place = self.place(line, p)?;
        let behind = place.depth - p.z;
        (place.coverage >= COVERED && behind >= -line.frame.tolerance)
            .then_some(behind / line.frame.texel)
    }

    /// `None` beside the frame.
    fn place(&self, line: &Line, p: DVec3) -> Option<Place> {
        const BESIDE: f64 = 1.0 + 1e-6;
        if !(p.x.abs() <= BESIDE && p.y.abs() <= BESIDE) {
            return None;
        }
        let across = self.impostor.texels() as usize;
        let last = across as f64 - 1.0;
        let at = |v: f64| ((v + 1.0) * 0.5 * across as f64 - 0.5).clamp(0.0, last);
        let [x, y] = [at(p.x), at(-p.y)];
        let [x0, y0] = [x, y].map(|v| v as usize);
        let [x1, y1] = [x0, y0].map(|v| (v + 1).min(across - 1));
        let [fx, fy] = [x - x0 as f64, y - y0 as f64];
        let index = |x: usize, y: usize| line.first_texel + y * across + x;
        let at = [index(x0, y0), index(x1, y0), index(x0, y1), index(x1, y1)];
        let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
        let (mut coverage, mut depth) = (0.0, 0.0);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut most, mut nearest) = (-1.0, 0.0);
        for (&i, w) in at.iter().zip(weights) {
            let [c, d] = self.texels[i].map(f64::from);
            coverage += c * w;
            depth += d * w;
            (low, high) = (low.min(d), high.max(d));
            if w > most {
                (most, nearest) = (w, d);
            }
        }
        // Between two surfaces there is none.
        let depth = if high - low > STEEP * line.frame.texel { nearest } else { depth };
        Some(Place { at, weights, coverage, depth })
    }

    /// The texel around a point that weighs most, and whose depth is the nearest to it.
    fn best(&self, lines: &[Line; 3], t: f64) -> Option<u32> {
        let mut best = (0.0, None);
        for line in lines {
            let p = line.from + line.step * t;
            let Some(place) = self.place(line, p) else { continue };
            for (&i, w) in place.at.iter().zip(place.weights) {
                let [c, d] = self.texels[i].map(f64::from);
                let off = (p.z - d) / line.frame.texel;
                let score = (line.weight + 0.02) * (w + 1e-3) * c / (0.1 + off * off);
                if score > best.0 {
                    best = (score, Some(i as u32));
                }
            }
        }
        best.1
    }
}
