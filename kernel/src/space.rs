//! A spline space: a degree and a knot vector, and the B-spline basis functions they define.

use std::sync::Arc;

/// From which side of a knot a derivative is taken: where a knot is repeated often enough, the two differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, PartialOrd, Ord)]
pub enum Side {
    /// That of the piece which ends at the knot; at the start of a periodic direction, of the piece that ends its period.
    Left,
    /// That of the piece which begins at the knot, as everywhere where no side is said.
    #[default]
    Right,
}

use crate::error::{Error, MAX_DEGREE, Result};

/// The order (degree + 1) that every basis row on the stack has room for.
pub const MAX_ORDER: usize = MAX_DEGREE + 1;

/// A space of splines in one parameter: the functions that a curve, or one direction of a surface, is made of.
///
/// *Open*: `n` vertices, `n + p + 1` knots, domain `[t_p, t_n]`; clamped or not.
/// *Periodic*: `n` distinct vertices, `n + 1` knots over one period, domain `[t_0, t_n]`; vertex `i` multiplies
/// the B-spline whose support starts at `t_i`.
///
/// Both are kept as one *unrolled* open knot vector, so that every algorithm is written once: unrolled basis
/// function `k` (support from [`flat`](Self::flat)`[k]`) belongs to vertex [`vertex(k)`](Self::vertex).
/// Cloning is cheap: the knots are shared.
#[derive(Debug, Clone)]
pub struct Space {
    degree: usize,
    periodic: bool,
    len: usize,
    /// How often the knot inside the domain that is repeated most often is there.
    repeats: usize,
    flat: Arc<[f64]>,
}

impl PartialEq for Space {
    fn eq(&self, other: &Self) -> bool {
        self.degree == other.degree
            && self.periodic == other.periodic
            && (Arc::ptr_eq(&self.flat, &other.flat) || self.flat == other.flat)
    }
}

impl Space {
    /// The open space of degree `p` over `n + p + 1` knots.
    ///
    /// # Errors
    /// When the degree exceeds 25, a knot is not finite or decreases, one is repeated more than `p + 1` times,
    /// there are fewer than `2p + 2` knots, or the domain `[t_p, t_n]` has no length.
    pub fn open(degree: usize, knots: Vec<f64>) -> Result<Self> {
        check_degree(degree)?;
        let needed = 2 * (degree + 1);
        if knots.len() < needed {
            let vertices = knots.len().saturating_sub(degree + 1);
            return Err(Error::TooFewVertices { vertices, degree, needed: degree + 1 });
        }
        check_knots(&knots, degree, degree + 1)?;
        let len = knots.len() - degree - 1;
        check_domain(knots[degree], knots[len])?;
        let (start, end) = (knots[degree], knots[len]);
        let inner = &knots[degree + 1..len];
        let inner = &inner[inner.partition_point(|&k| k <= start)..inner.partition_point(|&k| k < end)];
        Ok(Self { degree, periodic: false, len, repeats: longest_run(inner), flat: knots.into() })
    }

    /// The periodic space of degree `p` over the `n + 1` knots of one period.
    ///
    /// # Errors
    /// As for [`open`](Self::open); a knot may be repeated `max(p, 1)` times within a period, and at least two
    /// vertices are needed.
    pub fn periodic(degree: usize, knots: Vec<f64>) -> Result<Self> {
        check_degree(degree)?;
        if knots.len() < 3 {
            return Err(Error::TooFewVertices { vertices: knots.len().saturating_sub(1), degree, needed: 2 });
        }
        check_knots(&knots, degree, degree.max(1))?;
        let n = knots.len() - 1;
        let (start, end) = (knots[0], knots[n]);
        check_domain(start, end)?;
        // The first and the last knot are one knot of the closed line: count them together.
        let around = knots.iter().take_while(|&&k| k == start).count()
            + knots[1..].iter().rev().take_while(|&&k| k == end).count()
            - 1;
        if around > degree.max(1) {
            let allowed = degree.max(1);
            return Err(Error::Multiplicity { value: start, multiplicity: around, degree, allowed });
        }
        let p = degree as isize;
        let flat: Arc<[f64]> = (-p..=n as isize + p).map(|k| periodic_knot(&knots, k)).collect();
        Ok(Self { degree, periodic: true, len: n, repeats: longest_run(&knots).max(around), flat })
    }

