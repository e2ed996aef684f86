//! Reference visibility from files beside the scene, and the agreement of results with it.

use std::path::{Path, PathBuf};

use cullet::Transform;
use cullet::bounds::Aabb;
use cullet_command::exit::Failure;
use cullet_draw::{OccluderTriangles, SampleOptions, occluder_scene, sampled_boxes};
use cullet_maps::occscn::Occscn;
use serde::Serialize;

use super::rasteriser::{HIDDEN, OUTSIDE};
use super::scene::view;

/// Values of a reference: 0 outside, 1 visible, 2 hidden, 3 crosses the near plane, so never
/// counted.
const SEEN: u8 = 1;
const UNSEEN: u8 = 2;
const MOST: u8 = 3;

/// Pixels of published references, whatever the occlusion buffer has.
const SIZE: [u32; 2] = [1280, 720];
/// An object that is not nearer than what hides it by more than this part of its distance counts as
/// hidden there.
pub const TOLERANCE: f64 = 1e-6;

/// References that are looked for beside a scene: images of up to so many times the width and
/// height.
const FINEST: u32 = 16;

/// Visibility in images of N × N times the pixels.
#[derive(Clone, Debug)]
pub struct Reference {
    /// N.
    pub samples: u32,
    /// Each view's samples are shifted by a part of one, at random: so that pictures of different N
    /// have not the same places in them, and edges that follow the pixels are no special case.
    pub jittered: bool,
    /// View by view, one value an object.
    pub values: Vec<u8>,
}

/// Answers beside a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Agreement {
    /// N of the reference.
    pub samples: u32,
    /// Whether its samples were shifted at random.
    pub jittered: bool,
    /// Objects hidden there, over all views.
    pub hidden: u64,
    /// How many of these were culled.
    pub found: u64,
    /// Objects seen there.
    pub visible: u64,
    /// How many of these were culled.
    pub false_culls: u64,
    /// How many per cent of what is hidden was found; 100 where nothing is.
    pub efficiency: f64,
}

impl Reference {
    /// All references beside a scene: `city.bin.ref4` or `city.ref4`, and with jittered samples
    /// `city.bin.ref4j`.
    pub(super) fn beside(scene: &Path, views: usize, objects: usize) -> Result<Vec<Self>, Failure> {
        let mut found = Vec::new();
        for (samples, jittered) in (1..=FINEST).flat_map(|n| [(n, false), (n, true)]) {
            let places = paths(scene, samples, jittered);
            let Some(path) = places.into_iter().find(|p| p.is_file()) else { continue };
            let fail = |what: String| Failure::input(format!("{}: {what}", path.display()));
            let values = std::fs::read(&path).map_err(|e| fail(format!("cannot be read: {e}")))?;
            let want = views as u64 * objects as u64;
            if values.len() as u64 != want {
                return Err(fail(format!(
                    "{} bytes, but {views} views of {objects} objects take {want}; it belongs to \
                     another scene, so remove it or make it anew",
                    values.len()
                )));
            }
            if let Some(at) = values.iter().position(|&v| v > MOST) {
                let (view, object) = (at / objects, at % objects);
                let value = values[at];
                return Err(fail(format!(
                    "view {view}, object {object}: {value} is not a result; they are 0 to {MOST}"
                )));
            }
            found.push(Self { samples, jittered, values });
        }
        Ok(found)
    }

    /// How answers, view by view, stand beside it. Those may be of the first views alone.
    pub fn judge(&self, answers: &[u8]) -> Agreement {
        let Self { samples, jittered, .. } = *self;
        let mut agreement = Agreement { samples, jittered, ..Agreement::default() };
        for (&truth, &answer) in self.values.iter().zip(answers) {
            let culled = u64::from(answer == HIDDEN || answer == OUTSIDE);
            match truth {
                UNSEEN => {
                    agreement.hidden += 1;
                    agreement.found += culled;
                }
                SEEN => {
                    agreement.visible += 1;
                    agreement.false_culls += culled;
                }
                _ => {}
            }
        }
        agreement.efficiency = match agreement.hidden {
            0 => 100.0,
            hidden => agreement.found as f64 / hidden as f64 * 100.0,
        };
        agreement
    }
}

