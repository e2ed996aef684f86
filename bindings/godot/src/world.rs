//! The node that people add.

use std::cell::RefCell;
use std::collections::HashMap;
use std::time::Instant;

use godot::classes::{Camera3D, Engine, INode, Node, Node3D, RenderingServer};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

use crate::frame::{Frame, Settings};
use crate::inbox::TreeSignals;
use crate::lights::Receivers;
use crate::mirror::Mirror;
use crate::pvs::resource::CulletPvs;
use crate::registry::{Follow, Registry};
use crate::watched::Watched;

/// Where shadows count that a camera may see.
#[derive(GodotConvert, Var, Export, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[godot(via = i64)]
pub(crate) enum ShadowReceivers {
    /// On nodes that a camera was found to see.
    #[default]
    Seen,
    /// Anywhere in a camera's picture: for scripts that draw by `RenderingServer`, without nodes.
    Anywhere,
}

/// Nodes that a preview in the editor looks at without a reason, as no frame does it in between.
const LOOKED_AT_IN_EDITOR: usize = 512;
/// All of these nodes.
const GROUP: &str = "cullet_worlds";

thread_local! {
    // By scenario: the node that culls it. Nodes live on the main thread.
    static WORLDS: RefCell<HashMap<Rid, InstanceId>> = RefCell::default();
}

/// Hides, in each frame, what no camera of its world can see behind other meshes. Add one anywhere
/// in a scene; it finds the rest by itself.
///
/// Nothing of a node's own properties is changed: what is hidden is told to Godot's server alone.
#[derive(GodotClass)]
#[class(tool, base = Node)]
pub struct CulletWorld {
    /// Off: everything is given back to Godot.
    #[export]
    #[var(set = set_enabled)]
    enabled: bool,
    /// Keep what the last frame hid and showed, to look at it from elsewhere. Nothing is followed
    /// meanwhile.
    #[export]
    frozen: bool,
    /// Hide what lies behind other meshes. Off: only what is outside of every camera's picture.
    #[export]
    occlusion: bool,
    /// Pixels across the buffer into which occluders are drawn. More find smaller gaps.
    #[export(range = (64.0, 4096.0, 1.0))]
    buffer_width: i64,
    /// Microseconds that drawing occluders may take, by the engine's model.
    #[export(range = (0.0, 10000.0, 1.0))]
    budget: f32,
    /// Also hide what casts shadows that no camera sees.
    #[export]
    shadow_casters: bool,
    /// Also hide omni and spot lights without shadows whose reach holds nothing that is seen.
    #[export]
    lamps: bool,
    /// Where shadows count.
    #[export]
    shadow_receivers: ShadowReceivers,
    /// How movement is followed.
    #[export]
    follow: Follow,
    /// Baked visibility: what the cell of a camera cannot see is hidden before anything else is
    /// asked. Each is of the scene whose root it names, and holds for the nodes that are still what
    /// they were.
    #[export]
    pvs: Array<Option<Gd<CulletPvs>>>,
    registry: Registry,
    frame: Frame,
    tree_signals: TreeSignals,
    watched: Watched,
    is_connected: bool,
    has_warned: bool,
    base: Base<Node>,
}

#[godot_api]
impl INode for CulletWorld {
    fn init(base: Base<Node>) -> Self {
        Self {
            enabled: true,
            frozen: false,
            occlusion: true,
            buffer_width: 640,
            budget: 200.0,
            shadow_casters: true,
            lamps: true,
            shadow_receivers: ShadowReceivers::Seen,
            follow: Follow::Auto,
            pvs: Array::new(),
            registry: Registry::default(),
            frame: Frame::default(),
            tree_signals: TreeSignals::default(),
            watched: Watched::default(),
            is_connected: false,
            has_warned: false,
            base,
        }
    }

    fn enter_tree(&mut self) {
        self.base_mut().add_to_group(GROUP);
        if Engine::singleton().is_editor_hint() {
            return;
        }
        if let Some(mut tree) = self.base().get_tree_or_null() {
            let inbox = self.registry.mirror.inbox.clone();
            self.tree_signals.connect(&mut tree, &inbox);
        }
        let callable = self.base().callable("cull_now");
        RenderingServer::singleton().connect("frame_pre_draw", &callable);
        self.is_connected = true;
    }

