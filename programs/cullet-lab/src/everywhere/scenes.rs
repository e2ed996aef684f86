//! Built-in scenes: what views see of them at each SIMD level, and what is asked and prepared.

use cullet::bounds::Aabb;
use cullet::cull::shadow::Light;
use cullet::prepared::{Preparation, Prepared};
use cullet::{Camera, Culler, Depth, Output, Projection, Scene, Simd, View, ViewState, Visible};
use cullet_cells::CellView;
use cullet_cells::query::{
    EyeBox, LightAnswer, LightOptions, RegionCuller, RegionState, RegionVisible, SightOptions,
    VolumeOptions, box_to_box, cull_light_casters, cull_lights, line_of_sight,
};
use cullet_io::Model;
use cullet_mesh::{MaskGrid, NormalMasks, ViewCone};
use cullet_scenes::Rng;

use crate::bakes;
use crate::hash::{Hash, line};

const SCENES: &[&str] = &[
    "city:cells=4,objects=80",
    "office:rooms=3,corridors=1,floors=1",
    "forest:n=200",
    "solids:n=24",
    "knobs:n=8",
    "moving",
];
const MESHES: usize = 12;
const SIZE: [u32; 2] = [320, 200];

pub(crate) fn run() -> Result<(), String> {
    for spec in SCENES {
        let mut model = cullet_scenes::build(spec).map_err(|e| e.to_string())?;
        let name = spec.split(':').next().unwrap_or(spec);
        geometry(name, &model);
        let space = Space::of(&model.scene);
        let views = space.views().map_err(|e| e.to_string())?;
        line(&format!("{name}: views"), |hash| hash.value(&views));
        masks(name, &model.scene)?;
        seen(name, &model.scene, &views)?;
        lights(name, &model.scene, &views, &space)?;
        queries(name, &model.scene, &space);
        if !model.cells.cells.is_empty() {
            in_cells(name, &mut model, &views)?;
        }
        bakes::run(name, &model)?;
    }
    Ok(())
}

/// The box that a scene fills.
struct Space {
    centre: [f64; 3],
    half: [f64; 3],
}

impl Space {
    fn of(scene: &Scene) -> Self {
        let extent = scene.extent();
        let (centre, half) = (extent.center(), extent.half_extent());
        Self { centre: centre.map(f64::from), half: half.map(f64::from) }
    }

    /// A point at random, at most a share of the box's half away from its middle.
    fn point(&self, rng: &mut Rng, share: f64) -> [f64; 3] {
        std::array::from_fn(|a| self.centre[a] + self.half[a] * rng.range(-share, share))
    }

    fn views(&self) -> Result<Vec<View>, cullet::view::ViewError> {
        let mut rng = Rng::new(2, 1);
        let mut views = Vec::new();
        for number in 0..6 {
            let (eye, target) = (self.point(&mut rng, 1.1), self.point(&mut rng, 0.5));
            let (fov, wide) = (rng.range(0.4, 1.9), self.half[0] * 0.7);
            views.push(if number < 5 {
                View::perspective(eye, target, fov, 0.1, 2000.0, SIZE)?
            } else {
                let (left, right, bottom, top) = (-wide, wide, -wide * 0.6, wide * 0.6);
                let lens =
                    Projection::Orthographic { left, right, bottom, top, near: 0.1, far: 1000.0 };
                View::new(&Camera::look_at(eye, target, lens), Depth::Reversed, SIZE)?
            });
        }
        Ok(views)
    }
}

/// Hashes of several things at each SIMD level, which must be equal.
fn at_each_level(names: &[String], mut run: impl FnMut(Simd, &mut [Hash])) -> Result<(), String> {
    let mut first: Option<(Simd, Vec<Hash>)> = None;
    for simd in Simd::all() {
        let mut hashes = vec![Hash::new(); names.len()];
        run(simd, &mut hashes);
        match &first {
            None => first = Some((simd, hashes)),
            Some((other, expected)) => {
                for ((name, hash), expected) in names.iter().zip(&hashes).zip(expected) {
                    if hash != expected {
                        let (simd, other) = (simd.name(), other.name());
                        return Err(format!("{name}: {simd} and {other} differ"));
                    }
                }
            }
        }
    }
    let (_, hashes) = first.ok_or("no SIMD level")?;
    names.iter().zip(hashes).for_each(|(name, hash)| hash.print(name));
    Ok(())
}

fn geometry(name: &str, model: &Model) {
    let scene = &model.scene;
    line(&format!("{name}: meshes"), |hash| {
        for mesh in scene.meshes() {
            mesh.positions().as_flattened().iter().for_each(|&v| hash.number(v));
            mesh.indices().iter().for_each(|&v| hash.whole(v));
        }
    });
    line(&format!("{name}: transforms"), |hash| {
        scene.slots().for_each(|slot| hash.value(scene.transform(slot)));
    });
    line(&format!("{name}: materials"), |hash| {
        model.materials.iter().flat_map(|m| m.color).for_each(|v| hash.number(v));
    });
    let meshes = || scene.meshes().iter().take(MESHES);
    line(&format!("{name}: cones, planes and occluders"), |hash| {
        meshes().for_each(|mesh| hash.value(&Prepared::of(mesh, Preparation::ALL)));
    });
}

