//! Triangles are where the surface needs them, and nowhere does anything gape.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use std::collections::BTreeMap;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, DeclaredShape, Drawn, Faceted, Fineness};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::{Cage, SubdivisionSurface};

fn tessellated(states: &[Cage], fineness: &Fineness) -> Faceted {
    let states: Vec<_> = states.iter().map(|c| SubdivisionSurface::new(c.clone()).unwrap()).collect();
    SubdivisionSurface::tessellate(&states.iter().collect::<Vec<_>>(), fineness).unwrap()
}

fn mesh(faceted: &Faceted) -> &Mesh {
    match &faceted.drawn {
        Drawn::Mesh(mesh) => mesh,
        Drawn::Line(_) => panic!("a surface is no line"),
    }
}

/// Euler's characteristic of some faces.
fn euler(points: usize, edges: usize, faces: usize) -> i64 {
    points as i64 - edges as i64 + faces as i64
}

/// Every edge is run once each way, or once where the surface ends; what is left is how often that is, and Euler's characteristic. A vertex in
/// the middle of another triangle's edge would leave edges that are run once.
fn edges(mesh: &Mesh, name: &str) -> (usize, i64) {
    let mut runs: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for face in mesh.faces() {
        for k in 0..3 {
            *runs.entry((face[k], face[(k + 1) % 3])).or_default() += 1;
        }
    }
    assert!(runs.values().all(|&count| count == 1), "{name}: an edge is run twice the same way");
    let single = runs.keys().filter(|&&(a, b)| !runs.contains_key(&(b, a))).count();
    let count = (runs.len() + single) / 2;
    (single, euler(mesh.points().len(), count, mesh.faces().count()))
}

/// Cubes with a corner, or the edges at one, that are sharp to a finite degree: what is refined is the corner.
#[test]
fn a_semi_sharp_corner_takes_few_triangles() {
    for sharpness in [0.5, 1.0, 1.7, 2.0, 2.5, 3.5, 6.0] {
        let corner = crate::shapes::cube().with_corner(7, sharpness).unwrap();
        let at = [3, 5, 6];
        let edges_there =
            at.iter().fold(crate::shapes::cube(), |c, &v| c.with_crease(7, v, sharpness).unwrap());
        for (name, cage) in [("corner", corner), ("edges", edges_there)] {
            let name = format!("{name} {sharpness}");
            let fineness = Fineness { chord: Chord::Absolute(0.02), ..Fineness::default() };
            let faceted = tessellated(&[cage], &fineness);
            let count = mesh(&faceted).faces().count();
            assert!(count < 3000, "{name}: {count}");
            assert!(faceted.certified && faceted.error <= 0.02, "{name}");
            assert_eq!(edges(mesh(&faceted), &name), (0, 2), "{name}");
        }
    }
}

/// Whatever cages: meshes have edges where the surface ends and nowhere else, and hang together as the cage does.
#[test]
fn nothing_gapes() {
    let (mut closed, mut open) = (0, 0);
    for (name, cage) in crate::shapes::all().into_iter().step_by(3) {
        let topology = cage.topology();
        let rim = (0..topology.edge_count()).filter(|&e| topology.is_boundary_edge(e)).count();
        let own = euler(topology.vertex_count(), topology.edge_count(), topology.face_count());
        for fineness in [
            Fineness { chord: Chord::Relative(5e-3), angle: 10.0 },
            Fineness { chord: Chord::Relative(3e-2), angle: 0.4 },
        ] {
            let faceted = tessellated(std::slice::from_ref(&cage), &fineness);
            let (single, of_mesh) = edges(mesh(&faceted), &name);
            assert_eq!(of_mesh, own, "{name}");
            assert!(if rim == 0 { single == 0 } else { single >= rim }, "{name}: {single} of {rim}");
            if rim == 0 { closed += 1 } else { open += 1 }
        }
    }
    assert!(closed >= 20 && open >= 40, "{closed} {open}");
}

/// A plane with a bump: its triangles are at the bump.
#[test]
fn a_bump_takes_triangles_at_the_bump() {
    let mut cage = crate::shapes::grid(40, 40, [false, false], 0.0);
    let middle = 20 * 40 + 20;
    cage.points_mut()[middle].z = 1.5;
    let fineness = Fineness { chord: Chord::Absolute(2e-3), angle: 0.2 };
    let faceted = tessellated(&[cage], &fineness);
    let (far, near): (Vec<_>, Vec<_>) = mesh(&faceted)
        .faces()
        .map(|f| mesh(&faceted).points()[f[0] as usize])
        .partition(|p| (p - Point::new(20.0, 20.0, p.z)).norm() > 5.0);
    assert!(far.len() < 2 * 39 * 39 && near.len() > 1000, "{} far, {} near", far.len(), near.len());
    assert_eq!(edges(mesh(&faceted), "bump").1, 1);
}

/// Triangles of several states are the same ones, as fine as the worst needs.
#[test]
fn states_have_the_same_triangles() {
    let cage = crate::shapes::double_fan(5, 0.1).with_crease(0, 2, 1.5).unwrap();
    let mut pulled = cage.clone();
    pulled.points_mut()[0] += Vector::new(0.5, 0.0, 2.0);
    let fineness = Fineness { chord: Chord::Absolute(0.01), angle: 0.5 };
    let both = tessellated(&[cage.clone(), pulled.clone()], &fineness);
    let alone = tessellated(std::slice::from_ref(&cage), &fineness);
    assert!(mesh(&both).faces().count() > mesh(&alone).faces().count());
    assert!(both.certified && both.error <= 0.01 && both.states.len() == 2);
    assert_eq!(edges(mesh(&both), "both"), (0, 2));
    for (state, cage) in [cage, pulled].into_iter().enumerate() {
        let surface = SubdivisionSurface::new(cage).unwrap();
        for (at, p) in both.places.iter().zip(&both.states[state]) {
            let there = surface.value(*at, Derivative::POSITION).unwrap();
            assert!((p.coords - there).norm() < 1e-12, "{at}");
            assert!(matches!(at, Location::Face(..)));
        }
    }
}

/// The same bytes every time, whatever runs beside it.
#[test]
fn the_same_every_time() {
    let cage = crate::shapes::cube().with_corner(7, 2.5).unwrap().with_hole(2).unwrap();
    let fineness = Fineness { chord: Chord::Absolute(4e-3), ..Fineness::default() };
    let first = tessellated(std::slice::from_ref(&cage), &fineness);
    for _ in 0..3 {
        assert_eq!(tessellated(std::slice::from_ref(&cage), &fineness), first);
    }
    assert_eq!(edges(mesh(&first), "a hole").1, 1);
}

/// Surfaces whose cage's vertices have all the same limit have an extent all the same; those that are one point are refused.
#[test]
fn limits_that_are_one_point() {
    let fineness = Fineness { chord: Chord::Relative(4e-3), angle: 10.0 };
    let pillow = tessellated(&[crate::shapes::pillow(3)], &fineness);
    assert!(pillow.certified && edges(mesh(&pillow), "pillow") == (0, 2));
    let mut cage = crate::shapes::cube();
    cage.points_mut().fill(Point::new(1.0, 2.0, 3.0));
    let surface = SubdivisionSurface::new(cage).unwrap();
    let error = SubdivisionSurface::tessellate(&[&surface], &fineness).unwrap_err().to_string();
    assert!(error.contains("one point"), "{error}");
}
