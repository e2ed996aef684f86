//! Baked data of a file, as `cullet info` reports it.

use std::path::Path;
use std::time::Instant;

use cullet::lod::NO_GROUP;
use cullet_command::console::{Console, count, digits, grouped};
use cullet_command::exit::Failure;
use cullet_io::baked::{BakedError, BakedLevels, BakedMesh, LevelKind, Measured, VERSION};
use cullet_io::{BakedFile, BakedFileError, ListedLevels, ListedMesh, Model};
use serde::Serialize;

use crate::names::mesh_name;

/// Baked data of a model.
#[derive(Debug, Serialize)]
pub struct BakedRecord {
    version: u32,
    generator: String,
    /// Bytes of the tables of all meshes.
    bytes: u64,
    /// Whether sums were held against the bytes.
    checked: bool,
    /// Meshes whose levels are left out: damaged, or of another mesh.
    problems: u64,
    /// Why all of it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
    meshes: Vec<BakedMeshRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    groups: Option<GroupsRecord>,
    /// Why merged groups are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    groups_problem: Option<String>,
}

/// Merged groups of instances.
#[derive(Debug, Serialize)]
struct GroupsRecord {
    groups: u64,
    /// Instances that one of them stands for.
    instances: u64,
    triangles: u64,
    /// How many groups have texture coordinates, and how many colours.
    with_uvs: u64,
    with_colors: u64,
    /// Least and largest error, in units of the scene.
    errors: [f32; 2],
    measured: MeasuredRecord,
}

impl BakedRecord {
    /// How many meshes have something baked.
    pub fn meshes_count(&self) -> usize {
        self.meshes.len()
    }
}

#[derive(Debug, Serialize)]
struct BakedMeshRecord {
    mesh: u32,
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<u64>,
    bytes: u64,
    /// Sum of the geometry that it was baked of.
    geometry: String,
    /// Whether sums are right and levels are those of this mesh.
    intact: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
    levels: Vec<LevelsRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    occluders: Option<OccludersRecord>,
    /// Impostor of the mesh in a file that is read as it lies; in a scene it is among the levels.
    #[serde(skip_serializing_if = "Option::is_none")]
    impostor: Option<ImpostorRecord>,
}

/// Pictures of a mesh from all around.
#[derive(Debug, Serialize)]
struct ImpostorRecord {
    grid: u32,
    texels: u32,
    bytes: u64,
    error: f32,
    directions: u32,
}

/// Occluders of a mesh.
#[derive(Debug, Serialize)]
struct OccludersRecord {
    boxes: u64,
    polygons: u64,
    triangles: u64,
    /// The share of the mesh's silhouette that they cover.
    efficiency: f64,
}

/// A chain or a hierarchy.
#[derive(Debug, Serialize)]
struct LevelsRecord {
    /// The number by which a scene that is loaded from the file knows it.
    number: u32,
    kind: &'static str,
    clusters: u64,
    groups: u64,
    /// How many triangles each level has, from the mesh itself to the coarsest. In a hierarchy a
    /// level is what was simplified as often.
    triangles_by_level: Vec<u64>,
    /// Least and largest error of a group, in units of the mesh.
    errors: [f32; 2],
    measured: MeasuredRecord,
}

/// Baked data of a file, without the model.
#[derive(Debug, Serialize)]
pub struct FileRecord {
    schema: u32,
    /// Size of the file.
    pub file_bytes: u64,
    /// Time to open it.
    pub open_seconds: f64,
    /// Baked data of the file.
    pub baked: BakedRecord,
}

#[derive(Debug, Serialize)]
struct MeasuredRecord {
    points: u32,
    reverse_points: u32,
    quantile: f64,
    most_over: f64,
    seed: u64,
}

/// Returns the baked data of a model; `None` where the file has none.
pub fn record(model: &Model) -> Option<BakedRecord> {
    let baked = model.baked.as_ref()?;
    let meshes: Vec<BakedMeshRecord> = baked.meshes.iter().map(|m| mesh(model, m)).collect();
    Some(BakedRecord {
        version: VERSION,
        generator: baked.generator.clone(),
        bytes: baked.meshes.iter().map(|m| m.bytes).sum(),
        checked: true,
        problem: baked.problem.as_ref().map(ToString::to_string),
        problems: meshes.iter().filter(|m| !m.intact).count() as u64,
        meshes,
        groups: groups_of(model),
        groups_problem: None,
    })
}

