//! `symmetrize`: shapes made exactly symmetric about a plane.

mod circle;
mod corners;
mod ellipse;
mod operation;
mod start;
mod surface;

use loftsman_kernel::error::{Error, MAX_DEGREE, Result};
use loftsman_kernel::spline::algebra::Function;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

use crate::fields::long;

pub use corners::Corner;
pub use operation::Symmetrize;
pub use surface::{symmetrize_surface, symmetrize_surface_best};

/// Samples of a span for the places where a curve crosses the plane.
const SAMPLES: usize = 16;
/// What is nearer to the plane than this part of the size is in it.
const IN_PLANE: f64 = 1e-9;
/// A curve that ends where it began to this part of its size is closed.
const CLOSED: f64 = 1e-12;

/// A plane to mirror in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror {
    point: Point,
    normal: Vector,
}

/// Which half of a shape the other is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Half {
    /// The mean of both: of all symmetric shapes with these knots the one whose control vertices are nearest.
    #[default]
    Both,
    /// That on the side to which the normal points.
    Front,
    /// The other.
    Back,
}

/// A symmetric shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetric<T> {
    /// The shape: for parameters that mirror one another the points do so, too.
    pub shape: T,
    /// The furthest that a control vertex has moved, once knots were inserted so that they are symmetric, and of a circle its centre; none where a half is new.
    pub moved: Option<f64>,
    /// Where it turns (a corner of a curve, a crease of a surface) and the original is smooth.
    pub corners: Vec<Corner>,
}

impl Mirror {
    /// The plane through a point, with a normal of any length.
    ///
    /// # Errors
    /// When a number is not finite or the normal is 0.
    pub fn new(point: Point, normal: Vector) -> Result<Self> {
        let largest = normal.amax();
        if !(largest > 0.0 && normal.iter().chain(point.iter()).all(|x| x.is_finite())) {
            return Err(Error::Invalid("the plane needs a finite point, and a normal that is not 0".into()));
        }
        Ok(Self { point, normal: (normal / largest).normalize() })
    }

    fn height(&self, point: &Point) -> f64 {
        (point - self.point).dot(&self.normal)
    }

    fn image(&self, point: &Point) -> Point {
        // Twice, where twice the height may be no number.
        let height = self.normal * self.height(point);
        point - height - height
    }
}

