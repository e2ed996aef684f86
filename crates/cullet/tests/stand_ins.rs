//! Instances that stand for others: who is drawn in whose place.

use cullet::lod::{LevelEye, Levels, Lod, PixelScale};
use cullet::{
    Culler, Handle, Instance, InstanceFlags, MeshId, Output, Scene, SceneError, Stage, Transform,
    View, ViewState, Visible, scene::BoundsOverride,
};
use cullet_testkit::answers::cull;
use cullet_testkit::memory::{Counting, allocations_of};
use cullet_testkit::steps::Balls;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, cases};
use proptest::prelude::*;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Balls in clumps, clumps in clumps, and who stands for whom.
struct Clumps {
    scene: Scene,
    /// Ordinary instances.
    balls: Vec<Handle>,
    /// Who stands for others, from below to above, and for whom.
    stands: Vec<(Handle, Vec<Handle>)>,
}

impl Clumps {
    fn random(rng: &mut Rng) -> Self {
        let mut scene = Scene::new();
        let kinds: [MeshId; 2] =
            [&[12, 6, 3][..], &[9, 4]].map(|rings| Balls::new(rings, 1.0).add_to(&mut scene));
        let plain = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
        // What stands for others states errors of its own; here it looks like nothing they are.
        let stand_ins: [MeshId; 3] = [&[5, 4, 3][..], &[12, 8], &[30, 5, 2]]
            .map(|rings| Balls::new(rings, rng.range(0.05, 0.5)).add_to(&mut scene));
        let mut row: Vec<(Handle, [f64; 3])> = Vec::new();
        let mut balls = Vec::new();
        for at in 0..rng.below(60) {
            let place = [at as f64 * 2.0, rng.range(-3.0, 3.0), rng.range(-3.0, 3.0)];
            let mesh = [kinds[0], kinds[1], plain][rng.index(3)];
            let mut instance = Instance::new(mesh, Transform::from_translation(place));
            instance.flags.always_visible = rng.below(20) == 0;
            let handle = scene.add(instance).unwrap();
            balls.push(handle);
            if !instance.flags.always_visible && rng.below(8) > 0 {
                row.push((handle, place));
            }
        }
        let mut stands = Vec::new();
        for _ in 0..3 {
            let mut above = Vec::new();
            let mut rest = &row[..];
            while !rest.is_empty() {
                let (own, others) = rest.split_at(rest.len().min(1 + rng.index(5)));
                rest = others;
                if rng.below(6) == 0 {
                    continue;
                }
                let middle = own[own.len() / 2].1;
                let size = 2.0 + own.len() as f32;
                let transform = Transform::from_scale_translation([size; 3], middle);
                let mesh = stand_ins[rng.index(3)];
                let handle = scene.add(Instance::new(mesh, transform)).unwrap();
                let members: Vec<Handle> = own.iter().map(|o| o.0).collect();
                scene.stand_for(handle, &members).unwrap();
                stands.push((handle, members));
                above.push((handle, middle));
            }
            row = above;
        }
        Self { scene, balls, stands }
    }

    /// How many triangles are drawn, and who is, by the rule alone.
    fn drawn_ref(&self, view: &View, lod: &Lod) -> (u64, Vec<u32>) {
        let mut found: Vec<(u64, Vec<u32>)> = Vec::new();
        let of = |handle: Handle, found: &[(u64, Vec<u32>)]| match self
            .stands
            .iter()
            .position(|s| s.0 == handle)
        {
            Some(at) => found[at].clone(),
            None => {
                let slot = self.scene.slot(handle).unwrap();
                let whole = u64::from(self.scene.mesh(slot).triangle_count());
                let is_exempt = self.scene.flags(slot).always_visible;
                let clusters = self.scene.mesh(slot).clusters().len();
                let own = self.cut(slot, clusters, view, lod).filter(|_| !is_exempt);
                (own.map_or(whole, |own| own.min(whole)), vec![slot])
            }
        };
        for (handle, members) in &self.stands {
            let each: Vec<_> = members.iter().map(|&m| of(m, &found)).collect();
            let below = each.iter().map(|e| e.0).sum();
            let slot = self.scene.slot(*handle).unwrap();
            // A cut of more clusters than what it replaces is not drawn.
            let members = self.scene.stood_for_by(slot);
            let clusters = members.iter().map(|&s| self.scene.mesh(s).clusters().len()).sum();
            let own = self.cut(slot, clusters, view, lod);
            let own = own.filter(|_| !self.scene.is_stand_in_off(slot));
            found.push(match own {
                Some(own) if own <= below => (own, vec![slot]),
                _ => (below, each.into_iter().flat_map(|e| e.1).collect()),
            });
        }
        let below: Vec<Handle> = self.stands.iter().flat_map(|s| s.1.clone()).collect();
        let top = self.balls.iter().chain(self.stands.iter().map(|s| &s.0));
        let top = top.filter(|h| !below.contains(h)).map(|&h| of(h, &found));
        let (mut triangles, mut slots) = (0, Vec::new());
        top.for_each(|(n, own)| {
            triangles += n;
            slots.extend(own);
        });
        slots.sort_unstable();
        (triangles, slots)
    }

