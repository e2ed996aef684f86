//! Writes the pictures of a small city where a person can look at them:
//! `cargo test --release -p cullet-draw --test gallery -- --ignored`, into `target/gallery`.

mod common;

use std::path::Path;
use std::time::Instant;

use common::{city, frustum_kept, look};
use cullet_draw::{
    Picture, RenderOptions, Selection, VerifyOptions, depth_complexity, fly_out, kinds_of, render,
    shaded, top_down, verify_visible,
};

#[test]
#[ignore = "for looking at"]
fn gallery() {
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/gallery");
    std::fs::create_dir_all(&out).unwrap();
    let save = |name: &str, start: Instant, picture: Picture| {
        let drawn = start.elapsed();
        picture.save_png(out.join(name)).unwrap();
        println!("{name}: {drawn:.2?}, with the file {:.2?}", start.elapsed());
    };
    let scene = city(24, 1, 4000);
    for (name, eye, target) in [
        ("street", [0.0, 1.7, 200.0], [8.0, 6.0, 0.0]),
        ("above", [-60.0, 75.0, 260.0], [0.0, 5.0, 0.0]),
    ] {
        let view = look(eye, target, [1280, 720]);
        let start = Instant::now();
        let options = RenderOptions { scale: 2, ..RenderOptions::default() };
        let frame = render(&scene, &view, Selection::All, &options);
        save(&format!("{name}-shaded.png"), start, shaded(&scene, &frame, &view, &[]).halved());
        let options = VerifyOptions { count_layers: true, ..VerifyOptions::default() };
        let start = Instant::now();
        let v = verify_visible(&scene, &view, frustum_kept(&scene, &view), &options);
        println!("verified in {:.2?}, {} lost", start.elapsed(), v.false_culls.len());
        let start = Instant::now();
        save(
            &format!("{name}-map.png"),
            start,
            top_down(&scene, &view, &v.result, &v.seen, [1280, 900]),
        );
        let start = Instant::now();
        save(
            &format!("{name}-layers.png"),
            start,
            depth_complexity(&v.frame, Some(&v.culled_frame)),
        );
        let start = Instant::now();
        let from = fly_out(&scene, &view, [1280, 720]);
        save(&format!("{name}-kinds.png"), start, kinds_of(&scene, &view, &v.result, &from));
    }
}
