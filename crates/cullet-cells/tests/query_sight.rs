//! Lines of sight against every triangle one by one, through seams, and where the answer is by definition.

use cullet::mesh::{Alpha, Part};
use cullet::{Instance, InstanceFlags, Mesh, MeshData, Scene, Transform, scene::BoundsOverride};
use cullet_cells::query::{
    BlockingSides, Find, Segment, Sight, SightOptions, line_of_sight, lines_of_sight,
};
use cullet_testkit::meshes::{of_parts, one_sided};
use cullet_testkit::oracles::sight::{place, sight_ref};
use cullet_testkit::scenes::{city, elsewhere, mixed_scene, random_scene};
use cullet_testkit::views::looking_down_z;
use cullet_testkit::{Rng, cases, soups};

/// A point in or near the box around everything.
fn near(scene: &Scene, rng: &mut Rng) -> [f64; 3] {
    let (b, origin) = (scene.extent(), scene.origin());
    std::array::from_fn(|a| {
        let (min, max) = (f64::from(b.min[a]), f64::from(b.max[a]));
        origin[a] + rng.range(min - (max - min) * 0.1, max + (max - min) * 0.1)
    })
}

fn random_options(scene: &Scene, rng: &mut Rng) -> SightOptions {
    let mut options = SightOptions::default();
    if rng.chance(0.3) {
        options.layers = 1 << rng.below(3);
    }
    if rng.chance(0.5) {
        options.sides = BlockingSides::Both;
    }
    if rng.chance(0.3) {
        options.ignored[rng.index(2)] =
            scene.handle(rng.below(u64::from(scene.slot_count())) as u32);
    }
    options
}

/// Holds one query against every triangle; whether it is blocked, and whether that was beyond doubt.
fn check(scene: &Scene, from: [f64; 3], to: [f64; 3], options: &SightOptions) -> (bool, bool) {
    let hits = sight_ref(scene, from, to, options);
    let nearest = line_of_sight(scene, from, to, options);
    let sure = hits.iter().filter(|h| h.sure);
    match nearest {
        Sight::Clear => {
            assert!(sure.count() == 0, "{from:?} {to:?}: clear, but {hits:?}");
        }
        Sight::Blocked(by) => {
            let hit = hits.iter().find(|h| (h.slot, h.triangle) == (by.slot, by.triangle));
            let hit = hit.unwrap_or_else(|| panic!("{from:?} {to:?}: {by:?} of {hits:?}"));
            assert!(!hit.sure || (hit.share - by.share).abs() <= 1e-4, "{by:?} {hit:?}");
            for other in sure {
                assert!(other.share >= by.share - 1e-4, "{by:?}, but {other:?} is nearer");
            }
            assert_eq!(scene.handle(by.slot), Some(by.handle));
            assert!(by.share > 0.0 && by.share < 1.0);
            for a in 0..3 {
                let at = from[a] + (to[a] - from[a]) * by.share;
                assert!((by.point[a] - at).abs() <= 1e-12 * (from[a].abs() + to[a].abs()));
            }
        }
    }
    let any = line_of_sight(scene, from, to, &SightOptions { find: Find::Any, ..*options });
    assert_eq!(any.is_blocked(), nearest.is_blocked());
    if let Sight::Blocked(by) = any {
        assert!(hits.iter().any(|h| (h.slot, h.triangle) == (by.slot, by.triangle)), "{by:?}");
    }
    (nearest.is_blocked(), hits.iter().all(|h| h.sure))
}

#[test]
fn what_blocks_is_what_every_triangle_one_by_one_says() {
    let mut rng = Rng(0x51_6447);
    let (mut blocked, mut clear, mut doubtful) = (0, 0, 0);
    for round in 0..cases(60) {
        let mut scene = match round % 3 {
            0 => random_scene(&mut rng, 3 + round as usize % 40),
            _ => mixed_scene(&mut rng),
        };
        if round % 4 == 3 {
            elsewhere(&mut scene, &looking_down_z(), &mut rng);
        }
        for committed in [false, true] {
            if committed {
                scene.commit(&cullet::Culler::default());
                let extent = scene.extent();
                if !extent.is_empty() && rng.chance(0.5) {
                    scene.rebase(std::array::from_fn(|a| {
                        f64::from(extent.min[a]) + scene.origin()[a]
                    }));
                }
            }
            if scene.extent().is_empty() {
                continue;
            }
            for _ in 0..60 {
                let (from, mut to) = (near(&scene, &mut rng), near(&scene, &mut rng));
                // Mostly past some instance: else most lines meet nothing.
                let aim = scene.bounds(rng.below(u64::from(scene.slot_count())) as u32);
                if aim.is_finite() && !aim.is_empty() && rng.chance(0.8) {
                    let (middle, reach) = (aim.center(), rng.range(0.8, 2.0));
                    to = std::array::from_fn(|a| {
                        from[a] + (scene.origin()[a] + middle[a] - from[a]) * reach
                    });
                }
                let options = random_options(&scene, &mut rng);
                let (is_blocked, sure) = check(&scene, from, to, &options);
                blocked += u32::from(is_blocked);
                clear += u32::from(!is_blocked);
                doubtful += u32::from(!sure);
            }
        }
    }
    let least = cases(60) * 10;
    assert!(
        blocked > least && clear > least && doubtful * 4 < blocked + clear,
        "{blocked} {clear} {doubtful}"
    );
}

