//! A surface as bicubic splines.

use std::collections::BTreeMap;

use loftsman_kernel::space::Space;
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Vector};

use super::SubdivisionSurface;
use super::grids::Quads;
use super::last::{self, Corner};
use super::net::Net;
use super::pattern::{Pattern, Quadrant};
use super::regular;
use super::template::Templates;
use crate::cage::Cage;
use crate::catmull_clark::refine;
use crate::error::{Result, SubdivisionError};
use crate::part::Part;
use crate::topology::NONE;

/// Levels that are refined, at most.
pub(crate) const LEVELS: u32 = 56;
/// Quads of a level, and surfaces, at most.
pub(crate) const MOST: usize = 1 << 20;

/// A subdivision surface as B-spline surfaces, bicubic as Catmull and Clark's or biquadratic as Doo and Sabin's, and bicubic Bézier patches.
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    /// The surfaces, those first that are exact; their normals point where the surface's do.
    pub surfaces: Vec<Surface>,
    /// How many are exact. The others are Bézier patches at extraordinary vertices.
    pub exact: usize,
    /// A bound of the distance between the limit surface and the others, point by point; 0 where there are none.
    pub deviation: f64,
}

impl SubdivisionSurface {
    /// The diagonal of the box around the limits of the cage's vertices.
    pub(crate) fn size(&self) -> Result<f64> {
        let limits = crate::catmull_clark::limit_points(&self.cage)?;
        Ok(super::tessellate::diagonal(&limits))
    }

    /// The surface as bicubic splines, within a tolerance (a length, in the unit of the cage).
    ///
    /// *Regular faces* are put together to rectangles, as large as is found by going along their sides: uniform bicubic B-spline surfaces
    /// that are the limit surface exactly, one unit of parameters a face.
    ///
    /// *Round an extraordinary vertex* (and where anything is semi-sharp, and on faces that are no quads) there are rings of such surfaces,
    /// each half as large as the one before, exact as well, down to the level at which one bicubic Bézier patch for each remaining quad
    /// is near enough. It has the limit's positions, tangents and twists at its three regular corners, the exact boundary on its two outer
    /// sides, the limit's position at the extraordinary vertex and in the middles of the quad and of its inner sides, and along the inner
    /// sides, where the vertex is smooth, the limit's tangents.
    ///
    /// *How near* is bounded: patch and surface are compared over the same quadrants, by the differences of their Bézier points, down to a
    /// quadrant where the convex hulls of both are small; the largest distance of points of equal parameters is the deviation. All quads at
    /// one vertex end on one level, and have their common sides to the bit. Where surfaces of different size meet, the side of a large
    /// one is several of small ones: they are the same cubic curve piece by piece, to rounding (T-junctions without gaps).
    ///
    /// The number of surfaces grows with the logarithm of the tolerance. Cost: linear in the cage, and in the rings some 100 µs a quad.
    ///
    /// # Errors
    /// When the tolerance is not positive, or less than what rounding leaves of the surface; a face has more than 2048 vertices in the faces
    /// round it; semi-sharp creases need more than a million surfaces; a coordinate overflows.
    pub fn patches(&self, tolerance: f64) -> Result<Patches> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let (what, place, needed) = ("tolerance", "patches".to_owned(), "positive and finite");
            return Err(SubdivisionError::Value { what, place, value: tolerance, needed });
        }
        let open = (0..self.cage.topology().face_count()).filter(|&f| !self.cage.is_hole(f)).collect();
        let mut front = Front { cage: self.cage.clone(), open };
        let mut found = Found {
            templates: &self.layout.templates,
            tolerance,
            exact: Vec::new(),
            last: Vec::new(),
            deviation: 0.0,
        };
        for _ in 0..=LEVELS {
            found.take_regular(&mut front)?;
            found.take_near(&mut front)?;
            if front.open.is_empty() {
                let exact = found.exact.len();
                let mut surfaces = found.exact;
                surfaces.extend(found.last);
                return Ok(Patches { surfaces, exact, deviation: found.deviation });
            }
            if found.exact.len() + 4 * front.open.len() > MOST {
                let what = format!("the surfaces for a tolerance of {tolerance:e} and what is semi-sharp");
                return Err(SubdivisionError::TooLarge { what, limit: MOST });
            }
            front = front.refined()?;
        }
        let (what, place, needed) = (
            "tolerance",
            "patches".to_owned(),
            "larger: rounding of the surface's coordinates leaves more than that",
        );
        Err(SubdivisionError::Value { what, place, value: tolerance, needed })
    }
}

/// What of a level is still to be covered, with what is round it.
struct Front {
    cage: Cage,
    open: Vec<usize>,
}

