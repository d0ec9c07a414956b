//! Products of spline functions against twice the digits: knots repeated up to `p + 1` times, high degrees, any size.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::ops::{Add, Mul, Neg, Sub};

use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::algebra::Function;

/// A number as the unevaluated sum of two, the second below half a unit in the last place of the first: some 32 digits (Dekker 1971).
#[derive(Debug, Clone, Copy)]
struct Twice(f64, f64);

/// A sum and what its rounding lost (Knuth).
fn two_sum(a: f64, b: f64) -> Twice {
    let sum = a + b;
    let other = sum - a;
    Twice(sum, (a - (sum - other)) + (b - other))
}

impl From<f64> for Twice {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Neg for Twice {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Add for Twice {
    type Output = Self;
    fn add(self, by: Self) -> Self {
        let (high, low) = (two_sum(self.0, by.0), two_sum(self.1, by.1));
        let sum = two_sum(high.0, high.1 + low.0);
        two_sum(sum.0, sum.1 + low.1)
    }
}

impl Sub for Twice {
    type Output = Self;
    fn sub(self, by: Self) -> Self {
        self + -by
    }
}

impl Mul for Twice {
    type Output = Self;
    fn mul(self, by: Self) -> Self {
        let product = self.0 * by.0;
        let lost = self.0.mul_add(by.0, -product) + (self.0 * by.1 + self.1 * by.0);
        two_sum(product, lost)
    }
}

impl Twice {
    /// Three steps of long division.
    fn over(self, by: Self) -> Self {
        let first = self.0 / by.0;
        let rest = self - by * first.into();
        let second = rest.0 / by.0;
        let third = (rest - by * second.into()).0 / by.0;
        two_sum(first, second) + third.into()
    }
}

#[test]
fn twice_the_digits_are_there() {
    let third = Twice::from(1.0).over(3.0.into());
    let off = third * 3.0.into() - 1.0.into();
    assert!(off.0.abs() < 1e-31, "{off:?}");
    let tiny = Twice::from(1.0) + 1e-25.into() - 1.0.into();
    assert!((tiny.0 / 1e-25 - 1.0).abs() < 1e-6, "{tiny:?}");
}

/// De Boor's algorithm on the span that begins at knot `span`.
fn value(of: &Function<f64>, span: usize, u: Twice) -> Twice {
    let (p, t) = (of.space().degree(), of.space().flat());
    let vertex = |k: usize| Twice::from(of.coefficients()[of.space().vertex(k)]);
    let mut own: Vec<Twice> = (span - p..=span).map(vertex).collect();
    for round in 1..=p {
        for j in (round..=p).rev() {
            let (low, high) = (Twice::from(t[span - p + j]), Twice::from(t[span + 1 + j - round]));
            let share = (u - low).over(high - low);
            own[j] = own[j - 1] + (own[j] - own[j - 1]) * share;
        }
    }
    own[p]
}

/// The B-splines that live on a span, there.
fn basis(space: &Space, span: usize, u: f64) -> Vec<f64> {
    let t = space.flat();
    let mut out = vec![1.0];
    for r in 1..=space.degree() {
        let mut next = vec![0.0; r + 1];
        for (j, own) in out.iter().enumerate() {
            let (low, high) = (t[span + 1 + j - r], t[span + 1 + j]);
            let share = (u - low) / (high - low);
            next[j] += own * (1.0 - share);
            next[j + 1] += own * share;
        }
        out = next;
    }
    out
}

/// By how much errors of the Bernstein coefficients of a piece grow in each coefficient of a product, the best piece of its support: the sum of the absolute
/// polar forms of the piece's Bernstein polynomials at the coefficient's own knots is at most `Π (|1 - x| + |x|)`, `x` being a knot from 0 to 1
/// along the piece. 1 where these are ends of one piece.
fn growth(space: &Space) -> Vec<f64> {
    let (degree, t) = (space.degree(), space.flat());
    let mut all = vec![f64::INFINITY; space.len()];
    for k in 0..space.unrolled_len() {
        let best = &mut all[space.vertex(k)];
        for w in t[k..=k + degree + 1].windows(2).filter(|w| w[0] < w[1]) {
            // Pieces of the domain alone are known.
            if w[0] < space.domain().0 || w[1] > space.domain().1 {
                continue;
            }
            let along = t[k + 1..=k + degree].iter().map(|x| (x - w[0]) / (w[1] - w[0]));
            *best = best.min(along.map(|x| (1.0 - x).abs() + x.abs()).product());
        }
    }
    all
}

struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }

    /// In `[-1, 1]`.
    fn number(&mut self) -> f64 {
        self.below(2_000_001) as f64 / 1e6 - 1.0
    }
}

/// A space of a degree over some breakpoints, each inner knot repeated up to `most` times; clamped, floating or periodic.
fn space(degree: usize, breaks: &[f64], kind: usize, most: usize, dice: &mut Dice) -> Space {
    let inner = &breaks[1..breaks.len() - 1];
    // A closed line has no jumps but of steps.
    let most = if kind == 2 { most.min(degree.max(1)) } else { most.min(degree + 1) };
    let repeated = inner.iter().flat_map(|&k| {
        let times = dice.below(most + 1);
        std::iter::repeat_n(k, times)
    });
    let inner: Vec<f64> = repeated.collect();
    let (start, end) = (breaks[0], breaks[breaks.len() - 1]);
    let unit = (end - start) / breaks.len() as f64;
    let beyond = |k: usize| if kind == 1 { k as f64 * unit * 0.7 } else { 0.0 };
    if kind == 2 {
        let knots = [&[start][..], &inner, &[end]].concat();
        if let Ok(space) = Space::periodic(degree, knots) {
            return space;
        }
    }
    let before = (0..=degree).rev().map(|k| start - beyond(k));
    let after = (0..=degree).map(|k| end + beyond(k));
    Space::open(degree, before.chain(inner.iter().copied()).chain(after).collect()).unwrap()
}

