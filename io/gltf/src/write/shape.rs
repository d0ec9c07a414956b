//! Shapes as primitives: what goes into the buffer, and what the document says of it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::placement::Change;
use loftsman_kernel::plugin::FormatError;
use loftsman_kernel::{Error, Point, Vector};

use super::bin::{Bin, Kind, Out, Use};
use super::frame::{Frame, single};
use super::schema::Primitive;
use crate::extras::fingerprint;
use loftsman_kernel::text::counted;

pub(super) const NORMAL: &str = "NORMAL";

pub(super) const POINTS: u8 = 0;
pub(super) const LINES: u8 = 1;
pub(super) const LINE_STRIP: u8 = 3;
pub(super) const TRIANGLES: u8 = 4;

pub(super) fn put<const N: usize>(numbers: [f32; N], out: &mut Out<'_>) -> io::Result<()> {
    // At most four numbers: one call instead of one for each.
    let mut bytes = [0; 16];
    for (slot, x) in bytes.chunks_exact_mut(4).zip(numbers) {
        slot.copy_from_slice(&x.to_le_bytes());
    }
    out.write_all(&bytes[..4 * N])
}

pub(super) fn put_index(index: u32, kind: Kind, out: &mut Out<'_>) -> io::Result<()> {
    if kind.is_narrow() {
        out.write_all(&(index as u16).to_le_bytes())
    } else {
        out.write_all(&index.to_le_bytes())
    }
}

/// An object's shape, written.
#[derive(Debug, Clone)]
pub(super) struct Shaped {
    pub(super) primitives: Vec<Primitive>,
    /// The slot of each primitive's material, and how many sets of texture coordinates it has.
    pub(super) slots: Vec<(u32, u32)>,
    /// The colours that slots have instead of a material; none of most shapes.
    pub(super) paints: Vec<Option<[f64; 4]>>,
    pub(super) frame: Frame,
    /// What it became: `"12 triangles"`.
    pub(super) form: String,
    /// What had to be changed.
    pub(super) remarks: Vec<String>,
    pub(super) has_colors: bool,
    /// For each point that was written, the point of the shape that it comes from, where they are not the same.
    pub(super) doubled: Vec<u32>,
    /// Whether its tangents are not the scene's.
    pub(super) made_tangents: bool,
    /// What its normals turn with in frames, where it has any.
    pub(super) turning: Option<Turning>,
}

/// A mesh with its normals, and which of them each point that was written has; [`NONE`](loftsman_kernel::mesh::NONE) for none.
#[derive(Debug, Clone)]
pub(super) struct Turning {
    pub(super) mesh: Mesh,
    pub(super) of: Vec<u32>,
    /// Which of the points that were written have a normal that is a little short; none at all where the list is empty.
    pub(super) short: Vec<bool>,
}

impl Shaped {
    /// Lines or points with positions and nothing else.
    fn plain(primitives: Vec<Primitive>, frame: Frame, form: String) -> Self {
        Self {
            slots: vec![(0, 0); primitives.len()],
            primitives,
            paints: Vec::new(),
            frame,
            form,
            remarks: Vec::new(),
            has_colors: false,
            doubled: Vec::new(),
            made_tangents: false,
            turning: None,
        }
    }
}

/// Values that are poured later where the scene lends them, or else now.
pub(super) fn values<'a, T>(
    bin: &mut Bin<'a>,
    list: Cow<'a, [T]>,
    kind: Kind,
    used: Use,
    bounds: Option<[Vec<f32>; 2]>,
    one: impl Fn(&T, &mut Out<'_>) -> io::Result<()> + 'a,
) -> io::Result<usize>
where
    [T]: ToOwned,
{
    match list {
        Cow::Borrowed(list) => {
            let pour = move |out: &mut Out<'_>| list.iter().try_for_each(|v| one(v, out));
            Ok(bin.later(kind, used, list.len(), bounds, Box::new(pour)))
        }
        Cow::Owned(_) => {
            bin.now(kind, used, list.len(), bounds, |out| list.iter().try_for_each(|v| one(v, out)))
        }
    }
}

pub(super) fn positions<'a>(bin: &mut Bin<'a>, points: Cow<'a, [Point]>, frame: Frame) -> io::Result<usize> {
    let one = move |p: &Point, out: &mut Out<'_>| put(frame.position(p), out);
    values(bin, points, Kind::floats(3), Use::Vertices, Some(frame.bounds()), one)
}

pub(super) fn primitive(attributes: BTreeMap<String, usize>, indices: Option<usize>, mode: u8) -> Primitive {
    Primitive { attributes, indices, material: None, mode, targets: Vec::new() }
}

/// Loose points (mode [`POINTS`]), or a chain of them ([`LINE_STRIP`]); a closed one comes back to its first vertex by its
/// indices.
pub(super) fn chain<'a>(
    points: Cow<'a, [Point]>,
    mode: u8,
    closed: bool,
    change: Change,
    bin: &mut Bin<'a>,
) -> Result<Shaped, FormatError> {
    let frame = Frame::of(&points, change)?;
    let count = points.len();
    let position = positions(bin, points, frame)?;
    let indices = if closed {
        let (kind, n) = (Kind::indices(count), count as u32);
        let all = move |out: &mut Out<'_>| (0..n).chain([0]).try_for_each(|i| put_index(i, kind, out));
        Some(bin.later(kind, Use::Indices, count + 1, None, Box::new(all)))
    } else {
        None
    };
    let form = match mode {
        POINTS => counted(count, "point[|s]"),
        _ => format!("line strip of {}", counted(count - usize::from(!closed), "segment[|s]")),
    };
    let all = vec![primitive(BTreeMap::from([("POSITION".to_owned(), position)]), indices, mode)];
    Ok(Shaped::plain(all, frame, form))
}

