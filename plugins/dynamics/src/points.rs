//! The Gauss points of a body: where its energy is summed up, prepared once.

use loftsman_kernel::shape::{Cell, Derivative, Location, Shape, cells_of, rows_at};
use loftsman_kernel::{Point, Vector};

use crate::body::Material;
use crate::error::{DynamicsError, Result};

/// Where the shape's speed is less than this share of the mean, it has no length there.
const COLLAPSED: f64 = 1e-9;

/// So many vertices a span, in each direction, are more than the points of a degree see; and how many points more do.
const LOOSE: f64 = 1.2;
const MORE: usize = 1;
/// With so many a span a curve finds shapes between these points as well, and with so many a cell a surface (Bézier chains and patches, few spans).
const FREE: [f64; 2] = [1.5, 4.0];

/// How many points a span has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rule {
    /// As many as its degree `p`, or one more: where it bends within its spans these let it.
    Few,
    /// `2p - 1` where it has many vertices a span, of a surface `2p + 1` in each direction where it has many a cell.
    Full,
}

/// The Gauss points of one cell.
#[derive(Debug, Clone)]
pub(crate) struct CellPoints {
    /// Where its vertices start in [`Points::vertices`], and how many there are.
    pub(crate) vertices: usize,
    pub(crate) width: usize,
    /// Its points, by their numbers.
    pub(crate) first: usize,
    pub(crate) count: usize,
    /// Where its rows start: for each point and each direction one of `width` numbers.
    pub(crate) rows: usize,
    /// The face, of a surface of many.
    pub(crate) face: Option<u32>,
}

/// What is known of one point.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rest {
    /// The Gauss weight in parameters.
    pub(crate) weight: f64,
    /// The speed at rest, in each direction.
    pub(crate) speed: [f64; 2],
    /// Of a surface: the cosine of the angle of its directions, and the area of a unit of parameters, both at the start.
    pub(crate) cosine: f64,
    pub(crate) measure: f64,
    /// The length or area of a unit of parameters at rest: what energies are summed up over.
    pub(crate) size: f64,
}

/// Gauss points with the rows of first derivatives. With `p` points a span for degree `p`, squares of derivatives are exact; where a span has
/// more than its share of vertices, one more from degree 3 on, or what the points do not see would stretch; on
/// surfaces one more in each direction always.
///
/// A curve with half as many vertices again as spans, or more (Bézier chains, few spans), is free to be as long as at rest at all of these and anything between, folds
/// among it; a surface of four times as many as cells is. `|P'|²` is of degree `2p - 2`: where it is that at rest at `2p - 1` points it is so everywhere, so that with these nothing rests stretched that steps do not see.
/// Of more spans the smoothness at their ends does as much, and so many points would hold a rope straight that turns within a few of them (of degree 2 or 3).
#[derive(Debug, Clone)]
pub(crate) struct Points {
    pub(crate) directions: usize,
    pub(crate) cells: Vec<CellPoints>,
    pub(crate) vertices: Vec<u32>,
    pub(crate) rows: Vec<f64>,
    pub(crate) rest: Vec<Rest>,
}

/// First derivatives, rows of a direction's order.
pub(crate) fn order(direction: usize, times: usize) -> Derivative {
    if direction == 0 { Derivative { u: times, v: 0 } } else { Derivative { u: 0, v: times } }
}

/// Whether there are many more vertices than cells: in each direction by a fifth.
fn is_loose(vertices: usize, cells: usize, directions: usize) -> bool {
    vertices as f64 > LOOSE.powi(directions as i32) * cells as f64
}

/// Whether a shape of so many cells, `kept` together where its knots do not, has so many vertices that it needs the full rule.
fn is_free(shape: &dyn Shape, cells: usize, kept: usize) -> bool {
    let vertices = shape.control_vertices().len().saturating_sub(kept);
    vertices as f64 >= FREE[usize::from(shape.domain().len() == 2)] * cells as f64
}

/// Round extraordinary vertices cells are halved again and again: the smaller its share of a face, the fewer points a cell needs.
fn enough(cell: &Cell, direction: usize) -> usize {
    let side = cell.sides.get(direction).map_or(1.0, |side| side.end - side.start);
    match cell.face {
        Some(_) if side <= 1.0 / 16.0 => 1,
        Some(_) if side <= 1.0 / 4.0 => 2,
        _ => usize::MAX,
    }
}

