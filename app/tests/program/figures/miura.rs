//! Those of Miura, Cheng and Wang.

use super::*;

fn figure(number: usize) -> Figure {
    Figure::of("miura", number)
}

fn ends(curve: &Curve) -> [Point; 2] {
    let (a, b) = curve.domain();
    [point(curve, a), point(curve, b)]
}

fn curvature(curve: &Curve, u: f64) -> f64 {
    let (first, second) = (curve.derivative(u, 1).unwrap(), curve.derivative(u, 2).unwrap());
    first.cross(&second).norm() / first.norm().powi(3)
}

/// How many times as long the derivative is, and how many times as large the curvature, before and after.
fn factors(figure: &Figure, name: &str) -> Vec<[f64; 2]> {
    let [before, after] = figure.curves(name);
    let at = (0..50).map(|i| 0.05 + 0.1 * f64::from(i)).filter(|u| curvature(before, *u) > 1e-3);
    let length = |c: &Curve, u: f64| c.derivative(u, 1).unwrap().norm();
    at.map(|u| [length(after, u) / length(before, u), curvature(after, u) / curvature(before, u)]).collect()
}

fn near(a: Point, b: Point) -> bool {
    (a - b).norm() < 1e-12
}

/// A form whose stem is tuned: its foot where it was, and longer by what the springs leave of 1.7.
#[test]
fn figure_1_a_form_becomes_another() {
    let figure = figure(1);
    let [a, b] = ["a", "b"].map(|name| match figure.after.object(name).unwrap().geometry() {
        Geometry::Mesh(mesh) => mesh.clone(),
        other => panic!("{other:?}"),
    });
    let height = |mesh: &Mesh| {
        let z = || mesh.points().iter().map(|p| p.z);
        [z().fold(f64::MAX, f64::min), z().fold(f64::MIN, f64::max)]
    };
    assert!(!a.normals.is_empty() && !b.normals.is_empty());
    let [[low, high], [other_low, other_high]] = [height(&a), height(&b)];
    assert!((low - other_low).abs() < 0.05, "{low} {other_low}");
    let stem = 2.0 * 0.7;
    assert!((other_high - high - stem).abs() < 0.2 * stem, "{high} {other_high}");
}

#[test]
fn figure_2_shorter_and_shorter() {
    let figure = figure(2);
    for name in ["a", "b"] {
        let factors = factors(&figure, name);
        assert!(factors.iter().all(|[length, curvature]| (length * curvature - 1.0).abs() < 1e-9), "{name}");
        assert!(
            factors.windows(2).all(|pair| pair[1][0] < pair[0][0]),
            "{name}: the derivative shrinks along the curve"
        );
    }
    let [[before, after], [_, both]] = ["a", "b"].map(|name| figure.curves(name));
    assert!(near(ends(after)[0], ends(before)[0]) && !near(ends(after)[1], ends(before)[1]));
    assert!((0..2).all(|k| near(ends(both)[k], ends(before)[k])));
    // The two red curves are similar: their curvatures have one ratio.
    let ratio = |u: f64| curvature(both, u) / curvature(after, u);
    assert!((0..50).all(|i| (ratio(0.05 + 0.1 * f64::from(i)) / ratio(0.05) - 1.0).abs() < 1e-9));
    // In (a) no tangent turns.
    for u in [0.0, 1.7, 3.2, 5.0] {
        let [a, b] = [before, after].map(|c| c.derivative(u, 1).unwrap());
        assert!(a.cross(&b).norm() < 1e-12 && a.dot(&b) > 0.0);
    }
}

