//! What `sew` makes of faces that are not as they should be: twice there, inside out, all but what was meant, with edges as short as the tolerance.
#![allow(clippy::unwrap_used, reason = "tests may panic")]

use std::f64::consts::{PI, TAU};

use loftsman_construction::{Construction, Sewn, sew};
use loftsman_kernel::brep::{Brep, CurveForm, Edge, Face, Parts, Shell, SurfaceForm, Use, Vertex};
use loftsman_kernel::plugin::{Chord, Context, Fineness, Parameters, Registry, Tessellator};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Direction, Space, Surface, Trimmed};
use loftsman_kernel::{Point, Vector};
use loftsman_tessellation::{Adaptive, Tessellation};
use nalgebra::Matrix4;
use serde_json::{Value, json};

fn sewn(geometries: &[Geometry], near: f64) -> Sewn {
    sew(geometries, near, &Adaptive::default()).unwrap()
}

/// The volume of a fine mesh, which must be watertight.
fn volume(brep: &Brep) -> f64 {
    let fineness = Fineness { chord: Chord::Relative(1e-4), angle: 0.2 };
    let cut = Adaptive::default().measured_brep(brep, &fineness).unwrap();
    assert!(cut.left_out.is_empty(), "{:?}", cut.left_out);
    let mut edges = std::collections::BTreeMap::new();
    for corners in cut.mesh.corners().chunks(3) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
        }
    }
    assert!(edges.values().all(|count| *count == 0), "it is not watertight");
    let p = |k: u32| cut.mesh.points()[k as usize].coords;
    cut.mesh.corners().chunks(3).map(|t| p(t[0]).dot(&p(t[1]).cross(&p(t[2]))) / 6.0).sum()
}

fn flat(corners: [Point; 4]) -> Surface {
    let space = || Space::clamped(1, &[0.0, 1.0]).unwrap();
    let [a, b, c, d] = corners;
    Surface::new(space(), space(), vec![a, d, b, c]).unwrap()
}

/// The sides of a box 1 by 2 by 3 times a size, each reversed in another way.
fn sides(size: f64, at: Point, seed: usize) -> Vec<Geometry> {
    let corner =
        |k: usize| at + Vector::new((k & 1) as f64, (k >> 1 & 1) as f64 * 2.0, (k >> 2) as f64 * 3.0) * size;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (0..6)
        .map(|face| {
            let mut surface = flat(faces[face].map(corner));
            if (seed >> face) & 1 == 1 {
                surface = surface.reverse(Direction::U).unwrap();
            }
            if (seed >> (face + 3)) & 1 == 1 {
                surface = surface.reverse(Direction::V).unwrap();
            }
            surface.into()
        })
        .collect()
}

/// Two faces in one place are no body: one of them is left out, alone and as one side of a box, whichever way they run.
#[test]
fn a_face_that_is_there_twice_is_no_solid() {
    for seed in [0, 77, 300] {
        for (size, shift) in [(1.0, 0.0), (1e-3, 3e-10), (1.0, 5e-7)] {
            let faces = sides(size, Point::origin(), seed);
            let again = sides(size, Point::new(shift, -shift, shift), 511 - seed);
            for which in 0..6 {
                let made = sewn(&[faces[which].clone(), again[which].clone()], 1e-6 * size);
                assert_eq!((made.twice, made.open.len()), (1, 4), "{seed} {which}");
                assert!(made.brep.solids().is_empty() && made.brep.face_count() == 1);
                // As a side of a box that has it twice, or all of them.
                let mut more = faces.clone();
                more.push(again[which].clone());
                let made = sewn(&more, 1e-6 * size);
                assert_eq!(
                    (made.twice, made.open.len(), made.brep.solids().len()),
                    (1, 0, 1),
                    "{seed} {which}"
                );
                assert!((volume(&made.brep) / (6.0 * size.powi(3)) - 1.0).abs() < 1e-5);
            }
            let all: Vec<Geometry> = faces.iter().chain(&again).cloned().collect();
            let made = sewn(&all, 1e-6 * size);
            assert_eq!((made.twice, made.open.len(), made.brep.solids().len()), (6, 0, 1), "{seed}");
        }
    }
    // Halves of a ball have their border in common, and nothing else.
    let half = Curve::elliptic_arc(Point::origin(), Vector::z() * -2.0, Vector::x() * 2.0, 0.0, PI).unwrap();
    let turned = |from: f64| {
        let map = Matrix4::new_rotation(Vector::z() * from);
        Surface::revolution(&half, Point::origin(), Vector::z(), PI).unwrap().transformed(&map).unwrap()
    };
    let made = sewn(&[turned(0.0).into(), turned(PI).into()], 1e-6);
    assert_eq!((made.twice, made.open.len(), made.brep.solids().len()), (0, 0, 1));
    assert!((volume(&made.brep) / (4.0 / 3.0 * PI * 8.0) - 1.0).abs() < 1e-3);
}

