//! The built command, end to end: what it writes, what it says, how it exits.

mod bench;
mod commands;
mod effects;
mod orientation;
mod render;
mod sandbox;
