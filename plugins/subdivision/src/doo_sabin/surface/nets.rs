//! The biquadratic pieces of a surface as they are: nets of points, and no rows.

use std::ops::Range;

use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::shape::{CellNet, CellSide};
use loftsman_kernel::{Point, Vector};
use smallvec::SmallVec;

use super::node::Node;
use super::{DooSabinSurface, kind};
use crate::doo_sabin::refine::FaceSums;
use crate::surface::pattern::Quadrant;

impl DooSabinSurface {
    /// The Bézier nets of cells. Cost: for each face the vertices of the cage round it, and for each cell a refinement of a few points.
    pub(super) fn nets_of(
        &self,
        numbers: Range<usize>,
        origin: &Point,
        each: &mut dyn FnMut(CellNet<'_>),
    ) -> Result<()> {
        let layout = &self.layout;
        let mut face = layout.cells.partition_point(|&first| first <= numbers.start).saturating_sub(1);
        while let (Some(&first), Some(&end)) = (layout.cells.get(face), layout.cells.get(face + 1))
            && first < numbers.end
        {
            let own = numbers.start.max(first)..numbers.end.min(end);
            if !own.is_empty() {
                let half = layout.corners[face];
                let quadrants = &layout.quadrants[kind(&self.cage, half)];
                let mut path = vec![(Quadrant::WHOLE, self.node_of(half, origin))];
                for number in own {
                    let quadrant = quadrants[number - first];
                    let node = go(&mut path, quadrant);
                    if !node.is_regular() {
                        let problem =
                            format!("is no biquadratic piece on a part that is counted as one: {quadrant:?}");
                        return Err(Error::Face { face, problem });
                    }
                    let size = 0.5_f64.powi(quadrant.level as i32);
                    let sides = [quadrant.i, quadrant.j].map(|k| CellSide {
                        start: k as f64 * size,
                        end: (k + 1) as f64 * size,
                        degree: 2,
                    });
                    let points = &bezier(node);
                    each(CellNet { number, face: Some(face as u32), sides, points });
                }
            }
            face += 1;
        }
        Ok(())
    }

    /// The neighbourhood of the face at a corner of the cage: its points from an origin. Cost: the vertices of the faces round it.
    fn node_of(&self, half: u32, origin: &Point) -> Node<Vector> {
        let topology = self.cage.topology();
        let mut around: SmallVec<[(usize, FaceSums<'_>); 4]> = SmallVec::new();
        let mut new = |corner: u32| {
            let face = topology.face_of(corner) as usize;
            let known = around.iter().position(|(of, _)| *of == face);
            let at = known.unwrap_or_else(|| {
                around.push((face, FaceSums::new(&self.cage, face, origin)));
                around.len() - 1
            });
            around[at].1.corner(corner as usize - topology.face_corners(face).start)
        };
        let rings = self.rings(half).map(|ring| ring.into_iter().map(&mut new).collect());
        Node { rings, rules: self.layout.spans.rules(&self.cage, half) }
    }
}

/// The neighbourhood of a quadrant, on the way to which the last ones that were asked for are kept.
fn go(path: &mut Vec<(Quadrant, Node<Vector>)>, quadrant: Quadrant) -> &Node<Vector> {
    let mut way = Vec::new();
    let mut at = quadrant;
    while let Some((parent, corner)) = at.parent() {
        way.push((at, corner));
        at = parent;
    }
    way.reverse();
    let same = path[1..].iter().zip(&way).take_while(|(a, b)| a.0 == b.0).count();
    path.truncate(same + 1);
    for &(quadrant, corner) in &way[same..] {
        let next = path[path.len() - 1].1.quarter_at(corner);
        path.push((quadrant, next));
    }
    &path[path.len() - 1].1
}

/// The Bézier points of a regular piece.
fn bezier(node: &Node<Vector>) -> [Vector; 9] {
    let net = node.net();
    // Those between which a point is half way along a direction: at an end two, in the middle twice the same.
    let between = |k: usize| [[0, 1], [1, 1], [1, 2]][k];
    std::array::from_fn(|k| {
        let (rows, columns) = (between(k / 3), between(k % 3));
        let line = |j: usize| *net[3 * rows[0] + j] + *net[3 * rows[1] + j];
        (line(columns[0]) + line(columns[1])) * 0.25
    })
}
