//! Axis-parallel boxes around curves and surfaces: the tight one, and the cheap one of the control vertices.
//!
//! A side of the tight box is the largest value of a coordinate (or of its negative). Best first: every span starts
//! with its control vertices' largest value as a bound from above (weights are positive, so a rational piece too
//! stays in the hull of its vertices). The span with the largest bound is taken first and brought to Bézier form,
//! whose corners lie on the shape; while its bound sticks out beyond the values known to be reached it is halved.
//! The gap shrinks with the square of the piece's size, so a side takes some twenty halvings, and spans whose vertices
//! do not come near it are never touched. Convex hull property: Farin, *Curves and Surfaces for CAGD*, 5th ed.,
//! section 5.3.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::piece::{bezier, bezier_patch, halves, halves_of_rows};
use super::space::Space;
use super::{Curve, Surface};
use crate::{Point, Vector};

/// How far a side may lie outside the shape, relative to the largest extent of the control vertices' box.
const RELATIVE: f64 = 1e-12;
/// Halvings a side after which its bound is taken as it is: so many, and so many for each span.
pub(super) const HALVINGS: usize = 20_000;
pub(super) const HALVINGS_A_SPAN: usize = 64;

/// A coordinate times the weight, and the weight.
pub(super) type Value = [f64; 2];

impl Curve {
    /// The corners of the axis-parallel box around the curve, the lower first. The curve is inside (to rounding), and
    /// each side is within 1e-12 of touching it, relative to the largest extent of [`hull_bounds`](Self::hull_bounds).
    /// `O(n p)` and some twenty halvings, each `O(p²)`, for every place that reaches a side.
    pub fn bounds(&self) -> (Point, Point) {
        let (space, p) = (self.space(), self.degree());
        let spans: Vec<usize> = space.spans().collect();
        let net = Controls { points: self.points(), weights: self.weights() };
        let vertices = |span: usize| (span - p..=span).map(|k| space.vertex(k));
        tight(&net, self.hull_bounds(), |side| {
            let bound =
                |&s: &usize| vertices(s).map(|i| side.coordinate(i)).fold(f64::NEG_INFINITY, f64::max);
            farthest(spans.iter().map(bound), 1, side.tolerance, |k| {
                bezier(space, spans[k], &vertices(spans[k]).map(|i| side.value(i)).collect::<Vec<_>>())
            })
        })
    }

    /// The box of the control vertices that act in the domain. The curve is inside, but may not reach the sides.
    /// `O(n p)`.
    pub fn hull_bounds(&self) -> (Point, Point) {
        let used = used(self.space());
        around(self.points().iter().zip(used).filter_map(|(p, used)| used.then_some(p)))
    }
}

impl Surface {
    /// The corners of the axis-parallel box around the surface, the lower first, as [`Curve::bounds`]. Where the
    /// surface touches a side along a whole line that runs across its patches, and 20,000 halvings and 64 a patch are
    /// not enough to follow it, the side is farther out, as a rule by less than 1e-7 of the extent. `O(n p q)` and the
    /// halvings, each `O((p + q) p q)`.
    pub fn bounds(&self) -> (Point, Point) {
        let (u, v) = (self.u(), self.v());
        let (p, q) = (u.degree(), v.degree());
        let spans: Vec<_> = u.spans().flat_map(|i| v.spans().map(move |j| (i, j))).collect();
        let net = Controls { points: self.points(), weights: self.weights() };
        let vertices = |(i, j): (usize, usize)| {
            (i - p..=i).flat_map(move |r| (j - q..=j).map(move |c| u.vertex(r) * v.len() + v.vertex(c)))
        };
        tight(&net, self.hull_bounds(), |side| {
            let bound = |&s: &_| vertices(s).map(|i| side.coordinate(i)).fold(f64::NEG_INFINITY, f64::max);
            farthest(spans.iter().map(bound), q + 1, side.tolerance, |k| {
                bezier_patch(u, v, spans[k], vertices(spans[k]).map(|i| side.value(i)).collect())
            })
        })
    }

    /// The box of the control vertices that act in the domain. The surface is inside, but may not reach the sides.
    /// `O(n)`.
    pub fn hull_bounds(&self) -> (Point, Point) {
        let (rows, columns) = (used(self.u()), used(self.v()));
        let acting = rows.iter().flat_map(|row| columns.iter().map(move |column| *row && *column));
        around(self.points().iter().zip(acting).filter_map(|(p, used)| used.then_some(p)))
    }
}

/// Which vertices act in the domain: those of its non-empty spans. (Where an open domain starts or ends with more
/// than `p` equal knots from the inside, the outermost vertices have no share in it.)
fn used(space: &Space) -> Vec<bool> {
    let mut used = vec![false; space.len()];
    for span in space.spans() {
        for k in span - space.degree()..=span {
            used[space.vertex(k)] = true;
        }
    }
    used
}

