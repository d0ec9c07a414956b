//! The rules of Hoppe, DeRose, Kass and Truong: which mixture of smooth, crease and corner makes the next point of a vertex.

use crate::cage::decayed;

/// How the next point of a vertex is mixed: weights of the rules, which sum to one, and between which two of its edges a crease runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VertexRule {
    pub(crate) smooth: f64,
    pub(crate) crease: f64,
    pub(crate) corner: f64,
    /// The places of the two sharp edges round the vertex, where `crease` counts.
    pub(crate) ends: [usize; 2],
}

impl VertexRule {
    /// Nothing is sharp.
    pub(crate) const SMOOTH: Self = Self { smooth: 1.0, crease: 0.0, corner: 0.0, ends: [0; 2] };

    fn add(&mut self, kind: Kind, weight: f64) {
        match kind {
            Kind::Smooth => self.smooth += weight,
            Kind::Crease(ends) => (self.crease, self.ends) = (self.crease + weight, ends),
            Kind::Corner => self.corner += weight,
        }
    }
}

/// What a vertex is: with no or one sharp edge (a dart) smooth, with two on a crease, with more, or sharp itself, a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Smooth,
    Crease([usize; 2]),
    Corner,
}

/// What a vertex is by its own sharpness and those of the edges round it.
pub(crate) fn kind(vertex: f64, edges: impl Iterator<Item = f64>) -> Kind {
    if vertex > 0.0 {
        return Kind::Corner;
    }
    let mut sharp = edges.enumerate().filter(|(_, s)| *s > 0.0).map(|(k, _)| k);
    match (sharp.next(), sharp.next(), sharp.next()) {
        (_, _, Some(_)) => Kind::Corner,
        (Some(a), Some(b), None) => Kind::Crease([a, b]),
        _ => Kind::Smooth,
    }
}

/// The rule for a vertex of this sharpness whose edges have these, all infinite on the boundary.
///
/// Where the vertex becomes something else by refinement (sharpness ends), its rule and that of its child are blended by the mean of
/// the sharpnesses that end, at most 1 (DeRose, Kass and Truong 1998, section 3; OpenSubdiv 3.5, `CREASE_UNIFORM`).
pub(crate) fn vertex_rule(vertex: f64, edges: impl Iterator<Item = f64> + Clone) -> VertexRule {
    let now = kind(vertex, edges.clone());
    if now == Kind::Smooth {
        return VertexRule::SMOOTH;
    }
    let then = kind(decayed(vertex), edges.clone().map(decayed));
    let mut rule = VertexRule { smooth: 0.0, ..VertexRule::SMOOTH };
    if now == then {
        rule.add(now, 1.0);
        return rule;
    }
    let ending = std::iter::once(vertex).chain(edges).filter(|&s| s > 0.0 && decayed(s) <= 0.0);
    let (count, sum) = ending.fold((0.0, 0.0), |(count, sum), s| (count + 1.0, sum + s));
    let share = if count > 0.0 { f64::min(sum / count, 1.0) } else { 0.0 };
    rule.add(now, share);
    rule.add(then, 1.0 - share);
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(vertex: f64, edges: &[f64]) -> VertexRule {
        vertex_rule(vertex, edges.iter().copied())
    }

    #[test]
    fn sharpness_below_one_blends_with_what_comes_after() {
        assert_eq!(rule(0.0, &[0.0, 3.0, 0.0]), VertexRule::SMOOTH);
        let crease = rule(0.0, &[2.0, 0.0, 1.5]);
        assert_eq!((crease.crease, crease.ends), (1.0, [0, 2]));
        // Both end, 0.3 and 0.5 on average 0.4.
        let ends = rule(0.0, &[0.3, 0.0, 0.5]);
        assert!((ends.crease - 0.4).abs() < 1e-15 && (ends.smooth - 0.6).abs() < 1e-15);
        // One of three ends: a corner becomes a crease between the others.
        let corner = rule(0.0, &[0.25, 4.0, 0.0, f64::INFINITY]);
        assert_eq!((corner.corner, corner.crease, corner.ends), (0.25, 0.75, [1, 3]));
        assert_eq!(rule(0.5, &[0.0; 4]), VertexRule { smooth: 0.5, crease: 0.0, corner: 0.5, ends: [0; 2] });
        assert_eq!(rule(10.0, &[0.0; 4]).corner, 1.0);
    }
}
