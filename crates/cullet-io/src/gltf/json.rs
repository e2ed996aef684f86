//! The JSON of a glTF, as far as geometry, sidedness and cameras go.
//!
//! Every item of an array is read on its own: so an error can name the item it is in, and what is
//! not needed (images, textures) is never read.

use std::borrow::Cow;

use crate::ErrorKind;
use crate::from_json;
use crate::json::{FromJson, Json, Object, start};

pub(super) use crate::json::Integer;

/// An index into one of the document's arrays.
pub(super) type Index = Integer;

/// One array of a document, item by item.
pub(super) type Items<'a> = Option<Vec<Json<'a>>>;

/// The document.
#[derive(Debug)]
pub(super) struct Root<'a> {
    pub(super) textures: Items<'a>,
    pub(super) scene: Option<Index>,
    pub(super) scenes: Items<'a>,
    pub(super) nodes: Items<'a>,
    pub(super) meshes: Items<'a>,
    pub(super) accessors: Items<'a>,
    pub(super) buffer_views: Items<'a>,
    pub(super) buffers: Items<'a>,
    pub(super) materials: Items<'a>,
    pub(super) cameras: Items<'a>,
    pub(super) animations: Items<'a>,
    pub(super) skins: Items<'a>,
    pub(super) extensions_required: Vec<String>,
    /// Empty where the list is malformed.
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions: Option<Json<'a>>,
}

/// Members that name accessors.
#[derive(Debug, Default)]
pub(super) struct Attributes<'a>(pub(super) Vec<(Cow<'a, str>, Index)>);

impl Attributes<'_> {
    /// The accessor of an attribute.
    pub(super) fn get(&self, name: &str) -> Option<Index> {
        self.0.iter().rev().find(|(n, _)| n == name).map(|&(_, index)| index)
    }
}

impl<'a> FromJson<'a> for Attributes<'a> {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        let mut all = Vec::new();
        for (name, to) in Object::from_json(json)?.members() {
            all.push((name.clone(), Index::from_json(*to)?));
        }
        Ok(Self(all))
    }
}

