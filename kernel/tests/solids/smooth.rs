//! Faces that meet smoothly and both move.

use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Moving, Parts, Shell, SurfaceForm, Use, Vertex};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::spline::{Direction, Space, Surface};
use loftsman_kernel::text::figure;
use loftsman_kernel::{Point, Vector};

use super::{gaps, size};

/// A wavy surface of some degrees over [0, 2] × [0, 1], with knots of its own; rational where `weights`.
fn wavy([p, q]: [usize; 2], weights: bool, scale: f64) -> Surface {
    let space = |degree: usize, inner: &[f64], end: f64| {
        let mut knots = vec![0.0; degree + 1];
        knots.extend(inner);
        knots.extend(vec![end; degree + 1]);
        Space::open(degree, knots).unwrap()
    };
    let (u, v) = (space(p, &[0.7, 1.3], 2.0), space(q, &[0.4], 1.0));
    let mut points = Vec::new();
    for i in 0..u.len() {
        for j in 0..v.len() {
            let (x, y) = (u.greville(i), v.greville(j));
            points.push(Point::new(x + 0.1 * y * y, y - 0.05 * x, 0.2 * (3.0 * x).sin() * (1.0 + y)) * scale);
        }
    }
    let weights = weights.then(|| (0..points.len()).map(|k| 1.0 + 0.3 * (k as f64).sin().abs()).collect());
    Surface::build(u, v, points, weights).unwrap()
}

/// Faces of some surfaces side by side in `u`, each one's last column the next one's first: an open shell. The edges between are the first ones.
fn strip(sheets: Vec<Surface>) -> Brep {
    let corner = |s: &Surface, end: bool, top: bool| {
        let ((a, b), (c, d)) = (s.u().domain(), s.v().domain());
        s.point(if end { b } else { a }, if top { d } else { c }).unwrap()
    };
    let mut vertices = Vec::new();
    let mut columns = Vec::new();
    let edge = |curve: loftsman_kernel::spline::Curve, ends: [usize; 2]| {
        let range = curve.domain();
        Edge { curve, range, ends, tolerance: 0.0, form: CurveForm::Spline }
    };
    for k in 0..=sheets.len() {
        let (sheet, end) = if k < sheets.len() { (&sheets[k], false) } else { (&sheets[k - 1], true) };
        let (a, b) = sheet.u().domain();
        vertices.extend([corner(sheet, end, false), corner(sheet, end, true)]);
        columns
            .push(edge(sheet.isocurve(Direction::U, if end { b } else { a }).unwrap(), [2 * k, 2 * k + 1]));
    }
    let count = columns.len();
    // Those between first.
    columns.rotate_left(1);
    let column = |k: usize| (k + count - 1) % count;
    let (mut edges, mut faces) = (columns, Vec::new());
    for (k, surface) in sheets.into_iter().enumerate() {
        let (c, d) = surface.v().domain();
        let low = edges.len();
        edges.push(edge(surface.isocurve(Direction::V, c).unwrap(), [2 * k, 2 * k + 2]));
        edges.push(edge(surface.isocurve(Direction::V, d).unwrap(), [2 * k + 1, 2 * k + 3]));
        let one = |edge: usize, reversed: bool| Use { edge, reversed, parameters: None };
        let chain =
            vec![one(low, false), one(column(k + 1), false), one(low + 1, true), one(column(k), true)];
        let loops = vec![chain];
        let form = SurfaceForm::Spline;
        faces.push(Face { name: None, color: None, surface, form, reversed: false, loops, points: vec![] });
    }
    let shells = vec![Shell { faces: (0..faces.len()).collect() }];
    let vertices = vertices.into_iter().map(|point| Vertex { point, tolerance: 0.0 }).collect();
    Brep::new(Parts { vertices, edges, faces, shells, solids: vec![] }).unwrap()
}

/// The largest angle between the normals of two faces along the edge at the end of the first one's `u`.
fn crease(brep: &Brep, [first, other]: [usize; 2]) -> f64 {
    let (f, g) = (brep.surface(first).unwrap(), brep.surface(other).unwrap());
    let normal = |s: &Surface, u: f64, share: f64| {
        let (c, d) = s.v().domain();
        let v = c + (d - c) * share;
        s.derivative(u, v, 1, 0).unwrap().cross(&s.derivative(u, v, 0, 1).unwrap()).normalize()
    };
    let share = |k: i32| f64::from(k) / 400.0;
    let angle = |k: i32| {
        let (a, b) = (normal(&f, f.u().domain().1, share(k)), normal(&g, g.u().domain().0, share(k)));
        a.cross(&b).norm().atan2(a.dot(&b))
    };
    (0..=400).map(angle).fold(0.0, f64::max)
}

fn pulled(brep: &Brep, moving: Moving, at: Location, by: Vector) -> (Brep, String) {
    let edited = Edit::new(&brep.clone().moving(moving)).ask(position(at).by(by)).solve().unwrap();
    let way =
        edited.shape().value(at, Default::default()).unwrap() - brep.value(at, Default::default()).unwrap();
    assert!((way - by).norm() <= 1e-11 * size(brep), "{way} {by}");
    (edited.shape().clone(), edited.report().to_string())
}

