//! Text of files and messages: what all formats write and read alike.

mod encoding;

use std::io::{self, Write};

pub use encoding::{Encoding, decoded};

/// A noun behind its article: `"a curve"`, `"an instance"`.
pub fn a(noun: &str) -> String {
    let article = if noun.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    format!("{article} {noun}")
}

/// A number before the words that go with it: of `[one|several]` those for one where it is 1, else the others. For texts of our own, into
/// which nothing of a file's has been put: that comes behind.
///
/// ```
/// use loftsman_kernel::text::counted;
///
/// let meshes = |count| counted(count, "mesh[|es] [has|have] tangents");
/// assert_eq!([0, 1, 2].map(meshes), ["0 meshes have tangents", "1 mesh has tangents", "2 meshes have tangents"]);
/// ```
pub fn counted(count: usize, words: &str) -> String {
    let mut text = format!("{count} ");
    let mut rest = words;
    while let Some((before, (one, several, after))) = rest.split_once('[').and_then(|(before, choice)| {
        let (choice, after) = choice.split_once(']')?;
        let (one, several) = choice.split_once('|')?;
        Some((before, (one, several, after)))
    }) {
        text.push_str(before);
        text.push_str(if count == 1 { one } else { several });
        rest = after;
    }
    text.push_str(rest);
    text
}

/// The start of a text, on one line and printable: what a file says may be a megabyte long.
///
/// ```
/// assert_eq!(loftsman_kernel::text::clip("a\nname"), "a\\nname");
/// assert_eq!(loftsman_kernel::text::clip(&"a".repeat(99)), format!("{}…", "a".repeat(60)));
/// ```
pub fn clip(text: &str) -> String {
    clip_to(60, text)
}

/// The same, of so many characters.
pub fn clip_to(most: usize, text: &str) -> String {
    let mut short: String = text.chars().take(most).flat_map(char::escape_debug).collect();
    if text.chars().nth(most).is_some() {
        short.push('…');
    }
    short
}

/// A number in about four figures, as people write it: plain from a ten-thousandth to a thousand million, else with an exponent.
///
/// ```
/// use loftsman_kernel::text::figure;
///
/// assert_eq!([0.0001976, 0.1, 2.165196, 12345.6, 3e-9].map(figure), ["0.0001976", "0.1", "2.165", "12346", "3e-9"]);
/// assert_eq!([15_234_567.8, 2.5e12].map(figure), ["15234568", "2.5e12"]);
/// ```
pub fn figure(number: f64) -> String {
    figures(number, 4)
}

/// The same in about two figures, for what is only said to tell how large it is: `0.0077`, `2.4e-16`.
pub fn short(number: f64) -> String {
    figures(number, 2)
}

/// The same in about six figures, for what is measured and may be copied: places, parameters, lengths.
///
/// ```
/// use loftsman_kernel::text::measured;
///
/// assert_eq!([0.3576882987033557, 0.00000357770876, -0.0, 213.628300].map(measured), ["0.357688", "3.57771e-6", "0", "213.628"]);
/// ```
pub fn measured(number: f64) -> String {
    figures(number, 6)
}

/// What is measured, without what is only rounding of what it was measured on: 0 where it is no more than a few units in the last place of that.
///
/// ```
/// use loftsman_kernel::text::without_rounding;
///
/// assert_eq!([2.448e-32, -0.0, 3.1e-16, 1e-9].map(|found| without_rounding(found, 2.0)), [0.0, 0.0, 0.0, 1e-9]);
/// ```
pub fn without_rounding(found: f64, size: f64) -> f64 {
    if found.abs() <= ROUNDING * size.abs() { 0.0 } else { found }
}

/// Units in the last place that a few sums of numbers leave.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Numbers in about six figures, or in so many more that no two that differ look alike.
///
/// ```
/// use loftsman_kernel::text::told_apart;
///
/// assert_eq!(told_apart(&[5.0, 1.0 / 3.0]), ["5", "0.333333"]);
/// assert_eq!(told_apart(&[5.0, 5.00000001, 5.0]), ["5", "5.00000001", "5"]);
/// ```
pub fn told_apart(numbers: &[f64]) -> Vec<String> {
    let mut order: Vec<f64> = numbers.iter().map(|number| number + 0.0).collect();
    order.sort_by(f64::total_cmp);
    order.dedup_by(|a, b| a.total_cmp(b).is_eq());
    let apart = |digits: usize| {
        // What is rounded alike lies side by side.
        order.windows(2).all(|pair| figures(pair[0], digits) != figures(pair[1], digits))
    };
    match (6..=17).find(|&digits| apart(digits)) {
        Some(digits) => numbers.iter().map(|&number| figures(number, digits)).collect(),
        None => numbers.iter().map(f64::to_string).collect(),
    }
}

