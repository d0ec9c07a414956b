//! Linear constraints that a fit holds exactly.

use std::sync::Arc;

use loftsman_kernel::edit::{Axis, Constraint, Edit, EditError, Wanted};
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Equation, Functional, Linearity, Shapes, Store, rows_of};
use loftsman_kernel::measure::measure;
use loftsman_kernel::solve::Sense;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::banded::{Qr, Stencils};
use crate::error::{FitError, Result};
use crate::frame::Frame;

/// More numbers than this in the dense border of constraints are refused (1.6 GB).
const BORDER: usize = 200_000_000;
/// What is left of a row, once the others are taken out, below which it depends on them.
const DEPENDENT: f64 = 1e-10;
/// How far a dependent row may contradict the others, relative to the numbers in it.
const AGREES: f64 = 1e-8;

/// Whether a fit can hold a constraint at all.
fn check(constraint: &Constraint) -> Result<()> {
    let functional = constraint.functional();
    let reason = match constraint.wanted() {
        _ if functional.linearity() != Linearity::Linear => {
            "it is not linear in the control vertices; edit the fitted curve instead"
        }
        _ if !functional.companions().is_empty() => {
            "it holds beside others that stay as they are, and a fit has no curve yet to keep them of; edit the fitted curve \
             instead"
        }
        Wanted::To(_) | Wanted::Hold => return Ok(()),
        Wanted::Keep | Wanted::By(_) | Wanted::Scale(_) => {
            "a fit has no curve yet of which it could be kept or changed: say which value it should have with `to`"
        }
        Wanted::AtLeast(_) | Wanted::AtMost(_) => {
            "a fit holds equations, no bounds; edit or fair the fitted curve instead"
        }
    };
    Err(refused(constraint, reason))
}

fn refused(constraint: &Constraint, reason: &str) -> FitError {
    FitError::Constraint { name: constraint.describe(), reason: reason.into() }
}

/// Why a constraint cannot be asked of the curve.
fn unheld(constraint: &Constraint, error: EditError) -> FitError {
    match error {
        EditError::Geometry(Error::Invalid(reason)) => refused(constraint, &reason),
        EditError::Geometry(error) => FitError::Geometry(error),
        error => refused(constraint, &error.to_string()),
    }
}

/// One scalar equation `Σ a_i·P_i = value`, its coefficients of length 1, in local coordinates.
#[derive(Debug)]
struct Row {
    terms: Vec<(usize, Vector)>,
    value: f64,
    constraint: usize,
}

/// Three equations that share a stencil of neighbouring vertices: they fit into the band.
#[derive(Debug)]
struct Local {
    start: usize,
    values: Vec<f64>,
    value: Vector,
}

/// A constraint as it was imposed: what can be measured on the curve that is handed out.
#[derive(Debug, Clone)]
struct Imposed {
    name: String,
    functional: Arc<dyn Functional>,
    axis: Option<Axis>,
    to: Vec<f64>,
}

/// The equations of all constraints of a fit.
#[derive(Debug, Default)]
pub(crate) struct Held {
    imposed: Vec<Imposed>,
    rows: Vec<Row>,
    local: Vec<Local>,
}

/// What became of the constraints.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Kept {
    /// Each constraint's name and the largest error of its equations, in document units.
    pub residuals: Vec<(String, f64)>,
    /// Constraints that the others imply, at least in part; they hold too.
    pub redundant: Vec<String>,
}

/// The constraints that a curve should meet, and those that others implied.
#[derive(Debug, Clone, Default)]
pub(crate) struct Holding {
    imposed: Vec<Imposed>,
    redundant: Vec<String>,
}

impl Holding {
    /// With those of another piece of the curve.
    pub(crate) fn extend(&mut self, other: Self) {
        self.imposed.extend(other.imposed);
        self.redundant.extend(other.redundant);
    }

    /// Asks the functionals themselves, on the curve that is handed out, in document coordinates.
    ///
    /// # Errors
    /// [`FitError::Missed`] where one misses its value by more than its accuracy allows.
    pub(crate) fn measured(self, curve: &Curve, points: &[Point]) -> Result<Kept> {
        let shapes = Shapes::one(curve);
        let reach = points.iter().fold(0.0_f64, |most, p| most.max(p.coords.amax()));
        let mut residuals = Vec::with_capacity(self.imposed.len());
        for Imposed { name, functional, axis, to } in self.imposed {
            let asked = |k: usize| axis.is_none_or(|axis| axis as usize == k);
            let found = measure(&shapes, functional.as_ref(), Sense::Equal, &to, &asked, reach)?;
            if !found.holds() {
                let verdict = found.verdict();
                return Err(FitError::Missed { name, error: verdict.error, allowed: verdict.allowed });
            }
            residuals.push((name, found.error));
        }
        Ok(Kept { residuals, redundant: self.redundant })
    }
}

