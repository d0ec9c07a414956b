//! Statements whose order counts: the parts one after the other, sorted into the sections that become objects.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use loftsman_kernel::spline::Curve;
use loftsman_kernel::text::Encoding;

use super::Split;
use super::freeform::{At, Freeform, Meeting, Outcome, SoFar};
use super::ours::Ours;
use super::part::{Counts, Mark, Parsed, WRONG};
use super::raw::{Raw, Use};
use super::section::{Element, Section, Shape, State};
use super::statement::Known;
use super::tally::Tallies;
use crate::text::{name, show, tokens};

/// The most groups that faces may be in at once, so that a small file cannot become a large scene by them.
const GROUPS: usize = 16;

/// The most material libraries that are looked for.
const LIBRARIES: usize = 64;

/// Why statements are left out that are not named one by one.
const MORE_WRONG: &str = "further statements that are wrong";

/// Names in the order in which they came.
#[derive(Debug, Default)]
pub(crate) struct Names {
    pub(crate) list: Vec<String>,
    index: HashMap<String, usize>,
}

impl Names {
    fn place(&mut self, name: String) -> usize {
        if let Some(&at) = self.index.get(&name) {
            return at;
        }
        let at = self.list.len();
        self.list.push(name.clone());
        self.index.insert(name, at);
        at
    }
}

/// What the statements have built so far.
pub(crate) struct Reader {
    pub(crate) raw: Raw,
    pub(crate) freeform: Freeform,
    pub(crate) sections: Vec<Section>,
    by_name: HashMap<String, usize>,
    /// The section that elements go to, once it has any.
    current: Option<usize>,
    current_name: String,
    /// The line of the statement that the current name came with, until elements follow or another name.
    pending: Option<usize>,
    split: Split,
    state: State,
    pub(crate) groups: Names,
    /// The line that first names each group.
    pub(crate) group_lines: Vec<usize>,
    /// Groups that some element was in.
    pub(crate) groups_used: BTreeSet<usize>,
    pub(crate) materials: Names,
    /// Material libraries, with the line that first names them.
    pub(crate) libraries: Vec<(Vec<u8>, usize)>,
    pub(crate) left_out: BTreeMap<String, usize>,
    /// What is left out likewise, with the line of the first.
    pub(crate) left_out_at: Tallies,
    pub(crate) unknown: Tallies,
    /// Elements and statements that are in the scene.
    pub(crate) kept: usize,
    /// The first statement that is wrong, with its line; and how many are named in the report.
    pub(crate) first_wrong: Option<(usize, String)>,
    wrong_named: usize,
    /// Vertices, texture vertices and normals whose statement is wrong.
    pub(crate) broken: [Vec<u32>; 3],
    pub(crate) broken_counts: [usize; 3],
    /// The exact curve that was noted for the next one.
    exact: Option<Curve>,
    /// Curves whose own knots were noted beside the form in which they are written.
    pub(crate) restored: usize,
    /// What became of vertices and parameter vertices that free-form elements use.
    pub(crate) used: Vec<u32>,
    pub(crate) parameter_uses: Vec<Use>,
    pub(crate) meetings: Vec<Meeting>,
    /// Statements understood.
    pub(crate) understood: usize,
    pub(crate) periodic: usize,
    /// Free-form elements that were read otherwise than the file has them, by what was done.
    pub(crate) mended: Tallies,
    pub(crate) third: usize,
    /// Files that are older than UTF-8, and how they were read.
    pub(crate) old: Vec<(String, Encoding)>,
}

impl Reader {
    pub(crate) fn new(split: Split, counts: Counts, budget: usize) -> Self {
        Self {
            raw: Raw::new(counts),
            freeform: Freeform::new(budget),
            sections: Vec::new(),
            by_name: HashMap::new(),
            current: None,
            current_name: String::new(),
            pending: None,
            split,
            state: State::default(),
            groups: Names::default(),
            group_lines: Vec::new(),
            groups_used: BTreeSet::new(),
            materials: Names::default(),
            libraries: Vec::new(),
            left_out: BTreeMap::new(),
            left_out_at: Tallies::new(),
            unknown: Tallies::new(),
            kept: 0,
            first_wrong: None,
            wrong_named: 0,
            broken: Default::default(),
            broken_counts: [0; 3],
            exact: None,
            restored: 0,
            used: Vec::new(),
            parameter_uses: vec![Use::Nothing; counts.parameters],
            meetings: Vec::new(),
            understood: 0,
            periodic: 0,
            mended: Tallies::new(),
            third: 0,
            old: Vec::new(),
        }
    }

    pub(crate) fn leave_out(&mut self, reason: &str, count: usize) {
        if count > 0 {
            match self.left_out.get_mut(reason) {
                Some(known) => *known += count,
                None => _ = self.left_out.insert(reason.to_owned(), count),
            }
        }
    }

    /// Leaves out what is told with the line of the first.
    pub(crate) fn leave_out_at(&mut self, reason: &str, count: usize, line: usize) {
        if count > 0 {
            match self.left_out_at.get_mut(reason) {
                Some(known) => known.add(count, line),
                None => self.left_out_at.entry(reason.to_owned()).or_default().add(count, line),
            }
        }
    }

