//! `simulate` in Blender: as many key frames as were written, the last one in its place, and smooth.

use loftsman::kernel::Point;
use loftsman::kernel::mesh::Mesh;
use loftsman::kernel::scene::{Geometry, Scene};
use loftsman::kernel::shape::{Derivative, Location, Shape};
use loftsman_tests::curves::document;
use loftsman_tests::oracle::{Oracle, list, number, object, position};
use serde_json::{Value, json};

use crate::{LOFTSMAN, save};

/// Places are where they should be to this share of the size.
const NEAR: f64 = 1e-5;

fn knots(count: usize) -> Vec<usize> {
    [vec![0; 3], (0..=count - 3).collect(), vec![count - 3; 3]].concat()
}

/// Runs a recipe of these steps on one object: the film, and the scene beside it.
fn film(folder: &std::path::Path, name: &str, shape: Value, steps: &[Value]) -> (std::path::PathBuf, Scene) {
    save(folder, &format!("{name}.in.loft.json"), &document("m", &[shape]));
    let (glb, kept) = (format!("{name}.glb"), format!("{name}.loft.json"));
    let recipe = json!({ "input": format!("{name}.in.loft.json"), "output": [glb, kept], "step": steps });
    std::fs::write(folder.join("r.json"), recipe.to_string()).unwrap();
    LOFTSMAN.done(folder, &["run", "r.json"]);
    (folder.join(glb), loftsman::read_scene(folder.join(kept)).unwrap())
}

/// Where Blender draws the points of an object, in the `frame`-th of the frames that it was asked for.
fn drawn(report: &Value, frame: usize, name: &str) -> Vec<Point> {
    let entry = &list(report, "frames")[frame]["objects"][name];
    list(entry, "points").iter().map(|p| Point::from(position(p))).collect()
}

/// The points of an animated object at a frame, the shape itself for `None`.
fn at_frame(scene: &Scene, name: &str, frame: Option<usize>) -> Vec<Point> {
    let object = scene.object(name).unwrap();
    frame
        .map_or(object.geometry().points().to_vec(), |k| object.animation.as_ref().unwrap().frames[k].clone())
}

/// How far points are from a curve or surface with these control vertices.
fn off(points: &[Point], shape: &Geometry, vertices: &[Point]) -> f64 {
    let mut shape = shape.clone();
    let closest: Box<dyn Fn(Point) -> f64> = match &mut shape {
        Geometry::Curve(curve) => {
            let curve =
                loftsman::kernel::spline::Curve::new(curve.space().clone(), vertices.to_vec()).unwrap();
            Box::new(move |p| curve.closest(p).unwrap().distance)
        }
        Geometry::Surface(surface) => {
            let (u, v) = (surface.u().clone(), surface.v().clone());
            let surface = loftsman::kernel::spline::Surface::new(u, v, vertices.to_vec()).unwrap();
            Box::new(move |p| surface.closest(p).unwrap().distance)
        }
        other => panic!("{} is no spline", other.kind()),
    };
    points.iter().map(|p| closest(*p)).fold(0.0, f64::max)
}

/// How far places all over a curve or surface with these control vertices are from the nearest of the points: what is drawn of it in part only leaves some far.
fn uncovered(points: &[Point], shape: &Geometry, vertices: &[Point]) -> f64 {
    let mut shape = shape.shape().unwrap().boxed();
    shape.control_vertices_mut().copy_from_slice(vertices);
    let domain = shape.domain();
    let at = |axis: usize, k: u32| {
        let interval = &domain[axis];
        interval.start + (interval.end - interval.start) * f64::from(k) / 16.0
    };
    let places: Vec<Location> = match domain.len() {
        1 => (0..=16).map(|k| at(0, k).into()).collect(),
        _ => (0..=16)
            .flat_map(|i| (0..=16).map(move |j| (i, j)))
            .map(|(i, j)| (at(0, i), at(1, j)).into())
            .collect(),
    };
    let nearest = |place: Location| {
        let own = Point::from(shape.value(place, Derivative::POSITION).unwrap());
        points.iter().map(|p| (own - p).norm()).fold(f64::INFINITY, f64::min)
    };
    places.into_iter().map(nearest).fold(0.0, f64::max)
}

/// The extent of points.
fn extent(points: &[Point]) -> f64 {
    let low = points.iter().fold(points[0], |low, p| low.inf(p));
    (points.iter().fold(points[0], |high, p| high.sup(p)) - low).norm()
}

