//! The cages that the tests are run on.
#![allow(clippy::unwrap_used, reason = "what cannot be made fails the test")]

pub(crate) mod duals;
pub(crate) mod levels;
pub(crate) mod plain;
pub(crate) mod wild;

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_subdivision::{BoundaryRule, Cage};

/// A number in `[-1, 1]` that looks random and is always the same.
pub(crate) fn noise(seed: u64) -> f64 {
    let mut x = seed.wrapping_add(0x9E37_79B9_7F4A_7C15).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 29;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^= x >> 32;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn stirred(points: &mut [Point], by: f64) {
    for (k, p) in points.iter_mut().enumerate() {
        for axis in 0..3 {
            p[axis] += by * noise((3 * k + axis) as u64);
        }
    }
}

pub(crate) fn cube() -> Cage {
    let at = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Cage::new((0..8).map(at).collect(), &faces).unwrap()
}

pub(crate) fn tetrahedron() -> Cage {
    let points = vec![
        Point::new(0., 0., 0.),
        Point::new(2., 0., 0.),
        Point::new(0., 2., 0.),
        Point::new(0.3, 0.2, 2.),
    ];
    Cage::new(points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
}

/// A grid of `rows × columns` vertices, row after row, either direction perhaps closed.
pub(crate) fn grid(rows: usize, columns: usize, wrap: [bool; 2], by: f64) -> Cage {
    let mut points: Vec<Point> =
        (0..rows * columns).map(|k| Point::new((k / columns) as f64, (k % columns) as f64, 0.0)).collect();
    stirred(&mut points, by);
    let (r, c) = (if wrap[0] { rows } else { rows - 1 }, if wrap[1] { columns } else { columns - 1 });
    let at = |i: usize, j: usize| i % rows * columns + j % columns;
    let mut faces = Vec::new();
    for i in 0..r {
        for j in 0..c {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Cage::new(points, &faces).unwrap()
}

/// `n` faces round a vertex, each of `size` corners; closed, or with a gap.
pub(crate) fn fan(n: usize, size: usize, closed: bool, by: f64) -> Cage {
    let spokes = if closed { n } else { n + 1 };
    let sweep = if closed { std::f64::consts::TAU } else { 4.0 };
    let between = size - 3;
    let mut points = vec![Point::origin()];
    let on = |t: f64, r: f64| Point::new(r * (sweep * t).cos(), r * (sweep * t).sin(), 0.3 * r * r);
    for k in 0..spokes {
        points.push(on(k as f64 / n as f64, 1.0));
    }
    for k in 0..n {
        for j in 0..between {
            points.push(on((k as f64 + (j as f64 + 1.0) / (between as f64 + 1.0)) / n as f64, 1.4));
        }
    }
    stirred(&mut points, by);
    let faces: Vec<Vec<usize>> = (0..n)
        .map(|k| {
            let mut face = vec![0, 1 + k];
            face.extend((0..between).map(|j| 1 + spokes + k * between + j));
            face.push(1 + (k + 1) % spokes);
            face
        })
        .collect();
    Cage::new(points, &faces).unwrap()
}

/// Two fans back to back: closed, with two vertices of valence `n`, the others of valence 4 or 3.
pub(crate) fn double_fan(n: usize, by: f64) -> Cage {
    let mut points = vec![Point::new(0., 0., 1.), Point::new(0., 0., -1.)];
    for k in 0..n {
        let t = std::f64::consts::TAU * k as f64 / n as f64;
        points.push(Point::new(2.0 * t.cos(), 2.0 * t.sin(), 0.0));
    }
    stirred(&mut points, by);
    let mut faces = Vec::new();
    for k in 0..n {
        let (a, b) = (2 + k, 2 + (k + 1) % n);
        faces.push([0, a, b]);
        faces.push([1, b, a]);
    }
    Cage::new(points, &faces).unwrap()
}

/// Two polygons on the same vertices: every vertex has valence 2.
pub(crate) fn pillow(n: usize) -> Cage {
    let at = |k: usize| {
        let t = std::f64::consts::TAU * k as f64 / n as f64;
        Point::new(t.cos(), t.sin(), 0.2 * noise(k as u64))
    };
    let front: Vec<usize> = (0..n).collect();
    let back: Vec<usize> = (0..n).rev().collect();
    Cage::new((0..n).map(at).collect(), &[front, back]).unwrap()
}

/// One face.
pub(crate) fn one_face(n: usize) -> Cage {
    let at = |k: usize| {
        let t = std::f64::consts::TAU * k as f64 / n as f64;
        Point::new(t.cos(), t.sin(), 0.3 * noise(k as u64))
    };
    Cage::new((0..n).map(at).collect(), &[(0..n).collect::<Vec<_>>()]).unwrap()
}

/// Every kind, with names.
pub(crate) fn all() -> Vec<(String, Cage)> {
    let mut all = vec![("cube".to_owned(), cube()), ("tetrahedron".to_owned(), tetrahedron())];
    for n in 3..8 {
        all.push((format!("one face of {n}"), one_face(n)));
        all.push((format!("one face of {n}, no corners"), one_face(n).with_boundary(BoundaryRule::EdgeOnly)));
        all.push((format!("pillow of {n}"), pillow(n)));
    }
    for n in 3..=12 {
        all.push((format!("double fan of {n}"), double_fan(n, 0.1)));
        for size in [3, 4, 5] {
            all.push((format!("fan of {n} faces of {size}"), fan(n, size, true, 0.1)));
        }
    }
    for n in 1..=6 {
        for size in [3, 4, 6] {
            let open = fan(n, size, false, 0.1);
            all.push((format!("open fan of {n} of {size}"), open.clone()));
            all.push((
                format!("open fan of {n} of {size}, no corners"),
                open.with_boundary(BoundaryRule::EdgeOnly),
            ));
        }
    }
    for wrap in [[false, false], [true, false], [true, true]] {
        all.push((format!("grid {wrap:?}"), grid(5, 6, wrap, 0.3)));
    }
    // Creases of all sharpnesses from the middle of fans: dart, crease, corner.
    for n in [3, 4, 5, 7] {
        for sharpness in [0.25, 0.5, 1.0, 1.7, 2.5, 4.0, 9.9, 10.0, f64::INFINITY] {
            let mut cage = fan(n, 4, true, 0.1);
            for count in 1..=3 {
                // Each sharper than the one before.
                let s = sharpness * (0.5 + 0.25 * count as f64);
                cage = cage.with_crease(0, [1, 3, 2][count - 1], s).unwrap();
                all.push((format!("fan of {n}, {count} creases of {sharpness}"), cage.clone()));
            }
            all.push((
                format!("sharp vertex {sharpness} of {n}"),
                fan(n, 4, true, 0.1).with_corner(0, sharpness).unwrap(),
            ));
            all.push((
                format!("cube with a creased top of {sharpness}, {n}"),
                [(4, 5), (5, 7), (7, 6), (6, 4)]
                    .iter()
                    .try_fold(cube(), |cage, &(a, b)| cage.with_crease(a, b, sharpness))
                    .unwrap(),
            ));
        }
    }
    // Points of many edges; creases and sharp vertices of open cages, from the boundary and along it; holes.
    for n in [20, 33] {
        all.push((format!("fan of {n} faces of 4"), fan(n, 4, true, 0.1)));
        all.push((format!("open fan of {n} of 4"), fan(n, 4, false, 0.1)));
    }
    for sharpness in [0.4, 2.5, f64::INFINITY] {
        let net = grid(5, 6, [false, false], 0.3);
        let creased = [(8, 14), (14, 15), (2, 8)]
            .iter()
            .try_fold(net.clone(), |cage, &(a, b)| cage.with_crease(a, b, sharpness))
            .unwrap();
        all.push((format!("grid with a crease of {sharpness} from its boundary"), creased));
        let sharp = net.with_corner(2, sharpness).and_then(|cage| cage.with_corner(15, sharpness)).unwrap();
        all.push((format!("grid with sharp vertices of {sharpness}"), sharp.clone()));
        all.push((
            format!("grid with sharp vertices of {sharpness}, no corners"),
            sharp.with_boundary(BoundaryRule::EdgeOnly),
        ));
    }
    all.push(("cube with a hole".to_owned(), cube().with_hole(2).unwrap()));
    all.push(("grid with a hole".to_owned(), grid(5, 6, [false, false], 0.3).with_hole(7).unwrap()));
    all
}

/// A torus with an interval for each row and column, and its spline.
pub(crate) fn torus(rows: &[f64], columns: &[f64]) -> (Cage, Surface) {
    let (r, c) = (rows.len(), columns.len());
    let mut cage = grid(r, c, [true, true], 0.4);
    let at = |i: usize, j: usize| i % r * c + j % c;
    for i in 0..r {
        for j in 0..c {
            cage = cage.with_interval(at(i, j), at(i + 1, j), rows[i]).unwrap();
            cage = cage.with_interval(at(i, j), at(i, j + 1), columns[j]).unwrap();
        }
    }
    let space = |d: &[f64]| {
        let n = d.len();
        // The support of vertex i starts two intervals before its place.
        let mut knots = vec![0.0];
        (0..n).for_each(|j| knots.push(knots[j] + d[(j + n - 2) % n]));
        Space::periodic(3, knots).unwrap()
    };
    let spline = Surface::new(space(rows), space(columns), cage.points().to_vec()).unwrap();
    (cage, spline)
}

/// A torus by end intervals, one for each row and column, and its biquadratic spline.
pub(crate) fn quadratic_torus(rows: &[f64], columns: &[f64]) -> (Cage, Surface) {
    let (r, c) = (rows.len(), columns.len());
    let mut cage = grid(r, c, [true, true], 0.4);
    let at = |i: usize, j: usize| i % r * c + j % c;
    for i in 0..r {
        for j in 0..c {
            for (next, interval) in [
                (at(i + 1, j), rows[i]),
                (at(i + r - 1, j), rows[i]),
                (at(i, j + 1), columns[j]),
                (at(i, j + c - 1), columns[j]),
            ] {
                cage = cage.with_end_interval(at(i, j), next, interval).unwrap();
            }
        }
    }
    let space = |d: &[f64]| {
        let n = d.len();
        // Span j is the interval of the vertex whose support starts one knot before.
        let mut knots = vec![0.0];
        (0..n).for_each(|j| knots.push(knots[j] + d[(j + n - 1) % n]));
        Space::periodic(2, knots).unwrap()
    };
    let spline = Surface::new(space(rows), space(columns), cage.points().to_vec()).unwrap();
    (cage, spline)
}

/// The end intervals of a cage that are all along a row of faces the same: in each face, away from an edge, those of its ends. `interval` says that
/// of a row by its number.
pub(crate) fn rowed(cage: &Cage, interval: impl Fn(u64) -> f64) -> Cage {
    let topology = cage.topology();
    let ends = 2 * topology.edge_count();
    let end = |from: u32, to: u32| {
        let edge = topology.edge_between(from as usize, to as usize).unwrap();
        2 * edge + usize::from(topology.edge(edge).unwrap()[0] != from)
    };
    let mut row: Vec<usize> = (0..ends).collect();
    fn root(row: &[usize], mut k: usize) -> usize {
        while row[k] != k {
            k = row[k];
        }
        k
    }
    for face in 0..topology.face_count() {
        let v = topology.face(face);
        let n = v.len();
        for k in 0..n {
            let (a, b) = (end(v[k], v[(k + n - 1) % n]), end(v[(k + 1) % n], v[(k + 2) % n]));
            let (a, b) = (root(&row, a), root(&row, b));
            row[a.max(b)] = a.min(b);
        }
    }
    (0..topology.edge_count()).fold(cage.clone(), |cage, e| {
        let [a, b] = topology.edge(e).unwrap().map(|v| v as usize);
        let d = |k: usize| interval(root(&row, 2 * e + k) as u64);
        cage.with_end_interval(a, b, d(0)).unwrap().with_end_interval(b, a, d(1)).unwrap()
    })
}
