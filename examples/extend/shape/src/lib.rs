//! A shape of one's own, neither curve nor surface: a Coons patch, which four cubic edges bound and nothing inside.

use loftsman_kernel::Point;
use loftsman_kernel::error::Result;
use loftsman_kernel::plugin::{
    Declaration, DeclaredShape, Field, ParameterError, Parameters, Plugin, Registry, Splines,
};
use loftsman_kernel::shape::{
    BoundaryEdge, Cell, CellSide, Cells, Derivative, Domain, Edges, Interval, Location, Shape, Stencil,
};
use loftsman_kernel::spline::{Curve, Surface};

/// The bilinearly blended patch between four cubic Bézier edges (Coons 1967). Its 12 control vertices go once around:
/// from the corner `(0, 0)` along `u` to `(1, 0)`, on to `(1, 1)` and `(0, 1)`, and back.
#[derive(Debug, Clone)]
pub struct Coons(pub [Point; 12]);

/// Where vertex `k` stands in a net of 4 × 4, of which the patch has the rim.
const RIM: [[usize; 2]; 12] =
    [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [3, 3], [2, 3], [1, 3], [0, 3], [0, 2], [0, 1]];

impl Coons {
    /// What vertex `(i, j)` of the net of the bicubic patch that it is owes to the rim: blending is linear, and so is
    /// the net of a linear function.
    fn net([i, j]: [usize; 2]) -> impl Iterator<Item = (usize, f64)> {
        let (s, t) = (i as f64 / 3.0, j as f64 / 3.0);
        RIM.into_iter().enumerate().map(move |(k, [a, b])| {
            let (at_a, at_b) = (f64::from(u8::from(a == i)), f64::from(u8::from(b == j)));
            let (to_a, to_b) = ([1.0 - s, 0.0, 0.0, s][a], [1.0 - t, 0.0, 0.0, t][b]);
            (k, at_a * to_b + at_b * to_a - to_a * to_b)
        })
    }
}

impl Shape for Coons {
    fn control_vertices(&self) -> &[Point] {
        &self.0
    }

    fn control_vertices_mut(&mut self) -> &mut [Point] {
        &mut self.0
    }

    fn stencil(&self, at: Location, derivative: Derivative) -> Result<Stencil> {
        let (u, v) = at.on_surface()?;
        let cubic = Curve::bezier(vec![Point::origin(); 4])?;
        let (along_u, along_v) =
            (cubic.stencil(u.into(), derivative.u.into())?, cubic.stencil(v.into(), derivative.v.into())?);
        let net = along_u.iter().flat_map(|(i, a)| along_v.iter().map(move |(j, b)| ([i, j], a * b)));
        Ok(net.flat_map(|(place, c)| Self::net(place).map(move |(k, part)| (k, c * part))).collect())
    }

    fn domain(&self) -> Domain {
        [Interval { start: 0.0, end: 1.0, periodic: false }; 2].into_iter().collect()
    }

    fn boxed(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn cells(&self) -> Option<&dyn Cells> {
        Some(self)
    }

    fn edges(&self) -> Option<&dyn Edges> {
        Some(self)
    }
}

/// One polynomial: with that it is faired, and has an area and a volume.
impl Cells for Coons {
    fn count(&self) -> usize {
        1
    }

    fn cell(&self, index: usize) -> Option<Cell> {
        let sides = [CellSide { start: 0.0, end: 1.0, degree: 3 }; 2].into_iter().collect();
        (index == 0).then(|| Cell { face: None, sides, rational: false, vertices: (0..12).collect() })
    }
}

/// Four edges: with these it is joined to others.
impl Edges for Coons {
    fn count(&self) -> usize {
        4
    }

    fn edge(&self, index: usize) -> Option<BoundaryEdge> {
        let (name, at_end) = (*["u0", "u1", "v0", "v1"].get(index)?, index % 2 == 1);
        let (along_u, fixed, name) = (index > 1, f64::from(u8::from(at_end)), name.into());
        Some(BoundaryEdge { name, face: None, along_u, start: 0.0, end: 1.0, periodic: false, fixed, at_end })
    }
}

impl DeclaredShape for Coons {
    const DECLARATION: Declaration = Declaration {
        name: "coons",
        help: "the patch between four cubic edges",
        fields: &[Field::required("points", "[[x, y, z], …]", "12 control vertices, once around")],
    };

    fn fields(&self) -> Parameters {
        Parameters::empty("").with_points("points", &self.0)
    }

    fn from_parameters(fields: &Parameters) -> std::result::Result<Self, ParameterError> {
        let points = fields.points("points")?;
        let wrong = |p: Vec<Point>| fields.error("points", format!("{} points where 12 are needed", p.len()));
        points.try_into().map(Self).map_err(wrong)
    }

    fn splines(&self) -> Option<Splines> {
        let vertex = |k: usize| Self::net([k / 4, k % 4]).collect::<Stencil>().apply(&self.0).into();
        let net: Vec<Point> = (0..16).map(vertex).collect();
        let space = Curve::bezier(net[..4].to_vec()).ok()?.space().clone();
        Some(Splines::Surfaces(vec![Surface::new(space.clone(), space, net).ok()?]))
    }
}

/// Registers the kind.
#[derive(Debug, Clone, Copy, Default)]
pub struct CoonsPlugin;

impl Plugin for CoonsPlugin {
    fn register(&self, registry: &mut Registry) {
        registry.shape::<Coons>();
    }
}
