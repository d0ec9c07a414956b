//! `info FILE [--to EXT] [--json]`

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write;
use std::process::ExitCode;

use crate::convert::Conversion;
use crate::describe::{
    Degree, FaceFacts, LayerFacts, ObjectFacts, OffEdge, OpenEdge, SceneFacts, Totals, describe,
    describe_faces,
};
use crate::file::output::encode;
use crate::file::{Content, Input};
use loftsman_kernel::plugin::{Format, FormatError, ReadReport, Registry, Source, WriteOptions};
use loftsman_kernel::scene::{Geometry, Scene, Unit};
use loftsman_kernel::text::short;
use serde_json::{Map, Value};

use super::convert::format_of;
use super::{measures, report};
use crate::program::args::{InfoArgs, check_options};
use crate::program::console::{self, BOLD, DIM, count, figure, styled};
use crate::program::progress::Progress;

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
    /// Why the format refuses the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    refused: Option<String>,
}

impl Losses {
    fn of(scene: &Scene, format: &dyn Format, options: &Map<String, Value>, registry: &Registry) -> Self {
        let to = format.declaration().name;
        let conversion =
            Conversion { write: BTreeMap::from([(to.to_owned(), options.clone())]), ..Conversion::default() };
        let tessellator = registry.tessellator();
        let options = WriteOptions { tessellator, ..conversion.write_options(None, format) };
        let refused = |error: FormatError| Self { to, losses: Vec::new(), refused: Some(error.problem) };
        match format.losses(scene, &options) {
            Ok(losses) => match empty(scene, format, &options, registry) {
                Some(error) => refused(error),
                None => Self { to, losses, refused: None },
            },
            Err(error) => refused(error),
        }
    }
}

/// Why a conversion refuses a scene nothing of which would go out. It is asked only where no object is of a kind that the format has, so that nothing is
/// cut or written for the answer.
fn empty(
    scene: &Scene,
    format: &dyn Format,
    options: &WriteOptions<'_>,
    registry: &Registry,
) -> Option<FormatError> {
    let holds = format.holds(&options.own).ok()?;
    let goes = |geometry: &Geometry| {
        !matches!(geometry, Geometry::Group)
            && (holds.exactly(geometry)
                || holds.tessellates(geometry)
                || matches!(geometry, Geometry::Instance(_) | Geometry::Custom(_)))
    };
    if scene.objects().iter().any(|object| goes(object.geometry())) {
        return None;
    }
    match encode(scene, "", format, options, registry) {
        Err(crate::Error::Format(error)) => Some(error),
        _ => None,
    }
}

