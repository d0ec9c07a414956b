//! Free-form curves and surfaces: the state of `cstype`, `deg`, `bmat` and `step`, and the element between `curv`,
//! `curv2` or `surf` and `end`.

mod basis;
mod build;
mod trim;

use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::spline::Curve;

use super::raw::Raw;
use super::section::Shape;
use super::statement::Known;
use crate::number::{entry, next_number, numbers};
use crate::text::{show, tokens};
use basis::Kind;

pub(crate) use trim::Meeting;

/// An error of a statement before the one at hand, or of that one.
#[derive(Debug)]
pub(crate) struct At {
    pub(crate) line: Option<usize>,
    pub(crate) problem: String,
}

impl From<String> for At {
    fn from(problem: String) -> Self {
        Self { line: None, problem }
    }
}

fn at(line: usize, problem: impl Into<String>) -> At {
    At { line: Some(line), problem: problem.into() }
}

/// What a free-form element is.
#[derive(Debug)]
enum What {
    Curve { range: (f64, f64), vertices: Vec<u32> },
    Curve2 { vertices: Vec<u32> },
    Surface { ranges: [(f64, f64); 2], vertices: Vec<u32> },
}

/// Part of a curve in the parameter plane: from, to, and its number counted from 0.
type Piece = (f64, f64, u32);

/// `trim`, `hole` or `scrv`.
#[derive(Debug)]
struct Loop {
    kind: Known,
    pieces: Vec<Piece>,
    line: usize,
}

/// An element that has started.
#[derive(Debug)]
struct Body {
    what: What,
    line: usize,
    /// `parm u` and `parm v`, with their lines.
    parameters: [Option<(Vec<f64>, usize)>; 2],
    loops: Vec<Loop>,
    /// Special points, as parameter vertices.
    special: Vec<u32>,
}

/// What of a curve was read otherwise than the file has it, as some exporters get it wrong.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mended {
    /// The range of a curve goes beyond what its knots define.
    clipped: bool,
    /// That of a surface does.
    clipped_surface: bool,
    /// It has one or two knots too many.
    dropped: bool,
    /// A loop uses a curve backwards.
    pub(crate) turned: bool,
}

impl Mended {
    /// In words; `None` where nothing was.
    pub(crate) fn reason(self) -> Option<String> {
        let clipped = "a curve that runs beyond what its knots define: its range was clipped to that";
        let clipped_surface =
            "a surface that runs beyond what its knots define: its range was clipped to that";
        let dropped = "a B-spline curve with one or two values of parm too many: the last were dropped";
        let turned = "a loop that runs backwards along one of its curves: that curve was turned round";
        let all = [
            (self.dropped, dropped),
            (self.clipped, clipped),
            (self.clipped_surface, clipped_surface),
            (self.turned, turned),
        ];
        let said: Vec<&str> = all.iter().filter(|(done, _)| *done).map(|(_, words)| *words).collect();
        (!said.is_empty()).then(|| said.join("; "))
    }
}

/// What an element became.
#[derive(Debug)]
pub(crate) enum Outcome {
    Shape {
        shape: Box<Shape>,
        surface: Option<usize>,
        wrapped: bool,
        /// What was read otherwise than the file has it.
        mended: Mended,
    },
    /// A curve in the parameter plane, which counts where a surface uses it.
    ParameterCurve,
    /// Nothing: what was wrong with it has been said.
    GivenUp,
    LeftOut(String),
}

/// What an element used: vertices and parameter vertices; special points of curves, which are not kept.
#[derive(Debug, Default)]
pub(crate) struct Used {
    /// Where the element starts.
    pub(crate) line: usize,
    pub(crate) vertices: Vec<u32>,
    pub(crate) parameters: Vec<u32>,
    pub(crate) special_left_out: usize,
    /// Texture vertices and normals at control points, which are not kept.
    pub(crate) attributes_left_out: usize,
    pub(crate) loops: usize,
}

/// A curve in the parameter plane, and what became of it.
#[derive(Debug)]
pub(crate) struct PlaneCurve {
    /// `None` where it is left out.
    curve: Option<Curve>,
    pub(crate) vertices: Vec<u32>,
    pub(crate) used: bool,
}

/// The state between statements.
#[derive(Debug, Default)]
pub(crate) struct Freeform {
    kind: Option<(bool, Kind)>,
    degrees: Option<[usize; 2]>,
    matrices: [Option<Vec<f64>>; 2],
    steps: [Option<usize>; 2],
    body: Option<Body>,
    /// Whether the element at hand, up to its end, was given up.
    given_up: bool,
    pub(crate) plane_curves: Vec<PlaneCurve>,
    /// Surfaces so far; whether each is in the scene.
    surfaces: Vec<bool>,
    attributes: usize,
    /// Control vertices of parameter curves that surfaces hold so far: a curve may be used again and again, and a
    /// small file must not become a large scene by that.
    held: usize,
    /// How many that may be.
    budget: usize,
}

