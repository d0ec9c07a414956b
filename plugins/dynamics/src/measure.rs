//! How much there is of a shape, and where: Gauss points on parts of cells, so many and so small that they see it as it is.
//!
//! `|P'|` and `|P_u × P_v|` are no polynomials: what turns sharply within a cell is seen by no rule of few points. So each cell is summed up by a rule of Gauss and
//! Lobatto, which looks at its ends, and by one of Gauss and Legendre, which looks between, and where these differ it is halved, in the direction in which they differ more,
//! its worst part first.

mod rule;

use std::collections::BTreeMap;

use loftsman_kernel::shape::{Cell, Derivative, Location, Shape, Stencil, cells_of, rows_at};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use self::rule::{Key, Rule};
use crate::error::Result;
use crate::points::order;

/// The rules are the same that differ by this share of what a cell has.
const SAME: f64 = 1e-10;
/// A cell is halved so often at most.
const HALVED: usize = 1000;
/// All together so often, and so often for each of them.
const ALL: usize = 20_000;
const EACH: usize = 8;

/// A part of a cell: its Gauss points, along the last parameter first, and how much of the shape each of them stands for.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// How many there are in each direction.
    pub(crate) counts: [usize; 2],
    pub(crate) points: Vec<Location>,
    pub(crate) shares: Vec<f64>,
}

impl Part {
    /// All of it.
    pub(crate) fn whole(&self) -> f64 {
        self.shares.iter().sum()
    }

    /// Its points, each with how much it stands for.
    pub(crate) fn weighed(&self) -> Vec<(Location, f64)> {
        self.points.iter().copied().zip(self.shares.iter().copied()).collect()
    }

    /// For each of its points along one direction of a surface what there is in all across it there.
    pub(crate) fn sums(&self, direction: usize) -> Vec<(Location, f64)> {
        let [along, across] = self.counts;
        let at = |i: usize, j: usize| i * across + j;
        let sum = |indices: &mut dyn Iterator<Item = usize>| indices.map(|index| self.shares[index]).sum();
        match direction {
            0 => {
                (0..along).map(|i| (self.points[at(i, 0)], sum(&mut (0..across).map(|j| at(i, j))))).collect()
            }
            _ => {
                (0..across).map(|j| (self.points[at(0, j)], sum(&mut (0..along).map(|i| at(i, j))))).collect()
            }
        }
    }
}

/// A part, and what is known of it.
struct Judged {
    cell: Cell,
    part: Part,
    /// By how much the rules differ, beyond rounding.
    apart: f64,
    /// Across which direction to halve it.
    across: usize,
}

/// How much there is of a shape: of a curve its length, of a surface its area.
pub(crate) struct Measure<'s> {
    shape: &'s dyn Shape,
    /// Curves without extent, for the basis functions along each direction of a polynomial tensor-product surface.
    lines: Option<[Curve; 2]>,
    /// Nodes and weights, and Legendre's polynomial of twice the degree there.
    rules: BTreeMap<Key, Rule>,
    /// How often parts may be halved still.
    left: usize,
    missing: f64,
    seen: f64,
}

impl<'s> Measure<'s> {
    /// Of a shape of so many cells.
    pub(crate) fn new(shape: &'s dyn Shape, cells: usize) -> Result<Self> {
        let splines = shape.cells().and_then(|cells| cells.splines());
        let splines = splines.filter(|splines| splines.weights.is_none());
        let lines = splines.and_then(|splines| Some(lines(splines.u, splines.v?))).transpose()?;
        let left = ALL + EACH * cells;
        Ok(Self { shape, lines, rules: BTreeMap::new(), left, missing: 0.0, seen: 0.0 })
    }

    /// What sums over all that was looked at until now may be wrong by, as a share: what rules differed by still when they were taken.
    pub(crate) fn missing(&self) -> f64 {
        if self.missing > 0.0 { self.missing / self.seen } else { 0.0 }
    }

