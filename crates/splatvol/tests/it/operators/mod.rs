//! Operators, clips and isosurfaces: the same picture where they do nothing, the same bytes on any threads and
//! instructions, and close to closed forms and to f64 integrals along rays.
//!
//! Tolerances lie a little above the measured values; `--nocapture` prints the figures.

mod cuts;
mod integrals;
mod same;
mod support;
mod surfaces;
