//! Baking in Godot: on a thread, with progress, and an end at any time.

use std::sync::Arc;
use std::thread::JoinHandle;

use godot::classes::{Engine, Node, SceneTree};
use godot::obj::Singleton;
use godot::prelude::*;

use super::baked::{Baked, Method};
use super::gather::Gathered;
use super::resource::CulletPvs;
use super::work::{self, BakeError, Progress, Settings};
use crate::convert;
use crate::registry::Registry;
use crate::world::{CulletWorld, scenario_of};

/// The way by which baked visibility is found.
#[derive(GodotConvert, Var, Export, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[godot(via = i64)]
pub(crate) enum CulletPvsMethod {
    #[default]
    Rooms,
    Proved,
    Sampled,
}

/// Bakes which nodes of a scene may be seen from where, on threads of its own, as Godot goes on.
/// Works in the editor too. The result is a `CulletPvs`, to be saved and put into `CulletWorld.pvs`.
///
/// Nodes hide others as for `CulletWorld`, but for those with automatic levels, those below a
/// `NoCulletOccluder`, and those that a body of physics carries: mark what moves.
#[derive(GodotClass)]
#[class(tool, base = RefCounted)]
pub(crate) struct CulletPvsBaker {
    /// How sets are found.
    #[var]
    method: CulletPvsMethod,
    /// Where cameras may be, for `Proved` and `Sampled`, as a grid of cells; without a size, the
    /// bounds of all nodes.
    #[var]
    bounds: Aabb,
    /// About the size of a cell of the grid. Smaller ones hide more, and take longer.
    #[var]
    cell_size: Vector3,
    /// Cells for `Proved` and `Sampled` in place of the grid: rooms, say. They must not overlap.
    #[var]
    boxes: Array<Aabb>,
    /// Voxels along the longest side, for `Proved`: 2 to 512. Time and memory grow with the third
    /// power.
    #[var]
    voxels: i64,
    /// Side of a voxel of `Rooms`, which walls must be thicker than; 0 chooses one.
    #[var]
    voxel_size: f64,
    /// Rays of `Sampled`. More take longer and miss less.
    #[var]
    rays: i64,
    /// Nodes that are smaller than this along every axis hide nothing in the bake, so that they may
    /// move, come and go without a loss.
    #[var]
    smallest: f64,
    /// Threads; 0 for as many as there are cores.
    #[var]
    threads: i64,
    state: State,
    root: NodePath,
    error: GString,
    told: f32,
    result: Option<Gd<CulletPvs>>,
    base: Base<RefCounted>,
}

/// How far it is.
#[derive(Default)]
enum State {
    #[default]
    Idle,
    /// Meshes are being made.
    Gathers(Box<(Registry, Gd<Node>, Settings)>),
    Works(Arc<Progress>, JoinHandle<Result<Baked, BakeError>>),
}

#[godot_api]
impl IRefCounted for CulletPvsBaker {
    fn init(base: Base<RefCounted>) -> Self {
        Self {
            method: CulletPvsMethod::Rooms,
            bounds: Aabb::default(),
            cell_size: Vector3::new(8.0, 4.0, 8.0),
            boxes: Array::new(),
            voxels: 192,
            voxel_size: 0.0,
            rays: 50_000_000,
            smallest: 1.0,
            threads: 0,
            state: State::Idle,
            root: NodePath::default(),
            error: GString::new(),
            told: 0.0,
            result: None,
            base,
        }
    }
}

#[godot_api]
impl CulletPvsBaker {
    /// Rooms are found in closed walls, and the openings between them. Nothing that may be seen is
    /// missing.
    #[constant]
    const ROOMS: i64 = CulletPvsMethod::Rooms as i64;
    /// Boxes, from which is hidden what voxels inside of closed meshes prove hidden. Nothing that
    /// may be seen is missing; much that is hidden is kept.
    #[constant]
    const PROVED: i64 = CulletPvsMethod::Proved as i64;
    /// Boxes, from which is seen what sampled lines meet. Nodes that can be seen may be missing, and
    /// flicker.
    #[constant]
    const SAMPLED: i64 = CulletPvsMethod::Sampled as i64;

    /// More is done: a share of 0 to 1.
    #[signal]
    fn progressed(share: f32);

    /// The bake ended, with its result; null where it failed or was cancelled: see `get_error`.
    #[signal]
    fn finished(pvs: Option<Gd<CulletPvs>>);

    /// Begins to bake the nodes from `root` down, in the world of `world`, which will use the
    /// result. Returns false where that cannot be, or a bake runs.
    #[func]
    fn start(&mut self, world: Gd<CulletWorld>, root: Gd<Node>) -> bool {
        if self.is_running() {
            return false;
        }
        let (node, tree) = (world.upcast::<Node>(), tree());
        let Some((scenario, mut tree)) = scenario_of(&node).zip(tree) else {
            return self.refuse("the CulletWorld is in no world");
        };
        let settings = match self.settings() {
            Ok(settings) => settings,
            Err(why) => return self.refuse(&why),
        };
        let mut registry = Registry::default();
        registry.collect(&root, scenario);
        self.root = node.get_path_to(&root);
        self.error = GString::new();
        self.told = 0.0;
        self.result = None;
        self.state = State::Gathers(Box::new((registry, root, settings)));
        tree.connect("process_frame", &self.base().callable("poll"));
        true
    }

