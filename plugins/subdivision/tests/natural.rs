//! The coordinates in which energies are taken round extraordinary points: against the planar nets that explicit refinement comes to, and
//! energies that come to something.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use std::collections::BTreeMap;

use loftsman_fairing::{Fair, bend, stretch, variation};
use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{ChartedRow, Derivative, Location, Shape, cells_of, charted_rows};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::doo_sabin::{self, DooSabinSurface};
use loftsman_subdivision::{Cage, SubdivisionSurface, catmull_clark};

use crate::shapes;

/// The faces of a cage that are at most `rings` from one of its faces, as large as the largest of their coordinates is one.
fn cropped(cage: &Cage, start: &[usize], rings: usize) -> Cage {
    let topology = cage.topology();
    let mut faces: Vec<usize> = start.to_vec();
    // The middle stays: where it is off by rounding, that would grow beside what gets smaller.
    let around: Vec<Vector> =
        start.iter().flat_map(|&f| topology.face(f)).map(|&v| cage.points()[v as usize].coords).collect();
    let middle = around.iter().sum::<Vector>() / around.len() as f64;
    for _ in 0..rings {
        let points: Vec<u32> = faces.iter().flat_map(|&f| topology.face(f).to_vec()).collect();
        faces = (0..topology.face_count())
            .filter(|&f| topology.face(f).iter().any(|v| points.contains(v)))
            .collect();
    }
    let mut kept: Vec<u32> = faces.iter().flat_map(|&f| topology.face(f).to_vec()).collect();
    kept.sort_unstable();
    kept.dedup();
    let at = |v: &u32| kept.binary_search(v).unwrap();
    let points: Vec<Point> = kept.iter().map(|&v| cage.points()[v as usize] - middle).collect();
    let size = points.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()));
    let faces: Vec<Vec<usize>> = faces.iter().map(|&f| topology.face(f).iter().map(at).collect()).collect();
    Cage::new(points.iter().map(|p| p / size).collect(), &faces).unwrap()
}

/// A flat fan that was refined until it stays the same but for its size, from the middle.
fn settled(n: usize, refine: impl Fn(&Cage) -> Cage) -> Cage {
    let mut cage = shapes::fan(n, 4, true, 0.0);
    cage.points_mut().iter_mut().for_each(|p| p.z = 0.0);
    for _ in 0..60 {
        cage = refine(&cage);
        let topology = cage.topology();
        let middle = (0..topology.face_count()).filter(|&f| topology.face(f).len() != 4).collect::<Vec<_>>();
        let vertices = (0..topology.vertex_count())
            .filter(|&v| !topology.is_boundary_vertex(v) && topology.around(v).count() != 4);
        let start = match middle[..] {
            [] => vertices.flat_map(|v| topology.vertex_faces(v)).map(|f| f as usize).collect(),
            _ => middle,
        };
        cage = cropped(&cage, &start, 2);
    }
    cage
}

/// Where charts are those of a plane that a surface is, but for one similarity.
fn agrees(surface: &dyn Shape, n: usize) -> usize {
    let cells = cells_of(surface, "a chart").unwrap();
    let mut seen: Option<f64> = None;
    let mut count = 0;
    for index in 0..cells.count() {
        let cell = cells.cell(index).unwrap();
        for (at, _) in cell.gauss_points([3, 2]) {
            let Some(chart) = cells.chart(at) else { continue };
            let by = |u, v| surface.value(at, Derivative { u, v }).unwrap();
            let own = |[x, y]: [f64; 2]| Vector::new(x, y, 0.0);
            let pairs = [
                (own(chart.first[0]), by(1, 0)),
                (own(chart.first[1]), by(0, 1)),
                (own(chart.second[0]), by(2, 0)),
                (own(chart.second[1]), by(1, 1)),
                (own(chart.second[2]), by(0, 2)),
            ];
            // Lengths and angles are those of the plane, which is another size, turned or turned over.
            let size = pairs[0].0.norm() / pairs[0].1.norm();
            let known = *seen.get_or_insert(size);
            assert!((size / known - 1.0).abs() < 1e-9, "{n}: {at:?} {size} {known}");
            for (a, b) in &pairs {
                for (c, d) in &pairs {
                    let (found, wanted) = (a.dot(c), b.dot(d) * size * size);
                    let scale = a.norm() * c.norm() + pairs[0].0.norm_squared();
                    assert!((found - wanted).abs() < 1e-9 * scale, "{n}: {at:?} {found} {wanted}");
                }
            }
            count += 1;
        }
    }
    count
}

