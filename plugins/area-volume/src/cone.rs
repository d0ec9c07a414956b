//! The cones over the border of a hole, as what a flux is integrated over.

use loftsman_kernel::shape::{Border, Derivative, Hole, Shape, Stencil};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::{Error, Result};

/// Gauss points of all cones of a hole, with the rows there.
pub(crate) struct Cones {
    /// The vertices that they depend on, ascending.
    pub(crate) vertices: Vec<usize>,
    pub(crate) weights: Vec<f64>,
    /// For each point the rows of its position and of its derivatives by `s` and by `t`, one after another.
    pub(crate) rows: Vec<f64>,
}

/// Points between the apex and the border: the integrand has degree 2 there, with moments 3.
const OUTWARDS: usize = 2;

impl Cones {
    /// Of `S(s, t) = c + s (b(t) - c)` from the apex `c` over each border `b`, `s` and `t` from 0 to 1, whose rows are those of the shape at
    /// `c` and `b(t)` mixed: so are its derivatives by control vertices. `count` says how many Gauss points are taken along a border of a
    /// degree. Cost: as many stencils, twice.
    ///
    /// # Errors
    /// As for [`Shape::stencil`]; when a row has a vertex that there is not, or a number that is none.
    pub(crate) fn new(shape: &dyn Shape, hole: &Hole, count: impl Fn(usize) -> usize) -> Result<Self> {
        let apex = shape.stencil(hole.at(hole.apex), Derivative::POSITION)?;
        let mut along = Vec::new();
        for border in &hole.border {
            let (nodes, weights) = gauss_legendre(count(border.degree));
            for (t, weight) in nodes.into_iter().zip(weights) {
                let at = hole.at(border.at(t));
                along.push((
                    shape.stencil(at, Derivative::POSITION)?,
                    slope(shape, hole, border, t)?,
                    weight,
                ));
            }
        }
        let mut vertices: Vec<usize> = apex.iter().map(|(v, _)| v).collect();
        let rows = || along.iter().flat_map(|(place, slope, _)| place.iter().chain(slope.iter()));
        vertices.extend(rows().map(|(v, _)| v));
        vertices.sort_unstable();
        vertices.dedup();
        let known = vertices.last().is_none_or(|&v| v < shape.control_vertices().len());
        if !known || !apex.iter().chain(rows()).all(|(_, c)| c.is_finite()) {
            return Err(Error::Invalid(format!(
                "a shape ({}) depends on control vertices that it has not, or on no number of one, round a hole: {hole:?}",
                shape.type_name()
            )));
        }
        let dense = |stencil: &Stencil| {
            let mut row = vec![0.0; vertices.len()];
            for (v, c) in stencil.iter() {
                if let Ok(at) = vertices.binary_search(&v) {
                    row[at] += c;
                }
            }
            row
        };
        let apex = dense(&apex);
        let (outwards, shares) = gauss_legendre(OUTWARDS);
        let (mut weights, mut rows) = (Vec::new(), Vec::new());
        for (place, slope, weight) in &along {
            let (place, slope) = (dense(place), dense(slope));
            for (s, share) in outwards.iter().zip(&shares) {
                weights.push(weight * share);
                rows.extend(apex.iter().zip(&place).map(|(c, b)| (1.0 - s) * c + s * b));
                rows.extend(apex.iter().zip(&place).map(|(c, b)| b - c));
                rows.extend(slope.iter().map(|d| s * d));
            }
        }
        Ok(Self { vertices, weights, rows })
    }
}

/// The derivative along a border.
fn slope(shape: &dyn Shape, hole: &Hole, border: &Border, t: f64) -> Result<Stencil> {
    let mut sum = Stencil::new();
    for (k, by) in [[1, 0], [0, 1]].into_iter().enumerate() {
        let step = border.to[k] - border.from[k];
        if step != 0.0 {
            let row = shape.stencil(hole.at(border.at(t)), Derivative::from(by))?;
            row.iter().for_each(|(v, c)| sum.add(v, step * c));
        }
    }
    Ok(sum)
}
