//! Accessors: typed elements in buffer views, checked against their bounds before anything is read.

use loftsman_kernel::plugin::FormatError;

use super::file::File;

/// The type of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of some bytes. Normalised integers are fractions of the largest one (glTF 2.0, §3.6.2.2).
    fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let (value, largest) = match (self, bytes) {
            (Self::I8, &[a, ..]) => (f64::from(a as i8), 127.0),
            (Self::U8, &[a, ..]) => (f64::from(a), 255.0),
            (Self::I16, &[a, b, ..]) => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b, ..]) => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::U32, &[a, b, c, d, ..]) => (f64::from(u32::from_le_bytes([a, b, c, d])), 4_294_967_295.0),
            (Self::F32, &[a, b, c, d, ..]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
            // Lengths are checked before.
            _ => return 0.0,
        };
        if normalized { (value / largest).max(-1.0) } else { value }
    }
}

/// The elements of an accessor, all inside of their buffers.
pub(super) struct Elements<'f> {
    pub(super) index: usize,
    pub(super) count: usize,
    pub(super) components: usize,
    component: Component,
    normalized: bool,
    /// From the first element on; `None` for zeros.
    bytes: Option<&'f [u8]>,
    stride: usize,
    sparse: Option<Sparse<'f>>,
}

/// Elements that differ: their indices, ascending, and their values side by side.
struct Sparse<'f> {
    count: usize,
    index: Component,
    indices: &'f [u8],
    values: &'f [u8],
}

impl File<'_> {
    /// The elements of an accessor; `user` is who asks.
    pub(super) fn elements(&self, index: usize, user: &str) -> Result<Elements<'_>, FormatError> {
        let accessors = &self.root.accessors;
        let Some(accessor) = accessors.get(index) else {
            let error = self.missing("accessors", index, accessors.len());
            return Err(self.fail(user, format!("accessors[{index}]: {}", error.problem)));
        };
        let fail =
            |problem: String| self.fail(format!("accessors[{index}]"), format!("{problem} (used by {user})"));
        let Some(component) = Component::of(accessor.component_type.0) else {
            return Err(fail(format!("the componentType {} does not exist", accessor.component_type.0)));
        };
        let size = component.size();
        // Columns of matrices start at multiples of four bytes; nothing that is read here is a matrix.
        let components = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT2" | "MAT3" | "MAT4" => {
                return Err(fail(format!("elements of type {} cannot stand here", accessor.kind)));
            }
            other => return Err(fail(format!("the type \"{}\" does not exist", super::file::clip(other)))),
        };
        let width = components * size;
        let count = accessor.count.index();
        let offset = accessor.byte_offset.index();
        let (bytes, stride) = match accessor.buffer_view {
            None => (None, width),
            Some(view_index) => {
                let view = self.view(view_index.index())?;
                let stride = view.stride.unwrap_or(width);
                if stride < width {
                    return Err(fail(format!(
                        "its elements of {width} bytes overlap at a stride of {stride} (bufferViews[{}])",
                        view_index.0
                    )));
                }
                let needed = count
                    .saturating_sub(1)
                    .checked_mul(stride)
                    .and_then(|n| n.checked_add(if count == 0 { 0 } else { width })?.checked_add(offset));
                if needed.is_none_or(|needed| needed > view.bytes.len()) {
                    return Err(fail(format!(
                        "{count} elements of {width} bytes every {stride} from byte {offset} do not fit into \
                         bufferViews[{}] of {} bytes",
                        view_index.0,
                        view.bytes.len()
                    )));
                }
                (Some(&view.bytes[offset..]), stride)
            }
        };
        let sparse = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let changed = sparse.count.index();
                let index_type = match Component::of(sparse.indices.component_type.0) {
                    Some(kind @ (Component::U8 | Component::U16 | Component::U32)) => kind,
                    _ => {
                        let code = sparse.indices.component_type.0;
                        return Err(fail(format!("sparse indices cannot have the componentType {code}")));
                    }
                };
                let part = |view: usize, offset: usize, size: usize| -> Result<&[u8], FormatError> {
                    let bytes = self.view(view)?.bytes;
                    let end = changed.checked_mul(size).and_then(|n| n.checked_add(offset));
                    end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
                        fail(format!(
                            "{changed} sparse elements of {size} bytes from byte {offset} do not fit into \
                             bufferViews[{view}] of {} bytes",
                            bytes.len()
                        ))
                    })
                };
                let (i, v) = (&sparse.indices, &sparse.values);
                let indices = part(i.buffer_view.index(), i.byte_offset.index(), index_type.size())?;
                let values = part(v.buffer_view.index(), v.byte_offset.index(), width)?;
                Some(Sparse { count: changed, index: index_type, indices, values })
            }
        };
        let normalized = accessor.normalized;
        Ok(Elements { index, count, components, component, normalized, bytes, stride, sparse })
    }

    /// The elements of an accessor as vectors of `N` numbers; one that has fewer components is filled up with
    /// `fill`. `what` names the elements.
    pub(super) fn vectors<const N: usize>(
        &self,
        elements: &Elements<'_>,
        fill: f64,
        user: &str,
    ) -> Result<Vec<[f64; N]>, FormatError> {
        self.take(user, elements.count, 8 * N)?;
        let mut out = elements.read::<N>(fill);
        if let Some(sparse) = &elements.sparse {
            self.take(user, sparse.count, 8)?;
            let (size, width) = (sparse.index.size(), elements.component.size() * elements.components);
            let mut least = 0;
            for k in 0..sparse.count {
                let at = sparse.index.number(&sparse.indices[k * size..], false) as usize;
                // Ascending, so that no element is there twice.
                let Some(slot) = out.get_mut(at).filter(|_| at >= least) else {
                    let problem = if at < least {
                        format!("sparse index {k} is {at}, not above the one before it (used by {user})")
                    } else {
                        format!(
                            "sparse index {k} is {at}, but there are {} elements (used by {user})",
                            elements.count
                        )
                    };
                    return Err(self.fail(format!("accessors[{}].sparse.indices", elements.index), problem));
                };
                *slot = elements.element(&sparse.values[k * width..], fill);
                least = at + 1;
            }
        }
        Ok(out)
    }

    /// The elements of an accessor as indices below `limit`.
    pub(super) fn indices(&self, index: usize, limit: usize, user: &str) -> Result<Vec<u32>, FormatError> {
        let elements = self.elements(index, user)?;
        let fail = |problem: String| {
            let error = self.fail(format!("accessors[{index}]"), format!("{problem} (used by {user})"));
            Err(error)
        };
        let unsigned = matches!(elements.component, Component::U8 | Component::U16 | Component::U32);
        if elements.components != 1 || !unsigned {
            return fail("indices must be scalars of an unsigned type".to_owned());
        }
        self.take(user, elements.count, 4)?;
        // Whole numbers up to 2^32 are exact as doubles.
        let wide = self.vectors_of_indices(&elements, user)?;
        match wide.iter().position(|&i| i as usize >= limit) {
            None => Ok(wide),
            Some(at) => fail(format!("index {at} is {}, but there are only {limit} vertices", wide[at])),
        }
    }

    fn vectors_of_indices(&self, elements: &Elements<'_>, user: &str) -> Result<Vec<u32>, FormatError> {
        if elements.sparse.is_some() {
            let wide = self.vectors::<1>(elements, 0.0, user)?;
            return Ok(wide.into_iter().map(|[i]| i as u32).collect());
        }
        let Some(bytes) = elements.bytes else { return Ok(vec![0; elements.count]) };
        let (size, stride) = (elements.component.size(), elements.stride);
        let at = |k: usize| &bytes[k * stride..k * stride + size];
        Ok((0..elements.count)
            .map(|k| match *at(k) {
                [a] => u32::from(a),
                [a, b] => u32::from(u16::from_le_bytes([a, b])),
                [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
                _ => 0,
            })
            .collect())
    }
}

