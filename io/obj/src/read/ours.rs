//! What was noted here in comments: unit and axis, curves with their own knots, meshes that show a surface.

use loftsman_kernel::Point;
use loftsman_kernel::scene::{Unit, Up};
use loftsman_kernel::spline::{Curve, Space};

use crate::number::numbers;
use crate::text::{keyword, line_length};

/// The unit and the axis in the first line of a file that was written here: `# Loftsman; unit mm, y up`.
pub(super) fn head(text: &[u8]) -> Option<(Unit, Up)> {
    let line = std::str::from_utf8(&text[..line_length(text)]).ok()?.trim_end();
    let (unit, up) = line.strip_prefix("# Loftsman; unit ")?.strip_suffix(" up")?.rsplit_once(", ")?;
    Some((Unit::from_name(unit)?, Up::from_name(up)?))
}

/// A note in a comment.
pub(super) enum Ours {
    /// The curve whose Bézier form follows: `curve 3 open; knots …; points …; weights …`.
    Curve(Curve),
    /// The normals of the object's faces were made when it was written: `normals`.
    MadeNormals,
    /// The object's mesh shows the surface of this mark: `mesh 0123456789abcdef`.
    Mesh(u64),
    /// The object's own colour: `color 0.25 0.5 0.75 1`.
    Color([f64; 4]),
    /// The object's surface, of the first mark, is shown by the mesh of the second: `surface 0123456789abcdef of mesh 0123456789abcdef`.
    Surface(u64, u64),
}

impl Ours {
    /// What a comment notes, behind its start; `None` where it notes nothing that could be read.
    pub(super) fn of(text: &[u8]) -> Option<Self> {
        let (word, rest) = keyword(text);
        match word {
            b"curve" => curve(rest).map(Self::Curve),
            b"normals" => Some(Self::MadeNormals),
            b"mesh" => mark(rest).map(Self::Mesh),
            b"color" => color(rest).map(Self::Color),
            b"surface" => {
                let (own, rest) = keyword(rest);
                let (of, rest) = keyword(rest);
                let (what, rest) = keyword(rest);
                (of == b"of" && what == b"mesh")
                    .then(|| mark(own).zip(mark(rest)))?
                    .map(|(own, mesh)| Self::Surface(own, mesh))
            }
            _ => None,
        }
    }
}

fn color(text: &[u8]) -> Option<[f64; 4]> {
    let color: [f64; 4] = numbers(text).ok()?.try_into().ok()?;
    color.iter().all(|x| x.is_finite()).then_some(color)
}

fn mark(text: &[u8]) -> Option<u64> {
    u64::from_str_radix(std::str::from_utf8(text).ok()?.trim(), 16).ok()
}

fn curve(text: &[u8]) -> Option<Curve> {
    let mut parts = text.split(|&b| b == b';');
    let (degree, kind) = keyword(parts.next()?);
    let degree = std::str::from_utf8(degree).ok()?.parse().ok()?;
    let (mut knots, mut points, mut weights) = (None, None, None);
    for part in parts {
        let (word, values) = keyword(part);
        let list = match word {
            b"knots" => &mut knots,
            b"points" => &mut points,
            b"weights" => &mut weights,
            _ => return None,
        };
        *list = Some(numbers(values).ok()?);
    }
    let space = match kind.trim_ascii() {
        b"open" => Space::open(degree, knots?),
        b"periodic" => Space::periodic(degree, knots?),
        _ => return None,
    };
    let points: Vec<f64> = points?;
    let points = points.chunks_exact(3).map(|p| Point::new(p[0], p[1], p[2])).collect();
    Curve::build(space.ok()?, points, weights).ok()
}
