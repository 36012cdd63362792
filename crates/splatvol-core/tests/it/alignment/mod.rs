//! Alignments: footprints against the line integrals they stand for (mueller1998 section 4), all computed
//! again here in 64 bits by quadrature.

mod bounds;
mod errors;
mod figures;
mod model;
mod rows;
