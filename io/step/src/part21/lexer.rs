//! One entity of a file, parsed: keywords and their parameters.

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value<'f> {
    /// `$`: not given.
    Omitted,
    /// `*`: follows from others.
    Derived,
    /// A whole number.
    Integer(i64),
    /// A number with a point.
    Real(f64),
    /// A string, as it stands between its quotes.
    Text(&'f [u8]),
    /// `.NAME.`, without the points.
    Enumeration(&'f [u8]),
    /// A string of bits.
    Binary,
    /// `#number`.
    Reference(u64),
    /// `( …, … )`.
    List(Vec<Self>),
    /// `NAME( … )`: a value of a named type.
    Typed(&'f [u8], Vec<Self>),
}

impl Value<'_> {
    /// What it is, for messages.
    pub(crate) fn what(&self) -> String {
        match self {
            Self::Omitted => "nothing ($)".to_owned(),
            Self::Derived => "a derived value (*)".to_owned(),
            Self::Integer(number) => format!("the number {number}"),
            Self::Real(number) => format!("the number {number}"),
            Self::Text(_) => "a text".to_owned(),
            Self::Enumeration(name) => format!(".{}.", String::from_utf8_lossy(name)),
            Self::Binary => "a string of bits".to_owned(),
            Self::Reference(number) => format!("#{number}"),
            Self::List(values) => format!("a list of {}", values.len()),
            Self::Typed(name, _) => String::from_utf8_lossy(name).into_owned(),
        }
    }
}

/// A keyword with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part<'f> {
    pub(crate) name: &'f [u8],
    pub(crate) values: Vec<Value<'f>>,
}

/// An entity: one part, or several where it is of several types at once.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entity<'f> {
    pub(crate) number: u64,
    pub(crate) parts: Vec<Part<'f>>,
}

/// What is wrong, and at which byte.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) at: usize,
    pub(crate) problem: String,
}

/// How deep lists may lie in one another: what schemas have is three or four deep.
const DEEPEST: usize = 32;

/// A place in a text.
pub(super) struct Cursor<'f> {
    pub(super) bytes: &'f [u8],
    pub(super) at: usize,
}

impl<'f> Cursor<'f> {
    pub(super) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    pub(super) fn fault<T>(&self, problem: impl Into<String>) -> Result<T, Fault> {
        Err(Fault { at: self.at, problem: problem.into() })
    }

    /// Goes on to what is neither blank nor comment.
    pub(super) fn skip(&mut self) -> Result<(), Fault> {
        loop {
            match self.peek() {
                Some(b) if b.is_ascii_whitespace() || b == 0 => self.at += 1,
                Some(b'/') if self.bytes.get(self.at + 1) == Some(&b'*') => {
                    match memchr::memmem::find(&self.bytes[self.at + 2..], b"*/") {
                        Some(end) => self.at += 2 + end + 2,
                        None => return self.fault("a comment that does not end: close it with */"),
                    }
                }
                // Print directives.
                Some(b'\\') if matches!(self.bytes.get(self.at + 1), Some(b'N' | b'F')) => self.at += 3,
                _ => return Ok(()),
            }
        }
    }

    pub(super) fn take(&mut self, wanted: u8) -> bool {
        let is = self.peek() == Some(wanted);
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, wanted: u8) -> Result<(), Fault> {
        self.skip()?;
        if self.take(wanted) {
            return Ok(());
        }
        let found = self.found();
        self.fault(format!("{found} where \"{}\" is needed", char::from(wanted)))
    }

    pub(super) fn found(&self) -> String {
        match self.peek() {
            Some(b) if b.is_ascii_graphic() => format!("\"{}\"", char::from(b)),
            Some(b) => format!("the byte {b}"),
            None => "the end".to_owned(),
        }
    }

