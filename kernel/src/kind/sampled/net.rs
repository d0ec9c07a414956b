//! A shape of two parameters as triangles between the lines of a grid.

use super::{HALVED, HALVED_FOR_ANGLE, MOST, Sampler, leaps};
use crate::error::Result;
use crate::kind::facets::{Drawn, Faceted, normals};
use crate::mesh::distance::{from_segment, from_triangle};
use crate::mesh::{Layer, Mesh};
use crate::shape::Location;
use crate::{Error, Point};

/// Points of a side that are nearer than this, relative to their coordinates, are one: rounding.
const SAME: f64 = 1e-13;

/// A piece of a direction: where it begins, and how often it came of halving.
#[derive(Clone, Copy)]
struct Piece {
    from: f64,
    halved: u32,
    /// Whether it is to be halved, as far as was seen in this round.
    split: bool,
    /// Whether this is its first round.
    is_new: bool,
}

/// The pieces of a direction, and where the last one ends (at 1).
struct Pieces(Vec<Piece>);

impl Pieces {
    fn new(count: usize) -> Self {
        let piece = |i: usize| Piece { from: i as f64 / count as f64, halved: 0, split: false, is_new: true };
        Self((0..count).map(piece).collect())
    }

    fn end(&self, i: usize) -> f64 {
        self.0.get(i + 1).map_or(1.0, |next| next.from)
    }

    /// The place at quarter `k` of piece `i`.
    fn quarter(&self, i: usize, k: usize) -> f64 {
        if k == 4 { self.end(i) } else { self.0[i].from + (self.end(i) - self.0[i].from) * k as f64 / 4.0 }
    }

    /// Marks a piece to be halved, for the sake of the angle or of the chord.
    fn mark(&mut self, i: usize, for_angle: bool) {
        let piece = &mut self.0[i];
        piece.split |= !for_angle || piece.halved < HALVED_FOR_ANGLE;
    }

    /// Halves what is marked; whether anything was, or where a piece was halved too often.
    fn halve(&mut self) -> std::result::Result<bool, f64> {
        let mut halved = Vec::with_capacity(self.0.len());
        let mut any = false;
        for (i, piece) in self.0.iter().enumerate() {
            if !piece.split {
                halved.push(Piece { is_new: false, ..*piece });
                continue;
            }
            if piece.halved >= HALVED {
                return Err(piece.from);
            }
            any = true;
            let half = Piece { halved: piece.halved + 1, split: false, is_new: true, ..*piece };
            halved.push(half);
            halved.push(Piece { from: 0.5 * (piece.from + self.end(i)), ..half });
        }
        self.0 = halved;
        Ok(any)
    }
}

/// The triangles: two in each cell of a grid whose lines are halved until all cells are near enough.
pub(super) fn sampled(sampler: &Sampler<'_>) -> Result<Faceted> {
    let (mut us, mut vs) = (Pieces::new(sampler.start), Pieces::new(sampler.start));
    let mut error = 0.0_f64;
    loop {
        let cells = us.0.len().saturating_mul(vs.0.len());
        let mut excess = 1.0_f64;
        for i in 0..us.0.len() {
            for j in 0..vs.0.len() {
                // What was near enough still is: both pieces are as they were.
                if !(us.0[i].is_new || vs.0[j].is_new) {
                    continue;
                }
                for (state, chord) in sampler.chords.iter().enumerate() {
                    let apart = look(sampler, state, (&mut us, i), (&mut vs, j))?;
                    if apart <= *chord {
                        error = error.max(apart);
                    }
                    excess = excess.max(apart / chord);
                }
            }
        }
        let halved_u = us.halve().map_err(|u| sampler.gap(0, u))?;
        if !(vs.halve().map_err(|v| sampler.gap(1, v))? || halved_u) {
            break;
        }
        // With each halving the distance is a quarter: what needs many times too many is told before it is tried.
        let needed = (cells as f64 * excess / 128.0).max((us.0.len() * vs.0.len()) as f64);
        if needed > MOST as f64 {
            return Err(sampler.too_many());
        }
    }
    mesh(sampler, &us, &vs, error)
}

/// How far a state is from the two triangles of a cell; marks the directions in which that is too much, or it turns.
fn look(
    sampler: &Sampler<'_>,
    state: usize,
    (us, i): (&mut Pieces, usize),
    (vs, j): (&mut Pieces, usize),
) -> Result<f64> {
    let chord = sampler.chords[state];
    let mut at = [[Point::origin(); 5]; 5];
    for (a, row) in at.iter_mut().enumerate() {
        for (b, p) in row.iter_mut().enumerate() {
            *p = sampler.on_net(state, us.quarter(i, a), vs.quarter(j, b))?;
        }
    }
    let (mut far, mut turns) = ([false; 2], [false; 2]);
    for k in 0..5 {
        let lines = [[0, 1, 2, 3, 4].map(|a| at[a][k]), at[k]];
        for (direction, line) in lines.iter().enumerate() {
            far[direction] |= line[1..4].iter().any(|p| from_segment(p, &line[0], &line[4]) > chord);
            far[direction] |= leaps(line, chord);
            turns[direction] |= sampler.turns(&line[0], &line[2], &line[4]);
        }
    }
    let triangles = diagonal([&at[0][0], &at[4][0], &at[4][4], &at[0][4]]);
    let near = |p: &Point| triangles.iter().map(|t| from_triangle(p, t)).fold(f64::INFINITY, f64::min);
    let worst = at.iter().flatten().map(near).fold(0.0, f64::max);
    if worst > chord && far == [false; 2] {
        far = [true; 2];
    }
    for (direction, (pieces, index)) in [(us, i), (vs, j)].into_iter().enumerate() {
        if far[direction] || turns[direction] {
            pieces.mark(index, !far[direction]);
        }
    }
    Ok(worst)
}

