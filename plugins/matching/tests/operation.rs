//! The operation `match`: rough surfaces brought to others, measured by an evaluator of the test's own.
#![allow(clippy::unwrap_used, clippy::panic, reason = "these are tests, their helpers included")]

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Edge, Shapes};
use loftsman_kernel::plugin::{Context, NoClock, Observer, Operation, Parameters, Plugin, Quiet, Registry};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_matching::{Limits, MatchOperation, MatchingPlugin, matching};
use serde_json::{Value, json};

fn run(scene: &mut Scene, fields: Value) -> Result<Vec<String>, String> {
    let mut registry = Registry::new();
    MatchingPlugin.register(&mut registry);
    let context = Context { registry: &registry, observer: &Quiet, clock: &NoClock };
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    MatchOperation.apply(scene, &parameters, &context).map(|report| report.notes).map_err(|e| e.to_string())
}

/// A hull: `u1` is its upper edge, wavy; another parametrisation than the deck's.
fn hull(p: usize, q: usize) -> Surface {
    let (u, v) = (Space::clamped_uniform(p, p + 3).unwrap(), Space::clamped_uniform(q, q + 5).unwrap());
    let (rows, columns) = (u.len(), v.len());
    let at = |k: usize| {
        let (i, j) = ((k / columns) as f64 / (rows - 1) as f64, (k % columns) as f64 / (columns - 1) as f64);
        let beam = 1.0 + 0.4 * (3.0 * j).sin();
        Point::new(10.0 * j * j.sqrt(), beam * (0.3 + i * (2.0 - i)), 2.0 * i * i + 0.3 * (2.0 * j).cos())
    };
    Surface::new(u, v, (0..rows * columns).map(at).collect()).unwrap()
}

/// A deck that starts above and inside the hull's edge.
fn deck(p: usize, q: usize) -> Surface {
    let (u, v) = (Space::clamped_uniform(p, p + 4).unwrap(), Space::clamped_uniform(q, q + 3).unwrap());
    let (rows, columns) = (u.len(), v.len());
    let at = |k: usize| {
        let (i, j) = ((k / columns) as f64 / (rows - 1) as f64, (k % columns) as f64 / (columns - 1) as f64);
        Point::new(9.8 * j + 0.1, 1.2 - i, 2.6 + i)
    };
    Surface::new(u, v, (0..rows * columns).map(at).collect()).unwrap()
}

fn scene(hull: &Surface, deck: &Surface) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("hull", hull.clone().into())).unwrap();
    scene.add(Object::new("deck", deck.clone().into())).unwrap();
    scene
}

/// The fields that bring the deck to an edge of the hull, with those limits that belong to the continuity.
fn asked(edge: &str, continuity: usize, tolerance: f64, angle: f64, curvature: f64) -> Value {
    let mut fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": edge },
        "continuity": continuity, "tolerance": tolerance });
    if continuity > 0 {
        fields["angle"] = json!(angle);
    }
    if continuity > 1 {
        fields["curvature"] = json!(curvature);
    }
    fields
}

/// Position, the sine of the angle between the normals, and the difference of the normal curvatures square to the edge, at places of `s`'s edge `u0`; the nearest point of the hull's edge is looked for.
fn measured(s: &Surface, hull: &Surface, along: Direction) -> [f64; 3] {
    let end = hull.space(along).domain().1;
    let edge = hull.isocurve(along, end).unwrap();
    let (a, b) = s.v().domain();
    let mut worst = [0.0_f64; 3];
    for i in 1..400 {
        let (u, v) = (s.u().domain().0, a + (b - a) * f64::from(i) / 400.0);
        let d = |a: usize, b: usize| s.derivative(u, v, a, b).unwrap();
        let near = edge.closest(Point::from(d(0, 0))).unwrap();
        let t = |a: usize, b: usize| match along {
            Direction::U => hull.derivative(end, near.at, a, b).unwrap(),
            Direction::V => hull.derivative(near.at, end, a, b).unwrap(),
        };
        let normal = t(1, 0).cross(&t(0, 1)).normalize();
        let own = d(1, 0).cross(&d(0, 1)).normalize();
        let square = |normal: &Vector, d: &dyn Fn(usize, usize) -> Vector, across_u: bool| {
            let by = |along: usize, across: usize| if across_u { d(across, along) } else { d(along, across) };
            let (t, s) = (by(1, 0), by(0, 1));
            let a = s.dot(&t) / t.norm_squared();
            let bend = by(0, 2) - by(1, 1) * (2.0 * a) + by(2, 0) * (a * a);
            normal.dot(&bend) / (s - t * a).norm_squared()
        };
        let same_side = if own.dot(&normal) < 0.0 { -own } else { own };
        let curvature = square(&same_side, &d, true) - square(&normal, &t, along == Direction::U);
        for (worst, now) in worst.iter_mut().zip([
            (near.point.coords - d(0, 0)).norm(),
            normal.cross(&own).norm(),
            curvature.abs(),
        ]) {
            *worst = worst.max(now);
        }
    }
    worst
}

