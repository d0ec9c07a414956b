//! An object on the stage.

use std::sync::Arc;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::mesh::color::to_srgb;
use loftsman_kernel::plugin::{Chord, CustomShape, Drawn, Fineness, Splines};
use loftsman_kernel::scene::{Geometry, Object};
use loftsman_kernel::shape::{Grid, grid_or_row};
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Error, Point, Vector};
use nalgebra::Vector4;

use super::laid::Laid;
use super::piece::Piece;
use super::shell::Shell;
use super::solid::{ANGLE, Solid};
use super::trim::Trim;
use crate::error::PictureError;
use crate::theme::Color;

/// An object in stage coordinates.
#[derive(Debug)]
pub(crate) struct Body<'a> {
    pub(crate) object: &'a Object,
    /// Which colour of the palette it has: an object and its state before have the same.
    pub(crate) index: usize,
    pub(crate) form: Form,
    /// The control vertices of a plug-in's shape, of which the form has none: it may be drawn as splines that have
    /// others.
    pub(crate) vertices: Vec<Vector>,
    /// The edges between them, of a shape that says which are neighbours.
    pub(crate) edges: Vec<[usize; 2]>,
    /// Why a Brep is not drawn, or what of it.
    pub(crate) missing: Option<String>,
}

impl<'a> Body<'a> {
    /// An object whose points, or those of the solid that shows it, are `points` on the stage, and whose normals `normal` turns there.
    pub(crate) fn of(
        object: &'a Object,
        index: usize,
        solid: Option<&Arc<Solid>>,
        points: Vec<Vector>,
        normal: impl Fn(&Vector) -> Vector,
    ) -> Result<Self, PictureError> {
        if let Some(solid) = solid {
            let normals = solid.normals.iter().map(&normal).collect();
            let missing = solid.remark.clone();
            let form = Form::Solid(Shell { skin: Arc::clone(&solid.skin), points, normals, laid: None });
            return Ok(Self { object, index, form, vertices: Vec::new(), edges: Vec::new(), missing });
        }
        let custom = matches!(object.geometry(), Geometry::Custom(_));
        let vertices = if custom { points.clone() } else { Vec::new() };
        let edges = edges(object.geometry());
        let form = Form::of(object.geometry(), points, normal)?;
        Ok(Self { object, index, form, vertices, edges, missing: None })
    }

    /// The control vertices, of what has them.
    pub(crate) fn net(&self) -> Option<&[Vector]> {
        match &self.form {
            _ if !self.vertices.is_empty() => Some(&self.vertices),
            Form::Curve { net, .. } | Form::Surface { net, .. } => Some(net),
            _ => None,
        }
    }
}

/// The edges of the cage of a plug-in's shape; none where it does not say which vertices are neighbours.
fn edges(geometry: &Geometry) -> Vec<[usize; 2]> {
    let Geometry::Custom(custom) = geometry else { return Vec::new() };
    let Some(neighbours) = custom.shape().ok().and_then(|shape| shape.neighbours()) else {
        return Vec::new();
    };
    let count = custom.points().len();
    let later =
        |v: usize| neighbours.around(v).into_iter().filter(move |&w| v < w && w < count).map(move |w| [v, w]);
    (0..count).flat_map(later).collect()
}

/// How far triangles may be from a plug-in's shape, as a part of its size: no facet is seen, for they are lit by the shape's normals.
const OF_SHAPES: f64 = 1e-3;

/// What there is to draw of an object.
#[derive(Debug)]
pub(crate) enum Form {
    /// Nothing.
    Empty,
    /// A curve: its Bézier pieces, one a knot span, and its control vertices.
    Curve { pieces: Vec<Piece>, net: Vec<Vector>, closed: bool },
    /// A surface in stage coordinates, with its control net, and what counts of it.
    Surface { surface: Box<Surface>, net: Vec<Vector>, grid: Grid, trim: Option<Trim> },
    /// A polyline.
    Polyline { points: Vec<Vector>, closed: bool },
    /// A mesh: points, corners, face starts, the segments of its loose lines, and by corner, where it has any, normals (of any length)
    /// and colours.
    Mesh {
        points: Vec<Vector>,
        corners: Vec<u32>,
        starts: Vec<usize>,
        lines: Vec<(usize, usize)>,
        normals: Vec<Vector>,
        colors: Vec<Color>,
    },
    /// A Brep, or a plug-in's surface.
    Solid(Shell),
    /// Loose points.
    Cloud(Vec<Vector>),
}

