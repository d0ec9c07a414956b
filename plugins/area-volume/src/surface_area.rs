//! How large surfaces are.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{
    Accuracy, DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes,
};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::{Result, Vector};

use crate::length::positive;
use crate::members::{Members, OBJECT, OBJECTS, name_of, surface};
use crate::rule::Basis;

/// The area `∫∫ |S_u × S_v| du dv` of a surface, or of several together. One nonlinear equation.
///
/// Tensor Gauss–Legendre quadrature on each cell of the knots, by two rules; where they differ most, a part is halved, across
/// the direction to which that is due, until they agree everywhere to 1e-11 of a cell's share of the whole. So the rule
/// follows the surface as it changes, and a line of parameters along which `S_u × S_v` vanishes (where a surface of revolution
/// meets its axis) costs a few halvings. Their number is bounded: where the surface folds over along other lines the integrand
/// has a crease there that no rule gets hold of, the area cannot be told as well as it would have to be kept, and that is
/// said at once.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceArea {
    members: Members,
    /// How well the area can be told, where that is not to rounding.
    told: Option<f64>,
}

/// The area of the first shape of the problem, a surface.
pub fn surface_area() -> SurfaceArea {
    SurfaceArea::default()
}

/// The rules' points beyond the degree.
const EXTRA: [usize; 2] = [2, 4];
/// Halvings allowed in all: so many, and so many for each cell.
const HALVINGS: usize = 400;
const HALVINGS_A_CELL: usize = 1;
/// What the two rules may differ by on a part, as a share of a cell's share of the whole.
const AGREE: f64 = 1e-11;
/// By how much they may differ in all where that is not reached, relative.
const ENOUGH: f64 = 1e-6;
/// What they may differ by in all and still agree to rounding: the better of them is nearer by far.
const AS_GOOD: f64 = 1e-9;
/// An area below this share of the squared size is what rounding makes of none.
const NOTHING: f64 = 1e3 * f64::EPSILON;

impl SurfaceArea {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The area of all of these.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self { members: shapes.into_iter().collect(), told: None }
    }

    fn measure(&self, shapes: &Shapes<'_>, mut found: impl FnMut(usize, Vec<Vector>)) -> Result<Area> {
        let what = self.describe();
        let mut total = Area { area: 0.0, error: 0.0 };
        for on in &self.members.0 {
            let own = surface(shapes, on, &what, "ask for the area inside it, or its length")?;
            let mut gradient = vec![Vector::zeros(); own.points().len()];
            let Area { area, error } = Measure::new(own).whole(&mut gradient);
            let name = name_of(on);
            if !area.is_finite() {
                return Err(Error::Invalid(format!(
                    "{what}: the area of {name} is beyond what numbers can hold; scale it down, or make its weights alike"
                )));
            }
            let size = extent(own);
            if area <= NOTHING * size * size {
                return Err(Error::Invalid(format!(
                    "{what}: {name} has no area, and no direction to grow in; move a vertex first"
                )));
            }
            if error > ENOUGH * area {
                return Err(Error::Invalid(format!(
                    "{what}: that of {name} can be told to {:.1e} of itself only, which is not enough to keep it or bring \
                     it to a value: the surface folds over or is creased along lines that are not knots; unfold it, or \
                     insert knots there",
                    error / area
                )));
            }
            total.area += area;
            total.error += error;
            found(on.shape, gradient);
        }
        Ok(total)
    }
}

/// Nodes and weights of a rule on `[0, 1]` in both directions.
struct Nodes {
    u: (Vec<f64>, Vec<f64>),
    v: (Vec<f64>, Vec<f64>),
}

struct Measure<'s> {
    surface: &'s Surface,
    rules: [Nodes; 2],
    bases: [Basis; 2],
}

/// A part of a cell: its span and interval in each direction.
#[derive(Clone, Copy)]
struct Part {
    spans: [usize; 2],
    u: (f64, f64),
    v: (f64, f64),
}

