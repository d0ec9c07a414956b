//! Offsets of planar curves.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should panic")]

use std::f64::consts::{PI, TAU};

use loftsman_construction::{Corners, OffsetOptions, offset};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

fn polygon(points: &[[f64; 2]]) -> Curve {
    let n = points.len();
    let space = Space::periodic(1, (0..=n).map(|k| k as f64).collect()).unwrap();
    let mut points: Vec<Point> = points.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect();
    points.rotate_left(1);
    Curve::new(space, points).unwrap()
}

fn with(corners: Corners) -> OffsetOptions {
    OffsetOptions { corners, ..OffsetOptions::default() }
}

fn length(curves: &[Curve]) -> f64 {
    curves.iter().map(|c| c.length(1e-12).unwrap().value).sum()
}

fn places(curve: &Curve, count: usize) -> Vec<Point> {
    let (a, b) = curve.domain();
    (0..=count).map(|k| curve.point((a + (b - a) * k as f64 / count as f64).min(b)).unwrap()).collect()
}

/// The largest difference of the distance from `away` among many places.
fn off(source: &Curve, curves: &[Curve], away: f64) -> f64 {
    // A torn curve's places beside its tears are asked piece by piece.
    let torn = source.space().most_repeated() > source.degree();
    let parts = if torn { source.bezier_segments().unwrap() } else { vec![source.clone()] };
    let near = |p: Point| parts.iter().map(|c| c.closest(p).unwrap().distance).fold(f64::INFINITY, f64::min);
    curves.iter().flat_map(|c| places(c, 500)).map(|p| (near(p) - away.abs()).abs()).fold(0.0, f64::max)
}

#[test]
fn lines_and_circles_are_exact_at_any_size() {
    for scale in [1.0, 1e-9, 1e9] {
        let center = Point::new(3.0, -2.0, 1.0) * scale;
        let tilted = Vector::new(1.0, 2.0, -0.5);
        let ring = Curve::circle(center, tilted, 2.0 * scale).unwrap();
        for away in [0.5, -0.5, 7.0] {
            let found = offset(&ring, away * scale, &OffsetOptions::default()).unwrap();
            let [curve] = &found.curves[..] else { panic!("{found:#?}") };
            assert_eq!((curve.degree(), curve.points().len()), (2, ring.points().len()), "{away}");
            assert_eq!(curve.points().first(), curve.points().last());
            for p in places(curve, 100) {
                assert!(((p - center).norm() - (2.0 + away) * scale).abs() < 1e-14 * 20.0 * scale);
            }
        }
        let hidden = ring.to_periodic(0.0).unwrap().shape;
        let found = offset(&hidden, 0.5 * scale, &OffsetOptions::default()).unwrap();
        assert!(found.curves[0].is_periodic() && found.curves[0].points().len() == hidden.points().len());
        let line = Curve::line(Point::origin(), Point::new(scale, 0.0, 0.0)).unwrap();
        let up = OffsetOptions { normal: Some(Vector::new(0.1, 0.0, 1.0)), ..OffsetOptions::default() };
        let right = offset(&line, 0.25 * scale, &up).unwrap();
        assert_eq!(
            right.curves[0].points(),
            [Point::new(0.0, -0.25, 0.0) * scale, Point::new(1.0, -0.25, 0.0) * scale]
        );
    }
}

#[test]
fn squares_have_round_sharp_or_open_corners() {
    let square = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    let backwards = square.reverse().unwrap();
    for square in [square, backwards] {
        let round = offset(&square, 0.5, &with(Corners::Round)).unwrap();
        assert!(round.curves.len() == 1 && (length(&round.curves) - 8.0 - PI).abs() < 1e-12, "{round:#?}");
        assert!(off(&square, &round.curves, 0.5) < 1e-14);
        let sharp = offset(&square, 0.5, &with(Corners::Sharp)).unwrap();
        assert!((length(&sharp.curves) - 12.0).abs() < 1e-13 && sharp.curves[0].degree() == 1);
        // One vertex a corner, and one at the seam, which is where the curve has it.
        assert_eq!(sharp.curves[0].points().len(), 5, "{sharp:#?}");
        let open = offset(&square, 0.5, &with(Corners::Open)).unwrap();
        assert!(open.curves.len() == 4 && (length(&open.curves) - 8.0).abs() < 1e-13);
        for corners in [Corners::Round, Corners::Sharp, Corners::Open] {
            let inner = offset(&square, -0.5, &with(corners)).unwrap();
            assert!((length(&inner.curves) - 4.0).abs() < 1e-13 && inner.curves.len() == 1, "{inner:#?}");
            assert_eq!(inner.curves[0].points().len(), 4);
            assert!(off(&square, &inner.curves, 0.5) < 1e-14);
        }
        let message = offset(&square, -1.5, &with(Corners::Round)).unwrap_err().to_string();
        assert!(
            message.starts_with(
                "nothing of the curve is 1.5 away on that side: what is longer than the tolerance of "
            ),
            "{message}"
        );
    }
}

#[test]
fn tips_are_as_long_as_four_distances() {
    let needle = polygon(&[[0.0, 0.0], [10.0, 1.0], [0.0, 2.0]]);
    let sharp = offset(&needle, 0.5, &with(Corners::Sharp)).unwrap();
    assert_eq!((sharp.curves.len(), sharp.blunted), (1, 1));
    let arrow = polygon(&[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0]]);
    let sharp = offset(&arrow, 0.5, &with(Corners::Sharp)).unwrap();
    assert_eq!((sharp.curves.len(), sharp.blunted, sharp.curves[0].points().len()), (1, 0, 4));
}

