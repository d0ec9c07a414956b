//! Breps: edges cut, faces filled, all put together.

mod finer;
mod finish;
mod lay;
mod untangle;

use std::collections::BTreeMap;

use loftsman_kernel::brep::{Brep, Edge};
use loftsman_kernel::plugin::{Chord, Fineness, TessellatedBrep};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Error, Point, Result, parallel};

use self::lay::Laid;
use super::carrier::Carrier;
use super::cut::{Chain, Goal, Guide, ONE_PLACE, Path, Track};
use crate::fineness::{Frame, targets};
use crate::weld::Welds;

/// How often a relative tolerance is measured.
const ROUNDS_OF_SIZE: usize = 4;
/// By how much more than its edges a Brep may extend before a relative tolerance is measured again.
const BEYOND: f64 = 1.02;

/// The mesh of a Brep.
pub(crate) fn mesh(brep: &Brep, fineness: &Fineness, budget: usize) -> Result<TessellatedBrep> {
    if brep.face_count() == 0 {
        return Err(Error::NoExtent("it has no faces".into()));
    }
    let frame = Frame::of(brep.points())?;
    let lines = parallel::map(brep.edge_count(), |number| Line::of(brep, number));
    let relative = matches!(fineness.chord, Chord::Relative(_));
    let mut samples = if relative { samples(brep)? } else { Vec::new() };
    for round in 0..ROUNDS_OF_SIZE {
        let (targets, tolerance) = targets(std::iter::once((&frame, samples.clone())), fineness)?;
        let Some(target) = targets.first() else { break };
        let goal = Goal { chord: target.chord, angle: target.angle, size: target.size, budget, part: 1.0 };
        let carried = Carried::new(brep, &lines, frame, &goal);
        let mut cut = Cut::new(brep, &lines, &carried, goal, tolerance);
        if relative && round + 1 < ROUNDS_OF_SIZE {
            let size = diagonal(&samples);
            samples.extend(cut.inner_samples());
            if diagonal(&samples) > BEYOND * size {
                continue;
            }
        }
        return cut.finish(&frame, fineness);
    }
    Err(Error::Invalid("it has no extent".into()))
}

/// An edge, and its curve between its ends.
struct Line {
    edge: Edge,
    part: Result<Curve>,
}

impl Line {
    fn of(brep: &Brep, number: usize) -> Option<Self> {
        let edge = brep.edge(number)?;
        let part = edge.curve.between(edge.range.0, edge.range.1);
        Some(Self { edge, part })
    }
}

fn diagonal(points: &[Point]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// Points of the Brep: of its edges, and of faces that are whole surfaces.
fn samples(brep: &Brep) -> Result<Vec<Point>> {
    let of_edge = |number: usize| -> Result<Vec<Point>> {
        let Some(edge) = brep.edge(number) else { return Ok(Vec::new()) };
        let curve = edge.curve.between(edge.range.0, edge.range.1)?;
        let breaks = curve.space().breakpoints();
        let steps = 2 * curve.degree() + 2;
        let mut points = Vec::new();
        for pair in breaks.windows(2) {
            for k in 0..=steps {
                points.push(curve.point(pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64))?);
            }
        }
        Ok(points)
    };
    let mut all = Vec::new();
    for points in parallel::map(brep.edge_count(), of_edge) {
        all.extend(points?);
    }
    for face in (0..brep.face_count()).filter(|&face| brep.loops(face).is_empty()) {
        let Some(surface) = brep.surface(face) else { continue };
        let places = |space: &loftsman_kernel::spline::Space| -> Vec<f64> {
            let breaks = space.breakpoints();
            breaks
                .windows(2)
                .flat_map(|b| [0.0, 0.25, 0.5, 0.75, 1.0].map(|t| b[0] + (b[1] - b[0]) * t))
                .collect()
        };
        let across = places(surface.v());
        for u in places(surface.u()) {
            for &v in &across {
                all.push(surface.point(u, v)?);
            }
        }
    }
    Ok(all)
}

/// The surfaces of the faces, prepared.
struct Carried {
    carriers: Vec<Option<Carrier>>,
    /// Why faces are left out.
    troubles: BTreeMap<usize, Error>,
}

impl Carried {
    fn new(brep: &Brep, lines: &[Option<Line>], frame: Frame, goal: &Goal) -> Self {
        let made = parallel::map(brep.face_count(), |face| {
            if brep.loops(face).is_empty() {
                return None;
            }
            let uses = brep.loops(face).iter().flatten();
            let tolerances =
                uses.filter_map(|one| lines.get(one.edge)?.as_ref()).map(|line| line.edge.tolerance);
            let widest = tolerances.fold(0.0, f64::max) / goal.size;
            let one = widest.min(0.1 * goal.chord);
            let surface = brep.surface(face)?;
            Some(Carrier::new(surface, frame, goal.chord, Some(one)))
        });
        let (mut carriers, mut troubles) = (Vec::with_capacity(made.len()), BTreeMap::new());
        for (face, carrier) in made.into_iter().enumerate() {
            carriers.push(match carrier {
                Some(Ok(carrier)) => Some(carrier),
                Some(Err(error)) => {
                    troubles.insert(face, error);
                    None
                }
                None => None,
            });
        }
        Self { carriers, troubles }
    }
}

