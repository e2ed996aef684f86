//! Visible sets of a scene without rooms: view cells, sampled lines, and how wrong the answer is.

use cullet_bake::sampled::{
    RayTree, RayTreeOptions, SampledSettings, ViewCells, bake_sampled, check_pictures,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = cullet_scenes::build("city")?;
    let tree = RayTree::new(&model.scene, &RayTreeOptions::default())?;
    // Where eyes are: 1 to 2.5 above the lowest point.
    let [mut low, mut high] = tree.bounds();
    (low[1], high[1]) = (low[1] + 1.0, low[1] + 2.5);
    let cells = ViewCells::adaptive(&tree, &[[low, high]], 50, 1)?;
    let pvs = bake_sampled(&tree, &cells, &SampledSettings::default().with_rays(1_000_000), 2)?;
    let mean = pvs.visible_pairs() as f64 / f64::from(cells.len());
    println!("{} cells see {mean:.0} of {} instances each", cells.len(), tree.targets().count());
    let missing = pvs.missing.iter().sum::<f32>() / pvs.missing.len() as f32;
    println!("estimate of what is missing: {:.3} % of looks", missing * 100.0);
    let check = check_pictures(&tree, &cells, &pvs.visible, 20, 32, 1, 2);
    println!("pixels that are wrong in 20 pictures: {:.3} %", check.pixel_error() * 100.0);
    let middle: [f64; 3] = std::array::from_fn(|a| (low[a] + high[a]) * 0.5);
    if let Some(cell) = cells.cell_of(middle) {
        let first: Vec<u32> = pvs.seen_from(cell).take(5).collect();
        println!("from the middle of the city one may see instances {first:?} and others");
    }
    Ok(())
}
