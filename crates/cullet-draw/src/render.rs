//! The renderer: instances front to back, in batches; tiles on all cores.

use cullet::{Scene, View};

use crate::bounds::{misses, triangle_rect};
use crate::cut::CutLens;
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::geometry::{Lens, Surface, has_area};
use crate::impostor::Rays;
use crate::parallel;
use crate::prepare::{Item, Items, Stage};
use crate::sample::{Jitter, Rect, Samples};
use crate::sort;
use crate::tile::{Draw, Sprite, TILE, Tile};

/// Triangles in the first batch: few, so that what is near hides the rest early.
const FIRST_BATCH: u32 = 8 << 10;
/// Triangles in a batch at the most: what is drawn later sees what was drawn before, and the memory
/// of a batch stays near the caches.
const LAST_BATCH: u32 = 64 << 10;
/// Triangles that one task sets up.
const TASK: u32 = 1 << 10;
/// The most pixels along a side of a frame.
const MAX_SIDE: u32 = 65_536;

/// Draws a scene as a view sees it, with no culling but each part's sidedness and the selection.
///
/// Exact to the letter, in f64: see the [crate's page](crate) for the rules. The frame depends on
/// neither the order in which instances are drawn, nor the number of threads; a triangle's samples
/// do not depend on the selection. Instances in none of the view's layers, with a transform that is
/// not finite or that flattens space to a line, and triangles without area are never drawn. Bounds
/// that override those of a mesh are not looked at.
///
/// Cost: some 0.1 µs an instance, 0.1 µs a triangle that is not rejected with its block, and a few
/// nanoseconds a fragment; 20 bytes a pixel and at most 16 MiB of triangles at a time.
#[must_use]
pub fn render(scene: &Scene, view: &View, selection: Selection, options: &RenderOptions) -> Frame {
    in_pool(options.threads, || render_stage(&Stage::new(scene), view, selection, options))
}

pub(crate) fn render_stage(
    stage: &Stage,
    view: &View,
    selection: Selection,
    options: &RenderOptions,
) -> Frame {
    let lens = Lens::new(view);
    let samples = frame_samples(view, options);
    let items = stage.items(&lens, &samples, selection);
    let mut target = Target::new(samples, |_| true, options.count_layers);
    target.draw(stage, &lens, selection, &items);
    target.into_frame(&lens)
}

/// The samples of the frame of a view.
pub(crate) fn frame_samples(view: &View, options: &RenderOptions) -> Samples {
    let viewport = view.viewport();
    let most = MAX_SIDE / viewport[0].max(viewport[1]);
    let scale = options.scale.clamp(1, most.max(1));
    Samples::new(viewport.map(|v| v * scale), Jitter::Fixed(options.jitter))
}

/// Runs `work` on so many threads; 0 is those of the pool it is called from.
pub fn in_pool<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let (mut work, mut result) = (Some(work), None);
    parallel::install(threads, &mut || result = work.take().map(|work| work()));
    result.expect("what is installed is run")
}

/// The tiles of an image, or some of them.
#[derive(Debug)]
pub(crate) struct Target {
    samples: Samples,
    /// Tiles in a row.
    wide: u32,
    /// For each tile of the image, its index in `tiles`, or `NO_TILE`.
    index: Vec<u32>,
    tiles: Vec<Tile>,
    count_layers: bool,
}

const NO_TILE: u32 = u32::MAX;

/// How many tiles an image is wide and high.
pub(crate) fn tiles_of(samples: &Samples) -> [u32; 2] {
    samples.size.map(|v| v.div_ceil(TILE))
}

/// The tiles, by column and row, that a rectangle touches.
pub(crate) fn tiles_in(rect: &Rect) -> impl Iterator<Item = [u32; 2]> {
    let [x, y] = [rect.x, rect.y].map(|r| r.map(|v| v / TILE));
    (y[0]..=y[1]).flat_map(move |row| (x[0]..=x[1]).map(move |column| [column, row]))
}

/// Surfaces that one task set up, and which tile is to draw which of them.
#[derive(Debug, Default)]
struct Bins<'a> {
    draws: Vec<Draw>,
    /// Tile and surface, as [`sort::pair`]s, sorted.
    entries: Vec<u64>,
    sprites: Vec<Sprite<'a>>,
    /// Tile and sprite, likewise.
    sprite_entries: Vec<u64>,
}

/// Entries of one tile, of a sorted list.
fn of_tile(entries: &[u64], tile: u32) -> impl Iterator<Item = usize> {
    let first = entries.partition_point(|&e| (e >> 32) < u64::from(tile));
    let own = entries[first..].iter().take_while(move |&&e| e >> 32 == u64::from(tile));
    own.map(|&e| e as u32 as usize)
}

/// How what is drawn into a tile meets what is there.
#[derive(Clone, Copy)]
struct Into<'a> {
    surface: &'a (dyn Fn(&mut Tile, &Draw) + Sync),
    sprite: &'a (dyn Fn(&mut Tile, &Sprite) + Sync),
}

