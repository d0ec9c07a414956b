//! What the schema says of curves and surfaces, by its formulas.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use crate::common::{AXES, file, read};
use loftsman_kernel::Point;
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::{Curve, Surface};

fn scene(item: &str) -> Scene {
    let text = file("#100", &format!("{AXES}#100=GEOMETRIC_SET('',(#101));\n{item}"));
    let (scene, report) = read(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert!(report.adds_up());
    scene
}

fn curve(item: &str) -> Curve {
    let Geometry::Curve(curve) = scene(item).objects()[0].geometry().clone() else { panic!("{item}") };
    curve
}

fn surface(item: &str) -> Surface {
    let Geometry::Surface(surface) = scene(item).objects()[0].geometry().clone() else { panic!("{item}") };
    surface
}

/// Points all along a curve.
fn along(curve: &Curve) -> Vec<Point> {
    let (a, b) = curve.domain();
    (0..=32).map(|k| curve.point(a + (b - a) * f64::from(k) / 32.0).unwrap()).collect()
}

#[test]
fn conics_are_exact() {
    let trimmed = |basis: &str, from: f64, to: f64, sense: &str| {
        curve(&format!(
            "#101=TRIMMED_CURVE('',#102,(PARAMETER_VALUE({from:?})),(PARAMETER_VALUE({to:?})),.{sense}.,.PARAMETER.);\n#102={basis};"
        ))
    };
    let near = |a: Point, b: Point| assert!((a - b).norm() < 1e-13 * 40.0, "{a} {b}");
    // Angles are in degrees.
    let circle = trimmed("CIRCLE('',#10,2.)", 30.0, 210.0, "T");
    assert!(along(&circle).iter().all(|p| (p.coords.norm() - 2.0).abs() < 1e-14));
    near(along(&circle)[0], Point::new(2.0 * 0.75_f64.sqrt(), 1.0, 0.0));
    near(along(&circle)[32], Point::new(-2.0 * 0.75_f64.sqrt(), -1.0, 0.0));
    // A full turn with as many digits as other programs write is one, and no arc of rounding; a tiny arc is tiny.
    for (from, to) in
        [(0.0, 360.0), (0.0, 360.000_000_000_02), (57.0, 417.000_000_000_02), (0.0, 359.999_999_999_9)]
    {
        let round = trimmed("CIRCLE('',#10,2.)", from, to, "T").length(1e-10).unwrap().value;
        assert!((round - 4.0 * std::f64::consts::PI).abs() < 1e-10, "{from} {to}: {round}");
    }
    let speck = trimmed("CIRCLE('',#10,2.)", 0.0, 1e-8, "T");
    assert!((along(&speck)[32] - along(&speck)[0]).norm() < 1e-9);
    // The other way round it goes over the rest of the circle.
    let back = trimmed("CIRCLE('',#10,2.)", 30.0, 210.0, "F");
    assert!(along(&back)[16].y < -1.0 || along(&back)[16].x > 0.0);
    near(along(&back)[0], along(&circle)[0]);
    let ellipse = trimmed("ELLIPSE('',#10,3.,1.)", 0.0, 90.0, "T");
    assert!(along(&ellipse).iter().all(|p| ((p.x / 3.0).powi(2) + p.y.powi(2) - 1.0).abs() < 1e-14));
    let parabola = trimmed("PARABOLA('',#10,0.5)", -1.0, 3.0, "T");
    assert!(along(&parabola).iter().all(|p| (p.y * p.y - 2.0 * p.x).abs() < 1e-13));
    near(along(&parabola)[32], Point::new(4.5, 3.0, 0.0));
    let hyperbola = trimmed("HYPERBOLA('',#10,2.,1.)", -1.5, 2.0, "T");
    for p in along(&hyperbola) {
        assert!(((p.x / 2.0).powi(2) - p.y.powi(2) - 1.0).abs() < 1e-13, "{p}");
    }
    near(along(&hyperbola)[32], Point::new(2.0 * 2.0_f64.cosh(), 2.0_f64.sinh(), 0.0));
}

#[test]
fn splines_of_every_form_are_what_they_say() {
    let points = "#110=CARTESIAN_POINT('',(0.,0.,0.));#111=CARTESIAN_POINT('',(1.,2.,0.));\
                  #112=CARTESIAN_POINT('',(2.,0.,1.));#113=CARTESIAN_POINT('',(3.,1.,0.));";
    let list = "(#110,#111,#112,#113)";
    let complex = |own: &str| {
        curve(&format!(
            "#101=(BOUNDED_CURVE()B_SPLINE_CURVE(3,{list},.UNSPECIFIED.,.F.,.F.){own}CURVE()\
             GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM(''));{points}"
        ))
    };
    let knots = "B_SPLINE_CURVE_WITH_KNOTS((4,4),(0.,2.),.UNSPECIFIED.)";
    let listed = complex(knots);
    assert_eq!(listed.domain(), (0.0, 2.0));
    let rational = complex(&format!("{knots}RATIONAL_B_SPLINE_CURVE((1.,0.5,2.,1.))"));
    assert_eq!(rational.weights(), Some(&[1.0, 0.5, 2.0, 1.0][..]));
    assert!(complex("BEZIER_CURVE()").space().is_clamped());
    assert!(complex("QUASI_UNIFORM_CURVE()").space().is_clamped());
    assert!(!complex("UNIFORM_CURVE()").space().is_clamped());
    let simple = curve(&format!(
        "#101=B_SPLINE_CURVE_WITH_KNOTS('',2,{list},.UNSPECIFIED.,.F.,.F.,(3,1,3),(0.,0.25,1.),.UNSPECIFIED.);{points}"
    ));
    assert_eq!((simple.degree(), simple.points().len()), (2, 4));
    let quasi = curve(&format!("#101=QUASI_UNIFORM_CURVE('',2,{list},.UNSPECIFIED.,.F.,.F.);{points}"));
    assert_eq!(quasi.space().breakpoints(), [0.0, 1.0, 2.0]);
    let patch = surface(&format!(
        "#101=BEZIER_SURFACE('',1,1,((#110,#111),(#112,#113)),.UNSPECIFIED.,.F.,.F.,.F.);{points}"
    ));
    assert_eq!(patch.points().len(), 4);
}

#[test]
fn composites_are_joined() {
    let all = curve(
        "#101=COMPOSITE_CURVE('',(#120,#121),.F.);\n\
         #120=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.T.,#122);#121=COMPOSITE_CURVE_SEGMENT(.CONTINUOUS.,.F.,#123);\n\
         #122=TRIMMED_CURVE('',#130,(PARAMETER_VALUE(0.)),(PARAMETER_VALUE(90.)),.T.,.PARAMETER.);\n\
         #123=POLYLINE('',(#131,#132));#130=CIRCLE('',#10,1.);\n\
         #131=CARTESIAN_POINT('',(-2.,1.,0.));#132=CARTESIAN_POINT('',(0.,1.,0.));",
    );
    let ends = along(&all);
    assert!((ends[0] - Point::new(1.0, 0.0, 0.0)).norm() < 1e-15);
    assert!((ends[32] - Point::new(-2.0, 1.0, 0.0)).norm() < 1e-15);
}

#[test]
fn rectangles_of_elementary_surfaces_are_where_their_parameters_say() {
    for (basis, [u, v], at) in [
        ("CYLINDRICAL_SURFACE('',#10,2.)", ["0.,90.", "1.,3."], Point::new(0.0, 2.0, 3.0)),
        ("CONICAL_SURFACE('',#10,2.,45.)", ["0.,90.", "0.,1."], Point::new(0.0, 3.0, 1.0)),
        ("SPHERICAL_SURFACE('',#10,2.)", ["0.,90.", "-90.,0."], Point::new(0.0, 2.0, 0.0)),
        ("TOROIDAL_SURFACE('',#10,3.,1.)", ["-90.,90.", "0.,90."], Point::new(0.0, 3.0, 1.0)),
        ("PLANE('',#10)", ["0.,2.", "-1.,4."], Point::new(2.0, 4.0, 0.0)),
        ("OFFSET_SURFACE('',#103,0.5,.F.)", ["0.,90.", "1.,3."], Point::new(0.0, 2.5, 3.0)),
    ] {
        let part = surface(&format!(
            "#101=RECTANGULAR_TRIMMED_SURFACE('',#102,{u},{v},.T.,.T.);#102={basis};#103=CYLINDRICAL_SURFACE('',#10,2.);"
        ));
        let found = part.point(part.u().domain().1, part.v().domain().1).unwrap();
        assert!((found - at).norm() < 1e-14, "{basis}: {found} {at}");
    }
}

/// A face of a surface, bounded by the curves of a quarter of it, `u` and `v` from the corner at (2, 0, 0).
#[test]
fn swept_surfaces_hold_the_edges_of_their_faces() {
    let points = "#41=VERTEX_POINT('',#51);#51=CARTESIAN_POINT('',(2.,0.,0.));\
                  #42=VERTEX_POINT('',#52);#52=CARTESIAN_POINT('',(0.,2.,0.));\
                  #43=VERTEX_POINT('',#53);#53=CARTESIAN_POINT('',(0.,2.,3.));\
                  #44=VERTEX_POINT('',#54);#54=CARTESIAN_POINT('',(2.,0.,3.));\
                  #61=EDGE_CURVE('',#41,#42,#71,.T.);#71=CIRCLE('',#10,2.);\
                  #62=EDGE_CURVE('',#42,#43,#72,.T.);#72=LINE('',#52,#82);#82=VECTOR('',#12,1.);\
                  #63=EDGE_CURVE('',#44,#43,#73,.T.);#73=CIRCLE('',#20,2.);#20=AXIS2_PLACEMENT_3D('',#21,#12,#13);\
                  #21=CARTESIAN_POINT('',(0.,0.,3.));\
                  #64=EDGE_CURVE('',#44,#41,#74,.F.);#74=LINE('',#51,#82);\
                  #90=EDGE_LOOP('',(#91,#92,#93,#94));#91=ORIENTED_EDGE('',*,*,#61,.T.);#92=ORIENTED_EDGE('',*,*,#62,.T.);\
                  #93=ORIENTED_EDGE('',*,*,#63,.F.);#94=ORIENTED_EDGE('',*,*,#64,.T.);\
                  #95=FACE_OUTER_BOUND('',#90,.T.);#96=AXIS1_PLACEMENT('',#11,#12);#97=VECTOR('',#12,2.);";
    for basis in [
        "CYLINDRICAL_SURFACE('',#10,2.)",
        "SURFACE_OF_REVOLUTION('',#74,#96)",
        "SURFACE_OF_LINEAR_EXTRUSION('',#71,#97)",
        "SURFACE_OF_LINEAR_EXTRUSION('',#75,#97)",
        "OFFSET_SURFACE('',#76,1.,.F.)",
        "RECTANGULAR_TRIMMED_SURFACE('',#77,0.,180.,-1.,5.,.T.,.T.)",
    ] {
        let data = format!(
            "{AXES}{points}#100=OPEN_SHELL('',(#101));#101=ADVANCED_FACE('',(#95),#102,.T.);#102={basis};\
             #75=TRIMMED_CURVE('',#71,(#51),(#52),.T.,.CARTESIAN.);#76=CYLINDRICAL_SURFACE('',#10,1.);\
             #77=CYLINDRICAL_SURFACE('',#10,2.);"
        );
        let (scene, report) = read(&file("#100", &data)).unwrap();
        let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!("{basis}") };
        let flaws = brep.flaws(1e-12).unwrap();
        assert!(flaws.is_empty(), "{basis}: {} {report:?}", flaws[0]);
        // Its normal points outwards, from the axis.
        let surface = brep.surface(0).unwrap();
        let at = surface.closest(Point::new(2.0_f64.sqrt(), 2.0_f64.sqrt(), 1.0)).unwrap();
        assert!(at.distance < 1e-12, "{basis}");
        let [du, dv] = [(1, 0), (0, 1)].map(|(a, b)| surface.derivative(at.at.0, at.at.1, a, b).unwrap());
        let normal = du.cross(&dv) * if brep.is_reversed(0) { -1.0 } else { 1.0 };
        assert!(normal.x > 0.0 && normal.y > 0.0, "{basis}: {normal}");
    }
}

