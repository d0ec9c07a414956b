//! Text of files older than UTF-8: what its bytes from 128 up stand for.

use std::borrow::Cow;
use std::fmt;

/// What the bytes from 128 up are in code page 437, that of DOS.
const CODE_PAGE_437: &str = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀\
    αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}";

/// What those from 128 to 159 are in Windows-1252; from 160 on it is Latin-1. Five stand for nothing.
const WINDOWS_1252: &str = "€\u{fffd}‚ƒ„…†‡ˆ‰Š‹Œ\u{fffd}Ž\u{fffd}\u{fffd}‘’“”•–—˜™š›œ\u{fffd}žŸ";

/// How a text that is not UTF-8 was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Windows-1252, which holds what Latin-1 does, with quotes and dashes.
    Windows1252,
    /// Code page 437, that of DOS.
    CodePage437,
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Windows1252 => "Windows-1252",
            Self::CodePage437 => "code page 437",
        })
    }
}

/// The characters of all bytes; U+FFFD where one stands for nothing.
type Table = [char; 256];

impl Encoding {
    fn table(self) -> Table {
        let characters = match self {
            Self::Windows1252 => WINDOWS_1252,
            Self::CodePage437 => CODE_PAGE_437,
        };
        let mut table = [' '; 256];
        // The characters of Latin-1 are the first of Unicode.
        (0..=255_u8).zip(&mut table).for_each(|(byte, c)| *c = char::from(byte));
        table[128..].iter_mut().zip(characters.chars()).for_each(|(c, known)| *c = known);
        table
    }
}

/// A text as UTF-8. Lines that are UTF-8 stay as they are; of the others each byte becomes a character of one encoding, so that no two texts
/// become one: Windows-1252 or code page 437, as the characters fit in better with those beside them (letters in words of one
/// case, quotes at their borders, degrees behind digits, frames in runs). Where either fits as well it is Windows-1252, if it is Latin-1
/// (no byte from 128 to 159). `O(n)`; a text that is UTF-8 is looked through once and not copied.
///
/// ```
/// use loftsman_kernel::text::{Encoding, decoded};
///
/// let (text, encoding) = decoded(b"\x93NACA\x94 12\xb0 M\xfcller");
/// assert_eq!((text.as_ref(), encoding), ("“NACA” 12° Müller".as_bytes(), Some(Encoding::Windows1252)));
/// let (text, encoding) = decoded(b"M\x81ller 12\xf8");
/// assert_eq!((text.as_ref(), encoding), ("Müller 12°".as_bytes(), Some(Encoding::CodePage437)));
/// assert_eq!(decoded("Müller".as_bytes()).1, None);
/// ```
pub fn decoded(bytes: &[u8]) -> (Cow<'_, [u8]>, Option<Encoding>) {
    if std::str::from_utf8(bytes).is_ok() {
        return (Cow::Borrowed(bytes), None);
    }
    let lines = || bytes.split_inclusive(|&b| b == b'\n' || b == b'\r');
    let is_old = |line: &[u8]| std::str::from_utf8(line).is_err();
    let [windows, dos] = [Encoding::Windows1252, Encoding::CodePage437].map(Encoding::table);
    let mut lead = 0_i64;
    let (mut is_dos, mut is_latin) = (false, true);
    for line in lines().filter(|line| is_old(line)) {
        is_dos |= line.iter().any(|&b| windows[usize::from(b)] == char::REPLACEMENT_CHARACTER);
        is_latin &= !line.iter().any(|b| (128..160).contains(b));
        lead += fit(line, &windows) - fit(line, &dos);
    }
    is_dos |= lead < 0 || lead == 0 && !is_latin;
    let (encoding, table) =
        if is_dos { (Encoding::CodePage437, dos) } else { (Encoding::Windows1252, windows) };
    let mut text = Vec::with_capacity(bytes.len() + bytes.len() / 16);
    for line in lines() {
        if is_old(line) {
            for &byte in line {
                text.extend_from_slice(table[usize::from(byte)].encode_utf8(&mut [0; 4]).as_bytes());
            }
        } else {
            text.extend_from_slice(line);
        }
    }
    (Cow::Owned(text), Some(encoding))
}

