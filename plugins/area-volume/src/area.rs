//! The area that curves enclose (paper 2).

use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, Field, ParameterError, Parameters};
use loftsman_kernel::{Point, Result, Vector};

use crate::contour::Contour;
use crate::form::AreaForm;
use crate::members::{Members, OBJECT, OBJECTS, curve, extent};
use crate::plane::Plane;
use crate::ties::Closed;

/// The area inside closed curves, `½ ∮ n·(C × C') du`: bilinear in the coordinates of the plane, `½ xᵀΦy` with the banded
/// [`AreaForm`], which is computed once for an edit. One equation, with gradient `½ (ΦP)_i × n`; `O(n p)` an evaluation.
///
/// *Which curves*: periodic ones, open ones whose ends meet, several that are joined end to end; of a compound, each closed
/// part counts with its own direction, and [`holes`](Self::holes) count less whichever way they run.
///
/// *Its sign*: with a [`normal`](Self::normal), positive where the curve runs counter-clockwise seen against the normal; of
/// a curve in space it is the area of its projection along the normal. Without one, the curve must be planar, and its area
/// is positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    members: Members,
    holes: Option<Members>,
    normal: Option<Vector>,
    bound: Option<Arc<Bound>>,
}

#[derive(Debug, PartialEq)]
struct Bound {
    plane: Plane,
    pieces: Vec<Piece>,
}

#[derive(Debug, PartialEq)]
struct Piece {
    shape: usize,
    sign: f64,
    form: AreaForm,
}

/// The area inside the first shape of the problem.
pub fn area() -> Area {
    Area { members: Members::default(), holes: None, normal: None, bound: None }
}

/// Below this, of the sizes of its parts, an area is zero.
const NONE: f64 = 1e-10;

impl Area {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// The area that these shapes bound together.
    #[must_use]
    pub fn of<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.members = shapes.into_iter().collect();
        self
    }

    /// Less the areas inside these, whichever way they run.
    #[must_use]
    pub fn holes<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.holes = Some(shapes.into_iter().collect());
        self
    }

    /// Measured across this normal.
    #[must_use]
    pub fn normal(mut self, normal: impl Into<Vector>) -> Self {
        self.normal = Some(normal.into());
        self
    }

    fn everyone(&self) -> Vec<On> {
        self.members.0.iter().chain(self.holes.iter().flat_map(|h| &h.0)).cloned().collect()
    }

    fn prepared(&self, shapes: &Shapes<'_>) -> Result<Arc<Bound>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        let what = self.describe();
        let everyone = self.everyone();
        let (origin, size) = extent(shapes, &everyone)?;
        let mut groups = vec![(&self.members, Contour::find(shapes, &self.members.0, &what)?)];
        // Each hole is a boundary of its own.
        if let Some(holes) = &self.holes {
            groups.push((holes, Contour::find(shapes, &holes.0, &what)?));
        }
        let mut pieces = Vec::new();
        let mut vectors = Vec::new();
        for (members, contour) in &groups {
            for (on, &sign) in members.0.iter().zip(&contour.senses) {
                let own = curve(shapes, on, &what, "ask for its volume, or its surface-area")?;
                let piece = Piece { shape: on.shape, sign, form: AreaForm::of_curve(own)? };
                vectors.push(piece.area_vector(own.points(), &origin));
                pieces.push(piece);
            }
        }
        let outer = self.members.0.len();
        let sum = |vectors: &[(Vector, f64)]| vectors.iter().fold(Vector::zeros(), |sum, (v, _)| sum + v);
        let whole = sum(&vectors[..outer]);
        let terms: f64 = vectors.iter().map(|(_, terms)| terms).sum();
        let zero = |area: f64| area.is_nan() || area <= NONE * terms;
        let normal = match self.normal {
            Some(normal) => normal,
            None if zero(whole.norm()) => {
                return Err(Error::Invalid(format!(
                    "{what}: it encloses no area, so its plane cannot be told; give it some first, or a \"normal\""
                )));
            }
            None => whole,
        };
        let plane = Plane::across(&normal, origin, &what)?;
        if self.normal.is_none() {
            check_planar(shapes, &everyone, &plane, size, &what)?;
        }
        let outside = whole.dot(&plane.normal);
        if zero(outside.abs()) {
            return Err(Error::Invalid(format!(
                "{what}: its area is zero; only what encloses some can keep or change it (is the normal right?)"
            )));
        }
        // A hole is a whole loop: all its pieces turn, or none.
        if let Some((_, contour)) = groups.get(1) {
            for (k, first) in contour.loops.iter().enumerate() {
                let own = (0..contour.loops.len()).filter(|&j| contour.loops[j] == *first);
                let inside: f64 = own.map(|j| vectors[outer + j].0.dot(&plane.normal)).sum();
                if inside * outside > 0.0 {
                    pieces[outer + k].sign = -pieces[outer + k].sign;
                }
            }
        }
        Ok(Arc::new(Bound { plane, pieces }))
    }
}

fn check_planar(shapes: &Shapes<'_>, members: &[On], plane: &Plane, size: f64, what: &str) -> Result<()> {
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for on in members {
        for p in shapes.get(on.shape)?.control_vertices() {
            let height = (p - plane.origin).dot(&plane.normal);
            (low, high) = (low.min(height), high.max(height));
        }
    }
    if high - low <= 1e-9 * size {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "{what}: it is not planar: its control vertices leave its plane by {:.3e}; give a \"normal\", and the area of its \
         projection along that is meant",
        high - low
    )))
}

