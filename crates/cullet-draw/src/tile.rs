//! A square of samples, with their owners and depths, and how a surface is drawn into it.

use crate::cut::{CutLens, cut_face};
use crate::frame::PixelId;
use crate::geometry::Surface;
use crate::impostor::Rays;
use crate::sample::{Jitter, Rect, Samples};

/// Samples along a side of a tile.
pub(crate) const TILE: u32 = 64;
/// Samples along a side of a block, the unit in which hidden and missed parts are skipped.
const BLOCK: usize = 8;
const BLOCKS: usize = TILE as usize / BLOCK;
const SAMPLES: usize = (TILE * TILE) as usize;
/// A rectangle of at most this many samples is drawn one by one: looking at blocks would cost more.
const SMALL: u32 = 12;

/// A surface to draw, with its owner and where it may cover samples.
#[derive(Clone, Debug)]
pub(crate) struct Draw {
    pub(crate) surface: Surface,
    pub(crate) id: PixelId,
    pub(crate) rect: Rect,
    /// Nearest depth that any of its samples may have.
    pub(crate) nearest: f64,
    /// Whether it shows its front.
    pub(crate) front: bool,
}

/// An impostor to draw.
#[derive(Clone, Debug)]
pub(crate) struct Sprite<'a> {
    pub(crate) rays: Rays<'a>,
    pub(crate) slot: u32,
    pub(crate) rect: Rect,
    /// Nearest depth that any of its samples may have.
    pub(crate) nearest: f64,
}

/// A square of samples. Depths are inner ones: smaller is nearer, +∞ is nothing.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// First column and row.
    origin: [u32; 2],
    pub(crate) ids: Vec<PixelId>,
    pub(crate) depth: Vec<f64>,
    /// Fragments of each sample; empty if they are not counted.
    pub(crate) layers: Vec<u32>,
    /// The farthest depth in each block.
    farthest: [f64; BLOCKS * BLOCKS],
    /// Blocks whose `farthest` is out of date: too far, never too near.
    stale: u64,
    /// Blended triangles that passed, and the first sample (by row, then column) where each did.
    pub(crate) passed: Vec<(PixelId, [u32; 2])>,
    /// Where its samples lie.
    sight: Sight,
    /// The instance whose cut faces are looked for, and for each sample how many more of its
    /// surfaces beyond the cut face away than face the eye. Empty until there is one.
    wound: (u32, Vec<i32>),
}

impl Tile {
    /// The tile of this column and row of tiles.
    pub(crate) fn new(samples: &Samples, place: [u32; 2], count_layers: bool) -> Self {
        let origin = place.map(|v| v * TILE);
        let mut depth = vec![f64::INFINITY; SAMPLES];
        // A sample beyond the image is never drawn and must not keep its block open.
        let [width, height] = samples.size;
        for (i, d) in (0..).zip(&mut depth) {
            if origin[0] + i % TILE >= width || origin[1] + i / TILE >= height {
                *d = f64::NEG_INFINITY;
            }
        }
        Self {
            origin,
            sight: Sight::new(samples, origin),
            ids: vec![PixelId::NONE; SAMPLES],
            depth,
            layers: vec![0; if count_layers { SAMPLES } else { 0 }],
            farthest: [f64::INFINITY; BLOCKS * BLOCKS],
            stale: 0,
            passed: Vec::new(),
            wound: (u32::MAX, Vec::new()),
        }
    }

    /// First column and row.
    pub(crate) fn origin(&self) -> [u32; 2] {
        self.origin
    }

    /// The farthest depth of some samples, whole blocks of them.
    pub(crate) fn farthest(&self, rect: &Rect) -> f64 {
        let ([bx0, bx1], [by0, by1]) = self.blocks(rect);
        let mut far = f64::NEG_INFINITY;
        for by in by0..=by1 {
            for bx in bx0..=bx1 {
                far = far.max(self.farthest[by * BLOCKS + bx]);
            }
        }
        far
    }

    /// Brings `farthest` up to date.
    pub(crate) fn freshen(&mut self) {
        while self.stale != 0 {
            let b = self.stale.trailing_zeros() as usize;
            self.stale &= self.stale - 1;
            let first = b / BLOCKS * BLOCK * TILE as usize + b % BLOCKS * BLOCK;
            let mut far = [f64::NEG_INFINITY; BLOCK];
            for row in 0..BLOCK {
                let at = first + row * TILE as usize;
                for (f, d) in far.iter_mut().zip(&self.depth[at..at + BLOCK]) {
                    *f = if *d > *f { *d } else { *f };
                }
            }
            self.farthest[b] = far.into_iter().fold(f64::NEG_INFINITY, f64::max);
        }
    }

