//! Meshes: vertices once, texture vertices and normals with their own indices.

use std::fmt::Write as _;
use std::io::Write;

use loftsman_kernel::mesh::color::to_srgb;
use loftsman_kernel::mesh::{Mesh, NONE};
use loftsman_kernel::plugin::FormatError;

use super::state::Changes;
use super::{Writer, print};

impl<W: Write> Writer<'_, W> {
    /// A mesh whose slots have these looks.
    pub(super) fn mesh(&mut self, mesh: &Mesh, looks: &[Option<String>]) -> Result<(), FormatError> {
        let point = self.colored_vertices(mesh)?;
        let (uv, normal) = (self.written.uvs + 1, self.written.normals + 1);
        for uv in mesh.uvs.values() {
            self.statement("vt", *uv)?;
        }
        self.written.uvs += mesh.uvs.values().len();
        for n in mesh.normals.values() {
            self.statement("vn", n.iter().copied())?;
        }
        self.written.normals += mesh.normals.values().len();
        // Where smoothing groups say what is smooth, nothing is added.
        let silent = mesh.normals.is_empty() && mesh.smoothing.is_empty() && mesh.face_count() > 0;
        let give_normals = self.face_normals && silent;
        self.notes.given_normals += usize::from(give_normals);
        if give_normals {
            self.line("# Loftsman normals")?;
        }
        if mesh.groups.is_empty() {
            self.ungroup()?;
        }
        let mut changes = Changes::new(&mesh.groups);
        for (f, (face, pair)) in mesh.faces().zip(mesh.starts().windows(2)).enumerate() {
            if !mesh.groups.is_empty()
                && let Some(active) = changes.at(f as u32)
            {
                self.text.push('g');
                for &group in active {
                    _ = write!(self.text, " {}", print::group(&mesh.groups[group].name));
                }
                if active.is_empty() {
                    self.text.push_str(" default");
                }
                self.state.groups = !active.is_empty();
                self.flush_line()?;
            } else if f == 0 {
                self.ungroup()?;
            }
            let slot = mesh.materials.get(f).copied().unwrap_or(0) as usize;
            self.use_look(looks.get(slot))?;
            self.smooth(mesh.smoothing.get(f).copied(), f == 0 && !mesh.smoothing.is_empty())?;
            let given = if give_normals { mesh.face_normal(f) } else { None };
            if let Some(normal) = given {
                self.statement("vn", normal.iter().copied())?;
                self.written.normals += 1;
            }
            self.text.push('f');
            for (&p, corner) in face.iter().zip(pair[0]..) {
                _ = write!(self.text, " {}", point + p as usize);
                let t = mesh.uvs.index(corner, p);
                let n = match (given, mesh.normals.index(corner, p)) {
                    (Some(_), _) => Some(self.written.normals),
                    (None, NONE) => None,
                    (None, index) => Some(normal + index as usize),
                };
                _ = match (t, n) {
                    (NONE, None) => Ok(()),
                    (NONE, Some(n)) => write!(self.text, "//{n}"),
                    (t, None) => write!(self.text, "/{}", uv + t as usize),
                    (t, Some(n)) => write!(self.text, "/{}/{n}", uv + t as usize),
                };
            }
            self.flush_line()?;
        }
        if mesh.lines().next().is_some() || mesh.face_count() == 0 {
            self.ungroup()?;
            self.use_look(looks.first())?;
        }
        if mesh.face_count() == 0 && mesh.lines().next().is_none() {
            for p in 0..mesh.points().len() {
                _ = write!(self.text, "p {}", point + p);
                self.flush_line()?;
            }
        }
        for line in mesh.lines() {
            for pair in line.windows(2) {
                _ = write!(self.text, "l {} {}", point + pair[0] as usize, point + pair[1] as usize);
                self.flush_line()?;
            }
        }
        Ok(())
    }

    /// `s`, where it changes; said once where a mesh speaks of smoothing at all.
    fn smooth(&mut self, group: Option<u32>, say: bool) -> std::io::Result<()> {
        let group = group.unwrap_or(0);
        if !say && group == self.state.smoothing {
            return Ok(());
        }
        self.state.smoothing = group;
        let line = if group == 0 { "s off".to_owned() } else { format!("s {group}") };
        self.line(&line)
    }

    /// The vertices with their colours: OBJ has one a vertex, that of the first corner there.
    fn colored_vertices(&mut self, mesh: &Mesh) -> Result<usize, FormatError> {
        if mesh.colors.is_empty() {
            return self.vertices(mesh.points(), None);
        }
        let mut colors = vec![NONE; mesh.points().len()];
        let values = mesh.colors.values();
        for (corner, &p) in mesh.corners().iter().enumerate() {
            let slot = &mut colors[p as usize];
            if *slot == NONE {
                *slot = mesh.colors.index(corner, p);
            }
        }
        if mesh.colors.corners().is_none() {
            (0..).zip(&mut colors).for_each(|(p, slot)| *slot = p);
        }
        let first = self.written.points + 1;
        for (p, &color) in mesh.points().iter().zip(&colors) {
            let color = values.get(color as usize);
            // Vertex colours of OBJ files are taken for sRGB.
            let shown = color.map(|&[r, g, b, alpha]| ([r, g, b].map(to_srgb), alpha));
            let alpha = shown.map(|(_, alpha)| alpha).filter(|alpha| *alpha != 1.0);
            let rgb = shown.into_iter().flat_map(|(rgb, _)| rgb);
            self.statement("v", p.iter().copied().chain(rgb).chain(alpha))?;
        }
        self.written.points += colors.len();
        Ok(first)
    }
}
