//! A Doo-Sabin surface as splines.

use std::collections::BTreeMap;

use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Vector};

use super::node::Node;
use super::tessellate::{Corners, size};
use super::{DooSabinSurface, kind};
use crate::error::{Result, SubdivisionError};
use crate::surface::fill::{self, Surrounded};
use crate::surface::grids::Quads;
use crate::surface::left_out::first_of;
use crate::surface::net::{Net, largest, turned};
use crate::surface::patches::{LEVELS, MOST, Patches, surface};
use crate::surface::pattern::Quadrant;

/// Vertices of nets that differ by no more than so many parts of the largest coordinate are one: neighbours sum theirs up in other orders.
const ONE: f64 = 64.0 * f64::EPSILON;

impl DooSabinSurface {
    /// The diagonal of the box around the corners of the surface's faces.
    pub(crate) fn size(&self) -> Result<f64> {
        Ok(size(self.cage.points(), &self.nodes()?))
    }

    /// The surface as splines, within a tolerance (a length, in the unit of the cage).
    ///
    /// *Regular faces* are put together to rectangles, as large as is found by going along their sides: uniform biquadratic B-spline surfaces
    /// that are the surface exactly; where knot intervals differ one for each of their spans.
    ///
    /// *Round an extraordinary point*, the middle of a face that is no quad or the limit of a vertex that has not four edges, there are rings of
    /// such surfaces, each half as large as the one before, down to the level at which one bicubic Bézier patch for each remaining quad is near
    /// enough. It has the limit's positions, tangents and twists at its three regular corners, the exact boundary on its two outer sides, the
    /// limit's position at the point and in the middles of the quad and of its inner sides, and along these the limit's tangents.
    ///
    /// *How near* is bounded: patch and surface are compared over the same quadrants, by the differences of their Bézier points, down to a
    /// quadrant where the convex hulls of both are small; the largest distance of points of equal parameters is the deviation. All quads at
    /// one point end on one level, and have their common sides to the bit. Where surfaces of different size meet, the side of a large
    /// one is several of small ones: they are the same curve piece by piece, to rounding (T-junctions without gaps).
    ///
    /// What has no extent, at double knots, is left out. The number of surfaces grows with the logarithm of the tolerance. Cost: linear in the
    /// faces, and in the rings some 20 µs a quad.
    ///
    /// # Errors
    /// When the tolerance is not positive, or less than what rounding leaves of the surface; more than a million surfaces would be needed; a
    /// coordinate overflows.
    pub fn patches(&self, tolerance: f64) -> Result<Patches> {
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            let (what, place, needed) = ("tolerance", "patches".to_owned(), "positive and finite");
            return Err(SubdivisionError::Value { what, place, value: tolerance, needed });
        }
        let mut front = Front::new(self)?;
        let coordinates = self.cage.points().iter().map(|p| p.coords.amax());
        let mut found = Found {
            tolerance,
            near: ONE * largest(coordinates),
            exact: Vec::new(),
            last: Vec::new(),
            deviation: 0.0,
        };
        for _ in 0..=LEVELS {
            found.take_regular(&mut front)?;
            found.take_last(&mut front)?;
            if front.open.is_empty() {
                let exact = found.exact.len();
                let mut surfaces = found.exact;
                surfaces.extend(found.last);
                return Ok(Patches { surfaces, exact, deviation: found.deviation });
            }
            if found.exact.len() + 4 * front.open.len() > MOST {
                let what = format!("the surfaces for a tolerance of {tolerance:e}");
                return Err(SubdivisionError::TooLarge { what, limit: MOST });
            }
            front.refine();
        }
        let (what, place, needed) = (
            "tolerance",
            "patches".to_owned(),
            "larger: rounding of the surface's coordinates leaves more than that",
        );
        Err(SubdivisionError::Value { what, place, value: tolerance, needed })
    }
}

/// A quad that is still to be covered.
struct Open {
    node: Node<Vector>,
    /// Names of its corners, which its neighbours have, too.
    corners: [u32; 4],
    /// The corners that are extraordinary: none, one or, of a face of the surface itself, 0 and 2.
    extraordinary: [bool; 4],
}

