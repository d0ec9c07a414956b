//! Unknowns other than control vertices: `P = P⁰ + B x`.

use std::sync::{Arc, OnceLock};

use nalgebra::Matrix3;

use super::metric::Metric;
use crate::energy::Energy;
use crate::error::{Error, Result};
use crate::functional::Shapes;
use crate::solve::{Map, Operator, SparseRows, Symmetric, SystemMetric, Through};

/// The unknowns of an edit where they are not its control vertices: these move as `P = P⁰ + B x`, and nothing else moves. With
/// them all that is asked of vertices is asked of `x`: every functional, linear or not, every solver, inequalities, drags,
/// conflicts and multipliers are what they are without.
///
/// What is least is the [metric](super::Metric) of the vertices' adjustments, `xᵀBᵀWBx`; or, where the unknowns are
/// [measured themselves](Self::measured), `xᵀMx`.
///
/// ```
/// use loftsman_kernel::Point;
/// use loftsman_kernel::edit::{Ask, Edit, Tie, Unknowns};
/// use loftsman_kernel::functional::position;
/// use loftsman_kernel::shape::Shape;
/// use loftsman_kernel::spline::{Curve, Space};
///
/// let points = (0..6).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
/// let curve = Curve::new(Space::clamped_uniform(3, 6)?, points)?;
/// // The last vertex goes where the first goes.
/// let tied = Unknowns::tied(6, &[Tie::together(5, 0)])?;
/// let edited = Edit::new(&curve).through(tied).ask(position(0.0).by([0.0, 1.0, 0.0])).solve()?;
/// assert_eq!(edited.shape().control_vertices()[5].y, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Unknowns {
    /// The vertices that `B` moves, ascending global numbers.
    vertices: Arc<Vec<usize>>,
    /// Whether the map is one of vertices, the same for x, y and z; else it is one of their coordinates.
    alike: bool,
    map: Map,
    measured: Measured,
    /// How many vertices all shapes have together, where that is known.
    of: Option<usize>,
    /// `BᵀB`.
    gram: OnceLock<Arc<Symmetric>>,
}

/// What the unknowns are measured by.
#[derive(Debug, Clone)]
enum Measured {
    /// The vertices that they move.
    Vertices,
    /// This form, or the identity.
    Themselves(Option<Arc<Symmetric>>),
}

/// A control vertex that goes where another takes it: `d_vertex = by · d_to`. Vertices are numbered through all shapes of the
/// edit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// The vertex that follows.
    pub vertex: usize,
    /// The vertex that it follows; one that follows another itself, if need be.
    pub to: usize,
    /// What becomes of the way of that one: a reflection for the other half of something symmetric.
    pub by: Matrix3<f64>,
}

impl Tie {
    /// A vertex that makes the same way as another: parts that move as one piece, vertices that two shapes share.
    pub fn together(vertex: usize, to: usize) -> Self {
        Self { vertex, to, by: Matrix3::identity() }
    }
}

