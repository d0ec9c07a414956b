//! Every solver on random families of systems: clustered, repeated, dependent, scaled and empty rows by the hundred, with
//! right-hand sides that agree and that contradict each other. What comes out is multiplied out here, in twice the precision.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::sync::Arc;

use loftsman_kernel::Point;
use loftsman_kernel::shape::Shape;
use loftsman_kernel::solve::{
    Adjoint, Automatic, DenseLu, Diagnosis, HouseholderQr, Map, SaddlePoint, SolveError, Solver, Sparse,
    SparseRows, Symmetric, System, SystemMetric, Through,
};
use loftsman_kernel::spline::{Curve, Space};

/// A linear congruential generator: the same families on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }

    /// A number of either sign whose magnitude is anything between the two powers of ten.
    fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        let sign = if self.next() < 0.5 { -1.0 } else { 1.0 };
        sign * 10_f64.powf(self.between(low, high))
    }
}

/// `Σ a b` in twice the precision (Ogita, Rump and Oishi 2005).
fn dot(terms: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut rest) = (0.0_f64, 0.0);
    for (a, b) in terms {
        let product = a * b;
        let lost = a.mul_add(b, -product);
        let next = sum + product;
        let kept = next - sum;
        rest += (sum - (next - kept)) + (product - kept) + lost;
        sum = next;
    }
    sum + rest
}

type Row = Vec<(usize, f64)>;

fn curve(random: &mut Random) -> Curve {
    let degree = [1, 2, 3, 3, 4, 5, 6, 7, 25][random.below(9)];
    let spans = 2 + random.below(12);
    let mut breaks = vec![random.between(-3.0, 3.0)];
    for _ in 0..spans {
        breaks.push(breaks[breaks.len() - 1] + random.magnitude(-1.0, 0.5).abs());
    }
    let space = match random.below(4) {
        0 => Space::clamped(degree, &breaks).unwrap(),
        1 => {
            // Inner knots of multiplicity up to degree + 1.
            let mut knots = vec![breaks[0]; degree + 1];
            for &u in &breaks[1..spans] {
                knots.extend(vec![u; 1 + random.below(degree + 1)]);
            }
            knots.extend(vec![breaks[spans]; degree + 1]);
            Space::open(degree, knots).unwrap()
        }
        2 => Space::floating_uniform(degree, degree + 1 + spans).unwrap(),
        _ => {
            while breaks.len() < degree + 2 {
                breaks.push(breaks[breaks.len() - 1] + random.between(0.3, 1.0));
            }
            Space::periodic(degree, breaks).unwrap()
        }
    };
    let n = space.len();
    let points = (0..n).map(|i| Point::new(i as f64, random.next(), random.next())).collect();
    if random.below(4) == 0 {
        let weights = (0..n).map(|_| random.magnitude(-1.0, 1.0).abs()).collect();
        Curve::rational(space, points, weights).unwrap()
    } else {
        Curve::new(space, points).unwrap()
    }
}

/// The stencil of a position or derivative somewhere, or near a parameter.
fn stencil(curve: &Curve, u: f64, order: usize) -> Row {
    let (low, high) = curve.domain();
    let u = if curve.is_periodic() { u } else { u.max(low).min(high) };
    curve.stencil(u.into(), order.into()).unwrap().iter().collect()
}

struct Family {
    name: &'static str,
    width: usize,
    rows: Vec<Row>,
    /// A row that the others imply, exactly but for rounding.
    implied: usize,
}

fn combination(rows: &[Row], picks: &[(usize, f64)]) -> Row {
    let mut columns: Vec<usize> = picks.iter().flat_map(|&(r, _)| rows[r].iter().map(|t| t.0)).collect();
    columns.sort_unstable();
    columns.dedup();
    let entry = |c: usize, r: usize| rows[r].iter().filter(|t| t.0 == c).map(|t| t.1).sum::<f64>();
    columns.into_iter().map(|c| (c, dot(picks.iter().map(|&(r, f)| (f, entry(c, r)))))).collect()
}

