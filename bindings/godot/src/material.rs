//! Facts of materials: whether a surface hides, and where its vertices may be drawn.

use std::collections::HashMap;

use godot::classes::base_material_3d::{
    BillboardMode, CullMode, DepthDrawMode, DistanceFadeMode, Flags, StencilMode, Transparency,
};
use godot::classes::{BaseMaterial3D, Material, ShaderMaterial};
use godot::obj::InstanceId;
use godot::prelude::*;

/// Where the vertices of a surface may be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reach {
    /// Where they lie, or farther out by a distance in units of the mesh.
    Mesh(f32),
    /// In a ball around the node's origin: billboards.
    Ball,
    /// Wherever a shader moves them.
    Moved,
    /// Before what is nearer, or nearer than they lie: nothing hides them.
    Through,
}

impl Reach {
    /// Returns what holds both.
    pub(crate) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Through, _) | (_, Self::Through) => Self::Through,
            (Self::Moved, _) | (_, Self::Moved) => Self::Moved,
            (Self::Ball, _) | (_, Self::Ball) => Self::Ball,
            (Self::Mesh(a), Self::Mesh(b)) => Self::Mesh(a.max(b)),
        }
    }
}

/// Surfaces of a mesh that hide what is behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Hiding {
    /// One bit a surface; those after the 64th hide nothing.
    pub(crate) surfaces: u64,
    /// Whether both sides of all of them are drawn.
    pub(crate) two_sided: bool,
}

impl Hiding {
    /// All surfaces of a mesh.
    pub(crate) fn all(two_sided: bool) -> Self {
        Self { surfaces: u64::MAX, two_sided }
    }
}

/// Facts of a material and of the passes after it, or of the surfaces of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facts {
    /// Surfaces that hide what is behind them; of a material, all that are drawn by it.
    pub(crate) hides: Option<Hiding>,
    pub(crate) reach: Reach,
}

impl Facts {
    /// A surface without a material: opaque, one-sided, drawn where it lies.
    pub(crate) const PLAIN: Self = Self {
        hides: Some(Hiding { surfaces: u64::MAX, two_sided: false }),
        reach: Reach::Mesh(0.0),
    };

    /// Returns the facts of one surface that is drawn by this material.
    pub(crate) fn of_surface(self, surface: i32) -> Self {
        let surfaces = 1_u64.checked_shl(surface as u32).unwrap_or(0);
        Self { hides: self.hides.map(|hides| Hiding { surfaces, ..hides }), ..self }
    }

    /// Returns the facts of both side by side. What hides of either hides; both sides of it only if
    /// they do of both.
    pub(crate) fn beside(self, other: Self) -> Self {
        let hides = match (self.hides, other.hides) {
            (Some(a), Some(b)) => Some(Hiding {
                surfaces: a.surfaces | b.surfaces,
                two_sided: a.two_sided && b.two_sided,
            }),
            (one, None) | (None, one) => one,
        };
        Self { hides, reach: self.reach.and(other.reach) }
    }
}

/// Facts of materials that were asked for since the last call of [`clear`](Self::clear): scripts
/// change materials without a signal, so that they are asked again in each frame.
#[derive(Debug, Default)]
pub(crate) struct Materials(HashMap<InstanceId, Facts>);

impl Materials {
    /// Forgets all, as a frame begins.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Returns the facts of a material; those of a surface without one for `None`.
    pub(crate) fn facts(&mut self, material: Option<Gd<Material>>) -> Facts {
        let Some(material) = material else { return Facts::PLAIN };
        let id = material.instance_id();
        if let Some(facts) = self.0.get(&id) {
            return *facts;
        }
        let facts = of_passes(material);
        self.0.insert(id, facts);
        facts
    }
}

/// A chain of passes longer than this is taken for one that draws anywhere.
const MOST_PASSES: usize = 8;

fn of_passes(first: Gd<Material>) -> Facts {
    let mut facts = of_one(&first);
    let mut next = first.get_next_pass();
    for _ in 0..MOST_PASSES {
        let Some(pass) = next else { return facts };
        // A later pass draws over what the first left in the depth buffer, which hides as before.
        facts.reach = facts.reach.and(of_one(&pass).reach);
        next = pass.get_next_pass();
    }
    Facts { hides: None, reach: Reach::Through }
}

fn of_one(material: &Gd<Material>) -> Facts {
    let unknown = Facts { hides: None, reach: Reach::Through };
    if let Ok(material) = material.clone().try_cast::<BaseMaterial3D>() {
        return of_base(&material);
    }
    let Ok(material) = material.clone().try_cast::<ShaderMaterial>() else { return unknown };
    let Some(shader) = material.get_shader() else { return Facts::PLAIN };
    Facts { hides: None, reach: of_shader(&shader.get_code().to_string()) }
}