from_json! {
    pub(super) struct SceneItem {
        nodes: Vec<Index> = or_default("nodes"),
    }

    pub(super) struct NodeItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        children: Vec<Index> = or_default("children"),
        mesh: Option<Index> = get("mesh"),
        camera: Option<Index> = get("camera"),
        skin: Option<Index> = get("skin"),
        weights: Option<Vec<f64>> = get("weights"),
        matrix: Option<[f64; 16]> = get("matrix"),
        translation: Option<[f64; 3]> = get("translation"),
        rotation: Option<[f64; 4]> = get("rotation"),
        scale: Option<[f64; 3]> = get("scale"),
        instancing: Option<InstancingItem<'a>> = extension("EXT_mesh_gpu_instancing"),
        visibility: Option<Visibility> = extension("KHR_node_visibility"),
    }

    pub(super) struct InstancingItem<'a> {
        attributes: Attributes<'a> = or_default("attributes"),
    }

    pub(super) struct Visibility {
        visible: Option<bool> = get("visible"),
    }

    pub(super) struct MeshItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        primitives: Vec<PrimitiveItem<'a>> = need("primitives"),
        weights: Vec<f64> = or_default("weights"),
    }

    pub(super) struct PrimitiveItem<'a> {
        attributes: Attributes<'a> = need("attributes"),
        indices: Option<Index> = get("indices"),
        material: Option<Index> = get("material"),
        mode: Option<Integer> = get("mode"),
        targets: Vec<Attributes<'a>> = or_default("targets"),
        draco: Option<Json<'a>> = extension("KHR_draco_mesh_compression"),
    }

    pub(super) struct AccessorItem<'a> {
        buffer_view: Option<Index> = get("bufferView"),
        byte_offset: Option<Integer> = get("byteOffset"),
        component_type: Integer = need("componentType"),
        normalized: bool = or_default("normalized"),
        count: Integer = need("count"),
        kind: Cow<'a, str> = need("type"),
        sparse: Option<SparseItem> = get("sparse"),
        min: Option<Vec<f64>> = get("min"),
        max: Option<Vec<f64>> = get("max"),
    }

    pub(super) struct SparseItem {
        count: Integer = need("count"),
        indices: SparseIndices = need("indices"),
        values: SparseValues = need("values"),
    }

    pub(super) struct SparseIndices {
        buffer_view: Index = need("bufferView"),
        byte_offset: Option<Integer> = get("byteOffset"),
        component_type: Integer = need("componentType"),
    }

    pub(super) struct SparseValues {
        buffer_view: Index = need("bufferView"),
        byte_offset: Option<Integer> = get("byteOffset"),
    }

    pub(super) struct ViewItem<'a> {
        buffer: Index = need("buffer"),
        byte_offset: Option<Integer> = get("byteOffset"),
        byte_length: Integer = need("byteLength"),
        byte_stride: Option<Integer> = get("byteStride"),
        target: Option<Integer> = get("target"),
        meshopt: Option<MeshoptItem<'a>> = extension("EXT_meshopt_compression"),
        meshopt_of_khronos: Option<MeshoptItem<'a>> = extension("KHR_meshopt_compression"),
    }

    pub(super) struct MeshoptItem<'a> {
        buffer: Index = need("buffer"),
        byte_offset: Option<Integer> = get("byteOffset"),
        byte_length: Integer = need("byteLength"),
        byte_stride: Integer = need("byteStride"),
        count: Integer = need("count"),
        mode: Cow<'a, str> = need("mode"),
        filter: Option<Cow<'a, str>> = get("filter"),
    }

    pub(super) struct BufferItem<'a> {
        uri: Option<Cow<'a, str>> = get("uri"),
        byte_length: Integer = need("byteLength"),
    }

    pub(super) struct MaterialItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        double_sided: bool = or_default("doubleSided"),
        alpha_mode: Option<Cow<'a, str>> = get("alphaMode"),
        pbr_metallic_roughness: Option<Pbr> = get("pbrMetallicRoughness"),
        transmission: Option<Transmission> = extension("KHR_materials_transmission"),
        glossiness: Option<Glossiness> = extension("KHR_materials_pbrSpecularGlossiness"),
    }

    pub(super) struct Pbr {
        base_color_factor: Option<[f32; 4]> = get("baseColorFactor"),
    }

    pub(super) struct Transmission {
        transmission_factor: f32 = or_default("transmissionFactor"),
    }

    pub(super) struct Glossiness {
        diffuse_factor: Option<[f32; 4]> = get("diffuseFactor"),
    }

    pub(super) struct CameraItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        perspective: Option<Perspective> = get("perspective"),
        orthographic: Option<Orthographic> = get("orthographic"),
    }

    pub(super) struct Perspective {
        aspect_ratio: Option<f64> = get("aspectRatio"),
        yfov: f64 = need("yfov"),
        zfar: Option<f64> = get("zfar"),
        znear: f64 = need("znear"),
    }

    pub(super) struct Orthographic {
        xmag: f64 = need("xmag"),
        ymag: f64 = need("ymag"),
        zfar: f64 = need("zfar"),
        znear: f64 = need("znear"),
    }

    /// `CESIUM_RTC`.
    pub(super) struct Rtc {
        center: [f64; 3] = need("center"),
    }

    pub(super) struct SkinItem {
        joints: Vec<Index> = need("joints"),
        inverse_bind_matrices: Option<Index> = get("inverseBindMatrices"),
    }

    pub(super) struct AnimationItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        channels: Vec<Channel<'a>> = or_default("channels"),
        samplers: Vec<Sampler<'a>> = or_default("samplers"),
    }

    pub(super) struct Channel<'a> {
        sampler: Index = need("sampler"),
        target: Target<'a> = need("target"),
    }

    pub(super) struct Target<'a> {
        node: Option<Index> = get("node"),
        path: Cow<'a, str> = need("path"),
        pointer: Option<Pointer<'a>> = extension("KHR_animation_pointer"),
    }

    pub(super) struct Pointer<'a> {
        pointer: Cow<'a, str> = need("pointer"),
    }

    pub(super) struct Sampler<'a> {
        input: Index = need("input"),
        output: Index = need("output"),
        interpolation: Option<Cow<'a, str>> = get("interpolation"),
    }
}

