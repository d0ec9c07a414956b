//! Colour values as light (linear) and as files and screens have them (sRGB, IEC 61966-2-1).

/// A linear value, 0 to 1, as sRGB; beyond that the same formula.
pub fn to_srgb(value: f64) -> f64 {
    if value <= 0.003_130_8 { value * 12.92 } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
}

/// An sRGB value, 0 to 1, as a linear one; beyond that the same formula.
pub fn from_srgb(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
