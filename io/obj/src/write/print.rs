//! Numbers and names as OBJ has them.

use std::collections::HashMap;
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

/// Names that are taken, each with the last number behind it that was tried: all before it are taken too.
#[derive(Debug, Default)]
pub(crate) struct Names(HashMap<String, usize>);

impl Names {
    /// A name that stays on its line and that nobody else has: with a number behind it where it is taken.
    pub(crate) fn unique(&mut self, wanted: &str) -> String {
        let clean = name(wanted);
        let mut unique = clean.clone();
        if let Some(&tried) = self.0.get(&clean) {
            let mut number = tried;
            while self.0.contains_key(&unique) {
                number += 1;
                unique = format!("{clean}.{number:03}");
            }
            self.0.insert(clean, number);
        }
        self.0.insert(unique.clone(), 0);
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
