use std::time::Instant;
fn main() {
    let model = cullet_io::scenes::build("forest:n=1000000").unwrap();
    println!("{} instances, meshes {}", model.scene.instance_count(), model.scene.meshes().len());
    let t = Instant::now();
    let bytes = cullet_viewer::web::packed::pack(&model);
    println!("pack {:?} {} MB", t.elapsed(), bytes.len() >> 20);
    let t = Instant::now();
    let mut un = cullet_viewer::web::packed::Unpacker::new(bytes).unwrap();
    println!("new {:?}", t.elapsed());
    let t = Instant::now();
    while un.step().unwrap() {}
    println!("meshes {:?}", t.elapsed());
    let t = Instant::now();
    let m = un.finish().unwrap();
    println!("finish {:?}", t.elapsed());
    let mut scene = cullet::Scene::new();
    for mesh in m.scene.meshes() { scene.add_mesh(mesh.clone()); }
    let mut all: Vec<_> = m.scene.slots().map(|s| (m.scene.handle(s).unwrap().index, s)).collect();
    all.sort_unstable();
    let t = Instant::now();
    for (_, s) in &all { scene.add(cullet::Instance::new(m.scene.mesh_id(*s), *m.scene.transform(*s))).unwrap(); }
    println!("adds {:?}", t.elapsed());
    let t = Instant::now();
    scene.commit();
    println!("commit {:?}", t.elapsed());
    let t = Instant::now();
    scene.rebase([0.0; 3]);
    println!("rebase {:?}", t.elapsed());
    let t = Instant::now();
    let w = cullet_viewer::world::World::new(m, "x".into());
    println!("world {:?}", t.elapsed());
    let gpu = cullet_viewer::headless::Gpu::open().unwrap();
    let mut r = cullet_viewer::draw::Renderer::new(&gpu.adapter, &gpu.device);
    let t = Instant::now();
    r.set_scene(&gpu.device, &gpu.queue, &w.model).unwrap();
    println!("set_scene {:?}", t.elapsed());
    let t = Instant::now();
    w.first_sight([1280, 720]);
    println!("first sight {:?}", t.elapsed());
}
