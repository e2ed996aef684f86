//! Composes the panes to draw of a session, with lines and ghosts. It neither decides nor draws.

use cullet::{Depth, Reason, Stage, View, Visible, draw::SlotRange, view::CullFace};
use cullet_draw::palette;
use glam::DVec3;

use crate::cell_lines;
use crate::draw::{Paint, Pane, Style};
use crate::fades::share_by_size;
use crate::levels_alone::is_dropped;
use crate::lines::{Lines, tint};
use crate::session::Session;
use crate::state::{Colour, GhostForm, Layout, Look, Part};
use crate::structure;
use crate::study::Seen;

/// More ghosts than these are a haze.
pub const MOST_GHOSTS: usize = 6_000;

/// Role of a pane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The flown camera's picture.
    Flown,
    /// The culling camera's picture, beside the flown one's.
    Culling,
    /// From outside, following.
    Outside,
    /// The part of a wipe that is not culled.
    Bare,
    /// True depth of what the culling camera sees.
    Depth,
}

/// The part of the scene that a pane draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// The visible set of the culler.
    Kept,
    /// Instances that the graphics device finds visible.
    OnDevice,
    /// That, and ghosts as they are.
    WithGhosts,
    /// The occluders that were drawn into the occlusion buffer.
    Occluders,
    /// All.
    All,
}

/// A pane with its own data.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Its role.
    pub role: Role,
    /// Where it is: x, y, width, height in pixels.
    pub place: [u32; 4],
    /// Its view.
    pub view: View,
    content: Content,
    style: Style,
    /// Whether levels of detail fade in it.
    fades: bool,
    lines: Lines,
    overlay: Lines,
    ghosts: Lines,
}

/// All panes of a picture.
#[derive(Clone, Debug, Default)]
pub struct Composition {
    /// From the bottom up.
    pub panels: Vec<Panel>,
    /// The view that the graphics device decides for, where it does.
    pub by_device: Option<View>,
    /// The visible set, with the ghosts that are drawn as they are.
    with_ghosts: Visible,
    /// The occluders that were drawn into the occlusion buffer.
    occluders: Visible,
    /// Levels of detail that go, while others fade in.
    going: Visible,
    /// How many ghosts were left out because there are too many.
    pub ghosts_left_out: usize,
    /// Counts of the test results of the boxes of the level that is shown.
    pub tally: structure::LevelTally,
    /// How many cones are shown, of how many clusters.
    pub cones: [usize; 2],
    /// Whether the cluster that was clicked has a culling volume, where it is tested.
    pub volume: Option<bool>,
}

impl Composition {
    /// The panes for a renderer.
    #[must_use]
    pub fn panes<'a>(&'a self, kept: Option<&'a Visible>) -> Vec<Pane<'a>> {
        let mut panes = Vec::with_capacity(self.panels.len());
        for p in &self.panels {
            let mut pane = Pane {
                place: p.place,
                view: &p.view,
                visible: match p.content {
                    Content::All => None,
                    Content::Kept | Content::OnDevice => kept,
                    Content::WithGhosts => Some(&self.with_ghosts),
                    Content::Occluders => Some(&self.occluders),
                },
                on_device: p.content == Content::OnDevice,
                style: p.style,
                over: false,
                lines: &p.lines.0,
                overlay: &p.overlay.0,
                ghosts: &p.ghosts.0,
            };
            if p.fades {
                // What is translucent comes after both.
                panes.push(Pane { lines: &[], overlay: &[], ghosts: &[], ..pane });
                pane.style.going = true;
                (pane.visible, pane.over) = (Some(&self.going), true);
            }
            panes.push(pane);
        }
        panes
    }

    /// The topmost pane at a pixel.
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<&Panel> {
        self.panels.iter().rev().find(|p| {
            let [left, top, width, height] = p.place.map(f64::from);
            x >= left && x < left + width && y >= top && y < top + height
        })
    }
}

