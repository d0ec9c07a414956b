//! Where things are: transforms of geometry, the way up a hierarchy, and scenes in another unit or up axis.

use std::borrow::Cow;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use nalgebra::{Matrix3, Matrix4};

use crate::error::{Error, Result};
use crate::mesh::{Cloud, Mesh, Polyline};
use crate::scene::{Definition, Geometry, Object, Scene, Unit, Up};
use crate::spline::form::affine;
use crate::spline::{Curve, Surface};
use crate::{Point, Vector};

impl Up {
    /// The rotation that turns this axis up into `to`: a signed permutation, exact on every number.
    ///
    /// From z to y it is `(x, y, z) → (x, z, -y)`, as glTF and OBJ programs have it, from z to x
    /// `(x, y, z) → (z, y, -x)`; all others follow from these, so that a turn by way of a third axis is the same
    /// turn.
    pub fn turn(self, to: Self) -> Matrix3<f64> {
        from_z(to) * from_z(self).transpose()
    }
}

#[rustfmt::skip]
fn from_z(to: Up) -> Matrix3<f64> {
    match to {
        Up::X => Matrix3::new(0.0, 0.0, 1.0,  0.0, 1.0, 0.0,  -1.0, 0.0, 0.0),
        Up::Y => Matrix3::new(1.0, 0.0, 0.0,  0.0, 0.0, 1.0,  0.0, -1.0, 0.0),
        Up::Z => Matrix3::identity(),
    }
}

impl Geometry {
    /// The geometry moved by an affine map (the last row is taken as `0 0 0 1`).
    ///
    /// Groups and instances have no points and stay as they are. Splines follow their control vertices; their weights stay, and loops stay where they are in the parameter plane.
    /// What is a circle or a cylinder beside a spline stays one where the map keeps angles.
    /// Normals follow the cofactor matrix, tangents the map itself, and both come
    /// out with unit length; a map that mirrors reverses the faces, so that outside stays outside. `O(points)`.
    ///
    /// # Errors
    /// When a coordinate overflows; [`Error::UnknownKind`] where its plug-in is not here.
    pub fn transformed(&self, map: &Matrix4<f64>) -> Result<Self> {
        let moved = self.points().iter().map(|p| transform_point(map, p)).collect();
        match self {
            Self::Mesh(mesh) => Ok(Self::Mesh(transform_mesh(mesh, moved, map)?)),
            Self::Curve(curve) => Ok(Self::Curve(curve.transformed(map)?)),
            Self::Surface(surface) => Ok(Self::Surface(surface.transformed(map)?)),
            Self::Brep(brep) => Ok(Self::Brep(brep.transformed(moved, map)?)),
            other => other.with_points(moved),
        }
    }

    /// The same geometry with other points ([`points`](Self::points)): what it is in a frame of its animation. A mesh's
    /// normals stay; what was a circle beside a spline is a spline only, unless nothing moves. `O(points)`.
    ///
    /// # Errors
    /// When there are more or fewer points than it has, or a coordinate is not finite; [`Error::UnknownKind`] where
    /// its plug-in is not here.
    pub fn with_points(&self, points: Vec<Point>) -> Result<Self> {
        let (found, expected) = (points.len(), self.points().len());
        if found != expected {
            let kind = crate::text::a(&self.noun());
            return Err(Error::Invalid(format!("{found} points for {kind} of {expected}")));
        }
        Ok(match self {
            Self::Group => Self::Group,
            Self::Instance(definition) => Self::Instance(definition.clone()),
            Self::Curve(curve) if points == curve.points() => Self::Curve(curve.clone()),
            Self::Curve(curve) => Self::Curve(Curve::build(
                curve.space().clone(),
                points,
                curve.weights().map(<[f64]>::to_vec),
            )?),
            Self::Surface(surface) if points == surface.points() => Self::Surface(surface.clone()),
            Self::Surface(surface) => Self::Surface(surface_through(surface, points)?),
            Self::Trimmed(trimmed) => Self::Trimmed(trimmed.on(surface_through(trimmed.surface(), points)?)?),
            Self::Brep(brep) => Self::Brep(brep.with_points(points)?),
            Self::Mesh(mesh) => {
                let mut mesh = mesh.clone();
                mesh.points_mut().copy_from_slice(&finite(points)?);
                Self::Mesh(mesh)
            }
            Self::Polyline(line) => Self::Polyline(Polyline { points: finite(points)?, closed: line.closed }),
            Self::Cloud(_) => Self::Cloud(Cloud { points: finite(points)? }),
            Self::Custom(custom) => Self::Custom(custom.with_points(&points)?),
        })
    }
}