/// Breakpoints at random, their distances as unlike as `spread`, over a domain of a size.
fn breaks(count: usize, spread: f64, size: f64, dice: &mut Dice) -> Vec<f64> {
    let mut all = vec![dice.number() * size];
    for _ in 0..count {
        let last = all[all.len() - 1];
        all.push(last + spread.powf(0.5 * (dice.number() - 1.0)) * size);
    }
    all
}

/// Whatever the factors, errors are what the machine's numbers make of Bernstein coefficients, grown as extrapolation makes them grow, and no more.
///
/// The coefficients of a product are means of products of the factors' (positive weights of sum 1, Mørken 1991): that alone would lose one `ε` of
/// `max |a| max |b|`. On a piece both factors are brought to Bernstein form by insertions of knots, at most `p` and `q` convex combinations, whose
/// shares are off by `3 ε` each; a Bernstein coefficient of the product is a mean of at most `min(p, q) + 1` of their products, by weights that are
/// off by `3 ε`. So each is off by `ε (4 p + 4 q + 8)` of `max |a| max |b|` at most. A coefficient of the product is their combination by
/// the polar forms at its knots, whose shares and sum add `4 (p + q)` such roundings, and whose absolute values sum up to its *growth*. Its
/// part of the value at a place is what the B-spline there is.
///
/// Of even simple knots the growth is `Π (1 + 2 d)` over lengths `d` beyond the piece in the middle, more than any power of `p + q`; repeated knots have less.
#[test]
fn products_lose_what_extrapolation_makes_of_rounding() {
    let (mut most, mut worst_growth, mut torn, mut places) = (0.0_f64, 0.0_f64, 0, 0);
    let mut dice = Dice(5);
    let mut degrees: Vec<(usize, usize)> = (1..=7).flat_map(|p| (0..=7).map(move |q| (p, q))).collect();
    degrees.extend([(25, 0), (24, 1), (18, 7), (13, 12), (12, 12), (0, 25), (1, 24)]);
    for (p, q) in degrees {
        for round in 0..12 {
            let size = [1.0, 1e-9, 1e9][round % 3];
            let [x, y] = [[1.0, 1.0], [1e-9, 1e9], [1e9, 1e9], [1e-9, 1e-9]][round % 4];
            let all = breaks(3 + dice.below(5), [1.0, 10.0, 1e4][dice.below(3)], size, &mut dice);
            // The factors have some breakpoints in common, and each some of its own.
            let mut of = |degree: usize| {
                let kind = dice.below(3);
                let most = [1, degree.max(1), degree + 1][dice.below(3)];
                space(degree, &all, kind, most, &mut dice)
            };
            let (a, b) = (of(p), of(q));
            let mut function = |space: &Space, by: f64| {
                let numbers = (0..space.len()).map(|_| dice.number() * by).collect();
                Function::new(space.clone(), numbers).unwrap()
            };
            let (f, g) = (function(&a, x), function(&b, y));
            let product = a.product(&b).unwrap();
            let prepared = product.combine(&f, &g, |a, b| a * b).unwrap();
            let growth = growth(product.space());
            let largest = |f: &Function<f64>| f.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
            let scale = largest(&f) * largest(&g);
            let roundings = (8 * (p + q) + 8) as f64 * f64::EPSILON;
            torn += usize::from(a.most_repeated() == p + 1 || b.most_repeated() == q + 1);
            for found in [f.times(&g).unwrap(), prepared] {
                let space = found.space();
                // In one piece of degree 0 the other is a number, and the product is in the space of the one.
                let growth = if space == product.space() { growth.clone() } else { vec![1.0; space.len()] };
                for span in space.spans() {
                    let [low, high] = [space.flat()[span], space.flat()[span + 1]];
                    for share in [0.0, 0.21, 0.5, 0.93] {
                        let u = low + (high - low) * share;
                        let at = |f: &Function<f64>| value(f, f.space().span(u), u.into());
                        let wanted = at(&f) * at(&g);
                        let off = (value(&found, span, u.into()) - wanted).0.abs();
                        let allowed: f64 = basis(space, span, u)
                            .iter()
                            .enumerate()
                            .map(|(j, n)| n * growth[space.vertex(span - space.degree() + j)])
                            .sum();
                        assert!(
                            off <= allowed * roundings * scale,
                            "{p} {q} {round}: {off:e} at {u}, {:e} of what is allowed, growth {allowed:e}\n{a:?}\n{b:?}",
                            off / (allowed * roundings * scale)
                        );
                        most = most.max(off / (allowed * roundings * scale));
                        worst_growth = worst_growth.max(allowed);
                        places += 1;
                    }
                }
            }
            // As a linear map of the second factor it is the same, coefficient by coefficient.
            let rows = product.with_first(&f);
            let prepared = product.combine(&f, &g, |a, b| a * b).unwrap();
            for (k, row) in rows.chunks(q + 1).enumerate() {
                let sum: f64 = row.iter().map(|(j, by)| by * g.coefficients()[*j]).sum();
                let off = (sum - prepared.coefficients()[k]).abs();
                assert!(off <= 2.0 * growth[k] * roundings * scale, "{p} {q} {round}, {k}: {off:e}");
            }
        }
    }
    println!("{most:e} of what is allowed, growth up to {worst_growth:e}, {places} places, {torn} torn");
    assert!(places > 20_000 && torn > 50, "{places} {torn}");
    // The bound is no idle one.
    assert!(most > 0.01, "{most:e}");
}
