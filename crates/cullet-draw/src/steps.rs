//! Level of each triangle that is drawn.

use cullet::{Scene, Visible, scene::MeshLevels};

use crate::sort;

/// For each level of each mesh, how often each of its triangles was simplified.
#[derive(Clone, Debug)]
pub struct LevelSteps<'a> {
    scene: &'a Scene,
    /// For each mesh, level less one and cluster: its first triangle and its step, ascending.
    of_meshes: Vec<Vec<Vec<(u32, u32)>>>,
    most: u32,
    has_impostors: bool,
}

impl<'a> LevelSteps<'a> {
    /// Collects the steps of a scene. O(clusters of its levels).
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        let all = || (0..scene.meshes().len() as u32).flat_map(|mesh| scene.levels(mesh));
        let simplified = all().filter(|l| l.impostor.is_none());
        let most = simplified.flat_map(|l| l.levels.steps()).max().unwrap_or(0);
        let has_impostors = all().any(|l| l.impostor.is_some());
        let of_mesh = |mesh: u32| {
            let steps = |levels: &MeshLevels| {
                if levels.impostor.is_some() {
                    return vec![(0, most + 1)];
                }
                let clusters = scene.meshes()[levels.mesh as usize].clusters();
                let starts = clusters.iter().map(|c| c.first_triangle);
                let steps: Vec<(u32, u32)> = starts.zip(levels.levels.steps()).collect();
                sort::sorted_by(&steps, |s| sort::pair(s.0, s.1))
            };
            scene.levels(mesh).iter().map(steps).collect()
        };
        let of_meshes: Vec<Vec<Vec<(u32, u32)>>> =
            (0..scene.meshes().len() as u32).map(of_mesh).collect();
        Self { scene, of_meshes, most, has_impostors }
    }

    /// The coarsest step that there is: that of [impostors](Self::impostor), where there are any.
    #[must_use]
    pub fn most(&self) -> u32 {
        self.most + u32::from(self.has_impostors)
    }

    /// The step of the boxes of impostors, beyond all levels of triangles, where there are any.
    #[must_use]
    pub fn impostor(&self) -> Option<u32> {
        self.has_impostors.then_some(self.most + 1)
    }

    /// How often a triangle was simplified, given in the order of the mesh at that level: 0 in
    /// full.
    #[must_use]
    pub fn of(&self, slot: u32, level: u32, triangle: u32) -> u32 {
        if slot >= self.scene.slot_count() {
            return 0;
        }
        let own = &self.of_meshes[self.scene.mesh_id(slot) as usize];
        let Some(clusters) = level.checked_sub(1).and_then(|at| own.get(at as usize)) else {
            return 0;
        };
        let after = clusters.partition_point(|c| c.0 <= triangle);
        after.checked_sub(1).map_or(0, |at| clusters[at].1)
    }

    /// How many triangles of a visible set, with its triangles, there are of each step: one entry
    /// for each up to [`most`](Self::most).
    #[must_use]
    pub fn count(&self, visible: &Visible) -> Vec<u64> {
        let mut counts = vec![0; self.most() as usize + 1];
        for r in &visible.triangle_ranges {
            let end = (r.first as usize).saturating_add(r.count as usize);
            let own = visible.triangles.get(r.first as usize..end.min(visible.triangles.len()));
            if r.level == 0 {
                counts[0] += own.map_or(0, |own| own.len() as u64);
                continue;
            }
            for &t in own.unwrap_or_default() {
                counts[self.of(r.slot, r.level, t) as usize] += 1;
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use cullet::lod::Lod;
    use cullet::{Culler, Instance, Output, Stage, Transform};
    use cullet_testkit::answers::cull;
    use cullet_testkit::steps::Balls;
    use cullet_testkit::views::look;

    use super::*;

    #[test]
    fn triangles_are_counted_by_the_level_that_they_are_of() {
        let mut scene = Scene::new();
        let rings = [64, 16, 8];
        let mesh = Balls::new(&rings, 1.0).add_to(&mut scene);
        for z in [0.0, -4.0, -60.0, -900.0] {
            scene.add(Instance::new(mesh, Transform::from_translation([0.0, 0.0, z]))).unwrap();
        }
        scene.commit(&Culler::default());
        let view = look([0.0, 0.0, 1.5], [0.0, 0.0, -900.0], [320, 200]);
        let lod = Some(Lod::default());
        let only = Culler::default().with_lod(lod).with_output(Output::Triangles).only(Stage::Lod);
        let visible = cull(&only, &scene, &view);
        let steps = LevelSteps::new(&scene);
        assert_eq!(steps.most(), 2);
        // Near in full, and far away as coarse as there is.
        let [full, half, least] = rings.map(|n| 4 * u64::from(n) * u64::from(n - 1));
        assert_eq!(steps.count(&visible), [full, half, 2 * least]);
        assert_eq!(steps.of(u32::MAX, 1, 0), 0);
    }
}
