//! Pictures from random places: how wrong are the sets, in pixels and in what is missing?

use glam::DVec3;

use super::cells::ViewCells;
use super::tree::{Passed, RayTree};
use crate::rows::{BitRows, ones};
use crate::threads;
use cullet_draw::Random;

/// Check of sets by pictures from random places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureCheck {
    /// Places from where a picture was made all around.
    pub poses: u32,
    /// Pixels of all pictures, sky included.
    pub pixels: u64,
    /// Pixels in which something is seen that the cell's set lacks.
    pub wrong_pixels: u64,
    /// Different targets in the pictures, summed over the pictures.
    pub seen: u64,
    /// Pixels among them that show what the cell's set lacks.
    pub missing: u64,
    /// The picture with most wrong pixels: its cell, the eye, and how many are wrong.
    pub worst: Option<WorstPose>,
}

/// The picture with most wrong pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstPose {
    /// The cell.
    pub cell: u32,
    /// Where the eye is, in the world.
    pub eye: [f64; 3],
    /// Wrong pixels of its picture.
    pub wrong_pixels: u64,
}

impl PictureCheck {
    /// Share of the pixels that are wrong.
    #[must_use]
    pub fn pixel_error(&self) -> f64 {
        self.wrong_pixels as f64 / self.pixels.max(1) as f64
    }

    /// Share of what the pictures show that is missing.
    #[must_use]
    pub fn missing_share(&self) -> f64 {
        self.missing as f64 / self.seen.max(1) as f64
    }
}

/// Draws pictures of all that is around random points of random cells, and holds them against the
/// cells' rows: six faces of a cube, of `side` × `side` pixels each, a ray through the middle of
/// each. The points have nothing to do with those of a bake, and what is drawn does not know the
/// sets.
///
/// Cost: 6 · `side`² rays a pose, on so many threads, which change nothing but time.
#[must_use]
pub fn check_pictures(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    rows: &BitRows,
    poses: u32,
    side: u32,
    seed: u64,
    threads: usize,
) -> PictureCheck {
    let all: Vec<u32> = (0..cells.len()).collect();
    check_pictures_from(tree, cells, &all, rows, [poses, side], seed, threads)
}

/// The same from random points of some of the cells, `among`; `[poses, side]` are how many pictures
/// and the pixels along their sides.
#[must_use]
pub fn check_pictures_from(
    tree: &RayTree<'_>,
    cells: &ViewCells,
    among: &[u32],
    rows: &BitRows,
    [poses, side]: [u32; 2],
    seed: u64,
    threads: usize,
) -> PictureCheck {
    if among.is_empty() {
        return PictureCheck::default();
    }
    let pictures = threads::run(
        threads.max(1),
        poses as usize,
        || (Vec::new(), vec![0_u64; rows.columns().div_ceil(64) as usize]),
        |(passed, seen), pose| {
            let mut random = Random::new(mixed(seed), [pose as u32, 0x51c7]);
            let cell = among[random.below(among.len() as u32) as usize];
            let [low, high] = cells.boxes()[cell as usize];
            let eye = low + (high - low) * DVec3::from(random.three());
            let wrong = picture(tree, eye, side, rows.row(cell), passed, seen);
            let lacking = seen.iter().zip(rows.row(cell)).map(|(s, r)| (s & !r).count_ones());
            let missing = lacking.map(u64::from).sum::<u64>();
            let count = ones(seen).count() as u64;
            seen.fill(0);
            (WorstPose { cell, eye: eye.into(), wrong_pixels: wrong }, count, missing)
        },
        || true,
    );
    let mut check = PictureCheck { poses, ..PictureCheck::default() };
    check.pixels = u64::from(poses) * 6 * u64::from(side) * u64::from(side);
    for (pose, seen, missing) in pictures.unwrap_or_default() {
        check.wrong_pixels += pose.wrong_pixels;
        check.seen += seen;
        check.missing += missing;
        let most = check.worst.map_or(0, |w| w.wrong_pixels);
        if pose.wrong_pixels > most {
            check.worst = Some(pose);
        }
    }
    check
}

/// Another seed than that of a bake, whatever that is.
fn mixed(seed: u64) -> u64 {
    seed ^ 0x7069_6374_7572_6573
}

/// Draws all that is around a point; how many pixels show what the row lacks. `seen` gets a bit for
/// each target.
fn picture(
    tree: &RayTree<'_>,
    eye: DVec3,
    side: u32,
    row: &[u64],
    passed: &mut Vec<Passed>,
    seen: &mut [u64],
) -> u64 {
    let mut wrong = 0;
    let mut note = |target: u32| {
        let (word, bit) = (target as usize / 64, 1 << (target % 64));
        seen[word] |= bit;
        row[word] & bit == 0
    };
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        for y in 0..side {
            for x in 0..side {
                let place = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(side) - 1.0;
                let mut way = DVec3::ZERO;
                way[axis] = sign;
                way[(axis + 1) % 3] = place(x);
                way[(axis + 2) % 3] = place(y);
                let hit = tree.cast(eye, way, passed).hit;
                let in_front = passed.iter().filter(|p| p.seen[0]).map(|p| p.target);
                let lacks = hit.map(|h| h.target).into_iter().chain(in_front);
                wrong += u64::from(lacks.fold(false, |any, target| note(target) | any));
            }
        }
    }
    wrong
}
