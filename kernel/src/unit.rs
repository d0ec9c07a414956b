//! Units of length, and which axis points up.

use std::borrow::Cow;
use std::fmt;

use serde::de::Error as _;

use crate::text;

/// A unit of length: one with a name, so many metres, or one that nobody knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Nanometre.
    Nanometre,
    /// Micrometre.
    Micrometre,
    /// Millimetre.
    Millimetre,
    /// Centimetre.
    Centimetre,
    /// Decimetre.
    Decimetre,
    /// Metre, the default.
    #[default]
    Metre,
    /// Kilometre.
    Kilometre,
    /// A thousandth of an inch.
    Mil,
    /// International inch (25.4 mm).
    Inch,
    /// International foot (12 in).
    Foot,
    /// US survey foot (1200/3937 m).
    SurveyFoot,
    /// International yard (3 ft).
    Yard,
    /// International mile (1760 yd).
    Mile,
    /// So many metres, where that is none of the others ([`Unit::of_metres`]).
    Metres(Length),
    /// Whatever it is: numbers of a file that does not say. They stay as they are where another unit is asked for.
    Unknown,
}

/// A length in metres, positive and finite.
#[derive(Clone, Copy)]
pub struct Length(f64);

impl Length {
    /// In metres.
    pub fn metres(self) -> f64 {
        self.0
    }
}

impl PartialEq for Length {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Length {}

impl fmt::Debug for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} m", self.0)
    }
}

impl Unit {
    /// Every unit with a name, by its name in documents.
    pub const ALL: [(&'static str, Self); 13] = [
        ("nm", Self::Nanometre),
        ("um", Self::Micrometre),
        ("mm", Self::Millimetre),
        ("cm", Self::Centimetre),
        ("dm", Self::Decimetre),
        ("m", Self::Metre),
        ("km", Self::Kilometre),
        ("mil", Self::Mil),
        ("in", Self::Inch),
        ("ft", Self::Foot),
        ("us-ft", Self::SurveyFoot),
        ("yd", Self::Yard),
        ("mi", Self::Mile),
    ];

    /// The name of the unit that nobody knows.
    pub const UNKNOWN: &'static str = "unknown";

    /// How many metres one unit is; `None` where it is unknown.
    pub fn metres(self) -> Option<f64> {
        Some(match self {
            Self::Nanometre => 1e-9,
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Decimetre => 1e-1,
            Self::Metre => 1.0,
            Self::Kilometre => 1e3,
            Self::Mil => 2.54e-5,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
            Self::SurveyFoot => 1200.0 / 3937.0,
            Self::Yard => 0.9144,
            Self::Mile => 1609.344,
            Self::Metres(length) => length.metres(),
            Self::Unknown => return None,
        })
    }

    /// The unit of so many metres: the one with a name where there is one; `None` where that is no positive finite number.
    pub fn of_metres(metres: f64) -> Option<Self> {
        if !(metres > 0.0 && metres.is_finite()) {
            return None;
        }
        let named = Self::ALL.iter().find(|(_, unit)| unit.metres() == Some(metres));
        Some(named.map_or(Self::Metres(Length(metres)), |(_, unit)| *unit))
    }

    /// The name in documents: `"mm"`, `"m"`, `"in"`, …; of any other a number of metres, `"0.3 m"`; or `"unknown"`.
    pub fn name(self) -> Cow<'static, str> {
        if let Self::Metres(length) = self {
            let mut number = Vec::new();
            // Writing to a list cannot fail, and digits are ASCII.
            let _ = text::number(&mut number, length.metres());
            return Cow::Owned(String::from_utf8_lossy(&number).into_owned() + " m");
        }
        let named = Self::ALL.iter().find(|(_, unit)| *unit == self);
        Cow::Borrowed(named.map_or(Self::UNKNOWN, |(name, _)| name))
    }

    /// A number of this unit's first, second or third power, for people: `2 m²`, `3 × (0.3 m)²`, `2 square units` where it is unknown.
    ///
    /// ```
    /// use loftsman_kernel::scene::Unit;
    ///
    /// assert_eq!(Unit::Millimetre.quantity(15_234_567.8, 3), "15234568 mm³");
    /// assert_eq!(Unit::Unknown.quantity(0.5, 2), "0.5 square units");
    /// assert_eq!(Unit::Unknown.quantity(1.0, 1), "1 unit");
    /// ```
    pub fn quantity(self, number: f64, power: usize) -> String {
        self.of_figure(&text::figure(number), power)
    }