#[test]
fn a_deck_comes_to_the_hull_within_its_limits() {
    let mut done = 0;
    for (p, q) in [(1, 1), (2, 3), (3, 1), (3, 3), (4, 5), (5, 2), (7, 7)] {
        for continuity in 0..=2_usize {
            let (hull, deck) = (hull(3, 4), deck(p, q));
            let mut both = scene(&hull, &deck);
            let fields = asked("u1", continuity, 0.001, 0.5, 10.0);
            let notes = run(&mut both, fields).unwrap_or_else(|e| panic!("{p} {q} {continuity}: {e}"));
            let after = both.surface("deck").unwrap();
            let [position, sine, curvature] = measured(after, &hull, Direction::U);
            assert!(position < 0.001, "{p} {q} {continuity}: {position} {notes:?}");
            assert!(continuity < 1 || sine < 0.5_f64.to_radians() * 1.01, "{p} {q} {continuity}: {sine}");
            let note = notes.iter().find(|note| note.contains("now: ")).unwrap();
            if continuity == 2 {
                let told: f64 =
                    note.split("curvature ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
                assert!(curvature < told * 1.02 + 1e-9, "{p} {q}: {curvature}, told {note}");
            }
            assert_eq!(both.surface("hull").unwrap(), &hull, "the hull stands still");
            // What is kept at the far edge: position, tangents, curvature, at the same parameters.
            for j in 0..=20 {
                let v = after.v().domain().1 * f64::from(j) / 20.0;
                for order in 0..=continuity {
                    let (old, new) = (deck.u().domain().1, after.u().domain().1);
                    let kept = deck.derivative(old, v, order, 0).unwrap()
                        - after.derivative(new, v, order, 0).unwrap();
                    assert!(
                        kept.norm() < 1e-9,
                        "{p} {q} {continuity}: derivative {order} at the far edge: {kept}"
                    );
                }
            }
            done += 1;
        }
    }
    assert_eq!(done, 21);
}

/// The lower outer part of a torus: `v` runs up its circle to nearly the equator.
fn bowl() -> Surface {
    let quarter =
        Curve::arc(Point::new(3.0, 0.0, -1.0), Point::new(3.0, 0.0, 0.0), -Vector::y(), 1.4).unwrap();
    Surface::revolution(&quarter, Point::origin(), Vector::z(), 1.5).unwrap()
}

#[test]
fn polynomial_and_rational_sheets_meet_a_torus() {
    let bowl = bowl();
    for (p, q, weighted) in [(3, 3, false), (2, 4, true), (5, 2, true)] {
        for continuity in 1..=2_usize {
            let flat = deck(p, q);
            let (u, v, points, _) = flat.into_parts();
            let points: Vec<Point> = points
                .iter()
                .map(|at| {
                    let turn = 0.1 + 1.3 * at.x / 10.0;
                    let radius = 3.9 + 0.2 * (at.y - 1.2);
                    Point::new(radius * turn.cos(), radius * turn.sin(), at.z - 2.4)
                })
                .collect();
            let weights = weighted.then(|| (0..points.len()).map(|k| 1.0 + 0.4 * (k as f64).sin()).collect());
            let rim = Surface::build(u, v, points, weights).unwrap();
            let mut both = scene(&bowl, &rim);
            let fields = asked("v1", continuity, 1e-3, 0.2, 5.0);
            let notes = run(&mut both, fields).unwrap_or_else(|e| panic!("{p} {q} {continuity}: {e}"));
            let [position, sine, curvature] = measured(both.surface("deck").unwrap(), &bowl, Direction::V);
            assert!(position < 1.01e-3 && sine < 0.2_f64.to_radians() * 1.05, "{position} {sine} {notes:?}");
            // 5 % of the torus's 1, and what positions a little apart make of it.
            assert!(continuity < 2 || curvature < 0.06, "{p} {q}: {curvature} {notes:?}");
        }
    }
}

#[test]
fn what_cannot_be_is_said() {
    let (hull, deck) = (hull(3, 4), deck(3, 3));
    let base = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" } });
    let with = |field: &str, value: Value| {
        let mut fields = base.clone();
        fields[field] = value;
        let mut both = scene(&hull, &deck);
        let refused = run(&mut both, fields).unwrap_err();
        assert_eq!(both.surface("deck").unwrap(), &deck, "{field}: changed although refused");
        refused
    };
    for (field, value, words) in [
        ("edge", json!("w0"), "unknown edge \"w0\""),
        ("with", json!({ "object": "hull" }), "edge"),
        ("with", json!({ "object": "mast", "edge": "u1" }), "mast"),
        ("with", json!({ "object": "deck", "edge": "u1" }), "cannot stand still"),
        ("continuity", json!(3), "3 is not 0, 1 or 2"),
        ("keep", json!(7), "is not 0, 1, 2 or"),
        ("keep", json!("all"), "\"all\" is not 0, 1, 2 or \"nothing\""),
        ("curvature", json!(5), "limits nothing with continuity 1: say continuity = 2"),
        ("tolerance", json!(0), "above 0"),
        ("angle", json!(-1), "above 0"),
        ("metric", json!("falloff"), "bend"),
        ("objekt", json!("deck"), "object"),
    ] {
        let refused = with(field, value);
        assert!(refused.contains(words), "{field}: {refused}");
    }
    let mut fields = base.clone();
    fields["continuity"] = json!(0);
    fields["angle"] = json!(0.5);
    let refused = run(&mut scene(&hull, &deck), fields).unwrap_err();
    assert!(refused.contains("angle") && refused.contains("say continuity = 1"), "{refused}");
    // So narrow that no number of knots will do, and without knots.
    let refused = with("refine", json!(false));
    assert!(refused.contains("refine = true") && refused.contains("angle"), "{refused}");
    let refused = with("angle", json!(1e-13));
    assert!(refused.contains("still apart by position"), "{refused}");
    // A curve has no edge, and is told of where it stands.
    let mut both = scene(&hull, &deck);
    let rail = hull.isocurve(Direction::U, hull.u().domain().1).unwrap();
    both.add(Object::new("rail", Geometry::Curve(rail))).unwrap();
    let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "rail", "edge": "u1" } });
    let refused = run(&mut both, fields).unwrap_err();
    assert!(refused.contains("with.object") && refused.contains("constraint `edge`"), "{refused}");
    // One that lies folded over the other.
    let mut folded = scene(&hull, &hull);
    folded.rename("deck", "cover").unwrap();
    let fields = json!({ "object": "cover", "edge": "u1", "with": { "object": "hull", "edge": "u1" }, "metric": "least" });
    let refused = run(&mut folded, fields).unwrap_err();
    assert!(refused.contains("folded back"), "{refused}");
}

/// A sheet whose edge `u1` is wild and rational, of this degree along it, and one beside it.
fn wild(degree: usize, seed: u64) -> [Surface; 2] {
    let mut state = seed;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut sheet = |degree: usize, x: f64, count: usize| {
        let (u, v) = (Space::clamped_uniform(3, 5).unwrap(), Space::clamped_uniform(degree, count).unwrap());
        let at = |k: usize| ((k / count) as f64, (k % count) as f64 / (count - 1) as f64);
        let points = (0..5 * count)
            .map(|k| Point::new(x + 0.5 * at(k).0, 2.0 * at(k).1 - 1.0, 0.6 * next() - 0.3))
            .collect();
        let weights = (0..5 * count).map(|_| 0.5 + 1.5 * next()).collect();
        Surface::build(u, v, points, Some(weights)).unwrap()
    };
    [sheet(degree, -2.0, 2 * degree + 3), sheet(2, 0.3, 4)]
}

