//! The energy of stretching as it is, where steps sum it up at few places a span.
//!
//! `|P'|` is no polynomial: where a curve turns back within a span it has as good as a corner there, of which no rule of few points knows. So each cell is summed up by two
//! rules of Gauss and Legendre, of four and of eight points more than its degree; where these differ by more than a share of what there is, it is halved (in each direction), and its
//! parts are looked at in the same way.

use loftsman_kernel::shape::{Cell, Shape, cells_of, rows_at};
use loftsman_kernel::{Point, Vector};

use crate::body::Material;
use crate::error::Result;
use crate::points::{Rest, order};

/// So many points more than its degree a part of a cell has in each direction, by one rule and by the other.
const MORE: [usize; 2] = [4, 8];
/// Both are the same that differ by this share of the energy of a part, or of what a cell has of it on average.
const SAME: f64 = 1e-5;
/// Parts are halved so often at most: of a curve, of a surface.
const HALVED: [usize; 2] = [24, 4];
/// And so many are looked at beside the cells, for each of these.
const PARTS: usize = 8;
const LEAST: usize = 1000;

/// The energy of stretching and shearing of a shape that was so at `first`: what it is, where [`energy`](crate::elastic::Elastic::energy) is what steps take it for. To 1e-4 or so
/// of a curve; of a surface that folds sharply within its cells to 1e-2. `O(n)`.
pub(crate) fn stretching(shape: &dyn Shape, first: &[Point], material: &Material) -> Result<f64> {
    let cells = cells_of(shape, "an energy")?.checked(shape)?;
    let look = Look { shape, first, material };
    let each: Vec<Sums> = cells.iter().map(|cell| look.sums(cell)).collect::<Result<_>>()?;
    let mean = each.iter().map(|sums| sums.energy).sum::<f64>() / cells.len().max(1) as f64;
    let mut left = PARTS * cells.len() + LEAST;
    let most = HALVED[usize::from(shape.domain().len() == 2)];
    let mut all = 0.0;
    for (cell, sums) in cells.into_iter().zip(each) {
        // Those that are not seen well enough yet, with how often they were halved.
        let mut parts = vec![(cell, sums, 0)];
        while let Some((part, sums, halved)) = parts.pop() {
            let same = sums.apart <= SAME * sums.energy.max(mean) + sums.noise;
            if same || !sums.apart.is_finite() || halved == most || left == 0 {
                all += sums.energy;
                continue;
            }
            for half in halves(&part) {
                left = left.saturating_sub(1);
                let sums = look.sums(&half)?;
                parts.push((half, sums, halved + 1));
            }
        }
    }
    Ok(all)
}

/// The halves of a part of a cell, the quarters of one of two directions.
fn halves(part: &Cell) -> Vec<Cell> {
    let mut all = vec![part.clone()];
    for k in 0..part.sides.len() {
        let middle = 0.5 * (part.sides[k].start + part.sides[k].end);
        let (mut low, mut high) = (all.clone(), all);
        low.iter_mut().for_each(|half| half.sides[k].end = middle);
        high.iter_mut().for_each(|half| half.sides[k].start = middle);
        low.append(&mut high);
        all = low;
    }
    all
}

/// What both rules say of a part.
struct Sums {
    /// By the finer rule.
    energy: f64,
    /// By how much the other differs.
    apart: f64,
    /// By how much it may for the rounding of vertices.
    noise: f64,
}

struct Look<'a> {
    shape: &'a dyn Shape,
    first: &'a [Point],
    material: &'a Material,
}

