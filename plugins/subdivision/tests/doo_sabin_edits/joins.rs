//! Joins, to one another, to splines and to themselves; symmetry; falloff.

use std::collections::BTreeMap;

use loftsman_kernel::edit::{Ask, Edit, Metric};
use loftsman_kernel::functional::{Edge, join, position, symmetry};
use loftsman_kernel::nalgebra::Rotation3;
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::doo_sabin::DooSabinSurface;

use super::{Case, case, moved, on_side, side};
use crate::shapes::duals::spot;
use crate::shapes::plain::Plain;
use crate::shapes::wild::{self, Dice};
use crate::wild_edits::{butterfly, changed_inside, side as along};

fn shape(plain: &Plain) -> DooSabinSurface {
    DooSabinSurface::new(plain.cage().unwrap()).unwrap()
}

/// The sides of the surface along a row of boundary vertices, each with the vertex behind it: `(face, inner, outer)` for both halves of each face but those
/// at the row's ends, whose one corner is on the boundary.
fn halves(plain: &Plain, row: &[[usize; 2]]) -> Vec<(usize, usize, usize)> {
    let edges = plain.edges();
    let face = |k: usize| {
        let [a, b] = [row[k][0], row[k + 1][0]];
        edges[&[a.min(b), a.max(b)]][0]
    };
    let inside = 1..row.len() - 1;
    inside.flat_map(|k| [(face(k - 1), row[k][1], row[k][0]), (face(k), row[k][1], row[k][0])]).collect()
}

/// A sheet with a row of its boundary, changed inside as far as the first row of faces allows.
fn sheet(count: usize, dice: &mut Dice, changes: bool) -> (Plain, Vec<[usize; 2]>) {
    loop {
        let which = dice.below(4);
        let other = 4 + dice.below(2);
        let (rows, columns) = if which < 2 { (other, count) } else { (count, other) };
        let row = along(rows, columns, which);
        let mut plain = wild::sheet(rows, columns, 0.3, dice);
        if changes {
            plain = changed_inside(plain, &row, 0, dice);
        }
        if DooSabinSurface::new(plain.cage().unwrap()).is_ok() {
            return (plain, row);
        }
    }
}

/// Two random sheets along random sides: by hand, places are the same and derivatives across opposite; of sheets of quads the second
/// derivatives across, too, which are `P - 2 Q + R` of three rows of vertices.
#[test]
fn two_limits_meet_along_a_whole_side() {
    let mut changed = 0;
    for seed in 0..54 {
        let mut dice = Dice::new(seed + 61_000);
        let order = (seed % 3) as usize;
        let count = 3 + dice.below(4);
        let size = [1.0, 1e-9, 1e9][(seed / 3 % 3) as usize];
        let [(mut a, left), (mut b, mut right)] = [0, 1].map(|_| sheet(count, &mut dice, order < 2));
        changed += usize::from(a.faces.iter().chain(&b.faces).any(|f| f.len() != 4));
        if dice.below(2) == 0 {
            right.reverse();
        }
        for ([v, _], [w, _]) in left.iter().zip(&right) {
            b.points[*w] = a.points[*v] + dice.vector() * 0.05;
        }
        a.points.iter_mut().chain(&mut b.points).for_each(|p| *p *= size);
        let (one, other) = (shape(&a), shape(&b));
        let (mine, theirs) = (halves(&a, &left), halves(&b, &right));
        let ask = |edit: Edit<DooSabinSurface>, (x, y): (&(usize, usize, usize), &(usize, usize, usize))| {
            let (i, j) = (side(&one, x.0, x.1, x.2), side(&other, y.0, y.1, y.2));
            edit.ask(join(Edge::Number(i), 1, Edge::Number(j), order).keep())
        };
        let edit = mine.iter().zip(&theirs).fold(Edit::new(&one).with(other.boxed()), ask);
        let edited = edit.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        assert!(edited.report().adjustment > 1e-3 * size, "{seed}: they did not meet before");
        let (a, b) = (moved(&a, edited.shape()), moved(&b, edited.shape_at(1).unwrap()));
        for (x, y) in mine.iter().zip(&theirs) {
            for t in [0.0, 0.25, 0.625, 1.0] {
                let [[p, into], [q, out]] =
                    [(&a, x), (&b, y)].map(|(plain, &(f, i, o))| on_side(plain, f, i, o, t));
                let (off, turned) = ((p - q).norm(), (into + out).norm());
                assert!(off < 1e-12 * size, "{seed}, order {order}: {off:e} apart at {t}");
                assert!(order < 1 || turned < 1e-12 * size, "{seed}: derivatives {turned:e} apart at {t}");
            }
        }
        if order == 2 {
            let second = |plain: &Plain, row: &[[usize; 2]], k: usize| {
                let [v, w] = row[k];
                // The third is the one after the second, as the second is after the first.
                let third = (2 * w).wrapping_sub(v);
                plain.points[v] - plain.points[w] * 2.0 + plain.points[third]
            };
            for k in 0..count {
                let off = (second(&a, &left, k) - second(&b, &right, k)).norm();
                assert!(off < 1e-11 * size, "{seed}: second derivatives {off:e} apart at vertex {k}");
            }
        }
    }
    assert!(changed > 12, "{changed}");
}

