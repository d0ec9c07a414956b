//! Pictures that are SVG and PNG at once.

#![allow(clippy::unwrap_used, reason = "what cannot be drawn fails the test")]

use loftsman_picture::Picture;

/// The SVG of a picture of which there is a PNG, too: whatever is written, the renderer knows.
pub(crate) trait Drawn {
    fn drawn(&self) -> String;
}

impl Drawn for Picture<'_> {
    fn drawn(&self) -> String {
        self.to_png(64).unwrap();
        self.to_svg().unwrap()
    }
}
