//! `simplify` on families of curves and surfaces: knots that were put in come out again, and nothing moves.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, reason = "tests")]

use loftsman_editing::Editing;
use loftsman_kernel::Point;
use loftsman_kernel::plugin::{
    Context, Format as _, Memory, OperationError, Parameters, ReadOptions, Registry, StepReport, UpChoice,
    WriteOptions,
};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_obj::Obj;
use serde_json::{Value, json};

struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.next() * count as f64) as usize).min(count - 1)
    }
}

fn run(scene: &mut Scene, parameters: Value) -> Result<StepReport, OperationError> {
    let mut registry = Registry::new();
    registry.add(&Editing);
    let operation = registry.find_operation("simplify", "step[0].op")?.clone();
    let parameters = Parameters::new(parameters, "step[0]")?;
    parameters.check(operation.declaration().fields)?;
    operation.apply(scene, &parameters, &Context::quiet(&registry))
}

fn simplified(geometry: impl Into<Geometry>, parameters: Value) -> (Geometry, String) {
    let mut scene = Scene::new();
    scene.add(Object::new("s", geometry.into())).unwrap();
    let report = run(&mut scene, parameters).unwrap();
    (scene.object("s").unwrap().geometry().clone(), report.notes.join("\n"))
}

fn curve_of(geometry: Geometry) -> Curve {
    match geometry {
        Geometry::Curve(curve) => curve,
        other => panic!("a {}", other.kind()),
    }
}

/// A space of a degree: clamped, floating or periodic; knots of any spacing and, where `repeated`, multiplicity.
fn space(random: &mut Random, degree: usize, repeated: bool) -> Space {
    let mut t = random.within(-3.0, 3.0);
    let mut inner = Vec::new();
    for _ in 0..1 + random.below(9) {
        t += random.within(0.2, 2.0);
        let times = if repeated && random.below(3) == 0 { 1 + random.below(degree) } else { 1 };
        inner.extend(vec![t; times]);
    }
    let (a, b) = (inner[0] - random.within(0.2, 2.0), t + random.within(0.2, 2.0));
    match random.below(3) {
        0 => Space::open(degree, [vec![a; degree + 1], inner, vec![b; degree + 1]].concat()).unwrap(),
        1 => {
            let before = (0..=degree).map(|i| a - 0.4 * (degree - i) as f64);
            let after = (0..=degree).map(|i| b + 0.7 * i as f64);
            Space::open(degree, before.chain(inner).chain(after).collect()).unwrap()
        }
        _ => Space::periodic(degree, [vec![a], inner, vec![b]].concat()).unwrap(),
    }
}

fn net(random: &mut Random, count: usize, size: f64, rational: bool) -> (Vec<Point>, Option<Vec<f64>>) {
    let points = (0..count).map(|_| Point::from([(); 3].map(|()| size * random.within(-1.0, 1.0))));
    let points = points.collect();
    let weights = rational.then(|| (0..count).map(|_| random.within(0.3, 3.0)).collect());
    (points, weights)
}

/// Knots put into a space, each as often as there is room.
fn more(random: &mut Random, space: &Space) -> Vec<f64> {
    let (a, b) = space.domain();
    let mut new = Vec::new();
    for _ in 0..1 + random.below(8) {
        let u = if random.below(3) == 0 {
            // The ends of a floating space's domain stay, whatever is put there.
            let knots = space.breakpoints();
            let inner = if space.is_periodic() { &knots[..] } else { &knots[1..knots.len() - 1] };
            inner[random.below(inner.len())]
        } else {
            random.within(a, b)
        };
        let times = 1 + random.below(3);
        let mut with = new.clone();
        with.extend(vec![u; times]);
        if space.inserting(&with).is_ok() {
            new = with;
        }
    }
    new
}

/// The largest distance at many parameters, over the size.
fn apart(a: &Curve, b: &Curve, size: f64) -> f64 {
    let (start, end) = a.domain();
    (0..2000)
        .map(|i| start + (end - start) * (f64::from(i) + 0.5) / 2000.0)
        .map(|u| (a.point(u).unwrap() - b.point(u).unwrap()).norm() / size)
        .fold(0.0, f64::max)
}

#[test]
fn inserted_knots_and_bezier_forms_of_curves_come_out_again() {
    for member in 0..300 {
        let mut random = Random(member);
        let degree = 1 + random.below(7);
        let size = 10_f64.powi(random.below(19) as i32 - 9);
        let space = space(&mut random, degree, member % 2 == 0);
        let (points, weights) = net(&mut random, space.len(), size, member % 3 == 0);
        let curve = Curve::build(space, points, weights).unwrap();
        // What it needs: some of the knots of a random curve may themselves be idle only by chance, and none are.
        let (needed, _) = simplified(curve.clone(), json!({}));
        assert_eq!(needed.points().len(), curve.points().len(), "member {member}, degree {degree}");
        let new = more(&mut random, curve.space());
        let finer = curve.insert_knots(&new).unwrap();
        let (found, note) = simplified(finer.clone(), json!({}));
        let found = curve_of(found);
        assert_eq!(found.space(), curve.space(), "member {member}, degree {degree}: {note}");
        assert!(note.starts_with(&format!("{} of ", new.len())), "{note}");
        assert!(apart(&curve, &found, size) <= 1e-13, "member {member}: {:e}", apart(&curve, &found, size));
        // A Bézier form is open: a periodic curve comes back clamped, or periodic if that is asked for.
        let (found, _) = simplified(curve.bezier_form().unwrap(), json!({ "periodic": curve.is_periodic() }));
        let found = curve_of(found);
        assert_eq!(found.points().len(), curve.points().len(), "member {member}, degree {degree}, Bézier");
        assert!(apart(&curve, &found, size) <= 1e-13, "member {member}, Bézier");
    }
}

