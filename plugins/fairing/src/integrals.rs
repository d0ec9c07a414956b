//! The integrals of an energy as squares: rows at the nodes of every span or cell, exact for polynomials, of as many nodes as are enough
//! where there are weights.

use loftsman_kernel::energy::Squares;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{
    Cell, Cells, ChartedRow, Derivative, Location, Shape, Splines, cells_of, charted_rows, rows_at,
};
use loftsman_kernel::spline::Space;
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::{Point, Vector};

/// Nodes a span and direction, beyond those for a polynomial, at which the integrals of rational shapes are tried first, and
/// when to give up.
const RATIONAL_NODES: usize = 6;
const RATIONAL_LIMIT: usize = 80;

/// Squares that integrals are added to.
#[derive(Debug, Default)]
pub(crate) struct Integrals(pub(crate) Squares);

impl Integrals {
    /// The integral of the squared derivatives of an order; of the distance from the shape as it is, relative to an
    /// origin, where there is one.
    pub(crate) fn integrals(
        &mut self,
        shape: &dyn Shape,
        order: usize,
        weight: f64,
        near: Option<Point>,
    ) -> Result<()> {
        let cells = cells_of(shape, "an energy")?;
        let ([p, q], curve) = (cells.degrees(), shape.domain().len() < 2);
        check_degree(p, order, if curve { "the curve" } else { "the surface along u" })?;
        if !curve {
            check_degree(q, order, "the surface along v")?;
        }
        match cells.splines() {
            Some(splines) => match splines.v {
                None => self.curve(shape, &splines, order, weight, near),
                Some(v) => self.surface(shape, &splines, v, order, weight, near),
            },
            None => self.cells(shape, (cells, &cells.checked(shape)?), order, weight, near),
        }
    }

    /// Of a shape that is no spline: by the stencils at the nodes of every cell.
    fn cells(
        &mut self,
        shape: &dyn Shape,
        (of, cells): (&dyn Cells, &[Cell]),
        order: usize,
        weight: f64,
        near: Option<Point>,
    ) -> Result<()> {
        if order > 2 {
            let charted = |cell: &&Cell| of.chart(cell.at([0.5; 2])).is_some();
            if let Some(cell) = cells.iter().find(charted) {
                let face = cell
                    .face
                    .map_or_else(String::new, |face| format!(", the first at a corner of face {face}"));
                return Err(Error::Invalid(format!(
                    "the variation of bending is infinite at extraordinary vertices{face}, so that nothing has the least of it: ask for \
                     \"bend\" (or \"stretch\")"
                )));
            }
        }
        let mut nodes = None;
        if let Some(degree) =
            cells.iter().filter(|c| c.rational).flat_map(|c| &c.sides).map(|s| s.degree).max()
        {
            let trial = |nodes: usize| {
                let each = cells.iter().map(|cell| {
                    let mut trial = Self::default();
                    trial.cell(shape, cell, order, 1.0, None, Some(nodes))?;
                    Ok(trial.0.trace())
                });
                each.collect()
            };
            let ends = |cell: &Cell| {
                let each = cell.sides.iter().map(|side| format!("[{}, {}]", side.start, side.end));
                each.collect::<Vec<_>>().join(" × ")
            };
            nodes = Some(enough_nodes(degree + 1, trial, |at| format!("on {}", ends(&cells[at])))?);
        }
        cells.iter().try_for_each(|cell| match charted_rows(shape, of, cell, order)? {
            None => self.cell(shape, cell, order, weight, near, nodes),
            Some(rows) => {
                self.0.open(cell.vertices.iter().copied());
                let scale = weight.sqrt();
                rows.into_iter().try_for_each(|ChartedRow { at, root, row }| {
                    let row = row.into_iter().map(|c| c * scale).collect();
                    self.finish(row, near, root * scale, shape, at)
                })
            }
        })
    }

