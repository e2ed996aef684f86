//! Cases that occlusion buffers get wrong elsewhere: each has a known answer, in views of every kind.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{
    Convex, Occlusion, OcclusionBuffer, OcclusionError, Patch, Visibility,
};
use cullet::mesh::Part;
use cullet::{
    Camera, Culler, Depth, Instance, Mesh, MeshData, Projection, Scene, Simd, Stage, Transform,
    View, ViewState, Visible,
};

const SIZES: [[u32; 2]; 6] = [[1280, 720], [640, 360], [333, 187], [33, 17], [8, 8], [1, 1]];

fn perspective() -> Projection {
    Projection::Perspective { fov_y_radians: 1.0, aspect: 16.0 / 9.0, near: 0.1, far: 100.0 }
}

/// Views along −Z of every kind: perspective, infinite, off-centre, orthographic; each in both depths, and mirrored
/// in x, in y, in both.
fn views(eye: [f64; 3]) -> Vec<View> {
    let off_centre = |far| Projection::OffCentre {
        left: -0.02,
        right: 0.09,
        bottom: -0.05,
        top: 0.01,
        near: 0.1,
        far,
    };
    let orthographic = Projection::Orthographic {
        left: -3.0,
        right: 2.0,
        bottom: -2.5,
        top: 1.0,
        near: 0.1,
        far: 100.0,
    };
    let endless =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: f64::INFINITY };
    let kinds =
        [perspective(), endless, off_centre(100.0), off_centre(f64::INFINITY), orthographic];
    let mut views = Vec::new();
    for projection in kinds {
        for depth in [Depth::Standard, Depth::Reversed] {
            let camera =
                Camera { eye, direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], projection };
            let matrix = View::new(&camera, depth, [1280, 720]).unwrap().clip_from_world();
            for rows in [&[][..], &[0], &[1], &[0, 1]] {
                let mut m = matrix;
                rows.iter().for_each(|r| (0..4).for_each(|c| m[c * 4 + r] = -m[c * 4 + r]));
                views.push(View::from_matrix(m, depth, [1280, 720]).unwrap());
            }
        }
    }
    views
}

fn view() -> View {
    View::new(
        &Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], perspective()),
        Depth::Reversed,
        [1280, 720],
    )
    .unwrap()
}

fn cuboid(min: [f32; 3], max: [f32; 3]) -> Aabb {
    Aabb { min, max }
}

/// A flat wall across the line of sight.
fn wall(x: [f32; 2], y: [f32; 2], z: f32) -> Aabb {
    cuboid([x[0], y[0], z], [x[1], y[1], z])
}

/// The sides of walls as triangles, each side with corners of its own.
fn quads(walls: &[Aabb]) -> (Vec<[f32; 3]>, Vec<u32>) {
    let corners = |w: &Aabb| {
        let ([x0, y0, z], [x1, y1, _]) = (w.min, w.max);
        [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]]
    };
    let positions = walls.iter().flat_map(corners).collect();
    let indices =
        (0..walls.len() as u32 * 4).step_by(4).flat_map(|n| [0, 1, 2, 0, 2, 3].map(|k| n + k));
    (positions, indices.collect())
}

fn patch(positions: &[[f32; 3]], indices: &[u32], two_sided: bool) -> Vec<Patch> {
    Patch::cut(positions, indices, Patch::FACETS, two_sided).unwrap()
}

/// How walls are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
enum As {
    Convex,
    Patch,
    /// A box of which the transform is the wall, mirrored in x where the wall is not.
    Mirrored,
}

fn draw(buffer: &mut OcclusionBuffer, walls: &[Aabb], how: As, at: [f64; 3]) {
    let level = Simd::best();
    let here = Transform::from_translation(at);
    match how {
        As::Convex => {
            walls.iter().for_each(|w| Convex::from_box(w).unwrap().draw(level, buffer, &here));
        }
        As::Patch => {
            let (positions, indices) = quads(walls);
            patch(&positions, &indices, true).iter().for_each(|p| p.draw(level, buffer, &here));
        }
        As::Mirrored => {
            let mirror = Transform::from_scale_translation([-1.0, 1.0, 1.0], at);
            for w in walls {
                let flipped =
                    cuboid([-w.max[0], w.min[1], w.min[2]], [-w.min[0], w.max[1], w.max[2]]);
                Convex::from_box(&flipped).unwrap().draw(level, buffer, &mirror);
            }
        }
    }
}

