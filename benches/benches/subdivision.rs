//! A cage of 1024 quads refined five times by Catmull and Clark, to 1,048,576; and a drag event on the limit of a cage of 10,200.
//!
//! Aims: a million faces in 0.25 s and 300 MiB, faster than any other crate (alum) and within twice the time of OpenSubdiv's own refinement
//! on one thread (`peers/subdivision.py`, which compiles `peers/opensubdiv.cpp`); an event in 2 µs, whatever the size of the cage.
//! All three refine the same cage in doubles, and their finest vertices have the same mean and mean square.
//!
//! What is kept differs, so OpenSubdiv stands there twice: `OpenSubdiv` makes of the finest level what is needed for its vertices, `OpenSubdiv,
//! full` edges and neighbours of faces, too, as ours (which derives its edges when they are asked for) and alum's half-edges can answer.

use std::hint::black_box;

use alum::{DVec3, HasTopology, PolyMeshF64};
use criterion::measurement::Measurement;
use criterion::{BatchSize, BenchmarkId, Criterion};
use loftsman_benches::inputs::{lattice, scaled};
use loftsman_benches::measure::{self, Case};
use loftsman_benches::shapes::cage;
use loftsman_kernel::Point;
use loftsman_kernel::edit::Edit;
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::Location;
use loftsman_kernel::solve::Automatic;
use loftsman_subdivision::{SubdivisionSurface, catmull_clark};

const LEVELS: usize = 5;
const GROUP: &str = "Catmull-Clark to a million faces";

fn alums() -> PolyMeshF64 {
    let (points, faces) = lattice(12, 4..8);
    let mut mesh = PolyMeshF64::with_capacity(points.len(), 2 * faces.len(), faces.len());
    for [x, y, z] in scaled(&points, 12) {
        mesh.add_vertex(DVec3(x, y, z)).expect("a vertex");
    }
    for face in faces {
        mesh.add_face(&face.map(|v| (v as u32).into())).expect("a face");
    }
    mesh
}

/// Mean of all vertices and mean square: what OpenSubdiv has to twelve digits (`peers/opensubdiv.cpp` prints them).
fn judge(who: &str, faces: usize, points: impl ExactSizeIterator<Item = [f64; 3]>) {
    let count = points.len();
    let (mut mean, mut square) = ([0.0; 3], 0.0);
    for p in points {
        for (sum, x) in mean.iter_mut().zip(p) {
            *sum += x / count as f64;
            square += x * x / count as f64;
        }
    }
    assert_eq!((faces, count), (1_048_576, 1_048_576), "{who}: faces and vertices");
    assert!(mean.iter().all(|x| (x - 0.5).abs() < 1e-11), "{who}: {mean:?}");
    assert!((square - 1.11348928378158).abs() < 1e-11, "{who}: {square}");
}

fn refinement<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group(GROUP);
    let coarse = cage(12, 4..8);
    let finest = catmull_clark::refine_times(&coarse, LEVELS).expect("32 bits count them");
    judge("ours", finest.topology().face_count(), finest.points().iter().map(|p| [p.x, p.y, p.z]));
    drop(finest);
    group.bench_function(BenchmarkId::new("ours", LEVELS), |b| {
        b.iter(|| catmull_clark::refine_times(black_box(&coarse), LEVELS));
    });
    let mut theirs = alums();
    theirs.subdivide_catmull_clark(LEVELS, true).expect("refined");
    let points = theirs.points();
    let points = points.try_borrow().expect("nobody writes");
    judge("alum", theirs.num_faces(), points.iter().map(|p| [p.0, p.1, p.2]));
    drop(points);
    drop(theirs);
    group.bench_function(BenchmarkId::new("alum", LEVELS), |b| {
        b.iter_batched(
            alums,
            |mut mesh| {
                mesh.subdivide_catmull_clark(LEVELS, true).expect("refined");
                mesh
            },
            BatchSize::PerIteration,
        );
    });
    group.finish();
}

/// Events at a place whose face is one bicubic piece, and at one beside a vertex of valence 5.
fn drags<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group("limit point, an event");
    for (cells, hole) in [(12, 4..8), (38, 13..25)] {
        let surface = SubdivisionSurface::new(cage(cells, hole)).expect("a cage of quads");
        let faces = surface.cage().topology().face_count();
        for (name, regular) in [("regular", true), ("extraordinary", false)] {
            let face = (0..faces as u32).find(|&face| surface.is_regular(face).is_ok_and(|is| is == regular));
            let place = Location::Face(face.expect("faces of both kinds"), 0.4, 0.3);
            let edit = Edit::new(&surface).handle(position(place));
            let mut session = edit.prepare(Automatic).expect("a point");
            let mut x = 0.0;
            session.to_point(Point::new(x, 1.0, 0.0)).expect("a point goes anywhere");
            group.bench_function(BenchmarkId::new(name, faces), |b| {
                b.iter(|| {
                    x += 1e-6;
                    black_box(session.to_point(Point::new(x, 1.0, 0.0)).is_ok())
                });
            });
        }
    }
    group.finish();
}

fn main() {
    let mut criterion = measure::criterion();
    refinement(&mut criterion);
    drags(&mut criterion);
    criterion.final_summary();
    let million = [Case { name: LEVELS.to_string(), size: 1.0, row: String::new() }];
    measure::summary(GROUP, &["ours", "alum", "OpenSubdiv", "OpenSubdiv, full"], "ours", &["ours"], &million);
    let sizes = [1024, 10_200].map(|n| Case { name: n.to_string(), size: f64::from(n), row: String::new() });
    measure::summary(
        "limit point, an event",
        &["regular", "extraordinary"],
        "regular",
        &["regular", "extraordinary"],
        &sizes,
    );
}