/// Composes the picture of a session; nothing without a scene or a camera.
#[must_use]
pub fn compose(session: &Session) -> Composition {
    let mut made = Composition::default();
    let (Some(_), Some(flown)) = (&session.world, &session.state.camera) else { return made };
    let [w, h] = session.size;
    let half = (w / 2).max(1);
    let state = &session.state;
    let frozen = state.frozen.is_some();
    // The decision's own view, so that the picture and what was decided for it always fit. The
    // device decides for the picture itself.
    let by_device = session.by_device();
    made.by_device = session.culling_view().filter(|_| by_device);
    let decided = match by_device {
        true => made.by_device.clone(),
        false => session.decision.as_ref().map(|d| d.request.view.clone()),
    };
    let culling = |size: [u32; 2]| {
        let ready = decided.clone().filter(|v| v.viewport() == size);
        ready.or_else(|| session.culling_rig()?.view(size).ok())
    };
    let free = |size: [u32; 2]| if frozen { flown.view(size).ok() } else { culling(size) };
    let mut add = |role, place: [u32; 4], view: Option<View>| {
        if let Some(view) = view.filter(|_| place[2] > 0 && place[3] > 0) {
            let stages = &state.stages;
            let fade = stages.on && stages.detail_px > 0.0 && stages.detail_fade > 0.0;
            let style = Style { fade, ..style(&state.look) };
            let (lines, overlay, ghosts) = Default::default();
            let content = Content::Kept;
            let fades = false;
            let panel = Panel { role, place, view, content, style, fades, lines, overlay, ghosts };
            made.panels.push(panel);
        }
    };
    match state.layout {
        Layout::One => add(Role::Flown, [0, 0, w, h], free([w, h])),
        Layout::Split => {
            let right = w.saturating_sub(half).max(1);
            add(Role::Culling, [0, 0, half, h], culling([half, h]));
            if frozen {
                add(Role::Flown, [half, 0, right, h], flown.view([right, h]).ok());
            } else {
                let outside = session.outside().and_then(|r| r.view([right, h]).ok());
                add(Role::Outside, [half, 0, right, h], outside);
            }
        }
        Layout::Buffer => add(Role::Depth, [0, 0, half, h], culling([half, h])),
        Layout::Wipe => {
            let at = ((f64::from(state.wipe) * f64::from(w)) as u32).min(w);
            let whole = free([w, h]);
            let part = |from, to| whole.as_ref().and_then(|v| columns(v, from, to));
            if by_device {
                // Of the view that it is decided for; what is beside it is drawn over it.
                add(Role::Flown, [0, 0, w, h], whole.clone());
            } else {
                add(Role::Flown, [0, 0, at, h], part(0, at));
            }
            add(Role::Bare, [at, 0, w - at, h], part(at, w));
        }
    }
    decorate(session, &mut made);
    made
}

/// Converts a look to the renderer's style.
fn style(look: &Look) -> Style {
    Style {
        paint: match look.colour {
            Colour::Material => Paint::Material,
            Colour::Reason | Colour::Pops => Paint::Instances,
            Colour::Sides => Paint::Sides,
            Colour::Clusters => Paint::Clusters,
            Colour::Overdraw => Paint::Overdraw,
            Colour::Size => Paint::TriangleSize,
            Colour::Depth => Paint::Depth,
            Colour::Levels => Paint::Levels,
        },
        fill: look.fill,
        wireframe: look.wireframe,
        cull_face: if look.hardware { look.cull } else { CullFace::None },
        clockwise: look.clockwise,
        face_normals: look.face_normals,
        vertex_normals: look.vertex_normals,
        fade: false,
        going: false,
        samples: if look.fine { 4 } else { 1 },
    }
}

/// The part of a view between two columns of its picture.
fn columns(view: &View, from: u32, to: u32) -> Option<View> {
    let [w, h] = view.viewport();
    let ndc = |x: u32| f64::from(x) / f64::from(w) * 2.0 - 1.0;
    let (a, b) = (ndc(from), ndc(to));
    let mut m = view.clip_from_world();
    for column in m.chunks_exact_mut(4) {
        column[0] = (2.0 * column[0] - (a + b) * column[3]) / (b - a);
    }
    let mut part = View::from_matrix(m, Depth::Reversed, [to.checked_sub(from)?, h]).ok()?;
    (part.cull_face, part.front_face) = (view.cull_face, view.front_face);
    Some(part)
}

