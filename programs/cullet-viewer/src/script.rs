//! Runs without a user, for tests and for showing: one throws every switch, one gives every order.

use cullet_scenes::paths::PathSpec;

use crate::link;
use crate::session::Session;
use crate::state::State;

/// A run without a user.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Script {
    /// Nothing.
    #[default]
    None,
    /// Every switch is thrown.
    Toggles,
    /// Every order is given: all that a button begins and that leaves something behind.
    Orders,
    /// The graphics device is lost.
    Lose,
}

/// One step; the next follows when all is settled.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// The switches of a part of a link.
    Throw(&'static str),
    /// An order, by its name.
    Order(&'static str, fn(&mut Session)),
    /// The graphics device goes away.
    Lose,
}

impl Script {
    /// Parses its name on a command line.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        match name {
            "toggles" => Some(Self::Toggles),
            "orders" => Some(Self::Orders),
            "lose-device" => Some(Self::Lose),
            _ => None,
        }
    }

    /// Its steps.
    #[must_use]
    pub fn steps(self) -> Vec<Step> {
        match self {
            Self::None => Vec::new(),
            Self::Toggles => TOGGLES.iter().map(|toggle| Step::Throw(toggle)).collect(),
            Self::Orders => ORDERS.iter().map(|(name, order)| Step::Order(name, *order)).collect(),
            Self::Lose => vec![Step::Lose],
        }
    }
}

/// An order, by its name.
pub type Order = (&'static str, fn(&mut Session));

/// All that a button begins and that leaves something behind.
pub const ORDERS: &[Order] = &[
    ("copy the link", Session::copy_link),
    ("copy the funnel", Session::copy_funnel),
    ("save a picture", |s| s.shoot = true),
    ("verify", Session::prove),
    ("show portals", |s| s.step_portals(1)),
    ("open or shut one", Session::toggle_nearest_portal),
    ("bake what sees what", Session::bake_cells),
    ("take a path", |s| s.travel(PathSpec::Orbit)),
    ("measure it", Session::measure),
    ("copy the path", Session::copy_path),
    #[cfg(not(target_arch = "wasm32"))]
    ("make a report", Session::make_report),
];

/// Parts of links, each of which throws a switch: every setting of a state is among them.
pub const TOGGLES: &[&str] = &[
    "stages.on=false",
    "stages.frustum=false",
    "stages.frustum_exact=true",
    "stages.portal=false",
    "stages.backface=off",
    "stages.backface=exact&stages.depth=triangles",
    "stages.degenerate=false",
    "stages.detail_px=4",
    "stages.detail_px=16&stages.detail_by=area",
    "stages.detail_px=4&stages.detail_by=diameter",
    "stages.lod_px=2",
    "stages.detail_px=8&stages.detail_fade=1",
    "stages.lod_px=1&stages.lod_corners=true&stages.lod_steady=true",
    "stages.lod_px=4&stages.lod_fade=0.2&stages.lod_impostors=false",
    "stages.lod_px=1&stages.lod_steady=true&stages.lod_ball=0.2&stages.lod_triangles=5000",
    "stages.occlusion=false",
    "stages.occlusion_width=64",
    "stages.occlusion_budget=0",
    "stages.occlusion_width=1280&stages.occlusion_budget=20000",
    "device.on=true",
    "device.on=true&layout=wipe&device.compare=true",
    "device.on=true&layout=buffer&device.level=3",
    "device.on=true&look.fine=true&look.wireframe=true&stages.occlusion=false&always=true",
    "sides=one-sided",
    "sides=two-sided",
    "stages.depth=instances",
    "stages.depth=triangles",
    "look.colour=reason",
    "look.colour=sides",
    "look.colour=clusters",
    "look.colour=overdraw",
    "look.colour=levels&stages.lod_px=1",
    "look.colour=pops&stages.detail_px=4",
    "look.colour=size",
    "look.colour=depth",
    "look.fill=false&look.wireframe=true",
    "look.wireframe=true",
    "look.cull=none",
    "look.cull=front",
    "look.cull=back&look.hardware=true",
    "look.clockwise=true",
    "look.face_normals=true",
    "look.vertex_normals=true",
    "look.fine=true",
    "layout=split",
    "layout=wipe&wipe=0.3",
    "layout=buffer",
    "layout=buffer&structure.tiles=true",
    "layout=buffer&stages.occlusion=false",
    "structure.buffer=true",
    "structure.buffer=true&structure.tiles=true&camera.mode=top",
    "structure.occluders=true",
    "frozen.distance=30&layout=split&structure.occluders=true&structure.buffer=true",
    "panels=false",
    "map=false",
    "ghosts.form=boxes",
    "ghosts.form=solid",
    "ghosts.form=solid&ghosts.hidden=[\"frustum\"]",
    "structure.level=1",
    "structure.level=9&structure.cones=true",
    "structure.volume=true",
    "structure.outcodes=true",
    "structure.audit=true",
    "structure.cells=true&layout=split",
    "structure.portals=true",
    "structure.portals=true&structure.step=2&layout=split",
    "structure.portals=true&doors=[0,3]",
    "study.cube=true",
    "study.cube=true&study.cells=16&study.by=masks&study.groups=64",
    "study.by=cones",
    "study.by=elliptic",
    "study.by=boxes",
    "study.by=pyramids&structure.cones=true",
    "cut.on=true",
    "cut.on=true&cut.normal=[0,1,0]&cut.at=-0.5&cut.part=outside",
    "cut.on=true&cut.normal=[1,0.5,0.2]&cut.caps=false",
    "cut.on=true&cut.outlines=false&cut.shape=box&cut.low=[0,-1.05,0]&cut.high=[1.05,1.05,1.05]&cut.part=outside",
    "clipping.open=true",
    "clipping.open=true&clipping.step=3&clipping.sides=6&clipping.polygon=[[-0.9,-0.9],[0.9,-0.9],[0,0.9]]",
    "frozen.target=[0,0,0]&frozen.distance=30",
    "frozen.distance=30&layout=split&ghosts.form=boxes",
    "frozen.distance=30&layout=wipe&ghosts.form=solid",
    "camera.mode=fly",
    "camera.mode=top&camera.distance=200",
    "always=true",
    "hover_turns=true",
    "dark=false",
    "scene=city",
];

/// The state with the switches of a part of a link thrown. What the part says of no camera leaves
/// the present one.
#[must_use]
pub fn thrown(state: &State, toggle: &str) -> Option<State> {
    let mut thrown = link::from_text(toggle).ok()?;
    thrown.scene.clone_from(&state.scene);
    if thrown.camera.is_none() {
        thrown.camera = state.camera;
    }
    Some(thrown)
}
