//! Where parts are, and how large: mapped items, occurrences that are said the other way round, units of each context, frames without all directions.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use crate::common::{AXES, file, read};
use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Format, Memory, WriteOptions};
use loftsman_kernel::scene::{Definition, Geometry, Object, Scene, Unit};
use loftsman_step::Step;
use nalgebra::{Matrix4, Rotation3, Vector3};

/// A placement, by its point and the directions of `z` and `x`.
fn frame(number: u32, origin: &str, z: &str, x: &str) -> String {
    let [p, a, b] = [number + 1, number + 2, number + 3];
    format!(
        "#{number}=AXIS2_PLACEMENT_3D('',#{p},#{a},#{b});#{p}=CARTESIAN_POINT('',({origin}));\
         #{a}=DIRECTION('',({z}));#{b}=DIRECTION('',({x}));\n"
    )
}

/// A line of a part, in a representation of its own.
fn part(representation: u32, context: u32, from: &str, to: &str) -> String {
    let [line, a, b] = [representation + 1, representation + 2, representation + 3];
    format!(
        "#{representation}=SHAPE_REPRESENTATION('part',(#{line}),#{context});#{line}=POLYLINE('',(#{a},#{b}));\
         #{a}=CARTESIAN_POINT('',({from}));#{b}=CARTESIAN_POINT('',({to}));\n"
    )
}

/// A context in inches, that has the numbers of the one in millimetres and ten.
const INCHES: &str = "#15=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#16,#2))REPRESENTATION_CONTEXT('',''));\
     #16=(CONVERSION_BASED_UNIT('INCH',#17)LENGTH_UNIT()NAMED_UNIT(*));\
     #17=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#1);\n";

/// The ends of all lines of a scene, where they are shown.
fn shown(scene: &Scene) -> Vec<Point> {
    let mut all = Vec::new();
    for placed in scene.placed(100).unwrap() {
        if let Geometry::Polyline(line) = placed.object.geometry() {
            let to_world = placed.to_world.unwrap_or_else(Matrix4::identity);
            all.extend(line.points.iter().map(|p| to_world.transform_point(p)));
        }
    }
    all
}

#[track_caller]
fn near(found: &[Point], wanted: &[[f64; 3]]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (a, b) in found.iter().zip(wanted) {
        assert!((a - Point::from(*b)).norm() < 1e-12, "{found:?} {wanted:?}");
    }
}

/// The frame that a map has in what is mapped comes to lie on the one that the item has.
#[test]
fn what_is_mapped_comes_from_its_own_frame_to_that_of_the_item() {
    let data = part(200, 5, "1.,2.,3.", "2.,4.,7.")
        + "#100=MAPPED_ITEM('',#101,#110);#101=REPRESENTATION_MAP(#120,#200);\n"
        + &frame(110, "10.,20.,30.", "0.,0.,1.", "0.,1.,0.")
        + &frame(120, "1.,2.,3.", "1.,0.,0.", "0.,1.,0.");
    let (scene, report) = read(&file("#100", &data)).unwrap();
    assert!(report.left_out.keys().all(|why| !why.starts_with('#')), "{report:?}");
    near(&shown(&scene), &[[10.0, 20.0, 30.0], [6.0, 22.0, 31.0]]);
    // In a representation that is mapped itself, from an offset frame.
    let nested = data.replace("#100=", "#300=SHAPE_REPRESENTATION('pair',(#301),#5);#301=")
        + "#100=MAPPED_ITEM('',#102,#130);#102=REPRESENTATION_MAP(#140,#300);\n"
        + &frame(130, "0.,0.,5.", "0.,1.,0.", "0.,0.,1.")
        + &frame(140, "1.,1.,1.", "0.,0.,1.", "1.,0.,0.");
    let (scene, _) = read(&file("#100", &nested)).unwrap();
    near(&shown(&scene), &[[19.0, 29.0, 14.0], [21.0, 30.0, 10.0]]);
}

/// The lengths of each representation are those of its own context, frames of a map among them.
#[test]
fn each_representation_has_the_unit_of_its_context() {
    let data = part(200, 15, "1.,0.,0.", "3.,1.,0.")
        + INCHES
        + "#100=MAPPED_ITEM('',#101,#110);#101=REPRESENTATION_MAP(#120,#200);\n"
        + &part(400, 5, "0.,0.,0.", "1.,0.,0.")
        + &frame(110, "10.,20.,30.", "0.,0.,1.", "1.,0.,0.")
        + &frame(120, "1.,0.,0.", "0.,0.,1.", "1.,0.,0.");
    let (scene, _) = read(&file("#100,#401", &data)).unwrap();
    let inches = scene.unit == Unit::Inch;
    assert!(inches || scene.unit == Unit::Millimetre, "{:?}", scene.unit);
    let scale = if inches { 25.4 } else { 1.0 };
    let mut found: Vec<Point> = shown(&scene).iter().map(|p| p * scale).collect();
    found.sort_by(|a, b| a.x.total_cmp(&b.x));
    found.dedup();
    near(&found, &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [10.0, 20.0, 30.0], [60.8, 45.4, 30.0]]);
}

