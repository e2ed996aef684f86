//! Bakes of meshes: occluders and levels of detail.

use cullet_bake::levels::{ChainOptions, LevelsData, build_chain};
use cullet_bake::occluders::{OccluderOptions, occluders};
use cullet_bake::work::OneRound;
use cullet_io::baked::{
    Baked, BakedLevels, BakedMesh, Container, LevelKind, LevelTables, Measured, Occluders, Tag,
    geometry_hash, hash, write_chunks,
};
use engine::{Mesh, MeshData};

use crate::bake::{Bake, BakeOptions, on_deep_stack};
use crate::memory::Out;
use crate::occluders::give;
use crate::scene::{InCells, SCENES, Scene};
use crate::status::{Error, Result, Status, call};

/// Counted up whenever the same mesh and options give something else.
const VERSION: u32 = 1;

/// Chunks of levels in a unit: triangles of each part, indices, clusters, groups.
const CHUNKS: [Tag; 4] = [*b"PART", *b"TRIS", *b"CLUS", *b"GRPS"];

/// How the errors of a chain are found: `build_chain` has no choice.
const MEASURED: Measured = Measured {
    points: 1,
    reverse_points: 4,
    quantile: 1.0,
    most_over: 1.0,
    seed: 0x6c65_7665_6c73,
};

/// Meshes to bake of: all that have triangles, do not deform and hold no levels of others.
fn meshes_of(scene: &engine::Scene) -> Vec<u32> {
    let all = 0..scene.meshes().len() as u32;
    let mut holds = vec![false; all.len()];
    for mesh in all.clone() {
        scene.levels(mesh).iter().for_each(|levels| holds[levels.mesh as usize] = true);
    }
    let is_own = |&mesh: &u32| {
        let of = &scene.meshes()[mesh as usize];
        !holds[mesh as usize] && of.triangle_count() > 0 && !of.is_deformable()
    };
    all.filter(is_own).collect()
}

/// Makes some bytes of each mesh, as units of a bake.
fn bake_each(
    scene: &engine::Scene,
    meshes: &[u32],
    bake: &Bake<'_>,
    settings: &str,
    make: impl Fn(&Mesh) -> Vec<u8> + Sync,
) -> Result<Vec<Vec<u8>>> {
    let of = |at: usize| &scene.meshes()[meshes[at] as usize];
    let all = || (0..meshes.len()).map(of);
    let mut bytes = format!("{VERSION} {} {settings}", env!("CARGO_PKG_VERSION")).into_bytes();
    for mesh in all() {
        bytes.extend(geometry_hash(mesh).to_le_bytes());
        let sides = mesh.parts().iter().map(|part| (part.two_sided, part.alpha as u8));
        bytes.extend(sides.flat_map(|(two_sided, alpha)| [u8::from(two_sided), alpha]));
    }
    let costs = all().map(|mesh| mesh.triangle_count().into()).collect();
    let mut work = OneRound::new(hash(&bytes), costs, |item| Some(make(of(item as usize))));
    bake.run(&mut work)?;
    // All is done, as the run says.
    work.finish().ok_or_else(crate::bake::stopped)
}

/// The entry of a mesh among those with something baked.
fn entry<'a>(baked: &'a mut Baked, scene: &engine::Scene, mesh: u32) -> &'a mut BakedMesh {
    let at = baked.meshes.iter().position(|one| one.mesh == mesh).unwrap_or_else(|| {
        baked.meshes.push(BakedMesh { mesh, ..BakedMesh::default() });
        baked.meshes.len() - 1
    });
    let one = &mut baked.meshes[at];
    one.geometry = geometry_hash(&scene.meshes()[mesh as usize]);
    one
}

/// Bakes occluders of every mesh, boxes and polygons that hide no more than the mesh does, and gives
/// them to meshes as `cullet_scene_take_occluders` does; `always` and `given` are those of it. Meshes
/// that deform have none. `cullet_scene_save` keeps them. `options` may be NULL; a unit is a mesh.
/// The same on every run and machine. Needs the scene alone. Cost: up to seconds a mesh.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_bake_occluders(
    scene: Scene,
    always: u32,
    options: *const BakeOptions,
    given: *mut u32,
) -> Status {
    call("cullet_bake_occluders", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("given", given, usize::from(!given.is_null())) }?;
        // SAFETY: as the header asks of the caller.
        let bake = unsafe { Bake::of(options) }?;
        if always > 1 {
            return Err(Error::value(format!("always is {always}: it must be 0 or 1")));
        }
        let mut own = SCENES.get_mut(scene.id)?;
        let own = &mut *own;
        let count = on_deep_stack(|| bake_occluders(own, &bake, always))?;
        if out.room() > 0 {
            out.set(0, count);
        }
        Ok(())
    })
}

