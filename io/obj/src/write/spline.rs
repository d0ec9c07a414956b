//! Curves, surfaces and trimmed surfaces, exactly.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::Write;

use loftsman_kernel::plugin::FormatError;
use loftsman_kernel::spline::trimmed::ParameterCurve;
use loftsman_kernel::spline::{Curve, Space, Surface, Trimmed};

use super::{Knots, Writer, print};

/// A loop or chain with its keyword, and the numbers of its curves.
type Chain<'a> = (&'static str, Vec<(&'a ParameterCurve, usize)>);

/// The loops and special curves of a trimmed surface by their keywords, in the order that OBJ wants: an outer loop, its
/// holes, the next outer loop.
fn chains_of(trimmed: &Trimmed) -> Vec<(&'static str, &[ParameterCurve])> {
    let mut chains = Vec::new();
    for region in trimmed.regions() {
        if !region.outer.is_empty() {
            chains.push(("trim", region.outer.as_slice()));
        }
        chains.extend(region.holes.iter().map(|hole| ("hole", hole.as_slice())));
    }
    chains.extend(trimmed.curves().iter().map(|curve| ("scrv", curve.as_slice())));
    chains
}

impl<W: Write> Writer<'_, W> {
    pub(super) fn curve(&mut self, curve: &Curve) -> Result<(), FormatError> {
        let form =
            if self.knots == Knots::Bezier { Cow::Owned(curve.bezier_form()?) } else { Cow::Borrowed(curve) };
        let space = form.space();
        self.ungroup()?;
        if *form != *curve {
            self.own_knots(curve)?;
        }
        let first = self.vertices(form.points(), form.weights())?;
        self.kind(form.weights().is_some(), &[space.degree()])?;
        let (a, b) = space.domain();
        self.text.push_str("curv");
        print::number(&mut self.text, a);
        print::number(&mut self.text, b);
        // A periodic curve repeats its first control vertices: that is how OBJ closes one.
        for k in 0..space.unrolled_len() {
            _ = write!(self.text, " {}", first + space.vertex(k));
        }
        self.flush_line()?;
        self.parameters("u", space)?;
        Ok(self.line("end")?)
    }

    /// A comment with the curve itself, where another form of it follows.
    fn own_knots(&mut self, curve: &Curve) -> std::io::Result<()> {
        let kind = if curve.is_periodic() { "periodic" } else { "open" };
        _ = write!(self.text, "# Loftsman curve {} {kind}; knots", curve.degree());
        curve.space().knots().iter().for_each(|&t| print::number(&mut self.text, t));
        self.text.push_str("; points");
        curve.points().iter().flat_map(|p| p.iter()).for_each(|&x| print::number(&mut self.text, x));
        if let Some(weights) = curve.weights() {
            self.text.push_str("; weights");
            weights.iter().for_each(|&w| print::number(&mut self.text, w));
        }
        self.flush_line()
    }

    pub(super) fn surface(&mut self, name: &str, surface: &Surface) -> Result<(), FormatError> {
        self.surface_head(name, surface)?;
        Ok(self.line("end")?)
    }

    /// A trimmed surface with its curves.
    pub(super) fn trimmed(&mut self, name: &str, trimmed: &Trimmed) -> Result<(), FormatError> {
        let mut chains: Vec<Chain<'_>> = Vec::new();
        for (keyword, curves) in chains_of(trimmed) {
            let mut numbered = Vec::with_capacity(curves.len());
            for curve in curves {
                numbered.push((curve, self.plane_curve(curve.curve())?));
            }
            chains.push((keyword, numbered));
        }
        let special = self.written.parameters + 1;
        for [u, v] in trimmed.points() {
            self.parameter_vertex(&[*u, *v])?;
        }
        self.surface_head(name, trimmed.surface())?;
        for (keyword, curves) in &chains {
            self.text.push_str(keyword);
            for (curve, number) in curves {
                let (from, to) = curve.range();
                print::number(&mut self.text, from);
                print::number(&mut self.text, to);
                _ = write!(self.text, " {number}");
            }
            self.flush_line()?;
        }
        if !trimmed.points().is_empty() {
            self.text.push_str("sp");
            for k in 0..trimmed.points().len() {
                _ = write!(self.text, " {}", special + k);
            }
            self.flush_line()?;
        }
        Ok(self.line("end")?)
    }

    /// A curve in the parameter plane; its number.
    pub(super) fn plane_curve(&mut self, curve: &Curve) -> Result<usize, FormatError> {
        let first = self.written.parameters + 1;
        for (i, p) in curve.points().iter().enumerate() {
            match curve.weights() {
                Some(weights) => self.parameter_vertex(&[p.x, p.y, weights[i]])?,
                None => self.parameter_vertex(&[p.x, p.y])?,
            }
        }
        let space = curve.space();
        self.kind(curve.weights().is_some(), &[space.degree()])?;
        self.text.push_str("curv2");
        for k in 0..space.unrolled_len() {
            _ = write!(self.text, " {}", first + space.vertex(k));
        }
        self.flush_line()?;
        self.parameters("u", space)?;
        self.line("end")?;
        self.written.plane_curves += 1;
        Ok(self.written.plane_curves)
    }

    fn parameter_vertex(&mut self, numbers: &[f64]) -> std::io::Result<()> {
        self.written.parameters += 1;
        self.statement("vp", numbers.iter().copied())
    }

    fn kind(&mut self, rational: bool, degrees: &[usize]) -> std::io::Result<()> {
        self.line(if rational { "cstype rat bspline" } else { "cstype bspline" })?;
        self.text.push_str("deg");
        degrees.iter().for_each(|p| _ = write!(self.text, " {p}"));
        self.flush_line()
    }

    fn parameters(&mut self, side: &str, space: &Space) -> std::io::Result<()> {
        self.statement(&format!("parm {side}"), space.flat().iter().copied())
    }

    /// A surface up to its knots.
    fn surface_head(&mut self, name: &str, surface: &Surface) -> Result<(), FormatError> {
        self.ungroup()?;
        let first = self.vertices(surface.points(), surface.weights())?;
        let (u, v) = (surface.u(), surface.v());
        self.kind(surface.weights().is_some(), &[u.degree(), v.degree()])?;
        self.text.push_str("surf");
        for space in [u, v] {
            let (a, b) = space.domain();
            print::number(&mut self.text, a);
            print::number(&mut self.text, b);
        }
        // In OBJ the vertices run along u first.
        for j in 0..v.unrolled_len() {
            for i in 0..u.unrolled_len() {
                _ = write!(self.text, " {}", first + u.vertex(i) * v.len() + v.vertex(j));
            }
        }
        self.flush_line()?;
        self.parameters("u", u)?;
        self.parameters("v", v)?;
        self.written.surfaces += 1;
        self.surface_numbers.insert(name.to_owned(), self.written.surfaces);
        Ok(())
    }
}
