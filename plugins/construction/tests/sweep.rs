//! Sweeps along paths.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::{PI, TAU};

use loftsman_construction::{Turning, sweep};
use loftsman_kernel::spline::{Curve, Direction, Space};
use loftsman_kernel::{Point, Vector};

fn spiral(knots: usize, pitch: f64) -> Curve {
    let at = |i: usize| {
        let a = 0.7 * i as f64;
        Point::new(2.0 * a.cos(), 2.0 * a.sin(), pitch * a)
    };
    Curve::new(Space::clamped_uniform(5, knots).unwrap(), (0..knots).map(at).collect()).unwrap()
}

#[test]
fn a_circle_along_a_circle_is_a_torus() {
    for scale in [1.0, 1e-9, 1e9] {
        for sweep_angle in [TAU, 2.0] {
            let path =
                Curve::arc(Point::new(3.0, 0.0, 0.0) * scale, Point::origin(), Vector::z(), sweep_angle)
                    .unwrap();
            let ring = Curve::circle(Point::new(3.0, 0.0, 0.0) * scale, Vector::y(), scale).unwrap();
            let swept = sweep(&ring, &path, Turning::Least, Some(1e-6 * scale)).unwrap();
            assert!(swept.deviation <= 1e-6 * scale && swept.twist.abs() < 1e-12 && swept.folds.is_none());
            let s = &swept.surface;
            for u in 0..=40 {
                for v in 0..=40 {
                    let at = |k: i32, space: &Space| {
                        let (a, b) = space.domain();
                        (a + (b - a) * f64::from(k) / 40.0).min(b)
                    };
                    let p = s.point(at(u, s.u()), at(v, s.v())).unwrap() / scale;
                    let off = ((p.x.hypot(p.y) - 3.0).hypot(p.z) - 1.0).abs();
                    assert!(off <= 1e-6, "{off:e}");
                }
            }
            if sweep_angle == TAU {
                let n = ring.points().len();
                assert_eq!(s.points()[..n], s.points()[s.points().len() - n..]);
            }
        }
    }
    let path = Curve::circle(Point::origin(), Vector::z(), 3.0).unwrap().to_periodic(0.0).unwrap().shape;
    let ring = Curve::circle(path.point(0.0).unwrap(), Vector::y(), 1.0).unwrap();
    let swept = sweep(&ring, &path, Turning::Least, None).unwrap();
    assert!(swept.surface.u().is_periodic() && swept.deviation <= swept.tolerance);
}

#[test]
fn parallel_sweeps_are_exact() {
    let path = spiral(9, 0.4);
    let profile = Curve::circle(Point::new(2.0, 0.0, 0.0), -Vector::y(), 0.3).unwrap();
    let swept = sweep(&profile, &path, Turning::Parallel, None).unwrap();
    let s = &swept.surface;
    assert_eq!((s.u(), s.v()), (path.space(), profile.space()));
    let start = path.point(path.domain().0).unwrap();
    for k in 0..=20 {
        let (u, v) = (path.domain().1 * f64::from(k) / 20.0, profile.domain().1 * f64::from(20 - k) / 20.0);
        let expected = path.point(u).unwrap() + (profile.point(v).unwrap() - start);
        assert!((s.point(u, v).unwrap() - expected).norm() < 1e-14);
    }
}

#[test]
fn frames_turn_as_little_as_can_be() {
    // Along a helix frames turn back against the normal by the torsion: -∫ τ ds (Bishop 1975). A helix within 1e-10 of a spline.
    let n = 400;
    let (turns, h) = (1.5, 0.5);
    let at = |t: f64| Point::new(t.cos(), t.sin(), h * t);
    let step = turns * TAU / f64::from(n);
    let (mut points, mut knots) = (vec![at(0.0)], vec![0.0; 4]);
    for k in 0..n {
        let (s, e) = (step * f64::from(k), step * f64::from(k + 1));
        let d = |t: f64| Vector::new(-t.sin(), t.cos(), h) * (step / 3.0);
        points.extend([at(s) + d(s), at(e) - d(e)]);
        knots.extend([e; 2]);
    }
    points.push(at(turns * TAU));
    knots.extend([turns * TAU; 2]);
    let path = Curve::new(Space::open(3, knots).unwrap(), points).unwrap();
    // The profile points to the axis at the start.
    let profile = Curve::line(at(0.0), Point::new(0.9, 0.0, 0.0)).unwrap();
    let swept = sweep(&profile, &path, Turning::Least, Some(1e-8)).unwrap();
    let end = swept.surface.isocurve(Direction::U, turns * TAU).unwrap();
    let way = (end.points()[1] - end.points()[0]) / 0.1;
    let t = turns * TAU;
    let normal = -Vector::new(t.cos(), t.sin(), 0.0);
    let tangent = Vector::new(-t.sin(), t.cos(), h).normalize();
    let angle = normal.cross(&way).dot(&tangent).atan2(normal.dot(&way));
    let expected = -h / (1.0 + h * h) * t * (1.0 + h * h).sqrt();
    let off = (angle - expected) / TAU;
    assert!((off - off.round()).abs() < 1e-6, "{angle} is not {expected}");
}

