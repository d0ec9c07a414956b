//! What stretches, shears and bends: energies and their forces.
//!
//! Of a curve `½ ∫ k ε² ℓ du`, `ε = |P'|/ℓ - 1`, `ℓ` being the speed at rest; of a surface `½ ∫ k ε² dA` in each of its directions, and
//! `½ ∫ k_s γ² dA` of the shear `γ = P_u·P_v/(ℓ_u ℓ_v) - cos θ`, `dA` being the area at rest. So what rests at `r` times its lengths is what was
//! made `r` times as large, curve or surface: a strip of a width of 1 at rest pulls as the rope of its stiffness. Bending is `½ B ∫ |P_ss|² ds` by
//! arc length at rest: quadratic, so that its matrix is made once; of a surface the thin plate's, by the lengths of its two directions.

use loftsman_kernel::shape::{Derivative, Shape, cells_of, rows_at};
use loftsman_kernel::solve::Symmetric;
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use crate::body::Material;
use crate::error::Result;
use crate::points::{CellPoints, Points, Rule, order};

/// The elasticity of one body.
#[derive(Debug, Clone)]
pub(crate) struct Elastic {
    /// Where energy is summed up now.
    pub(crate) points: Points,
    /// Of what needs more points than are enough where it bends within its spans: those by the other rule.
    other: Option<Points>,
    rule: Rule,
    /// The bending's matrix, where it bends.
    pub(crate) bend: Option<Symmetric>,
    /// As it counts now; and as it is, which it counts as but where rest is looked for from afar.
    pub(crate) stiffness: f64,
    pub(crate) given: f64,
    pub(crate) shear: f64,
    pub(crate) viscosity: f64,
    /// Whether what is slack pushes; not while rest is looked for from afar, where nothing bends.
    pub(crate) pushes: bool,
}

type Local = SmallVec<[Vector; 16]>;

impl Elastic {
    pub(crate) fn new(shape: &dyn Shape, material: &Material, kept: usize) -> Result<Self> {
        let few = Points::new(shape, material, kept, Rule::Few)?;
        let full = Points::new(shape, material, kept, Rule::Full)?;
        let other = (full.rest.len() > few.rest.len()).then_some(few);
        let bend = if material.bending > 0.0 { Some(bending(shape, material)?) } else { None };
        let Material { stiffness, shear, viscosity, .. } = *material;
        Ok(Self {
            points: full,
            other,
            rule: Rule::Full,
            bend,
            stiffness,
            given: stiffness,
            shear,
            viscosity,
            pushes: true,
        })
    }

    /// Sums up by this rule from now on.
    pub(crate) fn see(&mut self, rule: Rule) {
        if let Some(other) = self.other.as_mut().filter(|_| self.rule != rule) {
            std::mem::swap(&mut self.points, other);
        }
        self.rule = rule;
    }

    pub(crate) fn rule(&self) -> Rule {
        self.rule
    }

    /// Whether the other rule sees more of stretching than this one, by more than a share of what this one does and than a stretch by that on average.
    pub(crate) fn misses(&self, q: &[Point], share: f64, strain: f64) -> bool {
        let Some(other) = &self.other else { return false };
        let (seen, all) = (self.stretching(&self.points, q).0, self.stretching(other, q).0);
        all - seen > share * seen + 0.5 * self.given * self.size() * strain * strain
    }

    /// Its length or area at rest.
    pub(crate) fn size(&self) -> f64 {
        self.points.rest.iter().map(|rest| rest.weight * rest.size).sum()
    }

    /// Adds the forces on the control vertices, three numbers each. Gives the least `|P'|/ℓ`.
    pub(crate) fn add_forces(&self, q: &[Point], v: &[Point], out: &mut [f64]) -> f64 {
        let mut forces = Local::new();
        let mut slackest = f64::INFINITY;
        for cell in &self.points.cells {
            forces.clear();
            forces.resize(cell.width, Vector::zeros());
            if self.points.directions == 1 {
                slackest = slackest.min(self.pull_curve(cell, q, v, &mut forces));
            } else {
                slackest = slackest.min(self.pull_surface(cell, q, v, &mut forces));
            }
            for (&vertex, force) in self.points.of(cell).iter().zip(&forces) {
                let out = &mut out[3 * vertex as usize..][..3];
                out.iter_mut().zip(force.iter()).for_each(|(out, f)| *out += f);
            }
        }
        if let Some(bend) = &self.bend {
            for i in 0..q.len() {
                // Of differences, for its rows sum to nothing: far from the origin coordinates would round away what bends.
                let sum = bend.row(i).fold(Vector::zeros(), |sum, (j, c)| sum + (q[j] - q[i]) * c);
                (0..3).for_each(|axis| out[3 * i + axis] -= sum[axis]);
            }
        }
        slackest
    }

