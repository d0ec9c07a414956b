//! Parts of a section, cell after cell, in order: branches and loops.

use loftsman_kernel::spline::Surface;

use super::cell::Cells;

/// Parts in order, each with whether it runs from its second end to its first.
#[derive(Debug)]
pub(crate) struct Chain {
    pub(crate) parts: Vec<(usize, bool)>,
    pub(crate) closed: bool,
}

/// How far apart, relative to the domain, two ends on an edge may be that are one: rounding of their roots.
const SAME: f64 = 1e-7;

/// The chains of all parts. `O(k log k)`.
pub(crate) fn chains(cells: &Cells<'_>, surface: &Surface) -> Vec<Chain> {
    let links = links(cells, surface);
    let mut used = vec![false; cells.parts.len()];
    let mut chains = Vec::new();
    // Branches first, from their ends; what is left then are loops.
    for round in 0..2 {
        for start in 0..cells.parts.len() {
            let Some(first) = (0..2).find(|&e| round == 1 || links[2 * start + e].is_none()) else {
                continue;
            };
            if used[start] {
                continue;
            }
            let mut parts = Vec::new();
            let (mut part, mut entered) = (start, first);
            let closed = loop {
                used[part] = true;
                parts.push((part, entered == 1));
                match links[2 * part + (1 - entered)] {
                    Some(next) if !used[next / 2] => (part, entered) = (next / 2, next % 2),
                    Some(next) => break next / 2 == start,
                    None => break false,
                }
            };
            chains.push(Chain { parts, closed });
        }
    }
    chains
}

/// For each end (two a part) the end that it goes on at.
fn links(cells: &Cells<'_>, surface: &Surface) -> Vec<Option<usize>> {
    let spaces = [surface.u(), surface.v()];
    let mut ends: Vec<(usize, f64, bool, f64, usize)> = Vec::with_capacity(2 * cells.parts.len());
    for (p, part) in cells.parts.iter().enumerate() {
        for (e, end) in part.ends.iter().enumerate() {
            let (fixed, upper) = end.edge;
            ends.push((fixed, end.at[fixed], upper, end.at[1 - fixed], 2 * p + e));
        }
    }
    ends.sort_by(|a, b| {
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.3.total_cmp(&b.3)).then(a.4.cmp(&b.4))
    });
    let mut links = vec![None; ends.len()];
    let mut borders: [Vec<(f64, usize, [f64; 2])>; 2] = [Vec::new(), Vec::new()];
    let mut k = 0;
    while k < ends.len() {
        let (fixed, at, upper, x, id) = ends[k];
        let reach = SAME * spaces[1 - fixed].length();
        // The nearest on the other side of the line, next to it in order.
        let partner =
            ends.get(k + 1).filter(|o| o.0 == fixed && o.1 == at && o.2 != upper && (o.3 - x).abs() <= reach);
        if let Some(partner) = partner {
            links[id] = Some(partner.4);
            links[partner.4] = Some(id);
            k += 2;
            continue;
        }
        let (start, end) = spaces[fixed].domain();
        if at == start || at == end {
            let mut place = [0.0; 2];
            (place[fixed], place[1 - fixed]) = (at, x);
            borders[fixed].push((x, id, place));
        }
        k += 1;
    }
    // Across the seam of a closed surface.
    for (fixed, list) in borders.iter_mut().enumerate() {
        list.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let reach = SAME * spaces[1 - fixed].length();
        for k in 0..list.len() {
            let (x, id, place) = list[k];
            if links[id].is_some() {
                continue;
            }
            let other = list[k + 1..].iter().take_while(|o| o.0 - x <= reach).find(|o| {
                let points = cells.point(place).zip(cells.point(o.2));
                links[o.1].is_none()
                    && o.2[fixed] != place[fixed]
                    && points.is_some_and(|(p, q)| (p - q).norm() <= 1e-9)
            });
            if let Some(&(_, other, _)) = other {
                links[id] = Some(other);
                links[other] = Some(id);
            }
        }
    }
    links
}
