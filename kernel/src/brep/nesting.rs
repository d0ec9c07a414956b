//! Loops that should lie in one another and lie beside one another, or run the wrong way.

use super::{Brep, Frame, SurfaceForm, Use};
use crate::error::Result;
use crate::spline::{ParameterSide, Surface};
use crate::text::figure;
use crate::{Point, Vector};

/// Places of each knot span of an edge at which a loop is looked at.
const PLACES: usize = 16;
/// A place further from the surface than this part of the size of its control net is none of it: its loop cannot be judged.
const OFF: f64 = 1e-2;
/// Places nearer to a pole than this part of the domain have no parameter along it.
const POLE: f64 = 1e-6;

/// A loop in the parameter plane: its places, each as near to the one before it as it can be.
struct Laid {
    places: Vec<[f64; 2]>,
    /// How often it goes around each direction that closes.
    turns: [i64; 2],
    /// The area that it goes around in space, as seen from where that is largest.
    area: f64,
}

/// What is wrong with the loops of a face: with the area, in space, that a loop goes around, as seen from where that is largest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoopFlaw {
    /// A loop lies outside of what the others bound: no hole of that.
    Outside(f64),
    /// A loop lies partly outside of what the others bound: the two cross.
    Across(f64),
    /// A loop lies within a hole.
    InHole(f64),
    /// The outer loop runs clockwise about the normal of the face, so that material would be on its other side.
    Clockwise(f64),
    /// A hole runs the way of the outer loop.
    Along(f64),
}

impl LoopFlaw {
    /// The area that the loop goes around.
    pub fn area(&self) -> f64 {
        let (Self::Outside(area)
        | Self::Across(area)
        | Self::InHole(area)
        | Self::Clockwise(area)
        | Self::Along(area)) = self;
        *area
    }
}

impl Brep {
    /// What is wrong with how the loops of a face lie and run. On a plane, and on any surface with a border, one loop goes around all others, counterclockwise about
    /// the normal of the face, and the others clockwise, none within another; on one that goes on where its parameters end (a
    /// cylinder, a torus) two that go around it bound what is between them, and all others lie in there; on a surface without any
    /// border none need lie in another. Empty where all is well, and where a loop is too far off the surface to be judged.
    ///
    /// 16 places of each knot span of the edges, and on other surfaces than planes a step downhill for each; none for a face with a single loop that is no
    /// plane. `O(n log n)` in the loops but for those that are beside one another along `u`.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn loop_flaws(&self, face: usize) -> Result<Vec<LoopFlaw>> {
        let loops = self.loops(face);
        let plane = match self.surface_form(face) {
            SurfaceForm::Plane { frame } => Some(frame),
            _ => None,
        };
        if loops.len() < if plane.is_some() { 1 } else { 2 } {
            return Ok(Vec::new());
        }
        let Some(surface) = self.surface(face) else { return Ok(Vec::new()) };
        let size = surface.points().iter().map(|p| (p - surface.points()[0]).norm()).fold(0.0, f64::max);
        let sides = surface.parameter_sides(1e-6 * size)?;
        let mut all = Vec::with_capacity(loops.len());
        for chain in loops {
            let points = self.points_of_loop(chain)?;
            let laid = match &plane {
                Some(frame) => Some(on_plane(frame, &points)),
                None => on_surface(&surface, &sides, &points, OFF * size)?,
            };
            let Some(laid) = laid else { return Ok(Vec::new()) };
            all.push(laid);
        }
        let goes_on = |d: usize| sides[d].closed || sides[d].poles == [true; 2];
        let without_border = plane.is_none() && goes_on(0) && goes_on(1);
        let sense = if self.is_reversed(face) { -1.0 } else { 1.0 };
        Ok(flaws(&all, if plane.is_some() { None } else { Some(&sides) }, without_border, sense))
    }

    /// [`loop_flaws`](Self::loop_flaws) in words, for what a reader says of a face; which way its loops run only where the format says how they should.
    ///
    /// # Errors
    /// As for [`loop_flaws`](Self::loop_flaws).
    pub fn loops_told(&self, face: usize, oriented: bool) -> Result<Option<String>> {
        let flaws = self.loop_flaws(face)?;
        let curved = !matches!(self.surface_form(face), SurfaceForm::Plane { .. });
        let what = if curved { "what the others bound" } else { "the largest" };
        let areas = |kind: fn(f64) -> LoopFlaw| -> Vec<f64> {
            flaws.iter().filter(|flaw| **flaw == kind(flaw.area())).map(LoopFlaw::area).collect()
        };
        let told = [
            told(
                &areas(LoopFlaw::Outside),
                &format!("outside {what}: no hole of that, it is kept as a part of the face"),
                &format!("outside {what}: no holes of that, they are kept as parts of the face"),
            ),
            told(
                &areas(LoopFlaw::Across),
                &format!("partly outside {what}: it crosses that, and what the face is cannot be said"),
                &format!("partly outside {what}: they cross that, and what the face is cannot be said"),
            ),
            told(
                &areas(LoopFlaw::InHole),
                "within a hole: it is kept as an island there, a part of the face",
                "within holes: they are kept as islands there, parts of the face",
            ),
        ];
        let mut told: Vec<String> = told.into_iter().flatten().collect();
        if oriented {
            if !areas(LoopFlaw::Clockwise).is_empty() {
                told.push("its outer loop runs clockwise about its normal: sense and bounds contradict each other, and what faces outwards there, and a volume, may be wrong".to_owned());
            }
            match areas(LoopFlaw::Along).len() {
                0 => {}
                1 => {
                    told.push("a hole of it runs the way of its outer loop: it is kept as a hole".to_owned());
                }
                more => told.push(format!(
                    "{more} holes of it run the way of its outer loop: they are kept as holes"
                )),
            }
        }
        Ok((!told.is_empty()).then(|| told.join("; ")))
    }

    fn points_of_loop(&self, chain: &[Use]) -> Result<Vec<Point>> {
        let mut points = Vec::new();
        for one in chain {
            let Some(edge) = self.edge(one.edge) else { continue };
            let (from, to) = edge.range;
            let steps = PLACES * edge.curve.space().breakpoints().len().saturating_sub(1).max(1);
            for k in 0..steps {
                let share = k as f64 / steps as f64;
                let share = if one.reversed { 1.0 - share } else { share };
                points.push(edge.curve.point(from + (to - from) * share)?);
            }
        }
        Ok(points)
    }
}

