//! Faces that meet themselves, as they are written: which side of a seam their edges start from, and tips that are met.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::HashMap;

use loftsman_iges::Iges;
use loftsman_kernel::brep::{Brep, SurfaceForm};
use loftsman_kernel::plugin::{Format, Memory, WriteOptions};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::spline::Curve;

use crate::common::read;

/// A file that was made for tests.
fn made(name: &str) -> Scene {
    let path = format!("{}/../../tests/data/made/{name}.igs", env!("CARGO_MANIFEST_DIR"));
    read(&std::fs::read_to_string(path).unwrap()).unwrap().0
}

fn breps(scene: &Scene) -> Vec<&Brep> {
    let geometries = scene.objects().iter().map(Object::geometry);
    geometries
        .filter_map(|geometry| if let Geometry::Brep(brep) = geometry { Some(brep) } else { None })
        .collect()
}

fn written(scene: &Scene) -> String {
    let mut memory = Memory::new("t.igs", Vec::new());
    Iges.write(scene, &mut memory, &WriteOptions::default()).unwrap();
    String::from_utf8(memory.bytes).unwrap()
}

/// The parameters of each entity, by its number.
fn entities(text: &str) -> HashMap<usize, Vec<f64>> {
    let mut all: HashMap<usize, String> = HashMap::new();
    for line in text.lines().filter(|line| line.as_bytes().get(72) == Some(&b'P')) {
        *all.entry(line[64..72].trim().parse().unwrap()).or_default() += line[..64].trim();
    }
    let numbers = |text: String| {
        text.trim_end_matches(';')
            .split(',')
            .map(|one| one.replace('D', "e").parse().unwrap_or(f64::NAN))
            .collect()
    };
    all.into_iter().map(|(number, text)| (number, numbers(text))).collect()
}

/// The control points of a spline curve (126).
fn points(curve: &[f64]) -> Vec<[f64; 2]> {
    assert_eq!(curve[0], 126.0);
    let (last, degree) = (curve[1] as usize, curve[2] as usize);
    let first = 7 + (last + degree + 2) + (last + 1);
    (0..=last).map(|k| [curve[first + 3 * k], curve[first + 3 * k + 1]]).collect()
}

/// A ball out of which another one was cut, but for a small part of it all that is left of both is a ball: its seam has two sides, a turn apart, and its loop runs on but at poles, in degrees.
#[test]
fn seams_of_solids_have_two_sides() {
    let text = written(&made("bitten_solid"));
    let all = entities(&text);
    let mut seams = 0;
    for chain in all.values().filter(|entity| entity[0] == 508.0) {
        let (mut at, mut uses) = (2, Vec::new());
        for _ in 0..chain[1] as usize {
            assert_eq!((chain[at], chain[at + 4]), (0.0, 1.0), "{chain:?}");
            uses.push((chain[at + 2] as usize, points(&all[&(chain[at + 6] as usize)])));
            at += 7;
        }
        for (k, (edge, own)) in uses.iter().enumerate() {
            let (end, start) = (own[own.len() - 1], uses[(k + 1) % uses.len()].1[0]);
            assert!((end[1] - start[1]).abs() < 1e-6, "{uses:?}");
            assert!((end[0] - start[0]).abs() < 1e-6 || (end[1].abs() - 90.0).abs() < 1e-6, "{uses:?}");
            for (other, across) in uses.iter().skip(k + 1).filter(|(other, _)| other == edge) {
                seams += 1;
                assert!(((own[0][0] - across[0][0]).abs() - 360.0).abs() < 1e-6, "{edge} {other}: {uses:?}");
            }
        }
    }
    assert!(seams > 0, "{text}");
}

/// A cone out of which a cylinder was cut: its seam misses the tip by what numbers of ten digits are off, and is written as ending there.
#[test]
fn seams_end_at_the_tips_that_they_miss_by_noise() {
    // How far ends of lines that are near a tip are from it, as a part of their size.
    let off = |scene: &Scene| {
        let mut all = Vec::new();
        for brep in breps(scene) {
            for face in 0..brep.face_count() {
                let SurfaceForm::Cone { frame, radius, angle } = brep.surface_form(face) else { continue };
                let tip = frame.origin - frame.z * (radius / angle.tan());
                for one in brep.loops(face).iter().flatten() {
                    let edge = brep.edge(one.edge).unwrap();
                    let size = edge.curve.points().iter().map(|p| (p - tip).norm()).fold(0.0, f64::max);
                    let ends = edge.ends.map(|end| (brep.vertices()[end] - tip).norm() / size);
                    all.extend(ends.into_iter().filter(|off| *off < 1e-4));
                }
            }
        }
        all
    };
    let scene = made("cone_tip");
    let before = off(&scene);
    assert!(!before.is_empty() && before.iter().any(|off| *off > 1e-11), "{before:?}");
    let after = off(&read(&written(&scene)).unwrap().0);
    assert!(after.len() == before.len() && after.iter().all(|off| *off < 1e-14), "{before:?} {after:?}");
}

/// Edges that are further off their faces than their tolerances say: the file says how exact it is.
#[test]
fn a_file_states_how_far_edges_are_off_their_faces() {
    let scene = made("bitten_solid");
    let brep = breps(&scene)[0];
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
    let (again, report) = read(&written(&scene)).unwrap();
    let stated = breps(&again)[0].tolerances().iter().copied().fold(0.0, f64::max);
    assert!(stated >= gap, "{stated} of {gap}: {report:?}");
}
