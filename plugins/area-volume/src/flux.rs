//! Integrals over a surface of its normal against basis functions, by sum factorisation.

use loftsman_kernel::error::Error;
use loftsman_kernel::shape::Splines;
use loftsman_kernel::spline::Space;
use loftsman_kernel::{Point, Result, Vector};

use crate::rule::Rule;

/// `F_ij = ∫∫ h R_ij (S_u × S_v) du dv` for `h = 1`, or for `h = 1, x, y, z`: what volume and first moments, and their
/// gradients, are made of. With `o` the origin of coordinates, `3V = Σ F_ij·P_ij` and `4M_h = Σ F^h_ij·P_ij`.
///
/// The integrand is a sum of products of a function of `u` and one of `v`: vertices are first combined along `v` at all
/// Gauss points, then along `u`; the results go back the same way. `O(m² n² p)` for `n²` vertices and `m` points a span,
/// all in loops over neighbouring numbers, and never a tensor of more indices. Strips of spans are done one after another,
/// so that what is at work stays in the cache.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flux {
    u: RuleOf,
    v: RuleOf,
    rows: usize,
    columns: usize,
    weights: Option<Vec<f64>>,
    moments: bool,
}

/// A rule, compared by what it was made from.
#[derive(Debug, Clone)]
struct RuleOf(Rule);

impl PartialEq for RuleOf {
    fn eq(&self, other: &Self) -> bool {
        self.0.weights == other.0.weights && self.0.values == other.0.values
    }
}

/// Gauss points of a strip, at most; its rows then fit into the first cache.
const STRIP: usize = 96;
/// Points on a span beyond which a rational surface's spans are divided instead.
pub(crate) const MOST: usize = 24;
/// A rational surface's integrals are refined until they change by less than this.
pub(crate) const SETTLED: f64 = 1e-13;
/// Integrals below this share of the squared size, for each vertex, are what rounding makes of none.
const NOTHING: f64 = 1e3 * f64::EPSILON;
/// Changes below this share of it are rounding of the terms that cancel where the area is next to none.
const CANCELLED: f64 = 64.0 * f64::EPSILON;
/// No rule of more points than this is tried (about a second), but for large surfaces one three times as fine as the first.
const POINTS: usize = 1 << 22;

/// The most points that a rule may have where the first one has so many.
pub(crate) fn most(first: usize) -> usize {
    POINTS.max(first.saturating_mul(9))
}

impl Flux {
    /// For the surfaces that differ from this one in their control vertices only; with `moments` for all four `h`. Exact
    /// for polynomial ones; for rational ones refined until the present integrals settle to 1e-13.
    pub(crate) fn new(splines: &Splines<'_>, v: &Space, vertices: &[Point], moments: bool) -> Result<Self> {
        let (u, weights) = (splines.u, splines.weights);
        let points = |space: &Space| {
            let p = space.degree();
            // The integrand has degree 3p - 1 in each direction, with moments 4p - 1.
            if moments { 2 * p } else { (3 * p).div_ceil(2) }
        };
        let make = |per: [usize; 2], parts: usize| Self {
            u: RuleOf(Rule::new(u, per[0], parts)),
            v: RuleOf(Rule::new(v, per[1], parts)),
            rows: u.len(),
            columns: v.len(),
            weights: weights.map(<[f64]>::to_vec),
            moments,
        };
        let mut per = [points(u), points(v)];
        let mut parts = 1;
        let mut flux = make(per, parts);
        if weights.is_none() {
            return Ok(flux);
        }
        let middle = crate::members::middle_of(vertices);
        let (mut work, mut last, mut now) = (Strip::default(), Vec::new(), Vec::new());
        flux.integrate(vertices, &middle, &mut work, &mut last);
        let count = |per: [usize; 2], parts: usize| {
            let along = |space: &Space, per: usize| space.spans().count().saturating_mul(per * parts);
            along(u, per[0]).saturating_mul(along(v, per[1]))
        };
        let most = most(count(per, parts));
        for _ in 0..12 {
            if per[0].max(per[1]) < MOST {
                per = [per[0] + u.degree() + 1, per[1] + v.degree() + 1];
            } else {
                parts *= 2;
            }
            if count(per, parts) > most {
                break;
            }
            let finer = make(per, parts);
            finer.integrate(vertices, &middle, &mut work, &mut now);
            if settled(&now, &last, vertices, &middle)? {
                return Ok(flux);
            }
            flux = finer;
            std::mem::swap(&mut last, &mut now);
        }
        Err(unsettled())
    }

