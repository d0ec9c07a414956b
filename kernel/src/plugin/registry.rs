//! Everything that is known by name: formats, operations, kinds of functional, of shape, solvers and the tessellator.

use std::sync::Arc;

use super::format::{Confidence, Format, FormatDeclaration};
use super::operation::Operation;
use crate::declare::{Declaration, ParameterError, Parameters, hint};
use crate::functional::{DeclaredFunctional, Functional, ShapeNames};
use crate::kind::{DeclaredShape, KindOf, ShapeKind};
use crate::solve::Solver;
use crate::tessellator::Tessellator;
use crate::text::clip;

/// Something that brings formats, operations, functionals, solvers or kinds of shape.
pub trait Plugin {
    /// Registers what it brings.
    fn register(&self, registry: &mut Registry);
}

/// A format brings itself.
impl<F: Format + Clone + 'static> Plugin for F {
    fn register(&self, registry: &mut Registry) {
        registry.format(self.clone());
    }
}

type Build = Arc<
    dyn Fn(&Parameters, &mut dyn ShapeNames) -> Result<Arc<dyn Functional>, ParameterError> + Send + Sync,
>;

/// What is known. Starts empty; a name registered again takes the place of the old one.
#[derive(Default, Clone)]
pub struct Registry {
    formats: Vec<Arc<dyn Format>>,
    operations: Vec<Arc<dyn Operation>>,
    functionals: Vec<(Declaration, Build)>,
    solvers: Vec<Arc<dyn Solver>>,
    shapes: Vec<Arc<dyn ShapeKind>>,
    tessellator: Option<Arc<dyn Tessellator>>,
}

impl Registry {
    /// An empty registry.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds what a plug-in brings.
    pub fn add(&mut self, plugin: &dyn Plugin) -> &mut Self {
        plugin.register(self);
        self
    }

    /// Adds a format.
    pub fn format(&mut self, format: impl Format + 'static) {
        self.formats.retain(|f| f.declaration().name != format.declaration().name);
        self.formats.push(Arc::new(format));
    }

    /// Adds an operation.
    pub fn operation(&mut self, operation: impl Operation + 'static) {
        self.operations.retain(|o| o.declaration().name != operation.declaration().name);
        self.operations.push(Arc::new(operation));
    }

    /// Adds a kind of functional; name, fields and help come from the type.
    pub fn functional<F: DeclaredFunctional>(&mut self) {
        self.functionals.retain(|(d, _)| d.name != F::DECLARATION.name);
        let build: Build = Arc::new(|parameters, names| {
            let functional: Arc<dyn Functional> = Arc::new(F::from_parameters(parameters, names)?);
            Ok(functional)
        });
        self.functionals.push((F::DECLARATION, build));
    }

    /// Adds a solver.
    pub fn solver(&mut self, solver: impl Solver + 'static) {
        self.solvers.retain(|s| s.name() != solver.name());
        self.solvers.push(Arc::new(solver));
    }

    /// Adds a kind of shape; name, fields and help come from the type.
    pub fn shape<S: DeclaredShape>(&mut self) {
        self.shape_kind(KindOf::<S>::default());
    }

    /// Adds a kind of shape that is no type of its own (one that another language brings, say).
    pub fn shape_kind(&mut self, kind: impl ShapeKind + 'static) {
        self.shapes.retain(|k| k.declaration().name != kind.declaration().name);
        self.shapes.push(Arc::new(kind));
    }

    /// Sets the tessellator.
    pub fn set_tessellator(&mut self, tessellator: impl Tessellator + 'static) {
        self.tessellator = Some(Arc::new(tessellator));
    }

    /// All formats.
    pub fn formats(&self) -> &[Arc<dyn Format>] {
        &self.formats
    }

    /// All operations.
    pub fn operations(&self) -> &[Arc<dyn Operation>] {
        &self.operations
    }

