//! Circles along a line: rings of points, their faces, normals and texture coordinates, and the caps at the ends.

use std::f64::consts::{FRAC_PI_2, TAU};

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::{Point, Vector};

use super::frames::{Frames, turned};
use super::line::{Part, State};

/// What closes the ends of an open tube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Caps {
    /// A polygon across.
    Flat,
    /// Half a sphere.
    Round,
    /// Nothing.
    None,
}

/// How far the points of a corner may be from it, in radii: of sharper ones the outer side is cut off.
const MITRE: f64 = 3.0;

/// Corners that turn by more (a cosine) are seen as edges: normals differ on both sides.
const EDGE: f64 = 0.866_025_403_784_438_6;

/// What is swept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Profile {
    pub(super) radius: f64,
    pub(super) sides: usize,
    pub(super) caps: Caps,
    pub(super) uvs: bool,
}

impl Profile {
    /// Rows of points of a round cap between its ring and its tip.
    fn rows(&self) -> usize {
        match self.caps {
            Caps::Round => self.sides.div_ceil(4).max(2) - 1,
            Caps::Flat | Caps::None => 0,
        }
    }

    /// How many points the tube of a part of a line has.
    pub(super) fn points(&self, part: &Part) -> usize {
        let rings = part.states.first().map_or(0, |state| state.points.len());
        let caps =
            if part.closed || self.caps != Caps::Round { 0 } else { 2 * (self.rows() * self.sides + 1) };
        rings.saturating_mul(self.sides).saturating_add(caps)
    }

    /// The cosine and sine of each side's angle.
    fn circle(&self) -> Vec<(f64, f64)> {
        (0..self.sides)
            .map(|j| {
                let (sine, cosine) = (TAU * j as f64 / self.sides as f64).sin_cos();
                (cosine, sine)
            })
            .collect()
    }

    /// The angles above the ring of a round cap's rows, the tip left out.
    fn heights(&self) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator + use<> {
        let rows = self.rows();
        (1..rows + 1).map(move |k| FRAC_PI_2 * k as f64 / (rows + 1) as f64)
    }

    /// The points of a state: of the cap at the start from its ring to its tip, of all rings, of the cap at the end.
    pub(super) fn state(&self, state: &State, frames: &Frames, closed: bool, out: &mut Vec<Point>) {
        let circle = self.circle();
        for i in 0..state.points.len() {
            let ring = Ring::of(state, frames, i);
            out.extend(circle.iter().map(|&way| state.points[i] + ring.out(way) * self.radius));
        }
        if closed || self.caps != Caps::Round {
            return;
        }
        for (i, way) in [(0, -1.0), (state.points.len() - 1, 1.0)] {
            let (t, ring) = (state.leave[i] * way, Ring::of(state, frames, i));
            for height in self.heights() {
                let (up, out_by) = height.sin_cos();
                let at = |&side| state.points[i] + (ring.side(side) * out_by + t * up) * self.radius;
                out.extend(circle.iter().map(at));
            }
            out.push(state.points[i] + t * self.radius);
        }
    }
}

/// The circle at a point of a line.
struct Ring {
    arrive: Vector,
    /// The frame in which the line arrives: a vector across it, and the other.
    first: Vector,
    second: Vector,
    /// At a corner the plane half way, as a vector along the line for each direction across: `λ = -e·b / t·b`.
    corner: Option<Vector>,
    leave: Vector,
}

impl Ring {
    fn of(state: &State, frames: &Frames, i: usize) -> Self {
        let (arrive, leave) = (state.arrive[i], state.leave[i]);
        let first = frames.arriving[i];
        let both = arrive + leave;
        let along = arrive.dot(&both);
        // A line that turns back has no plane half way: its circle stays as it is.
        let corner = (state.turn(i) < 1.0 - 1e-12 && along > 1e-6).then(|| both / along);
        Self { arrive, first, second: arrive.cross(&first), corner, leave }
    }

