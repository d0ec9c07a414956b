//! An energy as a sum of squares `‖A P - r‖²`, `A` kept in small dense blocks: one for each knot span and datum.
//!
//! The matrix `AᵀA` is never relied on: its condition is the square of `A`'s (`n⁴` instead of `n²` for bending `n` vertices).
//! Residuals and products go through `A`; `AᵀA` only preconditions.

use std::any::Any;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{Derivative, Location, Shape};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::spline::space::MAX_ORDER;
use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::energy::{Energy, Term};
use crate::orthogonal::add;

/// Nodes a span and direction, beyond those for a polynomial, at which the integrals of rational shapes are tried first, and
/// when to give up.
const RATIONAL_NODES: usize = 6;
const RATIONAL_LIMIT: usize = 80;

/// `‖A P - r‖²` over the control vertices of one shape.
#[derive(Debug, Clone, Default)]
pub(crate) struct Squares {
    blocks: Vec<Block>,
    vertices: Vec<u32>,
    coefficients: Vec<f64>,
    /// `r`, a vector a row.
    targets: Vec<Vector>,
    /// The lowest order of derivative that is integrated; 0 where there is none.
    order: usize,
    /// Tethers: `Σ τ_i |x_i - rest_i|²` beside all that, where there are any.
    tethers: Vec<f64>,
    rest: Vec<Vector>,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    vertices: usize,
    width: usize,
    coefficients: usize,
    rows: usize,
    target: usize,
}

/// One block as its users see it: its vertices, and its rows one after another.
pub(crate) struct View<'a> {
    pub(crate) vertices: &'a [u32],
    pub(crate) rows: &'a [f64],
    pub(crate) targets: &'a [Vector],
}

impl Squares {
    /// The squares of an energy for a shape; points are taken relative to `origin`, which loses nothing of a shape far away.
    pub(crate) fn new(shape: &dyn Shape, energy: &Energy, origin: Point) -> Result<Self> {
        if energy.terms.is_empty() {
            return Err(Error::Invalid(
                "say what should be small: give an energy, \"stretch\", \"bend\" or \"variation\"".into(),
            ));
        }
        let mut squares = Self::default();
        for (weight, term) in &energy.terms {
            if !(*weight >= 0.0 && weight.is_finite()) {
                return Err(Error::Invalid(format!(
                    "an energy's weight is {weight}: every weight must be a finite number, and not negative"
                )));
            }
            if *weight == 0.0 {
                continue;
            }
            match term {
                Term::Derivative(order) => {
                    squares.order = if squares.order == 0 { *order } else { squares.order.min(*order) };
                    squares.integrals(shape, *order, *weight, None)?;
                }
                Term::Near => squares.integrals(shape, 0, *weight, Some(origin))?,
                Term::Data(points) => {
                    for datum in points {
                        let good = datum.weight > 0.0
                            && datum.weight.is_finite()
                            && datum.to.coords.iter().all(|c| c.is_finite());
                        if !good {
                            return Err(Error::Invalid(format!(
                                "the point to be near to at {} needs a positive weight and finite coordinates",
                                datum.at
                            )));
                        }
                        let stencil = shape.stencil(datum.at, Derivative::POSITION)?;
                        let root = (weight * datum.weight).sqrt();
                        squares.open(stencil.vertices().iter().copied());
                        squares.row(stencil.coefficients().iter().map(|c| c * root));
                        squares.targets.push((datum.to - origin) * root);
                    }
                }
            }
        }
        if squares.coefficients.iter().any(|c| !c.is_finite()) {
            return Err(Error::Invalid(
                "the energy overflows: the parameter's domain is too short or a weight too large".into(),
            ));
        }
        Ok(squares)
    }

    /// Ties every vertex to where it rests, with these weights.
    pub(crate) fn tether(&mut self, weights: &[f64], rest: &[Vector]) {
        self.tethers = weights.to_vec();
        self.rest = rest.to_vec();
    }

    /// The weight that ties each vertex; none where nothing is tied.
    pub(crate) fn tethers(&self) -> &[f64] {
        &self.tethers
    }

