//! Surfaces and α of all kinds, and what is measured of them.

use loftsman_fine_tuning::{Ends, FineTuneSurface, Scaling, surface_alpha_spaces};
use loftsman_kernel::spline::Direction::{U, V};
use loftsman_kernel::spline::algebra::{Field, Function};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// Numbers of a fixed sequence, in [0, 1).
pub(crate) struct Lcg(u64);

impl Lcg {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        (0..9).for_each(|_| {
            random.next();
        });
        random
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}

/// Clamped, floating or periodic, knots repeated up to corners now and then.
pub(crate) fn any_space(degree: usize, random: &mut Lcg) -> Space {
    let kind = random.below(3);
    let mut knots = Vec::new();
    let mut at = 0.0;
    for _ in 0..1 + random.below(4) {
        at += if random.below(5) == 0 { 0.05 } else { 0.3 + random.next() };
        let times = if random.below(4) == 0 { 1 + random.below(degree) } else { 1 };
        knots.extend(std::iter::repeat_n(at, times));
    }
    let end = at + 0.7;
    match kind {
        0 => {
            let all = [vec![0.0; degree + 1], knots, vec![end; degree + 1]].concat();
            Space::open(degree, all).unwrap()
        }
        1 => {
            let mut all: Vec<f64> = (0..=degree).map(|i| -0.4 * (degree - i) as f64).collect();
            all.extend(knots);
            all.extend((0..=degree).map(|i| end + 0.3 * i as f64));
            Space::open(degree, all).unwrap()
        }
        _ => {
            let mut all = [vec![0.0], knots, vec![end]].concat();
            while all.len() < degree + 3 {
                let last = all.pop().unwrap();
                all.extend([last, last + 0.5]);
            }
            Space::periodic(degree, all).unwrap()
        }
    }
}

/// A surface of degrees 1 to 7, of any size, plane or not, with a pole now and then.
pub(crate) fn any_surface(seed: u64) -> Surface {
    let mut random = Lcg::new(seed);
    let (p, q) = (1 + random.below(7), 1 + random.below(7));
    let (u, v) = (any_space(p, &mut random), any_space(q, &mut random));
    shaped(u, v, &mut random)
}

pub(crate) fn shaped(u: Space, v: Space, random: &mut Lcg) -> Surface {
    let size = [1.0, 1.0, 1e-9, 1e9][random.below(4)];
    let (flat, pole) = (random.below(4) == 0, random.below(5) == 0);
    let (rows, columns) = (u.len(), v.len());
    let mut points = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let (a, b) = (i as f64 / rows as f64 * 5.0, j as f64 / columns as f64 * 4.0);
            let mut noise = || 0.5 * random.next() - 0.25;
            let (x, y) = (a + noise(), b + noise());
            let z = if flat { 0.0 } else { (a + b).sin() + noise() };
            let at = if pole && i == 0 { Vector::new(0.0, 2.0, 0.5) } else { Vector::new(x, y, z) };
            points.push(Point::from(at * size));
        }
    }
    Surface::new(u, v, points).unwrap()
}

pub(crate) fn any_line(surface: &Surface, direction: Direction, random: &mut Lcg) -> Function<f64> {
    let [u, v] = surface_alpha_spaces(surface).unwrap();
    let space = if direction == U { u } else { v };
    let values = (0..space.len()).map(|_| 0.4 + 1.4 * random.next()).collect();
    Function::new(space, values).unwrap()
}

/// α(u, v) of degree `across` on even knots over the surface's domain, without jumps; periodic where the surface is.
pub(crate) fn any_net(
    surface: &Surface,
    knots: [usize; 2],
    degrees: [usize; 2],
    random: &mut Lcg,
) -> Field<f64> {
    let even = |space: &Space, count: usize, degree: usize| {
        let (a, b) = space.domain();
        let at = |i: usize| if i == count { b } else { a + (b - a) * i as f64 / count as f64 };
        let breakpoints: Vec<f64> = (0..=count).map(at).collect();
        if space.is_periodic() && count >= degree + 2 && degree > 0 {
            Space::periodic(degree, breakpoints).unwrap()
        } else {
            Space::clamped(degree, &breakpoints).unwrap()
        }
    };
    let (u, v) = (even(surface.u(), knots[0], degrees[0]), even(surface.v(), knots[1], degrees[1]));
    let values = (0..u.len() * v.len()).map(|_| 0.5 + random.next()).collect();
    Field::new(u, v, values).unwrap()
}