impl Held {
    /// Linearizes the constraints on `curve`, which is in document coordinates and near to the fit: directions
    /// to keep and pairs of mirror images are read off it.
    ///
    /// # Errors
    /// When a constraint is not linear, lacks its value, or cannot be asked of a curve.
    pub(crate) fn new(constraints: &[Constraint], curve: &Curve, frame: &Frame) -> Result<Self> {
        let mut held = Self::default();
        if constraints.is_empty() {
            return Ok(held);
        }
        for constraint in constraints {
            check(constraint)?;
        }
        let asked =
            |some: &[Constraint]| some.iter().cloned().fold(Edit::new(curve).smooth(0), Edit::ask).problem();
        let problem = asked(constraints).map_err(|error| {
            let alone = constraints.iter().find(|c| asked(std::slice::from_ref(*c)).is_err());
            unheld(alone.unwrap_or(&constraints[0]), error)
        })?;
        let shapes = problem.shapes();
        for (index, constraint) in problem.constraints().enumerate() {
            let mut store = Store::default();
            rows_of(constraint.functional().as_ref(), &shapes, &mut store.rows(&shapes))?;
            let to = problem.target(index).unwrap_or_default();
            if !held.append(index, constraint.narrowed(), &store, to, frame) {
                return Err(refused(
                    constraint,
                    "it does not depend on the control vertices, or too much to compute with",
                ));
            }
            let (name, functional) = (constraint.describe(), Arc::clone(constraint.functional()));
            held.imposed.push(Imposed { name, functional, axis: constraint.narrowed(), to: to.to_vec() });
        }
        let entries = held.rows.len().saturating_mul(3 * curve.points().len());
        if entries > BORDER {
            return Err(FitError::Request(format!(
                "{} constraint equations on {} control vertices are too many for a fit: hold fewer",
                held.rows.len(),
                curve.points().len()
            )));
        }
        Ok(held)
    }

    /// Appends the equations of one constraint, of one axis where it is narrowed to that; false where one of them has no
    /// coefficients.
    fn append(
        &mut self,
        constraint: usize,
        axis: Option<Axis>,
        store: &Store,
        to: &[f64],
        frame: &Frame,
    ) -> bool {
        let asked = |k: usize| axis.is_none_or(|axis| axis as usize == k);
        let mut to = to.iter().copied();
        let mut next = || to.next().unwrap_or(0.0);
        let origin = frame.leave(Vector::zeros()).coords;
        let usable = |size: f64| size > 0.0 && size.is_finite();
        for equation in store.equations() {
            match equation {
                Equation::Alike { vertices, coefficients, constant } => {
                    let wanted = Vector::new(next(), next(), next()) - constant;
                    let sum: f64 = coefficients.iter().sum();
                    let size = coefficients.iter().map(|c| c * c).sum::<f64>().sqrt();
                    if !usable(size) {
                        return false;
                    }
                    let value = frame.enter_vector(wanted - origin * sum) / size;
                    for axis in (0..3).filter(|k| asked(*k)) {
                        let e = Vector::ith(axis, 1.0 / size);
                        let terms = vertices.iter().zip(coefficients).map(|(&v, &c)| (v, e * c)).collect();
                        self.rows.push(Row { terms, value: value[axis], constraint });
                    }
                    if axis.is_some() {
                        continue;
                    }
                    let values = coefficients.iter().map(|c| c / size).collect();
                    self.local.extend(vertices.first().map(|&start| Local { start, values, value }));
                    if let (Some(local), false) = (self.local.last_mut(), consecutive(vertices)) {
                        // Around the seam of a closed curve: start behind the gap.
                        let gap = vertices.windows(2).position(|w| w[1] > w[0] + 1).unwrap_or(0) + 1;
                        local.start = vertices[gap];
                        local.values.rotate_left(gap);
                    }
                }
                Equation::Coupled { vertices, vectors, constant } => {
                    let size = vectors.iter().map(Vector::norm_squared).sum::<f64>().sqrt();
                    if !usable(size) {
                        return false;
                    }
                    let at_origin: f64 = vectors.iter().map(|a| a.dot(&origin)).sum();
                    let value = frame.enter_length(next() - constant - at_origin) / size;
                    let terms = vertices.iter().zip(vectors).map(|(&v, a)| (v, a / size)).collect();
                    self.rows.push(Row { terms, value, constraint });
                }
            }
        }
        true
    }

