//! `edge`: an edge of a surface or a Brep as a curve, exactly, or a piece of the border of a trimmed surface.

use loftsman_kernel::Point;
use loftsman_kernel::brep::Brep;
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::Edge;
use loftsman_kernel::plugin::{
    Context, Declaration, Field, Operation, OperationError, ParameterError, Parameters, StepReport,
    in_own_coordinates, object_name,
};
use loftsman_kernel::scene::{Geometry, Scene};
use loftsman_kernel::shape::edges_of;
use loftsman_kernel::spline::{Curve, Trimmed};
use loftsman_kernel::text::{a, without_rounding};
use loftsman_kernel::topology::EdgeCurve;

use crate::fields::{NAME, free_name, length, like, made, named};

/// Edges whose distances differ by less than this part of the larger one, or of the size of the coordinates, are as near.
const AS_NEAR: f64 = 1e-9;
/// How far a border may be from where it should be where nobody says, as a part of the size of the surface.
const NEAR: f64 = 1e-7;

/// The operation `edge`: [`EdgeCurve::of`], or the part of its curve that an edge of a Brep is, or what a curve of a trimmed surface's loops is in space
/// ([`ParameterCurve::on`](loftsman_kernel::spline::trimmed::ParameterCurve::on)).
#[derive(Debug, Clone, Copy, Default)]
pub struct EdgeOf;

impl Operation for EdgeOf {
    fn declaration(&self) -> Declaration {
        const FIELDS: &[Field] = &[
            Field::optional("object", "text", "the only shape with edges", "the surface or brep"),
            Field::required(
                "edge",
                "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\" | \"border 2\" | { closest = [x, y, z] }",
                "the edge: where u or v starts or ends, of a brep its number, of a trimmed surface a curve of its loops by its number, or the one that comes nearest to a point",
            ),
            Field::optional(
                "tolerance",
                "length",
                "1e-7 of its size",
                "how far the border of a trimmed surface may be from where it should be, where it is not exact",
            ),
            NAME,
        ];
        Declaration {
            name: "edge",
            help: "add an edge of a surface or brep as a curve, exactly, or a piece of the border of a trimmed surface, exactly or within a tolerance; reports its length",
            fields: FIELDS,
        }
    }

    fn apply(
        &self,
        scene: &mut Scene,
        p: &Parameters,
        _: &Context<'_>,
    ) -> Result<StepReport, OperationError> {
        p.check(self.declaration().fields)?;
        let with_edges = |g: &Geometry| match g {
            Geometry::Brep(brep) => brep.edge_count() > 0,
            g => g.shape().is_ok_and(|shape| edges_of(shape, "edge").is_ok()),
        };
        let source = object_name(scene, p, with_edges, "shape with edges")?;
        let mut notes = Vec::new();
        let geometry = scene.object(&source)?.geometry();
        let edges = Edges::of(geometry).ok_or_else(|| {
            let problem = format!(
                "\"{source}\" is {}, which has no edges: name a surface or a brep",
                a(&geometry.noun())
            );
            p.error("object", problem)
        })?;
        if let Geometry::Trimmed(trimmed) = geometry
            && let Some(asked) = Wanted::of(trimmed, p)?
        {
            let trimmed = trimmed.clone();
            return border(scene, &source, &trimmed, asked, p);
        }
        if p.has("tolerance") {
            let problem = "an edge is exact: leave it out (it is for the border of a trimmed surface)";
            return Err(p.error("tolerance", problem).into());
        }
        let index = match p.value("edge") {
            Some(value) if value.is_object() => {
                let place = p.table("edge")?;
                place.check(&[Field::required("closest", "[x, y, z]", "a point")])?;
                let (index, note) = edges.nearest(place.point("closest")?, &source, scene, p)?;
                notes.push(note);
                index
            }
            _ => edges.named(Edge::from_parameters(p, "edge")?, p)?,
        };
        let curve = edges.curve(index).map_err(named(&source))?;
        let called = edges.name(index);
        if let Geometry::Trimmed(trimmed) = geometry {
            notes.extend(left_of(trimmed, &curve, &called).map_err(named(&source))?);
        }
        // Its name is u1, or edge 3.
        let short =
            called.strip_prefix("edge ").filter(|rest| rest.starts_with(['u', 'v'])).unwrap_or(&called);
        let name = free_name(scene, p, &format!("{source} {short}"))?;
        let object = like(scene, &source, &name, curve.into());
        scene.add(object)?;
        Ok(made("edge", name, notes))
    }
}

/// Which piece of the border of a trimmed surface is meant.
enum Wanted {
    Number(usize),
    Closest(Point),
}

