//! Progress bars on the standard error, for work of over a second at a terminal.

use std::cell::RefCell;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use loftsman::kernel::plugin::{Clock, Observer};

const PATIENCE: Duration = Duration::from_secs(1);

/// Shows progress once the work has taken a second; also the clock of reports.
pub(crate) struct Progress {
    started: Instant,
    terminal: bool,
    bar: RefCell<Option<ProgressBar>>,
}

impl Progress {
    /// Starts the clock.
    pub(crate) fn start() -> Self {
        Self { started: Instant::now(), terminal: std::io::stderr().is_terminal(), bar: RefCell::new(None) }
    }
}

impl Observer for Progress {
    fn progress(&self, work: &str, done: u64, total: u64) {
        if !self.terminal || self.started.elapsed() < PATIENCE {
            return;
        }
        let mut slot = self.bar.borrow_mut();
        let bar = slot.get_or_insert_with(|| bar(total));
        bar.set_length(total);
        bar.set_position(done);
        bar.set_message(work.to_owned());
    }
}

impl Clock for Progress {
    fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get_mut() {
            bar.finish_and_clear();
        }
    }
}

/// A bar on the standard error; it shows nothing where that is no terminal.
pub(crate) fn bar(total: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {elapsed}");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
