//! What a simulation tells of itself.

use loftsman_kernel::Vector;
use loftsman_kernel::plugin::{ConstraintReport, Frames, OperationError, StepReport};
use loftsman_kernel::scene::Unit;
use loftsman_kernel::shape::{Derivative, Location};
use loftsman_kernel::text::{counted, figure, short, without_rounding};

use crate::body::extent;
use crate::link::{LEFT, SHUT};
use crate::simulation::{Event, Settled, Simulation, Unrest, Unseen};

/// Elastic energy that steps do not see is told where it is more than this share of what they do.
const UNSEEN: f64 = 0.01;

/// Constraints that drift by more than this share of the size are warned of.
const DRIFT: f64 = 1e-6;

pub(super) fn report(
    object: &str,
    simulation: &mut Simulation,
    settled: Option<Settled>,
    (before, stretch, stable): (f64, f64, f64),
    scheme: &str,
    (seen, unit): (&Frames, Unit),
) -> Result<StepReport, OperationError> {
    let errors = simulation.errors()?;
    let (equations, rank) = simulation.equations();
    let after = simulation.energy();
    let (mut notes, mut warnings) = (Vec::new(), Vec::new());
    let mut more = 0.0;
    let mut differs = false;
    for body in 0..simulation.bodies.len() {
        let unseen = simulation.unseen(body)?;
        (more, differs) = (more + unseen.more, differs || unseen.differs);
        warnings.extend(unresolved(simulation.body_name(body)?, unseen));
    }
    let energies = [after.kinetic, after.elastic, after.gravity, after.pulls];
    let all = energies.iter().map(|part| part.abs()).sum();
    let unseen = (differs || more.abs() > UNSEEN * after.elastic && without_rounding(more, all) != 0.0)
        .then_some(after.elastic + more);
    if simulation.sub_steps() > 0 {
        let length = simulation.time() / simulation.sub_steps() as f64;
        notes.push(match scheme {
            "implicit" => format!(
                "{} steps of {} s{}, scheme implicit (explicit ones would be stable to {} s)",
                simulation.sub_steps(),
                figure(length),
                match simulation.pauses() {
                    0 => String::new(),
                    pauses =>
                        format!(" (halved where they had to be: {} more)", counted(pauses, "solution[|s]")),
                },
                figure(stable)
            ),
            _ => format!(
                "{} steps of {} s on average{}, scheme {scheme} (stable to {} s)",
                simulation.sub_steps(),
                figure(length),
                match simulation.pauses() {
                    0 => String::new(),
                    pauses => format!(", with {} at corners", counted(pauses, "stop[|s]")),
                },
                figure(stable)
            ),
        });
        let unseen = match &unseen {
            Some(whole) => {
                format!(" as steps see it ({} in all: stretch varies within spans)", figure(*whole))
            }
            None => String::new(),
        };
        let [kinetic, elastic, gravity, pulls] = energies.map(|part| figure(without_rounding(part, all)));
        notes.push(format!(
            "energy at the end: motion {kinetic}, elastic {elastic}{unseen}, gravity {gravity}, pulls {pulls}, in mass · {}² / s²",
            unit.one()
        ));
        let drift = without_rounding(simulation.worst_error(), simulation.size);
        if equations > 0 {
            notes.push(format!("constraints drifted by {} at most", unit.quantity(drift, 1)));
        }
        if drift > DRIFT * simulation.size {
            warnings.push(format!(
                "constraints of {object:?} drifted by {}, more than a millionth of its size: give a shorter `step`, or scheme \"implicit\"",
                short(drift)
            ));
        }
    } else if let Some(whole) = unseen {
        notes.push(format!(
            "its elastic energy is {} where rest is found by it ({} in all: stretch varies within spans), in mass · {}² / s²",
            figure(without_rounding(after.elastic, all)),
            figure(whole),
            unit.one()
        ));
    }
    let by = |stretch: f64| {
        let way = if stretch < 0.0 { "compressed" } else { "stretched" };
        format!("{way} by {:.2} %", 100.0 * stretch.abs())
    };
    let end = simulation.largest_stretch(0)?;
    let most = if stretch.abs() > end.abs() { stretch } else { end };
    let told = match end.abs() < NO_STRETCH {
        true => "at the end it is neither stretched nor compressed anywhere".to_owned(),
        false => format!("at the end it is {} where it is most, whichever way", by(end)),
    };
    notes.push(match simulation.sub_steps() {
        0 => told,
        _ if most.abs() < NO_STRETCH => format!("{told}, nor in any frame"),
        _ => format!("{told}, in any frame {} at most", by(most)),
    });
    if let Some(Settled { stable: Some(false), .. }) = settled {
        notes.push(
            "the balance is unstable: the least push would let it crumple or fall over; with some `bending`, or moved before (`seconds`), it finds where it goes"
                .into(),
        );
    }
    if let Some(Settled { stable: None, rests: true, .. }) = settled {
        notes
            .push("whether the balance is stable does not show: the energy is as good as level there".into());
    }
    if let Some(Settled { residual, steps, rests, unrest, .. }) = settled {
        if rests {
            notes.push(format!("it rests: {} of the forces is left, after {steps} steps", short(residual)));
        } else {
            let left = short(residual);
            let (what, advice) = match unrest {
                Some(Unrest::Missed(index)) => {
                    let [name, by] = [simulation.name_of(index)?.to_owned(), short(errors[index])];
                    (format!("\"{name}\" misses what it asks by {by}"), "ask for less, or let it move before")
                }
                Some(Unrest::Slides(index)) => {
                    let name = simulation.name_of(index)?;
                    (format!("it is still drawn along at \"{name}\""), "let it move before")
                }
                Some(Unrest::Vertex(body, vertex)) => {
                    let name = simulation.body_name(body)?;
                    (format!("most of it on vertex {vertex} of {name:?}"), "let it move before")
                }
                None => ("nothing shows where".into(), "let it move before"),
            };
            warnings.push(format!(
                "{object:?} does not rest yet: {left} of the forces is left after {steps} steps, {what}; {advice} \
                 (more `seconds`, with some `damping`), or give it some `bending`"
            ));
        }
    }
    let unheld = gone(simulation)?;
    warnings.extend(unheld.or_else(|| left(simulation)));
    warnings.extend(shut(simulation));
    notes.extend(
        simulation
            .events()
            .iter()
            .map(|e| format!("{} s: \"{}\": {}", round(e.time, simulation.time()), e.name, e.what)),
    );
    notes.extend(ends(simulation, seen)?);
    notes.extend(sides(simulation)?);
    match settled {
        Some(settled) => notes.extend(without_corners(settled.turns)),
        None => notes.extend(held_back(simulation)?),
    }
    let mut constraints = Vec::with_capacity(errors.len());
    for (index, residual) in errors.iter().enumerate() {
        // Of two places both, one behind the other.
        let places = simulation.locations(index)?.into_iter().flat_map(|at| match at {
            Location::Curve(u) => vec![u],
            Location::Surface(u, v) | Location::Face(_, u, v) => vec![u, v],
            Location::Vertex(_) => Vec::new(),
        });
        let location = Some(places.collect::<Vec<_>>()).filter(|all| !all.is_empty());
        constraints.push(ConstraintReport {
            name: simulation.name_of(index)?.into(),
            // Of what holds no more there is none: null in JSON.
            residual: if simulation.holds(index)? { *residual } else { f64::NAN },
            location: location.filter(|_| simulation.holds(index).unwrap_or(false)),
            multipliers: simulation.force_of(index)?.to_vec(),
            ..ConstraintReport::default()
        });
    }
    let mut told = StepReport {
        op: "simulate".into(),
        object: Some(object.into()),
        equations: Some(equations),
        rank: Some(rank),
        residual: Some(without_rounding(errors.iter().copied().fold(0.0, f64::max), simulation.size)),
        energy: Some([before, after.total()]),
        steps: Some(simulation.sub_steps()),
        iterations: settled.map(|settled| settled.steps),
        constraints,
        notes,
        warnings,
        ..StepReport::default()
    };
    told.numbers.insert("elastic".into(), after.elastic.into());
    told.numbers.insert("elastic_in_all".into(), (after.elastic + more).into());
    Ok(told)
}

