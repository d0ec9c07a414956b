//! Every operation with random valid input, and the documents that it writes: checked by an evaluator that shares no code with
//! the kernel (`loftsman_tests::exact`). Refusals are counted, and bounded for each operation.

use std::collections::BTreeMap;

use loftsman::kernel::plugin::{Context, Parameters};
use loftsman::kernel::scene::{Object, Scene};
use loftsman::kernel::spline::Direction as KernelDirection;
use loftsman_tests::curves::Sequence;
use loftsman_tests::exact::{
    Direction, apart, curve_derivative, curve_point, numbers, object, surface_derivative, surface_point,
};
use serde_json::{Value, json};

const CASES: u32 = 24;

/// What a step did: the documents before and after, and what was asked. `Err` is the refusal's text.
struct Walk<'a> {
    random: &'a mut Sequence,
    folder: &'a std::path::Path,
}

impl Walk<'_> {
    fn number(&mut self) -> f64 {
        self.random.next_number()
    }

    fn up_to(&mut self, n: usize) -> usize {
        ((self.number() * n as f64) as usize).min(n - 1)
    }

    fn flip(&mut self) -> bool {
        self.number() < 0.5
    }

    /// A number between two others, with few digits.
    fn between(&mut self, a: f64, b: f64) -> f64 {
        let share = (self.number() * 1024.0).floor() / 1024.0;
        a + (b - a) * share
    }

    /// One direction of any family: clamped with knots up to `degree + tear` times, floating, periodic. With its number of
    /// vertices.
    fn direction(&mut self, most: usize, tear: usize) -> (Value, usize) {
        let degree = 1 + self.up_to(most);
        let family = self.up_to(3);
        let (mut knots, mut at) = (Vec::new(), self.between(-4.0, 4.0).round());
        let n = degree + 2 + self.up_to(6);
        match family {
            0 => {
                knots.extend(vec![at; degree + 1]);
                let mut inner = n - degree - 1;
                while inner > 0 {
                    at += self.between(0.25, 2.0);
                    let times = (1 + self.up_to(degree + tear)).min(inner);
                    knots.extend(vec![at; times]);
                    inner -= times;
                }
                at += self.between(0.25, 2.0);
                knots.extend(vec![at; degree + 1]);
            }
            _ => {
                let count = if family == 1 { n + degree + 1 } else { n + 1 };
                for _ in 0..count {
                    knots.push(at);
                    at += self.between(0.25, 2.0);
                }
            }
        }
        (json!({ "degree": degree, "periodic": family == 2, "knots": knots }), n)
    }

    fn point(&mut self, size: f64) -> Value {
        json!([self.between(-size, size), self.between(-size, size), self.between(-size, size)])
    }

    /// A curve of any family and of some size, rational or not.
    fn curve(&mut self, tear: usize) -> Value {
        let size = [1e-3, 1.0, 1e5][self.up_to(3)];
        let (mut curve, n) = self.direction(7, tear);
        curve["points"] = (0..n).map(|_| self.point(size)).collect();
        if self.flip() {
            curve["weights"] = (0..n).map(|_| json!(self.between(0.25, 4.0))).collect();
        }
        curve
    }

    fn surface(&mut self) -> Value {
        let size = [1e-3, 1.0, 1e5][self.up_to(3)];
        let ((u, n), (v, m)) = (self.direction(4, 0), self.direction(4, 0));
        let net: Value = (0..n).map(|_| (0..m).map(|_| self.point(size)).collect::<Value>()).collect();
        let mut surface = json!({ "u": u, "v": v, "points": net });
        if self.flip() {
            let row = |walk: &mut Self| (0..m).map(|_| json!(walk.between(0.25, 4.0))).collect::<Value>();
            surface["weights"] = (0..n).map(|_| row(self)).collect();
        }
        surface
    }

    /// A closed curve in the plane z = height that goes round the middle once.
    fn ring(&mut self, height: f64, size: f64) -> Value {
        let degree = 1 + self.up_to(4);
        let n = degree + 3 + self.up_to(5);
        let turn = std::f64::consts::TAU / n as f64;
        let point = |walk: &mut Self, i: usize| {
            let (r, angle) = (size * walk.between(0.8, 1.2), turn * i as f64);
            json!([r * angle.cos(), r * angle.sin(), height])
        };
        let points: Value = (0..n).map(|i| point(self, i)).collect();
        json!({ "degree": degree, "periodic": true, "knots": (0..=n).collect::<Vec<_>>(), "points": points })
    }

    fn document(&self, objects: &[(&str, &str, &Value)]) -> (Scene, Value) {
        let objects: Vec<_> =
            objects.iter().map(|(name, kind, what)| json!({ "name": name, *kind: what })).collect();
        let text = json!({ "loftsman": 1, "objects": objects }).to_string();
        let path = self.folder.join("in.loft.json");
        std::fs::write(&path, &text).unwrap();
        (loftsman::read_scene(&path).unwrap(), serde_json::from_str(&text).unwrap())
    }

    fn written(&self, scene: &Scene) -> Value {
        let path = self.folder.join("out.loft.json");
        loftsman::write(scene, &path).unwrap();
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    /// Runs a step on these objects; the document after it.
    fn run(&self, objects: &[(&str, &str, &Value)], op: &str, fields: Value) -> Result<Value, String> {
        let (mut scene, _) = self.document(objects);
        let before = scene.clone();
        let registry = loftsman::registry();
        let operation = registry.find_operation(op, "op").unwrap();
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        parameters.check(operation.declaration().fields).unwrap();
        match operation.apply(&mut scene, &parameters, &Context::quiet(registry)) {
            Ok(_) => Ok(self.written(&scene)),
            Err(error) => {
                assert_eq!(scene, before, "{op}: a failed step must leave the scene alone");
                Err(error.to_string())
            }
        }
    }

    fn parameters(&mut self, curve: &Value, count: usize) -> Vec<f64> {
        let (a, b) = Direction::new(curve).domain();
        (0..count).map(|_| self.between(a, b)).collect()
    }
}

fn size_of(spline: &Value) -> f64 {
    fn largest(value: &Value) -> f64 {
        match value {
            Value::Array(list) => list.iter().map(largest).fold(0.0, f64::max),
            other => other.as_f64().unwrap().abs(),
        }
    }
    largest(&spline["points"])
}

type Outcome = Result<(), String>;

/// Two curves are the same within `near` of their size, at the parameters that `map` gives.
fn same_curve(before: &Value, after: &Value, at: &[f64], map: impl Fn(f64) -> f64, near: f64) {
    for &u in at {
        let (a, b) = (curve_point(before, u), curve_point(after, map(u)));
        assert!(apart(a, b) <= near * size_of(before), "at {u}: {a:?} {b:?}\n{before}\n{after}");
    }
}

/// What the test's own evaluator says of something asked: how far it is missed, beside how large that may be.
type Judge = Box<dyn Fn(&Value, &Value) -> f64>;

/// A curve or a surface, as documents have them.
struct Patient {
    kind: &'static str,
    shape: Value,
    size: f64,
    /// The degree along u and v, and the shortest distance of knots.
    degrees: [usize; 2],
    gap: f64,
}

impl Patient {
    fn new(walk: &mut Walk<'_>) -> Self {
        let (kind, shape) = if walk.flip() { ("curve", walk.curve(0)) } else { ("surface", walk.surface()) };
        let degree = |d: &Value| d["degree"].as_u64().unwrap() as usize;
        let size = size_of(&shape);
        let degrees = match kind {
            "curve" => [degree(&shape), 0],
            _ => [degree(&shape["u"]), degree(&shape["v"])],
        };
        Self { kind, shape, size, degrees, gap: 0.25 }
    }

    fn is_curve(&self) -> bool {
        self.kind == "curve"
    }

    fn place(&self, walk: &mut Walk<'_>) -> Vec<f64> {
        if self.is_curve() {
            return walk.parameters(&self.shape, 1);
        }
        vec![walk.parameters(&self.shape["u"], 1)[0], walk.parameters(&self.shape["v"], 1)[0]]
    }

    /// How large a derivative of these orders can be, of rational shapes too.
    fn large(&self, orders: [usize; 2]) -> f64 {
        let [p, q] = self.degrees.map(|d| 16.0 * d.max(1) as f64 / self.gap);
        self.size * p.powi(orders[0] as i32) * q.powi(orders[1] as i32)
    }