fn area_in_space(points: &[Point]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let sum: Vector = points.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first))).sum();
    0.5 * sum.norm()
}

fn on_plane(frame: &Frame, points: &[Point]) -> Laid {
    let places =
        points.iter().map(|p| p - frame.origin).map(|away| [away.dot(&frame.x), away.dot(&frame.y())]);
    Laid { places: places.collect(), turns: [0; 2], area: area_in_space(points) }
}

/// The loop in the parameters of a surface; `None` where it is not on that.
fn on_surface(
    surface: &Surface,
    sides: &[ParameterSide; 2],
    points: &[Point],
    off: f64,
) -> Result<Option<Laid>> {
    let mut places: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    let mut last: Option<(f64, f64)> = None;
    for point in points {
        let mut foot = match last {
            Some(start) => Some(surface.foot(*point, start)?),
            None => None,
        };
        if foot.as_ref().is_none_or(|foot| foot.distance > off) {
            let closest = surface.closest(*point)?;
            if closest.distance > off {
                return Ok(None);
            }
            foot = Some(surface.foot(*point, closest.at)?);
        }
        let Some(foot) = foot else { return Ok(None) };
        let at = [sides[0].wrapped(foot.at.0), sides[1].wrapped(foot.at.1)];
        // Where the loop crosses a border at which the surface goes on the search stops there, and is made anew all over once that is too far off.
        last = Some((at[0], at[1]));
        let is_pole = (0..2).any(|d| {
            let near = POLE * sides[d].length();
            (sides[d].poles[0] && at[d] - sides[d].low <= near)
                || (sides[d].poles[1] && sides[d].high - at[d] <= near)
        });
        if is_pole {
            continue;
        }
        places.push(match places.last() {
            Some(before) => [0, 1].map(|d: usize| sides[d].unwrapped(at[d], before[d])),
            None => at,
        });
    }
    let (Some(first), Some(end)) = (places.first(), places.last()) else { return Ok(None) };
    let turns = [0, 1].map(|d: usize| {
        if !sides[d].closed {
            return 0;
        }
        let back = sides[d].unwrapped(first[d], end[d]) - first[d];
        (back / sides[d].length()).round() as i64
    });
    Ok(Some(Laid { places, turns, area: area_in_space(points) }))
}