#[test]
fn polygons_and_triangles_are_read() {
    let points = "#51=CARTESIAN_POINT('',(0.,0.,0.));#52=CARTESIAN_POINT('',(1.,0.,0.));\
                  #53=CARTESIAN_POINT('',(0.,1.,0.));#54=CARTESIAN_POINT('',(0.,0.,1.));";
    let face = |k: usize, a: usize, b: usize, c: usize| {
        format!(
            "#{}=FACE('',(#{}));#{}=FACE_BOUND('',#{},.T.);#{}=POLY_LOOP('',(#{a},#{b},#{c}));",
            200 + k,
            210 + k,
            210 + k,
            220 + k,
            220 + k
        )
    };
    let faces = [face(0, 51, 53, 52), face(1, 51, 52, 54), face(2, 52, 53, 54), face(3, 53, 51, 54)].concat();
    let text = file(
        "#100",
        &format!("#100=FACETED_BREP('tet',#101);#101=CLOSED_SHELL('',(#200,#201,#202,#203));{points}{faces}"),
    );
    let (scene, _) = read(&text).unwrap();
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!() };
    assert_eq!((brep.solids().len(), brep.edge_count(), brep.vertices().len()), (1, 6, 4));
    let text = file(
        "#100",
        "#100=TRIANGULATED_FACE('m',#101,4,(),$,(),((1,2,3),(1,3,4)));\
         #101=COORDINATES_LIST('',4,((0.,0.,0.),(1.,0.,0.),(1.,1.,0.),(0.,1.,0.)));",
    );
    let (scene, _) = read(&text).unwrap();
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { panic!() };
    assert_eq!((mesh.points().len(), mesh.face_count()), (4, 2));
    let text = file(
        "#100",
        "#100=COMPLEX_TRIANGULATED_FACE('m',#101,4,(),$,(4,3,2,1),((1,2,4,3)),());\
         #101=COORDINATES_LIST('',4,((0.,0.,0.),(1.,0.,0.),(1.,1.,0.),(0.,1.,0.)));",
    );
    assert_eq!(read(&text).unwrap().0.objects()[0].geometry().kind(), "mesh");
}

