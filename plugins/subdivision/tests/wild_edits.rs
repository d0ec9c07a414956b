//! Random cages joined, made symmetric and tuned by springs, each against an evaluator that knows nothing of the crate's.

#![allow(clippy::unwrap_used, clippy::panic, reason = "what is missing fails the test")]

use loftsman_kernel::edit::{Ask, Edit};
use loftsman_kernel::functional::{Edge, join, position, symmetry};
use loftsman_kernel::nalgebra::{DMatrix, Rotation3};
use loftsman_kernel::shape::{Location, Shape};
use loftsman_kernel::{Point, Vector};
use loftsman_subdivision::SubdivisionSurface;
use loftsman_subdivision::doo_sabin::{FineTune, elevated};

use crate::shapes::plain::{Plain, ends};
use crate::shapes::wild::{self, Dice};

fn shape(plain: &Plain) -> SubdivisionSurface {
    SubdivisionSurface::new(plain.cage().unwrap()).unwrap()
}

/// The mesh with other points.
fn moved(plain: &Plain, shape: &dyn Shape) -> Plain {
    let points = shape.control_vertices().iter().map(|p| p.coords).collect();
    Plain { points, ..plain.clone() }
}

/// A sheet with its mirror image in `x = 0`, where it has its first row, as one mesh; parts of the sheet are changed, some edges sharp.
pub(crate) fn butterfly(seed: u64) -> Plain {
    let mut dice = Dice::new(seed);
    let (rows, columns) = (3 + dice.below(3), 3 + dice.below(3));
    let mut half = wild::sheet(rows, columns, 0.3, &mut dice);
    for p in &mut half.points {
        p.x = p.x.abs() + 0.2;
    }
    for _ in 0..dice.below(5) {
        let mut changed = half.clone();
        wild::change(&mut changed, &mut dice);
        let edges = changed.edges();
        // The first row is still a boundary.
        let kept = (1..columns).all(|k| edges.get(&[k - 1, k]).is_some_and(|f| f.len() == 1));
        if kept && changed.cage().is_ok_and(|cage| cage.check_shape().is_ok()) {
            half = changed;
        }
    }
    (0..columns).for_each(|k| half.points[k].x = 0.0);
    if seed.is_multiple_of(2) {
        half = wild::sharpened(half, seed);
    }
    let count = half.points.len();
    let image = |v: usize| if v < columns { v } else { v + count - columns };
    let mirror = |p: &Vector| Vector::new(-p.x, p.y, p.z);
    let mut both = half.clone();
    both.points.extend(half.points[columns..].iter().map(mirror));
    both.faces.extend(half.faces.iter().map(|f| f.iter().rev().map(|&v| image(v)).collect()));
    both.creases.extend(half.creases.iter().map(|([a, b], s)| (ends(image(*a), image(*b)), *s)));
    both.corners.extend(half.corners.iter().map(|(v, s)| (image(*v), *s)));
    both.rounded = seed.is_multiple_of(3);
    both
}

/// The limit of an inner vertex at which nothing is sharp, of quads: `(n² P + 4 Σ E + Σ F) / (n (n + 5))`, `F` being across.
fn limit(quads: &Plain, vertex: usize) -> Vector {
    let mut sum = Vector::zeros();
    let mut n = 0.0;
    for face in quads.faces.iter().filter(|f| f.contains(&vertex)) {
        let k = face.iter().position(|&v| v == vertex).unwrap();
        // Each edge once: the one that leaves the vertex in this face.
        sum += quads.points[face[(k + 1) % 4]] * 4.0 + quads.points[face[(k + 2) % 4]];
        n += 1.0;
    }
    (quads.points[vertex] * n * n + sum) / (n * (n + 5.0))
}

/// Whether a vertex is inside and nothing is sharp there.
fn is_smooth(plain: &Plain, vertex: usize) -> bool {
    !plain.corners.contains_key(&vertex)
        && plain
            .edges()
            .iter()
            .filter(|(e, _)| e.contains(&vertex))
            .all(|(e, faces)| faces.len() == 2 && !plain.creases.contains_key(e))
}