    /// A direction across the line as it arrives.
    fn side(&self, (cosine, sine): (f64, f64)) -> Vector {
        self.first * cosine + self.second * sine
    }

    /// From the line to the tube, in radii: across, but at corners in the plane half way, where the tubes of both sides meet.
    fn out(&self, way: (f64, f64)) -> Vector {
        let across = self.side(way);
        match &self.corner {
            Some(plane) => across - self.arrive * across.dot(plane).clamp(-MITRE, MITRE),
            None => across,
        }
    }

    /// The normals as the line arrives and as it leaves: one where the corner is no edge.
    fn normals(&self, way: (f64, f64)) -> [Vector; 2] {
        let arriving = self.side(way);
        let leaving = turned(&arriving, &self.arrive, &self.leave);
        let both = (arriving + leaving).try_normalize(1e-6);
        match both {
            Some(both) if self.arrive.dot(&self.leave) > EDGE => [both, both],
            _ => [arriving, leaving],
        }
    }
}

/// The faces of a tube and what belongs to their corners.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    starts: Vec<usize>,
    normals: Vec<Vector>,
    uvs: Vec<[f64; 2]>,
    normal_at: Vec<u32>,
    uv_at: Vec<u32>,
}

impl Faces {
    fn face(&mut self, corners: &[(usize, usize, usize)]) {
        for &(point, normal, uv) in corners {
            self.corners.push(index(point));
            self.normal_at.push(index(normal));
            self.uv_at.push(index(uv));
        }
        self.starts.push(self.corners.len());
    }

    fn normal(&mut self, normal: Vector) -> usize {
        self.normals.push(normal);
        self.normals.len() - 1
    }

    fn uv(&mut self, uv: [f64; 2]) -> usize {
        self.uvs.push(uv);
        self.uvs.len() - 1
    }

    /// `sides + 1` texture coordinates of a row.
    fn row(&mut self, sides: usize, v: f64) -> usize {
        let first = self.uvs.len();
        self.uvs.extend((0..=sides).map(|j| [j as f64 / sides as f64, v]));
        first
    }
}

/// As an index of a mesh; what does not fit is refused before, by its number.
fn index(i: usize) -> u32 {
    u32::try_from(i).unwrap_or(u32::MAX)
}

/// The mesh of a tube: its parts in their first state, each with its frames, and `points` as
/// [`Profile::state`] gives them, one part after the other.
///
/// Faces look outward. Texture coordinates run round in `u` and along the arc length of the profile in `v`, each from 0 to 1;
/// a flat cap has the disc of its polygon.
pub(super) fn mesh(parts: &[(&Part, &Frames)], profile: &Profile, points: Vec<Point>) -> Result<Mesh> {
    let mut faces = Faces { starts: vec![0], ..Faces::default() };
    let mut base = 0;
    for (part, frames) in parts {
        tube(part, frames, profile, base, &mut faces);
        base += profile.points(part);
    }
    let missing = || Error::Invalid("the tube of a line without states".into());
    if points.len() != base {
        return Err(missing());
    }
    let Faces { corners, starts, normals, uvs, normal_at, uv_at } = faces;
    let mut mesh = Mesh::from_parts(points, corners, starts)?;
    mesh.normals = Layer::per_corner(normals, normal_at);
    if profile.uvs {
        mesh.uvs = Layer::per_corner(uvs, uv_at);
    }
    Ok(mesh)
}

