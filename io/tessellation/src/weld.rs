//! Points of the grid that are one point: seams and poles.

/// Sets of grid points that are one vertex: a forest in one array, the least index of a set its root.
#[derive(Debug)]
pub(crate) struct Welds {
    parent: Vec<u32>,
}

impl Welds {
    /// Every point on its own. The caller has checked that indices fit.
    pub(crate) fn new(points: usize) -> Self {
        Self { parent: (0..points as u32).collect() }
    }

    /// The least point of the set.
    pub(crate) fn root(&mut self, point: usize) -> usize {
        let mut at = point as u32;
        while self.parent[at as usize] != at {
            // Path halving keeps chains short (Tarjan and van Leeuwen 1984).
            let above = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = above;
            at = above;
        }
        at as usize
    }

    /// Makes two points one.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high] = low as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_have_one_root() {
        let mut welds = Welds::new(100_000);
        for i in (1..100_000).rev() {
            welds.join(i, i - 1);
        }
        assert_eq!(welds.root(99_999), 0);
    }
}
