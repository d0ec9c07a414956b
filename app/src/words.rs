//! What the words mean that declarations use for what a field takes: for help.

/// A word or the name of a field of a table, and what is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub(crate) struct Word {
    /// As declarations write it.
    pub(crate) word: &'static str,
    /// What to write in its place.
    pub(crate) means: &'static str,
}

/// A word with its meaning.
const fn word(word: &'static str, means: &'static str) -> Word {
    Word { word, means }
}

/// The words of recipes, options and pictures.
pub(crate) const WORDS: &[Word] = &[
    word(
        "[x, y, z]",
        "three numbers along the axes of the scene, or of the object where it is one of its places: a place, in the unit of the scene, or a direction",
    ),
    word("about", "[x, y, z], a point that stays where it is"),
    word("at", "a location, as position has it (`loftsman plugins position`)"),
    word("at_least", "no less than this; `loftsman plugins wishes`"),
    word("at_most", "no more than this; `loftsman plugins wishes`"),
    word("axis", "[x, y, z], a direction that is turned about; elsewhere what the field says"),
    word("by", "so much more; `loftsman plugins wishes`"),
    word("caption", "text below a part of a picture"),
    word(
        "closest",
        "[x, y, z], a point in the object's coordinates: what is meant is the place of the shape that is nearest to it; reports say which parameters these are",
    ),
    word("count", "a whole number from 1 on, or from 0 where none makes sense"),
    word("degree", "a whole number, the degree of the pieces"),
    word("degrees", "a number, an angle: 360 are a full turn"),
    word("direction", "the field of that name beside it"),
    word(
        "edge",
        "\"u0\", \"u1\", \"v0\" or \"v1\": where u or v starts or ends; \"edge 3\" is that of other shapes by its number; of an edge of a mesh the numbers of its two vertices",
    ),
    word("face", "a whole number: faces are counted from 0, as `loftsman info` and reports count them"),
    word("falloff", "so many vertices: what is farther from the places asked moves the less"),
    word("file", "text, a path relative to the recipe"),
    word("force", "[x, y, z], in mass · length / s²"),
    word("format", "text, the name of a format: `loftsman plugins formats`"),
    word("from", "a number, where it starts"),
    word("high", "a number, the upper end"),
    word("i", "a whole number, a vertex counted from 0; of an order how often by u"),
    word("index", "a whole number, a control vertex counted from 0; -1 is the last"),
    word("interval", "a number, the knot interval of an edge: 1 is the usual one"),
    word("j", "a whole number, a vertex counted from 0; of an order how often by v"),
    word("k", "a whole number, a vertex counted from 0"),
    word("keep", "true: its value stays as it is; `loftsman plugins wishes`"),
    word(
        "kind",
        "text, the sort of a table, with the fields of that sort beside it: where they are not listed below, those of a constraint (`loftsman plugins constraints`); of an energy one of its names",
    ),
    word("knots", "a list of numbers that do not fall, where pieces meet"),
    word("length", "a number, in the unit of the scene, which `loftsman info` tells"),
    word(
        "location",
        "a place on a shape: a number, the parameter of a curve, or the share of its length on a polyline; [u, v], the parameters of a surface; { face = 3, uv = [u, v] } on a shape of faces; { vertex = 3 }, at a vertex of a cage; or { closest = [x, y, z] }, what is nearest to that point",
    ),
    word("low", "a number, the lower end"),
    word("mass", "a number, a unit of length of a curve, of area of a surface"),
    word("millimetres", "a number, on paper"),
    word(
        "name",
        "text, what something is called: an object of the scene, or a name of the list that the field says",
    ),
    word("normal", "[x, y, z], across a plane; its length does not matter"),
    word(
        "number",
        "2, 0.5 or 1e-3; where it is a distance, in the unit of the scene, which `loftsman info` tells; where it is a parameter, the shape's own",
    ),
    word("object", "text, the name of an object of the scene"),
    word("option", "text, an option of a format: `loftsman plugins formats`"),
    word("pick", "a length: a place that near to an end of the curve is the end"),
    word("point", "[x, y, z], a place"),
    word("points", "a list of tables, places with what is asked there"),
    word("profile", "\"arc-length\" or \"parameter\": a chart of curvature by that"),
    word("scale", "a number, so many times; `loftsman plugins wishes` where it is one"),
    word("sharpness", "a number: 0 is smooth, 10 or more stays sharp for ever"),
    word(
        "step",
        "a table [[step]] with `op`, the name of an operation, and the fields of that: `loftsman plugins operations`",
    ),
    word("stiffness", "a number, the force for a distance of 1"),
    word("still", "true or false: whether it stands still"),
    word("text", "letters in quotes, as \"body\""),
    word("to", "what it becomes or where it goes: a number, or [x, y, z]"),
    word("u", "a number, the first parameter of a surface"),
    word(
        "unit",
        "text: \"nm\", \"um\", \"mm\", \"cm\", \"dm\", \"m\", \"km\", \"mil\", \"in\", \"ft\", \"us-ft\", \"yd\", \"mi\", any number of metres (\"0.3 m\"), or \"unknown\"",
    ),
    word("uv", "[u, v], the parameters of a face"),
    word("v", "a number, the second parameter of a surface"),
    word("value", "a number; of an option what the option takes"),
    word("values", "a list of numbers, one a control vertex"),
    word("vector", "[x, y, z], a direction with a length"),
    word("vertex", "a whole number, a vertex counted from 0; of a control net -1 is the last"),
    word("vertices", "a whole number, so many control vertices"),
    word("weight", "a number above 0, how much it counts"),
    word("weights", "a list of numbers above 0, how much each counts"),
    word("whole number", "1, 2, 3, …; where vertices are counted from 0 also 0, and -1 for the last"),
];

