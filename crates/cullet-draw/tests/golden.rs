//! Pictures against those in `tests/golden`. `CULLET_UPDATE_GOLDEN=1` writes those anew; a failure
//! leaves expected, got and difference side by side in `target/golden`.

use std::path::{Path, PathBuf};

use cullet::{Scene, View};
use cullet_draw::{
    Outlook, Picture, RenderOptions, Selection, VerifyOptions, depth_complexity, kinds_of, render,
    shaded, top_down, verify_visible,
};
use cullet_testkit::oracles::visible::frustum_kept;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;

/// A channel may differ by so much: sine and power are not the same to the last bit everywhere.
const TOLERANCE: u8 = 6;
/// And so large a share of the channels by more.
const OUTLIERS: f64 = 0.002;

fn golden(name: &str, got: &Picture) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = root.join("../cullet-draw/tests/golden").join(name).with_extension("png");
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

fn view(size: [u32; 2]) -> View {
    look([-30.0, 38.0, 130.0], [0.0, 3.0, 0.0], size)
}

#[test]
fn shaded_view() {
    let (scene, view) = (city(10, 1, 200), view([192, 108]));
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(&scene, &view, Selection::All, &options);
    golden("shaded", &shaded(&scene, &frame, &view, &[]).halved());
}

#[test]
fn map_from_above() {
    let (scene, view) = (city(10, 1, 200), view([192, 108]));
    let v = verify_visible(&scene, &view, frustum_kept(&scene, &view), &VerifyOptions::default());
    golden("map", &top_down(&scene, &view, &v.result, &v.seen, [420, 260]));
}

#[test]
fn layers_before_and_after() {
    let (scene, mut view) = (city(10, 1, 200), view([192, 108]));
    view.cull_face = cullet::view::CullFace::None;
    let options = VerifyOptions { count_layers: true, ..VerifyOptions::default() };
    let v = verify_visible(&scene, &view, frustum_kept(&scene, &view), &options);
    assert!(v.after.fragments < v.before.fragments);
    golden("layers", &depth_complexity(&v.frame, Some(&v.culled_frame)));
}

#[test]
fn kinds_of_culling() {
    let (scene, view) = (city(8, 1, 60), view([192, 108]));
    let culler = cullet::Culler::default()
        .with_output(cullet::Output::Triangles)
        .with_reasons(true)
        .with_dropped(true);
    let mut kept = cullet::Visible::default();
    culler.cull_one(&scene, &view, &mut cullet::ViewState::default(), &mut kept);
    let from = look([60.0, 110.0, 190.0], [0.0, 0.0, 20.0], [240, 150]);
    golden("kinds", &kinds_of(&scene, &view, &kept, &from));
}

#[test]
fn pictures_of_nothing_are_pictures() {
    let (scene, view) = (Scene::new(), view([40, 30]));
    let frame = render(&scene, &view, Selection::All, &RenderOptions::default());
    let none = cullet::Visible::default();
    assert_eq!(shaded(&scene, &frame, &view, &[]).rgb.len(), 40 * 30 * 3);
    assert_eq!(top_down(&scene, &view, &none, &[], [0, 0]).width, 320);
    assert!(depth_complexity(&frame, None).height > 30);
    let size = [320, 200];
    let picture = kinds_of(&scene, &view, &none, &Outlook::new(&scene, &view, size).from);
    assert_eq!([picture.width, picture.height], size);
}