#[test]
fn closed_paths_meet_their_start() {
    let at = |i: usize| {
        let a = TAU * i as f64 / 11.0;
        Point::new(3.0 * a.cos(), 3.0 * a.sin(), (2.0 * a).sin() + 0.7 * (3.0 * a).cos())
    };
    let path = Curve::new(Space::periodic_uniform(4, 11).unwrap(), (0..11).map(at).collect()).unwrap();
    let start = path.point(path.domain().0).unwrap();
    let square = Curve::new(
        Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(),
        vec![start + Vector::z() * 0.2, start, start + Vector::x() * 0.3],
    )
    .unwrap();
    let swept = sweep(&square, &path, Turning::Least, Some(1e-5)).unwrap();
    assert!(swept.twist.abs() > 0.01 && swept.surface.u().is_periodic());
    // As far from the path everywhere as at the start, and across it as much.
    let s = &swept.surface;
    let (a, b) = path.domain();
    for k in 0..100 {
        let u = a + (b - a) * f64::from(k) / 100.0;
        let arms = [0.0, 2.0].map(|v| s.point(u, v).unwrap() - path.point(u).unwrap());
        assert!((arms[0].norm() - 0.2).abs() < 2e-5 && (arms[1].norm() - 0.3).abs() < 2e-5);
        let along = path.derivative(u, 1).unwrap().normalize();
        let before = path.derivative(a, 1).unwrap().normalize().z * 0.2;
        assert!((arms[0].dot(&along) - before).abs() < 3e-5);
    }
}

#[test]
fn upright_stays_upright() {
    let path = spiral(9, 0.4);
    let start = path.points()[0];
    let across = Vector::z().cross(&path.derivative(0.0, 1).unwrap());
    let profile = Curve::line(start, start + across).unwrap();
    let swept = sweep(&profile, &path, Turning::Upright(Vector::z()), Some(1e-7)).unwrap();
    let s = &swept.surface;
    for k in 0..=50 {
        let u = path.domain().1 * f64::from(k) / 50.0;
        let arm = s.point(u, 1.0).unwrap() - s.point(u, 0.0).unwrap();
        assert!(arm.z.abs() < 3e-7 && arm.dot(&path.derivative(u, 1).unwrap()).abs() < 2e-5, "{arm}");
    }
}

#[test]
fn what_cannot_be_swept_is_told_why() {
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let said =
        |path: &Curve, turning, tolerance| sweep(&ring, path, turning, tolerance).unwrap_err().to_string();
    let corner = Curve::new(
        Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(),
        vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0)],
    )
    .unwrap();
    assert!(
        said(&corner, Turning::Least, None)
            .contains("the profile reaches too far to their inner side, so that the surface would fold")
    );
    let fan =
        Curve::bezier(vec![Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(2.0, 1.0, 0.0)]).unwrap();
    let fan = fan
        .join(&Curve::line(Point::new(2.0, 1.0, 0.0), Point::new(9.0, 1.0, 0.0)).unwrap(), 1e-9)
        .unwrap()
        .shape;
    // In the plane of its ring it is a flat sheet, mitred where a bent piece meets a straight one.
    let fan = sweep(&ring, &fan, Turning::Least, None).unwrap();
    assert!(fan.flat && fan.corners == 1 && fan.leaned > 0.01, "{}", fan.leaned);
    assert!(sweep(&ring, &corner, Turning::Parallel, None).is_ok());
    let line = Curve::line(Point::origin(), Point::new(0.0, 0.0, 2.0)).unwrap();
    assert!(
        said(&line, Turning::Upright(Vector::z()), None).contains("runs along the upright direction at 0")
    );
    assert!(said(&line, Turning::Upright(Vector::zeros()), None).contains("is none"));
    assert!(said(&line, Turning::Least, Some(0.0)).contains("0 is no tolerance"));
    assert!(said(&line, Turning::Least, Some(f64::NAN)).contains("NaN is no tolerance"));
    let point = Curve::bezier(vec![Point::new(1.0, 2.0, 3.0); 4]).unwrap();
    assert!(said(&point, Turning::Least, None).contains("the path stops at"));
    let torn = Curve::new(
        Space::open(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]).unwrap(),
        [0.0, 1.0, 2.0, 3.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec(),
    )
    .unwrap();
    assert!(said(&torn, Turning::Least, None).contains("the path is torn at 1"));
    let bend = Curve::arc(Point::new(0.5, 0.0, 0.0), Point::origin(), Vector::y(), PI).unwrap();
    let folded = sweep(&ring, &bend, Turning::Least, None).unwrap();
    assert!(folded.folds.is_some() && folded.deviation <= folded.tolerance);
}