    /// The declarations of all kinds of functional.
    pub fn functionals(&self) -> impl Iterator<Item = Declaration> + '_ {
        self.functionals.iter().map(|(declaration, _)| *declaration)
    }

    /// All solvers.
    pub fn solvers(&self) -> &[Arc<dyn Solver>] {
        &self.solvers
    }

    /// All kinds of shape.
    pub fn shape_kinds(&self) -> &[Arc<dyn ShapeKind>] {
        &self.shapes
    }

    /// The tessellator, if there is one.
    pub fn tessellator(&self) -> Option<&dyn Tessellator> {
        self.tessellator.as_deref()
    }

    /// The format of a file name, by the longest extension that fits (`loft.json` before `json`).
    pub fn format_of(&self, file: &str) -> Option<&Arc<dyn Format>> {
        let file = file.to_lowercase();
        let fits = |d: &FormatDeclaration| {
            d.extensions.iter().filter(|e| file.ends_with(&format!(".{e}"))).map(|e| e.len()).max()
        };
        self.formats
            .iter()
            .filter_map(|f| fits(&f.declaration()).map(|length| (length, f)))
            .max_by_key(|(length, _)| *length)
            .map(|(_, f)| f)
    }

    /// The format that is most sure of the first bytes of a file, if any holds them for its own.
    pub fn format_of_bytes(&self, bytes: &[u8]) -> Option<&Arc<dyn Format>> {
        let head = &bytes[..bytes.len().min(4096)];
        let sure = |wanted| self.formats.iter().find(|f| f.confidence(head) == wanted);
        sure(Confidence::Sure).or_else(|| sure(Confidence::Maybe))
    }

    /// The operation of a name.
    ///
    /// # Errors
    /// Naming the nearest one where there is none; `path` says where the name was found.
    pub fn find_operation(&self, name: &str, path: &str) -> Result<&Arc<dyn Operation>, ParameterError> {
        self.operations.iter().find(|o| o.declaration().name == name).ok_or_else(|| {
            unknown("operation", name, path, self.operations.iter().map(|o| o.declaration().name))
        })
    }

    /// The solver of a name.
    ///
    /// # Errors
    /// Naming the nearest one where there is none; `path` says where the name was found.
    pub fn find_solver(&self, name: &str, path: &str) -> Result<&Arc<dyn Solver>, ParameterError> {
        self.solvers
            .iter()
            .find(|s| s.name() == name)
            .ok_or_else(|| unknown("solver", name, path, self.solvers.iter().map(|s| s.name())))
    }

    /// The kind of shape of a name.
    ///
    /// # Errors
    /// Naming the nearest one where there is none; `path` says where the name was found.
    pub fn find_shape(&self, name: &str, path: &str) -> Result<&Arc<dyn ShapeKind>, ParameterError> {
        self.shapes.iter().find(|k| k.declaration().name == name).ok_or_else(|| {
            unknown("kind of shape", name, path, self.shapes.iter().map(|k| k.declaration().name))
        })
    }

    /// The declaration of a kind of functional.
    ///
    /// # Errors
    /// Naming the nearest one where there is none; `path` says where the name was found.
    pub fn find_functional(&self, kind: &str, path: &str) -> Result<Declaration, ParameterError> {
        self.functionals().find(|d| d.name == kind).ok_or_else(|| {
            unknown("kind of constraint", kind, path, self.functionals.iter().map(|(d, _)| d.name))
        })
    }

    /// Builds the functional that `parameters` describe (`kind` and its own fields, nothing else).
    ///
    /// # Errors
    /// When the kind is unknown, or a field is missing, unknown or wrong.
    pub fn build_functional(
        &self,
        kind: &str,
        parameters: &Parameters,
        names: &mut dyn ShapeNames,
    ) -> Result<Arc<dyn Functional>, ParameterError> {
        let declaration = self.find_functional(kind, parameters.path())?;
        parameters.check(declaration.fields)?;
        match self.functionals.iter().find(|(d, _)| d.name == kind) {
            Some((_, build)) => build(parameters, names),
            None => Err(parameters.error("", format!("unknown kind of constraint \"{kind}\""))),
        }
    }
}

fn unknown<'a>(
    what: &str,
    name: &str,
    path: &str,
    known: impl Iterator<Item = &'a str> + Clone,
) -> ParameterError {
    let hint = hint(name, known.clone(), || match known.clone().next() {
        None => "none is registered".to_owned(),
        Some(_) => format!("known are {}", known.collect::<Vec<_>>().join(", ")),
    });
    let problem = format!("unknown {what} \"{}\"; {hint}", clip(name));
    ParameterError { path: path.to_owned(), problem }
}
