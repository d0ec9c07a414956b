//! Shapes of any kind brought near to clouds.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_fitting::{CloudFit, DerivativeEnergy, FitError};
use loftsman_kernel::edit::Ask;
use loftsman_kernel::functional::{linear, position};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::catmull_clark::refine;
use loftsman_subdivision::doo_sabin::DooSabinSurface;
use loftsman_subdivision::{Cage, SubdivisionSurface};

/// A number in `[-1, 1]` that looks random and is always the same.
fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(0x9E37_79B9_7F4A_7C15).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 29;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^= x >> 32;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn stirred<S: Shape + Clone>(shape: &S, by: f64) -> S {
    let mut other = shape.clone();
    for (k, p) in other.control_vertices_mut().iter_mut().enumerate() {
        (0..3).for_each(|axis| p[axis] += by * noise((3 * k + axis) as u64 + 77));
    }
    other
}

fn scaled<S: Shape + Clone>(shape: &S, by: f64, to: Vector) -> S {
    let mut other = shape.clone();
    other.control_vertices_mut().iter_mut().for_each(|p| *p = Point::from(p.coords * by + to));
    other
}

fn cube() -> Cage {
    let at = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Cage::new((0..8).map(at).collect(), &faces).unwrap()
}

/// A curved sheet with a vertex of valence 3 and one of valence 5 inside, a crease, a semi-sharp edge, a dart and corners.
fn sheet() -> Cage {
    let (rows, columns) = (5, 6);
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let at = |a: usize, b: usize| (i + a) * columns + j + b;
            let quad = vec![at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            // Two triangles in the middle: valences beside 4, and faces that are no quads.
            if (i, j) == (1, 2) {
                faces.push(vec![quad[0], quad[1], quad[2]]);
                faces.push(vec![quad[0], quad[2], quad[3]]);
            } else {
                faces.push(quad);
            }
        }
    }
    let point = |k: usize| {
        let (x, y) = ((k / columns) as f64, (k % columns) as f64);
        Point::new(x, y, (0.8 * x).sin() * (0.7 * y).cos() + 0.1 * noise(k as u64))
    };
    let cage = Cage::new((0..rows * columns).map(point).collect(), &faces).unwrap();
    let cage = cage.with_crease(13, 19, 10.0).unwrap().with_crease(19, 25, 10.0).unwrap();
    cage.with_crease(9, 10, 1.5).unwrap()
}

/// Points of every face, `each²` a face, at places that look random.
fn of_faces(shape: &dyn Shape, each: usize) -> Vec<Point> {
    let count = shape.faces().unwrap();
    let mut points = Vec::new();
    for face in 0..count {
        for k in 0..each * each {
            let jitter = |salt: usize| 0.5 + 0.5 * noise(((face * each * each + k) * 2 + salt) as u64);
            let (i, j) = ((k / each) as f64, (k % each) as f64);
            let place = |at: f64, salt: usize| ((at + jitter(salt)) / each as f64).clamp(0.0, 1.0);
            let at = Location::Face(face as u32, place(i, 0), place(j, 1));
            points.push(Point::from(shape.value(at, Derivative::POSITION).unwrap()));
        }
    }
    points
}

#[test]
fn points_of_a_limit_are_met_to_rounding_from_a_cage_that_is_disturbed() {
    let closed = refine(&cube()).unwrap();
    for (name, cage, by) in [("finer cube", closed, 0.03), ("sheet", sheet(), 0.08)] {
        let known = SubdivisionSurface::new(cage).unwrap();
        let points = of_faces(&known, 9);
        let fitted = CloudFit::new(&stirred(&known, by)).tolerance(1e-13).to(&points).unwrap();
        let report = fitted.report();
        println!("{name}: {report}");
        assert!(report.converged && report.largest < 1e-12, "{name}: {report}");
        assert!(report.before > 0.01 * by, "{name}: {report}");
        let cage = known.control_vertices().iter().zip(fitted.shape().control_vertices());
        let off = cage.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{name}: vertices off {off:.1e}");
        assert!(off < 1e-9, "{name}: {off:e}");
    }
}

