//! What a rule finds on a part of a tensor-product spline: products of basis functions, no stencils.

use loftsman_kernel::Vector;
use loftsman_kernel::shape::{Location, Patch};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::space::MAX_ORDER;

use super::Measure;
use super::nodes::Nodes;
use super::part::Part;
use super::sums::{Room, Sum};
use super::turns::Turns;

/// A patch of two parameters.
#[derive(Clone, Copy)]
pub(super) struct Spans<'s> {
    u: &'s Space,
    v: &'s Space,
    weights: Option<&'s [f64]>,
    first: usize,
}

impl<'s> Spans<'s> {
    pub(super) fn of(patch: &Patch<'s>) -> Option<Self> {
        let (splines, first) = (patch.splines, patch.first);
        Some(Self { u: splines.u, v: splines.v?, weights: splines.weights, first })
    }

    /// Its spans, each with the box of parameters that it is.
    pub(super) fn all(&self) -> impl Iterator<Item = ([usize; 2], (f64, f64), (f64, f64))> + use<'s> {
        let Self { u, v, .. } = *self;
        let ends = |space: &Space, span: usize| (space.flat()[span], space.flat()[span + 1]);
        u.spans().flat_map(move |i| v.spans().map(move |j| ([i, j], ends(u, i), ends(v, j))))
    }

    /// The span of each direction in which a box of parameters lies, if it lies in one.
    pub(super) fn around(&self, u: (f64, f64), v: (f64, f64)) -> Option<[usize; 2]> {
        let span = |space: &Space, (a, b): (f64, f64)| {
            let span = space.span(0.5 * a + 0.5 * b);
            (space.flat().get(span)? <= &a && &b <= space.flat().get(span + 1)?).then_some(span)
        };
        Some([span(self.u, u)?, span(self.v, v)?])
    }

    /// Of the functions of two spans, the control vertex of number `(i, j)`, and its place among the weights.
    fn vertex(&self, spans: [usize; 2], i: usize, j: usize) -> (usize, usize) {
        let row = self.u.vertex(spans[0] - self.u.degree() + i);
        let own = row * self.v.len() + self.v.vertex(spans[1] - self.v.degree() + j);
        (self.first + own, own)
    }

    fn weight(&self, own: usize) -> f64 {
        self.weights.map_or(1.0, |weights| weights[own])
    }
}

/// A homogeneous point of a patch and its two derivatives, and what follows from them.
struct Place {
    su: [f64; 4],
    sv: [f64; 4],
    w: f64,
    tu: [f64; 3],
    tv: [f64; 3],
    normal: [f64; 3],
    size: f64,
}

impl Place {
    fn new(s: [f64; 4], su: [f64; 4], sv: [f64; 4]) -> Self {
        let w = s[3];
        let project = |d: [f64; 4]| [0, 1, 2].map(|a| (d[a] - s[a] / w * d[3]) / w);
        let (tu, tv) = (project(su), project(sv));
        let normal = cross(tu, tv);
        let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        Self { su, sv, w, tu, tv, normal, size }
    }

    /// How the size of the normal, times a weight, depends on the homogeneous point, its `u` and its `v` derivative.
    fn gradient(&self, weight: f64) -> [[f64; 3]; 3] {
        let unit = self.normal.map(|n| n / self.size);
        let weight = weight / self.w;
        let [by_u, by_v] = [cross(self.tv, unit), cross(unit, self.tu)].map(|way| way.map(|x| x * weight));
        let by_point = [0, 1, 2].map(|a| -(by_u[a] * self.su[3] + by_v[a] * self.sv[3]) / self.w);
        [by_point, by_u, by_v]
    }
}

impl<'s> Measure<'s> {
    /// The patch and the spans of a part, where its surface is a tensor-product spline there.
    pub(super) fn spans_of(&self, part: &Part) -> Option<(Spans<'s>, [usize; 2])> {
        let (patch, spans) = part.spans?;
        Some(((*self.patches.get(patch)?)?, spans))
    }