/// The words of documents, where they mean something else or are not in recipes.
pub(crate) const DOCUMENT_WORDS: &[Word] = &[
    word("along", "[x, y, z], the vector of an extrusion"),
    word("alpha", "a number from 0, see-through, to 1"),
    word("alpha_cutoff", "a number: opaque from that alpha on, not there below"),
    word("angle", "half the angle of a cone, in radians"),
    word("at", "[x, y, z], where a vertex is"),
    word("base64", "text, the bytes of the picture in base 64"),
    word("base_color", "[red, green, blue, alpha], linear"),
    word("blend", "true where it is see-through"),
    word("blue", "a number from 0 to 1"),
    word("closed", "true or false: whether the last point is joined to the first [default: false]"),
    word("color", "[red, green, blue, alpha], linear"),
    word("colors", "a layer, see normals: [red, green, blue, alpha], linear"),
    word("curve", "{ degree, knots, points, … }; in a parameter plane its points are [u, v, 0]"),
    word("curves", "special curves of a trimmed surface, each a list of pieces { curve, from, to }"),
    word("definition", "text, the name of a definition"),
    word("degree", "a whole number from 1 on"),
    word("double_sided", "true or false: whether both sides of faces are seen"),
    word("edge", "a whole number, an edge of the list counted from 0"),
    word("edges", "a list of tables, see edge in the text of the field"),
    word("emissive", "[red, green, blue], linear: the light that it gives"),
    word("face", "a whole number, a face of the list counted from 0"),
    word(
        "faces",
        "a list of lists of vertices, counted from 0; of a brep a list of tables; of a group whole numbers that rise",
    ),
    word("file", "text, a path relative to the document"),
    word("first", "{ object, curve, from, to }: one side"),
    word("focal", "the focal length of a parabola"),
    word(
        "form",
        "what a curve or surface is beside a spline: kind is \"line\", \"circle\", \"ellipse\", \"plane\", \"cylinder\", \"cone\", \"sphere\", \"torus\", \"parabola\", \"hyperbola\", \"extrusion\" or \"revolution\"",
    ),
    word("format", "text, the name of a format"),
    word("frames", "a list of frames, each a list of all points"),
    word("from", "a number, the parameter of the curve where a piece starts"),
    word("green", "a number from 0 to 1"),
    word("groups", "a list of { name, faces }"),
    word("kind", "text, the sort of a form or of a shape"),
    word(
        "knots",
        "numbers that do not fall: points + degree + 1 of an open shape, points + 1 over one period of a periodic one",
    ),
    word("line", "text, one line"),
    word("lines", "a list of chains of points, counted from 0"),
    word(
        "loops",
        "a list of loops, each a list of tables; of a region the curves are pieces { curve, from, to }",
    ),
    word("major", "a number, the large radius of a torus"),
    word(
        "materials",
        "a list of whole numbers, for each face an entry of the object's materials, counted from 0",
    ),
    word("media_type", "text, \"image/png\" and the like"),
    word("metallic", "a number from 0 to 1"),
    word("minor", "a number, the small radius of a torus"),
    word("more_uvs", "a list of layers like uvs"),
    word("name", "text, unlike others of its list"),
    word(
        "normals",
        "a layer of [x, y, z]: one a point, or { values, corners }: for each corner of each face the index of its value, -1 for none",
    ),
    word("object", "text, the name of an object; in the list of objects one table"),
    word("objects", "a list of objects as below"),
    word("origin", "[x, y, z], where it is"),
    word("outer", "a whole number, the shell around a solid"),
    word("parameters", "{ curve, from, to }: the edge in the parameter plane of the face"),
    word("parent", "text, the name of the layer or object above"),
    word("periodic", "true or false: closed without ends [default: false]"),
    word(
        "points",
        "a list of [x, y, z], of a surface rows of them along u; of a trimmed surface pairs [u, v]; of a face of a brep vertices alone in it",
    ),
    word("profile", "the form of the curve that is extruded or turned"),
    word("radii", "[major, minor] of an ellipse, the half diameters of a hyperbola"),
    word("radius", "a number"),
    word("rate", "a number, frames a second"),
    word("red", "a number from 0 to 1"),
    word("regions", "a list of { outer, holes }, loops of pieces { curve, from, to } in the parameter plane"),
    word("reversed", "true where it runs, or looks, the other way"),
    word("roughness", "a number from 0 to 1"),
    word("second", "{ object, curve, from, to }: the other side"),
    word("shells", "a list of lists of faces"),
    word("smoothing", "a list of whole numbers, for each face its smoothing group, 0 for flat"),
    word("solids", "a list of { name, outer, voids }"),
    word("statements", "{ format = [line, …] }: what a format keeps for itself"),
    word("surface", "{ u, v, points, weights }"),
    word("tangents", "a layer, see normals: [x, y, z, sign]"),
    word("text", "letters in quotes"),
    word(
        "textures",
        "a list of tables: a channel (\"base_color\", \"metallic_roughness\", \"normal\", \"occlusion\", \"emissive\") or other, the image, and set, strength, offset, tiling, rotation, wrap, magnify, minify where they differ from the usual",
    ),
    word("to", "a number, the parameter of the curve where a piece ends"),
    word("tolerance", "a number, how far what meets there may be apart [default: 0]"),
    word("u", "{ degree, periodic, knots } along the rows"),
    word("uvs", "a layer, see normals: [u, v]"),
    word("v", "{ degree, periodic, knots } across the rows"),
    word("vertices", "a list of { at, tolerance }; of an edge the two at its ends, counted from 0"),
    word("visible", "true or false"),
    word("voids", "a list of whole numbers, shells inside a solid"),
    word("weights", "numbers above 0, one a point [default: not rational]"),
    word("x", "[x, y, z] of length 1, across z"),
    word("z", "[x, y, z] of length 1, the axis"),
];