/// Whatever the mesh: its refinements are their own mirror images, and the place asked for is met.
#[test]
fn random_cages_are_made_symmetric() {
    let mut seen = 0;
    for seed in 0..120 {
        let mut plain = butterfly(seed);
        let mut dice = Dice::new(seed + 700);
        // Anywhere in space, and not quite symmetric.
        let (turn, aside) = (Rotation3::new(dice.vector() * 2.0), dice.vector() * 3.0);
        plain.points.iter_mut().for_each(|p| *p = turn * *p + aside + dice.vector() * 4e-4);
        let (normal, origin) = (turn * Vector::x(), Point::from(aside));
        let inner: Vec<usize> = (0..plain.points.len()).filter(|&v| is_smooth(&plain, v)).collect();
        let edit = Edit::new(&shape(&plain)).ask(symmetry(normal, origin).hold());
        let aim = (!inner.is_empty()).then(|| {
            let v = inner[dice.below(inner.len())];
            let off = limit(&plain.refined(), v) + dice.vector() * 0.2 - origin.coords;
            // In the plane, so that a vertex there can be moved to it.
            (v, origin + off - normal * normal.dot(&off) * if v < 6 { 1.0 } else { 0.0 })
        });
        let edit = match aim {
            Some((v, to)) => edit.ask(position(Location::Vertex(v as u32)).to(to)),
            None => edit,
        };
        let edited = edit.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        let after = moved(&plain, edited.shape());
        let fine = after.refined().refined();
        if let Some((v, to)) = aim {
            let off = (limit(&after.refined(), v) - to.coords).norm();
            assert!(off < 1e-12, "{seed}: {off:e} from where vertex {v} is to be");
        }
        for p in &fine.points {
            let image = p - normal * (2.0 * normal.dot(&(p - origin.coords)));
            let near = fine.points.iter().map(|q| (q - image).norm()).fold(f64::MAX, f64::min);
            assert!(near < 1e-12, "{seed}: {near:e}");
        }
        seen += usize::from(aim.is_some());
    }
    assert!(seen > 80, "{seen}");
}

/// The vertices along a side of a sheet, in order, each with the one behind it.
pub(crate) fn side(rows: usize, columns: usize, which: usize) -> Vec<[usize; 2]> {
    let at = |i: usize, j: usize| i * columns + j;
    match which {
        0 => (0..columns).map(|j| [at(0, j), at(1, j)]).collect(),
        1 => (0..columns).map(|j| [at(rows - 1, j), at(rows - 2, j)]).collect(),
        2 => (0..rows).map(|i| [at(i, 0), at(i, 1)]).collect(),
        _ => (0..rows).map(|i| [at(i, columns - 1), at(i, columns - 2)]).collect(),
    }
}

/// The uniform cubic through the ends of its vertices, on span `k` at `t`.
fn cubic(vertices: &[Vector], k: usize, t: f64) -> Vector {
    let n = vertices.len();
    let at = |i: usize| match i {
        0 => vertices[0] * 2.0 - vertices[1],
        i if i == n + 1 => vertices[n - 1] * 2.0 - vertices[n - 2],
        i => vertices[i - 1],
    };
    let s = 1.0 - t;
    let weights =
        [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t];
    (0..4).map(|i| at(k + i) * (weights[i] / 6.0)).sum()
}

/// The sheet changed away from a side: its first rows of faces there are as they were, so many.
pub(crate) fn changed_inside(mut sheet: Plain, along: &[[usize; 2]], order: usize, dice: &mut Dice) -> Plain {
    let row: Vec<usize> = along.iter().map(|pair| pair[0]).collect();
    let next: Vec<usize> = along.iter().map(|pair| pair[1]).collect();
    let guarded = |v: &usize| row.contains(v) || order > 0 && next.contains(v);
    for _ in 0..dice.below(6) {
        let mut changed = sheet.clone();
        wild::change(&mut changed, dice);
        let kept = |plain: &Plain| {
            let mut all: Vec<Vec<usize>> =
                plain.faces.iter().filter(|f| f.iter().any(guarded)).cloned().collect();
            all.sort();
            all
        };
        if kept(&changed) == kept(&sheet) && changed.cage().is_ok_and(|cage| cage.check_shape().is_ok()) {
            sheet = changed;
        }
    }
    sheet
}

