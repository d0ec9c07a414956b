//! Areas that are told once, of surfaces that fold over along lines that are no knots, against closed forms.

use std::f64::consts::PI;

use loftsman_area_volume::surface_area_of;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::folded::{area_of_triangles, random, torus};

/// A polynomial of two variables: `c u^i v^j`.
type Polynomial<'a> = &'a [(f64, usize, usize)];

/// The Bézier surface `(x(u, v), y(u, v), 0)` over the unit square, turned, moved and of another size: of `u^k` the coefficients are
/// `C(i, k) / C(p, k)`.
fn sheet([p, q]: [usize; 2], coordinates: [Polynomial<'_>; 2], size: f64) -> Surface {
    let choose = |n: usize, k: usize| (0..k).map(|j| (n as f64 - j as f64) / (j + 1) as f64).product::<f64>();
    let ordinate = |terms: Polynomial<'_>, i: usize, j: usize| -> f64 {
        let own =
            |(c, k, l): (f64, usize, usize)| c * choose(i, k) / choose(p, k) * choose(j, l) / choose(q, l);
        terms.iter().map(|&term| own(term)).sum()
    };
    // Two directions at right angles, of length 1.
    let (a, b) = (Vector::new(2.0, 1.0, 2.0) / 3.0, Vector::new(-2.0, 2.0, 1.0) / 3.0);
    let at = |i: usize, j: usize| {
        let [x, y] = coordinates.map(|terms| ordinate(terms, i, j));
        Point::from((a * x + b * y + Vector::new(0.3, -0.2, 0.5)) * size)
    };
    let net = (0..=p).flat_map(|i| (0..=q).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect();
    Surface::new(Space::clamped(p, &[0.0, 1.0]).unwrap(), Space::clamped(q, &[0.0, 1.0]).unwrap(), net)
        .unwrap()
}

/// Creases along a diagonal, a parabola and a circle of the parameters, which no rule and no knots follow: `|x_u y_v - x_v y_u|` is
/// `2 |v - u|`, `2 |v - u²|` and `4 |s² + t² - 1/4|` with `s = 2u - 1` and `t = 2v - 1`.
#[test]
fn what_folds_over_is_told() {
    let diagonal: [Polynomial<'_>; 2] = [&[(1.0, 1, 0)], &[(1.0, 0, 2), (-2.0, 1, 1), (1.0, 2, 0)]];
    let parabola: [Polynomial<'_>; 2] = [&[(1.0, 1, 0)], &[(1.0, 0, 2), (-2.0, 2, 1), (1.0, 4, 0)]];
    // x = s³/3 + s t² - s/4, y = t, by powers of u and v.
    let circle: [Polynomial<'_>; 2] = [
        &[
            (-1.0 / 3.0 - 1.0 + 0.25, 0, 0),
            (2.0 + 2.0 - 0.5, 1, 0),
            (-4.0, 2, 0),
            (8.0 / 3.0, 3, 0),
            (4.0, 0, 1),
            (-4.0, 0, 2),
            (-8.0, 1, 1),
            (8.0, 1, 2),
        ],
        &[(-1.0, 0, 0), (2.0, 0, 1)],
    ];
    let families = [
        ([2, 2], diagonal, 2.0 / 3.0),
        ([4, 2], parabola, 11.0 / 15.0),
        ([3, 2], circle, 5.0 / 3.0 + PI / 16.0),
    ];
    for (degrees, coordinates, exact) in families {
        for size in [1e-9, 1.0, 1e9] {
            let surface = sheet(degrees, coordinates, size);
            let told = |surface: &Surface| surface_area_of(surface).unwrap() / (size * size * exact) - 1.0;
            assert!(told(&surface).abs() < 1e-7, "{degrees:?} {size:e}: {:e}", told(&surface));
            // The same with knots, of a higher degree, and as a quotient.
            let more = surface.insert_knots(Direction::U, &[0.2, 0.2, 0.7]).unwrap();
            let more = more.insert_knots(Direction::V, &[0.35]).unwrap();
            let again = told(&more.elevate(Direction::U, 1).unwrap());
            assert!(again.abs() < 1e-7, "{degrees:?} {size:e}: {again:e}");
        }
    }
}

/// Nets folded flat by chance are told, too: as triangles have it.
#[test]
fn nets_that_are_folded_flat_are_told() {
    for seed in 0..24 {
        let mut next = random(seed);
        let degree = 1 + (next() * 4.0) as usize;
        let size = 10_f64.powi((next() * 19.0) as i32 - 9);
        let (around, across) = (4 + (next() * 4.0) as usize, 3 + (next() * 4.0) as usize);
        let mut surface = torus(degree, around, across, 3.0 * next(), 3.0 * next(), size);
        surface.control_vertices_mut().iter_mut().for_each(|p| {
            *p += Vector::new(next(), next(), 0.0) * size;
            p.z = 0.0;
        });
        let (told, expected) = (surface_area_of(&surface).unwrap(), area_of_triangles(&surface, 40));
        assert!((told - expected).abs() <= 5e-3 * expected, "{seed}: {told:e} {expected:e}");
    }
}

/// What has no area has the area 0, what is too large is said to be, and where there are more folds than bounded work follows it is said how
/// far the area can be told.
#[test]
fn what_cannot_be_told_is_said() {
    assert_eq!(surface_area_of(&torus(3, 8, 6, 3.0, 0.0, 1e9)).unwrap(), 0.0);
    let large = surface_area_of(&torus(3, 8, 6, 3.0, 1.0, 1e200)).unwrap_err().to_string();
    assert!(large.contains("beyond what numbers can hold"), "{large}");
    let mut next = random(7);
    let mut wild = torus(3, 64, 64, 3.0, 1.0, 1.0);
    wild.control_vertices_mut().iter_mut().for_each(|p| *p = Point::new(next(), next(), 0.0));
    let start = std::time::Instant::now();
    let refused = surface_area_of(&wild).unwrap_err().to_string();
    assert!(refused.contains("folds over") && refused.contains("of itself only"), "{refused}");
    assert!(start.elapsed().as_secs() < 30, "{:?}", start.elapsed());
}

/// `(u, v, u³)` over the unit square on knots that float, the outermost `far` away: by the blossom the vertices are `(t₁ + t₂ + t₃) / 3` and `t₁ t₂ t₃` of three knots
/// in a row, millions of times farther off than the surface is large. Its area is `∫₀¹ √(1 + 9 u⁴) du` all the same, as long as rounding of these vertices is less; where it is more, that is
/// said. (Both was told as an area of 0.)
#[test]
fn vertices_that_lie_far_off_do_not_take_the_area_away() {
    let surface = |far: f64, size: f64| {
        let knots = vec![-far, -0.9 * far, -0.8 * far, 0.0, 1.0, 0.8 * far, 0.9 * far, far];
        let row = |i: usize| (knots[i + 1], knots[i + 2], knots[i + 3]);
        let points = (0..4).flat_map(|i| [0.0, 1.0].map(|v| (i, v))).map(|(i, v)| {
            let (a, b, c) = row(i);
            Point::new(size * (a + b + c) / 3.0, size * v, size * (a * b * c))
        });
        let points = points.collect();
        Surface::new(Space::open(3, knots).unwrap(), Space::clamped(1, &[0.0, 1.0]).unwrap(), points).unwrap()
    };
    let exact = 1.547_865_654_683_61;
    for size in [1e-9, 1.0, 1e9] {
        for (far, bound) in [(3.0, 1e-13), (300.0, 1e-8)] {
            let told = surface_area_of(&surface(far, size)).unwrap() / (size * size);
            assert!((told / exact - 1.0).abs() < bound, "{far} {size:e}: {told}");
        }
        let refused = surface_area_of(&surface(1e7, size)).unwrap_err().to_string();
        assert!(refused.contains("times as far apart as it is large"), "{refused}");
    }
}
