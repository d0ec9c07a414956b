//! Curves with curves.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]
use loftsman_intersection::{Contact, Options, curve_surface, curves};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

#[test]
fn circles_cross_touch_and_overlap() {
    let o = Options::default();
    for (scale, away) in [(1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1e4)] {
        let at = |x: f64| Point::new(away + x * scale, 0.0, 0.0);
        let ring = |x: f64, r: f64| Curve::circle(at(x), Vector::z(), r * scale).unwrap();
        let found = curves(&ring(0.0, 1.0), &ring(1.2, 1.0), &o).unwrap();
        assert_eq!((found.meetings.len(), found.overlaps.len()), (2, 0), "{found:#?}");
        for m in &found.meetings {
            assert!(
                (m.point.x - away - 0.6 * scale).abs() < 1e-11 * (scale + away)
                    && m.contact == Contact::Crossing
            );
        }
        let found = curves(&ring(0.0, 1.0), &ring(3.0, 2.0), &o).unwrap();
        assert_eq!((found.meetings.len(), found.overlaps.len()), (1, 0), "{found:#?}");
        assert_eq!(found.meetings[0].contact, Contact::Touching);
        let found = curves(&ring(0.0, 1.0), &ring(0.0, 1.0), &o).unwrap();
        assert_eq!((found.meetings.len(), found.overlaps.len()), (0, 1), "{found:#?}");
        let part = ring(0.0, 1.0).between(0.1, 0.6).unwrap();
        let found = curves(&part, &ring(0.0, 1.0), &o).unwrap();
        assert_eq!((found.meetings.len(), found.overlaps.len()), (0, 1), "{found:#?}");
        assert!(found.is_complete());
        let found = curves(&ring(0.0, 1.0), &ring(0.0, 1.001), &o).unwrap();
        assert_eq!((found.meetings.len(), found.overlaps.len()), (0, 0), "{found:#?}");
    }
}

#[test]
fn a_line_and_a_wave_and_a_ball() {
    let wave = Curve::new(
        Space::clamped_uniform(3, 12).unwrap(),
        (0..12).map(|i| Point::new(f64::from(i), if i % 2 == 0 { 1.0 } else { -1.0 }, 0.0)).collect(),
    )
    .unwrap();
    let line = Curve::line(Point::new(-1.0, 0.0, 0.0), Point::new(12.0, 0.0, 0.0)).unwrap();
    let found = curves(&line, &wave, &Options::default()).unwrap();
    assert_eq!(found.meetings.len(), 11, "{found:#?}");
    let half =
        Curve::arc(Point::new(0.0, 0.0, -2.0), Point::origin(), Vector::y(), std::f64::consts::PI).unwrap();
    let ball = Surface::revolution(&half, Point::origin(), Vector::z(), std::f64::consts::TAU).unwrap();
    let line = Curve::line(Point::new(-5.0, 0.3, 0.4), Point::new(5.0, 0.5, -0.2)).unwrap();
    let found = curve_surface(&line, &ball, &Options::default()).unwrap();
    assert_eq!(found.meetings.len(), 2, "{found:#?}");
    for m in &found.meetings {
        assert!((m.point.coords.norm() - 2.0).abs() < 1e-13);
    }
    let found = curve_surface(&half, &ball, &Options::default()).unwrap();
    assert_eq!((found.meetings.len(), found.overlaps.len()), (0, 1), "{found:#?}");
    let tangent = Curve::line(Point::new(-5.0, 2.0, 0.0), Point::new(5.0, 2.0, 0.0)).unwrap();
    let found = curve_surface(&tangent, &ball, &Options::default()).unwrap();
    assert_eq!((found.meetings.len(), found.overlaps.len()), (1, 0), "{found:#?}");
}
