//! The curvature of a surface as colours of the points of its mesh.

use loftsman_kernel::error::Result;
use loftsman_kernel::mesh::color::from_srgb;
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{ParameterError, Parameters};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::curvature::SurfaceCurvature;

/// Which curvature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    Mean,
    Gaussian,
    Maximum,
    Minimum,
}

impl Measure {
    const WORDS: [(&str, Self); 4] = [
        ("mean", Self::Mean),
        ("gaussian", Self::Gaussian),
        ("maximum", Self::Maximum),
        ("minimum", Self::Minimum),
    ];

    fn of(self, at: &SurfaceCurvature) -> f64 {
        match self {
            Self::Mean => at.mean,
            Self::Gaussian => at.gaussian,
            Self::Maximum => at.principal[0],
            Self::Minimum => at.principal[1],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean curvature",
            Self::Gaussian => "Gaussian curvature",
            Self::Maximum => "larger principal curvature",
            Self::Minimum => "smaller principal curvature",
        }
    }
}

/// A colour map: the ends are two colours of Okabe and Ito (2008), "Color universal design", which colour-blind readers can tell apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paint {
    pub(super) measure: Measure,
    range: Option<[f64; 2]>,
}

/// sRGB.
const MAP: [[f64; 3]; 3] = [[0.0, 114.0, 178.0], [245.0, 245.0, 245.0], [213.0, 94.0, 0.0]];
/// Of points where nothing has a curvature.
const GREY: [f64; 3] = [128.0; 3];
/// Without a range, this part of the points is within the ends of the map.
const WITHIN: f64 = 0.98;

impl Paint {
    /// What the fields `colors` and `range` say.
    pub(super) fn new(p: &Parameters) -> std::result::Result<Option<Self>, ParameterError> {
        if !p.has("colors") {
            if p.has("range") {
                return Err(p.error("range", "is one of colours: give \"colors\" too"));
            }
            return Ok(None);
        }
        let measure = p.choice("colors", &Measure::WORDS)?;
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
            let end = end_of(&values);
            [-end, end]
        });
        let share =
            |value: f64| if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        let color = |value: &Option<f64>| {
            let [r, g, b] = value.map_or(GREY, |v| mapped(share(v))).map(|byte| from_srgb(byte / 255.0));
            [r, g, b, 1.0]
        };
        mesh.colors = Layer::per_point(values.iter().map(color).collect());
        let mut said = if high > low {
            let beyond = values.iter().flatten().filter(|v| !(low..=high).contains(v)).count();
            let middle = 0.5 * (low + high);
            let mut said =
                format!("; {} from {low} (blue) over {middle} to {high} (vermilion)", self.measure.name());
            if beyond > 0 {
                said += &format!(", {beyond} points beyond");
            }
            said
        } else {
            format!("; {} 0 everywhere", self.measure.name())
        };
        if without > 0 {
            said += &format!(", {without} points without one have that of their neighbours");
        }
        said
    }
}

/// The colour at a share of the map.
fn mapped(share: f64) -> [f64; 3] {
    let (from, to, t) = if share < 0.5 { (0, 1, 2.0 * share) } else { (1, 2, 2.0 * share - 1.0) };
    std::array::from_fn(|k| MAP[from][k] + (MAP[to][k] - MAP[from][k]) * t)
}

/// The size that most values are within, to three digits.
fn end_of(values: &[Option<f64>]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().flatten().map(|v| v.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let at = (sizes.len() as f64 * WITHIN).ceil() as usize;
    let size = sizes.get(at.saturating_sub(1)).copied().unwrap_or(0.0);
    format!("{size:.2e}").parse().unwrap_or(size)
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
pub(super) fn of_surface(surface: &Surface, mesh: &Mesh, measure: Measure) -> Result<Vec<Option<f64>>> {
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
    measure: Measure,
) -> Option<Result<Vec<Option<f64>>>> {
    let value = |&at: &Location| {
        let found = SurfaceCurvature::of(shape, at)?.map(|at| measure.of(&at));
        Ok(found.filter(|value| value.is_finite()))
    };
    (!places.is_empty()).then(|| places.iter().map(value).collect())
}