/// That a shape is not stretched as steps take it for: what they sum up differs from what there is.
fn unresolved(name: &str, unseen: Unseen) -> Option<String> {
    let Unseen { seen, more, strain, differs } = unseen;
    differs.then(|| {
        format!(
            "steps take the elastic energy of {name:?} for {}, and summed up finely it is {}: within its spans it is stretched or pushed together otherwise than they see (by {} % \
             on average), and where it is or rests is off by as much; give it a degree more (operation elevate), with whose knots steps see all of it, or more control vertices \
             (operation refine)",
            figure(seen),
            figure(seen + more),
            short(100.0 * strain)
        )
    })
}

/// That nothing holds something any more where its weight or a force draws it, since the last let go by itself.
fn gone(simulation: &mut Simulation) -> Result<Option<String>, OperationError> {
    let by_itself = |event: &&Event| event.let_go;
    let Some(last) = simulation.events().iter().rfind(by_itself).cloned() else { return Ok(None) };
    let Some((body, way)) = simulation.unheld()? else { return Ok(None) };
    Ok(Some(format!(
        "nothing holds {:?} any more since {} s, when \"{}\" let go ({}): it goes on along {} for ever; end it sooner (less `seconds`), or hold it at \
         one more place",
        simulation.body_name(body)?,
        round(last.time, simulation.time()),
        last.name,
        last.what,
        crate::error::direction(&way)
    )))
}

