//! Diagrams against those in `tests/golden`. `CULLET_UPDATE_GOLDEN=1` writes those anew; a failure
//! leaves expected, got and difference side by side in `target/golden`.

use std::path::{Path, PathBuf};

use cullet::{Scene, View};
use cullet_draw::Picture;
use cullet_lab::teach::{
    back_regions, clusters, cones, conservative_set, culling_volume, normal_mask, normal_partition,
};
use cullet_mesh::ViewCone;
use cullet_testkit::meshes;
use cullet_testkit::views::look;

/// A channel may differ by so much: sine and power are not the same to the last bit everywhere.
const TOLERANCE: u8 = 6;
/// And so large a share of the channels by more.
const OUTLIERS: f64 = 0.002;

fn golden(name: &str, got: &Picture) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("tests/golden").join(name).with_extension("png");
    let bytes = got.to_png();
    assert!(bytes.len() <= 30_000, "{name} has {} bytes; keep golden pictures small", bytes.len());
    if std::env::var_os("CULLET_UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, bytes).unwrap();
        return;
    }
    let expected = read(&path);
    let same_size = (expected.width, expected.height) == (got.width, got.height);
    let apart = expected.rgb.iter().zip(&got.rgb).filter(|(a, b)| a.abs_diff(**b) > TOLERANCE);
    let share = apart.count() as f64 / got.rgb.len() as f64;
    if !same_size || share > OUTLIERS {
        let out = side_by_side(root, name, &expected, got);
        panic!(
            "{name}: {:.2} % of it differs, see {}; if it is meant, run again with \
             CULLET_UPDATE_GOLDEN=1",
            share * 100.0,
            out.display()
        );
    }
}

fn read(path: &Path) -> Picture {
    let file = std::fs::File::open(path)
        .unwrap_or_else(|e| panic!("{}: {e}; CULLET_UPDATE_GOLDEN=1 makes it", path.display()));
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    Picture { width: info.width, height: info.height, rgb }
}

fn side_by_side(root: &Path, name: &str, expected: &Picture, got: &Picture) -> PathBuf {
    let (w, h) = (expected.width.max(got.width), expected.height.max(got.height));
    let mut all = Picture::new(w * 3, h, [0; 3]);
    for y in 0..h {
        for x in 0..w {
            let (a, b) = (expected.pixel(x, y), got.pixel(x, y));
            let apart = std::array::from_fn(|c| a[c].abs_diff(b[c]).saturating_mul(8));
            for (i, color) in [a, b, apart].into_iter().enumerate() {
                let at = ((y * w * 3 + i as u32 * w + x) * 3) as usize;
                all.rgb[at..at + 3].copy_from_slice(&color);
            }
        }
    }
    let out = root.join("../../target/golden");
    std::fs::create_dir_all(&out).unwrap();
    let out = out.join(name).with_extension("png");
    all.save_png(&out).unwrap();
    out
}

/// The smallest sheet there is.
const SHEET: [u32; 2] = [640, 360];

#[test]
fn diagrams_of_normals() {
    let cone = ViewCone::around([-3.0, -2.0, -5.0], 10f64.to_radians()).unwrap();
    // With 3,000 lines, so small that its file is, too.
    golden("normal-mask", &normal_mask(&cone, SHEET).halved().halved());
    golden("normal-partition", &normal_partition(20.0, SHEET).halved());
    golden("conservative-set", &conservative_set(90.0, SHEET).halved());
}

#[test]
fn diagrams_take_any_angle_and_size() {
    for angle in [f64::NAN, -1.0, f64::INFINITY] {
        let [a, b] = [normal_partition(angle, [0; 2]), conservative_set(angle, [0; 2])];
        assert_eq!([[a.width, a.height], [b.width, b.height]], [SHEET; 2]);
    }
    assert_eq!(normal_partition(f64::NAN, SHEET), normal_partition(0.0, SHEET));
    assert_eq!(normal_partition(999.0, SHEET), normal_partition(80.0, SHEET));
    assert_eq!(conservative_set(f64::NAN, SHEET), conservative_set(90.0, SHEET));
    assert_ne!(conservative_set(40.0, SHEET), conservative_set(90.0, SHEET));
}

/// The knobbly ball, and a view of it.
fn knobs() -> (Scene, View) {
    let model = cullet_scenes::build("knobs:n=12").unwrap();
    (model.scene, look([2.4, 2.6, 3.0], [0.0, 1.15, 0.0], [192, 108]))
}

#[test]
fn surfaces_in_clusters_and_cones() {
    let (scene, view) = knobs();
    golden("clusters", &clusters(&scene, &view));
    golden("cones", &cones(&scene, &view));
}

#[test]
fn regions_that_face_away() {
    let (scene, view) = knobs();
    let (picture, count) = back_regions(&scene, &view);
    // Each hollow on the near side may have one; that on the far side is the largest.
    assert!((3..60).contains(&count), "{count}");
    golden("back-regions", &picture);
    // Nothing depends on how many threads draw.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| back_regions(&scene, &view)), (picture, count));
}

#[test]
fn a_box_has_one_region_that_faces_away() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
    scene.add(cullet::Instance::new(mesh, cullet::Transform::IDENTITY)).unwrap();
    scene.commit(&cullet::Culler::default());
    let (_, count) = back_regions(&scene, &look([4.0, 3.0, 5.0], [0.0; 3], [192, 108]));
    assert_eq!(count, 1);
}

#[test]
fn a_cluster_and_its_volume() {
    let (scene, _) = knobs();
    let slot = scene.slots().next().unwrap();
    let (picture, figure) = culling_volume(&scene, slot, None, SHEET).unwrap();
    golden("culling-volume", &picture.halved());
    // The proved region is a part of the ideal one.
    assert!(0.02 < figure.proved && figure.proved < figure.ideal && figure.ideal < 0.5);
    let again = culling_volume(&scene, slot, Some(figure.cluster), SHEET).unwrap();
    assert_eq!(again, (picture, figure));
    let clusters = scene.mesh(slot).clusters().len() as u32;
    assert!(culling_volume(&scene, slot, Some(clusters), SHEET).is_none());
    assert!(culling_volume(&scene, scene.slot_count(), None, SHEET).is_none());
}

#[test]
fn diagrams_of_nothing_are_pictures() {
    let (scene, view) = (Scene::new(), look([2.4, 2.6, 3.0], [0.0; 3], [40, 30]));
    for picture in [clusters(&scene, &view), cones(&scene, &view), back_regions(&scene, &view).0] {
        assert_eq!([picture.width, picture.height], [40, 30]);
    }
}
