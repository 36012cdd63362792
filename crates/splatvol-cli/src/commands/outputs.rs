//! The output files of `splatvol render`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use splatvol::{Frame, ImageSize, RenderStatistics};
use splatvol_io::{DepthFormat, ImageFormat, encode_depth};

use crate::args::RenderArgs;
use crate::failure::{During, Failure, Step};
use crate::output::{Target, check_distinct, encode_frame, picture_format};
use crate::terminal::Terminal;

/// The destinations of everything; checked before the work, so that a refusal costs nothing.
pub(super) struct Outputs {
    picture: Target,
    format: ImageFormat,
    depth: Option<(Target, DepthFormat)>,
    stats: Option<Target>,
}

impl Outputs {
    /// As the flags say; without a flag, the picture is named after the input.
    pub(super) fn new(args: &RenderArgs, reference: &str) -> Result<Self, Failure> {
        let picture = match &args.output {
            Some(path) => Target::new(path),
            None => Target::File(default_name(reference)),
        };
        let format = match &picture {
            Target::Stdout => ImageFormat::Png8,
            Target::File(path) => picture_format(path)?,
        };
        let stats = args.stats.as_deref().map(Target::new);
        let depth = args.depth.as_deref().map(depth_target).transpose()?;
        let mut results = vec![("picture", &picture)];
        results.extend(depth.iter().map(|(target, _)| ("depth", target)));
        results.extend(stats.iter().map(|target| ("statistics", target)));
        check_distinct(&results)?;
        for (_, target) in results {
            target.check(args.write.overwrite)?;
        }
        Ok(Self {
            picture,
            format,
            depth,
            stats,
        })
    }

    /// Format of the picture.
    pub(super) fn format(&self) -> ImageFormat {
        self.format
    }

    /// Where pictures between sheets go: beside the picture, or refused where it is no file.
    pub(super) fn partial(&self) -> Result<PathBuf, Failure> {
        match &self.picture {
            Target::File(path) => Ok(path.clone()),
            Target::Stdout => Err(Failure::usage(
                "--partial writes files beside the picture: use -o FILE",
            )),
        }
    }

    /// Writes a picture between sheets.
    pub(super) fn write_partial(
        &self,
        sheets: usize,
        frame: &Frame,
        (background, bits): (Option<[f64; 4]>, u8),
        overwrite: bool,
    ) -> Result<(), Failure> {
        let path = numbered(&self.partial()?, sheets);
        let bytes = encode_with_bits(frame, (self.format, bits), background, &[])?;
        Target::File(path).write(&bytes, overwrite)
    }

    /// The file that can take the picture in bands of rows: a PNG, without depths beside it.
    pub(super) fn banded(&self) -> Option<&Path> {
        match &self.picture {
            Target::File(path) if self.format != ImageFormat::Exr && self.depth.is_none() => Some(path),
            _ => None,
        }
    }

    /// Writes picture and depths.
    pub(super) fn write(
        &self,
        frame: &Frame,
        (background, bits): (Option<[f64; 4]>, u8),
        metadata: &[(String, String)],
        overwrite: bool,
    ) -> Result<(), Failure> {
        let bytes = encode_with_bits(frame, (self.format, bits), background, metadata)?;
        self.picture.write(&bytes, overwrite)?;
        if let Some((target, format)) = &self.depth {
            let size = frame.image.size();
            let software = [(
                "Software".to_owned(),
                concat!("splatvol ", env!("CARGO_PKG_VERSION")).to_owned(),
            )];
            let bytes = encode_depth(&frame.depth, size, *format, &software).during(Step::Output)?;
            target.write(&bytes, overwrite)?;
        }
        Ok(())
    }

    /// Writes statistics, and says that all is done.
    pub(super) fn finish(
        &self,
        statistics: &RenderStatistics,
        size: ImageSize,
        (overwrite, start): (bool, Instant),
        terminal: &Terminal,
    ) -> Result<(), Failure> {
        if let Some(stats) = &self.stats {
            let mut json = serde_json::to_string_pretty(statistics).during(Step::Output)?;
            json.push('\n');
            stats.write(json.as_bytes(), overwrite)?;
        }
        if let Target::File(path) = &self.picture {
            terminal.note(format!(
                "wrote {} ({}x{}, {:.2} s)",
                path.display(),
                size.width(),
                size.height(),
                start.elapsed().as_secs_f64()
            ));
        }
        Ok(())
    }
}

/// `head.0012.png` for `head.png`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    path.with_extension(format!("{number:04}.{extension}"))
}

/// A frame as a picture file with this many bits per channel.
pub(super) fn encode_with_bits(
    frame: &Frame,
    (format, bits): (ImageFormat, u8),
    background: Option<[f64; 4]>,
    metadata: &[(String, String)],
) -> Result<Vec<u8>, Failure> {
    let format = match format {
        ImageFormat::Png8 if bits == 16 => ImageFormat::Png16,
        format => format,
    };
    encode_frame(frame, format, background, metadata)
}

fn depth_target(path: &Path) -> Result<(Target, DepthFormat), Failure> {
    let format = DepthFormat::from_path(path).ok_or_else(|| {
        Failure::usage(format!("{}: no depth format has this extension", path.display()))
            .hint("use .exr, .png or .npy")
    })?;
    Ok((Target::new(path), format))
}

/// `folder/scan.nii.gz` makes `scan.png`, here; `sample:head:128` makes `head.png`.
fn default_name(reference: &str) -> PathBuf {
    PathBuf::from(format!("{}.png", short_name(reference)))
}

/// `scan` for `folder/scan.nii.gz`, `head` for `sample:head:128`.
pub(super) fn short_name(reference: &str) -> String {
    match reference.strip_prefix("sample:") {
        Some(sample) => sample.split(':').next().unwrap_or(sample).to_owned(),
        None => {
            let path = Path::new(reference);
            let path = match path.extension() {
                Some(ext) if ext.eq_ignore_ascii_case("gz") => path.with_extension(""),
                _ => path.to_owned(),
            };
            path.file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_between_sheets_are_numbered() {
        assert_eq!(
            numbered(Path::new("a/b.c.png"), 12),
            PathBuf::from("a/b.c.0012.png")
        );
    }

    #[test]
    fn outputs_are_named_after_inputs_in_the_current_folder() {
        for (reference, name) in [
            ("data/scan.nii.gz", "scan.png"),
            ("a.b.nrrd", "a.b.png"),
            ("sample:head", "head.png"),
            ("sample:head:64", "head.png"),
        ] {
            assert_eq!(default_name(reference), PathBuf::from(name));
        }
    }
}