/// The merged groups of a scene.
fn groups_of(model: &Model) -> Option<GroupsRecord> {
    let (scene, of) = (&model.scene, model.baked.as_ref()?.stand_ins?);
    let mut sums = GroupsRecord::new(&of);
    for slot in scene.stand_in_slots() {
        let mesh = scene.mesh_id(slot);
        let Some(levels) = scene.levels(mesh).first() else { continue };
        let own = &levels.levels;
        let attributes = model.attributes.get(mesh as usize);
        sums.add(
            (0..own.group_count()).map(|g| own.group(g).error),
            scene.mesh(slot).triangle_count().into(),
            attributes.map_or([false; 2], |a| [!a.uvs.is_empty(), !a.colors.is_empty()]),
        );
    }
    let instances = scene.slots().filter(|&slot| scene.stand_in_of(slot).is_some());
    sums.instances = instances.count() as u64;
    (sums.groups > 0).then_some(sums)
}

/// Returns the merged groups of a file that is read as it lies.
fn groups_of_file(file: &BakedFile, check: bool) -> Result<Option<GroupsRecord>, BakedError> {
    let all = file.groups()?;
    let Some(of) = file.groups_measured() else { return Ok(None) };
    if check {
        file.check_groups()?;
    }
    let mut sums = GroupsRecord::new(&of);
    for (number, group) in all.iter().enumerate() {
        let slices = file.group_unchecked(number)?;
        sums.add(
            slices.levels.groups.iter().map(|row| row[4]),
            slices.levels.indices.len() as u64,
            [!slices.uvs.is_empty(), !slices.colors.is_empty()],
        );
        sums.instances += group.instances.len() as u64;
    }
    Ok(Some(sums))
}

impl GroupsRecord {
    fn new(of: &Measured) -> Self {
        let (groups, instances, triangles) = (0, 0, 0);
        let errors = [f32::INFINITY, 0.0];
        let measured = measured(of);
        Self { groups, instances, triangles, with_uvs: 0, with_colors: 0, errors, measured }
    }

    fn add(&mut self, errors: impl Iterator<Item = f32>, triangles: u64, has: [bool; 2]) {
        self.groups += 1;
        self.triangles += triangles;
        self.with_uvs += u64::from(has[0]);
        self.with_colors += u64::from(has[1]);
        errors.for_each(|e| self.errors = [self.errors[0].min(e), self.errors[1].max(e)]);
    }
}

fn mesh(model: &Model, of: &BakedMesh) -> BakedMeshRecord {
    let triangles = model.scene.meshes()[of.mesh as usize].triangle_count();
    BakedMeshRecord {
        mesh: of.mesh,
        name: mesh_name(model, of.mesh),
        triangles: Some(triangles.into()),
        bytes: of.bytes,
        geometry: format!("{:016x}", of.geometry),
        intact: of.problem.is_none(),
        problem: of.problem.as_ref().map(ToString::to_string),
        levels: of.levels.iter().filter_map(|levels| record_of(model, of.mesh, levels)).collect(),
        occluders: of.occluders.as_ref().map(|o| OccludersRecord {
            boxes: o.boxes.len() as u64,
            polygons: o.polygons.len() as u64,
            triangles: o.sheets.iter().map(|s| s.triangles.len() as u64).sum(),
            efficiency: o.efficiency,
        }),
        impostor: None,
    }
}

fn record_of(model: &Model, mesh: u32, of: &BakedLevels) -> Option<LevelsRecord> {
    let all = model.scene.levels(mesh);
    let number = all.iter().position(|levels| levels.mesh == of.held_by)?;
    let levels = &all[number].levels;
    let held_by = &model.scene.meshes()[of.held_by as usize];
    let errors = (0..levels.group_count()).map(|g| levels.group(g).error);
    let triangles: Vec<u32> = held_by.clusters().iter().map(|c| c.triangle_count).collect();
    Some(LevelsRecord {
        number: number as u32 + 1,
        kind: of.kind.name(),
        clusters: triangles.len() as u64,
        groups: levels.group_count() as u64,
        triangles_by_level: by_level(
            &triangles,
            levels.made_from(),
            levels.replaced_by(),
            levels.group_count(),
        ),
        errors: [errors.clone().fold(f32::INFINITY, f32::min), errors.fold(0.0, f32::max)],
        measured: measured(&of.measured),
    })
}

fn measured(of: &Measured) -> MeasuredRecord {
    MeasuredRecord {
        points: of.points,
        reverse_points: of.reverse_points,
        quantile: of.quantile,
        most_over: of.most_over,
        seed: of.seed,
    }
}

