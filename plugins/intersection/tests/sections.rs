//! Sections of surfaces, and curves with planes.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]
use loftsman_intersection::{Options, Plane, Section, SectionCurve, curve_plane, section, trimmed_section};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region, Trimmed};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use std::f64::consts::{PI, TAU};

fn ball(scale: f64, away: f64) -> Surface {
    let at = |z: f64| Point::new(away, 0.0, z * scale);
    let half = Curve::arc(at(-2.0), at(0.0), Vector::y(), PI).unwrap();
    Surface::revolution(&half, at(0.0), Vector::z(), TAU).unwrap()
}

fn torus() -> Surface {
    let ring = Curve::circle(Point::new(3.0, 0.0, 0.0), Vector::y(), 1.0).unwrap();
    Surface::revolution(&ring, Point::origin(), Vector::z(), TAU).unwrap()
}

#[test]
fn balls_are_cut_in_circles_of_the_right_length() {
    for (scale, away) in [(1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1e4)] {
        for height in [0.3, 0.01, 0.0, -1.0, 1.99] {
            for normal in [Vector::z(), Vector::x(), Vector::new(1.0, 2.0, -0.5)] {
                let normal = normal.normalize();
                let plane =
                    Plane::new(Point::new(away, 0.0, 0.0) + normal * (height * scale), normal).unwrap();
                let cut = section(&ball(scale, away), &plane, &Options::within(1e-7 * scale)).unwrap();
                assert!(cut.undecided.is_empty() && cut.touching.is_empty());
                assert!(
                    cut.curves.len() == 1 || normal == Vector::x() && height == 0.0,
                    "{normal} {height}: {cut:#?}"
                );
                let length: f64 = cut.curves.iter().map(|c| c.curve.length(1e-9).unwrap().value).sum();
                let radius = (4.0_f64 - height * height).sqrt();
                assert!((length / scale - TAU * radius).abs() < 1e-5, "{scale} {normal} {height}: {length}");
                for c in &cut.curves {
                    assert_eq!(c.curve.is_periodic(), c.closed);
                    assert!(c.distance <= 1e-7 * scale, "{}", c.distance);
                    let (a, b) = c.curve.domain();
                    for k in 0..=1000 {
                        let p = c.curve.point((a + (b - a) * f64::from(k) / 1000.0).min(b)).unwrap();
                        let off = (p - Point::new(away, 0.0, 0.0)).norm() - 2.0 * scale;
                        assert!(off.abs() <= 1.1e-7 * scale + 1e-11 * away, "{off:e}");
                        let most = 1.002 * c.distance + 1e-15 * scale + 1e-15 * away;
                        assert!(off.abs() <= most, "{off:e} where at most {:e} is told", c.distance);
                        assert!(plane.distance(&p).abs() <= 1e-7 * scale);
                    }
                }
            }
        }
    }
}

#[test]
fn a_torus_has_two_loops_one_loop_or_touches() {
    let cut = |z: f64, normal: Vector| {
        section(&torus(), &Plane::new(Point::new(0.0, 0.0, z), normal).unwrap(), &Options::default()).unwrap()
    };
    assert_eq!(cut(0.5, Vector::z()).curves.len(), 2);
    assert_eq!(cut(0.5, Vector::z()).curves.iter().filter(|c| c.closed).count(), 2);
    // A loop begins as smoothly as it goes on.
    for ring in cut(0.5, Vector::z()).curves {
        let space = ring.curve.space();
        assert_eq!(space.multiplicity(space.domain().0), 2, "{ring:?}");
    }
    assert_eq!(cut(0.0, Vector::x()).curves.len(), 2);
    assert_eq!(cut(1.5, Vector::z()).curves.len(), 0);
    let villarceau = cut(0.0, Vector::new(1.0, 0.0, -8.0_f64.sqrt()));
    assert!(villarceau.undecided.is_empty());
    let length: f64 = villarceau.curves.iter().map(|c| c.curve.length(1e-9).unwrap().value).sum();
    // Where the two circles cross, corners are cut by about the root of the distance that the plane is moved.
    assert!((length - 2.0 * TAU * 3.0).abs() < 3e-3, "{length}");
    let ball_top = section(
        &ball(1.0, 0.0),
        &Plane::new(Point::new(2.0, 0.0, 0.0), Vector::x()).unwrap(),
        &Options::default(),
    )
    .unwrap();
    assert_eq!((ball_top.curves.len(), ball_top.touching.len()), (0, 1), "{ball_top:#?}");
}

