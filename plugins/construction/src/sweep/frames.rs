//! Frames along a path that turn with its tangent.
//!
//! From a place `k` the tangent goes to `T` by the smallest rotation. A frame that is carried along by it turns about `T` at the rate
//! `-det(T_k, T, T') / (1 + T_k·T)`; taken away again, by quadrature, what is left turns as little as can be.

mod mitres;

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix3;

use super::Turning;

/// Fine steps of a polynomial piece.
const STEPS: usize = 4;
/// Halvings of a step.
const HALVINGS: usize = 30;
/// The largest turn of the tangent in one step: its cosine.
const TURN: f64 = 0.9;
/// Tangents that differ by more make a corner.
const CORNER: f64 = 1e-6;
/// A path nearer to the upright direction than this has no side.
const UPRIGHT: f64 = 1e-6;

/// The frame at a place of the path, seen from that at its start.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub(super) at: f64,
    /// The piece of the path, of which it has the derivatives.
    piece: usize,
    pub(super) point: Point,
    pub(super) speed: Vector,
    pub(super) tangent: Vector,
    /// The derivative of the tangent.
    bend: Vector,
    /// The rotation from the start, and its derivative.
    pub(super) turn: Matrix3<f64>,
    pub(super) turning: Matrix3<f64>,
    /// Across the tangent, as it is carried along without twist.
    side: Vector,
    /// The length of the path up to here.
    length: f64,
}

/// A place of the path: point, derivative, tangent, its derivative.
struct Place {
    point: Point,
    speed: Vector,
    tangent: Vector,
    bend: Vector,
}

/// How sections lean beside a corner: what is at an arm `r` from the path, seen from its start, is moved by `m·r` along the tangent at the corner, and
/// evenly less until `reach` from there, measured along the path.
#[derive(Debug, Clone, Copy)]
struct Lean {
    by: Vector,
    corner: f64,
    reach: f64,
}

pub(super) struct Walk<'a> {
    pieces: Vec<Curve>,
    path: &'a Curve,
    turning: Turning,
    closed: bool,
    twist: f64,
    length: f64,
    /// The length of the path up to the end of each piece.
    lengths: Vec<f64>,
    /// For each piece the direction across the plane in which it begins and ends, where the path has a corner there.
    mitres: Vec<[Option<Vector>; 2]>,
    /// For each piece how sections lean on their way from the corner before it, and to that behind it.
    leans: Vec<[Option<Lean>; 2]>,
    /// Which pieces are straight.
    straight: Vec<bool>,
    rule: [(f64, f64); 5],
}

impl<'a> Walk<'a> {
    /// A walk with a profile, whose vertices say how far sections lean at corners.
    pub(super) fn new(path: &'a Curve, profile: &Curve, turning: Turning, size: f64) -> Result<Self> {
        let (a, b) = path.domain();
        let gap = (path.point(a)? - path.point(b)?).norm();
        let closed = path.is_periodic() || gap <= 1e-12 * size;
        let turning = match turning {
            Turning::Upright(up) => {
                let largest = up.amax();
                if !(largest > 0.0 && up.iter().all(|x| x.is_finite())) {
                    return Err(Error::Invalid(
                        "the upright direction is none: give a vector that is not 0".into(),
                    ));
                }
                Turning::Upright((up / largest).normalize())
            }
            other => other,
        };
        let pieces = path.bezier_segments()?;
        let rule = gauss();
        let (lengths, mitres) = (vec![0.0; pieces.len()], vec![[None; 2]; pieces.len()]);
        let (leans, straight) = (vec![[None; 2]; pieces.len()], pieces.iter().map(straight).collect());
        let (twist, length) = (0.0, 0.0);
        let mut walk =
            Self { pieces, path, turning, closed, twist, length, lengths, mitres, leans, straight, rule };
        walk.check(size)?;
        let mut last: Option<Frame> = None;
        let mut lengths = vec![0.0; walk.pieces.len()];
        walk.each(true, |_, end, _| {
            lengths[end.piece] = end.length;
            last = Some(end.clone());
            Ok(true)
        })?;
        walk.lengths = lengths;
        if let Some(end) = last {
            walk.length = end.length;
            if walk.closed && walk.turning == Turning::Least {
                let start = walk.first()?;
                // From the first side to the last, about the tangent; round the corner where there is one.
                let (s, mut e) = (start.side, end.side);
                if walk.is_mitred_at_start() {
                    let (to, from) = (start.tangent, end.tangent);
                    e -= (from + to) * (to.dot(&e) / (1.0 + from.dot(&to)));
                }
                walk.twist = -start.tangent.dot(&s.cross(&e)).atan2(s.dot(&e));
            }
        }
        if walk.is_mitred() {
            walk.leans = walk.leaning(profile)?;
        }
        Ok(walk)
    }

