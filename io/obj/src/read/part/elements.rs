//! What elements name: the vertices, textures and normals of faces, lines and points.

use loftsman_kernel::mesh::NONE;
use loftsman_kernel::text::counted;

use super::Parser;
use crate::number::{index, resolve};
use crate::text::{show, tokens};

impl Parser<'_, '_> {
    /// `f v/vt/vn …`.
    pub(super) fn face(&mut self, rest: &[u8]) -> Result<(), String> {
        let out = &self.out;
        let before = [out.corners.len(), out.textures.len(), out.normals.len()];
        let made = self.corners(rest).and_then(|()| match self.out.corners.len() - before[0] {
            corners @ 0..3 => {
                Err(format!("a face has {}: at least 3 are needed", counted(corners, "corner[|s]")))
            }
            _ => Ok(()),
        });
        let out = &mut self.out;
        if made.is_err() {
            out.corners.truncate(before[0]);
            out.textures.truncate(before[1]);
            out.normals.truncate(before[2]);
        } else {
            out.ends.push(out.corners.len() as u32);
        }
        made
    }

    /// Appends the corners of a face.
    pub(super) fn corners(&mut self, mut rest: &[u8]) -> Result<(), String> {
        let (out, total) = (&mut self.out, self.total);
        loop {
            rest = rest.trim_ascii_start();
            if rest.is_empty() || rest[0] == b'#' {
                return Ok(());
            }
            let corner = rest;
            let wrong = |what: &str| {
                let end = corner.iter().position(u8::is_ascii_whitespace).unwrap_or(corner.len());
                format!("\"{}\" is not the number of a {what}", show(&corner[..end]))
            };
            let vertex = index(&mut rest).ok_or_else(|| wrong("vertex"))?;
            let vertex = resolve(vertex, self.before.points + self.here.points, "vertex")?;
            out.corners.push(there(vertex, total.points, "vertex")?);
            if let [b'/', after @ ..] = rest {
                rest = after;
                if !matches!(rest, [] | [b'/', ..]) && !rest[0].is_ascii_whitespace() {
                    let texture = index(&mut rest).ok_or_else(|| wrong("texture vertex"))?;
                    let texture = resolve(texture, self.before.uvs + self.here.uvs, "texture vertex")?;
                    out.textures.resize(out.corners.len() - 1, NONE);
                    out.textures.push(there(texture, total.uvs, "texture vertex")?);
                }
            }
            if let [b'/', after @ ..] = rest {
                rest = after;
                if rest.first().is_some_and(|b| !b.is_ascii_whitespace()) {
                    let normal = index(&mut rest).ok_or_else(|| wrong("normal"))?;
                    let normal = resolve(normal, self.before.normals + self.here.normals, "normal")?;
                    out.normals.resize(out.corners.len() - 1, NONE);
                    out.normals.push(there(normal, total.normals, "normal")?);
                }
            }
            match rest.first() {
                None => {}
                Some(b) if b.is_ascii_whitespace() => {}
                Some(b'/') => return Err("a corner has more than vertex/texture/normal".to_owned()),
                Some(_) => return Err(wrong("vertex")),
            }
        }
    }

    /// `l v/vt …`.
    pub(super) fn chain(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut chains = std::mem::take(&mut self.out.chains);
        let before = chains.len();
        let made = self.vertices(rest, &mut chains).and_then(|textured| match chains.len() - before {
            vertices @ 0..2 => Err(format!("a line has {vertices} vertex: at least 2 are needed")),
            _ => Ok(textured),
        });
        chains.truncate(if made.is_ok() { chains.len() } else { before });
        self.out.chains = chains;
        self.out.line_textures += usize::from(made?);
        self.out.chain_ends.push(self.out.chains.len() as u32);
        Ok(())
    }

    /// `p v …`.
    pub(super) fn dots(&mut self, rest: &[u8]) -> Result<(), String> {
        let mut dots = std::mem::take(&mut self.out.dots);
        let before = dots.len();
        let made = self.vertices(rest, &mut dots).and_then(|_| match dots.len() - before {
            0 => Err("a point statement has no vertex".to_owned()),
            _ => Ok(()),
        });
        dots.truncate(if made.is_ok() { dots.len() } else { before });
        self.out.dots = dots;
        made?;
        self.out.dot_ends.push(self.out.dots.len() as u32);
        Ok(())
    }

    /// Appends vertices, and says whether any had a texture vertex.
    pub(super) fn vertices(&self, rest: &[u8], out: &mut Vec<u32>) -> Result<bool, String> {
        let mut textured = false;
        for word in tokens(rest) {
            let mut parts = word.split(|&b| b == b'/');
            let part = parts.next().unwrap_or_default();
            let vertex = crate::number::entry(part, self.before.points + self.here.points, "vertex")?;
            out.push(there(vertex, self.total.points, "vertex")?);
            // Texture vertices of lines are left out, whether they exist or not.
            if let Some(part) = parts.next().filter(|part| !part.is_empty()) {
                crate::number::entry(part, self.before.uvs + self.here.uvs, "texture vertex")?;
                textured = true;
            }
            if parts.next().is_some() {
                return Err("a vertex of a line or point has more than vertex/texture".to_owned());
            }
        }
        Ok(textured)
    }
}

/// An entry of a list, if the file has so many.
fn there(entry: u32, count: usize, what: &str) -> Result<u32, String> {
    if (entry as usize) < count {
        return Ok(entry);
    }
    Err(format!("refers to {what} {}, but the file has {count}", u64::from(entry) + 1))
}
