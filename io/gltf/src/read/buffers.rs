//! Where the bytes are: the BIN chunk, data URIs, files beside the document.

use std::borrow::Cow;
use std::collections::HashMap;

use base64::Engine as _;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use loftsman_kernel::plugin::{FormatError, FormatErrorKind, Source};

use super::file::{File, clip};
use super::schema::{Buffer, Raw};

/// The bytes of every buffer, or why they are not there. Buffers of the same file share its bytes.
pub(super) struct Buffers<'a> {
    resources: Vec<Cow<'a, [u8]>>,
    /// The resource of each buffer, and how many of its bytes are the buffer's.
    buffers: Vec<Result<(usize, usize), String>>,
}

/// Base 64 as writers have it: with padding or without.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

impl<'a> Buffers<'a> {
    /// Reads all buffers. What is missing is an error only where it is needed.
    pub(super) fn load(buffers: &[Buffer<'a>], binary: Option<&'a [u8]>, source: &'a dyn Source) -> Self {
        let mut all = Self { resources: Vec::new(), buffers: Vec::with_capacity(buffers.len()) };
        let mut files: HashMap<String, usize> = HashMap::new();
        for (i, buffer) in buffers.iter().enumerate() {
            let found = match (buffer.uri, binary) {
                (Some(uri), _) => all.resource(uri, source, &mut files),
                (None, Some(binary)) if i == 0 => {
                    all.resources.push(Cow::Borrowed(binary));
                    Ok((all.resources.len() - 1, "the BIN chunk".to_owned()))
                }
                (None, _) => Err("it has no uri, and there is no BIN chunk for it".to_owned()),
            };
            let length = buffer.byte_length.index();
            let found = found.and_then(|(resource, what)| match all.resources[resource].len() {
                has if has < length => {
                    Err(format!("it says {length} bytes, but {what} has only {has}: get the file again"))
                }
                _ => Ok((resource, length)),
            });
            all.buffers.push(found);
        }
        all
    }

    /// The number of bytes in all of them.
    pub(super) fn len(&self) -> u64 {
        self.resources.iter().map(|b| b.len() as u64).sum()
    }

    /// The resource that a URI stands for, and what to call it.
    fn resource(
        &mut self,
        uri: Raw<'a>,
        source: &'a dyn Source,
        files: &mut HashMap<String, usize>,
    ) -> Result<(usize, String), String> {
        let text = string(uri)?;
        if let Some((_, bytes)) = data(&text)? {
            self.resources.push(Cow::Owned(bytes));
            return Ok((self.resources.len() - 1, "its data URI".to_owned()));
        }
        let name = relative(&text)?;
        let what = format!("the file \"{}\"", clip(&name));
        if let Some(&known) = files.get(&name) {
            return Ok((known, what));
        }
        self.resources.push(source.sibling(&name).map_err(|e| e.problem)?);
        files.insert(name, self.resources.len() - 1);
        Ok((self.resources.len() - 1, what))
    }
}

/// The text of a JSON string.
pub(super) fn string(raw: Raw<'_>) -> Result<Cow<'_, str>, String> {
    let text = raw.get();
    // Most strings escape nothing, and data URIs may be most of the file.
    if let Some(plain) = text.strip_prefix('"').and_then(|t| t.strip_suffix('"'))
        && !plain.contains('\\')
    {
        return Ok(Cow::Borrowed(plain));
    }
    serde_json::from_str(text).map(Cow::Owned).map_err(|_| "a uri must be a text".to_owned())
}

/// The media type and the bytes of a data URI; `None` for another URI.
pub(super) fn data(uri: &str) -> Result<Option<(String, Vec<u8>)>, String> {
    let Some((scheme, rest)) = uri.split_at_checked(5) else { return Ok(None) };
    if !scheme.eq_ignore_ascii_case("data:") {
        return Ok(None);
    }
    let Some((kind, bytes)) = rest.split_once(',') else {
        return Err("the data URI has no comma, after which its bytes would come".to_owned());
    };
    let media_type = kind.split(';').next().unwrap_or_default().to_ascii_lowercase();
    if !kind.rsplit(';').next().is_some_and(|k| k.eq_ignore_ascii_case("base64")) {
        return Ok(Some((media_type, percent_decoded(bytes)?)));
    }
    let bytes = BASE64.decode(bytes).map_err(|e| format!("the data URI is not base 64: {e}"))?;
    Ok(Some((media_type, bytes)))
}

/// The name of the file that a relative URI stands for.
pub(super) fn relative(uri: &str) -> Result<String, String> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme);
    let scheme = scheme.filter(|s| s.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c)));
    if scheme.is_some() || uri.starts_with("//") {
        let shown = clip(uri);
        return Err(format!("\"{shown}\" is not beside the file: copy it there and name it without a path"));
    }
    let bytes = percent_decoded(uri)?;
    String::from_utf8(bytes).map_err(|_| format!("\"{}\" is not UTF-8", clip(uri)))
}

