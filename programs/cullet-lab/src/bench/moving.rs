//! Building a hierarchy, and keeping it while its boxes move.

use cullet::Simd;
use cullet::bounds::Aabb;
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::{Handle, Hierarchy};

use super::measure::{fastest_of_both, stream};
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{Layout, Random, camera_over, planes_of, size_name};

/// Rows of moves: how many boxes move, one in so many.
const MOVES: [(&str, usize); 2] = [("all moved", 1), ("10% moved", 10)];

/// Frames of drift.
const FRAMES: usize = 1000;
/// Rows of drift, and how often in those frames all windows are sorted again.
const DRIFTS: [(&str, usize); 2] = [("drift, 10 rounds", 10), ("drift, 40 rounds", 40)];
/// The most that a box moves along an axis in a frame, in units: a fifth of the world in all.
const SPEED: f32 = 0.4;

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for layout in Layout::ALL {
        for &len in options.tree_sizes.iter().filter(|&&len| len <= 1_000_000) {
            let name = format!("moving/{}/{}/", layout.name(), size_name(len));
            let wanted = |row: &str| options.wants(&format!("{name}{row}"));
            let build = wanted("build");
            let moves = wanted("refit") || MOVES.iter().any(|row| wanted(row.0));
            let drift = DRIFTS.iter().filter(|row| len <= options.drift_size && wanted(row.0));
            let drift: Vec<_> = drift.collect();
            if !(build || moves || !drift.is_empty()) {
                continue;
            }
            let world = Moving { options, name: name.clone(), items: layout.boxes(len) };
            let each = &mut |row: Measured| {
                if options.wants(&row.name) {
                    each(row);
                }
            };
            if build {
                world.build(each);
            }
            if moves {
                world.moves(each);
            }
            for (what, rounds) in drift {
                world.drift(what, *rounds, each);
            }
        }
    }
}

/// A hierarchy whose boxes move.
struct Moving<'a> {
    options: &'a BenchOptions,
    name: String,
    items: Vec<Aabb>,
}

