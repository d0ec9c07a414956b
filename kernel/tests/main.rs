//! The tests of this crate, as one program.

mod basis_properties;
mod border;
mod boxed;
mod conformance;
mod curvature;
mod edits;
mod evaluation;
mod floating;
mod golden_basis;
mod inequalities;
mod joins;
mod liars;
mod measured;
mod parameters;
mod parts;
mod rank;
mod refinement;
mod refusals;
mod shapes;
mod smooth;
mod solids;
mod solvers;
mod symmetry;
mod told;
mod unknowns;
mod wishes;
