//! `plot FILE OUT.svg|OUT.png`

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use crate::convert::Conversion;
use crate::file::{Content, Input, Outputs, Produced};
use crate::picture::{self, Beads, Combs, Faces, Frames, Look, Panel, View};
use loftsman_kernel::plugin::{ReadReport, Registry, Source};

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
    let look = look(args);
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
    let before = before.as_ref().map(|(_, before)| &before.scene);
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
        combs: if args.comb_scale.is_some() { look.combs } else { Combs::Off },
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

/// How the picture is to look.
fn look(args: &PlotArgs) -> Look {
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
            None if args.no_combs => Combs::Off,
            None => Combs::Automatic,
        },
        beads: match args.beads {
            Some(count) => Beads::Uniform(usize::from(count)),
            None if args.no_knots => Beads::Off,
            None => Beads::Knots,
        },
        polygons: !args.no_polygons,
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