/// A tolerance that is told as one that closes does so; edges that close by themselves have one too.
#[test]
fn the_tolerance_that_is_told_closes() {
    let up = |x: f64| x * (1.0 + 1e-3);
    for gap in [1e-2, 3.3e-4, 7.77e-5] {
        // A lid above a cup: two circles, which begin elsewhere.
        let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, 5.0)).unwrap();
        let tube = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
        let lid = |z: f64, turn: f64| -> Geometry {
            let corner = |x: f64, y: f64| Point::new(6.0 * (x - 0.5), 6.0 * (y - 0.5), z);
            let plane = flat([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
            let (x, y) =
                (Vector::new(turn.cos(), turn.sin(), 0.0), Vector::new(-turn.sin(), turn.cos(), 0.0));
            let arc = Curve::elliptic_arc(Point::new(0.5, 0.5, 0.0), x / 3.0, y / 3.0, 0.0, TAU).unwrap();
            let region = Region { outer: vec![ParameterCurve::whole(arc).unwrap()], holes: vec![] };
            Trimmed::new(plane, vec![region], vec![], vec![]).unwrap().into()
        };
        let cup = [tube.clone().into(), lid(0.0, 0.0), lid(5.0 + gap, 0.0)];
        let made = sewn(&cup, 1e-6);
        assert_eq!((made.open.len(), made.brep.solids().len()), (2, 0));
        let closes = made.closes.unwrap();
        assert!((closes / gap - 1.0).abs() < 1e-6 && made.next == made.closes, "{closes} {gap}");
        let made = sewn(&cup, up(closes));
        assert_eq!((made.open.len(), made.brep.solids().len()), (0, 1), "{gap}");
        // A box of which two sides have moved, one further: first one, then all.
        let mut faces = sides(1.0, Point::origin(), 77);
        for (face, by) in [(0, gap), (1, 3.0 * gap)] {
            let map = Matrix4::new_translation(&Vector::new(0.0, 0.0, if face == 0 { -by } else { by }));
            faces[face] = faces[face].transformed(&map).unwrap();
        }
        let made = sewn(&faces, 1e-6);
        assert!((made.next.unwrap() / gap - 1.0).abs() < 1e-6, "{:?} {gap}", made.next);
        assert!((made.closes.unwrap() / (3.0 * gap) - 1.0).abs() < 1e-6, "{:?} {gap}", made.closes);
        assert_eq!(sewn(&faces, up(made.next.unwrap())).open.len(), 8);
        assert_eq!(sewn(&faces, up(made.closes.unwrap())).brep.solids().len(), 1);
    }
    // What nothing is beside has no tolerance.
    let made = sewn(&sides(1.0, Point::origin(), 3)[..2], 1e-6);
    assert_eq!((made.next, made.closes), (None, None));
}

