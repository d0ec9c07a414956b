//! A branch of a section as a spline: cubic pieces with its points and directions, halved until they are near enough.

use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use super::SectionCurve;
use super::cell::{Cell, Cells, across};
use super::chain::Chain;
use crate::error::Result;
use crate::intersections::Plane;
use crate::net::Frame;

/// Halvings of one cell's part.
const HALVINGS: usize = 24;
/// Into so many parts a piece is cut to say how far it is from the section.
const SAMPLES: usize = 16;
/// Pieces that are shorter than this part of the whole are none: where the section passes near a corner of its cells.
const SHORTEST: f64 = 1e-13;

/// Pieces that are shorter than this part of the tolerance are none either: an end of the next piece takes in where they lie.
const TOO_SHORT: f64 = 0.1;

/// The pieces without those that are too short, each of which an end of a longer neighbour takes in; and how far ends were moved at most.
fn without_short(cubics: Vec<Cubic>, least: f64) -> (Vec<Cubic>, f64) {
    if cubics.iter().map(|cubic| cubic.length).sum::<f64>() < least {
        return (cubics, 0.0);
    }
    let mut kept: Vec<Cubic> = Vec::with_capacity(cubics.len());
    let (mut moved, mut pending, mut before) = (0.0_f64, None::<Place>, 0.0);
    for mut cubic in cubics {
        // Many of them in a row are as long as a piece of their own.
        if cubic.length < least && before + cubic.length < least {
            before += cubic.length;
            match kept.last_mut() {
                Some(last) => {
                    let by = cubic.end.point - last.end.point;
                    last.vertices[2] += by;
                    last.vertices[3] += by;
                    last.end = Place { tangent: last.end.tangent, ..cubic.end };
                    moved = moved.max(before);
                }
                None => pending = pending.or(Some(cubic.start)),
            }
            continue;
        }
        if let Some(start) = pending.take() {
            let by = start.point - cubic.start.point;
            cubic.vertices[0] += by;
            cubic.vertices[1] += by;
            cubic.start = Place { tangent: cubic.start.tangent, ..start };
            moved = moved.max(before);
        }
        before = 0.0;
        kept.push(cubic);
    }
    (kept, moved)
}

/// A place of the section and its direction.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: [f64; 2],
    point: Vector,
    tangent: Vector,
}

/// A cubic piece in Bézier form, and its length.
struct Cubic {
    vertices: [Vector; 4],
    length: f64,
    start: Place,
    end: Place,
}

pub(crate) fn trace(
    cells: &Cells<'_>,
    chain: &Chain,
    frame: &Frame,
    plane: &Plane,
    tolerance: f64,
) -> Result<SectionCurve> {
    let mut cubics: Vec<Cubic> = Vec::new();
    let mut distance = 0.0_f64;
    for &(index, backwards) in &chain.parts {
        let part = &cells.parts[index];
        let [mut a, mut b] = part.ends.map(|e| e.at);
        if backwards {
            std::mem::swap(&mut a, &mut b);
        }
        let d = part.cell.along;
        let line = Line { cells, cell: &part.cell, plane, forward: (b[d] - a[d]).signum() };
        let mut open = vec![(line.place(a), line.place(b), 0)];
        while let Some((start, end, depth)) = open.pop() {
            let (from, to) = (start.at[d], end.at[d]);
            let middle = line.place(line.at(0.5 * (from + to)));
            let cubic = hermite(start, end, &middle);
            if cubic.length == 0.0 {
                continue;
            }
            let off = line.measure(&cubic);
            let inside = 0.5 * (from + to);
            let halvable = (from < inside && inside < to) || (to < inside && inside < from);
            // What is off between those few points, where the section turns sharply, is seen at many.
            let peak = || off.max(line.largest(&cubic));
            let halves = depth < HALVINGS && halvable;
            if halves && (off > 0.8 * tolerance || peak() > tolerance) {
                open.push((middle, end, depth + 1));
                open.push((start, middle, depth + 1));
                continue;
            }
            distance = distance.max(peak());
            cubics.push(cubic);
        }
    }
    // What is shorter than rounding of a knot where it lies would repeat that.
    let least = SHORTEST * cubics.iter().map(|cubic| cubic.length).sum::<f64>();
    cubics.retain(|cubic| cubic.length > least);
    let (cubics, moved) = without_short(cubics, TOO_SHORT * tolerance);
    let distance = distance + moved;
    let parameters =
        cubics.iter().map(|c| c.start.at).chain(cubics.last().map(|c| c.end.at)).collect::<Vec<_>>();
    let curve = join(&cubics, chain.closed, frame)?;
    Ok(SectionCurve {
        curve,
        closed: chain.closed,
        distance: distance * frame.size,
        parameters,
        isocurve: None,
    })
}

struct Line<'a> {
    cells: &'a Cells<'a>,
    cell: &'a Cell,
    plane: &'a Plane,
    forward: f64,
}

