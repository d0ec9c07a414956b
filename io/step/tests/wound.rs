//! Bounds that run the wrong way round on faces that are no planes, and how exact a file says that it is.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Format, Memory, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::Curve;
use loftsman_step::Step;

use crate::common::read;

fn mirrored() -> (Brep, Vec<String>) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/made/mirrored_torus.step");
    let (scene, report) = read(&std::fs::read_to_string(path).unwrap()).unwrap();
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!("{report:?}") };
    (brep.clone(), report.notes)
}

/// A torus and a ball together, mirrored: OpenCASCADE wrote the flag of the torus's bound as it is not. No face of it is a plane: as the file's parameter curves have it, the bound of
/// the torus has to be turned, and the hole in the ball is right.
#[test]
fn bounds_are_turned_as_parameter_curves_say() {
    let (brep, notes) = mirrored();
    assert_eq!(brep.solids().len(), 1, "{notes:?}");
    assert!(notes.iter().any(|note| note.starts_with("#17:") && note.contains("turned round")), "{notes:?}");
    assert!(!notes.iter().any(|note| note.starts_with("#708:")), "{notes:?}");
    for face in 0..brep.face_count() {
        let is_ball = !brep.face(face).unwrap().points.is_empty();
        let curves = brep.parameter_curves(face).unwrap();
        let mut places: Vec<[f64; 2]> = Vec::new();
        for (one, found) in brep.loops(face)[0].iter().zip(&curves[0]) {
            let (from, to) = found.curve.range();
            for k in 0..=40 {
                let share = f64::from(if one.reversed { 40 - k } else { k }) / 40.0;
                let p = found.curve.curve().point((from + (to - from) * share).min(to)).unwrap();
                places.push([p.x, p.y]);
            }
        }
        let next = places.iter().skip(1).chain(places.first());
        let area: f64 = places.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
        // What is left of the ball is outside of its loop.
        assert_eq!((area > 0.0) != brep.is_reversed(face), !is_ball, "{face}: {area}");
    }
}

/// Edges that are further off their faces than their tolerances say: the file says how exact it is.
#[test]
fn a_file_states_how_far_edges_are_off_their_faces() {
    let (brep, _) = mirrored();
    let mut parts = brep.parts();
    let size = brep.vertices().iter().map(|p| (p - brep.vertices()[0]).norm()).fold(0.0, f64::max);
    for edge in &mut parts.edges {
        edge.tolerance = 1e-9 * size;
        let (space, mut points, weights) = edge.curve.clone().into_parts();
        points.iter_mut().for_each(|p| p.z += 2e-6 * size);
        edge.curve = Curve::build(space, points, weights).unwrap();
    }
    parts.vertices.iter_mut().for_each(|vertex| vertex.tolerance = 1e-9 * size);
    let off = Brep::new(parts).unwrap();
    let gap = off.gap().unwrap();
    assert!(gap > 1e-6 * size && gap < 3e-6 * size, "{gap} of {size}");
    let mut scene = Scene::new();
    scene.add(Object::new("it", Geometry::Brep(off))).unwrap();
    let mut memory = Memory::new("t.step", Vec::new());
    let report = Step.write(&scene, &mut memory, &WriteOptions::default()).unwrap();
    assert!(format!("{report:?}").contains("edges are off their surfaces by more"), "{report:?}");
    let (again, report) = read(&String::from_utf8(memory.bytes).unwrap()).unwrap();
    let Geometry::Brep(again) = again.objects()[0].geometry() else { panic!("{report:?}") };
    let stated = again.tolerances().iter().copied().fold(0.0, f64::max);
    assert!(stated >= gap, "{stated} of {gap}: {report:?}");
}