/// Draws the reference of the first `views` views: 1280 × 720 pixels of N × N samples each, both
/// sides of every triangle, as published references are. Ends early where `go_on` says so, which is
/// called after each view.
pub(super) fn drawn(
    scene: &Occscn,
    objects: &[Aabb],
    views: usize,
    samples: u32,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Reference, Failure> {
    let occluder = OccluderTriangles {
        positions: &scene.vertices,
        indices: scene.triangles.as_flattened(),
        transform: Transform::IDENTITY,
        two_sided: true,
    };
    let occluders =
        occluder_scene(&[occluder]).map_err(|e| Failure::input(format!("the reference: {e}")))?;
    let options = SampleOptions { samples, tolerance: TOLERANCE, ..SampleOptions::default() };
    let mut values = Vec::with_capacity(views * objects.len());
    for camera in 0..views.min(scene.cameras.len()) {
        let view = view(scene, camera, SIZE)?;
        let answers = sampled_boxes(&occluders, &view, objects, &options);
        values.extend(answers.into_iter().map(|a| a as u8));
        if !go_on() {
            break;
        }
    }
    Ok(Reference { samples, jittered: false, values })
}

/// Where the reference of a scene may lie.
fn paths(scene: &Path, samples: u32, jittered: bool) -> [PathBuf; 2] {
    let ending = format!("ref{samples}{}", if jittered { "j" } else { "" });
    let mut name = scene.as_os_str().to_owned();
    name.push(format!(".{ending}"));
    [name.into(), scene.with_extension(ending)]
}

#[cfg(test)]
mod tests {
    use super::super::rasteriser::VISIBLE;
    use super::*;

    #[test]
    fn what_is_seen_and_culled_is_a_false_cull() {
        let values = vec![0, 1, 1, 1, 2, 2, 2, 3];
        let reference = Reference { samples: 4, jittered: false, values };
        let answers = [OUTSIDE, VISIBLE, HIDDEN, OUTSIDE, HIDDEN, OUTSIDE, VISIBLE, HIDDEN];
        let agreement = reference.judge(&answers);
        assert_eq!((agreement.samples, agreement.hidden, agreement.found), (4, 3, 2));
        assert_eq!((agreement.visible, agreement.false_culls), (3, 2));
        assert!((agreement.efficiency - 200.0 / 3.0).abs() < 1e-9);
        // Of the first views alone.
        let short = reference.judge(&answers[..3]);
        assert_eq!((short.visible, short.hidden), (2, 0));
        assert_eq!(short.efficiency, 100.0);
    }

    #[test]
    fn references_are_found_beside_the_scene_and_checked() {
        let folder = std::env::temp_dir().join(format!("cullet-refs-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("a.bin");
        let find = || Reference::beside(&scene, 2, 3);
        assert!(find().unwrap().is_empty());
        std::fs::write(folder.join("a.ref4"), [0, 1, 2, 3, 2, 1]).unwrap();
        std::fs::write(folder.join("a.bin.ref1"), [2; 6]).unwrap();
        std::fs::write(folder.join("a.bin.ref4j"), [1; 6]).unwrap();
        let found = find().unwrap();
        let which: Vec<_> = found.iter().map(|r| (r.samples, r.jittered)).collect();
        assert_eq!(which, [(1, false), (4, false), (4, true)]);
        assert_eq!(found[1].values, [0, 1, 2, 3, 2, 1]);
        std::fs::write(folder.join("a.ref2"), [0; 5]).unwrap();
        assert!(find().unwrap_err().message.contains("5 bytes, but 2 views of 3 objects take 6"));
        std::fs::write(folder.join("a.ref2"), [0, 0, 0, 0, 9, 0]).unwrap();
        assert!(find().unwrap_err().message.contains("view 1, object 1: 9"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
