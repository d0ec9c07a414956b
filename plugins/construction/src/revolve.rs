//! `revolve`: the surface that a curve goes through when turned about an axis.

use loftsman_kernel::functional::{ShapeNames, Shapes};
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::spline::{Curve, Direction, Surface};
use loftsman_kernel::{Error, Point, Vector};

use crate::fields::{NAME, direction, figure, free_name, like, long, made, named, point_or_origin, turn};
use crate::symmetrize::{Mirror, crossings};

/// What lies nearer to the axis than this part of the curve's size is on it, to rounding.
const ON_AXIS: f64 = 1e-14;

/// The sine of an angle that is rounding of a direction.
const ALONG: f64 = 1e-9;
/// Places of a span of a profile by which it is told which way round it runs.
const INWARDS: usize = 32;

/// The operation `revolve`: [`Surface::revolution`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Revolve;

impl Operation for Revolve {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only curve", "the curve to turn"),
            Field::optional("point", "[x, y, z]", "[0, 0, 0]", "a point of the axis"),
            Field::optional("axis", "[x, y, z]", "[0, 0, 1]", "the direction of the axis"),
            Field::optional(
                "degrees",
                "degrees, -360 to 360",
                "360",
                "how far it turns, counterclockwise as seen from the tip of the axis",
            ),
            Field::optional(
                "periodic",
                "true | false",
                "false",
                "without a seam round the axis: of a full turn",
            ),
            NAME,
        ];
        Declaration {
            name: "revolve",
            help: "turn a curve about an axis: an exact rational surface, u the angle, v the curve; reports its area",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let source = object_name(scene, p, |g| matches!(g, Geometry::Curve(_)), "curve")?;
        let curve = scene.curve(&source).map_err(|e| p.error("object", e.to_string()))?;
        let (point, axis) = (point_or_origin(p, "point")?, direction(p, "axis", Vector::z())?);
        let sweep = turn(p, "degrees")?;
        if on_axis(curve, point, axis) {
            let problem = format!("\"{source}\" lies on the axis: move the axis, or the curve");
            return Err(p.error("axis", problem).into());
        }
        if along_circles(curve, point, axis)? {
            let problem = format!(
                "\"{source}\" runs along its own circle about the axis, so that the surface would have no area: move the axis, or the curve"
            );
            return Err(p.error("axis", problem).into());
        }
        let mut surface = Surface::revolution(curve, point, axis, sweep).map_err(named(&source))?;
        if p.flag("periodic")? {
            if sweep.abs() < std::f64::consts::TAU {
                let problem = "a part of a turn has ends: leave it out, or degrees";
                return Err(p.error("periodic", problem).into());
            }
            surface = surface.to_periodic(Direction::U, 0.0)?.shape;
        }
        let name = free_name(scene, p, &format!("{source} revolved"))?;
        let (u, v) = (surface.u(), surface.v());
        let mut notes = vec![format!(
            "degree {} × {}, {} × {} control vertices",
            u.degree(),
            v.degree(),
            u.len(),
            v.len()
        )];
        let crossing = crossed(curve, point, axis)?;
        let bounds_a_volume = crossing.is_none() && sweep.abs() >= std::f64::consts::TAU && closes(curve);
        notes.extend(crossing);
        if bounds_a_volume && inwards(curve, point, axis, sweep)? {
            notes.push("its faces look inwards, as the profile runs: turn that round by `reverse`, or say degrees = -360".into());
        }
        notes.extend(in_own_coordinates(scene, &source, p, &["point", "axis"], &[])?);
        let surface = Geometry::from(surface);
        let area = match scene.standing(&source)?.seen(&surface)?.as_ref() {
            Geometry::Surface(surface) => measured(context, "surface-area", surface),
            _ => None,
        };
        let object = like(scene, &source, &name, surface);
        scene.add(object)?;
        Ok(StepReport { area, ..made("revolve", name, notes) })
    }
}

/// Whether a profile that is turned bounds a volume: it closes, or both its ends lie on the axis, which is for who asks to say.
fn closes(curve: &Curve) -> bool {
    let (start, end) = curve.domain();
    let size = curve.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let ends = curve.point(start).and_then(|a| Ok((curve.point(end)? - a).amax()));
    curve.is_periodic() || ends.is_ok_and(|apart| apart <= ON_AXIS * size)
}

