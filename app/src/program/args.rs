//! The command line as it is typed. What it means is in [`crate::program::commands`].

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::convert::{self, Conversion, UPS};
use clap::{Args, CommandFactory, Parser, Subcommand, ValueHint};
use loftsman_kernel::plugin::{Chord, Format, FormatDeclaration, Registry, UpChoice, nearest};
use loftsman_kernel::scene::{Unit, Up};
use serde_json::{Map, Value};

use crate::program::Usage;
pub(crate) use plot::PlotArgs;

#[cfg_attr(not(feature = "picture"), path = "args/no_plot.rs")]
mod plot;

/// The option of formats that leaves out what is no mesh.
const MESHES_ONLY: &str = "meshes-only";

/// Edits splines under constraints and hands them to Blender, MeshLab and CAD.
#[derive(Debug, Parser)]
#[command(name = "loftsman", version, max_term_width = 100, arg_required_else_help = true)]
#[command(
    after_help = "Exit status: 0 done; 1 the input or the problem is at fault; 2 the command line is; 130 interrupted."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// The command line. A number below 0 behind an option is its value, and refused in that option's words where it cannot be.
pub(crate) fn command() -> clap::Command {
    let negative = |arg: clap::Arg| {
        let is_option = arg.get_action().takes_values() && !arg.is_positional();
        match arg.get_id().as_str() {
            // It may be a percentage, which is no number.
            "tolerance" => arg.allow_hyphen_values(true),
            _ if is_option => arg.allow_negative_numbers(true),
            _ => arg,
        }
    };
    Arguments::command().mut_subcommands(|command| command.mut_args(negative))
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Apply a recipe and write all of its outputs, or none.
    Run(RunArgs),
    /// Convert from any readable format to any writable one.
    Convert(ConvertArgs),
    /// Say what is in a file.
    Info(InfoArgs),
    /// Fit a spline through points.
    Fit(FitArgs),
    /// Draw curves with control polygons, combs and curvature profiles, surfaces and meshes from all sides.
    Plot(PlotArgs),
    /// Run a recipe with every solver and compare what they make of it; writes nothing.
    Compare(CompareArgs),
    /// List formats, operations, constraints, solvers and kinds of shape with all their fields.
    Plugins(PluginsArgs),
    /// Print completions for a shell.
    Completions(CompletionsArgs),
}