    /// Adds how much forces may differ for the rounding of vertices, one number each: `u Σ_j |K_ij| (|q_j| + |q_i|)`, `u` being the unit roundoff and `K` their
    /// stiffness along, by the largest coordinates of each cell.
    pub(crate) fn add_rounding(&self, q: &[Point], out: &mut [f64]) {
        for cell in &self.points.cells {
            let vertices = self.points.of(cell);
            let far = vertices.iter().fold(0.0_f64, |most, &v| most.max(q[v as usize].coords.amax()));
            for point in 0..cell.count {
                let rest = &self.points.rest[cell.first + point];
                for k in 0..self.points.directions {
                    let row = self.points.row(cell, point, k);
                    let size = if self.points.directions == 1 { rest.speed[0] } else { rest.size };
                    let unit = rest.weight * size * self.stiffness / (rest.speed[k] * rest.speed[k]);
                    let whole: f64 = row.iter().map(|c| c.abs()).sum();
                    for (&vertex, c) in vertices.iter().zip(row) {
                        out[vertex as usize] += f64::EPSILON * unit * c.abs() * whole * far;
                    }
                }
            }
        }
        if let Some(bend) = &self.bend {
            for (i, out) in out.iter_mut().enumerate() {
                let own = q[i].coords.amax();
                *out += f64::EPSILON
                    * bend.row(i).map(|(j, c)| c.abs() * (q[j].coords.amax() + own)).sum::<f64>();
            }
        }
    }

    /// A strain as it counts.
    pub(crate) fn felt(&self, strain: f64) -> f64 {
        if self.pushes { strain } else { strain.max(0.0) }
    }

    fn pull_curve(&self, cell: &CellPoints, q: &[Point], v: &[Point], forces: &mut [Vector]) -> f64 {
        let mut slackest = f64::INFINITY;
        let vertices = self.points.of(cell);
        for point in 0..cell.count {
            let rest = &self.points.rest[cell.first + point];
            let row = self.points.row(cell, point, 0);
            let tangent = sum(row, vertices, q);
            let speed = tangent.norm();
            slackest = slackest.min(speed / rest.speed[0]);
            if speed > 0.0 {
                let mut tension = self.stiffness * self.felt(speed / rest.speed[0] - 1.0);
                if self.viscosity > 0.0 {
                    tension += self.viscosity * tangent.dot(&sum(row, vertices, v)) / (speed * rest.speed[0]);
                }
                let pull = tangent * (-rest.weight * tension / speed);
                forces.iter_mut().zip(row).for_each(|(force, c)| *force += pull * *c);
            }
        }
        slackest
    }

    fn pull_surface(&self, cell: &CellPoints, q: &[Point], v: &[Point], forces: &mut [Vector]) -> f64 {
        let mut slackest = f64::INFINITY;
        let vertices = self.points.of(cell);
        for point in 0..cell.count {
            let rest = &self.points.rest[cell.first + point];
            let rows = [0, 1].map(|k| self.points.row(cell, point, k));
            let tangents = rows.map(|row| sum(row, vertices, q));
            let weight = rest.weight * rest.size;
            let mut pulls = [Vector::zeros(); 2];
            for k in 0..2 {
                let speed = tangents[k].norm();
                slackest = slackest.min(speed / rest.speed[k]);
                if speed > 0.0 {
                    let mut tension = self.stiffness * self.felt(speed / rest.speed[k] - 1.0);
                    if self.viscosity > 0.0 {
                        let rate = tangents[k].dot(&sum(rows[k], vertices, v)) / (speed * rest.speed[k]);
                        tension += self.viscosity * rate;
                    }
                    pulls[k] = tangents[k] * (weight * tension / (speed * rest.speed[k]));
                }
            }
            let lengths = rest.speed[0] * rest.speed[1];
            let shear = tangents[0].dot(&tangents[1]) / lengths - rest.cosine;
            let couple = weight * self.shear * shear / lengths;
            pulls[0] += tangents[1] * couple;
            pulls[1] += tangents[0] * couple;
            for (i, force) in forces.iter_mut().enumerate() {
                *force -= pulls[0] * rows[0][i] + pulls[1] * rows[1][i];
            }
        }
        slackest
    }

