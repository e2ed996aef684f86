//! Lists of instances: never without one that the engine keeps, hardly longer, and the same from any device.

use crate::common;

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use cullet::bounds::{Aabb, Plane, Side};
use cullet::{
    Camera, Culler, Depth, Instance, Projection, Scene, Stage, Transform, View, ViewState, Visible,
};
use cullet_gpu::{
    BLOCK, BlockPlanes, Blocks, DrawArguments, Gpu, GpuError, Grid, GridBox, GridPlane,
    InstanceBits, LaneBuffers, Lanes, ListSource, Listed, Passes, SlotList, Tier, visible_ref,
};
use cullet_testkit::Rng;
use cullet_testkit::meshes::block;
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::random_view;

use common::gpu;

/// A number of any size, not finite at times.
fn any(rng: &mut Rng) -> f32 {
    match rng.below(12) {
        0 => 0.0,
        1 => rng.signed() as f32 * 1e30,
        2 => rng.signed() as f32 * 1e-38,
        3 => rng.signed() as f32 * 1e7,
        _ => rng.signed() as f32 * 10.0,
    }
}

fn any_box(rng: &mut Rng) -> Aabb {
    let [a, b]: [[f32; 3]; 2] = [0, 1].map(|_| [0, 1, 2].map(|_| any(rng)));
    let around = Aabb::from_points(&[a, b]);
    match rng.below(20) {
        0 => Aabb::EMPTY,
        1 => Aabb::new([f32::NAN; 3], around.max),
        2 => Aabb::new([f32::NEG_INFINITY; 3], around.max),
        _ => around,
    }
}

#[test]
fn steps_hold_the_box_and_what_a_plane_rejects_is_outside() {
    let mut rng = Rng(1);
    let (mut rejected, mut outside) = (0, 0);
    for _ in 0..200_000 {
        let boxes = [any_box(&mut rng), any_box(&mut rng)];
        let around = boxes.iter().filter(|b| b.is_finite()).fold(Aabb::EMPTY, |u, b| u.union(b));
        let grid = Grid::around(&around);
        let plane = Plane::new(rng.direction(), f64::from(any(&mut rng)));
        let on_grid = GridPlane::new(&plane, &grid);
        for bounds in boxes {
            let steps = grid.round_out(&bounds).expect("the grid was made around it");
            if bounds.is_empty() {
                assert_eq!(steps, GridBox::default());
                continue;
            }
            assert_eq!(steps.layers, u32::MAX, "{bounds:?}");
            if steps.is_always() {
                assert!(!bounds.is_finite(), "{bounds:?}");
                continue;
            }
            let [low, high] = grid.to_box(&steps);
            for a in 0..3 {
                assert!(low[a] <= f64::from(bounds.min[a]), "{bounds:?} {steps:?} {grid:?}");
                assert!(high[a] >= f64::from(bounds.max[a]), "{bounds:?} {steps:?} {grid:?}");
            }
            let is_outside = bounds.side(&plane) == Side::Outside;
            outside += u32::from(is_outside);
            if on_grid.rejects(&steps) {
                rejected += 1;
                assert!(bounds.span(&plane)[1] > 0.0 && is_outside, "{bounds:?} {plane:?}");
            }
        }
    }
    // Of two boxes of which one is 1e30 times as large, the other is far smaller than the grid's steps.
    assert!(outside > 50_000 && rejected * 3 > outside, "{rejected} of {outside}");
}

#[test]
fn a_plane_that_is_not_finite_and_a_block_without_room_reject_nothing() {
    let grid = Grid { origin: [1e300, 0.0, 0.0], step: 1e-300 };
    let all = GridBox { low: [-32767; 3], high: [32767; 3], layers: 1 };
    let planes = [
        Plane::new([f64::NAN, 0.0, 0.0], 0.0),
        Plane::new([0.0; 3], -1.0),
        Plane::new([1.0, 0.0, 0.0], f64::INFINITY),
    ];
    for plane in planes {
        assert!(!GridPlane::new(&plane, &grid).rejects(&all), "{plane:?}");
    }
    let unit = Grid { origin: [0.0; 3], step: 1.0 };
    assert!(unit.round_out(&Aabb::new([0.0; 3], [32768.0, 1.0, 1.0])).is_none());
    // Beyond 32 bits a plane decides by itself.
    let far = |d: f64| GridPlane::new(&Plane::new([1.0, 0.0, 0.0], d), &unit);
    assert!(far(-1e12).rejects(&all) && !far(1e12).rejects(&all));
}

/// Planes of a view, in the space of the scene's boxes.
fn planes_of(view: &View, scene: &Scene) -> Vec<Plane> {
    view.frustum().relative_to(scene.origin()).planes().map(|(_, plane)| *plane).collect()
}