/// Returns the baked data of a file, which is mapped: only JSON is read of it, and tables of
/// clusters; with `check` all of them.
///
/// # Errors
/// If it cannot be opened, or nothing is baked in it.
pub fn of_path(path: &Path, check: bool, schema: u32) -> Result<FileRecord, Failure> {
    let start = Instant::now();
    let file = BakedFile::open(path).map_err(|error| match error {
        // It names the file.
        BakedFileError::Map { .. } => Failure::input(error),
        error => Failure::input(format!("{}: {error}", path.display())),
    })?;
    let open_seconds = start.elapsed().as_secs_f64();
    let listed = (0..).zip(file.meshes());
    let meshes: Vec<BakedMeshRecord> =
        listed.map(|(at, mesh)| of_file(&file, at, mesh, check)).collect();
    let (groups, problem) = match groups_of_file(&file, check) {
        Ok(groups) => (groups, None),
        Err(error) => (None, Some(error)),
    };
    Ok(FileRecord {
        schema,
        file_bytes: file.bytes().len() as u64,
        open_seconds,
        baked: BakedRecord {
            version: VERSION,
            generator: file.generator().to_owned(),
            bytes: file.meshes().iter().map(|m| m.bytes).sum(),
            checked: check,
            problem: None,
            problems: meshes.iter().filter(|m| !m.intact).count() as u64,
            meshes,
            groups,
            groups_problem: problem.map(|error| error.to_string()),
        },
    })
}

fn of_file(file: &BakedFile, at: usize, mesh: &ListedMesh, check: bool) -> BakedMeshRecord {
    let mut problem = mesh.problem.clone();
    if check && problem.is_none() {
        problem = file.check(at).err();
    }
    let mut levels = Vec::new();
    if problem.is_none() {
        for (number, of) in mesh.levels.iter().enumerate() {
            match levels_of_file(file, at, number, of) {
                Ok(record) => levels.push(record),
                Err(error) => problem = Some(error),
            }
        }
    }
    let (mut occluders, mut impostor) = (None, None);
    if problem.is_none() {
        match (file.occluders_unchecked(at), file.impostor_unchecked(at)) {
            (Ok(found), Ok(own)) => {
                occluders = found.map(|o| OccludersRecord {
                    boxes: o.boxes.len() as u64,
                    polygons: o.polygons.len() as u64,
                    triangles: o.far().map(|s| u64::from(s[0])).sum(),
                    efficiency: o.efficiency,
                });
                impostor = own.zip(mesh.impostor.as_ref()).map(|(own, listed)| ImpostorRecord {
                    grid: own.grid,
                    texels: own.texels,
                    bytes: listed.table.bytes.len() as u64,
                    error: own.error,
                    directions: listed.measured.points,
                });
            }
            (Err(error), _) | (_, Err(error)) => problem = Some(error),
        }
    }
    let name = match mesh.name.as_str() {
        "" => format!("mesh {}", mesh.number),
        name => name.to_owned(),
    };
    BakedMeshRecord {
        mesh: mesh.number,
        name,
        triangles: None,
        bytes: mesh.bytes,
        geometry: format!("{:016x}", mesh.geometry),
        intact: problem.is_none(),
        problem: problem.as_ref().map(ToString::to_string),
        levels,
        occluders,
        impostor,
    }
}

fn levels_of_file(
    file: &BakedFile,
    at: usize,
    number: usize,
    of: &ListedLevels,
) -> Result<LevelsRecord, BakedError> {
    let slices = file.levels_unchecked(at, number)?;
    let groups = slices.groups.len();
    let known = |group: u32| group == NO_GROUP || (group as usize) < groups;
    if let Some(odd) = slices.clusters.iter().position(|c| !known(c[2]) || !known(c[3])) {
        let message = format!("cluster {odd} names a group beyond the {groups} that there are");
        return Err(BakedError::Form(message));
    }
    let column = |k: usize| -> Vec<u32> { slices.clusters.iter().map(|c| c[k]).collect() };
    Ok(LevelsRecord {
        number: number as u32 + 1,
        kind: of.kind.name(),
        clusters: slices.clusters.len() as u64,
        groups: groups as u64,
        triangles_by_level: by_level(&column(1), &column(2), &column(3), groups),
        errors: of.errors.unwrap_or_default(),
        measured: measured(&of.measured),
    })
}

