//! The surface as a kind of shape: its fields in documents, its triangles, its splines.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{
    Declaration, DeclaredShape, Faceted, Field, Fineness, ParameterError, Parameters, Splines,
};
use serde_json::Value;

use super::pattern::Quadrant;
use super::{DEPTH, SubdivisionSurface, tessellate};
use crate::cage::{BoundaryRule, Cage, INFINITELY_SHARP};
use crate::error::SubdivisionError;
use crate::said::Once;

/// The words for what becomes of the boundary.
const BOUNDARIES: [(&str, BoundaryRule); 2] =
    [("edge-and-corner", BoundaryRule::EdgeAndCorner), ("edge-only", BoundaryRule::EdgeOnly)];

/// Documents say cages as they are, every number to the last bit; an infinite sharpness is written as 10, which means the same.
impl DeclaredShape for SubdivisionSurface {
    const DECLARATION: Declaration = Declaration {
        name: "subdivision",
        help: "the limit surface of a cage",
        fields: &[
            Field::required("points", "[[x, y, z], …]", "the vertices of the cage"),
            Field::required(
                "faces",
                "[[i, j, k, …], …]",
                "the vertices of each face, counterclockwise from outside",
            ),
            Field::optional("scheme", "\"catmull-clark\"", "\"catmull-clark\"", "how it is refined"),
            Field::optional(
                "creases",
                "[[i, j, sharpness], …]",
                "none",
                "sharp edges: 0 smooth, 10 or more for ever",
            ),
            Field::optional("corners", "[[i, sharpness], …]", "none", "sharp vertices"),
            Field::optional("holes", "[face, …]", "none", "faces that are refined and not shown"),
            Field::optional(
                "intervals",
                "[[i, j, interval], …]",
                "1 each",
                "knot intervals of edges: on opposite edges of quads the same",
            ),
            Field::optional(
                "boundary",
                "\"edge-and-corner\" | \"edge-only\"",
                "\"edge-and-corner\"",
                "whether a boundary vertex with one face is a corner or rounded",
            ),
            Field::optional(
                "depth",
                "1 to 24",
                "8",
                "levels round an extraordinary vertex that integrals are taken over",
            ),
        ],
    };

    const MADE_SPLINES_BY: Option<&'static str> = Some("patches");

    fn fields(&self) -> Parameters {
        let (cage, topology) = (&self.cage, self.cage.topology());

        let said = |s: f64| if s.is_finite() { s } else { INFINITELY_SHARP };
        let faces: Vec<Value> = (0..topology.face_count()).map(|f| topology.face(f).into()).collect();
        let mut fields = Parameters::empty("")
            .with("scheme", "catmull-clark")
            .with_points("points", cage.points())
            .with("faces", faces);
        let sharp = (0..topology.edge_count()).filter(|&e| cage.crease(e) > 0.0);
        let creases: Vec<Value> = sharp
            .filter_map(|e| topology.edge(e).map(|[a, b]| serde_json::json!([a, b, said(cage.crease(e))])))
            .collect();
        let corners = (0..cage.points().len()).filter(|&v| cage.corner(v) > 0.0);
        let corners: Vec<Value> = corners.map(|v| serde_json::json!([v, said(cage.corner(v))])).collect();
        let holes: Vec<Value> =
            (0..topology.face_count()).filter(|&f| cage.is_hole(f)).map(Value::from).collect();
        let uneven = (0..topology.edge_count()).filter(|&e| cage.interval(e) != 1.0);
        let intervals: Vec<Value> = uneven
            .filter_map(|e| topology.edge(e).map(|[a, b]| serde_json::json!([a, b, cage.interval(e)])))
            .collect();
        let lists = [("creases", creases), ("corners", corners), ("holes", holes), ("intervals", intervals)];
        for (name, list) in lists {
            if !list.is_empty() {
                fields = fields.with(name, list);
            }
        }
        if cage.boundary() == BoundaryRule::EdgeOnly {
            fields = fields.with("boundary", "edge-only");
        }
        if self.depth != DEPTH {
            fields = fields.with("depth", self.depth);
        }
        fields
    }

