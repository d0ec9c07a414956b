//! What is said of it, sessions, and shapes that have nothing to keep.

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{derivative, position, vertex};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// Two cubic pieces that are smooth at 1, unequally long, flat at the joint.
fn wave() -> Curve {
    let at = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 1.0], [5.0, 1.0], [6.0, 0.0], [7.0, 0.0]];
    let space = Space::open(3, vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0]).unwrap();
    Curve::new(space, at.iter().map(|p| Point::new(p[0], p[1], 0.0)).collect()).unwrap()
}

#[test]
fn a_report_keeps_apart_what_was_asked() {
    let edited = Edit::new(&wave()).ask(position(1.0).by([0.0, 0.5, 0.0])).solve().unwrap();
    let report = edited.report();
    assert_eq!(report.constraints.len(), 1);
    assert_eq!((report.smooth.knots, report.smooth.equations), (1, 3));
    assert_eq!((report.equations, report.rank), (6, 6));
    assert!(report.smooth.corners.is_empty() && report.notes.is_empty() && report.redundant.is_empty());
    assert!(report.to_string().contains("kept smooth at 1 knot (3 equations)"), "{report}");

    let torn = Edit::new(&wave()).smooth(0).ask(vertex(2).by([0.0, 1.0, 0.0])).solve().unwrap();
    assert_eq!(torn.report().smooth.knots, 0);
    assert_eq!(torn.report().notes, ["a corner of 45.0° at 1 (was 0°)"]);
}

#[test]
fn what_is_implied_is_kept_in_silence() {
    // All around the knot stays: the row says nothing more, and nobody is told that it was dropped.
    let edit = Edit::new(&wave()).ask(vertex(2).keep()).ask(vertex(3).keep()).ask(vertex(4).keep());
    let edited = edit.ask(vertex(0).by([1.0, 0.0, 0.0])).solve().unwrap();
    assert!(edited.report().redundant.is_empty(), "{:?}", edited.report().redundant);
    // Locked vertices leave the row without any that may move.
    let locked = Edit::new(&wave()).lock([2, 3, 4]).ask(position(0.5).by([0.0, 0.1, 0.0])).solve().unwrap();
    assert_eq!(locked.report().smooth.knots, 0);
}

#[test]
fn shapes_without_such_knots_answer_what_they_did() {
    let points: Vec<Point> = (0..14).map(|i| Point::new(f64::from(i), f64::from(i * i % 5), 0.3)).collect();
    let spaces = [
        Space::clamped_uniform(3, 14).unwrap(),
        Space::floating_uniform(4, 14).unwrap(),
        Space::periodic_uniform(2, 14).unwrap(),
        Space::open(
            3,
            [vec![0.0; 4], vec![1.0, 1.0, 2.0, 2.0, 3.0, 4.0, 5.0, 5.0, 6.0, 6.0], vec![7.0; 4]].concat(),
        )
        .unwrap(),
    ];
    for space in spaces {
        let curve = Curve::new(space, points.clone()).unwrap();
        let (a, b) = curve.domain();
        let solve = |level: u8| {
            let edit = Edit::new(&curve).smooth(level).ask(position(0.5 * (a + b)).by([0.1, 0.7, 0.0]));
            edit.ask(derivative(0.3 * a + 0.7 * b, 1).keep()).solve().unwrap()
        };
        let (default, let_go) = (solve(1), solve(0));
        assert_eq!(default.shape().points(), let_go.shape().points());
        assert_eq!(default.report(), let_go.report());
        assert!(default.report().smooth.is_empty());
    }
}