fn surface_through(surface: &Surface, points: Vec<Point>) -> Result<Surface> {
    let weights = surface.weights().map(<[f64]>::to_vec);
    Surface::build(surface.u().clone(), surface.v().clone(), points, weights)
}

/// An affine map on a point: `A p + t`.
pub fn transform_point(map: &Matrix4<f64>, p: &Point) -> Point {
    affine(map, p)
}

fn finite(points: Vec<Point>) -> Result<Vec<Point>> {
    match points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
        Some((index, p)) => Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z }),
        None => Ok(points),
    }
}

fn transform_mesh(mesh: &Mesh, points: Vec<Point>, map: &Matrix4<f64>) -> Result<Mesh> {
    let linear = map.fixed_view::<3, 3>(0, 0).into_owned();
    let largest = linear.amax();
    // Only the direction of normals counts: scaled to 1, the cofactors cannot overflow or vanish by size.
    let a = if largest > 0.0 { linear / largest } else { linear };
    let mirrors = a.determinant() < 0.0;
    let mut moved = mesh.clone();
    moved.points_mut().copy_from_slice(&finite(points)?);
    if mirrors {
        moved.reverse_faces();
    }
    let (x, y, z) = (a.column(0), a.column(1), a.column(2));
    let cofactors = Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]);
    let sign = if mirrors { -1.0 } else { 1.0 };
    // Where axes change their places and all have one scale, directions keep their numbers: brought to length 1 again and again they would wander by rounding.
    let keeps = a.iter().all(|x| [-1.0, 0.0, 1.0].contains(x))
        && a.column_iter().all(|column| column.abs().sum() == 1.0);
    let direction = |turned: Vector| if keeps { turned } else { turned.try_normalize(0.0).unwrap_or(turned) };
    for n in moved.normals.values_mut() {
        *n = direction(cofactors * *n * sign);
    }
    for t in moved.tangents.values_mut() {
        let unit = direction(a * Vector::new(t[0], t[1], t[2]));
        // n × t turns round under a mirror, and the bitangent does not.
        *t = [unit.x, unit.y, unit.z, t[3] * sign];
    }
    Ok(moved)
}

/// From lengths in one unit and axes to another: `s R`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The turn of the axes.
    pub turn: Matrix3<f64>,
    /// What a length is multiplied by.
    pub scale: f64,
}

impl Change {
    /// From a unit and up axis to another. Numbers keep their size where one of the units is unknown.
    pub fn between(from: (Unit, Up), to: (Unit, Up)) -> Self {
        let scale = match (from.0.metres(), to.0.metres()) {
            (Some(from), Some(to)) if from != to => from / to,
            _ => 1.0,
        };
        Self { turn: from.1.turn(to.1), scale }
    }

    /// No change.
    pub fn none() -> Self {
        Self { turn: Matrix3::identity(), scale: 1.0 }
    }

    /// Whether nothing changes.
    pub fn is_none(&self) -> bool {
        self.scale == 1.0 && self.turn == Matrix3::identity()
    }