/// From a place within, to points beyond the very corners and edges: nothing gets out, however it is turned,
/// sheared and moved. The corners are computed as an application would, so that rounding puts the line beside the
/// edge on either side.
#[test]
fn nothing_slips_through_the_edges_of_a_closed_mesh() {
    let mut rng = Rng(77);
    for round in 0..cases(40) {
        let (positions, indices) = match round % 3 {
            0 => soups::ball(5, 7),
            1 => soups::divided_block(4),
            // Corners that are not shared but lie in one place.
            _ => soups::unshared(&soups::bumpy_ball(6, 0.05)),
        };
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(one_sided((positions.clone(), indices.clone())));
        let far = [1.0, 1e3, 1e7][rng.index(3)];
        let mut t = Transform::from_translation(rng.vector(far));
        t.linear = std::array::from_fn(|_| rng.vector(1.0).map(|v| v as f32));
        if t.determinant().abs() < 0.05 {
            continue;
        }
        scene.add(Instance::new(mesh, t)).unwrap();
        scene.commit(&cullet::Culler::default());
        let b = scene.mesh(0).bounds();
        let middle = place(&t, std::array::from_fn(|a| (b.min[a] + b.max[a]) * 0.5));
        let options = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
        for corners in indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|k| place(&t, positions[corners[k] as usize]));
            for (i, j, share) in [(0, 0, 0.0), (0, 1, 0.5), (1, 2, 0.25), (2, 0, rng.unit())] {
                let (p, q): ([f64; 3], [f64; 3]) = (corners[i], corners[j]);
                let beyond = std::array::from_fn(|a| {
                    let on_edge = p[a] + (q[a] - p[a]) * share;
                    middle[a] + (on_edge - middle[a]) * 3.0
                });
                assert!(line_of_sight(&scene, middle, beyond, &options).is_blocked(), "{round}");
                assert!(line_of_sight(&scene, beyond, middle, &options).is_blocked(), "{round}");
            }
        }
    }
}

fn wall(two_sided: bool, alpha: Alpha) -> Mesh {
    let p = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let part = Part { triangle_count: 2, two_sided, alpha, ..Part::default() };
    of_parts((p, vec![0, 1, 2, 0, 2, 3]), vec![part])
}

/// Change that makes an instance another.
type Change = fn(&mut Instance);

fn alone(mesh: Mesh, change: impl FnOnce(&mut Instance)) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    let mut instance = Instance::new(mesh, Transform::IDENTITY);
    change(&mut instance);
    scene.add(instance).unwrap();
    scene
}

const FRONT: [f64; 3] = [0.3, 0.2, 5.0];
const BACK: [f64; 3] = [0.3, 0.2, -5.0];

fn blocks(scene: &Scene, from: [f64; 3], to: [f64; 3]) -> bool {
    line_of_sight(scene, from, to, &SightOptions::default()).is_blocked()
}

#[test]
fn a_one_sided_wall_blocks_from_the_side_that_is_drawn() {
    let both = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
    for mirrored in [false, true] {
        let scene = alone(wall(false, Alpha::Opaque), |i| {
            if mirrored {
                i.transform = Transform::from_scale_translation([-1.0, 1.0, 1.0], [0.0; 3]);
            }
        });
        // A mirrored instance keeps its front in front.
        assert!(blocks(&scene, FRONT, BACK) && !blocks(&scene, BACK, FRONT));
        assert!(line_of_sight(&scene, BACK, FRONT, &both).is_blocked());
    }
    let double = alone(wall(false, Alpha::Opaque), |i| i.flags.double_sided = true);
    let two = alone(wall(true, Alpha::Opaque), |_| {});
    assert!([double, two].iter().all(|s| blocks(s, FRONT, BACK) && blocks(s, BACK, FRONT)));
}

