//! Where surfaces of a scene meet: pairs of curves in their parameter planes.

use crate::error::{Error, Result};
use crate::scene::{Geometry, Scene};
use crate::spline::trimmed::ParameterCurve;
use crate::text::a;

/// One side of a connection: a curve on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// The object that is the surface.
    pub object: String,
    /// The curve in its parameter plane.
    pub curve: ParameterCurve,
}

/// Two surfaces meet along a curve, which each knows in its own parameters (`con` of an OBJ file). What a file says is
/// kept; that the two curves are the same in space is not checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// One surface.
    pub first: Side,
    /// The other one, or the same.
    pub second: Side,
}

impl Connection {
    /// Both sides.
    pub fn sides(&self) -> [&Side; 2] {
        [&self.first, &self.second]
    }

    /// Whether both sides are surfaces of a scene.
    ///
    /// # Errors
    /// With the name of the one that is not.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        for side in self.sides() {
            let name = &side.object;
            match scene.get(name).map(|o| o.geometry()) {
                Some(Geometry::Surface(_) | Geometry::Trimmed(_)) => {}
                Some(other) => {
                    let kind = other.kind();
                    return Err(Error::Invalid(format!(
                        "a connection names \"{name}\", which is {}",
                        a(kind)
                    )));
                }
                None => {
                    return Err(Error::Invalid(format!(
                        "a connection names \"{name}\", which does not exist"
                    )));
                }
            }
        }
        Ok(())
    }

    pub(crate) fn rename(&mut self, old: &str, new: &str) {
        for side in [&mut self.first, &mut self.second] {
            if side.object == old {
                new.clone_into(&mut side.object);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::mesh::Cloud;
    use crate::scene::Object;
    use crate::spline::{Curve, Space, Surface};

    #[test]
    fn connections_follow_their_surfaces() {
        let space = || Space::clamped(1, &[0.0, 1.0]).unwrap();
        let flat = Surface::new(space(), space(), vec![Point::origin(); 4]).unwrap();
        let mut scene = Scene::new();
        for name in ["a", "b"] {
            scene.add(Object::new(name, (&flat).into())).unwrap();
        }
        scene.add(Object::new("c", Cloud::default().into())).unwrap();
        let line = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
        let side =
            |name: &str| Side { object: name.into(), curve: ParameterCurve::whole(line.clone()).unwrap() };
        let join = |a: &str, b: &str| Connection { first: side(a), second: side(b) };
        assert!(scene.connect(join("a", "c")).unwrap_err().to_string().contains("cloud"));
        assert!(scene.connect(join("a", "d")).unwrap_err().to_string().contains("not exist"));
        scene.connect(join("a", "b")).unwrap();
        scene.rename("b", "d").unwrap();
        assert_eq!(scene.connections(), [join("a", "d")]);
        scene.check().unwrap();
        scene.replace("d", Cloud::default()).unwrap();
        assert!(scene.connections().is_empty());
        scene.replace("d", flat).unwrap();
        scene.connect(join("d", "a")).unwrap();
        scene.remove("a").unwrap();
        assert!(scene.connections().is_empty());
    }
}
