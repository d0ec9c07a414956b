//! Parameters for points: where along the curve each one is expected.

use loftsman_kernel::{Point, Vector};

use crate::error::{FitError, Result};
use crate::frame::Frame;

/// How parameters are given to points. All but [`Given`](Self::Given) run from 0 to 1; around a closed curve 1 is
/// where the first point comes again.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Parametrization {
    /// Proportional to the distance between neighbours: the default, near to arc length.
    #[default]
    ChordLength,
    /// Proportional to the square root of the distance (Lee 1989): tighter at sharp turns among uneven distances.
    Centripetal,
    /// The same step between all neighbours.
    Uniform,
    /// These, one a point, increasing. Around a closed curve one more, at which the first point comes again.
    Given(Vec<f64>),
}

impl Parametrization {
    /// Parameters for points: one a point and, where `closed`, one more at which the first point comes again.
    ///
    /// They do not decrease; coincident neighbours get the same parameter (except by
    /// [`Uniform`](Self::Uniform)). `O(n)`.
    ///
    /// # Errors
    /// When a coordinate is not finite, all points are the same, or given parameters do not fit.
    pub fn parameters(&self, points: &[Point], closed: bool) -> Result<Vec<f64>> {
        let frame = Frame::of(points)?;
        let local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
        self.of_local(&local, closed)
    }

    pub(crate) fn of_local(&self, points: &[Vector], closed: bool) -> Result<Vec<f64>> {
        let wanted = points.len() + usize::from(closed);
        let root = match self {
            Self::ChordLength => false,
            Self::Centripetal => true,
            Self::Uniform => {
                let steps = wanted.saturating_sub(1).max(1) as f64;
                return Ok((0..wanted).map(|i| i as f64 / steps).collect());
            }
            Self::Given(values) => return given(values, wanted),
        };
        let mut parameters = Vec::with_capacity(wanted);
        let mut sum = 0.0;
        parameters.push(0.0);
        let around = closed.then(|| points.first()).flatten();
        for (a, b) in points.iter().zip(points.iter().skip(1).chain(around)) {
            let distance = (b - a).norm();
            sum += if root { distance.sqrt() } else { distance };
            parameters.push(sum);
        }
        if sum == 0.0 {
            return Err(FitError::AllEqual { count: points.len() });
        }
        for u in &mut parameters {
            *u /= sum;
        }
        Ok(parameters)
    }
}

fn given(values: &[f64], wanted: usize) -> Result<Vec<f64>> {
    if values.len() != wanted {
        return Err(FitError::ParameterCount { parameters: values.len(), points: wanted });
    }
    let (start, end) = match (values.first(), values.last()) {
        (Some(&a), Some(&b)) => (a, b),
        _ => return Ok(Vec::new()),
    };
    for (index, &value) in values.iter().enumerate() {
        let before = if index == 0 { start } else { values[index - 1] };
        if !(value.is_finite() && value >= before) {
            return Err(FitError::Parameter { index, value, start, end });
        }
    }
    if end == start {
        return Err(FitError::Parameter { index: values.len() - 1, value: end, start, end });
    }
    Ok(values.to_vec())
}

/// Indices `i` whose parameter cannot be told from that of point `i - 1` (`i = n` of a closed curve: the first
/// point again). "Cannot be told": closer than a few units of rounding of the domain's length.
pub(crate) fn coincident(parameters: &[f64]) -> Vec<usize> {
    let (Some(a), Some(b)) = (parameters.first(), parameters.last()) else { return Vec::new() };
    let least = 8.0 * f64::EPSILON * (b - a).max(a.abs()).max(b.abs());
    (1..parameters.len()).filter(|&i| parameters[i] - parameters[i - 1] <= least).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<Point> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 4.0), (1.0, 4.0), (-3.0, 4.0)]
            .map(|(x, y)| Point::new(x, y, 0.0))
            .to_vec()
    }

    #[test]
    fn chord_centripetal_uniform() {
        let chord = Parametrization::ChordLength.parameters(&points(), false).unwrap();
        assert_eq!(chord, [0.0, 1.0 / 9.0, 5.0 / 9.0, 5.0 / 9.0, 1.0]);
        let root = Parametrization::Centripetal.parameters(&points(), false).unwrap();
        assert_eq!(root, [0.0, 0.2, 0.6, 0.6, 1.0]);
        let closed = Parametrization::ChordLength.parameters(&points(), true).unwrap();
        assert_eq!(closed, [0.0, 1.0 / 14.0, 5.0 / 14.0, 5.0 / 14.0, 9.0 / 14.0, 1.0]);
        assert_eq!(coincident(&closed), [3]);
        let even = Parametrization::Uniform.parameters(&points(), true).unwrap();
        assert_eq!(even, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    }

    #[test]
    fn given_parameters_are_checked() {
        let give = |values: &[f64]| Parametrization::Given(values.to_vec()).parameters(&points(), false);
        assert!(matches!(give(&[0.0, 1.0]), Err(FitError::ParameterCount { parameters: 2, points: 5 })));
        assert!(matches!(give(&[0.0, 1.0, 0.5, 2.0, 3.0]), Err(FitError::Parameter { index: 2, .. })));
        assert!(matches!(give(&[0.0, 1.0, f64::NAN, 2.0, 3.0]), Err(FitError::Parameter { index: 2, .. })));
        assert!(give(&[1.0; 5]).is_err());
    }
}
