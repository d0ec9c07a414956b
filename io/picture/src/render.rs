//! A picture as a file's bytes.

use std::collections::BTreeSet;

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
        Ok(self.to_png_noted(width)?.0)
    }

    /// The picture as [`to_png`](Self::to_png) makes it, and a note for each text with letters that its font lacks: these are
    /// drawn as boxes. An SVG leaves them to the fonts of who shows it.
    ///
    /// # Errors
    /// As for [`to_png`](Self::to_png).
    pub fn to_png_noted(&self, width: u32) -> Result<(Vec<u8>, Vec<String>), PictureError> {
        let (png, lacking) = raster::render(&self.to_svg()?, width)?;
        let note = |(words, letters): (String, BTreeSet<char>)| {
            let letters: Vec<String> = letters.iter().map(|letter| format!("{letter:?}")).collect();
            format!(
                "the text {words:?} has letters that the font of PNG pictures lacks, drawn as boxes: {}; an SVG shows them",
                letters.join(", ")
            )
        };
        Ok((png, lacking.into_iter().map(note).collect()))
    }
}