/// A rounded rim whose fillet comes as the rest of its torus: the faces beside it tell which part was meant.
#[test]
fn a_fillet_goes_on_from_the_faces_beside_it() {
    let (high, r) = (5.0, 0.5);
    let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, high - r)).unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
    let lid = |z: f64, radius: f64| -> Geometry {
        let corner = |x: f64, y: f64| Point::new(6.0 * (x - 0.5), 6.0 * (y - 0.5), z);
        let plane = flat([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
        let circle = Curve::circle(Point::new(0.5, 0.5, 0.0), Vector::z(), radius / 6.0).unwrap();
        let region = Region { outer: vec![ParameterCurve::whole(circle).unwrap()], holes: vec![] };
        Trimmed::new(plane, vec![region], vec![], vec![]).unwrap().into()
    };
    let ring = Curve::circle(Point::new(1.5, 0.0, high - r), Vector::y(), r).unwrap();
    let torus = Surface::revolution(&ring, Point::origin(), Vector::z(), TAU).unwrap();
    // The quarter of the ring between its top and its outermost point.
    let knots = torus.v().breakpoints();
    let at = |v: f64| torus.point(torus.u().domain().0, v).unwrap();
    let is = |p: Point, x: f64, z: f64| (p.x - x).hypot(p.z - z) < 1e-9;
    let quarter = knots.windows(2).find(|pair| {
        let [a, b] = [at(pair[0]), at(pair[1])];
        let ends = |p: Point, q: Point| is(p, 1.5, high) && is(q, 2.0, high - r);
        ends(a, b) || ends(b, a)
    });
    let quarter = quarter.unwrap();
    let fillet = |complement: bool, reversed: bool| -> Geometry {
        let edges: Vec<Edge> = (0..2)
            .map(|k| {
                let curve = torus.isocurve(Direction::V, quarter[k]).unwrap();
                let range = curve.domain();
                Edge { curve, range, ends: [k, k], tolerance: 1e-9, form: CurveForm::Spline }
            })
            .collect();
        let vertices = edges
            .iter()
            .map(|edge| Vertex { point: edge.curve.point(edge.range.0).unwrap(), tolerance: 1e-9 })
            .collect();
        let one =
            |edge: usize| Use { edge, reversed: (edge == 1) != (complement != reversed), parameters: None };
        let face = Face {
            name: None,
            color: None,
            surface: torus.clone(),
            form: SurfaceForm::Spline,
            reversed,
            loops: vec![vec![one(0)], vec![one(1)]],
            points: vec![],
        };
        let shells = vec![Shell { faces: vec![0] }];
        Brep::new(Parts { vertices, edges, faces: vec![face], shells, solids: vec![] }).unwrap().into()
    };
    let cap = 1.5 * 1.5 * r + 2.0 * 1.5 * PI / 4.0 * r * r + r * r * r - r.powi(3) / 3.0;
    let exact = PI * (4.0 * (high - r) + cap);
    for reversed in [false, true] {
        for complement in [false, true] {
            let faces = [tube.clone().into(), lid(0.0, 2.0), lid(high, 1.5), fillet(complement, reversed)];
            let made = sewn(&faces, 1e-6);
            let what = format!("{complement} {reversed}");
            assert_eq!((made.open.len(), made.brep.solids().len()), (0, 1), "{what}");
            assert_eq!(made.inverted, usize::from(complement), "{what}");
            let found = volume(&made.brep);
            assert!((found / exact - 1.0).abs() < 1e-3, "{what}: {found} {exact}");
        }
    }
}

/// A face of a box whose loop runs the wrong way, as against its normal: it is its plane but for the face.
#[test]
fn a_face_that_is_inside_out_is_turned_round() {
    for seed in [0, 300] {
        let faces = sides(1.0, Point::new(3.0, 1.0, -2.0), seed);
        for which in 0..6 {
            let mut all = faces.clone();
            let mut parts = sewn(&[all[which].clone()], 1e-6).brep.parts();
            // A plane that goes on beyond the face.
            let larger = |t: f64| 3.0 * t - 1.0;
            let corner = |u: f64, v: f64| {
                let s = &parts.faces[0].surface;
                let p = |u: f64, v: f64| s.point(u, v).unwrap().coords;
                let origin = p(0.0, 0.0);
                Point::from(origin + (p(1.0, 0.0) - origin) * larger(u) + (p(0.0, 1.0) - origin) * larger(v))
            };
            let plane = flat([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
            let face = &mut parts.faces[0];
            face.surface = plane;
            for uses in &mut face.loops {
                uses.reverse();
                uses.iter_mut().for_each(|one| (one.reversed, one.parameters) = (!one.reversed, None));
            }
            all[which] = Brep::new(parts).unwrap().into();
            let made = sewn(&all, 1e-6);
            assert_eq!(
                (made.inverted, made.open.len(), made.brep.solids().len()),
                (1, 0, 1),
                "{seed} {which}"
            );
            assert!((volume(&made.brep) - 6.0).abs() < 1e-9);
        }
    }
}

fn run(fields: Value, faces: &[Geometry]) -> (Vec<String>, Vec<String>) {
    let mut scene = Scene::new();
    for (k, face) in faces.iter().enumerate() {
        scene.add(Object::new(format!("side {k}"), face.clone())).unwrap();
    }
    let mut registry = Registry::new();
    registry.add(&Construction);
    registry.add(&Tessellation);
    let operation = registry.find_operation("sew", "op").unwrap();
    let parameters = Parameters::new(fields, "step[0]").unwrap();
    let report = operation.apply(&mut scene, &parameters, &Context::quiet(&registry)).unwrap();
    (report.notes, report.warnings)
}

/// A corner of a side is cut off by an edge that is nearly as long as the tolerance: that is warned of, a much shorter one is told.
#[test]
fn an_edge_about_as_long_as_the_tolerance_is_warned_of() {
    let near = 1e-3;
    for (long, warned) in [(0.6 * near, true), (0.05 * near, false)] {
        let mut faces = sides(1.0, Point::origin(), 0);
        let Geometry::Surface(side) = &faces[2] else { panic!("a surface") };
        // In parameters lengths are 1 and 3.
        let corners = [[0.0, long / 3.0], [long, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let at = |k: usize| Point::new(corners[k % 5][0], corners[k % 5][1], 0.0);
        let outer =
            (0..5).map(|k| ParameterCurve::whole(Curve::line(at(k), at(k + 1)).unwrap()).unwrap()).collect();
        let region = Region { outer, holes: vec![] };
        faces[2] = Trimmed::new(side.clone(), vec![region], vec![], vec![]).unwrap().into();
        let made = sewn(&faces, near);
        assert_eq!((made.short, made.open.len(), made.brep.solids().len()), (1, 0, 1));
        assert!(made.longest > 0.5 * long && made.longest <= long * 1.5, "{} {long}", made.longest);
        let (notes, warnings) = run(json!({ "objects": ["side*"], "tolerance": near }), &faces);
        let says = |list: &[String]| {
            list.iter().any(|text| text.contains("1 edge no longer than the tolerance is left out"))
        };
        assert_eq!((says(&notes), says(&warnings)), (!warned, warned), "{notes:?} {warnings:?}");
    }
}

/// What is told says a number that works, and that faces were healed.
#[test]
fn what_was_healed_is_told() {
    let mut faces = sides(1.0, Point::origin(), 5);
    let map = Matrix4::new_translation(&Vector::new(0.0, 0.0, 1.234_567_8e-3));
    faces[1] = faces[1].transformed(&map).unwrap();
    faces.push(faces[2].clone());
    let (notes, warnings) = run(json!({ "objects": ["side*"] }), &faces);
    assert!(notes.iter().any(|text| text.ends_with("with a tolerance of 0.00124 m none is")), "{notes:?}");
    assert!(warnings.iter().any(|text| text.contains("lies on another one")), "{warnings:?}");
    let (notes, _) = run(json!({ "objects": ["side*"], "tolerance": 0.00124 }), &faces);
    assert!(notes.iter().any(|text| text.contains("1 shell closes")), "{notes:?}");
}

/// Curves of every degree on both sides of a gap: the tolerance is that of the furthest place.
#[test]
fn gaps_of_curved_edges_are_measured_where_they_are_widest() {
    for degree in [2, 3, 5, 7] {
        let sheet = |bulge: f64, side: f64| {
            let space = Space::clamped_uniform(degree, degree + 3).unwrap();
            let count = space.len();
            let rim = |k: usize| {
                let t = space.greville(k) / space.domain().1;
                Point::new(t, 0.02 * bulge * t * (1.0 - t), 0.3 * (3.0 * t).sin())
            };
            let net = (0..2 * count).map(|k| {
                let p = rim(k % count);
                if k < count { p } else { p + Vector::new(0.0, side, 0.0) }
            });
            Surface::new(Space::clamped(1, &[0.0, 1.0]).unwrap(), space.clone(), net.collect()).unwrap()
        };
        let (one, other) = (sheet(0.0, 1.0), sheet(-1.0, -1.0));
        let rims = [&one, &other].map(|s| s.isocurve(Direction::U, 0.0).unwrap());
        let gap = (0..=2000)
            .map(|k| {
                let (a, b) = rims[0].domain();
                let p = rims[0].point(a + (b - a) * f64::from(k) / 2000.0).unwrap();
                rims[1].closest(p).unwrap().distance
            })
            .fold(0.0, f64::max);
        let made = sewn(&[one.clone().into(), other.clone().into()], 1e-6);
        let next = made.next.unwrap();
        assert!((next / gap - 1.0).abs() < 0.02, "{degree}: {next} {gap}");
        assert_eq!(sewn(&[one.into(), other.into()], 1.03 * next).joined, 1, "{degree}");
    }
}

/// Fifty-seven sets of faces, each moved by up to a third of a thousandth of the size: boxes, and cups with lids. All of them close, and are solids.
#[test]
fn gaps_of_a_thousandth_are_closed() {
    let mut seed = 7_u64;
    let mut random = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let line = Curve::line(Point::new(2.0, 0.0, 0.0), Point::new(2.0, 0.0, 5.0)).unwrap();
    let tube = Surface::revolution(&line, Point::origin(), Vector::z(), TAU).unwrap();
    let lid = |z: f64, turn: f64| -> Geometry {
        let corner = |x: f64, y: f64| Point::new(6.0 * (x - 0.5), 6.0 * (y - 0.5), z);
        let plane = flat([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
        let (x, y) = (Vector::new(turn.cos(), turn.sin(), 0.0), Vector::new(-turn.sin(), turn.cos(), 0.0));
        let arc = Curve::elliptic_arc(Point::new(0.5, 0.5, 0.0), x / 3.0, y / 3.0, 0.0, TAU).unwrap();
        let region = Region { outer: vec![ParameterCurve::whole(arc).unwrap()], holes: vec![] };
        Trimmed::new(plane, vec![region], vec![], vec![]).unwrap().into()
    };
    let mut failed = Vec::new();
    for k in 0..57 {
        let (faces, exact, size) = match k % 2 {
            0 => (sides(1.0, Point::origin(), 9 * k), 6.0, 3.0),
            _ => (vec![tube.clone().into(), lid(0.0, 0.1 * k as f64), lid(5.0, 0.3)], PI * 20.0, 5.0),
        };
        let near = 1e-3 * size;
        let faces: Vec<Geometry> = faces
            .iter()
            .map(|face| {
                let by = Vector::new(random(), random(), random()) * (0.5 * near);
                face.transformed(&Matrix4::new_translation(&by)).unwrap()
            })
            .collect();
        let made = sewn(&faces, near);
        let solids = made.brep.solids().len();
        let volume = if solids == 1 { volume(&made.brep) / exact - 1.0 } else { f64::NAN };
        if (made.open.len(), solids) != (0, 1) || volume.abs() > 5e-3 {
            failed.push((k, made.open.len(), solids, made.unknown, volume));
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
