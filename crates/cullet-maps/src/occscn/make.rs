//! Makes benchmark scenes: which instances occlude, which boxes are tested, and from where.

use cullet::bounds::Aabb;

use super::{MeshRange, OccCamera, Occscn, Role};
use cullet_io::{ErrorKind, MatrixView, Model, local_origin};
use cullet_scenes::Rng;

/// Boxes of a scene that are tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objects {
    /// The bounds of all instances that are no occluders.
    Rest,
    /// So many random boxes in the box of the occluders, with half-extents of 0.1 to 1 per cent of
    /// its diagonal, each drawn evenly for each axis. Instances that are no occluders are left out.
    Random(u32),
}

/// How [`Occscn::make`] makes a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct MakeOptions {
    /// Parts of names: an instance is an occluder if its own name, its mesh's, or that of a node
    /// above it contains one. Empty: all are, but those with
    /// [`no_occlusion`](cullet::InstanceFlags::no_occlusion).
    pub occluders: Vec<String>,
    /// Meshes of at most so many triangles, cut from all occluders together (see
    /// [`Occscn::cluster`]); `None` leaves one mesh an instance. 128 is what published comparisons
    /// use.
    pub cluster: Option<u32>,
    /// Boxes that are tested.
    pub objects: Objects,
    /// Another seed gives other random boxes.
    pub seed: u64,
    /// Place in the world that the file's zero stands for: for a model far from zero one near it,
    /// as [`Occscn::local_origin`] finds it, for the file has 32-bit numbers.
    pub origin: [f64; 3],
}

impl Default for MakeOptions {
    fn default() -> Self {
        Self {
            occluders: Vec::new(),
            cluster: None,
            objects: Objects::Rest,
            seed: 1,
            origin: [0.0; 3],
        }
    }
}

impl Occscn {
    /// Makes a benchmark scene of a model, seen from `views`. What is blended or alpha-masked never
    /// occludes. The same model, views and options give the same scene, to the last bit.
    ///
    /// # Errors
    /// As [`from_model`](Self::from_model); also if a name matches no instance, or there is nothing
    /// that occludes.
    pub fn make(
        model: &Model,
        views: &[MatrixView],
        options: &MakeOptions,
    ) -> Result<Self, ErrorKind> {
        let wanted = occluder_slots(model, &options.occluders)?;
        let mut out = Self::gather(model, options.origin, |slot| {
            match (wanted[slot as usize], options.objects) {
                (true, _) => Role::Occluder,
                (false, Objects::Rest) => Role::Object,
                (false, Objects::Random(_)) => Role::Nothing,
            }
        })?;
        if out.triangles.is_empty() {
            let message = "none is left: what is blended or masked never occludes";
            return Err(ErrorKind::invalid("occluders", message));
        }
        if let Some(most) = options.cluster {
            out.cluster(most);
        }
        if let Objects::Random(count) = options.objects {
            out.objects = random_boxes(out.extent(), count, options.seed);
        }
        out.cameras =
            views.iter().map(|view| OccCamera::from_origin(view, options.origin)).collect();
        Ok(out)
    }

    /// Returns a place for [`MakeOptions::origin`]: zero, unless 32-bit numbers are coarse for an
    /// instance of `model` where it is, and less so near its middle.
    #[must_use]
    pub fn local_origin(model: &Model) -> [f64; 3] {
        local_origin(&model.scene)
    }

    /// Sorts the triangles into meshes of at most `most` triangles (at least 1): halves them at the
    /// median of their centres along the longest axis of the box around those, until they are few
    /// enough. Ties keep their order. Vertices stay as they are. O(n log² n) in the number of
    /// triangles.
    pub fn cluster(&mut self, most: u32) {
        let centre = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| self.vertices[v as usize]);
            // Thrice the centre, in f64, which holds any sum of three.
            std::array::from_fn(|k| f64::from(a[k]) + f64::from(b[k]) + f64::from(c[k]))
        };
        let mut items: Vec<([f64; 3], [u32; 3])> =
            self.triangles.iter().map(|t| (centre(t), *t)).collect();
        self.meshes.clear();
        let mut rest = Vec::from_iter((!items.is_empty()).then_some(0..items.len()));
        while let Some(range) = rest.pop() {
            if range.len() <= most.max(1) as usize {
                self.meshes.push(MeshRange {
                    first_triangle: range.start as u32,
                    triangle_count: range.len() as u32,
                });
                continue;
            }
            let part = &mut items[range.clone()];
            let extent: [f64; 3] = std::array::from_fn(|k| {
                let of = |f: fn(f64, f64) -> f64, from| part.iter().map(|i| i.0[k]).fold(from, f);
                of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
            });
            let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
            part.sort_by(|a, b| a.0[axis].total_cmp(&b.0[axis]));
            let middle = range.start + range.len() / 2;
            // The first half is taken next, so that ranges ascend.
            rest.extend([middle..range.end, range.start..middle]);
        }
        self.triangles = items.into_iter().map(|i| i.1).collect();
    }

    /// The box of all vertices that triangles use; empty if there is none.
    #[must_use]
    pub fn extent(&self) -> Aabb {
        let used: Vec<[f32; 3]> =
            self.triangles.as_flattened().iter().map(|&v| self.vertices[v as usize]).collect();
        Aabb::from_points(&used)
    }
}

