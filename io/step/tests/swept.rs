//! Faces on curves without ends that are extruded or turned: against the equations of what they sweep.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use crate::common::{AXES, file, read};
use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_step::Step;

fn brep(scene: &Scene) -> &Brep {
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!("no brep") };
    brep
}

/// How far the surface of a face is from where a function is 0, at worst, of its own size.
fn worst(brep: &Brep, face: usize, equation: impl Fn(Point) -> f64) -> f64 {
    let surface = brep.surface(face).unwrap();
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    let mut worst = 0.0_f64;
    for k in 0..=24 {
        for l in 0..=24 {
            let at = (a + (b - a) * f64::from(k) / 24.0, c + (d - c) * f64::from(l) / 24.0);
            worst = worst.max(equation(surface.point(at.0, at.1).unwrap()).abs());
        }
    }
    worst
}

/// Solids that OpenCASCADE made of a parabola and a hyperbola: the one curved face of each is on the cylinder over the conic, the solid closes.
#[test]
fn extruded_conics_without_ends_are_read() {
    let parabola = |p: Point| (p.y * p.y - 4.0 * p.x) / 40.0;
    let hyperbola = |p: Point| p.x * p.x / 4.0 - p.y * p.y - 1.0;
    let cases: [(&str, &dyn Fn(Point) -> f64); 2] = [("parab.step", &parabola), ("hyper.step", &hyperbola)];
    for (name, equation) in cases {
        let path = format!("{}/../../tests/data/made/{name}", env!("CARGO_MANIFEST_DIR"));
        let memory = Memory::new(name, std::fs::read(path).unwrap());
        let (scene, report) = Step.read(&memory, &ReadOptions::default()).unwrap();
        let brep = brep(&scene);
        assert_eq!((brep.face_count(), brep.solids().len()), (4, 1), "{name}: {report:?}");
        assert_eq!(brep.flaws(1e-6).unwrap(), [], "{name}");
        let curved: Vec<usize> = (0..4).filter(|&face| worst(brep, face, equation) < 1e-13).collect();
        assert_eq!(curved.len(), 1, "{name}");
        let surface = brep.surface(curved[0]).unwrap();
        assert_eq!([surface.u().degree(), surface.v().degree()], [2, 1]);
    }
}

/// The edge of a cap: a circle of a radius about the axis at a height, in a scene of that size.
fn cap(size: f64, radius: f64, height: f64, basis: &str) -> (Scene, String) {
    let n = |x: f64| format!("{:?}", x * size);
    let data = format!(
        "{AXES}#41=VERTEX_POINT('',#51);#51=CARTESIAN_POINT('',({r},0.,{h}));\
         #61=EDGE_CURVE('',#41,#41,#71,.T.);#71=CIRCLE('',#20,{r});#20=AXIS2_PLACEMENT_3D('',#21,#12,#13);\
         #21=CARTESIAN_POINT('',(0.,0.,{h}));#90=EDGE_LOOP('',(#91));#91=ORIENTED_EDGE('',*,*,#61,.F.);\
         #95=FACE_OUTER_BOUND('',#90,.T.);#96=AXIS1_PLACEMENT('',#11,#12);#97=AXIS2_PLACEMENT_3D('',#11,#98,#12);\
         #98=DIRECTION('',(0.,1.,0.));#100=OPEN_SHELL('',(#101));#101=ADVANCED_FACE('',(#95),#102,.T.);\
         #102=SURFACE_OF_REVOLUTION('',#103,#96);{basis}",
        r = n(radius),
        h = n(height)
    );
    let (scene, report) = read(&file("#100", &data)).unwrap();
    (scene, format!("{report:?}"))
}