fn of_base(m: &Gd<BaseMaterial3D>) -> Facts {
    let flag = |flag| m.get_flag(flag);
    let stencils = m.get_stencil_mode() != StencilMode::DISABLED;
    let is_through = stencils
        || flag(Flags::DISABLE_DEPTH_TEST)
        || flag(Flags::FIXED_SIZE)
        || flag(Flags::USE_Z_CLIP_SCALE)
        || flag(Flags::USE_FOV_OVERRIDE)
        || flag(Flags::USE_POINT_SIZE)
        || flag(Flags::PARTICLE_TRAILS_MODE)
        || m.get_depth_test() != godot::classes::base_material_3d::DepthTest::DEFAULT;
    let reach = if is_through {
        Reach::Through
    } else if m.get_billboard_mode() != BillboardMode::DISABLED {
        Reach::Ball
    } else if m.is_grow_enabled() {
        Reach::Mesh(m.get_grow().abs())
    } else {
        Reach::Mesh(0.0)
    };
    let culls = m.get_cull_mode();
    let hides = reach == Reach::Mesh(0.0)
        && m.get_transparency() == Transparency::DISABLED
        && culls != CullMode::FRONT
        && m.get_depth_draw_mode() != DepthDrawMode::DISABLED
        && m.get_distance_fade() == DistanceFadeMode::DISABLED
        && m.get_blend_mode() == godot::classes::base_material_3d::BlendMode::MIX
        && !m.is_proximity_fade_enabled()
        && !m.get_feature(godot::classes::base_material_3d::Feature::REFRACTION)
        && !flag(Flags::USE_SHADOW_TO_OPACITY);
    Facts { hides: hides.then(|| Hiding::all(culls == CullMode::DISABLED)), reach }
}

/// Reads where a shader draws. It never hides: what it discards is not looked for.
fn of_shader(code: &str) -> Reach {
    let code = without_comments(code);
    let has = |word: &str| words(&code).any(|w| w == word);
    // What stands in another file may do anything.
    if code.contains("#include") || has("depth_test_disabled") || has("depth_test_inverted") {
        return Reach::Through;
    }
    let stencils = has("stencil_mode") || has("DEPTH") || has("Z_CLIP_SCALE");
    if stencils || has("POINT_SIZE") || has("FOV_OVERRIDE") {
        return Reach::Through;
    }
    // Reading them is no movement, but telling that from writing would take a parser.
    let moves =
        ["POSITION", "VERTEX", "MODELVIEW_MATRIX", "PROJECTION_MATRIX", "skip_vertex_transform"];
    let is_moved = moves.into_iter().any(has) && has("vertex");
    if is_moved { Reach::Moved } else { Reach::Mesh(0.0) }
}

fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

fn without_comments(code: &str) -> String {
    let mut out = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find('/') {
        let (before, from) = rest.split_at(at);
        out.push_str(before);
        let end = match from.as_bytes().get(1) {
            Some(b'/') => from.find('\n').unwrap_or(from.len()),
            Some(b'*') => from.find("*/").map_or(from.len(), |end| end + 2),
            _ => {
                out.push('/');
                1
            }
        };
        out.push(' ');
        rest = &from[end..];
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_that_hides_nothing_takes_nothing_from_its_neighbours() {
        let glass = Facts { hides: None, ..Facts::PLAIN };
        let both_sides = Facts { hides: Some(Hiding::all(true)), ..Facts::PLAIN };
        let of = |all: &[Facts]| {
            let each = (0..).zip(all).map(|(i, facts)| facts.of_surface(i));
            each.reduce(Facts::beside).and_then(|facts| facts.hides)
        };
        assert_eq!(of(&[glass, glass]), None);
        let one = Some(Hiding { surfaces: 0b10, two_sided: true });
        assert_eq!(of(&[glass, both_sides]), one);
        let two = Some(Hiding { surfaces: 0b101, two_sided: false });
        assert_eq!(of(&[both_sides, glass, Facts::PLAIN]), two);
        assert_eq!(Facts::PLAIN.of_surface(64).hides.map(|hides| hides.surfaces), Some(0));
    }

    #[test]
    fn a_shader_that_only_colours_stays_where_its_mesh_is() {
        let code = "shader_type spatial; void fragment() { ALBEDO = vec3(1.0); }";
        assert_eq!(of_shader(code), Reach::Mesh(0.0));
    }

    #[test]
    fn a_shader_that_moves_vertices_is_noticed() {
        let code = "shader_type spatial; void vertex() { VERTEX.y += sin(TIME); }";
        assert_eq!(of_shader(code), Reach::Moved);
    }

    #[test]
    fn a_shader_without_a_depth_test_is_seen_through_walls() {
        let code = "shader_type spatial; render_mode unshaded, depth_test_disabled;";
        assert_eq!(of_shader(code), Reach::Through);
        let code = "shader_type spatial; // depth_test_disabled\n/* DEPTH */ void fragment() {}";
        assert_eq!(of_shader(code), Reach::Mesh(0.0));
    }
}
