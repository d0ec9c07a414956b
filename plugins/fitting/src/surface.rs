//! Surfaces through, or near to, a grid of points: the engines of curves, once along `u` and once along `v`.

use loftsman_kernel::spline::{Curve, Space, Surface};
use loftsman_kernel::{Point, Vector};

use crate::banded::Stencils;
use crate::error::{Astray, FitError, Result};
use crate::frame::Frame;
use crate::knots;
use crate::measure::{Course, LIMIT, length};
use crate::parameters::{Parametrization, coincident};
use crate::solve::solve;

const ADVICE: &str = "ask for fewer vertices, a lower degree, or (closed directions) an odd degree";

const ASTRAY: &str = "try centripetal parameters, a lower degree, or fewer vertices";
/// A line of points in one place may become a ring about it: this many of its errors long.
const AROUND: f64 = 8.0;
/// Lengths below this are rounding.
const ROUNDING: f64 = 1e-11;

/// Fits a tensor-product B-spline surface to a full grid of points; entry 0 of each pair is along `u` (from row to
/// row), entry 1 along `v` (within a row).
///
/// ```
/// # use loftsman_fitting::GridFit;
/// # use loftsman_kernel::Point;
/// let grid: Vec<Point> = (0..6 * 8).map(|k| Point::new((k / 8) as f64, (k % 8) as f64, (k as f64).sin())).collect();
/// let through = GridFit::new([3, 3]).surface(8, &grid)?;
/// assert!(through.max_error < 1e-13);
/// # Ok::<(), loftsman_fitting::FitError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GridFit {
    /// The degrees, 1 to 25.
    pub degree: [usize; 2],
    /// Which directions close smoothly (periodic) from the last row or column to the first.
    pub closed: [bool; 2],
    /// How many control vertices each way, for least squares; `None` passes through every point.
    pub vertices: [Option<usize>; 2],
    /// Which parameters rows and columns get: each the mean over the lines across.
    pub parameters: Parametrization,
}

/// A surface and how near it comes to its points.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedSurface {
    /// The surface.
    pub surface: Surface,
    /// The parameters of the rows, and of the columns.
    pub parameters: [Vec<f64>; 2],
    /// The largest distance of a point from the surface at its parameters, in document units.
    pub max_error: f64,
    /// The index of the point that has it.
    pub worst: usize,
    /// The root of the mean square of the distances.
    pub rms_error: f64,
    /// Estimates of the condition numbers of the equations along `u` and `v`.
    pub condition: [f64; 2],
}

impl GridFit {
    /// Through every point, open both ways, by chord length.
    pub fn new(degree: [usize; 2]) -> Self {
        Self { degree, closed: [false; 2], vertices: [None; 2], parameters: Parametrization::default() }
    }

    /// The surface for a grid given row after row, `columns` points each.
    ///
    /// The least-squares problem of a full grid separates: fitting all columns along `u` and then the vertices so
    /// found along `v` is the fit of the whole (de Boor 1979). `O(rows · columns · p²)`.
    ///
    /// # Errors
    /// When the grid is not full, a coordinate is not finite, whole rows or columns coincide, or there are too few
    /// of them for the degree or the vertices asked for; [`FitError::Astray`] where a line of the surface, measured on
    /// the surface that would be handed out, does not go where its points go: bounds as for curves
    /// ([`Fit`](crate::Fit)), and halfway between two lines of points no line is longer than twice the longer of them.
    pub fn surface(&self, columns: usize, points: &[Point]) -> Result<FittedSurface> {
        if columns == 0 || points.is_empty() || !points.len().is_multiple_of(columns) {
            return Err(FitError::Request(format!(
                "{} points do not make rows of {columns}: give a full grid",
                points.len()
            )));
        }
        let rows = points.len() / columns;
        let frame = Frame::of(points)?;
        let local: Vec<Vector> = points.iter().map(|&p| frame.enter(p)).collect();
        let line = |direction: usize, across: usize| -> Vec<Vector> {
            if direction == 0 {
                local.iter().skip(across).step_by(columns).copied().collect()
            } else {
                local[across * columns..(across + 1) * columns].to_vec()
            }
        };
        let sites_u = self.sites(0, columns, |across| line(0, across))?;
        let sites_v = self.sites(1, rows, |across| line(1, across))?;
        let (u, v) = (self.space(0, &sites_u)?, self.space(1, &sites_v)?);
        // Along u: a row of the grid is one right-hand side, all its columns at once.
        let rhs: Vec<f64> = local.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let along_u = Stencils::collocation(&u, &sites_u[..rows])?;
        let first = solve(&u, &along_u, None, &rhs, 3 * columns, ADVICE)?;
        // Along v: the same for the columns of vertices that are there now.
        let turned = transposed(&first.vertices, columns);
        let along_v = Stencils::collocation(&v, &sites_v[..columns])?;
        let second = solve(&v, &along_v, None, &turned, 3 * u.len(), ADVICE)?;
        let net = frame.raise(&transposed(&second.vertices, u.len()))?;
        let surface = Surface::new(u, v, net)?;
        let (mut max_error, mut worst, mut sum) = (0.0_f64, 0, 0.0);
        for (k, point) in local.iter().enumerate() {
            let at = surface.point(sites_u[k / columns], sites_v[k % columns])?;
            let distance = (frame.enter(at) - point).norm();
            if distance > max_error {
                (max_error, worst) = (distance, k);
            }
            sum += distance * distance;
        }
        let parameters = [sites_u[..rows].to_vec(), sites_v[..columns].to_vec()];
        self.travels(&surface, &frame, &local, &parameters)?;
        Ok(FittedSurface {
            surface,
            parameters,
            max_error: frame.leave_length(max_error),
            worst,
            rms_error: frame.leave_length((sum / points.len() as f64).sqrt()),
            condition: [first.condition, second.condition],
        })
    }

