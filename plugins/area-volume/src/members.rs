//! Which shapes a functional is about.

use std::fmt;

use loftsman_kernel::error::Error;
use loftsman_kernel::functional::{On, ShapeNames, Shapes};
use loftsman_kernel::plugin::{Field, ParameterError, Parameters};
use loftsman_kernel::shape::{Cells, Shape, Splines, cells_of};
use loftsman_kernel::{Point, Result, topology};

/// The field that names another object than the step's.
pub(crate) const OBJECT: Field =
    Field::optional("object", "text", "the step's object", "another object of the scene to ask this of");
/// The field that names several.
pub(crate) const OBJECTS: Field = Field::optional(
    "objects",
    "[text, …]",
    "the one object",
    "the objects that bound it together: outer curve and holes, pieces end to end, patches",
);

/// Shapes of a problem, one or several that belong together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Members(pub(crate) Vec<On>);

impl Default for Members {
    fn default() -> Self {
        Self(vec![On::default()])
    }
}

impl<T: Into<On>> FromIterator<T> for Members {
    fn from_iter<I: IntoIterator<Item = T>>(shapes: I) -> Self {
        Self(shapes.into_iter().map(Into::into).collect())
    }
}

impl Members {
    /// From `object`, or a list of names in `list`.
    pub(crate) fn from_parameters(
        parameters: &Parameters,
        names: &mut dyn ShapeNames,
        list: &str,
    ) -> Result<Self, ParameterError> {
        if !parameters.has(list) {
            let mut on = On::from_parameters(parameters, names)?;
            on.name = on.name.or_else(|| names.name(on.shape).map(Into::into));
            return Ok(Self(vec![on]));
        }
        if parameters.has("object") && list == "objects" {
            return Err(parameters.error("object", "\"objects\" names them already; leave this one out"));
        }
        let mut all: Vec<On> = Vec::new();
        for (i, value) in parameters.list(list)?.iter().enumerate() {
            let path = format!("{list}[{i}]");
            let Some(name) = value.as_str() else {
                return Err(parameters.error(&path, "the name of an object is needed"));
            };
            let shape = names.shape(name).map_err(|e| parameters.error(&path, e.to_string()))?;
            if all.iter().any(|on| on.shape == shape) {
                return Err(parameters.error(&path, format!("\"{name}\" is named twice")));
            }
            all.push(On { shape, name: Some(name.into()) });
        }
        if all.is_empty() {
            return Err(parameters.error(list, "name at least one object"));
        }
        Ok(Self(all))
    }
}

/// `"section"`, or what stands for a name where there is none.
pub(crate) fn name_of(on: &On) -> String {
    match &on.name {
        Some(name) => format!("\"{name}\""),
        None if on.shape == 0 => "the shape".into(),
        None => format!("shape {}", on.shape),
    }
}

impl fmt::Display for Members {
    /// Nothing for the first shape alone, else ` of "hull"` or ` of "outer", "hole"`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let [on] = &self.0[..] {
            return write!(f, "{on}");
        }
        let names: Vec<String> = self.0.iter().map(name_of).collect();
        write!(f, " of {}", names.join(", "))
    }
}

/// Whether something is asked of curves or of surfaces.
pub(crate) fn is_surface(shapes: &Shapes<'_>, on: &On) -> Result<bool> {
    Ok(shapes.get(on.shape)?.domain().len() == 2)
}

/// A curve or surface that is measured, and the cells that it consists of.
#[derive(Clone, Copy)]
pub(crate) struct Member<'a> {
    pub(crate) shape: &'a dyn Shape,
    pub(crate) cells: &'a dyn Cells,
    /// Its spaces and weights, where it is a spline: sums over products of spans are faster than over cells.
    pub(crate) splines: Option<Splines<'a>>,
}

impl<'a> Member<'a> {
    fn of(shapes: &Shapes<'a>, on: &On, what: &str, instead: &str, parameters: usize) -> Result<Self> {
        let shape: &'a dyn Shape = shapes.get(on.shape)?;
        let name = name_of(on);
        if shape.domain().len() != parameters {
            let kind = if parameters == 1 { "a surface" } else { "a curve" };
            return Err(Error::Invalid(format!("{what}: {name} is {kind}; {instead}")));
        }
        let cells = cells_of(shape, &format!("{what} of {name}"))?;
        // Of a part nothing is a product of what is along u and along v.
        let splines = if cells.is_partial() { None } else { cells.splines() };
        Ok(Self { shape, cells, splines })
    }

    pub(crate) fn points(&self) -> &'a [Point] {
        self.shape.control_vertices()
    }
}

/// The curve that a member is; the error says what to ask of a surface instead.
pub(crate) fn curve<'a>(shapes: &Shapes<'a>, on: &On, what: &str, instead: &str) -> Result<Member<'a>> {
    Member::of(shapes, on, what, instead, 1)
}

/// The surface that a member is; the error says what to ask of a curve instead.
pub(crate) fn surface<'a>(shapes: &Shapes<'a>, on: &On, what: &str, instead: &str) -> Result<Member<'a>> {
    Member::of(shapes, on, what, instead, 2)
}

/// Which members say themselves what they bound, and which have to close with one another.
///
/// # Errors
/// When a member is no surface.
pub(crate) fn by_themselves(shapes: &Shapes<'_>, members: &[On], what: &str) -> Result<Vec<bool>> {
    let alone = |on: &On| {
        let own =
            surface(shapes, on, what, "a volume is bounded by surfaces; ask for its area, or its length")?;
        Ok(own.cells.senses().is_some())
    };
    members.iter().map(alone).collect()
}

/// Surfaces as parts of a shell, by the names that messages use.
pub(crate) fn shell_members<'a>(
    shapes: &Shapes<'a>,
    members: &[On],
    what: &str,
) -> Result<Vec<topology::Member<'a>>> {
    let part = |on: &On| {
        let shape =
            surface(shapes, on, what, "a volume is bounded by surfaces; ask for its area, or its length")?
                .shape;
        Ok(topology::Member { shape, name: name_of(on) })
    };
    members.iter().map(part).collect()
}

/// The middle of the box around some points.
pub(crate) fn middle_of(points: &[Point]) -> Point {
    let Some(&first) = points.first() else { return Point::origin() };
    let (low, high) = points.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    middle(&low, &high)
}

/// The middle of the box around all vertices of the members, and its diagonal.
pub(crate) fn extent(shapes: &Shapes<'_>, members: &[On]) -> Result<(Point, f64)> {
    let (mut low, mut high): (Option<Point>, Option<Point>) = (None, None);
    for on in members {
        for p in shapes.get(on.shape)?.control_vertices() {
            low = Some(low.map_or(*p, |low| low.inf(p)));
            high = Some(high.map_or(*p, |high| high.sup(p)));
        }
    }
    let (low, high) = (low.unwrap_or_else(Point::origin), high.unwrap_or_else(Point::origin));
    Ok((middle(&low, &high), (high - low).norm()))
}

fn middle(low: &Point, high: &Point) -> Point {
    // Halves first: the sum of two large coordinates may overflow.
    Point::from(low.coords * 0.5 + high.coords * 0.5)
}