fn percent_decoded(text: &str) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            out.push(byte);
            continue;
        }
        let mut digit = || rest.next().and_then(|b| char::from(b).to_digit(16));
        let (Some(high), Some(low)) = (digit(), digit()) else {
            return Err(format!("\"{}\" has a % without two hexadecimal digits", clip(text)));
        };
        out.push((high * 16 + low) as u8);
    }
    Ok(out)
}

/// The bytes of a buffer view, and how far apart it says that elements are.
pub(super) struct View<'f> {
    pub(super) bytes: &'f [u8],
    pub(super) stride: Option<usize>,
}

impl File<'_> {
    /// A buffer view.
    pub(super) fn view(&self, index: usize) -> Result<View<'_>, FormatError> {
        let views = &self.root.buffer_views;
        let Some(view) = views.get(index) else {
            return Err(self.missing("bufferViews", index, views.len()));
        };
        let path = || format!("bufferViews[{index}]");
        if view.extensions.as_ref().is_some_and(|e| e.contains_key("EXT_meshopt_compression")) {
            let problem = "its bytes are compressed (EXT_meshopt_compression), which is not read: write the file again \
                           without compression (gltf-transform: `gltf-transform copy in.glb out.glb`)";
            return Err(self.fail(path(), problem).as_kind(FormatErrorKind::Unsupported));
        }
        let buffer = view.buffer.index();
        let bytes = match self.buffers.buffers.get(buffer) {
            Some(Ok((resource, length))) => &self.buffers.resources[*resource][..*length],
            Some(Err(problem)) => return Err(self.fail(format!("buffers[{buffer}]"), problem.clone())),
            None => return Err(self.missing("buffers", buffer, self.buffers.buffers.len())),
        };
        let (start, length) = (view.byte_offset.index(), view.byte_length.index());
        let stride = match view.byte_stride {
            None => None,
            Some(stride) if (1..=252).contains(&stride.0) => Some(stride.index()),
            Some(stride) => {
                let problem = format!("a stride of {} bytes; it must be 4 to 252", stride.0);
                return Err(self.fail(format!("{}.byteStride", path()), problem));
            }
        };
        match start.checked_add(length).and_then(|end| bytes.get(start..end)) {
            Some(bytes) => Ok(View { bytes, stride }),
            None => {
                let problem = format!(
                    "it takes {length} bytes from byte {start}, but buffers[{buffer}] has only {}",
                    bytes.len()
                );
                Err(self.fail(path(), problem))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_data_or_stay_in_the_folder() {
        let (kind, bytes) = data("data:application/gltf-buffer;base64,AAEC/w").unwrap().unwrap();
        assert_eq!((kind.as_str(), bytes.as_slice()), ("application/gltf-buffer", [0, 1, 2, 255].as_slice()));
        assert_eq!(data("DATA:;BASE64,AAEC/w==").unwrap().unwrap().1, [0, 1, 2, 255]);
        assert_eq!(data("data:text/plain,a%20b").unwrap().unwrap().1, b"a b");
        assert_eq!(data("a.bin").unwrap(), None);
        assert!(data("data:;base64").unwrap_err().contains("comma"));
        assert!(data("data:;base64,!").unwrap_err().contains("not base 64"));
        assert_eq!(relative("m%C3%BC%2520.bin").unwrap(), "mü%20.bin");
        for bad in ["http://x/a.bin", "file:///a", "C:/a.bin", "//host/a"] {
            assert!(relative(bad).unwrap_err().contains("beside"), "{bad}");
        }
        assert!(relative("a%2").is_err() && relative("%ff").is_err());
    }
}
