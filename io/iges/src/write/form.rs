//! Curves and surfaces by themselves as what they are: lines (110), circular arcs (100) and conic arcs (104), and what these are turned (120) or moved
//! along (122).

use std::f64::consts::TAU;

use loftsman_kernel::brep::{CurveForm, Frame, SurfaceForm};
use loftsman_kernel::spline::{Curve, CurvePiece, Direction, Surface, SurfacePiece};
use loftsman_kernel::{Point, Vector};
use nalgebra::Matrix4;

use super::print::{Look, Printer, Record};

/// A conic whose half diameters squared are further apart is read as another kind: its equation has no digits for both.
const FLATTEST: f64 = 1e-10;
/// So many neighbours of a number are tried on either side.
const NEIGHBOURS: usize = 8;

impl Printer {
    /// A curve as the line or conic that it is: its number and what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed(
        &mut self,
        curve: &Curve,
        look: Look,
        properties: &[u32],
    ) -> Option<(u32, &'static str)> {
        // Asked once more: what is written is never another curve.
        let piece = &curve.form().filter(|piece| piece.check(curve).is_ok())?.upright();
        let ends = [*curve.points().first()?, *curve.points().last()?];
        let (low, high) = curve.domain();
        let number = match piece.form {
            CurveForm::Spline => return None,
            CurveForm::Line if ends[0] == ends[1] => return None,
            CurveForm::Line => {
                let record = Record::new(110).reals(ends.iter().flat_map(|p| p.iter()));
                self.put(record.properties(properties), look)
            }
            CurveForm::Circle { frame, radius } => {
                self.circle((&frame, radius), piece, ends, (look, properties))
            }
            CurveForm::Ellipse { frame, radii } => {
                self.ellipse((&frame, radii), piece, high - low, (look, properties))?
            }
            CurveForm::Parabola { frame, focal } => {
                let at = |t: f64| {
                    let y = settled(2.0 * focal * t, t, |y| y / (2.0 * focal));
                    [focal * t * t, y]
                };
                let form =
                    Conic { equation: [0.0, 1.0, -4.0 * focal, 0.0], ends: piece.range.map(at), number: 3 };
                self.conic(&frame, &form, (look, properties))
            }
            CurveForm::Hyperbola { frame, radii: [a, b] } => {
                let equation = equation(a, b, -1.0)?;
                let at = |t: f64| [a * t.cosh(), settled(b * t.sinh(), t, |y| (y / b).asinh())];
                let form = Conic { equation, ends: piece.range.map(at), number: 2 };
                self.conic(&frame, &form, (look, properties))
            }
        };
        Some((number, piece.noun()))
    }

    /// A surface as the rectangle of an elementary one, or the swept curve, that it is, turned (120) or, also of a plane, along a vector (122): its number and
    /// what it is called. `None` where it is a spline and no more.
    pub(crate) fn formed_surface(
        &mut self,
        surface: &Surface,
        look: Look,
        properties: &[u32],
    ) -> Option<(u32, &'static str)> {
        let piece = *surface.form().filter(|piece| piece.check(surface).is_ok())?;
        let [[a, b], v] = piece.ranges;
        let net = surface.points();
        let columns = surface.v().len();
        let (start, end) = (*net.first()?, *net.get(columns - 1)?);
        let line = |ends: [Point; 2]| Record::new(110).reals(ends.iter().flat_map(|p| p.iter()));
        let (frame, radius, major) = match piece.form {
            SurfaceForm::Plane { .. } => {
                let directrix = self.put(line([start, *net.get(net.len() - columns)?]), Look::PART);
                let record = Record::new(122).entity(directrix).reals(end.iter());
                return Some((self.put(record.properties(properties), look), piece.noun()));
            }
            SurfaceForm::Extrusion { .. } => {
                let directrix = self.profile(surface, &piece)?;
                let record = Record::new(122).entity(directrix).reals(end.iter());
                return Some((self.put(record.properties(properties), look), piece.noun()));
            }
            // Around against the angle runs the mirror image of a cone.
            _ if a > b => return None,
            SurfaceForm::Cylinder { frame, .. } | SurfaceForm::Cone { frame, .. } => (frame, None, 0.0),
            SurfaceForm::Sphere { frame, radius } => (frame, Some(radius), 0.0),
            SurfaceForm::Torus { frame, major, minor } => (frame, Some(minor), major),
            SurfaceForm::Revolution { frame, .. } => (frame, None, 0.0),
            SurfaceForm::Spline => return None,
        };
        let generatrix = match radius {
            None if matches!(piece.form, SurfaceForm::Revolution { .. }) => self.profile(surface, &piece)?,
            None => self.put(line([start, end]), Look::PART),
            Some(radius) => {
                let x = frame.x * a.cos() + frame.y() * a.sin();
                let circle = Frame::new(frame.origin + x * major, x.cross(&frame.z), x)?;
                let form = CurveForm::Circle { frame: circle, radius };
                let [c, d] = v;
                let profile = CurvePiece { form, range: [c.min(d), c.max(d)] };
                let profile = if c < d { profile } else { profile.reversed() };
                let meridian = surface.isocurve(Direction::U, surface.u().domain().0).ok()?;
                self.formed(&meridian.with_form(profile).ok()?, Look::PART, &[])?.0
            }
        };
        // As long as the surface is large, so that its direction has all digits.
        let size = net.iter().map(|p| (p - start).amax()).fold(0.0, f64::max);
        let axis = self.put(line([frame.origin, frame.origin + frame.z * size]), Look::PART);
        let record = Record::new(120).entities(&[axis, generatrix]).reals(&[0.0, b - a]);
        Some((self.put(record.properties(properties), look), piece.noun()))
    }

    /// The curve that is swept, as what it is.
    fn profile(&mut self, surface: &Surface, piece: &SurfacePiece) -> Option<u32> {
        let profile = piece.profile(surface).ok()??;
        match profile.form() {
            Some(_) => self.formed(&profile, Look::PART, &[]).map(|(number, _)| number),
            None => Some(self.curve(&profile, Look::PART, &[])),
        }
    }

    fn circle(
        &mut self,
        (frame, radius): (&Frame, f64),
        piece: &CurvePiece,
        ends: [Point; 2],
        (look, properties): (Look, &[u32]),
    ) -> u32 {
        let ([from, to], full) = (piece.range, piece.is_whole());
        if frame.z == Vector::z() {
            // In a plane of the file's own axes it needs no matrix, and ends where it ends.
            let [start, end] = [ends[0], if full { ends[0] } else { ends[1] }];
            let all = [frame.origin, start, end].map(|p| [p.x, p.y]);
            let record = Record::new(100).real(frame.origin.z).reals(all.iter().flatten());
            return self.put(record.properties(properties), look);
        }
        // Its angles count from where it starts.
        let frame = if from == 0.0 {
            *frame
        } else {
            Frame { x: frame.x * from.cos() + frame.y() * from.sin(), ..*frame }
        };
        let end = if full { [radius, 0.0] } else { ending([radius; 2], 0.0, to - from) };
        let record = Record::new(100).reals(&[0.0; 3]).reals(&[radius, 0.0]).reals(&end);
        let look = self.at(&frame, look);
        self.put(record.properties(properties), look)
    }

    fn ellipse(
        &mut self,
        (frame, radii): (&Frame, [f64; 2]),
        piece: &CurvePiece,
        domain: f64,
        what: (Look, &[u32]),
    ) -> Option<u32> {
        let equation = equation(radii[0], radii[1], 1.0)?;
        let [from, to] = piece.range;
        let sweep = if ((to - from) - domain).abs() <= 1e-9 { domain } else { to - from };
        let (sin, cos) = from.sin_cos();
        let wanted = if from.abs() <= std::f64::consts::PI { from } else { sin.atan2(cos) };
        let y = settled(radii[1] * sin, wanted, |y| angle([radii[0] * cos, y], radii));
        let start = [settled(radii[0] * cos, wanted, |x| angle([x, y], radii)), y];
        let end = if piece.is_whole() { start } else { ending(radii, angle(start, radii), sweep) };
        Some(self.conic(frame, &Conic { equation, ends: [start, end], number: 1 }, what))
    }

    /// A conic arc (104) in standard position.
    fn conic(&mut self, frame: &Frame, conic: &Conic, (look, properties): (Look, &[u32])) -> u32 {
        let [a, c, d, f] = conic.equation;
        let record = Record::new(104).reals(&[a, 0.0, c, d, 0.0, f, 0.0]).reals(conic.ends.iter().flatten());
        let look = self.at(frame, look).form(conic.number);
        self.put(record.properties(properties), look)
    }

    /// Where a frame is, unless it is that of the file.
    fn at(&mut self, frame: &Frame, look: Look) -> Look {
        let axes = [frame.x, frame.y(), frame.z, frame.origin.coords];
        let mut map = Matrix4::identity();
        for (k, axis) in axes.iter().enumerate() {
            map.fixed_view_mut::<3, 1>(0, k).copy_from(axis);
        }
        if map == Matrix4::identity() {
            return look;
        }
        let matrix = self.matrix(&map);
        Look { matrix: Some(matrix), ..look }
    }
}

