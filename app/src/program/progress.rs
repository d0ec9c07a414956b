//! Progress bars on the standard error, for work of over a second at a terminal; and Ctrl-C, which stops it.

use std::cell::RefCell;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use loftsman_kernel::plugin::{Clock, Observer};

const PATIENCE: Duration = Duration::from_secs(1);

/// The exit status of an interrupted program, as shells have it: 128 and the number of the signal.
pub(crate) const INTERRUPTED: u8 = 130;

/// Whether Ctrl-C was pressed.
static STOP: AtomicBool = AtomicBool::new(false);

/// From now on Ctrl-C stops the work at the next place where it can be stopped, and what is half written is removed. Pressed
/// again it ends the program at once: files that are in place by then are whole.
pub(crate) fn listen() {
    let pressed = || {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(INTERRUPTED));
        }
        if std::io::stderr().is_terminal() {
            crate::program::console::warning("stopping; Ctrl-C again ends at once");
        }
    };
    // Where there is no such thing, Ctrl-C ends the program as it always did.
    let _ = ctrlc::set_handler(pressed);
}

/// Whether Ctrl-C was pressed.
pub(crate) fn interrupted() -> bool {
    STOP.load(Ordering::SeqCst)
}

/// Shows nothing, and stops at Ctrl-C.
pub(crate) struct Silent;

impl Observer for Silent {
    fn cancelled(&self) -> bool {
        interrupted()
    }
}

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

    fn cancelled(&self) -> bool {
        interrupted()
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