    /// The parts of a cell, and how much there is at each of their points, so that sums of it times products of two of the basis functions are those of all that is between, to 1e-10
    /// of what the cell has of it: what [remains](Self::missing) where creases run askew is 1e-7 or so of it. One look by two rules, of five and of six points more than its degree in each
    /// direction, where that is enough.
    pub(crate) fn of(&mut self, cell: &Cell) -> Result<Vec<Part>> {
        let mut parts = vec![self.judged(cell.clone())?];
        let mut halved = 0;
        loop {
            let (mut whole, mut apart, mut worst) = (0.0, 0.0, (0.0, None));
            for (index, judged) in parts.iter().enumerate() {
                whole += judged.part.whole();
                apart += judged.apart;
                if judged.apart > worst.0 {
                    worst = (judged.apart, Some(index));
                }
            }
            let halves = match worst.1 {
                Some(index) if apart > SAME * whole && halved < HALVED && self.left > 0 => {
                    halves(&parts[index].cell, parts[index].across).map(|halves| (index, halves))
                }
                _ => None,
            };
            let Some((index, [low, high])) = halves else {
                (self.missing, self.seen) = (self.missing + apart, self.seen + whole);
                return Ok(parts.into_iter().map(|judged| judged.part).collect());
            };
            (halved, self.left) = (halved + 1, self.left - 1);
            parts[index] = self.judged(low)?;
            let high = self.judged(high)?;
            parts.insert(index + 1, high);
        }
    }

    fn judged(&mut self, cell: Cell) -> Result<Judged> {
        let (ends, between) = ([true; 2], [false; 2]);
        let (rough, noise) = self.part(&cell, ends)?;
        let (part, _) = self.part(&cell, between)?;
        let (rough, fine) = (self.moments(&cell, &rough, ends), self.moments(&cell, &part, between));
        let differ =
            |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let apart = (differ(&rough, &fine) - noise).max(0.0);
        let mut across = 0;
        // Only of those that will be halved: which of both directions has not enough.
        if cell.sides.len() == 2 && apart > SAME * part.whole() {
            let mut along = [0.0; 2];
            for k in 0..2 {
                let mut one = between;
                one[k] = true;
                let (mixed, _) = self.part(&cell, one)?;
                along[k] = differ(&self.moments(&cell, &mixed, one), &fine);
            }
            across = usize::from(along[1] > along[0]);
        }
        Ok(Judged { cell, part, apart, across })
    }

    /// What there is in all, and its moments with Legendre's polynomials of twice the degree, in each direction and in both: sums with products of two basis functions are made of such and of
    /// those of lower degree.
    fn moments(&self, cell: &Cell, part: &Part, with_ends: [bool; 2]) -> [f64; 4] {
        let highest = |k: usize| {
            self.rules.get(&Key::new(cell, k, with_ends[k])).map_or(&[][..], |rule| &rule.highest[..])
        };
        let (along, across) = (highest(0), highest(1));
        let mut all = [0.0; 4];
        for (index, share) in part.shares.iter().enumerate() {
            let by = |row: &[f64], at: usize| row.get(at).copied().unwrap_or(0.0);
            let u = by(along, index / part.counts[1]);
            let v = if cell.sides.len() == 2 { by(across, index % part.counts[1]) } else { 0.0 };
            for (sum, by) in all.iter_mut().zip([1.0, u, v, u * v]) {
                *sum += share * by;
            }
        }
        all
    }

    /// A part by these rules, and what of its sum may be rounding.
    fn part(&mut self, cell: &Cell, with_ends: [bool; 2]) -> Result<(Part, f64)> {
        let directions = cell.sides.len();
        let keys = [0, 1].map(|k| Key::new(cell, k, with_ends[k]));
        for key in keys {
            self.rules.entry(key).or_insert_with(|| Rule::new(key));
        }
        let [along, across] = [&self.rules[&keys[0]], &self.rules[&keys[1]]];
        let counts = if directions == 2 { keys.map(|key| key.count) } else { [keys[0].count, 1] };
        let size = cell.size();
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (x, w) in along.within(cell.sides.first()).zip(&along.weights) {
            if directions < 2 {
                points.push(cell.at([x, 0.0]));
                weights.push(w * size);
                continue;
            }
            for (y, b) in across.within(cell.sides.get(1)).zip(&across.weights) {
                points.push(cell.at([x, y]));
                weights.push(w * b * size);
            }
        }
        let tangents = match &self.lines {
            Some(lines) => self.by_lines(lines, &points, counts)?,
            None => self.by_stencils(cell, &points, &weights)?,
        };
        let far = |v: usize| self.shape.control_vertices()[v].coords.amax();
        let far = cell.vertices.iter().fold(0.0_f64, |most, &v| most.max(far(v)));
        let (mut shares, mut noise) = (Vec::with_capacity(points.len()), 0.0);
        for ([u, v], weight) in tangents.iter().zip(&weights) {
            let off = |tangent: &Tangent| 4.0 * f64::EPSILON * tangent.sum * far;
            let (share, rounding) = if directions == 2 {
                let (au, av) = (u.way.norm(), v.way.norm());
                (u.way.cross(&v.way).norm(), au * off(v) + av * off(u) + off(u) * off(v))
            } else {
                (u.way.norm(), off(u))
            };
            shares.push(weight * share);
            noise += weight.abs() * (rounding + 4.0 * f64::EPSILON * share);
        }
        Ok((Part { counts, points, shares }, noise))
    }

