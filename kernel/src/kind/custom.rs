//! A shape of a plug-in together with its kind, or what a document says of one whose plug-in is not here.

use std::sync::Arc;

use super::facets::Faceted;
use super::{DeclaredShape, KindOf, ShapeKind, Splines};
use crate::Point;
use crate::declare::{ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::{Shape, check_shape};
use crate::tessellator::Fineness;
use crate::text::a;

/// A shape of a plug-in, together with its kind: whoever holds it can write, tessellate and draw it. Where the plug-in
/// is not here, what a document says of the shape, word for word.
///
/// Two are equal when they are of one kind and it writes the same of both, or when they are kept with the same words.
#[derive(Debug, Clone)]
pub struct CustomShape(Content);

#[derive(Debug, Clone)]
enum Content {
    Known { kind: Arc<dyn ShapeKind>, shape: Box<dyn Shape> },
    Unknown { kind: String, text: String },
}

impl CustomShape {
    /// A shape of a kind.
    ///
    /// # Errors
    /// When it is not a shape of this kind, or does not hang together (vertices to look at and to move, a domain).
    pub fn new(kind: Arc<dyn ShapeKind>, mut shape: Box<dyn Shape>) -> Result<Self> {
        check_shape(shape.as_mut())?;
        kind.write(shape.as_ref())?;
        Ok(Self(Content::Known { kind, shape }))
    }

    /// The shape of a kind that fields describe.
    ///
    /// # Errors
    /// When a field is unknown, missing or wrong, with its place; when what was read does not hang together.
    pub fn read(kind: &Arc<dyn ShapeKind>, fields: &Parameters) -> Result<Self, ParameterError> {
        let shape = kind.read(fields)?;
        let finite = |shape: &dyn Shape| {
            let mut points = shape.control_vertices().iter().enumerate();
            points.find(|(_, p)| !p.iter().all(|c| c.is_finite())).map(|(index, _)| index)
        };
        if let Some(index) = finite(shape.as_ref()) {
            return Err(fields.error("", format!("control vertex {index} of the shape is not finite")));
        }
        Self::new(Arc::clone(kind), shape).map_err(|defect| fields.error("", defect.to_string()))
    }

    /// What a document says of a shape of a kind whose plug-in is not here: its own text of the whole, kind and all.
    pub fn unknown(kind: impl Into<String>, text: impl Into<String>) -> Self {
        Self(Content::Unknown { kind: kind.into(), text: text.into() })
    }

    /// The kind's name in documents.
    pub fn kind(&self) -> &str {
        match &self.0 {
            Content::Known { kind, .. } => kind.declaration().name,
            Content::Unknown { kind, .. } => kind,
        }
    }

    /// The kind itself, where its plug-in is here.
    pub fn shape_kind(&self) -> Option<&Arc<dyn ShapeKind>> {
        match &self.0 {
            Content::Known { kind, .. } => Some(kind),
            Content::Unknown { .. } => None,
        }
    }

    /// The shape.
    ///
    /// # Errors
    /// [`Error::UnknownKind`] where its plug-in is not here.
    pub fn shape(&self) -> Result<&dyn Shape> {
        self.known().map(|(_, shape)| shape)
    }

    fn known(&self) -> Result<(&dyn ShapeKind, &dyn Shape)> {
        match &self.0 {
            Content::Known { kind, shape } => Ok((kind.as_ref(), shape.as_ref())),
            Content::Unknown { kind, .. } => Err(Error::UnknownKind { kind: kind.clone() }),
        }
    }

    /// What a document says of it, where its plug-in is not here.
    pub fn text(&self) -> Option<&str> {
        match &self.0 {
            Content::Known { .. } => None,
            Content::Unknown { text, .. } => Some(text),
        }
    }

    /// Its fields.
    ///
    /// # Errors
    /// [`Error::UnknownKind`] where its plug-in is not here.
    pub fn fields(&self) -> Result<Parameters> {
        let (kind, shape) = self.known()?;
        kind.write(shape)
    }

    /// Its control vertices; none where its plug-in is not here.
    pub fn points(&self) -> &[Point] {
        self.shape().map_or(&[], |shape| shape.control_vertices())
    }

    /// Another shape of the same kind.
    ///
    /// # Errors
    /// As for [`new`](Self::new); [`Error::UnknownKind`] where its plug-in is not here.
    pub fn with_shape(&self, shape: Box<dyn Shape>) -> Result<Self> {
        match &self.0 {
            Content::Known { kind, .. } => Self::new(Arc::clone(kind), shape),
            Content::Unknown { kind, .. } => Err(Error::UnknownKind { kind: kind.clone() }),
        }
    }

    /// The same shape with other control vertices: as many, and finite.
    ///
    /// # Errors
    /// When they are not; [`Error::UnknownKind`] where its plug-in is not here.
    pub fn with_points(&self, points: &[Point]) -> Result<Self> {
        let mut shape = self.shape()?.boxed();
        if let Some((index, p)) = points.iter().enumerate().find(|(_, p)| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::VertexNotFinite { index, x: p.x, y: p.y, z: p.z });
        }
        let vertices = shape.control_vertices_mut();
        if vertices.len() != points.len() {
            let (found, expected) = (points.len(), vertices.len());
            return Err(Error::Invalid(format!("{found} points for {} of {expected}", a(self.kind()))));
        }
        vertices.copy_from_slice(points);
        self.with_shape(shape)
    }

    /// As segments or triangles.
    ///
    /// # Errors
    /// As for [`ShapeKind::tessellate`]; [`Error::UnknownKind`] where its plug-in is not here.
    pub fn tessellate(&self, fineness: &Fineness) -> Result<Faceted> {
        let (kind, shape) = self.known()?;
        kind.tessellate(&[shape], fineness)?.checked(1)
    }

    /// The same segments or triangles for all of these states of it: frames of an animation, the points of each.
    ///
    /// # Errors
    /// As for [`tessellate`](Self::tessellate) and [`with_points`](Self::with_points); when there are no states.
    pub fn tessellate_frames(&self, frames: &[Vec<Point>], fineness: &Fineness) -> Result<Faceted> {
        let (kind, _) = self.known()?;
        let states = frames.iter().map(|frame| self.with_points(frame)).collect::<Result<Vec<_>>>()?;
        let shapes = states.iter().map(Self::shape).collect::<Result<Vec<_>>>()?;
        kind.tessellate(&shapes, fineness)?.checked(frames.len())
    }

    /// The splines that it is, exactly; `None` where it is none, or its plug-in is not here.
    pub fn splines(&self) -> Option<Splines> {
        let (kind, shape) = self.known().ok()?;
        kind.splines(shape)
    }

    /// The operation that makes splines of it within a tolerance; `None` where there is none, or its plug-in is not here.
    pub fn made_splines_by(&self) -> Option<&'static str> {
        self.known().ok().and_then(|(kind, _)| kind.made_splines_by())
    }

    /// Why a format that knows splines only leaves it out, where it is none exactly: `STEP has no subdivision, and this one is no splines
    /// exactly: the operation "patches" makes some of it`.
    pub fn without_splines(&self, format: &str) -> String {
        let kind = match self.known() {
            Ok((kind, _)) => kind,
            Err(unknown) => return unknown.to_string(),
        };
        let made = kind.made_splines_by().map_or_else(String::new, |operation| {
            format!(": the operation \"{operation}\" makes some of it, within a tolerance")
        });
        format!("{format} has no {}, and this one is no splines exactly{made}", self.kind())
    }
}

impl PartialEq for CustomShape {
    fn eq(&self, other: &Self) -> bool {
        if self.kind() != other.kind() {
            return false;
        }
        match (self.text(), other.text()) {
            (None, None) => {
                let written = |custom: &Self| custom.fields().ok().map(Parameters::into_map);
                written(self).is_some_and(|own| Some(own) == written(other))
            }
            (own, others) => own == others,
        }
    }
}

impl<S: DeclaredShape> From<S> for CustomShape {
    fn from(shape: S) -> Self {
        Self(Content::Known { kind: Arc::new(KindOf::<S>::default()), shape: Box::new(shape) })
    }
}
