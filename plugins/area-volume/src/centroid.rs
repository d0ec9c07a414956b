//! Where the middle of what is enclosed lies.

use std::sync::Arc;

use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::{Point, Result, Vector};

use crate::members::{OBJECT, OBJECTS, curve, is_surface};
use crate::plane::Plane;
use crate::region::{HOLES, NORMAL, Region};
use crate::rule::Rule;
use crate::solid::{Solid, Work};

/// The centroid of the region inside closed curves, or of the solid inside closed surfaces: first moments over area (or
/// volume). Three equations, a point; nonlinear.
///
/// In a plane the moments are `⅓ ∮ C (n·(C × C')) du`, of degree 3; across it (`n`), where the region itself lies at. Of a
/// solid, `¼ ∫∫ S (S·(S_u × S_v)) du dv`. Which shapes, holes and normals: as for [`Area`](crate::Area) and
/// [`Volume`](crate::Volume).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Centroid {
    region: Region,
    bound: Option<Arc<Bound>>,
}

#[derive(Debug, PartialEq)]
enum Bound {
    Plane { plane: Plane, pieces: Vec<Piece> },
    Solid(Solid),
}

#[derive(Debug)]
struct Piece {
    shape: usize,
    sign: f64,
    rule: Rule,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape && self.sign == other.sign && self.rule.values == other.rule.values
    }
}

/// The centroid of what the first shape of the problem encloses.
pub fn centroid() -> Centroid {
    Centroid::default()
}

/// The point, and for each shape the derivatives of its x, y and z by each vertex.
type Linearized = (Point, Vec<(usize, [Vec<Vector>; 3])>);

impl Centroid {
    /// The same of another shape of the problem.
    #[must_use]
    pub fn on(self, shape: impl Into<On>) -> Self {
        self.of([shape])
    }

    /// Of what these shapes bound together.
    #[must_use]
    pub fn of<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.region.members = shapes.into_iter().collect();
        self
    }

    /// Less the insides of these curves, whichever way they run.
    #[must_use]
    pub fn holes<T: Into<On>>(mut self, shapes: impl IntoIterator<Item = T>) -> Self {
        self.region.holes = Some(shapes.into_iter().collect());
        self
    }

    /// Of curves' projection along this normal.
    #[must_use]
    pub fn normal(mut self, normal: impl Into<Vector>) -> Self {
        self.region.normal = Some(normal.into());
        self
    }

    fn prepared(&self, shapes: &Shapes<'_>) -> Result<Arc<Bound>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        let what = self.describe();
        let members = &self.region.members.0;
        if let Some(first) = members.first()
            && is_surface(shapes, first)?
        {
            return Ok(Arc::new(Bound::Solid(Solid::new(shapes, members, true, &what)?)));
        }
        let outline = self.region.outline(shapes, &what)?;
        let plane = outline.plane;
        let mut pieces = Vec::with_capacity(outline.pieces.len());
        for piece in &outline.pieces {
            let own = curve(shapes, &On::from(piece.shape), &what, "ask for curves and surfaces apart")?;
            // The moments' integrand has degree 3p - 1; the polar moment, which never vanishes, settles last.
            let polar = |rule: &Rule, points: &[Point]| {
                let mut sum = 0.0;
                rule.along(points, &plane.origin, |c, d, weight, _| {
                    sum += weight * plane.normal.dot(&c.cross(&d)) * c.norm_squared();
                });
                sum
            };
            let rule = Rule::settled(&own, (3 * own.cells.degrees()[0]).saturating_sub(1), polar)?;
            pieces.push(Piece { shape: piece.shape, sign: piece.sign, rule });
        }
        Ok(Arc::new(Bound::Plane { plane, pieces }))
    }

    fn linearized(&self, shapes: &Shapes<'_>) -> Result<Linearized> {
        match self.prepared(shapes)?.as_ref() {
            Bound::Plane { plane, pieces } => planar(shapes, plane, pieces),
            Bound::Solid(solid) => {
                let mut work = Work::default();
                let measured = solid.measure(shapes, &mut work)?;
                let [volume, moments @ ..] = measured.values;
                let middle = Vector::from(moments) / volume;
                let gradients = measured.gradients.iter().map(|(shape, gradients)| {
                    let of = |k: usize| {
                        let both = gradients[k + 1].iter().zip(&gradients[0]);
                        both.map(|(m, v)| (m - v * middle[k]) / volume).collect()
                    };
                    (*shape, std::array::from_fn(of))
                });
                Ok((solid.origin + middle, gradients.collect()))
            }
        }
    }
}

