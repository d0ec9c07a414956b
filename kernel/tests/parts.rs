//! The part of a surface that loops bound: what is in it and what is nearest to a point, against closed forms on a plane.
#![allow(clippy::unwrap_used, reason = "tests")]

use loftsman_kernel::brep::Brep;
use loftsman_kernel::spline::part::Part;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

/// A flat sheet of which `(u, v)` of `0..10` is the point `(u, v, 0)` times a size.
fn sheet(degree: usize, size: f64) -> Surface {
    let space = Space::clamped(degree, &[0.0, 3.0, 10.0]).unwrap();
    let at = |k: usize| space.greville(k);
    let count = space.len();
    let points =
        (0..count * count).map(|k| Point::new(at(k / count) * size, at(k % count) * size, 0.0)).collect();
    Surface::new(space.clone(), space, points).unwrap()
}

fn square(low: f64, high: f64) -> Vec<ParameterCurve> {
    let corner = |k: usize| [[low, low], [high, low], [high, high], [low, high]][k % 4];
    let at = |k: usize| Point::new(corner(k)[0], corner(k)[1], 0.0);
    (0..4).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap()).collect()
}

fn circle(middle: [f64; 2], radius: f64) -> Vec<ParameterCurve> {
    let middle = Point::new(middle[0], middle[1], 0.0);
    vec![ParameterCurve::whole(Curve::circle(middle, Vector::z(), radius).unwrap()).unwrap()]
}

fn backwards(chain: &[ParameterCurve]) -> Vec<ParameterCurve> {
    let turn = |one: &ParameterCurve| ParameterCurve::whole(one.curve().reverse().unwrap()).unwrap();
    chain.iter().rev().map(turn).collect()
}

/// Of a square with a round hole: points over what is left are nearest to their foot, others to the border; whichever way the loops run, whatever the degree and the size.
#[test]
fn the_nearest_place_is_within_the_loops() {
    for (degree, size) in [(1, 1.0), (2, 1e-6), (3, 1.0), (5, 1e6)] {
        for turned in [false, true] {
            let [mut outer, mut hole] = [square(1.0, 9.0), circle([4.0, 5.0], 2.0)];
            if turned {
                (outer, hole) = (backwards(&outer), backwards(&hole));
            }
            let regions = vec![Region { outer, holes: vec![hole] }];
            let part =
                Trimmed::new(sheet(degree, size), regions, Vec::new(), Vec::new()).unwrap().part().unwrap();
            let mut seen = [0; 3];
            for k in 0..100 {
                let (x, y) = (f64::from(k / 10) * 1.23 - 0.5, f64::from(k % 10) * 1.19 - 0.5);
                let (dx, dy) = (x - 4.0, y - 5.0);
                let away = dx.hypot(dy);
                let inside = (1.0..=9.0).contains(&x) && (1.0..=9.0).contains(&y);
                let (case, flat) = if away < 2.0 {
                    (0, 2.0 - away)
                } else if inside {
                    (1, 0.0)
                } else {
                    (2, (x - x.clamp(1.0, 9.0)).hypot(y - y.clamp(1.0, 9.0)))
                };
                seen[case] += 1;
                let found = part.closest(Point::new(x, y, 0.7) * size).unwrap();
                let expected = f64::hypot(flat, 0.7) * size;
                // The border is known to the chords of its curves, a 7,000th of the circle's radius.
                assert!(
                    (found.distance - expected).abs() <= 3e-4 * size,
                    "{degree} {size} {x} {y}: {found:?} {expected}"
                );
                if case != 0 {
                    assert!(
                        (found.distance - expected).abs() <= 1e-9 * size,
                        "{degree} {size} {x} {y}: {found:?} {expected}"
                    );
                }
                assert_eq!(part.has([x, y]), case == 1, "{x} {y}");
                let on = part.surface().point(found.at.0, found.at.1).unwrap();
                assert!((on - found.point).norm() <= 1e-12 * size);
            }
            assert!(seen.iter().all(|n| *n > 8), "{seen:?}");
        }
    }
}

/// Without regions all of the surface counts, and of a region without an outer loop all but its holes; two regions are two.
#[test]
fn regions_are_what_they_say() {
    let of = |regions| Trimmed::new(sheet(3, 1.0), regions, Vec::new(), Vec::new()).unwrap().part().unwrap();
    let query = Point::new(5.0, 5.0, 1.0);
    let all = of(Vec::new());
    assert!(all.has([5.0, 5.0]) && (all.closest(query).unwrap().distance - 1.0).abs() < 1e-12);
    let holed = of(vec![Region { outer: Vec::new(), holes: vec![square(4.0, 7.0)] }]);
    assert!(!holed.has([5.0, 5.0]) && holed.has([0.5, 9.5]));
    assert!((holed.closest(query).unwrap().distance - 2.0_f64.sqrt()).abs() < 1e-9);
    let corner = holed.closest(Point::new(12.0, 12.0, 0.0)).unwrap();
    assert!((corner.distance - 8.0_f64.sqrt()).abs() < 1e-9, "{corner:?}");
    let island = |low, high| Region { outer: square(low, high), holes: Vec::new() };
    let two = of(vec![island(1.0, 2.0), island(7.0, 9.0)]);
    assert!(two.has([1.5, 1.5]) && two.has([8.0, 8.0]) && !two.has([4.0, 4.0]));
    assert!((two.closest(query).unwrap().distance - 9.0_f64.sqrt()).abs() < 1e-9);
    assert!(all.closest(Point::new(f64::NAN, 0.0, 0.0)).is_err());
}

