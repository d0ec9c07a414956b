//! Curves with curves and surfaces: the search, and what is made of what it found.

use loftsman_kernel::Point;
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::spline::{Curve, Space, Surface};

use crate::contact::{Judge, Met};
use crate::error::{IntersectionError, Result};
use crate::intersections::{Contact, Intersections, Meeting, Options, Overlap, Undecided};
use crate::net::Frame;
use crate::pieces::Pieces;
use crate::search::{Found, Search};
use crate::together::Run;

/// Crossings that are further apart than this part of the size are not too near to tell apart: between them the shapes would be as straight as
/// lines that cross once.
const LENS: f64 = 1e-2;

/// Runs no further apart than this part of the domain are looked at whether they are one.
const FOLLOWS: f64 = 1e-6;
/// Runs no further apart than this part of the domain are looked at whether they go on into one another, at so many places between them.
const SHORT: f64 = 0.05;
const PLACES: u32 = 16;

/// Where two curves meet, in space or in a plane: all points no further apart than the tolerance, and the parts that run
/// together.
///
/// Bézier pieces whose boxes are near (by a tree over each curve) are cut until they are apart, or their derivatives show
/// that they meet once at most, which Newton's method then settles to rounding. Touching ones, which never show that, are told
/// by the tolerance. `O((n + m) log)` for the trees, then what comes near.
///
/// ```
/// use loftsman_intersection::{Contact, Options, curves};
/// use loftsman_kernel::{Point, Vector, spline::Curve};
/// let ring = Curve::circle(Point::origin(), Vector::z(), 1.0)?;
/// let line = Curve::line(Point::new(-2.0, 0.6, 0.0), Point::new(2.0, 0.6, 0.0))?;
/// let found = curves(&line, &ring, &Options::default())?;
/// assert_eq!(found.meetings.len(), 2);
/// assert!((found.meetings[0].point.x + 0.8).abs() < 1e-14);
/// assert!(found.is_complete() && found.meetings[0].contact == Contact::Crossing);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the tolerance is no length, or the shapes are too large for numbers.
pub fn curves(a: &Curve, b: &Curve, options: &Options) -> Result<Intersections> {
    let (frame, tolerance) = setting(&[a.hull_bounds(), b.hull_bounds()], options)?;
    let inner = tolerance / frame.size;
    let search = Search::new(&Pieces::of_curve(a, &frame)?, &Pieces::of_curve(b, &frame)?, inner);
    Answer { a, b, spaces: [Some(a.space()), Some(b.space()), None], frame, tolerance, both: Location::Curve }
        .of(search)
}

/// Where a curve meets a surface: as [`curves`].
///
/// # Errors
/// As for [`curves`].
pub fn curve_surface(curve: &Curve, surface: &Surface, options: &Options) -> Result<Intersections> {
    let (frame, tolerance) = setting(&[curve.hull_bounds(), surface.hull_bounds()], options)?;
    let inner = tolerance / frame.size;
    let search = Search::new(&Pieces::of_curve(curve, &frame)?, &Pieces::of_surface(surface, &frame)?, inner);
    let spaces = [Some(curve.space()), Some(surface.u()), Some(surface.v())];
    Answer { a: curve, b: surface, spaces, frame, tolerance, both: |u| Location::Surface(u, 0.0) }.of(search)
}

/// The frame of shapes with these boxes, and the tolerance.
pub(crate) fn setting(boxes: &[(Point, Point)], options: &Options) -> Result<(Frame, f64)> {
    let frame = Frame::around(boxes).ok_or(IntersectionError::TooLarge)?;
    // Nothing is nearer than the rounding of its coordinates.
    let rounding = 16.0 * f64::EPSILON * (frame.center.coords.amax() + frame.size);
    let tolerance = match options.tolerance {
        Some(t) if !(t.is_finite() && t > 0.0) => return Err(IntersectionError::Tolerance(t)),
        Some(t) => t,
        None => 1e-9 * frame.size,
    };
    Ok((frame, tolerance.max(rounding)))
}

