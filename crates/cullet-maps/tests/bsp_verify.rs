//! Culling loses nothing of a map as its players see it, and takes most of it away; portals do their part.

use cullet::{Culler, Stage, ViewState};
use cullet_draw::{VerifyOptions, verify};
use cullet_io::LoadOptions;
use cullet_maps::load;
use cullet_scenes::paths::{self, Overrides, PathSpec};
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
        let graph =
            model.in_cells().graph().unwrap_or_else(|| panic!("{name}: {:?}", model.warnings));
        assert_eq!(graph.cell_count() as usize, model.cells.cells.len());
        // Portals alone, with nothing that could hide their faults.
        let portal = Culler::default().with_reasons(true).only(Stage::Portal);
        let (mut all, mut left, mut seen, mut idle, mut beyond) = (0, 0, 0, 0, 0);
        for view in &views {
            let mut state = ViewState::default();
            let done = verify(model.in_cells(), view, &portal, &mut state, &options);
            assert!(done.false_culls.is_empty(), "{name}, portals: {:?}", done.false_culls);
            idle += u32::from(model.in_cells().reached(&portal, view).is_none());
            beyond += done.all - done.potentially_visible;

            let done = verify(
                model.in_cells(),
                view,
                &Culler::default(),
                &mut ViewState::default(),
                &options,
            );
            assert!(done.false_culls.is_empty(), "{name}: {:?}", done.false_culls);
            all += done.all;
            left += done.potentially_visible;
            seen += done.visible;
        }
        println!(
            "{name}: {left} of {all} triangles left, {seen} seen in {} views; portals alone take {beyond}, and nothing in \
             {idle} views",
            views.len()
        );
        assert!(
            idle * 2 <= views.len() as u32,
            "{name}: {idle} of {} eyes in no cell",
            views.len()
        );
        assert!(beyond * 2 >= all, "{name}: portals take {beyond} of {all} triangles");
        assert!(left * 5 < all * 3 && seen > 0, "{name}: {left} of {all}");
    }
}