impl Points {
    pub(crate) fn new(shape: &dyn Shape, material: &Material, kept: usize, rule: Rule) -> Result<Self> {
        let directions = shape.domain().len();
        let mut all =
            Self { directions, cells: Vec::new(), vertices: Vec::new(), rows: Vec::new(), rest: Vec::new() };
        let vertices = shape.control_vertices();
        let mut least = (f64::INFINITY, None);
        let (mut speeds, mut weights) = (0.0, 0.0);
        let cells = cells_of(shape, "a simulation")?.checked(shape)?;
        let loose = is_loose(vertices.len(), cells.len(), directions);
        let full = rule == Rule::Full && is_free(shape, cells.len(), kept);
        for cell in cells {
            let count = |k: usize| {
                let degree = cell.sides.get(k).map_or(0, |side| side.degree);
                // With fewer a sheet has ways to stretch that cost nothing, most of them in degree 1: all of its cells are seen in full.
                let more = if directions == 2 || degree >= 3 && loose { MORE } else { 0 };
                let own = if cell.rational { degree + 4 } else { degree.max(1) + more };
                // `|P_u|²` is of degree `2p - 2` along `u`, `|P_v|²` of `2p`.
                let all = if directions == 2 { 2 * degree + 1 } else { (2 * degree).saturating_sub(1) };
                let own = if full { own.max(all) } else { own };
                own.min(enough(&cell, k))
            };
            let points = cell.gauss_points([count(0), count(1)]);
            let width = cell.vertices.len();
            let first = all.rest.len();
            all.cells.push(CellPoints {
                vertices: all.vertices.len(),
                width,
                first,
                count: points.len(),
                rows: all.rows.len(),
                face: cell.face,
            });
            all.vertices.extend(cell.vertices.iter().map(|&v| v as u32));
            let each: Vec<Vec<f64>> = (0..directions)
                .map(|k| rows_at(shape, &cell, &points, order(k, 1)))
                .collect::<loftsman_kernel::Result<_>>()?;
            for (index, (at, weight)) in points.iter().enumerate() {
                let mut tangents = [Vector::zeros(); 2];
                for k in 0..directions {
                    let row = &each[k][index * width..][..width];
                    tangents[k] = apply(row, &cell.vertices, vertices);
                    all.rows.extend_from_slice(row);
                }
                let rest = Rest::new(*weight, &tangents, directions, material.rest);
                for k in 0..directions {
                    let speed = tangents[k].norm();
                    if speed.is_nan() || speed < least.0 {
                        least = (speed, Some(*at));
                    }
                    speeds += speed * weight;
                    weights += weight;
                }
                all.rest.push(rest);
            }
        }
        let mean = speeds / weights;
        if !(least.0 > COLLAPSED * mean && mean.is_finite()) {
            let at = least.1.map_or_else(|| "every place".to_owned(), |at: Location| at.to_string());
            return Err(DynamicsError::Collapsed { at, surface: directions == 2 });
        }
        Ok(all)
    }

    /// The vertices of a cell.
    pub(crate) fn of(&self, cell: &CellPoints) -> &[u32] {
        &self.vertices[cell.vertices..cell.vertices + cell.width]
    }

    /// The rows of a point of a cell, one direction's behind the other's.
    pub(crate) fn rows_of(&self, cell: &CellPoints, point: usize) -> &[f64] {
        let length = self.directions * cell.width;
        &self.rows[cell.rows + point * length..][..length]
    }

    /// The row of a point of a cell in a direction.
    pub(crate) fn row(&self, cell: &CellPoints, point: usize, direction: usize) -> &[f64] {
        &self.rows[cell.rows + (point * self.directions + direction) * cell.width..][..cell.width]
    }
}

impl Rest {
    pub(crate) fn new(weight: f64, tangents: &[Vector; 2], directions: usize, factor: f64) -> Self {
        let speeds = [tangents[0].norm(), tangents[1].norm()];
        let (cosine, measure) = match directions {
            2 => (
                tangents[0].dot(&tangents[1]) / (speeds[0] * speeds[1]),
                tangents[0].cross(&tangents[1]).norm(),
            ),
            _ => (0.0, speeds[0]),
        };
        let size = measure * factor.powi(directions as i32);
        Self { weight, speed: speeds.map(|s| s * factor), cosine, measure, size }
    }
}

fn apply(row: &[f64], vertices: &[usize], points: &[Point]) -> Vector {
    row.iter().zip(vertices).fold(Vector::zeros(), |sum, (c, &v)| sum + points[v].coords * *c)
}
