//! Areas and volumes of the solids of real STEP files against OpenCASCADE's.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use loftsman::area_volume::{surface_area, volume_of};
use loftsman::kernel::brep::Brep;
use loftsman::kernel::functional::{Shapes, value_of};
use loftsman::kernel::plugin::{Chord, Context, Fineness, Parameters, Tessellator};
use loftsman::kernel::scene::{Geometry, Object, Scene};
use loftsman::kernel::{Point, Vector};
use serde_json::json;

/// What OpenCASCADE finds in a file; `unsure` is what its own integrals are unsure by.
#[derive(serde::Deserialize)]
struct Told {
    area: f64,
    unsure: f64,
    solids: Vec<Solid>,
}

#[derive(Debug, serde::Deserialize)]
struct Solid {
    area: f64,
    volume: f64,
    unsure: [f64; 2],
}

/// Rounding, and what fits of edges leave.
const EXACT: f64 = 1e-9;
/// A loop that is off its edge by a distance changes an area by that times its length, where the face meets the next one squarely; flatter, by more.
const FLAT: f64 = 4.0;

/// By how much an area may differ, since the edges of the file are off the faces that they bound: their lengths times how far they are off, as
/// [`parameter_curves`](Brep::parameter_curves) measures it.
fn slack(brep: &Brep) -> f64 {
    let length = |edge: usize| {
        let (curve, (from, to)) = (brep.curve(edge).unwrap(), brep.edge(edge).unwrap().range);
        let at = |k: u32| curve.point(from + (to - from) * f64::from(k) / 64.0).unwrap();
        (0..64).map(|k| (at(k + 1) - at(k)).norm()).sum::<f64>()
    };
    let mut sum = 0.0;
    for face in 0..brep.face_count() {
        let curves = brep.parameter_curves(face).unwrap();
        for (one, curve) in brep.loops(face).iter().flatten().zip(curves.iter().flatten()) {
            sum += length(one.edge) * curve.error;
        }
    }
    FLAT * sum
}

/// What OpenCASCADE's integrals change by when they are refined a last time does not bound what they are off by.
const UNSURE: f64 = 4.0;

/// A file whose circles are splines: OpenCASCADE puts those onto its cylinders by approximation, and is off by a millionth. The parts are a bolt,
/// a nut and a bracket that have closed forms, in millimetres.
fn in_closed_form(name: &str) -> Option<Vec<Solid>> {
    let solid = |area: f64, volume: f64| Solid { area, volume, unsure: [0.0; 2] };
    (name == "dm1-id-214.stp").then(|| {
        vec![
            // A shaft of radius 5 and length 37 with a head of radius 7.5 and height 3.
            solid(527.5 * PI, 1093.75 * PI),
            // 15 by 20 by 3 with a hole of radius 5.
            solid(810.0 - 20.0 * PI, 900.0 - 75.0 * PI),
            // 10 thick, with legs of 50 and 60, 100 wide, and four holes of radius 5.
            solid(24_000.0 + 200.0 * PI, 100_000.0 - 1000.0 * PI),
        ]
    })
}

/// The diagonal of the box of its vertices.
fn extent(brep: &Brep) -> f64 {
    let points = brep.vertices();
    let low = points.iter().fold(points[0], |low, p| low.inf(p));
    (points.iter().fold(points[0], |high, p| high.sup(p)) - low).norm()
}

