//! Groups that the author made: always right, and their walk always the answer of a flat sweep.

mod common;

use common::{Rng, random_box, random_planes};
use cullet::Level;
use cullet::bounds::{Aabb, Boxes, Plane};
use cullet::cull::frustum::batch::{self, Planes, mask_words};
use cullet::cull::frustum::groups::{Fate, cull_groups, cull_groups_ref, explain_groups};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::{Groups, GroupsError, Member};
use proptest::prelude::*;

/// Groups of some shape, things in some of them that lie near each other, boxes of any kind.
struct World {
    parents: Vec<u32>,
    members: Vec<[u32; 2]>,
    bounds: Vec<Aabb>,
}

impl World {
    fn random(rng: &mut Rng) -> Self {
        let groups = [0, 1, 3, 40, 300][rng.below(5) as usize];
        let things = [0, 1, 20, 900, 3000][rng.below(5) as usize];
        // Flat, like a tree of some width, a chain.
        let shape = rng.below(3);
        let mut parents: Vec<u32> = (0..groups)
            .map(|g| match shape {
                0 => Groups::NONE,
                1 if g > 0 => rng.below(g) as u32,
                2 if g > 0 => g as u32 - 1,
                _ => Groups::NONE,
            })
            .collect();
        // A number says nothing about who is above whom.
        if rng.below(2) == 0 {
            parents.reverse();
            for parent in parents.iter_mut().filter(|p| **p != Groups::NONE) {
                *parent = groups as u32 - 1 - *parent;
            }
        }
        let places: Vec<[f64; 3]> = (0..groups).map(|_| rng.vector(90.0)).collect();
        let mut bounds = Vec::new();
        let mut members = Vec::new();
        for item in 0..things as u32 {
            let group =
                if groups == 0 || rng.below(20) == 0 { None } else { Some(rng.below(groups)) };
            let mut b = random_box(rng);
            // Near the others of its group, mostly, so that groups are outside and inside at times.
            if let Some(group) = group {
                members.push([group as u32, item]);
                let plain = b.min.iter().chain(&b.max).all(|v| v.abs() < 200.0) && !b.is_empty();
                if plain {
                    let place = places[group as usize].map(|v| v as f32);
                    b.min = std::array::from_fn(|a| b.min[a] * 0.1 + place[a]);
                    b.max = std::array::from_fn(|a| b.max[a] * 0.1 + place[a]);
                }
            }
            bounds.push(b);
        }
        for i in (1..members.len()).rev() {
            members.swap(i, rng.below(i as u64 + 1) as usize);
        }
        Self { parents, members, bounds }
    }

    fn groups(&self) -> Groups {
        Groups::build(&self.parents, &self.members, &self.bounds).expect("good groups")
    }
}

fn check(planes: &Planes, groups: &Groups, cut: &mut Cut) {
    let boxes = groups.boxes();
    let words = mask_words(boxes.len());
    let expected = cull_groups_ref(planes, groups);
    for level in common::levels() {
        let (mut visible, mut inside) = (vec![0; words], vec![0; words]);
        batch::classify_boxes(level, planes, boxes, 0, &mut visible, &mut inside);
        cull_groups(level, planes, groups, cut);
        assert_eq!((cut.visible(), cut.inside()), (&*visible, &*inside), "{level:?}");
        let touched: Vec<_> = (0..words).filter(|&w| visible[w] != 0).collect();
        assert!(cut.touched().eq(touched), "{level:?}");
        let mut fates = Vec::new();
        explain_groups(level, planes, groups, cut, &mut fates);
        assert_eq!((cut.visible(), cut.inside()), (&*visible, &*inside), "explained, {level:?}");
        assert_eq!(fates, expected, "{level:?}");
    }
}

#[test]
fn the_walk_of_groups_is_the_sweep() {
    let mut rng = Rng(11);
    let mut cut = Cut::new();
    let mut whole = 0;
    for _ in 0..60 {
        let groups = World::random(&mut rng).groups();
        groups.validate().expect("just built");
        for _ in 0..4 {
            let planes = random_planes(&mut rng);
            check(&planes, &groups, &mut cut);
            let fates = cull_groups_ref(&planes, &groups);
            whole += fates.iter().filter(|f| matches!(f, Fate::WithGroup { .. })).count();
        }
    }
    assert!(whole > 5_000, "only {whole} things went with a group: the test tests little");
}

