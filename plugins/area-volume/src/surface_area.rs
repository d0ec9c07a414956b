//! How large surfaces are.

use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
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
/// Tensor Gauss–Legendre quadrature on each cell of the knots, by two rules, the cell quartered until they agree to 1e-11 of
/// its share of the whole; so the rule follows the surface as it changes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceArea {
    members: Members,
}

/// The area of the first shape of the problem, a surface.
pub fn surface_area() -> SurfaceArea {
    SurfaceArea::default()
}

/// The rules' points beyond the degree.
const EXTRA: [usize; 2] = [2, 4];
/// Quarterings of a cell, after which it is taken as it is.
const DEPTH: usize = 24;
/// Quarterings allowed in all, for each cell.
const QUARTERINGS: usize = 60;
/// What the two rules may differ by, relative.
const AGREE: f64 = 1e-11;

impl SurfaceArea {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The area of all of these.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self { members: shapes.into_iter().collect() }
    }

    fn measure(&self, shapes: &Shapes<'_>, mut found: impl FnMut(usize, Vec<Vector>)) -> Result<f64> {
        let what = self.describe();
        let mut total = 0.0;
        for on in &self.members.0 {
            let own = surface(shapes, on, &what, "ask for the area inside it, or its length")?;
            let mut gradient = vec![Vector::zeros(); own.points().len()];
            let area = Measure::new(own).whole(&mut gradient);
            if area.is_nan() || area <= 0.0 {
                return Err(Error::Invalid(format!(
                    "{what}: {} has no area, and no direction to grow in; move a vertex first",
                    name_of(on)
                )));
            }
            total += area;
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

    /// The area of a part by rule `which`, and its gradient added where there is room.
    fn part(&mut self, part: Part, which: usize, mut gradient: Option<&mut [Vector]>) -> f64 {
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
        let nodes = &self.rules[which];
        let mut total = 0.0;
        for (x, wx) in nodes.u.0.iter().zip(&nodes.u.1) {
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
            for (y, wy) in nodes.v.0.iter().zip(&nodes.v.1) {
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

    fn whole(&mut self, gradient: &mut [Vector]) -> f64 {
        let (u, v) = (self.surface.u().clone(), self.surface.v().clone());
        let mut cells = Vec::new();
        for i in u.spans() {
            for j in v.spans() {
                let ends = |flat: &[f64], span: usize| (flat[span], flat[span + 1]);
                let part = Part { spans: [i, j], u: ends(u.flat(), i), v: ends(v.flat(), j) };
                cells.push((part, self.part(part, 0, None)));
            }
        }
        let share = cells.iter().map(|(_, area)| area).sum::<f64>() / cells.len().max(1) as f64;
        let mut total = 0.0;
        for (cell, rough) in cells {
            let mut todo = vec![(cell, rough, 0)];
            let mut left = QUARTERINGS;
            while let Some((part, rough, depth)) = todo.pop() {
                let fine = self.part(part, 1, None);
                if (fine - rough).abs() <= AGREE * share.max(fine) || depth >= DEPTH || left == 0 {
                    total += self.part(part, 1, Some(gradient));
                    continue;
                }
                left -= 1;
                let (mu, mv) = (0.5 * part.u.0 + 0.5 * part.u.1, 0.5 * part.v.0 + 0.5 * part.v.1);
                for u in [(mu, part.u.1), (part.u.0, mu)] {
                    for v in [(mv, part.v.1), (part.v.0, mv)] {
                        let quarter = Part { u, v, ..part };
                        let rough = self.part(quarter, 0, None);
                        todo.push((quarter, rough, depth + 1));
                    }
                }
            }
        }
        total
    }
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
            *value = total;
        }
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        if let Some(out) = out.first_mut() {
            *out = self.measure(shapes, |_, _| ())?;
        }
        Ok(())
    }

    fn check_target(&self, _: &[f64], wanted: &[f64]) -> Result<()> {
        positive(&self.describe(), "surface area", wanted)
    }

    fn describe(&self) -> String {
        format!("surface area{}", self.members)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        for on in &self.members.0 {
            surface(shapes, on, &self.describe(), "ask for the area inside it, or its length")?;
        }
        Ok(None)
    }
}

impl DeclaredFunctional for SurfaceArea {
    const DECLARATION: Declaration = Declaration {
        name: "surface-area",
        help: "the area of a surface, or of several together",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { members: Members::from_parameters(parameters, names, "objects")? })
    }
}