fn planar(shapes: &Shapes<'_>, plane: &Plane, pieces: &[Piece]) -> Result<Linearized> {
    let normal = plane.normal;
    let (mut area, mut moment) = (0.0, Vector::zeros());
    let mut gradients = Vec::with_capacity(pieces.len());
    for piece in pieces {
        let points = shapes.get(piece.shape)?.control_vertices();
        let mut of_area = vec![Vector::zeros(); points.len()];
        let mut of_moment: [Vec<Vector>; 3] = std::array::from_fn(|_| of_area.clone());
        piece.rule.along(points, &plane.origin, |c, d, weight, local| {
            let weight = weight * piece.sign;
            let swept = normal.dot(&c.cross(&d));
            area += 0.5 * weight * swept;
            moment += c * (weight * swept / 3.0);
            // Of n·(C × C'), by C and by C'.
            let (by_point, by_slope) = (d.cross(&normal) * weight, normal.cross(&c) * weight);
            local.add(by_point * 0.5, by_slope * 0.5, &mut of_area);
            for (k, gradient) in of_moment.iter_mut().enumerate() {
                let mut value = by_point * (c[k] / 3.0);
                value[k] += weight * swept / 3.0;
                local.add(value, by_slope * (c[k] / 3.0), gradient);
            }
        });
        gradients.push((piece.shape, of_area, of_moment));
    }
    // Sectors from the origin have their centroids at two thirds of their height above it; the boundary's is wanted.
    let lift = |v: Vector| v + normal * (0.5 * normal.dot(&v));
    let gradients = gradients.into_iter().map(|(shape, of_area, of_moment)| {
        let along: Vec<[Vector; 3]> = (0..of_area.len())
            .map(|i| {
                // Row k: the derivative of component k of M / A by vertex i.
                let rows: [Vector; 3] =
                    std::array::from_fn(|k| (of_moment[k][i] - of_area[i] * (moment[k] / area)) / area);
                let across = (0..3).fold(Vector::zeros(), |sum, k| sum + rows[k] * normal[k]) * 0.5;
                std::array::from_fn(|k| rows[k] + across * normal[k])
            })
            .collect();
        (shape, std::array::from_fn(|k| along.iter().map(|rows| rows[k]).collect()))
    });
    Ok((plane.origin + lift(moment / area), gradients.collect()))
}

impl Functional for Centroid {
    fn equations(&self) -> usize {
        3
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn linearize(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>, value: &mut [f64]) -> Result<()> {
        let (point, gradients) = self.linearized(shapes)?;
        for axis in 0..3 {
            rows.equation();
            for (shape, by_axis) in &gradients {
                rows.terms(*shape, 0, by_axis[axis].iter().copied());
            }
        }
        value.iter_mut().zip(point.iter()).for_each(|(out, p)| *out = *p);
        Ok(())
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        self.linearize(shapes, rows, &mut [])
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let (point, _) = self.linearized(shapes)?;
        out.iter_mut().zip(point.iter()).for_each(|(out, p)| *out = *p);
        Ok(())
    }

    fn describe(&self) -> String {
        format!("centroid{}", self.region.describe())
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn companions(&self) -> Vec<Arc<dyn Functional>> {
        self.region.companions()
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = Some(self.prepared(shapes)?);
        Ok(Some(Arc::new(Self { bound, ..self.clone() })))
    }

    fn is_vector(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Centroid {
    const DECLARATION: Declaration = Declaration {
        name: "centroid",
        help: "the centroid of what closed curves, or closed surfaces, enclose",
        fields: &[NORMAL, OBJECT, OBJECTS, HOLES],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self { region: Region::from_parameters(parameters, names)?, bound: None })
    }
}