#[test]
fn what_is_not_opaque_rigid_drawn_or_wanted_does_not_block() {
    let opaque = || wall(true, Alpha::Opaque);
    let deformable = {
        let data = opaque().to_data();
        Mesh::new(MeshData { deformable: true, ..data }).unwrap()
    };
    let clear: [(&str, Mesh, Change); 9] = [
        ("masked", wall(true, Alpha::Masked), |_| {}),
        ("blended", wall(true, Alpha::Blended), |_| {}),
        ("transparent", opaque(), |i| i.flags.transparent = true),
        ("in no layer", opaque(), |i| i.layers = 0),
        ("deformable", deformable, |_| {}),
        ("margin", opaque(), |i| i.bounds = BoundsOverride::Margin(1.0)),
        ("no bounds", opaque(), |i| i.bounds = BoundsOverride::None),
        ("not finite", opaque(), |i| i.transform.translation[1] = f64::NAN),
        ("flat", opaque(), |i| i.transform.linear[2] = [0.0; 3]),
    ];
    for (name, mesh, change) in clear {
        assert!(!blocks(&alone(mesh, change), FRONT, BACK), "{name}");
    }
    let scene = alone(opaque(), |i| {
        i.layers = 4;
        i.flags = InstanceFlags { no_occlusion: true, always_visible: true, ..i.flags };
    });
    assert!(blocks(&scene, FRONT, BACK), "an instance that is never an occluder is drawn");
    let handle = scene.handle(0);
    for options in [
        SightOptions { layers: 3, ..SightOptions::default() },
        SightOptions { ignored: [None, handle], ..SightOptions::default() },
    ] {
        assert_eq!(line_of_sight(&scene, FRONT, BACK, &options), Sight::Clear);
    }
}

#[test]
fn ends_that_are_no_places_or_lie_on_the_surface_are_clear() {
    let scene = alone(wall(true, Alpha::Opaque), |_| {});
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2e17] {
        for axis in 0..3 {
            let mut end = BACK;
            end[axis] = bad;
            assert!(!blocks(&scene, FRONT, end) && !blocks(&scene, end, FRONT), "{end:?}");
        }
    }
    assert!(!blocks(&Scene::new(), FRONT, BACK), "nothing is in the way in nothing");
    let on = [0.3, 0.2, 0.0];
    assert!(!blocks(&scene, FRONT, on) && !blocks(&scene, on, BACK) && !blocks(&scene, on, on));
    assert!(blocks(&scene, FRONT, [0.3, 0.2, -1e-15]), "by however little it is beyond");
    // Along the wall, within its plane.
    assert!(!blocks(&scene, [-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]));
    // Its very corner, edge and diagonal are part of it.
    for [x, y] in [[1.0, 1.0], [1.0, 0.5], [0.5, 0.5]] {
        assert!(blocks(&scene, [x, y, 3.0], [x, y, -3.0]));
    }
    assert!(!blocks(&scene, [1.0 + 1e-15, 0.5, 3.0], [1.0 + 1e-15, 0.5, -3.0]));
}

/// Streets and houses: of lines between two people most are blocked, and by what all triangles say.
#[test]
fn in_a_city_most_people_do_not_see_each_other() {
    let mut scene = city(8, 4, 200);
    scene.commit(&cullet::Culler::default());
    let mut rng = Rng(4);
    let segments: Vec<Segment> = (0..300)
        .map(|_| {
            let mut person = || [rng.range(-90.0, 90.0), 1.7, rng.range(-90.0, 90.0)];
            Segment { from: person(), to: person() }
        })
        .collect();
    let options = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
    let mut results = vec![Sight::Clear];
    lines_of_sight(&scene, &segments, &options, &mut results);
    assert_eq!(results.len(), segments.len());
    for (s, &result) in segments.iter().zip(&results) {
        assert_eq!(result, line_of_sight(&scene, s.from, s.to, &options));
    }
    let blocked = results.iter().filter(|r| r.is_blocked()).count();
    assert!(blocked >= 285, "{blocked} of 300");
    for s in &segments[..cases(40).min(300) as usize] {
        check(&scene, s.from, s.to, &options);
    }
}

#[test]
fn commits_change_no_answer() {
    let mut rng = Rng(21);
    let mut scene = random_scene(&mut rng, 300);
    let ends: Vec<_> = (0..300).map(|_| (near(&scene, &mut rng), near(&scene, &mut rng))).collect();
    let options = SightOptions::default();
    let ask = |scene: &Scene| -> Vec<_> {
        let one = |&(from, to): &_| match line_of_sight(scene, from, to, &options) {
            Sight::Clear => None,
            Sight::Blocked(by) => Some((by.handle, by.triangle, by.share.to_bits())),
        };
        ends.iter().map(one).collect()
    };
    let before = ask(&scene);
    scene.commit(&cullet::Culler::default());
    assert_eq!(ask(&scene), before);
    assert!(before.iter().filter(|b| b.is_some()).count() > 30);
}
