//! The operation `symmetrize`.

use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, Parameters, StepReport, in_own_coordinates,
    object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::text::{self, without_rounding};
use loftsman_kernel::{Point, Vector};

use super::{Corner, Half, IN_PLANE, Mirror, symmetrize, symmetrize_surface, symmetrize_surface_best};
use crate::fields::{direction, figure, made, named, point_or_origin};

/// The operation `symmetrize`: [`symmetrize`](super::symmetrize()), [`symmetrize_surface`], [`symmetrize_surface_best`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Symmetrize;

impl Operation for Symmetrize {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only curve or surface", "what becomes symmetric"),
            Field::optional("point", "[x, y, z]", "[0, 0, 0]", "a point of the plane"),
            Field::optional("normal", "[x, y, z]", "[1, 0, 0]", "across the plane"),
            Field::optional(
                "half",
                "\"both\" | \"front\" | \"back\"",
                "both",
                "the mean of both, or one kept and mirrored: front is where the normal points",
            ),
            Field::optional(
                "direction",
                "\"u\" | \"v\"",
                "that in which less moves",
                "of a surface: the parameter that runs across the plane",
            ),
        ];
        Declaration {
            name: "symmetrize",
            help: "make a curve or surface exactly symmetric about a plane, by the least change or from one half; reports how far it moved, and corners that it had not",
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
        let fits = |g: &Geometry| matches!(g, Geometry::Curve(_) | Geometry::Surface(_));
        let source = object_name(scene, p, fits, "curve or surface")?;
        let normal = direction(p, "normal", Vector::x())?;
        let mirror = Mirror::new(point_or_origin(p, "point")?, normal)
            .map_err(|e| p.error("normal", e.to_string()))?;
        let points = scene.object(&source)?.geometry().points();
        let unseen = |x: &Point| mirror.image(x).iter().any(|x| !x.is_finite());
        if points.iter().any(|p| !mirror.height(p).is_finite() || unseen(p)) {
            let problem = format!(
                "the plane is so far from \"{source}\" that its mirror image is where no numbers are: give a point nearer to it"
            );
            return Err(p.error("point", problem).into());
        }
        let halves = [("both", Half::Both), ("front", Half::Front), ("back", Half::Back)];
        let half = p.choice_or("half", &halves, Half::Both)?;
        let ways = [("u", Direction::U), ("v", Direction::V)];
        let along = p.has("direction").then(|| p.choice("direction", &ways)).transpose()?;
        let mut across = None;
        let (geometry, moved, corners): (Geometry, _, _) = match scene.object(&source)?.geometry() {
            Geometry::Curve(curve) => {
                if p.has("direction") {
                    return Err(p
                        .error("direction", "is of a surface: a curve has one only, leave it out")
                        .into());
                }
                let even = symmetrize(curve, &mirror, half).map_err(named(&source))?;
                (even.shape.into(), even.moved, even.corners)
            }
            Geometry::Surface(surface) => {
                let even = match along {
                    Some(along) => symmetrize_surface(surface, &mirror, along, half),
                    None => symmetrize_surface_best(surface, &mirror, half).map(|(even, way)| {
                        across = Some(if way == Direction::U { "u" } else { "v" });
                        even
                    }),
                };
                let even = even.map_err(named(&source))?;
                (even.shape.into(), even.moved, even.corners)
            }
            other => {
                let problem = format!("\"{source}\" is {}", other.other_than("a curve or a surface"));
                return Err(p.error("object", problem).into());
            }
        };
        let is_curve = matches!(geometry, Geometry::Curve(_));
        let mut notes = vec![match moved {
            Some(moved) => {
                let largest = scene.object(&source)?.geometry().points().iter().map(|p| p.coords.amax());
                let moved =
                    without_rounding(moved, largest.fold(0.0, f64::max)) * scene.standing(&source)?.most();
                let what = if is_curve { "places" } else { "control vertices" };
                format!("{what} moved by {} at most", scene.unit.quantity(moved, 1))
            }
            None => "one half is kept, and the other is its mirror image".into(),
        }];
        notes.extend(across.map(|name| format!("{name} runs across the plane")));
        notes.extend(turned(&corners, if is_curve { "corner" } else { "crease" }, half));
        if half == Half::Both {
            notes.extend(one_sided(scene.object(&source)?.geometry().points(), &mirror));
        }
        notes.extend(in_own_coordinates(scene, &source, p, &["point", "normal"], &[])?);
        *scene.object_mut(&source)?.geometry_mut() = geometry;
        Ok(made("symmetrize", source, notes))
    }
}

/// What is said of corners that it has and the original has not.
fn turned(corners: &[Corner], kind: &str, half: Half) -> Option<String> {
    /// So many are told where they are.
    const TOLD: usize = 8;
    let angle = |c: &Corner| format!("{}°", text::figure(c.angle.to_degrees()));
    let told: Vec<String> = corners
        .iter()
        .take(TOLD)
        .map(|c| {
            let [x, y, z] = [c.place.x, c.place.y, c.place.z].map(figure);
            format!("of {} at ({x}, {y}, {z})", angle(c))
        })
        .collect();
    let sharpest = corners.iter().max_by(|a, b| a.angle.total_cmp(&b.angle))?;
    let rest = match corners.len().saturating_sub(TOLD) {
        0 => String::new(),
        more => format!(", and {more} more; the sharpest is of {}", angle(sharpest)),
    };
    let why = match half {
        Half::Both => {
            "where it was smooth: one on the other side has a mirror image, or pieces run at other speeds than their images"
        }
        Half::Front | Half::Back => {
            "where the half meets its image: it does not go straight across the plane there"
        }
    };
    let (a, s) = if corners.len() == 1 { ("a ", "") } else { ("", "s") };
    Some(format!("{a}{kind}{s} {}{rest}, {why}", told.join(", ")))
}

/// What is said of a net that is on one side of the plane, of which the mean with its mirror image lies about in the plane.
fn one_sided(points: &[Point], mirror: &Mirror) -> Option<String> {
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for point in points {
        let height = mirror.height(point);
        (low, high) = (low.min(height), high.max(height));
    }
    let near = IN_PLANE * (high - low);
    let half = match (low >= -near, high <= near) {
        (true, false) => "front",
        (false, true) => "back",
        _ => return None,
    };
    Some(format!(
        "all of it was on one side of the plane, so that the mean of it and its mirror image lies about in that: half = \"{half}\" keeps it as one half"
    ))
}
