//! Segments that hang together, as chains.

use std::collections::HashMap;

/// Segments between numbered places as chains, as long as they go; each segment once. Linear but for a sort.
pub(crate) fn linked(segments: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut ends: Vec<(usize, usize)> =
        segments.iter().enumerate().flat_map(|(i, (a, b))| [(*a, i), (*b, i)]).collect();
    ends.sort_unstable();
    let first = |place: usize| ends.partition_point(|(p, _)| *p < place);
    let mut used = vec![false; segments.len()];
    // Where the next unused segment of a place is looked for: what is before is used.
    let mut next: HashMap<usize, usize> = HashMap::new();
    let mut chains = Vec::new();
    let mut walk = |start: usize, used: &mut Vec<bool>| {
        let mut chain = vec![start];
        let mut place = start;
        loop {
            let at = next.entry(place).or_insert_with(|| first(place));
            while ends.get(*at).is_some_and(|(p, i)| *p == place && used[*i]) {
                *at += 1;
            }
            match ends.get(*at) {
                Some(&(p, i)) if p == place => {
                    used[i] = true;
                    let (a, b) = segments[i];
                    place = if a == place { b } else { a };
                    chain.push(place);
                }
                _ => return chain,
            }
        }
    };
    // From the places where an odd number of segments end, so that chains begin at their ends; then what is left are loops.
    let mut at = 0;
    let mut odd = Vec::new();
    while at < ends.len() {
        let place = ends[at].0;
        let count = ends[at..].iter().take_while(|(p, _)| *p == place).count();
        if count % 2 == 1 {
            odd.push(place);
        }
        at += count;
    }
    for start in odd.into_iter().chain(segments.iter().map(|(a, _)| *a)) {
        let chain = walk(start, &mut used);
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_have_every_segment_once() {
        // A square with a tail, and a loop of its own.
        let segments = [(0, 1), (1, 2), (2, 3), (3, 0), (3, 4), (7, 8), (8, 9), (9, 7)];
        let chains = linked(&segments);
        let mut found: Vec<(usize, usize)> =
            chains.iter().flat_map(|c| c.windows(2)).map(|s| (s[0].min(s[1]), s[0].max(s[1]))).collect();
        found.sort_unstable();
        let mut expected = segments.map(|(a, b)| (a.min(b), a.max(b)));
        expected.sort_unstable();
        assert_eq!(found, expected);
        assert_eq!(chains.len(), 2);
        assert_eq!(linked(&[]), Vec::<Vec<usize>>::new());
    }
}