    fn exit_tree(&mut self) {
        self.leave();
        if std::mem::take(&mut self.is_connected) {
            let callable = self.base().callable("cull_now");
            RenderingServer::singleton().disconnect("frame_pre_draw", &callable);
        }
        if let Some(mut tree) = self.base().get_tree_or_null() {
            self.tree_signals.disconnect(&mut tree);
        }
    }

    fn process(&mut self, _delta: f64) {
        if self.enabled && !Engine::singleton().is_editor_hint() {
            self.registry.add_some_movers(self.follow);
        }
    }

    fn get_configuration_warnings(&self) -> PackedStringArray {
        self.get_configuration_warnings_now()
    }
}

#[godot_api]
impl CulletWorld {
    /// A watched node came into the sight of a camera, or left it: emitted after the frame in which
    /// it was found.
    #[signal]
    pub(crate) fn sight_changed(camera: Gd<Camera3D>, node: Gd<Node3D>, is_seen: bool);

    /// Switches culling on or off, as `enabled` does.
    #[func]
    fn set_enabled(&mut self, enabled: bool) {
        self.enabled = enabled;
        if !enabled {
            self.registry.mirror.show_all();
            self.registry.dark.give_back();
        }
    }

    /// Looks at the whole tree again. Never needed for what Godot reports; see the documentation
    /// for what it does not.
    #[func]
    fn rebuild(&mut self) {
        self.leave();
    }

    /// Culls now. Godot calls it before each frame; scripts need it where nothing is drawn, as in
    /// a headless test.
    #[func]
    fn cull_now(&mut self) {
        if !self.enabled || self.frozen || !self.join() {
            return;
        }
        let clock = Instant::now();
        let tree = self.base().get_tree_or_null();
        let is_interpolated = tree.is_some_and(|tree| tree.is_physics_interpolation_enabled());
        self.registry.mirror.is_interpolated = is_interpolated;
        self.registry.follow(self.follow);
        let us = clock.elapsed().as_secs_f64() * 1e6;
        let settings = self.settings();
        self.registry.pvs.bind(&self.pvs, &self.base().clone());
        self.frame.run(&mut self.registry, settings, us);
        let changes = self.watched.changes(&self.registry.mirror, &self.frame);
        for change in changes {
            // Scripts run when the frame is done.
            let arguments = vslice![change.camera.to_i64(), change.node.to_i64(), change.is_seen];
            self.base_mut().call_deferred("tell_sight", arguments);
        }
    }

    /// Says that `node` may draw something else than before: its material lost its depth test, say,
    /// or vertices of its mesh were written in place. Most changes need no call: what Godot
    /// reports, and changed materials of nodes that hide others.
    #[func]
    fn refresh(&mut self, node: Gd<Node3D>) {
        self.registry.mirror.refresh(node.instance_id());
    }

    /// Returns the warnings that the editor shows beside the node.
    #[func]
    fn get_configuration_warnings_now(&self) -> PackedStringArray {
        self.second_warning().iter().map(GString::from).collect()
    }

    /// Counts and times, in microseconds, of the last frame.
    #[func]
    fn statistics(&self) -> VarDictionary {
        let s = &self.frame.stats;
        let number = |n: usize| n as i64;
        let us: f64 = s.us.iter().sum();
        vdict! {
            "instances" => number(s.instances),
            "cameras" => number(s.cameras),
            "visible" => number(s.visible),
            "shadow_only" => number(s.shadow_only),
            "gone" => number(s.gone),
            "changed" => number(s.changed),
            "occluders" => number(s.occluders),
            "dark_lamps" => number(s.dark),
            "pvs_hidden" => number(s.pvs.hidden),
            "pvs_cameras" => number(s.pvs.cameras),
            "pvs_stale" => number(s.pvs.stale),
            "again" => number(s.again),
            "waiting" => number(self.registry.mirror.meshes.waiting()),
            "us" => us,
            "us_follow" => s.us[0],
            "us_cull" => s.us[1],
            "us_casters" => s.us[2],
            "us_tell" => s.us[3],
        }
    }
}