/// The same of Doo and Sabin's surfaces, closed, and with the boundary, the triangles and the vertices of other than four edges of the sheet.
#[test]
fn points_of_a_doo_sabin_surface_are_met_to_rounding() {
    let smooth = sheet();
    let faces: Vec<Vec<u32>> =
        (0..smooth.topology().face_count()).map(|f| smooth.topology().face(f).to_vec()).collect();
    let faces: Vec<Vec<usize>> = faces.iter().map(|f| f.iter().map(|v| *v as usize).collect()).collect();
    let smooth = Cage::new(smooth.points().to_vec(), &faces).unwrap();
    for (name, cage, by) in
        [("cube", cube(), 0.03), ("finer cube", refine(&cube()).unwrap(), 0.03), ("sheet", smooth, 0.06)]
    {
        let known = DooSabinSurface::new(cage).unwrap();
        let points = of_faces(&known, 7);
        let fitted = CloudFit::new(&stirred(&known, by)).tolerance(1e-13).to(&points).unwrap();
        let report = fitted.report();
        assert!(report.converged && report.largest < 1e-11, "{name}: {report}");
        assert!(report.before > 0.01 * by, "{name}: {report}");
        let cage = known.control_vertices().iter().zip(fitted.shape().control_vertices());
        let off = cage.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(off < 1e-8, "{name}: {off:e}");
    }
}

/// The limit of a cube's cage does not see one motion: its vertices in and out by turns come to nothing in the first refinement. So
/// no points determine it, and it is a vertex that has to be held.
#[test]
fn a_motion_that_the_limit_does_not_see_is_named() {
    let known = SubdivisionSurface::new(cube()).unwrap();
    let points = of_faces(&known, 8);
    let start = stirred(&known, 0.1);
    let error = CloudFit::new(&start).to(&points).unwrap_err();
    assert!(matches!(error, FitError::Undetermined { rank: 7, vertices: 8, .. }), "{error}");
    let fitted = CloudFit::new(&start).lock([0]).tolerance(1e-13).to(&points).unwrap();
    println!("{}", fitted.report());
    assert!(fitted.report().converged && fitted.report().largest < 1e-12);
    let ways: Vec<Vector> =
        fitted.shape().control_vertices().iter().zip(known.control_vertices()).map(|(a, b)| a - b).collect();
    for (k, way) in ways.iter().enumerate() {
        let sign = if (k.count_ones() & 1) == 1 { -1.0 } else { 1.0 };
        assert!((way - ways[0] * sign).norm() < 1e-9, "{k}: {way} {}", ways[0]);
    }
}

#[test]
fn sizes_and_places_do_not_matter() {
    let known = SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap();
    let start = stirred(&known, 0.03);
    let points = of_faces(&known, 5);
    let plain = CloudFit::new(&start).to(&points).unwrap();
    for (size, to) in [
        (1e-9, Vector::zeros()),
        (1e9, Vector::zeros()),
        (1e-60, Vector::zeros()),
        (1e60, Vector::zeros()),
        (1.0, Vector::new(1e3, -1e3, 1e3)),
    ] {
        let moved: Vec<Point> = points.iter().map(|p| Point::from(p.coords * size + to)).collect();
        let fitted = CloudFit::new(&scaled(&start, size, to)).to(&moved).unwrap();
        let report = fitted.report();
        println!("{size:e}: {report}");
        let reach = size + to.amax();
        assert!(report.converged && report.largest < 1e-12 * reach, "{size:e}: {report}");
        for (a, b) in plain.shape().control_vertices().iter().zip(fitted.shape().control_vertices()) {
            assert!((a.coords * size + to - b.coords).norm() < 1e-8 * reach, "{size:e}: {a} {b}");
        }
    }
}