impl<'s> Measure<'s> {
    fn new(surface: &'s Surface) -> Self {
        let rule = |extra: usize| Nodes {
            u: gauss_legendre(surface.u().degree() + extra),
            v: gauss_legendre(surface.v().degree() + extra),
        };
        Self { surface, rules: EXTRA.map(rule), bases: [Basis::default(), Basis::default()] }
    }

    /// The area of a part by a rule for each direction, and its gradient added where there is room.
    fn part(&mut self, part: Part, rules: [usize; 2], mut gradient: Option<&mut [Vector]>) -> f64 {
        let (su, sv) = (self.surface.u(), self.surface.v());
        let (p, q) = (su.degree(), sv.degree());
        let columns = sv.len();
        let vertex = |i: usize, j: usize| {
            su.vertex(part.spans[0] - p + i) * columns + sv.vertex(part.spans[1] - q + j)
        };
        let (points, weights) = (self.surface.points(), self.surface.weights());
        let [bu, bv] = &mut self.bases;
        bu.enter(su, part.spans[0]);
        bv.enter(sv, part.spans[1]);
        let (along_u, along_v) = (&self.rules[rules[0]].u, &self.rules[rules[1]].v);
        let mut total = 0.0;
        for (x, wx) in along_u.0.iter().zip(&along_u.1) {
            bu.at(part.u.0 + (part.u.1 - part.u.0) * x);
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
            for (y, wy) in along_v.0.iter().zip(&along_v.1) {
                bv.at(part.v.0 + (part.v.1 - part.v.0) * y);
                let (mut s, mut su_, mut sv_) = ([0.0; 4], [0.0; 4], [0.0; 4]);
                for (j, line) in line.iter().enumerate().take(q + 1) {
                    for a in 0..4 {
                        s[a] += bv.values[j] * line[0][a];
                        su_[a] += bv.values[j] * line[1][a];
                        sv_[a] += bv.slopes[j] * line[0][a];
                    }
                }
                let w = s[3];
                let project = |d: [f64; 4]| Vector::from_fn(|a, _| (d[a] - s[a] / w * d[3]) / w);
                let (tu, tv) = (project(su_), project(sv_));
                let normal = tu.cross(&tv);
                let size = normal.norm();
                let weight = wx * (part.u.1 - part.u.0) * wy * (part.v.1 - part.v.0);
                total += weight * size;
                let Some(gradient) = gradient.as_deref_mut().filter(|_| size > 0.0) else { continue };
                let unit = normal / size;
                let (by_u, by_v) = (tv.cross(&unit) * weight, unit.cross(&tu) * weight);
                for i in 0..=p {
                    for j in 0..=q {
                        let at = vertex(i, j);
                        let own = weights.map_or(1.0, |w| w[at]);
                        let r = own * bu.values[i] * bv.values[j] / w;
                        let ru = (own * bu.slopes[i] * bv.values[j] - r * su_[3]) / w;
                        let rv = (own * bu.values[i] * bv.slopes[j] - r * sv_[3]) / w;
                        gradient[at] += by_u * ru + by_v * rv;
                    }
                }
            }
        }
        total
    }

    /// The area, what it may be wrong by, and its gradient added.
    fn whole(&mut self, gradient: &mut [Vector]) -> Area {
        let (u, v) = (self.surface.u().clone(), self.surface.v().clone());
        let mut parts = BinaryHeap::new();
        let ends = |flat: &[f64], span: usize| (flat[span], flat[span + 1]);
        for i in u.spans() {
            for j in v.spans() {
                let part = Part { spans: [i, j], u: ends(u.flat(), i), v: ends(v.flat(), j) };
                parts.push(self.judged(part, parts.len()));
            }
        }
        let cells = parts.len();
        let share = parts.iter().map(|p| p.fine).sum::<f64>() / cells.max(1) as f64;
        let mut made = cells;
        for _ in 0..HALVINGS + HALVINGS_A_CELL * cells {
            let Some(worst) = parts.pop() else { break };
            if worst.error <= AGREE * share.max(worst.fine) || !worst.error.is_finite() {
                parts.push(worst);
                break;
            }
            let Some(halves) = self.halves(&worst, made) else {
                // Too short to be halved: what it may be wrong by stays counted, and others go on.
                parts.push(Judged { settled: true, ..worst });
                if parts.peek().is_none_or(|p| p.settled) {
                    break;
                }
                continue;
            };
            parts.extend(halves);
            made += 2;
        }
        // In the order in which they were made: the same sum every time.
        let mut parts = parts.into_vec();
        parts.sort_by_key(|p| p.order);
        let mut found = Area { area: 0.0, error: 0.0 };
        for p in &parts {
            found.area += self.part(p.part, [1; 2], Some(gradient));
            found.error += p.error;
        }
        found
    }

