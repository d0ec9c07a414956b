//! The quadrature behind the area of a surface: two rules on each part, halved where they differ.

mod folds;
mod nodes;
mod part;
mod pile;
mod spans;
mod sums;
mod turns;

use loftsman_kernel::shape::{Cell, Shape, Share};
use loftsman_kernel::{Point, Result, Vector, parallel};

use self::nodes::Nodes;
use self::part::{Judged, Part};
use self::pile::Pile;
use self::spans::Spans;
use self::sums::{Lines, Net, Room};
use crate::members::Member;
use crate::nets::{Nets, Total};

/// The rules' points beyond the degree.
const EXTRA: [usize; 2] = [2, 4];
/// The number of the rule that has the better one's nodes and looks at the ends.
const WITH_ENDS: usize = 2;
/// Halvings allowed in all: so many, and so many for each cell.
const HALVINGS: usize = 400;
const HALVINGS_A_CELL: usize = 1;
/// So many times that where an area is told once.
const MORE: usize = 64;
/// After so many halvings it is looked again whether they are enough.
const LOOK: usize = 256;
/// Into how many parts along each of its borders what loops leave of a cell is cut at most.
const MOST_PARTS: usize = 64;
/// The most points that a rule on what loops leave of a cell is raised to.
const MOST_RAISED: usize = 24;
/// What the two rules may differ by on a part, as a share of a cell's share of the whole.
const AGREE: f64 = 1e-11;
/// What is left of `|S_u × S_v|` below this part of its mean says nothing about the direction of a crease.
const UNSEEN: f64 = 1e-6;
/// Parts that one thread looks at in a run.
const RUN: usize = 32;

/// A surface at work.
pub(super) struct Measure<'s> {
    shape: &'s dyn Shape,
    /// Whether it is a tensor-product spline, all of which counts.
    is_spline: bool,
    /// This, or what each face is of which something counts, in their order.
    patches: Vec<Option<Spans<'s>>>,
    /// The nets of its cells, where it says them.
    nets: Option<Nets<'s>>,
    points: &'s [Point],
    /// What counts of cells, where that is not all.
    counted: &'s [(Cell, Share)],
    degrees: [usize; 2],
    /// The rougher and the better one, and this with its ends.
    rules: [Nodes; 3],
    /// The functions of whole cells at the nodes of these.
    lines: [Lines; 3],
    /// Whether it is told once.
    telling: bool,
}

impl<'s> Measure<'s> {
    pub(super) fn new(surface: &Member<'s>, counted: &'s [(Cell, Share)], effort: Effort) -> Self {
        let nets = Nets::of(surface);
        let degrees = nets.map_or_else(|| surface.cells.degrees(), |nets| nets.degrees);
        let rules = [0, 1, WITH_ENDS].map(|rule| Nodes::of_rule(degrees, rule));
        let spline = |face| surface.cells.patch(face).and_then(|patch| Spans::of(&patch));
        let runs = counted.chunk_by(|(a, _), (b, _)| a.face == b.face);
        let patches = match surface.splines {
            Some(_) => vec![spline(None)],
            None => runs.filter_map(|run| run.first()).map(|(cell, _)| spline(cell.face)).collect(),
        };
        let lines = rules.each_ref().map(|rule| Lines::new(degrees, rule, [(0.0, 1.0); 2]));
        Self {
            shape: surface.shape,
            is_spline: surface.splines.is_some(),
            patches,
            nets,
            points: surface.points(),
            counted,
            degrees,
            rules,
            lines,
            telling: matches!(effort, Effort::Telling(_)),
        }
    }

    /// The cells: of a spline all of its spans, else those of which something counts.
    fn cells(&self) -> Vec<Part> {
        let mut cells = Vec::new();
        if let (true, Some(Some(spline))) = (self.is_spline, self.patches.first()) {
            for (spans, u, v) in spline.all() {
                cells.push(Part { spans: Some((0, spans)), ..Part::whole(None, u, v) });
            }
            return cells;
        }
        let mut faces = Vec::with_capacity(self.patches.len());
        for (number, (cell, share)) in self.counted.iter().enumerate() {
            let [u, v] = cell.sides[..] else { continue };
            if faces.last() != Some(&cell.face) {
                faces.push(cell.face);
            }
            let (u, v) = ((u.start, u.end), (v.start, v.end));
            let patch = faces.len() - 1;
            let spans = self.patches.get(patch).and_then(|spline| spline.as_ref()?.around(u, v));
            let share = matches!(share, Share::Part(_)).then_some((number, 1));
            let spans = spans.map(|spans| (patch, spans));
            cells.push(Part { spans, share, ..Part::whole(cell.face, u, v) });
        }
        cells
    }