    /// Corners, tears and stops.
    fn check(&mut self, size: f64) -> Result<()> {
        let count = self.pieces.len();
        for k in 0..count {
            let j = (k + 1) % count;
            let at = self.pieces[k].domain().1;
            let (end, start) = (self.place(k, at)?, self.place(j, self.pieces[j].domain().0)?);
            let torn = (end.point - start.point).norm() > 1e-11 * size;
            let corner = (end.tangent - start.tangent).norm() > CORNER;
            let across = end.tangent + start.tangent;
            // Both sides end in the plane between them.
            let mitred = across.norm() > CORNER;
            if j == 0 && (!self.closed || corner && !mitred) {
                // A closed path that turns straight back at its seam is one with ends.
                self.closed = false;
            } else if torn && j > 0 {
                return Err(Error::Invalid(format!("the path is torn at {}: split it there", Figure(at))));
            } else if corner && mitred {
                self.mitres[k][1] = Some(across);
                self.mitres[j][0] = Some(across);
            } else if corner {
                return Err(Error::Invalid(format!(
                    "the path has a corner at {} and turns straight back, so that the surface would fold: split the path there",
                    Figure(at)
                )));
            }
        }
        Ok(())
    }

    /// How far a place of the profile is moved along the tangent, so that at corners it arrives in the plane between both sides; and the
    /// derivative of that.
    pub(super) fn ahead(&self, frame: &Frame, arm: &Vector) -> (f64, f64) {
        let (mut ahead, mut faster) = (0.0, 0.0);
        for (side, lean) in self.leans[frame.piece].iter().enumerate() {
            let Some(lean) = lean.filter(|lean| lean.reach > 0.0) else { continue };
            let (whole, away) = (lean.by.dot(arm), (frame.length - lean.corner).abs() / lean.reach);
            let slope = whole * frame.speed.norm() / lean.reach;
            ahead += whole * (1.0 - away.min(1.0));
            faster += if side == 0 { -slope } else { slope };
        }
        (ahead, faster)
    }

    /// Where a place of the profile is when the frame is there, and the derivative of that.
    pub(super) fn carried(&self, frame: &Frame, arm: &Vector) -> (Point, Vector) {
        let (ahead, faster) = self.ahead(frame, arm);
        let point = frame.point + frame.turn * arm + frame.tangent * ahead;
        (point, frame.speed + frame.turning * arm + frame.tangent * faster + frame.bend * ahead)
    }

    pub(super) fn closed(&self) -> bool {
        self.closed
    }

    pub(super) fn twist(&self) -> f64 {
        self.twist
    }

    /// Where the path starts.
    pub(super) fn start(&self) -> Point {
        self.pieces.first().map_or(Point::origin(), |p| p.points()[0])
    }

    fn place(&self, piece: usize, u: f64) -> Result<Place> {
        let curve = &self.pieces[piece];
        let (a, b) = curve.domain();
        let run: f64 = curve.points().windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let mut d = [Vector::zeros(); 3];
        curve.derivatives_into(u, &mut d)?;
        let speed = d[1].norm();
        if speed * (b - a) <= 1e-9 * run || run == 0.0 {
            return Err(Error::Invalid(format!(
                "the path stops at {} and has no direction there: its derivative has to be other than 0",
                Figure(u)
            )));
        }
        let tangent = d[1] / speed;
        let bend = (d[2] - tangent * tangent.dot(&d[2])) / speed;
        Ok(Place { point: Point::from(d[0]), speed: d[1], tangent, bend })
    }

