//! Instances that stand for others, as they lie in files.

use std::collections::HashMap;

use cullet::mesh::Part;
use cullet::{Handle, Instance, Mesh, MeshData, Scene, Transform};

use super::hash::{Sum, hash};
use super::{BakedError, LevelTables};
use crate::Attributes;
use crate::bytes::of_f32s;

/// One that stands for others.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StandInTables {
    /// Where the origin of its mesh is.
    pub(crate) origin: [f64; 3],
    /// The instances that it stands for, by their numbers in the order of the file.
    pub(crate) instances: Vec<u32>,
    /// The others that it stands for, by their numbers in the list, lower than its own.
    pub(crate) stand_ins: Vec<u32>,
    /// For each part an instance below it, and which of its parts that have triangles it is drawn
    /// like.
    pub(crate) like: Vec<[u32; 2]>,
    pub(crate) positions: Vec<[f32; 3]>,
    /// Texture coordinates and colours of the vertices, where there are any.
    pub(crate) attributes: Attributes,
    pub(crate) levels: LevelTables,
    /// How many triangles all instances below have, by which it is known that they are still the
    /// same.
    pub(crate) triangles: u64,
}

/// The sum of a list: of tables by their bytes.
pub(crate) fn sum_of(all: &[(&StandInTables, [&[u8]; 4])]) -> u64 {
    let mut sum = Sum::new(all.len() as u64);
    for (of, tables) in all {
        of.origin.iter().for_each(|v| sum.add(v.to_bits()));
        for list in [&of.instances, &of.stand_ins, &of.levels.parts] {
            sum.add(list.len() as u64);
            list.iter().for_each(|&v| sum.add(v.into()));
        }
        of.like.as_flattened().iter().for_each(|&v| sum.add(v.into()));
        sum.add(of.triangles);
        tables.iter().for_each(|bytes| sum.add(hash(bytes)));
    }
    sum.end()
}

/// The sum of the attributes of one: of their bytes, texture coordinates and colours, which are
/// empty where there are none.
pub(crate) fn attribute_sum(tables: [&[u8]; 2]) -> u64 {
    let mut sum = Sum::new(2);
    tables.iter().for_each(|bytes| sum.add(hash(bytes)));
    sum.end()
}

/// The instances of a scene in the order of its file: by their handles, which are given in that
/// order.
fn in_order(scene: &Scene) -> Vec<Handle> {
    let mut all: Vec<Handle> = scene.slots().filter_map(|slot| scene.handle(slot)).collect();
    all.sort_unstable_by_key(|handle| handle.index);
    all
}

impl StandInTables {
    /// Returns the stand-ins of a scene that are switched on; `written` says which instances are
    /// written; they are written in the order of their handles. A stand-in is left out, with all
    /// above it, if one of its instances is not written, or if it has a part that is drawn like no
    /// part of what it stands for. `attributes` holds those of the scene's meshes, by mesh number.
    pub(crate) fn all_of(
        scene: &Scene,
        attributes: &[Attributes],
        written: impl Fn(u32) -> bool,
    ) -> Vec<Self> {
        let mut number_of: HashMap<u32, u32> = HashMap::new();
        for handle in in_order(scene) {
            if let Ok(slot) = scene.slot(handle)
                && written(slot)
            {
                number_of.insert(slot, number_of.len() as u32);
            }
        }
        // By the slot of who stands for them.
        let mut members: HashMap<u32, [Vec<u32>; 2]> = HashMap::new();
        for slot in scene.slots() {
            if let Some(by) = scene.stand_in_of(slot) {
                members.entry(by).or_default()[0].push(slot);
            }
        }
        for slot in scene.stand_in_slots() {
            if let Some(by) = scene.stand_in_of(slot) {
                members.entry(by).or_default()[1].push(slot);
            }
        }
        let mut out: Vec<Self> = Vec::new();
        let mut stand_in_of: HashMap<u32, u32> = HashMap::new();
        for slot in scene.stand_in_slots() {
            let Some([instances, below]) = members.get(&slot) else { continue };
            let found = Self::of(scene, slot, (instances, &number_of), (below, &stand_in_of));
            if let Some(mut one) = found {
                if let Some(own) = attributes.get(scene.mesh_id(slot) as usize) {
                    one.set_attributes(own);
                }
                stand_in_of.insert(slot, out.len() as u32);
                out.push(one);
            }
        }
        out
    }