#[test]
fn figures_3_and_4_the_identity_a_zigzag_and_growth() {
    for number in [3, 4] {
        let figure = figure(number);
        let [before, same] = figure.curves("a");
        assert!((0..=50).all(|i| near(point(before, 0.1 * f64::from(i)), point(same, 0.1 * f64::from(i)))));
        let turns = |name: &str| {
            let factors = factors(&figure, name);
            factors.windows(3).filter(|w| (w[1][0] - w[0][0]) * (w[2][0] - w[1][0]) < 0.0).count()
        };
        assert!(turns("b") >= 3 && turns("c") == 0, "{} {}", turns("b"), turns("c"));
        // Curvature has as many extremes as before: it is scaled gradually.
        let extremes = |curve: &Curve| {
            let all: Vec<f64> = (0..=200).map(|i| curvature(curve, 0.025 * f64::from(i))).collect();
            all.windows(3).filter(|w| w[1] > w[0] && w[1] > w[2]).count()
        };
        let [before, after] = figure.curves("c");
        assert_eq!(extremes(before), extremes(after));
        // Equations 1 and 5, by α as the recipe says it: tangents are all turned by one angle, and curvature is divided by α times one scale.
        for (name, values) in
            [("b", [1.0, 1.4, 0.7, 1.4, 0.7, 1.4, 1.0]), ("c", [0.6, 0.7, 0.8, 1.0, 1.2, 1.3, 1.4])]
        {
            let [before, after] = figure.curves(name);
            let slope = |u: f64| [before, after].map(|c| c.derivative(u, 1).unwrap());
            let scale = slope(0.0).map(|x| x.norm());
            let scale = scale[1] / scale[0] / alpha(&values, 0.0);
            let angle = |u: f64| {
                let [a, b] = slope(u);
                a.cross(&b).z.atan2(a.dot(&b))
            };
            for u in (0..100).map(|i| 0.05 * f64::from(i)) {
                let [a, b] = slope(u);
                let by = alpha(&values, u) * scale;
                assert!((b.norm() / a.norm() / by - 1.0).abs() < 1e-9, "{name} at {u}");
                assert!((angle(u) - angle(0.0)).abs() < 1e-9, "{name} at {u}");
                let (was, is) = (curvature(before, u), curvature(after, u));
                assert!((is * by - was).abs() < 1e-9 * (1.0 + was), "{name} at {u}: {was} {is}");
            }
        }
        // "Although the positions of the control points of the fine-tuned curve in Fig. 3(b) are strongly zigzaged": beside the same polygon with α = 1, whose
        // legs are as long as their neighbours, those of (b) are longer and shorter in turn; the curvature is that of the curve with no more
        // undulations than α has of its own.
        let legs = |curve: &Curve| {
            let legs: Vec<f64> = curve.points().windows(2).map(|w| (w[1] - w[0]).norm()).collect();
            legs.windows(2).map(|w| (w[1] / w[0]).ln()).collect::<Vec<_>>()
        };
        let (same, zigzag) = (figure.curves("a")[1], figure.curves("b")[1]);
        let relative: Vec<f64> = legs(zigzag).iter().zip(legs(same)).map(|(a, b)| a - b).collect();
        let turns = relative.windows(2).filter(|w| w[0] * w[1] < 0.0).count();
        let inflexions = |curve: &Curve| {
            let bend = |i: i32| {
                let [a, b] = [1, 2].map(|k| curve.derivative(0.025 * f64::from(i), k).unwrap());
                a.cross(&b).z
            };
            let all: Vec<f64> = (0..=200).map(bend).collect();
            all.windows(2).filter(|w| w[0] * w[1] < 0.0).count()
        };
        println!("{turns} turns of {}, {} inflexions", relative.len(), inflexions(zigzag));
        assert!(turns >= 4, "{relative:?}");
        assert_eq!(inflexions(zigzag), inflexions(same));
        assert!(extremes(zigzag) <= extremes(same) + 3, "{} {}", extremes(zigzag), extremes(same));
    }
}

/// α of degree two over the derivative's knots, by de Boor's recursion.
fn alpha(values: &[f64; 7], u: f64) -> f64 {
    const KNOTS: [f64; 10] = [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0];
    let span = (2..7).rev().find(|&k| KNOTS[k] <= u).unwrap();
    let mut own: Vec<f64> = values[span - 2..=span].to_vec();
    for round in 1..=2 {
        for j in (round..=2).rev() {
            let (low, high) = (KNOTS[span - 2 + j], KNOTS[span + 1 + j - round]);
            let share = (u - low) / (high - low);
            own[j] = own[j - 1] * (1.0 - share) + own[j] * share;
        }
    }
    own[2]
}

/// End points, and the second and third control points from them, are those of the same curve in the tuned one's degree.
#[test]
fn figures_5_and_6_ends_tangents_curvatures() {
    for (number, names) in [(5, &["a", "b"][..]), (6, &["a", "b", "c"])] {
        let figure = figure(number);
        for (fixed, name) in names.iter().enumerate() {
            let [before, after] = figure.curves(name);
            let raised = before.elevate(after.degree() - before.degree()).unwrap();
            let missing = |t: &f64| {
                let times = after.space().multiplicity(*t) - raised.space().multiplicity(*t);
                std::iter::repeat_n(*t, times)
            };
            let missing: Vec<f64> = raised.space().breakpoints().iter().flat_map(missing).collect();
            let raised = raised.insert_knots(&missing).unwrap();
            let (a, b) = (after.points(), raised.points());
            assert_eq!(a.len(), b.len());
            let last = a.len() - 1;
            for k in 0..=fixed {
                assert!(near(a[k], b[k]) && near(a[last - k], b[last - k]), "{number} {name} {k}");
            }
            assert!(!near(a[fixed + 1], b[fixed + 1]));
        }
    }
}
