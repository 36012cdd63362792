//! One module per subcommand.

pub(crate) mod animate;
mod asked;
mod bands;
pub(crate) mod bench;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod export;
pub(crate) mod info;
#[cfg(feature = "lab")]
pub(crate) mod lab;
mod methods;
mod metrics;
mod nothing;
mod outputs;
pub(crate) mod part;
pub(crate) mod render;
pub(crate) mod sample;
pub(crate) mod schema;
pub(crate) mod serve;
mod ssim;
mod studio;
#[cfg(feature = "view")]
pub(crate) mod view;
