//! The loops that bound a part of a surface, as polygons in its parameter plane, and a mask of what is inside them.

use loftsman_kernel::Result;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::trimmed::{ParameterCurve, Trimmed};

/// Steps of a curved loop from knot to knot.
const STEPS: usize = 24;
/// Steps of a loop through the whole domain of a surface: a straight line of parameters bends as the surface does. As many a span of
/// the surface, and no fewer, and no more, than these.
const ACROSS_A_SPAN: f64 = 16.0;
const ACROSS: [f64; 2] = [64.0, 2048.0];

/// Cells of a mask each way: what is inside is decided to within a thousandth of the domain.
const CELLS: usize = 1024;

/// What counts of a surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Trim {
    /// The loops, as parameters; each closes at its first point.
    pub(crate) loops: Vec<Vec<[f64; 2]>>,
    /// Whether the whole domain counts where no loop is about a place.
    whole: bool,
}

impl Trim {
    /// The loops of a trimmed surface; `None` where all of it counts.
    ///
    /// # Errors
    /// When a curve overflows.
    pub(crate) fn of(trimmed: &Trimmed) -> Result<Option<Self>> {
        let loops: Vec<Vec<[f64; 2]>> =
            trimmed.loops().map(|chain| flattened(chain, trimmed.surface())).collect::<Result<_>>()?;
        let whole = trimmed.regions().iter().any(|region| region.outer.is_empty());
        Ok((!loops.is_empty()).then_some(Self { loops, whole }))
    }
}

fn flattened(chain: &[ParameterCurve], surface: &Surface) -> Result<Vec<[f64; 2]>> {
    let mut points = Vec::new();
    // Steps a parameter, each way.
    let density = [surface.u(), surface.v()].map(|space| {
        let (low, high) = space.domain();
        let spans = space.breakpoints().len().saturating_sub(1) as f64;
        (ACROSS_A_SPAN * spans).clamp(ACROSS[0], ACROSS[1]) / (high - low)
    });
    for part in chain {
        let (curve, (from, to)) = (part.curve(), part.range());
        let inner = curve.space().breakpoints().into_iter().filter(|u| *u > from && *u < to);
        let breaks: Vec<f64> = [from].into_iter().chain(inner).chain([to]).collect();
        let straight = curve.space().degree() == 1 && curve.weights().is_none();
        for span in breaks.windows(2) {
            let (p, q) = (curve.point(span[0])?, curve.point(span[1])?);
            let across = [(q.x - p.x) * density[0], (q.y - p.y) * density[1]].map(f64::abs);
            // The cast saturates, and a range of parameters is within the domain or not far from it.
            let across = (across[0].max(across[1]).ceil() as usize).clamp(1, ACROSS[1] as usize);
            let steps = if straight { across } else { across.max(STEPS) };
            for i in 0..steps {
                let p = curve.point(span[0] + (span[1] - span[0]) * (i as f64 / steps as f64))?;
                points.push([p.x, p.y]);
            }
        }
    }
    Ok(points)
}

/// Cells of a surface's domain that count.
#[derive(Debug)]
pub(crate) struct Mask {
    domain: [(f64, f64); 2],
    cells: Vec<bool>,
}

