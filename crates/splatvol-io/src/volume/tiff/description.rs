//! Mapping of pages to slices, channels and time points: by ImageJ's description, OME's, or none.
//!
//! ImageJ's is lines `key=value`: `images`, `channels`, `slices`, `frames`, `spacing` (between slices), `unit`.
//! Channels vary fastest, then slices, then frames; lengths of pixels are the inverse of the resolution tags.

use std::path::PathBuf;

use glam::DVec3;
use splatvol_scene::LengthUnit;

use super::ome;
use crate::IoError;
use crate::error::Context;
use crate::tiff_pages::Pages;
use crate::volume::{ReadOptions, length_unit};

/// Channels of spectral cameras are hundreds.
const MOST_CHANNELS: usize = 4096;

/// Index of the opened file in [`Layout::files`].
pub(super) const OWN_FILE: usize = 0;

/// A page: an index into [`Layout::files`], and the page's number there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) file: usize,
    pub(super) page: usize,
}

impl Place {
    /// A page of the opened file.
    pub(super) fn own(page: usize) -> Self {
        Self { file: OWN_FILE, page }
    }
}

/// The arrangement of a file's pages.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) format: &'static str,
    pub(super) orientation: &'static str,
    pub(super) slices: usize,
    /// Names of the channels; one even if the file names none.
    pub(super) channels: Vec<String>,
    pub(super) times: usize,
    /// Page of every slice, channel and time: slices fastest, then channels.
    pub(super) pages: Vec<Place>,
    /// The opened file, and others that hold pages.
    pub(super) files: Vec<PathBuf>,
    /// True where pages follow the first without headers of their own.
    pub(super) contiguous: bool,
    pub(super) spacing: DVec3,
    pub(super) unit: LengthUnit,
    pub(super) series: Vec<String>,
    pub(super) warnings: Vec<String>,
}

impl Layout {
    /// The layout of `count` pages from the text of the first.
    pub(super) fn new(
        text: Option<&str>,
        count: usize,
        pages: &Pages,
        options: &ReadOptions,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let mut layout = match text.map(str::trim_start) {
            Some(text) if text.starts_with("ImageJ=") => Self::imagej(text, count, pages, context),
            Some(text) if text.starts_with('<') && text.contains("<OME") => {
                ome::layout(text, count, options, context)
            }
            _ => Ok(Self::plain(count)),
        }?;
        layout.files.insert(OWN_FILE, context.path.to_owned());
        Ok(layout)
    }

    /// One page after the other.
    pub(super) fn plain(count: usize) -> Self {
        Self {
            format: "TIFF",
            orientation: "no geometry in the file, spacing 1",
            slices: count,
            channels: vec!["0".to_owned()],
            times: 1,
            pages: (0..count).map(Place::own).collect(),
            files: Vec::new(),
            contiguous: false,
            spacing: DVec3::ONE,
            unit: LengthUnit::Unknown,
            series: Vec::new(),
            warnings: Vec::new(),
        }
    }

    pub(super) fn page(&self, slice: usize, channel: usize, time: usize) -> Place {
        self.pages[slice + self.slices * (channel + self.channels.len() * time)]
    }

    fn imagej(text: &str, count: usize, pages: &Pages, context: &Context<'_>) -> Result<Self, IoError> {
        let value = |key: &str| {
            let pairs = text.lines().filter_map(|line| line.trim().split_once('='));
            pairs.rev().find(|(name, _)| *name == key).map(|(_, value)| value)
        };
        let number = |key: &str| -> Result<Option<usize>, IoError> {
            let Some(value) = value(key) else { return Ok(None) };
            let number = value
                .parse()
                .ok()
                .filter(|&number: &usize| number > 0 && number as u64 <= 1 << 32);
            let bad = || context.field(format!("ImageJ {key}"), value, None, "a positive number");
            number.map(Some).ok_or_else(bad)
        };
        let images = number("images")?.unwrap_or(count);
        let channels = number("channels")?.unwrap_or(1);
        let times = number("frames")?.unwrap_or(1);
        let rest = images / channels.saturating_mul(times).max(1);
        let slices = number("slices")?.unwrap_or(rest.max(1));
        let total = channels
            .checked_mul(slices)
            .and_then(|product| product.checked_mul(times));
        let contiguous = count == 1 && images > 1;
        // Each page takes a byte of the file at least.
        let most = if contiguous {
            pages.length().min(images as u64)
        } else {
            count as u64
        };
        if total.is_none_or(|total| total as u64 > most) {
            let shown = format!("{channels} x {slices} x {times}");
            let expected = format!("channels, slices and frames for {most} pages");
            return Err(context.field("ImageJ channels, slices, frames", shown, None, expected));
        }
        if channels > MOST_CHANNELS {
            let expected = format!("at most {MOST_CHANNELS}");
            return Err(context.field("ImageJ channels", channels, None, expected));
        }
        let mut layout = Self::plain(1);
        layout.format = "TIFF (ImageJ)";
        layout.slices = slices;
        layout.times = times;
        layout.contiguous = contiguous;
        layout.channels = (0..channels)
            .map(|channel| format!("channel {channel}"))
            .collect();
        let of_time = |time| move |channel| move |slice| (time * slices + slice) * channels + channel;
        layout.pages = (0..times)
            .flat_map(|time| (0..channels).map(of_time(time)))
            .flat_map(|page| (0..slices).map(page))
            .map(Place::own)
            .collect();
        layout.calibrate(value("unit"), value("spacing"), pages, context);
        Ok(layout)
    }

    /// Spacing by ImageJ's unit. ImageJ writes "inch" or "pixel" if nobody has calibrated anything.
    fn calibrate(&mut self, unit: Option<&str>, spacing: Option<&str>, pages: &Pages, context: &Context<'_>) {
        let unit = unit.unwrap_or_default().replace("\\u00B5", "µ");
        let between = spacing.and_then(|spacing| spacing.parse::<f64>().ok());
        let between = between
            .map(f64::abs)
            .filter(|spacing| spacing.is_finite() && *spacing > 0.0);
        let known = if unit == "cm" {
            Some(LengthUnit::Millimetre)
        } else {
            length_unit(&unit)
        };
        let scale = if unit == "cm" { 10.0 } else { 1.0 };
        match known {
            Some(unit) if unit != LengthUnit::Unknown => {
                let [x, y] = pages.resolution(context);
                let x = x.unwrap_or(1.0);
                self.spacing = DVec3::new(x, y.unwrap_or(x), between.unwrap_or(x)) * scale;
                self.unit = unit;
                self.orientation = "spacing of ImageJ; the file does not say how an object lies";
            }
            _ => self.spacing.z = between.unwrap_or(1.0),
        }
    }
}