    /// Whether the surface's lines through the points travel as these do, and are no longer between them.
    fn travels(
        &self,
        surface: &Surface,
        frame: &Frame,
        points: &[Vector],
        parameters: &[Vec<f64>; 2],
    ) -> Result<()> {
        let columns = parameters[1].len();
        let net: Vec<f64> = surface.points().iter().flat_map(|&p| <[f64; 3]>::from(frame.enter(p))).collect();
        let turned = transposed(&net, surface.v().len());
        // Lines along v at the parameters of the rows, then lines along u at those of the columns.
        for along in [1, 0] {
            let (across, along_space) =
                if along == 1 { (surface.u(), surface.v()) } else { (surface.v(), surface.u()) };
            let net = if along == 1 { &net } else { &turned };
            let index =
                |line: usize, k: usize| if along == 1 { line * columns + k } else { k * columns + line };
            let sites = &parameters[1 - along];
            let mut middles: Vec<f64> = sites.windows(2).map(|w| 0.5 * w[0] + 0.5 * w[1]).collect();
            middles.extend(
                self.closed[1 - along].then(|| 0.5 * (sites[sites.len() - 1] + sites[0] + across.length())),
            );
            let lines = lines(net, across, along_space, sites)?;
            let mut longest = Vec::with_capacity(lines.len());
            for (line, curve) in lines.iter().enumerate() {
                let own: Vec<Vector> = (0..parameters[along].len()).map(|k| points[index(line, k)]).collect();
                let course = Course {
                    points: &own,
                    sites: &parameters[along],
                    closed: self.closed[along],
                    corners: &[],
                };
                let error = course.distances(curve)?.into_iter().fold(0.0, f64::max);
                let travel = course.travel(curve, error)?;
                // A line that is drawn together in a point may run around in its error.
                let allowance = AROUND * error + ROUNDING;
                let free = travel.polygon <= allowance;
                if let Some(astray) = travel.trouble(&LIMIT, allowance, free) {
                    let astray = astray.renumbered(|k| index(line, k));
                    return Err(FitError::Astray { astray, advice: ASTRAY });
                }
                longest.push((travel.polygon, allowance));
            }
            for (j, curve) in self::lines(net, across, along_space, &middles)?.iter().enumerate() {
                let (here, next) = (longest[j], longest[(j + 1) % longest.len()]);
                let polygon = here.0.max(next.0);
                let length = length(curve)?;
                if length > LIMIT.length * polygon + here.1.max(next.1) {
                    return Err(FitError::Astray { astray: Astray::Long(length / polygon), advice: ASTRAY });
                }
            }
        }
        Ok(())
    }

    /// The mean of the parameters of all lines in a direction; lines that are a single point have no say.
    fn sites(&self, direction: usize, lines: usize, line: impl Fn(usize) -> Vec<Vector>) -> Result<Vec<f64>> {
        let mut sum: Vec<f64> = Vec::new();
        let mut counted = 0.0;
        for across in 0..lines {
            match self.parameters.of_local(&line(across), self.closed[direction]) {
                Ok(sites) if sum.is_empty() => sum = sites,
                Ok(sites) => sum.iter_mut().zip(sites).for_each(|(s, u)| *s += u),
                Err(FitError::AllEqual { .. }) => continue,
                Err(error) => return Err(error),
            }
            counted += 1.0;
        }
        let name = ["rows", "columns"][direction];
        if sum.len() < 2 {
            return Err(FitError::Request(format!(
                "all {name} of the grid coincide: a surface needs two places"
            )));
        }
        for u in &mut sum {
            *u /= counted;
        }
        match coincident(&sum).first() {
            None => Ok(sum),
            Some(&k) => Err(FitError::Request(format!(
                "{name} {} and {} of the grid coincide: leave one out",
                k - 1,
                k % (sum.len() - usize::from(self.closed[direction]))
            ))),
        }
    }

