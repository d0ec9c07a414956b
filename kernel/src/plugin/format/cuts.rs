//! How finely each object of a scene is cut on its way out, and at which points on its border, so that what hangs together still does.

use std::borrow::Cow;

use nalgebra::Matrix4;

use super::error::FormatError;
use super::outgoing::Outgoing;
use crate::Point;
use crate::error::Result;
use crate::scene::placement::transform_point;
use crate::scene::{Geometry, Joined, Scene, similarity};
use crate::tessellator::{Beside, Chord, Fineness, Tessellator};
use crate::topology::Nearby;

/// How finely the objects of a scene are cut: of surfaces that hang together relative to all of them, so that they still do.
#[derive(Debug)]
pub struct Cuts {
    fineness: Fineness,
    /// Lengths that were asked for to those of the scene.
    scale: f64,
    /// For each object what it hangs together with.
    joined: Vec<Option<Joined>>,
    /// For each object the points at which it and what it hangs together with are cut, in the scene's coordinates; none where nothing hangs
    /// together as points only.
    borders: Vec<Vec<Point>>,
    /// For each object the map from its own coordinates to the scene's; none where there are no borders.
    world: Vec<Option<Matrix4<f64>>>,
}

impl Outgoing<'_> {
    /// How finely each object is cut of a scene that is [this one](Self::scene), [converted](Self::converted) or not; a length that was
    /// asked for is `scale` of that in its unit.
    ///
    /// # Errors
    /// When the hierarchy is broken.
    pub fn cuts(&self, scene: &Scene, scale: f64) -> Result<Cuts, FormatError> {
        Ok(Cuts::new(scene, self.options.fineness, scale, self.options.tessellator)?)
    }
}

impl Cuts {
    /// `O(s log s)` for `s` surfaces, and cutting the borders of those that hang together as points only.
    fn new(
        scene: &Scene,
        fineness: Fineness,
        scale: f64,
        tessellator: Option<&dyn Tessellator>,
    ) -> Result<Self> {
        let mut cuts =
            Self { fineness, scale, joined: scene.joined()?, borders: Vec::new(), world: Vec::new() };
        if let Some(tessellator) = tessellator
            && cuts.joined.iter().flatten().any(|joined| joined.as_points)
        {
            cuts.world = scene.world_transforms()?;
            cuts.borders = cuts.borders(scene, tessellator);
        }
        Ok(cuts)
    }

    /// How finely the object of this number is cut, in the scene's coordinates.
    pub fn of(&self, index: usize) -> Fineness {
        let chord = match (self.fineness.chord, self.joined.get(index).and_then(Option::as_ref)) {
            (Chord::Absolute(length), _) => Chord::Absolute(length * self.scale),
            (Chord::Relative(fraction), Some(joined)) => Chord::Absolute(fraction * joined.diagonal),
            (chord, None) => chord,
        };
        Fineness { chord, ..self.fineness }
    }

    /// What is beside the border of the object of this number, in the scene's coordinates, where it hangs together with something that is
    /// so as points only anywhere: cut it by [`Tessellator::measured_surface_beside`] then.
    pub fn beside(&self, index: usize) -> Option<Beside<'_>> {
        let near = self.joined.get(index)?.as_ref().filter(|joined| joined.as_points)?.near;
        let points = self.borders.get(index).map(Vec::as_slice).unwrap_or_default();
        Some(Beside { points, near })
    }

    /// The same in the object's own coordinates: points, and which are one. `None` also where its transforms flatten it or stretch it unevenly: its
    /// chords are no others' then.
    pub fn beside_in_its_own(&self, index: usize) -> Option<(Vec<Point>, f64)> {
        let Beside { points, near } = self.beside(index)?;
        let Some(map) = self.world.get(index)? else { return Some((points.to_vec(), near)) };
        let (scale, back) = (similarity(map)?, map.try_inverse()?);
        Some((points.iter().map(|p| transform_point(&back, p)).collect(), near / scale))
    }

    /// For each object the points on its border, and on those of what it is beside. Points that are near one another are one, the first.
    fn borders(&self, scene: &Scene, tessellator: &dyn Tessellator) -> Vec<Vec<Point>> {
        let mut borders: Vec<Vec<Point>> = Vec::with_capacity(self.joined.len());
        for (index, (object, map)) in scene.objects().iter().zip(&self.world).enumerate() {
            let placed = match (object.geometry(), map) {
                (Geometry::Surface(_), None) if self.beside(index).is_some() => {
                    Some(Cow::Borrowed(object.geometry()))
                }
                (Geometry::Surface(_), Some(map)) if self.beside(index).is_some() => {
                    object.geometry().transformed(map).ok().map(Cow::Owned)
                }
                _ => None,
            };
            // What cannot be placed or cut is told when it is.
            let border = match placed.as_deref() {
                Some(Geometry::Surface(surface)) => tessellator.border(surface, &self.of(index)).ok(),
                _ => None,
            };
            borders.push(border.unwrap_or_default());
        }
        let low = borders.iter().flatten().copied().reduce(|a, b| a.inf(&b)).unwrap_or_else(Point::origin);
        let near = self.joined.iter().flatten().map(|joined| joined.near).fold(f64::INFINITY, f64::min);
        let mut known = Nearby::new(low, near);
        for point in borders.iter_mut().flatten() {
            match known.find(point, |other: &Point| (other - *point).norm() <= near) {
                Some(other) => *point = *other,
                None => known.put(point, *point),
            }
        }
        let all = self.joined.iter().enumerate().map(|(index, joined)| {
            let beside = joined.iter().flat_map(|joined| &joined.beside);
            let parts = std::iter::once(&index).chain(beside).filter_map(|&k| borders.get(k));
            parts.flatten().copied().collect()
        });
        all.collect()
    }
}
