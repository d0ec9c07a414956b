//! A surface through sections.

mod align;
mod check;
mod interpolate;

use loftsman_kernel::error::MAX_DEGREE;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Error, Point};

use crate::error::{RegionError, Result};

pub use align::Aligned;
pub use check::Narrow;
use interpolate::{Collocation, averaged};

/// The most control vertices that a loft may have.
const MOST: usize = 4_000_000;

/// A surface through sections, and what was done for it and found on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Lofted {
    /// The surface: along `u` the sections, along `v` from one to the next.
    pub surface: Surface,
    /// What was done to each section.
    pub sections: Vec<Aligned>,
    /// Where along `v` each section is.
    pub parameters: Vec<f64>,
    /// The largest distance of the surface from a section as it was given, measured between the knots and at them.
    pub deviation: f64,
    /// Where it is narrowest, if it is much narrower somewhere than the sections on either side.
    pub narrow: Option<Narrow>,
}

/// The surface that passes through sections in their order: along `u` the sections, brought to a space in common, turned
/// to run the same way and begun where they face one another; along `v` a spline of `degree` (at most one less than
/// sections) through their control vertices, so that each section is met exactly.
///
/// Sections that are all closed are aligned as closed ones: each is turned round where it runs the other way, and begun at
/// the parameter at which it faces the start of the one before it (see [`Aligned`] for what was done); both are exact. If
/// one is open, all are taken as open and only reversed. Parameters along `v` are proportional to the mean distance of
/// neighbouring sections, knots are averages of them (de Boor). Rational sections are interpolated in homogeneous
/// coordinates, their weights brought to the same mean first. One banded system for all columns:
/// `O(vertices · sections · degree)`.
///
/// What is handed out has been measured: every section as it was given lies on it to rounding, and it does not swing out
/// between them.
///
/// ```
/// use loftsman_kernel::{Point, Vector, spline::Curve};
/// let lower = Curve::circle(Point::origin(), Vector::z(), 2.0)?;
/// let upper = Curve::circle(Point::new(0.0, 0.0, 3.0), -Vector::z(), 1.0)?;
/// let lofted = loftsman_regions::loft(&[lower, upper], 1)?;
/// assert!(lofted.sections[1].reversed);
/// # Ok::<(), loftsman_regions::RegionError>(())
/// ```
///
/// # Errors
/// With fewer than two sections, a degree outside 1 to 25, sections that coincide or have too many knots together, spaces
/// that cannot be made common, or weights that do not stay positive between sections; where the surface would swing out
/// between its sections (a high degree through many), or miss one.
pub fn loft(sections: &[Curve], degree: usize) -> Result<Lofted> {
    if sections.len() < 2 {
        return Err(RegionError::Sections("a loft needs two sections at least".into()));
    }
    if degree == 0 || degree > MAX_DEGREE {
        return Err(Error::Degree { degree }.into());
    }
    let (aligned, changes) = align::align(sections)?;
    let common = in_one_space(&with_knots_met(sections, aligned)?)?;
    let v = parameters(&common)?;
    let surface = through(&common, &v, degree.min(sections.len() - 1))?;
    let mut lofted = Lofted { surface, sections: changes, parameters: v, deviation: 0.0, narrow: None };
    lofted.look_between()?;
    lofted.measure(sections)?;
    Ok(lofted)
}

/// The surface through sections in one space, at parameters `v`.
fn through(sections: &[Curve], v: &[f64], degree: usize) -> Result<Surface> {
    let (rows, columns) = (sections.len(), sections[0].points().len());
    let space = Space::open(degree, averaged(v, degree))?;
    let Some(collocation) = Collocation::new(&space, v)? else {
        return Err(RegionError::Sections(
            "neighbouring sections are too near to one another, beside how far others are: leave one out"
                .into(),
        ));
    };
    let rational = sections.iter().any(|s| s.weights().is_some());
    // A common factor on all weights of a section changes nothing on it, but between it and the next: one mean for all.
    let mean =
        |s: &Curve| s.weights().map_or(0.0, |w| w.iter().map(|w| w.ln()).sum::<f64>() / w.len() as f64);
    let factors: Vec<f64> = sections
        .iter()
        .map(|s| mean(&sections[0]) - mean(s))
        .map(|log| if log.abs() <= 1e-12 { 1.0 } else { log.exp() })
        .collect();
    let mut points = vec![Point::origin(); columns * rows];
    let mut weights = vec![1.0; if rational { columns * rows } else { 0 }];
    // In units of about their size, a power of two, so that nothing is rounded: products with weights then neither
    // overflow nor vanish.
    let size = size_of(sections).log2().floor().exp2();
    let mut values = vec![[0.0; 4]; rows];
    for i in 0..columns {
        for ((value, section), factor) in values.iter_mut().zip(sections).zip(&factors) {
            let w = section.weights().map_or(1.0, |w| w[i]) * factor;
            let p = section.points()[i] / size;
            *value = [p.x * w, p.y * w, p.z * w, w];
        }
        collocation.solve(&mut values);
        for (j, &[x, y, z, w]) in values.iter().enumerate() {
            let w = if rational { w } else { 1.0 };
            if w <= 0.0 || w.is_nan() {
                return Err(RegionError::Sections(format!(
                    "the weights of vertex {i} do not stay positive between the sections: lower the degree (3 seldom fails, 1 never)"
                )));
            }
            if rational {
                weights[i * rows + j] = w;
            }
            points[i * rows + j] = Point::new(x / w * size, y / w * size, z / w * size);
        }
    }
    Ok(Surface::build(sections[0].space().clone(), space, points, rational.then_some(weights))?)
}

