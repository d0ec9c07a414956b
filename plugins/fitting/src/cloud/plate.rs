//! The energy of derivatives of a shape.

use loftsman_kernel::energy::{Energy, Squares};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{Derivative, Shape, cells_of, rows_at};
use loftsman_kernel::{Point, Vector};

/// Gauss points more than a polynomial needs, for a quotient.
const RATIONAL: usize = 8;

/// The integral of the squared derivatives of an order: 1 stretch (of a surface the membrane's), 2 bend (the thin plate's), 3 the
/// variation of these; over the shape's own parameters, of a surface `∫∫ Σ binomial(k, i) |∂ᵢ S|²`. Of shapes that say of which cells
/// they consist, exact where these are polynomials; of quotients by a fixed number of Gauss points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DerivativeEnergy(pub usize);

impl Energy for DerivativeEnergy {
    fn describe(&self) -> String {
        match self.0 {
            1 => "stretch".into(),
            2 => "bend".into(),
            3 => "variation".into(),
            order => format!("derivatives of order {order}"),
        }
    }

    fn squares(&self, shape: &dyn Shape, _origin: Point) -> Result<Option<Squares>> {
        let order = self.0;
        let what = self.describe();
        let cells = cells_of(shape, &what)?;
        let lowest = cells.degrees().into_iter().take(shape.domain().len()).min().unwrap_or(0);
        if order == 0 || lowest < order {
            // As recipes call them.
            let called = |order: usize| match order {
                1 => "\"stretch\" (or \"membrane\")".to_owned(),
                2 => "\"bend\" (or \"thin-plate\")".to_owned(),
                _ => format!("\"{}\"", Self(order).describe()),
            };
            let instead = match lowest {
                0 => "elevate it".to_owned(),
                degree => format!("ask for {}, or elevate it", called(degree.min(3))),
            };
            return Err(Error::Invalid(format!(
                "{} is of derivatives of order {order}, and the shape's degree is {lowest}: {instead}",
                called(order)
            )));
        }
        let mut squares = Squares::default();
        squares.differentiate(order);
        for cell in cells.checked(shape)? {
            squares.open(cell.vertices.iter().copied());
            let curve = cell.sides.len() < 2;
            for k in if curve { order..=order } else { 0..=order } {
                let by = Derivative { u: k, v: order - k };
                let count = |side: usize, by: usize| {
                    let degree = cell.sides.get(side).map_or(0, |side| side.degree);
                    if cell.rational { degree + RATIONAL } else { degree + 1 - by.min(degree) }
                };
                let points = cell.gauss_points([count(0, by.u), count(1, by.v)]);
                let rows = rows_at(shape, &cell, &points, by)?;
                let share = if curve { 1.0 } else { binomial(order, k) };
                for ((_, weight), row) in points.iter().zip(rows.chunks_exact(cell.vertices.len().max(1))) {
                    let root = (share * weight).sqrt();
                    squares.row(row.iter().map(|c| c * root), Vector::zeros());
                }
            }
        }
        Ok(Some(squares))
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}
