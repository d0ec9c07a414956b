//! Offsets of outlines out of lines, arcs and splines against OpenCASCADE's and, where sharp corners stand beside arcs, closed forms: `golden/outlines.py` made the
//! numbers.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::collections::BTreeMap;

use loftsman_construction::{Corners, OffsetOptions, arc_through, offset};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/outlines.json")).unwrap()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(value: &Value) -> Vec<Point> {
    let point = |v: &Value| Point::new(v[0].as_f64().unwrap(), v[1].as_f64().unwrap(), 0.0);
    list(value).iter().map(point).collect()
}

/// Pieces one behind the other, as one curve.
fn wire(pieces: &[Value]) -> Curve {
    let piece = |piece: &Value| {
        if piece.get("line").is_some() {
            return Curve::new(Space::clamped_uniform(1, 2).unwrap(), points(&piece["line"])).unwrap();
        }
        if piece.get("arc").is_some() {
            let on = points(&piece["arc"]);
            return arc_through(on[0], on[1], on[2]).unwrap();
        }
        let degree = piece["degree"].as_u64().unwrap() as usize;
        let space = Space::open(degree, numbers(&piece["knots"])).unwrap();
        Curve::rational(space, points(&piece["spline"]), numbers(&piece["weights"])).unwrap()
    };
    let pieces: Vec<Curve> = pieces.iter().map(piece).collect();
    let degree = pieces.iter().map(Curve::degree).max().unwrap();
    let mut pieces = pieces.into_iter().map(|c| c.elevate(degree - c.degree()).unwrap());
    let first = pieces.next().unwrap();
    pieces.fold(first, |whole, piece| whole.join(&piece, 1e-9).unwrap().shape)
}

/// Twice the area to the left of a closed curve's way, by Gauss's rule on parts of its spans.
fn doubled_area(curve: &Curve) -> f64 {
    let rule = [
        (0.046910077030668, 0.118463442528095),
        (0.230765344947158, 0.239314335249683),
        (0.5, 0.284444444444444),
        (0.769234655052842, 0.239314335249683),
        (0.953089922969332, 0.118463442528095),
    ];
    let mut sum = 0.0;
    for span in curve.space().breakpoints().windows(2) {
        for part in 0..4 {
            let step = 0.25 * (span[1] - span[0]);
            for (x, weight) in rule {
                let at = span[0] + step * (f64::from(part) + x);
                let (p, d) = (curve.point(at).unwrap(), curve.derivative(at, 1).unwrap());
                sum += weight * step * (p.x * d.y - p.y * d.x);
            }
        }
    }
    sum
}

/// Relative: what OpenCASCADE's trims and integrals are good for.
const NEAR: f64 = 1e-7;
/// The tolerance that offsets are asked for with: no more than that may they be off by.
const FINE: f64 = 1e-7;

/// At how many of some places of an offset the source is not on the side where it is to be: to the left if moved to the right.
fn places_beside(found: &Curve, source: &Curve, to_the_right: bool) -> usize {
    let (a, b) = found.domain();
    let wrong = |k: &u8| {
        let at = a + (b - a) * (0.137 + 0.2 * f64::from(*k));
        let (p, along) = (found.point(at).unwrap(), found.derivative(at, 1).unwrap());
        let left = along.cross(&(source.closest(p).unwrap().point - p)).z > 0.0;
        left != to_the_right
    };
    (0..5).filter(wrong).count()
}

