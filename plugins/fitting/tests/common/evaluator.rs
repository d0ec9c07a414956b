//! De Boor's algorithm by the book, and what can be measured with it. Slow, and independent of the kernel.

use loftsman_kernel::spline::Curve;
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
        let p = curve.degree();
        let given = curve.space().knots();
        let points: Vec<Vector> = curve.points().iter().map(|q| q.coords / size).collect();
        let n = points.len();
        if !curve.is_periodic() {
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
            for _ in 0..60 {
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
