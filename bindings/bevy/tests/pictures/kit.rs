//! Parts that scenes are built with: boxes, walls, lights and cameras.

use bevy::camera::RenderTarget;
use bevy::camera::visibility::RenderLayers;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;

use crate::picture::Canvas;

/// A mesh in the picture of the scene: a plugin that loses it must be noticed.
#[derive(Component)]
pub(crate) struct Probe;

/// A mesh outside the picture whose shadow is in it: a plugin that takes it from the lights must be noticed.
#[derive(Component)]
pub(crate) struct CasterProbe;

/// Pseudorandom numbers in 0..1, the same on every machine.
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn roll(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

/// A world that a scene is built into.
pub(crate) struct Kit<'w> {
    pub(crate) world: &'w mut World,
    pub(crate) cube: Handle<Mesh>,
    pub(crate) paints: Vec<Handle<StandardMaterial>>,
}

impl<'w> Kit<'w> {
    pub(crate) fn new(world: &'w mut World) -> Self {
        let cube = world.resource_mut::<Assets<Mesh>>().add(Cuboid::new(1.0, 1.0, 1.0));
        let mut kit = Self { world, cube, paints: Vec::new() };
        kit.paints = (0..8).map(|i| kit.paint(Color::hsl(i as f32 * 45.0, 0.7, 0.5))).collect();
        kit
    }

    pub(crate) fn paint(&mut self, color: Color) -> Handle<StandardMaterial> {
        self.material(StandardMaterial { base_color: color, ..default() })
    }

    /// Rough, so that no highlight depends on the eye.
    pub(crate) fn material(&mut self, material: StandardMaterial) -> Handle<StandardMaterial> {
        let material = StandardMaterial { perceptual_roughness: 0.9, ..material };
        self.world.resource_mut::<Assets<StandardMaterial>>().add(material)
    }

    /// The parts of a box whose colour is the `paint`th.
    pub(crate) fn box_parts(&self, paint: usize, at: Transform) -> impl Bundle + use<> {
        let paint = self.paints[paint % self.paints.len()].clone();
        (Mesh3d(self.cube.clone()), MeshMaterial3d(paint), at)
    }

    pub(crate) fn put(&mut self, paint: usize, center: [f32; 3], size: [f32; 3]) -> Entity {
        let at = Transform::from_translation(center.into()).with_scale(size.into());
        let parts = self.box_parts(paint, at);
        self.world.spawn(parts).id()
    }

    /// `count` boxes at all angles between two corners.
    pub(crate) fn heap(&mut self, count: usize, from: Vec3, to: Vec3) -> Vec<Entity> {
        let mut dice = Dice(count as u64);
        let mut angle = || dice.roll() * 6.0;
        let turns: Vec<_> = (0..count)
            .map(|_| Quat::from_euler(EulerRot::XYZ, angle(), angle(), angle()))
            .collect();
        let boxes = turns.into_iter().enumerate().map(|(i, turn)| {
            let place = Vec3::new(dice.roll(), dice.roll(), dice.roll());
            let at = Transform::from_translation(from + (to - from) * place).with_rotation(turn);
            self.box_parts(i, at.with_scale(Vec3::splat(0.4 + dice.roll())))
        });
        let boxes: Vec<_> = boxes.collect();
        boxes.into_iter().map(|parts| self.world.spawn(parts).id()).collect()
    }

    /// Ground, four walls and 600 boxes among them, seen along -Z.
    pub(crate) fn yard(&mut self) -> [Entity; 4] {
        self.heap(600, Vec3::new(-40.0, 0.0, -104.0), Vec3::new(40.0, 12.0, -4.0));
        self.put(3, [0.0, -1.0, -50.0], [120.0, 1.0, 140.0]);
        let walls =
            [(-6.0, -12.0, 9.0), (9.0, -20.0, 14.0), (-20.0, -40.0, 30.0), (18.0, -55.0, 30.0)];
        walls.map(|(x, z, wide)| self.put(0, [x, 5.0, z], [wide, 10.0, 0.5]))
    }

    /// The box that is lost by mutants, near the middle of the picture.
    pub(crate) fn probe(&mut self) -> Entity {
        let e = self.put(5, [1.0, 2.6, -3.0], [0.5, 0.5, 0.5]);
        self.world.entity_mut(e).insert(Probe);
        e
    }

    /// A box that is not seen itself, between a light from above and the ground that is.
    pub(crate) fn caster_probe(&mut self, center: [f32; 3]) {
        let e = self.put(5, center, [2.0, 2.0, 2.0]);
        self.world.entity_mut(e).insert(CasterProbe);
    }

    pub(crate) fn daylight(&mut self, shadow_maps_enabled: bool) {
        let light = DirectionalLight { illuminance: 3000.0, shadow_maps_enabled, ..default() };
        let from = Transform::from_xyz(5.0, 9.0, -5.0);
        self.world.spawn((light, from.looking_at(Vec3::new(-3.0, 0.0, -30.0), Vec3::Y)));
    }

    pub(crate) fn camera(&mut self, at: Transform) -> Entity {
        let canvas = self.world.resource::<Canvas>().0.clone();
        let target = RenderTarget::Image(canvas.into());
        let camera = (Camera3d::default(), target, Msaa::Off, Tonemapping::Reinhard, at);
        self.world.spawn(camera).id()
    }

    /// The camera that looks into the yard.
    pub(crate) fn eye(&mut self) -> Entity {
        self.camera(Transform::from_xyz(0.0, 3.0, 2.0))
    }

    pub(crate) fn layer(&mut self, e: Entity, layers: &[usize]) {
        self.world.entity_mut(e).insert(RenderLayers::from_layers(layers));
    }
}