pub(crate) fn size(surface: &Surface) -> f64 {
    surface.points().iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

pub(crate) fn inside(space: &Space) -> Vec<f64> {
    let breakpoints = space.breakpoints();
    breakpoints.windows(2).flat_map(|w| [0.13, 0.71].map(|s| w[0] + s * (w[1] - w[0]))).collect()
}

pub(crate) fn places(surface: &Surface) -> Vec<(f64, f64)> {
    let all = inside(surface.v());
    inside(surface.u()).into_iter().flat_map(|u| all.iter().map(move |v| (u, *v))).collect()
}

pub(crate) fn slope(surface: &Surface, direction: Direction, (u, v): (f64, f64)) -> Vector {
    let (a, b) = if direction == U { (1, 0) } else { (0, 1) };
    surface.derivative(u, v, a, b).unwrap()
}

pub(crate) fn curvature(surface: &Surface, direction: Direction, (u, v): (f64, f64)) -> f64 {
    let second = if direction == U { (2, 0) } else { (0, 2) };
    let (first, second) =
        (slope(surface, direction, (u, v)), surface.derivative(u, v, second.0, second.1).unwrap());
    first.cross(&second).norm() / first.norm().powi(3)
}

/// `D_u = αS_u`, and of each line the curvature divided by α.
pub(crate) fn assert_scaled(
    given: &Surface,
    tuned: &Surface,
    direction: Direction,
    alpha: &dyn Fn(f64, f64) -> f64,
    case: u64,
) {
    let all = places(given);
    let largest = all.iter().fold(0.0_f64, |m, at| m.max(slope(given, direction, *at).norm()));
    for at in all {
        let (own, found, a) = (slope(given, direction, at), slope(tuned, direction, at), alpha(at.0, at.1));
        assert!(
            (found - own * a).norm() <= 1e-10 * largest * a.abs().max(1.0),
            "{case} {at:?}: {found} {}",
            own * a
        );
        if given.space(direction).degree() > 1 && own.norm() > 0.05 * largest && a > 0.05 {
            let (before, after) = (curvature(given, direction, at), curvature(tuned, direction, at));
            assert!((after - before / a).abs() <= 1e-7 * (before / a + 1.0 / size(given)), "{case} κ {at:?}");
        }
    }
}

pub(crate) fn distance(one: &Surface, other: &Surface) -> f64 {
    places(one)
        .into_iter()
        .fold(0.0_f64, |m, (u, v)| m.max((one.point(u, v).unwrap() - other.point(u, v).unwrap()).norm()))
}

pub(crate) fn free(surface: &Surface, scaling: Scaling) -> Surface {
    FineTuneSurface::new(surface, scaling).ends(Ends::Free).solve().unwrap().into_surface()
}

/// The surface in the degrees and with the knots that a tuned part of it needs, as the kernel makes it.
pub(crate) fn raised(surface: &Surface, tuned: &Surface) -> Surface {
    let mut all = surface.clone();
    for direction in [U, V] {
        let (own, to) = (all.space(direction).clone(), tuned.space(direction));
        if &own == to {
            continue;
        }
        if !own.is_periodic() {
            all = all.convert(direction, &own.clamping().unwrap()).unwrap();
        }
        all = all.elevate(direction, to.degree() - own.degree()).unwrap();
        let ends = own.domain();
        // Copies of a seam may be numbered with its start or with its end.
        let refined = [ends.1, ends.0].map(|left_out| {
            let lacking = |t: f64| {
                let end = t == left_out || (!own.is_periodic() && (t == ends.0 || t == ends.1));
                let times = if end { 0 } else { to.multiplicity(t) - all.space(direction).multiplicity(t) };
                std::iter::repeat_n(t, times)
            };
            let missing: Vec<f64> = to.breakpoints().into_iter().flat_map(lacking).collect();
            all.insert_knots(direction, &missing).unwrap()
        });
        let same = usize::from(refined[1].space(direction) == to);
        all = refined[same].clone();
    }
    all
}
