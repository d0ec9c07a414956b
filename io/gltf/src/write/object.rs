//! One object: what of it is to be seen, exactly or tessellated, and as what it goes into the document.

use std::borrow::Cow;

use loftsman_kernel::brep::Brep;
use loftsman_kernel::mesh::Mesh;
use loftsman_kernel::placement::Change;
use loftsman_kernel::placement::transform_point;
use loftsman_kernel::plugin::{
    Beside, Chord, CustomShape, Drawn, Fineness, FormatError, MovingLine, MovingMesh, Tessellated,
    TessellatedBrep, Written,
};
use loftsman_kernel::scene::{Animation, Geometry, Object};
use loftsman_kernel::shape::Shape;
use loftsman_kernel::text::a;
use loftsman_kernel::{Error, Point};
use nalgebra::Matrix4;
use serde_json::{Value, json};

use super::animation::{self, Moves};
use super::left_out::{UNSEEN, cut, untold};
use super::shape::{self, LINE_STRIP, NORMAL, POINTS, Shaped, TRIANGLES};
use super::{Writer, mesh, schema};
use crate::extras::{AnimationFields, ExtrasFields, Loose};
use crate::words::{MATERIAL, MESH_DATA, MESH_NAME, NONE, TARGET_NAMES, UNNAMED, frame_name};

/// What is to be seen of an object.
pub(super) enum Shown<'a> {
    /// Nothing: a group, or what is left out.
    Nothing,
    /// Nothing, but its exact spline is in extras.
    Unseen(Box<ExtrasFields>),
    /// A shape, its frames, and what is noted beside it.
    Shaped(Box<Shaped>, Option<Moves<'a>>, Box<ExtrasFields>),
}