/// Pipes round corners, by closed forms: what a mitred pipe of a profile with area `A` and centroid on the path holds is `A` times the path's length,
/// and its sides are those of prisms cut off askew.
#[test]
fn a_square_pipe_round_corners_is_mitred() {
    let line = |points: &[[f64; 3]]| {
        let space = Space::clamped_uniform(1, points.len()).unwrap();
        Curve::new(space, points.iter().map(|p| Point::from(*p)).collect()).unwrap()
    };
    let square = |size: f64| {
        line(
            &[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0], [-0.5, -0.5, 0.0]]
                .map(|p| p.map(|c| c * size)),
        )
    };
    let triangles = |s: &loftsman_kernel::spline::Surface| -> (f64, f64) {
        let breaks = |space: &Space| {
            let b = space.breakpoints();
            let mut all: Vec<f64> = b
                .windows(2)
                .flat_map(|w| (0..6).map(move |k| w[0] + (w[1] - w[0]) * f64::from(k) / 6.0))
                .collect();
            all.push(*b.last().unwrap());
            all
        };
        let (us, vs) = (breaks(s.u()), breaks(s.v()));
        let (mut area, mut volume) = (0.0, 0.0);
        for u in us.windows(2) {
            for v in vs.windows(2) {
                let p = |u: f64, v: f64| s.point(u, v).unwrap().coords;
                let [a, b, c, d] = [p(u[0], v[0]), p(u[1], v[0]), p(u[1], v[1]), p(u[0], v[1])];
                for (x, y, z) in [(a, b, c), (a, c, d)] {
                    area += 0.5 * (y - x).cross(&(z - x)).norm();
                    volume += x.dot(&y.cross(&z)) / 6.0;
                }
            }
        }
        (area, volume)
    };
    for size in [1e-9, 1.0, 1e9] {
        let scaled =
            |points: &[[f64; 3]]| line(&points.iter().map(|p| p.map(|c| c * size)).collect::<Vec<_>>());
        // An L: up and to the side. The walls are 4 (3 + 4) whatever the corner cuts, inner and outer side together.
        let ell = scaled(&[[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 3.0]]);
        for turning in [Turning::Least, Turning::Upright(Vector::y())] {
            let swept = sweep(&square(size), &ell, turning, None).unwrap();
            assert!(swept.folds.is_none() && swept.deviation <= 1e-12 * size, "{:e}", swept.deviation);
            let (area, volume) = triangles(&swept.surface);
            assert!((area / size / size - 28.0).abs() < 1e-9, "{size}: {area}");
            assert!((swept.corners, swept.leaned) == (1, 0.0) && volume > 0.0, "{volume}");
            // The ends are open: the one is in z = 0, seen from the origin at no angle; the other's pyramid is 1 · 4 / 3.
            let volume = volume.abs() / size / size / size;
            assert!(
                (volume + 4.0 / 3.0 - 7.0).abs() < 1e-9 || (volume - 4.0 / 3.0 - 7.0).abs() < 1e-9,
                "{volume}"
            );
            // The corner is a square cut askew: all its points are in the plane between both sides.
            let middle = swept.surface.u().domain().1 * 0.5;
            for k in 0..=20 {
                let v = swept.surface.v().domain().1 * f64::from(k) / 20.0;
                let p = swept.surface.point(middle, v).unwrap() / size;
                assert!((p.x + (p.z - 3.0)).abs() < 1e-12 && p.x.abs() <= 0.5 + 1e-12, "{p}");
            }
        }
        // A frame: closed, with a corner at the seam. Its volume is the length of the path, 4 · 4; its walls 4 times that.
        let frame =
            scaled(&[[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, 0.0], [0.0, 0.0, 0.0]]);
        let swept = sweep(&square(size), &frame, Turning::Least, None).unwrap();
        let (area, volume) = triangles(&swept.surface);
        assert!((area / size / size - 64.0).abs() < 1e-8 && swept.twist.abs() < 1e-12, "{area}");
        assert!((volume.abs() / size / size / size - 16.0).abs() < 1e-8, "{volume}");
        let (s, v) = (&swept.surface, 0.37 * swept.surface.v().domain().1);
        let (a, b) = s.u().domain();
        assert!((s.point(a, v).unwrap() - s.point(b, v).unwrap()).norm() == 0.0);
        // Out of the plane, closed: turned about the path, and still closed, each wall in one piece.
        let bent =
            scaled(&[[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 4.0, 1.0], [0.0, 0.0, 0.0]]);
        let swept = sweep(&square(size), &bent, Turning::Least, Some(1e-5 * size)).unwrap();
        assert!(swept.twist.abs() > 0.1 && swept.deviation <= 1e-5 * size, "{swept:?}");
        // With an arc between straight pieces, a corner only where there is one.
        let refused = |path: &Curve, turning: Turning| {
            sweep(&square(size), path, turning, None).unwrap_err().to_string()
        };
        let short = scaled(&[[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.7, 0.0, 3.0], [0.7, 0.0, 0.0]]);
        assert!(
            refused(&short, Turning::Least).contains("would fold"),
            "{}",
            refused(&short, Turning::Least)
        );
        let back = scaled(&[[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 0.0, 1.0]]);
        assert!(refused(&back, Turning::Least).contains("turns straight back"));
        let leaves = scaled(&[[0.0, 0.0, 0.0], [1.0, 0.0, 3.0], [4.0, 2.0, 3.0]]);
        let words = refused(&leaves, Turning::Upright(Vector::new(0.3, 1.0, 0.2)));
        assert!(words.contains("leaves the plane across the upright direction"), "{words}");
    }
}