impl Unknowns {
    /// The `count` control vertices of all shapes, some of which follow others. `O(n)` for ties that follow few others.
    ///
    /// # Errors
    /// When a vertex that is not there is tied, one is tied twice, or they follow one another in a circle. An edit whose shapes
    /// have another number of vertices is refused when it is prepared.
    pub fn tied(count: usize, ties: &[Tie]) -> Result<Self> {
        let mut follows: Vec<Option<(usize, Matrix3<f64>)>> = vec![None; count];
        for tie in ties {
            if let Some(bad) = [tie.vertex, tie.to].into_iter().find(|v| *v >= count) {
                return Err(Error::Invalid(format!(
                    "control vertex {bad} cannot be tied: there are {count}, numbered from 0"
                )));
            }
            if tie.by.iter().any(|c| !c.is_finite()) {
                return Err(Error::Invalid(format!(
                    "control vertex {} cannot be tied by a matrix that is not finite",
                    tie.vertex
                )));
            }
            if follows[tie.vertex].replace((tie.to, tie.by)).is_some() {
                return Err(Error::Invalid(format!(
                    "control vertex {} is tied twice: it can follow one other only",
                    tie.vertex
                )));
            }
        }
        // Where each goes in the end. Those whose way is known shorten the ways of those behind them.
        let mut known: Vec<Option<(usize, Matrix3<f64>)>> =
            (0..count).map(|v| follows[v].is_none().then_some((v, Matrix3::identity()))).collect();
        for vertex in 0..count {
            let (mut way, mut at) = (Vec::new(), vertex);
            while known[at].is_none() {
                let Some((to, by)) = follows[at].take() else {
                    return Err(Error::Invalid(format!(
                        "control vertex {at} follows itself by way of others: ties must lead to a vertex that is free"
                    )));
                };
                way.push((at, by));
                at = to;
            }
            while let (Some((behind, by)), Some((root, turn))) = (way.pop(), known[at]) {
                known[behind] = Some((root, by * turn));
                at = behind;
            }
        }
        let known: Vec<(usize, Matrix3<f64>)> = known.into_iter().flatten().collect();
        let alike = known.iter().all(|(_, by)| *by == Matrix3::identity());
        let mut number = vec![0; count];
        let mut free = 0;
        for (vertex, (root, _)) in known.iter().enumerate() {
            if *root == vertex {
                number[vertex] = free;
                free += 1;
            }
        }
        let mut rows = SparseRows::with_capacity(if alike { free } else { 3 * free }, count, count);
        for (root, by) in &known {
            if alike {
                rows.push([(number[*root], 1.0)]);
                continue;
            }
            for axis in 0..3 {
                let of = (0..3).map(|k| (3 * number[*root] + k, by[(axis, k)]));
                rows.push(of.filter(|(_, c)| *c != 0.0));
            }
        }
        let tied = Self::new((0..count).collect(), alike, Map::Sparse(Arc::new(rows)));
        Ok(Self { of: Some(count), ..tied })
    }

    /// What of each unknown each coordinate of some vertices has: `rows` are those of `B`, three a vertex, over the unknowns.
    /// `vertices` are numbered through all shapes, ascending.
    ///
    /// # Errors
    /// When vertices do not ascend, there are not three rows for each, or a number is not finite.
    pub fn sparse(vertices: Vec<usize>, rows: SparseRows) -> Result<Self> {
        check_vertices(&vertices)?;
        if rows.len() != 3 * vertices.len() {
            return Err(Error::Invalid(format!(
                "{} rows for {} control vertices: give three for each, for its x, y and z",
                rows.len(),
                vertices.len()
            )));
        }
        if (0..rows.len()).flat_map(|row| rows.row(row).1).any(|value| !value.is_finite()) {
            return Err(Error::Invalid("what unknowns do to control vertices must be finite numbers".into()));
        }
        Ok(Self::new(vertices, false, Map::Sparse(Arc::new(rows))))
    }

    /// A map that is applied and never stored, from unknowns to x, y and z of each of some vertices, one after another.
    /// `vertices` are numbered through all shapes, ascending.
    ///
    /// # Errors
    /// When vertices do not ascend, the operator does not make three numbers for each, or it and its transpose do not belong
    /// together (they are tried out).
    pub fn operator(vertices: Vec<usize>, operator: Arc<dyn Operator>) -> Result<Self> {
        check_vertices(&vertices)?;
        if operator.columns() != 3 * vertices.len() {
            return Err(Error::Invalid(format!(
                "a map to {} numbers cannot move {} control vertices: it must make three for each",
                operator.columns(),
                vertices.len()
            )));
        }
        let map = Map::operator(operator).map_err(|error| Error::Invalid(error.to_string()))?;
        Ok(Self::new(vertices, false, map))
    }

    fn new(vertices: Vec<usize>, alike: bool, map: Map) -> Self {
        let vertices = Arc::new(vertices);
        Self { vertices, alike, map, measured: Measured::Vertices, of: None, gram: OnceLock::new() }
    }