fn tube(part: &Part, frames: &Frames, profile: &Profile, base: usize, faces: &mut Faces) {
    let Some(state) = part.states.first() else { return };
    let (sides, rings) = (profile.sides, state.points.len());
    let circle = profile.circle();
    let round = !part.closed && profile.caps == Caps::Round;
    let cap = if round { FRAC_PI_2 * profile.radius } else { 0.0 };
    let whole = state.lengths[rings] + 2.0 * cap;
    let v = |way: f64| if whole > 0.0 { way / whole } else { 0.0 };
    // Of each ring the normals as the line arrives and as it leaves, and a row of texture coordinates; of a closed tube
    // one more row, which ends where it began.
    let mut normals = Vec::with_capacity(rings);
    let mut rows = Vec::with_capacity(rings + 1);
    for i in 0..rings {
        let ring = Ring::of(state, frames, i);
        let first = faces.normals.len();
        let both: Vec<[Vector; 2]> = circle.iter().map(|&way| ring.normals(way)).collect();
        faces.normals.extend(both.iter().map(|[arriving, _]| *arriving));
        let split = both.iter().any(|[arriving, leaving]| arriving != leaving);
        if split {
            faces.normals.extend(both.iter().map(|[_, leaving]| *leaving));
        }
        normals.push([first, if split { first + sides } else { first }]);
        rows.push(faces.row(sides, v(cap + state.lengths[i])));
    }
    if part.closed {
        rows.push(faces.row(sides, 1.0));
    }
    for i in 0..if part.closed { rings } else { rings - 1 } {
        let next = (i + 1) % rings;
        for j in 0..sides {
            let k = (j + 1) % sides;
            let at = |ring: usize, side: usize| base + ring * sides + side;
            let (here, there) = (normals[i][1], normals[next][0]);
            faces.face(&[
                (at(i, j), here + j, rows[i] + j),
                (at(i, k), here + k, rows[i] + j + 1),
                (at(next, k), there + k, rows[i + 1] + j + 1),
                (at(next, j), there + j, rows[i + 1] + j),
            ]);
        }
    }
    if part.closed || profile.caps == Caps::None {
        return;
    }
    for (end, (i, way)) in [(0, -1.0), (rings - 1, 1.0)].into_iter().enumerate() {
        let along = state.leave[i] * way;
        let ring = base + i * sides;
        // Seen from outside the circle runs the other way round at the start.
        let order = |j: usize| if end == 0 { sides - 1 - j } else { j };
        if profile.caps == Caps::Flat {
            let normal = faces.normal(along);
            let disc: Vec<_> = (0..sides)
                .map(|j| {
                    let j = order(j);
                    let (cosine, sine) = circle[j];
                    (ring + j, normal, faces.uv([0.5 + 0.5 * cosine * -way, 0.5 + 0.5 * sine]))
                })
                .collect();
            faces.face(&disc);
            continue;
        }
        let above = base + rings * sides + end * (profile.rows() * sides + 1);
        let frame = Ring::of(state, frames, i);
        let v_at = |height: f64| match end {
            0 => v(cap - height * profile.radius),
            _ => v(whole - cap + height * profile.radius),
        };
        let mut below = (ring, normals[i][1 - end], rows[i]);
        for (k, height) in profile.heights().enumerate() {
            let (up, out) = height.sin_cos();
            let first = faces.normals.len();
            faces.normals.extend(circle.iter().map(|&side| frame.side(side) * out + along * up));
            let row = (above + k * sides, first, faces.row(sides, v_at(height)));
            for j in 0..sides {
                let next = (j + 1) % sides;
                let [a, b, c, d] = [
                    (below.0 + j, below.1 + j, below.2 + j),
                    (below.0 + next, below.1 + next, below.2 + j + 1),
                    (row.0 + next, row.1 + next, row.2 + j + 1),
                    (row.0 + j, row.1 + j, row.2 + j),
                ];
                faces.face(&if end == 0 { [d, c, b, a] } else { [a, b, c, d] });
            }
            below = row;
        }
        let tip = above + profile.rows() * sides;
        let normal = faces.normal(along);
        for j in 0..sides {
            let next = (j + 1) % sides;
            // Each triangle has the tip in the middle of its side.
            let uv = faces.uv([(j as f64 + 0.5) / sides as f64, v_at(FRAC_PI_2)]);
            let [a, b] =
                [(below.0 + j, below.1 + j, below.2 + j), (below.0 + next, below.1 + next, below.2 + j + 1)];
            let tip = (tip, normal, uv);
            faces.face(&if end == 0 { [b, a, tip] } else { [a, b, tip] });
        }
    }
}
