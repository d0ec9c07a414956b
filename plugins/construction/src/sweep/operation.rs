//! The operation `sweep`.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::text::{self, without_rounding};

use super::{Mitre, Turning, sweep};
use crate::fields::{NAME, direction, figure, free_name, length, like, made, named, seen};
use crate::revolve::measured;

/// A closed profile whose plane leans off the one across the path by more (60 degrees: it is half as wide then) is warned of.
const LEANING: f64 = std::f64::consts::FRAC_PI_3;
/// A surface whose area is less than this part of the square of its size has none but rounding.
const NO_AREA: f64 = 1e-12;
/// So many spikes are told with their places.
const PLACES: usize = 8;

/// Where there are other spikes, after the first: the furthest of them with how far they reach.
fn elsewhere(others: &[Mitre], unit: Unit) -> String {
    if others.is_empty() {
        return String::new();
    }
    let each = others.iter().take(PLACES - 1).map(|mitre| {
        let degrees = text::figure(mitre.turn.to_degrees());
        format!("{} at {} ({degrees} degrees)", unit.quantity(mitre.reach, 1), text::figure(mitre.at))
    });
    let more = match others.len().saturating_sub(PLACES - 1) {
        0 => String::new(),
        more => format!(", and at {more} more"),
    };
    let corners = if others.len() == 1 {
        "another corner".to_owned()
    } else {
        format!("{} other corners", others.len())
    };
    format!(", and at {corners} more than twice as far: {}{more}", each.collect::<Vec<_>>().join(", "))
}

/// The operation `sweep`: [`sweep`](fn@super::sweep).
#[derive(Debug, Clone, Copy, Default)]
pub struct Sweep;

