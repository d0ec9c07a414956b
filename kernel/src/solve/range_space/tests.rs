//! Against the whole system, dense: `[W 0 -Lᵀ; 0 ε -L_sᵀ; L L_s 0]`.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::solve::EnvelopeCholesky;

/// Numbers between -1 and 1, the same every time.
struct Sequence(u64);

impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.next() + 1.0) / 2.0 * count as f64) as usize % count
    }
}

/// A positive definite band of this half width, perhaps closed.
fn band(n: usize, width: usize, closed: bool, random: &mut Sequence) -> DMatrix<f64> {
    let mut a = DMatrix::zeros(n, n);
    for i in 0..n {
        for k in 1..=width {
            let j = if i + k < n {
                i + k
            } else if closed {
                (i + k) % n
            } else {
                continue;
            };
            let value = 0.3 * random.next();
            a[(i, j)] += value;
            a[(j, i)] += value;
        }
        a[(i, i)] += 1.0 + 0.7 * width as f64;
    }
    a
}

fn envelope(a: &DMatrix<f64>) -> EnvelopeCholesky {
    let first = (0..a.nrows()).map(|i| (0..=i).find(|&j| a[(i, j)] != 0.0).unwrap() as u32).collect();
    EnvelopeCholesky::factor(first, 1e-14, |i, j| a[(i, j)]).unwrap()
}

/// A row of one to three equations: vertices, and a 3 × equations block for each.
type Given = (Vec<usize>, Vec<DMatrix<f64>>, bool);

struct Case {
    weight: DMatrix<f64>,
    rows: Vec<Given>,
    free: DMatrix<f64>,
    epsilon: f64,
}

impl Case {
    /// Whether these are the conditions of the least: for rows that depend on one another, whose multipliers are not told.
    fn holds(&self, f: &DVector<f64>, x: &[f64], s: &[f64], lambda: &[f64]) {
        let mut left = &self.weight * DVector::from_column_slice(x) - f;
        let mut at = 0;
        for (vertices, blocks, _) in &self.rows {
            for (v, block) in vertices.iter().zip(blocks) {
                for q in 0..block.nrows() {
                    (0..3).for_each(|axis| left[3 * v + axis] -= block[(q, axis)] * lambda[at + q]);
                }
            }
            at += blocks[0].nrows();
        }
        let pull = self.free.transpose() * DVector::from_column_slice(lambda);
        let size = lambda.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
        assert!(left.amax() < 1e-10 * size, "{}", left.amax());
        for (s, pull) in s.iter().zip(pull.iter()) {
            assert!((self.epsilon * s - pull).abs() < 1e-8 * size, "{s} {pull}");
        }
    }

    fn dense(&self, f: &DVector<f64>, e: &DVector<f64>) -> (DVector<f64>, DVector<f64>, DVector<f64>) {
        let (n, m, k) = (self.weight.nrows(), e.len(), self.free.ncols());
        let mut l = DMatrix::zeros(m, n);
        let mut at = 0;
        for (vertices, blocks, _) in &self.rows {
            for (v, block) in vertices.iter().zip(blocks) {
                for q in 0..block.nrows() {
                    (0..3).for_each(|axis| l[(at + q, 3 * v + axis)] += block[(q, axis)]);
                }
            }
            at += blocks[0].nrows();
        }
        let mut all = DMatrix::zeros(n + k + m, n + k + m);
        all.view_mut((0, 0), (n, n)).copy_from(&self.weight);
        all.view_mut((n, n), (k, k)).copy_from(&(DMatrix::identity(k, k) * self.epsilon));
        all.view_mut((0, n + k), (n, m)).copy_from(&-l.transpose());
        all.view_mut((n, n + k), (k, m)).copy_from(&-self.free.transpose());
        all.view_mut((n + k, 0), (m, n)).copy_from(&l);
        all.view_mut((n + k, n), (m, k)).copy_from(&self.free);
        let right = DVector::from_iterator(
            n + k + m,
            f.iter().copied().chain((0..k).map(|_| 0.0)).chain(e.iter().copied()),
        );
        let x = all.lu().solve(&right).unwrap();
        (x.rows(0, n).into(), x.rows(n, k).into(), x.rows(n + k, m).into())
    }

