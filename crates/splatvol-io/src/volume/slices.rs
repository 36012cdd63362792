//! A folder of pictures, one per slice: TIFF, PNG or JPEG, in the natural order of their names (`a9.tif` before
//! `a10.tif`).

use std::io::BufReader;
use std::path::{Path, PathBuf};

use jpeg_decoder::PixelFormat;
use splatvol_scene::Samples;

use super::planes::{Plane, append, component_names};
use super::stack::{self, Slices};
use super::{
    Description, Draft, Loaded, Opened, ReadOptions, checked_dims, choose_channel, detect, sample_count, tiff,
};
use crate::error::Context;
use crate::files::File;
use crate::samples::SampleType;
use crate::source::{Source, read_file};
use crate::{IoError, SampleType as Type};

/// Bytes that a compressed byte may decode to (deflate has 1032), and bytes that any file may hold.
const RATIO: u64 = 1032;
const SLACK: u64 = 1 << 20;

/// True if the file's name is that of a slice.
pub(super) fn is_slice(path: &Path) -> bool {
    matches!(
        detect::extension(path).as_str(),
        "tif" | "tiff" | "png" | "jpg" | "jpeg"
    )
}

/// The slices of a folder, all of the form of the first.
#[derive(Debug)]
struct Folder {
    files: Vec<PathBuf>,
    size: [usize; 2],
    components: usize,
    channel: usize,
}

impl Folder {
    /// The folder, its volume and the first slice.
    fn open(
        folder: &Path,
        options: &ReadOptions,
        context: &Context<'_>,
    ) -> Result<(Self, Draft, Samples), IoError> {
        let mut files = detect::files_of(folder, context)?;
        files.retain(|file| is_slice(file));
        let Some(first) = files.first() else {
            return Err(context.unsupported("no slices (TIFF, PNG or JPEG)"));
        };
        let one = plane(first)?;
        let (size, components) = (one.size, one.components);
        let sizes = [size[0], size[1], files.len()].map(|size| size as i64);
        let names = component_names(components);
        let (channel, warning) = choose_channel(&names, options, context)?;
        let description = Description {
            format: format!("folder of slices ({})", detect::extension(first)),
            stored_type: one.samples.type_name().to_owned(),
            orientation: "no geometry in the files, spacing 1".to_owned(),
            channels: if components > 1 { names } else { Vec::new() },
            warnings: warning.into_iter().chain(gaps(&files)).collect(),
            files: files.clone(),
            ..Description::default()
        };
        let draft = Draft::new(checked_dims(&sizes, "dims", None, context)?, description);
        let folder = Self {
            files,
            size,
            components,
            channel,
        };
        Ok((folder, draft, one.component(channel)))
    }
}

impl Slices for Folder {
    fn slice(&self, index: usize) -> Result<Samples, IoError> {
        let file = &self.files[index];
        let next = plane(file)?;
        if (next.size, next.components) != (self.size, self.components) {
            let shown = format!(
                "{} x {}, {} components",
                next.size[0], next.size[1], next.components
            );
            let expected = format!(
                "{} x {}, {} components, as in {}",
                self.size[0],
                self.size[1],
                self.components,
                self.files[0].display()
            );
            return Err(Context::new("slice", file).field("size", shown, None, expected));
        }
        Ok(next.component(self.channel))
    }
}

/// Reads a folder.
///
/// # Errors
/// See [`IoError`]; also a slice of another size or type than the first, by its name.
pub fn read(folder: &Path, options: &ReadOptions) -> Result<Loaded, IoError> {
    let context = &Context::new("folder of slices", folder).following(options);
    let (folder, draft, mut pile) = Folder::open(folder, options, context)?;
    let sample_type = Type::from_name(pile.type_name()).unwrap_or(SampleType::F64);
    sample_count(draft.dims, 1, sample_type, options, context)?;
    for (index, file) in folder.files.iter().enumerate().skip(1) {
        append(&mut pile, folder.slice(index)?, &Context::new("slice", file))?;
    }
    draft.finish(pile, context)
}

