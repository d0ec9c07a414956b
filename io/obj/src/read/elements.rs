//! Faces, lines and points, sorted into the sections that become objects.

use std::collections::{BTreeSet, HashMap};

use loftsman_kernel::spline::Curve;

use super::Split;
use super::freeform::{Element, Freeform};
use super::raw::{Raw, resolve};
use crate::text::words;

/// No texture vertex or normal at a corner.
pub(crate) const NONE: u32 = u32::MAX;

/// The elements of one object-to-be.
#[derive(Debug, Default)]
pub(crate) struct Section {
    pub(crate) name: String,
    /// Vertex of every corner, face after face.
    pub(crate) corners: Vec<u32>,
    pub(crate) starts: Vec<usize>,
    /// Texture vertex of every corner, or [`NONE`]; shorter than `corners` where the last ones have none.
    pub(crate) textures: Vec<u32>,
    /// Normal of every corner, likewise.
    pub(crate) normals: Vec<u32>,
    pub(crate) chains: Vec<Vec<u32>>,
    pub(crate) points: Vec<u32>,
    pub(crate) curves: Vec<Curve>,
    pub(crate) materials: BTreeSet<Vec<u8>>,
}

/// The largest index into a list, and where it stands.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Reach {
    pub(crate) past: usize,
    pub(crate) line: usize,
}

/// What the statements have built so far.
pub(crate) struct Reader {
    pub(crate) raw: Raw,
    pub(crate) freeform: Freeform,
    pub(crate) sections: Vec<Section>,
    by_name: HashMap<String, usize>,
    current: usize,
    split: Split,
    material: Option<Vec<u8>>,
    /// Whether the current section knows the current material.
    material_noted: bool,
    pub(crate) libraries: Vec<Vec<u8>>,
    pub(crate) left_out: HashMap<String, usize>,
    /// Elements and statements that are in the scene.
    pub(crate) kept: usize,
    pub(crate) material_statements: usize,
    pub(crate) reach: [Reach; 3],
    /// Vertices that curves use.
    pub(crate) curve_vertices: Vec<u32>,
    /// Statements understood.
    pub(crate) statements: usize,
    pub(crate) periodic: usize,
}

impl Reader {
    pub(crate) fn new(split: Split) -> Self {
        Self {
            raw: Raw::default(),
            freeform: Freeform::default(),
            sections: vec![Section::default()],
            by_name: HashMap::from([(String::new(), 0)]),
            current: 0,
            split,
            material: None,
            material_noted: false,
            libraries: Vec::new(),
            left_out: HashMap::new(),
            kept: 0,
            material_statements: 0,
            reach: [Reach::default(); 3],
            curve_vertices: Vec::new(),
            statements: 0,
            periodic: 0,
        }
    }

    pub(crate) fn left_out(&mut self, reason: &str) -> Result<(), String> {
        match self.left_out.get_mut(reason) {
            Some(count) => *count += 1,
            None => _ = self.left_out.insert(reason.to_owned(), 1),
        }
        Ok(())
    }

    pub(crate) fn object(&mut self, rest: &[u8]) -> Result<(), String> {
        if self.split == Split::Object {
            self.switch(rest);
            return Ok(());
        }
        self.left_out("objects (o) were not asked for")
    }

    pub(crate) fn group(&mut self, rest: &[u8]) -> Result<(), String> {
        if self.split == Split::Group {
            self.switch(rest);
            return Ok(());
        }
        self.left_out("groups inside objects are not kept: read with split = \"group\" to make them objects")
    }

    /// Goes on with the section of a name; the name of nothing is that of the file.
    fn switch(&mut self, name: &[u8]) {
        self.kept += 1;
        self.material_noted = false;
        let name: String = String::from_utf8_lossy(name).chars().filter(|c| !c.is_control()).collect();
        let next = self.sections.len();
        self.current = *self.by_name.entry(name.clone()).or_insert(next);
        if self.current == next {
            self.sections.push(Section { name, ..Section::default() });
        }
    }

    pub(crate) fn material(&mut self, rest: &[u8]) -> Result<(), String> {
        self.material = Some(rest.to_vec()).filter(|name| !name.is_empty());
        self.material_noted = false;
        self.material_statements += 1;
        Ok(())
    }

    pub(crate) fn library(&mut self, rest: &[u8]) -> Result<(), String> {
        self.material_statements += 1;
        // A file that repeats the statement before every object must not have the library read as often.
        if self.libraries.len() < 64 && !self.libraries.iter().any(|l| l == rest) {
            self.libraries.push(rest.to_vec());
        }
        Ok(())
    }

