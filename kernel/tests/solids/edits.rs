//! Edits of single faces, with neighbours and without.

use loftsman_kernel::Vector;
use loftsman_kernel::brep::{Brep, Moving, SurfaceForm};
use loftsman_kernel::edit::{Ask, Edit, Edited};
use loftsman_kernel::functional::position;
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::Automatic;

use super::family::{block, cylinder, parted_ball};
use super::{gaps, size};
use loftsman_kernel::Point;
use loftsman_kernel::brep::{CurveForm, Edge, Face, Frame, Parts, Shell, Solid, Use, Vertex};
use loftsman_kernel::spline::{Direction, Space, Surface};

/// A place in the middle of a face's box of parameters.
fn middle(brep: &Brep, face: u32) -> Location {
    let curves = brep.parameter_curves(face as usize).unwrap();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for curve in curves.iter().flatten() {
        let (a, b) = curve.curve.curve().bounds();
        for k in 0..2 {
            low[k] = low[k].min(a[k]);
            high[k] = high[k].max(b[k]);
        }
    }
    Location::Face(face, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]))
}

pub(super) fn pulled(brep: &Brep, at: Location, by: Vector) -> Edited<Brep> {
    let edited = Edit::new(brep).ask(position(at).by(by)).solve().unwrap();
    let before = brep.value(at, Default::default()).unwrap();
    let after = edited.shape().value(at, Default::default()).unwrap();
    assert!((after - before - by).norm() < 1e-12 * size(brep), "{} {}", after - before, by);
    edited
}

#[test]
fn a_face_of_a_block_bulges_between_edges_that_stay_to_the_bit() {
    let block = block();
    for face in 0..6 {
        let at = middle(&block, face);
        let edited = pulled(&block, at, Vector::new(0.25, -0.125, 0.5));
        let after = edited.shape();
        let worst = gaps(after).into_iter().fold(0.0, f64::max);
        assert!(worst <= 1e-14 * size(&block), "{face}: {worst:e}");
        for edge in 0..12 {
            assert_eq!(after.edge(edge), block.edge(edge), "{face} {edge}");
        }
        for other in (0..6).filter(|other| *other != face) {
            assert_eq!(after.surface(other as usize), block.surface(other as usize));
            assert_eq!(after.surface_form(other as usize), block.surface_form(other as usize));
        }
        assert_eq!(after.surface_form(face as usize), SurfaceForm::Spline);
        assert_eq!(after.flaws(1e-14).unwrap(), vec![]);
        assert!(edited.report().to_string().contains("1 face moved"), "{}", edited.report());
        assert_eq!(edited.undo(), block);
    }
}

#[test]
fn neighbours_of_a_block_go_along_exactly() {
    let block = block();
    for rings in 1..3 {
        let free = block.clone().moving(Moving::new().neighbours(rings));
        for face in 0..6 {
            let edited = pulled(&free, middle(&block, face), Vector::new(0.25, -0.125, 0.5));
            let after = edited.shape();
            let worst = gaps(after).into_iter().fold(0.0, f64::max);
            assert!(worst <= 1e-13 * size(&block), "{rings} {face}: {worst:e} {}", edited.report());
            assert_eq!(after.flaws(1e-13).unwrap(), vec![], "{}", edited.report());
            assert!(edited.report().to_string().contains("no edge opened"), "{}", edited.report());
        }
    }
}

#[test]
fn a_cylinder_and_its_caps() {
    let cylinder = cylinder(1.5, 2.0);
    for (face, rings) in [(0, 0), (1, 0), (2, 0), (0, 1), (2, 1), (1, 2)] {
        let free = cylinder.clone().moving(Moving::new().neighbours(rings));
        let edited = pulled(&free, middle(&cylinder, face), Vector::new(0.2, 0.1, 0.15));
        let after = edited.shape();
        let worst = gaps(after).into_iter().fold(0.0, f64::max);
        // Caps have circles that are no knot lines of theirs: the side follows them at places.
        let bound = if rings == 0 { 1e-13 } else { 1e-6 };
        assert!(worst <= bound * size(&cylinder), "{face} {rings}: {worst:e} {}", edited.report());
        for (edge, gap) in gaps(after).into_iter().enumerate() {
            let tolerance = after.edge(edge).unwrap().tolerance;
            // A search for the nearest point is done where squares of distances no longer fall: it is beside it by some 1e-8 of the size.
            let allowed = (1.02 * tolerance).hypot(3e-8 * size(&cylinder)) + 1e-13;
            assert!(
                gap <= if rings == 0 { 1.02 * tolerance + 1e-13 } else { allowed },
                "{face} {rings}: edge {edge} is open by {gap:e}, and says {tolerance:e}"
            );
        }
        assert_eq!(after.flaws(1e-13).unwrap(), vec![], "{}", edited.report());
    }
}

