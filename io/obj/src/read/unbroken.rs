//! What uses vertices whose own statement is wrong is left out, the rest stays.

use loftsman_kernel::mesh::{FaceGroup, NONE};

use super::reader::Reader;
use super::section::Section;
use crate::number::{index, resolve};
use crate::text::{Statements, keyword, tokens, uncommented};

impl Reader {
    /// Takes faces, lines and points that use a broken vertex out of the sections, and broken texture vertices and
    /// normals off the corners that use them.
    pub(super) fn without_broken(&mut self, text: &[u8]) {
        let [points, uvs, normals] = std::mem::take(&mut self.broken);
        self.broken_counts = [points.len(), uvs.len(), normals.len()];
        let is = |list: &[u32], entry: u32| list.binary_search(&entry).is_ok();
        if !uvs.is_empty() || !normals.is_empty() {
            for section in &mut self.sections {
                section.textures.iter_mut().filter(|t| is(&uvs, **t)).for_each(|t| *t = NONE);
                section.normals.iter_mut().filter(|n| is(&normals, **n)).for_each(|n| *n = NONE);
            }
        }
        if points.is_empty() {
            return;
        }
        let lines = first_users(text, &points, self.raw.points.len());
        let mut lost = [0; 3];
        for section in &mut self.sections {
            lost[0] += section.keep_faces(|face| !face.iter().any(|&v| is(&points, v)));
            lost[1] += section.split_chains(|v| is(&points, v));
            lost[2] += section.drop_dots(|v| is(&points, v));
        }
        self.kept -= lost[0];
        for ((count, line), what) in lost.into_iter().zip(lines).zip([
            "faces with a vertex that is wrong itself",
            "ends and segments of lines with a vertex that is wrong itself",
            "points that are a vertex that is wrong itself",
        ]) {
            match line {
                Some(line) => self.leave_out_at(what, count, line),
                None => self.leave_out(what, count),
            }
        }
    }
}

/// The lines of the first face, the first line and the first point statement that use one of the broken vertices. Lines are not kept for
/// each face, so that the file is looked at again, where it is broken.
fn first_users(text: &[u8], broken: &[u32], total: usize) -> [Option<usize>; 3] {
    let mut found = [None; 3];
    let mut so_far = 0;
    for (line, statement) in Statements::new(text) {
        let (word, rest) = keyword(uncommented(&statement));
        let kind = match word {
            b"v" => {
                so_far += 1;
                continue;
            }
            b"f" | b"fo" => 0,
            b"l" => 1,
            b"p" => 2,
            _ => continue,
        };
        let uses = |mut word: &[u8]| {
            // Positive numbers may be of vertices that are still to come.
            let vertex = index(&mut word)
                .and_then(|number| resolve(number, if number < 0 { so_far } else { total }, "vertex").ok());
            vertex.is_some_and(|vertex| broken.binary_search(&vertex).is_ok())
        };
        if found[kind].is_none() && tokens(rest).any(uses) {
            found[kind] = Some(line);
            if found.iter().all(Option::is_some) {
                break;
            }
        }
    }
    found
}

/// The line of a normal, by its number in the file from 0 on: the file is looked at again, as above.
pub(super) fn line_of_normal(text: &[u8], number: u32) -> Option<usize> {
    let is_normal = |statement: &[u8]| keyword(uncommented(statement)).0 == b"vn";
    let mut normals = Statements::new(text).filter(|(_, statement)| is_normal(statement));
    normals.nth(number as usize).map(|(line, _)| line)
}

impl Section {
    /// Keeps the faces that are right; how many go.
    fn keep_faces(&mut self, is_right: impl Fn(&[u32]) -> bool) -> usize {
        let stays: Vec<bool> = self.starts.windows(2).map(|w| is_right(&self.corners[w[0]..w[1]])).collect();
        let gone = stays.iter().filter(|stays| !**stays).count();
        if gone == 0 {
            return 0;
        }
        let of_corners =
            || self.starts.windows(2).zip(&stays).flat_map(|(w, &stays)| (w[0]..w[1]).map(move |_| stays));
        let pick = |list: &[u32], flags: &mut dyn Iterator<Item = bool>| -> Vec<u32> {
            list.iter().zip(flags).filter(|(_, stays)| *stays).map(|(x, _)| *x).collect()
        };
        let corners = pick(&self.corners, &mut of_corners());
        let textures = pick(&self.textures, &mut of_corners());
        let normals = pick(&self.normals, &mut of_corners());
        (self.corners, self.textures, self.normals) = (corners, textures, normals);
        self.materials = pick(&self.materials, &mut stays.iter().copied());
        self.smoothing = pick(&self.smoothing, &mut stays.iter().copied());
        let mut starts = vec![0];
        let mut place = vec![NONE; stays.len()];
        for (face, pair) in self.starts.windows(2).enumerate().filter(|(face, _)| stays[*face]) {
            place[face] = starts.len() as u32 - 1;
            starts.push(starts.last().copied().unwrap_or(0) + pair[1] - pair[0]);
        }
        self.starts = starts;
        for FaceGroup { faces, .. } in &mut self.groups {
            faces.iter_mut().for_each(|face| *face = place[*face as usize]);
            faces.retain(|&face| face != NONE);
        }
        self.groups.retain(|group| !group.faces.is_empty());
        gone
    }

    /// Cuts chains where a vertex is broken; how many vertices go, with those that are left alone between two.
    fn split_chains(&mut self, is_broken: impl Fn(u32) -> bool) -> usize {
        if !self.chains.iter().any(|&v| is_broken(v)) {
            return 0;
        }
        let (mut chains, mut starts, mut looks) = (Vec::new(), vec![0], Vec::new());
        for (pair, look) in self.chain_starts.windows(2).zip(&self.chain_looks) {
            for piece in self.chains[pair[0]..pair[1]].split(|&v| is_broken(v)).filter(|p| p.len() > 1) {
                chains.extend_from_slice(piece);
                starts.push(chains.len());
                looks.push(*look);
            }
        }
        let gone = self.chains.len() - chains.len();
        (self.chains, self.chain_starts, self.chain_looks) = (chains, starts, looks);
        gone
    }

    /// Drops points that are broken; how many go.
    fn drop_dots(&mut self, is_broken: impl Fn(u32) -> bool) -> usize {
        let before = self.dots.len();
        let mut at = 0;
        let ends: Vec<usize> =
            self.dot_looks.iter().skip(1).map(|(start, _)| *start).chain([before]).collect();
        let mut dots = Vec::with_capacity(before);
        for ((start, _), end) in self.dot_looks.iter_mut().zip(ends) {
            *start = dots.len();
            dots.extend(self.dots[at..end].iter().copied().filter(|&v| !is_broken(v)));
            at = end;
        }
        self.dots = dots;
        before - self.dots.len()
    }
}
