//! One odd entity never costs the file: it is left out with its line, and everything else is read.

#![allow(clippy::unwrap_used, reason = "a test may stop at what should not be")]

use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_obj::Obj;

fn read(text: &str) -> (Scene, ReadReport) {
    let (scene, report) = Obj.read(&Memory::new("t.obj", text), &ReadOptions::default()).unwrap();
    assert!(report.adds_up(), "{report:?}");
    assert!(scene.check().is_ok());
    (scene, report)
}

/// The lines of the report that name a line of the file.
fn wrong(report: &ReadReport) -> Vec<&str> {
    report.left_out.keys().filter(|why| why.starts_with("line ")).map(String::as_str).collect()
}

/// A mesh, a line, a point, a curve and a trimmed surface.
const SOUND: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nvp 0.2 0.2\nvp 0.8 0.2\nvp 0.5 0.8\n\
    o mesh\nf 1 2 3\nf 1/1/1 3/1/1 4/1/1\no line\nl 1 2 4\no dot\np 3\n\
    o curve\ncstype bspline\ndeg 1\ncurv 0 1 1 2\nparm u 0 0 1 1\nend\n\
    cstype bspline\ndeg 1\ncurv2 1 2 3 1\nparm u 0 0 1 2 3 3\nend\n\
    o sheet\ncstype bspline\ndeg 1 1\nsurf 0 1 0 1 1 2 4 3\nparm u 0 0 1 1\nparm v 0 0 1 1\ntrim 0 3 1\nend\n";

fn summary(scene: &Scene) -> Vec<String> {
    let of = |o: &loftsman_kernel::scene::Object| match o.geometry() {
        Geometry::Mesh(mesh) => format!("{} {} {}", o.name(), mesh.points().len(), mesh.face_count()),
        other => format!("{} {} {}", o.name(), other.kind(), other.points().len()),
    };
    scene.objects().iter().map(of).collect()
}

#[test]
fn a_wrong_statement_anywhere_is_left_out_with_its_line_and_the_rest_is_read() {
    let (sound, report) = read(SOUND);
    assert_eq!(
        summary(&sound),
        ["mesh 4 2", "line polyline 3", "dot cloud 1", "curve curve 2", "sheet trimmed 4"]
    );
    assert!(wrong(&report).is_empty());
    let odd = [
        "f 1 2",
        "f",
        "f 1 2 99",
        "f 1 2 x",
        "f 1/9 2/9 3/9",
        "f 1//7 2//7 3//7",
        "f 1/1/1/1 2 3",
        "l 1",
        "l 1 0",
        "p",
        "p 77",
        "s seven",
        "cstype nurbs\ncstype bspline",
        "deg 99\ndeg 1",
        "bmat w 1",
        "step 0",
        "end",
        "parm u 0 1",
        "con 1 2",
        "\u{7}\u{8}",
        "vp",
        "curv 0 1 1 2\nparm u 0 0 1 1\nparm u x\nparm v 0 0\nend",
        "curv 0 1 1 2\nparm u 0 0 1\nend",
        "curv 0 1 1 99\nparm u 0 0 1 1\nend",
        "curv 0 1 1 2",
        "surf 0 1 0 1 1 2 3\nparm u 0 0 1 1\nparm v 0 0 1 1\nend",
    ];
    let lines: Vec<&str> = SOUND.lines().collect();
    let mut tried = 0;
    for odd in odd {
        // Behind every line but within the body of an element, which it would be part of.
        for at in [9, 11, 12, 14, 16] {
            let mut text = lines[..at].join("\n") + "\n";
            text += odd;
            text += "\n";
            text += &lines[at..].join("\n");
            let (scene, report) = read(&text);
            assert_eq!(summary(&scene), summary(&sound), "{odd:?} behind line {at}");
            let named = wrong(&report);
            assert!(!named.is_empty(), "{odd:?}: {report:?}");
            let first =
                named.iter().filter_map(|why| why[5..].split(':').next()?.parse::<usize>().ok()).min();
            let count = odd.lines().count();
            assert!(first.is_some_and(|line| line > at && line <= at + count), "{odd:?}: {named:?}");
            tried += 1;
        }
    }
    assert!(tried >= 100, "{tried}");
}

#[test]
fn numbers_of_elements_that_are_left_out_stay_theirs() {
    // The first plane curve and the first surface are wrong: the second ones keep their numbers.
    let bad = "cstype bspline\ndeg 1\ncurv2 1 2\nparm u 0 0 1\nend\ncurv2 1 99\nparm u 0 0 1 1\nend\n\
        surf 0 1 0 1 1 2 4 3\nparm u 0 0 1\nparm v 0 0 1 1\nend\ncurv 0 1 1 2\n";
    let (text, tail) = SOUND.split_once("cstype bspline\ndeg 1\ncurv2").unwrap();
    let text = format!("{text}{bad}cstype bspline\ndeg 1\ncurv2{}", tail.replace("trim 0 3 1", "trim 0 3 3"));
    let (scene, report) = read(&text);
    assert_eq!(summary(&scene).last().unwrap(), "sheet trimmed 4");
    assert_eq!(wrong(&report).len(), 4, "{report:?}");
}

