//! OpenEXR: 32-bit floats, linear light (BT.709 primaries), premultiplied alpha, ZIP compression.
//!
//! Channels are `R G B A` and, for frames, `Z`: camera depth (along the view direction, not along the ray), infinite
//! where the picture is empty. Metadata: `Software` is EXR's standard attribute `software`; all other pairs go as one
//! JSON list of pairs into the string attribute [`METADATA_ATTRIBUTE`], since the writer's own order of several custom
//! attributes changes from run to run and files should not.

use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, MetaData, ReadChannels,
    ReadLayers, Vec2, WritableImage, read,
};
use splatvol_scene::{Image, ImageSize};

use super::{LoadedImage, check_size, metadata};
use crate::IoError;
use crate::error::Context;

/// Attribute that holds all metadata but `Software`, as a JSON list of pairs of strings.
pub const METADATA_ATTRIBUTE: &str = "splatvol.metadata";

/// Best ratio of the compressions: deflate has 1032, of which PXR24 drops a quarter; run lengths in PIZ have 410.
const RATIO: u64 = 1500;
/// Bytes that any file may hold, whatever its length.
const SLACK: u64 = 1 << 20;

/// Longest attribute that is read as text.
const LONGEST_TEXT: usize = 16 << 20;

/// A picture, with its depth where there is one, as the bytes of an EXR file.
///
/// # Errors
/// [`IoError::Encode`] for metadata that cannot be held, or a depth that does not fit the image.
pub fn encode(
    image: &Image,
    depth: Option<&[f32]>,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, IoError> {
    let refuse = |what: String| IoError::Encode { format: "EXR", what };
    metadata::check("EXR", metadata)?;
    if let Some(depth) = depth.filter(|depth| depth.len() != image.pixels.len()) {
        let (found, expected) = (depth.len(), image.pixels.len());
        return Err(refuse(format!("{found} depths for {expected} pixels")));
    }
    let plane = |c: usize| image.pixels.iter().map(|pixel| pixel[c]).collect();
    let mut channels: Vec<AnyChannel<FlatSamples>> = ["R", "G", "B", "A"]
        .into_iter()
        .enumerate()
        .map(|(c, name)| AnyChannel::new(name, FlatSamples::F32(plane(c))))
        .collect();
    channels.extend(depth.map(|depth| AnyChannel::new("Z", FlatSamples::F32(depth.to_vec()))));

    let layer = Layer::new(
        (image.size().width() as usize, image.size().height() as usize),
        attributes(metadata).map_err(|error| refuse(error.to_string()))?,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into()),
    );
    let mut picture = exr::prelude::Image::from_layer(layer);
    picture.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| refuse(error.to_string()))?;
    Ok(bytes.into_inner())
}

pub(super) fn attributes(metadata: &[(String, String)]) -> Result<LayerAttributes, serde_json::Error> {
    // EXR strings are bytes; these are UTF-8.
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let mut attributes = LayerAttributes::default();
    let is_software = |(keyword, _): &&(String, String)| keyword == metadata::SOFTWARE;
    attributes.software_name = metadata.iter().find(is_software).map(|(_, value)| text(value));
    let others: Vec<_> = metadata.iter().filter(|pair| !is_software(pair)).collect();
    if !others.is_empty() {
        let json = serde_json::to_string(&others)?;
        attributes
            .other
            .insert(text(METADATA_ATTRIBUTE), AttributeValue::Text(text(&json)));
    }
    Ok(attributes)
}

/// A picture from the bytes of an EXR file; `path` is only named in errors. The first of several layers is taken; if
/// a picture lies inside a larger window, only the stored part is.
///
/// # Errors
/// [`IoError::Format`] for an invalid EXR, [`IoError::Unsupported`] for pictures without `R`, `G` and `B`,
/// [`IoError::Truncated`] and [`IoError::Limit`] for sizes that the bytes do not justify.
pub fn decode(bytes: &[u8], path: &Path) -> Result<LoadedImage, IoError> {
    let context = Context::new("EXR", path);
    let picture = decode_picture(bytes, &context)?;
    let layer = &picture.layer_data;
    let size = layer_size(layer, &context)?;
    let plane = |name: &str| channel(layer, name);
    let (Some(red), Some(green), Some(blue)) = (plane("R"), plane("G"), plane("B")) else {
        return Err(context.unsupported("the first layer has no full channels R, G and B"));
    };
    let alpha = plane("A").unwrap_or_else(|| vec![1.0; size.pixel_count()]);
    let pixels = (0..size.pixel_count())
        .map(|i| [red[i], green[i], blue[i], alpha[i]])
        .collect();
    Ok(LoadedImage {
        image: Image::from_pixels(size, pixels).map_err(|error| context.scene(error))?,
        depth: plane("Z"),
        metadata: texts(&layer.attributes, &context)?,
    })
}

