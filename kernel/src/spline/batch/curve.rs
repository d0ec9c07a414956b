//! Many parameters on a curve.

use super::bernstein::Bernstein;
use super::cursor::Cursor;
use super::powers::Powers;
use super::{in_blocks, same_length};
use crate::error::{Error, Result};
use crate::spline::Curve;
use crate::spline::space::MAX_ORDER;
use crate::{Point, Vector};

/// A form of one span in which many parameters are cheap.
pub(super) trait Local {
    /// Parameters on one span from which taking the span pays.
    const PAYS: usize;

    /// Takes a span of a curve.
    fn take(&mut self, curve: &Curve, span: usize);

    /// Points and derivatives, as many as the form was made for, at parameters of the span it has taken.
    fn run<T: From<[f64; 3]>>(&self, us: &[f64], out: &mut [T]);
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
        in_blocks(us, out, 1, |us, out| self.block_of::<1, Point>(us, 1, out))
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

    /// One block of derivatives, in the form that suits the degree.
    fn block(&self, us: &[f64], orders: usize, out: &mut [Vector]) -> Result<()> {
        match orders {
            1 => self.block_of::<1, Vector>(us, orders, out),
            2 => self.block_of::<2, Vector>(us, orders, out),
            3 => self.block_of::<3, Vector>(us, orders, out),
            _ if self.weights().is_some() => {
                self.in_runs(us, orders, out, Bernstein::<4>::new(self.degree(), orders))
            }
            _ => self.in_runs(us, orders, out, Bernstein::<3>::new(self.degree(), orders)),
        }
    }

    fn block_of<const K: usize, T: From<[f64; 3]>>(
        &self,
        us: &[f64],
        orders: usize,
        out: &mut [T],
    ) -> Result<()> {
        match (self.degree(), self.weights().is_some()) {
            (1, false) => self.in_runs(us, orders, out, Powers::<2, 3, K>::new()),
            (2, false) => self.in_runs(us, orders, out, Powers::<3, 3, K>::new()),
            (3, false) => self.in_runs(us, orders, out, Powers::<4, 3, K>::new()),
            (4, false) => self.in_runs(us, orders, out, Powers::<5, 3, K>::new()),
            (5, false) => self.in_runs(us, orders, out, Powers::<6, 3, K>::new()),
            (1, true) => self.in_runs(us, orders, out, Powers::<2, 4, K>::new()),
            (2, true) => self.in_runs(us, orders, out, Powers::<3, 4, K>::new()),
            (3, true) => self.in_runs(us, orders, out, Powers::<4, 4, K>::new()),
            (4, true) => self.in_runs(us, orders, out, Powers::<5, 4, K>::new()),
            (5, true) => self.in_runs(us, orders, out, Powers::<6, 4, K>::new()),
            (_, false) => self.in_runs(us, orders, out, Bernstein::<3>::new(self.degree(), orders)),
            (_, true) => self.in_runs(us, orders, out, Bernstein::<4>::new(self.degree(), orders)),
        }
    }

    /// Runs of parameters on the same span are found; long ones are evaluated in the span's local form, short ones
    /// one by one.
    fn in_runs<F: Local, T: From<[f64; 3]>>(
        &self,
        us: &[f64],
        orders: usize,
        out: &mut [T],
        mut form: F,
    ) -> Result<()> {
        let mut cursor = Cursor::new(self.space());
        let mut row = [Vector::zeros(); MAX_ORDER];
        let mut start = 0;
        while let Some(&first) = us.get(start) {
            let mut u = cursor.find(first)?;
            let run = cursor.run(&us[start..]).max(1);
            let (us, out) = (&us[start..start + run], &mut out[start * orders..(start + run) * orders]);
            start += run;
            if run >= F::PAYS {
                form.take(self, cursor.span);
                form.run(us, out);
                continue;
            }
            for (i, out) in out.chunks_exact_mut(orders).enumerate() {
                if i > 0 {
                    u = us[i];
                }
                if orders == 1 {
                    out[0] = T::from(self.point_on(cursor.span, u).into());
                    continue;
                }
                self.derivatives_on(cursor.span, u, &mut row[..orders]);
                for (out, value) in out.iter_mut().zip(&row) {
                    *out = T::from((*value).into());
                }
            }
        }
        Ok(())
    }
}
