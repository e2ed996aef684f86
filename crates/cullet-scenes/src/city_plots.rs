//! A city of any size, plot by plot: what stands on a plot is a function of the seed and the plot,
//! so that no one ever needs all of it.

use cullet::mesh::{Alpha, MeshError};
use cullet::{Mesh, Transform};

use super::builder::{SceneBuilder, Sides, fill};
use super::city::{
    Building, FACADES, Object, PITCH, cameras, ground, kinds, object, quarter_turned,
};
use super::rng::{Rng, morton_grid};
use super::shapes::{Shape, mesh_data};
use super::spec::{SceneSpecError, Spec};
use cullet_io::Model;

/// Small objects of a plot.
const OBJECTS: usize = 10;

/// Draws for one at the most: a plot whose house fills it nearly is left with fewer.
const TRIES: usize = 400;

/// A city of square plots of 24 m, each with a building and ten small objects, about the origin on
/// y = 0. Any part of it is made without the rest; up to 1e9 instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CityPlots {
    seed: u64,
    side: u32,
}

/// Mesh that stands somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Number of its mesh in [`CityPlots::meshes`].
    pub mesh: u32,
    /// Where.
    pub transform: Transform,
}

/// The house of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plot {
    /// Where the plot's middle is, along x and z.
    pub centre: [f64; 2],
    /// The height of its building.
    pub height: f64,
    /// The building.
    pub building: Placed,
}

impl CityPlots {
    /// Length of a side of a plot.
    pub const PITCH: f64 = PITCH;

    /// The highest that anything stands: on the highest roof.
    pub const HIGHEST: f64 = 123.0;

    /// Instances of a plot.
    pub const INSTANCES: u64 = 1 + OBJECTS as u64;

    /// A square city of at least so many instances, 1 to 1e9.
    #[must_use]
    pub fn new(instances: u64, seed: u64) -> Self {
        let plots = instances.clamp(1, 1_000_000_000).div_ceil(Self::INSTANCES);
        let mut side = (plots as f64).sqrt() as u32;
        while u64::from(side) * u64::from(side) < plots {
            side += 1;
        }
        Self { seed, side }
    }

    /// Plots along each side.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Half the length of a side of the city.
    #[must_use]
    pub fn reach(&self) -> f64 {
        f64::from(self.side) * PITCH * 0.5
    }

    /// The meshes: buildings, then small objects, each with its name; last a box that fills −½..½ ×
    /// 0..1 × −½..½.
    ///
    /// # Errors
    /// Never: they are checked meshes.
    pub fn meshes() -> Result<Vec<(&'static str, Mesh)>, MeshError> {
        let mesh = |shape: Shape, material| {
            Mesh::new(mesh_data(&[(shape, material)], false, Alpha::Opaque))
        };
        let mut meshes = Vec::new();
        for (k, (name, _)) in (0..).zip(FACADES) {
            meshes.push((name, mesh(Shape::building(1), k)?));
        }
        for (k, (name, _, shape)) in (FACADES.len() as u32..).zip(kinds()) {
            meshes.push((name, mesh(shape, k)?));
        }
        let block = meshes.len() as u32;
        meshes.push(("block", mesh(Shape::building(1), block)?));
        Ok(meshes)
    }

    /// The number of the last mesh, the box.
    #[must_use]
    pub fn block() -> u32 {
        (FACADES.len() + kinds().len()) as u32
    }

    /// A box of the last mesh.
    #[must_use]
    pub fn block_at(low: [f64; 3], high: [f64; 3]) -> Placed {
        Placed { mesh: Self::block(), transform: fill(low, high) }
    }

    fn rng(&self, x: u32, z: u32) -> Rng {
        Rng::new(self.seed, 1 << 62 | u64::from(x) << 31 | u64::from(z))
    }

    /// The house of a plot: x and z below [`Self::side`].
    #[must_use]
    pub fn plot(&self, x: u32, z: u32) -> Plot {
        self.house(x, z, &mut self.rng(x, z)).0
    }

    fn house(&self, x: u32, z: u32, rng: &mut Rng) -> (Plot, Building) {
        let building = Building::any(rng);
        let centre = [x, z].map(|i| (f64::from(i) + 0.5) * PITCH - self.reach());
        let ([cx, cz], [hx, hz]) = (centre, building.half);
        let transform = fill([cx - hx, 0.0, cz - hz], [cx + hx, building.height, cz + hz]);
        let placed = Placed { mesh: building.facade as u32, transform };
        (Plot { centre, height: building.height, building: placed }, building)
    }