#[test]
fn a_curve_that_closes_may_start_anywhere() {
    // A square of degree 1, whose vertex is a corner other than its first.
    let data = "#100=OPEN_SHELL('',(#101));#101=ADVANCED_FACE('',(#95),#102,.T.);#102=PLANE('',#10);\
                #95=FACE_BOUND('',#90,.T.);#90=EDGE_LOOP('',(#91));#91=ORIENTED_EDGE('',*,*,#61,.T.);\
                #61=EDGE_CURVE('',#41,#41,#71,.T.);#41=VERTEX_POINT('',#52);\
                #71=POLYLINE('',(#51,#52,#53,#54,#51));#51=CARTESIAN_POINT('',(0.,0.,0.));\
                #52=CARTESIAN_POINT('',(1.,0.,0.));#53=CARTESIAN_POINT('',(1.,1.,0.));#54=CARTESIAN_POINT('',(0.,1.,0.));";
    let (scene, _) = read(&file("#100", &format!("{AXES}{data}"))).unwrap();
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!() };
    assert!(brep.flaws(1e-12).unwrap().is_empty());
    let edge = brep.edge(0).unwrap();
    let length = edge.curve.points().windows(2).map(|p| (p[1] - p[0]).norm()).sum::<f64>();
    assert!((length - 4.0).abs() < 1e-12);
}

