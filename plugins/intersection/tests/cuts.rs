//! Sections of solids against OpenCASCADE's and against closed forms: `golden/cuts.py` made the numbers.
#![allow(clippy::unwrap_used, reason = "a test that fails should panic")]

use std::f64::consts::TAU;

use loftsman_area_volume::volume_of;
use loftsman_intersection::{Options, Plane, ShellSection, brep_section};
use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::plugin::{Format, Memory, ReadOptions};
use loftsman_kernel::scene::{Definition, Geometry};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use loftsman_step::Step;
use serde_json::Value;

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/cuts.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn point(value: &Value) -> Point {
    Point::from_slice(&numbers(value))
}

fn vector(value: &Value) -> Vector {
    point(value).coords
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

/// What is compared, and what all comparisons together came to.
#[derive(Debug, Default)]
struct Told {
    cuts: usize,
    lengths: usize,
    areas: usize,
    points: usize,
    /// Lengths and areas held to a millionth and better, and those that are so near.
    within_a_millionth: usize,
    near_a_millionth: usize,
    wrong: Vec<String>,
}

impl Told {
    /// Holds a section, its lengths to be multiplied by `unit`, against a case. The file tells, by OpenCASCADE, how far the solid's edges are `off` its
    /// faces where the plane passes them: one of the two has its corner at the edge, the other on a face.
    fn compare(&mut self, name: &str, case: &Value, found: &ShellSection, unit: f64) {
        self.cuts += 1;
        let off = case.get("off").map_or(0.0, |off| off.as_f64().unwrap());
        let mut wrong = |problem: String| {
            self.wrong.push(format!("{name} {} {}: {problem}", case["point"], case["normal"]));
        };
        if !found.undecided.is_empty() || found.curves.iter().any(|c| !c.closed) {
            wrong(format!("undecided {:?}, or open", found.undecided));
            return;
        }
        if case["loops"].as_u64().is_some_and(|loops| loops != found.curves.len() as u64) {
            wrong(format!("{} loops, not {}", found.curves.len(), case["loops"]));
        }
        let fine_length = 1e-3 * found.tolerance;
        let length: f64 = found.curves.iter().map(|c| c.curve.length(fine_length).unwrap().value).sum();
        let (length, area) = (length * unit, found.area.unwrap() * unit * unit);
        // All of a loop may be as far off as it is at most. What it was moved by to lie in the plane is added: some hundredths of what was asked for.
        let fine = found.curves.iter().map(|c| c.distance).fold(0.0, f64::max);
        if fine > 1.05 * found.tolerance {
            wrong(format!("{fine:e} off, where {:e} is asked for", found.tolerance));
        }
        let fine = fine * unit;
        let around = TAU * fine * found.curves.len() as f64;
        let crossed = found.curves.iter().map(|c| c.faces.len()).sum::<usize>() as f64;
        let slacks = [around + 2.0 * off * crossed, (fine + off) * length];
        for (k, (key, ours)) in [("length", length), ("area", area)].into_iter().enumerate() {
            let Some(theirs) = case[key].as_f64() else { continue };
            let unsure = case["unsure"][k].as_f64().unwrap_or(0.0);
            let allowed = (NEAR * theirs + unsure + slacks[k]).min(MOST * theirs);
            if (ours - theirs).abs() > allowed {
                wrong(format!(
                    "{key} {ours}, not {theirs}: {:.1e} where {allowed:.1e} is allowed",
                    ours - theirs
                ));
            }
            self.within_a_millionth += usize::from(allowed <= 1e-6 * theirs);
            self.near_a_millionth += usize::from((ours - theirs).abs() <= 1e-6 * theirs);
            if k == 0 { self.lengths += 1 } else { self.areas += 1 }
        }
        let mut bounds: Option<(Point, Point)> = None;
        for branch in &found.curves {
            let (low, high) = branch.curve.bounds();
            bounds = Some(bounds.map_or((low, high), |(l, h)| (l.inf(&low), h.sup(&high))));
        }
        let (low, high) = bounds.unwrap();
        let within = case["within"].as_f64().unwrap() + found.tolerance * unit + off;
        let sides =
            (low * unit - point(&case["low"])).amax().max((high * unit - point(&case["high"])).amax());
        if sides > within {
            wrong(format!("its box is {sides:.1e} off"));
        }
        for theirs in list(&case["points"]) {
            let p = point(theirs);
            let near = found.curves.iter().map(|c| c.curve.closest(p / unit).unwrap().distance * unit);
            let near = near.fold(f64::INFINITY, f64::min);
            if near > within {
                wrong(format!("{p} is {near:.1e} away"));
            }
            self.points += 1;
        }
    }
}

/// Relative: what OpenCASCADE's integrals and its edges (drawn through places of the section) are good for.
const NEAR: f64 = 1e-7;
/// Relative: whatever a file and a section say that they are off by, no more is allowed.
const MOST: f64 = 1e-5;
/// Of the size of a solid: the tolerance that sections are asked for with.
const FINE: f64 = 1e-7;

#[test]
fn sections_of_files_are_those_of_opencascade() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/step/");
    let mut told = Told::default();
    for (name, solids) in golden()["files"].as_object().unwrap() {
        let file = Memory::new(name.as_str(), std::fs::read(format!("{folder}{name}")).unwrap());
        let (scene, _) = Step.read(&file, &ReadOptions::default()).unwrap();
        let unit = scene.unit.metres().unwrap() * 1e3;
        let objects = scene.definitions().iter().flat_map(Definition::objects).chain(scene.objects());
        let breps: Vec<&Brep> = objects
            .filter_map(|object| match object.geometry() {
                Geometry::Brep(brep) if !brep.solids().is_empty() => Some(brep),
                _ => None,
            })
            .collect();
        for (number, solid) in list(solids).iter().enumerate() {
            let volume = solid["volume"].as_f64().unwrap();
            // Edges that are off their faces make one of a little less.
            let same = |brep: &&&Brep| {
                (volume_of(**brep).unwrap() * unit.powi(3) - volume).abs() <= 1e-4 * volume.abs()
            };
            let brep =
                breps.iter().find(same).unwrap_or_else(|| panic!("{name} {number}: none of volume {volume}"));
            let size = (point(&solid["high"]) - point(&solid["low"])).norm() / unit;
            for case in list(&solid["cuts"]) {
                let plane = Plane::new(point(&case["point"]) / unit, vector(&case["normal"])).unwrap();
                let found = brep_section(brep, &plane, &Options::within(FINE * size)).unwrap();
                told.compare(&format!("{name} {number}"), case, &found, unit);
            }
        }
    }
    assert!(told.wrong.is_empty(), "{}", told.wrong.join("\n"));
    println!("{told:?}");
    assert_eq!([told.cuts, told.lengths, told.areas], [98, 98, 89], "{told:?}");
    assert!(
        told.within_a_millionth >= 115 && told.near_a_millionth >= 184 && told.points >= 1000,
        "{told:?}"
    );
}

