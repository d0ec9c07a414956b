//! Numbers and indices, read from the bytes.

use crate::text::show;

/// Powers of ten that are floats without rounding.
const EXACT: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Takes the first number of a text, behind blanks; nothing where the text ends or a comment starts. `text` is then
/// what follows the number.
///
/// The nearest float, always: where the digits are at most `2^53` and the power of ten at most `10^22`, both are floats
/// without rounding and one division or product rounds once (Clinger 1990); all else goes to the standard library.
pub(crate) fn next_number(text: &mut &[u8]) -> Result<Option<f64>, String> {
    let start = text.trim_ascii_start();
    if start.is_empty() || start[0] == b'#' {
        *text = &[];
        return Ok(None);
    }
    let (negative, mut at) = match start[0] {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let (mut digits, mut first) = (0_u64, at);
    let mut behind = 0;
    while let Some(digit) = start.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
        digits = digits.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    let mut count = at - first;
    if start.get(at) == Some(&b'.') {
        at += 1;
        first = at;
        while let Some(digit) = start.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
            digits = digits.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        behind = at - first;
        count += behind;
    }
    // 19 digits cannot have wrapped around.
    if start.get(at).is_none_or(u8::is_ascii_whitespace)
        && (1..=19).contains(&count)
        && digits <= 1 << 53
        && let Some(power) = EXACT.get(behind)
    {
        *text = &start[at..];
        let value = digits as f64 / power;
        return Ok(Some(if negative { -value } else { value }));
    }
    let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
    *text = &start[end..];
    number(&start[..end]).map(Some)
}

/// A finite number. An exponent may have a `d`, as Fortran writes it.
#[cold]
pub(crate) fn number(word: &[u8]) -> Result<f64, String> {
    let text = std::str::from_utf8(word).unwrap_or("?");
    let value = text.parse::<f64>().ok().or_else(|| {
        let plain = |b: u8| b.is_ascii_digit() || b"+-.dD".contains(&b);
        word.iter().all(|&b| plain(b)).then(|| text.replace(['d', 'D'], "e").parse().ok()).flatten()
    });
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(value) => Err(format!("the number \"{}\" is {value}: every number must be finite", show(word))),
        None => Err(format!("\"{}\" is not a number", show(word))),
    }
}

/// An index as it is written: from 1 up, or from -1 down from the newest. `text` is then what follows the digits.
pub(crate) fn index(text: &mut &[u8]) -> Option<i64> {
    let (negative, start) = match text.first() {
        Some(b'-') => (true, 1),
        Some(b'+') => (false, 1),
        _ => (false, 0),
    };
    let mut at = start;
    let mut value = 0_i64;
    while let Some(digit) = text.get(at).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
        value = value.wrapping_mul(10).wrapping_add(i64::from(digit));
        at += 1;
    }
    if at == start || at > start + 18 {
        return None;
    }
    *text = &text[at..];
    Some(if negative { -value } else { value })
}

/// Which entry of a list, counted from 0, an index means after `count` of them. Entries that come later in the file
/// are allowed.
pub(crate) fn resolve(index: i64, count: usize, what: &str) -> Result<u32, String> {
    let entry = match index {
        1.. => index - 1,
        0 => return Err(format!("there is no {what} 0: numbers start at 1, or at -1 from the end")),
        _ => index + count as i64,
    };
    if entry < 0 {
        return Err(format!("the index {index} leads before the first {what}: there are {count} so far"));
    }
    u32::try_from(entry)
        .ok()
        .filter(|&i| i < u32::MAX)
        .ok_or_else(|| format!("the index {index} is too large"))
}

/// The entry that a whole word means.
pub(crate) fn entry(word: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let mut rest = word;
    match index(&mut rest).filter(|_| rest.is_empty()) {
        Some(index) => resolve(index, count, what),
        None => Err(format!("\"{}\" is not the number of a {what}", show(word))),
    }
}

/// Reads numbers into `out`; how many there were.
pub(crate) fn fill(mut text: &[u8], out: &mut [f64]) -> Result<usize, String> {
    let mut count = 0;
    while let Some(value) = next_number(&mut text)? {
        if let Some(slot) = out.get_mut(count) {
            *slot = value;
        }
        count += 1;
    }
    Ok(count)
}

/// All numbers of a text.
pub(crate) fn numbers(mut text: &[u8]) -> Result<Vec<f64>, String> {
    let mut out = Vec::new();
    while let Some(value) = next_number(&mut text)? {
        out.push(value);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn one(text: &str) -> Result<f64, String> {
        let mut rest = text.as_bytes();
        let value = next_number(&mut rest)?.unwrap();
        assert!(rest.is_empty(), "{text}");
        Ok(value)
    }

    #[test]
    fn numbers_are_finite_or_errors() {
        for (text, value) in [
            ("+1.", 1.0),
            ("-.5", -0.5),
            ("2.e1", 20.0),
            ("1E-2", 0.01),
            ("1d0", 1.0),
            ("-2.5D+1", -25.0),
            ("9007199254740993", 9_007_199_254_740_992.0),
            ("0.1", 0.1),
            ("123456789012345678901234567890", 123_456_789_012_345_678_901_234_567_890.0),
            ("0.0000000000000000000000000000001", 1e-31),
            ("1e-400", 0.0),
        ] {
            assert_eq!(one(text), Ok(value), "{text}");
        }
        assert!(one("-0").unwrap().is_sign_negative());
        for text in
            ["nan", "inf", "1e999", "3.1+e2", "0x10", "1,5", "-", "+", ".", "e", "1d", "d0", "1#", "--1"]
        {
            assert!(one(text).is_err(), "{text}");
        }
        assert_eq!(numbers(b" 1\t2 # 3"), Ok(vec![1.0, 2.0]));
    }

    #[test]
    fn indices_count_from_either_end() {
        assert_eq!(entry(b"3", 2, "vertex"), Ok(2));
        assert_eq!(entry(b"-2", 2, "vertex"), Ok(0));
        assert_eq!(entry(b"+1", 0, "vertex"), Ok(0));
        for wrong in ["0", "-3", "1.0", "", "-", "4294967296", "9999999999999999999", "1/2"] {
            assert!(entry(wrong.as_bytes(), 2, "vertex").is_err(), "{wrong}");
        }
    }

    proptest! {
        #[test]
        fn numbers_are_the_nearest_floats(text in "[+-]?[0-9]{1,22}(\\.[0-9]{0,22})?([eE][+-]?[0-9]{1,2})?") {
            prop_assert_eq!(one(&text).unwrap().to_bits(), text.parse::<f64>().unwrap().to_bits());
        }
    }
}