#[test]
fn what_is_moved_far_inwards_falls_apart() {
    // Two rooms and a passage 0.6 wide.
    let rooms = polygon(&[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.2],
        [4.0, 1.2],
        [4.0, 0.0],
        [7.0, 0.0],
        [7.0, 3.0],
        [4.0, 3.0],
        [4.0, 1.8],
        [3.0, 1.8],
        [3.0, 3.0],
        [0.0, 3.0],
    ]);
    let near = offset(&rooms, -0.2, &OffsetOptions::default()).unwrap();
    assert_eq!(near.curves.len(), 1);
    assert!(off(&rooms, &near.curves, 0.2) < 1e-9);
    let far = offset(&rooms, -0.5, &OffsetOptions::default()).unwrap();
    assert_eq!(far.curves.len(), 2, "{far:#?}");
    assert!(far.cut > 0 && off(&rooms, &far.curves, 0.5) < 1e-9);
    for c in &far.curves {
        assert!(c.points().first() == c.points().last() || c.is_periodic());
    }
}

#[test]
fn an_ellipse_moved_beyond_its_radius_of_curvature_has_no_loops() {
    let ellipse = Curve::ellipse(Point::origin(), Vector::x() * 3.0, Vector::y()).unwrap();
    // Curvature at the tips: radius b²/a = 1/3.
    for (away, tolerance) in
        [(0.3, 1e-7), (-0.3, 1e-7), (-0.5, 1e-7), (-0.5, 1e-4), (-0.9, 1e-6), (4.0, 1e-6)]
    {
        let options = OffsetOptions { tolerance: Some(tolerance), ..OffsetOptions::default() };
        let found = offset(&ellipse, away, &options).unwrap();
        assert_eq!(found.curves.len(), 1, "{away}: {found:#?}");
        let measured = off(&ellipse, &found.curves, away);
        assert!(measured <= tolerance && found.deviation <= tolerance, "{away}: {measured:e}");
        // Up to one swallowtail at each tip.
        assert_eq!(found.cut > 0, away < -1.0 / 3.0, "{away}: {}", found.cut);
    }
    // A parallel curve is longer by 2πd (Steiner), as long as it has no cusps.
    let longer = offset(&ellipse, 0.7, &OffsetOptions::default()).unwrap();
    assert!((length(&longer.curves) - length(&[ellipse]) - TAU * 0.7).abs() < 1e-5);
}

/// Numbers that look like chance and are not.
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    /// A planar curve of any family.
    fn curve(&mut self) -> Curve {
        let degree = 1 + self.below(7);
        let n = degree + 1 + self.below(8);
        let space = match self.below(4) {
            0 => Space::clamped_uniform(degree, n).unwrap(),
            1 => Space::floating_uniform(degree, n).unwrap(),
            2 => Space::periodic_uniform(degree, n.max(3)).unwrap(),
            _ => {
                let breaks: Vec<f64> = (1..=(n - degree - 1) / 2).map(|k| k as f64).collect();
                // A knot that tears the curve, and one that gives it a corner.
                let times = if degree < 6 && self.next() < 0.3 { degree + 1 } else { degree };
                let inner = breaks.iter().flat_map(|b| vec![*b; times]);
                let ends = |x: f64| vec![x; degree + 1];
                let last = breaks.len() as f64 + 1.0;
                Space::open(degree, ends(0.0).into_iter().chain(inner).chain(ends(last)).collect()).unwrap()
            }
        };
        let n = space.len();
        let points =
            (0..n).map(|_| Point::new(4.0 * self.next() - 2.0, 4.0 * self.next() - 2.0, 0.0)).collect();
        if self.next() < 0.5 {
            return Curve::new(space, points).unwrap();
        }
        Curve::rational(space, points, (0..n).map(|_| 0.3 + 2.0 * self.next()).collect()).unwrap()
    }
}

#[test]
fn every_place_is_as_far_away_as_asked_for() {
    let mut random = Sequence(5);
    let (mut curves, mut cut, mut refused) = (0, 0, 0);
    for case in 0..25 {
        let source = random.curve();
        let away = [0.01, 0.1, 0.4][random.below(3)] * if random.next() < 0.5 { -1.0 } else { 1.0 };
        let found = match offset(
            &source,
            away,
            &OffsetOptions { tolerance: Some(1e-5), normal: Some(Vector::z()), ..OffsetOptions::default() },
        ) {
            Ok(found) => found,
            // A thin loop has no inside that far away.
            Err(error) if error.to_string().starts_with("nothing of the curve is") => {
                refused += 1;
                continue;
            }
            Err(error) => panic!("case {case}: {error} {source:?}"),
        };
        let measured = off(&source, &found.curves, away);
        assert!(measured <= 1.05e-5, "case {case}, {away}: {measured:e} and not {:e}", found.deviation);
        curves += found.curves.len();
        cut += found.cut;
    }
    println!("{curves} curves, {cut} parts cut away");
    assert!(refused <= 2, "{refused}");
    assert!(curves >= 40 && cut >= 40, "{curves} {cut}");
}