fn family(kind: usize, random: &mut Random) -> Family {
    let curve = curve(random);
    let (n, p) = (curve.points().len(), curve.degree());
    let (low, high) = curve.domain();
    let mut rows: Vec<Row> = Vec::new();
    let name;
    match kind {
        0 => {
            name = "clusters";
            for _ in 0..1 + random.below(4) {
                let (u, apart) =
                    (random.between(low, high), (high - low) * random.magnitude(-14.0, -1.0).abs());
                (0..2 + random.below(p + 1))
                    .for_each(|k| rows.push(stencil(&curve, u + k as f64 * apart, 0)));
            }
        }
        1 => {
            name = "all kept";
            (0..n).for_each(|i| rows.push(vec![(i, 1.0)]));
            (0..1 + random.below(4)).for_each(|_| rows.push(stencil(&curve, random.between(low, high), 0)));
        }
        2 => {
            name = "hundreds";
            let (from, to) = (random.between(low, high), random.between(low, high));
            let count = 100 + random.below(300);
            for k in 0..count {
                let u = from + (to - from) * k as f64 / count as f64;
                rows.push(stencil(&curve, u, if p > 1 && k % 7 == 0 { 1 } else { 0 }));
            }
        }
        3 => {
            name = "combinations";
            (0..3 + random.below(10)).for_each(|_| {
                rows.push(stencil(&curve, random.between(low, high), random.below(p.min(3) + 1)));
            });
            for _ in 0..1 + random.below(8) {
                let picks: Vec<(usize, f64)> = (0..1 + random.below(4))
                    .map(|_| (random.below(rows.len()), random.magnitude(-3.0, 3.0)))
                    .collect();
                rows.push(combination(&rows, &picks));
            }
        }
        4 => {
            name = "an end";
            let start = if curve.is_periodic() { random.between(low, high) } else { low };
            let near = start + (high - low) * random.magnitude(-6.0, -0.5).abs();
            let touched: Vec<usize> = stencil(&curve, near, 0).iter().map(|t| t.0).collect();
            touched.iter().for_each(|&i| rows.push(vec![(i, 1.0)]));
            rows.push(stencil(&curve, near, 0));
            if random.below(2) == 0 {
                rows.rotate_right(1);
            }
        }
        5 => {
            name = "repeated";
            for _ in 0..2 + random.below(12) {
                let row = stencil(&curve, random.between(low, high), 0);
                (0..1 + random.below(20)).for_each(|_| rows.push(row.clone()));
            }
        }
        6 => {
            name = "tiny factors";
            let i = random.below(n - 1);
            rows.push(vec![(i, 1.0)]);
            rows.push(vec![(i + 1, random.magnitude(-3.0, 3.0))]);
            let tiny = random.magnitude(-14.0, 0.0);
            let picks = [(0, 1.0), (1, tiny)];
            rows.push(combination(&rows, &picks));
            (0..random.below(3)).for_each(|_| rows.push(stencil(&curve, random.between(low, high), 0)));
        }
        _ => {
            name = "a few";
            (0..1 + random.below(5)).for_each(|_| {
                rows.push(stencil(&curve, random.between(low, high), random.below(p.min(3) + 1)));
            });
        }
    }
    if random.below(4) == 0 {
        rows.push(Vec::new());
    }
    // Whatever else: a combination of some rows, for contradictions.
    let picks: Vec<(usize, f64)> = (0..1 + random.below(3))
        .map(|_| (random.below(rows.len()), random.magnitude(-1.0, 1.0)))
        .filter(|&(r, _)| !rows[r].is_empty())
        .collect();
    rows.push(combination(&rows, &picks));
    let implied = rows.len() - 1;
    if random.below(3) == 0 {
        for row in &mut rows {
            let scale = random.magnitude(-9.0, 9.0);
            row.iter_mut().for_each(|t| t.1 *= scale);
        }
    }
    Family { name, width: n, rows, implied }
}

