//! `sample`: points spread evenly along a curve or polyline.

use loftsman_kernel::error::{Error, Figure, Result};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name, object_names,
};
use loftsman_kernel::scene::{Geometry, Scene, Standing};
use loftsman_kernel::spline::Curve;
use loftsman_kernel::{Point, text::a};

use crate::fields::{NAME, free_name, length, like, made, named, seen};
use crate::primitives::curve_through;

/// The accuracy of the lengths between points, relative to the whole.
const ACCURACY: f64 = 1e-12;
/// The most points: 240 MB.
const MOST: usize = 10_000_000;
/// Of so many curves it is told how long each is.
const TOLD: usize = 8;
/// Ends nearer than this part of the size are one, to rounding.
const CLOSED: f64 = 1e-14;

/// How points are spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// So many points, those at the ends included.
    Count(usize),
    /// As few points as are no further apart along the curve than this, a length.
    Spacing(f64),
}

/// Points spread evenly along a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// Their parameters.
    pub parameters: Vec<f64>,
    /// The points.
    pub points: Vec<Point>,
    /// Whether the curve ends where it starts, so that the last point is followed by the first.
    pub closed: bool,
    /// The length of the curve from each to the next.
    pub spacing: f64,
    /// What each of these lengths may be wrong by (estimated from above, as in
    /// [`Length`](loftsman_kernel::spline::length::Length)).
    pub error: f64,
}

impl Sampled {
    /// The shortest and the longest way from each point to the next along the curve as it stands in a scene, and all of them together.
    fn lengths(&self, curve: &Curve, standing: &Standing) -> Result<(f64, f64, f64)> {
        let steps = if self.closed { self.points.len() } else { self.points.len() - 1 };
        if let Some(scale) = standing.scale() {
            let each = self.spacing * scale;
            return Ok((each, each, each * steps as f64));
        }
        let table = seen(curve, standing)?.arc_length(ACCURACY)?;
        let whole = table.length().value;
        let mut at = self.parameters.iter().map(|u| table.up_to(*u)).collect::<Result<Vec<f64>>>()?;
        at.extend(self.closed.then_some(whole));
        let each = || at.windows(2).map(|pair| pair[1] - pair[0]);
        Ok((each().fold(f64::INFINITY, f64::min), each().fold(0.0, f64::max), whole))
    }
}

/// Points of a curve that are the same length apart, measured along it: with both ends, or, round a curve that ends where it
/// starts, without the end. `O(n p² + k log n)` for `k` points.
///
/// # Errors
/// When fewer than 2 or more than 10 million points are asked for, the spacing is not a positive number, or the curve has no
/// length.
pub fn spread(curve: &Curve, spread: Spread) -> Result<Sampled> {
    let (start, end) = curve.domain();
    let size = curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let closed = curve.is_periodic() || (curve.point(end)? - curve.point(start)?).amax() <= CLOSED * size;
    let table = curve.arc_length(ACCURACY)?;
    let length = table.length();
    let count = match spread {
        Spread::Count(count) => count,
        Spread::Spacing(spacing) if spacing > 0.0 && spacing.is_finite() => {
            // A spacing that divides the length but for rounding needs no further point.
            let steps = (length.value / spacing * (1.0 - ACCURACY)).ceil().max(1.0);
            if steps > MOST as f64 { usize::MAX } else { steps as usize + usize::from(!closed) }
        }
        Spread::Spacing(spacing) => {
            return Err(Error::Invalid(format!("{} is no length: give a number above 0", Figure(spacing))));
        }
    };
    if count > MOST {
        return Err(Error::Invalid(format!("these are more than {MOST} points: ask for fewer")));
    }
    let count = if matches!(spread, Spread::Spacing(_)) { count.max(2) } else { count };
    if count < 2 {
        return Err(Error::Invalid(format!(
            "{count} {} too few to be spread along a curve: ask for 2 at least",
            if count == 1 { "point is" } else { "points are" }
        )));
    }
    let parameters = table.evenly(count, !closed)?;
    let mut points = vec![Point::origin(); count];
    curve.points_into(&parameters, &mut points)?;
    let steps = if closed { count } else { count - 1 };
    Ok(Sampled {
        parameters,
        points,
        closed,
        spacing: length.value / steps as f64,
        error: 2.0 * length.error,
    })
}

/// The operation `sample`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sample;

