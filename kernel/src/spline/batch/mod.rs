//! Evaluation in batches: many parameters on a curve, grids of parameters on a surface.
//!
//! Point by point, most of the time goes into finding the span and into the basis functions. In a batch both are
//! paid once a span (curves) or once a row and a column (surfaces). Work is cut into blocks of fixed size, with or
//! without threads, so that the result is the same to the bit whatever the number of threads.

mod cursor;
mod powers;

use cursor::Cursor;
use powers::Powers;

use super::space::MAX_ORDER;
use super::{Curve, Surface};
use crate::error::{Error, Result};
use crate::{Point, Vector};

/// Parameters in one block of work.
const BLOCK: usize = 1 << 14;
/// Parameters that Horner's rule takes at once: their sums are vectors that the compiler knows to vectorise.
const LANES: usize = 4;
/// Parameters in a row on one span from which the expansion pays.
const PAYS: usize = 3;

/// Point, first derivatives and unit normal of a surface, in the order of a grid (see [`Surface::grid_frames_into`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The point.
    pub point: Point,
    /// The derivative by `u`.
    pub du: Vector,
    /// The derivative by `v`.
    pub dv: Vector,
    /// `du × dv` made a unit vector; zero where they are parallel or vanish (a pole, for one).
    pub normal: Vector,
}

impl Sample {
    /// A sample of zeros, to make room with.
    pub const ZERO: Self = Self {
        point: Point::new(0.0, 0.0, 0.0),
        du: Vector::new(0.0, 0.0, 0.0),
        dv: Vector::new(0.0, 0.0, 0.0),
        normal: Vector::new(0.0, 0.0, 0.0),
    };
}

impl Curve {
    /// The points at many parameters, in the order given; fastest where they ascend. `O(m)` for `m` parameters in
    /// runs on one span, `O(m (p² + log n))` at worst.
    ///
    /// Agrees with [`point`](Self::point) to rounding (1e-14 of the size of the curve).
    ///
    /// # Errors
    /// When the slices differ in length or a parameter is outside the domain; `out` then holds some of the points.
    pub fn points_into(&self, us: &[f64], out: &mut [Point]) -> Result<()> {
        same_length(us.len(), out.len())?;
        in_blocks(us, out, 1, |us, out| self.block(us, 1, out))
    }

    /// The points and derivatives `C, C', …` at many parameters: `orders` vectors a parameter, one parameter after
    /// another. Costs and agreement as for [`points_into`](Self::points_into), times `orders`; the `k`-th derivative
    /// is right relative to the size of the curve over the `k`-th power of the span's length.
    ///
    /// # Errors
    /// When `out` is not `us.len() * orders` long, `orders` is beyond 26, or a parameter is outside the domain.
    pub fn derivatives_many_into(&self, us: &[f64], orders: usize, out: &mut [Vector]) -> Result<()> {
        if orders == 0 || orders > MAX_ORDER {
            return Err(Error::DerivativeOrder { order: orders.wrapping_sub(1) });
        }
        same_length(us.len().saturating_mul(orders), out.len())?;
        in_blocks(us, out, orders, |us, out| self.block(us, orders, out))
    }

    /// One block: runs of parameters on the same span are found, and each run is evaluated as it pays best.
    fn block<T: From<[f64; 3]>>(&self, us: &[f64], orders: usize, out: &mut [T]) -> Result<()> {
        match (self.degree(), self.weights().is_some()) {
            (1, false) => self.block_of::<2, 3, T>(us, orders, out),
            (2, false) => self.block_of::<3, 3, T>(us, orders, out),
            (3, false) => self.block_of::<4, 3, T>(us, orders, out),
            (4, false) => self.block_of::<5, 3, T>(us, orders, out),
            (5, false) => self.block_of::<6, 3, T>(us, orders, out),
            (1, true) => self.block_of::<2, 4, T>(us, orders, out),
            (2, true) => self.block_of::<3, 4, T>(us, orders, out),
            (3, true) => self.block_of::<4, 4, T>(us, orders, out),
            (4, true) => self.block_of::<5, 4, T>(us, orders, out),
            (5, true) => self.block_of::<6, 4, T>(us, orders, out),
            _ => self.one_by_one(us, orders, out),
        }
    }

