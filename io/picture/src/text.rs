//! The font of all pictures, and how wide a text is in it.

use loftsman_kernel::text::measured;
use ttf_parser::Face;

/// DejaVu Sans, reduced to Latin, Greek, Cyrillic and some signs.
const FONT: &[u8] = include_bytes!("../font/DejaVuSans-subset.ttf");

/// The family of [`FONT`], and what a browser may take instead: fonts of the same widths first.
pub(crate) const FAMILY: &str = "'DejaVu Sans', Verdana, sans-serif";

/// The font of all pictures.
pub(crate) fn font() -> Option<Face<'static>> {
    // Ours is whole, as every text in every test shows.
    Face::parse(FONT, 0).ok()
}

/// The width of a text in units of the font size. Characters that the font lacks count as an em.
pub(crate) fn width(text: &str) -> f64 {
    let Some(font) = font() else { return text.chars().count() as f64 };
    let em = f64::from(font.units_per_em());
    text.chars()
        .map(|c| font.glyph_index(c).and_then(|glyph| font.glyph_hor_advance(glyph)))
        .map(|advance| advance.map_or(1.0, |units| f64::from(units) / em))
        .sum()
}

/// A text of at most `most` characters: a longer one loses its middle, which tells names apart best, and with it the numbers that would be cut.
pub(crate) fn clipped(text: &str, most: usize) -> String {
    /// Numbers longer than this are cut all the same.
    const LONGEST: usize = 8;
    let all: Vec<char> = text.chars().collect();
    let count = all.len();
    if count <= most {
        return text.to_owned();
    }
    let (head, tail) = (most * 2 / 3, most - most * 2 / 3 - 1);
    let of_number = |k: usize| all.get(k).is_some_and(|c| c.is_ascii_digit() || *c == '.');
    let within = |k: &usize| *k > 0 && of_number(*k - 1) && of_number(*k);
    let outside = |places: &mut dyn Iterator<Item = usize>, or: usize| {
        places.take(LONGEST).find(|k| !within(k)).unwrap_or(or)
    };
    let head = outside(&mut (1..=head).rev(), head);
    let tail = outside(&mut (count - tail..count), count - tail);
    all.iter().take(head).chain(&['…']).chain(all.iter().skip(tail)).collect()
}

/// A number as people write it: up to three significant digits (all of them before the point), powers of ten
/// for the very large and small.
pub(crate) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 || (1e-3..1e5).contains(&magnitude) {
        let digits = (2 - magnitude.max(1e-3).log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{value:.digits$}");
        let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        return text.replace('-', "−");
    }
    in_powers(&format!("{value:.2e}"))
}

/// The figures of a number as pictures write them, with powers of ten and a true minus: `-5.5e-6` is `−5.5·10⁻⁶`.
fn in_powers(figures: &str) -> String {
    let Some((mantissa, exponent)) = figures.split_once('e') else { return figures.replace('-', "−") };
    let mantissa =
        if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    let raised: String = exponent.chars().map(superscript).collect();
    match mantissa {
        "1" => format!("10{raised}"),
        "-1" => format!("−10{raised}"),
        _ => format!("{mantissa}·10{raised}").replace('-', "−"),
    }
}

/// A measure in about four figures, as reports have it.
pub(crate) fn figure(value: f64) -> String {
    in_powers(&loftsman_kernel::text::figure(value))
}

/// Words whose numbers have six figures at most, which is more than can be seen: `position at 0.0385882`. Whole numbers stay, and so do
/// figures that belong to a name.
pub(crate) fn rounded(words: &str) -> String {
    let mut out = String::with_capacity(words.len());
    let mut rest = words;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, from) = rest.split_at(start);
        out.push_str(before);
        let is_named = out.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '.');
        // Bytes: a number has no others, and ends before whatever it has not.
        let bytes = from.as_bytes();
        let digits = |at: usize| bytes[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = digits(0);
        let has_point = bytes.get(end) == Some(&b'.') && digits(end + 1) > 0;
        if has_point {
            end += 1 + digits(end + 1);
        }
        let figures = from[..end].bytes().filter(u8::is_ascii_digit).count();
        if bytes.get(end) == Some(&b'e') {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'-' | b'+')));
            let exponent = digits(end + 1 + sign);
            end += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let (number, after) = from.split_at(end);
        let is_followed = after.starts_with(|c: char| c.is_alphanumeric() || c == '_');
        match number.parse::<f64>() {
            Ok(value) if has_point && figures > 6 && !is_named && !is_followed => {
                out.push_str(&measured(value));
            }
            _ => out.push_str(number),
        }
        rest = after;
    }
    out + rest
}