impl<'a> Writer<'a, '_> {
    /// What to show of an object, moved by `rest`; how it moves; and its exact spline. `stretch` is how much its
    /// transforms may stretch a length.
    pub(super) fn shape(
        &mut self,
        object: &'a Object,
        rest: &Matrix4<f64>,
        stretch: f64,
        report: &mut Written,
    ) -> Result<Shown<'a>, FormatError> {
        let mesh_like = match object.geometry() {
            Geometry::Custom(custom) => match custom.shape() {
                Ok(shape) => shape.domain().len() == 2,
                Err(unknown) => return nothing(report, unknown.to_string()),
            },
            Geometry::Group | Geometry::Mesh(_) => true,
            Geometry::Surface(_) | Geometry::Trimmed(_) | Geometry::Brep(_) => true,
            _ => false,
        };
        if self.meshes_only && !mesh_like {
            return nothing(report, "only meshes were asked for");
        }
        // Shapes that are baked are in the file's coordinates already; others change as they are poured.
        let baked = *rest != Matrix4::identity();
        let total = rest * self.change.map();
        let (geometry, change) = if baked {
            (Cow::Owned(object.geometry().transformed(&total)?), Change::none())
        } else {
            (Cow::Borrowed(object.geometry()), self.change)
        };
        let frames = object.animation.as_ref().map(|animation| {
            if baked {
                let frame = |f: &Vec<Point>| f.iter().map(|p| transform_point(&total, p)).collect();
                Cow::Owned(Animation {
                    rate: animation.rate,
                    frames: animation.frames.iter().map(frame).collect(),
                })
            } else {
                Cow::Borrowed(animation)
            }
        });
        let frames = frames.filter(|f| !f.frames.is_empty());
        let frames = match frames {
            Some(frames) if frames.frames.len() > animation::LARGEST => {
                let reason = format!(
                    "its animation of {} frames was left out: glTF needs the square of their number, at most {} are written",
                    frames.frames.len(),
                    animation::LARGEST
                );
                report.change(&reason);
                None
            }
            frames => frames,
        };
        let (fineness, chord) = (self.fineness(object, stretch, baked), self.options.fineness.chord);
        let in_scene = stretch / if baked { self.change.scale * self.grown } else { self.grown };
        if let Geometry::Custom(custom) = geometry.as_ref() {
            return self.custom(object, (custom, &fineness), change, (rest, in_scene), frames, report);
        }
        let Some(tessellator) = self.options.tessellator else {
            if matches!(object.geometry(), Geometry::Curve(_) | Geometry::Surface(_) | Geometry::Trimmed(_)) {
                let reason = "splines need a tessellator, and none is registered".to_owned();
                return Ok(self.unseen(object, &reason, report));
            }
            if matches!(object.geometry(), Geometry::Brep(_)) {
                return nothing(report, "breps need a tessellator, and none is registered");
            }
            return self.plain(object, geometry, change, frames, report);
        };
        // What has no extent is there all the same; what cannot be cut finely enough is refused.
        let seen = |e: Error| match e {
            Error::NoExtent(problem) => Ok(problem),
            e => Err(FormatError::whole(format!("it could not be tessellated: {e}"))),
        };
        match geometry.as_ref() {
            Geometry::Curve(curve) => {
                let (states, from_first) = animation::states(curve.control_vertices(), frames.as_deref());
                let states = animation::curves(curve, &states)?;
                let line = match tessellator.moving_curve(&states, &fineness) {
                    Ok(line) if line.states.iter().any(|points| points.len() >= 2) => line,
                    Ok(_) => return Ok(self.unseen(object, "the curve has no extent", report)),
                    Err(e) => return Ok(self.unseen(object, &seen(e)?, report)),
                };
                let MovingLine { states, starts, closed, tolerance, error, .. } = line;
                let points = states.first().cloned().unwrap_or_default();
                report.cut(chord.length(tolerance * in_scene), Some(error * in_scene));
                report.change("the curve became segments; the exact one is in extras");
                let moves = frames.map(|frames| Moves::of(states, from_first, frames.rate));
                let shaped = shape::chains(&points, &starts, closed, change, &mut self.bin)?;
                Ok(self.exact(object, shaped, &points, moves))
            }
            Geometry::Surface(surface) => {
                let (states, from_first) = animation::states(surface.control_vertices(), frames.as_deref());
                let states = animation::surfaces(surface, &states)?;
                let beside = self.beside(object).filter(|_| frames.is_none() && !baked);
                let found = match &beside {
                    Some((points, near)) => {
                        let beside = Beside { points, near: *near };
                        let cut = tessellator.measured_surface_beside(surface, &fineness, beside);
                        cut.map(|Tessellated { mesh, tolerance, error }| {
                            let states = vec![mesh.points().to_vec()];
                            MovingMesh { mesh, states, tolerance, error }
                        })
                    }
                    None => tessellator.moving_surface(&states, &fineness),
                };
                let found = match found {
                    Ok(found) => found,
                    Err(e) => return Ok(self.unseen(object, &seen(e)?, report)),
                };
                let MovingMesh { mesh, states, tolerance, error } = found;
                report.cut(chord.length(tolerance * in_scene), Some(error * in_scene));
                report.change("the surface became triangles; the exact one is in extras");
                let moves = frames.map(|frames| Moves::of(states, from_first, frames.rate));
                self.spline_mesh(object, mesh, (rest, change), moves, report)
            }
            Geometry::Trimmed(trimmed) => {
                let Tessellated { mesh, tolerance, error } =
                    match tessellator.measured_trimmed(trimmed, &fineness) {
                        Ok(found) => found,
                        Err(e) => return Ok(self.unseen(object, &untold(&e), report)),
                    };
                report.cut(chord.length(tolerance * in_scene), Some(error * in_scene));
                report.change("the trimmed surface became triangles; the exact one is in extras");
                if frames.is_some() {
                    report.change("it stands still for other programs: its frames are in extras");
                }
                self.spline_mesh(object, mesh, (rest, change), None, report)
            }
            Geometry::Brep(brep) => {
                let found = match tessellator.measured_brep(brep, &fineness) {
                    Ok(found) => found,
                    Err(e) => return nothing(report, untold(&e)),
                };
                report.cut(chord.length(found.tolerance * in_scene), Some(found.error * in_scene));
                report.change("the brep became triangles");
                let remarks = found.remark(brep).into_iter().chain(found.excess(in_scene));
                remarks.for_each(|remark| report.change(&remark));
                if frames.is_some() {
                    report.change("its frames were left out");
                }
                self.brep_mesh(object, brep, found, change, report)
            }
            _ => self.plain(object, geometry, change, frames, report),
        }
    }

    /// A plug-in's shape: what its kind draws of it, and its fields beside that.
    fn custom(
        &mut self,
        object: &Object,
        (custom, fineness): (&CustomShape, &Fineness),
        change: Change,
        (rest, in_scene): (&Matrix4<f64>, f64),
        frames: Option<Cow<'a, Animation>>,
        report: &mut Written,
    ) -> Result<Shown<'a>, FormatError> {
        let own = custom.points();
        let (states, from_first) = animation::states(own, frames.as_deref());
        let found = match frames {
            Some(_) => {
                let states: Vec<Vec<Point>> = states.into_iter().map(<[Point]>::to_vec).collect();
                custom.tessellate_frames(&states, fineness)
            }
            None => custom.tessellate(fineness),
        };
        let found = match found {
            Ok(found) => found,
            Err(Error::NoExtent(problem)) => return Ok(self.unseen(object, &problem, report)),
            Err(e) => return Err(FormatError::whole(format!("it could not be tessellated: {e}"))),
        };
        let reason =
            format!("the {} became {}; its own fields are in extras", custom.kind(), found.drawn.what());
        report.change(&reason);
        let remark = found.remark(in_scene);
        let error = remark.is_none().then_some(found.error * in_scene);
        report.cut(self.options.fineness.chord.length(found.tolerance * in_scene), error);
        remark.iter().for_each(|remark| report.change(remark));
        let moves = frames.map(|frames| Moves::of(found.states, from_first, frames.rate));
        match found.drawn {
            Drawn::Line(line) if line.points.len() < 2 => Ok(self.unseen(object, "it has no extent", report)),
            Drawn::Line(line) => {
                let shaped = shape::chains(&line.points, &[0], line.closed, change, &mut self.bin)?;
                Ok(self.exact(object, shaped, &line.points, moves))
            }
            Drawn::Mesh(mesh) => self.spline_mesh(object, mesh, (rest, change), moves, report),
        }
    }

    /// A spline that cannot be shown: it goes out in extras alone, for our own reader.
    fn unseen(&self, object: &Object, reason: &str, report: &mut Written) -> Shown<'a> {
        if self.meshes_only {
            report.leave_out(reason);
            return Shown::Nothing;
        }
        report.form = "node".to_owned();
        let reason = format!("{reason}: other programs see nothing of it; the exact one is in extras");
        report.change(&reason);
        let mut own = ExtrasFields::of(object.geometry());
        own.animation = object.animation.as_ref().map(AnimationFields::of);
        Shown::Unseen(Box::new(own))
    }

    fn spline_mesh(
        &mut self,
        object: &Object,
        mut mesh: Mesh,
        (rest, change): (&Matrix4<f64>, Change),
        moves: Option<Moves<'a>>,
        report: &mut Written,
    ) -> Result<Shown<'a>, FormatError> {
        // A surface's normal is mirrored inward, a mesh's stays outside.
        if rest.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            mesh.turn_inside_out();
        }
        let points = mesh.points().to_vec();
        let maps = self.materials.normal_maps(&object.materials);
        match mesh::mesh(Cow::Owned(mesh), change, self.meshes_only, &maps, moves.is_some(), &mut self.bin)? {
            Some(shaped) => Ok(self.exact(object, shaped, &points, moves)),
            None => Ok(self.unseen(object, "it has no triangle of any extent", report)),
        }
    }

    /// The triangles of a Brep, faces that have colours of their own as primitives of their own.
    fn brep_mesh(
        &mut self,
        object: &Object,
        brep: &Brep,
        found: TessellatedBrep,
        change: Change,
        report: &mut Written,
    ) -> Result<Shown<'a>, FormatError> {
        let (colors, slots) = found.colors(brep);
        let mut mesh = found.mesh;
        // -0 becomes 0: as a mesh it is read and written again so.
        mesh.points_mut().iter_mut().flat_map(|p| p.iter_mut()).for_each(|x| *x += 0.0);
        mesh.normals.values_mut().iter_mut().flat_map(|n| n.iter_mut()).for_each(|x| *x += 0.0);
        if colors.len() > 1 {
            mesh.materials = slots;
        }
        // Where a face has a colour, that stands for the object's material.
        let maps = self.materials.normal_maps(object.materials.get(..1).unwrap_or_default());
        match mesh::mesh(Cow::Owned(mesh), change, self.meshes_only, &maps, false, &mut self.bin)? {
            Some(shaped) => {
                let shaped = Shaped { paints: colors, ..shaped };
                Ok(Shown::Shaped(Box::new(shaped), None, Box::default()))
            }
            None => nothing(report, UNSEEN),
        }
    }

    /// A shape with the exact spline that it shows.
    fn exact(
        &self,
        object: &Object,
        shaped: Shaped,
        points: &[Point],
        moves: Option<Moves<'a>>,
    ) -> Shown<'a> {
        let mut own = ExtrasFields::of(object.geometry());
        own.shown_by = Some(shape::shown_by(points, &shaped.frame));
        own.starts_at_first = moves.as_ref().is_some_and(Moves::starts_elsewhere);
        own.animation = object.animation.as_ref().map(AnimationFields::of);
        Shown::Shaped(Box::new(shaped), moves, Box::new(own))
    }

    /// What needs no tessellator.
    fn plain(
        &mut self,
        object: &Object,
        geometry: Cow<'a, Geometry>,
        change: Change,
        frames: Option<Cow<'a, Animation>>,
        report: &mut Written,
    ) -> Result<Shown<'a>, FormatError> {
        // Only what moves is looked at again.
        let base = if frames.is_some() { geometry.points().to_vec() } else { Vec::new() };
        let maps = self.materials.normal_maps(&object.materials);
        let shaped = match geometry {
            Cow::Borrowed(Geometry::Group) | Cow::Owned(Geometry::Group) => {
                report.form = "node".to_owned();
                return Ok(Shown::Nothing);
            }
            Cow::Borrowed(Geometry::Polyline(line)) if line.points.len() >= 2 => shape::chain(
                Cow::Borrowed(line.points.as_slice()),
                LINE_STRIP,
                line.closed,
                change,
                &mut self.bin,
            )?,
            Cow::Owned(Geometry::Polyline(line)) if line.points.len() >= 2 => {
                shape::chain(Cow::Owned(line.points), LINE_STRIP, line.closed, change, &mut self.bin)?
            }
            Cow::Borrowed(Geometry::Cloud(cloud)) if !cloud.points.is_empty() => {
                shape::chain(Cow::Borrowed(cloud.points.as_slice()), POINTS, false, change, &mut self.bin)?
            }
            Cow::Owned(Geometry::Cloud(cloud)) if !cloud.points.is_empty() => {
                shape::chain(Cow::Owned(cloud.points), POINTS, false, change, &mut self.bin)?
            }
            Cow::Borrowed(Geometry::Mesh(mesh)) => {
                cut(mesh, report);
                match mesh::mesh(
                    Cow::Borrowed(mesh),
                    change,
                    self.meshes_only,
                    &maps,
                    frames.is_some(),
                    &mut self.bin,
                )? {
                    Some(shaped) => shaped,
                    None => return nothing(report, UNSEEN),
                }
            }
            Cow::Owned(Geometry::Mesh(mesh)) => {
                cut(&mesh, report);
                match mesh::mesh(
                    Cow::Owned(mesh),
                    change,
                    self.meshes_only,
                    &maps,
                    frames.is_some(),
                    &mut self.bin,
                )? {
                    Some(shaped) => shaped,
                    None => return nothing(report, UNSEEN),
                }
            }
            other => {
                let reason = match other.as_ref() {
                    Geometry::Polyline(_) => "a line needs two points".to_owned(),
                    Geometry::Cloud(_) => "it has no points".to_owned(),
                    other => {
                        format!("{} cannot be tessellated yet: convert it to a mesh first", a(&other.noun()))
                    }
                };
                return nothing(report, reason);
            }
        };
        let moves = frames.map(|frames| Moves::new(base, frames));
        let starts = moves.as_ref().is_some_and(Moves::starts_elsewhere);
        let modes = || shaped.primitives.iter().map(|primitive| primitive.mode);
        let loose = if modes().all(|mode| mode == POINTS) {
            Some(Loose::Points)
        } else if modes().all(|mode| mode != TRIANGLES) {
            Some(Loose::Lines)
        } else {
            None
        };
        let own = ExtrasFields { starts_at_first: starts, loose, ..ExtrasFields::default() };
        Ok(Shown::Shaped(Box::new(shaped), moves, Box::new(own)))
    }

    /// Puts a shape into the document as a mesh.
    pub(super) fn mesh(
        &mut self,
        index: usize,
        object: &'a Object,
        mut shaped: Shaped,
        moves: Option<Moves<'a>>,
        noted: &mut ExtrasFields,
        report: &mut Written,
    ) -> Result<usize, FormatError> {
        // What has colours of vertices and no material in the file that it comes from has none here, unless it was given a colour since.
        let is_bare = object.materials.is_empty()
            && object.statement(MATERIAL) == Some(NONE)
            && self.scene.color_of(object).is_none();
        for (primitive, &(slot, sets)) in shaped.primitives.iter_mut().zip(&shaped.slots) {
            if let Some(paint @ Some(_)) = shaped.paints.get(slot as usize) {
                primitive.material = self.materials.color(*paint, shaped.has_colors);
                continue;
            }
            let named = object.materials.get(slot as usize);
            if is_bare || named.is_some_and(|name| self.materials.is_unsaid(name)) {
                continue;
            }
            let found = named.and_then(|name| self.materials.named(name, sets, &mut self.bin));
            let made_up = || self.materials.color(self.scene.color_of(object), shaped.has_colors);
            primitive.material = found.or_else(made_up);
        }
        let mut extras =
            object.statement(MESH_DATA).and_then(|text| serde_json::from_str::<Value>(text).ok());
        let mut weights = Vec::new();
        if let Some(moves) = moves {
            let count = moves.count();
            if moves.starts_elsewhere() {
                // What shows no animation shows its start.
                weights = (0..count).map(|k| if k == 0 { 1.0 } else { 0.0 }).collect();
            }
            let targets = moves.targets(&shaped, &mut self.bin)?;
            for primitive in &mut shaped.primitives {
                primitive.targets.clone_from(&targets);
                // What a primitive has not cannot move.
                if !primitive.attributes.contains_key(NORMAL) {
                    primitive.targets.iter_mut().for_each(|target| _ = target.remove(NORMAL));
                }
            }
            let names: Vec<String> = (0..count).map(frame_name).collect();
            match &mut extras {
                Some(Value::Object(fields)) => _ = fields.insert(TARGET_NAMES.to_owned(), json!(names)),
                other => {
                    if other.is_some() {
                        report.change("what other programs noted of its mesh is left out");
                    }
                    *other = Some(json!({ TARGET_NAMES: names }));
                }
            }
            self.keys.add(index, count, moves.rate(), &mut self.bin)?;
            if noted.animation.is_none() {
                noted.rate = Some(moves.rate());
            }
        }
        noted.made_tangents = shaped.made_tangents;
        report.form.clone_from(&shaped.form);
        for remark in &shaped.remarks {
            report.change(remark);
        }
        let called = match object.statement(UNNAMED) {
            // A mesh without a name, of a node without one.
            Some(name) if name == object.label() => "",
            _ => object.label(),
        };
        self.meshes.push(schema::Mesh {
            name: object.statement(MESH_NAME).unwrap_or(called).to_owned(),
            primitives: shaped.primitives,
            weights,
            extras,
        });
        Ok(self.meshes.len() - 1)
    }

    /// What is beside the border of a surface, in its own coordinates, where it hangs together with something that is so as points only.
    pub(super) fn beside(&self, object: &Object) -> Option<(Vec<Point>, f64)> {
        self.cuts.beside_in_its_own(self.scene.position(object.name())?)
    }

    /// The fineness in the coordinates in which a shape is tessellated.
    pub(super) fn fineness(&self, object: &Object, stretch: f64, baked: bool) -> Fineness {
        let index = self.scene.position(object.name()).unwrap_or(usize::MAX);
        let mut fineness = self.cuts.of(index);
        if let Chord::Absolute(length) = &mut fineness.chord {
            if baked {
                *length *= self.change.scale;
            }
            if stretch > 0.0 {
                *length /= stretch;
            }
        }
        fineness
    }
}

/// Leaves an object out, and says why.
fn nothing<'a>(report: &mut Written, reason: impl Into<String>) -> Result<Shown<'a>, FormatError> {
    report.leave_out(reason);
    Ok(Shown::Nothing)
}
