//! Surfaces as meshes: a grid of parameter lines, welded at seams and poles, two triangles a cell.

use loftsman_kernel::mesh::{Layer, Mesh};
use loftsman_kernel::plugin::Fineness;
use loftsman_kernel::spline::{Space, Surface};
use loftsman_kernel::{Point, Result, Vector};

use crate::evaluate::Evaluator;
use crate::fineness::{Frame, Target};
use crate::lines::{Lines, Stretch, choose, too_many};
use crate::normals::{limit, unit_normal};
use crate::weld::Welds;

/// Points closer than this fraction of the surface's size are one point. Rounding in the evaluation of a pole or
/// of two edges that coincide is a hundred times smaller.
const ONE_POINT: f64 = 1e-12;

/// Normals of one vertex that differ by less than this are one normal.
const AGREE: f64 = 1e-6;

/// The mesh of a surface.
pub(crate) fn mesh(surface: &Surface, fineness: &Fineness, budget: usize) -> Result<Mesh> {
    let frame = Frame::of(surface.points())?;
    let target = target(surface, &frame, fineness)?;
    let lines = choose(surface, &frame, &target, fineness, budget)?;
    Net::build(surface, &frame, &lines)?.into_mesh(surface, &frame)
}

/// The fineness in the surface's frame; a relative one by points at the ends and the middle of every span.
fn target(surface: &Surface, frame: &Frame, fineness: &Fineness) -> Result<Target> {
    let evaluator = Evaluator::new(surface, frame);
    let thirds = |space: &Space| -> Vec<(usize, f64)> {
        let flat = space.flat();
        let ends = space.spans().flat_map(|s| {
            let (a, b) = (flat[s], flat[s + 1]);
            [(s, a), (s, a + (b - a) * 0.5), (s, b)]
        });
        ends.collect()
    };
    let (us, vs) = (thirds(surface.u()), thirds(surface.v()));
    let mut row = evaluator.row();
    let mut corners: Option<(Vector, Vector)> = None;
    for &(span, u) in &us {
        evaluator.prepare(span, u, &mut row);
        for &(span, v) in &vs {
            let p = evaluator.at(&row, span, v).point;
            let (low, high) = corners.unwrap_or((p, p));
            corners = Some((low.inf(&p), high.sup(&p)));
        }
    }
    let (low, high) = corners.unwrap_or_default();
    let place = |p: Vector| frame.centre + p * frame.size;
    frame.target(fineness, [place(low), place(high)])
}

/// A line of the grid: its parameter, the span it is seen from, and the span before it where the surface may have
/// a crease or a seam there.
#[derive(Debug, Clone, Copy)]
struct Line {
    span: usize,
    at: f64,
    before: Option<(usize, f64)>,
}

/// The lines of one direction. Where periodic the last one is the first.
fn lines_of(space: &Space, stretches: &[Stretch]) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    let mut previous: Option<&Stretch> = None;
    for s in stretches {
        for k in 0..s.n {
            let before = previous.filter(|_| k == 0).map(|t| (t.span, t.b));
            let crease =
                before.is_some_and(|(span, at)| span != s.span && space.multiplicity(at) >= space.degree());
            lines.push(Line { span: s.span, at: s.at(k), before: before.filter(|_| crease) });
        }
        previous = Some(s);
    }
    if let Some(last) = previous {
        if space.is_periodic() {
            if let Some(first) = lines.first_mut() {
                first.before = Some((last.span, last.b));
            }
        } else {
            lines.push(Line { span: last.span, at: last.b, before: None });
        }
    }
    lines
}

/// The grid of points with normals, before welding.
struct Net {
    u: Vec<Line>,
    v: Vec<Line>,
    points: Vec<Vector>,
    normals: Vec<Option<Vector>>,
}