/// A parabola about its own axis is a paraboloid, once: it ends at the apex, which no edge names; likewise a hyperbola, and a line that makes a cone.
#[test]
fn caps_of_turned_curves_go_on_to_the_axis() {
    for size in [1e-6, 1.0, 1e6] {
        let n = |x: f64| format!("{:?}", x * size);
        // Radius² = 4 · height, its focal length 1.
        let (scene, report) = cap(size, 2.0, 1.0, &format!("#103=PARABOLA('',#97,{});", n(1.0)));
        let brep = brep(&scene);
        let off = |p: Point| (p.x * p.x + p.y * p.y) / (size * size) - 4.0 * p.z / size;
        assert!(worst(brep, 0, off) < 1e-13, "{report}");
        let surface = brep.surface(0).unwrap();
        assert!(brep.flaws(1e-12 * size).unwrap().is_empty(), "{report}");
        for p in [Point::origin(), Point::new(1.2, 1.6, 1.0) * size] {
            assert!(surface.closest(p).unwrap().distance < 1e-12 * size, "{size} {p}");
        }
        // height² / 4 - radius² = 1, and a circle at the height of 2 cosh 1.
        let (scene, report) = cap(
            size,
            1.0_f64.sinh(),
            2.0 * 1.0_f64.cosh(),
            &format!("#103=HYPERBOLA('',#97,{},{});", n(2.0), n(1.0)),
        );
        let brep = self::brep(&scene);
        let off = |p: Point| (0.25 * p.z * p.z - p.x * p.x - p.y * p.y) / (size * size) - 1.0;
        assert!(worst(brep, 0, off) < 1e-13, "{report}");
        let apex = brep.surface(0).unwrap().closest(Point::new(0.0, 0.0, 2.0 * size)).unwrap();
        assert!(apex.distance < 1e-12 * size, "{size}");
        let line = "#103=LINE('',#51,#104);#104=VECTOR('',#105,1.);#105=DIRECTION('',(2.,0.,1.));";
        let (scene, report) = cap(size, 2.0, 1.0, line);
        let brep = self::brep(&scene);
        let off = |p: Point| (p.x.hypot(p.y) - 2.0 * p.z) / size;
        assert!(worst(brep, 0, off) < 1e-13, "{report}");
        let tip = brep.surface(0).unwrap().closest(Point::origin()).unwrap();
        assert!(tip.distance < 1e-12 * size, "{size}");
    }
}

/// Of a parabola that is turned the ends are points: OpenCASCADE takes its parameters for others than the schema has.
#[test]
fn turned_parabolas_end_at_points() {
    let (scene, _) = cap(1.0, 2.0, 1.0, "#103=PARABOLA('',#97,1.);");
    let mut memory = Memory::new("t.step", Vec::new());
    Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap();
    let text = String::from_utf8(memory.bytes).unwrap();
    let trimmed: Vec<&str> = text.lines().filter(|line| line.contains("TRIMMED_CURVE")).collect();
    assert!(trimmed.len() == 1 && trimmed[0].contains(".CARTESIAN."), "{trimmed:?}");
    let (again, report) = read(&text).unwrap();
    let off = |p: Point| p.x * p.x + p.y * p.y - 4.0 * p.z;
    assert!(worst(brep(&again), 0, off) < 1e-13, "{report:?}");
}

