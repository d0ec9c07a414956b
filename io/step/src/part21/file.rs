//! A whole file: where its entities are. What is in them is parsed when it is asked for.

use std::cell::Cell;

use super::lexer::{Cursor, Entity, Fault, Part, Value};
use super::text::decode;

/// All bytes together may be parsed so many times, and some more in small files: entities that name one another again and again would
/// take forever otherwise.
const TIMES: u64 = 50;
const MORE: u64 = 10_000_000;

/// What whole files end with.
const END: &[u8] = b"END-ISO-10303-21";

/// Where an entity is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record {
    number: u64,
    /// Its first byte behind `=`, and the one behind its last.
    start: usize,
    end: usize,
}

/// What a file says of itself.
#[derive(Debug, Clone, Default)]
pub(crate) struct Header {
    /// Its schemas.
    pub(crate) schemas: Vec<String>,
    /// The system that its content comes from.
    pub(crate) system: String,
    /// What wrote it.
    pub(crate) writer: String,
}

/// An entity whose number an earlier one has.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Doubled {
    pub(crate) number: u64,
    start: usize,
    first: usize,
}

/// A file: its bytes, and where its entities are, by their numbers.
pub(crate) struct File<'f> {
    bytes: &'f [u8],
    records: Vec<Record>,
    /// For small numbers the place of the record and one; empty where numbers are too far apart for that.
    table: Vec<u32>,
    /// How many bytes may still be parsed.
    left: Cell<u64>,
    pub(crate) header: Header,
    /// The entities whose number was taken: that, and where they and the one that has it are.
    pub(crate) doubled: Vec<Doubled>,
}

impl<'f> File<'f> {
    /// Finds the entities of a file, in one pass.
    pub(crate) fn scan(bytes: &'f [u8]) -> Result<Self, Fault> {
        let bytes = loftsman_kernel::text::unmarked(bytes);
        let mut scan =
            Scan { cursor: Cursor { bytes, at: 0 }, records: Vec::new(), header: Header::default() };
        scan.file()?;
        let Scan { mut records, header, .. } = scan;
        if !records.is_sorted_by(|a, b| a.number < b.number) {
            records.sort_by_key(|record| record.number);
        }
        let count = records.len();
        let mut doubled = Vec::new();
        records.dedup_by(|record, first| {
            let same = record.number == first.number;
            if same {
                doubled.push(Doubled { number: record.number, start: record.start, first: first.start });
            }
            same
        });
        let largest = records.last().map_or(0, |record| record.number);
        let mut table = Vec::new();
        if largest <= 8 * count as u64 + 1024 && u32::try_from(count).is_ok() {
            table = vec![0; largest as usize + 1];
            for (place, record) in records.iter().enumerate() {
                table[record.number as usize] = place as u32 + 1;
            }
        }
        let left = Cell::new(TIMES * bytes.len() as u64 + MORE);
        Ok(Self { bytes, doubled, records, table, left, header })
    }

    /// How many entities there are.
    pub(crate) fn len(&self) -> usize {
        self.records.len()
    }

    /// The place of an entity among those of the file, by number ascending.
    pub(crate) fn place(&self, number: u64) -> Option<usize> {
        if self.table.is_empty() {
            return self.records.binary_search_by_key(&number, |record| record.number).ok();
        }
        (*self.table.get(usize::try_from(number).ok()?)? as usize).checked_sub(1)
    }

    /// The number of the entity at a place.
    pub(crate) fn number(&self, place: usize) -> u64 {
        self.records[place].number
    }

