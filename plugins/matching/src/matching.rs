//! An edge kept on another surface's edge, with its tangent planes and its curvature.

use std::sync::Arc;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::functional::{
    Accuracy, DeclaredFunctional, Edge, Functional, Linearity, On, Rows, ShapeNames, Shapes, Told,
};
use loftsman_kernel::plugin::{Declaration, Field, ParameterError, Parameters};
use loftsman_kernel::shape::{Derivative, Shape, Stencil, strips};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::{figure, measured};
use loftsman_kernel::topology::EdgeCurve;
use loftsman_kernel::{Point, Vector};

use crate::beside::{Askew, Begun, Beside, Track, edge_of};
use crate::contact::{Contact, Frame, Partials};
use crate::deviation::{Deviation, Limits};
use crate::edge_on::{OBJECT, named, rows, tolerance, unbound};
use crate::near::{Near, Place};

/// Positions that are to be equal to rounding are looked at between with this part of the edge's size.
const ROUNDING: f64 = 1e-9;
/// Tangent planes before and behind a place, in radians, that differ by no more are one.
const SHARP: f64 = 1e-4;
/// A surface whose curvatures are smaller than this, divided by the edge's size, is flat to rounding.
const FLAT: f64 = 1e-8;

/// A whole edge of a surface that meets the edge of another one, which stands still: with continuity 0 in position, with 1 in
/// the tangent planes too (G¹), with 2 in the curvature (G²), whatever the parametrisations. At places of the edge, `s` running
/// across it, with the other surface's unit normal `n` and its second fundamental form `II`:
///
/// ```text
/// S = T,   n·S_s = 0,   n·S_ss = II(S_s, S_s)
/// ```
///
/// Where position and tangent planes agree all along an edge, and the second fundamental forms for one direction across it, they
/// agree for all directions (J. Pegna and F.-E. Wolter, Geometrical criteria to guarantee curvature continuity of blend surfaces,
/// J. Mech. Des. 114, 1992). What is measured is the difference of the normal curvatures square to the edge, each surface's own.
///
/// Position as in [`EdgeOn`](crate::EdgeOn), everywhere to rounding where the edge's space holds the other edge; the others at the edge's
/// Greville abscissae, as many places as it has control vertices. Linear up to continuity 1. Between these places all is
/// [measured](Self::deviation), and refused where it is outside the [`Limits`]: more knots along the edge bring it nearer.
#[derive(Debug, Clone, PartialEq)]
pub struct Matching {
    on: On,
    edge: Edge,
    other: On,
    other_edge: Edge,
    continuity: usize,
    limits: Limits,
    /// Whether a closed edge may begin between the knots of the other.
    free: bool,
    /// Whether the lines across leave the edge as fast as those of the other surface arrive there, but for one factor all along the edge.
    led: bool,
    /// The way and the start, where they are known.
    begun: Option<Begun>,
    bound: Option<Arc<Bound>>,
}

/// An edge of the first shape that meets the edge of shape `other` of the problem with continuity 0, 1 or 2.
pub fn matching(
    edge: Edge,
    other: impl Into<On>,
    other_edge: Edge,
    continuity: usize,
    limits: Limits,
) -> Matching {
    Matching {
        on: On::default(),
        edge,
        other: other.into(),
        other_edge,
        continuity,
        limits,
        free: false,
        led: false,
        begun: None,
        bound: None,
    }
}

/// What is fixed when an edit starts.
#[derive(Debug, PartialEq)]
struct Bound {
    rows: Vec<(Stencil, Point)>,
    contacts: Vec<Contact>,
    /// Contacts with what lies before a corner of the other edge where there is one with what lies behind it, or the other way round.
    corners: Vec<Contact>,
    between: Vec<Place>,
    /// How the other edge's parameters go along with this one's.
    track: Track,
    /// Whether closed edges were not begun where they are nearest to one another.
    askew: Option<Askew>,
    /// How far the edges may be apart between the places where they meet.
    distance: f64,
    /// What differences of curvatures are measured by: the largest curvature of the surface that stands still.
    curvature: f64,
    /// The largest of its curvatures square to the edge; 0 where these are rounding.
    square: f64,
    /// Whether that one is flat along the edge, so that this is rounding.
    flat: bool,
    /// Places of the edges that are no further apart are at one another.
    apart: f64,
    /// Whether the surface stood at less than a right angle over the other one when this was bound, and whether it lay on it.
    folded: [bool; 2],
    /// How many times as fast as the other surface's lines across arrive at the edge those of this one leave it, where that is asked.
    lead: Option<f64>,
}