    fn cell(
        &mut self,
        shape: &dyn Shape,
        cell: &Cell,
        order: usize,
        weight: f64,
        near: Option<Point>,
        nodes: Option<usize>,
    ) -> Result<()> {
        self.0.open(cell.vertices.iter().copied());
        let width = self.0.width();
        let by_u = if cell.sides.len() < 2 { order..=order } else { 0..=order };
        for k in by_u {
            let derivative = Derivative { u: k, v: order - k };
            let share = weight * if cell.sides.len() < 2 { 1.0 } else { binomial(order, k) };
            let count = |side: usize, by: usize| {
                let degree = cell.sides.get(side).map_or(0, |side| side.degree);
                // Exact for the square of a polynomial of degree p - k: 2 (p - k) ≤ 2 n - 1.
                nodes.filter(|_| cell.rational).unwrap_or(degree + 1 - by.min(degree))
            };
            let points = cell.gauss_points([count(0, k), count(1, order - k)]);
            let rows = rows_at(shape, cell, &points, derivative)?;
            for ((at, w), row) in points.iter().zip(rows.chunks_exact(width.max(1))) {
                let root = (share * w).sqrt();
                self.finish(row.iter().map(|c| c * root).collect(), near, root, shape, *at)?;
            }
        }
        Ok(())
    }

    fn curve(
        &mut self,
        shape: &dyn Shape,
        splines: &Splines<'_>,
        order: usize,
        weight: f64,
        near: Option<Point>,
    ) -> Result<()> {
        let space = splines.u;
        let spans: Vec<usize> = space.spans().collect();
        let nodes = match splines.weights {
            None => None,
            Some(_) => {
                let trial = |nodes: usize| {
                    let line = Line::new(space, order, Some(nodes));
                    let each = spans.iter().enumerate().map(|(at, &span)| {
                        let mut trial = Self::default();
                        trial.curve_span(shape, splines, order, 1.0, None, &line, (at, span))?;
                        Ok(trial.0.trace())
                    });
                    each.collect()
                };
                let name = |at: usize| format!("between {}", ends(space, spans[at]));
                Some(enough_nodes(space.degree() + 1, trial, name)?)
            }
        };
        let line = Line::new(space, order, nodes);
        spans.iter().enumerate().try_for_each(|(at, &span)| {
            self.curve_span(shape, splines, order, weight, near, &line, (at, span))
        })
    }

    #[allow(clippy::too_many_arguments, reason = "an integral, and where it is taken")]
    fn curve_span(
        &mut self,
        shape: &dyn Shape,
        splines: &Splines<'_>,
        order: usize,
        weight: f64,
        near: Option<Point>,
        line: &Line,
        (at, span): (usize, usize),
    ) -> Result<()> {
        let (space, p) = (splines.u, splines.u.degree());
        self.0.open(sorted((0..=p).map(|j| space.vertex(span - p + j))));
        for (k, &(u, w)) in line.nodes(space, span).iter().enumerate() {
            let root = (weight * w).sqrt();
            let mut row = vec![0.0; self.0.width()];
            if splines.weights.is_some() {
                let stencil = shape.stencil(Location::Curve(u), Derivative { u: order, v: 0 })?;
                self.0.place(&mut row, stencil.iter().map(|(v, c)| (v, c * root)));
            } else {
                let terms = line.row(at, k).iter().enumerate();
                self.0.place(&mut row, terms.map(|(j, c)| (space.vertex(span - p + j), c * root)));
            }
            self.finish(row, near, root, shape, Location::Curve(u))?;
        }
        Ok(())
    }

