//! The surface as a kind of shape: its fields in documents, its triangles, its splines.

use loftsman_kernel::Point;
use loftsman_kernel::plugin::{
    Declaration, DeclaredShape, Faceted, Field, Fineness, ParameterError, Parameters, Splines,
};
use serde_json::Value;

use super::{DEPTH, DooSabinSurface, tessellate};
use crate::cage::Cage;
use crate::error::SubdivisionError;
use crate::said::Once;
use crate::surface::declared::{indices, rows};

/// Documents say cages as they are, every number to the last bit.
impl DeclaredShape for DooSabinSurface {
    const DECLARATION: Declaration = Declaration {
        name: "doo-sabin",
        help: "the limit surface of a cage under Doo-Sabin subdivision",
        fields: &[
            Field::required("points", "[[x, y, z], …]", "the vertices of the cage"),
            Field::required(
                "faces",
                "[[i, j, k, …], …]",
                "the vertices of each face, counterclockwise from outside",
            ),
            Field::optional(
                "intervals",
                "[[i, j, interval], …]",
                "1 each",
                "knot intervals of vertices i in the direction of their edges to j: all along a row of faces the same, 0 for a double knot",
            ),
            Field::optional("holes", "[face, …]", "none", "faces that are refined and not shown"),
            Field::optional(
                "depth",
                "1 to 24",
                "8",
                "levels round an extraordinary point that integrals are taken over",
            ),
        ],
    };

    const MADE_SPLINES_BY: Option<&'static str> = Some("patches");

    fn fields(&self) -> Parameters {
        let (cage, topology) = (&self.cage, self.cage.topology());
        let faces: Vec<Value> = (0..topology.face_count()).map(|f| topology.face(f).into()).collect();
        let holes: Vec<Value> =
            (0..topology.face_count()).filter(|&f| cage.is_hole(f)).map(Value::from).collect();
        let mut fields = Parameters::empty("").with_points("points", cage.points()).with("faces", faces);
        let ends = |e: usize| {
            let (ends, d) = (topology.edge(e), cage.end_interval(e));
            ends.into_iter().flat_map(move |[a, b]| [([a, b], d[0]), ([b, a], d[1])])
        };
        let uneven = (0..topology.edge_count()).flat_map(ends).filter(|(_, d)| *d != 1.0);
        let intervals: Vec<Value> = uneven.map(|([a, b], d)| serde_json::json!([a, b, d])).collect();
        if !intervals.is_empty() {
            fields = fields.with("intervals", intervals);
        }
        if !holes.is_empty() {
            fields = fields.with("holes", holes);
        }
        if self.depth != DEPTH {
            fields = fields.with("depth", self.depth);
        }
        fields
    }

    fn from_parameters(fields: &Parameters) -> Result<Self, ParameterError> {
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
        let mut once = Once::new("interval");
        for (place, [at, towards], interval) in rows::<2>(fields, "intervals")? {
            once.say_towards(at, towards, interval).map_err(wrong(&place))?;
            cage = cage.with_end_interval(at, towards, interval).map_err(wrong(&place))?;
        }
        if let Some(holes) = fields.value("holes") {
            for hole in indices(fields, "holes", holes)? {
                cage = cage.with_hole(hole).map_err(wrong("holes"))?;
            }
        }
        let depth = u32::try_from(fields.count_or("depth", DEPTH as usize)?).unwrap_or(u32::MAX);
        Self::with_depth(cage, depth).map_err(wrong(if depth == DEPTH { "faces" } else { "depth" }))
    }

    fn tessellate(states: &[&Self], fineness: &Fineness) -> loftsman_kernel::error::Result<Faceted> {
        tessellate::tessellate(states, fineness)
    }

    /// The [patches](DooSabinSurface::patches), where every face is regular: then they are exact.
    fn splines(&self) -> Option<Splines> {
        if !self.is_all_regular() {
            return None;
        }
        // Any tolerance will do, for nothing is left to come near to.
        Some(Splines::Surfaces(self.patches(1.0).ok()?.surfaces))
    }
}
