//! Trimmed surfaces: one face, whose edges are curves in its own parameters.

use loftsman_kernel::plugin::{Chord, Fineness, Tessellated};
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Surface, Trimmed};
use loftsman_kernel::{Error, Point, Result, parallel};

use super::arrange::{Arranged, Layout, Leg, arrange};
use super::assemble::{Piece, assemble};
use super::carrier::Carrier;
use super::cut::{Chain, Goal, Path, Track};
use super::fill::fill;
use super::plane::{Plane, Trouble};
use crate::fineness::{Frame, targets};
use crate::surface;

/// How often curves are cut finer because chords are in each other's way.
const ROUNDS: usize = 12;
/// How much wider than its samples a face may be before a relative tolerance is measured again.
const BEYOND: f64 = 1.02;

/// The mesh of a trimmed surface.
pub(crate) fn mesh(trimmed: &Trimmed, fineness: &Fineness, budget: usize) -> Result<Tessellated> {
    let alone = trimmed.regions().is_empty() && trimmed.curves().is_empty() && trimmed.points().is_empty();
    if alone {
        return surface::mesh(trimmed.surface(), fineness, budget, None);
    }
    let frame = Frame::of(trimmed.surface().points())?;
    let lines = Lines::of(trimmed)?;
    let mut samples = lines.samples(trimmed)?;
    for round in 0.. {
        let (targets, tolerance) = targets(std::iter::once((&frame, samples.clone())), fineness)?;
        let Some(target) = targets.first() else { break };
        let goal = Goal { chord: target.chord, angle: target.angle, size: target.size, budget, part: 1.0 };
        let size = diagonal(&samples);
        let mut cut = Cut::new(trimmed, &lines, frame, goal)?;
        let arranged = cut.untangled()?;
        let mut plane = cut.plane(&arranged).map_err(|trouble| trouble.error())?;
        if matches!(fineness.chord, Chord::Relative(_)) && round < 3 {
            let inside = plane.labels()?;
            samples.extend(plane.triangles(&inside).into_iter().map(|(corners, _)| {
                let at = corners.map(|k| plane.vertices[k as usize].at);
                let middle = [0, 1].map(|d: usize| (at[0][d] + at[1][d] + at[2][d]) / 3.0);
                plane.carrier.unframed(&plane.carrier.point(middle))
            }));
            if diagonal(&samples) > BEYOND * size {
                continue;
            }
        }
        let first_own = cut.points.len() as u32;
        let filled = fill(&mut plane, &goal)?;
        let piece = Piece::new(&plane, filled, false, first_own)?;
        let beside = cut.chains.iter().map(|chain| chain.bend + chain.beside).fold(0.0, f64::max);
        let error = piece.error.max(beside + cut.gap);
        let whole = assemble(&[(0, piece)], &cut.points, &frame)?;
        return Ok(Tessellated { mesh: whole.mesh, tolerance, error: error * goal.size });
    }
    Err(Error::Invalid("the trimmed surface has no extent".into()))
}

fn diagonal(points: &[Point]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    (high - low).norm()
}

/// The curves of a trimmed surface: those that bound it, then those to be followed, each with the numbers of its ends.
struct Lines {
    curves: Vec<loftsman_kernel::spline::Curve>,
    ends: Vec<[u32; 2]>,
    /// How many of them are borders.
    borders: usize,
    /// The places of the ends, by number.
    places: Vec<[f64; 2]>,
    /// The largest gap between curves of a loop, in parameters by direction.
    gap: [f64; 2],
}

impl Lines {
    fn of(trimmed: &Trimmed) -> Result<Self> {
        let mut lines =
            Self { curves: Vec::new(), ends: Vec::new(), borders: 0, places: Vec::new(), gap: [0.0; 2] };
        let around = around(trimmed.surface())?;
        let whole = trimmed.regions().is_empty();
        if whole || trimmed.regions().iter().any(|region| region.outer.is_empty()) {
            // The edge of the domain, but for where it closes or is a point: these have no borders.
            if around.len() == 4 {
                lines.add(&around, true)?;
            } else {
                // Each goes around, and ends where it started, a period on.
                for side in &around {
                    lines.add(std::slice::from_ref(side), true)?;
                }
                lines.gap = [0.0; 2];
            }
        }
        for chain in trimmed.loops() {
            lines.add(chain, true)?;
        }
        lines.borders = lines.curves.len();
        for chain in trimmed.curves() {
            lines.add(chain, false)?;
        }
        Ok(lines)
    }