    fn surface(
        &mut self,
        shape: &dyn Shape,
        splines: &Splines<'_>,
        vs: &Space,
        order: usize,
        weight: f64,
        near: Option<Point>,
    ) -> Result<()> {
        let us = splines.u;
        let (u_spans, v_spans): (Vec<usize>, Vec<usize>) = (us.spans().collect(), vs.spans().collect());
        let spans = || {
            let pairs = u_spans.iter().enumerate();
            pairs.flat_map(|u| v_spans.iter().enumerate().map(move |v| ((u.0, *u.1), (v.0, *v.1))))
        };
        let lines = |nodes: Option<usize>| -> Vec<(Line, Line)> {
            (0..=order).map(|k| (Line::new(us, k, nodes), Line::new(vs, order - k, nodes))).collect()
        };
        let nodes = match splines.weights {
            None => None,
            Some(weights) => {
                let at = |((_, u), (_, v))| net(us, vs, u, v).into_iter().map(|i| weights[i]);
                let uneven = most_uneven(spans().map(|pair| ratio(at(pair))));
                let Some(pair) = spans().nth(uneven) else { return Ok(()) };
                let trial = |nodes: usize| {
                    let mut trial = Self::default();
                    trial.surface_span(shape, (us, vs, true), order, 1.0, None, &lines(Some(nodes)), pair)?;
                    Ok(vec![trial.0.trace()])
                };
                let ((_, u), (_, v)) = pair;
                let name = |_| format!("between u = {} and v = {}", ends(us, u), ends(vs, v));
                Some(enough_nodes(us.degree().max(vs.degree()) + 1, trial, name)?)
            }
        };
        let lines = lines(nodes);
        let rational = splines.weights.is_some();
        spans().try_for_each(|pair| {
            self.surface_span(shape, (us, vs, rational), order, weight, near, &lines, pair)
        })
    }

    #[allow(clippy::too_many_arguments, reason = "an integral, and where it is taken")]
    fn surface_span(
        &mut self,
        shape: &dyn Shape,
        (us, vs, rational): (&Space, &Space, bool),
        order: usize,
        weight: f64,
        near: Option<Point>,
        lines: &[(Line, Line)],
        ((i, u_span), (j, v_span)): ((usize, usize), (usize, usize)),
    ) -> Result<()> {
        let vertices = net(us, vs, u_span, v_span);
        self.0.open(sorted(vertices.iter().copied()));
        for (k, (along_u, along_v)) in lines.iter().enumerate() {
            let share = weight * binomial(order, k);
            let along = along_v.nodes(vs, v_span);
            for (a, &(u, wu)) in along_u.nodes(us, u_span).iter().enumerate() {
                for (b, &(v, wv)) in along.iter().enumerate() {
                    let root = (share * wu * wv).sqrt();
                    let mut row = vec![0.0; self.0.width()];
                    if rational {
                        let by = Derivative { u: k, v: order - k };
                        let stencil = shape.stencil(Location::Surface(u, v), by)?;
                        self.0.place(&mut row, stencil.iter().map(|(v, c)| (v, c * root)));
                    } else {
                        let (us, vs) = (along_u.row(i, a), along_v.row(j, b));
                        let products = us.iter().flat_map(|x| vs.iter().map(move |y| x * y * root));
                        self.0.place(&mut row, vertices.iter().copied().zip(products));
                    }
                    self.finish(row, near, root, shape, Location::Surface(u, v))?;
                }
            }
        }
        Ok(())
    }

    fn finish(
        &mut self,
        row: Vec<f64>,
        near: Option<Point>,
        root: f64,
        shape: &dyn Shape,
        at: Location,
    ) -> Result<()> {
        let target = match near {
            Some(origin) => (shape.value(at, Derivative::POSITION)? - origin.coords) * root,
            None => Vector::zeros(),
        };
        self.0.row(row, target);
        Ok(())
    }
}

/// The vertices that matter on a pair of spans, along `v` first.
fn net(us: &Space, vs: &Space, u_span: usize, v_span: usize) -> Vec<usize> {
    let (p, q, columns) = (us.degree(), vs.degree(), vs.len());
    let row = |a| us.vertex(u_span - p + a) * columns;
    (0..=p).flat_map(|a| (0..=q).map(move |b| row(a) + vs.vertex(v_span - q + b))).collect()
}

