//! An app without a window or a renderer, with Bevy's own visibility or the plugin's.
#![allow(dead_code, unreachable_pub, reason = "each test uses a part of it")]

use std::any::TypeId;

use bevy::app::{PluginsState, TaskPoolPlugin};
use bevy::asset::AssetPlugin;
use bevy::camera::CameraPlugin;
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{NoAutoAabb, VisibleEntities};
use bevy::math::Vec3A;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy_cullet::CulletPlugin;

/// The app.
pub struct Headless {
    pub app: App,
    is_finished: bool,
}

impl Headless {
    pub fn without_plugin() -> Self {
        let mut app = App::new();
        app.add_plugins((
            TaskPoolPlugin::default(),
            TransformPlugin,
            AssetPlugin::default(),
            MeshPlugin,
            CameraPlugin,
        ));
        app.init_asset::<Image>();
        Self { app, is_finished: false }
    }

    pub fn with_plugin() -> Self {
        let mut app = Self::without_plugin();
        app.app.add_plugins(CulletPlugin);
        app
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    pub fn camera(&mut self) -> Entity {
        self.world().spawn(Camera3d::default()).id()
    }

    pub fn frames(&mut self, count: usize) {
        if !std::mem::replace(&mut self.is_finished, true) {
            while self.app.plugins_state() == PluginsState::Adding {}
            self.app.finish();
            self.app.cleanup();
        }
        (0..count).for_each(|_| self.app.update());
    }

    /// The meshes that a camera sees.
    pub fn seen(&self, camera: Entity) -> Vec<Entity> {
        let visible = self.app.world().get::<VisibleEntities>(camera);
        visible.map(|v| v.get(TypeId::of::<Mesh3d>()).to_vec()).unwrap_or_default()
    }
}

/// A box of one unit to each side.
pub fn solid(half: [f32; 3]) -> impl Bundle {
    let half_extents = Vec3A::from_array(half);
    (Mesh3d::default(), NoAutoAabb, Aabb { center: Vec3A::ZERO, half_extents })
}

/// A cube of one unit.
pub fn cube(app: &mut Headless, at: [f32; 3]) -> Entity {
    app.world().spawn((Transform::from_translation(at.into()), solid([0.5; 3]))).id()
}

/// Numbers that look random.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
    pub fn within(&mut self, by: f32) -> f32 {
        (self.unit() * 2.0 - 1.0) * by
    }
    pub fn vec(&mut self, by: f32) -> Vec3 {
        Vec3::new(self.within(by), self.within(by), self.within(by))
    }
    pub fn one_in(&mut self, n: u32) -> bool {
        self.unit() * (n as f32) < 1.0
    }
}
