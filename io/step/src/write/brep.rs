//! Breps: solids and shells, faces on what their surfaces are, edges on what their curves are.

use loftsman_kernel::brep::drawn::{self, Drawings, Manner, Pace, is_length, turned};
use loftsman_kernel::brep::{Brep, CurveForm, Frame, SurfaceForm, UsePlace};
use loftsman_kernel::spline::Surface;
use loftsman_kernel::{Point, Result, Vector};

use super::print::{Printer, flag, real, references};
use crate::part21::encode;

/// What was written of a Brep.
pub(crate) struct Written {
    /// Its solids and surface models.
    pub(crate) items: Vec<u64>,
    /// The entity of each face.
    pub(crate) faces: Vec<u64>,
    /// Whether some of them is a solid.
    pub(crate) solid: bool,
    /// What comes back changed.
    pub(crate) changes: Vec<&'static str>,
    /// How near to each other its parts are.
    pub(crate) uncertainty: f64,
}

/// How edges are told in the parameters of faces that meet themselves.
const MANNER: Manner = Manner { conics: true, backs: true };

/// A surface that was written.
pub(super) struct Sheet {
    pub(super) number: u64,
    /// Whether its normal in the file is that of the spline.
    pub(super) same: bool,
    /// Whether it is written as a plane, cylinder, cone, sphere or torus.
    pub(super) elementary: bool,
    /// What was written, where that is a spline.
    pub(super) spline: Option<Surface>,
}

impl Sheet {
    /// What of it says how edges are in its parameters.
    fn drawn(&self) -> drawn::Sheet<'_> {
        drawn::Sheet { same: self.same, elementary: self.elementary, spline: self.spline.as_ref() }
    }
}

fn no_face(number: usize) -> loftsman_kernel::Error {
    loftsman_kernel::Error::Invalid(format!("there is no face {number}"))
}

impl Printer {
    /// All of a Brep, under a name.
    pub(crate) fn brep(&mut self, brep: &Brep, name: &str) -> Result<Written> {
        let mut changes = Vec::new();
        let vertices: Vec<u64> = brep.vertices().iter().map(|p| self.vertex(p)).collect();
        let mut sheets = Vec::with_capacity(brep.face_count());
        for face in 0..brep.face_count() {
            let surface = brep.surface(face).ok_or_else(|| no_face(face))?;
            sheets.push(self.sheet(surface, &brep.surface_form(face))?);
        }
        let mut drawings = Drawings::default();
        for (face, sheet) in sheets.iter().enumerate() {
            drawings.add(brep, face, &sheet.drawn(), MANNER);
        }
        let (mut edges, mut left) = (Vec::with_capacity(brep.edge_count()), false);
        for edge in 0..brep.edge_count() {
            edges.push(self.edge(brep, edge, (&vertices, &sheets, &drawings), &mut left)?);
        }
        if left {
            changes.push("parameter curves that are not at the pace of their edges, or leave their surfaces, are left out");
        }
        if drawings.unsaid {
            changes.push(
                "edges of faces that meet themselves are not told in their parameters, which were not found: others may take the wrong side of a seam",
            );
        }
        let mut faces = Vec::with_capacity(brep.face_count());
        for (face, sheet) in sheets.iter().enumerate() {
            faces.push(self.face(brep, face, sheet, (&vertices, &edges, &drawings))?);
        }
        let mut items = Vec::new();
        let mut in_solid = vec![false; brep.shells().len()];
        let of = |shell: usize| {
            references(&brep.shells()[shell].faces.iter().map(|&f| faces[f]).collect::<Vec<_>>())
        };
        for solid in brep.solids() {
            let called = encode(solid.name.as_deref().filter(|_| brep.solids().len() > 1).unwrap_or(name));
            in_solid[solid.outer] = true;
            // The item has the name of the object, as others show it: the solid's own is that of its shell.
            let own = encode(solid.name.as_deref().unwrap_or_default());
            let outer = self.put(&format!("CLOSED_SHELL({own},{})", of(solid.outer)));
            let mut voids = Vec::new();
            for &void in &solid.voids {
                in_solid[void] = true;
                let shell = self.put(&format!("CLOSED_SHELL('',{})", of(void)));
                voids.push(self.put(&format!("ORIENTED_CLOSED_SHELL('',*,#{shell},.T.)")));
            }
            items.push(if voids.is_empty() {
                self.put(&format!("MANIFOLD_SOLID_BREP({called},#{outer})"))
            } else {
                self.put(&format!("BREP_WITH_VOIDS({called},#{outer},{})", references(&voids)))
            });
        }
        let solid = !items.is_empty();
        let mut shells = Vec::new();
        let mut in_shell = vec![false; brep.face_count()];
        for (number, shell) in brep.shells().iter().enumerate() {
            shell.faces.iter().for_each(|&face| in_shell[face] = true);
            if !in_solid[number] {
                let kind = if brep.is_closed(&shell.faces) { "CLOSED_SHELL" } else { "OPEN_SHELL" };
                shells.push(self.put(&format!("{kind}('',{})", of(number))));
            }
        }
        let alone: Vec<u64> =
            (0..faces.len()).filter(|&face| !in_shell[face]).map(|face| faces[face]).collect();
        if !alone.is_empty() {
            changes.push("its faces without a shell are one");
            shells.push(self.put(&format!("OPEN_SHELL('',{})", references(&alone))));
        }
        if !shells.is_empty() {
            items.push(self.put(&format!(
                "SHELL_BASED_SURFACE_MODEL({},{})",
                encode(name),
                references(&shells)
            )));
        }
        if items.len() > 1 {
            changes.push("its solids and shells are objects of their own");
        }
        let edges = (0..brep.edge_count()).filter_map(|edge| Some(brep.edge(edge)?.tolerance));
        let all: Vec<f64> = brep.tolerances().iter().copied().chain(edges).collect();
        let largest = all.iter().copied().fold(0.0, f64::max);
        if all.iter().any(|tolerance| *tolerance < largest) {
            changes.push("all its tolerances are the largest");
        }
        if largest < drawings.off {
            changes.push("its tolerance is larger, as seams miss the tips of their faces by more");
        }
        let gap = brep.gap()?;
        if largest.max(drawings.off) < gap {
            changes.push("its tolerance is larger, as edges are off their surfaces by more");
        }
        let uncertainty = largest.max(drawings.off).max(gap);
        Ok(Written { items, faces, solid, changes, uncertainty })
    }

