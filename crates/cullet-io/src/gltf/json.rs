//! The JSON of a glTF, as far as geometry, sidedness and cameras go.
//!
//! Every array is first read as raw items, and each item on its own: so an error can name the item
//! it is in, and what is not needed (images, textures) is never read.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Deserialize as Derive;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, Visitor};
use serde_json::value::RawValue;

use crate::ErrorKind;

/// One array of a document, item by item in raw form.
pub(super) type Items<'a> = Option<Vec<&'a RawValue>>;

/// The document.
#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root<'a> {
    pub(super) asset: Option<Asset>,
    pub(super) scene: Option<Index>,
    #[serde(borrow)]
    pub(super) scenes: Items<'a>,
    #[serde(borrow)]
    pub(super) nodes: Items<'a>,
    #[serde(borrow)]
    pub(super) meshes: Items<'a>,
    #[serde(borrow)]
    pub(super) accessors: Items<'a>,
    #[serde(borrow)]
    pub(super) buffer_views: Items<'a>,
    #[serde(borrow)]
    pub(super) buffers: Items<'a>,
    #[serde(borrow)]
    pub(super) materials: Items<'a>,
    #[serde(borrow)]
    pub(super) cameras: Items<'a>,
    #[serde(borrow)]
    pub(super) animations: Items<'a>,
    #[serde(borrow)]
    pub(super) skins: Items<'a>,
    #[serde(default)]
    pub(super) extensions_required: Vec<String>,
    #[serde(borrow)]
    pub(super) extensions: Option<&'a RawValue>,
}

#[derive(Debug, Derive)]
pub(super) struct Asset {
    pub(super) version: String,
}

#[derive(Debug, Derive)]
pub(super) struct SceneItem {
    #[serde(default)]
    pub(super) nodes: Vec<Index>,
}

#[derive(Debug, Derive)]
pub(super) struct NodeItem<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    #[serde(default)]
    pub(super) children: Vec<Index>,
    pub(super) mesh: Option<Index>,
    pub(super) camera: Option<Index>,
    pub(super) skin: Option<Index>,
    pub(super) weights: Option<Vec<Float>>,
    pub(super) matrix: Option<[Float; 16]>,
    pub(super) translation: Option<[Float; 3]>,
    pub(super) rotation: Option<[Float; 4]>,
    pub(super) scale: Option<[Float; 3]>,
    #[serde(default)]
    pub(super) extensions: NodeExtensions,
}

#[derive(Debug, Default, Derive)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(super) instancing: Option<InstancingItem>,
    #[serde(rename = "KHR_node_visibility")]
    pub(super) visibility: Option<Visibility>,
}

#[derive(Debug, Derive)]
pub(super) struct InstancingItem {
    #[serde(default)]
    pub(super) attributes: BTreeMap<String, Index>,
}

#[derive(Debug, Derive)]
pub(super) struct Visibility {
    pub(super) visible: Option<bool>,
}

#[derive(Debug, Derive)]
pub(super) struct MeshItem<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    pub(super) primitives: Vec<PrimitiveItem>,
    #[serde(default)]
    pub(super) weights: Vec<Float>,
}

#[derive(Debug, Derive)]
pub(super) struct PrimitiveItem {
    pub(super) attributes: BTreeMap<String, Index>,
    pub(super) indices: Option<Index>,
    pub(super) material: Option<Index>,
    pub(super) mode: Option<Integer>,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, Index>>,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Derive)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<serde::de::IgnoredAny>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct AccessorItem {
    pub(super) buffer_view: Option<Index>,
    pub(super) byte_offset: Option<Integer>,
    pub(super) component_type: Integer,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: Integer,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<SparseItem>,
    pub(super) min: Option<Vec<Float>>,
    pub(super) max: Option<Vec<Float>>,
}

#[derive(Debug, Derive)]
pub(super) struct SparseItem {
    pub(super) count: Integer,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: Index,
    pub(super) byte_offset: Option<Integer>,
    pub(super) component_type: Integer,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: Index,
    pub(super) byte_offset: Option<Integer>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct ViewItem {
    pub(super) buffer: Index,
    pub(super) byte_offset: Option<Integer>,
    pub(super) byte_length: Integer,
    pub(super) byte_stride: Option<Integer>,
    pub(super) target: Option<Integer>,
    #[serde(default)]
    pub(super) extensions: ViewExtensions,
}

#[derive(Debug, Default, Derive)]
pub(super) struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub(super) meshopt: Option<MeshoptItem>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct MeshoptItem {
    pub(super) buffer: Index,
    pub(super) byte_offset: Option<Integer>,
    pub(super) byte_length: Integer,
    pub(super) byte_stride: Integer,
    pub(super) count: Integer,
    pub(super) mode: String,
    pub(super) filter: Option<String>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferItem<'a> {
    #[serde(borrow)]
    pub(super) uri: Option<Cow<'a, str>>,
    pub(super) byte_length: Integer,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct MaterialItem<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    #[serde(default)]
    pub(super) double_sided: bool,
    pub(super) alpha_mode: Option<String>,
    #[serde(default)]
    pub(super) pbr_metallic_roughness: Pbr,
    #[serde(default)]
    pub(super) extensions: MaterialExtensions,
}

#[derive(Debug, Default, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct Pbr {
    pub(super) base_color_factor: Option<[f32; 4]>,
}