#[test]
fn inserted_knots_and_bezier_forms_of_surfaces_come_out_again() {
    for member in 0..100 {
        let mut random = Random(5000 + member);
        let degrees = [1 + random.below(5), 1 + random.below(5)];
        let size = 10_f64.powi(random.below(19) as i32 - 9);
        let [u, v] = degrees.map(|degree| space(&mut random, degree, member % 2 == 0));
        let (points, weights) = net(&mut random, u.len() * v.len(), size, member % 3 == 0);
        let surface = Surface::build(u.clone(), v.clone(), points, weights).unwrap();
        let (mu, mv) = (more(&mut random, &u), more(&mut random, &v));
        let finer = surface.insert_knots(Direction::U, &mu).unwrap().insert_knots(Direction::V, &mv).unwrap();
        let bezier = surface.bezier_form().unwrap();
        for (given, what) in [(&finer, "knots"), (&bezier, "Bézier")] {
            let (found, note) = simplified(given.clone(), json!({}));
            let Geometry::Surface(found) = found else { panic!("no surface") };
            let count = |direction: Direction| {
                let space = surface.space(direction);
                // Opened at the seam: p vertices more.
                let open = usize::from(what == "Bézier" && space.is_periodic()) * space.degree();
                space.len() + open
            };
            let net = (found.u().len(), found.v().len());
            assert_eq!(net, (count(Direction::U), count(Direction::V)), "member {member}, {what}: {note}");
            for i in 0..40 {
                for j in 0..40 {
                    let at = |s: &Space, k: i32| s.domain().0 + s.length() * (f64::from(k) + 0.5) / 40.0;
                    let (x, y) = (at(&u, i), at(&v, j));
                    let moved = (surface.point(x, y).unwrap() - found.point(x, y).unwrap()).norm();
                    assert!(moved <= 2e-13 * size, "member {member}, {what}: {:e}", moved / size);
                }
            }
        }
        // Made periodic again, where it was.
        if u.is_periodic() || v.is_periodic() {
            let (found, note) = simplified(bezier, json!({ "periodic": true }));
            let Geometry::Surface(found) = found else { panic!("no surface") };
            assert_eq!((found.u().len(), found.v().len()), (u.len(), v.len()), "member {member}: {note}");
        }
        // One direction alone.
        let (found, _) = simplified(finer.clone(), json!({ "direction": "v" }));
        let Geometry::Surface(found) = found else { panic!("no surface") };
        assert_eq!((found.u().len(), found.v()), (finer.u().len(), surface.v()), "member {member}");
    }
}

#[test]
fn degree_25_and_long_chains() {
    let mut random = Random(7);
    for (degree, count) in [(3, 2000), (5, 600), (10, 60), (25, 40)] {
        let space = Space::clamped_uniform(degree, count).unwrap();
        let (points, _) = net(&mut random, count, 1.0, false);
        let curve = Curve::new(space.clone(), points).unwrap();
        let new: Vec<f64> =
            (0..count / 4).map(|i| space.length() * (i as f64 + 0.3) / (count / 4) as f64).collect();
        let (found, note) = simplified(curve.insert_knots(&new).unwrap(), json!({}));
        assert_eq!(found.points().len(), count, "{degree}: {note}");
        assert!(apart(&curve, &curve_of(found), 1.0) <= 1e-13, "{degree}");
        let form = curve.bezier_form().unwrap();
        let (found, note) = simplified(form.clone(), json!({}));
        // A vertex of high degree reaches over more Bézier pieces than numbers can extrapolate: what is not removed then is
        // told, and nothing moves.
        assert!(degree > 7 || found.points().len() == count, "{degree}: {note}");
        assert!(found.points().len() < form.points().len(), "{degree}: {note}");
        assert!(apart(&curve, &curve_of(found), 1.0) <= 1e-13, "{degree}");
    }
}

#[test]
fn within_a_tolerance_the_measured_distance_holds() {
    for member in 0..100 {
        let mut random = Random(9000 + member);
        let degree = 1 + random.below(5);
        let space = Space::clamped_uniform(degree, 30).unwrap();
        let (mut points, weights) = net(&mut random, 30, 0.01, member % 2 == 0);
        points.iter_mut().enumerate().for_each(|(i, p)| p.x += i as f64);
        let curve = Curve::build(space, points, weights).unwrap();
        let tolerance = 10_f64.powf(random.within(-4.0, 0.0));
        let (found, note) = simplified(curve.clone(), json!({ "tolerance": tolerance }));
        let moved = apart(&curve, &curve_of(found), 1.0);
        assert!(moved <= tolerance, "member {member}: {moved} > {tolerance}: {note}");
    }
}

