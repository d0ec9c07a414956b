//! The comments that keep what a row of numbers cannot say.

use loftsman_kernel::scene::{Unit, Up};

/// Whether rows are a chain or loose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A chain; closed where that is known.
    Polyline {
        /// Whether it is closed; none where the points have to tell.
        closed: Option<bool>,
    },
    /// Loose points.
    Cloud,
}

const FILE: &str = " loftsman points, unit ";

/// The comment at the head of a file, without the `#`: ` loftsman points, unit mm, z up`.
pub(crate) fn file_mark(unit: Unit, up: Up) -> String {
    format!("{FILE}{}, {} up", unit.name(), up.name())
}

/// Reads [`file_mark`].
pub(crate) fn file(comment: &[u8]) -> Option<(Unit, Up)> {
    let text = std::str::from_utf8(comment).ok()?.strip_prefix(FILE)?;
    let (unit, up) = text.strip_suffix(" up")?.split_once(", ")?;
    Some((Unit::from_name(unit)?, Up::from_name(up)?))
}

/// The comment before an object: ` closed polyline "name"`, the name as JSON has it, on one line.
pub(crate) fn object_mark(name: &str, kind: Kind) -> String {
    let kind = match kind {
        Kind::Cloud => "cloud",
        Kind::Polyline { closed: Some(true) } => "closed polyline",
        Kind::Polyline { .. } => "open polyline",
    };
    format!(" {kind} {}", serde_json::Value::from(name))
}

/// Reads [`object_mark`].
pub(crate) fn object(comment: &[u8]) -> Option<(String, Kind)> {
    let text = std::str::from_utf8(comment).ok()?;
    let quote = text.find('"')?;
    let kind = match &text[..quote] {
        " cloud " => Kind::Cloud,
        " open polyline " => Kind::Polyline { closed: Some(false) },
        " closed polyline " => Kind::Polyline { closed: Some(true) },
        _ => return None,
    };
    Some((serde_json::from_str(&text[quote..]).ok()?, kind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_read_back() {
        for (_, unit) in Unit::ALL {
            assert_eq!(file(file_mark(unit, Up::Y).as_bytes()), Some((unit, Up::Y)));
        }
        for kind in
            [Kind::Cloud, Kind::Polyline { closed: Some(true) }, Kind::Polyline { closed: Some(false) }]
        {
            let name = "a \"b\"\r\n# é";
            let mark = object_mark(name, kind);
            assert!(!mark.contains(['\n', '\r']));
            assert_eq!(object(mark.as_bytes()), Some((name.to_owned(), kind)));
        }
        assert_eq!(object(b" a cloud \"x\""), None);
    }
}
