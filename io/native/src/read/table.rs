//! Tables (JSON objects) with known fields: unknown and repeated ones are refused.

use std::fmt;

use loftsman_kernel::plugin::hint;
use loftsman_kernel::text::clip;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, Visitor};

use super::trail::Trail;

/// A table that is being read.
pub(super) trait Table<'de>: Sized {
    /// What it becomes.
    type Out;
    /// What to call it in messages, with its article: `"a curve"`.
    const WHAT: &'static str;
    /// The fields it may have.
    const FIELDS: &'static [&'static str];

    /// Reads the value of a field, one of [`FIELDS`](Self::FIELDS).
    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error>;

    /// Checks the whole and makes what it becomes.
    fn finish<E: serde::de::Error>(self, trail: &Trail) -> Result<Self::Out, E>;
}

/// Reads a table.
pub(super) struct TableSeed<'t, T> {
    /// Where errors leave their path.
    pub(super) trail: &'t Trail,
    /// The table, still empty.
    pub(super) table: T,
}

impl<'de, T: Table<'de>> DeserializeSeed<'de> for TableSeed<'_, T> {
    type Value = T::Out;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<T::Out, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, T: Table<'de>> Visitor<'de> for TableSeed<'_, T> {
    type Value = T::Out;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, a table of {}", T::WHAT, Names(T::FIELDS))
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<T::Out, A::Error> {
        // One bit a field; no table has more than 32.
        let mut seen = 0_u32;
        while let Some(key) = map.next_key::<String>()? {
            let Some(at) = T::FIELDS.iter().position(|field| *field == key) else {
                return Err(self.trail.refuse(unknown::<T>(&key)));
            };
            if seen & (1 << at) != 0 {
                return Err(self.trail.refuse(format!("the field \"{key}\" is there twice: keep one")));
            }
            seen |= 1 << at;
            let name = T::FIELDS[at];
            self.trail.field(name, self.table.field(name, &mut map, self.trail))?;
        }
        self.table.finish(self.trail)
    }
}

/// A field that must be there.
pub(super) fn need<'de, T: Table<'de>, V, E: serde::de::Error>(
    value: Option<V>,
    name: &str,
    trail: &Trail,
) -> Result<V, E> {
    value.ok_or_else(|| trail.refuse_table("", format!("{} needs the field \"{name}\"", T::WHAT)))
}

fn unknown<'de, T: Table<'de>>(key: &str) -> String {
    let hint = hint(key, T::FIELDS.iter().copied(), || match T::FIELDS {
        [] => "it takes none".to_owned(),
        known => format!("known are {}", Names(known)),
    });
    format!("{} has no field \"{}\"; {hint}", T::WHAT, clip(key))
}

/// Names, with commas.
struct Names(&'static [&'static str]);

impl fmt::Display for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return write!(f, "nothing: {{}}");
        }
        for (i, name) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}\"{name}\"")?;
        }
        Ok(())
    }
}
