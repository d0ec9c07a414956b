//! What closes, ends in a point or runs smoothly in a surface by where its control vertices are, and not by its knots: what of that a motion loses is told.

use loftsman_kernel::shape::{Derivative, Interval, Location, Shape, Side};
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Vector};

use crate::body::extent;
use crate::seam::MEETS;

use super::seams::{APART, FOLDED, SMOOTH};

/// Places along an edge or a line of knots at which it is looked at.
const PLACES: usize = 17;
/// Lines of knots more than these are not looked at.
const MOST: usize = 512;

/// Edges that meet and edges that are points, and lines of knots along which a surface runs smoothly though they would let it fold.
#[derive(Debug, Default)]
pub(super) struct Creases {
    /// Whether the edges at the start and at the end of a parameter meet.
    meets: [bool; 2],
    /// Whether the edges at the start and at the end of a parameter are points.
    points: [[bool; 2]; 2],
    lines: Vec<Line>,
}

/// A line of knots: the parameter that stands still on it, where, and which of its places are smooth.
#[derive(Debug)]
struct Line {
    axis: usize,
    at: f64,
    smooth: [bool; PLACES],
}

impl Creases {
    /// Those of a surface as it is; none of other shapes. `O(p)` for each place.
    pub(super) fn of(shape: &dyn Shape) -> Self {
        let Some(domain) = surface(shape) else { return Self::default() };
        let size = extent(shape.control_vertices());
        let mut creases = Self::default();
        for axis in 0..2 {
            if domain[axis].periodic {
                continue;
            }
            let [start, end] = [domain[axis].start, domain[axis].end].map(|at| edge(shape, axis, at));
            creases.points[axis] = [&start, &end].map(|edge| spread(edge) <= MEETS * size);
            creases.meets[axis] = creases.points[axis] != [true; 2] && apart(&start, &end) <= MEETS * size;
        }
        let Some(splines) = shape.cells().and_then(|cells| cells.splines()) else { return creases };
        for (axis, space) in [Some(splines.u), splines.v].into_iter().enumerate() {
            let Some(space) = space else { continue };
            let (start, end) = space.domain();
            let inside = |u: &f64| *u < end && (space.is_periodic() || *u > start);
            let knots = space.breakpoints().into_iter();
            let loose = knots.filter(inside).filter(|u| space.multiplicity(*u) >= space.degree());
            for at in loose.take(MOST - creases.lines.len()) {
                let smooth = turns(shape, axis, at).map(|cosine| cosine.is_some_and(|c| c >= SMOOTH));
                if smooth.contains(&true) {
                    creases.lines.push(Line { axis, at, smooth });
                }
            }
        }
        creases
    }

    /// What of it is no more, in words.
    pub(super) fn lost(&self, name: &str, shape: &dyn Shape) -> Option<String> {
        let (domain, size) = (surface(shape)?, extent(shape.control_vertices()));
        let edges = |axis: usize| [domain[axis].start, domain[axis].end].map(|at| edge(shape, axis, at));
        let mut said = Vec::new();
        for axis in (0..2).filter(|&axis| self.meets[axis]) {
            let [start, end] = edges(axis);
            let gap = apart(&start, &end);
            if gap > APART * size {
                said.push(format!(
                    "its edges at the ends of {}, which met, are up to {} apart, as nothing in its knots holds them together: make it periodic there first (operation simplify with periodic = true)",
                    ["u", "v"][axis],
                    figure(gap)
                ));
            }
        }
        for axis in 0..2 {
            for (edge, was) in edges(axis).iter().zip(self.points[axis]) {
                let wide = spread(edge);
                if was && wide > APART * size {
                    said.push(format!(
                        "its edge at an end of {}, which was one point, is {} wide: fix it there, or it opens",
                        ["u", "v"][axis],
                        figure(wide)
                    ));
                }
            }
        }
        if !said.is_empty() {
            return Some(format!("{name:?} has come open: {}", said.join("; ")));
        }
        let mut folded = self.lines.iter().filter_map(|line| {
            let turns = turns(shape, line.axis, line.at);
            let worst =
                turns.iter().zip(line.smooth).filter(|(_, smooth)| *smooth).filter_map(|(turn, _)| *turn);
            let worst = worst.fold(1.0, f64::min);
            (worst < FOLDED).then_some((line, worst))
        });
        let first = folded.next()?;
        let (count, worst) = folded.fold((0, first), |(count, worst), next| {
            (count + 1, if next.1 < worst.1 { next } else { worst })
        });
        let more =
            if count > 0 { format!(" and along {count} more of its knots' lines") } else { String::new() };
        Some(format!(
            "{name:?} has folded along {} = {} by up to {} degrees{more}, where its knots let it and `bending` does not act: fit a surface whose knots are simple to it",
            ["u", "v"][worst.0.axis],
            figure(worst.0.at),
            figure((worst.1.clamp(-1.0, 1.0).acos().to_degrees() * 10.0).round() / 10.0)
        ))
    }
}

/// The domain of a surface of one face.
fn surface(shape: &dyn Shape) -> Option<[Interval; 2]> {
    let splines = shape.cells()?.splines()?;
    splines.v?;
    let domain = shape.domain();
    Some([*domain.first()?, *domain.get(1)?])
}

fn places(interval: Interval) -> [f64; PLACES] {
    std::array::from_fn(|k| {
        interval.start + (interval.end - interval.start) * (k as f64 / (PLACES - 1) as f64)
    })
}

fn at(axis: usize, still: f64, along: f64) -> Location {
    if axis == 0 { Location::Surface(still, along) } else { Location::Surface(along, still) }
}

/// Points of an edge, evenly in the other parameter.
fn edge(shape: &dyn Shape, axis: usize, still: f64) -> Vec<Point> {
    let Some(domain) = surface(shape) else { return Vec::new() };
    let points = shape.control_vertices();
    let point = |along: f64| shape.stencil(at(axis, still, along), Derivative::POSITION).ok();
    let all = places(domain[1 - axis]).into_iter().filter_map(point);
    all.map(|stencil| Point::from(stencil.apply(points))).collect()
}

fn apart(a: &[Point], b: &[Point]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn spread(edge: &[Point]) -> f64 {
    edge.iter().map(|p| (p - edge[0]).norm()).fold(0.0, f64::max)
}

/// The cosines of the angles between the normals on either side of a line of knots; none where there is no normal.
fn turns(shape: &dyn Shape, axis: usize, still: f64) -> [Option<f64>; PLACES] {
    let Some(domain) = surface(shape) else { return [None; PLACES] };
    let points = shape.control_vertices();
    let normal = |along: f64, side: Side| -> Option<Vector> {
        let sides = if axis == 0 { [side, Side::Right] } else { [Side::Right, side] };
        let way = |u: usize, v: usize| {
            let stencil = shape.stencil_on(at(axis, still, along), Derivative { u, v }, sides.into()).ok()?;
            stencil.apply(points).try_normalize(0.0)
        };
        way(1, 0)?.cross(&way(0, 1)?).try_normalize(1e-9)
    };
    places(domain[1 - axis]).map(|along| Some(normal(along, Side::Left)?.dot(&normal(along, Side::Right)?)))
}
