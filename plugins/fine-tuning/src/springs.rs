//! Polygons and meshes: edges scaled, and springs that reconcile them (paper 5, §4).

use std::collections::BTreeMap;
use std::sync::Arc;

use loftsman_kernel::edit::Edit;
use loftsman_kernel::energy::Energy;
use loftsman_kernel::error::{Error, Result as KernelResult};
use loftsman_kernel::functional::Shapes;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::shape::{Derivative, Domain, Interval, Location, Shape, Stencil};
use loftsman_kernel::solve::{Symmetric, SystemMetric};
use loftsman_kernel::{Point, Vector};

use crate::error::{FineTuneError, Result};

/// The edges of a polygon or a mesh as linear springs, each of which wants to be its own edge times a factor: the edges of a control
/// net are its derivative, and scaled ones need not close up. `min Σ |X_j - X_i - α_ij (P_j - P_i)|²`, a vertex of each piece that
/// hangs together staying where it is: a graph Laplacian, factored once for x, y and z. Around a closed polygon the closing error is
/// spread over all edges alike.
///
/// ```
/// use loftsman_fine_tuning::Springs;
/// use loftsman_kernel::Point;
///
/// let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0));
/// let mut springs = Springs::of_polygon(4, true);
/// springs.scale([0, 1], 2.0)?;
/// let tuned = springs.solve(&square)?;
/// // The edge is longer by one, and the loop gives way by a quarter on each of its edges.
/// assert!((tuned.points[1] - Point::new(1.75, 0.0, 0.0)).norm() < 1e-14);
/// # Ok::<(), loftsman_fine_tuning::FineTuneError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Springs {
    vertices: usize,
    /// Both vertices of each edge, the smaller first, and its factor.
    edges: BTreeMap<[usize; 2], f64>,
    pins: Vec<usize>,
    any_sign: bool,
}

/// What springs came to.
#[derive(Debug, Clone)]
pub struct Sprung {
    /// Where the vertices are.
    pub points: Vec<Point>,
    /// `(Σ |X_j - X_i - α_ij e_ij|² / Σ |α_ij e_ij|²)^½`: how far the edges are from what they want to be; 0 where they close up.
    pub strain: f64,
}

impl Springs {
    /// The edges of a polygon, in order.
    pub fn of_polygon(vertices: usize, closed: bool) -> Self {
        let last = if closed && vertices > 2 { vertices } else { vertices.saturating_sub(1) };
        Self::new(vertices, (0..last).map(|i| [i, (i + 1) % vertices]))
    }

