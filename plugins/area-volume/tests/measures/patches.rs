//! Closed sets of patches whose edges are the same curves with other knots, degrees, directions, parameters and seams.

use std::f64::consts::{PI, TAU};

use loftsman_area_volume::{gap, volume};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Functional, On, Shapes, position};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::spline::{Curve, Direction, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::samples::patches;

fn shapes(all: &[Surface]) -> Shapes<'_> {
    Shapes::new(all.iter().map(|s| s as &dyn Shape))
}

fn everyone(all: &[Surface]) -> Vec<On> {
    (0..all.len()).map(On::from).collect()
}

fn enclosed(all: &[Surface]) -> f64 {
    let mut out = [f64::NAN];
    volume().of(everyone(all)).value(&shapes(all), &mut out).unwrap();
    out[0].abs()
}

fn refused(all: &[Surface], words: &[&str]) {
    let error = volume().of(everyone(all)).value(&shapes(all), &mut [0.0]).unwrap_err().to_string();
    for word in words {
        assert!(error.contains(word), "\"{word}\" is not in: {error}");
    }
}

/// The box, each patch in a space of its own.
fn unlike(bulge: f64) -> Vec<Surface> {
    let mut all = patches(3, bulge);
    all[0] = all[0].elevate(Direction::U, 1).unwrap();
    all[1] = all[1].insert_knots(Direction::V, &[0.3, 0.7]).unwrap().reverse(Direction::U).unwrap();
    all[2] = all[2].reparametrise(Direction::U, -5.0, 17.0).unwrap();
    all[3] = all[3].elevate(Direction::V, 2).unwrap().insert_knots(Direction::U, &[1.0 / 3.0]).unwrap();
    all[4] =
        all[4].insert_knots(Direction::U, &[0.5, 0.5]).unwrap().insert_knots(Direction::V, &[0.1]).unwrap();
    all
}

#[test]
fn a_box_of_patches_that_have_nothing_in_common() {
    let all = unlike(0.0);
    assert!((enclosed(&all) / 8.0 - 1.0).abs() < 1e-13, "{}", enclosed(&all));
    assert!(gap(&shapes(&all), &everyone(&all)).unwrap() < 1e-14);
    let bulging = enclosed(&patches(3, 0.2));
    assert!((enclosed(&unlike(0.2)) / bulging - 1.0).abs() < 1e-13);
}

#[test]
fn edges_of_unlike_patches_stay_one_while_they_are_edited() {
    for alternating in [false, true] {
        let all = unlike(0.2);
        let kept = enclosed(&all);
        // A corner, and the middle of an edge: both belong to several patches.
        let mut edit = Edit::new(&all[0]).ask(volume().of(0..6).keep()).handle(position([0.0, 0.4]));
        for patch in &all[1..] {
            edit = edit.with(patch.boxed());
        }
        let edit = if alternating { edit.alternating() } else { edit };
        let mut session = edit.prepare(Automatic).unwrap();
        let from = all[0].point(0.0, 0.4).unwrap();
        for step in 1..=10 {
            session.to_point(from + Vector::new(0.03, 0.02, -0.01) * f64::from(step)).unwrap();
            let mut out = [f64::NAN];
            volume().of(0..6).value(&session.problem().shapes(), &mut out).unwrap();
            assert!((out[0].abs() / kept - 1.0).abs() < 1e-12, "{step}: {out:?}");
            assert!(gap(&session.problem().shapes(), &everyone(&all)).unwrap() < 1e-13);
        }
    }
}

/// A cylinder's wall of radius 1 and height 2, or a disc at a height.
fn revolved(from: Point, to: Point) -> Surface {
    let line = Curve::line(from, to).unwrap();
    Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap()
}

