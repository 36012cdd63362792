// What the module is built from. `cargo xtask-webgpu` and the tests of the module share this file.

/// Files and folders of the module, in the repository.
pub(crate) const SOURCES: [&str; 11] = [
    "Cargo.toml",
    "Cargo.lock",
    ".cargo/config.toml",
    "crates/splatvol",
    "crates/splatvol-core",
    "crates/splatvol-cpu",
    "crates/splatvol-gpu",
    "crates/splatvol-gpu/shaders",
    "crates/splatvol-samples",
    "crates/splatvol-scene",
    "crates/splatvol-webgpu",
];

/// Where the module is, in the repository.
pub(crate) const PLACE: &str = "crates/splatvol-webgpu/module";