/// A rational edge with knots of its own is met in position: with its knots, which the surface gets where halving its own brings nothing. And what a refusal
/// names helps: it was tried.
#[test]
fn what_a_refusal_advises_works() {
    let (mut refused, mut more, mut lower, mut knots) = (0, 0, 0, 0);
    for (degree, seed, edge, continuity, refine) in [
        (1, 1, "u0", 0, true),
        (3, 1, "u0", 0, true),
        (3, 3, "u0", 0, false),
        (3, 2, "u1", 1, true),
        (1, 3, "u0", 1, false),
        (3, 0, "u1", 2, true),
        (2, 1, "u1", 2, true),
        (3, 0, "u0", 2, false),
    ] {
        let [hull, deck] = wild(degree, seed);
        let fields = json!({ "object": "deck", "edge": edge, "with": { "object": "hull", "edge": "u1" },
            "continuity": continuity, "refine": refine });
        let told = match run(&mut scene(&hull, &deck), fields.clone()) {
            Ok(_) => continue,
            Err(told) => told,
        };
        refused += 1;
        assert!(continuity > 0 || !refine, "{seed} {degree}: {told}");
        if let Some((_, all)) = told.split_once("allow more (") {
            let mut fields = fields.clone();
            for limit in all.split(')').next().unwrap().split(", ") {
                let (name, value) = limit.split_once(" = ").unwrap();
                fields[name] = json!(value.parse::<f64>().unwrap());
            }
            run(&mut scene(&hull, &deck), fields).unwrap_or_else(|e| panic!("{told}: {e}"));
            more += 1;
        }
        let mut fields = fields.clone();
        fields["refine"] = json!(true);
        if told.contains("let knots be inserted (refine = true)") {
            run(&mut scene(&hull, &deck), fields).unwrap_or_else(|e| panic!("{told}: {e}"));
            knots += 1;
        } else if let Some((_, words)) = told.split_once("ask for continuity ") {
            fields["continuity"] = json!(words[..1].parse::<usize>().unwrap());
            run(&mut scene(&hull, &deck), fields).unwrap_or_else(|e| panic!("{told}: {e}"));
            lower += 1;
        }
    }
    assert!(refused > 3 && more > 2 && lower > 0 && knots > 2, "{refused} {more} {lower} {knots}");
}

/// Knots that lie close together on the surface that stands still are nothing to the one that moves; where its own lie so close that bending is beyond
/// numbers, that is said in words of its own.
#[test]
fn knots_close_together_do_not_matter_where_nothing_moves() {
    let (hull, deck) = (hull(3, 4), deck(3, 3));
    let near = |s: &Surface, by: f64| {
        let (a, b) = s.u().domain();
        let at = a + 0.4 * (b - a);
        s.insert_knots(Direction::U, &[at, at, at, at + by, at + by]).unwrap()
    };
    let fields = asked("u1", 1, 0.001, 0.5, 10.0);
    let mut plain = scene(&hull, &deck);
    run(&mut plain, fields.clone()).unwrap();
    let mut close = scene(&near(&hull, 1e-9), &deck);
    run(&mut close, fields.clone()).unwrap();
    let [plain, close] = [&plain, &close].map(|scene| scene.surface("deck").unwrap().points().to_vec());
    for (p, q) in plain.iter().zip(&close) {
        assert!((p - q).norm() < 1e-6, "{p} {q}");
    }
    let own = near(&deck, 1e-9);
    // Where no metric is said, the other one is taken, which needs no such measure.
    let notes = run(&mut scene(&hull, &own), fields.clone()).unwrap();
    assert!(notes.iter().any(|note| note.starts_with("how much it bends cannot be measured")), "{notes:?}");
    let mut bend = fields;
    bend["metric"] = json!("bend");
    let refused = run(&mut scene(&hull, &own), bend).unwrap_err();
    assert!(
        refused.contains("how much the surface bends cannot be measured: its knots at u = "),
        "{refused}"
    );
    assert!(refused.contains("only 1e-9 apart") && refused.contains("metric = \"least\""), "{refused}");
    // What moves surfaces tells curves where to go.
    let mut curves = scene(&hull, &deck);
    let line = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
    curves.add(Object::new("line", line.into())).unwrap();
    let fields = json!({ "object": "line", "edge": "u0", "with": { "object": "hull", "edge": "u1" } });
    let refused = run(&mut curves, fields).unwrap_err();
    assert!(refused.contains("`match` moves surfaces") && refused.contains("`join`"), "{refused}");
}

/// Two jagged sheets that stand at some 75 degrees to each other, `u1` of the first near `u0` of the second.
fn jagged(seed: u64) -> [Surface; 2] {
    let mut state = seed.wrapping_mul(2654435761) + 1;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut sheet = |upright: bool, degree: usize, count: usize| {
        let along = Space::clamped_uniform(degree, count).unwrap();
        let across = Space::clamped_uniform(1 + degree, count).unwrap();
        let points = (0..count * count)
            .map(|k| {
                let [i, j] = [k / count, k % count].map(|k| k as f64 / (count - 1) as f64);
                let [a, b, c] = [0, 0, 0].map(|_| 0.2 * (next() - 0.5));
                if upright {
                    Point::new(1.2 + 0.26 * i + a, j + b, 0.97 * i + c)
                } else {
                    Point::new(i + a, j + b, c)
                }
            })
            .collect();
        Surface::build(across, along, points, None).unwrap()
    };
    [sheet(false, 1 + (seed % 3) as usize, 5 + (seed % 2) as usize), sheet(true, 2, 5)]
}

/// What was one surface until it was split meets itself with every continuity, and stays where it is: the adjustment is rounding, whatever share of itself
/// it still changes by. Nearly so where it is off by less than can be seen.
#[test]
fn what_meets_already_stays_where_it_is() {
    let mut state = 7_u64;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for degree in [3, 4, 5] {
        for (extra, size) in [(1, 1.0), (2, 1e3), (3, 1e-3), (2, 1e-7)] {
            let count = degree + extra;
            let space = Space::clamped_uniform(degree, count).unwrap();
            let points = (0..count * count).map(|k| {
                let [i, j] = [k / count, k % count].map(|k| k as f64 / (count - 1) as f64);
                Point::new(i + 0.03 * next(), j + 0.03 * next(), 0.4 * next()) * size
            });
            let whole = Surface::build(space.clone(), space, points.collect(), None).unwrap();
            let halves = whole.split(Direction::U, 0.37).unwrap();
            let [left, right] = &halves[..] else { panic!("{halves:?}") };
            for off in [0.0, 1e-14, 1e-12, 1e-10, 1e-8] {
                let moved =
                    right.points().iter().map(|p| p + Vector::new(next(), next(), next()) * (off * size));
                let beside =
                    Surface::build(right.u().clone(), right.v().clone(), moved.collect(), None).unwrap();
                for continuity in [0, 1, 2] {
                    let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" },
                        "continuity": continuity });
                    let mut all = scene(left, &beside);
                    let what = format!(
                        "degree {degree}, {count} vertices, size {size:e}, off by {off:e}, G{continuity}"
                    );
                    run(&mut all, fields).unwrap_or_else(|e| panic!("{what}: {e}"));
                    let now = all.surface("deck").unwrap();
                    let ((a, b), (c, d)) = (right.u().domain(), right.v().domain());
                    let at =
                        |k: i32| (a + (b - a) * f64::from(k % 7) / 6.0, c + (d - c) * f64::from(k / 7) / 6.0);
                    let moved =
                        (0..49).map(at).map(|(u, v)| now.point(u, v).unwrap() - right.point(u, v).unwrap());
                    let far = moved.map(|by| by.norm()).fold(0.0, f64::max);
                    assert!(far <= (1e3 * off + 1e-11) * size, "{what}: {far:e}");
                }
            }
        }
    }
}