fn around<'a>(points: impl Iterator<Item = &'a Point>) -> (Point, Point) {
    let nothing = (Vector::repeat(f64::INFINITY).into(), Vector::repeat(f64::NEG_INFINITY).into());
    points.fold(nothing, |(low, high): (Point, Point), p| (low.inf(p), high.sup(p)))
}

pub(super) struct Controls<'a> {
    pub(super) points: &'a [Point],
    pub(super) weights: Option<&'a [f64]>,
}

/// One of six ways out of the box: an axis, and `1` upwards or `-1` downwards.
pub(super) struct Side<'a> {
    net: &'a Controls<'a>,
    pub(super) axis: usize,
    pub(super) sign: f64,
    /// Coordinates are measured from here, so that rounding is relative to the shape, not to its distance from 0.
    pub(super) origin: f64,
    /// The largest weight: with it as unit no product overflows.
    weight: f64,
    /// How far the side may stay away from the shape.
    pub(super) tolerance: f64,
}

impl Side<'_> {
    pub(super) fn coordinate(&self, vertex: usize) -> f64 {
        self.sign * (self.net.points[vertex][self.axis] - self.origin)
    }

    pub(super) fn value(&self, vertex: usize) -> Value {
        let weight = self.net.weights.map_or(1.0, |w| w[vertex] / self.weight);
        [self.coordinate(vertex) * weight, weight]
    }
}

