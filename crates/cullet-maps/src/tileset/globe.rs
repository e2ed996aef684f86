//! Tiles that are written for a place on the globe, with horizon occlusion points.

use cullet::cull::horizon::Ellipsoid;
use glam::{DMat4, DVec3};

use super::cut::{Item, Node};
use super::globe_place::GlobePlace;
use super::place;

/// The extension that has horizon occlusion points. It is a draft of August 2026 for 3D Tiles 2.0
/// (pull requests `CesiumGS/glTF` 120 and `CesiumGS/3d-tiles` 867), for tiles that are nodes of glTF.
/// Nobody has specified it for 1.1; it is written there under the same name with the same contents.
pub(super) const EXTENSION: &str = "3DTILES_horizon_occlusion_point";

/// Where the tiles of a scene are on the globe.
#[derive(Debug)]
pub(super) struct Globe {
    /// From tiles, which are z-up, to the globe.
    transform: DMat4,
    /// How deep below the ellipsoid the lowest instance reaches, in metres; 0 if none does.
    depth: f64,
}

impl Globe {
    /// Places the origin of a scene with `items`: its +X is east, +Y up and +Z south.
    pub(super) fn new(at: GlobePlace, items: &[Item]) -> Self {
        let [longitude, latitude] = at.radians();
        let origin = place::on_globe(longitude, latitude, at.height());
        // Above the ellipsoid the normal is that of the place below.
        let axes = place::east_north_up(place::on_globe(longitude, latitude, 0.0));
        let mut globe = Self { transform: DMat4::from_mat3_translation(axes, origin), depth: 0.0 };
        let lowest = items.iter().map(|item| globe.level(item)).fold(1.0, f64::min);
        globe.depth = (1.0 - lowest) * shortest_radius();
        globe
    }

    /// The transform of the root tile, by columns.
    pub(super) fn transform(&self) -> [f64; 16] {
        self.transform.to_cols_array()
    }

    /// The horizon occlusion point of a tile with all below it, whose meshes may be off by `error`;
    /// `None` if it has none.
    pub(super) fn point(&self, node: &Node, error: f64) -> Option<[f64; 3]> {
        let own = node.own.iter().map(Item::bounds);
        let below = node.children.iter().map(|child| [child.low, child.high]);
        let corners: Vec<[f64; 3]> =
            own.chain(below).flat_map(|bounds| self.corners(bounds)).collect();
        Ellipsoid::WGS84.occlusion_point(self.depth, &corners, error)
    }

    /// A distance from the centre, in space divided by the radii, that no point of an item is below:
    /// along the direction of its middle, where its corners are the least.
    fn level(&self, item: &Item) -> f64 {
        let corners = self.corners(item.bounds());
        let scaled = corners.map(|p| DVec3::from(p) / DVec3::from(Ellipsoid::WGS84.radii()));
        let up = scaled.iter().sum::<DVec3>().normalize_or_zero();
        scaled.iter().map(|p| p.dot(up)).fold(f64::INFINITY, f64::min)
    }

    /// Corners of a box of the scene, on the globe.
    fn corners(&self, [low, high]: [DVec3; 2]) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| {
            let side = |a: usize| if k >> a & 1 == 0 { low[a] } else { high[a] };
            let z_up = DVec3::new(side(0), -side(2), side(1));
            self.transform.transform_point3(z_up).to_array()
        })
    }
}

fn shortest_radius() -> f64 {
    Ellipsoid::WGS84.radii().into_iter().fold(f64::INFINITY, f64::min)
}
