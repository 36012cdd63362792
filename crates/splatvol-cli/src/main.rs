//! The command `splatvol`.
fn main() {}