impl Front {
    /// The next level. What is not round open faces is left behind: the vertices on the rim are wrong there, and no open face's
    /// neighbours have them.
    fn refined(&self) -> Result<Self> {
        let part = Part::to_refine(&self.cage, &self.open);
        let cage = part.to_cage(&self.cage)?;
        let corners: usize = (0..self.open.len()).map(|f| cage.topology().face(f).len()).sum();
        Ok(Self { cage: refine(&cage)?, open: (0..corners).collect() })
    }
}

/// What has been found.
struct Found<'a> {
    templates: &'a Templates,
    tolerance: f64,
    exact: Vec<Surface>,
    last: Vec<Surface>,
    deviation: f64,
}

impl Found<'_> {
    fn take_regular(&mut self, front: &mut Front) -> Result<()> {
        let topology = front.cage.topology();
        let mut nets: Vec<Option<Box<[Point]>>> = vec![None; topology.face_count()];
        let mut open = Vec::new();
        // A face whose interval in one direction is 0 is a curve or a point: no surface.
        let has_extent = |face: &&usize| {
            topology.face_edges(**face).iter().all(|&e| front.cage.interval(e as usize) > 0.0)
        };
        for &face in front.open.iter().filter(has_extent) {
            match regular::net(&front.cage, face) {
                Some(rows) => {
                    let point = |v: u32| front.cage.points()[v as usize].coords;
                    let sum = |row: regular::Row| {
                        Point::from(row.iter().fold(Vector::zeros(), |sum, &(v, c)| sum + point(v) * c))
                    };
                    nets[face] = Some(Box::new(rows.map(sum)));
                }
                None => open.push(face),
            }
        }
        let beyond = |face: usize, side: usize| {
            let twin = topology.twin((topology.face_corners(face).start + side) as u32);
            let next = (twin != NONE).then(|| topology.face_of(twin) as usize)?;
            Some((next, twin as usize - topology.face_corners(next).start))
        };
        // To the bit: each is a vertex of the cage, and a mirrored one is another.
        let quads = Quads { degree: 3, nets, beyond: &beyond, same: &|a, b| a == b };
        self.exact.extend(quads.surfaces()?);
        front.open = open;
        Ok(())
    }

    /// Vertex by vertex, all quads there or none.
    fn take_near(&mut self, front: &mut Front) -> Result<()> {
        let cage = &front.cage;
        let mut fans: BTreeMap<u32, Option<Vec<(usize, usize)>>> = BTreeMap::new();
        for &face in &front.open {
            match alone(cage, face) {
                Some(corner) => {
                    let fan =
                        fans.entry(cage.topology().face(face)[corner]).or_insert_with(|| Some(Vec::new()));
                    fan.iter_mut().for_each(|fan| fan.push((face, corner)));
                }
                // Nothing ends at a vertex of a face that does not: they would not share their sides.
                None => cage.topology().face(face).iter().for_each(|&v| {
                    fans.insert(v, None);
                }),
            }
        }
        let mut done = Vec::new();
        for (vertex, fan) in fans {
            let Some(fan) = fan else { continue };
            let corner = Corner::new(cage, vertex as usize)?;
            if let Some((patches, deviation)) =
                last::fan(self.templates, cage, &corner, &fan, self.tolerance)?
            {
                self.deviation = self.deviation.max(deviation);
                for patch in &patches {
                    self.last.push(surface(patch)?);
                }
                done.extend(fan.iter().map(|(face, _)| *face));
            }
        }
        done.sort_unstable();
        front.open.retain(|face| done.binary_search(face).is_err());
        Ok(())
    }
}

/// The one extraordinary corner of a quad that is regular everywhere else.
fn alone(cage: &Cage, face: usize) -> Option<usize> {
    if cage.topology().face(face).len() != 4 {
        return None;
    }
    let pattern = Pattern::of_quad(cage, face);
    let corner = pattern.corners.iter().position(|c| c.extraordinary)?;
    let others = Quadrant::WHOLE.parts().into_iter().enumerate().filter(|(k, _)| *k != corner);
    // With knot intervals the parts of these are pieces where they are none.
    let is_piece =
        |q: Quadrant| pattern.is_regular(q) || q.parts().into_iter().all(|q| pattern.is_regular(q));
    let regular = others.into_iter().all(|(_, quadrant)| is_piece(quadrant));
    (pattern.steps() == 0 && regular).then_some(corner)
}

/// A Bézier patch as a surface.
pub(crate) fn surface(patch: &Net) -> Result<Surface> {
    let space = Space::clamped(3, &[0.0, 1.0])?;
    Ok(Surface::new(space.clone(), space, patch.iter().map(|p| Point::from(*p)).collect())?)
}