#[test]
fn what_uses_a_vertex_that_is_wrong_goes_with_it() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 nan 0\nv 0 1 0\nv 1 1 1\nvt 0 0\nvt x\nvn 0 0 1\nvn 1 2\ng a\nf 1 2 3\ng b\ns 2\n\
        f 1/1/1 2/2/2 4/1/1\ng a\nf 3 4 5\nl 1 2 3 4 5\np 3 5\n";
    let (scene, report) = read(text);
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!() };
    assert_eq!((mesh.face_count(), mesh.lines().count(), mesh.groups.len()), (1, 2, 1));
    assert_eq!((mesh.smoothing.as_slice(), mesh.groups[0].faces.as_slice()), (&[2][..], &[0][..]));
    let [a, b, c] = [0, 1, 2].map(|corner| (corner, mesh.corners()[corner]));
    assert!(mesh.uvs.at(a.0, a.1).is_some() && mesh.uvs.at(b.0, b.1).is_none());
    // The normal that is wrong does not cost the others theirs.
    assert!(mesh.normals.at(a.0, a.1).is_some() && mesh.normals.at(b.0, b.1).is_none());
    assert!(mesh.normals.at(c.0, c.1).is_some());
    assert_eq!(scene.objects()[1].geometry().points().len(), 1);
    let named = wrong(&report);
    assert!(named.iter().any(|why| why.starts_with("line 3: ") && why.contains("NaN")), "{named:?}");
    assert_eq!(
        (named.len(), report.left_out["faces with a vertex that is wrong itself (line 11 and 1 more)"]),
        (3, 2)
    );
    let curve = "o c\ncstype bspline\ndeg 1\ncurv 0 1 1 3\nparm u 0 0 1 1\nend\n";
    let (scene, report) = read(&format!("{text}{curve}"));
    assert!(scene.objects().iter().all(|o| o.name() != "c"));
    assert!(wrong(&report).iter().any(|why| why.starts_with("line 22: ")), "{report:?}");
}

#[test]
fn a_colour_that_is_none_costs_the_colour() {
    for (colour, line) in [("nan 0 0", 2), ("1 2 3e400", 2), ("1 1 0x 1", 2), ("1 4e200 0", 2)] {
        let text = format!("v 0 0 0 1 0 0\nv 1 0 0 {colour}\nv 0 1 0 0 0 1\nf 1 2 3\n");
        let (scene, report) = read(&text);
        let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!() };
        let colors = [0, 1, 2].map(|k| mesh.colors.at(k, k as u32).is_some());
        assert_eq!((mesh.face_count(), colors), (1, [true, false, true]), "{colour}");
        assert!(
            wrong(&report)[0].starts_with(&format!("line {line}: the vertex has no colour")),
            "{report:?}"
        );
    }
}

#[test]
fn zero_normals_do_not_cost_the_others_theirs() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 0\nvn 0 1 0\nf 1//1 2//2 3//3\n";
    let (scene, _) = read(text);
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!() };
    assert_eq!([0, 1, 2].map(|k| mesh.normals.at(k, k as u32).is_some()), [true, false, true]);
}

/// Normals of no length and of another one are told with the line of the first, and those that are wrong themselves once.
#[test]
fn odd_normals_are_told_once_with_their_line() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 9 9 9\nvn 0 0 1\nvn 0 0 0 # none\nvn \\\n0 0 2\nvn 1e300 0 1e300\nvn 0 nan 0\nvn 0 0 0\n\
        vn 0 1e-300 0\nf 1//2 2//3 3//4\nf 1//5 2//6 3//7\nf 1//8 3//8 2//2\n";
    let (scene, report) = read(text);
    let Geometry::Mesh(mesh) = scene.objects()[0].geometry() else { unreachable!() };
    let normals: Vec<Option<[f64; 3]>> = (mesh.corners().iter().enumerate())
        .map(|(corner, &point)| mesh.normals.at(corner, point).map(|n| [n.x, n.y, n.z]))
        .collect();
    let half = 0.5_f64.sqrt();
    let (z, y) = (Some([0.0, 0.0, 1.0]), Some([0.0, 1.0, 0.0]));
    for (found, expected) in normals.iter().zip([z, None, z, Some([half, 0.0, half]), None, None, y, y, z]) {
        assert_eq!(found.is_some(), expected.is_some(), "{normals:?}");
        let apart = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-15, "{normals:?}");
    }
    let left: Vec<&str> = report.left_out.keys().map(String::as_str).collect();
    assert_eq!(report.left_out.values().sum::<usize>(), 4, "{left:?}");
    assert!(left.contains(&"normals of length 0 (line 6 and 1 more)"), "{left:?}");
    assert!(left.contains(&"normals that nothing in the scene uses"), "{left:?}");
    assert_eq!(left.iter().filter(|why| why.contains("NaN")).count(), 1, "{left:?}");
    let read: Vec<&str> = report.approximated.keys().map(String::as_str).collect();
    assert_eq!(read, ["normals that were not of length 1 (line 7 and 2 more)"]);
}