impl Target {
    /// The tiles, by column and row, that are `wanted`.
    pub(crate) fn new(
        samples: Samples,
        wanted: impl Fn([u32; 2]) -> bool,
        count_layers: bool,
    ) -> Self {
        let [wide, high] = tiles_of(&samples);
        let mut index = vec![NO_TILE; (wide * high) as usize];
        let mut places = Vec::new();
        for row in 0..high {
            for column in 0..wide {
                if wanted([column, row]) {
                    index[(row * wide + column) as usize] = places.len() as u32;
                    places.push([column, row]);
                }
            }
        }
        let tile = |i: usize| Tile::new(&samples, places[i], count_layers);
        let tiles = parallel::map(places.len(), &tile);
        Self { samples, wide, index, tiles, count_layers }
    }

    /// Draws all that is opaque, then tests all that is blended against it.
    pub(crate) fn draw(&mut self, stage: &Stage, lens: &Lens, selection: Selection, items: &Items) {
        let range = lens.range;
        let opaque = Into {
            surface: &|tile, d| tile.draw(d, range),
            sprite: &|tile, d| tile.draw_sprite(d, range),
        };
        let blended = Into {
            surface: &|tile, d| tile.test(d, range),
            sprite: &|tile, d| tile.test_sprite(d, range),
        };
        self.pass(stage, lens, selection, &items.opaque, opaque);
        self.pass(stage, lens, selection, &items.blended, blended);
    }

    /// Draws the cut faces of some closed instances, which ascend by slot, and then what a cut
    /// leaves of all.
    pub(crate) fn draw_cut(
        &mut self,
        stage: &Stage,
        lens: &Lens,
        cut: &CutLens,
        capped: &[Item],
        all: &[Item],
    ) {
        // Impostors are levels, and a whole scene has none.
        let sprite = &|_: &mut Tile, _: &Sprite| ();
        let caps = Into { surface: &|tile, d| tile.wind(d, cut), sprite };
        // What lies behind a cut face is skipped, and no cut face is farther: so a sample may then
        // be counted wrong, but has its owner.
        self.pass(stage, lens, Selection::All, capped, caps);
        parallel::for_each_chunk(&mut self.tiles, 1, &|_, tile| {
            tile[0].close(cut);
            tile[0].freshen();
        });
        let range = lens.range;
        let kept = Into { surface: &|tile, d| tile.draw_kept(d, range, cut), sprite };
        self.pass(stage, lens, Selection::All, all, kept);
    }

    fn pass(
        &mut self,
        stage: &Stage,
        lens: &Lens,
        selection: Selection,
        items: &[Item],
        into: Into<'_>,
    ) {
        let mut budget = FIRST_BATCH;
        let mut rest = items;
        while !rest.is_empty() {
            let (batch, later) = rest.split_at(few(rest, budget));
            rest = later;
            budget = (budget * 2).min(LAST_BATCH);
            let mut tasks = Vec::new();
            let mut left = batch;
            while !left.is_empty() {
                let (task, next) = left.split_at(few(left, TASK));
                tasks.push(task);
                left = next;
            }
            let bins = parallel::map(tasks.len(), &|task| {
                let mut bins = Bins::default();
                tasks[task].iter().for_each(|i| self.bin(stage, lens, selection, i, &mut bins));
                sort::sort(&mut bins.entries);
                sort::sort(&mut bins.sprite_entries);
                bins
            });
            parallel::for_each_chunk(&mut self.tiles, 1, &|i, tile| {
                let (i, tile) = (i as u32, &mut tile[0]);
                for bins in &bins {
                    for d in of_tile(&bins.entries, i) {
                        (into.surface)(tile, &bins.draws[d]);
                    }
                    for d in of_tile(&bins.sprite_entries, i) {
                        (into.sprite)(tile, &bins.sprites[d]);
                    }
                }
                tile.freshen();
            });
        }
    }

    /// The tile of a column and row, if it is wanted.
    fn tile(&self, [column, row]: [u32; 2]) -> Option<u32> {
        Some(self.index[(row * self.wide + column) as usize]).filter(|&i| i != NO_TILE)
    }

    /// Whether all samples of a rectangle hold something strictly nearer.
    pub(crate) fn hides(&self, rect: &Rect, nearest: f64) -> bool {
        let behind = |t: [u32; 2]| {
            self.tile(t).is_none_or(|t| nearest > self.tiles[t as usize].farthest(rect))
        };
        !self.count_layers && nearest > f64::NEG_INFINITY && tiles_in(rect).all(behind)
    }

    /// The inner depth of what was drawn at a sample; before all where its tile was not wanted.
    pub(crate) fn depth(&self, column: u32, row: u32) -> f64 {
        let tile = self.tile([column / TILE, row / TILE]);
        tile.map_or(f64::NEG_INFINITY, |t| {
            self.tiles[t as usize].depth[(row % TILE * TILE + column % TILE) as usize]
        })
    }