/// A metric, and `dᵀWd` of it.
fn metric(kind: usize, n: usize, random: &mut Random) -> SystemMetric {
    match kind {
        0 | 1 => SystemMetric::Least,
        2 => SystemMetric::Weights(Arc::new((0..n).map(|_| random.magnitude(-3.0, 3.0).abs()).collect())),
        3 => {
            // Mass and bending: (d, d) + L⁴ Σ (second differences)².
            let stiff = (n as f64).powi(4) * 0.1;
            let mass = (0..n).map(|i| (i, i, 1.0));
            let bend = (2..n).flat_map(|i| {
                let (a, b, c) = (i - 2, i - 1, i);
                let six = [(a, a, 1.0), (b, b, 4.0), (c, c, 1.0), (a, b, -2.0), (b, c, -2.0), (a, c, 1.0)];
                six.map(|(i, j, v)| (i, j, v * stiff))
            });
            SystemMetric::Matrix(Arc::new(Symmetric::from_entries(n, mass.chain(bend).collect::<Vec<_>>())))
        }
        _ => {
            // Falloff (Wendland 1995).
            let radius = 1.0 + 6.0 * random.next();
            let near = (0..n).flat_map(|i| (i..n).map(move |j| (i, j, (j - i) as f64 / radius)));
            let entries =
                near.filter(|e| e.2 < 1.0).map(|(i, j, r)| (i, j, (1.0 - r).powi(3) * (3.0 * r + 1.0)));
            SystemMetric::Inverse(Arc::new(Symmetric::from_entries(n, entries.collect::<Vec<_>>())))
        }
    }
}

/// `dᵀWd`; `None` for metrics that are known by their inverse.
fn squared(metric: &SystemMetric, d: &[f64]) -> Option<f64> {
    match metric {
        SystemMetric::Least => Some(d.iter().map(|v| v * v).sum()),
        SystemMetric::Weights(w) => Some(d.iter().zip(w.iter()).map(|(v, w)| v * v * w).sum()),
        SystemMetric::Matrix(w) => {
            let mut product = vec![0.0; d.len()];
            w.multiply(d, 1, &mut product);
            Some(d.iter().zip(product).map(|(a, b)| a * b).sum())
        }
        SystemMetric::Inverse(_) | SystemMetric::Through(_) => None,
    }
}

struct Answer {
    d: Vec<f64>,
    diagnosis: Diagnosis,
}

enum Outcome {
    Solved(Answer),
    Conflict,
    Refused(SolveError),
}

/// What a session does: rank coarsely, and finely where what was asked denies what seemed to be implied.
fn answer(solver: &dyn Solver, system: &System, rhs: &[f64], size: &[f64]) -> Outcome {
    for system in [system.clone(), system.finely()] {
        let mut factored = match solver.factor(&system) {
            Ok(factored) => factored,
            Err(error) => return Outcome::Refused(error),
        };
        let diagnosis = factored.diagnosis();
        assert_eq!(diagnosis.rank + diagnosis.dependencies.len(), system.rows().len());
        let mut d = vec![f64::NAN; system.touched().len() * system.sides()];
        factored.solve_into(rhs, &mut d);
        if diagnosis.dependencies.iter().all(|row| row.agrees(&system, rhs, size, &d)) {
            return Outcome::Solved(Answer { d, diagnosis });
        }
    }
    Outcome::Conflict
}

/// The largest `|b - F d|`: of independent rows in roundings of `|b| + |F||d|`; of the others in roundings of what they are
/// made of, too, and of the numbers of `scale` that the right-hand side comes from.
fn residual(system: &System, rhs: &[f64], scale: &[f64], Answer { d, diagnosis }: &Answer) -> f64 {
    let (rows, mut worst) = (system.rows(), 0.0_f64);
    for (row, b) in rhs.iter().enumerate() {
        let terms = || rows.iter_row(row).map(|(c, v)| (v, d[c]));
        let missed = dot(terms().chain([(-1.0, *b)])).abs();
        let mut size = terms().map(|(v, d)| (v * d).abs()).sum::<f64>() + b.abs();
        if let Some(implied) = diagnosis.dependencies.iter().find(|d| d.row == row) {
            let all = || implied.combination.iter().copied().chain([(row, 1.0)]);
            let columns = all().flat_map(|(row, _)| rows.row(row).0.to_vec());
            let most = columns.fold(0.0_f64, |most, c| most.max(d[c as usize].abs()));
            let whole = |row: usize| {
                scale[row] + rhs[row].abs() + most * rows.row(row).1.iter().map(|v| v.abs()).sum::<f64>()
            };
            size = all().map(|(row, factor)| factor.abs() * whole(row)).sum();
        }
        let own = missed / (f64::EPSILON * size).max(f64::MIN_POSITIVE);
        worst = if own > worst || own.is_nan() { own } else { worst };
    }
    worst
}