#[derive(Debug, Default, Derive)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_transmission")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    pub(super) glossiness: Option<Glossiness>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct Transmission {
    #[serde(default)]
    pub(super) transmission_factor: f32,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct Glossiness {
    pub(super) diffuse_factor: Option<[f32; 4]>,
}

#[derive(Debug, Derive)]
pub(super) struct CameraItem<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    pub(super) perspective: Option<Perspective>,
    pub(super) orthographic: Option<Orthographic>,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct Perspective {
    pub(super) aspect_ratio: Option<Float>,
    pub(super) yfov: Float,
    pub(super) zfar: Option<Float>,
    pub(super) znear: Float,
}

#[derive(Debug, Derive)]
pub(super) struct Orthographic {
    pub(super) xmag: Float,
    pub(super) ymag: Float,
    pub(super) zfar: Float,
    pub(super) znear: Float,
}

#[derive(Debug, Derive)]
#[serde(rename_all = "camelCase")]
pub(super) struct SkinItem {
    pub(super) joints: Vec<Index>,
    pub(super) inverse_bind_matrices: Option<Index>,
}

#[derive(Debug, Derive)]
pub(super) struct AnimationItem<'a> {
    #[serde(borrow)]
    pub(super) name: Option<Cow<'a, str>>,
    #[serde(default)]
    pub(super) channels: Vec<Channel>,
    #[serde(default)]
    pub(super) samplers: Vec<Sampler>,
}

#[derive(Debug, Derive)]
pub(super) struct Channel {
    pub(super) sampler: Index,
    pub(super) target: Target,
}

#[derive(Debug, Derive)]
pub(super) struct Target {
    pub(super) node: Option<Index>,
    pub(super) path: String,
}

#[derive(Debug, Derive)]
pub(super) struct Sampler {
    pub(super) input: Index,
    pub(super) output: Index,
    pub(super) interpolation: Option<String>,
}

/// A whole number that may be written with a fraction or exponent, as the specification allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Integer(pub(super) u64);

/// An index into one of the document's arrays.
pub(super) type Index = Integer;

impl Integer {
    /// As an index; more than memory can address stays out of every range.
    pub(super) fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Integer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Whole;
        impl Visitor<'_> for Whole {
            type Value = Integer;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a whole number from 0 to 2^53")
            }
            fn visit_u64<E: Error>(self, v: u64) -> Result<Integer, E> {
                Ok(Integer(v))
            }
            fn visit_f64<E: Error>(self, v: f64) -> Result<Integer, E> {
                // Beyond 2^53 an f64 no longer tells whole numbers apart.
                if v.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&v) {
                    return Ok(Integer(v as u64));
                }
                Err(E::invalid_value(serde::de::Unexpected::Float(v), &self))
            }
        }
        deserializer.deserialize_any(Whole)
    }
}

/// A number that may lie beyond f64, then infinite: a parser of JSON would refuse the whole file, but
/// one such transform should not cost the user the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Float(pub(super) f64);

impl<'de> Deserialize<'de> for Float {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let raw = <&RawValue>::deserialize(deserializer)?;
        let number = raw.get().parse().map_err(|_| {
            D::Error::custom(format!("expected a number, found {}", start(raw.get())))
        })?;
        Ok(Self(number))
    }
}

