//! Areas and volumes of families of shapes against refinement by hand, and the bounds of what they leave out.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_area_volume::{surface_area_of, volume_of};
use loftsman_kernel::shape::Shape;
use loftsman_subdivision::doo_sabin::DooSabinSurface;
use loftsman_subdivision::{LeftOut, SubdivisionSurface};

use crate::shapes::plain::Plain;
use crate::shapes::wild;

/// Area and volume, and the bounds of what they leave out.
struct Measured {
    is: [f64; 2],
    left: [f64; 2],
}

fn measured(shape: &dyn Shape, left: LeftOut, is_closed: bool) -> Measured {
    let volume = if is_closed { volume_of(shape).unwrap() } else { 0.0 };
    Measured { is: [surface_area_of(shape).unwrap(), volume], left: [left.area, left.volume] }
}

/// A measure by meshes that come nearer to the surface level by level, and by how much it may be off.
///
/// Regular parts go with a quarter a level, which is taken out; what is left goes by `λ² μ` round an extraordinary point and `λ²` at a corner, less than two
/// thirds: less than twice its last change, then. A change may be small by chance, two of them are not.
fn extrapolated(levels: &[f64]) -> [f64; 2] {
    let without: Vec<f64> = levels.windows(2).map(|pair| pair[1] + (pair[1] - pair[0]) / 3.0).collect();
    let [a, b, c] = without[without.len() - 3..] else { unreachable!() };
    [c, 2.0 * (c - b).abs().max((b - a).abs() / 4.0)]
}

/// What is compared of a family.
struct Family {
    is_closed: bool,
    /// How many times what is missing the bound of the area may be at most.
    most: f64,
    /// To what part refinement by hand has to tell a measure.
    known: f64,
    refine: fn(&Plain) -> Plain,
    at_depth: fn(&Plain, u32, bool) -> Measured,
}

fn catmull_clark(plain: &Plain, depth: u32, is_closed: bool) -> Measured {
    let surface = SubdivisionSurface::with_depth(plain.cage().unwrap(), depth).unwrap();
    measured(&surface, surface.left_out().unwrap(), is_closed)
}

fn doo_sabin(plain: &Plain, depth: u32, is_closed: bool) -> Measured {
    let surface = DooSabinSurface::with_depth(plain.cage().unwrap(), depth).unwrap();
    measured(&surface, surface.left_out().unwrap(), is_closed)
}

const DEEPEST: u32 = 24;
const NAMES: [&str; 2] = ["area", "volume"];

/// The true values are those of the deepest cells, which refinement by hand comes to; at every depth what is missing is less than the bound, and the bound is no
/// more than so many times what is missing of an area, and `4^-depth` of a volume.
fn holds(name: &str, plain: &Plain, family: &Family) {
    let mut mesh = plain.clone();
    let mut levels = Vec::new();
    for _ in 0..6 {
        mesh = (family.refine)(&mesh);
        levels.push(mesh.measures());
    }
    let measures = if family.is_closed { 0..2 } else { 0..1 };
    let deep = (family.at_depth)(plain, DEEPEST, family.is_closed);
    let by_default = (family.at_depth)(plain, 8, family.is_closed);
    for k in measures.clone() {
        let [by_hand, slack] = extrapolated(&levels.iter().map(|level| level[k]).collect::<Vec<_>>());
        let size = deep.is[k].abs();
        assert!(slack < family.known * size, "{name}, {}: {slack:e} of {size} is not known", NAMES[k]);
        for found in [&deep, &by_default] {
            let off = (found.is[k] - by_hand).abs();
            assert!(
                off <= slack + found.left[k],
                "{name}, {}: {off:e}, {slack:e} {:e}",
                NAMES[k],
                found.left[k]
            );
        }
        assert!(deep.left[k] < 1e-6 * size, "{name}: {:e}", deep.left[k]);
    }
    for depth in [1, 2, 3, 5, 8] {
        let found = (family.at_depth)(plain, depth, family.is_closed);
        for k in measures.clone() {
            let (missing, bound) = ((deep.is[k] - found.is[k]).abs(), found.left[k]);
            let rounding = 1e-13 * deep.is[k].abs() + deep.left[k];
            let context = format!("{name}, depth {depth}, {}: {missing:e} {bound:e}", NAMES[k]);
            assert!(missing <= bound + rounding, "{context}");
            // What is missing of a volume has both signs, and may be next to nothing.
            let most =
                [family.most * (missing + rounding), 0.25_f64.powi(depth as i32) * deep.is[1].abs()][k];
            assert!(bound <= most, "{context}");
        }
        assert!(found.is[0] <= deep.is[0], "{name}: cells are parts of the surface");
    }
}