    /// Ends the bake. Nothing is kept of it.
    #[func]
    fn cancel(&mut self) {
        if self.is_running() {
            self.halt();
            self.end(Err(BakeError::Cancelled));
        }
    }

    /// Whether a bake runs.
    #[func]
    fn is_running(&self) -> bool {
        !matches!(self.state, State::Idle)
    }

    /// How much is done, 0 to 1.
    #[func]
    fn get_progress(&self) -> f32 {
        match &self.state {
            State::Works(progress, _) => progress.share(),
            _ => self.told,
        }
    }

    /// The result of the last bake; null while it runs, and where it failed or was cancelled.
    #[func]
    fn get_result(&self) -> Option<Gd<CulletPvs>> {
        self.result.clone()
    }

    /// Why the last bake has no result; empty where it has one.
    #[func]
    fn get_error(&self) -> GString {
        self.error.clone()
    }

    /// Takes over what threads did. Godot calls it in each frame while a bake runs.
    #[func]
    fn poll(&mut self) {
        match std::mem::take(&mut self.state) {
            State::Idle => {}
            State::Gathers(mut all) => {
                let mirror = &mut all.0.mirror;
                mirror.remove_freed();
                mirror.receive_meshes();
                if mirror.meshes.waiting() > 0 {
                    self.state = State::Gathers(all);
                    return;
                }
                match Self::begin(*all) {
                    Ok(state) => self.state = state,
                    Err(error) => self.end(Err(error)),
                }
            }
            State::Works(progress, thread) if thread.is_finished() => {
                drop(progress);
                match thread.join() {
                    Ok(result) => self.end(result),
                    Err(_) => self.end(Err(std::io::Error::other("a thread panicked").into())),
                }
            }
            State::Works(progress, thread) => {
                let share = progress.share();
                self.state = State::Works(progress, thread);
                if share > self.told {
                    self.told = share;
                    self.signals().progressed().emit(share);
                }
            }
        }
    }
}

impl CulletPvsBaker {
    fn settings(&self) -> Result<Settings, String> {
        let size = convert::point(self.cell_size);
        if !size.iter().all(|s| *s > 0.0 && s.is_finite()) {
            return Err(format!(
                "cell_size is {}; it must be above 0 on each axis",
                self.cell_size
            ));
        }
        if !(self.voxel_size >= 0.0 && self.voxel_size.is_finite()) {
            return Err(format!("voxel_size is {}; it must be 0, or a length", self.voxel_size));
        }
        if self.smallest.is_nan() {
            return Err("smallest is no number; it must be a length".into());
        }
        let region = |b: Aabb| [convert::point(b.position), convert::point(b.position + b.size)];
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Settings {
            method: match self.method {
                CulletPvsMethod::Rooms => Method::Rooms,
                CulletPvsMethod::Proved => Method::Proved,
                CulletPvsMethod::Sampled => Method::Sampled,
            },
            boxes: self.boxes.iter_shared().map(region).collect(),
            region: (self.bounds.size != Vector3::ZERO).then(|| region(self.bounds)),
            cell_size: size,
            voxels: self.voxels.clamp(0, 1 << 20) as u32,
            voxel: (self.voxel_size > 0.0).then_some(self.voxel_size),
            smallest: self.smallest,
            rays: self.rays.max(0) as u64,
            threads: if self.threads > 0 { self.threads.min(1024) as usize } else { cores },
        })
    }

    fn refuse(&mut self, why: &str) -> bool {
        self.error = GString::from(why);
        godot_warn!("baked visibility: {why}");
        false
    }

    /// Hands the nodes over to a thread.
    fn begin(
        (mut registry, root, settings): (Registry, Gd<Node>, Settings),
    ) -> Result<State, BakeError> {
        let is_there = root.is_instance_valid() && root.is_inside_tree();
        let gathered = if is_there {
            Gathered::new(&registry.mirror, &root, settings.smallest)
        } else {
            Gathered::default()
        };
        registry.clear();
        let progress = Arc::new(Progress::default());
        let own = Arc::clone(&progress);
        let name = std::thread::Builder::new().name("cullet pvs".into());
        let thread = name.spawn(move || work::bake(gathered, &settings, &own))?;
        Ok(State::Works(progress, thread))
    }

    /// Ends threads, and lets all nodes go.
    fn halt(&mut self) {
        match std::mem::take(&mut self.state) {
            State::Idle => {}
            State::Gathers(mut all) => all.0.clear(),
            State::Works(progress, thread) => {
                progress.cancel();
                let _ = thread.join();
            }
        }
    }

    fn end(&mut self, result: Result<Baked, BakeError>) {
        let poll = self.base().callable("poll");
        if let Some(mut tree) = tree()
            && tree.is_connected("process_frame", &poll)
        {
            tree.disconnect("process_frame", &poll);
        }
        self.result = match result {
            Ok(baked) => {
                self.told = 1.0;
                Some(CulletPvs::of(&baked, self.root.clone()))
            }
            Err(error) => {
                self.error = GString::from(&error.to_string());
                None
            }
        };
        let made = self.result.clone();
        self.signals().finished().emit(made.as_ref());
    }
}

impl Drop for CulletPvsBaker {
    fn drop(&mut self) {
        self.halt();
    }
}

fn tree() -> Option<Gd<SceneTree>> {
    Engine::singleton().get_main_loop()?.try_cast::<SceneTree>().ok()
}
