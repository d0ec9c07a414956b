//! Cages of every kind fitted to noisy points of their own limit: what comes out is near to what was measured, and not folded.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::TAU;

use loftsman_fitting::{CloudFit, DerivativeEnergy};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::{Cage, SubdivisionSurface};

use crate::common::families::Random;

const KINDS: [&str; 8] = ["sphere", "hull", "bipyramid", "box", "torus", "sheet", "prism", "rough"];

/// A cage whose limit is known, a cage near to it, points of the first with noise, and how much.
struct Case {
    kind: &'static str,
    truth: SubdivisionSurface,
    start: SubdivisionSurface,
    points: Vec<Point>,
    sigma: f64,
}

fn surface(points: Vec<Vector>, faces: &[Vec<usize>]) -> SubdivisionSurface {
    SubdivisionSurface::new(Cage::new(points.into_iter().map(Point::from).collect(), faces).unwrap()).unwrap()
}

/// The triangles of the convex hull of points on a sphere.
fn hull(points: &[Vector]) -> Vec<Vec<usize>> {
    let n = points.len();
    let mut faces = Vec::new();
    for a in 0..n {
        for b in a + 1..n {
            for c in b + 1..n {
                let normal = (points[b] - points[a]).cross(&(points[c] - points[a]));
                let sides: Vec<f64> = (0..n)
                    .filter(|k| ![a, b, c].contains(k))
                    .map(|k| normal.dot(&(points[k] - points[a])))
                    .collect();
                if sides.iter().all(|s| *s < 0.0) {
                    faces.push(vec![a, b, c]);
                } else if sides.iter().all(|s| *s > 0.0) {
                    faces.push(vec![a, c, b]);
                }
            }
        }
    }
    faces
}

fn cube() -> (Vec<Vector>, Vec<Vec<usize>>) {
    boxes([1, 1, 1])
}

/// The faces of a block of so many boxes.
fn boxes(count: [usize; 3]) -> (Vec<Vector>, Vec<Vec<usize>>) {
    let mut places: Vec<[usize; 3]> = Vec::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, count[axis]] {
            for i in 0..count[b] {
                for j in 0..count[c] {
                    let mut face: Vec<usize> = [[0, 0], [1, 0], [1, 1], [0, 1]]
                        .iter()
                        .map(|[p, q]| {
                            let mut at = [0; 3];
                            (at[axis], at[b], at[c]) = (side, i + p, j + q);
                            places.iter().position(|x| *x == at).unwrap_or_else(|| {
                                places.push(at);
                                places.len() - 1
                            })
                        })
                        .collect();
                    if side == 0 {
                        face.reverse();
                    }
                    faces.push(face);
                }
            }
        }
    }
    let point = |at: &[usize; 3]| Vector::from_fn(|k, _| at[k] as f64 / count[k] as f64 - 0.5);
    (places.iter().map(point).collect(), faces)
}

/// Vertices and faces of a kind.
fn cage(kind: &str, r: &mut Random) -> (Vec<Vector>, Vec<Vec<usize>>) {
    let ring = |k: usize, n: usize| {
        let a = TAU * k as f64 / n as f64;
        Vector::new(a.cos(), a.sin(), 0.0)
    };
    match kind {
        "sphere" => {
            let (points, faces) = cube();
            let cage = Cage::new(points.into_iter().map(Point::from).collect(), &faces).unwrap();
            let fine = refine(&cage).unwrap();
            let net = fine.topology();
            let faces =
                (0..net.face_count()).map(|f| net.face(f).iter().map(|&v| v as usize).collect()).collect();
            (fine.points().iter().map(|p| p.coords.normalize()).collect(), faces)
        }
        "hull" | "rough" => {
            let n = r.whole(8, 14);
            let points: Vec<Vector> =
                (0..n).map(|_| Vector::new(r.normal(), r.normal(), r.normal()).normalize()).collect();
            let faces = hull(&points);
            let long = if kind == "rough" {
                Vector::new(r.between(0.6, 2.0), 1.0, r.between(0.6, 2.0))
            } else {
                Vector::repeat(1.0)
            };
            (points.iter().map(|p| p.component_mul(&long)).collect(), faces)
        }
        "bipyramid" => {
            let n = r.whole(5, 9);
            let mut points: Vec<Vector> = (0..n).map(|k| ring(k, n)).collect();
            points.extend([Vector::z(), -Vector::z()]);
            let up = (0..n).map(|k| vec![k, (k + 1) % n, n]);
            (points, up.chain((0..n).map(|k| vec![(k + 1) % n, k, n + 1])).collect())
        }
        "box" => boxes([r.whole(2, 3), r.whole(1, 2), 1]),
        "torus" => {
            let (n, m) = (r.whole(4, 6), r.whole(3, 4));
            let at = |k: usize| {
                let (a, b) = (ring(k / m, n), ring(k % m, m));
                a * (2.0 + b.x) + Vector::z() * b.y
            };
            let face = |k: usize| {
                let (i, j) = (k / m, k % m);
                let at = |i: usize, j: usize| (i % n) * m + j % m;
                vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
            };
            ((0..n * m).map(at).collect(), (0..n * m).map(face).collect())
        }
        "sheet" => {
            let (n, m) = (r.whole(4, 5), r.whole(4, 6));
            let at = |k: usize| {
                let (x, y) = ((k / m) as f64, (k % m) as f64);
                Vector::new(x, y, (0.8 * x).sin() * (0.7 * y).cos())
            };
            let face = |k: usize| {
                let at = k / (m - 1) * m + k % (m - 1);
                vec![at, at + m, at + m + 1, at + 1]
            };
            ((0..n * m).map(at).collect(), (0..(n - 1) * (m - 1)).map(face).collect())
        }
        _ => {
            let n = r.whole(4, 8);
            let points = (0..2 * n).map(|k| ring(k % n, n) + Vector::z() * if k < n { -1.0 } else { 1.0 });
            let mut faces: Vec<Vec<usize>> =
                (0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]).collect();
            faces.push((0..n).rev().collect());
            faces.push((n..2 * n).collect());
            (points.collect(), faces)
        }
    }
}

