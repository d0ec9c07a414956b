//! What can keep a shape from being tuned: one variant a reason, with the numbers that show it.

use loftsman_kernel::edit::EditError;
use loftsman_kernel::error::{Error, Figure, MAX_DEGREE};
use loftsman_kernel::plugin::OperationError;
use loftsman_kernel::text::counted;

/// The result of a tuning.
pub type Result<T, E = FineTuneError> = std::result::Result<T, E>;

/// Why a shape could not be tuned. Every message says what was found and what to do.
#[non_exhaustive]
#[derive(Debug, Clone, thiserror::Error)]
pub enum FineTuneError {
    /// The shape is rational.
    #[error(
        "the derivative of a rational {what} is no spline, so that scaling it gives none: {}",
        polynomial(what)
    )]
    Rational {
        /// A curve or a surface.
        what: &'static str,
    },
    /// The shape is torn.
    #[error(
        "the {what} is torn at {}, where a knot is repeated {copies} times (its degree {degree} allows {degree}), so that it has no derivative there: split it \
         there and tune the pieces", Figure(*.at)
    )]
    Torn {
        /// A curve, or a surface and along which parameter.
        what: &'static str,
        /// Where.
        at: f64,
        /// How often the knot is repeated.
        copies: usize,
        /// The degree.
        degree: usize,
    },
    /// The tuned shape would be of a degree that is not there.
    #[error(
        "a derivative of degree {derivative} times α of degree {alpha} would give degree {}, above {MAX_DEGREE}: give α a lower \
         degree",
        derivative + alpha + 1
    )]
    Degree {
        /// The degree of the derivative.
        derivative: usize,
        /// The degree of α.
        alpha: usize,
    },
    /// α has not as many values as its space.
    #[error(
        "α has {found} values and needs {needed}: one for each B-spline of degree {degree} on the knots of the derivative; other \
         knots are given as {{ degree, knots, values }}"
    )]
    Values {
        /// Values found.
        found: usize,
        /// Values needed.
        needed: usize,
        /// The degree of the derivative.
        degree: usize,
    },
    /// α is not positive.
    #[error(
        "α is {} at {at}: where it is not positive, tangents turn round or vanish; say any_sign where that is meant", Figure(*.value)
    )]
    NotPositive {
        /// Its value (or coefficient).
        value: f64,
        /// Where.
        at: String,
    },
    /// α is so large that nothing but rounding would be left of the ends.
    #[error(
        "α is as large as {}: the ends are kept to rounding of what it makes of the curve; give values up to 1e9, or say ends = \"free\"", Figure(*.value)
    )]
    TooLarge {
        /// Its largest size.
        value: f64,
    },
    /// What is asked is met by no α that is positive.
    #[error(
        "what is asked takes an α that is not positive (the nearest one runs from {} to {}), and none that is at least {} everywhere does it, tangents \
         keeping their directions: ask for less, give α more knots, or say any_sign where tangents may turn round", Figure(*.least), Figure(*.most), Figure(*.bound)
    )]
    NoPositive {
        /// The smallest value of the nearest α.
        least: f64,
        /// Its largest value.
        most: f64,
        /// How small an α was looked for.
        bound: f64,
    },
    /// A range that is none, or outside of the domain.
    #[error("the range [{}, {}] {}", Figure(*.from), Figure(*.to), range_fault([*.from, *.to], [*.start, *.end], *.periodic))]
    Range {
        /// Where it should start.
        from: f64,
        /// Where it should end.
        to: f64,
        /// Where the domain starts.
        start: f64,
        /// Where the domain ends.
        end: f64,
        /// Whether that is the period of a curve, so that a range may go over its seam.
        periodic: bool,
    },
    /// Both ends are one point, so that no rotation and no scale brings them anywhere.
    #[error(
        "the {which} of the {whose} curve are one point, so that no rotation and scale can be found that keeps them (paper 5 cannot, \
         either): use ends = \"exact\""
    )]
    Closed {
        /// Which points.
        which: &'static str,
        /// Of the tuned curve or of the one it came from.
        whose: &'static str,
    },
    /// More is asked of the ends than α can give.
    #[error(
        "{asked}: these are {equations} equations, and α has {} where it needs at least {needed}: give it \
         more knots ({{ degree, knots, values }}), tune a longer range, or ask for less",
        counted(*.values, "value[|s]")
    )]
    TooFewValues {
        /// What is asked.
        asked: String,
        /// Equations.
        equations: usize,
        /// Values that α needs.
        needed: usize,
        /// Values of α.
        values: usize,
    },
    /// What is asked of the ends is met nearest to the α asked for by 1.
    #[error(
        "{asked}: of all α that do this, 1 is the nearest to the one asked for, so that nothing would be tuned: ask for an α that varies along the curve, tune a \
         part of it (range), or let the end go (ends = \"free\")"
    )]
    Nothing {
        /// What is asked.
        asked: String,
    },
    /// Edges of a surface that stay with α = 1 only.
    #[error(
        "that both edges across {along} stay takes up to {equations} independent equations of α{}, of which {values} {} may change, so that only α = 1 \
         keeps them: {}, ask for less continuity, or tune more of the surface", if *.net { "(u, v)" } else { "" },
        if *.values == 1 { "value" } else { "values" },
        if *.net { format!("give α at least {needed} values along {along} with the {columns} across ({{ degree, knots, values }})") }
        else { format!("give α at least {needed} values along {along}, or scale by an α(u, v)") }
    )]
    Edges {
        /// The direction that is scaled.
        along: &'static str,
        /// Whether α is a function of both parameters.
        net: bool,
        /// Independent equations, at most.
        equations: usize,
        /// Values of α that may change.
        values: usize,
        /// Values along the direction that leave some to change.
        needed: usize,
        /// Values across.
        columns: usize,
    },
    /// A part of a surface of which α has no values left, or none that is asked to be other than 1.
    #[error("{}", sides(along, *.found, *.fixed, *.needed))]
    Sides {
        /// The direction that is scaled.
        along: &'static str,
        /// Values of α along it and across; 1 across where it is a function of one parameter.
        found: [usize; 2],
        /// How many at the start and at the end, and at the first and the last side, are 1.
        fixed: [[usize; 2]; 2],
        /// How many leave some to change; 0 where there are enough.
        needed: [usize; 2],
    },
    /// Something that contradicts something else that was asked.
    #[error("{0}")]
    Contradiction(String),
    /// What is asked cannot be met.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The geometry does not allow it.
    #[error(transparent)]
    Geometry(#[from] Error),
}