/// Shapes that are known by name, as they are.
#[test]
fn of_a_cube_a_tetrahedron_and_a_double_fan() {
    let creased = crate::shapes::cube().with_crease(4, 5, 1.5).unwrap();
    let fan = crate::shapes::double_fan(5, 0.1);
    let all = [
        ("cube", crate::shapes::cube()),
        ("tetrahedron", crate::shapes::tetrahedron()),
        ("double fan", fan),
        ("creased cube", creased),
    ];
    for (name, cage) in all {
        let family = Family {
            is_closed: true,
            most: 4.0,
            known: 1e-4,
            refine: Plain::refined,
            at_depth: catmull_clark,
        };
        holds(name, &Plain::of(&cage), &family);
    }
}

/// A point of more than a hundred edges costs a few seconds, and its area and volume are within what they say.
#[test]
fn of_a_point_of_more_than_a_hundred_edges() {
    let plain = Plain::of(&crate::shapes::double_fan(140, 0.1));
    let mut mesh = plain.clone();
    let mut levels = Vec::new();
    for _ in 0..5 {
        mesh = mesh.refined();
        levels.push(mesh.measures());
    }
    let found = catmull_clark(&plain, 8, true);
    for k in 0..2 {
        let [by_hand, slack] = extrapolated(&levels.iter().map(|level| level[k]).collect::<Vec<_>>());
        let (off, size) = ((found.is[k] - by_hand).abs(), by_hand.abs());
        assert!(
            slack < 2e-3 * size && found.left[k] < 0.1 * size,
            "{}: {slack:e} {:e} of {size}",
            NAMES[k],
            found.left[k]
        );
        assert!(off <= slack + found.left[k], "{}: {off:e} {slack:e} {:e}", NAMES[k], found.left[k]);
    }
}

/// Smooth and closed, of all valences from 3 to 8, with faces of three to nine corners.
#[test]
fn of_smooth_closed_surfaces() {
    let mut seen = [0; 9];
    for seed in 0..24 {
        let plain = wild::closed(seed);
        wild::valences(&plain).into_iter().for_each(|n| seen[n] += 1);
        let family = Family {
            is_closed: true,
            most: 4.0,
            known: 1e-4,
            refine: Plain::refined,
            at_depth: catmull_clark,
        };
        holds(&format!("closed {seed}"), &plain, &family);
    }
    assert!(seen[3..].iter().all(|count| *count > 1), "{seen:?}");
}

/// With creases and corners, for ever and for some levels. Cones of infinitely sharp corners are bounded less well.
#[test]
fn of_sharp_closed_surfaces() {
    for seed in 0..24 {
        let plain = wild::sharpened(wild::closed(seed), seed);
        let family = Family {
            is_closed: true,
            most: 40.0,
            known: 4e-3,
            refine: Plain::refined,
            at_depth: catmull_clark,
        };
        holds(&format!("sharp {seed}"), &plain, &family);
    }
}

/// With a boundary, rounded or with corners.
#[test]
fn of_open_surfaces() {
    for seed in 0..24 {
        let plain = wild::opened(wild::sharpened(wild::closed(seed), seed), seed);
        let family = Family {
            is_closed: false,
            most: 40.0,
            known: 4e-3,
            refine: Plain::refined,
            at_depth: catmull_clark,
        };
        holds(&format!("open {seed}"), &plain, &family);
    }
}

/// Doo and Sabin's.
#[test]
fn of_surfaces_of_doo_and_sabin() {
    for seed in 0..16 {
        let family =
            Family { is_closed: true, most: 3.0, known: 1e-3, refine: Plain::dual, at_depth: doo_sabin };
        holds(&format!("Doo-Sabin {seed}"), &wild::closed(seed), &family);
    }
}
