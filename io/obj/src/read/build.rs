//! Scene objects out of sections, and the account of every entity.

use std::collections::HashMap;

use loftsman_kernel::Vector;
use loftsman_kernel::mesh::{Cloud, Layer, Mesh, Polyline};
use loftsman_kernel::plugin::{Fate, FormatError, Place, ReadReport, Source};
use loftsman_kernel::scene::{Geometry, Object, Scene};

use super::elements::{NONE, Reader, Section};
use super::raw::{Raw, Use};
use super::{Corners, material, stem};
use crate::text::show;

/// What has become of every entry of the lists.
struct Uses {
    points: Vec<Use>,
    uvs: Vec<Use>,
    normals: Vec<Use>,
}

impl Reader {
    /// Makes the scene of what was read.
    pub(crate) fn finish(
        mut self,
        source: &dyn Source,
        corners: Corners,
        scene: &mut Scene,
        report: &mut ReadReport,
    ) -> Result<(), FormatError> {
        let file = source.name();
        self.freeform.unfinished().map_err(|p| FormatError::new(file, Place::File, p))?;
        let lists = [
            (self.raw.points.len(), "vertex"),
            (self.raw.uvs.len(), "texture vertex"),
            (self.raw.normals.len(), "normal"),
        ];
        for (reach, (count, what)) in self.reach.iter().zip(lists) {
            if reach.past > count {
                let problem = format!("refers to {what} {}, but the file has {count}", reach.past);
                return Err(FormatError::new(file, Place::Line(reach.line), problem));
            }
        }
        let colors = self.colors(source, report);
        let stem = stem(file);
        let mut uses = Uses {
            points: vec![Use::Nothing; self.raw.points.len()],
            uvs: vec![Use::Nothing; self.raw.uvs.len()],
            normals: vec![Use::Nothing; self.raw.normals.len()],
        };
        for &vertex in &self.curve_vertices {
            uses.points[vertex as usize] = Use::Kept;
        }
        let empty = |s: &Section| {
            s.corners.is_empty() && s.chains.is_empty() && s.points.is_empty() && s.curves.is_empty()
        };
        let only_points = self.sections.iter().all(empty) && self.left_out.is_empty();
        if only_points && !self.raw.points.is_empty() {
            report.notes.push("the file has vertices and nothing else: they are a cloud".to_owned());
            self.sections[0].points = (0..self.raw.points.len() as u32).collect();
        }
        for section in std::mem::take(&mut self.sections) {
            let name = if section.name.is_empty() { stem.as_ref() } else { section.name.as_str() };
            let color = match section.materials.first() {
                Some(only) if section.materials.len() == 1 => colors.get(only).copied(),
                _ => None,
            };
            let geometries = geometries(&self.raw, &section, corners, &mut uses)
                .map_err(|e| FormatError::new(file, Place::File, e.to_string()).of(name))?;
            for geometry in geometries {
                let mut object = Object::new(scene.unique_name(name), geometry);
                object.color = color;
                scene.add(object).map_err(|e| FormatError::new(file, Place::File, e.to_string()))?;
            }
        }
        self.account(&uses, report);
        Ok(())
    }

    /// The colours of all libraries that can be found.
    fn colors(&self, source: &dyn Source, report: &mut ReadReport) -> HashMap<Vec<u8>, [f64; 4]> {
        let mut colors = HashMap::new();
        for library in &self.libraries {
            // One name, perhaps with blanks; or several names.
            let text = String::from_utf8_lossy(library);
            let whole = text.strip_prefix("./").unwrap_or(&text);
            let mut found = match source.sibling(whole) {
                Ok(bytes) => {
                    material::colors(&bytes, &mut colors);
                    true
                }
                Err(_) => false,
            };
            if !found {
                for name in whole.split_ascii_whitespace().take(64) {
                    if let Ok(bytes) = source.sibling(name.strip_prefix("./").unwrap_or(name)) {
                        material::colors(&bytes, &mut colors);
                        found = true;
                    }
                }
            }
            if !found {
                report.notes.push(format!("the material library \"{}\" was not found", show(library)));
            }
        }
        colors
    }

    fn account(&self, uses: &Uses, report: &mut ReadReport) {
        report.count_many(Fate::Kept, "", self.kept);
        let mut reasons: Vec<_> = self.left_out.iter().collect();
        reasons.sort();
        for (reason, count) in reasons {
            report.count_many(Fate::LeftOut, reason, *count);
        }
        let materials = "materials: the colour of an object of one material is kept, nothing else";
        report.count_many(Fate::Approximated, materials, self.material_statements);
        for (list, what) in
            [(&uses.points, "vertices"), (&uses.uvs, "texture vertices"), (&uses.normals, "normals")]
        {
            let count = |wanted: Use| list.iter().filter(|&&u| u == wanted).count();
            report.count_many(Fate::Kept, "", count(Use::Kept));
            report.count_many(
                Fate::LeftOut,
                &format!("{what} that nothing in the scene uses"),
                count(Use::Nothing),
            );
            let differ = format!(
                "{what} that differ between the faces at a point, or that only some corners have (corners = \"split\" keeps them)"
            );
            report.count_many(Fate::LeftOut, &differ, count(Use::LeftOut));
        }
        if self.periodic > 0 {
            let what = "curve(s) whose control vertices and knots wrap around are periodic";
            report.notes.push(format!("{} {what}", self.periodic));
        }
        if !self.raw.colors.is_empty() {
            report.notes.push("vertex colours were taken as sRGB and made linear".to_owned());
        }
    }
}

