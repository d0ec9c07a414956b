//! Pictures of scenes for people: curves with control polygons, curvature combs and knots, surfaces, meshes,
//! polylines and clouds, what an edit was asked, before and after, as SVG and as PNG.
//!
//! ```
//! use loftsman_kernel::scene::{Object, Scene};
//! use loftsman_kernel::{Point, spline::Curve};
//! use loftsman_picture::{Combs, Picture};
//!
//! let arch = Curve::bezier(vec![Point::new(0.0, 0.0, 0.0), Point::new(1.0, 2.0, 0.0), Point::new(2.0, 0.0, 0.0)])?;
//! let mut scene = Scene::new();
//! scene.add(Object::new("arch", (&arch).into()))?;
//!
//! let picture = Picture::of(&scene).title("An arch").combs(Combs::Automatic);
//! let svg: String = picture.to_svg()?;
//! let png: Vec<u8> = picture.to_png(800)?;
//! # assert!(svg.contains("An arch") && png.starts_with(b"\x89PNG"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A picture may have several panels: the scene from several sides, some of its objects, the curvature of its curves
//! as a chart.
//!
//! The way through the crate, each step in its own module: `stage` brings scenes into the coordinates of a view
//! (x right, y up, z towards the viewer, about one unit large); `page` arranges the panels and `layout` finds where
//! things go in them; the modules of `draw` put one kind of thing each on a `sheet`, `chart` draws profiles; `svg`
//! writes it all and `raster` renders it. Nothing
//! reads fonts, files or clocks: the same scene gives the same bytes, also on a machine without fonts.

mod chain;
mod chart;
mod choices;
mod depth;
mod draw;
mod error;
mod film;
mod labels;
mod layout;
mod page;
mod panel;
mod path;
mod picture;
mod raster;
mod render;
mod sheet;
mod stage;
mod svg;
mod text;
mod theme;
mod traces;
mod view;

pub use choices::{Beads, Combs, Curvature, Faces, Frames};
pub use error::PictureError;
pub use panel::{Against, Panel};
pub use picture::Picture;
pub use raster::WIDEST;
pub use theme::Theme;
pub use view::View;