/// That constraints let go because the end or edge of what slid through them has passed, where others still hold it.
fn left(simulation: &Simulation) -> Option<String> {
    let told = let_go(simulation, LEFT)?;
    Some(format!(
        "the end or edge of the shape has passed {told}, and nothing holds it there any more: where that is not meant, hold a place that stays (`fixed`), or pull less"
    ))
}

/// That constraints let go because their loops are drawn shut.
fn shut(simulation: &Simulation) -> Option<String> {
    let told = let_go(simulation, SHUT)?;
    Some(format!(
        "loops are drawn shut at {told}, and nothing holds their places together any more: where that is not meant, pull less, end it sooner, or give it some `bending`"
    ))
}

/// Which constraints let go by themselves for this, and when.
fn let_go(simulation: &Simulation, why: &str) -> Option<String> {
    let gone = simulation.events().iter().filter(|event| event.let_go && event.what == why);
    let mut told: Vec<String> = gone
        .map(|event| format!("\"{}\" ({} s)", event.name, round(event.time, simulation.time())))
        .collect();
    let more = told.len().saturating_sub(LEFTS);
    told.truncate(LEFTS);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!told.is_empty()).then(|| format!("{}{more}", told.join(", ")))
}

/// So many that let go are named in a warning.
const LEFTS: usize = 4;

/// A stretch that is 0.00 %.
const NO_STRETCH: f64 = 5e-5;

/// So many places that slide have a line each.
const ENDS: usize = 20;

