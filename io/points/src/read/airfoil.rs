//! The conventions of airfoil collections.

use loftsman_kernel::Point;

use super::scan::Block;

/// The row counts that a Lednicer file starts with, if this one does: two whole numbers that add up to the rows
/// behind them and cannot be a point of the outline, because they lie outside it or blank lines set them apart.
pub(super) fn lednicer_counts(block: &Block) -> Option<(usize, usize)> {
    let (first, rest) = block.points.split_first()?;
    let count = |x: f64| (x >= 2.0 && x.fract() == 0.0 && x <= rest.len() as f64).then_some(x as usize);
    let (upper, lower) = (count(first.x)?, count(first.y)?);
    if upper.checked_add(lower) != Some(rest.len()) || rest.iter().any(|p| p.z != 0.0) {
        return None;
    }
    // Where blank lines set the surfaces apart elsewhere, the counts contradict them.
    if matches!(block.gaps[..], [1, second] if second != 1 + upper) {
        return None;
    }
    // And where nothing but the rows do: the one place at which x falls back to the leading edge.
    if !are_surfaces(&rest[..upper], &rest[upper..]) && lednicer_blocks(block).is_some() {
        return None;
    }
    let apart = block.gaps.contains(&1) && block.gaps.contains(&(1 + upper));
    let outside = rest.iter().all(|p| p.x < first.x && p.y.abs() < first.y);
    (apart || outside).then_some((upper, lower))
}

/// Two whole numbers in the first row, and the rows behind it.
fn counts_and_rows(block: &Block) -> Option<((f64, f64), &[Point])> {
    counts_of(block, 2.0)
}

/// The same of numbers that are so large at least.
fn counts_of(block: &Block, least: f64) -> Option<((f64, f64), &[Point])> {
    let (first, rest) = block.points.split_first()?;
    let whole = |x: f64| x >= least && x.fract() == 0.0;
    (whole(first.x) && whole(first.y) && !rest.is_empty()).then_some(((first.x, first.y), rest))
}

/// Whether a point is near to the unit chord.
fn is_unit(p: &Point) -> bool {
    p.x >= -0.5 && p.x <= 1.5 && p.y.abs() <= 1.0 && p.z == 0.0
}

/// Whether these are the two surfaces of an airfoil: each runs along x one way, and both end where the other does: else one of them is cut off.
fn are_surfaces(upper: &[Point], lower: &[Point]) -> bool {
    let runs = |part: &[Point]| {
        let (there, back) = (|w: &[Point]| w[1].x >= w[0].x, |w: &[Point]| w[1].x <= w[0].x);
        part.len() >= 2 && (part.windows(2).all(there) || part.windows(2).all(back))
    };
    let trailing = |part: &[Point]| part.iter().map(|p| p.x).reduce(f64::max);
    let ends_meet = trailing(upper).zip(trailing(lower)).is_some_and(|(a, b)| (a - b).abs() <= 0.05);
    runs(upper) && runs(lower) && ends_meet
}

/// A counts row that does not fit the rows behind it: two whole numbers, set apart by a blank line, that add up to the rows all the same, or
/// are far outside the unit chord that all other rows keep to, or those up to the next blank lines, where these are two surfaces.
pub(super) fn wrong_counts(block: &Block) -> Option<(f64, f64, usize)> {
    let ((upper, lower), rest) = counts_and_rows(block)?;
    let as_many = upper + lower == rest.len() as f64;
    let surfaces = || match block.gaps[..] {
        [1, second, third, ..] => {
            let (one, other) = (&rest[..second - 1], &rest[second - 1..third - 1]);
            one.iter().chain(other).all(is_unit) && are_surfaces(one, other)
        }
        _ => false,
    };
    let counts = block.gaps.contains(&1) && (as_many || rest.iter().all(is_unit) || surfaces());
    counts.then_some((upper, lower, rest.len()))
}

/// The rows of the two surfaces of a file with a counts row that does not fit them: those between its blank lines, or up
/// to where x falls back from the trailing edge to the leading edge.
pub(super) fn lednicer_blocks(block: &Block) -> Option<(usize, usize)> {
    // Set apart by blank lines before two surfaces, no numbers are a point.
    let least = if let [1, _] = block.gaps[..] { 0.0 } else { 2.0 };
    let ((one, other), rest) = counts_of(block, least)?;
    let falls_back = || {
        let mut falls = (1..rest.len()).filter(|&k| rest[k].x < rest[k - 1].x);
        falls.next().filter(|_| falls.next().is_none())
    };
    let split = match block.gaps[..] {
        [1, second] if one < 2.0 || other < 2.0 => {
            let surfaces = rest.iter().all(is_unit) && rest.len() >= 6;
            surfaces.then_some(second - 1)?
        }
        [1, second] => wrong_counts(block).map(|_| second - 1)?,
        [1] => wrong_counts(block).and_then(|_| falls_back())?,
        // Nothing but the shape of all others says that the first row is none of them.
        [] => {
            let split = falls_back().filter(|_| rest.iter().all(is_unit))?;
            (rest[0].x - rest[split].x).abs().le(&0.05).then_some(split)?
        }
        _ => return None,
    };
    let (upper, lower) = rest.split_at(split);
    are_surfaces(upper, lower).then_some((split, rest.len() - split))
}