    /// `F_ij` for each `h`, in the surface's order of vertices, into `out`; coordinates are taken from `origin`. Allocates
    /// nothing where `work` and `out` have been through it before.
    pub(crate) fn integrate(
        &self,
        points: &[Point],
        origin: &Point,
        work: &mut Strip,
        out: &mut Vec<Vec<Vector>>,
    ) {
        out.resize_with(if self.moments { 4 } else { 1 }, Vec::new);
        for out in out.iter_mut() {
            out.clear();
            out.resize(points.len(), Vector::zeros());
        }
        let panels = self.v.0.panels();
        let strip = (STRIP / self.v.0.per).max(1);
        for first in (0..panels).step_by(strip) {
            self.strip(points, origin, first, (first + strip).min(panels), work, out);
        }
        if let Some(weights) = &self.weights {
            for out in out {
                out.iter_mut().zip(weights).for_each(|(f, w)| *f *= *w);
            }
        }
    }

    fn strip(
        &self,
        points: &[Point],
        origin: &Point,
        first: usize,
        last: usize,
        work: &mut Strip,
        out: &mut [Vec<Vector>],
    ) {
        let (u, v) = (&self.u.0, &self.v.0);
        let g = (last - first) * v.per;
        // Components of a homogeneous point: x, y, z and, of a rational surface, w.
        let c = if self.weights.is_some() { 4 } else { 3 };
        let kinds = out.len();
        work.resize(self.rows * c * g, self.rows * 3 * kinds * g, c * g, 3 * kinds * g);
        for i in 0..self.rows {
            let row = &points[i * self.columns..(i + 1) * self.columns];
            let weight = |j: usize| self.weights.as_ref().map(|w| w[i * self.columns + j]);
            let (values, slopes) = (&mut work.values[i * c * g..], &mut work.slopes[i * c * g..]);
            for panel in first..last {
                let vertices = v.vertices_of(panel);
                for x in 0..v.per {
                    let (n, d) = v.functions(panel * v.per + x);
                    let at = (panel - first) * v.per + x;
                    let (mut value, mut slope) = ([0.0; 4], [0.0; 4]);
                    for (k, &j) in vertices.iter().enumerate() {
                        let j = j as usize;
                        let p = row[j] - origin;
                        let w = weight(j).unwrap_or(1.0);
                        let h = [p.x * w, p.y * w, p.z * w, w];
                        for a in 0..c {
                            value[a] += n[k] * h[a];
                            slope[a] += d[k] * h[a];
                        }
                    }
                    for a in 0..c {
                        values[a * g + at] = value[a];
                        slopes[a * g + at] = slope[a];
                    }
                }
            }
        }
        work.back.fill(0.0);
        for panel in 0..u.panels() {
            let vertices = u.vertices_of(panel);
            for x in 0..u.per {
                let point = panel * u.per + x;
                let (n, d) = u.functions(point);
                combine(&work.values, vertices, d, c * g, &mut work.su);
                combine(&work.slopes, vertices, n, c * g, &mut work.sv);
                if c == 4 || kinds == 4 {
                    combine(&work.values, vertices, n, c * g, &mut work.s);
                }
                if c == 4 {
                    project(&mut work.s, &mut work.su, &mut work.sv, g);
                }
                let weight = u.weights[point];
                normals(&work.su, &work.sv, weight, g, &mut work.normal);
                if c == 4 {
                    // R_ij = w_ij N_i M_j / W: the weight of the vertex is put on at the end.
                    for a in 0..3 {
                        let normal = &mut work.normal[a * g..(a + 1) * g];
                        normal.iter_mut().zip(&work.s[3 * g..4 * g]).for_each(|(n, w)| *n /= w);
                    }
                }
                if kinds == 4 {
                    let (plain, scaled) = work.normal.split_at_mut(3 * g);
                    for h in 0..3 {
                        for a in 0..3 {
                            let to = &mut scaled[(3 * h + a) * g..(3 * h + a + 1) * g];
                            let (s, n) = (&work.s[h * g..(h + 1) * g], &plain[a * g..(a + 1) * g]);
                            to.iter_mut().zip(s.iter().zip(n)).for_each(|(t, (s, n))| *t = s * n);
                        }
                    }
                }
                let length = 3 * kinds * g;
                for (k, &i) in vertices.iter().enumerate() {
                    let to = &mut work.back[i as usize * length..(i as usize + 1) * length];
                    let factor = n[k];
                    to.iter_mut().zip(&work.normal).for_each(|(t, n)| *t += factor * n);
                }
            }
        }
        for i in 0..self.rows {
            for panel in first..last {
                let vertices = v.vertices_of(panel);
                for x in 0..v.per {
                    let point = panel * v.per + x;
                    let (n, _) = v.functions(point);
                    let at = (panel - first) * v.per + x;
                    for (h, out) in out.iter_mut().enumerate() {
                        let back = &work.back[(i * kinds + h) * 3 * g..];
                        let weight = v.weights[point];
                        let normal = Vector::new(back[at], back[g + at], back[2 * g + at]) * weight;
                        for (k, &j) in vertices.iter().enumerate() {
                            out[i * self.columns + j as usize] += normal * n[k];
                        }
                    }
                }
            }
        }
    }
}