    /// The edges of a mesh's faces and its loose lines, each once.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let faces = mesh.faces().flat_map(|face| {
            let next = face.iter().cycle().skip(1);
            face.iter().zip(next).map(|(a, b)| [*a as usize, *b as usize]).collect::<Vec<_>>()
        });
        let lines = mesh.lines().flat_map(|line| line.windows(2).map(|w| [w[0] as usize, w[1] as usize]));
        Self::new(mesh.points().len(), faces.chain(lines))
    }

    fn new(vertices: usize, edges: impl Iterator<Item = [usize; 2]>) -> Self {
        let edges = edges.filter(|[a, b]| a != b).map(|[a, b]| ([a.min(b), a.max(b)], 1.0)).collect();
        Self { vertices, edges, pins: Vec::new(), any_sign: false }
    }

    /// Scales all edges.
    pub fn scale_all(&mut self, alpha: f64) {
        self.edges.values_mut().for_each(|own| *own = alpha);
    }

    /// Scales an edge.
    ///
    /// # Errors
    /// When there is no such edge.
    pub fn scale(&mut self, [a, b]: [usize; 2], alpha: f64) -> Result<()> {
        match self.edges.get_mut(&[a.min(b), a.max(b)]) {
            Some(own) => {
                *own = alpha;
                Ok(())
            }
            None => Err(FineTuneError::Contradiction(format!(
                "there is no edge between vertices {a} and {b}: vertices are numbered from 0, and an edge is one of a face or a line"
            ))),
        }
    }

    /// A vertex that stays where it is. Pieces without one keep the first of their vertices.
    ///
    /// # Errors
    /// When there is no such vertex.
    pub fn pin(&mut self, vertex: usize) -> Result<()> {
        if vertex >= self.vertices {
            return Err(Error::NoVertex { index: vertex as i64, count: self.vertices }.into());
        }
        self.pins.push(vertex);
        Ok(())
    }

    /// Lets factors be zero or negative.
    pub fn any_sign(&mut self) {
        self.any_sign = true;
    }

    /// Where the vertices come to.
    ///
    /// # Errors
    /// When a factor is not finite, or not positive and need be; when there are not as many points, or numbers overflow.
    pub fn solve(&self, points: &[Point]) -> Result<Sprung> {
        if points.len() != self.vertices {
            let problem = format!("{} points for springs between {} vertices", points.len(), self.vertices);
            return Err(FineTuneError::Contradiction(problem));
        }
        let fine = |alpha: f64| alpha.is_finite() && (self.any_sign || alpha > 0.0);
        if let Some(([a, b], alpha)) = self.edges.iter().find(|(_, alpha)| !fine(**alpha)) {
            return Err(FineTuneError::NotPositive {
                value: *alpha,
                at: format!("the edge of vertices {a} and {b}"),
            });
        }
        let wanted = |([a, b], alpha): (&[usize; 2], &f64)| (*a, *b, (points[*b] - points[*a]) * *alpha);
        let wanted: Vec<(usize, usize, Vector)> = self.edges.iter().map(wanted).collect();
        let pins = self.pinned();
        let net = Net(points.to_vec());
        let points = if pins.len() == points.len() || points.len() < 2 {
            points.to_vec()
        } else {
            let energy = Wanted { edges: Arc::new(wanted.clone()) };
            let edit = Edit::new(&net).minimise(energy).smooth(0).lock(pins.iter().map(|v| *v as i64));
            edit.solve()?.shape().0.clone()
        };
        let (mut off, mut size) = (0.0, 0.0);
        for (a, b, way) in &wanted {
            off += (points[*b] - points[*a] - way).norm_squared();
            size += way.norm_squared();
        }
        let strain = if size > 0.0 { (off / size).sqrt() } else { 0.0 };
        Ok(Sprung { points, strain })
    }

    /// The vertices that stay: those that were said, and the first of each piece that has none.
    fn pinned(&self) -> Vec<usize> {
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); self.vertices];
        for [a, b] in self.edges.keys() {
            beside[*a].push(*b);
            beside[*b].push(*a);
        }
        let mut seen = vec![false; self.vertices];
        let mut all = self.pins.clone();
        for first in self.pins.iter().copied().chain(0..self.vertices) {
            if seen[first] {
                continue;
            }
            if !self.pins.contains(&first) {
                all.push(first);
            }
            let mut way = vec![first];
            while let Some(vertex) = way.pop() {
                if !std::mem::replace(&mut seen[vertex], true) {
                    way.extend(beside[vertex].iter().filter(|v| !seen[**v]));
                }
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }
}

/// `Σ |X_j - X_i - w_ij|²`.
#[derive(Debug)]
struct Wanted {
    edges: Arc<Vec<(usize, usize, Vector)>>,
}

impl Energy for Wanted {
    fn describe(&self) -> String {
        "springs".into()
    }

    fn form(&self, shapes: &Shapes<'_>, moving: &[usize]) -> KernelResult<SystemMetric> {
        let entries = self.edges.iter().flat_map(|(a, b, _)| [(*a, *a, 1.0), (*b, *b, 1.0), (*b, *a, -1.0)]);
        let all = Symmetric::from_entries(shapes.vertex_count(), entries.collect::<Vec<_>>());
        Ok(SystemMetric::Matrix(Arc::new(all.select(moving))))
    }

    fn pull(&self, shapes: &Shapes<'_>, moving: &[usize]) -> KernelResult<Vec<Vector>> {
        let points = shapes.get(0)?.control_vertices();
        let mut all = vec![Vector::zeros(); points.len()];
        for (a, b, way) in self.edges.iter() {
            let missing = way - (points[*b] - points[*a]);
            all[*b] += missing;
            all[*a] -= missing;
        }
        Ok(moving.iter().map(|v| all[*v]).collect())
    }
}

/// Vertices as a shape: a line through them in their order, which nobody looks at.
#[derive(Debug, Clone)]
struct Net(Vec<Point>);

impl Shape for Net {
    fn control_vertices(&self) -> &[Point] {
        &self.0
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.0
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> KernelResult<Stencil> {
        let (u, last) = (at.on_curve()?, self.0.len() - 1);
        let span = (u.max(0.0) as usize).min(last.saturating_sub(1));
        let t = u - span as f64;
        let row = match derivative.u {
            0 => [1.0 - t, t],
            1 => [-1.0, 1.0],
            _ => [0.0, 0.0],
        };
        Ok([(span, row[0]), (last.min(span + 1), row[1])].into_iter().collect())
    }

    fn domain(&self) -> Domain {
        let end = (self.0.len().max(2) - 1) as f64;
        std::iter::once(Interval { start: 0.0, end, periodic: false }).collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }
}
