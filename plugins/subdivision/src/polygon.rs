//! Subdivision curves.

mod spline;

use loftsman_kernel::{Point, Vector};

use crate::cage::checked_interval;
use crate::error::{Result, SubdivisionError};

/// How a polygon is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// Chaikin's (1974): the curve is a quadratic spline. Knot intervals belong to vertices.
    Chaikin,
    /// The curve is a cubic spline. Knot intervals belong to edges.
    Cubic,
}

impl Scheme {
    /// The degree of the spline.
    pub fn degree(self) -> usize {
        match self {
            Self::Chaikin => 2,
            Self::Cubic => 3,
        }
    }
}

/// A polygon as the control polygon of a subdivision curve: closed, or open with clamped ends (the curve starts and ends at the
/// first and last vertex, along the first and last edge). Its limit is exactly a spline of the kernel ([`to_curve`](Self::to_curve)).
///
/// Knot intervals are the spans of that spline: of a closed polygon one a vertex (Chaikin) or an edge (cubic, edge `i` after vertex `i`);
/// of an open one with `n` vertices one for each but the first and last vertex (`n - 2`), or edge (`n - 3`). Zeros make it less smooth
/// there. All are 1 unless said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    points: Vec<Point>,
    closed: bool,
    scheme: Scheme,
    /// One a vertex or an edge, zero at the ends of an open polygon.
    intervals: Vec<f64>,
}