/// Whether integrals are the same by two rules, to rounding.
///
/// # Errors
/// When there is nothing but rounding: the surface has no area, as one that is swept along itself.
pub(crate) fn settled(
    now: &[Vec<Vector>],
    last: &[Vec<Vector>],
    vertices: &[Point],
    middle: &Point,
) -> Result<bool> {
    let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0_f64, f64::max);
    let reach = largest(&mut vertices.iter().map(|p| (p - middle).amax()));
    let normals = largest(&mut now.iter().take(1).flatten().map(|v| v.amax()));
    let share = reach * reach / vertices.len() as f64;
    if normals <= NOTHING * share {
        return Err(Error::Invalid("the surface has no area, and encloses nothing".into()));
    }
    let size = largest(&mut now.iter().flatten().map(|v| v.amax()));
    let change = largest(&mut now.iter().flatten().zip(last.iter().flatten()).map(|(a, b)| (a - b).amax()));
    Ok(change <= (SETTLED * size).max(CANCELLED * share))
}

/// By how much integrals differ by two rules, relative to the largest or to what the points could make.
pub(crate) fn change(now: &[Vec<Vector>], last: &[Vec<Vector>], vertices: &[Point], middle: &Point) -> f64 {
    let reach = vertices.iter().map(|p| (p - middle).amax()).fold(0.0, f64::max);
    let share = reach * reach / vertices.len().max(1) as f64;
    let size = now.iter().flatten().map(|v| v.amax()).fold(0.0, f64::max);
    let change = now.iter().flatten().zip(last.iter().flatten()).map(|(a, b)| (a - b).amax());
    change.fold(0.0, f64::max) / size.max(CANCELLED / SETTLED * share).max(f64::MIN_POSITIVE)
}

/// That a rational surface's integrals do not settle.
pub(crate) fn unsettled() -> Error {
    Error::Invalid(
        "the surface's weights differ too much for its volume to be told; insert knots where they do".into(),
    )
}

/// What a strip works with: for each row of vertices, component after component, the numbers at all Gauss points.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    values: Vec<f64>,
    slopes: Vec<f64>,
    back: Vec<f64>,
    s: Vec<f64>,
    su: Vec<f64>,
    sv: Vec<f64>,
    normal: Vec<f64>,
}

impl Strip {
    fn resize(&mut self, rows: usize, back: usize, line: usize, normal: usize) {
        self.values.resize(rows, 0.0);
        self.slopes.resize(rows, 0.0);
        self.back.resize(back, 0.0);
        for v in [&mut self.s, &mut self.su, &mut self.sv] {
            v.resize(line, 0.0);
        }
        self.normal.resize(normal, 0.0);
    }
}

/// `Σ factor · row` over the rows of a panel, `length` numbers each.
fn combine(rows: &[f64], vertices: &[u32], factors: &[f64], length: usize, out: &mut [f64]) {
    let row = |k: usize| &rows[vertices[k] as usize * length..][..length];
    let out = &mut out[..length];
    if let [a, b, c, d] = *factors {
        let (ra, rb, rc, rd) = (row(0), row(1), row(2), row(3));
        for i in 0..length {
            out[i] = (a * ra[i] + b * rb[i]) + (c * rc[i] + d * rd[i]);
        }
        return;
    }
    out.fill(0.0);
    for (k, factor) in factors.iter().enumerate() {
        out.iter_mut().zip(row(k)).for_each(|(o, r)| *o += factor * r);
    }
}

/// `weight · S_u × S_v`.
fn normals(su: &[f64], sv: &[f64], weight: f64, g: usize, out: &mut [f64]) {
    let [ux, uy, uz] = [&su[..g], &su[g..2 * g], &su[2 * g..3 * g]];
    let [vx, vy, vz] = [&sv[..g], &sv[g..2 * g], &sv[2 * g..3 * g]];
    let (x, rest) = out.split_at_mut(g);
    let (y, rest) = rest.split_at_mut(g);
    let z = &mut rest[..g];
    for i in 0..g {
        x[i] = weight * (uy[i] * vz[i] - uz[i] * vy[i]);
        y[i] = weight * (uz[i] * vx[i] - ux[i] * vz[i]);
        z[i] = weight * (ux[i] * vy[i] - uy[i] * vx[i]);
    }
}

/// From homogeneous points and derivatives to those of the surface; the weights `W` stay in the fourth place of `s`.
fn project(s: &mut [f64], su: &mut [f64], sv: &mut [f64], g: usize) {
    for i in 0..g {
        let (w, wu, wv) = (s[3 * g + i], su[3 * g + i], sv[3 * g + i]);
        for a in 0..3 {
            let at = a * g + i;
            s[at] /= w;
            su[at] = (su[at] - s[at] * wu) / w;
            sv[at] = (sv[at] - s[at] * wv) / w;
        }
    }
}
