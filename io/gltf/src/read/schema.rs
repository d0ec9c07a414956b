//! The parts of the glTF 2.0 schema that are read (Khronos glTF 2.0 specification, section 5).
//!
//! Lists whose entries may be almost empty (`nodes`, `meshes`, `materials`, …) are kept as the text that they are and
//! parsed entry by entry, so that a file of brackets costs little more memory than it has bytes.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};
use serde_json::value::RawValue;

/// Text of the file.
pub(super) type Raw<'a> = &'a RawValue;

/// The extensions of an entry, by name.
pub(super) type Extensions<'a> = BTreeMap<String, Raw<'a>>;

/// An index or a count: a whole number from 0, written `3` or `3.0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Whole(pub(super) u64);

impl Whole {
    /// The number as an index; one that no list can have where it is too large.
    pub(super) fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Digits;
        impl Visitor<'_> for Digits {
            type Value = Whole;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a whole number from 0")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Whole, E> {
                Ok(Whole(value))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Whole, E> {
                // 2^53: up to there every whole number is a float of its own.
                if value >= 0.0 && value.fract() == 0.0 && value <= 9_007_199_254_740_992.0 {
                    Ok(Whole(value as u64))
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Float(value), &self))
                }
            }
        }
        deserializer.deserialize_u64(Digits)
    }
}

/// Whether something stands there, whatever it is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Present(pub(super) bool);

impl<'de> Deserialize<'de> for Present {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        serde::de::IgnoredAny::deserialize(deserializer).map(|_| Self(true))
    }
}

/// The document.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Root<'a> {
    #[serde(borrow)]
    pub(super) asset: Option<Asset<'a>>,
    pub(super) scene: Option<Whole>,
    pub(super) extensions_used: Vec<String>,
    pub(super) extensions_required: Vec<String>,
    #[serde(borrow)]
    pub(super) scenes: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) nodes: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) meshes: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) materials: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) animations: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) skins: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) cameras: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) images: Vec<Raw<'a>>,
    #[serde(borrow)]
    pub(super) textures: Vec<Texture<'a>>,
    pub(super) samplers: Vec<Sampler>,
    pub(super) accessors: Vec<Accessor>,
    #[serde(borrow)]
    pub(super) buffer_views: Vec<BufferView<'a>>,
    #[serde(borrow)]
    pub(super) buffers: Vec<Buffer<'a>>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset<'a> {
    pub(super) version: String,
    pub(super) min_version: Option<String>,
    pub(super) copyright: Option<String>,
    #[serde(borrow)]
    pub(super) generator: Option<Raw<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Scene<'a> {
    pub(super) name: Option<String>,
    pub(super) nodes: Vec<Whole>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Node<'a> {
    pub(super) name: Option<String>,
    pub(super) children: Vec<Whole>,
    pub(super) mesh: Option<Whole>,
    pub(super) camera: Option<Whole>,
    pub(super) skin: Option<Whole>,
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) weights: Option<Vec<f64>>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh<'a> {
    pub(super) name: Option<String>,
    #[serde(borrow)]
    pub(super) primitives: Vec<Primitive<'a>>,
    pub(super) weights: Option<Vec<f64>>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive<'a> {
    pub(super) attributes: BTreeMap<String, Whole>,
    pub(super) indices: Option<Whole>,
    pub(super) material: Option<Whole>,
    pub(super) mode: Option<Whole>,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, Whole>>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Material<'a> {
    pub(super) name: Option<String>,
    #[serde(borrow)]
    pub(super) pbr_metallic_roughness: Option<Pbr<'a>>,
    #[serde(borrow)]
    pub(super) normal_texture: Option<TextureInfo<'a>>,
    #[serde(borrow)]
    pub(super) occlusion_texture: Option<TextureInfo<'a>>,
    #[serde(borrow)]
    pub(super) emissive_texture: Option<TextureInfo<'a>>,
    pub(super) emissive_factor: Option<[f64; 3]>,
    pub(super) alpha_mode: Option<String>,
    pub(super) alpha_cutoff: Option<f64>,
    pub(super) double_sided: bool,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Pbr<'a> {
    pub(super) base_color_factor: Option<[f64; 4]>,
    #[serde(borrow)]
    pub(super) base_color_texture: Option<TextureInfo<'a>>,
    pub(super) metallic_factor: Option<f64>,
    pub(super) roughness_factor: Option<f64>,
    #[serde(borrow)]
    pub(super) metallic_roughness_texture: Option<TextureInfo<'a>>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    pub(super) extras: Present,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo<'a> {
    pub(super) index: Whole,
    pub(super) tex_coord: Option<Whole>,
    /// Of normals.
    pub(super) scale: Option<f64>,
    /// Of occlusion.
    pub(super) strength: Option<f64>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    #[serde(default)]
    pub(super) extras: Present,
}