#[test]
fn what_has_no_offset_is_told_why() {
    let said = |curve: &Curve, away: f64, options: &OffsetOptions| {
        offset(curve, away, options).unwrap_err().to_string()
    };
    let o = OffsetOptions::default();
    let line = Curve::line(Point::origin(), Point::new(1.0, 0.0, 0.0)).unwrap();
    assert!(said(&line, 1.0, &o).contains("is straight and lies in many planes: say which by normal"));
    let along = OffsetOptions { normal: Some(Vector::x()), ..o };
    assert!(said(&line, 1.0, &along).contains("points along the line"));
    for bad in [Vector::zeros(), Vector::new(f64::NAN, 0.0, 0.0)] {
        assert!(said(&line, 1.0, &OffsetOptions { normal: Some(bad), ..o }).contains("has no direction"));
    }
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    assert!(said(&ring, 1.0, &along).contains("no normal of the curve's plane"));
    for bad in [0.0, f64::NAN, f64::INFINITY] {
        assert!(said(&ring, bad, &o).contains("is no distance to move by"));
        assert!(said(&ring, 1.0, &OffsetOptions { tolerance: Some(-bad), ..o }).contains("is no tolerance"));
    }
    assert!(said(&ring, 1e200, &o).contains("too large or too small"));
    assert!(said(&ring, -2.0, &o).ends_with("ends at a distance of about 1"));
    let helix = Curve::bezier(
        (0..5).map(|i| Point::new((f64::from(i)).cos(), (f64::from(i)).sin(), f64::from(i))).collect(),
    );
    assert!(said(&helix.unwrap(), 1.0, &o).contains("leaves its plane by"));
    let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap();
    assert!(said(&point, 1.0, &o).contains("is a point"));
    let huge = Curve::line(Point::origin(), Point::new(1e300, 0.0, 0.0)).unwrap();
    assert!(said(&huge, 1.0, &o).contains("too large"));
}

#[test]
fn ends_whose_vertices_fall_together_have_a_direction() {
    let p = |x: f64, y: f64| Point::new(x, y, 0.0);
    for points in [
        vec![p(0.0, 0.0), p(0.0, 0.0), p(1.0, 1.0), p(3.0, 0.0)],
        vec![p(0.0, 0.0), p(1.0, 1.0), p(3.0, 0.0), p(3.0, 0.0)],
        vec![p(0.0, 0.0), p(0.0, 0.0), p(0.0, 0.0), p(1.0, 1.0), p(3.0, 0.0)],
        vec![p(0.0, 0.0), p(1.0, 1.0), p(3.0, 0.0), p(3.0, 0.0), p(3.0, 0.0)],
    ] {
        let curve = Curve::bezier(points).unwrap();
        for away in [0.1, -0.1] {
            let found = offset(&curve, away, &OffsetOptions::default()).unwrap();
            assert!(found.curves.len() == 1 && off(&curve, &found.curves, away) < 4e-6, "{found:?}");
        }
    }
}

#[test]
fn the_highest_degree_is_no_other() {
    let at = |k: usize| Point::new(k as f64 * 0.2, if k.is_multiple_of(2) { 1.0 } else { -1.0 }, 0.0);
    let curve = Curve::bezier((0..=25).map(at).collect()).unwrap();
    let found = offset(&curve, 0.2, &OffsetOptions::default()).unwrap();
    assert!(off(&curve, &found.curves, 0.2) <= found.tolerance, "{found:?}");
}

#[test]
fn a_ring_found_by_chance() {
    let points = [
        [0.996875, 0.0],
        [0.5958984375000002, 1.0321263699009071],
        [-0.43515624999999986, 0.7537127342311444],
        [-1.00078125, 1.2256035544591871e-16],
        [-0.49335937500000043, -0.8545235038904263],
        [0.5714843749999993, -0.9898399732317457],
    ];
    let points = points.map(|[x, y]| Point::new(x, y, 0.5)).to_vec();
    let ring = Curve::new(Space::periodic_uniform(3, 6).unwrap(), points).unwrap();
    for away in [0.030390625, -0.030390625] {
        let options = OffsetOptions { tolerance: Some(1e-5), ..OffsetOptions::default() };
        let found = offset(&ring, away, &options).unwrap();
        println!("{found:?}");
        assert!(off(&ring, &found.curves, away) <= 1e-5, "{found:?}");
    }
}

/// Near to where nothing is left, what is left is short: it is found whole, or refused, and never handed out in pieces.
#[test]
fn polygons_near_their_inradius_stay_closed_or_are_refused() {
    let polygon = |corners: &[[f64; 2]]| {
        let points: Vec<Point> =
            corners.iter().chain(&corners[..1]).map(|c| Point::new(c[0], c[1], 0.0)).collect();
        let count = points.len();
        Curve::new(Space::clamped_uniform(1, count).unwrap(), points).unwrap()
    };
    let box_of = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    let (mut made, mut refused) = (0, 0);
    for below in [1e-1, 1e-2, 5e-4, 1e-4, 3e-5, 1e-5] {
        match offset(&box_of, below - 0.5, &OffsetOptions::default()) {
            Ok(found) => {
                let length: f64 = found.curves.iter().map(|c| c.length(1e-12).unwrap().value).sum();
                // A box of 1 + 2 below by 2 below.
                assert!((length - 2.0 - 8.0 * below).abs() < 1e-5, "{below:e}: {length}");
                for curve in &found.curves {
                    assert_eq!(curve.points().first(), curve.points().last(), "{below:e}: open");
                }
                made += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("too short") || text.contains("shorter than the tolerance"), "{text}");
                refused += 1;
            }
        }
    }
    assert!(made >= 4 && refused <= 2, "{made} {refused}");
    // The offset of a chamfer is short as well.
    for short in [1e-2, 1e-3, 1e-4] {
        let c = short + 2.0 - f64::sqrt(2.0);
        let chamfered = polygon(&[[c, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, c]]);
        let found = offset(&chamfered, -1.0, &OffsetOptions::default()).unwrap();
        let length = found.curves[0].length(1e-12).unwrap().value;
        let wanted = 2.0 * 8.0 + 2.0 * (8.0 - short) + short * f64::sqrt(2.0);
        assert!(
            found.curves.len() == 1 && (length - wanted).abs() < 1e-4,
            "{short}: {length} and not {wanted}"
        );
    }
    // Of a circle moved to its centre nothing is left, which is no object without a name.
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    for by in [-1.0, -0.999_999_9] {
        let error = offset(&circle, by, &OffsetOptions::default()).unwrap_err().to_string();
        assert!(error.contains("nothing of the curve"), "{error}");
    }
}

