use proptest::prelude::*;

use super::*;
use crate::Vector;
use crate::quadrature::gauss_legendre;
use crate::space::Space;
use crate::spline::Direction;
use crate::spline::testing::{any_space, parameters};

/// Coefficients that are no pattern.
fn noise(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| ((i * 37 + seed * 11) % 23) as f64 / 5.0 - 2.0).collect()
}

fn vectors(n: usize, seed: usize) -> Vec<Vector> {
    let (x, y, z) = (noise(n, seed), noise(n, seed + 1), noise(n, seed + 5));
    (0..n).map(|i| Vector::new(x[i], y[i], z[i])).collect()
}

/// Two spaces over one domain: the second one's knots are brought to the first one's domain; some then coincide.
fn two_spaces() -> impl Strategy<Value = (Space, Space)> {
    let degrees = || prop_oneof![8 => 1..=5_usize, 1 => Just(12_usize)];
    (any_space(degrees()), any_space(degrees()), any::<bool>()).prop_map(|(a, b, same)| {
        if same {
            // The same knots, a degree lower: what fine tuning multiplies.
            let lower = a.derived().unwrap_or_else(|_| a.clone());
            return (lower, a);
        }
        let ((c, d), (e, f)) = (a.domain(), b.domain());
        let moved = |k: f64| {
            if k == e {
                c
            } else if k == f {
                d
            } else {
                c + (k - e) / (f - e) * (d - c)
            }
        };
        let knots: Vec<f64> = b.knots().iter().map(|k| moved(*k)).collect();
        let b =
            if b.is_periodic() { Space::periodic(b.degree(), knots) } else { Space::open(b.degree(), knots) };
        (a, b.unwrap())
    })
}

/// Places inside the pieces of two spaces: at knots either may jump.
fn inside(a: &Space, b: &Space) -> Vec<f64> {
    let mut all = bernstein::partition(a, b).unwrap();
    all.dedup();
    all.windows(2).flat_map(|w| [0.07, 0.5, 0.93].map(|s| w[0] + s * (w[1] - w[0]))).collect()
}