fn extent(points: &[Vector]) -> f64 {
    let all = || points.iter();
    (0..3)
        .map(|k| all().fold(f64::MIN, |m, p| m.max(p[k])) - all().fold(f64::MAX, |m, p| m.min(p[k])))
        .fold(0.0, f64::max)
}

fn at(s: &SubdivisionSurface, place: Location) -> Vector {
    s.value(place, Derivative::POSITION).unwrap()
}

fn normal(s: &SubdivisionSurface, place: Location) -> Vector {
    let by = |u: usize, v: usize| s.value(place, Derivative { u, v }).unwrap();
    by(1, 0).cross(&by(0, 1))
}

/// The case of a seed: the kind in turn, all else drawn.
fn case(seed: u64) -> Case {
    let mut r = Random::new(seed);
    let kind = KINDS[seed as usize % KINDS.len()];
    let (mut points, faces) = cage(kind, &mut r);
    let mut stir = |by: f64, points: &[Vector]| -> Vec<Vector> {
        points.iter().map(|p| p + Vector::new(r.normal(), r.normal(), r.normal()) * by).collect()
    };
    points = stir(0.05, &points);
    let size = extent(&points);
    let mut q = Random::new(seed ^ 0x5555);
    let start = stir(size * q.pick(&[0.02, 0.05, 0.08]), &points);
    let vertices = points.len();
    let truth = surface(points, &faces);
    let many = vertices * q.pick(&[5, 10, 20]);
    let sigma = size * q.pick(&[0.005, 0.01, 0.02, 0.03]);
    let count = truth.faces().unwrap();
    let points = (0..many)
        .map(|_| {
            let place = Location::Face(q.whole(0, count - 1) as u32, q.unit(), q.unit());
            Point::from(at(&truth, place) + Vector::new(q.normal(), q.normal(), q.normal()) * sigma)
        })
        .collect();
    Case { kind, truth, start: surface(start, &faces), points, sigma }
}

/// Places of every face, `each²` a face, none on its border.
fn places(s: &SubdivisionSurface, each: usize) -> Vec<Location> {
    let share = |k: usize| (k as f64 + 0.5) / each as f64;
    (0..s.faces().unwrap() * each * each)
        .map(|k| {
            let (face, at) = (k / (each * each), k % (each * each));
            Location::Face(face as u32, share(at / each), share(at % each))
        })
        .collect()
}

/// How far a surface is from another, in the mean of the squares, both ways; and the part of it that looks the other way than the other where it
/// is nearest.
fn apart(fitted: &SubdivisionSurface, truth: &SubdivisionSurface) -> (f64, f64) {
    let on = |s: &SubdivisionSurface, each: usize| -> (Vec<Location>, Vec<Point>) {
        let all = places(s, each);
        let points = all.iter().map(|p| Point::from(at(s, *p))).collect();
        (all, points)
    };
    let (own, samples) = on(fitted, 6);
    let there = CloudFit::new(truth).iterations(0).to(&samples).unwrap();
    let turned = own
        .iter()
        .zip(there.feet())
        .filter(|(a, b)| {
            let (a, b) = (normal(fitted, **a), normal(truth, **b));
            a.dot(&b) < 0.0
        })
        .count();
    let back = CloudFit::new(fitted).iterations(0).to(&on(truth, 4).1).unwrap();
    let both = (there.report().rms.powi(2) + back.report().rms.powi(2)) / 2.0;
    (both.sqrt(), turned as f64 / own.len() as f64)
}

