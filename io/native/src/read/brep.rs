//! Breps.

use loftsman_kernel::brep::{
    Brep, CurveForm, Edge, Face, Frame, Parts, Shell, Solid, SurfaceForm, Use, Vertex,
};
use loftsman_kernel::plugin::hint;
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Curve, Surface};
use loftsman_kernel::{Point, Vector};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess};

use super::geometry::{CurveTable, SurfaceTable};
use super::lists::{Fixed, Index, List, Number, PointSeed};
use super::table::{Table, TableSeed, need};
use super::trail::Trail;
use super::trimmed::{PieceTable, item};

item!(VertexSeed, VertexTable);
item!(EdgeSeed, EdgeTable);
item!(FaceSeed, FaceTable);
item!(SolidSeed, SolidTable);
item!(UseSeed, UseTable);

fn numbers(trail: &Trail) -> List<'_, Index<'_>> {
    List { trail, what: "numbers of parts", item: Index(trail) }
}

fn wide(numbers: Vec<u32>) -> Vec<usize> {
    numbers.into_iter().map(|number| number as usize).collect()
}

/// `"brep"`.
#[derive(Default)]
pub(super) struct BrepTable(Parts);

impl<'de> Table<'de> for BrepTable {
    type Out = Brep;
    const WHAT: &'static str = "a brep";
    const FIELDS: &'static [&'static str] = &["vertices", "edges", "faces", "shells", "solids"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let parts = &mut self.0;
        match name {
            "vertices" => {
                let item = VertexSeed(trail);
                parts.vertices =
                    map.next_value_seed(List { trail, what: "vertices { at, tolerance }", item })?;
            }
            "edges" => {
                let item = EdgeSeed(trail);
                parts.edges = map.next_value_seed(List { trail, what: "edges { curve, … }", item })?;
            }
            "faces" => {
                let item = FaceSeed(trail);
                parts.faces =
                    map.next_value_seed(List { trail, what: "faces { surface, loops, … }", item })?;
            }
            "shells" => {
                let item = numbers(trail);
                let lists = map.next_value_seed(List { trail, what: "shells, lists of faces", item })?;
                parts.shells = lists.into_iter().map(|faces| Shell { faces: wide(faces) }).collect();
            }
            _ => {
                let item = SolidSeed(trail);
                parts.solids = map.next_value_seed(List { trail, what: "solids { outer, voids }", item })?;
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Brep, E> {
        Brep::new(self.0).map_err(|defect| trail.refuse_table("", defect.to_string()))
    }
}

/// A vertex.
#[derive(Default)]
pub(super) struct VertexTable {
    at: Option<Point>,
    tolerance: f64,
}

impl<'de> Table<'de> for VertexTable {
    type Out = Vertex;
    const WHAT: &'static str = "a vertex";
    const FIELDS: &'static [&'static str] = &["at", "tolerance"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "at" => self.at = Some(map.next_value_seed(PointSeed(trail))?),
            _ => self.tolerance = map.next_value_seed(Number)?,
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Vertex, E> {
        Ok(Vertex { point: need::<Self, _, _>(self.at, "at", trail)?, tolerance: self.tolerance })
    }
}

/// An edge.
#[derive(Default)]
pub(super) struct EdgeTable {
    curve: Option<Curve>,
    from: Option<f64>,
    to: Option<f64>,
    vertices: Option<Vec<u32>>,
    tolerance: f64,
    form: Option<Form>,
}

impl<'de> Table<'de> for EdgeTable {
    type Out = Edge;
    const WHAT: &'static str = "an edge";
    const FIELDS: &'static [&'static str] = &["curve", "from", "to", "vertices", "tolerance", "form"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "curve" => {
                self.curve = Some(map.next_value_seed(TableSeed { trail, table: CurveTable::default() })?);
            }
            "from" => self.from = Some(map.next_value_seed(Number)?),
            "to" => self.to = Some(map.next_value_seed(Number)?),
            "vertices" => self.vertices = Some(map.next_value_seed(numbers(trail))?),
            "tolerance" => self.tolerance = map.next_value_seed(Number)?,
            _ => self.form = Some(map.next_value_seed(TableSeed { trail, table: FormTable::default() })?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Edge, E> {
        let curve = need::<Self, _, _>(self.curve, "curve", trail)?;
        let (start, end) = curve.domain();
        let ends = wide(need::<Self, _, _>(self.vertices, "vertices", trail)?);
        let Ok(ends) = <[usize; 2]>::try_from(ends.as_slice()) else {
            let problem = format!("{} vertices: give that at its start and that at its end", ends.len());
            return Err(trail.refuse_table("vertices", problem));
        };
        let form = match self.form {
            None => CurveForm::Spline,
            Some(Form::Curve(form)) => form,
            Some(Form::Surface(form)) => {
                let problem = format!("\"{}\" is no kind of curve; known are {CURVES}", form.name());
                return Err(trail.refuse_table("form.kind", problem));
            }
        };
        let range = (self.from.unwrap_or(start), self.to.unwrap_or(end));
        Ok(Edge { curve, range, ends, tolerance: self.tolerance, form })
    }
}

/// A face.
#[derive(Default)]
pub(super) struct FaceTable {
    name: Option<String>,
    color: Option<[f64; 4]>,
    surface: Option<Surface>,
    form: Option<Form>,
    reversed: bool,
    loops: Vec<Vec<Use>>,
    points: Vec<usize>,
}

impl<'de> Table<'de> for FaceTable {
    type Out = Face;
    const WHAT: &'static str = "a face";
    const FIELDS: &'static [&'static str] =
        &["name", "color", "surface", "form", "reversed", "loops", "points"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            "color" => {
                self.color = Some(map.next_value_seed(Fixed { trail, what: "[red, green, blue, alpha]" })?);
            }
            "surface" => {
                self.surface =
                    Some(map.next_value_seed(TableSeed { trail, table: SurfaceTable::default() })?);
            }
            "form" => {
                self.form = Some(map.next_value_seed(TableSeed { trail, table: FormTable::default() })?);
            }
            "reversed" => self.reversed = map.next_value()?,
            "loops" => {
                let item = List { trail, what: "edges { edge, reversed }", item: UseSeed(trail) };
                self.loops = map.next_value_seed(List { trail, what: "loops", item })?;
            }
            _ => self.points = wide(map.next_value_seed(numbers(trail))?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Face, E> {
        let form = match self.form {
            None => SurfaceForm::Spline,
            Some(Form::Surface(form)) => form,
            Some(Form::Curve(form)) => {
                let problem = format!("\"{}\" is no kind of surface; known are {SURFACES}", form.name());
                return Err(trail.refuse_table("form.kind", problem));
            }
        };
        Ok(Face {
            name: self.name,
            color: self.color,
            surface: need::<Self, _, _>(self.surface, "surface", trail)?,
            form,
            reversed: self.reversed,
            loops: self.loops,
            points: self.points,
        })
    }
}

/// An edge in a loop.
#[derive(Default)]
pub(super) struct UseTable {
    edge: Option<u32>,
    reversed: bool,
    parameters: Option<ParameterCurve>,
}

impl<'de> Table<'de> for UseTable {
    type Out = Use;
    const WHAT: &'static str = "an edge of a loop";
    const FIELDS: &'static [&'static str] = &["edge", "reversed", "parameters"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "edge" => self.edge = Some(map.next_value_seed(Index(trail))?),
            "reversed" => self.reversed = map.next_value()?,
            _ => {
                let table = PieceTable::default();
                self.parameters = Some(map.next_value_seed(TableSeed { trail, table })?);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Use, E> {
        let edge = need::<Self, _, _>(self.edge, "edge", trail)? as usize;
        Ok(Use { edge, reversed: self.reversed, parameters: self.parameters })
    }
}

/// A solid.
#[derive(Default)]
pub(super) struct SolidTable {
    name: Option<String>,
    outer: Option<u32>,
    voids: Vec<usize>,
}

impl<'de> Table<'de> for SolidTable {
    type Out = Solid;
    const WHAT: &'static str = "a solid";
    const FIELDS: &'static [&'static str] = &["name", "outer", "voids"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            "outer" => self.outer = Some(map.next_value_seed(Index(trail))?),
            _ => self.voids = wide(map.next_value_seed(numbers(trail))?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Solid, E> {
        let outer = need::<Self, _, _>(self.outer, "outer", trail)? as usize;
        Ok(Solid { name: self.name, outer, voids: self.voids })
    }
}

pub(super) const CURVES: &str = "\"spline\", \"line\", \"circle\", \"ellipse\", \"parabola\", \"hyperbola\"";
pub(super) const SURFACES: &str =
    "\"spline\", \"plane\", \"cylinder\", \"cone\", \"sphere\", \"torus\", \"extrusion\", \"revolution\"";

/// What a curve or a surface is beside a spline.
pub(super) enum Form {
    Curve(CurveForm),
    Surface(SurfaceForm),
}

/// `"form"`.
#[derive(Default)]
pub(super) struct FormTable {
    kind: Option<String>,
    origin: Option<Point>,
    x: Option<Vector>,
    z: Option<Vector>,
    radius: Option<f64>,
    radii: Option<[f64; 2]>,
    angle: Option<f64>,
    major: Option<f64>,
    minor: Option<f64>,
    focal: Option<f64>,
    along: Option<Vector>,
    profile: Option<Box<Form>>,
}

impl<'de> Table<'de> for FormTable {
    type Out = Form;
    const WHAT: &'static str = "a form";
    const FIELDS: &'static [&'static str] = &[
        "kind", "origin", "x", "z", "radius", "radii", "angle", "major", "minor", "focal", "along", "profile",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let direction = Fixed::<3> { trail, what: "[x, y, z]" };
        match name {
            "kind" => self.kind = Some(map.next_value()?),
            "origin" => self.origin = Some(map.next_value_seed(PointSeed(trail))?),
            "x" => self.x = Some(Vector::from(map.next_value_seed(direction)?)),
            "z" => self.z = Some(Vector::from(map.next_value_seed(direction)?)),
            "radii" => self.radii = Some(map.next_value_seed(Fixed { trail, what: "[along x, along y]" })?),
            "radius" => self.radius = Some(map.next_value_seed(Number)?),
            "angle" => self.angle = Some(map.next_value_seed(Number)?),
            "major" => self.major = Some(map.next_value_seed(Number)?),
            "focal" => self.focal = Some(map.next_value_seed(Number)?),
            "along" => self.along = Some(Vector::from(map.next_value_seed(direction)?)),
            "profile" => {
                let table = FormTable::default();
                self.profile = Some(Box::new(map.next_value_seed(TableSeed { trail, table })?));
            }
            _ => self.minor = Some(map.next_value_seed(Number)?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Form, E> {
        let frame = || {
            Ok(Frame {
                origin: need::<Self, _, E>(self.origin, "origin", trail)?,
                x: need::<Self, _, E>(self.x, "x", trail)?,
                z: need::<Self, _, E>(self.z, "z", trail)?,
            })
        };
        let length = |value: Option<f64>, name: &str| need::<Self, _, E>(value, name, trail);
        let kind = need::<Self, _, E>(self.kind.as_deref(), "kind", trail)?;
        let profile = || match self.profile.as_deref() {
            None => Ok(CurveForm::Spline),
            Some(Form::Curve(form)) => Ok(*form),
            Some(Form::Surface(form)) => {
                let problem = format!("\"{}\" is no kind of curve; known are {CURVES}", form.name());
                Err(trail.refuse_table("profile.kind", problem))
            }
        };
        Ok(match kind {
            "line" => Form::Curve(CurveForm::Line),
            "circle" => {
                Form::Curve(CurveForm::Circle { frame: frame()?, radius: length(self.radius, "radius")? })
            }
            "ellipse" => {
                let radii = need::<Self, _, E>(self.radii, "radii", trail)?;
                Form::Curve(CurveForm::Ellipse { frame: frame()?, radii })
            }
            "parabola" => {
                Form::Curve(CurveForm::Parabola { frame: frame()?, focal: length(self.focal, "focal")? })
            }
            "hyperbola" => {
                let radii = need::<Self, _, E>(self.radii, "radii", trail)?;
                Form::Curve(CurveForm::Hyperbola { frame: frame()?, radii })
            }
            "extrusion" => {
                let along = need::<Self, _, E>(self.along, "along", trail)?;
                Form::Surface(SurfaceForm::Extrusion { along, profile: profile()? })
            }
            "revolution" => Form::Surface(SurfaceForm::Revolution { frame: frame()?, profile: profile()? }),
            "plane" => Form::Surface(SurfaceForm::Plane { frame: frame()? }),
            "cylinder" => {
                let radius = length(self.radius, "radius")?;
                Form::Surface(SurfaceForm::Cylinder { frame: frame()?, radius })
            }
            "cone" => {
                let (radius, angle) = (length(self.radius, "radius")?, length(self.angle, "angle")?);
                Form::Surface(SurfaceForm::Cone { frame: frame()?, radius, angle })
            }
            "sphere" => {
                let radius = length(self.radius, "radius")?;
                Form::Surface(SurfaceForm::Sphere { frame: frame()?, radius })
            }
            "torus" => {
                let (major, minor) = (length(self.major, "major")?, length(self.minor, "minor")?);
                Form::Surface(SurfaceForm::Torus { frame: frame()?, major, minor })
            }
            other => {
                let names = [
                    "line",
                    "circle",
                    "ellipse",
                    "parabola",
                    "hyperbola",
                    "plane",
                    "cylinder",
                    "cone",
                    "sphere",
                    "torus",
                    "extrusion",
                    "revolution",
                ];
                let hint = hint(other, names.iter().copied(), || {
                    "leave the form out of what is a spline only".to_owned()
                });
                return Err(trail.refuse_table("kind", format!("there is no form \"{other}\"; {hint}")));
            }
        })
    }
}
