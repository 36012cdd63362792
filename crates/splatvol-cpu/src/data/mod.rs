//! Post-classification: coefficients are splatted to planes, four at a time, and each pair of planes is shaded.
pub(crate) mod activate;
pub(crate) mod border;
pub(crate) mod engine;
pub(crate) mod frame;
pub(crate) mod level;
pub(crate) mod mask;
pub(crate) mod order;
pub(crate) mod plane;
pub(crate) mod resolve;
pub(crate) mod ring;
pub(crate) mod shade;
pub(crate) mod sheet;
pub(crate) mod splat;
pub(crate) mod tile;
pub(crate) mod upsample;
