//! Coarse stand-ins: one mesh in the place of many instances that are far away, of the levels of
//! detail and the [merged groups](cullet::Scene::stand_for) that a scene has already. Nothing is
//! simplified here, so that errors are those that were measured when the scene was baked.
//!
//! After C. Erikson, D. Manocha, W. Baxter, *HLODs for faster display of large static and dynamic
//! environments*, 2001.

use std::collections::HashMap;

use cullet::bounds::Aabb;
use cullet::{MeshData, Scene};

use crate::gather::{Piece, Surface};

pub use crate::gather::MeshAttributes;

/// A mesh in the place of many instances.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// Its triangles, with parts by material; without normals.
    pub mesh: MeshData,
    /// Texture coordinates of its vertices; empty where no instance has any.
    pub uvs: Vec<[f32; 2]>,
    /// Their colours, linear and with alpha; empty where no instance has any.
    pub colors: Vec<[f32; 4]>,
    /// Where its origin is in the world.
    pub origin: [f64; 3],
    /// How far it is off at the most, in units of the world: the largest error of the levels and
    /// groups that it is made of, and the longest diagonal of an instance that is left out.
    pub error: f64,
}

/// Options that decide which stand-ins are made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StandInOptions {
    /// The most triangles of one. Default: 16,384.
    pub triangles: u64,
    /// The error that is allowed at first, in radii of what it stands for, above 0; it is doubled
    /// until there are few enough triangles. Default: 1/2048, a pixel of 60° and 1080 lines at half
    /// a radius.
    pub first: f64,
}

impl Default for StandInOptions {
    fn default() -> Self {
        Self { triangles: 1 << 14, first: 1.0 / 2048.0 }
    }
}

impl StandInOptions {
    /// Returns a copy with `triangles`.
    #[must_use]
    pub fn with_triangles(self, triangles: u64) -> Self {
        Self { triangles, ..self }
    }
}

/// Stand-ins of instances of a scene.
#[derive(Debug)]
pub struct StandIns<'a> {
    scene: &'a Scene,
    attributes: &'a [MeshAttributes<'a>],
    options: StandInOptions,
    groups: Vec<Group>,
    /// Number of the group that stands for each slot.
    group_of: Vec<Option<u32>>,
}

/// A merged group of the scene.
#[derive(Debug)]
struct Group {
    slot: u32,
    above: Option<u32>,
    is_off: bool,
    /// Instances, and groups of lower numbers.
    instances: Vec<u32>,
    below: Vec<u32>,
    /// All instances below.
    count: u32,
}

