//! What the colours of faces say: zebra stripes, curvature, the distance from the state before.

use loftsman_kernel::mesh::color::{diverging, map_end, map_end_of_all};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::spline::curvature::SurfaceCurvature;
use loftsman_kernel::text::counted;
use loftsman_kernel::{Point, Vector};

use crate::choices::{Curvature, Faces};
use crate::draw::sides;
use crate::draw::surface::{Samples, samples};
use crate::sheet::{Caption, Fill};
use crate::stage::Stage;
use crate::stage::body::{Body, Form};
use crate::stage::feet::Feet;
use crate::stage::finer::finer;
use crate::stage::laid::Laid;
use crate::stage::shell::Shell;
use crate::text::figure;
use crate::theme::{Color, Theme};
use crate::view::Lens;

/// The colours of its stripes.
pub(crate) const DARK: Color = Color([38; 3]);
pub(crate) const LIGHT: Color = Color([240; 3]);

/// Stripes of a zebra from one side of the world to the other.
const STRIPES: f64 = 24.0;
/// Where stripes meet, this part of one is between light and dark, so that their edges are smooth.
const SOFT: f64 = 0.12;
/// The cells of faces that are painted are finer, so that stripes and colours change smoothly.
const FINER: usize = 3;

/// So many objects are named in a note.
const NAMED: usize = 4;

/// Why a body without a state before is shaded.
const NEW: &str = "has no state before: nothing of its name was there";

/// The colours of all bodies of a stage.
#[derive(Debug, Default)]
pub(crate) struct Painting {
    faces: Faces,
    bodies: Vec<Painted>,
    /// The values at the ends of the map, from minus this to this, in the scene's units.
    end: f64,
    /// Whether other drawings have the same map: then it speaks of all of them.
    shared: bool,
    /// What cannot be painted.
    notes: Vec<String>,
}

/// What a body has at its points.
#[derive(Debug, Default)]
pub(crate) struct Painted {
    /// Of a surface, its points on a grid.
    pub(crate) grid: Option<Samples>,
    /// Of a plug-in's surface that is painted, its faces in smaller triangles.
    pub(crate) shell: Option<Shell>,
    /// At each point of the grid, or of the mesh, or each place of a shell ([`Shell::painted_at`]), what its colour shows; none where faces are
    /// shaded, or the body has none.
    values: Vec<f64>,
    /// Of a shell that is painted by curvature, these values each for the same area.
    by_area: Vec<f64>,
    /// Of a surface that is striped, the unit normals.
    normals: Vec<Vector>,
}

impl Painting {
    /// What there is to paint on a stage.
    pub(crate) fn of(stage: &Stage<'_>, faces: Faces) -> Self {
        let mut painting = Self { faces, ..Self::default() };
        let surfaces = stage.surfaces();
        for body in &stage.new {
            let painted = painting.painted(stage, body, surfaces);
            painting.bodies.push(painted);
        }
        painting.tell_sides(stage);
        // A part that has moved may be small: all of it is to be seen. Curvatures may be infinite here and there.
        painting.end = if faces == Faces::Deviation {
            map_end_of_all(painting.bodies.iter().flat_map(|b| &b.values).copied())
        } else {
            let counted =
                painting.bodies.iter().map(|b| if b.by_area.is_empty() { &b.values } else { &b.by_area });
            map_end(counted.flatten().copied())
        };
        painting
    }