    fn of(
        scene: &Scene,
        slot: u32,
        (instances, number_of): (&[u32], &HashMap<u32, u32>),
        (below, stand_in_of): (&[u32], &HashMap<u32, u32>),
    ) -> Option<Self> {
        if scene.is_stand_in_off(slot) {
            return None;
        }
        let numbers = |slots: &[u32], of: &HashMap<u32, u32>| {
            let numbers: Option<Vec<u32>> =
                slots.iter().map(|slot| of.get(slot).copied()).collect();
            numbers.map(|mut numbers| {
                numbers.sort_unstable();
                numbers
            })
        };
        let levels = scene.levels(scene.mesh_id(slot)).first()?;
        let held_by = scene.meshes().get(levels.mesh as usize)?;
        let m = scene.transform(slot).to_matrix();
        let tables = LevelTables::of(held_by, &levels.levels)?;
        let all = scene.stood_for_by(slot);
        // Parts that have triangles, of each mesh once.
        let mut kinds: HashMap<(u32, bool, u8), [u32; 2]> = HashMap::new();
        let mut seen = std::collections::HashSet::new();
        for &slot in &all {
            if seen.insert(scene.mesh_id(slot)) {
                let number = *number_of.get(&slot)?;
                for (at, part) in (0..).zip(drawn_parts(scene.mesh(slot))) {
                    kinds.entry(kind(part)).or_insert([number, at]);
                }
            }
        }
        let like: Option<Vec<[u32; 2]>> =
            held_by.parts().iter().map(|part| kinds.get(&kind(part)).copied()).collect();
        Some(Self {
            origin: [m[12], m[13], m[14]],
            instances: numbers(instances, number_of)?,
            stand_ins: numbers(below, stand_in_of)?,
            like: like?,
            positions: held_by.positions().to_vec(),
            attributes: Attributes::default(),
            levels: tables,
            triangles: all.iter().map(|&s| u64::from(scene.mesh(s).triangle_count())).sum(),
        })
    }

    /// Takes over lists that are of all its vertices; it has no normals.
    fn set_attributes(&mut self, own: &Attributes) {
        let vertices = self.positions.len();
        if own.uvs.len() == vertices {
            self.attributes.uvs.clone_from(&own.uvs);
        }
        if own.colors.len() == vertices {
            self.attributes.colors.clone_from(&own.colors);
        }
    }

    /// The bytes of its attributes: texture coordinates and colours.
    pub(crate) fn attributes_to_bytes(&self) -> [Vec<u8>; 2] {
        let Attributes { uvs, colors, .. } = &self.attributes;
        [of_f32s(uvs.as_flattened()), of_f32s(colors.as_flattened())]
    }

    /// The bytes of its tables: positions, indices, clusters, groups.
    pub(crate) fn to_bytes(&self) -> [Vec<u8>; 4] {
        let [indices, clusters, groups] = self.levels.to_bytes();
        [of_f32s(self.positions.as_flattened()), indices, clusters, groups]
    }