#[test]
fn noise_is_averaged_and_an_energy_takes_more_of_it() {
    let known = SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap();
    let exact = of_faces(&known, 12);
    let by = 1e-3;
    let noisy = |k: usize| Vector::from_fn(|axis, _| by * noise((3 * k + axis) as u64 + 9_000_000));
    let points: Vec<Point> = exact.iter().enumerate().map(|(k, p)| p + noisy(k)).collect();
    let plain = CloudFit::new(&stirred(&known, 0.02)).to(&points).unwrap();
    let fair = CloudFit::new(&stirred(&known, 0.02)).energy(1e-6, DerivativeEnergy(2)).to(&points).unwrap();
    println!("{}\n{}", plain.report(), fair.report());
    // Of noise in one direction of variance by²/3 there is less left than came in; the surface is nearer to the truth than the points.
    let rms = plain.report().rms;
    assert!(rms > 0.4 * by && rms < 0.6 * by, "{rms:e}");
    let off = |s: &SubdivisionSurface| {
        let pairs = (0..s.faces().unwrap() as u32).map(|face| {
            let at = Location::Face(face, 0.5, 0.5);
            let way =
                s.value(at, Derivative::POSITION).unwrap() - known.value(at, Derivative::POSITION).unwrap();
            let [u, v] = [[1, 0], [0, 1]].map(|by| known.value(at, Derivative::from(by)).unwrap());
            way.dot(&u.cross(&v).normalize()).powi(2)
        });
        (pairs.sum::<f64>() / s.faces().unwrap() as f64).sqrt()
    };
    let (a, b) = (off(plain.shape()), off(fair.shape()));
    println!("off {a:.2e} plain, {b:.2e} fair");
    assert!(a < 0.25 * by, "{a:e}");
    assert!(fair.report().rms >= plain.report().rms);
    let bend = |s: &SubdivisionSurface| {
        CloudFit::new(s).energy(1.0, DerivativeEnergy(2)).iterations(0).to(&points).unwrap().report().energy
    };
    assert!(bend(fair.shape()) < bend(plain.shape()));
}

#[test]
fn what_is_asked_holds_exactly() {
    let known = SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap();
    let start = stirred(&known, 0.02);
    let points = of_faces(&known, 5);
    let wanted = Point::new(0.19, 0.21, 0.2);
    let there = |s: &SubdivisionSurface| s.value(Location::Vertex(0), Derivative::POSITION).unwrap();
    let fair = || CloudFit::new(&start).lock([5]).energy(1e-3, DerivativeEnergy(2));
    let fitted = fair().ask(position(Location::Vertex(0)).to(wanted)).to(&points).unwrap();
    println!("{}", fitted.report());
    assert!(fitted.report().converged);
    assert!((there(fitted.shape()) - wanted.coords).norm() < 1e-13);
    assert_eq!(fitted.shape().control_vertices()[5], start.control_vertices()[5]);
    assert_eq!((fitted.report().equations, fitted.report().rank), (3, 3));

    // Multipliers are how what is least changes with the value.
    let least = |x: f64| {
        let wanted = Point::new(wanted.x + x, wanted.y, wanted.z);
        let fitted = fair().ask(position(Location::Vertex(0)).to(wanted)).to(&points).unwrap();
        fitted.report().rms.powi(2) + fitted.report().energy
    };
    let slope = (least(1e-4) - least(-1e-4)) / 2e-4;
    let multiplier = fitted.report().constraints[0].multipliers[0];
    println!("slope {slope:e}, multiplier {multiplier:e}");
    assert!((slope / multiplier - 1.0).abs() < 1e-3, "{slope:e} {multiplier:e}");

    // One that couples the axes.
    let terms = [(3_i64, Vector::new(1.0, 1.0, 0.0)), (7, Vector::new(0.0, -1.0, 2.0))];
    let sum = |s: &SubdivisionSurface| {
        terms.iter().map(|(v, a)| a.dot(&s.control_vertices()[*v as usize].coords)).sum::<f64>()
    };
    let fitted = fair().ask(linear(terms.to_vec()).to(1.25)).to(&points).unwrap();
    println!("{}", fitted.report());
    assert!(fitted.report().converged && (sum(fitted.shape()) - 1.25).abs() < 1e-13);

    let conflict = CloudFit::new(&start)
        .ask(position(Location::Vertex(0)).to(wanted))
        .ask(position(Location::Vertex(0)).to([0.0, 0.0, 0.0]))
        .to(&points)
        .unwrap_err()
        .to_string();
    assert!(conflict.contains("vertex 0"), "{conflict}");
}