proptest! {
    #[test]
    fn products_are_products((a, b) in two_spaces(), seed in 0..50_usize) {
        let f = Function::new(a.clone(), vectors(a.len(), seed)).unwrap();
        let g = Function::new(b.clone(), noise(b.len(), seed + 3)).unwrap();
        let found = f.times(&g).unwrap();
        prop_assert!(a.is_periodic() && b.is_periodic() || !found.space().is_periodic());
        let digits = 1e-13 * 3.0_f64.powi((a.degree() + b.degree()) as i32 / 2);
        for u in inside(&a, &b) {
            let expected = f.value(u).unwrap() * g.value(u).unwrap();
            let error = (found.value(u).unwrap() - expected).norm();
            prop_assert!(error < 10.0 * digits, "{} at {} of {:?} {:?}", error, u, a, b);
        }
        // Prepared with one factor it is the same.
        let product = a.product(&b).unwrap();
        let rows = product.with_first(&f);
        for (row, c) in rows.chunks(b.degree() + 1).zip(found.coefficients()) {
            let sum = row.iter().fold(Vector::zeros(), |sum, (k, by)| sum + by * g.coefficients()[*k]);
            prop_assert!((sum - c).norm() < 1e2 * digits);
        }
    }

    #[test]
    fn integrals_are_undone_by_derivatives(a in any_space(prop_oneof![8 => 1..=5_usize, 1 => Just(24_usize)]), seed in 0..50_usize) {
        let f = Function::new(a.clone(), vectors(a.len(), seed)).unwrap();
        let start = Vector::new(1.0, -2.0, 3.0);
        let integral = f.integral(start).unwrap();
        let (begin, end) = integral.space().domain();
        prop_assert!((integral.value(begin).unwrap() - start).norm() < 1e-11);
        let total = integral.value(end).unwrap() - start;
        prop_assert!((total - f.total().unwrap()).norm() < 1e-10, "{total} {:?}", f.total());
        let (nodes, weights) = gauss_legendre(a.degree() / 2 + 1);
        let breakpoints = a.breakpoints();
        let mut sum = Vector::zeros();
        for w in breakpoints.windows(2) {
            for (x, weight) in nodes.iter().zip(&weights) {
                sum += f.value(w[0] + x * (w[1] - w[0])).unwrap() * (*weight * (w[1] - w[0]));
            }
            // Short of the knot, where it may jump.
            let found = integral.value(w[1]).unwrap() - start;
            prop_assert!((found - sum).norm() < 1e-10, "{found} is not {sum} at {}", w[1]);
        }
        // The integral's derivative is the function, where it has no jumps that no space of one degree more derives.
        if let Ok(back) = integral.derivative() {
            for u in inside(&a, &a) {
                prop_assert!((back.value(u).unwrap() - f.value(u).unwrap()).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn inner_products_are_integrals_of_products((a, b) in two_spaces(), seed in 0..50_usize) {
        let rows = a.inner_products(&b).unwrap();
        let (x, y) = (noise(a.len(), seed), noise(b.len(), seed + 7));
        let sum: f64 = (0..a.len()).map(|i| x[i] * rows.iter_row(i).map(|(k, w)| w * y[k]).sum::<f64>()).sum();
        let f = Function::new(a.clone(), x).unwrap();
        let g = Function::new(b.clone(), y).unwrap();
        let inner = f.inner(&g).unwrap();
        prop_assert!((sum - inner).abs() < 1e-10 * 3.0_f64.powi((a.degree() + b.degree()) as i32 / 2), "{} {}", sum, inner);
        // Against the constant 1, of degree 0, they are the integrals.
        let one = Space::open(0, vec![a.domain().0, a.domain().1]).unwrap();
        let rows = a.inner_products(&one).unwrap();
        for (i, integral) in a.integrals().into_iter().enumerate() {
            let sum: f64 = rows.iter_row(i).map(|(_, w)| w).sum();
            prop_assert!((integral - sum).abs() < 1e-13, "{integral} is not {sum}");
        }
    }

    #[test]
    fn maps_are_maps_of_values((a, b) in two_spaces(), seed in 0..50_usize) {
        let turn = |v: Vector| Vector::new(0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y, -2.5 * v.z);
        let along = |v: Vector| 3.0 * v.x - v.y + 0.5 * v.z;
        let f = Function::new(a.clone(), vectors(a.len(), seed)).unwrap();
        let (turned, number) = (f.mapped(turn).unwrap(), f.mapped(along).unwrap());
        for u in inside(&a, &b) {
            let value = f.value(u).unwrap();
            prop_assert!((turned.value(u).unwrap() - turn(value)).norm() < 1e-12);
            prop_assert!((number.value(u).unwrap() - along(value)).abs() < 1e-12);
        }
        let field = Field::new(a.clone(), b.clone(), vectors(a.len() * b.len(), seed)).unwrap();
        let (turned, number) = (field.mapped(turn).unwrap(), field.mapped(along).unwrap());
        for u in inside(&a, &a) {
            for v in inside(&b, &b) {
                let value = field.value(u, v).unwrap();
                prop_assert!((turned.value(u, v).unwrap() - turn(value)).norm() < 1e-12);
                prop_assert!((number.value(u, v).unwrap() - along(value)).abs() < 1e-12);
            }
        }
        prop_assert!(f.mapped(|v| v * f64::MAX * f64::MAX).is_err());
    }

    #[test]
    fn sums_are_sums((a, b) in two_spaces(), seed in 0..50_usize) {
        let f = Function::new(a.clone(), vectors(a.len(), seed)).unwrap();
        let g = Function::new(b.clone(), vectors(b.len(), seed + 3)).unwrap();
        let Ok(sum) = f.plus(-0.5, &g) else {
            prop_assert!(a.degree() == 0 || b.degree() == 0, "{:?}", f.plus(-0.5, &g));
            return Ok(());
        };
        for u in inside(&a, &b) {
            let expected = f.value(u).unwrap() - g.value(u).unwrap() * 0.5;
            prop_assert!((sum.value(u).unwrap() - expected).norm() < 1e-10);
        }
    }

    #[test]
    fn fields_too((a, b) in two_spaces(), (c, d) in two_spaces(), seed in 0..50_usize) {
        prop_assume!(a.degree() + b.degree() < 8 && c.degree() + d.degree() < 8);
        let f = Field::new(a.clone(), c.clone(), vectors(a.len() * c.len(), seed)).unwrap();
        let g = Field::new(b.clone(), d.clone(), noise(b.len() * d.len(), seed)).unwrap();
        let product = f.times(&g).unwrap();
        let along = Function::new(d.clone(), noise(d.len(), seed + 1)).unwrap();
        let partly = f.times_along(Direction::V, &along).unwrap();
        for u in inside(&a, &b).into_iter().step_by(4) {
            for v in inside(&c, &d).into_iter().step_by(4) {
                let own = f.value(u, v).unwrap();
                let expected = own * g.value(u, v).unwrap();
                prop_assert!((product.value(u, v).unwrap() - expected).norm() < 1e-9);
                let expected = own * along.value(v).unwrap();
                prop_assert!((partly.value(u, v).unwrap() - expected).norm() < 1e-9);
            }
        }
        let twice = product.integral(Direction::U).unwrap().integral(Direction::V).unwrap();
        let (end, last) = (twice.space(Direction::U).domain().1, twice.space(Direction::V).domain().1);
        prop_assert!((twice.value(end, last).unwrap() - product.total().unwrap()).norm() < 1e-8);
        for direction in [Direction::U, Direction::V] {
            is_derived(&f, direction)?;
        }
        // By both parameters, in either order.
        let both = |one: Direction, other: Direction| f.derivative(one).and_then(|slope| slope.derivative(other));
        let orders = [(Direction::U, Direction::V), (Direction::V, Direction::U)];
        if let [Ok(one), Ok(other)] = orders.map(|(one, other)| both(one, other)) {
            for u in inside(&a, &a).into_iter().step_by(4) {
                for v in inside(&c, &c).into_iter().step_by(4) {
                    let (x, y) = (one.value(u, v).unwrap(), other.value(u, v).unwrap());
                    prop_assert!((x - y).norm() < 1e-11 * (1.0 + x.norm()), "{x} {y}");
                }
            }
        }
    }
}

/// The derivative of a field in a direction: within a piece, differences are its integrals, of which Gauss points miss nothing.
fn is_derived(field: &Field<Vector>, direction: Direction) -> Result<(), TestCaseError> {
    let across = if direction == Direction::U { Direction::V } else { Direction::U };
    let (space, other) = (field.space(direction), field.space(across));
    let Ok(slope) = field.derivative(direction) else {
        prop_assert!(space.derived().is_err());
        return Ok(());
    };
    let at = |of: &Field<Vector>, x: f64, y: f64| match direction {
        Direction::U => of.value(x, y).unwrap(),
        Direction::V => of.value(y, x).unwrap(),
    };
    let (nodes, weights) = gauss_legendre(space.degree() / 2 + 1);
    for piece in inside(space, space).chunks(3) {
        let (low, length) = (piece[0], piece[2] - piece[0]);
        for y in inside(other, other).into_iter().step_by(3) {
            let gauss = nodes
                .iter()
                .zip(&weights)
                .map(|(x, weight)| at(&slope, low + x * length, y) * (weight * length));
            let found = gauss.sum::<Vector>();
            let expected = at(field, piece[2], y) - at(field, low, y);
            prop_assert!(
                (found - expected).norm() < 1e-11,
                "{found} is not {expected} at {low}, {y} by {direction:?}"
            );
        }
    }
    Ok(())
}

/// High degrees on even knots, where supports have many pieces.
#[test]
fn high_degrees_lose_nothing() {
    for (p, q) in [(8, 8), (12, 12), (15, 0), (15, 9), (24, 1)] {
        let a = Space::clamped_uniform(p, p + 9).unwrap();
        let b = Space::clamped(q, &a.breakpoints()).unwrap();
        let f = Function::new(a.clone(), noise(a.len(), 1)).unwrap();
        let g = Function::new(b.clone(), noise(b.len(), 2)).unwrap();
        let product = f.times(&g).unwrap();
        let mut most = 0.0_f64;
        for u in parameters(0.0, a.domain().1).take(64) {
            let expected = f.value(u).unwrap() * g.value(u).unwrap();
            most = most.max((product.value(u).unwrap() - expected).abs());
        }
        assert!(most < 1e-10, "{p} {q}: {most:e}");
    }
}

/// Intervals of very unlike lengths: each coefficient is taken from the longest piece that it can be.
#[test]
fn graded_knots_lose_nothing() {
    for ratio in [10.0, 1e3, 1e6] {
        let mut knots = vec![0.0; 4];
        let mut at = 0.0;
        for i in 0..12 {
            at += if i % 3 == 0 { ratio } else { 1.0 };
            knots.push(at);
        }
        knots.extend([at; 3]);
        let a = Space::open(3, knots).unwrap();
        let b = a.derived().unwrap();
        let f = Function::new(a.clone(), noise(a.len(), 1)).unwrap();
        let g = Function::new(b.clone(), noise(b.len(), 2)).unwrap();
        let product = f.times(&g).unwrap();
        for u in parameters(0.0, at).take(32) {
            let expected = f.value(u).unwrap() * g.value(u).unwrap();
            assert!((product.value(u).unwrap() - expected).abs() < 1e-13, "{ratio} {u}");
        }
        let largest = product.coefficients().iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        assert!(largest < 20.0, "{largest}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let a = Space::clamped_uniform(3, 8).unwrap();
    let b = Space::clamped_uniform(3, 9).unwrap();
    assert!(a.product(&b).unwrap_err().to_string().contains("no common domain"));
    let high = Space::clamped(20, &[0.0, 5.0]).unwrap();
    assert_eq!(high.product(&high).unwrap_err(), crate::Error::Degree { degree: 40 });
    assert!(Function::new(a.clone(), vec![1.0; 7]).unwrap_err().to_string().contains("7 coefficients"));
    let mut bad = vec![1.0; 8];
    bad[3] = f64::NAN;
    assert!(Function::new(a.clone(), bad).unwrap_err().to_string().contains("coefficient 3"));
    let huge = Function::new(a, vec![1e200; 8]).unwrap();
    assert!(huge.times(&huge).is_err());
}

/// The largest number of a running sum's errors does not grow with its length.
#[test]
fn a_million_knots_are_summed_to_rounding() {
    let n = 200_000;
    let space = Space::clamped_uniform(2, n).unwrap();
    let f = Function::constant(space, 0.1).unwrap();
    let integral = f.integral(0.0).unwrap();
    let (found, exact) = (integral.coefficients().last().copied().unwrap(), 0.1 * (n - 2) as f64);
    assert!((found - exact).abs() < 1e-15 * exact, "{found} {exact}");
}

/// A periodic function whose integral is zero has a periodic antiderivative; one whose is not has none.
#[test]
fn closed_integrals() {
    for p in 1..=6 {
        let space = Space::periodic(p, vec![0.0, 0.5, 0.5, 1.3, 2.0, 3.5, 3.9, 5.0])
            .unwrap_or_else(|_| Space::periodic_uniform(p, 7).unwrap());
        let f = Function::new(space.clone(), noise(space.len(), p)).unwrap();
        assert!(f.closed_integral(0.0).unwrap_err().to_string().contains("does not close"));
        let mean = f.total().unwrap() / space.length();
        let f = f.mapped(|c| c - mean).unwrap();
        let (closed, open) = (f.closed_integral(2.0).unwrap(), f.integral(2.0).unwrap());
        assert!(closed.space().is_periodic());
        for u in inside(&space, &space) {
            assert!((closed.value(u).unwrap() - open.value(u).unwrap()).abs() < 1e-13);
        }
    }
}

/// In Bézier pieces no digit is lost at any degree: knots repeated as often as the degree, and once more.
#[test]
fn products_of_pieces_lose_nothing() {
    for (p, q) in [(1, 1), (2, 7), (5, 6), (6, 6), (7, 7), (7, 18), (12, 13), (24, 1), (25, 0)] {
        for seed in 0..8 {
            let breakpoints = [0.0, 0.03, 1.0, 1.4, 5.0];
            let pieces = |degree: usize, times: usize| {
                let inner = breakpoints[1..4].iter().flat_map(|t| std::iter::repeat_n(*t, times));
                let knots = std::iter::repeat_n(0.0, degree + 1).chain(inner);
                let knots: Vec<f64> = knots.chain(std::iter::repeat_n(5.0, degree + 1)).collect();
                Space::open(degree, knots).unwrap()
            };
            let (a, b) = (pieces(p, p + seed % 2), pieces(q, q + usize::from(q == 0 || seed % 3 == 0)));
            let f = Function::new(a.clone(), vectors(a.len(), seed)).unwrap();
            let g = Function::new(b.clone(), noise(b.len(), seed + 3)).unwrap();
            let found = f.times(&g).unwrap();
            let inner = found.total().unwrap();
            for u in inside(&a, &b) {
                let expected = f.value(u).unwrap() * g.value(u).unwrap();
                let error = (found.value(u).unwrap() - expected).norm();
                assert!(error < 1e-13 * 40.0, "{p} {q} {seed}: {error:e} at {u}");
            }
            // The integral by Gauss's rule of as many nodes as make it exact.
            let (nodes, weights) = gauss_legendre((p + q) / 2 + 1);
            let mut sum = Vector::zeros();
            for w in breakpoints.windows(2) {
                for (x, weight) in nodes.iter().zip(&weights) {
                    let u = w[0] + x * (w[1] - w[0]);
                    sum += f.value(u).unwrap() * g.value(u).unwrap() * (*weight * (w[1] - w[0]));
                }
            }
            assert!((inner - sum).norm() < 1e-11, "{p} {q} {seed}: {inner} {sum}");
        }
    }
}
