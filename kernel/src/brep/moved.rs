//! A Brep with other control vertices.

use nalgebra::{Matrix3, Matrix4};

use super::{Brep, CurveForm, SurfaceForm};
use crate::error::{Error, Result};
use crate::spline::form::Similarity;
use crate::{Point, Vector};

impl Brep {
    /// The same Brep with other [control vertices](Self::points). What was a circle or a plane beside a spline is a spline only, unless
    /// nothing moves; tolerances stay. `O(points)`.
    ///
    /// # Errors
    /// When there are more or fewer points, or a coordinate is not finite.
    pub fn with_points(&self, points: Vec<Point>) -> Result<Self> {
        if points == self.net {
            return Ok(self.clone());
        }
        let mut moved = self.clone();
        moved.put(points)?;
        for (number, face) in moved.faces.iter_mut().enumerate() {
            let (first, len) = (self.places.faces[number], face.spaces[0].len() * face.spaces[1].len());
            if moved.net[first..first + len] != self.net[first..first + len] {
                face.form = SurfaceForm::Spline;
            }
        }
        for (number, edge) in moved.edges.iter_mut().enumerate() {
            let (first, len) = (self.places.edges[number], edge.space.len());
            if moved.net[first..first + len] != self.net[first..first + len] {
                edge.form = CurveForm::Spline;
            }
        }
        Ok(moved)
    }

    /// The Brep moved by an affine map, of which `points` are the control vertices moved. Circles and cylinders stay what they are where the
    /// map keeps angles; tolerances grow with lengths; where it mirrors, faces and loops turn round, so that outside stays outside.
    ///
    /// # Errors
    /// As for [`with_points`](Self::with_points).
    pub fn transformed(&self, points: Vec<Point>, map: &Matrix4<f64>) -> Result<Self> {
        let mut moved = self.clone();
        moved.put(points)?;
        let linear: Matrix3<f64> = map.fixed_view::<3, 3>(0, 0).into_owned();
        let shift: Vector = map.fixed_view::<3, 1>(0, 3).into_owned();
        let similarity = Similarity::of(&linear, shift);
        // No length grows by more than the largest singular value.
        let largest = linear.amax();
        let grows = if largest > 0.0 { largest * (linear / largest).singular_values().max() } else { 0.0 };
        let mirrors = largest > 0.0 && (linear / largest).determinant() < 0.0;
        for tolerance in &mut moved.tolerances {
            *tolerance = grown(*tolerance, grows)?;
        }
        for edge in &mut moved.edges {
            edge.tolerance = grown(edge.tolerance, grows)?;
            edge.form = edge.form.moved(similarity.as_ref());
        }
        for face in &mut moved.faces {
            face.form = match (face.form, &similarity) {
                (SurfaceForm::Plane { frame }, None) => plane(&frame, &linear, shift),
                (form, _) => form.moved(similarity.as_ref()),
            };
            if mirrors {
                face.reversed = !face.reversed;
                for chain in &mut face.loops {
                    chain.reverse();
                    chain.iter_mut().for_each(|one| one.reversed = !one.reversed);
                }
            }
        }
        if mirrors {
            for place in moved.uses.iter_mut().flatten() {
                let len = moved.faces[place.face].loops[place.chain].len();
                place.number = len - 1 - place.number;
            }
        }
        Ok(moved)
    }

    fn put(&mut self, points: Vec<Point>) -> Result<()> {
        let (found, expected) = (points.len(), self.net.len());
        if found != expected {
            return Err(Error::Invalid(format!("{found} points for a brep of {expected}")));
        }
        if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
        }
        self.net = points;
        self.motion = super::loose::Motion::None;
        self.known = super::flaws::Known::default();
        Ok(())
    }
}

fn grown(tolerance: f64, by: f64) -> Result<f64> {
    let length = tolerance * by;
    if length.is_finite() {
        return Ok(length);
    }
    Err(Error::Invalid(format!("its tolerance {tolerance} becomes {length}: scale it by less")))
}

/// A plane stays one under any affine map, unless that flattens it.
fn plane(frame: &super::Frame, linear: &Matrix3<f64>, shift: Vector) -> SurfaceForm {
    let (x, y) = (linear * frame.x, linear * frame.y());
    let origin = Point::from(linear * frame.origin.coords + shift);
    let frame = super::Frame::new(origin, x.cross(&y), x);
    frame.map_or(SurfaceForm::Spline, |frame| SurfaceForm::Plane { frame })
}