    /// First derivatives at the points of a grid, by the basis functions of both directions.
    fn by_lines(
        &self,
        lines: &[Curve; 2],
        points: &[Location],
        counts: [usize; 2],
    ) -> Result<Vec<[Tangent; 2]>> {
        let rows = |k: usize| {
            let stride = if k == 0 { counts[1] } else { 1 };
            (0..counts[k])
                .map(|at| {
                    let (x, y) = points[at * stride].on_surface()?;
                    let at = Location::Curve(if k == 0 { x } else { y });
                    Ok([
                        lines[k].stencil(at, Derivative::POSITION)?,
                        lines[k].stencil(at, Derivative::from(1))?,
                    ])
                })
                .collect::<loftsman_kernel::Result<Vec<_>>>()
        };
        let (along, across) = (rows(0)?, rows(1)?);
        let (vertices, width) = (self.shape.control_vertices(), lines[1].control_vertices().len());
        let mut columns: Vec<usize> =
            across.iter().flatten().flat_map(Stencil::iter).map(|(j, _)| j).collect();
        columns.sort_unstable();
        columns.dedup();
        // The rows across by the numbers of their columns among these.
        let among = |row: &Stencil| -> Vec<(usize, f64)> {
            row.iter().map(|(j, c)| (columns.partition_point(|column| *column < j), c)).collect()
        };
        let across: Vec<[Vec<(usize, f64)>; 2]> =
            across.iter().map(|[value, slope]| [among(value), among(slope)]).collect();
        let size = |row: &[(usize, f64)]| row.iter().map(|(_, c)| c.abs()).sum::<f64>();
        let mut all = Vec::with_capacity(points.len());
        for rows in &along {
            let [value, slope] = rows.each_ref().map(|row| row.iter().collect::<Vec<_>>());
            // Combined along u once, for each column.
            let line = |row: &[(usize, f64)]| -> Vec<Vector> {
                let sum = |j: usize| {
                    row.iter().fold(Vector::zeros(), |sum, (i, c)| sum + vertices[i * width + j].coords * *c)
                };
                columns.iter().map(|j| sum(*j)).collect()
            };
            let (values, slopes) = (line(&value), line(&slope));
            let (of_value, of_slope) = (size(&value), size(&slope));
            for [value, slope] in &across {
                let sum = |row: &[(usize, f64)], line: &[Vector]| {
                    row.iter().fold(Vector::zeros(), |sum, (j, c)| sum + line[*j] * *c)
                };
                all.push([
                    Tangent { way: sum(value, &slopes), sum: of_slope * size(value) },
                    Tangent { way: sum(slope, &values), sum: of_value * size(slope) },
                ]);
            }
        }
        Ok(all)
    }

    fn by_stencils(&self, cell: &Cell, points: &[Location], weights: &[f64]) -> Result<Vec<[Tangent; 2]>> {
        let weighed: Vec<(Location, f64)> = points.iter().copied().zip(weights.iter().copied()).collect();
        let (width, vertices) = (cell.vertices.len().max(1), self.shape.control_vertices());
        let mut all = vec![[Tangent::default(); 2]; points.len()];
        for k in 0..cell.sides.len().min(2) {
            let rows = rows_at(self.shape, cell, &weighed, order(k, 1))?;
            for (tangents, row) in all.iter_mut().zip(rows.chunks_exact(width)) {
                for (c, &v) in row.iter().zip(&cell.vertices) {
                    tangents[k].way += vertices[v].coords * *c;
                    tangents[k].sum += c.abs();
                }
            }
        }
        Ok(all)
    }
}

/// The length of a curve, the area of a surface.
pub(crate) fn whole(shape: &dyn Shape) -> Result<f64> {
    let cells = cells_of(shape, "a length")?.checked(shape)?;
    let mut measure = Measure::new(shape, cells.len())?;
    let mut all = 0.0;
    for cell in &cells {
        all += measure.of(cell)?.iter().map(Part::whole).sum::<f64>();
    }
    Ok(all)
}

