//! Transforms as glTF has them: translation, rotation, scale.

use loftsman_kernel::Vector;
use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, UnitQuaternion};

/// The numbers of a placement as a file has them. A map does not give them back to the last bit, so that what has not been moved goes
/// out with these.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Numbers {
    /// Column by column; instead of the others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) matrix: Option<[f64; 16]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) translation: Option<[f64; 3]>,
    /// Quaternion `x, y, z, w`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rotation: Option<[f64; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) scale: Option<[f64; 3]>,
}

impl Numbers {
    /// The placement that they say; `None` where they say none that glTF allows.
    pub(crate) fn placement(&self) -> Option<Placement> {
        if let Some(matrix) = &self.matrix {
            if self.translation.is_some() || self.rotation.is_some() || self.scale.is_some() {
                return None;
            }
            let map = Matrix4::from_column_slice(matrix);
            let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
            return Placement::of(&map).map(|parts| Placement { linear: Some(linear), ..parts });
        }
        Some(Placement {
            translation: Vector::from(self.translation.unwrap_or([0.0; 3])),
            rotation: self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            scale: Vector::from(self.scale.unwrap_or([1.0; 3])),
            linear: None,
        })
    }

    /// Whether the map that they make gives other numbers back.
    pub(crate) fn differ(&self, map: &Matrix4<f64>) -> bool {
        let own = self.placement();
        own.is_some() && own != Placement::of(map)
    }
}

/// A transform without shear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub(crate) translation: Vector,
    /// Quaternion `x, y, z, w`.
    pub(crate) rotation: [f64; 4],
    pub(crate) scale: Vector,
    /// Rotation and scale as a matrix, where rounding has sheared them: then they are those next to it.
    pub(crate) linear: Option<Matrix3<f64>>,
}

/// How far from a right angle two columns may be before the matrix goes out as it is.
const SHEAR: f64 = 1e-9;

/// How far before it counts as sheared: matrices in single precision, as other programs write them, are off by less.
const ROUNDED: f64 = 1e-6;

impl Placement {
    /// The parts of an affine map, or `None` where it shears or flattens, or has numbers that single precision (with which
    /// glTF is read) does not hold.
    pub(crate) fn of(map: &Matrix4<f64>) -> Option<Self> {
        let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
        let translation = map.fixed_view::<3, 1>(0, 3).into_owned();
        if linear == Matrix3::identity() && translation.iter().all(|t| (*t as f32).is_finite()) {
            let (rotation, scale) = ([0.0, 0.0, 0.0, 1.0], Vector::repeat(1.0));
            return Some(Self { translation, rotation, scale, linear: None });
        }
        let mut scale = Vector::from_fn(|i, _| {
            let column = linear.column(i);
            let largest = column.amax();
            if largest > 0.0 { largest * (column / largest).norm() } else { 0.0 }
        });
        let fits = |x: &f64| (*x as f32).is_finite();
        if !scale.iter().all(|s| (*s as f32).is_normal()) || !translation.iter().all(fits) {
            return None;
        }
        let mut axes = Matrix3::from_columns(&[0, 1, 2].map(|i| linear.column(i) / scale[i]));
        let apart = |i: usize, j: usize| axes.column(i).dot(&axes.column(j)).abs();
        let shear = apart(0, 1).max(apart(1, 2)).max(apart(2, 0));
        if shear > ROUNDED {
            return None;
        }
        if axes.determinant() < 0.0 {
            // A mirror is a negative scale of all axes.
            (axes, scale) = (-axes, -scale);
        }
        let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let linear = (shear > SHEAR).then_some(linear);
        Some(Self { translation, rotation: [q.i, q.j, q.k, q.w], scale, linear })
    }

    /// No move at all.
    pub(crate) fn none() -> Self {
        let (rotation, scale) = ([0.0, 0.0, 0.0, 1.0], Vector::repeat(1.0));
        Self { translation: Vector::zeros(), rotation, scale, linear: None }
    }

    /// The map that the parts make: the translation after the rotation after the scale.
    pub(crate) fn matrix(&self) -> Matrix4<f64> {
        let [i, j, k, w] = self.rotation;
        let mut map = Matrix4::identity();
        if let Some(linear) = &self.linear {
            map.fixed_view_mut::<3, 3>(0, 0).copy_from(linear);
            map.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
            return map;
        }
        let turn = if self.rotation == [0.0, 0.0, 0.0, 1.0] {
            Matrix3::identity()
        } else {
            // Normalised: files round.
            UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)).to_rotation_matrix().into_inner()
        };
        map.fixed_view_mut::<3, 3>(0, 0).copy_from(&(turn * Matrix3::from_diagonal(&self.scale)));
        map.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
        map
    }

    /// The map that the parts make, column by column.
    pub(crate) fn columns(&self) -> [f64; 16] {
        let map = self.matrix();
        std::array::from_fn(|k| map[(k % 4, k / 4)])
    }

    /// The translation, unless it is none.
    pub(crate) fn shift(&self) -> Option<[f64; 3]> {
        (self.translation != Vector::zeros()).then(|| self.translation.into())
    }

    /// The rotation, unless it is none.
    pub(crate) fn turn(&self) -> Option<[f64; 4]> {
        (self.rotation != [0.0, 0.0, 0.0, 1.0]).then_some(self.rotation)
    }

    /// The scale, unless it is one.
    pub(crate) fn stretch(&self) -> Option<[f64; 3]> {
        (self.scale != Vector::repeat(1.0)).then(|| self.scale.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;

    #[test]
    fn parts_make_the_whole_and_shear_is_refused() {
        let axis = nalgebra::Unit::new_normalize(Vector::new(1.0, 2.0, -0.5));
        for scale in [Vector::new(2.0, 3.0, 0.5), Vector::new(-1e-9, 2e-9, 1e-9), Vector::repeat(1e9)] {
            let map = Translation3::new(1.0, -2.0, 3.0).to_homogeneous()
                * Matrix4::from_axis_angle(&axis, 2.5)
                * Matrix4::new_nonuniform_scaling(&scale);
            let parts = Placement::of(&map).unwrap();
            let [i, j, k, w] = parts.rotation;
            let back = Translation3::from(parts.translation).to_homogeneous()
                * UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)).to_homogeneous()
                * Matrix4::new_nonuniform_scaling(&parts.scale);
            assert!((back - map).amax() <= 1e-14 * scale.amax().max(3.0));
        }
        let mut shear = Matrix4::identity();
        shear[(0, 1)] = 0.5;
        assert_eq!(Placement::of(&shear), None);
        assert_eq!(Placement::of(&Matrix4::zeros()), None);
        assert_eq!(Placement::of(&Matrix4::new_scaling(1e-60)), None);
        assert_eq!(Placement::of(&Matrix4::new_translation(&Vector::new(1e40, 0.0, 0.0))), None);
    }
}