fn decorate(session: &Session, made: &mut Composition) {
    let Some(world) = &session.world else { return };
    let scene = &world.model.scene;
    let state = &session.state;
    let decision = session.decision.as_ref();
    let view = decision.map(|d| &d.request.view);
    let visible = decision.map(|d| &d.visible);
    let reasons = visible.map_or(&[][..], |v| &v.reasons);
    let solid = state.ghosts.form == GhostForm::Solid;
    let occluders = decision.filter(|_| state.structure.occluders).map(|d| &d.occluders);
    for &slot in occluders.into_iter().flatten() {
        made.occluders.whole.push(SlotRange { first: slot, count: 1 });
    }
    if solid && let Some(visible) = visible {
        made.with_ghosts = with_ghosts(session, visible);
    }
    made.going.clone_from(session.fades.going());
    let mut boxes = Lines::default();
    if state.ghosts.form == GhostForm::Boxes {
        let dropped = reasons.iter().enumerate().filter_map(|(slot, r)| Some((slot as u32, (*r)?)));
        let dropped = dropped.filter(|&(slot, reason)| is_dropped(scene, slot, reason));
        let shown = dropped.filter(|(_, r)| !session.hides(r.stage.name()));
        for (i, (slot, reason)) in shown.enumerate() {
            if i < MOST_GHOSTS {
                let colour = palette::reason_color(Some(reason.stage));
                boxes.edges(&scene.bounds(slot), scene.origin(), tint(colour, 150));
            } else {
                made.ghosts_left_out += 1;
            }
        }
    }
    let mut marks = Lines::default();
    let mut cones = Lines::default();
    if let Some(view) = view {
        made.tally = structure::hierarchy(scene, view, state.structure.level, &mut boxes);
        if let (true, Some(i)) = (state.structure.cones, &session.inspected) {
            made.cones = structure::cones(scene, view, i.slot, &mut cones);
        }
    }
    if let Some(inspected) = &session.inspected {
        marks.edges(&scene.bounds(inspected.slot), scene.origin(), [255, 255, 255, 255]);
        triangle(session, inspected.slot, inspected.triangle, &mut marks);
        let by = palette::reason_color(Some(Stage::Occlusion));
        for &slot in inspected.explanation.hidden_by.iter().take(MOST_GHOSTS) {
            marks.edges(&scene.bounds(slot), scene.origin(), tint(by, 255));
        }
    }
    let mut sides = Lines::default();
    made.volume = study(session, &mut marks, &mut sides);
    if state.structure.audit {
        session.audit.draw(scene, MOST_GHOSTS, &mut marks);
    }
    if let Some(found) = session.truth.finding() {
        for &slot in found.lost.iter().take(MOST_GHOSTS) {
            marks.edges(&scene.bounds(slot), scene.origin(), tint(palette::LOST, 255));
        }
    }
    let mut frustum = (Lines::default(), Lines::default());
    if let Some(view) = view {
        let colour = if state.dark { [255, 255, 255, 230] } else { [20, 24, 30, 230] };
        frustum.0.frustum(view, world.reach * 0.9, colour, &mut frustum.1);
    }
    let mut path = Lines::default();
    if let Some(costs) = session.measured.costs() {
        for pair in costs.all.windows(2) {
            let ends = [&pair[0], &pair[1]].map(|c| DVec3::from(c.eye));
            path.line(ends[0], ends[1], tint(costs.colour(&pair[1]), 255));
        }
    }
    let mut rooms = (Lines::default(), Lines::default());
    cell_lines::draw(session, &mut rooms.0, &mut rooms.1);
    let by_reason = state.look.colour == Colour::Reason;
    let by_device = made.by_device.is_some();
    for panel in &mut made.panels {
        panel.content = match panel.role {
            Role::Bare if by_device && state.device.compare => Content::Kept,
            Role::Bare => Content::All,
            // The culling camera's own picture shows the visible set as it is drawn.
            Role::Culling | Role::Depth => Content::Kept,
            _ if solid && decision.is_some() => Content::WithGhosts,
            _ => Content::Kept,
        };
        if !state.stages.on {
            panel.content = Content::All;
        }
        if panel.role != Role::Bare && occluders.is_some() {
            panel.content = Content::Occluders;
        }
        panel.fades = !session.fades.is_empty()
            && matches!(panel.content, Content::Kept | Content::WithGhosts);
        panel.style.fade |= panel.fades;
        let lines = panel.style.face_normals || panel.style.vertex_normals;
        let is_plain = panel.content == Content::Kept && !panel.fades && !lines;
        if by_device && is_plain && panel.role != Role::Bare {
            panel.content = Content::OnDevice;
        }
        let from_outside = match panel.role {
            Role::Outside => true,
            Role::Flown | Role::Bare => state.frozen.is_some(),
            Role::Culling | Role::Depth => false,
        };
        if from_outside {
            // Seen from outside, the visible set shows its backs too: they face away from here, not
            // from the culling camera.
            panel.view.cull_face = CullFace::None;
            panel.overlay.0.extend_from_slice(&path.0);
            panel.overlay.0.extend_from_slice(&rooms.0.0);
            panel.ghosts.0.extend_from_slice(&rooms.1.0);
            panel.overlay.0.extend_from_slice(&frustum.0.0);
            panel.ghosts.0.extend_from_slice(&frustum.1.0);
        }
        match panel.role {
            Role::Bare | Role::Culling => {}
            Role::Depth => panel.style.paint = Paint::Depth,
            Role::Flown | Role::Outside => {
                if (solid || by_reason) && panel.style.paint == Paint::Material {
                    panel.style.paint = Paint::Instances;
                }
                panel.lines.0.extend_from_slice(&boxes.0);
            }
        }
        panel.lines.0.extend_from_slice(&cones.0);
        panel.overlay.0.extend_from_slice(&marks.0);
        panel.ghosts.0.extend_from_slice(&sides.0);
        outlines(session, &panel.view, &mut panel.overlay);
    }
}