/// The tight box within `hull`; `reach` gives the largest coordinate of the shape towards a side.
pub(super) fn tight(
    net: &Controls<'_>,
    hull: (Point, Point),
    mut reach: impl FnMut(&Side<'_>) -> f64,
) -> (Point, Point) {
    let (low, high) = hull;
    let extent = (high - low).amax();
    if !extent.is_finite() {
        return hull;
    }
    let weight = net.weights.map_or(1.0, |w| w.iter().copied().fold(f64::MIN_POSITIVE, f64::max));
    let mut found = hull;
    // What is flat in an axis fills its side.
    for axis in (0..3).filter(|&axis| low[axis] < high[axis]) {
        for (sign, corner) in [(-1.0, &mut found.0), (1.0, &mut found.1)] {
            let origin = if sign > 0.0 { high[axis] } else { low[axis] };
            let side = Side { net, axis, sign, origin, weight, tolerance: RELATIVE * extent };
            // Negative: how far the side moves in from that of the hull.
            corner[axis] = origin + sign * reach(&side);
        }
    }
    found
}

struct Piece {
    bound: f64,
    /// Its Bézier net, or the number of the span it is to be made of.
    net: Result<Vec<Value>, usize>,
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Piece {}
impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// The largest value on all spans, from above and within `tolerance`: `bounds` are those of the spans, `make` brings
/// a span to Bézier form.
fn farthest(
    bounds: impl Iterator<Item = f64>,
    columns: usize,
    tolerance: f64,
    make: impl Fn(usize) -> Vec<Value>,
) -> f64 {
    let unmade = |(span, bound)| Piece { bound, net: Err(span) };
    let mut heap: BinaryHeap<Piece> = bounds.enumerate().map(unmade).collect();
    let mut left = heap.len().saturating_mul(HALVINGS_A_SPAN).saturating_add(HALVINGS);
    let mut known = f64::NEG_INFINITY;
    while let Some(piece) = heap.pop() {
        // No other piece has a larger bound.
        if piece.bound <= known + tolerance || left == 0 {
            return known.max(piece.bound);
        }
        let mut add = |net: Vec<Value>| {
            let (rows, last) = (net.len() / columns, net.len() - 1);
            for corner in [0, columns - 1, (rows - 1) * columns, last] {
                known = known.max(net[corner][0] / net[corner][1]);
            }
            heap.push(Piece { bound: hull(&net).min(piece.bound), net: Ok(net) });
        };
        match piece.net {
            Err(span) => add(make(span)),
            Ok(net) => {
                left -= 1;
                cut(&net, columns).into_iter().for_each(&mut add);
            }
        }
    }
    known
}

/// The largest vertex; where weights are so unequal that one vanishes beside the others, no bound at all.
pub(super) fn hull(net: &[Value]) -> f64 {
    let value = |[x, w]: &Value| if *w > 0.0 { x / w } else { f64::INFINITY };
    net.iter().map(value).fold(f64::NEG_INFINITY, f64::max)
}

/// Halves a net in the direction in which it is less straight: along a straight one the hull is exact already.
fn cut(net: &[Value], columns: usize) -> [Vec<Value>; 2] {
    if is_straighter_in_rows(net, columns) {
        halves(net, net.len() / columns, columns)
    } else {
        halves_of_rows(net, columns)
    }
}

/// Whether a net is as straight in its rows as across them, or straighter.
pub(super) fn is_straighter_in_rows(net: &[Value], columns: usize) -> bool {
    let value = |i: usize| net[i][0] / net[i][1];
    let bend = |i: usize, step: usize| (value(i - step) - 2.0 * value(i) + value(i + step)).abs();
    let inner = columns..net.len().saturating_sub(columns).max(columns);
    let down = inner.map(|i| bend(i, columns)).fold(0.0, f64::max);
    let inside_row = |i: &usize| (1..columns.saturating_sub(1)).contains(&(i % columns));
    let along = (0..net.len()).filter(inside_row).map(|i| bend(i, 1)).fold(0.0, f64::max);
    along <= down
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{any_curve, any_surface, line_of, parameters};
    use super::*;

    /// No sample is outside, and one comes close to each side; `coarse` is what the samples can miss.
    fn check((low, high): (Point, Point), samples: &[Point], size: f64, coarse: f64) {
        let (a, b) = around(samples.iter());
        for axis in 0..3 {
            let (below, above) = (a[axis] - low[axis], high[axis] - b[axis]);
            for gap in [below, above] {
                assert!(gap >= -1e-13 * size, "a sample is outside by {gap}");
                assert!(gap <= coarse * size, "a side is {gap} away");
            }
        }
    }

    /// Samples of a piece, and each place where a coordinate is larger or smaller than beside it, found by ternary
    /// search.
    fn extremes(piece: &Curve) -> Vec<Point> {
        let (a, b) = piece.domain();
        let at: Vec<f64> = parameters(a, b).collect();
        let mut found: Vec<Point> = at.iter().map(|&u| piece.point(u).unwrap()).collect();
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let value = |u: f64| sign * piece.point(u).unwrap()[axis];
            for i in 0..at.len() {
                let (mut low, mut high) = (at[i.saturating_sub(1)], at[(i + 1).min(at.len() - 1)]);
                if value(at[i]) >= value(low).max(value(high)) {
                    for _ in 0..60 {
                        let third = (high - low) / 3.0;
                        let (x, y) = (low + third, high - third);
                        (low, high) = if value(x) < value(y) { (x, high) } else { (low, y) };
                    }
                    found.push(piece.point(low).unwrap());
                }
            }
        }
        found
    }

    proptest! {
        #[test]
        fn a_curve_is_inside_and_touches_every_side(curve in any_curve()) {
            let samples: Vec<Point> = curve.bezier_segments().unwrap().iter().flat_map(extremes).collect();
            check(curve.bounds(), &samples, 20.0, 1e-9);
        }

        #[test]
        fn a_surface_too(surface in any_surface()) {
            let mut samples = Vec::new();
            for patch in surface.bezier_patches().unwrap() {
                let ((a, b), (c, d)) = (patch.u().domain(), patch.v().domain());
                for u in parameters(a, b).step_by(4) {
                    samples.extend(parameters(c, d).step_by(4).map(|v| patch.point(u, v).unwrap()));
                }
            }
            check(surface.bounds(), &samples, 20.0, 0.2);
        }
    }

    #[test]
    fn extremes_of_a_cubic_are_the_roots_of_its_derivative() {
        // x = 3t(1-t)², largest 4/9 at t = 1/3; y = t³; z = -x, anywhere and at any size.
        for scale in [1e-9, 1.0, 1e9] {
            for far in [0.0, 1e6 * scale] {
                let at = |x: f64, y: f64, z: f64| Point::new(x * scale + far, y * scale, z * scale);
                let vertices = [at(0.0, 0.0, 0.0), at(1.0, 0.0, -1.0), at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0)];
                let (low, high) = Curve::bezier(vertices.to_vec()).unwrap().bounds();
                let (a, b) = (at(0.0, 0.0, -4.0 / 9.0), at(4.0 / 9.0, 1.0, 0.0));
                let rounding = 4.0 * f64::EPSILON * far;
                assert!((low - a).amax() <= 2e-12 * scale + rounding, "{low} is not {a}");
                assert!((high - b).amax() <= 2e-12 * scale + rounding, "{high} is not {b}");
            }
        }
    }

    #[test]
    fn the_box_of_a_turned_circle_is_exact() {
        // A circle of three 120° arcs, turned by 0.3: nothing of it is aligned with the axes.
        for radius in [1e-9, 1.0, 1e9] {
            let vertices: Vec<Point> = (0..7)
                .map(|i| {
                    let (angle, r) = (
                        0.3 + std::f64::consts::FRAC_PI_3 * f64::from(i),
                        if i % 2 == 1 { 2.0 } else { 1.0 },
                    );
                    Point::new(r * angle.cos(), r * angle.sin(), 0.0) * radius
                })
                .collect();
            let space = Space::open(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0]).unwrap();
            let weights = (0..7).map(|i| if i % 2 == 1 { 0.5 } else { 1.0 }).collect();
            let circle = Curve::rational(space, vertices, weights).unwrap();
            let (low, high) = circle.bounds();
            let corner = Vector::new(radius, radius, 0.0);
            assert!((low.coords + corner).amax() <= 5e-12 * radius, "{low}");
            assert!((high.coords - corner).amax() <= 5e-12 * radius, "{high}");
            assert!(circle.hull_bounds().0.x < -1.9 * radius);
        }
    }

    #[test]
    fn the_box_of_an_oblique_torus_is_exact() {
        // Along a unit vector e it reaches as far as R √(1 - (e·n)²) + r, with its axis n.
        let axis = Vector::new(1.0, 2.0, 3.0).normalize();
        let across = axis.cross(&Vector::x()).normalize();
        for scale in [1e-9, 1.0, 1e9] {
            let (center, big, small) = (Point::new(5.0, -3.0, 1.0) * scale, 2.0 * scale, 0.5 * scale);
            let ring = Curve::circle(center + across * big, axis.cross(&across), small).unwrap();
            let torus = Surface::revolution(&ring, center, axis, std::f64::consts::TAU).unwrap();
            let (low, high) = torus.bounds();
            for k in 0..3 {
                let reach = big * (1.0 - axis[k] * axis[k]).sqrt() + small;
                assert!((high[k] - center[k] - reach).abs() <= 1e-11 * scale, "{high}");
                assert!((low[k] - center[k] + reach).abs() <= 1e-11 * scale, "{low}");
            }
        }
    }

    #[test]
    fn a_slanted_ridge_is_followed_as_far_as_is_worth_it() {
        // z = -(u - v)², largest along the whole diagonal: the worst case. Bernstein coefficients in blossom form.
        let thirds = [0.0, 0.5, 1.0];
        let squares = [0.0, 0.0, 1.0];
        let mut points = Vec::new();
        for i in 0..3 {
            for j in 0..3 {
                let z = -(squares[i] - 2.0 * thirds[i] * thirds[j] + squares[j]);
                points.push(Point::new(thirds[i], thirds[j], z));
            }
        }
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let (low, high) = Surface::new(space.clone(), space, points).unwrap().bounds();
        assert!((low - Point::new(0.0, 0.0, -1.0)).amax() < 1e-12, "{low}");
        assert!((high - Point::new(1.0, 1.0, 0.0)).amax() < 1e-7 && high.z >= 0.0, "{high}");
    }

    #[test]
    fn vertices_without_a_share_in_the_domain_do_not_count() {
        // The domain starts at 1, where the support of vertex 0 ends.
        let space = Space::open(1, vec![0.0, 1.0, 1.0, 2.0, 3.0]).unwrap();
        let points = [100.0, 1.0, 2.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let curve = Curve::new(space, points).unwrap();
        assert_eq!(curve.hull_bounds().1.x, 2.0);
        assert_eq!(curve.bounds().1.x, 2.0);
    }

    #[test]
    fn far_apart_weights_and_huge_coordinates_are_no_trouble() {
        let space = Space::clamped(2, &[0.0, 1.0]).unwrap();
        let points = vec![Point::origin(), Point::new(1.0, 1.0, 0.0), Point::new(2.0, 0.0, 0.0)];
        for weights in [vec![1e-300, 1e300, 1e-300], vec![5e-324, 1.0, 1e-308], vec![1e308, 1e308, 1e308]] {
            let (low, high) = Curve::rational(space.clone(), points.clone(), weights).unwrap().bounds();
            assert_eq!((low.x, low.y), (0.0, 0.0));
            assert!((high.x - 2.0).abs() < 1e-11 && high.y <= 1.0);
        }
        let huge = vec![Point::new(-1e308, 0.0, 0.0), Point::origin(), Point::new(1e308, 0.0, 0.0)];
        let curve = Curve::new(space, huge).unwrap();
        assert_eq!(curve.bounds(), curve.hull_bounds());
    }

    #[test]
    fn a_hundred_thousand_vertices() {
        // y = sin of the vertex: thousands of places come close to both sides.
        let curve = line_of(3, 100_000);
        let (low, high) = curve.bounds();
        assert_eq!((low.x, high.x), (0.0, 99_999.0));
        // The cubic B-spline damps a wave of 1 radian a vertex by (2 + cos 1) / 3 at its crests.
        let wave = (2.0 + 1_f64.cos()) / 3.0;
        assert!((low.y + wave).abs() < 1e-6, "{low}");
        // The upper side of z is the first vertex, cos 0.
        assert_eq!(high.z, 1.0);
    }
}
