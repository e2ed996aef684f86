//! Simplifying within a bound, and chains of levels, measured without what made them.

use cullet::MeshData;
use cullet::mesh::Part;
use cullet_bake::levels::{
    ChainOptions, LevelsError, NO_GROUP, WithinOptions, build_chain, simplify_within,
};
use cullet_draw::surface::deviation;
use cullet_testkit::soups::{self, Soup};
use cullet_testkit::{Rng, cases};

fn data((positions, indices): Soup) -> MeshData {
    MeshData { positions, indices, ..MeshData::default() }
}

fn bumpy(rings: u32) -> MeshData {
    data(soups::bumpy_ball(rings, 0.15))
}

#[test]
fn the_bound_holds_at_independent_points_whatever_the_shape() {
    let mut rng = Rng(19);
    let mut left = Vec::new();
    for case in 0..cases(10) {
        let soup = match case % 3 {
            0 => soups::bumpy_ball(24 + rng.below(16) as u32, 0.2),
            1 => soups::terrain(24 + rng.below(20) as u32),
            // Every triangle with vertices of its own.
            _ => soups::unshared(&soups::bumpy_ball(20, 0.1)),
        };
        let mesh = data(soup);
        let bound = [0.01, 0.03, 0.08][rng.index(3)];
        let found = simplify_within(&mesh, bound, &WithinOptions::default()).expect("valid");
        assert!(found.error <= bound * 1.081, "case {case}: {} over {bound}", found.error);
        let whole = (&mesh.positions[..], &mesh.indices[..]);
        let far = deviation(whole, (&mesh.positions, &found.indices), 100_000, 1000);
        assert!(far.p999 <= bound, "case {case}: {far:?} over {bound}");
        assert!(far.max <= bound * 1.2, "case {case}: {far:?} over {bound}");
        // Closed ones stay closed; borders have fewer edges, not more.
        assert!(far.open_edges[1] <= far.open_edges[0], "case {case}: {far:?}");
        assert_eq!(far.open_edges[0] == 0, far.open_edges[1] == 0, "case {case}: {far:?}");
        left.push(found.indices.len() as f64 / mesh.indices.len() as f64);
        let again = simplify_within(&mesh, bound, &WithinOptions::default());
        assert_eq!(again, Ok(found), "case {case}");
    }
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    assert!(mean < 0.7, "{mean} of the triangles left");
}

#[test]
fn a_larger_bound_leaves_fewer_triangles_and_one_of_nothing_the_shape() {
    let mesh = bumpy(40);
    let mut before = mesh.indices.len() / 3 + 1;
    for bound in [0.0, 0.002, 0.01, 0.05, 0.3] {
        let found = simplify_within(&mesh, bound, &WithinOptions::default()).expect("valid");
        assert_eq!(found.indices.len() / 3, found.parts[0].triangle_count as usize);
        assert!(found.indices.len() / 3 < before, "{bound}: {} left", found.indices.len() / 3);
        before = found.indices.len() / 3 + 1;
    }
    assert!(before < 200, "{before}");
}

#[test]
fn parts_stay_apart_and_the_line_between_them_closes() {
    let (positions, indices) = soups::bumpy_ball(30, 0.1);
    // Bands around the ball, by their height.
    let band =
        |t: &[u32]| (t.iter().map(|&v| positions[v as usize][1]).sum::<f32>() > 0.4) as usize;
    let mut of = [Vec::new(), Vec::new()];
    indices.chunks_exact(3).for_each(|t| of[band(t)].extend_from_slice(t));
    let count = of.clone().map(|o| (o.len() / 3) as u32);
    let part = |first: u32, triangle_count, material| Part {
        first_triangle: first,
        triangle_count,
        material,
        ..Part::default()
    };
    let parts = vec![part(0, count[0], 3), part(count[0], count[1], 5)];
    let mesh = MeshData {
        positions: positions.clone(),
        indices: of.concat(),
        parts,
        ..MeshData::default()
    };
    let found = simplify_within(&mesh, 0.02, &WithinOptions::default()).expect("valid");
    let far = deviation((&positions, &mesh.indices), (&positions, &found.indices), 50_000, 5);
    assert_eq!(far.open_edges, [0, 0]);
    assert_eq!(found.parts.iter().map(|p| p.material).collect::<Vec<_>>(), [3, 5]);
    // Each part alone deviates no more than the whole: the line between them was not moved.
    for (old, new) in mesh.parts.iter().zip(&found.parts) {
        let of = |p: &Part, indices: &[u32]| {
            let from = p.first_triangle as usize * 3;
            indices[from..from + p.triangle_count as usize * 3].to_vec()
        };
        let (old, new) = (of(old, &mesh.indices), of(new, &found.indices));
        assert!(new.len() * 2 < old.len(), "{} of {}", new.len(), old.len());
        let far = deviation((&positions, &old), (&positions, &new), 20_000, 5);
        assert!(far.max < 0.06, "{far:?}");
    }
}

