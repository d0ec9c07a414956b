//! W3: the wavy rational surface of 50 × 50 vertices as triangles, to a thousandth of its diagonal.
//!
//! Aims: the tolerance met where it is sampled, at most 40,000 triangles, 0.08 s. Ours bounds the deviation beforehand;
//! curvo has no chord tolerance, so that the coarsest of a ladder of its settings that meets the tolerance counts (the
//! search is not timed); truck divides a grid of lines until the middles of its cells are within the tolerance.
//! Floor: a grid of as many triangles, evaluated in one batch, which is what a tessellator cannot do without.

use std::hint::black_box;

use criterion::measurement::Measurement;
use criterion::{BenchmarkId, Criterion};
use curvo::prelude::{AdaptiveTessellationOptions, NurbsSurface3D, Tessellation};
use loftsman_benches::deviation::{Triangle, deviation};
use loftsman_benches::inputs::{knots, parameters, sheet};
use loftsman_benches::measure::{self, Case};
use loftsman_kernel::Point;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::spline::batch::OrientedPoint;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_tessellation::Adaptive;
use nalgebra::{Point4, U4};
use truck_geometry::prelude::{BSplineSurface, KnotVec, NurbsSurface, Vector4};
use truck_polymesh::StructuredMesh;

const SIZES: [usize; 3] = [25, 50, 100];
/// truck takes a quarter of a minute for the surface of 50 × 50 vertices.
const PATIENCE: usize = 25;

/// One line of the second table: who, on what, how many triangles, how far from the surface in tolerances.
struct Quality(&'static str, usize, usize, f64);

fn bench<M: Measurement>(criterion: &mut Criterion<M>, qualities: &mut Vec<Quality>) {
    let mut group = criterion.benchmark_group("W3 tessellation");
    for size in SIZES {
        let id = |name: &str| BenchmarkId::new(name, size);
        let (u, v, net) = (knots(size, 3, 2), knots(size, 3, 3), sheet(size));
        let space = |t: &[f64]| Space::open(3, t.to_vec()).expect("the knots are in order");
        let points = net.iter().map(|p| Point::new(p[0], p[1], p[2])).collect();
        let surface = Surface::rational(space(&u), space(&v), points, net.iter().map(|p| p[3]).collect())
            .expect("as many vertices as the spaces have");
        let tolerance = 1e-3 * diagonal(&surface);

        let fineness = Fineness { chord: Chord::Absolute(tolerance), angle: std::f64::consts::PI };
        let ours = Adaptive::default();
        group.bench_function(id("loftsman"), |b| {
            b.iter(|| ours.surface(black_box(&surface), black_box(&fineness)).is_ok());
        });
        let mesh = ours.surface(&surface, &fineness).expect("a surface that can be tessellated");
        let worst = deviation(&surface, of_mesh(&mesh)) / tolerance;
        qualities.push(Quality("loftsman", size, mesh.triangle_count(), worst));

        let side = ((mesh.triangle_count() as f64 / 2.0).sqrt().ceil() as usize) + 1;
        let at = parameters(side);
        group.bench_function(id("floor"), |b| {
            b.iter(|| {
                let mut out = vec![OrientedPoint::ZERO; side * side];
                black_box(surface.grid_oriented_into(&at, black_box(&at), &mut out).is_ok())
            });
        });

        let curvo: NurbsSurface3D<f64> = NurbsSurface3D::new(
            3,
            3,
            u.clone(),
            v.clone(),
            net.chunks_exact(size)
                .map(|row| {
                    row.iter().map(|p| Point4::new(p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3])).collect()
                })
                .collect(),
        );
        for setting in [2.0, 1.0, 0.5, 0.35, 0.3, 0.28, 0.25, 0.2, 0.15, 0.1] {
            let options = AdaptiveTessellationOptions::<f64, U4>::default().with_norm_tolerance(setting);
            let mesh = curvo.tessellate(Some(options.clone()));
            let corner = |k: usize| {
                let (p, uv) = (&mesh.points()[k], &mesh.uvs()[k]);
                (Point::new(p.x, p.y, p.z), [uv.x, uv.y])
            };
            let worst = deviation(&surface, mesh.faces().iter().map(|f| f.map(corner))) / tolerance;
            if worst <= 1.0 {
                qualities.push(Quality("curvo", size, mesh.faces().len(), worst));
                group.bench_function(id("curvo"), |b| {
                    b.iter(|| black_box(curvo.tessellate(Some(options.clone()))).faces().len());
                });
                break;
            }
        }

        if size <= PATIENCE {
            let rows = net
                .chunks_exact(size)
                .map(|row| {
                    row.iter().map(|p| Vector4::new(p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3])).collect()
                })
                .collect();
            let truck = NurbsSurface::new(BSplineSurface::new((KnotVec::from(u), KnotVec::from(v)), rows));
            let range = ((0.0, 1.0), (0.0, 1.0));
            group.bench_function(id("truck"), |b| {
                b.iter(|| black_box(StructuredMesh::from_surface(&truck, range, tolerance)));
            });
            let mesh = StructuredMesh::from_surface(&truck, range, tolerance);
            let triangles = of_grid(&mesh);
            let worst = deviation(&surface, triangles.iter().copied()) / tolerance;
            qualities.push(Quality("truck", size, triangles.len(), worst));
        }
    }
    group.finish();
}

