//! The inside of a power plant: a nave with tall vessels between aisles of rooms, storey above
//! storey, all of them full of pipes.

mod piping;

use cullet::{MeshId, Projection, Transform};
use glam::{DMat3, DVec3};

use super::builder::{SceneBuilder, Sides, fill, turned};
use super::rng::Rng;
use super::shapes::Shape;
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::{CameraNode, Model};

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "plant",
    about: "the inside of a power plant: pipes, valves, vessels, pumps, ladders and trays in rooms on \
            both sides of a nave; from its west end, camera hall, nearly all of it is in the picture and \
            nearly all of that is hidden",
    keys: &[
        KeyInfo { name: "seed", about: "which plant", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "bays",
            about: "length in bays of 8 m; each has 6 racks of pipes on a storey",
            default: 12,
            min: 2,
            max: 200,
        },
        KeyInfo { name: "floors", about: "storeys of 6 m", default: 6, min: 1, max: 50 },
        KeyInfo {
            name: "pipes",
            about: "pipes in the rack of a bay, some 1300 triangles each",
            default: 9,
            min: 1,
            max: 100,
        },
        KeyInfo {
            name: "kinds",
            about: "different racks; each is used by bays x floors x 6 / kinds bays",
            default: 48,
            min: 1,
            max: 1000,
        },
        KeyInfo {
            name: "roof",
            about: "1 covers the building, 0 leaves it open, so that one looks in from above",
            default: 0,
            min: 0,
            max: 1,
        },
    ],
};

/// Side of a bay.
const BAY: f64 = 8.0;
/// From floor to floor.
const STOREY: f64 = 6.0;
const SLAB: f64 = 0.4;
const WALL: f64 = 0.3;
/// Overlap of a shape with the one it stands on or in, so that rounding leaves no crack.
const LAP: f64 = 0.05;
/// Half the width of the nave.
const NAVE: f64 = 10.0;
/// Bays from the nave to the outer wall.
const DEPTH: usize = 3;
/// Width of the galleries along the nave.
const GALLERY: f64 = 1.8;
/// How far the nave goes on west of the first bay, where one stands and looks.
const PORCH: f64 = 14.0;
const OUTER: f64 = NAVE + WALL + DEPTH as f64 * BAY;
/// Doors from rooms to the nave: width and height.
const DOOR: [f64; 2] = [2.2, 2.8];
/// How many rooms are open to the nave.
const OPEN: f64 = 0.3;
/// Bays along the nave for a vessel.
const VESSEL_BAYS: usize = 2;

/// Everything that is made once and placed many times.
struct Parts {
    concrete: MeshId,
    wall: MeshId,
    steel: MeshId,
    racks: Vec<[MeshId; 2]>,
    tanks: Vec<MeshId>,
    pump: MeshId,
    ladder: MeshId,
    tall_ladder: MeshId,
    railing: MeshId,
    tray: MeshId,
    girder: MeshId,
    vessels: Vec<MeshId>,
    cabinet: MeshId,
}

struct Plant {
    b: SceneBuilder,
    parts: Parts,
    bays: usize,
    floors: usize,
    rng: Rng,
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let mut b = SceneBuilder::new(spec);
    let floors = spec.get("floors") as usize;
    let mut rng = Rng::new(spec.get("seed"), 1);
    let parts = Parts::new(&mut b, spec, floors as f64 * STOREY, &mut rng)?;
    let bays = spec.get("bays") as usize;
    let mut plant = Plant { b, parts, bays, floors, rng: Rng::new(spec.get("seed"), 2) };
    plant.shell(spec.get("roof") == 1)?;
    for floor in 0..floors {
        plant.storey(floor)?;
    }
    plant.nave()?;
    plant.cameras();
    Ok(plant.b.finish())
}