impl Bound {
    /// Equations of a contact.
    fn each(&self, continuity: usize) -> usize {
        continuity + usize::from(self.lead.is_some())
    }
}

impl Matching {
    /// The same with the edge of another shape of the problem.
    #[must_use]
    pub fn on(mut self, shape: impl Into<On>) -> Self {
        self.on = shape.into();
        self
    }

    /// The same, a closed edge beginning between knots of the other where the two are nearest there.
    #[must_use]
    pub(crate) fn free(mut self, free: bool) -> Self {
        self.free = free;
        self
    }

    /// The same, the way and the start being those that were found before knots were inserted.
    #[must_use]
    pub(crate) fn begun(mut self, begun: Begun) -> Self {
        self.begun = Some(begun);
        self
    }

    /// The same with the way across prescribed, square to the edge: `o·S_s = c |T_s|`, `o` being the direction in which the other surface would go on, `T_s` the
    /// part of its derivative square to the edge, and `c` the mean of what it is now. The tangent planes alone leave open on which side of the edge a surface
    /// lies; with this it cannot be folded back, and where `S_s = c T_s` it is met in the spaces that hold position.
    #[must_use]
    pub(crate) fn led(mut self, led: bool) -> Self {
        self.led = led;
        self
    }

    /// How far the surfaces are from one another, now: position, angle and curvature at places all along the edge, between those
    /// where they are imposed.
    ///
    /// # Errors
    /// When the match cannot be asked of these shapes.
    pub fn deviation(&self, shapes: &Shapes<'_>) -> Result<Deviation> {
        Ok(Deviation::worst(&self.profile(shapes)?))
    }

    /// The same with everything fixed that it takes from the shapes' state.
    pub(crate) fn bound_to(&self, shapes: &Shapes<'_>) -> Result<Self> {
        let bound = Self { bound: None, ..self.clone() }.fixed(shapes)?;
        Ok(Self { bound: Some(bound), ..self.clone() })
    }

    /// The deviation at many places all along the edge, its ends among them, and where between these each of its measures is largest; by the edge's
    /// parameter.
    pub(crate) fn profile(&self, shapes: &Shapes<'_>) -> Result<Vec<(f64, Deviation)>> {
        let bound = self.fixed(shapes)?;
        let other = shapes.get(self.other.shape)?;
        let there = edge_of(shapes, &self.other, self.other_edge, &self.describe())?;
        let edge = edge_of(shapes, &self.on, self.edge, &self.describe())?;
        let beside = Beside::along(edge, &there.curve, bound.track)?;
        let near = self.near(shapes, &bound)?;
        let step = self.step(shapes)?;
        let at = |t: f64| -> Result<Option<Deviation>> {
            let u = beside.there(t);
            let frame = match Frame::new(other, &there.edge, u) {
                Ok(frame) => frame,
                // Of position alone, a pole somewhere matters not.
                Err(_) if self.continuity == 0 => return Ok(None),
                Err(error) => return Err(error),
            };
            let (at, by) = (beside.at(t), Partials::new(&beside.edge.edge));
            let contact = Contact { at, by, at_end: beside.edge.edge.at_end, step, frame };
            let place = Place { t, point: there.curve.point(u)?, u, contact };
            Ok(Some(self.deviation_at(shapes, &bound, &near, &place)?))
        };
        let mut profile = Vec::new();
        for t in beside.told() {
            profile.extend(at(t)?.map(|found| (t, found)));
        }
        let peaks = crate::deviation::peaks(&profile, &at)?;
        profile.extend(peaks);
        profile.sort_by(|x, y| x.0.total_cmp(&y.0));
        Ok(profile)
    }

