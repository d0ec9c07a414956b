//! What our reader wants and glTF has no place for: the exact spline or plug-in's shape, the exact transform, and the unit and
//! axes of both, the layer, and that there were lines or points; and of the whole, the unit, the up axis and the layers.
//!
//! It stands in `extras.loftsman` of a node, as a text of JSON (because Blender cannot take lists of lists as custom
//! properties), and is taken only where it still belongs to the node: the spline where the node's mesh has the vertices
//! that were written with it, or no mesh at all, the transform where it agrees with the node's. Programs that pass nodes on drop
//! what stands beside them, so that each node says its unit and axes itself.

use loftsman_kernel::Point;
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::named::NamedList;
use loftsman_kernel::plugin::{CustomShape, Parameters, ReadOptions};
use loftsman_kernel::scene::{Animation, Geometry, Layer, Unit, Up, check_layers};
use loftsman_kernel::spline::trimmed::{ParameterCurve, Region};
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};
use nalgebra::Matrix4;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The fields of `extras.loftsman`; names and meanings are those of the native document.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct ExtrasFields {
    /// The unit of the spline, its frames and the transform; as for the whole file where it is not said, as in files written before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) unit: Option<Unit>,
    /// Their axis up, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) up: Option<Up>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) curve: Option<CurveFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) surface: Option<SurfaceFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) trimmed: Option<TrimmedFields>,
    /// A plug-in's shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) shape: Option<ShapeFields>,
    /// The fingerprint of the vertices that show the spline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) shown_by: Option<String>,
    /// That the node's mesh has no triangles, and is `"lines"` or `"points"`: Blender leaves such out unless it is told otherwise, and the node is
    /// all that comes back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) loose: Option<Loose>,
    /// Frames of the spline, in its unit and axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) animation: Option<AnimationFields>,
    /// Frames a second, where glTF's single precision would change them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) rate: Option<f64>,
    /// The object's transform in the scene's unit and axes, where the node's parts do not give it to the last bit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) transform: Option<[[f64; 4]; 4]>,
    /// From the object's coordinates to those of the node, in the file's unit and axes, where they differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) place: Option<[[f64; 4]; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) layer: Option<String>,
    /// Whether its colour is that of its layer.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) by_layer: bool,
    /// Whether the weights of the mesh show its first frame, and its points are the shape itself.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) starts_at_first: bool,
    /// Whether the mesh got its tangents when it was written, because its material has a normal map.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) made_tangents: bool,
    /// The colour of what has no mesh, whose material would show it, or has another material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) color: Option<[f64; 4]>,
}

/// What a mesh without triangles is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Loose {
    Lines,
    Points,
}

/// A layer in `asset.extras.loftsman`; fields as in the native document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LayerFields {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    color: Option<[f64; 4]>,
    #[serde(default = "seen", skip_serializing_if = "is_seen")]
    visible: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    parent: Option<String>,
}

fn is_seen(visible: &bool) -> bool {
    *visible
}

fn seen() -> bool {
    true
}

impl LayerFields {
    /// The layers of a scene. A colour that is not finite, which no JSON has, is none.
    pub(crate) fn of(layers: &NamedList<Layer>) -> Vec<Self> {
        let fields = |layer: &Layer| Self {
            name: layer.name().to_owned(),
            color: layer.color.filter(|color| color.iter().all(|x| x.is_finite())),
            visible: layer.visible,
            parent: layer.parent.clone(),
        };
        layers.iter().map(fields).collect()
    }

    /// The layers that these are.
    pub(crate) fn make(list: Vec<Self>) -> Result<NamedList<Layer>> {
        let mut layers = NamedList::default();
        for Self { name, color, visible, parent } in list {
            let mut layer = Layer::new(name);
            (layer.color, layer.visible, layer.parent) = (color, visible, parent);
            layers.add(layer)?;
        }
        check_layers(&layers)?;
        Ok(layers)
    }
}

/// Rows of a matrix.
pub(crate) fn rows(matrix: &Matrix4<f64>) -> [[f64; 4]; 4] {
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| matrix[(i, j)]))
}

/// The matrix of rows; `None` where it is not affine or finite.
pub(crate) fn matrix(rows: &[[f64; 4]; 4]) -> Option<Matrix4<f64>> {
    let affine = rows[3] == [0.0, 0.0, 0.0, 1.0] && rows.iter().flatten().all(|x| x.is_finite());
    affine.then(|| Matrix4::from_fn(|i, j| rows[i][j]))
}