    fn text(&self, place: usize) -> &'f [u8] {
        let bytes = self.bytes;
        &bytes[self.records[place].start..self.records[place].end]
    }

    /// The type of the entity at a place; of one of several types at once all of them, sorted as they stand.
    pub(crate) fn kind(&self, place: usize) -> Kind<'f> {
        let mut cursor = Cursor { bytes: self.text(place), at: 0 };
        // A comment that does not end was found before.
        let _ = cursor.skip();
        let name = cursor.keyword();
        if name.is_empty() && cursor.peek() == Some(b'(') { Kind::Several } else { Kind::One(name) }
    }

    /// The entity at a place, parsed.
    pub(crate) fn parse(&self, place: usize) -> Result<Entity<'f>, Fault> {
        let record = &self.records[place];
        // Even the shortest costs something.
        let cost = 16 + (record.end - record.start) as u64;
        let Some(left) = self.left.get().checked_sub(cost) else {
            let problem =
                format!("entities name one another so often that all would be read more than {TIMES} times");
            return Err(Fault { at: record.start, problem });
        };
        self.left.set(left);
        let mut cursor = Cursor { bytes: self.text(place), at: 0 };
        let parts = cursor.parts().map_err(|fault| Fault { at: fault.at + record.start, ..fault })?;
        Ok(Entity { number: record.number, parts })
    }

    /// The numbers that the entity at a place names.
    pub(crate) fn references(&self, place: usize, mut each: impl FnMut(u64)) {
        let mut cursor = Cursor { bytes: self.text(place), at: 0 };
        let mut quoted = false;
        while let Some(step) = memchr::memchr2(b'#', b'\'', &cursor.bytes[cursor.at..]) {
            cursor.at += step + 1;
            if cursor.bytes[cursor.at - 1] == b'\'' {
                quoted = !quoted;
            } else if !quoted && let Some(number) = cursor.digits() {
                each(number);
            }
        }
    }

    /// The type of an entity whose number is taken, its line, and that of the one that has it.
    pub(crate) fn doubled_lines(&self, doubled: &Doubled) -> (&'f [u8], usize, usize) {
        let bytes = self.bytes;
        let mut cursor = Cursor { bytes: &bytes[doubled.start..], at: 0 };
        let _ = cursor.skip();
        (cursor.keyword(), self.line(doubled.start), self.line(doubled.first))
    }

    /// The line of an entity.
    pub(crate) fn line_of(&self, place: usize) -> usize {
        self.line(self.records[place].start)
    }

    /// How many lines there are.
    pub(crate) fn lines(&self) -> usize {
        self.line(self.bytes.trim_ascii_end().len())
    }

    /// The line of a byte, counted from 1: by `\n`, or by `\r` where there are none.
    pub(crate) fn line(&self, at: usize) -> usize {
        line(self.bytes, at)
    }
}

/// The line of a byte, counted from 1.
pub(crate) fn line(bytes: &[u8], at: usize) -> usize {
    let before = &bytes[..at.min(bytes.len())];
    let count = |byte: u8| memchr::memchr_iter(byte, before).count();
    let ends = count(b'\n');
    1 + if ends == 0 { count(b'\r') } else { ends }
}

/// Of which types an entity is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind<'f> {
    /// Of this one.
    One(&'f [u8]),
    /// Of several at once.
    Several,
}

struct Scan<'f> {
    cursor: Cursor<'f>,
    records: Vec<Record>,
    header: Header,
}

