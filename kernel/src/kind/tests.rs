//! Kinds of shape in scenes, and their triangles.

use std::sync::Arc;

use super::*;
use crate::Point;
use crate::conformance::kind_conformance;
use crate::declare::Field;
use crate::plugin::Registry;
use crate::scene::{Geometry, Object, Scene, Unit, Up};
use crate::shape::{Derivative, Domain, Interval, Location, Stencil};
use crate::spline::Space;
use crate::tessellator::Chord;

/// A spline that hides what it is.
#[derive(Debug, Clone)]
struct Hidden<T>(T);

impl<T: Shape + Clone> Shape for Hidden<T> {
    fn control_vertices(&self) -> &[Point] {
        self.0.control_vertices()
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        self.0.control_vertices_mut()
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        self.0.stencil(at, derivative)
    }

    fn domain(&self) -> Domain {
        self.0.domain()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}

const FIELDS: &[Field] = &[Field::required("points", "[[x, y, z], …]", "the control vertices")];

fn some<T>(
    fields: &Parameters,
    count: usize,
    made: impl FnOnce(Vec<Point>) -> Result<T>,
) -> std::result::Result<T, ParameterError> {
    let points = fields.points("points")?;
    if points.len() != count {
        return Err(fields.error("points", format!("{} points where {count} are needed", points.len())));
    }
    made(points).map_err(|e| fields.error("points", e.to_string()))
}

impl DeclaredShape for Hidden<Curve> {
    const DECLARATION: Declaration =
        Declaration { name: "hidden-ring", help: "a closed curve", fields: FIELDS };

    fn fields(&self) -> Parameters {
        Parameters::empty("").with_points("points", self.control_vertices())
    }

    fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        some(fields, 6, |points| Ok(Self(Curve::new(Space::periodic_uniform(3, 6)?, points)?)))
    }

    fn splines(&self) -> Option<Splines> {
        Some(Splines::Curves(vec![self.0.clone()]))
    }
}

impl DeclaredShape for Hidden<Surface> {
    const DECLARATION: Declaration = Declaration { name: "hidden-patch", help: "a patch", fields: FIELDS };

    fn fields(&self) -> Parameters {
        Parameters::empty("").with_points("points", self.control_vertices())
    }

    fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        some(fields, 20, |points| {
            Ok(Self(Surface::new(Space::clamped_uniform(2, 4)?, Space::periodic_uniform(3, 5)?, points)?))
        })
    }
}

fn ring() -> Hidden<Curve> {
    let at = |k: usize| {
        let angle = k as f64 * std::f64::consts::FRAC_PI_3;
        Point::new(angle.cos() * 3.0, angle.sin(), 0.1 * k as f64)
    };
    Hidden(Curve::new(Space::periodic_uniform(3, 6).unwrap(), (0..6).map(at).collect()).unwrap())
}

/// A tube that narrows to a point at one end.
fn patch() -> Hidden<Surface> {
    let at = |k: usize| {
        let (row, angle) = ((k / 5) as f64, (k % 5) as f64 * 0.4 * std::f64::consts::PI);
        let radius = (3.0 - row) / 1.5;
        Point::new(radius * angle.cos(), radius * angle.sin(), row)
    };
    let (u, v) = (Space::clamped_uniform(2, 4).unwrap(), Space::periodic_uniform(3, 5).unwrap());
    Hidden(Surface::new(u, v, (0..20).map(at).collect()).unwrap())
}

fn kinds() -> Registry {
    let mut registry = Registry::new();
    registry.shape::<Hidden<Curve>>();
    registry.shape::<Hidden<Surface>>();
    registry
}

#[test]
fn the_samples_are_kinds() {
    let registry = kinds();
    let verdict = kind_conformance(registry.find_shape("hidden-ring", "").unwrap(), &[ring().boxed()]);
    assert!(verdict.passed() && verdict.checks > 50, "{verdict}");
    let verdict = kind_conformance(registry.find_shape("hidden-patch", "").unwrap(), &[patch().boxed()]);
    assert!(verdict.passed() && verdict.checks > 50, "{verdict}");
    let error = registry.find_shape("hiden-patch", "op").unwrap_err().to_string();
    assert!(error.contains("did you mean \"hidden-patch\""), "{error}");
    assert!(Registry::new().find_shape("x", "op").unwrap_err().to_string().contains("none is registered"));
}

