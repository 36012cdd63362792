//! The slow, obvious f64 ray integrator that every engine is tested against.