#[test]
fn chains_are_valid_err_as_they_say_and_shrink() {
    for (mesh, least) in [(bumpy(32), 5), (data(soups::terrain(40)), 4)] {
        let options = ChainOptions::default();
        let chain = build_chain(&mesh, &options).expect("valid");
        chain.validate().expect("a valid chain");
        assert!(chain.groups.len() >= least, "{} levels", chain.groups.len());
        assert!(chain.groups.windows(2).all(|g| g[0].error <= g[1].error));
        assert_eq!(chain.mesh.indices[..mesh.indices.len()], mesh.indices);
        let mut before = mesh.indices.len() / 3;
        for (number, group) in chain.groups.iter().enumerate() {
            let made = (0..chain.clustering.clusters.len())
                .filter(|&c| chain.made_from[c] == number as u32);
            let level: Vec<u32> =
                made.flat_map(|c| chain.cluster_indices(c as u32).collect::<Vec<_>>()).collect();
            assert!(
                level.len() / 3 <= (before as f32 * options.keep) as usize + 1,
                "level {number}"
            );
            before = level.len() / 3;
            let whole = (&mesh.positions[..], &mesh.indices[..]);
            let far = deviation(whole, (&mesh.positions, &level), 30_000, 9);
            assert!(far.p999 <= group.error && far.max <= group.error * 1.2, "{far:?} {group:?}");
        }
        assert_eq!(build_chain(&mesh, &options), Ok(chain));
    }
}

#[test]
fn what_cannot_be_simplified_is_one_level() {
    let triangle = data((vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![0, 1, 2]));
    let point = data((vec![[2.0; 3]; 900], (0..900).collect()));
    for mesh in [MeshData::default(), triangle, point] {
        let chain = build_chain(&mesh, &ChainOptions::default()).expect("valid");
        assert_eq!(chain.groups.len(), 0);
        assert!(chain.replaced_by.iter().all(|&g| g == NO_GROUP));
        chain.validate().expect("a valid chain");
        simplify_within(&mesh, 0.1, &WithinOptions::default()).expect("valid");
    }
}

#[test]
fn wrong_bounds_options_and_meshes_are_refused() {
    let mesh = bumpy(6);
    let refused = |bound, options: &WithinOptions<'_>| {
        matches!(
            simplify_within(&mesh, bound, options),
            Err(LevelsError::Value { .. } | LevelsError::Length { .. } | LevelsError::Mesh(_))
        )
    };
    let fine = WithinOptions::default();
    for bound in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(refused(bound, &fine), "{bound}");
    }
    let with = |change: &dyn Fn(&mut WithinOptions<'static>)| {
        let mut options = WithinOptions::default();
        change(&mut options);
        options
    };
    assert!(refused(0.1, &with(&|o| o.rounds = 0)));
    assert!(refused(0.1, &with(&|o| o.shares = &[f32::NAN])));
    assert!(refused(0.1, &with(&|o| o.same = &[0])));
    let mut broken = mesh.clone();
    broken.positions[3][1] = f32::NAN;
    assert!(matches!(simplify_within(&broken, 0.1, &fine), Err(LevelsError::Mesh(_))));
    let mut options = ChainOptions::default();
    options.growth = 1.0;
    assert!(matches!(build_chain(&mesh, &options), Err(LevelsError::Value { what: "growth", .. })));
    options = ChainOptions::default();
    options.first = f32::NAN;
    assert!(matches!(build_chain(&mesh, &options), Err(LevelsError::Value { what: "first", .. })));
}