/// `KHR_texture_transform`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureTransform {
    pub(super) offset: Option<[f64; 2]>,
    pub(super) rotation: Option<f64>,
    pub(super) scale: Option<[f64; 2]>,
    pub(super) tex_coord: Option<Whole>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Image<'a> {
    pub(super) name: Option<String>,
    #[serde(borrow)]
    pub(super) uri: Option<Raw<'a>>,
    pub(super) mime_type: Option<String>,
    pub(super) buffer_view: Option<Whole>,
    #[serde(borrow)]
    pub(super) extensions: Option<Extensions<'a>>,
    pub(super) extras: Present,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Texture<'a> {
    pub(super) sampler: Option<Whole>,
    pub(super) source: Option<Whole>,
    #[serde(borrow)]
    pub(super) extensions: Option<Box<Extensions<'a>>>,
    pub(super) extras: Present,
}

#[derive(Debug, Default, Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Sampler {
    pub(super) mag_filter: Option<Whole>,
    pub(super) min_filter: Option<Whole>,
    pub(super) wrap_s: Option<Whole>,
    pub(super) wrap_t: Option<Whole>,
    pub(super) extras: Present,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<Whole>,
    #[serde(default = "zero")]
    pub(super) byte_offset: Whole,
    pub(super) component_type: Whole,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: Whole,
    #[serde(rename = "type")]
    pub(super) kind: String,
    pub(super) sparse: Option<Box<Sparse>>,
    #[serde(default)]
    pub(super) extras: Present,
}

fn zero() -> Whole {
    Whole(0)
}

#[derive(Debug, Deserialize)]
pub(super) struct Sparse {
    pub(super) count: Whole,
    pub(super) indices: SparseIndices,
    pub(super) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseIndices {
    pub(super) buffer_view: Whole,
    #[serde(default = "zero")]
    pub(super) byte_offset: Whole,
    pub(super) component_type: Whole,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparseValues {
    pub(super) buffer_view: Whole,
    #[serde(default = "zero")]
    pub(super) byte_offset: Whole,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView<'a> {
    pub(super) buffer: Whole,
    #[serde(default = "zero")]
    pub(super) byte_offset: Whole,
    pub(super) byte_length: Whole,
    pub(super) byte_stride: Option<Whole>,
    #[serde(borrow)]
    pub(super) extensions: Option<Box<Extensions<'a>>>,
    #[serde(default)]
    pub(super) extras: Present,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(borrow)]
    pub(super) uri: Option<Raw<'a>>,
    pub(super) byte_length: Whole,
    #[serde(default)]
    pub(super) extras: Present,
}

#[derive(Debug, Deserialize)]
pub(super) struct Animation<'a> {
    pub(super) name: Option<String>,
    pub(super) channels: Vec<AnimationChannel>,
    pub(super) samplers: Vec<AnimationSampler>,
    #[serde(borrow)]
    pub(super) extras: Option<Raw<'a>>,
}

#[derive(Debug, Deserialize)]
pub(super) struct AnimationChannel {
    pub(super) sampler: Whole,
    pub(super) target: AnimationTarget,
}

#[derive(Debug, Deserialize)]
pub(super) struct AnimationTarget {
    pub(super) node: Option<Whole>,
    pub(super) path: String,
}

#[derive(Debug, Deserialize)]
pub(super) struct AnimationSampler {
    pub(super) input: Whole,
    pub(super) output: Whole,
    pub(super) interpolation: Option<String>,
}
