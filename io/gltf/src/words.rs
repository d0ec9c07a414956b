//! Words that the reader and the writer share.

/// The field of `extras` that is ours.
pub(crate) const EXTRAS: &str = "loftsman";

/// How statements of materials that are glTF's begin: the name of an extension comes after it, or `extras`.
pub(crate) const PREFIX: &str = "gltf ";

/// Extensions that let textures show pictures of further media types.
pub(crate) const SOURCES: [(&str, &str); 3] = [
    ("KHR_texture_basisu", "image/ktx2"),
    ("EXT_texture_webp", "image/webp"),
    ("EXT_texture_avif", "image/avif"),
];

/// The media type of a picture, by its first bytes.
pub(crate) fn media_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, ..] => Some("image/ktx2"),
        [_, _, _, _, b'f', b't', b'y', b'p', b'a', b'v', b'i', b'f', ..] => Some("image/avif"),
        _ => None,
    }
}
