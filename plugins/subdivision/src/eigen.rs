//! Left eigenvectors of the matrices by which subdivision goes on at a point.

/// A matrix by its rows.
pub(crate) type Matrix = Vec<Vec<(u32, f64)>>;

/// Multiplications after which a vertex is said to come to no point, or to have no tangent plane.
pub(crate) const MOST: usize = 20_000;
/// What changes by no more than this is looked on as found, and multiplied as often again: the error is then its square.
const NEARLY: f64 = 4e-15;
/// The part of a second tangent beside the first below which there is none but by rounding.
pub(crate) const PLANE: f64 = 1e-12;

/// A row times a matrix.
pub(crate) fn times(row: &[f64], matrix: &Matrix) -> Vec<f64> {
    let mut product = vec![0.0; row.len()];
    for (weight, of) in row.iter().zip(matrix) {
        of.iter().for_each(|&(k, c)| product[k as usize] += weight * c);
    }
    product
}

/// The row of the limit: what `e M^k` comes to for the row `e` of the first vertex.
pub(crate) fn position(matrix: &Matrix) -> Option<Vec<f64>> {
    let mut row = vec![0.0; matrix.len()];
    row[0] = 1.0;
    let mut found = None;
    for step in 0..MOST {
        let mut next = times(&row, matrix);
        let total: f64 = next.iter().sum();
        next.iter_mut().for_each(|c| *c /= total);
        let change = row.iter().zip(&next).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
        row = next;
        if found.is_none() && change <= NEARLY {
            found = Some(2 * step);
        }
        if found.is_some_and(|last| step >= last) {
            return Some(row);
        }
    }
    None
}

/// A plane that stays under multiplication.
#[derive(Debug)]
pub(crate) struct Plane {
    /// Two orthonormal rows, which measure coordinates in it.
    pub(crate) rows: [Vec<f64>; 2],
    /// Places whose coordinates these are, for each of what is multiplied: but for what vanishes faster, it is `position + places · rows`.
    pub(crate) places: [Vec<f64>; 2],
}

/// Two orthonormal rows whose plane stays under multiplication, found from a plane to start from: that of the two largest eigenvalues
/// below one. `area` is what the points of the limit enclose in coordinates that are given for each, counterclockwise positive; by it
/// the second row is to the left of the first.
pub(crate) fn invariant(
    matrix: &Matrix,
    position: &[f64],
    start: [Vec<f64>; 2],
    area: impl Fn(&[Vec<f64>; 2]) -> f64,
) -> Option<[Vec<f64>; 2]> {
    plane(matrix, position, start, area).map(|plane| plane.rows)
}

/// The same, with the places that these rows measure.
pub(crate) fn plane(
    matrix: &Matrix,
    position: &[f64],
    start: [Vec<f64>; 2],
    area: impl Fn(&[Vec<f64>; 2]) -> f64,
) -> Option<Plane> {
    let mut rows = settle(start, |row| without(times(row, matrix), position))?;
    let columns = settle(rows.clone(), |column| {
        let image = matrix.iter().map(|row| row.iter().map(|&(k, c)| c * column[k as usize]).sum());
        let image: Vec<f64> = image.collect();
        let mean: f64 = image.iter().zip(position).map(|(a, b)| a * b).sum();
        image.iter().map(|c| c - mean).collect()
    })?;
    // Coordinates that the rows measure are the columns times the inverse of this, whose determinant turns the area.
    let by = |a: usize, b: usize| dot(&rows[a], &columns[b]);
    let determinant = by(0, 0) * by(1, 1) - by(0, 1) * by(1, 0);
    let turned = area(&columns) * determinant;
    if turned == 0.0 || !turned.is_finite() {
        return None;
    }
    let inverse = [[by(1, 1), -by(0, 1)], [-by(1, 0), by(0, 0)]].map(|row| row.map(|c| c / determinant));
    let place = |k: usize| {
        let each = columns[0].iter().zip(&columns[1]);
        each.map(|(a, b)| a * inverse[0][k] + b * inverse[1][k]).collect::<Vec<f64>>()
    };
    let mut places = [place(0), place(1)];
    if turned < 0.0 {
        for row in [&mut rows[1], &mut places[1]] {
            row.iter_mut().for_each(|c| *c = -*c);
        }
    }
    Some(Plane { rows, places })
}

/// Multiplies a plane until it stays.
fn settle(mut plane: [Vec<f64>; 2], image: impl Fn(&[f64]) -> Vec<f64>) -> Option<[Vec<f64>; 2]> {
    orthonormalise(&mut plane).then_some(())?;
    let mut found = None;
    for step in 0..MOST {
        let mut next = [image(&plane[0]), image(&plane[1])];
        orthonormalise(&mut next).then_some(())?;
        let change = next.iter().fold(0.0, |most: f64, row| {
            let (a, b) = (dot(row, &plane[0]), dot(row, &plane[1]));
            let off = |k: usize| (row[k] - a * plane[0][k] - b * plane[1][k]).abs();
            (0..row.len()).map(off).fold(most, f64::max)
        });
        plane = next;
        if found.is_none() && change <= NEARLY {
            found = Some(2 * step);
        }
        if found.is_some_and(|last| step >= last) {
            return Some(plane);
        }
    }
    None
}

/// What of a row sums to zero.
pub(crate) fn without(mut row: Vec<f64>, constant: &[f64]) -> Vec<f64> {
    let total: f64 = row.iter().sum();
    row.iter_mut().zip(constant).for_each(|(c, p)| *c -= total * p);
    row
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Makes it a unit vector; what was its length.
pub(crate) fn normalise(row: &mut [f64]) -> f64 {
    let size = row.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    if size > 0.0 {
        row.iter_mut().for_each(|c| *c /= size);
        let length = dot(row, row).sqrt();
        row.iter_mut().for_each(|c| *c /= length);
        return size * length;
    }
    0.0
}

/// Makes two rows orthonormal without turning them over; false where they are one direction but for rounding.
pub(crate) fn orthonormalise([a, b]: &mut [Vec<f64>; 2]) -> bool {
    if normalise(a) == 0.0 || normalise(b) == 0.0 {
        return false;
    }
    let along = dot(a, b);
    b.iter_mut().zip(a.iter()).for_each(|(b, a)| *b -= along * a);
    if normalise(b) <= PLANE {
        return false;
    }
    // Once more, for what rounding left of the first.
    let along = dot(a, b);
    b.iter_mut().zip(a.iter()).for_each(|(b, a)| *b -= along * a);
    normalise(b) > 0.0
}
