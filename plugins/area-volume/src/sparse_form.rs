//! The area's bilinear form of a curve that is no spline.

use loftsman_kernel::{Result, Vector};

use crate::form::AreaForm;
use crate::members::Member;
use crate::rule::Rule;

/// `Φ` with `2A = xᵀΦy`, of whichever curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Form {
    /// Of a spline: banded.
    Banded(AreaForm),
    /// Of a curve that consists of other cells: its entries above the diagonal, `(i, j, Φ_ij)`, the others being their negatives.
    Sparse(Vec<(u32, u32, f64)>),
}

impl Form {
    /// The form of the curves that differ from this one in their control vertices only; by Gauss points, exact where the cells are
    /// polynomial, refined until the areas settle where they are rational.
    pub(crate) fn of(curve: &Member<'_>) -> Result<Self> {
        if let Some(splines) = curve.splines {
            return Ok(Self::Banded(AreaForm::of_splines(splines.u, splines.weights)?));
        }
        let [degree, _] = curve.cells.degrees();
        let middle = crate::members::middle_of(curve.points());
        let rule = Rule::settled(curve, (2 * degree).saturating_sub(1), |rule, points| {
            let mut swept = Vector::zeros();
            rule.along(points, &middle, |c, d, weight, _| swept += c.cross(&d) * weight);
            swept.norm()
        })?;
        let mut entries = Vec::new();
        for panel in 0..rule.panels() {
            let vertices = rule.vertices_of(panel);
            let points = panel * rule.per..(panel + 1) * rule.per;
            for (i, &a) in vertices.iter().enumerate() {
                for (j, &b) in vertices.iter().enumerate().skip(i + 1) {
                    let sum = points.clone().fold(0.0, |sum, at| {
                        let (values, slopes) = rule.functions(at);
                        sum + rule.weights[at] * (values[i] * slopes[j] - slopes[i] * values[j])
                    });
                    if sum != 0.0 {
                        entries.push((a, b, sum));
                    }
                }
            }
        }
        entries.sort_by_key(|&(i, j, _)| (i, j));
        entries.dedup_by(|later, kept| {
            let same = (later.0, later.1) == (kept.0, kept.1);
            if same {
                kept.2 += later.2;
            }
            same
        });
        Ok(Self::Sparse(entries))
    }

    /// Coordinates as [`apply`](Self::apply) takes them.
    pub(crate) fn padded(&self, values: impl Iterator<Item = f64>, out: &mut Vec<f64>) {
        match self {
            Self::Banded(form) => form.padded(values, out),
            Self::Sparse(_) => {
                out.clear();
                out.extend(values);
            }
        }
    }

    /// `Φx` and `Φy`.
    pub(crate) fn apply(&self, x: &[f64], y: &[f64], out_x: &mut [f64], out_y: &mut [f64]) {
        match self {
            Self::Banded(form) => form.apply(x, y, out_x, out_y),
            Self::Sparse(entries) => {
                out_x.fill(0.0);
                out_y.fill(0.0);
                for &(i, j, value) in entries {
                    let (i, j) = (i as usize, j as usize);
                    out_x[i] += value * x[j];
                    out_x[j] -= value * x[i];
                    out_y[i] += value * y[j];
                    out_y[j] -= value * y[i];
                }
            }
        }
    }
}