    /// All cells, judged in runs side by side; in their order.
    fn first(&self) -> Result<Vec<Judged>> {
        if let Some(nets) = &self.nets {
            return nets.map(&nets.origin, Room::default, |room, net| {
                let [u, v] = net.sides.map(|side| (side.start, side.end));
                let part = Part { cell: net.number, ..Part::whole(net.face, u, v) };
                self.judged(part, Some(Net { points: net.points, sides: net.sides }), room)
            });
        }
        let cells = self.cells();
        in_runs(&cells, |part, room| Ok(self.judged(*part, None, room)))
    }

    /// The area, what it may be wrong by, and its gradient added where there is room.
    pub(super) fn whole(&self, mut gradient: Option<&mut [Vector]>, effort: Effort) -> Result<Area> {
        let mut parts = self.first()?;
        (0..).zip(&mut parts).for_each(|(order, part)| part.order = order);
        let cells = parts.len();
        let usual = halvings(cells);
        let most = if self.telling { MORE * HALVINGS + cells } else { usual };
        let start = Pile::new(parts);
        let mut pile = match self.side_by_side(start.clone(), cells, usual)? {
            Some((pile, done)) => self.one_by_one(pile, cells, done..most, usual, effort)?,
            // It may fold over: where most is gained is first then.
            None => self.one_by_one(start, cells, 0..most, usual, effort)?,
        };
        let parts = pile.take();
        if let Some(gradient) = &mut gradient {
            let mut room = Room::default();
            for part in &parts {
                self.part(part.part, 1, None, Some(gradient), &mut room);
            }
            room.sound()?;
        }
        let (mut area, mut error) = (Total::default(), Total::default());
        for part in &parts {
            area.add(part.fine);
            error.add(part.error);
        }
        Ok(Area { area: area.value(), error: error.value() })
    }

    /// Halves all parts with more than any may have, many at a time: those that would be halved one by one, too. With how many halvings it took; `None`
    /// where these are more than usual.
    fn side_by_side(&self, mut pile: Pile, cells: usize, usual: usize) -> Result<Option<(Pile, usize)>> {
        let mut done = 0;
        loop {
            let limit = AGREE * pile.share.max(pile.largest);
            let worst = pile.above(limit);
            done += worst.len();
            if worst.is_empty() {
                return Ok(Some((pile, done)));
            }
            if done > usual {
                return Ok(None);
            }
            let halves = in_runs(&worst, |part, room| self.split(part, cells, room))?;
            halves.into_iter().zip(worst).for_each(|(halves, whole)| pile.put(halves, whole));
        }
    }

    /// Halves the part with most, and again, until it has no more than it may.
    fn one_by_one(
        &self,
        mut pile: Pile,
        cells: usize,
        halvings: std::ops::Range<usize>,
        usual: usize,
        effort: Effort,
    ) -> Result<Pile> {
        let mut room = Room::default();
        for done in halvings {
            if let Effort::Telling(enough) = effort
                && done >= usual
                && (done - usual).is_multiple_of(LOOK)
            {
                let [area, error] = pile.sums();
                if error <= enough * area {
                    break;
                }
            }
            let Some(worst) = pile.worst() else { break };
            let halves = self.split(&worst, cells, &mut room)?;
            pile.put(halves, worst);
        }
        Ok(pile)
    }

