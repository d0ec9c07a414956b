//! The inside of closed surfaces: volume and first moments with their gradients.

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, Shapes};
use loftsman_kernel::shape::{Derivative, Stencil, edges_of, strips};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::topology::Shell;
use loftsman_kernel::{Point, Result, Vector};

use crate::cell_flux::{self, CellFlux};
use crate::flux::{Flux, Strip};
use crate::members::{Member, by_themselves, extent, name_of, shell_members, surface};
use crate::net_volume;
use crate::nets::Nets;

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
    flux: PatchFlux,
    rim: Vec<Rim>,
}

/// The integrals of a patch: of a tensor-product spline direction by direction, of any other surface cell by cell.
#[derive(Debug, Clone, PartialEq)]
enum PatchFlux {
    Spline(Box<Flux>),
    Cells(CellFlux),
}

impl PatchFlux {
    /// Of a member; `alone` is one that says itself what it bounds.
    fn of(on: &On, surface: &Member<'_>, alone: bool, moments: bool, what: &str) -> Result<Self> {
        if alone {
            let said = |error| Error::Invalid(format!("{what}: {}: {error}", name_of(on)));
            return CellFlux::new(surface, moments).map(Self::Cells).map_err(said);
        }
        Self::new(surface, moments)
    }

    fn new(surface: &Member<'_>, moments: bool) -> Result<Self> {
        match surface.splines.and_then(|splines| Some((splines, splines.v?))) {
            Some((splines, v)) => {
                Flux::new(&splines, v, surface.points(), moments).map(|flux| Self::Spline(Box::new(flux)))
            }
            None => CellFlux::new(surface, moments).map(Self::Cells),
        }
    }

    fn integrate(&self, points: &[Point], origin: &Point, work: &mut Room, out: &mut Vec<Vec<Vector>>) {
        match self {
            Self::Spline(flux) => flux.integrate(points, origin, &mut work.strip, out),
            Self::Cells(flux) => flux.integrate(points, origin, &mut work.cells, out),
        }
    }
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
    room: Room,
    measured: Measured,
}

#[derive(Debug, Default)]
struct Room {
    strip: Strip,
    cells: cell_flux::Room,
}

/// Below this, of the sizes of its parts, a volume is zero.
const NONE: f64 = 1e-10;

impl Solid {
    /// # Errors
    /// When a member is not a surface, the boundary is open, or it encloses nothing.
    pub(crate) fn new(shapes: &Shapes<'_>, members: &[On], moments: bool, what: &str) -> Result<Self> {
        Self::from(middle(shapes, members)?, shapes, members, moments, what)
    }

    fn from(origin: Point, shapes: &Shapes<'_>, members: &[On], moments: bool, what: &str) -> Result<Self> {
        let mut patches = Vec::with_capacity(members.len());
        for (on, sign) in members.iter().zip(signs(shapes, members, what)?) {
            let own = surface(shapes, on, what, "ask for its area, or its length")?;
            let flux = PatchFlux::of(on, &own, sign.is_none(), moments, what)?;
            let rim = if sign.is_some() { rim(&own, what)? } else { Vec::new() };
            patches.push(Patch { shape: on.shape, sign: sign.unwrap_or(1.0), flux, rim });
        }
        let solid = Self { origin, patches };
        let mut work = Work::default();
        let measured = solid.measure(shapes, &mut work)?;
        encloses(measured.values[0], measured.size, what)?;
        Ok(solid)
    }