#[test]
fn what_points_leave_open_is_named_and_an_energy_closes_it() {
    let known = SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap();
    let all = of_faces(&known, 4);
    let few: Vec<Point> = all[..20].to_vec();
    let error = CloudFit::new(&known).to(&few).unwrap_err();
    let FitError::Undetermined { rank, vertices, .. } = error else { panic!("{error}") };
    assert!(vertices == 26 && rank < 20, "{error}");
    assert!(error.to_string().contains(&format!("determine {rank} of 26")), "{error}");
    // As few, but all round.
    let few: Vec<Point> = all.iter().step_by(17).copied().collect();
    assert!(matches!(CloudFit::new(&known).to(&few), Err(FitError::Undetermined { vertices: 26, .. })));
    let fair = CloudFit::new(&known).energy(1e-3, DerivativeEnergy(2)).to(&few).unwrap();
    println!("{}", fair.report());
    assert!(fair.report().converged);
    // So do constraints on what no point sees: a plane patch of one face, all of it asked.
    let linear = || Space::clamped_uniform(1, 2).unwrap();
    let net = (0..4).map(|k| Point::new(f64::from(k / 2), f64::from(k % 2), 0.0)).collect();
    let plane = Surface::new(linear(), linear(), net).unwrap();
    let line: Vec<Point> = (0..9).map(|k| Point::new(f64::from(k) / 8.0, 0.0, 0.1)).collect();
    let error = CloudFit::new(&plane).to(&line).unwrap_err();
    assert!(matches!(error, FitError::Undetermined { rank: 2, vertices: 4, .. }), "{error}");
    let held = CloudFit::new(&plane).ask(position([0.0, 1.0]).keep()).ask(position([1.0, 1.0]).keep());
    let held = held.to(&line).unwrap();
    assert!(held.report().largest < 1e-13 && held.report().converged, "{}", held.report());
}

#[test]
fn bad_points_weights_and_constraints_are_refused() {
    let known = SubdivisionSurface::new(cube()).unwrap();
    let mut points = of_faces(&known, 4);
    let fit = CloudFit::new(&known);
    assert!(fit.to(&[]).unwrap_err().to_string().contains("no points"));
    points[7].y = f64::NAN;
    assert!(matches!(fit.to(&points), Err(FitError::PointNotFinite { index: 7, .. })));
    points[7].y = 1e200;
    assert!(fit.to(&points).unwrap_err().to_string().contains("point 7"));
    points[7].y = 0.5;
    let weighed = |weights| CloudFit::new(&known).weights(weights).to(&points).unwrap_err();
    let error = weighed(vec![1.0; 3]);
    assert!(matches!(error, FitError::Weights { found: 3, points: 96 }), "{error}");
    assert!(error.to_string().starts_with("3 weights for 96 points"), "{error}");
    let error = weighed(vec![-1.0; 96]);
    assert!(matches!(error, FitError::Weight { index: 0, .. }), "{error}");
    let energy = CloudFit::new(&known).energy(-1.0, DerivativeEnergy(2)).to(&points).unwrap_err();
    assert!(energy.to_string().contains("\"bend\" is -1"), "{energy}");
    let energy = CloudFit::new(&known).energy(1.0, DerivativeEnergy(4)).to(&points).unwrap_err();
    assert!(energy.to_string().contains("order 4"), "{energy}");
    assert!(CloudFit::new(&known).lock([8]).to(&points).is_err());
    let mut wild = known.clone();
    wild.control_vertices_mut()[3].x = f64::INFINITY;
    assert!(CloudFit::new(&wild).to(&points).is_err());
}