fn drawn(view: &View, size: [u32; 2], walls: &[Aabb], how: As) -> OcclusionBuffer {
    let mut buffer = OcclusionBuffer::new(size).unwrap();
    buffer.begin(view, [0.0; 3]);
    draw(&mut buffer, walls, how, [0.0; 3]);
    buffer
}

/// Behind a wall that fills the view, in front of it, through it, touching it, and out of the view.
fn hold(buffer: &OcclusionBuffer, case: &str) {
    for (occludee, visibility, what) in [
        (cuboid([-0.4, -0.6, -9.0], [0.3, -0.2, -8.0]), Visibility::Hidden, "behind"),
        (cuboid([-0.4, -0.6, -5.1], [0.3, -0.2, -5.01]), Visibility::Hidden, "close behind"),
        (cuboid([-300.0, -300.0, -90.0], [0.3, -0.2, -8.0]), Visibility::Hidden, "behind the edge"),
        (cuboid([-0.4, -0.6, -4.0], [0.3, -0.2, -3.0]), Visibility::Visible, "before"),
        (cuboid([-0.4, -0.6, -6.0], [0.3, -0.2, -4.0]), Visibility::Visible, "through"),
        (cuboid([-0.4, -0.6, -6.0], [0.3, -0.2, -5.0]), Visibility::Visible, "touching"),
        (cuboid([-0.4, -0.6, -5.0], [0.3, -0.2, -5.0]), Visibility::Visible, "in its plane"),
        (
            cuboid([-0.4, -0.6, -6.0], [0.3, -0.2, 0.0]),
            Visibility::Visible,
            "through the near plane",
        ),
        (cuboid([-0.4, -0.6, -6.0], [0.3, -0.2, 9.0]), Visibility::Visible, "around the eye"),
        (cuboid([500.0, -0.6, -6.0], [501.0, -0.2, -5.5]), Visibility::Outside, "beside the view"),
        (cuboid([-0.4, -0.6, 5.0], [0.3, -0.2, 6.0]), Visibility::Outside, "behind the eye"),
    ] {
        assert_eq!(buffer.test_box(&occludee), visibility, "{what}, {case}");
    }
}

#[test]
fn answers_are_right_in_views_of_every_kind_and_size() {
    let fills = [wall([-90.0, 90.0], [-90.0, 90.0], -5.0)];
    for (number, view) in views([0.0; 3]).iter().enumerate() {
        for size in SIZES {
            for how in [As::Convex, As::Patch, As::Mirrored] {
                let buffer = drawn(view, size, &fills, how);
                hold(&buffer, &format!("view {number} {size:?} {how:?}"));
            }
        }
    }
}

#[test]
fn far_from_the_origin_a_rebased_scene_has_the_same_answers() {
    let fills = [wall([-90.0, 90.0], [-90.0, 90.0], -5.0)];
    let far = [1e7, -1e7, 1e7];
    for (number, view) in views(far).iter().enumerate() {
        for size in [[640, 360], [33, 17], [1, 1]] {
            let mut buffer = OcclusionBuffer::new(size).unwrap();
            buffer.begin(view, far);
            draw(&mut buffer, &fills, As::Convex, far);
            hold(&buffer, &format!("view {number} {size:?} at {far:?}"));
        }
    }
}

