//! Faces that meet themselves along a seam and have other edges: what they are in the parameters of their surfaces, as the schema counts these.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Frame, Parts, SurfaceForm, Use, Vertex};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;

const RADIUS: f64 = 2.0;
/// How far out the plane is in which the hole's border lies.
const OUT: f64 = 1.5;

fn frame() -> Frame {
    Frame::new(Point::new(1.0, -2.0, 0.5), Vector::new(0.3, 0.2, 1.0), Vector::new(1.0, 0.1, -0.4)).unwrap()
}

/// An arc about a point, from an angle on.
fn arc(center: Point, [x, y]: [Vector; 2], [from, by]: [f64; 2], ends: [usize; 2], spline: bool) -> Edge {
    let curve = Curve::elliptic_arc(center, x, y, from, by).unwrap();
    let radius = x.norm();
    let form = CurveForm::Circle { frame: Frame::new(center, x.cross(&y), x).unwrap(), radius };
    let form = if spline { CurveForm::Spline } else { form };
    Edge { range: curve.domain(), curve, ends, tolerance: 1e-7, form }
}

/// A ball without what a plane across its `x` cuts off, which is over its seam: of two meridians and the two halves of a circle. `splines` says whether edges are but
/// splines, `backwards` which edges run the other way, and `start` with which of the six uses the loop starts.
fn bitten(splines: bool, backwards: [bool; 4], start: usize) -> Brep {
    let frame = frame();
    let (o, x, y, z) = (frame.origin, frame.x, frame.y(), frame.z);
    let half = (RADIUS * RADIUS - OUT * OUT).sqrt();
    let latitude = half.atan2(OUT);
    let at = |v: f64| o + (x * v.cos() + z * v.sin()) * RADIUS;
    let vertices = [at(-FRAC_PI_2), at(-latitude), at(latitude), at(FRAC_PI_2)];
    let (meridian, rim) = ([x * RADIUS, z * RADIUS], o + x * OUT);
    let mut edges = vec![
        arc(o, meridian, [-FRAC_PI_2, FRAC_PI_2 - latitude], [0, 1], splines),
        arc(o, meridian, [latitude, FRAC_PI_2 - latitude], [2, 3], splines),
        // From the lower to the upper vertex, where `y` is less, and where it is more.
        arc(rim, [-z * half, -y * half], [0.0, TAU / 2.0], [1, 2], splines),
        arc(rim, [-z * half, y * half], [0.0, TAU / 2.0], [1, 2], splines),
    ];
    let mut uses: Vec<Use> = [(0, false), (2, false), (1, false), (1, true), (3, true), (0, true)]
        .map(|(edge, reversed)| Use { edge, reversed, parameters: None })
        .into();
    uses.rotate_left(start);
    for (number, edge) in edges.iter_mut().enumerate().filter(|(number, _)| backwards[*number]) {
        edge.curve = edge.curve.reverse().unwrap();
        edge.ends.reverse();
        if let CurveForm::Circle { frame, .. } = &mut edge.form {
            frame.z = -frame.z;
        }
        uses.iter_mut().filter(|one| one.edge == number).for_each(|one| one.reversed = !one.reversed);
    }
    let form = SurfaceForm::Sphere { frame, radius: RADIUS };
    Brep::new(Parts {
        vertices: vertices.map(|point| Vertex { point, tolerance: 1e-7 }).into(),
        edges,
        faces: vec![Face {
            name: None,
            color: None,
            surface: form.covering(&vertices).unwrap(),
            form,
            reversed: false,
            loops: vec![uses],
            points: Vec::new(),
        }],
        ..Parts::default()
    })
    .unwrap()
}

fn written(brep: &Brep) -> String {
    let mut scene = Scene::new();
    scene.add(Object::new("it", Geometry::Brep(brep.clone()))).unwrap();
    let mut memory = Memory::new("t.step", Vec::new());
    Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap();
    String::from_utf8(memory.bytes).unwrap()
}

/// The entities of a file by their numbers.
fn entities(text: &str) -> HashMap<u64, &str> {
    let entity = |line: &'_ str| -> Option<(u64, usize)> {
        let (number, rest) = line.strip_prefix('#')?.split_once('=')?;
        Some((number.parse().ok()?, line.len() - rest.len()))
    };
    text.lines().filter_map(|line| entity(line).map(|(number, from)| (number, &line[from..]))).collect()
}