    /// Whether there is nothing to hold.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// How far the equations are from holding on a curve that follows the points, all in all: each by the length of
    /// the smallest change of vertices that would meet it. In local coordinates.
    pub(crate) fn pull(&self, rough: &Curve, frame: &Frame) -> f64 {
        let x: Vec<f64> = rough.points().iter().flat_map(|&p| <[f64; 3]>::from(frame.enter(p))).collect();
        self.rows.iter().map(|row| row.defect(&x).abs()).sum()
    }

    /// Adds the constraints that fit into the band to the equations to be met in the least-squares sense. The
    /// answer does not change, because they will hold exactly; but they then also determine vertices that the
    /// data leave open.
    pub(crate) fn augment(&self, matrix: &mut Stencils, rhs: &mut Vec<f64>) {
        for local in &self.local {
            let fits = local.values.len() <= matrix.width()
                && (matrix.is_cyclic() || local.start + local.values.len() <= matrix.columns());
            if fits {
                matrix.push(local.start, &local.values);
                rhs.extend([local.value.x, local.value.y, local.value.z]);
            }
        }
    }

    /// Moves the least-squares solution `x` to the one of least squares among those that meet the constraints.
    ///
    /// With `A = QR` and constraints `C x = d`, `Z = R⁻ᵀCᵀ = UT` orthogonalized column by column, the answer is
    /// `x + R⁻¹ U T⁻ᵀ (d - C x)` (the null-space form of Björck, *Numerical Methods for Least Squares Problems*,
    /// §5.1, on the factor of `A` instead of `AᵀA`). Three steps, the later ones to take the rounding out.
    /// `O(n c (p + c))`.
    ///
    /// # Errors
    /// [`FitError::Conflict`] where a constraint depends on others and contradicts them.
    pub(crate) fn hold(&self, qr: &Qr, x: &mut [f64]) -> Result<Holding> {
        let n = x.len() / 3;
        let mut basis: Vec<Column> = Vec::new();
        // Column j of T: what row `kept[j]` has of each basis vector, and of itself.
        let mut mixing: Vec<Vec<f64>> = Vec::new();
        let (mut kept, mut dependent) = (Vec::new(), Vec::new());
        for (index, row) in self.rows.iter().enumerate() {
            let mut z = Column::new(row, n);
            z.each(|axis| qr.solve_transposed(axis));
            let size = z.dot(&z).sqrt();
            let mut share = vec![0.0; basis.len()];
            // Gram and Schmidt twice is enough (Kahan, Parlett): orthogonal to rounding.
            for _ in 0..2 {
                for (u, share) in basis.iter().zip(&mut share) {
                    let h = u.dot(&z);
                    *share += h;
                    z.subtract(u, h);
                }
            }
            let left = z.dot(&z).sqrt();
            if left.is_nan() || left <= DEPENDENT * size {
                dependent.push((index, share));
                continue;
            }
            z.each(|axis| axis.iter_mut().for_each(|v| *v /= left));
            share.push(left);
            basis.push(z);
            mixing.push(share);
            kept.push(index);
        }
        for step in 0..3 {
            // Tᵀ y = r, forwards.
            let mut y: Vec<f64> = Vec::with_capacity(kept.len());
            for (&index, share) in kept.iter().zip(&mixing) {
                let known: f64 = share.iter().zip(&y).map(|(t, y)| t * y).sum();
                let own = share.last().copied().unwrap_or(1.0);
                y.push((self.rows[index].defect(x) - known) / own);
            }
            if step == 0 {
                self.agree(&dependent, &kept, &mixing, &y, x)?;
            }
            let mut change = Column { axes: std::array::from_fn(|_| vec![0.0; n]) };
            for (u, &y) in basis.iter().zip(&y) {
                change.subtract(u, -y);
            }
            change.each(|axis| qr.solve_upper(axis));
            for (axis, values) in change.axes.iter().enumerate() {
                for (v, d) in values.iter().enumerate() {
                    x[3 * v + axis] += d;
                }
            }
        }
        let mut redundant: Vec<usize> = dependent.iter().map(|&(i, _)| self.rows[i].constraint).collect();
        redundant.dedup();
        let redundant = redundant.into_iter().map(|c| self.imposed[c].name.clone()).collect();
        Ok(Holding { imposed: self.imposed.clone(), redundant })
    }

