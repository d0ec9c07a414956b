//! The curvature of a surface as colours of the points of its mesh.

use std::collections::{HashMap, HashSet};

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::color::{diverging, from_srgb, map_end};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{Drawn, Faceted, ParameterError, Parameters};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::curvature::{CurvatureMeasure, SurfaceCurvature};
use loftsman_kernel::text::counted;

/// What the colours show, and the curvatures at the ends of the map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paint {
    pub(super) measure: CurvatureMeasure,
    range: Option<[f64; 2]>,
}

/// Of points where nothing has a curvature, in sRGB.
const GREY: [f64; 3] = [128.0; 3];
impl Paint {
    /// What the fields `colors` and `range` say.
    pub(super) fn new(p: &Parameters) -> std::result::Result<Option<Self>, ParameterError> {
        if !p.has("colors") {
            if p.has("range") {
                return Err(p.error("range", "is one of colours: give \"colors\" too"));
            }
            return Ok(None);
        }
        let measure = p.choice("colors", &CurvatureMeasure::WORDS)?;
        let range = match p.has("range").then(|| p.numbers("range")).transpose()?.as_deref() {
            None => None,
            Some(&[low, high]) if low < high && (high - low).is_finite() => Some([low, high]),
            Some(_) => return Err(p.error("range", "needs two curvatures, the smaller first")),
        };
        Ok(Some(Self { measure, range }))
    }

    /// Gives a mesh the colours of its values, where there is none of the mean of its neighbours'; says what the colours mean.
    pub(super) fn put(self, mesh: &mut Mesh, values: Values) -> String {
        let without = values.points_without(mesh);
        let Values { of: values, corners } = values.spread(mesh);
        let [low, high] = self.range.unwrap_or_else(|| {
            let end = map_end(values.iter().flatten().copied());
            [-end, end]
        });
        // From the middle of the range: -1 at its low end, 1 at its high one.
        let share = |value: f64| if high > low { 2.0 * (value - low) / (high - low) - 1.0 } else { 0.0 };
        let color = |value: &Option<f64>| {
            let [r, g, b] = value.map_or(GREY, |v| diverging(share(v))).map(|byte| from_srgb(byte / 255.0));
            [r, g, b, 1.0]
        };
        let colors = values.iter().map(color).collect();
        let mut said = if high > low {
            let is_beyond = |v: Option<f64>| v.is_some_and(|v| !(low..=high).contains(&v));
            let beyond = points_where(mesh, |k, p| is_beyond(values[slot(&corners, k, p)]));
            let middle = 0.5 * (low + high);
            let mut said =
                format!("; {} from {low} (blue) over {middle} to {high} (vermilion)", self.measure.name());
            if beyond > 0 {
                said += &format!(", {} beyond", counted(beyond, "point[|s]"));
            }
            said
        } else {
            format!("; {} 0 everywhere", self.measure.name())
        };
        mesh.colors = match corners {
            None => Layer::per_point(colors),
            Some(corners) => Layer::per_corner(colors, corners),
        };
        if without > 0 {
            said += &format!(
                ", {}",
                counted(without, "point[|s] without one [has|have] that of [its|their] neighbours")
            );
        }
        said
    }
}

/// Values on a mesh: one for each point, or, where what is on both sides of a crease differs, several.
#[derive(Debug, Clone)]
pub(super) struct Values {
    of: Vec<Option<f64>>,
    /// Which of them each corner of the mesh has; `None` where they are those of its points.
    corners: Option<Vec<u32>>,
}

/// The number of a corner's value.
fn slot(corners: &Option<Vec<u32>>, corner: usize, point: u32) -> usize {
    corners.as_ref().map_or(point, |all| all[corner]) as usize
}

/// How many points have a corner that is so.
fn points_where(mesh: &Mesh, is_so: impl Fn(usize, u32) -> bool) -> usize {
    let corners = mesh.corners().iter().enumerate();
    corners.filter(|(k, p)| is_so(*k, **p)).map(|(_, p)| *p).collect::<HashSet<u32>>().len()
}

impl Values {
    fn points_without(&self, mesh: &Mesh) -> usize {
        points_where(mesh, |k, p| self.of[slot(&self.corners, k, p)].is_none())
    }

    /// Gives what has no value the mean of those of its faces that have one, from one to the next.
    fn spread(mut self, mesh: &Mesh) -> Self {
        let slots: Vec<usize> =
            mesh.corners().iter().enumerate().map(|(k, p)| slot(&self.corners, k, *p)).collect();
        loop {
            let mut sums = vec![(0.0, 0_u32); self.of.len()];
            for face in mesh.starts().windows(2) {
                let own = &slots[face[0]..face[1]];
                let (mut sum, mut count) = (0.0, 0);
                for value in own.iter().filter_map(|&k| self.of[k]) {
                    (sum, count) = (sum + value, count + 1);
                }
                for &k in own.iter().filter(|&&k| self.of[k].is_none()) {
                    let (all, times) = &mut sums[k];
                    (*all, *times) = (*all + sum, *times + count);
                }
            }
            let mut any = false;
            for (value, (sum, count)) in self.of.iter_mut().zip(sums) {
                if value.is_none() && count > 0 {
                    *value = Some(sum / f64::from(count));
                    any = true;
                }
            }
            if !any {
                return self;
            }
        }
    }
}