    fn painted(&mut self, stage: &Stage<'_>, body: &Body<'_>, surfaces: usize) -> Painted {
        let size = stage.projection.size;
        match &body.form {
            Form::Surface { surface, .. } => {
                let finer = if matches!(self.faces, Faces::Zebra | Faces::Curvature(_)) { FINER } else { 1 };
                let grid = samples(surface, surfaces, finer);
                let mut painted = Painted::default();
                match self.faces {
                    Faces::Shaded => {}
                    Faces::Zebra => painted.normals = normals(surface, &grid),
                    Faces::Curvature(which) => {
                        let value =
                            |u: f64, v: f64| bent(which, &surface.curvature(u, v).ok().flatten()?, size);
                        painted.values = filled(&grid, |u, v, _| value(u, v));
                    }
                    Faces::Deviation => {
                        let old = stage.old.iter().find(|old| old.object.name() == body.object.name());
                        let old = old.map(|old| &old.form);
                        painted.values = match old {
                            Some(Form::Surface { surface: old, .. }) => {
                                filled(&grid, |_, _, p| deviation(old, p).map(|d| d * size))
                            }
                            Some(_) => self.without(body, "was something else before"),
                            None if stage.had(body) => vec![0.0; grid.points.len()],
                            None => self.without(body, NEW),
                        };
                    }
                }
                painted.grid = Some(grid);
                painted
            }
            Form::Mesh { points, .. } => {
                let values = match self.faces {
                    Faces::Curvature(_) => self.without(body, "is a mesh, which has no curvature of its own"),
                    Faces::Deviation => {
                        let old = stage.old.iter().find(|old| old.object.name() == body.object.name());
                        match old.map(|old| &old.form) {
                            Some(Form::Mesh { points: old, .. }) if old.len() == points.len() => {
                                points.iter().zip(old).map(|(p, q)| (p - q).norm() * size).collect()
                            }
                            None if stage.had(body) => vec![0.0; points.len()],
                            None => self.without(body, NEW),
                            Some(_) => self.without(body, "had other points before"),
                        }
                    }
                    Faces::Shaded | Faces::Zebra => Vec::new(),
                };
                Painted { values, ..Painted::default() }
            }
            Form::Solid(Shell { laid: Some(_), .. }) if self.faces == Faces::Shaded => Painted::default(),
            Form::Solid(shell) if let Some(finer) = finer(shell) => self.laid(stage, body, finer),
            Form::Solid(Shell { points, .. }) => {
                let values = match self.faces {
                    Faces::Curvature(_) => self.without(body, "is a brep, whose curvature is not drawn"),
                    Faces::Deviation => {
                        let old = stage.old.iter().find(|old| old.object.name() == body.object.name());
                        match old.map(|old| &old.form) {
                            None if stage.had(body) => vec![0.0; points.len()],
                            None => self.without(body, NEW),
                            Some(_) => self.without(body, "is a brep, whose faces are not compared"),
                        }
                    }
                    Faces::Shaded | Faces::Zebra => Vec::new(),
                };
                Painted { values, ..Painted::default() }
            }
            _ => Painted::default(),
        }
    }

    /// A plug-in's surface: its own curvature, and the distance of its points from the surface before.
    fn laid(&mut self, stage: &Stage<'_>, body: &Body<'_>, mut shell: Shell) -> Painted {
        let size = stage.projection.size;
        let is_bent = matches!(self.faces, Faces::Curvature(_));
        if let Some(laid) = shell.laid.as_mut().filter(|_| is_bent) {
            laid.part();
        }
        let values = match (self.faces, &shell.laid) {
            (Faces::Curvature(which), Some(laid)) => {
                let value = |at| bent(which, &laid.curvature(at)?, size);
                let (values, without) = laid.values(&shell.skin, value);
                if without > 0 && laid.has_faces() {
                    self.notes.push(format!(
                        "\"{}\" has no curvature at {}, where it may grow without bound: the numbers are those of the points drawn",
                        body.object.name(),
                        counted(without, "point[|s]")
                    ));
                }
                values
            }
            (Faces::Deviation, Some(laid)) => {
                let old = stage.old.iter().find(|old| old.object.name() == body.object.name());
                match old.map(|old| &old.form) {
                    Some(Form::Solid(old)) if let Some(feet) = Feet::of(old) => {
                        let distance = |p: &Vector| feet.distance(p).map(|d| d * size);
                        laid.values_of_points(&shell, distance)
                    }
                    Some(Form::Surface { surface: old, .. }) => {
                        laid.values_of_points(&shell, |p| deviation(old, p).map(|d| d * size))
                    }
                    Some(_) => self.without(body, "was something else before"),
                    None if stage.had(body) => laid.values(&shell.skin, |_| Some(0.0)).0,
                    None => self.without(body, NEW),
                }
            }
            _ => Vec::new(),
        };
        let by_area = if is_bent { Laid::by_area(&shell, &values) } else { Vec::new() };
        Painted { shell: Some(shell), values, by_area, ..Painted::default() }
    }

    /// Says whose sign of curvature is against that of what it goes on in: it is by each surface's own normal.
    fn tell_sides(&mut self, stage: &Stage<'_>) {
        // The product of both principal curvatures is the same from either side.
        if !matches!(self.faces, Faces::Curvature(which) if which != Curvature::Gaussian) {
            return;
        }
        let surfaces = stage.new.iter().filter_map(|body| match &body.form {
            // Sides of what is trimmed are no edges of it.
            Form::Surface { surface, trim: None, .. } => Some((body.object.name(), &**surface)),
            _ => None,
        });
        let (names, surfaces): (Vec<&str>, Vec<&Surface>) = surfaces.unzip();
        let turned = sides::turned(&surfaces);
        if turned.is_empty() {
            return;
        }
        let named: Vec<String> = turned.iter().take(NAMED).map(|k| format!("\"{}\"", names[*k])).collect();
        let more = match turned.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        self.notes.push(format!(
            "the sign of curvature is by each surface's own normal: of {}{more} that points to the other side than beside it (`reverse` turns it)",
            named.join(", ")
        ));
    }