/// A plane face between polygons, and what is said of it.
fn polygons(loops: &[&[[f64; 3]]]) -> Vec<String> {
    let (mut bounds, mut data, mut next) = (Vec::new(), String::new(), 200);
    for (k, points) in loops.iter().enumerate() {
        let numbers: Vec<String> = (0..points.len()).map(|i| format!("#{}", next + i)).collect();
        for [x, y, z] in *points {
            data += &format!("#{next}=CARTESIAN_POINT('',({x:?},{y:?},{z:?}));\n");
            next += 1;
        }
        let kind = if k == 0 { "FACE_OUTER_BOUND" } else { "FACE_BOUND" };
        data += &format!("#{next}=POLY_LOOP('',({}));\n", numbers.join(","));
        data += &format!("#{}={kind}('',#{next},.T.);\n", next + 1);
        bounds.push(format!("#{}", next + 1));
        next += 2;
    }
    let text = format!(
        "{AXES}#100=SHELL_BASED_SURFACE_MODEL('',(#101));\n#101=OPEN_SHELL('',(#102));\n\
         #102=FACE_SURFACE('',({}),#103,.T.);\n#103=PLANE('',#10);\n{data}",
        bounds.join(",")
    );
    let (_, report) = read(&file("#100", &text)).unwrap();
    report.notes.into_iter().filter(|note| note.starts_with("#10")).collect()
}

