//! Which control vertices are next to one another.

use smallvec::SmallVec;

/// What a shape can say whose control vertices hang together by edges of a net, regular or not.
pub trait Neighbours {
    /// The vertices next to a vertex, each once, ascending, the vertex itself not among them. Who is next to whom is mutual.
    /// None for a vertex that there is not.
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]>;
}

impl Neighbours for super::Grid {
    /// Those before and after it in its row and in its column.
    fn around(&self, vertex: usize) -> SmallVec<[usize; 8]> {
        let columns = self.columns.max(1);
        let (row, column) = (vertex / columns, vertex % columns);
        let mut all = SmallVec::new();
        if row >= self.rows {
            return all;
        }
        let beside = |at: usize, length: usize, wraps: bool| {
            let before = if at > 0 { Some(at - 1) } else { (wraps && length > 1).then(|| length - 1) };
            let after = if at + 1 < length { Some(at + 1) } else { (wraps && length > 1).then_some(0) };
            before.into_iter().chain(after)
        };
        all.extend(beside(row, self.rows, self.rows_wrap).map(|r| r * columns + column));
        all.extend(beside(column, columns, self.columns_wrap).map(|c| row * columns + c));
        all.sort_unstable();
        all.dedup();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::Grid;
    use super::*;

    #[test]
    fn grids_wrap_where_they_do() {
        let grid = Grid { rows: 3, columns: 4, rows_wrap: false, columns_wrap: true };
        assert_eq!(grid.around(0)[..], [1, 3, 4]);
        assert_eq!(grid.around(5)[..], [1, 4, 6, 9]);
        assert_eq!(grid.around(11)[..], [7, 8, 10]);
        assert!(grid.around(12).is_empty());
        let pair = Grid { rows: 1, columns: 2, rows_wrap: true, columns_wrap: true };
        assert_eq!(pair.around(0)[..], [1]);
    }
}
