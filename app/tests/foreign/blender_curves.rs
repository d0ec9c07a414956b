//! Curves in OBJ: Blender opens them as its own NURBS curves and draws exactly ours.

use loftsman_kernel::spline::Curve;
use loftsman_tests::curves::{FAMILIES, curve, curve_json, document};
use loftsman_tests::oracle::{Oracle, list, number, object, position};
use serde_json::{Value, json};

use crate::{apart, save};

use crate::LOFTSMAN;

/// Blender draws a curve in Bézier form with `resolution` steps a segment, evenly in each segment's parameter, so
/// that its point `k` is ours at a known parameter.
pub(crate) fn check_drawn(name: &str, ours: &Curve, report: &Value, tolerance: f64) {
    let seen = object(report, name);
    assert_eq!(seen["type"], "CURVE", "{name}");
    assert_eq!(list(seen, "splines").len(), 1, "{name}: one spline");
    let spline = &list(seen, "splines")[0];
    assert_eq!(spline["type"], "NURBS", "{name}");
    assert_eq!(number(spline, "order_u"), ours.degree() as f64 + 1.0, "{name}: its order");
    let weighted = list(spline, "weights").iter().any(|w| w.as_f64() != Some(1.0));
    assert_eq!(weighted, ours.weights().is_some(), "{name}: whether it has weights");

    let drawn: Vec<_> = list(seen, "evaluated/points").iter().map(position).collect();
    let breakpoints = ours.space().breakpoints();
    let steps = number(spline, "resolution_u") as usize;
    let wanted = steps * (breakpoints.len() - 1) + usize::from(spline["cyclic_u"] == false);
    assert_eq!(drawn.len(), wanted, "{name}: the points Blender draws");
    let size = ours.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    for (k, &theirs) in drawn.iter().enumerate() {
        let span = (k / steps).min(breakpoints.len() - 2);
        let t = (k - span * steps) as f64 / steps as f64;
        let u = breakpoints[span] + t * (breakpoints[span + 1] - breakpoints[span]);
        let p = ours.point(u).unwrap();
        let error = apart(theirs, [p.x, p.y, p.z]);
        assert!(error <= tolerance * size, "{name} at {u}: {theirs:?} is {error:e} from {p:?}");
    }
}

/// Writes the curves as OBJ through the program, and has Blender draw them.
fn through_blender(batches: &[Vec<(String, Curve)>]) {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<_> = batches
        .iter()
        .enumerate()
        .map(|(i, batch)| {
            let objects: Vec<Value> =
                batch.iter().map(|(name, c)| json!({ "name": name, "curve": curve_json(c) })).collect();
            let native = format!("{i}.loft.json");
            save(folder.path(), &native, &document("m", &objects));
            LOFTSMAN.done(folder.path(), &["convert", &native, &format!("{i}.obj")]);
            folder.path().join(format!("{i}.obj"))
        })
        .collect();
    let Some(reports) = Oracle::Blender.ask(&files, &["--eval"]) else { return };
    for (report, batch) in reports.iter().zip(batches) {
        assert_eq!(list(report, "objects").len(), batch.len(), "as many objects as curves");
        for (name, ours) in batch {
            check_drawn(name, ours, report, 1e-5);
        }
    }
}

#[test]
fn blender_draws_every_family_of_curves_exactly() {
    let families = FAMILIES.iter().map(|family| {
        let each = (1..=5).flat_map(|degree| [(degree, false), (degree, true)]);
        each.map(|(degree, rational)| {
            let name = format!("{family}-{degree}{}", if rational { "-rational" } else { "" });
            (name, curve(family, degree, rational, 2.0))
        })
        .collect()
    });
    through_blender(&families.collect::<Vec<_>>());
}

#[test]
fn blender_draws_curves_of_any_size() {
    // Blender computes in single precision: 1e-5 of the size holds at every size it can show. Its report is
    // rounded to seven decimals, which bounds how small a curve can be checked.
    let sizes = [0.5, 1e3, 1e6].map(|size| vec![(format!("size {size}"), curve("uneven", 3, true, size))]);
    through_blender(&sizes);
}