    fn vertex(&mut self, p: &Point) -> u64 {
        let point = self.point(p);
        self.put(&format!("VERTEX_POINT('',#{point})"))
    }

    fn edge(
        &mut self,
        brep: &Brep,
        number: usize,
        (vertices, sheets, drawings): (&[u64], &[Sheet], &Drawings),
        left: &mut bool,
    ) -> Result<u64> {
        let Some(edge) = brep.edge(number) else {
            return Err(loftsman_kernel::Error::Invalid(format!("there is no edge {number}")));
        };
        let [start, end] = edge.ends;
        let (from, to) = edge.range;
        let points = [edge.curve.point(from)?, edge.curve.point(to)?];
        // Parameter curves have to be at the pace of the curve that is written.
        let back = drawings.back.contains(&number);
        let pace = Pace::of(&edge, back)?;
        let round = |frame: &Frame| if back { turned(frame) } else { *frame };
        let curve = match edge.form {
            CurveForm::Line if is_length(points) => {
                let [start, end] = if back { [points[1], points[0]] } else { points };
                let origin = self.point(&start);
                let way = end - start;
                let direction = self.direction(&way);
                let vector = self.put(&format!("VECTOR('',#{direction},{})", real(way.norm())));
                self.put(&format!("LINE('',#{origin},#{vector})"))
            }
            CurveForm::Circle { frame, radius } => {
                let placement = self.frame(&round(&frame));
                self.put(&format!("CIRCLE('',#{placement},{})", real(radius)))
            }
            CurveForm::Ellipse { frame, radii: [a, b] } => {
                let placement = self.frame(&round(&frame));
                self.put(&format!("ELLIPSE('',#{placement},{},{})", real(a), real(b)))
            }
            CurveForm::Parabola { frame, focal } => {
                let placement = self.frame(&frame);
                self.put(&format!("PARABOLA('',#{placement},{})", real(focal)))
            }
            CurveForm::Hyperbola { frame, radii: [x, y] } => {
                let placement = self.frame(&frame);
                self.put(&format!("HYPERBOLA('',#{placement},{},{})", real(x), real(y)))
            }
            _ => {
                // On a periodic curve the edge may run through the seam.
                let part =
                    if edge.curve.is_periodic() { edge.curve.between(from, to)? } else { edge.curve.clone() };
                let part = if back { part.reverse()? } else { part };
                self.curve(part.clamped()?.as_ref())
            }
        };
        let curve = self.on_surfaces(brep, number, (sheets, drawings), (curve, pace), left)?;
        let (start, end) = (vertices[start], vertices[end]);
        Ok(self.put(&format!("EDGE_CURVE('',#{start},#{end},#{curve},{})", flag(pace.along()))))
    }

