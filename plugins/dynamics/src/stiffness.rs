//! How elastic forces change with the vertices: the tangent stiffness `K = ∂²E/∂q²`.
//!
//! At a Gauss point a direction with tangent `P' = |P'| t` and strain `ε` has the block `k/ℓ² (t tᵀ + (1 - ℓ/|P'|)(I - t tᵀ))`, of which the second
//! part pushes where it is compressed; shear `γ` has its own `k_s (∇γ ∇γᵀ + γ ∇²γ)`. What is convex alone is without what pushes and without
//! `γ ∇²γ`.

use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix3;

use crate::elastic::{Elastic, sum};

/// Which part of the stiffness is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// The second derivatives of the energy as they are: indefinite where something is compressed.
    Whole,
    /// A positive semidefinite part of them: what is slack does not push.
    Convex,
    /// The same, but that what is slack counts as if it pulled: steps across it are no longer than what it does by itself can change.
    Absolute,
}

/// Where the matrix of a cell is put together; kept from one time to the next.
#[derive(Debug, Default)]
pub(crate) struct Room(Vec<Matrix3<f64>>);

impl Elastic {
    /// Adds `factor` times the matrix by which forces change with vertices, and `rate` times that by which they change with velocities; entry by
    /// entry of the lower triangle, by coordinates. `O(w²)` for each Gauss point of a cell of `w` vertices. Nothing is allocated where the `room` was used before.
    pub(crate) fn add_stiffness(
        &self,
        q: &[Point],
        part: Part,
        factor: f64,
        rate: f64,
        room: &mut Room,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let Room(local) = room;
        for cell in &self.points.cells {
            let vertices = self.points.of(cell);
            let width = cell.width;
            local.clear();
            local.resize(width * width, Matrix3::zeros());
            for point in 0..cell.count {
                let rest = &self.points.rest[cell.first + point];
                let directions = self.points.directions;
                let size = if directions == 1 { 1.0 } else { rest.size };
                let mut blocks = [[Matrix3::<f64>::zeros(); 2]; 2];
                let mut tangents = [Vector::zeros(); 2];
                for k in 0..directions {
                    tangents[k] = sum(self.points.row(cell, point, k), vertices, q);
                    let speed = tangents[k].norm();
                    // Of a curve ∂²/∂P'² of ½ k ε² ℓ; of a surface of ½ k ε² dA.
                    let unit = if directions == 1 { rest.speed[0] } else { rest.speed[k] * rest.speed[k] };
                    let axial = rest.weight * size * (factor * self.stiffness + rate * self.viscosity) / unit;
                    if !self.pushes && speed <= rest.speed[k] {
                        continue;
                    }
                    if speed > 0.0 {
                        let t = tangents[k] / speed;
                        let along = t * t.transpose();
                        let excess = speed - rest.speed[k];
                        let excess = match part {
                            Part::Convex => excess.max(0.0),
                            Part::Absolute => excess.abs(),
                            Part::Whole => excess,
                        };
                        let across = rest.weight * size * factor * self.stiffness / unit * (excess / speed);
                        blocks[k][k] = along * axial + (Matrix3::identity() - along) * across;
                    } else {
                        blocks[k][k] = Matrix3::identity() * axial;
                    }
                }
                if directions == 2 {
                    let lengths = rest.speed[0] * rest.speed[1];
                    let scale = factor * rest.weight * size * self.shear / (lengths * lengths);
                    let w = [tangents[1], tangents[0]];
                    for a in 0..2 {
                        for b in 0..2 {
                            blocks[a][b] += w[a] * w[b].transpose() * scale;
                        }
                    }
                    if part == Part::Whole {
                        let shear = tangents[0].dot(&tangents[1]) - rest.cosine * lengths;
                        let couple = Matrix3::identity() * (scale * shear);
                        blocks[0][1] += couple;
                        blocks[1][0] += couple;
                    }
                }
                self.add_products(self.points.rows_of(cell, point), &blocks, local);
            }
            for (i, &row) in vertices.iter().enumerate() {
                for (j, &column) in vertices[..=i].iter().enumerate() {
                    let block = &local[i * width + j];
                    for a in 0..3 {
                        for b in 0..if i == j { a + 1 } else { 3 } {
                            let (r, c) = (3 * row as usize + a, 3 * column as usize + b);
                            add(r.max(c), r.min(c), block[(a, b)]);
                        }
                    }
                }
            }
        }
        if let Some(bend) = &self.bend {
            for i in 0..q.len() {
                for (j, value) in bend.row(i).filter(|(j, _)| *j <= i) {
                    (0..3).for_each(|axis| add(3 * i + axis, 3 * j + axis, factor * value));
                }
            }
        }
    }