    /// Leaves out a statement that is wrong, or what it belongs to.
    pub(crate) fn wrong(&mut self, line: usize, problem: String) {
        if self.wrong_named < WRONG {
            self.wrong_named += 1;
            self.leave_out(&format!("line {line}: {problem}"), 1);
        } else {
            self.leave_out(MORE_WRONG, 1);
        }
        if self.first_wrong.as_ref().is_none_or(|(first, _)| line < *first) {
            self.first_wrong = Some((line, problem));
        }
    }

    /// Takes a part; `before` is what the file has before it.
    pub(crate) fn take(&mut self, mut parsed: Parsed<'_>, before: Counts) {
        self.raw.take(before.points, &mut parsed);
        for (line, problem) in std::mem::take(&mut parsed.wrong) {
            self.wrong(line, problem);
        }
        self.leave_out(MORE_WRONG, parsed.more_wrong);
        for (all, part) in self.broken.iter_mut().zip(&mut parsed.broken) {
            all.append(part);
        }
        self.understood += parsed.understood;
        self.third += parsed.third;
        self.leave_out("texture vertices of lines are not kept", parsed.line_textures);
        self.leave_out("statements about display are not kept", parsed.display);
        let superseded =
            "superseded statements (bsp, bzp, cdc, cdp, res) and calls of other files are not read";
        if parsed.obsolete.count > 0 {
            self.left_out_at.entry(superseded.to_owned()).or_default().and(parsed.obsolete);
        }
        for (name, tally) in std::mem::take(&mut parsed.unknown) {
            let full = self.unknown.len() >= 32 && !self.unknown.contains_key(&name);
            self.unknown.entry(if full { "others".to_owned() } else { name }).or_default().and(tally);
        }
        self.kept += parsed.ends.len() + parsed.chain_ends.len() + parsed.dot_ends.len();
        let marks = std::mem::take(&mut parsed.marks);
        let mut done = [0; 3];
        for mark in &marks {
            self.elements(&parsed, &mut done, [mark.faces, mark.chains, mark.dots].map(|n| n as usize));
            if let Err(At { line, problem }) = self.mark(mark, before) {
                self.wrong(line.unwrap_or(mark.line), problem);
            }
        }
        let all = [parsed.ends.len(), parsed.chain_ends.len(), parsed.dot_ends.len()];
        self.elements(&parsed, &mut done, all);
    }

    /// Leaves out an element that has no end.
    pub(crate) fn abandon(&mut self) {
        if let Some(line) = self.freeform.abandon() {
            self.wrong(line, "the curve or surface has no end statement".to_owned());
        }
    }

    /// Gives the section what a part has from `done` up to `until`: faces, lines, points.
    fn elements(&mut self, parsed: &Parsed<'_>, done: &mut [usize; 3], until: [usize; 3]) {
        if *done == until {
            return;
        }
        self.groups_used.extend(&self.state.groups);
        let section = self.section();
        let section = &mut self.sections[section];
        let run = |k: usize| done[k]..until[k];
        section.faces(parsed, run(0), &self.state, &self.groups.list);
        section.lines(parsed, run(1), &self.state);
        section.dots(parsed, run(2), &self.state);
        *done = until;
    }

    /// Counts an object that nothing came after.
    pub(crate) fn empty_before(&mut self) {
        if let Some(line) = self.pending.take()
            && !self.by_name.contains_key(&self.current_name)
        {
            self.kept -= 1;
            self.leave_out_at("names of objects (o, or g) that have no elements", 1, line);
        }
    }

    /// The section at hand.
    fn section(&mut self) -> usize {
        if let Some(current) = self.current {
            return current;
        }
        let next = self.sections.len();
        let at = *self.by_name.entry(self.current_name.clone()).or_insert(next);
        if at == next {
            self.sections.push(Section::new(&self.current_name));
        }
        self.current = Some(at);
        at
    }

    /// Goes on with the section of a name; the name of nothing is that of the file.
    fn switch(&mut self, name: String, line: usize) {
        self.kept += 1;
        self.empty_before();
        self.pending = Some(line);
        self.current_name = name;
        self.current = None;
    }