/// Surfaces that are not clamped across the edge, of one piece or more: all rows of the last span have a say there, so that they get more of them.
#[test]
fn one_piece_that_is_not_clamped_is_matched() {
    let sheet = |x: f64, across: Space, bend: f64| {
        let (n, along) = (across.len(), Space::clamped_uniform(3, 4).unwrap());
        let points = (0..4 * n).map(|k| {
            let (i, j) = ((k / 4) as f64, (k % 4) as f64);
            Point::new(x + 2.0 * i / (n - 1) as f64, 2.0 * j / 3.0 - 1.0, bend * i * i)
        });
        Surface::build(across.clone(), along, points.collect(), None).unwrap()
    };
    let hull = sheet(0.5, Space::clamped_uniform(3, 5).unwrap(), 0.05);
    for degree in 1..=6 {
        for pieces in 1..=3 {
            let knots = (0..=2 * degree + pieces).map(|k| k as f64).collect();
            let across = Space::open(degree, knots).unwrap();
            let deck = sheet(-2.0, across, 0.02);
            for continuity in [0, 1, 2] {
                for keep in [json!(null), json!(0), json!(2), json!("nothing")] {
                    let mut fields = json!({ "object": "deck", "edge": "u1", "with": { "object": "hull", "edge": "u0" },
                        "continuity": continuity });
                    if !keep.is_null() {
                        fields["keep"] = keep.clone();
                    }
                    let what = format!("degree {degree}, {pieces} pieces, G{continuity}, keep {keep}");
                    let mut all = scene(&hull, &deck);
                    run(&mut all, fields).unwrap_or_else(|e| panic!("{what}: {e}"));
                    let now = all.surface("deck").unwrap();
                    // The far edge stays.
                    let ((a, _), (from, to)) = (deck.u().domain(), deck.v().domain());
                    for k in 0..=4 {
                        let v = from + (to - from) * f64::from(k) / 4.0;
                        let off = (now.point(a, v).unwrap() - deck.point(a, v).unwrap()).norm();
                        assert!(keep == json!("nothing") || off < 1e-12, "{what}: {off:e}");
                    }
                }
            }
        }
    }
}

/// Tangent planes leave open on which side of its edge a surface lies. What would fold back is led, which is said; what lay folded back before is refused.
#[test]
fn what_would_fold_back_is_led() {
    let (mut led, mut free, mut refused) = (0, 0, 0);
    for seed in 0..24 {
        let [deck, hull] = jagged(seed);
        for (continuity, metric) in [(1, "bend"), (1, "least"), (2, "bend")] {
            let fields = json!({ "object": "deck", "edge": "u1", "with": { "object": "hull", "edge": "u0" },
                "continuity": continuity, "metric": metric });
            let mut all = scene(&hull, &deck);
            match run(&mut all, fields) {
                Ok(notes) => {
                    let said = notes.iter().any(|note| note.contains("left free it would fold back"));
                    led += usize::from(said);
                    free += usize::from(!said);
                    let found = worst_angle(all.surface("deck").unwrap(), &hull);
                    assert!(found < 0.11, "{seed} {continuity} {metric}: {found}°");
                }
                Err(problem) => {
                    eprintln!("{seed} {continuity} {metric}: {problem}");
                    refused += 1;
                    assert!(problem.contains("folded back") || continuity == 2, "{seed}: {problem}");
                }
            }
        }
    }
    eprintln!("{led} {free} {refused}");
    assert!(led >= 10 && free >= 10 && refused <= 24, "{led} {free} {refused}");
}

/// The largest angle, in degrees, between the ways across of a surface at `u1` and of another at `u0` in the plane square to the edge; near 180 where one lies
/// folded back on the other.
fn worst_angle(deck: &Surface, hull: &Surface) -> f64 {
    let square = |s: &Surface, u: f64, v: f64| {
        let mut all = [Vector::zeros(); 4];
        s.derivatives_into(u, v, [1, 1], &mut all).unwrap();
        let along = all[1].normalize();
        (all[2] - along * along.dot(&all[2])).normalize()
    };
    let (end, start) = (deck.u().domain().1, hull.u().domain().0);
    let ((a, b), (c, d)) = (deck.v().domain(), hull.v().domain());
    let angle = |k: usize| {
        let share = k as f64 / 400.0;
        let [x, y] = [square(deck, end, a + (b - a) * share), square(hull, start, c + (d - c) * share)];
        x.cross(&y).norm().atan2(x.dot(&y)).to_degrees()
    };
    (0..=400).map(angle).fold(0.0, f64::max)
}

/// Where bending cannot be measured and the metric `least` alone does not do, it is advised together with what does: both were tried.
#[test]
fn the_metric_least_is_advised_where_it_helps() {
    let (mut alone, mut together) = (0, 0);
    for (degree, seed) in [(3, 0), (1, 2)] {
        let [hull, deck] = wild(degree, seed);
        let (a, b) = deck.v().domain();
        let at = a + 0.4 * (b - a);
        let deck = deck.insert_knots(Direction::V, &[at, at, at + 1e-9, at + 1e-9]).unwrap();
        for continuity in [0, 1, 2] {
            let mut fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" },
                "continuity": continuity, "metric": "bend" });
            let Err(told) = run(&mut scene(&hull, &deck), fields.clone()) else { continue };
            if !told.contains("cannot be measured") {
                continue;
            }
            if !told.contains("say metric = \"least\"") {
                assert!(told.contains("nothing that was tried helps"), "{told}");
                continue;
            }
            fields["metric"] = json!("least");
            match told.split_once("ask for continuity ") {
                Some((_, words)) => {
                    fields["continuity"] = json!(words[..1].parse::<usize>().unwrap());
                    together += 1;
                }
                None => alone += 1,
            }
            run(&mut scene(&hull, &deck), fields).unwrap_or_else(|e| panic!("{told}: {e}"));
        }
    }
    assert!(alone > 0 && together > 0, "{alone} {together}");
}