impl Net {
    fn build(surface: &Surface, frame: &Frame, lines: &Lines) -> Result<Self> {
        let (u, v) = (lines_of(surface.u(), &lines.u), lines_of(surface.v(), &lines.v));
        let count = u.len().checked_mul(v.len()).filter(|&n| n < u32::MAX as usize);
        let Some(count) = count else { return Err(too_many(usize::MAX)) };
        let evaluator = Evaluator::new(surface, frame);
        let (mut row, mut other) = (evaluator.row(), evaluator.row());
        let (mut points, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for line in &u {
            evaluator.prepare(line.span, line.at, &mut row);
            if let Some((span, at)) = line.before {
                evaluator.prepare(span, at, &mut other);
            }
            for column in &v {
                let jet = evaluator.at(&row, column.span, column.at);
                points.push(jet.point);
                let mut normal = unit_normal(&jet);
                // Both sides of a crease have their say; where there is none they agree.
                let mut add =
                    |more: Option<Vector>| normal = normal.zip(more).map(|(a, b)| a + b).or(normal).or(more);
                if let Some((span, at)) = column.before {
                    add(unit_normal(&evaluator.at(&row, span, at)));
                }
                if line.before.is_some() {
                    add(unit_normal(&evaluator.at(&other, column.span, column.at)));
                    if let Some((span, at)) = column.before {
                        add(unit_normal(&evaluator.at(&other, span, at)));
                    }
                }
                normals.push(normal.and_then(|n| n.try_normalize(0.1)));
            }
        }
        Ok(Self { u, v, points, normals })
    }

    /// Joins neighbours on the grid that coincide, and opposite edges that do.
    fn welds(&self) -> Welds {
        let (rows, columns) = (self.u.len(), self.v.len());
        let mut welds = Welds::new(self.points.len());
        let same = |a: usize, b: usize| (self.points[a] - self.points[b]).norm() <= ONE_POINT;
        for i in 0..rows {
            for j in 0..columns {
                let here = i * columns + j;
                if j + 1 < columns && same(here, here + 1) {
                    welds.join(here, here + 1);
                }
                if i + 1 < rows && same(here, here + columns) {
                    welds.join(here, here + columns);
                }
            }
        }
        let last_row = (rows - 1) * columns;
        if rows > 2 && (0..columns).all(|j| same(j, last_row + j)) {
            (0..columns).for_each(|j| welds.join(j, last_row + j));
        }
        if columns > 2 && (0..rows).all(|i| same(i * columns, (i + 1) * columns - 1)) {
            (0..rows).for_each(|i| welds.join(i * columns, (i + 1) * columns - 1));
        }
        welds
    }

    fn into_mesh(mut self, surface: &Surface, frame: &Frame) -> Result<Mesh> {
        let mut welds = self.welds();
        self.settle_normals(surface, &mut welds)?;
        let (rows, columns) = (self.u.len(), self.v.len());
        // Numbers the sets in the order of their first points.
        let mut number = vec![u32::MAX; self.points.len()];
        let (mut points, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
        let ((u0, u1), (v0, v1)) = (surface.u().domain(), surface.v().domain());
        for i in 0..rows {
            for j in 0..columns {
                let here = i * columns + j;
                let root = welds.root(here);
                if root == here {
                    number[here] = points.len() as u32;
                    points.push(frame.centre + self.points[here] * frame.size);
                    normals.push(self.normals[here]);
                    uvs.push([(self.u[i].at - u0) / (u1 - u0), (self.v[j].at - v0) / (v1 - v0)]);
                } else {
                    number[here] = number[root];
                }
            }
        }
        let corners = self.triangles(surface, &number);
        let normals = fill_normals(normals, &points, &corners);
        let starts = (0..=corners.len() / 3).map(|f| 3 * f).collect();
        let mut mesh = Mesh::from_parts(points, corners, starts)?;
        (mesh.normals, mesh.uvs) = (Layer::per_point(normals), Layer::per_point(uvs));
        Ok(mesh)
    }

    /// Two triangles a cell, cut along its shorter diagonal; those that welding has made edges are left out.
    fn triangles(&self, surface: &Surface, number: &[u32]) -> Vec<u32> {
        let (rows, columns) = (self.u.len(), self.v.len());
        let cells_u = if surface.u().is_periodic() { rows } else { rows - 1 };
        let cells_v = if surface.v().is_periodic() { columns } else { columns - 1 };
        let mut corners = Vec::with_capacity(6 * cells_u * cells_v);
        for i in 0..cells_u {
            let next_i = (i + 1) % rows;
            for j in 0..cells_v {
                let next_j = (j + 1) % columns;
                let cell =
                    [i * columns + j, next_i * columns + j, next_i * columns + next_j, i * columns + next_j];
                let across =
                    |a: usize, b: usize| (self.points[cell[a]] - self.points[cell[b]]).norm_squared();
                let [a, b, c, d] = cell.map(|k| number[k]);
                let pair =
                    if across(1, 3) < across(0, 2) { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
                for [a, b, c] in pair {
                    if a != b && b != c && c != a {
                        corners.extend([a, b, c]);
                    }
                }
            }
        }
        corners
    }

    /// Gives every set of welded points one normal: what its points have, or their limits where the surface is
    /// singular. Where they do not agree (the apex of a cone, a seam with a crease) it has none, and
    /// [`fill_normals`] takes the faces around it: how many grid points a direction has is no measure of it.
    fn settle_normals(&mut self, surface: &Surface, welds: &mut Welds) -> Result<()> {
        let (rows, columns) = (self.u.len(), self.v.len());
        let mut agree = vec![true; self.normals.len()];
        for i in 0..rows {
            for j in 0..columns {
                let here = i * columns + j;
                let normal = match self.normals[here] {
                    Some(normal) => normal,
                    None => self.limit(surface, i, j)?,
                };
                self.normals[here] = Some(normal);
                let root = welds.root(here);
                let first = self.normals[root].unwrap_or_default();
                agree[root] &= (first - normal).norm() <= AGREE;
            }
        }
        for (normal, agree) in self.normals.iter_mut().zip(agree) {
            *normal = normal.filter(|_| agree).and_then(|n| n.try_normalize(1e-6));
        }
        Ok(())
    }

    fn limit(&self, surface: &Surface, i: usize, j: usize) -> Result<Vector> {
        let (u, v) = (self.u[i].at, self.v[j].at);
        let (first, last) = ((i == 0, j == 0), (i + 1 == self.u.len(), j + 1 == self.v.len()));
        let open = (!surface.u().is_periodic(), !surface.v().is_periodic());
        let mut sum = Vector::zeros();
        if open.0 && (first.0 || last.0) {
            sum += limit(surface, u, v, true, if first.0 { 1.0 } else { -1.0 })?;
        }
        if open.1 && (first.1 || last.1) {
            sum += limit(surface, u, v, false, if first.1 { 1.0 } else { -1.0 })?;
        }
        Ok(sum)
    }
}

/// Where no limit exists, the sum of the faces around by their angles there; where there is none either, z.
fn fill_normals(normals: Vec<Option<Vector>>, points: &[Point], corners: &[u32]) -> Vec<Vector> {
    let mut sums: Vec<Vector> = Vec::new();
    if normals.iter().any(Option::is_none) {
        sums.resize(points.len(), Vector::zeros());
        for face in corners.chunks_exact(3) {
            let corner = |k: usize| points[face[k % 3] as usize];
            for k in 0..3 {
                let (s, t) = (corner(k + 1) - corner(k), corner(k + 2) - corner(k));
                let size = s.amax().max(t.amax());
                if size > 0.0 {
                    let (s, t) = (s / size, t / size);
                    let normal = s.cross(&t).try_normalize(0.0).unwrap_or_default();
                    sums[face[k] as usize] += normal * s.angle(&t);
                }
            }
        }
    }
    let fallback = |i: usize| sums[i].try_normalize(0.0).unwrap_or_else(Vector::z);
    normals.into_iter().enumerate().map(|(i, n)| n.unwrap_or_else(|| fallback(i))).collect()
}