fn references(entity: &str) -> Vec<u64> {
    let all = entity.split('#').skip(1);
    all.map(|rest| rest.chars().take_while(char::is_ascii_digit).collect::<String>().parse().unwrap())
        .collect()
}

/// The numbers in the brackets of a list, behind what comes before it.
fn numbers(list: &str) -> Vec<f64> {
    list.trim_matches(['(', ')', ';']).split(',').map(|number| number.parse().unwrap()).collect()
}

/// A curve of two coordinates as it stands in a file.
fn planar(all: &HashMap<u64, &str>, number: u64) -> Curve {
    let entity = all[&number];
    assert!(entity.starts_with("B_SPLINE_CURVE_WITH_KNOTS("), "{entity}");
    let points = references(entity).into_iter().map(|point| {
        let at = numbers(all[&point].strip_prefix("CARTESIAN_POINT('',").unwrap());
        Point::new(at[0], at[1], 0.0)
    });
    let degree: usize = entity.split(',').nth(1).unwrap().parse().unwrap();
    let lists = entity.split_once(".U.,").unwrap().1;
    let (counts, rest) = lists.split_once("),(").unwrap();
    let (counts, knots) = (numbers(counts), numbers(rest.split_once(')').unwrap().0));
    let knots = counts.iter().zip(&knots).flat_map(|(count, knot)| vec![*knot; *count as usize]).collect();
    let space = loftsman_kernel::spline::Space::open(degree, knots).unwrap();
    Curve::new(space, points.collect()).unwrap()
}

/// All ways in which the face may be given: each use of an edge is in the file along the way that the loop goes, from where the one before it ended, and beside the seam on its own
/// side; the later use of a seam runs along its curve. The loop starts with a seam.
#[test]
fn edges_beside_a_seam_are_said_in_parameters_without_a_jump() {
    let form = SurfaceForm::Sphere { frame: frame(), radius: RADIUS };
    let SurfaceForm::Sphere { frame, .. } = form else { return };
    for start in 0..6 {
        for choice in 0..32_u32 {
            let case = format!("start {start}, choice {choice}");
            let backwards = [0, 1, 2, 3].map(|k| choice >> k & 1 == 1);
            let brep = bitten(choice >> 4 & 1 == 1, backwards, start);
            let text = written(&brep);
            let all = entities(&text);
            let face = all.values().find(|entity| entity.starts_with("ADVANCED_FACE")).unwrap();
            let (chain, surface) = (all[&references(face)[0]], *references(face).last().unwrap());
            let mut seen: HashMap<u64, usize> = HashMap::new();
            let mut runs: Vec<[Point; 2]> = Vec::new();
            for one in references(all[&references(chain)[0]]) {
                let edge = references(all[&one])[0];
                let parts = references(all[&edge]);
                // Along the curve in space, and whether the edge is.
                let along = all[&one].ends_with(".T.);") == all[&edge].ends_with(".T.);");
                let curve = all[&parts[2]];
                let curves = references(curve);
                let is_seam = curve.starts_with("SEAM_CURVE(");
                assert_eq!(curves.len(), if is_seam { 3 } else { 2 }, "{case}: {curve}");
                assert!(is_seam || !runs.is_empty(), "{case}: it starts beside the seam");
                let before = *seen.entry(edge).and_modify(|count| *count += 1).or_insert(1);
                assert!(!is_seam || before == 1 || along, "{case}: the later use runs against the curve");
                // Of a seam the first is that of the use along the edge.
                let forwards = all[&one].ends_with(".T.);");
                let pcurve = all[&curves[if is_seam && !forwards { 2 } else { 1 }]];
                let item = references(pcurve);
                assert_eq!(item[0], surface, "{case}");
                let curve = planar(&all, references(all[&item[1]])[0]);
                let (a, b) = curve.domain();
                for k in 0..=40 {
                    let p = curve.point((a + (b - a) * f64::from(k) / 40.0).min(b)).unwrap();
                    assert!((-1e-9..TAU + 1e-9).contains(&p.x), "{case}: {p}");
                    let across = frame.x * p.x.cos() + frame.y() * p.x.sin();
                    let on = frame.origin + (across * p.y.cos() + frame.z * p.y.sin()) * RADIUS;
                    let number = (0..brep.edge_count())
                        .map(|edge| brep.curve(edge).unwrap().closest(on).unwrap().distance);
                    assert!(number.fold(f64::INFINITY, f64::min) < 1e-8, "{case}: {p} is on no edge");
                }
                let ends = [curve.point(a).unwrap(), curve.point(b).unwrap()];
                if is_seam {
                    // To the bit, one on each side.
                    assert!(
                        ends.iter().all(|p| p.x == 0.0) || ends.iter().all(|p| p.x == TAU),
                        "{case}: {ends:?}"
                    );
                }
                runs.push(if along { ends } else { [ends[1], ends[0]] });
            }
            let next = runs.iter().skip(1).chain(runs.first());
            let mut leaps = 0;
            for ([_, end], [start, _]) in runs.iter().zip(next) {
                let apart = (end - start).norm();
                let pole = (end.y.abs() - FRAC_PI_2).abs() < 1e-9 && (end.y - start.y).abs() < 1e-9;
                leaps += usize::from(pole);
                assert!(apart < 1e-7 || (pole && (apart - TAU).abs() < 1e-7), "{case}: {end}, {start}");
            }
            assert_eq!(leaps, 2, "{case}");
            // Read again it is the same part of the same surface.
            let (again, _) =
                Step.read(&Memory::new("t.step", text.as_bytes()), &ReadOptions::default()).unwrap();
            let Geometry::Brep(again) = again.objects()[0].geometry() else { panic!("{case}") };
            let part = again.part(0).unwrap();
            let at = |u: f64| frame.origin + (frame.x * u.cos() + frame.y() * u.sin()) * RADIUS;
            for u in [1.0, 3.0, 5.0] {
                assert!(part.closest(at(u)).unwrap().distance < 1e-9, "{case}: {u} is in it");
            }
            assert!(part.closest(at(0.01)).unwrap().distance > 0.5, "{case}: the hole is none of it");
        }
    }
}