    /// Any direction across the tangent at the start, or the one that upright means.
    fn first(&self) -> Result<Frame> {
        let at = self.path.domain().0;
        let place = self.place(0, at)?;
        let side = match self.turning {
            Turning::Upright(up) => self.beside(&up, &place, at)?.0,
            _ => {
                let mut axis = Vector::zeros();
                axis[place.tangent.iamin()] = 1.0;
                (axis - place.tangent * place.tangent.dot(&axis)).normalize()
            }
        };
        self.frame(0, at, &place, side, 0.0, &Basis(place.tangent, side))
    }

    /// The direction across both upright and path, and its derivative.
    fn beside(&self, up: &Vector, place: &Place, at: f64) -> Result<(Vector, Vector)> {
        let across = up.cross(&place.tangent);
        let norm = across.norm();
        if norm < UPRIGHT {
            return Err(Error::Invalid(format!(
                "the path runs along the upright direction at {}: give another one",
                Figure(at)
            )));
        }
        let side = across / norm;
        let change = up.cross(&place.bend) / norm;
        Ok((side, change - side * side.dot(&change)))
    }

    fn frame(
        &self,
        piece: usize,
        at: f64,
        place: &Place,
        side: Vector,
        length: f64,
        start: &Basis,
    ) -> Result<Frame> {
        let (tangent, bend) = (place.tangent, place.bend);
        let (first, change) = match self.turning {
            Turning::Upright(up) => self.beside(&up, place, at)?,
            _ => {
                // The twist of a closed path, by its length; not yet known on the first way round.
                let share = if self.length > 0.0 { self.twist / self.length } else { 0.0 };
                let (sine, cosine) = (share * length).sin_cos();
                let side = side * cosine + tangent.cross(&side) * sine;
                let spin = tangent.cross(&bend) + tangent * (share * place.speed.norm());
                (side, spin.cross(&side))
            }
        };
        let second = tangent.cross(&first);
        let columns = Matrix3::from_columns(&[tangent, first, second]);
        let changes = Matrix3::from_columns(&[bend, change, bend.cross(&first) + tangent.cross(&change)]);
        let back = start.matrix().transpose();
        Ok(Frame {
            at,
            piece,
            point: place.point,
            speed: place.speed,
            tangent,
            bend,
            turn: columns * back,
            turning: changes * back,
            side,
            length,
        })
    }

    /// The frame further on in the same piece; none where the tangent turns too far on the way.
    fn onwards(&self, piece: usize, from: &Frame, to: f64, start: &Basis) -> Result<Option<Frame>> {
        let place = self.place(piece, to)?;
        let t = from.tangent;
        let half = 0.5 * (to - from.at);
        let (mut angle, mut length) = (0.0, from.length);
        for (x, weight) in self.rule {
            let p = self.place(piece, from.at + half * (1.0 + x))?;
            if t.dot(&p.tangent) < TURN {
                return Ok(None);
            }
            angle += weight * half * t.cross(&p.tangent).dot(&p.bend) / (1.0 + t.dot(&p.tangent));
            length += weight * half * p.speed.norm();
        }
        if t.dot(&place.tangent) < TURN {
            return Ok(None);
        }
        let both = t + place.tangent;
        let side = from.side - both * (place.tangent.dot(&from.side) / (1.0 + t.dot(&place.tangent)));
        let (sine, cosine) = angle.sin_cos();
        let side = side * cosine + place.tangent.cross(&side) * sine;
        let side = (side - place.tangent * place.tangent.dot(&side)).normalize();
        self.frame(piece, to, &place, side, length, start).map(Some)
    }