    /// The change as a map of points.
    pub fn map(&self) -> Matrix4<f64> {
        let mut map = Matrix4::identity();
        map.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.turn * self.scale));
        map
    }

    /// A transform between objects, `M T M⁻¹`; to the bit where nothing changes.
    pub fn of_transform(&self, transform: &Matrix4<f64>) -> Matrix4<f64> {
        if self.is_none() {
            // To the bit: a product would take their sign from zeros.
            return *transform;
        }
        let linear = self.turn * transform.fixed_view::<3, 3>(0, 0) * self.turn.transpose();
        let shift = self.turn * transform.fixed_view::<3, 1>(0, 3) * self.scale;
        let mut changed = *transform;
        changed.fixed_view_mut::<3, 3>(0, 0).copy_from(&linear);
        changed.fixed_view_mut::<3, 1>(0, 3).copy_from(&shift);
        changed
    }
}

impl Scene {
    /// Each object's map into the scene's coordinates: the product of the transforms from it up to its root;
    /// `None` where no object on that way has one. `O(objects)`, however deep the hierarchy.
    ///
    /// # Errors
    /// When the hierarchy is broken ([`check_hierarchy`](Self::check_hierarchy)).
    pub fn world_transforms(&self) -> Result<Vec<Option<Matrix4<f64>>>> {
        self.check_hierarchy()?;
        Ok(self.transforms())
    }

    /// The same scene with its numbers in another unit and another axis up: itself where both already hold. Where one of the
    /// units is unknown, numbers keep their size.
    ///
    /// Every point becomes `s R p`; transforms become `M T M⁻¹` with `M = s R`, frames go along, normals turn. Objects
    /// that share a geometry share what it becomes. A shape whose plug-in is not here stays as it is written, and its
    /// transform takes it along: `M T`; what hangs under it is where it was. `O(points)`.
    ///
    /// # Errors
    /// When a coordinate overflows; the message names the object.
    pub fn converted(&self, unit: Unit, up: Up) -> Result<Cow<'_, Self>> {
        if unit == self.unit && up == self.up {
            return Ok(Cow::Borrowed(self));
        }
        let change = Change::between((self.unit, self.up), (unit, up));
        let Change { turn, scale } = change;
        let map = change.map();
        let mut back = Matrix4::identity();
        back.fixed_view_mut::<3, 3>(0, 0).copy_from(&(turn.transpose() / scale));
        let mut scene = self.around();
        (scene.unit, scene.up) = (unit, up);
        let mut known = HashMap::new();
        let mut converted = |object: &Object, under_unknown: bool| {
            let named = |e: Error| Error::Invalid(format!("\"{}\" in {}: {e}", object.name(), unit.name()));
            let is_unknown = object.geometry().is_unknown();
            let geometry = match known.entry(object.geometry_id()) {
                Entry::Occupied(known) => Arc::clone(known.get()),
                Entry::Vacant(_) if is_unknown => Arc::clone(object.shared_geometry()),
                Entry::Vacant(new) => {
                    let moved = object.geometry().transformed(&map).map_err(named)?;
                    Arc::clone(new.insert(Arc::new(moved)))
                }
            };
            let mut new = object.renamed(object.name());
            new.share_geometry(geometry);
            new.transform = object.transform.map(|own| change.of_transform(&own));
            if is_unknown {
                new.transform = Some(new.transform.unwrap_or_else(Matrix4::identity) * map);
            }
            if under_unknown {
                new.transform = Some(back * new.transform.unwrap_or_else(Matrix4::identity));
            }
            for frame in new.animation.iter_mut().filter(|_| !is_unknown).flat_map(|a| &mut a.frames) {
                frame.iter_mut().for_each(|p| *p = transform_point(&map, p));
            }
            Ok::<_, Error>(new)
        };
        let is_unknown = |object: &Object| object.geometry().is_unknown();
        for definition in self.definitions() {
            let mut new = Definition::new(definition.name());
            new.statements.clone_from(&definition.statements);
            for object in definition.objects() {
                let above = object.parent.as_deref().and_then(|parent| definition.get(parent));
                new.add(converted(object, above.is_some_and(is_unknown))?)?;
            }
            scene.define(new)?;
        }
        for object in self.objects() {
            let above = object.parent.as_deref().and_then(|parent| self.get(parent));
            scene.add(converted(object, above.is_some_and(is_unknown))?)?;
        }
        for connection in self.connections() {
            scene.connect(connection.clone())?;
        }
        Ok(Cow::Owned(scene))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Layer;