/// How well the characters from 128 up fit in with those beside them: one for each that does, less than none for each that does not.
fn fit(line: &[u8], table: &Table) -> i64 {
    let at = |k: Option<usize>| k.and_then(|k| line.get(k)).map_or(' ', |&b| table[usize::from(b)]);
    let old = line.iter().enumerate().filter(|(_, byte)| !byte.is_ascii());
    old.map(|(k, &byte)| {
        let before = [at(k.checked_sub(1)), at(k.checked_sub(2))];
        one(table[usize::from(byte)], before, at(k.checked_add(1)))
    })
    .sum()
}

/// The same of one character, `before` it the nearest first.
fn one(c: char, [before, farther]: [char; 2], after: char) -> i64 {
    let beside = [before, after];
    let letters = beside.iter().filter(|c| c.is_alphabetic()).count();
    let words = beside.iter().filter(|c| c.is_alphanumeric()).count();
    let blanks = beside.iter().filter(|c| c.is_whitespace()).count();
    let or = |fits: bool, otherwise: i64| if fits { 1 } else { otherwise };
    match c {
        '„' | '‚' => or(!before.is_alphanumeric() && after.is_alphanumeric(), -i64::from(words > 0)),
        '«' | '»' | '‹' | '›' => or(letters == 1, -i64::from(letters == 2)),
        '’' if letters == 2 => 1,
        '’' if after.is_alphanumeric() => -i64::from(words == 2),
        '‘' | '’' | '“' | '”' => [0, 1, -1][words],
        '–' | '—' => or(blanks == 2 || words == 2 && letters == 0, 0),
        '…' => or(!before.is_whitespace() && !after.is_alphanumeric(), 0),
        '™' => or(before.is_alphabetic() && !after.is_alphanumeric(), -i64::from(words > 0)),
        '°' | '²' | '³' | 'ⁿ' => {
            or(before.is_alphanumeric() && !after.is_lowercase(), -(letters as i64))
        }
        '±' => or(blanks > 0 || after.is_ascii_digit(), -1),
        '½' | '¼' | '¾' => or(before.is_ascii_digit(), -i64::from(letters == 2)),
        '·' | '×' | '÷' | 'ª' | 'º' => -i64::from(letters == 2),
        '€' | '£' | '¥' => or(letters == 0, -1),
        '\u{a0}' => or(letters < words, -i64::from(letters == 2 && !after.is_uppercase())),
        // Frames come in runs of the same.
        '\u{2500}'..='\u{259f}' => or(beside.contains(&c), -i64::from(words > 0)),
        // Greek letters are signs of their own.
        '\u{370}'..='\u{3ff}' => -i64::from(letters > 0),
        _ if c.is_alphabetic() => {
            let among_ascii = beside.iter().any(char::is_ascii_alphabetic);
            // A capital behind a small letter, a small letter before a capital or behind several.
            let odd = if c.is_uppercase() {
                before.is_lowercase()
            } else {
                after.is_uppercase() || before.is_uppercase() && farther.is_uppercase()
            };
            if odd {
                -2
            } else if before.is_numeric() {
                -1
            } else {
                i64::from(among_ascii)
            }
        }
        _ => -i64::from(letters == 2),
    }
}

#[cfg(test)]
mod tests {
    use super::Encoding::{CodePage437, Windows1252};
    use super::*;

