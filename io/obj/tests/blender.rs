//! Curves as Blender 4.4, 4.5 and 5.0 write them to OBJ: of every kind of spline, order, closed or not, with end points or not, in Bézier mode or not,
//! what is read, and whether that is the curve that Blender draws. The files and the points drawn are those of `golden/blender_curves.py`, and
//! the rows of the table in the manual (`docs/manual/src/files.md`) are the functions below.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions};
use loftsman_kernel::scene::Geometry;
use loftsman_obj::Obj;
use serde_json::Value;

struct Case {
    kind: String,
    order: usize,
    cyclic: bool,
    endpoint: bool,
    bezier: bool,
    points: usize,
    obj: String,
    drawn: Vec<[f64; 3]>,
}

impl Case {
    fn new(case: &Value) -> Self {
        let flag = |name: &str| case[name].as_bool().unwrap();
        let count = |name: &str| case[name].as_u64().unwrap() as usize;
        let text = |name: &str| case[name].as_str().unwrap().to_owned();
        let drawn = case["drawn"].as_array().unwrap().iter();
        let drawn = drawn.map(|p| std::array::from_fn(|k| p[k].as_f64().unwrap())).collect();
        let (cyclic, endpoint, bezier) = (flag("cyclic"), flag("endpoint"), flag("bezier"));
        Self {
            kind: text("type"),
            order: count("order"),
            cyclic,
            endpoint,
            bezier,
            points: count("points"),
            obj: text("obj"),
            drawn,
        }
    }
}

#[derive(Debug, PartialEq, Clone, Copy)]
enum Read {
    /// A curve that passes where Blender draws.
    Drawn,
    /// A curve that does not: the file has other knots than Blender draws by.
    Other,
    /// Left out with its line.
    LeftOut,
    /// A polyline.
    Segments,
}

/// Blender 4.4: as drawn are curves without end points, not in Bézier mode, and all of order 2; from order 5 on there are too few knots.
fn of_4_4(case: &Case) -> Read {
    match case {
        Case { order: 5.., .. } => Read::LeftOut,
        Case { order: 2, .. } | Case { endpoint: false, bezier: false, .. } => Read::Drawn,
        // One span between end points, with whatever knots.
        Case { order: 4, points: 4, endpoint: true, cyclic: false, .. } => Read::Drawn,
        _ => Read::Other,
    }
}

/// Blender 4.5: closed curves with end points or in Bézier mode have other knots, and some open ones in Bézier mode have; of as many points as the order
/// these have no domain, and with end points they may be torn.
fn of_4_5(case: &Case) -> Read {
    match case {
        Case { order: 2, .. } | Case { endpoint: false, bezier: false, .. } => Read::Drawn,
        Case { cyclic: true, .. } => Read::Other,
        Case { endpoint: false, .. } if case.points == case.order => Read::LeftOut,
        Case { endpoint: false, order, .. } => {
            if order % 2 == 1 {
                Read::Drawn
            } else {
                Read::Other
            }
        }
        Case { bezier: true, order: 5.., points: 7, .. } => Read::LeftOut,
        _ => Read::Drawn,
    }
}

/// Blender 5.0: closed curves in Bézier mode have other knots; open ones without end points of as many points as the order have one point.
fn of_5_0(case: &Case) -> Read {
    match case {
        Case { order: 2, .. } | Case { bezier: false, .. } => Read::Drawn,
        Case { cyclic: true, .. } => Read::Other,
        Case { endpoint: false, .. } if case.points == case.order => Read::LeftOut,
        _ => Read::Drawn,
    }
}

