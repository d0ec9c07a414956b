//! A cage of 1024 quads refined five times by Catmull and Clark, to 1,048,576; and a drag event on the limit of a cage of 10,200.
//!
//! Aims: a million faces in 0.25 s and 300 MiB, faster than any other crate (alum) and within twice the time of OpenSubdiv's own refinement
//! on one thread (`peers/subdivision.py`, which compiles `peers/opensubdiv.cpp`); an event in 2 µs, whatever the size of the cage.
//! All three refine the same cage in doubles, and their finest vertices have the same mean and mean square.
//!
//! What is kept differs, so OpenSubdiv stands there twice: `OpenSubdiv` makes of the finest level what is needed for its vertices, `OpenSubdiv,
//! full` edges and neighbours of faces, too, as ours (which derives its edges when they are asked for) and alum's half-edges can answer.
//! With the feature `petite` the crate opensubdiv-petite refines it, too: OpenSubdiv 3.7 compiled by the crate, in single precision.

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
/// How near the mean of a million doubles comes.
const DOUBLE: f64 = 1e-11;

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
fn judge(who: &str, accuracy: f64, faces: usize, points: impl ExactSizeIterator<Item = [f64; 3]>) {
    let count = points.len();
    let (mut mean, mut square) = ([0.0; 3], 0.0);
    for p in points {
        for (sum, x) in mean.iter_mut().zip(p) {
            *sum += x / count as f64;
            square += x * x / count as f64;
        }
    }
    assert_eq!((faces, count), (1_048_576, 1_048_576), "{who}: faces and vertices");
    assert!(mean.iter().all(|x| (x - 0.5).abs() < accuracy), "{who}: {mean:?}");
    assert!((square - 1.11348928378158).abs() < accuracy, "{who}: {square}");
}

fn refinement<M: Measurement>(criterion: &mut Criterion<M>) {
    let mut group = criterion.benchmark_group(GROUP);
    let coarse = cage(12, 4..8);
    let finest = catmull_clark::refine_times(&coarse, LEVELS).expect("32 bits count them");
    judge("ours", DOUBLE, finest.topology().face_count(), finest.points().iter().map(|p| [p.x, p.y, p.z]));
    drop(finest);
    group.bench_function(BenchmarkId::new("ours", LEVELS), |b| {
        b.iter(|| catmull_clark::refine_times(black_box(&coarse), LEVELS));
    });
    let mut theirs = alums();
    theirs.subdivide_catmull_clark(LEVELS, true).expect("refined");
    let points = theirs.points();
    let points = points.try_borrow().expect("nobody writes");
    judge("alum", DOUBLE, theirs.num_faces(), points.iter().map(|p| [p.0, p.1, p.2]));
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
    #[cfg(feature = "petite")]
    petite::refinement(&mut group);
    group.finish();
}

#[cfg(feature = "petite")]
mod petite {
    use criterion::measurement::Measurement;
    use criterion::{BenchmarkGroup, BenchmarkId};
    use loftsman_benches::inputs::{lattice, scaled};
    use opensubdiv_petite::far;

    use super::{LEVELS, judge};

    /// Its name in the table.
    pub(super) const NAME: &str = "opensubdiv-petite";

    /// Corners of faces, four each, and coordinates, three each.
    fn cage() -> (Vec<u32>, Vec<f32>) {
        let (points, faces) = lattice(12, 4..8);
        let corners = faces.iter().flatten().map(|&v| v as u32).collect();
        (corners, scaled(&points, 12).into_iter().flatten().map(|x| x as f32).collect())
    }

    /// The finest level's number of faces and its vertices.
    fn refined(corners: &[u32], points: &[f32]) -> (usize, Vec<f32>) {
        let sides = vec![4; corners.len() / 4];
        let cage = far::TopologyDescriptor::new(points.len() / 3, &sides, corners).expect("a cage of quads");
        let mut refiner = far::TopologyRefiner::new(cage, far::TopologyRefinerOptions::default()).expect("a manifold");
        refiner.refine_uniform(far::topology_refiner::UniformRefinementOptions { refinement_level: LEVELS, ..Default::default() });
        let steps = far::PrimvarRefiner::new(&refiner).expect("levels");
        let finest = (1..=LEVELS).fold(points.to_vec(), |points, level| steps.interpolate(level, 3, &points).expect("a level"));
        (refiner.level(LEVELS).expect("the finest").face_count(), finest)
    }

    pub(super) fn refinement<M: Measurement>(group: &mut BenchmarkGroup<'_, M>) {
        let (corners, points) = cage();
        let (faces, finest) = refined(&corners, &points);
        let finest: Vec<[f64; 3]> = finest.chunks_exact(3).map(|p| [p[0].into(), p[1].into(), p[2].into()]).collect();
        judge(NAME, 1e-5, faces, finest.into_iter());
        group.bench_function(BenchmarkId::new(NAME, LEVELS), |b| b.iter(|| refined(&corners, &points)));
    }
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
    let crates: &[&str] = &[
        "ours",
        "alum",
        #[cfg(feature = "petite")]
        petite::NAME,
    ];
    measure::summary(GROUP, &[crates, &["OpenSubdiv", "OpenSubdiv, full"]].concat(), "ours", &["ours"], &million);
    let sizes = [1024, 10_200].map(|n| Case { name: n.to_string(), size: f64::from(n), row: String::new() });
    measure::summary(
        "limit point, an event",
        &["regular", "extraordinary"],
        "regular",
        &["regular", "extraordinary"],
        &sizes,
    );
}
