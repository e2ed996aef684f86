//! A culling view seen from outside: everything it dropped in the colour of the kind of culling
//! that took it.

use std::borrow::Cow;

use cullet::{Culler, Output, Scene, View, ViewState, Visible};
use cullet_cells::InCells;

use super::Picture;
use super::font::text_size;
use super::frozen::{FrozenView, from_far};
use super::map::{Fate, Legend, plural};
use super::outside::{Outlook, draw_frustum, from_outside};
use super::palette::{INK, PAPER};
use super::shaded::light_through;
use crate::frame::{Frame, PixelId};

/// Culls for `view`, stands aside from it ([`Outlook`]) and draws the whole scene, each dropped
/// triangle in the colour of the kind of culling that took it, with the frustum, and a legend where
/// it would cover less than a quarter. `size` is that of the picture, at least 320 × 200.
///
/// Cost: the culling, two frames of the scene, some 0.2 µs a pixel, and as much for a triangle of
/// an instance that is kept.
#[must_use]
pub fn kinds<'a>(
    world: impl Into<InCells<'a>>,
    view: &View,
    culler: &Culler,
    size: [u32; 2],
) -> Picture {
    let world = world.into();
    let scene = world.scene;
    let culler =
        culler.clone().with_output(Output::Triangles).with_reasons(true).with_dropped(true);
    let mut visible = Visible::default();
    world.cull(&culler, view, &mut ViewState::default(), &mut visible);
    kinds_of(scene, view, &visible, &Outlook::new(scene, view, size).from)
}

/// [`kinds`] for a visible set that is known, with triangles, reasons and what was dropped, seen
/// from a view of one's choice. The picture has the size of that view.
#[must_use]
pub fn kinds_of(scene: &Scene, view: &View, visible: &Visible, from: &View) -> Picture {
    let frozen = FrozenView::new(scene, Cow::Borrowed(view), Cow::Borrowed(visible));
    let fates = frozen.fates();
    let from = from_outside(from);
    let frame = from_far(scene, &from);
    let color = |id: PixelId| fates.color_of(id);
    // Colours carry the meaning: no haze.
    let mut picture = light_through(0.0, scene, &frame, &from, frozen.surfaces(), &color).halved();
    let lines = draw_frustum(&mut picture, scene, view, &from, &frame);
    explain(&mut picture, &frame, &lines, &fates.counts());
    picture
}

/// Puts a legend into the corner where it hides the least, if it covers less than a quarter of the
/// picture. `frame` is what the picture shows, at twice its size; `lines` are points of what was
/// drawn over it.
pub(super) fn explain(
    picture: &mut Picture,
    frame: &Frame,
    lines: &[[f64; 2]],
    counts: &[(Fate, u64)],
) {
    let size = text_size(picture.width);
    let mut legend = Legend { at: [0; 2], size, ink: INK, paper: PAPER };
    let (wide, high) = (Legend::width(size) + 28, legend.height(counts.len()) + 20);
    let room = [picture.width, picture.height].map(i64::from);
    if wide * high * 4 >= room[0] * room[1] {
        return;
    }
    let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, below]| {
        [12 + right * (room[0] - wide - 24), 12 + below * (room[1] - high - 24)]
    });
    let hides = |[x, y]: &[i64; 2]| {
        let within =
            |p: [i64; 2]| (*x..*x + wide).contains(&p[0]) && (*y..*y + high).contains(&p[1]);
        let shown = (*y..*y + high)
            .step_by(4)
            .flat_map(|y| (*x..*x + wide).step_by(4).map(move |x| [x, y]));
        let surface =
            shown.filter(|p| frame.id(p[0] as u32 * 2, p[1] as u32 * 2) != PixelId::NONE).count();
        // A line is thin, and says more than a surface.
        surface + 40 * lines.iter().filter(|p| within(p.map(|v| v as i64))).count()
    };
    let [x, y] = corners.into_iter().min_by_key(hides).unwrap_or([12, 12]);
    picture.fill([x, y], [wide, high], PAPER, 0.9);
    legend.at = [x + 14, y + 16];
    let total: u64 = counts.iter().map(|c| c.1).sum();
    legend.draw(picture, "the view and its culling", &plural(total, "triangle"), counts);
}

#[cfg(test)]
mod tests {
    use cullet::cull::occlusion::Occlusion;
    use cullet::{Camera, Instance, Mesh, MeshData, Stage, Transform};

    use super::*;
    use crate::frame::{RenderOptions, Selection};
    use crate::picture::scene_fates::SceneFates;
    use crate::picture::space::Surfaces;
    use crate::render::render;

    fn culled(scene: &Scene, view: &View) -> Visible {
        culled_by(&Culler::default().with_occlusion(Occlusion::default()), scene, view)
    }

    fn culled_by(culler: &Culler, scene: &Scene, view: &View) -> Visible {
        let culler =
            culler.clone().with_output(Output::Triangles).with_reasons(true).with_dropped(true);
        let mut visible = Visible::default();
        culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
        visible
    }