/// The two triangles of four corners, cut where the cut is shorter.
fn diagonal([a, b, c, d]: [&Point; 4]) -> [[Point; 3]; 2] {
    if cut_first([a, b, c, d]) { [[*a, *b, *c], [*a, *c, *d]] } else { [[*a, *b, *d], [*b, *c, *d]] }
}

fn cut_first([a, b, c, d]: [&Point; 4]) -> bool {
    (c - a).norm() <= (d - b).norm()
}

fn mesh(sampler: &Sampler<'_>, us: &Pieces, vs: &Pieces, error: f64) -> Result<Faceted> {
    let wraps = [0, 1].map(|direction| sampler.domain[direction].periodic);
    let (rows, columns) = (us.0.len(), vs.0.len());
    // Lines of the grid, that at the end only where it is not the first again.
    let (u_lines, v_lines) = (rows + usize::from(!wraps[0]), columns + usize::from(!wraps[1]));
    let at = |pieces: &Pieces, line: usize| pieces.0.get(line).map_or(1.0, |piece| piece.from);
    let states = (0..sampler.states.len())
        .map(|state| {
            let places = (0..u_lines).flat_map(|i| (0..v_lines).map(move |j| (i, j)));
            places.map(|(i, j)| sampler.on_net(state, at(us, i), at(vs, j))).collect()
        })
        .collect::<Result<Vec<Vec<Point>>>>()?;
    let Some(points) = states.first().cloned() else {
        return Err(Error::Invalid("there is no state of the shape to tessellate".into()));
    };
    let id = |i: usize, j: usize| (i % u_lines) * v_lines + j % v_lines;
    let alike = |a: usize, b: usize| {
        states.iter().all(|points| (points[a] - points[b]).amax() <= SAME * points[a].coords.amax())
    };
    // A side that is one point in all states (a pole) has one point.
    let mut point: Vec<usize> = (0..points.len()).collect();
    let mut merge = |side: Vec<usize>| {
        if side.iter().all(|&k| alike(side[0], k)) {
            side.iter().for_each(|&k| point[k] = side[0]);
        }
    };
    for (wrapped, i) in [(wraps[0], 0), (wraps[0], rows)] {
        if !wrapped {
            merge((0..v_lines).map(|j| id(i, j)).collect());
        }
    }
    for (wrapped, j) in [(wraps[1], 0), (wraps[1], columns)] {
        if !wrapped {
            merge((0..u_lines).map(|i| id(i, j)).collect());
        }
    }
    let mut corners = Vec::with_capacity(6 * rows * columns);
    let mut of_corners = Vec::with_capacity(6 * rows * columns);
    for i in 0..rows {
        for j in 0..columns {
            let cell = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)].map(|k| point[k]);
            let [(u0, u1), (v0, v1)] = [(at(us, i), us.end(i)), (at(vs, j), vs.end(j))];
            let places = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
            let first = cut_first(cell.map(|k| &points[k]));
            let triangles = if first { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
            for triangle in triangles {
                let [a, b, c] = triangle.map(|k| cell[k]);
                if a != b && b != c && c != a {
                    corners.extend([a, b, c].map(|k| k as u32));
                    of_corners.extend(triangle.map(|k: usize| {
                        let (u, v) = places[k];
                        Location::Surface(sampler.parameter(0, u), sampler.parameter(1, v))
                    }));
                }
            }
        }
    }
    if corners.is_empty() {
        return Err(Error::NoExtent("the shape has no triangle of any extent".into()));
    }
    let kept: Vec<usize> = (0..points.len()).filter(|&k| point[k] == k).collect();
    let mut number = vec![0_u32; points.len()];
    (0..).zip(&kept).for_each(|(new, &k)| number[k] = new);
    corners.iter_mut().for_each(|corner| *corner = number[*corner as usize]);
    let chosen = |points: &Vec<Point>| kept.iter().map(|&k| points[k]).collect::<Vec<_>>();
    let (points, states) = (chosen(&points), states.iter().map(chosen).collect());
    let starts = (0..=corners.len()).step_by(3).collect();
    let normals = normals(&points, &corners);
    let mut mesh = Mesh::from_parts(points, corners, starts)?;
    mesh.normals = Layer::per_point(normals);
    if wraps == [false; 2] {
        let place = |&k: &usize| [at(us, k / v_lines), at(vs, k % v_lines)];
        mesh.uvs = Layer::per_point(kept.iter().map(place).collect());
    }
    let place = |&k: &usize| {
        let [u, v] = [at(us, k / v_lines), at(vs, k % v_lines)];
        Location::Surface(sampler.parameter(0, u), sampler.parameter(1, v))
    };
    let places = kept.iter().map(place).collect();
    Ok(Faceted {
        drawn: Drawn::Mesh(mesh),
        states,
        tolerance: sampler.tolerance,
        error,
        certified: false,
        places,
        corners: of_corners,
    })
}
