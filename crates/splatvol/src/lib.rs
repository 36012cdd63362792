//! Volume rendering by splatting.