    /// The vertices in the order of their numbers.
    fn vertices(shape: &Value) -> Vec<[f64; 3]> {
        numbers_of(&shape["points"]).chunks(3).map(|c| [c[0], c[1], c[2]]).collect()
    }
}

fn at_place(shape: &Value, at: &[f64], orders: [usize; 2]) -> [f64; 3] {
    match *at {
        [u, v] => surface_derivative(shape, [u, v], orders),
        _ => curve_derivative(shape, at[0], orders[0]),
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// Wishes that a vector may meet, and what they come to: on all axes or one, exactly or on one side.
fn wish(
    walk: &mut Walk<'_>,
    table: &mut Value,
    step: f64,
    large: f64,
    value: impl Fn(&Value) -> [f64; 3] + 'static,
) -> Judge {
    let by: [f64; 3] = [0, 1, 2].map(|_| walk.between(-step, step));
    let axis = [None, None, Some(0), Some(1), Some(2)][walk.up_to(5)];
    let number = |v: [f64; 3]| axis.map_or_else(|| json!(v), |k| json!(v[k]));
    if let Some(k) = axis {
        table["axis"] = json!(["x", "y", "z"][k]);
    }
    let factor = walk.between(0.5, 1.5);
    let word = ["to", "by", "scale", "keep", "at_least", "at_most"][walk.up_to(6)];
    // The value before is not known here: `to` and the bounds aim at values of their own, near nothing.
    table[word] = match word {
        "scale" => json!(factor),
        "keep" => json!(true),
        _ => number(by),
    };
    Box::new(move |before, after| {
        let (was, is) = (value(before), value(after));
        (0..3)
            .filter(|&k| axis.is_none_or(|only| only == k))
            .map(|k| match word {
                "to" => (is[k] - by[k]).abs(),
                "by" => (is[k] - was[k] - by[k]).abs(),
                "scale" => (is[k] - factor * was[k]).abs(),
                "keep" => (is[k] - was[k]).abs(),
                "at_least" => (by[k] - is[k]).max(0.0),
                _ => (is[k] - by[k]).max(0.0),
            })
            .fold(0.0, f64::max)
            / large
    })
}

/// Something linear asked of a shape, and who judges it.
fn linear(walk: &mut Walk<'_>, patient: &Patient) -> (Value, Judge) {
    let at = patient.place(walk);
    let place = if patient.is_curve() { json!(at[0]) } else { json!(at) };
    let kinds = if patient.is_curve() {
        ["position", "derivative", "tangent", "orthogonal", "vertex", "linear"]
    } else {
        ["position", "derivative", "normal", "position", "vertex", "linear"]
    };
    let kind = kinds[walk.up_to(6)];
    let mut table = json!({ "kind": kind });
    if !matches!(kind, "vertex" | "linear") {
        table["at"] = place;
    }
    let way: [f64; 3] = [0, 1, 2].map(|k| walk.between(-1.0, 1.0) + if k == 0 { 1.5 } else { 0.0 });
    let vertices = Patient::vertices(&patient.shape);
    let judge: Judge = match kind {
        "position" => {
            let large = patient.size;
            wish(walk, &mut table, 0.3 * patient.size, large, move |s| at_place(s, &at, [0, 0]))
        }
        "derivative" => {
            let orders = match patient.degrees {
                [p, 0] => [1 + walk.up_to(p.min(3)), 0],
                [p, q] => {
                    let i = walk.up_to(p.min(2) + 1);
                    [i, if i == 0 { 1 + walk.up_to(q.min(2)) } else { walk.up_to(2) }]
                }
            };
            table["order"] = if patient.is_curve() { json!(orders[0]) } else { json!(orders) };
            let large = patient.large(orders);
            wish(walk, &mut table, 0.3 * patient.size, large, move |s| at_place(s, &at, orders))
        }
        "tangent" => {
            let said = walk.flip();
            if said {
                table["direction"] = json!(way);
            }
            if walk.flip() || !said {
                table["keep"] = json!(true);
            }
            let large = patient.large([1, 0]);
            Box::new(move |before, after| {
                let old = at_place(before, &at, [1, 0]);
                let to = if said { way } else { old };
                let all = cross(at_place(after, &at, [1, 0]), to);
                all.iter().fold(0.0, |m: f64, v| m.max(v.abs())) / (large * dot(to, to).sqrt())
            })
        }
        "orthogonal" => {
            table["to"] = json!(way);
            let large = patient.large([1, 0]);
            Box::new(move |_, after| dot(at_place(after, &at, [1, 0]), way).abs() / large)
        }
        "normal" => {
            table["to"] = json!(way);
            let large = patient.large([1, 0]).max(patient.large([0, 1]));
            Box::new(move |_, after| {
                let along = |orders| dot(at_place(after, &at, orders), way).abs();
                along([1, 0]).max(along([0, 1])) / large
            })
        }
        "vertex" => {
            let index = walk.up_to(vertices.len());
            let back = walk.flip();
            table["index"] = json!(index as i64 - if back { vertices.len() as i64 } else { 0 });
            wish(walk, &mut table, 0.3 * patient.size, patient.size, move |s| Patient::vertices(s)[index])
        }
        _ => {
            let terms: Vec<(usize, [f64; 3])> = (0..1 + walk.up_to(3))
                .map(|_| (walk.up_to(vertices.len()), [0, 1, 2].map(|_| walk.between(-2.0, 2.0))))
                .collect();
            table["terms"] = terms.iter().map(|(v, c)| json!({ "vertex": v, "vector": c })).collect();
            let sum = move |s: &Value| {
                let all = Patient::vertices(s);
                terms.iter().map(|(v, c)| dot(all[*v], *c)).sum::<f64>()
            };
            let (by, kept, large) =
                (walk.between(-0.5, 0.5) * patient.size, walk.flip(), 20.0 * patient.size);
            if kept {
                table["keep"] = json!(true);
            } else {
                table["by"] = json!(by);
            }
            Box::new(move |before, after| {
                (sum(after) - sum(before) - if kept { 0.0 } else { by }).abs() / large
            })
        }
    };
    (table, judge)
}

/// Up to three linear things asked of a shape of any family, with any solver: each as the test's own evaluator sees it.
fn asked(walk: &mut Walk<'_>, op: &str, more: impl Fn(&mut Walk<'_>, &Patient) -> Value) -> Outcome {
    let patient = Patient::new(walk);
    let (mut tables, mut judges) = (Vec::new(), Vec::new());
    for _ in 0..1 + walk.up_to(3) {
        let (table, judge) = linear(walk, &patient);
        tables.push(table);
        judges.push(judge);
    }
    let mut fields = more(walk, &patient);
    let solvers: Vec<&str> = loftsman::registry().solvers().iter().map(|s| s.name()).collect();
    fields["solver"] = json!(solvers[walk.up_to(solvers.len())]);
    fields["constraints"] = json!(tables);
    let after = match walk.run(&[("c", patient.kind, &patient.shape)], op, fields.clone()) {
        // Told for what it is: a solver for few equations.
        Err(error) if error.contains("too many for the solver \"adjoint\"") => return Ok(()),
        other => other.map_err(|e| format!("{fields}: {e}"))?,
    };
    let after = &object(&after, "c")[patient.kind];
    for (judge, table) in judges.iter().zip(&tables) {
        let missed = judge(&patient.shape, after);
        assert!(
            missed <= 1e-9,
            "{op}: missed by {missed:e} of its size: {table} in {fields}\n{}",
            patient.shape
        );
    }
    Ok(())
}

fn edit(walk: &mut Walk<'_>) -> Outcome {
    asked(walk, "edit", |walk, _| {
        let metric = ["least", "stretch", "bend"][walk.up_to(3)];
        json!({ "metric": metric })
    })
}

fn drag(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let at = walk.parameters(&curve, 1)[0];
    let size = size_of(&curve);
    let path: Vec<Value> = (0..3).map(|_| walk.point(size)).collect();
    let fields = json!({ "handle": { "kind": "position", "at": at }, "path": path, "frames": true });
    let after = walk.run(&[("c", "curve", &curve)], "drag", fields)?;
    let whole = object(&after, "c");
    let goal = numbers(&path[2]);
    assert!(apart(curve_point(&whole["curve"], at), [goal[0], goal[1], goal[2]]) <= 1e-12 * size);
    let frames = whole["animation"]["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    for (frame, goal) in frames.iter().skip(1).zip(&path) {
        let mut shown = whole["curve"].clone();
        shown["points"] = frame.clone();
        let goal = numbers(goal);
        assert!(apart(curve_point(&shown, at), [goal[0], goal[1], goal[2]]) <= 1e-12 * size);
    }
    Ok(())
}

fn fair(walk: &mut Walk<'_>) -> Outcome {
    if walk.flip() {
        return asked(walk, "fair", |walk, patient| {
            // An energy of derivatives that the degrees have.
            let least = patient.degrees.into_iter().filter(|p| *p > 0).min().unwrap();
            let energy = ["stretch", "bend", "variation"][walk.up_to(least.min(3))];
            json!({ "energy": energy })
        });
    }
    // What is kept holds already: the energy can only become less.
    let curve = walk.curve(0);
    let at = walk.parameters(&curve, 2);
    let degree = curve["degree"].as_u64().unwrap() as usize;
    let order = 1 + walk.up_to(degree.min(3));
    let energy = ["stretch", "bend", "variation"][order - 1];
    let constraints: Vec<_> =
        at.iter().map(|u| json!({ "kind": "position", "at": u, "keep": true })).collect();
    let fields = json!({ "energy": energy, "constraints": constraints });
    let after = walk.run(&[("c", "curve", &curve)], "fair", fields)?;
    let after = &object(&after, "c")["curve"];
    for u in at {
        let error = apart(curve_point(after, u), curve_point(&curve, u));
        assert!(error <= 1e-9 * size_of(&curve), "{error:e} at {u} {energy}\n{curve}");
    }
    // By the rectangles' midpoints, as many on either side of every knot.
    let (a, b) = Direction::new(&curve).domain();
    let mut ends: Vec<f64> = numbers(&curve["knots"]).into_iter().filter(|k| (a..=b).contains(k)).collect();
    ends.extend([a, b]);
    ends.sort_by(f64::total_cmp);
    let of = |curve: &Value| -> f64 {
        let spans = ends.windows(2).filter(|w| w[0] < w[1]);
        let nodes = spans
            .flat_map(|w| (0..6).map(|i| (w[0] + (w[1] - w[0]) * (f64::from(i) + 0.5) / 6.0, w[1] - w[0])));
        nodes
            .map(|(u, h)| {
                let d = curve_derivative(curve, u, order);
                h * dot(d, d)
            })
            .sum()
    };
    let (was, is) = (of(&curve), of(after));
    assert!(is <= 1.1 * was, "{energy} {is:e} from {was:e}\n{curve}");
    Ok(())
}

fn fit(walk: &mut Walk<'_>) -> Outcome {
    let count = 8 + walk.up_to(60);
    let (turns, noise) = (walk.between(0.2, 1.5), walk.between(0.0, 0.02));
    let points: Vec<Value> = (0..count)
        .map(|i| {
            let t = turns * std::f64::consts::TAU * i as f64 / count as f64;
            let r = 1.0 + 0.2 * t + noise * (walk.number() - 0.5);
            json!([r * t.cos(), r * t.sin(), 0.1 * t])
        })
        .collect();
    let tolerance = walk.between(0.005, 0.05);
    let fields = json!({ "object": "p", "tolerance": tolerance, "degree": 2 + walk.up_to(3) });
    let after = walk.run(&[("p", "cloud", &json!({ "points": points }))], "fit", fields)?;
    let after = &object(&after, "p")["curve"];
    let (a, b) = Direction::new(after).domain();
    let samples: Vec<_> =
        (0..=600).map(|i| curve_derivative(after, a + (b - a) * f64::from(i) / 600.0, 0)).collect();
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let long: f64 = samples.windows(2).map(|w| distance(&w[0], &w[1])).sum();
    let polygon: Vec<[f64; 3]> = points.iter().map(numbers).map(|p| [p[0], p[1], p[2]]).collect();
    let around: f64 = polygon.windows(2).map(|w| distance(&w[0], &w[1])).sum();
    assert!(long <= 1.5 * around, "{long} of {around}");
    for p in &polygon {
        let near = samples.iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
        assert!(near <= tolerance + long / 600.0, "{near} of {tolerance}");
    }
    Ok(())
}

fn refine(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(1);
    let at = walk.parameters(&curve, 12);
    let knots = walk.parameters(&curve, 3);
    let after = walk.run(&[("c", "curve", &curve)], "refine", json!({ "knots": knots }))?;
    let after = &object(&after, "c")["curve"];
    assert_eq!(Direction::new(after).count(), Direction::new(&curve).count() + 3);
    same_curve(&curve, after, &at, |u| u, 1e-13);
    Ok(())
}

fn elevate(walk: &mut Walk<'_>) -> Outcome {
    if walk.flip() {
        let surface = walk.surface();
        let after = walk.run(&[("s", "surface", &surface)], "elevate", json!({}))?;
        let after = &object(&after, "s")["surface"];
        for _ in 0..6 {
            let (u, v) = (walk.parameters(&surface["u"], 1)[0], walk.parameters(&surface["v"], 1)[0]);
            let error = apart(surface_point(&surface, u, v), surface_point(after, u, v));
            assert!(error <= 1e-13 * size_of(&surface), "{error:e}");
        }
        return Ok(());
    }
    let curve = walk.curve(1);
    let at = walk.parameters(&curve, 12);
    let by = 1 + walk.up_to(3);
    let after = walk.run(&[("c", "curve", &curve)], "elevate", json!({ "by": by }))?;
    let after = &object(&after, "c")["curve"];
    assert_eq!(after["degree"].as_u64(), curve["degree"].as_u64().map(|p| p + by as u64));
    same_curve(&curve, after, &at, |u| u, 1e-12);
    Ok(())
}

fn reverse(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let at = walk.parameters(&curve, 12);
    let after = walk.run(&[("c", "curve", &curve)], "reverse", json!({}))?;
    let after = &object(&after, "c")["curve"];
    let ((a, b), (c, d)) = (Direction::new(&curve).domain(), Direction::new(after).domain());
    // Just beside a knot the mirrored parameter may be on its other side: no jump, since nothing is torn here.
    same_curve(&curve, after, &at, |u| (c + d - (u - a) * (d - c) / (b - a) - c).clamp(c, d), 1e-9);
    Ok(())
}

fn split(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let (a, b) = Direction::new(&curve).domain();
    let at = walk.between(a + 0.2 * (b - a), a + 0.8 * (b - a));
    let places = walk.parameters(&curve, 12);
    let after = walk.run(&[("c", "curve", &curve)], "split", json!({ "at": at }))?;
    let pieces: Vec<&Value> = after["objects"].as_array().unwrap().iter().map(|o| &o["curve"]).collect();
    let mut seen = 0;
    for piece in pieces {
        let (c, d) = Direction::new(piece).domain();
        for &u in &places {
            // A periodic curve is cut open: its piece goes on beyond the end of the period.
            for u in [u, u + (b - a), u - (b - a)].into_iter().filter(|u| *u >= c && *u <= d) {
                let inside = if u > b {
                    u - (b - a)
                } else if u < a {
                    u + (b - a)
                } else {
                    u
                };
                let error = apart(curve_point(piece, u), curve_point(&curve, inside));
                assert!(error <= 1e-12 * size_of(&curve), "{error:e}");
                seen += 1;
            }
        }
    }
    assert!(seen >= places.len());
    Ok(())
}

fn simplify(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let knots = walk.parameters(&curve, 4);
    let finer = walk.run(&[("c", "curve", &curve)], "refine", json!({ "knots": knots }))?;
    let finer = object(&finer, "c")["curve"].clone();
    let after = walk.run(&[("c", "curve", &finer)], "simplify", json!({}))?;
    let after = &object(&after, "c")["curve"];
    if Direction::new(after).count() > Direction::new(&curve).count() {
        return Err("a knot was left that rounding had made needed".to_owned());
    }
    let at = walk.parameters(&curve, 12);
    same_curve(&curve, after, &at, |u| u, 1e-11);
    Ok(())
}

fn transform(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(1);
    let at = walk.parameters(&curve, 6);
    let (scale, shift) = (walk.between(0.5, 3.0), walk.point(size_of(&curve)));
    let quarter = json!({ "axis": [0, 0, walk.between(0.5, 1e3)], "degrees": 90 });
    let fields = json!({ "scale": scale, "rotate": quarter, "translate": shift });
    let after = walk.run(&[("c", "curve", &curve)], "transform", fields)?;
    let after = &object(&after, "c")["curve"];
    let shift = numbers(&shift);
    for u in at {
        let [x, y, z] = curve_point(&curve, u);
        let wanted = [-scale * y + shift[0], scale * x + shift[1], scale * z + shift[2]];
        assert!(apart(curve_point(after, u), wanted) <= 1e-13 * 5.0 * size_of(&curve));
    }
    Ok(())
}

/// The volume that a mesh encloses, and whether each edge has two faces that run against each other.
fn enclosed(mesh: &Value) -> (f64, bool) {
    let points: Vec<Vec<f64>> = mesh["points"].as_array().unwrap().iter().map(numbers).collect();
    let mut edges: BTreeMap<(u64, u64), i32> = BTreeMap::new();
    let mut six = 0.0;
    for face in mesh["faces"].as_array().unwrap() {
        let f: Vec<u64> = face.as_array().unwrap().iter().map(|i| i.as_u64().unwrap()).collect();
        for k in 0..f.len() {
            let (a, b) = (f[k], f[(k + 1) % f.len()]);
            *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            if k >= 1 && k + 1 < f.len() {
                let (p, q, r) = (&points[f[0] as usize], &points[a as usize], &points[b as usize]);
                six += p[0] * (q[1] * r[2] - q[2] * r[1])
                    + p[1] * (q[2] * r[0] - q[0] * r[2])
                    + p[2] * (q[0] * r[1] - q[1] * r[0]);
            }
        }
    }
    (six / 6.0, edges.values().all(|sum| *sum == 0))
}

/// The area inside a plane ring by many chords.
fn area_inside(ring: &Value) -> f64 {
    let (a, b) = Direction::new(ring).domain();
    let points: Vec<_> =
        (0..400).map(|i| curve_derivative(ring, a + (b - a) * f64::from(i) / 400.0, 0)).collect();
    let pairs = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * pairs.map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>()
}

fn fill(walk: &mut Walk<'_>) -> Outcome {
    let ring = walk.ring(0.5, 1.0);
    let fields = json!({ "objects": ["r"], "tolerance": 0.001, "name": "filled" });
    let after = walk.run(&[("r", "curve", &ring)], "fill", fields)?;
    let mesh = &object(&after, "filled")["mesh"];
    assert!(mesh["points"].as_array().unwrap().iter().all(|p| (numbers(p)[2] - 0.5).abs() < 1e-12));
    // Closed by a cone to the origin it encloses a third of its area times its height.
    let (cone, _) = enclosed(mesh);
    assert!((cone.abs() - area_inside(&ring).abs() * 0.5 / 3.0).abs() < 0.002 * 7.0, "{cone}");
    Ok(())
}

fn extrude(walk: &mut Walk<'_>) -> Outcome {
    let ring = walk.ring(0.0, 1.0);
    let height = walk.between(0.5, 3.0);
    let fields = json!({ "objects": ["r"], "by": [0, 0, height], "tolerance": 0.001, "name": "solid" });
    let after = walk.run(&[("r", "curve", &ring)], "extrude", fields)?;
    let (volume, closed) = enclosed(&object(&after, "solid")["mesh"]);
    assert!(closed);
    let exact = area_inside(&ring).abs() * height;
    assert!((volume - exact).abs() < 0.002 * 7.0 * height, "{volume} {exact}");
    Ok(())
}

fn loft(walk: &mut Walk<'_>) -> Outcome {
    let mut rings = vec![];
    for k in 0..3 {
        let mut ring = walk.ring(f64::from(k), 1.0);
        // Begun anywhere, gone round either way.
        let points = ring["points"].as_array_mut().unwrap();
        let turn = walk.up_to(points.len());
        points.rotate_left(turn);
        if walk.flip() {
            points.reverse();
        }
        rings.push(ring);
    }
    let objects: Vec<_> = ["a", "b", "c"].into_iter().zip(&rings).map(|(n, r)| (n, "curve", r)).collect();
    let fields = json!({ "sections": ["a", "b", "c"], "degree": 1, "tolerance": 0.002, "name": "hull" });
    let after = walk.run(&objects, "loft", fields)?;
    let (volume, closed) = enclosed(&object(&after, "hull")["mesh"]);
    assert!(closed);
    // Between two sections the area is at least about the smaller one's, and at most the larger one's.
    let areas: Vec<f64> = rings.iter().map(|r| area_inside(r).abs()).collect();
    let low = areas[0].min(areas[1]) + areas[1].min(areas[2]);
    let high = areas[0].max(areas[1]) + areas[1].max(areas[2]);
    assert!(volume > 0.8 * low && volume < 1.1 * high, "{volume} is not between {low} and {high}");
    Ok(())
}

/// A ring round the middle and a line through it: two points, each on both.
fn intersect(walk: &mut Walk<'_>) -> Outcome {
    let ring = walk.ring(0.0, 1.0);
    let angle = walk.between(0.0, 6.0);
    let (x, y) = (3.0 * angle.cos(), 3.0 * angle.sin());
    let line =
        json!({ "degree": 1, "periodic": false, "knots": [0, 0, 1, 1], "points": [[-x, -y, 0], [x, y, 0]] });
    let fields = json!({ "object": "l", "with": "r", "name": "both" });
    let after = walk.run(&[("l", "curve", &line), ("r", "curve", &ring)], "intersect", fields)?;
    let points = object(&after, "both")["cloud"]["points"].as_array().unwrap().clone();
    assert!(!points.is_empty(), "{ring}");
    let samples: Vec<_> =
        walk.parameters(&ring, 4000).into_iter().map(|u| curve_derivative(&ring, u, 0)).collect();
    for p in points.iter().map(numbers) {
        assert!((p[0] * y - p[1] * x).abs() < 1e-8, "{p:?} is not on the line");
        let near = samples.iter().map(|s| (s[0] - p[0]).hypot(s[1] - p[1])).fold(f64::INFINITY, f64::min);
        assert!(near < 0.02, "{p:?} is {near} from the ring");
    }
    Ok(())
}

/// Every point of a section is in the plane; where the surface changes sides there is a section.
fn section(walk: &mut Walk<'_>) -> Outcome {
    let surface = walk.surface();
    let (low, high) =
        surface["points"].as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(low, high), p| {
                let z = numbers(p)[2];
                (low.min(z), high.max(z))
            },
        );
    let at = walk.between(low, high);
    let fields = json!({ "object": "s", "axis": "z", "at": at, "name": "cut" });
    let after = walk.run(&[("s", "surface", &surface)], "section", fields)?;
    for found in after["objects"].as_array().unwrap().iter().filter(|o| o["name"] != "s") {
        let curve = &found["curve"];
        for u in walk.parameters(curve, 10) {
            let p = curve_point(curve, u);
            assert!((p[2] - at).abs() <= 2e-6 * (high - low).max(at.abs()), "{p:?} is not at {at}");
        }
    }
    Ok(())
}

