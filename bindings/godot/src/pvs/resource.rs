//! Baked sets as a resource of Godot.

use std::rc::Rc;

use godot::classes::Resource;
use godot::prelude::*;

use super::baked::{Baked, Method};
use crate::convert;

/// Baked visibility of a scene: which of its nodes may be seen from where. `CulletPvsBaker` makes
/// it, Godot saves and loads it like any resource, and `CulletWorld.pvs` uses it.
///
/// Bytes that are damaged or of another version give a warning, and hide nothing.
#[derive(GodotClass)]
#[class(tool, init, base = Resource)]
pub(crate) struct CulletPvs {
    /// The root of the scene that was baked, as seen from the `CulletWorld`: paths of nodes begin
    /// there.
    #[export]
    pub(crate) root: NodePath,
    /// The sets as bytes.
    #[var(get = get_data, set = set_data, usage_flags = [STORAGE])]
    data: PackedByteArray,
    pub(crate) baked: Option<Rc<Baked>>,
    base: Base<Resource>,
}

#[godot_api]
impl CulletPvs {
    /// Returns the sets as bytes.
    #[func]
    fn get_data(&self) -> PackedByteArray {
        self.data.clone()
    }

    /// Takes sets over from bytes. Damaged ones give a warning, and hide nothing.
    #[func]
    fn set_data(&mut self, data: PackedByteArray) {
        self.baked = None;
        if !data.is_empty() {
            match Baked::from_bytes(data.as_slice()) {
                Ok(baked) => self.baked = Some(Rc::new(baked)),
                Err(error) => {
                    let path = self.base().get_path();
                    godot_warn!("{path}: baked visibility is ignored: {error}");
                }
            }
        }
        self.data = data;
    }

    /// Whether it has sets.
    #[func]
    fn is_valid(&self) -> bool {
        self.baked.is_some()
    }

    /// Whether nothing that may be seen is missing from the sets. False for sampled ones.
    #[func]
    fn is_exact(&self) -> bool {
        self.baked.as_ref().is_some_and(|baked| baked.method != Method::Sampled)
    }

    /// The share of looks from a cell that is estimated to go to something that its set lacks: the
    /// mean over the cells, and the most of one. An estimate and no bound; 0 for exact sets.
    #[func]
    fn missing(&self) -> Vector2 {
        let [mean, most] = self.baked.as_ref().map_or([0.0; 2], |baked| baked.missing);
        Vector2::new(mean as f32, most as f32)
    }

    /// How many cells there are.
    #[func]
    fn cell_count(&self) -> i64 {
        self.baked.as_ref().map_or(0, |baked| i64::from(baked.sets.cell_count()))
    }

    /// How many nodes there are, seen or not.
    #[func]
    fn node_count(&self) -> i64 {
        self.baked.as_ref().map_or(0, |baked| baked.nodes.len() as i64)
    }

    /// The boxes in which a camera must be for the sets to hide anything: at least one for each
    /// cell.
    #[func]
    fn boxes(&self) -> Array<Aabb> {
        let all = self.baked.iter().flat_map(|baked| &baked.boxes);
        let vector = |v: [f64; 3]| Vector3::new(v[0] as f32, v[1] as f32, v[2] as f32);
        all.map(|(_, [low, high])| Aabb::from_position_end(vector(*low), vector(*high))).collect()
    }

    /// Paths of the nodes that may be seen from a point, from `root` on; none outside of all cells.
    #[func]
    fn seen_from(&self, position: Vector3) -> PackedStringArray {
        let mut paths = PackedStringArray::new();
        let Some(baked) = &self.baked else { return paths };
        let at = convert::point(position);
        let is_in =
            |[low, high]: &[[f64; 3]; 2]| (0..3).all(|a| low[a] <= at[a] && at[a] <= high[a]);
        let of: Vec<u32> =
            baked.boxes.iter().filter(|(_, b)| is_in(b)).map(|(cell, _)| *cell).collect();
        let row = baked.sets.union(&of);
        for (number, node) in baked.nodes.iter().enumerate() {
            if row[number / 64] >> (number % 64) & 1 == 1 {
                paths.push(&GString::from(&node.path));
            }
        }
        paths
    }
}

impl CulletPvs {
    /// Makes a resource of sets.
    pub(crate) fn of(baked: &Baked, root: NodePath) -> Gd<Self> {
        let data = PackedByteArray::from(baked.to_bytes());
        let mut made = Self::new_gd();
        let mut own = made.bind_mut();
        own.root = root;
        own.set_data(data);
        drop(own);
        made
    }
}
