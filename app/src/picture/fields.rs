//! The fields of a recipe's table `picture`, and the words that they take.

use loftsman_kernel::plugin::Field;
use loftsman_picture::{Against, Curvature, Faces, View};

/// The names of views.
pub const VIEWS: [(&str, View); 6] = [
    ("automatic", View::Automatic),
    ("front", View::Front),
    ("top", View::Top),
    ("right", View::Right),
    ("isometric", View::Isometric),
    ("perspective", View::Perspective),
];

/// What curvature can be drawn against.
pub const AGAINST: [(&str, Against); 2] =
    [("arc-length", Against::ArcLength), ("parameter", Against::Parameter)];

/// The fields of a recipe's table `picture`.
pub const FIELDS: &[Field] = &[
    Field::optional("title", "text", "none", "a line above the picture"),
    Field::optional("view", "name or [x, y, z]", "\"automatic\"", VIEW),
    Field::optional(
        "objects",
        "[name, …]",
        "all",
        "what is shown, in every panel that does not say itself; \"frames*\": all whose names begin so",
    ),
    Field::optional(
        "panel",
        "[{ caption, view, profile, faces, objects }, …]",
        "one view",
        "parts of the picture; `profile` (\"arc-length\" or \"parameter\") makes one a chart of curvature",
    ),
    Field::optional("columns", "count", "by number and shape", "panels in a row"),
    Field::optional("before", "true | false", "true", "show each object as it was, lighter"),
    Field::optional("points", "true | false", "true", "the points that curves and surfaces were fitted to"),
    Field::optional(
        "frames",
        "true | false | count",
        "false",
        "show frames of animations in the drawing: a few dashed, or so many, the fainter the earlier",
    ),
    Field::optional("film", "count", "none", "frames of animations side by side, so many from first to last"),
    Field::optional(
        "combs",
        "true | false | scale",
        "false",
        "curvature combs, of surfaces on some lines of equal parameter; a tooth is scale · curvature long",
    ),
    Field::optional("knots", "true | false | count", "false", "beads at knots, or so many in each span"),
    Field::optional("polygons", "true | false", "true", "control polygons and nets"),
    Field::optional(
        "movements",
        "true | false",
        "false",
        "arrows from control vertices before to where they are",
    ),
    Field::optional("segments", "true | false", "false", "the segments of curves dark and light in turn"),
    Field::optional("faces", FACES_TAKE, "shaded", FACES),
    Field::optional("labels", "true | false", "true", "labels of what was asked"),
    Field::optional(
        "parameters",
        "true | false",
        "false",
        "parameters written beside curves, and those of lines of equal u and v on surfaces: what `at` takes",
    ),
    Field::optional("marks", "true | false", "true", "what was asked: points moved and kept, directions, …"),
    Field::optional("legend", "true | false", "true", "what is what, axes and scale"),
    Field::optional("dark", "true | false", "false", "light on dark"),
    Field::optional("width", "millimetres", "180", "of the page"),
    Field::optional("height", "millimetres", "two thirds of the width", "of a drawing, at most"),
    Field::optional("pixels", "count", "1600", "the width of a PNG"),
];

const FACES_TAKE: &str =
    "\"shaded\" | \"zebra\" | \"mean\" | \"gaussian\" | \"maximum\" | \"minimum\" | \"deviation\"";
const FACES: &str = "what the colours of faces show: stripes that a striped world is mirrored in, a curvature, the distance from the \
                     state before (+ along normals); with a scale";

/// The words of `faces`.
pub const FACE_WORDS: [(&str, Faces); 7] = [
    ("shaded", Faces::Shaded),
    ("zebra", Faces::Zebra),
    ("mean", Faces::Curvature(Curvature::Mean)),
    ("gaussian", Faces::Curvature(Curvature::Gaussian)),
    ("maximum", Faces::Curvature(Curvature::Maximum)),
    ("minimum", Faces::Curvature(Curvature::Minimum)),
    ("deviation", Faces::Deviation),
];

/// The fields of a panel.
pub(super) const PANEL: &[Field] = &[
    Field::optional("caption", "text", "none", "a line below the panel"),
    Field::optional("view", "name or [x, y, z]", "\"automatic\"", VIEW),
    Field::optional(
        "profile",
        "\"arc-length\" | \"parameter\"",
        "a drawing",
        "a chart of curvature against this",
    ),
    Field::optional(
        "objects",
        "[name, …]",
        "the picture's",
        "what it shows; \"frames*\": all whose names begin so",
    ),
    Field::optional("faces", FACES_TAKE, "the picture's", FACES),
];

const VIEW: &str =
    "automatic, front, top, right, isometric, perspective, or the direction towards the viewer";
