//! The first pass over a file: its rows, in blocks, and the lines of text before them.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Cancelled, FormatError, Observer, Place};
use loftsman_kernel::scene::{Unit, Up};

use super::columns::{Columns, RowFault, header, names_axes};
use super::line::{Separator, before_comment, clip, comment, lines, text};
use super::number::{NumberFault, Signs, parse};
use super::tecplot::Tecplot;
use crate::marks::{self, Kind};

/// How many lines of text may stand before the first row.
const MOST_WORDS: usize = 32;

/// Rows that belong together.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    /// Its name, if the file says one.
    pub(super) name: Option<String>,
    /// What it is, if the file says so.
    pub(super) kind: Option<Kind>,
    /// The line before its first row.
    pub(super) line: usize,
    /// Its rows.
    pub(super) points: Vec<Point>,
    /// The rows with blank lines before them, but for the first row.
    pub(super) gaps: Vec<usize>,
}

/// A single number in a line of its own before the rows: usually their count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Single {
    /// Its line.
    pub(super) line: usize,
    /// The number.
    pub(super) value: f64,
}

/// What a file holds.
#[derive(Debug, Clone, Default)]
pub(super) struct Scan {
    /// Lines of text before the rows that are no header: the first is usually a name.
    pub(super) words: Vec<(usize, String)>,
    /// A number alone in a line before the rows, and its spelling.
    pub(super) single: Option<(Single, String)>,
    /// The columns, once there is a row.
    pub(super) columns: Option<Columns>,
    /// The rows.
    pub(super) blocks: Vec<Block>,
    /// Whether some stand under a heading of their own, below others.
    pub(super) headed: bool,
    /// Lines of text below the last row.
    pub(super) footnotes: Vec<usize>,
    /// Whether there were Tecplot headers.
    pub(super) tecplot: bool,
    /// Whether it was written here.
    pub(super) own: bool,
    /// Unit and axis, where a file written here says them.
    pub(super) unit: Option<Unit>,
    pub(super) up: Option<Up>,
    /// Which decimal signs there are.
    pub(super) signs: Signs,
}

impl Scan {
    /// Scans a text.
    pub(super) fn new(bytes: &[u8], observer: &dyn Observer) -> Result<Self, FormatError> {
        let mut scanner = Scanner::default();
        for (number, line) in lines(bytes) {
            if number % 65_536 == 1 && observer.cancelled() {
                return Err(Cancelled.into());
            }
            scanner.number = number;
            let blank = scanner.blank;
            let taken = match scanner.line(line) {
                Ok(()) => scanner.check_footnotes(),
                Err(problem) => {
                    scanner.blank = blank;
                    scanner.text_below(line, problem)
                }
            };
            taken.map_err(|(line, problem)| FormatError::new(Place::Line(line), problem))?;
        }
        scanner.finish()
    }

    /// How many rows there are in all.
    pub(super) fn rows(&self) -> usize {
        self.blocks.iter().map(|b| b.points.len()).sum()
    }
}

