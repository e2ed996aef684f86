//! Baked files as other programs read them: the validator of Khronos, and three.js.

use std::fs;
use std::path::Path;

use crate::plain;
use crate::runner::{End, Ended, all};
use crate::tools::{command, run, target};
use crate::web;

/// The script and the packages that it needs, from the root.
const FOLDER: &str = "programs/cullet-baker/tests/readers";
const WHAT: &str = "baked files in gltf-validator and three.js";
/// A small one with many materials, and cells, whose rooms are instances to be merged.
const SCENE: &str = "office:floors=1,corridors=1,rooms=4";

/// The step of `test`: a generated scene is baked with all that can be baked of it, and once more
/// as a glTF that stays as it is, and both are read.
pub(crate) fn test() -> Ended {
    let mut node = match web::script(FOLDER, "readers.mjs", WHAT)? {
        Ok(node) => node,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    let baker = plain::program("cullet-baker")?;
    let folder = target().join("readers");
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let place = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let [first, second, record] = ["baked.glb", "again.glb", "record.json"].map(place);
    let all_of_it = ["--merge", "--impostors", "--occluders", "--quiet"];
    let bake = |from: &str, to: &str, more: &[&str]| {
        let words = [&["bake", from, "-o", to][..], &all_of_it, more].concat();
        run(command(&baker.to_string_lossy(), &words))
    };
    bake(SCENE, &first, &["--json", &record])?;
    bake(&first, &second, &["--msft-lod"])?;
    node.arg(triangles(Path::new(&record))?).args([first, second]);
    all(run(node))
}

/// How many triangles the baker counted.
fn triangles(record: &Path) -> Result<String, String> {
    let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", record.display());
    let text = fs::read_to_string(record).map_err(|e| fail(&e))?;
    let record: serde_json::Value = serde_json::from_str(&text).map_err(|e| fail(&e))?;
    let count = record["triangles"].as_u64().filter(|&count| count > 0);
    count.map(|count| count.to_string()).ok_or_else(|| fail(&"no triangles were baked"))
}