#[test]
fn faces_cut_from_one_surface_stay_one_smooth_surface() {
    for degrees in [[2, 2], [3, 3], [3, 5], [5, 3], [4, 4]] {
        for (rational, scale) in [(false, 1.0), (true, 1.0), (false, 1e-6), (true, 1e6)] {
            let whole = wavy(degrees, rational, scale);
            let first = whole.between(Direction::U, 0.0, 1.0).unwrap();
            // The other half at another pace, and with knots of its own.
            let second = whole.between(Direction::U, 1.0, 2.0).unwrap();
            let second = second.reparametrise(Direction::U, 0.0, 3.0).unwrap();
            let second = second.insert_knots(Direction::V, &[0.6]).unwrap();
            let brep = strip(vec![first, second]);
            let at = Location::Face(0, 0.8, 0.45);
            let by = Vector::new(0.05, -0.02, 0.2) * scale;
            let both = Moving::new().faces([0, 1]);
            let (after, told) = pulled(&brep, both.clone(), at, by);
            assert!(
                crease(&after, [0, 1]) < 1e-9,
                "{degrees:?} {rational} {scale}: {:e}",
                crease(&after, [0, 1])
            );
            assert!(gaps(&after)[0] <= 1e-12 * size(&brep), "{degrees:?}");
            assert!(told.contains("1 edge was smooth before, kept so: faces meet there at"), "{told}");
            // By request a crease may come, and is told.
            let (after, told) = pulled(&brep, both.sharp(), at, by);
            let angle = crease(&after, [0, 1]);
            assert!(angle > 1e-3, "{degrees:?}: {angle:e}");
            let said = format!("to {}°", figure(after.openings().unwrap()[0].angle.unwrap().to_degrees()));
            assert!(
                told.contains("1 edge was smooth before: edge 0 changed most") && told.contains(&said),
                "{said} {told}"
            );
            assert!(after.openings().unwrap()[0].angle.unwrap() <= angle * (1.0 + 1e-12));
            // Beside a face that stands still, too.
            let (after, told) = pulled(&brep, Moving::new().sharp(), at, by);
            assert!(crease(&after, [0, 1]) > 1e-3, "{degrees:?}");
            let said = figure(after.openings().unwrap()[0].angle.unwrap().to_degrees());
            assert!(
                told.contains("1 edge was smooth before: edge 0 changed most")
                    && told.contains(&format!("to {said}°")),
                "{said} {told}"
            );
            let (after, told) = pulled(&brep, Moving::new(), at, by);
            assert!(crease(&after, [0, 1]) < 1e-9 && !told.contains("smooth before"), "{told}");
        }
    }
}

/// Derivatives across the edge whose ratio changes along it: kept at places, and what is left between these is small and told.
#[test]
fn a_pace_that_changes_along_the_edge_leaves_little() {
    let first = wavy([3, 3], false, 1.0).between(Direction::U, 0.0, 1.0).unwrap();
    let (c, rim) = (first.isocurve(Direction::U, 1.0).unwrap(), first.u().len() - 1);
    // G_u = (1 + v) F_u along the edge: of degree 4 there, as the product of a line and a cubic.
    let columns = first.v().len();
    let p = first.u().degree() as f64;
    let h = 1.0 - first.u().knots()[rim];
    let across =
        |j: usize| (first.points()[rim * columns + j] - first.points()[(rim - 1) * columns + j]) * (p / h);
    let slope = loftsman_kernel::spline::Curve::new(
        first.v().clone(),
        (0..columns).map(|j| across(j).into()).collect(),
    )
    .unwrap();
    let places: Vec<f64> = {
        let space = slope.elevate(1).unwrap();
        (0..space.space().len()).map(|k| space.space().greville(k)).collect()
    };
    let raised = c.elevate(1).unwrap();
    // The product by interpolation in the space that holds it.
    let count = places.len();
    let mut matrix = nalgebra::DMatrix::zeros(count, count);
    let mut right = nalgebra::DMatrix::zeros(count, 3);
    for (k, &v) in places.iter().enumerate() {
        let row = Shape::stencil(&raised, Location::Curve(v), Default::default()).unwrap();
        row.iter().for_each(|(i, x)| matrix[(k, i)] = x);
        let value = slope.point(v).unwrap().coords * (1.0 + v);
        (0..3).for_each(|d| right[(k, d)] = value[d]);
    }
    let solved = matrix.lu().solve(&right).unwrap();
    let mut points = raised.points().to_vec();
    for step in [1.0 / 3.0, 2.0 / 3.0, 1.0] {
        points.extend((0..count).map(|k| {
            let way = Vector::new(solved[(k, 0)], solved[(k, 1)], solved[(k, 2)]);
            raised.points()[k] + way * step + Vector::new(0.0, 0.0, 0.1) * (step - 1.0 / 3.0)
        }));
    }
    let second =
        Surface::build(Space::clamped(3, &[0.0, 1.0]).unwrap(), raised.space().clone(), points, None)
            .unwrap();
    let brep = strip(vec![first, second]);
    assert!(crease(&brep, [0, 1]) < 1e-9, "{:e}", crease(&brep, [0, 1]));
    let at = Location::Face(0, 0.8, 0.45);
    let (after, told) = pulled(&brep, Moving::new().faces([0, 1]), at, Vector::new(0.05, -0.02, 0.2));
    let (angle, sharp) = (
        crease(&after, [0, 1]),
        crease(
            &pulled(&brep, Moving::new().faces([0, 1]).sharp(), at, Vector::new(0.05, -0.02, 0.2)).0,
            [0, 1],
        ),
    );
    assert!(angle < 1e-4 && sharp > 100.0 * angle, "{angle:e} {sharp:e} {told}");
    assert!(gaps(&after)[0] <= 1e-12 * size(&brep));
}

