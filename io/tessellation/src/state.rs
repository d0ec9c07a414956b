//! A surface in one state of an animation, or the only one.

use loftsman_kernel::Result;
use loftsman_kernel::spline::Surface;

use crate::fineness::Frame;
use crate::patch::Patches;

/// A surface in one state, in its own frame.
pub(crate) struct State<'a> {
    pub(crate) frame: Frame,
    pub(crate) patches: Patches<'a>,
    /// The same in the surface's own coordinates.
    pub(crate) own: Patches<'a>,
}

impl<'a> State<'a> {
    pub(crate) fn new(surface: &'a Surface) -> Result<Self> {
        let frame = Frame::of(surface.points())?;
        Ok(Self {
            patches: Patches::new(surface, &frame),
            own: Patches::new(surface, &Frame::absolute()),
            frame,
        })
    }
}