    fn add(&mut self, chain: &[ParameterCurve], closed: bool) -> Result<()> {
        let first = self.places.len() as u32;
        let mut before: Option<[f64; 2]> = None;
        for one in chain {
            let [start, end] = one.ends()?;
            let (from, to) = one.range();
            self.curves.push(one.curve().between(from, to)?);
            match before {
                Some(before) => {
                    (0..2).for_each(|d| self.gap[d] = self.gap[d].max((before[d] - start[d]).abs()));
                }
                None => self.places.push(start),
            }
            let number = self.places.len() as u32 - 1;
            self.places.push(end);
            self.ends.push([number, number + 1]);
            before = Some(end);
        }
        if let (true, Some(last), Some(end)) = (closed, self.ends.last_mut(), before) {
            let start = self.places[first as usize];
            (0..2).for_each(|d| self.gap[d] = self.gap[d].max((end[d] - start[d]).abs()));
            last[1] = first;
            self.places.pop();
        }
        Ok(())
    }

    /// Points of the curves on the surface.
    fn samples(&self, trimmed: &Trimmed) -> Result<Vec<Point>> {
        let surface = trimmed.surface();
        let inside = |space: &loftsman_kernel::spline::Space, x: f64| {
            let (low, high) = space.domain();
            if space.is_periodic() { x } else { x.clamp(low, high) }
        };
        let mut all = Vec::new();
        for curve in &self.curves {
            let steps = 2 * curve.degree() + 2;
            for pair in curve.space().breakpoints().windows(2) {
                for k in 0..=steps {
                    let p = curve.point(pair[0] + (pair[1] - pair[0]) * (k as f64 / steps as f64))?;
                    all.push(surface.point(inside(surface.u(), p.x), inside(surface.v(), p.y))?);
                }
            }
        }
        if all.is_empty() {
            let (u, v) = (surface.u().domain(), surface.v().domain());
            for k in 0..=8 {
                for l in 0..=8 {
                    let at = |(a, b): (f64, f64), k: usize| a + (b - a) * (k as f64 / 8.0);
                    all.push(surface.point(at(u, k), at(v, l))?);
                }
            }
        }
        Ok(all)
    }
}

/// The open sides of the domain, counterclockwise.
fn around(surface: &Surface) -> Result<Vec<ParameterCurve>> {
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let corners = [[a, c], [b, c], [b, d], [a, d]];
    let mut sides = Vec::new();
    for k in 0..4 {
        let closed = if k % 2 == 0 { surface.v().is_periodic() } else { surface.u().is_periodic() };
        if !closed {
            let [from, to] = [corners[k], corners[(k + 1) % 4]].map(|[u, v]| Point::new(u, v, 0.0));
            sides.push(ParameterCurve::whole(loftsman_kernel::spline::Curve::line(from, to)?)?);
        }
    }
    Ok(sides)
}

/// A trimmed surface with its curves cut.
struct Cut {
    carriers: Vec<Option<Carrier>>,
    chains: Vec<Chain>,
    ends: Vec<[u32; 2]>,
    borders: usize,
    /// Special points.
    lone: Vec<[f64; 2]>,
    goal: Goal,
    /// What gaps between curves are in space, in the frame.
    gap: f64,
    /// The points of the whole, once it is untangled.
    points: Vec<Point>,
    places: Vec<[f64; 2]>,
}

impl Cut {
    fn new(trimmed: &Trimmed, lines: &Lines, frame: Frame, goal: Goal) -> Result<Self> {
        let carrier = Carrier::new(trimmed.surface().clone(), frame, goal.chord, None)?;
        let speeds = carrier.bounds.speeds(
            [carrier.sides[0].low, carrier.sides[1].low],
            [carrier.sides[0].high, carrier.sides[1].high],
        );
        let gap = speeds[0] * lines.gap[0] + speeds[1] * lines.gap[1];
        let carriers = vec![Some(carrier)];
        let made = parallel::map(lines.curves.len(), |k| {
            let track = Track::new(0, None);
            let [a, b] = lines.ends[k];
            let least = if a == b { 3 } else { 1 };
            Chain::new(Path::Lifted(lines.curves[k].clone()), vec![track], 0.0, least, &carriers, goal)
        });
        let chains = made.into_iter().collect::<Result<Vec<Chain>>>()?;
        Ok(Self {
            carriers,
            chains,
            ends: lines.ends.clone(),
            borders: lines.borders,
            lone: trimmed.points().to_vec(),
            goal,
            gap,
            points: Vec::new(),
            places: lines.places.clone(),
        })
    }