impl Parts {
    fn new(
        b: &mut SceneBuilder,
        spec: &Spec,
        height: f64,
        rng: &mut Rng,
    ) -> Result<Self, SceneSpecError> {
        let concrete = b.material("concrete", 0xA9A59C);
        let plaster = b.material("wall", 0xC9C6B8);
        let steel = b.material("steel", 0x6B737C);
        let yellow = b.material("railing", 0xD9A520);
        let silver = b.material("cladding", 0xC3C9CE);
        let red = b.material("valve", 0xB3392F);
        let green = b.material("pump", 0x3D7F6B);
        let grey = b.material("cabinet", 0x8FA0A8);
        let colours = [0x9FB4C0, 0x5E7FA3, 0x7C9A5E, 0xC08A4A, 0xB8BDC2, 0x86664F];
        let paints: Vec<u32> = (0..)
            .zip(colours)
            .map(|(i, colour)| b.material(&format!("pipe paint {i}"), colour))
            .collect();
        let cube = || Shape::building(1);
        let mut racks = Vec::new();
        let size = DVec3::new(BAY, STOREY - SLAB, BAY);
        for i in 0..spec.get("kinds") as usize {
            let [lines, valves] = piping::rack(size, spec.get("pipes") as u32, rng);
            // Valves of one rack may be few, never none: the middle stretch always has room for
            // one.
            let paint = paints[i % paints.len()];
            let lines = b.mesh(&format!("pipe rack {i}"), &[(lines, paint)], Sides::One)?;
            let valves = b.mesh(&format!("valves {i}"), &[(valves, red)], Sides::One)?;
            racks.push([lines, valves]);
        }
        let mut tanks = Vec::new();
        for i in 0..8 {
            let tank = piping::tank(rng.range(0.5, 1.1), rng.range(2.2, 2.9), 32, rng);
            let paint = [silver, paints[0], paints[4]][i % 3];
            tanks.push(b.mesh(&format!("tank {i}"), &[(tank, paint)], Sides::One)?);
        }
        let mut vessels = Vec::new();
        for i in 0..3 {
            let h = (height * (0.78 + 0.08 * f64::from(i))).max(4.0);
            let vessel = piping::tank(4.6 - 0.3 * f64::from(i), h, 96, rng);
            vessels.push(b.mesh(&format!("vessel {i}"), &[(vessel, silver)], Sides::One)?);
        }
        let [foot, body] = piping::pump(1.0);
        let door = Shape::boxes(&[
            ([-0.6, 0.0, -0.3], [0.6, 2.1, 0.3]),
            ([-0.56, 0.1, 0.2], [-0.02, 2.0, 0.33]),
            ([0.02, 0.1, 0.2], [0.56, 2.0, 0.33]),
            ([-0.1, 1.0, 0.3], [-0.06, 1.2, 0.37]),
        ]);
        Ok(Self {
            concrete: b.mesh("slab", &[(cube(), concrete)], Sides::One)?,
            wall: b.mesh("wall", &[(cube(), plaster)], Sides::One)?,
            steel: b.mesh("steel", &[(cube(), steel)], Sides::One)?,
            racks,
            tanks,
            pump: b.mesh("pump", &[(foot, concrete), (body, green)], Sides::One)?,
            ladder: b.mesh("ladder", &[(piping::ladder(STOREY - SLAB), yellow)], Sides::One)?,
            tall_ladder: b.mesh(
                "tall ladder",
                &[(piping::ladder((height * 0.75).max(3.0)), yellow)],
                Sides::One,
            )?,
            railing: b.mesh("railing", &[(piping::railing(BAY), yellow)], Sides::One)?,
            tray: b.mesh("cable tray", &[(piping::tray(BAY), steel)], Sides::One)?,
            girder: b.mesh("girder", &[(piping::girder(2.0 * NAVE, 1.6), steel)], Sides::One)?,
            vessels,
            cabinet: b.mesh("cabinet", &[(door, grey)], Sides::One)?,
        })
    }
}

