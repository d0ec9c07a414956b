//! Parameters of an entity: numbers, texts (`5Hhello`), nothing; between delimiters, up to the end of the record.

/// A parameter as it stands there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Field {
    from: usize,
    to: usize,
    /// Whether it is a text, and `from..to` what stands behind its `H`.
    text: bool,
}

/// The parameters of one record.
#[derive(Debug, Clone, Default)]
pub(crate) struct Params {
    raw: Vec<u8>,
    fields: Vec<Field>,
}

/// What stands at the places of parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value<'p> {
    /// Nothing: the default counts.
    Omitted,
    /// A number.
    Number(f64),
    /// A text.
    Text(&'p [u8]),
    /// What is neither.
    Other(&'p [u8]),
}

/// How a record ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// With its delimiter.
    Closed,
    /// Without one, as the text is over.
    Open,
    /// In the middle of a text of so many characters.
    InText(usize),
}

impl Params {
    /// The parameters of a text, whose data columns are joined; how it ends, and where behind its delimiter.
    pub(crate) fn parse(raw: Vec<u8>, [between, last]: [u8; 2]) -> (Self, End, usize) {
        let mut fields = Vec::new();
        let (mut at, mut end) = (0, End::Open);
        while at < raw.len() {
            at += raw[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
            // Digits and an `H`: a text of so many characters, in which delimiters are none.
            let digits = raw[at..].iter().take_while(|b| b.is_ascii_digit()).count();
            let is_text = digits > 0 && matches!(raw.get(at + digits), Some(b'H' | b'h'));
            let mut stop = at;
            if is_text {
                let count =
                    std::str::from_utf8(&raw[at..at + digits]).ok().and_then(|n| n.parse::<usize>().ok());
                let from = at + digits + 1;
                let left = raw.len() - from;
                let Some(count) = count.filter(|&count| count <= left) else {
                    end = End::InText(count.unwrap_or(usize::MAX));
                    at = raw.len();
                    break;
                };
                fields.push(Field { from, to: from + count, text: true });
                stop = from + count;
            }
            // Up to the delimiter; behind a text there should be nothing else.
            let rest = &raw[stop..];
            let behind = rest.iter().position(|&b| b == between || b == last);
            let to = stop + behind.unwrap_or(rest.len());
            let is_last = raw.get(to).is_none_or(|&b| b == last);
            if !is_text {
                let blank = raw[at..to].trim_ascii().is_empty();
                // A record that just ends has no further parameter, one between two delimiters is omitted.
                if !(blank && (is_last && fields.is_empty() || to == raw.len())) {
                    fields.push(Field { from: at, to, text: false });
                }
            }
            at = to + 1;
            if is_last {
                if behind.is_some() {
                    end = End::Closed;
                }
                break;
            }
        }
        (Self { raw, fields }, end, at)
    }

    /// The text again, to which more may come.
    pub(crate) fn into_raw(self) -> Vec<u8> {
        self.raw
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.fields.len()
    }

    /// What stands at a place; nothing behind the last.
    pub(crate) fn value(&self, index: usize) -> Value<'_> {
        let Some(field) = self.fields.get(index) else { return Value::Omitted };
        let raw = &self.raw[field.from..field.to];
        if field.text {
            return Value::Text(raw);
        }
        let trimmed = raw.trim_ascii();
        if trimmed.is_empty() {
            return Value::Omitted;
        }
        number(trimmed).map_or(Value::Other(trimmed), Value::Number)
    }
}

/// A number, whose exponent may follow a `D`, as double precision does in Fortran.
fn number(raw: &[u8]) -> Option<f64> {
    const LONGEST: usize = 64;
    if !raw.iter().all(|b| b.is_ascii_digit() || b"+-.eEdD".contains(b)) {
        return None;
    }
    let plain = std::str::from_utf8(raw).ok()?;
    let parsed = if raw.len() <= LONGEST && !raw.iter().any(|b| matches!(b, b'd' | b'D')) {
        plain.parse::<f64>().ok()
    } else {
        plain.replace(['d', 'D'], "E").parse().ok()
    };
    parsed.filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> (Params, End, usize) {
        Params::parse(text.as_bytes().to_vec(), *b",;")
    }

    #[test]
    fn numbers_texts_and_nothing() {
        let (params, end, at) = parse("126, 1.5D-3,,5Ha,b;c , -2.e2,+7;rest");
        assert_eq!((params.len(), end), (6, End::Closed));
        assert_eq!(params.value(0), Value::Number(126.0));
        assert_eq!(params.value(1), Value::Number(1.5e-3));
        assert_eq!(params.value(2), Value::Omitted);
        assert_eq!(params.value(3), Value::Text(b"a,b;c"));
        assert_eq!(params.value(4), Value::Number(-200.0));
        assert_eq!(params.value(5), Value::Number(7.0));
        assert_eq!(params.value(6), Value::Omitted);
        assert_eq!(&b"126, 1.5D-3,,5Ha,b;c , -2.e2,+7;rest"[at..], b"rest");
    }

    #[test]
    fn ends_of_records() {
        for (text, count, end) in [
            ("1,2,;", 3, End::Closed),
            ("1,2,", 2, End::Open),
            ("1,2", 2, End::Open),
            (";", 0, End::Closed),
            ("", 0, End::Open),
            ("1,9Habc;", 1, End::InText(9)),
            ("1,99999999999999999999Habc;", 1, End::InText(usize::MAX)),
            (",;", 2, End::Closed),
        ] {
            let (params, found, _) = parse(text);
            assert_eq!((params.len(), found), (count, end), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in ["nan", "inf", "1e999", "1.2.3", "--1", "x", "1 2", "0x10"] {
            let (params, ..) = parse(&format!("{text};"));
            assert_eq!(params.value(0), Value::Other(text.as_bytes()), "{text}");
        }
    }
}