    fn judged(&mut self, part: Part, order: usize) -> Judged {
        let (rough, fine) = (self.part(part, [0; 2], None), self.part(part, [1; 2], None));
        Judged { part, fine, error: (fine - rough).abs(), order, settled: false }
    }

    /// A part in two, across the direction to which the difference of the rules is due: the one in which the rougher rule
    /// alone is further from the better one in both. None where there is no number between the ends.
    fn halves(&mut self, whole: &Judged, order: usize) -> Option<[Judged; 2]> {
        let part = whole.part;
        let middle = |(a, b): (f64, f64)| {
            let middle = 0.5 * a + 0.5 * b;
            (a < middle && middle < b).then_some(middle)
        };
        let across_u =
            middle(part.u).map(|m| [Part { u: (part.u.0, m), ..part }, Part { u: (m, part.u.1), ..part }]);
        let across_v =
            middle(part.v).map(|m| [Part { v: (part.v.0, m), ..part }, Part { v: (m, part.v.1), ..part }]);
        let off = [[0, 1], [1, 0]].map(|rules| (self.part(part, rules, None) - whole.fine).abs());
        let halves = if off[0] >= off[1] { across_u.or(across_v) } else { across_v.or(across_u) };
        halves.map(|[first, second]| [self.judged(first, order), self.judged(second, order + 1)])
    }
}

/// An area, and a bound (as a rule) of its error.
struct Area {
    area: f64,
    error: f64,
}

/// A part with its area, by the better rule, and the difference of both; in the heap the part with most is the greatest.
struct Judged {
    part: Part,
    fine: f64,
    error: f64,
    order: usize,
    /// Whether it cannot be halved any more.
    settled: bool,
}

impl PartialEq for Judged {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Judged {}
impl PartialOrd for Judged {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Judged {
    /// Of equal ones the first made, so that the answer is always the same.
    fn cmp(&self, other: &Self) -> Ordering {
        let open = other.settled.cmp(&self.settled);
        open.then(self.error.total_cmp(&other.error)).then(other.order.cmp(&self.order))
    }
}

/// The longest side of the box of a surface's vertices.
fn extent(surface: &Surface) -> f64 {
    let (low, high) = surface.hull_bounds();
    (high - low).amax()
}

impl Functional for SurfaceArea {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        rows.equation();
        let total = self.measure(shapes, |shape, gradient| {
            rows.terms(shape, 0, gradient.into_iter());
        })?;
        if let Some(value) = value.first_mut() {
            *value = total.area;
        }
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        if let Some(out) = out.first_mut() {
            *out = self.measure(shapes, |_, _| ())?.area;
        }
        Ok(())
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        positive(&self.describe(), "surface area", wanted)
    }

    fn describe(&self) -> String {
        format!("surface area{}", self.members)
    }

    fn accuracy(&self) -> Accuracy {
        self.told.map_or(Accuracy::Rounding, Accuracy::Within)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let Area { area, error } = self.measure(shapes, |_, _| ())?;
        let told = (error > AS_GOOD * area).then_some(error);
        Ok(Some(Arc::new(Self { members: self.members.clone(), told })))
    }
}

impl DeclaredFunctional for SurfaceArea {
    const DECLARATION: Declaration = Declaration {
        name: "surface-area",
        help: "the area of a surface, or of several together",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { members: Members::from_parameters(parameters, names, "objects")?, told: None })
    }
}
