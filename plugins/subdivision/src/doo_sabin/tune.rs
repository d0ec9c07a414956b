//! A Doo-Sabin form fine tuned (Miura, Cheng and Wang, section 4 and figure 1).

use loftsman_kernel::Vector;
use loftsman_kernel::solve::{EnvelopeCholesky, Symmetric};
use loftsman_kernel::text::counted;

use super::elevate::{elevated, ends, settle};
use crate::cage::{Cage, between, present};
use crate::error::{Result, SubdivisionError};
use crate::topology::{NONE, Topology};

/// The derivatives of a Doo-Sabin surface scaled: the biquadratic surface of a cage becomes a bicubic one by knot intervals.
///
/// The edges of the cage are the surface's derivatives where it crosses its knot lines, and each has a factor α there; between two knot
/// lines α is linear. So the [elevated](super::elevated) cage, whose edges are the derivative too, is to have these:
///
/// * across a knot line: `α e`, the edge `e` times the α of the edge of the cage that it lies along;
/// * between knot lines, at a vertex of the cage whose edges on either side have `α₀` and `α₁`: the middle Bézier coefficient of the
///   product, `(α₀ e₁ + α₁ e₀)/4` with the elevated edges `e₀`, `e₁` across the knot lines before and after.
///
/// These need not close up. Springs reconcile them, `min Σ |X_b - X_a - w_ab|²`, with a vertex of each piece that hangs together staying
/// where it is: one sparse symmetric system, factored once for x, y and z.
///
/// Faces of five corners and more then lose what would leave no tangent plane in their middle (unless one of their vertices is pinned).
///
/// *What holds.* α = 1 everywhere gives the elevated cage, α = c that cage scaled about what stays. Rigid motions commute with it. Where
/// the wanted edges close up, the result is the tensor-product surface `∫ α S_u`, to rounding: on a grid of which the edges of one direction
/// have an α for each knot line and those of the other are [left out](Self::leave_out); and on a grid that is a sum of two polygons, with an α
/// for each knot line of either direction. Elsewhere it is the compromise above, and [`Tuned::strain`] says how far it is from what was asked.
///
/// ```
/// use loftsman_kernel::Point;
/// use loftsman_subdivision::{Cage, catmull_clark, doo_sabin};
///
/// let corner = |k: usize| Point::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// let cube = Cage::new((0..8).map(corner).collect(), &faces)?;
/// let mut tune = doo_sabin::FineTune::new(cube);
/// tune.scale([6, 7], 1.5)?;
/// let tuned = tune.solve()?;
/// assert_eq!(tuned.cage.points().len(), 24);
/// let frames = catmull_clark::limit_frames(&tuned.cage)?;
/// assert_eq!(frames.len(), 24);
/// # Ok::<(), loftsman_subdivision::SubdivisionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FineTune {
    cage: Cage,
    /// The factor of each edge; `None` where there is no spring.
    alpha: Vec<Option<f64>>,
    pins: Vec<usize>,
    any_sign: bool,
}

/// A tuned form.
#[derive(Debug, Clone)]
pub struct Tuned {
    /// The cage by knot intervals, for Catmull-Clark refinement.
    pub cage: Cage,
    /// `(Σ |X_b - X_a - w_ab|² / Σ |w_ab|²)^½`: how far the edges are from what they want to be; 0 where they close up.
    pub strain: f64,
}

/// An edge of the elevated cage, and what it wants to be.
struct Spring {
    from: u32,
    to: u32,
    wanted: Vector,
}

impl FineTune {
    /// The tuning that changes nothing yet: α = 1.
    pub fn new(cage: Cage) -> Self {
        let alpha = vec![Some(1.0); cage.topology().edge_count()];
        Self { cage, alpha, pins: Vec::new(), any_sign: false }
    }

    /// Scales all edges.
    pub fn scale_all(&mut self, alpha: f64) {
        self.alpha.fill(Some(alpha));
    }

    /// Scales the edge between two vertices of the cage.
    ///
    /// # Errors
    /// When there is no such edge.
    pub fn scale(&mut self, edge: [usize; 2], alpha: f64) -> Result<()> {
        let edge = self.edge(edge)?;
        self.alpha[edge] = Some(alpha);
        Ok(())
    }

