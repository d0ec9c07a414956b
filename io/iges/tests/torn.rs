//! Boundaries whose curves in space are torn or missing, while those in parameters close.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at what should not be")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::common::{entity, file, read};
use loftsman_kernel::brep::{CurveForm, Flaw};
use loftsman_kernel::plugin::{FormatError, ReadReport};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Trimmed;

/// The corners of a triangle on a cylinder of radius 2 and height 3: shares of the height, and angles.
const CORNERS: [[f64; 2]; 3] = [[0.1, 0.5], [0.9, 2.0], [0.3, 5.9]];

/// The cylinder within that triangle, whose sides are straight in the parameters. There corner 1 is off by `torn[0]`, and the second of the curves in space, if there are any,
/// by `torn[1]`.
fn triangle(from: f64, torn: [f64; 2], with_model: bool) -> Result<(Scene, ReadReport), FormatError> {
    let space =
        |[share, angle]: [f64; 2]| format!("{},{},{}", 2.0 * angle.cos(), 2.0 * angle.sin(), 3.0 * share);
    let mut texts = vec![
        "110,0.,0.,0.,0.,0.,1.;".to_owned(),
        "110,2.,0.,0.,2.,0.,3.;".to_owned(),
        format!("120,1,3,{from},{};", from + TAU),
    ];
    for k in 0..3 {
        let (a, b) = (CORNERS[k], CORNERS[(k + 1) % 3]);
        let off = if k == 1 { torn[0] } else { 0.0 };
        texts.push(format!("110,{},{},0.,{},{},0.;", a[0] + off, a[1], b[0], b[1]));
    }
    texts.push("102,3,7,9,11;".to_owned());
    if with_model {
        for k in 0..3 {
            let (mut a, b) = (CORNERS[k], CORNERS[(k + 1) % 3]);
            if k == 1 {
                a[0] += torn[1] / 3.0;
            }
            texts.push(format!("110,{},{};", space(a), space(b)));
        }
        texts.push("102,3,15,17,19;".to_owned());
    }
    let (model, boundary) = if with_model { (21, 23) } else { (0, 15) };
    texts.push(format!("142,0,5,13,{model},3;"));
    texts.push(format!("144,5,1,0,{boundary};"));
    let entities: Vec<_> = texts.iter().map(|text| entity(0, text)).collect();
    read(&file(&entities))
}

/// All that is told of a fate.
fn told(reasons: &BTreeMap<String, usize>) -> String {
    reasons.keys().map(|reason| format!("{reason}\n")).collect()
}

fn trimmed(scene: &Scene) -> &Trimmed {
    match scene.objects() {
        [object] => match object.geometry() {
            Geometry::Trimmed(trimmed) => trimmed,
            other => panic!("{}", other.kind()),
        },
        other => panic!("{} objects", other.len()),
    }
}

/// Along each side the share of the height is linear in the angle: within 1e-9 of the size, at any speed of the spline.
fn check_sides(trimmed: &Trimmed) {
    let [region] = trimmed.regions() else { panic!("{}", trimmed.regions().len()) };
    assert_eq!((region.outer.len(), region.holes.len()), (3, 0));
    for (k, side) in region.outer.iter().enumerate() {
        let ([s, a], [t, b]) = (CORNERS[k], CORNERS[(k + 1) % 3]);
        let (from, to) = side.range();
        for step in 0..=500 {
            let at = side.curve().point(from + (to - from) * (f64::from(step) / 500.0)).unwrap();
            let p = trimmed.surface().point(at.x, at.y).unwrap();
            let angle = p.y.atan2(p.x).rem_euclid(TAU);
            let z = 3.0 * (s + (t - s) * (angle - a) / (b - a));
            assert!((p.z - z).abs() < 2e-8, "side {k}, {step}: {} of {z}", p.z);
        }
    }
}

#[test]
fn boundaries_that_are_torn_in_space_are_taken_from_parameters() {
    // Angles that the file counts from 0, and from where it says.
    for from in [0.0, 0.25] {
        let (scene, report) = triangle(from, [0.0, 0.1], true).unwrap();
        check_sides(trimmed(&scene));
        assert!(report.left_out.is_empty(), "{report:?}");
        let told = told(&report.approximated);
        assert!(told.contains("torn in space, by 0.1 mm, but closes in the parameters"), "{told:?}");
    }
}

#[test]
fn boundaries_askew_over_angles_need_no_curves_in_space() {
    let (scene, report) = triangle(0.0, [0.0; 2], false).unwrap();
    check_sides(trimmed(&scene));
    let told = told(&report.approximated);
    assert!(told.contains("in the parameters of the surface only"), "{told:?}");
}

#[test]
fn boundaries_that_are_torn_both_ways_are_left_out() {
    let told = triangle(0.0, [0.05, 0.1], true).unwrap_err().to_string();
    assert!(told.contains("the boundary is torn before curve 2 of 3"), "{told}");
}

/// OpenCASCADE 8 writes a whole ellipse turned about its centre by the angle that it starts at: its ends are off the seam, which the boundary runs along, too.
#[test]
fn ellipses_that_opencascade_turned_are_taken_from_parameters() {
    for (name, gap) in [("turned_bore", "0.00462 mm"), ("turned_drill", "0.2409 mm")] {
        let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/made/");
        let text = std::fs::read_to_string(format!("{data}{name}.igs")).unwrap();
        let (scene, report) = read(&text).unwrap();
        assert_eq!(trimmed(&scene).loops().count(), 1, "{name}");
        let told = told(&report.approximated);
        assert!(told.contains(&format!("torn in space, by {gap}")), "{name}: {told}");
    }
}

/// The tip of a cone beyond a slanted plane: OpenCASCADE turned the ellipse between them about its centre. It is turned back, ends at its vertex and lies on both faces.
#[test]
fn whole_ellipses_of_solids_are_turned_back() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/made/turned_ellipse.igs");
    let (scene, report) = read(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert!(report.notes.iter().any(|note| note.contains("it is turned back")), "{report:?}");
    let brep = scene.objects().iter().find_map(|object| match object.geometry() {
        Geometry::Brep(brep) => Some(brep),
        _ => None,
    });
    let brep = brep.unwrap();
    assert_eq!(brep.solids().len(), 1, "{report:?}");
    let forms: Vec<CurveForm> = (0..brep.edge_count()).map(|edge| brep.edge(edge).unwrap().form).collect();
    assert!(forms.iter().any(|form| matches!(form, CurveForm::Ellipse { .. })), "{forms:?}");
    let off = brep.flaws(0.0).unwrap().iter().map(Flaw::distance).fold(0.0, f64::max);
    assert!(off < 2e-6, "{off}: {:?}", brep.flaws(0.0));
}
