//! The eye goes through the doors of a scene with cells.

use std::collections::VecDeque;

use cullet::{Culler, ViewState, Visible};
use cullet_cells::cell::CellGraph;
use cullet_cells::{CellView, InCells};
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_draw::{Picture, PortalWalk};
use cullet_io::Model;
use cullet_scenes::paths::{self, Overrides, PathSpec};
use glam::DVec3;

use super::args::FilmArgs;
use super::path::{Lens, Stand, Track};
use super::script::Script;

/// How far ahead the eye looks along its way, in heights of its own.
const AHEAD: f64 = 1.6;
/// Doors on the way at the most.
const DOORS: usize = 5;

/// The film.
pub(super) struct Portal<'a> {
    walk: PortalWalk<'a>,
    world: InCells<'a>,
    among: CellView,
    culler: Culler,
    state: ViewState,
    result: Visible,
    colors: Vec<[f32; 4]>,
    lens: Lens,
    track: Track,
    ahead: f64,
}

impl<'a> Portal<'a> {
    pub(super) fn new(model: &'a Model, args: &FilmArgs) -> Result<Self, Failure> {
        let (scene, world) = (&model.scene, model.in_cells());
        let name = &model.name;
        let graph = world.graph().ok_or_else(|| {
            Failure::input(format!(
                "{name}: there are no cells, so no portals; try --cells auto, or the built-in office"
            ))
        })?;
        let overrides = Overrides { seed: args.seed, ..Overrides::default() };
        let cameras = paths::cameras(model, &PathSpec::Walk, 8, args.size, &overrides);
        let cameras = cameras.map_err(Failure::input)?;
        let mut eyes = cameras.iter().map(|camera| DVec3::from(camera.eye));
        let start = eyes.find_map(|eye| Some((eye, world.cell_of(eye.into())?)));
        let (eye, cell) = start.ok_or_else(|| {
            Failure::input(format!("{name}: a walk through it is in none of its cells"))
        })?;
        let floor = scene.extent();
        let height = (eye.y - f64::from(floor.min[1]) - scene.origin()[1]).clamp(1e-3, 2.0);
        let doors = longest_way(graph, cell, eye.y);
        if doors.is_empty() {
            return Err(Failure::input(format!(
                "{name}: no open door leads out of cell {cell}, where a walk begins; try another --seed"
            )));
        }
        let points: Vec<DVec3> = std::iter::once(eye).chain(doors).collect();
        let walk = PortalWalk::new(world, eye.into(), args.size)
            .ok_or_else(|| Failure::input(format!("{name}: there are no cells")))?;
        let [near, _] = paths::range(&cameras[0].projection);
        let fov_y_radians = paths::DEFAULT_FOV_DEGREES.to_radians();
        let lens = Lens { fov_y_radians, near, size: walk.view_size() };
        Ok(Self {
            walk,
            world,
            among: CellView::default(),
            culler: inputs::culler(&args.cull).with_occlusion(None).with_lod(None),
            state: ViewState::default(),
            result: Visible::default(),
            colors: inputs::colors(model),
            lens,
            track: Track::new(points),
            ahead: height * AHEAD,
        })
    }
}

impl Script for Portal<'_> {
    fn frame(&mut self, share: f64) -> Result<Picture, Failure> {
        // It stops short of its end, so that there is something to look at.
        let along = share * (self.track.length() - self.ahead).max(0.0);
        let eye = self.track.at(along);
        let target = self.track.at(along + self.ahead);
        let view = self.lens.view(Stand { eye, target })?;
        let Self { culler, world, among, state, result, .. } = self;
        if let Some(cells) = world.cells {
            let culled = culler.cull_among(world.scene, &view, &among.on(cells), state, result);
            culled.map_err(Failure::usage)?;
        }
        Ok(self.walk.draw(&view, self.among.reached(), &self.colors))
    }
}

/// The middles of the doors, at the height of an eye, from a cell to the one that takes the most of
/// them, up to a number. A door is an open portal that is upright and reaches that high.
fn longest_way(graph: &CellGraph, start: u32, height: f64) -> Vec<DVec3> {
    let door = |portal: u32| -> Option<DVec3> {
        let polygon = &graph.portals()[portal as usize].polygon;
        let heights = polygon.iter().map(|p| p[1]);
        let (low, high) = heights
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        let upright = graph.plane(portal).normal[1].abs() < 0.5;
        let middle = polygon.iter().map(|p| DVec3::from(*p)).sum::<DVec3>() / polygon.len() as f64;
        (upright && (low..=high).contains(&height))
            .then_some(DVec3::new(middle.x, height, middle.z))
    };
    let mut from: Vec<Option<(u32, u32)>> = vec![None; graph.cell_count() as usize];
    let (mut queue, mut deepest) = (VecDeque::from([(start, 0)]), (start, 0));
    while let Some((cell, depth)) = queue.pop_front() {
        if depth > deepest.1 {
            deepest = (cell, depth);
        }
        for &portal in graph.portals_of(cell) {
            let next =
                graph.beyond(portal, cell).filter(|_| depth < DOORS && door(portal).is_some());
            if let Some(next) = next.filter(|&n| n != start && from[n as usize].is_none()) {
                from[next as usize] = Some((cell, portal));
                queue.push_back((next, depth + 1));
            }
        }
    }
    let (mut way, mut cell) = (Vec::new(), deepest.0);
    while let Some((before, portal)) = from[cell as usize].filter(|_| cell != start) {
        way.extend(door(portal));
        cell = before;
    }
    way.reverse();
    way
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_through_an_office_leads_through_open_doors() {
        let model = cullet_scenes::build("office").unwrap();
        let graph = model.in_cells().graph().unwrap();
        let start = model.in_cells().cell_of([26.6, 1.7, 18.2]).unwrap();
        let way = longest_way(graph, start, 1.7);
        assert!((2..=DOORS).contains(&way.len()), "{way:?}");
        assert!(way.iter().all(|p| p.y == 1.7));
    }
}