fn geometries(
    raw: &Raw,
    section: &Section,
    corners: Corners,
    uses: &mut Uses,
) -> loftsman_kernel::Result<Vec<Geometry>> {
    let mut out = Vec::new();
    if !section.corners.is_empty() {
        out.push(Geometry::Mesh(mesh(raw, section, corners, uses)?));
    }
    let mut take = |vertex: u32| {
        uses.points[vertex as usize] = Use::Kept;
        raw.points[vertex as usize]
    };
    for chain in &section.chains {
        let closed = chain.len() > 3 && chain.first() == chain.last();
        let end = chain.len() - usize::from(closed);
        out.push(Geometry::Polyline(Polyline {
            points: chain[..end].iter().map(|&v| take(v)).collect(),
            closed,
        }));
    }
    if !section.points.is_empty() {
        out.push(Geometry::Cloud(Cloud { points: section.points.iter().map(|&v| take(v)).collect() }));
    }
    out.extend(section.curves.iter().map(Geometry::from));
    Ok(out)
}

/// The mesh of a section, with the points that it uses in the order of the file.
fn mesh(raw: &Raw, section: &Section, corners: Corners, uses: &mut Uses) -> loftsman_kernel::Result<Mesh> {
    let at = |list: &[u32], corner: usize| list.get(corner).copied().unwrap_or(NONE);
    let (origin, numbered) = match corners {
        Corners::Share => share(&section.corners),
        Corners::Split => split(section),
    };
    // Attributes by point: the first that any corner gives; dropped where another differs or is missing.
    let gather = |list: &[u32], uses: &mut [Use], equal: &dyn Fn(u32, u32) -> bool| -> Option<Vec<u32>> {
        if list.is_empty() {
            return None;
        }
        let mut by_point = vec![NONE; origin.len()];
        let mut consistent = true;
        for (corner, &point) in numbered.iter().enumerate() {
            let index = at(list, corner);
            let slot = &mut by_point[point as usize];
            if *slot == NONE {
                *slot = index;
            }
            consistent &= index != NONE && (*slot == index || equal(*slot, index));
        }
        let fate = if consistent { Use::Kept } else { Use::LeftOut };
        for &index in list.iter().filter(|&&i| i != NONE) {
            let mark = &mut uses[index as usize];
            *mark = (*mark).max(fate);
        }
        consistent.then_some(by_point)
    };
    let uvs = gather(&section.textures, &mut uses.uvs, &|a, b| raw.uvs[a as usize] == raw.uvs[b as usize]);
    let unit = |i: u32| raw.normals[i as usize].try_normalize(0.0);
    let normals = gather(&section.normals, &mut uses.normals, &|a, b| {
        raw.normals[a as usize] == raw.normals[b as usize]
    });
    let points = origin.iter().map(|&v| raw.points[v as usize]).collect();
    let mut mesh = Mesh::from_parts(points, numbered, section.starts.clone())?;
    for &v in &origin {
        uses.points[v as usize] = Use::Kept;
    }
    mesh.uvs = uvs.map_or_else(Layer::none, |list| {
        Layer::per_point(list.iter().map(|&i| raw.uvs[i as usize]).collect())
    });
    // A normal without length has no direction: the mesh then has none.
    let units: Option<Vec<Vector>> = normals.and_then(|list| list.iter().map(|&i| unit(i)).collect());
    mesh.normals = Layer::per_point(units.unwrap_or_default());
    let colors: Option<Vec<[f64; 4]>> = origin.iter().map(|&v| raw.color(v)).collect();
    mesh.colors = Layer::per_point(colors.unwrap_or_default());
    Ok(mesh)
}

/// The vertices in use, ascending, and every corner's place among them. `O(corners)`, or `O(corners log corners)`
/// where few of a wide range are used, so that many small objects of a large file do not cost its square.
fn share(corners: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let (Some(&low), Some(&high)) = (corners.iter().min(), corners.iter().max()) else {
        return (Vec::new(), Vec::new());
    };
    let range = (high - low) as usize + 1;
    if range <= 4 * corners.len() + 64 {
        let mut place = vec![NONE; range];
        for &v in corners {
            place[(v - low) as usize] = 0;
        }
        let mut origin = Vec::new();
        for (offset, slot) in place.iter_mut().enumerate().filter(|(_, slot)| **slot == 0) {
            *slot = origin.len() as u32;
            origin.push(low + offset as u32);
        }
        let numbered = corners.iter().map(|&v| place[(v - low) as usize]).collect();
        return (origin, numbered);
    }
    let mut origin = corners.to_vec();
    origin.sort_unstable();
    origin.dedup();
    let numbered = corners.iter().map(|v| origin.partition_point(|o| o < v) as u32).collect();
    (origin, numbered)
}

/// One point for every combination of vertex, texture vertex and normal, in the order of the corners.
fn split(section: &Section) -> (Vec<u32>, Vec<u32>) {
    let at = |list: &[u32], corner: usize| list.get(corner).copied().unwrap_or(NONE);
    let mut known: HashMap<(u32, u32, u32), u32> = HashMap::with_capacity(section.corners.len() / 2);
    let mut origin = Vec::new();
    let mut numbered = Vec::with_capacity(section.corners.len());
    for (corner, &v) in section.corners.iter().enumerate() {
        let key = (v, at(&section.textures, corner), at(&section.normals, corner));
        let next = origin.len() as u32;
        let place = *known.entry(key).or_insert(next);
        if place == next {
            origin.push(v);
        }
        numbered.push(place);
    }
    (origin, numbered)
}
