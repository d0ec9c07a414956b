//! Strings of ISO 10303-21 (clause 6.4.3), in and out.

/// The text of a string as it stands between its quotes. Bytes that are not ASCII are UTF-8, as newer files have them, else
/// Latin-1; ends of lines are none of the text.
pub(crate) fn decode(raw: &[u8]) -> String {
    let plain = |bytes: &[u8]| match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    };
    let mut out = String::with_capacity(raw.len());
    let mut rest = raw;
    while let Some(at) = memchr::memchr2(b'\'', b'\\', rest) {
        out += &plain(&rest[..at]);
        let (letters, length) = escape(&rest[at..]);
        out += &letters;
        rest = &rest[at + length..];
    }
    out += &plain(rest);
    out.retain(|c| !c.is_control());
    out
}

/// What an escape at the start of some bytes stands for, and how long it is; what is none stands for itself.
fn escape(bytes: &[u8]) -> (String, usize) {
    let one = |letter: char, length: usize| (letter.to_string(), length);
    match bytes {
        [b'\'', b'\'', ..] => one('\'', 2),
        [b'\\', b'\\', ..] => one('\\', 2),
        [b'\\', b'S', b'\\', letter, ..] => one(char::from(letter | 0x80), 4),
        [b'\\', b'P', _, b'\\', ..] => (String::new(), 4),
        [b'\\', b'X', b'\\', high, low, ..] => match hexadecimal(&[*high, *low]) {
            Some(code) => one(char::from_u32(code).unwrap_or('\u{fffd}'), 5),
            None => one('\\', 1),
        },
        [b'\\', b'X', width @ (b'2' | b'4'), b'\\', rest @ ..] => {
            let digits = if *width == b'2' { 4 } else { 8 };
            let end = memchr::memmem::find(rest, b"\\X0\\").unwrap_or(rest.len());
            let codes: Option<Vec<u32>> = rest[..end].chunks(digits).map(hexadecimal).collect();
            match codes {
                Some(codes) => (letters(&codes), (4 + end + 4).min(bytes.len())),
                None => one('\\', 1),
            }
        }
        [first, ..] => one(char::from(*first), 1),
        [] => (String::new(), 0),
    }
}

/// The letters of UTF-16 or UTF-32 codes.
fn letters(codes: &[u32]) -> String {
    match codes.iter().map(|&code| u16::try_from(code).ok()).collect::<Option<Vec<u16>>>() {
        Some(units) => String::from_utf16_lossy(&units),
        None => codes.iter().map(|&code| char::from_u32(code).unwrap_or('\u{fffd}')).collect(),
    }
}

fn hexadecimal(digits: &[u8]) -> Option<u32> {
    u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()
}

/// A text as a string, with its quotes: ASCII, the rest escaped.
pub(crate) fn encode(text: &str) -> String {
    let mut out = String::from("'");
    for letter in text.chars() {
        match letter {
            '\'' => out += "''",
            '\\' => out += "\\\\",
            ' '..='~' => out.push(letter),
            _ if u32::from(letter) <= 0xffff => out += &format!("\\X2\\{:04X}\\X0\\", u32::from(letter)),
            _ => out += &format!("\\X4\\{:08X}\\X0\\", u32::from(letter)),
        }
    }
    out.push('\'');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_letters() {
        for (raw, text) in [
            ("it''s", "it's"),
            ("a\\\\b", "a\\b"),
            ("\\X2\\00E900DF\\X0\\t", "éßt"),
            ("\\X4\\0001F600\\X0\\", "😀"),
            ("\\X2\\D83DDE00\\X0\\", "😀"),
            ("\\X\\E9", "é"),
            ("\\S\\i", "é"),
            ("\\PA\\x", "x"),
            ("two\r\n lines", "two lines"),
            // What is no escape stays.
            ("\\X2\\00Z9\\X0\\", "\\X2\\00Z9\\X0\\"),
            ("\\", "\\"),
            ("\\X2\\0041", "A"),
        ] {
            assert_eq!(decode(raw.as_bytes()), text);
        }
        assert_eq!(decode("é".as_bytes()), "é");
        assert_eq!(decode(&[0xe9]), "é");
    }

    #[test]
    fn texts_read_back() {
        for text in ["", "plain", "it's \\ 'quoted'", "é ß 漢字 😀", "\\X2\\"] {
            let written = encode(text);
            assert!(written.is_ascii());
            assert_eq!(decode(&written.as_bytes()[1..written.len() - 1]), text);
        }
    }
}
