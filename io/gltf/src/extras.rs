//! The exact spline, as a native document has it.

use loftsman_kernel::Point;
use loftsman_kernel::scene::Geometry;
use loftsman_kernel::spline::{Curve, Space, Surface};
use serde_json::{Map, Value, json};

/// `extras` of a node: `{"loftsman": "{\"curve\": …}"}`; `None` for what is not a spline.
pub(crate) fn exact(geometry: &Geometry) -> Option<Value> {
    let document = match geometry {
        Geometry::Curve(curve) => json!({ "curve": curve_value(curve) }),
        Geometry::Surface(surface) => json!({ "surface": surface_value(surface) }),
        _ => return None,
    };
    Some(json!({ "loftsman": document.to_string() }))
}

fn space_fields(space: &Space) -> Map<String, Value> {
    let mut fields = Map::new();
    fields.insert("degree".into(), space.degree().into());
    fields.insert("periodic".into(), space.is_periodic().into());
    fields.insert("knots".into(), space.knots().into());
    fields
}

fn coordinates(points: &[Point]) -> Value {
    points.iter().map(|p| json!([p.x, p.y, p.z])).collect()
}

fn curve_value(curve: &Curve) -> Value {
    let mut fields = space_fields(curve.space());
    fields.insert("points".into(), coordinates(curve.points()));
    if let Some(weights) = curve.weights() {
        fields.insert("weights".into(), weights.into());
    }
    fields.into()
}

fn surface_value(surface: &Surface) -> Value {
    let columns = surface.v().len();
    let mut fields = Map::new();
    fields.insert("u".into(), space_fields(surface.u()).into());
    fields.insert("v".into(), space_fields(surface.v()).into());
    fields.insert("points".into(), surface.points().chunks(columns).map(coordinates).collect());
    if let Some(weights) = surface.weights() {
        fields.insert("weights".into(), weights.chunks(columns).map(Value::from).collect());
    }
    fields.into()
}