#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// The recipe, TOML or JSON; - for the standard input.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) recipe: PathBuf,
    /// Write this file instead of the recipe's outputs; may be repeated. #### in its name is the number of a frame: one
    /// file for each frame of the animations.
    #[arg(short, long = "output", value_name = "OUT", value_hint = ValueHint::FilePath)]
    pub(crate) outputs: Vec<PathBuf>,
    /// Use this solver in every step that takes one.
    #[arg(long, value_name = "NAME")]
    pub(crate) solver: Option<String>,
    /// Say how long steps took, too.
    #[arg(short, long)]
    pub(crate) verbose: bool,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// IN and OUT; with --into, only inputs. - is the standard input or output; #### in OUT is the number of a frame:
    /// one file for each frame of the animations.
    #[arg(required = true, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) files: Vec<PathBuf>,
    /// The format to write, by its extension; needed where OUT is - [with --into: glb].
    #[arg(long, value_name = "EXT")]
    pub(crate) to: Option<String>,
    /// The format to read, by its extension, whatever the input is called.
    #[arg(long, value_name = "EXT")]
    pub(crate) from: Option<String>,
    /// Write every input into this folder, which is made where it is missing; one that fails does not stop the rest.
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) into: Option<PathBuf>,
    /// Conversions at once with --into; as many as the machine has cores unless given.
    #[arg(long, value_name = "N", requires = "into", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) jobs: Option<u16>,
    #[command(flatten)]
    pub(crate) how: ConversionArgs,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct ConversionArgs {
    /// Chord tolerance where splines must be tessellated: a length in the scene's unit (0.01) or a part of each
    /// shape's diagonal (0.1%; of surfaces that share edges: of all of them together) [default: 0.1%; for glTF 0.01%]
    #[arg(long, value_name = "T", value_parser = convert::chord)]
    tolerance: Option<Chord>,
    /// Largest angle between neighbouring segments of a tessellation, in degrees [default: 15].
    #[arg(long, value_name = "DEGREES", value_parser = angle)]
    angle: Option<f64>,
    /// The unit (nm, um, mm, cm, dm, m, km, mil, in, ft, us-ft, yd, mi, or so many metres: "0.3 m"): of the input's
    /// numbers where its format has none (OBJ, point files), else of the output's.
    #[arg(long, value_name = "U", value_parser = unit)]
    unit: Option<Unit>,
    /// The unit of the input's numbers, whatever the file says; --unit is the output's then.
    #[arg(long, value_name = "U", value_parser = unit)]
    from_unit: Option<Unit>,
    /// The up axis of the output: x, y, z, or keep (turn nothing) [default: the format's own].
    #[arg(long, value_name = "AXIS", value_parser = up)]
    up: Option<UpChoice>,
    /// The up axis of the input: x, y or z [default: what the file or its format says].
    #[arg(long, value_name = "AXIS", value_parser = from_up)]
    from_up: Option<Up>,
    /// Leave curves, lines and points out, for programs that take them for triangles (MeshLab); same as --write
    /// meshes-only=true.
    #[arg(long)]
    meshes_only: bool,
    /// An option of the input's format; `loftsman plugins` lists them. May be repeated.
    #[arg(long, value_name = "OPTION=VALUE", value_parser = option)]
    read: Vec<(String, Value)>,
    /// An option of the output's format. May be repeated.
    #[arg(long, value_name = "OPTION=VALUE", value_parser = option)]
    write: Vec<(String, Value)>,
}

