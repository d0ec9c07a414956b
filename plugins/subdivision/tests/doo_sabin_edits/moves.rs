//! Points, derivatives and normals of the limit asked for, dragged, and area and volume kept.

use loftsman_area_volume::{surface_area, surface_area_of, volume, volume_of};
use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{derivative, normal, position};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::solve::Automatic;
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::doo_sabin::DooSabinSurface;

use super::{Case, case, location, moved};
use crate::shapes::plain::Plain;
use crate::shapes::wild::{self, Dice};

/// A place moved, a derivative kept at another, the plane held at a third: by hand it is so, and what was asked cost the least, for nothing that no row
/// reaches has moved.
#[test]
fn places_derivatives_and_normals_are_met() {
    let mut seen = 0;
    for seed in 0..160 {
        let Some(case) = case(seed) else { continue };
        let (size, name) = (case.size, &case.name);
        let mut dice = Dice::new(seed + 71_000);
        let [a, b, c] = [0, 1, 2].map(|_| case.place(&mut dice));
        if [b, c].contains(&a) || b == c {
            continue;
        }
        let before = [a, b, c].map(|at| case.spot(&case.surface, at));
        let wanted = before[0].place + dice.vector() * (0.1 * size);
        let slope = before[1].along[0];
        let facing = before[2].normal();
        let edited = Edit::new(&case.surface)
            .ask(position(location(a)).to(Point::from(wanted)))
            .ask(derivative(location(b), [1, 0]).keep())
            .ask(normal(location(c), facing).hold())
            .solve();
        // Where all three are on few vertices they may say too much at once, and then say so.
        let edited = match edited {
            Ok(edited) => edited,
            Err(e) if e.to_string().contains("contradict") => continue,
            Err(e) => panic!("{name}: {e}"),
        };
        let after = [a, b, c].map(|at| case.spot(edited.shape(), at));
        assert!((after[0].place - wanted).norm() < 1e-12 * size, "{name}: {}", after[0].place - wanted);
        assert!((after[1].along[0] - slope).norm() < 1e-12 * size, "{name}: {}", after[1].along[0]);
        let [u, v] = after[2].along.map(|x| x.dot(&facing));
        assert!(u.abs().max(v.abs()) < 1e-12 * size, "{name}: {u:e} {v:e}");
        // A face depends on the vertices of the faces round its corner's.
        let reached: Vec<usize> = [a, b, c]
            .iter()
            .flat_map(|(face, _)| {
                let (of, corner) = case.surface.cage_corner(*face).unwrap();
                let vertex = case.plain.faces[of][corner];
                case.plain.faces.iter().filter(move |f| f.contains(&vertex)).flatten().copied()
            })
            .collect();
        let all = moved(&case.plain, edited.shape());
        for (v, (p, q)) in case.plain.points.iter().zip(&all.points).enumerate() {
            assert!(p == q || reached.contains(&v), "{name}: vertex {v} moved");
        }
        seen += 1;
    }
    assert!(seen > 90, "{seen}");
}

/// The plane at extraordinary points: at middles of faces that are no quads by the first wave round them, at vertices by that of the face that they become.
#[test]
fn normals_are_turned_at_extraordinary_points() {
    let mut seen = 0;
    for seed in 0..160 {
        let Some(case) = case(seed) else { continue };
        let (size, name) = (case.size, &case.name);
        let mut dice = Dice::new(seed + 72_000);
        let face = dice.below(case.surface.faces().unwrap()) as u32;
        let at = (face, [f64::from(dice.below(2) as u32); 2]);
        let before = case.spot(&case.surface, at);
        let facing = (before.normal() + dice.vector() * 0.2).normalize();
        let wanted = before.place + dice.vector() * (0.1 * size);
        let edited = Edit::new(&case.surface)
            .ask(position(location(at)).to(Point::from(wanted)))
            .ask(normal(location(at), facing).hold())
            .solve()
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        let after = case.spot(edited.shape(), at);
        assert!((after.place - wanted).norm() < 1e-12 * size, "{name}: {}", after.place - wanted);
        assert!((after.normal() - facing).norm() < 1e-10, "{name}: {} {facing}", after.normal());
        seen += 1;
    }
    assert!(seen > 110, "{seen}");
}

