//! `plot FILE OUT.svg|OUT.png`

use std::collections::BTreeMap;
use std::process::ExitCode;

use loftsman::file::{Input, Outputs};
use loftsman::kernel::plugin::{ReadOptions, Source};
use loftsman::picture::{self, Beads, Combs, Picture, Theme, View};

use super::report;
use crate::Usage;
use crate::args::PlotArgs;
use crate::console::{self, BOLD, bytes, styled};
use crate::progress::Progress;

pub(crate) fn run(args: &PlotArgs) -> anyhow::Result<ExitCode> {
    if !picture::is_picture(&args.out) {
        return Err(Usage(format!("{}: a picture is .svg or .png", args.out.display())).into());
    }
    let mut outputs = Outputs::new();
    let input = Input::open(&args.file)?;
    outputs.protect(Source::name(&input));
    outputs.claim(&args.out)?;
    let format = input.format(loftsman::registry())?;
    let progress = Progress::start();
    let options = ReadOptions { observer: &progress, ..ReadOptions::default() };
    let (scene, read) = format.read(&input, &options)?;
    let bare = Picture::of(&scene).control_polygons(!args.no_polygons);
    let picture = bare
        .view(args.view.map_or(View::Automatic, Into::into))
        .theme(if args.dark { Theme::Dark } else { Theme::Light })
        .combs(if args.no_combs { Combs::Off } else { Combs::Automatic })
        .beads(if args.no_knots { Beads::Off } else { Beads::Knots });
    outputs.add(&args.out, picture::encode(&args.out, &picture, args.pixels)?, BTreeMap::new())?;
    drop(progress);
    for produced in outputs.commit()? {
        let head = styled(BOLD, &produced.path);
        console::print(&format!("wrote {head}, {}\n{}", bytes(produced.bytes), report::read(&read)))?;
    }
    Ok(ExitCode::SUCCESS)
}
