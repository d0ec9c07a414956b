//! The bicubic pieces of a Catmull-Clark surface.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use loftsman_kernel::shape::Derivative;
use loftsman_kernel::shape::Shape;
use loftsman_subdivision::LimitFrame;
use loftsman_subdivision::catmull_clark::{limit_frames, patch, patch_stencils, refine};

#[test]
fn patches_are_the_surface() {
    let (mut count, mut on_boundary) = (0, 0);
    for (name, cage) in crate::shapes::all().into_iter().step_by(3) {
        for coarse in [cage.clone(), refine(&cage).unwrap()] {
            let (here, fine) = (limit_frames(&coarse).unwrap(), refine(&coarse).unwrap());
            let there = limit_frames(&fine).unwrap();
            let topology = coarse.topology();
            let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
            for face in 0..topology.face_count() {
                let Some(spline) = patch(&coarse, face).unwrap() else { continue };
                count += 1;
                let close = |frame: &LimitFrame, u: f64, v: f64, smooth: bool| {
                    let off = (spline.point(u, v).unwrap() - frame.point).norm();
                    assert!(off < 1e-14, "{name}, face {face}: {off:e}");
                    let [du, dv] = [(1, 0), (0, 1)]
                        .map(|(du, dv)| spline.value([u, v].into(), Derivative { u: du, v: dv }).unwrap());
                    let plane = LimitFrame { point: frame.point, tangents: [du, dv] };
                    if let (Some(a), Some(b), true) = (plane.normal(), frame.normal(), smooth) {
                        assert!((a - b).norm() < 1e-9, "{name}, face {face}: {a} {b}");
                    }
                };
                let corners = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)];
                for (&v, (a, b)) in topology.face(face).iter().zip(corners) {
                    on_boundary += usize::from(topology.is_boundary_vertex(v as usize));
                    close(&here[v as usize], a, b, true);
                }
                for (&e, (a, b)) in
                    topology.face_edges(face).iter().zip([(0.5, 0.), (1., 0.5), (0.5, 1.), (0., 0.5)])
                {
                    close(&there[vertices + e as usize], a, b, true);
                }
                close(&there[vertices + edges + face], 0.5, 0.5, true);
                for row in patch_stencils(&coarse, face).unwrap().unwrap() {
                    assert!((row.coefficients().iter().sum::<f64>() - 1.0).abs() < 1e-15);
                }
            }
        }
    }
    assert!(count > 200 && on_boundary > 100, "{count} {on_boundary}");
}

#[test]
fn what_is_not_regular_has_none() {
    let cube = refine(&crate::shapes::cube()).unwrap();
    assert!((0..24).all(|face| patch(&cube, face).unwrap().is_none()));
    assert!(patch(&cube, 24).is_err());
    let grid = crate::shapes::grid(5, 5, [true, true], 0.1);
    let creased = grid.clone().with_crease(0, 1, 0.5).unwrap();
    let regular = |cage: &loftsman_subdivision::Cage| {
        (0..25).filter(|&f| patch_stencils(cage, f).unwrap().is_some()).count()
    };
    assert_eq!(regular(&grid), 25);
    // Those at either end of the crease: two rows of three, less none.
    assert_eq!(regular(&creased), 25 - 6);
}