impl From<FineTuneError> for OperationError {
    fn from(error: FineTuneError) -> Self {
        match error {
            FineTuneError::Edit(error) => error.into(),
            FineTuneError::Geometry(error) => error.into(),
            other => Error::Invalid(other.to_string()).into(),
        }
    }
}

/// Why α of a part of a surface has no choice.
fn sides(along: &str, found: [usize; 2], fixed: [[usize; 2]; 2], needed: [usize; 2]) -> String {
    let net = found[1] > 1 || fixed[1] != [0; 2];
    let (what, has) = if net {
        ("α(u, v)", format!("{} values along {along} and {} across", found[0], found[1]))
    } else {
        ("α", format!("{} values along {along}", found[0]))
    };
    let both = |[first, last]: [usize; 2], each: &str, names: [&str; 2]| match (first, last) {
        (first, last) if first == last => format!("{first} at either {each}"),
        (first, 0) => format!("{first} at {}", names[0]),
        (0, last) => format!("{last} at {}", names[1]),
        (first, last) => format!("{first} at {} and {last} at {}", names[0], names[1]),
    };
    let ends = both(fixed[0], "end", ["the start", "the end"]);
    let ends = if net {
        format!(
            "{ends} along {along} and {} across",
            both(fixed[1], "side", ["the first side", "the last side"])
        )
    } else {
        ends
    };
    let way = if needed == [0; 2] {
        "all others are asked to be 1, too; ask for others than 1 among those, or give α more values ({ degree, knots, values })".to_owned()
    } else if net {
        format!(
            "none is left to change; give α at least {} values along {along} and {} across ({{ degree, knots, values }})",
            needed[0], needed[1]
        )
    } else {
        format!(
            "none is left to change; give α at least {} values along {along} ({{ degree, knots, values }})",
            needed[0]
        )
    };
    format!(
        "{what} has {has}, of which {ends} are 1, so that the part joins the rest: {way}, or ask for less continuity"
    )
}

/// What is wrong with a range of a domain.
fn range_fault([from, to]: [f64; 2], [start, end]: [f64; 2], periodic: bool) -> String {
    if from == to {
        return "is empty: it runs from a smaller number to a larger one".to_owned();
    }
    let domain = format!("[{}, {}]", Figure(start), Figure(end));
    if from > to {
        let over = to + (end - start);
        let seam = if periodic && start <= from && from < end && from < over {
            format!(", or over the seam [{}, {}]", Figure(from), Figure(over))
        } else {
            String::new()
        };
        return format!(
            "is reversed: it runs from the smaller number to the larger one, [{}, {}]{seam}",
            Figure(to),
            Figure(from)
        );
    }
    if from < to && periodic {
        return format!(
            "reaches out of the domain, which is {domain}: it starts there, and ends at most once round ({} after its start)",
            Figure(end - start)
        );
    }
    if from < to {
        return format!("reaches out of the domain, which is {domain}");
    }
    "is none: give two numbers, the smaller one first".to_owned()
}

/// How a polynomial curve or surface near a rational one is had.
fn polynomial(what: &str) -> &'static str {
    match what {
        "curve" => {
            "take points along it (operation `sample`) and fit a polynomial curve to them within a tolerance (operation `fit`)"
        }
        _ => "bring a polynomial surface to points of it (operation `fit-shape`)",
    }
}
