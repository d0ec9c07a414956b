//! A random family of pairs of surfaces, joined with every solver.

use std::collections::BTreeMap;

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, EditError};
use loftsman_kernel::functional::{Accuracy, Functional, Join};
use loftsman_kernel::solve::{Automatic, SolveError};
use loftsman_kernel::spline::{Space, Surface};

use super::{EDGES, Pair, book, solvers};

pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    pub(crate) fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.next()
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Clamped,
    Floating,
    Periodic,
}

/// A space of a kind over `[0, 1]`-relative inner knots with multiplicities, moved to a domain.
fn space(kind: Kind, degree: usize, inner: &[(f64, usize)], (start, length): (f64, f64)) -> Space {
    let mut knots: Vec<f64> = Vec::new();
    let inside = inner.iter().flat_map(|&(t, m)| std::iter::repeat_n(t, m.min(degree)));
    match kind {
        Kind::Clamped => {
            knots.extend(vec![0.0; degree + 1]);
            knots.extend(inside);
            knots.extend(vec![1.0; degree + 1]);
        }
        Kind::Floating => {
            knots.extend((0..=degree).map(|i| -0.2 * (degree - i) as f64));
            knots.extend(inside);
            knots.extend((0..=degree).map(|i| 1.0 + 0.3 * i as f64));
        }
        Kind::Periodic => {
            knots.push(0.0);
            knots.extend(inside);
            knots.push(1.0);
        }
    }
    let knots: Vec<f64> = knots.into_iter().map(|t| start + length * t).collect();
    if kind == Kind::Periodic { Space::periodic(degree, knots) } else { Space::open(degree, knots) }.unwrap()
}

fn inner(random: &mut Random, spans: usize, most: usize) -> Vec<(f64, usize)> {
    let gaps: Vec<f64> = (0..spans).map(|_| random.between(0.4, 1.6)).collect();
    let total: f64 = gaps.iter().sum();
    let mut t = 0.0;
    let mut all = Vec::new();
    for gap in &gaps[..spans - 1] {
        t += gap / total;
        all.push((t, if random.below(3) == 0 { 1 + random.below(most) } else { 1 }));
    }
    all
}

/// What is unlike about the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Relation {
    Same,
    Raised,
    Finer,
    Unlike,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Weights {
    None,
    /// Along the edge the same up to a factor, and the rows beside it too.
    Alike,
    /// The first only, and the same along the edge.
    One,
    /// Along the edge the same, beside it unlike.
    Beside,
    /// Unlike along the edge.
    Unlike,
}

struct Member {
    pair: Pair,
    reversed: bool,
    relation: Relation,
    weights: Weights,
    closed: bool,
}

/// The surface whose edge lies along `x = 0`, from `y = 0` to `y = 4`, on the side of `side`.
fn surface(
    random: &mut Random,
    edge: &str,
    (along, over): (&Space, &Space),
    (side, reversed): (f64, bool),
    weight: impl Fn(usize, usize) -> Option<f64>,
) -> Surface {
    let relative = |space: &Space, i: usize| {
        let (a, b) = space.domain();
        let p = space.degree();
        let mean = space.flat()[i + 1..=i + p].iter().sum::<f64>() / p as f64;
        (mean - a) / (b - a)
    };
    let net = |i: usize, j: usize, random: &mut Random| {
        let (mut x, mut y) = (relative(over, i), relative(along, j));
        if edge.ends_with('1') {
            x = 1.0 - x;
        }
        if reversed {
            y = 1.0 - y;
        }
        let noise = |random: &mut Random| random.between(-0.3, 0.3);
        let place = if along.is_periodic() {
            let angle = std::f64::consts::TAU * y;
            Point::new(side * (0.2 + 3.0 * x), 2.0 * angle.cos(), 2.0 * angle.sin())
        } else {
            Point::new(side * (0.2 + 3.0 * x), 4.0 * y, noise(random))
        };
        place + loftsman_kernel::Vector::new(noise(random), noise(random), noise(random)) * 0.5
    };
    let (n, m) = (over.len(), along.len());
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    let mut add = |i: usize, j: usize, random: &mut Random| {
        points.push(net(i, j, random));
        weights.extend(weight(i, if reversed { m - 1 - j } else { j }));
    };
    if edge.starts_with('u') {
        (0..n * m).for_each(|k| add(k / m, k % m, random));
    } else {
        (0..n * m).for_each(|k| add(k % n, k / n, random));
    }
    let weights = (!weights.is_empty()).then_some(weights);
    let (u, v) = if edge.starts_with('u') { (over, along) } else { (along, over) };
    Surface::build(u.clone(), v.clone(), points, weights).unwrap()
}

