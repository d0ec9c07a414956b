//! What surfaces and curves enclose: MeshLab and Blender measure the tessellation, and come to what we say at second order.

use loftsman::area_volume::{surface_area, volume};
use loftsman_kernel::Point;
use loftsman_kernel::functional::{Functional, Shapes};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_tests::curves::document;
use loftsman_tests::oracle::{Oracle, list, number, object};
use serde_json::json;

use crate::save;

use crate::LOFTSMAN;

/// A wobbly torus: periodic both ways, so that its mesh is closed without any seam.
fn torus() -> Surface {
    let n = 12;
    let at = |k: usize| {
        let turn = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let (a, b) = (turn(k / n), turn(k % n));
        let r = 0.4 + 0.05 * (3.0 * a + 2.0 * b).sin();
        Point::new((1.0 + r * b.cos()) * a.cos(), (1.0 + r * b.cos()) * a.sin(), r * b.sin())
    };
    let space = Space::periodic_uniform(3, n).unwrap();
    Surface::new(space.clone(), space, (0..n * n).map(at).collect()).unwrap()
}

#[test]
fn volumes_and_surface_areas_of_meshes_come_to_ours() {
    let surface = torus();
    let measured = |functional: &dyn Functional| {
        let mut out = [f64::NAN];
        functional.value(&Shapes::one(&surface), &mut out).unwrap();
        out[0]
    };
    let (inside, area) = (measured(&volume()).abs(), measured(&surface_area()));
    let space: Vec<f64> = surface.u().knots().to_vec();
    let net: Vec<Vec<[f64; 3]>> =
        surface.points().chunks(12).map(|row| row.iter().map(|p| [p.x, p.y, p.z]).collect()).collect();
    let direction = json!({ "degree": 3, "periodic": true, "knots": space });
    let ring = json!({ "name": "ring", "surface": { "u": direction, "v": direction, "points": net } });
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "ring.loft.json", &document("m", &[ring]));
    // A quarter of the distance is about half the chord, four times as many triangles.
    let tolerances = [4e-3, 1e-3, 2.5e-4];
    let files: Vec<_> = tolerances
        .iter()
        .map(|tolerance| {
            let out = format!("ring-{tolerance}.glb");
            let tolerance = tolerance.to_string();
            LOFTSMAN.done(folder.path(), &["convert", "ring.loft.json", &out, "--tolerance", &tolerance]);
            folder.path().join(out)
        })
        .collect();
    if let Some(reports) = Oracle::MeshLab.ask(&files, &["--weld"]) {
        let mesh = |k: usize| &list(&reports[k], "meshes")[0];
        let faces = |k: usize| number(mesh(k), "faces");
        converges("MeshLab's volume", inside, &tolerances, faces, |k| number(mesh(k), "welded/volume").abs());
        converges("MeshLab's area", area, &tolerances, faces, |k| number(mesh(k), "area"));
    }
    if let Some(reports) = Oracle::Blender.ask(&files, &[]) {
        let seen = |k: usize| object(&reports[k], "ring");
        let faces = |k: usize| number(seen(k), "faces");
        let volumes = |k: usize| number(seen(k), "welded_at_1e-6/volume_signed").abs();
        converges("Blender's volume", inside, &tolerances, faces, volumes);
        converges("Blender's area", area, &tolerances, faces, |k| number(seen(k), "area"));
    }
}

/// Each error is about its tolerance's share, and from one tolerance to the next they fall with the square of the triangles'
/// size (as one over their number): at about half the size, to about a quarter.
fn converges(
    what: &str,
    exact: f64,
    tolerances: &[f64],
    faces: impl Fn(usize) -> f64,
    measured: impl Fn(usize) -> f64,
) {
    let errors: Vec<f64> = (0..tolerances.len()).map(|k| (measured(k) / exact - 1.0).abs()).collect();
    for (error, tolerance) in errors.iter().zip(tolerances) {
        // A tube of radius 0.4 that loses t everywhere loses 2t/0.4 of its volume.
        assert!(*error <= 5.0 * tolerance, "{what}: {errors:?}");
    }
    // Triangles of a tolerance are not all of one size, so that a single step may be off by more than all together.
    let order =
        |from: usize, to: usize| 2.0 * (errors[from] / errors[to]).ln() / (faces(to) / faces(from)).ln();
    for k in 1..errors.len() {
        assert!(
            (1.5..2.5).contains(&order(k - 1, k)),
            "{what} converges at order {:.2}: {errors:?}",
            order(k - 1, k)
        );
        let ratio = errors[k - 1] / errors[k];
        assert!(
            (2.5..6.5).contains(&ratio),
            "{what}: a quarter of the tolerance divides the error by {ratio:.2}"
        );
    }
    let whole = order(0, errors.len() - 1);
    assert!((1.7..2.3).contains(&whole), "{what} converges at order {whole:.2}: {errors:?}");
}
