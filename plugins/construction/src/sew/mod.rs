//! `sew`: faces that lie beside one another made one shell, edges within a tolerance made one.
//!
//! 1. Vertices of open edges within the tolerance of one another become one, edges no longer than that are left out.
//! 2. An open edge is cut where a vertex of another lies on it, so that one edge may lie along several.
//!    A face that lies on another one, edge for edge, is left out.
//! 3. Of open edges between the same vertices those within the tolerance of one another, measured at eight places of each span and from both sides, become
//!    one, the nearest first; its own tolerance grows to what was found.
//! 4. The loops of faces that are inside out are turned round: of what ends, the loops leave nothing beyond its ends; what closes goes on from the faces beside it.
//! 5. Faces are turned so that they look to one side, as few as may be; what closes becomes a solid that they look out of. As no two solids are in one
//!    place, a closed shell within another bounds what is hollow in that, one within the hollow is a solid again.
//!
//! Surfaces are not moved, and nothing is sewn that was not asked for.

mod gather;
mod hint;
mod inward;
mod join;
mod nest;
mod operation;
mod sides;
mod told;
mod twice;

use std::collections::{BTreeMap, BTreeSet};

use loftsman_kernel::brep::{Brep, Flaw, Parts, Shell, Solid};
use loftsman_kernel::error::{Error, Result};
use loftsman_kernel::plugin::{Chord, Fineness, Tessellator};
use loftsman_kernel::scene::Geometry;

pub use operation::Sew;

use gather::Healed;
use nest::Hull;
use sides::Group;

/// How fine the mesh is that says which side of a shell is outside: finer, where faces cannot be cut so coarsely.
const CHORDS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// What came of faces that were sewn.
#[derive(Debug)]
pub struct Sewn {
    /// The faces with the edges that they share; what closes is a solid.
    pub brep: Brep,
    /// How many pairs of edges became one.
    pub joined: usize,
    /// The widest gap that was closed, measured.
    pub gap: f64,
    /// How many edges were cut at vertices of others.
    pub cut: usize,
    /// How many edges no longer than the tolerance were left out, points not counted.
    pub short: usize,
    /// How long the longest of these was.
    pub longest: f64,
    /// How many faces lay on others, edge for edge, and were left out.
    pub twice: usize,
    /// How many faces were inside out: all of their surface but what their loops go round.
    pub inverted: usize,
    /// How many faces were turned over.
    pub turned: usize,
    /// The edges that are still open.
    pub open: Vec<usize>,
    /// The least tolerance known at which fewer are open, tried: no open edge is nearer to others all along. `None` where none was found, or there are too many to look.
    pub next: Option<f64>,
    /// A tolerance at which none is open, tried.
    pub closes: Option<f64>,
    /// Shells that cannot look to one side, as a Möbius band.
    pub one_sided: usize,
    /// Shells that close, but of which faces could not be cut, so that it is not known which side is outside.
    pub unknown: usize,
    /// What is still further from its place than 1e-4 of the size, as it was before.
    pub flaws: Vec<Flaw>,
}

/// Sews the faces of Breps, surfaces and trimmed surfaces, in one frame, within a tolerance in their unit. Edges and vertices take the tolerances that were
/// measured; colours and names of faces stay. About `O(n log n)` in the number of edges, and one coarse mesh of what closes.
///
/// # Errors
/// When the tolerance is no length, a geometry has no faces, nothing is left that is larger than the tolerance, or an evaluation overflows.
pub fn sew(geometries: &[Geometry], near: f64, tessellator: &dyn Tessellator) -> Result<Sewn> {
    if !(near > 0.0 && near.is_finite()) {
        return Err(Error::Invalid(format!("the tolerance {near} is no length: give a number above 0")));
    }
    let (mut parts, mut healed) = (Parts::default(), Healed::default());
    for geometry in geometries {
        gather::gather(&mut parts, geometry, near, &mut healed)?;
    }
    sew_parts(parts, near, healed, tessellator)
}

