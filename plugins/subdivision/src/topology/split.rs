//! Every face split into quads round its middle: the topology that Catmull-Clark refinement makes, by arithmetic alone.

use std::sync::Arc;

use super::build::check_room;
use super::{Deferred, NONE, Pairing, Threads, Topology, flat, many};
use crate::error::Result;

impl Topology {
    /// The topology with a vertex more on each edge and face. With `V` vertices, `E` edges: vertex `v` stays `v`, edge `e` becomes
    /// vertex `V + e`, face `f` becomes `V + E + f`. Corner `h` becomes face `h`: its vertex, the middle of the edge that follows,
    /// the middle of the face, the middle of the edge before. Edge `e` becomes `2e` (at its start) and `2e + 1`; edge `2E + h` joins the
    /// middle of the edge that follows corner `h` to that of the face. Cost: linear; no sorting.
    ///
    /// # Errors
    /// When 32 bits cannot count what would be there.
    pub fn split(&self) -> Result<Self> {
        let mut child = self.split_corners()?;
        child.pairing = self.split_pairing(Threads::All).into();
        Ok(child)
    }

    /// [`split`](Self::split), whose edges are found when they are first asked for.
    pub(crate) fn split_deferred(self: &Arc<Self>) -> Result<Self> {
        self.find_edges_now();
        let mut child = self.split_corners()?;
        child.pairing = Deferred::split_of(self);
        Ok(child)
    }

    /// The faces of the split, without its edges.
    fn split_corners(&self) -> Result<Self> {
        let (vertices, edges, corners) = (self.vertex_count(), self.edge_count(), self.corner_count());
        check_room("corners of faces", corners.saturating_mul(4))?;
        check_room("vertices", vertices + edges + self.face_count())?;
        let (v, e) = (vertices as u32, edges as u32);
        let edge_of = &self.pairing().edge_of;
        let child_corners = flat(Threads::All, corners, |h| {
            let before = self.previous(h) as usize;
            [self.origin(h), v + edge_of[h as usize], v + e + self.face_of(h), v + edge_of[before]]
        });
        Ok(Self {
            vertices: vertices + edges + self.face_count(),
            edges: 2 * edges + corners,
            corners: child_corners,
            polygons: None,
            pairing: Deferred::default(),
        })
    }