    /// Open space with full-multiplicity end knots (`p + 1` times; paper 4's *fmek* knots) and the given
    /// strictly increasing breakpoints, each interior one simple.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn clamped(degree: usize, breakpoints: &[f64]) -> Result<Self> {
        let (Some(&first), Some(&last)) = (breakpoints.first(), breakpoints.last()) else {
            return Err(Error::TooFewVertices { vertices: 0, degree, needed: degree + 1 });
        };
        check_degree(degree)?;
        let mut knots = vec![first; degree];
        knots.extend_from_slice(breakpoints);
        knots.extend(std::iter::repeat_n(last, degree));
        Self::open(degree, knots)
    }

    /// Clamped space for `vertices` control vertices with breakpoints `0, 1, 2, …`.
    ///
    /// # Errors
    /// When there are fewer than `degree + 1` vertices or the degree exceeds 25.
    pub fn clamped_uniform(degree: usize, vertices: usize) -> Result<Self> {
        check_degree(degree)?;
        if vertices < degree + 1 {
            return Err(Error::TooFewVertices { vertices, degree, needed: degree + 1 });
        }
        let breakpoints: Vec<f64> = (0..=vertices - degree).map(|i| i as f64).collect();
        Self::clamped(degree, &breakpoints)
    }

    /// Floating (unclamped) uniform space for `vertices` control vertices, knots `-p, …, 0, 1, …`; the domain
    /// starts at 0.
    ///
    /// # Errors
    /// When there are fewer than `degree + 1` vertices or the degree exceeds 25.
    pub fn floating_uniform(degree: usize, vertices: usize) -> Result<Self> {
        check_degree(degree)?;
        if vertices < degree + 1 {
            return Err(Error::TooFewVertices { vertices, degree, needed: degree + 1 });
        }
        Self::open(degree, (0..vertices + degree + 1).map(|i| i as f64 - degree as f64).collect())
    }

    /// Periodic uniform space for `vertices` distinct control vertices, knots `0, 1, …, n`.
    ///
    /// # Errors
    /// When there are fewer than two vertices or the degree exceeds 25.
    pub fn periodic_uniform(degree: usize, vertices: usize) -> Result<Self> {
        Self::periodic(degree, (0..=vertices).map(|i| i as f64).collect())
    }

    /// The polynomial degree `p`.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Whether the space is periodic.
    pub fn is_periodic(&self) -> bool {
        self.periodic
    }

    /// The number `n` of control vertices (distinct ones where periodic).
    #[allow(clippy::len_without_is_empty, reason = "a space is never empty")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// The knots as documents keep them: `n + p + 1` of an open space, `n + 1` of a periodic one.
    pub fn knots(&self) -> &[f64] {
        if self.periodic { &self.flat[self.degree..=self.degree + self.len] } else { &self.flat }
    }

    /// The unrolled knots: [`unrolled_len`](Self::unrolled_len)` + p + 1` of them. The domain is
    /// `[flat[p], flat[unrolled_len]]` for open and periodic spaces alike.
    pub fn flat(&self) -> &[f64] {
        &self.flat
    }

    /// The number of unrolled basis functions: `n`, or `n + p` where periodic.
    pub fn unrolled_len(&self) -> usize {
        self.flat.len() - self.degree - 1
    }

    /// The control vertex of unrolled basis function `k`: itself, or `(k - p) mod n` where periodic.
    pub fn vertex(&self, unrolled: usize) -> usize {
        if self.periodic {
            let n = self.len;
            (unrolled + n - self.degree % n) % n
        } else {
            unrolled
        }
    }

    /// Start and end of the domain.
    pub fn domain(&self) -> (f64, f64) {
        (self.flat[self.degree], self.flat[self.unrolled_len()])
    }

    /// Length of the domain (the period, where periodic).
    pub fn length(&self) -> f64 {
        let (a, b) = self.domain();
        b - a
    }

    /// Whether both ends have knots of full multiplicity, so that the ends are control vertices.
    pub fn is_clamped(&self) -> bool {
        let (a, b) = self.domain();
        !self.periodic
            && self.flat[..self.degree].iter().all(|&k| k == a)
            && self.flat[self.unrolled_len() + 1..].iter().all(|&k| k == b)
    }

    /// How often `u` occurs among the knots (of one period, where periodic: both its ends are one knot).
    pub fn multiplicity(&self, u: f64) -> usize {
        let count = |u: f64| {
            let first = self.flat.partition_point(|&k| k < u);
            self.flat[first..].iter().take_while(|&&k| k == u).count()
        };
        if !self.periodic {
            return count(u);
        }
        let (a, b) = self.domain();
        if u == a || u == b { count(a).max(count(b)) } else { count(u) }
    }

    /// How often the knot *inside* the domain that is repeated most often is there: 0 where there is none, 1 where all
    /// are simple. The seam of a periodic space counts as inside. `O(1)`.
    pub fn most_repeated(&self) -> usize {
        self.repeats
    }

    /// The distinct knots of the domain, both ends included: `spans + 1` of them.
    pub fn breakpoints(&self) -> Vec<f64> {
        let mut points: Vec<f64> = self.flat[self.degree..=self.unrolled_len()].to_vec();
        points.dedup();
        points
    }

    /// The non-empty knot spans of the domain: `s` such that `flat[s] < flat[s + 1]`.
    pub fn spans(&self) -> impl Iterator<Item = usize> + '_ {
        (self.degree..self.unrolled_len()).filter(|&s| self.flat[s] < self.flat[s + 1])
    }

    /// Greville abscissa of vertex `i`: the mean of the `p` knots inside its support, where the basis function
    /// has its influence. Wrapped into the domain where periodic. (For degree 0, the middle of the span.)
    pub fn greville(&self, vertex: usize) -> f64 {
        let k = if self.periodic { vertex + self.degree } else { vertex };
        let p = self.degree;
        if p == 0 {
            return 0.5 * (self.flat[k] + self.flat[k + 1]);
        }
        if self.periodic {
            // The support of vertex i starts at t_i and may pass the end of the unrolled knots.
            let (a, _) = self.domain();
            let knots = self.knots();
            let (n, period) = (self.len, self.length());
            let sum: f64 =
                (1..=p).map(|j| knots[(vertex + j) % n] - a + ((vertex + j) / n) as f64 * period).sum();
            let offset = sum / p as f64;
            return a + (offset - period * (offset / period).floor());
        }
        let mean = self.flat[k + 1..=k + p].iter().map(|t| t / p as f64).sum::<f64>();
        let (low, high) = (self.flat[k + 1], self.flat[k + p]);
        mean.max(low).min(high)
    }

    /// `u` as a parameter of the domain: wrapped by the period where periodic (its end is its start, so that one-sided
    /// derivatives there are those from the right, as at every knot), itself where open.
    ///
    /// # Errors
    /// When `u` is not finite, or outside the domain of an open space by more than rounding (8 ulp of the
    /// domain's largest number).
    pub fn locate(&self, u: f64) -> Result<f64> {
        let (a, b) = self.domain();
        if u >= a && (u < b || u == b && !self.periodic) {
            return Ok(u);
        }
        if !u.is_finite() {
            return Err(Error::Outside { value: u, start: a, end: b });
        }
        if self.periodic {
            let period = b - a;
            let wrapped = (u - period * ((u - a) / period).floor()).max(a);
            // The end of a period is its start, exactly; rounding may bring others to the end as well.
            return Ok(if u == b || wrapped >= b { a } else { wrapped });
        }
        let slack = 8.0 * f64::EPSILON * a.abs().max(b.abs());
        if u >= a - slack && u <= b + slack {
            return Ok(u.max(a).min(b));
        }
        Err(Error::Outside { value: u, start: a, end: b })
    }

    /// As [`locate`](Self::locate), but the end of a period stays its end: for knots at the seam, which belong to either
    /// side as they were given.
    pub(crate) fn locate_knot(&self, u: f64) -> Result<f64> {
        let (_, end) = self.domain();
        if u == end { Ok(u) } else { self.locate(u) }
    }

    /// The knot span of a parameter *within* the domain: `s` with `flat[s] ≤ u < flat[s + 1]`; at an interior
    /// knot the span to the right, at the end of the domain the last non-empty one. The `p + 1` basis functions
    /// that do not vanish there are the unrolled ones `s - p ..= s`. `O(log n)`, for uniform knots mostly `O(1)`.
    pub fn span(&self, u: f64) -> usize {
        let (p, m) = (self.degree, self.unrolled_len());
        // Where it is if the knots are uniform.
        let (a, b) = self.domain();
        let guess = p + ((u - a) / (b - a) * (m - p) as f64) as usize;
        if guess < m && self.flat[guess] <= u && u < self.flat[guess + 1] {
            return guess;
        }
        let inner = &self.flat[p + 1..m];
        let mut s = p + inner.partition_point(|&k| k <= u);
        while s > p && self.flat[s] >= self.flat[s + 1] {
            s -= 1;
        }
        s
    }

    /// The non-empty knot span on one side of a parameter *within* the domain, and the parameter as this span knows it:
    /// on the right, as [`span`](Self::span); on the left of a knot the span that ends there, which at the start of a
    /// periodic domain is the last one, at its end. `O(log n)`.
    pub fn span_on(&self, u: f64, side: Side) -> (usize, f64) {
        let (a, b) = self.domain();
        let u = match side {
            Side::Right => return (self.span(u), u),
            Side::Left if self.periodic && u == a => b,
            Side::Left => u,
        };
        let before = self.flat[self.degree..=self.unrolled_len()].partition_point(|&k| k < u);
        // Nothing ends at the start of an open domain.
        (if before == 0 { self.span(u) } else { self.degree + before - 1 }, u)
    }
}

