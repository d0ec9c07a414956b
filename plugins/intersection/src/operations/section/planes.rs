//! The planes of a step `section`.

use loftsman_kernel::plugin::{Field, OperationError, Parameters};
use loftsman_kernel::{Point, Vector};

use crate::Plane;

/// The most planes of a step.
const MOST: usize = 10_000;

pub(super) const PLANE: &[Field] = &[
    Field::optional("point", "[x, y, z]", "[0, 0, 0]", "a point of the plane"),
    Field::required("normal", "[x, y, z]", "the plane's normal, of any length"),
];

/// The planes of a step. `ends` are the corners of the box round what is cut, asked for where planes are counted.
pub(super) fn planes(
    parameters: &Parameters,
    ends: impl FnOnce() -> Result<(Point, Point), OperationError>,
) -> Result<Vec<Plane>, OperationError> {
    // Each field is read for itself first, so that what is wrong with one is said of it.
    let plane = if parameters.has("plane") { Some(read_plane(parameters)?) } else { None };
    let axes = [("x", 0), ("y", 1), ("z", 2)];
    if parameters.value("axis").is_some_and(serde_json::Value::is_array) {
        let problem = "an axis is \"x\", \"y\" or \"z\": across any other direction it is plane = { point = [x, y, z], normal = [x, y, z] }";
        return Err(parameters.error("axis", problem).into());
    }
    let axis = if parameters.has("axis") { Some(parameters.choice("axis", &axes)?) } else { None };
    let at = match parameters.value("at") {
        Some(value) if value.is_array() => Some(parameters.numbers("at")?),
        Some(_) => Some(vec![parameters.number("at")?]),
        None => None,
    };
    let count = if parameters.has("count") { Some(parameters.count("count")?) } else { None };
    let axis = match (plane, axis) {
        (Some(plane), None) if at.is_none() && count.is_none() => return Ok(vec![plane]),
        (None, Some(axis)) => axis,
        _ => {
            let problem = "give either plane = { point, normal } alone, or axis with at or count";
            return Err(parameters.error("", problem).into());
        }
    };
    let mut normal = Vector::zeros();
    normal[axis] = 1.0;
    let places = match (at, count) {
        (Some(_), Some(_)) | (None, None) => {
            return Err(parameters.error("", "axis goes with one of at and count").into());
        }
        (Some(places), None) => places,
        (None, Some(count)) => {
            if count == 0 || count > MOST {
                return Err(parameters.error("count", format!("{count} where 1 to {MOST} is needed")).into());
            }
            let (low, high) = ends()?;
            let step = (high[axis] - low[axis]) / (count + 1) as f64;
            (1..=count).map(|k| low[axis] + step * k as f64).collect()
        }
    };
    if places.is_empty() || places.len() > MOST {
        return Err(parameters
            .error(
                "at",
                match places.len() {
                    0 => format!("no place is named: 1 to {MOST} are needed"),
                    many => format!("{many} places are named: {MOST} are the most"),
                },
            )
            .into());
    }
    let plane = |at: f64| Plane::new(Point::from(normal * at), normal).map_err(OperationError::from);
    places.into_iter().map(plane).collect()
}

fn read_plane(parameters: &Parameters) -> Result<Plane, OperationError> {
    let table = parameters.table("plane")?;
    table.check(PLANE)?;
    let point = if table.has("point") { table.point("point")? } else { Point::origin() };
    Plane::new(point, table.vector("normal")?).map_err(|e| table.error("normal", e.to_string()).into())
}
