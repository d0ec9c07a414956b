//! What representations hold: solids, surfaces, curves, points, meshes.

use std::collections::HashSet;
use std::sync::Arc;

use loftsman_kernel::mesh::{Cloud, Polyline};
use loftsman_kernel::scene::Geometry;

use super::brep::{Builder, is_model};
use super::entity::{Got, Problem, deeper, entity, kind};
use super::facets;
use super::place::Space;
use super::report::Account;
use super::style::Styles;

/// Something that becomes an object.
#[derive(Clone)]
pub(crate) struct Item {
    pub(crate) name: String,
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) color: Option<[f64; 4]>,
    pub(crate) layer: Option<String>,
    /// The entity whose triangles it is.
    pub(crate) tessellation: Option<u64>,
}

/// A reader of items.
pub(crate) struct Items<'r, 'a, 'f> {
    pub(crate) space: Space<'r, 'f>,
    pub(crate) styles: &'r Styles,
    pub(crate) account: &'a mut Account<'r, 'f>,
    pub(crate) found: Vec<Item>,
    /// Points without anything around them: one cloud.
    points: Vec<loftsman_kernel::Point>,
    /// The sets that have been read.
    sets: HashSet<u64>,
}

impl<'r, 'a, 'f> Items<'r, 'a, 'f> {
    pub(crate) fn new(space: Space<'r, 'f>, styles: &'r Styles, account: &'a mut Account<'r, 'f>) -> Self {
        Self { space, styles, account, found: Vec::new(), points: Vec::new(), sets: HashSet::new() }
    }

    /// All items of a list; what cannot be read is left out.
    pub(crate) fn all(&mut self, numbers: &[u64], set: Option<u64>, depth: usize) {
        for &number in numbers {
            if let Err(problem) = self.one(number, set, depth) {
                if problem.number != number {
                    let text = format!("#{} in it is left out", problem.number);
                    self.account.problems(vec![Problem::new(number, text)]);
                }
                self.account.problems(vec![problem]);
            }
        }
        if !self.points.is_empty() {
            let geometry = Cloud { points: std::mem::take(&mut self.points) }.into();
            self.add(set.unwrap_or_default(), None, geometry);
        }
    }

    fn add(&mut self, number: u64, set: Option<u64>, geometry: Geometry) {
        // Solids have their names first, as all items of representations.
        let name = |number| entity(self.space.file, number).map(|e| e.args().name(0)).unwrap_or_default();
        let own = name(number);
        let name = if own.is_empty() { set.map(name).unwrap_or_default() } else { own };
        let either = [Some(number), set];
        let color = either.iter().flatten().find_map(|&number| self.styles.color(number));
        let layer = either.iter().flatten().find_map(|&number| self.styles.layer(number)).cloned();
        self.found.push(Item { name, geometry: Arc::new(geometry), color, layer, tessellation: None });
    }

    fn one(&mut self, number: u64, set: Option<u64>, depth: usize) -> Got<()> {
        let depth = deeper(number, depth)?;
        let kind = kind(self.space.file, number);
        match kind {
            b"GEOMETRIC_SET" | b"GEOMETRIC_CURVE_SET" => {
                // Else sets of sets would be read as often as there are ways to them.
                if !self.sets.insert(number) {
                    return Err(Problem::new(
                        number,
                        "this set lies in itself, or is named more than once: it is read once",
                    ));
                }
                let elements = self.space.entity(number)?.args().references(1)?;
                self.all(&elements, Some(number), depth);
                self.account.keep_alone(&[number]);
            }
            b"CARTESIAN_POINT" => {
                self.points.push(self.space.point(number)?);
                self.account.keep_alone(&[number]);
            }
            b"VERTEX_POINT" => {
                let point = self.space.entity(number)?.args().reference(1)?;
                self.points.push(self.space.point(point)?);
                self.account.keep_whole(&[number]);
            }
            b"AXIS2_PLACEMENT_3D" => self.account.keep_whole(&[number]),
            b"MAPPED_ITEM" => {}
            b"POLYLINE" => {
                let mut points = self.space.polyline_points(&self.space.entity(number)?)?;
                let closed = points.len() > 3 && points.first() == points.last();
                if closed {
                    points.pop();
                }
                self.add(number, set, Polyline { points, closed }.into());
                self.account.keep_whole(&[number]);
            }
            _ if is_model(kind) => self.model(number, set)?,
            _ if facets::is_one(kind) => {
                let mesh = facets::mesh(&self.space, number)?;
                self.add(number, set, mesh.into());
                // Whether it stays is seen when everything exact is read.
                if let Some(item) = self.found.last_mut() {
                    item.tessellation = Some(number);
                }
            }
            _ if is_curve(kind) => {
                let curve = self.space.bounded(number, 0)?;
                self.add(number, set, curve.into());
                self.account.keep_whole(&[number]);
            }
            b"CURVE_BOUNDED_SURFACE" => {
                let (trimmed, used) = self.space.curve_bounded(number)?;
                self.add(number, set, trimmed.into());
                self.account.keep_whole(&[number]);
                self.account.keep_parameters(&used);
            }
            _ if kind == b"PLANE"
                || kind.ends_with(b"_SURFACE")
                || kind.starts_with(b"B_SPLINE_SURFACE")
                || kind.starts_with(b"SURFACE_OF_") =>
            {
                self.surface(number, set)?;
            }
            b"" => self.of_several(number, set)?,
            // Anything else is accounted for by its type.
            _ => {}
        }
        Ok(())
    }

    fn of_several(&mut self, number: u64, set: Option<u64>) -> Got<()> {
        let entity = self.space.entity(number)?;
        if super::spline::is_one(&entity, &super::spline::CURVES) {
            let curve = self.space.spline_curve(&entity)?;
            self.add(number, set, curve.into());
            self.account.keep_whole(&[number]);
        } else if super::spline::is_one(&entity, &super::spline::SURFACES) {
            self.surface(number, set)?;
        }
        Ok(())
    }

    fn surface(&mut self, number: u64, set: Option<u64>) -> Got<()> {
        let sheet = self.space.sheet(number, 0)?;
        let surface = sheet.whole(number)?;
        sheet.told(number).into_iter().for_each(|note| self.account.note(note));
        self.add(number, set, surface.into());
        self.account.keep_whole(&[number]);
        Ok(())
    }

    fn model(&mut self, number: u64, set: Option<u64>) -> Got<()> {
        let model = Builder::build(self.space, self.styles, number)?;
        let shell = model.alone.get(1).copied();
        self.add(number, set, model.brep.into());
        if let Some(item) = self.found.last_mut() {
            // Some writers colour the shell instead of the solid.
            item.color = item.color.or_else(|| self.styles.color(shell?));
            item.layer = item.layer.take().or_else(|| self.styles.layer(shell?).cloned());
        }
        self.account.keep_whole(&model.whole);
        if model.problems.is_empty() {
            self.account.keep_alone(&model.alone);
        } else {
            self.account.keep_partial(&model.alone);
        }
        self.account.keep_parameters(&model.parameters);
        self.account.problems(model.problems);
        model.notes.into_iter().for_each(|note| self.account.note(note));
        Ok(())
    }
}

fn is_curve(kind: &[u8]) -> bool {
    kind.ends_with(b"_CURVE")
        || kind.starts_with(b"B_SPLINE_CURVE")
        || matches!(kind, b"LINE" | b"CIRCLE" | b"ELLIPSE" | b"PARABOLA" | b"HYPERBOLA")
}
