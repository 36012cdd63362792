//! Development tasks of splatvol.
fn main() {}