impl Operation for Sweep {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::required("object", "text", "the curve that is moved, where it is at the path's start"),
            Field::required("path", "text", "the curve that it is moved along"),
            Field::optional(
                "frame",
                "\"least\" | \"upright\" | \"parallel\"",
                "least",
                "turning with the path and about it as little as can be, or with `up` staying up, or not at all",
            ),
            Field::optional(
                "up",
                "[x, y, z]",
                "[0, 0, 1]",
                "what stays up in the scene, where the frame is upright",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-6 of the size",
                "how far the surface may be from the sweep",
            ),
            NAME,
        ];
        Declaration {
            name: "sweep",
            help: "move a curve along another: a surface, u along the path, v the curve; parallel exactly, else within a tolerance; what is closed looks outwards, corners are mitred; reports area and deviation",
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
        p.text("object")?;
        let source = object_name(scene, p, |g| matches!(g, Geometry::Curve(_)), "curve")?;
        let along = p.text("path")?;
        let profile = scene.curve(&source).map_err(|e| p.error("object", e.to_string()))?;
        let path = scene.curve(along).map_err(|e| p.error("path", e.to_string()))?;
        let (place, of_path) = (scene.standing(&source)?, scene.standing(along)?);
        let profile = &seen(profile, &place).map_err(named(&source))?;
        let path = &seen(path, &of_path).map_err(named(along))?;
        let frames = [
            ("least", Turning::Least),
            ("upright", Turning::Upright(Vector::z())),
            ("parallel", Turning::Parallel),
        ];
        let mut turning = p.choice_or("frame", &frames, Turning::Least)?;
        if let Turning::Upright(up) = &mut turning {
            *up = direction(p, "up", Vector::z())?;
        } else if p.has("up") {
            return Err(p.error("up", "is for frame = \"upright\" only: leave it out, or say so").into());
        }
        let tolerance = if p.has("tolerance") { Some(length(p, "tolerance")?) } else { None };
        let swept = sweep(profile, path, turning, tolerance).map_err(named(&source))?;
        let name = free_name(scene, p, &format!("{source} swept"))?;
        let points = profile.points().iter().chain(path.points());
        let largest = points.map(|p| p.coords.amax()).fold(0.0, f64::max);
        let (deviation, tolerance) = (swept.deviation, swept.tolerance);
        let leaned = without_rounding(swept.leaned, largest);
        let surface = swept.surface;
        let (u, v) = (surface.u(), surface.v());
        let mut notes = vec![format!(
            "degree {} × {}, {} × {} control vertices",
            u.degree(),
            v.degree(),
            u.len(),
            v.len()
        )];
        notes.push(if turning == Turning::Parallel {
            "exact".into()
        } else {
            format!(
                "{} from where it should be at most, measured; {} were allowed",
                scene.unit.quantity(without_rounding(deviation, largest), 1),
                scene.unit.quantity(tolerance, 1)
            )
        });
        if swept.corners > 0 {
            let corners = if swept.corners == 1 { "corner" } else { "corners" };
            notes.push(format!("mitred at {} {corners} of the path", swept.corners));
        }
        if leaned > 0.0 {
            notes.push(format!(
                "sections lean beside corners where the path bends, so that both sides meet: {} from the sweep of others at most, measured",
                scene.unit.quantity(leaned, 1)
            ));
        }
        if swept.reversed {
            notes.push("the curve is taken backwards, so that the faces look outwards".into());
        }
        if swept.flat {
            notes.push(format!(
                "\"{source}\" lies along the path where that starts: the surface is laid double there, with nothing inside"
            ));
        }
        if swept.twist.abs() > 1e-9 {
            notes.push(format!(
                "turned about the path by {} degrees on the way round, so that the ends meet",
                figure(swept.twist.to_degrees())
            ));
        }
        if let Some(at) = swept.folds {
            notes.push(format!(
                "folds back at {} of the path, whose bend is too narrow for the curve",
                text::figure(at)
            ));
        }
        let mut warnings = Vec::new();
        if let [mitre, others @ ..] = &swept.spikes[..] {
            warnings.push(format!(
                "where the path turns by {} degrees, at {} of it, the mitre of \"{source}\" reaches {} from it, {} times as far as the curve by itself ({}){}: put an arc \
                 into the corner, make it blunter, bring the curve nearer to the path, or split the path there and sweep along each part",
                text::figure(mitre.turn.to_degrees()),
                text::figure(mitre.at),
                scene.unit.quantity(mitre.reach, 1),
                text::short(mitre.reach / mitre.profile),
                scene.unit.quantity(mitre.profile, 1),
                elsewhere(others, scene.unit),
            ));
        }
        if let Some(off) =
            swept.off.filter(|off| *off > LEANING && !swept.flat && turning != Turning::Parallel)
        {
            warnings.push(format!(
                "the plane of \"{source}\" leans {} degrees off the one across the path where that starts, so that across the path it is {} % as wide as it is in its own plane: \
                 turn it until it lies across the path there, or say frame = \"parallel\" if it is to stay as it is",
                text::figure(off.to_degrees()),
                text::short(100.0 * off.cos()),
            ));
        }
        let area = measured(context, "surface-area", &surface);
        // Beside the square of its own size.
        let low = surface.points().iter().fold(surface.points()[0], |low, p| low.inf(p));
        let size = surface.points().iter().map(|p| (p - low).norm()).fold(0.0, f64::max);
        if area.is_some_and(|area| area <= NO_AREA * size * size) {
            warnings.push(format!(
                "the surface has no area: \"{source}\" runs along the path, as does what it leaves behind; turn it across the path"
            ));
        }
        let mut surface = Geometry::from(surface);
        let object = match place.back(&source, along) {
            Ok(back) => {
                if let Some(back) = back {
                    surface = surface.transformed(&back)?;
                }
                like(scene, &source, &name, surface)
            }
            // Nothing but a flat sheet could hang where the profile does.
            Err(_) => {
                let mut object = like(scene, &source, &name, surface);
                (object.parent, object.transform) = (None, None);
                object
            }
        };
        if place != of_path {
            notes.push(format!(
                "\"{along}\" is placed otherwise than \"{source}\": both are taken as they stand in the scene"
            ));
        }
        scene.add(object)?;
        let mut report = StepReport { area, warnings, ..made("sweep", name, notes) };
        report.numbers.insert("deviation".into(), deviation.into());
        report.numbers.insert("tolerance".into(), tolerance.into());
        report.numbers.insert("corners".into(), swept.corners.into());
        if let Some(mitre) = swept.mitre {
            report.numbers.insert("mitre".into(), mitre.reach.into());
        }
        report.numbers.insert("leaned".into(), leaned.into());
        report.numbers.insert("twist".into(), swept.twist.into());
        Ok(report)
    }
}