/// `∬ S·n / 3` by triangles, of a surface that is closed, or whose rims are closed by a fan from their middle.
fn enclosed(s: &loftsman_kernel::spline::Surface, capped: bool) -> f64 {
    let grid = |space: &Space| -> Vec<f64> {
        let breaks = space.breakpoints();
        let inside =
            |w: &[f64]| -> Vec<f64> { (0..24).map(|k| w[0] + (w[1] - w[0]) * f64::from(k) / 24.0).collect() };
        breaks.windows(2).flat_map(inside).chain(breaks.last().copied()).collect()
    };
    let (us, vs) = (grid(s.u()), grid(s.v()));
    let p = |u: f64, v: f64| s.point(u, v).unwrap().coords;
    let volume = |x: Vector, y: Vector, z: Vector| x.dot(&y.cross(&z)) / 6.0;
    let mut sum = 0.0;
    for v in vs.windows(2) {
        for u in us.windows(2) {
            let [a, b, c, d] = [p(u[0], v[0]), p(u[1], v[0]), p(u[1], v[1]), p(u[0], v[1])];
            sum += volume(a, b, c) + volume(a, c, d);
        }
        if capped {
            // Where the wall looks outwards it runs clockwise about the path.
            for (u, sense) in [(us[0], 1.0), (us[us.len() - 1], -1.0)] {
                let middle = vs.iter().map(|v| p(u, *v)).sum::<Vector>() / vs.len() as f64;
                sum += sense * volume(middle, p(u, v[0]), p(u, v[1]));
            }
        }
    }
    sum
}

