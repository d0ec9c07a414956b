//! `plot FILE OUT.svg|OUT.png`

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use crate::convert::Conversion;
use crate::file::{Content, Input, Outputs, Produced};
use crate::picture::{self, Beads, Combs, Faces, Frames, Look, Panel, View};
use loftsman_kernel::plugin::{ReadReport, Registry, Source};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::text::clip;

use super::report;
use crate::program::Usage;
use crate::program::args::PlotArgs;
use crate::program::console::{self, BOLD, bytes, styled};
use crate::program::progress::Progress;

/// What was drawn.
#[derive(serde::Serialize)]
struct Plotted<'a> {
    input: &'a str,
    format: &'static str,
    output: &'a str,
    bytes: u64,
    /// Of a sequence, the file of each frame.
    #[serde(skip_serializing_if = "<[Produced]>::is_empty")]
    frames: &'a [Produced],
    report: &'a ReadReport,
}

pub(crate) fn run(args: &PlotArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    if !picture::is_picture(&args.out) {
        return Err(Usage(format!("{}: a picture is .svg or .png", args.out.display())).into());
    }
    let sequence = super::convert::sequence(&args.out)?;
    if sequence.is_some() && (args.before.is_some() || args.film.is_some() || args.frames.is_some()) {
        let text =
            "each picture of a sequence shows one frame: leave out --before, --film and --frames, or the #";
        return Err(Usage(text.to_owned()).into());
    }
    if args.faces == Some(Faces::Deviation) && args.before.is_none() {
        let text =
            "--faces deviation shows how far things are from the state before: give it with --before FILE";
        return Err(Usage(text.to_owned()).into());
    }
    let mut outputs = Outputs::new();
    let progress = Progress::start();
    let (name, Content { scene, report: read, format }) =
        open(&args.file, &mut outputs, &progress, registry)?;
    let before =
        args.before.as_ref().map(|file| open(file, &mut outputs, &progress, registry)).transpose()?;
    match &sequence {
        Some(sequence) => outputs.claim(sequence.file(0))?,
        None => outputs.claim(&args.out)?,
    }
    let before = match before {
        Some((file, before)) => Some(paired(before.scene, &scene, (&file, &name), args.faces)?),
        None => None,
    };
    let before = before.as_ref();
    let look = look(args, &scene);
    let undrawn = if let Some(sequence) = &sequence {
        let frames = sequence.each(&scene, &progress, |file, moment| {
            let (image, undrawn) =
                picture::draw(file, &look.clone().at(moment), &scene, before, &[], registry)?;
            outputs.add(file, image, BTreeMap::new())?;
            Ok(undrawn)
        })?;
        let undrawn = frames.first().cloned().unwrap_or_default();
        undrawn.into_iter().chain(sequence.notes(frames.len())).collect()
    } else {
        let (image, undrawn) = picture::draw(&args.out, &look, &scene, before, &[], registry)?;
        outputs.add(&args.out, image, BTreeMap::new())?;
        undrawn
    };
    let produced = outputs.commit_watched(&progress)?;
    drop(progress);
    undrawn.iter().for_each(|note| console::warning(note));
    // What is drawn without being asked for need not be missed.
    let asked = Look {
        combs: if args.combs || args.comb_scale.is_some() { look.combs } else { Combs::Off },
        beads: if args.beads.is_some() { look.beads } else { Beads::Off },
        ..look
    };
    asked.unmet(&scene).iter().for_each(|note| console::warning(note));
    produced.iter().filter_map(Produced::note).for_each(|note| console::warning(&note));
    let frames = sequence.as_ref().map(|sequence| sequence.produced(&produced));
    let Some(whole) = frames.as_ref().or(produced.first()) else { return Ok(ExitCode::SUCCESS) };
    if args.json.wanted {
        report::warn(&name, &read);
        let (format, output, bytes) = (format.name, &whole.path, whole.bytes);
        let frames = if sequence.is_some() { produced.as_slice() } else { &[] };
        console::print_json(&Plotted { input: &name, format, output, bytes, frames, report: &read })?;
    } else {
        let head = styled(BOLD, &whole.path);
        console::print(&format!("wrote {head}, {}\n{}", bytes(whole.bytes), report::read(&read)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The state before, of which a single object is that of a single one, whatever it is called.
///
/// # Errors
/// When distances from before are asked for and nothing is called alike.
fn paired(
    mut before: Scene,
    scene: &Scene,
    (old_file, new_file): (&str, &str),
    faces: Option<Faces>,
) -> anyhow::Result<Scene> {
    let shapes = |scene: &Scene| -> Vec<String> {
        let all = scene.objects().iter().filter(|o| !matches!(o.geometry(), Geometry::Group));
        all.map(|o| o.name().to_owned()).collect()
    };
    let (old, new) = (shapes(&before), shapes(scene));
    if old.iter().any(|name| scene.get(name).is_some()) {
        return Ok(before);
    }
    if let ([one], [other]) = (&old[..], &new[..]) {
        if before.get(other).is_none() {
            before.rename(one, other)?;
        }
        return Ok(before);
    }
    if faces != Some(Faces::Deviation) {
        return Ok(before);
    }
    let some = |names: &[String]| {
        let first: Vec<String> = names.iter().take(4).map(|name| format!("\"{}\"", clip(name))).collect();
        format!("{}{}", first.join(", "), if names.len() > 4 { ", …" } else { "" })
    };
    anyhow::bail!(
        "no object of {new_file} ({}) is called as one of {old_file} ({}), so that nothing can be compared: rename them alike",
        some(&new),
        some(&old)
    )
}

/// Reads a file, which must not be written over; its name.
fn open(
    file: &Path,
    outputs: &mut Outputs,
    progress: &Progress,
    registry: &Registry,
) -> anyhow::Result<(String, Content)> {
    let input = Input::open(file)?;
    let name = Source::name(&input).to_owned();
    outputs.protect(&name);
    Ok((name, Conversion::default().read(&input, progress, registry)?))
}

/// More control vertices than these are not drawn unless they are asked for: they would hide the shapes.
const VERTICES: usize = 400;

/// Whether a scene has curves and no faces.
fn only_curves(scene: &Scene) -> bool {
    scene.objects().iter().all(|object| {
        matches!(
            object.geometry(),
            Geometry::Curve(_) | Geometry::Polyline(_) | Geometry::Cloud(_) | Geometry::Group
        )
    })
}

/// Whether control polygons and nets are few enough to be read, and of shapes that end where these do.
fn few_vertices(scene: &Scene) -> bool {
    let all = scene.objects().iter().map(|object| match object.geometry() {
        Geometry::Curve(curve) => curve.points().len(),
        Geometry::Surface(surface) => surface.points().len(),
        // What is cut away has control vertices, too.
        Geometry::Trimmed(_) => VERTICES + 1,
        _ => 0,
    });
    all.fold(0, usize::saturating_add) <= VERTICES
}

/// How the picture is to look: what is not said is as it can be read. Combs and knots are for curves; over faces they would hide them.
fn look(args: &PlotArgs, scene: &Scene) -> Look {
    let bare = only_curves(scene);
    let views: Vec<(&str, View)> = args.view.iter().flat_map(|seen| seen.views()).collect();
    let objects = (!args.objects.is_empty()).then(|| args.objects.clone());
    let only = |panel: Panel| match &objects {
        Some(names) => panel.objects(names.iter().cloned()),
        None => panel,
    };
    let mut panels: Vec<Panel> = Vec::new();
    if views.len() > 1 {
        panels.extend(views.iter().map(|(name, view)| only(Panel::view(*view).caption(*name))));
    }
    let view = views.first().map_or(View::Automatic, |(_, view)| *view);
    if let Some(along) = args.profile {
        if panels.is_empty() {
            panels.push(only(Panel::view(view)));
        }
        panels.push(only(Panel::profile(along.into())));
    }
    Look {
        title: args.title.clone(),
        view,
        objects,
        panels,
        columns: args.columns.map(usize::from),
        frames: match (args.film, args.frames) {
            (Some(count), _) => Frames::Film(usize::from(count)),
            (None, Some(Some(count))) => Frames::Fading(usize::from(count)),
            (None, dashed) => Frames::from(dashed.is_some()),
        },
        combs: match args.comb_scale {
            Some(scale) => Combs::Scale(scale),
            None if args.combs || bare && !args.no_combs => Combs::Automatic,
            None => Combs::Off,
        },
        beads: match args.beads {
            Some(count) => Beads::Uniform(usize::from(count)),
            None if bare && !args.no_knots => Beads::Knots,
            None => Beads::Off,
        },
        polygons: args.polygons || !args.no_polygons && few_vertices(scene),
        movements: args.movements,
        segments: args.segments,
        faces: args.faces.unwrap_or_default(),
        parameters: args.parameters,
        legend: !args.no_legend,
        dark: args.dark,
        width: args.width,
        height: args.height,
        pixels: args.pixels,
        ..Look::default()
    }
}