impl Form {
    /// What there is to draw of a geometry whose points are `points` on the stage, and whose normals `normal` turns there.
    pub(crate) fn of(
        geometry: &Geometry,
        points: Vec<Vector>,
        normal: impl Fn(&Vector) -> Vector,
    ) -> Result<Self, PictureError> {
        Ok(match geometry {
            Geometry::Curve(curve) => {
                Self::Curve { pieces: pieces(curve, &points)?, closed: curve.is_periodic(), net: points }
            }
            Geometry::Surface(surface) => Self::surface(surface, points, None)?,
            Geometry::Trimmed(trimmed) => Self::surface(trimmed.surface(), points, Trim::of(trimmed)?)?,
            Geometry::Mesh(mesh) => {
                let corners = mesh.corners().to_vec();
                let of =
                    |(corner, &point)| mesh.normals.at(corner, point).map_or_else(Vector::zeros, &normal);
                let given = !mesh.normals.values().is_empty();
                let normals = if given { corners.iter().enumerate().map(of).collect() } else { Vec::new() };
                let (colors, lines) = (colors(mesh), segments(mesh));
                Self::Mesh { points, corners, starts: mesh.starts().to_vec(), lines, normals, colors }
            }
            Geometry::Polyline(line) => Self::Polyline { points, closed: line.closed },
            Geometry::Cloud(_) => Self::Cloud(points),
            Geometry::Custom(custom) => Self::custom(custom, &points)?,
            _ => Self::Empty,
        })
    }

    /// A plug-in's shape: the spline that it is, where it is one, else its segments or triangles. What is unknown is
    /// nothing.
    fn custom(custom: &CustomShape, points: &[Vector]) -> Result<Self, PictureError> {
        if custom.shape().is_err() {
            return Ok(Self::Empty);
        }
        // The way to the stage is affine, and so is that from the vertices to the shape.
        let points: Vec<Point> = points.iter().map(|p| Point::from(*p)).collect();
        let staged = custom.with_points(&points)?;
        let coordinates = |points: &[Point]| points.iter().map(|p| p.coords).collect::<Vec<_>>();
        match staged.splines() {
            Some(Splines::Curves(curves)) if curves.len() == 1 => {
                let net = coordinates(curves[0].points());
                return Ok(Self::Curve {
                    pieces: pieces(&curves[0], &net)?,
                    closed: curves[0].is_periodic(),
                    net,
                });
            }
            // Of many faces all borders are told apart, where a spline that closes on itself has seams.
            Some(Splines::Surfaces(surfaces)) if surfaces.len() == 1 && staged.shape()?.faces().is_none() => {
                return Self::surface(&surfaces[0], coordinates(surfaces[0].points()), None);
            }
            _ => {}
        }
        let fineness = Fineness { chord: Chord::Relative(OF_SHAPES), angle: ANGLE.to_radians() };
        let (drawn, corners) = match staged.tessellate(&fineness) {
            Ok(found) => (found.drawn, found.corners),
            // A point.
            Err(Error::NoExtent(_)) => return Ok(Self::Cloud(coordinates(&points[..points.len().min(1)]))),
            Err(error) => return Err(error.into()),
        };
        match drawn {
            Drawn::Line(line) => {
                Ok(Self::Polyline { points: coordinates(&line.points), closed: line.closed })
            }
            Drawn::Mesh(mesh) => {
                if let Some(shell) = Laid::shell(staged, mesh.clone(), &corners)? {
                    return Ok(Self::Solid(shell));
                }
                let points = coordinates(mesh.points());
                Self::of(&mesh.into(), points, |normal| *normal)
            }
        }
    }

    fn surface(surface: &Surface, points: Vec<Vector>, trim: Option<Trim>) -> Result<Self, PictureError> {
        let staged = points.iter().map(|p| Point::from(*p)).collect();
        let (u, v, _, weights) = surface.clone().into_parts();
        let grid = grid_or_row(surface);
        let surface = Box::new(Surface::build(u, v, staged, weights)?);
        Ok(Self::Surface { surface, net: points, grid, trim })
    }
}

/// What cannot be told apart on paper, in units of the stage: a micrometre of a page of usual size.
const ALIKE: f64 = 1e-5;

impl Form {
    /// Whether two forms look alike: the same to rounding, as by a change of units and back.
    pub(crate) fn alike(&self, other: &Self) -> bool {
        let near = |a: &[Vector], b: &[Vector]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).amax() <= ALIKE)
        };
        match (self, other) {
            (Self::Empty, Self::Empty) => true,
            (
                Self::Curve { pieces, net, closed },
                Self::Curve { pieces: others, net: other, closed: other_closed },
            ) => {
                let same = |a: &Piece, b: &Piece| {
                    a.control.len() == b.control.len()
                        && (0..a.control.len()).all(|i| (a.vertex(i) - b.vertex(i)).amax() <= ALIKE)
                        && (!(a.rational || b.rational) || (a.point(0.5) - b.point(0.5)).amax() <= ALIKE)
                };
                closed == other_closed
                    && near(net, other)
                    && pieces.len() == others.len()
                    && pieces.iter().zip(others).all(|(a, b)| same(a, b))
            }
            (
                Self::Surface { surface, net, trim, .. },
                Self::Surface { surface: other, net: others, trim: other_trim, .. },
            ) => {
                near(net, others)
                    && trim == other_trim
                    && (surface.u(), surface.v(), surface.weights())
                        == (other.u(), other.v(), other.weights())
            }
            (Self::Polyline { points, closed }, Self::Polyline { points: others, closed: other_closed }) => {
                closed == other_closed && near(points, others)
            }
            (
                Self::Mesh { points, corners, starts, lines, colors, .. },
                Self::Mesh {
                    points: others,
                    corners: other_corners,
                    starts: other_starts,
                    lines: other_lines,
                    colors: other_colors,
                    ..
                },
            ) => {
                (corners, starts, lines, colors) == (other_corners, other_starts, other_lines, other_colors)
                    && near(points, others)
            }
            (Self::Solid(shell), Self::Solid(other)) => {
                let (skin, others) = (&shell.skin, &other.skin);
                (&skin.triangles, &skin.colors) == (&others.triangles, &others.colors)
                    && near(&shell.points, &other.points)
            }
            (Self::Cloud(points), Self::Cloud(others)) => near(points, others),
            _ => false,
        }
    }
}

