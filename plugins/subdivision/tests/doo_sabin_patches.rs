//! Doo-Sabin surfaces as splines: as near as they say, without gaps, and of grids one.

#![allow(clippy::unwrap_used, reason = "what is missing fails the test")]

use crate::certified::{nearest, pieces, places, point};
use crate::shapes::quadratic_torus;
use loftsman_area_volume::{surface_area, surface_area_of, volume_of};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Functional, Shapes, position};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_subdivision::Cage;
use loftsman_subdivision::doo_sabin::DooSabinSurface;

/// Cages of which there is a surface that does not lie on itself, by equal intervals and others.
fn cages() -> Vec<(String, Cage)> {
    let plain = crate::doo_sabin_surface::some().into_iter().step_by(2);
    let uneven = crate::doo_sabin_intervals::uneven().into_iter().step_by(3);
    let uneven = uneven.map(|(name, cage)| (format!("{name}, by intervals"), cage));
    let flat = |name: &str| name.contains("pillow") || name.contains("true, true") || name.contains("torus");
    let all: Vec<_> = plain.chain(uneven).filter(|(name, _)| !flat(name)).collect();
    assert!(all.len() > 30, "{}", all.len());
    all
}

#[test]
fn they_are_as_near_as_they_say() {
    let (mut looked, mut inexact) = (0, 0);
    for (name, cage) in cages() {
        let surface = DooSabinSurface::new(cage).unwrap();
        let mut counts = Vec::new();
        for tolerance in [1e-2, 1e-4] {
            let patches = surface.patches(tolerance).unwrap();
            assert!(patches.deviation <= tolerance, "{name}");
            assert_eq!(patches.deviation > 0.0, patches.exact < patches.surfaces.len(), "{name}");
            counts.push(patches.surfaces.len());
            inexact += patches.surfaces.len() - patches.exact;
            let pieces = pieces(&patches.surfaces);
            for face in (0..surface.faces().unwrap() as u32).step_by(3) {
                for at in places(face, 9) {
                    let off = nearest(&point(&surface, at), pieces.iter());
                    assert!(off <= patches.deviation + 1e-9, "{name}, {at}: {off:e} {:e}", patches.deviation);
                    looked += 1;
                }
            }
        }
        assert!(counts[1] <= 6 * counts[0] + 400, "{name}: {counts:?}");
    }
    assert!(looked > 5000 && inexact > 1000, "{looked} {inexact}");
}

/// All of the surface is there; and what its cells leave out is no more than is said, and not so very much less.
#[test]
fn nothing_is_left_out_but_what_is_said() {
    let (mut tight, mut count, mut solids) = (f64::INFINITY, 0, 0);
    let area = |surface: &dyn Shape| {
        let mut out = [0.0];
        surface_area().value(&Shapes::one(surface), &mut out).unwrap();
        out[0]
    };
    for (name, cage) in cages() {
        let deep = DooSabinSurface::with_depth(cage.clone(), 14).unwrap();
        let whole = area(&deep);
        let patches = deep.patches(1e-3).unwrap();
        let own: f64 = patches.surfaces.iter().map(|s| surface_area_of(s).unwrap()).sum();
        assert!((own / whole - 1.0).abs() < 2e-3, "{name}: {own} {whole}");
        for depth in [2, 5] {
            let surface = DooSabinSurface::with_depth(cage.clone(), depth).unwrap();
            let (bound, off) = (surface.left_out().unwrap(), (whole - area(&surface)).abs());
            let rounding = 1e-9 * whole;
            assert!(off <= bound.area + rounding, "{name} {depth}: {off:e} {bound:?}");
            if bound.count == 0 {
                assert!(bound.area == 0.0 && off <= rounding, "{name} {depth}: {off:e}");
                continue;
            }
            count += 1;
            let closed = !(0..cage.topology().vertex_count()).any(|v| cage.topology().is_boundary_vertex(v));
            if closed && (0..cage.topology().face_count()).all(|f| !cage.is_hole(f)) {
                let [own, deep] = [&surface, &deep].map(|s| volume_of(s).unwrap());
                assert!(
                    (own - deep).abs() <= bound.volume + rounding,
                    "{name} {depth}: {own} {deep} {bound:?}"
                );
                if (own - deep).abs() > 100.0 * rounding {
                    assert!(
                        bound.volume < 10.0 * (own - deep).abs(),
                        "{name} {depth}: {own} {deep} {bound:?}"
                    );
                    solids += 1;
                }
            }
            if off > 100.0 * rounding {
                tight = tight.min(bound.area / off);
                assert!(bound.area < 40.0 * off, "{name} {depth}: {off:e} {bound:?}");
            }
        }
    }
    println!("bound / left out: {tight} at least");
    assert!(count > 40 && solids > 10, "{count} {solids}");
}

/// The area of such a surface is brought to a value as any other's, with extraordinary points and without.
#[test]
fn areas_are_constrained() {
    let cages = [
        crate::shapes::cube(),
        crate::shapes::grid(6, 8, [true, true], 0.2),
        crate::shapes::fan(5, 4, true, 0.2),
    ];
    for cage in cages {
        let surface = DooSabinSurface::new(cage).unwrap();
        let edit = Edit::new(&surface)
            .ask(surface_area().scale(1.1))
            .ask(position(Location::Face(0, 0.4, 0.6)).keep());
        let done = edit.solve().unwrap();
        let [before, after] = [&surface, done.shape()].map(|s| {
            let mut out = [0.0];
            surface_area().value(&Shapes::one(s), &mut out).unwrap();
            out[0]
        });
        assert!((after / before - 1.1).abs() < 1e-9, "{before} {after}");
    }
}

