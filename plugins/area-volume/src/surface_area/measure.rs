//! The quadrature behind the area of a surface: two rules on each part, halved where they differ.

mod nodes;
mod part;
mod turns;

use std::collections::BinaryHeap;

use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{Cell, Location, Shape, Share};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::{Point, Result, Vector};

use self::nodes::{Along, Nodes};
use self::part::{Judged, Part};
use self::turns::Turns;
use crate::members::Member;
use crate::rule::Basis;

/// The rules' points beyond the degree.
const EXTRA: [usize; 2] = [2, 4];
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

/// Where a surface folds over along a line of its net is found to this part of a cell.
const FOUND: f64 = 1e-15;
/// On both sides of such a line, so far from it by a cell's length, the normals are opposite.
const BESIDE: f64 = 1e-7;
/// What is left of `|S_u × S_v|` below this part of its mean says nothing about the direction of a crease.
const UNSEEN: f64 = 1e-6;

/// A surface at work.
pub(super) struct Measure<'s> {
    shape: &'s dyn Shape,
    /// The spaces and the weights, of a tensor-product spline.
    splines: Option<(&'s Space, &'s Space, Option<&'s [f64]>)>,
    points: &'s [Point],
    /// The cells: of a spline the numbers of their spans.
    cells: Vec<Part>,
    /// What counts of cells, where that is not all.
    counted: &'s [(Cell, Share)],
    degrees: [usize; 2],
    /// The rougher and the better one, and this with its ends.
    rules: [Nodes; 3],
    bases: [Basis; 2],
    /// Whether it is told once.
    telling: bool,
    /// What a stencil could not be had for.
    failed: Option<Error>,
}

impl<'s> Measure<'s> {
    pub(super) fn new(surface: &Member<'s>, counted: &'s [(Cell, Share)]) -> Self {
        let [p, q] = surface.cells.degrees();
        let rule = |extra: usize| Nodes { u: Along::new(p + extra), v: Along::new(q + extra) };
        let with_ends = Nodes { u: Along::with_ends(p + EXTRA[1]), v: Along::with_ends(q + EXTRA[1]) };
        let splines = surface.splines.and_then(|all| Some((all.u, all.v?, all.weights)));
        let mut cells = Vec::new();
        match splines {
            Some((u, v, _)) => {
                let ends = |flat: &[f64], span: usize| (flat[span], flat[span + 1]);
                for i in u.spans() {
                    let each = v.spans().map(|j| (j, ends(v.flat(), j)));
                    cells.extend(each.map(|(j, v)| Part {
                        spans: [i, j],
                        face: None,
                        u: ends(u.flat(), i),
                        v,
                        share: None,
                        halved: [0; 2],
                    }));
                }
            }
            None => {
                for (number, (cell, share)) in counted.iter().enumerate() {
                    let [u, v] = cell.sides[..] else { continue };
                    let (u, v) = ((u.start, u.end), (v.start, v.end));
                    let share = matches!(share, Share::Part(_)).then_some((number, 1));
                    cells.push(Part { spans: [0; 2], face: cell.face, u, v, share, halved: [0; 2] });
                }
            }
        }
        let [rough, fine] = EXTRA.map(rule);
        let (rules, bases) = ([rough, fine, with_ends], [Basis::default(), Basis::default()]);
        let (shape, points) = (surface.shape, surface.points());
        Self {
            shape,
            splines,
            points,
            cells,
            counted,
            degrees: [p, q],
            rules,
            bases,
            telling: false,
            failed: None,
        }
    }

    /// The area of a part by one of the rules, and its gradient added where there is room.
    fn part(&mut self, part: Part, rule: usize, gradient: Option<&mut [Vector]>) -> Sum {
        if let Some(splines) = self.splines {
            return self.part_of_spans(splines, part, rule, gradient);
        }
        self.part_by_stencils(part, rule, gradient).unwrap_or_else(|error| {
            self.failed.get_or_insert(error);
            Sum::default()
        })
    }

    /// What a place adds: the normal, and the gradient of its size times a weight.
    fn place(&self, at: Location, weight: f64, gradient: Option<&mut [Vector]>) -> Result<Vector> {
        let row = |by: [usize; 2]| self.shape.stencil(at, by.into());
        let (by_u, by_v) = (row([1, 0])?, row([0, 1])?);
        let (su, sv) = (by_u.apply(self.points), by_v.apply(self.points));
        let normal = su.cross(&sv);
        let size = normal.norm();
        if let Some(gradient) = gradient.filter(|_| size > 0.0) {
            let unit = normal / size;
            let (along, across) = (sv.cross(&unit) * weight, unit.cross(&su) * weight);
            by_u.iter().for_each(|(vertex, c)| gradient[vertex] += along * c);
            by_v.iter().for_each(|(vertex, c)| gradient[vertex] += across * c);
        }
        Ok(normal)
    }