    /// `f v/vt/vn …`.
    pub(crate) fn face(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        let section = &mut self.sections[self.current];
        let before = section.corners.len();
        if section.starts.is_empty() {
            section.starts.push(0);
        }
        for word in words(rest) {
            let mut parts = word.split(|&b| b == b'/');
            let vertex = resolve(parts.next().unwrap_or_default(), self.raw.points.len(), "vertex")?;
            section.corners.push(vertex);
            reach(&mut self.reach[0], vertex, line);
            if let Some(part) = parts.next().filter(|p| !p.is_empty()) {
                let texture = resolve(part, self.raw.uvs.len(), "texture vertex")?;
                section.textures.resize(section.corners.len() - 1, NONE);
                section.textures.push(texture);
                reach(&mut self.reach[1], texture, line);
            }
            if let Some(part) = parts.next().filter(|p| !p.is_empty()) {
                let normal = resolve(part, self.raw.normals.len(), "normal")?;
                section.normals.resize(section.corners.len() - 1, NONE);
                section.normals.push(normal);
                reach(&mut self.reach[2], normal, line);
            }
            if parts.next().is_some() {
                return Err("a corner has more than vertex/texture/normal".to_owned());
            }
        }
        let corners = section.corners.len() - before;
        if corners < 3 {
            return Err(format!("a face has {corners} corner(s): at least 3 are needed"));
        }
        section.starts.push(section.corners.len());
        if let Some(material) = self.material.as_ref().filter(|_| !self.material_noted) {
            section.materials.insert(material.clone());
            self.material_noted = true;
        }
        self.kept += 1;
        Ok(())
    }

    /// `l v/vt …`: joined to the line before where it starts at its end.
    pub(crate) fn line(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        let mut chain = self.vertices(rest, line)?;
        if chain.len() < 2 {
            return Err(format!("a line has {} vertex: at least 2 are needed", chain.len()));
        }
        let section = &mut self.sections[self.current];
        match section.chains.last_mut() {
            // A chain that has come back to its start is complete.
            Some(last) if last.last() == chain.first() && (last.len() < 3 || last.first() != last.last()) => {
                last.extend(chain.drain(1..));
            }
            _ => section.chains.push(chain),
        }
        self.kept += 1;
        Ok(())
    }

    /// `p v …`.
    pub(crate) fn points(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        let points = self.vertices(rest, line)?;
        if points.is_empty() {
            return Err("a point statement has no vertex".to_owned());
        }
        self.sections[self.current].points.extend(points);
        self.kept += 1;
        Ok(())
    }

    fn vertices(&mut self, rest: &[u8], line: usize) -> Result<Vec<u32>, String> {
        let mut out = Vec::new();
        for word in words(rest) {
            let part = word.split(|&b| b == b'/').next().unwrap_or_default();
            let vertex = resolve(part, self.raw.points.len(), "vertex")?;
            reach(&mut self.reach[0], vertex, line);
            out.push(vertex);
        }
        Ok(out)
    }

    /// `curv u0 u1 v …`: the element starts; `end` ends it.
    pub(crate) fn curv(&mut self, rest: &[u8], line: usize) -> Result<(), String> {
        let mut parts = words(rest);
        let mut bound = || match parts.next() {
            Some(word) => crate::text::number(word),
            None => Err("curv needs a start and an end parameter and control vertices".to_owned()),
        };
        let range = (bound()?, bound()?);
        let mut vertices = Vec::new();
        for word in parts {
            vertices.push(resolve(word, self.raw.points.len(), "vertex")?);
        }
        // The curve is made at its end, so that here forward references cannot wait for the end of the file.
        if let Some(&past) = vertices.iter().find(|&&v| v as usize >= self.raw.points.len()) {
            let count = self.raw.points.len();
            return Err(format!("refers to vertex {}, but there are {count} so far", u64::from(past) + 1));
        }
        self.freeform.start(Element::Curve { range, vertices }, line)
    }

    pub(crate) fn other_element(&mut self, word: &[u8], line: usize) -> Result<(), String> {
        let what = String::from_utf8_lossy(word).into_owned();
        self.freeform.start(Element::Other { what }, line)
    }

    pub(crate) fn end(&mut self, line: usize) -> Result<(), String> {
        use super::freeform::Outcome;
        match self.freeform.finish(&self.raw, line)? {
            Outcome::Curve { curve, vertices, wrapped } => {
                self.kept += 1;
                self.periodic += usize::from(wrapped);
                self.curve_vertices.extend(vertices);
                self.sections[self.current].curves.push(curve);
                Ok(())
            }
            Outcome::LeftOut(reason) => self.left_out(&reason),
        }
    }
}

fn reach(reach: &mut Reach, index: u32, line: usize) {
    let past = index as usize + 1;
    if past > reach.past {
        *reach = Reach { past, line };
    }
}
