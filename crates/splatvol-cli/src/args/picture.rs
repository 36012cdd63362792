//! Flags about a picture: all that a document says of it but its size, whose default each command has of its own.

use std::path::PathBuf;

use clap::Args;
use splatvol_document::keys::Background;

use super::help::OUTPUT;
use super::{CameraArgs, EffectArgs, InputArgs, ItemArgs, LookArgs, MethodArgs, MotionArgs, values};

/// What a picture shows, and how it is made.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct PictureArgs {
    /// Colour: white, gray, none, #rrggbb, r,g,b[,a]... [default: charcoal]
    ///
    /// black, white, gray, charcoal, none (the picture keeps its alpha), #rrggbb, or r,g,b or r,g,b,a from 0 to 1.
    #[arg(long, value_name = "COLOUR", value_parser = values::background, help_heading = OUTPUT)]
    pub(crate) background: Option<Background>,
    /// Bits per channel of a PNG: 8 or 16 [default: 8]
    #[arg(long, value_name = "BITS", value_parser = values::bits, help_heading = OUTPUT)]
    pub(crate) bits: Option<u8>,
    /// Make the picture as this PNG of splatvol, but for the flags given here
    #[arg(long, value_name = "PICTURE", help_heading = OUTPUT)]
    pub(crate) like: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    #[command(flatten)]
    pub(crate) effects: EffectArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    #[command(flatten)]
    pub(crate) motion: MotionArgs,
    #[command(flatten)]
    pub(crate) read: InputArgs,
    #[command(flatten)]
    pub(crate) item: ItemArgs,
}
