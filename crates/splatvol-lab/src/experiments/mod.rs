//! The experiments, a module per paper.

pub mod beyond;
mod ground;
pub mod huang2000;
pub mod mueller1998;
pub mod swan1997;
pub mod zwicker2001;