impl From<&MatrixView> for OccCamera {
    /// Rounded to f32.
    fn from(view: &MatrixView) -> Self {
        Self::from_origin(view, [0.0; 3])
    }
}

impl OccCamera {
    /// A view of a world that is counted from `origin`, rounded to f32.
    fn from_origin(v: &MatrixView, origin: [f64; 3]) -> Self {
        let mut clip = v.clip_from_world;
        for row in 0..4 {
            clip[12 + row] += (0..3).map(|a| clip[4 * a + row] * origin[a]).sum::<f64>();
        }
        Self {
            clip_from_world: clip.map(|x| x as f32),
            eye: std::array::from_fn(|a| (v.eye[a] - origin[a]) as f32),
            near: v.near as f32,
        }
    }
}

/// Returns for each slot whether it holds one of the occluders that [`MakeOptions::occluders`]
/// names.
///
/// # Errors
/// If a name matches no instance.
pub fn occluder_slots(model: &Model, names: &[String]) -> Result<Vec<bool>, ErrorKind> {
    let scene = &model.scene;
    if names.is_empty() {
        return Ok((0..scene.slot_count()).map(|s| !scene.flags(s).no_occlusion).collect());
    }
    let mut wanted = vec![false; scene.slot_count() as usize];
    // Whether a node, or one above it, has the name. Parents may come after their children in a
    // file.
    let tree = &model.node_tree;
    for name in names {
        let under = |mut node: u32| {
            // No path to a root is longer than the tree, even if it was made with a loop.
            (0..tree.len()).any(|_| {
                let here = node as usize;
                node = tree.parents.get(here).copied().unwrap_or(cullet_io::NodeTree::NONE);
                tree.names.get(here).is_some_and(|n| n.contains(name.as_str()))
            })
        };
        let nodes: Vec<bool> = (0..tree.len() as u32).map(under).collect();
        let mut found = false;
        for slot in scene.slots() {
            let Some(handle) = scene.handle(slot) else { continue };
            let node = tree.node_of_instance.get(handle.index as usize);
            if model.instance_name(handle).contains(name.as_str())
                || model
                    .mesh_names
                    .get(scene.mesh_id(slot) as usize)
                    .is_some_and(|n| n.contains(name.as_str()))
                || node.is_some_and(|&n| nodes.get(n as usize).copied().unwrap_or(false))
            {
                wanted[slot as usize] = true;
                found = true;
            }
        }
        if !found {
            let message = "it is in the name of no instance, mesh or node; `cullet info SCENE --all` lists them";
            return Err(ErrorKind::invalid(format!("occluders '{name}'"), message));
        }
    }
    Ok(wanted)
}

/// Boxes as [`Objects::Random`] says; none in an extent that is not finite.
fn random_boxes(extent: Aabb, count: u32, seed: u64) -> Vec<[[f32; 3]; 2]> {
    if !extent.is_finite() {
        return Vec::new();
    }
    let (min, max) = (extent.min.map(f64::from), extent.max.map(f64::from));
    let diagonal = (0..3).map(|k| (max[k] - min[k]).powi(2)).sum::<f64>().sqrt();
    let mut rng = Rng::new(seed, 4);
    (0..count)
        .map(|_| {
            let centre: [f64; 3] = std::array::from_fn(|k| rng.range(min[k], max[k]));
            let half: [f64; 3] = std::array::from_fn(|_| rng.range(0.001, 0.01) * diagonal);
            let corner = |side: f64| std::array::from_fn(|k| (centre[k] + side * half[k]) as f32);
            [corner(-1.0), corner(1.0)]
        })
        .collect()
}
