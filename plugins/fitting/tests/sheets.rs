//! Open sheets fitted to noisy points: they end where their points end.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::TAU;

use loftsman_fitting::{CloudFit, DerivativeEnergy};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::{Cage, SubdivisionSurface};

use crate::common::families::Random;

const FORMS: [&str; 4] = ["waves", "cylinder", "saddle", "dome"];
const NETS: [&str; 3] = ["quads", "triangles", "mixed"];

/// A sheet whose limit is known, one near to it, and noisy points of the first.
struct Case {
    name: String,
    truth: SubdivisionSurface,
    start: SubdivisionSurface,
    points: Vec<Point>,
}

fn surface(points: &[Vector], faces: &[Vec<usize>]) -> SubdivisionSurface {
    let points = points.iter().copied().map(Point::from).collect();
    SubdivisionSurface::new(Cage::new(points, faces).unwrap()).unwrap()
}

fn form(kind: &str, [x, y]: [f64; 2]) -> Vector {
    match kind {
        "waves" => Vector::new(x, y, 0.12 * (TAU * 0.8 * x).sin() * (TAU * 0.6 * y).cos()),
        "cylinder" => Vector::new(0.5 * (2.2 * x).sin(), y, 0.5 * (2.2 * x).cos()),
        "saddle" => Vector::new(x, y, 0.8 * (x - 0.5) * (y - 0.4)),
        _ => Vector::new(x, y, -0.6 * ((x - 0.5).powi(2) + (y - 0.5).powi(2))),
    }
}

/// The faces of a grid of so many vertices.
fn faces(net: &str, rows: usize, columns: usize, r: &mut Random) -> Vec<Vec<usize>> {
    let mut faces = Vec::new();
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let at = |a: usize, b: usize| (i + a) * columns + j + b;
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let split = net == "triangles" || net == "mixed" && r.whole(0, 2) == 0;
            match (split, r.whole(0, 1)) {
                (false, _) => faces.push(vec![a, b, c, d]),
                (true, 0) => faces.extend([vec![a, b, c], vec![a, c, d]]),
                _ => faces.extend([vec![a, b, d], vec![b, c, d]]),
            }
        }
    }
    faces
}

fn case(seed: u64) -> Case {
    let mut r = Random::new(seed ^ 0xA5A5);
    let (kind, net) = (FORMS[seed as usize % 4], NETS[seed as usize / 4 % 3]);
    let (rows, columns) =
        if net == "quads" { (r.whole(4, 14), r.whole(5, 15)) } else { (r.whole(4, 10), r.whole(4, 11)) };
    let faces = faces(net, rows, columns, &mut r);
    let jitter = 0.2;
    let mut plain = Vec::new();
    for k in 0..rows * columns {
        let place = [(k / columns) as f64 / (rows - 1) as f64, (k % columns) as f64 / (columns - 1) as f64];
        let inner = |x: f64, n: usize, r: &mut Random| {
            if x == 0.0 || x == 1.0 { x } else { x + jitter * r.between(-1.0, 1.0) / n as f64 }
        };
        plain.push([inner(place[0], rows - 1, &mut r), inner(place[1], columns - 1, &mut r)]);
    }
    let net_points: Vec<Vector> = plain.iter().map(|p| form(kind, *p)).collect();
    let truth = surface(&net_points, &faces);
    let by = r.pick(&[0.0, 0.01, 0.03]);
    let stirred: Vec<Vector> =
        net_points.iter().map(|p| p + Vector::new(r.normal(), r.normal(), r.normal()) * by).collect();
    let start = surface(&stirred, &faces);
    let sigma = r.pick(&[0.0, 0.005, 0.01, 0.02]);
    let part = r.pick(&[1.0, 1.0, 0.75, 0.5]);
    let many = rows * columns * r.pick(&[3, 6, 12]);
    let count = truth.faces().unwrap();
    let mut points = Vec::new();
    while points.len() < many {
        let at = Location::Face(r.whole(0, count - 1) as u32, r.unit(), r.unit());
        let p = truth.value(at, Derivative::POSITION).unwrap();
        let noise = Vector::new(r.normal(), r.normal(), r.normal()) * sigma;
        if p.y <= part {
            points.push(Point::from(p + noise));
        }
    }
    let name = format!("{kind} {net} {}f stir {by} part {part} noise {sigma} n {many}", faces.len());
    Case { name, truth, start, points }
}

fn samples(s: &SubdivisionSurface, each: usize) -> Vec<Point> {
    let share = |k: usize| k as f64 / (each - 1) as f64;
    (0..s.faces().unwrap() * each * each)
        .map(|k| {
            let (face, at) = (k / (each * each), k % (each * each));
            let at = Location::Face(face as u32, share(at / each), share(at % each));
            Point::from(s.value(at, Derivative::POSITION).unwrap())
        })
        .collect()
}

fn area(s: &SubdivisionSurface) -> f64 {
    CloudFit::new(s).iterations(0).to(&[Point::origin()]).unwrap().report().measure[0]
}

/// Before they were held from sliding along themselves three of these shrank to the part that has points (to 0.48, 0.50 and 0.76 of their area), and one crumpled to
/// 1.47 of it.
#[test]
fn sheets_end_where_they_should() {
    let (seeds, mut sum, mut turned) = ([0, 2, 4, 5, 6, 9, 16, 19], 0.0, 0);
    for seed in seeds {
        let case = case(seed);
        let fitted = CloudFit::new(&case.start).fair(DerivativeEnergy(2)).to(&case.points).unwrap();
        let report = fitted.report();
        let ratio = report.measure[1] / area(&case.truth);
        let beyond = CloudFit::new(&case.truth).iterations(0).to(&samples(fitted.shape(), 4)).unwrap();
        let short = CloudFit::new(fitted.shape()).iterations(0).to(&samples(&case.truth, 4)).unwrap();
        let far = [beyond, short].map(|f| f.report().largest);
        println!(
            "{seed} {}: {ratio:.3} of the area, beyond and short {far:.3?}, {:?} {:?}, {report}",
            case.name, report.turned, report.beyond
        );
        assert!(ratio > 0.85 && ratio < 1.15, "{seed} {}: {ratio}", case.name);
        assert!(far.iter().all(|far| *far < 0.2), "{seed} {}: {far:?}", case.name);
        assert!(report.turned.share < 0.01 && !report.is_beyond(), "{seed} {}: {report:?}", case.name);
        turned += usize::from(report.turned.share > 0.0);
        sum += (ratio - 1.0).abs();
    }
    assert!(sum < 0.06 * seeds.len() as f64 && turned <= 1, "{sum} {turned}");
}

/// Points beyond a sheet move its border all the same.
#[test]
fn points_beyond_a_border_move_it() {
    for seed in [8, 9] {
        let case = case(seed);
        let size = |s: &SubdivisionSurface| area(s) / area(&case.truth);
        let mut small = case.start.clone();
        let middle = Vector::new(0.5, 0.5, 0.0);
        small
            .control_vertices_mut()
            .iter_mut()
            .for_each(|p| *p = Point::from(middle + (p.coords - middle) * 0.85));
        let fitted = CloudFit::new(&small).fair(DerivativeEnergy(2)).to(&case.points).unwrap();
        let (was, is) = (size(&small), size(fitted.shape()));
        println!("{seed} {}: {was:.3} to {is:.3} of the area, {}", case.name, fitted.report());
        assert!(was < 0.75 && is > 0.8 && is < 1.1, "{was} {is}");
    }
}