impl Wanted {
    /// `border 2`, or the piece nearest to a point; `None` where it is an edge of the surface that carries it.
    fn of(trimmed: &Trimmed, p: &Parameters) -> Result<Option<Self>, ParameterError> {
        if p.value("edge").is_some_and(|value| value.is_object()) {
            if trimmed.regions().is_empty() {
                return Ok(None);
            }
            let place = p.table("edge")?;
            place.check(&[Field::required("closest", "[x, y, z]", "a point")])?;
            return Ok(Some(Self::Closest(place.point("closest")?)));
        }
        let number = p.text("edge")?.strip_prefix("border ").and_then(|number| number.parse().ok());
        Ok(number.map(Self::Number))
    }
}

/// Adds a piece of the border of a trimmed surface: a curve of its loops on the surface, exactly or within a tolerance. All of them are brought there
/// where the nearest is asked for.
fn border(
    scene: &mut Scene,
    source: &str,
    trimmed: &Trimmed,
    wanted: Wanted,
    p: &Parameters,
) -> Result<StepReport, OperationError> {
    let net = trimmed.surface().points();
    let extent = net.iter().map(|point| (point - net[0]).amax()).fold(0.0, f64::max);
    let tolerance = if p.has("tolerance") { length(p, "tolerance")? } else { NEAR * extent };
    let part = trimmed.part().map_err(named(source))?;
    let pieces = part.border();
    let lifted = |index: usize| pieces[index].on(trimmed.surface(), tolerance).map_err(named(source));
    let mut notes = Vec::new();
    let (index, found) = match wanted {
        Wanted::Number(index) if index < pieces.len() => (index, lifted(index)?),
        Wanted::Number(index) => {
            let problem = match pieces.len().checked_sub(1) {
                None => format!(
                    "there is no border {index}: no loop bounds \"{source}\"; its edges are u0, u1, v0 and v1"
                ),
                Some(last) => format!(
                    "there is no border {index}: the loops of \"{source}\" are \"border 0\" to \"border {last}\"; {{ closest = [x, y, z] }} is the one nearest to a point"
                ),
            };
            return Err(p.error("edge", problem).into());
        }
        Wanted::Closest(point) => {
            let mut all = Vec::with_capacity(pieces.len());
            for index in 0..pieces.len() {
                let found = lifted(index)?;
                all.push((found.curve.closest(point).map_err(named(source))?.distance, found));
            }
            let best = (0..all.len()).min_by(|&a, &b| all[a].0.total_cmp(&all[b].0));
            let Some(best) = best else {
                return Err(p.error("edge", format!("\"{source}\" has no border")).into());
            };
            let away = all[best].0;
            let others = as_near(all.iter().map(|(distance, _)| *distance), away, point);
            notes.push(nearest_note(scene, &format!("border {best}"), away, point, others));
            (best, all.swap_remove(best).1)
        }
    };
    let longer = scene.standing(source)?.most();
    notes.push(match found.deviation {
        None => "exact".to_owned(),
        Some(off) => {
            let size = net.iter().map(|point| point.coords.amax()).fold(0.0, f64::max);
            format!(
                "{} from where it should be at most, measured; {} were allowed",
                scene.unit.quantity(longer * without_rounding(off, size), 1),
                scene.unit.quantity(longer * tolerance, 1)
            )
        }
    });
    notes.extend(in_own_coordinates(scene, source, p, &[], &["tolerance"])?);
    let name = free_name(scene, p, &format!("{source} border {index}"))?;
    let object = like(scene, source, &name, found.curve.into());
    scene.add(object)?;
    let mut report = made("edge", name, notes);
    report.numbers.insert("border".into(), index.into());
    if let Some(off) = found.deviation {
        report.numbers.insert("deviation".into(), (longer * off).into());
        report.numbers.insert("tolerance".into(), (longer * tolerance).into());
    }
    Ok(report)
}

/// How many more distances are the least but for rounding.
fn as_near(distances: impl Iterator<Item = f64>, least: f64, point: Point) -> usize {
    let size = point.coords.amax().max(least);
    distances.filter(|&d| d <= least + AS_NEAR * size).count().saturating_sub(1)
}

/// What is said of an edge that a point stands for.
fn nearest_note(scene: &Scene, called: &str, away: f64, point: Point, others: usize) -> String {
    let more = match others {
        0 => String::new(),
        1 => "; another is as near".to_owned(),
        more => format!("; {more} others are as near"),
    };
    let away = scene.unit.quantity(without_rounding(away, point.coords.amax().max(away)), 1);
    format!("{called} comes nearest to the point: {away} away{more}")
}