fn member(seed: u64) -> Member {
    let mut random = Random::new(seed + 1);
    let random = &mut random;
    let order = random.below(3);
    let kind = [Kind::Clamped, Kind::Floating, Kind::Periodic][random.below(3)];
    let relation = [Relation::Same, Relation::Raised, Relation::Finer, Relation::Unlike][random.below(4)];
    let mut p = 1 + random.below(5);
    if relation == Relation::Raised {
        p = p.min(4);
    }
    let closed = kind == Kind::Periodic;
    let spans = if closed { 3 + random.below(4) } else { 1 + random.below(5) };
    let knots = inner(random, spans, p);
    let (mut q, mut other_kind, mut other) = (p, kind, knots.clone());
    match relation {
        Relation::Same => {}
        Relation::Raised => {
            q = p + 1 + random.below(5 - p);
            let by = if random.below(2) == 0 { q - p } else { 0 };
            other.iter_mut().for_each(|(_, m)| *m += by);
        }
        Relation::Finer => {
            let t = random.between(0.05, 0.95);
            let at = other.partition_point(|(s, _)| *s < t);
            other.insert(at, (t, 1 + random.below(p)));
        }
        Relation::Unlike => {
            q = 1 + random.below(5);
            let spans = if closed { 3 + random.below(4) } else { 1 + random.below(5) };
            other = inner(random, spans, q);
            if !closed {
                other_kind = [Kind::Clamped, Kind::Floating][random.below(2)];
            }
        }
    }
    let reversed = !closed && random.below(2) == 0;
    if reversed {
        other = other.iter().rev().map(|&(t, m)| (1.0 - t, m)).collect();
    }
    let a_domain = (random.between(-3.0, 3.0), random.between(0.5, 5.0));
    let b_domain =
        if random.below(2) == 0 { a_domain } else { (random.between(-3.0, 3.0), random.between(0.5, 5.0)) };
    // Reversed floating knots lie otherwise outside of the domain, with the same functions inside.
    let (first, second) = (space(kind, p, &knots, a_domain), space(other_kind, q, &other, b_domain));
    let over = |random: &mut Random| {
        let kind = [Kind::Clamped, Kind::Clamped, Kind::Floating][random.below(3)];
        let (degree, spans) = (1 + random.below(4), 1 + random.below(3));
        let knots = inner(random, spans, 1);
        space(kind, degree, &knots, (random.between(-1.0, 1.0), random.between(0.5, 3.0)))
    };
    let (over_a, over_b) = (over(random), over(random));
    let edges = (EDGES[random.below(4)].0, EDGES[random.below(4)].0);
    let mut weights =
        [Weights::None, Weights::None, Weights::Alike, Weights::One, Weights::Beside, Weights::Unlike]
            [random.below(6)];
    // The same function in unlike spaces is a constant; and in floating ones that are reversed.
    let constant = relation != Relation::Same || reversed && kind == Kind::Floating;
    if weights == Weights::Beside && !(over_a.is_clamped() && over_b.is_clamped()) {
        weights = Weights::Unlike;
    }
    let list = |random: &mut Random| -> Vec<f64> { (0..40).map(|_| random.between(0.4, 2.5)).collect() };
    let (mut along, across_a, across_b) = (list(random), list(random), list(random));
    if constant || weights == Weights::One {
        along.fill(1.0);
    }
    let (unlike_a, unlike_b) = (list(random), list(random));
    let factor = random.between(0.2, 5.0);
    let weight = |second: bool| {
        let (along, across) = (along.clone(), if second { across_b.clone() } else { across_a.clone() });
        let unlike = if second { unlike_b.clone() } else { unlike_a.clone() };
        let at_edge = {
            let (edge, over) = if second { (edges.1, &over_b) } else { (edges.0, &over_a) };
            if edge.ends_with('1') { over.len() - 1 } else { 0 }
        };
        move |i: usize, j: usize| match weights {
            Weights::None => None,
            Weights::One if second => None,
            Weights::One => Some(across[i]),
            Weights::Alike => Some(along[j] * across[i] * if second { factor } else { 1.0 }),
            Weights::Beside if i == at_edge => Some(along[j]),
            Weights::Beside => Some(unlike[(7 * i + 3 * j) % 40]),
            Weights::Unlike => Some(unlike[(11 * i + j) % 40]),
        }
    };
    let pair = Pair {
        a: surface(random, edges.0, (&first, &over_a), (-1.0, false), weight(false)),
        b: surface(random, edges.1, (&second, &over_b), (1.0, reversed), weight(true)),
        edges,
        order,
    };
    Member { pair, reversed, relation, weights, closed }
}