/// A scan under way.
#[derive(Default)]
struct Scanner<'t> {
    scan: Scan,
    /// The line that is being scanned.
    number: usize,
    /// Lines of text before the rows, the header among them.
    words: Vec<(usize, &'t [u8])>,
    /// The last comment before the rows: some files name their columns there.
    last_comment: Option<&'t [u8]>,
    tecplot: Tecplot,
    blank: bool,
    /// Lines of text below rows: a heading, where rows follow, else footnotes; and why the first is no row.
    below: Vec<(usize, &'t [u8])>,
    /// The first of them that is a footnote if no rows follow, and an error else; and why it is no row.
    loose: Option<(usize, String)>,
    no_row: Option<(usize, String)>,
}

/// Whether a line that is no row is meant as text: it begins with a word or with a mark that no number has ("* see p. 3"), has words and no number at
/// all, or words and at most one number among them in another count of fields than rows have ("12 % thick"). One field of a row that is wrong is none
/// ("0.5 O.25").
fn is_text(line: &[u8], columns: &Columns) -> bool {
    let separator = columns.separator();
    let is_word = |field: &[u8]| matches!(parse(field, true, &mut Signs::default()), Err(NumberFault::Word));
    let first = separator.fields(line).next().unwrap_or_default();
    let begins = |b: &u8| b.is_ascii_alphabetic() || *b > 127 || b"(*$&@=~<>[{|_\\".contains(b);
    if first.first().is_some_and(begins) && is_word(first) {
        return true;
    }
    let spoken = |field: &&[u8]| {
        is_word(field) && field.windows(2).any(|pair| pair.iter().all(u8::is_ascii_alphabetic))
    };
    let blanks = || Separator::Blanks.fields(line);
    let words = blanks().filter(spoken).count();
    let numbers = |separator: Separator| separator.fields(line).filter(|field| !is_word(field)).count();
    let numbers = [numbers(Separator::Blanks), numbers(separator)].into_iter().max().unwrap_or(0);
    let as_a_row = blanks().count() == columns.count || separator.fields(line).count() == columns.count;
    words >= 1 && (numbers == 0 || numbers == 1 && (words >= 2 || !as_a_row))
}

/// Whether a line is meant as text that would be no heading, where no rows follow: it has a word of letters beside numbers, in another count of fields than rows have ("17 May 1998", "0.12 0.30 max
/// thickness"), or is one field that is no number and no list of any ("---", "1987-03-12").
fn is_footnote(line: &[u8], columns: &Columns) -> bool {
    let is_word = |field: &[u8]| matches!(parse(field, true, &mut Signs::default()), Err(NumberFault::Word));
    let spoken =
        |field: &[u8]| is_word(field) && field.len() > 2 && field.iter().take(3).all(u8::is_ascii_alphabetic);
    let mut fields = Separator::Blanks.fields(line);
    let alone =
        |field: &[u8]| is_word(field) && !field.iter().any(|b| b",;.".contains(b) || b.is_ascii_alphabetic());
    match (fields.next(), fields.next()) {
        (Some(field), None) => columns.count > 1 && alone(field),
        // As many fields as rows have are a row of which some are wrong.
        _ => {
            columns.separator().fields(line).count() != columns.count
                && Separator::Blanks.fields(line).any(spoken)
        }
    }
}

impl<'t> Scanner<'t> {
    fn line(&mut self, line: &'t [u8]) -> Result<(), String> {
        if line.is_empty() {
            self.blank = true;
            return Ok(());
        }
        if let Some(comment) = comment(line) {
            self.comment(comment);
            return Ok(());
        }
        if self.tecplot.takes(line)? {
            self.scan.tecplot = true;
            if let Some(name) = self.tecplot.zone() {
                self.open(Block { name, kind: Some(Kind::Polyline { closed: None }), ..Block::default() });
            }
            return Ok(());
        }
        if self.scan.columns.is_none() {
            return self.line_before_rows(line, before_comment(line));
        }
        // Few rows have a comment behind them: it is looked for where a row is none as it stands.
        let signs = self.scan.signs;
        self.row(line).or_else(|problem| {
            let row = before_comment(line);
            self.scan.signs = signs;
            if row.len() < line.len() { self.row(row) } else { Err(problem) }
        })
    }

    /// A row, now that the columns are known.
    fn row(&mut self, line: &[u8]) -> Result<(), String> {
        let Some(columns) = &self.scan.columns else { return Ok(()) };
        let point = columns.point(line, &mut self.scan.signs).map_err(|fault| match fault {
            RowFault::Field(word, NumberFault::Word) if word.is_empty() => {
                "a column is empty: every row needs all its coordinates".to_owned()
            }
            RowFault::Field(word, NumberFault::Word) => format!(
                "\"{word}\" is not a number: rows are numbers; text may stand in lines of its own before and below the rows, over two rows or more, or behind #, ! or %"
            ),
            RowFault::Field(word, why) => format!("\"{word}\" {}", why.says()),
            RowFault::Count(1) => "the row has one number: a point needs two or three".to_owned(),
            RowFault::Count(found) => {
                let expected = columns.count;
                format!(
                    "the row has {found} columns, the rows before have {expected}: give every row the same"
                )
            }
        })?;
        if let Some((_, heading)) = self.below.first() {
            let name = super::without_padding(&text(heading)).to_owned();
            self.below.clear();
            self.scan.headed = true;
            self.open(Block { name: Some(name), ..Block::default() });
        } else if self.scan.blocks.is_empty() {
            self.open(Block::default());
        }
        if let Some(block) = self.scan.blocks.last_mut() {
            if std::mem::take(&mut self.blank) && !block.points.is_empty() {
                block.gaps.push(block.points.len());
            }
            block.points.push(point);
        }
        Ok(())
    }

    /// A line below rows that is none: text, which is a heading or a footnote, if it is no row with something wrong in it.
    fn text_below(&mut self, line: &'t [u8], problem: String) -> Result<(), (usize, String)> {
        let here = self.number;
        let Some(columns) = self.scan.columns.as_ref().filter(|_| !self.scan.own && !self.scan.tecplot)
        else {
            return Err((here, problem));
        };
        let control = line.iter().any(|b| matches!(b, 0..=8 | 14..=31 | 127));
        let text = is_text(line, columns);
        if control || self.below.len() >= MOST_WORDS || !(text || is_footnote(line, columns)) {
            return Err((here, problem));
        }
        if !text {
            self.loose.get_or_insert((here, problem.clone()));
        }
        self.check_headed()?;
        self.no_row.get_or_insert((here, problem));
        self.below.push((here, line));
        Ok(())
    }

    /// What may be a footnote and is no heading does not stand above rows, of which one has just come.
    fn check_footnotes(&mut self) -> Result<(), (usize, String)> {
        match self.loose.take_if(|_| self.below.is_empty()) {
            Some(wrong) => Err(wrong),
            None => Ok(()),
        }
    }

    /// A heading stands over two rows at least: else it is a row that is wrong.
    fn check_headed(&mut self) -> Result<(), (usize, String)> {
        let is_short = self.scan.headed && self.scan.blocks.last().is_some_and(|b| b.points.len() < 2);
        match self.no_row.take() {
            Some((line, _)) if is_short && self.below.is_empty() => {
                let heading = self.scan.blocks.last().and_then(|b| b.name.as_deref()).unwrap_or_default();
                Err((
                    line,
                    format!(
                        "\"{}\" is not a number: a heading of rows has two of them or more below it, and here is one; other text may stand in lines of its own before and below the rows, or behind #, ! or %",
                        clip(heading.as_bytes())
                    ),
                ))
            }
            other => {
                self.no_row = other.filter(|_| !self.below.is_empty());
                Ok(())
            }
        }
    }

    /// A line before there were rows: the first row, a count, a header or a name.
    fn line_before_rows(&mut self, line: &'t [u8], row: &[u8]) -> Result<(), String> {
        let names = |separator: Separator, count: usize| self.column_names(separator, count);
        if let Some(columns) = Columns::of(row, &names) {
            self.take_words(&columns);
            self.scan.columns = Some(columns);
            return self.row(row);
        }
        if let Ok(value) = parse(row, false, &mut Signs::default()) {
            if self.scan.single.is_some() {
                return Err("the row has one number: a point needs two or three".to_owned());
            }
            self.scan.single = Some((Single { line: self.number, value }, text(row)));
            return Ok(());
        }
        if line.iter().any(|b| matches!(b, 0..=8 | 14..=31 | 127)) {
            return Err("there are control characters: this is no text file".to_owned());
        }
        if self.words.len() >= MOST_WORDS {
            return Err(format!(
                "{MOST_WORDS} lines without a row of two or three numbers: this does not look like a point file"
            ));
        }
        self.words.push((self.number, line));
        Ok(())
    }

    /// The names of the columns: Tecplot's variables, the last line of text, or the last comment if it names axes.
    fn column_names(&self, separator: Separator, count: usize) -> Option<Vec<String>> {
        if let Some(names) = self.tecplot.variables(count) {
            return Some(names);
        }
        let plain = |line: &[u8]| header(line, separator, count);
        let axes = |line: &[u8]| plain(line).filter(|names| names_axes(names));
        match self.words.last() {
            // "Clark Y" over two columns between blanks is a name.
            Some((_, line)) if separator == Separator::Blanks => axes(line),
            Some((_, line)) => plain(line),
            None => self.last_comment.and_then(axes),
        }
    }

    /// Keeps the lines of text, but for the header.
    fn take_words(&mut self, columns: &Columns) {
        let is_header = |line: &[u8]| {
            columns.names.is_some() && header(line, columns.separator(), columns.count) == columns.names
        };
        if self.words.last().is_some_and(|(_, line)| is_header(line)) {
            self.words.pop();
        }
        self.scan.words = self.words.drain(..).map(|(number, line)| (number, text(line))).collect();
    }

    fn comment(&mut self, comment: &'t [u8]) {
        if let Some((unit, up)) = marks::file(comment) {
            (self.scan.own, self.scan.unit, self.scan.up) = (true, Some(unit), Some(up));
        } else if let Some((name, kind)) = self.scan.own.then(|| marks::object(comment)).flatten() {
            self.open(Block { name: Some(name), kind: Some(kind), ..Block::default() });
        } else if self.scan.columns.is_none() {
            self.last_comment = Some(comment);
        }
    }

    fn open(&mut self, mut block: Block) {
        block.line = self.number;
        self.blank = false;
        self.scan.blocks.push(block);
    }

    fn finish(mut self) -> Result<Scan, FormatError> {
        let footnotes = self.below.iter().map(|(line, _)| *line).collect();
        self.check_headed().map_err(|(line, problem)| FormatError::new(Place::Line(line), problem))?;
        self.scan.footnotes = footnotes;
        if self.scan.columns.is_some() || self.scan.own && !self.scan.blocks.is_empty() {
            return Ok(self.scan);
        }
        let seen = self.words.first().map(|&(line, words)| (line, words.to_vec()));
        let single = self.scan.single.take().map(|(single, spelling)| (single.line, spelling.into_bytes()));
        let (line, what) = match single.or(seen) {
            Some((line, words)) => (Some(line), format!("\"{}\" and no row", clip(&words))),
            None => (None, "no row".to_owned()),
        };
        let problem =
            format!("{what} of at least two numbers: a point file has the coordinates of a point a line");
        Err(FormatError::new(line.map_or(Place::File, Place::Line), problem))
    }
}