fn tessellate(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let size = size_of(&curve);
    let tolerance = 0.01 * size;
    let after = walk.run(&[("c", "curve", &curve)], "tessellate", json!({ "tolerance": tolerance }))?;
    let line = &object(&after, "c")["polyline"];
    let points: Vec<Vec<f64>> = line["points"].as_array().unwrap().iter().map(numbers).collect();
    let closed = line["closed"] == true;
    let chords = if closed { points.len() } else { points.len() - 1 };
    for u in walk.parameters(&curve, 20) {
        let p = curve_point(&curve, u);
        let near = (0..chords).map(|k| to_chord(p, &points[k], &points[(k + 1) % points.len()]));
        let near = near.fold(f64::INFINITY, f64::min);
        assert!(near <= 1.001 * tolerance, "{near} of {tolerance}");
    }
    Ok(())
}

fn tube(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let size = size_of(&curve);
    let (radius, sides) = (0.002 * size, 12);
    let caps = ["flat", "round"][walk.up_to(2)];
    let fields = json!({ "radius": radius, "sides": sides, "tolerance": 1e-4 * size, "caps": caps });
    let after = walk.run(&[("c", "curve", &curve)], "tube", fields)?;
    let mesh = &object(&after, "c tube")["mesh"];
    let (a, b) = Direction::new(&curve).domain();
    let line: Vec<[f64; 3]> =
        (0..=4000).map(|k| curve_point(&curve, a + (b - a) * f64::from(k) / 4000.0)).collect();
    // At corners the points are in the plane half way, three radii away at most.
    for p in numbers_of(&mesh["points"]).chunks(3).step_by(11) {
        let near = line.windows(2).map(|c| to_chord([p[0], p[1], p[2]], &c[0], &c[1]));
        let near = near.fold(f64::INFINITY, f64::min);
        assert!(near <= 3.2 * radius, "{near} of {radius}: {curve}");
    }
    let (volume, closed) = enclosed(mesh);
    assert!(closed, "{curve}");
    // Pappus: what one side of a bend has less the other has more, where the bend leaves room for it.
    let tight = (0..=4000).any(|k| {
        let u = a + (b - a) * f64::from(k) / 4000.0;
        let [first, second] = [1, 2].map(|order| curve_derivative(&curve, u, order));
        let speed = dot(first, first).sqrt();
        let bent = cross(first, second);
        dot(bent, bent).sqrt() * radius >= speed.powi(3)
    });
    if tight {
        return Ok(());
    }
    let length: f64 =
        line.windows(2).map(|c| (0..3).map(|k| (c[1][k] - c[0][k]).powi(2)).sum::<f64>().sqrt()).sum();
    let across = 0.5 * f64::from(sides) * radius * radius * (std::f64::consts::TAU / f64::from(sides)).sin();
    let share = volume / (length * across);
    assert!((0.9..1.1).contains(&share), "{share} of the volume: {curve}");
    Ok(())
}