#[test]
fn curves_meet_planes() {
    let ring = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let cut = |x: f64| {
        curve_plane(&ring, &Plane::new(Point::new(x, 0.0, 0.0), Vector::x()).unwrap(), &Options::default())
            .unwrap()
    };
    assert_eq!(cut(0.5).meetings.len(), 2);
    assert_eq!(cut(0.0).meetings.len(), 2);
    assert_eq!(cut(1.0).meetings.len(), 1, "{:?}", cut(1.0));
    assert_eq!(cut(-1.0).meetings.len(), 1, "{:?}", cut(-1.0));
    assert_eq!(cut(1.1).meetings.len(), 0);
    let flat =
        curve_plane(&ring, &Plane::new(Point::origin(), Vector::z()).unwrap(), &Options::default()).unwrap();
    assert_eq!((flat.meetings.len(), flat.overlaps.len()), (0, 1));
}

/// A flat patch that is level along one of its sides, but for rounding, which may go one way all over it.
#[test]
fn level_patches_are_cut_along_their_sides() {
    let line = |length: f64| Space::clamped(1, &[0.0, length]).unwrap();
    for k in 0..300 {
        let angle = 0.1 + 0.37 * f64::from(k);
        let x = Vector::new(angle.cos(), angle.sin(), 0.3 * (2.0 * angle).sin()).normalize();
        let y = x.cross(&Vector::new(0.2, -angle.sin(), 1.0)).normalize();
        let origin = Point::new(100.0 * angle.sin(), 3.0, -40.0 * angle.cos());
        let at = |a: f64, b: f64| origin + x * a + y * b;
        let net = vec![at(0.0, 0.0), at(0.0, 7.0), at(31.0, 0.0), at(31.0, 7.0)];
        let patch = Surface::new(line(31.0), line(7.0), net).unwrap();
        for (through, normal, length) in [(at(13.0, 0.0), x, 7.0), (at(0.0, 3.0), y, 31.0)] {
            let plane = Plane::new(through, normal).unwrap();
            let cut = section(&patch, &plane, &Options::default()).unwrap();
            assert_eq!(cut.curves.len(), 1);
            let found = cut.curves[0].curve.length(1e-9).unwrap().value;
            assert!((found - length).abs() < 1e-9 && cut.curves[0].distance < 1e-5, "{k}: {found} {length}");
        }
    }
}