/// At so many places of an edge it is asked whether loops leave it; those that are further from what they leave than this part of its size are cut away.
const PLACES: u32 = 64;
const LEFT: f64 = 1e-6;

/// What is said of an edge of a trimmed surface that its loops do not leave whole. 65 searches for the nearest place at most.
fn left_of(trimmed: &Trimmed, edge: &Curve, called: &str) -> loftsman_kernel::Result<Option<String>> {
    let part = trimmed.part()?;
    let ((from, to), (low, high)) = (edge.domain(), edge.hull_bounds());
    let size = (high - low).norm();
    let mut away = 0;
    for k in 0..=PLACES {
        let at = if k == PLACES { to } else { from + (to - from) * f64::from(k) / f64::from(PLACES) };
        away += u32::from(part.closest(edge.point(at)?)?.distance > LEFT * size);
    }
    Ok(match away {
        0 => None,
        all if all > PLACES => {
            Some(format!("{called} of the surface that carries it, of which its loops leave nothing"))
        }
        _ => Some(format!(
            "{called} of the surface that carries it, whole: its loops leave only a part of that; {{ closest = [x, y, z] }} or \"border 0\" are of these"
        )),
    })
}

/// What has edges.
enum Edges<'a> {
    /// A surface, trimmed or not, or a plug-in's shape.
    Shape(&'a Geometry),
    Brep(&'a Brep),
}

impl<'a> Edges<'a> {
    fn of(geometry: &'a Geometry) -> Option<Self> {
        match geometry {
            Geometry::Brep(brep) => Some(Self::Brep(brep)),
            other => other.shape().ok().map(|_| Self::Shape(geometry)),
        }
    }

    fn count(&self) -> loftsman_kernel::Result<usize> {
        match self {
            Self::Shape(geometry) => Ok(edges_of(geometry.shape()?, "edge")?.count()),
            Self::Brep(brep) => Ok(brep.edge_count()),
        }
    }

    /// The edge of a name; a Brep has numbers only.
    fn named(&self, edge: Edge, p: &Parameters) -> Result<usize, ParameterError> {
        match (self, edge) {
            (Self::Shape(geometry), edge) => {
                let number = geometry.shape().and_then(|shape| edge.number_on(shape));
                number.map_err(|problem| p.error("edge", problem.to_string()))
            }
            (Self::Brep(brep), Edge::Number(index)) if index < brep.edge_count() => Ok(index),
            (Self::Brep(brep), edge) => {
                let last = brep.edge_count().saturating_sub(1);
                let problem = format!(
                    "there is no {}: the brep's edges are \"edge 0\" to \"edge {last}\"; {{ closest = [x, y, z] }} is the one nearest to a point",
                    edge.called()
                );
                Err(p.error("edge", problem))
            }
        }
    }

    /// The edge that comes nearest to a point, of several the first, and what is said of it.
    fn nearest(
        &self,
        point: Point,
        source: &str,
        scene: &Scene,
        p: &Parameters,
    ) -> Result<(usize, String), OperationError> {
        let mut found = Vec::new();
        for index in 0..self.count().map_err(named(source))? {
            let curve = self.curve(index).map_err(named(source))?;
            found.push(curve.closest(point).map_err(named(source))?.distance);
        }
        let best = (0..found.len()).min_by(|&a, &b| found[a].total_cmp(&found[b]));
        let Some(best) = best else {
            return Err(p.error("edge", format!("\"{source}\" has no edges")).into());
        };
        let others = as_near(found.iter().copied(), found[best], point);
        Ok((best, nearest_note(scene, &self.name(best), found[best], point, others)))
    }

    /// The edge as messages call it: `edge u1`, `edge 3`.
    fn name(&self, index: usize) -> String {
        match self {
            Self::Shape(geometry) => {
                let of =
                    |shape| edges_of(shape, "edge").ok()?.edge(index).map(|edge| edge.called().into_owned());
                geometry.shape().ok().and_then(of).unwrap_or_else(|| format!("edge {index}"))
            }
            Self::Brep(_) => format!("edge {index}"),
        }
    }

    /// The edge from its start to its end.
    fn curve(&self, index: usize) -> loftsman_kernel::Result<Curve> {
        match self {
            Self::Shape(geometry) => Ok(EdgeCurve::of(geometry.shape()?, index, "edge")?.curve),
            Self::Brep(brep) => {
                let none = || Error::Invalid(format!("there is no edge {index}"));
                let edge = brep.edge(index).ok_or_else(none)?;
                let (from, to) = edge.range;
                let whole = edge.curve.domain() == edge.range;
                if whole { Ok(edge.curve) } else { edge.curve.between(from, to) }
            }
        }
    }
}
