//! One module per subcommand.

pub(crate) mod animate;
pub(crate) mod bench;
pub(crate) mod compare;
mod composed;
pub(crate) mod convert;
pub(crate) mod info;
#[cfg(feature = "lab")]
pub(crate) mod lab;
mod methods;
mod metrics;
mod outputs;
pub(crate) mod render;
pub(crate) mod sample;
mod shown;
mod ssim;
mod studio;