/// A point of the file's B-spline at a share of its range, by Cox and de Boor's recursion: what a curve has to be that is drawn otherwise, too.
/// A range beyond what the knots define ends there; knots too many are not looked at.
fn of_the_file(obj: &str, share: f64) -> Point {
    let text = obj.replace("\\\n", " ");
    let numbers = |line: &str, skip: usize| -> Vec<f64> {
        line.split_whitespace().skip(skip).map(|word| word.parse().unwrap()).collect()
    };
    let of = |word: &'static str| text.lines().filter(move |line| line.split(' ').next() == Some(word));
    let vertices: Vec<Vec<f64>> = of("v").map(|line| numbers(line, 1)).collect();
    let degree = numbers(of("deg").next_back().unwrap(), 1)[0] as usize;
    let curve = numbers(of("curv").next_back().unwrap(), 1);
    let knots = numbers(of("parm").next_back().unwrap(), 2);
    let points: Vec<&Vec<f64>> = curve[2..]
        .iter()
        .map(|k| &vertices[if *k < 0.0 { vertices.len() as f64 + k } else { k - 1.0 } as usize])
        .collect();
    let n = points.len();
    let (a, b) = (curve[0].max(knots[degree]), curve[1].min(knots[n]));
    let t = a + (b - a) * share;
    let span = (degree..n).rev().find(|&k| knots[k] <= t && knots[k] < knots[k + 1]).unwrap();
    let homogeneous = |p: &Vec<f64>| {
        let w = p.get(3).copied().unwrap_or(1.0);
        [p[0] * w, p[1] * w, p[2] * w, w]
    };
    let mut d: Vec<[f64; 4]> = (span - degree..=span).map(|k| homogeneous(points[k])).collect();
    for level in 1..=degree {
        for j in (level..=degree).rev() {
            let (low, high) = (knots[j + span - degree], knots[j + 1 + span - level]);
            let x = (t - low) / (high - low);
            d[j] = std::array::from_fn(|k| (1.0 - x) * d[j - 1][k] + x * d[j][k]);
        }
    }
    let [x, y, z, w] = d[degree];
    Point::new(x / w, y / w, z / w)
}

fn check(golden: &str, version: &str, expected: fn(&Case) -> Read) {
    let golden: Value = serde_json::from_str(golden).unwrap();
    assert!(golden["blender"].as_str().unwrap().starts_with(version));
    let cases: Vec<Case> = golden["cases"].as_array().unwrap().iter().map(Case::new).collect();
    assert_eq!(cases.len(), 4 + 5 * 2 * 2 * 2 * 2);
    for case in &cases {
        let name = format!(
            "{version} {} order {} cyclic {} endpoint {} bezier {} points {}",
            case.kind, case.order, case.cyclic, case.endpoint, case.bezier, case.points
        );
        // A point beside it, so that the file is read whatever becomes of the curve.
        let beside = "v 9 9 9\np -1\n";
        let file = Memory::new("c.obj", format!("{}\n{beside}", case.obj));
        let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
        assert!(report.adds_up(), "{name}");
        let shapes: Vec<&Geometry> = scene.objects().iter().map(|o| o.geometry()).collect();
        let found = match shapes[..] {
            [Geometry::Curve(curve), Geometry::Cloud(_)] | [Geometry::Cloud(_), Geometry::Curve(curve)] => {
                assert_eq!(curve.degree(), if case.order > 0 { case.order - 1 } else { 1 }, "{name}");
                assert!(case.drawn.len() > 1, "{name}");
                if case.kind == "NURBS" {
                    let (a, b) = curve.domain();
                    for share in [0.0, 0.2, 0.5, 0.9] {
                        let (ours, file) =
                            (curve.point(a + (b - a) * share).unwrap(), of_the_file(&case.obj, share));
                        // Knots of six digits that repeat to these are taken to repeat.
                        let within = if curve.is_periodic() { 2e-5 } else { 1e-9 };
                        assert!((ours - file).norm() < within, "{name}: {ours} at {share} is not {file}");
                    }
                    // Closed is what Blender closes, and nothing else.
                    let wraps = case.cyclic && (version == "4.4.0" || !case.bezier && !case.endpoint);
                    assert!(!wraps || curve.is_periodic(), "{name}: wraps around\n{}", case.obj);
                    let (start, end) = (curve.point(a).unwrap(), curve.point(b).unwrap());
                    let is_closed = curve.is_periodic() || (start - end).norm() < 1e-9;
                    // Of one piece in Bézier mode Blender 4.5 and 5.0 write knots that leave it open.
                    let torn =
                        version != "4.4.0" && case.bezier && !case.endpoint && case.points == case.order;
                    assert_eq!(is_closed, case.cyclic && !(torn && case.order > 2), "{name}");
                }
                // Files have six decimals, the points drawn four.
                let off = |p: &[f64; 3]| curve.closest(Point::from(*p)).unwrap().distance;
                let farthest = case.drawn.iter().map(off).fold(0.0, f64::max);
                assert!(!(2e-4..0.05).contains(&farthest), "{name}: {farthest}");
                if farthest < 2e-4 { Read::Drawn } else { Read::Other }
            }
            [Geometry::Polyline(_), Geometry::Cloud(_)] | [Geometry::Cloud(_), Geometry::Polyline(_)] => {
                Read::Segments
            }
            [Geometry::Cloud(_)] => {
                assert!(report.left_out.keys().any(|why| why.starts_with("line ")), "{name}: {report:?}");
                Read::LeftOut
            }
            _ => panic!("{name}: {} objects", shapes.len()),
        };
        let expected = match case.kind.as_str() {
            "POLY" => Read::Drawn,
            "BEZIER" => Read::Segments,
            _ => expected(case),
        };
        assert_eq!(found, expected, "{name}\n{}", case.obj);
    }
}

