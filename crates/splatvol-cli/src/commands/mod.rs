//! One module per subcommand.

pub(crate) mod animate;
pub(crate) mod bench;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod info;
mod methods;
mod metrics;
pub(crate) mod render;
pub(crate) mod sample;
mod studio;