    /// The volume alone, asked for once: what says the nets of its cells is summed by these, and nothing is kept of it. Coordinates are taken from `origin`, or
    /// from the middle of the box.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub(crate) fn volume(
        origin: Option<Point>,
        shapes: &Shapes<'_>,
        members: &[On],
        what: &str,
    ) -> Result<f64> {
        let origin = match origin {
            Some(origin) => origin,
            None => middle(shapes, members)?,
        };
        let own = |on: &On| surface(shapes, on, what, "ask for its area, or its length");
        let all = members.iter().map(own).collect::<Result<Vec<_>>>()?;
        if !all.iter().any(|own| Nets::of(own).is_some()) {
            let solid = Self::from(origin, shapes, members, false, what)?;
            return Ok(solid.measure(shapes, &mut Work::default())?.values[0]);
        }
        let (mut volume, mut size) = (0.0, 0.0);
        let mut work = Work::default();
        for ((on, own), sign) in members.iter().zip(&all).zip(signs(shapes, members, what)?) {
            let (found, terms) = match net_volume::volume(own, &origin) {
                Some(found) => found?,
                None => {
                    let flux = PatchFlux::of(on, own, sign.is_none(), false, what)?;
                    let patch = Patch { shape: on.shape, sign: 1.0, flux, rim: Vec::new() };
                    let solid = Self { origin, patches: vec![patch] };
                    let measured = solid.measure(shapes, &mut work)?;
                    (measured.values[0], measured.size)
                }
            };
            volume += sign.unwrap_or(1.0) * found;
            size += terms;
        }
        encloses(volume, size, what)?;
        Ok(volume)
    }

    /// Measures the shapes as they are now. Allocates nothing where `work` has measured them before.
    pub(crate) fn measure<'w>(&self, shapes: &Shapes<'_>, work: &'w mut Work) -> Result<&'w Measured> {
        let Work { room, measured } = work;
        (measured.values, measured.size) = ([0.0; 4], 0.0);
        measured.gradients.resize_with(self.patches.len(), Default::default);
        for (patch, (shape, gradients)) in self.patches.iter().zip(&mut measured.gradients) {
            *shape = patch.shape;
            let points = shapes.get(patch.shape)?.control_vertices();
            patch.flux.integrate(points, &self.origin, room, gradients);
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

/// From where coordinates are taken where nobody says so: the middle of what the members' vertices reach over, so that the gaps of what closes but for these count
/// little.
fn middle(shapes: &Shapes<'_>, members: &[On]) -> Result<Point> {
    Ok(extent(shapes, members)?.0)
}

/// For each member its sense in the shell that they are; none of what says itself what it bounds.
fn signs(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Vec<Option<f64>>> {
    let alone = by_themselves(shapes, members, what)?;
    let rest: Vec<On> =
        members.iter().zip(&alone).filter(|(_, alone)| !**alone).map(|(on, _)| on.clone()).collect();
    let mut senses = Vec::new();
    if !rest.is_empty() {
        senses = Shell::find(&shell_members(shapes, &rest, what)?, what)?.senses;
    }
    let mut senses = senses.into_iter();
    Ok(alone.into_iter().map(|alone| if alone { None } else { senses.next() }).collect())
}

fn encloses(volume: f64, size: f64, what: &str) -> Result<()> {
    let volume = volume.abs();
    if volume.is_nan() || volume <= NONE * size {
        return Err(Error::Invalid(format!(
            "{what}: it encloses no volume; only what encloses some can keep or change it"
        )));
    }
    Ok(())
}

/// The Gauss points of all edges; on rational ones six more.
fn rim(surface: &Member<'_>, what: &str) -> Result<Vec<Rim>> {
    let mut all = Vec::new();
    let shape = surface.shape;
    let more = if surface.cells.is_rational() { 6 } else { 0 };
    for (index, edge) in edges_of(shape, what)?.iter().enumerate() {
        let space = match surface.splines {
            Some(splines) => if edge.along_u { Some(splines.u) } else { splines.v }.cloned(),
            None => strips(shape, index, 0)?.into_iter().next().map(|strip| strip.space),
        };
        let Some(space) = space else { continue };
        let per = 2 * space.degree() + more;
        let (nodes, shares) = gauss_legendre(per);
        let sign = if edge.at_end { 1.0 } else { -1.0 } * if edge.along_u { -1.0 } else { 1.0 };
        for pair in space.breakpoints().windows(2) {
            let length = pair[1] - pair[0];
            for (node, share) in nodes.iter().zip(&shares) {
                let at = edge.at(pair[0] + length * node);
                let nonzero = |s: Stencil| s.iter().filter(|(_, c)| *c != 0.0).collect::<Stencil>();
                all.push(Rim {
                    point: nonzero(shape.stencil(at, Derivative::POSITION)?),
                    slope: nonzero(shape.stencil(at, edge.along(1))?),
                    weight: share * length * sign,
                });
            }
        }
    }
    Ok(all)
}
