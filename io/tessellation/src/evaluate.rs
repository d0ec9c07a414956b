//! Points and first derivatives of a surface on a grid, a row of it at a time.

use loftsman_kernel::Vector;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::space::MAX_ORDER;
use nalgebra::Vector4;

use crate::fineness::Frame;

/// A point with its first derivatives, in the shape's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jet {
    pub(crate) point: Vector,
    /// By `u`, times the length of the domain along `u`.
    pub(crate) u: Vector,
    /// By `v`, times the length of the domain along `v`.
    pub(crate) v: Vector,
}

/// The surface with its control points in the frame, ready for rows of points.
pub(crate) struct Evaluator<'a> {
    surface: &'a Surface,
    /// Homogeneous control points in the frame, `(w x, w)`, columns unrolled.
    net: Vec<Vector4<f64>>,
    columns: usize,
}

/// What a line `u = const` needs: the surface contracted along `u`, and its derivative by `u`.
pub(crate) struct Row {
    values: Vec<Vector4<f64>>,
    slopes: Vec<Vector4<f64>>,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(surface: &'a Surface, frame: &Frame) -> Self {
        let v = surface.v();
        let columns = v.unrolled_len();
        let mut net = Vec::with_capacity(surface.u().len() * columns);
        for row in 0..surface.u().len() {
            for column in 0..columns {
                let vertex = row * v.len() + v.vertex(column);
                let weight = surface.weights().map_or(1.0, |w| w[vertex]);
                let local = (surface.points()[vertex] - frame.centre) / frame.size;
                net.push((local * weight).push(weight));
            }
        }
        Self { surface, net, columns }
    }

    /// Room for one row.
    pub(crate) fn row(&self) -> Row {
        Row { values: vec![Vector4::zeros(); self.columns], slopes: vec![Vector4::zeros(); self.columns] }
    }

    /// Contracts the net along `u` at a parameter of a span (its end too, seen from within). `O(p · columns)`.
    pub(crate) fn prepare(&self, span: usize, u: f64, row: &mut Row) {
        let space = self.surface.u();
        let p = space.degree();
        let (mut value, mut slope) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        space.basis_into(span, u, 0, &mut value);
        space.basis_into(span, u, 1, &mut slope);
        row.values.fill(Vector4::zeros());
        row.slopes.fill(Vector4::zeros());
        let length = space.length();
        for i in 0..=p {
            let start = space.vertex(span - p + i) * self.columns;
            let line = &self.net[start..start + self.columns];
            for ((h, out), out_slope) in line.iter().zip(&mut row.values).zip(&mut row.slopes) {
                *out += h * value[i];
                *out_slope += h * (slope[i] * length);
            }
        }
    }

    /// The point and first derivatives at a parameter of a span of `v`. `O(q)`.
    pub(crate) fn at(&self, row: &Row, span: usize, v: f64) -> Jet {
        let space = self.surface.v();
        let q = space.degree();
        let (mut value, mut slope) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        space.basis_into(span, v, 0, &mut value);
        space.basis_into(span, v, 1, &mut slope);
        let length = space.length();
        let (mut a, mut au, mut av) = (Vector4::zeros(), Vector4::zeros(), Vector4::zeros());
        for j in 0..=q {
            let h = row.values[span - q + j];
            a += h * value[j];
            au += row.slopes[span - q + j] * value[j];
            av += h * (slope[j] * length);
        }
        if self.surface.weights().is_none() {
            return Jet { point: a.xyz(), u: au.xyz(), v: av.xyz() };
        }
        let point = a.xyz() / a.w;
        let u = (au.xyz() - point * au.w) / a.w;
        let v = (av.xyz() - point * av.w) / a.w;
        Jet { point, u, v }
    }
}