/// How many vertices there are so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SoFar {
    pub(crate) points: usize,
    pub(crate) parameters: usize,
}

impl Freeform {
    /// Nothing yet; `budget` control vertices of parameter curves may be held by surfaces.
    pub(crate) fn new(budget: usize) -> Self {
        Self { budget, ..Self::default() }
    }

    /// A statement of the state or of an element's body. Where it is wrong, the element is given up, or, of the state,
    /// those that need it.
    pub(crate) fn statement(
        &mut self,
        known: Known,
        rest: &[u8],
        line: usize,
        so_far: SoFar,
    ) -> Result<(), At> {
        let of_body = matches!(known, Known::Parm | Known::Trim | Known::Hole | Known::Scrv | Known::Sp);
        if of_body && self.given_up {
            return Ok(());
        }
        let taken = self.take(known, rest, line, so_far);
        if taken.is_err() {
            match known {
                Known::Curv => self.given_up = true,
                Known::Curv2 => self.give_up(&What::Curve2 { vertices: Vec::new() }),
                Known::Surf => self.give_up(&What::Surface { ranges: [(0.0, 1.0); 2], vertices: Vec::new() }),
                _ if of_body => {
                    if let Some(body) = self.body.take() {
                        self.give_up(&body.what);
                    }
                }
                _ => {}
            }
        }
        taken
    }

    /// Gives up an element, which keeps its number.
    fn give_up(&mut self, what: &What) {
        self.given_up = true;
        match what {
            What::Curve { .. } => {}
            What::Curve2 { vertices } => {
                self.plane_curves.push(PlaneCurve { curve: None, vertices: vertices.clone(), used: false });
            }
            What::Surface { .. } => self.surfaces.push(false),
        }
    }