    /// First and last column and row within the tile of the part of `rect` in it.
    fn local(&self, rect: &Rect) -> ([u32; 2], [u32; 2]) {
        let [x, y] = self.origin;
        let clamp = |r: [u32; 2], o: u32| [r[0].max(o) - o, r[1].min(o + TILE - 1) - o];
        (clamp(rect.x, x), clamp(rect.y, y))
    }

    fn blocks(&self, rect: &Rect) -> ([usize; 2], [usize; 2]) {
        let (x, y) = self.local(rect);
        (x.map(|v| v as usize / BLOCK), y.map(|v| v as usize / BLOCK))
    }

    /// Draws an opaque surface: the nearest owns a sample, then the lowest id.
    pub(crate) fn draw(&mut self, d: &Draw, range: [f64; 2]) {
        self.each(d, range, &mut Meet::Own);
    }

    /// Tests a blended surface: it passes where it is not behind what is held.
    pub(crate) fn test(&mut self, d: &Draw, range: [f64; 2]) {
        let mut meet = Meet::Pass(usize::MAX);
        self.each(d, range, &mut meet);
        if let Meet::Pass(first) = meet
            && first < SAMPLES
        {
            self.passed.push((d.id, self.sample(first)));
        }
    }

    /// Draws what a cut leaves of a surface, like [`draw`](Self::draw).
    pub(crate) fn draw_kept(&mut self, d: &Draw, range: [f64; 2], cut: &CutLens) {
        self.each(d, range, &mut Meet::Keep(cut));
    }

    /// Counts a surface of a closed mesh where it lies beyond the cut. All surfaces of an instance
    /// come one after the other, and then [`close`](Self::close) is called.
    pub(crate) fn wind(&mut self, d: &Draw, cut: &CutLens) {
        if self.wound.0 != d.id.slot {
            self.close(cut);
            self.wound.0 = d.id.slot;
            self.wound.1.resize(SAMPLES, 0);
        }
        // What lies beyond the far plane winds as well.
        self.each(d, [f64::NEG_INFINITY, f64::INFINITY], &mut Meet::Wind(cut));
    }

    /// Gives a sample to what is nearest, then to the lowest id.
    #[inline]
    fn own(&mut self, at: usize, depth: f64, id: PixelId) {
        let held = self.depth[at];
        if depth < held || (depth == held && id < self.ids[at]) {
            self.depth[at] = depth;
            self.ids[at] = id;
            let (column, row) = (at % TILE as usize / BLOCK, at / TILE as usize / BLOCK);
            self.stale |= 1 << (row * BLOCKS + column);
        }
    }

    /// Draws the cut faces of the instance that was counted.
    pub(crate) fn close(&mut self, cut: &CutLens) {
        let (slot, mut wound) = std::mem::take(&mut self.wound);
        if let Some(closed) = (cut.closed)(slot) {
            for at in (0..wound.len()).filter(|&at| closed.holds(wound[at])) {
                if let Some((depth, plane)) = cut.entry(self.sample(at)) {
                    self.own(at, depth, cut_face(slot, plane));
                }
            }
        }
        wound.fill(0);
        self.wound = (u32::MAX, wound);
    }

    /// Draws what the rays of an impostor meet, like [`draw`](Self::draw).
    pub(crate) fn draw_sprite(&mut self, d: &Sprite, range: [f64; 2]) {
        self.each_of_sprite(d, range, |tile, at, depth, id| {
            tile.own(at, depth, id);
        });
    }

    /// Tests an impostor like [`test`](Self::test): it passes by the first of its texels that does.
    pub(crate) fn test_sprite(&mut self, d: &Sprite, range: [f64; 2]) {
        let mut first = None;
        self.each_of_sprite(d, range, |tile, at, depth, id| {
            if depth <= tile.depth[at] {
                first = first.or(Some((id, tile.sample(at))));
            }
        });
        self.passed.extend(first);
    }