    /// Adds all that stands on a plot: its building, then its small objects.
    pub fn add_all(&self, x: u32, z: u32, out: &mut Vec<Placed>) {
        let (house, objects) = self.all(x, z);
        out.push(house.building);
        out.extend(objects.iter().map(|object| {
            let mesh = (FACADES.len() + object.kind) as u32;
            Placed { mesh, transform: quarter_turned(object) }
        }));
    }

    fn all(&self, x: u32, z: u32) -> (Plot, Vec<Object>) {
        let mut rng = self.rng(x, z);
        let (plot, building) = self.house(x, z, &mut rng);
        let [low, high] = [-0.5, 0.5].map(|s| plot.centre.map(|c| c + s * PITCH));
        let mut objects = Vec::with_capacity(OBJECTS);
        let mut tries = 0;
        while objects.len() < OBJECTS && tries < TRIES {
            tries += 1;
            objects.extend(object(&mut rng, low, high, |_| (plot.centre, building)));
        }
        (plot, objects)
    }

    /// Whether nothing small stands where an eye is to be.
    fn is_clear(&self, eye: [f64; 3]) -> bool {
        let plot = |v: f64| ((v + self.reach()) / PITCH) as u32;
        let around = |v: f64| [plot(v - PITCH), plot(v), plot(v + PITCH)];
        around(eye[2]).into_iter().all(|z| {
            around(eye[0])
                .into_iter()
                .filter(|&x| x.max(z) < self.side)
                .all(|x| self.all(x, z).1.iter().all(|object| object.is_clear_of(eye)))
        })
    }
}

/// The whole of it as a model.
pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let (seed, sub) = (spec.get("seed"), spec.get("sub") as u32);
    let city = CityPlots::new(spec.get("n"), seed);
    let mut b = SceneBuilder::new(spec);
    for (name, colour) in FACADES {
        let material = b.material(name, colour);
        let name = format!("{name} building");
        b.mesh(&name, &[(Shape::building(sub), material)], Sides::One)?;
    }
    for (name, colour, shape) in kinds() {
        let material = b.material(name, colour);
        b.mesh(name, &[(shape, material)], Sides::One)?;
    }
    if spec.get("ground") == 1 {
        let material = b.material("asphalt", 0x5A5E63);
        let mesh = b.mesh_from("ground", ground(city.reach() + 200.0, material))?;
        b.add(mesh, Transform::IDENTITY)?;
    }
    let mut placed = Vec::new();
    for (x, z) in morton_grid(city.side) {
        city.add_all(x, z, &mut placed);
        for Placed { mesh, transform } in placed.drain(..) {
            b.add(mesh, transform)?;
        }
    }
    cameras(&mut b.model, city.side, |eye| city.is_clear(eye), &mut Rng::new(seed, 3));
    Ok(b.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plot_is_the_same_whoever_makes_it_and_stays_in_its_place() {
        let city = CityPlots::new(100_000_000, 3);
        assert!(u64::from(city.side()).pow(2) * CityPlots::INSTANCES >= 100_000_000);
        let meshes = CityPlots::meshes().unwrap();
        for (x, z) in [(0, 0), (1234, 7), (city.side() - 1, city.side() - 1)] {
            let (mut one, mut two) = (Vec::new(), Vec::new());
            city.add_all(x, z, &mut one);
            city.add_all(x, z, &mut two);
            assert_eq!(one, two);
            assert_eq!(one.len() as u64, CityPlots::INSTANCES);
            let plot = city.plot(x, z);
            assert_eq!(plot.building, one[0]);
            for placed in &one {
                assert!((placed.mesh as usize) < meshes.len() - 1);
                let [px, py, pz] = placed.transform.translation;
                assert!((px - plot.centre[0]).abs() <= PITCH * 0.5);
                assert!((pz - plot.centre[1]).abs() <= PITCH * 0.5);
                assert!((0.0..=CityPlots::HIGHEST).contains(&py));
            }
        }
        assert_ne!(city.plot(5, 5).height, city.plot(5, 6).height);
        assert_eq!(CityPlots::new(1, 0).side(), 1);
    }
}
