//! Files of other programs, with facts counted by someone else (`tests/data/obj/SOURCES.md`).

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Format, FormatError, Memory, Parameters, Place, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene, Up};
use loftsman_obj::Obj;

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/obj/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn try_read(name: &str, options: &ReadOptions<'_>) -> Result<(Scene, ReadReport), FormatError> {
    let data = bytes(name);
    assert!(Obj.recognises(&data[..data.len().min(4096)]) || name == "icosahedron.obj", "{name}");
    Obj.read(&Memory::new(name, data), options)
}

fn read(name: &str) -> (Scene, ReadReport) {
    let (scene, report) = try_read(name, &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && scene.up == Up::Y, "{name}: {report:?}");
    (scene, report)
}

/// Points, faces, triangles of all meshes together.
fn sizes(scene: &Scene) -> (usize, usize, usize) {
    scene.objects().iter().fold((0, 0, 0), |(p, f, t), o| match &o.geometry {
        Geometry::Mesh(m) => (p + m.points().len(), f + m.face_count(), t + m.triangle_count()),
        _ => (p, f, t),
    })
}

#[test]
fn meshes_have_the_counted_points_faces_and_objects() {
    for (name, objects, v, f, triangles) in [
        ("box_longline.obj", 1, 8, 6, 944),
        ("cat_head.obj", 1, 131, 248, 248),
        ("concave_polygon.obj", 1, 64, 1, 64),
        ("cube with white spaces.obj", 1, 8, 6, 12),
        ("cube_with_vertexcolors.obj", 1, 8, 12, 12),
        ("dodecahedron_poly.obj", 1, 20, 12, 36),
        ("hundred_cubes.obj", 100, 800, 600, 1200),
        ("icosahedron.obj", 1, 12, 20, 20),
        ("moebius.obj", 1, 280, 224, 448),
    ] {
        let (scene, _) = read(name);
        assert_eq!((scene.objects().len(), sizes(&scene)), (objects, (v, f, triangles)), "{name}");
    }
    assert_eq!(read("dodecahedron_poly.obj").0.objects()[0].name(), "dodecahedron");
    assert_eq!(read("cat_head.obj").0.objects()[0].name(), "cat_head");
}

#[test]
fn lines_and_points_have_the_counted_elements() {
    let (scene, report) = read("testmixed.obj");
    // 8 vertices, 6 faces, 6 lines and 6 point statements are kept; two of the lines join.
    assert_eq!((report.kept, sizes(&scene)), (8 + 6 + 6 + 6, (8, 6, 12)));
    let cloud = scene.objects().iter().find(|o| o.geometry.kind() == "cloud").unwrap();
    assert_eq!(cloud.geometry.points().len(), 24);
    let (scene, _) = read("lines_with_vt.obj");
    assert!(matches!(&scene.objects()[2].geometry, Geometry::Polyline(l) if l.closed && l.points.len() == 4));
}

#[test]
fn odd_numbers_are_read_and_the_impossible_one_is_refused_with_its_line() {
    let error = try_read("number_formats.obj", &ReadOptions::default()).unwrap_err();
    assert_eq!(error.place, Place::Line(11));
    // All its other numbers are read: it alone stands in the way.
    let text = String::from_utf8(bytes("number_formats.obj")).unwrap();
    let mended = text.replace("3.1+e", "3.1e+").replace("3.1-e", "3.1e-");
    let (scene, report) = Obj.read(&Memory::new("n.obj", mended), &ReadOptions::default()).unwrap();
    assert_eq!((sizes(&scene), report.left_out.values().sum::<usize>()), ((3, 1, 1), 12));
}

#[test]
fn normals_by_face_are_kept_when_points_may_be_split() {
    let mut options = ReadOptions::default();
    let own = serde_json::json!({ "corners": "split" });
    options.own = Parameters::new(own, "options").unwrap();
    let (scene, report) = try_read("icosahedron.obj", &options).unwrap();
    assert!(report.adds_up());
    let Geometry::Mesh(mesh) = &scene.objects()[0].geometry else { unreachable!() };
    assert_eq!((mesh.points().len(), mesh.normals.values().len(), mesh.face_count()), (60, 60, 20));
    assert!(read("icosahedron.obj").1.left_out.values().any(|&n| n == 20));
}

#[test]
fn vertex_colours_are_linear() {
    let (scene, _) = read("cube_with_vertexcolors.obj");
    let Geometry::Mesh(mesh) = &scene.objects()[0].geometry else { unreachable!() };
    // sRGB 0.48627 is linear 0.20156.
    assert!((mesh.colors.values()[0][0] - 0.20156).abs() < 1e-5 && mesh.colors.values()[0][3] == 1.0);
}