    fn part_by_stencils(&self, part: Part, rule: usize, mut gradient: Option<&mut [Vector]>) -> Result<Sum> {
        if let Some((number, parts)) = part.share
            && let Some((cell, share)) = self.counted.get(number)
        {
            let ([p, q], extra) = (self.degrees, EXTRA[rule.min(1)]);
            // Where all is smooth, rules of more points get nearer by far than as many points of the same rule on more parts.
            let (times, parts) = raised(p.max(q) + EXTRA[1], parts);
            let counts = [times * (p + extra), times * (q + extra)];
            let mut sum = Sum::default();
            for (at, weight) in share.gauss_points(cell, counts, parts) {
                sum.area += weight * self.place(at, weight, gradient.as_deref_mut())?.norm();
            }
            return Ok(sum);
        }
        let Nodes { u: along_u, v: along_v } = &self.rules[rule];
        let (length_u, length_v) = (part.u.1 - part.u.0, part.v.1 - part.v.0);
        let (mut sum, mut turns) = (Sum::default(), Turns::default());
        for (x, [wx, ux @ ..]) in &along_u.0 {
            for (j, (y, [wy, vy @ ..])) in along_v.0.iter().enumerate() {
                let at = part.at(part.u.0 + length_u * x, part.v.0 + length_v * y);
                let weight = wx * length_u * wy * length_v;
                let normal = self.place(at, weight, gradient.as_deref_mut())?;
                turns.see(j, normal.into());
                let size = normal.norm();
                sum.area += wx * wy * size;
                for k in 0..2 {
                    sum.rough_along[0][k] += ux[k] * wy * size;
                    sum.rough_along[1][k] += wx * vy[k] * size;
                }
            }
        }
        sum.area *= length_u * length_v;
        sum.creased = turns.creased;
        Ok(sum)
    }

    fn part_of_spans(
        &mut self,
        (su, sv, weights): (&Space, &Space, Option<&[f64]>),
        part: Part,
        rule: usize,
        mut gradient: Option<&mut [Vector]>,
    ) -> Sum {
        let (p, q) = (su.degree(), sv.degree());
        let columns = sv.len();
        let vertex = |i: usize, j: usize| {
            su.vertex(part.spans[0] - p + i) * columns + sv.vertex(part.spans[1] - q + j)
        };
        let points = self.points;
        let [bu, bv] = &mut self.bases;
        bu.enter(su, part.spans[0]);
        bv.enter(sv, part.spans[1]);
        let Nodes { u: along_u, v: along_v } = &self.rules[rule];
        let (length_u, length_v) = (part.u.1 - part.u.0, part.v.1 - part.v.0);
        let (mut sum, mut turns) = (Sum::default(), Turns::default());
        for (x, [wx, ux @ ..]) in &along_u.0 {
            bu.at(part.u.0 + length_u * x);
            // Combined along u: homogeneous points and derivatives for each of the q + 1 columns.
            let mut line = [[[0.0; 4]; 2]; MAX_ORDER];
            for (j, line) in line.iter_mut().enumerate().take(q + 1) {
                for i in 0..=p {
                    let at = vertex(i, j);
                    let w = weights.map_or(1.0, |w| w[at]);
                    let h = [points[at].x * w, points[at].y * w, points[at].z * w, w];
                    for a in 0..4 {
                        line[0][a] += bu.values[i] * h[a];
                        line[1][a] += bu.slopes[i] * h[a];
                    }
                }
            }
            let mut sums = [[[0.0; 3]; 2]; MAX_ORDER];
            for (j, (y, [wy, vy @ ..])) in along_v.0.iter().enumerate() {
                bv.at(part.v.0 + length_v * y);
                let (mut s, mut su_, mut sv_) = ([0.0; 4], [0.0; 4], [0.0; 4]);
                for (j, line) in line.iter().enumerate().take(q + 1) {
                    for a in 0..4 {
                        s[a] += bv.values[j] * line[0][a];
                        su_[a] += bv.values[j] * line[1][a];
                        sv_[a] += bv.slopes[j] * line[0][a];
                    }
                }
                let w = s[3];
                let project = |d: [f64; 4]| [0, 1, 2].map(|a| (d[a] - s[a] / w * d[3]) / w);
                let (tu, tv) = (project(su_), project(sv_));
                let normal = cross(tu, tv);
                turns.see(j, normal);
                let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
                sum.area += wx * wy * size;
                for k in 0..2 {
                    sum.rough_along[0][k] += ux[k] * wy * size;
                    sum.rough_along[1][k] += wx * vy[k] * size;
                }
                if !(gradient.is_some() && size > 0.0) {
                    continue;
                }
                // The point, its u and its v derivative depend on the vertices as `s`, `su_` and `sv_` do: summed over this
                // line first, so that a point costs the vertices of one direction, not of both.
                let unit = normal.map(|n| n / size);
                let weight = wx * length_u * wy * length_v / w;
                let (by_u, by_v) = (cross(tv, unit), cross(unit, tu));
                for a in 0..3 {
                    let (by_u, by_v) = (by_u[a] * weight, by_v[a] * weight);
                    let by_point = -(by_u * su_[3] + by_v * sv_[3]) / w;
                    for (j, sums) in sums.iter_mut().enumerate().take(q + 1) {
                        sums[0][a] += by_point * bv.values[j] + by_v * bv.slopes[j];
                        sums[1][a] += by_u * bv.values[j];
                    }
                }
            }
            let Some(gradient) = gradient.as_deref_mut() else { continue };
            for i in 0..=p {
                for (j, [by_value, by_slope]) in sums.iter().enumerate().take(q + 1) {
                    let at = vertex(i, j);
                    let own = weights.map_or(1.0, |w| w[at]);
                    for a in 0..3 {
                        gradient[at][a] += own * (by_value[a] * bu.values[i] + by_slope[a] * bu.slopes[i]);
                    }
                }
            }
        }
        sum.area *= length_u * length_v;
        sum.creased = turns.creased;
        sum
    }