    fn block_of<const N: usize, const L: usize, T: From<[f64; 3]>>(
        &self,
        us: &[f64],
        orders: usize,
        out: &mut [T],
    ) -> Result<()> {
        let mut cursor = Cursor::new(self.space());
        let mut start = 0;
        while let Some(&first) = us.get(start) {
            let u = cursor.find(first)?;
            let run = cursor.run(&us[start..]).max(1);
            let (us, out) = (&us[start..start + run], &mut out[start * orders..(start + run) * orders]);
            start += run;
            if run < if orders == 1 { PAYS } else { 2 } || orders > 3 {
                let mut row = [Vector::zeros(); MAX_ORDER];
                for (i, out) in out.chunks_exact_mut(orders).enumerate() {
                    // The first parameter may have been wrapped.
                    let u = if i == 0 { u } else { us[i] };
                    if orders == 1 {
                        out[0] = T::from(self.point_on(cursor.span, u).into());
                        continue;
                    }
                    self.derivatives_on(cursor.span, u, &mut row[..orders]);
                    for (out, value) in out.iter_mut().zip(&row) {
                        *out = T::from((*value).into());
                    }
                }
                continue;
            }
            let powers = Powers::<N, L>::new(self, cursor.span);
            match orders {
                1 => powers.run::<1, T>(us, out),
                2 => powers.run::<2, T>(us, out),
                _ => powers.run::<3, T>(us, out),
            }
        }
        Ok(())
    }

    fn one_by_one<T: From<[f64; 3]>>(&self, us: &[f64], orders: usize, out: &mut [T]) -> Result<()> {
        let mut cursor = Cursor::new(self.space());
        let mut row = [Vector::zeros(); MAX_ORDER];
        for (&u, out) in us.iter().zip(out.chunks_exact_mut(orders)) {
            let u = cursor.find(u)?;
            self.derivatives_on(cursor.span, u, &mut row[..orders]);
            for (out, value) in out.iter_mut().zip(&row) {
                *out = T::from((*value).into());
            }
        }
        Ok(())
    }
}

impl Surface {
    /// The points on the grid `us × vs`, all of `vs` for the first `u`, then for the next. The sum over the net is
    /// taken in two steps: one row of vertices a `u`, then `q + 1` of them a point. `O(|us| n_v p + |us| |vs| q)`.
    ///
    /// # Errors
    /// When `out` is not `us.len() * vs.len()` long or a parameter is outside the domain.
    pub fn grid_into(&self, us: &[f64], vs: &[f64], out: &mut [Point]) -> Result<()> {
        self.contract::<false, Point>(us, vs, out, &|[[x, y, z, w], ..]| Point::new(x / w, y / w, z / w))
    }

    /// Points, first derivatives and unit normals on the grid `us × vs`, as [`grid_into`](Self::grid_into).
    ///
    /// # Errors
    /// As for [`grid_into`](Self::grid_into).
    pub fn grid_frames_into(&self, us: &[f64], vs: &[f64], out: &mut [Sample]) -> Result<()> {
        self.contract::<true, Sample>(us, vs, out, &frame)
    }

