//! Instances that stand for others, in files and back.

use cullet::lod::Lod;
use cullet::mesh::{Clustering, Part};
use cullet::{Culler, Instance, Mesh, MeshData, Output, Scene, Stage, Transform, Visible};
use cullet_io::baked::{Baked, BakedError, LevelTables, Measured};
use cullet_io::{Attributes, BakedFile, LoadOptions, Model, load_bytes, save};
use cullet_testkit::answers::cull;
use cullet_testkit::steps::Balls;
use cullet_testkit::views::look;

/// Twelve balls in three clumps that stand for four each, and one for all.
fn clumps() -> Model {
    let mut scene = Scene::new();
    let ball = Balls::new(&[16, 8, 5], 1.0).add_to(&mut scene);
    scene.clear_levels(ball);
    let mut balls = Vec::new();
    for at in 0..12 {
        let place = [f64::from(at) * 2.5, 0.0, f64::from(at % 4)];
        balls.push(scene.add(Instance::new(ball, Transform::from_translation(place))).unwrap());
    }
    // A mesh that holds its own levels, as merged ones do.
    let mut merged = |size: f64, place: [f64; 3], members: &[cullet::Handle]| {
        let Balls { coarse, levels, .. } = Balls::new(&[12, 9, 4], 0.3 * size);
        let indices = coarse.indices().to_vec();
        let order = (0..coarse.triangle_count()).collect();
        let clustering = Clustering { order, clusters: coarse.clusters().to_vec() };
        let positions = coarse.positions().iter().map(|p| p.map(|v| v * size as f32)).collect();
        // Drawn like the balls.
        let two_sided = scene.meshes()[ball as usize].is_two_sided();
        let parts = coarse.parts().iter().map(|p| Part { two_sided, ..*p }).collect();
        let data = MeshData { positions, indices, parts, ..MeshData::default() };
        let scaled = Mesh::with_clusters(data, &clustering).unwrap();
        let groups: Vec<_> = (0..levels.group_count())
            .map(|g| cullet::lod::Group { radius: size as f32, ..levels.group(g) })
            .collect();
        let (from, by) = (levels.made_from().to_vec(), levels.replaced_by().to_vec());
        let levels = cullet::lod::Levels::new(&scaled, &groups, from, by).unwrap();
        let mesh = scene.add_mesh(scaled);
        scene.add_levels(mesh, mesh, levels).unwrap();
        let own = scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap();
        scene.stand_for(own, members).unwrap();
        own
    };
    let clumps: Vec<_> = (0..3)
        .map(|c| merged(6.0, [f64::from(c) * 10.0 + 4.0, 0.0, 1.5], &balls[c as usize * 4..][..4]))
        .collect();
    merged(20.0, [14.0, 0.0, 1.5], &clumps);
    scene.sort();
    let measured =
        Measured { points: 2, reverse_points: 4, quantile: 1.0, most_over: 1.0, seed: 5 };
    let baked = Baked { stand_ins: Some(measured), ..Baked::default() };
    Model { name: "clumps".into(), scene, baked: Some(baked), ..Model::default() }
}

fn drawn(scene: &Scene, far: f64) -> Visible {
    let view = look([14.0, 3.0, far], [14.0, 0.0, 0.0], [800, 500]);
    let lod = Some(Lod::default());
    let culler = Culler::default().with_lod(lod).with_output(Output::Triangles);
    cull(&culler.only(Stage::Lod), scene, &view)
}