    fn deviations(&self, shapes: &Shapes<'_>, bound: &Bound) -> Result<Vec<(f64, Deviation)>> {
        let near = self.near(shapes, bound)?;
        let each = bound.between.iter();
        each.map(|place| Ok((place.t, self.deviation_at(shapes, bound, &near, place)?))).collect()
    }

    fn deviation_at(
        &self,
        shapes: &Shapes<'_>,
        bound: &Bound,
        near: &Near<'_>,
        place: &Place,
    ) -> Result<Deviation> {
        let found = near.measure(shapes, place)?;
        let curvature = found.measured.curvature.abs();
        Ok(Deviation {
            distance: found.apart.norm(),
            angle: found.measured.angle,
            curvature,
            part: curvature / bound.curvature,
            square: if curvature > 0.0 { curvature / bound.square } else { 0.0 },
            flat: bound.flat,
        })
    }

    /// What finds the places of the edges that are nearest to one another.
    fn near<'a>(&self, shapes: &Shapes<'a>, bound: &Bound) -> Result<Near<'a>> {
        let there = edge_of(shapes, &self.other, self.other_edge, &self.describe())?;
        let own = edge_of(shapes, &self.on, self.edge, &self.describe())?;
        Near::new(shapes.get(self.other.shape)?, there, self.on.shape, own, bound.apart)
    }

    fn fail<T>(&self, problem: &str) -> Result<T> {
        Err(Error::Invalid(format!("{}: {problem}", self.describe())))
    }

    fn fixed(&self, shapes: &Shapes<'_>) -> Result<Arc<Bound>> {
        if let Some(bound) = &self.bound {
            return Ok(Arc::clone(bound));
        }
        let (what, limits) = (self.describe(), &self.limits);
        if self.continuity > 2 {
            return self.fail(&format!("continuity {} is not 0, 1 or 2", self.continuity));
        }
        let wrong = |x: f64| !(x > 0.0 && x.is_finite());
        if limits.distance.is_some_and(wrong) || wrong(limits.angle) || wrong(limits.curvature) {
            return self.fail("its limits are to be finite numbers above 0");
        }
        if self.on.shape == self.other.shape {
            return self.fail("a surface cannot be matched to itself: it would have to stand still");
        }
        let other = shapes.get(self.other.shape)?;
        let there = edge_of(shapes, &self.other, self.other_edge, &what)?;
        if there.spread() == 0.0 {
            return self.fail("the edge beside is a point (a pole), which runs along nothing");
        }
        let edge = edge_of(shapes, &self.on, self.edge, &what)?;
        let size = edge.spread().max(there.spread());
        let beside = match self.begun {
            Some(begun) => Beside::begun(edge, &there.curve, begun)?,
            None => Beside::new(edge, &there.curve, limits.distance.is_none() || !self.free)?,
        };
        let (rows, exact) = rows(&beside, shapes, &self.on, limits.distance, &what)?;
        let step = self.step(shapes)?;
        let contact = |t: f64| -> Result<Contact> {
            Ok(Contact {
                at: beside.at(t),
                by: Partials::new(&beside.edge.edge),
                at_end: beside.edge.edge.at_end,
                step,
                frame: Frame::new(other, &there.edge, beside.there(t))?,
            })
        };
        let contacts = if self.continuity > 0 {
            beside.greville().into_iter().map(contact).collect::<Result<_>>()?
        } else {
            Vec::new()
        };
        let corners = self.corners(&beside, &contacts, &contact)?;
        let between = self.between(&beside, exact && self.continuity == 0, &there, &contact)?;
        let curvature = between.iter().fold(0.0, |m: f64, place| m.max(place.contact.frame.largest));
        let square = between.iter().fold(0.0, |m: f64, place| m.max(place.contact.frame.curvature.abs()));
        let rounding = FLAT / size;
        let square = if square > rounding { square } else { 0.0 };
        let (curvature, flat) = (curvature.max(rounding), curvature <= rounding);
        let distance = limits.distance.unwrap_or(ROUNDING * size);
        let apart = ROUNDING * size;
        let mut bound = Bound {
            rows,
            contacts,
            corners,
            between,
            track: beside.track(),
            askew: beside.askew(),
            distance,
            curvature,
            square,
            flat,
            apart,
            folded: [false; 2],
            lead: None,
        };
        if self.led {
            bound.lead = lead(shapes.get(self.on.shape)?, &bound.contacts)?;
        }
        if self.continuity > 0 {
            let profile = self.deviations(shapes, &bound)?;
            bound.folded = [Deviation::folded(&profile), Deviation::lies_on(&profile, limits)];
        }
        Ok(Arc::new(bound))
    }

    /// Where the other surface has another tangent plane before a place of contact than behind it, as at a corner of its edge, the surface that moves has to lie
    /// in both: it can, along the line in which they meet, where its own edge has a corner, too.
    fn corners(
        &self,
        beside: &Beside,
        contacts: &[Contact],
        contact: &dyn Fn(f64) -> Result<Contact>,
    ) -> Result<Vec<Contact>> {
        let mut corners = Vec::new();
        if contacts.is_empty() {
            return Ok(corners);
        }
        for (k, sides) in beside.knots_met() {
            // Which of them the place itself shows is a matter of rounding.
            for side in sides {
                let (at, here) = (contact(side)?, &contacts[k]);
                if at.frame.normal.cross(&here.frame.normal).norm() > SHARP {
                    corners.push(Contact { at: here.at, ..at });
                }
            }
        }
        Ok(corners)
    }

    /// The parameter step by which derivatives across are made lengths.
    fn step(&self, shapes: &Shapes<'_>) -> Result<f64> {
        let shape = shapes.get(self.on.shape)?;
        let largest =
            strips(shape, self.edge.number_on(shape)?, 1)?.get(1).map_or(0.0, |strip| strip.largest);
        let step = 1.0 / largest;
        if step > 0.0 && step.is_finite() {
            return Ok(step);
        }
        self.fail("the surface is too short across the edge: choose a longer domain")
    }

    fn between(
        &self,
        beside: &Beside,
        exact: bool,
        there: &EdgeCurve,
        contact: &dyn Fn(f64) -> Result<Contact>,
    ) -> Result<Vec<Place>> {
        let mut all = Vec::new();
        for t in beside.between(exact) {
            let u = beside.there(t);
            let point = there.curve.point(u)?;
            match contact(t) {
                Ok(contact) => all.push(Place { t, point, u, contact }),
                // Of position alone, a pole somewhere matters not.
                Err(_) if self.continuity == 0 => {}
                Err(error) => return Err(error),
            }
        }
        Ok(all)
    }
}

