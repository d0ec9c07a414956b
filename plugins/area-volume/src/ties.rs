//! What keeps a boundary closed while it is edited: points that must stay together.

use std::sync::Arc;

use loftsman_kernel::Result;
use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{DeclaredFunctional, Functional, Linearity, On, Rows, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Declaration, ParameterError, Parameters};
use loftsman_kernel::shape::Stencil;
use loftsman_kernel::topology::Shell;

use crate::contour::Contour;
use crate::members::{Members, OBJECT, OBJECTS, by_themselves, is_surface, shell_members};
use crate::tie::Tie;

/// A boundary that stays closed: curves whose ends meet, surfaces whose edges do, poles that stay points. Three linear
/// equations, alike in all axes, for each pair of points that must stay together; none for a periodic shape.
///
/// It goes along with [`Area`](crate::Area), [`Volume`](crate::Volume) and [`Centroid`](crate::Centroid) by itself. Which
/// points belong together is found when an edit starts: ends and edges within 1e-9 of the size of the whole; [`gap`] says
/// by how much a boundary is open. Edges may differ in degree, knots, direction, where their parameters run from and to and,
/// if periodic, where they start: compared, and tied, in the space that holds both, `n + m` rows for `n` and `m` knots (what
/// these say twice is found redundant). An edge meets one other all along; one that several share must be split.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed {
    members: Members,
    ties: Option<Arc<Vec<Tie>>>,
}

/// What to do where ends are apart that are to be held.
const MEET: &str = "this kind holds ends that meet already: close it first (while it moves `tied` draws two points together)";

/// The boundary that the first shape of the problem is.
pub fn closed() -> Closed {
    Closed::of_members(Members::default())
}

impl Closed {
    /// The boundary that these shapes are together.
    #[must_use]
    pub fn of<T: Into<On>>(self, shapes: impl IntoIterator<Item = T>) -> Self {
        Self::of_members(shapes.into_iter().collect())
    }

    pub(crate) fn of_members(members: Members) -> Self {
        Self { members, ties: None }
    }

    fn found(&self, shapes: &Shapes<'_>) -> Result<Arc<Vec<Tie>>> {
        if let Some(ties) = &self.ties {
            return Ok(Arc::clone(ties));
        }
        let first = self.members.0.first().ok_or_else(|| Error::Invalid("closed: of no shape".into()))?;
        let what = self.describe();
        let ties = if is_surface(shapes, first)? {
            // What says itself what it bounds keeps itself together.
            let alone = by_themselves(shapes, &self.members.0, &what)?;
            let rest = self.members.0.iter().zip(&alone).filter(|(_, alone)| !**alone);
            let rest: Vec<On> = rest.map(|(on, _)| on.clone()).collect();
            if rest.is_empty() {
                return Ok(Arc::new(Vec::new()));
            }
            let of = |(member, stencil): (usize, Stencil)| (rest[member].shape, stencil);
            let found = Shell::find(&shell_members(shapes, &rest, &what)?, &what)?.ties;
            found.into_iter().map(|tie| Tie { first: of(tie.first), second: of(tie.second) }).collect()
        } else {
            Contour::find(shapes, &self.members.0, &what, MEET)?.ties
        };
        Ok(Arc::new(ties))
    }
}

/// By how much the boundary that these shapes are together is open: the largest distance between ends or edges that are
/// next to one another, zero for periodic shapes. The unit is that of the shapes.
///
/// # Errors
/// When a shape is not there, or they are not all curves or all surfaces.
pub fn gap(shapes: &Shapes<'_>, members: &[On]) -> Result<f64> {
    let first = members.first().ok_or_else(|| Error::Invalid("the gap of no shapes".into()))?;
    if is_surface(shapes, first)? {
        Shell::gap(&shell_members(shapes, members, "gap")?, "gap")
    } else {
        Contour::gap(shapes, members)
    }
}

impl Functional for Closed {
    fn equations(&self) -> usize {
        self.ties.as_ref().map_or(0, |ties| 3 * ties.len())
    }

    fn linearity(&self) -> Linearity {
        Linearity::Linear
    }

    fn rows(&self, shapes: &Shapes<'_>, rows: &mut Rows<'_>) -> Result<()> {
        for tie in self.found(shapes)?.iter() {
            let ((a, first), (b, second)) = (&tie.first, &tie.second);
            rows.difference((*a, first), (*b, second));
        }
        Ok(())
    }

    fn value(&self, shapes: &Shapes<'_>, out: &mut [f64]) -> Result<()> {
        for (tie, out) in self.found(shapes)?.iter().zip(out.chunks_exact_mut(3)) {
            out.copy_from_slice(tie.gap(shapes)?.as_slice());
        }
        Ok(())
    }

    fn describe(&self) -> String {
        format!("closed{}", self.members)
    }

    fn dimension(&self) -> Option<u8> {
        Some(1)
    }

    fn bind(&self, shapes: &Shapes<'_>) -> Result<Option<Arc<dyn Functional>>> {
        Ok(Some(Arc::new(Self { members: self.members.clone(), ties: Some(self.found(shapes)?) })))
    }

    fn is_condition(&self) -> bool {
        true
    }
}

impl DeclaredFunctional for Closed {
    const DECLARATION: Declaration = Declaration {
        name: "closed",
        help: "ends and edges that meet stay together; area and volume bring it along",
        fields: &[OBJECT, OBJECTS],
    };

    fn from_parameters(parameters: &Parameters, names: &mut dyn ShapeNames) -> Result<Self, ParameterError> {
        Ok(Self::of_members(Members::from_parameters(parameters, names, "objects")?))
    }
}
