//! What is known in the parameters of surfaces: curves of edges, and loops of trimmed surfaces. And meshes, which know of none.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Fate, Format, Memory, ReadOptions, ReadReport, WriteOptions, WriteReport};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;

fn data(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/../../tests/data/step/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn read(bytes: &[u8]) -> (Scene, ReadReport) {
    let (scene, report) = Step.read(&Memory::new("t.step", bytes), &ReadOptions::default()).unwrap();
    assert!(report.adds_up());
    scene.check().unwrap();
    (scene, report)
}

fn write(scene: &Scene) -> (Vec<u8>, WriteReport) {
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    (memory.bytes, report)
}

fn of(geometry: impl Into<Geometry>) -> Scene {
    let mut scene = Scene::new();
    scene.add(Object::new("it", geometry.into())).unwrap();
    scene
}

fn breps(scene: &Scene) -> Vec<&Brep> {
    let defined = scene.definitions().iter().flat_map(|d| d.objects());
    let all = scene.objects().iter().chain(defined);
    all.filter_map(|o| if let Geometry::Brep(brep) = o.geometry() { Some(brep) } else { None }).collect()
}

/// The uses of a Brep that have parameter curves, and how many there are.
fn known(brep: &Brep) -> (usize, usize) {
    let uses = (0..brep.face_count()).flat_map(|face| brep.loops(face)).flatten();
    uses.fold((0, 0), |(with, all), one| (with + usize::from(one.parameters.is_some()), all + 1))
}

/// How far the edges of a Brep are from its faces along the curves in their parameters, at most.
fn off(brep: &Brep) -> f64 {
    let curves = (0..brep.face_count()).map(|face| brep.parameter_curves(face).unwrap());
    curves.flatten().flatten().map(|one| one.error).fold(0.0, f64::max)
}

/// The Breps of a file with the curves in the parameters of all their faces, as they are computed.
fn with_parameters(name: &str) -> Scene {
    let (mut scene, _) = read(&data(name));
    let names: Vec<String> = scene.objects().iter().map(|o| o.name().to_owned()).collect();
    for name in names {
        let Geometry::Brep(brep) = scene.object(&name).unwrap().geometry() else { continue };
        let mut parts = brep.parts();
        for (face, part) in parts.faces.iter_mut().enumerate() {
            let curves = brep.parameter_curves(face).unwrap();
            for (one, curve) in part.loops.iter_mut().flatten().zip(curves.into_iter().flatten()) {
                one.parameters = Some(curve.curve);
            }
        }
        *scene.object_mut(&name).unwrap().geometry_mut() = Brep::new(parts).unwrap().into();
    }
    scene
}

/// Those that run along lines of parameters are computed anew, exactly; on planes and cylinders all of them.
#[test]
fn parameter_curves_are_written_and_taken_from_files() {
    for (name, least) in [("test_pipe.step", 2), ("NIST_MBE_PMI_1.stp", 1), ("MAINBODY_FRONT.stp", 0)] {
        let scene = with_parameters(name);
        let text = String::from_utf8(write(&scene).0).unwrap();
        assert!(text.matches("=PCURVE(").count() > least, "{name}");
        let (again, report) = read(text.as_bytes());
        let mut taken = 0;
        for (before, after) in breps(&scene).iter().zip(breps(&again)) {
            taken += known(after).0;
            let size = before.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
            assert!(
                off(after) <= 2.0 * off(before).max(1e-9 * size),
                "{name}: {} {}",
                off(before),
                off(after)
            );
            for (face, part) in after.parts().faces.iter().enumerate() {
                for (chain, uses) in part.loops.iter().enumerate() {
                    for (number, one) in uses.iter().enumerate() {
                        let own = before.loops(face)[chain][number].parameters.as_ref().unwrap();
                        let Some(found) = &one.parameters else { continue };
                        // From the edge's start to its end, as it was, whatever its pace.
                        let apart = |k: usize| {
                            let [a, b] = [own, found].map(|c| c.ends().unwrap()[k]);
                            (a[0] - b[0]).hypot(a[1] - b[1])
                        };
                        assert!(
                            apart(0).max(apart(1)) < 1e-9,
                            "{name} {face} {:?} {:?}",
                            own.ends(),
                            found.ends()
                        );
                    }
                }
            }
        }
        assert!(taken >= least, "{name}: {taken}");
        assert!(format!("{report:?}").contains("computed anew"), "{name}");
        // From there on they are what they are, to the last bit.
        assert!(read(&write(&again).0).0 == again, "{name}");
    }
    let (pipe, _) = read(&data("test_pipe.step"));
    assert_eq!(breps(&pipe).iter().map(|brep| known(brep).0).sum::<usize>(), 2);
}

/// Curves that lie elsewhere on the surface are not believed: the edges are projected instead.
#[test]
fn parameter_curves_that_are_not_their_edges_are_not_used() {
    let (scene, _) = read(&data("test_pipe.step"));
    let text = String::from_utf8(write(&scene).0).unwrap();
    // Of points of two coordinates, the first is brought nearer to the middle of all of them.
    let firsts: Vec<f64> = text
        .lines()
        .filter_map(|line| line.split_once("=CARTESIAN_POINT('',("))
        .filter(|(_, rest)| rest.matches(',').count() == 1)
        .map(|(_, rest)| rest.split(',').next().unwrap().parse().unwrap())
        .collect();
    let middle = firsts.iter().sum::<f64>() / firsts.len() as f64;
    let wrong: Vec<String> = text
        .lines()
        .map(|line| match line.split_once("=CARTESIAN_POINT('',(") {
            Some((number, rest)) if rest.matches(',').count() == 1 => {
                let (u, v) = rest.trim_end_matches("));").split_once(',').unwrap();
                let u: f64 = u.parse().unwrap();
                format!("{number}=CARTESIAN_POINT('',({:?},{v}));", middle + 0.8 * (u - middle))
            }
            _ => line.to_owned(),
        })
        .collect();
    assert!(wrong.iter().zip(text.lines()).filter(|(a, b)| *a != b).count() > 10);
    let (read_wrong, _) = read(wrong.join("\n").as_bytes());
    let mut taken = 0;
    for (good, bad) in breps(&scene).iter().zip(breps(&read_wrong)) {
        taken += known(bad).0;
        let size = good.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        assert!(off(bad) <= (2.0 * off(good)).max(1e-6 * size), "{} {}", off(good), off(bad));
    }
    assert!(taken > 0);
}

fn space(degree: usize, inner: &[f64], (from, to): (f64, f64)) -> Space {
    let mut knots = vec![from; degree + 1];
    knots.extend(inner);
    knots.extend(vec![to; degree + 1]);
    Space::open(degree, knots).unwrap()
}

fn sheet([p, q]: [usize; 2], rational: bool, scale: f64) -> Surface {
    let (u, v) = (space(p, &[0.3, 0.3], (-1.0, 2.0)), space(q, &[1.2], (1.0, 2.0)));
    let mut points = Vec::new();
    for i in 0..u.len() {
        for j in 0..v.len() {
            let (x, y) = (u.greville(i), v.greville(j));
            points.push(Point::new(x, y * 1.1, (x * y).sin() * 0.3) * scale);
        }
    }
    let weights = rational.then(|| (0..points.len()).map(|k| 1.0 + 0.2 * (k as f64).cos()).collect());
    Surface::build(u, v, points, weights).unwrap()
}

fn at(u: f64, v: f64) -> Point {
    Point::new(u, v, 0.0)
}

fn square(low: [f64; 2], high: [f64; 2]) -> Vec<ParameterCurve> {
    let corners = [at(low[0], low[1]), at(high[0], low[1]), at(high[0], high[1]), at(low[0], high[1])];
    let side =
        |k: usize| ParameterCurve::whole(Curve::line(corners[k], corners[(k + 1) % 4]).unwrap()).unwrap();
    (0..4).map(side).collect()
}

fn round(middle: Point, radius: f64) -> Vec<ParameterCurve> {
    vec![ParameterCurve::whole(Curve::circle(middle, Vector::z(), radius).unwrap()).unwrap()]
}

#[test]
fn trimmed_surfaces_come_back_to_the_last_bit() {
    for degrees in [[1, 1], [2, 3], [3, 2], [7, 4], [25, 1]] {
        for (rational, scale) in [(false, 1.0), (true, 1.0), (false, 1e-9), (true, 1e9)] {
            let hole = round(at(0.5, 1.5), 0.2);
            for region in [
                Region { outer: square([-0.9, 1.1], [1.8, 1.9]), holes: vec![] },
                Region { outer: square([-0.9, 1.1], [1.8, 1.9]), holes: vec![hole.clone()] },
                Region { outer: vec![], holes: vec![hole.clone(), square([1.0, 1.2], [1.5, 1.6])] },
                Region { outer: round(at(0.5, 1.5), 0.4), holes: vec![hole] },
            ] {
                let surface = sheet(degrees, rational, scale);
                let trimmed = Trimmed::new(surface, vec![region], vec![], vec![]).unwrap();
                let (bytes, report) = write(&of(trimmed.clone()));
                assert_eq!(report.objects[0].fate, Fate::Kept, "{report:?}");
                let (back, report) = read(&bytes);
                let Geometry::Trimmed(found) = back.objects()[0].geometry() else { panic!("{report:?}") };
                // What is read is open and clamped; circles were so before.
                assert_eq!(found.surface(), trimmed.surface(), "{degrees:?}");
                assert!(write(&back).0 == bytes, "{degrees:?} {rational} {scale}");
                let [before, after] = [&trimmed, found]
                    .map(|one| one.loops().flatten().map(|c| c.ends().unwrap()).collect::<Vec<_>>());
                assert_eq!(before, after);
            }
        }
    }
}

#[test]
fn what_of_a_trimmed_surface_is_lost_is_told() {
    let regions = vec![
        Region { outer: square([-0.9, 1.1], [0.2, 1.9]), holes: vec![] },
        Region { outer: square([0.4, 1.1], [1.8, 1.9]), holes: vec![] },
    ];
    let special = vec![square([0.0, 1.2], [0.1, 1.3])];
    let trimmed = Trimmed::new(sheet([3, 3], false, 1.0), regions, special, vec![[0.0, 1.5]]).unwrap();
    let (bytes, report) = write(&of(trimmed));
    let told = format!("{:?}", report.objects[0]);
    assert!(
        told.contains("special curves and points are left out") && told.contains("regions are objects"),
        "{told}"
    );
    assert_eq!(
        read(&bytes).0.objects().iter().filter(|o| matches!(o.geometry(), Geometry::Trimmed(_))).count(),
        2
    );
}

#[test]
fn surfaces_that_curves_bound_are_left_out_with_their_reason_where_they_are_not_read() {
    let trimmed = Trimmed::new(
        sheet([3, 3], false, 1.0),
        vec![Region { outer: square([-0.9, 1.1], [0.2, 1.9]), holes: vec![] }],
        vec![],
        vec![],
    );
    let mut scene = of(trimmed.unwrap());
    scene.add(Object::new("beside", Curve::line(at(0.0, 0.0), at(1.0, 0.0)).unwrap().into())).unwrap();
    let text = String::from_utf8(write(&scene).0).unwrap();
    for (from, to, says) in [
        ("=OUTER_BOUNDARY_CURVE(", "=OUTER_COMPOSITE_CURVE(", "is no boundary"),
        (
            "=DEFINITIONAL_REPRESENTATION('',(",
            "=DEFINITIONAL_REPRESENTATION('',(#1,",
            "only B-splines are read so",
        ),
        ("(-0.9,1.1)", "(-7.9,1.1)", "domain"),
        ("(.CONTINUOUS.,.T.,", "(.CONTINUOUS.,.F.,", "loop"),
    ] {
        assert!(text.contains(from), "{from}");
        let (scene, report) = read(text.replacen(from, to, 1).as_bytes());
        assert_eq!(scene.objects().len(), 1, "{from}");
        let told = format!("{report:?}");
        assert!(told.contains(says), "{from}: {told}");
    }
}

#[test]
fn meshes_come_back_as_triangles_with_the_same_points() {
    for scale in [1.0, 1e-9, 1e9] {
        let points: Vec<Point> = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]
            .map(|p| Point::new(p[0] / 3.0, p[1], 0.1) * scale)
            .to_vec();
        let flat = Mesh::new(points.clone(), &[[0, 1, 2, 3, 4, 5]]).unwrap();
        let (bytes, report) = write(&of(flat));
        let told = format!("{report:?}");
        assert!(told.contains("more than three corners"), "{told}");
        let (back, _) = read(&bytes);
        let Geometry::Mesh(found) = back.objects()[0].geometry() else { panic!("{back:?}") };
        assert_eq!((found.points(), found.face_count()), (&points[..], 4));
        // An L: no triangle of a fan is outside of it.
        let area: f64 = found
            .faces()
            .map(|f| {
                let [a, b, c] = [f[0], f[1], f[2]].map(|k| found.points()[k as usize]);
                (b - a).cross(&(c - a)).z / 2.0
            })
            .sum();
        assert!((area / (scale * scale) - 1.0).abs() < 1e-14, "{area}");
        // Triangles are as they were, whatever else there is.
        let block = Mesh::new(points, &[[0, 1, 2], [2, 1, 3], [3, 4, 5]]).unwrap();
        let (bytes, report) = write(&of(block.clone()));
        assert_eq!(report.objects[0].fate, Fate::Kept);
        let (back, _) = read(&bytes);
        assert_eq!(back.objects()[0].geometry(), &Geometry::from(block));
    }
    let (_, report) = write(&of(Mesh::new(vec![], &[] as &[[usize; 3]]).unwrap()));
    assert_eq!(report.objects[0].fate, Fate::LeftOut);
}
