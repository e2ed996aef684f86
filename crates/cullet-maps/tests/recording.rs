//! Recordings: what was answered once is answered again, at every SIMD level; any bytes are refused or played.
//!
//! `CULLET_WRITE_RECORDINGS=1` writes the regression files of `tests/recordings` anew.

use std::path::PathBuf;

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Patch, Shape, Visibility};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};
use cullet_maps::recording::{Recording, RecordingError};
use cullet_testkit::at_every_level;
use proptest::prelude::*;

/// A buffer that notes what it does.
struct Noted {
    buffer: OcclusionBuffer,
    recording: Recording,
}

impl Noted {
    fn new(view: &View, origin: [f64; 3], size: [u32; 2]) -> Self {
        let mut noted =
            Self { buffer: OcclusionBuffer::new(size).unwrap(), recording: Recording::default() };
        noted.begin(view, origin);
        noted
    }

    fn begin(&mut self, view: &View, origin: [f64; 3]) {
        self.buffer.begin(view, origin);
        self.recording.begin(view, origin, self.buffer.size());
    }

    fn draw(&mut self, shape: &Shape, at: Transform) {
        shape.draw(Simd::best(), &mut self.buffer, &at);
        self.recording.draw(shape, &at);
    }

    fn test(&mut self, bounds: Aabb) -> Visibility {
        let visibility = self.buffer.test_box(&bounds);
        self.recording.test(&bounds, visibility);
        visibility
    }
}

fn view(projection: Projection) -> View {
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    View::new(&camera, Depth::Reversed, [1280, 720]).unwrap()
}

fn perspective() -> Projection {
    Projection::Perspective {
        fov_y_radians: 1.0,
        aspect: 16.0 / 9.0,
        near: 0.1,
        far: f64::INFINITY,
    }
}

fn cuboid(min: [f32; 3], max: [f32; 3]) -> Aabb {
    Aabb { min, max }
}

fn convex(min: [f32; 3], max: [f32; 3]) -> Shape {
    Shape::Convex(Convex::from_box(&cuboid(min, max)).unwrap())
}

/// A row of boxes at places behind.
fn test_rows(noted: &mut Noted) {
    for k in 0..60 {
        let (x, y) = ((k % 10) as f32 * 0.7 - 3.3, (k / 10) as f32 * 0.6 - 1.7);
        noted.test(cuboid([x, y, -9.0], [x + 0.3, y + 0.3, -8.5]));
    }
}

/// Walls with gaps of a thousandth of a pixel and of a pixel between.
fn gaps() -> Recording {
    let px = 2.0 * 5.0 * 0.5_f32.tan() / 720.0;
    let mut noted = Noted::new(&view(perspective()), [0.0; 3], [160, 90]);
    let wall = convex([-2.0, -9.0, -5.0], [0.0, 9.0, -5.0]);
    for (k, gap) in [-px, 1e-3 * px, px].into_iter().enumerate() {
        let x = 2.0 * k as f32 - 1.0;
        noted.draw(&wall, Transform::from_translation([f64::from(x + gap), 0.0, 0.0]));
    }
    test_rows(&mut noted);
    noted.recording
}

/// A bent sheet with shared edges in three patches, mirrored, off-centre, far from the origin.
fn sheet() -> Recording {
    let row = 9_u32;
    let positions: Vec<[f32; 3]> = (0..row * row)
        .map(|v| {
            let (x, y) = ((v % row) as f32 - 4.0, (v / row) as f32 - 4.0);
            [x * 0.3, y * 0.25, -5.0 + 0.3 * (x * 0.8).sin() * (y * 0.7).cos()]
        })
        .collect();
    let indices: Vec<u32> = (0..64)
        .flat_map(|i| {
            let v = i / 8 * row + i % 8;
            [v, v + 1, v + row + 1, v, v + row + 1, v + row]
        })
        .collect();
    let projection = Projection::OffCentre {
        left: -0.05,
        right: 0.08,
        bottom: -0.04,
        top: 0.05,
        near: 0.1,
        far: 50.0,
    };
    let far = [1e6, -1e6, 0.0];
    let camera = Camera { eye: far, direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], projection };
    let view = View::new(&camera, Depth::Standard, [640, 480]).unwrap();
    let mut noted = Noted::new(&view, far, [101, 77]);
    let mirror = Transform::from_scale_translation([-1.0, 1.0, 1.0], far);
    for patch in Patch::cut(&positions, &indices, 20, true).unwrap() {
        noted.draw(&Shape::Patch(patch), mirror);
    }
    test_rows(&mut noted);
    noted.recording
}

/// A floor through the near plane and boxes on it, from two views of one buffer.
fn floor() -> Recording {
    let first = view(perspective());
    let mut noted = Noted::new(&first, [0.0; 3], [64, 36]);
    let second = view(Projection::Orthographic {
        left: -4.0,
        right: 4.0,
        bottom: -3.0,
        top: 3.0,
        near: 0.1,
        far: 30.0,
    });
    for view in [first, second] {
        noted.begin(&view, [0.0; 3]);
        noted.draw(&convex([-9.0, -1.0, -40.0], [9.0, -0.9, 9.0]), Transform::IDENTITY);
        let block = convex([-0.7, -1.0, -0.5], [0.7, 1.0, 0.5]);
        for x in [-2.0, 0.2, 1.9] {
            noted.draw(&block, Transform::from_translation([x, 0.0, -6.0]));
        }
        test_rows(&mut noted);
    }
    noted.recording
}

