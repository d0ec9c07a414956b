//! The same cages as OpenSubdiv's: refined points, limit positions and tangent planes.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::collections::BTreeMap;

use loftsman_kernel::Point;
use loftsman_kernel::shape::Stencil;
use loftsman_subdivision::catmull_clark::{Refinement, limit_stencils, refine, sectors};
use loftsman_subdivision::{BoundaryRule, Cage};
use serde_json::Value;

fn cage(value: &Value) -> Cage {
    let faces: Vec<Vec<usize>> = serde_json::from_value(value["faces"].clone()).unwrap();
    let rule = match value["boundary"].as_str().unwrap() {
        "edge-only" => BoundaryRule::EdgeOnly,
        "edge-and-corner" => BoundaryRule::EdgeAndCorner,
        other => unreachable!("{other}"),
    };
    let mut cage = Cage::new(points(&value["points"]), &faces).unwrap().with_boundary(rule);
    for crease in value["creases"].as_array().unwrap() {
        let [a, b] = [0, 1].map(|k| crease[k].as_u64().unwrap() as usize);
        cage = cage.with_crease(a, b, crease[2].as_f64().unwrap()).unwrap();
    }
    for corner in value["corners"].as_array().unwrap() {
        cage = cage.with_corner(corner[0].as_u64().unwrap() as usize, corner[1].as_f64().unwrap()).unwrap();
    }
    cage
}

fn points(value: &Value) -> Vec<Point> {
    let points: Vec<[f64; 3]> = serde_json::from_value(value.clone()).unwrap();
    points.into_iter().map(Point::from).collect()
}

/// A row, dense.
fn dense(pairs: impl Iterator<Item = (usize, f64)>, count: usize) -> Vec<f64> {
    let mut row = vec![0.0; count];
    pairs.for_each(|(v, c)| row[v] += c);
    row
}

fn given(value: &Value, count: usize) -> Vec<f64> {
    let pairs: Vec<(usize, f64)> = serde_json::from_value(value.clone()).unwrap();
    dense(pairs.into_iter(), count)
}

/// How far a row is from the plane of two others, relative to its length.
fn off(row: &[f64], plane: &[Vec<f64>; 2]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let [a, b] = plane;
    let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
    let (ra, rb) = (dot(row, a), dot(row, b));
    if bb == 0.0 {
        return (1.0 - ra * ra / (aa * dot(row, row))).max(0.0).sqrt();
    }
    let determinant = aa * bb - ab * ab;
    let (s, t) = ((ra * bb - rb * ab) / determinant, (rb * aa - ra * ab) / determinant);
    let rest: Vec<f64> = row.iter().zip(a).zip(b).map(|((r, x), y)| r - s * x - t * y).collect();
    (dot(&rest, &rest) / dot(row, row)).sqrt()
}

#[test]
fn cages_are_refined_as_opensubdiv_does() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/opensubdiv.json");
    let golden: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let (mut refined, mut planes, mut both, mut of_rule) = (0, 0, 0, BTreeMap::new());
    let cages = golden["cages"].as_array().unwrap();
    assert_eq!(cages.len(), 200);
    for value in cages {
        let (cage, name) = (cage(value), &value["name"]);
        let mut fine = cage.clone();
        for level in value["refined"].as_array().into_iter().flatten() {
            fine = refine(&fine).unwrap();
            // Numbered otherwise: every point is there, and as many.
            let theirs = points(&level["points"]);
            assert_eq!(theirs.len(), fine.points().len(), "{name}");
            for p in &theirs {
                let near = fine.points().iter().map(|q| (p - q).norm()).fold(f64::MAX, f64::min);
                assert!(near < 1e-13, "{name}: {near:e}");
            }
            refined += 1;
        }
        let count = cage.points().len();
        for limit in value["limits"].as_array().unwrap() {
            let v = limit["vertex"].as_u64().unwrap() as usize;
            let what = format!("{name}, vertex {v}, {}", limit["rule"]);
            let ours: Vec<_> =
                (0..sectors(&cage, v).unwrap()).map(|s| limit_stencils(&cage, v, s).unwrap()).collect();
            // Every sector has the same position.
            for ours in &ours {
                let row = dense(ours.position.iter(), count);
                for (a, b) in row.iter().zip(given(&limit["position"], count)) {
                    assert!((a - b).abs() < 1e-13, "{what}: {a} {b}");
                }
            }
            *of_rule.entry(limit["rule"].as_str().unwrap()).or_insert(0) += 1;
            let theirs = &limit["tangents"];
            if theirs.as_array().is_none_or(|t| t.len() != 2) {
                continue;
            }
            // A corner with smooth edges has no tangent plane: what OpenSubdiv gives are edges of its last level, whatever that is.
            let levels =
                if limit["rule"] == "corner" { value["levels"].as_u64().unwrap() as usize } else { 0 };
            let refinement = Refinement::new(cage.clone(), levels).unwrap();
            let last = refinement.finest();
            let ours: Vec<_> =
                (0..sectors(last, v).unwrap()).map(|s| limit_stencils(last, v, s).unwrap()).collect();
            let back = |t: &Stencil| -> Vec<(usize, f64)> {
                let rows = t.iter().map(|(v, c)| refinement.stencil(levels, v).unwrap().scaled(c));
                rows.flat_map(|row| row.iter().collect::<Vec<_>>()).collect()
            };
            // Theirs are those of the sector of the first face. Each of theirs in our plane, and where they are two directions (those
            // found by powers of the matrix may be one) each of ours in theirs.
            let plane = ours[0].tangents.each_ref().map(|t| dense(back(t).into_iter(), count));
            let theirs = [0, 1].map(|k| given(&theirs[k], count));
            let apart = off(&theirs[0], &[theirs[1].clone(), vec![0.0; count]]);
            let mut best = [0, 1].map(|k| off(&theirs[k], &plane)).into_iter().fold(0.0, f64::max);
            if apart > 1e-3 {
                best = plane.iter().map(|row| off(row, &theirs)).fold(best, f64::max);
                both += 1;
            }
            assert!(best < 1e-12, "{what}: {best:e}");
            planes += 1;
        }
    }
    assert!(refined >= 80 && planes == 942 && both >= 900, "{refined} {planes} {both}");
    assert_eq!(of_rule, BTreeMap::from([("corner", 127), ("crease", 318), ("dart", 118), ("smooth", 424)]));
}