    /// The plane laid out, its curves cut finer until none are in each other's way.
    fn untangled(&mut self) -> Result<Arranged> {
        for round in 0..=ROUNDS {
            let clash = match self.arrange() {
                Ok(arranged) => match self.plane(&arranged) {
                    Ok(_) => return Ok(arranged),
                    Err(Trouble::Other(error)) => return Err(error),
                    Err(Trouble::Clash(clash)) => clash,
                },
                Err(clash) => clash,
            };
            let mut wanted: Vec<(usize, usize)> = clash.clone();
            wanted.sort_unstable();
            wanted.dedup();
            let mut any = false;
            for (curve, part) in wanted.into_iter().rev() {
                if let Some(chain) = self.chains.get_mut(curve) {
                    any |= chain.halve(part, &self.carriers)?;
                }
            }
            for chain in &mut self.chains {
                chain.settle(&self.carriers)?;
            }
            if !any || round == ROUNDS {
                let near = clash.first().and_then(|(curve, part)| {
                    let at = self.chains.get(*curve)?.tracks.first()?.at.get(*part)?;
                    Some(format!(" near the parameters ({}, {})", at[0], at[1]))
                });
                return Err(Error::Invalid(format!(
                    "the loops of the trimmed surface cross or touch{}: they must keep clear of one another and of themselves",
                    near.unwrap_or_default()
                )));
            }
        }
        Err(Error::Invalid("the loops of the trimmed surface cross".into()))
    }

    fn arrange(&mut self) -> Result<Arranged, super::arrange::Clash> {
        let Some(Some(carrier)) = self.carriers.first() else { return Err(Vec::new()) };
        let at = |place: [f64; 2]| {
            [0, 1].map(|d: usize| {
                let side = &carrier.sides[d];
                if side.closed { side.wrapped(place[d]) } else { place[d].clamp(side.low, side.high) }
            })
        };
        self.points = self.places.iter().map(|place| carrier.unframed(&carrier.point(at(*place)))).collect();
        let mut legs = Vec::new();
        let mut poles = [[None; 2]; 2];
        for (edge, chain) in self.chains.iter().enumerate() {
            let first = self.points.len() as u32;
            let inner = chain.points.get(1..chain.points.len() - 1).unwrap_or_default();
            self.points.extend_from_slice(inner);
            let [start, end] = self.ends[edge];
            let number = |k: usize| match k {
                0 => start,
                k if k + 1 == chain.points.len() => end,
                k => first + k as u32 - 1,
            };
            let at = &chain.tracks[0].at;
            // All that is on a pole is one point.
            let mut number = |k: usize| {
                let Some(d) = (0..2).find(|&d| at[k][d].is_nan()) else { return number(k) };
                let end = usize::from(at[k][1 - d] == carrier.sides[1 - d].high);
                *poles[1 - d][end].get_or_insert_with(|| number(k))
            };
            let mut of = |part: usize| Leg {
                points: [number(part), number(part + 1)],
                ends: [at[part], at[part + 1]],
                edge,
                part,
            };
            legs.push((0..at.len().saturating_sub(1)).map(&mut of).collect::<Vec<_>>());
        }
        let followed: Vec<Leg> = legs.split_off(self.borders).into_iter().flatten().collect();
        let legs: Vec<Leg> = legs.into_iter().flatten().collect();
        let mut lone = Vec::new();
        for place in &self.lone {
            let place = at(*place);
            lone.push((place, self.points.len() as u32));
            self.points.push(carrier.unframed(&carrier.point(place)));
        }
        let layout = Layout {
            legs: &legs,
            followed: &followed,
            reversed: false,
            merges: true,
            first_own: self.points.len() as u32,
            lone: &lone,
        };
        arrange(carrier, &layout, &self.goal)
    }

    fn plane(&self, arranged: &Arranged) -> Result<Plane<'_>, Trouble> {
        let Some(Some(carrier)) = self.carriers.first() else {
            return Err(Trouble::Other(Error::Invalid("it has no surface".into())));
        };
        let place = |number: u32| carrier.framed(&self.points[number as usize]);
        Plane::new(carrier, arranged, self.points.len() as u32, place, &self.goal)
    }
}