/// Whether the faces of a closed profile's surface, a full turn by `sweep`, look inwards: by the sign of the area that the profile goes round in the
/// half plane of radius and height, `∮ r dz`; counterclockwise there, with the turn counterclockwise, they look outwards.
fn inwards(curve: &Curve, point: Point, axis: Vector, sweep: f64) -> Result<bool, OperationError> {
    let direction = (axis / axis.amax()).normalize();
    // In cylinder coordinates, as the profile need not lie in a plane: (r, z).
    let at = |p: Point| {
        let arm = p - point;
        let height = direction.dot(&arm);
        ((arm - direction * height).norm(), height)
    };
    let mut twice = 0.0;
    for span in curve.space().breakpoints().windows(2) {
        let mut before = at(curve.point(span[0])?);
        for k in 1..=INWARDS {
            let u = if k == INWARDS {
                span[1]
            } else {
                span[0] + (span[1] - span[0]) * k as f64 / INWARDS as f64
            };
            let here = at(curve.point(u)?);
            twice += (before.0 + here.0) * (here.1 - before.1);
            before = here;
        }
    }
    Ok(twice * sweep < 0.0)
}

/// Whether all of a curve lies on an axis, to rounding.
fn on_axis(curve: &Curve, point: Point, axis: Vector) -> bool {
    let direction = (axis / axis.amax()).normalize();
    let size = curve.points().iter().map(|p| (p - point).amax()).fold(0.0, f64::max);
    curve.points().iter().all(|p| {
        let arm = p - point;
        (arm - direction * direction.dot(&arm)).amax() <= ON_AXIS * size
    })
}

/// What is said of a profile, a curve in a plane through the axis, that runs over to the other side of it.
fn crossed(curve: &Curve, point: Point, axis: Vector) -> Result<Option<String>, OperationError> {
    /// So many places are told.
    const TOLD: usize = 8;
    let direction = (axis / axis.amax()).normalize();
    let arm = |p: &Point| {
        let arm = p - point;
        arm - direction * direction.dot(&arm)
    };
    let furthest = curve.points().iter().map(arm).max_by(|x, y| long(x).total_cmp(&long(y)));
    let Some(furthest) = furthest else { return Ok(None) };
    let outwards = (furthest / furthest.amax()).normalize();
    let across = direction.cross(&outwards);
    // Off a plane through the axis it may go round that, and crosses nothing.
    if curve.points().iter().any(|p| arm(p).dot(&across).abs() > ON_AXIS * long(&furthest)) {
        return Ok(None);
    }
    let places = crossings(curve, &Mirror::new(point, outwards)?)?;
    if places.is_empty() {
        return Ok(None);
    }
    let told = places.iter().take(TOLD).map(|u| {
        let p = curve.point(*u)?;
        let [x, y, z] = [p.x, p.y, p.z].map(figure);
        Ok(format!("({x}, {y}, {z})"))
    });
    let told = told.collect::<Result<Vec<_>, Error>>()?.join(", ");
    let rest = match places.len().saturating_sub(TOLD) {
        0 => String::new(),
        more => format!(" and {more} more places"),
    };
    Ok(Some(format!(
        "the profile crosses the axis at {told}{rest}: the surface runs through itself there, and what comes of one side looks inwards; move the \
         profile or the axis until all of it is on one side, or cut it there (`split`) and turn one side only"
    )))
}

/// Whether a curve runs along circles about an axis everywhere, to rounding: of a piece of degree `p` at more places than it can do so without doing so all along.
fn along_circles(curve: &Curve, point: Point, axis: Vector) -> Result<bool, OperationError> {
    let direction = (axis / axis.amax()).normalize();
    let places = 4 * curve.degree() + 1;
    for span in curve.space().breakpoints().windows(2) {
        for k in 0..places {
            let u = span[0] + (span[1] - span[0]) * (k as f64 + 0.5) / places as f64;
            let (way, round) = (curve.derivative(u, 1)?, direction.cross(&(curve.point(u)? - point)));
            if way.cross(&round).norm() > ALONG * way.norm() * round.norm() {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// No other shapes.
struct Alone;

impl ShapeNames for Alone {
    fn shape(&mut self, object: &str) -> loftsman_kernel::Result<usize> {
        Err(Error::Invalid(format!("there is no \"{object}\" here")))
    }
}

/// What the registry's functional of this name says of a shape; nothing where it is not here, or does not know.
pub(crate) fn measured(context: &Context<'_>, functional: &str, shape: &dyn Shape) -> Option<f64> {
    let functional =
        context.registry.build_functional(functional, &Parameters::empty("report"), &mut Alone).ok()?;
    let mut value = [0.0];
    if functional.equations() != 1 {
        return None;
    }
    loftsman_kernel::functional::value_of(functional.as_ref(), &Shapes::new([shape]), &mut value).ok()?;
    Some(value[0]).filter(|value| value.is_finite())
}