/// Channels that may hold depths, best first.
const DEPTH_CHANNELS: [&str; 5] = ["Z", "depth", "Y", "V", "R"];

/// Width, height and depths of an EXR file: channel `Z`, or the first of `depth`, `Y`, `V`, `R`.
///
/// # Errors
/// Same as [`decode`]; [`IoError::Unsupported`] without such a channel.
pub(crate) fn decode_depth(bytes: &[u8], path: &Path) -> Result<([usize; 2], Vec<f32>), IoError> {
    let context = Context::new("EXR", path);
    let picture = decode_picture(bytes, &context)?;
    let layer = &picture.layer_data;
    let size = layer_size(layer, &context)?;
    let depths = DEPTH_CHANNELS
        .iter()
        .find_map(|name| channel(layer, name))
        .ok_or_else(|| {
            context.unsupported(format!(
                "no full channel {} for depths",
                DEPTH_CHANNELS.join(", ")
            ))
        })?;
    Ok(([size.width() as usize, size.height() as usize], depths))
}

type Channels = AnyChannels<FlatSamples>;

/// The first layer, all channels; sizes are first checked against the bytes.
fn decode_picture(
    bytes: &[u8],
    context: &Context<'_>,
) -> Result<exr::prelude::Image<Layer<Channels>>, IoError> {
    let malformed = |error: exr::error::Error| context.field("contents", error, None, "a valid EXR");
    let headers = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(malformed)?
        .headers;
    for header in &headers {
        let Vec2(width, height) = header.layer_size;
        let pixels = (width as u64).saturating_mul(height as u64);
        let needed = pixels.saturating_mul(header.channels.bytes_per_pixel as u64);
        let available = (bytes.len() as u64).saturating_mul(RATIO).saturating_add(SLACK);
        if needed > available {
            return Err(context.too_small("pixels", needed, available));
        }
        let channels = header.channels.list.len() as u64;
        check_size(
            pixels.saturating_mul(channels.div_ceil(4)),
            bytes,
            u64::MAX,
            context,
        )?;
    }
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(malformed)
}

fn layer_size(layer: &Layer<Channels>, context: &Context<'_>) -> Result<ImageSize, IoError> {
    let side = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    ImageSize::new(side(layer.size.0), side(layer.size.1)).map_err(|error| context.scene(error))
}

/// Samples of a channel that is not subsampled.
fn channel(layer: &Layer<Channels>, name: &str) -> Option<Vec<f32>> {
    let channel = layer
        .channel_data
        .list
        .iter()
        .find(|channel| channel.name.eq(name))?;
    let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
    (samples.len() == layer.size.0 * layer.size.1).then_some(samples)
}

fn texts(attributes: &LayerAttributes, context: &Context<'_>) -> Result<Vec<(String, String)>, IoError> {
    let string = |text: &Text| String::from_utf8_lossy(text.as_slice()).into_owned();
    let mut metadata = Vec::new();
    if let Some(software) = &attributes.software_name {
        metadata.push((metadata::SOFTWARE.to_owned(), string(software)));
    }
    let mut others: Vec<(String, String)> = attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) if text.as_slice().len() <= LONGEST_TEXT => {
                Some((string(name), string(text)))
            }
            _ => None,
        })
        .collect();
    others.sort();
    for (name, text) in others {
        if name == METADATA_ATTRIBUTE {
            let pairs: Vec<(String, String)> = serde_json::from_str(&text).map_err(|error| {
                context.field(METADATA_ATTRIBUTE, error, None, "a JSON list of pairs of strings")
            })?;
            metadata.extend(pairs);
        } else {
            metadata.push((name, text));
        }
    }
    Ok(metadata)
}