/// The segments of a mesh's loose lines, each once and those without length left out.
fn segments(mesh: &Mesh) -> Vec<(usize, usize)> {
    let ends = |pair: &[u32]| (pair[0].min(pair[1]) as usize, pair[0].max(pair[1]) as usize);
    let mut segments: Vec<_> = mesh.lines().flat_map(|line| line.windows(2).map(ends)).collect();
    segments.retain(|(a, b)| a != b);
    segments.sort_unstable();
    segments.dedup();
    segments
}

/// The colours of a mesh by corner; none where it has none, or not everywhere.
fn colors(mesh: &Mesh) -> Vec<Color> {
    let byte = |linear: f64| (to_srgb(linear.clamp(0.0, 1.0)) * 255.0).round() as u8;
    let of = |(corner, &point)| mesh.colors.at(corner, point).map(|&[r, g, b, _]| Color([r, g, b].map(byte)));
    mesh.corners().iter().enumerate().map(of).collect::<Option<_>>().unwrap_or_default()
}

/// The Bézier pieces of a curve whose control vertices are replaced by `points`, one a non-empty knot span.
///
/// # Errors
/// Only when numbers overflow.
pub(crate) fn pieces(curve: &Curve, points: &[Vector]) -> Result<Vec<Piece>, PictureError> {
    let staged = points.iter().map(|p| Point::from(*p)).collect();
    let weights = curve.weights().map(<[f64]>::to_vec);
    let form = Curve::build(curve.space().clone(), staged, weights)?.bezier_form()?;
    let p = form.degree();
    let homogeneous: Vec<Vector4<f64>> = form
        .points()
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let w = form.weights().map_or(1.0, |w| w[i]);
            (point.coords * w).push(w)
        })
        .collect();
    let piece = |span: usize| {
        let control = homogeneous[span - p..=span].to_vec();
        let rational = control.iter().any(|c| (c.w - control[0].w).abs() > 1e-14 * control[0].w.abs());
        Piece { control, rational }
    };
    // By knots, not by counting: a knot of multiplicity p + 1, where the curve is torn, has a vertex of its own on either side.
    Ok(form.space().spans().map(piece).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::spline::Space;

    #[test]
    fn pieces_are_the_curve() {
        for (space, rational) in [
            (Space::clamped(3, &[0.0, 1.0, 2.5, 3.0]).unwrap(), true),
            (Space::periodic(2, vec![0.0, 0.4, 1.0, 1.5, 2.0]).unwrap(), false),
            (Space::floating_uniform(4, 7).unwrap(), true),
            (
                Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.0, 3.0, 4.0, 4.0, 4.0])
                    .unwrap(),
                true,
            ),
            (
                Space::open(3, vec![-1.0, -0.5, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.5, 3.0, 4.0]).unwrap(),
                false,
            ),
        ] {
            let n = space.len();
            let net: Vec<Vector> =
                (0..n).map(|i| Vector::new((i * i) as f64 % 5.0, i as f64, (i * 7 % 3) as f64)).collect();
            let weights = rational.then(|| (0..n).map(|i| 1.0 + i as f64 / 3.0).collect());
            let points = net.iter().map(|p| Point::from(*p)).collect();
            let curve = Curve::build(space, points, weights).unwrap();
            let breaks = curve.space().breakpoints();
            let pieces = pieces(&curve, &net).unwrap();
            assert_eq!(pieces.len() + 1, breaks.len());
            for (piece, span) in pieces.iter().zip(breaks.windows(2)) {
                let h = span[1] - span[0];
                let jet = piece.jet(0.25);
                let u = span[0] + 0.25 * h;
                for (order, value) in [jet.point, jet.first / h, jet.second / (h * h)].iter().enumerate() {
                    let expected = curve.derivative(u, order).unwrap();
                    assert!((value - expected).norm() < 1e-11 * (1.0 + expected.norm()), "{order}");
                }
            }
        }
    }
}