/// The length of the longest run of equal numbers.
fn longest_run(knots: &[f64]) -> usize {
    let (mut longest, mut run) = (usize::from(!knots.is_empty()), 1);
    for pair in knots.windows(2) {
        run = if pair[0] == pair[1] { run + 1 } else { 1 };
        longest = longest.max(run);
    }
    longest
}

/// Knot `k` of the closed line whose one period is `knots` (first and last are the same knot), for any `k`.
///
/// Within the period the knots are kept as given, to the last bit; outside they are measured from the nearer end,
/// so that copies of a multiple knot at the seam stay equal and rounding never makes the knots decrease.
pub(crate) fn periodic_knot(knots: &[f64], k: isize) -> f64 {
    let n = knots.len() - 1;
    let (start, end) = (knots[0], knots[n]);
    let (turns, knot) = (k.div_euclid(n as isize), knots[k.rem_euclid(n as isize) as usize]);
    match turns {
        0 => knot,
        1.. => end + (turns - 1) as f64 * (end - start) + (knot - start),
        _ => start - (-turns - 1) as f64 * (end - start) - (end - knot),
    }
}

fn check_degree(degree: usize) -> Result<()> {
    if degree > MAX_DEGREE { Err(Error::Degree { degree }) } else { Ok(()) }
}

