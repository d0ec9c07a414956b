//! An order of rows that keeps the envelope of their Gram matrix small.

use super::system::SparseRows;

/// For each position, the first position whose row shares a column with it.
fn envelope(rows: &SparseRows, order: &[u32]) -> Vec<u32> {
    let mut earliest = vec![u32::MAX; rows.width()];
    let mut first = Vec::with_capacity(order.len());
    for (position, &row) in order.iter().enumerate() {
        let mut low = position as u32;
        for &column in rows.row(row as usize).0 {
            let seen = &mut earliest[column as usize];
            if *seen == u32::MAX {
                *seen = position as u32;
            }
            low = low.min(*seen);
        }
        first.push(low);
    }
    first
}

pub(super) fn size_of(first: &[u32]) -> usize {
    first.iter().enumerate().map(|(i, &f)| i + 1 - f as usize).sum()
}

/// Rows in an order that keeps the envelope of their Gram matrix small, and that envelope: by first column where that is
/// narrow (curves), by breadth-first search over shared columns elsewhere (surfaces, seams, pairs of vertices).
pub(super) fn narrow(rows: &SparseRows, mut kept: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
    let first = |r: u32| rows.row(r as usize).0.first().copied().unwrap_or(0);
    if !kept.windows(2).all(|pair| first(pair[0]) <= first(pair[1])) {
        kept.sort_by_key(|&r| (first(r), r));
    }
    let by_column = envelope(rows, &kept);
    let size = size_of(&by_column);
    if kept.len() < 16 || size <= kept.len() * 8 {
        return (kept, by_column);
    }
    let searched = breadth_first(rows, &kept);
    let by_search = envelope(rows, &searched);
    if size_of(&by_search) < size { (searched, by_search) } else { (kept, by_column) }
}

fn breadth_first(rows: &SparseRows, kept: &[u32]) -> Vec<u32> {
    // Which kept rows touch a column: counting sort.
    let mut starts = vec![0_u32; rows.width() + 1];
    for &row in kept {
        for &column in rows.row(row as usize).0 {
            starts[column as usize + 1] += 1;
        }
    }
    for i in 0..rows.width() {
        starts[i + 1] += starts[i];
    }
    let mut fill = starts.clone();
    let mut touching = vec![0_u32; starts.last().map_or(0, |&s| s as usize)];
    for (at, &row) in kept.iter().enumerate() {
        for &column in rows.row(row as usize).0 {
            let slot = &mut fill[column as usize];
            touching[*slot as usize] = at as u32;
            *slot += 1;
        }
    }
    let (mut seen, mut expanded) = (vec![false; kept.len()], vec![false; rows.width()]);
    let mut order: Vec<u32> = Vec::with_capacity(kept.len());
    for start in 0..kept.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut head = order.len();
        order.push(start as u32);
        while head < order.len() {
            let row = kept[order[head] as usize];
            // A column is expanded once: a row that everything shares does not cost the square.
            for &column in rows.row(row as usize).0 {
                let column = column as usize;
                if std::mem::replace(&mut expanded[column], true) {
                    continue;
                }
                for &next in &touching[starts[column] as usize..starts[column + 1] as usize] {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        order.push(next);
                    }
                }
            }
            head += 1;
        }
    }
    order.reverse();
    order.into_iter().map(|at| kept[at as usize]).collect()
}