    /// Lets an edge be what it likes: it is no spring.
    ///
    /// # Errors
    /// When there is no such edge.
    pub fn leave_out(&mut self, edge: [usize; 2]) -> Result<()> {
        let edge = self.edge(edge)?;
        self.alpha[edge] = None;
        Ok(())
    }

    fn edge(&self, [from, to]: [usize; 2]) -> Result<usize> {
        self.cage.topology().edge_between(from, to).ok_or(SubdivisionError::NoEdge { from, to })
    }

    /// A vertex of the cage whose elevated vertices, one for each of its faces, stay where they are. Pieces without one hold on to the first
    /// of theirs.
    ///
    /// # Errors
    /// When there is no such vertex.
    pub fn pin(&mut self, vertex: usize) -> Result<()> {
        present("vertex", vertex, self.cage.points().len())?;
        self.pins.push(vertex);
        Ok(())
    }

    /// Lets α be zero or negative.
    pub fn any_sign(&mut self) {
        self.any_sign = true;
    }

    /// The tuned cage.
    ///
    /// # Errors
    /// When an α is not finite, or not positive and need be; when end intervals differ; when numbers overflow.
    pub fn solve(&self) -> Result<Tuned> {
        self.check()?;
        let mut cage = elevated(&self.cage)?;
        let springs = self.springs(&cage);
        let moved = self.displacements(&cage, &springs)?;
        cage.points.iter_mut().zip(&moved).for_each(|(p, d)| *p += d);
        self.settle_faces(&mut cage);
        if let Some(vertex) = cage.points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            let problem =
                "is moved beyond what numbers hold: scale the cage down, or give α smaller values".to_owned();
            return Err(SubdivisionError::Vertex { vertex, problem });
        }
        let (mut off, mut size) = (0.0, 0.0);
        for Spring { from, to, wanted } in &springs {
            let is = cage.points[*to as usize] - cage.points[*from as usize];
            off += (is - wanted).norm_squared();
            size += wanted.norm_squared();
        }
        Ok(Tuned { cage, strain: if size > 0.0 { (off / size).sqrt() } else { 0.0 } })
    }

    /// In faces of five corners and more none of which is pinned.
    fn settle_faces(&self, cage: &mut Cage) {
        let topology = self.cage.topology();
        let free = |v: &u32| !topology.is_boundary_vertex(*v as usize) && !self.pins.contains(&(*v as usize));
        for face in (0..topology.face_count()).filter(|&f| topology.face(f).iter().all(free)) {
            settle(cage, face);
        }
    }

    fn check(&self) -> Result<()> {
        let fine = |alpha: &f64| alpha.is_finite() && (self.any_sign || *alpha > 0.0);
        let wrong =
            self.alpha.iter().enumerate().find_map(|(edge, a)| a.filter(|a| !fine(a)).map(|a| (edge, a)));
        let Some((edge, value)) = wrong else { return Ok(()) };
        let [from, to] = self.cage.topology().ends(edge).map(|v| v as usize);
        let needed = if self.any_sign {
            "a finite number"
        } else {
            "positive: where it is not, tangents turn round or vanish"
        };
        Err(SubdivisionError::Value { what: "α", place: between(from, to), value, needed })
    }

    fn springs(&self, net: &Cage) -> Vec<Spring> {
        let topology = self.cage.topology();
        let at = |h: u32| net.points()[h as usize];
        let alpha = |h: u32| self.alpha[topology.edge_of(h) as usize];
        let mut all = Vec::new();
        for half in 0..topology.corner_count() as u32 {
            let next = topology.next(half);
            if let Some(alpha) = alpha(half) {
                all.push(Spring { from: half, to: next, wanted: (at(next) - at(half)) * alpha });
            }
            // To this corner of the vertex from that of the face on the other side of the edge before.
            let back = topology.twin(topology.previous(half));
            if back == NONE {
                continue;
            }
            let before = topology.previous(back);
            if let (Some(behind), Some(ahead)) = (alpha(before), alpha(half)) {
                let edges = across(topology, half, &at) - across(topology, before, &at);
                let wanted =
                    (at(half) - at(back)) * (0.5 * (ahead + behind)) + edges * ((behind - ahead) / 8.0);
                all.push(Spring { from: back, to: half, wanted });
            }
        }
        all
    }

    /// How far the vertices go: `L d = Σ ±(w_ab - e_ab)` with the Laplacian `L` of the springs.
    fn displacements(&self, net: &Cage, springs: &[Spring]) -> Result<Vec<Vector>> {
        let count = net.points().len();
        let pinned = self.pinned(count, springs);
        let free: Vec<usize> = (0..count).filter(|&v| !pinned[v]).collect();
        let mut pull = vec![Vector::zeros(); count];
        for Spring { from, to, wanted } in springs {
            let (a, b) = (*from as usize, *to as usize);
            let missing = wanted - (net.points()[b] - net.points()[a]);
            pull[b] += missing;
            pull[a] -= missing;
        }
        let entries = springs.iter().flat_map(|s| {
            let (a, b) = (s.from as usize, s.to as usize);
            [(a, a, 1.0), (b, b, 1.0), (a.max(b), a.min(b), -1.0)]
        });
        let matrix = Symmetric::from_entries(count, entries.collect::<Vec<_>>()).select(&free);
        let order = matrix.narrow_order();
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
        let nearest = |(at, &row): (usize, &usize)| {
            matrix.row(row).map(|(column, _)| place[column]).fold(at, usize::min) as u32
        };
        let first = order.iter().enumerate().map(nearest).collect();
        let factored = EnvelopeCholesky::factor(first, 0.0, |i, j| matrix.entry(order[i], order[j]));
        let factored = factored.map_err(|row| {
            let problem = "hangs on no vertex that stays: pin one of its piece".to_owned();
            SubdivisionError::Vertex { vertex: free[order[row]], problem }
        })?;
        let mut x: Vec<f64> =
            order.iter().flat_map(|&row| pull[free[row]].iter().copied().collect::<Vec<_>>()).collect();
        factored.solve(&mut x, 3);
        let mut moved = vec![Vector::zeros(); count];
        for (at, &row) in order.iter().enumerate() {
            moved[free[row]] = Vector::from_column_slice(&x[3 * at..3 * at + 3]);
        }
        Ok(moved)
    }

    /// Which elevated vertices stay: those of the pins, and the first of each piece that has none.
    fn pinned(&self, count: usize, springs: &[Spring]) -> Vec<bool> {
        let topology = self.cage.topology();
        let mut stays = vec![false; count];
        self.pins.iter().flat_map(|&v| topology.around(v)).for_each(|h| stays[h as usize] = true);
        let mut beside: Vec<Vec<u32>> = vec![Vec::new(); count];
        for Spring { from, to, .. } in springs {
            beside[*from as usize].push(*to);
            beside[*to as usize].push(*from);
        }
        let mut seen = vec![false; count];
        let held: Vec<usize> = (0..count).filter(|&v| stays[v]).collect();
        for first in held.into_iter().chain(0..count) {
            if seen[first] {
                continue;
            }
            stays[first] = true;
            let mut way = vec![first];
            while let Some(vertex) = way.pop() {
                if !std::mem::replace(&mut seen[vertex], true) {
                    way.extend(beside[vertex].iter().map(|&v| v as usize).filter(|&v| !seen[v]));
                }
            }
        }
        stays
    }
}

/// The elevated edge from a corner to the next one of its face: where one of the two is on the outermost knot line, it is half of what
/// it would be, and is doubled.
fn across(topology: &Topology, half: u32, at: &impl Fn(u32) -> loftsman_kernel::Point) -> Vector {
    let next = topology.next(half);
    let cut = ends(topology, half)[1] || ends(topology, next)[0];
    (at(next) - at(half)) * if cut { 2.0 } else { 1.0 }
}

/// What there is to say of a Doo-Sabin cage that becomes a bicubic form, which is the same surface where all faces and vertices have four edges.
pub(crate) fn irregular(cage: &Cage) -> String {
    let topology = cage.topology();
    let faces = (0..topology.face_count()).filter(|&face| topology.face(face).len() != 4).count();
    let is_other = |&v: &usize| !topology.is_boundary_vertex(v) && topology.around(v).count() != 4;
    let vertices = (0..topology.vertex_count()).filter(is_other).count();
    if faces + vertices == 0 {
        return String::new();
    }
    format!(
        "; round {} and {} of other than four edges the bicubic form is another surface than Doo and Sabin's, alpha or none",
        counted(faces, "face[|s]"),
        counted(vertices, "vert[ex|ices]")
    )
}