fn check_knots(knots: &[f64], degree: usize, allowed: usize) -> Result<()> {
    let mut run = 1;
    for (index, &value) in knots.iter().enumerate() {
        if !value.is_finite() {
            return Err(Error::KnotNotFinite { index, value });
        }
        if index == 0 {
            continue;
        }
        let before = knots[index - 1];
        if value < before {
            return Err(Error::KnotOrder { index, before, value });
        }
        run = if value == before { run + 1 } else { 1 };
        // Longer runs are an error at their last knot, so that the message counts them all.
        if run > allowed && knots.get(index + 1) != Some(&value) {
            return Err(Error::Multiplicity { value, multiplicity: run, degree, allowed });
        }
    }
    Ok(())
}

fn check_domain(start: f64, end: f64) -> Result<()> {
    let length = end - start;
    // A length below what the numbers can resolve would make every quotient meaningless.
    let resolvable = 16.0 * f64::EPSILON * start.abs().max(end.abs());
    if length > resolvable && length.is_finite() && length >= f64::MIN_POSITIVE {
        Ok(())
    } else {
        Err(Error::EmptyDomain { start, end })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stencil_of_the_theory() {
        let space = Space::clamped(3, &(0..=9).map(f64::from).collect::<Vec<_>>()).unwrap();
        let mut row = [0.0; MAX_ORDER];
        let span = space.span(4.5);
        space.basis_into(span, 4.5, 0, &mut row);
        assert_eq!(space.vertex(span - 3), 4);
        for (value, expected) in row.iter().zip([1.0, 23.0, 23.0, 1.0]) {
            assert!((value - expected / 48.0).abs() < 1e-16);
        }
    }

    #[test]
    fn invalid_spaces_say_why() {
        assert!(matches!(Space::open(1_000_000_000, vec![]), Err(Error::Degree { .. })));
        assert!(matches!(Space::open(1, vec![0.0, 0.0, f64::NAN, 1.0]), Err(Error::KnotNotFinite { .. })));
        assert!(matches!(Space::open(1, vec![0.0, 0.0, 1.0, 0.5]), Err(Error::KnotOrder { index: 3, .. })));
        assert!(matches!(Space::open(1, vec![0.0; 4]), Err(Error::Multiplicity { multiplicity: 4, .. })));
        assert!(matches!(Space::open(2, vec![0.0; 5]), Err(Error::TooFewVertices { needed: 3, .. })));
        assert!(matches!(
            Space::periodic(2, vec![0.0, 0.0, 1.0, 2.0, 2.0]),
            Err(Error::Multiplicity { multiplicity: 3, .. })
        ));
        let tiny = 1e300;
        assert!(Space::open(1, vec![tiny, tiny, tiny * (1.0 + 4e-16), tiny * (1.0 + 4e-16)]).is_err());
    }

    #[test]
    fn the_span_is_found_however_the_knots_are_spaced() {
        let graded: Vec<f64> = (0..=40).map(|i| f64::from(i * i * i)).collect();
        let spaces = [
            Space::clamped_uniform(3, 30).unwrap(),
            Space::periodic_uniform(3, 30).unwrap(),
            Space::clamped(2, &graded).unwrap(),
            Space::open(2, vec![-1.0, -0.5, 0.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.1, 9.0, 9.0, 12.0]).unwrap(),
        ];
        for space in &spaces {
            let (a, b) = space.domain();
            let flat = space.flat();
            let between = (0..=1000).map(|i| a + (b - a) * f64::from(i) / 1000.0);
            let knots = flat.iter().copied().filter(|t| (a..=b).contains(t));
            for u in between.chain(knots).map(|u| u.min(b)) {
                // The last span that starts no later, of those that have a length.
                let found = space.spans().filter(|&s| flat[s] <= u).last().unwrap();
                assert_eq!(space.span(u), found, "{u} in {flat:?}");
            }
        }
    }

    #[test]
    fn periodic_knots_come_back_to_the_bit() {
        let knots = vec![0.1, 0.7, 1.3, 2.9, 3.3];
        let space = Space::periodic(3, knots.clone()).unwrap();
        assert_eq!(space.knots(), knots);
        assert_eq!(space.domain(), (0.1, 3.3));
        assert_eq!(space.flat().len(), 4 + 3 + 3 + 1);
    }

    #[test]
    fn a_multiple_knot_at_the_seam_has_equal_copies_at_both_ends() {
        // 0.1 + (3.3 - 0.1) is not 3.3 in floating point, nor is 3.3 - (3.3 - 0.1) the number 0.1.
        for knots in [vec![0.1, 0.1, 1.3, 2.9, 3.3], vec![0.1, 0.7, 1.3, 3.3, 3.3]] {
            let space = Space::periodic(3, knots).unwrap();
            let flat = space.flat();
            assert!(flat.windows(2).all(|w| w[0] <= w[1]));
            assert_eq!(flat.iter().filter(|&&k| k == 0.1).count(), 2);
            assert_eq!(flat.iter().filter(|&&k| k == 3.3).count(), 2);
        }
    }
}