    pub(super) fn part_of_spans(
        &self,
        patch: Spans<'_>,
        spans: [usize; 2],
        part: Part,
        rule: usize,
        mut gradient: Option<&mut [Vector]>,
        room: &mut Room,
    ) -> Sum {
        let Spans { u: su, v: sv, .. } = patch;
        let (p, q) = (su.degree(), sv.degree());
        let points = self.points;
        let [bu, bv] = &mut room.bases;
        bu.enter(su, spans[0]);
        bv.enter(sv, spans[1]);
        let Nodes { u: along_u, v: along_v } = &self.rules[rule];
        let (length_u, length_v) = (part.u.1 - part.u.0, part.v.1 - part.v.0);
        let (mut sum, mut turns) = (Sum::default(), Turns::default());
        for (x, [wx, ux @ ..]) in &along_u.0 {
            bu.at(part.u.0 + length_u * x);
            // Combined along u: homogeneous points and derivatives for each of the q + 1 columns.
            let mut line = [[[0.0; 4]; 2]; MAX_ORDER];
            for (j, line) in line.iter_mut().enumerate().take(q + 1) {
                for i in 0..=p {
                    let (at, own) = patch.vertex(spans, i, j);
                    let w = patch.weight(own);
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
                let place = Place::new(s, su_, sv_);
                turns.see(j, place.normal);
                sum.area += wx * wy * place.size;
                for k in 0..2 {
                    sum.rough_along[0][k] += ux[k] * wy * place.size;
                    sum.rough_along[1][k] += wx * vy[k] * place.size;
                }
                if !(gradient.is_some() && place.size > 0.0) {
                    continue;
                }
                // The point, its u and its v derivative depend on the vertices as `s`, `su_` and `sv_` do: summed over this
                // line first, so that a point costs the vertices of one direction, not of both.
                let [by_point, by_u, by_v] = place.gradient(wx * length_u * wy * length_v);
                for (j, sums) in sums.iter_mut().enumerate().take(q + 1) {
                    for a in 0..3 {
                        sums[0][a] += by_point[a] * bv.values[j] + by_v[a] * bv.slopes[j];
                        sums[1][a] += by_u[a] * bv.values[j];
                    }
                }
            }
            let Some(gradient) = gradient.as_deref_mut() else { continue };
            for i in 0..=p {
                for (j, [by_value, by_slope]) in sums.iter().enumerate().take(q + 1) {
                    let (at, own) = patch.vertex(spans, i, j);
                    let w = patch.weight(own);
                    for a in 0..3 {
                        gradient[at][a] += w * (by_value[a] * bu.values[i] + by_slope[a] * bu.slopes[i]);
                    }
                }
            }
        }
        sum.area *= length_u * length_v;
        sum.creased = turns.creased;
        sum
    }

    /// The same at places one by one, of what loops leave of a part.
    pub(super) fn share_of_spans(
        &self,
        patch: Spans<'_>,
        spans: [usize; 2],
        places: &[(Location, f64)],
        mut gradient: Option<&mut [Vector]>,
        room: &mut Room,
    ) -> Sum {
        let (p, q) = (patch.u.degree(), patch.v.degree());
        let net: Vec<(usize, f64, [f64; 4])> = (0..=p)
            .flat_map(|i| (0..=q).map(move |j| (i, j)))
            .map(|(i, j)| {
                let (at, own) = patch.vertex(spans, i, j);
                let (w, point) = (patch.weight(own), self.points[at]);
                (at, w, [point.x * w, point.y * w, point.z * w, w])
            })
            .collect();
        let [bu, bv] = &mut room.bases;
        bu.enter(patch.u, spans[0]);
        bv.enter(patch.v, spans[1]);
        let mut sum = Sum::default();
        for &(at, weight) in places {
            let (Location::Surface(u, v) | Location::Face(_, u, v)) = at else { continue };
            bu.at(u);
            bv.at(v);
            let (mut s, mut su, mut sv) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            for (i, row) in net.chunks(q + 1).enumerate() {
                let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
                for (j, (_, _, h)) in row.iter().enumerate() {
                    for a in 0..4 {
                        value[a] += bv.values[j] * h[a];
                        slope[a] += bv.slopes[j] * h[a];
                    }
                }
                for a in 0..4 {
                    s[a] += bu.values[i] * value[a];
                    su[a] += bu.slopes[i] * value[a];
                    sv[a] += bu.values[i] * slope[a];
                }
            }
            let place = Place::new(s, su, sv);
            sum.area += weight * place.size;
            let Some(gradient) = gradient.as_deref_mut().filter(|_| place.size > 0.0) else { continue };
            let [by_point, by_u, by_v] = place.gradient(weight);
            for (i, row) in net.chunks(q + 1).enumerate() {
                for (j, (at, w, _)) in row.iter().enumerate() {
                    let [value, along, across] = [
                        bu.values[i] * bv.values[j],
                        bu.slopes[i] * bv.values[j],
                        bu.values[i] * bv.slopes[j],
                    ];
                    for a in 0..3 {
                        gradient[*at][a] += w * (by_point[a] * value + by_u[a] * along + by_v[a] * across);
                    }
                }
            }
        }
        sum
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