fn saved(model: &Model, name: &str) -> Vec<u8> {
    let folder =
        std::env::temp_dir().join(format!("cullet-stand-ins-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("out.glb");
    save(model, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    bytes
}

fn loaded(bytes: &[u8]) -> Model {
    load_bytes("clumps.glb", bytes, &LoadOptions::default()).unwrap()
}

#[test]
fn what_is_loaded_stands_for_the_same() {
    let model = clumps();
    let bytes = saved(&model, "same");
    let back = loaded(&bytes);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    assert_eq!(back.scene.instance_count(), 12);
    assert_eq!(back.scene.stand_in_slots().count(), 4);
    assert_eq!(
        back.baked.as_ref().and_then(|b| b.stand_ins),
        model.baked.as_ref().and_then(|b| b.stand_ins)
    );
    let counts = |scene: &Scene| {
        [5.0, 300.0, 900.0, 3000.0, 20_000.0].map(|far| {
            let found = drawn(scene, far);
            (found.triangle_count, found.instance_count)
        })
    };
    let found = counts(&back.scene);
    assert_eq!(found, counts(&model.scene));
    assert!(found[0].1 == 12 && found[4].1 == 1, "{found:?}");
    // And again, byte for byte.
    let again = saved(&back, "again");
    assert!(saved(&loaded(&again), "once more") == again);
}

#[test]
fn texture_coordinates_and_colours_come_back() {
    let mut model = clumps();
    let slot = model.scene.stand_in_slots().next().unwrap();
    let mesh = model.scene.mesh_id(slot) as usize;
    let vertices = model.scene.meshes()[mesh].positions().len();
    let own = Attributes {
        uvs: (0..vertices).map(|v| [v as f32, -0.5]).collect(),
        colors: (0..vertices).map(|v| [0.25, v as f32, 0.0, 1.0]).collect(),
        ..Attributes::default()
    };
    model.attributes.resize(mesh, Attributes::default());
    model.attributes.push(own.clone());
    let bytes = saved(&model, "attributes");
    let with = |details| {
        let options = LoadOptions { details, ..LoadOptions::default() };
        load_bytes("clumps.glb", &bytes, &options).unwrap()
    };
    let back = with(true);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let found: Vec<_> = back.scene.stand_in_slots().map(|s| back.scene.mesh_id(s)).collect();
    assert_eq!(back.attributes[found[0] as usize], own);
    assert!(
        found[1..]
            .iter()
            .all(|&m| back.attributes.get(m as usize).is_none_or(Attributes::is_empty))
    );
    assert!(with(false).attributes.is_empty());
    let again = saved(&back, "attributes again");
    let details = LoadOptions { details: true, ..LoadOptions::default() };
    let third = load_bytes("clumps.glb", &again, &details).unwrap();
    assert_eq!(third.attributes[found[0] as usize], own);
    assert!(saved(&third, "attributes once more") == again);
    // Their sum is their own.
    let at = bytes
        .windows(16)
        .rposition(|w| w == [0.25_f32, 1.0, 0.0, 1.0].map(f32::to_le_bytes).as_flattened());
    let mut odd = bytes.clone();
    odd[at.unwrap() + 3] ^= 1;
    let told = load_bytes("clumps.glb", &odd, &details).unwrap().warnings;
    assert!(told[0].message.contains("attributes of a stand-in"), "{told:?}");
    assert!(load_bytes("clumps.glb", &odd, &LoadOptions::default()).unwrap().warnings.is_empty());
}

#[test]
fn a_mapped_file_has_the_groups_as_they_lie() {
    let mut model = clumps();
    let slots: Vec<u32> = model.scene.stand_in_slots().collect();
    let mesh = model.scene.mesh_id(slots[1]) as usize;
    let uvs = vec![[0.5, 0.25]; model.scene.meshes()[mesh].positions().len()];
    model.attributes.resize(mesh, Attributes::default());
    model.attributes.push(Attributes { uvs: uvs.clone(), ..Attributes::default() });
    let bytes = saved(&model, "mapped");
    let mut words = vec![0u64; bytes.len().div_ceil(8)];
    let mapped = |bytes: &[u8], words: &mut [u64]| {
        bytemuck::cast_slice_mut(words)[..bytes.len()].copy_from_slice(bytes);
    };
    mapped(&bytes, &mut words);
    let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()]).unwrap();
    let groups = file.groups().unwrap();
    assert_eq!(
        (groups.len(), file.groups_measured()),
        (4, model.baked.as_ref().unwrap().stand_ins)
    );
    for (number, (group, &slot)) in groups.iter().zip(&slots).enumerate() {
        let held_by = model.scene.mesh(slot);
        let slices = file.group(number).unwrap();
        assert_eq!(slices.positions, held_by.positions());
        let levels = &model.scene.levels(model.scene.mesh_id(slot))[0].levels;
        let own = LevelTables::of(held_by, levels).unwrap();
        assert_eq!(slices.levels.to_tables().unwrap(), own);
        assert_eq!(slices.uvs, if number == 1 { &uvs[..] } else { &[] });
        assert!(slices.colors.is_empty());
        let whole: u64 = model
            .scene
            .stood_for_by(slot)
            .iter()
            .map(|&s| u64::from(model.scene.mesh(s).triangle_count()))
            .sum();
        assert_eq!(group.triangles, whole);
        assert_eq!(
            (group.instances.len(), group.groups.len()),
            if number < 3 { (4, 0) } else { (0, 3) }
        );
    }
    assert!(matches!(file.group(4), Err(BakedError::Form(_))));
    // The last table is that of the last group's groups: one byte of it, and no group is given out.
    let mut odd = bytes.clone();
    odd[groups[3].tables[2].start] ^= 4;
    let end = groups[1].attributes.as_ref().unwrap().0[0].start;
    mapped(&odd, &mut words);
    let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..bytes.len()]).unwrap();
    assert!(matches!(file.group(0), Err(BakedError::Damaged { .. })));
    assert!(file.group_unchecked(0).is_ok());
    let mut odd = bytes;
    odd[end] ^= 4;
    mapped(&odd, &mut words);
    let file = BakedFile::of(&bytemuck::cast_slice::<u64, u8>(&words)[..odd.len()]).unwrap();
    assert!(matches!(file.check_groups(), Err(BakedError::Damaged { .. })));
}