#[test]
fn gaps_from_a_thousandth_to_a_whole_pixel_are_seen_through() {
    // A pixel of 1280 × 720 at a distance of 5.
    let px = 2.0 * 5.0 * 0.5_f32.tan() / 720.0;
    let occludee = cuboid([-1.0, -1.0, -9.0], [1.0, 1.0, -8.0]);
    for parts in [1e-3_f32, 1e-2, 0.1, 0.3, 0.5, 0.9, 1.0] {
        let gap = parts * px;
        let upright =
            [wall([-20.0, 0.0], [-20.0, 20.0], -5.0), wall([gap, 20.0], [-20.0, 20.0], -5.0)];
        let level =
            [wall([-20.0, 20.0], [-20.0, 0.0], -5.0), wall([-20.0, 20.0], [gap, 20.0], -5.0)];
        // Two walls meet a third whose edge stands back.
        let junction = [
            wall([-20.0, 0.0], [-20.0, 20.0], -5.0),
            wall([0.0, 20.0], [-20.0, 0.0], -5.0),
            wall([gap, 20.0], [0.0, 20.0], -5.0),
        ];
        for size in SIZES {
            for walls in [&upright[..], &level, &junction] {
                for how in [As::Convex, As::Patch] {
                    let buffer = drawn(&view(), size, walls, how);
                    let visibility = buffer.test_box(&occludee);
                    assert_eq!(visibility, Visibility::Visible, "{parts} px, {size:?} {how:?}");
                }
            }
        }
        // A box that the gap does not show is still hidden.
        let aside = cuboid([-2.0, -1.5, -9.0], [-1.0, -1.0, -8.0]);
        let buffer = drawn(&view(), [640, 360], &upright, As::Convex);
        assert_eq!(buffer.test_box(&aside), Visibility::Hidden, "{parts} px");
    }
}

#[test]
fn a_vertex_off_the_edge_that_it_divides_leaves_a_gap() {
    // One large triangle to the left of x = 0, two to the right whose common vertex on that edge is dented.
    let px = 2.0 * 5.0 * 0.5_f32.tan() / 720.0;
    for dent in [1e-3 * px, 0.1 * px, px] {
        let positions = [
            [0.0, -20.0, -5.0],
            [0.0, 20.0, -5.0],
            [-40.0, 0.0, -5.0],
            [dent, 0.1, -5.0],
            [40.0, 0.0, -5.0],
        ];
        let indices = [0, 1, 2, 0, 4, 3, 3, 4, 1];
        for size in SIZES {
            let mut buffer = OcclusionBuffer::new(size).unwrap();
            buffer.begin(&view(), [0.0; 3]);
            for p in patch(&positions, &indices, true) {
                p.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
            }
            let occludee = cuboid([-0.5, -0.5, -9.0], [0.5, 0.5, -8.0]);
            assert_eq!(buffer.test_box(&occludee), Visibility::Visible, "{dent} {size:?}");
        }
    }
}

#[test]
fn a_wall_that_ends_short_of_the_screen_shows_what_is_at_its_edge() {
    let (half_height, z) = (0.5_f64.tan() * 5.0, -5.0);
    let half_width = (half_height * 16.0 / 9.0) as f32;
    let px = 2.0 * half_height as f32 / 720.0;
    let occludee = cuboid([0.0, -0.5, -9.0], [40.0, 0.5, -8.0]);
    for (short, visibility) in [
        (-10.0 * px, Visibility::Hidden),
        (1e-3 * px, Visibility::Visible),
        (px, Visibility::Visible),
    ] {
        for size in SIZES {
            let walls = [wall([-90.0, half_width - short], [-90.0, 90.0], z)];
            for how in [As::Convex, As::Patch] {
                let buffer = drawn(&view(), size, &walls, how);
                assert_eq!(buffer.test_box(&occludee), visibility, "{short} {size:?} {how:?}");
            }
        }
    }
}

#[test]
fn an_occluder_through_the_near_plane_hides_what_it_hides() {
    // A floor that goes on behind the eye: through w = 0, and with corners just beside it.
    for back in [9.0, 1e-30, 0.0, -1e-30, -0.05, -0.1] {
        let floor = cuboid([-50.0, -1.0, -50.0], [50.0, -1.0, back]);
        for how in [As::Convex, As::Mirrored] {
            let buffer = drawn(&view(), [640, 360], &[floor], how);
            let below = cuboid([-1.0, -3.0, -10.0], [1.0, -1.5, -9.0]);
            let above = cuboid([-1.0, -0.9, -10.0], [1.0, 1.5, -9.0]);
            assert_eq!(buffer.test_box(&below), Visibility::Hidden, "{back} {how:?}");
            assert_eq!(buffer.test_box(&above), Visibility::Visible, "{back} {how:?}");
        }
    }
}