/// `A x² + C y² + D x + F = 0` from one point to another, and the number of its form.
struct Conic {
    equation: [f64; 4],
    ends: [[f64; 2]; 2],
    number: i32,
}

/// `x²/a² ± y²/b² = 1`, times the lesser square: of that half diameter the coefficient is 1, so that it is read to the bit; that of the other is
/// the neighbour of its quotient that is read to the bit.
fn equation(a: f64, b: f64, sign: f64) -> Option<[f64; 4]> {
    let (less, more) = if a <= b { (a, b) } else { (b, a) };
    let square = less * less;
    let quotient = (less / more) * (less / more);
    if !(quotient > FLATTEST && square > 0.0 && square.is_finite()) {
        return None;
    }
    let other = settled(quotient, more, |quotient| (square / quotient).sqrt());
    let [first, second] = if a <= b { [1.0, other] } else { [other, 1.0] };
    Some([first, sign * second, 0.0, -square])
}

/// The angle of a point on an ellipse.
fn angle([x, y]: [f64; 2], radii: [f64; 2]) -> f64 {
    (y / radii[1]).atan2(x / radii[0])
}

/// The point of an ellipse by an angle behind another, such that the angle between them is read to the bit.
fn ending(radii: [f64; 2], from: f64, sweep: f64) -> [f64; 2] {
    let (sin, cos) = (from + sweep).sin_cos();
    let read = |p: [f64; 2]| (angle(p, radii) - from).rem_euclid(TAU);
    let y = settled(radii[1] * sin, sweep, |y| read([radii[0] * cos, y]));
    [settled(radii[0] * cos, sweep, |x| read([x, y])), y]
}

/// The number nearest to a guess of which `read` makes what is wanted, to the bit: what is read and written again is then the same. The guess
/// itself where none of its neighbours is read so.
fn settled(guess: f64, wanted: f64, read: impl Fn(f64) -> f64) -> f64 {
    let (mut up, mut down) = (guess, guess);
    for _ in 0..=NEIGHBOURS {
        if read(up) == wanted {
            return up;
        }
        if read(down) == wanted {
            return down;
        }
        (up, down) = (up.next_up(), down.next_down());
    }
    guess
}