#[test]
fn places_are_a_permutation_with_each_group_in_one_range() {
    let mut rng = Rng(12);
    for _ in 0..40 {
        let world = World::random(&mut rng);
        let groups = world.groups();
        let mut items = groups.items().to_vec();
        items.sort_unstable();
        assert!(items.iter().copied().eq(0..world.bounds.len() as u32));
        for &[group, item] in &world.members {
            let place = groups.place(item).expect("it is there") as usize;
            assert_eq!(groups.items()[place], item);
            assert_eq!(groups.group_of(item), Some(group));
            assert!(groups.places(group).expect("it is there").contains(&place));
            let stored = Boxes::from_slice(&[world.bounds[item as usize]]).get(0);
            assert_eq!(groups.boxes().get(place), stored);
        }
        for (group, &parent) in world.parents.iter().enumerate() {
            let group = group as u32;
            let above = groups.parent(group);
            assert_eq!(above, Some(parent).filter(|&p| p != Groups::NONE));
            if let Some(above) = above {
                let (here, there) = (groups.places(group), groups.places(above));
                let (here, there) = (here.expect("a group"), there.expect("a group"));
                assert!(there.start <= here.start && here.end <= there.end);
            }
        }
        let grouped = world.members.len();
        assert_eq!(groups.validate().expect("good").ungrouped, world.bounds.len() - grouped);
    }
}

#[test]
fn what_moves_stays_held_and_a_refit_is_tight() {
    let mut rng = Rng(13);
    let mut cut = Cut::new();
    for _ in 0..25 {
        let mut world = World::random(&mut rng);
        let mut groups = world.groups();
        for round in 0..4 {
            for _ in 0..rng.below(60) {
                if world.bounds.is_empty() {
                    break;
                }
                let item = rng.below(world.bounds.len() as u64) as usize;
                world.bounds[item] = random_box(&mut rng);
                groups.set_bounds(item as u32, &world.bounds[item]).expect("it is there");
            }
            groups.validate().expect("groups grow with what is in them");
            check(&random_planes(&mut rng), &groups, &mut cut);
            if round % 2 == 0 {
                groups.refit();
            } else {
                groups.set_all(&world.bounds);
            }
            let fresh = world.groups();
            for group in 0..groups.len() as u32 {
                assert_eq!(groups.bounds(group), fresh.bounds(group), "group {group}");
            }
            check(&random_planes(&mut rng), &groups, &mut cut);
        }
    }
}