/// Two random sheets along random sides, to order 0 and 1: the boundary is the cubic of its own vertices, and the derivative across it, where the faces
/// beside are regular, that of the differences from them to those behind.
#[test]
fn random_cages_are_joined() {
    for seed in 0..120 {
        let mut dice = Dice::new(seed + 3_000);
        let order = dice.below(2);
        let count = 3 + dice.below(4);
        let mut parts = Vec::new();
        for _ in 0..2 {
            let which = dice.below(4);
            let other = 4 + dice.below(2);
            let (rows, columns) = if which < 2 { (other, count) } else { (count, other) };
            let along = side(rows, columns, which);
            let sheet = wild::sheet(rows, columns, 0.3, &mut dice);
            parts.push((changed_inside(sheet, &along, order, &mut dice), along));
        }
        let [(a, left), (mut b, mut right)] = <[_; 2]>::try_from(parts).unwrap();
        if dice.below(2) == 0 {
            right.reverse();
        }
        for ([v, _], [w, _]) in left.iter().zip(&right) {
            b.points[*w] = a.points[*v] + dice.vector() * 0.05;
        }
        let (one, other) = (shape(&a), shape(&b));
        let number = |shape: &SubdivisionSurface, v: usize, w: usize| {
            let edges = Shape::edges(shape).unwrap();
            edges.iter().position(|e| e.name == format!("{v}-{w}") || e.name == format!("{w}-{v}")).unwrap()
        };
        let pairs: Vec<[usize; 2]> = (1..count)
            .map(|k| [number(&one, left[k - 1][0], left[k][0]), number(&other, right[k - 1][0], right[k][0])])
            .collect();
        let edit = pairs.iter().fold(Edit::new(&one).with(other.boxed()), |edit, &[i, j]| {
            edit.ask(join(Edge::Number(i), 1, Edge::Number(j), order).keep())
        });
        let edited = edit.solve().unwrap_or_else(|e| panic!("{seed}: {e}"));
        let (a, b) = (moved(&a, edited.shape()), moved(&b, edited.shape_at(1).unwrap()));
        let rows = |plain: &Plain, along: &[[usize; 2]]| {
            let outer: Vec<Vector> = along.iter().map(|pair| plain.points[pair[0]]).collect();
            let inwards: Vec<Vector> =
                along.iter().map(|[v, w]| plain.points[*w] - plain.points[*v]).collect();
            [outer, inwards]
        };
        let ([p, d], [q, e]) = (rows(&a, &left), rows(&b, &right));
        for k in 0..count - 1 {
            for t in [0.0, 0.31, 0.77, 1.0] {
                let off = (cubic(&p, k, t) - cubic(&q, k, t)).norm();
                assert!(off < 1e-12, "{seed}, order {order}: {off:e} apart at {k}, {t}");
                if order > 0 {
                    let off = (cubic(&d, k, t) + cubic(&e, k, t)).norm();
                    assert!(off < 1e-12, "{seed}: derivatives {off:e} apart at {k}, {t}");
                }
            }
        }
    }
}

