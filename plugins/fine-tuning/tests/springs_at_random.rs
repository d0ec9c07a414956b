//! Springs between the vertices of random meshes and polygons, against the dense least squares.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests may fail the test")]

use std::collections::BTreeMap;

use loftsman_fine_tuning::Springs;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::{Point, Vector};
use nalgebra::{DMatrix, DVector};

/// Numbers that look random and are the same in every run (splitmix64).
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    /// In `[-1, 1]`.
    fn number(&mut self) -> f64 {
        self.below(2_000_001) as f64 / 1e6 - 1.0
    }
}

/// Two polygons of `n` corners and the quads between, of which some are cut into triangles, some made to fans, some joined to larger faces and some removed.
fn piece(dice: &mut Dice) -> Vec<Vec<usize>> {
    let n = 3 + dice.below(5);
    let mut faces: Vec<Vec<usize>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    faces.extend((0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]));
    let mut next = 2 * n;
    for _ in 0..dice.below(8) {
        let at = dice.below(faces.len());
        let face = faces[at].clone();
        match dice.below(4) {
            0 => {
                faces.remove(at);
                faces.extend((0..face.len()).map(|k| vec![next, face[k], face[(k + 1) % face.len()]]));
                next += 1;
            }
            1 if face.len() > 3 => {
                faces[at] = face[..3].to_vec();
                faces.push([&face[2..], &face[..1]].concat());
            }
            2 if faces.len() > 2 => drop(faces.remove(at)),
            // With the face that runs the first of its edges the other way, where these two have that one edge alone in common.
            _ => {
                let (a, b) = (face[0], face[1]);
                let beyond = |f: &Vec<usize>| (0..f.len()).any(|k| f[k] == b && f[(k + 1) % f.len()] == a);
                let Some(other) = faces.iter().position(beyond) else { continue };
                if faces[other].iter().filter(|v| face.contains(v)).count() != 2 {
                    continue;
                }
                let from = faces[other].iter().position(|&v| v == a).unwrap();
                let rest = (1..faces[other].len() - 1).map(|k| faces[other][(from + k) % faces[other].len()]);
                let joined: Vec<usize> =
                    [a].into_iter().chain(rest).chain(face[1..].iter().copied()).collect();
                faces[at] = joined;
                faces.remove(other);
            }
        }
    }
    faces
}

/// Some of these side by side, with points that nothing belongs to and lines; now and then a third face at an edge.
fn mesh(dice: &mut Dice, size: f64) -> Mesh {
    let (mut faces, mut count): (Vec<Vec<usize>>, usize) = (Vec::new(), 0);
    for _ in 0..=dice.below(3) {
        let own = piece(dice);
        let most = own.iter().flatten().max().unwrap() + 1;
        faces.extend(own.into_iter().map(|f| f.into_iter().map(|v| v + count).collect::<Vec<_>>()));
        count += most;
    }
    if dice.below(3) == 0 {
        faces.push(vec![faces[0][0], faces[0][1], count]);
        count += 1;
    }
    let lone = dice.below(3);
    count += lone;
    let mut point = || Point::from(Vector::from_fn(|_, _| dice.number()) * size);
    let points: Vec<Point> = (0..count).map(|_| point()).collect();
    let mut mesh = Mesh::new(points, &faces).unwrap();
    if dice.below(2) == 0 {
        // A line between what may be two pieces, and one of three points.
        let ends: Vec<u32> = (0..5).map(|_| dice.below(count) as u32).collect();
        if (0..4).all(|k| ends[k] != ends[k + 1]) {
            mesh.set_lines(ends, vec![0, 2, 5]).unwrap();
        }
    }
    mesh
}

type Edges = BTreeMap<[usize; 2], f64>;