    /// The fewest triangles of a slot's levels, where any are within the threshold in no more clusters than `most`.
    fn cut(&self, slot: u32, most: usize, view: &View, lod: &Lod) -> Option<u64> {
        let scale = PixelScale::of(view, lod.at_corners);
        let eye = LevelEye::new(lod, &scale, self.scene.transform(slot), view.eyes);
        let levels = self.scene.levels(self.scene.mesh_id(slot)).iter();
        let of = |levels: &Levels, mesh: MeshId| {
            let is_there = (0..levels.group_count()).all(|g| {
                levels.replaced_by().contains(&(g as u32)) || !eye.is_over(&levels.group(g))
            });
            let chosen = levels.select_where(|group| eye.is_over(group)).into_iter();
            let clusters = self.scene.meshes()[mesh as usize].clusters();
            let chosen: Vec<_> = chosen.zip(clusters).filter(|c| c.0).map(|c| c.1).collect();
            let triangles = chosen.iter().map(|c| u64::from(c.triangle_count)).sum();
            (is_there && chosen.len() <= most).then_some(triangles)
        };
        levels.filter_map(|l| of(&l.levels, l.mesh)).min()
    }
}

fn random_look(rng: &mut Rng) -> View {
    let far = 10_f64.powf(rng.range(0.5, 3.5));
    look([60.0, 5.0, far], [rng.range(20.0, 100.0), 0.0, 0.0], [640, 400])
}