/// Corners of a mesh that have a value together: those of one point and one normal, so that a crease parts them. `None` where that is all of a point's.
fn by_normal(mesh: &Mesh) -> Option<Vec<u32>> {
    let normals = mesh.normals.corners()?;
    let mut known = HashMap::new();
    let slots: Vec<u32> = mesh
        .corners()
        .iter()
        .zip(normals)
        .map(|(point, normal)| {
            let next = known.len() as u32;
            *known.entry((*point, *normal)).or_insert(next)
        })
        .collect();
    let points = mesh.corners().iter().collect::<HashSet<_>>().len();
    (known.len() > points).then_some(slots)
}

/// The curvature of a surface on a mesh of it, from the mesh's `uvs`: where a point has several (at seams), the mean of those there, on each side of a
/// crease for itself. `None` at poles.
pub(super) fn of_surface(surface: &Surface, mesh: &Mesh, measure: CurvatureMeasure) -> Result<Values> {
    let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
    let between = |share: f64, from: f64, to: f64| (from + (to - from) * share).clamp(from, to);
    let size = size(mesh);
    let place = |corner: usize, point: u32| {
        let &[u, v] = mesh.uvs.at(corner, point)?;
        Some(Location::Surface(between(u, u0, u1), between(v, v0, v1)))
    };
    let value = |at: Location| {
        let (u, v) = at.on_surface()?;
        Ok(surface.curvature(u, v)?.map(|found| measure.beyond_rounding(&found, size)))
    };
    of_places(mesh, by_normal(mesh), place, value)
}

/// The diagonal of the box around a mesh.
fn size(mesh: &Mesh) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY].map(|end| Point::from([end; 3]));
    let [low, high] = mesh.points().iter().fold(ends, |[low, high], p| [low.inf(p), high.sup(p)]);
    (high - low).norm()
}

/// The means of the finite values at the places of what has one together (`corners`, or each point).
fn of_places(
    mesh: &Mesh,
    corners: Option<Vec<u32>>,
    place: impl Fn(usize, u32) -> Option<Location>,
    value: impl Fn(Location) -> Result<Option<f64>>,
) -> Result<Values> {
    let count = match &corners {
        None => mesh.points().len(),
        Some(all) => all.iter().max().map_or(0, |most| *most as usize + 1),
    };
    let mut sums: Vec<(f64, u32, Option<Location>)> = vec![(0.0, 0, None); count];
    for (corner, &point) in mesh.corners().iter().enumerate() {
        let Some(at) = place(corner, point) else { continue };
        let (sum, count, last) = &mut sums[slot(&corners, corner, point)];
        if *last == Some(at) {
            continue;
        }
        *last = Some(at);
        if let Some(value) = value(at)?.filter(|value| value.is_finite()) {
            (*sum, *count) = (*sum + value, *count + 1);
        }
    }
    let mean = |(sum, count, _): (f64, u32, _)| (count > 0).then(|| sum / f64::from(count));
    Ok(Values { of: sums.into_iter().map(mean).collect(), corners })
}

/// Inside a triangle and yet as good as at its corner, as a part of the way to the side beyond.
const INSIDE: f64 = 1.0 / 64.0;

/// The curvature of a shape on its triangles; nothing where it does not say where they are. At creases each side has its own, and where second derivatives
/// jump from piece to piece, as between those of degree 2, each triangle.
pub(super) fn of_shape(
    shape: &dyn Shape,
    faceted: &Faceted,
    measure: CurvatureMeasure,
) -> Option<Result<Values>> {
    let Drawn::Mesh(mesh) = &faceted.drawn else { return None };
    let size = size(mesh);
    let value = |at: Location| {
        Ok(SurfaceCurvature::of(shape, at)?.map(|found| measure.beyond_rounding(&found, size)))
    };
    let corners = &faceted.corners;
    if corners.is_empty() {
        let place = |_: usize, point: u32| faceted.places.get(point as usize).copied();
        return (!faceted.places.is_empty()).then(|| of_places(mesh, None, place, value));
    }
    let first = shape.cells().and_then(|cells| cells.iter().next());
    if !first.is_some_and(|cell| cell.sides.iter().any(|side| side.degree < 3)) {
        return Some(of_places(mesh, by_normal(mesh), |corner, _| Some(corners[corner]), value));
    }
    let own = (0..corners.len() as u32).collect();
    let inside = |corner: usize, _: u32| {
        let of = corners.get(corner / 3 * 3..corner / 3 * 3 + 3)?;
        let share = |k: usize| if k == corner % 3 { 1.0 - INSIDE } else { 0.5 * INSIDE };
        Location::mean(&[0, 1, 2].map(|k| (of[k], share(k)))).or(Some(corners[corner]))
    };
    Some(of_places(mesh, Some(own), inside, value))
}