impl Functional for Matching {
    fn equations(&self) -> usize {
        match &self.bound {
            Some(bound) => {
                let corners = self.continuity * bound.corners.len();
                3 * bound.rows.len() + bound.each(self.continuity) * bound.contacts.len() + corners
            }
            None => 3 + self.continuity,
        }
    }

    fn linearity(&self) -> Linearity {
        if self.continuity < 2 { Linearity::Linear } else { Linearity::Nonlinear }
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let Some(bound) = &self.bound else { return Err(unbound(&self.describe())) };
        for (stencil, point) in &bound.rows {
            rows.alike(self.on.shape, stencil);
            rows.constant(-point.coords);
        }
        for contact in &bound.contacts {
            put(rows, shapes, self.on.shape, contact, self.continuity, [1.0, 1.0])?;
            if let Some(lead) = bound.lead {
                let across = shapes.stencil(self.on.shape, contact.at, contact.by.of(0, 1))?;
                let (direction, speed) = contact.lead();
                rows.equation().along(self.on.shape, &across, direction * contact.step);
                rows.constant(Vector::new(-lead * speed * contact.step, 0.0, 0.0));
            }
        }
        for contact in &bound.corners {
            put(rows, shapes, self.on.shape, contact, self.continuity, [1.0, 1.0])?;
        }
        Ok(())
    }