    /// Names in the bytes that Python 3.11 writes of them (`str.encode`), which are no UTF-8.
    const NAMES: &[(&[u8], &str, Encoding)] = &[
        (b"\x93NACA\x94 0012 \x96 12 % \x85 \x80", "“NACA” 0012 – 12 % … €", Windows1252),
        (b"G\xf6ttingen 398", "Göttingen 398", Windows1252),
        (b"G\x94ttingen 398", "Göttingen 398", CodePage437),
        (b"G\xd6TTINGEN 398", "GÖTTINGEN 398", Windows1252),
        (b"G\x99TTINGEN 398", "GÖTTINGEN 398", CodePage437),
        (b"Profil \xe0 12 %", "Profil à 12 %", Windows1252),
        (b"Profil \x85 12 %", "Profil à 12 %", CodePage437),
        (b"Profil \xe0 camber \xe9lev\xe9", "Profil à camber élevé", Windows1252),
        (b"Profil \x85 camber \x82lev\x82", "Profil à camber élevé", CodePage437),
        (b"12\xb0", "12°", Windows1252),
        (b"12\xf8", "12°", CodePage437),
        (b"twist 3\xb0", "twist 3°", Windows1252),
        (b"twist 3\xf8", "twist 3°", CodePage437),
        (b"H\xf6he 12 \xb0C", "Höhe 12 °C", Windows1252),
        (b"H\x94he 12 \xf8C", "Höhe 12 °C", CodePage437),
        (b"M\xdcLLER H\xf6he", "MÜLLER Höhe", Windows1252),
        (b"M\x9aLLER H\x94he", "MÜLLER Höhe", CodePage437),
        (b"M\xfcller", "Müller", Windows1252),
        (b"M\x81ller", "Müller", CodePage437),
        (b"M\xe4ll", "Mäll", Windows1252),
        (b"M\x84ll", "Mäll", CodePage437),
        (b"f\xe4", "fä", Windows1252),
        (b"f\x84", "fä", CodePage437),
        (b"f\xfc", "fü", Windows1252),
        (b"f\x81", "fü", CodePage437),
        (b"\xc9T\xc9", "ÉTÉ", Windows1252),
        (b"\x90T\x90", "ÉTÉ", CodePage437),
        (b"\xe9t\xe9", "été", Windows1252),
        (b"\x82t\x82", "été", CodePage437),
        (b"\xe9", "é", Windows1252),
        (b"\x82", "é", CodePage437),
        (b"\xc4", "Ä", Windows1252),
        (b"\x8e", "Ä", CodePage437),
        (b"\xc4\xd6\xdc", "ÄÖÜ", Windows1252),
        (b"\x8e\x99\x9a", "ÄÖÜ", CodePage437),
        (b"Gr\xf6\xdfe", "Größe", Windows1252),
        (b"Gr\x94\xe1e", "Größe", CodePage437),
        (b"d\x92Arc", "d’Arc", Windows1252),
        (b"\x84G\xf6ttinger\x93 Profil", "„Göttinger“ Profil", Windows1252),
        (b"\xabEiffel\xbb 385", "«Eiffel» 385", Windows1252),
        (b"\xaeEiffel\xaf 385", "«Eiffel» 385", CodePage437),
        (b"Espa\xf1ola", "Española", Windows1252),
        (b"Espa\xa4ola", "Española", CodePage437),
        (b"P\xe1gina", "Página", Windows1252),
        (b"P\xa0gina", "Página", CodePage437),
        (b"a\xf1o 1932", "año 1932", Windows1252),
        (b"a\xa4o 1932", "año 1932", CodePage437),
        (b"perfil se\xf1alado", "perfil señalado", Windows1252),
        (b"perfil se\xa4alado", "perfil señalado", CodePage437),
        (b"Coraz\xf3n", "Corazón", Windows1252),
        (b"Coraz\xa2n", "Corazón", CodePage437),
        (b"\xbfQu\xe9?", "¿Qué?", Windows1252),
        (b"\xa8Qu\x82?", "¿Qué?", CodePage437),
        (b"\xd8rsted", "Ørsted", Windows1252),
        (b"\xc5lborg", "Ålborg", Windows1252),
        (b"\x8flborg", "Ålborg", CodePage437),
        (b"T\xe5ge", "Tåge", Windows1252),
        (b"T\x86ge", "Tåge", CodePage437),
        (b"Sj\xf8fart", "Sjøfart", Windows1252),
        (b"\xc6ble", "Æble", Windows1252),
        (b"\x92ble", "Æble", CodePage437),
        (b"\xdcbergang", "Übergang", Windows1252),
        (b"\x9abergang", "Übergang", CodePage437),
        (b"\xb10.5 mm", "±0.5 mm", Windows1252),
        (b"\xf10.5 mm", "±0.5 mm", CodePage437),
        (b"NACA 4\xbd", "NACA 4½", Windows1252),
        (b"NACA 4\xab", "NACA 4½", CodePage437),
        (b"m\xb3", "m³", Windows1252),
        (b"\xc9\xcd\xcd\xbb FOIL \xba", "╔══╗ FOIL ║", CodePage437),
        (b"\xda\xc4\xc4\xc4\xc4\xbf", "┌────┐", CodePage437),
        (b"G\x99TTINGEN \xab \xea 398 \xb0\xb1\xb2 \x84", "GÖTTINGEN ½ Ω 398 ░▒▓ ä", CodePage437),
        (b"\xe0 = 3\xf8", "α = 3°", CodePage437),
        (b"\xc9clair", "Éclair", Windows1252),
        (b"\x90clair", "Éclair", CodePage437),
        (b"for\xeat", "forêt", Windows1252),
        (b"for\x88t", "forêt", CodePage437),
        (b"\xcele", "Île", Windows1252),
        (b"Cura\xe7ao", "Curaçao", Windows1252),
        (b"Cura\x87ao", "Curaçao", CodePage437),
        (b"na\xefve", "naïve", Windows1252),
        (b"na\x8bve", "naïve", CodePage437),
        (b"M\xfcller & S\xf6hne", "Müller & Söhne", Windows1252),
        (b"M\x81ller & S\x94hne", "Müller & Söhne", CodePage437),
        (b"FX 60-126 \x96 ge\xe4ndert", "FX 60-126 – geändert", Windows1252),
        (b"it\x92s", "it’s", Windows1252),
        (b"\x91quote\x92", "‘quote’", Windows1252),
        (b"b\x9cuf", "bœuf", Windows1252),
        (b"fa\xe7ade \x91A\x92", "façade ‘A’", Windows1252),
        (b"B\xe9zier", "Bézier", Windows1252),
        (b"B\x82zier", "Bézier", CodePage437),
        (b"Poincar\xe9", "Poincaré", Windows1252),
        (b"Poincar\x82", "Poincaré", CodePage437),
        (b"\xc5ngstr\xf6m", "Ångström", Windows1252),
        (b"\x8fngstr\x94m", "Ångström", CodePage437),
    ];