/// A cylinder between two circles, as most are, is read as it is: it stays short. Cut askew it is said.
#[test]
fn plain_faces_stay_short() {
    let cylinder = |askew: f64| {
        let frame = frame();
        let (o, x, y, z) = (frame.origin, frame.x, frame.y(), frame.z);
        let ring = |height: f64, lean: f64, vertex: usize| {
            let (center, across) = (o + z * height, x + z * lean);
            let curve = Curve::ellipse(center, across, y).unwrap();
            let flat = Frame::new(center, across.cross(&y), across).unwrap();
            let form = if lean == 0.0 {
                CurveForm::Circle { frame: flat, radius: 1.0 }
            } else {
                CurveForm::Ellipse { frame: flat, radii: [across.norm(), 1.0] }
            };
            Edge { range: curve.domain(), curve, ends: [vertex; 2], tolerance: 1e-7, form }
        };
        let ends = [o + x, o + x + z * (3.0 + askew)];
        let seam = Curve::line(ends[0], ends[1]).unwrap();
        let seam =
            Edge { range: seam.domain(), curve: seam, ends: [0, 1], tolerance: 1e-7, form: CurveForm::Line };
        let form = SurfaceForm::Cylinder { frame, radius: 1.0 };
        let uses = [(0, false), (2, false), (1, true), (2, true)];
        Brep::new(Parts {
            vertices: ends.map(|point| Vertex { point, tolerance: 1e-7 }).into(),
            edges: vec![ring(0.0, 0.0, 0), ring(3.0, askew, 1), seam],
            faces: vec![Face {
                name: None,
                color: None,
                surface: form.covering(&[o, o + z * (3.0 + askew)]).unwrap(),
                form,
                reversed: false,
                loops: vec![uses.map(|(edge, reversed)| Use { edge, reversed, parameters: None }).into()],
                points: Vec::new(),
            }],
            ..Parts::default()
        })
        .unwrap()
    };
    assert_eq!(written(&cylinder(0.0)).matches("PCURVE(").count(), 0);
    let text = written(&cylinder(0.4));
    assert_eq!((text.matches("=PCURVE(").count(), text.matches("=SEAM_CURVE(").count()), (4, 1));
}