#[test]
fn triangles_have_the_unit_of_their_context() {
    let data = INCHES.to_owned()
        + "#200=SHAPE_REPRESENTATION('part',(#100),#15);\n\
           #100=TRIANGULATED_FACE('m',#101,3,(),$,(),((1,2,3)));\
           #101=COORDINATES_LIST('',3,((1.,0.,0.),(2.,0.,0.),(1.,3.,0.)));\n"
        + &part(400, 5, "0.,0.,0.", "1.,0.,0.");
    let (scene, _) = read(&file("#401", &data)).unwrap();
    assert_eq!(scene.unit, Unit::Millimetre);
    let mesh = scene.objects().iter().find_map(|object| match object.geometry() {
        Geometry::Mesh(mesh) => Some(mesh),
        _ => None,
    });
    near(mesh.unwrap().points(), &[[25.4, 0.0, 0.0], [50.8, 0.0, 0.0], [25.4, 76.2, 0.0]]);
}

/// How exact a file says it is may be said in another unit than its lengths.
#[test]
fn uncertainties_are_in_their_own_unit() {
    let text =
        std::fs::read_to_string(format!("{}/../../tests/data/step/tet.step", env!("CARGO_MANIFEST_DIR")))
            .unwrap();
    let tolerance = |text: &str| {
        let (scene, _) = read(text).unwrap();
        assert_eq!(scene.unit, Unit::Centimetre);
        let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!() };
        brep.tolerances()[0]
    };
    assert_eq!(tolerance(&text), 0.001);
    let other = |unit: &str| {
        let from = "LENGTH_MEASURE(0.001),#136,";
        assert_eq!(text.matches(from).count(), 1);
        text.replace(from, "LENGTH_MEASURE(0.001),#900,").replace("#142=", &format!("#900={unit};\n#142="))
    };
    let metre = other("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))");
    assert!((tolerance(&metre) - 0.1).abs() < 1e-16);
    let millimetre = other("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))");
    assert!((tolerance(&millimetre) - 1e-4).abs() < 1e-18);
}

/// ISO 10303-42, first_proj_axis: without a direction `x` is that of the axes as it is seen along `z`, and `y` where `z` is along `x`.
#[test]
fn frames_without_a_direction_of_x() {
    for (z, x, y) in [
        ("$", [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
        ("#12", [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]),
        ("#21", [2.0, 0.0, 0.0], [0.0, 0.0, 2.0]),
        ("#22", [1.6, 0.0, -1.2], [0.0, 2.0, 0.0]),
        ("#23", [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]),
    ] {
        let data = format!(
            "{AXES}#21=DIRECTION('',(0.,-3.,0.));#22=DIRECTION('',(3.,0.,4.));#23=DIRECTION('',(2.,0.,0.));\
             #30=AXIS2_PLACEMENT_3D('',#11,{z},$);#100=GEOMETRIC_SET('',(#101));#101=CIRCLE('',#30,2.);"
        );
        let (scene, _) = read(&file("#100", &data)).unwrap();
        let Geometry::Curve(circle) = scene.objects()[0].geometry() else { panic!() };
        let (a, b) = circle.domain();
        near(&[a, a + 0.25 * (b - a)].map(|t| circle.point(t).unwrap()), &[x, y]);
    }
}

/// Some writers name the whole first and the part second, and their frames in the same order: it stands in the same place.
#[test]
fn occurrences_said_the_other_way_round_stand_where_they_stood() {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7);
    let place = Matrix4::new_translation(&Vector3::new(3.0, -1.0, 2.0)) * turn.to_homogeneous();
    let mut part = Definition::new("part");
    let block = Brep::block(Point::origin(), Point::new(1.0, 2.0, 3.0)).unwrap();
    part.add(Object::new("block", block.into())).unwrap();
    let mut scene = Scene::new();
    scene.define(part).unwrap();
    let mut instance = Object::new("shown", Geometry::Instance("part".to_owned()));
    instance.transform = Some(place);
    scene.add(instance).unwrap();
    let mut memory = Memory::new("t.step", Vec::new());
    Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap();
    let text = String::from_utf8(memory.bytes).unwrap();
    let exchanged = |text: &str, after: &str| {
        let start = text.find(after).unwrap() + after.len();
        let end = start + text[start..].find(')').unwrap();
        let (from, to) = text[start..end].split_once(',').unwrap();
        format!("{}{to},{from}{}", &text[..start], &text[end..])
    };
    let stands = |text: &str| read(text).unwrap().0.objects().iter().find_map(|o| o.transform).unwrap();
    let relation = "(REPRESENTATION_RELATIONSHIP('','',";
    let frames = "ITEM_DEFINED_TRANSFORMATION('','',";
    assert!((stands(&text) - place).amax() < 1e-14);
    let both = exchanged(&exchanged(&text, relation), frames);
    assert!((stands(&both) - place).amax() < 1e-13);
    // Only the representations: the frames are then each of the other one.
    let one = exchanged(&text, relation);
    assert!((stands(&one) - place.try_inverse().unwrap()).amax() < 1e-13);
}
