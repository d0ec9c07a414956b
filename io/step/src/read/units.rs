//! Units of representations: lengths, angles, and how exact they say they are.

use std::collections::HashMap;

use loftsman_kernel::scene::Unit;

use super::entity::{Got, Problem, deeper, entity};
use super::place::Units;
use crate::part21::{Entity, File, Value};

/// What a context says.
#[derive(Debug, Clone, Copy)]
struct Context {
    /// How many metres the unit of length is.
    metres: Option<f64>,
    /// How many radians that of angles is.
    radians: Option<f64>,
    /// How exact lengths are, in its own unit.
    uncertainty: f64,
}

/// The units of all contexts that were asked for.
#[derive(Default)]
pub(crate) struct Contexts {
    known: HashMap<u64, Context>,
    /// The unit of the scene: that of the first context that says one.
    metres: Option<f64>,
    /// Whether some context says no unit of length, and the first that does not.
    pub(crate) silent: bool,
    unsaid: Option<u64>,
}

impl Contexts {
    /// An entity that should name a unit of length does not.
    pub(crate) fn miss(&mut self, number: u64) {
        self.silent = true;
        self.unsaid.get_or_insert(number);
    }

    /// The units of a context, in the scene's. One that says no unit of length is taken to have the scene's.
    pub(crate) fn units(&mut self, file: &File<'_>, number: u64) -> Got<Units> {
        let context = match self.known.get(&number) {
            Some(context) => *context,
            None => {
                let context = context(file, number)?;
                self.known.insert(number, context);
                context
            }
        };
        if context.metres.is_none() {
            self.miss(number);
        }
        let scale = match (context.metres, self.metres) {
            (Some(own), Some(all)) if own != all => own / all,
            (Some(own), None) => {
                self.metres = Some(own);
                1.0
            }
            _ => 1.0,
        };
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Problem::new(number, "its unit is too far from that of the rest of the file"));
        }
        let tolerance = context.uncertainty * scale;
        Ok(Units { scale, angle: context.radians.unwrap_or(1.0), tolerance })
    }

    /// What is said of a context without a unit of length.
    pub(crate) fn told_silent(&self, file: &File<'_>) -> String {
        let known = self.unsaid.and_then(|number| Some((number, file.line_of(file.place(number)?))));
        let which = known.map_or_else(
            || "a part of the file".to_owned(),
            |(number, line)| format!("#{number}, line {line},"),
        );
        let taken = match self.metres {
            Some(_) => "its lengths are taken to be in the unit of the rest",
            None => "its numbers are taken as they are: name the unit of the input if it has one",
        };
        format!("{which} says no unit of length: {taken}")
    }

    /// The unit of the scene.
    pub(crate) fn unit(&self) -> Unit {
        self.metres.and_then(Unit::of_metres).unwrap_or(Unit::Unknown)
    }
}

fn context(file: &File<'_>, number: u64) -> Got<Context> {
    let entity_ = entity(file, number)?;
    let mut context = Context { metres: None, radians: None, uncertainty: 0.0 };
    if entity_.part("GLOBAL_UNIT_ASSIGNED_CONTEXT").is_some() {
        for unit in entity_.of("GLOBAL_UNIT_ASSIGNED_CONTEXT")?.references(0)? {
            let unit = entity(file, unit)?;
            if unit.part("LENGTH_UNIT").is_some() {
                context.metres = Some(measure(file, &unit, 0)?);
            } else if unit.part("PLANE_ANGLE_UNIT").is_some() {
                context.radians = Some(measure(file, &unit, 0)?);
            }
        }
    }
    if entity_.part("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT").is_some() {
        for number in entity_.of("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT")?.references(0)? {
            let uncertainty = entity(file, number)?;
            let args = uncertainty.args();
            let is_length = match args.values.first() {
                Some(Value::Typed(kind, _)) => kind.ends_with(b"LENGTH_MEASURE"),
                _ => true,
            };
            // It may be said in another unit than that of lengths.
            let unit = args.optional(1)?.map(|unit| measure(file, &entity(file, unit)?, 0)).transpose()?;
            let factor = match (unit, context.metres) {
                (Some(own), Some(all)) => own / all,
                _ => 1.0,
            };
            let value = args.real(0)? * factor;
            if is_length && value > context.uncertainty && value.is_finite() {
                context.uncertainty = value;
            }
        }
    }
    Ok(context)
}

/// How many metres or radians a unit is.
fn measure(file: &File<'_>, unit: &Entity<'_>, depth: usize) -> Got<f64> {
    let depth = deeper(unit.number, depth)?;
    let number = unit.number;
    let factor = if unit.part("SI_UNIT").is_some() {
        let args = unit.of("SI_UNIT")?;
        // In an entity of several types SI_UNIT has a prefix and a name only, alone also the dimensions first.
        let prefix = args.values.len().saturating_sub(2);
        match &args.values.get(prefix) {
            Some(Value::Enumeration(name)) => match prefixed(name) {
                Some(factor) => factor,
                None => {
                    let name = String::from_utf8_lossy(name);
                    return Err(Problem::new(number, format!("the unit prefix .{name}. is none")));
                }
            },
            _ => 1.0,
        }
    } else if unit.part("CONVERSION_BASED_UNIT").is_some() {
        let of = unit.of("CONVERSION_BASED_UNIT")?;
        let by = entity(file, of.reference(1)?)?;
        let args = by.args();
        // Also of several types at once: the part with value and unit.
        let args = if by.part("MEASURE_WITH_UNIT").is_some() { by.of("MEASURE_WITH_UNIT")? } else { args };
        args.real(0)? * measure(file, &entity(file, args.reference(1)?)?, depth)?
    } else {
        return Err(Problem::new(number, format!("the unit {} is not read", unit.kinds())));
    };
    if factor > 0.0 && factor.is_finite() {
        // Products of prefixes and factors are off by rounding: 25.4 thousandths of a metre are an inch.
        let named = Unit::ALL.iter().filter_map(|(_, unit)| unit.metres());
        let near = named.into_iter().find(|metres| (metres - factor).abs() <= 1e-14 * factor);
        return Ok(near.unwrap_or(factor));
    }
    Err(Problem::new(number, format!("a unit of {factor}: it must be positive")))
}

fn prefixed(name: &[u8]) -> Option<f64> {
    Some(match name {
        b"EXA" => 1e18,
        b"PETA" => 1e15,
        b"TERA" => 1e12,
        b"GIGA" => 1e9,
        b"MEGA" => 1e6,
        b"KILO" => 1e3,
        b"HECTO" => 1e2,
        b"DECA" => 1e1,
        b"DECI" => 1e-1,
        b"CENTI" => 1e-2,
        b"MILLI" => 1e-3,
        b"MICRO" => 1e-6,
        b"NANO" => 1e-9,
        b"PICO" => 1e-12,
        b"FEMTO" => 1e-15,
        b"ATTO" => 1e-18,
        _ => return None,
    })
}
