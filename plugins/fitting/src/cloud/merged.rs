//! Squares with no more rows than they need.

use std::collections::BTreeMap;

use loftsman_kernel::Vector;
use loftsman_kernel::energy::{Block, Squares};
use nalgebra::DMatrix;

/// The same sum of squares, `‖A P - r‖²` for every `P`, of blocks over the same control vertices made one each: of `[A r]` the triangle
/// `R` of `QR` is left, which has the same sums and no more rows than columns. A limit surface has some hundred blocks round an
/// extraordinary vertex that are over the same few control vertices, and each block some dozen rows more than vertices.
///
/// What overflows stays as it is. Cost: `m w²` for `m` rows over `w` vertices.
pub(super) fn merged(squares: Squares, count: usize) -> Squares {
    let mut alike: BTreeMap<&[u32], Vec<Block<'_>>> = BTreeMap::new();
    for block in squares.blocks() {
        alike.entry(block.vertices).or_default().push(block);
    }
    let mut all = Squares::default();
    for (vertices, blocks) in alike {
        let width = vertices.len();
        let targets = || blocks.iter().flat_map(|block| block.targets);
        // Columns of targets are there where they are needed.
        let sides = if targets().any(|r| *r != Vector::zeros()) { 3 } else { 0 };
        let coefficients = blocks.iter().flat_map(|block| block.rows.chunks_exact(width.max(1)));
        let rows: Vec<(&[f64], &Vector)> = coefficients.zip(targets()).collect();
        let entry = |i: usize, j: usize| if j < width { rows[i].0[j] } else { rows[i].1[j - width] };
        let whole = DMatrix::from_fn(rows.len(), width + sides, entry);
        let left = if rows.len() > width + sides { whole.qr().r() } else { whole };
        all.open(vertices.iter().map(|&v| v as usize));
        for row in left.row_iter() {
            let target =
                if sides == 3 { Vector::from_fn(|axis, _| row[width + axis]) } else { Vector::zeros() };
            all.row(row.iter().take(width).copied(), target);
        }
    }
    if squares.order() > 0 {
        all.differentiate(squares.order());
    }
    if all.check(count).is_ok() { all } else { squares }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_stay_and_rows_go() {
        let mut squares = Squares::default();
        let number = |k: usize| ((k * 7919 + 13) % 101) as f64 / 50.0 - 1.0;
        for block in 0..6 {
            squares.open(if block % 2 == 0 { vec![0, 2, 3] } else { vec![1, 2] });
            let width = squares.width();
            for row in 0..5 {
                let at = 100 * block + 10 * row;
                squares.row(
                    (0..width).map(|k| number(at + k)),
                    Vector::from_fn(|axis, _| number(at + 7 + axis)),
                );
            }
        }
        squares.differentiate(2);
        let small = merged(squares.clone(), 4);
        let rows = |s: &Squares| s.blocks().map(|block| block.targets.len()).sum::<usize>();
        assert_eq!((rows(&squares), rows(&small), small.order()), (30, 3 + 3 + 2 + 3, 2));
        for k in 0..20 {
            let x: Vec<Vector> =
                (0..4).map(|v| Vector::from_fn(|axis, _| number(31 * k + 3 * v + axis))).collect();
            assert!((squares.energy(&x).0 - small.energy(&x).0).abs() < 1e-12);
            for targets in [false, true] {
                let [mut a, mut b] = [vec![Vector::zeros(); 4], vec![Vector::zeros(); 4]];
                squares.gradient(&x, targets, &mut a);
                small.gradient(&x, targets, &mut b);
                assert!(a.iter().zip(&b).all(|(a, b)| (a - b).norm() < 1e-12));
            }
        }
    }
}