impl Polygon {
    /// The polygon of these vertices (without a repeated last one where closed), uniform.
    ///
    /// # Errors
    /// When there are fewer than 3 vertices, or 4 of an open cubic one; when a coordinate is not finite.
    pub fn new(scheme: Scheme, points: Vec<Point>, closed: bool) -> Result<Self> {
        let needed = if closed { 3 } else { scheme.degree() + 1 };
        if points.len() < needed {
            let problem = format!(
                "has {} vertices: at least {needed} are needed for degree {}",
                points.len(),
                scheme.degree()
            );
            return Err(SubdivisionError::Polygon { problem });
        }
        if let Some((vertex, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            let problem = format!("is ({}, {}, {}): coordinates must be finite numbers", p.x, p.y, p.z);
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        let spans = if closed { points.len() } else { points.len() - scheme.degree() };
        let intervals = Self::padded(closed, vec![1.0; spans]);
        Ok(Self { points, closed, scheme, intervals })
    }

    /// The same with knot intervals, each 0 or between 1e-100 and 1e100.
    ///
    /// # Errors
    /// When there are not as many as spans, or one is neither 0 nor in range.
    pub fn with_intervals(mut self, intervals: Vec<f64>) -> Result<Self> {
        let needed = self.spans().len();
        if intervals.len() != needed {
            let problem = format!(
                "has {needed} spans, and {} knot intervals were given: give one for each",
                intervals.len()
            );
            return Err(SubdivisionError::Polygon { problem });
        }
        for (k, &interval) in intervals.iter().enumerate() {
            checked_interval(|| format!("span {k}"), interval)?;
        }
        self.intervals = Self::padded(self.closed, intervals);
        Ok(self)
    }

    fn padded(closed: bool, mut spans: Vec<f64>) -> Vec<f64> {
        if !closed {
            spans.insert(0, 0.0);
            spans.push(0.0);
        }
        spans
    }

    /// The vertices.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The vertices, to be moved.
    pub fn points_mut(&mut self) -> &mut [Point] {
        &mut self.points
    }

    /// Whether the last vertex is joined to the first.
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// How it is refined.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// The knot intervals: the lengths of the spline's spans.
    pub fn spans(&self) -> &[f64] {
        if self.closed { &self.intervals } else { &self.intervals[1..self.intervals.len() - 1] }
    }

    /// The interval a number of places away from place `k`; zero beyond an open end.
    fn interval(&self, k: usize, away: isize) -> f64 {
        let (n, at) = (self.intervals.len() as isize, k as isize + away);
        let at = if self.closed { at.rem_euclid(n) } else { at };
        usize::try_from(at).ok().and_then(|at| self.intervals.get(at)).copied().unwrap_or(0.0)
    }

    /// The vertex a number of places away from vertex `k`; the end itself beyond an open end.
    fn vertex(&self, k: usize, away: isize) -> Vector {
        let (n, at) = (self.points.len() as isize, k as isize + away);
        let at = if self.closed { at.rem_euclid(n) } else { at.clamp(0, n - 1) };
        self.points[at as usize].coords
    }

    /// The polygon refined once: a knot in the middle of every span that has a length. Cost: linear.
    #[must_use]
    pub fn refine(&self) -> Self {
        let mut points = Vec::with_capacity(2 * self.points.len());
        let mut intervals = Vec::with_capacity(2 * self.intervals.len());
        for k in 0..self.points.len() {
            let d = self.interval(k, 0);
            match self.scheme {
                Scheme::Chaikin if d > 0.0 => {
                    // A quarter of the way to each neighbour, by intervals `d / (2 (d + d'))`.
                    for away in [-1, 1] {
                        let part = 0.5 * part(d, self.interval(k, away));
                        points.push(Point::from(self.vertex(k, 0).lerp(&self.vertex(k, away), part)));
                        intervals.push(0.5 * d);
                    }
                }
                Scheme::Chaikin => {
                    points.push(self.points[k]);
                    intervals.push(0.0);
                }
                Scheme::Cubic => {
                    let (before, after) = (self.on_edge(k, -1), self.on_edge(k, 0));
                    let between = before.lerp(&after, part(self.interval(k, -1), d));
                    points.push(Point::from((self.vertex(k, 0) + between) * 0.5));
                    if d > 0.0 {
                        points.push(Point::from(after));
                        intervals.extend([0.5 * d; 2]);
                    } else if k < self.intervals.len() {
                        intervals.push(0.0);
                    }
                }
            }
        }
        Self { points, intervals, ..*self }
    }

    /// The new point of the edge after (0) or before (-1) a vertex of a cubic polygon: the middle, by intervals
    /// `((d + 2 d₊) P + (d + 2 d₋) P₊) / (2 (d₋ + d + d₊))`.
    fn on_edge(&self, k: usize, away: isize) -> Vector {
        let [before, d, after] = [-1, 0, 1].map(|side| self.interval(k, away + side));
        let (start, end) = (self.vertex(k, away), self.vertex(k, away + 1));
        start.lerp(&end, part(d + 2.0 * before, d + 2.0 * after))
    }

    /// The cubic polygon of Chaikin's curve: the same curve, each knot doubled, so that intervals are those of the vertices with zeros
    /// between them. With the point `K` of the curve on each edge a vertex `P` becomes `(K₋ + 2 P)/3` and `(2 P + K₊)/3`; an open one ends
    /// in its own ends. Cost: linear.
    ///
    /// # Errors
    /// When the polygon is cubic already.
    pub fn elevated(&self) -> Result<Self> {
        if self.scheme == Scheme::Cubic {
            let problem = "is cubic already: what is elevated is Chaikin's".to_owned();
            return Err(SubdivisionError::Polygon { problem });
        }
        let on_edge = |k: usize, away: isize| {
            let (a, b) = (self.interval(k, away), self.interval(k, away + 1));
            self.vertex(k, away).lerp(&self.vertex(k, away + 1), part(a, b))
        };
        let (mut points, mut intervals) = (Vec::new(), Vec::new());
        let n = self.points.len();
        for k in 0..n {
            let own = self.vertex(k, 0);
            if !self.closed && (k == 0 || k + 1 == n) {
                points.push(Point::from(own));
                continue;
            }
            points.extend([on_edge(k, -1), on_edge(k, 0)].map(|knot| Point::from((knot + own * 2.0) / 3.0)));
            intervals.extend([self.interval(k, 0), 0.0]);
        }
        if !self.closed {
            intervals.pop();
        }
        Self::new(Scheme::Cubic, points, self.closed)?.with_intervals(intervals)
    }

    /// The polygon refined so many times.
    #[must_use]
    pub fn refine_times(&self, times: usize) -> Self {
        (0..times).fold(self.clone(), |polygon, _| polygon.refine())
    }

    /// Points of the curve at its knots, in order: of a cubic polygon for each vertex (of an open one the ends are its own, and what
    /// lies next to them is there as well), of Chaikin's one on each edge. Cost: linear.
    pub fn limit_points(&self) -> Vec<Point> {
        let n = self.points.len();
        match self.scheme {
            Scheme::Chaikin => {
                let edges = if self.closed { n } else { n - 1 };
                let on_edge = |k: usize| {
                    let part = part(self.interval(k, 0), self.interval(k, 1));
                    Point::from(self.vertex(k, 0).lerp(&self.vertex(k, 1), part))
                };
                (0..edges).map(on_edge).collect()
            }
            Scheme::Cubic => {
                let vertices = if self.closed { 0..n } else { 1..n - 1 };
                let at_vertex = |k: usize| {
                    let [far_before, before, after, far_after] =
                        [-2, -1, 0, 1].map(|away| self.interval(k, away));
                    let own = self.vertex(k, 0);
                    let back = own.lerp(&self.vertex(k, -1), part(after, before + far_before));
                    let forth = own.lerp(&self.vertex(k, 1), part(before, after + far_after));
                    Point::from(back.lerp(&forth, part(before, after)))
                };
                vertices.map(at_vertex).collect()
            }
        }
    }
}

/// `a / (a + b)`; of nothing, nothing.
fn part(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { a / (a + b) } else { 0.0 }
}