/// Of degree 25 an offset takes as long as it takes, and no longer: what is finer than can be told is refused at once, and the rest comes within
/// its tolerance or says what is too much.
#[test]
fn offsets_of_degree_25_end_soon() {
    let points = |n: usize| {
        (0..n).map(|k| {
            let k = k as f64;
            Point::new(k, 2.0 * (0.9 * k).sin() + 0.3 * (7.0 * k).sin(), 0.0)
        })
    };
    for n in [26, 46] {
        let open: Vec<f64> = (0..=n - 25).map(|k| k as f64).collect();
        let curve = Curve::new(Space::clamped(25, &open).unwrap(), points(n).collect()).unwrap();
        let at = |tolerance| OffsetOptions { tolerance: Some(tolerance), ..OffsetOptions::default() };
        let fine = offset(&curve, 0.3, &at(1e-7)).unwrap();
        assert!(fine.deviation <= 1e-7 && off(&curve, &fine.curves, 0.3) <= 1e-7, "{}", fine.deviation);
        for away in [0.3, 4.0] {
            let error = offset(&curve, away, &at(1e-12)).unwrap_err().to_string();
            assert!(
                error.contains("a tolerance of 1e-12 is finer than") && error.contains("give that or more"),
                "{error}"
            );
        }
    }
    // Two lines of a fold, side by side at twice the distance, on one of which the other is as near as the distance all along.
    let fold: Vec<Point> = (0..60)
        .map(|k| {
            let t = f64::from(k % 30);
            if k < 30 { Point::new(t, 0.0, 0.0) } else { Point::new(29.0 - t, 2.0, 0.0) }
        })
        .collect();
    let knots: Vec<f64> = (0..=35).map(f64::from).collect();
    let fold = Curve::new(Space::clamped(25, &knots).unwrap(), fold).unwrap();
    let finest = OffsetOptions { tolerance: Some(1e-6), ..OffsetOptions::default() };
    for side in [1.0, -1.0] {
        match offset(&fold, side, &finest) {
            Ok(found) => {
                assert!(
                    found.deviation <= 1e-6 && off(&fold, &found.curves, 1.0) <= 1e-6,
                    "{}",
                    found.deviation
                );
            }
            Err(error) => {
                let text = error.to_string();
                let why = ["places to follow", "too short", "misses its place", "nothing of the curve"];
                assert!(why.iter().any(|why| text.contains(why)), "{text}");
            }
        }
    }
    // A distance that nothing is found to is refused at once.
    for away in [1e-300, -1e-300, -1e-12] {
        let start = std::time::Instant::now();
        let error = offset(&fold, away, &OffsetOptions::default()).unwrap_err().to_string();
        assert!(error.contains("is less than the parts of an offset are found to"), "{error}");
        assert!(start.elapsed().as_secs() < 2, "{:?}", start.elapsed());
    }
}

/// A rough closed curve of degree 6 whose largest circle inside has the radius 0.7431180 (scipy), moved by a little more than that: nothing is left, and it is
/// told in seconds up to where something is.
#[test]
fn where_nothing_is_left_is_found_out_early() {
    let knots = [
        0.0,
        0.08764710588078273,
        0.39651097633768684,
        0.7398949576592402,
        0.8020908156552385,
        0.8020908156552385,
        0.8020908156552385,
        1.0,
    ];
    let points = [
        [1.0706733527040622, 0.0],
        [0.6504394789158428, 0.8156253086104632],
        [-0.26534916377697604, 1.162570647357914],
        [-0.7638688482865978, 0.3678598494325644],
        [-1.0363973836800073, -0.49910267497881944],
        [-0.2180568748273459, -0.9553695912226097],
        [0.6323166994651799, -0.7929000619711237],
    ];
    let weights = [
        1.4915462811771398,
        0.6669438414557046,
        1.4390342602784671,
        1.049942881537484,
        1.2806201589358062,
        1.0192020337370213,
        0.9938409344049826,
    ];
    let space = Space::periodic(6, knots.to_vec()).unwrap();
    let points = points.map(|[x, y]| Point::new(x, y, 0.0)).to_vec();
    let curve = Curve::rational(space, points, weights.to_vec()).unwrap();
    let options = OffsetOptions { corners: Corners::Sharp, ..OffsetOptions::default() };
    let begin = std::time::Instant::now();
    let refused = offset(&curve, -0.807273313272774, &options).unwrap_err().to_string();
    let took = begin.elapsed().as_secs_f64();
    assert!(took < 60.0, "{took} s: {refused}");
    assert!(
        refused.contains("nothing of the curve is 0.807") && refused.contains("about 0.743"),
        "{took} s: {refused}"
    );
}