impl Look<'_> {
    fn sums(&self, part: &Cell) -> Result<Sums> {
        let [(coarse, _), (energy, noise)] = [self.sum(part, MORE[0])?, self.sum(part, MORE[1])?];
        Ok(Sums { energy, apart: (energy - coarse).abs(), noise })
    }

    /// The energy of a part by so many points more than its degree, and how much of it may be rounding.
    fn sum(&self, part: &Cell, more: usize) -> Result<(f64, f64)> {
        let Self { shape, first, material } = *self;
        let (directions, now) = (shape.domain().len(), shape.control_vertices());
        let count = |k: usize| part.sides.get(k).map_or(0, |side| side.degree + more);
        let points = part.gauss_points([count(0), count(1)]);
        let width = part.vertices.len();
        let rows: Vec<Vec<f64>> = (0..directions)
            .map(|k| rows_at(shape, part, &points, order(k, 1)))
            .collect::<loftsman_kernel::Result<_>>()?;
        let far = part.vertices.iter().fold(0.0_f64, |most, &v| most.max(now[v].coords.amax()));
        let (mut energy, mut noise) = (0.0, 0.0);
        for (index, (_, weight)) in points.iter().enumerate() {
            let (mut before, mut after) = ([Vector::zeros(); 2], [Vector::zeros(); 2]);
            let mut rounding = 0.0_f64;
            for k in 0..directions {
                let row = &rows[k][index * width..][..width];
                for (c, &v) in row.iter().zip(&part.vertices) {
                    before[k] += first[v].coords * *c;
                    after[k] += now[v].coords * *c;
                }
                rounding = rounding.max(row.iter().map(|c| c.abs()).sum::<f64>() * far * f64::EPSILON);
            }
            let rest = Rest::new(*weight, &before, directions, material.rest);
            let scale = 0.5 * rest.weight * rest.size;
            for (after, speed) in after.iter().zip(rest.speed).take(directions) {
                let (strain, off) = (after.norm() / speed - 1.0, rounding / speed);
                energy += scale * material.stiffness * strain.powi(2);
                noise += scale * material.stiffness * off * (2.0 * strain.abs() + off);
            }
            if directions == 2 {
                let lengths = rest.speed[0] * rest.speed[1];
                let shear = after[0].dot(&after[1]) / lengths - rest.cosine;
                let off = rounding * (after[0].norm() + after[1].norm() + rounding) / lengths;
                energy += scale * material.shear * shear * shear;
                noise += scale * material.shear * off * (2.0 * shear.abs() + off);
            }
        }
        Ok((energy, noise))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::{Curve, Space, Surface};

    use super::*;
    use crate::elastic::Elastic;
    use crate::elastic::tests::power;

    /// A straight rope and strip of length 1, bowed to `z = c x²/2`: `½ k ∫ (√(1 + c²x²) - 1)² dx` in closed form, of any degree.
    #[test]
    fn energy_is_told_as_it_is() {
        for degree in [2, 3, 4, 5, 7] {
            for c in [0.1_f64, 2.0, 20.0] {
                let space = Space::clamped(degree, &[0.0, 0.4, 1.0]).unwrap();
                let [x, squares] = [1, 2].map(|a| power(&space, a));
                let at = |k: usize, c: f64| Point::new(x[k], 0.0, 0.5 * c * squares[k]);
                let shape =
                    |c: f64| Curve::new(space.clone(), (0..x.len()).map(|k| at(k, c)).collect()).unwrap();
                let (flat, bowed) = (shape(0.0), shape(c));
                let material = Material { stiffness: 30.0, shear: 7.0, ..Material::default() };
                let root = (1.0 + c * c).sqrt();
                let wanted = 15.0 * (2.0 + c * c / 3.0 - root - c.asinh() / c);
                let found = stretching(&bowed, flat.points(), &material).unwrap();
                assert!((found - wanted).abs() < 1e-4 * wanted, "{degree} {c}: {found} {wanted}");
                // As wide as 2, where nothing is stretched across or sheared.
                let across = Space::clamped_uniform(1, 2).unwrap();
                let wide = |curve: &Curve| -> Vec<Point> {
                    curve.points().iter().flat_map(|p| [*p, p + Vector::y() * 2.0]).collect()
                };
                let sheet = Surface::new(space.clone(), across, wide(&bowed)).unwrap();
                let found = stretching(&sheet, &wide(&flat), &material).unwrap();
                assert!((found - 2.0 * wanted).abs() < 2e-3 * wanted, "{degree} {c}: {found} {wanted}");
            }
        }
    }

    /// Turned back where no point is, `P = (b (t - m)²/2, c t)` of degrees 2 to 7 in one span, against `½ k ∫ (|P'| - 1)² dt` in closed form: sharply and less so; and a
    /// strip of it.
    #[test]
    fn what_turns_back_within_a_span_is_told_as_it_is() {
        for degree in [2, 3, 4, 5, 7] {
            for (m, c) in [(0.37, 1e-6), (0.37, 0.01), (0.5, 0.0), (0.5, 0.1), (0.913, 1e-3), (0.05, 0.3)] {
                let b = 4.0;
                let space = Space::clamped(degree, &[0.0, 1.0]).unwrap();
                let [x, squares] = [1, 2].map(|a| power(&space, a));
                let flat: Vec<Point> = x.iter().map(|x| Point::new(*x, 0.0, 0.0)).collect();
                let fold = x.iter().zip(&squares);
                let fold: Vec<Point> =
                    fold.map(|(x, xx)| Point::new(0.5 * b * (xx - 2.0 * m * x), c * x, 0.0)).collect();
                let squared = b * b * ((1.0 - m).powi(3) + m.powi(3)) / 3.0 + c * c;
                let primitive = |x: f64| {
                    let bent = if c > 0.0 { c * c / b * (b * x / c).asinh() } else { 0.0 };
                    0.5 * (x * (b * x).hypot(c) + bent)
                };
                let wanted = 15.0 * (squared - 2.0 * (primitive(1.0 - m) - primitive(-m)) + 1.0);
                let material = Material { stiffness: 30.0, shear: 0.0, ..Material::default() };
                let curve = Curve::new(space.clone(), fold.clone()).unwrap();
                let found = stretching(&curve, &flat, &material).unwrap();
                assert!((found / wanted - 1.0).abs() < 1e-4, "{degree} {m} {c}: {found} {wanted}");
                let wide = |points: &[Point]| -> Vec<Point> {
                    points.iter().flat_map(|p| [*p, p + Vector::z()]).collect()
                };
                let across = Space::clamped_uniform(1, 2).unwrap();
                let sheet = Surface::new(space, across, wide(&fold)).unwrap();
                let found = stretching(&sheet, &wide(&flat), &material).unwrap();
                assert!((found / wanted - 1.0).abs() < 1e-2, "{degree} {m} {c}: {found} {wanted}");
            }
        }
    }

    /// With `2p - 1` points a span that is free, what is as long as at rest at all of them is so everywhere: a fold that the few points take for nothing (`|P'| = 1` at both of
    /// degree 2) is seen.
    #[test]
    fn no_fold_of_one_span_costs_nothing() {
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let [x, squares] = [1, 2].map(|a| power(&space, a));
        let flat = Curve::new(space.clone(), x.iter().map(|x| Point::new(*x, 0.0, 0.0)).collect()).unwrap();
        // `P' = √3 (2t - 1)`.
        let fold: Vec<Point> =
            x.iter().zip(&squares).map(|(x, xx)| Point::new(3.0_f64.sqrt() * (xx - x), 0.0, 0.0)).collect();
        let material = Material { stiffness: 30.0, ..Material::default() };
        let mut elastic = Elastic::new(&flat, &material, 0).unwrap();
        let whole = 15.0 * (2.0 - 3.0_f64.sqrt());
        assert!(elastic.energy(&fold).0 > whole, "{}", elastic.energy(&fold).0);
        elastic.see(crate::points::Rule::Few);
        assert!(elastic.energy(&fold).0 < 1e-12 && elastic.misses(&fold, 0.01, 1e-3));
        assert!(!elastic.misses(flat.points(), 0.01, 1e-3));
    }
}
