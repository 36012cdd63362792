//! The built command, end to end: what it writes, what it says, how it exits.

mod animate;
mod bench;
mod commands;
mod data;
mod effects;
mod help;
mod kernels;
#[cfg(feature = "lab")]
mod lab;
mod motion;
mod orientation;
mod outputs;
mod render;
mod sandbox;
mod scenes;
mod shared;