/// The bare words of what a field takes: what stands in quotes, and between the ends of a range, is left out.
fn bare(takes: &str) -> Vec<&str> {
    let outside = takes.split('"').step_by(2);
    let words = outside.flat_map(|part| part.split(|c: char| !(c.is_alphanumeric() || c == '_')));
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    let is_number =
        |at: usize| words.get(at).is_some_and(|word| word.starts_with(|c: char| c.is_ascii_digit()));
    let in_range = |at: usize| words[at] == "to" && at > 0 && is_number(at - 1) && is_number(at + 1);
    (0..words.len()).filter(|&at| !is_number(at) && !in_range(at)).map(|at| words[at]).collect()
}

/// What a field takes without the phrases of a list, and where these are in it.
fn without_phrases(list: &[Word], takes: &str) -> (String, Vec<usize>) {
    let phrases = list.iter().zip(0..).filter(|(word, _)| word.word.contains(' '));
    let found: Vec<(&Word, usize)> = phrases.filter(|(word, _)| takes.contains(word.word)).collect();
    let rest = found.iter().fold(takes.to_owned(), |rest, (word, _)| rest.replace(word.word, ""));
    (rest, found.into_iter().map(|(_, at)| at).collect())
}

/// Where a word is in a list, `numbers` as `number`.
fn place(list: &[Word], used: &str) -> Option<usize> {
    let exactly = |wanted: &str| list.iter().position(|word| word.word == wanted);
    exactly(used).or_else(|| exactly(used.strip_suffix('s')?))
}

