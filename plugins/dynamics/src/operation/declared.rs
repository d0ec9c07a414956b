//! What `simulate` takes: its fields, and those of the tables that these list.

use loftsman_kernel::plugin::{Declaration, Field, Table};

pub(super) const FIELDS: [Field; 22] = [
    Field::optional("object", "text", "the only curve or surface", "what moves"),
    Field::optional("seconds", "number", "this or settle is needed", "how long it moves"),
    Field::optional(
        "settle",
        "true | false",
        "false",
        "go to where everything rests, at the end; with seconds left out, at once",
    ),
    Field::optional("scheme", "\"epsilon\" | \"exact\" | \"implicit\"", "epsilon", "how steps are taken"),
    Field::optional(
        "step",
        "number (seconds)",
        "as long as is stable",
        "the longest step; explicit ones are shorter where they must be",
    ),
    Field::optional("frames_per_second", "number", "24", "the rate of the animation"),
    Field::optional("mass", "number", "1", "a unit of length of a curve, of area of a surface"),
    Field::optional(
        "stiffness",
        "number",
        "200 times the weight (of a surface: over the root of its area)",
        "the force that would stretch it to twice its length",
    ),
    Field::optional(
        "shear",
        "number",
        "half the stiffness",
        "of a surface: the force for a shear by an angle of 1",
    ),
    Field::optional("rest", "number", "1", "what its length at rest is of its length now"),
    Field::optional("bending", "number", "0", "the moment for a curvature of 1; it is straight by nature"),
    Field::optional("damping", "number (1/s)", "0.5", "how fast motion dies away: the air; 0 for none"),
    Field::optional("viscosity", "number", "0", "the force that resists a rate of stretching of 1/s"),
    Field::optional("gravity", "[x, y, z]", "9.81 m/s² down", "the acceleration of all that falls"),
    Field::optional("constraints", "[{ kind, … }, …]", "none", "what holds it; its tables are listed below"),
    Field::optional(
        "pull",
        "[{ at, to, stiffness, … }, …]",
        "none",
        "damped springs to a place or along a path: [[x, y, z], …]",
    ),
    Field::optional("forces", "[{ at, force, … }, …]", "none", "forces at places"),
    Field::optional(
        "bodies",
        "[{ object, still, mass, … }, …]",
        "none",
        "other objects that move along, made of what they say, else of the same; `still = true` for what others slide on",
    ),
    Field::optional(
        "epsilon",
        "number",
        "0.001",
        "the mass of a floating location, of that between two control vertices",
    ),
    Field::optional(
        "draw",
        "number (seconds)",
        "0.05",
        "the time constant by which what a constraint misses when it comes is drawn in: (1 + t/draw) e^(-t/draw) of it is left after t seconds, 4 % after five of them, a millionth after 17",
    ),
    Field::optional(
        "corners",
        "true | false",
        "true",
        "with settle: where a curve without bending turns at a place that slides it is given knots for a corner, and both sides rest stretched alike",
    ),
    Field::optional(
        "settle_frames",
        "true | false",
        "false",
        "keep the rest that settle finds as one more frame",
    ),
];

/// The tables of its fields.
pub(super) const TABLES: [Table; 4] = [
    Table {
        field: "constraints",
        help: "what holds a shape while it moves: a kind of these with its own fields, or any linear kind that edits have \
               (`loftsman plugins constraints`) with its own and `to` (numbers; without it the value stays, and a condition holds) and `axis`",
        fields: &ALL,
        kinds: &KINDS,
    },
    Table { field: "pull", help: "damped springs: what a mouse does", fields: &PULL, kinds: &[] },
    Table { field: "forces", help: "forces that stay as they are", fields: &FORCE, kinds: &[] },
    Table {
        field: "bodies",
        help: "other objects that move along, or stand still for others to slide on",
        fields: &BODY,
        kinds: &[],
    },
];

const FROM: Field = Field::optional("from", "number (seconds)", "0", "when it comes");
const UNTIL: Field = Field::optional("until", "number (seconds)", "the end", "when it goes");
const OBJECT: Field = Field::optional(
    "object",
    "text",
    "what moves",
    "whose it is: another object stands still unless it is a body",
);

/// What all constraints take.
pub(super) const ALL: [Field; 5] = [
    Field::required("kind", "name", "what it is"),
    OBJECT,
    Field::optional("name", "text", "its kind and location", "what reports and messages call it"),
    FROM,
    UNTIL,
];

