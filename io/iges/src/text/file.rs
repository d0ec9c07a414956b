//! A file: one pass for where its lines are and what its directory says; parameters are parsed where they are asked for.

use std::cell::{Cell, OnceCell};
use std::collections::HashMap;

use super::lines::{Line, Section, line_at, lines, section};
use super::params::{End, Params, Value};
use super::{Fault, Global};
use loftsman_kernel::text::counted;

/// Where parameters end on a line: behind it stands the number of the entity.
const DATA: usize = 64;
/// As many bytes of one entity are read: a record that never ends would be the rest of the file, for each entity anew.
const LARGEST: usize = 1 << 28;
/// As often the bytes of a file may be parsed on the whole: what is shared is parsed by all that share it.
const AGAIN: u64 = 64;

/// An entity as the directory has it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Entry {
    /// Its type: 126 is a B-spline curve.
    pub(crate) kind: u32,
    pub(crate) form: i32,
    /// The layer; negative where a property lists several.
    pub(crate) level: i32,
    /// The matrix that places it; 0 where none does.
    pub(crate) matrix: i32,
    /// One of eight colours, or minus the number of a colour entity.
    pub(crate) color: i32,
    /// Whether it is hidden.
    pub(crate) blank: bool,
    /// What it is for: 0 geometry, 1 annotation, 2 definition, 5 a curve in parameters, …
    pub(crate) purpose: u8,
    pub(crate) label: String,
    pub(crate) subscript: u32,
    /// Its line in the file.
    pub(crate) line: usize,
    /// The first line of its parameters, counted in their section from 1.
    parameters: u32,
}

/// Numbers of entities as they are written: the place of each, and that of each place.
#[derive(Debug)]
struct Numbers {
    places: HashMap<u32, usize>,
    all: Vec<u32>,
}

/// A file that was looked through.
#[derive(Debug)]
pub(crate) struct File<'f> {
    bytes: &'f [u8],
    pub(crate) global: Global,
    entries: Vec<Entry>,
    /// Where the lines of parameters start.
    parameters: Vec<usize>,
    /// The numbers, where these are not 1, 3, 5, …
    numbers: Option<Numbers>,
    /// The first line of parameters of each entity, as these lines say: for directories that point elsewhere.
    owners: OnceCell<HashMap<u32, usize>>,
    /// How many bytes of parameters may still be parsed: those of a directory all of which points to the same place would be
    /// without end.
    left: Cell<u64>,
    /// What is to be said of the file as a whole.
    pub(crate) notes: Vec<String>,
}