/// Parses the document's outline.
///
/// # Errors
/// If it is no JSON of the right form, or of another version of glTF; or if it holds so many tiny
/// objects that they would swell in memory.
pub(super) fn parse(text: &[u8]) -> Result<Root<'_>, ErrorKind> {
    if text.starts_with(&[0xEF, 0xBB, 0xBF]) {
        return Err(ErrorKind::invalid(
            "JSON",
            "starts with a byte order mark, which glTF forbids: save it as UTF-8 without one",
        ));
    }
    let text = std::str::from_utf8(text).map_err(|e| {
        ErrorKind::invalid("JSON", format!("is not UTF-8 at byte {}", e.valid_up_to()))
    })?;
    if text.trim_ascii().is_empty() {
        return Err(ErrorKind::invalid("JSON", "is empty"));
    }
    // A derived struct would also take an array, field by field.
    if !text.trim_ascii_start().starts_with('{') {
        let found = start(text.trim_ascii_start());
        return Err(ErrorKind::invalid("JSON", format!("expected an object, found {found}")));
    }
    check_density(text)?;
    let root: Root<'_> =
        serde_json::from_str(text).map_err(|e| ErrorKind::invalid("JSON", e.to_string()))?;
    let Some(asset) = &root.asset else {
        return Err(ErrorKind::invalid("JSON", "`asset` is missing: this is not glTF"));
    };
    if !asset.version.starts_with("2.") {
        let shown = start(&asset.version);
        return Err(ErrorKind::Unsupported(format!(
            "glTF version {shown:?}; only 2.x is read. Version 1.0 becomes 2.0 by \
             `gltf-pipeline -i in.gltf -o out.glb`"
        )));
    }
    Ok(root)
}

/// The start of a JSON text on one line, for a message.
fn start(text: &str) -> String {
    let head: String = text.chars().take(100).collect();
    let words: Vec<&str> = head.split_whitespace().collect();
    words.join(" ").chars().take(24).collect()
}

/// An object in memory takes up to some 200 bytes, but `{},` takes three in a file. Real files have
/// more than 16 bytes an object; one with less must be small.
fn check_density(text: &str) -> Result<(), ErrorKind> {
    let count = text.bytes().filter(|&b| b == b'{').count();
    let limit = (1 << 20) + text.len() / 16;
    if count > limit {
        let item = "objects in the JSON".into();
        return Err(ErrorKind::OverLimit { item, count: count as u64, limit: limit as u64 });
    }
    Ok(())
}

/// Parses item `index` of an array; `what` is the array's name in the singular.
///
/// # Errors
/// Names the item and its defect.
pub(super) fn item<'a, T: Deserialize<'a>>(
    raw: &'a RawValue,
    what: &str,
    index: usize,
) -> Result<T, ErrorKind> {
    member(raw, format!("{what} {index}"))
}

/// Parses an object; `name` is what errors call it.
///
/// # Errors
/// Names it and its defect.
pub(super) fn member<'a, T: Deserialize<'a>>(
    raw: &'a RawValue,
    name: String,
) -> Result<T, ErrorKind> {
    let wrong = |message: String| ErrorKind::invalid(name.clone(), message);
    // A derived struct would also take an array, field by field.
    if !raw.get().starts_with('{') {
        return Err(wrong(format!("expected an object, found {}", start(raw.get()))));
    }
    serde_json::from_str(raw.get()).map_err(|e| {
        let message = e.to_string();
        // The position is relative to the item, which would mislead.
        wrong(message.split(" at line ").next().unwrap_or_default().to_owned())
    })
}

/// Parses every item of an array into owned form.
pub(super) fn items<T: DeserializeOwned>(raw: &Items<'_>, what: &str) -> Result<Vec<T>, ErrorKind> {
    raw.iter().flatten().enumerate().map(|(i, raw)| item(raw, what, i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_have_a_fraction_of_zero() {
        for text in ["3", "3.0", "30e-1", "0.3e1"] {
            assert_eq!(serde_json::from_str::<Integer>(text).unwrap(), Integer(3), "{text}");
        }
        for text in ["-1", "0.5", "1e300", "\"3\"", "null", "-1.0"] {
            assert!(serde_json::from_str::<Integer>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_beyond_f64_are_infinite() {
        let v: [Float; 3] = serde_json::from_str("[1e309, -1e309, 2.5]").unwrap();
        assert_eq!(v.map(|v| v.0), [f64::INFINITY, f64::NEG_INFINITY, 2.5]);
        assert!(serde_json::from_str::<Float>("\"inf\"").is_err());
        assert!(serde_json::from_str::<Float>("true").is_err());
    }

    #[test]
    fn errors_name_the_item() {
        let raw: &RawValue = serde_json::from_str(r#"{"componentType": 5126}"#).unwrap();
        let error = item::<AccessorItem>(raw, "accessor", 4).unwrap_err().to_string();
        assert_eq!(error, "accessor 4: missing field `count`");
        let raw: &RawValue = serde_json::from_str(r#"[1]"#).unwrap();
        let error = item::<BufferItem<'_>>(raw, "buffer", 0).unwrap_err().to_string();
        assert_eq!(error, "buffer 0: expected an object, found [1]");
    }

    #[test]
    fn a_swarm_of_empty_objects_is_refused() {
        let text =
            format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{{}}{}]}}"#, ",{}".repeat(2_000_000));
        assert!(matches!(parse(text.as_bytes()), Err(ErrorKind::OverLimit { .. })));
    }
}