    /// Before it is bound: the difference of position where it is largest, then the largest of the others.
    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let shape = shapes.get(self.on.shape)?;
        let Some(bound) = &self.bound else {
            let found = self.deviation(shapes)?;
            let all = [found.distance, 0.0, 0.0, found.angle, found.curvature];
            out.iter_mut().zip(all).for_each(|(out, value)| *out = value);
            return Ok(());
        };
        let (positions, others) = out.split_at_mut(3 * bound.rows.len());
        for ((stencil, point), out) in bound.rows.iter().zip(positions.chunks_exact_mut(3)) {
            out.copy_from_slice((stencil.apply(shape.control_vertices()) - point.coords).as_slice());
        }
        let each = bound.each(self.continuity);
        let (others, corners) = others.split_at_mut(each * bound.contacts.len());
        for (contact, out) in bound.corners.iter().zip(corners.chunks_exact_mut(self.continuity.max(1))) {
            let found = contact.measure(shape)?;
            out.iter_mut().zip([found.slope, found.bend]).for_each(|(out, value)| *out = value);
        }
        for (contact, out) in bound.contacts.iter().zip(others.chunks_exact_mut(each.max(1))) {
            let found = contact.measure(shape)?;
            out.iter_mut().zip([found.slope, found.bend]).for_each(|(out, value)| *out = value);
            if let (Some(lead), Some(out)) = (bound.lead, out.last_mut()) {
                let (direction, speed) = contact.lead();
                let across = shape.value(contact.at, contact.by.of(0, 1))?;
                *out = (direction.dot(&across) - lead * speed) * contact.step;
            }
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("G{} match of {}{} to {}{}", self.continuity, self.edge, self.on, self.other_edge, self.other)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        Ok(Some(Arc::new(self.bound_to(shapes)?)))
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn told(&self, shapes: &Shapes<'_>) -> Result<Option<Told>> {
        let bound = self.fixed(shapes)?;
        let profile = self.deviations(shapes, &bound)?;
        let (worst, count) = (Deviation::worst(&profile), bound.contacts.len().max(bound.rows.len()));
        let is_surface = (shapes.get(self.on.shape)? as &dyn std::any::Any).is::<Surface>();
        let folds = self.continuity > 0 && Deviation::folded(&profile);
        let remedy = if folds && bound.folded[1] {
            "one surface lies folded back on the other: turn it round, or ask for continuity 0".to_owned()
        } else if folds && bound.folded[0] {
            let operation = if is_surface { ", use the operation `match`, which bends it round" } else { "" };
            format!(
                "it stands at less than a right angle over the other, and brought there it would fold back on it: turn it round{operation}, or ask for \
                 continuity 0"
            )
        } else if folds {
            "brought there it would fold back on the other, which it does not now: bring it nearer first, let more of it move, or \
             ask for continuity 0"
                .to_owned()
        } else {
            let more = if is_surface {
                format!(
                    "insert knots along the edge, which has {count} control vertices (the operation `match` inserts them by itself)"
                )
            } else {
                format!("give the edge more control vertices than its {count}: subdivide once more")
            };
            let allowed = self.limits.up_to(self.continuity, bound.distance);
            match worst.allowing(self.continuity, bound.distance, &self.limits) {
                Some(limits) if limits.is_empty() => format!("{allowed} is allowed: allow more, or {more}"),
                Some(limits) => format!("{allowed} is allowed: allow more ({limits}), or {more}"),
                None => format!(
                    "{allowed} is allowed, and beyond a right angle it folds back on the other there, as where an edge turns back or a surface shrinks to a \
                     point: ask for continuity 0, or {more}"
                ),
            }
        };
        let found = format!("the surfaces are apart by {}", worst.up_to(self.continuity));
        Ok(Some(Told { found, remedy }))
    }

    fn notes(&self) -> Vec<String> {
        let Some(Askew { turn, nearest, seam }) = self.bound.as_ref().and_then(|bound| bound.askew) else {
            return Vec::new();
        };
        // The operation has tried to begin between them already.
        let begins = if self.begun.is_some() {
            if seam {
                "; without its seam it may begin between them (`simplify` with `periodic = true` takes the seam away)"
            } else {
                ""
            }
        } else if seam {
            "; an edge with a seam may bend where it begins between them: make the surface periodic (`simplify` with `periodic = true` takes the seam away), and use the operation `match`"
        } else {
            "; the operation `match` begins between them where that asks for no corners and not for too many knots"
        };
        vec![format!(
            "{} begins at a knot of the other edge, {}° of a turn from where the two are nearest, which is at {} of that: lines across run askew by as much{begins}",
            self.describe(),
            figure(360.0 * turn),
            measured(nearest)
        )]
    }

    fn witness(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        let bound = self.fixed(shapes)?;
        Ok(Some(Arc::new(Between { of: Self { bound: Some(bound), ..self.clone() } })))
    }
}

/// By what factor the lines across of a surface leave its edge faster than those of the other one arrive there, in the mean; `None` where one of them does not.
fn lead(shape: &dyn Shape, contacts: &[Contact]) -> Result<Option<f64>> {
    let (mut own, mut other) = (0.0, 0.0);
    for contact in contacts {
        own += contact.across(shape)?;
        other += contact.lead().1;
    }
    let lead: f64 = own / other;
    Ok(Some(lead).filter(|lead| *lead > 0.0 && lead.is_finite()))
}

/// The rows of a contact, each times a factor.
fn put(
    rows: &mut Rows<'_>,
    shapes: &Shapes<'_>,
    on: usize,
    contact: &Contact,
    continuity: usize,
    by: [f64; 2],
) -> Result<()> {
    let normal = contact.frame.normal;
    let stencil = |along, across| shapes.stencil(on, contact.at, contact.by.of(along, across));
    let across = stencil(0, 1)?;
    rows.equation().along(on, &across, normal * (contact.step * by[0]));
    if continuity > 1 {
        let half = contact.frame.second(&across.apply(shapes.get(on)?.control_vertices())).1;
        let step = contact.step * contact.step * by[1];
        let second = stencil(0, 2)?;
        rows.equation().along(on, &second, normal * step).along(on, &across, half * (-2.0 * step));
    }
    Ok(())
}

/// The match looked at between the places where it was imposed: every number divided by its limit and multiplied by the
/// allowed distance, so that one accuracy judges all.
#[derive(Debug)]
struct Between {
    of: Matching,
}

impl Between {
    fn bound(&self) -> Result<&Bound> {
        self.of.bound.as_deref().ok_or_else(|| unbound(&self.of.describe()))
    }