    /// `Σ c_ai B_ab c_bj` of a point's rows `c`, added to the blocks `(i, j ≤ i)` of its cell.
    fn add_products(&self, rows: &[f64], blocks: &[[Matrix3<f64>; 2]; 2], local: &mut [Matrix3<f64>]) {
        if self.points.directions == 1 {
            let width = rows.len();
            for (i, a) in rows.iter().enumerate() {
                let block = blocks[0][0] * *a;
                for (local, b) in local[i * width..].iter_mut().zip(&rows[..=i]) {
                    *local += block * *b;
                }
            }
            return;
        }
        let (u, v) = rows.split_at(rows.len() / 2);
        let width = u.len();
        for i in 0..width {
            let [by_u, by_v] = [0, 1].map(|b| blocks[0][b] * u[i] + blocks[1][b] * v[i]);
            for ((local, u), v) in local[i * width..].iter_mut().zip(&u[..=i]).zip(&v[..=i]) {
                *local += by_u * *u + by_v * *v;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "what makes the shapes of the tests cannot fail")]

    use loftsman_kernel::spline::{Curve, Space, Surface};

    use super::*;
    use crate::body::Material;

    fn shaken(count: usize) -> Vec<Point> {
        let at = |k: usize| (k as f64 * 1.7).sin();
        (0..count).map(|k| Point::new(0.6 * at(k), 0.5 * at(3 * k + 1), 0.4 * at(7 * k + 2))).collect()
    }

    /// The whole stiffness is how forces change, by central differences; its convex part has no negative eigenvalue and is the whole where
    /// all is stretched and nothing sheared.
    #[test]
    fn the_stiffness_is_how_forces_change() {
        let material = Material { stiffness: 30.0, shear: 11.0, bending: 1e-3, ..Material::default() };
        let (u, v) = (Space::clamped_uniform(3, 5).unwrap(), Space::periodic_uniform(2, 4).unwrap());
        let points = (0..20).map(|k| {
            let turn = (k % 4) as f64 * std::f64::consts::FRAC_PI_2;
            Point::new((k / 4) as f64, turn.cos(), turn.sin())
        });
        let sheet = Surface::new(u, v, points.collect()).unwrap();
        let rope = Curve::new(Space::clamped_uniform(4, 9).unwrap(), shaken(9)).unwrap();
        for shape in [&sheet as &dyn loftsman_kernel::shape::Shape, &rope] {
            let elastic = Elastic::new(shape, &material, 0).unwrap();
            let n = shape.control_vertices().len();
            let q: Vec<Point> = shape
                .control_vertices()
                .iter()
                .zip(shaken(n))
                .map(|(p, s)| p * 0.6 + s.coords * 0.1)
                .collect();
            let matrix = |part: Part| {
                let mut k = nalgebra::DMatrix::<f64>::zeros(3 * n, 3 * n);
                elastic.add_stiffness(&q, part, 1.0, 0.0, &mut Room::default(), |i, j, value| {
                    k[(i, j)] += value;
                    if i != j {
                        k[(j, i)] += value;
                    }
                });
                k
            };
            let whole = matrix(Part::Whole);
            let forces = |column: usize, by: f64| {
                let mut moved = q.clone();
                moved[column / 3][column % 3] += by;
                let mut out = vec![0.0; 3 * n];
                elastic.add_forces(&moved, &vec![Point::origin(); n], &mut out);
                out
            };
            let size = whole.amax();
            for column in 0..3 * n {
                let (ahead, behind) = (forces(column, 1e-6), forces(column, -1e-6));
                for row in 0..3 * n {
                    let change = (behind[row] - ahead[row]) / 2e-6;
                    assert!((change - whole[(row, column)]).abs() < 1e-7 * size, "{row} {column}");
                }
            }
            let least = matrix(Part::Convex).symmetric_eigenvalues().min();
            assert!(least > -1e-12 * size, "{least}");
            let least = whole.symmetric_eigenvalues().min();
            assert!(least < -1e-3 * size, "{least} {size}");
        }
    }
}
