//! Lengths, areas and volumes in words.

use crate::measures::{Leaks, Measures};
use loftsman_kernel::plugin::{Measured, ObjectChange};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::text::{self, short, without_rounding};

use crate::program::console::{count, figure};

/// Below this a ratio is 1: rounding of what was kept.
const KEPT: f64 = 1e-9;

/// What a step changed of an object: `area 0.0822 → 0.0904 m² (× 1.1) · deviates by up to 0.02 m`.
pub(super) fn change(change: &ObjectChange, unit: Unit) -> String {
    let quantities = [("area", change.area, 2), ("volume", change.volume, 3), ("length", change.length, 1)];
    let mut facts: Vec<String> =
        quantities.iter().filter_map(|(name, measured, power)| pair(name, *measured, unit, *power)).collect();
    facts.extend(change.deviation.map(|d| match (d, change.of_points) {
        (0.0, false) => "nowhere off the old shape".to_owned(),
        (d, false) => format!("deviates by up to {}", quantity(d, unit, 1)),
        (0.0, true) => "goes through all its points".to_owned(),
        (d, true) => format!("its points are up to {} off it", quantity(d, unit, 1)),
    }));
    facts.extend(change.unmeasured.iter().map(|why| format!("not measured: {why}")));
    facts.join(" · ")
}

/// A quantity before and after.
pub(super) fn pair(name: &str, measured: Measured, unit: Unit, power: usize) -> Option<String> {
    let one = |number: f64| format!("{name} {}", quantity(number, unit, power));
    Some(match (measured.before, measured.after) {
        (None, None) => return None,
        (None, Some(after)) => one(after) + inside_out(name, after),
        (Some(before), None) => format!("{}{} before", one(before), inside_out(name, before)),
        (Some(before), Some(after)) if (after - before).abs() <= KEPT * before.abs().max(after.abs()) => {
            format!("{}{} as before", one(after), inside_out(name, after))
        }
        (Some(before), Some(after)) => {
            // What is nothing but rounding is nothing.
            let after = without_rounding(after, before);
            let ratio = after / before;
            // Six figures where four do not show the change, and a share of it where these do not.
            let few = figure(before) != figure(after);
            let shown = |number: f64| if few { figure(number) } else { text::measured(number) };
            if shown(before) == shown(after) {
                let by = short(((after - before) / before).abs());
                return Some(format!(
                    "{}{} as before but for {by} of it",
                    one(after),
                    inside_out(name, after)
                ));
            }
            let told = if ratio.is_finite() && ratio > 0.0 && shown(ratio) != "1" {
                format!(" (× {})", shown(ratio))
            } else {
                String::new()
            };
            let after_told =
                if few { quantity(after, unit, power) } else { unit.measured_quantity(after, power) };
            // Of two that are inside out it is said once.
            let [then, now] = [before, after].map(|number| inside_out(name, number));
            let then = if now.is_empty() { then } else { "" };
            format!("{name} {}{then} → {after_told}{told}{now}", shown(before))
        }
    })
}

/// What is to be said of a volume below 0: its faces look inwards.
fn inside_out(name: &str, number: f64) -> &'static str {
    if name == "volume" && number < 0.0 { ", inside out" } else { "" }
}

/// What is known of an object: `area 6 m² · volume 1 m³ · watertight`.
pub(super) fn all(measures: &Measures, unit: Unit) -> Vec<String> {
    let mut facts = quantities(measures, unit);
    facts.extend(match (measures.watertight, &measures.leaks) {
        (Some(true), _) => Some("watertight".to_owned()),
        (_, Some(leaks)) => Some(self::leaks(leaks)),
        (Some(false), None) => Some(format!("open along {}", listed(&measures.open))),
        _ => None,
    });
    facts.extend(measures.unmeasured.iter().map(|why| format!("not measured: {why}")));
    facts
}

/// `u0, u1 and v0`: the edges where a surface is open.
fn listed(open: &[&str]) -> String {
    match open {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        ["border"] => "its border".to_owned(),
        _ => open.concat(),
    }
}

/// Whether lengths, areas or volumes differ by more than rounding.
pub(super) fn differ(a: &Measures, b: &Measures) -> bool {
    [(a.length, b.length), (a.area, b.area), (a.volume, b.volume)].into_iter().any(|pair| match pair {
        (Some(a), Some(b)) => (a - b).abs() > KEPT * a.abs().max(b.abs()),
        (a, b) => a.is_some() != b.is_some(),
    })
}

