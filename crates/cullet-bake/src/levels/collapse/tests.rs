use cullet_draw::surface::{closest_point, inner_points};
use cullet_testkit::{Rng, cases, soups};
use glam::{DVec3, Vec3};

use super::near::Fan;
use super::*;

/// A mesh with points on its triangles, three each and the corners.
struct Sampled {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    place: Vec<u32>,
    points: Points,
    tree: SurfaceTree,
}

impl Sampled {
    fn new((positions, indices): soups::Soup) -> Self {
        let mut points = Points::default();
        for (t, corners) in (0..).zip(indices.as_chunks::<3>().0) {
            let places = corners.map(|v| positions[v as usize]);
            let all = places.into_iter().chain(inner_points(places, 7, t, 3));
            points.add(all.map(|point| (point, 0.0)), usize::MAX);
        }
        let place = cullet::mesh::weld(&positions);
        let tree = SurfaceTree::new(&positions, &indices);
        Self { positions, indices, place, points, tree }
    }

    fn run(&self, locks: &[bool], triangles: usize, limit: f32) -> (Collapser, Collapsed) {
        let mut collapser = Collapser::default();
        let made = collapser.run(&Task {
            positions: &self.positions,
            place: &self.place,
            indices: &self.indices,
            locks,
            shares: &[],
            carried: &self.points,
            triangles,
            free: 0.0,
            limit,
            original: Some(&self.tree),
        });
        (collapser, made)
    }

    /// Edges that triangles have on one side more often than on the other, by places.
    fn open(&self, indices: &[u32]) -> Vec<[u32; 2]> {
        let mut sides = std::collections::HashMap::new();
        for t in indices.as_chunks::<3>().0 {
            let t = t.map(|v| self.place[v as usize]);
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *sides.entry([a.min(b), a.max(b)]).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        sides.into_iter().filter(|s| s.1 != 0).map(|s| s.0).collect()
    }
}

fn exact(point: [f32; 3], corners: [[f32; 3]; 3]) -> f64 {
    let double = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
    (closest_point(double(point), corners.map(double)) - double(point)).length()
}

#[test]
fn no_point_is_farther_than_the_error_and_each_is_as_far_as_is_said() {
    let mut rng = Rng(3);
    for case in 0..cases(24) {
        let mesh = Sampled::new(match case % 4 {
            0 => soups::bumpy_ball(12 + rng.below(12) as u32, 0.2),
            1 => soups::terrain(10 + rng.below(20) as u32),
            2 => soups::unshared(&soups::bumpy_ball(14, 0.1)),
            _ => soups::scattered(300),
        });
        let limit = [0.01, 0.05, f32::INFINITY][rng.index(3)];
        let locks: Vec<bool> = mesh.positions.iter().map(|_| rng.below(9) == 0).collect();
        let before = mesh.indices.len() / 3;
        let wanted = if limit < f32::INFINITY { 0 } else { before / 3 };
        let (collapser, made) = mesh.run(&locks, wanted, limit);
        assert!(made.indices.len() / 3 <= before && made.error <= limit * 1.000_01);
        let (mut seen, mut left) = (0, mesh.points.points.clone());
        left.sort_unstable_by(|a, b| a.partial_cmp(b).expect("finite"));
        for (&from, corners) in made.from.iter().zip(made.indices.as_chunks::<3>().0) {
            let corners = corners.map(|v| mesh.positions[v as usize]);
            for (point, distance) in collapser.points_of(from) {
                seen += 1;
                let is_known = left.binary_search_by(|p| p.partial_cmp(&point).expect("finite"));
                assert!(is_known.is_ok());
                let truth = exact(point, corners);
                assert!((truth - f64::from(distance)).abs() < 1e-5, "{truth} {distance}");
                assert!(distance <= made.error * 1.000_01, "{distance} {}", made.error);
            }
        }
        assert!(seen >= left.len(), "case {case}: a point is lost");
        // What must stay does, and no edge opens.
        let used: std::collections::HashSet<u32> =
            made.indices.iter().map(|&v| mesh.place[v as usize]).collect();
        for &v in &mesh.indices {
            let place = mesh.place[v as usize];
            assert!(!locks[place as usize] || used.contains(&place), "case {case}");
        }
        let border: std::collections::HashSet<u32> =
            mesh.open(&mesh.indices).into_iter().flatten().collect();
        assert!(mesh.open(&made.indices).iter().flatten().all(|v| border.contains(v)));
    }
}

#[test]
fn a_flat_sheet_needs_few_triangles_and_keeps_its_border() {
    let side = 17u32;
    let positions = (0..side * side).map(|i| [(i % side) as f32, (i / side) as f32, 0.0]).collect();
    let quad = |q: u32| {
        let a = q / 16 * side + q % 16;
        [a, a + 1, a + side + 1, a, a + side + 1, a + side]
    };
    let mesh = Sampled::new((positions, (0..256).flat_map(quad).collect()));
    let free = vec![false; mesh.positions.len()];
    let (_, made) = mesh.run(&free, 0, 1e-4);
    assert!(made.indices.len() / 3 <= 8, "{} of 512 triangles", made.indices.len() / 3);
    assert!(made.error < 1e-5);
    let area: f32 = made
        .indices
        .as_chunks::<3>()
        .0
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| Vec3::from_array(mesh.positions[v as usize]));
            (b - a).cross(c - a).z * 0.5
        })
        .sum();
    assert!((area - 256.0).abs() < 1e-3, "{area}");
    let mut locks = free;
    locks[40] = true;
    let (_, kept) = mesh.run(&locks, 0, 1e-4);
    assert!(kept.indices.contains(&40) && !made.indices.contains(&40));
}

#[test]
fn the_nearest_of_a_few_triangles_is_found() {
    let mut rng = Rng(5);
    for _ in 0..cases(2000) {
        let mut at = || [0; 3].map(|_| rng.range(-1.0, 1.0) as f32);
        let count = 1 + (at()[0].abs() * 9.0) as usize;
        let mut triangles: Vec<[[f32; 3]; 3]> = (0..count).map(|_| [at(), at(), at()]).collect();
        // One without area.
        triangles[0][1] = triangles[0][0];
        let point = at();
        let mut fan = Fan::default();
        triangles.iter().for_each(|t| fan.push(t.map(Vec3::from_array)));
        let (squared, number) = fan.nearest(Vec3::from_array(point));
        let truth = triangles.iter().map(|t| exact(point, *t)).fold(f64::INFINITY, f64::min);
        assert!((f64::from(squared).sqrt() - truth).abs() < 1e-5, "{squared} {truth}");
        let named = exact(point, triangles[number as usize]);
        assert!((named - truth).abs() < 1e-5, "{named} {truth}");
    }
}