#[test]
fn charts_are_what_refinement_comes_to() {
    for n in [3, 5, 7, 16] {
        let cage = settled(n, |cage| catmull_clark::refine(cage).unwrap());
        assert!(agrees(&SubdivisionSurface::new(cage).unwrap(), n) >= n * 21 * 6, "{n}");
        let cage = settled(n, |cage| doo_sabin::refine(cage).unwrap());
        assert!(agrees(&DooSabinSurface::new(cage).unwrap(), n) >= n * 21 * 6, "{n}");
    }
}

/// A plane has no thin plate's energy, however its net lies in it.
#[test]
fn a_plane_does_not_bend() {
    for n in [3, 5, 8] {
        let cage = settled(n, |cage| catmull_clark::refine(cage).unwrap());
        let surface = SubdivisionSurface::new(cage).unwrap();
        let cells = cells_of(&surface, "an energy").unwrap();
        let (mut bent, mut all) = (0.0, 0.0);
        for index in 0..cells.count() {
            let cell = cells.cell(index).unwrap();
            let Some(rows) = charted_rows(&surface, cells, &cell, 2).unwrap() else { continue };
            for ChartedRow { row, .. } in rows {
                let each =
                    row.iter().zip(&cell.vertices).map(|(c, &v)| *c * surface.cage().points()[v].coords);
                bent += each.clone().sum::<Vector>().norm_squared();
                all += each.map(|x| x.norm()).sum::<f64>().powi(2);
            }
        }
        assert!(all > 0.1 && bent < 1e-20 * all, "{n}: {bent:e} {all:e}");
    }
}

/// What each level adds to the thin plate's energy.
fn levels(surface: &dyn Shape) -> BTreeMap<i32, f64> {
    let cells = cells_of(surface, "an energy").unwrap();
    let mut levels = BTreeMap::new();
    for index in 0..cells.count() {
        let cell = cells.cell(index).unwrap();
        let Some(rows) = charted_rows(surface, cells, &cell, 2).unwrap() else { continue };
        let level = -(cell.sides[0].end - cell.sides[0].start).log2().round() as i32;
        for ChartedRow { row, .. } in rows {
            let sum: Vector =
                row.iter().zip(&cell.vertices).map(|(c, &v)| surface.control_vertices()[v].coords * *c).sum();
            *levels.entry(level).or_insert(0.0) += sum.norm_squared();
        }
    }
    levels
}

/// From level to level the energy falls as the eigenvalues say: with `μ`, the next below the pair `λ`, by `(μ/λ)²`. Of Catmull-Clark that
/// is the second wave's, `λ` of twice the angle, or that of what goes up and down all round; of Doo-Sabin, where it is a
/// quarter and `λ` a half, more slowly at first, for it stands there more than once.
#[test]
fn a_thin_plates_energy_comes_to_something() {
    let wave = |turns: f64| {
        let x = 5.0 + turns.cos();
        (x + (x * x - 16.0).sqrt()) / 16.0
    };
    for n in [3, 5, 6, 8] {
        let around = std::f64::consts::TAU / n as f64;
        let surface = SubdivisionSurface::with_depth(shapes::fan(n, 4, true, 0.1), 10).unwrap();
        let all = levels(&surface);
        let a = n as f64;
        // Of what is the same all round: with the weights of a vertex of n edges.
        let round = {
            // The middle, the mean of the edges' ends and that of the corners across faces; one of the three eigenvalues is one.
            let m = [
                [1.0 - 7.0 / (4.0 * a), 3.0 / (2.0 * a), 1.0 / (4.0 * a)],
                [0.375, 0.5, 0.125],
                [0.25, 0.5, 0.25],
            ];
            let trace = m[0][0] + m[1][1] + m[2][2] - 1.0;
            let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
            let product = minor(0, 1) + minor(0, 2) + minor(1, 2) - trace;
            0.5 * (trace + (trace * trace - 4.0 * product).max(0.0).sqrt())
        };
        let second = if n > 3 { wave(2.0 * around) } else { round };
        let [least, most] = [round.min(second), round.max(second)].map(|next| (next / wave(around)).powi(2));
        let found = all[&10] / all[&9];
        println!("{n}: {found} between {least} and {most}");
        assert!((0.95 * least..1.06 * most).contains(&found), "{n}: {found} between {least} and {most}");

        let all = levels(&DooSabinSurface::with_depth(shapes::fan(n, 4, true, 0.1), 10).unwrap());
        let found = all[&10] / all[&9];
        assert!((0.24..0.35).contains(&found), "{n}: {found}");
    }
}