impl ExtrasFields {
    /// The fields of a spline or of a plug-in's shape; of other geometry none.
    pub(crate) fn of(geometry: &Geometry) -> Self {
        let mut own = Self::default();
        match geometry {
            Geometry::Curve(curve) => own.curve = Some(CurveFields::of(curve)),
            Geometry::Surface(surface) => own.surface = Some(SurfaceFields::of(surface)),
            Geometry::Trimmed(trimmed) => own.trimmed = Some(TrimmedFields::of(trimmed)),
            Geometry::Custom(custom) => own.shape = ShapeFields::of(custom),
            _ => {}
        }
        own
    }

    /// Whether there is a spline or a plug-in's shape.
    pub(crate) fn is_exact(&self) -> bool {
        self.curve.is_some() || self.surface.is_some() || self.trimmed.is_some() || self.shape.is_some()
    }

    /// The spline or the plug-in's shape, if there is one; shapes of kinds that the options do not know are errors.
    pub(crate) fn exact(&self, options: &ReadOptions<'_>) -> Option<Result<Geometry>> {
        if let Some(shape) = &self.shape {
            return Some(shape.make(options).map(Geometry::Custom));
        }
        if let Some(curve) = &self.curve {
            return Some(curve.make().map(Geometry::Curve));
        }
        if let Some(surface) = &self.surface {
            return Some(surface.make().map(Geometry::Surface));
        }
        self.trimmed.as_ref().map(|trimmed| trimmed.make().map(Geometry::Trimmed))
    }
}

/// A plug-in's shape: its kind, and the fields that this writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ShapeFields {
    kind: String,
    fields: Map<String, Value>,
}

impl ShapeFields {
    /// `None` where its plug-in is not here.
    fn of(custom: &CustomShape) -> Option<Self> {
        let fields = custom.fields().ok()?.into_map();
        Some(Self { kind: custom.kind().to_owned(), fields })
    }

    fn make(&self, options: &ReadOptions<'_>) -> Result<CustomShape> {
        let Some(kind) = options.kind(&self.kind) else {
            return Err(Error::UnknownKind { kind: self.kind.clone() });
        };
        Parameters::new(Value::Object(self.fields.clone()), "shape.fields")
            .and_then(|fields| CustomShape::read(kind, &fields))
            .map_err(|error| Error::Invalid(error.to_string()))
    }
}

/// A direction of a spline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SpaceFields {
    degree: usize,
    #[serde(default)]
    periodic: bool,
    knots: Vec<f64>,
}

impl SpaceFields {
    fn of(space: &Space) -> Self {
        Self { degree: space.degree(), periodic: space.is_periodic(), knots: space.knots().to_vec() }
    }

    fn make(&self) -> Result<Space> {
        if self.periodic {
            Space::periodic(self.degree, self.knots.clone())
        } else {
            Space::open(self.degree, self.knots.clone())
        }
    }
}

/// A curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct CurveFields {
    degree: usize,
    #[serde(default)]
    periodic: bool,
    knots: Vec<f64>,
    points: Vec<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<f64>>,
}

impl CurveFields {
    fn of(curve: &Curve) -> Self {
        let SpaceFields { degree, periodic, knots } = SpaceFields::of(curve.space());
        let points = curve.points().iter().map(|p| (*p).into()).collect();
        Self { degree, periodic, knots, points, weights: curve.weights().map(<[f64]>::to_vec) }
    }

    fn make(&self) -> Result<Curve> {
        let space = SpaceFields { degree: self.degree, periodic: self.periodic, knots: self.knots.clone() };
        let points = self.points.iter().map(|&p| Point::from(p)).collect();
        Curve::build(space.make()?, points, self.weights.clone())
    }
}

/// A surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SurfaceFields {
    u: SpaceFields,
    v: SpaceFields,
    points: Vec<Vec<[f64; 3]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<Vec<f64>>>,
}

impl SurfaceFields {
    fn of(surface: &Surface) -> Self {
        let columns = surface.v().len().max(1);
        let rows = |row: &[Point]| row.iter().map(|p| (*p).into()).collect();
        Self {
            u: SpaceFields::of(surface.u()),
            v: SpaceFields::of(surface.v()),
            points: surface.points().chunks(columns).map(rows).collect(),
            weights: surface.weights().map(|w| w.chunks(columns).map(<[f64]>::to_vec).collect()),
        }
    }