#[test]
fn a_surface_through_the_near_plane_hides_what_it_hides() {
    let corner = |x: f32, z: f32| [x, -1.0, z];
    for back in [9.0, 1e-30, 0.0, -1e-30, -0.05, -0.1] {
        let floor = [corner(-50.0, -50.0), corner(50.0, -50.0), corner(50.0, back)];
        let floor = [floor[0], floor[1], floor[2], corner(-50.0, back)];
        let mut buffer = OcclusionBuffer::new([640, 360]).unwrap();
        buffer.begin(&view(), [0.0; 3]);
        for patch in patch(&floor, &[0, 1, 2, 0, 2, 3], true) {
            patch.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        }
        let below = cuboid([-1.0, -3.0, -10.0], [1.0, -1.5, -9.0]);
        let above = cuboid([-1.0, -0.9, -10.0], [1.0, 1.5, -9.0]);
        assert_eq!(buffer.test_box(&below), Visibility::Hidden, "{back}");
        assert_eq!(buffer.test_box(&above), Visibility::Visible, "{back}");
    }
}

#[test]
fn an_occluder_around_the_eye_hides_nothing() {
    let occludees = [
        cuboid([-0.4, -0.4, -9.0], [0.4, 0.4, -8.0]),
        cuboid([-0.4, -0.4, -0.9], [0.4, 0.4, -0.8]),
        cuboid([-90.0; 3], [90.0, 90.0, -6.0]),
    ];
    for half in [0.11, 0.2, 1.0, 5.0] {
        let around = cuboid([-half; 3], [half; 3]);
        for size in SIZES {
            let buffer = drawn(&view(), size, &[around], As::Convex);
            for occludee in &occludees {
                assert_eq!(buffer.test_box(occludee), Visibility::Visible, "{half} {size:?}");
            }
        }
    }
}

#[test]
fn nothing_hides_itself() {
    let block = cuboid([-1.0, -0.5, -7.0], [1.5, 0.5, -5.0]);
    let grown = cuboid([-1.0, -0.5, -7.0], [1.5, 0.5, -5.0_f32.next_up()]);
    for view in views([0.0; 3]) {
        for size in SIZES {
            let buffer = drawn(&view, size, &[block], As::Convex);
            assert_ne!(buffer.test_box(&block), Visibility::Hidden, "{size:?}");
            assert_ne!(buffer.test_box(&grown), Visibility::Hidden, "{size:?}");
        }
    }
}

/// A grid of n × n squares, two triangles each, with corners (x0, y0) and (x1, y1).
fn grid(n: u32, low: [f32; 2], high: [f32; 2], z: f32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let at = |i: u32, a: usize| low[a] + (high[a] - low[a]) * (i as f32 / n as f32);
    let row = n + 1;
    let positions = (0..row * row).map(|v| [at(v % row, 0), at(v / row, 1), z]).collect();
    let indices = (0..n * n).flat_map(|i| {
        let v = i / n * row + i % n;
        [v, v + 1, v + row + 1, v, v + row + 1, v + row]
    });
    (positions, indices.collect())
}