#[test]
fn solids_have_the_areas_and_volumes_that_opencascade_finds() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let told = std::fs::read_to_string(root.join("golden/solids.json")).unwrap();
    let told: BTreeMap<String, Told> = serde_json::from_str(&told).unwrap();
    let (mut files, mut solids, mut wrong) = (0, 0, Vec::new());
    for (name, mut told) in told {
        told.solids = in_closed_form(&name).unwrap_or(told.solids);
        let scene = loftsman::read_scene(root.join("data/step").join(&name)).unwrap();
        // OpenCASCADE reads all lengths as millimetres.
        let unit = scene.unit.metres().unwrap() * 1e3;
        let definitions = scene.definitions().iter().flat_map(|definition| definition.objects());
        let (mut loose, mut off) = (0.0, 0.0);
        for object in definitions.chain(scene.objects()) {
            let Geometry::Brep(brep) = object.geometry() else { continue };
            let mut area = [0.0];
            value_of(&surface_area(), &Shapes::one(brep), &mut area).unwrap();
            let area = area[0] * unit * unit;
            if brep.solids().is_empty() {
                loose += area;
                off += slack(brep) * unit * unit;
                continue;
            }
            let volume = volume_of(brep).unwrap() * unit.powi(3);
            let off = slack(brep) * unit * unit;
            let near = |found: f64, told: f64, off: f64| (found - told).abs() <= EXACT * told + off;
            let same = |told: &Solid| {
                near(area, told.area, UNSURE * told.unsure[0] + off)
                    && near(volume, told.volume, UNSURE * told.unsure[1] + off * extent(brep) * unit)
            };
            if !told.solids.iter().any(same) {
                let first = told.solids.iter().map(|s| (s.area, s.volume));
                let nearest = first.min_by(|a, b| (a.0 - area).abs().total_cmp(&(b.0 - area).abs()));
                wrong.push(format!(
                    "{name} \"{}\": {area:?} {volume:?}, not {nearest:?}; edges are off by {off:e}",
                    object.name()
                ));
            }
            // What edges are off is little beside the whole, or nothing would be tested.
            assert!(off <= 1e-3 * area, "{name}: {off:e} of {area:e}");
            solids += 1;
        }
        if told.solids.is_empty()
            && (loose - told.area).abs() > EXACT * told.area + UNSURE * told.unsure + off
        {
            wrong.push(format!("{name}: {loose:?}, not {:?}; edges are off by {off:e}", told.area));
        }
        files += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(files >= 17 && solids >= 20, "{files} files, {solids} solids");
}

/// All files with Breps, at two tolerances: nothing is left out, and nothing is further off than asked for and the file itself is.
#[test]
fn every_face_of_every_file_is_cut() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let tessellator = loftsman::tessellation::Adaptive::default();
    let (mut files, mut faces) = (0, 0);
    for folder in ["step", "iges"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let Ok(scene) = loftsman::read_scene(&path) else { continue };
            let definitions = scene.definitions().iter().flat_map(|definition| definition.objects());
            let mut found = false;
            for object in definitions.chain(scene.objects()) {
                let Geometry::Brep(brep) = object.geometry() else { continue };
                for chord in [2e-3, 2e-4] {
                    let fineness = Fineness { chord: Chord::Relative(chord), ..Fineness::default() };
                    let cut = tessellator.measured_brep(brep, &fineness).unwrap();
                    assert!(cut.left_out.is_empty(), "{}: {:?}", path.display(), cut.left_out);
                    assert!(cut.mesh.face_count() >= brep.face_count());
                }
                faces += brep.face_count();
                found = true;
            }
            files += usize::from(found);
        }
    }
    assert!(files >= 20 && faces >= 500, "{files} files, {faces} faces");
}

/// A torus whose one face has a boundary along both of its seams (`data/made`), as other programs write it in IGES: closed, and as large as it is.
#[test]
fn a_torus_of_one_trimmed_surface_is_whole() {
    let registry = loftsman::registry();
    let format = registry.formats().iter().find(|f| f.declaration().name == "iges").unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/made/torus.igs");
    let memory = loftsman::kernel::plugin::Memory::new("torus.igs", std::fs::read(path).unwrap());
    let (scene, report) = format.read(&memory, &Default::default()).unwrap();
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!("{report:?}") };
    let exact = 4.0 * PI * PI * 5.0;
    let fineness = Fineness { chord: Chord::Relative(1e-4), angle: 0.1 };
    let found = registry.tessellator().unwrap().measured_brep(brep, &fineness).unwrap();
    assert!(found.left_out.is_empty(), "{:?}", found.left_out);
    let points = found.mesh.points();
    let mut area = 0.0;
    for face in found.mesh.faces() {
        let [a, b, c] = [0, 1, 2].map(|k: usize| points[face[k] as usize]);
        area += 0.5 * (b - a).cross(&(c - a)).norm();
    }
    assert!((area / exact - 1.0).abs() < 2e-3, "{area} {exact}");
}

