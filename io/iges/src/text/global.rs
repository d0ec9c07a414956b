//! The global section: delimiters, who wrote the file, units, how exact it is.

use loftsman_kernel::scene::Unit;

use super::params::{End, Params, Value};
use super::{Fault, decode};

/// The delimiters where the file names none.
const USUAL: [u8; 2] = *b",;";

/// What a file says of its lengths.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Length {
    /// A unit.
    Known(Unit),
    /// None is said: the standard's default, inches.
    Unsaid,
    /// A flag that stands for no unit, or for a name that is not there.
    Nameless(String),
    /// A unit whose name is none that is known.
    Other(String),
}

impl Length {
    /// The unit of the file's lengths.
    pub(crate) fn unit(&self) -> Unit {
        match self {
            Self::Known(unit) => *unit,
            Self::Unsaid => Unit::Inch,
            Self::Nameless(_) | Self::Other(_) => Unit::Unknown,
        }
    }
}

/// What the global section says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Global {
    /// Between parameters, and behind the last.
    pub(crate) delimiters: [u8; 2],
    /// The system that the model was made with.
    pub(crate) system: String,
    /// The program that wrote the file.
    pub(crate) writer: String,
    /// By what model lengths are multiples of real ones, where that is not 1.
    pub(crate) scale: Option<f64>,
    pub(crate) length: Length,
    /// The smallest distance that is meant; 0 where none is said.
    pub(crate) resolution: f64,
    /// 11 is version 5.3.
    pub(crate) version: Option<f64>,
}

impl Global {
    /// The section of joined lines, of which the first has this number.
    pub(crate) fn parse(text: Vec<u8>, line: usize) -> Result<Self, Fault> {
        let (delimiters, rest) = delimiters(&text, line)?;
        let (params, end, _) = Params::parse(text[rest..].to_vec(), delimiters);
        if end != End::Closed {
            let problem = "the global section does not end: the file is cut off, or names another delimiter than it uses";
            return Err(Fault::new(line, problem));
        }
        // The first two parameters are the delimiters.
        let at = |number: usize| params.value(number - 3);
        let text = |number: usize| match at(number) {
            Value::Text(raw) => decode(raw).trim().to_owned(),
            _ => String::new(),
        };
        let number = |number: usize| match at(number) {
            Value::Number(number) => Some(number),
            _ => None,
        };
        Ok(Self {
            delimiters,
            system: text(5),
            writer: text(6),
            scale: number(13).filter(|&scale| scale > 0.0 && scale != 1.0),
            length: length(at(14), &text(15)),
            resolution: number(19).filter(|&r| r > 0.0).unwrap_or(0.0),
            version: number(23),
        })
    }
}