/// What leaves its plane by less than the tolerance, as sections of solids do, is put there; the deviation told counts that.
#[test]
fn what_is_nearly_planar_is_put_into_its_plane() {
    let points = |height: f64| -> Vec<Point> {
        (0..8)
            .map(|i| (f64::from(i), f64::from(i) * std::f64::consts::FRAC_PI_4))
            .map(|(i, a)| Point::new(a.cos(), a.sin(), height * (1.7 * i).sin()))
            .collect()
    };
    let ring = |height: f64| Curve::new(Space::periodic_uniform(3, 8).unwrap(), points(height)).unwrap();
    let flat = offset(&ring(0.0), 0.2, &OffsetOptions::default()).unwrap();
    let found = offset(&ring(5e-8), 0.2, &OffsetOptions::default()).unwrap();
    assert!(found.deviation >= 2e-8 && found.deviation <= found.tolerance, "{found:?}");
    let length = |o: &loftsman_construction::Offset| o.curves[0].length(1e-12).unwrap().value;
    assert!((length(&flat) - length(&found)).abs() < 1e-6);
    let z: Vec<f64> = found.curves[0].points().iter().map(|p| p.z).collect();
    assert!(z.iter().all(|z| z.abs() < 2e-7), "{z:?}");
    let error = offset(&ring(1e-6), 0.2, &OffsetOptions::default()).unwrap_err().to_string();
    assert!(error.contains("leaves its plane"), "{error}");
}

/// What stops and turns back within a polynomial piece, straight or in a cusp, has both its sides, and a round end where it turns.
#[test]
fn what_turns_back_is_gone_round() {
    for scale in [1e-9, 1.0, 1e9] {
        // `x = 4t - 3t²`: to 4/3, and back to 1.
        let points = [0.0, 2.0, 1.0].map(|x| Point::new(x * scale, 0.0, 0.0)).to_vec();
        let up = OffsetOptions { normal: Some(Vector::z()), ..OffsetOptions::default() };
        for fold in
            [Curve::bezier(points.clone()).unwrap(), Curve::bezier(points).unwrap().elevate(4).unwrap()]
        {
            let found = offset(&fold, 0.5 * scale, &up).unwrap();
            let exact = 4.0 / 3.0 + 0.5 * PI + 1.0 / 3.0;
            assert!((length(&found.curves) / scale - exact).abs() < 1e-6, "{}", length(&found.curves));
            assert!(off(&fold, &found.curves, 0.5 * scale) < 2e-6 * scale);
            // To the right, seen from above: below the way out, above the way back; to the left the other way round.
            for side in [1.0, -1.0] {
                let found = offset(&fold, 0.5 * side * scale, &up).unwrap();
                let [from, to] = tips(&found.curves);
                assert!((from / scale - Point::new(0.0, -0.5 * side, 0.0)).norm() < 1e-6, "{side}: {from}");
                assert!((to / scale - Point::new(1.0, 0.5 * side, 0.0)).norm() < 1e-6, "{side}: {to}");
            }
        }
        // `(t², t³)`: a cusp.
        let points = [(1.0, -1.0), (-1.0 / 3.0, 1.0), (-1.0 / 3.0, -1.0), (1.0, 1.0)];
        let cusp = Curve::bezier(points.map(|(x, y)| Point::new(x, y, 0.0) * scale).to_vec()).unwrap();
        for away in [0.3, -0.3] {
            let found = offset(&cusp, away * scale, &up).unwrap();
            assert!(off(&cusp, &found.curves, away * scale) < 5e-6 * scale, "{away}");
            // Across its ends, whose directions are (-2, 3) and (2, 3). Within the cusp the arc round its tip is apart.
            assert_eq!(found.curves.len(), if away > 0.0 { 2 } else { 1 });
            let [from, to] = tips(&found.curves[..1]);
            let right = Vector::new(3.0, 2.0, 0.0).normalize() * away;
            assert!((from / scale - Point::new(1.0, -1.0, 0.0) - right).norm() < 1e-6, "{away}: {from}");
            let right = Vector::new(3.0, -2.0, 0.0).normalize() * away;
            assert!((to / scale - Point::new(1.0, 1.0, 0.0) - right).norm() < 1e-6, "{away}: {to}");
        }
    }
}

/// Where the one curve that there is starts and ends.
fn tips(curves: &[Curve]) -> [Point; 2] {
    assert_eq!(curves.len(), 1);
    let curve = &curves[0];
    let (a, b) = curve.domain();
    [curve.point(a).unwrap(), curve.point(b).unwrap()]
}

/// What the passes of a way along a line cover that go in one direction: how long that is, and in how many parts.
fn covered(turns: &[f64], way: f64) -> (f64, usize) {
    let mut passes: Vec<[f64; 2]> = (turns.windows(2).filter(|w| (w[1] - w[0]) * way > 0.0))
        .map(|w| [w[0].min(w[1]), w[0].max(w[1])])
        .collect();
    passes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut long, mut parts, mut end) = (0.0, 0, f64::NEG_INFINITY);
    for [low, high] in passes {
        parts += usize::from(low > end + 1e-9);
        long += (high - low.max(end)).max(0.0);
        end = end.max(high);
    }
    (long, parts)
}