fn words(bytes: Vec<u8>) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Lister of all slots of a scene.
struct OnDevice {
    passes: Passes,
    bits: InstanceBits,
    list: SlotList,
}

impl OnDevice {
    fn new(gpu: &Gpu, blocks: &Blocks) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let passes = Passes::without_occlusion(device).unwrap();
        let bits = InstanceBits::new(device, queue, &passes.instances, blocks, 6).unwrap();
        let lanes = Lanes::by_slot(blocks.slot_count());
        let lanes = LaneBuffers::new(device, queue, &lanes).unwrap();
        let source = ListSource { bits: bits.bits(), seen: bits.bits(), listed: Listed::All };
        let draws = [(0, DrawArguments::default())];
        let list = SlotList::new(device, queue, &passes.lists, &lanes, &draws, source).unwrap();
        Self { passes, bits, list }
    }

    /// The list of a view.
    fn list(&mut self, gpu: &Gpu, planes: &BlockPlanes) -> Vec<u32> {
        self.bits.set(&gpu.queue, planes).unwrap();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.passes.instances.record(&mut encoder, &self.bits, planes);
        self.passes.lists.record(&mut encoder, &self.list);
        gpu.queue.submit([encoder.finish()]);
        let count = words(gpu.read(self.list.arguments(), 20).unwrap())[1];
        words(gpu.read(self.list.list(), u64::from(count) * 4).unwrap())
    }
}

/// Returns the slots that the engine's frustum stage keeps.
fn kept(scene: &Scene, view: &View) -> Vec<u32> {
    let mut visible = Visible::default();
    let culler = Culler::default().only(Stage::Frustum);
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    let mut slots: Vec<u32> =
        visible.whole.iter().flat_map(|r| r.first..r.first + r.count).collect();
    slots.extend(visible.partial.iter().map(|r| r.slot));
    slots.sort_unstable();
    slots.dedup();
    slots
}

#[test]
fn lists_hold_what_the_engine_keeps_and_devices_agree_to_the_byte() {
    let gpu = gpu(Tier::Compute);
    let mut rng = Rng(2);
    let (mut listed, mut expected) = (0, 0);
    for instances in [0, 1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 700, 5000, 20_000] {
        let mut scene = random_scene(&mut rng, instances);
        scene.commit(&Culler::default());
        let blocks = Blocks::new(&scene);
        assert_eq!(blocks.slot_count(), scene.slot_count());
        let mut on_device = gpu.map(|gpu| OnDevice::new(gpu, &blocks));
        for _ in 0..12 {
            let view = random_view(&mut rng);
            let mut planes = BlockPlanes::default();
            planes.set(&blocks, &planes_of(&view, &scene), view.layers);
            let list = visible_ref(&blocks, &planes);
            assert!(list.is_sorted_by(|a, b| a < b));
            let engine = kept(&scene, &view);
            let missing = engine.iter().filter(|slot| list.binary_search(slot).is_err()).count();
            assert_eq!(missing, 0, "{instances} instances, {view:?}");
            listed += list.len();
            // The engine looks at clusters too; boxes alone say this much.
            let all = planes_of(&view, &scene);
            let keeps = |&slot: &u32| {
                scene.layers(slot) & view.layers != 0
                    && all.iter().all(|p| scene.bounds(slot).side(p) != Side::Outside)
            };
            expected += scene.slots().filter(keeps).count();
            if let (Some(gpu), Some(on_device)) = (gpu, &mut on_device) {
                assert!(on_device.list(gpu, &planes) == list, "{instances} instances");
            }
        }
    }
    assert!(
        listed > 1000 && listed * 100 <= expected * 102,
        "{listed} listed, {expected} by their boxes"
    );
}

/// Boxes side by side, in rows.
fn rows(instances: u32) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(block([-0.4; 3], [0.4; 3]));
    for i in 0..instances {
        let at = [f64::from(i % 512), f64::from(i / 512), -20.0];
        scene.add(Instance::new(mesh, Transform::from_translation(at))).unwrap();
    }
    scene.commit(&Culler::default());
    scene
}

fn view_at(eye: [f64; 3]) -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: f64::INFINITY };
    let target = [eye[0] + 3.0, eye[1] + 2.0, -20.0];
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, [640, 400]).unwrap()
}