/// Caps of balls whose loops close within the parameters of their spheres (`data/made`): as large as they are, `2 pi r h`.
#[test]
fn caps_that_loops_bound_are_whole() {
    let registry = loftsman::registry();
    let format = registry.formats().iter().find(|f| f.declaration().name == "iges").unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/made/lens.igs");
    let memory = loftsman::kernel::plugin::Memory::new("lens.igs", std::fs::read(path).unwrap());
    let (scene, report) = format.read(&memory, &Default::default()).unwrap();
    let apart = 2.2_f64.hypot(0.4);
    let ring = (apart * apart + 4.0 - 1.0) / (2.0 * apart);
    let mut exact = [4.0 * PI * (2.0 - ring), 2.0 * PI * (1.0 - (apart - ring))];
    let fineness = Fineness { chord: Chord::Relative(1e-5), angle: 0.05 };
    let tessellator = registry.tessellator().unwrap();
    let mut found: Vec<f64> = scene
        .objects()
        .iter()
        .filter_map(|object| match object.geometry() {
            Geometry::Brep(brep) => Some(tessellator.measured_brep(brep, &fineness).unwrap().mesh),
            Geometry::Trimmed(trimmed) => {
                Some(tessellator.measured_trimmed(trimmed, &fineness).unwrap().mesh)
            }
            _ => None,
        })
        .map(|mesh| {
            let corner = |face: &[u32], k: usize| mesh.points()[face[k] as usize];
            let area = |face: &[u32]| {
                let [a, b, c] = [0, 1, 2].map(|k| corner(face, k));
                0.5 * (b - a).cross(&(c - a)).norm()
            };
            mesh.faces().map(area).sum()
        })
        .collect();
    found.sort_by(f64::total_cmp);
    exact.sort_by(f64::total_cmp);
    assert_eq!(found.len(), 2, "{report:?}");
    for (found, exact) in found.iter().zip(exact) {
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
    }
}

/// A face of three sides whose surface ends in a point (`data/made`): fans of triangles beside borders that were just near enough had no width any more, and it was called too singular.
#[test]
fn a_tip_of_a_fillet_is_cut_as_finely_as_is_asked() {
    let registry = loftsman::registry();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/made/fillet_tip.step");
    let scene = loftsman::read_scene(path).unwrap();
    let Geometry::Brep(brep) = scene.objects()[0].geometry() else { panic!("a brep") };
    // As OpenCASCADE's Gauss points find it.
    let exact = 0.110_667_5;
    for chord in [0.01, 0.005, 0.002, 0.001, 0.0005] {
        let fineness = Fineness { chord: Chord::Absolute(chord), angle: 0.5 };
        let cut = registry.tessellator().unwrap().measured_brep(brep, &fineness).unwrap();
        assert!(cut.left_out.is_empty() && cut.error <= chord, "{chord}: {} {:?}", cut.error, cut.left_out);
        let points = cut.mesh.points();
        let of = |f: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|k: usize| points[f[k] as usize]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        let area = cut.mesh.faces().map(of).sum::<f64>();
        assert!((area / exact - 1.0).abs() < 20.0 * chord, "{chord}: {area}");
    }
}

/// What is told of a quantity that was asked for is that of the solid as it came out: an edit may give its faces other control vertices.
#[test]
fn what_was_asked_is_told_of_the_solid_that_came_out() {
    let registry = loftsman::registry();
    let operation = registry.find_operation("edit", "op").unwrap();
    for from in [Point::origin(), Point::new(50.0, -20.0, 7.0)] {
        let block = Brep::block(from, from + Vector::new(2.0, 3.0, 4.0)).unwrap();
        let mut scene = Scene::new();
        scene.add(Object::new("block", block.into())).unwrap();
        let fields = json!({ "faces": [1], "constraints": [{ "kind": "volume", "scale": 1.1 }] });
        let parameters = Parameters::new(fields, "step[0]").unwrap();
        let report = operation.apply(&mut scene, &parameters, &Context::quiet(registry)).unwrap();
        let Geometry::Brep(brep) = scene.object("block").unwrap().geometry() else { panic!("a brep") };
        let volume = volume_of(brep).unwrap();
        assert!((volume - 26.4).abs() < 1e-8, "{volume}");
        let told = report.asked[0].value;
        let near = |value: Option<f64>, wanted: f64| value.is_some_and(|x| (x - wanted).abs() < 1e-8);
        assert!(near(told.before, 24.0) && near(told.after, 26.4), "{told:?}");
    }
}