impl ConversionArgs {
    /// What is asked of a conversion to a format.
    ///
    /// # Errors
    /// When meshes alone are asked for, which the format cannot leave to itself, and for an option that it does not have.
    pub(crate) fn conversion(&self, output: &dyn Format, registry: &Registry) -> Result<Conversion, Usage> {
        let mut write: Map<String, Value> = self.write.iter().cloned().collect();
        if self.meshes_only {
            let declaration = output.declaration();
            if !declaration.options.iter().any(|option| option.name == MESHES_ONLY) {
                let has = |d: &FormatDeclaration| d.options.iter().any(|option| option.name == MESHES_ONLY);
                let all = registry.formats().iter().map(|format| format.declaration());
                let others: Vec<&str> = all.filter(has).map(|format| format.name).collect();
                let (name, others) = (declaration.name, others.join(", "));
                return Err(Usage(format!("--meshes-only: {name} has no such option; {others} has")));
            }
            write.insert(MESHES_ONLY.to_owned(), Value::Bool(true));
        }
        check_options("--write", &output.declaration(), &write, registry)?;
        Ok(Conversion {
            unit: self.unit,
            from_unit: self.from_unit,
            up: self.up.unwrap_or_default(),
            from_up: self.from_up,
            chord: self.tolerance,
            angle: self.angle,
            read: self.read.iter().cloned().collect(),
            write: BTreeMap::from([(output.declaration().name.to_owned(), write)]),
        })
    }
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// The file; - for the standard input.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Say what a conversion to the format of this extension would lose.
    #[arg(long, value_name = "EXT")]
    pub(crate) to: Option<String>,
    /// An option of that format. May be repeated.
    #[arg(long, value_name = "OPTION=VALUE", value_parser = option, requires = "to")]
    pub(crate) write: Vec<(String, Value)>,
    /// Say of each face of a solid its number, what it is, its parameters and a place inside of it, as recipes take places on faces: { face, uv }.
    #[arg(short, long)]
    pub(crate) verbose: bool,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    /// A file with points: Selig, Lednicer or AeroDyn sections, csv, xyz, or any readable cloud or polyline.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) points: PathBuf,
    /// The file to write; .svg and .png make a picture.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// The object to fit, where the file has several.
    #[arg(long, value_name = "NAME")]
    pub(crate) object: Option<String>,
    /// The degree of the curve.
    #[arg(long, value_name = "P", default_value_t = 3)]
    pub(crate) degree: usize,
    /// How far the points may be from the curve, in the file's unit; control vertices are added until they are.
    #[arg(long, value_name = "T", value_parser = distance)]
    pub(crate) tolerance: Option<f64>,
    /// The same as a share of the diagonal of the box around the points [default: 1e-4].
    #[arg(long, value_name = "SHARE", value_parser = positive, conflicts_with = "tolerance")]
    pub(crate) relative_tolerance: Option<f64>,
    /// Use exactly this many control vertices; with --tolerance, at most this many.
    #[arg(long, value_name = "N", conflicts_with = "relative_tolerance")]
    pub(crate) vertices: Option<usize>,
    /// Pass through every point exactly.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(crate) interpolate: Option<bool>,
    /// Join the end to the start smoothly: a periodic curve. --closed=false opens a closed polyline where it starts.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(crate) closed: Option<bool>,
    /// Divide the fit at points where they turn by more than so many degrees, or `auto`; round noses are no corners.
    #[arg(long, value_name = "DEGREES|auto", value_parser = json)]
    pub(crate) corners: Option<Value>,
    /// The parameters to start from: chord, centripetal, uniform, or a list of numbers with commas.
    #[arg(long, value_name = "HOW", value_parser = list_or_word)]
    pub(crate) parameters: Option<Value>,
    /// The most parameter corrections between two additions of knots; 0 keeps the parameters [default: 4].
    #[arg(long, value_name = "N")]
    pub(crate) corrections: Option<usize>,
    /// What an open curve does at its ends: keep or free; with --interpolate averaged, not-a-knot or natural.
    #[arg(long, value_name = "HOW")]
    pub(crate) ends: Option<String>,
    /// Leave out points that coincide with the one before, with --interpolate.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(crate) merge: Option<bool>,
    /// A positive weight for each point, with commas.
    #[arg(long, value_name = "W,…", value_delimiter = ',')]
    pub(crate) weights: Vec<f64>,
    /// What must hold exactly, as in a recipe: '{ kind = "position", at = 0.5, to = [0, 1, 0] }', or the same as JSON.
    /// May be repeated.
    #[arg(long, value_name = "TABLE", value_parser = table)]
    pub(crate) constraints: Vec<Value>,
    /// How strongly to straighten vertices that the points leave open; 1e-6 is little [default: 0].
    #[arg(long, value_name = "FACTOR")]
    pub(crate) regularization: Option<f64>,
    /// Spend what the tolerance leaves over on an even curvature [default: true].
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(crate) smooth: Option<bool>,
    /// Take the best curve found where the tolerance cannot be met.
    #[arg(long, value_name = "BOOL", num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    pub(crate) best_effort: Option<bool>,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// The recipe; its outputs are not written.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) recipe: PathBuf,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct PluginsArgs {
    /// Only the entry of this name; or all of a sort: formats, operations, constraints, solvers, shapes, wishes (what
    /// every constraint takes), recipe, picture, document (what a *.loft.json holds).
    pub(crate) name: Option<String>,
    #[command(flatten)]
    pub(crate) json: Json,
}

#[derive(Debug, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell.
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub(crate) struct Json {
    /// Print one JSON object on the standard output, and nothing else there.
    #[arg(long = "json")]
    pub(crate) wanted: bool,
}