/// A curve made symmetric about a plane: with `Half::Both` the mean of the curve and its mirror image run backwards, else one half and its
/// mirror image; a curve that begins or ends in the plane is a half by itself. To keep a half a closed curve is begun where it crosses the plane first. With both halves it is
/// begun where its mirror image, run backwards from there, comes nearest to it (least squares over its parameter), and that place comes to lie in the plane; a circle
/// in a plane across the mirror is moved, stays a circle, and begins in the mirror.
///
/// The mean of vertices `P` with weights `w` and mirrored ones `Q` with `ω`, both over knots that are symmetric, is
/// `(w P + ω Q) / (w + ω)` with weights `(w + ω) / 2`. `O(n p)`. Where weights differ that may turn at knots as often as the degree at which the curve is smooth:
/// then an ellipse becomes the ellipse that is its mean with its image, and any other curve the mean of the points, of twice the degree, where that has fewer
/// corners (none where the derivative is continuous there). Corners that remain are told, also those where a half meets its image.
///
/// ```
/// use loftsman_construction::{Half, Mirror, symmetrize};
/// use loftsman_kernel::{Point, Vector, spline::Curve};
/// let points = [[-2.0, 0.1], [-1.0, 2.0], [1.1, 2.0], [2.0, 0.0]].map(|[x, y]| Point::new(x, y, 0.0));
/// let mirror = Mirror::new(Point::origin(), Vector::x())?;
/// let even = symmetrize(&Curve::bezier(points.to_vec())?, &mirror, Half::Both)?.shape;
/// let (p, q) = (even.point(0.2)?, even.point(0.8)?);
/// assert!((p.x + q.x).abs() + (p.y - q.y).abs() < 1e-15);
/// # Ok::<(), loftsman_kernel::Error>(())
/// ```
///
/// # Errors
/// When half of the curve is asked for and it does not cross the plane once (closed: twice; open: not at all where it begins or ends in
/// it, and all of it is on that side); when a closed curve does not cross it at all.
pub fn symmetrize(curve: &Curve, mirror: &Mirror, half: Half) -> Result<Symmetric<Curve>> {
    let (start, end) = curve.domain();
    let size = curve.points().iter().map(|p| long(&(p - curve.points()[0]))).fold(0.0, f64::max);
    let closed = curve.is_periodic() || long(&(curve.point(start)? - curve.point(end)?)) <= CLOSED * size;
    if half == Half::Both {
        if !closed {
            return smooth_mean(curve, mirror, false);
        }
        if crossings(curve, mirror)?.is_empty() {
            return Err(Error::Invalid(
                "the closed curve does not cross the plane: move the plane, or the curve".into(),
            ));
        }
        if let Some(round) = circle::moved(curve, mirror)? {
            return Ok(round);
        }
        let even = smooth_mean(&curve.started_at(start::best(curve, mirror)?)?, mirror, true)?;
        if even.corners.is_empty() && even.shape.degree() == curve.degree() {
            return Ok(even);
        }
        return Ok(ellipse::mean(curve, mirror)?.unwrap_or(even));
    }
    let side = if half == Half::Front { 1.0 } else { -1.0 };
    let mut cuts = crossings(curve, mirror)?;
    if !closed {
        // An end in the plane is a half's own end, and no place where it crosses.
        let near = IN_PLANE * size;
        let is_in = |at: f64| -> Result<bool> { Ok(mirror.height(&curve.point(at)?).abs() <= near) };
        let slack = IN_PLANE * (end - start);
        let ends = [is_in(start)?, is_in(end)?];
        cuts.retain(|at| !(ends[0] && at - start <= slack || ends[1] && end - at <= slack));
        if cuts.is_empty() && ends.contains(&true) {
            return from_plane(curve, mirror, side, ends);
        }
    } else {
        // A knot to rounding is the knot, and the end is the beginning.
        let slack = IN_PLANE * (end - start);
        let breaks = curve.space().breakpoints();
        for at in &mut cuts {
            let knot = breaks.iter().copied().find(|k| (k - *at).abs() <= slack).unwrap_or(*at);
            *at = if knot < end { knot } else { start };
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
    }
    let wanted = if closed { 2 } else { 1 };
    if cuts.len() != wanted {
        let kind = if closed { "twice" } else { "once" };
        return Err(Error::Invalid(format!(
            "the curve {}: to keep one half, it is to cross it {kind}",
            crossing("crosses the plane", cuts.len())
        )));
    }
    let opened = if closed { curve.started_at(cuts[0])?.to_clamped()? } else { curve.to_clamped()? };
    let (a, b) = opened.domain();
    // The other crossing, on the curve as it begins now.
    let last = cuts[cuts.len() - 1];
    let last = if last < a { last + (end - start) } else { last };
    if !(a < last && last < b) {
        return Err(Error::Invalid(
            "the curve ends in the plane, and has no other half there: join it first".into(),
        ));
    }
    let parts = opened.split(last)?;
    let [before, after] = &parts[..] else {
        return Err(Error::Invalid("the curve cannot be cut at the plane: it is torn there".into()));
    };
    let (c, d) = before.domain();
    let kept = if mirror.height(&before.point(0.5 * c + 0.5 * d)?) * side > 0.0 { before } else { after };
    let first_is_in = closed || std::ptr::eq(kept, after);
    // How the original turns where it is cut: at the other crossing, and where it begins.
    let turned = [corners::turn_between(before, after), corners::turn_between(after, before)];
    let (space, mut points, weights) = kept.clone().into_parts();
    let n = points.len();
    let onto = |p: Point| p - mirror.normal * mirror.height(&p);
    if closed || first_is_in {
        points[0] = onto(points[0]);
    }
    if closed || !first_is_in {
        points[n - 1] = onto(points[n - 1]);
    }
    let kept = Curve::build(space, points, weights)?;
    let image = mirrored(&kept, mirror)?;
    // Both end in the plane, to rounding.
    let snap = 1e-12 * (size + kept.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max));
    let (first, second) = if first_is_in && !closed { (&image, &kept) } else { (&kept, &image) };
    let mut corners: Vec<Corner> = corners::between(first, second, turned[0]).into_iter().collect();
    corners.extend(closed.then(|| corners::between(second, first, turned[1])).flatten());
    let mut shape = first.join(second, snap)?.shape;
    if closed && curve.is_periodic() {
        shape = shape.to_periodic(1e-14 * size)?.shape;
    }
    // It begins at the parameter at which the curve began: what is symmetric already stays as it is, its parameters, too.
    let (begin, over) = shape.domain();
    if !closed && begin != start {
        shape = shape.reparametrise(start, start + (over - begin))?;
    }
    Ok(Symmetric { shape, moved: None, corners })
}

