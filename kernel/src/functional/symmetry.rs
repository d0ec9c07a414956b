//! A shape that is its own mirror image.

use std::sync::Arc;

use super::position::OBJECT;
use super::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use crate::declare::{Declaration, Field, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::text::figure;
use crate::{Point, Vector};

/// Every control vertex the mirror image of its partner: `P_i - M P_j - c = 0` for each pair, with
/// `M = I - 2nnᵀ`, and `n·(P_i - o) = 0` for a vertex that is its own partner. Linear; couples the axes.
///
/// Vertices are paired by position when an edit starts: each with the one nearest to its mirror image. Vertices that are one
/// point (the seam of a closed shape, a pole) may share a partner.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetry {
    on: On,
    normal: Vector,
    point: Point,
    pairs: Vec<(usize, usize)>,
}

/// Vertices that are no farther apart than this part of the shape's size are one point.
const ONE: f64 = 1e-9;

/// Symmetry in the plane through `point` with this `normal`.
pub fn symmetry(normal: impl Into<Vector>, point: impl Into<Point>) -> Symmetry {
    Symmetry { on: On::default(), normal: normal.into(), point: point.into(), pairs: Vec::new() }
}

impl Symmetry {
    /// The same on another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    fn unit_normal(&self) -> Result<Vector> {
        crate::direction(&self.normal)
            .ok_or_else(|| Error::Invalid("symmetry: the normal is the zero vector; give a direction".into()))
    }

    /// Pairs `(i, j)` with `i ≤ j`, each vertex in one at least. `O(n log n)`: both the vertices and their images are
    /// sorted along the direction in which they spread most, and only near neighbours are compared.
    fn paired(&self, vertices: &[Point]) -> Result<Vec<(usize, usize)>> {
        let n = self.unit_normal()?;
        let mirror = |p: &Point| p - n * (2.0 * n.dot(&(p - self.point)));
        let (low, high) = vertices.iter().fold((self.point, self.point), |(low, high), p| {
            (low.inf(p).inf(&mirror(p)), high.sup(p).sup(&mirror(p)))
        });
        let size = (high - low).norm();
        let axis = (high - low).iamax();
        let mut sorted: Vec<usize> = (0..vertices.len()).collect();
        sorted.sort_by(|&a, &b| vertices[a][axis].total_cmp(&vertices[b][axis]).then(a.cmp(&b)));
        // Far enough that a shape drawn by hand pairs, near enough that nothing else does.
        let reach = 1e-3 * size;
        let mut pairs = Vec::new();
        let mut partner = vec![usize::MAX; vertices.len()];
        for i in 0..vertices.len() {
            if partner[i] != usize::MAX {
                continue;
            }
            let image = mirror(&vertices[i]);
            let start = sorted.partition_point(|&k| vertices[k][axis] < image[axis] - reach);
            let nearest = |may: &dyn Fn(usize) -> bool| {
                sorted[start..]
                    .iter()
                    .take_while(|&&k| vertices[k][axis] <= image[axis] + reach)
                    .filter(|&&k| may(k))
                    .map(|&k| ((vertices[k] - image).norm(), k))
                    .filter(|(distance, _)| *distance <= reach)
                    .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            };
            let free = nearest(&|k| partner[k] == usize::MAX);
            let shared = |k: usize| {
                let other = partner[k];
                other < vertices.len() && (vertices[other] - vertices[i]).norm() <= ONE * size
            };
            match free.or_else(|| nearest(&shared)) {
                Some((_, j)) => {
                    partner[i] = j;
                    if partner[j] == usize::MAX {
                        partner[j] = i;
                    }
                    pairs.push((i.min(j), i.max(j)));
                }
                _ => {
                    return Err(Error::Invalid(format!(
                        "symmetry{}: control vertex {i} has no partner within {} of its mirror image; \
                         make the control polygon symmetric first",
                        self.on,
                        figure(reach)
                    )));
                }
            }
        }
        Ok(pairs)
    }
}

impl Functional for Symmetry {
    fn equations(&self) -> usize {
        self.pairs.iter().map(|(i, j)| if i == j { 1 } else { 3 }).sum()
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        shapes.get(self.on.shape)?;
        let (n, shape) = (self.unit_normal()?, self.on.shape);
        let offset = n * (2.0 * n.dot(&self.point.coords));
        for &(i, j) in &self.pairs {
            if i == j {
                rows.equation().term(shape, i, n).constant(Vector::x() * -n.dot(&self.point.coords));
                continue;
            }
            for axis in 0..3 {
                // Row `axis` of P_i - (I - 2nnᵀ) P_j - 2 (n·o) n.
                let e = Vector::ith(axis, 1.0);
                rows.equation().term(shape, i, e).term(shape, j, n * (2.0 * n[axis]) - e);
                rows.constant(Vector::x() * -offset[axis]);
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("symmetry{}", self.on)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let pairs = self.paired(shapes.get(self.on.shape)?.control_vertices())?;
        Ok(Some(Arc::new(Self { pairs, ..self.clone() })))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Symmetry {
    const DECLARATION: Declaration = Declaration {
        name: "symmetry",
        help: "mirror image of itself, vertices paired by position",
        fields: &[
            Field::required("normal", "[x, y, z]", "the normal of the mirror plane"),
            Field::optional("point", "[x, y, z]", "[0, 0, 0]", "a point of the mirror plane"),
            OBJECT,
        ],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let point = if parameters.has("point") { parameters.point("point")? } else { Point::origin() };
        let on = On::from_parameters(parameters, names)?;
        Ok(Self { on, normal: parameters.vector("normal")?, point, pairs: Vec::new() })
    }
}
