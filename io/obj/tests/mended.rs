//! Curves of which an exporter wrote the range or the knots wrong, as Blender 4.4 does: read, and said.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::fmt::Write as _;

use loftsman_kernel::plugin::{Format, Memory, ReadOptions, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Curve;
use loftsman_obj::Obj;

/// A curve that is not clamped, whose range is that of all its knots.
const BEYOND: &str = "v 0 0 0\nv 1 2 0\nv 3 1 0\nv 4 0 0\nv 5 2 0\ncstype bspline\ndeg 3\n\
    curv 0.0 1.0 1 2 3 4 5\nparm u 0.0 0.125 0.25 0.375 0.5 0.625 0.75 0.875 1.0\nend\n";

/// A curve of order 2 with a parm too many.
const EXTRA: &str = "v 0 0 0\nv 1 2 0\nv 3 1 0\nv 4 0 0\ncstype bspline\ndeg 1\n\
    curv 0.0 1.0 1 2 3 4\nparm u 0.0 0.0 0.25 0.5 0.75 1.0 1.0\nend\n";

fn read(text: &str) -> Result<(Scene, ReadReport), String> {
    let read = Obj.read(&Memory::new("a.obj", text), &ReadOptions::default()).map_err(|e| e.to_string());
    read.inspect(|(_, report)| assert!(report.adds_up(), "{report:?}"))
}

fn curve(text: &str) -> (Curve, Vec<String>) {
    let (scene, report) = read(text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let [object] = scene.objects() else { panic!("one object: {text}") };
    let Geometry::Curve(curve) = object.geometry() else { panic!("a curve: {text}") };
    (curve.clone(), report.approximated.into_keys().collect())
}

/// A point by de Boor's algorithm as the textbooks have it.
fn de_boor(p: usize, t: &[f64], points: &[[f64; 3]], u: f64) -> [f64; 3] {
    let n = points.len();
    let k = (p..n).rev().find(|&k| t[k] <= u && t[k] < t[k + 1]).unwrap();
    let mut d: Vec<[f64; 3]> = points[k - p..=k].to_vec();
    for r in 1..=p {
        for j in (r..=p).rev() {
            let i = j + k - p;
            let share = (u - t[i]) / (t[i + p - r + 1] - t[i]);
            d[j] = [0, 1, 2].map(|c| (1.0 - share) * d[j - 1][c] + share * d[j][c]);
        }
    }
    d[p]
}

#[test]
fn a_range_beyond_the_domain_of_floating_knots_is_clipped_and_said() {
    let (curve, said) = curve(BEYOND);
    assert_eq!((curve.points().len(), curve.domain()), (5, (0.375, 0.625)));
    let [reason] = &said[..] else { panic!("{said:?}") };
    assert!(reason.contains("clipped"), "{reason}");
}

#[test]
fn an_extra_knot_is_dropped_and_said() {
    let (curve, said) = curve(EXTRA);
    assert_eq!((curve.degree(), curve.points().len(), curve.domain()), (1, 4, (0.0, 0.75)));
    let corners: Vec<[f64; 3]> = [0.0, 0.25, 0.5, 0.75].map(|u| curve.point(u).unwrap().into()).to_vec();
    assert_eq!(corners, [[0.0; 3], [1.0, 2.0, 0.0], [3.0, 1.0, 0.0], [4.0, 0.0, 0.0]]);
    let [reason] = &said[..] else { panic!("{said:?}") };
    assert!(reason.contains("dropped") && reason.contains("clipped"), "{reason}");
}

/// An element of evenly spaced knots over `[0, 1]`, `extra` more than needed, run from `from` to `to`.
fn element(p: usize, n: usize, extra: usize, range: [f64; 2]) -> (String, Vec<f64>, Vec<[f64; 3]>) {
    let points: Vec<[f64; 3]> = (0..n).map(|i| [i as f64, (i * i % 7) as f64, (3 * i % 5) as f64]).collect();
    let count = n + p + 1;
    let knots: Vec<f64> = (0..count + extra).map(|k| k as f64 / (count - 1) as f64).collect();
    let mut text = String::new();
    points.iter().for_each(|[x, y, z]| _ = writeln!(text, "v {x} {y} {z}"));
    let _ = write!(text, "cstype bspline\ndeg {p}\ncurv {} {}", range[0], range[1]);
    (1..=n).for_each(|i| _ = write!(text, " {i}"));
    text.push_str("\nparm u");
    knots.iter().for_each(|t| _ = write!(text, " {t}"));
    text.push_str("\nend\n");
    (text, knots, points)
}

#[test]
fn such_curves_of_every_degree_are_what_their_knots_say() {
    let mut members = 0;
    for p in [1, 2, 3, 4, 5, 6, 7, 25] {
        for n in [p + 1, p + 2, p + 9] {
            for extra in [0, 1, 2] {
                // The range of all knots of the file, also of those too many: so Blender 4.4 writes it.
                let all = (n + p + extra) as f64 / (n + p) as f64;
                for range in [[0.0, 1.0], [0.0, 0.5], [0.5, 1.0], [0.0, all]] {
                    let (text, knots, points) = element(p, n, extra, range);
                    let domain = [knots[p], knots[n]];
                    let part = [range[0].max(domain[0]), range[1].min(domain[1])];
                    let (curve, said) = curve(&text);
                    let (a, b) = curve.domain();
                    assert!((a - part[0]).abs() < 1e-12 && (b - part[1]).abs() < 1e-12, "{text}");
                    for s in 0..=20 {
                        let u = a + (b - a) * f64::from(s) / 20.0 * (1.0 - 1e-12);
                        let expected = de_boor(p, &knots, &points, u);
                        let found: [f64; 3] = curve.point(u).unwrap().into();
                        let apart =
                            found.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
                        assert!(apart < 1e-9 * n as f64, "{u}: {found:?} {expected:?}: {text}");
                    }
                    let said = said.join("");
                    assert_eq!(said.contains("clipped"), part != range, "{said}: {text}");
                    assert_eq!(said.contains("dropped"), extra > 0, "{said}: {text}");
                    members += 1;
                }
            }
        }
    }
    assert!(members >= 100, "{members}");
}

/// Ranges that pass the end of all knots, or of clamped ones, or are rounded otherwise than these.
#[test]
fn what_a_range_has_beyond_all_knots_is_clipped_and_said() {
    const CLAMPED: &str = "parm u 0 0 0 0 0.5 0.75 0.75 0.75 0.75";
    let clamped = BEYOND.replace("parm u 0.0 0.125 0.25 0.375 0.5 0.625 0.75 0.875 1.0", CLAMPED);
    let even = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
    let ends = [0.0, 0.0, 0.0, 0.0, 0.5, 0.75, 0.75, 0.75, 0.75];
    let points = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [3.0, 1.0, 0.0], [4.0, 0.0, 0.0], [5.0, 2.0, 0.0]];
    for (text, range, knots, domain) in [
        (BEYOND, "0.5 2.0", even, (0.5, 0.625)),
        (BEYOND, "-1 2.0", even, (0.375, 0.625)),
        (BEYOND, "0.5 1.001", even, (0.5, 0.625)),
        (BEYOND, "-5 0.5", even, (0.375, 0.5)),
        (BEYOND, "-1e300 1e300", even, (0.375, 0.625)),
        (BEYOND, "0.374999 0.625001", even, (0.375, 0.625)),
        (&clamped, "-0.5 1.5", ends, (0.0, 0.75)),
        (&clamped, "0 0.750000003", ends, (0.0, 0.75)),
        (&clamped, "0.25 0.7500001", ends, (0.25, 0.75)),
    ] {
        let text = text.replace("curv 0.0 1.0", &format!("curv {range}"));
        let (curve, said) = curve(&text);
        assert_eq!(curve.domain(), domain, "{text}");
        for k in 0..=20 {
            let u = (domain.0 + (domain.1 - domain.0) * f64::from(k) / 20.0 * (1.0 - 1e-12)).max(domain.0);
            let expected = de_boor(3, &knots, &points, u);
            let found: [f64; 3] = curve.point(u).unwrap().into();
            assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-11), "{u}: {text}");
        }
        let [reason] = &said[..] else { panic!("{said:?}: {text}") };
        assert!(reason.contains("a curve") && reason.contains("clipped to that (line 8)"), "{reason}");
    }
}

