//! One number of a row.

/// What is wrong with a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberFault {
    /// No number at all.
    Word,
    /// `nan`, `inf`, `1.#QNAN` and the like.
    NotFinite,
    /// Beyond 1.8e308.
    TooLarge,
    /// A decimal comma in one number, a decimal point in another.
    Mixed,
}

impl NumberFault {
    /// What to say about it.
    pub(super) fn says(self) -> &'static str {
        match self {
            Self::Word => "is not a number",
            Self::NotFinite => "is not finite: every coordinate must be, take the row out or mend it",
            Self::TooLarge => "is too large: every coordinate must be finite, at most 1.8e308",
            Self::Mixed => {
                "mixes decimal commas and decimal points: use one of them (and no thousands separators)"
            }
        }
    }
}

/// Which decimal signs have been met.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Signs {
    pub(super) points: bool,
    pub(super) commas: bool,
}

/// Reads a number: decimal, with an exponent after `e`, `E` or, as Fortran writes it, `d` or `D`; with a decimal
/// comma where `comma` allows it.
pub(super) fn parse(token: &[u8], comma: bool, signs: &mut Signs) -> Result<f64, NumberFault> {
    // The longest shortest-round-trip number has 24 characters; some programs write 50.
    const LONGEST: usize = 400;
    let mut special = false;
    let mut digits = 0;
    for (i, &b) in token.iter().enumerate() {
        match b {
            b'0'..=b'9' => digits += 1,
            b'+' | b'-' | b'e' | b'E' => {}
            b'.' => signs.points = true,
            b'd' | b'D' if digits > 0 => special = true,
            b',' if comma && between_digits(token, i) => {
                special = true;
                signs.commas = true;
            }
            _ => return Err(word(token)),
        }
    }
    if digits == 0 || token.len() > LONGEST {
        return Err(word(token));
    }
    if signs.points && signs.commas {
        return Err(NumberFault::Mixed);
    }
    let text = std::str::from_utf8(token).map_err(|_| NumberFault::Word)?;
    let value = if special {
        let usual: String = text
            .chars()
            .map(|c| match c {
                'd' | 'D' => 'e',
                ',' => '.',
                c => c,
            })
            .collect();
        usual.parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match value {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(NumberFault::TooLarge),
        Err(_) => Err(NumberFault::Word),
    }
}

fn between_digits(token: &[u8], i: usize) -> bool {
    i > 0 && token[i - 1].is_ascii_digit() && token.get(i + 1).is_some_and(u8::is_ascii_digit)
}

/// Whether a token that is no number is one of the spellings of NaN and infinity.
fn word(token: &[u8]) -> NumberFault {
    let start = token.iter().position(|b| !matches!(b, b'+' | b'-')).unwrap_or(0);
    let bare = token[start..].to_ascii_lowercase();
    let starts = |names: &[&str]| names.iter().any(|name| bare.starts_with(name.as_bytes()));
    let spelled = matches!(bare.as_slice(), b"nan" | b"inf" | b"infinity" | b"infinite")
        || starts(&["nan(", "1.#", "nanq", "nans"]);
    if spelled { NumberFault::NotFinite } else { NumberFault::Word }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(token: &str) -> Result<f64, NumberFault> {
        parse(token.as_bytes(), false, &mut Signs::default())
    }

    #[test]
    fn numbers_in_all_their_spellings() {
        for (token, value) in [
            ("1", 1.0),
            ("+.5", 0.5),
            ("-5.", -5.0),
            ("0.2137733E-02", 0.002_137_733),
            ("1.0D-3", 1e-3),
            ("1d+2", 100.0),
            ("1e-400", 0.0),
            ("5e-324", 5e-324),
        ] {
            assert_eq!(plain(token), Ok(value), "{token}");
        }
        assert!(plain("-0").unwrap().is_sign_negative());
        for token in ["", "+", "e5", "1e", "1.2.3", "--1", "0x10", "1_000", "1,5", "d1", "é", "1-2", "."] {
            assert_eq!(plain(token), Err(NumberFault::Word), "{token}");
        }
        for token in ["nan", "NaN", "-nan(ind)", "Inf", "-Infinity", "1.#QNAN", "-1.#INF"] {
            assert_eq!(plain(token), Err(NumberFault::NotFinite), "{token}");
        }
        assert_eq!(plain("1e999"), Err(NumberFault::TooLarge));
    }

    #[test]
    fn decimal_commas_where_they_are_allowed_and_alone() {
        let mut signs = Signs::default();
        assert_eq!(parse(b"-1,5", true, &mut signs), Ok(-1.5));
        assert_eq!(parse(b"2,5E3", true, &mut signs), Ok(2500.0));
        assert_eq!(parse(b",5", true, &mut signs), Err(NumberFault::Word));
        assert_eq!(parse(b"1,2,3", true, &mut signs), Err(NumberFault::Word));
        assert_eq!(parse(b"1.5", true, &mut signs), Err(NumberFault::Mixed));
        assert_eq!(parse(b"1,234.5", true, &mut Signs::default()), Err(NumberFault::Mixed));
    }
}
