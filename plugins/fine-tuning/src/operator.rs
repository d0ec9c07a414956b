//! From the values of α to the control vertices of the tuned curve.

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::solve::Operator;
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::algebra::Function;
use smallvec::{SmallVec, smallvec};

use crate::alpha::check_degree;
use crate::error::Result;
use crate::local::Host;

/// The linear map from the values of α to the control vertices of `∫ α C'`, three coordinates each, and behind them to α's own
/// vertices as a [shape](crate::Scale): a product that is sparse, and a running sum that would be dense if it were stored.
/// `O(n)` a time.
#[derive(Debug)]
pub(crate) struct Tuning {
    /// Where the terms of each coefficient of `α C'` start.
    starts: Vec<u32>,
    unknowns: Vec<u32>,
    /// What each coefficient of the integrand has of each unknown, times its share `(t_{i+p+1} - t_i) / (p + 1)` of the integral.
    terms: Vec<Vector>,
    count: usize,
    /// The space of the tuned curve.
    space: Space,
    /// The one that it is in when it is closed, where that is known beforehand.
    closed: Option<Space>,
}

impl Tuning {
    /// Of a derivative and a space for α. `O(n p³)`.
    pub(crate) fn new(derivative: &Function<Vector>, alpha: &Space) -> Result<Self> {
        check_degree(derivative.space(), alpha)?;
        let product = derivative.space().product(alpha)?;
        let few = alpha.degree() + 1;
        // A periodic integrand is opened, for its integral need not close.
        let own = product.space();
        let opening = if own.is_periodic() && own.degree() > 0 { Some(own.clamping()?) } else { None };
        let integrand = match &opening {
            Some(opening) => opening.to().clone(),
            None if own.is_periodic() => Space::open(0, own.knots().to_vec())?,
            None => own.clone(),
        };
        let (p, t) = (integrand.degree(), integrand.flat());
        let mut knots = Vec::with_capacity(t.len() + 2);
        knots.extend(t.first());
        knots.extend(t);
        knots.extend(t.last());
        let count = integrand.len() * few;
        let mut all = Self {
            starts: Vec::with_capacity(integrand.len() + 1),
            unknowns: Vec::with_capacity(count),
            terms: Vec::with_capacity(count),
            count: alpha.len(),
            space: Space::open(p + 1, knots)?,
            closed: opening.is_some().then(|| Space::periodic(p + 1, own.knots().to_vec())).transpose()?,
        };
        all.starts.push(0);
        let share = |i: usize| (t[i + p + 1] - t[i]) / (p + 1) as f64;
        let Some(opening) = &opening else {
            product.each_with_first(derivative, |unknown, by| {
                let row = all.terms.len() / few;
                all.unknowns.push(unknown as u32);
                all.terms.push(by * share(row));
            });
            all.starts.extend((1..=integrand.len()).map(|row| (row * few) as u32));
            return Ok(all);
        };
        let terms = product.with_first(derivative);
        for i in 0..integrand.len() {
            for (from, w) in opening.row(i) {
                for (unknown, by) in &terms[from * few..(from + 1) * few] {
                    all.unknowns.push(*unknown as u32);
                    all.terms.push(by * (w * share(i)));
                }
            }
            all.starts.push(all.terms.len() as u32);
        }
        Ok(all)
    }

    /// The space of the tuned curve: open, clamped.
    pub(crate) fn space(&self) -> &Space {
        &self.space
    }

    /// The space that a closed curve is in when it is tuned and closed again: of a derivative and an α that are both without a seam.
    pub(crate) fn closed(&self) -> Option<&Space> {
        self.closed.as_ref()
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Vector)> {
        let range = self.starts[i] as usize..self.starts[i + 1] as usize;
        self.unknowns[range.clone()].iter().map(|u| *u as usize).zip(&self.terms[range])
    }

    /// The control vertices of `∫ α C'`, the first of them zero.
    pub(crate) fn vertices(&self, alpha: &[f64]) -> Vec<Vector> {
        let mut all = Vec::with_capacity(self.space.len());
        self.each_vertex(alpha, |v| all.push(v));
        all
    }

    /// The control vertices of the curve and those of α.
    fn apply_to(&self, x: &[f64], curve: &mut [f64], scale: &mut [f64]) {
        let mut places = curve.chunks_exact_mut(3);
        self.each_vertex(x, |v| {
            if let Some(out) = places.next() {
                out.copy_from_slice(v.as_slice());
            }
        });
        for (out, x) in scale.chunks_exact_mut(3).zip(x) {
            out.copy_from_slice(&[*x, 0.0, 0.0]);
        }
    }

