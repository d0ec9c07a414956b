//! Breps: edges cut, faces filled, all put together.

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::brep::{Brep, Edge};
use loftsman_kernel::plugin::{Apart, Chord, Fineness, TessellatedBrep};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Error, Point, Result, Vector, parallel};

use super::arrange::{Layout, Leg, arrange};
use super::assemble::{Piece, assemble};
use super::carrier::{Carrier, Searches};
use super::cut::{Chain, Goal, Guide, ONE_PLACE, Path, Track};
use super::fill::fill;
use super::plane::{Plane, Trouble};
use crate::fineness::{Frame, targets};
use crate::surface;
use crate::weld::Welds;

/// How often edges are cut finer because chords are in each other's way.
const ROUNDS: usize = 12;
/// No more than so many times the points that edges have, and so many beside, are put on them for that: loops that cross stay crossed.
const FINER: usize = 4;
const CHORDS: usize = 20_000;
/// The part of the tolerance that is told to be worth a try where chords stay in each other's way.
const FINER_BY: f64 = 0.1;
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
        let goal = Goal { chord: target.chord, angle: target.angle, size: target.size, budget };
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
    goal: Goal,
    tolerance: f64,
    carriers: &'b [Option<Carrier>],
    /// Why faces are left out.
    troubles: BTreeMap<usize, Error>,
    chains: Vec<Option<Chain>>,
    /// The vertices that are one, because an edge between them is a point.
    vertices: Vec<u32>,
    /// The faces laid out with the edges as they are cut; none of those that are whole or left out.
    planes: Vec<Option<Result<Plane<'b>, Trouble>>>,
}

impl<'b> Cut<'b> {
    fn new(brep: &'b Brep, lines: &[Option<Line>], carried: &'b Carried, goal: Goal, tolerance: f64) -> Self {
        let mut cut = Self {
            brep,
            goal,
            tolerance,
            carriers: &carried.carriers,
            troubles: carried.troubles.clone(),
            chains: Vec::new(),
            vertices: Vec::new(),
            planes: Vec::new(),
        };
        let degenerate = cut.weld(lines);
        cut.cut_edges(lines, &degenerate);
        cut.untangle();
        cut
    }

    /// Makes vertices one between which an edge is a point; which edges are.
    fn weld(&mut self, lines: &[Option<Line>]) -> Vec<bool> {
        let count = self.brep.vertices().len();
        let mut welds = Welds::new(count);
        let least = ONE_PLACE * self.goal.size;
        let is_point = |line: &Line| {
            let Ok(part) = &line.part else { return false };
            let points = part.points();
            points.iter().all(|p| (p - points[0]).amax() <= least)
        };
        let degenerate: Vec<bool> = lines.iter().map(|line| line.as_ref().is_none_or(is_point)).collect();
        for line in
            lines.iter().zip(&degenerate).filter(|(_, point)| **point).filter_map(|(line, _)| line.as_ref())
        {
            welds.join(line.edge.ends[0], line.edge.ends[1]);
        }
        self.vertices = (0..count).map(|vertex| welds.root(vertex) as u32).collect();
        degenerate
    }

    fn cut_edges(&mut self, lines: &[Option<Line>], degenerate: &[bool]) {
        let brep = self.brep;
        let mut between: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        let ends = |edge: &Edge| {
            let [a, b] = edge.ends.map(|end| self.vertices[end]);
            [a.min(b), a.max(b)]
        };
        for (line, _) in lines.iter().zip(degenerate).filter(|(_, point)| !**point) {
            line.iter().for_each(|line| *between.entry(ends(&line.edge)).or_default() += 1);
        }
        let made = parallel::map(lines.len(), |number| -> Result<Option<Chain>> {
            let Some(line) = lines[number].as_ref().filter(|_| !degenerate[number]) else { return Ok(None) };
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
            let pair = ends(edge);
            let least = if pair[0] == pair[1] {
                3
            } else if between.get(&pair).copied().unwrap_or_default() > 1 {
                2
            } else {
                1
            };
            let points = edge.ends.map(|end| brep.vertices()[self.vertices[end] as usize]);
            let path = Path::Space { curve, ends: points };
            let tolerance =
                edge.ends.iter().map(|&end| brep.tolerances()[end]).fold(edge.tolerance, f64::max);
            let tolerance = (tolerance / self.goal.size).min(self.goal.chord);
            Chain::new(path, tracks, tolerance, least, self.carriers, &self.goal).map(Some)
        });
        for (number, chain) in made.into_iter().enumerate() {
            let chain = chain.unwrap_or_else(|error| {
                for place in brep.uses(number) {
                    let of = Error::Invalid(format!("its edge {number}: {error}"));
                    self.troubles.entry(place.face).or_insert(of);
                }
                None
            });
            self.chains.push(chain);
        }
    }

    /// The points that faces share: vertices, then those inside edges; and where those of each edge start.
    fn shared(&self) -> (Vec<Point>, Vec<u32>) {
        let mut points = self.brep.vertices().to_vec();
        let mut starts = Vec::with_capacity(self.chains.len());
        for chain in &self.chains {
            starts.push(points.len() as u32);
            if let Some(chain) = chain {
                points.extend_from_slice(chain.points.get(1..chain.points.len() - 1).unwrap_or_default());
            }
        }
        (points, starts)
    }