/// Noise of half a hundredth to three hundredths of the size, five to twenty points a vertex. By what is left of the noise alone five of these
/// are fitted farther off, or folded.
#[test]
fn noisy_points_do_not_fold_cages() {
    let (seeds, mut sum, mut folds) = ([4, 8, 10, 16, 18, 19, 20, 26], 0.0, 0);
    for seed in seeds {
        let case = case(seed);
        let fitted = CloudFit::new(&case.start).fair(DerivativeEnergy(2)).to(&case.points).unwrap();
        let (off, folded) = apart(fitted.shape(), &case.truth);
        let off = off / case.sigma;
        println!("{seed} {}: off {off:.3} of the noise, folded {folded:.4}, {}", case.kind, fitted.report());
        assert!(off < 1.5, "{seed} {}: {off} {folded}", case.kind);
        folds += usize::from(folded > 0.0);
        assert!(fitted.report().converged, "{seed}: {}", fitted.report());
        sum += off;
    }
    // One of them has 50 points for 10 vertices and noise of 6 % of its size, and its folds are not told from it.
    assert!(folds <= 1, "{folds}");
    assert!(sum < 0.8 * seeds.len() as f64, "{sum}");
}

/// With the weight that points which are left out call for, shapes that bend less and go where no point is have the least of distances and energy:
/// by that alone these are fitted 2.8 to 3.3 of the noise off, one of them folded.
#[test]
fn shapes_do_not_go_where_no_point_is() {
    for seed in [2, 49] {
        let case = case(seed);
        let fitted = CloudFit::new(&case.start).fair(DerivativeEnergy(2)).to(&case.points).unwrap();
        let (off, folded) = apart(fitted.shape(), &case.truth);
        let off = off / case.sigma;
        println!("{seed} {}: off {off:.3} of the noise, folded {folded:.4}, {}", case.kind, fitted.report());
        assert!(folded == 0.0 && off < 1.5, "{seed} {}: {off} {folded}", case.kind);
    }
}

/// Closed cages that folded while nothing held them from sliding along themselves (each of these, 11 of the first 50) do not, and come nearer to what
/// was measured.
#[test]
fn noise_does_not_fold_closed_cages() {
    let (seeds, mut folds, mut told, mut sum) = ([9, 25, 26, 28, 31, 41, 44, 46, 50, 52, 54], 0, 0, 0.0);
    for seed in seeds {
        let case = case(seed);
        let fitted = CloudFit::new(&case.start).fair(DerivativeEnergy(2)).to(&case.points).unwrap();
        let (off, folded) = apart(fitted.shape(), &case.truth);
        let (off, turned) = (off / case.sigma, fitted.report().turned);
        println!("{seed} {}: off {off:.3} of the noise, folded {folded:.4}, told {turned:?}", case.kind);
        (folds, told, sum) =
            (folds + usize::from(folded > 0.0), told + usize::from(turned.share > 0.0), sum + off);
        assert!(off < 1.5, "{seed} {}: {off}", case.kind);
    }
    assert!(folds <= 1 && told <= 1, "{folds} folded, {told} told");
    assert!(sum < 0.8 * seeds.len() as f64, "{sum}");
}

/// With next to no energy cages fold: which ones is told, as the truth has it, but for folds that are hardly there.
#[test]
fn folds_are_told() {
    let (mut folded, mut plain, mut missed, mut wrong) = (0, 0, 0, 0);
    for seed in (0..64).filter(|seed| KINDS[*seed as usize % KINDS.len()] != "sheet") {
        let case = case(seed);
        let fit = CloudFit::new(&case.start).energy(1e-9, DerivativeEnergy(2)).iterations(12);
        // Some have more vertices than so little energy determines.
        let Ok(fitted) = fit.to(&case.points) else { continue };
        let (turned, truth) = (fitted.report().turned, apart(fitted.shape(), &case.truth).1);
        println!("{seed} {}: {truth:.4} turned, told {turned:?}", case.kind);
        assert_eq!(turned.share > 0.0, turned.faces > 0 && turned.at.is_some());
        (folded, plain) = (folded + usize::from(truth > 0.01), plain + usize::from(truth == 0.0));
        missed += usize::from(truth > 0.01 && turned.share == 0.0);
        wrong += usize::from(truth == 0.0 && turned.share > 0.01);
    }
    println!("{folded} folded, {missed} of them not told; {plain} not, {wrong} of them told");
    assert!(folded >= 8 && plain >= 8, "{folded} {plain}");
    assert_eq!((missed, wrong), (0, 0));
}