/// Sides lie on sides of others where the surface is closed; normals point where the surface's do.
#[test]
fn nothing_gapes() {
    let mut sides = 0;
    for (name, cage) in [
        ("cube", crate::shapes::cube()),
        ("fan", crate::shapes::double_fan(5, 0.1)),
        ("tetrahedron", crate::shapes::tetrahedron()),
        ("cube by intervals", crate::shapes::rowed(&crate::shapes::cube(), |row| 0.3 + row as f64)),
    ] {
        let patches = DooSabinSurface::new(cage).unwrap().patches(1e-2).unwrap();
        let pieces = pieces(&patches.surfaces);
        let mut volume = 0.0;
        for (k, (surface, _)) in pieces.iter().enumerate() {
            let [(u0, u1), (v0, v1)] = [surface.u().domain(), surface.v().domain()];
            for t in [0.13, 0.5, 0.77] {
                let (u, v) = (u0 + (u1 - u0) * t, v0 + (v1 - v0) * t);
                for (u, v) in [(u, v0), (u, v1), (u0, v), (u1, v)] {
                    let p = surface.point(u, v).unwrap();
                    let gap = nearest(&p, pieces.iter().enumerate().filter(|(o, _)| *o != k).map(|(_, s)| s));
                    assert!(gap < 1e-12, "{name}, {k}: {gap:e}");
                    sides += 1;
                }
                let [a, b] = [(1, 0), (0, 1)].map(|(i, j)| surface.derivative(u, v, i, j).unwrap());
                volume += surface.point(u, v).unwrap().coords.dot(&a.cross(&b)) * (u1 - u0) * (v1 - v0);
            }
        }
        assert!(volume > 0.0, "{name}: {volume}");
    }
    assert!(sides > 1000, "{sides}");
}

/// A grid is one biquadratic surface, closed or not; by intervals one for each span, of which at double knots there are fewer.
#[test]
fn a_grid_is_exact() {
    for wrap in [[false, false], [true, false], [true, true]] {
        let surface = DooSabinSurface::new(crate::shapes::grid(6, 7, wrap, 0.3)).unwrap();
        let patches = surface.patches(1e-3).unwrap();
        assert_eq!((patches.surfaces.len(), patches.exact, patches.deviation), (1, 1, 0.0), "{wrap:?}");
        let [u, v] =
            [patches.surfaces[0].u(), patches.surfaces[0].v()].map(|s| (s.degree(), s.spans().count()));
        assert_eq!((u.0, v.0, u.1 * v.1), (2, 2, surface.faces().unwrap()), "{wrap:?}");
    }
    let rows = [1.0, 0.0, 2.0, 0.5, 1.0, 0.7];
    let (cage, spline) = quadratic_torus(&rows, &[1.0, 3.0, 0.2, 1.0, 0.0]);
    let surface = DooSabinSurface::new(cage).unwrap();
    let patches = surface.patches(1e-3).unwrap();
    assert_eq!((patches.surfaces.len(), patches.exact, patches.deviation), (5 * 4, 5 * 4, 0.0));
    // Piece by piece, four for each span: places of the same parameters, perhaps turned.
    let mut whole = Vec::new();
    for piece in spline.bezier_patches().unwrap() {
        let [(u0, u1), (v0, v1)] = [piece.u().domain(), piece.v().domain()];
        let at = |k: u32, from: f64, to: f64| from + (to - from) * f64::from(k) / 16.0;
        whole.extend((0..289).map(|k| piece.point(at(k / 17, u0, u1), at(k % 17, v0, v1)).unwrap()));
    }
    for (_, points) in pieces(&patches.surfaces) {
        for (_, _, p) in points {
            let off = whole.iter().map(|q| (q - p).norm()).fold(f64::INFINITY, f64::min);
            assert!(off < 1e-12, "{off:e}");
        }
    }
}

#[test]
fn tolerances_and_sizes() {
    let cage = crate::shapes::double_fan(5, 0.1);
    let surface = DooSabinSurface::new(cage.clone()).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-17] {
        assert!(surface.patches(tolerance).unwrap_err().to_string().contains("tolerance"), "{tolerance}");
    }
    assert!(surface.patches(1e-12).unwrap().deviation <= 1e-12);
    let own = surface.patches(1e-3).unwrap();
    assert_eq!(own, DooSabinSurface::new(cage.clone()).unwrap().patches(1e-3).unwrap());
    for by in [1e-9, 1e9, 1e150] {
        let mut other = cage.clone();
        other.points_mut().iter_mut().for_each(|p| *p *= by);
        let scaled = DooSabinSurface::new(other).unwrap().patches(1e-3 * by).unwrap();
        assert_eq!((scaled.surfaces.len(), scaled.exact), (own.surfaces.len(), own.exact), "{by}");
        assert!((scaled.deviation / by / own.deviation - 1.0).abs() < 1e-9, "{by}");
    }
    let mut huge = cage.clone();
    huge.points_mut().iter_mut().for_each(|p| *p *= 1e308);
    assert!(DooSabinSurface::new(huge).and_then(|s| s.patches(1e300)).is_err());
    // Far from the origin rounding is what it is there, and rectangles are still found.
    let mut far = crate::shapes::grid(6, 7, [false, false], 0.3);
    far.points_mut().iter_mut().for_each(|p| *p += loftsman_kernel::Vector::new(1e6, -1e6, 1e6));
    let far = DooSabinSurface::new(far).unwrap();
    assert_eq!(far.patches(1e-3).unwrap().surfaces.len(), 1);
    let at = Location::Face(0, 0.3, 0.4);
    assert!(nearest(&point(&far, at), pieces(&far.patches(1e-3).unwrap().surfaces).iter()) < 1e-8);
}