#[test]
fn curves_of_blender_4_4() {
    check(include_str!("golden/blender-4.4.json"), "4.4.0", of_4_4);
}

#[test]
fn curves_of_blender_4_5() {
    check(include_str!("golden/blender-4.5.json"), "4.5.4", of_4_5);
}

#[test]
fn curves_of_blender_5_0() {
    check(include_str!("golden/blender-5.0.json"), "5.0.1", of_5_0);
}

/// A file of so many hairs as Blender 4.4 writes each: a uniform cubic without end points over the whole range of its knots, its vertices numbered back to
/// front.
fn hair(count: usize) -> (String, Vec<Vec<[f64; 3]>>) {
    use std::fmt::Write;
    let (mut text, mut hairs) = (String::from("# Blender 4.4.0\n# www.blender.org\n"), Vec::new());
    for k in 0..count {
        let points: Vec<[f64; 3]> = (0..5 + k % 4)
            .map(|j| {
                let (turn, up) = (0.7 * k as f64, j as f64);
                [turn.cos() * (1.0 + 0.1 * up), turn.sin() * (1.0 + 0.05 * up * up), 0.3 * up]
            })
            .map(|p| p.map(|x: f64| (x * 1e6).round() / 1e6))
            .collect();
        for [x, y, z] in &points {
            writeln!(text, "v {x:.6} {y:.6} {z:.6}").unwrap();
        }
        let numbers = |list: Vec<String>| list.join(" ");
        let knots = points.len() + 4;
        writeln!(
            text,
            "g hair_{k}\ncstype bspline\ndeg 3\ncurv 0.0 1.0 {}\nparm u {}\nend",
            numbers((1..=points.len()).map(|j| format!("-{j}")).collect()),
            numbers((0..knots).map(|j| format!("{:.6}", j as f64 / (knots - 1) as f64)).collect())
        )
        .unwrap();
        hairs.push(points.into_iter().rev().collect());
    }
    (text, hairs)
}

/// All hairs are read, each with its points, and run where the uniform cubics of their points do.
#[test]
fn a_thousand_hairs_are_read_whole() {
    let read = |count: usize| {
        let (text, hairs) = hair(count);
        let file = Memory::new("hair.obj", text);
        let (scene, report) = Obj.read(&file, &ReadOptions::default()).unwrap();
        assert!(report.adds_up() && report.left_out.is_empty(), "{report:?}");
        assert_eq!(scene.objects().len(), count);
        for (object, points) in scene.objects().iter().zip(&hairs) {
            let Geometry::Curve(curve) = object.geometry() else { panic!("{}", object.name()) };
            let (a, b) = curve.domain();
            let spans = points.len() - 3;
            for span in 0..spans {
                // At the start of each span (1, 4, 1) / 6; in its middle (1, 23, 23, 1) / 48.
                for (x, parts) in [(0.0, [8.0, 32.0, 8.0, 0.0]), (0.5, [1.0, 23.0, 23.0, 1.0])] {
                    let found = curve.point(a + (b - a) * (span as f64 + x) / spans as f64).unwrap();
                    for axis in 0..3 {
                        let wanted: f64 = (0..4).map(|j| parts[j] * points[span + j][axis] / 48.0).sum();
                        assert!((found[axis] - wanted).abs() < 2e-5, "{} {span}", object.name());
                    }
                }
            }
        }
    };
    read(1000);
    read(4000);
}
