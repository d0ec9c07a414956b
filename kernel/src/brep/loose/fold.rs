//! Faces that an edit has laid on themselves: from one place to the next their normal turns over.

use super::super::Brep;
use super::Loose;
use super::strand::inside;
use crate::Vector;
use crate::error::Result;
use crate::spline::{Space, Surface};
use crate::text::{figure, measured};

/// Parts of a span in each direction, at whose ends normals are looked at: so many at least, and more of few spans.
const EACH: usize = 4;
const PARTS: usize = 128;
/// Normals are compared that are this part of the domain apart. (A surface in space has hardly ever a line at which its normal turns by 180° at once:
/// what lies on itself bends around in next to nothing.)
const NEAR: f64 = 1.0 / 64.0;
/// A normal that turns by more between such places (cos 120°) turns over; one that turned by more than a right angle before did so already.
const OVER: f64 = -0.5;
/// So many faces are told one by one.
const TOLD: usize = 3;

/// Where a face lies on itself.
#[derive(Debug, Clone, Copy)]
struct Fold {
    /// The two neighbouring places.
    between: [[f64; 2]; 2],
    /// The cosine of the angle between the normals there.
    cosine: f64,
}

impl Brep {
    /// Notes on the faces among these that the edit has folded: along `u` or `v` their normal turns by more than 120° within 1/64 of the domain, and
    /// turned by less than a right angle there before. It is looked at at the ends of equal parts of spans (four each, 128 in each direction at least).
    /// `O(spans)` evaluations.
    pub(super) fn folds(&self, loose: &Loose, moved: &[usize]) -> Result<Vec<String>> {
        let mut found = Vec::new();
        for &face in moved {
            if let Some(fold) = self.fold(loose, face)? {
                found.push((face, fold));
            }
        }
        found.sort_by(|a, b| a.1.cosine.total_cmp(&b.1.cosine).then(a.0.cmp(&b.0)));
        let mut notes: Vec<String> = found.iter().take(TOLD).map(|(face, fold)| told(*face, fold)).collect();
        if let more @ 1.. = found.len().saturating_sub(TOLD) {
            notes.push(format!("{more} more face{} folded over", if more == 1 { " is" } else { "s are" }));
        }
        Ok(notes)
    }

    /// The place of a face where its normal turns over most.
    fn fold(&self, loose: &Loose, face: usize) -> Result<Option<Fold>> {
        let Some(now) = self.surface(face) else { return Ok(None) };
        let before = loose.base[self.range_of(face)].to_vec();
        let before =
            Surface::build(now.u().clone(), now.v().clone(), before, now.weights().map(<[f64]>::to_vec))?;
        let [along_u, along_v] = [now.u(), now.v()].map(Looks::new);
        let mut normals = Vec::with_capacity(along_u.at.len() * along_v.at.len());
        for &u in &along_u.at {
            for &v in &along_v.at {
                normals.push(normal(&now, [u, v])?);
            }
        }
        let (mut worst, mut part): (Option<Fold>, _) = (None, None);
        let columns = along_v.at.len();
        let place = |number: usize| [along_u.at[number / columns], along_v.at[number % columns]];
        for number in 0..normals.len() {
            let (i, j) = (number / columns, number % columns);
            let beside = along_u.before(i).map(|i| i * columns + j);
            for other in beside.chain(along_v.before(j).map(|j| i * columns + j)) {
                let Some(cosine) = cosine(normals[number], normals[other]) else { continue };
                if cosine > worst.map_or(OVER, |fold| fold.cosine) {
                    continue;
                }
                let between = [place(other), place(number)];
                if part.is_none() {
                    part = Some(self.part(face)?);
                }
                let on = part.as_ref().is_some_and(|part| between.into_iter().all(|at| part.has(at)));
                let [a, b] = between.map(|at| normal(&before, at));
                if on && self::cosine(a?, b?).is_some_and(|cosine| cosine >= 0.0) {
                    worst = Some(Fold { between, cosine });
                }
            }
        }
        Ok(worst)
    }
}

/// Where normals are looked at in a direction.
struct Looks {
    /// The ends of parts of all spans, ascending.
    at: Vec<f64>,
    /// For each of them the last one that is as far before it as normals are compared.
    far: Vec<Option<usize>>,
}

impl Looks {
    fn new(space: &Space) -> Self {
        let knots = space.breakpoints();
        let each = PARTS.div_ceil(knots.len().saturating_sub(1).max(1)).max(EACH);
        let ends = knots.windows(2).map(|pair| (pair[0], pair[1]));
        let parts = ends.flat_map(|(a, b)| (0..each).map(move |k| a + (b - a) * (k as f64 / each as f64)));
        let at: Vec<f64> = parts.chain(knots.last().copied()).collect();
        let way = NEAR * space.length();
        let far = at.iter().map(|t| at.partition_point(|other| *other <= t - way).checked_sub(1));
        let far = far.collect();
        Self { at, far }
    }

    /// The ones before it with which one is compared: its neighbours, so that a narrow pleat is seen, and that one.
    fn before(&self, number: usize) -> impl Iterator<Item = usize> + use<> {
        let near = (1..=2).filter_map(move |k| number.checked_sub(k));
        near.chain(self.far[number])
    }
}

fn normal(surface: &Surface, [u, v]: [f64; 2]) -> Result<Option<Vector>> {
    super::normal(surface, inside(surface, u, v))
}

fn cosine(a: Option<Vector>, b: Option<Vector>) -> Option<f64> {
    Some(a?.dot(&b?))
}

fn told(face: usize, fold: &Fold) -> String {
    let at = |[u, v]: [f64; 2]| format!("({}, {})", measured(u), measured(v));
    let [a, b] = fold.between.map(at);
    format!(
        "face {face} is folded over: its normal turns by {}° between its (u, v) = {a} and {b}; move less at once, let more faces move \
         (\"neighbours\"), or ask for a smoother change",
        figure(fold.cosine.clamp(-1.0, 1.0).acos().to_degrees()),
    )
}
