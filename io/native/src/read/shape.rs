//! Shapes of plug-ins: read by their kinds, or kept word for word where these are not here.

use loftsman_kernel::plugin::{CustomShape, Parameters, ReadOptions};
use loftsman_kernel::text::clip;
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use super::trail::Trail;

/// Reads `"shape"`: its `kind`, and the fields that this has.
pub(super) struct ShapeSeed<'s, 't> {
    pub(super) trail: &'t Trail,
    pub(super) options: &'s ReadOptions<'s>,
}

impl<'de> DeserializeSeed<'de> for ShapeSeed<'_, '_> {
    type Value = CustomShape;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<CustomShape, D::Error> {
        let Self { trail, options } = self;
        let text = <&RawValue>::deserialize(deserializer)?.get();
        // What is said of places in here is said of the whole: the reader stands behind it.
        let fields = serde_json::from_str::<Fields<'_>>(text)
            .map_err(|error| trail.refuse_table("", problem(&error.to_string())))?;
        let mut kind = None;
        for (k, (name, value)) in fields.0.iter().enumerate() {
            if fields.0[..k].iter().any(|(known, _)| known == name) {
                return Err(
                    trail.refuse_table("", format!("the field \"{}\" is there twice: keep one", clip(name)))
                );
            }
            if name == "kind" {
                let text = serde_json::from_str::<String>(value.get());
                kind =
                    Some(text.map_err(|_| {
                        trail.refuse_table("kind", "the name of a kind of shape is needed here")
                    })?);
            }
        }
        let Some(kind) = kind.filter(|kind| !kind.is_empty()) else {
            let problem =
                "a shape needs the field \"kind\": the name that its plug-in gave to shapes like it";
            return Err(trail.refuse_table("", problem));
        };
        let Some(known) = options.kind(&kind) else { return Ok(CustomShape::unknown(kind, text)) };
        let mut own = Parameters::empty("");
        for (name, value) in fields.0.iter().filter(|(name, _)| name != "kind") {
            let value = serde_json::from_str::<Value>(value.get())
                .map_err(|error| trail.refuse_table(clip(name), problem(&error.to_string())))?;
            own = own.with(name.as_str(), value);
        }
        CustomShape::read(known, &own).map_err(|error| trail.refuse_table(error.path, error.problem))
    }
}

/// What the parser says of a part of the document: its own lines mean nothing to anybody.
fn problem(message: &str) -> String {
    let message = message.rsplit_once(" at line ").map_or(message, |(message, _)| message);
    match message {
        "number out of range" => {
            "a number is too large: every number must be finite, at most 1.8e308".to_owned()
        }
        "recursion limit exceeded" => {
            "the brackets are nested too deeply for a document; close those before".to_owned()
        }
        other if other.len() < 200 => other.to_owned(),
        other => clip(other),
    }
}

/// The fields of a table, their values still as they stand.
struct Fields<'de>(Vec<(String, &'de RawValue)>);

impl<'de> Deserialize<'de> for Fields<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct All;
        impl<'de> Visitor<'de> for All {
            type Value = Fields<'de>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "a shape, a table of its \"kind\" and the fields of that")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields<'de>, A::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                    if fields.len() > MOST {
                        return Err(A::Error::custom("a shape has more fields than any kind can declare"));
                    }
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(All)
    }
}

/// Fields that a shape may have: none has a tenth of that, and each is compared with those before it.
const MOST: usize = 1000;
