//! `tessellate`: a spline becomes segments or triangles.

mod colors;

use loftsman_kernel::brep::Brep;
use loftsman_kernel::error::Error;
use loftsman_kernel::mesh::{Layer, Polyline};
use loftsman_kernel::plugin::{
    Chord, Context, Declaration, Drawn, Field, Fineness, Operation, OperationError, Parameters, StepReport,
    Tessellated, TessellatedBrep, in_own_coordinates, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::text::{a, counted, without_rounding};

/// The operation `tessellate`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tessellate;

impl Operation for Tessellate {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only curve, surface or brep", "the object"),
            Field::optional(
                "tolerance",
                "length",
                "1/1000 of its size (with what it shares edges with)",
                "largest distance from the shape",
            ),
            Field::optional("angle", "degrees", "15", "largest angle between neighbouring pieces"),
            Field::optional(
                "colors",
                "\"mean\" | \"gaussian\" | \"maximum\" | \"minimum\"",
                "none",
                "the surface's curvature as colours of the mesh's points, blue to white to vermilion",
            ),
            Field::optional(
                "range",
                "[low, high]",
                "0 in the middle",
                "the curvatures that are blue and vermilion",
            ),
        ];
        Declaration {
            name: "tessellate",
            help: "a curve becomes a polyline, a surface or brep a mesh; reports how far from the shape it is at most",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        context: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        let fits = |g: &Geometry| {
            use Geometry::{Brep, Curve, Custom, Surface, Trimmed};
            matches!(g, Curve(_) | Surface(_) | Trimmed(_) | Brep(_) | Custom(_))
        };
        let name = object_name(scene, p, fits, "curve, surface or brep")?;
        let mut fineness = Fineness::default();
        if p.has("tolerance") {
            fineness.chord = Chord::Absolute(p.number("tolerance")?);
        }
        if p.has("angle") {
            fineness.angle = p.number("angle")?.to_radians();
        }
        if let (Chord::Relative(fraction), Some(at)) = (fineness.chord, scene.position(&name))
            && let Some(Some(joined)) = scene.joined()?.get(at)
        {
            // In the object's own coordinates; where its transforms stretch, its neighbours' do so too.
            let map = scene.world_transforms()?.get(at).copied().flatten();
            let stretch = map.map_or(1.0, |m| m.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt());
            if stretch > 0.0 {
                fineness.chord = Chord::Absolute(fraction * joined.diagonal / stretch);
            }
        }
        let paint = colors::Paint::new(p)?;
        let none = match scene.object(&name)?.geometry() {
            Geometry::Curve(_) => Some("a curve has none: a picture draws its curvature as a comb"),
            Geometry::Trimmed(_) => Some(
                "the mesh of a trimmed surface does not take them: \"untrim\" it first, or leave them out",
            ),
            Geometry::Brep(_) => Some("the mesh of a brep has those of its faces: leave them out"),
            _ => None,
        };
        if let (Some(problem), true) = (none, paint.is_some()) {
            return Err(p.error("colors", problem).into());
        }
        let mut warnings = Vec::new();
        let tessellator = || {
            let missing = || Error::Invalid("no tessellator is registered".into());
            context.registry.tessellator().ok_or_else(missing)
        };
        let (pieces, note, near): (Geometry, String, Near) = match scene.object(&name)?.geometry() {
            Geometry::Curve(curve) => {
                let line = tessellator()?.moving_curve(std::slice::from_ref(curve), &fineness)?;
                let points = line.states.into_iter().next().unwrap_or_default();
                let note = counted(points.len(), "point[|s]");
                let near = Near { error: line.error, tolerance: line.tolerance, certified: true };
                (Polyline { points, closed: line.closed }.into(), note, near)
            }
            Geometry::Surface(surface) => {
                let Tessellated { mut mesh, tolerance, error } =
                    tessellator()?.measured_surface(surface, &fineness)?;
                let mut note = counted(mesh.triangle_count(), "triangle[|s]");
                if let Some(paint) = paint {
                    let values = colors::of_surface(surface, &mesh, paint.measure)?;
                    note += &paint.put(&mut mesh, values);
                }
                (mesh.into(), note, Near { error, tolerance, certified: true })
            }
            Geometry::Custom(custom) => {
                let named = |e: Error| Error::Invalid(format!("\"{name}\" cannot be tessellated: {e}"));
                let mut faceted = custom.tessellate(&fineness).map_err(named)?;
                let mut note = match &faceted.drawn {
                    Drawn::Line(line) => counted(line.points.len(), "point[|s]"),
                    Drawn::Mesh(mesh) => counted(mesh.triangle_count(), "triangle[|s]"),
                };
                let (error, tolerance, certified) = (faceted.error, faceted.tolerance, faceted.certified);
                if let Some(paint) = paint {
                    let values = colors::of_shape(custom.shape()?, &faceted, paint.measure);
                    match (&mut faceted.drawn, values) {
                        (Drawn::Mesh(mesh), Some(values)) => note += &paint.put(mesh, values?),
                        _ => {
                            let problem = format!(
                                "the {} \"{name}\" does not say where on it the points of its mesh are: leave the colours out",
                                custom.kind()
                            );
                            return Err(p.error("colors", problem).into());
                        }
                    }
                }
                (faceted.drawn.into(), note, Near { error, tolerance, certified })
            }
            Geometry::Trimmed(trimmed) => {
                let Tessellated { mesh, tolerance, error } =
                    tessellator()?.measured_trimmed(trimmed, &fineness)?;
                let note = counted(mesh.triangle_count(), "triangle[|s]");
                (mesh.into(), note, Near { error, tolerance, certified: true })
            }
            Geometry::Brep(brep) => {
                let mut cut = tessellator()?.measured_brep(brep, &fineness)?;
                let note = counted(cut.mesh.triangle_count(), "triangle[|s]");
                warnings.extend(cut.remark(brep).into_iter().chain(cut.excess(1.0)));
                color_faces(&mut cut, brep, scene.color_of(scene.object(&name)?));
                let near = Near { error: cut.error, tolerance: cut.tolerance, certified: true };
                (cut.mesh.into(), note, near)
            }
            other => {
                return Err(Error::Invalid(format!("\"{name}\" is {} already", a(&other.noun()))).into());
            }
        };
        let size = pieces.points().iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
        let longer = scene.standing(&name)?.most();
        let near = Near { error: longer * near.error, tolerance: longer * near.tolerance, ..near };
        let mut notes = vec![note, near.words(scene.unit, longer * size)];
        notes.extend(in_own_coordinates(scene, &name, p, &[], &["tolerance"])?);
        scene.replace(&name, pieces)?;
        let mut report = StepReport {
            op: "tessellate".into(),
            object: Some(name),
            notes,
            warnings,
            ..StepReport::default()
        };
        report.numbers.insert("deviation".into(), near.error.into());
        report.numbers.insert("tolerance".into(), near.tolerance.into());
        report.numbers.insert("certified".into(), near.certified.into());
        Ok(report)
    }
}

