//! What a document, `*.loft.json`, holds: for help. The manual's chapter on files says it at length.

use loftsman_kernel::plugin::Field;

/// The fields of a document, those of its tables behind the table's name.
pub const FIELDS: &[Field] = &[
    Field::required("loftsman", "1", "the version of the format"),
    Field::optional("unit", "\"mm\" | \"m\" | \"in\" | … | \"unknown\"", "\"m\"", "of all lengths"),
    Field::optional("up", "\"x\" | \"y\" | \"z\"", "\"z\"", "the axis that points up"),
    Field::required("objects", "[object, …]", "what is shown"),
    Field::optional("definitions", "[{ name, objects, statements }, …]", "[]", "objects that instances show"),
    Field::optional(
        "layers",
        "[{ name, color, visible, parent }, …]",
        "[]",
        "layers of which there is more to say",
    ),
    Field::optional(
        "materials",
        "[{ name, base_color, metallic, roughness, emissive, alpha_cutoff, blend, double_sided, textures, statements }, …]",
        "[]",
        "what faces are made of",
    ),
    Field::optional("images", "[{ name, file, media_type, base64 }, …]", "[]", "pictures of textures"),
    Field::optional(
        "connections",
        "[{ first, second }, …], each { object, curve, from, to }",
        "[]",
        "edges of trimmed surfaces that are common",
    ),
    Field::optional(
        "statements",
        "{ format = [line, …] }",
        "none",
        "what a file said that nobody else understands",
    ),
    Field::required("objects[].name", "text", "unlike all others"),
    Field::optional("objects[].label", "text", "the name", "what it is called where names may be equal"),
    Field::optional("objects[].color", "[red, green, blue, alpha]", "none", "linear, from 0 to 1"),
    Field::optional("objects[].layer", "text", "none", "the layer it is on"),
    Field::optional("objects[].parent", "text", "none", "the object it hangs under"),
    Field::optional(
        "objects[].transform",
        "[[…; 4]; 4]",
        "none",
        "rows of a matrix, from its coordinates to its parent's",
    ),
    Field::optional(
        "objects[].animation",
        "{ rate, frames }",
        "none",
        "its points in each of so many frames a second",
    ),
    Field::optional(
        "objects[].curve",
        "{ degree, periodic, knots, points, weights, form }, a form { kind, origin, x, z, radius, radii, focal, from, to }",
        "one shape is needed",
        "open: points + degree + 1 knots; periodic: points + 1 knots over one period",
    ),
    Field::optional(
        "objects[].surface",
        "{ u, v, points, weights, form }, u and v each { degree, periodic, knots }, a form { kind, origin, x, z, radius, angle, major, minor, u, v }",
        "one shape is needed",
        "rows of points along u, each along v",
    ),
    Field::optional(
        "objects[].trimmed",
        "{ surface, regions, curves, points }",
        "one shape is needed",
        "a part of a surface",
    ),
    Field::optional(
        "objects[].brep",
        "{ vertices, edges, faces, shells, solids }; a vertex { at, tolerance }, an edge { curve, from, to, vertices, tolerance, form }, a face { name, color, surface, form, reversed, loops, points }, in a loop { edge, reversed, parameters }, a solid { name, outer, voids }, a form { kind, origin, x, z, radius, radii, angle, major, minor, focal, along, profile }",
        "one shape is needed",
        "faces that share edges",
    ),
    Field::optional(
        "objects[].mesh",
        "{ points, faces, lines, normals, tangents, uvs, more_uvs, colors, materials, smoothing, groups }",
        "one shape is needed",
        "faces of three or more corners",
    ),
    Field::optional("objects[].polyline", "{ points, closed }", "one shape is needed", "segments"),
    Field::optional("objects[].cloud", "{ points }", "one shape is needed", "loose points"),
    Field::optional(
        "objects[].group",
        "{}",
        "one shape is needed",
        "nothing of its own; others hang under it",
    ),
    Field::optional("objects[].instance", "{ definition }", "one shape is needed", "shows a definition"),
    Field::optional(
        "objects[].shape",
        "{ kind, … }",
        "one shape is needed",
        "a plug-in's kind; `loftsman plugins shapes` lists them",
    ),
    Field::optional(
        "objects[].same_as",
        "{ object, definition }",
        "one shape is needed",
        "the shape of an object before it",
    ),
    Field::optional("objects[].materials", "[name, …]", "none", "of its faces"),
    Field::optional(
        "objects[].statements",
        "{ format = [line, …] }",
        "none",
        "what a file said that nobody else understands",
    ),
];