/// The largest coordinate, never zero.
fn size_of(sections: &[Curve]) -> f64 {
    sections.iter().flat_map(Curve::points).fold(f64::MIN_POSITIVE, |m, p| m.max(p.coords.amax()))
}

/// The aligned sections with knots that differ by rounding alone made equal, so that no column is spun between two that are
/// one. What rounding is depends on the domain in which a section was given: far from zero its knots are known less well.
fn with_knots_met(given: &[Curve], aligned: Vec<Curve>) -> Result<Vec<Curve>> {
    let mut met: Vec<f64> = Vec::new();
    let mut out = Vec::with_capacity(aligned.len());
    for (given, curve) in given.iter().zip(aligned) {
        let (a, b) = given.domain();
        let (start, end) = curve.domain();
        let blur = 1.0 + a.abs().max(b.abs()) / (b - a);
        let slack = 16.0 * f64::EPSILON * (end - start) * blur.min(1e9);
        let nearest = |k: f64| {
            let at = met.partition_point(|&t| t < k);
            let beside =
                [at.checked_sub(1), Some(at)].into_iter().flatten().filter_map(|i| met.get(i).copied());
            beside.filter(|t| (t - k).abs() <= slack).min_by(|s, t| (s - k).abs().total_cmp(&(t - k).abs()))
        };
        let (space, points, weights) = curve.into_parts();
        // The ends are met as they are, and what lies beyond them in an open space stays.
        let knots: Vec<f64> = space
            .knots()
            .iter()
            .map(|&k| if k > start && k < end { nearest(k).unwrap_or(k) } else { k })
            .collect();
        let space = if space.is_periodic() {
            Space::periodic(space.degree(), knots)?
        } else {
            Space::open(space.degree(), knots)?
        };
        met.extend(space.breakpoints());
        met.sort_by(f64::total_cmp);
        met.dedup();
        out.push(Curve::build(space, points, weights)?);
    }
    Ok(out)
}

fn in_one_space(sections: &[Curve]) -> Result<Vec<Curve>> {
    let Some(first) = sections.first() else { return Ok(Vec::new()) };
    let mut all = first.clone();
    for section in &sections[1..] {
        all = all.in_common_space(section)?.0;
        if all.points().len() * sections.len() > MOST {
            return Err(RegionError::Sections(format!(
                "the sections' knots, all together, would make a surface of more than {MOST} control vertices: \
                 refine the sections alike, so that they share their knots"
            )));
        }
    }
    let mut out = vec![all.clone()];
    for section in &sections[1..] {
        let (same, section) = all.in_common_space(section)?;
        if same.space() != all.space() {
            return Err(RegionError::Sections(
                "the sections' knots are too near to one another to be told apart: refine the sections alike"
                    .into(),
            ));
        }
        out.push(section);
    }
    Ok(out)
}

/// Places at which the distance of neighbouring sections is taken.
const PLACES: usize = 128;

/// Parameters from 0 to 1, proportional to the mean distance of neighbouring sections at equal parameters: whatever knots
/// they have.
fn parameters(sections: &[Curve]) -> Result<Vec<f64>> {
    // In units of the size, so that no square overflows or vanishes.
    let size = size_of(sections);
    let sampled = |section: &Curve| -> Result<Vec<Point>> {
        let (a, b) = section.domain();
        let at = |i: usize| section.point(a + (b - a) * (i as f64 + 0.5) / PLACES as f64);
        Ok((0..PLACES).map(at).collect::<Result<_, _>>()?)
    };
    let mut v = vec![0.0];
    let mut sum = 0.0;
    let mut last = sampled(&sections[0])?;
    for (j, section) in sections.iter().enumerate().skip(1) {
        let next = sampled(section)?;
        let mean =
            last.iter().zip(&next).map(|(p, q)| (q / size - p / size).norm()).sum::<f64>() / PLACES as f64;
        if !(mean > 8.0 * f64::EPSILON && mean.is_finite()) {
            return Err(RegionError::Sections(format!("sections {} and {j} coincide: leave one out", j - 1)));
        }
        sum += mean;
        v.push(sum);
        last = next;
    }
    v.iter_mut().for_each(|x| *x /= sum);
    if let Some(last) = v.last_mut() {
        *last = 1.0;
    }
    Ok(v)
}