/// Opens a folder, whose slices are read when they are asked for.
///
/// # Errors
/// See [`IoError`].
pub(super) fn open(folder: &Path, options: &ReadOptions) -> Result<Opened, IoError> {
    let context = &Context::new("folder of slices", folder).following(options);
    let (folder, draft, first) = Folder::open(folder, options, context)?;
    stack::open(folder, first.element_type(), (draft, context))
}

/// A warning if the numbers in the names have gaps.
fn gaps(files: &[PathBuf]) -> Option<String> {
    let number = |file: &PathBuf| {
        let name = file.file_stem()?.to_string_lossy().into_owned();
        let digits: String = name.chars().rev().take_while(char::is_ascii_digit).collect();
        digits.chars().rev().collect::<String>().parse::<u64>().ok()
    };
    let numbers: Option<Vec<u64>> = files.iter().map(number).collect();
    let numbers = numbers?;
    let steps: Vec<u64> = numbers
        .windows(2)
        .map(|pair| pair[1].saturating_sub(pair[0]))
        .collect();
    let usual = steps.iter().copied().min().filter(|&step| step > 0)?;
    let index = steps.iter().position(|&step| step != usual)?;
    Some(format!(
        "numbers are missing between {} and {}; slices are taken as evenly spaced",
        numbers[index],
        numbers[index + 1]
    ))
}

fn plane(path: &Path) -> Result<Plane, IoError> {
    let context = &Context::new("slice", path);
    match detect::extension(path).as_str() {
        "png" => png(path, context),
        "jpg" | "jpeg" => jpeg(path, context),
        _ => tiff::first_plane(path, context),
    }
}

fn invalid(error: impl Into<Box<dyn std::error::Error + Send + Sync>>, context: &Context<'_>) -> IoError {
    context.read(std::io::Error::new(std::io::ErrorKind::InvalidData, error))
}

/// Refuses a size that a file of this length cannot hold.
fn check(bytes: usize, length: u64, context: &Context<'_>) -> Result<(), IoError> {
    let most = length.saturating_mul(RATIO).saturating_add(SLACK);
    match bytes as u64 <= most {
        true => Ok(()),
        false => Err(context.too_small("samples", bytes as u64, most)),
    }
}

fn png(path: &Path, context: &Context<'_>) -> Result<Plane, IoError> {
    let length = Source::open(path)?.at_most();
    let file = File::open(path).map_err(|error| context.read(error))?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| invalid(error, context))?;
    let (color, depth) = reader.output_color_type();
    let bytes = reader.output_buffer_size().unwrap_or(usize::MAX);
    check(bytes, length, context)?;
    let mut data = vec![0; bytes];
    let info = reader
        .next_frame(&mut data)
        .map_err(|error| invalid(error, context))?;
    data.truncate(info.buffer_size());
    let samples = match depth {
        png::BitDepth::Sixteen => Samples::U16(
            data.chunks_exact(2)
                .map(|b| u16::from_be_bytes([b[0], b[1]]))
                .collect(),
        ),
        _ => Samples::U8(data.into()),
    };
    Ok(Plane {
        size: [info.width as usize, info.height as usize],
        components: color.samples(),
        samples,
    })
}

fn jpeg(path: &Path, context: &Context<'_>) -> Result<Plane, IoError> {
    let bytes = read_file(path, context)?;
    let mut decoder = jpeg_decoder::Decoder::new(&*bytes);
    decoder.read_info().map_err(|error| invalid(error, context))?;
    let info = decoder.info().ok_or_else(|| context.truncated("JPEG", 1, 0))?;
    let size = [usize::from(info.width), usize::from(info.height)];
    check(
        size[0] * size[1] * info.pixel_format.pixel_bytes(),
        bytes.len() as u64,
        context,
    )?;
    let data = crate::jpeg::decode(&mut decoder, context)?;
    let (components, samples) = match info.pixel_format {
        PixelFormat::L8 => (1, Samples::U8(data.into())),
        PixelFormat::RGB24 => (3, Samples::U8(data.into())),
        PixelFormat::L16 => {
            let words = data.chunks_exact(2).map(|b| u16::from_ne_bytes([b[0], b[1]]));
            (1, Samples::U16(words.collect()))
        }
        PixelFormat::CMYK32 => return Err(context.unsupported("colours for printing (CMYK)")),
    };
    Ok(Plane {
        size,
        components,
        samples,
    })
}