    /// The factors of slope and bend at a place that make them lengths to be judged by the allowed distance.
    fn factors(&self, shapes: &Shapes<'_>, bound: &Bound, contact: &Contact) -> Result<[f64; 2]> {
        let across = contact.across(shapes.get(self.of.on.shape)?)? * contact.step;
        let limits = &self.of.limits;
        let slope = bound.distance / (limits.angle.sin() * across);
        let bend = bound.distance / (limits.curvature * bound.curvature * across * across);
        Ok([slope, bend].map(|factor| if factor.is_finite() { factor } else { 1.0 }))
    }
}

impl Functional for Between {
    fn equations(&self) -> usize {
        let count = self.of.bound.as_ref().map_or(0, |bound| bound.between.len());
        (3 + self.of.continuity) * count
    }

    fn linearity(&self) -> Linearity {
        Linearity::Nonlinear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        let (bound, on) = (self.bound()?, self.of.on.shape);
        for place in &bound.between {
            rows.alike(on, &shapes.stencil(on, place.contact.at, Derivative::POSITION)?);
            rows.constant(-place.point.coords);
            if self.of.continuity > 0 {
                let by = self.factors(shapes, bound, &place.contact)?;
                put(rows, shapes, on, &place.contact, self.of.continuity, by)?;
            }
        }
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        let bound = self.bound()?;
        let near = self.of.near(shapes, bound)?;
        for (place, out) in bound.between.iter().zip(out.chunks_exact_mut(3 + self.of.continuity)) {
            let (found, limits) = (near.measure(shapes, place)?, &self.of.limits);
            let (apart, found) = (found.apart, found.measured);
            // The planes may differ along the edge as well, where positions do: what counts is the whole angle, and each
            // surface's own curvature.
            let angle = found.angle / limits.angle * bound.distance;
            let curvature = found.curvature / (limits.curvature * bound.curvature) * bound.distance;
            let all = [apart.x, apart.y, apart.z, angle.copysign(found.slope), curvature];
            out.iter_mut().zip(all).for_each(|(out, value)| *out = value);
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("{}, all along", self.of.describe())
    }

    fn is_condition(&self) -> bool {
        true
    }

    fn accuracy(&self) -> Accuracy {
        self.of.bound.as_ref().map_or(Accuracy::Rounding, |bound| Accuracy::Within(bound.distance))
    }
}

pub(crate) const LIMITS: [Field; 3] = [
    Field::optional("tolerance", "length", "none: to rounding, or refused", "how far the edges may be apart"),
    Field::optional(
        "angle",
        "degrees",
        "0.1",
        "the largest angle between the surfaces, from continuity 1 on",
    ),
    Field::optional(
        "curvature",
        "number (percent)",
        "5",
        "with continuity 2, the largest difference of the normal curvatures square to the edge, of the largest curvature of the other \
         surface along it",
    ),
];

/// The limits that fields give; those that nothing would be judged by with this continuity are refused.
pub(crate) fn limits(p: &Parameters, continuity: usize) -> Result<Limits, ParameterError> {
    for (field, least) in [("angle", 1), ("curvature", 2)] {
        if p.has(field) && continuity < least {
            let problem = format!(
                "it limits nothing with continuity {continuity}: say continuity = {least}, or leave it out"
            );
            return Err(p.error(field, problem));
        }
    }
    let default = Limits::default();
    Ok(Limits {
        distance: tolerance(p, "tolerance")?,
        angle: tolerance(p, "angle")?.map_or(default.angle, f64::to_radians),
        curvature: tolerance(p, "curvature")?.map_or(default.curvature, |percent| percent / 100.0),
    })
}

pub(crate) const EDGE: Field = Field::required(
    "edge",
    "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"",
    "the edge that moves: where u or v starts or ends",
);
pub(crate) const WITH: Field =
    Field::required("with", "{ object, edge }", "the surface that stands still, and which of its edges");

/// What the field `with` names.
pub(crate) fn other(p: &Parameters) -> Result<Parameters, ParameterError> {
    const FIELDS: [Field; 2] = [
        Field::required("object", "text", "the surface that stands still"),
        Field::required("edge", "\"u0\" | \"u1\" | \"v0\" | \"v1\" | \"edge 3\"", "its edge"),
    ];
    if let Some(name) = p.value("with").and_then(|with| with.as_str()) {
        let problem =
            format!("an object and its edge are needed: with = {{ object = \"{name}\", edge = \"u0\" }}");
        return Err(p.error("with", problem));
    }
    let with = p.table("with")?;
    with.check(&FIELDS)?;
    Ok(with)
}

pub(crate) const CONTINUITY: Field =
    Field::optional("continuity", "0 | 1 | 2", "1", "position, tangent planes (G1), curvature (G2)");

/// The field `continuity`.
pub(crate) fn continuity(p: &Parameters) -> Result<usize, ParameterError> {
    match p.count_or("continuity", 1)? {
        order @ 0..=2 => Ok(order),
        order => Err(p.error("continuity", format!("{order} is not 0, 1 or 2"))),
    }
}

impl DeclaredFunctional for Matching {
    const DECLARATION: Declaration = Declaration {
        name: "match",
        help: "an edge meets the edge of another surface, which stands still: in position, tangent planes (G1), curvature (G2)",
        fields: &[EDGE, WITH, CONTINUITY, LIMITS[0], LIMITS[1], LIMITS[2], OBJECT],
    };

    fn from_parameters(p: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        let with = other(p)?;
        let continuity = continuity(p)?;
        Ok(Self {
            edge: Edge::from_parameters(p, "edge")?,
            other: named(&with, "object", names)?,
            other_edge: Edge::from_parameters(&with, "edge")?,
            on: On::from_parameters(p, names)?,
            continuity,
            limits: limits(p, continuity)?,
            free: false,
            led: false,
            begun: None,
            bound: None,
        })
    }
}
