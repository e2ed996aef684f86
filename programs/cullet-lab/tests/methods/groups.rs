//! Masks for groups of triangles and for sectors of a frustum.

use cullet::bounds::{Aabb, Sphere};
use cullet::{Camera, Projection, Simd};
use cullet_lab::methods::Groups;
use cullet_lab::methods::sectors::{
    MaskUse, SectorError, corner_directions, mask_of_corners, mask_of_sectors,
};
use cullet_mesh::{BackfaceMask, MaskGrid, NormalMasks};
use cullet_testkit::models::model;
use cullet_testkit::vectors::{cross, dot, fibonacci, front};
use cullet_testkit::{Rng, at_every_level};

/// Small triangles all over a unit sphere, wound outward.
fn ball(rng: &mut Rng, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    for _ in 0..count {
        let p = rng.direction();
        let (mut u, mut v) = (rng.vector(1.0), rng.vector(1.0));
        for e in [&mut u, &mut v] {
            let along = dot(*e, p) * 0.7;
            (0..3).for_each(|k| e[k] = (e[k] - p[k] * along) * 0.05);
        }
        if dot(cross(u, v), p) < 0.0 {
            (u, v) = (v, u);
        }
        let at = |e: [f64; 3]| std::array::from_fn(|k| (p[k] + e[k]) as f32);
        positions.extend([at([0.0; 3]), at(u), at(v)]);
    }
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

fn ones(words: &[u64]) -> u64 {
    words.iter().map(|w| u64::from(w.count_ones())).sum()
}

fn eye_at(direction: [f64; 3], far: f64) -> [f64; 4] {
    let [x, y, z] = direction.map(|v| v * far);
    [x, y, z, 1.0]
}

#[test]
fn more_groups_cull_more_and_nothing_in_front() {
    let mut rng = Rng(11);
    let (positions, indices) = ball(&mut rng, 3001);
    let grid = MaskGrid::new(16).expect("a good N");
    let mut last = 0;
    for count in [1, 5, 64, 700] {
        let groups = Groups::kd(&positions, &indices, count);
        assert_eq!(groups.len(), count);
        let mut order = groups.order().to_vec();
        order.sort_unstable();
        assert!(order.into_iter().eq(0..3001), "a permutation");
        let mut end = 0;
        for (range, sphere) in groups.ranges().iter().zip(groups.spheres()) {
            assert_eq!(range.start, end);
            end = range.end;
            for t in &groups.order()[range.start as usize..range.end as usize] {
                let corners = &indices[*t as usize * 3..][..3];
                assert!(corners.iter().all(|v| sphere.contains(positions[*v as usize])));
            }
        }
        assert_eq!(end, 3001);
        let mut masks = NormalMasks::default();
        grid.encode_triangles(&positions, &groups.reorder(&indices), &mut masks);
        let (mut culled, mut total) = (Vec::new(), 0);
        for i in 0..40 {
            let mut eye = eye_at(rng.direction(), [0.9, 1.5, 3.0, 50.0][i % 4]);
            if i % 9 == 0 {
                eye[3] = 0.0;
            }
            let expected = groups.cull_ref(&grid, &masks, eye);
            at_every_level!(|name, level| {
                groups.cull(level, &grid, &masks, eye, &mut culled);
                assert_eq!(culled, expected, "{name}");
            });
            total += ones(&culled);
            for (place, t) in groups.order().iter().enumerate() {
                if culled[place / 64] >> (place % 64) & 1 == 1 {
                    let corners = [0, 1, 2].map(|k| positions[*t as usize * 3 + k]);
                    let (value, size) = front(corners, eye);
                    assert!(value <= size * 1e-12, "triangle {t} from {eye:?}");
                }
            }
        }
        assert!(total > last, "{count} groups cull {total}, fewer culled {last}");
        last = total;
    }
}

#[test]
fn groups_of_the_caller_are_any_ranges() {
    let mut rng = Rng(12);
    let (positions, indices) = ball(&mut rng, 500);
    let grid = MaskGrid::new(8).expect("a good N");
    let mut masks = NormalMasks::default();
    grid.encode_triangles(&positions, &indices, &mut masks);
    let groups = Groups::of_ranges(&positions, &indices, &[3..70, 70..70, 130..131, 200..450]);
    let mut culled = Vec::new();
    let eye = eye_at([0.0, 0.0, 1.0], 20.0);
    groups.cull(Simd::best(), &grid, &masks, eye, &mut culled);
    assert_eq!(culled, groups.cull_ref(&grid, &masks, eye));
    let grouped = |i: usize| (3..70).contains(&i) || i == 130 || (200..450).contains(&i);
    assert!((0..500).all(|i| culled[i / 64] >> (i % 64) & 1 == 0 || grouped(i)));
    assert!(ones(&culled) > 50);
    assert_eq!(Groups::kd(&positions, &[], 4).len(), 0);
    assert_eq!(Groups::kd(&positions, &indices[..6], 4).len(), 2);
}

#[test]
fn sixty_four_groups_of_the_bunny() {
    let Some((positions, indices)) = model("stanford-bunny/bun_zipper.ply") else { return };
    let grid = MaskGrid::new(16).expect("a good N");
    let b = Aabb::from_points(&positions);
    let radius = b.half_extent().iter().map(|v| v * v).sum::<f64>().sqrt();
    let ball = Sphere::from_points(&positions);
    assert!(f64::from(ball.radius) <= radius * 1.001);
    let (radius, centre) = (f64::from(ball.radius), ball.center.map(f64::from));
    for (count, floor) in [(1, 28.0), (64, 48.5), (256, 50.5)] {
        let groups = Groups::kd(&positions, &indices, count);
        let mut masks = NormalMasks::default();
        grid.encode_triangles(&positions, &groups.reorder(&indices), &mut masks);
        let (mut culled, mut total) = (Vec::new(), 0);
        for i in 0..200 {
            let d = fibonacci(i, 200);
            let eye = [0, 1, 2].map(|k: usize| centre[k] + d[k] * 3.0 * radius);
            groups.cull(Simd::best(), &grid, &masks, [eye[0], eye[1], eye[2], 1.0], &mut culled);
            total += ones(&culled);
        }
        let percent = total as f64 / (2 * masks.len()) as f64;
        println!("{count} groups cull {percent:.2} %");
        assert!(percent >= floor, "{count} groups cull {percent} %");
    }
}

#[test]
fn sectors_cull_more_and_nothing_in_front() {
    let mut rng = Rng(13);
    let (positions, indices) = ball(&mut rng, 2000);
    let grid = MaskGrid::new(16).expect("a good N");
    let mut masks = NormalMasks::default();
    grid.encode_triangles(&positions, &indices, &mut masks);
    let mut culled = [0; 4];
    for view in 0..20 {
        let eye = rng.direction().map(|v| v * 3.0);
        // Some views are off-centre.
        let shift = if view % 3 == 0 { 0.3 } else { 0.0 };
        let projection =
            Projection::Perspective { fov_y_radians: 0.9, aspect: 1.5, near: 0.1, far: 100.0 };
        let direction = std::array::from_fn(|k| -eye[k] + shift * [0.7, -1.0, 0.5][k]);
        let camera = Camera { eye, direction, up: [0.1, 1.0, 0.2], projection };
        let frustum = camera.frustum().expect("a good camera");
        let corners = corner_directions(&frustum).expect("a perspective");
        let whole = mask_of_corners(&grid, Simd::best(), &corners, MaskUse::Camera).expect("it");
        for (slot, k) in [1, 2, 4, 8].into_iter().enumerate() {
            let sectors = mask_of_sectors(&grid, Simd::best(), &corners, k, MaskUse::Camera)
                .expect("sectors");
            assert_eq!(sectors.side(), k);
            if k == 1 {
                assert_eq!(sectors.sector(0, 0), &whole);
            }
            for t in 0..2000 {
                let triangle = [0, 1, 2].map(|c| positions[t * 3 + c]);
                let sphere = Sphere::from_points(&triangle);
                let Some(mask) = sectors.for_sphere(eye, &sphere) else {
                    // Outside of every sector: outside of the frustum.
                    let point = triangle[0].map(f64::from);
                    let out = frustum.planes().any(|(_, p)| p.distance(point) > -1e-6);
                    assert!(out, "triangle {t} is in view");
                    continue;
                };
                if !mask.culls(masks.get(t)) {
                    continue;
                }
                culled[slot] += 1;
                let (value, size) = front(triangle, [eye[0], eye[1], eye[2], 1.0]);
                let in_view = triangle.iter().any(|p| {
                    frustum.planes().all(|(_, plane)| plane.distance(p.map(f64::from)) <= 0.0)
                });
                assert!(!in_view || value <= size * 1e-12, "triangle {t} of view {view}, k {k}");
            }
        }
    }
    println!("culled with 1, 4, 16 and 64 sectors: {culled:?}");
    assert!(culled.is_sorted() && culled[3] * 10 > culled[0] * 13, "{culled:?}");
}

#[test]
fn sectors_of_what_has_none_are_refused() {
    let grid = MaskGrid::new(4).expect("a good N");
    let corners = [[-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0]];
    let make = |corners, k, purpose| mask_of_sectors(&grid, Simd::best(), corners, k, purpose);
    let other = MaskUse::ShadowOrReflection;
    assert_eq!(make(&corners, 2, other).err(), Some(SectorError::NotACameraView));
    assert_eq!(make(&corners, 0, MaskUse::Camera).err(), Some(SectorError::NoCorners));
    let flat = [[0.0, 0.0, 1.0]; 4];
    assert_eq!(make(&flat, 2, MaskUse::Camera).err(), Some(SectorError::NoCorners));
    let sectors = make(&corners, 2, MaskUse::Camera).expect("good corners");
    // A sphere that is not a number is in every sector; one behind the viewer in none.
    let nan = Sphere { center: [f32::NAN; 3], radius: 1.0 };
    let all = sectors.for_sphere([0.0; 3], &nan).expect("it may be seen");
    let one = sectors.sector(0, 0).clone();
    let every = [(1, 0), (0, 1), (1, 1)]
        .into_iter()
        .fold(one, |mask: BackfaceMask, (x, y)| mask.and(sectors.sector(x, y)));
    assert_eq!(all, every);
    let behind = Sphere { center: [0.0, 0.0, 5.0], radius: 1.0 };
    assert!(sectors.for_sphere([0.0; 3], &behind).is_none());
}