/// A bicubic surface of 4 × 4 vertices with even knots, as [`element`] has them, run over these ranges.
fn patch(ranges: &str) -> String {
    let mut text = String::new();
    (0..16).for_each(|k| _ = writeln!(text, "v {} {} {}", k % 4, k / 4, (k * k) % 5));
    let knots: String = (0..8).map(|k| format!(" {}", f64::from(k) / 8.0)).collect();
    let all: String = (1..=16).map(|k| format!(" {k}")).collect();
    format!("{text}cstype bspline\ndeg 3 3\nsurf {ranges}{all}\nparm u{knots}\nparm v{knots}\nend\n")
}

#[test]
fn ranges_of_surfaces_are_clipped_and_said() {
    let knots: Vec<f64> = (0..8).map(|k| f64::from(k) / 8.0).collect();
    for (ranges, domain, clipped) in [
        ("0 1 0 1", [0.375, 0.5, 0.375, 0.5], true),
        ("0 0.45 0.375 0.5", [0.375, 0.45, 0.375, 0.5], true),
        ("0.375 0.5 0.4 7", [0.375, 0.5, 0.4, 0.5], true),
        ("0.375 0.5000001 0.375 0.5", [0.375, 0.5, 0.375, 0.5], true),
        ("0.375 0.5 0.375 0.5", [0.375, 0.5, 0.375, 0.5], false),
    ] {
        let (scene, report) = read(&patch(ranges)).unwrap_or_else(|e| panic!("{ranges}: {e}"));
        let Geometry::Surface(surface) = scene.objects()[0].geometry() else { panic!("{ranges}") };
        let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
        assert_eq!([a, b, c, d], domain, "{ranges}");
        let said: Vec<String> = report.approximated.into_keys().collect();
        assert_eq!(said.len(), usize::from(clipped), "{ranges}: {said:?}");
        assert!(said.iter().all(|why| why.contains("a surface") && why.contains("(line 19)")), "{said:?}");
        for k in 0..=10 {
            let share = f64::from(k) / 10.0 * (1.0 - 1e-12);
            let (u, v) = (a + (b - a) * share, d - (d - c) * (share + 1e-12));
            let rows: Vec<[f64; 3]> = (0..4_u32)
                .map(|j| {
                    let row: Vec<_> =
                        (4 * j..4 * j + 4).map(|k| [k % 4, k / 4, (k * k) % 5].map(f64::from)).collect();
                    de_boor(3, &knots, &row, u)
                })
                .collect();
            let expected = de_boor(3, &knots, &rows, v);
            let found: [f64; 3] = surface.point(u, v).unwrap().into();
            assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-11), "{u} {v}: {ranges}");
        }
    }
    for (ranges, words) in [
        ("1 2 0.375 0.5", "in u it runs from 1 to 2, but its knots define it from 0.375 to 0.5"),
        ("0.375 0.5 0.5 0.375", "in v it runs backwards, from 0.5 to 0.375"),
    ] {
        let error = read(&patch(ranges)).map(|_| ()).unwrap_err();
        assert!(error.contains(words) && error.contains("line 19"), "{error}");
    }
}