/// A pipe about the z axis, closed round `u`, turned about it, its edge `v0` the lower one.
fn pipe(radius: f64, low: f64, high: f64, degrees: f64, periodic: bool) -> Surface {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let at = |z: f64| Point::new(radius * cos, radius * sin, z);
    let line = Curve::line(at(low), at(high)).unwrap();
    let pipe = Surface::revolution(&line, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    if periodic { pipe.to_periodic(Direction::U, 0.0).unwrap().shape } else { pipe }
}

/// A tube that is matched to a closed edge with a corner gets that corner, where it comes, and stays closed along its own seam.
#[test]
fn a_tube_stays_closed_where_the_other_edge_has_a_corner() {
    // A clamped cubic that ends where it starts, another way than it starts, extruded.
    let corners = 8;
    let points = (0..corners).flat_map(|k| {
        let (sin, cos) =
            (std::f64::consts::TAU * f64::from(k % (corners - 1)) / f64::from(corners - 1)).sin_cos();
        [0.0, 20.0].map(|z| Point::new(5.0 * cos, 5.0 * sin, z))
    });
    let drop = Surface::new(
        Space::clamped_uniform(3, corners as usize).unwrap(),
        Space::clamped_uniform(1, 2).unwrap(),
        points.collect(),
    )
    .unwrap();
    let (mut made, mut refused) = (0, Vec::new());
    for continuity in [0, 1] {
        for periodic in [false, true] {
            for degrees in [0.0, 30.0, 90.0, 140.0, 200.0, 300.0] {
                let mut scene = Scene::new();
                scene.add(Object::new("low", drop.clone().into())).unwrap();
                scene.add(Object::new("high", pipe(3.0, 30.0, 60.0, degrees, periodic).into())).unwrap();
                let fields = json!({
                    "object": "high", "edge": "v0", "with": { "object": "low", "edge": "v1" }, "continuity": continuity
                });
                match run(&mut scene, fields) {
                    Ok(notes) => {
                        made += 1;
                        assert!(!notes.iter().any(|note| note.contains("a gap of")), "{degrees}: {notes:?}");
                        let found = scene.surface("high").unwrap();
                        let ((a, b), (c, d)) = (found.u().domain(), found.v().domain());
                        for k in 0..=20 {
                            let v = (c + (d - c) * f64::from(k) / 20.0).min(d);
                            let [p, q] = [a, b].map(|u| found.point(u, v).unwrap());
                            assert!((p - q).norm() < 1e-9, "{continuity} {periodic} {degrees}: {p} {q}");
                        }
                    }
                    Err(error) => refused.push(format!("{continuity} {periodic} {degrees}: {error}")),
                }
            }
        }
    }
    assert!(made >= 12 && made + refused.len() == 24, "{made} {refused:#?}");
}

/// A pipe is matched to a coaxial one as it is, however it is turned about its axis: straight up, not twisted, from the place of the other's edge that
/// is beside its start, wherever between knots that lies; the result is the same body.
#[test]
fn a_turned_pipe_is_not_twisted() {
    let low = pipe(5.0, 0.0, 20.0, 0.0, false);
    let fields =
        json!({ "object": "high", "edge": "v0", "with": { "object": "low", "edge": "v1" }, "continuity": 2 });
    let within = 1e-4 * 10.0;
    for periodic in [false, true] {
        let mut waists = Vec::new();
        // One with a seam, rational as these are, would be bent at its own knots by a start between those of the other.
        let turns: &[f64] =
            if periodic { &[0.0, 30.0, 90.0, 150.0, 270.0] } else { &[0.0, 90.0, 180.0, 270.0] };
        for &degrees in turns {
            let mut scene = Scene::new();
            scene.add(Object::new("low", low.clone().into())).unwrap();
            scene.add(Object::new("high", pipe(3.0, 30.0, 60.0, degrees, periodic).into())).unwrap();
            let notes = run(&mut scene, fields.clone()).unwrap();
            assert!(notes[0].contains("position 10.2 "), "{degrees}: {notes:?}");
            let found = scene.surface("high").unwrap();
            let ((a, b), (c, d)) = (found.u().domain(), found.v().domain());
            let middle = 0.5 * (c + d);
            for k in 0..=360 {
                let at = (a + (b - a) * f64::from(k) / 360.0).min(b);
                let start = found.point(at, c).unwrap();
                let off = start.x.hypot(start.y) - 5.0;
                assert!(
                    off.abs() < 2.0 * within && (start.z - 20.0).abs() < 2.0 * within,
                    "{degrees}: {start}"
                );
                // Lines across go straight: as far round as at the edge that stays, but for the parameters of quarters.
                let [round, there] = [middle, d].map(|v| found.point(at, v).unwrap()).map(|p| p.y.atan2(p.x));
                let turn = (round - there + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
                assert!((turn - std::f64::consts::PI).abs().to_degrees() < 2.0, "{degrees} {k}: {turn}");
                let waist = found.point(at, middle).unwrap();
                waists.push(waist.x.hypot(waist.y));
            }
        }
        let (low, high) = waists.iter().fold((f64::MAX, 0.0_f64), |(l, h), w| (l.min(*w), h.max(*w)));
        // Twisted by 30° it would be 8 % narrower.
        assert!(high - low < 0.006 * high, "{low} {high}");
    }
    let mut scene = Scene::new();
    scene.add(Object::new("low", low.into())).unwrap();
    scene.add(Object::new("high", pipe(3.0, 30.0, 60.0, 30.0, false).into())).unwrap();
    let notes = run(&mut scene, fields).unwrap();
    let told = |note: &String| {
        note.contains("askew") && note.contains("° of a turn") && note.contains("periodic = true")
    };
    assert!(notes.iter().any(told), "{notes:?}");
}

/// A ring of so many control vertices, of a cubic at that radius but for ripples, from `low` to `high`.
fn ring(count: usize, radius: f64, low: f64, high: f64, degrees: f64, periodic: bool) -> Surface {
    let u = Space::periodic_uniform(3, count).unwrap();
    let v = Space::clamped_uniform(3, 5).unwrap();
    let net = (0..count * 5).map(|k| {
        let angle = std::f64::consts::TAU * (k / 5) as f64 / count as f64 + degrees.to_radians();
        Point::new(radius * angle.cos(), radius * angle.sin(), low + (high - low) * (k % 5) as f64 / 4.0)
    });
    let ring = Surface::new(u, v, net.collect()).unwrap();
    if periodic { ring } else { ring.to_clamped().unwrap() }
}

/// However a ring is turned about its axis, and whether it has a seam or not, lines across it go on where they end on the other, to a degree, either way round; the
/// constraint, which begins at a knot of the other where it has to lie on it exactly, says by how much that is askew.
#[test]
fn rings_at_any_angle_are_not_twisted() {
    let mut seed = 11_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut straight = [0, 0];
    for case in 0..20 {
        let degrees = if case == 0 { 77.7 } else { 360.0 * next() };
        let count = [8, 12, 16][case % 3];
        for (periodic, backwards) in [(true, false), (false, false), (true, true), (false, true)] {
            let low = ring(count, 5.0, 0.0, 20.0, 0.0, case % 2 == 0);
            let mut high = ring(12, 3.0, 30.0, 60.0, degrees, periodic);
            if backwards {
                high = high.reverse(Direction::U).unwrap();
            }
            let mut scene = Scene::new();
            scene.add(Object::new("low", low.clone().into())).unwrap();
            scene.add(Object::new("high", high.into())).unwrap();
            let fields = json!({ "object": "high", "edge": "v0", "with": { "object": "low", "edge": "v1" }, "continuity": 1 });
            let notes = run(&mut scene, fields).unwrap_or_else(|e| panic!("{degrees} {periodic}: {e}"));
            let found = scene.surface("high").unwrap();
            let ((a, b), (c, d)) = (found.u().domain(), found.v().domain());
            let mut worst = 0.0_f64;
            for k in 0..=90 {
                let at = (a + (b - a) * f64::from(k) / 90.0).min(b);
                let [here, there] = [c, d].map(|v| found.point(at, v).unwrap()).map(|p| p.y.atan2(p.x));
                let turn = (here - there + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU);
                worst = worst.max((turn - std::f64::consts::PI).abs().to_degrees());
            }
            let askew = notes.iter().find_map(|note| {
                let (before, _) = note.split_once("° of a turn from where the two are nearest")?;
                before.rsplit(' ').next()?.parse::<f64>().ok()
            });
            // What has a seam may have to begin at a knot: then it says by how much lines are askew, and what to do.
            match askew {
                None => assert!(worst < 1.0, "{degrees} {periodic} {backwards}: {worst} {notes:?}"),
                Some(turn) => {
                    assert!(!periodic && turn < 23.0, "{degrees} {periodic} {backwards}: {notes:?}");
                    assert!((worst - turn).abs() < 1.0, "{degrees}: {worst} {notes:?}");
                    assert!(
                        notes.iter().any(|note| note.contains("`simplify` with `periodic = true`")),
                        "{notes:?}"
                    );
                }
            }
            straight[usize::from(periodic)] += usize::from(askew.is_none());
        }
    }
    assert!(straight[1] == 40 && straight[0] > 10, "{straight:?}");
}

/// The constraint, under which an edge lies on the other exactly, begins it at a knot of that, and says by how much lines across run askew and what to do.
#[test]
fn an_edge_that_begins_at_a_knot_says_how_far_askew_that_is() {
    for (degrees, periodic, askew) in
        [(0.0, true, None), (90.0, false, None), (40.0, true, Some("10°")), (77.7, false, Some("12.3°"))]
    {
        let (low, high) = (ring(12, 5.0, 0.0, 20.0, 0.0, true), ring(12, 3.0, 30.0, 60.0, degrees, periodic));
        let low = if periodic { low } else { low.to_clamped().unwrap() };
        let asked = matching(Edge::VStart, 1, Edge::VEnd, 0, Limits::default());
        let edited = Edit::new(&high)
            .with(low.boxed())
            .lock_on(1, 0..low.points().len() as i64)
            .ask(asked.hold())
            .solve()
            .unwrap();
        let notes = &edited.report().notes;
        let note = notes.iter().find(|note| note.contains("askew"));
        match askew {
            Some(turn) => assert!(
                note.is_some_and(|n| n.contains(turn) && n.contains("operation `match`")),
                "{degrees}: {notes:?}"
            ),
            None => assert!(note.is_none(), "{degrees}: {notes:?}"),
        }
    }
}

/// Where nothing but rounding is left, nothing is told.
#[test]
fn rounding_is_told_as_nothing() {
    let hull = hull(3, 4);
    let mut both = scene(&hull, &hull);
    both.rename("deck", "cover").unwrap();
    let fields = json!({ "object": "cover", "edge": "u1", "with": { "object": "hull", "edge": "u1" }, "continuity": 0 });
    let notes = run(&mut both, fields).unwrap();
    assert!(notes.iter().any(|n| n.contains("now: position to rounding")), "{notes:?}");
}

/// Corners of the other edge are met, and said; those that nobody asks for are not made.
#[test]
fn an_edge_with_corners_is_met_with_corners() {
    let sheet = |x: f64, lift: f64| {
        let (u, v) = (
            Space::clamped_uniform(2, 5).unwrap(),
            Space::open(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0]).unwrap(),
        );
        let columns = v.len();
        let at = |k: usize| {
            let (i, j) = (k / columns, k % columns);
            Point::new(x + i as f64, j as f64, if j == columns / 2 { lift } else { 0.0 })
        };
        Surface::new(u, v, (0..5 * columns).map(at).collect()).unwrap()
    };
    for (lift, cornered) in [(1.0, true), (0.0, false)] {
        let mut both = scene(&sheet(0.0, lift), &sheet(5.0, 0.0));
        let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" }, "continuity": 0 });
        let notes = run(&mut both, fields).unwrap();
        assert_eq!(notes.iter().any(|note| note.contains("corners may appear")), cornered, "{notes:?}");
        let [position, ..] = measured(both.surface("deck").unwrap(), &sheet(0.0, lift), Direction::U);
        assert!(position < 1e-12, "{lift}: {position}");
    }
}

/// A deck whose lines across leave the edge at `degrees` to it, not square.
fn sheared(p: usize, q: usize, degrees: f64) -> Surface {
    let (u, v, points, weights) = deck(p, q).into_parts();
    let along = 1.0 / degrees.to_radians().tan();
    let points = points.iter().map(|at| at + Vector::x() * (1.2 - at.y) * along).collect();
    Surface::build(u, v, points, weights).unwrap()
}

/// What is solved and told is the curvature square to the edge, however the surface's lines run across it.
#[test]
fn lines_that_leave_the_edge_slantwise_hide_no_curvature() {
    let hull = hull(3, 4);
    for degrees in [60.0, 30.0, 10.0] {
        for (p, q) in [(3, 3), (5, 4)] {
            let mut both = scene(&hull, &sheared(p, q, degrees));
            let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" },
                "continuity": 2, "angle": 0.2, "curvature": 5 });
            let notes = run(&mut both, fields).unwrap_or_else(|e| panic!("{degrees} {p} {q}: {e}"));
            let [position, sine, curvature] = measured(both.surface("deck").unwrap(), &hull, Direction::U);
            let note = notes.iter().find(|note| note.contains("now: ")).unwrap();
            assert!(position < 1e-3 && sine < 0.2_f64.to_radians() * 1.01, "{degrees} {p} {q}: {note}");
            let told: f64 =
                note.split("curvature ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            assert!(curvature < told * 1.02 + 1e-9 && told < 0.05, "{degrees} {p} {q}: {curvature}, {note}");
        }
    }
}

