//! Edges that are found when they are first asked for: those of the finest level of a refinement seldom are.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::{Threads, Topology};

/// Which half-edges make which edge, and which leaves which vertex.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Pairing {
    /// The edge of each half-edge.
    pub(super) edge_of: Vec<u32>,
    /// The half-edges of each edge; the second [`NONE`](super::NONE) on the boundary.
    pub(super) edges: Vec<[u32; 2]>,
    /// A half-edge that leaves each vertex; on the boundary the one that has nothing on its right.
    pub(super) leaving: Vec<u32>,
}

impl Pairing {
    /// The half-edge on the other side of its edge, or [`NONE`](super::NONE).
    #[inline]
    pub(super) fn twin(&self, half: u32) -> u32 {
        let [a, b] = self.edges[self.edge_of[half as usize] as usize];
        if a == half { b } else { a }
    }

    fn bytes(&self) -> usize {
        4 * (self.edge_of.len() + 2 * self.edges.len() + self.leaving.len())
    }
}

/// A [`Pairing`], or the topology from whose split it follows, which is let go of when it is found.
#[derive(Debug, Default)]
pub(super) struct Deferred {
    found: OnceLock<Pairing>,
    parent: Mutex<Option<Arc<Topology>>>,
}

impl Deferred {
    /// The pairing of what this topology splits into.
    pub(super) fn split_of(parent: &Arc<Topology>) -> Self {
        Self { found: OnceLock::new(), parent: Mutex::new(Some(Arc::clone(parent))) }
    }

    /// What is found already, or now: by the thread that asks alone, for others that ask meanwhile wait for it, and one that waited for these could never end.
    #[inline]
    pub(super) fn get(&self) -> &Pairing {
        self.found.get_or_init(|| {
            let pairing = self.find(Threads::One);
            self.parent().take();
            pairing
        })
    }

    /// Finds it by all threads. Nobody waits for it: who asks meanwhile finds it, too, and the first is kept, which is the same.
    pub(super) fn find_now(&self) {
        if self.found.get().is_none() {
            let pairing = self.find(Threads::All);
            // Found by somebody else, meanwhile.
            let _ = self.found.set(pairing);
        }
        self.parent().take();
    }

    #[cold]
    fn find(&self, threads: Threads) -> Pairing {
        let parent = self.parent().clone();
        parent.map(|parent| parent.split_pairing(threads)).unwrap_or_default()
    }

    fn parent(&self) -> MutexGuard<'_, Option<Arc<Topology>>> {
        self.parent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The bytes of what is found.
    pub(super) fn bytes(&self) -> usize {
        self.found.get().map_or(0, Pairing::bytes)
    }
}

impl From<Pairing> for Deferred {
    fn from(pairing: Pairing) -> Self {
        Self { found: OnceLock::from(pairing), parent: Mutex::new(None) }
    }
}

impl Clone for Deferred {
    fn clone(&self) -> Self {
        self.get().clone().into()
    }
}

/// Whether the same edges are there, found or not.
impl PartialEq for Deferred {
    fn eq(&self, other: &Self) -> bool {
        self.get() == other.get()
    }
}

impl Eq for Deferred {}
