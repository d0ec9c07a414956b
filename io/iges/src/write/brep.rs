//! Breps: solids (186), shells (514) and what they are made of.

use loftsman_kernel::brep::{Brep, Use};
use loftsman_kernel::{Error, Result};

use super::print::{Look, Printer, Purpose, Record};

/// What was written of a Brep.
pub(crate) struct Written {
    /// Its solids and shells.
    pub(crate) items: Vec<u32>,
    /// Whether some of them is a solid.
    pub(crate) solid: bool,
    pub(crate) changes: Vec<&'static str>,
}

/// How faces and solids look.
pub(crate) trait Looks {
    /// The number of a colour.
    fn color(&mut self, printer: &mut Printer, color: [f64; 4]) -> u32;
    /// The number of a name.
    fn name(&mut self, printer: &mut Printer, name: &str) -> u32;
}

impl Printer {
    /// All of a Brep; `look` and `properties` are those of its only item, or of each.
    pub(crate) fn brep(
        &mut self,
        brep: &Brep,
        looks: &mut dyn Looks,
        look: Look,
        properties: &[u32],
    ) -> Result<Written> {
        let mut changes = Vec::new();
        let vertices = brep.vertices();
        let record = Record::new(502).count(vertices.len()).reals(vertices.iter().flat_map(|p| p.iter()));
        // Lists of nothing are none: a sphere has neither edges nor vertices.
        let vertices = if brep.vertices().is_empty() { 0 } else { self.put(record, Look::PART.form(1)) };
        let mut curves = Vec::with_capacity(brep.edge_count());
        for number in 0..brep.edge_count() {
            let Some(edge) = brep.edge(number) else {
                return Err(Error::Invalid(format!("there is no edge {number}")));
            };
            curves.push((self.edge_curve(&edge)?, edge.ends));
        }
        let mut record = Record::new(504).count(curves.len());
        for (curve, [start, end]) in curves {
            record = record.entities(&[curve, vertices]).count(start + 1).entity(vertices).count(end + 1);
        }
        let edges = if brep.edge_count() == 0 { 0 } else { self.put(record, Look::PART.form(1)) };
        let mut faces = Vec::with_capacity(brep.face_count());
        for face in 0..brep.face_count() {
            faces.push(self.face(brep, face, (vertices, edges), looks)?);
        }
        let mut items = Vec::new();
        let mut in_solid = vec![false; brep.shells().len()];
        let mut shells = Vec::new();
        let count = brep.solids().len();
        let mut in_shell = vec![false; faces.len()];
        let shell_of = |numbers: &[usize]| {
            let record = Record::new(514).count(numbers.len());
            numbers
                .iter()
                .fold(record, |record, &face| record.entity(faces[face].0).whole(i64::from(faces[face].1)))
        };
        for solid in brep.solids() {
            let all: Vec<usize> = std::iter::once(solid.outer).chain(solid.voids.iter().copied()).collect();
            let mut numbers = Vec::new();
            for shell in all {
                in_solid[shell] = true;
                numbers.push(self.put(shell_of(&brep.shells()[shell].faces), Look::PART.form(1)));
            }
            let record = Record::new(186).entity(numbers[0]).whole(1).count(numbers.len() - 1);
            let record = numbers[1..].iter().fold(record, |record, &void| record.entity(void).whole(1));
            let own = match &solid.name {
                Some(name) if count > 1 => vec![looks.name(self, name)],
                _ => properties.to_vec(),
            };
            items.push(self.put(record.properties(&own), look));
        }
        for (number, shell) in brep.shells().iter().enumerate() {
            shell.faces.iter().for_each(|&face| in_shell[face] = true);
            if !in_solid[number] {
                shells.push((shell.faces.clone(), brep.is_closed(&shell.faces)));
            }
        }
        let alone: Vec<usize> = (0..faces.len()).filter(|&face| !in_shell[face]).collect();
        if !alone.is_empty() {
            changes.push("its faces without a shell are one");
            shells.push((alone, false));
        }
        for (numbers, closed) in shells {
            let form = if closed { 1 } else { 2 };
            items.push(self.put(shell_of(&numbers).properties(properties), look.form(form)));
        }
        if items.len() > 1 {
            changes.push("its solids and shells are objects of their own");
        }
        Ok(Written { items, solid: count > 0, changes })
    }

    /// A face, and whether its normal is that of its surface in the file.
    fn face(
        &mut self,
        brep: &Brep,
        number: usize,
        (vertices, edges): (u32, u32),
        looks: &mut dyn Looks,
    ) -> Result<(u32, bool)> {
        let Some(face) = brep.face(number) else {
            return Err(Error::Invalid(format!("there is no face {number}")));
        };
        let (surface, same) = self.sheet(&face.surface, &face.form)?;
        // Whether the face's normal is that of the surface in the file, around which loops run there.
        let along = face.reversed != same;
        let mut loops = Vec::new();
        for chain in &face.loops {
            let ordered: Vec<&Use> =
                if along { chain.iter().collect() } else { chain.iter().rev().collect() };
            let record = ordered.iter().fold(Record::new(508).count(chain.len()), |record, one| {
                let with = one.reversed != along;
                record.whole(0).entity(edges).count(one.edge + 1).whole(i64::from(with)).whole(0)
            });
            loops.push(self.put(record, Look::PART.form(1)));
        }
        for &vertex in &face.points {
            let record =
                Record::new(508).whole(1).whole(1).entity(vertices).count(vertex + 1).whole(1).whole(0);
            loops.push(self.put(record, Look::PART.form(1)));
        }
        let record = Record::new(510).entity(surface).count(loops.len()).whole(0).entities(&loops);
        let name = face.name.as_deref().filter(|name| !name.trim().is_empty());
        let properties: Vec<u32> = name.map(|name| looks.name(self, name)).into_iter().collect();
        let color = face.color.map(|color| looks.color(self, color));
        let look = Look { color, ..Look::PART.form(1).purpose(Purpose::Geometry) };
        Ok((self.put(record.properties(&properties), look), along))
    }
}