    /// Makes the unknowns' own change least, not that of the vertices: `‖x‖²`, or `xᵀMx` with a symmetric positive definite `M`
    /// (the Gram matrix of the functions whose coefficients they are). With `None`, `B` may have columns that depend on one
    /// another.
    ///
    /// # Errors
    /// When the matrix is not as large as there are unknowns, or a number in it is not finite.
    pub fn measured(mut self, by: Option<Symmetric>) -> Result<Self> {
        let count = self.count();
        let own = if self.alike { count / 3 } else { count };
        if let Some(found) = by.as_ref().map(Symmetric::size).filter(|size| *size != own) {
            return Err(Error::Invalid(format!("a matrix of size {found} cannot measure {own} unknowns")));
        }
        if let Some(row) = by.as_ref().and_then(Symmetric::first_not_finite) {
            return Err(Error::Invalid(format!(
                "row {row} of the matrix that measures the unknowns has a number that is not finite: every one must be"
            )));
        }
        self.measured = Measured::Themselves(by.map(Arc::new));
        Ok(self)
    }

    /// How many numbers are unknown.
    pub fn count(&self) -> usize {
        self.map.unknowns() * if self.alike { 3 } else { 1 }
    }

    /// The control vertices that move, by their numbers through all shapes, ascending.
    pub fn vertices(&self) -> &Arc<Vec<usize>> {
        &self.vertices
    }

    /// Whether x, y and z move alike and by themselves.
    pub(super) fn is_alike(&self) -> bool {
        self.alike
    }

    /// What becomes of a metric of all vertices; `per_axis` where the system's columns are coordinates.
    pub(super) fn resolve(
        &self,
        metric: &Metric,
        shapes: &Shapes<'_>,
        per_axis: bool,
    ) -> Result<SystemMetric> {
        let there = shapes.vertex_count();
        if let Some(count) = self.of.filter(|count| *count != there) {
            return Err(Error::Invalid(format!(
                "{count} control vertices are tied, but the shapes of the edit have {there} together: count all of them"
            )));
        }
        let spread = self.alike && per_axis;
        let of_vertices = |form: SystemMetric| if per_axis { form.per_axis() } else { form };
        let map = match &self.map {
            Map::Sparse(rows) if spread => Map::Sparse(Arc::new(rows.per_axis())),
            map => map.clone(),
        };
        let measure = match (&self.measured, metric) {
            (Measured::Themselves(own), Metric::Least) => {
                own.as_ref().map(|own| if spread { Arc::new(own.per_axis()) } else { Arc::clone(own) })
            }
            (Measured::Themselves(_), _) => {
                return Err(Error::Invalid(
                    "the unknowns are measured by themselves, so that no metric of control vertices can be given beside them"
                        .into(),
                ));
            }
            (Measured::Vertices, Metric::Least) => {
                let gram = self.gram.get_or_init(|| Arc::new(self.map.form(None)));
                Some(if spread { Arc::new(gram.per_axis()) } else { Arc::clone(gram) })
            }
            (Measured::Vertices, metric) => match of_vertices(metric.form(shapes, &self.vertices)?) {
                SystemMetric::Weights(weights) => {
                    let each = weights.iter().enumerate().map(|(i, w)| (i, i, *w));
                    Some(Arc::new(map.form(Some(&Symmetric::from_entries(weights.len(), each)))))
                }
                SystemMetric::Matrix(matrix) => Some(Arc::new(map.form(Some(&matrix)))),
                _ => {
                    return Err(Error::Invalid(
                        "a falloff says which control vertices go along with others, and so do unknowns of one's own: leave one of \
                         the two out"
                            .into(),
                    ));
                }
            },
        };
        let is_own = matches!(self.measured, Measured::Themselves(_));
        Ok(SystemMetric::Through(Arc::new(Through { map, measure, is_own })))
    }
}

fn check_vertices(vertices: &[usize]) -> Result<()> {
    match vertices.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(Error::Invalid(format!(
            "the control vertices that unknowns move must ascend: {} comes before {}",
            pair[0], pair[1]
        ))),
        None => Ok(()),
    }
}