/// What overlaps the domain by rounding, in one point or not at all is nothing.
#[test]
fn ranges_beyond_the_domain_and_backward_ones_are_left_out() {
    for (range, words) in [
        ("0.6 0.4", "it runs backwards, from 0.6 to 0.4: the smaller parameter comes first"),
        ("1.0 0.0", "it runs backwards, from 1 to 0"),
        ("5 6", "it runs from 5 to 6, but its knots define it from 0.375 to 0.625"),
        ("0.625 1", "it runs from 0.625 to 1, but its"),
        ("0.62499999999 1", "it runs from 0.62499999999 to 1, but its"),
        ("0 0.375", "it runs from 0 to 0.375, but its"),
        ("0.5 0.5", "it runs from 0.5 to 0.5, but its"),
    ] {
        let text = BEYOND.replace("curv 0.0 1.0", &format!("curv {range}"));
        let error = read(&text).map(|_| ()).unwrap_err();
        assert!(error.contains(words) && error.contains("line 8"), "{error}");
        let (scene, report) = read(&format!("{text}p 1\n")).unwrap();
        assert_eq!(scene.objects().len(), 1);
        assert!(
            report.left_out.keys().any(|why| why.contains(words) && why.contains("line 8")),
            "{report:?}"
        );
    }
}

