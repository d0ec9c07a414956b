//! A cell as triangles: of all ways to draw them between the vertices around it the one whose worst triangle is best.

use loftsman_kernel::Vector;

use crate::bezier::more;
use crate::fineness::Target;
use crate::form::{Form, Ranges};
use crate::topology::Poles;
use crate::tree::{Cell, Tree, Vertex};

/// Above this many choices the triangles are not chosen by their certified error, but by their edges' lengths.
const CHOICES: usize = 64;

/// Where the patch is further (in tolerances) from an edge, no triangle that has it will do: however that one lies, how far
/// the patch is from the edge counts, across the triangle or within it. (It is measured across the cell, whose normal is not
/// quite the triangle's: a cell that barely meets the target may be cut for that.)
pub(crate) const HOPELESS_EDGE: f64 = 1.0;

/// Where the patch is so many times further from a diagonal than the triangles along the other one cost, those along this one,
/// which are no nearer than it, are not looked at. (What is more than 1 is for the normals, which are not quite the cell's.)
const WORSE_DIAGONAL: f64 = 1.25;

/// What a triangle costs that is further from the patch than is of use.
const FAR: f64 = f64::MAX;

/// The plane of a triangle, and how far the patch is from it over the triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Of any length.
    pub(crate) normal: Vector,
    pub(crate) error: f64,
}

impl Plane {
    /// That of three vertices.
    pub(crate) fn of(corners: [&Vertex; 3], form: &Form) -> Self {
        Self::with(corners, form, normal_of(corners))
    }

    /// The one with this normal.
    pub(crate) fn with(corners: [&Vertex; 3], form: &Form, normal: Vector) -> Self {
        let error = form.across(&normal, &corners[0].point).triangle(corners.map(|v| v.at));
        Self { normal, error }
    }
}

/// A triangle, counterclockwise in parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    pub(crate) corners: [u32; 3],
    /// Its plane, where that is known from choosing it.
    pub(crate) plane: Option<Plane>,
}

/// The best way to go on from a pair of vertices, one on either chain.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// What the worst triangle from here on costs.
    worst: f64,
    /// Whether the first one goes ahead on the near chain.
    near: bool,
    /// The plane of the first one.
    plane: Option<Plane>,
}

/// The triangles of one cell; its room is used again from cell to cell.
#[derive(Debug, Default)]
pub(crate) struct Triangulation {
    sides: [Vec<u32>; 4],
    near: Vec<u32>,
    far: Vec<u32>,
    table: Vec<Step>,
    pub(crate) triangles: Vec<Triangle>,
}

impl Triangulation {
    /// Takes the vertices around a cell; their number.
    pub(crate) fn look(&mut self, tree: &Tree, cell: &Cell) -> usize {
        for (k, side) in self.sides.iter_mut().enumerate() {
            side.clear();
            tree.chain(cell, k, side);
        }
        self.sides.iter().map(Vec::len).sum()
    }

    /// Triangulates the cell last looked at, or not: false where it `may_fail` and every way has a triangle that is further
    /// from the patch than the tolerance.
    pub(crate) fn choose(&mut self, costs: &Costs<'_>, may_fail: bool) -> bool {
        let limit = if may_fail { costs.target.chord } else { f64::INFINITY };
        let worst = self.find_best(costs, limit);
        if worst >= FAR && worst.is_finite() {
            return false;
        }
        if may_fail && worst > 1.001 * limit {
            // A triangle is turned over, and one that is too far may still cost less.
            self.find_best(costs, f64::INFINITY);
        }
        true
    }