impl Open {
    fn ends(&self, side: usize) -> (u32, u32) {
        ordered(self.corners[side % 4], self.corners[(side + 1) % 4])
    }
}

fn ordered(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// What of a level is still to be covered.
struct Front {
    open: Vec<Open>,
    names: u32,
}

impl Front {
    fn new(of: &DooSabinSurface) -> Result<Self> {
        let topology = of.cage.topology();
        let mut places = Corners::new(of);
        let mut open = Vec::new();
        for (node, &half) in of.nodes()?.into_iter().zip(&of.layout.corners) {
            if node.vanishes().contains(&true) {
                continue;
            }
            let corners = places.of(topology, half).map(|place| place as u32);
            let kind = kind(&of.cage, half);
            open.push(Open { node, corners, extraordinary: [kind & 1 != 0, false, kind & 2 != 0, false] });
        }
        Ok(Self { open, names: places.count() as u32 })
    }

    /// The next level.
    fn refine(&mut self) {
        let mut middles = BTreeMap::new();
        let mut name = |of: Option<(u32, u32)>| {
            let new = self.names;
            let own = of.map_or(new, |ends| *middles.entry(ends).or_insert(new));
            self.names += u32::from(own == new);
            own
        };
        let mut all = Vec::with_capacity(4 * self.open.len());
        for quad in &self.open {
            let centre = name(None);
            let sides = [0, 1, 2, 3].map(|side| name(Some(quad.ends(side))));
            for (k, node) in quad.node.quarters().into_iter().enumerate() {
                let mut corners = [quad.corners[k], sides[k], centre, sides[(k + 3) % 4]];
                corners.rotate_right(k);
                let extraordinary = std::array::from_fn(|c| c == k && quad.extraordinary[c]);
                all.push(Open { node, corners, extraordinary });
            }
        }
        self.open = all;
    }
}

/// What has been found.
struct Found {
    tolerance: f64,
    near: f64,
    exact: Vec<Surface>,
    last: Vec<Surface>,
    deviation: f64,
}

impl Found {
    fn take_regular(&mut self, front: &mut Front) -> Result<()> {
        let (regular, open): (Vec<Open>, Vec<Open>) =
            std::mem::take(&mut front.open).into_iter().partition(|quad| quad.node.is_regular());
        front.open = open;
        let mut sides: BTreeMap<(u32, u32), Vec<(usize, usize)>> = BTreeMap::new();
        for (k, quad) in regular.iter().enumerate() {
            (0..4).for_each(|side| sides.entry(quad.ends(side)).or_default().push((k, side)));
        }
        let beyond = |quad: usize, side: usize| match sides.get(&regular[quad].ends(side))?[..] {
            [one, other] if one == (quad, side) => Some(other),
            [other, one] if one == (quad, side) => Some(other),
            _ => None,
        };
        let near = self.near;
        let same = |a: &Point, b: &Point| (a - b).amax() <= near;
        let net = |quad: &Open| Some(quad.node.net().map(|p| Point::from(*p)).to_vec().into_boxed_slice());
        let nets = regular.iter().map(net).collect();
        self.exact.extend(Quads { degree: 2, nets, beyond: &beyond, same: &same }.surfaces()?);
        Ok(())
    }

    /// Point by point, all quads there or none.
    fn take_last(&mut self, front: &mut Front) -> Result<()> {
        let mut fans: BTreeMap<u32, Option<Vec<(usize, usize)>>> = BTreeMap::new();
        for (k, quad) in front.open.iter().enumerate() {
            let mut corners = (0..4).filter(|&corner| quad.extraordinary[corner]);
            match (corners.next(), corners.next()) {
                (Some(corner), None) => {
                    let fan = fans.entry(quad.corners[corner]).or_insert_with(|| Some(Vec::new()));
                    fan.iter_mut().for_each(|fan| fan.push((k, corner)));
                }
                // Nothing ends at the corner of a quad that does not: they would not share their sides.
                _ => quad.corners.iter().for_each(|&corner| {
                    fans.insert(corner, None);
                }),
            }
        }
        let mut done = vec![false; front.open.len()];
        for fan in fans.into_values().flatten() {
            let mut sides = BTreeMap::new();
            let mut patches = Vec::with_capacity(fan.len());
            for &(k, corner) in &fan {
                match last(&front.open[k], corner, &mut sides, self.tolerance)? {
                    Some(patch) => patches.push(patch),
                    None => break,
                }
            }
            if patches.len() < fan.len() {
                continue;
            }
            for (patch, deviation) in patches {
                self.deviation = self.deviation.max(deviation);
                self.last.push(surface(&patch)?);
            }
            fan.iter().for_each(|&(k, _)| done[k] = true);
        }
        let mut done = done.into_iter();
        front.open.retain(|_| done.next() != Some(true));
        Ok(())
    }
}

/// The patch over a quad with one extraordinary corner, seen from there, and a bound of how near it is; `None` where that is more than the
/// tolerance. Sides that a neighbour has had are its.
fn last(
    quad: &Open,
    corner: usize,
    sides: &mut BTreeMap<(u32, u32), [Vector; 4]>,
    tolerance: f64,
) -> Result<Option<(Net, f64)>> {
    let mut levels = Levels::new(&quad.node, corner);
    let first = levels.pieces[0];
    let mut all = fill::around(&first.map(|piece| (piece, 2.0)));
    let (start, [u, v]) = quad.node.corner(corner);
    // Seen from the corner: along the side that follows, and along the one before.
    let [along_u, along_v] = match corner {
        0 => [u, v],
        1 => [v, -u],
        2 => [-u, -v],
        _ => [-v, u],
    };
    let mut known = |side: usize, along: &Vector, middle: Vector, far: [Vector; 2]| {
        *sides.entry(quad.ends(side)).or_insert_with(|| fill::side(start, Some(along), middle, far))
    };
    let side_u = known(corner, &along_u, first[0][0], [all[8], all[12]]);
    let side_v = known(corner + 3, &along_v, first[2][0], [all[2], all[3]]);
    fill::close(&mut all, side_u, side_v, first[1][0]);
    Ok(fill::apart(&all, tolerance, &mut levels)?.map(|apart| (all, apart)))
}

/// What is round an extraordinary corner of a quad, level by level, seen from there.
struct Levels {
    corner: usize,
    /// The quarter at the corner.
    nodes: Vec<Node<Vector>>,
    /// The three others.
    pieces: Vec<[Net; 3]>,
}

impl Levels {
    fn new(whole: &Node<Vector>, corner: usize) -> Self {
        let mut levels = Self { corner, nodes: Vec::new(), pieces: Vec::new() };
        levels.divide(whole);
        levels
    }

    fn divide(&mut self, node: &Node<Vector>) {
        let quarters = node.quarters();
        let piece = |k: usize| turned(&quarters[(self.corner + k) % 4].patch(), self.corner);
        self.pieces.push([1, 2, 3].map(piece));
        self.nodes.push(quarters[self.corner].clone());
    }

    fn until(&mut self, level: u32) -> usize {
        while self.nodes.len() < level as usize {
            let last = self.nodes[self.nodes.len() - 1].clone();
            self.divide(&last);
        }
        (level as usize).saturating_sub(1)
    }
}

impl Surrounded for Levels {
    fn piece(&mut self, quadrant: Quadrant) -> Result<Option<Net>> {
        let at = self.until(quadrant.level);
        // One of the three beside that at the corner.
        let [_, rest @ ..] = first_of(at as u32).parts();
        Ok(rest.iter().position(|other| *other == quadrant).map(|k| self.pieces[at][k]))
    }

    fn hull(&mut self, level: u32) -> Result<Vec<Vector>> {
        let at = self.until(level);
        Ok(self.nodes[at].rings.iter().flatten().copied().collect())
    }
}