    /// Says that a body cannot be painted.
    fn without(&mut self, body: &Body<'_>, why: &str) -> Vec<f64> {
        self.notes.push(format!("\"{}\" {why}: it is shaded", body.object.name()));
        Vec::new()
    }

    /// What the body of this number has.
    pub(crate) fn body(&self, index: usize) -> Option<&Painted> {
        self.bodies.get(index)
    }

    /// Where the map ends, and whether it is of the same thing: maps of one thing in one picture end alike.
    pub(crate) fn end(&self) -> (Faces, f64) {
        (self.faces, self.end)
    }

    /// The same with another end of the map.
    pub(crate) fn ending(self, end: f64, shared: bool) -> Self {
        Self { end, shared, ..self }
    }

    /// Says in the legend what the colours are.
    pub(crate) fn explain(&self, caption: &mut Caption, unit: Unit) {
        for note in &self.notes {
            caption.note(note.clone());
        }
        let one = unit.one();
        let (title, of) = match self.faces {
            Faces::Shaded | Faces::Zebra => return,
            Faces::Curvature(which) => match which.power() {
                2 => (which.name(), format!("1/{one}²")),
                _ => (which.name(), format!("1/{one}")),
            },
            Faces::Deviation => {
                ("distance from before", if unit == Unit::Unknown { unit.symbol() } else { one }.into_owned())
            }
        };
        let values = || self.bodies.iter().flat_map(|body| &body.values).copied();
        let Some(range) = values().map(|v| (v, v)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))) else {
            return;
        };
        // What differs by less is rounding.
        let even = !self.shared && range.1 - range.0 <= 1e-4 * range.0.abs().max(range.1.abs());
        let title = match (even, self.faces) {
            (true, _) => {
                let value = figure(0.5 * (range.0 + range.1));
                // `0.5/mm` and not `0.5 1/mm`.
                let unit = of.strip_prefix('1').map_or_else(|| format!(" {of}"), str::to_owned);
                format!("{title}: {value}{unit} everywhere")
            }
            _ => format!("{title} in {of}"),
        };
        caption.scale(title, self.end, range);
    }

    /// The colour of a value.
    fn color(&self, value: f64) -> Color {
        mapped(if self.end > 0.0 { value / self.end } else { 0.0 })
    }

    /// What the legend shows faces of a body filled with, where they are painted.
    pub(crate) fn fill(&self, index: usize) -> Option<Fill> {
        let body = self.bodies.get(index)?;
        match self.faces {
            Faces::Zebra => Some(Fill::Stripes),
            _ if body.values.is_empty() => None,
            _ => Some(Fill::Map),
        }
    }

    /// How the faces of a body are painted where they do not show what they are lit by; None where they do.
    pub(crate) fn brush<'a>(&'a self, index: usize, theme: Theme) -> Option<Brush<'a>> {
        let body = self.bodies.get(index)?;
        match self.faces {
            Faces::Zebra => {
                // Without the objects' colours, so that stripes are seen to go on where objects meet.
                Some(Brush::Zebra { normals: &body.normals, dark: DARK, light: LIGHT })
            }
            _ if body.values.is_empty() => None,
            _ => Some(Brush::Values { painting: self, values: &body.values, theme }),
        }
    }
}

/// How faces are painted.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Brush<'a> {
    /// By where they mirror the world: dark and light in turn. A mesh has no normals here.
    Zebra { normals: &'a [Vector], dark: Color, light: Color },
    /// By values at their corners.
    Values { painting: &'a Painting, values: &'a [f64], theme: Theme },
}