/// Turned by quarters about y within a bay whose lowest corner is `at`.
fn in_bay(quarter: usize, at: DVec3) -> Transform {
    let shift = [[0.0, 0.0], [0.0, BAY], [BAY, BAY], [BAY, 0.0]][quarter];
    turned(quarter as f64 * 0.25, [1.0; 3], (at + DVec3::new(shift[0], 0.0, shift[1])).to_array())
}

impl Plant {
    fn length(&self) -> f64 {
        self.bays as f64 * BAY
    }

    fn height(&self) -> f64 {
        self.floors as f64 * STOREY
    }

    fn boxed(&mut self, mesh: MeshId, min: [f64; 3], max: [f64; 3]) -> Result<(), SceneSpecError> {
        self.b.add(mesh, fill(min, max))?;
        Ok(())
    }

    /// Foundation, outer walls, columns and girders of the nave, and the roof if there is one.
    fn shell(&mut self, roof: bool) -> Result<(), SceneSpecError> {
        let (l, h) = (self.length(), self.height());
        let Parts { concrete, wall, steel, girder, .. } = self.parts;
        let out = OUTER + WALL;
        self.boxed(concrete, [-PORCH - WALL, -1.0, -out], [l + WALL, 0.0, out])?;
        for side in [-1.0, 1.0] {
            let z = [side * OUTER, side * out];
            let (z0, z1) = (z[0].min(z[1]), z[0].max(z[1]));
            self.boxed(wall, [-WALL, -LAP, z0], [l + WALL, h, z1])?;
            // West fronts of the aisles, and the porch between them.
            let z = [side * NAVE, side * (OUTER + LAP)];
            let (z0, z1) = (z[0].min(z[1]), z[0].max(z[1]));
            self.boxed(wall, [-WALL, -LAP, z0], [0.0, h - LAP, z1])?;
            let z = [side * NAVE, side * (NAVE + WALL)];
            let (z0, z1) = (z[0].min(z[1]), z[0].max(z[1]));
            self.boxed(wall, [-PORCH, -LAP, z0], [-WALL + LAP, h - 2.0 * LAP, z1])?;
        }
        self.boxed(wall, [l, -LAP, -OUTER - LAP], [l + WALL - LAP, h - LAP, OUTER + LAP])?;
        self.boxed(wall, [-PORCH - WALL, -LAP, -NAVE - WALL], [-PORCH, h, NAVE + WALL])?;
        for i in -1..=self.bays as i32 {
            let x = f64::from(i) * BAY + if i == self.bays as i32 { -0.4 } else { 0.4 };
            for z in [-NAVE + 0.3, NAVE - 0.3] {
                self.boxed(steel, [x - 0.2, -LAP, z - 0.2], [x + 0.2, h + 0.3, z + 0.2])?;
            }
            self.b.add(girder, Transform::from_translation([x, h, -NAVE]))?;
        }
        if roof {
            self.boxed(concrete, [-PORCH - WALL, h - LAP, -out], [l + WALL, h + SLAB, out])?;
        }
        Ok(())
    }

