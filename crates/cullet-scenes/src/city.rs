//! A city of boxes on a grid, with small objects in its streets and on its roofs.

use std::f64::consts::TAU;

use cullet::mesh::{Alpha, MeshData};
use cullet::{Projection, Transform};

use super::builder::{SceneBuilder, Sides, fill};
use super::rng::{Rng, morton_grid, sin_cos};
use super::shapes::{Shape, mesh_data};
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::{CameraNode, Model};

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "city",
    about: "box buildings on a 24 m grid of streets, with small objects in the streets and on the \
            roofs, and 32 cameras; nearly everything is hidden from the street",
    keys: &[
        KeyInfo { name: "seed", about: "which city", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "cells",
            about: "buildings along each side; the city has cells x cells of them",
            default: 100,
            min: 1,
            max: 1000,
        },
        KeyInfo {
            name: "objects",
            about: "small objects in streets, in the air and on roofs",
            default: 100_000,
            min: 0,
            max: 10_000_000,
        },
        KeyInfo {
            name: "n",
            about: "if not 0, in place of cells and objects: a city of plots of at least so many instances, one building \
                    to ten objects, any part of which can be made without the rest",
            default: 0,
            min: 0,
            max: 10_000_000,
        },
        KeyInfo {
            name: "sub",
            about: "each face of a building is cut in sub x sub quads",
            default: 1,
            min: 1,
            max: 64,
        },
        KeyInfo {
            name: "ground",
            about: "1 lays two triangles of ground under the city, 0 leaves them out",
            default: 1,
            min: 0,
            max: 1,
        },
    ],
};

/// Distance between the centres of neighbouring buildings.
pub(super) const PITCH: f64 = 24.0;

/// Facades, and how they are called.
pub(super) const FACADES: [(&str, u32); 6] = [
    ("sandstone", 0xD8C3A0),
    ("brick", 0xB5654A),
    ("concrete", 0xA9ACB0),
    ("plaster", 0xE6DFD3),
    ("slate", 0x6F7F8C),
    ("ochre", 0xCF9F4F),
];

#[derive(Clone, Copy)]
pub(super) struct Building {
    pub(super) half: [f64; 2],
    pub(super) height: f64,
    pub(super) facade: usize,
}

impl Building {
    pub(super) fn any(rng: &mut Rng) -> Self {
        Self {
            half: [rng.range(5.0, 9.0), rng.range(5.0, 9.0)],
            height: (6.0 + rng.exponential(14.0)).min(120.0),
            facade: rng.below(FACADES.len()),
        }
    }
}

struct City {
    cells: u32,
    buildings: Vec<Building>,
}

impl City {
    /// Half the length of a side of the city.
    fn reach(&self) -> f64 {
        f64::from(self.cells) * PITCH * 0.5
    }

    fn centre(&self, x: u32, z: u32) -> [f64; 2] {
        [x, z].map(|i| (f64::from(i) + 0.5) * PITCH - self.reach())
    }

    fn cell_of(&self, p: [f64; 2]) -> (u32, u32) {
        let [x, z] = p.map(|v| ((v + self.reach()) / PITCH) as u32);
        (x.min(self.cells - 1), z.min(self.cells - 1))
    }

    fn building(&self, (x, z): (u32, u32)) -> &Building {
        &self.buildings[(z * self.cells + x) as usize]
    }
}

/// A small object: the half-width and half-depth of its box, and its height.
pub(super) struct Object {
    at: [f64; 3],
    half: f64,
    height: f64,
    pub(super) kind: usize,
    quarter: usize,
}

impl Object {
    /// Whether it leaves room for an eye.
    pub(super) fn is_clear_of(&self, eye: [f64; 3]) -> bool {
        (self.at[0] - eye[0]).abs() > self.half + 0.3
            || (self.at[2] - eye[2]).abs() > self.half + 0.3
            || eye[1] < self.at[1] - 0.3
            || eye[1] > self.at[1] + self.height + 0.3
    }
}

/// Kinds of small objects; every mesh fills −1..1 × 0..1 × −1..1, so that scaling it gives the box
/// wanted.
const CRATE: usize = 0;
const CAR: usize = 1;
const BARREL: usize = 2;
const CONE: usize = 3;
const LAMP: usize = 4;
const BALLOON: usize = 5;
const VENT: usize = 6;