impl Operation for Sample {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional(
                "object",
                "text",
                "the only curve or polyline",
                "what the points are spread along",
            ),
            Field::optional(
                "objects",
                "[text, …]",
                "the one object",
                "instead of object: several curves or polylines, each with points of its own; \"hair*\" is all whose names begin so",
            ),
            Field::optional(
                "count",
                "count",
                "count or spacing is needed",
                "how many points, both ends included",
            ),
            Field::optional(
                "spacing",
                "length",
                "count or spacing is needed",
                "the furthest that neighbours may be apart along the curve",
            ),
            Field::optional("as", "\"polyline\" | \"cloud\"", "polyline", "what they become"),
            NAME,
        ];
        Declaration {
            name: "sample",
            help: "add points spread evenly by length along curves or polylines; reports the length from each to the next",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let fits = |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Polyline(_));
        let (whose, sources) = if p.has("objects") {
            if p.has("object") {
                return Err(p.error("objects", "object is given, too: leave one of them out").into());
            }
            ("objects", object_names(scene, p, "objects", fits)?)
        } else {
            ("object", vec![object_name(scene, p, fits, "curve or polyline")?])
        };
        let (field, asked) = match (p.has("count"), p.has("spacing")) {
            (true, false) => ("count", Spread::Count(p.count("count")?)),
            (false, true) => ("spacing", Spread::Spacing(length(p, "spacing")?)),
            (true, true) => {
                return Err(p
                    .error("spacing", "it follows from count, which is given, too: leave one of them out")
                    .into());
            }
            (false, false) => return Err(p.error("", "say count = …, or spacing = …").into()),
        };
        let as_cloud = p.choice_or("as", &[("polyline", false), ("cloud", true)], false)?;
        let unit = scene.unit;
        let (mut changed, mut notes) = (scene.clone(), Vec::new());
        let (mut first, mut lengths, mut spacings) = (None, Vec::new(), Vec::new());
        let (mut shortest_of, mut longest_of) = (f64::INFINITY, 0.0_f64);
        for source in &sources {
            let curve = match scene.object(source).map_err(|e| p.error(whose, e.to_string()))?.geometry() {
                Geometry::Curve(curve) => curve.clone(),
                Geometry::Polyline(line) => curve_through(line).map_err(named(source))?,
                other => {
                    let problem = format!("\"{source}\" is {}: name a curve or a polyline", a(&other.noun()));
                    return Err(p.error(whose, problem).into());
                }
            };
            let sampled = spread(&curve, asked).map_err(|e| match e {
                Error::NoExtent(_) => {
                    p.error(whose, format!("\"{source}\" has no length to spread points along"))
                }
                e => p.error(field, e.to_string()),
            })?;
            let wanted = format!("{source} points");
            let name = match p.has("name") {
                true if sources.len() > 1 => changed.unique_name(p.text("name")?),
                _ => free_name(&changed, p, &wanted)?,
            };
            let standing = scene.standing(source)?;
            let (shortest, spacing, length) = sampled.lengths(&curve, &standing).map_err(named(source))?;
            let Sampled { points, closed, .. } = sampled;
            let count = points.len();
            let range = if shortest < spacing {
                format!("{} to ", unit.quantity(shortest, 1))
            } else {
                String::new()
            };
            let spaced = format!("{range}{}", unit.quantity(spacing, 1));
            if sources.len() > 1 && lengths.len() >= TOLD {
                shortest_of = shortest_of.min(shortest);
                longest_of = longest_of.max(spacing);
            } else if sources.len() > 1 {
                notes.push(format!(
                    "\"{source}\" is {} long: {count} points, {spaced} from each to the next along it",
                    unit.quantity(length, 1)
                ));
            } else {
                notes.push(format!("the curve is {} long", unit.quantity(length, 1)));
                notes.push(format!("{count} points, {spaced} from each to the next along the curve"));
            }
            // Where all is longer alike, points that are even are even in the scene.
            let even = if standing.scale().is_none() { &["spacing", "count"][..] } else { &["spacing"] };
            notes.extend(in_own_coordinates(scene, source, p, &[], even)?);
            let geometry: Geometry =
                if as_cloud { Cloud { points }.into() } else { Polyline { points, closed }.into() };
            changed.add(like(scene, source, &name, geometry))?;
            first.get_or_insert(name);
            lengths.push(length);
            spacings.push(spacing);
        }
        if lengths.len() > TOLD {
            let (shortest, longest) = (unit.quantity(shortest_of, 1), unit.quantity(longest_of, 1));
            let range = if shortest == longest { longest } else { format!("{shortest} to {longest}") };
            notes
                .push(format!("and {} more, {range} from each to the next along them", lengths.len() - TOLD));
        }
        *scene = changed;
        let mut report = made("sample", first.unwrap_or_default(), notes);
        for (name, values) in [("length", lengths), ("spacing", spacings)] {
            let told = match values[..] {
                [one] => one.into(),
                _ => values.into(),
            };
            report.numbers.insert(name.into(), told);
        }
        Ok(report)
    }
}

#[cfg(test)]
mod tests {
    use loftsman_kernel::Vector;

    use super::*;

    #[test]
    fn a_helix_is_divided_as_its_formula_says() {
        // A parabola y = x² from 0 to 1, at whose points the length is x √(1 + 4x²)/2 + asinh(2x)/4.
        let parabola =
            Curve::bezier([[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]].map(|[x, y]| Point::new(x, y, 0.0)).to_vec())
                .unwrap();
        let along = |x: f64| 0.5 * x * (1.0 + 4.0 * x * x).sqrt() + 0.25 * (2.0 * x).asinh();
        let sampled = spread(&parabola, Spread::Count(11)).unwrap();
        for (k, p) in sampled.points.iter().enumerate() {
            assert!((along(p.x) - 0.1 * k as f64 * along(1.0)).abs() < 1e-12, "{k}");
        }
        let spaced = spread(&parabola, Spread::Spacing(sampled.spacing)).unwrap();
        assert_eq!(spaced.points.len(), 11);
        assert_eq!(spread(&parabola, Spread::Spacing(1e9)).unwrap().points.len(), 2);
    }

    #[test]
    fn what_is_closed_has_no_last_point_twice() {
        let circle = Curve::circle(Point::origin(), Vector::z(), 1.0).unwrap();
        let ring = spread(&circle, Spread::Count(6)).unwrap();
        assert!(ring.closed && (ring.spacing - std::f64::consts::PI / 3.0).abs() < 1e-13);
        for pair in ring.points.windows(2) {
            assert!(((pair[1] - pair[0]).norm() - 1.0).abs() < 1e-12);
        }
        assert!(spread(&circle, Spread::Count(1)).is_err());
        assert!(spread(&circle, Spread::Spacing(0.0)).is_err());
        assert!(spread(&circle, Spread::Spacing(f64::NAN)).is_err());
        assert!(spread(&circle, Spread::Spacing(1e-300)).is_err());
        assert!(spread(&circle, Spread::Count(usize::MAX)).is_err());
    }
}