    /// The same in about six figures, where more than four are needed to see a change.
    pub fn measured_quantity(self, number: f64, power: usize) -> String {
        self.of_figure(&text::measured(number), power)
    }

    fn of_figure(self, figure: &str, power: usize) -> String {
        let raised = ["", "", "²", "³"].get(power).copied().unwrap_or_default();
        let words = ["", "unit", "square unit", "cubic unit"].get(power).copied().unwrap_or_default();
        match self {
            Self::Unknown if matches!(figure, "1" | "-1") || power == 0 => {
                format!("{figure} {words}")
            }
            Self::Unknown => format!("{figure} {words}s"),
            Self::Metres(_) => format!("{figure} × {}{raised}", self.one()),
            named => format!("{figure} {}{raised}", named.name()),
        }
    }

    /// The unit of a [name](Self::name).
    pub fn from_name(name: &str) -> Option<Self> {
        if name == Self::UNKNOWN {
            return Some(Self::Unknown);
        }
        let named = Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, unit)| *unit);
        let number = || name.strip_suffix('m')?.trim_end_matches(' ').parse::<f64>().ok();
        named.or_else(|| number().and_then(Self::of_metres))
    }

    /// What texts call a number of it: `"mm"`; `"× 0.3 m"`; `"units"` where it is unknown.
    pub fn symbol(self) -> Cow<'static, str> {
        match self {
            Self::Metres(_) => Cow::Owned(format!("× {}", self.name())),
            Self::Unknown => Cow::Borrowed("units"),
            named => named.name(),
        }
    }

    /// What texts call one of it, behind a stroke: `"mm"`; `"(0.3 m)"`; `"unit"` where it is unknown.
    pub fn one(self) -> Cow<'static, str> {
        match self {
            Self::Metres(_) => Cow::Owned(format!("({})", self.name())),
            Self::Unknown => Cow::Borrowed("unit"),
            named => named.name(),
        }
    }
}

impl serde::Serialize for Unit {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.name())
    }
}

impl<'de> serde::Deserialize<'de> for Unit {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::from_name(&name)
            .ok_or_else(|| D::Error::custom(format!("unknown unit \"{}\"", text::clip(&name))))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conformance::Lcg;

    #[test]
    fn names_read_back_as_the_same_unit_whatever_its_length() {
        let mut random = Lcg::new(3);
        let any = (0..500).map(|k| random.next().abs() * 10_f64.powi(k % 600 - 300));
        for metres in any.chain([f64::MIN_POSITIVE, 5e-324, f64::MAX, 1.0 / 3.0]).filter(|m| *m > 0.0) {
            let unit = Unit::of_metres(metres).unwrap();
            assert_eq!(unit.metres(), Some(metres));
            assert_eq!(Unit::from_name(&unit.name()), Some(unit), "{unit:?}");
            let json = serde_json::to_string(&unit).unwrap();
            assert_eq!(serde_json::from_str::<Unit>(&json).unwrap(), unit);
        }
        for (name, unit) in Unit::ALL {
            assert_eq!((unit.name().as_ref(), Unit::from_name(name)), (name, Some(unit)));
            assert_eq!(Unit::of_metres(unit.metres().unwrap()), Some(unit));
        }
        assert_eq!(Unit::from_name("0.0254 m"), Some(Unit::Inch));
        assert_eq!((Unit::from_name("unknown"), Unit::Unknown.metres()), (Some(Unit::Unknown), None));
    }

    #[test]
    fn what_is_no_length_is_no_unit() {
        for name in
            ["", "0 m", "-1 m", "inf m", "NaN m", "1e999 m", "furlong", "Unknown", "3", " m", "1 mm m"]
        {
            assert_eq!(Unit::from_name(name), None, "{name}");
        }
        assert!([0.0, -2.0, f64::NAN, f64::INFINITY].iter().all(|&m| Unit::of_metres(m).is_none()));
    }

    #[test]
    fn texts_name_a_unit_as_people_read_it() {
        let said = |unit: Unit| format!("2 {}, 3 / {}", unit.symbol(), unit.one());
        assert_eq!(said(Unit::Millimetre), "2 mm, 3 / mm");
        assert_eq!(said(Unit::Unknown), "2 units, 3 / unit");
        assert_eq!(said(Unit::of_metres(0.3).unwrap()), "2 × 0.3 m, 3 / (0.3 m)");
    }
}