fn folder() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../cullet-maps/tests/recordings"))
}

#[test]
fn regression_files_are_answered_as_they_were() {
    if std::env::var("CULLET_WRITE_RECORDINGS").is_ok() {
        for (name, made) in [("gaps", gaps()), ("sheet", sheet()), ("floor", floor())] {
            std::fs::write(folder().join(name).with_extension("occ"), made.encode()).unwrap();
        }
    }
    let mut files = 0;
    for entry in std::fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "occ") {
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.len() < 20_000, "{}: {} bytes", path.display(), bytes.len());
        let recording = Recording::decode(&bytes).unwrap();
        assert_eq!(recording.encode(), bytes, "{}", path.display());
        at_every_level!(|level| {
            let found = recording.replay(level).unwrap();
            assert_eq!(found.changed, [], "{}", path.display());
            // Neither all nor nothing is hidden in any of them.
            assert!(found.hidden > 0 && found.hidden < found.tested, "{}", path.display());
        });
        files += 1;
    }
    assert!(files >= 3, "{files} files");
}

#[test]
fn what_is_recorded_is_what_is_played() {
    for made in [gaps(), sheet(), floor()] {
        let again = Recording::decode(&made.encode()).unwrap();
        assert_eq!((again.len(), again.encode()), (made.len(), made.encode()));
        let (one, two) = (made.replay(Simd::best()).unwrap(), again.replay(Simd::best()).unwrap());
        assert_eq!((one.changed.len(), &one), (0, &two));
        assert_eq!((one.views + one.drawn + one.tested) as usize, made.len());
    }
}

#[test]
fn an_answer_that_was_wrong_is_found() {
    let mut noted = Noted::new(&view(perspective()), [0.0; 3], [64, 36]);
    let target = cuboid([-0.4, -0.6, -9.0], [0.3, -0.2, -8.0]);
    assert_eq!(noted.test(target), Visibility::Visible);
    noted.recording.test(&target, Visibility::Hidden);
    let found = noted.recording.replay(Simd::best()).unwrap();
    assert_eq!(found.changed.len(), 1);
    let changed = found.changed[0];
    assert_eq!(
        (changed.call, changed.was, changed.is),
        (2, Visibility::Hidden, Visibility::Visible)
    );
}

#[test]
fn bytes_that_are_none_are_refused_with_what_is_wrong() {
    let whole = gaps().encode();
    assert_eq!(Recording::decode(b"OCCSCN01").unwrap_err(), RecordingError::Magic);
    for length in 0..whole.len() {
        let error = Recording::decode(&whole[..length]).unwrap_err();
        let expected = matches!(error, RecordingError::Magic | RecordingError::Damaged { .. });
        assert!(expected, "{length}: {error}");
    }
    let mut more = whole.clone();
    more.push(0);
    assert_eq!(Recording::decode(&more).unwrap_err(), RecordingError::Trailing(1));
    // Counts that no memory holds: of shapes, of vertices, of faces.
    for at in [8, 10, 11 + 8 * 12] {
        let mut huge = whole[..at].to_vec();
        huge.extend([0xFF, 0xFF, 0xFF, 0xFF, 0x0F]);
        huge.extend(&whole[at + 1..]);
        let error = Recording::decode(&huge).unwrap_err();
        assert!(matches!(error, RecordingError::Damaged { .. }), "{at}: {error}");
    }
    let text = Recording::decode(&whole[..whole.len() - 1]).unwrap_err().to_string();
    let last = gaps().len() - 1;
    assert!(
        text.starts_with(&format!("call {last} at byte ")) && text.contains("cut off"),
        "{text}"
    );
    let mut large = Recording::default();
    large.begin(&view(perspective()), [0.0; 3], [16384, 16384]);
    let error = Recording::decode(&large.encode()).unwrap_err();
    assert_eq!(error, RecordingError::Pixels { call: 0, size: [16384; 2] });
    let mut none = Recording::default();
    none.test(&Aabb::EMPTY, Visibility::Outside);
    let none = Recording::decode(&none.encode()).unwrap();
    assert_eq!(none.replay(Simd::best()).unwrap_err(), RecordingError::NoView(0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(300)))]

    #[test]
    fn bytes_with_faults_are_refused_or_played(
        which in 0..3_usize,
        faults in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = [gaps, sheet, floor][which]().encode();
        for (at, value) in faults {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok(recording) = Recording::decode(&bytes) {
            let found = recording.replay(Simd::best());
            let refused = |e: &RecordingError| {
                matches!(e, RecordingError::NoView(_) | RecordingError::Buffer { .. })
            };
            prop_assert!(found.is_ok() || found.is_err_and(|e| refused(&e)));
            prop_assert_eq!(Recording::decode(&recording.encode()).unwrap().len(), recording.len());
        }
    }
}
