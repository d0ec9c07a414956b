//! Regions of a plane bounded by curves: which way each curve counts, and the plane.

use loftsman_kernel::text::{figure, short};
use std::sync::Arc;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{Functional, On, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Field, ParameterError, Parameters};
use loftsman_kernel::{Point, Result, Vector};

use crate::contour::Contour;
use crate::members::{Members, curve, extent, name_of};
use crate::plane::Plane;
use crate::sparse_form::Form;
use crate::ties::Closed;

/// What to do with an open boundary.
const CLOSE: &str = "close it";

/// Curves that bound a region together, holes in it, and the side from which it is looked at.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Region {
    pub(crate) members: Members,
    pub(crate) holes: Option<Members>,
    pub(crate) normal: Option<Vector>,
}

/// The field for the side from which areas are looked at.
pub(crate) const NORMAL: Field = Field::optional(
    "normal",
    "[x, y, z]",
    "the curve's own, so that the area is positive",
    "the side from which counter-clockwise counts as positive",
);
/// The field for holes.
pub(crate) const HOLES: Field =
    Field::optional("holes", "[text, …]", "none", "objects whose areas count less, whichever way they run");

/// A region found to be one, ready to be measured.
#[derive(Debug, PartialEq)]
pub(crate) struct Outline {
    pub(crate) plane: Plane,
    pub(crate) pieces: Vec<Piece>,
}

/// A curve of the boundary.
#[derive(Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) shape: usize,
    /// 1 where it counts as it runs, -1 the other way round.
    pub(crate) sign: f64,
    pub(crate) form: Form,
}

/// Below this, of the sizes of its parts, an area is zero.
const NONE: f64 = 1e-10;

impl Region {
    fn everyone(&self) -> Vec<On> {
        self.members.0.iter().chain(self.holes.iter().flat_map(|h| &h.0)).cloned().collect()
    }

    /// # Errors
    /// When a member is not a curve, the boundary is open, not planar, or encloses nothing; `what` names it.
    pub(crate) fn outline(&self, shapes: &Shapes<'_>, what: &str) -> Result<Outline> {
        let everyone = self.everyone();
        let (origin, size) = extent(shapes, &everyone)?;
        let mut groups = vec![(&self.members, Contour::find(shapes, &self.members.0, what, CLOSE)?)];
        // Each hole is a boundary of its own.
        if let Some(holes) = &self.holes {
            groups.push((holes, Contour::find(shapes, &holes.0, what, CLOSE)?));
        }
        let mut pieces = Vec::new();
        let mut vectors = Vec::new();
        for (members, contour) in &groups {
            for (on, &sign) in members.0.iter().zip(&contour.senses) {
                let own = curve(shapes, on, what, "ask for its volume, or its surface-area")?;
                let piece = Piece { shape: on.shape, sign, form: Form::of(&own)? };
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
        let plane = Plane::across(&normal, origin, what)?;
        if self.normal.is_none() {
            check_planar(shapes, &everyone, &plane, size, what)?;
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
        Ok(Outline { plane, pieces })
    }

    /// ` of "section" less the holes of … across [0, 0, 1]`, as far as it was said.
    pub(crate) fn describe(&self) -> String {
        let mut text = self.members.to_string();
        if let Some(holes) = &self.holes {
            text += &format!(" less the holes{holes}");
        }
        if let Some(n) = self.normal {
            text += &format!(" across [{}, {}, {}]", n.x, n.y, n.z);
        }
        text
    }

    /// What keeps the boundaries closed.
    pub(crate) fn companions(&self) -> Vec<Arc<dyn Functional>> {
        let groups = std::iter::once(&self.members).chain(&self.holes);
        groups.map(|g| -> Arc<dyn Functional> { Arc::new(Closed::of_members(g.clone())) }).collect()
    }

    /// From `object` or `objects`, `holes` and `normal`.
    pub(crate) fn from_parameters(
        parameters: &Parameters,
        names: &mut dyn ShapeNames,
    ) -> Result<Self, ParameterError> {
        let members = Members::from_parameters(parameters, names, "objects")?;
        let holes = parameters.has("holes").then(|| Members::from_parameters(parameters, names, "holes"));
        let holes = holes.transpose()?;
        if let Some(twice) = holes.iter().flat_map(|h| &h.0).find(|on| members.0.contains(on)) {
            return Err(parameters.error("holes", format!("{} cannot be a hole in itself", name_of(twice))));
        }
        let normal = if parameters.has("normal") { Some(parameters.vector("normal")?) } else { None };
        Ok(Self { members, holes, normal })
    }
}

/// What leaves its plane by no more than this part of its size is planar.
const PLANAR: f64 = 1e-9;

fn check_planar(shapes: &Shapes<'_>, members: &[On], plane: &Plane, size: f64, what: &str) -> Result<()> {
    // The plane's origin, the middle of a box, need not lie in it.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for on in members {
        for p in shapes.get(on.shape)?.control_vertices() {
            let height = (p - plane.origin).dot(&plane.normal);
            (low, high) = (low.min(height), high.max(height));
        }
    }
    if high - low <= PLANAR * size {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "{what}: it is not planar: its control vertices leave its plane by {} in the scene's unit, {} of its size (more than {PLANAR:e}, which is rounding); give a \"normal\", and its projection \
         along that is meant",
        figure(high - low),
        short((high - low) / size)
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
    pub(crate) fn measure(&self, points: &[Point], plane: &Plane, work: &mut Work) -> f64 {
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

/// Coordinates in the plane, and `Φ` times them.
#[derive(Default)]
pub(crate) struct Work {
    x: Vec<f64>,
    y: Vec<f64>,
    pub(crate) fx: Vec<f64>,
    pub(crate) fy: Vec<f64>,
}