    #[test]
    fn a_stage_alone_paints_its_colour_alone_and_as_often_as_it_counts() {
        let all = Culler::default().with_occlusion(Occlusion::default());
        let scene = cullet_scenes::build("city:cells=8,objects=60").unwrap().scene;
        let view = look([-12.0, 1.7, 12.0], [0.0, 1.0, -6.0]);
        let seen = render(&scene, &view, Selection::All, &RenderOptions::default()).visible();
        let surfaces = Surfaces::of_all(&scene);
        let stages = [Stage::Frustum, Stage::Occlusion, Stage::Backface, Stage::Degenerate];
        let alone = stages.map(|stage| (all.only(stage), vec![stage]));
        for (culler, stages) in alone.into_iter().chain([(all.clone(), stages.to_vec())]) {
            let visible = culled_by(&culler, &scene, &view);
            let fates = SceneFates::new(&scene, &visible, &seen, &surfaces);
            let counts = fates.counts();
            for stage in Stage::ALL {
                let painted = counts.iter().find(|c| c.0 == Fate::Dropped(Some(stage)));
                let painted = painted.map_or(0, |c| c.1);
                assert_eq!(painted, visible.funnel.dropped(stage).triangles, "{stage:?}");
                assert!(painted == 0 || stages.contains(&stage), "{stage:?} of {stages:?}");
            }
        }
    }

    fn look(eye: [f64; 3], target: [f64; 3]) -> View {
        let projection = cullet::Projection::Perspective {
            fov_y_radians: 1.0,
            aspect: 1.6,
            near: 0.05,
            far: f64::INFINITY,
        };
        let camera = Camera::look_at(eye, target, projection);
        View::new(&camera, cullet::Depth::Reversed, [160, 100]).unwrap()
    }

    #[test]
    fn the_legend_counts_every_triangle_once_and_has_each_colour_that_is_painted() {
        for (text, eye) in [
            ("city:cells=8,objects=60", [-12.0, 1.7, 12.0]),
            ("knobs:n=12", [0.5, 1.2, 2.4]),
            ("office:rooms=2,corridors=1,floors=1", [5.0, 1.7, 5.0]),
        ] {
            let scene = cullet_scenes::build(text).unwrap().scene;
            let view = look(eye, [0.0, 1.0, -6.0]);
            let visible = culled(&scene, &view);
            let seen = render(&scene, &view, Selection::All, &RenderOptions::default()).visible();
            let surfaces = Surfaces::of_all(&scene);
            let fates = SceneFates::new(&scene, &visible, &seen, &surfaces);
            let counts = fates.counts();
            assert_eq!(counts.iter().map(|c| c.1).sum::<u64>(), scene.triangle_count(), "{text}");
            assert!(counts.len() > 2, "{text}: {counts:?}");
            for (i, (fate, n)) in counts.iter().enumerate() {
                assert!(*n > 0 && counts[..i].iter().all(|c| c.0 != *fate), "{text}: {counts:?}");
            }
            assert_eq!(counts[0], (Fate::Seen, seen.len() as u64), "{text}");
            let from = from_outside(&Outlook::new(&scene, &view, [320, 200]).from);
            let frame = render(&scene, &from, Selection::All, &RenderOptions::default());
            for id in frame.ids.into_iter().filter(|id| *id != PixelId::NONE) {
                assert!(counts.iter().any(|c| c.0 == fates.of(id)), "{text}: {id:?}");
            }
        }
    }

    #[test]
    fn a_view_under_a_roof_is_cut_open_and_one_under_the_sky_is_not() {
        let sheet = |y: f32, size: f32| {
            let positions =
                vec![[-size, y, -size], [size, y, -size], [size, y, size], [-size, y, size]];
            let indices = vec![0, 2, 1, 0, 3, 2];
            Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap()
        };
        let mut scene = Scene::new();
        let (ground, roof) = (sheet(0.0, 10.0), sheet(3.0, 10.0));
        let ground = scene.add_mesh(ground);
        scene.add(Instance::new(ground, Transform::IDENTITY)).unwrap();
        let cube = scene.add_mesh(sheet(1.0, 0.5));
        for [x, z] in [[0.0, -3.0], [-8.0, -8.0], [8.0, -8.0], [-8.0, 8.0], [8.0, 8.0]] {
            let place = Transform { translation: [x, 0.0, z], ..Transform::IDENTITY };
            scene.add(Instance::new(cube, place)).unwrap();
        }
        scene.commit(&Culler::default());
        let view = look([0.0, 1.6, 2.0], [0.0, 0.8, -3.0]);
        assert_eq!(Outlook::new(&scene, &view, [320, 200]).cut_at, None);
        let roof = scene.add_mesh(roof);
        scene.add(Instance::new(roof, Transform::IDENTITY)).unwrap();
        scene.commit(&Culler::default());
        let cut = Outlook::new(&scene, &view, [320, 200]).cut_at.unwrap();
        assert!((cut - 1.76).abs() < 1e-3, "{cut}");
    }

    #[test]
    fn a_single_model_and_the_frustum_are_in_the_picture() {
        let scene = cullet_scenes::build("knobs:n=12").unwrap().scene;
        let view = look([0.0, 1.6, 5.0], [0.0, 1.1, 0.0]);
        let outlook = Outlook::new(&scene, &view, [320, 200]);
        assert_eq!(outlook.cut_at, None);
        let space = crate::picture::space::Space::new(&outlook.from);
        for slot in scene.slots() {
            for corner in crate::picture::space::corners(&scene, &scene.bounds(slot)) {
                let [x, y] = space.project(corner, [320, 200]).unwrap().0;
                assert!((0.0..320.0).contains(&x) && (0.0..200.0).contains(&y), "{x}, {y}");
            }
        }
        let eye = space.project([0.0, 1.6, 5.0].into(), [320, 200]).unwrap().0;
        assert!((0.0..320.0).contains(&eye[0]) && (0.0..200.0).contains(&eye[1]), "{eye:?}");
    }
}