    /// The area, what it may be wrong by, and its gradient added where there is room.
    pub(super) fn whole(&mut self, mut gradient: Option<&mut [Vector]>, effort: Effort) -> Result<Area> {
        self.telling = matches!(effort, Effort::Telling(_));
        let mut parts = BinaryHeap::new();
        for part in std::mem::take(&mut self.cells) {
            parts.push(self.judged(part, parts.len()));
        }
        let cells = parts.len();
        let share = parts.iter().map(|p| p.fine).sum::<f64>() / cells.max(1) as f64;
        let mut made = cells;
        let usual = halvings(cells);
        let most = if self.telling { MORE * HALVINGS + cells } else { usual };
        for done in 0..most {
            if let Effort::Telling(enough) = effort
                && done >= usual
                && (done - usual).is_multiple_of(LOOK)
            {
                let sums = parts.iter().fold((0.0, 0.0), |(a, e), p| (a + p.fine, e + p.error));
                if sums.1 <= enough * sums.0 {
                    break;
                }
            }
            let Some(worst) = parts.pop() else { break };
            if worst.error <= AGREE * share.max(worst.fine) || !worst.error.is_finite() {
                parts.push(worst);
                break;
            }
            let whole_cell = worst.order < cells && worst.part.share.is_none();
            let folded = if whole_cell { self.unfolded(&worst.part, made) } else { None };
            let Some(halves) = folded.or_else(|| self.halves(&worst, made)) else {
                // Too short to be halved: what it may be wrong by stays counted, and others go on.
                parts.push(Judged { settled: true, ..worst });
                if parts.peek().is_none_or(|p| p.settled) {
                    break;
                }
                continue;
            };
            made += halves.len();
            parts.extend(halves);
        }
        // In the order in which they were made: the same sum every time.
        let mut parts = parts.into_vec();
        parts.sort_by_key(|p| p.order);
        let mut found = Area { area: 0.0, error: 0.0 };
        for p in &parts {
            if gradient.is_some() {
                self.part(p.part, 1, gradient.as_deref_mut());
            }
            found.area += p.fine;
            found.error += p.error;
        }
        self.failed.take().map_or(Ok(found), Err)
    }

    fn judged(&mut self, part: Part, order: usize) -> Judged {
        let better = if self.telling { 2 } else { 1 };
        let (rough, fine) = (self.part(part, 0, None), self.part(part, better, None));
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
        Judged { part, fine: fine.area, error, across_u, order, settled: false }
    }