    fn contract<const DERIVATIVES: bool, T: Send>(
        &self,
        us: &[f64],
        vs: &[f64],
        out: &mut [T],
        make: &(impl Fn([[f64; 4]; 3]) -> T + Sync),
    ) -> Result<()> {
        same_length(us.len().saturating_mul(vs.len()), out.len())?;
        let (space, q, columns) = (self.v(), self.v().degree(), self.v().len());
        let mut starts = Vec::with_capacity(vs.len());
        let mut values = vec![[0.0; 2]; vs.len() * (q + 1)];
        let (mut row, mut slope) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
        for (&v, values) in vs.iter().zip(values.chunks_exact_mut(q + 1)) {
            let v = space.locate(v)?;
            let span = space.span(v);
            space.basis_into(span, v, 0, &mut row);
            space.basis_into(span, v, 1, &mut slope);
            starts.push(span - q);
            for (target, pair) in values.iter_mut().zip(row.iter().zip(&slope)) {
                *target = [*pair.0, *pair.1];
            }
        }
        in_blocks(us, out, vs.len(), |us, out| {
            let p = self.u().degree();
            // Homogeneous rows, unrolled along v, so that no point has to wrap an index.
            let mut lines = vec![[[0.0; 4]; 2]; space.unrolled_len()];
            let (mut row, mut slope) = ([0.0; MAX_ORDER], [0.0; MAX_ORDER]);
            for (&u, out) in us.iter().zip(out.chunks_exact_mut(vs.len().max(1))) {
                let u = self.u().locate(u)?;
                let span = self.u().span(u);
                self.u().basis_into(span, u, 0, &mut row);
                self.u().basis_into(span, u, 1, &mut slope);
                lines.fill([[0.0; 4]; 2]);
                for i in 0..=p {
                    let first = self.u().vertex(span - p + i) * columns;
                    for (k, line) in lines.iter_mut().enumerate() {
                        let index = first + space.vertex(k);
                        let (point, w) = (self.points()[index], self.weights().map_or(1.0, |w| w[index]));
                        let homogeneous = [point.x * w, point.y * w, point.z * w, w];
                        for (lane, h) in homogeneous.iter().enumerate() {
                            line[0][lane] += row[i] * h;
                            if DERIVATIVES {
                                line[1][lane] += slope[i] * h;
                            }
                        }
                    }
                }
                for ((&start, values), out) in starts.iter().zip(values.chunks_exact(q + 1)).zip(out) {
                    let mut sums = [[0.0; 4]; 3];
                    for ([value, slope], line) in values.iter().zip(&lines[start..]) {
                        for lane in 0..4 {
                            sums[0][lane] += value * line[0][lane];
                            if DERIVATIVES {
                                sums[1][lane] += value * line[1][lane];
                                sums[2][lane] += slope * line[0][lane];
                            }
                        }
                    }
                    if self.weights().is_none() {
                        // The weights of a polynomial surface are 1 exactly, not to rounding.
                        (sums[0][3], sums[1][3], sums[2][3]) = (1.0, 0.0, 0.0);
                    }
                    *out = make(sums);
                }
            }
            Ok(())
        })
    }
}

fn frame([a, au, av]: [[f64; 4]; 3]) -> Sample {
    let over = 1.0 / a[3];
    let point = Vector::new(a[0], a[1], a[2]) * over;
    let slope = |d: [f64; 4]| (Vector::new(d[0], d[1], d[2]) - point * d[3]) * over;
    let (du, dv) = (slope(au), slope(av));
    Sample { point: point.into(), du, dv, normal: unit_cross(&du, &dv).unwrap_or_default() }
}

/// The direction of `a × b`, unless the two are parallel to rounding or one vanishes. Lengths are divided out first:
/// the product of two tiny (or huge) vectors would leave the range of numbers.
pub(super) fn unit_cross(a: &Vector, b: &Vector) -> Option<Vector> {
    let (la, lb) = (a.amax(), b.amax());
    if !(la > 0.0 && lb > 0.0 && la.is_finite() && lb.is_finite()) {
        return None;
    }
    let cross = (a / la).cross(&(b / lb));
    let length = cross.norm();
    (length > 1e-14).then(|| cross / length)
}

fn same_length(expected: usize, found: usize) -> Result<()> {
    if expected == found {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "the batch gives {expected} results and there is room for {found}: make both equal"
    )))
}