#[test]
fn what_is_closed_looks_outwards_whatever_way_it_runs() {
    let start = Point::new(3.0, 0.0, 0.0);
    let ways = [
        (Curve::arc(start, Point::origin(), Vector::z(), 2.0).unwrap(), true, 6.0 * PI),
        (Curve::circle(Point::origin(), Vector::z(), 3.0).unwrap(), false, 6.0 * PI * PI),
        (Curve::circle(Point::origin(), Vector::z(), 3.0).unwrap().reverse().unwrap(), false, 6.0 * PI * PI),
        (Curve::line(start, start + Vector::y() * 5.0).unwrap(), true, 5.0 * PI),
    ];
    for (path, capped, expected) in ways {
        for normal in [Vector::y(), -Vector::y()] {
            let ring = Curve::circle(start, normal, 1.0).unwrap();
            for ring in [ring.clone(), ring.to_periodic(0.0).unwrap().shape] {
                for turning in [Turning::Least, Turning::Upright(Vector::z()), Turning::Parallel] {
                    let swept = sweep(&ring, &path, turning, Some(1e-6)).unwrap();
                    // A circle's axis says about which direction it runs counterclockwise.
                    let along = path.derivative(0.0, 1).unwrap();
                    assert_eq!(swept.reversed, normal.dot(&along) > 0.0);
                    if turning != Turning::Parallel {
                        let volume = enclosed(&swept.surface, capped);
                        assert!((volume / expected - 1.0).abs() < 5e-3, "{volume} is not {expected}");
                    } else if path.degree() == 1 {
                        assert!((enclosed(&swept.surface, true) / expected - 1.0).abs() < 5e-3);
                    }
                }
            }
        }
    }
    // An open one keeps its way; one that lies along the path has no outer side.
    let path = Curve::line(start, start + Vector::y() * 5.0).unwrap();
    let open = Curve::line(start, start + Vector::x()).unwrap();
    for profile in [open.clone(), open.reverse().unwrap()] {
        let swept = sweep(&profile, &path, Turning::Least, None).unwrap();
        assert!(!swept.reversed && !swept.flat);
        assert_eq!(swept.surface.isocurve(Direction::U, 0.0).unwrap().points(), profile.points());
    }
    let ring = Curve::circle(start, Vector::z(), 1.0).unwrap();
    let swept = sweep(&ring, &path, Turning::Least, None).unwrap();
    assert!(swept.flat && !swept.reversed);
}

/// A pipe along a line and then an arc, with a corner between, whose section is symmetric about the plane of both: what it holds is, by Pappus, the
/// section times the path's length, whatever sections lean, since these lean by what is odd across the path.
#[test]
fn corners_beside_arcs_are_mitred() {
    for scale in [1e-9, 1.0, 1e9] {
        let at = |x: f64, y: f64, z: f64| Point::new(x, y, z) * scale;
        let line = Curve::line(at(0.0, 0.0, 0.0), at(0.0, 0.0, 4.0)).unwrap();
        // An arc of radius 10 from there, that begins 30° beside the line's way.
        let (radius, bend) = (10.0, PI / 6.0);
        let way = Vector::new(bend.sin(), 0.0, bend.cos());
        let middle = at(0.0, 0.0, 4.0) + Vector::new(way.z, 0.0, -way.x) * (radius * scale);
        let arc = Curve::arc(at(0.0, 0.0, 4.0), middle, Vector::y(), 1.0).unwrap();
        assert!((arc.derivative(0.0, 1).unwrap().normalize() - way).norm() < 1e-12);
        let path = line.join(&arc, 1e-12 * scale).unwrap().shape;
        let square = {
            let points = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]];
            let points = points.iter().map(|p| at(p[0], p[1], 0.0)).collect();
            Curve::new(Space::clamped_uniform(1, 5).unwrap(), points).unwrap()
        };
        let swept = sweep(&square, &path, Turning::Least, Some(1e-7 * scale)).unwrap();
        assert!(swept.corners == 1 && swept.folds.is_none() && swept.reversed, "{swept:?}");
        let s = &swept.surface;
        let seam = line.domain().1;
        // The seam lies in the plane between both sides.
        let across = Vector::z() + way;
        for k in 0..=40 {
            let v = s.v().domain().1 * f64::from(k) / 40.0;
            let p = s.point(seam, v).unwrap() - at(0.0, 0.0, 4.0);
            assert!(p.dot(&across).abs() < 1e-12 * scale, "{p}");
            // Towards the line walls are those of the straight prism, to the last but rounding.
            let p = s.point(0.7 * seam, v).unwrap() / scale;
            assert!((p.x.abs().max(p.y.abs()) - 0.5).abs() < 1e-12, "{p}");
        }
        // A place `x` inwards of the arc is moved `x tan 15°` along the tangent: `√((r - x)² + (x tan 15°)²) - (r - x)` away from its circle.
        let by = 0.5 * (0.5 * bend).tan();
        let inner = (radius - 0.5).hypot(by) - (radius - 0.5);
        assert!((swept.leaned / scale - inner).abs() < 1e-5, "{} {inner}", swept.leaned / scale);
        let volume = enclosed(s, true) / scale.powi(3);
        // What leans moves along the path, by what is as much on the one side as on the other.
        assert!((volume - (4.0 + radius)).abs() < 2e-2, "{volume}");
        // The other way it is the same shape.
        let back =
            sweep(&square_at_end(&path, scale), &path.reverse().unwrap(), Turning::Least, Some(1e-7 * scale))
                .unwrap();
        assert!((back.leaned - swept.leaned).abs() < 1e-5 * scale && back.corners == 1);
    }
    // Where the bent piece is too short for the profile it folds, and is told where.
    let hook = Curve::arc(Point::new(0.0, 0.0, 4.0), Point::new(0.0, 0.0, 6.0), Vector::y(), 0.3).unwrap();
    let path =
        Curve::line(Point::origin(), Point::new(0.0, 0.0, 4.0)).unwrap().join(&hook, 1e-9).unwrap().shape;
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let words = sweep(&ring, &path, Turning::Least, None).unwrap_err().to_string();
    assert!(words.contains("beside the corners around") && words.contains("would fold"), "{words}");
}