fn edges(mesh: &Mesh, dice: &mut Dice, any_sign: bool) -> Edges {
    let faces = mesh.faces().flat_map(|f| (0..f.len()).map(move |k| [f[k], f[(k + 1) % f.len()]]));
    let lines = mesh.lines().flat_map(|l| l.windows(2).map(|w| [w[0], w[1]]));
    let mut alpha = || match any_sign {
        true => [0.0, 2.0 * dice.number(), dice.number()][dice.below(3)],
        false => 3.0_f64.powf(dice.number()),
    };
    let all: std::collections::BTreeSet<[usize; 2]> =
        faces.chain(lines).map(|[a, b]| [a.min(b) as usize, a.max(b) as usize]).collect();
    all.into_iter().map(|edge| (edge, alpha())).collect()
}

/// The vertices that hang together with one.
fn hanging(edges: &Edges, first: usize) -> Vec<usize> {
    let (mut all, mut done) = (vec![first], 0);
    while done < all.len() {
        let v = all[done];
        for [a, b] in edges.keys().filter(|e| e.contains(&v)) {
            let other = a + b - v;
            if !all.contains(&other) {
                all.push(other);
            }
        }
        done += 1;
    }
    all
}

/// The least of `Σ |X_b - X_a - α (P_b - P_a)|²`, as an overdetermined system of a row for each edge, by its normal equations; each piece without a pin keeps its first.
/// With the condition of the Laplacian.
fn least(points: &[Point], edges: &Edges, pins: &[usize]) -> (Vec<Vector>, f64, f64) {
    let mut fixed: Vec<usize> = pins.to_vec();
    for v in 0..points.len() {
        let own = hanging(edges, v);
        if own.iter().all(|w| *w >= v) && !own.iter().any(|w| pins.contains(w)) {
            fixed.push(v);
        }
    }
    let free: Vec<usize> = (0..points.len()).filter(|v| !fixed.contains(v)).collect();
    let place = |v: &usize| free.iter().position(|w| w == v);
    let mut matrix = DMatrix::zeros(edges.len(), free.len());
    let mut right = DMatrix::zeros(edges.len(), 3);
    for (row, ([a, b], alpha)) in edges.iter().enumerate() {
        let mut wanted = (points[*b] - points[*a]) * *alpha;
        for (v, sign) in [(b, 1.0), (a, -1.0)] {
            match place(v) {
                Some(column) => matrix[(row, column)] = sign,
                None => wanted -= points[*v].coords * sign,
            }
        }
        (0..3).for_each(|axis| right[(row, axis)] = wanted[axis]);
    }
    let mut all: Vec<Vector> = points.iter().map(|p| p.coords).collect();
    let mut condition = 1.0;
    if !free.is_empty() && !edges.is_empty() {
        // By elimination: singular values that are near to each other lose digits that the Laplacian has.
        let laplacian = matrix.transpose() * &matrix;
        let values = laplacian.symmetric_eigenvalues();
        condition = values.max() / values.min();
        let (decomposed, right) = (laplacian.lu(), matrix.transpose() * right);
        for axis in 0..3 {
            let column: DVector<f64> = right.column(axis).into_owned();
            let solved = decomposed.solve(&column).unwrap();
            free.iter().enumerate().for_each(|(k, &v)| all[v][axis] = solved[k]);
        }
    }
    let (mut off, mut size) = (0.0, 0.0);
    for ([a, b], alpha) in edges {
        let wanted = (points[*b] - points[*a]) * *alpha;
        off += (all[*b] - all[*a] - wanted).norm_squared();
        size += wanted.norm_squared();
    }
    (all, if size > 0.0 { (off / size).sqrt() } else { 0.0 }, condition)
}