/// A parameter, in as many figures as are needed to point at its place: one that is rounded up at the end of a domain would be outside.
pub(crate) fn parameter(value: f64) -> String {
    in_powers(&measured(value))
}

/// A tick of an axis: all of them have as many decimals as their step needs.
pub(crate) fn tick(value: f64, all: &[f64]) -> String {
    let largest = all.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let step = if let [a, b, ..] = all { b - a } else { largest };
    if !(1e-3..1e5).contains(&step) || largest >= 1e5 {
        return number(value);
    }
    let decimals = (-step.log10()).ceil().clamp(0.0, 4.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() {
        "0".to_owned()
    } else {
        text.replace('-', "−")
    }
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
        other => other,
    }
}

/// A text of a size in lines of a width, at most three; what is too long for them is in the last.
pub(crate) fn wrapped(text: &str, size: f64, width: f64) -> Vec<String> {
    wrapped_in(text, size, width, 3)
}

/// The same in as many lines as are said at most.
pub(crate) fn wrapped_in(text: &str, size: f64, width: f64, most: usize) -> Vec<String> {
    let fit =
        |line: &str, word: &str| (self::width(line) + self::width(" ") + self::width(word)) * size <= width;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let full = lines.len() == most;
        match lines.last_mut() {
            Some(line) if full || fit(line, word) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A line of text of the room that there is, shorter by whole characters where it must be.
pub(crate) fn fitting(line: &str, size: f64, room: f64) -> String {
    let fits = (room / (width(line).max(1e-9) * size) * line.chars().count() as f64) as usize;
    clipped(line, fits.max(4))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_the_fonts() {
        // DejaVu Sans: 2048 units an em; "m" is 1995 wide, "i" 569 (font's hmtx table).
        assert!((width("mi") - (1995.0 + 569.0) / 2048.0).abs() < 1e-6);
        assert_eq!(width("船"), 1.0);
    }

    #[test]
    fn numbers_read_well() {
        let texts = [0.0, 0.25, -1.5, 20.0, 12345.0, 2e-9, 1e9, -2.5e12].map(number);
        assert_eq!(texts, ["0", "0.25", "−1.5", "20", "12345", "2·10⁻⁹", "10⁹", "−2.5·10¹²"]);
        let texts = [0.0, -3.2, 5.5e-6, -8.38e-6, 1e-7, -1e-7, 12345.6].map(figure);
        assert_eq!(texts, ["0", "−3.2", "5.5·10⁻⁶", "−8.38·10⁻⁶", "10⁻⁷", "−10⁻⁷", "12346"]);
    }

    #[test]
    fn labels_have_six_figures_at_most() {
        for (words, expected) in [
            ("position at 0.03858823942820688", "position at 0.0385882"),
            ("y of position at [0.5, 123.456789]", "y of position at [0.5, 123.457]"),
            ("position at -0.39779992 by 1.00000000e-5", "position at -0.3978 by 1e-5"),
            (
                "vertex 12345678 of part_0.1234567, v1.23456789",
                "vertex 12345678 of part_0.1234567, v1.23456789",
            ),
            ("0.25", "0.25"),
            ("naïve 1.5é 0.12345678é", "naïve 1.5é 0.12345678é"),
            ("3.", "3."),
        ] {
            assert_eq!(rounded(words), expected);
        }
    }

    #[test]
    fn ticks_have_the_decimals_of_their_step() {
        let all = [-0.5, 0.0, 0.5, 1.0];
        assert_eq!(all.map(|v| tick(v, &all)), ["−0.5", "0", "0.5", "1.0"]);
        assert_eq!(tick(20.0, &[0.0, 20.0, 40.0]), "20");
        assert_eq!(tick(2e-9, &[0.0, 1e-9, 2e-9]), "2·10⁻⁹");
    }

    #[test]
    fn long_names_lose_their_middle() {
        assert_eq!(clipped("section", 7), "section");
        assert_eq!(clipped("wing-section-root-17", 10), "wing-s…-17");
        let label = "double sliding near [0.0983, 0.25117] and [0.9017, 0.25117]";
        assert_eq!(clipped(label, 48), "double sliding near [0.0983, …, 0.25117]");
        assert_eq!(clipped("123456789012345", 10), "123456…345");
    }
}