fn to_chord(p: [f64; 3], a: &[f64], b: &[f64]) -> f64 {
    let along: f64 = (0..3).map(|k| (b[k] - a[k]) * (p[k] - a[k])).sum();
    let length: f64 = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum();
    let t = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
    (0..3).map(|k| (a[k] + t * (b[k] - a[k]) - p[k]).powi(2)).sum::<f64>().sqrt()
}

fn scene_keeping(walk: &mut Walk<'_>, op: &str, fields: &Value, names: &[&str]) -> Outcome {
    let (curve, surface) = (walk.curve(1), walk.surface());
    let after = walk.run(&[("c", "curve", &curve), ("s", "surface", &surface)], op, fields.clone())?;
    let found: Vec<&str> =
        after["objects"].as_array().unwrap().iter().map(|o| o["name"].as_str().unwrap()).collect();
    assert_eq!(sorted(&found), sorted(names), "{op}");
    // Whatever its name, every number is as it was; a copy says whose it has.
    for o in after["objects"].as_array().unwrap() {
        let o = o["same_as"]["object"].as_str().map_or(o, |first| object(&after, first));
        let (kind, was) = if o.get("curve").is_some() { ("curve", &curve) } else { ("surface", &surface) };
        assert_eq!(numbers_of(&o[kind]["points"]), numbers_of(&was["points"]));
    }
    Ok(())
}

