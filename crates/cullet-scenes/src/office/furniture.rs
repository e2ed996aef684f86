//! Furniture of the rooms of the office.

use cullet::MeshId;

use super::super::builder::{SceneBuilder, Sides, turned};
use super::super::rng::Rng;
use super::super::shapes::Shape;
use super::super::spec::SceneSpecError;

/// Side of the square that a piece may take, with room to walk past.
const PLACE: f64 = 1.6;

/// Meshes of furniture; each stands at y = 0, within a square of 1.4 m about the origin.
pub(super) struct Furniture {
    room: Vec<MeshId>,
    hall: Vec<MeshId>,
}

impl Furniture {
    pub(super) fn new(b: &mut SceneBuilder) -> Result<Self, SceneSpecError> {
        let oak = b.material("oak", 0xC29A66);
        let steel = b.material("steel", 0x8F99A3);
        let fabric = b.material("fabric", 0x3F6C8F);
        let red = b.material("red fabric", 0xA8483F);
        let clay = b.material("clay", 0xB0694A);
        let green = b.material("house plant", 0x4C8A4A);
        let shade = b.material("lampshade", 0xF2DFA8);
        let black = b.material("screen", 0x2B2E33);

        // Boxes overlap where they meet: no two share an edge.
        let desk = Shape::boxes(&[
            ([-0.7, 0.72, -0.35], [0.7, 0.76, 0.35]),
            ([-0.66, -0.01, -0.31], [-0.62, 0.74, 0.31]),
            ([0.62, -0.01, -0.30], [0.66, 0.73, 0.30]),
            ([0.25, 0.3, -0.29], [0.63, 0.725, 0.29]),
        ]);
        let screen = Shape::boxes(&[
            ([-0.12, 0.75, -0.2], [0.12, 0.78, 0.0]),
            ([-0.02, 0.77, -0.12], [0.02, 0.95, -0.08]),
            ([-0.28, 0.88, -0.09], [0.28, 1.2, -0.06]),
        ]);
        let chair = Shape::boxes(&[
            ([-0.24, 0.44, -0.24], [0.24, 0.5, 0.24]),
            ([-0.22, 0.49, 0.18], [0.22, 0.95, 0.23]),
            ([-0.04, 0.03, -0.04], [0.04, 0.45, 0.04]),
            ([-0.26, -0.01, -0.05], [0.26, 0.05, 0.05]),
            ([-0.05, -0.012, -0.26], [0.05, 0.052, 0.26]),
        ]);
        let shelf = Shape::boxes(&[
            ([-0.6, -0.01, -0.2], [-0.56, 1.9, 0.2]),
            ([0.56, -0.012, -0.2], [0.6, 1.902, 0.2]),
            ([-0.58, 0.05, -0.19], [0.58, 0.09, 0.19]),
            ([-0.57, 0.62, -0.195], [0.57, 0.66, 0.185]),
            ([-0.58, 1.2, -0.19], [0.58, 1.24, 0.19]),
            ([-0.57, 1.84, -0.195], [0.57, 1.88, 0.185]),
            ([-0.59, 0.02, -0.18], [0.59, 1.89, -0.16]),
        ]);
        let sofa = Shape::boxes(&[
            ([-0.7, 0.08, -0.35], [0.7, 0.42, 0.35]),
            ([-0.68, 0.3, -0.36], [0.68, 0.85, -0.18]),
            ([-0.69, -0.01, -0.34], [-0.53, 0.62, 0.34]),
            ([0.53, -0.01, -0.34], [0.69, 0.62, 0.34]),
        ]);
        let table = Shape::lathe(
            &[[0.35, -0.01], [0.33, 0.03], [0.05, 0.06], [0.05, 0.68], [0.6, 0.7], [0.6, 0.74]],
            14,
        );
        let cabinet = Shape::boxes(&[
            ([-0.45, -0.01, -0.25], [0.45, 1.1, 0.25]),
            ([-0.1, 0.8, 0.24], [0.1, 0.83, 0.28]),
            ([-0.1, 0.35, 0.24], [0.1, 0.38, 0.28]),
        ]);
        let lamp = Shape::lathe(&[[0.18, -0.01], [0.16, 0.03], [0.02, 0.05], [0.02, 1.35]], 10);
        let lampshade = Shape::lathe(&[[0.26, 1.3], [0.14, 1.62]], 10);
        let pot = Shape::lathe(&[[0.16, -0.01], [0.22, 0.4]], 10);
        let leaves = Shape::icosphere(1).scaled([0.4, 0.5, 0.4], [0.0, 0.85, 0.0]);
        // Open at the top: it has an inside.
        let basket = Shape::lathe(
            &[[0.0, -0.01], [0.14, -0.01], [0.18, 0.35], [0.17, 0.35], [0.13, 0.01], [0.0, 0.01]],
            12,
        );

        let one = Sides::One;
        let desk = b.mesh("desk", &[(desk, oak), (screen, black)], one)?;
        let chair = b.mesh("chair", &[(chair, fabric)], one)?;
        let shelf = b.mesh("shelf", &[(shelf, oak)], one)?;
        let sofa = b.mesh("sofa", &[(sofa, red)], one)?;
        let table = b.mesh("round table", &[(table, oak)], one)?;
        let cabinet = b.mesh("cabinet", &[(cabinet, steel)], one)?;
        let lamp = b.mesh("floor lamp", &[(lamp, steel), (lampshade, shade)], one)?;
        let plant = b.mesh("plant", &[(pot, clay), (leaves, green)], one)?;
        let basket = b.mesh("basket", &[(basket, steel)], one)?;
        Ok(Self {
            room: vec![desk, chair, desk, chair, shelf, cabinet, table, lamp, plant, basket, sofa],
            hall: vec![sofa, plant, table],
        })
    }

    /// Stands up to `pieces` in the room `low`..`high`, at most one a place of a grid.
    pub(super) fn fill_room(
        &self,
        b: &mut SceneBuilder,
        rng: &mut Rng,
        low: [f64; 3],
        high: [f64; 3],
        pieces: usize,
    ) -> Result<(), SceneSpecError> {
        let count = |a: usize| ((high[a] - low[a]) / PLACE).floor().max(1.0) as usize;
        let (nx, nz) = (count(0), count(2));
        let mut places: Vec<usize> = (0..nx * nz).collect();
        for i in 0..pieces.min(places.len()) {
            let pick = i + rng.below(places.len() - i);
            places.swap(i, pick);
            let (x, z) = (places[i] % nx, places[i] / nx);
            let middle = |a: usize, i: usize, n: usize| {
                low[a] + (high[a] - low[a]) * (i as f64 + 0.5) / n as f64
            };
            let at = [
                middle(0, x, nx) + rng.range(-0.05, 0.05),
                low[1],
                middle(2, z, nz) + rng.range(-0.05, 0.05),
            ];
            let mesh = self.room[rng.below(self.room.len())];
            b.add(mesh, turned(rng.below(4) as f64 * 0.25, [1.0; 3], at))?;
        }
        Ok(())
    }

    /// Stands one piece in the hall, facing across it.
    pub(super) fn stand_in_hall(
        &self,
        b: &mut SceneBuilder,
        rng: &mut Rng,
        at: [f64; 3],
    ) -> Result<(), SceneSpecError> {
        let mesh = self.hall[rng.below(self.hall.len())];
        b.add(mesh, turned(0.75, [1.0; 3], at))?;
        Ok(())
    }
}