/// Of a block's faces each is nearest where the box says.
#[test]
fn faces_are_parts() {
    let block = Brep::block(Point::new(0.0, 0.0, 0.0), Point::new(2.0, 3.0, 4.0)).unwrap();
    let query = Point::new(5.0, 1.5, 2.0);
    let mut distances: Vec<f64> = (0..block.face_count())
        .map(|face| block.part(face).unwrap().closest(query).unwrap().distance)
        .collect();
    distances.sort_by(f64::total_cmp);
    // The face at x = 2, the four beside it, the one at x = 0.
    let beside = [9.0 + 2.25, 9.0 + 2.25, 9.0 + 4.0, 9.0 + 4.0_f64];
    let expected: Vec<f64> = [3.0].into_iter().chain(beside.map(f64::sqrt)).chain([5.0]).collect();
    for (found, expected) in distances.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-9, "{distances:?} {expected}");
    }
    assert_eq!(distances.len(), 6);
    assert!(block.part(6).is_err());
}

/// A wavy ring of so many spans, 48 chords each, in a sheet.
fn wavy(spans: usize) -> Part {
    let ring: Vec<Point> = (0..spans)
        .map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / spans as f64;
            let radius = 3.5 + 0.5 * (7.0 * angle).sin();
            Point::new(5.0 + radius * angle.cos(), 5.0 + radius * angle.sin(), 0.0)
        })
        .collect();
    let ring = Curve::new(Space::periodic_uniform(3, spans).unwrap(), ring).unwrap();
    let regions = vec![Region { outer: vec![ParameterCurve::whole(ring).unwrap()], holes: Vec::new() }];
    Trimmed::new(sheet(2, 1.0), regions, Vec::new(), Vec::new()).unwrap().part().unwrap()
}

/// A question to a loop of 100,000 chords takes about as long as one to a thousand: whether a place is inside, and how far off one outside is. The answers are those of the
/// wave that the loop follows.
#[test]
fn long_loops_answer_as_soon_as_short_ones() {
    let places: Vec<[f64; 2]> =
        (0..400).map(|k| [f64::from(k % 20) * 0.5 + 0.013, f64::from(k / 20) * 0.5 + 0.017]).collect();
    let ask = |part: &Part| {
        let inside = places.iter().filter(|at| part.has(**at)).count();
        let far: f64 =
            places.iter().map(|at| part.distance_at_most(Point::new(at[0], at[1], 0.0)).unwrap()).sum();
        (inside, far)
    };
    let mut times = Vec::new();
    let mut answers = Vec::new();
    for spans in [21, 2084] {
        let part = wavy(spans);
        // The first question looks at the border.
        answers.push(ask(&part));
        let best = (0..5).map(|_| {
            let start = std::time::Instant::now();
            std::hint::black_box(ask(&part));
            start.elapsed().as_secs_f64()
        });
        times.push(best.fold(f64::INFINITY, f64::min));
    }
    // What is asked for all chords takes a hundred times as long.
    assert!(times[1] < 12.0 * times[0], "{times:?}");
    // The ring at many places: inside it is 0, outside the distance to the nearest of these.
    let wave = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 20_000.0;
        let radius = 3.5 + 0.5 * (7.0 * angle).sin();
        [5.0 + radius * angle.cos(), 5.0 + radius * angle.sin()]
    };
    let ring: Vec<[f64; 2]> = (0..20_000).map(wave).collect();
    let inside = |[x, y]: [f64; 2]| {
        let (x, y) = (x - 5.0, y - 5.0);
        x.hypot(y) < 3.5 + 0.5 * (7.0 * y.atan2(x)).sin()
    };
    let far =
        |[x, y]: [f64; 2]| ring.iter().map(|p| (p[0] - x).hypot(p[1] - y)).fold(f64::INFINITY, f64::min);
    let expected: f64 = places.iter().map(|at| if inside(*at) { 0.0 } else { far(*at) }).sum();
    assert_eq!(answers[1].0, places.iter().filter(|at| inside(**at)).count(), "{answers:?}");
    assert!((answers[1].1 - expected).abs() < 1e-3 * expected, "{answers:?} {expected}");
}