#[test]
fn a_drag_comes_to_the_same_as_an_edit() {
    let block = block();
    let at = middle(&block, 1);
    let free = block.clone().moving(Moving::new().neighbours(1));
    let target = block.value(at, Default::default()).unwrap() + Vector::new(0.1, 0.2, 0.3);
    let mut drag = Edit::new(&free).handle(position(at)).prepare(Automatic).unwrap();
    for k in 0..10 {
        let share = f64::from(k) / 9.0;
        let to = block.value(at, Default::default()).unwrap() * (1.0 - share) + target * share;
        drag.to_point(to.into()).unwrap();
        // Edges are where the faces are at every event.
        let now = drag.shape().openings().unwrap();
        assert!(now.iter().all(|o| o.gap < 1e-13 && o.off < 1e-13), "{now:?}");
    }
    let dragged = drag.commit().unwrap();
    let edited = Edit::new(&free).ask(position(at).to(target)).solve().unwrap();
    let apart = dragged.shape().points().iter().zip(edited.shape().points()).map(|(a, b)| (a - b).norm());
    assert!(apart.fold(0.0, f64::max) < 1e-13);
    assert_eq!(dragged.undo(), block);
}

#[test]
fn what_cannot_move_is_refused_in_words() {
    let block = block();
    let refused = |brep: &Brep, at: Location, says: &str| {
        let error = Edit::new(brep).ask(position(at).by(Vector::z())).solve().unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    };
    let rim = |brep: &Brep| {
        let curve = &brep.parameter_curves(1).unwrap()[0][0].curve;
        let at = curve.ends().unwrap();
        Location::Face(1, 0.5 * (at[0][0] + at[1][0]), 0.5 * (at[0][1] + at[1][1]))
    };
    refused(&block, rim(&block), "let the neighbours move too");
    refused(&block, Location::Face(7, 0.5, 0.5), "there is no face 7");
    refused(&block, Location::Surface(0.5, 0.5), "face");
    // With them it moves.
    let free = block.clone().moving(Moving::new().neighbours(1));
    let edited = pulled(&free, rim(&block), Vector::new(0.1, 0.0, 0.2));
    assert!(gaps(edited.shape()).into_iter().all(|gap| gap <= 1e-13 * size(&block)));
    let error = Edit::new(&block).lock([0]).ask(position(middle(&block, 1)).by(Vector::z())).solve();
    assert!(error.unwrap_err().to_string().contains("lock none of them"));
}

#[test]
fn the_nearest_place_of_a_solid_is_on_a_face() {
    let cylinder = cylinder(1.5, 2.0);
    for face in 0..3 {
        let at = middle(&cylinder, face);
        let point = cylinder.value(at, Default::default()).unwrap();
        let found = cylinder.closest(point.into()).unwrap();
        assert!(found.distance < 1e-12 && found.face == face as usize, "{face}: {found:?}");
    }
    // Above the corner of a block: its vertex.
    let block = block();
    let corner = Point::new(2.0, 2.5, 3.0);
    let found = block.closest(corner + Vector::new(1.0, 1.0, 1.0)).unwrap();
    assert!(
        (found.point - corner).norm() < 1e-9 && (found.distance - 3.0_f64.sqrt()).abs() < 1e-9,
        "{found:?}"
    );
}