/// The back faces that a bound proves of what is inspected, the culling volume of the cluster that
/// was clicked, and the outcodes of its triangle. Returns whether there is such a volume.
fn study(session: &Session, lines: &mut Lines, sides: &mut Lines) -> Option<bool> {
    let (world, inspected) = (session.world.as_ref()?, session.inspected.as_ref()?);
    let view = &session.decision.as_ref()?.request.view;
    let scene = &world.model.scene;
    let (mesh, transform) = (scene.mesh(inspected.slot), scene.transform(inspected.slot));
    let seen = Seen { mesh, transform, view };
    if let Some(figures) = &session.figures {
        let violet = palette::reason_color(Some(Stage::Backface));
        seen.faces(&figures.proved, tint(violet, 150), sides);
    }
    let structure = &session.state.structure;
    if let Some(coded) = session.coded().filter(|_| structure.outcodes) {
        let b = scene.bounds(inspected.slot);
        let middle = DVec3::from(b.center()) + DVec3::from(scene.origin());
        // Squares beside a ground would cover all else.
        let radius = DVec3::from(b.half_extent()).length().min(world.reach * 0.15);
        coded.draw(middle, radius, lines, sides);
    }
    let t = mesh.original_triangle().iter().position(|&o| o == inspected.triangle)? as u32;
    let cluster = mesh.clusters().iter().position(|c| c.triangles().contains(&t))?;
    structure.volume.then(|| seen.volume(cluster, lines, sides))
}

/// The outlines of the cut, of planes whose cut side is in sight: from behind there is scene
/// between.
fn outlines(session: &Session, view: &View, lines: &mut Lines) {
    let inside = session.state.cut.part == Part::Inside;
    let ink = if session.state.dark { palette::CHALK } else { palette::INK };
    let [x, y, z, w] = view.eye();
    for outline in &session.cutting.outlines {
        let (n, d) = (DVec3::from(outline.plane.normal), outline.plane.d);
        // Homogeneous: of a parallel view, its direction.
        if (n.dot(DVec3::new(x, y, z)) - d * w > 0.0) == inside {
            let points = outline.points.iter().map(|p| DVec3::from(*p));
            let next = points.clone().cycle().skip(1);
            points.zip(next).for_each(|(a, b)| lines.line(a, b, tint(ink, 255)));
        }
    }
}

/// The edges of a triangle by its original number.
fn triangle(session: &Session, slot: u32, original: u32, lines: &mut Lines) {
    let Some(world) = &session.world else { return };
    let (mesh, transform) = (world.model.scene.mesh(slot), world.model.scene.transform(slot));
    let Some(t) = mesh.original_triangle().iter().position(|&o| o == original) else { return };
    let linear = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
    let corners = mesh.corners(t as u32).map(|p| {
        let p = p.map(f64::from);
        linear[0] * p[0] + linear[1] * p[1] + linear[2] * p[2] + DVec3::from(transform.translation)
    });
    for i in 0..3 {
        lines.line(corners[i], corners[(i + 1) % 3], [255, 255, 255, 255]);
    }
}