impl<'f> File<'f> {
    /// Looks through a file. `O(bytes)`.
    pub(crate) fn scan(bytes: &'f [u8]) -> Result<Self, Fault> {
        let bytes_of = loftsman_kernel::text::unmarked(bytes);
        let shift = bytes.len() - bytes_of.len();
        let mut global: Vec<u8> = Vec::new();
        let (mut global_line, mut last_line) = (0, 0);
        let mut directory: Vec<(Line<'_>, Option<u32>)> = Vec::new();
        let mut entries = Vec::new();
        let mut numbers = Vec::new();
        let mut parameters = Vec::new();
        let (mut terminated, mut any, mut unplaced) = (false, false, 0_usize);
        for line in lines(bytes_of) {
            last_line = line.number;
            if !any
                && line.text.get(72).is_some_and(|b| matches!(b, b'C' | b'B'))
                && section(&line.text).is_none()
            {
                let form = if line.text[72] == b'C' { "compressed" } else { "binary" };
                let problem = format!(
                    "an IGES file in the {form} form, which is not read: export it in the usual form, ASCII of 80 columns"
                );
                return Err(Fault::new(line.number, problem));
            }
            let Some((section, letter, number)) = section(&line.text) else {
                if !any {
                    let problem = "no IGES file: its first line has no section letter S in column 73";
                    return Err(Fault::new(line.number, problem));
                }
                unplaced += 1;
                continue;
            };
            any = true;
            match section {
                Section::Start => {}
                Section::Global => {
                    if global_line == 0 {
                        global_line = line.number;
                    }
                    global.extend_from_slice(&line.text[..letter.min(72)]);
                    // What is short is padded: a text may go on behind its blanks.
                    if letter < 72 && line.text.len() < 80 {
                        global.resize(global.len() + 72 - letter, b' ');
                    }
                }
                Section::Directory => {
                    directory.push((line, number));
                    if directory.len() == 2 {
                        let [(first, one), (second, _)] = [&directory[0], &directory[1]];
                        entries.push(Entry::parse(first, second)?);
                        numbers.push(*one);
                        directory.clear();
                    }
                }
                Section::Parameters => parameters.push(line.at + shift),
                Section::Terminate => {
                    terminated = true;
                    break;
                }
            }
        }
        if !any {
            return Err(Fault::new(0, "no IGES file: it is empty"));
        }
        if global_line == 0 {
            return Err(Fault::new(
                last_line,
                "there is no global section: the file is cut off, or no IGES file",
            ));
        }
        let global = Global::parse(global, global_line)?;
        let mut notes = Vec::new();
        if let [(line, _)] = &directory[..] {
            let text = "an entity of the directory without its second line";
            if !terminated {
                return Err(Fault::new(line.number, format!("{text}: the file was cut off, get it again")));
            }
            notes.push(format!("line {}: {text}", line.number));
        }
        if !terminated {
            notes.push("the file has no terminate section: it may be cut off".to_owned());
        }
        if unplaced > 0 {
            notes.push(counted(unplaced, "line[|s] without the letter of a section [is|are] left out"));
        }
        let numbers = Self::numbering(&numbers, &mut notes);
        let left = Cell::new(AGAIN * bytes.len() as u64 + (1 << 20));
        let file = Self { bytes, global, entries, parameters, numbers, owners: OnceCell::new(), left, notes };
        // Without its end a file is whole only where all of its directory is there.
        let missing = || (0..file.len()).find(|&place| file.params(place).is_err());
        if !terminated && let Some(place) = missing() {
            let (number, kind) = (file.number(place), file.entry(place).kind);
            let problem = format!(
                "the file ends before the parameters of D{number} ({kind}) do: it was cut off, get it again"
            );
            return Err(Fault::new(last_line, problem));
        }
        file.left.set(AGAIN * bytes.len() as u64 + (1 << 20));
        Ok(file)
    }

    /// Numbers as they are written, where these ascend and are not simply 1, 3, 5; wrong ones count for nothing.
    fn numbering(written: &[Option<u32>], notes: &mut Vec<String>) -> Option<Numbers> {
        let usual = |(k, number): (usize, &Option<u32>)| number.is_none_or(|n| n as usize == 2 * k + 1);
        if written.iter().enumerate().all(usual) {
            return None;
        }
        let all: Option<Vec<u32>> = written.iter().copied().collect();
        match all {
            Some(all) if all.windows(2).all(|pair| pair[0] < pair[1]) => {
                let places = all.iter().enumerate().map(|(place, &number)| (number, place)).collect();
                Some(Numbers { places, all })
            }
            _ => {
                notes.push(
                    "numbers of lines of the directory are wrong: entities are counted instead".to_owned(),
                );
                None
            }
        }
    }

    /// How many entities there are.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// An entity by its place.
    pub(crate) fn entry(&self, place: usize) -> &Entry {
        &self.entries[place]
    }

    /// All entities.
    pub(crate) fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The place of an entity of a number, by which others name it.
    pub(crate) fn place(&self, number: i64) -> Option<usize> {
        let number = u32::try_from(number).ok()?;
        match &self.numbers {
            Some(numbers) => numbers.places.get(&number).copied(),
            None => {
                // Names of the second line of an entity are of old writers.
                let place = (number.checked_sub(1)? / 2) as usize;
                (place < self.entries.len()).then_some(place)
            }
        }
    }

    /// The number of a place.
    pub(crate) fn number(&self, place: usize) -> u32 {
        let written = self.numbers.as_ref().and_then(|numbers| numbers.all.get(place));
        written.copied().unwrap_or(2 * place as u32 + 1)
    }

    /// The parameters of an entity, the first of which is its type.
    pub(crate) fn params(&self, place: usize) -> Result<Params, String> {
        let entry = &self.entries[place];
        let start = (entry.parameters as usize).wrapping_sub(1);
        let params = self.record(start);
        let fits = |params: &Params| params.value(0) == Value::Number(f64::from(entry.kind));
        match params {
            Ok(params) if fits(&params) => return Ok(params),
            Err(why) if start < self.parameters.len() => return Err(why),
            _ => {}
        }
        // The directory points elsewhere: lines of parameters say whose they are.
        let number = self.number(place);
        let owners = self.owners.get_or_init(|| {
            let mut first = HashMap::new();
            for (place, &at) in self.parameters.iter().enumerate() {
                if let Some(owner) = self.owner(at) {
                    first.entry(owner).or_insert(place);
                }
            }
            first
        });
        match owners.get(&number).map(|&own| self.record(own)) {
            Some(Ok(params)) if fits(&params) => Ok(params),
            _ => Err("its parameters are not where the directory says that they are".to_owned()),
        }
    }

    /// The entity that a line of parameters belongs to.
    fn owner(&self, at: usize) -> Option<u32> {
        let line = line_at(self.bytes, at);
        let (_, letter, _) = section(&line)?;
        std::str::from_utf8(line.get(DATA..letter)?.trim_ascii()).ok()?.parse().ok()
    }

    /// The record that starts on a line of parameters.
    fn record(&self, start: usize) -> Result<Params, String> {
        let last = self.global.delimiters[1];
        let mut raw = Vec::new();
        let (mut next, mut least) = (start, 0);
        loop {
            // Lines up to one with the delimiter; that may stand in a text: then twice as many.
            while let Some(&at) = self.parameters.get(next) {
                let line = line_at(self.bytes, at);
                let letter = section(&line).map_or(line.len(), |(_, letter, _)| letter);
                let data = columns(&line, letter);
                raw.extend_from_slice(data);
                // A text goes on behind the blanks of a line that is short.
                if letter >= 72 {
                    let missing = DATA.saturating_sub(data.len());
                    raw.resize(raw.len() + missing, b' ');
                }
                next += 1;
                if (data.contains(&last) && raw.len() >= least) || raw.len() > LARGEST {
                    break;
                }
            }
            let whole = next >= self.parameters.len() || raw.len() > LARGEST;
            least = 2 * raw.len();
            let Some(left) = self.left.get().checked_sub(raw.len() as u64) else {
                return Err(
                    "too much of the file is named again and again: its directory points to the wrong lines"
                        .to_owned(),
                );
            };
            self.left.set(left);
            let (params, end, _) = Params::parse(std::mem::take(&mut raw), self.global.delimiters);
            match end {
                End::Closed => return Ok(params),
                _ if !whole => raw = params.into_raw(),
                End::Open => {
                    return Err("its parameters do not end: the file is cut off, or a delimiter is missing"
                        .to_owned());
                }
                End::InText(count) => {
                    return Err(format!(
                        "a text of {count} characters in it is longer than the rest of the file"
                    ));
                }
            }
        }
    }
}

/// The columns of a line of parameters that are data.
fn columns(line: &[u8], letter: usize) -> &[u8] {
    if letter >= 72 {
        return &line[..DATA.min(line.len())];
    }
    // The number of the entity stands before the letter, wherever that is.
    let data = line[..letter].trim_ascii_end();
    let digits = data.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    &data[..data.len() - digits]
}

impl Entry {
    /// The two lines of an entity, each of nine fields of eight columns.
    fn parse(first: &Line<'_>, second: &Line<'_>) -> Result<Self, Fault> {
        let number = |line: &Line<'_>, field: usize, name: &str| -> Result<i32, Fault> {
            let raw = field_of(line, field);
            if raw.is_empty() {
                return Ok(0);
            }
            let text = std::str::from_utf8(raw).unwrap_or_default();
            let plain = text.trim_end_matches(".0").trim_end_matches('.').trim_start_matches('+');
            plain.parse().map_err(|_| {
                let found = loftsman_kernel::text::clip(&String::from_utf8_lossy(raw));
                Fault::new(line.number, format!("\"{found}\" where the directory has {name}, a whole number"))
            })
        };
        let status = field_of(first, 9);
        // Two digits each; blanks are zeros, leading ones may be left out.
        let status: Vec<u8> = std::iter::repeat_n(b'0', 8 - status.len().min(8))
            .chain(status.iter().map(|&b| if b == b' ' { b'0' } else { b }))
            .collect();
        let pair = |k: usize| match status.get(2 * k..2 * k + 2) {
            Some([a @ b'0'..=b'9', b @ b'0'..=b'9']) => 10 * (a - b'0') + (b - b'0'),
            _ => 0,
        };
        let kind = number(first, 1, "a type")?;
        let again = number(second, 1, "a type")?;
        let Ok(of_kind) = u32::try_from(kind) else {
            return Err(Fault::new(first.number, format!("{kind} is no type of an entity")));
        };
        if kind != again {
            let problem = format!(
                "an entity of type {kind} goes on as type {again}: a line of the directory is missing"
            );
            return Err(Fault::new(second.number, problem));
        }
        let parameters = number(first, 2, "the line of the parameters")?;
        Ok(Self {
            kind: of_kind,
            form: number(second, 5, "a form")?,
            level: number(first, 5, "a level")?,
            matrix: number(first, 7, "a matrix")?,
            color: number(second, 3, "a colour")?,
            blank: pair(0) == 1,
            purpose: pair(2),
            label: super::decode(field_of(second, 8)).trim().to_owned(),
            subscript: u32::try_from(number(second, 9, "a subscript").unwrap_or(0)).unwrap_or(0),
            line: first.number,
            parameters: u32::try_from(parameters).unwrap_or(0),
        })
    }
}

/// A field of a line of the directory, from 1, without the blanks around it.
fn field_of<'l>(line: &'l Line<'_>, field: usize) -> &'l [u8] {
    let from = 8 * (field - 1);
    let to = (from + 8).min(72).min(line.text.len());
    line.text.get(from..to).unwrap_or_default().trim_ascii()
}