    /// Triangulates between two chains of vertices: from one end to the other, each triangle takes a step on one of them.
    ///
    /// The steps are chosen so that the worst triangle is best (dynamic programming over all ways); of long chains by
    /// the shorter of the two next diagonals. What the worst one costs, as far as that is known: [`FAR`] where all ways have
    /// a triangle that is further from the patch than `limit`.
    fn find_best(&mut self, costs: &Costs<'_>, limit: f64) -> f64 {
        self.triangles.clear();
        if let [&[a], &[b], &[c], &[d]] = self.sides.each_ref().map(Vec::as_slice) {
            return self.find_diagonal(costs, limit, [a, b, c, d]);
        }
        self.chains();
        let (n, m) = (self.near.len(), self.far.len());
        if n * m > CHOICES {
            self.zip(costs.vertices);
            return 0.0;
        }
        self.table.clear();
        self.table.resize(n * m, Step { worst: f64::INFINITY, near: false, plane: None });
        self.table[n * m - 1].worst = 0.0;
        for at in (0..n * m - 1).rev() {
            let (j, i) = (at / m, at % m);
            if at > 0 && costs.bend([self.near[j], self.far[i]]) > HOPELESS_EDGE * limit {
                self.table[at].worst = FAR;
                continue;
            }
            let mut best = self.table[at];
            for near in [true, false] {
                let next = match near {
                    true if j + 1 < n => at + m,
                    false if i + 1 < m => at + 1,
                    _ => continue,
                };
                let rest = self.table[next].worst;
                if rest < best.worst {
                    let mut first = Triangle { corners: self.ahead(j, i, near), plane: None };
                    let worst = costs.add(rest, &mut first, limit);
                    if worst < best.worst {
                        best = Step { worst, near, plane: first.plane };
                    }
                }
            }
            self.table[at] = best;
        }
        let (mut j, mut i) = (0, 0);
        while j + 1 < n || i + 1 < m {
            let step = self.table[j * m + i];
            let near = i + 1 == m || (j + 1 < n && step.near);
            self.triangles.push(Triangle { corners: self.ahead(j, i, near), plane: step.plane });
            *(if near { &mut j } else { &mut i }) += 1;
        }
        self.table[0].worst
    }

    /// The best way for a cell that has no vertices but its corners: along one of its diagonals.
    fn find_diagonal(&mut self, costs: &Costs<'_>, limit: f64, [a, b, c, d]: [u32; 4]) -> f64 {
        let mut ways = [[[a, b, d], [b, c, d]], [[a, c, d], [a, b, c]]]
            .map(|way| way.map(|corners| Triangle { corners, plane: None }));
        let (mut least, mut best) = (f64::INFINITY, 1);
        // The more promising first, so that half of the other will often do; where they are alike it is the first.
        let bends = [[b, d], [a, c]].map(|ends| costs.bend(ends));
        for way in if bends[1] < bends[0] { [1, 0] } else { [0, 1] } {
            let better = |worst: f64, least: f64| worst < least || (worst == least && way == 0);
            let [one, two] = &mut ways[way];
            if bends[way] > WORSE_DIAGONAL * least {
                break;
            }
            let start = if bends[way] > HOPELESS_EDGE * limit { FAR } else { 0.0 };
            let rest = costs.add(start, two, limit);
            if better(rest, least) {
                let worst = costs.add(rest, one, limit);
                if better(worst, least) {
                    (least, best) = (worst, way);
                }
            }
        }
        self.triangles.extend_from_slice(&ways[best]);
        least
    }

    /// The chords around the cell last looked at, each from its one vertex to its next.
    pub(crate) fn border(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let around = self.sides.iter().flatten();
        around.clone().zip(around.clone().skip(1).chain(around.take(1))).map(|(from, to)| (*from, *to))
    }

    /// The same triangles in another state, where their planes are others.
    pub(crate) fn move_on(&mut self) {
        self.triangles.iter_mut().for_each(|triangle| triangle.plane = None);
    }

    /// The normal of the triangle beside one that a pole has made an edge.
    pub(crate) fn neighbour(&self, vertices: &[Vertex], index: usize, poles: &Poles) -> Option<Vector> {
        let thin = self.triangles[index].corners;
        let shares = |t: &[u32; 3]| t.iter().filter(|k| thin.contains(k)).count() == 2;
        let whole = |t: &[u32; 3]| poles.same(t.map(|k| vertices[k as usize].at)) == [false; 3];
        let found = self.triangles.iter().map(|t| t.corners).find(|t| shares(t) && whole(t))?;
        Some(normal_of(found.map(|k| &vertices[k as usize])))
    }

    /// Sorts the vertices around the cell into two chains that run the same way: the side with the most vertices,
    /// and all others.
    fn chains(&mut self) {
        let most = (0..4).max_by_key(|&k| (self.sides[k].len(), 4 - k)).unwrap_or(0);
        let [_, right, top, left] = [0, 1, 2, 3].map(|k| (most + k) % 4);
        self.near.clone_from(&self.sides[most]);
        self.near.push(self.sides[right][0]);
        self.far.clear();
        self.far.extend(self.sides[left][1..].iter().rev());
        self.far.push(self.sides[left][0]);
        self.far.extend(self.sides[top].iter().rev());
        self.far.extend(self.sides[right][1..].iter().rev());
    }

    /// The triangle that takes the next step on the near chain, or on the far one.
    fn ahead(&self, j: usize, i: usize, near: bool) -> [u32; 3] {
        let next = if near { self.near[j + 1] } else { self.far[i + 1] };
        [self.near[j], next, self.far[i]]
    }