/// A first row that may count others and does not, far outside the unit chord that these keep to.
pub(super) fn stray(block: &Block) -> Option<(f64, f64)> {
    let (counts, rest) = counts_and_rows(block)?;
    (rest.len() >= 4 && rest.iter().all(is_unit)).then_some(counts)
}

/// What came of two surfaces.
pub(super) struct Outline {
    /// From the trailing edge over the upper side and the nose to the lower trailing edge.
    pub(super) points: Vec<Point>,
    /// Whether both surfaces had the same first point, which is kept once.
    pub(super) shared_nose: bool,
    /// What was not as the convention has it.
    pub(super) notes: Vec<&'static str>,
}

/// One outline of the two surfaces of a Lednicer file, each from the leading edge to the trailing edge.
pub(super) fn lednicer_outline(rows: &[Point], upper: usize) -> Outline {
    let (first, second) = rows.split_at(upper);
    let (mut first, mut second) = (first.to_vec(), second.to_vec());
    let mut notes = Vec::new();
    for surface in [&mut first, &mut second] {
        let backwards = surface.first().zip(surface.last()).is_some_and(|(a, b)| a.x > b.x);
        if backwards {
            surface.reverse();
            notes.push("a surface ran from the trailing edge to the leading edge and was turned round");
        }
    }
    if area_below(&first) < area_below(&second) {
        std::mem::swap(&mut first, &mut second);
        notes.push("the lower surface came first; the outline runs over the upper one first all the same");
    }
    let shared_nose = first.first() == second.first();
    first.reverse();
    first.extend(&second[usize::from(shared_nose)..]);
    Outline { points: first, shared_nose, notes }
}

/// `∫ y dx` along a surface, by the trapezoidal rule.
fn area_below(points: &[Point]) -> f64 {
    points.windows(2).map(|w| 0.5 * (w[0].y + w[1].y) * (w[1].x - w[0].x)).sum()
}

/// Whether points run as in a Selig file: from the trailing edge, where x is largest, to the leading edge, where
/// it is least, and back, in a plane and longer than thick.
pub(super) fn is_selig(points: &[Point]) -> bool {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return false };
    if points.len() < 5 || points.iter().any(|p| p.z != 0.0) {
        return false;
    }
    let (low, high) = points.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let chord = high.x - low.x;
    let close = |p: &Point| high.x - p.x <= 0.05 * chord;
    let Some(nose) = points.iter().position(|p| p.x == low.x) else { return false };
    // Rounded tables may stand still for a row or two, hence not strictly.
    let there = points[..=nose].windows(2).all(|w| w[1].x <= w[0].x);
    let back = points[nose..].windows(2).all(|w| w[1].x >= w[0].x);
    close(first) && close(last) && high.y - low.y < 0.8 * chord && there && back
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[[f64; 2]]) -> Vec<Point> {
        list.iter().map(|&[x, y]| Point::new(x, y, 0.0)).collect()
    }

    #[test]
    fn an_outline_comes_out_the_same_however_the_surfaces_come_in() {
        let upper = [[0.0, 0.0], [0.5, 0.1], [1.0, 0.01]];
        let lower = [[0.0, 0.0], [0.5, -0.05], [1.0, -0.01]];
        let expected = points(&[[1.0, 0.01], [0.5, 0.1], [0.0, 0.0], [0.5, -0.05], [1.0, -0.01]]);
        let usual = lednicer_outline(&points(&[upper, lower].concat()), 3);
        assert!(usual.shared_nose && usual.notes.is_empty());
        assert_eq!(usual.points, expected);
        let swapped = lednicer_outline(&points(&[lower, upper].concat()), 3);
        assert_eq!((swapped.points, swapped.notes.len()), (expected.clone(), 1));
        let mut turned = upper;
        turned.reverse();
        let turned = lednicer_outline(&points(&[turned, lower].concat()), 3);
        assert_eq!((turned.points, turned.notes.len()), (expected.clone(), 1));
        assert!(is_selig(&expected));
    }

    #[test]
    fn a_point_is_not_taken_for_counts() {
        let rows = |first: [f64; 2], gaps: &[usize]| {
            let mut list = vec![first];
            list.extend([[0.0, 0.0], [5.0, 5.0], [9.0, 0.0], [3.0, -4.0]]);
            Block { points: points(&list), gaps: gaps.to_vec(), ..Block::default() }
        };
        assert_eq!(lednicer_counts(&rows([2.0, 2.0], &[])), None);
        assert_eq!(lednicer_counts(&rows([2.0, 2.0], &[1, 3])), Some((2, 2)));
        assert_eq!(lednicer_counts(&rows([2.0, 3.0], &[1, 3])), None);
        assert_eq!(lednicer_counts(&rows([f64::MAX, 2.0], &[1, 3])), None);
        // Counts that add up, and blank lines that say otherwise.
        let mut list = vec![[3.0, 4.0], [1.0, 0.0], [0.5, 0.1], [0.1, 0.05], [0.0, 0.0]];
        list.extend([[0.0, 0.0], [0.5, -0.05], [1.0, 0.0]]);
        let block = |gaps: &[usize]| Block { points: points(&list), gaps: gaps.to_vec(), ..Block::default() };
        assert_eq!(lednicer_counts(&block(&[1, 5])), None);
        assert_eq!(lednicer_blocks(&block(&[1, 5])), Some((4, 3)));
        assert_eq!(lednicer_counts(&block(&[1, 4])), Some((3, 4)));
    }
}