    /// Whether the dependent rows follow from the kept ones.
    fn agree(
        &self,
        dependent: &[(usize, Vec<f64>)],
        kept: &[usize],
        mixing: &[Vec<f64>],
        y: &[f64],
        x: &[f64],
    ) -> Result<()> {
        for (index, share) in dependent {
            let row = &self.rows[*index];
            let implied: f64 = share.iter().zip(y).map(|(h, y)| h * y).sum();
            let scale: f64 =
                1.0 + row.value.abs() + share.iter().zip(y).map(|(h, y)| (h * y).abs()).sum::<f64>();
            if (implied - row.defect(x)).abs() <= AGREES * scale {
                continue;
            }
            // The combination of kept rows that this one is: T a = h, backwards.
            let mut a = share.clone();
            for j in (0..a.len()).rev() {
                a[j] /= mixing[j][j];
                let value = a[j];
                for (i, a) in a[..j].iter_mut().enumerate() {
                    *a -= mixing[j][i] * value;
                }
            }
            let largest = a.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let mut with: Vec<String> = Vec::new();
            for (&k, a) in kept.iter().zip(&a) {
                let name = &self.imposed[self.rows[k].constraint].name;
                if a.abs() > 1e-6 * largest && !with.contains(name) {
                    with.push(name.clone());
                }
            }
            // Two that are called alike are told apart by their numbers.
            let name = self.imposed[row.constraint].name.clone();
            if with.contains(&name) {
                let numbered = |k: usize| format!("{} (constraints[{k}])", self.imposed[k].name);
                let beside = kept.iter().zip(&a).filter(|(_, a)| a.abs() > 1e-6 * largest);
                let mut others: Vec<usize> = beside.map(|(&k, _)| self.rows[k].constraint).collect();
                others.dedup();
                let with = others.into_iter().map(numbered).collect();
                return Err(FitError::Conflict { name: numbered(row.constraint), with });
            }
            return Err(FitError::Conflict { name, with });
        }
        Ok(())
    }
}

impl Row {
    /// What is missing from its value.
    fn defect(&self, x: &[f64]) -> f64 {
        let product = |&(v, a): &(usize, Vector)| a.x * x[3 * v] + a.y * x[3 * v + 1] + a.z * x[3 * v + 2];
        self.value - self.terms.iter().map(product).sum::<f64>()
    }
}

/// A vector over all vertices and axes; an axis without entries is empty.
#[derive(Debug)]
struct Column {
    axes: [Vec<f64>; 3],
}

impl Column {
    fn new(row: &Row, n: usize) -> Self {
        let axes = std::array::from_fn(|axis| {
            if row.terms.iter().all(|(_, a)| a[axis] == 0.0) {
                return Vec::new();
            }
            let mut values = vec![0.0; n];
            for &(v, a) in &row.terms {
                values[v] += a[axis];
            }
            values
        });
        Self { axes }
    }

    fn each(&mut self, mut change: impl FnMut(&mut [f64])) {
        for axis in self.axes.iter_mut().filter(|a| !a.is_empty()) {
            change(axis);
        }
    }

    fn dot(&self, other: &Self) -> f64 {
        let axes = self.axes.iter().zip(&other.axes);
        axes.map(|(a, b)| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>()).sum()
    }

    fn subtract(&mut self, other: &Self, factor: f64) {
        for (mine, theirs) in self.axes.iter_mut().zip(&other.axes) {
            if mine.is_empty() && factor != 0.0 && !theirs.is_empty() {
                mine.resize(theirs.len(), 0.0);
            }
            for (m, t) in mine.iter_mut().zip(theirs) {
                *m -= factor * t;
            }
        }
    }
}

fn consecutive(vertices: &[usize]) -> bool {
    vertices.windows(2).all(|w| w[1] == w[0] + 1)
}

/// A curve over `space` that follows the points roughly: each vertex at the points' polygon, at its Greville
/// abscissa. `O(n log m)`.
pub(crate) fn rough(space: &Space, sites: &[f64], points: &[Vector], frame: &Frame) -> Result<Curve> {
    let at = |u: f64| {
        let k = sites.partition_point(|&s| s <= u).clamp(1, (sites.len() - 1).max(1));
        let (Some(&a), Some(&b)) = (sites.get(k - 1), sites.get(k)) else { return points[0] };
        let share = if b > a { ((u - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
        points[(k - 1) % points.len()].lerp(&points[k % points.len()], share)
    };
    let vertices = (0..space.len()).map(|i| frame.leave(at(space.greville(i)))).collect();
    Ok(Curve::new(space.clone(), vertices)?)
}