/// Of a surface with many bumps a face is a window: the nearest place is that of the window, however near the rest of the surface comes, and not
/// one of the places that are only nearer than those around them.
#[test]
fn the_nearest_place_of_a_face_is_inside_its_loops_and_the_nearest_of_all() {
    let count = 30;
    let net = (0..count * count).map(|k| {
        let (x, y) = ((k / count) as f64, (k % count) as f64);
        Point::new(x, y, 2.5 * (1.3 * x).sin() * (1.1 * y + 0.4).cos() + 0.02 * x)
    });
    let space = || Space::clamped_uniform(3, count).unwrap();
    let surface = Surface::new(space(), space(), net.collect()).unwrap();
    let (low, high) = ([0.22, 0.31], [0.71, 0.64]);
    let corners = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
    let vertices = corners
        .iter()
        .map(|at| Vertex { point: surface.point(at[0], at[1]).unwrap(), tolerance: 1e-9 })
        .collect();
    let edges = [
        (Direction::V, low[1], [low[0], high[0]], [0, 1]),
        (Direction::U, high[0], [low[1], high[1]], [1, 2]),
        (Direction::V, high[1], [low[0], high[0]], [3, 2]),
        (Direction::U, low[0], [low[1], high[1]], [0, 3]),
    ]
    .map(|(direction, at, range, ends)| Edge {
        curve: surface.isocurve(direction, at).unwrap(),
        range: (range[0], range[1]),
        ends,
        tolerance: 1e-9,
        form: CurveForm::Spline,
    })
    .to_vec();
    let uses = (0..4).map(|edge| Use { edge, reversed: edge > 1, parameters: None }).collect();
    let face = Face {
        name: None,
        color: None,
        surface: surface.clone(),
        form: SurfaceForm::Spline,
        reversed: false,
        loops: vec![uses],
        points: Vec::new(),
    };
    let shells = vec![Shell { faces: vec![0] }];
    let brep = Brep::new(Parts { vertices, edges, faces: vec![face], shells, solids: Vec::new() }).unwrap();
    let grid = 300;
    let samples: Vec<_> = (0..=grid * grid + 2 * grid)
        .map(|k| [k / (grid + 1), k % (grid + 1)])
        .map(|k| [0, 1].map(|d: usize| low[d] + (high[d] - low[d]) * (k[d] as f64 / grid as f64)))
        .map(|at| surface.point(at[0], at[1]).unwrap())
        .collect();
    let mut outside = 0;
    for k in 0..60 {
        let x = f64::from(k);
        let point = Point::new(
            29.0 * (0.618_034 * x).fract(),
            29.0 * (0.414_214 * x).fract(),
            8.0 * (0.732_051 * x).fract() - 4.0,
        );
        let found = brep.closest(point).unwrap();
        let least = samples.iter().map(|p| (p - point).norm()).fold(f64::INFINITY, f64::min);
        assert!(found.distance <= least + 1e-7, "{k}: {} where {least} is known", found.distance);
        for d in 0..2 {
            assert!(found.at[d] >= low[d] - 1e-6 && found.at[d] <= high[d] + 1e-6, "{k}: {:?}", found.at);
        }
        outside += usize::from(surface.closest(point).unwrap().distance < found.distance - 0.01);
    }
    assert!(outside > 20, "of {outside} points all of the surface is nearer");
}

/// Places on edges, at corners too, as each of the faces there has them: all faces that meet there get what can move.
#[test]
fn places_on_edges_and_corners_move_with_all_faces_there() {
    // What is left between places on the rim of a cap is a part of the way; a block's edges are lines of both of their faces.
    for (name, brep, bound) in [("block", block(), 1e-13), ("cylinder", cylinder(1.5, 2.0), 1e-5)] {
        let free = brep.clone().moving(Moving::new().neighbours(2));
        let mut done = 0;
        for edge in 0..brep.edge_count() {
            for place in brep.uses(edge) {
                let curve = &brep.parameter_curves(place.face).unwrap()[place.chain][place.number].curve;
                let (from, to) = curve.range();
                for share in [0.0, 0.05, 0.45, 1.0] {
                    let t = if share == 1.0 { to } else { from + (to - from) * share };
                    let at = curve.curve().point(t).unwrap();
                    let surface = brep.surface(place.face).unwrap();
                    let into = |t: f64, (a, b): (f64, f64)| t.clamp(a, b);
                    let (u, v) = (into(at.x, surface.u().domain()), into(at.y, surface.v().domain()));
                    let by = Vector::new(0.05, -0.02, 0.03);
                    let edited = pulled(&free, Location::Face(place.face as u32, u, v), by);
                    let after = edited.shape();
                    let worst = gaps(after).into_iter().fold(0.0, f64::max);
                    assert!(
                        worst <= bound * size(&brep),
                        "{name} {edge} {place:?} {share}: {worst:e} {}",
                        edited.report()
                    );
                    assert!(
                        edited.report().condition < 1e8,
                        "{name} {edge} {place:?} {share}: {}",
                        edited.report().condition
                    );
                    assert_eq!(
                        after.flaws(1e-13).unwrap(),
                        vec![],
                        "{name} {edge} {share}: {}",
                        edited.report()
                    );
                    done += 1;
                }
            }
        }
        assert!(done >= 24, "{name}: {done}");
    }
}