impl Piece {
    /// `½ ∮ C × C'` with its direction, and the sum of the sizes of its terms.
    fn area_vector(&self, points: &[Point], origin: &Point) -> (Vector, f64) {
        let n = points.len();
        let (mut x, mut y, mut fx, mut fy) = (Vec::new(), Vec::new(), vec![0.0; n], vec![0.0; n]);
        let (mut sum, mut size) = (Vector::zeros(), 0.0);
        for (a, b, c) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            self.form.padded(points.iter().map(|p| p[a] - origin[a]), &mut x);
            self.form.padded(points.iter().map(|p| p[b] - origin[b]), &mut y);
            self.form.apply(&x, &y, &mut fx, &mut fy);
            for (p, f) in points.iter().zip(&fy) {
                let term = 0.5 * (p[a] - origin[a]) * f;
                sum[c] += self.sign * term;
                size += term.abs();
            }
        }
        (sum, size)
    }

    /// The piece's area, and `ΦX` and `ΦY` for its gradient.
    fn measure(&self, points: &[Point], plane: &Plane, work: &mut Work) -> f64 {
        let Work { x, y, fx, fy } = work;
        self.form.padded(points.iter().map(|p| (p - plane.origin).dot(&plane.x)), x);
        self.form.padded(points.iter().map(|p| (p - plane.origin).dot(&plane.y)), y);
        fx.resize(points.len(), 0.0);
        fy.resize(points.len(), 0.0);
        self.form.apply(x, y, fx, fy);
        let pad = (x.len() - points.len()) / 2;
        // xᵀΦy = -yᵀΦx: half of either, so that no axis is privileged by rounding.
        let own = x[pad..].iter().zip(fy.iter()).zip(y[pad..].iter().zip(fx.iter()));
        0.25 * self.sign * own.map(|((x, fy), (y, fx))| x * fy - y * fx).sum::<f64>()
    }
}

#[derive(Default)]
struct Work {
    x: Vec<f64>,
    y: Vec<f64>,
    fx: Vec<f64>,
    fy: Vec<f64>,
}

impl Functional for Area {
    fn equations(&self) -> usize {
        1
    }

    fn linearity(&self) -> Linearity {
        Linearity::Multilinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let bound = self.prepared(shapes)?;
        let plane = &bound.plane;
        let mut work = Work::default();
        let mut total = 0.0;
        rows.equation();
        for piece in &bound.pieces {
            let points = shapes.get(piece.shape)?.control_vertices();
            total += piece.measure(points, plane, &mut work);
            let (x, y) = (plane.x * (0.5 * piece.sign), plane.y * (0.5 * piece.sign));
            let gradient = work.fx.iter().zip(&work.fy).map(|(fx, fy)| x * *fy - y * *fx);
            rows.terms(piece.shape, 0, gradient);
        }
        if let Some(value) = value.first_mut() {
            *value = total;
        }
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let bound = self.prepared(shapes)?;
        let mut work = Work::default();
        let mut total = 0.0;
        for piece in &bound.pieces {
            total += piece.measure(shapes.get(piece.shape)?.control_vertices(), &bound.plane, &mut work);
        }
        if let Some(out) = out.first_mut() {
            *out = total;
        }
        Ok(())
    }

    fn check_target(&self, present: &[f64], wanted: &[f64]) -> Result<()> {
        let (Some(&present), Some(&wanted)) = (present.first(), wanted.first()) else { return Ok(()) };
        if wanted * present > 0.0 {
            return Ok(());
        }
        let what = self.describe();
        Err(Error::Invalid(if wanted == 0.0 {
            format!(
                "{what}: nothing is left of it at an area of 0; ask for one like the present {present:.6}"
            )
        } else {
            format!(
                "{what}: it is {present:.6} and should become {wanted:.6}, which would turn the curve inside out; give an \
                 area of the same sign, or reverse the curve or the normal"
            )
        }))
    }

    fn describe(&self) -> String {
        let mut text = format!("area{}", self.members);
        if let Some(holes) = &self.holes {
            text += &format!(" less the holes{holes}");
        }
        if let Some(n) = self.normal {
            text += &format!(" across [{}, {}, {}]", n.x, n.y, n.z);
        }
        text
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        let groups = std::iter::once(&self.members).chain(&self.holes);
        groups.map(|g| -> Arc<dyn Functional> { Arc::new(Closed::of_members(g.clone())) }).collect()
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Some(self.prepared(shapes)?);
        Ok(Some(Arc::new(Self { bound, ..self.clone() })))
    }
}

impl DeclaredFunctional for Area {
    const DECLARATION: Declaration = Declaration {
        name: "area",
        help: "the area inside a closed planar curve, or several",
        fields: &[
            Field::optional(
                "normal",
                "[x, y, z]",
                "the curve's own, so that the area is positive",
                "the side from which counter-clockwise counts as positive",
            ),
            OBJECT,
            OBJECTS,
            Field::optional(
                "holes",
                "[text, …]",
                "none",
                "objects whose areas count less, whichever way they run",
            ),
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let members = Members::from_parameters(parameters, names, "objects")?;
        let holes = parameters.has("holes").then(|| Members::from_parameters(parameters, names, "holes"));
        let holes = holes.transpose()?;
        if let Some(twice) = holes.iter().flat_map(|h| &h.0).find(|on| members.0.contains(on)) {
            let name = crate::members::name_of(twice);
            return Err(parameters.error("holes", format!("{name} cannot be a hole in itself")));
        }
        let normal = if parameters.has("normal") { Some(parameters.vector("normal")?) } else { None };
        Ok(Self { members, holes, normal, bound: None })
    }
}
