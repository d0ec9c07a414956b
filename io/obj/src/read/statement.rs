//! The statements of OBJ.

/// Statements whose meaning depends on what came before, or whose meaning changes what comes after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Known {
    Object,
    Group,
    Smoothing,
    Material,
    Library,
    Cstype,
    Deg,
    Bmat,
    Step,
    Curv,
    Curv2,
    Surf,
    Parm,
    Trim,
    Hole,
    Scrv,
    Sp,
    End,
    Con,
    /// Vertex colours in comments, as ZBrush writes them.
    Mrgb,
    /// What was noted here in comments.
    Ours,
}

const KNOWN: &[(&[u8], Known)] = &[
    (b"o", Known::Object),
    (b"g", Known::Group),
    (b"s", Known::Smoothing),
    (b"usemtl", Known::Material),
    (b"mtllib", Known::Library),
    (b"cstype", Known::Cstype),
    (b"deg", Known::Deg),
    (b"bmat", Known::Bmat),
    (b"step", Known::Step),
    (b"curv", Known::Curv),
    (b"curv2", Known::Curv2),
    (b"surf", Known::Surf),
    (b"parm", Known::Parm),
    (b"trim", Known::Trim),
    (b"hole", Known::Hole),
    (b"scrv", Known::Scrv),
    (b"sp", Known::Sp),
    (b"end", Known::End),
    (b"con", Known::Con),
];

/// Statements that say how something is shown or tessellated, not what it is.
pub(crate) const DISPLAY: &[&[u8]] = &[
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"maplib",
    b"usemap",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"mg",
];

/// Free-form statements of version 2.11, which version 3.0 gave up, and statements that run other files.
pub(crate) const OBSOLETE: &[&[u8]] = &[b"bsp", b"bzp", b"cdc", b"cdp", b"res", b"call", b"csh"];

/// What a keyword means.
pub(crate) fn known(word: &[u8]) -> Option<Known> {
    KNOWN.iter().find(|(name, _)| *name == word).map(|(_, known)| *known)
}
