//! Operators in WGSL, the language of GPUs: the text beside the Rust that it follows line by line.

/// An operator as the GPU engine applies it.
///
/// Its function has this signature, and reads its own numbers as `operand(at)`, `operand(at + 1u)` and so on:
///
/// ```wgsl
/// fn NAME(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32)
/// ```
///
/// `SheetSample` and `Appearance` have the members of [`SheetSample`](super::SheetSample) and
/// [`Appearance`](super::Appearance), in the same spaces and units. Shaders hold the functions of all operators of an item: two
/// functions must not have one name.
#[derive(Debug, Clone, PartialEq)]
pub struct WgslOperator {
    /// Name of its function.
    pub name: &'static str,
    /// The function and those that it calls. A text that several operators have is taken once.
    pub texts: Vec<&'static str>,
    /// Its numbers.
    pub operands: Vec<[f32; 4]>,
}

pub(super) const PICTURE: &str = include_str!("picture.wgsl");
pub(super) const NOISE: &str = include_str!("noise.wgsl");
pub(super) const GRADIENT_OPACITY: &str = include_str!("gradient_opacity.wgsl");
pub(super) const TRANSFER_FUNCTION_2D: &str = include_str!("transfer_function_2d.wgsl");
pub(super) const SOLID_TEXTURE: &str = include_str!("solid_texture.wgsl");
pub(super) const BUMP_MAP: &str = include_str!("bump_map.wgsl");
pub(super) const ENVIRONMENT_MAP: &str = include_str!("environment_map.wgsl");
