//! The buffer, its views and accessors; and the two containers.

use loftsman_kernel::plugin::{FormatError, Place, Sink};

use crate::schema::{Accessor, Buffer, BufferView, Root};

const VERTICES: u16 = 34962;
const INDICES: u16 = 34963;

/// The bytes that accessors refer to, all in one buffer.
#[derive(Debug, Default)]
pub(crate) struct Binary {
    pub(crate) bytes: Vec<u8>,
    pub(crate) views: Vec<BufferView>,
    pub(crate) accessors: Vec<Accessor>,
}

impl Binary {
    /// An accessor of vectors of `N` floats; with `bounds`, its least and largest components, as positions need.
    pub(crate) fn floats<const N: usize>(&mut self, values: &[[f32; N]], bounds: bool) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N.min(4)];
        let start = self.bytes.len();
        self.bytes.reserve(values.len() * N * 4);
        let (mut min, mut max) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        for value in values {
            for (i, &x) in value.iter().enumerate() {
                self.bytes.extend_from_slice(&x.to_le_bytes());
                (min[i], max[i]) = (min[i].min(x), max[i].max(x));
            }
        }
        let list = |ends: [f32; N]| if bounds { ends.map(f64::from).to_vec() } else { Vec::new() };
        self.accessor(start, VERTICES, 5126, values.len(), kind, list(min), list(max))
    }

    /// An accessor of indices into `vertices` vertices: 16 bits wide where they fit (the largest 16-bit index is
    /// not one: it restarts primitives).
    pub(crate) fn indices(&mut self, values: &[u32], vertices: usize) -> usize {
        let start = self.bytes.len();
        let narrow = vertices <= usize::from(u16::MAX);
        for &index in values {
            if narrow {
                self.bytes.extend_from_slice(&(index as u16).to_le_bytes());
            } else {
                self.bytes.extend_from_slice(&index.to_le_bytes());
            }
        }
        let component = if narrow { 5123 } else { 5125 };
        self.accessor(start, INDICES, component, values.len(), "SCALAR", Vec::new(), Vec::new())
    }

    #[allow(clippy::too_many_arguments, reason = "the fields of an accessor, set in one place")]
    fn accessor(
        &mut self,
        start: usize,
        target: u16,
        component_type: u16,
        count: usize,
        kind: &'static str,
        min: Vec<f64>,
        max: Vec<f64>,
    ) -> usize {
        let byte_length = self.bytes.len() - start;
        self.views.push(BufferView { buffer: 0, byte_offset: start, byte_length, target });
        // Every view starts at a multiple of four, as floats need.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let buffer_view = self.views.len() - 1;
        self.accessors.push(Accessor { buffer_view, component_type, count, kind, min, max });
        self.accessors.len() - 1
    }
}

/// Writes the document: a `.gltf` with a `.bin` beside it, or else a `.glb`.
pub(crate) fn emit(mut root: Root, binary: Binary, sink: &mut dyn Sink) -> Result<(), FormatError> {
    let file = sink.name().to_owned();
    let fail = |problem: String| FormatError::new(&file, Place::File, problem);
    let io = |e: std::io::Error| fail(format!("it cannot be written: {e}"));
    let text = file.to_lowercase().ends_with(".gltf");
    root.accessors = binary.accessors;
    root.buffer_views = binary.views;
    let sibling = format!("{}.bin", &file[..file.len() - if text { ".gltf".len() } else { 0 }]);
    if !binary.bytes.is_empty() {
        let uri = text.then(|| percent_encoded(&sibling));
        root.buffers.push(Buffer { uri, byte_length: binary.bytes.len() });
    }
    let json = |root: &Root, pretty: bool| {
        let result = if pretty { serde_json::to_vec_pretty(root) } else { serde_json::to_vec(root) };
        result.map_err(|e| fail(format!("it cannot be written: {e}")))
    };
    if text {
        sink.main().write_all(&json(&root, true)?).map_err(io)?;
        if !binary.bytes.is_empty() {
            sink.sibling(&sibling)?.write_all(&binary.bytes).map_err(io)?;
        }
        return Ok(());
    }
    // Header, then chunks of a length, a type and bytes padded to four: JSON with blanks, BIN with zeros.
    let mut json = json(&root, false)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let bin = if binary.bytes.is_empty() { 0 } else { 8 + binary.bytes.len() };
    let total = 12 + 8 + json.len() + bin;
    let too_large = || fail(format!("{total} bytes are more than a .glb file can have: write several files"));
    let length = |n: usize| u32::try_from(n).map_err(|_| too_large());
    length(total)?;
    let out = sink.main();
    let mut put = |bytes: &[u8]| out.write_all(bytes).map_err(io);
    put(b"glTF")?;
    put(&2_u32.to_le_bytes())?;
    put(&length(total)?.to_le_bytes())?;
    put(&length(json.len())?.to_le_bytes())?;
    put(b"JSON")?;
    put(&json)?;
    if bin > 0 {
        put(&length(binary.bytes.len())?.to_le_bytes())?;
        put(b"BIN\0")?;
        put(&binary.bytes)?;
    }
    Ok(())
}

/// A file name as a URI: everything but letters, digits and `-._~` as `%XX` (RFC 3986).
fn percent_encoded(name: &str) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            out.push(char::from(byte));
        } else {
            _ = write!(out, "%{byte:02X}");
        }
    }
    out
}