const AT: Field = Field::required("at", "location", "where on the shape; it stays there");
const NEAR: Field = Field::required("near", "location", "where on the shape it starts; it slides from there");
const TO: Field = Field::optional(
    "to",
    "[x, y, z], or [[x, y, z], …]",
    "where the point is as it comes",
    "the place, or a path that it goes from one to the next, smoothly, in equal times",
);
const WITH: Field = Field::optional(
    "to",
    "[x, y, z], or [[x, y, z], …]",
    "anywhere",
    "where the shape passes with it, or the path of that place, from one to the next in equal times",
);
const ARRIVE: Field = Field::optional(
    "arrive",
    "number (seconds)",
    "until, or the end",
    "when a path has reached its last place",
);
const AXIS: Field =
    Field::optional("axis", "\"x\" | \"y\" | \"z\", or a list of these", "all", "only these coordinates");

/// The kinds of constraint of its own, with the fields that each has beside those of all.
pub(super) const KINDS: [Declaration; 7] = [
    Declaration {
        name: "fixed",
        help: "a point of the shape stays at a place",
        fields: &[AT, TO, ARRIVE, AXIS],
    },
    Declaration {
        name: "sliding",
        help: "the shape passes a place, wherever along itself",
        fields: &[NEAR, TO, ARRIVE, AXIS],
    },
    Declaration {
        name: "knot",
        help: "a curve passes one of its own points: a running knot",
        fields: &[
            NEAR,
            Field::required("at", "location", "the point that it passes; it stays the same of the curve"),
        ],
    },
    Declaration {
        name: "double-sliding",
        help: "a curve passes itself, wherever on both sides",
        fields: &[Field::required(
            "near",
            "[location, location]",
            "the two that start together; both slide: [a, b] on a curve, [[u, v], [u, v]] on a surface",
        )],
    },
    Declaration {
        name: "sliding-tangent",
        help: "somewhere a curve has this first derivative; with `to` where it passes a place",
        fields: &[NEAR, Field::required("direction", "[x, y, z]", "the first derivative"), WITH, ARRIVE],
    },
    Declaration {
        name: "sliding-curvature",
        help: "somewhere a curve has this second derivative; with `to` where it passes a place",
        fields: &[NEAR, Field::required("curvature", "[x, y, z]", "the second derivative"), WITH, ARRIVE],
    },
    Declaration {
        name: "tied",
        help: "points of two objects are one, each at a location that stays or near one that slides",
        fields: &[
            Field::optional(
                "at",
                "location",
                "this or near is needed",
                "where on the object; it stays there",
            ),
            Field::optional(
                "near",
                "location",
                "this or at is needed",
                "where on the object it starts; it slides",
            ),
            Field::required("other", "text", "the other object"),
            Field::optional(
                "other_at",
                "location",
                "this or other_near is needed",
                "where on the other; it stays there",
            ),
            Field::optional(
                "other_near",
                "location",
                "this or other_at is needed",
                "where on the other it starts; it slides",
            ),
        ],
    },
];

/// What a pull takes.
pub(super) const PULL: [Field; 7] = [
    AT,
    Field::required(
        "to",
        "[x, y, z], or [[x, y, z], …]",
        "the place that it draws to, or a path from one to the next in equal times",
    ),
    Field::required("stiffness", "number", "the force for a distance of 1"),
    ARRIVE,
    OBJECT,
    FROM,
    UNTIL,
];

/// What a force takes.
pub(super) const FORCE: [Field; 5] =
    [AT, Field::required("force", "[x, y, z]", "the force, in mass · length / s²"), OBJECT, FROM, UNTIL];

/// What a body takes.
pub(super) const BODY: [Field; 9] = [
    Field::required("object", "text", "a curve or surface beside the first"),
    Field::optional("still", "true | false", "false", "it stands still: for what slides on it"),
    Field::optional("mass", "number", "the step's", "as of the step"),
    Field::optional("stiffness", "number", "the step's", "as of the step"),
    Field::optional("shear", "number", "the step's", "as of the step"),
    Field::optional("rest", "number", "the step's", "as of the step"),
    Field::optional("bending", "number", "the step's", "as of the step"),
    Field::optional("damping", "number (1/s)", "the step's", "as of the step"),
    Field::optional("viscosity", "number", "the step's", "as of the step"),
];
