//! Loops that should lie in one another and lie beside one another.

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

impl Brep {
    /// The areas of the loops of a face that lie outside of what the others bound, each as seen from where it is largest: no holes, though nothing else
    /// makes parts of them. On a plane, and on any surface with a border, one loop goes around all others; on one that goes on where its parameters end (a
    /// cylinder, a torus) two that go around it bound what is between them, and all others lie in there; on a surface without any
    /// border none need lie in another. Empty where all is well, and where a loop is too far off the surface to be judged.
    ///
    /// A step downhill on the surface for each of 16 places of each knot span of the edges; none for planes and for faces with less than two loops.
    ///
    /// # Errors
    /// When an evaluation overflows.
    pub fn beside(&self, face: usize) -> Result<Vec<f64>> {
        let loops = self.loops(face);
        if loops.len() < 2 {
            return Ok(Vec::new());
        }
        let Some(surface) = self.surface(face) else { return Ok(Vec::new()) };
        let plane = match self.surface_form(face) {
            SurfaceForm::Plane { frame } => Some(frame),
            _ => None,
        };
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
        Ok(outside(&all, if plane.is_some() { None } else { Some(&sides) }, without_border))
    }

    /// [`beside`](Self::beside) in words, for what a reader says of a face.
    ///
    /// # Errors
    /// As for [`beside`](Self::beside).
    pub fn beside_told(&self, face: usize) -> Result<Option<String>> {
        let areas: Vec<String> = self.beside(face)?.into_iter().map(figure).collect();
        let curved = !matches!(self.surface_form(face), SurfaceForm::Plane { .. });
        let what = if curved { "what the others bound" } else { "the largest" };
        Ok(match &areas[..] {
            [] => None,
            [one] => Some(format!(
                "a loop of it, around an area of {one}, lies outside {what}: no hole of that, it is kept as a part of the face"
            )),
            all => Some(format!(
                "{} loops of it, around areas of {}, lie outside {what}: no holes of that, they are kept as parts of the face",
                all.len(),
                all.join(", ")
            )),
        })
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

/// The areas of the loops that are outside of what the others bound.
fn outside(all: &[Laid], sides: Option<&[ParameterSide; 2]>, without_border: bool) -> Vec<f64> {
    let (around, plain): (Vec<&Laid>, Vec<&Laid>) = all.iter().partition(|laid| laid.turns != [0; 2]);
    let most_outside = |laid: &Laid, inside: &dyn Fn([f64; 2]) -> bool| {
        // Loops may touch: what counts is where most of one is.
        2 * laid.places.iter().filter(|p| !inside(**p)).count() > laid.places.len()
    };
    if around.is_empty() {
        if without_border {
            return Vec::new();
        }
        let size = |laid: &Laid| area(&laid.places).abs();
        let largest =
            (0..plain.len()).max_by(|a, b| size(plain[*a]).total_cmp(&size(plain[*b]))).unwrap_or(0);
        let inside = |p: [f64; 2]| in_any_turn(sides, p, &|p| is_around(&plain[largest].places, p));
        let beside = (0..plain.len()).filter(|&k| k != largest && most_outside(plain[k], &inside));
        return beside.map(|k| plain[k].area).collect();
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
    plain.iter().filter(|laid| most_outside(laid, &between)).map(|laid| laid.area).collect()
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