    const AXES: [Up; 3] = [Up::X, Up::Y, Up::Z];

    #[test]
    fn turns_bring_one_axis_to_the_other_and_agree_by_any_way() {
        let axis = |up| match up {
            Up::X => Vector::x(),
            Up::Y => Vector::y(),
            Up::Z => Vector::z(),
        };
        for from in AXES {
            for to in AXES {
                assert_eq!(from.turn(to) * axis(from), axis(to));
                assert_eq!(from.turn(to).determinant(), 1.0);
                for by in AXES {
                    assert_eq!(by.turn(to) * from.turn(by), from.turn(to));
                }
            }
        }
        assert_eq!(Up::Z.turn(Up::Y) * Vector::new(1.0, 2.0, 3.0), Vector::new(1.0, 3.0, -2.0));
    }

    /// Also the sign of a zero, so that what is written without a change is read without one.
    #[test]
    fn what_does_not_change_is_kept_to_the_bit() {
        let mut noted = Matrix4::new_rotation(Vector::new(0.3, -1.2, 0.4));
        (noted[(0, 3)], noted[(1, 0)], noted[(2, 3)]) = (-0.0, -0.0, 5.0);
        let bits = |m: &Matrix4<f64>| m.map(f64::to_bits);
        for up in AXES {
            let none = Change::between((Unit::Inch, up), (Unit::Inch, up));
            assert_eq!(bits(&none.of_transform(&noted)), bits(&noted));
        }
    }

    #[test]
    fn world_transforms_follow_the_hierarchy_and_refuse_a_cycle() {
        let mut scene = Scene::new();
        let shift = |x: f64| Some(Matrix4::new_translation(&Vector::new(x, 0.0, 0.0)));
        // A chain of 20,000, listed from the leaf up.
        for i in 0..20_000 {
            let mut object = Object::new(format!("{i}"), Geometry::Group);
            object.parent = (i < 19_999).then(|| format!("{}", i + 1));
            object.transform = if i % 2 == 0 { shift(1.0) } else { None };
            scene.add(object).unwrap();
        }
        let world = scene.world_transforms().unwrap();
        assert_eq!(world[0].unwrap()[(0, 3)], 10_000.0);
        assert_eq!(world[19_999], None);
        scene.object_mut("19999").unwrap().parent = Some("0".into());
        assert!(scene.world_transforms().is_err());
    }