    fn check(&self, mut space: RangeSpace, random: &mut Sequence, same_multipliers: bool) {
        let n = self.weight.nrows();
        for (vertices, blocks, alike) in &self.rows {
            if *alike {
                space.push_alike(vertices.iter().copied().zip(blocks.iter().map(|b| b[(0, 0)])));
            } else {
                space.push_coupled(
                    vertices.iter().copied().zip(blocks.iter().map(|b| [b[(0, 0)], b[(0, 1)], b[(0, 2)]])),
                );
            }
        }
        let (m, k) = (space.equations(), self.free.ncols());
        space.float(k, self.epsilon);
        for i in 0..m {
            (0..k).for_each(|j| space.change(i, j, self.free[(i, j)]));
        }
        space.factor();
        let f = DVector::from_fn(n, |_, _| random.next());
        // What can be asked of these rows: what some change does.
        let (x, s): (Vec<f64>, Vec<f64>) =
            ((0..n).map(|_| random.next()).collect(), (0..k).map(|_| random.next()).collect());
        let mut e = vec![0.0; m];
        space.apply(&x, &s, &mut e);
        let e = DVector::from_vec(e);
        let mut found = f.as_slice().to_vec();
        let (mut multipliers, mut rates) = (vec![0.0; m], vec![0.0; k]);
        let error = space.solve(&mut found, e.as_slice(), &mut multipliers, &mut rates);
        let off = |a: &[f64], b: &DVector<f64>| {
            a.iter().zip(b.iter()).fold(0.0_f64, |o, (a, b)| o.max((a - b).abs())) / b.amax().max(1.0)
        };
        assert!(error < 1e-12, "{error}");
        if !same_multipliers {
            self.holds(&f, &found, &rates, &multipliers);
            return;
        }
        let (x, s, lambda) = self.dense(&f, &e);
        assert!(off(&found, &x) < 1e-9, "{} of {n}, {m}, {k}", off(&found, &x));
        assert!(off(&rates, &s) < 1e-8, "{rates:?} {s}");
        assert!(off(&multipliers, &lambda) < 1e-8);
    }
}

fn rows(count: usize, vertices: usize, coupled: bool, random: &mut Sequence) -> Vec<Given> {
    (0..count)
        .map(|i| {
            let first = random.below(vertices);
            let touched: Vec<usize> = (0..4.min(vertices)).map(|k| (first + k) % vertices).collect();
            let alike = !coupled || i % 2 == 0;
            let blocks = touched.iter().map(|_| {
                let c = random.next();
                if alike { DMatrix::identity(3, 3) * c } else { DMatrix::from_fn(1, 3, |_, _| random.next()) }
            });
            (touched.clone(), blocks.collect(), alike)
        })
        .collect()
}

fn free(rows: &[Given], k: usize, random: &mut Sequence) -> DMatrix<f64> {
    let m = rows.iter().map(|(_, blocks, _)| blocks[0].nrows()).sum();
    DMatrix::from_fn(m, k, |_, _| random.next())
}

fn thrice(a: &DMatrix<f64>) -> DMatrix<f64> {
    a.kronecker(&DMatrix::identity(3, 3))
}

#[test]
fn it_is_the_answer_of_the_whole_system() {
    let mut random = Sequence(1);
    for case in 0..120 {
        let n = [4, 9, 40, 90, 130][case % 5];
        let closed = case % 3 == 1 && n > 8;
        let a = band(n, 1 + case % 3, closed, &mut random);
        let rows = rows(1 + random.below(5).min(n / 4), n, case % 2 == 1, &mut random);
        let free = free(&rows, (case % 4).min(2), &mut random);
        let epsilon = [0.0, 1e-3, 2.0][case % 3];
        let whole = Case { weight: thrice(&a), rows, free, epsilon };
        // A vertex order of its own, too.
        let order: Option<Vec<usize>> = (case % 7 == 3).then(|| (0..n).rev().collect());
        let factor = match &order {
            Some(order) => envelope(&DMatrix::from_fn(n, n, |i, j| a[(order[i], order[j])])),
            None => envelope(&a),
        };
        whole.check(RangeSpace::new([(Weight::Vertices(factor), order)]), &mut random, true);
        let coordinates = Weight::Coordinates(envelope(&whole.weight));
        whole.check(RangeSpace::new([(coordinates, None)]), &mut random, true);
    }
}

