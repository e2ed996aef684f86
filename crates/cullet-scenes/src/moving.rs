//! A square where everything moves: carts, people with joints, swaying weed, and drops that morph.
//!
//! The scene stands still at a time that its text gives. What deforms has a mesh of its own, posed
//! at that time, and bounds of its joints or targets, as an engine would give them: neither knows
//! the other.

use cullet::bounds::Aabb;
use cullet::mesh::Alpha;
use cullet::{Instance, Mesh, Transform, scene::BoundsOverride};
use glam::{DAffine3, DVec3};

use super::builder::{SceneBuilder, Sides, fill, turned};
use super::rng::{Rng, sin_cos};
use super::shapes::{Shape, mesh_data};
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::Model;
use cullet_io::Motion;
use cullet_io::deform::{JointBoxes, MorphBounds, Morphs, Skin};

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "moving",
    about: "a square with carts that drive, people that walk (skinned), weed that sways (skinned) and \
            drops that morph, among walls; deformed meshes have bounds of their joints and targets",
    keys: &[
        KeyInfo { name: "seed", about: "which square", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "n",
            about: "how many movers, the four kinds in turn",
            default: 400,
            min: 1,
            max: 20_000,
        },
        KeyInfo {
            name: "t",
            about: "the time, in milliseconds",
            default: 0,
            min: 0,
            max: 86_400_000,
        },
    ],
};

/// Distance between the places about which instances move, in metres.
const PITCH: f64 = 6.0;

/// A shape with the joints that move each of its vertices.
#[derive(Default)]
struct Rigged {
    shape: Shape,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    /// Where each joint is when the shape is at rest.
    rest: Vec<DVec3>,
    inverse_binds: Vec<Transform>,
}

impl Rigged {
    /// Adds a limb along y, from `top` down to `bottom`: its joints divide it evenly, and near each
    /// the vertices blend.
    fn limb(mut self, top: DVec3, bottom: f64, radius: f64, joints: &[u16]) -> Self {
        const RINGS: u32 = 12;
        let length = top.y - bottom;
        let profile: Vec<[f64; 2]> = (0..=RINGS)
            .map(|i| {
                let up = f64::from(i) / f64::from(RINGS);
                let r = if i == 0 || i == RINGS { radius * 0.6 } else { radius };
                [r, bottom + length * up]
            })
            .collect();
        let limb = Shape::lathe(&profile, 8).scaled([1.0; 3], [top.x, 0.0, top.z]);
        for p in &limb.positions {
            // In joints from the top; within 0.3 of a division two joints share the vertex.
            let at = (top.y - f64::from(p[1])) / length * joints.len() as f64;
            let below = (at - 0.5).floor().clamp(0.0, joints.len() as f64 - 1.0) as usize;
            let next = (below + 1).min(joints.len() - 1);
            let share = ((at - (below as f64 + 0.7)) / 0.6).clamp(0.0, 1.0) as f32;
            self.joints.push([joints[below], joints[next], 0, 0]);
            self.weights.push([1.0 - share, share, 0.0, 0.0]);
        }
        self.shape = self.shape.and(&limb);
        self
    }

    /// At rest its joints are here, unturned. The boxes of what they move are taken once.
    fn bound(mut self, rest: Vec<DVec3>) -> Result<(Self, JointBoxes), SceneSpecError> {
        self.inverse_binds = rest.iter().map(|r| Transform::from_translation(-*r)).collect();
        self.rest = rest;
        let boxes = JointBoxes::new(&self.skin())?;
        Ok((self, boxes))
    }

    fn skin(&self) -> Skin<'_> {
        Skin {
            positions: &self.shape.positions,
            joints: &self.joints,
            weights: &self.weights,
            inverse_binds: &self.inverse_binds,
        }
    }

    /// Adds a shape that one joint carries whole.
    fn rigid(mut self, shape: &Shape, joint: u16) -> Self {
        self.joints.extend(shape.positions.iter().map(|_| [joint, 0, 0, 0]));
        self.weights.extend(shape.positions.iter().map(|_| [1.0, 0.0, 0.0, 0.0]));
        self.shape = self.shape.and(shape);
        self
    }
}

const HIP: f64 = 0.95;
const SHOULDER: f64 = 1.5;

/// A figure of 1.8 m that faces +z. Joints: 0 body, 1 and 2 left leg, 3 and 4 right leg, 5 and 6
/// left arm, 7 and 8 right arm.
fn person() -> Result<(Rigged, JointBoxes), SceneSpecError> {
    let x = 0.12;
    let body = Shape::lathe(&[[0.16, 0.9], [0.2, 1.0], [0.24, 1.45], [0.1, 1.56]], 8);
    let head = Shape::icosphere(2).scaled([0.13, 0.16, 0.13], [0.0, 1.7, 0.0]);
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let rest = vec![
        DVec3::ZERO,
        at(x, HIP),
        at(x, 0.5),
        at(-x, HIP),
        at(-x, 0.5),
        at(0.3, SHOULDER),
        at(0.3, 1.15),
        at(-0.3, SHOULDER),
        at(-0.3, 1.15),
    ];
    Rigged::default()
        .rigid(&body, 0)
        .rigid(&head, 0)
        .limb(at(x, HIP), 0.02, 0.09, &[1, 2])
        .limb(at(-x, HIP), 0.02, 0.09, &[3, 4])
        .limb(at(0.3, SHOULDER), 0.8, 0.06, &[5, 6])
        .limb(at(-0.3, SHOULDER), 0.8, 0.06, &[7, 8])
        .bound(rest)
}

