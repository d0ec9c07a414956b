//! Ropes of every kind come to rest, in few steps: none ends in an error, and what does not rest says what is left and where.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what makes the shapes of the tests cannot fail")]

use loftsman_dynamics::{
    Body, Material, Scheme, Setup, double_sliding, fixed, force, knot, pull, sliding, sliding_curvature,
    sliding_tangent,
};
use loftsman_kernel::Point;
use loftsman_kernel::shape::Location;
use loftsman_kernel::spline::{Curve, Space, Surface};

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// The same numbers every time, from 0 to 1.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn happens(&mut self, share: f64) -> bool {
        self.next() < share
    }

    fn around(&mut self, by: f64) -> [f64; 3] {
        [0; 3].map(|_| self.between(-by, by))
    }
}

/// Knots as they come: uniform, uneven down to a hundredth of the mean, repeated; open, floating or round.
fn rope(round: usize, chance: &mut Chance) -> (Curve, bool) {
    let degree = [1, 2, 3, 4, 5, 6, 7, 25][round % 8];
    let n = degree + 2 + (chance.next() * 8.0) as usize;
    let periodic = round % 3 == 2;
    let spans = if periodic { n } else { n - degree };
    let mut inside: Vec<f64> = (1..spans).map(|k| k as f64).collect();
    if chance.happens(0.5) {
        inside.iter_mut().for_each(|knot| *knot += chance.between(-0.495, 0.495));
    }
    if spans > 3 && degree > 1 && chance.happens(0.3) {
        inside[1] = inside[0];
    }
    let end = spans as f64;
    let space = if periodic {
        Space::periodic(degree, [0.0].into_iter().chain(inside).chain([end]).collect())
    } else if round % 6 == 4 {
        Space::floating_uniform(degree, n)
    } else {
        let ends = |at: f64| vec![at; degree + 1];
        Space::open(degree, [ends(0.0), inside, ends(end)].concat())
    };
    let at = |i: usize| {
        let t = i as f64 / n as f64;
        let turn = std::f64::consts::TAU * t;
        if periodic {
            Point::new(turn.cos(), turn.sin(), 0.0)
        } else {
            Point::new(3.0 * t, (3.0 * turn).sin() * 0.3, 0.0)
        }
    };
    let points = (0..n).map(|i| at(i) + loftsman_kernel::Vector::from(chance.around(0.15))).collect();
    let weights = chance.happens(0.2).then(|| (0..n).map(|_| chance.between(0.5, 2.0)).collect());
    (Curve::build(space.unwrap(), points, weights).unwrap(), periodic)
}