/// The diagonal of the box of a fine grid of points.
fn diagonal(surface: &Surface) -> f64 {
    let at: Vec<f64> = (0..=400).map(|k| f64::from(k) / 400.0).collect();
    let mut points = vec![Point::origin(); at.len() * at.len()];
    surface.grid_into(&at, &at, &mut points).expect("parameters of the domain");
    let ends = |pick: fn(f64, f64) -> f64, axis: usize| points.iter().map(|p| p[axis]).reduce(pick);
    (0..3)
        .map(|axis| (ends(f64::max, axis).unwrap_or(0.0) - ends(f64::min, axis).unwrap_or(0.0)).powi(2))
        .sum::<f64>()
        .sqrt()
}

fn of_mesh(mesh: &Mesh) -> impl Iterator<Item = Triangle> + '_ {
    mesh.starts().windows(2).map(|face| {
        let corner = |k: usize| {
            let point = mesh.corners()[face[0] + k];
            let uv = mesh.uvs.at(face[0] + k, point).expect("a tessellation has parameters");
            (mesh.points()[point as usize], *uv)
        };
        assert_eq!(face[1] - face[0], 3, "a tessellation has triangles");
        [corner(0), corner(1), corner(2)]
    })
}

fn of_grid(mesh: &StructuredMesh) -> Vec<Triangle> {
    let (us, vs) = mesh.uv_division().clone().expect("a mesh from a surface knows its parameters");
    let corner = |i: usize, j: usize| {
        let p = mesh.positions()[i][j];
        (Point::new(p.x, p.y, p.z), [us[i], vs[j]])
    };
    let mut triangles = Vec::new();
    for i in 1..us.len() {
        for j in 1..vs.len() {
            let (a, b, c, d) = (corner(i - 1, j - 1), corner(i, j - 1), corner(i, j), corner(i - 1, j));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

fn main() {
    let mut criterion = measure::criterion();
    let mut qualities = Vec::new();
    bench(&mut criterion, &mut qualities);
    criterion.final_summary();
    let case = |size: usize| Case { name: size.to_string(), size: (size * size) as f64, row: String::new() };
    let cases: Vec<Case> = SIZES.into_iter().map(case).collect();
    let contestants = ["floor", "loftsman", "curvo", "truck"];
    measure::summary("W3 tessellation", &contestants, "loftsman", &["loftsman"], &cases);
    println!("\n| who | vertices | triangles | deviation, in tolerances |\n|---|---|---|---|");
    for Quality(who, size, triangles, worst) in qualities {
        println!("| {who} | {size} × {size} | {triangles} | {worst:.3} |");
    }
}