/// A straight curve that turns back however often has on each side what its passes in that direction cover, and half a circle round each end where it turns:
/// places are sampled here, so densely that turns are known to 1e-7.
#[test]
fn straight_curves_that_turn_back_often_are_slots() {
    let mut random = Sequence(11);
    let (mut turned, mut uneven) = ([0; 8], 0);
    for degree in 1..=7_usize {
        for case in 0..24 {
            let count = degree + 1 + if case % 3 == 0 { 3 } else { 0 } + usize::from(degree == 1) * 4;
            let closed = case % 4 == 3;
            let mut values: Vec<f64> = (0..count).map(|_| 6.0 * random.next() - 3.0).collect();
            if closed {
                values[count - 1] = values[0];
            }
            let weights: Vec<f64> = (0..count).map(|_| 0.5 + random.next()).collect();
            let scale = [1.0, 1e-6, 1e6][case % 3];
            let along =
                [Vector::x(), Vector::new(1.0, -0.267, 0.0), Vector::new(0.2, 0.5, 0.7)][case / 3 % 3];
            let along = along.normalize();
            let normal = along.cross(&Vector::new(0.3, -0.8, 0.1)).normalize();
            let points: Vec<Point> = values.iter().map(|x| Point::origin() + along * (x * scale)).collect();
            let space = Space::clamped_uniform(degree, count).unwrap();
            let weights = (case % 2 == 1).then_some(weights);
            let curve = Curve::build(space, points, weights).unwrap();
            let seen = places(&curve, 20_000);
            let mut xs: Vec<f64> = seen.iter().map(|p| p.coords.dot(&along) / scale).collect();
            if degree == 1 {
                xs = values;
            }
            xs.dedup();
            let mut turns = vec![xs[0]];
            turns.extend(xs.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).map(|w| w[1]));
            turns.push(xs[xs.len() - 1]);
            if turns.len() < 3 {
                continue;
            }
            turned[degree] += usize::from(turns.len() > 3);
            let (low, high) = turns.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
            let inner = &turns[1..turns.len() - 1];
            let (up, down) = (covered(&turns, 1.0), covered(&turns, -1.0));
            let ends = [low, high].iter().filter(|x| closed || inner.contains(x)).count();
            for away in [0.4, -0.4] {
                let options = OffsetOptions { normal: Some(normal), ..OffsetOptions::default() };
                let found = offset(&curve, away * scale, &options).unwrap();
                let told = format!("degree {degree}, case {case}, {away}: {turns:?}");
                let exact = up.0 + down.0 + ends as f64 * 0.4 * PI;
                let long = length(&found.curves) / scale;
                assert!((long - exact).abs() < 1e-5, "{told}: {long} for {exact}");
                assert!(off(&curve, &found.curves, away * scale) < 1e-9 * scale, "{told}");
                // Each end that is gone round joins two parts, of which a ring is one.
                let parts = (up.1 + down.1 - ends).max(1);
                assert_eq!(found.curves.len(), parts, "{told}");
                for c in &found.curves {
                    let (a, b) = c.domain();
                    let ring = up.1 + down.1 == ends;
                    assert_eq!(c.point(a).unwrap() == c.point(b).unwrap(), ring, "{told}");
                }
                let open = offset(&curve, away * scale, &OffsetOptions { corners: Corners::Open, ..options })
                    .unwrap();
                assert!((length(&open.curves) / scale - up.0 - down.0).abs() < 1e-5, "{told}");
                assert_eq!(open.curves.len(), up.1 + down.1, "{told}");
                // What goes up is on the right, what goes down on the left, seen from above: each runs its own way there, and covers what the passes do.
                let right = along.cross(&normal) * away.signum();
                for (way, (covers, parts)) in [(1.0, up), (-1.0, down)] {
                    let own = open.curves.iter().filter(|c| {
                        let (a, _) = c.domain();
                        c.point(a).unwrap().coords.dot(&right) * way > 0.0
                    });
                    let (mut long, mut count) = (0.0, 0);
                    for c in own {
                        let [from, to] = tips(std::slice::from_ref(c)).map(|p| p.coords / scale);
                        assert!((from.dot(&right) * way - 0.4).abs() < 1e-9, "{told}");
                        let runs = (to - from).dot(&along) * way;
                        assert!(runs > 0.0, "{told}: {runs}");
                        (long, count) = (long + runs, count + 1);
                    }
                    assert!((long - covers).abs() < 1e-5 && count == parts, "{told}, {way}: {long} {count}");
                }
                uneven += usize::from((up.0 - down.0).abs() > 0.1);
                let sharp =
                    offset(&curve, away * scale, &OffsetOptions { corners: Corners::Sharp, ..options })
                        .unwrap();
                assert_eq!((&sharp.curves, sharp.blunted), (&found.curves, ends), "{told}");
            }
        }
    }
    assert!(turned[2..].iter().sum::<usize>() > 60 && turned[4] > 5, "{turned:?}");
    // Where one side has more than the other they cannot be exchanged.
    assert!(uneven > 100, "{uneven}");
}

/// Where a straight curve turns is found in its shares from 0 to 1, however few digits of its parameters are left: between two knots so near that what
/// is between them has some thousands of numbers.
#[test]
fn straight_curves_turn_back_whatever_their_parameters_are() {
    let mut random = Sequence(23);
    for degree in 2..=5_usize {
        for case in 0..6 {
            let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let points: Vec<Point> =
                (0..degree + 3).map(|k| Point::new(sign(k) * (1.0 + random.next()), 0.0, 0.0)).collect();
            let weights: Vec<f64> = (0..degree + 3).map(|_| 0.5 + random.next()).collect();
            let weights = (case % 2 == 1).then_some(weights);
            let at = 0.1 + 0.8 * random.next();
            let up = OffsetOptions { normal: Some(Vector::z()), ..OffsetOptions::default() };
            let long = |low: f64, wide: f64| {
                let knots = [0.0, at, at + 1e-7, 1.0].map(|x| low + wide * x);
                let space = Space::clamped(degree, &knots).unwrap();
                let curve = Curve::build(space, points.clone(), weights.clone()).unwrap();
                let found = offset(&curve, 0.1, &up);
                length(&found.unwrap_or_else(|e| panic!("{degree}, {case}, {low}: {e}")).curves)
            };
            let (exact, far) = (long(0.0, 1.0), long(1000.0, 0.01));
            assert!((far - exact).abs() < 1e-6, "{degree}, {case}: {far} for {exact}");
        }
    }
}