#[test]
fn what_moves_is_uploaded_and_nothing_else() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let mut scene = rows(40 * BLOCK as u32);
    let mut blocks = Blocks::new(&scene);
    let mut on_device = OnDevice::new(gpu, &blocks);
    assert_eq!(on_device.bits.uploaded(), 40 * BLOCK as u64 * 16);
    blocks.update(&scene);
    assert!(blocks.changed().is_empty());
    // Two instances move a little.
    for slot in [700, 5000] {
        let mut t = *scene.transform(slot);
        t.translation[0] += 0.25;
        scene.set_transform(scene.handle(slot).unwrap(), t).unwrap();
    }
    scene.commit(&Culler::default());
    blocks.update(&scene);
    assert!(!blocks.changed().is_empty() && blocks.changed().len() <= 4, "{:?}", blocks.changed());
    assert!(on_device.bits.update(&gpu.queue, &blocks));
    assert_eq!(on_device.bits.uploaded(), blocks.changed().len() as u64 * BLOCK as u64 * 16);
    let mut planes = BlockPlanes::default();
    for eye in [[0.0, 0.0, 0.0], [300.0, 5.0, -15.0], [1e5, 0.0, 0.0]] {
        planes.set(&blocks, &planes_of(&view_at(eye), &scene), u32::MAX);
        assert!(on_device.list(gpu, &planes) == visible_ref(&blocks, &planes));
    }
    assert!(!on_device.bits.update(&gpu.queue, &Blocks::new(&rows(3))), "another scene");
}

#[test]
fn more_blocks_than_one_row_of_workgroups_has_room_for() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    // 32,769 blocks of which most are nearly empty would take an hour to add one by one; so many instances do not.
    let scene = rows(300 * BLOCK as u32);
    let blocks = Blocks::new(&scene);
    let mut on_device = OnDevice::new(gpu, &blocks);
    let mut planes = BlockPlanes::default();
    planes.set(&blocks, &[], u32::MAX);
    assert_eq!(planes.in_use().len(), 300);
    let all = on_device.list(gpu, &planes);
    assert!(all == (0..300 * BLOCK as u32).collect::<Vec<_>>());
    let none = Plane::new([0.0, 0.0, 1.0], -100.0);
    planes.set(&blocks, &[none], u32::MAX);
    assert!(planes.in_use().is_empty());
    assert!(on_device.list(gpu, &planes).is_empty());
}

#[test]
fn what_is_too_large_for_the_device_is_said_in_numbers() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let pass = Passes::without_occlusion(&gpu.device).unwrap().instances;
    let scene = rows(600);
    let blocks = Blocks::new(&scene);
    let with = |most| InstanceBits::new(&gpu.device, &gpu.queue, &pass, &blocks, most);
    let told = with(usize::MAX / 1024).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("planes of blocks") && told.contains("at most"), "{told}");
    let mut bits = with(1).unwrap();
    let mut planes = BlockPlanes::default();
    planes.set(&blocks, &planes_of(&view_at([0.0, 0.0, -19.9]), &scene), u32::MAX);
    let many = planes.in_use().iter().map(|b| b.plane_count).sum::<u32>();
    assert!(many as usize > blocks.grids().len(), "{many}");
    assert!(matches!(bits.set(&gpu.queue, &planes), Err(GpuError::TooLarge { .. })));
}

/// Small boxes of so many instances, each block of them somewhere else.
fn many(instances: u32) -> Blocks {
    let mut blocks = Blocks::default();
    blocks.follow(instances, |slot| {
        let block = slot / BLOCK as u32;
        let at = [slot % 16, slot / 16 % 16, 0].map(|v| v as f32);
        let of_block = [block % 64, block / 64 % 64, block / 4096].map(|v| v as f32 * 20.0);
        let low = [0, 1, 2].map(|a| of_block[a] + at[a]);
        (Aabb::new(low, low.map(|v| v + 0.5)), 1 << (slot % 3), 1.0)
    });
    blocks
}

/// One more than 65,536 blocks have.
const MOST: u32 = (1 << 24) + 1;

#[test]
fn as_many_instances_as_a_device_has_room_for() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let limits = gpu.device.limits();
    let room = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
    let boxes = u32::try_from(room / 16).unwrap_or(u32::MAX) / BLOCK as u32 * BLOCK as u32;
    let count = MOST.min(boxes);
    if count < MOST {
        println!("{count} instances in place of {MOST}: a binding has {room} bytes here");
    }
    let blocks = many(count);
    let mut on_device = OnDevice::new(gpu, &blocks);
    let plane = |a: usize, sign: f64, d: f64| {
        let mut normal = [0.0; 3];
        normal[a] = sign;
        Plane::new(normal, d)
    };
    // A slab that has some of every row of blocks, and of its blocks a part.
    let slab = [plane(0, 1.0, 707.7), plane(1, -1.0, -503.3)];
    let mut planes = BlockPlanes::default();
    planes.set(&blocks, &slab, 5);
    let found = on_device.list(gpu, &planes);
    assert!(found.len() > count as usize / 8 && found.len() < count as usize);
    assert!(found == visible_ref(&blocks, &planes));
    planes.set(&blocks, &[], u32::MAX);
    assert!(on_device.list(gpu, &planes) == (0..count).collect::<Vec<_>>());
}

