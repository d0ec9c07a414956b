//! How surfaces look: materials, their textures, and the pictures these show.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::named::Named;

/// What a texture stands for.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// The colour and alpha.
    BaseColor,
    /// Metalness in blue, roughness in green.
    MetallicRoughness,
    /// Normals in the tangent plane.
    Normal,
    /// Occluded light in red.
    Occlusion,
    /// Light given off.
    Emissive,
    /// Another meaning, by the name that its format gives it.
    Other(String),
}

/// What a texture shows outside of its picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The picture again and again.
    #[default]
    Repeat,
    /// The picture and its mirror image in turns.
    Mirror,
    /// The picture's edge.
    Clamp,
}

/// How a texture is read between its picture's dots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// The nearest dot.
    Nearest,
    /// The dots around, mixed.
    Linear,
    /// The nearest dot of the nearest smaller picture.
    NearestOfNearest,
    /// The dots around, of the nearest smaller picture.
    LinearOfNearest,
    /// The nearest dots of the two smaller pictures, mixed.
    NearestOfMixed,
    /// The dots around, of the two smaller pictures, mixed.
    LinearOfMixed,
}

/// A picture laid over a surface by its texture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// The name of the picture, among the scene's.
    pub image: String,
    /// Which set of texture coordinates: 0 for [`uvs`](crate::mesh::Mesh::uvs), then
    /// [`more_uvs`](crate::mesh::Mesh::more_uvs).
    pub set: u32,
    /// How strongly it counts (of normals: their scale; of occlusion: its strength).
    pub strength: f64,
    /// Added to the texture coordinates.
    pub offset: [f64; 2],
    /// How often the picture is repeated over the unit square.
    pub tiling: [f64; 2],
    /// By how many radians it is turned, counterclockwise.
    pub rotation: f64,
    /// What lies outside of the picture, along `u` and `v`.
    pub wrap: [Wrap; 2],
    /// Between the dots, seen from close by; `None` where nothing is said.
    pub magnify: Option<Filter>,
    /// Between the dots, seen from afar; `None` where nothing is said.
    pub minify: Option<Filter>,
}

impl Texture {
    /// A texture that shows a picture once over the unit square.
    pub fn new(image: impl Into<String>) -> Self {
        Self {
            image: image.into(),
            set: 0,
            strength: 1.0,
            offset: [0.0; 2],
            tiling: [1.0; 2],
            rotation: 0.0,
            wrap: [Wrap::Repeat; 2],
            magnify: None,
            minify: None,
        }
    }
}

/// What alpha means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Alpha {
    /// Nothing: the surface is opaque.
    #[default]
    Opaque,
    /// Opaque from this value on, invisible below it.
    Mask(f64),
    /// How much of what lies behind is covered.
    Blend,
}

/// How a surface looks, as metals and roughness describe it (glTF 2.0, §3.9).
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    name: String,
    /// Linear red, green, blue and alpha, each 0 to 1.
    pub base_color: [f64; 4],
    /// 0 for plastic or wood, 1 for metal.
    pub metallic: f64,
    /// 0 for a mirror, 1 for chalk.
    pub roughness: f64,
    /// Light given off: linear red, green, blue.
    pub emissive: [f64; 3],
    /// What alpha means.
    pub alpha: Alpha,
    /// Whether faces are seen from behind.
    pub double_sided: bool,
    /// What textures say, by what they stand for.
    pub textures: BTreeMap<Channel, Texture>,
    /// What a format said beyond all this, word for word, for the same format: `("mtl Ks", "0.5 0.5 0.5")`.
    pub statements: Vec<(String, String)>,
}

impl Material {
    /// A material of one colour, neither metal nor mirror.
    pub fn new(name: impl Into<String>, base_color: [f64; 4]) -> Self {
        Self {
            name: name.into(),
            base_color,
            metallic: 0.0,
            roughness: 0.5,
            emissive: [0.0; 3],
            alpha: if base_color[3] < 1.0 { Alpha::Blend } else { Alpha::Opaque },
            double_sided: false,
            textures: BTreeMap::new(),
            statements: Vec::new(),
        }
    }

    /// The same material under another name.
    #[must_use]
    pub fn renamed(&self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self.clone() }
    }
}

impl Named for Material {
    const KIND: &'static str = "material";

    fn name(&self) -> &str {
        &self.name
    }
}

/// Where a picture's bytes are.
#[derive(Debug, Clone, PartialEq)]
pub enum ImageData {
    /// In a file, named relative to the scene's own.
    File(String),
    /// Here, as a file of this type (`image/png`) would hold them.
    Embedded {
        /// The media type.
        media_type: String,
        /// The bytes of the file.
        bytes: Arc<[u8]>,
    },
}

impl ImageData {
    /// The media type of a picture, by its first bytes; `None` for what is none of PNG, JPEG, WebP, KTX2 and AVIF.
    pub fn media_type_of(bytes: &[u8]) -> Option<&'static str> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
            [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
            [0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, ..] => Some("image/ktx2"),
            [_, _, _, _, b'f', b't', b'y', b'p', b'a', b'v', b'i', b'f', ..] => Some("image/avif"),
            _ => None,
        }
    }
}

/// A picture that textures show.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    name: String,
    /// Where its bytes are.
    pub data: ImageData,
}

impl Image {
    /// A picture.
    pub fn new(name: impl Into<String>, data: ImageData) -> Self {
        Self { name: name.into(), data }
    }
}

impl Named for Image {
    const KIND: &'static str = "image";

    fn name(&self) -> &str {
        &self.name
    }
}
