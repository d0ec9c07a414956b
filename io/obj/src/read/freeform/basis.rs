//! One direction of a free-form element as a B-spline: knots, and the exact change of basis.
//!
//! A piece of degree `n` with control points `P_i` is a polynomial `Σ a_j t^j` of its local parameter `t ∈ [0, 1]`,
//! where `a = Mᵀ P` with the basis matrix `M`; its Bézier points are `b_k = Σ_{j ≤ k} C(k, j) / C(n, j) a_j`. Pieces
//! that meet become one spline with knots of multiplicity `n`.

use loftsman_kernel::spline::Space;
use loftsman_kernel::text::counted;

/// What the control points of an element mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Bspline,
    Bezier,
    Bmatrix,
    Cardinal,
    Taylor,
}

/// What is wrong with an element: an error, or a reason to leave it out.
#[derive(Debug)]
pub(crate) enum Problem {
    Wrong(String),
    LeftOut(String),
}

impl From<String> for Problem {
    fn from(text: String) -> Self {
        Self::Wrong(text)
    }
}

/// A new control point as a sum of the old ones.
type Row = Vec<(usize, f64)>;

/// One direction of an element as a B-spline.
#[derive(Debug)]
pub(crate) struct Form {
    /// How many control points it takes.
    pub(crate) count: usize,
    pub(crate) space: Space,
    /// The B-spline's control points; `None` where they are those of the file.
    rows: Option<Vec<Row>>,
    /// Where pieces meet: the end of one and the start of the next.
    joints: Vec<(Row, Row)>,
}

/// What the state says of one direction.
pub(crate) struct Direction<'a> {
    pub(crate) kind: Kind,
    pub(crate) degree: usize,
    /// `bmat`, row after row, one row a control point.
    pub(crate) matrix: Option<&'a [f64]>,
    pub(crate) step: Option<usize>,
    /// `parm`.
    pub(crate) parameters: Option<&'a [f64]>,
    /// How many control points there are, where known.
    pub(crate) count: Option<usize>,
    /// The parameters from which to which the element runs.
    pub(crate) range: (f64, f64),
}