#[test]
fn one_instance_too_many_is_said_in_numbers() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    // With the limits that every adapter has, a browser's too.
    let wanted = wgpu::DeviceDescriptor::default();
    let opened =
        pin!(gpu.adapter.request_device(&wanted)).poll(&mut Context::from_waker(Waker::noop()));
    let Poll::Ready(Ok((device, queue))) = opened else { panic!("{opened:?}") };
    let pass = Passes::without_occlusion(&device).unwrap().instances;
    let told = InstanceBits::new(&device, &queue, &pass, &many(MOST), 6).map(|_| ()).unwrap_err();
    let GpuError::TooLarge { what, bytes, limit } = told else { panic!("{told}") };
    let expected = (u64::from(MOST).next_multiple_of(256) * 16, 128 << 20);
    assert_eq!((what, (bytes, limit)), ("boxes of instances", expected));
    let told = told.to_string();
    for part in ["268439552 bytes", "134217728", "max_storage_buffer_binding_size", "CPU"] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn lists_of_more_groups_than_a_row_of_workgroups_has_room_for() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let (device, queue) = (&gpu.device, &gpu.queue);
    let limits = device.limits();
    let room = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size) / 8;
    // Two rows of 32,768 groups of 256.
    let count = (MOST - 1).min(u32::try_from(room).unwrap_or(u32::MAX));
    let mut rng = Rng(9);
    // Every other time none of 32.
    let bits: Vec<u32> = (0..count.div_ceil(32))
        .map(|i| if i % 2 == 0 { rng.bits() as u32 & rng.bits() as u32 } else { 0 })
        .collect();
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    let on_device = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: size_of_val(&bits[..]) as u64,
        usage,
        mapped_at_creation: false,
    });
    queue.write_buffer(&on_device, 0, bytemuck::cast_slice(&bits));
    let pass = Passes::without_occlusion(device).unwrap().lists;
    let lanes = LaneBuffers::new(device, queue, &Lanes::by_slot(count)).unwrap();
    let source = ListSource { bits: &on_device, seen: &on_device, listed: Listed::All };
    let draws = [(0, DrawArguments::default())];
    let list = SlotList::new(device, queue, &pass, &lanes, &draws, source).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    pass.record(&mut encoder, &list);
    queue.submit([encoder.finish()]);
    let is_set = |slot: &u32| bits[*slot as usize / 32] >> (slot % 32) & 1 != 0;
    let expected: Vec<u32> = (0..count).filter(is_set).collect();
    assert_eq!(words(gpu.read(list.arguments(), 20).unwrap())[1] as usize, expected.len());
    let found = words(gpu.read(list.list(), expected.len() as u64 * 4).unwrap());
    assert!(found == expected);
}

/// Why planes are integers: a device may multiply and add in one step, and f32 says something else then of boxes that touch a plane.
#[test]
fn in_floating_point_devices_would_differ() {
    let mut rng = Rng(5);
    let (mut differ, mut rejected) = (0, 0);
    for _ in 0..10_000 {
        let normal = rng.direction().map(|v| v as f32);
        let point = rng.vector(100.0).map(|v| v as f32);
        // A plane that touches it.
        let d = -(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2]);
        let apart = normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] + d;
        let fused = normal[0]
            .mul_add(point[0], normal[1].mul_add(point[1], normal[2].mul_add(point[2], d)));
        differ += u32::from((apart > 0.0) != (fused > 0.0));
        // The same box and plane in integers: nothing is rounded, so that sums are what they are in any order.
        let beyond = std::array::from_fn(|a| point[a] + normal[a].signum());
        let bounds = Aabb::from_points(&[point, beyond]);
        let around = bounds.union(&Aabb::new([-128.0; 3], [128.0; 3]));
        let grid = Grid::around(&around);
        let steps = grid.round_out(&bounds).unwrap();
        let plane = Plane::new(normal.map(f64::from), f64::from(-d) - rng.range(0.0, 0.1));
        let on_grid = GridPlane::new(&plane, &grid);
        let products = [0, 1, 2].map(|a| {
            let n = i64::from(on_grid.normal[a]);
            n * i64::from(if n >= 0 { steps.low[a] } else { steps.high[a] })
        });
        let offset = i64::from(on_grid.offset);
        let in_step = products.iter().rev().fold(offset, |sum, product| product + sum) > 0;
        let in_one = products.iter().sum::<i64>() + offset > 0;
        assert_eq!([in_step, in_one], [on_grid.rejects(&steps); 2]);
        rejected += u32::from(in_one);
        assert!(!in_one || bounds.side(&plane) == Side::Outside);
    }
    assert!(differ > 1000 && rejected > 1000, "{differ} differ, {rejected} rejected");
}
