//! The built command, end to end: what it writes, what it says, how it exits.

mod animate;
mod bench;
mod browser;
mod chunks;
mod commands;
mod data;
mod effects;
mod export;
mod help;
mod kernels;
#[cfg(feature = "lab")]
mod lab;
mod motion;
#[path = "../../../splatvol-io/tests/it/common/nifti_file.rs"]
#[allow(dead_code, reason = "a module of tests, used in part")]
mod nifti_file;
mod opened;
mod orientation;
mod outputs;
mod render;
mod sandbox;
mod scenes;
mod serve;
mod shared;
