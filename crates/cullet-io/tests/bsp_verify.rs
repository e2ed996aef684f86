//! Culling loses nothing of a map as its players see it, and takes most of it away.

use cullet::{Culler, ViewState};
use cullet_draw::{VerifyOptions, verify};
use cullet_io::paths::{self, Overrides, PathSpec};
use cullet_io::{LoadOptions, load};
use cullet_testkit::data;

#[test]
fn culling_loses_nothing_that_a_player_sees() {
    let maps = [
        ("quake-libre", "start"),
        ("quake-libre", "lqdm1"),
        ("quake-libre", "lqdm2"),
        ("quake-libre", "lq_e0m1"),
        ("quake-libre", "lq_e0m3"),
        ("quake-libre", "lq_e1m2"),
        ("quake3-openarena", "aggressor"),
        ("quake3-openarena", "oa_bases3"),
        ("quake3-openarena", "oa_dm1"),
    ];
    let options = VerifyOptions { samples: 2, ..VerifyOptions::default() };
    for (folder, name) in maps {
        let Some(folder) = data(folder) else { continue };
        let path = folder.join(name).with_extension("bsp");
        let model = load(&path, &LoadOptions::default()).unwrap();
        let of = paths::of_file(&path.display().to_string());
        assert_eq!(of, PathSpec::Camera("*".into()));
        let views = paths::views(&model, &of, 4, [320, 180], &Overrides::default()).unwrap();
        let (mut all, mut left, mut seen) = (0, 0, 0);
        for view in &views {
            let done =
                verify(&model.scene, view, &Culler::default(), &mut ViewState::default(), &options);
            assert!(done.false_culls.is_empty(), "{name}: {:?}", done.false_culls);
            all += done.all;
            left += done.potentially_visible;
            seen += done.visible;
        }
        println!("{name}: {left} of {all} triangles left, {seen} seen in {} views", views.len());
        assert!(left * 5 < all * 3 && seen > 0, "{name}: {left} of {all}");
    }
}