    /// Long chains: by the shorter diagonal.
    fn zip(&mut self, vertices: &[Vertex]) {
        let (n, m) = (self.near.len(), self.far.len());
        let (mut j, mut i) = (0, 0);
        let at = |k: u32| vertices[k as usize].at;
        let point = |k: u32| vertices[k as usize].point;
        while j + 1 < n || i + 1 < m {
            let valid = |x: u32, y: u32, z: u32| area(at(x), at(y), at(z)) > 0.0;
            // The last vertex of the near side waits for those of the side that ends there.
            let waits = j + 2 == n
                && i + 1 < m
                && !(i + 2 == m && valid(self.near[n - 1], self.far[m - 1], self.far[i]));
            let step_near = j + 1 < n && !waits;
            let step_far = i + 1 < m && valid(self.near[j], self.far[i + 1], self.far[i]);
            let near_first = match (step_near, step_far) {
                (true, true) => {
                    (point(self.near[j + 1]) - point(self.far[i])).norm_squared()
                        < (point(self.near[j]) - point(self.far[i + 1])).norm_squared()
                }
                (near, far) => near || (!far && j + 1 < n),
            };
            self.triangles.push(Triangle { corners: self.ahead(j, i, near_first), plane: None });
            *(if near_first { &mut j } else { &mut i }) += 1;
        }
    }
}

/// What triangles of a cell cost.
pub(crate) struct Costs<'a> {
    pub(crate) form: &'a Form,
    /// The second derivatives across the cell.
    pub(crate) ranges: Ranges,
    pub(crate) vertices: &'a [Vertex],
    pub(crate) poles: &'a Poles,
    pub(crate) target: &'a Target,
}

impl Costs<'_> {
    /// How far the patch is from an edge, across the cell.
    fn bend(&self, ends: [u32; 2]) -> f64 {
        let [from, to] = ends.map(|k| self.vertices[k as usize].at);
        self.ranges.along(from, to)
    }

    /// The larger of a cost and that of a triangle, which gets its plane, if that is to be found.
    fn add(&self, rest: f64, triangle: &mut Triangle, limit: f64) -> f64 {
        if rest >= FAR {
            return rest;
        }
        more(rest, self.of(triangle, limit))
    }

    /// What is wrong with a triangle: its distance from the patch; among those that hardly differ the length of its longest
    /// edge; far too much where it is turned over or has no area in parameters. It gets its plane, if it has one.
    fn of(&self, triangle: &mut Triangle, limit: f64) -> f64 {
        let corners = triangle.corners.map(|k| &self.vertices[k as usize]);
        let ([a, b, c], chord) = (corners, self.target.chord);
        if area(a.at, b.at, c.at) <= 0.0 {
            return f64::INFINITY;
        }
        if self.poles.same(corners.map(|v| v.at)) != [false; 3] {
            return 0.0;
        }
        let plane = Plane::of(corners, self.form);
        if plane.error > limit {
            return FAR;
        }
        triangle.plane = Some(plane);
        let edges = [b.point - a.point, c.point - b.point, a.point - c.point];
        let long = edges.iter().map(Vector::norm_squared).fold(0.0, more).sqrt();
        let turned = corners.iter().any(|v| v.normal.dot(&plane.normal) < 0.0);
        let scale = if turned { 4.0 } else { 1.0 };
        scale * more(0.05 * chord, plane.error) + 1e-6 * chord * long
    }
}

/// Twice the area of a triangle of parameters (exact: they are dyadic fractions).
fn area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// A normal of a triangle, of any length; where its corners are in line, one across that line nearest to the surface's.
#[inline]
pub(crate) fn normal_of([a, b, c]: [&Vertex; 3]) -> Vector {
    let (s, t) = (b.point - a.point, c.point - a.point);
    let cross = s.cross(&t);
    if cross.norm_squared() > 1e-24 * s.norm_squared() * t.norm_squared() {
        return cross;
    }
    normal_across([a, b, c], s, t)
}

/// One across the line of corners that are in line, `s` and `t` from the first to the others.
#[cold]
fn normal_across([a, b, c]: [&Vertex; 3], s: Vector, t: Vector) -> Vector {
    let line = if s.norm_squared() > t.norm_squared() { s } else { t };
    let line = line.try_normalize(0.0).unwrap_or_default();
    let mean = a.normal + b.normal + c.normal;
    let any = Vector::ith(line.iamin(), 1.0);
    let off = |n: Vector| (n - line * n.dot(&line)).try_normalize(1e-6);
    off(mean).or_else(|| off(any)).unwrap_or_else(Vector::z)
}
