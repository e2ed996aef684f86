//! Hierarchies of the shared test models: ceilings on what is drawn at one pixel, with the bound kept.

use cullet_bake::levels::{ErrorSource, HierarchyOptions, build_hierarchy};
use cullet_testkit::meshes::one_sided_data;
use cullet_testkit::models::model;

use super::cuts::row;

#[test]
fn models_need_few_triangles_at_one_pixel_and_keep_it() {
    // Radii, and the most triangles.
    let armadillo = [(2.0, 46_000.0), (5.0, 15_000.0), (20.0, 2_900.0)];
    let buddha = [(2.0, 45_500.0), (5.0, 17_000.0), (20.0, 3_900.0)];
    let models = [("armadillo/armadillo.obj", armadillo), ("happy-buddha/buddha-100k.obj", buddha)];
    for (name, most) in models {
        let Some(data) = model(name).map(one_sided_data) else { continue };
        let levels = build_hierarchy(&data, None, &HierarchyOptions::default()).expect("valid");
        levels.validate().expect("valid");
        for (radii, most) in most {
            let (triangles, d) = row(&levels, &data.indices, radii, 40_000);
            println!("{name} at {radii} R: {triangles:.0} {d:?}");
            assert!(triangles < most, "{name} at {radii} R: {triangles}");
            assert!(d.p999 <= 1.0 && d.most <= 1.2, "{name} at {radii} R: {d:?}");
        }
        // The simplifier's own errors do not.
        let options =
            HierarchyOptions { errors: ErrorSource::Returned, ..HierarchyOptions::default() };
        let levels = build_hierarchy(&data, None, &options).expect("valid");
        let (triangles, d) = row(&levels, &data.indices, 2.0, 40_000);
        println!("{name} at 2 R by returned errors: {triangles:.0} {d:?}");
        assert!(d.most > 1.2, "{name}: returned errors keep the bound too: {d:?}");
    }
}