    /// Sets up the triangles of an item and finds their tiles.
    fn bin<'a>(
        &self,
        stage: &'a Stage,
        lens: &Lens,
        selection: Selection,
        item: &Item,
        bins: &mut Bins<'a>,
    ) {
        let place = &item.screen_bounds;
        if self.hides(&place.rect, place.nearest) {
            return;
        }
        let mesh = &stage.scene.meshes()[item.mesh as usize];
        let object = lens.object(stage.scene.transform(item.slot));
        if let Some(impostor) = stage.impostor(item.mesh) {
            let (rect, nearest, slot) = (place.rect, place.nearest, item.slot);
            let Some(rays) = Rays::new(impostor, lens, &object) else { return };
            let sprite = bins.sprites.len() as u32;
            let tiles = tiles_in(&rect).filter_map(|tile| self.tile(tile));
            bins.sprite_entries.extend(tiles.map(|tile| sort::pair(tile, sprite)));
            bins.sprites.push(Sprite { rays, slot, rect, nearest });
            return;
        }
        let original = mesh.original_triangle();
        for entry in item.first..item.first + item.count {
            let t = match selection {
                Selection::All => entry,
                Selection::Visible(visible) => visible.triangles[entry as usize],
            };
            let corners = mesh.corners(t);
            let clip = corners.map(|p| object.clip(p));
            let Some(rect) = triangle_rect(lens, &clip, &self.samples) else { continue };
            let Some((surface, counter_clockwise)) = Surface::new(clip) else { continue };
            if !object.draws(counter_clockwise, item.two_sided) || !has_area(corners) {
                continue;
            }
            let nearest = surface.nearest();
            if self.hides(&rect, nearest) {
                continue;
            }
            let one = rect.x[0] / TILE == rect.x[1] / TILE && rect.y[0] / TILE == rect.y[1] / TILE;
            let draw = bins.draws.len() as u32;
            let before = bins.entries.len();
            for tile in tiles_in(&rect) {
                let Some(index) = self.tile(tile) else { continue };
                let [x, y] = tile.map(|v| [v * TILE, v * TILE + TILE - 1]);
                if one || !misses(&surface, &Rect { x, y }, &self.samples) {
                    bins.entries.push(sort::pair(index, draw));
                }
            }
            if bins.entries.len() > before {
                let id = PixelId { slot: item.slot, triangle: original[t as usize] };
                let front = object.is_front(counter_clockwise);
                bins.draws.push(Draw { surface, id, rect, nearest, front });
            }
        }
    }

    /// Every owner of a sample, and every blended triangle that passed one in some tile; in no
    /// particular order, and some more than once.
    pub(crate) fn seen(&self) -> impl Iterator<Item = (PixelId, [u32; 2])> {
        self.tiles.iter().flat_map(|tile| {
            let owner = |(at, id): (usize, &PixelId)| (*id, tile.sample(at));
            let owners = tile.ids.iter().enumerate().filter(|(_, id)| **id != PixelId::NONE);
            owners.map(owner).chain(tile.passed.iter().copied())
        })
    }

    /// The frame of an image all of whose tiles were wanted.
    pub(crate) fn into_frame(self, lens: &Lens) -> Frame {
        let [width, height] = self.samples.size;
        let pixels = width as usize * height as usize;
        let mut frame = Frame {
            width,
            height,
            ids: vec![PixelId::NONE; pixels],
            depth: vec![lens.ndc_depth(f64::INFINITY); pixels],
            layers: vec![0; if self.count_layers { pixels } else { 0 }],
            ..Frame::default()
        };
        for tile in &self.tiles {
            let [x0, y0] = tile.origin();
            let columns = TILE.min(width - x0) as usize;
            for row in 0..TILE.min(height - y0) {
                let from = (row * TILE) as usize;
                let to = (y0 + row) as usize * width as usize + x0 as usize;
                frame.ids[to..to + columns].copy_from_slice(&tile.ids[from..from + columns]);
                let depth = frame.depth[to..to + columns].iter_mut();
                for (d, inner) in depth.zip(&tile.depth[from..from + columns]) {
                    *d = lens.ndc_depth(*inner);
                }
                if self.count_layers {
                    let layers = &tile.layers[from..from + columns];
                    frame.layers[to..to + columns].copy_from_slice(layers);
                }
            }
        }
        let passed: Vec<_> = self.tiles.iter().flat_map(|tile| &tile.passed).copied().collect();
        frame.set_blended(&passed);
        frame.count();
        frame
    }
}

/// How many items from the front hold about so many triangles; at least one.
fn few(items: &[Item], triangles: u32) -> usize {
    let mut sum = 0;
    let mut n = 0;
    for item in items {
        sum += item.count;
        n += 1;
        if sum >= triangles {
            break;
        }
    }
    n
}
