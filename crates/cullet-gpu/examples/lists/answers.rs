//! Lists of each scene and view, and whether the device agrees with the CPU.

use cullet_gpu::{BLOCK, BlockPlanes, Blocks, Gpu, GpuError, Lanes, Passes, visible_ref};

use super::device::Listing;
use super::lists::{difference, hash, lists_ref};
use super::scenes::{Case, scenes};

/// List of one view, by the CPU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Answer {
    /// The scene's name.
    pub scene: &'static str,
    /// Instances of it.
    pub instances: u32,
    /// How many are in the view.
    pub listed: usize,
    /// Hash of bits and lists.
    pub hash: u64,
    /// Difference of the device's lists, in words, if one was asked.
    pub differs: Option<String>,
}

/// A line for each answer, to be compared with that of another machine.
///
/// # Errors
/// If a device listed something else than the CPU: a line for each such answer.
pub(crate) fn report(answers: &[Answer]) -> Result<String, String> {
    let line =
        |a: &Answer| format!("{}, {}: {} listed, {:016x}", a.scene, a.instances, a.listed, a.hash);
    let differs = |a: &Answer| Some(format!("{}: {} differs", line(a), a.differs.as_ref()?));
    let wrong: Vec<String> = answers.iter().filter_map(differs).collect();
    if wrong.is_empty() {
        Ok(answers.iter().map(line).collect::<Vec<_>>().join("\n"))
    } else {
        Err(wrong.join("\n"))
    }
}

/// All answers, in order; with a device also whether it gives the same.
///
/// # Errors
/// If the device has no room for a scene, or is lost.
pub(crate) async fn answers(on: Option<(&Gpu, &Passes)>) -> Result<Vec<Answer>, GpuError> {
    let mut all = Vec::new();
    for case in scenes() {
        add(&case, on, &mut all).await?;
    }
    Ok(all)
}

async fn add(
    case: &Case,
    on: Option<(&Gpu, &Passes)>,
    all: &mut Vec<Answer>,
) -> Result<(), GpuError> {
    let blocks = Blocks::new(&case.scene);
    let lanes = Lanes::of(&case.scene);
    let mut device = on.map(|on| Listing::new(on, &case.scene, &blocks)).transpose()?;
    let mut planes = BlockPlanes::default();
    let mut seen = vec![0; blocks.boxes().len().max(BLOCK) / 32];
    for (of_view, layers) in &case.views {
        planes.set(&blocks, of_view, *layers);
        let slots = visible_ref(&blocks, &planes);
        let lists = lists_ref(&slots, &seen, &lanes);
        let differs = match &mut device {
            Some(device) => difference(&lists, &device.list(&planes).await?),
            None => None,
        };
        all.push(Answer {
            scene: case.name,
            instances: case.scene.instance_count(),
            listed: slots.len(),
            hash: hash(&lists),
            differs,
        });
        seen = lists.bits;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_differs_is_told_by_scene_and_view() {
        let answer = Answer { scene: "s", instances: 1, listed: 1, hash: 5, differs: None };
        let wrong = Answer { differs: Some("1 of 8 words of bits".to_owned()), ..answer.clone() };
        assert_eq!(report(std::slice::from_ref(&answer)).unwrap().lines().count(), 1);
        let told = report(&[answer, wrong]).unwrap_err();
        assert!(told.lines().count() == 1 && told.contains("words of bits differs"), "{told}");
    }
}
