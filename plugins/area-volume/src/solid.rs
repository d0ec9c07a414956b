//! The inside of closed surfaces: volume and first moments with their gradients.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::{Derivative, Location, Shape, Stencil};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Result, Vector};

use crate::flux::{Flux, Strip};
use crate::members::{extent, surface};
use crate::rule::Rule;
use crate::shell::Shell;

/// Surfaces that close, ready to be measured.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solid {
    pub(crate) origin: Point,
    patches: Vec<Patch>,
}

#[derive(Debug, Clone, PartialEq)]
struct Patch {
    shape: usize,
    sign: f64,
    flux: Flux,
    rim: Vec<Rim>,
}

/// A Gauss point on an edge. Volumes of closed surfaces do not need them; the derivative of `⅓ ∫∫ S·(S_u × S_v)` when a
/// vertex of the edge moves does.
#[derive(Debug, Clone, PartialEq)]
struct Rim {
    point: Stencil,
    slope: Stencil,
    weight: f64,
}

/// Volume, and where asked for first moments, with the gradient for each vertex of each patch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Measured {
    /// `V`, then `∫ x`, `∫ y`, `∫ z` from the origin.
    pub(crate) values: [f64; 4],
    /// The sum of the sizes of the volume's terms.
    pub(crate) size: f64,
    /// For each patch its shape, and for each of the values the gradients of its vertices.
    pub(crate) gradients: Vec<(usize, Vec<Vec<Vector>>)>,
}

/// What measuring works with, and what it found.
#[derive(Debug, Default)]
pub(crate) struct Work {
    strip: Strip,
    measured: Measured,
}

/// Below this, of the sizes of its parts, a volume is zero.
const NONE: f64 = 1e-10;

impl Solid {
    /// # Errors
    /// When a member is not a surface, the boundary is open, or it encloses nothing.
    pub(crate) fn new(shapes: &Shapes<'_>, members: &[On], moments: bool, what: &str) -> Result<Self> {
        let shell = Shell::find(shapes, members, what)?;
        let (origin, _) = extent(shapes, members)?;
        let mut patches = Vec::with_capacity(members.len());
        for (on, &sign) in members.iter().zip(&shell.senses) {
            let own = surface(shapes, on, what, "ask for its area, or its length")?;
            let rim = rim(own)?;
            patches.push(Patch { shape: on.shape, sign, flux: Flux::new(own, moments)?, rim });
        }
        let solid = Self { origin, patches };
        let mut work = Work::default();
        let measured = solid.measure(shapes, &mut work)?;
        let volume = measured.values[0].abs();
        if volume.is_nan() || volume <= NONE * measured.size {
            return Err(Error::Invalid(format!(
                "{what}: it encloses no volume; only what encloses some can keep or change it"
            )));
        }
        Ok(solid)
    }

    /// Measures the shapes as they are now. Allocates nothing where `work` has measured them before.
    pub(crate) fn measure<'w>(&self, shapes: &Shapes<'_>, work: &'w mut Work) -> Result<&'w Measured> {
        let Work { strip, measured } = work;
        (measured.values, measured.size) = ([0.0; 4], 0.0);
        measured.gradients.resize_with(self.patches.len(), Default::default);
        for (patch, (shape, gradients)) in self.patches.iter().zip(&mut measured.gradients) {
            *shape = patch.shape;
            let points = shapes.get(patch.shape)?.control_vertices();
            patch.flux.integrate(points, &self.origin, strip, gradients);
            for (kind, gradient) in gradients.iter_mut().enumerate() {
                // Homogeneous of degree 3 and 4: Euler's theorem gives the value from the gradient.
                let share = patch.sign / if kind == 0 { 3.0 } else { 4.0 };
                let (mut sum, mut size) = (0.0, 0.0);
                for (g, p) in gradient.iter_mut().zip(points) {
                    let term = g.dot(&(p - self.origin));
                    sum += term;
                    size += term.abs();
                    *g *= patch.sign;
                }
                measured.values[kind] += share * sum;
                if kind == 0 {
                    measured.size += size / 3.0;
                }
            }
            for rim in &patch.rim {
                let point = rim.point.apply(points) - self.origin.coords;
                // S_v × S along v, and S × S_u along u; the sign is in the weight.
                let normal = rim.slope.apply(points).cross(&point) * (rim.weight * patch.sign);
                for (kind, gradient) in gradients.iter_mut().enumerate() {
                    let h = if kind == 0 { 1.0 / 3.0 } else { point[kind - 1] / 4.0 };
                    for (i, n) in rim.point.iter() {
                        gradient[i] += normal * (n * h);
                    }
                }
            }
        }
        Ok(measured)
    }
}

fn rim(surface: &Surface) -> Result<Vec<Rim>> {
    let mut all = Vec::new();
    for (along_u, run, across) in [(false, surface.v(), surface.u()), (true, surface.u(), surface.v())] {
        if across.is_periodic() {
            continue;
        }
        let per = 2 * run.degree() + if surface.weights().is_some() { 6 } else { 0 };
        let rule = Rule::new(run, per, 1);
        let nodes = loftsman_kernel::spline::gram::gauss_legendre(per).0;
        let (a, b) = across.domain();
        for (end, sign) in [(a, -1.0), (b, 1.0)] {
            for (panel, span) in run.spans().enumerate() {
                let (low, high) = (run.flat()[span], run.flat()[span + 1]);
                for (x, node) in nodes.iter().enumerate() {
                    let t = low + (high - low) * node;
                    let at = if along_u { Location::Surface(t, end) } else { Location::Surface(end, t) };
                    let order = if along_u { [1, 0] } else { [0, 1] };
                    let nonzero = |s: Stencil| s.iter().filter(|(_, c)| *c != 0.0).collect::<Stencil>();
                    let weight = rule.weights[panel * per + x] * if along_u { -sign } else { sign };
                    all.push(Rim {
                        point: nonzero(surface.stencil(at, Derivative::POSITION)?),
                        slope: nonzero(surface.stencil(at, order.into())?),
                        weight,
                    });
                }
            }
        }
    }
    Ok(all)
}
