//! Fair interpolation by limits of Doo and Sabin's scheme, against a dense optimum.

use loftsman_fairing::{Fair, bend};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::Cage;
use loftsman_subdivision::doo_sabin::{DooSabinSurface, refine};

use super::{location, moved};
use crate::editing::{gauss, least_by, thin_plate};
use crate::shapes::duals::spot;
use crate::shapes::plain::Plain;
use crate::shapes::wild::Dice;

/// Meshes whose vertices have four edges inside, with middles of faces of 3, 4, 5 and 7 sides, closed, open and with a hole.
fn cages() -> Vec<(String, Cage)> {
    let mut all = vec![
        ("a cube".to_owned(), refine(&crate::shapes::cube()).unwrap()),
        ("a sheet".to_owned(), crate::shapes::grid(6, 6, [false, false], 0.2)),
        ("a torus".to_owned(), crate::shapes::grid(5, 6, [true, true], 0.2)),
    ];
    for n in [3, 5, 7] {
        all.push((format!("prism of {n}"), refine(&crate::shapes::wild::prism(n).cage().unwrap()).unwrap()));
        all.push((format!("open fan of {n}"), refine(&crate::shapes::fan(n, 4, true, 0.1)).unwrap()));
    }
    all.push(("with a hole".to_owned(), refine(&crate::shapes::cube()).unwrap().with_hole(2).unwrap()));
    all
}

/// The least thin-plate energy through given places, whatever the size; places by refinement by hand, the least by a dense matrix.
#[test]
fn fair_interpolation() {
    for (k, (name, cage)) in cages().into_iter().enumerate() {
        let size = [1.0, 1e-9, 1e9][k % 3];
        let mut cage = cage;
        cage.points_mut().iter_mut().for_each(|p| *p *= size);
        let plain = Plain::of(&cage);
        let surface = DooSabinSurface::new(cage).unwrap();
        let mut dice = Dice::new(80_000 + k as u64);
        let faces = surface.faces().unwrap();
        let places: Vec<(u32, [f64; 2])> =
            (0..7).map(|j| ((j * faces / 7) as u32, [0, 1].map(|_| dice.below(5) as f64 / 4.0))).collect();
        let there = |plain: &Plain, (face, at): (u32, [f64; 2])| {
            let (of, corner) = surface.cage_corner(face).unwrap();
            spot(plain, of, corner, at).place
        };
        let wanted: Vec<Vector> =
            places.iter().map(|&at| there(&plain, at) + dice.vector() * (0.2 * size)).collect();
        let fair = places.iter().zip(&wanted).fold(Fair::new(&surface).energy(bend()), |fair, (&at, p)| {
            fair.ask(position(location(at)).to(Point::from(*p)))
        });
        let fair = fair.solve().unwrap_or_else(|e| panic!("{name}: {e}"));
        let after = moved(&plain, fair.shape());
        for (&at, p) in places.iter().zip(&wanted) {
            let off = (there(&after, at) - p).norm();
            assert!(off < 1e-11 * size, "{name}: {off:e}");
        }
        // Of a face that is not regular the middle is the extraordinary place.
        let odd = |face: u32| (!surface.is_regular(face).unwrap()).then_some((0, 0));
        // The crate's own rule, two points a direction more than the degree, and a finer one.
        let [form, finer] = [4, 6].map(|n| thin_plate(&surface, odd, &gauss(n, 1)));
        let rows: Vec<Vec<f64>> = places
            .iter()
            .map(|&at| {
                // By hand: what a unit at each vertex comes to there.
                let unit = |k: usize| {
                    let mut only = plain.clone();
                    only.points.iter_mut().for_each(|p| *p = Vector::zeros());
                    only.points[k].x = 1.0;
                    there(&only, at).x
                };
                (0..plain.points.len()).map(unit).collect()
            })
            .collect();
        let best = least_by(&form, &rows, &wanted);
        let energy = |form: &[Vec<f64>], points: &[Vector]| -> f64 {
            let n = points.len();
            let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            pairs.map(|(i, j)| form[i][j] * points[i].dot(&points[j])).sum()
        };
        let least = places
            .iter()
            .zip(&wanted)
            .fold(Edit::new(&surface), |edit, (&at, p)| edit.ask(position(location(at)).to(Point::from(*p))));
        let least = moved(&plain, least.solve().unwrap().shape());
        let [a, b, c] = [&after.points, &best, &least.points].map(|points| energy(&form, points));
        assert!((a - b).abs() < 1e-10 * b && a < c, "{name}: {a:e} {b:e} {c:e}");
        // By the same rule the same vertices.
        let off = after.points.iter().zip(&best).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
        assert!(off < 1e-10 * size, "{name}: {off:e}");
        // Round extraordinary points, where the chart is in the denominators, no rule is exact; by the finer one hardly anything is less.
        let [a, b] = [&after.points, &least_by(&finer, &rows, &wanted)].map(|points| energy(&finer, points));
        assert!(a - b < 1e-10 * b, "{name}: {a:e} {b:e}");
        let value = fair.shape().value(Location::Face(0, 0.5, 0.5), Derivative::POSITION).unwrap();
        assert!((value - there(&after, (0, [0.5, 0.5]))).norm() < 1e-13 * size, "{name}");
    }
}
