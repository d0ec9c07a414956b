//! The volume over a surface whose cells say their nets, asked for once: no rows are kept, and no gradient is made.

use loftsman_kernel::shape::{Border, CellNet, Derivative, Hole, Shape};
use loftsman_kernel::spline::gram::gauss_legendre;
use loftsman_kernel::{Point, Result, Vector, parallel};

use crate::members::Member;
use crate::nets::{Line, Nets, Row, Total};

/// Holes that one thread looks at in a run.
const RUN: usize = 64;
/// The degrees whose rules are made beforehand.
const USUAL: [usize; 2] = [2, 3];

/// `⅓ ∫∫ (S - o)·(S_u × S_v) du dv` over the cells and the cones over their holes, and the sum of the sizes of what these have of it; `None` where the
/// cells say no nets. By Gauss points that are exact: the integrand has degree `3p - 1` in each direction. Cost: for a bicubic cell 25 points of a patch,
/// for a hole eight stencils.
pub(crate) fn volume(surface: &Member<'_>, origin: &Point) -> Option<Result<(f64, f64)>> {
    if surface.cells.senses().is_some() {
        return None;
    }
    let nets = Nets::of(surface)?;
    // Taken from where the surface is: far from an origin what is added for that is the same for all of it, and closed surfaces have none of it.
    let way = nets.origin - origin;
    Some(terms(surface, &nets).map(|terms| {
        let (mut own, mut size) = (Total::default(), Total::default());
        let mut across = [Total::default(); 3];
        for Flux { volume, area } in terms {
            own.add(volume);
            size.add((volume + way.dot(&area) / 3.0).abs());
            across.iter_mut().zip(&area).for_each(|(sum, term)| sum.add(*term));
        }
        let across = Vector::from(across.map(Total::value));
        (own.value() + way.dot(&across) / 3.0, size.value())
    }))
}

/// What a cell or the cones over a hole have, from the middle of the surface.
#[derive(Clone, Copy, Default)]
struct Flux {
    /// `⅓ ∫∫ S·(S_u × S_v) du dv`.
    volume: f64,
    /// `∫∫ S_u × S_v du dv`.
    area: Vector,
}

/// What each cell and the cones over each hole have.
fn terms(surface: &Member<'_>, nets: &Nets<'_>) -> Result<Vec<Flux>> {
    let (usual, origin) = (USUAL.map(Rule::new), &nets.origin);
    let mut all = nets.map(origin, Row::default, |row, net| {
        let [u, v] = net.sides.map(|side| side.degree);
        let known = |degree: usize| usual.iter().find(|rule| rule.degree == degree);
        match (known(u), known(v)) {
            (Some(u), Some(v)) => of_cell(&net, u, v, row),
            _ => of_cell(&net, &Rule::new(u), &Rule::new(v), row),
        }
    })?;
    let holes = surface.cells.holes();
    let runs: Vec<&[Hole]> = holes.chunks(RUN).collect();
    let made = parallel::map(runs.len(), |k| {
        let mut fans = Fans::default();
        runs[k].iter().map(|hole| fans.of_hole(surface.shape, hole, origin)).collect::<Result<Vec<Flux>>>()
    });
    for run in made {
        all.extend(run?);
    }
    Ok(all)
}

/// Gauss points that are exact for volumes of a degree.
struct Rule {
    degree: usize,
    line: Line,
    weights: Vec<f64>,
}

impl Rule {
    fn new(degree: usize) -> Self {
        let (nodes, weights) = gauss_legendre((3 * degree).div_ceil(2).max(1));
        Self { degree, line: Line::new(degree, nodes.into_iter()), weights }
    }
}

fn of_cell(net: &CellNet<'_>, u: &Rule, v: &Rule, row: &mut Row) -> Flux {
    let Some(first) = net.points.first() else { return Flux::default() };
    let mut sum = Flux::default();
    for (x, weight) in u.weights.iter().enumerate() {
        row.fill(net.points, [&u.line, &v.line], x, true);
        let (mut along, mut normals) = (0.0, [0.0; 3]);
        for (k, by) in v.weights.iter().enumerate() {
            let share = |a: usize| row.points[a][k] * row.normals[a][k];
            along += by * (share(0) + share(1) + share(2));
            normals.iter_mut().enumerate().for_each(|(a, sum)| *sum += by * row.normals[a][k]);
        }
        sum.volume += weight * along;
        sum.area += Vector::from(normals) * *weight;
    }
    Flux { volume: (sum.volume + first.dot(&sum.area)) / 3.0, ..sum }
}

