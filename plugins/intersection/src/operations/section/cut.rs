//! What one plane cuts from one shape, and what there is to say of it.

use loftsman_kernel::mesh::Cloud;
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::scene::{Geometry, Unit};
use loftsman_kernel::spline::Direction;
use loftsman_kernel::text::{a, counted, measured as told};
use loftsman_kernel::{Error, Point};

use crate::{
    Contact, Options, Plane, ShellSection, brep_section, curve_plane, mesh_lines_section, mesh_section,
    mesh_section_above, mesh_section_area, section, trimmed_section,
};

/// What a plane cuts, in the coordinates of the shape.
#[derive(Debug, Default)]
pub(super) struct Cut {
    /// Curves, polylines, and for lines and curves a cloud of points.
    pub(super) pieces: Vec<Geometry>,
    /// What is told of it, each as a sentence about `it`.
    pub(super) notes: Vec<String>,
    /// Where the plane touches without cutting.
    pub(super) touching: Vec<Point>,
    /// What its loops enclose.
    pub(super) area: Option<f64>,
    /// The parameter lines that pieces are.
    pub(super) lines: Vec<(Direction, f64)>,
    /// The largest distance of a piece from shape and plane, where one is found within a tolerance.
    pub(super) distance: Option<f64>,
    /// Whether the last piece is of points.
    pub(super) dots: bool,
}

impl Cut {
    fn off(&mut self, distance: f64) {
        self.distance = Some(distance.max(self.distance.unwrap_or(0.0)));
    }
}

/// How what is found is told.
pub(super) struct Telling<'a> {
    /// The plane's place.
    pub(super) at: &'a str,
    pub(super) unit: Unit,
    /// By how much lengths are longer where they are told.
    pub(super) longer: f64,
    /// A place of the shape, where it is told.
    pub(super) seen: &'a dyn Fn(&Point) -> String,
}