/// How near the pieces are to the shape.
struct Near {
    /// The largest distance between them.
    error: f64,
    /// What was asked for.
    tolerance: f64,
    /// Whether the distance is a bound, or the largest that was found in many places.
    certified: bool,
}

impl Near {
    /// In words, for a shape of this size.
    fn words(&self, unit: Unit, size: f64) -> String {
        let error = without_rounding(self.error, size);
        let within = if error == 0.0 {
            "nowhere off the shape".to_owned()
        } else if self.certified {
            format!("within {} of the shape everywhere", unit.quantity(error, 1))
        } else {
            format!(
                "within {} of the shape in many places, not certified between them",
                unit.quantity(error, 1)
            )
        };
        format!("{within} ({} asked for)", unit.quantity(self.tolerance, 1))
    }
}

/// Gives the triangles of faces that have colours of their own these, by corner; all others that of the object, or white.
fn color_faces(cut: &mut TessellatedBrep, brep: &Brep, own: Option<[f64; 4]>) {
    let (colors, of_triangles) = cut.colors(brep);
    if colors.len() > 1 {
        let values = colors.into_iter().map(|color| color.or(own).unwrap_or([1.0; 4])).collect();
        let corners = of_triangles.into_iter().flat_map(|color| [color; 3]).collect();
        cut.mesh.colors = Layer::per_corner(values, corners);
    }
}