    fn apply_transposed_of(&self, curve: &[f64], scale: &[f64], x: &mut [f64]) {
        x.iter_mut().zip(scale.chunks_exact(3)).for_each(|(x, f)| *x = f[0]);
        let mut behind = Vector::zeros();
        for i in (0..self.starts.len() - 1).rev() {
            behind += Vector::new(curve[3 * i + 3], curve[3 * i + 4], curve[3 * i + 5]);
            if behind == Vector::zeros() {
                continue;
            }
            self.row(i).for_each(|(j, by)| x[j] += by.dot(&behind));
        }
    }

    /// Each term of a row over the control vertices: the value of α, what the integrand has of it, and the sum of what the row has from there on, as it is
    /// and of its sizes.
    fn each_term(&self, curve: &[f64], mut put: impl FnMut(usize, &Vector, &Vector, &Vector)) {
        let (mut behind, mut sizes) = (Vector::zeros(), Vector::zeros());
        for i in (0..self.starts.len() - 1).rev() {
            let own = Vector::new(curve[3 * i + 3], curve[3 * i + 4], curve[3 * i + 5]);
            behind += own;
            sizes += own.abs();
            if sizes != Vector::zeros() {
                self.row(i).for_each(|(j, by)| put(j, by, &behind, &sizes));
            }
        }
    }

    /// What becomes of a row over the control vertices as one over α's values.
    fn influence_of(&self, curve: &[f64], scale: &[f64]) -> Influence {
        let mut found: Vec<[f64; 2]> = scale.chunks_exact(3).map(|f| [f[0], f[0].abs()]).collect();
        self.each_term(curve, |j, by, behind, sizes| {
            found[j][0] += by.dot(behind);
            found[j][1] += by.abs().dot(sizes);
        });
        if found.iter().all(|[_, sizes]| *sizes == 0.0) {
            return Influence::Nothing;
        }
        let is_rounding = |[sum, sizes]: &[f64; 2]| sum.abs() <= ROUNDING * sizes;
        if found.iter().all(is_rounding) { Influence::Rounding } else { Influence::Some }
    }

    /// The same in each coordinate, of a row over the control vertices that has all three: rounding is also what is so beside the others, as where the curve is
    /// straight along one of them.
    fn influences_of(&self, curve: &[f64]) -> [Influence; 3] {
        let mut found = vec![[Vector::zeros(); 2]; self.count];
        self.each_term(curve, |j, by, behind, sizes| {
            found[j][0] += by.component_mul(behind);
            found[j][1] += by.abs().component_mul(sizes);
        });
        let largest = found.iter().fold(Vector::zeros(), |m: Vector, [sum, _]| m.sup(&sum.abs()));
        [0, 1, 2].map(|axis| {
            let is_rounding = |[sum, sizes]: &[Vector; 2]| sum[axis].abs() <= ROUNDING * sizes[axis];
            if found.iter().all(|[_, sizes]| sizes[axis] == 0.0) {
                Influence::Nothing
            } else if largest[axis] <= BESIDE * largest.amax() || found.iter().all(is_rounding) {
                Influence::Rounding
            } else {
                Influence::Some
            }
        })
    }

    /// The control vertices alone, one after another; the running sum is compensated.
    fn each_vertex(&self, alpha: &[f64], mut put: impl FnMut(Vector)) {
        let (mut sum, mut lost) = (Vector::zeros(), Vector::zeros());
        put(sum);
        for i in 0..self.starts.len() - 1 {
            let part = self.row(i).fold(Vector::zeros(), |sum, (j, by)| sum + by * alpha[j]) - lost;
            let next = sum + part;
            lost = (next - sum) - part;
            sum = next;
            put(sum);
        }
    }
}

/// The part of the sizes of its terms up to which a sum is rounding.
const ROUNDING: f64 = 1e-12;

/// The part of what α has to say in one coordinate up to which it is rounding in another.
const BESIDE: f64 = 1e-13;

/// What α's values have to say in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Influence {
    /// Nothing: each of its terms is zero.
    Nothing,
    /// Sums of terms that cancel but for rounding: what it asks is so, or not, whatever α is.
    Rounding,
    Some,
}

/// A map from the values of α.
pub(crate) trait FromAlpha: Operator {
    /// What they have to say in a row over what it maps to. `O(n)`.
    fn influence(&self, row: &[f64]) -> Influence;

    /// The same in x, y and z, of a row with entries for all of these. `O(n)`.
    fn influences(&self, row: &[f64]) -> [Influence; 3];
}