/// With sharp corners more is taken away than circles say: of a U 2 wide nothing is left beyond 1, and just there is.
#[test]
fn where_sharp_offsets_end_is_told() {
    let u = [[0.0, 6.0], [2.0, 6.0], [2.0, 2.0], [6.0, 2.0], [6.0, 6.0], [8.0, 6.0], [8.0, 0.0], [0.0, 0.0]];
    for scale in [1.0, 1e-3, 1e4] {
        let source = polygon(&u.map(|p| p.map(|x| x * scale)));
        assert!(offset(&source, -0.9999 * scale, &with(Corners::Sharp)).is_ok());
        for away in [-1.0001, -1.1, -1.17, -5.0] {
            let said = offset(&source, away * scale, &with(Corners::Sharp)).unwrap_err().to_string();
            assert!(said.ends_with(&format!("ends at a distance of about {scale}")), "{away}: {said}");
        }
        // Circles round the inner corners: `√2 (2 - r) = r`.
        let said = offset(&source, -1.3 * scale, &OffsetOptions::default()).unwrap_err().to_string();
        let told: f64 = said.rsplit(' ').next().unwrap().parse().unwrap();
        assert!((told / scale - 2.0 * 2_f64.sqrt() / (1.0 + 2_f64.sqrt())).abs() < 1e-3, "{said}");
    }
}

/// Two sides exactly twice the distance apart: what lies between has no width and is left out, the rest by closed forms. Lengths would tell of lines laid double.
#[test]
fn a_strip_of_no_width_is_left_out() {
    // Rooms of 10 × 10 at both ends of a corridor 2 wide, in its middle, along a wall, and between corners that are not opposite; as lengths and areas of
    // both rooms' offsets by 1, sharp and round: a wall of 8 each, and at the mouth a wedge between two arcs.
    let dumbbell = [
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 4.0],
        [15.0, 4.0],
        [15.0, 0.0],
        [25.0, 0.0],
        [25.0, 10.0],
        [15.0, 10.0],
        [15.0, 6.0],
        [10.0, 6.0],
        [10.0, 10.0],
        [0.0, 10.0],
    ];
    let flush = [
        [0.0, 0.0],
        [25.0, 0.0],
        [25.0, 10.0],
        [15.0, 10.0],
        [15.0, 2.0],
        [10.0, 2.0],
        [10.0, 10.0],
        [0.0, 10.0],
    ];
    let dead_end = [
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 4.0],
        [15.0, 4.0],
        [15.0, 6.0],
        [10.0, 6.0],
        [10.0, 10.0],
        [0.0, 10.0],
    ];
    let quarter = PI / 4.0;
    let (wedge, arcs) = (2.0 * (1.0 - quarter), 4.0 * quarter - 2.0);
    let (half, arc) = (1.0 - quarter, 2.0 * quarter);
    // (outline, rooms, area and length of a room sharp, round)
    type Case<'a> = (&'a [[f64; 2]], usize, [f64; 2], [f64; 2]);
    let cases: [Case<'_>; 3] = [
        (&dumbbell, 2, [64.0, 32.0], [64.0 + wedge, 32.0 + arcs]),
        // The wall goes on to where the corridor begins, below its corner.
        (&flush, 2, [64.0, 32.0], [64.0 + half, 32.0 + arc]),
        (&dead_end, 1, [64.0, 32.0], [64.0 + wedge, 32.0 + arcs]),
    ];
    for (outline, rooms, sharp, round) in cases {
        for scale in [1.0, 1e-6, 1e6] {
            for angle in [0.0, 0.4, 2.0] {
                let (sine, cosine) = f64::sin_cos(angle);
                let turned: Vec<[f64; 2]> = outline
                    .iter()
                    .map(|[x, y]| {
                        [(x * cosine - y * sine + 3.0) * scale, (x * sine + y * cosine - 7.0) * scale]
                    })
                    .collect();
                let source = polygon(&turned);
                for (corners, wanted) in [(Corners::Sharp, sharp), (Corners::Round, round)] {
                    let found = offset(&source, -scale, &with(corners)).unwrap();
                    assert!(found.strips, "{corners:?} {angle}");
                    assert_eq!(found.curves.len(), rooms, "{corners:?} {angle} {scale}: {:?}", found.curves);
                    for curve in &found.curves {
                        let (a, b) = curve.domain();
                        assert!(
                            (curve.point(a).unwrap() - curve.point(b).unwrap()).norm() < 1e-12 * 30.0 * scale
                        );
                        let long = curve.length(1e-9 * scale).unwrap().value / scale;
                        let fine = places(curve, 4000);
                        let twice: f64 = fine
                            .windows(2)
                            .map(|w| (w[0].coords - fine[0].coords).cross(&(w[1].coords - fine[0].coords)).z)
                            .sum();
                        let area = 0.5 * twice.abs() / (scale * scale);
                        assert!(
                            (long - wanted[1]).abs() < 1e-3,
                            "{corners:?} {angle} {scale}: {long} {wanted:?}"
                        );
                        assert!(
                            (area - wanted[0]).abs() < 1e-3,
                            "{corners:?} {angle} {scale}: {area} {wanted:?}"
                        );
                    }
                }
            }
        }
    }
    // A narrower corridor and a wider one are as before: nothing of it, and a strip that has a width.
    for (width, rooms) in [(1.99, 2), (2.01, 1), (2.0 + 1e-6, 1)] {
        let low = 5.0 - 0.5 * width;
        let outline = dumbbell.map(|[x, y]| {
            [
                x,
                if y == 4.0 {
                    low
                } else if y == 6.0 {
                    low + width
                } else {
                    y
                },
            ]
        });
        for corners in [Corners::Sharp, Corners::Round] {
            let found = offset(&polygon(&outline), -1.0, &with(corners)).unwrap();
            assert_eq!((found.curves.len(), found.strips), (rooms, false), "{width} {corners:?}");
        }
    }
    // A bent corridor: arcs about one centre.
    let arc = |radius: f64, from: f64, to: f64| {
        let start = Point::new(radius * from.cos(), radius * from.sin(), 0.0);
        Curve::arc(start, Point::origin(), Vector::z(), to - from).unwrap()
    };
    let line = |x: [f64; 2], y: [f64; 2]| {
        Curve::line(Point::new(x[0], x[1], 0.0), Point::new(y[0], y[1], 0.0)).unwrap()
    };
    let parts = [
        arc(5.0, 0.0, PI),
        line([-5.0, 0.0], [-9.0, 0.0]),
        line([-9.0, 0.0], [-9.0, -8.0]),
        line([-9.0, -8.0], [-1.0, -8.0]),
        line([-1.0, -8.0], [-1.0, 0.0]),
        line([-1.0, 0.0], [-3.0, 0.0]),
        arc(3.0, PI, 0.0),
        line([3.0, 0.0], [5.0, 0.0]),
    ];
    let mut outline = parts[0].clone();
    for part in &parts[1..] {
        outline = outline.join(part, 1e-9).unwrap().shape;
    }
    for (corners, area, long) in [(Corners::Sharp, 36.0, 24.0), (Corners::Round, 36.0 + wedge, 24.0 + arcs)] {
        let found = offset(&outline, -1.0, &with(corners)).unwrap();
        assert!(found.strips && found.curves.len() == 1, "{corners:?}: {:?}", found.curves);
        let curve = &found.curves[0];
        let fine = places(curve, 4000);
        let twice: f64 = fine.windows(2).map(|w| w[0].coords.cross(&w[1].coords).z).sum();
        let told = (0.5 * twice.abs(), curve.length(1e-9).unwrap().value);
        // The corridor begins curved: arcs about its corners meet there with its middle's bend between them.
        assert!((told.0 - area).abs() < 0.02 && (told.1 - long).abs() < 0.02, "{corners:?}: {told:?}");
    }
    // Nothing else is left of what is twice as wide all along.
    let plank = polygon(&[[0.0, 0.0], [7.0, 0.0], [7.0, 2.0], [0.0, 2.0]]);
    for corners in [Corners::Sharp, Corners::Round, Corners::Open] {
        let said = offset(&plank, -1.0, &with(corners)).unwrap_err().to_string();
        assert!(said.contains("a strip of no width") && said.contains("give a smaller distance"), "{said}");
    }
}

