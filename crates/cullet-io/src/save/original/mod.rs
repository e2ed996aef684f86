//! A glTF file as it is, with what was baked of its meshes added.
//!
//! Textures, animations, skins, extras and extensions that nobody here knows stay: of the JSON only
//! what must change is written anew, and the binary buffer grows at its end. What lay in other
//! files is taken into the one that is written, so that it can be moved; what cannot be is left as
//! it is and told.

mod buffers;
mod images;
mod lods;
mod object;
mod strip;

use std::borrow::Cow;
use std::path::Path;

use self::object::{Object, list};
use super::buffer::{ALIGNMENT, File};
use super::{SaveError, SaveErrorKind, SaveFormat, baked, glb, replace};
use crate::beside::Beside;
use crate::gltf::{BAKED, parts};
use crate::json::{self, FromJson, Json};
use crate::{ErrorKind, Model, Warning};

/// Saves the glTF or GLB file `original` as a GLB at `path`, and in it what [`Model::baked`] has of
/// the meshes of `model`, which was loaded from that file. Of what was baked before nothing stays.
/// All else is as it was: JSON that need not change, byte for byte; buffers and images of other
/// files, which are taken in. An existing file is replaced when all has been written, also where it
/// is the original. Meshes that deform have nothing baked. The warnings name what is still outside.
///
/// With `msft_lod` the chains of meshes are also there as nodes, by `MSFT_lod`, for programs that
/// draw those; nodes that have such a list already keep it.
///
/// Costs O(size of the file), and takes its size in memory once.
///
/// # Errors
/// If the ending is not `.glb`, the original cannot be read or is no glTF, the file cannot be
/// written, or it would have more than 4 GiB.
pub fn save_original(
    model: &Model,
    original: &Path,
    path: &Path,
    msft_lod: bool,
) -> Result<Vec<Warning>, SaveError> {
    let write = || -> Result<Vec<Warning>, SaveErrorKind> {
        if SaveFormat::of(path) != Some(SaveFormat::Glb) {
            return Err(SaveErrorKind::Unsupported);
        }
        let of = |kind| SaveErrorKind::Original { path: original.to_owned(), kind };
        let bytes = std::fs::read(original).map_err(|e| of(e.into()))?;
        let folder = original.parent().unwrap_or(Path::new(""));
        let mut warnings = Vec::new();
        let Added { text, bin, others } =
            add(model, bytes, Beside::Folder(folder), msft_lod, &mut warnings).map_err(of)?;
        replace(path, |out| glb::container(text.into_bytes(), &bin, &others, ALIGNMENT, out))?;
        Ok(warnings)
    };
    write().map_err(|kind| SaveError { path: path.to_owned(), kind })
}

/// A file with what was baked.
struct Added {
    text: String,
    bin: Vec<u8>,
    /// Chunks of the container that are neither.
    others: Vec<u8>,
}

fn add(
    model: &Model,
    mut bytes: Vec<u8>,
    beside: Beside<'_>,
    msft_lod: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Added, ErrorKind> {
    let container = parts(&bytes)?;
    let text = std::str::from_utf8(&bytes[container.json.clone()])
        .map_err(|e| ErrorKind::invalid("JSON", e.to_string()))?
        .to_owned();
    let last = container.bin.as_ref().unwrap_or(&container.json).end;
    let others = bytes[last..container.end].to_vec();
    let chunk = container.bin.map(|range| {
        bytes.truncate(range.end);
        bytes.drain(..range.start);
        bytes
    });
    let mut root = Object::parse(&text, "JSON")?;
    let tables = strip::forget(&mut root)?;
    let mut bin = buffers::join(&mut root, chunk, container.is_glb, beside)?;
    if let Some(tables) = tables {
        strip::cut(&mut root, &mut bin, tables)?;
    }
    images::embed(&mut root, &mut bin, beside, warnings)?;
    outside(&root, warnings);
    if msft_lod {
        lods::add(model, &mut root, &mut bin, warnings)?;
    }

    let mut views = list(&root, "bufferViews")?;
    let mut file = File::behind(bin, views.len());
    let number: Vec<Option<usize>> = (0..)
        .zip(model.scene.meshes())
        .map(|(m, mesh): (usize, _)| {
            let own = model.file_meshes.get(m).filter(|_| !mesh.is_deformable());
            own.map(|&number| number as usize)
        })
        .collect();
    if let Some(baked) = baked::write(model, &number, &mut file) {
        views.extend(file.views.iter().map(|view| Cow::Owned(view.to_string())));
        root.set_list("bufferViews", &views);
        let mut meshes = list(&root, "meshes")?;
        for (at, object) in &baked.meshes {
            let Some(text) = meshes.get(*at).map(|text| text.clone().into_owned()) else {
                let message =
                    format!("is mesh {at} of {}: not the file of this model", meshes.len());
                return Err(ErrorKind::invalid(BAKED, message));
            };
            let mut mesh = Object::parse(&text, "mesh")?;
            mesh.change("extensions", &mut |all| {
                all.set(BAKED, object.to_string());
                Ok(())
            })?;
            meshes[*at] = Cow::Owned(mesh.to_text());
        }
        root.set_list("meshes", &meshes);
        root.change("extensions", &mut |all| {
            all.set(BAKED, baked.root.to_string());
            Ok(())
        })?;
        let mut used = list(&root, "extensionsUsed")?;
        used.push(Cow::Owned(format!("\"{BAKED}\"")));
        root.set_list("extensionsUsed", &used);
    }
    let bin = file.bin;
    if !bin.is_empty() {
        buffers::set_length(&mut root, bin.len())?;
    }
    Ok(Added { text: root.to_text(), bin, others })
}

/// Tells what else the file has in other files.
fn outside(root: &Object<'_>, warnings: &mut Vec<Warning>) {
    let known = ["buffers", "images"];
    for (name, text) in root.members().filter(|(name, _)| !known.contains(name)) {
        let Ok(value) = Json::parse(text) else { continue };
        let is_outside =
            |uri: Json<'_>| uri.text().starts_with('"') && !uri.text().starts_with("\"data:");
        if let Some(uri) = any(value, "uri", &is_outside) {
            let uri = uri.text();
            let message = format!(
                "names {uri}, which is not taken into the file: it is looked for beside it"
            );
            warnings.push(Warning { item: name.to_owned(), message });
        }
    }
}

/// The first member of a name, however deep, that is of some kind.
fn any<'a>(value: Json<'a>, name: &str, is: &dyn Fn(Json<'a>) -> bool) -> Option<Json<'a>> {
    let mut left = vec![value];
    while let Some(value) = left.pop() {
        if value.text().starts_with('[') {
            left.extend(Vec::<Json<'_>>::from_json(value).ok()?);
        } else if value.text().starts_with('{') {
            let members = json::Object::from_json(value).ok()?;
            let found = members.members().find(|(own, value)| own == name && is(*value));
            if let Some(&(_, value)) = found {
                return Some(value);
            }
            left.extend(members.members().map(|&(_, value)| value));
        }
    }
    None
}