impl Scan<'_> {
    fn file(&mut self) -> Result<(), Fault> {
        let c = &mut self.cursor;
        c.skip()?;
        if c.keyword() != b"ISO-10303-21" {
            c.at = 0;
            return c.fault("it does not begin with ISO-10303-21: this is no STEP file of clear text");
        }
        self.end_of_statement()?;
        loop {
            self.cursor.skip()?;
            let start = self.cursor.at;
            let section = self.cursor.keyword();
            match section {
                b"HEADER" => {
                    self.end_of_statement()?;
                    self.header_section()?;
                }
                b"DATA" => {
                    self.past_semicolon(&"DATA")?;
                    self.data_section()?;
                }
                b"END-ISO-10303-21" => return Ok(()),
                b"" => {
                    let found = self.cursor.found();
                    if self.cursor.peek().is_none() {
                        return self.cut("the file ends before END-ISO-10303-21");
                    }
                    return self.cursor.fault(format!("{found} where a section is needed"));
                }
                // ANCHOR, REFERENCE, SIGNATURE: nothing of geometry.
                _ => {
                    let name = String::from_utf8_lossy(section).into_owned();
                    loop {
                        let statement = self.past_semicolon(&name)?;
                        if self.cursor.bytes[statement.0..statement.1].trim_ascii_end().ends_with(b"ENDSEC") {
                            break;
                        }
                        if self.cursor.at <= start {
                            return self.cursor.fault("a section that does not end");
                        }
                    }
                }
            }
        }
    }

    /// That the file was cut off, and up to where it is whole.
    fn cut<T>(&self, how: &str) -> Result<T, Fault> {
        let behind = self.records.last().map(|last| {
            let line = line(self.cursor.bytes, last.end);
            format!("; the last whole entity is #{}, line {line}", last.number)
        });
        self.cursor.fault(format!("{how}: it was cut off, get it again{}", behind.unwrap_or_default()))
    }

    fn end_of_statement(&mut self) -> Result<(), Fault> {
        self.cursor.skip()?;
        if self.cursor.take(b';') {
            return Ok(());
        }
        let found = self.cursor.found();
        self.cursor.fault(format!("{found} where \";\" is needed"))
    }

    /// Goes behind the next `;` that is in no text and no comment; from where to where the statement was.
    fn past_semicolon(&mut self, what: &dyn std::fmt::Display) -> Result<(usize, usize), Fault> {
        let start = self.cursor.at;
        let bytes = self.cursor.bytes;
        let mut at = start;
        loop {
            let Some(step) = memchr::memchr3(b';', b'\'', b'/', &bytes[at..]) else {
                self.cursor.at = start;
                return self.cut(&format!("the file ends within {what}"));
            };
            at += step + 1;
            match bytes[at - 1] {
                b';' => {
                    self.cursor.at = at;
                    return Ok((start, at - 1));
                }
                b'\'' => match memchr::memchr(b'\'', &bytes[at..]) {
                    Some(end) => at += end + 1,
                    None => {
                        self.cursor.at = at - 1;
                        if memchr::memmem::find(&bytes[at..], END).is_none() {
                            return self.cut(&format!("the file ends within a text in {what}"));
                        }
                        return self.cursor.fault(format!("a text in {what} does not end: close it with '"));
                    }
                },
                _ if bytes.get(at) == Some(&b'*') => match memchr::memmem::find(&bytes[at..], b"*/") {
                    Some(end) => at += end + 2,
                    None => {
                        self.cursor.at = at - 1;
                        return self.cursor.fault("a comment that does not end: close it with */");
                    }
                },
                _ => {}
            }
        }
    }

    fn header_section(&mut self) -> Result<(), Fault> {
        loop {
            self.cursor.skip()?;
            let before = self.cursor.at;
            if self.cursor.keyword() == b"ENDSEC" {
                return self.end_of_statement();
            }
            self.cursor.at = before;
            let (start, end) = self.past_semicolon(&"the header")?;
            let mut cursor = Cursor { bytes: &self.cursor.bytes[start..end], at: 0 };
            // What it says is told, and nothing depends on it: what is malformed in it is not told.
            let Ok(parts) = cursor.parts() else { continue };
            for part in &parts {
                self.header_statement(part);
            }
        }
    }

    fn header_statement(&mut self, part: &Part<'_>) {
        let text = |value: Option<&Value<'_>>| match value {
            Some(Value::Text(raw)) => decode(raw).trim().to_owned(),
            _ => String::new(),
        };
        match part.name {
            b"FILE_SCHEMA" => {
                if let Some(Value::List(schemas)) = part.values.first() {
                    self.header.schemas = schemas.iter().map(|schema| text(Some(schema))).collect();
                }
            }
            b"FILE_NAME" => {
                self.header.writer = text(part.values.get(4));
                self.header.system = text(part.values.get(5));
            }
            _ => {}
        }
    }

    fn data_section(&mut self) -> Result<(), Fault> {
        loop {
            self.cursor.skip()?;
            if !self.cursor.take(b'#') {
                if self.cursor.keyword() == b"ENDSEC" {
                    return self.end_of_statement();
                }
                let found = self.cursor.found();
                return if self.cursor.peek().is_none() {
                    self.cut("the file ends within its data")
                } else {
                    self.cursor.fault(format!("{found} where an entity (#number = …) or ENDSEC is needed"))
                };
            }
            let number = self.cursor.digits();
            self.cursor.skip()?;
            if self.cursor.peek().is_none() {
                return self.cut("the file ends within the number of an entity");
            }
            let Some(number) = number else {
                return self.cursor.fault("a \"#\" without the number of an entity");
            };
            if !self.cursor.take(b'=') {
                let found = self.cursor.found();
                return self.cursor.fault(format!("{found} behind #{number}, where \"=\" is needed"));
            }
            let (start, end) = self.past_semicolon(&format_args!("#{number}"))?;
            self.records.push(Record { number, start, end });
        }
    }
}
