//! Geometries: their tables become the kernel's shapes, and what the kernel refuses gets the path of the field.

use loftsman_kernel::Point;
use loftsman_kernel::brep::CurveForm;
use loftsman_kernel::error::{Error as Defect, MAX_DEGREE};
use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::spline::{Curve, CurvePiece, Space, Surface, SurfacePiece};
use serde::de::{Error, MapAccess};

use super::brep::{CURVES, Form, FormTable, SURFACES};
use super::lists::{Count, Fixed, Grid, GridSeed, List, Number};
use super::table::{Table, TableSeed, need};
use super::trail::Trail;

/// The knots of one direction: what a curve has among its own fields and a surface has twice.
#[derive(Default)]
struct Knots {
    degree: Option<u64>,
    periodic: bool,
    knots: Option<Vec<f64>>,
}

impl Knots {
    /// Reads one of its fields; false where the field is none of them.
    fn field<'de, A: MapAccess<'de>>(
        &mut self,
        name: &str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<bool, A::Error> {
        match name {
            "degree" => self.degree = Some(map.next_value_seed(Count)?),
            "periodic" => self.periodic = map.next_value()?,
            "knots" => self.knots = Some(map.next_value_seed(List::numbers(trail))?),
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// The space for a number of vertices; `table` is who asks, `points` where the vertices are, from there.
    fn space<'de, T: Table<'de>, E: Error>(
        self,
        vertices: usize,
        above: &str,
        points: &str,
        trail: &Trail,
    ) -> Result<Space, E> {
        let path = |field: &str| match field {
            "points" => points.to_owned(),
            field => format!("{above}{field}"),
        };
        let degree = need::<T, _, _>(self.degree, "degree", trail)?;
        let knots = need::<T, _, _>(self.knots, "knots", trail)?;
        let degree = usize::try_from(degree).unwrap_or(usize::MAX);
        let (kind, needed, expected) = if self.periodic {
            ("a periodic", 2, vertices.checked_add(1))
        } else {
            // Beyond MAX_DEGREE the degree itself is refused below.
            let order = degree.min(MAX_DEGREE) + 1;
            ("an open", order, vertices.checked_add(order))
        };
        let defect = if degree == 0 || degree > MAX_DEGREE {
            Some(Defect::Degree { degree })
        } else if vertices < needed {
            Some(Defect::TooFewVertices { vertices, degree, needed })
        } else {
            expected.filter(|&expected| knots.len() != expected).map(|expected| Defect::KnotCount {
                knots: knots.len(),
                vertices,
                degree,
                kind,
                expected,
            })
        };
        let space = match defect {
            Some(defect) => Err(defect),
            None if self.periodic => Space::periodic(degree, knots),
            None => Space::open(degree, knots),
        };
        space.map_err(|defect| trail.refuse_table(path(&field_of(&defect, 0)), defect.to_string()))
    }
}

/// The field of a geometry's table that a defect belongs to; rows of `columns` vertices where that is not 0.
fn field_of(defect: &Defect, columns: usize) -> String {
    let entry = |list: &str, index: usize| match index.checked_div(columns) {
        Some(row) => format!("{list}[{row}][{}]", index % columns),
        None => format!("{list}[{index}]"),
    };
    match defect {
        Defect::Degree { .. } => "degree".to_owned(),
        Defect::KnotNotFinite { index, .. } | Defect::KnotOrder { index, .. } => format!("knots[{index}]"),
        Defect::KnotCount { .. } | Defect::Multiplicity { .. } | Defect::EmptyDomain { .. } => {
            "knots".to_owned()
        }
        Defect::TooFewVertices { .. } | Defect::Grid { .. } => "points".to_owned(),
        Defect::VertexNotFinite { index, .. } => entry("points", *index),
        Defect::Weight { index, .. } => entry("weights", *index),
        Defect::WeightCount { .. } => "weights".to_owned(),
        Defect::Face { face, .. } => format!("faces[{face}]"),
        _ => String::new(),
    }
}

/// The error of a table for a defect that the kernel found.
pub(super) fn refuse<E: Error>(defect: &Defect, columns: usize, trail: &Trail) -> E {
    trail.refuse_table(field_of(defect, columns), defect.to_string())
}

/// `"curve"`.
#[derive(Default)]
pub(super) struct CurveTable {
    knots: Knots,
    points: Option<Vec<Point>>,
    weights: Option<Vec<f64>>,
}

impl<'de> Table<'de> for CurveTable {
    type Out = Curve;
    const WHAT: &'static str = "a curve";
    const FIELDS: &'static [&'static str] = &["degree", "periodic", "knots", "points", "weights"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        if self.knots.field(name, map, trail)? {
            return Ok(());
        }
        match name {
            "points" => self.points = Some(map.next_value_seed(List::points(trail))?),
            _ => self.weights = Some(map.next_value_seed(List::numbers(trail))?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Curve, E> {
        let points = need::<Self, _, _>(self.points, "points", trail)?;
        let space = self.knots.space::<Self, E>(points.len(), "", "points", trail)?;
        Curve::build(space, points, self.weights).map_err(|defect| refuse(&defect, 0, trail))
    }
}

/// `"curve"` of an object: with what it is beside a spline.
#[derive(Default)]
pub(super) struct FormedCurveTable {
    curve: CurveTable,
    form: Option<CurvePiece>,
}

impl<'de> Table<'de> for FormedCurveTable {
    type Out = Curve;
    const WHAT: &'static str = CurveTable::WHAT;
    const FIELDS: &'static [&'static str] = &["degree", "periodic", "knots", "points", "weights", "form"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        if name != "form" {
            return self.curve.field(name, map, trail);
        }
        self.form = Some(map.next_value_seed(TableSeed { trail, table: PieceOfFormTable::default() })?);
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Curve, E> {
        let curve = self.curve.finish(trail)?;
        let Some(form) = self.form else { return Ok(curve) };
        curve.with_form(form).map_err(|defect| {
            let problem = format!("{defect}; leave the form out of what is a spline only");
            trail.refuse_table("form", problem)
        })
    }
}

/// `"form"` of a curve: a line or conic, and from where to where.
#[derive(Default)]
struct PieceOfFormTable {
    form: FormTable,
    from: Option<f64>,
    to: Option<f64>,
}

impl<'de> Table<'de> for PieceOfFormTable {
    type Out = CurvePiece;
    const WHAT: &'static str = FormTable::WHAT;
    const FIELDS: &'static [&'static str] =
        &["kind", "origin", "x", "z", "radius", "radii", "focal", "from", "to"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "from" => self.from = Some(map.next_value_seed(Number)?),
            "to" => self.to = Some(map.next_value_seed(Number)?),
            _ => return self.form.field(name, map, trail),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<CurvePiece, E> {
        let form = match self.form.finish(trail)? {
            Form::Curve(form) => form,
            Form::Surface(form) => {
                let problem = format!("\"{}\" is no kind of curve; known are {CURVES}", form.name());
                return Err(trail.refuse_table("kind", problem));
            }
        };
        let usual = (form == CurveForm::Line).then_some(CurvePiece::LINE.range);
        let end = |given: Option<f64>, k: usize| given.or(usual.map(|range| range[k]));
        let from = need::<Self, _, _>(end(self.from, 0), "from", trail)?;
        let to = need::<Self, _, _>(end(self.to, 1), "to", trail)?;
        Ok(CurvePiece { form, range: [from, to] })
    }
}

/// `"u"` and `"v"` of a surface.
#[derive(Default)]
struct DirectionTable(Knots);

impl<'de> Table<'de> for DirectionTable {
    type Out = Knots;
    const WHAT: &'static str = "a direction of a surface";
    const FIELDS: &'static [&'static str] = &["degree", "periodic", "knots"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        self.0.field(name, map, trail).map(|_| ())
    }

    fn finish<E: Error>(self, _: &Trail) -> Result<Knots, E> {
        Ok(self.0)
    }
}

/// `"surface"`.
#[derive(Default)]
pub(super) struct SurfaceTable {
    u: Option<Knots>,
    v: Option<Knots>,
    points: Option<Grid<Point>>,
    weights: Option<Grid<f64>>,
}

impl<'de> Table<'de> for SurfaceTable {
    type Out = Surface;
    const WHAT: &'static str = "a surface";
    const FIELDS: &'static [&'static str] = &["u", "v", "points", "weights"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let direction = TableSeed { trail, table: DirectionTable::default() };
        match name {
            "u" => self.u = Some(map.next_value_seed(direction)?),
            "v" => self.v = Some(map.next_value_seed(direction)?),
            "points" => self.points = Some(map.next_value_seed(GridSeed(List::points(trail)))?),
            _ => self.weights = Some(map.next_value_seed(GridSeed(List::numbers(trail)))?),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Surface, E> {
        let u = need::<Self, _, _>(self.u, "u", trail)?;
        let v = need::<Self, _, _>(self.v, "v", trail)?;
        let points = need::<Self, _, _>(self.points, "points", trail)?;
        let u = u.space::<DirectionTable, E>(points.rows, "u.", "points", trail)?;
        let v = v.space::<DirectionTable, E>(points.columns, "v.", "points[0]", trail)?;
        if let Some(weights) = &self.weights
            && (weights.rows, weights.columns) != (points.rows, points.columns)
        {
            let problem = format!(
                "{} rows of {} weights do not fit {} rows of {} points: give one weight a point, or none",
                weights.rows, weights.columns, points.rows, points.columns
            );
            return Err(trail.refuse_table("weights", problem));
        }
        Surface::build(u, v, points.items, self.weights.map(|w| w.items))
            .map_err(|defect| refuse(&defect, points.columns, trail))
    }
}

/// `"surface"` of an object: with what it is beside a spline.
#[derive(Default)]
pub(super) struct FormedSurfaceTable {
    surface: SurfaceTable,
    form: Option<SurfacePiece>,
}

impl<'de> Table<'de> for FormedSurfaceTable {
    type Out = Surface;
    const WHAT: &'static str = SurfaceTable::WHAT;
    const FIELDS: &'static [&'static str] = &["u", "v", "points", "weights", "form"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        if name != "form" {
            return self.surface.field(name, map, trail);
        }
        self.form = Some(map.next_value_seed(TableSeed { trail, table: PatchOfFormTable::default() })?);
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Surface, E> {
        let surface = self.surface.finish(trail)?;
        let Some(form) = self.form else { return Ok(surface) };
        surface.with_form(form).map_err(|defect| {
            let problem = format!("{defect}; leave the form out of what is a spline only");
            trail.refuse_table("form", problem)
        })
    }
}

/// `"form"` of a surface: an elementary or swept one, and from where to where.
#[derive(Default)]
struct PatchOfFormTable {
    form: FormTable,
    u: Option<[f64; 2]>,
    v: Option<[f64; 2]>,
}

impl<'de> Table<'de> for PatchOfFormTable {
    type Out = SurfacePiece;
    const WHAT: &'static str = FormTable::WHAT;
    const FIELDS: &'static [&'static str] =
        &["kind", "origin", "x", "z", "radius", "angle", "major", "minor", "along", "profile", "u", "v"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let range = Fixed { trail, what: "[from, to]" };
        match name {
            "u" => self.u = Some(map.next_value_seed(range)?),
            "v" => self.v = Some(map.next_value_seed(range)?),
            _ => return self.form.field(name, map, trail),
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<SurfacePiece, E> {
        let form = match self.form.finish(trail)? {
            Form::Surface(form) => form,
            Form::Curve(form) => {
                let problem = format!("\"{}\" is no kind of surface; known are {SURFACES}", form.name());
                return Err(trail.refuse_table("kind", problem));
            }
        };
        let u = need::<Self, _, _>(self.u, "u", trail)?;
        let v = need::<Self, _, _>(self.v, "v", trail)?;
        Ok(SurfacePiece { form, ranges: [u, v] })
    }
}

/// `"polyline"`.
#[derive(Default)]
pub(super) struct PolylineTable {
    points: Option<Vec<Point>>,
    closed: bool,
}

impl<'de> Table<'de> for PolylineTable {
    type Out = Polyline;
    const WHAT: &'static str = "a polyline";
    const FIELDS: &'static [&'static str] = &["points", "closed"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "points" => self.points = Some(map.next_value_seed(List::points(trail))?),
            _ => self.closed = map.next_value()?,
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Polyline, E> {
        Ok(Polyline { points: need::<Self, _, _>(self.points, "points", trail)?, closed: self.closed })
    }
}

/// `"cloud"`.
#[derive(Default)]
pub(super) struct CloudTable {
    points: Option<Vec<Point>>,
}

impl<'de> Table<'de> for CloudTable {
    type Out = Cloud;
    const WHAT: &'static str = "a cloud";
    const FIELDS: &'static [&'static str] = &["points"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        _: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        self.points = Some(map.next_value_seed(List::points(trail))?);
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Cloud, E> {
        Ok(Cloud { points: need::<Self, _, _>(self.points, "points", trail)? })
    }
}

/// `"group"`.
#[derive(Default)]
pub(super) struct GroupTable;

impl<'de> Table<'de> for GroupTable {
    type Out = ();
    const WHAT: &'static str = "a group";
    const FIELDS: &'static [&'static str] = &[];

    fn field<A: MapAccess<'de>>(&mut self, _: &'static str, _: &mut A, _: &Trail) -> Result<(), A::Error> {
        Ok(())
    }

    fn finish<E: Error>(self, _: &Trail) -> Result<(), E> {
        Ok(())
    }
}

/// `"animation"` of an object.
#[derive(Default)]
pub(super) struct AnimationTable {
    rate: Option<f64>,
    frames: Option<Vec<Vec<Point>>>,
}

impl<'de> Table<'de> for AnimationTable {
    type Out = loftsman_kernel::scene::Animation;
    const WHAT: &'static str = "an animation";
    const FIELDS: &'static [&'static str] = &["rate", "frames"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "rate" => self.rate = Some(map.next_value_seed(Number)?),
            _ => {
                let item = List::points(trail);
                self.frames = Some(map.next_value_seed(List { trail, what: "frames", item })?);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Self::Out, E> {
        let rate = need::<Self, _, _>(self.rate, "rate", trail)?;
        if rate <= 0.0 {
            let problem = format!("{rate} frames a second: the rate must be positive");
            return Err(trail.refuse_table("rate", problem));
        }
        Ok(Self::Out { rate, frames: need::<Self, _, _>(self.frames, "frames", trail)? })
    }
}