/// The words of a list that fields use which take this, in the order of the list.
pub(crate) fn used<'a>(list: &[Word], takes: impl Iterator<Item = &'a str>) -> Vec<Word> {
    let mut found = std::collections::BTreeSet::new();
    for takes in takes {
        let (rest, phrases) = without_phrases(list, takes);
        found.extend(phrases);
        found.extend(bare(&rest).into_iter().filter_map(|word| place(list, word)));
    }
    found.into_iter().map(|at| list[at]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::registry;
    use crate::{document, picture, recipe};
    use loftsman_kernel::plugin::Field;

    /// What only joins words.
    const GRAMMAR: [&str; 29] = [
        "or",
        "and",
        "list",
        "of",
        "these",
        "each",
        "with",
        "also",
        "on",
        "as",
        "many",
        "the",
        "has",
        "same",
        "an",
        "rows",
        "surface",
        "faces",
        "interpolating",
        "percent",
        "s",
        "true",
        "false",
        "seconds",
        "a",
        "in",
        "loop",
        "vertex",
        "solid",
    ];

    /// Every word that a field takes is explained: by the list, by a field of the same listing, or by the listing that its help names.
    #[test]
    fn every_word_that_a_field_takes_is_explained() {
        let registry = registry();
        let mut listings: Vec<(String, Vec<Field>)> = Vec::new();
        for operation in registry.operations() {
            let mut fields = operation.declaration().fields.to_vec();
            for table in operation.tables() {
                fields.extend(table.fields);
                fields.extend(table.kinds.iter().flat_map(|kind| kind.fields));
            }
            listings.push((operation.declaration().name.to_owned(), fields));
        }
        let declared =
            registry.functionals().chain(registry.shape_kinds().iter().map(|kind| kind.declaration()));
        listings.extend(declared.map(|one| (one.name.to_owned(), one.fields.to_vec())));
        listings.extend(
            registry
                .formats()
                .iter()
                .map(|f| (f.declaration().name.to_owned(), f.declaration().options.to_vec())),
        );
        listings.push(("wishes".into(), recipe::WISHES.to_vec()));
        listings.push(("recipe".into(), recipe::FIELDS.to_vec()));
        listings.push(("picture".into(), picture::FIELDS.to_vec()));
        listings.push(("document".into(), document::FIELDS.to_vec()));
        let mut unexplained = Vec::new();
        let mut seen = 0;
        for (name, fields) in &listings {
            let list = if name == "document" { DOCUMENT_WORDS } else { WORDS };
            for field in fields {
                for word in bare(&without_phrases(list, field.takes).0) {
                    seen += 1;
                    let beside = fields.iter().any(|field| field.name == word);
                    let named = listings.iter().any(|(listing, fields)| {
                        field.help.contains(&format!("`loftsman plugins {listing}`"))
                            && fields.iter().any(|field| field.name == word)
                    });
                    if place(list, word).is_none() && !GRAMMAR.contains(&word) && !beside && !named {
                        unexplained.push(format!("{name}.{}: {word}", field.name));
                    }
                }
            }
        }
        assert!(seen > 500, "{seen}");
        assert!(unexplained.is_empty(), "{unexplained:#?}");
    }

    #[test]
    fn words_are_listed_once_and_found_where_they_are_used() {
        for list in [WORDS, DOCUMENT_WORDS] {
            assert!(list.is_sorted_by(|a, b| a.word < b.word), "in their order, each once");
        }
        let words =
            |takes: &str| -> Vec<&str> { used(WORDS, [takes].into_iter()).iter().map(|w| w.word).collect() };
        assert_eq!(words("[numbers] | \"length\""), ["number"]);
        assert_eq!(words("whole number, or [i, j] on a surface"), ["i", "j", "whole number"]);
        assert_eq!(words("[[x, y, z], …]"), ["[x, y, z]"]);
        assert!(words("1 to 25").is_empty());
        assert_eq!(words("degrees, 0 to 30"), ["degrees"]);
    }
}