#[test]
fn grids_and_several_blocks() {
    let mut random = Sequence(2);
    for case in 0..60 {
        let (rows_u, columns) = [(3, 5), (12, 4), (4, 25), (25, 4)][case % 4];
        let (u, v) = (
            band(rows_u, 2, case % 3 == 0, &mut random),
            band(columns, 1 + case % 3, case % 5 == 0, &mut random),
        );
        let b = band(7, 2, false, &mut random);
        let n = rows_u * columns;
        let mut weight = DMatrix::zeros(3 * (n + 7), 3 * (n + 7));
        weight.view_mut((0, 0), (3 * n, 3 * n)).copy_from(&thrice(&u.kronecker(&v)));
        weight.view_mut((3 * n, 3 * n), (21, 21)).copy_from(&thrice(&b));
        let mut given = rows(3, n + 7, case % 2 == 0, &mut random);
        // One that is on both.
        given.push((
            vec![1, columns, n + 2],
            vec![DMatrix::identity(3, 3), DMatrix::identity(3, 3) * 0.4, DMatrix::identity(3, 3) * -1.0],
            true,
        ));
        let free = free(&given, case % 3, &mut random);
        let whole = Case { weight, rows: given, free, epsilon: 0.1 * (case % 2) as f64 };
        let blocks =
            [(Weight::Grid(envelope(&u), envelope(&v)), None), (Weight::Vertices(envelope(&b)), None)];
        whole.check(RangeSpace::new(blocks), &mut random, true);
    }
}

#[test]
fn rows_that_repeat_or_vanish_take_no_part() {
    let mut random = Sequence(3);
    for case in 0..60 {
        let n = 20;
        let a = band(n, 2, false, &mut random);
        let mut given = rows(3, n, case % 2 == 1, &mut random);
        given.push(given[0].clone());
        if case % 3 == 0 {
            // A knot drawn tight: vertices say nothing, the parameter does.
            given.push((vec![3], vec![DMatrix::zeros(3, 3)], true));
        }
        let k = 1 + case % 2;
        let mut changes = free(&given, k, &mut random);
        if case % 3 != 0 {
            // Those that repeat change alike.
            let m = changes.nrows();
            let first = changes.rows(0, 3).into_owned();
            changes.rows_mut(m - 3, 3).copy_from(&first);
        }
        let whole = Case { weight: thrice(&a), rows: given, free: changes, epsilon: [0.0, 0.5][case % 2] };
        whole.check(RangeSpace::new([(Weight::Vertices(envelope(&a)), None)]), &mut random, false);
    }
}