/// A line of parts, each from the first of its points to the one before the next part: strips of one mesh. A part of one
/// point shows nothing. A closed line is of one part.
pub(super) fn chains(
    points: &[Point],
    starts: &[usize],
    closed: bool,
    change: Change,
    bin: &mut Bin<'_>,
) -> Result<Shaped, FormatError> {
    if starts.len() < 2 {
        return chain(Cow::Owned(points.to_vec()), LINE_STRIP, closed, change, bin);
    }
    let frame = Frame::of(points, change)?;
    let count = points.len();
    let kind = Kind::indices(count);
    let position = positions(bin, Cow::Owned(points.to_vec()), frame)?;
    let ends = starts.iter().skip(1).copied().chain([count]);
    let parts: Vec<_> = starts.iter().copied().zip(ends).filter(|(start, end)| end - start >= 2).collect();
    let mut primitives = Vec::with_capacity(parts.len());
    for &(start, end) in &parts {
        let all =
            move |out: &mut Out<'_>| (start as u32..end as u32).try_for_each(|i| put_index(i, kind, out));
        let indices = bin.later(kind, Use::Indices, end - start, None, Box::new(all));
        let attributes = BTreeMap::from([("POSITION".to_owned(), position)]);
        primitives.push(primitive(attributes, Some(indices), LINE_STRIP));
    }
    let segments: usize = parts.iter().map(|(start, end)| end - start - 1).sum();
    let form =
        format!("{} of {}", counted(primitives.len(), "line strip[|s]"), counted(segments, "segment[|s]"));
    Ok(Shaped::plain(primitives, frame, form))
}

/// The fingerprint of the points as they are written.
pub(super) fn shown_by(points: &[Point], frame: &Frame) -> String {
    fingerprint(points.iter().map(|p| frame.position(p)))
}

/// What each frame adds to the points, as accessors of morph targets. `frame` gives the points of a frame, in the order
/// of `points`.
pub(super) fn targets<'a>(
    points: &[Point],
    shaped: &Shaped,
    frames: usize,
    frame: impl Fn(usize) -> Result<Vec<Point>, Error>,
    bin: &mut Bin<'a>,
) -> Result<Vec<BTreeMap<&'static str, usize>>, FormatError> {
    let at = shaped.frame;
    let mut targets = Vec::with_capacity(frames);
    for k in 0..frames {
        let moved = frame(k)?;
        let sources = (0..points.len()).chain(shaped.doubled.iter().map(|&p| p as usize));
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let mut moves = Vec::with_capacity(points.len() + shaped.doubled.len());
        for i in sources {
            let (Some(p), Some(q)) = (points.get(i), moved.get(i)) else { continue };
            // From what is written, so that the sum is the frame to rounding.
            let base = Vector::from(at.position(p).map(f64::from));
            let delta = single(at.moved(q) - at.centre - base);
            if !delta.iter().all(|x| x.is_finite()) {
                return Err(
                    Error::Invalid(format!("point {i} of frame {k} is beyond single precision")).into()
                );
            }
            for axis in 0..3 {
                (low[axis], high[axis]) = (low[axis].min(delta[axis]), high[axis].max(delta[axis]));
            }
            moves.push(delta);
        }
        let bounds = Some([low.to_vec(), high.to_vec()]);
        let mut target = BTreeMap::from([("POSITION", differences(bin, moves, bounds)?)]);
        if let Some(Turning { mesh, of, short }) = &shaped.turning {
            let turned = mesh.moved(moved)?;
            let delta = |(point, &normal): (usize, &u32)| {
                let is_short = short.get(point).is_some_and(|short| *short);
                let written = |n: &Vector| if is_short { at.short_normal(n) } else { at.normal(n) };
                let normal = |mesh: &Mesh| mesh.normals.values().get(normal as usize).map(written);
                let (Some(from), Some(to)) = (normal(mesh), normal(&turned)) else { return [0.0; 3] };
                single(Vector::from(to.map(f64::from)) - Vector::from(from.map(f64::from)))
            };
            target.insert(NORMAL, differences(bin, of.iter().enumerate().map(delta).collect(), None)?);
        }
        targets.push(target);
    }
    Ok(targets)
}

/// What a morph target adds to each point: all of it, or, where that is less, what is not zero.
fn differences<'a>(
    bin: &mut Bin<'a>,
    all: Vec<[f32; 3]>,
    bounds: Option<[Vec<f32>; 2]>,
) -> io::Result<usize> {
    let some: Vec<(u32, [f32; 3])> =
        (0..).zip(&all).filter(|(_, d)| **d != [0.0; 3]).map(|(i, d)| (i, *d)).collect();
    // 12 bytes a value, up to 4 an index, and some 200 of text.
    if 16 * some.len() + 200 < 12 * all.len() || some.is_empty() {
        return Ok(bin.sparse(all.len(), bounds, &some));
    }
    values(bin, Cow::Owned(all), Kind::floats(3), Use::Vertices, bounds, |d, out| put(*d, out))
}