#[test]
fn our_own_obj_comes_back_as_the_spline_that_it_was() {
    let points =
        (0..13).map(|i| Point::new(f64::from(i) * 0.1, (f64::from(i) * 0.7).sin(), 1.0 / 3.0)).collect();
    let knots: Vec<f64> = (0..=10).map(|i| (f64::from(i) / 10.0).powf(1.3)).collect();
    let section = Curve::new(Space::clamped(3, &knots).unwrap(), points).unwrap();
    let ring = Curve::new(Space::periodic(3, knots).unwrap(), section.points()[..10].to_vec()).unwrap();
    let weights = (0..13).map(|i| 1.0 + 0.1 * f64::from(i % 3)).collect();
    let rational = Curve::rational(section.space().clone(), section.points().to_vec(), weights).unwrap();
    for (curve, fields) in [(section, json!({})), (rational, json!({})), (ring, json!({ "periodic": true }))]
    {
        let mut scene = Scene::new();
        scene.add(Object::new("section", curve.clone().into())).unwrap();
        let mut file = Memory::new("section.obj", "");
        let options = WriteOptions { up: UpChoice::Keep, ..WriteOptions::default() };
        Obj.write(&scene, &mut file, &options).unwrap();
        // Another program has passed it on: what was said in comments is gone.
        let written = String::from_utf8(file.bytes).unwrap();
        let kept: String =
            written.lines().filter(|line| !line.starts_with('#')).flat_map(|l| [l, "\n"]).collect();
        let file = Memory::new("section.obj", kept);
        let (mut scene, _) = Obj.read(&file, &ReadOptions::default()).unwrap();
        assert_eq!(scene.objects()[0].geometry().points().len(), 31, "Bézier pieces, as Blender wants them");
        let report = run(&mut scene, fields).unwrap();
        let Geometry::Curve(back) = scene.objects()[0].geometry() else { panic!("no curve") };
        assert_eq!(back.space(), curve.space(), "{:?}", report.notes);
        for (p, q) in back.points().iter().zip(curve.points()) {
            assert!((p - q).norm() < 1e-14, "{p} {q}");
        }
    }
}

#[test]
fn what_cannot_be_simplified_says_so() {
    let curve = Curve::new(
        Space::clamped_uniform(3, 6).unwrap(),
        (0..6).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.0)).collect(),
    )
    .unwrap();
    let mut scene = Scene::new();
    scene.add(Object::new("c", curve.into())).unwrap();
    let mut fails = |fields: Value| run(&mut scene, fields).unwrap_err().to_string();
    assert!(fails(json!({ "tolerance": -1.0 })).contains("tolerance: -1 is no length"));
    assert!(fails(json!({ "tolerence": 1.0 })).contains("did you mean \"tolerance\"?"));
    assert!(fails(json!({ "periodic": true })).contains("cannot meet within the tolerance"));
    assert!(fails(json!({ "direction": "w" })).contains("direction"));
}

/// What lies in a plane to rounding does so when it is simplified, within a tolerance, too, whatever way the plane lies.
#[test]
fn what_is_planar_stays_so() {
    use loftsman_kernel::Vector;
    let mut random = Random(11);
    let mut removed = 0;
    for trial in 0..60 {
        let degree = 2 + random.below(4);
        let n = 40 + random.below(60);
        // Uneven knots, some nearly one.
        let mut t = 0.0;
        let inner: Vec<f64> = (0..n - degree - 1)
            .map(|_| {
                t += if random.below(4) == 0 { 1e-4 } else { random.within(0.2, 2.0) };
                t
            })
            .collect();
        let knots = [vec![-1.0; degree + 1], inner, vec![t + 1.0; degree + 1]].concat();
        let mut way =
            || Vector::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), random.within(-1.0, 1.0));
        let (x, y) = (way().normalize(), way());
        let normal = x.cross(&y).normalize();
        let y = normal.cross(&x);
        let points = (0..n).map(|k| {
            let (sine, cosine) = (0.15 * k as f64).sin_cos();
            Point::new(3.0, -2.0, 1.0) + x * (10.0 * cosine) + y * (7.0 * sine)
        });
        let curve = Curve::new(Space::open(degree, knots).unwrap(), points.collect()).unwrap();
        let (simple, _) =
            simplified(curve.clone(), json!({ "tolerance": 10_f64.powf(random.within(-6.0, -1.0)) }));
        let simple = curve_of(simple);
        removed += n - simple.points().len();
        for p in simple.points() {
            let height = (p - Point::new(3.0, -2.0, 1.0)).dot(&normal).abs();
            assert!(height < 1e-12, "{trial}: {height:e}");
        }
    }
    // 85 where this was written: a rounding elsewhere may keep a few more.
    assert!(removed >= 80, "{removed}");
}