/// Places of a side of a limit by hand, with the derivatives into it, and the nearest places of a spline's edge.
fn gap(plain: &Plain, half: (usize, usize, usize), spline: &dyn Shape, number: usize) -> [f64; 2] {
    let edge = spline.edges().unwrap().edge(number).unwrap();
    let out = if edge.at_end { -1.0 } else { 1.0 };
    let by = if edge.along_u { [0, 1] } else { [1, 0] };
    let off = |turned: bool| {
        let mut most = [0.0_f64; 2];
        for t in [0.0, 0.25, 0.625, 1.0] {
            let [p, into] = on_side(plain, half.0, half.1, half.2, t);
            let share = if turned { 1.0 - t } else { t };
            let at = edge.at(edge.start + (edge.end - edge.start) * share);
            let value = |by| spline.value(at, Derivative::from(by)).unwrap();
            most[0] = most[0].max((p - value([0, 0])).norm());
            most[1] = most[1].max((into + value(by) * out).norm());
        }
        most
    };
    let [a, b] = [false, true].map(off);
    if a[0] < b[0] { a } else { b }
}

#[test]
fn a_limit_meets_a_spline() {
    for seed in 0..24 {
        let mut dice = Dice::new(seed + 62_000);
        let (plain, row) = sheet(4, &mut dice, true);
        let a = shape(&plain);
        let half = halves(&plain, &row)[dice.below(4)];
        let number = side(&a, half.0, half.1, half.2);
        let degree = 2 + (seed % 3) as usize;
        let line = Space::clamped_uniform(degree, degree + 1).unwrap();
        let net = (0..(degree + 1) * (degree + 1)).map(|_| Point::from(dice.vector() * 3.0)).collect();
        let patch = Surface::new(line.clone(), line, net).unwrap();
        for order in 0..=1 {
            let edit = Edit::new(&a).with(Box::new(patch.clone()));
            let edited = edit.ask(join(Edge::Number(number), 1, Edge::UStart, order).keep()).solve().unwrap();
            let right = edited.shape_at(1).unwrap();
            let start = right.edges().unwrap().iter().position(|e| e.name == "u0").unwrap();
            let off = gap(&moved(&plain, edited.shape()), half, right, start);
            assert!(off[..=order].iter().all(|x| *x < 1e-12), "{seed}, order {order}: {off:?}");
            // And the other way round: the spline first, the limit as it is.
            let edit = Edit::new(&patch).with(a.boxed()).lock_on(1, 0..plain.points.len() as i64);
            let edited = edit.ask(join(Edge::UStart, 1, Edge::Number(number), order).keep()).solve().unwrap();
            let off = gap(&plain, half, edited.shape(), start);
            assert!(off[..=order].iter().all(|x| *x < 1e-12), "{seed}, order {order}: {off:?}");
        }
    }
}