/// Parses the document's outline.
///
/// # Errors
/// If it is no JSON of the right form, or of another version of glTF; or if it holds so many tiny
/// objects that they would swell in memory.
pub(super) fn parse(text: &[u8]) -> Result<Root<'_>, ErrorKind> {
    let wrong = |message: String| ErrorKind::invalid("JSON", message);
    if text.starts_with(&[0xEF, 0xBB, 0xBF]) {
        return Err(wrong(
            "starts with a byte order mark, which glTF forbids: save it as UTF-8 without one"
                .into(),
        ));
    }
    let text = std::str::from_utf8(text)
        .map_err(|e| wrong(format!("is not UTF-8 at byte {}", e.valid_up_to())))?;
    // Some writers of GLB pad with NUL.
    let text = text.trim_end_matches('\0');
    if text.trim_ascii().is_empty() {
        return Err(wrong("is empty".into()));
    }
    check_density(text)?;
    let all = Json::parse(text).and_then(Object::from_json).map_err(wrong)?;
    let asset: Option<Object<'_>> = member(&all, "asset")?;
    let version = asset.as_ref().map(|asset| asset.get::<Json<'_>>("version")).transpose();
    let version = version.map_err(wrong)?.flatten().map(|v| v.text().trim_matches('"'));
    // In version 1.0 arrays were maps from names, the version might be a number or left out.
    let maps = ["accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"];
    let is_map = |(name, json): &(Cow<'_, str>, Json<'_>)| {
        maps.contains(&name.as_ref()) && json.text().starts_with('{')
    };
    match version {
        Some(version) if version.starts_with("2.") => {}
        Some(version) => return Err(version_1(version)),
        None if all.members().any(is_map) => return Err(version_1("1.0")),
        None if asset.is_some() => return Err(wrong("missing field `version`".into())),
        None => return Err(wrong("`asset` is missing: this is not glTF".into())),
    }
    Ok(Root {
        // They are counted alone.
        textures: all.get("textures").unwrap_or_default(),
        scene: member(&all, "scene")?,
        scenes: member(&all, "scenes")?,
        nodes: member(&all, "nodes")?,
        meshes: member(&all, "meshes")?,
        accessors: member(&all, "accessors")?,
        buffer_views: member(&all, "bufferViews")?,
        buffers: member(&all, "buffers")?,
        materials: member(&all, "materials")?,
        cameras: member(&all, "cameras")?,
        animations: member(&all, "animations")?,
        skins: member(&all, "skins")?,
        extensions_required: all.or_default("extensionsRequired").map_err(wrong)?,
        extensions_used: all.or_default("extensionsUsed").unwrap_or_default(),
        extensions: member(&all, "extensions")?,
    })
}

/// The refusal of a version that is not 2.
pub(super) fn version_1(version: &str) -> ErrorKind {
    ErrorKind::Unsupported(format!(
        "glTF version {}; only 2.x is read. Version 1.0 becomes 2.0 by \
         `npx gltf-pipeline -i in.gltf -o out.glb`",
        start(version).escape_debug()
    ))
}

/// A member of the document.
fn member<'a, T: FromJson<'a>>(all: &Object<'a>, name: &str) -> Result<Option<T>, ErrorKind> {
    all.get(name).map_err(|message| ErrorKind::invalid("JSON", format!("{name}: {message}")))
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

/// The items of an array; none where there is no such array.
pub(super) fn all<'r, 'a>(items: &'r Items<'a>) -> &'r [Json<'a>] {
    items.as_deref().unwrap_or_default()
}

/// Reads item `index` of an array; `what` is the array's name in the singular.
///
/// # Errors
/// Names the item and its defect.
pub(super) fn item<'a, T: FromJson<'a>>(
    json: Json<'a>,
    what: &str,
    index: usize,
) -> Result<T, ErrorKind> {
    T::from_json(json).map_err(|message| ErrorKind::invalid(format!("{what} {index}"), message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_item() {
        let json = Json::parse(r#"{"componentType": 5126}"#).unwrap();
        let error = item::<AccessorItem<'_>>(json, "accessor", 4).unwrap_err().to_string();
        assert_eq!(error, "accessor 4: missing field `count`");
        let json = Json::parse("[1]").unwrap();
        let error = item::<BufferItem<'_>>(json, "buffer", 0).unwrap_err().to_string();
        assert_eq!(error, "buffer 0: expected an object, found [1]");
        let error = parse(br#"{"asset":{"version":"2.0"},"nodes":3}"#).unwrap_err().to_string();
        assert_eq!(error, "JSON: nodes: invalid type: integer `3`, expected a sequence");
    }

    #[test]
    fn version_1_is_told_by_its_maps_and_whatever_way_its_version_is_written() {
        for text in [
            r#"{"accessors":{"a":{}},"asset":{"version":"1.0","profile":{"api":"WebGL"}},"nodes":{}}"#,
            r#"{"asset":{"version":1},"scenes":[]}"#,
            r#"{"asset":{"generator":"collada2gltf"},"nodes":{"node_1":{}}}"#,
            r#"{"scene":"s","scenes":{"s":{"nodes":[]}}}"#,
        ] {
            let error = parse(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains("only 2.x is read"), "{error}");
            assert!(error.contains("npx gltf-pipeline"), "{error}");
        }
        let error = parse(br#"{"asset":{}}"#).unwrap_err().to_string();
        assert_eq!(error, "JSON: missing field `version`");
    }

    #[test]
    fn a_swarm_of_empty_objects_is_refused() {
        let text =
            format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{{}}{}]}}"#, ",{}".repeat(2_000_000));
        assert!(matches!(parse(text.as_bytes()), Err(ErrorKind::OverLimit { .. })));
    }
}