#[test]
fn anything_more_is_still_refused() {
    // Three too many; one too few; a range outside of the domain.
    let (three, ..) = element(3, 6, 3, [0.0, 1.0]);
    let few = EXTRA.replace(" 0.75 1.0 1.0", " 1.0");
    let out = BEYOND.replace("curv 0.0 1.0", "curv 0.0 0.25");
    for (text, words) in [(three, "parm"), (few, "parm"), (out, "knots")] {
        let error = read(&text).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{error}: {text}");
    }
}

/// A closed curve of order 2 and one of order 3 without end points, as Blender 4.4.0 wrote them; and what it drew of the
/// second, from its other end, evenly in the parameter (every third of its 24 points, and the last).
const BLENDER: [&str; 2] = [
    "# Blender 4.4.0\nv 0.000000 0.000000 0.000000\nv 1.000000 3.000000 -1.000000\nv 2.000000 1.000000 -4.000000\ng c\n\
     cstype bspline\ndeg 1\ncurv 0.0 1.0 -1 -2 -3 -1\n\
     parm u 0.0 0.142857 0.285714 0.428571 0.571429 0.714286 0.857143 1.0\nend\n",
    "# Blender 4.4.0\nv 0.000000 0.000000 0.000000\nv 1.000000 3.000000 -1.000000\nv 2.000000 1.000000 -4.000000\n\
     v 3.000000 4.000000 -2.000000\ng c\ncstype bspline\ndeg 2\ncurv 0.0 1.0 -1 -2 -3 -4\n\
     parm u 0.0 0.142857 0.285714 0.428571 0.571429 0.714286 0.857143 1.0\nend\n",
];

const DRAWN: [[f64; 3]; 9] = [
    [0.5, 1.5, -0.5],
    [0.760_87, 2.112_476, -0.828_922],
    [1.021_739, 2.384_688, -1.293_951],
    [1.282_609, 2.316_635, -1.895_085],
    [1.543_478, 1.917_77, -2.625_709],
    [1.804_348, 1.622_873, -3.181_475],
    [2.065_217, 1.668_242, -3.396_976],
    [2.326_087, 2.053_875, -3.272_212],
    [2.5, 2.5, -3.0],
];

#[test]
fn curves_of_blender_4_4_are_what_it_draws() {
    let (polygon, said) = curve(BLENDER[0]);
    let (a, b) = polygon.domain();
    for (k, corner) in [[2.0, 1.0, -4.0], [1.0, 3.0, -1.0], [0.0; 3], [2.0, 1.0, -4.0]].iter().enumerate() {
        let found = polygon.point((a + (b - a) * k as f64 / 3.0).min(b)).unwrap();
        let apart = found.iter().zip(corner).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-4, "{k}: {found}");
    }
    assert!(said.join("").contains("dropped") && said.join("").contains("clipped"), "{said:?}");

    let (smooth, said) = curve(BLENDER[1]);
    let (a, b) = smooth.domain();
    for (k, point) in [0, 3, 6, 9, 12, 15, 18, 21, 23].into_iter().zip(DRAWN) {
        let found = smooth.point(b - (b - a) * f64::from(k) / 23.0).unwrap();
        let apart = found.iter().zip(point).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-4, "{k}: {found} {point:?}");
    }
    assert!(said.join("").contains("dropped") && said.join("").contains("clipped"), "{said:?}");
}

/// A closed B-spline as Blender 4.4 writes it: even knots from 0 to 1 of so many decimals, one of them moved, the first `p` vertices again behind
/// the `n` of them.
fn closed(p: usize, n: usize, decimals: usize, moved: f64) -> String {
    let mut text = String::new();
    for i in 0..n {
        let (sin, cos) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
        writeln!(text, "v {cos:.6} {sin:.6} 0").unwrap();
    }
    let count = n + 2 * p + 1;
    let knot = |k: usize| k as f64 / (count - 1) as f64 + if k == p + 2 { moved } else { 0.0 };
    let numbers = |list: Vec<String>| list.join(" ");
    let vertices = numbers((0..n + p).map(|i| (i % n + 1).to_string()).collect());
    let knots = numbers((0..count).map(|k| format!("{:.decimals$}", knot(k))).collect());
    let (from, to) = (knot(p), knot(n + p));
    writeln!(
        text,
        "cstype bspline\ndeg {p}\ncurv {from:.decimals$} {to:.decimals$} {vertices}\nparm u {knots}\nend"
    )
    .unwrap();
    text
}