    /// The energy that is in it, and the largest stretch `|P'|/ℓ - 1` (by its amount, with its sign).
    pub(crate) fn energy(&self, q: &[Point]) -> (f64, f64) {
        let (mut energy, largest) = self.stretching(&self.points, q);
        if let Some(bend) = &self.bend {
            for (i, p) in q.iter().enumerate() {
                let pull = bend.row(i).fold(Vector::zeros(), |sum, (j, c)| sum + (q[j] - p) * c);
                energy += 0.5 * (p - q[0]).dot(&pull);
            }
        }
        (energy, largest)
    }

    /// The same without bending.
    pub(crate) fn energy_of_stretching(&self, q: &[Point]) -> f64 {
        self.stretching(&self.points, q).0
    }

    fn stretching(&self, points: &Points, q: &[Point]) -> (f64, f64) {
        let (mut energy, mut largest) = (0.0, 0.0_f64);
        for cell in &points.cells {
            let vertices = points.of(cell);
            for point in 0..cell.count {
                let rest = &points.rest[cell.first + point];
                let mut tangents = [Vector::zeros(); 2];
                let size = rest.size;
                for k in 0..points.directions {
                    tangents[k] = sum(points.row(cell, point, k), vertices, q);
                    let strain = tangents[k].norm() / rest.speed[k] - 1.0;
                    energy += 0.5 * rest.weight * size * self.stiffness * self.felt(strain).powi(2);
                    if strain.abs() > largest.abs() {
                        largest = strain;
                    }
                }
                if points.directions == 2 {
                    let shear = tangents[0].dot(&tangents[1]) / (rest.speed[0] * rest.speed[1]) - rest.cosine;
                    energy += 0.5 * rest.weight * size * self.shear * shear * shear;
                }
            }
        }
        (energy, largest)
    }
}

pub(crate) fn sum(row: &[f64], vertices: &[u32], points: &[Point]) -> Vector {
    let mut all = Vector::zeros();
    for (c, &v) in row.iter().zip(vertices) {
        all += points[v as usize].coords * *c;
    }
    all
}

/// The direction in which a shape is a polyline, if there is one: its second derivatives are nothing there, and it folds at its corners for nothing.
pub(crate) fn unbending(shape: &dyn Shape) -> Result<Option<usize>> {
    let cells = cells_of(shape, "bending")?.checked(shape)?;
    let straight =
        |k: &usize| cells.iter().all(|cell| cell.sides.get(*k).is_some_and(|side| side.degree < 2));
    Ok((0..shape.domain().len()).find(straight))
}