#[test]
fn one_that_was_switched_off_is_not_written() {
    let mut model = clumps();
    let slot = model.scene.slots().next().unwrap();
    let handle = model.scene.handle(slot).unwrap();
    model.scene.set_transform(handle, Transform::from_translation([0.0, 50.0, 0.0])).unwrap();
    let back = loaded(&saved(&model, "off"));
    assert_eq!(back.scene.stand_in_slots().count(), 2);
}

#[test]
fn what_is_damaged_or_does_not_fit_is_left_out_and_told() {
    let bytes = saved(&clumps(), "damaged");
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let text = std::str::from_utf8(&bytes[20..20 + length]).unwrap();
    let told = |bytes: &[u8]| {
        let model = loaded(bytes);
        assert_eq!(model.scene.stand_in_slots().count(), 0);
        assert_eq!(model.scene.instance_count(), 12);
        assert!(drawn(&model.scene, 20_000.0).instance_count == 12);
        model.warnings.iter().map(|w| w.message.clone()).collect::<Vec<_>>().join("; ")
    };
    // One byte of a table.
    let mut flipped = bytes.clone();
    let last = flipped.len() - 40;
    flipped[last] ^= 4;
    assert!(told(&flipped).contains("damaged"), "{}", told(&flipped));
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from) && from.len() == to.len(), "{from} in {text}");
        let mut out = bytes.clone();
        out[20..20 + length].copy_from_slice(text.replacen(from, to, 1).as_bytes());
        out
    };
    let at = text.find("\"instances\":[").unwrap();
    let digit = &text[at..at + 14];
    let other = format!("{}9", &digit[..13]);
    assert!(told(&changed(digit, &other)).contains("damaged"));
    let told_of = |from: &str, to: &str| told(&changed(from, to));
    assert!(told_of("\"positions\":", "\"positionz\":").contains("positions"));
}