/// One kind of flaw in words, after the areas of the loops that have it.
fn told(areas: &[f64], one: &str, more: &str) -> Option<String> {
    /// So many areas are told.
    const NAMED: usize = 4;
    let named: Vec<String> = areas.iter().take(NAMED).map(|&area| figure(area)).collect();
    let others = if areas.len() > NAMED { ", …" } else { "" };
    match areas.len() {
        0 => None,
        1 => Some(format!("a loop of it, around an area of {}, lies {one}", named.join(""))),
        count => {
            Some(format!("{count} loops of it, around areas of {}{others}, lie {more}", named.join(", ")))
        }
    }
}

/// What is wrong with loops. `sense` is -1 where the normal of the face is against that of its surface.
fn flaws(
    all: &[Laid],
    sides: Option<&[ParameterSide; 2]>,
    without_border: bool,
    sense: f64,
) -> Vec<LoopFlaw> {
    let (around, plain): (Vec<&Laid>, Vec<&Laid>) = all.iter().partition(|laid| laid.turns != [0; 2]);
    if around.is_empty() {
        return if without_border { Vec::new() } else { one_around_all(&plain, sides, sense) };
    }
    // Two that go once around one direction, against each other, bound a band; of anything else the orientation alone says what is inside.
    let (Some(sides), [one, other]) = (sides, &around[..]) else { return Vec::new() };
    let Some(along) = (0..2).find(|&d| {
        one.turns[d].abs() == 1
            && one.turns[1 - d] == 0
            && other.turns[d] == -one.turns[d]
            && other.turns[1 - d] == 0
    }) else {
        return Vec::new();
    };
    if sides[1 - along].closed {
        // Both sides of the two are bands there.
        return Vec::new();
    }
    let between =
        |p: [f64; 2]| crossings(&one.places, along, sides, p) != crossings(&other.places, along, sides, p);
    plain.iter().filter_map(|laid| lies_outside(laid, &between)).collect()
}

/// Loops of which one should go around all others.
fn one_around_all(plain: &[&Laid], sides: Option<&[ParameterSide; 2]>, sense: f64) -> Vec<LoopFlaw> {
    let areas: Vec<f64> = plain.iter().map(|laid| area(&laid.places)).collect();
    let Some(largest) = (0..plain.len()).max_by(|a, b| areas[*a].abs().total_cmp(&areas[*b].abs())) else {
        return Vec::new();
    };
    let outer = plain[largest];
    let inside = |p: [f64; 2]| in_any_turn(sides, p, &|p| is_around(&outer.places, p));
    let mut flaws: Vec<LoopFlaw> = Vec::new();
    let runs = |k: usize| if is_thin(plain[k]) { 0.0 } else { areas[k].signum() };
    if runs(largest) * sense < 0.0 {
        flaws.push(LoopFlaw::Clockwise(outer.area));
    }
    let mut holes = Vec::new();
    for k in (0..plain.len()).filter(|&k| k != largest) {
        match lies_outside(plain[k], &inside) {
            Some(flaw) => flaws.push(flaw),
            None => holes.push(k),
        }
    }
    // By where they begin: those that have ended before a hole begins are none that it lies in.
    let boxes: Vec<[[f64; 2]; 2]> = plain.iter().map(|laid| extent(&laid.places)).collect();
    holes.sort_by(|&a, &b| boxes[a][0][0].total_cmp(&boxes[b][0][0]).then(a.cmp(&b)));
    let mut open: Vec<usize> = Vec::new();
    let mut within = Vec::new();
    for &k in &holes {
        open.retain(|&other| boxes[other][1][0] >= boxes[k][0][0]);
        for &other in &open {
            if boxes[k][0][1] > boxes[other][1][1] || boxes[other][0][1] > boxes[k][1][1] {
                continue;
            }
            let (small, large) = if areas[k].abs() < areas[other].abs() { (k, other) } else { (other, k) };
            if lies_outside(plain[small], &|p| is_around(&plain[large].places, p)).is_none() {
                within.push(small);
            }
        }
        open.push(k);
    }
    within.sort_unstable();
    within.dedup();
    flaws.extend(within.iter().map(|&k| LoopFlaw::InHole(plain[k].area)));
    let along = holes.iter().filter(|k| within.binary_search(k).is_err());
    let mut along: Vec<usize> = along.copied().filter(|&k| runs(k) * runs(largest) > 0.0).collect();
    along.sort_unstable();
    flaws.extend(along.into_iter().map(|k| LoopFlaw::Along(plain[k].area)));
    flaws
}

