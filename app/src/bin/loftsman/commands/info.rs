//! `info FILE [--to EXT] [--json]`

use std::fmt::Write;
use std::process::ExitCode;

use loftsman::convert::Conversion;
use loftsman::describe::{Degree, LayerFacts, ObjectFacts, SceneFacts, describe};
use loftsman::file::{Content, Input};
use loftsman::kernel::plugin::{ReadReport, Source};
use loftsman::kernel::scene::Unit;

use super::convert::format_of;
use super::report;
use crate::args::InfoArgs;
use crate::console::{self, BOLD, DIM, count, figure, styled};
use crate::progress::Progress;

#[derive(serde::Serialize)]
struct Info {
    file: String,
    bytes: usize,
    format: &'static str,
    #[serde(flatten)]
    scene: SceneFacts,
    report: ReadReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    conversion: Option<Losses>,
}

/// What a conversion would lose.
#[derive(serde::Serialize)]
struct Losses {
    to: &'static str,
    losses: Vec<String>,
}

pub(crate) fn run(args: &InfoArgs) -> anyhow::Result<ExitCode> {
    let to = args.to.as_deref().map(format_of).transpose()?.map(|format| format.declaration());
    let input = Input::open(&args.file)?;
    let Content { scene, report, format } =
        Conversion::default().read(&input, &Progress::start(), loftsman::registry())?;
    let info = Info {
        file: Source::name(&input).to_owned(),
        bytes: input.bytes().len(),
        format: format.name,
        conversion: to.map(|to| Losses { to: to.name, losses: to.holds.losses(&scene) }),
        scene: describe(&scene),
        report,
    };
    if args.json.wanted {
        console::print_json(&info)?;
    } else {
        console::print(&text(&info))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn text(info: &Info) -> String {
    let scene = &info.scene;
    let up = format!("{} up", scene.up.name());
    let mut objects = count(scene.objects.len(), "object");
    if !scene.definitions.is_empty() {
        let shown = scene.shown.filter(|&n| n < u64::MAX).map_or("countless".to_owned(), |n| n.to_string());
        objects += &format!(" · {} · {shown} shown", count(scene.definitions.len(), "definition"));
    }
    let unit = if scene.unit == Unit::Unknown { "unknown unit".into() } else { scene.unit.name() };
    let facts = format!("{} · {unit} · {up} · {objects}", info.format);
    let mut text = format!("{} · {facts}\n", styled(BOLD, &info.file));
    list(&scene.objects, "  ", &mut text);
    for definition in &scene.definitions {
        let _ = writeln!(text, "  {} {}", styled(BOLD, "definition"), definition.name);
        list(&definition.objects, "    ", &mut text);
    }
    for layer in &scene.layers {
        let _ = writeln!(text, "  {} {}  {}", styled(BOLD, "layer"), layer.name, self::layer(layer));
    }
    text += &report::read(&info.report);
    if let Some(Losses { to, losses }) = &info.conversion {
        let kept = if losses.is_empty() { "everything" } else { "everything but this:" };
        let _ = writeln!(text, "a conversion to {to} keeps {kept}");
        losses.iter().for_each(|loss| _ = writeln!(text, "  {loss}"));
    }
    text
}

fn layer(layer: &LayerFacts) -> String {
    let mut facts = vec![count(layer.objects, "object")];
    if layer.hidden {
        facts.push("hidden".to_owned());
    }
    facts.extend(layer.color.map(|color| format!("colour {}", color.map(figure).join(" "))));
    facts.extend(layer.parent.as_ref().map(|parent| format!("below {parent}")));
    styled(DIM, &facts.join(" · "))
}

fn list(objects: &[ObjectFacts], indent: &str, text: &mut String) {
    let width = objects.iter().map(|o| o.name.chars().count()).max().unwrap_or(0).min(32);
    for object in objects {
        let _ = writeln!(text, "{indent}{:width$}  {:8}  {}", object.name, object.kind, self::object(object));
    }
}

fn object(object: &ObjectFacts) -> String {
    let mut facts = Vec::new();
    if object.unknown {
        facts.push("its plug-in is not here".to_owned());
    }
    facts.extend(object.label.as_ref().map(|label| format!("labelled {label}")));
    facts.extend(object.shows.as_ref().map(|definition| format!("of {definition}")));
    match object.degree {
        Some(Degree::Curve(p)) => facts.push(format!("degree {p}")),
        Some(Degree::Surface([p, q])) => facts.push(format!("degree {p}×{q}")),
        None => {}
    }
    match (object.net, object.vertices) {
        (Some([u, v]), _) => facts.push(format!("{u}×{v} vertices")),
        (None, Some(n)) if !object.domain.is_empty() => facts.push(count(n, "vertex")),
        (None, Some(n)) => facts.push(count(n, "point")),
        (None, None) => {}
    }
    if let Some(faces) = object.faces {
        facts.push(count(faces, "face"));
    }
    facts.extend(object.loops.map(|n| count(n, "loop")));
    if object.rational == Some(true) {
        facts.push("rational".to_owned());
    }
    if object.periodic.contains(&true) {
        facts.push("periodic".to_owned());
    } else if object.closed == Some(true) {
        facts.push("closed".to_owned());
    }
    facts.extend(object.domain.iter().map(|[a, b]| format!("domain {} to {}", figure(*a), figure(*b))));
    facts.extend(object.length.map(|l| format!("length {}", figure(l))));
    if let Some([low, high]) = object.bounds {
        let size: Vec<String> = (0..3).map(|i| figure(high[i] - low[i])).collect();
        facts.push(format!("size {}", size.join(" × ")));
    }
    facts.extend(object.frames.map(|n| count(n, "frame")));
    facts.extend(object.layer.as_ref().map(|l| format!("layer {l}")));
    facts.extend(object.parent.as_ref().map(|p| format!("under {p}")));
    styled(DIM, &facts.join(" · "))
}
