//! What was baked before, taken out.

use std::borrow::Cow;

use serde_json::Value;

use super::any;
use super::object::{Object, list};
use crate::ErrorKind;
use crate::baked::TABLE_ALIGNMENT;
use crate::gltf::BAKED;

/// The views of tables: the first, and how many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables {
    first: usize,
    count: usize,
}

/// Takes the extension out of the root and the meshes; the views of its tables, if it says which they are.
pub(super) fn forget(root: &mut Object<'_>) -> Result<Option<Tables>, ErrorKind> {
    let mut found = None;
    if root.get("extensions").is_some_and(|text| text.contains(BAKED)) {
        root.change("extensions", |all| {
            let own: Value = all
                .get(BAKED)
                .map_or(Value::Null, |text| serde_json::from_str(text).unwrap_or(Value::Null));
            let number = |name: &str| usize::try_from(own["bufferViews"][name].as_u64()?).ok();
            found = number("first").zip(number("count"));
            all.remove(BAKED);
            Ok(())
        })?;
    }
    let mut meshes = list(root, "meshes")?;
    let mut changed = false;
    for (m, text) in meshes.iter_mut().enumerate().filter(|(_, text)| text.contains(BAKED)) {
        let own = text.clone().into_owned();
        let mut mesh = Object::parse(&own, &format!("mesh {m}"))?;
        mesh.change("extensions", |all| {
            all.remove(BAKED);
            Ok(())
        })?;
        *text = Cow::Owned(mesh.to_text());
        changed = true;
    }
    if changed {
        root.set_list("meshes", &meshes);
    }
    let mut used = list(root, "extensionsUsed")?;
    let before = used.len();
    used.retain(|name| *name != format!("\"{BAKED}\""));
    if used.len() < before {
        root.set_list("extensionsUsed", &used);
    }
    Ok(found.map(|(first, count)| Tables { first, count }))
}

/// Cuts tables off, views and bytes, where they are the end of the file and nobody else has anything to do with them: so that a
/// file which is baked again does not grow. Where another program has moved them they stay, of use to nobody.
pub(super) fn cut(
    root: &mut Object<'_>,
    bin: &mut Vec<u8>,
    tables: Tables,
) -> Result<(), ErrorKind> {
    let mut views = list(root, "bufferViews")?;
    let Tables { first, count } = tables;
    if count == 0 || first.checked_add(count) != Some(views.len()) {
        return Ok(());
    }
    let mut start = bin.len();
    for text in &views[first..] {
        let view = Object::parse(text, "bufferView")?;
        if view.number("buffer") != Some(0) {
            return Ok(());
        }
        start = start.min(view.number("byteOffset").unwrap_or(0));
    }
    let named = |value: &Value| value.as_f64().is_some_and(|v| v >= first as f64);
    let mut taken = false;
    for (name, text) in root.members() {
        if name == "bufferViews" || !text.contains("bufferView") {
            continue;
        }
        let value =
            serde_json::from_str(text).map_err(|e| ErrorKind::invalid(name, e.to_string()))?;
        taken |= any(&value, "bufferView", &named).is_some();
    }
    for text in &views[..first] {
        let view: Value = serde_json::from_str(text)
            .map_err(|e| ErrorKind::invalid("bufferView", e.to_string()))?;
        // Its own range, and those of extensions.
        let inner = view["extensions"].as_object().into_iter().flat_map(|all| all.values());
        taken |= std::iter::once(&view).chain(inner).any(|of| end(of) > start as f64);
    }
    if !taken && start.is_multiple_of(TABLE_ALIGNMENT) {
        views.truncate(first);
        root.set_list("bufferViews", &views);
        bin.truncate(start);
    }
    Ok(())
}

/// Where a range of buffer 0 ends; 0 where it is of another.
fn end(of: &Value) -> f64 {
    let number = |name: &str| of[name].as_f64();
    match number("buffer") {
        Some(0.0) => number("byteOffset").unwrap_or(0.0) + number("byteLength").unwrap_or(0.0),
        _ => 0.0,
    }
}
