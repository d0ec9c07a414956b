//! Breps: solids (186), shells (514) and what they are made of.

use loftsman_kernel::brep::{Brep, Use, UsePlace};
use loftsman_kernel::spline::{Curve, Direction, Space};
use loftsman_kernel::{Error, Point, Result};

use super::print::{Look, Printer, Purpose, Record};
use super::seams::Seams;
use super::shape::elementary;
use super::tips::Tips;

/// Points of a surface's sides that are nearer than this part of its size are one.
const SAME: f64 = 1e-9;

/// What was written of a Brep.
pub(crate) struct Written {
    /// Its solids and shells.
    pub(crate) items: Vec<u32>,
    /// Whether some of them is a solid.
    pub(crate) solid: bool,
    pub(crate) changes: Vec<&'static str>,
    /// By how much some of it is written elsewhere than it is.
    pub(crate) off: f64,
}

/// How faces and solids look.
pub(crate) trait Looks {
    /// The number of a colour.
    fn color(&mut self, printer: &mut Printer, color: [f64; 4]) -> u32;
    /// The number of a name.
    fn name(&mut self, printer: &mut Printer, name: &str) -> u32;
}

/// The sides of a surface around a face that has no edges, and that no elementary surface of the file is. A loop of a single vertex is
/// read as a face of nothing by OpenCASCADE, no loop at all as an open one.
struct Rim {
    /// The curves of its edges, and the vertices that these run between.
    edges: Vec<(Curve, [usize; 2])>,
    /// The number of its first edge in the file.
    first: usize,
    /// Around the domain, counterclockwise: what each side is, and the side itself in parameters.
    sides: Vec<(RimSide, Curve)>,
}

/// A side of a rim.
enum RimSide {
    /// An edge of it, and whether the side runs along it.
    Edge {
        number: usize,
        with: bool,
    },
    Pole {
        vertex: usize,
    },
}

impl Rim {
    /// That of a face; its vertices are added to the points. `None` where the face has edges, or its surface goes out as what it is.
    fn of(brep: &Brep, number: usize, points: &mut Vec<Point>) -> Result<Option<Self>> {
        let Some(face) = brep.face(number).filter(|face| face.loops.is_empty()) else { return Ok(None) };
        if elementary(&face.surface, &face.form)?.is_some() {
            return Ok(None);
        }
        let surface = face.surface.clamped()?;
        let net = surface.points();
        let size = net.iter().map(|p| (p - net[0]).amax()).fold(0.0, f64::max);
        let [u, v] = surface.parameter_sides(SAME * size)?;
        // Its vertices: those that the face has already, as at poles, and new ones.
        let mut own = face.points.clone();
        let mut vertex = |at: [f64; 2]| -> Result<usize> {
            let place = surface.point(at[0], at[1])?;
            if let Some(&known) = own.iter().find(|&&known| (points[known] - place).amax() <= SAME * size) {
                return Ok(known);
            }
            points.push(place);
            own.push(points.len() - 1);
            Ok(points.len() - 1)
        };
        let corners = [[u.low, v.low], [u.high, v.low], [u.high, v.high], [u.low, v.high]];
        let numbers = [vertex(corners[0])?, vertex(corners[1])?, vertex(corners[2])?, vertex(corners[3])?];
        let mut rim = Self { edges: Vec::new(), first: 0, sides: Vec::new() };
        let mut known: [Option<usize>; 4] = [None; 4];
        for side in 0..4 {
            let next = (side + 1) % 4;
            // Along u at the bottom and the top, along v at the right and the left; the last two against them.
            let along_u = side % 2 == 0;
            let with = side < 2;
            let is_pole = match side {
                0 => v.poles[0],
                1 => u.poles[1],
                2 => v.poles[1],
                _ => u.poles[0],
            };
            let line = [corners[side], corners[next]].map(|at| Point::new(at[0], at[1], 0.0)).to_vec();
            let flat = Curve::new(Space::clamped(1, &[0.0, 1.0])?, line)?;
            if is_pole {
                rim.sides.push((RimSide::Pole { vertex: numbers[side] }, flat));
                continue;
            }
            let closed = if along_u { v.closed } else { u.closed };
            let number = match known[side].filter(|_| closed) {
                Some(number) => number,
                None => {
                    let (direction, at) = if along_u {
                        (Direction::V, corners[side][1])
                    } else {
                        (Direction::U, corners[side][0])
                    };
                    let ends =
                        if with { [numbers[side], numbers[next]] } else { [numbers[next], numbers[side]] };
                    rim.edges.push((surface.isocurve(direction, at)?.clamped()?.into_owned(), ends));
                    rim.edges.len() - 1
                }
            };
            // Where it closes, the side across is the same edge.
            known[(side + 2) % 4] = Some(number);
            rim.sides.push((RimSide::Edge { number, with }, flat));
        }
        Ok(Some(rim))
    }
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
        let tips = Tips::of(brep)?;
        let mut points = brep.vertices().to_vec();
        tips.put(&mut points);
        let mut rims = Vec::new();
        for face in 0..brep.face_count() {
            rims.push(Rim::of(brep, face, &mut points)?);
        }
        let record = Record::new(502).count(points.len()).reals(points.iter().flat_map(|p| p.iter()));
        // Lists of nothing are none: a sphere has neither edges nor vertices.
        let vertices = if points.is_empty() { 0 } else { self.put(record, Look::PART.form(1)) };
        let mut curves = Vec::with_capacity(brep.edge_count());
        for number in 0..brep.edge_count() {
            let Some(edge) = brep.edge(number) else {
                return Err(Error::Invalid(format!("there is no edge {number}")));
            };
            let edge = tips.meant(edge)?;
            curves.push((self.edge_curve(&edge)?, edge.ends));
        }
        // Those of the rims follow behind the Brep's own.
        for rim in rims.iter_mut().flatten() {
            rim.first = curves.len();
            for (curve, ends) in &rim.edges {
                curves.push((self.curve(curve, Look::PART, &[]), *ends));
            }
        }
        if rims.iter().any(Option::is_some) {
            changes.push("faces without edges get those along which their surfaces close");
        }
        let has_edges = !curves.is_empty();
        let mut record = Record::new(504).count(curves.len());
        for (curve, [start, end]) in curves {
            record = record.entities(&[curve, vertices]).count(start + 1).entity(vertices).count(end + 1);
        }
        let edges = if has_edges { self.put(record, Look::PART.form(1)) } else { 0 };
        let seams = Seams::of(brep)?;
        if seams.unsaid() {
            changes.push(
                "edges of faces that meet themselves are not told in their parameters, which were not found: others may take the wrong side of a seam",
            );
        }
        let mut faces = Vec::with_capacity(brep.face_count());
        for face in 0..brep.face_count() {
            faces.push(self.face(brep, face, (vertices, edges), (rims[face].as_ref(), &seams), looks)?);
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
        Ok(Written { items, solid: count > 0, changes, off: tips.off.max(seams.off()) })
    }