/// Curves that are nearly straight, going one way or back and forth, of any degree, at distances from a hundredth of their length to ten times that: what comes is within
/// the tolerance, and what is refused is refused soon, in words.
#[test]
fn nearly_straight_curves_are_moved_or_refused_soon() {
    let mut seed = 3_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut moved, mut narrow) = ([0, 0], 0);
    for case in 0..63 {
        let folds = case % 3 == 0;
        let degree = 1 + case % 7;
        let count = degree + 2 + (next() * 24.0) as usize;
        let amplitude = 10_f64.powf(-6.0 + 4.0 * next());
        let away = 10_f64.powf(-2.0 + 3.0 * next()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let tolerance = 10_f64.powf(-6.0 + 3.0 * next());
        let points = (0..count)
            .map(|k| {
                let x = if folds { next() } else { k as f64 / (count - 1) as f64 };
                Point::new(x, amplitude * (2.0 * next() - 1.0), 0.0)
            })
            .collect();
        let curve = Curve::new(Space::clamped_uniform(degree, count).unwrap(), points).unwrap();
        let options = OffsetOptions { tolerance: Some(tolerance), ..OffsetOptions::default() };
        let start = std::time::Instant::now();
        let found = offset(&curve, away, &options);
        // A hundred times what it takes by itself: tests run beside one another.
        assert!(start.elapsed().as_secs() < 60, "{case}: {:?}", start.elapsed());
        match found {
            Ok(found) => {
                moved[usize::from(folds)] += 1;
                narrow += usize::from(folds && amplitude <= 0.4 * tolerance);
                let far = off(&curve, &found.curves, away.abs());
                assert!(found.deviation <= tolerance && far <= 1.01 * tolerance, "{case}: {far} {tolerance}");
            }
            Err(error) => {
                let text = error.to_string();
                let why =
                    ["to follow", "too short", "misses its place", "nothing of the curve", "can be followed"];
                assert!(folds && amplitude > 0.25 * tolerance, "{case}: {amplitude} {tolerance}: {text}");
                assert!(why.iter().any(|why| text.contains(why)), "{case}: {text}");
            }
        }
    }
    assert!(moved[0] == 42 && narrow > 2, "{moved:?} {narrow}");
}