#[test]
fn a_limit_closes_onto_itself() {
    // A strip bent to a ring that does not quite close.
    let mut cage = crate::shapes::grid(9, 5, [false, false], 0.05);
    for (k, p) in cage.points_mut().iter_mut().enumerate() {
        let turn = 0.95 * std::f64::consts::TAU * (k / 5) as f64 / 8.0;
        *p = Point::new(2.0 * turn.cos() + p.z, 2.0 * turn.sin(), p.y);
    }
    let plain = Plain::of(&cage);
    let strip = DooSabinSurface::new(cage).unwrap();
    let [first, last] = [0, 1].map(|which| halves(&plain, &along(9, 5, which)));
    for order in 0..=1 {
        let edit = first.iter().zip(&last).fold(Edit::new(&strip), |edit, (x, y)| {
            let (i, j) = (side(&strip, x.0, x.1, x.2), side(&strip, y.0, y.1, y.2));
            edit.ask(join(Edge::Number(i), 0, Edge::Number(j), order).keep())
        });
        let edited = edit.solve().unwrap();
        let ring = moved(&plain, edited.shape());
        for (x, y) in first.iter().zip(&last) {
            for t in [0.0, 0.375, 1.0] {
                let [[p, into], [q, out]] = [x, y].map(|&(f, i, o)| on_side(&ring, f, i, o, t));
                assert!((p - q).norm() < 1e-12, "order {order}: {p} {q}");
                assert!(order == 0 || (into + out).norm() < 1e-12, "{into} {out}");
            }
        }
    }
}

/// Sheets by end intervals, the same along the side and others across it: their boundaries are the quadratics of `(b P + a Q) / (a + b)`, `P` and `Q` being the
/// first two rows and `a` and `b` their intervals, and the derivatives across those of `b (Q - P) / (a + b)`.
#[test]
fn sheets_by_intervals_meet() {
    for seed in 0..30 {
        let mut dice = Dice::new(seed + 63_000);
        let (rows, columns) = (4, 4 + dice.below(3));
        let order = dice.below(2);
        let mut interval =
            |count: usize| -> Vec<f64> { (0..count).map(|_| 4.0_f64.powf(dice.number())).collect() };
        let common = interval(columns);
        let across = [interval(rows), interval(rows)];
        let mut make = |across: &[f64], to: f64| {
            let mut plain = wild::sheet(rows, columns, 0.2, &mut dice);
            plain.points.iter_mut().for_each(|p| p.x += to);
            let mut cage = plain.cage().unwrap();
            for e in 0..cage.topology().edge_count() {
                let [v, w] = cage.topology().edge(e).unwrap().map(|v| v as usize);
                for [v, w] in [[v, w], [w, v]] {
                    let d =
                        if v / columns == w / columns { common[v % columns] } else { across[v / columns] };
                    cage = cage.with_end_interval(v, w, d).unwrap();
                }
            }
            (plain, DooSabinSurface::new(cage).unwrap())
        };
        let ((a, one), (b, other)) = (make(&across[0], 0.0), make(&across[1], 3.1));
        // The last row of one, the first of the other.
        let (left, right) = (along(rows, columns, 1), along(rows, columns, 0));
        let (mine, theirs) = (halves(&a, &left), halves(&b, &right));
        let edit = mine.iter().zip(&theirs).fold(Edit::new(&one).with(other.boxed()), |edit, (x, y)| {
            let (i, j) = (side(&one, x.0, x.1, x.2), side(&other, y.0, y.1, y.2));
            edit.ask(join(Edge::Number(i), 1, Edge::Number(j), order).keep())
        });
        let edited = edit.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        let (a, b) = (moved(&a, edited.shape()), moved(&b, edited.shape_at(1).unwrap()));
        let line = |plain: &Plain, row: &[[usize; 2]], [outer, inner]: [f64; 2]| -> Vec<[Vector; 2]> {
            let each = |&[v, w]: &[usize; 2]| {
                let (p, q) = (plain.points[v], plain.points[w]);
                [(p * inner + q * outer) / (outer + inner), (q - p) * (inner / (outer + inner))]
            };
            row.iter().map(each).collect()
        };
        let p = line(&a, &left, [across[0][rows - 1], across[0][rows - 2]]);
        let q = line(&b, &right, [across[1][0], across[1][1]]);
        // Between the knots round a vertex, whose span is the vertex's own interval.
        let quadratic = |line: &[[Vector; 2]], k: usize, order: usize, t: f64| {
            let [h0, h1, h2] = [0, 1, 2].map(|j| common[k - 1 + j]);
            let c = |j: usize| line[k - 1 + j][order];
            let (start, end) = ((c(0) * h1 + c(1) * h0) / (h0 + h1), (c(1) * h2 + c(2) * h1) / (h1 + h2));
            start * ((1.0 - t) * (1.0 - t)) + c(1) * (2.0 * t * (1.0 - t)) + end * (t * t)
        };
        for k in 1..columns - 1 {
            for t in [0.0, 0.3, 0.8, 1.0] {
                let off = (quadratic(&p, k, 0, t) - quadratic(&q, k, 0, t)).norm();
                assert!(off < 1e-12, "{seed}, order {order}: {off:e} apart");
                let off = (quadratic(&p, k, 1, t) + quadratic(&q, k, 1, t)).norm();
                assert!(order == 0 || off < 1e-12, "{seed}: derivatives {off:e} apart");
            }
        }
    }
}