#[test]
fn blender_plays_what_was_simulated_to_its_last_frame_and_smooth() {
    let folder = tempfile::tempdir().unwrap();
    let rope: Vec<_> = (0..20).map(|i| json!([0.2 * f64::from(i), 0, 0.05 * f64::from(i % 3)])).collect();
    let rope = json!({ "name": "rope", "curve": { "degree": 3, "knots": knots(20), "points": rope } });
    let held = json!([{ "kind": "fixed", "at": 0 }, { "kind": "sliding", "near": 10 }]);
    let swing =
        json!({ "op": "simulate", "seconds": 1, "scheme": "implicit", "step": 0.01, "constraints": held });
    let tube = json!({ "op": "tube", "radius": 0.05, "sides": 10, "caps": "round", "name": "hose" });
    let side = json!({ "degree": 3, "knots": knots(7) });
    // It is flat at first, and sags between its corners.
    let net: Vec<Vec<Value>> = (0..7)
        .map(|i| (0..7).map(|j| json!([f64::from(i) / 6.0, f64::from(j) / 6.0, 0])).collect())
        .collect();
    let sheet = json!({ "name": "sheet", "surface": { "u": side, "v": side, "points": net } });
    let corners: Vec<_> =
        [[0, 0], [4, 0], [0, 4], [4, 4]].iter().map(|at| json!({ "kind": "fixed", "at": at })).collect();
    let sag = json!({ "op": "simulate", "seconds": 0.5, "settle": true, "scheme": "implicit", "step": 0.01,
        "stiffness": 30, "damping": 2, "constraints": corners });
    let (ropes, rope_scene) = film(folder.path(), "ropes", rope, &[swing, tube]);
    let (sheets, sheet_scene) = film(folder.path(), "sheets", sheet, &[sag]);
    let files = [ropes, sheets];
    let options = ["--frames", "0,12,24", "--frame-points", "--eval"];
    let Some(reports) = Oracle::Blender.ask(&files, &options) else { return };
    let mut looked = 0;
    for (report, scene, names, frames) in [
        (&reports[0], &rope_scene, &["rope", "hose"][..], 25),
        (&reports[1], &sheet_scene, &["sheet"][..], 13),
    ] {
        let keys = list(report, "actions");
        for name in names {
            let own = scene.object(name).unwrap();
            assert_eq!(own.animation.as_ref().unwrap().frames.len(), frames, "{name}");
            let shapes = list(object(report, name), "shape_keys");
            assert_eq!(
                (shapes.len(), &shapes[frames]["name"]),
                (frames + 1, &json!(format!("frame {}", frames - 1)))
            );
            // Each is keyed at each frame, all objects of the file.
            let channels = keys.iter().flat_map(|action| list(action, "fcurves"));
            let own_keys = channels.filter(|c| c["keys"] == json!(frames)).count();
            assert!(
                own_keys >= names.len() * frames,
                "{name}: {own_keys} channels of {frames} keys: {keys:?}"
            );
            // The last frame of the sheet comes at 12: it stays there.
            for (asked, frame) in [(0, 0), (1, 12), (2, frames - 1)] {
                let shown = drawn(report, asked, name);
                let wanted = at_frame(scene, name, Some(frame));
                let near = NEAR * extent(&wanted);
                let apart = match own.geometry() {
                    // The points in their order; those that differ in texture are there twice, behind all.
                    Geometry::Mesh(mesh) => {
                        assert!(shown.len() >= mesh.points().len());
                        paired(&shown, mesh, &wanted)
                    }
                    spline => {
                        // All of it, in steps of no more than a thirtieth.
                        let left = uncovered(&shown, spline, &wanted);
                        assert!(left < extent(&wanted) / 30.0, "{name} at frame {frame}: {left}");
                        off(&shown, spline, &wanted)
                    }
                };
                assert!(apart <= near, "{name} at frame {frame}: {apart:e} of {near:e}");
                // Not because all frames are alike.
                if frame > 0 {
                    let first = at_frame(scene, name, Some(0));
                    let moved = first.iter().zip(&wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                    assert!(moved > 1e3 * near, "{name} at frame {frame} moved by {moved:e}");
                }
                let shading = &list(report, "frames")[asked]["objects"][*name]["shading"];
                if number(shading, "faces") > 0.0 {
                    assert_eq!(shading["smooth_faces"], shading["faces"], "{name} at frame {frame}");
                    assert!(number(shading, "max_degrees_apart") < 0.1, "{name} at frame {frame}: {shading}");
                }
                looked += 1;
            }
        }
    }
    assert_eq!(looked, 9);
}

/// How far the points are that Blender draws from those of the mesh, each from its own; points that are there twice from any.
fn paired(shown: &[Point], mesh: &Mesh, wanted: &[Point]) -> f64 {
    let own = mesh.points().len();
    let first = shown.iter().zip(wanted).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let nearest = |p: &Point| wanted.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    shown[own..].iter().map(nearest).fold(first, f64::max)
}