    fn make(&self) -> Result<Surface> {
        let columns = self.points.first().map_or(0, Vec::len);
        let even = self.points.iter().all(|row| row.len() == columns);
        let weights = self.weights.iter().flatten().all(|row| row.len() == columns);
        if !even || !weights {
            return Err(Error::Invalid(
                "the rows of a surface's points or weights are not equally long".into(),
            ));
        }
        let points = self.points.iter().flatten().map(|&p| Point::from(p)).collect();
        let weights = self.weights.as_ref().map(|rows| rows.concat());
        Surface::build(self.u.make()?, self.v.make()?, points, weights)
    }
}

/// A trimmed surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TrimmedFields {
    surface: SurfaceFields,
    regions: Vec<RegionFields>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    curves: Vec<Vec<PieceFields>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    points: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct RegionFields {
    outer: Vec<PieceFields>,
    holes: Vec<Vec<PieceFields>>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PieceFields {
    curve: CurveFields,
    from: f64,
    to: f64,
}

impl TrimmedFields {
    fn of(trimmed: &Trimmed) -> Self {
        let chain = |chain: &Vec<ParameterCurve>| -> Vec<PieceFields> {
            let piece = |p: &ParameterCurve| {
                let (from, to) = p.range();
                PieceFields { curve: CurveFields::of(p.curve()), from, to }
            };
            chain.iter().map(piece).collect()
        };
        let region =
            |r: &Region| RegionFields { outer: chain(&r.outer), holes: r.holes.iter().map(chain).collect() };
        Self {
            surface: SurfaceFields::of(trimmed.surface()),
            regions: trimmed.regions().iter().map(region).collect(),
            curves: trimmed.curves().iter().map(chain).collect(),
            points: trimmed.points().to_vec(),
        }
    }

    fn make(&self) -> Result<Trimmed> {
        let chain = |chain: &Vec<PieceFields>| -> Result<Vec<ParameterCurve>> {
            chain.iter().map(|p| ParameterCurve::new(p.curve.make()?, p.from, p.to)).collect()
        };
        let region = |r: &RegionFields| -> Result<Region> {
            Ok(Region { outer: chain(&r.outer)?, holes: r.holes.iter().map(chain).collect::<Result<_>>()? })
        };
        Trimmed::new(
            self.surface.make()?,
            self.regions.iter().map(region).collect::<Result<_>>()?,
            self.curves.iter().map(chain).collect::<Result<_>>()?,
            self.points.clone(),
        )
    }
}

/// Frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct AnimationFields {
    rate: f64,
    frames: Vec<Vec<[f64; 3]>>,
}

impl AnimationFields {
    pub(crate) fn of(animation: &Animation) -> Self {
        let frame = |frame: &Vec<Point>| frame.iter().map(|p| (*p).into()).collect();
        Self { rate: animation.rate, frames: animation.frames.iter().map(frame).collect() }
    }

    /// The frames of a shape of so many points; `None` where they do not fit.
    pub(crate) fn make(&self, points: usize) -> Option<Animation> {
        let fits = self.rate.is_finite()
            && self.rate > 0.0
            && self.frames.iter().all(|f| f.len() == points && f.iter().flatten().all(|x| x.is_finite()));
        let frame = |frame: &Vec<[f64; 3]>| frame.iter().map(|&p| Point::from(p)).collect();
        fits.then(|| Animation { rate: self.rate, frames: self.frames.iter().map(frame).collect() })
    }
}

/// A fingerprint of a set of single-precision positions, whatever their order and however often each is there: programs
/// that pass meshes on reorder and double vertices. (The hash is FNV-1a of 64 bits, by Fowler, Noll and Vo.)
pub(crate) fn fingerprint(positions: impl Iterator<Item = [f32; 3]>) -> String {
    // Adding 0 makes minus zero zero.
    let mut all: Vec<[u32; 3]> = positions.map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
    all.sort_unstable();
    all.dedup();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in all.iter().flatten().flat_map(|bits| bits.to_le_bytes()) {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingerprints_see_sets_and_nothing_else() {
        let set = |points: &[[f32; 3]]| fingerprint(points.iter().copied());
        let (a, b) = ([0.0, 1.0, -2.5], [1e-9, 0.0, 3.0]);
        assert_eq!(set(&[a, b]), set(&[b, a, b]));
        assert_eq!(set(&[a, b]), set(&[[-0.0, 1.0, -2.5], b]));
        assert_ne!(set(&[a, b]), set(&[a]));
        assert_ne!(set(&[a, b]), set(&[a, [1e-9, 0.0, 3.000_000_2]]));
    }
}