    fn space(&self, direction: usize, sites: &[f64]) -> Result<Space> {
        let (degree, closed) = (self.degree[direction], self.closed[direction]);
        if degree == 0 || degree > loftsman_kernel::error::MAX_DEGREE {
            return Err(loftsman_kernel::Error::Degree { degree }.into());
        }
        let lines = sites.len() - usize::from(closed);
        let least = if closed { 3 } else { degree + 1 };
        if lines < least {
            return Err(FitError::TooFewPoints {
                found: lines,
                needed: least,
                degree,
                possible: lines.saturating_sub(1),
            });
        }
        match self.vertices[direction] {
            None if closed => knots::around(degree, sites),
            None => knots::averaged(degree, sites),
            Some(n) if n < least || n > lines => Err(FitError::Request(format!(
                "{n} control vertices cannot be fitted to {lines} lines of points: choose from {least} to {lines}"
            ))),
            Some(n) if closed => Ok(Space::periodic(degree, knots::shared(sites, n))?),
            Some(n) => {
                let space = Space::clamped(degree, &knots::shared(sites, n - degree))?;
                knots::check_data(&space, sites)?;
                Ok(space)
            }
        }
    }
}

/// The lines of a surface at parameters `across` it, as curves along: each vertex a sum of `p + 1` of the net's.
fn lines(net: &[f64], across: &Space, along: &Space, at: &[f64]) -> Result<Vec<Curve>> {
    let stencils = Stencils::collocation(across, at)?;
    let n = along.len();
    let curve = |line: usize| {
        let (start, values) = stencils.row(line);
        let vertex = |j: usize| {
            let sum = |axis: usize| {
                let term =
                    |(c, value): (usize, &f64)| value * net[3 * ((start + c) % across.len() * n + j) + axis];
                values.iter().enumerate().map(term).sum::<f64>()
            };
            Point::new(sum(0), sum(1), sum(2))
        };
        Ok(Curve::new(along.clone(), (0..n).map(vertex).collect())?)
    };
    (0..at.len()).map(curve).collect()
}

/// A grid of points of three numbers each, its rows (of `columns` points) and columns exchanged.
fn transposed(grid: &[f64], columns: usize) -> Vec<f64> {
    let points = grid.as_chunks::<3>().0;
    let rows = points.len() / columns;
    (0..columns).flat_map(|j| (0..rows).flat_map(move |i| points[i * columns + j])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn torus(rows: usize, columns: usize) -> Vec<Point> {
        let turn = |k: usize, n: usize| std::f64::consts::TAU * k as f64 / n as f64;
        (0..rows * columns)
            .map(|k| (turn(k / columns, rows), turn(k % columns, columns)))
            .map(|(a, b)| {
                let r = 3.0 + b.cos();
                Point::new(r * a.cos(), r * a.sin(), b.sin())
            })
            .collect()
    }

    #[test]
    fn passes_through_every_point_open_and_closed() {
        for closed in [[false, false], [true, false], [false, true], [true, true]] {
            for degree in [[1, 3], [3, 2], [2, 5]] {
                let fit = GridFit { closed, ..GridFit::new(degree) };
                let through = fit.surface(9, &torus(12, 9)).unwrap();
                assert!(through.max_error < 1e-13, "{closed:?} {degree:?}: {:e}", through.max_error);
                assert_eq!([through.surface.u().len(), through.surface.v().len()], [12, 9]);
            }
        }
    }

    #[test]
    fn least_squares_reproduces_a_surface_of_the_space_and_nears_a_torus() {
        let grid: Vec<Point> = (0..21 * 16)
            .map(|k| ((k / 16) as f64 / 20.0, (k % 16) as f64 / 15.0))
            .map(|(u, v)| Point::new(u, v, u * u * v - 2.0 * v * v * v))
            .collect();
        let parameters = Parametrization::Uniform;
        let fit = GridFit { vertices: [Some(6), Some(5)], parameters, ..GridFit::new([3, 3]) };
        assert!(fit.surface(16, &grid).unwrap().max_error < 1e-14);
        let ring = GridFit { closed: [true; 2], vertices: [Some(12); 2], ..GridFit::new([3, 3]) };
        let fitted = ring.surface(40, &torus(50, 40)).unwrap();
        assert!(fitted.max_error < 5e-3 && fitted.rms_error > 0.0);
        assert_eq!(fitted.surface.points().len(), 144);
    }

    #[test]
    fn grids_that_cannot_be() {
        let fit = GridFit::new([3, 3]);
        assert!(matches!(fit.surface(5, &torus(4, 4)), Err(FitError::Request(_))));
        assert!(matches!(fit.surface(0, &torus(4, 4)), Err(FitError::Request(_))));
        assert!(fit.surface(1, &[]).is_err());
        assert!(matches!(fit.surface(3, &torus(4, 3)), Err(FitError::TooFewPoints { found: 3, .. })));
        let mut doubled = torus(5, 4);
        doubled.extend_from_within(16..);
        let error = fit.surface(4, &doubled).unwrap_err().to_string();
        assert!(error.contains("rows 4 and 5"), "{error}");
        assert!(fit.surface(4, &[Point::origin(); 16]).is_err());
        // One edge drawn together in a point is no obstacle.
        let fan: Vec<Point> = (0..25)
            .map(|k| (f64::from(k / 5), f64::from(k % 5)))
            .map(|(r, a)| Point::new(r * (0.3 * a).cos(), r * (0.3 * a).sin(), r))
            .collect();
        assert!(fit.surface(5, &fan).unwrap().max_error < 1e-14);
    }
}