#[test]
fn a_tin_with_lids_of_other_degrees_and_knots() {
    let wall = revolved(Point::new(1.0, 0.0, 0.0), Point::new(1.0, 0.0, 2.0));
    let lid = |z: f64| revolved(Point::new(0.0, 0.0, z), Point::new(1.0, 0.0, z));
    let around = if wall.u().len() > wall.v().len() { Direction::U } else { Direction::V };
    let (a, b) = wall.space(around).domain();
    let bottom = lid(0.0).elevate(around, 1).unwrap().reverse(around).unwrap();
    let top = lid(2.0).insert_knots(around, &[0.9 * a + 0.1 * b, 0.35 * a + 0.65 * b]).unwrap();
    let tin = [wall, bottom, top];
    assert!((enclosed(&tin) / (2.0 * PI) - 1.0).abs() < 1e-12, "{}", enclosed(&tin));
    // Open: the lid is missing, and that is said with the name of what is there.
    refused(&tin[..2], &["the boundary is open", "2 away", "the shape"]);
}

/// A ring of control vertices, turned by so many of them, at a height.
fn ring(turned: usize, n: usize, radius: f64, z: f64) -> impl Iterator<Item = Point> {
    (0..n).map(move |i| {
        let (sin, cos) = (TAU * (i + turned) as f64 / n as f64).sin_cos();
        Point::new(radius * cos, radius * sin, z)
    })
}

#[test]
fn periodic_edges_that_start_elsewhere() {
    let n = 9;
    let strip = |rows: Vec<Vec<Point>>, space: Space| {
        let net = rows.into_iter().flatten().collect();
        Surface::new(Space::clamped(1, &[0.0, 1.0]).unwrap(), space, net).unwrap()
    };
    let round =
        |domain: f64| Space::periodic(3, (0..=n).map(|i| domain * i as f64 / n as f64).collect()).unwrap();
    let wall = |turned| {
        strip(vec![ring(turned, n, 1.0, 0.0).collect(), ring(turned, n, 1.0, 2.0).collect()], round(9.0))
    };
    let lid = |z, turned, domain| {
        strip(vec![vec![Point::new(0.0, 0.0, z); n], ring(turned, n, 1.0, z).collect()], round(domain))
    };
    let plain = enclosed(&[wall(0), lid(0.0, 0, 9.0), lid(2.0, 0, 9.0)]);
    // A polygon's circle of uniform cubics: its area by the form of the theory, times the height.
    let turned = [wall(2), lid(0.0, 5, 9.0), lid(2.0, 0, 4.0).reverse(Direction::V).unwrap()];
    assert!((enclosed(&turned) / plain - 1.0).abs() < 1e-12, "{}", enclosed(&turned));
    // A lid opened at its seam, and so clamped, on a wall that starts elsewhere.
    let clamped = lid(0.0, 4, 1.0);
    let clamped = clamped.convert(Direction::V, &clamped.v().clamping().unwrap()).unwrap();
    let mixed = [wall(1), clamped, lid(2.0, 0, 9.0)];
    assert!((enclosed(&mixed) / plain - 1.0).abs() < 1e-12, "{}", enclosed(&mixed));
}

#[test]
fn edges_that_meet_only_as_sets_of_points_say_what_to_do() {
    // Twice as fast at one end as at the other: the same square with other parameters.
    let mut all = patches(1, 0.0);
    let (u, v, points, _) = all[0].clone().into_parts();
    all[0] = Surface::build(u, v, points, Some(vec![1.0, 1.0, 2.0, 2.0])).unwrap();
    refused(&all, &["meet", "different parameters", "the shape", "rebuild"]);
    // One face in two halves: the edges of the others meet two each.
    let mut all = patches(1, 0.0);
    let mut halves = all[0].split(Direction::U, 0.5).unwrap();
    all[0] = halves.remove(0);
    all.append(&mut halves);
    refused(&all, &["meets several edges", "split"]);
    // A wall inside: three patches meet at each of its edges.
    let mut walled = patches(1, 0.0);
    let (u, v, points, _) = walled[0].clone().into_parts();
    walled.push(Surface::new(u, v, points).unwrap());
    refused(&walled, &["meets another edge already", "leave the others out"]);
    all.rotate_left(1);
    refused(&all, &["meets several edges", "every edge meets one other"]);
}
