//! Meshes: points, faces, lines and layers.

use std::fmt;

use loftsman_kernel::mesh::{FaceGroup, Layer, Mesh};
use loftsman_kernel::{Point, Vector};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use super::geometry::refuse;
use super::lists::{Faces, FacesSeed, Fixed, Index, IndexOrNone, List};
use super::table::{Table, TableSeed, need};
use super::trail::Trail;

/// `"mesh"`.
#[derive(Default)]
pub(super) struct MeshTable {
    points: Option<Vec<Point>>,
    faces: Option<Faces>,
    lines: Option<Faces>,
    normals: Layer<[f64; 3]>,
    tangents: Layer<[f64; 4]>,
    uvs: Layer<[f64; 2]>,
    more_uvs: Vec<Layer<[f64; 2]>>,
    colors: Layer<[f64; 4]>,
    materials: Vec<u32>,
    smoothing: Vec<u32>,
    groups: Vec<FaceGroup>,
}

fn layer_seed<'t, const N: usize>(trail: &'t Trail, what: &'static str) -> LayerSeed<'t, N> {
    LayerSeed(Fixed { trail, what })
}

impl<'de> Table<'de> for MeshTable {
    type Out = Mesh;
    const WHAT: &'static str = "a mesh";
    const FIELDS: &'static [&'static str] = &[
        "points",
        "faces",
        "lines",
        "normals",
        "tangents",
        "uvs",
        "more_uvs",
        "colors",
        "materials",
        "smoothing",
        "groups",
    ];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        let numbers = |what| List { trail, what, item: Index(trail) };
        match name {
            "points" => self.points = Some(map.next_value_seed(List::points(trail))?),
            "faces" => self.faces = Some(map.next_value_seed(FacesSeed { trail, what: "face" })?),
            "lines" => self.lines = Some(map.next_value_seed(FacesSeed { trail, what: "line" })?),
            "normals" => self.normals = map.next_value_seed(layer_seed(trail, "[x, y, z]"))?,
            "tangents" => self.tangents = map.next_value_seed(layer_seed(trail, "[x, y, z, sign]"))?,
            "uvs" => self.uvs = map.next_value_seed(layer_seed(trail, "[u, v]"))?,
            "more_uvs" => {
                let item = layer_seed(trail, "[u, v]");
                self.more_uvs = map.next_value_seed(List { trail, what: "layers", item })?;
            }
            "colors" => {
                self.colors = map.next_value_seed(layer_seed(trail, "[red, green, blue, alpha]"))?;
            }
            "materials" => self.materials = map.next_value_seed(numbers("numbers of materials"))?,
            "smoothing" => self.smoothing = map.next_value_seed(numbers("smoothing groups"))?,
            _ => {
                self.groups =
                    map.next_value_seed(List { trail, what: "groups of faces", item: GroupSeed(trail) })?;
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Mesh, E> {
        let points = need::<Self, _, _>(self.points, "points", trail)?;
        let faces = need::<Self, _, _>(self.faces, "faces", trail)?;
        let mut mesh = Mesh::from_parts(points, faces.corners, faces.starts)
            .map_err(|defect| refuse(&defect, 0, trail))?;
        if let Some(lines) = self.lines {
            mesh.set_lines(lines.corners, lines.starts)
                .map_err(|defect| trail.refuse_table("lines", defect.to_string()))?;
        }
        let (points, corners) = (mesh.points().len(), mesh.corners().len());
        let fits = |field: &str, result: loftsman_kernel::Result<()>| {
            result.map_err(|defect| trail.refuse_table(field, defect.to_string()))
        };
        fits("normals", self.normals.check("normals", points, corners))?;
        fits("tangents", self.tangents.check("tangents", points, corners))?;
        fits("uvs", self.uvs.check("uvs", points, corners))?;
        for (i, layer) in self.more_uvs.iter().enumerate() {
            fits(&format!("more_uvs[{i}]"), layer.check("uvs", points, corners))?;
        }
        fits("colors", self.colors.check("colors", points, corners))?;
        mesh.normals = self.normals.map(|&n| Vector::from(n));
        mesh.tangents = self.tangents;
        (mesh.uvs, mesh.more_uvs, mesh.colors) = (self.uvs, self.more_uvs, self.colors);
        (mesh.materials, mesh.smoothing, mesh.groups) = (self.materials, self.smoothing, self.groups);
        // What is left are lists with a number a face, and the groups.
        mesh.check().map_err(|defect| trail.refuse_table("", defect.to_string()))?;
        Ok(mesh)
    }
}

/// Reads a layer: a list of rows, or a table of rows and the corners' indices.
#[derive(Clone, Copy)]
struct LayerSeed<'t, const N: usize>(Fixed<'t, N>);