#[test]
fn a_hundred_thousand_triangles_in_a_pixel_hide_no_more_than_they_cover() {
    let (size, px) = ([320, 180], 2.0 * 5.0 * 0.5_f32.tan() / 180.0);
    // 224 × 224 squares: within one pixel, then over three by three of them.
    for (low, high, most) in [([0.1, 0.1], [0.9, 0.9], 0), ([-1.05, -1.05], [2.05, 2.05], 9)] {
        let (positions, indices) = grid(224, low.map(|v| v * px), high.map(|v| v * px), -5.0);
        assert_eq!(indices.len() / 3, 100_352);
        let mut buffer = OcclusionBuffer::new(size).unwrap();
        buffer.begin(&view(), [0.0; 3]);
        for p in patch(&positions, &indices, false) {
            p.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        }
        let covered: Vec<_> = (0..size[0] * size[1])
            .map(|i| [i % size[0], i / size[0]])
            .filter(|&[x, y]| buffer.nearness(x, y) > 0.0)
            .collect();
        // Fewer is no fault: of patches that are smaller than a pixel none covers it alone.
        assert!(covered.len() <= most, "{covered:?}");
        let wide = px * 4.0;
        let occludee = cuboid([-wide, -wide, -9.0], [wide, wide, -8.0]);
        assert_eq!(buffer.test_box(&occludee), Visibility::Visible);
    }
}

#[test]
fn slivers_cover_nothing_and_a_sheet_of_them_hides_nothing_before_it() {
    let occludee = cuboid([-0.5, -0.5, -9.0], [0.5, 0.5, -8.0]);
    let before = cuboid([-0.5, -0.5, -4.9], [0.5, 0.5, -4.8]);
    for width in [0.0, 1e-30, 1e-7, 1e-4] {
        let positions = [[-20.0, 0.0, -5.0], [20.0, 0.0, -5.0], [0.0, width, -5.0]];
        for size in SIZES {
            let mut buffer = OcclusionBuffer::new(size).unwrap();
            buffer.begin(&view(), [0.0; 3]);
            for p in patch(&positions, &[0, 1, 2], true) {
                p.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
            }
            if let Ok(polygon) = Convex::from_polygon(&positions) {
                polygon.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
            }
            assert_eq!(buffer.test_box(&occludee), Visibility::Visible, "{width} {size:?}");
        }
    }
    // Two thousand strips, each a hundredth of a pixel and less, with shared edges.
    let n = 1000;
    let x = |i: u32| -1.0 + 2.0 * i as f32 / n as f32 * 0.01;
    let positions: Vec<[f32; 3]> =
        (0..=n).flat_map(|i| [[x(i), -9.0, -5.0], [x(i), 9.0, -5.0]]).collect();
    let indices: Vec<u32> = (0..n).flat_map(|i| [0, 2, 3, 0, 3, 1].map(|k| i * 2 + k)).collect();
    let mut buffer = OcclusionBuffer::new([640, 360]).unwrap();
    buffer.begin(&view(), [0.0; 3]);
    for p in patch(&positions, &indices, false) {
        p.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    assert_eq!(buffer.test_box(&before), Visibility::Visible);
    assert_eq!(buffer.test_box(&occludee), Visibility::Visible);
}

#[test]
fn numbers_that_are_none_hide_nothing_and_are_not_hidden() {
    let fills = [wall([-90.0, 90.0], [-90.0, 90.0], -5.0)];
    let mut buffer = drawn(&view(), [320, 180], &fills, As::Convex);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let good = cuboid([-0.4, -0.6, -9.0], [0.3, -0.2, -8.0]);
            let (mut low, mut high) = (good, good);
            low.min[axis] = bad;
            high.max[axis] = bad;
            for occludee in [low, high].into_iter().filter(|b| !b.is_empty()) {
                assert_eq!(buffer.test_box(&occludee), Visibility::Visible, "{occludee:?}");
            }
            assert!(Convex::from_box(&low).is_err(), "{low:?}");
            let mut corners = [[0.0, 0.0, -5.0], [1.0, 0.0, -5.0], [0.0, 1.0, -5.0]];
            corners[1][axis] = bad;
            assert!(Convex::from_polygon(&corners).is_err());
            let refused = Patch::cut(&corners, &[0, 1, 2], Patch::FACETS, true);
            assert!(
                matches!(refused, Err(OcclusionError::NotFinite { vertex: 1, .. })),
                "{refused:?}"
            );
        }
    }
    // A transform of which nothing can be told draws nothing.
    buffer.begin(&view(), [0.0; 3]);
    let convex = Convex::from_box(&fills[0]).unwrap();
    let (positions, indices) = quads(&fills);
    let patches = patch(&positions, &indices, true);
    let occludee = cuboid([-0.4, -0.6, -9.0], [0.3, -0.2, -8.0]);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut transforms = vec![Transform::from_translation([0.0, f64::from(bad), 0.0])];
        for axis in 0..3 {
            let mut t = Transform::IDENTITY;
            t.linear[axis][1] = bad;
            transforms.push(t);
        }
        for t in transforms {
            buffer.begin(&view(), [0.0; 3]);
            convex.draw(Simd::best(), &mut buffer, &t);
            patches.iter().for_each(|p| p.draw(Simd::best(), &mut buffer, &t));
            assert_eq!(buffer.test_box(&occludee), Visibility::Visible, "{t:?}");
        }
    }
    // Flattened to a line, the wall hides nothing; as large as f32 is, it may.
    buffer.begin(&view(), [0.0; 3]);
    let flat = Transform::from_scale_translation([1.0, 0.0, 1.0], [0.0; 3]);
    let huge = Transform::from_scale_translation([f32::MAX / 100.0, 1.0, 1.0], [0.0; 3]);
    for t in [flat, huge] {
        convex.draw(Simd::best(), &mut buffer, &t);
        patches.iter().for_each(|p| p.draw(Simd::best(), &mut buffer, &t));
        let before = cuboid([-0.4, -0.6, -4.0], [0.3, -0.2, -3.0]);
        assert_eq!(buffer.test_box(&before), Visibility::Visible, "{t:?}");
        if t == flat {
            assert_eq!(buffer.test_box(&occludee), Visibility::Visible);
        }
    }
}