#[test]
fn a_suite_finds_what_is_wrong() {
    /// Does not write its vertices.
    #[derive(Debug)]
    struct Forgetful;
    impl ShapeKind for Forgetful {
        fn declaration(&self) -> Declaration {
            Declaration { name: "Forgetful", help: "", fields: &[] }
        }
        fn write(&self, _: &dyn Shape) -> Result<Parameters> {
            Ok(Parameters::empty(""))
        }
        fn read(&self, _: &Parameters) -> std::result::Result<Box<dyn Shape>, ParameterError> {
            let mut patch = patch();
            patch.control_vertices_mut()[0].x += 1.0;
            Ok(patch.boxed())
        }
    }
    let kind: Arc<dyn ShapeKind> = Arc::new(Forgetful);
    let verdict = kind_conformance(&kind, &[patch().boxed()]).to_string();
    for words in ["no help", "other control vertices", "takes a field that it does not declare"] {
        assert!(verdict.contains(words), "{words}: {verdict}");
    }
}

#[test]
fn triangles_are_near_and_close_where_the_shape_does() {
    let shape = patch();
    for (chord, angle) in [(1e-1, 0.5), (1e-3, 10.0), (1e-5, 10.0)] {
        let fineness = Fineness { chord: Chord::Absolute(chord), angle };
        let Faceted { drawn: Drawn::Mesh(mesh), error, certified, .. } =
            sampled(&[&shape], &fineness).unwrap()
        else {
            panic!("no mesh")
        };
        assert!(error <= chord && error > 0.0 && !certified);
        mesh.check().unwrap();
        // Closed around, open at both ends: every edge but those of the rims has two faces.
        let mut edges = std::collections::BTreeMap::new();
        for face in mesh.faces() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
        let rim = edges.values().filter(|&&count| count == 1).count();
        let columns = mesh.points().iter().filter(|p| (p.z - 0.0).abs() < 1e-12).count();
        assert!(edges.values().all(|&count| count <= 2));
        // At the tip all points of a rim are one.
        assert_eq!(rim, columns);
    }
}

#[test]
fn corners_gaps_and_points_are_no_endless_work() {
    let fineness = Fineness { chord: Chord::Relative(1e-4), angle: 0.1 };
    let corner = Curve::new(
        Space::clamped_uniform(1, 3).unwrap(),
        vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0)],
    );
    let faceted = sampled(&[&Hidden(corner.unwrap())], &fineness).unwrap();
    assert!(faceted.drawn.points().len() < 200);
    let space = Space::open(1, vec![0.0, 0.0, 0.3, 0.3, 1.0, 1.0]).unwrap();
    let torn = [[0.0, 0.0], [1.0, 0.0], [1.0, 5.0], [2.0, 5.0]].map(|[x, y]| Point::new(x, y, 0.0));
    let error = sampled(&[&Hidden(Curve::new(space, torn.to_vec()).unwrap())], &fineness).unwrap_err();
    assert!(
        error.to_string().contains("gap near u = 0.3") || error.to_string().contains("gap near u = 0.29"),
        "{error}"
    );
    let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap();
    assert!(matches!(sampled(&[&point], &fineness), Err(Error::NoExtent(_))));
    let fine = Fineness { chord: Chord::Absolute(1e-15), angle: 0.1 };
    assert!(sampled(&[&patch()], &fine).unwrap_err().to_string().contains("larger tolerance"));
    for chord in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(sampled(&[&ring()], &Fineness { chord: Chord::Absolute(chord), angle: 0.1 }).is_err());
    }
    assert!(sampled(&[], &fineness).is_err());
    assert!(sampled(&[&ring() as &dyn Shape, &patch()], &fineness).is_err());
}