/// An open curve on one side of the plane that begins or ends in it, or both, and its mirror image.
fn from_plane(curve: &Curve, mirror: &Mirror, side: f64, ends: [bool; 2]) -> Result<Symmetric<Curve>> {
    let open = curve.to_clamped()?;
    let mut furthest = 0.0_f64;
    for span in open.space().breakpoints().windows(2) {
        for k in 0..=SAMPLES {
            let at = (span[0] + (span[1] - span[0]) * k as f64 / SAMPLES as f64).min(span[1]);
            let height = mirror.height(&open.point(at)?);
            furthest = if height.abs() > furthest.abs() { height } else { furthest };
        }
    }
    let reach = open.points().iter().map(|p| long(&(p - open.points()[0]))).fold(0.0, f64::max);
    if furthest.abs() <= IN_PLANE * reach {
        return Err(Error::Invalid("the curve lies in the plane, and is its own mirror image".into()));
    }
    if furthest * side <= 0.0 {
        let (here, other) = if side > 0.0 { ("in front of", "back") } else { ("behind", "front") };
        return Err(Error::Invalid(format!(
            "nothing of the curve is {here} the plane: keep the other half (half = \"{other}\")"
        )));
    }
    let (space, mut points, weights) = open.into_parts();
    let n = points.len();
    for (is_in, k) in [(ends[0], 0), (ends[1], n - 1)] {
        if is_in {
            let height = mirror.height(&points[k]);
            points[k] -= mirror.normal * height;
        }
    }
    let largest = points.iter().map(|p| long(&(p - points[0])).max(p.coords.amax())).fold(0.0, f64::max);
    let kept = Curve::build(space, points, weights)?;
    let image = mirrored(&kept, mirror)?;
    // What begins and ends in the plane is closed then.
    let (first, second) = if ends[0] { (&image, &kept) } else { (&kept, &image) };
    let mut corners: Vec<Corner> = corners::between(first, second, 0.0).into_iter().collect();
    corners.extend((ends[0] && ends[1]).then(|| corners::between(second, first, 0.0)).flatten());
    Ok(Symmetric { shape: first.join(second, 1e-12 * largest)?.shape, moved: None, corners })
}

fn mirrored(curve: &Curve, mirror: &Mirror) -> Result<Curve> {
    let (space, points, weights) = curve.reverse()?.into_parts();
    Curve::build(space, points.iter().map(|p| mirror.image(p)).collect(), weights)
}

/// The mean of a curve and its mirror image: of their vertices, or, where that has fewer corners, of their points.
fn smooth_mean(curve: &Curve, mirror: &Mirror, closed: bool) -> Result<Symmetric<Curve>> {
    let open = curve.to_clamped()?;
    let common = symmetric_space(open.space())?;
    let fine = open.insert_knots(&missing(open.space(), &common))?;
    let fine = Curve::build(common.clone(), fine.points().to_vec(), fine.weights().map(<[f64]>::to_vec))?;
    let image = mirrored(&fine, mirror)?;
    let (points, weights, moved) =
        averaged((fine.points(), fine.weights()), (image.points(), image.weights()));
    let corners = corners::of_curve(&common, &points, fine.points(), closed);
    let shape = Curve::build(common, points, weights)?;
    let even = Symmetric { shape, moved: Some(moved), corners };
    let pointwise = if even.corners.is_empty() { None } else { mean_of_points(&fine, mirror, closed)? };
    let mut even = pointwise.filter(|found| found.corners.len() < even.corners.len()).unwrap_or(even);
    if curve.is_periodic() {
        let largest =
            even.shape.points().iter().map(|p| long(&(p - even.shape.points()[0])).max(p.coords.amax()));
        let size = largest.fold(0.0, f64::max);
        even.shape = even.shape.to_periodic(1e-14 * size)?.shape;
    }
    Ok(even)
}