/// The largest of some weights over the smallest.
fn ratio(weights: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = weights.fold((f64::INFINITY, 0.0_f64), |(l, h), w| (l.min(w), h.max(w)));
    high / low
}

/// The number of the first largest.
fn most_uneven(ratios: impl Iterator<Item = f64>) -> usize {
    ratios.enumerate().fold((0, 0.0), |best, (i, r)| if r > best.1 { (i, r) } else { best }).0
}

/// How many nodes integrate rational functions: more and more, until no span's integral changes; convergence is geometric,
/// so that what the last addition still brings is far below rounding. `name` says which span the one of a number is.
fn enough_nodes(
    start: usize,
    traces: impl Fn(usize) -> Result<Vec<f64>>,
    name: impl Fn(usize) -> String,
) -> Result<usize> {
    let mut nodes = start + RATIONAL_NODES;
    let mut before = traces(nodes)?;
    loop {
        nodes += nodes / 2;
        let now = traces(nodes)?;
        let change = |at: usize| (now[at] - before[at]).abs();
        let settled = |at: usize| change(at) <= 1e-10 * now[at];
        let unsettled = (0..now.len()).filter(|&at| !settled(at));
        let share = |at: usize| change(at) / now[at];
        let Some(worst) = unsettled.max_by(|&a, &b| share(a).total_cmp(&share(b))) else { return Ok(nodes) };
        if nodes > RATIONAL_LIMIT {
            let place = name(worst);
            return Err(Error::Invalid(format!(
                "the weights differ so much {place} that the energy cannot be integrated there: refine the shape there first"
            )));
        }
        before = now;
    }
}

/// Where a span starts and ends, for people.
fn ends(space: &Space, span: usize) -> String {
    format!("{} and {}", space.flat()[span], space.flat()[span + 1])
}

/// Basis functions of one direction at the nodes of every span.
struct Line {
    nodes: Vec<f64>,
    weights: Vec<f64>,
    rows: Vec<f64>,
    order: usize,
}

impl Line {
    fn new(space: &Space, derivative: usize, rational: Option<usize>) -> Self {
        let p = space.degree();
        // Exact for the square of a polynomial of degree p - k: 2 (p - k) ≤ 2 n - 1.
        let exact = p + 1 - derivative.min(p);
        let (nodes, weights) = gauss_legendre(rational.unwrap_or(exact));
        let mut rows = Vec::new();
        if rational.is_none() {
            let mut row = [0.0; MAX_ORDER];
            for span in space.spans() {
                let (a, b) = (space.flat()[span], space.flat()[span + 1]);
                for x in &nodes {
                    space.basis_into(span, a + (b - a) * x, derivative, &mut row);
                    rows.extend_from_slice(&row[..=p]);
                }
            }
        }
        Self { nodes, weights, rows, order: p + 1 }
    }

    /// Parameters and weights of the nodes of a span.
    fn nodes(&self, space: &Space, span: usize) -> Vec<(f64, f64)> {
        let (a, b) = (space.flat()[span], space.flat()[span + 1]);
        self.nodes.iter().zip(&self.weights).map(|(x, w)| (a + (b - a) * x, w * (b - a))).collect()
    }

    /// The basis functions at node `k` of the span that is number `at` of those that are not empty.
    fn row(&self, at: usize, k: usize) -> &[f64] {
        let start = (at * self.nodes.len() + k) * self.order;
        &self.rows[start..start + self.order]
    }
}

fn check_degree(degree: usize, order: usize, what: &str) -> Result<()> {
    if degree >= order.max(1) {
        return Ok(());
    }
    let name = ["", "stretch", "bend", "variation"][order.min(3)];
    Err(Error::Invalid(format!(
        "\"{name}\" asks for derivatives of order {order}, and {what} has degree {degree}: elevate its degree first, or ask \
         for another energy"
    )))
}

/// Ascending and without repetition: a short period meets itself.
fn sorted(vertices: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut all: Vec<usize> = vertices.into_iter().collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}