    /// The parts of a part; of a whole cell those beside lines along which it folds over, where there are any. `None` where there is no number between
    /// its ends.
    fn split(&self, whole: &Judged, cells: usize, room: &mut Room) -> Result<Option<Vec<Judged>>> {
        let whole_cell = whole.order < cells && whole.part.share.is_none();
        let work = |net: Option<Net<'_>>, room: &mut Room| {
            let folded = if whole_cell { self.unfolded(&whole.part, net, room) } else { None };
            folded.or_else(|| self.halves(whole, net, room))
        };
        let halves = match &self.nets {
            Some(nets) => {
                let by_net = |room: &mut Room| {
                    nets.one(whole.part.cell, |net| {
                        work(Some(Net { points: net.points, sides: net.sides }), room)
                    })
                };
                by_net(room)?.flatten()
            }
            None => work(None, room),
        };
        room.sound()?;
        Ok(halves)
    }

    fn judged(&self, part: Part, net: Option<Net<'_>>, room: &mut Room) -> Judged {
        let better = if self.telling { WITH_ENDS } else { 1 };
        let [rough, fine] = [0, better].map(|rule| self.part(part, rule, net, None, room));
        let [along_u, along_v] = fine.rough_along.map(|[a, b]| a.abs() + b.abs());
        let mut across_u = along_u >= along_v;
        let mut error = (fine.area - rough.area).abs();
        if self.telling && fine.creased {
            // Both rules may be wrong by as much. What n nodes miss of a crease that runs straight across is of the order of n⁻² of the part; of
            // creases that run askew, and of many with either sign, an eighth of that is still more than was found missing.
            let nodes = self.degrees.map(|degree| degree + EXTRA[1]).into_iter().min().unwrap_or(1) as f64;
            error = error.max(fine.area / (8.0 * nodes * nodes));
            // Of one that cuts off no more than a corner the rules see nothing.
            let mean = fine.area / ((part.u.1 - part.u.0) * (part.v.1 - part.v.0));
            if along_u.max(along_v) <= UNSEEN * mean {
                across_u = part.halved[0] <= part.halved[1];
            }
        }
        Judged { part, fine: fine.area, error, across_u, order: 0, settled: false }
    }

    /// A part in two, across the direction in which it is less smooth. None where there is no number between the ends.
    fn halves(&self, whole: &Judged, net: Option<Net<'_>>, room: &mut Room) -> Option<Vec<Judged>> {
        let part = whole.part;
        if let Some((number, parts)) = part.share {
            // What loops leave of a cell is cut as a whole.
            let finer = Part { share: Some((number, 2 * parts)), ..part };
            return (parts < MOST_PARTS).then(|| vec![self.judged(finer, net, room)]);
        }
        let middle = |(a, b): (f64, f64)| {
            let middle = 0.5 * a + 0.5 * b;
            (a < middle && middle < b).then_some(middle)
        };
        let [by_u, by_v] = part.halved;
        let across_u = middle(part.u).map(|m| {
            let half = Part { halved: [by_u.saturating_add(1), by_v], ..part };
            [Part { u: (part.u.0, m), ..half }, Part { u: (m, part.u.1), ..half }]
        });
        let across_v = middle(part.v).map(|m| {
            let half = Part { halved: [by_u, by_v.saturating_add(1)], ..part };
            [Part { v: (part.v.0, m), ..half }, Part { v: (m, part.v.1), ..half }]
        });
        let halves = if whole.across_u { across_u.or(across_v) } else { across_v.or(across_u) };
        halves.map(|halves| halves.map(|half| self.judged(half, net, room)).to_vec())
    }
}

/// `work` on all of some parts, runs of them side by side; in their order.
fn in_runs<T: Sync, R: Send>(
    all: &[T],
    work: impl Fn(&T, &mut Room) -> Result<R> + Sync + Send,
) -> Result<Vec<R>> {
    let runs: Vec<&[T]> = all.chunks(RUN).collect();
    let made = parallel::map(runs.len(), |k| {
        let mut room = Room::default();
        let made = runs[k].iter().map(|one| work(one, &mut room)).collect::<Result<Vec<R>>>()?;
        room.sound()?;
        Ok(made)
    });
    let mut found = Vec::with_capacity(all.len());
    for run in made {
        found.extend(run?);
    }
    Ok(found)
}

/// How much work an area is worth.
#[derive(Clone, Copy)]
pub(super) enum Effort {
    /// It is asked for again and again while it is kept or brought to a value.
    Keeping,
    /// It is told once: more halvings, until the rules agree to this part of the whole.
    Telling(f64),
}

/// An area, and a bound (as a rule) of its error.
pub(super) struct Area {
    pub(super) area: f64,
    pub(super) error: f64,
}

/// The most points at which a look evaluates a surface: both rules on each part that can arise, and the better one again on
/// those that remain, for the gradient.
pub(super) fn points(surface: &Member<'_>, counted: &[(Cell, Share)]) -> usize {
    let nets = Nets::of(surface);
    let [p, q] = nets.map_or_else(|| surface.cells.degrees(), |nets| nets.degrees);
    let [rough, fine] = EXTRA.map(|extra| (p + extra) * (q + extra));
    let cells = match (surface.splines, nets) {
        (Some(all), _) => all.u.spans().count() * all.v.map_or(1, |v| v.spans().count()),
        (None, Some(nets)) => nets.count,
        (None, None) => counted.len(),
    };
    let halvings = halvings(cells);
    (cells + 2 * halvings) * (rough + fine) + (cells + halvings) * fine
}

/// How many halvings so many cells are allowed.
fn halvings(cells: usize) -> usize {
    HALVINGS + HALVINGS_A_CELL * cells
}