/// Whether an adjustment is a near conflict: a million times longer than what each equation alone would cost.
fn is_near_conflict(system: &System, rhs: &[f64], d: &[f64]) -> bool {
    let Some(length) = squared(system.metric(), d) else { return d.iter().any(|v| v.abs() > 1e6) };
    // ‖f‖ in the inverse metric: by the least adjustment of the row alone.
    let alone = |row: usize| {
        let one = system.select(&[row]);
        let mut d = vec![0.0; one.touched().len()];
        HouseholderQr.factor(&one).unwrap().solve_into(&rhs[row..=row], &mut d);
        squared(one.metric(), &d).unwrap().sqrt()
    };
    length.sqrt() > 1e6 * (0..rhs.len()).map(alone).sum::<f64>()
}

const KINDS: usize = 8;
const ROUNDS: usize = 1000;

fn solvers() -> [&'static dyn Solver; 6] {
    [&Adjoint, &Sparse, &SaddlePoint, &HouseholderQr, &DenseLu, &Automatic]
}

#[test]
fn what_agrees_is_solved_to_rounding_and_what_contradicts_is_refused() {
    let mut random = Random(77);
    // Of each solver: solved, refused, contradictions found, contradictions refused otherwise, the largest residual.
    let mut tally = [[0_usize; 4]; 6];
    let mut largest = [0.0_f64; 6];
    // Consistent systems, nearly dependent, whose rounding was taken for a contradiction.
    let mut misjudged = [0_usize; 6];
    let mut failures: Vec<String> = Vec::new();
    for round in 0..KINDS * ROUNDS {
        let Family { name, width, rows: list, implied } = family(round % KINDS, &mut random);
        let metric = metric(round / KINDS % 5, width, &mut random);
        let mut rows = SparseRows::new(width);
        list.iter().for_each(|row| rows.push(row.iter().copied()));
        let system = System::new(rows, (0..width).collect(), 1, metric);
        let wish: Vec<f64> = (0..width).map(|_| random.between(-1.0, 1.0)).collect();
        let rhs: Vec<f64> =
            (0..list.len()).map(|row| dot(system.rows().iter_row(row).map(|(c, v)| (v, wish[c])))).collect();
        // What the right-hand side is made of.
        let of = |row: usize| system.rows().iter_row(row).map(|(c, v)| (v * wish[c]).abs()).sum::<f64>();
        let scale: Vec<f64> = (0..list.len()).map(of).collect();
        let mut denied = rhs.clone();
        let size = scale[implied];
        denied[implied] += random.magnitude(-6.0, 2.0) * if size > 0.0 { size } else { 1.0 };
        for (k, solver) in solvers().into_iter().enumerate() {
            let what = format!(
                "round {round}, {name}, {} rows, {width} columns, {:?}, {}",
                list.len(),
                std::mem::discriminant(system.metric()),
                solver.name()
            );
            match answer(solver, &system, &rhs, &scale) {
                Outcome::Solved(answer) => {
                    tally[k][0] += 1;
                    let left = residual(&system, &rhs, &scale, &answer);
                    let condition = answer.diagnosis.condition;
                    largest[k] = largest[k].max(left);
                    if left > 256.0 || left.is_nan() {
                        failures.push(format!("{what}: residual {left:.1e}, condition {condition:.1e}"));
                    }
                    if let (Some(own), Some(least)) =
                        (squared(system.metric(), &answer.d), squared(system.metric(), &wish))
                    {
                        // What rounding of the right-hand side may do.
                        let slack = 1e-6 + 64.0 * f64::EPSILON * condition;
                        if own.sqrt() > least.sqrt() * (1.0 + slack) || own.is_nan() {
                            failures.push(format!("{what}: {own:e} is not the least, {least:e} will do"));
                        }
                    }
                }
                Outcome::Conflict => misjudged[k] += 1,
                Outcome::Refused(SolveError::TooLarge { .. }) if k == 0 => continue,
                Outcome::Refused(SolveError::IllConditioned { .. }) if k < 5 => tally[k][1] += 1,
                Outcome::Refused(SolveError::Unsupported(_)) if k == 5 => tally[k][1] += 1,
                Outcome::Refused(error) => failures.push(format!("{what}: {error}")),
            }
            match answer(solver, &system, &denied, &scale) {
                Outcome::Conflict => tally[k][2] += 1,
                Outcome::Refused(_) => tally[k][3] += 1,
                Outcome::Solved(answer) => {
                    let left = residual(&system, &denied, &scale, &answer);
                    if left <= 256.0 && is_near_conflict(&system, &denied, &answer.d) {
                        tally[k][3] += 1;
                    } else {
                        let condition = answer.diagnosis.condition;
                        failures.push(format!(
                            "{what}: a contradiction is solved, residual {left:.1e}, condition {condition:.1e}"
                        ));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
    assert_eq!(misjudged, [0; 6], "called conflicts");
    // Refusals are few: those of adjoint, sparse and saddle-point name a better solver, which is what the default goes on to.
    let all = KINDS * ROUNDS;
    let [adjoint, sparse, saddle, qr, lu, automatic] = tally;
    assert!(adjoint[0] > all / 4 && adjoint[1] * 8 < adjoint[0], "{adjoint:?}");
    println!("{tally:?}, {largest:?}");
    assert!(sparse[1] * 5 < all && saddle[1] * 5 < all, "{sparse:?} {saddle:?}");
    assert!(qr[1] * 50 < all && lu[1] * 200 < all && automatic[1] * 200 < all, "{qr:?} {lu:?} {automatic:?}");
    // Contradictions are found, not merely refused.
    assert!([sparse, saddle, qr, lu, automatic].iter().all(|t| t[2] >= t[0] - all / 50), "{tally:?}");
    assert!(largest.iter().all(|l| *l <= 256.0), "{largest:?}");
}

/// The same families through a map from fewer unknowns: what these can reach is solved, and what contradicts is refused.
#[test]
fn what_goes_through_a_map_agrees_or_contradicts_as_everything_else() {
    let mut random = Random(31);
    let (mut solved, mut refused, mut found, mut all) = (0, 0, 0, 0);
    for round in 0..KINDS * 60 {
        let Family { name, width, rows: list, implied } = family(round % KINDS, &mut random);
        let unknowns = width - width / 4;
        let mut map = SparseRows::new(unknowns);
        for i in 0..width {
            map.push([
                (i % unknowns, random.between(0.5, 2.0)),
                ((i * 7 + 1) % unknowns, random.between(-0.4, 0.4)),
            ]);
        }
        let w: Vec<f64> = (0..unknowns).map(|_| random.between(-1.0, 1.0)).collect();
        let mut wish = vec![0.0; width];
        map.multiply(&w, 1, &mut wish);
        let measure = (round / KINDS % 2 == 1).then(|| {
            Arc::new(Symmetric::from_entries(unknowns, (0..unknowns).map(|i| (i, i, 0.5 + i as f64))))
        });
        let weigh = |x: &[f64]| -> f64 {
            x.iter().enumerate().map(|(i, v)| v * v * measure.as_ref().map_or(1.0, |m| m.entry(i, i))).sum()
        };
        let least = weigh(&w);
        let map = Map::Sparse(Arc::new(map));
        let metric = SystemMetric::Through(Arc::new(Through {
            map: map.clone(),
            measure: measure.clone(),
            is_own: true,
        }));
        let mut rows = SparseRows::new(width);
        list.iter().for_each(|row| rows.push(row.iter().copied()));
        let system = System::new(rows, (0..width).collect(), 1, metric);
        let rhs: Vec<f64> =
            (0..list.len()).map(|row| dot(system.rows().iter_row(row).map(|(c, v)| (v, wish[c])))).collect();
        let of = |row: usize| system.rows().iter_row(row).map(|(c, v)| (v * wish[c]).abs()).sum::<f64>();
        let scale: Vec<f64> = (0..list.len()).map(of).collect();
        let mut denied = rhs.clone();
        denied[implied] += 0.1 * scale[implied].max(f64::MIN_POSITIVE);
        for solver in solvers() {
            all += 1;
            let what = format!("round {round}, {name}, {}", solver.name());
            match answer(solver, &system, &rhs, &scale) {
                Outcome::Solved(answer) => {
                    solved += 1;
                    // Rows over the unknowns that nearly depend on each other are missed by what they are made of.
                    let left = residual(&system, &rhs, &scale, &answer);
                    assert!(left < 1e4, "{what}: {left:.1e}");
                    let mut x = vec![0.0; unknowns];
                    map.nearest_unknowns(&answer.d, 1, &mut x);
                    let own = weigh(&x);
                    let slack = 1e-6 + 64.0 * f64::EPSILON * answer.diagnosis.condition;
                    assert!(own.sqrt() <= least.sqrt() * (1.0 + slack), "{what}: {own:e}, {least:e} will do");
                }
                Outcome::Conflict => panic!("{what}: called a conflict"),
                Outcome::Refused(
                    SolveError::TooLarge { .. }
                    | SolveError::IllConditioned { .. }
                    | SolveError::Unsupported(_),
                ) => refused += 1,
                Outcome::Refused(error) => panic!("{what}: {error}"),
            }
            match answer(solver, &system, &denied, &scale) {
                Outcome::Conflict => found += 1,
                Outcome::Refused(_) => {}
                Outcome::Solved(answer) => {
                    let left = residual(&system, &denied, &scale, &answer);
                    assert!(
                        is_near_conflict(&system, &denied, &answer.d),
                        "{what}: a contradiction, residual {left:.1e}"
                    );
                }
            }
        }
    }
    println!("{solved} solved, {refused} refused, {found} contradictions found, of {all}");
    assert!(solved * 10 > all * 8 && found * 10 > all * 7, "{solved} {found} {refused} of {all}");
}

/// `d = W⁻¹Fᵀλ` where rows were dropped, too, whose multipliers are zero: told by `bᵀλ = dᵀWd`, and vector by vector where the
/// metric or its inverse is at hand.
#[test]
fn multipliers_carry_the_adjustment_where_rows_were_dropped() {
    let mut random = Random(31);
    let mut checked = [[0_usize; 5]; 6];
    for round in 0..600 {
        let kind = round / 3 % 5;
        let Family { name, width, rows: list, .. } = family([3, 5, 7][round % 3], &mut random);
        let metric = metric(kind, width, &mut random);
        let mut rows = SparseRows::new(width);
        list.iter().for_each(|row| rows.push(row.iter().copied()));
        let system = System::new(rows, (0..width).collect(), 1, metric);
        let wish: Vec<f64> = (0..width).map(|_| random.between(-1.0, 1.0)).collect();
        let rhs: Vec<f64> =
            (0..list.len()).map(|row| dot(system.rows().iter_row(row).map(|(c, v)| (v, wish[c])))).collect();
        for (k, solver) in solvers().into_iter().enumerate() {
            let Ok(mut factored) = solver.factor(&system) else { continue };
            let Diagnosis { condition, dependencies, .. } = factored.diagnosis();
            if dependencies.is_empty() || condition > 1e4 {
                continue;
            }
            let what = format!("round {round}, {name}, {}", solver.name());
            let (mut d, mut multipliers) = (vec![f64::NAN; width], vec![f64::NAN; list.len()]);
            factored.solve_into(&rhs, &mut d);
            factored.multipliers_into(&rhs, &mut multipliers);
            assert!(dependencies.iter().all(|row| multipliers[row.row] == 0.0), "{what}");
            let mut force = vec![0.0; width];
            for (row, multiplier) in multipliers.iter().enumerate() {
                system.rows().iter_row(row).for_each(|(c, v)| force[c] += v * multiplier);
            }
            let expected = match system.metric() {
                SystemMetric::Least => Some(force.clone()),
                SystemMetric::Weights(w) => Some(force.iter().zip(w.iter()).map(|(f, w)| f / w).collect()),
                SystemMetric::Inverse(inverse) => {
                    let mut moved = vec![0.0; width];
                    inverse.multiply(&force, 1, &mut moved);
                    Some(moved)
                }
                SystemMetric::Matrix(_) | SystemMetric::Through(_) => None,
            };
            let largest = d.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            for (own, expected) in expected.iter().flat_map(|expected| d.iter().zip(expected)) {
                assert!((own - expected).abs() <= 1e-7 * largest, "{what}: {own:e} for {expected:e}");
            }
            let work = dot(rhs.iter().copied().zip(multipliers.iter().copied()));
            if let Some(own) = squared(system.metric(), &d) {
                // Bending hundreds of vertices is as ill-conditioned as that; no multipliers at all would be all of it.
                assert!((own - work).abs() <= 1e-3 * own, "{what}: {own:e} for {work:e}");
            }
            checked[k][kind] += 1;
        }
    }
    // Adjoint takes six equations only.
    assert!(
        checked.iter().skip(1).flatten().all(|&n| n >= 20) && checked[0].iter().sum::<usize>() >= 20,
        "{checked:?}"
    );
}
