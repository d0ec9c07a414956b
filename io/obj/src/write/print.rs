//! Numbers and names as OBJ has them.

use std::collections::{HashMap, HashSet};
use std::fmt::Write;

/// Appends a blank and the shortest text that reads back as the same number.
pub(crate) fn number(out: &mut String, value: f64) {
    // Writing to a string cannot fail.
    _ = if value.fract() == 0.0 && value.abs() < 1e15 && !(value == 0.0 && value.is_sign_negative()) {
        write!(out, " {}", value as i64)
    } else {
        // Debug, unlike Display, has exponents: 1e300 stays short.
        write!(out, " {value:?}")
    };
}

/// A name that stays on its line and means the same to every reader.
pub(crate) fn name(name: &str) -> String {
    let mut clean: String = name.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
    clean = clean.trim().to_owned();
    if clean.ends_with('\\') {
        clean.pop();
        clean.push('_');
    }
    if clean.starts_with('#') {
        clean.insert(0, '_');
    }
    if clean.contains(" #") {
        clean = clean.replace(" #", " _#");
    }
    if clean.is_empty() { "object".to_owned() } else { clean }
}

/// Names that are taken, each with the last number behind it that was tried: all before it are taken too; and those that are kept for what has them in
/// the scene.
#[derive(Debug, Default)]
pub(crate) struct Names {
    taken: HashMap<String, usize>,
    kept: HashSet<String>,
}

impl Names {
    /// None is taken, and no number behind a name makes one of these of it.
    pub(crate) fn beside<'n>(names: impl Iterator<Item = &'n str>) -> Self {
        Self { taken: HashMap::new(), kept: names.map(name).collect() }
    }

    /// A name that stays on its line and that nobody else has: with a number behind it where it is taken.
    pub(crate) fn unique(&mut self, wanted: &str) -> String {
        let clean = name(wanted);
        let mut unique = clean.clone();
        if let Some(&tried) = self.taken.get(&clean) {
            let mut number = tried;
            while self.taken.contains_key(&unique) || (number > tried && self.kept.contains(&unique)) {
                number += 1;
                unique = format!("{clean}.{number:03}");
            }
            self.taken.insert(clean, number);
        }
        self.taken.insert(unique.clone(), 0);
        unique
    }
}

/// A group's name, which ends at a blank; "default" is the group of what no group was named for.
pub(crate) fn group(name: &str) -> String {
    let clean: String =
        name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
    match clean.as_str() {
        "" => "group".to_owned(),
        "default" => "default_".to_owned(),
        _ if clean.starts_with('#') || clean.ends_with('\\') => format!("_{}_", clean.trim_end_matches('\\')),
        _ => clean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_to_the_bit() {
        for value in [0.0, -0.0, 1.0, -3.0, 0.1, 1.0 / 3.0, 1e300, -5e-324, 1e15, 123_456_789.123_456_79] {
            let mut text = String::new();
            number(&mut text, value);
            let back: f64 = text.trim().parse().unwrap();
            assert_eq!(back.to_bits(), value.to_bits(), "{text}");
        }
    }

    #[test]
    fn names_cannot_break_lines_or_start_comments() {
        assert_eq!(name("a\nb"), "a_b");
        assert_eq!(name(" x #y\\"), "x _#y_");
        assert_eq!(name("\t"), "_");
    }
}
