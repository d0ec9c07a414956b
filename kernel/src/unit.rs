//! Units of length, and which axis points up.

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Micrometre.
    #[serde(rename = "um")]
    Micrometre,
    /// Millimetre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Centimetre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metre, the default.
    #[default]
    #[serde(rename = "m")]
    Metre,
    /// Kilometre.
    #[serde(rename = "km")]
    Kilometre,
    /// International inch (25.4 mm).
    #[serde(rename = "in")]
    Inch,
    /// International foot (12 in).
    #[serde(rename = "ft")]
    Foot,
    /// International yard (3 ft).
    #[serde(rename = "yd")]
    Yard,
    /// International mile (1760 yd).
    #[serde(rename = "mi")]
    Mile,
}

impl Unit {
    /// Every unit, by its name in documents.
    pub const ALL: [(&'static str, Self); 9] = [
        ("um", Self::Micrometre),
        ("mm", Self::Millimetre),
        ("cm", Self::Centimetre),
        ("m", Self::Metre),
        ("km", Self::Kilometre),
        ("in", Self::Inch),
        ("ft", Self::Foot),
        ("yd", Self::Yard),
        ("mi", Self::Mile),
    ];

    /// How many metres one unit is.
    pub fn metres(self) -> f64 {
        match self {
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
            Self::Kilometre => 1e3,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
            Self::Yard => 0.9144,
            Self::Mile => 1609.344,
        }
    }

    /// The name in documents: `"mm"`, `"m"`, `"in"`, …
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, unit)| *unit == self).map_or("m", |(name, _)| name)
    }

    /// The unit of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit)
    }
}

/// Which axis points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// The x axis.
    X,
    /// The y axis (glTF, OBJ).
    Y,
    /// The z axis (STEP, STL, PLY, Blender), the default.
    #[default]
    Z,
}

impl Up {
    /// Every axis, by its name in documents.
    pub const ALL: [(&'static str, Self); 3] = [("x", Self::X), ("y", Self::Y), ("z", Self::Z)];

    /// The name in documents: `"x"`, `"y"` or `"z"`.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].0
    }

    /// The axis of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, up)| *up)
    }
}