impl Elements<'_> {
    /// All elements, sparse ones not yet put in.
    fn read<const N: usize>(&self, fill: f64) -> Vec<[f64; N]> {
        let Some(bytes) = self.bytes else {
            let zeros = [0_u8; 16];
            return vec![self.element(&zeros, fill); self.count];
        };
        if self.component == Component::F32 && self.components == N {
            // By far the most files: no look at each component's type.
            let single = |b: &[u8]| b.try_into().map_or(0.0, |b| f64::from(f32::from_le_bytes(b)));
            let element = |k: usize| {
                let b = &bytes[k * self.stride..k * self.stride + 4 * N];
                std::array::from_fn(|i| single(&b[4 * i..4 * i + 4]))
            };
            return (0..self.count).map(element).collect();
        }
        (0..self.count).map(|k| self.element(&bytes[k * self.stride..], fill)).collect()
    }

    /// The element at the start of some bytes.
    fn element<const N: usize>(&self, bytes: &[u8], fill: f64) -> [f64; N] {
        let size = self.component.size();
        let mut out = [fill; N];
        for (i, slot) in out.iter_mut().enumerate().take(self.components) {
            *slot = self.component.number(&bytes[i * size..], self.normalized);
        }
        out
    }

    /// Treats integers as fractions of their largest, whatever the accessor says: colours and texture coordinates have
    /// no other meaning.
    pub(super) fn normalized(mut self) -> Self {
        self.normalized |= self.component != Component::F32;
        self
    }
}