/// A plane that touches a ball or a ring leaves no sliver, and the place is told to rounding, wherever it is: in the middle of patches, on their edges, at
/// a pole. A little further in a circle is cut, a little further out nothing.
#[test]
fn tangent_planes_touch_at_their_place_and_cut_nothing() {
    let half = |r: f64| Curve::arc(Point::new(0.0, 0.0, -r), Point::origin(), Vector::y(), PI).unwrap();
    let turned = |profile: &Curve| Surface::revolution(profile, Point::origin(), Vector::z(), TAU).unwrap();
    let mut normals: Vec<Vector> = [
        [4.0, 4.0, 7.0],
        [8.0, 1.0, 4.0],
        [-2.0, 1.0, 2.0],
        [1.0, -8.0, -4.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [0.0, -1.0, 1.0],
        [-0.43242071356141254, 0.13080281362349352, -0.8921339307700479],
        [4.111856, 2.670254, 0.980581],
        [1e-3, 0.0, 1.0],
    ]
    .map(Vector::from)
    .to_vec();
    for k in 0..60 {
        let (a, z) = (2.399963 * f64::from(k), (f64::from(k) - 29.5) / 30.0);
        let r = (1.0 - z * z).sqrt();
        normals.push(Vector::new(r * a.cos(), r * a.sin(), z));
    }
    for size in [5.0, 9.0, 1e-6, 1e6] {
        let ball = turned(&half(size));
        for normal in &normals {
            let normal = normal.normalize();
            for options in [Options::default(), Options::within(1e-4 * size)] {
                for way in [1.0, -1.0] {
                    let foot = Point::from(normal * size);
                    let plane = Plane::new(foot, normal * way).unwrap();
                    let cut = section(&ball, &plane, &options).unwrap();
                    assert!(cut.curves.is_empty() && cut.undecided.is_empty(), "{size} {normal}: {cut:?}");
                    assert_eq!(cut.touching.len(), 1, "{size} {normal}: {:?}", cut.touching);
                    let off = (cut.touching[0] - foot).norm();
                    assert!(off <= 1e-9 * size, "{size} {normal}: {off:e}");
                }
            }
            let at = |x: f64| Plane::new(Point::from(normal * (size * x)), normal).unwrap();
            let cut = section(&ball, &at(1.0 - 1e-6), &Options::default()).unwrap();
            assert!(
                cut.touching.is_empty() && cut.curves.len() == 1 && cut.curves[0].closed,
                "{normal}: {cut:?}"
            );
            assert!(
                section(&ball, &at(1.0 + 1e-6), &Options::default()).unwrap()
                    == Section { tolerance: cut.tolerance, ..Section::default() }
            );
        }
    }
    // A ring lies on its top circle all along, and is touched outside at one place.
    let tube = Curve::circle(Point::new(10.0, 0.0, 0.0), Vector::y(), 3.0).unwrap();
    let ring = turned(&tube);
    for way in [1.0, -1.0] {
        for z in [3.0, -3.0] {
            let plane = Plane::new(Point::new(0.0, 0.0, z), Vector::z() * way).unwrap();
            let cut = section(&ring, &plane, &Options::default()).unwrap();
            assert!(cut.curves.is_empty() && cut.touching.len() == 1, "{cut:?}");
            let p = cut.touching[0];
            assert!((p.x.hypot(p.y) - 10.0).abs() < 1e-8 && (p.z - z).abs() < 1e-12, "{p}");
        }
        for degrees in [0.0, 45.0, 90.0, 133.0, 180.0, 301.0] {
            let (s, c) = f64::to_radians(degrees).sin_cos();
            let normal = Vector::new(c, s, 0.0);
            let plane = Plane::new(Point::from(normal * 13.0), normal * way).unwrap();
            let cut = section(&ring, &plane, &Options::default()).unwrap();
            assert!(cut.curves.is_empty() && cut.touching.len() == 1, "{degrees}: {cut:?}");
            assert!((cut.touching[0].coords - normal * 13.0).norm() < 1e-8, "{degrees}: {:?}", cut.touching);
        }
    }
}

/// A plane that touches a rim from within cuts an ellipse that closes, where it is moved to the side on which it passes the rim it is open there.
#[test]
fn what_touches_a_rim_closes_there() {
    let line = Curve::line(Point::new(10.0, 0.0, 0.0), Point::new(6.0, 0.0, 20.0)).unwrap();
    let cone = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
    for turn in [0.0, 0.3, 2.0, 4.0] {
        let (sine, cosine) = f64::sin_cos(turn);
        for sign in [1.0, -1.0] {
            // Through (0, 0, 10) and the point of the rim at (sine, cosine).
            let normal = Vector::new(10.0 * sine, 10.0 * cosine, 10.0) * sign;
            let plane = Plane::new(Point::new(0.0, 0.0, 10.0), normal).unwrap();
            let cut = section(&cone, &plane, &Options::default()).unwrap();
            assert!(cut.curves.len() == 1 && cut.curves[0].closed, "{turn} {sign}: {}", cut.curves.len());
            // x² + y² = (8 + y/5)² where z = 10 - y: half diameters √(200/3) and √(200/2.88), seen along z.
            let area = PI * (200.0_f64 / 3.0).sqrt() * (200.0_f64 / 2.88).sqrt() * 2.0_f64.sqrt();
            assert!((cut.area.unwrap().abs() - area).abs() < 1e-4 * area, "{turn}: {:?} {area}", cut.area);
        }
    }
}

/// The curve's control vertices in homogeneous coordinates are those of the isocurve; of a loop the last one is the first.
fn is_isocurve(cut: &SectionCurve, surface: &Surface) -> bool {
    let Some((direction, at)) = cut.isocurve else { return false };
    let line = surface.isocurve(direction, at).unwrap();
    let (a, b) = line.domain();
    let size = surface.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    cut.curve.degree() == line.degree()
        && cut.curve.domain() == (a, b)
        && cut.curve.space().breakpoints() == line.space().breakpoints()
        && cut.curve.weights().is_some() == line.weights().is_some()
        && (0..=200).all(|k| {
            let t = (a + (b - a) * f64::from(k) / 200.0).min(b);
            (cut.curve.point(t).unwrap() - line.point(t).unwrap()).norm() <= 1e-15 * size
        })
}

/// What the plane meets along a parameter line is that line, with its weights and its knots: circles of cylinders, balls, tori and cones of any size, turned and
/// away from the origin, at their edges, too; ribs of a loft of planar curves of any degree, closed or not.
#[test]
fn parameter_lines_in_the_plane_are_exact() {
    for (scale, away) in [(1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1e3)] {
        let axis = Vector::new(1.0, 2.0, -0.5).normalize();
        let middle = Point::new(away, -2.0 * away, 0.0);
        let across = axis.cross(&Vector::x()).normalize();
        let ring = Curve::circle(middle, axis, scale).unwrap();
        let pipe = Surface::extrusion(&ring, axis * (5.0 * scale)).unwrap();
        let side =
            Curve::line(middle + across * scale, middle + across * (3.0 * scale) + axis * (2.0 * scale))
                .unwrap();
        let cone = Surface::revolution(&side, middle, axis, TAU).unwrap();
        let part = Surface::revolution(&side, middle, axis, 2.0).unwrap();
        let tube = Curve::circle(middle + across * (3.0 * scale), axis.cross(&across), scale).unwrap();
        let donut = Surface::revolution(&tube, middle, axis, TAU).unwrap();
        let radius = |height: f64| {
            [(1.0, 0.0), (1.0 + height, 0.0), (1.0 + height, 0.0), {
                let half = (1.0 - height * height).max(0.0).sqrt();
                (3.0 + half, 3.0 - half)
            }]
        };
        for height in [0.0, 0.25, 0.777] {
            let plane = Plane::new(middle + axis * (height * scale), axis).unwrap();
            for (k, surface) in [&pipe, &cone, &part, &donut].into_iter().enumerate() {
                let cut = section(surface, &plane, &Options::default()).unwrap();
                let (outer, inner) = radius(height)[k];
                let count = if inner > 0.0 { 2 } else { 1 };
                assert_eq!(cut.curves.len(), count, "{scale} {height} {k}");
                for one in &cut.curves {
                    assert!(is_isocurve(one, surface), "{scale} {away} {height} {k}: {one:?}");
                    assert_eq!((one.closed, one.curve.is_periodic()), (k != 2, k != 2));
                    assert!(one.curve.points().len() <= 9 && one.distance <= 1e-14 * (scale + 3.0 * away));
                }
                let angle = if k == 2 { 2.0 } else { TAU };
                let length: f64 = cut.curves.iter().map(|c| c.curve.length(1e-12).unwrap().value).sum();
                let exactly = angle * (outer + inner) * scale;
                assert!((length - exactly).abs() <= 1e-9 * exactly, "{k}: {length} {exactly}");
                let area = PI * (outer * outer - inner * inner) * scale * scale;
                let near = |found: f64| (found - area).abs() <= (1e-12 + 1e-15 * away) * area;
                assert!(
                    k == 2 && cut.area.is_none() || cut.area.is_some_and(near),
                    "{k}: {:?} {area}",
                    cut.area
                );
            }
        }
        // Through the axis the lines of a cone, which are straight, and the circles of the torus.
        let plane = Plane::new(middle, axis.cross(&across)).unwrap();
        for surface in [&cone, &donut] {
            let cut = section(surface, &plane, &Options::default()).unwrap();
            assert!(cut.curves.len() == 2, "{scale} {away}: {cut:?}");
            assert!(cut.curves.iter().all(|one| is_isocurve(one, surface)), "{scale} {away}: {cut:?}");
        }
    }
    let mut seed = 5_u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    for (degree, along) in [(1, 1), (2, 3), (3, 2), (5, 3), (7, 4)] {
        let heights = [0.0, 1.0, 1.5, 4.0, 5.0, 7.0];
        let space = Space::clamped_uniform(along, heights.len()).unwrap();
        for own in [
            Space::clamped_uniform(degree, degree + 4).unwrap(),
            Space::periodic_uniform(degree, degree + 4).unwrap(),
        ] {
            let count = own.len();
            let net: Vec<Point> = (0..count * heights.len())
                .map(|k| {
                    let angle = TAU * (k / heights.len()) as f64 / count as f64;
                    let r = 2.0 + 0.3 * next();
                    Point::new(r * angle.cos(), r * angle.sin(), heights[k % heights.len()])
                })
                .collect();
            let surface = Surface::new(own.clone(), space.clone(), net).unwrap();
            for z in [0.0, 0.31, 3.3, 6.0, 7.0] {
                let cut = section(
                    &surface,
                    &Plane::new(Point::new(0.0, 0.0, z), Vector::z()).unwrap(),
                    &Options::default(),
                )
                .unwrap();
                assert!(
                    cut.curves.len() == 1 && is_isocurve(&cut.curves[0], &surface),
                    "{degree} {along} {z}: {cut:?}"
                );
                assert_eq!(cut.curves[0].closed, own.is_periodic());
            }
            // Askew it is no parameter line.
            let askew = Plane::new(Point::new(0.0, 0.0, 3.3), Vector::new(1e-3, 0.0, 1.0)).unwrap();
            let cut = section(&surface, &askew, &Options::default()).unwrap();
            assert!(cut.curves.len() == 1 && cut.curves[0].isocurve.is_none());
        }
    }
}

/// Of a trimmed surface the part within its loops is left of the line, cut out of it exactly.
#[test]
fn parts_of_parameter_lines_within_loops_are_exact() {
    let ring = Curve::circle(Point::origin(), Vector::z(), 2.0).unwrap();
    let pipe = Surface::extrusion(&ring, Vector::z() * 5.0).unwrap();
    let ((a, b), (c, d)) = (pipe.u().domain(), pipe.v().domain());
    let square = |low: [f64; 2], high: [f64; 2]| -> Vec<ParameterCurve> {
        let corner =
            |k: usize| [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]][k % 4];
        let at = |k: usize| Point::new(corner(k)[0], corner(k)[1], 0.0);
        (0..4).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap()).collect()
    };
    let at = |s: f64, t: f64| [a + (b - a) * s, c + (d - c) * t];
    let outer = square(at(0.1, 0.1), at(0.8, 0.9));
    let hole: Vec<ParameterCurve> = square(at(0.3, 0.3), at(0.5, 0.7))
        .iter()
        .rev()
        .map(|side| ParameterCurve::whole(side.curve().reverse().unwrap()).unwrap())
        .collect();
    let window =
        Trimmed::new(pipe.clone(), vec![Region { outer, holes: vec![hole] }], Vec::new(), Vec::new())
            .unwrap();
    for (height, ranges) in [(0.5, vec![(0.1, 0.3), (0.5, 0.8)]), (0.2, vec![(0.1, 0.8)]), (0.95, vec![])] {
        let plane = Plane::new(Point::new(0.0, 0.0, 5.0 * height), Vector::z()).unwrap();
        let cut = trimmed_section(&window, &plane, &Options::default()).unwrap();
        assert_eq!(cut.curves.len(), ranges.len(), "{height}: {cut:?}");
        for (from, to) in ranges {
            let ends = [from, to].map(|s| pipe.point(at(s, 0.0)[0], at(0.0, height)[1]).unwrap());
            let found = cut.curves.iter().find(|one| {
                let (s, t) = one.curve.domain();
                let own = [one.curve.point(s).unwrap(), one.curve.point(t).unwrap()];
                (own[0] - ends[0]).norm() + (own[1] - ends[1]).norm() <= 1e-12
            });
            let found = found.unwrap_or_else(|| panic!("{height}: {ends:?} {cut:?}"));
            assert!(found.isocurve.is_some() && found.curve.degree() == 2 && found.curve.weights().is_some());
            assert!(found.curve.points().len() <= 9 && found.distance <= 1e-14);
            let (s, t) = found.curve.domain();
            for k in 0..=100 {
                let p = found.curve.point((s + (t - s) * f64::from(k) / 100.0).min(t)).unwrap();
                assert!((p.x.hypot(p.y) - 2.0).abs() <= 1e-12 && (p.z - 5.0 * height).abs() <= 1e-12, "{p}");
            }
        }
    }
}