/// Turned about x by `turns`, at `place`.
fn hinge(turns: f64, place: DVec3) -> DAffine3 {
    let (s, c) = sin_cos(turns);
    let x = DVec3::X;
    let matrix3 = glam::DMat3::from_cols(x, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c));
    DAffine3 { matrix3, translation: place }
}

/// The joints of a walking person at a phase of the step, in turns.
fn stride(rest: &[DVec3], phase: f64) -> Vec<DAffine3> {
    let (swing, _) = sin_cos(phase);
    let (lift, _) = sin_cos(phase * 2.0);
    let body = hinge(0.0, DVec3::new(0.0, 0.02 * lift, 0.0));
    let mut joints = vec![body];
    // Legs bend back at the knee, arms forward at the elbow; each arm goes with the other leg.
    for (first, swing, bend) in
        [(1, swing, 0.12), (3, -swing, 0.12), (5, -swing, -0.12), (7, swing, -0.12)]
    {
        let upper = body * hinge(swing * 0.09, rest[first] - rest[0]);
        let (bent, _) = sin_cos(phase + if swing < 0.0 { 0.5 } else { 0.0 });
        let lower = hinge(bend * (0.3 + 0.7 * bent.abs()), rest[first + 1] - rest[first]);
        joints.extend([upper, upper * lower]);
    }
    joints
}

const WEED_JOINTS: u16 = 6;
const WEED_HEIGHT: f64 = 4.0;

/// A stalk of 4 m on six joints; the first is the lowest.
fn weed() -> Result<(Rigged, JointBoxes), SceneSpecError> {
    let joints: Vec<u16> = (0..WEED_JOINTS).rev().collect();
    let step = WEED_HEIGHT / f64::from(WEED_JOINTS);
    let rest = (0..WEED_JOINTS).map(|j| DVec3::new(0.0, f64::from(j) * step, 0.0)).collect();
    Rigged::default().limb(DVec3::new(0.0, WEED_HEIGHT, 0.0), 0.0, 0.18, &joints).bound(rest)
}

/// The joints of a swaying stalk: each leans a little more than the one below, and later.
fn sway(rest: &[DVec3], phase: f64) -> Vec<DAffine3> {
    let mut at = DAffine3::IDENTITY;
    let mut last = DVec3::ZERO;
    rest.iter()
        .enumerate()
        .map(|(j, r)| {
            let (s, _) = sin_cos(phase - j as f64 * 0.08);
            at *= hinge(s * 0.05, *r - last);
            last = *r;
            at
        })
        .collect()
}

/// A drop of 1 m on the ground and what it morphs to: tall, wide, and with a nose.
fn drop() -> (Shape, [Vec<[f32; 3]>; 3]) {
    let base = Shape::icosphere(3).scaled([0.5; 3], [0.0, 0.75, 0.0]);
    let pull = |f: fn([f32; 3]) -> [f32; 3]| base.positions.iter().map(|p| f(*p)).collect();
    let targets = [
        pull(|p| [0.0, (p[1] - 0.25) * 0.8, 0.0]),
        pull(|p| [p[0] * 0.7, 0.0, p[2] * 0.7]),
        pull(|p| [0.0, 0.0, if p[2] > 0.3 { (p[2] - 0.3) * 5.0 } else { 0.0 }]),
    ];
    (base, targets)
}

/// A mover's circle, and how far round it is.
struct Way {
    centre: [f64; 3],
    radius: f64,
    turns: f64,
}

impl Way {
    /// Where it is, looking along its way with +z.
    fn place(&self, scale: f64) -> Transform {
        let (s, c) = sin_cos(self.turns);
        let [x, y, z] = self.centre;
        let at = [x + c * self.radius, y, z - s * self.radius];
        turned(self.turns + 0.5, [scale; 3], at)
    }
}

impl SceneBuilder {
    /// Adds a mesh of its own for one instance that deforms, under bounds that were made without
    /// it.
    fn deformed(
        &mut self,
        name: &str,
        shape: Shape,
        material: u32,
        place: Transform,
        bounds: &Aabb,
    ) -> Result<(), SceneSpecError> {
        let mut data = mesh_data(&[(shape, material)], false, Alpha::Opaque);
        data.deformable = true;
        let mesh = self.model.scene.add_mesh(Mesh::new(data)?);
        self.model.mesh_names.push(name.to_owned());
        let bounds = BoundsOverride::World(place.transform_box(bounds, [0.0; 3]));
        self.model.scene.add(Instance { bounds, ..Instance::new(mesh, place) })?;
        Ok(())
    }