    /// A keyword, empty where there is none.
    pub(super) fn keyword(&mut self) -> &'f [u8] {
        let bytes = self.bytes;
        let start = self.at;
        self.take(b'!');
        while self.peek().is_some_and(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-') {
            self.at += 1;
        }
        &bytes[start..self.at]
    }

    /// The whole number at this place.
    pub(super) fn digits(&mut self) -> Option<u64> {
        let start = self.at;
        while self.peek().is_some_and(|b| b.is_ascii_digit()) {
            self.at += 1;
        }
        std::str::from_utf8(&self.bytes[start..self.at]).ok()?.parse().ok()
    }

    /// Behind the `=` of an entity to its end: `NAME( … )` or `( A( … ) B( … ) )`.
    pub(super) fn parts(&mut self) -> Result<Vec<Part<'f>>, Fault> {
        self.skip()?;
        let mut parts = Vec::with_capacity(1);
        if self.take(b'(') {
            loop {
                self.skip()?;
                if self.take(b')') {
                    break;
                }
                parts.push(self.part()?);
            }
        } else {
            parts.push(self.part()?);
        }
        self.skip()?;
        if parts.is_empty() {
            return self.fault("an entity without a type");
        }
        if self.at < self.bytes.len() {
            let found = self.found();
            return self.fault(format!("{found} behind the entity, where \";\" is needed"));
        }
        Ok(parts)
    }

    fn part(&mut self) -> Result<Part<'f>, Fault> {
        let name = self.keyword();
        if name.is_empty() {
            let found = self.found();
            return self.fault(format!("{found} where the name of a type is needed"));
        }
        self.expect(b'(')?;
        Ok(Part { name, values: self.list(0)? })
    }

    /// Values up to the closing bracket; the opening one has gone by.
    fn list(&mut self, depth: usize) -> Result<Vec<Value<'f>>, Fault> {
        if depth > DEEPEST {
            return self.fault(format!("lists lie more than {DEEPEST} deep in one another"));
        }
        let mut values = Vec::new();
        self.skip()?;
        if self.take(b')') {
            return Ok(values);
        }
        loop {
            values.push(self.value(depth)?);
            self.skip()?;
            if self.take(b')') {
                return Ok(values);
            }
            if !self.take(b',') {
                let found = self.found();
                return self.fault(format!("{found} where \",\" or \")\" is needed"));
            }
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value<'f>, Fault> {
        self.skip()?;
        let bytes = self.bytes;
        let start = self.at;
        match self.peek() {
            Some(b'$') => {
                self.at += 1;
                Ok(Value::Omitted)
            }
            Some(b'*') => {
                self.at += 1;
                Ok(Value::Derived)
            }
            Some(b'#') => {
                self.at += 1;
                match self.digits() {
                    Some(number) => Ok(Value::Reference(number)),
                    None => self.fault("a \"#\" without the number of an entity"),
                }
            }
            Some(b'(') => {
                self.at += 1;
                Ok(Value::List(self.list(depth + 1)?))
            }
            Some(b'\'') => self.text(),
            Some(b'"') => match memchr::memchr(b'"', &bytes[start + 1..]) {
                Some(length) => {
                    self.at += length + 2;
                    Ok(Value::Binary)
                }
                None => self.fault("a string of bits that does not end"),
            },
            Some(b'.') if bytes.get(start + 1).is_some_and(|b| !b.is_ascii_digit()) => {
                self.at += 1;
                let name = self.keyword();
                if self.take(b'.') {
                    return Ok(Value::Enumeration(name));
                }
                self.fault("an enumeration that does not end with \".\"")
            }
            Some(b'0'..=b'9' | b'+' | b'-' | b'.') => self.number(),
            _ => {
                let name = self.keyword();
                if name.is_empty() {
                    let found = self.found();
                    return self.fault(format!("{found} where a value is needed"));
                }
                self.expect(b'(')?;
                Ok(Value::Typed(name, self.list(depth + 1)?))
            }
        }
    }

    fn text(&mut self) -> Result<Value<'f>, Fault> {
        let bytes = self.bytes;
        let start = self.at + 1;
        let mut at = start;
        loop {
            match memchr::memchr(b'\'', &bytes[at..]) {
                Some(end) if bytes.get(at + end + 1) == Some(&b'\'') => at += end + 2,
                Some(end) => {
                    self.at = at + end + 1;
                    return Ok(Value::Text(&bytes[start..at + end]));
                }
                None => return self.fault("a text that does not end: close it with '"),
            }
        }
    }

    fn number(&mut self) -> Result<Value<'f>, Fault> {
        let bytes = self.bytes;
        let start = self.at;
        while self.peek().is_some_and(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b)) {
            self.at += 1;
        }
        let text = std::str::from_utf8(&bytes[start..self.at]).unwrap_or_default();
        if let Ok(whole) = text.parse() {
            return Ok(Value::Integer(whole));
        }
        // Fortran's exponents are seen in old files.
        let number = text.parse().or_else(|_| text.replace(['d', 'D'], "E").parse::<f64>());
        match number {
            Ok(number) if number.is_finite() && !text.contains(['n', 'N']) => Ok(Value::Real(number)),
            _ => {
                self.at = start;
                let text = loftsman_kernel::text::clip(text);
                self.fault(format!("\"{text}\" is no number that can be computed with"))
            }
        }
    }
}