    /// Goes along the path in steps: `take` says of each, by its ends and some frames between, whether it is short enough. `fine` steps
    /// are a quarter of a polynomial piece at most, others may be all of it.
    pub(super) fn each(
        &self,
        fine: bool,
        mut take: impl FnMut(&Frame, &Frame, &[Frame]) -> Result<bool>,
    ) -> Result<()> {
        let mut last = self.first()?;
        let start = Basis(last.tangent, last.side);
        for (k, piece) in self.pieces.iter().enumerate() {
            let (a, b) = piece.domain();
            if k > 0 {
                // The same place, with the derivatives of this side.
                let place = self.place(k, a)?;
                let both = last.tangent + place.tangent;
                let side = last.side
                    - both * (place.tangent.dot(&last.side) / (1.0 + last.tangent.dot(&place.tangent)));
                last = self.frame(k, a, &place, side.normalize(), last.length, &start)?;
            }
            let steps = if fine { STEPS } else { 1 };
            let mut open: Vec<(f64, usize)> = (1..=steps)
                .rev()
                .map(|s| (if s == steps { b } else { a + (b - a) * s as f64 / steps as f64 }, 0))
                .collect();
            while let Some((to, depth)) = open.pop() {
                let width = to - last.at;
                let mut frames = Vec::new();
                let mut from = last.clone();
                for x in [0.25, 0.5, 0.75, 1.0] {
                    let at = if x == 1.0 { to } else { last.at + width * x };
                    let Some(next) = self.onwards(k, &from, at, &start)? else { break };
                    frames.push(next.clone());
                    from = next;
                }
                let whole = frames.len() == 4;
                if whole && take(&last, &frames[3], &frames[..3])? {
                    last = from;
                    continue;
                }
                let middle = last.at + 0.5 * width;
                if depth >= HALVINGS || !(last.at < middle && middle < to) {
                    return Err(Error::Invalid(format!(
                        "the path turns at {} faster than can be followed: split it there, or give a larger tolerance",
                        Figure(middle)
                    )));
                }
                open.push((to, depth + 1));
                open.push((middle, depth + 1));
            }
        }
        Ok(())
    }

    /// The frames at ascending parameters, carried along in steps of their own.
    pub(super) fn frames_at(&self, at: &[f64]) -> Result<Vec<Frame>> {
        let mut found = Vec::with_capacity(at.len());
        let first = self.first()?;
        let start = Basis(first.tangent, first.side);
        let mut failed = Ok(());
        self.each(true, |begin, end, _| {
            while let Some(&u) = at.get(found.len()).filter(|u| **u <= end.at) {
                let piece =
                    self.pieces.iter().position(|p| u <= p.domain().1).unwrap_or(self.pieces.len() - 1);
                match self.onwards(piece, begin, u, &start) {
                    Ok(Some(frame)) => found.push(frame),
                    Ok(None) => return Ok(false),
                    Err(error) => {
                        failed = Err(error);
                        break;
                    }
                }
            }
            Ok(true)
        })?;
        failed.map(|()| found)
    }
}

/// Whether a piece is a straight way that never turns back.
fn straight(piece: &Curve) -> bool {
    let points = piece.points();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return false };
    let way = last - first;
    let length = way.norm();
    let legs = points.windows(2).map(|w| w[1] - w[0]);
    length > 0.0
        && legs
            .into_iter()
            .all(|leg| leg.cross(&way).norm() <= 1e-12 * length * length && leg.dot(&way) >= 0.0)
}

/// Gauß' rule of five points over `[-1, 1]`.
fn gauss() -> [(f64, f64); 5] {
    let root = 2.0 * (10.0_f64 / 7.0).sqrt();
    let (near, far) = ((5.0 - root).sqrt() / 3.0, (5.0 + root).sqrt() / 3.0);
    let (heavy, light) = ((322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0, (322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0);
    [(-far, light), (-near, heavy), (0.0, 128.0 / 225.0), (near, heavy), (far, light)]
}

/// The frame at the start: tangent and side.
struct Basis(Vector, Vector);

impl Basis {
    fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[self.0, self.1, self.0.cross(&self.1)])
    }
}