/// Another document beside the first: its objects come along, to the bit, under free names.
fn merge(walk: &mut Walk<'_>) -> Outcome {
    let (curve, surface, other) = (walk.curve(1), walk.surface(), walk.curve(1));
    let path = walk.folder.join("other.loft.json");
    let objects = json!([{ "name": "c", "curve": other }, { "name": "d", "surface": surface }]);
    std::fs::write(&path, json!({ "loftsman": 1, "objects": objects }).to_string()).unwrap();
    let after = walk.run(&[("c", "curve", &curve)], "merge", json!({ "file": path }))?;
    for (name, kind, was) in [("c", "curve", &curve), ("c.001", "curve", &other), ("d", "surface", &surface)]
    {
        assert_eq!(numbers_of(&object(&after, name)[kind]["points"]), numbers_of(&was["points"]), "{name}");
    }
    assert_eq!(after["objects"].as_array().unwrap().len(), 3);
    Ok(())
}

fn sorted<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let mut all = names.to_vec();
    all.sort_unstable();
    all
}

fn numbers_of(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers_of).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

fn untrim(walk: &mut Walk<'_>) -> Outcome {
    let surface = walk.surface();
    // Nothing is trimmed: refused by name. (Trimmed surfaces come from OBJ; `untrim` is tested with those.)
    let refused = walk.run(&[("s", "surface", &surface)], "untrim", json!({})).unwrap_err();
    assert!(refused.contains("trimmed surface"), "{refused}");
    Ok(())
}

fn fine_tune(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let alpha = walk.between(0.3, 2.5);
    let tuned = walk.run(&[("c", "curve", &curve)], "fine-tune", json!({ "alpha": alpha, "ends": "free" }));
    if curve.get("weights").is_some() {
        let refused = tuned.unwrap_err();
        assert!(refused.contains("rational"), "{refused}");
        return Ok(());
    }
    // A constant scales the curve about its start.
    let after = tuned?;
    let after = &object(&after, "c")["curve"];
    let start = curve_point(&curve, Direction::new(&curve).domain().0);
    for u in walk.parameters(&curve, 6) {
        let [x, y, z] = curve_point(&curve, u);
        let wanted = [0, 1, 2].map(|k| start[k] + alpha * ([x, y, z][k] - start[k]));
        let error = apart(curve_point(after, u), wanted);
        assert!(error <= 1e-10 * size_of(&curve), "{error:e} at {u} of {curve}");
    }
    Ok(())
}

fn subdivide(walk: &mut Walk<'_>) -> Outcome {
    let (n, closed) = (3 + walk.up_to(9), walk.flip());
    let points: Vec<Value> = (0..n).map(|_| walk.point(10.0)).collect();
    let line = json!({ "points": points, "closed": closed });
    let fields = json!({ "scheme": "chaikin", "levels": 1 });
    let after = walk.run(&[("l", "polyline", &line)], "subdivide", fields)?;
    let after: Vec<Vec<f64>> =
        object(&after, "l")["polyline"]["points"].as_array().unwrap().iter().map(numbers).collect();
    // Corners are cut at a quarter of each edge; an open line keeps its ends.
    let points: Vec<Vec<f64>> = points.iter().map(numbers).collect();
    let edges = if closed { n } else { n - 1 };
    for edge in usize::from(!closed)..edges - usize::from(!closed) {
        let (a, b) = (&points[edge], &points[(edge + 1) % n]);
        for share in [0.25, 0.75] {
            let cut = [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
            let near = after.iter().map(|p| apart(cut, [p[0], p[1], p[2]])).fold(f64::INFINITY, f64::min);
            assert!(near < 1e-13 * 10.0, "{near} at {share} of edge {edge} of {line}");
        }
    }
    if !closed {
        assert_eq!((after.first(), after.last()), (points.first(), points.last()));
    }
    Ok(())
}

/// A grid without creases is one surface: its vertices, and beyond the rim these mirrored.
fn patches(walk: &mut Walk<'_>) -> Outcome {
    let (rows, columns) = (2 + walk.up_to(4), 2 + walk.up_to(4));
    let points: Vec<Value> = (0..rows * columns).map(|_| walk.point(10.0)).collect();
    let at = |i: usize, j: usize| i * columns + j;
    let quads = (0..rows - 1).flat_map(|i| (0..columns - 1).map(move |j| (i, j)));
    let faces: Vec<Value> =
        quads.map(|(i, j)| json!([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])).collect();
    let shape = json!({ "kind": "subdivision", "scheme": "catmull-clark", "points": points, "faces": faces });
    let after = walk.run(&[("s", "shape", &shape)], "patches", json!({}))?;
    let after = numbers_of(&object(&after, "s.001")["surface"]["points"]);
    assert_eq!(after.len(), 3 * (rows + 2) * (columns + 2));
    for own in points.iter().map(numbers) {
        assert!(after.chunks_exact(3).any(|p| p == own), "{own:?} of {shape}");
    }
    Ok(())
}

/// A curve comes nearer to points beside it, from what is found between many places of it.
fn fit_shape(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let size = size_of(&curve);
    let beside: Vec<[f64; 3]> = walk
        .parameters(&curve, 30)
        .into_iter()
        .map(|u| curve_point(&curve, u))
        .map(|[x, y, z]| [x + 0.01 * size, y - 0.02 * size, z + 0.005 * size])
        .collect();
    let cloud = json!({ "points": beside });
    let objects: [(&str, &str, &Value); 2] = [("c", "curve", &curve), ("p", "cloud", &cloud)];
    let fields = json!({ "object": "c", "points": "p", "energy": "stretch", "fair": 1e-12, "iterations": 4 });
    let after = walk.run(&objects, "fit-shape", fields)?;
    let after = &object(&after, "c")["curve"];
    let far = |of: &Value, walk: &mut Walk<'_>| {
        let own: Vec<[f64; 3]> = walk.parameters(of, 600).into_iter().map(|u| curve_point(of, u)).collect();
        let near = |q: &[f64; 3]| own.iter().map(|p| apart(*p, *q)).fold(f64::INFINITY, f64::min);
        (beside.iter().map(|q| near(q) * near(q)).sum::<f64>() / beside.len() as f64).sqrt()
    };
    let (was, is) = (far(&curve, walk), far(after, walk));
    assert!(is < 0.95 * was, "{is:e} {was:e} of {curve}");
    Ok(())
}