#[test]
fn custom_shapes_are_geometry() {
    let geometry: Geometry = ring().into();
    assert_eq!((geometry.kind(), geometry.points().len()), ("hidden-ring", 6));
    assert_eq!(geometry, Geometry::from(ring()));
    let moved = geometry
        .transformed(&nalgebra::Matrix4::new_translation(&crate::Vector::new(1.0, 2.0, 3.0)))
        .unwrap();
    assert!(moved != geometry && moved.kind() == "hidden-ring");
    let value = |g: &Geometry| g.shape().unwrap().value(Location::Curve(1.3), Derivative::POSITION).unwrap();
    assert!((value(&moved) - value(&geometry) - crate::Vector::new(1.0, 2.0, 3.0)).norm() < 1e-12);
    let Geometry::Custom(custom) = &geometry else { panic!("custom") };
    assert!(custom.with_points(&[Point::origin()]).is_err());
    assert!(custom.with_points(&[Point::new(f64::NAN, 0.0, 0.0); 6]).is_err());
    assert!(custom.with_shape(patch().boxed()).unwrap_err().to_string().contains("\"hidden-ring\""));
    assert_ne!(Geometry::from(CustomShape::unknown("hidden-ring", "{}")), geometry);
}

#[test]
fn a_shape_that_does_not_hang_together_is_refused() {
    #[derive(Debug, Clone)]
    struct Broken;
    impl Shape for Broken {
        fn control_vertices(&self) -> &[Point] {
            &[]
        }
        fn control_vertices_mut(&mut self) -> &mut [Point] {
            &mut []
        }
        fn stencil(&self, _: Location, _: Derivative) -> Result<Stencil> {
            Ok(Stencil::new())
        }
        fn domain(&self) -> Domain {
            [Interval { start: 1.0, end: 0.0, periodic: false }].into_iter().collect()
        }
        fn boxed(&self) -> Box<dyn Shape> {
            Box::new(self.clone())
        }
    }
    let registry = kinds();
    let kind = registry.find_shape("hidden-ring", "").unwrap();
    assert!(CustomShape::new(Arc::clone(kind), Box::new(Broken)).is_err());
}

/// What is unknown stays where it is in space when the scene changes its unit and axes, and so does what hangs under
/// it.
#[test]
fn what_is_unknown_goes_along_by_its_transform() {
    let mut scene = Scene::new();
    (scene.unit, scene.up) = (Unit::Millimetre, Up::Z);
    let place = |x: f64| Some(nalgebra::Matrix4::new_translation(&crate::Vector::new(x, 1.0, 2.0)));
    let mut top = Object::new("top", CustomShape::unknown("coons", "{ \"kind\": \"coons\" }").into());
    top.transform = place(5.0);
    scene.add(top).unwrap();
    let mut below = Object::new("below", Curve::bezier(ring().0.points()[..4].to_vec()).unwrap().into());
    (below.parent, below.transform) = (Some("top".into()), place(-3.0));
    scene.add(below).unwrap();
    let mut bare = Object::new("bare", CustomShape::unknown("coons", "{ \"kind\": \"coons\" }").into());
    bare.parent = Some("top".into());
    scene.add(bare).unwrap();
    let other = scene.converted(Unit::Metre, Up::Y).unwrap().into_owned();
    assert_eq!(other.object("top").unwrap().geometry(), scene.object("top").unwrap().geometry());
    let (before, after) = (scene.world_transforms().unwrap(), other.world_transforms().unwrap());
    let turned = |p: Point| Point::new(p.x, p.z, -p.y) / 1e3;
    let apply =
        |map: &Option<nalgebra::Matrix4<f64>>, p: &Point| crate::placement::transform_point(&map.unwrap(), p);
    let own = Point::new(0.3, -0.7, 0.2);
    for k in [0, 2] {
        assert!((apply(&after[k], &own) - turned(apply(&before[k], &own))).norm() < 1e-15);
    }
    let [old, new] = [&scene, &other].map(|s| s.object("below").unwrap().geometry().points()[1]);
    assert!((apply(&after[1], &new) - turned(apply(&before[1], &old))).norm() < 1e-15);
}