/// A ball and a ring, each one face without edges, stay closed where they may become sharp: their seams and poles do not tear.
#[test]
fn whole_surfaces_stay_closed_where_they_may_become_sharp() {
    let frame = Frame::new(Point::new(0.3, -1.0, 2.0), Vector::new(0.2, 0.1, 1.0), Vector::x()).unwrap();
    let mut refused = 0;
    for form in
        [SurfaceForm::Sphere { frame, radius: 2.0 }, SurfaceForm::Torus { frame, major: 3.0, minor: 1.0 }]
    {
        let surface = form.covering(&[]).unwrap();
        let (u, v) = (surface.u().domain(), surface.v().domain());
        let face = Face {
            name: None,
            color: None,
            surface: surface.clone(),
            form,
            reversed: false,
            loops: vec![],
            points: vec![],
        };
        let (shells, solids) = (vec![Shell { faces: vec![0] }], vec![Solid::default()]);
        let brep = Brep::new(Parts { faces: vec![face], shells, solids, ..Parts::default() }).unwrap();
        for share in
            [[0.0, 0.5], [0.001, 0.3], [0.37, 0.61], [0.99, 0.02], [0.5, 0.0], [1.0, 1.0], [0.25, 0.5]]
        {
            let at = [u.0 + share[0] * (u.1 - u.0), v.0 + share[1] * (v.1 - v.0)];
            let asked = position(Location::Face(0, at[0], at[1])).by([0.1, -0.2, 0.15]);
            let free = brep.clone().moving(Moving::new().sharp());
            let Ok(edited) = Edit::new(&free).smooth(0).ask(asked).solve() else {
                refused += 1;
                continue;
            };
            let after = edited.shape();
            assert!(after.is_closed(&[0]), "{share:?}: {}", edited.report());
            let moved = after.surface(0).unwrap().point(at[0], at[1]).unwrap();
            let wanted = surface.point(at[0], at[1]).unwrap() + Vector::new(0.1, -0.2, 0.15);
            assert!((moved - wanted).norm() < 1e-12, "{share:?}: {moved} {wanted}");
        }
    }
    assert_eq!(refused, 0);
}

/// Faces of a ball whose loops cross its seam, and have its poles inside, without an edge there: the surface closes and its poles are points as before where it may become
/// sharp, whichever face moves, alone or with the other one.
#[test]
fn surfaces_stay_closed_inside_loops_where_they_may_become_sharp() {
    let (mut refused, mut tried, mut seams, mut tips) = (0, 0, 0, 0);
    for (normal, height) in [
        (Vector::z(), 0.5),
        (Vector::new(0.4, 0.2, 1.0), 0.0),
        (Vector::x(), 1.2),
        (Vector::new(1.0, 0.3, 0.2), 0.8),
        (-Vector::x(), 1.0),
    ] {
        let ball = parted_ball(normal, height);
        let seam = ball.surface(0).unwrap();
        let (u, v) = (seam.u().domain(), seam.v().domain());
        // On the seam, beside it, in a pole, far from all of them.
        for share in [[0.0, 0.5], [0.01, 0.45], [0.4, 1.0], [0.5, 0.4]] {
            for neighbours in [0, 1] {
                let at = [u.0 + share[0] * (u.1 - u.0), v.0 + share[1] * (v.1 - v.0)];
                let point = seam.point(at[0], at[1]).unwrap();
                let found = ball.closest(point).unwrap();
                let (face, [s, t]) = (found.face as u32, found.at);
                let by = Vector::new(0.05, -0.1, 0.08);
                let free = ball.clone().moving(Moving::new().sharp().neighbours(neighbours));
                let asked = position(Location::Face(face, s, t)).by(by);
                tried += 1;
                let Ok(edited) = Edit::new(&free).smooth(0).ask(asked).solve() else {
                    refused += 1;
                    continue;
                };
                let after = edited.shape();
                // A face that needs less of the surface has a part of it, from another place around.
                let surface = after.surface(face as usize).unwrap();
                let (around, along) = (surface.u().domain(), surface.v().domain());
                let closes = around.1 - around.0 > u.1 - u.0 - 1e-12;
                let poles = [along.0, along.1].map(|end| v.0 == end || v.1 == end);
                (seams, tips) = (seams + usize::from(closes), tips + usize::from(poles.contains(&true)));
                for k in 0..=20 {
                    let share = f64::from(k) / 20.0;
                    let x = around.0 + share * (around.1 - around.0);
                    let y = along.0 + share * (along.1 - along.0);
                    let gap =
                        (surface.point(around.0, y).unwrap() - surface.point(around.1, y).unwrap()).norm();
                    assert!(!closes || gap < 1e-12, "{normal}, {share}: the seam opens by {gap}");
                    for (end, _) in [along.0, along.1].into_iter().zip(poles).filter(|(_, is)| *is) {
                        let wide = surface.point(x, end).unwrap() - surface.point(around.0, end).unwrap();
                        assert!(wide.norm() < 1e-12, "{normal}: a pole is {wide}");
                    }
                }
                let moved = after.surface(face as usize).unwrap().point(s, t).unwrap();
                assert!((moved - (point + by)).norm() < 1e-9, "{normal}, {at:?}: {moved}");
            }
        }
    }
    assert!(refused <= tried / 4, "{refused} of {tried}");
    assert!(seams >= 20 && tips >= 20, "{seams} seams, {tips} poles");
}
