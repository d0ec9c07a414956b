//! The kind of shape "subdivision": what it writes it reads, its triangles are near.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use std::sync::Arc;

use loftsman_kernel::conformance::kind_conformance;
use loftsman_kernel::plugin::{
    Chord, DeclaredShape, Drawn, Fineness, KindOf, Parameters, Plugin, Registry, ShapeKind, Splines,
};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_subdivision::{BoundaryRule, Subdivision, SubdivisionSurface};

#[test]
fn it_is_a_kind() {
    let cube =
        crate::shapes::cube().with_crease(0, 1, 2.5).unwrap().with_crease(1, 3, f64::INFINITY).unwrap();
    let cages = [
        cube.with_corner(7, 1.25).unwrap().with_hole(4).unwrap(),
        crate::shapes::grid(3, 4, [false, false], 0.2),
        crate::shapes::fan(3, 5, true, 0.1).with_boundary(BoundaryRule::EdgeOnly),
    ];
    let samples: Vec<Box<dyn Shape>> = cages
        .into_iter()
        .map(|cage| Box::new(SubdivisionSurface::new(cage).unwrap()) as Box<dyn Shape>)
        .collect();
    let kind: Arc<dyn ShapeKind> = Arc::new(KindOf::<SubdivisionSurface>::default());
    let verdict = kind_conformance(&kind, &samples);
    assert!(verdict.passed(), "{}", verdict.to_string().chars().take(3000).collect::<String>());
}

#[test]
fn fields_come_back_to_the_last_bit() {
    for (name, cage) in crate::shapes::all() {
        let surface = SubdivisionSurface::with_depth(cage, 5).unwrap();
        let fields = surface.fields();
        let text = serde_json::Value::Object(fields.clone().into_map()).to_string();
        let read = Parameters::new(serde_json::from_str(&text).unwrap(), "shape").unwrap();
        let again = SubdivisionSurface::from_parameters(&read).unwrap();
        assert_eq!(again.fields().into_map(), fields.into_map(), "{name}");
        let bits = |s: &SubdivisionSurface| -> Vec<u64> {
            s.control_vertices().iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits).collect()
        };
        assert_eq!(bits(&surface), bits(&again), "{name}");
    }
}

#[test]
fn what_is_wrong_has_its_place() {
    let good = SubdivisionSurface::new(crate::shapes::cube()).unwrap().fields();
    for (field, value, words) in [
        ("creases", serde_json::json!([[0, 1, 1.0], [0, 7, 1.0]]), "creases[1]: there is no edge"),
        ("creases", serde_json::json!([[0, 1, -1.0]]), "creases[0]"),
        ("creases", serde_json::json!([[0, 1, 1.0], [1, 0, 2.0]]), "creases[1]: the sharpness of the edge"),
        ("corners", serde_json::json!([[0, 1.0], [0, 2.0]]), "said twice, as 1 and as 2"),
        ("holes", serde_json::json!([0, 1, 2, 3, 4, 5]), "is a hole, as are all others"),
        ("corners", serde_json::json!([[99, 1.0]]), "corners[0]"),
        ("corners", serde_json::json!([[1]]), "corners[0]"),
        ("faces", serde_json::json!([[0, 1, "a"]]), "faces[0]"),
        ("holes", serde_json::json!([77]), "holes"),
        ("depth", serde_json::json!(25), "depth"),
        ("scheme", serde_json::json!("loop"), "scheme"),
        ("boundary", serde_json::json!("none"), "boundary"),
    ] {
        let error =
            SubdivisionSurface::from_parameters(&good.clone().with(field, value)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn it_is_registered() {
    let mut registry = Registry::new();
    Subdivision.register(&mut registry);
    let torus = SubdivisionSurface::new(crate::shapes::grid(5, 6, [true, true], 0.2)).unwrap();
    let Some(Splines::Surfaces(patches)) = torus.splines() else { panic!("a torus is all splines") };
    assert_eq!(patches.len(), 1, "all faces are one spline");
    assert!(SubdivisionSurface::new(crate::shapes::cube()).unwrap().splines().is_none());
    let fine = Fineness { chord: Chord::Relative(1e-4), ..Fineness::default() };
    let faceted = SubdivisionSurface::tessellate(&[&torus], &fine).unwrap();
    assert!(faceted.certified && faceted.error <= faceted.tolerance);
    let Drawn::Mesh(mesh) = &faceted.drawn else { panic!("it is a surface") };
    assert_eq!(mesh.normals.values().len(), mesh.points().len());
}

/// Points of a mesh are where it says that they are on the surface.
#[test]
fn points_of_a_tessellation_know_their_places() {
    let fine = Fineness { chord: Chord::Relative(2e-2), angle: 1.0 };
    let mut count = 0;
    for (name, cage) in crate::shapes::all().into_iter().step_by(5) {
        let surface = SubdivisionSurface::new(cage).unwrap();
        let Ok(faceted) = SubdivisionSurface::tessellate(&[&surface], &fine) else { continue };
        count += 1;
        let points = faceted.drawn.points();
        assert_eq!(points.len(), faceted.places.len(), "{name}");
        let Drawn::Mesh(mesh) = &faceted.drawn else { panic!("it is a surface") };
        let mut used = mesh.corners().to_vec();
        used.sort_unstable();
        used.dedup();
        for k in used.into_iter().map(|k| k as usize) {
            let there = surface.value(faceted.places[k], Derivative::POSITION).unwrap();
            let off = (points[k].coords - there).norm();
            assert!(off < 1e-12, "{name}: point {k} at {} is {off:e} away", faceted.places[k]);
        }
        // And so are their corners, all three of a triangle on one face.
        assert_eq!(mesh.corners().len(), faceted.corners.len(), "{name}");
        for (corners, at) in mesh.faces().zip(faceted.corners.chunks(3)) {
            let face = |at: &Location| if let Location::Face(face, ..) = at { *face } else { panic!("{at}") };
            assert!(at.iter().all(|other| face(other) == face(&at[0])), "{name}: {at:?}");
            for (&k, &at) in corners.iter().zip(at) {
                let off =
                    (points[k as usize].coords - surface.value(at, Derivative::POSITION).unwrap()).norm();
                assert!(off < 1e-12, "{name}: a corner at {at} is {off:e} away");
            }
        }
    }
    assert!(count > 8, "{count}");
}