/// A side that begins at the middle of a pentagon has pieces without number: refused, with a way out that is one.
#[test]
fn sides_that_end_at_extraordinary_points_are_refused_with_a_way_out() {
    let cage = crate::shapes::fan(4, 5, true, 0.2);
    let surface = DooSabinSurface::new(cage.clone()).unwrap();
    let line = Space::clamped_uniform(2, 3).unwrap();
    let net = (0..9).map(|k| Point::new(f64::from(k / 3), -f64::from(k % 3), 0.2)).collect();
    let patch = Surface::new(line.clone(), line, net).unwrap();
    for order in 0..=1 {
        let edit = Edit::new(&surface).with(Box::new(patch.clone()));
        let refused = edit.ask(join(Edge::Number(0), 1, Edge::VStart, order).keep()).solve().unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.contains("ends at an extraordinary point") && refused.contains("refine"),
            "{refused}"
        );
    }
    // The half away from it, of the cage refined once.
    let fine = DooSabinSurface::new(loftsman_subdivision::doo_sabin::refine(&cage).unwrap()).unwrap();
    let count = Shape::edges(&fine).unwrap().count();
    let joined = (0..count).filter(|&k| {
        let edit = Edit::new(&fine).with(Box::new(patch.clone()));
        edit.ask(join(Edge::Number(k), 1, Edge::VStart, 1).keep()).solve().is_ok()
    });
    assert!(joined.count() >= 4);
}

