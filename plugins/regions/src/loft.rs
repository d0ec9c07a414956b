//! A surface through closed sections.

use loftsman_kernel::solve::{Automatic, Solver, SparseRows, System, SystemMetric};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Error, Point, Vector};

use crate::error::{RegionError, Result};

/// The surface that passes through sections in their order: along `u` the sections, brought to a space in common and
/// turned to run the same way round, along `v` a spline of `degree` (at most one less than sections) through their
/// control vertices, so that each section is met exactly.
///
/// Parameters along `v` are proportional to the mean distance of neighbouring sections' vertices, knots are averages
/// of them (de Boor). Rational sections are interpolated in homogeneous coordinates. Where sections start is their
/// maker's choice: start points are joined by a line of the surface. One banded system for all columns:
/// `O(vertices · sections · degree)`.
///
/// # Errors
/// With fewer than two sections, two that coincide, spaces that cannot be made common, or weights that do not stay
/// positive between sections.
pub fn loft(sections: &[Curve], degree: usize) -> Result<Surface> {
    let (Some(first), true) = (sections.first(), sections.len() > 1) else {
        return Err(RegionError::Sections("a loft needs two sections at least".into()));
    };
    if degree == 0 {
        return Err(Error::Degree { degree }.into());
    }
    let sections = in_one_space(&one_way_round(sections)?)?;
    let columns = first_len(&sections);
    let rows = sections.len();
    let v = parameters(&sections)?;
    let degree = degree.min(rows - 1);
    let space = Space::open(degree, averaged(&v, degree))?;
    let mut collocation = SparseRows::with_capacity(rows, rows, rows * (degree + 1));
    let mut basis = vec![0.0; degree + 1];
    for &v in &v {
        let span = space.span(v);
        space.basis_into(span, v, 0, &mut basis);
        collocation.push(basis.iter().enumerate().map(|(k, &b)| (span - degree + k, b)));
    }
    let system = System::new(collocation, (0..rows).collect(), 3, SystemMetric::Least);
    let mut factored = Automatic
        .factor(&system)
        .map_err(|e| RegionError::Sections(format!("the sections cannot be interpolated: {e}")))?;
    if factored.rank() < rows {
        return Err(RegionError::Sections("neighbouring sections are too near to one another".into()));
    }
    let rational = first.weights().is_some() || sections.iter().any(|s| s.weights().is_some());
    let weight = |s: &Curve, i: usize| s.weights().map_or(1.0, |w| w[i]);
    let mut points = vec![Point::origin(); columns * rows];
    let mut weights = vec![1.0; if rational { columns * rows } else { 0 }];
    let (mut rhs, mut net) = (vec![0.0; 3 * rows], vec![0.0; 3 * rows]);
    for i in 0..columns {
        if rational {
            for (j, section) in sections.iter().enumerate() {
                rhs[3 * j] = weight(section, i);
            }
            factored.solve_into(&rhs, &mut net);
            for j in 0..rows {
                let w = net[3 * j];
                if w <= 0.0 || w.is_nan() {
                    return Err(RegionError::Sections(format!(
                        "the weights of vertex {i} do not stay positive between the sections: lower the degree to 1"
                    )));
                }
                weights[i * rows + j] = w;
            }
        }
        for (j, section) in sections.iter().enumerate() {
            let p = section.points()[i].coords * weight(section, i);
            rhs[3 * j..3 * j + 3].copy_from_slice(p.as_slice());
        }
        factored.solve_into(&rhs, &mut net);
        for j in 0..rows {
            let w = if rational { weights[i * rows + j] } else { 1.0 };
            points[i * rows + j] = Point::from(Vector::from_column_slice(&net[3 * j..3 * j + 3]) / w);
        }
    }
    Ok(Surface::build(sections[0].space().clone(), space, points, rational.then_some(weights))?)
}

fn first_len(sections: &[Curve]) -> usize {
    sections.first().map_or(0, |s| s.points().len())
}

/// Each section turned to run round as the one before it: their area vectors must not oppose one another.
fn one_way_round(sections: &[Curve]) -> Result<Vec<Curve>> {
    let mut out: Vec<Curve> = Vec::with_capacity(sections.len());
    let mut before = Vector::zeros();
    for section in sections {
        let mut area = area_vector(section.points());
        let mut section = section.clone();
        if area.dot(&before) < 0.0 {
            section = section.reverse()?;
            area = -area;
        }
        before = area;
        out.push(section);
    }
    Ok(out)
}

fn area_vector(points: &[Point]) -> Vector {
    let Some(origin) = points.first() else { return Vector::zeros() };
    points.windows(2).fold(Vector::zeros(), |sum, w| sum + (w[0] - origin).cross(&(w[1] - origin)))
}

fn in_one_space(sections: &[Curve]) -> Result<Vec<Curve>> {
    let Some(first) = sections.first() else { return Ok(Vec::new()) };
    let mut all = first.clone();
    for section in &sections[1..] {
        all = all.in_common_space(section)?.0;
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

/// Parameters from 0 to 1, proportional to the mean distance of neighbouring sections' control vertices.
fn parameters(sections: &[Curve]) -> Result<Vec<f64>> {
    let mut v = vec![0.0];
    let mut sum = 0.0;
    for (j, pair) in sections.windows(2).enumerate() {
        let both = pair[0].points().iter().zip(pair[1].points());
        let mean = both.map(|(p, q)| (q - p).norm()).sum::<f64>() / pair[0].points().len() as f64;
        if mean <= 0.0 || !mean.is_finite() {
            return Err(RegionError::Sections(format!("sections {j} and {} coincide: leave one out", j + 1)));
        }
        sum += mean;
        v.push(sum);
    }
    v.iter_mut().for_each(|x| *x /= sum);
    Ok(v)
}

/// Clamped knots whose inner ones are means of `degree` parameters each (de Boor 1978, chapter XIII).
fn averaged(v: &[f64], degree: usize) -> Vec<f64> {
    let mut knots = vec![0.0; degree + 1];
    knots.extend(v[1..v.len() - 1].windows(degree).map(|w| w.iter().sum::<f64>() / degree as f64));
    knots.extend(vec![1.0; degree + 1]);
    knots
}
