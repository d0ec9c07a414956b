//! An edge kept on another surface's edge, with its tangent planes and its curvature.

mod between;
mod bound;
mod profile;

use std::sync::Arc;

use loftsman_kernel::Vector;
use loftsman_kernel::error::Result;
use loftsman_kernel::functional::{Edge, Functional, Linearity, On, Rows, Shapes, Told};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::text::{figure, measured};

use self::between::Between;
use self::bound::Bound;
use crate::beside::{Askew, Begun};
use crate::contact::Contact;
use crate::deviation::{Deviation, Limits};
use crate::edge_on::unbound;

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

    /// The same with everything fixed that it takes from the shapes' state.
    pub(crate) fn bound_to(&self, shapes: &Shapes<'_>) -> Result<Self> {
        let bound = Self { bound: None, ..self.clone() }.fixed(shapes)?;
        Ok(Self { bound: Some(bound), ..self.clone() })
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