/// Curves without extent, for the basis functions of both directions of a surface.
pub(crate) fn lines(u: &Space, v: &Space) -> Result<[Curve; 2]> {
    let line = |space: &Space| Curve::new(space.clone(), vec![Point::origin(); space.len()]);
    Ok([line(u)?, line(v)?])
}

/// A first derivative, and the sum of the coefficients' sizes that it has of vertices.
#[derive(Debug, Clone, Copy, Default)]
struct Tangent {
    way: Vector,
    sum: f64,
}

/// Both halves of a part; none of one that has no middle.
fn halves(part: &Cell, across: usize) -> Option<[Cell; 2]> {
    let side = part.sides.get(across)?;
    let middle = 0.5 * side.start + 0.5 * side.end;
    if middle <= side.start || middle >= side.end {
        return None;
    }
    let mut halves = [part.clone(), part.clone()];
    halves[0].sides[across].end = middle;
    halves[1].sides[across].start = middle;
    Some(halves)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::Surface;

    use super::*;
    use crate::body::Material;
    use crate::elastic::tests::power;
    use crate::mass::Mass;

    fn wide(points: &[Point], by: f64) -> Vec<Point> {
        points.iter().flat_map(|p| [*p, p + Vector::y() * by]).collect()
    }

    /// `P = (b (t - m)²/2, c t)`, a parabola or a hairpin in one span, of degrees 2 to 7 and 25, and a strip of it along either direction: lengths in closed form, the mass likewise.
    #[test]
    fn what_turns_within_a_cell_has_all_of_its_mass() {
        for degree in [2, 3, 4, 5, 7, 25] {
            for (m, c) in
                [(0.5, 4.0), (0.37, 1.0), (0.37, 1e-6), (0.5, 0.0), (0.5, 0.1), (0.913, 1e-3), (0.05, 0.3)]
            {
                let b = 4.0;
                let space = Space::clamped(degree, &[0.0, 1.0]).unwrap();
                let [x, squares] = [1, 2].map(|a| power(&space, a));
                let points = x.iter().zip(&squares);
                let points: Vec<Point> =
                    points.map(|(x, xx)| Point::new(0.5 * b * (xx - 2.0 * m * x), 0.0, c * x)).collect();
                let primitive = |x: f64| {
                    let bent = if c > 0.0 { c * c / b * (b * x / c).asinh() } else { 0.0 };
                    0.5 * (x * (b * x).hypot(c) + bent)
                };
                let wanted = primitive(1.0 - m) - primitive(-m);
                let curve = Curve::new(space.clone(), points.clone()).unwrap();
                let across = Space::clamped_uniform(1, 2).unwrap();
                let sheet = Surface::new(space.clone(), across.clone(), wide(&points, 0.5)).unwrap();
                let turned: Vec<Point> = [0.0, 0.5]
                    .iter()
                    .flat_map(|by| points.iter().map(move |p| p + Vector::y() * *by))
                    .collect();
                let weights = vec![1.0; turned.len()];
                let turned = Surface::rational(across, space, turned, weights).unwrap();
                for (shape, wanted) in
                    [(&curve as &dyn Shape, wanted), (&sheet, 0.5 * wanted), (&turned, 0.5 * wanted)]
                {
                    let found = whole(shape).unwrap();
                    assert!((found / wanted - 1.0).abs() < 1e-9, "{degree} {m} {c}: {found} {wanted}");
                    if c > 1e-3 {
                        let mass = Mass::new(shape, &Material { mass: 3.0, ..Material::default() }).unwrap();
                        let all: f64 = mass.lumped.iter().sum();
                        assert!((all / (3.0 * wanted) - 1.0).abs() < 1e-9, "{degree} {m} {c}: {all}");
                        assert!(mass.missing < 1e-10, "{degree} {m} {c}: {}", mass.missing);
                    }
                }
            }
        }
    }

    /// Cusps close to where parts end: `P = ((t - m)²/2, 0)` in one span of degrees 2 to 5, curves and strips, `∫ |t - m| = (m² + (1 - m)²)/2`.
    #[test]
    fn cusps_close_to_the_ends_of_parts() {
        for degree in [2, 3, 4, 5] {
            let space = Space::clamped(degree, &[0.0, 1.0]).unwrap();
            let [x, squares] = [1, 2].map(|a| power(&space, a));
            for beside in [0.0, 0.125, 0.25, 0.5, 0.75, 1.0] {
                for off in [0.0, 1e-10, 1e-7, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 0.02] {
                    let m: f64 = if beside < 0.5 { beside + off } else { beside - off };
                    let points = x.iter().zip(&squares);
                    let points: Vec<Point> =
                        points.map(|(x, xx)| Point::new(0.5 * (xx - 2.0 * m * x), 0.0, 0.0)).collect();
                    let wanted = 0.5 * (m * m + (1.0 - m) * (1.0 - m));
                    let curve = Curve::new(space.clone(), points.clone()).unwrap();
                    let across = Space::clamped_uniform(1, 2).unwrap();
                    let sheet = Surface::new(space.clone(), across, wide(&points, 1.0)).unwrap();
                    for shape in [&curve as &dyn Shape, &sheet] {
                        let found = whole(shape).unwrap();
                        assert!((found / wanted - 1.0).abs() < 2e-10, "{degree} {m}: {found} {wanted}");
                    }
                }
            }
        }
    }

    /// `x = t + t²` in one span: `∫ (1 + 2t) b_i b_j dt` by Euler's integrals.
    #[test]
    fn entries_by_eulers_integrals() {
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        let choose = |n: usize, k: usize| factorial(n) / (factorial(k) * factorial(n - k));
        let beta = |a: usize, b: usize| factorial(a) * factorial(b) / factorial(a + b + 1);
        for degree in [2, 3, 4, 5, 7] {
            let space = Space::clamped(degree, &[0.0, 1.0]).unwrap();
            let [x, squares] = [1, 2].map(|a| power(&space, a));
            let points = x.iter().zip(&squares).map(|(x, xx)| Point::new(0.0, x + xx, 0.0)).collect();
            let mass = Mass::new(&Curve::new(space, points).unwrap(), &Material::default()).unwrap();
            for i in 0..=degree {
                for j in 0..=i {
                    let (low, high) = (i + j, 2 * degree - i - j);
                    let wanted =
                        choose(degree, i) * choose(degree, j) * (beta(low, high) + 2.0 * beta(low + 1, high));
                    let found = mass.matrix.entry(i, j);
                    assert!((found / wanted - 1.0).abs() < 1e-12, "{degree} {i} {j}: {found} {wanted}");
                }
            }
        }
    }

    /// A sphere of two poles and a torus' quarter tube by unlike weights; a fold askew to both directions of a net of squares, whose area is a sum of triangles.
    #[test]
    fn spheres_and_folds() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let arc = Space::clamped(2, &[0.0, 1.0]).unwrap();
        // An eighth of a sphere of radius 2, its pole a row of points; far off.
        let (ring, line) = ([(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        let weight = [1.0, half, 1.0];
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (i, (x, y)) in ring.iter().enumerate() {
            for (j, (r, z)) in line.iter().enumerate() {
                points.push(Point::new(100.0 + 2.0 * x * r, 2.0 * y * r, 2.0 * z));
                weights.push(weight[i] * weight[j]);
            }
        }
        let ball = Surface::rational(arc.clone(), arc, points, weights).unwrap();
        let wanted = 2.0 * std::f64::consts::PI;
        let found = whole(&ball).unwrap();
        assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
        // `(x + y - 1)²` over the square along x: folded on the line `x + y = 1`, where its area element is `2 |x + y - 1|`.
        let square = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let [one, x, xx] = [0, 1, 2].map(|a| power(&square, a));
        let points = (0..9).map(|k| {
            let (i, j) = (k / 3, k % 3);
            let folded = xx[i] * one[j] + one[i] * xx[j] + one[i] * one[j] + 2.0 * x[i] * x[j]
                - 2.0 * x[i] * one[j]
                - 2.0 * one[i] * x[j];
            Point::new(folded, x[j], 0.0)
        });
        let fold = Surface::new(square.clone(), square, points.collect()).unwrap();
        let cells = cells_of(&fold, "a test").unwrap().checked(&fold).unwrap();
        let mut measure = Measure::new(&fold, cells.len()).unwrap();
        let found: f64 = measure.of(&cells[0]).unwrap().iter().map(Part::whole).sum();
        let wanted = 2.0 / 3.0;
        let off = (found / wanted - 1.0).abs();
        assert!(
            off < 1e-7 && off < measure.missing() && measure.missing() < 1e-7,
            "{found} {} {off}",
            measure.missing()
        );
    }
}
