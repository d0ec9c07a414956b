//! Cages and solids that more than one bench takes.

use std::path::Path;

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::plugin::{Format, Memory, ReadOptions};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_step::Step;
use loftsman_subdivision::Cage;

use crate::inputs::{lattice, scaled};

/// Files of tests/data/step, each of one solid.
pub const SOLIDS: [&str; 3] = ["NIST_MBE_PMI_1", "NIST_MBE_PMI_3", "NIST_MBE_PMI_11"];

fn bytes(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../tests/data/step/{name}.stp"));
    std::fs::read(path).expect("a bundled file")
}

/// One of these files with all that it holds so many times, entities numbered on, as `peers/solids.py` makes it.
///
/// # Panics
/// When the file is not there.
pub fn repeated(name: &str, times: usize) -> Vec<u8> {
    let text = String::from_utf8_lossy(&bytes(name)).into_owned();
    let (head, rest) = text.split_once("DATA;").expect("a section of data");
    let (body, tail) = rest.split_once("ENDSEC;").expect("its end");
    let pieces: Vec<(usize, &str)> = body
        .split('#')
        .skip(1)
        .map(|piece| {
            let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap_or(piece.len());
            (piece[..digits].parse().expect("a number"), &piece[digits..])
        })
        .collect();
    let most = pieces.iter().map(|(number, _)| *number).max().unwrap_or(0);
    let mut all = format!("{head}DATA;\n");
    for k in 0..times {
        pieces.iter().for_each(|(number, text)| all.push_str(&format!("#{}{text}", number + k * most)));
    }
    (all + "ENDSEC;" + tail).into_bytes()
}

/// What is read of a STEP file.
///
/// # Panics
/// When it cannot be read.
pub fn read(bytes: Vec<u8>) -> Scene {
    Step.read(&Memory::new("a file", bytes), &ReadOptions::default()).expect("it can be read").0
}

/// The solid of one of these files.
///
/// # Panics
/// When the file is not there.
pub fn solid(name: &str) -> Brep {
    let scene = read(bytes(name));
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
