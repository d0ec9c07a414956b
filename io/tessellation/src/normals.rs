//! Unit normals, also where the two first derivatives do not span a plane.

use loftsman_kernel::Vector;

use crate::bezier::less;
use crate::patch::{Jet, Patch};

/// Derivatives smaller than this fraction of the patch's size, or an angle between them smaller than this, give no
/// normal that rounding would not have made.
const SINGULAR: f64 = 1e-9;

/// The unit normal at parameters of a patch, or its limit from inside; zero where there is neither.
///
/// Where `S_u × S_v` vanishes on the patch's border, its derivative into the patch takes its place: along `v` that is
/// `S_uv × S_v + S_u × S_vv`, along `u` `S_uu × S_v + S_u × S_uv`. At a pole, where all of an edge is one point, it is
/// the tangent plane's normal.
pub(crate) fn normal(patch: &Patch, at: [f64; 2], jet: &Jet) -> Vector {
    let least = SINGULAR * patch.size;
    let (uu, vv) = (jet.u.norm_squared(), jet.v.norm_squared());
    let cross = jet.u.cross(&jet.v);
    let squared = cross.norm_squared();
    let plain = less(uu, vv) > least * least && squared > SINGULAR * SINGULAR * uu * vv;
    // Of what is smaller or larger, squares of squares may not be numbers.
    if plain && (1e-150..1e150).contains(&squared) {
        return cross * (1.0 / squared.sqrt());
    }
    careful(patch, at, jet)
}

/// As [`normal`], in unit vectors from the start.
#[cold]
fn careful(patch: &Patch, at: [f64; 2], jet: &Jet) -> Vector {
    let least = SINGULAR * patch.size;
    let (lu, lv) = (jet.u.norm(), jet.v.norm());
    if lu > least && lv > least {
        let cross = (jet.u / lu).cross(&(jet.v / lv));
        let length = cross.norm();
        if length > SINGULAR {
            return cross / length;
        }
    }
    limit(patch, at, jet)
}

fn limit(patch: &Patch, at: [f64; 2], jet: &Jet) -> Vector {
    let size = patch.size;
    if !(size > 0.0 && size.is_finite()) {
        return Vector::zeros();
    }
    let inward = at.map(|x| {
        if x <= 0.0 {
            1.0
        } else if x >= 1.0 {
            -1.0
        } else {
            0.0
        }
    });
    let [uu, uv, vv] = patch.second(at).1.map(|d| d / size);
    let (u, v) = (jet.u / size, jet.v / size);
    let along = [uu.cross(&v) + u.cross(&uv), uv.cross(&v) + u.cross(&vv)];
    let ways = [along[1] * inward[1], along[0] * inward[0], along[0] * inward[0] + along[1] * inward[1]];
    ways.into_iter().find(|way| way.norm() > SINGULAR).map_or_else(Vector::zeros, |way| way.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collapsed_edge_has_the_normal_of_its_tangent_plane() {
        // A bilinear patch whose edge v = 0 is one point: a flat triangle, upwards.
        let net =
            vec![[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]];
        let patch = Patch::new(net, 2, 2, false);
        for at in [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 0.5]] {
            let normal = normal(&patch, at, &patch.jet(at));
            assert!((normal + Vector::z()).norm() < 1e-15, "{at:?} {normal}");
        }
    }
}
