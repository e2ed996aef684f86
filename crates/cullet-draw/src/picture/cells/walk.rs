//! A walk through portals: the view, and a plan that stays where it is.

use cullet::View;
use cullet_cells::InCells;
use cullet_cells::cell::CellGraph;
use cullet_cells::portal::Reached;
use glam::{DVec3, DVec4};

use super::super::Picture;
use super::super::canvas::LINE;
use super::super::font::{text_size, text_width};
use super::super::palette::{INK, PAPER};
use super::super::shaded::even_doubled;
use super::chain::{marked, painted};
use super::plan::{Plan, lay};
use super::sight::{Sight, shown_portals, shut_doors};

/// Pictures of a walk through the cells of a scene: on the left what the eye sees, with each portal
/// that it sees through in the colour of how many it is; on the right a plan of the cells in the
/// same colours, the same in all of them.
#[derive(Debug)]
pub struct PortalWalk<'a> {
    world: InCells<'a>,
    graph: &'a CellGraph,
    plan: Plan,
    size: [u32; 2],
}

/// So much of the width is the view's.
const VIEW: [u32; 2] = [5, 8];

impl<'a> PortalWalk<'a> {
    /// For walks at the height of `eye`, in pictures of `size`, at least 320 x 160. `None` where
    /// the scene has no cells. Cost: the cell of a point for each pixel of a plan of twice its
    /// size.
    #[must_use]
    pub fn new(world: InCells<'a>, eye: [f64; 3], size: [u32; 2]) -> Option<Self> {
        let graph = world.graph()?;
        let size = [size[0].max(320), size[1].max(160)];
        let line = (text_size(size[0]) * LINE).round() as u32;
        let beside = size[0] - Self::view_width(size[0]);
        let shown = [beside - 2 * GAP, size[1] - 3 * line - 2 * GAP];
        let plan = Plan::new(world, graph, Some(eye.into()), shown);
        Some(Self { world, graph, plan, size })
    }

    fn view_width(width: u32) -> u32 {
        width * VIEW[0] / VIEW[1]
    }

    /// Pixels of the views that it draws.
    #[must_use]
    pub fn view_size(&self) -> [u32; 2] {
        [Self::view_width(self.size[0]), self.size[1]]
    }

    /// The picture of a view of [`view_size`](Self::view_size). `reached` is
    /// [`CellView::reached`](cullet_cells::CellView::reached) after a cull of it. `material_colors`
    /// are as for [`shaded`](fn@super::super::shaded). Cost: a frame of four times the view's
    /// pixels, and the plan.
    #[must_use]
    pub fn draw(
        &self,
        view: &View,
        reached: Option<&Reached>,
        material_colors: &[[f32; 4]],
    ) -> Picture {
        let Self { world, graph, plan, size } = self;
        let (steps, doors) = match reached {
            Some(reached) => (shown_portals(view, reached), shut_doors(graph, view, reached)),
            None => (Vec::new(), Vec::new()),
        };
        let mut picture = Picture::new(size[0], size[1], PAPER);
        let lit = even_doubled(world.scene, view, None, material_colors);
        lay(&mut picture, [0, 0], &marked(lit, &steps, &doors));
        let eye = DVec4::from(view.eye());
        let eye = (eye.w != 0.0).then(|| eye.truncate());
        let sight = Sight::new(graph, reached);
        let left = i64::from(self.view_size()[0]);
        let text = text_size(size[0]);
        let line = (text * LINE).round() as i64;
        let cell = eye.and_then(|eye: DVec3| world.cell_of(eye.into()));
        let words = [
            cell.map_or("the eye is in no cell".to_owned(), |cell| format!("from cell {cell}")),
            match reached {
                Some(_) => format!("{} of {} cells reached", sight.count(), graph.cell_count()),
                None => "portals hide nothing here".to_owned(),
            },
            format!("{} portals seen through", steps.len()),
        ];
        let room = i64::from(size[0]) - left;
        for (words, row) in words.iter().zip(0..) {
            let x = left + (room - text_width(words, text)) / 2;
            picture.text([x, i64::from(GAP) + row * line], words, text, INK);
        }
        let place = [left + i64::from(GAP), i64::from(GAP) + 3 * line];
        lay(&mut picture, place, &painted(plan, graph, &sight, eye));
        picture
    }
}

/// Between the parts of a picture.
const GAP: u32 = 10;

#[cfg(test)]
mod tests {
    use cullet::{Camera, Culler, Depth, Projection};

    use super::*;

    #[test]
    fn the_plan_stays_and_the_colours_follow_the_eye() {
        let model = cullet_scenes::build("office").unwrap();
        let world = model.in_cells();
        // In two cells that one looks out of.
        let graph = world.graph().unwrap();
        let cell_of = |p: &[f64; 3]| world.cell_of(*p).filter(|&c| graph.portals_of(c).len() > 3);
        let places: Vec<[f64; 3]> = (0..400)
            .map(|k| [f64::from(k % 20) * 1.3 + 0.7, 1.7, f64::from(k / 20) * 1.1 + 0.6])
            .filter(|p| cell_of(p).is_some())
            .collect();
        let other = places.iter().find(|p| cell_of(p) != cell_of(&places[0])).unwrap();
        let eyes = [places[0], *other];
        let walk = PortalWalk::new(world, eyes[0], [480, 270]).unwrap();
        assert_eq!(walk.view_size(), [300, 270]);
        let [a, b] = eyes.map(|eye| {
            // So near that all of what is before it is in one cell.
            let (fov_y_radians, aspect, near) = (1.2, 300.0 / 270.0, 0.05);
            let far = f64::INFINITY;
            let projection = Projection::Perspective { fov_y_radians, aspect, near, far };
            let target = [eye[0] + 1.0, eye[1], eye[2] + 0.08];
            let camera = Camera::look_at(eye, target, projection);
            let view = View::new(&camera, Depth::Reversed, walk.view_size()).unwrap();
            let reached = world.reached(&Culler::default(), &view);
            assert!(reached.is_some(), "the eye is in a cell");
            walk.draw(&view, reached.as_ref(), &[])
        });
        assert_eq!([a.width, a.height], [480, 270]);
        // Outlines of cells, thin and so not quite in their colour, are where they were, and doors;
        // the eye is not.
        let dark = |p: &Picture, x: u32, y: u32| p.pixel(x, y).iter().all(|v| *v < 0xb0);
        let plan = (300..480).flat_map(|x| (80..270).map(move |y| (x, y)));
        let (same, all) = plan
            .filter(|(x, y)| dark(&a, *x, *y))
            .fold((0, 0), |(same, all), (x, y)| (same + u32::from(dark(&b, x, y)), all + 1));
        assert!(all > 100 && same * 10 > all * 8, "{same} of {all}");
        assert_ne!(a, b);
        let empty = cullet_scenes::build("solids:n=2").unwrap();
        assert!(PortalWalk::new(empty.in_cells(), [0.0; 3], [480, 270]).is_none());
    }
}