/// `work` on blocks of parameters and the parts of `out` that belong to them (`each` entries a parameter).
fn in_blocks<T: Send>(
    us: &[f64],
    out: &mut [T],
    each: usize,
    work: impl Fn(&[f64], &mut [T]) -> Result<()> + Sync,
) -> Result<()> {
    let block = (BLOCK / each.max(1)).max(1);
    #[cfg(feature = "parallel")]
    if us.len() > 2 * block {
        use rayon::prelude::*;
        return us
            .par_chunks(block)
            .zip(out.par_chunks_mut((block * each).max(1)))
            .try_for_each(|(us, out)| work(us, out));
    }
    for (us, out) in us.chunks(block).zip(out.chunks_mut((block * each).max(1))) {
        work(us, out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::spline::testing::{any_curve, any_surface};

    fn many(a: f64, b: f64, count: usize) -> Vec<f64> {
        (0..count)
            .map(|i| if i + 1 == count { b } else { a + (b - a) * i as f64 / (count - 1) as f64 })
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_batch_on_a_curve_is_what_single_points_are(curve in any_curve(), backwards in any::<bool>()) {
            let (a, b) = curve.domain();
            let mut us = many(a, b, 200);
            if backwards {
                us.reverse();
            }
            let size = curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
            let shortest = curve.space().breakpoints().windows(2).map(|w| w[1] - w[0]).fold(b - a, f64::min);
            let mut points = vec![Point::origin(); us.len()];
            curve.points_into(&us, &mut points).unwrap();
            let mut rows = vec![Vector::zeros(); us.len() * 3];
            curve.derivatives_many_into(&us, 3, &mut rows).unwrap();
            for (i, &u) in us.iter().enumerate() {
                prop_assert!((points[i] - curve.point(u).unwrap()).norm() <= 2e-14 * size);
                for (order, row) in rows[3 * i..3 * i + 3].iter().enumerate() {
                    let exact = curve.derivative(u, order).unwrap();
                    // Weights from 0.2 to 5 and degree p multiply what rounding does by at most this.
                    let scale = size * (60.0 * curve.degree() as f64 / shortest).powi(order as i32);
                    prop_assert!((row - exact).norm() <= 1e-13 * scale, "order {order} at {u}: {row} {exact}");
                }
            }
        }

        #[test]
        fn a_grid_is_what_single_points_are(surface in any_surface()) {
            let (us, vs) = (surface.u().domain(), surface.v().domain());
            let (us, vs) = (many(us.0, us.1, 7), many(vs.0, vs.1, 9));
            let mut samples = vec![Sample::ZERO; 63];
            surface.grid_frames_into(&us, &vs, &mut samples).unwrap();
            let mut points = vec![Point::origin(); 63];
            surface.grid_into(&us, &vs, &mut points).unwrap();
            for (i, &u) in us.iter().enumerate() {
                for (j, &v) in vs.iter().enumerate() {
                    let (sample, k) = (samples[i * 9 + j], i * 9 + j);
                    prop_assert!((sample.point - surface.point(u, v).unwrap()).norm() < 1e-12);
                    prop_assert!((points[k] - sample.point).norm() < 1e-12);
                    let (du, dv) =
                        (surface.derivative(u, v, 1, 0).unwrap(), surface.derivative(u, v, 0, 1).unwrap());
                    prop_assert!((sample.du - du).norm() <= 1e-11 * (1.0 + du.norm()));
                    prop_assert!((sample.dv - dv).norm() <= 1e-11 * (1.0 + dv.norm()));
                    prop_assert!(sample.normal.dot(&sample.du).abs() <= 1e-9 * (1.0 + du.norm()));
                }
            }
        }
    }

    #[test]
    fn wrong_lengths_and_parameters_are_errors() {
        let curve = crate::spline::testing::line_of(3, 8);
        let mut out = vec![Point::origin(); 2];
        assert!(curve.points_into(&[0.0], &mut out).is_err());
        assert!(curve.points_into(&[0.0, f64::NAN], &mut out).is_err());
        assert!(curve.points_into(&[0.0, 1e9], &mut out).is_err());
        assert!(curve.derivatives_many_into(&[0.0], 0, &mut []).is_err());
        assert!(curve.derivatives_many_into(&[0.0], 1000, &mut []).is_err());
        curve.points_into(&[], &mut []).unwrap();
    }
}
