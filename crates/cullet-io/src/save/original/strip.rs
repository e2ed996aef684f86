//! Removal of data that was baked before.

use std::borrow::Cow;

use super::any;
use super::object::{Object, list};
use crate::ErrorKind;
use crate::baked::TABLE_ALIGNMENT;
use crate::gltf::BAKED;
use crate::json::{FromJson, Json};

/// The views of tables: the first, and how many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tables {
    first: usize,
    count: usize,
}

/// Takes the extension out of the root and the meshes; the views of its tables, if it says which
/// they are.
pub(super) fn forget(root: &mut Object<'_>) -> Result<Option<Tables>, ErrorKind> {
    let mut found = None;
    if root.get("extensions").is_some_and(|text| text.contains(BAKED)) {
        root.change("extensions", &mut |all| {
            let own = all.get(BAKED).and_then(|text| Object::parse(text, BAKED).ok());
            let views = own.as_ref().and_then(|own| own.get("bufferViews"));
            let views = views.and_then(|text| Object::parse(text, BAKED).ok()).unwrap_or_default();
            found = views.number("first").zip(views.number("count"));
            all.remove(BAKED);
            Ok(())
        })?;
    }
    let mut meshes = list(root, "meshes")?;
    let mut changed = false;
    for (m, text) in meshes.iter_mut().enumerate().filter(|(_, text)| text.contains(BAKED)) {
        let own = text.clone().into_owned();
        let mut mesh = Object::parse(&own, &format!("mesh {m}"))?;
        mesh.change("extensions", &mut |all| {
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

/// Cuts tables off, views and bytes, where they are the end of the file and nobody else has
/// anything to do with them: so that a file which is baked again does not grow. Where another
/// program has moved them they stay, of use to nobody.
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
    let named = |value: Json<'_>| f64::from_json(value).is_ok_and(|v| v >= first as f64);
    let mut taken = false;
    for (name, text) in root.members() {
        if name == "bufferViews" || !text.contains("bufferView") {
            continue;
        }
        let value = Json::parse(text).map_err(|message| ErrorKind::invalid(name, message))?;
        taken |= any(value, "bufferView", &named).is_some();
    }
    for text in &views[..first] {
        let view = Object::parse(text, "bufferView")?;
        taken |= end(&view) > start;
        // Its own range, and those of extensions.
        let inner = view.get("extensions").and_then(|text| Object::parse(text, "extensions").ok());
        for (_, text) in inner.iter().flat_map(Object::members) {
            taken |= Object::parse(text, "extension").is_ok_and(|of| end(&of) > start);
        }
    }
    if !taken && start.is_multiple_of(TABLE_ALIGNMENT) {
        views.truncate(first);
        root.set_list("bufferViews", &views);
        bin.truncate(start);
    }
    Ok(())
}

/// Where a range of buffer 0 ends; 0 where it is of another.
fn end(of: &Object<'_>) -> usize {
    let number = |name: &str| of.number(name).unwrap_or(0);
    match of.number("buffer") {
        Some(0) => number("byteOffset").saturating_add(number("byteLength")),
        _ => 0,
    }
}