impl<'de, const N: usize> DeserializeSeed<'de> for LayerSeed<'_, N> {
    type Value = Layer<[f64; N]>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, const N: usize> Visitor<'de> for LayerSeed<'_, N> {
    type Value = Layer<[f64; N]>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of {}, one a point, or a table of \"values\" and \"corners\"", self.0.what)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Self::Value, A::Error> {
        let rows = List { trail: self.0.trail, what: self.0.what, item: self.0 };
        rows.visit_seq(list).map(Layer::per_point)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        let table = LayerTable { row: self.0, values: None, corners: None };
        TableSeed { trail: self.0.trail, table }.visit_map(map)
    }
}

/// A layer whose values belong to corners.
struct LayerTable<'t, const N: usize> {
    row: Fixed<'t, N>,
    values: Option<Vec<[f64; N]>>,
    corners: Option<Vec<u32>>,
}

impl<'de, const N: usize> Table<'de> for LayerTable<'_, N> {
    type Out = Layer<[f64; N]>;
    const WHAT: &'static str = "a layer";
    const FIELDS: &'static [&'static str] = &["values", "corners"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "values" => {
                let rows = List { trail, what: self.row.what, item: self.row };
                self.values = Some(map.next_value_seed(rows)?);
            }
            _ => {
                let indices = List { trail, what: "indices, or -1", item: IndexOrNone(trail) };
                self.corners = Some(map.next_value_seed(indices)?);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<Self::Out, E> {
        let values = need::<Self, _, _>(self.values, "values", trail)?;
        Ok(Layer::per_corner(values, need::<Self, _, _>(self.corners, "corners", trail)?))
    }
}

/// Reads a group of faces.
#[derive(Clone, Copy)]
struct GroupSeed<'t>(&'t Trail);

impl<'de> DeserializeSeed<'de> for GroupSeed<'_> {
    type Value = FaceGroup;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<FaceGroup, D::Error> {
        TableSeed { trail: self.0, table: GroupOfFaces::default() }.deserialize(deserializer)
    }
}

#[derive(Default)]
struct GroupOfFaces {
    name: Option<String>,
    faces: Option<Vec<u32>>,
}

impl<'de> Table<'de> for GroupOfFaces {
    type Out = FaceGroup;
    const WHAT: &'static str = "a group of faces";
    const FIELDS: &'static [&'static str] = &["name", "faces"];

    fn field<A: MapAccess<'de>>(
        &mut self,
        name: &'static str,
        map: &mut A,
        trail: &Trail,
    ) -> Result<(), A::Error> {
        match name {
            "name" => self.name = Some(map.next_value()?),
            _ => {
                let faces = List { trail, what: "indices of faces", item: Index(trail) };
                self.faces = Some(map.next_value_seed(faces)?);
            }
        }
        Ok(())
    }

    fn finish<E: Error>(self, trail: &Trail) -> Result<FaceGroup, E> {
        let name = need::<Self, _, _>(self.name, "name", trail)?;
        Ok(FaceGroup { name, faces: need::<Self, _, _>(self.faces, "faces", trail)? })
    }
}
