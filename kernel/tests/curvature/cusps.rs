//! Beside a cusp rounding decides the curvature: refused, or met.

use loftsman_kernel::Point;
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{curvature, signed_curvature};
use loftsman_kernel::spline::{Curve, Space};

use super::book::Random;

fn cusp(scale: f64, turn: f64) -> Curve {
    let (sin, cos) = turn.sin_cos();
    let at = |x: f64, y: f64| Point::new(scale * (x * cos - y * sin), scale * (x * sin + y * cos), 0.0);
    let points = vec![at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0), at(1.0, 0.0)];
    Curve::new(Space::clamped(3, &[0.0, 1.0]).unwrap(), points).unwrap()
}

/// The curvature of the control vertices as they are, with errors that double precision does not make: `C'` and `C''` by
/// differences of exact products (Dekker), since these are what cancels.
fn kappa(curve: &Curve, u: f64) -> f64 {
    let p = curve.points();
    let sum = |terms: &[(f64, f64)]| -> f64 {
        let (mut high, mut low) = (0.0_f64, 0.0_f64);
        for &(a, b) in terms {
            let product = a * b;
            let total = high + product;
            let back = total - high;
            low += (high - (total - back)) + (product - back) + a.mul_add(b, -product);
            high = total;
        }
        high + low
    };
    let v = 1.0 - u;
    let basis = [
        [-3.0 * v * v, 3.0 * v * v - 6.0 * u * v, 6.0 * u * v - 3.0 * u * u, 3.0 * u * u],
        [6.0 * v, 6.0 * u - 12.0 * v, 6.0 * v - 12.0 * u, 6.0 * u],
    ];
    let along = |d: usize, axis: usize| sum(&[0, 1, 2, 3].map(|i| (basis[d][i], p[i][axis])));
    let ((x1, y1), (x2, y2)) = ((along(0, 0), along(0, 1)), (along(1, 0), along(1, 1)));
    sum(&[(x1, y2), (-y1, x2)]) / x1.hypot(y1).powi(3)
}

#[test]
fn the_one_that_was_missed() {
    let curve = cusp(1.0, 0.0);
    let error =
        Edit::new(&curve).ask(signed_curvature(0.500000001, [0.0, 0.0, 1.0]).scale(2.0)).solve().unwrap_err();
    assert!(error.to_string().contains("cannot be resolved"), "{error}");
}

#[test]
fn beside_cusps_of_all_sizes() {
    let (mut met, mut refused) = (0, 0);
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let curve = cusp(random.of(&[1.0, 1e-6, 1e6, 3.7]), random.between(0.0, 6.0));
        let away = 10.0_f64.powf(random.between(-12.0, -0.5));
        let u = 0.5 + away * random.of(&[-1.0, 1.0]);
        let edit = Edit::new(&curve);
        let signed = random.below(2) == 0;
        let factor = random.of(&[2.0, 0.5, 1.1]);
        let asked = if signed {
            edit.ask(signed_curvature(u, [0.0, 0.0, 1.0]).scale(factor))
        } else {
            edit.ask(curvature(u).scale(factor))
        };
        let wanted = factor * kappa(&curve, u);
        match asked.solve() {
            Ok(edited) => {
                met += 1;
                let found = kappa(edited.shape(), u);
                assert!(
                    (found.abs() - wanted.abs()).abs() < 1e-5 * wanted.abs(),
                    "{seed}: {u}: {found:e} for {wanted:e}"
                );
            }
            Err(error) => {
                refused += 1;
                assert!(away < 1e-2, "{seed}: {u}: {error}");
            }
        }
    }
    println!("{met} met, {refused} refused");
    assert!(met > 60 && refused > 60, "{met} met, {refused} refused");
}

#[test]
fn a_curvature_out_of_all_proportion_is_called_that() {
    for scale in [1e-6, 1.0, 1e6] {
        let curve = cusp(scale, 0.3);
        let ask = |kappa: f64| Edit::new(&curve).ask(curvature(0.2).to(kappa / scale)).solve();
        ask(50.0).unwrap();
        for kappa in [1e13, -1e30, 1e200] {
            let error = ask(kappa).unwrap_err().to_string();
            assert!(error.contains("out of all proportion") && error.contains("ask for less"), "{error}");
            assert!(!error.contains("stands still"), "{error}");
        }
        // What is nearer to the limit is met, or refused with both reasons.
        if let Err(error) = ask(1e11) {
            assert!(error.to_string().contains("for less"), "{error}");
        }
    }
}