impl FromAlpha for Tuning {
    fn influence(&self, row: &[f64]) -> Influence {
        let (curve, scale) = row.split_at(3 * self.space.len());
        self.influence_of(curve, scale)
    }

    fn influences(&self, row: &[f64]) -> [Influence; 3] {
        self.influences_of(&row[..3 * self.space.len()])
    }
}

impl FromAlpha for Hosted {
    fn influence(&self, row: &[f64]) -> Influence {
        let (part, scale) = self.split(row);
        self.part.influence_of(&part, scale)
    }

    fn influences(&self, row: &[f64]) -> [Influence; 3] {
        self.part.influences_of(&self.split(row).0)
    }
}

impl Operator for Tuning {
    fn unknowns(&self) -> usize {
        self.count
    }

    fn columns(&self) -> usize {
        3 * (self.space.len() + self.count)
    }

    fn apply(&self, x: &[f64], d: &mut [f64]) {
        let (curve, scale) = d.split_at_mut(3 * self.space.len());
        self.apply_to(x, curve, scale);
    }

    fn read_back(&self, d: &[f64], x: &mut [f64]) -> bool {
        let own = d.get(3 * self.space.len()..).unwrap_or_default().chunks_exact(3);
        x.iter_mut().zip(own).for_each(|(x, d)| *x = d[0]);
        true
    }

    fn row(&self, column: usize) -> Option<SmallVec<[(usize, f64); 4]>> {
        let behind = column.checked_sub(3 * self.space.len())?;
        Some(if behind % 3 == 0 { smallvec![(behind / 3, 1.0)] } else { SmallVec::new() })
    }

    fn apply_transposed(&self, f: &[f64], x: &mut [f64]) {
        let (curve, scale) = f.split_at(3 * self.space.len());
        self.apply_transposed_of(curve, scale, x);
    }
}

/// The same of a part of a curve: to the control vertices of all of the curve, of which only those inside the part move, then to
/// α's own, then to all of the part, by whose last vertex its end is kept.
#[derive(Debug)]
pub(crate) struct Hosted {
    part: Arc<Tuning>,
    /// The curve's control vertex that each of the part's is, but for the first and the last.
    inner: Vec<usize>,
    /// The number of the curve's control vertices.
    len: usize,
}

impl Hosted {
    pub(crate) fn new(part: Arc<Tuning>, host: &Host) -> Self {
        Self { part, inner: host.inner().to_vec(), len: host.curve().points().len() }
    }

    /// A row as one over the part's control vertices, and over α's own.
    fn split<'f>(&self, row: &'f [f64]) -> (Vec<f64>, &'f [f64]) {
        let (whole, rest) = row.split_at(3 * self.len);
        let (scale, part) = rest.split_at(3 * self.part.count);
        let mut all = part.to_vec();
        for (&k, own) in self.inner.iter().zip(all.chunks_exact_mut(3).skip(1)) {
            own.iter_mut().zip(&whole[3 * k..3 * k + 3]).for_each(|(own, f)| *own += f);
        }
        (all, scale)
    }
}

impl Operator for Hosted {
    fn unknowns(&self) -> usize {
        self.part.count
    }

    fn columns(&self) -> usize {
        3 * self.len + self.part.columns()
    }

    fn apply(&self, x: &[f64], d: &mut [f64]) {
        let (whole, rest) = d.split_at_mut(3 * self.len);
        let (scale, part) = rest.split_at_mut(3 * self.part.count);
        self.part.apply_to(x, part, scale);
        whole.fill(0.0);
        for (&k, moved) in self.inner.iter().zip(part.chunks_exact(3).skip(1)) {
            whole[3 * k..3 * k + 3].copy_from_slice(moved);
        }
    }

    fn read_back(&self, d: &[f64], x: &mut [f64]) -> bool {
        let own = d.get(3 * self.len..).unwrap_or_default().chunks_exact(3);
        x.iter_mut().zip(own).for_each(|(x, d)| *x = d[0]);
        true
    }

    fn row(&self, column: usize) -> Option<SmallVec<[(usize, f64); 4]>> {
        let behind = column.checked_sub(3 * self.len)?;
        let is_scale = behind < 3 * self.part.count;
        is_scale.then(|| if behind % 3 == 0 { smallvec![(behind / 3, 1.0)] } else { SmallVec::new() })
    }

    fn apply_transposed(&self, f: &[f64], x: &mut [f64]) {
        let (part, scale) = self.split(f);
        self.part.apply_transposed_of(&part, scale, x);
    }
}