    /// A face, and whether its normal is that of its surface in the file.
    fn face(
        &mut self,
        brep: &Brep,
        number: usize,
        (vertices, edges): (u32, u32),
        (rim, seams): (Option<&Rim>, &Seams),
        looks: &mut dyn Looks,
    ) -> Result<(u32, bool)> {
        let Some(face) = brep.face(number) else {
            return Err(Error::Invalid(format!("there is no face {number}")));
        };
        let (surface, same) = self.sheet(&face.surface, &face.form)?;
        // Whether the face's normal is that of the surface in the file, around which loops run there.
        let along = face.reversed != same;
        let mut loops = Vec::new();
        for (place, chain) in face.loops.iter().enumerate() {
            let all = chain.iter().enumerate();
            let ordered: Vec<(usize, &Use)> = if along { all.collect() } else { all.rev().collect() };
            let mut record = Record::new(508).count(chain.len());
            for (at, one) in ordered {
                let with = one.reversed != along;
                record = record.whole(0).entity(edges).count(one.edge + 1).whole(i64::from(with));
                let place = UsePlace { face: number, chain: place, number: at };
                record = match seams.curve(place, &face.form, with)? {
                    Some(flat) => {
                        let look = Look::PART.purpose(Purpose::Parametric);
                        record.whole(1).whole(0).entity(self.curve(&flat, look, &[]))
                    }
                    None => record.whole(0),
                };
            }
            loops.push(self.put(record, Look::PART.form(1)));
        }
        if let Some(rim) = rim {
            let mut record = Record::new(508).count(rim.sides.len());
            for (side, line) in &rim.sides {
                let flat = self.curve(line, Look::PART.purpose(Purpose::Parametric), &[]);
                record = match *side {
                    RimSide::Edge { number, with } => {
                        record.whole(0).entity(edges).count(rim.first + number + 1).whole(i64::from(with))
                    }
                    RimSide::Pole { vertex } => record.whole(1).entity(vertices).count(vertex + 1).whole(1),
                };
                record = record.whole(1).whole(0).entity(flat);
            }
            loops.push(self.put(record, Look::PART.form(1)));
        }
        // In a rim the poles are already.
        let points = if rim.is_some() { &[][..] } else { &face.points[..] };
        for &vertex in points {
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