/// A rope that is held where it is comes to hang there, and what it weighs is what holds it.
fn simulate(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let (a, b) = Direction::new(&curve).domain();
    let at = a + (b - a) * (0.3 + 0.4 * walk.random.next_number());
    let size = size_of(&curve);
    let held = json!([{ "kind": "fixed", "at": at }]);
    let fields = json!({
        "scheme": "implicit", "seconds": 0.25, "frames_per_second": 8, "gravity": [0, 0, -size], "mass": 1, "stiffness": 40.0 * size * size,
        "damping": 1, "constraints": held,
    });
    let after = walk.run(&[("c", "curve", &curve)], "simulate", fields)?;
    let after = &object(&after, "c")["curve"];
    let error = apart(curve_point(after, at), curve_point(&curve, at));
    assert!(error <= 1e-12 * size, "{error:e} at {at}\n{curve}");
    // Its weight is lower: heights by the mass of a piece of it, that of its length at the start.
    let places: Vec<f64> = (0..=400).map(|k| a + (b - a) * f64::from(k) / 400.0).collect();
    let height = |of: &Value| -> f64 {
        let pieces = places.windows(2).map(|pair| {
            let [from, to] = [pair[0], pair[1]].map(|u| curve_point(&curve, u));
            apart(from, to) * curve_point(of, 0.5 * (pair[0] + pair[1]))[2]
        });
        pieces.sum()
    };
    let (was, is) = (height(&curve), height(after));
    assert!(is < was, "{is:e} {was:e} of {curve}");
    let was = numbers_of(&curve["points"]);
    // Held by nothing and without any air, all of it falls alike, by two implicit steps of an eighth of a second: g (1 + 2) / 64.
    let fields = json!({
        "scheme": "implicit", "seconds": 0.25, "frames_per_second": 8, "gravity": [0, 0, -size], "mass": 1, "stiffness": 40.0 * size * size,
        "damping": 0,
    });
    let fallen = walk.run(&[("c", "curve", &curve)], "simulate", fields)?;
    let fallen = numbers_of(&object(&fallen, "c")["curve"]["points"]);
    for (k, (now, was)) in fallen.iter().zip(&was).enumerate() {
        let wanted = if k % 3 == 2 { was - 3.0 / 64.0 * size } else { *was };
        // To rounding of the mass matrix: its condition is 1e14 for eight vertices of degree 7 without clamped ends, and what was seen 1.4e-8.
        assert!((now - wanted).abs() <= 1e-7 * size, "{now} for {wanted} at {k} of {curve}");
    }
    Ok(())
}

/// Adds a curve made of numbers only; what each of its points must be, `off` away at most.
fn made(walk: &mut Walk<'_>, op: &str, fields: Value, off: impl Fn([f64; 3]) -> f64) -> Outcome {
    let after = walk.run(&[], op, fields)?;
    let curve = object(&after, op)["curve"].clone();
    for u in walk.parameters(&curve, 12) {
        let p = curve_point(&curve, u);
        assert!(off(p) <= 1e-12 * size_of(&curve), "{op}: {p:?} at {u} of {curve}");
    }
    Ok(())
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn triple(value: &Value) -> [f64; 3] {
    let all = numbers(value);
    [all[0], all[1], all[2]]
}

fn line(walk: &mut Walk<'_>) -> Outcome {
    let (from, to) = (walk.point(10.0), walk.point(10.0));
    let (a, b) = (triple(&from), triple(&to));
    made(walk, "line", json!({ "from": from, "to": to }), |p| {
        norm(cross(minus(p, a), minus(b, a))) / norm(minus(b, a))
    })
}

fn circle(walk: &mut Walk<'_>) -> Outcome {
    let (center, normal, radius) = (walk.point(10.0), walk.point(1.0), walk.between(0.1, 20.0));
    let (c, n) = (triple(&center), triple(&normal));
    let fields = json!({ "center": center, "normal": normal, "radius": radius, "periodic": walk.flip() });
    made(walk, "circle", fields, |p| {
        let arm = minus(p, c);
        (norm(arm) - radius).abs() + (dot(arm, n) / norm(n)).abs()
    })
}

fn arc(walk: &mut Walk<'_>) -> Outcome {
    let [from, through, to] = [walk.point(10.0), walk.point(10.0), walk.point(10.0)];
    let fields = json!({ "from": from, "through": through, "to": to });
    let after = walk.run(&[], "arc", fields)?;
    let curve = &object(&after, "arc")["curve"];
    let (a, b) = Direction::new(curve).domain();
    // Three points that are nearly on a line have a circle as large as they are far from it.
    let near = 1e-10 * size_of(curve);
    assert!(apart(curve_point(curve, a), triple(&from)) <= near, "{curve}");
    assert!(apart(curve_point(curve, b), triple(&to)) <= near, "{curve}");
    let middle = (0..=2000).map(|k| curve_point(curve, a + (b - a) * f64::from(k) / 2000.0));
    let gap = middle.map(|p| apart(p, triple(&through))).fold(f64::INFINITY, f64::min);
    assert!(gap <= 0.01 * size_of(curve), "{gap}: {curve}");
    Ok(())
}

fn ellipse(walk: &mut Walk<'_>) -> Outcome {
    let (x, y) = (walk.point(10.0), walk.point(10.0));
    let fields =
        json!({ "x": x, "y": y, "start": walk.between(-400.0, 400.0), "degrees": walk.between(5.0, 360.0) });
    let (x, y) = (triple(&x), triple(&y));
    // p = x cos t + y sin t: by the dual basis of x and y in their plane.
    let n = cross(x, y);
    let area = dot(n, n);
    let flat = (dot(x, x) * dot(y, y) / area).sqrt();
    made(walk, "ellipse", fields, |p| {
        let (c, s) = (dot(cross(p, y), n) / area, dot(cross(x, p), n) / area);
        ((c.hypot(s) - 1.0).abs() / flat + (dot(p, n) / area.sqrt()).abs()) / flat
    })
}

fn polyline(walk: &mut Walk<'_>) -> Outcome {
    let count = 3 + walk.up_to(9);
    let points: Vec<Value> = (0..count).map(|_| walk.point(10.0)).collect();
    let closed = walk.flip();
    let fields = json!({ "points": points, "closed": closed, "curve": true });
    let after = walk.run(&[], "polyline", fields)?;
    let curve = &object(&after, "polyline")["curve"];
    for (k, point) in points.iter().enumerate() {
        assert!(apart(curve_point(curve, k as f64), triple(point)) <= 1e-13, "{k} of {curve}");
    }
    Ok(())
}

/// Each point is one of the profile, as far along the axis and as far from it.
fn revolve(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let size = size_of(&curve);
    let (point, axis) = (walk.point(size), walk.point(1.0));
    let degrees = walk.between(-360.0, 360.0);
    let fields = json!({ "point": point, "axis": axis, "degrees": degrees, "name": "r" });
    let after = walk.run(&[("c", "curve", &curve)], "revolve", fields)?;
    let surface = &object(&after, "r")["surface"];
    let (point, axis) = (triple(&point), triple(&axis));
    let unit = axis.map(|c| c / norm(axis));
    let place = |p: [f64; 3]| {
        let arm = minus(p, point);
        (dot(arm, unit), norm(cross(arm, unit)))
    };
    let (a, b) = Direction::new(&surface["u"]).domain();
    assert!((b - a - degrees.abs().to_radians()).abs() < 1e-12, "{a} to {b} for {degrees}");
    for v in walk.parameters(&curve, 6) {
        let u = walk.between(a, b);
        let (q, p) = (place(surface_point(surface, u, v)), place(curve_point(&curve, v)));
        assert!((q.0 - p.0).abs() + (q.1 - p.1).abs() <= 1e-12 * size, "{q:?} {p:?} of {curve}");
    }
    Ok(())
}

fn isocurve(walk: &mut Walk<'_>) -> Outcome {
    let surface = walk.surface();
    let along_u = walk.flip();
    let (a, b) = Direction::new(&surface[if along_u { "v" } else { "u" }]).domain();
    let at = walk.between(a, b);
    let edge = walk.flip();
    let (op, fields) = match (edge, along_u) {
        (false, true) => ("isocurve", json!({ "v": at, "name": "c" })),
        (false, false) => ("isocurve", json!({ "u": at, "name": "c" })),
        (true, true) => ("edge", json!({ "edge": "v1", "name": "c" })),
        (true, false) => ("edge", json!({ "edge": "u1", "name": "c" })),
    };
    let after = match walk.run(&[("s", "surface", &surface)], op, fields) {
        // What is closed there has no edge.
        Err(problem) if edge && (problem.contains("there is no edge") || problem.contains("has no edge")) => {
            return Ok(());
        }
        other => other?,
    };
    let curve = object(&after, "c")["curve"].clone();
    let at = if edge { b } else { at };
    for t in walk.parameters(&curve, 8) {
        let (u, v) = if along_u { (t, at) } else { (at, t) };
        let error = apart(curve_point(&curve, t), surface_point(&surface, u, v));
        assert!(error <= 1e-12 * size_of(&surface), "{error:e} at {t} of {surface}");
    }
    Ok(())
}

/// By chords of many points between: the length from each point to the next is the same.
fn sample(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let count = 3 + walk.up_to(5);
    let after = walk.run(&[("c", "curve", &curve)], "sample", json!({ "count": count, "name": "s" }))?;
    let points: Vec<[f64; 3]> =
        object(&after, "s")["polyline"]["points"].as_array().unwrap().iter().map(triple).collect();
    assert_eq!(points.len(), count);
    let (a, b) = Direction::new(&curve).domain();
    let fine = 4_000;
    let all: Vec<[f64; 3]> = (0..=fine)
        .map(|k| curve_derivative(&curve, a + (b - a) * f64::from(k) / f64::from(fine), 0))
        .collect();
    let mut lengths = vec![0.0];
    for pair in all.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + norm(minus(pair[1], pair[0])));
    }
    let closed = apart(all[0], all[all.len() - 1]) <= 1e-12 * size_of(&curve);
    let steps = if closed { count } else { count - 1 };
    let whole = lengths[lengths.len() - 1];
    for (k, p) in points.iter().enumerate() {
        let wanted = whole * k as f64 / steps as f64;
        // Where the curve passes twice, only the place that is as far along counts.
        let near = |i: usize| (lengths[i] - wanted).abs() <= 2e-3 * whole;
        let gap =
            (0..all.len()).filter(|&i| near(i)).map(|i| apart(all[i], *p)).fold(f64::INFINITY, f64::min);
        assert!(gap <= 1e-3 * whole, "{gap:e} of {whole:e} at {k}: {curve}");
    }
    Ok(())
}