#[test]
fn buffers_of_no_size_or_a_huge_one_are_refused_with_the_limit() {
    let limit = OcclusionBuffer::LIMIT;
    for size in [[0, 1], [1, 0], [0, 0], [limit + 1, 1], [1, limit + 1], [u32::MAX; 2]] {
        let error = OcclusionBuffer::new(size).unwrap_err();
        assert_eq!(error, OcclusionError::Size(size[0], size[1], limit));
        assert!(error.to_string().contains(&limit.to_string()), "{error}");
    }
    for size in [[limit, 1], [1, limit]] {
        let fills = [wall([-90.0, 90.0], [-90.0, 90.0], -5.0)];
        hold(&drawn(&view(), size, &fills, As::Convex), &format!("{size:?}"));
    }
    let empty = OcclusionBuffer::new([9, 9]).unwrap();
    let occludee = cuboid([-0.4, -0.6, -9.0], [0.3, -0.2, -8.0]);
    assert_eq!(empty.test_box(&occludee), Visibility::Visible, "before it has a view");
}

/// A wall of two triangles before a row of others, one-sided towards +Z.
fn rows() -> Scene {
    let (positions, indices) = quads(&[wall([-1.0, 1.0], [-1.0, 1.0], 0.0)]);
    let parts = vec![Part { triangle_count: 2, ..Part::default() }];
    let mesh = Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap();
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    for z in 0..9 {
        let size = if z == 0 { 9.0 } else { 0.5 };
        let at =
            Transform::from_scale_translation([size, size, 1.0], [0.0, 0.0, -5.0 - f64::from(z)]);
        scene.add(Instance::new(mesh, at)).unwrap();
    }
    scene.commit(&Culler::default());
    scene
}

#[test]
fn a_budget_of_nothing_hides_nothing_and_the_front_wall_is_never_hidden() {
    let scene = rows();
    for (budget, hidden) in [(0.0, 0), (f32::NAN, 0), (-1.0, 0), (2000.0, 8), (f32::INFINITY, 8)] {
        for width in [33, 640, u32::MAX] {
            let culler = Culler::default()
                .with_occlusion(Occlusion::default().with_width(width).with_budget(budget))
                .with_reasons(true);
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            culler.cull_one(&scene, &view(), &mut state, &mut visible);
            let gone = visible.reasons.iter().flatten().filter(|r| r.stage == Stage::Occlusion);
            assert_eq!(gone.count(), hidden, "budget {budget}, width {width}");
        }
    }
}