fn with_lod(rng: &mut Rng) -> Culler {
    let lod = Lod::default().with_pixels(10_f64.powf(rng.range(-0.5, 1.5)));
    Culler::default().with_lod(lod).with_reasons(true)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(60), ..ProptestConfig::default() })]

    #[test]
    fn the_fewest_triangles_are_drawn_of_each_instance_once(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let mut clumps = Clumps::random(&mut rng);
        if rng.below(2) == 0 {
            clumps.scene.commit(&Culler::default());
        }
        for _ in 0..6 {
            let view = random_look(&mut rng);
            let culler = with_lod(&mut rng);
            let (triangles, slots) = clumps.drawn_ref(&view, &culler.lod.unwrap());
            for output in [Output::Instances, Output::Clusters, Output::Triangles] {
                let only = culler.clone().with_output(output).only(Stage::Lod);
                let result = cull(&only, &clumps.scene, &view);
                prop_assert_eq!(result.triangle_count, triangles);
                prop_assert_eq!(&result.slots().collect::<Vec<_>>(), &slots, "{:?}", output);
                prop_assert_eq!(result.instance_count as usize, slots.len());
                for slot in 0..clumps.scene.slot_count() {
                    let is_drawn = slots.binary_search(&slot).is_ok();
                    prop_assert_eq!(result.reasons[slot as usize].is_none(), is_drawn);
                }
                let last = result.funnel.rows.last().unwrap();
                prop_assert_eq!(last.left.triangles, triangles);
            }
            // Of what is in view, nobody stands for anybody where everything below was dropped.
            let part = cull(&culler, &clumps.scene, &view);
            for slot in part.slots().filter(|&s| clumps.scene.is_stand_in(s)) {
                let below = clumps.scene.stood_for_by(slot);
                prop_assert!(below.iter().any(|&s| part.reasons[s as usize].is_some_and(|r| r.stage == Stage::Lod)));
                prop_assert!(!below.iter().any(|&s| part.reasons[s as usize].is_none()));
            }
        }
    }

    #[test]
    fn without_levels_nobody_stands_for_anybody(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let mut clumps = Clumps::random(&mut rng);
        let all: u64 = clumps.scene.slots().map(|s| u64::from(clumps.scene.mesh(s).triangle_count())).sum();
        prop_assert_eq!(clumps.scene.triangle_count(), all);
        prop_assert_eq!(clumps.scene.instance_count() as usize, clumps.balls.len());
        let view = random_look(&mut rng);
        let drawn = |scene: &Scene, culler: &Culler| {
            cull(culler, scene, &view).slots().map(|s| scene.handle(s).unwrap()).collect::<std::collections::HashSet<_>>()
        };
        for culler in [Culler::default(), Culler::exact(), Culler::default().without(Stage::Frustum)] {
            let culler = culler.with_reasons(true);
            let before = drawn(&clumps.scene, &culler);
            prop_assert!(before.iter().all(|h| clumps.balls.contains(h)));
            let mut without = Clumps::random(&mut Rng(seed));
            without.scene.clear_stand_ins();
            prop_assert_eq!(&drawn(&without.scene, &culler), &before);
        }
        clumps.scene.rebase([3.0, 1e3, -7.0]);
        prop_assert!(clumps.stands.iter().all(|(h, _)| !clumps.scene.is_stand_in_off(clumps.scene.slot(*h).unwrap())));
    }

    #[test]
    fn what_changes_is_drawn_as_itself_at_once(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let mut clumps = Clumps::random(&mut rng);
        let Some((_, members)) = clumps.stands.first().cloned() else { return Ok(()) };
        let changed = members[rng.index(members.len())];
        let scene = &mut clumps.scene;
        let slot = scene.slot(changed).unwrap();
        match rng.below(6) {
            0 => scene.set_transform(changed, Transform::from_translation([0.0, 9.0, 0.0])).unwrap(),
            1 => scene.set_layers(changed, 3).unwrap(),
            2 => scene.set_flags(changed, InstanceFlags { always_visible: true, ..InstanceFlags::default() }).unwrap(),
            3 => scene.set_bounds(changed, BoundsOverride::Margin(1.0)).unwrap(),
            4 => {
                let bounds = scene.bounds(slot);
                scene.write_bounds(|writer| writer.set(slot, &bounds));
            }
            _ => {
                scene.edit_mesh(scene.mesh_id(slot), |mesh| {
                    let again = mesh.to_data();
                    *mesh = cullet::Mesh::new(again).unwrap();
                });
            }
        }
        if rng.below(2) == 0 {
            scene.commit_slice();
            scene.sort();
        }
        let mut above = scene.stand_in_of(scene.slot(changed).unwrap());
        prop_assert!(above.is_some());
        while let Some(slot) = above {
            prop_assert!(scene.is_stand_in_off(slot));
            above = scene.stand_in_of(slot);
        }
        let scene = &clumps.scene;
        for _ in 0..4 {
            let view = random_look(&mut rng);
            let culler = with_lod(&mut rng).only(Stage::Lod);
            let result = cull(&culler, scene, &view);
            let slot = scene.slot(changed).unwrap();
            prop_assert!(result.slots().any(|s| s == slot));
            prop_assert!(result.slots().all(|s| !scene.is_stand_in_off(s)));
        }
        let before = clumps.scene.instance_count();
        clumps.scene.remove(changed).unwrap();
        prop_assert_eq!(clumps.scene.instance_count(), before - 1);
        clumps.scene.commit(&Culler::default());
    }

    #[test]
    fn a_budget_is_kept_where_it_can_be(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let clumps = Clumps::random(&mut rng);
        let view = random_look(&mut rng);
        let with = |pixels: f64, triangles| {
            let lod = Some(Lod::default().with_pixels(pixels).with_triangles(triangles));
            cull(&Culler::default().with_lod(lod).only(Stage::Lod), &clumps.scene, &view)
        };
        let [all, fewest] = [0.125, 1e9].map(|pixels| with(pixels, None).triangle_count);
        for budget in [all, fewest, fewest + (all - fewest) / 3] {
            let result = with(1.0, Some(budget));
            prop_assert!(result.triangle_count <= budget || result.lod_pixels.unwrap() > 5e4, "{} of {budget}", result.triangle_count);
            let lod = Lod::default().with_pixels(result.lod_pixels.unwrap());
            prop_assert_eq!(result.triangle_count, clumps.drawn_ref(&view, &lod).0);
        }
    }

    #[test]
    fn an_explanation_gives_the_reason_of_the_cull(seed in any::<u64>()) {
        let mut rng = Rng(seed);
        let clumps = Clumps::random(&mut rng);
        let view = random_look(&mut rng);
        let culler = with_lod(&mut rng);
        let result = cull(&culler, &clumps.scene, &view);
        for slot in 0..clumps.scene.slot_count() {
            let handle = clumps.scene.handle(slot).unwrap();
            let told = culler.explain(&clumps.scene, &view, handle).unwrap();
            prop_assert_eq!(told.reason, result.reasons[slot as usize], "{}", slot);
            if told.reason.is_some_and(|r| r.stage == Stage::Lod) {
                let last = told.steps.last().unwrap();
                prop_assert!(last.to_string().contains("is drawn in its place"), "{last}");
            }
        }
    }
}

