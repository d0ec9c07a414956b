//! Tessellated geometry of AP242: triangles by index.

use loftsman_kernel::Point;
use loftsman_kernel::mesh::Mesh;

use super::entity::{Args, At, Got, Problem, deeper, entity};
use super::place::Space;
use crate::part21::{File, Value};

/// Whether an entity of this type is made of triangles.
pub(crate) fn is_one(kind: &[u8]) -> bool {
    matches!(
        kind,
        b"TESSELLATED_SOLID"
            | b"TESSELLATED_SHELL"
            | b"TRIANGULATED_FACE"
            | b"COMPLEX_TRIANGULATED_FACE"
            | b"TRIANGULATED_SURFACE_SET"
            | b"COMPLEX_TRIANGULATED_SURFACE_SET"
            | b"TESSELLATED_GEOMETRIC_SET"
    )
}

/// The mesh of an entity that [is one](is_one): all its faces, the points of each list once.
pub(crate) fn mesh(space: &Space<'_, '_>, number: u64) -> Got<Mesh> {
    let mut facets = Facets { space, points: Vec::new(), lists: Vec::new(), faces: Vec::new() };
    facets.add(number, 0)?;
    if facets.faces.is_empty() {
        return Err(Problem::new(number, "no triangles are in it"));
    }
    Mesh::new(facets.points, &facets.faces).at(number)
}

/// What a tessellation says that it stands for: the solid, shell or face that it names, else those that all of its parts name; none where it, or
/// one of them, names none.
pub(crate) fn links(file: &File<'_>, number: u64) -> Vec<u64> {
    fn find(file: &File<'_>, number: u64, depth: usize, found: &mut Vec<u64>) -> Option<()> {
        let depth = deeper(number, depth).ok()?;
        let entity = entity(file, number).ok()?;
        let args = entity.args();
        let (link, parts) = match entity.only() {
            b"TESSELLATED_SOLID" | b"TESSELLATED_SHELL" => (args.optional(2).ok()?, args.references(1).ok()?),
            b"TESSELLATED_GEOMETRIC_SET" => (None, args.references(1).ok()?),
            b"TRIANGULATED_FACE" | b"COMPLEX_TRIANGULATED_FACE" => (args.optional(4).ok()?, Vec::new()),
            _ => (None, Vec::new()),
        };
        if let Some(link) = link {
            found.push(link);
            return Some(());
        }
        (!parts.is_empty()).then_some(())?;
        parts.into_iter().try_for_each(|part| find(file, part, depth, found))
    }
    let mut found = Vec::new();
    find(file, number, 0, &mut found).map_or(Vec::new(), |()| found)
}

struct Facets<'r, 's, 'f> {
    space: &'r Space<'s, 'f>,
    points: Vec<Point>,
    /// Of each COORDINATES_LIST where its points start, and how many there are.
    lists: Vec<(u64, usize, usize)>,
    faces: Vec<[usize; 3]>,
}

impl Facets<'_, '_, '_> {
    fn add(&mut self, number: u64, depth: usize) -> Got<()> {
        let depth = deeper(number, depth)?;
        let entity = self.space.entity(number)?;
        let args = entity.args();
        match entity.only() {
            b"TESSELLATED_SOLID" | b"TESSELLATED_SHELL" | b"TESSELLATED_GEOMETRIC_SET" => {
                args.references(1)?.into_iter().try_for_each(|item| self.add(item, depth))
            }
            // name, coordinates, pnmax, normals, (geometric link,) pnindex, triangles
            b"TRIANGULATED_FACE" => self.triangles(&args, 5),
            b"TRIANGULATED_SURFACE_SET" => self.triangles(&args, 4),
            // …, strips, fans
            b"COMPLEX_TRIANGULATED_FACE" => self.strips(&args, 5),
            b"COMPLEX_TRIANGULATED_SURFACE_SET" => self.strips(&args, 4),
            // Lines and points beside triangles are left out.
            _ => Ok(()),
        }
    }

    /// Where the points of a face are: first the list, then through its own indices, if it has some.
    fn corners(&mut self, args: &Args<'_, '_>, index: usize) -> Got<Corners> {
        let list = args.reference(1)?;
        let (start, count) = match self.lists.iter().find(|(known, ..)| *known == list) {
            Some((_, start, count)) => (*start, *count),
            None => {
                let entity = self.space.entity(list)?;
                let rows = entity.of("COORDINATES_LIST")?;
                let start = self.points.len();
                for row in rows.list(2)? {
                    let row = Args { number: list, values: std::slice::from_ref(row) }.reals(0)?;
                    let [x, y, z] = row[..] else {
                        let text = format!("{} coordinates where 3 are needed", row.len());
                        return Err(Problem::new(list, text));
                    };
                    self.points.push(Point::from([x, y, z].map(|c| self.space.length(c))));
                }
                let count = self.points.len() - start;
                self.lists.push((list, start, count));
                (start, count)
            }
        };
        Ok(Corners { number: args.number, start, count, own: args.counts(index)? })
    }

    fn triangles(&mut self, args: &Args<'_, '_>, index: usize) -> Got<()> {
        let corners = self.corners(args, index)?;
        for row in args.list(index + 1)? {
            let row = Args { number: args.number, values: std::slice::from_ref(row) }.counts(0)?;
            let [a, b, c] = row[..] else {
                return Err(Problem::new(args.number, format!("a triangle of {} corners", row.len())));
            };
            self.faces.push([corners.at(a)?, corners.at(b)?, corners.at(c)?]);
        }
        Ok(())
    }

    fn strips(&mut self, args: &Args<'_, '_>, index: usize) -> Got<()> {
        let corners = self.corners(args, index)?;
        let lists = |index: usize| match args.values.get(index) {
            Some(Value::List(rows)) => rows.as_slice(),
            _ => &[],
        };
        for (rows, fan) in [(lists(index + 1), false), (lists(index + 2), true)] {
            for row in rows {
                let row = Args { number: args.number, values: std::slice::from_ref(row) }.counts(0)?;
                let row: Vec<usize> = row.into_iter().map(|k| corners.at(k)).collect::<Got<_>>()?;
                for (k, three) in row.windows(3).enumerate() {
                    let face = match (fan, k % 2) {
                        (true, _) => [row[0], three[1], three[2]],
                        (false, 0) => [three[0], three[1], three[2]],
                        (false, _) => [three[1], three[0], three[2]],
                    };
                    // Strips go on over triangles without area.
                    if face[0] != face[1] && face[1] != face[2] && face[2] != face[0] {
                        self.faces.push(face);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Where the corners of one face are among all points.
struct Corners {
    number: u64,
    start: usize,
    count: usize,
    /// Its own indices into the list, counted from 1; none where it uses those of the list.
    own: Vec<usize>,
}

impl Corners {
    fn at(&self, index: usize) -> Got<usize> {
        let in_list = if self.own.is_empty() {
            Some(index)
        } else {
            index.checked_sub(1).and_then(|k| self.own.get(k)).copied()
        };
        match in_list.and_then(|k| k.checked_sub(1)).filter(|k| *k < self.count) {
            Some(k) => Ok(self.start + k),
            None => Err(Problem::new(self.number, format!("a corner {index}: there is no such point"))),
        }
    }
}