/// So the surface that is fair does not depend on the depth of its cells.
#[test]
fn what_is_fair_does_not_depend_on_the_depth() {
    let fair = |cage: &Cage, depth| {
        let surface = SubdivisionSurface::with_depth(cage.clone(), depth).unwrap();
        let fair = (0..4).fold(Fair::new(&surface).energy(bend()), |fair, v| {
            let to = Point::from(surface.value(Location::Vertex(v), Derivative::POSITION).unwrap() * 1.3);
            fair.ask(position(Location::Vertex(v)).to(to))
        });
        let fair = fair.solve().unwrap();
        (fair.report().energy_after, fair.shape().control_vertices().to_vec())
    };
    for cage in [
        catmull_clark::refine(&shapes::cube()).unwrap(),
        catmull_clark::refine(&shapes::double_fan(7, 0.1)).unwrap(),
    ] {
        let (few, many) = (fair(&cage, 8), fair(&cage, 16));
        let off = few.1.iter().zip(&many.1).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{} {} {off:e}", few.0, many.0);
        assert!((few.0 / many.0 - 1.0).abs() < 0.02 && off < 0.02, "{} {} {off:e}", few.0, many.0);
    }
}

/// Vertices of a cube, and of a prism of six sides, can move so that nothing of the surface does: energies and metrics see that.
#[test]
fn cages_whose_vertices_move_for_nothing_are_edited_by_every_metric() {
    let prism = |n: usize| {
        let point = |k: usize| {
            let t = std::f64::consts::TAU * (k % n) as f64 / n as f64;
            Point::new(t.cos(), t.sin(), if k < n { 0.0 } else { 1.0 })
        };
        let mut faces: Vec<Vec<usize>> =
            (0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]).collect();
        faces.push((0..n).rev().collect());
        faces.push((n..2 * n).collect());
        Cage::new((0..2 * n).map(point).collect(), &faces).unwrap()
    };
    for cage in [shapes::cube(), prism(6), prism(8)] {
        let surface = SubdivisionSurface::new(cage).unwrap();
        let start = surface.value(Location::Vertex(0), Derivative::POSITION).unwrap();
        let to = Point::from(start + Vector::new(0.1, 0.2, -0.1));
        for metric in [Metric::Stretch, Metric::Bend] {
            let edited =
                Edit::new(&surface).metric(metric).ask(position(Location::Vertex(0)).to(to)).solve().unwrap();
            let off =
                (edited.shape().value(Location::Vertex(0), Derivative::POSITION).unwrap() - to.coords).norm();
            let moved = edited.shape().control_vertices().iter().zip(surface.control_vertices());
            let moved = moved.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(off < 1e-12 && moved < 2.0, "{off:e} {moved}");
        }
        let energy = |s: &SubdivisionSurface| {
            Fair::new(s)
                .energy(bend() + 0.1 * stretch())
                .ask(position(Location::Vertex(0)).keep())
                .solve()
                .unwrap()
        };
        assert!(energy(&surface).report().energy_before > 0.0);
    }
}

/// The variation of bending has no finite value at extraordinary vertices, so there is none that is least; where all are regular, and of
/// bending everywhere, there is.
#[test]
fn what_is_infinite_is_refused() {
    let surface = SubdivisionSurface::new(catmull_clark::refine(&shapes::cube()).unwrap()).unwrap();
    let torus = SubdivisionSurface::new(shapes::grid(5, 6, [true, true], 0.1)).unwrap();
    let fair = |surface: &SubdivisionSurface, energy| {
        let keep = (0..3).fold(Fair::new(surface).energy(energy), |fair, v| {
            fair.ask(position(Location::Vertex(v)).keep())
        });
        keep.solve().map(|_| ()).map_err(|error| error.to_string())
    };
    let why = fair(&surface, variation()).unwrap_err();
    assert!(why.contains("infinite at extraordinary vertices, the first at a corner of face 0"), "{why}");
    fair(&surface, bend() + stretch()).unwrap();
    fair(&torus, variation()).unwrap();
}