pub(crate) fn run(args: &InfoArgs, registry: &Registry) -> anyhow::Result<ExitCode> {
    let to = args.to.as_deref().map(|to| format_of(to, registry)).transpose()?;
    let options: Map<String, Value> = args.write.iter().cloned().collect();
    if let Some(format) = &to {
        check_options("--write", &format.declaration(), &options, registry)?;
    }
    let input = Input::open(&args.file)?;
    let Content { scene, report, format } =
        Conversion::default().read(&input, &Progress::start(), registry)?;
    let info = Info {
        file: Source::name(&input).to_owned(),
        bytes: input.bytes().len(),
        format: format.name,
        conversion: to.map(|to| Losses::of(&scene, to.as_ref(), &options, registry)),
        scene: if args.verbose { describe_faces(&scene) } else { describe(&scene) },
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
    if let Some(all) = scene.totals.filter(|_| !scene.definitions.is_empty() || scene.objects.len() > 1) {
        objects += &format!(" · {}", totals(&all).join(" · "));
    }
    let unit = if scene.unit == Unit::Unknown { "unknown unit".into() } else { scene.unit.name() };
    let facts = format!("{} · {unit} · {up} · {objects}", info.format);
    let mut text = format!("{} · {facts}\n", styled(BOLD, &info.file));
    list(&scene.objects, scene.unit, "  ", &mut text);
    for definition in &scene.definitions {
        let all = definition.totals.filter(|_| definition.objects.len() > 1);
        let all = all.map(|all| format!("  {}", styled(DIM, &totals(&all).join(" · ")))).unwrap_or_default();
        let _ = writeln!(text, "  {} {}{all}", styled(BOLD, "definition"), definition.name);
        list(&definition.objects, scene.unit, "    ", &mut text);
    }
    for layer in &scene.layers {
        let _ = writeln!(text, "  {} {}  {}", styled(BOLD, "layer"), layer.name, self::layer(layer));
    }
    text += &report::read(&info.report);
    if let Some(Losses { to, refused: Some(problem), .. }) = &info.conversion {
        let _ = writeln!(text, "a conversion to {to} is refused: {problem}");
    } else if let Some(Losses { to, losses, .. }) = &info.conversion {
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

/// More instances of one definition than this are one line.
const FEW: usize = 8;

/// How many open edges a line names.
const NAMED: usize = 3;

/// How far lines are indented at most, whatever hangs under what.
const DEEP: usize = 24;

/// A line for each object, below that under which it hangs; many instances of one definition are one line, where the first of
/// them would be.
fn list(objects: &[ObjectFacts], unit: Unit, indent: &str, text: &mut String) {
    let mut instances: HashMap<&str, usize> = HashMap::new();
    for definition in objects.iter().filter_map(|o| o.shows.as_deref()) {
        *instances.entry(definition).or_default() += 1;
    }
    instances.retain(|_, number| *number > FEW);
    let lines = tree(objects);
    let alone = |o: &ObjectFacts| o.shows.as_deref().is_none_or(|of| !instances.contains_key(of));
    let long = |(object, depth): &(&ObjectFacts, usize)| object.name.chars().count() + 2 * depth;
    let width = lines.iter().filter(|(o, _)| alone(o)).map(long).max().unwrap_or(0).min(32);
    let mut summed: HashSet<&str> = HashSet::new();
    for (object, depth) in lines {
        let indent = format!("{indent}{:1$}", "", 2 * depth);
        if let Some((of, number)) = object.shows.as_deref().and_then(|of| instances.get_key_value(of)) {
            if summed.insert(of) {
                let _ = writeln!(text, "{indent}{number} instances of {of}");
            }
            continue;
        }
        let width = width.saturating_sub(2 * depth);
        let facts = self::object(object, unit);
        let _ = writeln!(text, "{indent}{:width$}  {:8}  {facts}", object.name, object.kind);
        object.face_list.iter().for_each(|one| _ = writeln!(text, "{indent}  {}", face(one)));
    }
}

/// Objects and how deep they hang, each behind that under which it hangs, else in their order.
fn tree(objects: &[ObjectFacts]) -> Vec<(&ObjectFacts, usize)> {
    let number: HashMap<&str, usize> = objects.iter().zip(0..).map(|(o, i)| (o.name.as_str(), i)).collect();
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); objects.len()];
    let mut open = Vec::new();
    for (index, object) in objects.iter().enumerate() {
        match object.parent.as_deref().and_then(|parent| number.get(parent)) {
            Some(&parent) => below[parent].push(index),
            None => open.push((index, 0)),
        }
    }
    open.reverse();
    let mut lines = Vec::with_capacity(objects.len());
    while let Some((index, depth)) = open.pop() {
        lines.push((&objects[index], depth.min(DEEP)));
        open.extend(below[index].iter().rev().map(|&child| (child, depth + 1)));
    }
    lines
}

/// What Breps have together: `18 solids · 150 faces · 300 edges`.
fn totals(totals: &Totals) -> Vec<String> {
    let n = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
    let all = [(totals.solids, "solid"), (totals.faces, "face"), (totals.edges, "edge")];
    all.iter().map(|(number, what)| count(n(*number), what)).collect()
}

/// `3 open edges: edge 12 near (0, 1, 2), edge 14 near (0, 1, 3), …`.
fn open(number: usize, first: &[OpenEdge]) -> String {
    let named: Vec<String> = first
        .iter()
        .take(NAMED)
        .map(|open| format!("edge {} near {}", open.edge, measures::place(open.at)))
        .collect();
    let more = if number > named.len() { ", …" } else { "" };
    format!("{}: {}{more}", count(number, "open edge"), named.join(", "))
}

/// How often edges are off what they bound, and the furthest of them.
fn off(number: usize, first: &[OffEdge]) -> String {
    let told: Vec<String> = first
        .iter()
        .take(1)
        .map(|off| {
            let from = match (off.face, off.vertex) {
                (_, Some(vertex)) => format!("vertex {vertex}"),
                (face, None) => face.map_or_else(String::new, |face| format!("face {face}")),
            };
            let (distance, tolerance) = (figure(off.distance), short(off.tolerance));
            format!("edge {} is {distance} off {from}, its tolerance {tolerance}", off.edge)
        })
        .collect();
    let more = match number.saturating_sub(told.len()) {
        0 => String::new(),
        more => format!(", {more} more off by less"),
    };
    format!("{}{more}", told.join(", "))
}

/// `size 2 × 2 × 1 m`.
fn size([low, high]: [[f64; 3]; 2], unit: Unit) -> String {
    // What is rounding of the coordinates is no thickness.
    let rounding = |i: usize| 8.0 * f64::EPSILON * high[i].abs().max(low[i].abs());
    let long: Vec<f64> = (0..3).map(|i| high[i] - low[i]).collect();
    let least = 1e-12 * long.iter().copied().fold(0.0, f64::max);
    let size: Vec<String> =
        (0..3).map(|i| figure(if long[i] <= least.max(rounding(i)) { 0.0 } else { long[i] })).collect();
    let unit = if unit == Unit::Unknown { String::new() } else { format!(" {}", unit.one()) };
    format!("size {}{unit}", size.join(" × "))
}

/// `face 3 top  plane · u 0 to 1, v 0 to 2 · inside at uv = [0.5, 1], (3, 4, 5)`: parameters with all their digits, as recipes take them.
fn face(face: &FaceFacts) -> String {
    let name = face.name.as_ref().map(|name| format!(" {name}")).unwrap_or_default();
    let [[u0, u1], [v0, v1]] = face.domain;
    let mut facts = vec![face.form.to_owned(), format!("u {u0} to {u1}, v {v0} to {v1}")];
    if let (Some([u, v]), Some(at)) = (face.uv, face.at) {
        facts.push(format!("inside at uv = [{u}, {v}], {}", measures::place(at)));
    }
    format!("face {}{name}  {}", face.face, styled(DIM, &facts.join(" · ")))
}

fn object(object: &ObjectFacts, unit: Unit) -> String {
    let mut facts = Vec::new();
    if object.unknown {
        facts.push("its plug-in is not here".to_owned());
    }
    facts.extend(object.label.as_ref().map(|label| format!("labelled {label}")));
    facts.extend(object.shows.as_ref().map(|definition| format!("of {definition}")));
    facts.extend(object.form.map(str::to_owned));
    match object.degree {
        Some(Degree::Curve(p)) => facts.push(format!("degree {p}")),
        Some(Degree::Surface([p, q])) => facts.push(format!("degree {p}×{q}")),
        None => {}
    }
    if object.rational == Some(true) {
        facts.push("rational".to_owned());
    }
    if object.periodic.contains(&true) {
        facts.push("periodic".to_owned());
    } else if object.closed == Some(true) {
        facts.push("closed".to_owned());
    }
    // How large it is comes before of how many parts it is made. What an instance shows is told where that is listed.
    if object.shows.is_none() || object.resized {
        facts.extend(measures::all(&object.measures, unit));
        facts.extend(object.bounds.map(|bounds| size(bounds, unit)));
    }
    facts.extend(object.own.as_ref().filter(|own| measures::differ(&own.measures, &object.measures)).map(
        |own| {
            let mut told = measures::quantities(&own.measures, unit);
            told.extend(own.bounds.map(|bounds| size(bounds, unit)));
            format!("in its own coordinates {}", told.join(", "))
        },
    ));
    match (object.net, object.vertices) {
        (Some([u, v]), _) => facts.push(format!("{u}×{v} vertices")),
        (None, Some(n)) if !object.domain.is_empty() => facts.push(count(n, "vertex")),
        // The ends of a brep's edges are told by these.
        (None, Some(_)) if object.kind == "brep" => {}
        (None, Some(n)) => facts.push(count(n, "point")),
        (None, None) => {}
    }
    facts.extend(object.solids.filter(|&n| n > 0).map(|n| count(n, "solid")));
    facts.extend(object.faces.map(|n| count(n, "face")));
    facts.extend(object.edges.map(|n| count(n, "edge")));
    facts.extend(object.open_edges.map(|n| open(n, &object.open_at)));
    facts.extend(object.off_edges.map(|n| off(n, &object.off_at)));
    facts.extend(object.loops.map(|n| count(n, "loop")));
    facts.extend(object.lines.map(|n| count(n, "line")));
    let range = |[a, b]: &[f64; 2]| format!("{} to {}", figure(*a), figure(*b));
    match &object.domain[..] {
        [u, v] => facts.push(format!("domain u {}, v {}", range(u), range(v))),
        all => facts.extend(all.iter().map(|all| format!("domain {}", range(all)))),
    }
    facts.extend(object.frames.map(|n| count(n, "frame")));
    facts.extend(object.layer.as_ref().map(|l| format!("layer {l}")));
    facts.extend(object.color.map(|color| format!("colour {}", color.map(figure).join(" "))));
    facts.extend(object.face_colors.map(|n| format!("faces in {}", count(n, "colour"))));
    styled(DIM, &facts.join(" · "))
}