impl CulletWorld {
    pub(crate) fn mirror(&self) -> &Mirror {
        &self.registry.mirror
    }

    pub(crate) fn registry(&self) -> &Registry {
        &self.registry
    }

    pub(crate) fn frame(&self) -> &Frame {
        &self.frame
    }

    pub(crate) fn settings(&self) -> Settings {
        let width = self.buffer_width.clamp(1, 4096) as u32;
        let budget = if self.budget >= 0.0 { self.budget } else { 0.0 };
        Settings {
            occlusion: self.occlusion.then_some((width, budget)),
            casters: self.shadow_casters,
            lamps: self.lamps,
            pvs: true,
            receivers: match self.shadow_receivers {
                ShadowReceivers::Seen => Receivers::Seen,
                ShadowReceivers::Anywhere => Receivers::Anywhere,
            },
        }
    }

    /// Brings what is followed up to date outside of a frame, in the editor too. Returns what is
    /// followed; `None` where another node culls this world, or there is none.
    pub(crate) fn up_to_date(&mut self) -> Option<&mut Registry> {
        let is_editor = Engine::singleton().is_editor_hint();
        if is_editor && !self.tree_signals.is_connected() {
            let mut tree = self.base().get_tree_or_null()?;
            let inbox = self.registry.mirror.inbox.clone();
            self.tree_signals.connect(&mut tree, &inbox);
        }
        if !self.join() {
            return None;
        }
        if !is_editor {
            self.registry.follow(self.follow);
        } else {
            // Nodes of an edited scene get no child, and what is edited shows soon.
            self.registry.follow(Follow::Ask);
            self.registry.look_in_turn(LOOKED_AT_IN_EDITOR);
            self.registry.mirror.settle();
        }
        self.registry.pvs.bind(&self.pvs, &self.base().clone());
        Some(&mut self.registry)
    }

    pub(crate) fn watched_mut(&mut self) -> &mut Watched {
        &mut self.watched
    }

    /// Begins to follow the world that the node is in. Returns false where another node does.
    fn join(&mut self) -> bool {
        let node = self.base().clone();
        let scenario = scenario_of(&node);
        if scenario.is_some() && scenario == self.registry.world() {
            return true;
        }
        self.leave();
        let (Some(scenario), Some(tree)) = (scenario, node.get_tree_or_null()) else {
            return false;
        };
        let own = node.instance_id();
        let is_first = WORLDS.with_borrow_mut(|worlds| {
            let holder = *worlds.entry(scenario).or_insert(own);
            let is_there = holder == own || Gd::<Node>::try_from_instance_id(holder).is_ok();
            if !is_there {
                worlds.insert(scenario, own);
            }
            holder == own || !is_there
        });
        if !is_first {
            if let Some(warning) = self.second_warning().filter(|_| !self.has_warned) {
                godot_warn!("{warning}");
                self.has_warned = true;
            }
            return false;
        }
        // The editor's own nodes are no part of the scene.
        let root = match Engine::singleton().is_editor_hint() {
            true => tree.get_edited_scene_root(),
            false => tree.get_root().map(Gd::upcast),
        };
        let Some(root) = root else { return false };
        self.registry.collect(&root, scenario);
        true
    }

    /// Gives everything back.
    fn leave(&mut self) {
        let own = self.base().instance_id();
        WORLDS.with_borrow_mut(|worlds| worlds.retain(|_, holder| *holder != own));
        self.registry.clear();
        self.frame = Frame::default();
    }

    /// Returns what is wrong where the world has another of these nodes before this one.
    fn second_warning(&self) -> Option<String> {
        let own = self.base().clone();
        let scenario = scenario_of(&own)?;
        let all = own.get_tree_or_null()?.get_nodes_in_group(GROUP);
        let first = all.iter_shared().find(|node| scenario_of(node) == Some(scenario))?;
        (first != own).then(|| {
            let path = first.get_path();
            format!("This world has a CulletWorld already, {path}: only one culls. Remove either.")
        })
    }
}

/// Returns the scenario of the world that a node is in.
pub(crate) fn scenario_of(node: &Gd<Node>) -> Option<Rid> {
    let world = node.get_viewport()?.find_world_3d()?;
    Some(world.get_scenario())
}