/// The mean of the points of a rational curve over symmetric knots and of its mirror image, `P / w` and `Q / ω`: `(P ω + Q w) / (2 w ω)`. Nothing where the degree is too high.
fn mean_of_points(fine: &Curve, mirror: &Mirror, closed: bool) -> Result<Option<Symmetric<Curve>>> {
    let (Some(w), true) = (fine.weights(), 2 * fine.degree() <= MAX_DEGREE) else { return Ok(None) };
    let space = fine.space();
    // About the middle of the plane, so that far away is as near as here.
    let origin = mirror.point.coords;
    let parts = |curve: &Curve, w: &[f64]| -> Result<(Function<Vector>, Function<f64>)> {
        let points = curve.points().iter().zip(w).map(|(p, w)| (p.coords - origin) * *w).collect();
        Ok((Function::new(space.clone(), points)?, Function::new(space.clone(), w.to_vec())?))
    };
    let (upper, lower) = parts(fine, w)?;
    let backwards: Vec<f64> = w.iter().rev().copied().collect();
    let (other_upper, other_lower) = parts(&mirrored(fine, mirror)?, &backwards)?;
    let quotient = |upper: Function<Vector>, lower: &Function<f64>| -> Result<Curve> {
        let points = upper.coefficients().iter().zip(lower.coefficients());
        let points = points.map(|(p, w)| Point::from(p / *w + origin)).collect();
        Curve::build(upper.space().clone(), points, Some(lower.coefficients().to_vec()))
    };
    let weights = lower.times(&other_lower)?;
    let sum = upper.times(&other_lower)?.plus(1.0, &other_upper.times(&lower)?)?.mapped(|v| v * 0.5)?;
    let shape = settled(&quotient(sum, &weights)?, mirror, false)?;
    let old = quotient(upper.times(&other_lower)?, &weights)?;
    let moved = shape.points().iter().zip(old.points()).map(|(p, q)| long(&(p - q))).fold(0.0, f64::max);
    let corners = corners::of_curve(shape.space(), shape.points(), old.points(), closed);
    Ok(Some(Symmetric { shape, moved: Some(moved), corners }))
}

/// What is symmetric to rounding, clamped, so that it is so to the last bits; periodic if asked for.
fn settled(shape: &Curve, mirror: &Mirror, periodic: bool) -> Result<Curve> {
    let image = mirrored(shape, mirror)?;
    let (points, weights, _) = averaged((shape.points(), shape.weights()), (image.points(), image.weights()));
    let size = points.iter().map(|p| long(&(p - points[0])).max(p.coords.amax())).fold(0.0, f64::max);
    let shape = Curve::build(shape.space().clone(), points, weights)?;
    if periodic { Ok(shape.to_periodic(1e-14 * size)?.shape) } else { Ok(shape) }
}

type Net<'a> = (&'a [Point], Option<&'a [f64]>);

/// The mean of two nets, and how far the first one's vertices have moved.
fn averaged(first: Net<'_>, second: Net<'_>) -> (Vec<Point>, Option<Vec<f64>>, f64) {
    let n = first.0.len();
    let weight = |net: &Net<'_>, k: usize| net.1.map_or(1.0, |w| w[k]);
    let points: Vec<Point> = (0..n)
        .map(|k| {
            let (w, v) = (weight(&first, k), weight(&second, k));
            Point::from((first.0[k].coords * w + second.0[k].coords * v) / (w + v))
        })
        .collect();
    let weights =
        first.1.map(|_| (0..n).map(|k| 0.5 * weight(&first, k) + 0.5 * weight(&second, k)).collect());
    let moved = points.iter().zip(first.0).map(|(p, q)| long(&(p - q))).fold(0.0, f64::max);
    (points, weights, moved)
}

