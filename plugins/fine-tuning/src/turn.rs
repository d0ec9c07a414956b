//! The rotation of least angle.

use loftsman_kernel::Vector;
use nalgebra::{Matrix3, Rotation3, Unit};

/// The rotation of least angle that takes one direction to another; half a turn where they are opposite, in the plane `z = 0` where that
/// holds both. No angle is taken of a cosine, so that nothing is lost near none.
pub(crate) fn least_turn(from: &Vector, to: &Vector) -> Rotation3<f64> {
    let (Some(a), Some(b)) = (from.try_normalize(0.0), to.try_normalize(0.0)) else {
        return Rotation3::identity();
    };
    let (across, cosine) = (a.cross(&b), a.dot(&b));
    let sine = across.norm();
    if cosine < 0.0 && sine <= 1e-12 {
        let axis = if a.z.abs() <= 1e-12 { Vector::z() } else { a.cross(&Vector::x()) };
        let axis = if axis.norm() > 0.1 { axis } else { a.cross(&Vector::y()) };
        return Rotation3::from_axis_angle(&Unit::new_normalize(axis), std::f64::consts::PI);
    }
    let matrix = if cosine >= 0.0 {
        let cross = across.cross_matrix();
        Matrix3::identity() + cross + cross * cross / (1.0 + cosine)
    } else {
        // In the basis of a, what is across it towards b, and the axis: a goes where b is, however near the angle is to half a turn.
        let side = (b - a * cosine).normalize();
        let side = (side - a * a.dot(&side)).normalize();
        let axis = a.cross(&side);
        let turned = [a * cosine + side * sine, side * cosine - a * sine, axis];
        Matrix3::from_columns(&turned) * Matrix3::from_columns(&[a, side, axis]).transpose()
    };
    Rotation3::from_matrix_unchecked(matrix)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn it_is_a_rotation_that_takes_one_to_the_other_at_any_angle() {
        let from = Vector::new(0.3, -1.2, 0.7);
        for axis in [Vector::x(), Vector::z(), Vector::new(1.0, 1.0, -0.2)] {
            let axis = Unit::new_normalize(from.cross(&axis));
            for angle in [0.0, 1e-15, 1e-12, 1e-9, 3e-8, 1e-4, 0.5, 1.57, 1.6, 3.0, 3.1, PI - 1e-6, PI - 1e-9]
            {
                let to = Rotation3::from_axis_angle(&axis, angle) * from * 4e9;
                let turn = least_turn(&(from * 1e-9), &to);
                let off = (turn * from - to / 4e9).norm();
                assert!(off < 1e-14, "{angle}: {off:e}");
                let matrix = turn.matrix();
                assert!((matrix * matrix.transpose() - Matrix3::identity()).norm() < 1e-14, "{angle}");
                assert!((matrix.determinant() - 1.0).abs() < 1e-14);
                // What is across stays.
                assert!((turn * axis.into_inner() - axis.into_inner()).norm() < 1e-6, "{angle}");
            }
        }
        for (from, across) in [(Vector::new(1.0, 2.0, 0.0), true), (Vector::new(1.0, 2.0, 3.0), false)] {
            let half = least_turn(&from, &-from);
            assert!((half * from + from).norm() < 1e-14);
            assert!(!across || (half * Vector::z() - Vector::z()).norm() < 1e-14);
        }
    }
}
