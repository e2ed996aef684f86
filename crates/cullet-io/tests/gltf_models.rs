use cullet_io::{LoadOptions, load};
#[test]
fn explore() {
    for f in std::env::var("FILES").unwrap().split_whitespace() {
        let t = std::time::Instant::now();
        match load(f.as_ref(), &LoadOptions::default()) {
            Ok(m) => {
                let uv: usize = m.scene.meshes().iter().map(|m| m.positions().len()).sum();
                let ut: u64 = m.scene.meshes().iter().map(|m| u64::from(m.triangle_count())).sum();
                let v: usize = m.scene.slots().map(|s| m.scene.mesh(s).positions().len()).sum();
                println!(
                    "{f}: verts {v} ({uv}) tris {} ({ut}) inst {} meshes {} cams {} mats {} {:?} warn {}",
                    m.scene.triangle_count(),
                    m.scene.instance_count(),
                    m.scene.meshes().len(),
                    m.cameras.len(),
                    m.materials.len(),
                    t.elapsed(),
                    m.warnings.len()
                );
                for w in m.warnings.iter().take(5) {
                    println!("   {w}");
                }
            }
            Err(e) => println!("{e}"),
        }
    }
}