    #[test]
    fn names_of_every_age_are_read_as_they_were_meant() {
        for &(bytes, name, encoding) in NAMES {
            let (text, found) = decoded(bytes);
            assert_eq!((std::str::from_utf8(&text).unwrap(), found), (name, Some(encoding)), "{bytes:?}");
            // What is UTF-8 beside it stays.
            let both = [name.as_bytes(), b"\r\n", bytes, b"\n"].concat();
            let text = decoded(&both).0.into_owned();
            assert_eq!(String::from_utf8(text).unwrap(), format!("{name}\r\n{name}\n"));
        }
        assert!(NAMES.len() > 80);
    }

    #[test]
    fn every_byte_is_a_character_of_its_own() {
        let all: Vec<u8> = (128..=255).collect();
        let dos = "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}";
        let of = |encoding: Encoding| -> String { encoding.table()[128..].iter().collect() };
        assert_eq!(of(CodePage437), dos);
        assert_eq!(String::from_utf8(decoded(&all).0.into_owned()).unwrap(), dos);
        let windows = "€‚ƒ„…†‡ˆ‰Š‹ŒŽ‘’“”•–—˜™š›œžŸ\u{a0}¡¢£¤¥¦§¨©ª«¬\u{ad}®¯°±²³´µ¶·¸¹º»¼½¾¿ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÐÑÒÓÔÕÖ×ØÙÚÛÜÝÞßàáâãäåæçèéêëìíîïðñòóôõö÷øùúûüýþÿ";
        assert_eq!(of(Windows1252).replace(char::REPLACEMENT_CHARACTER, ""), windows);
        for encoding in [Windows1252, CodePage437] {
            assert_eq!(encoding.table()[..128], (0..128_u8).map(char::from).collect::<Vec<_>>()[..]);
        }
    }

    #[test]
    fn what_is_utf_8_is_not_touched() {
        for text in ["", "plain", "Müller 12° “x”\r\n\u{0}"] {
            let (same, encoding) = decoded(text.as_bytes());
            assert!(matches!(same, Cow::Borrowed(_)) && encoding.is_none());
            assert_eq!(same, text.as_bytes());
        }
        assert!(decoded(b"\xff").1.is_some());
    }
}
