//! What may be asked of a conversion: unit, up axis, fineness.

use loftsman_kernel::plugin::{
    Chord, Fineness, ParameterError, Parameters, ReadOptions, UpChoice, WriteOptions,
};
use loftsman_kernel::scene::{Unit, Up};

/// Formats whose files say nothing about units.
const WITHOUT_UNIT: &[&str] = &["obj", "points", "stl", "ply", "off", "csv", "xyz"];

/// Unit, axes and fineness of a conversion, as a person asks for them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conversion {
    /// The unit of the numbers: the input's where its format has none (OBJ, points) and
    /// [`from_unit`](Self::from_unit) is left out, else the output's.
    pub unit: Option<Unit>,
    /// The unit of the input's numbers, whatever its file says.
    pub from_unit: Option<Unit>,
    /// The up axis of the output.
    pub up: UpChoice,
    /// The up axis of the input, whatever its format says.
    pub from_up: Option<Up>,
    /// How fine splines are tessellated where the output cannot hold them.
    pub fineness: Fineness,
}

impl Conversion {
    /// The fields `unit`, `up` and `tolerance` of a table.
    ///
    /// # Errors
    /// When one has an unknown word or a number that cannot be.
    pub fn from_parameters(fields: &Parameters) -> Result<Self, ParameterError> {
        let mut conversion = Self::default();
        if fields.has("unit") {
            conversion.unit = Some(fields.choice("unit", &Unit::ALL)?);
        }
        if fields.has("up") {
            conversion.up = fields.choice("up", &UPS)?;
        }
        if fields.has("tolerance") {
            let text = match fields.value("tolerance").and_then(|v| v.as_f64()) {
                Some(number) => number.to_string(),
                None => fields.text("tolerance")?.to_owned(),
            };
            conversion.fineness.chord = chord(&text).map_err(|e| fields.error("tolerance", e))?;
        }
        Ok(conversion)
    }

    /// How to read an input of the format of this name.
    pub fn read_options(&self, format: &str) -> ReadOptions<'static> {
        let assumed = if WITHOUT_UNIT.contains(&format) { self.unit } else { None };
        ReadOptions { unit: self.from_unit.or(assumed), up: self.from_up, ..ReadOptions::default() }
    }

    /// How to write what came from an input of the format of this name.
    pub fn write_options(&self, input_format: &str) -> WriteOptions<'static> {
        let assumed = self.from_unit.is_none() && WITHOUT_UNIT.contains(&input_format);
        let unit = if assumed { None } else { self.unit };
        WriteOptions { unit, up: self.up, fineness: self.fineness, ..WriteOptions::default() }
    }
}

/// The words for the up axis of an output.
pub const UPS: [(&str, UpChoice); 4] = [
    ("x", UpChoice::To(Up::X)),
    ("y", UpChoice::To(Up::Y)),
    ("z", UpChoice::To(Up::Z)),
    ("keep", UpChoice::Keep),
];

/// A chord tolerance: `"0.01"` is a length in the scene's unit, `"0.1%"` a part of each shape's diagonal.
///
/// # Errors
/// When it is no number, or not positive and finite; the text says what to write.
pub fn chord(text: &str) -> Result<Chord, String> {
    let (number, relative) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim_end(), true),
        None => (text.trim(), false),
    };
    match number.parse::<f64>() {
        Ok(n) if n > 0.0 && n.is_finite() => {
            Ok(if relative { Chord::Relative(n / 100.0) } else { Chord::Absolute(n) })
        }
        Ok(_) => Err(format!("the tolerance {number} is not a positive number")),
        Err(_) => Err(format!("\"{number}\" is not a number; write a length as 0.01, or 0.1% of the size")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_is_the_inputs_where_its_format_has_none() {
        let mm = Conversion { unit: Some(Unit::Millimetre), ..Conversion::default() };
        assert_eq!(mm.read_options("obj").unit, Some(Unit::Millimetre));
        assert_eq!(mm.write_options("obj").unit, None);
        assert_eq!(mm.read_options("gltf").unit, None);
        assert_eq!(mm.write_options("gltf").unit, Some(Unit::Millimetre));
        let both = Conversion { from_unit: Some(Unit::Inch), ..mm };
        assert_eq!(both.read_options("obj").unit, Some(Unit::Inch));
        assert_eq!(both.write_options("obj").unit, Some(Unit::Millimetre));
    }

    #[test]
    fn tolerances_are_lengths_or_parts() {
        assert_eq!(chord("0.01"), Ok(Chord::Absolute(0.01)));
        assert_eq!(chord("0.1 %"), Ok(Chord::Relative(0.1 / 100.0)));
        for wrong in ["", "0", "-1", "nan", "inf", "1e999", "%", "mm"] {
            assert!(chord(wrong).is_err(), "{wrong}");
        }
    }
}
