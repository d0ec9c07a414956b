//! The fields of a match, in recipes: of the constraint and of the operation.

use loftsman_kernel::functional::{DeclaredFunctional, Edge, On, ShapeNames};
use loftsman_kernel::plugin::{Declaration, Field, ParameterError, Parameters};

use crate::deviation::Limits;
use crate::edge_on::{OBJECT, named, tolerance};
use crate::matching::{Matching, matching};

pub(crate) const LIMITS: [Field; 3] = [
    Field::optional("tolerance", "length", "none: to rounding, or refused", "how far the edges may be apart"),
    Field::optional(
        "angle",
        "degrees",
        "0.1",
        "the largest angle between the surfaces, from continuity 1 on",
    ),
    Field::optional(
        "curvature",
        "number (percent)",
        "5",
        "with continuity 2, the largest difference of the normal curvatures square to the edge, of the largest curvature of the other \
         surface along it",
    ),
];

/// The limits that fields give; those that nothing would be judged by with this continuity are refused.
pub(crate) fn limits(p: &Parameters, continuity: usize) -> Result<Limits, ParameterError> {
    for (field, least) in [("angle", 1), ("curvature", 2)] {
        if p.has(field) && continuity < least {
            let problem = format!(
                "it limits nothing with continuity {continuity}: say continuity = {least}, or leave it out"
            );
            return Err(p.error(field, problem));
        }
    }
    let default = Limits::default();
    Ok(Limits {
        distance: tolerance(p, "tolerance")?,
        angle: tolerance(p, "angle")?.map_or(default.angle, f64::to_radians),
        curvature: tolerance(p, "curvature")?.map_or(default.curvature, |percent| percent / 100.0),
    })
}

pub(crate) const EDGE: Field = Field::required(
    "edge",
    "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"",
    "the edge that moves: where u or v starts or ends",
);

pub(crate) const WITH: Field =
    Field::required("with", "{ object, edge }", "the surface that stands still, and which of its edges");

/// What the field `with` names.
pub(crate) fn other(p: &Parameters) -> Result<Parameters, ParameterError> {
    const FIELDS: [Field; 2] = [
        Field::required("object", "text", "the surface that stands still"),
        Field::required("edge", "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"", "its edge"),
    ];
    if let Some(name) = p.value("with").and_then(|with| with.as_str()) {
        let problem =
            format!("an object and its edge are needed: with = {{ object = \"{name}\", edge = \"u0\" }}");
        return Err(p.error("with", problem));
    }
    let with = p.table("with")?;
    with.check(&FIELDS)?;
    Ok(with)
}

pub(crate) const CONTINUITY: Field =
    Field::optional("continuity", "0 | 1 | 2", "1", "position, tangent planes (G1), curvature (G2)");

/// The field `continuity`.
pub(crate) fn continuity(p: &Parameters) -> Result<usize, ParameterError> {
    match p.count_or("continuity", 1)? {
        order @ 0..=2 => Ok(order),
        order => Err(p.error("continuity", format!("{order} is not 0, 1 or 2"))),
    }
}

impl DeclaredFunctional for Matching {
    const DECLARATION: Declaration = Declaration {
        name: "match",
        help: "an edge meets the edge of another surface, which stands still: in position, tangent planes (G1), curvature (G2)",
        fields: &[EDGE, WITH, CONTINUITY, LIMITS[0], LIMITS[1], LIMITS[2], OBJECT],
    };

    fn from_parameters(p: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let with = other(p)?;
        let continuity = continuity(p)?;
        let other_edge = Edge::from_parameters(&with, "edge")?;
        let edge = Edge::from_parameters(p, "edge")?;
        let other = named(&with, "object", names)?;
        let on = On::from_parameters(p, names)?;
        Ok(matching(edge, other, other_edge, continuity, limits(p, continuity)?).on(on))
    }
}