#[test]
fn who_cannot_stand_for_others_is_told() {
    let mut scene = Scene::new();
    let ball = Balls::new(&[8, 4], 1.0).add_to(&mut scene);
    let plain = scene.add_mesh(cullet_testkit::meshes::block([-1.0; 3], [1.0; 3]));
    let mut add = |mesh, always_visible| {
        let mut instance = Instance::new(mesh, Transform::IDENTITY);
        instance.flags.always_visible = always_visible;
        scene.add(instance).unwrap()
    };
    let [a, b, c] = [0; 3].map(|_| add(plain, false));
    let always = add(plain, true);
    let [s, t] = [0; 2].map(|_| add(ball, false));
    let gone = add(ball, false);
    scene.remove(gone).unwrap();
    assert_eq!(scene.stand_for(a, &[b]), Err(SceneError::NoLevels(a)));
    assert_eq!(scene.stand_for(s, &[a, always]), Err(SceneError::NotRigid(always)));
    assert_eq!(scene.stand_for(s, &[a, s]), Err(SceneError::Taken(s)));
    assert_eq!(scene.stand_for(s, &[a, a]), Err(SceneError::Taken(a)));
    assert!(matches!(scene.stand_for(s, &[gone]), Err(SceneError::NoInstance(_))));
    assert!(matches!(scene.stand_for(gone, &[a]), Err(SceneError::NoInstance(_))));
    assert_eq!(scene.stand_in_slots().count(), 0);
    scene.stand_for(s, &[a, b]).unwrap();
    assert_eq!(scene.stand_for(s, &[c]), Err(SceneError::Taken(s)));
    assert_eq!(scene.stand_for(t, &[b]), Err(SceneError::Taken(b)));
    assert_eq!(scene.stand_for(t, &[s, s]), Err(SceneError::Taken(s)));
    scene.stand_for(t, &[s, c]).unwrap();
    let slots = [a, b, c, s, t].map(|h| scene.slot(h).unwrap());
    assert_eq!(scene.stood_for_by(slots[4]), slots[..3]);
    assert_eq!(scene.stood_for_by(slots[3]), slots[..2]);
    assert_eq!([3, 4].map(|k| scene.layers(slots[k])), [0, 0]);
    scene.clear_stand_ins();
    assert_eq!(scene.instance_count(), 4);
}

#[test]
fn standing_for_others_allocates_nothing_in_steady_state() {
    let mut rng = Rng(11);
    let mut clumps = Clumps::random(&mut rng);
    while clumps.stands.len() < 6 {
        clumps = Clumps::random(&mut rng);
    }
    let views: Vec<View> = (0..12).map(|_| random_look(&mut rng)).collect();
    for triangles in [None, Some(500)] {
        let lod = Some(Lod::default().with_pixels(3.0).with_triangles(triangles));
        let culler = Culler::default().with_lod(lod);
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let mut all = || {
            views
                .iter()
                .for_each(|view| culler.cull_one(&clumps.scene, view, &mut state, &mut result));
        };
        all();
        let ((), allocations) = allocations_of(all);
        assert_eq!(allocations, 0, "{triangles:?}");
    }
}

/// Ends at once only where a look-up of a stand-in by its slot takes no walk over all of them.
#[test]
fn stand_ins_of_a_large_tree_are_found_by_their_slots() {
    const LEVELS: u32 = 16;
    let mut scene = Scene::new();
    let ball = Balls::new(&[9, 4], 0.2).add_to(&mut scene);
    let add = |scene: &mut Scene, k: usize| {
        let place = [(k % 512) as f64 * 3.0, (k / 512) as f64 * 3.0, k as f64 % 7.0];
        scene.add(Instance::new(ball, Transform::from_translation(place))).unwrap()
    };
    let mut row: Vec<Handle> = (0..1 << LEVELS).map(|k| add(&mut scene, k)).collect();
    let members = row.clone();
    let mut stand_ins = Vec::new();
    while row.len() > 1 {
        row = (row.chunks(2).enumerate())
            .map(|(k, pair)| {
                let stand_in = add(&mut scene, k * 65536 / row.len());
                scene.stand_for(stand_in, pair).unwrap();
                stand_in
            })
            .collect();
        stand_ins.extend_from_slice(&row);
    }
    scene.commit(&Culler::default());
    (0..40).for_each(|_| drop(scene.commit_slice()));
    let off = |scene: &Scene| {
        let slots = stand_ins.iter().map(|&handle| scene.slot(handle).unwrap());
        slots.filter(|&slot| scene.is_stand_in_off(slot)).count()
    };
    assert_eq!(off(&scene), 0);
    let refused = scene.set_layers(stand_ins[0], 3);
    assert_eq!(refused, Err(SceneError::StandIn(stand_ins[0])));
    let far = Transform::from_translation([0.0, -50.0, 0.0]);
    scene.set_transform(members[12345], far).unwrap();
    assert_eq!(off(&scene), LEVELS as usize);
    scene.commit(&Culler::default());
    for &member in &members {
        let mut slot = scene.slot(member).unwrap();
        let mut levels = 0;
        while let Some(above) = scene.stand_in_of(slot) {
            (slot, levels) = (above, levels + 1);
        }
        assert_eq!(levels, LEVELS);
        scene.set_transform(member, far).unwrap();
    }
    assert_eq!(off(&scene), stand_ins.len());
}