/// Triangles of clusters by how often they were simplified. Groups of finer ones come first.
fn by_level(triangles: &[u32], made_from: &[u32], replaced_by: &[u32], groups: usize) -> Vec<u64> {
    let mut depth = vec![0_usize; groups];
    let own = |depth: &[usize], c: usize| match made_from[c] {
        NO_GROUP => 0,
        group => depth[group as usize],
    };
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by_key(|&c| replaced_by[c]);
    for &c in order.iter().filter(|&&c| replaced_by[c] != NO_GROUP) {
        let above = replaced_by[c] as usize;
        depth[above] = depth[above].max(own(&depth, c) + 1);
    }
    let mut sums = Vec::new();
    for (c, &count) in triangles.iter().enumerate() {
        let level = own(&depth, c);
        sums.resize(sums.len().max(level + 1), 0);
        sums[level] += u64::from(count);
    }
    sums
}

/// Lines for people; at most `shown` meshes.
pub fn print(baked: &BakedRecord, shown: usize, console: &Console) {
    let by = match baked.generator.as_str() {
        "" => String::new(),
        name => format!(" by {name}"),
    };
    if let Some(problem) = &baked.problem {
        console.line(format!("\nBaked, but left out: {problem}"));
        return;
    }
    let state = match baked.problems {
        0 if !baked.checked => "sums were not looked at, --all does".to_owned(),
        0 => "sums are right".to_owned(),
        n => format!(
            "{} left out",
            count(n, "mesh has levels that are", "meshes have levels that are")
        ),
    };
    let bytes = count(baked.bytes, "byte", "bytes");
    console.line(format!("\nBaked{by}, version {}, {bytes}; {state}:", baked.version));
    for m in baked.meshes.iter().take(shown) {
        let name: String =
            m.name.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
        let triangles = m.triangles.map(|n| count(n, "triangle", "triangles") + ", ");
        let triangles = triangles.unwrap_or_default();
        console.line(format!("  {name}  {triangles}{} bytes", grouped(m.bytes)));
        if let Some(problem) = &m.problem {
            console.line(format!("    {problem}"));
        }
        for l in &m.levels {
            let [least, most] = l.errors.map(|e| digits(e.into()));
            if l.kind == LevelKind::Impostor.name() {
                let seen = count(l.measured.points.into(), "direction", "directions");
                console.line(format!("    {:<10} off by {most}, as seen from {seen}", l.kind));
                continue;
            }
            console.line(format!(
                "    {:<10} {}, {}, off by {least} to {most}",
                l.kind,
                count(l.triangles_by_level.len() as u64, "level", "levels"),
                count(l.groups, "group", "groups"),
            ));
            let steps: Vec<String> = l.triangles_by_level.iter().map(|&n| grouped(n)).collect();
            console.line(format!("    {:<10} {}", "", steps.join(" → ")));
        }
        if let Some(o) = &m.occluders {
            console.line(format!(
                "    {:<10} {}, {}, {}: they hide {:.0} %",
                "occluders",
                count(o.boxes, "box", "boxes"),
                count(o.polygons, "polygon", "polygons"),
                count(o.triangles, "triangle", "triangles"),
                o.efficiency * 100.0
            ));
        }
        if let Some(i) = &m.impostor {
            let seen = count(i.directions.into(), "direction", "directions");
            let error = digits(i.error.into());
            console.line(format!("    {:<10} off by {error}, as seen from {seen}", "impostor"));
        }
    }
    if let Some(problem) = &baked.groups_problem {
        console.line(format!("  merged groups are left out: {problem}"));
    }
    if let Some(g) = &baked.groups {
        let [least, most] = g.errors.map(|e| digits(e.into()));
        console.line(format!(
            "  {} of {}: {} in all levels, off by {least} to {most}",
            count(g.groups, "merged group", "merged groups"),
            count(g.instances, "instance", "instances"),
            count(g.triangles, "triangle", "triangles"),
        ));
        if g.with_uvs + g.with_colors > 0 {
            let [uvs, colors] = [g.with_uvs, g.with_colors].map(grouped);
            console.line(format!("    {uvs} with texture coordinates, {colors} with colours"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_counted_by_how_often_they_were_simplified() {
        // Two groups of the finest, one above both, one of its clusters left over.
        let triangles = [4, 4, 2, 2, 1, 3];
        let made_from = [NO_GROUP, NO_GROUP, 0, 1, 2, NO_GROUP];
        let replaced_by = [0, 1, 2, 2, NO_GROUP, NO_GROUP];
        assert_eq!(by_level(&triangles, &made_from, &replaced_by, 3), [11, 4, 1]);
        assert_eq!(by_level(&[7], &[NO_GROUP], &[NO_GROUP], 0), [7]);
    }
}