/// 240 ropes: hung up, tied, through rings, in loops that are drawn shut, slack and taut, stiff and limp, with and without weight.
#[test]
fn ropes_of_every_kind_come_to_rest() {
    let mut chance = Chance(16);
    let (mut rest, mut late, mut steps, mut contradict) = (0, Vec::new(), 0, 0);
    for round in 0..240 {
        let (curve, periodic) = rope(round, &mut chance);
        let (a, b) = curve.space().domain();
        let place = |chance: &mut Chance, from: f64, to: f64| a + (b - a) * chance.between(from, to);
        let mass = chance.between(0.1, 2.0);
        let stiffness = mass * 9.81 * 3.0 * 10_f64.powf(chance.between(0.7, 3.0));
        let bending =
            if chance.happens(0.55) { stiffness * 10_f64.powf(chance.between(-4.0, -0.5)) } else { 0.0 };
        // Polylines have nothing that bends.
        let bending = if curve.space().degree() > 1 { bending } else { 0.0 };
        let slack = if chance.happens(0.3) { chance.between(0.8, 1.1) } else { 1.0 };
        let material = Material { mass, stiffness, bending, rest: slack, ..Material::default() };
        let ends =
            if periodic { [place(&mut chance, 0.0, 0.1), place(&mut chance, 0.5, 0.6)] } else { [a, b] };
        let mut setup = Setup::new(Body::new(&curve).material(material)).hold(fixed(ends[0]));
        let mut what = format!(
            "{round}, degree {}, {} vertices, bending {bending:.1e}:",
            curve.space().degree(),
            curve.points().len()
        );
        if !chance.happens(0.1) {
            setup = setup.gravity(GRAVITY);
        }
        let mut say = |name: &str| what += &format!(" {name}");
        if chance.happens(0.6) {
            let by = curve.point(ends[1]).unwrap() + loftsman_kernel::Vector::from(chance.around(0.4));
            (setup, _) = (setup.hold(fixed(ends[1]).to(by)), say("other end"));
        }
        for _ in 0..(chance.next() * 3.0) as usize {
            let near = place(&mut chance, 0.15, 0.85);
            let by = curve.point(near).unwrap() + loftsman_kernel::Vector::from(chance.around(0.3));
            (setup, _) = match (chance.next() * 8.0) as usize {
                0..4 => (setup.hold(sliding(near).to(by).called(format!("ring {near}"))), say("ring")),
                4 | 5 => (setup.hold(knot(near, place(&mut chance, 0.15, 0.85))), say("knot")),
                6 => (setup.hold(double_sliding([near, place(&mut chance, 0.15, 0.85)])), say("loop")),
                _ if curve.space().degree() > 2 => {
                    let own = curve.value_at(near, 1 + round % 2);
                    let held = if round % 2 == 0 {
                        sliding_tangent(near, own)
                    } else {
                        sliding_curvature(near, own)
                    };
                    (setup.hold(held), say("derivative"))
                }
                _ => (setup, ()),
            };
        }
        if chance.happens(0.2) {
            (setup, _) =
                (setup.push(force(place(&mut chance, 0.0, 1.0), chance.around(10.0 * mass))), say("force"));
        }
        if chance.happens(0.2) {
            let at = place(&mut chance, 0.0, 1.0);
            (setup, _) = (setup.pull(pull(at, chance.around(1.0), 0.1 * stiffness)), say("pull"));
        }
        let mut simulation = match setup.scheme(Scheme::Exact).prepare() {
            Ok(simulation) => simulation,
            // What chance asks for may contradict itself.
            Err(loftsman_dynamics::DynamicsError::Conflict { .. }) => {
                contradict += 1;
                continue;
            }
            Err(error) => panic!("{what}: {error}"),
        };
        let settled = simulation.settle_without_corners().unwrap_or_else(|error| panic!("{what}: {error}"));
        if settled.rests {
            assert!(settled.residual < 1e-9 && settled.unrest.is_none(), "{what}: {settled:?}");
            let errors = simulation.errors().unwrap();
            assert!(errors.iter().all(|error| *error < 1e-7), "{what}: {errors:?}");
            assert!(settled.steps <= 600, "{what}: {settled:?}");
            (rest, steps) = (rest + 1, steps + settled.steps);
        } else {
            assert!(settled.unrest.is_some(), "{what}: {settled:?}");
            late.push((what, settled));
        }
    }
    assert!(contradict <= 40 && rest + late.len() + contradict == 240, "{contradict} contradict themselves");
    assert!(rest >= 180 && late.len() <= 2, "{rest} rest, {} do not: {late:#?}", late.len());
    assert!(steps < 50 * rest, "{steps} steps for {rest}");
}

/// A sheet of 7 by 7 that four places hold up, slack between them, of no weight and without bending: it crumples, and that ends.
#[test]
fn a_slack_sheet_without_weight_comes_to_rest() {
    let space = Space::clamped_uniform(3, 7).unwrap();
    let at = |i: usize| space.greville(i) * 6.0 / space.domain().1;
    let points = (0..49).map(|k| Point::new(at(k / 7), at(k % 7), 0.0)).collect();
    let sheet = Surface::new(space.clone(), space.clone(), points).unwrap();
    for rest in [1.0, 1.1] {
        let mut simulation = Setup::new(Body::new(&sheet).mass(0.02).stiffness(200.0).rest(rest))
            .hold(fixed([0.0, 0.0]))
            .hold(sliding([1.0, 3.0]).to([1.5, 4.5, 1.2]))
            .hold(sliding([3.0, 1.0]).to([4.5, 1.5, 1.2]))
            .hold(sliding([2.33, 2.33]).to([3.5, 3.5, 0.2]))
            .prepare()
            .unwrap();
        let settled = simulation.settle().unwrap();
        assert!(settled.rests && settled.steps < 300, "{rest}: {settled:?}");
    }
}