    /// The edges of the split.
    pub(super) fn split_pairing(&self, threads: Threads) -> Pairing {
        let (vertices, edges, corners) = (self.vertex_count(), self.edge_count(), self.corner_count());
        let e = edges as u32;
        let own = self.pairing();
        let edge_of = flat(threads, corners, |h| {
            let before = self.previous(h);
            let (along, back) = (own.edge_of[h as usize], own.edge_of[before as usize]);
            let at_start = u32::from(own.edges[along as usize][0] != h);
            let at_end = u32::from(own.edges[back as usize][0] == before);
            [2 * along + at_start, 2 * e + h, 2 * e + before, 2 * back + at_end]
        });
        let child_edges = many(threads, 2 * edges + corners, |k| {
            let k = k as u32;
            if k >= 2 * e {
                let h = k - 2 * e;
                return [4 * h + 1, 4 * self.next(h) + 2];
            }
            let [one, other] = own.edges[k as usize / 2];
            let (starts, ends) = (4 * one, 4 * self.next(one) + 3);
            let (back_starts, back_ends) =
                if other == NONE { (NONE, NONE) } else { (4 * other, 4 * self.next(other) + 3) };
            if k.is_multiple_of(2) { [starts, back_ends] } else { [ends, back_starts] }
        });
        let leaving = many(threads, vertices + edges + self.face_count(), |k| {
            if k < vertices {
                4 * own.leaving[k]
            } else if k < vertices + edges {
                4 * self.next(own.edges[k - vertices][0]) + 3
            } else {
                4 * self.face_corners(k - vertices - edges).start as u32 + 2
            }
        });
        Pairing { edge_of, edges: child_edges, leaving }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::Topology;

    /// What is found later is what is found at once, also where several ask and the parent is let go of.
    #[test]
    fn deferred_edges_are_the_same_and_their_parent_is_let_go() {
        let corners = vec![0, 3, 2, 1, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 3, 4, 7];
        let mut at_once = Topology::new(8, corners, &[0, 4, 8, 12, 16, 19, 22]).unwrap();
        let mut later = Arc::new(at_once.clone());
        for _ in 0..3 {
            let parent = Arc::downgrade(&later);
            at_once = at_once.split().unwrap();
            later = Arc::new(later.split_deferred().unwrap());
            assert_eq!(
                (later.edge_count(), later.vertex_count()),
                (at_once.edge_count(), at_once.vertex_count())
            );
            assert!(parent.upgrade().is_some() && later.bytes() < at_once.bytes());
            std::thread::scope(|threads| {
                for thread in 0..6 {
                    let (later, at_once) = (&later, &at_once);
                    threads.spawn(move || {
                        if thread % 3 == 0 {
                            later.find_edges_now();
                        }
                        assert_eq!(later.twin(0), at_once.twin(0));
                    });
                }
            });
            assert!(parent.upgrade().is_none() && later.bytes() == at_once.bytes());
            assert_eq!(*later, at_once);
            assert_eq!(Topology::clone(&later), at_once);
        }
    }

    /// Work side by side that asks for edges nobody has found has the right ones, whoever asks first.
    #[test]
    fn many_threads_may_ask_first() {
        use loftsman_kernel::parallel;
        let corners = vec![0, 3, 2, 1, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7, 7, 4, 5, 6];
        let mut cube = Arc::new(Topology::new(8, corners, &[0, 4, 8, 12, 16, 20, 24]).unwrap());
        for _ in 0..6 {
            cube = Arc::new(cube.split_deferred().unwrap());
        }
        // Work that asks for nothing, for threads to take from one another while one of them finds the edges.
        let busy = |k: usize| (0..200 + k % 50).fold(k as f64, |x, _| (x + 1.0).sqrt());
        for round in 0..10 {
            let finest = Arc::new(cube.split_deferred().unwrap());
            let valences = parallel::map(4000, |k| {
                let asks = (k + round).is_multiple_of(41);
                let others: f64 = parallel::map(16, |j| busy(16 * k + j)).into_iter().sum();
                if asks { (k, finest.valence(k)) } else { (usize::from(others < 0.0), 3) }
            });
            assert!(valences.iter().all(|(k, valence)| *valence == if *k < 8 { 3 } else { 4 }));
        }
    }

    /// The split agrees with the same faces put together from nothing, but for how edges are numbered.
    #[test]
    fn a_split_is_what_its_faces_say() {
        // A cube with one face missing and one cut in two triangles.
        let corners = vec![0, 3, 2, 1, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 3, 4, 7];
        let mut topology = Topology::new(8, corners, &[0, 4, 8, 12, 16, 19, 22]).unwrap();
        for _ in 0..3 {
            let split = topology.split().unwrap();
            let starts: Vec<usize> = (0..=split.face_count()).map(|f| 4 * f).collect();
            let again = Topology::new(split.vertex_count(), split.corners.clone(), &starts).unwrap();
            assert_eq!(split.edge_count(), again.edge_count());
            for h in 0..split.corner_count() as u32 {
                assert_eq!(split.twin(h), again.twin(h));
                assert!(split.halves(split.edge_of(h) as usize).contains(&h));
                assert_eq!(split.face_of(h), h / 4);
            }
            for v in 0..split.vertex_count() {
                assert_eq!(split.origin(split.pairing().leaving[v]) as usize, v);
                assert_eq!(split.is_boundary_vertex(v), again.is_boundary_vertex(v));
                assert_eq!(split.valence(v), again.valence(v));
                assert_eq!(split.around(v).count(), again.around(v).count());
            }
            topology = split;
        }
    }
}