/// Adds to the visible set, whole, the culled instances whose reasons are not switched off.
fn with_ghosts(session: &Session, visible: &Visible) -> Visible {
    let mut shown = Visible { partial: visible.partial.clone(), ..Visible::default() };
    let mut whole =
        visible.whole.iter().copied().flat_map(|r| r.first..r.first + r.count).peekable();
    let scene = session.world.as_ref().map(|world| &world.model.scene);
    let hidden: Vec<Stage> = Stage::ALL.into_iter().filter(|s| session.hides(s.name())).collect();
    let is_ghost = |slot: u32, reason: Reason| {
        !hidden.contains(&reason.stage) && scene.is_some_and(|s| is_dropped(s, slot, reason))
    };
    for (slot, reason) in visible.reasons.iter().enumerate() {
        let slot = slot as u32;
        let kept = whole.next_if_eq(&slot).is_some();
        if kept || reason.is_some_and(|r| is_ghost(slot, r)) {
            match shown.whole.last_mut() {
                Some(r) if r.first + r.count == slot => r.count += 1,
                _ => shown.whole.push(SlotRange { first: slot, count: 1 }),
            }
        }
    }
    shown
}

/// The colour of each slot: why it was dropped; of what was kept, whether the proof saw it.
#[must_use]
pub fn instance_colours(session: &Session) -> Vec<[u8; 4]> {
    let Some(world) = &session.world else { return Vec::new() };
    let count = world.model.scene.slot_count() as usize;
    let Some(decision) = &session.decision else {
        return vec![tint(palette::SEEN, 255); count];
    };
    // The proof tells of the view that it was made for.
    let view = Some(&decision.request.view);
    let proof = session.truth.finding().filter(|f| f.view.as_ref() == view);
    let colour = |slot: usize| {
        let reason = decision.visible.reasons.get(slot).copied().flatten();
        match reason {
            Some(reason) => palette::reason_color(Some(reason.stage)),
            None if proof.is_some_and(|p| p.unseen.get(slot) == Some(&true)) => palette::UNSEEN,
            None => palette::SEEN,
        }
    };
    if session.state.look.colour == Colour::Pops {
        return fading(session, faded(session, popped(session, count)));
    }
    let mut colours: Vec<[u8; 4]> = (0..count).map(|slot| tint(colour(slot), 255)).collect();
    for &slot in proof.map_or(&[][..], |p| &p.lost) {
        if let Some(c) = colours.get_mut(slot as usize) {
            *c = tint(palette::LOST, 255);
        }
    }
    fading(session, faded(session, colours))
}

/// The colours of what came and what changed since the picture before.
const CAME: [u8; 4] = [40, 190, 110, 255];
const CHANGED: [u8; 4] = [240, 140, 30, 255];
const STAYED: [u8; 4] = [170, 172, 176, 255];

/// The colour of each slot by what popped.
fn popped(session: &Session, count: usize) -> Vec<[u8; 4]> {
    let mut colours = vec![STAYED; count];
    for (slots, colour) in [(&session.pops.changed, CHANGED), (&session.pops.came, CAME)] {
        for &slot in slots {
            if let Some(c) = colours.get_mut(slot as usize) {
                *c = colour;
            }
        }
    }
    colours
}

/// Colours with the share by which each instance that is kept is drawn, as alpha.
fn faded(session: &Session, mut colours: Vec<[u8; 4]>) -> Vec<[u8; 4]> {
    let (Some(world), Some(decision)) = (&session.world, &session.decision) else { return colours };
    let (scene, view) = (&world.model.scene, &decision.request.view);
    let Some(detail) = decision.request.culler.detail.filter(|detail| detail.fade > 0.0) else {
        return colours;
    };
    for (slot, colour) in (0..).zip(&mut colours) {
        let reason = decision.visible.reasons.get(slot as usize).copied().flatten();
        if reason.is_none() && slot < scene.slot_count() {
            let weight = share_by_size(scene, view, &detail, slot);
            // Nothing that is kept goes altogether.
            colour[3] = (weight * 255.0).round().clamp(1.0, 255.0) as u8;
        }
    }
    colours
}

/// Colours with the share by which levels of detail have come already, as alpha.
fn fading(session: &Session, mut colours: Vec<[u8; 4]>) -> Vec<[u8; 4]> {
    for (slot, share) in session.fades.shares() {
        if let Some(colour) = colours.get_mut(slot as usize) {
            // Something that has no share at all is hidden, and so would be what goes.
            colour[3] = (share * 255.0).round().clamp(1.0, 255.0) as u8;
        }
    }
    colours
}