    /// Rooms, galleries and all that is in them, of one storey.
    fn storey(&mut self, floor: usize) -> Result<(), SceneSpecError> {
        let (l, y) = (self.length(), floor as f64 * STOREY);
        let top = y + STOREY - SLAB;
        let Parts { concrete, wall, railing, .. } = self.parts;
        for side in [-1.0, 1.0] {
            let across = |a: f64, b: f64| [(side * a).min(side * b), (side * a).max(side * b)];
            if floor > 0 {
                let z = across(NAVE - GALLERY, OUTER + LAP);
                self.boxed(concrete, [-LAP, y - SLAB, z[0]], [l + LAP, y, z[1]])?;
                for bay in 0..self.bays {
                    let at = [bay as f64 * BAY, y, side * (NAVE - GALLERY + 0.06)];
                    self.b.add(railing, Transform::from_translation(at))?;
                }
            }
            // Rooms of two bays; the last may be one.
            for first in (0..self.bays).step_by(2) {
                let count = (self.bays - first).min(2);
                let (x0, x1) = (first as f64 * BAY, (first + count) as f64 * BAY);
                // Some rooms are open to the nave.
                let open = self.rng.chance(OPEN);
                let z = across(NAVE, NAVE + WALL);
                let door = x0 + (x1 - x0) * self.rng.range(0.25, 0.75) - DOOR[0] * 0.5;
                if !open {
                    self.boxed(wall, [x0, y - LAP, z[0]], [door, top + LAP, z[1]])?;
                    self.boxed(wall, [door + DOOR[0], y - LAP, z[0]], [x1, top + LAP, z[1]])?;
                    let lintel = [door - LAP, y + DOOR[1], z[0] + 0.01];
                    let to = [door + DOOR[0] + LAP, top + LAP, z[1] - 0.01];
                    self.boxed(wall, lintel, to)?;
                }
                if x1 < l {
                    let z = across(NAVE + 0.02, OUTER + LAP);
                    let x = [x1 - WALL * 0.5, x1 + WALL * 0.5];
                    self.boxed(wall, [x[0], y - LAP, z[0]], [x[1], top + LAP, z[1]])?;
                }
            }
            for bay in 0..self.bays {
                for deep in 0..DEPTH {
                    let z = across(
                        NAVE + WALL + deep as f64 * BAY,
                        NAVE + WALL + (deep + 1) as f64 * BAY,
                    );
                    self.furnish(DVec3::new(bay as f64 * BAY, y, z[0]), deep)?;
                }
            }
        }
        Ok(())
    }

    /// Pipes under the ceiling of a bay, and machines on its floor.
    fn furnish(&mut self, at: DVec3, deep: usize) -> Result<(), SceneSpecError> {
        let rng = &mut self.rng;
        let rack = self.parts.racks[rng.below(self.parts.racks.len())];
        let placed = in_bay(rng.below(4), at);
        for mesh in rack {
            self.b.add(mesh, placed)?;
        }
        let mut place = |x: f64, z: f64| {
            let jitter = [rng.range(-0.3, 0.3), rng.range(-0.3, 0.3)];
            (at + DVec3::new(x + jitter[0], 0.0, z + jitter[1])).to_array()
        };
        let spots = [place(2.0, 2.0), place(2.0, 6.0), place(6.0, 2.0), place(6.0, 6.0)];
        for spot in spots {
            let kind = self.rng.below(5);
            let quarter = self.rng.below(4) as f64 * 0.25;
            let mesh = match kind {
                0 | 1 => self.parts.tanks[self.rng.below(self.parts.tanks.len())],
                2 | 3 => self.parts.pump,
                _ => self.parts.cabinet,
            };
            self.b.add(mesh, turned(quarter, [1.0; 3], spot))?;
        }
        let [x, y, z] = at.to_array();
        let tray = [x, y + STOREY - SLAB - 0.35, z + BAY * 0.5];
        self.b.add(self.parts.tray, Transform::from_translation(tray))?;
        if deep == DEPTH - 1 {
            self.b.add(self.parts.ladder, Transform::from_translation([x + 4.0, y, z + 4.0]))?;
        }
        Ok(())
    }