impl Line<'_> {
    fn at(&self, along: f64) -> [f64; 2] {
        across(self.cell, self.cells.piece(self.cell).orders, along)
    }

    fn place(&self, at: [f64; 2]) -> Place {
        let (jet, [fu, fv]) = self.cells.jet(self.cell, at);
        let mut tangent = jet.along[0] * fv - jet.along[1] * fu;
        // It runs the way that the parameter does.
        let way = if self.cell.along == 0 { fv } else { -fu };
        if way * self.forward < 0.0 {
            tangent = -tangent;
        }
        let normal = self.plane.normal();
        tangent -= normal * normal.dot(&tangent);
        let length = tangent.norm();
        let tangent = if length > 0.0 { tangent / length } else { Vector::zeros() };
        Place { at, point: jet.point, tangent }
    }

    /// The largest distance from the section among a few points between the ends: enough to say whether the piece is halved.
    fn measure(&self, cubic: &Cubic) -> f64 {
        [0.2, 0.4, 0.6, 0.8].iter().map(|x| self.off(cubic, *x)).fold(0.0, f64::max)
    }

    /// The largest distance from the section: the largest of many, and what a parabola through it and those beside it can rise above it between them.
    fn largest(&self, cubic: &Cubic) -> f64 {
        let mut off = [0.0; SAMPLES + 1];
        for (k, off) in off.iter_mut().enumerate().take(SAMPLES).skip(1) {
            *off = self.off(cubic, k as f64 / SAMPLES as f64);
        }
        off.windows(3).fold(0.0, |largest, beside| {
            let [before, here, after] = [beside[0], beside[1], beside[2]];
            let bend = before + after - 2.0 * here;
            let peak = if here >= before && here >= after { -0.125 * bend } else { 0.0 };
            largest.max(here + peak)
        })
    }

    /// The distance of the cubic's point at `x` of the whole from the section.
    fn off(&self, cubic: &Cubic, x: f64) -> f64 {
        let d = self.cell.along;
        let (from, to) = (cubic.start.at[d], cubic.end.at[d]);
        let y: f64 = 1.0 - x;
        let [a, b, c, e] = cubic.vertices;
        let point = a * (y * y * y) + b * (3.0 * y * y * x) + c * (3.0 * y * x * x) + e * (x * x * x);
        // The section's point beside it: that to which the way is across the section. By false positions (Illinois), as beside a pole the parameter runs at
        // quite another pace than the section.
        let ahead_of = |place: &Place| (point - place.point).dot(&place.tangent);
        let (mut low, mut high) = ((0.0, ahead_of(&cubic.start)), (1.0, ahead_of(&cubic.end)));
        let mut best = (point - cubic.start.point).norm().min((point - cubic.end.point).norm());
        let mut s: f64 = x;
        for _ in 0..48 {
            let place = self.place(self.at(from + (to - from) * s));
            let away = (point - place.point).norm();
            best = best.min(away);
            let ahead = ahead_of(&place);
            if ahead.abs() <= 0.01 * away {
                break;
            }
            if ahead > 0.0 {
                (low, high.1) = ((s, ahead), 0.5 * high.1);
            } else {
                (high, low.1) = ((s, ahead), 0.5 * low.1);
            }
            let next = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            s = if next > low.0 && next < high.0 { next } else { 0.5 * (low.0 + high.0) };
        }
        best
    }
}

/// The cubic with the places' points and directions, at about the speed 1.
fn hermite(start: Place, end: Place, middle: &Place) -> Cubic {
    let chord = (end.point - start.point).norm();
    let halves = (middle.point - start.point).norm() + (end.point - middle.point).norm();
    let length = (4.0 * halves - chord) / 3.0;
    let vertices = [
        start.point,
        start.point + start.tangent * (length / 3.0),
        end.point - end.tangent * (length / 3.0),
        end.point,
    ];
    Cubic { vertices, length, start, end }
}

/// The pieces as one spline: knots twice where directions agree, else three times.
fn join(cubics: &[Cubic], closed: bool, frame: &Frame) -> Result<Curve> {
    let mut points = Vec::with_capacity(2 * cubics.len() + 2);
    let mut knots = vec![0.0; 4];
    let mut at = 0.0;
    for (k, cubic) in cubics.iter().enumerate() {
        let smooth = k > 0 && (cubic.start.tangent - cubics[k - 1].end.tangent).norm() <= 1e-6;
        if k == 0 {
            points.push(cubic.vertices[0]);
        } else {
            knots.extend([at, at]);
            if !smooth {
                knots.push(at);
                points.push(cubic.vertices[0]);
            }
        }
        points.extend([cubic.vertices[1], cubic.vertices[2]]);
        at += cubic.length * frame.size;
    }
    let last =
        if closed { cubics.first().map(|c| c.vertices[0]) } else { cubics.last().map(|c| c.vertices[3]) };
    points.extend(last);
    knots.extend([at; 4]);
    let points: Vec<Point> = points.into_iter().map(|p| frame.center + p * frame.size).collect();
    let curve = Curve::new(Space::open(3, knots)?, points)?;
    // Where it begins it is as smooth as elsewhere, to rounding.
    Ok(if closed { curve.to_periodic(16.0 * f64::EPSILON * frame.size)?.shape } else { curve })
}