/// Whatever the mesh: its refinements are their own mirror images, and the place asked for is met.
#[test]
fn random_cages_are_made_symmetric() {
    let mut seen = 0;
    for seed in 0..120 {
        let mut plain = butterfly(seed);
        (plain.creases, plain.corners) = Default::default();
        let mut dice = Dice::new(seed + 64_000);
        let size = [1.0, 1e-9, 1e9][(seed % 3) as usize];
        let (turn, aside) = (Rotation3::new(dice.vector() * 2.0), dice.vector() * 3.0);
        plain.points.iter_mut().for_each(|p| *p = (turn * *p + aside + dice.vector() * 4e-4) * size);
        let (normal, origin) = (turn * Vector::x(), Point::from(aside * size));
        // What has a vertex of two edges has no surface.
        let Ok(surface) = DooSabinSurface::new(plain.cage().unwrap()) else { continue };
        let face = dice.below(surface.faces().unwrap()) as u32;
        let (of, corner) = surface.cage_corner(face).unwrap();
        let at = [0, 1].map(|_| (1 + dice.below(3)) as f64 / 4.0);
        let to = spot(&plain, of, corner, at).place + dice.vector() * (0.2 * size);
        let aim = position(Location::Face(face, at[0], at[1])).to(Point::from(to));
        let edit = Edit::new(&surface).ask(symmetry(normal, origin).hold()).ask(aim);
        let edited = edit.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        let after = moved(&plain, edited.shape());
        let off = (spot(&after, of, corner, at).place - to).norm();
        assert!(off < 1e-12 * size, "{seed}: {off:e} from where it is to be");
        let fine = after.dual().dual();
        for p in &fine.points {
            let image = p - normal * (2.0 * normal.dot(&(p - origin.coords)));
            let near = fine.points.iter().map(|q| (q - image).norm()).fold(f64::MAX, f64::min);
            assert!(near < 1e-12 * size, "{seed}: {near:e}");
        }
        seen += 1;
    }
    assert!(seen > 80, "{seen}");
}

/// Steps along edges from some vertices.
fn steps(plain: &Plain, from: &[usize]) -> BTreeMap<usize, usize> {
    let edges = plain.edges();
    let mut all: BTreeMap<usize, usize> = from.iter().map(|&v| (v, 0)).collect();
    for step in 1.. {
        let next: Vec<usize> = edges
            .keys()
            .flat_map(|&[a, b]| [[a, b], [b, a]])
            .filter(|[a, b]| all.contains_key(a) && !all.contains_key(b))
            .map(|[_, b]| b)
            .collect();
        if next.is_empty() {
            break;
        }
        for v in next {
            all.entry(v).or_insert(step);
        }
    }
    all
}

/// The limit of a vertex depends on the vertices of the faces round it; from each the falloff takes along what is fewer than `radius` steps away, and
/// nothing else moves by a bit.
#[test]
fn a_falloff_is_as_far_as_it_says() {
    let (mut moving, mut resting) = (0, 0);
    for seed in 0..80 {
        let Some(Case { plain, surface, size, name }) = case(seed) else { continue };
        let mut dice = Dice::new(seed + 65_000);
        let face = dice.below(surface.faces().unwrap()) as u32;
        let (of, corner) = surface.cage_corner(face).unwrap();
        let vertex = plain.faces[of][corner];
        let near: Vec<usize> =
            plain.faces.iter().filter(|f| f.contains(&vertex)).flatten().copied().collect();
        let far = steps(&plain, &near);
        for radius in [1.0, 2.0, 3.0] {
            let way = dice.vector() * size;
            let edit = Edit::new(&surface).metric(Metric::Falloff(radius));
            let edited = edit.ask(position(Location::Vertex(vertex as u32)).by(way)).solve().unwrap();
            let after = moved(&plain, edited.shape());
            for (v, (p, q)) in plain.points.iter().zip(&after.points).enumerate() {
                let is_near = far.get(&v).is_some_and(|&n| (n as f64) < radius);
                assert!(is_near || p == q, "{name}, radius {radius}: vertex {v} moved by {}", q - p);
                (moving, resting) = (moving + usize::from(p != q), resting + usize::from(p == q));
            }
            let [a, b] = [&plain, &after].map(|plain| spot(plain, of, corner, [1.0, 1.0]).place);
            assert!((b - a - way).norm() < 1e-12 * size, "{name}, radius {radius}: {}", b - a - way);
        }
    }
    assert!(moving > 500 && resting > 200, "{moving} {resting}");
}