const MEMBERS: u64 = 240;

/// Every member is joined by every solver so that the edges, and the derivatives, are one at 102 places to 1e-11 of the size of
/// the numbers there, or refused. What may be refused, and nothing else:
///
/// * weights that are unlike along the edge, or beside it where derivatives are to agree;
/// * closed edges with unlike knots;
/// * systems that are beyond the limits of `lu` (size) and `adjoint` (six equations).
#[test]
fn edges_are_one_all_along_or_the_join_is_refused() {
    let (mut held, mut refused) = (BTreeMap::new(), BTreeMap::new());
    for seed in 0..MEMBERS {
        let Member { pair, reversed, relation, weights, closed } = member(seed);
        let told =
            format!("{seed}: {relation:?} {weights:?} reversed {reversed} closed {closed} C{}", pair.order);
        let unlike = weights == Weights::Unlike || weights == Weights::Beside && pair.order > 0;
        for solver in solvers() {
            let name = solver.name().to_owned();
            match pair.solve(pair.join(), solver) {
                Ok(done) => {
                    assert!(!unlike, "{told}, {name}: this cannot be had");
                    let apart = done.apart(|x| if reversed { 1.0 - x } else { x });
                    for (k, apart) in apart.iter().enumerate() {
                        assert!(*apart <= 1e-11, "{told}, {name}: order {k} apart by {apart:e}");
                    }
                    let seen = done.witnessed(&pair, &pair.join());
                    assert!(seen <= 1e-11, "{told}, {name}: the witness sees {seen:e}");
                    *held.entry((relation, weights)).or_insert(0) += 1;
                }
                Err(EditError::Solve(SolveError::TooLarge { .. }))
                    if ["lu", "adjoint"].contains(&name.as_str()) =>
                {
                    *refused.entry("too large").or_insert(0) += 1;
                }
                Err(error) => {
                    let text = error.to_string();
                    let why = if unlike && text.contains("shrunk to a point; give both the same weights") {
                        "weights"
                    } else if closed
                        && relation != Relation::Same
                        && text.contains("closed and have unlike knots")
                    {
                        "knots"
                    } else {
                        panic!("{told}, {name}: {text}")
                    };
                    *refused.entry(why).or_insert(0) += 1;
                }
            }
        }
    }
    let kinds: std::collections::BTreeSet<_> = held.keys().map(|(relation, _)| relation).collect();
    assert_eq!(kinds.len(), 4);
    assert!(held.values().sum::<usize>() >= 500, "{held:?}");
    // Drawn: 64 members with unlike weights, 29 with closed edges of unlike knots, each refused by every solver.
    assert!(refused["weights"] <= 6 * 64 && refused["knots"] <= 6 * 29, "{refused:?}");
}