/// Three faces in a row: the middle one is held smoothly on both sides, and can still move.
#[test]
fn a_face_between_two_stays_smooth_with_both() {
    let whole = wavy([3, 3], false, 1.0);
    let part = |a: f64, b: f64| whole.between(Direction::U, a, b).unwrap();
    let brep = strip(vec![part(0.0, 0.6), part(0.6, 1.4), part(1.4, 2.0)]);
    let by = Vector::new(0.0, 0.0, 0.3);
    let (after, told) = pulled(&brep, Moving::new().neighbours(1), Location::Face(1, 0.65, 0.5), by);
    for pair in [[0, 1], [1, 2]] {
        assert!(crease(&after, pair) < 1e-9, "{pair:?} {told}");
    }
    assert!(told.contains("smooth before, kept so"), "{told}");
    // Alone it moves between edges that stay, smoothly too.
    let (after, _) = pulled(&brep, Moving::new(), Location::Face(1, 1.0, 0.5), by);
    for pair in [[0, 1], [1, 2]] {
        assert!(crease(&after, pair) < 1e-9, "{pair:?}");
    }
}

/// Faces of files meet at some hundredths of a degree where they are meant to be smooth: that stays what it is.
#[test]
fn what_is_nearly_smooth_stays_so() {
    let whole = wavy([3, 3], false, 1.0);
    let second = whole.between(Direction::U, 1.0, 2.0).unwrap();
    let (u, v, mut points, _) = second.into_parts();
    let columns = v.len();
    for j in 0..columns {
        let step = points[columns + j] - points[j];
        let side = step.cross(&Vector::y()).normalize();
        points[columns + j] += side * (step.norm() * 0.5_f64.to_radians().sin());
    }
    let second = Surface::build(u, v, points, None).unwrap();
    let brep = strip(vec![whole.between(Direction::U, 0.0, 1.0).unwrap(), second]);
    let before = crease(&brep, [0, 1]);
    assert!(before > 1e-3 && before < 1.0_f64.to_radians(), "{before}");
    let (at, by) = (Location::Face(0, 0.5, 0.5), Vector::new(0.0, 0.0, 0.3));
    for moving in [Moving::new(), Moving::new().faces([0, 1])] {
        let (after, told) = pulled(&brep, moving, at, by);
        assert!(crease(&after, [0, 1]) < 2.0 * before, "{:e} {before:e} {told}", crease(&after, [0, 1]));
    }
    let (after, _) = pulled(&brep, Moving::new().faces([0, 1]).sharp(), at, by);
    assert!(crease(&after, [0, 1]) > 4.0 * before);
}

/// At a pole that an edit has left round to the last bit only, the rounding points anywhere: it is no direction of the surface.
#[test]
fn rounding_at_a_pole_is_no_crease() {
    for scale in [1e-6, 1.0, 1e6] {
        let (u, v, mut points, _) = wavy([3, 3], false, scale).into_parts();
        for i in 0..u.len() {
            for j in 0..v.len() {
                let (x, y) = (u.greville(i), v.greville(j));
                points[i * v.len() + j] = Point::new(x * y, y, 0.2 * (3.0 * x).sin() * y * y) * scale;
            }
        }
        let whole = Surface::new(u, v, points).unwrap();
        let halves = [(0.0, 1.0), (1.0, 2.0)].map(|(a, b)| {
            let half = whole.between(Direction::U, a, b).unwrap();
            let (u, v, mut points, _) = half.into_parts();
            for i in 1..u.len() - 1 {
                points[i * v.len()] += Vector::new(0.1, 0.7, (i as f64).cos()) * (1e-16 * scale);
            }
            Surface::new(u, v, points).unwrap()
        });
        let opening = strip(halves.to_vec()).openings().unwrap()[0];
        assert!(opening.angle.unwrap() < 1e-9, "{scale}: {opening:?}");
    }
}