    fn mark(&mut self, mark: &Mark<'_>, before: Counts) -> Result<(), At> {
        let rest = mark.rest.as_ref();
        match mark.known {
            Known::Object if self.split == Split::Object => self.switch(name(rest), mark.line),
            Known::Object => self.leave_out("objects (o) were not asked for", 1),
            Known::Group if self.split == Split::Group => self.switch(name(rest), mark.line),
            Known::Group => self.group(rest, mark.line),
            Known::Smoothing => self.smoothing(rest)?,
            Known::Material => {
                let material = name(rest);
                self.state.material =
                    Some(material).filter(|name| !name.is_empty()).map(|name| self.materials.place(name));
                self.kept += 1;
            }
            Known::Library => {
                // A file that repeats the statement before every object must not have the library read as often.
                let library = rest.trim_ascii();
                if self.libraries.iter().any(|(known, _)| known == library) {
                    self.kept += 1;
                } else if self.libraries.len() < LIBRARIES {
                    self.libraries.push((library.to_vec(), mark.line));
                } else {
                    self.leave_out_at(&format!("material libraries beyond {LIBRARIES}"), 1, mark.line);
                }
            }
            Known::Mrgb => {
                let count = before.points + mark.points as usize;
                self.raw.mrgb(rest, count)?;
            }
            Known::Ours => self.ours(rest),
            Known::End => self.end()?,
            Known::Con => match self.freeform.connection(rest, mark.line)? {
                Ok(meeting) => {
                    self.meetings.push(meeting);
                    self.kept += 1;
                }
                Err(reason) => self.leave_out_at(&format!("a connection (con): {reason}"), 1, mark.line),
            },
            known => {
                if matches!(known, Known::Curv | Known::Curv2 | Known::Surf) {
                    self.abandon();
                }
                let so_far = SoFar {
                    points: before.points + mark.points as usize,
                    parameters: before.parameters + mark.parameters as usize,
                };
                self.freeform.statement(known, rest, mark.line, so_far)?;
            }
        }
        Ok(())
    }

    fn group(&mut self, rest: &[u8], line: usize) {
        self.kept += 1;
        self.state.groups.clear();
        let mut beyond = 0;
        for word in tokens(rest) {
            // What no group was named for is in the group "default".
            let name = name(word);
            if name.is_empty() || name == "default" {
                continue;
            }
            if self.state.groups.len() == GROUPS {
                beyond += 1;
                continue;
            }
            let place = self.groups.place(name);
            if place == self.group_lines.len() {
                self.group_lines.push(line);
            }
            if !self.state.groups.contains(&place) {
                self.state.groups.push(place);
            }
        }
        self.leave_out_at(&format!("groups of one statement beyond {GROUPS}"), beyond, line);
    }

    fn smoothing(&mut self, rest: &[u8]) -> Result<(), String> {
        let word = tokens(rest).next().unwrap_or_default();
        self.state.smoothing = Some(match word {
            b"off" => 0,
            b"on" => 1,
            digits => match std::str::from_utf8(digits).ok().and_then(|text| text.parse().ok()) {
                Some(group) => group,
                None => {
                    let found = show(digits);
                    return Err(format!(
                        "\"{found}\" is no smoothing group: a number from 0, or off, is one"
                    ));
                }
            },
        });
        self.kept += 1;
        Ok(())
    }

    /// What was noted here in a comment; other comments that start alike are comments.
    fn ours(&mut self, rest: &[u8]) {
        match Ours::of(rest) {
            Some(Ours::Curve(curve)) => self.exact = Some(curve),
            Some(Ours::MadeNormals) => {
                let section = self.section();
                self.sections[section].made_normals = true;
            }
            Some(Ours::Mesh(mark)) => {
                let section = self.section();
                self.sections[section].shows = Some(mark);
            }
            Some(Ours::Surface(own, mesh)) => {
                let section = self.section();
                self.sections[section].shown = Some((own, mesh));
            }
            Some(Ours::Color(color)) => {
                let section = self.section();
                self.sections[section].color = Some(color);
            }
            None => {}
        }
    }

    fn end(&mut self) -> Result<(), At> {
        let (outcome, used) = self.freeform.end(&self.raw)?;
        self.used.extend(&used.vertices);
        for &vertex in &used.parameters {
            self.parameter_uses[vertex as usize] = Use::Kept;
        }
        self.kept += used.loops;
        self.leave_out("special points (sp) of curves are not kept", used.special_left_out);
        self.leave_out(
            "texture vertices and normals at control vertices are not kept",
            used.attributes_left_out,
        );
        match outcome {
            Outcome::Shape { mut shape, surface, wrapped, mended } => {
                if let (Some(exact), Shape::Curve(curve)) = (self.exact.take(), shape.as_mut())
                    && exact.bezier_form().is_ok_and(|form| form == *curve)
                {
                    *curve = exact;
                    self.restored += 1;
                }
                match mended.reason() {
                    None => self.kept += 1,
                    Some(reason) => self.mended.entry(reason).or_default().add(1, used.line),
                }
                self.periodic += usize::from(wrapped);
                self.groups_used.extend(&self.state.groups);
                let material = self.state.material;
                let index = self.section();
                // The group is its name where there is none, or where that is the name of the faces, lines or points before it: so Blender
                // writes curves behind a mesh.
                let section = &self.sections[index];
                let group = self
                    .state
                    .groups
                    .first()
                    .copied()
                    .filter(|&group| section.name.is_empty() || section.is_before(group));
                self.leave_out_at(
                    "groups of curves and surfaces, which have none: at most one is their name",
                    self.state.groups.len() - usize::from(group.is_some()),
                    used.line,
                );
                let name = group.map(|group| self.groups.list[group].clone());
                let section = &mut self.sections[index];
                section.elements.push(Element { shape: *shape, name, surface, material });
            }
            Outcome::ParameterCurve | Outcome::GivenUp => {}
            Outcome::LeftOut(reason) => {
                self.leave_out_at(&format!("a free-form element: {reason}"), 1, used.line);
            }
        }
        Ok(())
    }
}
