//! What there is to say of faces that were sewn.

use loftsman_kernel::brep::Flaw;
use loftsman_kernel::text::counted;

use super::Sewn;
use super::hint::rounded_up;

/// An edge that was left out is warned of where it is longer than this part of the tolerance: what stood there may have been meant.
const LONG: f64 = 0.25;

/// Notes and warnings.
pub(super) struct Told {
    pub(super) notes: Vec<String>,
    pub(super) warnings: Vec<String>,
}

/// Of so many faces that were sewn within a tolerance; `quantity` says lengths in the unit of the scene.
pub(super) fn told(sewn: &Sewn, faces: usize, near: f64, quantity: &dyn Fn(f64) -> String) -> Told {
    let mut notes = vec![first(sewn, faces, near, quantity)];
    let mut say = |count: usize, text: &str| {
        if count > 0 {
            notes.push(counted(count, text));
        }
    };
    say(sewn.brep.solids().len(), "shell[|s] close[s|] and [is a solid|are solids]");
    say(
        sewn.brep.solids().iter().map(|solid| solid.voids.len()).sum(),
        "closed shell[|s] within another [is|are] what is hollow in it",
    );
    say(sewn.cut, "place[|s] where an edge was cut at a vertex of another");
    say(sewn.turned, "face[|s] turned over");
    if sewn.short > 0 && sewn.longest <= LONG * near {
        notes.push(short(sewn, quantity));
    }
    if !sewn.open.is_empty() {
        notes.push(open(sewn, quantity));
    }
    Told { notes, warnings: warnings(sewn, near, quantity) }
}

fn first(sewn: &Sewn, faces: usize, near: f64, quantity: &dyn Fn(f64) -> String) -> String {
    let faces = counted(faces, "face[|s]");
    if sewn.joined > 0 {
        let pairs = counted(sewn.joined, "pair[|s] of edges [is|are]");
        return format!(
            "{faces}: {pairs} joined, {} apart at most where it was measured",
            quantity(sewn.gap)
        );
    }
    if sewn.open.is_empty() {
        format!("{faces}: every edge is that of two already")
    } else {
        format!("{faces}: no two edges are within {} of one another", quantity(near))
    }
}

fn short(sewn: &Sewn, quantity: &dyn Fn(f64) -> String) -> String {
    let count = counted(sewn.short, "edge[|s] no longer than the tolerance [is|are] left out");
    format!("{count}, the longest {}", quantity(sewn.longest))
}

fn open(sewn: &Sewn, quantity: &dyn Fn(f64) -> String) -> String {
    let named: Vec<String> = sewn.open.iter().take(5).map(usize::to_string).collect();
    let more = if sewn.open.len() > named.len() { ", …" } else { "" };
    let up = |length: f64| quantity(rounded_up(length));
    let next = match (sewn.next, sewn.closes) {
        (Some(next), Some(all)) if next == all => format!("; with a tolerance of {} none is", up(all)),
        (Some(next), Some(all)) => {
            format!("; with a tolerance of {} fewer are, with {} none", up(next), up(all))
        }
        (Some(next), None) => format!("; with a tolerance of {} fewer are", up(next)),
        (None, _) => String::new(),
    };
    format!("open at {} (number {}{more}){next}", counted(sewn.open.len(), "edge[|s]"), named.join(", "))
}

fn warnings(sewn: &Sewn, near: f64, quantity: &dyn Fn(f64) -> String) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |count: usize, text: &str| {
        if count > 0 {
            warnings.push(counted(count, text));
        }
    };
    warn(sewn.twice, "face[|s] [lies|lie] on another one, edge for edge, and [is|are] left out");
    warn(
        sewn.inverted,
        "face[|s] [was|were] inside out, all of [its|their] surface but what [its|their] loops go round: the loops are turned round",
    );
    warn(
        sewn.one_sided,
        "shell[|s] [has|have] one side only, as a Möbius band: no way to turn [its|their] faces fits; parts that touch one another are sewn by themselves",
    );
    warn(
        sewn.unknown,
        "shell[|s] close[s|], but what is outside could not be told, or [it is|they are] thinner than the tolerance, so that [it is|they are] no solid[|s]",
    );
    if sewn.short > 0 && sewn.longest > LONG * near {
        let long = short(sewn, quantity);
        warnings.push(format!("{long}: about as long as the tolerance, which may be too large"));
    }
    warnings.extend(Flaw::told(&sewn.flaws));
    warnings
}