/// A Brep with its edges cut and its faces laid out.
struct Cut<'b> {
    brep: &'b Brep,
    lines: &'b [Option<Line>],
    goal: Goal,
    tolerance: f64,
    carriers: &'b [Option<Carrier>],
    /// Why faces are left out.
    troubles: BTreeMap<usize, Error>,
    chains: Vec<Option<Chain>>,
    /// The vertices that are one, because an edge between them is a point.
    vertices: Vec<u32>,
    /// How many chords each edge has at least; of one that is a point it has none.
    least: Vec<Option<usize>>,
    /// The faces laid out with the edges as they are cut; none of those that are whole or left out.
    planes: Vec<Option<Laid<'b>>>,
}

impl<'b> Cut<'b> {
    fn new(
        brep: &'b Brep,
        lines: &'b [Option<Line>],
        carried: &'b Carried,
        goal: Goal,
        tolerance: f64,
    ) -> Self {
        let mut cut = Self {
            brep,
            lines,
            goal,
            tolerance,
            carriers: &carried.carriers,
            troubles: carried.troubles.clone(),
            chains: Vec::new(),
            vertices: Vec::new(),
            least: Vec::new(),
            planes: Vec::new(),
        };
        cut.weld();
        cut.cut_edges();
        cut.planes.resize_with(brep.face_count(), || None);
        cut.untangle_all();
        cut.cut_finer();
        cut
    }

    /// Makes vertices one between which an edge is a point, and finds how many chords all other edges have at least.
    fn weld(&mut self) {
        let count = self.brep.vertices().len();
        let mut welds = Welds::new(count);
        let least = ONE_PLACE * self.goal.size;
        let is_point = |line: &Line| {
            let Ok(part) = &line.part else { return false };
            let points = part.points();
            points.iter().all(|p| (p - points[0]).amax() <= least)
        };
        let degenerate: Vec<bool> =
            self.lines.iter().map(|line| line.as_ref().is_none_or(is_point)).collect();
        let all = || self.lines.iter().zip(&degenerate);
        for line in all().filter(|(_, point)| **point).filter_map(|(line, _)| line.as_ref()) {
            welds.join(line.edge.ends[0], line.edge.ends[1]);
        }
        self.vertices = (0..count).map(|vertex| welds.root(vertex) as u32).collect();
        let ends = |line: &Line| {
            let [a, b] = line.edge.ends.map(|end| self.vertices[end]);
            [a.min(b), a.max(b)]
        };
        let mut between: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for line in all().filter(|(_, point)| !**point).filter_map(|(line, _)| line.as_ref()) {
            *between.entry(ends(line)).or_default() += 1;
        }
        let least = |line: &Line| {
            let pair = ends(line);
            if pair[0] == pair[1] {
                3
            } else if between.get(&pair).copied().unwrap_or_default() > 1 {
                2
            } else {
                1
            }
        };
        self.least = all().map(|(line, point)| line.as_ref().filter(|_| !point).map(least)).collect();
    }

    /// Cuts an edge; none of one that is a point, or that no face has.
    ///
    /// # Errors
    /// When its curve cannot be cut.
    fn chain(&self, number: usize, goal: Goal) -> Result<Option<Chain>> {
        let brep = self.brep;
        let (Some(line), Some(least)) = (self.lines[number].as_ref(), self.least[number]) else {
            return Ok(None);
        };
        let edge = &line.edge;
        let uses = brep.uses(number);
        if uses.is_empty() {
            return Ok(None);
        }
        let mut tracks: Vec<Track> = Vec::new();
        for place in uses {
            if tracks.iter().any(|track| track.face == place.face) {
                continue;
            }
            let one = &brep.loops(place.face)[place.chain][place.number];
            let guide = one.parameters.as_ref();
            let guide = guide.map(|g| Guide { curve: g.curve().clone(), range: g.range() });
            tracks.push(Track::new(place.face, guide));
        }
        let curve = line.part.clone()?;
        let points = edge.ends.map(|end| brep.vertices()[self.vertices[end] as usize]);
        let path = Path::Space { curve, ends: points };
        let tolerance = edge.ends.iter().map(|&end| brep.tolerances()[end]).fold(edge.tolerance, f64::max);
        let tolerance = (tolerance / goal.size).min(goal.chord);
        Chain::new(path, tracks, tolerance, least, self.carriers, goal).map(Some)
    }

    fn cut_edges(&mut self) {
        let made = parallel::map(self.lines.len(), |number| self.chain(number, self.goal));
        for (number, chain) in made.into_iter().enumerate() {
            let chain = chain.unwrap_or_else(|error| {
                for place in self.brep.uses(number) {
                    let of = Error::Invalid(format!("its edge {number}: {error}"));
                    self.troubles.entry(place.face).or_insert(of);
                }
                None
            });
            self.chains.push(chain);
        }
    }
}