pub(super) fn kinds() -> [(&'static str, u32, Shape); 7] {
    let car = [
        [-1.0, 0.12],
        [-0.8, 0.0],
        [0.8, 0.0],
        [1.0, 0.12],
        [0.95, 0.5],
        [0.45, 0.6],
        [0.2, 1.0],
        [-0.7, 1.0],
    ];
    let lamp = [[1.0, 0.0], [0.16, 0.1], [0.1, 0.82], [0.6, 1.0]];
    let balloon = [[0.0, 0.0], [1.0, 0.6], [0.0, 1.0]];
    [
        ("crate", 0x9C7A4D, Shape::cuboid([-1.0, 0.0, -1.0], [1.0, 1.0, 1.0])),
        ("car", 0xB23A3A, Shape::prism(&car, -1.0, 1.0)),
        ("barrel", 0x2F7F6F, Shape::lathe(&[[1.0, 0.0], [1.0, 1.0]], 8)),
        ("cone", 0xE8742A, Shape::lathe(&[[1.0, 0.0], [0.0, 1.0]], 8)),
        ("lamp post", 0x3E4650, Shape::lathe(&lamp, 4)),
        ("balloon", 0xC95A9A, Shape::lathe(&balloon, 4)),
        ("vent", 0xC3C8CC, Shape::cuboid([-1.0, 0.0, -1.0], [1.0, 1.0, 1.0])),
    ]
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let seed = spec.get("seed");
    let cells = spec.get("cells") as u32;
    let mut b = SceneBuilder::new(spec);

    let mut rng = Rng::new(seed, 1);
    let buildings = (0..cells * cells).map(|_| Building::any(&mut rng)).collect();
    let city = City { cells, buildings };

    let sub = spec.get("sub") as u32;
    let mut facades = Vec::new();
    for (name, colour) in FACADES {
        let material = b.material(name, colour);
        let name = format!("{name} building");
        facades.push(b.mesh(&name, &[(Shape::building(sub), material)], Sides::One)?);
    }
    let mut kind_meshes = Vec::new();
    for (name, colour, shape) in kinds() {
        let material = b.material(name, colour);
        kind_meshes.push(b.mesh(name, &[(shape, material)], Sides::One)?);
    }

    if spec.get("ground") == 1 {
        let material = b.material("asphalt", 0x5A5E63);
        let mesh = b.mesh_from("ground", ground(city.reach() + 200.0, material))?;
        b.add(mesh, Transform::IDENTITY)?;
    }

    // Neighbours in the city get slots near each other: both lists run cell by cell.
    let mut objects = objects(&city, spec.get("objects") as usize, &mut Rng::new(seed, 2));
    let mut place = vec![0u32; city.buildings.len()];
    for (i, (x, z)) in morton_grid(cells).enumerate() {
        place[(z * cells + x) as usize] = i as u32;
    }
    objects.sort_by_key(|o| {
        let (x, z) = city.cell_of([o.at[0], o.at[2]]);
        place[(z * cells + x) as usize]
    });
    for (x, z) in morton_grid(cells) {
        let building = city.building((x, z));
        let [cx, cz] = city.centre(x, z);
        let [hx, hz] = building.half;
        let transform = fill([cx - hx, 0.0, cz - hz], [cx + hx, building.height, cz + hz]);
        b.add(facades[building.facade], transform)?;
    }
    for o in &objects {
        b.add(kind_meshes[o.kind], quarter_turned(o))?;
    }
    let clear = |eye| objects.iter().all(|o| o.is_clear_of(eye));
    cameras(&mut b.model, city.cells, clear, &mut Rng::new(seed, 3));
    Ok(b.finish())
}

/// Two triangles at y = 0, seen from both sides.
pub(super) fn ground(reach: f64, material: u32) -> MeshData {
    let r = reach as f32;
    let shape = Shape {
        positions: vec![[-r, 0.0, -r], [-r, 0.0, r], [r, 0.0, r], [r, 0.0, -r]],
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    mesh_data(&[(shape, material)], true, Alpha::Opaque)
}

/// Small objects all over the city.
fn objects(city: &City, count: usize, rng: &mut Rng) -> Vec<Object> {
    let reach = city.reach();
    let mut objects = Vec::with_capacity(count);
    while objects.len() < count {
        let building = |p| {
            let cell = city.cell_of(p);
            (city.centre(cell.0, cell.1), *city.building(cell))
        };
        objects.extend(object(rng, [-reach; 2], [reach; 2], building));
    }
    objects
}

/// A small object somewhere in a box of ground: in the street or floating where the place is free,
/// else now and then on the roof.
pub(super) fn object(
    rng: &mut Rng,
    low: [f64; 2],
    high: [f64; 2],
    building_at: impl Fn([f64; 2]) -> ([f64; 2], Building),
) -> Option<Object> {
    let half = rng.range(0.2, 1.0);
    let height = rng.range(0.3, 2.5);
    let [x, z] = [rng.range(low[0], high[0]), rng.range(low[1], high[1])];
    // Buildings stay 3 m from the edge of their cell, so only the one of this cell can be met.
    let ([cx, cz], building) = building_at([x, z]);
    let inside =
        (x - cx).abs() < building.half[0] + half && (z - cz).abs() < building.half[1] + half;
    let slender = height > 2.2 * half;
    let (y, kind) = if inside {
        if !rng.chance(0.15) {
            return None;
        }
        (building.height, VENT)
    } else if rng.chance(0.25) {
        (rng.range(0.0, 12.0), BALLOON)
    } else if slender {
        (0.0, [LAMP, CONE, BARREL, BARREL][rng.below(4)])
    } else {
        (0.0, [CRATE, CRATE, CAR, CONE][rng.below(4)])
    };
    Some(Object { at: [x, y, z], half, height, kind, quarter: rng.below(4) })
}

/// Turned by quarters, which leaves the box as it is.
pub(super) fn quarter_turned(o: &Object) -> Transform {
    let (h, y) = (o.half as f32, o.height as f32);
    let [c, s] = [[h, 0.0], [0.0, h], [-h, 0.0], [0.0, -h]][o.quarter];
    Transform { linear: [[c, 0.0, -s + 0.0], [0.0, y, 0.0], [s, 0.0, c]], translation: o.at }
}

/// 32 cameras at street crossings of the middle half.
pub(super) fn cameras(
    model: &mut Model,
    cells: u32,
    is_clear: impl Fn([f64; 3]) -> bool,
    rng: &mut Rng,
) {
    let crossings = f64::from(cells) * 0.25;
    for i in 0..32u32 {
        let high = i % 8 == 7;
        let height = if high { 60.0 } else { 1.7 };
        let any = rng.unit();
        let along_street = (any * 4.0).floor() * 0.25 + rng.range(-0.1, 0.1) / TAU;
        let yaw = if i % 3 == 2 { along_street } else { any };
        let pitch = if high { -0.25 } else { rng.range(-0.05, 0.1) };
        let mut eye = [0.0, height, 0.0];
        // A crossing is at a corner of four cells. Should an object stand there, another is drawn;
        // a city so full that a hundred draws all fail keeps the last.
        for _ in 0..100 {
            let mut street = || {
                (rng.range(-crossings, crossings)).round() * PITCH
                    + rng.range(-3.0, 3.0)
                    + (f64::from(cells % 2) * PITCH * 0.5)
            };
            eye = [street(), height, street()];
            if is_clear(eye) {
                break;
            }
        }
        model.cameras.push(CameraNode {
            name: format!("{} {i:02}", if high { "roof" } else { "street" }),
            projection: Projection::Perspective {
                fov_y_radians: std::f64::consts::FRAC_PI_3,
                aspect: 0.0,
                near: 0.5,
                far: 6000.0,
            },
            keys: vec![(0.0, camera(eye, yaw, pitch))],
        });
    }
}

/// A camera that looks along −z, pitched up by `pitch` radians, then turned by `yaw` turns.
fn camera(eye: [f64; 3], yaw: f64, pitch: f64) -> Transform {
    let (sy, cy) = sin_cos(yaw);
    let (sp, cp) = sin_cos(pitch / TAU);
    let columns = [[cy, 0.0, -sy], [sy * sp, cp, cy * sp], [sy * cp, -sp, cy * cp]];
    Transform { linear: columns.map(|c| c.map(|v| v as f32)), translation: eye }
}
