//! Shape kinds: the shapes that plug-ins bring, as objects of scenes, documents and recipes.

mod custom;
mod facets;
mod sampled;

use std::any::Any;
use std::fmt;
use std::marker::PhantomData;

use crate::declare::{Declaration, ParameterError, Parameters};
use crate::error::{Error, Result};
use crate::shape::Shape;
use crate::spline::{Curve, Surface};
use crate::tessellator::Fineness;

pub use custom::CustomShape;
pub use facets::{Drawn, Faceted};
pub use sampled::sampled;

#[cfg(test)]
mod tests;

/// A shape of a plug-in that documents and recipes know by name: what a type says once, so that its shapes are objects
/// of scenes. [`Registry::shape`](crate::plugin::Registry::shape) makes a [`ShapeKind`] of it, and it turns into a
/// [`Geometry`](crate::scene::Geometry).
///
/// Its control vertices are points: the coefficients of a position add up to 1, so that a shape whose vertices are
/// moved, turned or scaled is moved, turned and scaled with them.
/// [`kind_conformance`](crate::conformance::kind_conformance) says whether that and all else holds.
pub trait DeclaredShape: Shape + Sized {
    /// Its name in documents, one line of help and the fields that it is written with. `kind` is no field of its own:
    /// it stands beside them.
    const DECLARATION: Declaration;

    /// The operation that makes splines of it, within a tolerance, where it is [none exactly](Self::splines): formats that know splines only
    /// name it where they leave the shape out. `None` (the default) where there is none.
    const MADE_SPLINES_BY: Option<&'static str> = None;

    /// Its fields, with every number that it needs to be made again.
    fn fields(&self) -> Parameters;

    /// The shape that the fields describe. They have been checked against the declaration: all are known, and those
    /// are there that must be.
    ///
    /// # Errors
    /// When a field's value is wrong, with its place ([`Parameters::error`]).
    fn from_parameters(fields: &Parameters) -> Result<Self, ParameterError>;

    /// As segments or triangles, the same ones in all states: frames of an animation, or a single one. By default
    /// [`sampled`]: adaptive, and its error measured in many places, not certified.
    ///
    /// # Errors
    /// As for [`sampled`].
    fn tessellate(states: &[&Self], fineness: &Fineness) -> Result<Faceted> {
        let states: Vec<&dyn Shape> = states.iter().map(|&shape| shape as &dyn Shape).collect();
        sampled(&states, fineness)
    }

    /// The splines that it is, all together and exactly; `None` (the default) where it is none.
    fn splines(&self) -> Option<Splines> {
        None
    }
}

/// What a shape is exactly, in terms that other programs know.
#[derive(Debug, Clone, PartialEq)]
pub enum Splines {
    /// Curves, one after another.
    Curves(Vec<Curve>),
    /// Surfaces side by side.
    Surfaces(Vec<Surface>),
}

/// A kind of shape, as a registry holds it and formats ask it: how shapes of it are written, read, tessellated. Types
/// implement [`DeclaredShape`] and get this for nothing; who has no type of its own implements this.
///
/// Shapes of another kind that are handed over are errors.
pub trait ShapeKind: Send + Sync {
    /// Its name in documents, help and fields.
    fn declaration(&self) -> Declaration;

    /// The fields of a shape, from which [`read`](Self::read) makes it again, to the last bit. `O(vertices)`.
    ///
    /// # Errors
    /// When it is not a shape of this kind.
    fn write(&self, shape: &dyn Shape) -> Result<Parameters>;

    /// The shape that fields describe.
    ///
    /// # Errors
    /// When a field is unknown, missing or wrong, with its place.
    fn read(&self, fields: &Parameters) -> Result<Box<dyn Shape>, ParameterError>;

    /// As segments or triangles, the same ones in all states.
    ///
    /// # Errors
    /// As for [`sampled`], which is the default.
    fn tessellate(&self, states: &[&dyn Shape], fineness: &Fineness) -> Result<Faceted> {
        sampled(states, fineness)
    }

    /// The splines that a shape is, exactly; `None` where it is none.
    fn splines(&self, shape: &dyn Shape) -> Option<Splines> {
        let _ = shape;
        None
    }

    /// The operation that makes splines of a shape that is none exactly, where there is one.
    fn made_splines_by(&self) -> Option<&'static str> {
        None
    }
}

impl fmt::Debug for dyn ShapeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "kind {:?}", self.declaration().name)
    }
}

/// The kind of a type.
pub struct KindOf<S>(PhantomData<fn() -> S>);

impl<S> Default for KindOf<S> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<S> Clone for KindOf<S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<S> Copy for KindOf<S> {}

impl<S> fmt::Debug for KindOf<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "KindOf<{}>", std::any::type_name::<S>())
    }
}

/// A shape as what it is.
fn own<S: DeclaredShape>(shape: &dyn Shape) -> Result<&S> {
    let any: &dyn Any = shape;
    any.downcast_ref().ok_or_else(|| {
        let (name, found) = (S::DECLARATION.name, shape.type_name());
        Error::Invalid(format!(
            "a shape of the kind \"{name}\" is expected here, and this is another one ({found})"
        ))
    })
}

impl<S: DeclaredShape> ShapeKind for KindOf<S> {
    fn declaration(&self) -> Declaration {
        S::DECLARATION
    }

    fn write(&self, shape: &dyn Shape) -> Result<Parameters> {
        Ok(own::<S>(shape)?.fields())
    }

    fn read(&self, fields: &Parameters) -> Result<Box<dyn Shape>, ParameterError> {
        fields.check(S::DECLARATION.fields)?;
        Ok(Box::new(S::from_parameters(fields)?))
    }

    fn tessellate(&self, states: &[&dyn Shape], fineness: &Fineness) -> Result<Faceted> {
        let states = states.iter().map(|shape| own::<S>(*shape)).collect::<Result<Vec<&S>>>()?;
        S::tessellate(&states, fineness)
    }

    fn splines(&self, shape: &dyn Shape) -> Option<Splines> {
        own::<S>(shape).ok()?.splines()
    }

    fn made_splines_by(&self) -> Option<&'static str> {
        S::MADE_SPLINES_BY
    }
}