    fn skinned(
        &mut self,
        name: &str,
        (rigged, boxes): &(Rigged, JointBoxes),
        joints: &[DAffine3],
        material: u32,
        place: Transform,
    ) -> Result<(), SceneSpecError> {
        let joints: Vec<Transform> = joints.iter().map(transform).collect();
        let bounds = boxes.bounds(&joints, [0.0; 3]);
        let positions = rigged.skin().pose(&joints)?;
        let shape = Shape { positions, indices: rigged.shape.indices.clone() };
        self.deformed(name, shape, material, place, &bounds)
    }
}

fn transform(a: &DAffine3) -> Transform {
    let column = |c: DVec3| c.as_vec3().to_array();
    let m = a.matrix3;
    Transform {
        linear: [column(m.x_axis), column(m.y_axis), column(m.z_axis)],
        translation: a.translation.into(),
    }
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let n = spec.get("n") as u32;
    let t = spec.get("t") as f64 * 1e-3;
    let mut rng = Rng::new(spec.get("seed"), 1);
    let mut b = SceneBuilder::new(spec);
    let paving = b.material("paving", 0xB9B4AA);
    let stone = b.material("stone", 0x8D8B86);
    let wood = b.material("wood", 0xA9773F);
    let leaf = b.material("weed", 0x5E8C3A);
    let water = b.material("drop", 0x56B4E9);
    let clothes = [0xD55E00, 0x0072B2, 0xE69F00, 0xCC79A7]
        .map(|colour| b.material(&format!("cloth {colour:06x}"), colour));
    let (person, weed, (base, targets)) = (person()?, weed()?, drop());
    let targets: Vec<&[[f32; 3]]> = targets.iter().map(Vec::as_slice).collect();
    let morphs = Morphs { positions: &base.positions, targets: &targets };
    let drop_bounds = MorphBounds::new(&morphs)?;
    let floor = b.mesh("floor", &[(Shape::building(1), paving)], Sides::One)?;
    let wall = b.mesh("wall", &[(Shape::building(1), stone)], Sides::One)?;
    let wheel = |x: f64, z: f64| {
        // Turned about x: the lathe's axis becomes the axle.
        let wheel = Shape::lathe(&[[0.35, -0.06], [0.35, 0.06]], 16);
        wheel.map(|p| DVec3::new(p.y + x, -p.x + 0.35, p.z + z))
    };
    let wheels = [(0.6, 0.7), (-0.6, 0.7), (0.6, -0.7), (-0.6, -0.7)];
    let cart = wheels
        .iter()
        .fold(Shape::cuboid([-0.5, 0.4, -1.2], [0.5, 1.1, 1.2]), |s, &(x, z)| s.and(&wheel(x, z)));
    let cart = b.mesh("cart", &[(cart, wood)], Sides::One)?;

    let side = f64::from(n).sqrt().ceil();
    let reach = side * PITCH * 0.5;
    let edge = reach + 2.0;
    b.add(floor, fill([-edge, -0.5, -edge], [edge, 0.0, edge]))?;
    for i in 0..n {
        let row = (f64::from(i) / side).floor();
        let column = f64::from(i) - row * side;
        let centre = [(column + 0.5) * PITCH - reach, 0.0, (row + 0.5) * PITCH - reach];
        // A wall at every eighth place, between it and the next.
        if i % 8 == 3 {
            let [x, _, z] = centre;
            let z = z + PITCH * 0.5;
            b.add(wall, fill([x - 2.4, 0.0, z - 0.1], [x + 2.4, 2.6, z + 0.1]))?;
        }
        let (start, pace) = (rng.unit(), rng.range(0.7, 1.3));
        let radius = rng.range(0.8, 1.3);
        let speed = [0.25, 0.18, 0.0, 0.02][i as usize % 4];
        let way = Way { centre, radius, turns: start + t * speed * pace };
        match i % 4 {
            0 => _ = b.add(cart, way.place(1.0))?,
            1 => {
                let joints = stride(&person.0.rest, start + t * pace);
                let cloth = clothes[rng.below(4)];
                let scale = rng.range(0.9, 1.1);
                b.skinned("person", &person, &joints, cloth, way.place(scale))?;
            }
            2 => {
                let joints = sway(&weed.0.rest, start + t * 0.3 * pace);
                let scale = rng.range(0.6, 1.2);
                b.skinned("weed", &weed, &joints, leaf, way.place(scale))?;
            }
            _ => {
                let weight =
                    |shift: f64, rate: f64| sin_cos(start + shift + t * rate * pace).0 as f32;
                let weights = [weight(0.0, 0.5), weight(0.3, 0.4) * 0.9, weight(0.6, 0.3) * 0.5];
                let bounds = drop_bounds.bounds(&weights);
                let positions = morphs.pose(&weights)?;
                let shape = Shape { positions, indices: base.indices.clone() };
                b.deformed("drop", shape, water, way.place(1.0), &bounds)?;
            }
        }
    }
    let text = spec.canonical();
    let make = move |seconds| crate::build_at(&text, seconds).map_err(|e| e.to_string());
    b.model.motion = Some(Motion::made(make));
    Ok(b.finish())
}