pub(crate) struct Answer<'a, B> {
    pub(crate) a: &'a Curve,
    pub(crate) b: &'a B,
    pub(crate) spaces: [Option<&'a Space>; 3],
    pub(crate) frame: Frame,
    pub(crate) tolerance: f64,
    /// Tells curves from surfaces.
    pub(crate) both: fn(f64) -> Location,
}

impl<B: Met> Answer<'_, B> {
    fn location(&self, at: &[f64; 3]) -> Location {
        match (self.both)(at[1]) {
            Location::Surface(u, _) => Location::Surface(u, at[2]),
            other => other,
        }
    }

    /// How far apart the shapes are at these parameters, and the curve's point.
    fn measure(&self, at: &[f64; 3]) -> Result<(Point, f64)> {
        let p = self.a.point(at[0])?;
        let q = Point::from(self.b.value(self.location(at), Derivative::POSITION)?);
        Ok((p, (p - q).norm()))
    }

    /// Whether all between two places is as near as places are: they are one then, as far as the tolerance tells.
    fn one(&self, x: &[f64; 3], y: &[f64; 3], reach: f64) -> Result<bool> {
        let (y_own, mut y) = (*y, *y);
        for k in 0..3 {
            // The shorter way around: where a direction is not closed, the points on it are not near.
            let Some(space) = self.spaces[k] else { continue };
            let length = space.length();
            if (y[k] - x[k]).abs() > 0.5 * length {
                y[k] += if y[k] < x[k] { length } else { -length };
            }
            // At a pole one point has all parameters of the other shape.
            if k == 0 && (y[k] - x[k]).abs() > 0.05 * length {
                return Ok(false);
            }
        }
        let pole = self.b.stands(self.location(x))? || self.b.stands(self.location(&y_own))?;
        for step in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let mut at = [0.0; 3];
            for k in 0..3 {
                at[k] = x[k] + (y[k] - x[k]) * step;
                if let Some(space) = self.spaces[k] {
                    let (low, high) = space.domain();
                    if at[k] < low {
                        at[k] += high - low;
                    } else if at[k] > high {
                        at[k] -= high - low;
                    }
                    at[k] = at[k].clamp(low, high);
                }
            }
            // Through a pole its parameters lead another way than the curve.
            if self.measure(&at)?.1 > reach && !(pole && self.b.off(&self.a.point(at[0])?)? <= reach) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The touching that two crossings are which are too near to tell apart: halfway.
    fn between(&self, x: &Found, y: &Found) -> Result<Found> {
        let mut found = Found { simple: false, own: false, ..*x };
        let wraps = (0..3)
            .any(|k| self.spaces[k].is_some_and(|space| (x.at[k] - y.at[k]).abs() > 0.5 * space.length()));
        if !wraps {
            let at = [0, 1, 2].map(|k| 0.5 * x.at[k] + 0.5 * y.at[k]);
            let distance = self.measure(&at)?.1;
            if distance <= self.tolerance {
                found = Found { at, distance: distance / self.frame.size, ..found };
            }
        }
        Ok(found)
    }

    pub(crate) fn of(&self, search: Search) -> Result<Intersections> {
        let near = 4.0 * self.tolerance;
        let runs = self.joined(search.runs.clone())?;
        let mut kept: Vec<Found> = Vec::new();
        let mut found = search.found;
        found.sort_by(|x, y| x.distance.total_cmp(&y.distance).then(x.at[0].total_cmp(&y.at[0])));
        'next: for place in found {
            for run in search.runs.iter().chain(&runs) {
                if self.on_run(&place.at, run) {
                    continue 'next;
                }
                if self.beside(&place.at, run, near)? {
                    continue 'next;
                }
            }
            for other in &mut kept {
                if self.same(&place.at, &other.at) {
                    continue 'next;
                }
                let both = place.own && other.own;
                // Two that were shown to be there are one where all between them is as near; looked at where that can be.
                let looked = !both || (place.point - other.point).norm() <= LENS;
                if looked && self.one(&place.at, &other.at, near)? {
                    // What is one with another place is not the only one around.
                    other.own = false;
                    if place.simple && other.simple {
                        *other = self.between(other, &place)?;
                    }
                    continue 'next;
                }
            }
            kept.push(place);
        }
        kept.sort_by(|x, y| {
            x.at[0].total_cmp(&y.at[0]).then(x.at[1].total_cmp(&y.at[1])).then(x.at[2].total_cmp(&y.at[2]))
        });
        let mut answer = Intersections { tolerance: self.tolerance, ..Intersections::default() };
        for place in kept {
            let (mut point, mut distance) = self.measure(&place.at)?;
            if distance > 2.0 * self.tolerance {
                // At a torn knot a parameter is a place of the piece after it: this one is on the piece before.
                point = self.frame.center + place.point * self.frame.size;
                distance = place.distance * self.frame.size;
            }
            let location = self.location(&place.at);
            // What was shown to be the only one around, away from the ends of pieces, crosses.
            let contact = if place.own {
                Contact::Crossing
            } else {
                self.b.contact(&Judge::new(self.tolerance, place.simple), self.a, place.at[0], location)?
            };
            let mut meeting = Meeting { at: place.at[0], with: Some(location), point, distance, contact };
            if contact == Contact::Touching
                && let Some((at, with)) = self.b.level(self.a, place.at[0], location)?
            {
                let (point, other) = (self.a.point(at)?, self.b.value(with, Derivative::POSITION)?);
                let distance = (point.coords - other).norm();
                if distance <= self.tolerance {
                    meeting = Meeting { at, with: Some(with), point, distance, ..meeting };
                }
            }
            answer.meetings.push(meeting);
        }
        for run in &runs {
            let (from, to) = (self.measure(&run.from)?.0, self.measure(&run.to)?.0);
            answer.overlaps.push(Overlap {
                range: (run.from[0], run.to[0]),
                with: Some([self.location(&run.from), self.location(&run.to)]),
                points: [from, to],
                distance: run.distance * self.frame.size,
            });
        }
        for (low, high, near) in search.undecided {
            let near = self.frame.center + near * self.frame.size;
            match answer.undecided.last_mut() {
                Some(last) if last.range.1 >= low && last.range.0 <= high => {
                    last.range = (last.range.0.min(low), last.range.1.max(high));
                }
                _ => answer.undecided.push(Undecided { range: (low, high), near }),
            }
        }
        Ok(answer)
    }

    /// Whether all between a place and the nearer end of a run is as near as places are.
    fn beside(&self, at: &[f64; 3], run: &Run, reach: f64) -> Result<bool> {
        let slack = 1e-3 * (run.to[0] - run.from[0]);
        let length = self.a.space().length();
        // The end of a closed curve is where it starts.
        for t in [at[0], at[0] - length, at[0] + length] {
            if t >= run.from[0] - slack && t <= run.to[0] + slack {
                let end = if (t - run.from[0]).abs() < (t - run.to[0]).abs() { &run.from } else { &run.to };
                if self.one(at, end, reach)? {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Whether two places have the same parameters, to rounding.
    fn same(&self, x: &[f64; 3], y: &[f64; 3]) -> bool {
        (0..3).all(|k| {
            self.spaces[k].is_none_or(|space| {
                let apart = (x[k] - y[k]).abs();
                let length = space.length();
                apart <= 1e-12 * length || space.is_periodic() && apart >= (1.0 - 1e-12) * length
            })
        })
    }

    /// Whether a place is between two places of a run, in all parameters.
    fn on_run(&self, at: &[f64; 3], run: &Run) -> bool {
        self.on(at, &run.places)
    }

    fn on(&self, at: &[f64; 3], places: &[[f64; 3]]) -> bool {
        places.windows(2).any(|pair| {
            at[0] >= pair[0][0]
                && at[0] <= pair[1][0]
                && (1..3).all(|k| {
                    let Some(space) = self.spaces[k] else { return true };
                    let (low, high) = (pair[0][k].min(pair[1][k]), pair[0][k].max(pair[1][k]));
                    // As much again to either side, for it need not run evenly.
                    let room = (high - low) + 1e-9 * space.length();
                    at[k] >= low - room && at[k] <= high + room
                })
        })
    }

    /// Runs end to end, and what is found twice or lies within another, as one.
    fn joined(&self, mut runs: Vec<Run>) -> Result<Vec<Run>> {
        runs.sort_by(|x, y| x.from[0].total_cmp(&y.from[0]).then(y.to[0].total_cmp(&x.to[0])));
        let mut joined: Vec<Run> = Vec::new();
        for run in runs {
            let mut taken = false;
            for before in &mut joined {
                // Each reaches beyond its end by as much as the tolerance allows.
                let gap = run.from[0] - before.to[0];
                let follows = gap.abs() <= FOLLOWS * self.a.space().length()
                    && self.one(&before.to, &run.from, 4.0 * self.tolerance)?
                    || self.goes_on(&before.to, &run.from)?;
                if follows
                    || self.along(&run, before)
                    || self.along(before, &run)
                    || self.round_a_seam(&run, before)?
                {
                    before.places.extend(run.places.iter().filter(|place| place[0] > before.to[0]));
                    if run.to[0] > before.to[0] {
                        before.to = run.to;
                    }
                    before.distance = before.distance.max(run.distance);
                    taken = true;
                    break;
                }
            }
            if !taken {
                joined.push(run);
            }
        }
        Ok(joined)
    }

    /// Whether the shapes stay together from where one run ends to where another starts: a short way, along both, and all of it within the tolerance.
    fn goes_on(&self, end: &[f64; 3], start: &[f64; 3]) -> Result<bool> {
        let gap = start[0] - end[0];
        // A curve is on itself everywhere.
        let itself =
            std::ptr::eq(std::ptr::from_ref(self.a).cast::<()>(), std::ptr::from_ref(self.b).cast::<()>());
        if itself || gap.abs() > SHORT * self.a.space().length() {
            return Ok(false);
        }
        // Back from the end only as far as the tolerance reaches: what runs along a curve that turns back does so twice.
        if gap < 0.0 && (self.a.point(start[0])? - self.a.point(end[0])?).norm() > 4.0 * self.tolerance {
            return Ok(false);
        }
        for k in 0..=PLACES {
            let share = f64::from(k) / f64::from(PLACES);
            let at = [0, 1, 2].map(|k| end[k] + (start[k] - end[k]) * share);
            let (point, beside) = self.measure(&at)?;
            if beside > LENS * self.frame.size || self.b.off(&point)? > self.tolerance {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a run within the range of another is the same one on the other side of a seam of the other shape: where it starts and ends and between, both are at one place
    /// whatever their parameters.
    fn round_a_seam(&self, run: &Run, other: &Run) -> Result<bool> {
        let reach = 1e-9 * self.a.space().length();
        if run.from[0] < other.from[0] - reach || run.to[0] > other.to[0] + reach || run.places.is_empty() {
            return Ok(false);
        }
        for place in [0, run.places.len() / 2, run.places.len() - 1].map(|k| &run.places[k]) {
            let next =
                other.places.partition_point(|p| p[0] < place[0]).clamp(1, other.places.len().max(2) - 1);
            let Some([before, after]) = other.places.get(next - 1..=next) else { return Ok(false) };
            let way = after[0] - before[0];
            let share = if way > 0.0 { ((place[0] - before[0]) / way).clamp(0.0, 1.0) } else { 0.0 };
            let beside = [0, 1, 2].map(|k| before[k] + (after[k] - before[k]) * share);
            if !self.one(&beside, place, 4.0 * self.tolerance)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether all places of a run where another has places, too, are on that: both go the same way on the other shape, as they do not where that
    /// turns back.
    fn along(&self, run: &Run, other: &Run) -> bool {
        let reach = 1e-9 * self.a.space().length();
        let (from, to) = (other.from[0] + reach, other.to[0] - reach);
        let first = run.places.partition_point(|place| place[0] <= from);
        let mut beside = run.places[first..].iter().take_while(|place| place[0] < to).peekable();
        beside.peek().is_some()
            && beside.all(|place| {
                // The places of the other that are beside it.
                let next = other.places.partition_point(|p| p[0] < place[0]);
                let some = &other.places[next.saturating_sub(2)..(next + 2).min(other.places.len())];
                self.on(place, some)
            })
    }
}