/// Names that differ in bytes that are no UTF-8 stay apart, in the file and in its library, and how they were read is said once.
#[test]
fn names_older_than_utf_8_stay_apart_and_are_said() {
    let file = |umlauts: [&[u8]; 2]| -> Vec<u8> {
        let [a, u] = umlauts;
        [
            b"mtllib f",
            u,
            b".mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\no M",
            u,
            b"ll\nusemtl f",
            a,
            b"\nf 1 2 3\no M",
            a,
            b"ll\nusemtl f",
            u,
            b"\nf 2 4 3\n",
        ]
        .concat()
    };
    let library = |[a, u]: [&[u8]; 2]| -> Vec<u8> {
        [b"newmtl f", a, b"\nKd 1 0 0\nmap_Kd M", u, b"ll.png\nnewmtl f", u, b"\nKd 0 1 0\n"].concat()
    };
    let windows: [&[u8]; 2] = [b"\xe4", b"\xfc"];
    let dos: [&[u8]; 2] = [b"\x84", b"\x81"];
    let new = ["ä".as_bytes(), "ü".as_bytes()];
    for (own, other, said) in [
        (windows, windows, &["t.obj, fü.mtl are not UTF-8: they were read as Windows-1252"][..]),
        (dos, dos, &["t.obj, fü.mtl are not UTF-8: they were read as code page 437"]),
        (windows, new, &["t.obj is not UTF-8: it was read as Windows-1252"]),
        (new, dos, &["fü.mtl is not UTF-8: it was read as code page 437"]),
        (new, new, &[]),
    ] {
        let mut source = Memory::new("t.obj", file(own));
        source.siblings.insert("fü.mtl".to_owned(), library(other));
        let (scene, report) = Obj.read(&source, &ReadOptions::default()).unwrap();
        assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
        let found: Vec<(&str, &str)> =
            scene.objects().iter().map(|o| (o.name(), o.materials[0].as_str())).collect();
        assert_eq!(found, [("Müll", "fä"), ("Mäll", "fü")]);
        let colors: Vec<[f64; 4]> = scene.materials.iter().map(|m| m.base_color).collect();
        assert_eq!(colors, [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
        assert!(scene.images.get("Müll.png").is_some());
        let notes: Vec<&String> = report.notes.iter().filter(|note| note.contains("UTF-8")).collect();
        assert_eq!(notes, said);
    }
}

#[test]
fn loops_that_run_backwards_are_turned_round() {
    let (forward, _) = read(SOUND);
    let (backward, report) = read(&SOUND.replace("trim 0 3 1", "trim 3 0 1"));
    let loops = |scene: &Scene| {
        let Geometry::Trimmed(trimmed) = scene.object("sheet").unwrap().geometry() else { unreachable!() };
        trimmed.regions()[0].outer.clone()
    };
    let ([ahead], [back]) = (&loops(&forward)[..], &loops(&backward)[..]) else { unreachable!() };
    assert_eq!((ahead.range(), back.range()), ((0.0, 3.0), (0.0, 3.0)));
    for k in 0..=30 {
        let t = f64::from(k) / 10.0;
        let apart = ahead.curve().point(t).unwrap() - back.curve().point(3.0 - t).unwrap();
        assert!(apart.norm() < 1e-15, "{t}");
    }
    assert!(report.approximated.keys().any(|why| why.contains("turned round")), "{report:?}");
    // A part of the curve, and a hole.
    let hole = SOUND.replace("trim 0 3 1", "hole 3 0 1");
    let (scene, _) = read(&hole);
    let Geometry::Trimmed(trimmed) = scene.object("sheet").unwrap().geometry() else { unreachable!() };
    assert_eq!(trimmed.regions()[0].holes.len(), 1);
}

#[test]
fn many_wrong_statements_are_counted_and_the_first_named() {
    let text = format!("{SOUND}{}", "f 1 2\n".repeat(100_000));
    let (scene, report) = read(&text);
    assert_eq!(scene.objects().len(), 5);
    assert_eq!(report.left_out.values().sum::<usize>(), 100_000);
    assert!(report.left_out.len() < 40 && wrong(&report).len() == 16, "{report:?}");
}
