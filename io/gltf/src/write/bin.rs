//! The buffer, its views and accessors; and the two containers.
//!
//! The JSON comes before the bytes and says how many there are. So what goes into the buffer is planned first, and
//! poured out afterwards, straight from the scene: nothing that is borrowed is copied in between.

use std::io::{self, BufWriter, Write};

use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Sink};

use super::schema::{Accessor, Buffer, BufferView, Root, Sparse, SparseIndices, SparseValues};

/// Where bytes are poured.
pub(super) type Out<'o> = BufWriter<&'o mut dyn Write>;

/// Pours the bytes of a part of the buffer.
pub(super) type Pour<'a> = Box<dyn Fn(&mut Out<'_>) -> io::Result<()> + 'a>;

/// Bytes that are gathered before they are passed on.
const GATHERED: usize = 1 << 16;

enum Section<'a> {
    Bytes(Vec<u8>),
    Pour(Pour<'a>),
}

/// What the bytes of a view are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Vertices,
    Indices,
    /// Times, weights, pictures.
    Other,
}

/// The bytes that accessors refer to, all in one buffer.
#[derive(Default)]
pub(super) struct Bin<'a> {
    sections: Vec<Section<'a>>,
    pub(super) length: usize,
    views: Vec<BufferView>,
    accessors: Vec<Accessor>,
}

/// The type of an accessor's elements.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    /// The code of the component type, and its size.
    component: (u16, usize),
    name: &'static str,
    components: usize,
}

impl Kind {
    /// Vectors of so many floats.
    pub(super) const fn floats(components: usize) -> Self {
        let name = match components {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            _ => "VEC4",
        };
        Self { component: (5126, 4), name, components }
    }

    /// Indices of so many vertices: 16 bits wide where they fit (the largest 16-bit index is none: it restarts
    /// primitives).
    pub(super) fn indices(vertices: usize) -> Self {
        let component = if vertices <= usize::from(u16::MAX) { (5123, 2) } else { (5125, 4) };
        Self { component, name: "SCALAR", components: 1 }
    }

    /// Whether indices have 16 bits.
    pub(super) fn is_narrow(self) -> bool {
        self.component.1 == 2
    }
}

impl<'a> Bin<'a> {
    /// A view of `length` bytes that `pour` pours: later where it may borrow from the scene, at once into memory where
    /// it `keep`s nothing alive.
    fn view(&mut self, length: usize, used: Use, section: Section<'a>) -> usize {
        let target = match used {
            Use::Vertices => Some(34962),
            Use::Indices => Some(34963),
            Use::Other => None,
        };
        self.views.push(BufferView { buffer: 0, byte_offset: self.length, byte_length: length, target });
        self.sections.push(section);
        // Every view starts at a multiple of four, as floats need.
        self.length += length.next_multiple_of(4);
        self.views.len() - 1
    }

    /// A view of bytes as they are.
    pub(super) fn bytes(&mut self, bytes: &'a [u8]) -> usize {
        self.view(bytes.len(), Use::Other, Section::Pour(Box::new(|out| out.write_all(bytes))))
    }

    /// A view of bytes that nothing lends.
    pub(super) fn owned(&mut self, bytes: Vec<u8>) -> usize {
        self.view(bytes.len(), Use::Other, Section::Bytes(bytes))
    }

    /// An accessor of elements that are poured when the file is written.
    pub(super) fn later(
        &mut self,
        kind: Kind,
        used: Use,
        count: usize,
        bounds: Option<[Vec<f32>; 2]>,
        pour: Pour<'a>,
    ) -> usize {
        let view = self.view(count * kind.component.1 * kind.components, used, Section::Pour(pour));
        self.accessor(kind, Some(view), count, bounds, None)
    }

