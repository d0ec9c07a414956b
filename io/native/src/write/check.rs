//! What a document cannot hold is refused before the first byte is written.

use std::collections::HashSet;

use loftsman_kernel::material::{Alpha, Material};
use loftsman_kernel::named::Named;
use loftsman_kernel::plugin::{CustomShape, FormatError};
use loftsman_kernel::scene::{Geometry, Object, Scene};
use loftsman_kernel::{Point, Vector};

/// Checks a whole scene: what is written can be read again.
pub(super) fn scene(scene: &Scene) -> Result<(), FormatError> {
    for material in &scene.materials {
        check_material(material).map_err(|problem| {
            FormatError::whole(format!("the material \"{}\": {problem}", material.name()))
        })?;
    }
    for layer in scene.layers.iter() {
        if let Some(color) = &layer.color {
            finite("its colour", color).map_err(|problem| {
                FormatError::whole(format!("the layer \"{}\": {problem}", layer.name()))
            })?;
        }
    }
    let defined = scene.definitions().iter().flat_map(|definition| definition.objects());
    let mut checked = HashSet::new();
    for object in defined.chain(scene.objects()) {
        let is_new = checked.insert(object.geometry_id());
        check_object(object)
            .and_then(|()| if is_new { check_geometry(object.geometry()) } else { Ok(()) })
            .map_err(|problem| FormatError::whole(problem).of(object.name()))?;
    }
    Ok(())
}

fn check_object(object: &Object) -> Result<(), String> {
    if let Some(color) = &object.color {
        finite("its colour", color)?;
    }
    if let Some(transform) = &object.transform {
        finite("its transform", transform.as_slice())?;
        if [0, 1, 2, 3].map(|j| transform[(3, j)]) != [0.0, 0.0, 0.0, 1.0] {
            return Err("its transform is not affine: the last row must be 0 0 0 1".to_owned());
        }
    }
    let count = object.geometry().points().len();
    if let Some(animation) = &object.animation {
        if !(animation.rate.is_finite() && animation.rate > 0.0) {
            let rate = animation.rate;
            return Err(format!("its animation has {rate} frames a second: the rate must be positive"));
        }
        for (i, frame) in animation.frames.iter().enumerate() {
            if frame.len() != count && !object.geometry().is_unknown() {
                return Err(format!("frame {i} has {} points, the object {count}", frame.len()));
            }
            points(&format!("frame {i}, point"), frame)?;
        }
    }
    Ok(())
}

fn check_geometry(geometry: &Geometry) -> Result<(), String> {
    match geometry {
        Geometry::Group | Geometry::Instance(_) => {}
        Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Trimmed(_) | Geometry::Brep(_) => {}
        Geometry::Polyline(_) | Geometry::Cloud(_) => points("point", geometry.points())?,
        Geometry::Mesh(mesh) => {
            points("point", mesh.points())?;
            each("normal", mesh.normals.values().iter().map(Vector::as_slice))?;
            each("tangent", mesh.tangents.values().iter().map(<[f64; 4]>::as_slice))?;
            for layer in std::iter::once(&mesh.uvs).chain(&mesh.more_uvs) {
                each("texture coordinate", layer.values().iter().map(<[f64; 2]>::as_slice))?;
            }
            each("colour", mesh.colors.values().iter().map(<[f64; 4]>::as_slice))?;
        }
        Geometry::Custom(custom) => check_shape(custom)?,
        other => {
            return Err(format!(
                "a {} cannot be written as a document: delete it or convert it",
                other.kind()
            ));
        }
    }
    Ok(())
}

/// What is written of a plug-in's shape must be read again.
fn check_shape(custom: &CustomShape) -> Result<(), String> {
    points("control vertex", custom.points())?;
    let Ok(fields) = custom.fields() else { return Ok(()) };
    if fields.has("kind") {
        let kind = custom.kind();
        return Err(format!(
            "the kind \"{kind}\" has a field \"kind\", which every shape has: its plug-in must rename it"
        ));
    }
    Ok(())
}

fn points(what: &str, points: &[Point]) -> Result<(), String> {
    each(what, points.iter().map(|p| p.coords.as_slice()))
}

fn each<'a>(what: &str, rows: impl Iterator<Item = &'a [f64]>) -> Result<(), String> {
    for (i, row) in rows.enumerate() {
        if row.iter().any(|x| !x.is_finite()) {
            return Err(not_finite(&format!("{what} {i}"), row));
        }
    }
    Ok(())
}

fn finite(what: &str, numbers: &[f64]) -> Result<(), String> {
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(not_finite(what, numbers)) }
}

fn not_finite(what: &str, numbers: &[f64]) -> String {
    format!("{what} is {numbers:?}: JSON holds finite numbers only")
}

fn check_material(material: &Material) -> Result<(), String> {
    finite("its colour", &material.base_color)?;
    finite("the light it gives off", &material.emissive)?;
    finite("its metalness or roughness", &[material.metallic, material.roughness])?;
    if let Alpha::Mask(cutoff) = material.alpha {
        finite("its least alpha", &[cutoff])?;
    }
    for texture in material.textures.values() {
        finite("the strength or rotation of a texture", &[texture.strength, texture.rotation])?;
        finite("the offset of a texture", &texture.offset)?;
        finite("the tiling of a texture", &texture.tiling)?;
    }
    Ok(())
}