    /// Adds all of a list to a scene whose instances are those of the file, and to the names and
    /// attributes of its meshes.
    ///
    /// # Errors
    /// If one does not fit it; then none is added, but meshes may have been.
    pub(crate) fn give(
        all: Vec<Self>,
        scene: &mut Scene,
        names: &mut Vec<String>,
        attributes: &mut Vec<Attributes>,
    ) -> Result<(), BakedError> {
        let handles = in_order(scene);
        let mut given: Vec<Handle> = Vec::with_capacity(all.len());
        let mut below: Vec<u64> = Vec::with_capacity(all.len());
        let result = (|| {
            for mut one in all {
                let triangles = one.triangles;
                let own = std::mem::take(&mut one.attributes);
                let (handle, found) = one.give_one(scene, &handles, (&given, &below), names)?;
                if found != triangles {
                    let (what, expected) = ("triangles that one stands for", triangles);
                    return Err(BakedError::Count { what, found, expected });
                }
                if !own.is_empty()
                    && let Ok(slot) = scene.slot(handle)
                {
                    attributes.resize(scene.mesh_id(slot) as usize, Attributes::default());
                    attributes.push(own);
                }
                given.push(handle);
                below.push(triangles);
            }
            Ok(())
        })();
        if result.is_err() {
            scene.clear_stand_ins();
        }
        result
    }

    fn give_one(
        self,
        scene: &mut Scene,
        handles: &[Handle],
        (given, below): (&[Handle], &[u64]),
        names: &mut Vec<String>,
    ) -> Result<(Handle, u64), BakedError> {
        let lacks = |what: &str, number: u32, count: usize| {
            BakedError::Form(format!("one stands for {what} {number} of {count}"))
        };
        let instance = |number: u32| {
            let handle = handles.get(number as usize).copied();
            handle.ok_or_else(|| lacks("instance", number, handles.len()))
        };
        let mut members = Vec::with_capacity(self.instances.len() + self.stand_ins.len());
        let mut triangles = 0;
        let slot_of =
            |scene: &Scene, handle| scene.slot(handle).map_err(|e| BakedError::Form(e.to_string()));
        for &number in &self.instances {
            let handle = instance(number)?;
            triangles += u64::from(scene.mesh(slot_of(scene, handle)?).triangle_count());
            members.push(handle);
        }
        for &number in &self.stand_ins {
            let handle = given.get(number as usize).copied();
            members.push(handle.ok_or_else(|| lacks("stand-in", number, given.len()))?);
            triangles += below[number as usize];
        }
        let mut parts: Vec<Part> = Vec::with_capacity(self.like.len());
        for &[number, part] in &self.like {
            let slot = slot_of(scene, instance(number)?)?;
            let like = drawn_parts(scene.mesh(slot)).nth(part as usize);
            let like = like
                .ok_or_else(|| lacks("the like of part", part, scene.mesh(slot).parts().len()))?;
            parts.push(Part { first_triangle: 0, triangle_count: 0, ..*like });
        }
        // A mesh of no triangles: the levels bring all.
        let base = Mesh::new(MeshData { positions: self.positions, parts, ..MeshData::default() })?;
        let (held_by, levels) = self.levels.build(&base)?;
        let name = format!("{} merged instances", members.len());
        let mesh = scene.add_mesh(held_by);
        names.resize(mesh as usize, String::new());
        names.push(name);
        scene.add_levels(mesh, mesh, levels)?;
        let form = |e: &dyn std::fmt::Display| BakedError::Form(e.to_string());
        let transform = Transform::from_translation(self.origin);
        if !transform.is_finite() {
            return Err(BakedError::Form("the origin of a stand-in is not finite".to_owned()));
        }
        let own = scene.add(Instance::new(mesh, transform)).map_err(|e| form(&e))?;
        if let Err(e) = scene.stand_for(own, &members) {
            let _ = scene.remove(own);
            return Err(form(&e));
        }
        Ok((own, triangles))
    }
}

/// The parts of a mesh that have triangles.
fn drawn_parts(mesh: &Mesh) -> impl Iterator<Item = &Part> {
    mesh.parts().iter().filter(|part| part.triangle_count > 0)
}

/// Returns what a part is drawn by: material, sidedness and alpha mode.
fn kind(part: &Part) -> (u32, bool, u8) {
    (part.material, part.two_sided, part.alpha as u8)
}