/// A flat sheet has no curvature to be a part of: what comes to it with G2 is flat along the edge to rounding, and it is said.
#[test]
fn flat_along_the_edge_is_flat_to_rounding() {
    let flat = {
        let (u, v, points, _) = hull(3, 4).into_parts();
        Surface::new(u, v, points.iter().map(|at| Point::new(at.x, at.y, 2.0)).collect()).unwrap()
    };
    let (u, v, points, _) = deck(4, 4).into_parts();
    let beyond =
        Surface::new(u, v, points.iter().map(|at| Point::new(at.x, 2.4 - at.y, at.z)).collect()).unwrap();
    let mut both = scene(&flat, &beyond);
    let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" }, "continuity": 2 });
    let notes = run(&mut both, fields).unwrap();
    let [position, sine, curvature] = measured(both.surface("deck").unwrap(), &flat, Direction::U);
    assert!(position < 1e-9 && sine < 1e-9 && curvature < 1e-9, "{position} {sine} {curvature}");
    assert!(
        notes.iter().any(|note| note.contains("now: ") && note.contains("the other surface is flat")),
        "{notes:?}"
    );
}

/// Counts how often, and with how many control vertices along the edge, a match is tried.
#[derive(Debug, Default)]
struct Counting {
    tried: std::sync::Mutex<Vec<u64>>,
}