impl Direction<'_> {
    /// The control points of one piece, and how many further the next one starts.
    pub(crate) fn window(&self) -> Result<(usize, usize), Problem> {
        let order = self.degree + 1;
        Ok(match self.kind {
            Kind::Bspline | Kind::Bezier => (order, self.degree),
            Kind::Taylor => (order, order),
            Kind::Cardinal if self.degree == 3 => (4, 1),
            Kind::Cardinal => {
                return Err(format!("cardinal splines are of degree 3, not {}", self.degree).into());
            }
            Kind::Bmatrix => match self.step {
                Some(step) => (order, step),
                None => return Err("bmatrix needs a step before it".to_owned().into()),
            },
        })
    }

    /// The B-spline form.
    pub(crate) fn form(&self) -> Result<Form, Problem> {
        if self.kind == Kind::Bspline {
            return self.bspline();
        }
        let n = self.degree;
        let (window, step) = self.window()?;
        let breaks = self.breaks(window, step)?;
        let pieces = breaks.len() - 1;
        let count = (pieces - 1) * step + window;
        let mut knots = Vec::with_capacity(pieces * n + n + 2);
        knots.extend(breaks.first());
        knots.extend(breaks.iter().flat_map(|&t| std::iter::repeat_n(t, n)));
        knots.extend(breaks.last());
        let space = Space::open(n, knots).map_err(|e| e.to_string())?;
        if self.kind == Kind::Bezier {
            return Ok(Form { count, space, rows: None, joints: Vec::new() });
        }
        let mut rows: Vec<Row> = Vec::with_capacity(pieces * n + 1);
        let mut joints = Vec::new();
        for (k, ends) in breaks.windows(2).enumerate() {
            let mut piece = self.piece(ends[0], ends[1])?.into_iter().map(|coefficients| -> Row {
                let shifted = coefficients.into_iter().enumerate().map(|(i, c)| (k * step + i, c));
                shifted.filter(|(_, c)| *c != 0.0).collect()
            });
            if let (Some(end), Some(start)) = (rows.last(), if k > 0 { piece.next() } else { None })
                && *end != start
            {
                joints.push((end.clone(), start));
            }
            rows.extend(piece);
        }
        Ok(Form { count, space, rows: Some(rows), joints })
    }

    /// A B-spline: `parm` holds its knots.
    fn bspline(&self) -> Result<Form, Problem> {
        let Some(knots) = self.parameters else {
            let needed =
                self.count.map_or(String::new(), |n| format!(": it needs {} values", n + self.degree + 1));
            return Err(format!("a B-spline has no parm{needed}").into());
        };
        let found = knots.len();
        let count = match self.count {
            Some(n) if found == n + self.degree + 1 => n,
            Some(n) => {
                let (p, needed) = (self.degree, n + self.degree + 1);
                return Err(format!(
                    "parm has {found} values: a B-spline of {n} vertices and degree {p} needs {needed}"
                )
                .into());
            }
            None => found.checked_sub(self.degree + 1).filter(|&n| n > 0).ok_or_else(|| {
                let (p, needed) = (self.degree, 2 * self.degree + 2);
                format!("parm has {found} values: a B-spline of degree {p} needs at least {needed}")
            })?,
        };
        let space = Space::open(self.degree, knots.to_vec()).map_err(|e| e.to_string())?;
        Ok(Form { count, space, rows: None, joints: Vec::new() })
    }

    /// The parameters where pieces meet: `parm`, or the range divided evenly.
    fn breaks(&self, window: usize, step: usize) -> Result<Vec<f64>, Problem> {
        let pieces = match self.count {
            Some(n) if n >= window && (n - window).is_multiple_of(step) => Some((n - window) / step + 1),
            Some(n) => {
                let p = self.degree;
                return Err(format!(
                    "{n} vertices do not make pieces of degree {p}: {window} are needed, and {step} more for each further piece"
                )
                .into());
            }
            None => None,
        };
        let breaks = match (self.parameters, pieces) {
            (Some(found), None) if found.len() >= 2 => found.to_vec(),
            (Some(found), None) => {
                return Err(
                    format!("parm has {}: at least 2 are needed", counted(found.len(), "value[|s]")).into()
                );
            }
            (Some(found), Some(pieces)) if found.len() == pieces + 1 => found.to_vec(),
            (Some(found), Some(pieces)) => {
                let (n, needed) = (found.len(), pieces + 1);
                return Err(format!(
                    "parm has {}: {} {needed}",
                    counted(n, "value[|s]"),
                    counted(pieces, "[piece needs|pieces need]")
                )
                .into());
            }
            (None, Some(pieces)) => {
                let (a, b) = self.range;
                let at = |k: usize| if k == pieces { b } else { a + (b - a) * (k as f64 / pieces as f64) };
                (0..=pieces).map(at).collect()
            }
            (None, None) => {
                return Err("a surface of several patches needs parm u and parm v".to_owned().into());
            }
        };
        match breaks.windows(2).position(|pair| pair[0] >= pair[1]) {
            Some(k) => Err(format!(
                "parm: {} is followed by {}, but the parameters between pieces must increase",
                breaks[k],
                breaks[k + 1]
            )
            .into()),
            None => Ok(breaks),
        }
    }

    /// The Bézier points of the piece between two parameters, as sums of its control points.
    fn piece(&self, start: f64, end: f64) -> Result<Vec<Vec<f64>>, Problem> {
        let n = self.degree;
        let power: Vec<Vec<f64>> = match self.kind {
            Kind::Bspline | Kind::Bezier => Vec::new(),
            // Through the two inner points, with half the differences of their neighbours as tangents.
            Kind::Cardinal => {
                let sixth = 1.0 / 6.0;
                return Ok(vec![
                    vec![0.0, 1.0, 0.0, 0.0],
                    vec![-sixth, 1.0, sixth, 0.0],
                    vec![0.0, sixth, 1.0, -sixth],
                    vec![0.0, 0.0, 1.0, 0.0],
                ]);
            }
            Kind::Bmatrix => {
                let Some(matrix) = self.matrix else {
                    return Err("bmatrix needs a bmat before it".to_owned().into());
                };
                let (found, needed) = (matrix.len(), (n + 1) * (n + 1));
                if found != needed {
                    let problem = format!("bmat has {found} values: degree {n} needs {needed}");
                    return Err(problem.into());
                }
                // Power j, control point i.
                (0..=n).map(|j| (0..=n).map(|i| matrix[i * (n + 1) + j]).collect()).collect()
            }
            // The coefficients are those of powers of the parameter itself, u = start + (end - start) t.
            Kind::Taylor => {
                let width = end - start;
                (0..=n)
                    .map(|k| {
                        let of = |j: usize| match j.checked_sub(k) {
                            Some(rest) => binomial(j, k) * start.powi(rest as i32) * width.powi(k as i32),
                            None => 0.0,
                        };
                        (0..=n).map(of).collect()
                    })
                    .collect()
            }
        };
        Ok((0..=n)
            .map(|k| {
                let sum = |i: usize| (0..=k).map(|j| binomial(k, j) / binomial(n, j) * power[j][i]).sum();
                (0..=n).map(sum).collect()
            })
            .collect())
    }
}

