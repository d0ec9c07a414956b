//! Doo and Sabin's limit at any binary fraction of a face, by refining by hand what is round one vertex and nothing else.

use loftsman_kernel::Vector;

use super::plain::Plain;

/// A place of the limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    pub(crate) place: Vector,
    /// Derivatives by `u` and `v`; two vectors along the surface where the place is the middle of a face that is no quad.
    pub(crate) along: [Vector; 2],
}

impl Spot {
    pub(crate) fn normal(&self) -> Vector {
        self.along[0].cross(&self.along[1]).normalize()
    }
}

/// The faces round a vertex, all of their vertices, and the numbers of one face and of the vertex among them.
fn round(plain: &Plain, vertex: usize, face: usize) -> (Plain, usize, usize) {
    let own: Vec<usize> = (0..plain.faces.len()).filter(|&f| plain.faces[f].contains(&vertex)).collect();
    let mut kept: Vec<usize> = own.iter().flat_map(|&f| plain.faces[f].clone()).collect();
    kept.sort_unstable();
    kept.dedup();
    let at = |v: &usize| kept.binary_search(v).unwrap();
    let crop = Plain {
        points: kept.iter().map(|&v| plain.points[v]).collect(),
        faces: own.iter().map(|&f| plain.faces[f].iter().map(at).collect()).collect(),
        ..Plain::default()
    };
    (crop, at(&vertex), own.iter().position(|&f| f == face).unwrap())
}

/// The limit at `(u, v)` of the quarter at a corner of a face, which runs from the face's middle, `(0, 0)`, to the limits of the edge before the corner,
/// `(1, 0)`, of that after it, `(0, 1)`, and of the vertex, `(1, 1)`. The middle of each face of each refinement is a place of the limit; the
/// refined mesh has four faces round the corner's own vertex, whose middles are those four places and whose own quarters there are the
/// quarters of this one.
pub(crate) fn spot(plain: &Plain, face: usize, corner: usize, [u, v]: [f64; 2]) -> Spot {
    let corners = &plain.faces[face];
    let n = corners.len();
    if u == 0.0 && v == 0.0 {
        return middle(corners.iter().map(|&v| plain.points[v]).collect(), corner);
    }
    let (crop, _, face) = round(plain, corners[corner], face);
    let fine = crop.dual();
    let own = crop.faces[..face].iter().map(Vec::len).sum::<usize>() + corner;
    // Counterclockwise: the face beyond the edge that comes before the vertex is the next.
    let mut four = [face; 4];
    for k in 1..4 {
        let last = &fine.faces[four[k - 1]];
        let at = last.iter().position(|&v| v == own).unwrap();
        let before = last[(at + last.len() - 1) % last.len()];
        let beyond = |f: &Vec<usize>| (0..f.len()).any(|i| f[i] == own && f[(i + 1) % f.len()] == before);
        four[k] = fine.faces.iter().position(beyond).unwrap();
    }
    let (quarter, inner) = match (u > 0.5, v > 0.5) {
        (false, false) => (0, [2.0 * u, 2.0 * v]),
        (true, false) => (1, [2.0 * v, 2.0 - 2.0 * u]),
        (true, true) => (2, [2.0 - 2.0 * u, 2.0 - 2.0 * v]),
        (false, true) => (3, [2.0 - 2.0 * v, 2.0 * u]),
    };
    let at = fine.faces[four[quarter]].iter().position(|&v| v == own).unwrap();
    debug_assert!(n > 2);
    let Spot { place, along: [a, b] } = spot(&fine, four[quarter], at, inner);
    let along = match quarter {
        0 => [a, b],
        1 => [-b, a],
        2 => [-a, -b],
        _ => [b, -a],
    };
    Spot { place, along: along.map(|x| x * 2.0) }
}

/// The middle of a face, which refinement does not move, with the derivatives there: of a quad those of the biquadratic, of others the first wave
/// round it, the next to stay.
fn middle(points: Vec<Vector>, corner: usize) -> Spot {
    let n = points.len();
    let place = points.iter().sum::<Vector>() / n as f64;
    let at = |k: usize| points[(corner + k) % n];
    if n == 4 {
        let along = [at(0) + at(3) - at(1) - at(2), at(0) + at(1) - at(2) - at(3)];
        return Spot { place, along: along.map(|x| x / 4.0) };
    }
    let wave = |phase: f64| -> Vector {
        (0..n).map(|k| at(k) * (std::f64::consts::TAU * k as f64 / n as f64 + phase).cos()).sum()
    };
    // Towards the edge before the corner and that after it, as far round as these are.
    let half = std::f64::consts::PI / n as f64;
    Spot { place, along: [wave(half), wave(-half)] }
}
