//! Point files from outside: real ones, every spelling, bytes that are none, and the way back.

#[cfg(test)]
mod common;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod real_files;
#[cfg(test)]
mod spellings;
#[cfg(test)]
mod write;