/// Each event takes the place to the cursor while another stays; many are one, and what is dragged back is where it was.
#[test]
fn a_session_drags_a_place_of_the_limit() {
    let mut seen = 0;
    for seed in 0..100 {
        let Some(case) = case(seed) else { continue };
        let (size, name) = (case.size, &case.name);
        let mut dice = Dice::new(seed + 73_000);
        let (hand, still) = (case.place(&mut dice), case.place(&mut dice));
        if hand == still {
            continue;
        }
        let [start, kept] = [hand, still].map(|at| case.spot(&case.surface, at).place);
        let edit = || Edit::new(&case.surface).ask(position(location(still)).keep());
        let Ok(mut drag) = edit().handle(position(location(hand))).prepare(Automatic) else { continue };
        let mut to = start;
        for event in 0..6 {
            to = start + dice.vector() * (0.3 * size);
            let shape = drag.to_point(Point::from(to)).unwrap_or_else(|e| panic!("{name}: {e}")).clone();
            let [here, there] = [hand, still].map(|at| case.spot(&shape, at).place);
            assert!((here - to).norm() < 1e-12 * size, "{name}, event {event}: {}", here - to);
            assert!((there - kept).norm() < 1e-12 * size, "{name}, event {event}: {}", there - kept);
        }
        let once = edit().ask(position(location(hand)).to(Point::from(to))).solve().unwrap();
        let (dragged, once) = (moved(&case.plain, drag.shape()), moved(&case.plain, once.shape()));
        for (p, q) in dragged.points.iter().zip(&once.points) {
            assert!((p - q).norm() < 1e-12 * size, "{name}: {p} {q}");
        }
        let back = moved(&case.plain, drag.to_point(Point::from(start)).unwrap());
        for (p, q) in case.plain.points.iter().zip(&back.points) {
            assert!((p - q).norm() < 1e-12 * size, "{name}: {p} {q}");
        }
        seen += 1;
    }
    assert!(seen > 60, "{seen}");
}

/// Area and volume by refinement by hand: three and four levels, and what a level less is off by taken away.
fn measures(plain: &Plain) -> [f64; 2] {
    let three = (0..3).fold(plain.clone(), |plain, _| plain.dual());
    let (a, b) = (three.measures(), three.dual().measures());
    [0, 1].map(|k| b[k] + (b[k] - a[k]) / 3.0)
}

/// A place moved, area or volume kept or both, by the measure of the surface and by that of its refinements.
#[test]
fn area_and_volume_are_kept() {
    let mut seen = 0;
    for seed in 0..18 {
        let size = [1.0, 1e-9, 1e9][(seed % 3) as usize];
        let mut plain = wild::closed(seed);
        plain.points.iter_mut().for_each(|p| *p *= size);
        if plain.faces.len() > 11 {
            continue;
        }
        let Ok(surface) = DooSabinSurface::new(plain.cage().unwrap()) else { continue };
        let mut dice = Dice::new(seed + 74_000);
        let case = Case { plain, surface, size, name: format!("{seed}, size {size:e}") };
        let at = case.place(&mut dice);
        let before = case.spot(&case.surface, at);
        // Outwards, so that there is more of both if nothing is kept.
        let wanted = Point::from(before.place + before.normal() * (0.15 * size));
        let ask = || Edit::new(&case.surface).ask(position(location(at)).to(wanted));
        let by_hand = |surface: &DooSabinSurface| measures(&moved(&case.plain, surface));
        let was = by_hand(&case.surface);
        let free = ask().solve().unwrap();
        let off = |now: [f64; 2], k: usize| (now[k] / was[k] - 1.0).abs();
        let (with_area, with_volume) = (seed % 3 != 1, seed % 3 != 2);
        let edit = if with_area { ask().ask(surface_area().keep()) } else { ask() };
        let edit = if with_volume { edit.ask(volume().keep()) } else { edit };
        let edited = edit.solve().unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let after = edited.shape();
        let (changed, now) = (by_hand(free.shape()), by_hand(after));
        assert!((case.spot(after, at).place - wanted.coords).norm() < 1e-12 * size, "{}", case.name);
        if with_area {
            let share = surface_area_of(after).unwrap() / surface_area_of(&case.surface).unwrap();
            assert!((share - 1.0).abs() < 1e-9, "{}: {share}", case.name);
            // Refinement is off by as much before as after but for what the edit changes.
            assert!(
                off(now, 0) < 0.02 * off(changed, 0) + 1e-6,
                "{}: {was:?} {now:?} {changed:?}",
                case.name
            );
        }
        if with_volume {
            let share = volume_of(after).unwrap() / volume_of(&case.surface).unwrap();
            assert!((share - 1.0).abs() < 1e-9, "{}: {share}", case.name);
            assert!(
                off(now, 1) < 1e-3 * off(changed, 1) + 1e-9,
                "{}: {was:?} {now:?} {changed:?}",
                case.name
            );
        }
        seen += 1;
    }
    assert!(seen > 6, "{seen}");
}

/// What vertex would have to be where is not said twice: two different places for one point are refused by name.
#[test]
fn two_places_for_one_point_are_refused() {
    let surface = DooSabinSurface::new(crate::shapes::cube()).unwrap();
    let edit = Edit::new(&surface).ask(position(location((0, [1.0, 1.0]))).to(Point::origin()));
    let vertex = crate::shapes::cube().topology().face(0)[0];
    let again = Location::Vertex(vertex);
    let refused = edit.ask(position(again).to(Point::from(Vector::x()))).solve().unwrap_err().to_string();
    assert!(refused.contains(&format!("vertex {vertex}")), "{refused}");
}
