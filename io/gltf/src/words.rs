//! Words that the reader and the writer share.

/// The field of `extras` that is ours.
pub(crate) const EXTRAS: &str = "loftsman";

/// How statements that are glTF's begin. Of materials, the name of an extension comes after it, or [`DATA`].
pub(crate) const PREFIX: &str = "gltf ";

/// What other programs noted: of a node or the whole document.
pub(crate) const DATA: &str = "gltf extras";

/// What other programs noted of a node's mesh, and its name where it is not the node's.
pub(crate) const MESH_DATA: &str = "gltf mesh extras";
pub(crate) const MESH_NAME: &str = "gltf mesh name";

/// What an object is called whose node has no name, or a material that has none; and that a node's primitive, or what stands for it, has no material.
pub(crate) const UNNAMED: &str = "gltf unnamed";
pub(crate) const MATERIAL: &str = "gltf material";

/// What [`MATERIAL`] says of a material that our writer made for a colour, one of several of an object.
pub(crate) const COLOR: &str = "color";

/// What a picture is called that has no name: of the whole document.
pub(crate) const UNNAMED_IMAGE: &str = "gltf unnamed image";

/// What [`MATERIAL`] says.
pub(crate) const NONE: &str = "none";

/// The numbers of a node's placement as its file has them, where a matrix does not give them back to the last bit.
pub(crate) const PLACEMENT: &str = "gltf placement";

/// What other programs noted of the scene that is shown, and its name.
pub(crate) const SCENE_DATA: &str = "gltf scene extras";
pub(crate) const SCENE_NAME: &str = "gltf scene name";

/// What other programs noted of the asset, and whose it is.
pub(crate) const ASSET_DATA: &str = "gltf asset extras";
pub(crate) const COPYRIGHT: &str = "gltf asset copyright";

/// The names of morph targets in the extras of a mesh; ours only number the frames.
pub(crate) const TARGET_NAMES: &str = "targetNames";

/// The name of the morph target that shows a frame.
pub(crate) fn frame_name(frame: usize) -> String {
    format!("frame {frame}")
}

/// Extensions that let textures show pictures of further media types.
pub(crate) const SOURCES: [(&str, &str); 3] = [
    ("KHR_texture_basisu", "image/ktx2"),
    ("EXT_texture_webp", "image/webp"),
    ("EXT_texture_avif", "image/avif"),
];