#[test]
fn curves_and_surfaces_are_fitted_alike() {
    let curve = Curve::new(
        Space::clamped_uniform(3, 12).unwrap(),
        (0..12)
            .map(|k| Point::new(f64::from(k), (0.9 * f64::from(k)).sin(), 0.3 * noise(k as u64)))
            .collect(),
    )
    .unwrap();
    let points: Vec<Point> = (0..300).map(|k| curve.point(9.0 * f64::from(k) / 299.0).unwrap()).collect();
    let fitted = CloudFit::new(&stirred(&curve, 0.1)).tolerance(1e-13).to(&points).unwrap();
    println!("curve {}", fitted.report());
    assert!(fitted.report().converged && fitted.report().largest < 1e-12);

    let ring = |k: i32| f64::from(k) * std::f64::consts::TAU / 8.0;
    let periodic = Curve::new(
        Space::periodic_uniform(3, 8).unwrap(),
        (0..8).map(|k| Point::new(ring(k).cos(), ring(k).sin(), 0.2 * noise(k as u64))).collect(),
    )
    .unwrap();
    let (start, end) = periodic.domain();
    let points: Vec<Point> =
        (0..200).map(|k| periodic.point(start + (end - start) * f64::from(k) / 200.0).unwrap()).collect();
    let fitted = CloudFit::new(&stirred(&periodic, 0.1)).tolerance(1e-13).to(&points).unwrap();
    println!("periodic {}", fitted.report());
    assert!(fitted.report().converged && fitted.report().largest < 1e-12);

    // A torus, so that nothing depends on where a border is.
    let round = |k: i32, n: i32| f64::from(k) * std::f64::consts::TAU / f64::from(n);
    let at = |k: i32| {
        let (a, b) = (round(k / 6, 9), round(k % 6, 6));
        let r = 3.0 + (1.0 + 0.1 * noise(k as u64)) * b.cos();
        Point::new(r * a.cos(), r * a.sin(), b.sin())
    };
    let (u, v) = (Space::periodic_uniform(2, 9).unwrap(), Space::periodic_uniform(3, 6).unwrap());
    let surface = Surface::new(u, v, (0..54).map(at).collect()).unwrap();
    let (a, b) = (surface.u().domain(), surface.v().domain());
    let share = |(start, end): (f64, f64), k: i32| start + (end - start) * f64::from(k) / 40.0;
    let points: Vec<Point> =
        (0..1600).map(|k| surface.point(share(a, k / 40), share(b, k % 40)).unwrap()).collect();
    let fitted = CloudFit::new(&stirred(&surface, 0.05)).tolerance(1e-13).to(&points).unwrap();
    println!("torus {}", fitted.report());
    assert!(fitted.report().converged && fitted.report().largest < 1e-12);
}

/// Against the kernel's branch and bound, which has proofs.
#[test]
fn feet_are_the_nearest_points_of_all() {
    let net =
        (0..42).map(|k| Point::new(f64::from(k / 6), f64::from(k % 6), 2.0 * noise(k as u64))).collect();
    let (u, v) = (Space::clamped_uniform(3, 7).unwrap(), Space::clamped_uniform(3, 6).unwrap());
    let surface = Surface::new(u, v, net).unwrap();
    let somewhere = |k: u64| {
        let at = |salt: u64| 0.5 + 0.5 * noise(5 * k + salt);
        Point::new(9.0 * at(0) - 1.5, 8.0 * at(1) - 1.5, 6.0 * at(2) - 3.0)
    };
    let points: Vec<Point> = (0..400).map(somewhere).collect();
    let fit = CloudFit::new(&surface).iterations(0).to(&points).unwrap();
    for (k, (point, at)) in points.iter().zip(fit.feet()).enumerate() {
        let closest = surface.closest(*point).unwrap();
        let own = (surface.value(*at, Derivative::POSITION).unwrap() - point.coords).norm();
        assert!((own - closest.distance).abs() < 1e-9 * (1.0 + own), "{k}: {own} at {at}, {closest:?}");
    }
}

/// Normals of a closed surface round the origin that point inwards: folds.
fn folds(surface: &SubdivisionSurface) -> usize {
    let mut count = 0;
    for face in 0..surface.faces().unwrap() as u32 {
        for k in 0..64 {
            let (u, v) = (f64::from(k / 8) / 7.0 * 0.98 + 0.01, f64::from(k % 8) / 7.0 * 0.98 + 0.01);
            let by = |u0: usize, v0: usize| {
                surface.value(Location::Face(face, u, v), Derivative { u: u0, v: v0 }).unwrap()
            };
            count += usize::from(by(1, 0).cross(&by(0, 1)).dot(&by(0, 0)) <= 0.0);
        }
    }
    count
}

/// The root of the mean of the squared distances of one surface's points from another.
fn apart(from: &SubdivisionSurface, to: &SubdivisionSurface) -> f64 {
    CloudFit::new(to).iterations(0).to(&of_faces(from, 5)).unwrap().report().rms
}