    fn from_parameters(fields: &Parameters) -> Result<Self, ParameterError> {
        fields.choice_or("scheme", &[("catmull-clark", ())], ())?;
        let points: Vec<Point> = fields.points("points")?;
        let mut faces = Vec::new();
        for (k, face) in fields.list("faces")?.iter().enumerate() {
            faces.push(indices(fields, &format!("faces[{k}]"), face)?);
        }
        let wrong = |name: &str| {
            let name = name.to_owned();
            move |e: SubdivisionError| fields.error(&name, e.to_string())
        };
        let mut cage = Cage::new(points, &faces).map_err(wrong("faces"))?;
        cage = cage.with_boundary(fields.choice_or("boundary", &BOUNDARIES, BoundaryRule::default())?);
        let mut once = Once::new("sharpness");
        for (place, [a, b], sharpness) in rows::<2>(fields, "creases")? {
            once.say(&[a, b], sharpness).map_err(wrong(&place))?;
            cage = cage.with_crease(a, b, sharpness).map_err(wrong(&place))?;
        }
        for (place, [v], sharpness) in rows::<1>(fields, "corners")? {
            once.say(&[v], sharpness).map_err(wrong(&place))?;
            cage = cage.with_corner(v, sharpness).map_err(wrong(&place))?;
        }
        let mut once = Once::new("interval");
        for (place, [a, b], interval) in rows::<2>(fields, "intervals")? {
            once.say(&[a, b], interval).map_err(wrong(&place))?;
            cage = cage.with_interval(a, b, interval).map_err(wrong(&place))?;
        }
        if let Some(holes) = fields.value("holes") {
            for hole in indices(fields, "holes", holes)? {
                cage = cage.with_hole(hole).map_err(wrong("holes"))?;
            }
        }
        let depth = u32::try_from(fields.count_or("depth", DEPTH as usize)?).unwrap_or(u32::MAX);
        let name = if depth == DEPTH { "faces" } else { "depth" };
        Self::with_depth(cage, depth).map_err(wrong(name))
    }

    fn tessellate(states: &[&Self], fineness: &Fineness) -> loftsman_kernel::error::Result<Faceted> {
        tessellate::tessellate(states, fineness)
    }

    /// The [patches](SubdivisionSurface::patches), where every face is regular: then they are exact.
    fn splines(&self) -> Option<Splines> {
        let regular = |face: usize| self.layout.pattern(face).is_regular(Quadrant::WHOLE);
        if !(0..self.layout.faces.len()).all(regular) {
            return None;
        }
        // Any tolerance will do, for nothing is left to come near to.
        Some(Splines::Surfaces(self.patches(1.0).ok()?.surfaces))
    }
}

/// A list of indices.
pub(crate) fn indices(fields: &Parameters, place: &str, value: &Value) -> Result<Vec<usize>, ParameterError> {
    let wrong = || fields.error(place, "a list of indices from 0 on is needed");
    let list = value.as_array().ok_or_else(wrong)?;
    let index = |v: &Value| v.as_u64().and_then(|k| usize::try_from(k).ok()).ok_or_else(wrong);
    list.iter().map(index).collect()
}

/// Of each row of a field its place, its indices and the number that follows them; none where the field is left out.
pub(crate) type Sharp<const N: usize> = (String, [usize; N], f64);

pub(crate) fn rows<const N: usize>(fields: &Parameters, name: &str) -> Result<Vec<Sharp<N>>, ParameterError> {
    if !fields.has(name) {
        return Ok(Vec::new());
    }
    let row = |(k, value): (usize, &Value)| {
        let place = format!("{name}[{k}]");
        let wrong = || fields.error(&place, format!("a list of {N} indices and a number is needed"));
        let list = value.as_array().filter(|list| list.len() == N + 1).ok_or_else(wrong)?;
        let mut found = [0; N];
        for (index, value) in found.iter_mut().zip(list) {
            *index = value.as_u64().and_then(|k| usize::try_from(k).ok()).ok_or_else(wrong)?;
        }
        let sharpness = list[N].as_f64().ok_or_else(wrong)?;
        Ok((place.clone(), found, sharpness))
    };
    fields.list(name)?.iter().enumerate().map(row).collect()
}