impl<'a> StandIns<'a> {
    /// Prepares stand-ins for a scene, with the attributes of its meshes by their numbers; meshes
    /// beyond the end have none. O(slots), and the square of the number of merged groups.
    #[must_use]
    pub fn new(
        scene: &'a Scene,
        attributes: &'a [MeshAttributes<'a>],
        options: StandInOptions,
    ) -> Self {
        let slots: Vec<u32> = scene.stand_in_slots().collect();
        let number_of: HashMap<u32, u32> = slots.iter().copied().zip(0..).collect();
        let above = |slot: u32| scene.stand_in_of(slot).and_then(|by| number_of.get(&by).copied());
        let mut groups: Vec<Group> = slots
            .iter()
            .map(|&slot| Group {
                slot,
                above: above(slot),
                is_off: scene.is_stand_in_off(slot),
                instances: Vec::new(),
                below: Vec::new(),
                count: 0,
            })
            .collect();
        let mut group_of = vec![None; scene.slot_count() as usize];
        for slot in scene.slots() {
            if let Some(group) = above(slot) {
                group_of[slot as usize] = Some(group);
                groups[group as usize].instances.push(slot);
            }
        }
        // Those below others come before them.
        for number in 0..groups.len() {
            groups[number].count += groups[number].instances.len() as u32;
            if let Some(above) = groups[number].above {
                groups[above as usize].below.push(number as u32);
                groups[above as usize].count += groups[number].count;
            }
        }
        Self { scene, attributes, options, groups, group_of }
    }

    /// One mesh in the place of some instances: the fewest triangles that their levels and those
    /// merged groups have which stand for no other, within a bound that is doubled until there are
    /// [few enough](StandInOptions::triangles). What is no longer across than the bound is left
    /// out. The bound, and the error that is stated, are not below `least`: those of what it is
    /// made to stand above. `None` where nothing would be left of it.
    ///
    /// Points of the instances that are in it are within the error of the mesh, and its points of
    /// theirs, as far as their levels were measured. It covers what is seen between the instances,
    /// so that it must not occlude: [`no_occlusion`](cullet::InstanceFlags::no_occlusion). What
    /// deforms stands as the scene has it; layers are not looked at.
    ///
    /// Cost: some ten choices of levels for each instance, and putting triangles together.
    #[must_use]
    pub fn of(&self, slots: &[u32], least: f64) -> Option<StandIn> {
        let origin = self.scene.origin();
        let around = slots.iter().map(|&s| self.scene.bounds(s));
        let around = around.fold(Aabb::EMPTY, |a, b| a.union(&b));
        let radius = diagonal(&around) * 0.5;
        if !(radius > 0.0 && radius < 1e15) {
            return None;
        }
        let finest = radius * self.options.first;
        let mut bound = least.max(finest);
        let (tops, loose) = self.split(slots);
        let (pieces, error) = loop {
            let mut made = Made::default();
            let mut triangles = 0;
            for &group in &tops {
                triangles += self.add_group(group, bound, &mut made);
            }
            for &slot in &loose {
                triangles += self.add_instance(slot, bound, &mut made);
            }
            if triangles == 0 {
                return None;
            }
            if triangles <= self.options.triangles {
                break (made.pieces, made.left_out);
            }
            bound *= 2.0;
        };
        let error = pieces.iter().map(|p| p.error).fold(error, f64::max);
        let middle: [f64; 3] = std::array::from_fn(|a| {
            (f64::from(around.min[a]) + f64::from(around.max[a])) * 0.5 + origin[a]
        });
        let surface = Surface::gather(
            self.scene,
            self.attributes,
            pieces.into_iter(),
            middle,
            &mut Vec::new(),
        );
        let error = error.max(least).max(finest);
        (!surface.indices.is_empty()).then(|| finished(surface, middle, error))
    }

    /// The largest groups that stand for none but some instances, and those of the instances that
    /// are in no such group.
    fn split(&self, slots: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let group_of = |slot: u32| self.group_of.get(slot as usize).copied().flatten();
        let mut within = vec![0_u32; self.groups.len()];
        slots.iter().filter_map(|&slot| group_of(slot)).for_each(|g| within[g as usize] += 1);
        for (number, group) in self.groups.iter().enumerate() {
            if let Some(above) = group.above {
                within[above as usize] += within[number];
            }
        }
        let is_whole = |number: u32| {
            let group = &self.groups[number as usize];
            !group.is_off && group.count > 0 && within[number as usize] == group.count
        };
        let has_whole_above = |group: &Group| group.above.is_some_and(is_whole);
        let tops = (0..).zip(&self.groups);
        let tops = tops.filter(|&(n, group)| is_whole(n) && !has_whole_above(group));
        let tops = tops.map(|(number, _)| number).collect();
        let loose = slots.iter().copied().filter(|&slot| !group_of(slot).is_some_and(is_whole));
        (tops, loose.collect())
    }

    /// Adds the fewest triangles of a group within a bound; how many. As deep as groups lie within
    /// each other.
    fn add_group(&self, number: u32, bound: f64, made: &mut Made) -> u64 {
        let group = &self.groups[number as usize];
        let mut members = Made::default();
        let below = group.below.iter().map(|&b| self.add_group(b, bound, &mut members));
        let mut triangles: u64 = below.sum();
        for &slot in &group.instances {
            triangles += self.add_instance(slot, bound, &mut members);
        }
        match Piece::of_levels(self.scene, group.slot, bound) {
            Some(own) if own.triangles < triangles => {
                triangles = own.triangles;
                made.pieces.push(own);
            }
            _ => {
                made.pieces.append(&mut members.pieces);
                made.left_out = made.left_out.max(members.left_out);
            }
        }
        triangles
    }

    /// Adds the fewest triangles of an instance within a bound, none where it is no longer across;
    /// how many.
    fn add_instance(&self, slot: u32, bound: f64, made: &mut Made) -> u64 {
        let across = diagonal(&self.scene.bounds(slot));
        if across <= bound {
            made.left_out = made.left_out.max(across);
            return 0;
        }
        let piece = Piece::within(self.scene, slot, bound);
        let triangles = piece.triangles;
        made.pieces.push(piece);
        triangles
    }
}

/// Ingredients of a stand-in.
#[derive(Default)]
struct Made {
    pieces: Vec<Piece>,
    /// The longest diagonal of an instance that is left out.
    left_out: f64,
}

fn finished(surface: Surface, origin: [f64; 3], error: f64) -> StandIn {
    let Surface { positions, values, indices, mut parts } = surface;
    parts.retain(|part| part.triangle_count > 0);
    let uvs: Vec<[f32; 2]> = values.iter().map(|&[u, v, ..]| [u, v]).collect();
    let colors: Vec<[f32; 4]> = values.iter().map(|&[.., r, g, b, a]| [r, g, b, a]).collect();
    let has_uvs = uvs.iter().any(|v| *v != [0.0; 2]);
    let has_colors = colors.iter().any(|v| *v != [1.0; 4]);
    StandIn {
        mesh: MeshData { positions, indices, parts, ..MeshData::default() },
        uvs: if has_uvs { uvs } else { Vec::new() },
        colors: if has_colors { colors } else { Vec::new() },
        origin,
        error,
    }
}

fn diagonal(bounds: &Aabb) -> f64 {
    let side = |a: usize| f64::from(bounds.max[a]) - f64::from(bounds.min[a]);
    (0..3).map(|a| side(a) * side(a)).sum::<f64>().sqrt()
}
