//! What a section is cut from: one shape, or all that a group or an instance shows.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};

use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::scene::placement::transform_point;
use loftsman_kernel::scene::{Geometry, MOST_PLACED, Scene, Standing};
use loftsman_kernel::text::a;
use loftsman_kernel::{Error, Point};

use crate::Plane;
use crate::operations::as_curve;
use crate::section::bounds;

/// A shape that is cut.
pub(super) struct Part<'a> {
    /// Its path below the object of the step; `None` where it is that itself.
    pub(super) name: Option<String>,
    pub(super) geometry: Cow<'a, Geometry>,
    /// From its own coordinates to those of the object of the step.
    pub(super) standing: Standing,
    pub(super) layer: Option<String>,
}

impl Part<'_> {
    /// What it is called within an instance, or a group: `l-bracket` for the part `bracket_1/l-bracket` of the instance `bracket_1`.
    pub(super) fn within(&self, object: &str) -> Option<&str> {
        let path = self.name.as_deref()?;
        Some(path.strip_prefix(object).and_then(|rest| rest.strip_prefix('/')).unwrap_or(path))
    }

    /// A plane of the object's coordinates in its own.
    ///
    /// # Errors
    /// When its transform flattens it.
    pub(super) fn own(&self, plane: &Plane) -> Result<Plane, OperationError> {
        let Some(to) = self.standing.to_world() else { return Ok(*plane) };
        let name = self.name.as_deref().unwrap_or_default();
        let back = self.standing.back(name, "the plane")?;
        let point = back.map_or(plane.point(), |back| transform_point(&back, &plane.point()));
        // n · (A x + t − p) = (Aᵀ n) · (x − A⁻¹ (p − t)).
        Ok(Plane::new(point, to.fixed_view::<3, 3>(0, 0).tr_mul(&plane.normal()))?)
    }

    /// A point of its own coordinates in the object's.
    pub(super) fn seen(&self, point: &Point) -> Point {
        self.standing.to_world().map_or(*point, |to| transform_point(to, point))
    }
}

/// Whether a geometry can be cut.
pub(super) fn is_cut(geometry: &Geometry) -> bool {
    matches!(
        geometry,
        Geometry::Brep(_)
            | Geometry::Surface(_)
            | Geometry::Trimmed(_)
            | Geometry::Mesh(_)
            | Geometry::Curve(_)
    )
}

/// What is cut of an object: itself, or where it is a group or an instance all that it shows and that can be cut, as far as it is seen. Polylines,
/// which sections of meshes are, only where one is the object itself.
///
/// # Errors
/// When there is nothing that can be cut, the hierarchy is broken, or the object's transform flattens it.
pub(super) fn parts<'a>(scene: &'a Scene, object: &str) -> Result<Vec<Part<'a>>, Error> {
    let geometry = scene.object(object)?.geometry();
    match geometry {
        Geometry::Group | Geometry::Instance(_) => {}
        Geometry::Polyline(_) => {
            let line = as_curve(geometry).map_err(|e| Error::Invalid(format!("\"{object}\": {e}")))?;
            return Ok(line.map(|line| whole(Cow::Owned(line.into()))).into_iter().collect());
        }
        other if is_cut(other) => return Ok(vec![whole(Cow::Borrowed(geometry))]),
        other => {
            return Err(Error::Invalid(format!(
                "\"{object}\" is {}: a section is cut from a brep, a surface, trimmed or not, a mesh, a curve or a polyline, or from all that a group or an instance shows",
                a(&other.noun())
            )));
        }
    }
    let below = below(scene, object);
    let back = scene.standing(object)?.back(object, "what it shows")?;
    let (mut parts, mut hidden) = (Vec::new(), 0);
    for placed in scene.placed(MOST_PLACED)? {
        let outermost = placed.path.inside_out().last().unwrap_or(placed.object);
        if !below.contains(outermost.name()) || !is_cut(placed.object.geometry()) {
            continue;
        }
        if placed.is_hidden() {
            hidden += 1;
            continue;
        }
        let map = match (back, placed.to_world) {
            (Some(back), Some(own)) => Some(back * own),
            (back, own) => back.or(own),
        };
        let path = placed.path.to_string();
        let name = placed.object.name();
        parts.push(Part {
            name: Some(if path.is_empty() { name.to_owned() } else { format!("{path}/{name}") }),
            geometry: Cow::Borrowed(placed.object.geometry()),
            standing: Standing::by(map),
            layer: placed.layer().map(str::to_owned),
        });
    }
    if parts.is_empty() {
        let reason = if hidden > 0 { ": what it shows is on hidden layers" } else { "" };
        return Err(Error::Invalid(format!(
            "\"{object}\" shows no brep, surface, mesh or curve that could be cut{reason}"
        )));
    }
    Ok(parts)
}

/// The names of all groups and instances of a scene that show something that can be cut, and is seen. `O(what is shown)`.
///
/// # Errors
/// When the hierarchy is broken, or too much is shown.
pub(super) fn showing(scene: &Scene) -> Result<HashSet<&str>, Error> {
    let mut names: HashSet<&str> = HashSet::new();
    for placed in scene.placed(MOST_PLACED)? {
        if !is_cut(placed.object.geometry()) || placed.is_hidden() {
            continue;
        }
        let outermost = placed.path.inside_out().last().unwrap_or(placed.object);
        let mut above = scene.get(outermost.name());
        // As far as somebody has been before.
        while let Some(object) = above {
            if !names.insert(object.name()) {
                break;
            }
            above = object.parent.as_deref().and_then(|parent| scene.get(parent));
        }
    }
    Ok(names)
}

fn whole(geometry: Cow<'_, Geometry>) -> Part<'_> {
    Part { name: None, geometry, standing: Standing::default(), layer: None }
}

/// An object and those below it in the hierarchy.
fn below<'a>(scene: &'a Scene, object: &str) -> HashSet<&'a str> {
    let mut children: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for object in scene.objects() {
        if let Some(parent) = &object.parent {
            children.entry(parent).or_default().push(object.name());
        }
    }
    let mut found = HashSet::new();
    let mut open: Vec<&str> = scene.get(object).map(|object| object.name()).into_iter().collect();
    while let Some(name) = open.pop() {
        if found.insert(name) {
            open.extend(children.get(name).into_iter().flatten());
        }
    }
    found
}

/// The corners of the box round parts, in the coordinates of the object.
///
/// # Errors
/// When a coordinate overflows.
pub(super) fn ends(parts: &[Part<'_>]) -> Result<(Point, Point), Error> {
    let mut all: Option<(Point, Point)> = None;
    for part in parts {
        let found = match part.standing.seen(&part.geometry)?.as_ref() {
            Geometry::Surface(surface) => Some(surface.bounds()),
            Geometry::Curve(curve) => Some(curve.bounds()),
            // The control vertices of its surfaces may be far beyond it.
            Geometry::Brep(brep) => bounds(brep),
            other => {
                let boxes = other.points().iter().map(|p| (*p, *p));
                boxes.reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h)))
            }
        };
        all = match (all, found) {
            (Some((low, high)), Some((l, h))) => Some((low.inf(&l), high.sup(&h))),
            (all, found) => all.or(found),
        };
    }
    Ok(all.unwrap_or_default())
}