/// Whatever the mesh: triangles to polygons of ten corners and more, with faces missing, in pieces, with lines and lone points; with pins anywhere and factors of
/// any sign.
#[test]
fn springs_of_random_meshes_are_least_squares() {
    let (mut polygons, mut open, mut strained, mut worst) = (0, 0, 0, 0.0_f64);
    for seed in 0..300 {
        let mut dice = Dice(seed);
        let size = [1.0, 1e-9, 1e9][(seed % 3) as usize];
        let mesh = mesh(&mut dice, size);
        let any_sign = dice.below(4) == 0;
        let edges = edges(&mesh, &mut dice, any_sign);
        let pins: Vec<usize> = (0..dice.below(4)).map(|_| dice.below(mesh.points().len())).collect();
        let mut springs = Springs::of_mesh(&mesh);
        for (&[a, b], &alpha) in &edges {
            springs.scale(if dice.below(2) == 0 { [a, b] } else { [b, a] }, alpha).unwrap();
        }
        pins.iter().for_each(|&v| springs.pin(v).unwrap());
        if any_sign {
            springs.any_sign();
        }
        let tuned = springs.solve(mesh.points()).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let (wanted, strain, condition) = least(mesh.points(), &edges, &pins);
        // A Laplacian is solved: its solution is as far off as its condition makes of rounding.
        let reach = wanted.iter().fold(size, |m, p| m.max(p.amax()));
        let allowed = 16.0 * f64::EPSILON * condition * reach;
        for (v, (p, q)) in tuned.points.iter().zip(&wanted).enumerate() {
            let off = (p.coords - q).norm();
            worst = worst.max(off / allowed);
            assert!(off <= allowed, "{seed}, vertex {v}: {off:e} of {reach:e}, condition {condition:e}");
        }
        assert!((tuned.strain - strain).abs() < 1e-11, "{seed}: {} {strain}", tuned.strain);
        for &v in &pins {
            assert_eq!(tuned.points[v], mesh.points()[v], "{seed}: pin {v}");
        }
        polygons += usize::from(mesh.faces().any(|f| f.len() > 4));
        let mut runs: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for f in mesh.faces() {
            for k in 0..f.len() {
                let (a, b) = (f[k], f[(k + 1) % f.len()]);
                *runs.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        open += usize::from(runs.values().any(|n| *n == 1));
        strained += usize::from(strain > 0.05);
    }
    println!("{worst} of what is allowed");
    assert!(polygons > 100 && open > 100 && strained > 200, "{polygons} {open} {strained}");
}

/// Polygons, jagged and with points that repeat, closed and open.
#[test]
fn springs_of_random_polygons_are_least_squares() {
    let (mut strained, mut worst) = (0, 0.0_f64);
    for seed in 0..200 {
        let mut dice = Dice(seed + 5_000);
        let (n, closed) = (1 + dice.below(30), dice.below(2) == 0);
        let size = [1.0, 1e-9, 1e9][(seed % 3) as usize];
        let mut points: Vec<Point> =
            (0..n).map(|_| Point::from(Vector::from_fn(|_, _| dice.number()) * size)).collect();
        for k in 1..n {
            if dice.below(6) == 0 {
                points[k] = points[k - 1];
            }
        }
        let last = if closed && n > 2 { n } else { n - 1 };
        let mut edges = Edges::new();
        let mut springs = Springs::of_polygon(n, closed);
        for i in 0..last {
            let (a, b, alpha) = (i, (i + 1) % n, 4.0_f64.powf(dice.number()));
            springs.scale([a, b], alpha).unwrap();
            edges.insert([a.min(b), a.max(b)], alpha);
        }
        let pins: Vec<usize> = (0..dice.below(3)).map(|_| dice.below(n)).collect();
        pins.iter().for_each(|&v| springs.pin(v).unwrap());
        let tuned = springs.solve(&points).unwrap();
        let (wanted, strain, condition) = least(&points, &edges, &pins);
        let reach = wanted.iter().fold(size, |m, p| m.max(p.amax()));
        let allowed = 16.0 * f64::EPSILON * condition * reach;
        for (v, (p, q)) in tuned.points.iter().zip(&wanted).enumerate() {
            let off = (p.coords - q).norm();
            worst = worst.max(off / allowed);
            assert!(off <= allowed, "{seed}, vertex {v}: {off:e} of {reach:e}, condition {condition:e}");
        }
        assert!((tuned.strain - strain).abs() < 1e-11, "{seed}: {} {strain}", tuned.strain);
        strained += usize::from(strain > 0.05);
    }
    println!("{worst} of what is allowed");
    assert!(strained > 60, "{strained}");
}