    fn face(
        &mut self,
        brep: &Brep,
        at: usize,
        sheet: &Sheet,
        (vertices, edges, drawings): (&[u64], &[u64], &Drawings),
    ) -> Result<u64> {
        let Some(face) = brep.face(at) else { return Err(no_face(at)) };
        let (surface, same) = (sheet.number, sheet.same);
        let mut bounds = Vec::new();
        for (place, chain) in face.loops.iter().enumerate() {
            // A loop that has a seam starts with it: OpenCASCADE exchanged the sides of seams of a hollow in which a loop started elsewhere.
            let is_seam = |number: usize| {
                let said = drawings.curves.contains_key(&UsePlace { face: at, chain: place, number });
                said && chain.iter().filter(|one| one.edge == chain[number].edge).count() == 2
            };
            let first = (0..chain.len()).find(|&number| is_seam(number)).unwrap_or(0);
            let mut uses = Vec::new();
            for one in chain[first..].iter().chain(&chain[..first]) {
                let along = flag(!one.reversed);
                uses.push(self.put(&format!("ORIENTED_EDGE('',*,*,#{},{along})", edges[one.edge])));
            }
            let chain = self.put(&format!("EDGE_LOOP('',{})", references(&uses)));
            bounds.push(self.put(&format!("FACE_BOUND('',#{chain},.T.)")));
        }
        let mut lone: Vec<u64> = face.points.iter().map(|&vertex| vertices[vertex]).collect();
        if bounds.is_empty() && lone.is_empty() {
            // A face needs a bound: a point of the whole surface.
            let (u, v) = (face.surface.u().domain().0, face.surface.v().domain().0);
            lone.push(self.vertex(&face.surface.point(u, v)?));
        }
        for vertex in lone {
            let chain = self.put(&format!("VERTEX_LOOP('',#{vertex})"));
            bounds.push(self.put(&format!("FACE_BOUND('',#{chain},.T.)")));
        }
        let name = encode(face.name.as_deref().unwrap_or_default());
        let sense = flag(face.reversed != same);
        Ok(self.put(&format!("ADVANCED_FACE({name},{},#{surface},{sense})", references(&bounds))))
    }

    /// A surface as what it is.
    fn sheet(&mut self, surface: Surface, form: &SurfaceForm) -> Result<Sheet> {
        if let Some((number, same)) = self.swept(&surface, form)? {
            return Ok(Sheet { number, same, elementary: false, spline: None });
        }
        let same = same_side(&surface, form)?;
        let written = same.and_then(|_| self.elementary(form));
        match (written, same) {
            (Some(number), Some(same)) => Ok(Sheet { number, same, elementary: true, spline: None }),
            _ => {
                let plain = surface.clamped()?.into_owned();
                Ok(Sheet { number: self.surface(&plain), same: true, elementary: false, spline: Some(plain) })
            }
        }
    }
}

impl Printer {
    /// An elementary surface; `None` of another, and of a torus that cuts itself.
    pub(super) fn elementary(&mut self, form: &SurfaceForm) -> Option<u64> {
        let (frame, kind, sizes) = match *form {
            SurfaceForm::Plane { frame } => (frame, "PLANE", vec![]),
            SurfaceForm::Cylinder { frame, radius } => (frame, "CYLINDRICAL_SURFACE", vec![radius]),
            SurfaceForm::Cone { frame, radius, angle } => (frame, "CONICAL_SURFACE", vec![radius, angle]),
            SurfaceForm::Sphere { frame, radius } => (frame, "SPHERICAL_SURFACE", vec![radius]),
            SurfaceForm::Torus { frame, major, minor } if major > minor => {
                (frame, "TOROIDAL_SURFACE", vec![major, minor])
            }
            _ => return None,
        };
        let placement = self.frame(&frame);
        let sizes: String = sizes.into_iter().map(|size| format!(",{}", real(size))).collect();
        Some(self.put(&format!("{kind}('',#{placement}{sizes})")))
    }
}

/// Whether the normal of a spline points as that of its form does; `None` where the spline is of no form, or has no normal anywhere
/// that was looked.
fn same_side(surface: &Surface, form: &SurfaceForm) -> Result<Option<bool>> {
    let ((a, b), (c, d)) = (surface.u().domain(), surface.v().domain());
    for (s, t) in [(0.37, 0.41), (0.61, 0.53), (0.13, 0.29)] {
        let (u, v) = (a + s * (b - a), c + t * (d - c));
        let normal = surface.derivative(u, v, 1, 0)?.cross(&surface.derivative(u, v, 0, 1)?);
        let p = surface.point(u, v)?;
        let outwards = match form {
            SurfaceForm::Spline | SurfaceForm::Extrusion { .. } | SurfaceForm::Revolution { .. } => {
                return Ok(None);
            }
            SurfaceForm::Plane { frame } => frame.z,
            SurfaceForm::Sphere { frame, .. } => p - frame.origin,
            // A cone's points away from the axis beyond its tip, too.
            SurfaceForm::Cylinder { frame, .. } | SurfaceForm::Cone { frame, .. } => across(frame, p),
            SurfaceForm::Torus { frame, major, .. } => {
                let flat = across(frame, p);
                p - (frame.origin + flat.try_normalize(0.0).unwrap_or(frame.x) * *major)
            }
        };
        let side = normal.dot(&outwards);
        if side != 0.0 && side.is_finite() {
            return Ok(Some(side > 0.0));
        }
    }
    Ok(None)
}

fn across(frame: &Frame, p: Point) -> Vector {
    let d = p - frame.origin;
    d - frame.z * d.dot(&frame.z)
}
