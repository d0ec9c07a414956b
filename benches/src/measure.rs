//! How to measure, and the table that says what came of it.

use std::path::PathBuf;
use std::time::Duration;

use cpu_time::ProcessTime;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{Criterion, Throughput};
use serde_json::Value;

/// Processor time of the process: on a shared machine it leaves out the waiting for a core. All contestants run on
/// one thread.
#[derive(Debug, Clone, Copy)]
pub struct Processor;

impl Measurement for Processor {
    type Intermediate = ProcessTime;
    type Value = Duration;

    fn start(&self) -> ProcessTime {
        ProcessTime::now()
    }

    fn end(&self, start: ProcessTime) -> Duration {
        start.elapsed()
    }

    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        &Nanoseconds
    }
}

/// Criterion's own formatter of nanoseconds.
struct Nanoseconds;

impl ValueFormatter for Nanoseconds {
    fn scale_values(&self, typical: f64, values: &mut [f64]) -> &'static str {
        WallTime.formatter().scale_values(typical, values)
    }

    fn scale_throughputs(&self, typical: f64, throughput: &Throughput, values: &mut [f64]) -> &'static str {
        WallTime.formatter().scale_throughputs(typical, throughput, values)
    }

    fn scale_for_machines(&self, values: &mut [f64]) -> &'static str {
        WallTime.formatter().scale_for_machines(values)
    }
}

/// Criterion with processor time, and few enough samples that hundreds of cases take minutes.
pub fn criterion() -> Criterion<Processor> {
    Criterion::default()
        .with_measurement(Processor)
        .sample_size(15)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(400))
        .without_plots()
        .configure_from_args()
}

/// One case of a group: its name within the group, and how large its input is, for the growth exponent.
#[derive(Debug, Clone)]
pub struct Case {
    /// The name, as given to criterion.
    pub name: String,
    /// The size that grows from case to case; cases to be compared follow one another.
    pub size: f64,
    /// Which row of cases it belongs to: exponents are taken between neighbours of one row only.
    pub row: String,
}

/// Prints a group's medians, contestant by contestant, with ours against the best peer and against the floor, and
/// the exponent `e` of our growth, time ∝ size^e, from the case before.
///
/// `ours` is the contestant to compare; those named in `mine` are ours too, and no peers.
pub fn summary(group: &str, contestants: &[&str], ours: &str, mine: &[&str], cases: &[Case]) {
    let medians: Vec<Vec<Option<f64>>> = cases
        .iter()
        .map(|case| contestants.iter().map(|peer| median(group, peer, &case.name)).collect())
        .collect();
    if medians.iter().flatten().all(Option::is_none) {
        return;
    }
    println!("\n## {group}\n");
    println!("| case | {} | best peer / ours | ours / floor | growth |", contestants.join(" | "));
    println!("|---|{}---|---|---|", "---|".repeat(contestants.len()));
    let place = |name: &str| contestants.iter().position(|&c| c == name);
    for (i, (case, row)) in cases.iter().zip(&medians).enumerate() {
        let ours = place(ours).and_then(|at| row[at].map(|time| (at, time)));
        let floor = place("floor").and_then(|at| row[at]);
        let peers = contestants.iter().zip(row).filter(|(c, _)| **c != "floor" && !mine.contains(c));
        let best = peers.filter_map(|(_, time)| *time).reduce(f64::min);
        let ratio = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => format!("{:.2}", a / b),
            _ => "–".into(),
        };
        let before = i.checked_sub(1).filter(|&j| cases[j].row == case.row && cases[j].size != case.size);
        let growth = match (ours, before.and_then(|j| medians[j][ours?.0].map(|time| (time, cases[j].size))))
        {
            (Some((_, now)), Some((then, size))) => {
                format!("{:.2}", (now / then).ln() / (case.size / size).ln())
            }
            _ => "–".into(),
        };
        let times: Vec<String> = row.iter().map(|t| t.map_or("–".into(), readable)).collect();
        let ours = ours.map(|(_, time)| time);
        println!(
            "| {} | {} | {} | {} | {growth} |",
            case.name,
            times.join(" | "),
            ratio(best, ours),
            ratio(ours, floor)
        );
    }
}

/// The median of a case of the last run, in nanoseconds.
pub fn median(group: &str, contestant: &str, case: &str) -> Option<f64> {
    let home = std::env::var_os("CRITERION_HOME").map(PathBuf::from).or_else(|| {
        let target =
            std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
        Some(target.join("criterion"))
    })?;
    let path = home.join(group).join(contestant).join(case).join("new/estimates.json");
    let estimates: Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    estimates["median"]["point_estimate"].as_f64()
}

/// Nanoseconds for people.
pub fn readable(nanoseconds: f64) -> String {
    match nanoseconds {
        t if t < 1e3 => format!("{t:.0} ns"),
        t if t < 1e6 => format!("{:.2} µs", t / 1e3),
        t if t < 1e9 => format!("{:.2} ms", t / 1e6),
        t => format!("{:.2} s", t / 1e9),
    }
}