    pub(crate) fn blocks(&self) -> impl Iterator<Item = View<'_>> {
        self.blocks.iter().map(|b| View {
            vertices: &self.vertices[b.vertices..b.vertices + b.width],
            rows: &self.coefficients[b.coefficients..b.coefficients + b.rows * b.width],
            targets: &self.targets[b.target..b.target + b.rows],
        })
    }

    /// The diagonal of `AᵀA`, the energy of each vertex's own motion; where that is nothing, the largest.
    pub(crate) fn stiffness(&self, count: usize) -> Vec<f64> {
        let mut stiffness = vec![0.0; count];
        for block in self.blocks() {
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                block.vertices.iter().zip(row).for_each(|(&v, c)| stiffness[v as usize] += c * c);
            }
        }
        let largest = stiffness.iter().fold(0.0, |m: f64, h| m.max(*h));
        stiffness.iter_mut().filter(|h| **h == 0.0).for_each(|h| *h = largest);
        stiffness
    }

    /// The lowest order of derivative that is integrated; 0 where there is none.
    pub(crate) fn order(&self) -> usize {
        self.order
    }

    /// Whether a motion costs no energy: in no block more than this part of what the block's numbers would make of a motion
    /// as large. Tethers are left out.
    pub(crate) fn vanishes(&self, motion: &[f64], part: f64) -> bool {
        let far = motion.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        self.blocks().all(|block| {
            let (mut energy, mut size) = (0.0, 0.0);
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                let value: f64 = row.iter().zip(block.vertices).map(|(c, &v)| c * motion[v as usize]).sum();
                let all: f64 = row.iter().map(|c| c.abs()).sum();
                energy += value * value;
                size += all * all;
            }
            energy <= part * far * far * size
        })
    }

    /// `‖A x - r‖²`, and the sum of the squared sizes of the numbers that it comes from.
    pub(crate) fn energy(&self, x: &[Vector]) -> (f64, f64) {
        let (mut energy, mut size) = (0.0, 0.0);
        for block in self.blocks() {
            for (row, target) in block.rows.chunks_exact(block.vertices.len()).zip(block.targets) {
                let (mut value, mut magnitude) = (-target, target.abs());
                for (c, &v) in row.iter().zip(block.vertices) {
                    value += x[v as usize] * *c;
                    magnitude += (x[v as usize] * *c).abs();
                }
                energy += value.norm_squared();
                size += magnitude.norm_squared();
            }
        }
        for ((weight, x), rest) in self.tethers.iter().zip(x).zip(&self.rest) {
            energy += weight * (x - rest).norm_squared();
            size += weight * (x.abs() + rest.abs()).norm_squared();
        }
        (energy, size)
    }

    /// The largest force on a vertex, `|A|ᵀ(|A| |x| + |r|)`: what the parts of a gradient would come to if none cancelled.
    pub(crate) fn strain(&self, x: &[Vector]) -> f64 {
        let mut forces = vec![0.0; x.len()];
        for block in self.blocks() {
            for (row, target) in block.rows.chunks_exact(block.vertices.len().max(1)).zip(block.targets) {
                let terms = row.iter().zip(block.vertices);
                let all = terms
                    .clone()
                    .fold(target.lp_norm(1), |sum, (c, &v)| sum + c.abs() * x[v as usize].lp_norm(1));
                terms.for_each(|(c, &v)| forces[v as usize] += c.abs() * all);
            }
        }
        forces.into_iter().fold(0.0, f64::max)
    }

    /// `out = Aᵀ(A x - r)`, or `AᵀA x` where the targets are left out.
    pub(crate) fn gradient(&self, x: &[Vector], targets: bool, out: &mut [Vector]) {
        out.fill(Vector::zeros());
        let mut local = Vec::with_capacity(64);
        let mut sum: Vec<Vector> = Vec::with_capacity(64);
        for block in self.blocks() {
            let width = block.vertices.len();
            local.clear();
            local.extend(block.vertices.iter().map(|&v| x[v as usize]));
            sum.clear();
            sum.resize(width, Vector::zeros());
            for (row, target) in block.rows.chunks_exact(width).zip(block.targets) {
                let mut value = if targets { -target } else { Vector::zeros() };
                for (c, x) in row.iter().zip(&local) {
                    value += x * *c;
                }
                for (c, sum) in row.iter().zip(&mut sum) {
                    *sum += value * *c;
                }
            }
            for (&v, sum) in block.vertices.iter().zip(&sum) {
                out[v as usize] += sum;
            }
        }
        for (((out, weight), x), rest) in out.iter_mut().zip(&self.tethers).zip(x).zip(&self.rest) {
            *out += if targets { x - rest } else { *x } * *weight;
        }
    }

    /// `(A V)ᵀ(A V)` of some motions, tethers left out.
    pub(crate) fn gram(&self, motions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut gram = vec![vec![0.0; motions.len()]; motions.len()];
        for block in self.blocks() {
            for row in block.rows.chunks_exact(block.vertices.len().max(1)) {
                let of = |m: &Vec<f64>| -> f64 {
                    row.iter().zip(block.vertices).map(|(c, &v)| c * m[v as usize]).sum()
                };
                let values: Vec<f64> = motions.iter().map(of).collect();
                for (line, value) in gram.iter_mut().zip(&values) {
                    add(line, *value, &values);
                }
            }
        }
        gram
    }

    fn open(&mut self, vertices: impl IntoIterator<Item = usize>) {
        let start = self.vertices.len();
        self.vertices.extend(vertices.into_iter().map(|v| v as u32));
        self.blocks.push(Block {
            vertices: start,
            width: self.vertices.len() - start,
            coefficients: self.coefficients.len(),
            rows: 0,
            target: self.targets.len(),
        });
    }

    /// A row of the block opened last. Its target has to follow.
    fn row(&mut self, coefficients: impl IntoIterator<Item = f64>) {
        self.coefficients.extend(coefficients);
        if let Some(block) = self.blocks.last_mut() {
            block.rows += 1;
        }
    }

    /// The integral of the squared derivatives of an order; of the distance from the shape as it is, relative to an
    /// origin, where there is one.
    fn integrals(&mut self, shape: &dyn Shape, order: usize, weight: f64, near: Option<Point>) -> Result<()> {
        let any: &dyn Any = shape;
        if let Some(curve) = any.downcast_ref::<Curve>() {
            check_degree(curve.degree(), order, "the curve")?;
            self.curve(curve, order, weight, near)
        } else if let Some(surface) = any.downcast_ref::<Surface>() {
            check_degree(surface.u().degree(), order, "the surface along u")?;
            check_degree(surface.v().degree(), order, "the surface along v")?;
            self.surface(surface, order, weight, near)
        } else {
            Err(Error::Invalid(
                "only the energies of B-spline curves and surfaces are known: convert the shape to one"
                    .into(),
            ))
        }
    }

    fn curve(&mut self, curve: &Curve, order: usize, weight: f64, near: Option<Point>) -> Result<()> {
        let space = curve.space();
        let spans: Vec<usize> = space.spans().collect();
        let nodes = match curve.weights() {
            None => None,
            Some(_) => {
                let trial = |nodes: usize| {
                    let line = Line::new(space, order, Some(nodes));
                    let each = spans.iter().enumerate().map(|(at, &span)| {
                        let mut trial = Self::default();
                        trial.curve_span(curve, order, 1.0, None, &line, (at, span))?;
                        Ok(trial.trace())
                    });
                    each.collect()
                };
                Some(enough_nodes(curve.degree() + 1, trial)?)
            }
        };
        let line = Line::new(space, order, nodes);
        spans
            .iter()
            .enumerate()
            .try_for_each(|(at, &span)| self.curve_span(curve, order, weight, near, &line, (at, span)))
    }

    fn curve_span(
        &mut self,
        curve: &Curve,
        order: usize,
        weight: f64,
        near: Option<Point>,
        line: &Line,
        (at, span): (usize, usize),
    ) -> Result<()> {
        let (space, p) = (curve.space(), curve.degree());
        self.open(sorted((0..=p).map(|j| space.vertex(span - p + j))));
        for (k, &(u, w)) in line.nodes(space, span).iter().enumerate() {
            let root = (weight * w).sqrt();
            let mut row = vec![0.0; self.width()];
            if curve.weights().is_some() {
                let stencil = curve.stencil(Location::Curve(u), Derivative { u: order, v: 0 })?;
                self.place(&mut row, stencil.iter().map(|(v, c)| (v, c * root)));
            } else {
                let terms = line.row(at, k).iter().enumerate();
                self.place(&mut row, terms.map(|(j, c)| (space.vertex(span - p + j), c * root)));
            }
            self.finish(row, near, root, || curve.point(u))?;
        }
        Ok(())
    }

    fn surface(&mut self, surface: &Surface, order: usize, weight: f64, near: Option<Point>) -> Result<()> {
        let (us, vs) = (surface.u(), surface.v());
        let (u_spans, v_spans): (Vec<usize>, Vec<usize>) = (us.spans().collect(), vs.spans().collect());
        let spans = || {
            let pairs = u_spans.iter().enumerate();
            pairs.flat_map(|u| v_spans.iter().enumerate().map(move |v| ((u.0, *u.1), (v.0, *v.1))))
        };
        let lines = |nodes: Option<usize>| -> Vec<(Line, Line)> {
            (0..=order).map(|k| (Line::new(us, k, nodes), Line::new(vs, order - k, nodes))).collect()
        };
        let nodes = match surface.weights() {
            None => None,
            Some(weights) => {
                let at = |((_, u), (_, v))| net(surface, u, v).into_iter().map(|i| weights[i]);
                let uneven = most_uneven(spans().map(|pair| ratio(at(pair))));
                let Some(pair) = spans().nth(uneven) else { return Ok(()) };
                let trial = |nodes: usize| {
                    let mut trial = Self::default();
                    trial.surface_span(surface, order, 1.0, None, &lines(Some(nodes)), pair)?;
                    Ok(vec![trial.trace()])
                };
                Some(enough_nodes(us.degree().max(vs.degree()) + 1, trial)?)
            }
        };
        let lines = lines(nodes);
        spans().try_for_each(|pair| self.surface_span(surface, order, weight, near, &lines, pair))
    }

    fn surface_span(
        &mut self,
        surface: &Surface,
        order: usize,
        weight: f64,
        near: Option<Point>,
        lines: &[(Line, Line)],
        ((i, u_span), (j, v_span)): ((usize, usize), (usize, usize)),
    ) -> Result<()> {
        let (us, vs) = (surface.u(), surface.v());
        let vertices = net(surface, u_span, v_span);
        self.open(sorted(vertices.iter().copied()));
        for (k, (along_u, along_v)) in lines.iter().enumerate() {
            let share = weight * binomial(order, k);
            let along = along_v.nodes(vs, v_span);
            for (a, &(u, wu)) in along_u.nodes(us, u_span).iter().enumerate() {
                for (b, &(v, wv)) in along.iter().enumerate() {
                    let root = (share * wu * wv).sqrt();
                    let mut row = vec![0.0; self.width()];
                    if surface.weights().is_some() {
                        let by = Derivative { u: k, v: order - k };
                        let stencil = surface.stencil(Location::Surface(u, v), by)?;
                        self.place(&mut row, stencil.iter().map(|(v, c)| (v, c * root)));
                    } else {
                        let (us, vs) = (along_u.row(i, a), along_v.row(j, b));
                        let products = us.iter().flat_map(|x| vs.iter().map(move |y| x * y * root));
                        self.place(&mut row, vertices.iter().copied().zip(products));
                    }
                    self.finish(row, near, root, || surface.point(u, v))?;
                }
            }
        }
        Ok(())
    }

    /// The trace of `AᵀA`.
    fn trace(&self) -> f64 {
        self.coefficients.iter().map(|c| c * c).sum()
    }

    fn width(&self) -> usize {
        self.blocks.last().map_or(0, |b| b.width)
    }

    /// Adds terms to a row of the block opened last.
    fn place(&self, row: &mut [f64], terms: impl IntoIterator<Item = (usize, f64)>) {
        let Some(block) = self.blocks.last() else { return };
        let vertices = &self.vertices[block.vertices..block.vertices + block.width];
        for (vertex, value) in terms {
            if let Ok(at) = vertices.binary_search(&(vertex as u32)) {
                row[at] += value;
            }
        }
    }

    fn finish(
        &mut self,
        row: Vec<f64>,
        near: Option<Point>,
        root: f64,
        point: impl FnOnce() -> Result<Point>,
    ) -> Result<()> {
        let target = match near {
            Some(origin) => (point()? - origin) * root,
            None => Vector::zeros(),
        };
        self.row(row);
        self.targets.push(target);
        Ok(())
    }
}

/// The vertices that matter on a pair of spans, along `v` first.
fn net(surface: &Surface, u_span: usize, v_span: usize) -> Vec<usize> {
    let (us, vs) = (surface.u(), surface.v());
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
/// so that what the last addition still brings is far below rounding.
fn enough_nodes(start: usize, traces: impl Fn(usize) -> Result<Vec<f64>>) -> Result<usize> {
    let mut nodes = start + RATIONAL_NODES;
    let mut before = traces(nodes)?;
    while nodes <= RATIONAL_LIMIT {
        nodes += nodes / 2;
        let now = traces(nodes)?;
        if now.iter().zip(&before).all(|(now, before)| (now - before).abs() <= 1e-10 * now) {
            return Ok(nodes);
        }
        before = now;
    }
    Err(Error::Invalid(
        "the weights differ so much within a span that the energy cannot be integrated: refine the shape there first".into(),
    ))
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
