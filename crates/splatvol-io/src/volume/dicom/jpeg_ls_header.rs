//! Segments before the scans of JPEG-LS (T.87, C.2): the frame, parameters, and which components a scan holds.

use super::jpeg_ls_context::Parameters;
use crate::IoError;
use crate::error::Context;

/// How the components of a scan alternate (`ILV`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interleave {
    /// One component.
    None,
    Line,
    Sample,
}

/// A scan, as its segment and those before it describe it.
#[derive(Debug)]
pub(super) struct ScanHeader {
    pub(super) parameters: Parameters,
    pub(super) interleave: Interleave,
    /// Places of the scan's components in the frame.
    pub(super) components: Vec<usize>,
}

/// Walks over the segments of a file.
pub(super) struct Segments<'a, 'b> {
    coded: &'a [u8],
    /// The next segment's place.
    pub(super) at: usize,
    /// Columns, rows and components that are expected.
    size: [usize; 3],
    context: &'a Context<'b>,
    /// Largest sample, by the frame's precision.
    largest: Option<i32>,
    /// Names of the components, in their order.
    names: Vec<u8>,
    presets: [i32; 5],
}

impl<'a, 'b> Segments<'a, 'b> {
    /// `size` is columns, rows and components.
    pub(super) fn new(coded: &'a [u8], size: [usize; 3], context: &'a Context<'b>) -> Self {
        Self {
            coded,
            at: 2,
            size,
            context,
            largest: None,
            names: Vec::new(),
            presets: [0; 5],
        }
    }

    fn cut(&self) -> IoError {
        let length = self.coded.len() as u64;
        self.context.truncated("JPEG-LS header", length + 1, length)
    }

    fn short(&self, bytes: &[u8], at: usize) -> Result<i32, IoError> {
        let pair = bytes.get(at..at + 2).ok_or_else(|| self.cut())?;
        Ok(i32::from(u16::from_be_bytes([pair[0], pair[1]])))
    }

    /// Reads up to the next scan; its first byte is then at `at`.
    pub(super) fn next_scan(&mut self) -> Result<ScanHeader, IoError> {
        loop {
            let marker = self.short(self.coded, self.at)?;
            let length = self.short(self.coded, self.at + 2)?.max(2) as usize;
            let body = self.coded.get(self.at + 4..self.at + 2 + length);
            let body = body.ok_or_else(|| self.cut())?;
            self.at += 2 + length;
            match marker {
                0xfff7 => self.frame(body)?,
                // Presets: largest value, three thresholds, reset; 0 leaves the default.
                0xfff8 if body.first() == Some(&1) => {
                    for i in 0..self.presets.len() {
                        self.presets[i] = self.short(body, 1 + 2 * i)?;
                    }
                }
                0xffda => return self.scan(body),
                0xfff8 | 0xffdd => return Err(self.context.unsupported("JPEG-LS with tables or restarts")),
                // HP's colour transformations, which are no part of the standard.
                0xffe8 if body.starts_with(b"mrfx") && body.get(4) != Some(&0) => {
                    return Err(self
                        .context
                        .unsupported("JPEG-LS with transformed colours (`mrfx`)"));
                }
                marker if marker >= 0xff00 => {}
                marker => {
                    let shown = format!("{marker:#x}");
                    let expected = "a marker (0xff..)";
                    return Err(self.context.field("JPEG-LS marker", shown, None, expected));
                }
            }
        }
    }

    /// The frame: precision, rows, columns, components with their sampling.
    fn frame(&mut self, body: &[u8]) -> Result<(), IoError> {
        let precision = body.first().copied().unwrap_or(0);
        let [columns, rows, components] = self.size;
        let found = [self.short(body, 3)? as usize, self.short(body, 1)? as usize];
        let count = body.get(5).copied().map_or(0, usize::from);
        let described = body.get(6..6 + 3 * count).ok_or_else(|| self.cut())?;
        let whole = described.chunks_exact(3).all(|component| component[1] == 0x11);
        if !(2..=16).contains(&precision) || count != components || components > 1 && !whole {
            let what =
                format!("JPEG-LS of {precision} bits and {count} components, or of fewer samples in some");
            return Err(self.context.unsupported(what));
        }
        if found != [columns, rows] {
            let shown = format!("{} x {}", found[0], found[1]);
            let expected = format!("{columns} x {rows}, as the header has it");
            let field = "size of the compressed image";
            return Err(self.context.field(field, shown, None, expected));
        }
        self.names = described.chunks_exact(3).map(|component| component[0]).collect();
        self.largest = Some((1 << precision) - 1);
        Ok(())
    }

    /// The scan: components and their tables, near, interleave.
    fn scan(&self, body: &[u8]) -> Result<ScanHeader, IoError> {
        let largest = self.largest.ok_or_else(|| self.cut())?;
        let count = body.first().copied().map_or(0, usize::from);
        let Some((described, &[near, interleave, ..])) =
            body.get(1..).and_then(|rest| rest.split_at_checked(2 * count))
        else {
            return Err(self.cut());
        };
        let place = |name: u8| self.names.iter().position(|&other| other == name);
        let components: Option<Vec<usize>> = described.chunks_exact(2).map(|pair| place(pair[0])).collect();
        let components = components.unwrap_or_default();
        let interleave = match (interleave, components.len()) {
            (_, 1) => Interleave::None,
            (1, 2..) => Interleave::Line,
            (2, 2..) => Interleave::Sample,
            _ => {
                let shown = format!("{interleave} for {count} components");
                let expected = "0 for one, 1 or 2 for several of the frame's";
                return Err(self.context.field("JPEG-LS interleave", shown, None, expected));
            }
        };
        let tables = described.chunks_exact(2).any(|pair| pair[1] != 0);
        if tables {
            return Err(self.context.unsupported("JPEG-LS with tables or restarts"));
        }
        Ok(ScanHeader {
            parameters: self.parameters(largest, near.into())?,
            interleave,
            components,
        })
    }

    fn parameters(&self, largest: i32, near: i32) -> Result<Parameters, IoError> {
        let [max_value, thresholds @ .., reset] = self.presets;
        let max_value = if max_value == 0 { largest } else { max_value };
        let mut parameters = Parameters::new(max_value, near);
        for (threshold, preset) in parameters.thresholds.iter_mut().zip(thresholds) {
            if preset != 0 {
                *threshold = preset;
            }
        }
        if reset != 0 {
            parameters.reset = reset;
        }
        if max_value > largest || near > 255.min(max_value / 2) || parameters.reset < 3 {
            let shown = format!("{max_value}, {near}, {}", parameters.reset);
            let field = "JPEG-LS MAXVAL, NEAR, RESET";
            return Err(self.context.field(field, shown, None, "values that T.87 allows"));
        }
        Ok(parameters)
    }
}