/// The edge comes to the other one, place by place, which has not moved; so does what is beside the opposite edge.
fn matched(walk: &mut Walk<'_>) -> Outcome {
    let (moving, still) = (walk.surface(), walk.surface());
    let size = size_of(&moving).max(size_of(&still));
    let (along_u, there_u) = (walk.flip(), walk.flip());
    let edge = |along_u: bool| if along_u { "v1" } else { "u1" };
    let fields = json!({ "object": "s", "edge": edge(along_u), "with": { "object": "t", "edge": edge(there_u) },
        "continuity": 0, "tolerance": 0.02 * size });
    let both = [("s", "surface", &moving), ("t", "surface", &still)];
    let after = match walk.run(&both, "match", fields) {
        // What is closed there has no edge.
        Err(problem) if (problem.contains("there is no edge") || problem.contains("has no edge")) => {
            return Ok(());
        }
        other => other?,
    };
    let (moved, stood) = (&object(&after, "s")["surface"], &object(&after, "t")["surface"]);
    let points = |s: &Value| serde_json::from_value::<Vec<Vec<[f64; 3]>>>(s["points"].clone()).unwrap();
    assert_eq!(points(stood), points(&still));
    let end = |surface: &Value, along_u: bool, part: f64| {
        let [u, v] = ["u", "v"].map(|d| Direction::new(&surface[d]).domain());
        let ((a, b), fixed) = if along_u { (u, v.1) } else { (v, u.1) };
        let t = a + part * (b - a);
        surface_derivative(surface, if along_u { [t, fixed] } else { [fixed, t] }, [0, 0])
    };
    let fine = 600;
    let edge: Vec<[f64; 3]> =
        (0..=fine).map(|k| end(stood, there_u, f64::from(k) / f64::from(fine))).collect();
    let longest = edge.windows(2).map(|pair| apart(pair[0], pair[1])).fold(0.0, f64::max);
    for k in 0..=12 {
        let point = end(moved, along_u, f64::from(k) / 12.0);
        let gap = edge.iter().map(|p| apart(*p, point)).fold(f64::INFINITY, f64::min);
        assert!(gap <= 0.02 * size * 1.01 + 0.5 * longest, "{gap:e} of {size:e} at {k}: {moving} {still}");
    }
    Ok(())
}

/// As far from the chords of the curve as asked for: a ring with any corners, outwards and inwards.
fn offset(walk: &mut Walk<'_>) -> Outcome {
    let ring = walk.ring(0.5, 1.0);
    let away = walk.between(0.02, 0.4) * if walk.flip() { 1.0 } else { -1.0 };
    let fields = json!({ "object": "r", "distance": away, "tolerance": 1e-5, "name": "o" });
    let after = walk.run(&[("r", "curve", &ring)], "offset", fields)?;
    let (a, b) = Direction::new(&ring).domain();
    let at = |k: i32| curve_derivative(&ring, a + (b - a) * f64::from(k) / 2000.0, 0);
    let chords: Vec<[f64; 3]> = (0..=2000).map(at).collect();
    let found: Vec<&Value> =
        after["objects"].as_array().unwrap().iter().filter(|o| o["name"] != "r").collect();
    assert!(!found.is_empty());
    let middle =
        |points: &[[f64; 3]]| points.iter().map(|p| p[0].hypot(p[1])).sum::<f64>() / points.len() as f64;
    for object in found {
        let curve = &object["curve"];
        let places: Vec<[f64; 3]> =
            walk.parameters(curve, 40).into_iter().map(|u| curve_derivative(curve, u, 0)).collect();
        for p in &places {
            let far = chords.windows(2).map(|c| to_chord(*p, &c[0], &c[1])).fold(f64::INFINITY, f64::min);
            assert!((far - away.abs()).abs() < 1e-3, "{far} is not {away} at {p:?} of {ring}");
        }
        assert!((middle(&places) > middle(&chords)) == (away > 0.0), "{away} of {ring}");
    }
    Ok(())
}

