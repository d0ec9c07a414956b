//! Which closed shells lie within which, by a mesh of them.

use std::f64::consts::TAU;

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::{Point, Vector};

/// A shell is where most of so many of its points are.
const PLACES: usize = 15;

/// The triangles of one shell.
pub(super) struct Hull {
    triangles: Vec<[Point; 3]>,
    low: Point,
    high: Point,
    /// Six times its volume: negative where its triangles look inward.
    pub(super) volume: f64,
}

impl Hull {
    /// Those of the triangles of each shell, where a mesh says which face a triangle is of, and `shell` in which of `count` that is. `O(triangles)`.
    pub(super) fn all(
        mesh: &Mesh,
        faces: &[usize],
        count: usize,
        shell: impl Fn(usize) -> usize,
    ) -> Vec<Self> {
        let point = |k: u32| mesh.points()[k as usize];
        let mut lists = vec![Vec::new(); count];
        for (t, &face) in mesh.corners().chunks_exact(3).zip(faces) {
            lists[shell(face)].push([point(t[0]), point(t[1]), point(t[2])]);
        }
        lists.into_iter().map(Self::new).collect()
    }

    fn new(triangles: Vec<[Point; 3]>) -> Self {
        let first = triangles.first().map(|t| t[0]).unwrap_or_default();
        let points = || triangles.iter().flatten();
        let low = points().fold(first, |low, p| low.inf(p));
        let high = points().fold(first, |high, p| high.sup(p));
        let volume =
            triangles.iter().map(|t| t.map(|p| p - first)).map(|[a, b, c]| a.dot(&b.cross(&c))).sum();
        Self { triangles, low, high, volume }
    }

    /// Whether it is a body: of twice its volume over its area, how thick a plate would be, more is left than what vertices are moved by.
    pub(super) fn is_thicker_than(&self, near: f64) -> bool {
        let area: f64 = self.triangles.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum();
        self.volume.abs() / 6.0 > 0.5 * near * area
    }

    /// Whether it lies within another: not within its box means not, else where most of its points are. `O(triangles)` of the other.
    pub(super) fn is_within(&self, other: &Self) -> bool {
        if (0..3).any(|k| self.low[k] < other.low[k] || self.high[k] > other.high[k]) {
            return false;
        }
        let step = self.triangles.len().div_ceil(PLACES).max(1);
        let places: Vec<Point> = self.triangles.iter().step_by(step).map(|t| t[0]).collect();
        let within = places.iter().filter(|place| other.turns_around(place).abs() > 0.5).count();
        2 * within > places.len()
    }

    /// How often it goes around a point: the solid angles of its triangles, `tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)` (Van
    /// Oosterom and Strackee 1983), over `4π`.
    fn turns_around(&self, point: &Point) -> f64 {
        let angle = |t: &[Point; 3]| {
            let [a, b, c]: [Vector; 3] = t.map(|p| p - point);
            let [x, y, z] = [a.norm(), b.norm(), c.norm()];
            let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
            a.dot(&b.cross(&c)).atan2(below)
        };
        self.triangles.iter().map(angle).sum::<f64>() / TAU
    }
}