fn bake_occluders(own: &mut InCells, bake: &Bake<'_>, always: u32) -> Result<u32> {
    let meshes = meshes_of(&own.scene);
    let options = OccluderOptions::default();
    let make = |mesh: &Mesh| occluders(mesh, &options).map(|(made, _)| made.to_bytes());
    // The default options are refused by no mesh.
    let make = |mesh: &Mesh| make(mesh).unwrap_or_default();
    let settings = format!("occluders {options:?}");
    let made = bake_each(&own.scene, &meshes, bake, &settings, make)?;
    let made = made.iter().map(|bytes| Occluders::from_bytes(bytes));
    let made = made.collect::<std::result::Result<Vec<_>, _>>();
    let made = made.map_err(|e| Error::new(Status::File, e.to_string()))?;
    let baked = own.rest.baked.get_or_insert_default();
    for (&mesh, made) in meshes.iter().zip(made) {
        entry(baked, &own.scene, mesh).occluders = Some(made);
    }
    give(own, always)
}

/// Bakes levels of detail of every mesh: the whole mesh again and again, each time with fewer
/// triangles and a measured error. They replace the levels that a mesh has, from whatever source,
/// and are held by meshes of their own, with new numbers: `cullet_scene_levels` lists them. Meshes
/// that deform, or that cannot be simplified, have none. `count` takes how many meshes have some,
/// unless it is NULL. `cullet_scene_save` keeps them. `options` may be NULL; a unit is a mesh. The
/// same on every run and machine. Needs the scene alone; commit it afterwards. Cost: seconds for
/// meshes of a hundred thousand triangles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_bake_levels(
    scene: Scene,
    options: *const BakeOptions,
    count: *mut u32,
) -> Status {
    call("cullet_bake_levels", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("count", count, usize::from(!count.is_null())) }?;
        // SAFETY: as the header asks of the caller.
        let bake = unsafe { Bake::of(options) }?;
        let mut own = SCENES.get_mut(scene.id)?;
        let own = &mut *own;
        let given = on_deep_stack(|| bake_levels(own, &bake))?;
        if out.room() > 0 {
            out.set(0, given);
        }
        Ok(())
    })
}

fn bake_levels(own: &mut InCells, bake: &Bake<'_>) -> Result<u32> {
    let meshes = meshes_of(&own.scene);
    let settings = format!("levels {:?}", ChainOptions::default());
    let made = bake_each(&own.scene, &meshes, bake, &settings, level_bytes)?;
    let built = meshes.iter().zip(&made).map(|(&mesh, bytes)| {
        let tables = tables_of(bytes)?;
        tables.map(|tables| tables.build(&own.scene.meshes()[mesh as usize])).transpose()
    });
    let built = built.collect::<std::result::Result<Vec<_>, _>>();
    let built = built.map_err(|e| Error::new(Status::File, e.to_string()))?;
    let InCells { scene, rest, .. } = own;
    let mut given = 0;
    for (&mesh, made) in meshes.iter().zip(built) {
        scene.clear_levels(mesh);
        let baked = entry(rest.baked.get_or_insert_default(), scene, mesh);
        for before in std::mem::take(&mut baked.levels) {
            // Nothing else has the mesh that held them, or it stays.
            let _ = scene.remove_mesh(before.held_by);
        }
        let Some((held, levels)) = made else { continue };
        let held_by = scene.add_mesh(held);
        let added = scene.add_levels(mesh, held_by, levels);
        added.map_err(|e| Error::new(Status::Mesh, e.to_string()))?;
        baked.levels.push(BakedLevels { kind: LevelKind::Chain, held_by, measured: MEASURED });
        let name = format!("{}, levels", rest.mesh_names.get(mesh as usize).map_or("", |n| n));
        let names = rest.mesh_names.len().max(held_by as usize + 1);
        rest.mesh_names.resize(names, String::new());
        rest.mesh_names[held_by as usize] = name;
        given += 1;
    }
    Ok(given)
}

/// Levels of a mesh as the bytes of a unit; none where it cannot be simplified.
fn level_bytes(mesh: &Mesh) -> Vec<u8> {
    let data = MeshData { polygons: 0, ..mesh.to_data() };
    let made = build_chain(&data, &ChainOptions::default()).and_then(LevelsData::into_levels);
    let tables = made.ok().and_then(|(held, levels)| LevelTables::of(&held, &levels));
    let Some(tables) = tables.filter(|tables| !tables.groups.is_empty()) else {
        return Vec::new();
    };
    let parts: Vec<u8> = tables.parts.iter().flat_map(|n| n.to_le_bytes()).collect();
    let [indices, clusters, groups] = tables.to_bytes();
    let chunks = [&parts, &indices, &clusters, &groups];
    let named: Vec<(Tag, &[u8])> =
        CHUNKS.into_iter().zip(chunks.into_iter().map(Vec::as_slice)).collect();
    write_chunks(&named)
}

/// The levels in such bytes.
fn tables_of(
    bytes: &[u8],
) -> std::result::Result<Option<LevelTables>, cullet_io::baked::BakedError> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let broken =
        |e: cullet_io::baked::ContainerError| cullet_io::baked::BakedError::Form(e.to_string());
    let file = Container::open(bytes).map_err(broken)?;
    let [parts, indices, clusters, groups] = CHUNKS.map(|tag| file.chunk(tag));
    let parts = parts.map_err(broken)?.as_chunks::<4>().0;
    let parts = parts.iter().map(|n| u32::from_le_bytes(*n)).collect();
    let tables = [indices.map_err(broken)?, clusters.map_err(broken)?, groups.map_err(broken)?];
    LevelTables::from_bytes(parts, tables).map(Some)
}