/// Rods pushed together or grown too long for their ends, and columns, from their straight and unstable balance: into the arch that they find.
#[test]
fn what_buckles_does_so_in_few_steps() {
    for degree in [2, 3, 5] {
        for n in [12, 40] {
            for (rest, pushed, gravity) in
                [(1.1, 0.0, [0.0; 3]), (1.0, 0.15, [0.0; 3]), (1.0, 0.15, [9.81, 0.0, 0.0])]
            {
                let space = Space::clamped_uniform(degree, n).unwrap();
                let end = space.domain().1;
                let points = (0..n).map(|i| Point::new(3.0 * space.greville(i) / end, 0.0, 0.0)).collect();
                let rod = Curve::new(space, points).unwrap();
                let mut simulation = Setup::new(Body::new(&rod).stiffness(600.0).bending(0.5).rest(rest))
                    .gravity(gravity)
                    .hold(fixed(0.0))
                    .hold(fixed(end).to([3.0 * (1.0 - pushed), 0.0, 0.0]))
                    .prepare()
                    .unwrap();
                let settled = simulation.settle().unwrap();
                let what = format!("degree {degree}, {n} vertices, {rest}, {gravity:?}: {settled:?}");
                assert!(settled.rests && settled.steps < 300, "{what}");
                let middle: Point = rod.point(0.5 * end).unwrap();
                let now = simulation.shape(0).unwrap().value((0.5 * end).into(), 0.into()).unwrap();
                assert!((now - middle.coords).yz().norm() > 0.1, "{what}: {now}");
            }
        }
    }
}

trait ValueAt {
    fn value_at(&self, at: f64, times: usize) -> [f64; 3];
}

impl ValueAt for Curve {
    fn value_at(&self, at: f64, times: usize) -> [f64; 3] {
        self.derivative(at, times).unwrap().into()
    }
}

/// Loops whose ends are pulled apart while rest is looked for: their places come together, which lets go and is told, or they stay as they follow one another; none goes through the other.
#[test]
fn no_loop_is_turned_inside_out() {
    let (mut held, mut shut) = (0, 0);
    for round in 0..60_u64 {
        let mut chance = Chance(round + 600);
        let mut random = move || chance.next();
        random();
        let degree = 2 + (5.0 * random()) as usize;
        let n = degree + 5 + (9.0 * random()) as usize;
        let space = Space::clamped_uniform(degree, n).unwrap();
        let end = space.domain().1;
        let at = |k: usize| {
            let g = space.greville(k) / end;
            let turn = std::f64::consts::TAU * 1.15 * g;
            Point::new(0.4 * turn.sin() + 1.2 * (g - 0.5), 0.02 * (3.0 * g).sin(), -0.4 * turn.cos())
        };
        let rope = Curve::new(space.clone(), (0..n).map(at).collect()).unwrap();
        // Where it comes nearest to itself.
        let places = (0..200).flat_map(|i| (i + 40..=200).map(move |j| (i, j)));
        let place = |k: usize| rope.point(end * k as f64 / 200.0).unwrap();
        let all: Vec<Point> = (0..=200).map(place).collect();
        let (i, j) = places
            .min_by(|a, b| (all[a.0] - all[a.1]).norm().total_cmp(&(all[b.0] - all[b.1]).norm()))
            .unwrap();
        let both = [i, j].map(|k| end * k as f64 / 200.0);
        let both = if random() < 0.5 { both } else { [both[1], both[0]] };
        let (pull, gravity) = (0.2 + 2.3 * random(), if random() < 0.6 { 0.0 } else { -9.81 });
        let [a, b] = [rope.points()[0], rope.points()[n - 1]].map(|p| p.coords);
        let away = loftsman_kernel::Vector::x() * pull;
        let mut simulation = Setup::new(Body::new(&rope).mass(0.1).stiffness(60.0))
            .gravity([0.0, 0.0, gravity])
            .hold(knot(both[0], both[1]))
            .hold(fixed(0.0).to(<[f64; 3]>::from(a - away)))
            .hold(fixed(end).to(<[f64; 3]>::from(b + away)))
            .prepare()
            .unwrap();
        simulation.settle().unwrap();
        if !simulation.holds(0).unwrap() {
            assert!(simulation.events().iter().any(|e| e.what == "its loop is drawn shut"), "{round}");
            shut += 1;
            continue;
        }
        let [Location::Curve(now), Location::Curve(other)] = simulation.locations(0).unwrap()[..] else {
            panic!("curves")
        };
        assert!((now - other) * (both[0] - both[1]) > 0.0, "{round}: {degree} {both:?} {now} {other}");
        held += 1;
    }
    assert!(held >= 40 && shut >= 2, "{held} {shut}");
}