/// Rectangles of what has no ends say where it ends.
#[test]
fn rectangles_of_swept_curves_without_ends_are_where_their_parameters_say() {
    let sheet = |item: &str| {
        let text = file("#100", &format!("{AXES}#100=GEOMETRIC_SET('',(#101));\n{item}"));
        let (scene, report) = read(&text).unwrap();
        let Geometry::Surface(surface) = scene.objects()[0].geometry().clone() else { panic!("{report:?}") };
        surface
    };
    let near = |a: Point, b: Point| assert!((a - b).norm() < 1e-13 * 10.0, "{a} {b}");
    // The parabola (t², 2t) along (1, 0, 2).
    let extruded = sheet(
        "#101=RECTANGULAR_TRIMMED_SURFACE('',#102,-1.,2.,0.5,1.5,.T.,.T.);#102=SURFACE_OF_LINEAR_EXTRUSION('',#103,#104);\
         #103=PARABOLA('',#10,1.);#104=VECTOR('',#105,5.);#105=DIRECTION('',(3.,0.,4.));",
    );
    assert_eq!((extruded.u().domain(), extruded.v().domain()), ((-1.0, 2.0), (0.5, 1.5)));
    near(extruded.point(2.0, 0.5).unwrap(), Point::new(4.0 + 1.5, 4.0, 2.0));
    near(extruded.point(0.0, 1.0).unwrap(), Point::new(3.0, 0.0, 4.0));
    // A line at (3, 0, t) about the axis, a quarter of it; angles are in degrees.
    let turned = sheet(
        "#101=RECTANGULAR_TRIMMED_SURFACE('',#102,90.,180.,-1.,2.,.T.,.T.);#102=SURFACE_OF_REVOLUTION('',#103,#106);\
         #103=LINE('',#107,#104);#104=VECTOR('',#12,1.);#106=AXIS1_PLACEMENT('',#11,#12);#107=CARTESIAN_POINT('',(3.,0.,0.));",
    );
    let ((a, b), (c, d)) = (turned.u().domain(), turned.v().domain());
    near(turned.point(a, c).unwrap(), Point::new(0.0, 3.0, -1.0));
    near(turned.point(b, d).unwrap(), Point::new(-3.0, 0.0, 2.0));
}

/// What is no surface is told.
#[test]
fn curves_swept_within_themselves_are_told() {
    for basis in ["#103=PARABOLA('',#10,1.);", "#103=HYPERBOLA('',#10,2.,1.);"] {
        let data = format!(
            "{AXES}#100=OPEN_SHELL('',(#101));#101=ADVANCED_FACE('',(#95),#102,.T.);#95=FACE_OUTER_BOUND('',#90,.T.);\
             #90=VERTEX_LOOP('',#41);#41=VERTEX_POINT('',#11);#102=SURFACE_OF_LINEAR_EXTRUSION('',#103,#104);\
             #104=VECTOR('',#13,1.);{basis}"
        );
        let text = file("#100", &data);
        let said = match read(&text) {
            Ok((_, report)) => format!("{report:?}"),
            Err(error) => error.to_string(),
        };
        assert!(said.contains("extruded within its own plane"), "{said}");
    }
}

fn made(name: &str) -> Scene {
    let path = format!("{}/../../tests/data/made/{name}", env!("CARGO_MANIFEST_DIR"));
    Step.read(&Memory::new(name, std::fs::read(path).unwrap()), &ReadOptions::default()).unwrap().0
}

fn written(scene: &Scene) -> String {
    let mut out = Memory::new("out.step", Vec::new());
    Step.write(scene, &mut out, &WriteOptions::default()).unwrap();
    String::from_utf8(out.bytes).unwrap()
}

