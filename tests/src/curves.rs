//! Curves and surfaces of every family, and the documents that hold them. The same on every run.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space};
use serde_json::{Value, json};

/// A small deterministic sequence of numbers in `[0, 1)`: `x ← 1664525 x + 1013904223 mod 2³²`.
#[derive(Debug, Clone)]
pub struct Sequence(u32);

impl Sequence {
    /// The sequence with this seed.
    pub fn new(seed: u32) -> Self {
        Self(seed)
    }

    /// Its next number.
    pub fn next_number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / 4_294_967_296.0
    }

    /// `count` knots with uneven spans.
    fn knots(&mut self, count: usize) -> Vec<f64> {
        let mut at = 4.0 * self.next_number();
        (0..count)
            .map(|_| {
                at += 0.5 + self.next_number();
                at
            })
            .collect()
    }

    fn points(&mut self, count: usize, size: f64) -> Vec<Point> {
        let turn = std::f64::consts::TAU / count as f64;
        (0..count)
            .map(|i| {
                let (sin, cos) = (turn * i as f64).sin_cos();
                let mut near = |x: f64| size * (x + 0.3 * self.next_number());
                Point::new(near(cos), near(sin), near(0.0))
            })
            .collect()
    }
}

/// The families: how the knots lie.
pub const FAMILIES: [&str; 5] = ["clamped", "uneven", "repeated", "floating", "periodic"];

/// A curve of a family, of about this size: `clamped` has even knots, the others uneven ones; `repeated` has one
/// interior knot twice.
///
/// # Panics
/// When there is no such family.
pub fn curve(family: &str, degree: usize, rational: bool, size: f64) -> Curve {
    let mut random = Sequence::new(17 * degree as u32 + u32::from(rational));
    let n = degree + 6;
    let space = match family {
        "clamped" => Space::clamped_uniform(degree, n),
        "uneven" | "repeated" => {
            let mut breakpoints = random.knots(n - degree + 1);
            if family == "repeated" && degree > 1 {
                breakpoints[3] = breakpoints[2];
            }
            Space::clamped(degree, &breakpoints)
        }
        "floating" => Space::open(degree, random.knots(n + degree + 1)),
        "periodic" => Space::periodic(degree, random.knots(n + 1)),
        other => panic!("no family {other}"),
    };
    let space = space.unwrap_or_else(|e| panic!("{family} of degree {degree}: {e}"));
    let points = random.points(n, size);
    let weights = rational.then(|| (0..n).map(|_| 0.5 + 1.5 * random.next_number()).collect());
    Curve::build(space, points, weights).unwrap_or_else(|e| panic!("{family} of degree {degree}: {e}"))
}

/// A curve as native documents hold it.
pub fn curve_json(curve: &Curve) -> Value {
    let mut out = json!({
        "degree": curve.degree(), "periodic": curve.is_periodic(), "knots": curve.space().knots(),
        "points": points_json(curve.points()),
    });
    if let Some(weights) = curve.weights() {
        out["weights"] = json!(weights);
    }
    out
}

/// The curve of a native document.
///
/// # Panics
/// When it is none.
pub fn curve_from_json(value: &Value) -> Curve {
    fn field<T: serde::de::DeserializeOwned>(value: &Value, name: &str) -> Option<T> {
        serde_json::from_value(value.get(name)?.clone()).ok()
    }
    let degree = field(value, "degree").unwrap_or(0);
    let knots = field(value, "knots").unwrap_or_default();
    let periodic = field(value, "periodic").unwrap_or(false);
    let space = if periodic { Space::periodic(degree, knots) } else { Space::open(degree, knots) };
    let points: Vec<[f64; 3]> = field(value, "points").unwrap_or_default();
    space
        .and_then(|s| Curve::build(s, points.into_iter().map(Point::from).collect(), field(value, "weights")))
        .unwrap_or_else(|e| panic!("no curve: {e} in {value}"))
}

/// Positions as native documents hold them.
pub fn points_json(points: &[Point]) -> Value {
    points.iter().map(|p| json!([p.x, p.y, p.z])).collect()
}

/// A native document of these objects, `{"name": …, "curve" | "surface" | "mesh": …}`, z up.
pub fn document(unit: &str, objects: &[Value]) -> Value {
    json!({ "loftsman": 1, "unit": unit, "up": "z", "objects": objects })
}

/// The surface of revolution of a wavy profile, `v` periodic or open around: rows along `u`, a bicubic net.
pub fn tube_json(around: usize, along: usize, closed: bool) -> Value {
    let turn = std::f64::consts::TAU / around as f64;
    let rows: Vec<Value> = (0..along)
        .map(|i| {
            let row: Vec<Value> = (0..around)
                .map(|j| {
                    let (sin, cos) = (turn * j as f64).sin_cos();
                    let radius = 1.0 + 0.2 * (i as f64).sin();
                    json!([radius * cos, radius * sin, 0.4 * i as f64])
                })
                .collect();
            json!(row)
        })
        .collect();
    let clamped: Vec<usize> = (0..along + 4).map(|k| k.saturating_sub(3).min(along - 3)).collect();
    let v: Vec<usize> = if closed {
        (0..=around).collect()
    } else {
        (0..around + 4).map(|k| k.saturating_sub(3).min(around - 3)).collect()
    };
    json!({
        "u": { "degree": 3, "periodic": false, "knots": clamped },
        "v": { "degree": 3, "periodic": closed, "knots": v },
        "points": rows,
    })
}

/// A box of six quadrangles with outward faces.
pub fn box_json(low: [f64; 3], high: [f64; 3]) -> Value {
    let corner = |i: usize| -> Vec<f64> {
        (0..3).map(|axis| if i >> axis & 1 == 1 { high[axis] } else { low[axis] }).collect()
    };
    json!({
        "points": (0..8).map(corner).collect::<Vec<_>>(),
        "faces": [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
    })
}