/// Knots that repeat after a period as far as their digits tell close a curve; those that do not, by their digits, do not.
#[test]
fn knots_of_few_digits_close_a_curve_and_others_do_not() {
    for p in 1..=5 {
        for n in [7, 11, 23] {
            let (rounded, said) = curve(&closed(p, n, 6, 0.0));
            assert!(rounded.is_periodic() && said.is_empty(), "{p} {n}: {said:?}");
            let (exact, _) = curve(&closed(p, n, 17, 0.0));
            assert!(exact.is_periodic(), "{p} {n}");
            for k in 0..100 {
                let at = |curve: &Curve| {
                    let (a, b) = curve.domain();
                    curve.point(a + (b - a) * f64::from(k) / 100.0).unwrap()
                };
                assert!((at(&rounded) - at(&exact)).norm() < 1e-5, "{p} {n} at {k}");
            }
            // All digits are there to say that one is elsewhere.
            let (open, _) = curve(&closed(p, n, 12, 1e-6));
            assert!(!open.is_periodic() || p == 1, "{p} {n}");
            let (open, _) = curve(&closed(p, n, 6, 1e-4));
            assert!(!open.is_periodic() || p == 1, "{p} {n}");
        }
    }
    // The vertices do not come round.
    let (open, _) = curve(&closed(3, 9, 6, 0.0).replace("1 2 3\nparm", "1 2 4\nparm"));
    assert!(!open.is_periodic());
}

/// The group of a curve is its name where `o` has named what stands before it: lines, points or faces.
#[test]
fn curves_behind_an_object_have_the_names_of_their_groups() {
    let points: String = (0..4).map(|i| format!("v {i} {} 0\n", i * i)).collect();
    let curve = |name: &str| {
        format!("g {name}\ncstype bspline\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 0 0 0 1 1 1 1\nend\n")
    };
    for element in ["l 1 2", "p 3", "f 1 2 3", "g first\nl 1 2", "g first\np 1"] {
        let text = format!("{points}o rail\n{element}\n{}{}", curve("hair"), curve("beard"));
        let (scene, report) = read(&text).unwrap();
        let names: Vec<&str> = scene.objects().iter().map(|o| o.name()).collect();
        assert_eq!(names, ["rail", "hair", "beard"], "{element}");
        assert!(report.left_out.keys().all(|why| !why.contains("groups of curves")), "{report:?}");
    }
    // A group that the lines are in names them, and no curve.
    let (scene, _) = read(&format!("{points}o rail\ng all\nl 1 2\n{}", curve("all"))).unwrap();
    assert_eq!(scene.objects()[1].label(), "rail");
}

/// What is counted is found: by the line of the first.
#[test]
fn what_is_counted_is_told_with_the_line_of_the_first() {
    let text = format!("bogus 1\n{BEYOND}bogus 2\nodd\nbogus\n{BEYOND}csh x\n");
    let (_, report) = read(&text).unwrap();
    let told: Vec<&String> = report.left_out.keys().chain(report.approximated.keys()).collect();
    let has = |wanted: &str| assert!(told.iter().any(|why| why.contains(wanted)), "{wanted}: {told:?}");
    has("unknown statement \"bogus\" (line 1 and 2 more)");
    has("unknown statement \"odd\" (line 13)");
    has("its range was clipped to that (line 9 and 1 more)");
    has("calls of other files are not read (line 25)");
    let (_, report) = read("o nothing\nv 0 0 0\nv 1 0 0\ng unused\ng\no line\nl 1 2\n").unwrap();
    let told: Vec<&String> = report.left_out.keys().collect();
    assert_eq!(
        told,
        [
            "groups (g) that have no elements (line 4)",
            "names of objects (o, or g) that have no elements (line 1)"
        ]
    );
}