/// Where the places ended that slide: their parameters, and their points as the objects' own.
fn ends(simulation: &Simulation, seen: &Frames) -> Result<Vec<String>, OperationError> {
    let mut lines = Vec::new();
    let mut more = 0;
    for index in 0..simulation.constraints() {
        if !simulation.holds(index)? || !simulation.slides(index)? {
            continue;
        }
        if lines.len() == ENDS {
            more += 1;
            continue;
        }
        let mut told = Vec::new();
        let (mut point, mut places) = (Vec::new(), Vec::new());
        for (body, at) in simulation.places(index)? {
            let shape = seen.own_shape(body, simulation.shape(body)?);
            let spans: Vec<f64> = shape.domain().iter().map(|range| range.end - range.start).collect();
            let span = |axis: usize| spans.get(axis).copied().unwrap_or(1.0);
            told.push(match at {
                Location::Curve(u) => within(u, span(0)),
                Location::Surface(u, v) => format!("[{}, {}]", within(u, span(0)), within(v, span(1))),
                other => other.to_string(),
            });
            let common = simulation.shape(body)?;
            let place = common.value(at, Derivative::POSITION)?;
            // Two that are drawn together are at two points until they are one.
            let apart = |other: &Vector| (other - place).norm() > 1e-6 * extent(common.control_vertices());
            if places.iter().all(apart) {
                let size = extent(shape.control_vertices());
                let own = shape.value(at, Derivative::POSITION)?;
                let own: Vec<String> = own.iter().map(|x| within(*x, size)).collect();
                point.push(format!("[{}]", own.join(", ")));
                places.push(place);
            }
        }
        let name = simulation.name_of(index)?;
        let corner = match (simulation.on_corners(index)?.contains(&true), simulation.order(index)?) {
            (false, _) => "",
            (true, 0) => ", on a corner",
            (true, _) => ", on a knot, where what it holds is no more than continuous",
        };
        lines.push(format!("\"{name}\" ends at {}, in {}{corner}", told.join(" and "), point.join(" and ")));
    }
    if more > 0 {
        lines.push(format!("… and {more} more that slide (with --json all)"));
    }
    Ok(lines)
}

/// How much curves are stretched on both sides of the places that slide along them: alike where nothing else acts on the sides.
fn sides(simulation: &Simulation) -> Result<Vec<String>, OperationError> {
    let mut lines = Vec::new();
    let weighs = simulation.gravity.norm() > 0.0;
    for index in 0..simulation.constraints() {
        let stretches = simulation.side_stretches(index)?;
        let several = stretches.len() > 1;
        for (place, [behind, ahead]) in stretches.into_iter().enumerate() {
            let name = simulation.name_of(index)?;
            let which = match (several, place) {
                (false, _) => "",
                (true, 0) => ", its first place",
                (true, _) => ", its second place",
            };
            if behind.abs().max(ahead.abs()) < NO_STRETCH {
                lines.push(format!("\"{name}\"{which}: stretched on neither side"));
                continue;
            }
            // On a vertex of a polyline, or where it turns within a span, weight is not all that there is.
            let made = simulation.corners().iter().any(|corner| corner.constraint == index);
            let by_weight = match (weighs, made || !simulation.on_corners(index)?.contains(&true)) {
                (true, true) => " on average, the higher one more by its weight",
                (true, false) => " on average",
                (false, _) => "",
            };
            let [behind, ahead] = [behind, ahead].map(|stretch| 100.0 * stretch);
            lines.push(format!(
                "\"{name}\"{which}: on both sides stretched by {behind:.2} % and {ahead:.2} %{by_weight}"
            ));
        }
    }
    lines.truncate(ENDS);
    Ok(lines)
}

/// That a rope in motion is held back where it turns within its spans: both its sides differ at a place that slides by more than this share of the larger.
const APART: f64 = 0.1;

fn held_back(simulation: &Simulation) -> Result<Option<String>, OperationError> {
    let mut names = Vec::new();
    for index in simulation.turning()? {
        let apart = |[a, b]: &[f64; 2]| (a - b).abs() > APART * a.abs().max(b.abs());
        if simulation.side_stretches(index)?.iter().any(apart) {
            names.push(format!("\"{}\"", simulation.name_of(index)?));
        }
    }
    let more = names.len().saturating_sub(LEFTS);
    names.truncate(LEFTS);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    Ok((!names.is_empty()).then(|| {
        format!(
            "at {}{more} a rope turns within its spans and not at a point, which holds it back as friction would, the more the more such places it passes: more control \
             vertices (`refine`) hold it back less, and `settle = true` gives it corners there, so that both sides are stretched alike",
            names.join(", ")
        )
    }))
}

