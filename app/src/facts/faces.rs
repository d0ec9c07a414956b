//! The faces of a Brep, as recipes name places on them: `{ face, uv }`.

use loftsman_kernel::brep::Brep;
use loftsman_kernel::nalgebra::Matrix4;
use loftsman_kernel::parallel;
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::spline::part::Part;

/// A face of a Brep.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct FaceFacts {
    /// Its number, from 0 on.
    pub face: usize,
    /// Its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What its surface is: `"plane"`, `"cylinder"`, `"spline"` and their like.
    pub form: &'static str,
    /// The parameters of its surface, along `u` and `v`; the face is what its loops leave of these.
    pub domain: [[f64; 2]; 2],
    /// The parameters of a place well inside of it; none where its loops cannot be told in parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uv: Option<[f64; 2]>,
    /// Where that place is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
}

/// All faces of a Brep, places where a map puts them. Loops are laid out in parameters, and places looked at in each of these.
pub(crate) fn faces(brep: &Brep, map: Option<&Matrix4<f64>>) -> Vec<FaceFacts> {
    let of = |face: usize| {
        let surface = brep.surface(face)?;
        let uv = brep.part(face).ok().and_then(|part| inside(&part));
        let at = uv.and_then(|[u, v]| surface.point(u, v).ok());
        let at = at.map(|at| map.map_or(at, |map| transform_point(map, &at)).coords.into());
        Some(FaceFacts {
            face,
            name: brep.face_name(face).map(str::to_owned),
            form: brep.surface_form(face).name(),
            domain: [surface.u(), surface.v()].map(|space| space.domain().into()),
            uv,
            at,
        })
    };
    parallel::map(brep.face_count(), of).into_iter().flatten().collect()
}

/// Places in each direction that are looked at, few first: odd, so that the middle is one of them.
const LOOKS: [usize; 3] = [17, 65, 257];

/// A place in a part of a surface, as far from its border along the lines of parameters as the places tell that are looked at: the middle of a rectangle. None
/// where the part is narrower than that.
fn inside(part: &Part) -> Option<[f64; 2]> {
    let whole = [part.surface().u(), part.surface().v()].map(|space| <[f64; 2]>::from(space.domain()));
    // Within its border first. A cap around a pole lies beyond that, a loop around the surface.
    let around = around(part).filter(|around| around.iter().all(|[from, to]| from < to));
    // Loops that run all around may start anywhere: the seam, where the domain ends, is to be no middle.
    let all_around = |d: usize, [from, to]: [f64; 2]| to - from >= (1.0 - 1e-9) * (whole[d][1] - whole[d][0]);
    let around = around.map(|around| {
        std::array::from_fn(|d: usize| if all_around(d, around[d]) { whole[d] } else { around[d] })
    });
    let boxes: Vec<[[f64; 2]; 2]> = around.into_iter().chain([whole]).collect();
    LOOKS.iter().find_map(|&count| boxes.iter().find_map(|within| innermost(part, *within, count)))
}

/// The box around the border, in parameters.
fn around(part: &Part) -> Option<[[f64; 2]; 2]> {
    let points = part.border().iter().flat_map(|curve| curve.curve().points());
    points
        .map(|p| [[p.x; 2], [p.y; 2]])
        .reduce(|a, b| std::array::from_fn(|d| [a[d][0].min(b[d][0]), a[d][1].max(b[d][1])]))
}

/// Of so many places each way the one that has most others between it and what is outside, in the direction in which it has fewest.
fn innermost(part: &Part, within: [[f64; 2]; 2], count: usize) -> Option<[f64; 2]> {
    let at = |k: [usize; 2]| -> [f64; 2] {
        std::array::from_fn(|d| {
            let [from, to] = within[d];
            from + (to - from) * ((k[d] as f64 + 0.5) / count as f64)
        })
    };
    let place = |index: usize| [index / count, index % count];
    let has: Vec<bool> = (0..count * count).map(|index| part.has(part.wrapped(at(place(index))))).collect();
    let mut room = vec![usize::MAX; count * count];
    // Along each line there and back: how many places in a row are inside.
    for line in 0..count {
        for across in [false, true] {
            for back in [false, true] {
                let mut run = 0;
                for step in 0..count {
                    let step = if back { count - 1 - step } else { step };
                    let index = if across { step * count + line } else { line * count + step };
                    run = if has[index] { run + 1 } else { 0 };
                    room[index] = room[index].min(run);
                }
            }
        }
    }
    let best = (0..room.len()).reduce(|best, k| if room[k] > room[best] { k } else { best })?;
    (room[best] > 0).then(|| part.wrapped(at(place(best))))
}
