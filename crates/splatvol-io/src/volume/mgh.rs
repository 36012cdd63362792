//! FreeSurfer's MGH and, compressed by gzip, MGZ
//! (<https://surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/MghFormat>): big-endian, one time point after the other.
//!
//! World is RAS+ by definition: `world = D S (voxel - dims / 2) + c`, with D the directions of the axes, S the spacing
//! and c the centre.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::LengthUnit;

use super::data_files::DataFiles;
use super::stored::{Encoding, FromStored, Layout, Selection, Stored};
use super::{Description, Draft, ReadOptions, axis_codes, checked_dims, choose_time};
use crate::error::Context;
use crate::source::{Codec, Source};
use crate::{Endian, IoError, SampleType};

/// Bytes before the samples.
const HEADER: usize = 284;

/// Reads a file.
///
/// # Errors
/// See [`IoError`].
pub(super) fn read<T: FromStored>(path: &Path, options: &ReadOptions) -> Result<T, IoError> {
    let context = &Context::new("MGH", path);
    let mut source = Source::open(path)?;
    let compressed = source.peek(context)?.starts_with(&[0x1f, 0x8b]);
    if compressed {
        source = source.inflate(Codec::Gzip);
    }
    let mut bytes = [0; HEADER];
    let found = source.fill(&mut bytes, context)?;
    if found < HEADER {
        return Err(context.truncated("header", HEADER as u64, found as u64));
    }
    let header = Header {
        bytes: &bytes,
        context,
    };
    let sample_type = header.sample_type()?;
    let sizes = [4, 8, 12].map(|at| i64::from(header.int(at)));
    let dims = checked_dims(&sizes, "width, height, depth", 4, context)?;
    let frames = usize::try_from(header.int(16)).unwrap_or(0);
    if frames == 0 {
        return Err(context.field("nframes", header.int(16), 16, "a positive number"));
    }
    let time = choose_time(frames, options, context)?;
    let mut draft = Draft::new(dims, Description::default());
    draft.world_from_voxel = header.world_from_voxel(dims, context)?;
    draft.unit = LengthUnit::Millimetre;
    let codes = axis_codes(&draft.grid(context)?);
    let coding = if compressed { "gzip" } else { "raw" };
    draft.description = Description {
        format: if compressed { "MGZ" } else { "MGH" }.to_owned(),
        stored_type: format!("{}, big-endian, {coding}", sample_type.name()),
        orientation: match header.placed() {
            true => format!("voxel axes {codes}; RAS+ as stored"),
            false => "not in the file; coronal slices (LIA), as FreeSurfer takes it".to_owned(),
        },
        // Without directions, FreeSurfer's convention is part of the format.
        oriented: true,
        files: vec![path.to_owned()],
        ..Description::default()
    };
    draft.set_times(frames, options);
    let stored = Stored {
        layout: Layout {
            half: false,
            sample_type,
            endian: Endian::Big,
            // The source is decompressed and at the samples already.
            encoding: Encoding::Raw,
            skip_lines: 0,
            skip_bytes: Some(0),
            start: HEADER as u64,
        },
        selection: Selection {
            dims,
            components: 1,
            component: 0,
            volumes: frames,
            times: frames,
            volume: time,
        },
        // Parameters of the scan may follow.
        files: DataFiles::attached("data").followed(),
    };
    T::from_stored(&stored, source, draft, (options, context))
}

struct Header<'a> {
    bytes: &'a [u8; HEADER],
    context: &'a Context<'a>,
}

impl Header<'_> {
    fn int(&self, at: usize) -> i32 {
        i32::from_be_bytes([
            self.bytes[at],
            self.bytes[at + 1],
            self.bytes[at + 2],
            self.bytes[at + 3],
        ])
    }

    fn vector(&self, at: usize) -> DVec3 {
        let float = |i: usize| f64::from(f32::from_bits(self.int(at + 4 * i) as u32));
        DVec3::new(float(0), float(1), float(2))
    }

    /// Whether the file gives an orientation.
    fn placed(&self) -> bool {
        self.bytes[28..30] != [0, 0]
    }

    fn sample_type(&self) -> Result<SampleType, IoError> {
        if self.int(0) != 1 {
            return Err(self.context.field("version", self.int(0), 0, "1"));
        }
        Ok(match self.int(20) {
            0 => SampleType::U8,
            1 => SampleType::I32,
            3 => SampleType::F32,
            4 => SampleType::I16,
            10 => SampleType::U16,
            other => return Err(self.context.field("type", other, 20, "0, 1, 3, 4 or 10")),
        })
    }

    fn world_from_voxel(&self, dims: [usize; 3], context: &Context<'_>) -> Result<DAffine3, IoError> {
        let (spacing, axes, centre) = match self.placed() {
            true => (
                self.vector(30),
                [42, 54, 66].map(|at| self.vector(at)),
                self.vector(78),
            ),
            false => (DVec3::ONE, [-DVec3::X, -DVec3::Z, DVec3::Y], DVec3::ZERO),
        };
        if !spacing.is_finite() || !centre.is_finite() || !axes.iter().all(|axis| axis.is_finite()) {
            let expected = "finite numbers";
            return Err(context.field("delta, Mdc, Pxyz_c", format!("{spacing} {centre}"), 30, expected));
        }
        let matrix = DMat3::from_cols(axes[0], axes[1], axes[2]) * DMat3::from_diagonal(spacing);
        let half = DVec3::from_array(dims.map(|size| size as f64 / 2.0));
        Ok(DAffine3::from_mat3_translation(matrix, centre - matrix * half))
    }
}