/// A cone's tip below a plane across it: of a seam that ends at the tip but for `off`, of the seam's length, and an ellipse.
fn tip(frame: Frame, off: [f64; 3]) -> Brep {
    let (radius, angle, height, slant) = (2.0, 0.4_f64, 3.0, 0.3);
    let t = angle.tan();
    let local = |x: f64, y: f64, z: f64| frame.origin + frame.x * x + frame.y() * y + frame.z * z;
    // Where the plane `z = height + slant x` meets the cone beside `y = 0`.
    let wide = t * (height + radius / t);
    let (near, far) = (wide / (1.0 - t * slant), -wide / (1.0 + t * slant));
    let middle = 0.5 * (near + far);
    let across = (t * (height + slant * middle + radius / t)).powi(2) - middle * middle;
    let center = local(middle, 0.0, height + slant * middle);
    let long = (frame.x + frame.z * slant) * (0.5 * (near - far));
    let short = frame.y() * across.sqrt();
    let curve = Curve::elliptic_arc(center, long, short, 0.0, TAU).unwrap();
    let radii = [long.norm(), short.norm()];
    let form = CurveForm::Ellipse { frame: Frame::new(center, long.cross(&short), long).unwrap(), radii };
    let (start, end) = (curve.point(0.0).unwrap(), local(0.0, 0.0, -radius / t));
    let length = (end - start).norm();
    let end = end + (frame.x * off[0] + frame.y() * off[1] + frame.z * off[2]) * length;
    let ellipse = Edge { range: curve.domain(), curve, ends: [0, 0], tolerance: 1e-7, form };
    let seam = Curve::line(start, end).unwrap();
    let seam =
        Edge { range: seam.domain(), curve: seam, ends: [0, 1], tolerance: 1e-7, form: CurveForm::Line };
    let form = SurfaceForm::Cone { frame, radius, angle };
    let vertices = [start, end];
    let uses = [(1, true), (0, true), (1, false)];
    let parts = Parts {
        vertices: vertices.map(|point| Vertex { point, tolerance: 1e-7 }).into(),
        edges: vec![ellipse, seam],
        faces: vec![Face {
            name: None,
            color: None,
            surface: form.covering(&vertices).unwrap(),
            form,
            reversed: false,
            loops: vec![uses.map(|(edge, reversed)| Use { edge, reversed, parameters: None }).into()],
            points: Vec::new(),
        }],
        ..Parts::default()
    };
    Brep::new(parts).unwrap()
}

/// A seam runs to the tip of a cone, but for the noise of a file: its two sides are in the file, a whole turn apart; and where the tip is missed by so much that
/// they cannot be, that is told.
#[test]
fn a_seam_that_misses_the_tip_by_noise_has_two_sides() {
    let far = Frame { origin: Point::new(20_000.0, -15_000.0, 9_000.0), ..frame() };
    for frame in [frame(), far] {
        for (off, is_told) in [
            ([0.0; 3], false),
            ([0.0, 4e-7, 0.0], false),
            ([-3e-7, -2e-7, -4e-7], false),
            ([0.0, 0.0, -5e-7], false),
            ([-2e-7, 0.0, -4e-7], false),
            ([0.0, 0.01, -0.02], true),
        ] {
            let mut scene = Scene::new();
            scene.add(Object::new("it", Geometry::Brep(tip(frame, off)))).unwrap();
            let mut memory = Memory::new("t.step", Vec::new());
            let report = Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap();
            let text = String::from_utf8(memory.bytes).unwrap();
            let told = format!("{report:?}").contains("are not told in their parameters");
            assert_eq!(told, is_told, "{off:?}: {report:?}");
            let all = entities(&text);
            let Some(seam) = all.values().find(|entity| entity.starts_with("SEAM_CURVE")) else {
                assert!(is_told, "{off:?}: {text}");
                continue;
            };
            assert!(!is_told, "{off:?}: {text}");
            let sides: Vec<Curve> = references(seam)[1..]
                .iter()
                .map(|one| planar(&all, references(all[&references(all[one])[1]])[0]))
                .collect();
            let [one, other] = &sides[..] else { panic!("{seam}") };
            for (p, q) in one.points().iter().zip(other.points()) {
                assert!(
                    ((p.x - q.x).abs() - TAU).abs() < 1e-9 && (p.y - q.y).abs() < 1e-9,
                    "{off:?}: {p} {q}"
                );
            }
        }
    }
}
