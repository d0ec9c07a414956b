//! Cages and solids that more than one bench takes.

use std::path::Path;

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions};
use loftsman_kernel::scene::Geometry;
use loftsman_step::Step;
use loftsman_subdivision::Cage;

use crate::inputs::{lattice, scaled};

/// Files of tests/data/step, each of one solid.
pub const SOLIDS: [&str; 3] = ["NIST_MBE_PMI_1", "NIST_MBE_PMI_3", "NIST_MBE_PMI_11"];

/// The solid of one of these files.
///
/// # Panics
/// When the file is not there.
pub fn solid(name: &str) -> Brep {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../tests/data/step/{name}.stp"));
    let bytes = std::fs::read(path).expect("a bundled file");
    let (scene, _) = Step.read(&Memory::new(name, bytes), &ReadOptions::default()).expect("it can be read");
    let found = scene.objects().iter().find_map(|object| match object.geometry() {
        Geometry::Brep(brep) => Some(brep.clone()),
        _ => None,
    });
    found.expect("a solid")
}

/// A thousandth of the diagonal of the box of the vertices.
pub fn tolerance(brep: &Brep) -> f64 {
    let points = brep.vertices();
    let first = points.first().copied().unwrap_or_default();
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    1e-3 * (high - low).norm()
}

/// The skin of a [`lattice`] as a cage, in a cube of edge 1.
///
/// # Panics
/// When it is not closed.
pub fn cage(cells: i32, hole: std::ops::Range<i32>) -> Cage {
    let (points, faces) = lattice(cells, hole);
    Cage::new(scaled(&points, cells).map(Point::from).collect(), &faces).expect("a closed cage")
}