/// That a rope turns without corners, in words.
fn without_corners(turns: usize) -> Option<String> {
    let places = match turns {
        0 => return None,
        1 => "1 place that slides".to_owned(),
        _ => format!("{turns} places that slide"),
    };
    Some(format!(
        "at {places} a rope turns within its spans: no rest with corners was found that is as low, so that both sides are stretched alike only to what half a span is of them, and on a vertex of a polyline by what that holds; more control vertices (`refine`), or a start that is nearer, may help"
    ))
}

/// A coordinate or parameter to a millionth of what is there to be told apart.
fn within(value: f64, size: f64) -> String {
    let decimals = 6.0 - size.log10().ceil();
    if !(0.0..=12.0).contains(&decimals) {
        return format!("{value:.6e}");
    }
    let text = format!("{value:.*}", decimals as usize);
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

/// A time to a thousandth of a second, or of a whole motion that is shorter.
fn round(time: f64, whole: f64) -> String {
    let finer = if whole > 0.0 { (-whole.log10().floor()).clamp(0.0, 12.0) } else { 0.0 };
    let unit = 10_f64.powf(3.0 + finer);
    let rounded = (time * unit).round() / unit;
    if finer > 0.0 { figure(rounded) } else { rounded.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Setup, fixed};
    use loftsman_kernel::Point;
    use loftsman_kernel::plugin::Frames;
    use loftsman_kernel::spline::{Curve, Space};

    /// What is told of a rope that was settled.
    fn told(simulation: &mut Simulation, settled: Settled) -> StepReport {
        report(
            "rope",
            simulation,
            Some(settled),
            (0.0, 0.0, 1.0),
            "implicit",
            (&Frames::default(), Unit::Metre),
        )
        .unwrap()
    }

    /// What does not rest is a warning that says what to do, what rests a note.
    #[test]
    fn what_does_not_rest_is_a_warning() {
        let points = (0..5).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let rope = Curve::new(Space::clamped_uniform(3, 5).unwrap(), points).unwrap();
        for rests in [true, false] {
            let mut simulation = Setup::new(Body::new(&rope)).hold(fixed(0.0)).prepare().unwrap();
            let settled = Settled {
                residual: 2.5e-3,
                way: 0.1,
                steps: 2000,
                rests,
                stable: Some(rests),
                unrest: None,
                turns: 0,
            };
            let StepReport { notes, warnings, iterations, steps, .. } = told(&mut simulation, settled);
            assert_eq!((steps, iterations), (Some(0), Some(2000)));
            let noted = notes.iter().any(|note| note.contains("it rests: 0.0025"));
            assert_eq!((noted, warnings.len()), (rests, usize::from(!rests)));
            for warning in warnings {
                assert!(
                    warning.contains("\"rope\" does not rest yet: 0.0025") && warning.contains("`damping`"),
                    "{warning}"
                );
            }
        }
    }

    /// What is not known of a balance is said.
    #[test]
    fn a_balance_that_may_not_be_stable_is_told() {
        let points = (0..5).map(|i| Point::new(f64::from(i), 0.0, 0.0)).collect();
        let rope = Curve::new(Space::clamped_uniform(3, 5).unwrap(), points).unwrap();
        for (stable, wanted) in [(Some(true), ""), (Some(false), "unstable"), (None, "does not show")] {
            let mut simulation = Setup::new(Body::new(&rope)).hold(fixed(0.0)).prepare().unwrap();
            let settled =
                Settled { residual: 1e-12, way: 0.0, steps: 9, rests: true, stable, unrest: None, turns: 0 };
            let notes = told(&mut simulation, settled).notes;
            let told: Vec<&String> = notes.iter().filter(|note| note.contains("balance")).collect();
            assert_eq!(told.len(), usize::from(stable != Some(true)), "{notes:?}");
            assert!(told.iter().all(|note| note.contains(wanted)), "{notes:?}");
        }
    }
}