fn seen(name: &str, scene: &Scene, views: &[View]) -> Result<(), String> {
    let presets =
        [("exact", Culler::exact()), ("balanced", Culler::balanced()), ("fast", Culler::fast())];
    for (preset, culler) in presets {
        let what = ["visible triangles", "visible clusters", "pixels of occlusion buffers"];
        let names = what.map(|what| format!("{name}, {preset}: {what}"));
        at_each_level(&names, |simd, hashes| {
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            for (at, output) in [Output::Triangles, Output::Clusters].into_iter().enumerate() {
                let culler = culler.clone().with_simd(simd).with_output(output).with_reasons(true);
                for view in views {
                    culler.cull_one(scene, view, &mut state, &mut visible);
                    hashes[at].visible(&visible);
                    let Some(buffer) = state.occlusion_buffer() else { continue };
                    let [width, height] = buffer.size();
                    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                    places.for_each(|(x, y)| hashes[2].number(buffer.nearness(x, y)));
                }
            }
        })?;
    }
    Ok(())
}

fn lights(name: &str, scene: &Scene, views: &[View], space: &Space) -> Result<(), String> {
    let mut rng = Rng::new(2, 2);
    let lights: Vec<Light> = (0..30)
        .map(|number| {
            let position = space.point(&mut rng, 1.0);
            let direction = [(); 3].map(|()| rng.range(-1.0, 1.0));
            let range = rng.range(0.05, 0.8) * space.half[0];
            let half_angle_radians = rng.range(0.1, 1.4);
            match number % 3 {
                0 => Light::Point { position, range },
                1 => Light::Spot { position, direction, half_angle_radians, range },
                _ => Light::Directional { direction },
            }
        })
        .collect();
    let names = ["lights", "casters of shadows"].map(|what| format!("{name}: {what}"));
    at_each_level(&names, |simd, hashes| {
        let culler = Culler::balanced().with_simd(simd).with_output(Output::Triangles);
        for view in &views[..2] {
            let (mut state, mut seen) = (ViewState::default(), Visible::default());
            culler.cull_one(scene, view, &mut state, &mut seen);
            let (visible, buffer) = (Some(&seen), state.occlusion_buffer());
            let options = LightOptions { simd, visible, buffer, ..LightOptions::default() };
            let mut answer = LightAnswer::default();
            cull_lights(scene, view, &lights, &options, &mut answer);
            let rows: Vec<_> = answer.rows.iter().map(|r| (r.stage, r.entered, r.left)).collect();
            hashes[0].value(&(&answer.kept, &answer.receivers, &answer.reasons, rows));
            let (mut states, mut results) = (Vec::new(), Vec::new());
            let lit = (view, &lights[..], &answer);
            cull_light_casters(&culler, scene, lit, &mut states, &mut results);
            results.iter().for_each(|result| hashes[1].visible(result));
        }
    })
}

/// Masks of the normals of triangles, and which of them an eye culls.
fn masks(name: &str, scene: &Scene) -> Result<(), String> {
    let grid = MaskGrid::new(4).ok_or("no such grid of normals")?;
    let names = ["masks of normals", "triangles culled by them"].map(|w| format!("{name}: {w}"));
    at_each_level(&names, |simd, hashes| {
        for mesh in scene.meshes().iter().take(MESHES) {
            let mut masks = NormalMasks::default();
            grid.encode_triangles(mesh.positions(), mesh.indices(), &mut masks);
            hashes[0].value(&masks);
            let cone = ViewCone::around([0.3, -0.5, 0.8], 0.4);
            let mut words = vec![0; masks.len().div_ceil(64)];
            masks.cull_words(simd, &grid.mask(simd, cone.as_ref()), 0, &mut words);
            hashes[1].value(&words);
        }
    })
}

fn queries(name: &str, scene: &Scene, space: &Space) {
    let mut rng = Rng::new(2, 3);
    let mut pairs = || [(); 8].map(|()| [(); 2].map(|()| space.point(&mut rng, 0.9)));
    line(&format!("{name}: lines of sight"), |hash| {
        for [a, b] in pairs() {
            hash.value(&line_of_sight(scene, a, b, &SightOptions::default()));
        }
    });
    line(&format!("{name}: boxes that see each other"), |hash| {
        for ends in pairs() {
            let [a, b] = ends.map(|centre| {
                let corner = |side: f64| {
                    std::array::from_fn(|a| (centre[a] + side * space.half[a] * 0.02) as f32)
                };
                Aabb::new(corner(-1.0), corner(1.0))
            });
            hash.value(&box_to_box(scene, &a, &b, &VolumeOptions::default()));
        }
    });
    let corner = |side: f64| std::array::from_fn(|a| space.centre[a] + side * space.half[a] * 0.1);
    let region = EyeBox::new(corner(-1.0), corner(1.0));
    let (mut state, mut seen) = (RegionState::default(), RegionVisible::default());
    let culled = RegionCuller::default().cull(scene, &region, &mut state, &mut seen).is_ok();
    line(&format!("{name}: seen from a region"), |hash| {
        hash.value(&culled);
        hash.value(&seen.slots().collect::<Vec<_>>());
    });
}

/// Through cells and portals.
fn in_cells(name: &str, model: &mut Model, views: &[View]) -> Result<(), String> {
    model.place_cells().map_err(|e| e.to_string())?;
    let cells = model.placed.as_ref().ok_or("cells were not placed")?;
    let names = [format!("{name}: seen through portals")];
    at_each_level(&names, |simd, hashes| {
        let culler = Culler::balanced().with_simd(simd).with_output(Output::Triangles);
        let (mut state, mut among) = (ViewState::default(), CellView::default());
        let mut visible = Visible::default();
        for view in views {
            let ended =
                culler.cull_among(&model.scene, view, &among.on(cells), &mut state, &mut visible);
            hashes[0].value(&ended);
            hashes[0].visible(&visible);
        }
    })
}