#[test]
fn outlines_move_as_those_of_opencascade() {
    let golden = golden();
    let wires: BTreeMap<&str, Curve> = golden["wires"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, pieces)| (name.as_str(), wire(list(pieces))))
        .collect();
    let (mut cases, mut places, mut wrong) = (0, 0, Vec::new());
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    for case in list(&golden["cases"]) {
        let name = case["wire"].as_str().unwrap();
        let (source, away) = (&wires[name], case["away"].as_f64().unwrap());
        let sharp = case["corners"] == "sharp";
        let corners = if sharp { Corners::Sharp } else { Corners::Round };
        let options = OffsetOptions { tolerance: Some(FINE), corners, normal: Some(Vector::z()), unit: None };
        let told = format!("{name} {away} {}", case["corners"]);
        cases += 1;
        let found = match offset(source, away, &options) {
            Ok(found) => found,
            Err(error) => {
                wrong.push(format!("{told}: {error}"));
                continue;
            }
        };
        // Those with corners too sharp to be prolonged are not among them.
        assert_eq!(found.blunted, 0, "{told}");
        let mut problem = |text: String| wrong.push(format!("{told}: {text}"));
        if found.curves.len() as u64 != case["loops"].as_u64().unwrap() {
            problem(format!("{} loops, not {}", found.curves.len(), case["loops"]));
        }
        let length: f64 = found.curves.iter().map(|c| c.length(1e-10).unwrap().value).sum();
        let theirs = case["length"].as_f64().unwrap();
        if found.deviation > FINE {
            problem(format!("{:.1e} off, more than was asked for", found.deviation));
        }
        if (length - theirs).abs() > NEAR * theirs + FINE {
            problem(format!("length {length}, not {theirs}: {:.1e}", length / theirs - 1.0));
        }
        let theirs = case.get("area").and_then(Value::as_f64);
        let clockwise = theirs.is_some() && doubled_area(source) < 0.0;
        // All run as the source does: outer ones the same way round, holes the other. Tips of sharp ones may be nearer to another part of the source.
        let beside: usize =
            found.curves.iter().map(|c| places_beside(c, source, (away > 0.0) != clockwise)).sum();
        if beside > 0 && !sharp {
            problem(format!("{beside} places run the other way"));
        }
        if theirs.is_none() {
            // Of an open one the one curve that there is begins and ends straight beside the source's ends, and sets out as that does.
            for (k, which) in ["begins", "ends"].into_iter().enumerate() {
                let end = |c: &Curve| [c.domain().0, c.domain().1][k];
                let (curve, at) = (&found.curves[0], end(source));
                let (p, along) = (source.point(at).unwrap(), source.derivative(at, 1).unwrap().normalize());
                let place = p + along.cross(&Vector::z()) * away;
                let apart = (curve.point(end(curve)).unwrap() - place).norm();
                let runs = curve.derivative(end(curve), 1).unwrap().normalize().dot(&along);
                if found.curves.len() != 1 || apart > NEAR || runs < 1.0 - NEAR {
                    problem(format!("{which} {apart:.1e} from where it is to, {runs} along the source"));
                }
            }
            // And hangs together.
            let torn = found.curves.iter().filter(|c| c.space().most_repeated() > c.degree()).count();
            if torn > 0 {
                problem("torn".into());
            }
        }
        if let Some(theirs) = theirs {
            let ends = |c: &Curve| (c.point(c.domain().0).unwrap() - c.point(c.domain().1).unwrap()).norm();
            if found.curves.iter().any(|c| ends(c) > 1e-12) {
                problem("open".into());
            }
            // A loop that runs the other way counts against the rest.
            let area = 0.5 * found.curves.iter().map(doubled_area).sum::<f64>();
            let area = if clockwise { -area } else { area };
            if (area - theirs).abs() > NEAR * theirs + FINE * length {
                problem(format!("area {area}, not {theirs}: {:.1e}", area / theirs - 1.0));
            }
        }
        let boxes = found.curves.iter().map(Curve::bounds);
        let (low, high) = boxes.reduce(|(l, h), (low, high)| (l.inf(&low), h.sup(&high))).unwrap();
        let theirs = points(&Value::from(vec![case["low"].clone(), case["high"].clone()]));
        let sides = (low - theirs[0]).amax().max((high - theirs[1]).amax());
        if sides > 1e-6 {
            problem(format!("its box is {sides:.1e} off"));
        }
        for p in points(&case["points"]) {
            let near =
                found.curves.iter().map(|c| c.closest(p).unwrap().distance).fold(f64::INFINITY, f64::min);
            if near > 1e-6 {
                problem(format!("{p} is {near:.1e} away"));
            }
            places += 1;
        }
        let open = if case.get("area").is_some() { "closed" } else { "open" };
        *kinds.entry(format!("{open} {}", case["corners"])).or_default() += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let formed = list(&golden["cases"]).iter().filter(|case| case.get("by").is_some()).count();
    assert_eq!(formed, 51);
    // Closed ones with round and with sharp corners, open ones likewise.
    let counts: Vec<usize> = kinds.values().copied().collect();
    assert_eq!(counts, [173, 160, 53, 18], "{kinds:?}");
    assert!(cases == 404 && places >= 3000, "{cases} {places}");
}
