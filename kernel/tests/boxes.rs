//! The box around what loops leave of a surface, against closed forms.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use loftsman_kernel::nalgebra::{Matrix4, Rotation3};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// The paraboloid `(u, v, (u² + v²) / 4)` over `-4 … 4`, times a size, raised to a degree and with knots inserted, one of them as often as `creased` says.
fn bowl(degree: usize, creased: usize, size: f64) -> Surface {
    let space = || Space::clamped(2, &[-4.0, 4.0]).unwrap();
    // The vertices of u² over a … b are a², a b, b².
    let squares = [16.0, -16.0, 16.0];
    let at = [-4.0, 0.0, 4.0];
    let points = (0..9).map(|k| (k / 3, k % 3));
    let points = points.map(|(i, j)| Point::new(at[i], at[j], (squares[i] + squares[j]) / 4.0) * size);
    let mut surface = Surface::new(space(), space(), points.collect()).unwrap();
    for direction in [Direction::U, Direction::V] {
        surface = surface.elevate(direction, degree - 2).unwrap();
        let knots: Vec<f64> = std::iter::repeat_n(0.7, creased.min(degree)).chain([-1.1, 2.3]).collect();
        surface = surface.insert_knots(direction, &knots).unwrap();
    }
    surface
}

fn circle(middle: [f64; 2], radius: f64) -> Vec<ParameterCurve> {
    let middle = Point::new(middle[0], middle[1], 0.0);
    vec![ParameterCurve::whole(Curve::circle(middle, Vector::z(), radius).unwrap()).unwrap()]
}

fn polygon(corners: &[[f64; 2]]) -> Vec<ParameterCurve> {
    let at = |k: usize| Point::new(corners[k % corners.len()][0], corners[k % corners.len()][1], 0.0);
    let side = |k: usize| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap();
    (0..corners.len()).map(side).collect()
}

fn of(surface: Surface, outer: Vec<ParameterCurve>, holes: Vec<Vec<ParameterCurve>>) -> Trimmed {
    Trimmed::new(surface, vec![Region { outer, holes }], vec![], vec![]).unwrap()
}

fn check(trimmed: &Trimmed, low: [f64; 3], high: [f64; 3], size: f64, what: &str) {
    let found = trimmed.bounds().unwrap();
    for k in 0..3 {
        let (below, above) = (found.0[k] - low[k] * size, found.1[k] - high[k] * size);
        assert!(
            below.abs() <= 2e-11 * size && above.abs() <= 2e-11 * size,
            "{what} {k}: {below:e} {above:e}"
        );
    }
}

/// Discs of a bowl: with its lowest point inside, or outside, or on the border; discs that are holes, so that the border bends the other way.
#[test]
fn discs_of_a_bowl() {
    for (degree, creased, size) in
        [(2, 0, 1.0), (2, 1, 1e-6), (3, 2, 1.0), (3, 3, 1e6), (5, 1, 1.0), (7, 7, 1.0), (25, 1, 1.0)]
    {
        for (x, y, r) in
            [(0.0, 0.0, 1.0), (0.5, -0.3, 1.0), (1.5, 1.0, 1.3), (-0.6, 0.8, 1.0), (2.0, -1.0, 2.0)]
        {
            let away = f64::hypot(x, y);
            let low = if away <= r { 0.0 } else { (away - r).powi(2) / 4.0 };
            let high = (away + r).powi(2) / 4.0;
            let what = format!("{degree} {creased} {size} {x} {y} {r}");
            let disc = of(bowl(degree, creased, size), circle([x, y], r), vec![]);
            check(&disc, [x - r, y - r, low], [x + r, y + r, high], size, &what);
            // All but the disc.
            let rest = of(bowl(degree, creased, size), vec![], vec![circle([x, y], r)]);
            let low = if away < r { (r - away).powi(2) / 4.0 } else { 0.0 };
            check(&rest, [-4.0, -4.0, low], [4.0, 4.0, 8.0], size, &format!("{what}, a hole"));
        }
    }
}