fn figures(number: f64, digits: usize) -> String {
    // No zero is below nothing.
    let number = number + 0.0;
    let size = number.abs();
    if !(size == 0.0 || (1e-4..1e9).contains(&size)) {
        let text = format!("{number:.*e}", digits - 1);
        let Some((digits, exponent)) = text.split_once('e') else { return text };
        return format!("{}e{exponent}", without_zeros(digits));
    }
    let digits = digits as i32 - 1;
    let decimals = if size == 0.0 { 0 } else { (digits - size.log10().floor() as i32).clamp(0, 20) as usize };
    without_zeros(&format!("{number:.decimals$}")).to_owned()
}

/// Decimals without zeros at their end.
fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Writes the shortest decimals that read back as the same bits. Whole numbers come without a point, but for minus zero, whose
/// sign most readers would lose otherwise.
///
/// # Errors
/// Those of the stream.
pub fn number(out: &mut impl Write, x: f64) -> io::Result<()> {
    // Below 2^53 the conversion is exact.
    let whole = x as i64;
    if whole as f64 == x && whole.unsigned_abs() < 1 << 53 && (whole != 0 || x.is_sign_positive()) {
        return Ok(serde_json::to_writer(out, &whole)?);
    }
    Ok(serde_json::to_writer(out, &x)?)
}

/// The bytes without the byte order mark of UTF-8.
pub fn unmarked(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Whether the start of a file is that of a JSON table which has this key itself, not within a table or list of its own.
pub fn has_key(head: &[u8], key: &str) -> bool {
    let head = unmarked(head).trim_ascii_start();
    let (mut depth, mut at) = (0_usize, 0);
    while let Some(&byte) = head.get(at) {
        at += 1;
        match byte {
            b'{' | b'[' => depth += 1,
            b'}' | b']' => depth = depth.saturating_sub(1),
            b'"' => {
                let text = at;
                while head.get(at).is_some_and(|&b| b != b'"') {
                    at += if head[at] == b'\\' { 2 } else { 1 };
                }
                let end = at.min(head.len());
                at += 1;
                let follows = head.get(at..).is_some_and(|rest| rest.trim_ascii_start().starts_with(b":"));
                if depth == 1 && follows && &head[text..end] == key.as_bytes() {
                    return head.starts_with(b"{");
                }
            }
            _ => {}
        }
    }
    false
}

/// What a JSON parser found, and what to do; without the position, which is said elsewhere.
pub fn json_problem(text: &str, error: &serde_json::Error) -> String {
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
    if error.is_eof() {
        return format!("it ends in the middle ({message}): it was cut off, or a bracket is not closed");
    }
    if let Some(word) = not_a_number(text, error.line(), error.column()) {
        return format!(
            "{word} is not a number that JSON can hold: every number must be finite; write a finite one"
        );
    }
    match message {
        "number out of range" => {
            "the number is too large: every number must be finite, at most 1.8e308".to_owned()
        }
        "recursion limit exceeded" => "the brackets are nested too deeply; close those before".to_owned(),
        _ if error.is_syntax() => format!("this is not JSON: {}", clip_to(200, message)),
        // The parser quotes the text it found in full, which may be a megabyte.
        _ => match message.rsplit_once(", expected ").filter(|_| message.chars().count() > 200) {
            Some((start, expected)) => format!("{}, expected {expected}", clip(start)),
            None => message.to_owned(),
        },
    }
}

/// `NaN`, `Infinity` and the like where a value should be: the parser stands on the word or behind it.
fn not_a_number(text: &str, line: usize, column: usize) -> Option<&str> {
    let line = text.split('\n').nth(line.checked_sub(1)?)?;
    let word = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'+');
    let (before, after) = line.as_bytes().split_at_checked(column.min(line.len()))?;
    let start = before.len() - before.iter().rev().take_while(|b| word(b)).count();
    let end = before.len() + after.iter().take_while(|b| word(b)).count();
    let found = line.get(start..end)?;
    let plain = found.trim_start_matches(['-', '+']).to_ascii_lowercase();
    matches!(plain.as_str(), "nan" | "inf" | "infinity").then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_the_outermost_table_only() {
        let has = |text: &str| has_key(text.as_bytes(), "asset");
        assert!(has("\u{feff} {\"scene\": 0, \"a\": [{\"b\": \"\\\"}\"}], \"asset\" : {}"));
        for other in [
            "{\"extras\": {\"asset\": 1}}",
            "[\"asset\", 1]",
            "[{\"asset\": 1}]",
            "{\"a\": \"asset\"}",
            "{\"asset\"",
            "{\"asset",
            "{\"\\",
            "\"asset\": 1",
            "",
        ] {
            assert!(!has(other), "{other}");
        }
    }

    #[test]
    fn nouns_have_their_article() {
        assert_eq!([a("curve"), a("instance")], ["a curve", "an instance"]);
    }

    #[test]
    fn numbers_read_back_to_the_bit() {
        for value in [0.0, -0.0, 1.0, -3.0, 0.1, 1e300, -5e-324, 1e16, 123_456_789.123_456_79] {
            let mut text = Vec::new();
            number(&mut text, value).unwrap();
            let text = String::from_utf8(text).unwrap();
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{text}");
        }
    }
}
