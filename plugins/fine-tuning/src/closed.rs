//! What is asked by the numbers of a closed curve's control vertices, of the curve opened at its seam, which is what is solved for.

use std::sync::Arc;

use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Equation, Functional, Linearity, Rows, Shapes, Store};
use loftsman_kernel::shape::{Shape, Side};
use loftsman_kernel::spline::{Curve, Space};
use loftsman_kernel::{Point, Vector};

/// A closed curve's control vertices as sums of those of the same curve opened.
#[derive(Debug)]
pub(crate) struct Opened {
    /// Any curve with so many control vertices.
    closed: Curve,
    rows: Vec<Vec<(usize, f64)>>,
}

impl Opened {
    /// Of a periodic space and the same, clamped at its seam. `O(n p³)`.
    pub(crate) fn new(closed: &Space, open: &Space) -> Result<Self> {
        let (p, t, (a, b)) = (closed.degree(), closed.flat(), closed.domain());
        let mut rows = vec![Vec::new(); closed.len()];
        for i in 0..closed.unrolled_len() {
            let (row, knots) = (&mut rows[closed.vertex(i)], &t[i + 1..=i + p]);
            let middle = knots.iter().sum::<f64>() / p as f64;
            if row.is_empty() && a <= middle && middle <= b {
                *row = polar(open, open.span_on(middle, Side::Right).0, knots);
            }
        }
        let points = (0..closed.len()).map(|k| Point::new(k as f64, 0.0, 0.0)).collect();
        Ok(Self { closed: Curve::new(closed.clone(), points)?, rows })
    }
}

/// What the polar form of the polynomial of a span has at `p` arguments of each control vertex (Ramshaw 1987): those of B-splines are its values at the
/// knots inside their supports.
fn polar(space: &Space, span: usize, arguments: &[f64]) -> Vec<(usize, f64)> {
    let (p, t) = (space.degree(), space.flat());
    let mut all: Vec<Vec<f64>> =
        (0..=p).map(|j| (0..=p).map(|k| f64::from(u8::from(j == k))).collect()).collect();
    for (r, argument) in (1..=p).zip(arguments) {
        for j in (r..=p).rev() {
            let (low, high) = (t[span - p + j], t[span + 1 + j - r]);
            let share = (argument - low) / (high - low);
            let (before, own) = all.split_at_mut(j);
            own[0]
                .iter_mut()
                .zip(&before[j - 1])
                .for_each(|(own, before)| *own = before + share * (*own - before));
        }
    }
    all[p].iter().enumerate().map(|(k, c)| (space.vertex(span - p + k), *c)).collect()
}

/// A linear functional of the closed curve's control vertices, asked of the open one's.
#[derive(Debug)]
pub(crate) struct OfClosed {
    functional: Arc<dyn Functional>,
    opened: Arc<Opened>,
}

impl OfClosed {
    pub(crate) fn new(functional: &Arc<dyn Functional>, opened: &Arc<Opened>) -> Self {
        Self { functional: Arc::clone(functional), opened: Arc::clone(opened) }
    }
}

impl Functional for OfClosed {
    fn equations(&self) -> usize {
        self.functional.equations()
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let mut all: Vec<&dyn Shape> = vec![&self.opened.closed];
        (1..shapes.len()).try_for_each(|k| shapes.get(k).map(|shape| all.push(shape)))?;
        let closed = Shapes::new(all.iter().copied());
        let mut store = Store::default();
        self.functional.rows(&closed, &mut store.rows(&closed))?;
        let put = |vertex: usize, vector: Vector, rows: &mut Rows<'_>| {
            if let Some(row) = self.opened.rows.get(vertex) {
                for (k, c) in row {
                    rows.term(0, *k, vector * *c);
                }
                return;
            }
            let shape = (1..closed.len()).rfind(|s| closed.offset(*s) <= vertex).unwrap_or(1);
            rows.term(shape, vertex - closed.offset(shape).min(vertex), vector);
        };
        for equation in store.equations() {
            match equation {
                Equation::Alike { vertices, coefficients, constant } => {
                    for axis in 0..3 {
                        let way = Vector::ith(axis, 1.0);
                        rows.equation();
                        for (vertex, c) in vertices.iter().zip(coefficients) {
                            put(*vertex, way * *c, rows);
                        }
                        rows.constant(Vector::new(constant[axis], 0.0, 0.0));
                    }
                }
                Equation::Coupled { vertices, vectors, constant } => {
                    rows.equation();
                    for (vertex, vector) in vertices.iter().zip(vectors) {
                        put(*vertex, *vector, rows);
                    }
                    rows.constant(Vector::new(constant, 0.0, 0.0));
                }
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        self.functional.describe()
    }

    fn by_number(&self, shape: usize) -> bool {
        self.functional.by_number(shape)
    }

    fn is_condition(&self) -> bool {
        self.functional.is_condition()
    }

    fn dimension(&self) -> Option<u8> {
        self.functional.dimension()
    }

    fn is_vector(&self) -> bool {
        self.functional.is_vector()
    }
}