/// `C(n, k)`, exact for degrees in use.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k.min(n - k)).fold(1.0_f64, |c, i| (c * (n - i) as f64 / (i + 1) as f64).round())
}

/// How far pieces may be apart that are taken to meet, relative to the largest number: files print six digits.
const GAP: f64 = 1e-6;

impl Form {
    /// How many control points the B-spline has.
    pub(crate) fn len(&self) -> usize {
        self.rows.as_ref().map_or(self.count, Vec::len)
    }

    /// Whether the control points are those of the file.
    pub(crate) fn is_identity(&self) -> bool {
        self.rows.is_none()
    }

    /// The B-spline's control points out of those of the file, in homogeneous coordinates, for each of `across` rows
    /// that lie `stride` apart, as does what comes out.
    pub(crate) fn apply(&self, points: &[[f64; 4]], across: usize) -> Result<Vec<[f64; 4]>, Problem> {
        let Some(rows) = &self.rows else { return Ok(points.to_vec()) };
        // Entry i of row r is points[i * across + r].
        let sum = |row: &Row, r: usize| {
            row.iter().fold([0.0; 4], |mut sum, &(i, c)| {
                for (s, x) in sum.iter_mut().zip(points[i * across + r]) {
                    *s += c * x;
                }
                sum
            })
        };
        let size = points.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (end, start) in &self.joints {
            for r in 0..across {
                let (a, b) = (sum(end, r), sum(start, r));
                let gap = a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
                if gap > GAP * size {
                    return Err(Problem::LeftOut("its pieces do not meet".to_owned()));
                }
            }
        }
        Ok(rows.iter().flat_map(|row| (0..across).map(move |r| sum(row, r))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(kind: Kind, degree: usize, parameters: &[f64]) -> Direction<'_> {
        let range = (0.0, 1.0);
        Direction { kind, degree, matrix: None, step: None, parameters: Some(parameters), count: None, range }
    }

    #[test]
    fn a_bezier_matrix_is_the_identity() {
        let matrix = [1.0, -3.0, 3.0, -1.0, 0.0, 3.0, -6.0, 3.0, 0.0, 0.0, 3.0, -3.0, 0.0, 0.0, 0.0, 1.0];
        let parameters = [0.0, 1.0, 3.0];
        let bmatrix = direction(Kind::Bmatrix, 3, &parameters);
        let form = Direction { matrix: Some(&matrix), step: Some(3), ..bmatrix }.form().unwrap();
        assert_eq!((form.count, form.len(), form.joints.len()), (7, 7, 0));
        let points: Vec<[f64; 4]> = (0..7).map(|k| [f64::from(k * k), 1.0, f64::from(k), 0.5]).collect();
        for (a, b) in form.apply(&points, 1).unwrap().iter().flatten().zip(points.iter().flatten()) {
            assert!((a - b).abs() < 1e-13, "{a} {b}");
        }
    }

    #[test]
    fn pieces_that_are_apart_are_left_out() {
        let form = direction(Kind::Taylor, 1, &[0.0, 1.0, 2.0]).form().unwrap();
        let value = |x: f64| [x, 0.0, 0.0, 0.0];
        let meeting = [value(1.0), value(2.0), value(5.0), value(-2.0)];
        let converted = form.apply(&meeting, 1).unwrap();
        assert_eq!(converted.iter().map(|p| p[0]).collect::<Vec<_>>(), [1.0, 3.0, 1.0]);
        let apart = [value(1.0), value(2.0), value(4.0), value(-2.0)];
        assert!(matches!(form.apply(&apart, 1), Err(Problem::LeftOut(_))));
    }
}