    fn each_of_sprite(
        &mut self,
        d: &Sprite,
        range: [f64; 2],
        mut f: impl FnMut(&mut Self, usize, f64, PixelId),
    ) {
        let sight = std::mem::take(&mut self.sight);
        let ([x0, x1], [y0, y1]) = self.local(&d.rect);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let at = (y * TILE + x) as usize;
                // A ray costs much more than this.
                if self.layers.is_empty() && d.nearest > self.depth[at] {
                    continue;
                }
                let place = match sight.wide {
                    true => [sight.x[at], sight.y[at]],
                    false => [sight.x[x as usize], sight.y[y as usize]],
                };
                let Some((depth, triangle)) = d.rays.meet(place) else { continue };
                if depth >= range[0] && depth <= range[1] {
                    if let Some(n) = self.layers.get_mut(at) {
                        *n += 1;
                    }
                    f(self, at, depth, PixelId { slot: d.slot, triangle });
                }
            }
        }
        self.sight = sight;
    }

    /// Column and row of a sample of the tile.
    pub(crate) fn sample(&self, at: usize) -> [u32; 2] {
        [self.origin[0] + at as u32 % TILE, self.origin[1] + at as u32 / TILE]
    }

    /// Lets a surface meet every sample that it covers within a range of depths, but in blocks
    /// where it is hidden.
    fn each(&mut self, d: &Draw, range: [f64; 2], meet: &mut Meet) {
        let sight = std::mem::take(&mut self.sight);
        let s = &d.surface;
        let ([x0, x1], [y0, y1]) = self.local(&d.rect);
        if (x1 - x0 + 1) * (y1 - y0 + 1) <= SMALL {
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let at = (y * TILE + x) as usize;
                    let (px, py) = match sight.wide {
                        true => (sight.x[at], sight.y[at]),
                        false => (sight.x[x as usize], sight.y[y as usize]),
                    };
                    let e = s.at(px, py);
                    if s.covers(e) {
                        let depth = s.depth(e);
                        if depth >= range[0] && depth <= range[1] {
                            self.meet(d, at, depth, meet);
                        }
                    }
                }
            }
            self.sight = sight;
            return;
        }
        let skip_hidden = self.layers.is_empty();
        let ([x0, x1], [y0, y1]) = ([x0 as usize, x1 as usize], [y0 as usize, y1 as usize]);
        for by in y0 / BLOCK..=y1 / BLOCK {
            for bx in x0 / BLOCK..=x1 / BLOCK {
                let block = by * BLOCKS + bx;
                // Strictly behind, so that a tie is still settled by the lowest id.
                if skip_hidden && d.nearest > self.farthest[block] {
                    continue;
                }
                let [low, high] = sight.range[block];
                if s.misses(low, high) {
                    continue;
                }
                let columns = [x0.max(bx * BLOCK) % BLOCK, x1.min(bx * BLOCK + 7) % BLOCK];
                for y in y0.max(by * BLOCK)..=y1.min(by * BLOCK + 7) {
                    let first = y * TILE as usize + bx * BLOCK;
                    let (xs, ys) = match sight.wide {
                        true => (row(&sight.x, first), row(&sight.y, first)),
                        false => (row(&sight.x, bx * BLOCK), [sight.y[y]; BLOCK]),
                    };
                    let Some((covered, depth)) = row_of(s, &xs, &ys, columns, range) else {
                        continue;
                    };
                    self.meet_row(d, first, &covered, &depth, meet);
                }
            }
        }
        self.sight = sight;
    }

    /// Lets a surface meet those of eight samples that it covers.
    fn meet_row(
        &mut self,
        d: &Draw,
        first: usize,
        covered: &[bool; BLOCK],
        depth: &[f64; BLOCK],
        meet: &mut Meet,
    ) {
        let Meet::Own = meet else {
            for l in (0..BLOCK).filter(|&l| covered[l]) {
                self.meet(d, first + l, depth[l], meet);
            }
            return;
        };
        if let Some(layers) = self.layers.get_mut(first..first + BLOCK) {
            layers.iter_mut().zip(covered).for_each(|(n, covered)| *n += u32::from(*covered));
        }
        // Most surfaces are behind others, which is told of eight samples at once.
        let held = row(&self.depth, first);
        let mut near = [false; BLOCK];
        let mut any = false;
        for l in 0..BLOCK {
            near[l] = covered[l] & (depth[l] <= held[l]);
            any |= near[l];
        }
        if any {
            for l in (0..BLOCK).filter(|&l| near[l]) {
                self.own(first + l, depth[l], d.id);
            }
        }
    }

    /// Lets a surface meet a sample at a depth.
    #[inline]
    fn meet(&mut self, d: &Draw, at: usize, depth: f64, meet: &mut Meet) {
        if let Some(n) = self.layers.get_mut(at) {
            *n += 1;
        }
        match meet {
            Meet::Own => self.own(at, depth, d.id),
            Meet::Pass(first) if depth <= self.depth[at] => *first = at.min(*first),
            Meet::Pass(_) => {}
            Meet::Keep(cut) if cut.keeps(self.sample(at), depth, d.front) => {
                self.own(at, depth, d.id);
            }
            Meet::Keep(_) => {}
            Meet::Wind(cut) => {
                let beyond = |entry: (f64, usize)| CutLens::beside(depth, d.front) > entry.0;
                if cut.entry(self.sample(at)).is_some_and(beyond) {
                    self.wound.1[at] += if d.front { -1 } else { 1 };
                }
            }
        }
    }
}