/// Whether a loop is outside of something: where most of it is, for loops may touch; with a good part of it inside it crosses.
fn lies_outside(laid: &Laid, inside: &dyn Fn([f64; 2]) -> bool) -> Option<LoopFlaw> {
    /// The part that may be in for what touches only.
    const TOUCHES: f64 = 0.05;
    let count = laid.places.len();
    let out = laid.places.iter().filter(|p| !inside(**p)).count();
    if 2 * out <= count {
        None
    } else if (count - out) as f64 > TOUCHES * count as f64 {
        Some(LoopFlaw::Across(laid.area))
    } else {
        Some(LoopFlaw::Outside(laid.area))
    }
}

/// Whether a loop goes around so little, for its length, that it has no direction: it may as well cross itself.
fn is_thin(laid: &Laid) -> bool {
    const THIN: f64 = 1e-4;
    let next = laid.places.iter().cycle().skip(1);
    let length: f64 = laid.places.iter().zip(next).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).sum();
    area(&laid.places).abs() <= THIN * length * length
}

/// The least and the largest of both coordinates.
fn extent(places: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let none = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    places.iter().fold(none, |[low, high], p| {
        [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
    })
}

/// Whether something holds at a place or at the same one a period away.
fn in_any_turn(sides: Option<&[ParameterSide; 2]>, p: [f64; 2], holds: &dyn Fn([f64; 2]) -> bool) -> bool {
    let Some(sides) = sides else { return holds(p) };
    let turns = |d: usize| if sides[d].closed { -1..=1 } else { 0..=0 };
    turns(0).any(|a| {
        turns(1).any(|b| {
            holds([p[0] + f64::from(a) * sides[0].length(), p[1] + f64::from(b) * sides[1].length()])
        })
    })
}

/// Whether a loop that goes around a direction is met an odd number of times on the way from a place to one side across.
fn crossings(points: &[[f64; 2]], along: usize, sides: &[ParameterSide; 2], p: [f64; 2]) -> bool {
    let period = sides[along].length();
    let mut odd = false;
    let Some(first) = points.first() else { return false };
    let Some(end) = points.last() else { return false };
    let mut closing = *first;
    closing[along] = sides[along].unwrapped(first[along], end[along]);
    for (a, b) in points.iter().zip(points.iter().skip(1).chain(std::iter::once(&closing))) {
        let (low, high) = (a[along].min(b[along]), a[along].max(b[along]));
        // The turn of the place that lies in this piece, if any does.
        let at = p[along] + period * ((low - p[along]) / period).ceil();
        if at >= high {
            continue;
        }
        let share = (at - a[along]) / (b[along] - a[along]);
        let met = a[1 - along] + (b[1 - along] - a[1 - along]) * share;
        odd ^= met > p[1 - along];
    }
    odd
}

fn area(points: &[[f64; 2]]) -> f64 {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0])).sum()
}

/// Whether a closed polygon, given by its corners, goes around a place, an odd number of times. Linear in the corners.
pub fn is_around(points: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = points.iter().cycle().skip(1);
    let crosses = |(p, q): &(&[f64; 2], &[f64; 2])| {
        (p[1] > y) != (q[1] > y) && x < p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1]))
    };
    points.iter().zip(next).filter(crosses).count() % 2 == 1
}
