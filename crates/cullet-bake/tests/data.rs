use cullet::MeshData;
use cullet_bake::clusters::*;
fn load(name: &str) -> MeshData {
    let p = std::path::Path::new("/work/shared/data").join(name);
    let m = cullet_io::load(&p, &cullet_io::LoadOptions{two_sided: Some(false), ..Default::default()}).unwrap();
    let mesh = m.scene.mesh(0);
    MeshData { positions: mesh.positions().to_vec(), indices: mesh.indices()[..(mesh.indices().len() - 3*mesh.degenerate_count() as usize)].to_vec(), parts: vec![cullet::mesh::Part{triangle_count: mesh.triangle_count()-mesh.degenerate_count(), ..Default::default()}], ..MeshData::default() }
}
#[test]
fn exp() {
    for n in ["stanford-bunny/bun_zipper.ply", "armadillo/armadillo.obj"] {
        let d = load(n);
        let b = ClusterOptions::default();
        for test in [16.0] { for (name, o) in [("fast", ClusterOptions::fast()), ("default", b), ("r3", ClusterOptions{rounds: 3, ..b}), ("s60", ClusterOptions{sweeps: 60, ..b}), ("r4s15", ClusterOptions{rounds: 4, sweeps: 15, ..b}),("v256r4s30", ClusterOptions{views:256, rounds: 4, sweeps: 30, ..b}),("v256r2s60", ClusterOptions{views:256, rounds: 2, sweeps: 60, ..b}), ("v256r4s30v.2", ClusterOptions{views:256, rounds: 4, sweeps: 30, vertex_cost: 0.2, ..b})] {
            if test == 24.0 && name == "best" { continue; }
            let t0 = std::time::Instant::now();
            let (c, r) = build_reported(&d, &ClusterOptions { test_cost: test, ..o }, |_| std::ops::ControlFlow::Continue(())).unwrap();
            let t = t0.elapsed();
            let q = Quality::of(&d, &c, 3.0);
            println!("{n} {test} {name}: {} {:.1} ideal {:.2} exact {:.2} {:?} never {} {} dup {:.3} cost {:.3} q {:?}", r.clusters, r.triangles_per_cluster(), q.ideal*100., q.exact*100., t, r.never_culled, r.never_culled_triangles, r.vertex_duplication, r.expected_cost, t0.elapsed()-t);
        }}
    }
}