/// What a plane cuts from a shape, both in its coordinates.
///
/// # Errors
/// Where it stays undecided whether, or where, the plane meets it; where the geometry is none that can be cut.
pub(super) fn cut(
    geometry: &Geometry,
    plane: &Plane,
    options: &Options,
    how: &Telling<'_>,
) -> Result<Cut, OperationError> {
    let (at, seen) = (how.at, how.seen);
    let point_or_points = |count| counted(count, "point[|s]");
    let mut all = Cut::default();
    match geometry {
        Geometry::Surface(surface) => {
            let cut = section(surface, plane, options)?;
            all.area = cut.area;
            for branch in cut.curves {
                all.off(branch.distance);
                all.lines.extend(branch.isocurve);
                all.pieces.push(branch.curve.into());
            }
            for q in cut.touching {
                all.notes.push(format!("the plane through {at} touches it at {}", seen(&q)));
                all.touching.push(q);
            }
            for [u, v] in cut.coincident {
                all.notes.push(format!(
                    "it lies in the plane through {at} for u from {} to {}, v from {} to {}",
                    told(u.0),
                    told(u.1),
                    told(v.0),
                    told(v.1)
                ));
            }
            // What is left would be a section with a piece less.
            if let Some([u, v]) = cut.undecided.first() {
                return Err(Error::Invalid(format!(
                    "it is undecided whether the plane through {at} meets it for u from {} to {}, v from {} to {}: move the plane or turn it a little",
                    told(u.0),
                    told(u.1),
                    told(v.0),
                    told(v.1)
                )).into());
            }
        }
        Geometry::Mesh(mesh) => {
            let lines = mesh_section(mesh, plane);
            all.area = mesh_section_area(&lines, plane);
            if let Some(above) = mesh_section_above(mesh, plane) {
                let beside = if lines.is_empty() { "" } else { side(above) };
                all.notes.push(format!("a face lies in the plane through {at}: not cut{beside}"));
            }
            all.pieces.extend(lines.into_iter().map(Geometry::from));
            let met = mesh_lines_section(mesh, plane);
            if met.lying > 0 {
                let parts = counted(met.lying, "part[|s] of its lines [lies|lie]");
                all.notes.push(format!("{parts} in the plane through {at}: not cut"));
            }
            if !met.points.is_empty() {
                let points = point_or_points(met.points.len());
                all.notes.push(format!("its lines meet the plane through {at} at {points}"));
                all.pieces.push(Cloud { points: met.points }.into());
                all.dots = true;
            }
        }
        Geometry::Curve(curve) => {
            let cut = curve_plane(curve, plane, options)?;
            all.off(cut.distance());
            if !cut.meetings.is_empty() {
                all.dots = true;
                all.pieces.push(Cloud { points: cut.meetings.iter().map(|m| m.point).collect() }.into());
            }
            for (contact, how) in [(Contact::Crossing, "crosses"), (Contact::Touching, "touches")] {
                let places = cut.meetings.iter().filter(|m| m.contact == contact).count();
                if places > 0 {
                    let points = point_or_points(places);
                    all.notes.push(format!("it {how} the plane through {at} at {points}"));
                }
            }
            for o in cut.overlaps {
                all.notes.push(format!(
                    "it lies in the plane through {at} from {} to {}",
                    told(o.range.0),
                    told(o.range.1)
                ));
            }
        }
        Geometry::Brep(_) | Geometry::Trimmed(_) => {
            let cut = match geometry {
                Geometry::Brep(brep) => brep_section(brep, plane, options)?,
                Geometry::Trimmed(trimmed) => trimmed_section(trimmed, plane, options)?,
                _ => ShellSection::default(),
            };
            all.notes.extend(
                cut.touching.iter().map(|q| format!("the plane through {at} touches it at {}", seen(q))),
            );
            if !cut.coincident.is_empty() {
                let beside = match cut.shift {
                    shift if shift == 0.0 || cut.curves.is_empty() => "",
                    shift => side(shift > 0.0),
                };
                all.notes.push(format!(
                    "{} in the plane through {at}: not cut{beside}",
                    faces(&cut.coincident, "lies", "lie")
                ));
            }
            // Where faces lie in it that was said above.
            if cut.shift != 0.0 && cut.coincident.is_empty() && !cut.curves.is_empty() {
                all.notes.push(format!(
                    "the plane through {at} passes a vertex or runs along an edge: what is cut was found {} along its normal, and laid into it",
                    how.unit.quantity(how.longer * cut.shift, 1)
                ));
            }
            // What is left would be a section with a loop less, and a wrong area.
            if !cut.undecided.is_empty() {
                return Err(Error::Invalid(format!(
                    "{} undecided in the plane through {at}: which part of the surface is inside the loops cannot be told there; move the plane or turn it a little",
                    faces(&cut.undecided, "is", "are")
                )).into());
            }
            all.touching.extend(&cut.touching);
            all.area = cut.area;
            for branch in cut.curves {
                all.off(branch.distance);
                all.lines.extend(branch.isocurve);
                all.pieces.push(branch.curve.into());
            }
        }
        other => {
            return Err(Error::Invalid(format!("{} has no section", a(&other.noun()))).into());
        }
    }
    Ok(all)
}

/// On which side of a plane what is cut is, where faces lie in it.
fn side(above: bool) -> &'static str {
    if above {
        "; what is cut is what lies just above it, where the plane's normal points"
    } else {
        "; what is cut is what lies just below it, away from the plane's normal"
    }
}

/// Faces in words: `face 3 lies`, `faces 3, 5, 7, … lie`.
fn faces(list: &[usize], one: &str, many: &str) -> String {
    const NAMED: usize = 5;
    if let [face] = list {
        return format!("face {face} {one}");
    }
    let named: Vec<String> = list.iter().take(NAMED).map(usize::to_string).collect();
    let more = if list.len() > NAMED { ", …" } else { "" };
    format!("faces {}{more} {many}", named.join(", "))
}