/// The same of the faces of parts, whose shells and solids are made anew.
fn sew_parts(mut parts: Parts, near: f64, mut healed: Healed, tessellator: &dyn Tessellator) -> Result<Sewn> {
    let given = parts.clone();
    let joined = join::join(&mut parts, near, &mut healed)?;
    if parts.faces.is_empty() {
        return Err(Error::Invalid("no face is larger than the tolerance: give a smaller one".into()));
    }
    healed.inverted += inward::turn_back(&mut parts)?;
    let (groups, mut turned) = sides::groups(&mut parts);
    parts.shells = groups.iter().map(|group| Shell { faces: group.faces.clone() }).collect();
    parts.solids.clear();
    let unknown = close(&mut parts, &groups, &mut turned, (near, tessellator))?;
    // Edges may be further from the surfaces than from one another: how far is measured.
    let found = Brep::new(parts.clone())?.flaws(0.0)?;
    for flaw in &found {
        match *flaw {
            Flaw::Off { edge, distance, .. } if distance <= near => {
                let known = &mut parts.edges[edge].tolerance;
                *known = known.max(distance);
            }
            Flaw::End { vertex, distance, .. } if distance <= near => {
                let known = &mut parts.vertices[vertex].tolerance;
                *known = known.max(distance);
            }
            _ => {}
        }
    }
    let open = join::open(&parts);
    let hint = hint::find(&given, &parts, &open, near)?;
    let brep = Brep::new(parts)?;
    let flaws = brep.misplaced()?;
    Ok(Sewn {
        brep,
        joined: joined.edges,
        gap: joined.gap,
        cut: joined.cut,
        short: healed.short,
        longest: healed.longest,
        twice: joined.twice,
        inverted: healed.inverted,
        turned: turned.len(),
        open,
        next: hint.next,
        closes: hint.closes,
        one_sided: groups.iter().filter(|group| !group.sided).count(),
        unknown,
        flaws,
    })
}

/// Makes solids of the shells that close, whose faces are turned to look out of them. Of how many it could not be told which side is outside.
fn close(
    parts: &mut Parts,
    groups: &[Group],
    turned: &mut BTreeSet<usize>,
    (near, tessellator): (f64, &dyn Tessellator),
) -> Result<usize> {
    let open = Brep::new(parts.clone())?;
    let closes = |group: &Group| group.closed && group.sided && open.is_closed(&group.faces);
    let closed = groups.iter().filter(|group| closes(group)).count();
    if closed == 0 {
        return Ok(0);
    }
    let mut found = None;
    for chord in CHORDS {
        let fineness = Fineness { chord: Chord::Relative(chord), angle: 0.5 };
        if let Ok(cut) = tessellator.measured_brep(&open, &fineness) {
            let is_whole = cut.left_out.is_empty();
            found = Some(cut);
            if is_whole {
                break;
            }
        }
    }
    let Some(cut) = found else { return Ok(closed) };
    let mut shell_of = vec![0; parts.faces.len()];
    for (shell, group) in groups.iter().enumerate() {
        group.faces.iter().for_each(|&face| shell_of[face] = shell);
    }
    let mut is_whole = vec![true; groups.len()];
    cut.left_out.iter().for_each(|(face, _)| is_whole[shell_of[*face]] = false);
    let all = Hull::all(&cut.mesh, &cut.faces, groups.len(), |face| shell_of[face]);
    let hulls: Vec<(usize, Hull)> = all
        .into_iter()
        .enumerate()
        .filter(|(shell, hull)| closes(&groups[*shell]) && is_whole[*shell] && hull.is_thicker_than(near))
        .collect();
    // Those that each lies within, from the one around it on: as they are nested, the more the deeper.
    let around: Vec<Vec<usize>> = hulls
        .iter()
        .map(|(_, hull)| (0..hulls.len()).filter(|&k| hull.is_within(&hulls[k].1)).collect())
        .collect();
    let depth = |k: usize| around[k].iter().filter(|&&other| other != k).count();
    let mut solid_of = BTreeMap::new();
    for (k, (shell, hull)) in hulls.iter().enumerate() {
        let is_hollow = depth(k) % 2 == 1;
        if (hull.volume < 0.0) != is_hollow {
            for &face in &groups[*shell].faces {
                sides::turn(parts, face);
                if !turned.remove(&face) {
                    turned.insert(face);
                }
            }
        }
        if !is_hollow {
            solid_of.insert(k, parts.solids.len());
            parts.solids.push(Solid { name: None, outer: *shell, voids: Vec::new() });
        }
    }
    for (k, (shell, _)) in hulls.iter().enumerate().filter(|(k, _)| depth(*k) % 2 == 1) {
        let mut outside = around[k].iter().filter(|&&other| other != k);
        if let Some(solid) =
            outside.find(|&&other| depth(other) + 1 == depth(k)).and_then(|k| solid_of.get(k))
        {
            parts.solids[*solid].voids.push(*shell);
        }
    }
    Ok(closed - hulls.len())
}
