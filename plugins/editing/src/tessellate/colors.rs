//! The curvature of a surface as colours of the points of its mesh.

use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::color::{diverging, from_srgb, map_end};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{ParameterError, Parameters};
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

    /// Gives each point of a mesh the colour of its value, or of the mean of its neighbours' where it has none; says what the colours mean.
    pub(super) fn put(self, mesh: &mut Mesh, mut values: Vec<Option<f64>>) -> String {
        let without = values.iter().filter(|v| v.is_none()).count();
        spread(mesh, &mut values);
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
        mesh.colors = Layer::per_point(values.iter().map(color).collect());
        let mut said = if high > low {
            let beyond = values.iter().flatten().filter(|v| !(low..=high).contains(v)).count();
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
        if without > 0 {
            said += &format!(
                ", {}",
                counted(without, "point[|s] without one [has|have] that of [its|their] neighbours")
            );
        }
        said
    }
}

/// Gives points that have no value the mean of those of their faces that have one, from one point to the next.
fn spread(mesh: &Mesh, values: &mut [Option<f64>]) {
    loop {
        let mut sums = vec![(0.0, 0_u32); values.len()];
        for face in mesh.starts().windows(2) {
            let corners = &mesh.corners()[face[0]..face[1]];
            let (mut sum, mut count) = (0.0, 0);
            for value in corners.iter().filter_map(|&p| values[p as usize]) {
                (sum, count) = (sum + value, count + 1);
            }
            for &p in corners.iter().filter(|&&p| values[p as usize].is_none()) {
                let (all, times) = &mut sums[p as usize];
                (*all, *times) = (*all + sum, *times + count);
            }
        }
        let mut any = false;
        for (value, (sum, count)) in values.iter_mut().zip(sums) {
            if value.is_none() && count > 0 {
                *value = Some(sum / f64::from(count));
                any = true;
            }
        }
        if !any {
            return;
        }
    }
}

/// The curvature of a surface at each point of a mesh of it, from the mesh's `uvs`: where a point has several (at seams), the mean of
/// those there. `None` at poles.
pub(super) fn of_surface(
    surface: &Surface,
    mesh: &Mesh,
    measure: CurvatureMeasure,
) -> Result<Vec<Option<f64>>> {
    let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
    let between = |share: f64, from: f64, to: f64| (from + (to - from) * share).clamp(from, to);
    let mut sums: Vec<(f64, u32, Option<[f64; 2]>)> = vec![(0.0, 0, None); mesh.points().len()];
    for (corner, &point) in mesh.corners().iter().enumerate() {
        let Some(&uv) = mesh.uvs.at(corner, point) else { continue };
        let (sum, count, last) = &mut sums[point as usize];
        if *last == Some(uv) {
            continue;
        }
        *last = Some(uv);
        if let Some(at) = surface.curvature(between(uv[0], u0, u1), between(uv[1], v0, v1))? {
            let value = measure.of(&at);
            if value.is_finite() {
                (*sum, *count) = (*sum + value, *count + 1);
            }
        }
    }
    Ok(sums.into_iter().map(|(sum, count, _)| (count > 0).then(|| sum / f64::from(count))).collect())
}

/// The curvature of a shape at places on it; nothing where it does not say where its points are.
pub(super) fn of_shape(
    shape: &dyn Shape,
    places: &[Location],
    measure: CurvatureMeasure,
) -> Option<Result<Vec<Option<f64>>>> {
    let value = |&at: &Location| {
        let found = SurfaceCurvature::of(shape, at)?.map(|at| measure.of(&at));
        Ok(found.filter(|value| value.is_finite()))
    };
    (!places.is_empty()).then(|| places.iter().map(value).collect())
}