    fn take(&mut self, known: Known, rest: &[u8], line: usize, so_far: SoFar) -> Result<(), At> {
        match known {
            Known::Cstype => {
                self.kind = None;
                Ok(self.cstype(rest)?)
            }
            Known::Deg => {
                self.degrees = None;
                Ok(self.deg(rest)?)
            }
            Known::Bmat => {
                let (side, values) = side(rest, "bmat")?;
                self.matrices[side] = Some(numbers(values)?);
                Ok(())
            }
            Known::Step => Ok(self.step(rest)?),
            Known::Curv | Known::Curv2 | Known::Surf => self.start(known, rest, line, so_far),
            Known::Parm => {
                let (side, values) = side(rest, "parm")?;
                self.body("parm")?.parameters[side] = Some((numbers(values)?, line));
                Ok(())
            }
            Known::Trim | Known::Hole | Known::Scrv => {
                let count = self.plane_curves.len();
                let body = self.body("trim, hole or scrv")?;
                if !matches!(body.what, What::Surface { .. }) {
                    return Err("only surfaces have trim, hole and scrv".to_owned().into());
                }
                body.loops.push(Loop { kind: known, pieces: trim::pieces(rest, count)?, line });
                Ok(())
            }
            Known::Sp => {
                let body = self.body("sp")?;
                for word in tokens(rest) {
                    let vertex = entry(word, so_far.parameters, "parameter vertex")?;
                    check(vertex, so_far.parameters, "parameter vertex")?;
                    body.special.push(vertex);
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn body(&mut self, what: &str) -> Result<&mut Body, String> {
        self.body.as_mut().ok_or_else(|| format!("{what} without a curv, curv2 or surf before it"))
    }

    /// `cstype [rat] type`.
    fn cstype(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut parts = tokens(rest).peekable();
        let rational = parts.next_if_eq(&b"rat".as_slice()).is_some();
        let kind = match parts.next() {
            Some(b"bspline") => Kind::Bspline,
            Some(b"bezier") => Kind::Bezier,
            Some(b"bmatrix") => Kind::Bmatrix,
            Some(b"cardinal") => Kind::Cardinal,
            Some(b"taylor") => Kind::Taylor,
            other => {
                let found = show(other.unwrap_or_default());
                let known = "bspline, bezier, bmatrix, cardinal and taylor";
                return Err(format!("unknown type of curve \"{found}\": {known} are known"));
            }
        };
        self.kind = Some((rational, kind));
        Ok(())
    }

    /// `deg degu [degv]`.
    fn deg(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut degrees = tokens(rest).map(|word| {
            let text = std::str::from_utf8(word).unwrap_or_default();
            match text.parse::<usize>() {
                Ok(degree) if (1..=MAX_DEGREE).contains(&degree) => Ok(degree),
                _ => Err(format!("a degree of \"{}\" is not supported: 1 to {MAX_DEGREE} are", show(word))),
            }
        });
        let u = degrees.next().unwrap_or_else(|| Err("deg needs a degree".to_owned()))?;
        let v = degrees.next().unwrap_or(Ok(u))?;
        self.degrees = Some([u, v]);
        Ok(())
    }

    /// `step stepu [stepv]`.
    fn step(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut steps = tokens(rest).map(|word| {
            let text = std::str::from_utf8(word).unwrap_or_default();
            text.parse::<usize>()
                .ok()
                .filter(|&step| step > 0)
                .ok_or_else(|| format!("a step of \"{}\" leads nowhere: 1 or more is right", show(word)))
        });
        let u = steps.next().unwrap_or_else(|| Err("step needs a number".to_owned()))?;
        let v = steps.next().unwrap_or(Ok(u))?;
        self.steps = [Some(u), Some(v)];
        Ok(())
    }

    /// `curv u0 u1 v …`, `curv2 vp …`, `surf s0 s1 t0 t1 v/vt/vn …`.
    fn start(&mut self, known: Known, rest: &[u8], line: usize, so_far: SoFar) -> Result<(), At> {
        self.given_up = false;
        let mut text = rest;
        let mut range = || match (next_number(&mut text), next_number(&mut text)) {
            (Ok(Some(a)), Ok(Some(b))) => Ok((a, b)),
            (Err(problem), _) | (_, Err(problem)) => Err(problem),
            _ => Err("its parameters are missing: a curve needs a start and an end, a surface two of each"
                .to_owned()),
        };
        let what = match known {
            Known::Curv => {
                let range = range()?;
                What::Curve { range, vertices: self.vertices(text, so_far.points, "vertex")? }
            }
            Known::Curv2 => {
                What::Curve2 { vertices: self.vertices(text, so_far.parameters, "parameter vertex")? }
            }
            _ => {
                let ranges = [range()?, range()?];
                What::Surface { ranges, vertices: self.vertices(text, so_far.points, "vertex")? }
            }
        };
        let (parameters, loops, special) = ([None, None], Vec::new(), Vec::new());
        self.body = Some(Body { what, line, parameters, loops, special });
        Ok(())
    }

    fn vertices(&mut self, text: &[u8], so_far: usize, what: &str) -> Result<Vec<u32>, String> {
        let mut out = Vec::new();
        for word in tokens(text) {
            let end = word.iter().position(|&b| b == b'/').unwrap_or(word.len());
            let vertex = entry(&word[..end], so_far, what)?;
            // The element is made at its end: what comes later in the file is not there yet.
            check(vertex, so_far, what)?;
            self.attributes += usize::from(end < word.len());
            out.push(vertex);
        }
        Ok(out)
    }

    /// Gives up an element that has started and not ended; its line.
    pub(crate) fn abandon(&mut self) -> Option<usize> {
        let body = self.body.take()?;
        self.give_up(&body.what);
        Some(body.line)
    }

    /// `end`: the element is complete.
    pub(crate) fn end(&mut self, raw: &Raw) -> Result<(Outcome, Used), At> {
        let body = self.body.take();
        if std::mem::take(&mut self.given_up) {
            self.attributes = 0;
            return Ok((Outcome::GivenUp, Used::default()));
        }
        let body = body.ok_or_else(|| "end without a curv, curv2 or surf before it".to_owned())?;
        let attributes_left_out = std::mem::take(&mut self.attributes);
        let mut used = Used { line: body.line, attributes_left_out, ..Used::default() };
        let outcome = self.finish(body, raw, &mut used)?;
        Ok((outcome, used))
    }
}

/// `u` or `v`, and what follows it.
fn side<'t>(rest: &'t [u8], what: &str) -> Result<(usize, &'t [u8]), String> {
    let (word, values) = crate::text::keyword(rest);
    match word {
        b"u" => Ok((0, values)),
        b"v" => Ok((1, values)),
        _ => Err(format!("{what} \"{}\": only u and v are parameters", show(word))),
    }
}

fn check(index: u32, count: usize, what: &str) -> Result<(), String> {
    if (index as usize) < count {
        return Ok(());
    }
    Err(format!("refers to {what} {}, but there are {count} so far", u64::from(index) + 1))
}