#[test]
fn given_boxes_are_used_and_those_that_do_not_hold_are_named() {
    let unit = |x: f32| Aabb::new([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
    let bounds = [unit(0.0), unit(2.0), unit(8.0)];
    // Group 0 has item 0 and group 1, which has item 1; item 2 is in none.
    let mut groups =
        Groups::build(&[Groups::NONE, 0], &[[1, 1], [0, 0]], &bounds).expect("good groups");
    let tight = groups.bounds(0);
    let wide = Aabb::new([-5.0; 3], [7.0; 3]);
    let leaves = |group, member| Err(GroupsError::Leaves { group, member });
    assert_eq!(groups.give_bounds(&[wide, unit(0.0)]), leaves(1, Member::Item(1)));
    assert_eq!(groups.give_bounds(&[unit(2.0), unit(2.0)]), leaves(0, Member::Item(0)));
    let first = Aabb::new([0.0; 3], [2.5, 1.0, 1.0]);
    assert_eq!(groups.give_bounds(&[first, unit(2.0)]), leaves(0, Member::Group(1)));
    assert_eq!(groups.bounds(0), tight, "what is refused changes nothing");
    assert_eq!(groups.give_bounds(&[wide]), Err(GroupsError::Count { given: 1, groups: 2 }));
    let message = leaves(0, Member::Group(1)).map(|()| 0).expect_err("an error").to_string();
    assert!(message.starts_with("group 1 leaves the box of group 0"), "{message}");

    groups.give_bounds(&[wide, unit(2.0)]).expect("they hold");
    assert_eq!(groups.bounds(0), Some(Boxes::from_slice(&[wide]).get(0)));
    let mut rng = Rng(14);
    let mut cut = Cut::new();
    for _ in 0..200 {
        check(&random_planes(&mut rng), &groups, &mut cut);
    }
    groups.fit();
    assert_eq!(groups.bounds(0), tight);
}

#[test]
fn a_group_that_is_outside_is_named_once_for_all_in_it() {
    // A street of houses at x = 0, 10, 20 ..., three rooms each, four things a room.
    let mut parents = Vec::new();
    let (mut members, mut bounds) = (Vec::new(), Vec::new());
    for house in 0..50u32 {
        let number = parents.len() as u32;
        parents.push(Groups::NONE);
        for room in 0..3 {
            let number_of_room = parents.len() as u32;
            parents.push(number);
            for thing in 0..4 {
                let x = (house * 10 + room * 2) as f32 + thing as f32 * 0.25;
                members.push([number_of_room, bounds.len() as u32]);
                bounds.push(Aabb::new([x, 0.0, 0.0], [x + 0.1, 1.0, 1.0]));
            }
        }
    }
    let groups = Groups::build(&parents, &members, &bounds).expect("good groups");
    let statistics = groups.validate().expect("just built");
    assert_eq!((statistics.groups, statistics.depth, statistics.widest), (200, 2, 4));
    // Everything with x ≤ 102.1: ten houses, one room of the eleventh, and a part of the next. A plane
    // that is pushed is number 6.
    let mut frustum = cullet::Frustum::everything();
    frustum.push(Plane::new([1.0, 0.0, 0.0], 102.1)).expect("one plane");
    let planes = Planes::new(&frustum);
    let (mut cut, mut fates) = (Cut::new(), Vec::new());
    explain_groups(Level::new(), &planes, &groups, &mut cut, &mut fates);
    let fate = |item: u32| fates[groups.place(item).expect("it is there") as usize];
    assert_eq!(cut.count(), 120 + 4 + 1);
    assert_eq!(fate(123), Fate::Visible);
    assert_eq!(fate(125), Fate::Alone { plane: 6 });
    assert_eq!(fate(128), Fate::WithGroup { group: 43, plane: 6 }, "the third room of house 10");
    assert_eq!(fate(132), Fate::WithGroup { group: 44, plane: 6 }, "house 11");
    cull_groups(Level::new(), &planes, &groups, &mut cut);
    assert_eq!(cut.count(), 125);
    assert_eq!(cut.swept(), 0);
    // Fifty houses in four blocks, and the one that straddles asks its things.
    assert!(cut.nodes_asked() <= 5 && cut.leaves_asked() <= 2, "{cut:?}");
}

#[test]
fn wrong_groups_are_refused_with_their_numbers() {
    const NONE: u32 = Groups::NONE;
    let b = [Aabb::new([0.0; 3], [1.0; 3]); 3];
    let build = |parents: &[u32], members: &[[u32; 2]]| Groups::build(parents, members, &b).err();
    assert_eq!(build(&[], &[]), None);
    assert_eq!(build(&[NONE, 0], &[[0, 2], [1, 0]]), None);
    let no_parent = GroupsError::NoParent { group: 1, parent: 7, groups: 2 };
    assert_eq!(build(&[NONE, 7], &[]), Some(no_parent));
    let no_group = GroupsError::NoGroup { item: 2, group: 1, groups: 1 };
    assert_eq!(build(&[NONE], &[[0, 0], [1, 2]]), Some(no_group));
    let no_item = GroupsError::NoItem { group: 0, item: 3, items: 3 };
    assert_eq!(build(&[NONE], &[[0, 3]]), Some(no_item));
    let twice = GroupsError::Twice { item: 1, first: 0, second: 1 };
    assert_eq!(build(&[NONE, 0], &[[0, 1], [1, 1]]), Some(twice));
    assert_eq!(build(&[0], &[]), Some(GroupsError::Cycle { group: 0 }));
    // 1 hangs on the circle of 2, 3 and 4, but is not of it.
    let circle = build(&[NONE, 2, 3, 4, 2], &[]);
    assert!(matches!(circle, Some(GroupsError::Cycle { group: 2..=4 })), "{circle:?}");
    let mut groups = Groups::build(&[NONE], &[[0, 1]], &b).expect("good groups");
    let no_item = GroupsError::NoItem { group: NONE, item: 3, items: 3 };
    assert_eq!(groups.set_bounds(3, &b[0]), Err(no_item));
    assert_eq!((groups.place(3), groups.places(1), groups.bounds(1)), (None, None, None));
    assert_eq!((groups.group_of(0), groups.group_of(1)), (None, Some(0)));
}

#[test]
fn a_chain_of_a_million_groups_is_no_trouble() {
    const LEN: u32 = 1_000_000;
    let parents: Vec<u32> = (0..LEN).map(|g| g.checked_sub(1).unwrap_or(Groups::NONE)).collect();
    let b = [Aabb::new([0.0; 3], [1.0; 3]), Aabb::new([5.0; 3], [6.0; 3])];
    let mut groups = Groups::build(&parents, &[[LEN - 1, 0], [0, 1]], &b).expect("good groups");
    assert_eq!(groups.validate().expect("good").depth, LEN as usize);
    groups.set_bounds(0, &Aabb::new([-9.0; 3], [-8.0; 3])).expect("it is there");
    groups.refit();
    assert_eq!(groups.bounds(1), groups.bounds(LEN - 1));
    check(&Planes::new(&common::looking_down_z().frustum()), &groups, &mut Cut::new());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(48)))]

    /// Whatever parents and members say, it is built or refused, and what is built is right.
    #[test]
    fn any_numbers_are_built_or_refused(
        parents in prop::collection::vec(prop_oneof![3 => 0u32..14, 1 => Just(Groups::NONE)], 0..12),
        members in prop::collection::vec([0u32..13, 0u32..40], 0..30),
        seed: u64,
    ) {
        let mut rng = Rng(seed);
        let bounds: Vec<_> = (0..36).map(|_| random_box(&mut rng)).collect();
        // Mostly good: later things twice are left out.
        let mut seen = std::collections::BTreeSet::new();
        let members: Vec<_> = members.into_iter().filter(|m| seen.insert(m[1])).collect();
        if let Ok(groups) = Groups::build(&parents, &members, &bounds) {
            groups.validate().expect("just built");
            check(&random_planes(&mut rng), &groups, &mut Cut::new());
        }
    }
}