/// The curve is where it was at the start, and as far from the path all along as there.
fn sweep(walk: &mut Walk<'_>) -> Outcome {
    let profile = walk.curve(0);
    let size = size_of(&profile);
    let parallel = walk.flip();
    let path = if parallel {
        walk.curve(0)
    } else {
        let n = 5 + walk.up_to(4);
        let mut knots = vec![0.0; 4];
        knots.extend((1..n - 3).map(|k| k as f64));
        knots.extend([(n - 3) as f64; 4]);
        // Forwards, so that it does not stop.
        let points: Value = (0..n)
            .map(|i| json!([2.0 * size * i as f64, walk.between(-size, size), walk.between(-size, size)]))
            .collect();
        json!({ "degree": 3, "periodic": false, "knots": knots, "points": points })
    };
    let near = 1e-4 * size;
    let frame = if parallel { "parallel" } else { "least" };
    let fields = json!({ "object": "p", "path": "c", "frame": frame, "tolerance": near, "name": "s" });
    let after = walk.run(&[("p", "curve", &profile), ("c", "curve", &path)], "sweep", fields)?;
    let surface = &object(&after, "s")["surface"];
    let (a, b) = Direction::new(&path).domain();
    let start = curve_point(&path, a);
    let near = if parallel { 1e-12 * (size + size_of(&path)) } else { 2.0 * near };
    let places = walk.parameters(&profile, 6);
    // A closed one may be taken backwards, so that faces look outwards.
    let (p, q) = Direction::new(&profile).domain();
    let closed = apart(curve_point(&profile, p), curve_point(&profile, q)) <= 1e-12 * size;
    let there = |v: f64| apart(surface_point(surface, a, v), curve_point(&profile, v));
    let backwards = closed && places.iter().any(|v| there(*v) > near);
    let own_at = |v: f64| curve_point(&profile, if backwards { (p + (q - v)).clamp(p, q) } else { v });
    for v in &places {
        let own = own_at(*v);
        assert!(apart(surface_point(surface, a, *v), own) <= near, "at {v} of {profile}");
        let u = walk.between(a, b);
        let (p, c) = (surface_point(surface, u, *v), curve_point(&path, u));
        let (now, then) = (minus(p, c), minus(own, start));
        assert!((norm(now) - norm(then)).abs() <= near, "at {u} {v} of {profile} along {path}");
        if parallel {
            assert!(apart(now, then) <= near, "at {u} {v} of {profile} along {path}");
        }
        let other = minus(surface_point(surface, u, places[0]), c);
        let first = minus(own_at(places[0]), start);
        let turned = norm(minus(now, other)) - norm(minus(then, first));
        assert!(turned.abs() <= 2.0 * near, "at {u} {v} of {profile} along {path}");
    }
    Ok(())
}

/// Places that mirror one another do so.
fn symmetrize(walk: &mut Walk<'_>) -> Outcome {
    let curve = walk.curve(0);
    let size = size_of(&curve);
    let normal = walk.point(1.0);
    let fields = json!({ "object": "c", "normal": normal });
    let after = walk.run(&[("c", "curve", &curve)], "symmetrize", fields)?;
    let even = &object(&after, "c")["curve"];
    let normal = triple(&normal);
    let (a, b) = Direction::new(even).domain();
    for u in walk.parameters(even, 12) {
        let (p, q) = (curve_point(even, u), curve_point(even, (a + (b - u)).clamp(a, b)));
        let height = dot(p, normal) / dot(normal, normal);
        let image = [0, 1, 2].map(|k| p[k] - 2.0 * height * normal[k]);
        assert!(apart(image, q) <= 1e-9 * size, "{p:?} {q:?} at {u} of {curve}");
    }
    Ok(())
}

/// A surface cut in two is one face beside the other again: they share the curve along which it was cut.
fn sew(walk: &mut Walk<'_>) -> Outcome {
    let whole = walk.surface();
    let size = size_of(&whole);
    let (scene, _) = walk.document(&[("s", "surface", &whole)]);
    let surface = scene.surface("s").unwrap();
    let (a, b) = surface.u().domain();
    let at = walk.between(a + 0.2 * (b - a), a + 0.8 * (b - a));
    let mut halves = Scene::new();
    for (name, from, to) in [("s", a, at), ("t", at, b)] {
        let half = surface.between(KernelDirection::U, from, to).unwrap();
        let half = if walk.flip() { half.reverse(KernelDirection::V).unwrap() } else { half };
        halves.add(Object::new(name, half.into())).unwrap();
    }
    let halves = walk.written(&halves);
    let [one, other] = ["s", "t"].map(|name| object(&halves, name)["surface"].clone());
    let fields = json!({ "objects": ["s", "t"], "name": "b", "tolerance": 1e-7 * size });
    let after = walk.run(&[("s", "surface", &one), ("t", "surface", &other)], "sew", fields)?;
    let brep = &object(&after, "b")["brep"];
    let faces = brep["faces"].as_array().unwrap();
    let used = |face: &Value| -> Vec<u64> {
        let uses = face["loops"].as_array().unwrap().iter().flat_map(|chain| chain.as_array().unwrap());
        uses.map(|one| one["edge"].as_u64().unwrap()).collect()
    };
    let [first, second] = [used(&faces[0]), used(&faces[1])];
    // Along the cut both are one edge, which is where the whole surface is there.
    let (from, to) = surface.v().domain();
    let mut shared =
        first.iter().filter(|edge| second.contains(edge)).map(|&edge| &brep["edges"][edge as usize]["curve"]);
    let is_cut = |curve: &&Value| {
        let (c, d) = Direction::new(curve).domain();
        (0..=8).all(|k| {
            let share = f64::from(k) / 8.0;
            let p = curve_point(curve, c + (d - c) * share);
            [share, 1.0 - share].into_iter().any(|share| {
                apart(p, surface_derivative(&whole, [at, from + (to - from) * share], [0, 0])) <= 1e-9 * size
            })
        })
    };
    assert!(shared.any(|curve| is_cut(&curve)), "{whole} at {at}: {brep}");
    Ok(())
}

type Step = fn(&mut Walk<'_>) -> Outcome;

/// Each operation, and how many of the cases it may refuse at most.
const STEPS: [(&str, Step, u32); 41] = [
    ("edit", edit, 2),
    ("drag", drag, 0),
    ("fair", fair, 2),
    ("fine-tune", fine_tune, 0),
    ("fit", fit, 3),
    ("fit-shape", fit_shape, 3),
    ("refine", refine, 3),
    ("elevate", elevate, 0),
    ("reverse", reverse, 0),
    ("split", split, 0),
    ("simplify", simplify, 3),
    ("transform", transform, 0),
    ("fill", fill, 0),
    ("extrude", extrude, 0),
    ("loft", loft, 3),
    ("simulate", simulate, 3),
    ("subdivide", subdivide, 0),
    ("patches", patches, 0),
    ("tessellate", tessellate, 0),
    ("tube", tube, 0),
    ("copy", |w| scene_keeping(w, "copy", &json!({ "object": "c", "to": ["d"] }), &["c", "s", "d"]), 0),
    ("merge", merge, 0),
    ("delete", |w| scene_keeping(w, "delete", &json!({ "object": "s" }), &["c"]), 0),
    ("rename", |w| scene_keeping(w, "rename", &json!({ "object": "c", "to": "k" }), &["k", "s"]), 0),
    ("untrim", untrim, 0),
    ("line", line, 0),
    ("polyline", polyline, 0),
    ("circle", circle, 0),
    ("arc", arc, 0),
    ("ellipse", ellipse, 0),
    ("revolve", revolve, 0),
    ("isocurve", isocurve, 0),
    ("edge", isocurve, 0),
    ("sample", sample, 0),
    ("intersect", intersect, 0),
    ("section", section, 0),
    ("match", matched, 3),
    ("offset", offset, 0),
    ("sweep", sweep, 0),
    ("sew", sew, 0),
    ("symmetrize", symmetrize, 3),
];

#[test]
fn every_operation_does_what_it_says_to_documents() {
    let known: Vec<String> =
        loftsman::registry().operations().iter().map(|o| o.declaration().name.to_owned()).collect();
    for name in &known {
        assert!(STEPS.iter().any(|(step, ..)| step == name), "no walk through \"{name}\"");
    }
    let folder = tempfile::tempdir().unwrap();
    let mut told = Vec::new();
    for (k, (name, step, most)) in STEPS.into_iter().enumerate() {
        let mut random = Sequence::new(1000 + k as u32);
        let cases = if matches!(name, "edit" | "fair") { 5 * CASES } else { CASES };
        let refusals: Vec<String> = (0..cases)
            .filter_map(|_| step(&mut Walk { random: &mut random, folder: folder.path() }).err())
            .collect();
        told.push(format!("{name}: {} of {cases} refused", refusals.len()));
        assert!(
            refusals.len() as u32 <= most,
            "{name}: {} refusals\n{}",
            refusals.len(),
            refusals.join("\n")
        );
    }
    println!("{}", told.join("\n"));
}