/// Where nothing may move the edges cannot meet; where one surface may not, the other one comes.
#[test]
fn locked_surfaces() {
    let (mut conflicts, mut met) = (0, 0);
    for seed in 0..MEMBERS {
        let Member { pair, reversed, relation, weights, closed } = member(seed);
        let unlike = weights == Weights::Unlike || weights == Weights::Beside && pair.order > 0;
        if unlike {
            continue;
        }
        let (na, nb) = (pair.a.points().len() as i64, pair.b.points().len() as i64);
        let locked = pair.edit().ask(pair.join().hold()).lock(0..na).lock_on(1, 0..nb);
        match locked.solve_with(Automatic) {
            Err(EditError::Solve(SolveError::Conflict { text, .. })) => {
                assert!(text.contains("join"), "{seed}: {text}");
                conflicts += 1;
            }
            Err(error)
                if closed && relation != Relation::Same && error.to_string().contains("unlike knots") =>
            {
                continue;
            }
            other => panic!("{seed}: {other:?}"),
        }
        // With the same functions along the edge and enough vertices across.
        let over = if pair.edges.1.starts_with('u') { pair.b.u() } else { pair.b.v() };
        if relation == Relation::Same && over.degree() >= pair.order {
            let edit = pair.edit().ask(pair.join().hold()).lock(0..na);
            let done = pair.done(edit, std::sync::Arc::new(Automatic)).unwrap();
            assert_eq!(done.a, pair.a, "{seed}");
            let apart = done.apart(|x| if reversed { 1.0 - x } else { x });
            assert!(apart.iter().all(|a| *a <= 1e-11), "{seed}: {apart:?}");
            met += 1;
        }
    }
    assert!(conflicts >= 100 && met >= 20, "{conflicts} {met}");
}

/// With a tolerance nothing is refused for its weights or knots; the edges are one where it was imposed, as far apart between as
/// the join says, and refused where that is more.
#[test]
fn with_a_tolerance_what_is_left_is_measured() {
    let solve = |pair: &Pair, tolerance: f64| {
        pair.solve(pair.join().within(tolerance), std::sync::Arc::new(Automatic))
    };
    let (mut exact, mut near, mut far) = (0, 0, 0);
    for seed in 0..MEMBERS / 2 {
        let Member { pair, reversed, closed, .. } = member(seed);
        let tolerant = pair.join().within(0.05);
        let bound = tolerant.bind(&pair.shapes()).unwrap().unwrap();
        assert_eq!(bound.accuracy(), Accuracy::Within(0.05));
        let any: &dyn std::any::Any = bound.as_ref();
        let bound: &Join = any.downcast_ref().unwrap();
        let done = solve(&pair, 1e9).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let gaps = bound.gaps(&done.shapes()).unwrap();
        let apart = done.apart(|x| if reversed { 1.0 - x } else { x });
        let size = book::size(&done.a, done.edges.0, 0).max(book::size(&done.b, done.edges.1, 0));
        // Looked at in other places: what the join saw is the most that there is, up to what lies between its own.
        if !closed {
            assert!(apart[0] * size <= 1.006 * gaps[0] + 1e-12 * size, "{seed}: {apart:?} {gaps:?}");
        }
        let left = done.farthest(&pair, &tolerant);
        match solve(&pair, 0.05) {
            Ok(done) => {
                assert!(left <= 0.05, "{seed}: {left}");
                let apart = done.apart(|x| if reversed { 1.0 - x } else { x });
                assert!(closed || apart[0] * size <= 0.05 * (1.0 + 1e-9), "{seed}: {apart:?}");
            }
            Err(error) => {
                assert!(
                    left > 0.0497 && error.to_string().contains("more than its tolerance of 0.05"),
                    "{seed}: {left}, {error}"
                );
            }
        }
        *(if gaps[0] <= 1e-12 * size {
            &mut exact
        } else if left <= 0.05 {
            &mut near
        } else {
            &mut far
        }) += 1;
    }
    assert!(exact >= 30 && near >= 10 && far >= 10, "{exact} {near} {far}");
}
