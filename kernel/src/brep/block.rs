//! The simplest solid.

use super::{Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex};
use crate::Point;
use crate::error::{Error, Result};
use crate::spline::Curve;

/// The corners of the faces of a block, each counterclockwise from outside; bit 0 of a corner is x, bit 1 y, bit 2 z.
const RINGS: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

impl Brep {
    /// The solid between two corners, its faces along the axes: six planes, twelve lines, eight vertices.
    ///
    /// ```
    /// use loftsman_kernel::{Point, brep::Brep};
    /// let block = Brep::block(Point::origin(), Point::new(3.0, 2.0, 1.0))?;
    /// assert_eq!((block.face_count(), block.edge_count(), block.solids().len()), (6, 12, 1));
    /// # Ok::<(), loftsman_kernel::Error>(())
    /// ```
    ///
    /// # Errors
    /// When a coordinate is not finite, or not larger in the second corner.
    pub fn block(low: Point, high: Point) -> Result<Self> {
        if !(0..3).all(|k| low[k].is_finite() && high[k].is_finite() && low[k] < high[k]) {
            return Err(Error::Invalid(format!(
                "no block lies between {:?} and {:?}: the second corner must be beyond the first along each axis",
                low.coords.as_slice(),
                high.coords.as_slice()
            )));
        }
        let corner = |k: usize| {
            let at = |axis: usize| if k >> axis & 1 == 1 { high[axis] } else { low[axis] };
            Point::new(at(0), at(1), at(2))
        };
        let mut parts = Parts {
            vertices: (0..8).map(|k| Vertex { point: corner(k), tolerance: 0.0 }).collect(),
            shells: vec![Shell { faces: (0..RINGS.len()).collect() }],
            solids: vec![Solid::default()],
            ..Parts::default()
        };
        for ring in RINGS {
            let mut chain = Vec::with_capacity(ring.len());
            for (k, &a) in ring.iter().enumerate() {
                let b = ring[(k + 1) % ring.len()];
                let known = parts.edges.iter().position(|edge| edge.ends == [b, a]);
                chain.push(Use {
                    edge: known.unwrap_or(parts.edges.len()),
                    reversed: known.is_some(),
                    parameters: None,
                });
                if known.is_none() {
                    parts.edges.push(Edge {
                        curve: Curve::line(corner(a), corner(b))?,
                        range: (0.0, 1.0),
                        ends: [a, b],
                        tolerance: 0.0,
                        form: CurveForm::Line,
                    });
                }
            }
            let [a, b, c, _] = ring.map(corner);
            // Sides of any size: only their directions matter.
            let [along, up] = [b - a, c - b].map(|side| side / side.amax());
            let frame = Frame::new(a, along.cross(&up), along).ok_or_else(|| {
                Error::Invalid("the sides of a block are beyond what numbers can hold".into())
            })?;
            let form = SurfaceForm::Plane { frame };
            parts.faces.push(Face {
                name: None,
                color: None,
                surface: form.covering(&ring.map(corner))?,
                form,
                reversed: false,
                loops: vec![chain],
                points: Vec::new(),
            });
        }
        Self::new(parts)
    }
}
