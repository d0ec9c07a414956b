//! What a step changed, in the quantities that people ask of shapes.

/// What a step did to one object: before and after. Lengths, areas and volumes are in the unit of the scene, of the object as it stands there, placed by its transform and
/// those above it; what was not measured, or does not apply, is left out when it is serialised.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct ObjectChange {
    /// The object.
    pub name: String,
    /// Whether it was there before, and is still there.
    pub change: ChangeKind,
    /// Its length before and after; `None` for what there is none of.
    #[serde(skip_serializing_if = "Measured::is_unknown")]
    pub length: Measured,
    /// Its area, or the area inside a closed planar curve.
    #[serde(skip_serializing_if = "Measured::is_unknown")]
    pub area: Measured,
    /// The volume inside.
    #[serde(skip_serializing_if = "Measured::is_unknown")]
    pub volume: Measured,
    /// The largest distance between the new shape and the old one, at places of the new.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// Whether the old shape are points that the new one was fitted to: its deviation is the distance of the furthest of them, and what lies between
    /// them has none.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub of_points: bool,
    /// What was not measured, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unmeasured: Vec<String>,
}

/// How an object came out of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ChangeKind {
    /// It has another shape.
    #[default]
    Changed,
    /// The step made it.
    New,
    /// The step took it out.
    Gone,
}

/// A quantity that a step was asked to change: a number with a unit.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct AskedQuantity {
    /// The constraint's name: `area across [0, 0, 1]`.
    pub name: String,
    /// The power of length that it has: 1 for a length, 2 for an area, 3 for a volume.
    pub dimension: u8,
    /// Its value before and after, in the coordinates in which it was asked.
    #[serde(flatten)]
    pub value: Measured,
}

/// A quantity before and after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Measured {
    /// Before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<f64>,
    /// After.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<f64>,
}

impl Measured {
    /// Whether nothing is known of it.
    pub fn is_unknown(&self) -> bool {
        self.before.is_none() && self.after.is_none()
    }
}