/// `∫ (l_i l_j' - l_i' l_j) dt` of the polynomials that are 1 at one node each, for the degrees that were asked for.
#[derive(Default)]
struct Fans(Vec<Fan>);

struct Fan {
    nodes: Vec<f64>,
    /// For each pair of nodes, the lower first.
    pairs: Vec<(usize, usize, f64)>,
}

impl Fans {
    /// The volume of the cones over the border of a hole: with the apex `c` and a border `b`, `⅙ ∫ c·((b - c) × b') dt`, which is what is between
    /// the origin and the cone.
    fn of_hole(&mut self, shape: &dyn Shape, hole: &Hole, origin: &Point) -> Result<Flux> {
        let value = |at: [f64; 2]| -> Result<Vector> {
            let row = shape.stencil(hole.at(at), Derivative::POSITION)?;
            Ok(row.iter().map(|(v, c)| (shape.control_vertices()[v] - origin) * c).sum())
        };
        let apex = value(hole.apex)?;
        let mut last: Option<([f64; 2], Vector)> = None;
        let mut area = Vector::zeros();
        let mut points = Vec::new();
        for border in &hole.border {
            let fan = self.of_degree(border);
            points.clear();
            for &t in &fan.nodes {
                // Where one border starts the last one ends.
                let at = border.at(t);
                let known = last.filter(|(place, _)| t == 0.0 && *place == at).map(|(_, known)| known);
                points.push(match known {
                    Some(known) => known,
                    None => value(at)? - apex,
                });
            }
            last = points.last().map(|&end| (border.to, end));
            area += fan.pairs.iter().map(|&(i, j, c)| points[i].cross(&points[j]) * c).sum::<Vector>();
        }
        Ok(Flux { volume: apex.dot(&area) / 6.0, area: area * 0.5 })
    }

    fn of_degree(&mut self, border: &Border) -> &Fan {
        let degree = border.degree.max(1);
        let at = match self.0.iter().position(|fan| fan.nodes.len() == degree + 1) {
            Some(at) => at,
            None => {
                self.0.push(Fan::new(degree));
                self.0.len() - 1
            }
        };
        &self.0[at]
    }
}

impl Fan {
    /// Nodes at the ends and, denser towards these, between them; of polynomials of a degree from 1 on.
    fn new(degree: usize) -> Self {
        let nodes: Vec<f64> = (0..=degree)
            .map(|k| {
                let half = (0.5 * std::f64::consts::PI * k as f64 / degree as f64).sin();
                half * half
            })
            .collect();
        let (places, weights) = gauss_legendre(degree + 1);
        // Value and slope of the polynomial of a node.
        let at = |k: usize, t: f64| {
            let (mut value, mut slope) = (1.0, 0.0);
            for (_, node) in nodes.iter().enumerate().filter(|(j, _)| *j != k) {
                let by = 1.0 / (nodes[k] - node);
                slope = (slope * (t - node) + value) * by;
                value *= (t - node) * by;
            }
            (value, slope)
        };
        let pair = |i: usize, j: usize| {
            let product = |(t, weight): (&f64, &f64)| {
                let ((a, da), (b, db)) = (at(i, *t), at(j, *t));
                weight * (a * db - da * b)
            };
            (i, j, places.iter().zip(&weights).map(product).sum())
        };
        let pairs = (0..=degree).flat_map(|j| (0..j).map(move |i| (i, j))).map(|(i, j)| pair(i, j)).collect();
        Self { nodes, pairs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ b × b' dt` of polynomials by their coefficients: of `a + b t` it is `a × b`, of `t e₁ + t² e₂` a third of `e₁ × e₂`.
    #[test]
    fn fans_are_those_of_polynomials() {
        for degree in 1..=6 {
            let fan = Fan::new(degree);
            assert!(fan.nodes[0] == 0.0 && (fan.nodes[degree] - 1.0).abs() < 1e-15);
            let powers = |m: i32, n: i32| -> f64 {
                let at = |k: usize, power: i32| fan.nodes[k].powi(power);
                fan.pairs.iter().map(|&(i, j, c)| c * (at(i, m) * at(j, n) - at(j, m) * at(i, n))).sum()
            };
            for m in 0..degree as i32 {
                let n = degree as i32;
                let exact = f64::from(n - m) / f64::from(m + n);
                assert!((powers(m, n) - exact).abs() < 1e-13, "{degree}: {m}, {n}");
            }
        }
    }
}
