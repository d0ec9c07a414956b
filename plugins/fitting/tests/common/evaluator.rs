//! De Boor's algorithm by the book, and what can be measured with it. Slow, and independent of the kernel.

use loftsman_fitting::FittedCurve;
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// A curve as its numbers: knots with those that a periodic curve continues by, and the vertex of each B-spline.
pub(crate) struct Spline {
    degree: usize,
    knots: Vec<f64>,
    vertices: Vec<Vector>,
    pub(crate) start: f64,
    pub(crate) end: f64,
}

impl Spline {
    /// Reads knots and vertices as the document has them. Lengths are measured in units of `size`.
    pub(crate) fn of(curve: &Curve, size: f64) -> Self {
        assert!(curve.weights().is_none());
        let points = curve.points().iter().map(|q| q.coords / size).collect();
        Self::from_parts(curve.space(), points)
    }

    /// A spline of vertices over the knots of a space.
    pub(crate) fn from_parts(space: &Space, points: Vec<Vector>) -> Self {
        let (p, given, n) = (space.degree(), space.knots(), points.len());
        if !space.is_periodic() {
            assert_eq!(given.len(), n + p + 1);
            return Self {
                degree: p,
                knots: given.to_vec(),
                vertices: points,
                start: given[p],
                end: given[n],
            };
        }
        // Vertex i has the B-spline whose support starts at knot i; both repeat after n.
        assert_eq!(given.len(), n + 1);
        let period = given[n] - given[0];
        let at = |k: i64| {
            let turn = k.div_euclid(n as i64);
            given[k.rem_euclid(n as i64) as usize] + turn as f64 * period
        };
        let p64 = p as i64;
        Self {
            degree: p,
            knots: (-p64..=(n + p) as i64).map(at).collect(),
            vertices: (-p64..n as i64).map(|k| points[k.rem_euclid(n as i64) as usize]).collect(),
            start: given[0],
            end: given[n],
        }
    }

    /// `C(u)`; a periodic curve's parameter is brought into its domain first.
    pub(crate) fn at(&self, u: f64) -> Vector {
        let length = self.end - self.start;
        let u = if u < self.start {
            u + length
        } else if u > self.end {
            u - length
        } else {
            u
        };
        let (p, t) = (self.degree, &self.knots);
        let last = self.vertices.len() - 1;
        let mut j = (t.partition_point(|&k| k <= u).max(p + 1) - 1).min(last);
        while t[j] == t[j + 1] {
            j -= 1;
        }
        let mut d: Vec<Vector> = (0..=p).map(|i| self.vertices[j - p + i]).collect();
        for r in 1..=p {
            for i in (r..=p).rev() {
                let (a, b) = (t[j - p + i], t[j + 1 + i - r]);
                let share = (u - a) / (b - a);
                d[i] = d[i - 1] * (1.0 - share) + d[i] * share;
            }
        }
        d[p]
    }

    /// Points of the curve, `each` on every knot span, in order; parameters with them.
    pub(crate) fn samples(&self, each: usize) -> Vec<(f64, Vector)> {
        let mut breaks: Vec<f64> =
            self.knots.iter().copied().filter(|&k| k >= self.start && k <= self.end).collect();
        breaks.dedup();
        let mut all = Vec::new();
        for w in breaks.windows(2) {
            all.extend(
                (0..each).map(|i| w[0] + (w[1] - w[0]) * i as f64 / each as f64).map(|u| (u, self.at(u))),
            );
        }
        all.push((self.end, self.at(self.end)));
        all
    }

    /// The distance of `q` from the curve: from the nearest of the samples and between its neighbours, by the golden
    /// section; likewise from any other sample that is nearer than those beside it.
    pub(crate) fn distance(&self, samples: &[(f64, Vector)], q: Vector) -> f64 {
        let far: Vec<f64> = samples.iter().map(|s| (s.1 - q).norm()).collect();
        let least = far.iter().copied().fold(f64::INFINITY, f64::min);
        let mut found = least;
        let last = samples.len() - 1;
        for i in 0..=last {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(last));
            let reach =
                (samples[before].1 - samples[i].1).norm().max((samples[after].1 - samples[i].1).norm());
            if far[i] > far[before] || far[i] > far[after] || far[i] - 2.0 * reach > found {
                continue;
            }
            let (mut a, mut b) = (samples[before].0, samples[after].0);
            let golden = 0.618_033_988_749_894_9;
            for _ in 0..90 {
                let (c, d) = (b - golden * (b - a), a + golden * (b - a));
                let (fc, fd) = ((self.at(c) - q).norm(), (self.at(d) - q).norm());
                found = found.min(fc).min(fd);
                if fc < fd { b = d } else { a = c }
            }
        }
        found
    }
}