    /// A cell cut along the lines of the net along which it folds over, as what is turned does where the speed of its profile vanishes: beside them it is
    /// smooth, and no number of halvings gets as near. None where there are no such lines.
    fn unfolded(&mut self, part: &Part, order: usize) -> Option<Vec<Judged>> {
        let [p, q] = self.degrees;
        let us = self.folds(p, part.u, part.v, &|x, y| part.at(x, y));
        let vs = self.folds(q, part.v, part.u, &|x, y| part.at(y, x));
        if us.is_empty() && vs.is_empty() {
            return None;
        }
        let ends = |(a, b): (f64, f64), inner: &[f64]| -> Vec<(f64, f64)> {
            let all: Vec<f64> = [a].into_iter().chain(inner.iter().copied()).chain([b]).collect();
            all.windows(2).map(|w| (w[0], w[1])).collect()
        };
        let mut parts = Vec::new();
        for u in ends(part.u, &us) {
            for v in ends(part.v, &vs) {
                parts.push(self.judged(Part { u, v, ..*part }, order + parts.len()));
            }
        }
        Some(parts)
    }

    /// The parameters of one direction, of this degree, at which the normal turns round all along the other one.
    fn folds(
        &self,
        degree: usize,
        (a, b): (f64, f64),
        across: (f64, f64),
        at: &dyn Fn(f64, f64) -> Location,
    ) -> Vec<f64> {
        let other = |share: f64| across.0 + (across.1 - across.0) * share;
        let normal = |x: f64, y: f64| -> Option<Vector> {
            let row = |by: [usize; 2]| self.shape.stencil(at(x, y), by.into()).ok();
            Some(row([1, 0])?.apply(self.points).cross(&row([0, 1])?.apply(self.points)))
        };
        let places = 2 * degree + 2;
        let place = |k: usize| a + (b - a) * (k as f64 + 0.5) / places as f64;
        let middle = other(0.5);
        let mut found = Vec::new();
        let mut before = normal(place(0), middle);
        for k in 1..places {
            let here = normal(place(k), middle);
            if let (Some(from), Some(to)) = (before, here)
                && from.dot(&to) < 0.0
            {
                let (mut low, mut high) = (place(k - 1), place(k));
                while high - low > FOUND * (b - a) {
                    let between = 0.5 * low + 0.5 * high;
                    if !(low < between && between < high) {
                        break;
                    }
                    match normal(between, middle) {
                        Some(n) if n.dot(&from) > 0.0 => low = between,
                        _ => high = between,
                    }
                }
                let line = 0.5 * low + 0.5 * high;
                let beside = BESIDE * (b - a);
                let turns = |share: f64| {
                    let sides = [line - beside, line + beside].map(|x| normal(x, other(share)));
                    matches!(sides, [Some(n), Some(m)] if n.dot(&m) < 0.0)
                };
                if line - beside > a && line + beside < b && [0.1, 0.37, 0.9].into_iter().all(turns) {
                    found.push(line);
                }
            }
            before = here;
        }
        found
    }

    /// A part in two, across the direction in which it is less smooth. None where there is no number between the ends.
    fn halves(&mut self, whole: &Judged, order: usize) -> Option<Vec<Judged>> {
        let part = whole.part;
        if let Some((number, parts)) = part.share {
            // What loops leave of a cell is cut as a whole.
            let finer = Part { share: Some((number, 2 * parts)), ..part };
            return (parts < MOST_PARTS).then(|| vec![self.judged(finer, order)]);
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
        halves.map(|[first, second]| vec![self.judged(first, order), self.judged(second, order + 1)])
    }
}

/// By how much the points of a rule of `count` points are raised, and on how many parts it is then used, so that there are `fineness` times as many.
fn raised(count: usize, fineness: usize) -> (usize, usize) {
    let mut times = 1;
    while 2 * times <= fineness && 2 * times * count <= MOST_RAISED {
        times *= 2;
    }
    (times, fineness / times)
}

/// What a rule finds on a part: the area, and what is left of `|S_u × S_v|` along u and along v when it is summed over the
/// other direction and polynomials are taken out: nothing where it is smooth.
#[derive(Default)]
struct Sum {
    area: f64,
    rough_along: [[f64; 2]; 2],
    /// Whether the normal turns by more than a right angle between neighbouring nodes: there is a crease, or it is not smooth yet.
    creased: bool,
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
    let [p, q] = surface.cells.degrees();
    let [rough, fine] = EXTRA.map(|extra| (p + extra) * (q + extra));
    let cells = match surface.splines {
        Some(all) => all.u.spans().count() * all.v.map_or(1, |v| v.spans().count()),
        None => counted.len(),
    };
    let halvings = halvings(cells);
    (cells + 2 * halvings) * (rough + fine) + (cells + halvings) * fine
}

/// How many halvings so many cells are allowed.
fn halvings(cells: usize) -> usize {
    HALVINGS + HALVINGS_A_CELL * cells
}