#[test]
fn loops_beside_one_another_and_edges_off_their_surface_are_told() {
    let square = |x: f64, a: f64| [[x, 0.0, 0.0], [x + a, 0.0, 0.0], [x + a, a, 0.0], [x, a, 0.0]];
    let hole = [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [4.0, 4.0, 0.0], [4.0, 2.0, 0.0]];
    assert_eq!(polygons(&[&square(0.0, 10.0)]), [""; 0]);
    assert_eq!(polygons(&[&square(0.0, 10.0), &hole]), [""; 0]);
    let told = polygons(&[&square(0.0, 10.0), &hole, &square(25.0, 4.0)]);
    assert!(
        told.len() == 1 && told[0].starts_with("#102: a loop of it, around an area of 16, lies outside"),
        "{told:?}"
    );
    let told = polygons(&[&[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 10.0, 50.0], [0.0, 10.0, 0.0]]]);
    assert!(
        told.len() == 1
            && told[0].contains("is up to 50 off the surface of face 0")
            && told[0].contains("; the file states "),
        "{told:?}"
    );
}

/// Which way loops run, and what lies within what: each told by itself, and none of what is right.
#[test]
fn loops_that_run_the_wrong_way_cross_or_lie_in_holes_are_told() {
    let square =
        |x: f64, y: f64, a: f64| [[x, y, 0.0], [x + a, y, 0.0], [x + a, y + a, 0.0], [x, y + a, 0.0]];
    let turned = |[a, b, c, d]: [[f64; 3]; 4]| [d, c, b, a];
    let outer = square(0.0, 0.0, 10.0);
    let hole = turned(square(2.0, 2.0, 4.0));
    let clockwise = "#102: its outer loop runs clockwise about its normal";
    let island = "#102: a loop of it, around an area of 1, lies within a hole";
    let across = "#102: a loop of it, around an area of 16, lies partly outside the largest: it crosses that";
    let others = [
        (vec![turned(outer)], clockwise),
        (vec![turned(outer), square(2.0, 2.0, 4.0)], clockwise),
        (vec![outer, square(2.0, 2.0, 4.0)], "#102: a hole of it runs the way of its outer loop"),
        (vec![outer, hole, square(3.0, 3.0, 1.0)], island),
        (vec![square(3.0, 3.0, 1.0), hole, outer], island),
        (vec![outer, turned(square(9.0, 3.0, 4.0))], across),
        // Beside a hole, which ends where it begins.
        (vec![outer, hole, turned(square(6.0, 6.0, 2.0))], ""),
    ];
    for (loops, expected) in others {
        let told = polygons(&loops.iter().map(|corners| &corners[..]).collect::<Vec<_>>());
        assert_eq!(told.len(), usize::from(!expected.is_empty()), "{told:?}");
        let whole = |told: &String| told.starts_with(expected) && !told.contains("; a ");
        assert!(told.iter().all(whole), "{expected}: {told:?} {loops:?}");
    }
    // A thousand holes, every tenth with an island.
    let holes: Vec<[[f64; 3]; 4]> =
        (0..1000).map(|k| turned(square(0.3 * f64::from(k % 33), 0.3 * f64::from(k / 33), 0.2))).collect();
    let frame = square(-1.0, -1.0, 12.0);
    let inner: Vec<[[f64; 3]; 4]> =
        holes.iter().step_by(10).map(|[_, _, _, [x, y, _]]| square(x + 0.05, y + 0.05, 0.1)).collect();
    let all: Vec<&[[f64; 3]]> =
        std::iter::once(&frame).chain(&holes).chain(&inner).map(|square| &square[..]).collect();
    let told = polygons(&all);
    assert!(told.len() == 1 && told[0].starts_with("#102: 100 loops of it, around areas of "), "{told:?}");
    assert!(
        told[0].ends_with("lie within holes: they are kept as islands there, parts of the face"),
        "{told:?}"
    );
}