/// Length, area and volume.
pub(super) fn quantities(measures: &Measures, unit: Unit) -> Vec<String> {
    let length = measures.length.map(|l| format!("length {}", quantity(l, unit, 1)));
    // Of triangles they are near to what they are of the shape.
    let near = if measures.within.is_some_and(|within| within > 0.0) { "≈ " } else { "" };
    let area = measures.area.map(|a| format!("area {near}{}", quantity(a, unit, 2)));
    let volume =
        measures.volume.map(|v| format!("volume {near}{}{}", quantity(v, unit, 3), inside_out("volume", v)));
    [length, area, volume].into_iter().flatten().collect()
}

/// `not watertight: 4 open edges in 1 rim, near (0.5, 0, 1)`.
fn leaks(leaks: &Leaks) -> String {
    let kinds = [
        (leaks.open_edges > 0)
            .then(|| format!("{} in {}", count(leaks.open_edges, "open edge"), count(leaks.rims, "rim"))),
        (leaks.turned_edges > 0).then(|| {
            format!("{} between faces that run against each other", count(leaks.turned_edges, "edge"))
        }),
        (leaks.crowded_edges > 0)
            .then(|| format!("{} of three or more faces", count(leaks.crowded_edges, "edge"))),
    ];
    let kinds: Vec<String> = kinds.into_iter().flatten().collect();
    format!("not watertight: {}, near {}", kinds.join(", "), place(leaks.at))
}

/// `(0.5, 0, 1)`: what is rounding beside the largest coordinate is 0.
pub(super) fn place(at: [f64; 3]) -> String {
    let least = 1e-12 * at.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    format!("({})", at.map(|x| figure(if x.abs() <= least { 0.0 } else { x })).join(", "))
}

/// A number of a unit's first, second or third power: `2 m²`, `2 square units` where the unit is unknown.
fn quantity(number: f64, unit: Unit, power: usize) -> String {
    unit.quantity(number, power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_no_place() {
        assert_eq!(place([-4.244, 0.3675, 3.5e-17]), "(-4.244, 0.3675, 0)");
        assert_eq!(place([1e-17, 0.0, 2e-17]), "(1e-17, 0, 2e-17)");
    }

    #[test]
    fn what_was_kept_is_told_from_what_changed() {
        let area =
            |before, after| ObjectChange { area: Measured { before, after }, ..ObjectChange::default() };
        let told = |before, after, unit| change(&area(before, after), unit);
        assert_eq!(told(Some(0.0822), Some(0.09042), Unit::Metre), "area 0.0822 → 0.09042 m² (× 1.1)");
        assert_eq!(told(Some(2.0), Some(2.0 + 1e-13), Unit::Unknown), "area 2 square units as before");
        assert_eq!(told(Some(2.0), Some(2.0 - 3e-5), Unit::Metre), "area 2 → 1.99997 m² (× 0.999985)");
        assert_eq!(
            told(Some(158.604_48), Some(158.642_77), Unit::Millimetre),
            "area 158.604 → 158.643 mm² (× 1.00024)"
        );
        assert_eq!(told(Some(2.0), Some(2.0 - 6e-8), Unit::Metre), "area 2 m² as before but for 3e-8 of it");
        assert_eq!(told(None, Some(3.0), Unit::Millimetre), "area 3 mm²");
        assert_eq!(told(Some(7.0), Some(1.776e-15), Unit::Millimetre), "area 7 → 0 mm²");
        assert_eq!(told(Some(3.0), None, Unit::Inch), "area 3 in² before");
        assert_eq!(told(Some(-1.0), Some(1.0), Unit::Unknown), "area -1 → 1 square unit");
        assert_eq!(told(None, None, Unit::Metre), "");
        let odd = Unit::of_metres(0.3).unwrap();
        assert_eq!(told(None, Some(3.0), odd), "area 3 × (0.3 m)²");
    }

    #[test]
    fn a_volume_below_nothing_is_inside_out() {
        let told = |before, after| {
            let volume = Measured { before, after };
            change(&ObjectChange { volume, ..ObjectChange::default() }, Unit::Millimetre)
        };
        assert_eq!(told(None, Some(-1777.0)), "volume -1777 mm³, inside out");
        assert_eq!(told(None, Some(1777.0)), "volume 1777 mm³");
        assert_eq!(told(Some(-2.0), None), "volume -2 mm³, inside out before");
        assert_eq!(told(Some(-2.0), Some(-2.0)), "volume -2 mm³, inside out as before");
        assert_eq!(told(Some(-2.0), Some(-3.0)), "volume -2 → -3 mm³ (× 1.5), inside out");
        assert_eq!(told(Some(-2.0), Some(3.0)), "volume -2, inside out → 3 mm³");
    }
}
