//! The words of documents for what the kernel has as enums.

use loftsman_kernel::material::{Channel, Filter, Wrap};

/// What textures stand for; others are named by their format.
pub(crate) const CHANNELS: [(&str, Channel); 5] = [
    ("base_color", Channel::BaseColor),
    ("metallic_roughness", Channel::MetallicRoughness),
    ("normal", Channel::Normal),
    ("occlusion", Channel::Occlusion),
    ("emissive", Channel::Emissive),
];

/// What lies outside of a picture.
pub(crate) const WRAPS: [(&str, Wrap); 3] =
    [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];

/// How pictures are read between their dots.
pub(crate) const FILTERS: [(&str, Filter); 6] = [
    ("nearest", Filter::Nearest),
    ("linear", Filter::Linear),
    ("nearest_of_nearest", Filter::NearestOfNearest),
    ("linear_of_nearest", Filter::LinearOfNearest),
    ("nearest_of_mixed", Filter::NearestOfMixed),
    ("linear_of_mixed", Filter::LinearOfMixed),
];

/// The word for a value.
pub(crate) fn of<T: PartialEq>(table: &[(&'static str, T)], value: &T) -> Option<&'static str> {
    table.iter().find(|(_, known)| known == value).map(|(name, _)| *name)
}