/// A free-form surface moved along its normal is no spline: what is read is near to it, at the same parameters, and says how near.
#[test]
fn offsets_of_free_form_surfaces_are_approximated_and_told() {
    // A bump, degree 3 by 2, of several pieces.
    let mut points = Vec::new();
    let mut rows = Vec::new();
    for i in 0..5 {
        let mut row = Vec::new();
        for j in 0..4 {
            let number = 200 + 10 * i + j;
            let (x, y) = (f64::from(i), f64::from(j));
            let z = (0.9 * x).sin() * (0.7 * y + 0.3).cos();
            points.push(format!("#{number}=CARTESIAN_POINT('',({x:?},{y:?},{z:?}));"));
            row.push(format!("#{number}"));
        }
        rows.push(format!("({})", row.join(",")));
    }
    let basis = format!(
        "#102=B_SPLINE_SURFACE_WITH_KNOTS('',3,2,({}),.UNSPECIFIED.,.F.,.F.,.F.,(4,1,4),(3,1,3),(0.,1.,2.),(0.,0.4,1.),.UNSPECIFIED.);{}",
        rows.join(","),
        points.join("")
    );
    let base = surface(&basis.replace("#102=", "#101="));
    for distance in [0.2, -0.2] {
        let found = surface(&format!("#101=OFFSET_SURFACE('',#102,{distance:?},.F.);{basis}"));
        assert_eq!((found.u().domain(), found.v().domain()), ((0.0, 2.0), (0.0, 1.0)));
        for k in 0..=50 * 50 {
            let (u, v) = (2.0 * f64::from(k / 51) / 50.0, f64::from(k % 51) / 50.0);
            let [du, dv] = [(1, 0), (0, 1)].map(|(a, b)| base.derivative(u, v, a, b).unwrap());
            let wanted = base.point(u, v).unwrap() + du.cross(&dv).normalize() * distance;
            let off = (found.point(u, v).unwrap() - wanted).norm();
            assert!(off < 1e-6, "{distance}: {off} at {u} {v}");
        }
    }
    let text = format!("{AXES}#100=GEOMETRIC_SET('',(#101));#101=OFFSET_SURFACE('',#102,0.2,.F.);{basis}");
    let (_, report) = read(&file("#100", &text)).unwrap();
    assert!(report.notes.iter().any(|n| n.contains("approximated by a B-spline: up to")), "{report:?}");
    // By more than it bends it would fold.
    let text = format!("{AXES}#100=GEOMETRIC_SET('',(#101));#101=OFFSET_SURFACE('',#102,9.,.F.);{basis}");
    let told = match read(&file("#100", &text)) {
        Ok((_, report)) => format!("{report:?}"),
        Err(error) => error.to_string(),
    };
    assert!(told.contains("folds"), "{told}");
}

/// Edges, loops and faces as text, in the order of their numbers from 1000 on.
#[derive(Default)]
struct Text {
    data: String,
    count: usize,
}