impl Mask {
    /// Fills the cells inside an odd number of loops, row by row.
    pub(crate) fn new(trim: &Trim, surface: &Surface) -> Self {
        let domain = [surface.u().domain(), surface.v().domain()];
        let unit = |at: [f64; 2]| {
            [0, 1].map(|i| (at[i] - domain[i].0) / (domain[i].1 - domain[i].0) * CELLS as f64 - 0.5)
        };
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); CELLS];
        for points in &trim.loops {
            for (i, p) in points.iter().enumerate() {
                let (p, q) = (unit(*p), unit(points[(i + 1) % points.len()]));
                let (low, high) = (p[0].min(q[0]), p[0].max(q[0]));
                let (first, end) =
                    (low.ceil().max(0.0) as usize, high.ceil().clamp(0.0, CELLS as f64) as usize);
                for (row, list) in crossings.iter_mut().enumerate().take(end).skip(first) {
                    list.push(p[1] + (q[1] - p[1]) * ((row as f64 - p[0]) / (q[0] - p[0])));
                }
            }
        }
        let mut cells = Vec::with_capacity(CELLS * CELLS);
        for list in &mut crossings {
            list.sort_by(f64::total_cmp);
            let mut passed = 0;
            for column in 0..CELLS {
                while list.get(passed).is_some_and(|x| *x <= column as f64) {
                    passed += 1;
                }
                cells.push((passed % 2 == 1) != trim.whole);
            }
        }
        Self { domain, cells }
    }

    /// Whether a place counts.
    pub(crate) fn has(&self, at: [f64; 2]) -> bool {
        let [row, column] = [0, 1].map(|i| {
            let (low, high) = self.domain[i];
            // The cast saturates.
            (((at[i] - low) / (high - low) * CELLS as f64) as usize).min(CELLS - 1)
        });
        self.cells[row * CELLS + column]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use loftsman_kernel::Point;
    use loftsman_kernel::spline::trimmed::Region;
    use loftsman_kernel::spline::{Curve, Space};

    #[test]
    fn a_disc_with_a_hole_has_its_area() {
        let (u, v) = (Space::clamped(1, &[0.0, 2.0]).unwrap(), Space::clamped(1, &[-1.0, 1.0]).unwrap());
        let surface = Surface::new(u, v, vec![Point::origin(); 4]).unwrap();
        let circle = |radius: f64| {
            let w = 0.5_f64.sqrt();
            let net = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
            let net = net.map(|[x, y]| Point::new(1.0 + radius * f64::from(x), radius * f64::from(y), 0.0));
            let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0].to_vec();
            let weights = [1.0, w, 1.0, w, 1.0, w, 1.0, w, 1.0].to_vec();
            let curve = Curve::rational(Space::open(2, knots).unwrap(), net.to_vec(), weights).unwrap();
            vec![ParameterCurve::whole(curve).unwrap()]
        };
        for (outer, expected) in [(circle(0.8), 0.64 - 0.16), (Vec::new(), 4.0 / std::f64::consts::PI - 0.16)]
        {
            let region = Region { outer, holes: vec![circle(0.4)] };
            let trimmed = Trimmed::new(surface.clone(), vec![region], Vec::new(), Vec::new()).unwrap();
            let trim = Trim::of(&trimmed).unwrap().unwrap();
            let mask = Mask::new(&trim, &surface);
            let share = mask.cells.iter().filter(|c| **c).count() as f64 / (CELLS * CELLS) as f64;
            assert!((share * 4.0 - expected * std::f64::consts::PI).abs() < 0.01, "{share}");
            assert!(!mask.has([1.0, 0.0]) && mask.has([1.6, 0.0]));
        }
        let whole = Trimmed::new(surface, Vec::new(), Vec::new(), Vec::new()).unwrap();
        assert_eq!(Trim::of(&whole).unwrap(), None);
    }

    /// A straight line of parameters bends as its surface does: here through four spans of it, so that there are as many steps in each.
    #[test]
    fn straight_lines_of_parameters_have_steps_in_each_span() {
        let u = Space::clamped(3, &[0.0, 1.0, 2.0, 3.0, 4.0]).unwrap();
        let v = Space::clamped(1, &[0.0, 1.0]).unwrap();
        let net =
            (0..14).map(|k| Point::new(f64::from(k / 2), f64::from(k % 2), f64::from(k / 2 % 2))).collect();
        let surface = Surface::new(u, v, net).unwrap();
        let corners = [[0.0, 0.25], [4.0, 0.25], [4.0, 0.75], [0.0, 0.75], [0.0, 0.25]];
        let outline = Curve::new(
            Space::clamped(1, &[0.0, 1.0, 2.0, 3.0, 4.0]).unwrap(),
            corners.map(|[u, v]| Point::new(u, v, 0.0)).to_vec(),
        );
        let outer = vec![ParameterCurve::whole(outline.unwrap()).unwrap()];
        let region = Region { outer, holes: Vec::new() };
        let trimmed = Trimmed::new(surface, vec![region], Vec::new(), Vec::new()).unwrap();
        let trim = Trim::of(&trimmed).unwrap().unwrap();
        let [points] = &trim.loops[..] else { panic!("one loop") };
        for pair in points.windows(2) {
            assert!((pair[1][0] - pair[0][0]).abs() <= 4.0 / 64.0 + 1e-12, "{pair:?}");
            assert!((pair[1][1] - pair[0][1]).abs() <= 1.0 / 64.0 + 1e-12, "{pair:?}");
        }
        assert_eq!(points.len(), 2 * (64 + 32));
    }
}
