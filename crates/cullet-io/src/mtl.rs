//! MTL, the materials of OBJ: names, diffuse colours and what alpha does. Nothing else is read.

use std::collections::HashMap;
use std::path::Path;

use cullet::mesh::Alpha;

use crate::Material;
use crate::beside::{Beside, Missing};
use crate::blocks::Source;
use crate::text::Cursor;

/// A material of a library.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MtlMaterial {
    pub(crate) color: [f32; 4],
    pub(crate) alpha: Alpha,
    /// How many textures it names.
    pub(crate) textures: u32,
}

impl Default for MtlMaterial {
    fn default() -> Self {
        Self { color: Material::GREY, alpha: Alpha::Opaque, textures: 0 }
    }
}

/// Materials by name.
pub(crate) type Library = HashMap<Vec<u8>, MtlMaterial>;

/// The most bytes of a library: materials are a few hundred bytes each.
const LIMIT: u64 = 64 << 20;

/// Reads a library beside a model.
///
/// # Errors
/// Why it cannot be read, in words.
pub(crate) fn read(beside: Beside<'_>, name: &[u8], library: &mut Library) -> Result<(), String> {
    let text = std::str::from_utf8(name).map_err(|_| "its name is not UTF-8".to_owned())?;
    // Files made on Windows have its separators.
    let try_one = |text: &str| beside.read(Path::new(text), LIMIT + 1);
    let read = match try_one(text) {
        Ok(read) => Ok(read),
        Err(_) => try_one(&text.replace('\\', "/")),
    };
    let (bytes, size) = read.map_err(|missing| match (missing, beside) {
        (Missing::Unread(e), _) => e.to_string(),
        (_, Beside::Folder(_) | Beside::Below(..)) => "there is no such file".to_owned(),
        (_, Beside::Given(_)) => "it was not given together with the model".to_owned(),
    })?;
    if size > LIMIT {
        return Err(format!("it exceeds the limit of {LIMIT} bytes"));
    }
    parse(&bytes, library);
    Ok(())
}

/// Parses a library into `library`; the first material of a name stays. What cannot be read as a
/// colour or an alpha is passed over: materials never stop a model.
pub(crate) fn parse(bytes: &[u8], library: &mut Library) {
    let mut c = Cursor::with_continuations(Source::memory(bytes));
    let mut current: Option<(Vec<u8>, MtlMaterial)> = None;
    let mut keep = |material: Option<(Vec<u8>, MtlMaterial)>| {
        if let Some((name, material)) = material {
            library.entry(name).or_insert(material);
        }
    };
    // Bytes in memory can always be read.
    while c.more().unwrap_or(false) {
        c.skip_blanks();
        let word = c.token().to_vec();
        if word.eq_ignore_ascii_case(b"newmtl") {
            keep(current.take());
            current = Some((c.rest_of_line(), MtlMaterial::default()));
        } else if let Some((_, material)) = &mut current {
            material.textures += u32::from(word.starts_with(b"map_"));
            match &word[..] {
                b"Kd" => {
                    // "Kd spectral file" and "Kd xyz ..." are colours too, but not ours to read.
                    let mut rgb = [0.0; 3];
                    let read = rgb.iter_mut().all(|v| {
                        c.skip_blanks();
                        c.f32().filter(|f| f.is_finite()).map(|f| *v = f).is_some()
                    });
                    if read {
                        material.color[..3].copy_from_slice(&rgb);
                    }
                }
                b"d" | b"Tr" => {
                    c.skip_blanks();
                    // "d -halo 0.5" fades by angle: still see-through.
                    let start = c.offset();
                    if c.token() != b"-halo" {
                        c.seek(start);
                    }
                    set_alpha(material, &word, &mut c);
                }
                b"map_d" => material.alpha = Alpha::Masked,
                _ => {}
            }
        }
        c.skip_line();
    }
    keep(current);
}

fn set_alpha(material: &mut MtlMaterial, word: &[u8], c: &mut Cursor<'_>) {
    c.skip_blanks();
    let Some(value) = c.f32().filter(|f| f.is_finite()) else { return };
    let alpha = if word == b"Tr" { 1.0 - value } else { value };
    material.color[3] = alpha.clamp(0.0, 1.0);
    // A cut-out stays a cut-out.
    if alpha < 1.0 && material.alpha == Alpha::Opaque {
        material.alpha = Alpha::Blended;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Library {
        let mut library = Library::new();
        parse(text.as_bytes(), &mut library);
        library
    }

    #[test]
    fn reads_names_colours_and_alpha() {
        let library = parsed(
            "# a library\nnewmtl red paint\nKd 1 0.25 0\nnewmtl glass\r\n\td 0.5\r\nKd 0 0 1\n\
             newmtl fence\nmap_d leaf.png\nd 0.9\nnewmtl smoke\nTr 0.75\nnewmtl halo\nd -halo 0.5\n",
        );
        let get = |name: &str| library[name.as_bytes()];
        assert_eq!(
            get("red paint"),
            MtlMaterial { color: [1.0, 0.25, 0.0, 1.0], ..MtlMaterial::default() }
        );
        assert_eq!(
            get("glass"),
            MtlMaterial { color: [0.0, 0.0, 1.0, 0.5], alpha: Alpha::Blended, textures: 0 }
        );
        assert_eq!(get("fence").alpha, Alpha::Masked);
        assert_eq!((get("smoke").color[3], get("smoke").alpha), (0.25, Alpha::Blended));
        assert_eq!((get("halo").color[3], get("halo").alpha), (0.5, Alpha::Blended));
    }

    #[test]
    fn invalid_lines_are_passed_over() {
        let library =
            parsed("Kd 1 1 1\nnewmtl a\nKd spectral file.rfl 1\nd nan\nKd 1 x\n\x00\x7f\n");
        assert_eq!(library[&b"a"[..]], MtlMaterial::default());
        assert_eq!(library.len(), 1);
    }
}