/// The length of a chain of points.
pub(crate) fn length(points: &[Vector]) -> f64 {
    points.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

/// The length of the polygon of points, in units of `size`.
pub(crate) fn polygon(points: &[Point], closed: bool, size: f64) -> f64 {
    let mut chain: Vec<Vector> = points.iter().map(|p| p.coords / size).collect();
    if closed {
        chain.push(chain[0]);
    }
    length(&chain)
}

/// The largest coordinate.
pub(crate) fn size(points: &[Point]) -> f64 {
    points.iter().fold(0.0_f64, |m, p| m.max(p.coords.amax()))
}

/// The extent of points in units of `size`.
pub(crate) fn spread(points: &[Point], size: f64) -> f64 {
    points.iter().fold(0.0_f64, |m, p| m.max((p.coords / size - points[0].coords / size).amax()))
}

/// The extent of points.
pub(crate) fn extent(points: &[Point]) -> f64 {
    spread(points, size(points)) * size(points)
}

/// Longer than this many times their polygon curves are to be refused.
pub(crate) const LONGEST: f64 = 2.0;

/// Everything that a fit says of its curve, measured again, and that it goes where the points go.
pub(crate) fn holds(fitted: &FittedCurve, points: &[Point], closed: bool, what: &str) {
    let size = size(points);
    let spline = Spline::of(&fitted.curve, size);
    let few = fitted.curve.points().len() < 60;
    let samples = spline.samples(if few { 16 * (1 + fitted.curve.degree()) } else { 24 });
    let line: Vec<Vector> = samples.iter().map(|s| s.1).collect();
    let (long, chain) = (length(&line), polygon(points, closed, size));
    // Evaluation rounds at the size of the vertices, the fit's own coordinates at the points' extent.
    let vertices = fitted.curve.points().iter().fold(1.0_f64, |m, p| m.max(p.coords.amax() / size));
    let rounding = 2e-14 * (2 + fitted.curve.degree()) as f64 * (vertices + spread(points, size).recip());
    assert!(
        long <= LONGEST * chain + rounding * line.len() as f64,
        "{what}: {long} long, the polygon {chain}"
    );
    assert!(
        !fitted.length.is_finite() && long > f64::MAX / size
            || (long - fitted.length / size).abs() <= 0.02 * long + rounding * line.len() as f64,
        "{what}: says {:e}, is {long}",
        fitted.length / size
    );
    let beyond = !fitted.polygon_length.is_finite() && chain > f64::MAX / size;
    assert!(beyond || (chain - fitted.polygon_length / size).abs() <= 1e-9 * chain + rounding, "{what}");
    // Distances at the parameters, and the true ones.
    let (mut worst, mut nearest) = (0.0_f64, 0.0_f64);
    for (u, point) in fitted.parameters.iter().zip(points) {
        let q = point.coords / size;
        let there = (spline.at(*u) - q).norm();
        worst = worst.max(there);
        nearest = nearest.max(spline.distance(&samples, q).min(there));
    }
    let says = [fitted.max_error / size, fitted.distance / size];
    assert!((worst - says[0]).abs() <= rounding + 1e-9 * worst, "{what}: {worst:e}, says {says:?}");
    assert!((nearest - says[1]).abs() <= rounding + 1e-3 * worst, "{what}: {nearest:e}, says {says:?}");
    if let (true, Some(tolerance)) = (fitted.met, fitted.tolerance) {
        assert!(worst <= tolerance / size * (1.0 + 1e-6) + rounding, "{what}: {worst:e}");
    }
    assert!(fitted.parameters.windows(2).all(|w| w[0] <= w[1]), "{what}: the order of the points is lost");
    forwards(fitted, &spline, points, worst, what);
}

/// At every point that is well apart from its neighbours, by secants of the curve: it is not passed backwards.
fn forwards(fitted: &FittedCurve, spline: &Spline, points: &[Point], worst: f64, what: &str) {
    let m = fitted.parameters.len();
    let size = size(points);
    for k in 1..m - 1 {
        let (a, b) = ((points[k] - points[k - 1]) / size, (points[k + 1] - points[k]) / size);
        let least = a.norm().min(b.norm());
        let course = a.normalize() + b.normalize();
        let sharp = course.norm() < 0.36;
        if sharp || least <= 20.0 * worst + 1e-7 || fitted.corners.contains(&k) {
            continue;
        }
        let (before, u, after) = (fitted.parameters[k - 1], fitted.parameters[k], fitted.parameters[k + 1]);
        let step = 1e-6 * (after - before);
        let along = spline.at(u + step) - spline.at(u - step);
        if along.dot(&course) >= -1e-3 * along.norm() * course.norm() - 1e-12 {
            continue;
        }
        // Back it goes: by more than what the points leave open?
        let (mut farthest, mut back) = (f64::NEG_INFINITY, 0.0_f64);
        for i in 0..=100 {
            let reached =
                spline.at(before + (after - before) * f64::from(i) / 100.0).dot(&course) / course.norm();
            farthest = farthest.max(reached);
            back = back.max(farthest - reached);
        }
        assert!(back <= 2.1 * worst + 1e-12, "{what}: back by {back:e} at point {k}");
    }
}
