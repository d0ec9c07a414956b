//! How finely each object of a scene is cut on its way out, and at which points on its border, so that what hangs together still does.

use std::collections::HashMap;

use nalgebra::Matrix4;

use super::error::FormatError;
use super::outgoing::Outgoing;
use crate::Point;
use crate::error::Result;
use crate::scene::placement::transform_point;
use crate::scene::{Geometry, Joined, Scene, similarity};
use crate::tessellator::{Beside, Chord, Fineness, Tessellator};

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
        let mut known = Known::default();
        let mut own: Vec<Vec<Point>> = Vec::with_capacity(self.joined.len());
        for (index, (object, map)) in scene.objects().iter().zip(&self.world).enumerate() {
            let (Geometry::Surface(surface), Some(beside)) = (object.geometry(), self.beside(index)) else {
                own.push(Vec::new());
                continue;
            };
            let placed = map.as_ref().map(|map| object.geometry().transformed(map)).transpose();
            let border = match &placed {
                Ok(Some(Geometry::Surface(placed))) => tessellator.border(placed, &self.of(index)),
                _ => tessellator.border(surface, &self.of(index)),
            };
            // What cannot be cut is told when it is.
            let points = border.unwrap_or_default();
            own.push(points.into_iter().map(|p| known.find(p, beside.near)).collect());
        }
        let all = self.joined.iter().enumerate().map(|(index, joined)| {
            let beside = joined.iter().flat_map(|joined| &joined.beside);
            let parts = std::iter::once(&index).chain(beside).filter_map(|&k| own.get(k));
            parts.flatten().copied().collect()
        });
        all.collect()
    }
}

/// Points by where they are, each once.
#[derive(Default)]
struct Known(HashMap<[i64; 3], Vec<Point>>);

impl Known {
    /// The first point that was within `near` of this one, or itself from now on.
    fn find(&mut self, point: Point, near: f64) -> Point {
        // Cells so wide that few points are near a wall.
        let cell = |shift: f64| [0, 1, 2].map(|k| ((point[k] + shift) / (16.0 * near)).floor() as i64);
        let (below, above) = (cell(-near), cell(near));
        for corner in 0..8 {
            let key = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { below[k] } else { above[k] });
            let found = self.0.get(&key).into_iter().flatten().find(|p| (*p - point).norm() <= near);
            if let Some(found) = found {
                return *found;
            }
        }
        self.0.entry(cell(0.0)).or_default().push(point);
        point
    }
}