impl Moving<'_> {
    fn built(&self) -> (Hierarchy, Vec<Handle>) {
        Hierarchy::build(&self.items).expect("fewer than there are slots")
    }

    fn row(&self, what: &str, visible: usize, checked: bool) -> Workload {
        Workload {
            name: format!("{}{what}", self.name),
            level: cullet_command::machine::levels()[0].0,
            items: self.items.len(),
            visible,
            checked,
        }
    }

    fn build(&self, each: &mut dyn FnMut(Measured)) {
        let (h, _) = self.built();
        let ok = h.validate().is_ok() && holds(&h, &self.items, |handle| handle.index as usize);
        let floats = h.boxes().as_floats();
        let times = fastest_of_both(
            self.options.seconds,
            |turn| stream(Simd::best(), floats, turn),
            || drop(self.built()),
        );
        let row = self.row("build", self.items.len(), ok);
        each(row.streaming(size_of::<Aabb>(), times));
    }

    fn moves(&self, each: &mut dyn FnMut(Measured)) {
        let (mut h, handles) = self.built();
        let floats = self.floats();
        let seconds = self.options.seconds;
        // To and fro, so that every pass moves what it says.
        let mut random = Random::new();
        let moved: Vec<_> = self.items.iter().map(|b| shifted(b, &mut random)).collect();

        let times = fastest_of_both(
            seconds,
            |turn| stream(Simd::best(), &floats, turn),
            || h.write_bounds(|_| ()),
        );
        let valid = h.validate().is_ok();
        let row = self.row("refit", self.items.len(), valid);
        each(row.streaming(size_of::<Aabb>(), times));
        let pairs = |to: &[Aabb], every: usize| -> Vec<(Handle, Aabb)> {
            handles.iter().copied().zip(to.iter().copied()).step_by(every).collect()
        };
        for (what, every) in MOVES {
            let [back, forth] = [pairs(&self.items, every), pairs(&moved, every)];
            let mut there = false;
            let times = fastest_of_both(
                seconds,
                |turn| stream(Simd::best(), &floats, turn),
                || {
                    there = !there;
                    let moves = if there { &forth } else { &back };
                    move_all(&mut h, moves);
                },
            );
            let at = |handle: Handle| handle.index as usize;
            let now = |i: usize| {
                if there && i.is_multiple_of(every) { &moved[i] } else { &self.items[i] }
            };
            let expected: Vec<_> = (0..self.items.len()).map(|i| *now(i)).collect();
            let valid = h.validate().is_ok() && holds(&h, &expected, at);
            let row = self.row(what, self.items.len().div_ceil(every), valid);
            each(row.streaming(size_of::<Aabb>(), times));
            move_all(&mut h, &back);
        }
    }

    /// Measures a walk after everything drifted and only slices were sorted, against one of a
    /// hierarchy that was just built over the same boxes.
    fn drift(&self, what: &str, rounds: usize, each: &mut dyn FnMut(Measured)) {
        let (mut h, _) = self.built();
        let mut random = Random::new();
        let speeds: Vec<[f32; 3]> = self
            .items
            .iter()
            .map(|_| std::array::from_fn(|_| (random.next() * 2.0 - 1.0) * SPEED))
            .collect();
        let mut places = self.items.clone();
        // A window is 1024 slots.
        let slices = (self.items.len().div_ceil(1024) * rounds).div_ceil(FRAMES);
        for _ in 0..FRAMES {
            let by_slot: Vec<_> = (0..h.slot_count()).map(|slot| h.handle(slot)).collect();
            h.write_bounds(|bounds| {
                for (slot, handle) in (0..).zip(by_slot) {
                    let Some(index) = handle.map(|handle| handle.index as usize) else { continue };
                    let (place, speed) = (&mut places[index], &speeds[index]);
                    for a in 0..3 {
                        place.min[a] += speed[a];
                        place.max[a] += speed[a];
                    }
                    bounds.set(slot, place);
                }
            });
            (0..slices).for_each(|_| drop(h.commit_slice()));
        }
        let (fresh, _) = Hierarchy::build(&places).expect("fewer than there are slots");
        let planes = planes_of(&camera_over(10, fresh.boxes()));
        let valid = h.validate().is_ok() && holds(&h, &places, |handle| handle.index as usize);
        let (mut old, mut new) = (Cut::new(), Cut::new());
        let times = fastest_of_both(
            self.options.seconds,
            |_| cull(&fresh, &planes, &mut new),
            || cull(&h, &planes, &mut old),
        );
        let (mut swept, mut listed) = (Indices::new(), Indices::new());
        cull_boxes(Simd::best(), &planes, h.boxes(), &mut swept);
        old.list(Simd::best(), &mut listed);
        let same = *swept == *listed && old.count() == new.count();
        let row = self.row(what, listed.len(), valid && same);
        each(row.against(times, "just built"));
    }

    fn floats(&self) -> Vec<f32> {
        self.items.iter().flat_map(|b| b.min.into_iter().chain(b.max)).collect()
    }
}

/// Moves boxes one by one, and refits.
fn move_all(h: &mut Hierarchy, moves: &[(Handle, Aabb)]) {
    for (handle, b) in moves {
        h.set_bounds(*handle, b).expect("it was never removed");
    }
    h.refit();
}

fn cull(h: &Hierarchy, planes: &Planes, cut: &mut Cut) {
    cut.cull(Simd::best(), planes, h.nodes(), h.boxes());
}

/// A box moved by up to a frame's way.
fn shifted(b: &Aabb, random: &mut Random) -> Aabb {
    let by: [f32; 3] = std::array::from_fn(|_| (random.next() * 2.0 - 1.0) * SPEED);
    let moved = |v: [f32; 3]| std::array::from_fn(|a| v[a] + by[a]);
    Aabb { min: moved(b.min), max: moved(b.max) }
}

/// Whether every slot's box holds that of its item, and is not much larger.
fn holds(h: &Hierarchy, items: &[Aabb], number: impl Fn(Handle) -> usize) -> bool {
    h.slot_count() as usize == items.len()
        && (0..h.slot_count()).all(|slot| {
            let Some(handle) = h.handle(slot) else { return false };
            let (held, given) = (h.boxes().get(slot as usize), &items[number(handle)]);
            (0..3).all(|a| {
                let [low, high] = [given.min[a] - held.min[a], held.max[a] - given.max[a]];
                (0.0..0.01).contains(&low) && (0.0..0.01).contains(&high)
            })
        })
}