fn along(edge: usize, reversed: bool) -> Use {
    Use { edge, reversed, parameters: None }
}

/// A surface of revolution about an axis, with the lids that it has.
fn round(case: &Value) -> Brep {
    let sizes = numbers(&case["sizes"]);
    let frame = Frame::new(point(&case["origin"]), vector(&case["axis"]), vector(&case["x"])).unwrap();
    let face = |form: SurfaceForm, points: &[Point], reversed: bool, loops: Vec<Vec<Use>>| {
        let surface = form.covering(points).unwrap();
        Face { name: None, color: None, surface, form, reversed, loops, points: vec![] }
    };
    let mut parts = Parts::default();
    let (wall, bottom, top, height) = match (case["kind"].as_str().unwrap(), &sizes[..]) {
        ("sphere", &[radius]) => {
            parts.faces.push(face(SurfaceForm::Sphere { frame, radius }, &[], false, vec![]));
            (None, 0.0, 0.0, 0.0)
        }
        ("torus", &[major, minor]) => {
            parts.faces.push(face(SurfaceForm::Torus { frame, major, minor }, &[], false, vec![]));
            (None, 0.0, 0.0, 0.0)
        }
        ("cylinder", &[radius, height]) => {
            (Some(SurfaceForm::Cylinder { frame, radius }), radius, radius, height)
        }
        ("cone", &[bottom, top, height]) => {
            // Its angle opens along the axis.
            let turned = Frame { origin: frame.origin + frame.z * height, z: -frame.z, ..frame };
            let angle = ((bottom - top) / height).atan();
            (Some(SurfaceForm::Cone { frame: turned, radius: top, angle }), bottom, top, height)
        }
        other => unreachable!("{other:?}"),
    };
    if let Some(wall) = wall {
        let mut corners = Vec::new();
        for (k, (radius, height)) in [(bottom, 0.0), (top, height)].into_iter().enumerate() {
            let center = frame.origin + frame.z * height;
            let curve = Curve::circle(center, frame.z, radius).unwrap();
            let range = curve.domain();
            let start = Vertex { point: curve.point(range.0).unwrap(), tolerance: 1e-12 };
            parts.vertices.push(start);
            parts.edges.push(Edge { curve, range, ends: [k; 2], tolerance: 1e-12, form: CurveForm::Spline });
            let (x, y) = (frame.x * radius, frame.y() * radius);
            let around = [x + y, x - y, -x - y, y - x].map(|v| center + v);
            let lid = SurfaceForm::Plane { frame: Frame { origin: center, ..frame } };
            parts.faces.push(face(lid, &around, k == 0, vec![vec![along(k, k == 0)]]));
            corners.extend(around);
        }
        // Its loops have the face to the left.
        parts.faces.push(face(wall, &corners, false, vec![vec![along(0, false)], vec![along(1, true)]]));
    }
    parts.shells.push(Shell { faces: (0..parts.faces.len()).collect() });
    parts.solids.push(Solid::default());
    Brep::new(parts).unwrap()
}

#[test]
fn sections_of_round_solids_have_closed_forms() {
    let mut told = Told::default();
    for case in list(&golden()["round"]) {
        let plane = Plane::new(point(&case["point"]), vector(&case["normal"])).unwrap();
        let found = brep_section(&round(case), &plane, &Options::within(1e-8)).unwrap();
        told.compare(&case["kind"].to_string(), case, &found, 1.0);
    }
    assert!(told.wrong.is_empty(), "{}", told.wrong.join("\n"));
    assert!(told.cuts >= 26 && told.within_a_millionth >= 50, "{told:?}");
}
