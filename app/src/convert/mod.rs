//! What may be asked of a conversion: unit, up axis, fineness, and the formats' own options.

mod run;

use std::collections::BTreeMap;

use loftsman_kernel::plugin::{
    Chord, Fate, Fineness, Format, FormatDeclaration, Observer, ParameterError, Parameters, ReadOptions,
    Registry, UnitRule, UpChoice, WriteOptions, Written,
};
use loftsman_kernel::scene::{Unit, Up};
use serde_json::{Map, Value};

use crate::error::Result;
use crate::file::Input;
use crate::file::input::Content;

pub use run::{Converted, Converter, convert};

/// Unit, axes, fineness and formats' options of a conversion, as a person asks for them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Conversion {
    /// The unit of the numbers: of those that a recipe without an input gives; the input's where its format has none (OBJ, points) and
    /// [`from_unit`](Self::from_unit) is left out; else the output's.
    pub unit: Option<Unit>,
    /// The unit of the input's numbers, whatever its file says.
    pub from_unit: Option<Unit>,
    /// The up axis of the output.
    pub up: UpChoice,
    /// The up axis of the input, whatever its format says.
    pub from_up: Option<Up>,
    /// How near splines are tessellated where the output cannot hold them, and the largest angle between neighbouring segments in
    /// radians; what is not asked for is what the output's format [has](Format::fineness). Where one is asked for and nothing is
    /// tessellated, that is said.
    pub chord: Option<Chord>,
    /// The angle.
    pub angle: Option<f64>,
    /// Options of the input's format.
    pub read: Map<String, Value>,
    /// Options of output formats, by the format's name.
    pub write: BTreeMap<String, Map<String, Value>>,
}

impl Conversion {
    /// The fields `unit`, `up`, `tolerance`, `read` and `write` of a table.
    ///
    /// # Errors
    /// When one has an unknown word or a number that cannot be.
    pub fn from_parameters(fields: &Parameters) -> Result<Self, ParameterError> {
        let mut conversion = Self::default();
        if fields.has("unit") {
            let text = fields.text("unit")?;
            conversion.unit = Some(unit(text).map_err(|problem| fields.error("unit", problem))?);
        }
        if fields.has("up") {
            conversion.up = fields.choice("up", &UPS)?;
        }
        if fields.has("tolerance") {
            let text = match fields.value("tolerance").and_then(|v| v.as_f64()) {
                Some(number) => number.to_string(),
                None => fields.text("tolerance")?.to_owned(),
            };
            conversion.chord = Some(chord(&text).map_err(|e| fields.error("tolerance", e))?);
        }
        if fields.has("read") {
            conversion.read = map(&fields.table("read")?);
        }
        if fields.has("write") {
            let formats = fields.table("write")?;
            for format in formats.names() {
                conversion.write.insert(format.to_owned(), map(&formats.table(format)?));
            }
        }
        Ok(conversion)
    }

    /// What to say where fineness was asked for and nothing of what was written needed it.
    pub fn idle_fineness<'w>(&self, written: impl IntoIterator<Item = &'w Written>) -> Option<String> {
        let fine = |w: &Written| w.tolerance.is_some() || w.error.is_some() || w.fate == Fate::Approximated;
        let asked = self.chord.is_some() || self.angle.is_some();
        let idle = asked && !written.into_iter().any(fine);
        idle.then(|| {
            "nothing was tessellated, so that the tolerance or angle asked for changes nothing".to_owned()
        })
    }

    /// Reads an input: the one door of all commands and recipes.
    ///
    /// # Errors
    /// As for [`Input::read`].
    pub fn read(&self, input: &Input, observer: &dyn Observer, registry: &Registry) -> Result<Content> {
        let format = input.format(registry)?;
        let options = ReadOptions { observer, ..self.read_options(&format.declaration()) };
        input.read(format.as_ref(), &options, registry)
    }

    /// Reads a further input beside one of the format of the name `first`: with that one's options where it is of the same
    /// format.
    ///
    /// # Errors
    /// As for [`Input::read`].
    pub fn read_beside(
        &self,
        first: &str,
        input: &Input,
        observer: &dyn Observer,
        registry: &Registry,
    ) -> Result<Content> {
        let format = input.format(registry)?;
        let mut options = ReadOptions { observer, ..self.read_options(&format.declaration()) };
        if format.declaration().name != first {
            options.own = Parameters::empty("read");
        }
        input.read(format.as_ref(), &options, registry)
    }

    /// How to read an input of a format.
    fn read_options(&self, format: &FormatDeclaration) -> ReadOptions<'static> {
        let assumed = if format.holds.unit == UnitRule::None { self.unit } else { None };
        let own = parameters(&self.read, "read".to_owned());
        ReadOptions { unit: self.from_unit.or(assumed), up: self.from_up, own, ..ReadOptions::default() }
    }

    /// How to write, in the format `output`, what came from an input of the format `input`, if from any.
    pub fn write_options(
        &self,
        input: Option<&FormatDeclaration>,
        output: &dyn Format,
    ) -> WriteOptions<'static> {
        let name = output.declaration().name;
        let usual = output.fineness();
        let fineness =
            Fineness { chord: self.chord.unwrap_or(usual.chord), angle: self.angle.unwrap_or(usual.angle) };
        // What names the unit of the numbers as they come in does not ask for them in that unit as they go out.
        let names_input =
            input.is_none_or(|format| format.holds.unit == UnitRule::None && self.from_unit.is_none());
        let unit = if names_input { None } else { self.unit };
        let none = Map::new();
        let own = parameters(self.write.get(name).unwrap_or(&none), format!("write.{name}"));
        WriteOptions { unit, up: self.up, fineness, own, ..WriteOptions::default() }
    }
}