#[test]
fn free_form_curves_are_exact() {
    let (scene, report) = read("spec_bezier_curve_13cv.obj");
    let curve = scene.curve("spec_bezier_curve_13cv").unwrap();
    assert_eq!(curve.domain(), (0.0, 4.0));
    for (u, x, y) in [(0.0, -2.3, 1.95), (1.0, -1.53, -1.49), (4.0, 2.9, 1.98)] {
        assert!((curve.point(u).unwrap() - Point::new(x, y, 0.0)).norm() < 1e-15);
    }
    assert_eq!(report.left_out.len(), 1);
    let (scene, _) = read("tinynurbs_output_curve.obj");
    let curve = scene.curve("tinynurbs_output_curve").unwrap();
    assert_eq!((curve.degree(), curve.points().len(), curve.weights()), (2, 6, None));
    assert_eq!(read("spec_trim_special_points.obj").0.objects().len(), 1);
}

#[test]
fn what_is_not_read_is_counted_by_statement() {
    for (name, statement, count) in [
        ("spec_bezier_patch.obj", "surf", 1),
        ("spec_bspline_surface.obj", "surf", 1),
        ("spec_cardinal_surface.obj", "surf", 1),
        ("spec_rational_bspline_surface.obj", "surf", 1),
        ("spec_trimmed_nurb_surface.obj", "vp", 6),
        ("spec_trimmed_nurb_surface_fixed.obj", "trim", 1),
        ("spec_trim_special_curve.obj", "scrv", 1),
        ("spec_trim_special_points.obj", "sp", 3),
        ("spec_two_regions_with_holes.obj", "hole", 2),
        ("spec_taylor_curve.obj", "taylor", 1),
        ("oxideav_bmatrix_arch.obj", "bmatrix", 1),
        ("oxideav_bmatrix_hermite.obj", "bmat ", 1),
        ("oxideav_bmatrix_two_segments.obj", "step", 1),
        ("tinynurbs_output_hemisphere.obj", "surf", 1),
    ] {
        let (_, report) = read(name);
        let found: usize = report
            .left_out
            .iter()
            .filter(|(reason, _)| format!("{reason} ").contains(&format!(" {}", statement.trim())))
            .map(|(_, n)| n)
            .sum();
        assert!(found >= count, "{name}: {report:?}");
    }
}

#[test]
fn the_colour_of_one_material_is_kept_and_a_missing_library_is_noted() {
    let text = "mtllib ./a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no one\nusemtl red\nf 1 2 3\n\
                o two\nf 1 2 3\nusemtl glass\nf 1 3 2\no three\nusemtl glass\nf 1 2 3\n";
    let mut file = Memory::new("m.obj", text);
    let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    assert!(scene.objects().iter().all(|o| o.color.is_none()));
    assert!(report.notes.iter().any(|n| n.contains("a b.mtl")));
    let library = "newmtl red\nKd 1 0 0\nnewmtl glass\nd 0.25\nKd 0 0.5 1\nillum x\nKd nonsense\n";
    file.siblings.insert("a b.mtl".into(), library.into());
    let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    let colors: Vec<_> = scene.objects().iter().map(|o| o.color).collect();
    assert_eq!(colors, [Some([1.0, 0.0, 0.0, 1.0]), None, Some([0.0, 0.5, 1.0, 0.25])]);
    assert!(report.adds_up() && report.approximated.values().sum::<usize>() == 4);
    // A library outside the folder is not looked for.
    let text = text.replace("./a b.mtl", "../../etc/passwd");
    assert!(Obj.read(&Memory::new("m.obj", text), &ReadOptions::default()).is_ok());
}

#[test]
fn a_wrapped_b_spline_is_periodic_and_the_same_curve() {
    // As Rhino writes closed curves: the first control vertices again at the end, knots beyond the domain.
    let mut text = String::from("cstype bspline\ndeg 3\n");
    for (x, y) in [(0.0, 0.0), (2.0, 0.5), (3.0, 2.0), (1.0, 4.0), (-1.5, 1.0)] {
        text = format!("v {x} {y} 0.25\n{text}");
    }
    text.push_str("curv 0 5 1 2 3 4 5 1 2 3\nparm u -3 -2 -1 0 1 2 3 4 5 6 7 8\nend\n");
    let (scene, report) = Obj.read(&Memory::new("loop.obj", text.as_str()), &ReadOptions::default()).unwrap();
    let curve = scene.curve("loop").unwrap();
    assert!(curve.is_periodic() && curve.points().len() == 5 && curve.domain() == (0.0, 5.0));
    assert!(report.notes.iter().any(|n| n.contains("periodic")));
    // At a knot of a uniform cubic: (P0 + 4 P1 + P2) / 6; vertices are numbered from the last line up.
    let expected = Point::new((-1.5 + 4.0 * 1.0 + 3.0) / 6.0, (1.0 + 4.0 * 4.0 + 2.0) / 6.0, 0.25);
    assert!((curve.point(0.0).unwrap() - expected).norm() < 1e-15);
    // A knot that does not repeat: still exact, but open.
    let open = text.replace("6 7 8", "6 7 8.5");
    let (scene, _) = Obj.read(&Memory::new("loop.obj", open), &ReadOptions::default()).unwrap();
    assert!(!scene.curve("loop").unwrap().is_periodic());
}