/// Effect of a surface on the samples that it covers.
enum Meet<'a> {
    /// It owns those where it is nearest.
    Own,
    /// It passes where it is not behind what is held; the first such sample.
    Pass(usize),
    /// It owns those where it is nearest of what a cut leaves.
    Keep(&'a CutLens<'a>),
    /// It winds around what a cut goes through.
    Wind(&'a CutLens<'a>),
}

/// Where the samples of a tile lie, looked up once for many surfaces.
#[derive(Clone, Debug, Default)]
struct Sight {
    /// X of each column, or of each sample.
    x: Vec<f64>,
    /// Y of each row, or of each sample.
    y: Vec<f64>,
    /// Whether the above are of each sample.
    wide: bool,
    /// The lowest and highest X and Y of each block.
    range: Vec<[[f64; 2]; 2]>,
}

impl Sight {
    fn new(samples: &Samples, [x0, y0]: [u32; 2]) -> Self {
        let side = TILE as usize;
        let wide = matches!(samples.jitter(), Jitter::Hashed(_));
        let len = if wide { SAMPLES } else { side };
        let mut sight = Self { x: vec![0.0; len], y: vec![0.0; len], wide, range: Vec::new() };
        match samples.jitter() {
            Jitter::Fixed([ox, oy]) => {
                for i in 0..TILE {
                    sight.x[i as usize] = samples.x(x0 + i, ox);
                    sight.y[i as usize] = samples.y(y0 + i, oy);
                }
            }
            Jitter::Hashed(_) => {
                for i in 0..TILE * TILE {
                    let at = samples.at(x0 + i % TILE, y0 + i / TILE);
                    [sight.x[i as usize], sight.y[i as usize]] = at;
                }
            }
        }
        let [ox, oy] = samples.offsets();
        let (side, blocks) = (BLOCK as u32, BLOCKS as u32);
        sight.range = (0..blocks * blocks)
            .map(|b| {
                let (column, row) = (x0 + b % blocks * side, y0 + b / blocks * side);
                let low = [samples.x(column, ox[0]), samples.y(row + side - 1, oy[1])];
                let high = [samples.x(column + side - 1, ox[1]), samples.y(row, oy[0])];
                [low, high]
            })
            .collect();
        sight
    }
}

#[inline]
fn row(v: &[f64], first: usize) -> [f64; BLOCK] {
    let mut out = [0.0; BLOCK];
    out.copy_from_slice(&v[first..first + BLOCK]);
    out
}

/// Coverage and depth of eight samples, within some columns and a range of depths; `None` where
/// none is covered. The very arithmetic of [`Surface::at`], [`Surface::covers`] and
/// [`Surface::depth`], side by side.
#[inline]
fn row_of(
    s: &Surface,
    xs: &[f64; BLOCK],
    ys: &[f64; BLOCK],
    columns: [usize; 2],
    range: [f64; 2],
) -> Option<([bool; BLOCK], [f64; BLOCK])> {
    let mut e = [[0.0; BLOCK]; 3];
    for (e, [a, b, c]) in e.iter_mut().zip(s.edges) {
        for l in 0..BLOCK {
            e[l] = a * xs[l] + (b * ys[l] + c);
        }
    }
    let mut covered = [false; BLOCK];
    let mut any = false;
    for l in 0..BLOCK {
        let inside = (l >= columns[0]) & (l <= columns[1]);
        covered[l] =
            inside & (e[0][l] >= s.least[0]) & (e[1][l] >= s.least[1]) & (e[2][l] >= s.least[2]);
        any |= covered[l];
    }
    if !any {
        return None;
    }
    let mut depth = [0.0; BLOCK];
    for l in 0..BLOCK {
        depth[l] = (e[0][l] * s.z[0] + e[1][l] * s.z[1] + e[2][l] * s.z[2])
            / (e[0][l] * s.w[0] + e[1][l] * s.w[1] + e[2][l] * s.w[2]);
        covered[l] &= (depth[l] >= range[0]) & (depth[l] <= range[1]);
    }
    Some((covered, depth))
}