/// `B ∫ D Dᵀ`, `D` being second derivatives by length at rest: `(P'' - P' ℓ'/ℓ) / ℓ²` in each direction, and mixed ones twice. With `p` points a span of
/// degree `p`, and `p + 1` in each direction of a surface, whose second derivatives are of full degree across: exact where lengths at rest are alike all over,
/// and the shape is no quotient (four more points then).
fn bending(shape: &dyn Shape, material: &Material) -> Result<Symmetric> {
    let directions = shape.domain().len();
    let vertices = shape.control_vertices();
    let mut entries = Vec::new();
    for cell in cells_of(shape, "bending")?.checked(shape)? {
        let count = |k: usize| {
            let degree = cell.sides.get(k).map_or(0, |side| side.degree);
            degree + (directions - 1) + if cell.rational { 4 } else { 0 }
        };
        let points = cell.gauss_points([count(0).max(1), count(1).max(1)]);
        let width = cell.vertices.len();
        let rows = |derivative: Derivative| rows_at(shape, &cell, &points, derivative);
        let value = |row: &[f64]| {
            row.iter().zip(&cell.vertices).fold(Vector::zeros(), |sum, (c, &v)| sum + vertices[v].coords * *c)
        };
        let first: Vec<Vec<f64>> =
            (0..directions).map(|k| rows(order(k, 1))).collect::<loftsman_kernel::Result<_>>()?;
        let second: Vec<Vec<f64>> =
            (0..directions).map(|k| rows(order(k, 2))).collect::<loftsman_kernel::Result<_>>()?;
        let mixed = if directions == 2 { rows(Derivative { u: 1, v: 1 })? } else { Vec::new() };
        for (index, (_, weight)) in points.iter().enumerate() {
            let part = index * width..(index + 1) * width;
            let tangents: SmallVec<[Vector; 2]> = first.iter().map(|all| value(&all[part.clone()])).collect();
            let speeds: SmallVec<[f64; 2]> = tangents.iter().map(|t| t.norm()).collect();
            let size = if directions == 2 { tangents[0].cross(&tangents[1]).norm() } else { speeds[0] };
            let rest = material.rest;
            // Lengths at rest are all longer by its factor; of a surface so is the width.
            let size = weight * size * rest.powi(directions as i32) * material.bending;
            let mut add = |row: &[f64], factor: f64| {
                for i in 0..width {
                    for j in 0..=i {
                        entries.push((cell.vertices[i], cell.vertices[j], factor * row[i] * row[j]));
                    }
                }
            };
            for k in 0..directions {
                let curve = value(&second[k][part.clone()]);
                let bent = tangents[k].dot(&curve) / (speeds[k] * speeds[k]);
                let scale = 1.0 / (rest * rest * speeds[k] * speeds[k]);
                let row: Vec<f64> = second[k][part.clone()]
                    .iter()
                    .zip(&first[k][part.clone()])
                    .map(|(second, first)| (second - bent * first) * scale)
                    .collect();
                add(&row, size);
            }
            if directions == 2 {
                let scale = 1.0 / (rest * rest * speeds[0] * speeds[1]);
                let row: Vec<f64> = mixed[part].iter().map(|c| c * scale).collect();
                add(&row, 2.0 * size);
            }
        }
    }
    Ok(Symmetric::from_entries(vertices.len(), entries))
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::{Curve, Space, Surface};

    use super::*;

    /// `Σ Π t / C(p, a)` over all choices of `a` of the `p` knots of each vertex: the control numbers of `x^a` (its polar form).
    pub(crate) fn power(space: &Space, a: usize) -> Vec<f64> {
        let p = space.degree();
        (0..space.len())
            .map(|i| {
                // Elementary symmetric sums of the knots, and binomial coefficients as those of ones.
                let (mut sums, mut ones) = (vec![0.0; p + 1], vec![0.0; p + 1]);
                (sums[0], ones[0]) = (1.0, 1.0);
                for &t in &space.knots()[i + 1..=i + p] {
                    for k in (1..=p).rev() {
                        sums[k] += t * sums[k - 1];
                        ones[k] += ones[k - 1];
                    }
                }
                sums[a] / ones[a]
            })
            .collect()
    }

    /// Flat sheets of all degrees, bent to `z = x^a y^b`: the thin plate's `½ B ∫∫ z_xx² + 2 z_xy² + z_yy²`, in closed form.
    #[test]
    fn a_bent_sheet_has_the_energy_of_a_thin_plate() {
        let mut bent = 0;
        for (p, q) in (1..=5).flat_map(|p| (1..=5).map(move |q| (p, q))).chain([(7, 2), (2, 7), (1, 7)]) {
            let spaces =
                [(p, p + 3), (q, q + 1)].map(|(degree, n)| Space::clamped_uniform(degree, n).unwrap());
            let [length, width] = [0, 1].map(|k| spaces[k].domain().1);
            let x = [power(&spaces[0], 1), power(&spaces[1], 1)];
            let sheet: Vec<Point> = x[0].iter().flat_map(|x| x_row(*x, &power(&spaces[1], 1))).collect();
            let surface = Surface::new(spaces[0].clone(), spaces[1].clone(), sheet.clone()).unwrap();
            let material = Material { stiffness: 0.0, shear: 0.0, bending: 0.7, ..Material::default() };
            let elastic = Elastic::new(&surface, &material, 0).unwrap();
            for (a, b) in (0..=p).flat_map(|a| (0..=q).map(move |b| (a, b))) {
                let heights = [power(&spaces[0], a), power(&spaces[1], b)];
                let bowed: Vec<Point> = sheet
                    .iter()
                    .enumerate()
                    .map(|(k, at)| {
                        let n = spaces[1].len();
                        Point::new(at.x, at.y, heights[0][k / n] * heights[1][k % n])
                    })
                    .collect();
                // ∫∫ (c x^i y^j)² of each second derivative.
                let square = |c: usize, i: isize, j: isize| {
                    if c == 0 {
                        return 0.0;
                    }
                    let along =
                        |of: f64, power: isize| of.powi(2 * power as i32 + 1) / (2 * power + 1) as f64;
                    (c * c) as f64 * along(length, i) * along(width, j)
                };
                let (i, j) = (a as isize, b as isize);
                let wanted = 0.35
                    * (square(a * a.saturating_sub(1), i - 2, j)
                        + 2.0 * square(a * b, i - 1, j - 1)
                        + square(b * b.saturating_sub(1), i, j - 2));
                let found = elastic.energy(&bowed).0;
                let what = format!("degrees {p} and {q}, x^{a} y^{b}: {found} for {wanted}");
                assert!((found - wanted).abs() < 1e-9 * wanted.max(1e-3), "{what}");
                bent += usize::from(wanted > 0.0);
            }
        }
        assert!(bent > 200, "{bent}");
    }

    fn x_row(x: f64, y: &[f64]) -> Vec<Point> {
        y.iter().map(|y| Point::new(x, *y, 0.0)).collect()
    }

    /// What rests at `r` times its lengths is what was made `r` times as large: stretched, sheared, bent and pulled alike, curve or surface.
    #[test]
    fn a_factor_of_rest_is_one_of_size() {
        let shaken = |k: usize| (k as f64 * 1.7).sin() * 0.2;
        let space = |degree: usize| Space::clamped_uniform(degree, degree + 3).unwrap();
        let (u, v) = (space(3), space(2));
        let at = |k: usize| Point::new(u.greville(k / 5), 0.7 * v.greville(k % 5), shaken(k));
        let sheet = Surface::new(u.clone(), v.clone(), (0..30).map(at).collect()).unwrap();
        let points = (0..6).map(|k| Point::new(k as f64, shaken(k), shaken(2 * k))).collect();
        let rope = Curve::new(space(3), points).unwrap();
        for shape in [&sheet as &dyn Shape, &rope] {
            for rest in [0.5, 1.0, 2.0] {
                let material =
                    Material { stiffness: 30.0, shear: 11.0, bending: 0.3, rest, ..Material::default() };
                let own = Elastic::new(shape, &material, 0).unwrap();
                let mut larger = shape.boxed();
                larger.control_vertices_mut().iter_mut().for_each(|p| p.coords *= rest);
                let made = Elastic::new(larger.as_ref(), &Material { rest: 1.0, ..material }, 0).unwrap();
                let q: Vec<Point> = shape
                    .control_vertices()
                    .iter()
                    .enumerate()
                    .map(|(k, p)| p * 1.3 + Vector::new(shaken(3 * k), shaken(5 * k), shaken(7 * k)))
                    .collect();
                let (one, other) = (own.energy(&q).0, made.energy(&q).0);
                assert!((one - other).abs() < 1e-12 * other, "{rest}: {one} {other}");
                let forces = [&own, &made].map(|elastic| {
                    let mut out = vec![0.0; 3 * q.len()];
                    elastic.add_forces(&q, &vec![Point::origin(); q.len()], &mut out);
                    out
                });
                for (one, other) in forces[0].iter().zip(&forces[1]) {
                    assert!((one - other).abs() < 1e-11 * material.stiffness, "{rest}: {one} {other}");
                }
            }
        }
    }
}