#[test]
fn closed_curves_stay_closed_and_smooth_where_they_were() {
    let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
    let (a, b) = circle.domain();
    let mut session = Edit::new(&circle).handle(position(0.0)).prepare(Automatic).unwrap();
    for k in 1..6 {
        let shape = session.to([0.0, 1.0 + 0.2 * f64::from(k), 0.1]).unwrap();
        assert!((shape.point(a).unwrap() - shape.point(b).unwrap()).norm() < 1e-14);
        let (start, end) = (shape.derivative(a, 1).unwrap(), shape.derivative(b, 1).unwrap());
        assert!(start.normalize().cross(&end.normalize()).norm() < 1e-12);
    }
    assert_eq!(session.report().smooth.knots, 4);
    let text = Edit::new(&circle).ask(position(a).by([0.1, 0.0, 0.0])).ask(position(b).keep()).solve();
    let text = text.unwrap_err().to_string();
    assert!(text.contains("smooth seam at 0") && text.contains("smooth = 0"), "{text}");
    let opened = Edit::new(&circle).smooth(0).ask(position(a).by([0.1, 0.0, 0.0])).solve().unwrap();
    assert!(
        opened.report().notes.iter().any(|n| n.starts_with("a gap of 0.1 at 0")),
        "{:?}",
        opened.report().notes
    );
    // A square, closed at a corner: the corner may turn, the ends stay together.
    let square =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]].map(|p| Point::new(p[0], p[1], 0.0));
    let square = Curve::new(Space::clamped_uniform(1, 5).unwrap(), square.to_vec()).unwrap();
    let moved = Edit::new(&square).ask(vertex(0).by([-0.5, -0.5, 0.0])).solve().unwrap();
    assert!((moved.shape().points()[0] - moved.shape().points()[4]).norm() < 1e-15);
}

#[test]
fn a_session_keeps_what_later_constraints_touch() {
    let curve = wave();
    let mut session = Edit::new(&curve).handle(position(0.1)).prepare(Automatic).unwrap();
    let smooth = |c: &Curve| {
        let p = c.control_vertices();
        let (left, right) = (p[3] - p[2], p[4] - p[3]);
        (right - left * 2.0).norm()
    };
    session.to([0.5, 0.5, 0.0]).unwrap();
    let id = session.add(position(2.0).by([0.0, 0.4, 0.0])).unwrap();
    session.apply().unwrap();
    assert!(smooth(session.shape()) < 1e-14);
    session.to([0.7, 0.9, 0.2]).unwrap();
    assert!(smooth(session.shape()) < 1e-14);
    // What cannot be prepared leaves the session as it was, rows of ours included.
    assert!(session.add(position(99.0).keep()).is_err());
    session.remove(id).unwrap();
    session.to([0.7, 0.8, 0.2]).unwrap();
    assert!(smooth(session.shape()) < 1e-14);
    assert!(session.undo().unwrap());
    assert_eq!(session.shape().points(), curve.points());
}

#[test]
fn a_derivative_that_vanishes_has_no_relation_and_is_reported() {
    // The handle after the joint is pulled in: the pieces go on in one direction, but nothing linear says so.
    let (space, mut points, _) = wave().into_parts();
    points[4] = points[3];
    points[5] = Point::new(5.0, 1.0, 0.0);
    let curve = Curve::new(space, points).unwrap();
    let edited = Edit::new(&curve).ask(vertex(2).by([0.0, 0.7, 0.0])).solve().unwrap();
    assert_eq!(edited.report().smooth.knots, 0);
    let [note] = &edited.report().notes[..] else { panic!("{:?}", edited.report().notes) };
    assert!(note.starts_with("a corner of 35.0° at 1 (was 0°)"), "{note}");
}

/// Three points of one place have no tangent; what an edit makes of them is told as that.
#[test]
fn a_corner_where_there_was_no_tangent_is_told() {
    let (space, mut points, _) = wave().into_parts();
    for k in 0..3 {
        points[k] = points[3];
    }
    let curve = Curve::new(space, points).unwrap();
    let edited = Edit::new(&curve).smooth(0).ask(vertex(2).by([-1.0, -1.0, 0.0])).solve().unwrap();
    assert_eq!(edited.report().notes, ["a corner of 45.0° at 1 (had no tangent)"]);
    let on = Edit::new(&curve).smooth(0).ask(vertex(2).by([-1.0, 0.0, 0.0])).solve().unwrap();
    assert!(on.report().notes.is_empty(), "{:?}", on.report().notes);
}

/// Before the knot the first derivative vanishes, and the second points back: the curve comes from where that points.
#[test]
fn a_piece_that_slows_down_to_a_stop_comes_from_where_it_was() {
    let (space, mut points, _) = wave().into_parts();
    points[2] = points[3];
    points[1] = Point::new(1.0, 1.0, 0.0);
    let curve = Curve::new(space, points).unwrap();
    let edit = Edit::new(&curve).smooth(0).ask(vertex(2).keep());
    let edited = edit.ask(vertex(1).by([0.0, -2.0, 0.0])).solve().unwrap();
    assert_eq!(edited.report().notes, ["a corner of 45.0° at 1 (was 0°)"]);
}
