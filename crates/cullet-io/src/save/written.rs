//! Instances of a model that a file has, and notes about what it does not have.

use cullet::Handle;

use super::{SaveErrorKind, SaveFormat};
use crate::{Model, Motion, Warning, place};

/// How many instances a note names.
const NAMED: usize = 3;

/// Summary of a file that was written.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Saved {
    /// Instances in the file.
    pub instances: u64,
    /// Triangles in the file, those of each instance.
    pub triangles: u64,
    /// The place in the world that the zero of the file stands for. Not zero only in an STL whose
    /// 32-bit numbers would be too coarse there; its header names the place too.
    pub origin: [f64; 3],
    /// How far a vertex of an STL is from its place at the most, in world units. 0 in other formats,
    /// which keep places as exactly as the model has them, or round them far below what its
    /// instances show.
    pub rounding: f64,
    /// Notes about everything that was left out or changed, and why.
    pub notes: Vec<Warning>,
}

/// The instances of a model that a file of a format has.
pub(super) struct Written<'a> {
    pub(super) model: &'a Model,
    /// In ascending order.
    pub(super) slots: Vec<u32>,
    pub(super) vertices: u64,
    /// Whether f32 is coarse for the size of an instance where it is.
    pub(super) is_far: bool,
    pub(super) saved: Saved,
}

impl<'a> Written<'a> {
    pub(super) fn of(model: &'a Model, format: SaveFormat) -> Self {
        let scene = &model.scene;
        let mut saved = Saved::default();
        let is_finite = |slot: &u32| scene.transform(*slot).is_finite();
        let (mut slots, lost): (Vec<u32>, Vec<u32>) = scene.slots().partition(is_finite);
        saved.note(model, &lost, "a transform that is not finite, which no file has a place for");
        let mut is_far = false;
        match format {
            SaveFormat::Glb => {
                let draws = |slot: &u32| scene.mesh(*slot).triangle_count() > 0;
                let (drawn, empty): (Vec<u32>, _) = slots.into_iter().partition(draws);
                slots = drawn;
                saved.note(model, &empty, "no triangles, and a mesh without any is no glTF");
            }
            SaveFormat::Ply => is_far = place::is_far(scene, saved.origin),
            SaveFormat::Stl => {
                saved.origin = place::local_origin(scene);
                is_far = place::is_far(scene, saved.origin);
            }
            SaveFormat::Obj => {}
        }
        let sum = |of: fn(&cullet::Mesh) -> u64| slots.iter().map(|&s| of(scene.mesh(s))).sum();
        saved.instances = slots.len() as u64;
        saved.triangles = sum(|m| m.triangle_count().into());
        let vertices = sum(|m| m.positions().len() as u64);
        saved.leave_out(model, format);
        Self { model, slots, vertices, is_far, saved }
    }

    /// Holds counts against the limits of a format.
    pub(super) fn check(&self, format: SaveFormat) -> Result<(), SaveErrorKind> {
        let limit = u64::from(u32::MAX);
        let (what, count) = match format {
            SaveFormat::Ply => ("vertices", self.vertices),
            SaveFormat::Stl => ("triangles", self.saved.triangles),
            SaveFormat::Glb | SaveFormat::Obj => return Ok(()),
        };
        if count > limit { Err(SaveErrorKind::TooMany { what, count, limit }) } else { Ok(()) }
    }
}

impl Saved {
    /// Notes instances that are left out, because they have `defect`.
    fn note(&mut self, model: &Model, slots: &[u32], defect: &str) {
        if slots.is_empty() {
            return;
        }
        let mut handles: Vec<Handle> =
            slots.iter().filter_map(|&slot| model.scene.handle(slot)).collect();
        handles.sort_unstable_by_key(|handle| handle.index);
        let names = handles.iter().take(NAMED).map(|&h| format!("\"{}\"", model.instance_name(h)));
        let mut names = names.collect::<Vec<_>>().join(", ");
        if slots.len() > NAMED {
            names += ", ...";
        }
        let (count, have) = match slots.len() {
            1 => ("1 instance".to_owned(), "it has"),
            n => (format!("{n} instances"), "they have"),
        };
        self.say(count, format!("left out, for {have} {defect}: {names}"));
    }

    /// Notes what the format has no place for.
    fn leave_out(&mut self, model: &Model, format: SaveFormat) {
        let is_glb = format == SaveFormat::Glb;
        let has_levels =
            (0..model.scene.meshes().len() as u32).any(|mesh| !model.scene.levels(mesh).is_empty());
        let (cameras, cells) = (!model.cameras.is_empty(), !model.cells.cells.is_empty());
        let levels = has_levels && !(is_glb && model.baked.is_some());
        let lost = [
            (model.textures > 0, "textures (not read)"),
            (
                model.motion.as_ref().is_some_and(Motion::moves),
                "motions (it is written as it stands)",
            ),
            (!model.views.is_empty(), "views that are matrices"),
            (model.cell_sets.is_some(), "visible sets of its cells"),
            (levels, "levels of detail"),
            (!is_glb && cameras, "cameras"),
            (!is_glb && cells, "cells and portals"),
        ];
        let lost: Vec<&str> = lost.iter().filter(|l| l.0).map(|l| l.1).collect();
        if !lost.is_empty() {
            let kept = if !is_glb && (cameras || cells) { "; a .glb keeps the last" } else { "" };
            self.say("model", format!("left out: {}{kept}", lost.join(", ")));
        }
    }

    pub(super) fn say(&mut self, item: impl Into<String>, message: impl Into<String>) {
        self.notes.push(Warning { item: item.into(), message: message.into() });
    }
}