/// A scan with noise, by a cage that is nearly as fine as it: without an energy it follows the noise and folds, with the weight that
/// follows from the noise it is nearer to what was scanned than the scan is.
#[test]
fn the_noise_says_how_fair_a_scan_is_fitted() {
    let (size, noisy) = (1.0, 0.03);
    let centred =
        scaled(&SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap(), 1.0, Vector::repeat(-0.5));
    let truth = SubdivisionSurface::new(refine(centred.cage()).unwrap()).unwrap();
    let truth = scaled(&truth, size, Vector::zeros());
    let mut points = of_faces(&truth, 2);
    for (k, p) in points.iter_mut().enumerate() {
        (0..3).for_each(|axis| p[axis] += size * noisy * noise((3 * k + axis) as u64 + 4242));
    }
    let start = stirred(&truth, 0.01 * size);
    let plain = CloudFit::new(&start).energy(1e-9, DerivativeEnergy(2)).iterations(30).to(&points).unwrap();
    let fair = CloudFit::new(&start).fair(DerivativeEnergy(2)).to(&points).unwrap();
    let off = [plain.shape(), fair.shape()].map(|shape| apart(&truth, shape) / size);
    println!(
        "{size:e}, {noisy}: {}\n  {} \n  off {off:?}, folds {} {}",
        plain.report(),
        fair.report(),
        folds(plain.shape()),
        folds(fair.shape())
    );
    assert!(folds(plain.shape()) > 100 && folds(fair.shape()) == 0, "{size:e} {noisy}");
    // Noise between -a and a is a/√3 along each axis.
    assert!(off[1] < 0.65 * noisy / 3.0_f64.sqrt(), "{off:?}");
    let weight = fair.report().fair.unwrap();
    let again = CloudFit::new(fair.shape()).energy(weight, DerivativeEnergy(2)).steady().to(&points).unwrap();
    assert!((again.report().rms / fair.report().rms - 1.0).abs() < 1e-2, "{}", again.report());
}

/// Without noise there is no energy to speak of: the points are met.
#[test]
fn without_noise_an_automatic_energy_goes_away() {
    let known = SubdivisionSurface::new(refine(&cube()).unwrap()).unwrap();
    let points = of_faces(&known, 9);
    let fitted = CloudFit::new(&stirred(&known, 0.03)).fair(DerivativeEnergy(2)).to(&points).unwrap();
    println!("{}", fitted.report());
    assert!(fitted.report().largest < 1e-8 && fitted.report().converged, "{}", fitted.report());
    assert!(fitted.report().fair.unwrap() < 1e-12);
}

/// A cage whose limit the points are exactly is found, though a large weight to begin with leads elsewhere.
#[test]
fn points_that_can_be_met_are_met() {
    let start: [[f64; 3]; 10] = [
        [1.097238, -0.018220, -0.034565],
        [0.698351, 0.985106, 0.323997],
        [-0.078724, 0.861063, 0.403883],
        [-0.854068, 0.621096, 0.005487],
        [-0.927513, 0.154355, 0.058647],
        [-0.837964, -0.631149, 0.037488],
        [0.281538, -1.002250, -0.200546],
        [0.550354, -0.489584, -0.081020],
        [-0.315670, -0.087105, 1.000002],
        [0.178325, -0.152170, -0.899998],
    ];
    let known: [[f64; 3]; 10] = [
        [1.137003, -0.053189, -0.043944],
        [0.786824, 1.071130, 0.366773],
        [-0.062127, 0.917979, 0.396849],
        [-0.858823, 0.578078, 0.005765],
        [-0.931614, 0.293037, 0.049004],
        [-0.774423, -0.565125, 0.028164],
        [0.340008, -1.111091, -0.195800],
        [0.593217, -0.609477, -0.138978],
        [-0.262866, -0.099955, 0.945092],
        [0.159645, -0.179300, -0.863775],
    ];
    let faces: [[usize; 3]; 14] = [
        [0, 1, 8],
        [1, 2, 8],
        [2, 3, 8],
        [3, 4, 8],
        [4, 5, 8],
        [5, 6, 8],
        [7, 0, 8],
        [1, 0, 9],
        [2, 1, 9],
        [3, 2, 9],
        [4, 3, 9],
        [6, 5, 9],
        [7, 6, 9],
        [0, 7, 9],
    ];
    let shape = |points: &[[f64; 3]]| {
        let cage = Cage::new(points.iter().map(|p| Point::from(Vector::from(*p))).collect(), &faces).unwrap();
        SubdivisionSurface::new(cage).unwrap()
    };
    let points = of_faces(&shape(&known), 4);
    let fitted = CloudFit::new(&shape(&start)).fair(DerivativeEnergy(2)).to(&points).unwrap();
    println!("{}", fitted.report());
    assert!(fitted.report().largest < 1e-8 && fitted.report().converged, "{}", fitted.report());
}