/// A square of side 1 about the end of a path in the plane `y = 0`, across it.
fn square_at_end(path: &Curve, scale: f64) -> Curve {
    let (_, b) = path.domain();
    let (end, along) = (path.point(b).unwrap(), path.derivative(b, 1).unwrap().normalize());
    let side = along.cross(&Vector::y());
    let points = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5]];
    let points = points.iter().map(|p| end + (side * p[0] + Vector::y() * p[1]) * scale).collect();
    Curve::new(Space::clamped_uniform(1, 5).unwrap(), points).unwrap()
}

/// How far a mitre reaches, by closed forms: that of a round pipe `1 / cos(turn / 2)` radii, and of a profile beside the path as much of how far it is.
#[test]
fn mitres_that_reach_far_are_told() {
    for scale in [1e-3, 1.0, 1e4] {
        for (degrees, spikes) in [(60.0_f64, 0), (119.0, 0), (121.0, 1), (150.0, 1), (172.0, 1)] {
            let turn = degrees.to_radians();
            let at = |x: f64, y: f64| Point::new(x, y, 0.0) * scale;
            let points = vec![at(-20.0, 0.0), at(0.0, 0.0), at(20.0 * turn.cos(), 20.0 * turn.sin())];
            let path = Curve::new(Space::clamped(1, &[0.0, 1.0, 2.0]).unwrap(), points).unwrap();
            let ring = Curve::circle(at(-20.0, 0.0), Vector::x(), 0.25 * scale).unwrap();
            let back = ring.reverse().unwrap();
            for profile in [ring, back] {
                let swept = sweep(&profile, &path, Turning::Least, None).unwrap();
                let mitre = swept.mitre.unwrap();
                assert!((mitre.turn - turn).abs() < 1e-9 && mitre.at == 1.0, "{mitre:?}");
                let times = mitre.reach / mitre.profile;
                // All places are seen, the ones in the path's plane among them.
                assert!((times * (0.5 * turn).cos() - 1.0).abs() < 1e-9, "{degrees}: {times}");
                assert!((mitre.profile - 0.25 * scale).abs() < 1e-12 * scale, "{mitre:?}");
                assert_eq!((swept.spikes.len(), swept.corners), (spikes, 1), "{degrees}");
                assert!((swept.off.unwrap()) < 1e-9, "{:?}", swept.off);
            }
        }
    }
    let straight = Curve::line(Point::origin(), Point::new(3.0, 0.0, 0.0)).unwrap();
    let ring = Curve::circle(Point::origin(), Vector::x(), 1.0).unwrap();
    let swept = sweep(&ring, &straight, Turning::Least, None).unwrap();
    assert_eq!((swept.mitre, swept.spikes.len()), (None, 0));
}