    /// An accessor of elements that are poured into memory now, because what they come from does not last.
    pub(super) fn now(
        &mut self,
        kind: Kind,
        used: Use,
        count: usize,
        bounds: Option<[Vec<f32>; 2]>,
        pour: impl Fn(&mut Out<'_>) -> io::Result<()>,
    ) -> io::Result<usize> {
        let length = count * kind.component.1 * kind.components;
        let mut bytes = Vec::with_capacity(length);
        let mut out = BufWriter::with_capacity(GATHERED.min(length.max(1)), &mut bytes as &mut dyn Write);
        pour(&mut out)?;
        out.flush()?;
        drop(out);
        let view = self.view(length, used, Section::Bytes(bytes));
        Ok(self.accessor(kind, Some(view), count, bounds, None))
    }

    fn accessor(
        &mut self,
        kind: Kind,
        buffer_view: Option<usize>,
        count: usize,
        bounds: Option<[Vec<f32>; 2]>,
        sparse: Option<Sparse>,
    ) -> usize {
        // As doubles: the shortest text of a single is another double.
        let [min, max] = bounds.unwrap_or_default().map(|ends| ends.into_iter().map(f64::from).collect());
        let component_type = kind.component.0;
        let kind = kind.name;
        self.accessors.push(Accessor { buffer_view, component_type, count, kind, min, max, sparse });
        self.accessors.len() - 1
    }

    /// An accessor of `count` elements of which all but a few are zero: these alone are written, with their indices, which
    /// ascend.
    pub(super) fn sparse<const N: usize>(
        &mut self,
        count: usize,
        bounds: Option<[Vec<f32>; 2]>,
        elements: &[(u32, [f32; N])],
    ) -> usize {
        let kind = Kind::floats(N);
        // Nothing but zeros needs neither view nor elements, but there are readers that refuse it so.
        let zero = [(0, [0.0; N])];
        let elements = if elements.is_empty() { &zero[..] } else { elements };
        let narrow = count <= usize::from(u16::MAX);
        let index =
            |i: u32| if narrow { (i as u16).to_le_bytes().to_vec() } else { i.to_le_bytes().to_vec() };
        let indices = elements.iter().flat_map(|&(i, _)| index(i)).collect();
        let values = elements.iter().flat_map(|(_, v)| v.iter().flat_map(|x| x.to_le_bytes())).collect();
        let component_type = if narrow { 5123 } else { 5125 };
        let indices = SparseIndices { buffer_view: self.owned(indices), component_type };
        let values = SparseValues { buffer_view: self.owned(values) };
        let sparse = Some(Sparse { count: elements.len(), indices, values });
        self.accessor(kind, None, count, bounds, sparse)
    }

    /// Pours the whole buffer.
    fn pour(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = BufWriter::with_capacity(GATHERED, out);
        for (section, view) in self.sections.iter().zip(&self.views) {
            match section {
                Section::Bytes(bytes) => out.write_all(bytes)?,
                Section::Pour(pour) => pour(&mut out)?,
            }
            let length = view.byte_length;
            out.write_all(&[0; 3][..length.next_multiple_of(4) - length])?;
        }
        out.flush()
    }
}

/// Writes the document: a `.gltf` with a `.bin` beside it, or else a `.glb`.
pub(super) fn emit(mut root: Root, mut bin: Bin<'_>, sink: &mut dyn Sink) -> Result<(), FormatError> {
    let file = sink.name().to_owned();
    let text = is_text(&file);
    root.accessors = std::mem::take(&mut bin.accessors);
    root.buffer_views = bin.views.iter().map(|v| BufferView { ..*v }).collect();
    let sibling = format!("{}.bin", &file[..file.len() - if text { ".gltf".len() } else { 0 }]);
    if bin.length > 0 {
        let uri = text.then(|| percent_encoded(&sibling));
        root.buffers.push(Buffer { uri, byte_length: bin.length });
    }
    if text {
        sink.main().write_all(&serde_json::to_vec_pretty(&root).map_err(io::Error::from)?)?;
        if bin.length > 0 {
            bin.pour(sink.sibling(&sibling)?)?;
        }
        return Ok(());
    }
    // Header, then chunks of a length, a type and bytes padded to four: JSON with blanks, BIN with zeros.
    let mut json = serde_json::to_vec(&root).map_err(io::Error::from)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = if bin.length == 0 { 0 } else { 8 + bin.length };
    let total = 12 + 8 + json.len() + chunk;
    let too_large = || {
        let problem = format!("{total} bytes are more than a .glb file can have: write several files");
        FormatError::whole(problem).as_kind(FormatErrorKind::Limit)
    };
    let length = |n: usize| u32::try_from(n).map(u32::to_le_bytes).map_err(|_| too_large());
    let out = sink.main();
    out.write_all(&[*b"glTF", 2_u32.to_le_bytes(), length(total)?].concat())?;
    out.write_all(&[length(json.len())?, *b"JSON"].concat())?;
    out.write_all(&json)?;
    if chunk > 0 {
        out.write_all(&[length(bin.length)?, *b"BIN\0"].concat())?;
        bin.pour(out)?;
    }
    Ok(())
}

/// Whether a file of this name is text with its bytes beside it.
pub(super) fn is_text(file: &str) -> bool {
    file.to_lowercase().ends_with(".gltf")
}

/// A relative path as a URI: everything but letters, digits and `-._~/` as `%XX` (RFC 3986).
pub(super) fn percent_encoded(name: &str) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            out.push(char::from(byte));
        } else {
            _ = write!(out, "%{byte:02X}");
        }
    }
    out
}