/// The space with the mirrored knots inserted, and knots that are nearly mirrored moved by rounding, so that all are.
fn symmetric_space(space: &Space) -> Result<Space> {
    let (a, b) = space.domain();
    let near = 1e-12 * space.length();
    let p = space.degree();
    let breaks = space.breakpoints();
    let mut both: Vec<(f64, usize)> = Vec::with_capacity(2 * breaks.len());
    for &k in breaks.iter().filter(|&&k| k > a && k < b) {
        let times = space.multiplicity(k).min(p + 1);
        both.extend([(k, times), (a + (b - k), times)]);
    }
    both.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut inner: Vec<(f64, usize)> = Vec::with_capacity(both.len());
    for (at, times) in both {
        match inner.last_mut() {
            Some((last, most)) if at - *last <= near => *most = times.max(*most),
            _ => inner.push((at, times)),
        }
    }
    let mut knots = vec![a; p + 1];
    knots.extend(inner.iter().flat_map(|&(x, times)| vec![x; times]));
    knots.extend(vec![b; p + 1]);
    Space::open(p, knots)
}

/// What has to be inserted for a space to be another one.
fn missing(space: &Space, wanted: &Space) -> Vec<f64> {
    let near = 1e-12 * space.length();
    let mut old = space.flat().iter().peekable();
    let mut missing = Vec::new();
    for &k in wanted.flat() {
        while old.next_if(|x| k - **x > near).is_some() {}
        if old.next_if(|x| (**x - k).abs() <= near).is_none() {
            missing.push(k);
        }
    }
    missing
}

/// The parameters where a curve changes sides; the seam of a closed curve once.
pub(crate) fn crossings(curve: &Curve, mirror: &Mirror) -> Result<Vec<f64>> {
    let (a, b) = curve.domain();
    let size = curve.points().iter().map(|p| long(&(p - curve.points()[0]))).fold(0.0, f64::max);
    let closes = curve.is_periodic() || long(&(curve.point(a)? - curve.point(b)?)) <= CLOSED * size;
    let largest = curve.points().iter().map(|p| p.coords.amax()).fold(mirror.point.coords.amax(), f64::max);
    let rounding = 16.0 * f64::EPSILON * largest;
    let height = |u: f64| curve.point(u).map(|p| mirror.height(&p));
    let mut found: Vec<f64> = Vec::new();
    let mut last: Option<(f64, f64)> = None;
    let mut within: Option<f64> = None;
    for span in curve.space().breakpoints().windows(2) {
        for k in 0..=SAMPLES {
            let u = if k == SAMPLES {
                span[1]
            } else {
                span[0] + (span[1] - span[0]) * k as f64 / SAMPLES as f64
            };
            let h = height(u)?;
            // A sample in the plane says where, and the next one beside it whether the curve changes sides there.
            if h.abs() <= rounding {
                within = within.or(Some(u));
                continue;
            }
            if let Some((before, value)) = last
                && (value < 0.0) != (h < 0.0)
            {
                let (mut low, mut high) = (before, u);
                for _ in 0..if within.is_some() { 0 } else { 200 } {
                    let middle = 0.5 * low + 0.5 * high;
                    if !(low < middle && middle < high) {
                        break;
                    }
                    if (height(middle)? < 0.0) == (value < 0.0) {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                let nearer = if height(low)?.abs() <= height(high)?.abs() { low } else { high };
                found.push(within.unwrap_or(nearer));
            }
            last = Some((u, h));
            within = None;
        }
    }
    // A closed curve may change sides at its seam.
    if closes && found.len() % 2 == 1 {
        found.insert(0, a);
    }
    Ok(found)
}

/// How often something happens, in words: `crosses the plane nowhere`, `… 3 times`.
fn crossing(does: &str, count: usize) -> String {
    match count {
        0 => format!("{does} nowhere"),
        1 => format!("{does} once"),
        2 => format!("{does} twice"),
        count => format!("{does} {count} times"),
    }
}