/// The delimiters that the section names first, and where it goes on.
fn delimiters(text: &[u8], line: usize) -> Result<([u8; 2], usize), Fault> {
    let mut found = USUAL;
    let mut at = 0;
    for k in 0..2 {
        at += text[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        if let Some([b'1', b'H' | b'h', own]) = text.get(at..at + 3) {
            let usable = !own.is_ascii_alphanumeric() && !own.is_ascii_control() && !b" +-.".contains(own);
            if !usable || (k == 1 && *own == found[0]) {
                let problem = format!(
                    "\"{}\" is named as a delimiter: it cannot be one",
                    char::from(*own).escape_debug()
                );
                return Err(Fault::new(line, problem));
            }
            found[k] = *own;
            at += 3;
        }
        at += text[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        match text.get(at) {
            Some(&b) if b == found[0] => at += 1,
            // A section may end behind its delimiters: all is as usual.
            Some(&b) if b == found[1] => {}
            _ => {
                let problem = "the global section does not begin with its delimiters (1H,,1H;,)";
                return Err(Fault::new(line, problem));
            }
        }
    }
    Ok((found, at))
}

/// The unit of a flag; where the flag says that the name counts, of a name.
fn length(flag: Value<'_>, name: &str) -> Length {
    let (flag, said) = match flag {
        Value::Omitted => (None, String::new()),
        Value::Number(number) => (Some(number), number.to_string()),
        Value::Text(raw) | Value::Other(raw) => (None, decode(raw)),
    };
    let flags = [
        (1.0, Unit::Inch),
        (2.0, Unit::Millimetre),
        (4.0, Unit::Foot),
        (5.0, Unit::Mile),
        (6.0, Unit::Metre),
        (7.0, Unit::Kilometre),
        (8.0, Unit::Mil),
        (9.0, Unit::Micrometre),
        (10.0, Unit::Centimetre),
    ];
    if let Some((_, unit)) = flags.iter().find(|(number, _)| flag == Some(*number)) {
        return Length::Known(*unit);
    }
    if flag == Some(11.0) {
        // A millionth of an inch.
        return Unit::of_metres(2.54e-8).map_or_else(|| Length::Other("UIN".to_owned()), Length::Known);
    }
    let names = [
        ("IN", Unit::Inch),
        ("INCH", Unit::Inch),
        ("MM", Unit::Millimetre),
        ("FT", Unit::Foot),
        ("MI", Unit::Mile),
        ("M", Unit::Metre),
        ("KM", Unit::Kilometre),
        ("MIL", Unit::Mil),
        ("UM", Unit::Micrometre),
        ("CM", Unit::Centimetre),
        ("DM", Unit::Decimetre),
        ("NM", Unit::Nanometre),
        ("YD", Unit::Yard),
    ];
    let upper = name.to_ascii_uppercase();
    match names.iter().find(|(known, _)| *known == upper) {
        Some((_, unit)) => Length::Known(*unit),
        // Neither a flag nor a name: the standard's default.
        None if said.is_empty() && name.is_empty() => Length::Unsaid,
        None if name.is_empty() => Length::Nameless(said),
        None if upper == "UNKNOWN" => Length::Known(Unit::Unknown),
        None => Length::Other(name.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Global, Fault> {
        Global::parse(text.as_bytes().to_vec(), 2)
    }

    #[test]
    fn delimiters_are_usual_or_named() {
        let rest = |d: char| {
            format!("4Hpart{d}1Hf{d}3Hsys{d}{d}32{d}38{d}6{d}308{d}15{d}{d}1.D0{d}6{d}1HM{d}{d}{d}{d}1.E-3")
        };
        for (head, d, r) in
            [(",,", ',', ';'), ("1H,,1H;,", ',', ';'), ("1H/,1H#,", '/', '#'), ("1H^^1H!^", '^', '!')]
        {
            let head = head.replace(',', &d.to_string());
            let head = if d == ',' { head } else { format!("1H{d}{d}1H{r}{d}") };
            let found = parse(&format!("{head}{}{r}", rest(d))).unwrap();
            assert_eq!(found.delimiters, [d as u8, r as u8]);
            assert_eq!((found.system.as_str(), &found.length), ("sys", &Length::Known(Unit::Metre)));
            assert_eq!((found.resolution, found.scale), (1e-3, None));
        }
        assert_eq!(parse(",,;").unwrap().length, Length::Unsaid);
        for bad in ["", "x", "1HA,", "1H,,1H,,", "1H,,1H;,3Hab", ",,1,2", "1H 1H;"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn units_by_flag_and_by_name() {
        let unit = |flag: &str, name: &str| length(flag.parse().map_or(Value::Omitted, Value::Number), name);
        assert_eq!(unit("2", "IN"), Length::Known(Unit::Millimetre));
        assert_eq!(unit("3", "yd"), Length::Known(Unit::Yard));
        assert_eq!(unit("3", ""), Length::Nameless("3".into()));
        assert_eq!(unit("0", ""), Length::Nameless("0".into()));
        assert_eq!(length(Value::Other(b"x"), ""), Length::Nameless("x".into()));
        assert_eq!(unit("3", "UNKNOWN"), Length::Known(Unit::Unknown));
        assert_eq!(unit("", ""), Length::Unsaid);
        assert_eq!(unit("3", "ELL"), Length::Other("ELL".into()));
        assert_eq!(unit("77", "MM"), Length::Known(Unit::Millimetre));
    }
}
