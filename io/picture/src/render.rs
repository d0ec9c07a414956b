//! A picture as a file's bytes.

use crate::error::PictureError;
use crate::page;
use crate::picture::Picture;
use crate::raster;

impl Picture<'_> {
    /// The picture as an SVG document.
    ///
    /// Linear in the size of the scene; the document stays within what can be seen: chains are thinned out where
    /// the eye could not tell, and what is left out is noted under the legend.
    ///
    /// # Errors
    /// When the hierarchy is cyclic, a transform overflows, an option is out of its range, a panel names an object
    /// that is not there, or a curvature profile has no curve.
    pub fn to_svg(&self) -> Result<String, PictureError> {
        self.check()?;
        page::compose(self)
    }

    /// The picture as a PNG image of this many pixels across (1 to 16384).
    ///
    /// # Errors
    /// As for [`to_svg`](Self::to_svg), and when the image would be too large.
    pub fn to_png(&self, width: u32) -> Result<Vec<u8>, PictureError> {
        raster::render(&self.to_svg()?, width)
    }
}
