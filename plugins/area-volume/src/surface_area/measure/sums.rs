//! What a rule finds on a part: by spans of a spline, by a net, or by stencils.

use loftsman_kernel::error::Error;
use loftsman_kernel::shape::{CellSide, Location};
use loftsman_kernel::{Result, Vector};

use super::nodes::Nodes;
use super::part::Part;
use super::turns::{Turns, creased};
use super::{EXTRA, MOST_RAISED, Measure, WITH_ENDS};
use crate::nets::{Line, MOST_NODES, Row};
use crate::rule::Basis;

/// What one thread works with.
#[derive(Default)]
pub(super) struct Room {
    pub(super) bases: [Basis; 2],
    row: Row,
    /// What a stencil could not be had for.
    failed: Option<Error>,
}

impl Room {
    /// # Errors
    /// Where a stencil could not be had.
    pub(super) fn sound(&mut self) -> Result<()> {
        self.failed.take().map_or(Ok(()), Err)
    }
}

/// What a rule finds on a part: the area, and what is left of `|S_u × S_v|` along u and along v when it is summed over the
/// other direction and polynomials are taken out: nothing where it is smooth.
#[derive(Default)]
pub(super) struct Sum {
    pub(super) area: f64,
    pub(super) rough_along: [[f64; 2]; 2],
    /// Whether the normal turns by more than a right angle between neighbouring nodes: there is a crease, or it is not smooth yet.
    pub(super) creased: bool,
}

/// The net of the cell of a part, and its sides.
#[derive(Clone, Copy)]
pub(super) struct Net<'n> {
    pub(super) points: &'n [Vector],
    pub(super) sides: [CellSide; 2],
}

impl<'n> Net<'n> {
    /// The shares of an interval of one of its sides: 0 at the start of the side, 1 at its end.
    fn shares(&self, side: usize, (a, b): (f64, f64)) -> (f64, f64) {
        let CellSide { start, end, .. } = self.sides[side];
        ((a - start) / (end - start), (b - start) / (end - start))
    }

    /// The direction of `S_u × S_v` at a place.
    pub(super) fn normal_at(&self, u: f64, v: f64) -> Vector {
        let shares = [self.shares(0, (u, u)).0, self.shares(1, (v, v)).0];
        let lines = [0, 1].map(|k| Line::new(self.sides[k].degree, std::iter::once(shares[k])));
        let mut row = Row::default();
        row.fill(self.points, [&lines[0], &lines[1]], 0, false);
        Vector::from(row.normal(0))
    }
}

/// The functions of whole cells at the nodes of a rule.
pub(super) struct Lines([Line; 2]);

impl Lines {
    /// At the nodes of a rule in intervals of shares of the sides.
    pub(super) fn new(degrees: [usize; 2], rule: &Nodes, [u, v]: [(f64, f64); 2]) -> Self {
        let place = |(a, b): (f64, f64)| move |(x, _): &(f64, [f64; 3])| a + (b - a) * x;
        Self([
            Line::new(degrees[0], rule.u.0.iter().map(place(u))),
            Line::new(degrees[1], rule.v.0.iter().map(place(v))),
        ])
    }
}

impl Measure<'_> {
    /// The area of a part by one of the rules, and its gradient added where there is room.
    pub(super) fn part(
        &self,
        part: Part,
        rule: usize,
        net: Option<Net<'_>>,
        gradient: Option<&mut [Vector]>,
        room: &mut Room,
    ) -> Sum {
        if let Some((patch, spans)) = self.spans_of(&part) {
            return match self.points_of_share(&part, rule) {
                Some(points) => self.share_of_spans(patch, spans, &points, gradient, room),
                None => self.part_of_spans(patch, spans, part, rule, gradient, room),
            };
        }
        if let (Some(net), None) = (net, &gradient) {
            return self.part_of_net(net, part, rule, room);
        }
        self.part_by_stencils(part, rule, gradient).unwrap_or_else(|error| {
            room.failed.get_or_insert(error);
            Sum::default()
        })
    }

    fn part_of_net(&self, net: Net<'_>, part: Part, rule: usize, room: &mut Room) -> Sum {
        let shares = [net.shares(0, part.u), net.shares(1, part.v)];
        let degrees = net.sides.map(|side| side.degree);
        let (other, own);
        let nodes = if degrees == self.degrees {
            &self.rules[rule]
        } else {
            other = Nodes::of_rule(degrees, rule);
            &other
        };
        let Lines([along_u, along_v]) = if degrees == self.degrees && shares == [(0.0, 1.0); 2] {
            &self.lines[rule]
        } else {
            own = Lines::new(degrees, nodes, shares);
            &own
        };
        let mut sum = Sum::default();
        let count = nodes.v.0.len().min(MOST_NODES);
        let with_creases = rule == WITH_ENDS;
        let row = &mut room.row;
        let mut before = [[0.0; MOST_NODES]; 3];
        let mut sizes = [0.0; MOST_NODES];
        for (x, (_, [wx, ux @ ..])) in nodes.u.0.iter().enumerate() {
            row.fill(net.points, [along_u, along_v], x, false);
            let [nx, ny, nz] = row.normals.each_ref().map(|all| &all[..count]);
            for (k, size) in sizes[..count].iter_mut().enumerate() {
                *size = (nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k]).sqrt();
            }
            let mut sums = [0.0; 3];
            for (size, (_, weights)) in sizes.iter().zip(&nodes.v.0) {
                (0..3).for_each(|a| sums[a] += weights[a] * size);
            }
            sum.area += wx * sums[0];
            for k in 0..2 {
                sum.rough_along[0][k] += ux[k] * sums[0];
                sum.rough_along[1][k] += wx * sums[1 + k];
            }
            if with_creases {
                sum.creased |= creased(&row.normals, &before, count);
                before = row.normals;
            }
        }
        // By shares of the cell's sides all is as many times as large as by its parameters.
        let length = |(a, b): (f64, f64)| b - a;
        sum.area *= length(shares[0]) * length(shares[1]);
        let cell: f64 = net.sides.iter().map(|side| side.end - side.start).product();
        sum.rough_along.iter_mut().flatten().for_each(|rough| *rough /= cell);
        sum
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

    /// The points of a rule on a part of which loops leave something, with their weights; `None` of one that counts as a whole.
    fn points_of_share(&self, part: &Part, rule: usize) -> Option<Vec<(Location, f64)>> {
        let (number, parts) = part.share?;
        let (cell, share) = self.counted.get(number)?;
        let ([p, q], extra) = (self.degrees, EXTRA[rule.min(1)]);
        // Where all is smooth, rules of more points get nearer by far than as many points of the same rule on more parts.
        let (times, parts) = raised(p.max(q) + EXTRA[1], parts);
        Some(share.gauss_points(cell, [times * (p + extra), times * (q + extra)], parts))
    }

    fn part_by_stencils(&self, part: Part, rule: usize, mut gradient: Option<&mut [Vector]>) -> Result<Sum> {
        if let Some(points) = self.points_of_share(&part, rule) {
            let mut sum = Sum::default();
            for (at, weight) in points {
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
}

/// By how much the points of a rule of `count` points are raised, and on how many parts it is then used, so that there are `fineness` times as many.
fn raised(count: usize, fineness: usize) -> (usize, usize) {
    let mut times = 1;
    while 2 * times <= fineness && 2 * times * count <= MOST_RAISED {
        times *= 2;
    }
    (times, fineness / times)
}