/// A damped parameter is one with a weight of `factor · L_sᵀG⁻¹L_s`; and where rows depend on one another, all of them hold still.
#[test]
fn what_is_damped_goes_a_part_of_its_way() {
    let mut random = Sequence(5);
    for case in 0..60 {
        let (n, k) = (24, 1 + case % 3);
        let a = band(n, 1 + case % 3, case % 4 == 0, &mut random);
        let mut given = rows(4, n, case % 2 == 0, &mut random);
        let dependent = case % 5 == 4;
        if dependent {
            given.push((vec![3], vec![DMatrix::zeros(3, 3)], true));
        }
        let changes = free(&given, k, &mut random);
        let mut space = RangeSpace::new([(Weight::Vertices(envelope(&a)), None)]);
        for (vertices, blocks, alike) in &given {
            if *alike {
                space.push_alike(vertices.iter().copied().zip(blocks.iter().map(|b| b[(0, 0)])));
            } else {
                space.push_coupled(
                    vertices.iter().copied().zip(blocks.iter().map(|b| [b[(0, 0)], b[(0, 1)], b[(0, 2)]])),
                );
            }
        }
        let m = space.equations();
        space.float(k, 0.0);
        let factors: Vec<f64> =
            (0..k).map(|j| if (case + j) % 3 == 0 { 0.0 } else { 3.0 * random.next().abs() }).collect();
        (0..k).for_each(|j| space.damp(j, factors[j]));
        (0..m).for_each(|i| (0..k).for_each(|j| space.change(i, j, changes[(i, j)])));
        space.factor();
        let f = DVector::from_fn(3 * n, |_, _| random.next());
        let e = DVector::from_fn(m, |i, _| if dependent && i >= m - 3 { 0.0 } else { random.next() });
        let mut found = f.as_slice().to_vec();
        let (mut lambda, mut s) = (vec![0.0; m], vec![0.0; k]);
        let missed = space.solve(&mut found, e.as_slice(), &mut lambda, &mut s);
        if dependent {
            continue;
        }
        assert!(missed < 1e-10, "{missed}");
        let mut l = DMatrix::<f64>::zeros(m, 3 * n);
        let mut at = 0;
        for (vertices, blocks, _) in &given {
            for (v, block) in vertices.iter().zip(blocks) {
                for q in 0..block.nrows() {
                    (0..3).for_each(|axis| l[(at + q, 3 * v + axis)] += block[(q, axis)]);
                }
            }
            at += blocks[0].nrows();
        }
        let g: DMatrix<f64> = &l * thrice(&a).try_inverse().unwrap() * l.transpose();
        let own = changes.transpose() * g.try_inverse().unwrap() * &changes;
        let pull = changes.transpose() * DVector::from_column_slice(&lambda);
        let size = lambda.iter().fold(1.0_f64, |size, v| size.max(v.abs()));
        for j in 0..k {
            let wanted = factors[j] * own[(j, j)] * s[j];
            assert!((wanted - pull[j]).abs() < 1e-8 * size, "case {case}: {wanted} {}", pull[j]);
        }
    }
}

#[test]
fn what_stays_takes_no_part() {
    let mut random = Sequence(4);
    let a = band(9, 2, false, &mut random);
    let mut space = RangeSpace::new([(Weight::Still(5), None), (Weight::Vertices(envelope(&a)), None)]);
    space.push_alike([(1, 0.5), (5 + 2, 1.0)].into_iter());
    space.float(0, 0.0);
    assert_eq!(space.factor(), 3);
    let (mut x, mut lambda) = (vec![0.0; 42], [0.0; 3]);
    assert!(space.solve(&mut x, &[1.0, 2.0, 3.0], &mut lambda, &mut []) < 1e-13);
    assert!(x[..15].iter().all(|v| *v == 0.0) && (x[15 + 6] - 1.0).abs() < 1e-13);
}

/// What is told of entries is what is applied.
#[test]
fn entries_are_those_of_the_rows() {
    let mut random = Sequence(5);
    let weights =
        [(Weight::Vertices(envelope(&band(4, 1, false, &mut random))), None), (Weight::Still(2), None)];
    let mut space = RangeSpace::new(weights);
    space.push_alike([(0, 0.5), (3, 2.0), (0, 0.25)].into_iter());
    space.push_coupled([(1, [1.0, -2.0, 3.0]), (5, [0.5, 0.0, 4.0])].into_iter());
    let x: Vec<f64> = (0..18).map(|_| random.next()).collect();
    let (mut applied, mut summed) = (vec![0.0; 4], vec![0.0; 4]);
    space.float(0, 0.0);
    space.apply(&x, &[], &mut applied);
    space.entries(|equation, coordinate, value| summed[equation] += value * x[coordinate]);
    for (a, b) in applied.iter().zip(&summed) {
        assert!((a - b).abs() < 1e-15 * (1.0 + a.abs()), "{a} {b}");
    }
}
