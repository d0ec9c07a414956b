//! B-spline curves and surfaces, in all the forms that the schema has for them.

use loftsman_kernel::Point;
use loftsman_kernel::spline::{Curve, Space as Knots, Surface};

use super::entity::{Args, At, Got, Problem};
use super::place::Space;
use crate::part21::{Entity, Value};

/// The types of a B-spline curve whose attributes may stand in one part.
pub(crate) const CURVES: [&str; 5] =
    ["B_SPLINE_CURVE_WITH_KNOTS", "BEZIER_CURVE", "UNIFORM_CURVE", "QUASI_UNIFORM_CURVE", "B_SPLINE_CURVE"];

/// The same of surfaces.
pub(crate) const SURFACES: [&str; 5] = [
    "B_SPLINE_SURFACE_WITH_KNOTS",
    "BEZIER_SURFACE",
    "UNIFORM_SURFACE",
    "QUASI_UNIFORM_SURFACE",
    "B_SPLINE_SURFACE",
];

/// Which knots a B-spline has.
enum Form<'e, 'f> {
    /// Those that are listed: multiplicities and values at these places.
    Listed(Args<'e, 'f>, usize),
    /// Whole numbers, the first and the last as often as the degree and one.
    Clamped,
    /// Whole numbers, each once.
    Floating,
    /// Whole numbers, inner ones as often as the degree.
    Bezier,
}

/// Whether an entity is a B-spline of one of these types.
pub(crate) fn is_one(entity: &Entity<'_>, of: &[&str; 5]) -> bool {
    of.iter().any(|name| entity.part(name).is_some())
}

/// The attributes that all forms have, the one with knots, and the weights.
fn attributes<'e, 'f>(
    entity: &'e Entity<'f>,
    of: &[&str; 5],
    own: usize,
) -> Got<(Args<'e, 'f>, Form<'e, 'f>, Option<&'e Value<'f>>)> {
    let simple = !entity.only().is_empty();
    // In an entity of several types the common attributes are without the name, which is another's.
    let common = if simple {
        let args = entity.args();
        Args { values: args.values.get(1..).unwrap_or_default(), ..args }
    } else {
        entity.of(of[4])?
    };
    let form = if entity.part(of[0]).is_some() {
        if simple { Form::Listed(common, own) } else { Form::Listed(entity.of(of[0])?, 0) }
    } else if entity.part(of[1]).is_some() {
        Form::Bezier
    } else if entity.part(of[2]).is_some() {
        Form::Floating
    } else if entity.part(of[3]).is_some() {
        Form::Clamped
    } else {
        return Err(Problem::new(
            entity.number,
            "a B-spline without knots: it says neither its own nor which usual ones",
        ));
    };
    let rational = ["RATIONAL_B_SPLINE_CURVE", "RATIONAL_B_SPLINE_SURFACE"];
    let weights = rational.iter().find_map(|name| entity.part(name)).and_then(|part| part.values.first());
    Ok((common, form, weights))
}

impl Form<'_, '_> {
    /// The space of so many vertices; `direction` is 0 along `u`, 1 along `v`, of `count` directions.
    fn knots(&self, degree: usize, vertices: usize, (direction, count): (usize, usize)) -> Got<Knots> {
        match self {
            Self::Listed(args, first) => {
                let multiplicities = args.counts(first + direction)?;
                let values = args.reals(first + count + direction)?;
                listed(args.number, degree, vertices, &multiplicities, &values)
            }
            Self::Clamped => Knots::clamped_uniform(degree, vertices).at(0),
            Self::Floating => Knots::floating_uniform(degree, vertices).at(0),
            Self::Bezier => {
                let pieces = vertices.saturating_sub(1) / degree.max(1);
                if pieces == 0 || pieces * degree + 1 != vertices {
                    let text = format!("{vertices} control points are no Bézier pieces of degree {degree}");
                    return Err(Problem::new(0, text));
                }
                let ends = |k: usize| if k == 0 || k == pieces { degree + 1 } else { degree };
                let all = (0..=pieces).flat_map(|k| std::iter::repeat_n(k as f64, ends(k)));
                Knots::open(degree, all.collect()).at(0)
            }
        }
    }
}

