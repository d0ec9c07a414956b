//! Point files: rows of coordinates in text, as airfoil collections, measuring machines and spreadsheets keep
//! them.
//!
//! | what is recognised | by what | becomes |
//! |---|---|---|
//! | AeroDyn / OpenFAST airfoil coordinates | a line `201 NumCoords ! …` | polyline; the first row, the reference point, is left out |
//! | Lednicer airfoil | a row `17. 17.` that counts the rows of two surfaces | polyline: upper trailing edge, nose, lower trailing edge |
//! | Selig airfoil | two columns from the trailing edge around the nose and back | polyline |
//! | Tecplot | `ZONE` headers | a polyline a zone |
//! | csv | columns separated by `,` or `;`, a header line or none | polyline |
//! | xyz, text | columns separated by blanks or tabs | polyline; cloud in `.xyz`, `.asc` and `.pts` |
//! | files written here | a comment `# loftsman points …` | polylines and clouds, as they were |
//!
//! The option `as` (`"polyline"` or `"cloud"`) decides otherwise. A file is one object but for headings, zones and
//! files written here, which name several; its name is the name line's, or the file's without its extension.
//!
//! * Two columns are x and y, z is 0. A header that names x, y (and z) chooses the columns; other columns are
//!   left out, and counted in the report.
//! * A polyline whose last row repeats its first is closed, and the repeated row is left out. An open trailing
//!   edge stays open.
//! * Numbers may have Fortran exponents (`1.0D-3`). A comma is a decimal sign only where it cannot separate
//!   columns: between `;`, or between blanks and with digits on both its sides.
//! * Comments start with `#`, `!`, `%` or `//`. Text may stand before the first row; below rows it is the heading of what
//!   follows, where that is two rows or more (an object of its own), or a footnote, which is left out.
//! * A Lednicer file whose counts do not fit is read by its blank lines, or by where x falls back to the leading edge.
//! * Names are UTF-8, else Windows-1252 or code page 437 (DOS), as the letters and signs fit in better: the report says which.
//! * Coordinates are taken as metres, z up, unless the options say otherwise: the files do not tell.
//!
//! In the read report an entity is a row, or a column that is left out.

mod format;
mod marks;
mod read;
mod write;

pub use format::{Points, Points as Plugin};