/// Files of OpenCASCADE: what is extruded, turned and a conic comes out as that, on the same points, and from then on the same.
#[test]
fn swept_surfaces_and_conics_go_out_as_what_they_are() {
    for (name, kinds) in [
        ("parab.step", &[("SURFACE_OF_LINEAR_EXTRUSION(", 1), ("PARABOLA(", 3)][..]),
        ("hyper.step", &[("SURFACE_OF_LINEAR_EXTRUSION(", 1), ("HYPERBOLA(", 3)]),
        ("elprism.step", &[("SURFACE_OF_LINEAR_EXTRUSION(", 1), ("ELLIPSE(", 3)]),
        ("elslant.step", &[("SURFACE_OF_LINEAR_EXTRUSION(", 1), ("ELLIPSE(", 3)]),
        ("splext.step", &[("SURFACE_OF_LINEAR_EXTRUSION(", 1), ("B_SPLINE_CURVE_WITH_KNOTS(", 3)]),
        ("splrev.step", &[("SURFACE_OF_REVOLUTION(", 1)]),
        ("splrevpart.step", &[("SURFACE_OF_REVOLUTION(", 1)]),
        ("elrev.step", &[("SURFACE_OF_REVOLUTION(", 1)]),
    ] {
        let first = made(name);
        let text = written(&first);
        for (kind, count) in kinds {
            assert_eq!(text.matches(kind).count(), *count, "{name}: {kind}");
        }
        assert!(!text.contains("B_SPLINE_SURFACE"), "{name}");
        let (second, report) = read(&text).unwrap();
        let (before, after) = (brep(&first), brep(&second));
        assert_eq!(
            (before.solids(), before.edge_count()),
            (after.solids(), after.edge_count()),
            "{name}: {report:?}"
        );
        let size = before.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        assert!(after.flaws(1e-6 * size).unwrap().is_empty(), "{name}: {report:?}");
        for face in 0..before.face_count() {
            assert_eq!(before.surface_form(face).name(), after.surface_form(face).name(), "{name}");
            assert_eq!(before.is_reversed(face), after.is_reversed(face), "{name}");
            let (old, new) = (before.surface(face).unwrap(), after.surface(face).unwrap());
            let ((a, b), (c, d)) = (old.u().domain(), old.v().domain());
            for (s, t) in [(0.0, 0.0), (0.3, 0.4), (0.7, 0.2), (1.0, 0.9)] {
                let p = old.point(a + s * (b - a), c + t * (d - c)).unwrap();
                let off = new.closest(p).unwrap().distance;
                assert!(off < 1e-12 * size, "{name}: face {face} {off}");
            }
        }
        let again = written(&second);
        let digits = |text: &str| text.matches("CARTESIAN_POINT").count();
        assert_eq!(digits(&again), digits(&text), "{name}");
        let (third, _) = read(&again).unwrap();
        let apart = brep(&third).points().iter().zip(after.points()).map(|(p, q)| (p - q).amax());
        assert!(apart.fold(0.0, f64::max) < 1e-13 * size, "{name}");
    }
}

/// Moved, turned and scaled they stay what they are; stretched, and with a control vertex moved, they are splines.
#[test]
fn what_is_swept_stays_so_as_long_as_it_is_not_edited() {
    for name in ["parab.step", "elslant.step", "splrev.step"] {
        let scene = made(name);
        let of = |kind: &str, brep: &Brep| {
            (0..brep.face_count()).filter(|&face| brep.surface_form(face).name() == kind).count()
        };
        let kind = if name == "splrev.step" { "revolution" } else { "extrusion" };
        assert_eq!(of(kind, brep(&scene)), 1);
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 1.1).to_homogeneous();
        let mirror = nalgebra::Matrix4::new_nonuniform_scaling(&nalgebra::Vector3::new(-2.0, 2.0, 2.0));
        for map in [turn, mirror, turn * mirror] {
            let geometry = scene.objects()[0].geometry().transformed(&map).unwrap();
            let mut moved = Scene::new();
            moved.add(loftsman_kernel::scene::Object::new("moved", geometry)).unwrap();
            assert_eq!(of(kind, brep(&moved)), 1, "{name}");
            let (back, report) = read(&written(&moved)).unwrap();
            assert_eq!(of(kind, brep(&back)), 1, "{name}: {report:?}");
            let size = brep(&moved).points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
            assert!(brep(&back).flaws(1e-6 * size).unwrap().is_empty(), "{name}: {report:?}");
            assert_eq!(brep(&back).solids().len(), 1, "{name}");
        }
        let stretch = nalgebra::Matrix4::new_nonuniform_scaling(&nalgebra::Vector3::new(1.0, 2.0, 3.0));
        let mut stretched = Scene::new();
        let geometry = scene.objects()[0].geometry().transformed(&stretch).unwrap();
        stretched.add(loftsman_kernel::scene::Object::new("stretched", geometry)).unwrap();
        assert_eq!(of(kind, brep(&stretched)), 0, "{name}");
        assert!(written(&stretched).contains("B_SPLINE_SURFACE"), "{name}");
        let mut points = brep(&scene).points().to_vec();
        points.iter_mut().for_each(|p| p.x += 0.01 * p.y);
        assert_eq!(of(kind, &brep(&scene).with_points(points).unwrap()), 0, "{name}");
    }
}