/// The whole of a surface has the whole's box, also by a loop round its domain.
#[test]
fn all_of_a_surface() {
    for outer in [vec![], polygon(&[[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])] {
        check(&of(bowl(3, 0, 1.0), outer, vec![]), [-4.0, -4.0, 0.0], [4.0, 4.0, 8.0], 1.0, "all");
    }
    let all = Trimmed::new(bowl(3, 0, 1.0), vec![], vec![], vec![]).unwrap();
    assert_eq!(all.bounds().unwrap(), bowl(3, 0, 1.0).bounds());
}

/// Two regions, and a sliver along a diagonal, turned in space: extremes on the border, at corners, in between.
#[test]
fn slivers_and_several_regions() {
    let (a, b) = (polygon(&[[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]]), circle([-2.0, -2.0], 0.5));
    let regions = [a, b].map(|outer| Region { outer, holes: vec![] }).to_vec();
    let two = Trimmed::new(bowl(3, 1, 1.0), regions, vec![], vec![]).unwrap();
    let away = f64::hypot(2.0, 2.0);
    check(&two, [-2.5, -2.5, 0.5], [2.0, 2.0, (away + 0.5).powi(2) / 4.0], 1.0, "two");
    // Along v = u, 1e-6 wide: z = u² / 2 there.
    let thin = polygon(&[[-1.0, -1.0], [3.0, 3.0], [3.0, 3.000_001], [-1.0, -0.999_999]]);
    let high = (9.0 + 3.000_001_f64.powi(2)) / 4.0;
    check(&of(bowl(2, 0, 1.0), thin, vec![]), [-1.0, -1.0, 0.0], [3.0, 3.000_001, high], 1.0, "thin");
    // Turned by 45° about x: the height is (y + z) / √2 of the flat one.
    let turn: Matrix4<f64> = Rotation3::from_axis_angle(&Vector::x_axis(), PI / 4.0).to_homogeneous();
    let turned = bowl(2, 1, 1.0).transformed(&turn).unwrap();
    // y + y²/4 + x²/4 over a disc about (0, -2): least inside, at y = -2, where it is -1; y - z highest there as well? z - y: only at the border.
    let disc = of(turned, circle([0.0, -2.0], 1.0), vec![]);
    let (_, high) = disc.bounds().unwrap();
    let low = disc.bounds().unwrap().0;
    assert!((low.z + FRAC_1_SQRT_2).abs() < 1e-11, "{low}");
    // The highest on the circle: x = cos t, y = -2 + sin t: (y + 2)²/4 - 1 + x²/4 = 1/4 - 1 all around.
    assert!((high.z + 0.75 * FRAC_1_SQRT_2).abs() < 1e-11, "{high}");
}

/// A roof whose crease a disc contains: highest along the crease, where no derivative vanishes.
#[test]
fn a_crease_inside_counts() {
    for degree in 1..5 {
        let space = Space::clamped(1, &[-2.0, 0.0, 2.0]).unwrap();
        let flat = Space::clamped(1, &[-2.0, 2.0]).unwrap();
        let points = [-2.0, 0.0, 2.0_f64]
            .iter()
            .flat_map(|x| [-2.0, 2.0].map(|y| Point::new(*x, y, 1.0 - x.abs() - 0.1 * y)))
            .collect();
        let mut roof = Surface::new(space, flat, points).unwrap();
        for direction in [Direction::U, Direction::V] {
            roof = roof.elevate(direction, degree - 1).unwrap();
        }
        let disc = of(roof, circle([0.2, 0.0], 1.0), vec![]);
        // On the crease, at the lower end of what the disc has of it; lowest on the border where the slope is.
        let high = 1.0 + 0.1 * (1.0 - 0.04_f64).sqrt();
        let low = 1.0 - 0.2 - (1.0 + 0.01_f64).sqrt();
        check(&disc, [-0.8, -1.0, low], [1.2, 1.0, high], 1.0, &format!("roof {degree}"));
    }
}

/// Windows of a rational tube, its highest line inside or outside: coordinates are those of arcs.
#[test]
fn windows_of_a_tube() {
    let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, 5.0)).unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), 2.0 * PI).unwrap();
    let ((a, b), (c, d)) = (tube.u().domain(), tube.v().domain());
    let angle = |u: f64| {
        let p = tube.point(u, c).unwrap();
        p.y.atan2(p.x)
    };
    for (from, to) in [(0.05, 0.2), (0.1, 0.4), (0.3, 0.9), (0.55, 0.7)] {
        let (u0, u1) = (a + (b - a) * from, a + (b - a) * to);
        let (v0, v1) = (c + (d - c) * 0.25, c + (d - c) * 0.5);
        let window = of(tube.clone(), polygon(&[[u0, v0], [u1, v0], [u1, v1], [u0, v1]]), vec![]);
        let heights = [tube.point(u0, v0).unwrap().z, tube.point(u0, v1).unwrap().z];
        let start = angle(u0);
        let sweep = (angle(u1) - start).rem_euclid(2.0 * PI);
        let reach = |toward: f64| {
            // The largest cosine from a direction over the arc.
            let before = (toward - start).rem_euclid(2.0 * PI);
            if before <= sweep { 1.0 } else { (start - toward).cos().max((start + sweep - toward).cos()) }
        };
        let low = [-2.0 * reach(PI), -2.0 * reach(1.5 * PI), heights[0].min(heights[1])];
        let high = [2.0 * reach(0.0), 2.0 * reach(0.5 * PI), heights[0].max(heights[1])];
        check(&window, low, high, 1.0, &format!("{from} {to}"));
    }
}
