//! What `plot` takes.

use std::path::PathBuf;

use crate::picture::{Against, FACE_WORDS, Faces, PIXELS, View, WIDEST};
use clap::{Args, ValueEnum, ValueHint};

use super::{Json, positive};

#[derive(Debug, Args)]
pub(crate) struct PlotArgs {
    /// The file to draw; - for the standard input.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// The picture: .svg or .png; with #### in its name one for each frame.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// From where the scene is seen; several, with commas, make a sheet of panels, `all` is
    /// top,perspective,front,right [default: square on where it is planar, else isometric].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VIEW,…")]
    pub(crate) view: Vec<Seen>,
    /// Add a chart of curvature along the curves, against arc length or the parameter.
    #[arg(long, value_enum, value_name = "AGAINST", num_args = 0..=1, require_equals = true, default_missing_value = "arc-length")]
    pub(crate) profile: Option<Along>,
    /// Show the scene of this file too, lighter: how it was before.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) before: Option<PathBuf>,
    /// Only this object; may be repeated.
    #[arg(long = "object", value_name = "NAME")]
    pub(crate) objects: Vec<String>,
    /// A line above the picture.
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Show frames of animations in the drawing: a few dashed, or N evenly spread, the fainter the earlier.
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub(crate) frames: Option<Option<u16>>,
    /// Show N frames of animations side by side, from the first to the last.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=100), conflicts_with_all = ["frames", "before"])]
    pub(crate) film: Option<u16>,
    /// Show the segments of curves dark and light in turn.
    #[arg(long)]
    pub(crate) segments: bool,
    /// Write parameters beside curves and those of lines of equal u and v on surfaces, and the numbers of vertices of meshes, polylines and cages: what
    /// recipes take.
    #[arg(long)]
    pub(crate) parameters: bool,
    /// What the colours of faces show: shaded, zebra, mean, gaussian, maximum or minimum curvature, or deviation (from
    /// --before).
    #[arg(long, value_name = "WHAT", value_parser = faces)]
    pub(crate) faces: Option<Faces>,
    /// Show arrows from control vertices before to where they are.
    #[arg(long, requires = "before")]
    pub(crate) movements: bool,
    /// Light on dark.
    #[arg(long)]
    pub(crate) dark: bool,
    /// Draw curvature combs, of surfaces on some lines of equal parameter, where there are faces too; in a scene of curves alone they
    /// are drawn anyway.
    #[arg(long, conflicts_with = "no_combs")]
    pub(crate) combs: bool,
    /// The same, a tooth this times the curvature long [default: as fits].
    #[arg(long, value_name = "SCALE", value_parser = positive, conflicts_with = "no_combs")]
    pub(crate) comb_scale: Option<f64>,
    /// Leave out the curvature combs.
    #[arg(long)]
    pub(crate) no_combs: bool,
    /// This many beads in each knot span, uniform in the parameter, instead of one at each knot.
    #[arg(long, value_name = "N", conflicts_with = "no_knots")]
    pub(crate) beads: Option<u16>,
    /// Leave out the beads at the knots.
    #[arg(long)]
    pub(crate) no_knots: bool,
    /// Draw control polygons and nets, however many control vertices there are, and of trimmed surfaces.
    #[arg(long, conflicts_with = "no_polygons")]
    pub(crate) polygons: bool,
    /// Leave out the control polygons and nets.
    #[arg(long)]
    pub(crate) no_polygons: bool,
    /// Leave out legend, axes and scale bar.
    #[arg(long)]
    pub(crate) no_legend: bool,
    /// Panels in a row [default: by their number and shape].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) columns: Option<u16>,
    /// The width of the page in millimetres [default: 180].
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(crate) width: Option<f64>,
    /// The greatest height of a drawing in millimetres [default: two thirds of the width].
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub(crate) height: Option<f64>,
    /// The width of a PNG.
    #[arg(long, value_name = "N", default_value_t = PIXELS, value_parser = clap::value_parser!(u32).range(1..=i64::from(WIDEST)))]
    pub(crate) pixels: u32,
    #[command(flatten)]
    pub(crate) json: Json,
}

/// What faces show, by its name.
fn faces(text: &str) -> Result<Faces, String> {
    let found = FACE_WORDS.iter().find(|(word, _)| *word == text);
    found.map(|(_, faces)| *faces).ok_or_else(|| {
        let words: Vec<&str> = FACE_WORDS.iter().map(|(word, _)| *word).collect();
        format!("it is one of {}", words.join(", "))
    })
}

/// From where a scene is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Seen {
    Automatic,
    Front,
    Top,
    Right,
    Isometric,
    Perspective,
    All,
}

impl Seen {
    /// The views with their captions.
    pub(crate) fn views(self) -> Vec<(&'static str, View)> {
        match self {
            Self::Automatic => vec![("", View::Automatic)],
            Self::Front => vec![("front", View::Front)],
            Self::Top => vec![("top", View::Top)],
            Self::Right => vec![("right", View::Right)],
            Self::Isometric => vec![("isometric", View::Isometric)],
            Self::Perspective => vec![("perspective", View::Perspective)],
            // As drawings are arranged: above the front is the top, to its right what is seen from there.
            Self::All => [Self::Top, Self::Perspective, Self::Front, Self::Right]
                .into_iter()
                .flat_map(Self::views)
                .collect(),
        }
    }
}

/// What curvature is drawn against.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Along {
    ArcLength,
    Parameter,
}

impl From<Along> for Against {
    fn from(along: Along) -> Self {
        match along {
            Along::ArcLength => Self::ArcLength,
            Along::Parameter => Self::Parameter,
        }
    }
}
