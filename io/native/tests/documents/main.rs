//! The native format from outside: round trips, and bytes that are no document.

#[cfg(test)]
mod breps;
#[cfg(test)]
mod common;
#[cfg(test)]
mod definitions;
#[cfg(test)]
mod forms;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod round_trip;
#[cfg(test)]
mod shapes;