    #[test]
    fn a_mirrored_mesh_keeps_its_outside() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
        let mut mesh = Mesh::new(points, &[[0, 1, 2]]).unwrap();
        mesh.normals = Layer::per_point(vec![Vector::z(); 3]);
        let mirror = Matrix4::new_nonuniform_scaling(&Vector::new(-1e-200, 1e-200, 1e-200));
        let Geometry::Mesh(moved) = Geometry::Mesh(mesh).transformed(&mirror).unwrap() else {
            unreachable!()
        };
        assert_eq!(moved.corners(), [0, 2, 1]);
        assert_eq!(moved.normals.values(), [Vector::z(); 3]);
    }

    #[test]
    fn a_scene_in_another_unit_has_the_same_world_points() {
        let mut scene = Scene::new();
        scene.unit = Unit::Millimetre;
        let mut object = Object::new("p", Cloud { points: vec![Point::new(1.0, 2.0, 3.0)] }.into());
        let axis = nalgebra::Vector3::z_axis();
        object.transform = Some(
            Matrix4::new_translation(&Vector::new(1000.0, 0.0, 0.0)) * Matrix4::from_axis_angle(&axis, 1.0),
        );
        scene.add(object).unwrap();
        let place = |s: &Scene| {
            transform_point(
                &s.world_transforms().unwrap()[0].unwrap(),
                &s.objects()[0].geometry().points()[0],
            )
        };
        let before = place(&scene);
        let turned = scene.converted(Unit::Metre, Up::Y).unwrap();
        let expected = Point::new(before.x, before.z, -before.y) / 1000.0;
        assert!((place(&turned) - expected).norm() < 1e-15);
        assert!(matches!(scene.converted(Unit::Millimetre, Up::Z).unwrap(), Cow::Borrowed(_)));
    }

    /// Directions of single precision, none of which has a length of exactly 1, come back as they were from another unit and other axes.
    #[test]
    fn directions_keep_their_numbers_where_axes_change() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
        let mut mesh = Mesh::new(points, &[[0, 1, 2]]).unwrap();
        let rounded = |t: f64| {
            let n = Vector::new(t.sin() * 0.3, t.cos() * 0.9, (1.7 * t).sin()).normalize();
            n.map(|x| f64::from(x as f32))
        };
        let all: Vec<Vector> = [0.1, 0.7, 2.3].map(rounded).to_vec();
        mesh.normals = Layer::per_point(all.clone());
        mesh.tangents = Layer::per_point(all.iter().map(|n| [n.y, n.z, n.x, 1.0]).collect());
        let own = Geometry::Mesh(mesh.clone());
        for from in [(Unit::Millimetre, Up::Z), (Unit::Inch, Up::Y), (Unit::Metre, Up::Z)] {
            let there = Change::between(from, (Unit::Metre, Up::Y));
            let back = Change::between((Unit::Metre, Up::Y), from);
            let moved = own.transformed(&there.map()).unwrap().transformed(&back.map()).unwrap();
            let Geometry::Mesh(moved) = moved else { unreachable!() };
            assert_eq!(moved.normals, mesh.normals, "{from:?}");
            assert_eq!(moved.tangents, mesh.tangents, "{from:?}");
        }
    }

    #[test]
    fn tangents_and_bitangents_follow_every_map() {
        let mut mesh = Mesh::new(
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Point::new(x, y, 0.0)).to_vec(),
            &[[0, 1, 2]],
        )
        .unwrap();
        mesh.normals = Layer::per_point(vec![Vector::z(); 3]);
        mesh.tangents = Layer::per_point(vec![[1.0, 0.0, 0.0, 1.0]; 3]);
        let mut mirror = Matrix4::identity();
        mirror[(0, 0)] = -2.0;
        let mut turn = Matrix4::identity();
        turn.fixed_view_mut::<3, 3>(0, 0).copy_from(&Up::Z.turn(Up::Y));
        for map in [Matrix4::identity(), turn, mirror, turn * mirror] {
            let Geometry::Mesh(moved) = Geometry::Mesh(mesh.clone()).transformed(&map).unwrap() else {
                unreachable!()
            };
            let (n, t) = (moved.normals.values()[0], moved.tangents.values()[0]);
            let along = Vector::new(t[0], t[1], t[2]);
            let linear = map.fixed_view::<3, 3>(0, 0);
            // Along u and v as the points went, both of length 1 here.
            assert!((along - (linear * Vector::x()).normalize()).norm() < 1e-15, "{t:?}");
            assert!((n.cross(&along) * t[3] - linear * Vector::y()).norm() < 1e-15, "{t:?} {n}");
        }
        let Geometry::Mesh(mut inside) = Geometry::Mesh(mesh.clone()) else { unreachable!() };
        inside.turn_inside_out();
        let (n, t) = (inside.normals.values()[0], inside.tangents.values()[0]);
        assert_eq!(n.cross(&Vector::x()) * t[3], Vector::y());
    }
}