impl Brush<'_> {
    /// The colour within a triangle of the grid or of a mesh: at the point `at` of the stage, with the normal there as far as it is
    /// known otherwise.
    pub(crate) fn color(
        &self,
        [a, b, c]: [usize; 3],
        [v, w]: [f64; 2],
        normal: &Vector,
        (lens, at): (Lens, &Vector),
        light: f64,
    ) -> Color {
        match self {
            Self::Zebra { normals, dark, light } => {
                let own = match (normals.get(a), normals.get(b), normals.get(c)) {
                    (Some(p), Some(q), Some(r)) => p + (q - p) * v + (r - p) * w,
                    _ => *normal,
                };
                stripe(&own, &lens.toward(at)).map_or(*dark, |share| dark.mixed(*light, share))
            }
            Self::Values { painting, values, theme } => {
                let at = |i: usize| values.get(i).copied().unwrap_or(0.0);
                let value = at(a) + (at(b) - at(a)) * v + (at(c) - at(a)) * w;
                theme.painted(painting.color(value), light)
            }
        }
    }
}

/// How light the stripe is that a face with a normal mirrors to the viewer, from 0 to 1: the world is striped by horizontal rings.
fn stripe(normal: &Vector, toward: &Vector) -> Option<f64> {
    let (n, t) = (normal.try_normalize(0.0)?, toward.try_normalize(0.0)?);
    let mirrored = n * (2.0 * n.dot(&t)) - t;
    let along = mirrored.y.clamp(-1.0, 1.0).acos() * STRIPES / std::f64::consts::PI;
    // How far inside its stripe, which begins and ends at whole numbers.
    let within = along - along.floor();
    let edge = (within.min(1.0 - within) / SOFT).min(1.0);
    let is_light = (along.floor() as i64) % 2 == 0;
    Some(if is_light { 0.5 + 0.5 * edge } else { 0.5 - 0.5 * edge })
}

/// A curvature found on the stage, where all is of size 1, of a scene of a size; none where it is infinite.
fn bent(which: Curvature, found: &SurfaceCurvature, size: f64) -> Option<f64> {
    let value = which.beyond_rounding(found, 1.0) / size.powi(which.power());
    Some(value).filter(|value| value.is_finite())
}

/// Values at the points of a grid; where there is none that of the point before, at its start the first that there is.
fn filled(grid: &Samples, value: impl Fn(f64, f64, &Vector) -> Option<f64>) -> Vec<f64> {
    let columns = grid.v.len();
    let at = |(i, p): (usize, &Vector)| value(grid.u[i / columns], grid.v[i % columns], p);
    let found: Vec<Option<f64>> = grid.points.iter().enumerate().map(at).collect();
    let mut last = found.iter().copied().flatten().next().unwrap_or(0.0);
    let carried = found.into_iter().map(|value| {
        last = value.unwrap_or(last);
        last
    });
    carried.collect()
}

/// The unit normals at the points of a grid; zero where there are none.
fn normals(surface: &Surface, grid: &Samples) -> Vec<Vector> {
    let places = grid.u.iter().flat_map(|&u| grid.v.iter().map(move |&v| (u, v)));
    places
        .map(|(u, v)| surface.normal(u, v).ok().and_then(|n| n.vector()).unwrap_or_else(Vector::zeros))
        .collect()
}

/// How far a point is from a surface, negative on the side away from its normal.
fn deviation(from: &Surface, p: &Vector) -> Option<f64> {
    let found = from.closest(Point::from(*p)).ok()?;
    let away = p - found.point.coords;
    let normal = from.normal(found.at.0, found.at.1).ok().and_then(|n| n.vector());
    let side = normal.map_or(1.0, |n| if n.dot(&away) < 0.0 { -1.0 } else { 1.0 });
    Some(side * away.norm())
}

/// The colour at a share of the map, -1 to 1.
pub(crate) fn mapped(share: f64) -> Color {
    Color(diverging(share).map(|byte| byte.round() as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_turn_twice_as_fast_as_the_normal_and_know_no_side() {
        let toward = Vector::z();
        let at = |degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            stripe(&Vector::new(0.0, 3.0 * s, 3.0 * c), &toward).unwrap()
        };
        // 24 stripes over half a turn of the mirrored ray, so one for 3.75 degrees of the normal.
        let mut changes = 0;
        let fine: Vec<f64> = (0..=900).map(|i| at(f64::from(i) * 0.1 - 45.0)).collect();
        for pair in fine.windows(2) {
            changes += usize::from((pair[0] > 0.5) != (pair[1] > 0.5));
        }
        assert!((23..=25).contains(&changes), "{changes}");
        for degrees in [-30.0, -1.0, 7.0, 33.3] {
            let (s, c) = f64::to_radians(degrees).sin_cos();
            let back = stripe(&-Vector::new(0.0, s, c), &toward).unwrap();
            assert!((back - at(degrees)).abs() < 1e-12);
        }
        assert_eq!(stripe(&Vector::zeros(), &toward), None);
    }
}