/// Refuses options that a format does not have on its way out.
///
/// # Errors
/// For the first of them, with the format that has it, or the names that there are.
pub(crate) fn check_options(
    flag: &str,
    format: &FormatDeclaration,
    options: &Map<String, Value>,
    registry: &Registry,
) -> Result<(), Usage> {
    let known = |d: &FormatDeclaration| -> Vec<&str> {
        let reads = flag == "--read";
        let fields: Vec<_> =
            if reads { d.reading_options().collect() } else { d.writing_options().collect() };
        fields.iter().map(|field| field.name).collect()
    };
    let Some(wrong) = options.keys().find(|name| !known(format).contains(&name.as_str())) else {
        return Ok(());
    };
    let all = registry.formats().iter().map(|format| format.declaration());
    let others: Vec<&str> = all.filter(|d| known(d).contains(&wrong.as_str())).map(|d| d.name).collect();
    let there = match (others.as_slice(), known(format).as_slice()) {
        ([], []) => format!("{} has no options on this way", format.name),
        ([], names) => format!("{} has {}", format.name, names.join(", ")),
        (others, _) => format!("it is one of {}", others.join(", ")),
    };
    Err(Usage(format!("{flag} {wrong}: {} has no such option; {there}", format.name)))
}

/// An option's name and value; the value is a number, true or false where it reads so, else a text.
fn option(text: &str) -> Result<(String, Value), String> {
    let (name, value) = text.split_once('=').ok_or("write it as OPTION=VALUE")?;
    let read: Option<Value> = serde_json::from_str(value).ok();
    Ok((name.trim().to_owned(), read.unwrap_or_else(|| Value::String(value.to_owned()))))
}

/// JSON, or the text itself.
fn json(text: &str) -> Result<Value, String> {
    Ok(serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned())))
}

/// Numbers with commas as a list, anything else as it is.
fn list_or_word(text: &str) -> Result<Value, String> {
    match serde_json::from_str::<Value>(&format!("[{text}]")) {
        Ok(Value::Array(all)) if all.iter().all(Value::is_number) => Ok(Value::Array(all)),
        _ => json(text),
    }
}

/// A table as JSON or as recipes have it.
fn table(text: &str) -> Result<Value, String> {
    if let Ok(value @ Value::Object(_)) = serde_json::from_str(text) {
        return Ok(value);
    }
    let read: Option<Value> =
        toml::from_str::<toml::Table>(&format!("x = {text}")).ok().and_then(|t| serde_json::to_value(t).ok());
    match read.and_then(|mut t| t.get_mut("x").map(Value::take)) {
        Some(value @ Value::Object(_)) => Ok(value),
        _ => Err("write a table, such as { kind = \"position\", at = 0.5, to = [0, 1, 0] }".to_owned()),
    }
}

fn unit(text: &str) -> Result<Unit, String> {
    convert::unit(text)
}

fn up(text: &str) -> Result<UpChoice, String> {
    let found = UPS.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice);
    found.ok_or_else(|| choose("axis", text, UPS.map(|(name, _)| name)))
}

fn from_up(text: &str) -> Result<Up, String> {
    match up(text) {
        Ok(UpChoice::To(axis)) => Ok(axis),
        _ => Err("choose one of x, y, z".to_owned()),
    }
}

fn choose<const N: usize>(what: &str, text: &str, names: [&'static str; N]) -> String {
    let hint = nearest(text, names).map(|near| format!("; did you mean {near}?")).unwrap_or_default();
    format!("there is no {what} \"{text}\"{hint}; choose one of {}", names.join(", "))
}

/// A length; a share of something has an option of its own.
fn distance(text: &str) -> Result<f64, String> {
    match text.trim().strip_suffix('%').map(|share| share.trim().parse::<f64>()) {
        Some(Ok(share)) if share > 0.0 => Err(format!(
            "is a share, and here a length is meant: write --relative-tolerance {}",
            share / 100.0
        )),
        _ => positive(text),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        Ok(_) => Err("must be positive and finite".to_owned()),
        Err(_) => Err("is not a number".to_owned()),
    }
}

fn angle(text: &str) -> Result<f64, String> {
    positive(text).map(f64::to_radians)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_command_line_is_consistent() {
        super::command().debug_assert();
    }
}