/// Knots and how often each is there.
fn listed(
    number: u64,
    degree: usize,
    vertices: usize,
    multiplicities: &[usize],
    values: &[f64],
) -> Got<Knots> {
    let problem = |text: String| Err(Problem::new(number, text));
    if multiplicities.len() != values.len() {
        return problem(format!("{} multiplicities for {} knots", multiplicities.len(), values.len()));
    }
    let needed = vertices.saturating_add(degree).saturating_add(1);
    let found = multiplicities.iter().fold(0_usize, |sum, &m| sum.saturating_add(m));
    if found != needed {
        return problem(format!(
            "{found} knots do not fit {vertices} control points of degree {degree}: {needed} are needed"
        ));
    }
    let all = values.iter().zip(multiplicities).flat_map(|(&knot, &m)| std::iter::repeat_n(knot, m));
    Knots::open(degree, all.collect()).at(number)
}

/// The weights of so many vertices; none where all are alike.
fn weights(number: u64, values: Option<Vec<f64>>) -> Got<Option<Vec<f64>>> {
    let Some(values) = values else { return Ok(None) };
    if let Some(bad) = values.iter().find(|w| **w <= 0.0 || w.is_nan()) {
        return Err(Problem::new(
            number,
            format!("the weight {bad} of a control point: it must be positive"),
        ));
    }
    Ok(Some(values))
}

impl Space<'_, '_> {
    /// A B-spline curve.
    pub(crate) fn spline_curve(&self, entity: &Entity<'_>) -> Got<Curve> {
        self.curve_with(entity, |points| self.points(points))
    }

    /// A B-spline curve of two coordinates, which are parameters of a surface: no lengths.
    pub(crate) fn planar_spline(&self, entity: &Entity<'_>) -> Got<Curve> {
        self.curve_with(entity, |points| {
            let point = |&number: &u64| {
                let [x, y] = self.coordinates::<2>(number, "CARTESIAN_POINT")?;
                Ok(Point::new(x, y, 0.0))
            };
            points.iter().map(point).collect()
        })
    }

    fn curve_with(&self, entity: &Entity<'_>, points: impl FnOnce(&[u64]) -> Got<Vec<Point>>) -> Got<Curve> {
        let number = entity.number;
        let (common, form, rational) = attributes(entity, &CURVES, 5)?;
        let degree = common.count(0)?;
        let points = points(&common.references(1)?)?;
        let knots = form.knots(degree, points.len(), (0, 1)).map_err(|p| Problem { number, ..p })?;
        let values = rational.map(|value| numbers(number, value)).transpose()?;
        Curve::build(knots, points, weights(number, values)?).at(number)
    }

    /// A B-spline surface.
    pub(crate) fn spline_surface(&self, entity: &Entity<'_>) -> Got<Surface> {
        let number = entity.number;
        let (common, form, rational) = attributes(entity, &SURFACES, 7)?;
        let degrees = [common.count(0)?, common.count(1)?];
        let rows = common.list(2)?;
        let columns = match rows.first() {
            Some(Value::List(row)) => row.len(),
            _ => 0,
        };
        let mut points = Vec::with_capacity(rows.len().saturating_mul(columns));
        for row in rows {
            let args = Args { number, values: std::slice::from_ref(row) };
            let row = args.references(0)?;
            if row.len() != columns {
                let found = row.len();
                let text = format!("a row of {found} control points beside rows of {columns}");
                return Err(Problem::new(number, text));
            }
            for point in row {
                points.push(self.point(point)?);
            }
        }
        let knots = |k: usize, vertices: usize| {
            form.knots(degrees[k], vertices, (k, 2)).map_err(|p| Problem { number, ..p })
        };
        let (u, v) = (knots(0, rows.len())?, knots(1, columns)?);
        let values = match rational {
            None => None,
            Some(Value::List(rows)) => {
                let mut all = Vec::with_capacity(points.len());
                for row in rows {
                    all.extend(numbers(number, row)?);
                }
                Some(all)
            }
            Some(other) => {
                return Err(Problem::new(number, format!("{} where weights are needed", other.what())));
            }
        };
        Surface::build(u, v, points, weights(number, values)?).at(number)
    }
}

fn numbers(number: u64, value: &Value<'_>) -> Got<Vec<f64>> {
    Args { number, values: std::slice::from_ref(value) }.reals(0)
}