impl Text {
    fn add(&mut self, entity: &str) -> String {
        let number = 1000 + self.count;
        self.count += 1;
        self.data += &format!("#{number}={entity};\n");
        format!("#{number}")
    }

    fn list(&mut self, kind: &str, numbers: &[f64]) -> String {
        let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
        self.add(&format!("{kind}('',({}))", numbers.join(",")))
    }

    fn vertex(&mut self, p: [f64; 3]) -> String {
        let point = self.list("CARTESIAN_POINT", &p);
        self.add(&format!("VERTEX_POINT('',{point})"))
    }

    fn straight(&mut self, a: [f64; 3], b: [f64; 3], ends: [&str; 2]) -> String {
        let points = [a, b].map(|p| self.list("CARTESIAN_POINT", &p));
        let line = self.add(&format!("POLYLINE('',({}))", points.join(",")));
        self.add(&format!("EDGE_CURVE('',{},{},{line},.T.)", ends[0], ends[1]))
    }

    /// Part of a circle around the axis of z, from one place of it to another; all of it where they are one.
    fn round(&mut self, radius: f64, z: f64, ends: [&str; 2], along: bool) -> String {
        let origin = self.list("CARTESIAN_POINT", &[0.0, 0.0, z]);
        let axis = self.list("DIRECTION", &[0.0, 0.0, if along { 1.0 } else { -1.0 }]);
        let placement = self.add(&format!("AXIS2_PLACEMENT_3D('',{origin},{axis},#13)"));
        let circle = self.add(&format!("CIRCLE('',{placement},{radius:?})"));
        self.add(&format!("EDGE_CURVE('',{},{},{circle},.T.)", ends[0], ends[1]))
    }

    fn bound(&mut self, edges: &[String], along: bool) -> String {
        let uses: Vec<String> =
            edges.iter().map(|edge| self.add(&format!("ORIENTED_EDGE('',*,*,{edge},.T.)"))).collect();
        let chain = self.add(&format!("EDGE_LOOP('',({}))", uses.join(",")));
        self.add(&format!("FACE_BOUND('',{chain},{})", if along { ".T." } else { ".F." }))
    }

    /// A rim of a cylinder.
    fn rim(&mut self, radius: f64, z: f64, along: bool) -> String {
        let vertex = self.vertex([radius, 0.0, z]);
        let edge = self.round(radius, z, [&vertex, &vertex], along);
        self.bound(&[edge], true)
    }

    /// A window of a cylinder between two angles and two heights.
    fn window(&mut self, radius: f64, angles: [f64; 2], heights: [f64; 2], along: bool) -> String {
        let at = |k: usize, l: usize| {
            [radius * angles[k].to_radians().cos(), radius * angles[k].to_radians().sin(), heights[l]]
        };
        let corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        let v = corners.map(|p| self.vertex(p));
        let edges = [
            self.round(radius, heights[0], [&v[0], &v[1]], true),
            self.straight(corners[1], corners[2], [&v[1], &v[2]]),
            self.round(radius, heights[1], [&v[2], &v[3]], false),
            self.straight(corners[3], corners[0], [&v[3], &v[0]]),
        ];
        self.bound(&edges, along)
    }

    /// What is said of a face with these bounds.
    fn told(self, bounds: &[String], surface: &str) -> Vec<String> {
        let text = format!(
            "{AXES}#100=SHELL_BASED_SURFACE_MODEL('',(#101));\n#101=OPEN_SHELL('',(#102));\n\
             #102=ADVANCED_FACE('',({}),#103,.T.);\n#103={surface};\n{}",
            bounds.join(","),
            self.data
        );
        let (scene, report) = read(&file("#100", &text)).unwrap();
        assert_eq!(scene.objects().len(), 1, "{report:?}");
        report.notes.into_iter().filter(|note| note.starts_with("#10")).collect()
    }
}