/// What the springs of an elevated mesh want, by the definition of [`FineTune`], for closed meshes: pairs of its vertices, one for each corner of each
/// face, in order.
fn springs(
    plain: &Plain,
    net: &[Vector],
    alpha: impl Fn(usize, usize) -> f64,
) -> Vec<(usize, usize, Vector)> {
    let mut first = vec![0];
    plain.faces.iter().for_each(|f| first.push(first[first.len() - 1] + f.len()));
    let corner =
        |face: usize, v: usize| first[face] + plain.faces[face].iter().position(|&w| w == v).unwrap();
    let mut all = Vec::new();
    for (f, face) in plain.faces.iter().enumerate() {
        let n = face.len();
        for k in 0..n {
            // Along an edge, in one of its faces.
            let (v, w) = (face[k], face[(k + 1) % n]);
            let (a, b) = (corner(f, v), corner(f, w));
            all.push((a, b, (net[b] - net[a]) * alpha(v, w)));
        }
    }
    for (edge, faces) in plain.edges() {
        for v in edge {
            // Across the edge at its end `v`: the edges of `v` before and after it in the two faces.
            let runs = |f: usize| {
                let face = &plain.faces[f];
                let k = face.iter().position(|&w| w == v).unwrap();
                ends(v, face[(k + 1) % face.len()]) == edge
            };
            let [one, other] = if runs(faces[0]) { [faces[0], faces[1]] } else { [faces[1], faces[0]] };
            let beside = |f: usize, step: isize| {
                let face = &plain.faces[f];
                let k = face.iter().position(|&w| w == v).unwrap() as isize;
                face[(k + step).rem_euclid(face.len() as isize) as usize]
            };
            // In `one` the edge follows `v` and the other edge comes before it; in `other` it is the other way round.
            let (far, near) = (beside(other, 1), beside(one, -1));
            let (from, to) = (corner(one, v), corner(other, v));
            let (before, after) = (alpha(near, v), alpha(v, far));
            // The elevated edges across the knot lines on either side; the middle coefficient of a linear α and a quadratic is
            // `(α₀ e₁ + α₁ e₀)/4` more than what the ends have.
            let (e0, e1) = (net[from] - net[corner(one, near)], net[corner(other, far)] - net[to]);
            let plain = (net[to] - net[from]) * (0.5 * (before + after));
            all.push((from, to, plain + (e1 - e0) * ((before - after) / 8.0)));
        }
    }
    all
}

/// The least squares of springs by dense equations.
#[test]
fn springs_of_random_cages_are_least_squares() {
    let mut seen = 0;
    for seed in 0..160 {
        let plain = wild::closed(seed);
        if plain.faces.iter().any(|f| f.len() > 4) {
            continue;
        }
        let cage = plain.cage().unwrap();
        let net: Vec<Vector> = elevated(&cage).unwrap().points().iter().map(|p| p.coords).collect();
        let alpha = |a: usize, b: usize| {
            let [a, b] = ends(a, b);
            1.0 + 0.8 * crate::shapes::noise(seed * 10_000 + (a * 100 + b) as u64)
        };
        let mut tune = FineTune::new(cage);
        plain.edges().keys().for_each(|&[a, b]| tune.scale([a, b], alpha(a, b)).unwrap());
        let tuned = tune.solve().unwrap();
        let all = springs(&plain, &net, alpha);
        let count = net.len();
        let mut matrix = DMatrix::zeros(count, count);
        let mut right = DMatrix::zeros(count, 3);
        for (a, b, wanted) in &all {
            for (i, j, s) in [(*a, *a, 1.0), (*b, *b, 1.0), (*a, *b, -1.0), (*b, *a, -1.0)] {
                matrix[(i, j)] += s;
            }
            for axis in 0..3 {
                right[(*b, axis)] += wanted[axis];
                right[(*a, axis)] -= wanted[axis];
            }
        }
        // The first stays.
        for axis in 0..3 {
            (0..count).for_each(|i| right[(i, axis)] -= matrix[(i, 0)] * net[0][axis]);
        }
        let solved = matrix.remove_row(0).remove_column(0).lu().solve(&right.remove_row(0)).unwrap();
        let found = |v: usize| if v == 0 { net[0] } else { Vector::from_fn(|axis, _| solved[(v - 1, axis)]) };
        let (mut off, mut size) = (0.0, 0.0);
        for (a, b, wanted) in &all {
            off += (found(*b) - found(*a) - wanted).norm_squared();
            size += wanted.norm_squared();
        }
        for (v, p) in tuned.cage.points().iter().enumerate() {
            let off = (p.coords - found(v)).norm();
            assert!(off < 1e-11, "{seed}, vertex {v}: {off:e}");
        }
        let strain = (off / size).sqrt();
        assert!((tuned.strain - strain).abs() < 1e-11 && strain > 1e-3, "{seed}: {} {strain}", tuned.strain);
        seen += 1;
    }
    assert!(seen > 60, "{seen}");
}