    /// Vessels in a row, with ladders, and pipes across.
    fn nave(&mut self) -> Result<(), SceneSpecError> {
        for (i, first) in (0..self.bays).step_by(VESSEL_BAYS).enumerate() {
            let count = (self.bays - first).min(VESSEL_BAYS) as f64;
            let x = (first as f64 + count * 0.5) * BAY;
            // By turns to the left and to the right of the middle.
            let z = if i % 2 == 0 { -1.8 } else { 1.8 };
            let vessel = self.parts.vessels[self.rng.below(self.parts.vessels.len())];
            let turn = self.rng.unit();
            self.b.add(vessel, turned(turn, [1.0; 3], [x, 0.0, z]))?;
            let ladder = turned(-0.25, [1.0; 3], [x - 4.75, 0.0, z]);
            self.b.add(self.parts.tall_ladder, ladder)?;
            for _ in 0..2 {
                let at = [x + self.rng.range(-3.5, 3.5), 0.0, -z * 3.6];
                let turn = self.rng.below(2) as f64 * 0.25;
                self.b.add(self.parts.pump, turned(turn, [1.3; 3], at))?;
            }
        }
        // Bridges of pipes between the aisles, from vessel to vessel.
        for bay in (1..self.bays).step_by(VESSEL_BAYS) {
            for floor in 0..self.floors {
                if !self.rng.chance(0.4) {
                    continue;
                }
                let scale = NAVE / BAY;
                for half in 0..2 {
                    let rack = self.parts.racks[self.rng.below(self.parts.racks.len())];
                    let at = [
                        (bay as f64 + 0.4) * BAY,
                        floor as f64 * STOREY,
                        NAVE * (f64::from(half) - 1.0),
                    ];
                    for mesh in rack {
                        self.b.add(mesh, turned(0.0, [scale; 3], at))?;
                    }
                }
            }
        }
        // Before the first bay, on both sides of whoever stands there.
        for side in [-1.0, 1.0] {
            for i in 0..4 {
                let at = [-2.0 - 2.6 * f64::from(i), 0.0, side * (NAVE - 1.3)];
                let tank = self.parts.tanks[self.rng.below(self.parts.tanks.len())];
                let mesh = if i % 2 == 0 { tank } else { self.parts.cabinet };
                let turn = if side > 0.0 { 0.5 } else { 0.0 };
                self.b.add(mesh, turned(turn, [1.0; 3], at))?;
            }
        }
        Ok(())
    }

    fn cameras(&mut self) {
        let (l, h) = (self.length(), self.height());
        let eye = DVec3::new(-PORCH + 1.5, (h * 0.42).clamp(1.7, 15.0), 3.0);
        let mut add = |name: &str, keys: Vec<(f64, Transform)>| {
            self.b.model.cameras.push(CameraNode {
                name: name.to_owned(),
                projection: Projection::Perspective {
                    fov_y_radians: std::f64::consts::FRAC_PI_3,
                    aspect: 0.0,
                    near: 0.2,
                    far: 3.0 * (l + h + 100.0),
                },
                keys,
            });
        };
        let middle = DVec3::new(l * 0.5, h * 0.42, 0.0);
        add("hall", vec![(0.0, sight(eye, middle))]);
        let low = DVec3::new(-PORCH * 0.5, 1.7, 6.4);
        add("floor", vec![(0.0, sight(low, DVec3::new(l, h * 0.4, 0.0)))]);
        let room = DVec3::new(1.0, 1.9, NAVE + WALL + 4.0);
        add("room", vec![(0.0, sight(room, room + DVec3::new(10.0, 0.3, 2.0)))]);
        let above = DVec3::new(-0.5 * h - 10.0, h * 2.2, OUTER * 1.5);
        add("above", vec![(0.0, sight(above, DVec3::new(l * 0.45, 0.0, 0.0)))]);
        // Along the nave, beside the vessels, a second for each bay.
        let steps = self.bays;
        let walk = (0..=steps).map(|i| {
            let x = -PORCH * 0.5 + (l + PORCH * 0.5 - 3.0) * i as f64 / steps as f64;
            let at = DVec3::new(x, 1.7, NAVE - GALLERY - 0.6);
            (i as f64, sight(at, at + DVec3::new(10.0, 1.5, -2.5)))
        });
        let walk = walk.collect();
        add("walk", walk);
    }
}

/// Where a camera at `eye` looks at `target`, upright.
fn sight(eye: DVec3, target: DVec3) -> Transform {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let m = DMat3::from_cols(right, back.cross(right), back);
    let linear = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.as_vec3().to_array());
    Transform { linear, translation: eye.to_array() }
}