/// Which loop is in which is looked at where surfaces are curved, too, and where they go on across a seam.
#[test]
fn loops_beside_one_another_on_curved_faces_are_told() {
    let cylinder = "CYLINDRICAL_SURFACE('',#10,2.)";
    let between = |window: Option<([f64; 2], [f64; 2])>| {
        let mut text = Text::default();
        let mut bounds = vec![text.rim(2.0, 0.0, true), text.rim(2.0, 10.0, false)];
        bounds.extend(window.map(|(angles, heights)| text.window(2.0, angles, heights, false)));
        text.told(&bounds, cylinder)
    };
    assert_eq!(between(None), [""; 0]);
    assert_eq!(between(Some(([20.0, 70.0], [3.0, 5.0]))), [""; 0]);
    assert_eq!(between(Some(([-30.0, 30.0], [3.0, 5.0]))), [""; 0], "across the seam");
    for angles in [[20.0, 70.0], [-30.0, 30.0]] {
        let told = between(Some((angles, [12.0, 14.0])));
        assert!(
            told.len() == 1
                && told[0].starts_with("#102: a loop of it, around an area of ")
                && told[0].contains("lies outside what the others bound"),
            "{told:?}"
        );
    }
    // A panel of the cylinder, with a hole and with another panel beside it.
    let panel = |other: ([f64; 2], [f64; 2])| {
        let mut text = Text::default();
        // The other one runs the other way, as holes do.
        let bounds =
            [text.window(2.0, [-60.0, 60.0], [0.0, 10.0], true), text.window(2.0, other.0, other.1, false)];
        text.told(&bounds, cylinder)
    };
    assert_eq!(panel(([-20.0, 20.0], [3.0, 5.0])), [""; 0]);
    for beside in [([100.0, 140.0], [3.0, 5.0]), ([-20.0, 20.0], [12.0, 14.0])] {
        let told = panel(beside);
        assert!(told.len() == 1 && told[0].contains("lies outside what the others bound"), "{told:?}");
    }
    // On a ball without any border loops are beside one another: both are holes.
    let mut text = Text::default();
    let bounds = [text.rim(3.0, 4.0, false), text.rim(4.0, 3.0, true)];
    assert_eq!(text.told(&bounds, "SPHERICAL_SURFACE('',#10,5.)"), [""; 0]);

    // A bilinear spline, whose lines of parameters are straight.
    let spline = |windows: &[[[f64; 2]; 2]]| {
        let mut text = Text::default();
        let at = |x: f64, y: f64| [x, y, 0.1 * x * y];
        let bounds: Vec<String> = windows
            .iter()
            .enumerate()
            .map(|(k, [[a, b], [c, d]])| {
                let corners = [at(*a, *c), at(*b, *c), at(*b, *d), at(*a, *d)];
                let v = corners.map(|p| text.vertex(p));
                let edges: Vec<String> = (0..4)
                    .map(|k| text.straight(corners[k], corners[(k + 1) % 4], [&v[k], &v[(k + 1) % 4]]))
                    .collect();
                text.bound(&edges, k == 0)
            })
            .collect();
        let net: Vec<String> = [(0.0, 0.0), (0.0, 9.0), (9.0, 0.0), (9.0, 9.0)]
            .map(|(x, y)| text.list("CARTESIAN_POINT", &at(x, y)))
            .to_vec();
        let surface = format!(
            "B_SPLINE_SURFACE_WITH_KNOTS('',1,1,(({},{}),({},{})),.U.,.F.,.F.,.F.,(2,2),(2,2),(0.,1.),(0.,1.),.U.)",
            net[0], net[1], net[2], net[3]
        );
        text.told(&bounds, &surface)
    };
    assert_eq!(spline(&[[[0.0, 5.0], [0.0, 5.0]], [[1.0, 2.0], [1.0, 2.0]]]), [""; 0]);
    let told = spline(&[[[0.0, 5.0], [0.0, 5.0]], [[1.0, 2.0], [1.0, 2.0]], [[6.0, 8.0], [6.0, 8.0]]]);
    assert!(told.len() == 1 && told[0].contains("lies outside what the others bound"), "{told:?}");
}