    /// The numbers of the points of an edge.
    fn numbers(&self, edge: usize, starts: &[u32]) -> Vec<u32> {
        let (Some(ends), Some(Some(chain))) = (self.brep.ends(edge), self.chains.get(edge)) else {
            return Vec::new();
        };
        let [first, last] = ends.map(|end| self.vertices[end]);
        let inner = (0..chain.points.len().saturating_sub(2) as u32).map(|k| starts[edge] + k);
        std::iter::once(first).chain(inner).chain(std::iter::once(last)).collect()
    }

    /// Lays out a face and joins its nodes.
    fn plane(&self, face: usize, points: &[Point], starts: &[u32]) -> Option<Result<Plane<'b>, Trouble>> {
        let carrier = self.carriers[face].as_ref()?;
        if self.troubles.contains_key(&face) {
            return None;
        }
        let mut legs = Vec::new();
        for one in self.brep.loops(face).iter().flatten() {
            let Some(Some(chain)) = self.chains.get(one.edge) else { continue };
            let Some(track) = chain.tracks.iter().find(|track| track.face == face) else { continue };
            if let Some(off) = track.lost {
                let (number, off) = (one.edge, loftsman_kernel::text::short(off * self.goal.size));
                return Some(Err(Trouble::Other(Error::Invalid(format!(
                    "its edge {number} is {off} off its surface: it lies on another one, or one of the two is wrong"
                )))));
            }
            let numbers = self.numbers(one.edge, starts);
            let of = |part: usize| {
                let (a, b) = (part, part + 1);
                let [a, b] = if one.reversed { [b, a] } else { [a, b] };
                Leg {
                    points: [numbers[a], numbers[b]],
                    ends: [track.at[a], track.at[b]],
                    edge: one.edge,
                    part,
                }
            };
            let parts = 0..track.at.len().saturating_sub(1);
            if one.reversed { legs.extend(parts.rev().map(of)) } else { legs.extend(parts.map(of)) }
        }
        let first_own = points.len() as u32;
        let mut lone = Vec::new();
        for &vertex in self.brep.lone_vertices(face) {
            let point = self.brep.vertices()[vertex];
            let snap = (self.brep.tolerances()[vertex] / self.goal.size).max(ONE_PLACE);
            match carrier.foot(&point, None, 2.0 * snap, &mut Searches::default()) {
                Ok((at, off)) if off <= 2.0 * snap => {
                    let mut at = carrier.settled(at, &carrier.framed(&point), 2.0 * snap);
                    for d in 0..2 {
                        if at[d].is_nan() {
                            at[d] = carrier.sides[d].low;
                        }
                    }
                    lone.push((at, self.vertices[vertex]));
                }
                _ => {}
            }
        }
        let layout = Layout {
            legs: &legs,
            followed: &[],
            reversed: self.brep.is_reversed(face),
            merges: false,
            first_own,
            lone: &lone,
        };
        let arranged = match arrange(carrier, &layout, &self.goal) {
            Ok(arranged) => arranged,
            Err(clash) => return Some(Err(Trouble::Clash(clash))),
        };
        let place = |number: u32| carrier.framed(&points[number as usize]);
        Some(Plane::new(carrier, &arranged, first_own, place, &self.goal))
    }

    /// Lays out the faces, and cuts edges finer where chords are in each other's way, until none are.
    fn untangle(&mut self) {
        let mut rounds = ROUNDS;
        let count =
            |chains: &[Option<Chain>]| chains.iter().flatten().map(|chain| chain.points.len()).sum::<usize>();
        let most = FINER * count(&self.chains) + CHORDS;
        loop {
            let (points, starts) = self.shared();
            self.planes = parallel::map(self.brep.face_count(), |face| self.plane(face, &points, &starts));
            if rounds == 0 || points.len() > most {
                return;
            }
            rounds -= 1;
            let mut wanted: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
            for plane in self.planes.iter().flatten() {
                let Err(Trouble::Clash(clash)) = plane else { continue };
                for (edge, part) in clash {
                    wanted.entry(*edge).or_default().insert(*part);
                }
            }
            let mut cut = false;
            for (edge, parts) in wanted {
                let Some(Some(chain)) = self.chains.get_mut(edge) else { continue };
                for part in parts.into_iter().rev() {
                    cut |= chain.halve(part, self.carriers, &self.goal).unwrap_or(false);
                }
                if chain.settle(self.carriers, &self.goal).is_err() {
                    // It will not get better: what still clashes is left out.
                    rounds = 0;
                }
            }
            if !cut {
                return;
            }
        }
    }

    /// Points inside faces, as far as they are known yet.
    fn inner_samples(&mut self) -> Vec<Point> {
        let found = parallel::map_mut(
            &mut self.planes,
            || (),
            |(), _, plane| {
                let Some(Ok(plane)) = plane else { return Vec::new() };
                let carrier = plane.carrier;
                if carrier.flat {
                    return Vec::new();
                }
                let Ok(inside) = plane.labels() else { return Vec::new() };
                let triangles = plane.triangles(&inside);
                let centre = |corners: [u32; 3]| -> Vector {
                    let at = corners.map(|k| plane.vertices[k as usize].at);
                    carrier.point([0, 1].map(|d: usize| (at[0][d] + at[1][d] + at[2][d]) / 3.0))
                };
                triangles.into_iter().map(|(corners, _)| carrier.unframed(&centre(corners))).collect()
            },
        );
        found.into_iter().flatten().collect()
    }

    /// Fills the faces and puts all together.
    fn finish(mut self, frame: &Frame, fineness: &Fineness) -> Result<TessellatedBrep> {
        let (points, starts) = self.shared();
        let first_own = points.len() as u32;
        let mut planes = std::mem::take(&mut self.planes);
        let made = parallel::map_mut(
            &mut planes,
            || (),
            |(), face, plane| -> Option<Result<Piece>> {
                let reversed = self.brep.is_reversed(face);
                if self.brep.loops(face).is_empty() {
                    let surface = self.brep.surface(face)?;
                    let fineness = Fineness { chord: Chord::Absolute(self.tolerance), ..*fineness };
                    let whole = surface::mesh(&surface, &fineness, self.goal.budget, None);
                    return Some(whole.map(|found| {
                        Piece::whole(&found.mesh, frame, reversed, first_own, found.error / self.goal.size)
                    }));
                }
                Some(match plane.take()? {
                    Ok(mut plane) => fill(&mut plane, &self.goal)
                        .and_then(|filled| Piece::new(&plane, filled, reversed, first_own)),
                    Err(Trouble::Clash(clash)) => Err(self.clash(&clash)),
                    Err(Trouble::Other(error)) => Err(error),
                })
            },
        );
        let mut pieces = Vec::new();
        for (face, piece) in made.into_iter().enumerate() {
            match piece {
                Some(Ok(piece)) => pieces.push((face, piece)),
                Some(Err(error)) => _ = self.troubles.insert(face, error),
                None => {}
            }
        }
        let left_out: Vec<(usize, Error)> = self.troubles.clone().into_iter().collect();
        if pieces.is_empty() {
            let reason = left_out.first().map(|(face, error)| format!(": face {face}: {error}"));
            return Err(Error::Invalid(format!(
                "none of its {} faces can be cut{}",
                self.brep.face_count(),
                reason.unwrap_or_default()
            )));
        }
        let count: usize = pieces.iter().map(|(_, piece)| piece.corners.len()).sum();
        if count > self.goal.budget {
            let tolerance = self.tolerance;
            return Err(Error::Invalid(format!(
                "a chord tolerance of {tolerance:e} needs {count} triangles, more than {}: choose a coarser one",
                self.goal.budget
            )));
        }
        let whole = assemble(&pieces, &points, frame)?;
        let present: BTreeSet<usize> = pieces.iter().map(|(face, _)| *face).collect();
        let mut error = pieces.iter().map(|(_, piece)| piece.error).fold(0.0, f64::max);
        let mut edges = vec![Vec::new(); self.brep.edge_count()];
        let mut furthest: Option<Apart> = None;
        for (number, out) in edges.iter_mut().enumerate() {
            if !self.brep.uses(number).iter().any(|place| present.contains(&place.face)) {
                continue;
            }
            if let Some(Some(chain)) = self.chains.get(number) {
                error = error.max(chain.bend + chain.beside + chain.off);
                if let Some(face) = chain.off_face
                    && furthest.is_none_or(|known| known.distance < chain.off * self.goal.size)
                {
                    furthest = Some(Apart { edge: number, face, distance: chain.off * self.goal.size });
                }
                let numbers = self.numbers(number, &starts).into_iter();
                *out = numbers.filter_map(|k| whole.numbers.get(k as usize).copied().flatten()).collect();
            }
        }
        Ok(TessellatedBrep {
            mesh: whole.mesh,
            faces: whole.faces,
            edges,
            left_out,
            tolerance: self.tolerance,
            error: error * self.goal.size,
            furthest,
        })
    }

    /// What is said of chords that cannot get out of each other's way.
    fn clash(&self, clash: &[(usize, usize)]) -> Error {
        let edges: BTreeSet<usize> = clash.iter().map(|(edge, _)| *edge).collect();
        let names: Vec<String> = edges.iter().map(usize::to_string).collect();
        let place = clash.first().and_then(|(edge, part)| {
            let chain = self.chains.get(*edge)?.as_ref()?;
            chain.points.get(*part).copied()
        });
        let near = place.map_or(String::new(), |p| {
            let short = loftsman_kernel::text::short;
            format!(" near ({}, {}, {})", short(p.x), short(p.y), short(p.z))
        });
        let finer = loftsman_kernel::text::short(FINER_BY * self.tolerance);
        Error::Invalid(format!(
            "its loops cross or touch at edge {}{near}: loops must keep clear of one another and of themselves; where they only come close, a tolerance of {finer} may part them",
            names.join(", ")
        ))
    }
}