impl Observer for Counting {
    fn progress(&self, work: &str, done: u64, _: u64) {
        if work == "match" {
            self.tried.lock().unwrap().push(done);
        }
    }
}

/// What cannot be reached is given up soon, and in words that say why: limits near rounding, and an edge full of kinks.
#[test]
fn work_is_bounded_where_limits_are_out_of_reach() {
    let kinked = {
        let (u, v) = (Space::clamped_uniform(3, 6).unwrap(), Space::clamped_uniform(1, 9).unwrap());
        let at = |k: usize| {
            let (i, j) = ((k / 9) as f64, (k % 9) as f64);
            Point::new(1.2 * j, 2.0 - 0.3 * i + 0.2 * (2.3 * j).sin(), 0.3 * i + 0.4 * (5.0 * j).cos())
        };
        Surface::new(u, v, (0..54).map(at).collect()).unwrap()
    };
    let most = [256, 192, 128];
    let (mut refused, mut done) = (0, 0);
    for (number, hull) in [hull(3, 4), kinked, hull(5, 3)].iter().enumerate() {
        for continuity in 0..=2 {
            for (tolerance, angle, curvature) in [(1e-4, 0.1, 5.0), (1e-12, 1e-9, 1e-7)] {
                let mut both = scene(hull, &deck(3, 3));
                let mut registry = Registry::new();
                MatchingPlugin.register(&mut registry);
                let observer = Counting::default();
                let context = Context { registry: &registry, observer: &observer, clock: &NoClock };
                let fields = asked("u1", continuity, tolerance, angle, curvature);
                let parameters = Parameters::new(fields, "step[0]").unwrap();
                let told = MatchOperation.apply(&mut both, &parameters, &context).map_err(|e| e.to_string());
                let tried = observer.tried.into_inner().unwrap();
                assert!(!tried.is_empty() && tried.len() <= 12, "{number} {continuity}: {tried:?}");
                assert!(
                    tried.iter().all(|&count| count <= most[continuity]),
                    "{number} {continuity}: {tried:?}"
                );
                match told {
                    Ok(_) => done += 1,
                    Err(told) => {
                        assert!(
                            told.contains("still apart by position") && told.contains("allow more"),
                            "{told}"
                        );
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(refused >= 5 && done >= 3, "{refused} refused, {done} done");
}

/// The other surface bends along the edge only a hundredth as much square to it: the share of that is told as well.
#[test]
fn a_difference_is_told_as_a_part_of_the_curvature_square_to_the_edge_too() {
    let trough = {
        let (u, v) = (Space::clamped_uniform(3, 6).unwrap(), Space::clamped_uniform(3, 8).unwrap());
        let at = |k: usize| {
            let (i, j) = ((k / 8) as f64, (k % 8) as f64);
            Point::new(j, 0.7 * i, 0.4 * (j - 3.5) * (j - 3.5) + 0.003 * i * i)
        };
        Surface::new(u, v, (0..48).map(at).collect()).unwrap()
    };
    let (u, v, points, _) = trough.clone().into_parts();
    let beside = points.iter().map(|p| Point::new(p.x, p.y + 3.6, p.z + 0.1 * p.y)).collect();
    let mut both = scene(&trough, &Surface::new(u, v, beside).unwrap());
    let fields = json!({ "object": "deck", "edge": "u0", "with": { "object": "hull", "edge": "u1" }, "continuity": 1 });
    let notes = run(&mut both, fields).unwrap();
    let note = notes.iter().find(|note| note.contains("now: ")).unwrap();
    let number = |after: &str| -> f64 {
        note.split(after).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    let (part, square) = (number("("), number("largest, "));
    assert!(note.ends_with("% of its largest across the edge)") && square > 20.0 * part, "{note}");
    let end = trough.u().domain().1;
    let (mut most, told) = (0.0_f64, number("curvature "));
    for i in 0..=400 {
        let at = trough.v().domain().1 * f64::from(i) / 400.0;
        let d = |a: usize, b: usize| trough.derivative(end, at, a, b).unwrap();
        let normal = d(1, 0).cross(&d(0, 1)).normalize();
        let skew = d(1, 0).dot(&d(0, 1)) / d(0, 1).norm_squared();
        let bend = d(2, 0) - d(1, 1) * (2.0 * skew) + d(0, 2) * (skew * skew);
        most = most.max((normal.dot(&bend) / (d(1, 0) - d(0, 1) * skew).norm_squared()).abs());
    }
    assert!((square / 100.0 * most / told - 1.0).abs() < 0.01, "{note}: {most}");
}

/// Where edges run through their parameters otherwise and may be apart, the angle that is told is no smaller than the one at the
/// nearest points.
#[test]
fn the_constraint_tells_the_angle_at_the_nearest_points() {
    let (mut done, mut refused) = (0, Vec::new());
    for skew in [0.0, 0.3, 0.6, 0.9] {
        for (p, q) in [(2, 2), (3, 3), (4, 2)] {
            let hull = hull(3, 4);
            let (u, v, points, _) = deck(p, q).into_parts();
            let shifted = |at: &Point| Point::new(at.x + skew * (10.0 - at.x) * at.x / 10.0, at.y, at.z);
            let deck = Surface::new(u, v, points.iter().map(shifted).collect()).unwrap();
            let limits = Limits { distance: Some(1.0), angle: 0.5, curvature: 1.0 };
            let asked = matching(Edge::UStart, 1, Edge::UEnd, 1, limits);
            let solved = Edit::new(&deck).with(Box::new(hull.clone())).ask(asked.clone().hold()).solve();
            let edited = match solved {
                Ok(edited) => edited,
                Err(error) => {
                    refused.push(format!("{p} {q} {skew}: {error}"));
                    continue;
                }
            };
            let shapes = Shapes::new([edited.shape() as &dyn Shape, &hull]);
            let told = asked.deviation(&shapes).unwrap();
            let [position, sine, _] = measured(edited.shape(), &hull, Direction::U);
            assert!(
                told.distance >= position && told.angle.sin() >= 0.99 * sine,
                "{p} {q} {skew}: {told}, {position} {sine}"
            );
            done += 1;
        }
    }
    assert_eq!((done, refused.len()), (12, 0), "{refused:?}");
}

/// The largest of all is told where it is at an end: a sheet that twists away from another one along the edge.
#[test]
fn what_is_largest_at_an_end_is_told() {
    let line = || Space::clamped_uniform(1, 2).unwrap();
    let flat = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let flat = Surface::new(line(), line(), flat).unwrap();
    for end in [0.0, 1.0] {
        // At one end it goes straight on, at the other it rises by 20°.
        let rise = 20.0_f64.to_radians().tan();
        let z = |y: f64| if y == end { rise } else { 0.0 };
        let net = [[1.0, 0.0], [1.0, 1.0], [2.0, 0.0], [2.0, 1.0]];
        let net = net.map(|[x, y]| Point::new(x, y, if x > 1.0 { z(y) } else { 0.0 })).to_vec();
        let twisted = Surface::new(line(), line(), net).unwrap();
        let asked = matching(Edge::UStart, 1, Edge::UEnd, 1, Limits::default());
        let told = asked.deviation(&Shapes::new([&twisted as &dyn Shape, &flat])).unwrap();
        assert!((told.angle.to_degrees() - 20.0).abs() < 1e-9, "{end}: {told}");
    }
}

/// What is told of position, angle and curvature bounds what is found at 10,000 places, both ends and both sides of knots among them, and is no
/// more than that by a thousandth.
#[test]
fn what_is_told_is_the_largest_all_along_the_edge() {
    let number = |note: &str, what: &str| -> f64 {
        let rest = note.split(what).nth(1).unwrap();
        rest.split(['°', ' ', ',']).next().unwrap().parse().unwrap()
    };
    let mut at_ends = 0;
    for case in 0..8_u32 {
        let turn = f64::from(case);
        let sheet = |far: f64, p: usize, seed: f64| {
            let (u, v) = (Space::clamped_uniform(2, 4).unwrap(), Space::clamped_uniform(p, p + 2).unwrap());
            let columns = v.len();
            let at = |k: usize| {
                let (i, j) = ((k / columns) as f64, (k % columns) as f64);
                let wave = (1.7 * i + 2.3 * j * seed + turn).sin();
                Point::new(
                    far + i + 0.3 * wave,
                    2.0 * j + 0.4 * (wave * 5.0).cos(),
                    0.8 * (3.0 * wave + i).sin(),
                )
            };
            Surface::new(u, v, (0..4 * columns).map(at).collect()).unwrap()
        };
        // Degree 1 along the edge has corners at its knots.
        let p = [1, 2, 3, 4][case as usize % 4];
        let (a, b) = (sheet(0.0, p, 1.0), sheet(3.5, p, 1.3));
        let mut both = Scene::new();
        both.add(Object::new("a", a.clone().into())).unwrap();
        both.add(Object::new("b", b.into())).unwrap();
        let fields =
            json!({ "object": "b", "edge": "u0", "with": { "object": "a", "edge": "u1" }, "continuity": 0 });
        let notes = run(&mut both, fields).unwrap();
        let note = notes.iter().find(|note| note.contains("now: ")).unwrap();
        let b = both.surface("b").unwrap();
        let (low, high) = b.v().domain();
        let angle = |v: f64| {
            let of = |s: &Surface, u: f64| {
                let d = |i: usize, j: usize| s.derivative(u, v, i, j).unwrap();
                (d(1, 0), d(0, 1), d(1, 0).cross(&d(0, 1)).normalize())
            };
            let ((out, along, n), (inwards, _, m)) = (of(&a, a.u().domain().1), of(b, b.u().domain().0));
            let between = n.cross(&m).norm().atan2(n.dot(&m).abs());
            let square = |d: Vector| d - along * (d.dot(&along) / along.norm_squared());
            let folded = square(out).dot(&inwards) < 0.0;
            if folded { 180.0 - between.to_degrees() } else { between.to_degrees() }
        };
        let mut places: Vec<f64> =
            (0..=10_000).map(|k| low + (high - low) * f64::from(k) / 10_000.0).collect();
        for knot in b.v().breakpoints() {
            places.extend([knot - 1e-10, knot + 1e-10].iter().map(|v| v.clamp(low, high)));
        }
        let (mut largest, mut place) = (0.0_f64, low);
        for v in places {
            let found = angle(v.clamp(low, high));
            (largest, place) = if found > largest { (found, v) } else { (largest, place) };
        }
        let told = number(note, "angle ");
        assert!(
            (told - largest).abs() <= 1e-3 * largest,
            "{case}: told {told}, largest {largest} at {place}"
        );
        at_ends += usize::from(place == low || place == high);
    }
    assert!(at_ends >= 2, "{at_ends} are largest at an end");
}

/// Where nothing is there to be moved, the message says what is there: what stands still is no answer, but not nothing either.
#[test]
fn a_scene_without_another_surface_says_what_it_has() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let mut one = Scene::new();
    one.add(Object::new("c", circle.into())).unwrap();
    let fields = json!({ "edge": "u0", "with": { "object": "c", "edge": "u0" }, "tolerance": 0.1 });
    let told = run(&mut one, fields.clone()).unwrap_err();
    assert!(told.contains("the scene has no other surface: it has only \"c\", a curve"), "{told}");
    one.add(Object::new("d", Curve::circle(Point::origin(), Vector::x(), 2.0).unwrap().into())).unwrap();
    let told = run(&mut one, fields).unwrap_err();
    assert!(told.contains("the scene has no other surface: \"d\" is a curve"), "{told}");
}
