//! Areas and volumes of the solids of real STEP files against OpenCASCADE's.

use std::collections::BTreeMap;
use std::path::Path;

use loftsman::area_volume::{surface_area, volume_of};
use loftsman::kernel::brep::Brep;
use loftsman::kernel::functional::{Shapes, value_of};
use loftsman::kernel::scene::Geometry;

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
    let (mut files, mut solids) = (0, 0);
    for (name, told) in &told {
        let scene = loftsman::read_scene(root.join("data/step").join(name)).unwrap();
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
                near(area, told.area, told.unsure[0] + off)
                    && near(volume, told.volume, told.unsure[1] + off * extent(brep) * unit)
            };
            assert!(
                told.solids.iter().any(same),
                "{name} \"{}\": {area:e} {volume:e} of {:?}, edges are off by {off:e}",
                object.name(),
                told.solids
            );
            // What edges are off is little beside the whole, or nothing would be tested.
            assert!(off <= 1e-3 * area, "{name}: {off:e} of {area:e}");
            solids += 1;
        }
        if told.solids.is_empty() {
            assert!(
                (loose - told.area).abs() <= EXACT * told.area + told.unsure + off,
                "{name}: {loose:e} {:e} {off:e}",
                told.area
            );
        }
        files += 1;
    }
    assert!(files >= 9 && solids >= 12, "{files} files, {solids} solids");
}