fn map(fields: &Parameters) -> Map<String, Value> {
    fields.names().filter_map(|name| Some((name.to_owned(), fields.value(name)?.clone()))).collect()
}

fn parameters(fields: &Map<String, Value>, path: String) -> Parameters {
    let none = Parameters::empty(path.clone());
    Parameters::new(Value::Object(fields.clone()), path).unwrap_or(none)
}

/// A unit that is asked for: a name, or a number of metres.
///
/// # Errors
/// With the names that there are.
pub fn unit(text: &str) -> std::result::Result<Unit, String> {
    if let Some(unit) = Unit::from_name(text).filter(|unit| *unit != Unit::Unknown) {
        return Ok(unit);
    }
    let known = Unit::ALL.map(|(name, _)| name).join(", ");
    // Names so short are all near one another: no one of them is meant more than the others.
    Err(format!(
        "unknown unit \"{}\"; choose one of {known}, or a number of metres, as \"0.3 m\"",
        loftsman_kernel::text::clip(text)
    ))
}

/// The words for the up axis of an output.
pub const UPS: [(&str, UpChoice); 4] = [
    ("x", UpChoice::To(Up::X)),
    ("y", UpChoice::To(Up::Y)),
    ("z", UpChoice::To(Up::Z)),
    ("keep", UpChoice::Keep),
];

/// A chord tolerance: `"0.01"` is a length in the scene's unit, `"0.1%"` a part of each shape's diagonal
/// (of surfaces that share edges: of all of them together).
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
        let (obj, gltf) = (&loftsman_obj::Obj.declaration(), &loftsman_gltf::Gltf.declaration());
        let mm = Conversion { unit: Some(Unit::Millimetre), ..Conversion::default() };
        assert_eq!(mm.read_options(obj).unit, Some(Unit::Millimetre));
        assert_eq!(mm.write_options(Some(obj), &loftsman_gltf::Gltf).unit, None);
        assert_eq!(mm.read_options(gltf).unit, None);
        assert_eq!(mm.write_options(Some(gltf), &loftsman_obj::Obj).unit, Some(Unit::Millimetre));
        let both = Conversion { from_unit: Some(Unit::Inch), ..mm.clone() };
        assert_eq!(both.read_options(obj).unit, Some(Unit::Inch));
        assert_eq!(both.write_options(Some(obj), &loftsman_gltf::Gltf).unit, Some(Unit::Millimetre));
        // Without an input it is that of the numbers given, which glTF wants in metres.
        assert_eq!(mm.write_options(None, &loftsman_gltf::Gltf).unit, None);
        assert_eq!(both.write_options(None, &loftsman_gltf::Gltf).unit, None);
    }

    #[test]
    fn what_is_not_asked_of_fineness_is_the_formats_own() {
        let of = |asked: &Conversion, output: &dyn Format| asked.write_options(None, output).fineness;
        let nothing = Conversion::default();
        assert_eq!(of(&nothing, &loftsman_gltf::Gltf).chord, Chord::Relative(1e-4));
        assert_eq!(of(&nothing, &loftsman_obj::Obj), Fineness::default());
        let angle = Conversion { angle: Some(0.1), ..Conversion::default() };
        let fine = of(&angle, &loftsman_gltf::Gltf);
        assert_eq!((fine.chord, fine.angle), (Chord::Relative(1e-4), 0.1));
        let chord = Conversion { chord: Some(Chord::Absolute(0.5)), ..Conversion::default() };
        assert_eq!(of(&chord, &loftsman_gltf::Gltf).chord, Chord::Absolute(0.5));
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
