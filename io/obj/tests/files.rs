//! Files of other programs, with facts counted by someone else (`tests/data/obj/SOURCES.md`), and tobj's reading of them.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::Point;
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::{
    Confidence, Format, FormatError, Memory, Parameters, Place, ReadOptions, ReadReport,
};
use loftsman_kernel::scene::{Geometry, Scene, Up};
use loftsman_obj::Obj;

const MESHES: [&str; 11] = [
    "box_longline.obj",
    "cat_head.obj",
    "concave_polygon.obj",
    "cube with white spaces.obj",
    "cube_with_vertexcolors.obj",
    "dodecahedron_poly.obj",
    "hundred_cubes.obj",
    "icosahedron.obj",
    "moebius.obj",
    "spider.obj",
    "spot.obj",
];

fn path(name: &str) -> String {
    format!("{}/../../tests/data/obj/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn try_read(name: &str, options: &ReadOptions<'_>) -> Result<(Scene, ReadReport), FormatError> {
    let data = std::fs::read(path(name)).unwrap();
    assert!(
        Obj.confidence(&data[..data.len().min(4096)]) == Confidence::Sure || name == "icosahedron.obj",
        "{name}"
    );
    Obj.read(&Memory::new(name, data), options)
}

fn read(name: &str) -> (Scene, ReadReport) {
    let (scene, report) = try_read(name, &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && scene.up == Up::Y, "{name}: {report:?}");
    scene.check().unwrap();
    (scene, report)
}

fn meshes(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    scene
        .objects()
        .iter()
        .filter_map(|o| if let Geometry::Mesh(mesh) = o.geometry() { Some(mesh) } else { None })
}

fn mesh(scene: &Scene) -> &Mesh {
    meshes(scene).next().unwrap()
}

#[test]
fn meshes_have_the_counted_points_faces_groups_and_layers() {
    let layer = |values: usize, corners: Option<usize>| (values, corners);
    // Points, texture vertices, normals (one of spider.obj has no length), faces, triangles, groups.
    let facts = [
        (8, 0, 0, 6, 944, 0),
        (131, 0, 0, 248, 248, 0),
        (64, 0, 1, 1, 64, 0),
        (8, 4, 6, 6, 12, 2),
        (8, 0, 6, 12, 12, 1),
        (20, 0, 0, 12, 36, 0),
        (800, 0, 0, 600, 1200, 100),
        (12, 0, 20, 20, 20, 1),
        (280, 0, 0, 224, 448, 0),
        (762, 302, 746, 1368, 1368, 19),
        (2930, 3225, 0, 5856, 5856, 0),
    ];
    for (name, (v, vt, vn, f, triangles, groups)) in MESHES.into_iter().zip(facts) {
        let (scene, _) = read(name);
        assert_eq!(scene.objects().len(), 1, "{name}");
        let m = mesh(&scene);
        let found = (m.points().len(), m.uvs.values().len(), m.normals.values().len());
        assert_eq!(found, (v, vt, vn), "{name}");
        assert_eq!((m.face_count(), m.triangle_count(), m.groups.len()), (f, triangles, groups), "{name}");
        let corners = |l: Option<&[u32]>| l.map(<[u32]>::len);
        let uvs = layer(m.uvs.values().len(), corners(m.uvs.corners()));
        assert!(uvs.1.is_none_or(|n| n == m.corners().len()), "{name}: {uvs:?}");
    }
    assert_eq!(read("dodecahedron_poly.obj").0.objects()[0].name(), "dodecahedron");
    assert_eq!(read("cat_head.obj").0.objects()[0].name(), "cat_head");
    let (scene, _) = read("hundred_cubes.obj");
    assert!(mesh(&scene).groups.iter().all(|g| g.faces.len() == 6));
}

#[test]
fn groups_can_be_objects() {
    let own = Parameters::new(serde_json::json!({ "split": "group" }), "options").unwrap();
    let options = ReadOptions { own, ..ReadOptions::default() };
    let (scene, report) = try_read("hundred_cubes.obj", &options).unwrap();
    assert!(report.adds_up());
    assert_eq!(scene.objects().len(), 100);
    assert!(meshes(&scene).all(|m| (m.points().len(), m.face_count(), m.groups.len()) == (8, 6, 0)));
}

/// The reference reads the same corners, and finds the same vertices, texture vertices and normals there. (It takes the
/// lines and points of testmixed.obj for faces.)
#[test]
fn tobj_agrees_on_every_mesh() {
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let mut compared = 0;
    for name in MESHES {
        let (models, _) = tobj::load_obj(path(name), &options).unwrap();
        let (scene, _) = read(name);
        let ours = mesh(&scene);
        let at = |layer: &Layer<[f64; 2]>, corner: usize| layer.at(corner, ours.corners()[corner]).copied();
        // tobj makes a model of each group and material; ours are one mesh in the same order.
        let mut first = 0;
        for model in models.iter().map(|m| &m.mesh) {
            for (k, &v) in model.indices.iter().enumerate() {
                let corner = first + k;
                let point = ours.points()[ours.corners()[corner] as usize];
                let close = |a: f64, b: f32| (a - f64::from(b)).abs() <= 1e-6 * a.abs().max(1.0);
                let there = &model.positions[3 * v as usize..][..3];
                assert!(point.iter().zip(there).all(|(a, b)| close(*a, *b)), "{name}: corner {corner}");
                if let Some(&t) = model.texcoord_indices.get(k) {
                    let uv = at(&ours.uvs, corner).unwrap();
                    let there = &model.texcoords[2 * t as usize..][..2];
                    assert!(uv.iter().zip(there).all(|(a, b)| close(*a, *b)), "{name}: corner {corner}");
                }
                if let Some(&n) = model.normal_indices.get(k) {
                    let there: Vec<f64> =
                        model.normals[3 * n as usize..][..3].iter().map(|x| f64::from(*x)).collect();
                    let there = loftsman_kernel::Vector::new(there[0], there[1], there[2]);
                    let normal = ours.normals.at(corner, ours.corners()[corner]);
                    // A normal without length is none.
                    assert_eq!(normal.is_none(), there.norm() == 0.0, "{name}: corner {corner}");
                    let Some(normal) = normal else { continue };
                    assert!((normal - there / there.norm()).norm() < 1e-3, "{name}: corner {corner}");
                }
            }
            first += model.indices.len();
        }
        assert_eq!(first, ours.corners().len(), "{name}");
        compared += first;
    }
    assert!(compared > 20_000);
}

#[test]
fn lines_and_points_have_the_counted_elements() {
    let (scene, report) = read("testmixed.obj");
    // 8 vertices, 6 faces, 6 lines and 6 point statements are kept, and two statements of state.
    assert!(report.kept >= 8 + 6 + 6 + 6, "{report:?}");
    let m = mesh(&scene);
    assert_eq!((m.points().len(), m.face_count(), m.triangle_count()), (8, 6, 12));
    assert!(m.lines().count() > 0 && m.lines().map(|l| l.len() - 1).sum::<usize>() >= 6);
    let cloud = scene.objects().iter().find(|o| o.geometry().kind() == "cloud").unwrap();
    assert_eq!(cloud.geometry().points().len(), 24);
    let (scene, _) = read("lines_with_vt.obj");
    assert!(
        matches!(scene.objects()[2].geometry(), Geometry::Polyline(l) if l.closed && l.points.len() == 4)
    );
}

#[test]
fn odd_numbers_are_read_and_the_impossible_ones_are_left_out_with_their_lines() {
    let (scene, report) = read("number_formats.obj");
    assert_eq!(mesh(&scene).points().len(), 3);
    let wrong: Vec<&String> = report.left_out.keys().filter(|why| why.starts_with("line ")).collect();
    assert_eq!(wrong.len(), 6, "{wrong:?}");
    assert_eq!(wrong[0], "line 11: \"3.1+e2\" is not a number");
    // All its other numbers are read.
    let text = std::fs::read_to_string(path("number_formats.obj")).unwrap();
    let mended = text.replace("3.1+e", "3.1e+").replace("3.1-e", "3.1e-");
    let (scene, report) = Obj.read(&Memory::new("n.obj", mended), &ReadOptions::default()).unwrap();
    assert_eq!((mesh(&scene).points().len(), report.left_out.values().sum::<usize>()), (3, 12));
}

#[test]
fn vertex_colours_are_linear() {
    let (scene, _) = read("cube_with_vertexcolors.obj");
    // sRGB 0.48627 is linear 0.20156.
    let color = mesh(&scene).colors.values()[0];
    assert!((color[0] - 0.20156).abs() < 1e-5 && color[3] == 1.0);
    // ZBrush's comments belong to the vertices before them, block by block.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n#MRGB ff000000ffFFFFFF\n#MRGB ff7f0000\nv 0 0 1\n#MRGB ff0000ff\n\
                f 1 2 3\nf 1 2 4\n";
    let (scene, _) = Obj.read(&Memory::new("z.obj", text), &ReadOptions::default()).unwrap();
    let colors = mesh(&scene).colors.values().to_vec();
    assert_eq!((colors[0], colors[1], colors[3]), ([0.0, 0.0, 0.0, 1.0], [1.0; 4], [0.0, 0.0, 1.0, 1.0]));
    assert!((colors[2][0] - 0.212_230_757_9).abs() < 1e-9);
    for (wrong, says) in [
        ("#MRGB ff", "line 2"),
        ("#MRGB ff00000g", "line 2"),
        ("#MRGB ff000000ff000000ff000000ff000000", "too many"),
    ] {
        let text = format!("v 0 0 0\n{wrong}\nv 1 0 0\nf 1 2 1\n");
        let (scene, report) = Obj.read(&Memory::new("z.obj", text), &ReadOptions::default()).unwrap();
        assert!(mesh(&scene).colors.is_empty() && report.adds_up(), "{wrong}");
        assert!(report.left_out.keys().any(|why| why.contains(says)), "{wrong}: {report:?}");
    }
    // Some have a colour, some not: only their corners do.
    let text = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let (scene, _) = Obj.read(&Memory::new("c.obj", text), &ReadOptions::default()).unwrap();
    let m = mesh(&scene);
    assert_eq!((m.colors.at(0, 0), m.colors.at(1, 1)), (Some(&[1.0, 0.0, 0.0, 1.0]), None));
}

#[test]
fn free_form_curves_are_exact() {
    let (scene, _) = read("spec_bezier_curve_13cv.obj");
    let curve = scene.curve("spec_bezier_curve_13cv").unwrap();
    assert_eq!(curve.domain(), (0.0, 4.0));
    for (u, x, y) in [(0.0, -2.3, 1.95), (1.0, -1.53, -1.49), (4.0, 2.9, 1.98)] {
        assert!((curve.point(u).unwrap() - Point::new(x, y, 0.0)).norm() < 1e-15);
    }
    let (scene, _) = read("tinynurbs_output_curve.obj");
    let curve = scene.curve("tinynurbs_output_curve").unwrap();
    assert_eq!((curve.degree(), curve.points().len(), curve.weights()), (2, 6, None));
    for (name, u, at) in [
        ("spec_taylor_curve", 1.0, [27.92, -6.37, 9.18]),
        ("oxideav_bmatrix_arch", 0.5, [1.5, 1.5, 0.0]),
        // Hermite, from P0 with tangent P1 to P2 with tangent P3, as its matrix says.
        ("oxideav_bmatrix_hermite", 0.5, [0.625, 0.375, 0.0]),
        ("oxideav_bmatrix_two_segments", 1.0, [3.0, 0.0, 0.0]),
        ("oxideav_bmatrix_two_segments", 1.5, [4.5, -0.75, 0.0]),
    ] {
        let (scene, report) = read(&format!("{name}.obj"));
        assert!(report.left_out.is_empty(), "{report:?}");
        let point = scene.curve(name).unwrap().point(u).unwrap();
        assert!((point - Point::from(at)).norm() < 1e-12, "{name}: {point}");
    }
}

#[test]
fn free_form_surfaces_are_exact() {
    for (name, corners) in [
        ("spec_bezier_patch", [[-5.0, 5.0, 0.0], [5.0, 5.0, 0.0]]),
        ("spec_cardinal_surface", [[-5.0 / 3.0, 5.0 / 3.0, 0.0], [5.0 / 3.0, 5.0 / 3.0, 0.0]]),
        ("spec_rational_bspline_surface", [[-1.3, -1.0, 0.0], [-1.4, 1.0, 0.0]]),
    ] {
        let (scene, _) = read(&format!("{name}.obj"));
        let surface = scene.surface(name).unwrap();
        let (u, v) = (surface.u().domain(), surface.v().domain());
        // The first vertices run along u: (u1, v0) is the end of the first row.
        let found = [surface.point(u.0, v.0).unwrap(), surface.point(u.0, v.1).unwrap()];
        if name == "spec_rational_bspline_surface" {
            assert_eq!(found, corners.map(Point::from));
            assert_eq!(surface.weights().unwrap()[3..5], [7.6, 0.5]);
            continue;
        }
        // Both are squares: z stays 0 and the corners are those of the square.
        for (a, b) in found.iter().zip(corners) {
            assert!(
                a.z == 0.0 && (a.x.abs() - b[0].abs()).abs() < 1e-5 && (a.y.abs() - b[1].abs()).abs() < 1e-5
            );
        }
    }
    let (scene, _) = read("spec_bspline_surface.obj");
    let patch = scene.surface("bspatch").unwrap();
    // At a corner of a uniform bicubic patch the inner four have the weights (16 + 4 + 4 + 1) / 36.
    let z = (25.0 * 11.977780 - 11.0 * 7.808327) / 36.0;
    assert!((patch.point(0.0, 0.0).unwrap().z - z).abs() < 1e-12);
    let (scene, _) = read("tinynurbs_output_hemisphere.obj");
    let sphere = scene.surface("tinynurbs_output_hemisphere").unwrap();
    for k in 0..=20 {
        let at = f64::from(k) / 20.0;
        assert!((sphere.point(at, 1.0 - at * at).unwrap().coords.norm() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn trimmed_surfaces_keep_loops_special_curves_and_points() {
    // Outer loops, holes, special curves, special points, curves beside them.
    for (name, facts) in [
        ("spec_trimmed_nurb_surface_fixed", (1, 0, 0, 0, 0)),
        ("spec_trim_special_curve", (1, 0, 1, 0, 0)),
        ("spec_trim_special_points", (1, 0, 0, 1, 1)),
        ("spec_two_regions_with_holes", (2, 2, 0, 0, 0)),
    ] {
        let (scene, report) = read(&format!("{name}.obj"));
        let trimmed = scene.objects().iter().find_map(|o| match o.geometry() {
            Geometry::Trimmed(trimmed) => Some(trimmed),
            _ => None,
        });
        let trimmed = trimmed.unwrap();
        let holes = trimmed.regions().iter().map(|r| r.holes.len()).sum::<usize>();
        let curves = scene.objects().iter().filter(|o| o.geometry().kind() == "curve").count();
        let found = (trimmed.regions().len(), holes, trimmed.curves().len(), trimmed.points().len(), curves);
        assert_eq!(found, facts, "{name}: {report:?}");
    }
    let (scene, report) = read("spec_trim_special_points.obj");
    // Those of curves are named as left out.
    assert_eq!(report.left_out.iter().find(|(why, _)| why.contains("special points")).unwrap().1, &3);
    assert_eq!(scene.curve("spec_trim_special_points").unwrap().domain(), (0.2, 0.9));
    // The area inside the loops of the last, by the corners of its squares in the parameter plane.
    let (scene, _) = read("spec_two_regions_with_holes.obj");
    let Geometry::Trimmed(trimmed) = scene.objects()[0].geometry() else { unreachable!() };
    let area: f64 = trimmed
        .loops()
        .map(|l| {
            let points = l[0].curve().points();
            points.windows(2).map(|p| 0.5 * (p[0].x * p[1].y - p[1].x * p[0].y)).sum::<f64>().abs()
        })
        .sum();
    assert!((area - 2.0 * (0.64 + 0.16)).abs() < 1e-12);
    // As published, all its knots along v are one number.
    let error = try_read("spec_trimmed_nurb_surface.obj", &ReadOptions::default()).unwrap_err();
    assert_eq!(error.place, Place::Line(27), "{error}");
}

#[test]
fn surfaces_that_meet_are_connected() {
    let surface = "surf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n";
    let text = format!(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\ncstype bezier\ndeg 1 1\no a\n{surface}o b\n{surface}\
         vp 0 0\nvp 1 0\ncurv2 -2 -1\nparm u 0 2\nend\ncon 1 0 2 1 2 0.5 1 -1\n"
    );
    let (scene, report) = Obj.read(&Memory::new("con.obj", text.as_str()), &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
    let [connection] = scene.connections() else { unreachable!() };
    assert_eq!((connection.first.object.as_str(), connection.second.object.as_str()), ("a", "b"));
    assert_eq!(connection.second.curve.range(), (0.5, 1.0));
}

#[test]
fn materials_are_slots_of_faces_and_a_missing_library_is_named_with_its_line() {
    let text = "mtllib ./a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no one\nusemtl red\nf 1 2 3\n\
                o two\nf 1 2 3\nusemtl glass\nf 1 3 2\no three\nusemtl glass\nf 1 2 3\nusemtl lost\n";
    let mut file = Memory::new("m.obj", text);
    let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    assert!(
        report.left_out.keys().any(|why| why.contains("line 1") && why.contains("a b.mtl")),
        "{report:?}"
    );
    assert_eq!(scene.materials.iter().map(|m| m.base_color).collect::<Vec<_>>(), [[0.8, 0.8, 0.8, 1.0]; 2]);
    let library =
        "newmtl red\nKd 1 0 0\nnewmtl glass\nd 0.25\nKd 0 0.5 1\nillum x\nKd nonsense\nnewmtl idle\n";
    file.siblings.insert("a b.mtl".into(), library.into());
    let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
    let slots: Vec<_> = scene.objects().iter().map(|o| o.materials.join(" ")).collect();
    assert_eq!(slots, ["red", "red glass", "glass"]);
    let Geometry::Mesh(two) = scene.object("two").unwrap().geometry() else { unreachable!() };
    assert_eq!(two.materials, [0, 1]);
    assert_eq!(scene.materials.get("glass").unwrap().base_color, [0.0, 0.5, 1.0, 0.25]);
    assert!(report.adds_up());
    let left_out: Vec<_> = report.left_out.keys().map(String::as_str).collect();
    assert!(left_out.iter().any(|why| why.contains("a b.mtl, line 7")), "{left_out:?}");
    assert!(left_out.contains(&"materials that nothing in the scene uses"), "{left_out:?}");
    // Several libraries in one statement, and one outside the folder, which is not looked for.
    for (names, found) in [("x.mtl r.mtl", 1), ("../../etc/passwd", 0)] {
        let mut file = Memory::new("m.obj", text.replace("./a b.mtl", names));
        file.siblings.insert("r.mtl".into(), b"newmtl red\nKd 1 0 0\n".to_vec());
        let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
        let red = scene.materials.iter().filter(|m| m.base_color == [1.0, 0.0, 0.0, 1.0]).count();
        assert_eq!((red, report.left_out.len()), (found, 1), "{names}: {report:?}");
    }
    // Faces before the first usemtl have a slot of their own where others follow.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl red\nf 1 2 3\n";
    let (scene, _) = Obj.read(&Memory::new("d.obj", text), &ReadOptions::default()).unwrap();
    assert_eq!(scene.objects()[0].materials, ["default", "red"]);
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

#[test]
fn one_text_in_any_encoding_and_with_any_line_ends_is_one_scene() {
    let text = "# é\no Würfel\nv 0 0 0\nv 1 0 \\\n0\nv\t0 1  0\t\nvt .5 1.\nvn 0 0 +1\ns 1\ng a b\nf 1/1/1 2/1/1 -1//1 \nl 1 \\\n2\n";
    let read = |bytes: Vec<u8>| Obj.read(&Memory::new("t.obj", bytes), &ReadOptions::default()).unwrap().0;
    let plain = read(text.into());
    assert_eq!(plain.objects()[0].name(), "Würfel");
    let wide = |order: fn(u16) -> [u8; 2]| {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(order).collect::<Vec<u8>>()
    };
    for other in [
        format!("\u{feff}{text}").into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        text.replace('\n', "\r").into_bytes(),
        text.replace('\n', " \t\n").into_bytes(),
        text.trim_end().into(),
        wide(u16::to_le_bytes),
        wide(u16::to_be_bytes),
    ] {
        assert_eq!(read(other), plain);
    }
}

/// A file of several parts, in which everything that a part leaves to the next occurs.
#[test]
fn parts_make_no_difference() {
    let mut text = String::new();
    for k in 0..60_000_u32 {
        let z = f64::from(k) / 7.0;
        text += &format!("v {k} {} {z}\nvn 0 0 1\nvt 0.5 {}\n", k % 9, f64::from(k % 11) / 11.0);
        if k % 1000 == 0 {
            text += &format!("g part{}\ns {}\nusemtl m{}\n", k / 5000, k / 1000 % 3, k / 7000);
        }
        if k >= 2 {
            text += "f -1/-1/-1 -2/-2/-2 -3//-3\n";
        }
    }
    let (scene, report) = Obj.read(&Memory::new("long.obj", text.as_str()), &ReadOptions::default()).unwrap();
    assert!(report.adds_up() && text.len() > 4 << 19);
    let m = mesh(&scene);
    assert_eq!((m.points().len(), m.face_count(), m.groups.len()), (60_000, 59_998, 12));
    assert_eq!(scene.objects()[0].materials.len(), 9);
    for f in [0, 12_345, 59_997_usize] {
        let v = f as u32 + 2;
        assert_eq!(m.corners()[3 * f..3 * f + 3], [v, v - 1, v - 2]);
        assert_eq!(m.uvs.at(3 * f + 1, v - 1), Some(&[0.5, f64::from((v - 1) % 11) / 11.0]));
        assert_eq!((m.uvs.at(3 * f + 2, v - 2), m.normals.at(3 * f + 2, v - 2).is_some()), (None, true));
        assert_eq!(m.smoothing[f], v / 1000 % 3);
        assert_eq!(m.materials[f], v / 1000 * 1000 / 7000);
        assert_eq!(m.groups.iter().filter(|g| g.faces.binary_search(&(f as u32)).is_ok()).count(), 1);
    }
    // What is wrong in a late part has its line.
    let lines = text.lines().count();
    text += "v 1 2\n";
    let (_, report) = Obj.read(&Memory::new("long.obj", text), &ReadOptions::default()).unwrap();
    let line = format!("line {}: ", lines + 1);
    assert!(report.left_out.keys().any(|why| why.starts_with(&line)), "{:?}", report.left_out);
}
