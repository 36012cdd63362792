//! `.ksplat` (Mark Kellogg, `GaussianSplats3D`, `SplatBuffer.js`), version 0.1.
//!
//! A header of 4096 bytes, headers of 1024 bytes for each section, then the sections' data: sizes of partly filled
//! buckets, centres of buckets, Gaussians. Level 0 of compression has floats; level 1 has half floats and means in 16
//! bits relative to the centre of a bucket; level 2 has bytes for harmonics, too. Harmonics are grouped by degree, in
//! each by colour.

use std::path::Path;

use half::f16;

use super::LoadedGaussians;
use super::collect::{Collector, Splat, harmonics_of_color};
use super::fields::Fields;
use super::frame::{self, RDF};
use super::harmonics::harmonics_count;
use crate::error::Context;
use crate::source::read_file;
use crate::{IoError, ReadOptions};

const HEADER: u64 = 4096;
const SECTION_HEADER: u64 = 1024;

/// Number formats at a level of compression.
struct Level {
    number: u16,
    /// Bytes of a mean's coordinate, and of each number of scales and rotations.
    bytes: u64,
    harmonic_bytes: u64,
    /// Bounds of harmonics in bytes.
    harmonics: [f32; 2],
}

impl Level {
    /// Bytes before the colour: mean, scales, rotation.
    fn color_offset(&self) -> u64 {
        10 * self.bytes
    }

    fn number(&self, fields: &Fields<'_>, offset: u64) -> Result<f64, IoError> {
        Ok(match self.number {
            0 => f64::from(fields.f32(offset)?),
            _ => f16::from_bits(fields.u16(offset)?).to_f64(),
        })
    }

    fn harmonic(&self, fields: &Fields<'_>, offset: u64) -> Result<f32, IoError> {
        let [min, max] = self.harmonics;
        Ok(match self.number {
            0 => fields.f32(offset)?,
            1 => f16::from_bits(fields.u16(offset)?).to_f32(),
            _ => min + f32::from(fields.u8(offset)?) / 255.0 * (max - min),
        })
    }
}

/// A section's header.
struct Section {
    count: u64,
    capacity: u64,
    bucket_capacity: u64,
    bucket_count: u64,
    block_size: f64,
    bucket_bytes: u64,
    range: f64,
    full_buckets: u64,
    partial_buckets: u64,
    degree: u32,
}

impl Section {
    fn new(fields: &Fields<'_>, at: u64, level: &Level) -> Result<Self, IoError> {
        let number = |offset| fields.u32(at + offset).map(u64::from);
        let degree = u32::from(fields.u16(at + 40)?);
        if degree > 3 {
            let expected = "a degree of 0 to 3";
            return Err(fields
                .context
                .field("sphericalHarmonicsDegree", degree, at + 40, expected));
        }
        let range = match number(24)? {
            0 if level.number == 0 => 1.0,
            0 => 32767.0,
            range => range as f64,
        };
        Ok(Self {
            count: number(0)?,
            capacity: number(4)?,
            bucket_capacity: number(8)?,
            bucket_count: number(12)?,
            block_size: f64::from(fields.f32(at + 16)?),
            bucket_bytes: u64::from(fields.u16(at + 20)?),
            range,
            full_buckets: number(32)?,
            partial_buckets: number(36)?,
            degree,
        })
    }

    fn splat_bytes(&self, level: &Level) -> u64 {
        let harmonics = 3 * (harmonics_count(self.degree) as u64 - 1);
        level.color_offset() + 4 + harmonics * level.harmonic_bytes
    }

    fn buckets_bytes(&self) -> u64 {
        self.bucket_bytes * self.bucket_count + 4 * self.partial_buckets
    }

    /// The bytes of the section, its capacity not its count.
    fn bytes(&self, level: &Level) -> u64 {
        let splats = self.splat_bytes(level).saturating_mul(self.capacity);
        self.buckets_bytes().saturating_add(splats)
    }
}

/// Buckets in the order of their Gaussians.
struct Buckets {
    index: u64,
    end: u64,
}

impl Buckets {
    /// The bucket of a Gaussian; indices come in ascending order.
    fn of(&mut self, index: u64, section: &Section, fields: &Fields<'_>, at: u64) -> Result<u64, IoError> {
        let full = section.full_buckets.saturating_mul(section.bucket_capacity);
        if index < full {
            return Ok(index / section.bucket_capacity);
        }
        while index >= full + self.end {
            if self.index >= section.partial_buckets {
                let expected = "buckets for all Gaussians of the section";
                return Err(fields
                    .context
                    .field("partiallyFilledBucketCount", self.index, at, expected));
            }
            self.end += u64::from(fields.u32(at + 4 * self.index)?);
            self.index += 1;
        }
        Ok(section.full_buckets + self.index - 1)
    }
}

/// Reads a `.ksplat`.
///
/// # Errors
/// Another version, unknown compression, sections that do not fit the file.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new(".ksplat", path);
    let bytes = read_file(path, context)?;
    let fields = &Fields {
        bytes: &bytes,
        what: "sections",
        context,
    };
    fields.slice(0, HEADER)?;
    let version = (fields.u8(0)?, fields.u8(1)?);
    if version != (0, 1) {
        let found = format!("{}.{}", version.0, version.1);
        return Err(context.field("version", found, 0, "0.1"));
    }
    let level = Level::read(fields)?;
    let section_count = u64::from(fields.u32(4)?);
    fields.slice(HEADER, section_count * SECTION_HEADER)?;
    let header = |index| Section::new(fields, HEADER + index * SECTION_HEADER, &level);
    let mut degree = 0;
    let mut count = 0u64;
    let mut end = HEADER + section_count * SECTION_HEADER;
    for index in 0..section_count {
        let section = header(index)?;
        if section.count > section.capacity {
            let expected = format!("at most {}, the section's capacity", section.capacity);
            return Err(context.field("splatCount", section.count, None, expected));
        }
        fields.slice(end, section.bytes(&level))?;
        end += section.bytes(&level);
        count += section.count;
        degree = degree.max(section.degree);
    }
    let mut collector = Collector::new(count, degree, options, context)?;
    collector.description.format = ".ksplat 0.1".to_owned();
    collector.description.stored_type =
        format!("compression level {}, {section_count} sections", level.number);
    collector.description.orientation = frame::describe(RDF);
    let mut at = HEADER + section_count * SECTION_HEADER;
    for index in 0..section_count {
        let section = header(index)?;
        read_section(fields, at, &section, &level, &mut collector)?;
        at += section.bytes(&level);
    }
    collector.finish(frame::world_from_local(RDF), context)
}

impl Level {
    fn read(fields: &Fields<'_>) -> Result<Self, IoError> {
        let number = fields.u16(20)?;
        if number > 2 {
            return Err(fields
                .context
                .field("compressionLevel", number, 20, "a level of 0 to 2"));
        }
        let bound = |offset, otherwise| {
            let bound = fields.f32(offset)?;
            Ok::<_, IoError>(if bound == 0.0 { otherwise } else { bound })
        };
        Ok(Self {
            number,
            bytes: if number == 0 { 4 } else { 2 },
            harmonic_bytes: [4, 2, 1][usize::from(number)],
            harmonics: [bound(36, -1.5)?, bound(40, 1.5)?],
        })
    }
}

fn read_section(
    fields: &Fields<'_>,
    at: u64,
    section: &Section,
    level: &Level,
    collector: &mut Collector,
) -> Result<(), IoError> {
    let mut buckets = Buckets { index: 0, end: 0 };
    let stride = section.splat_bytes(level);
    let step = section.block_size / 2.0 / section.range;
    let rest = harmonics_count(section.degree) - 1;
    let mut harmonics = vec![[0.0; 3]; rest + 1];
    for index in 0..section.count {
        let place = at + section.buckets_bytes() + index * stride;
        let mut mean = [0.0; 3];
        if level.number > 0 {
            let bucket = buckets.of(index, section, fields, at)?;
            let centre = at + 4 * section.partial_buckets + bucket * section.bucket_bytes;
            for (axis, coordinate) in (0..).zip(&mut mean) {
                let offset = f64::from(fields.u16(place + 2 * axis)?) - section.range;
                *coordinate = offset * step + f64::from(fields.f32(centre + 4 * axis)?);
            }
        }
        let number = |i: u64| level.number(fields, place + i * level.bytes);
        if level.number == 0 {
            mean = [number(0)?, number(1)?, number(2)?];
        }
        let color = place + level.color_offset();
        let byte = |i| fields.u8(color + i).map(|byte| f64::from(byte) / 255.0);
        let splat = Splat {
            mean,
            scale: [number(3)?, number(4)?, number(5)?],
            rotation: [number(7)?, number(8)?, number(9)?, number(6)?],
            opacity: byte(3)?,
        };
        harmonics[0] = harmonics_of_color([byte(0)?, byte(1)?, byte(2)?]);
        for degree in 1..=section.degree as usize {
            let (first, width) = (degree * degree, 2 * degree + 1);
            for (m, triple) in harmonics[first..first + width].iter_mut().enumerate() {
                for (channel, value) in triple.iter_mut().enumerate() {
                    let number = 3 * (first - 1) + channel * width + m;
                    let offset = color + 4 + number as u64 * level.harmonic_bytes;
                    *value = level.harmonic(fields, offset)?;
                }
            }
        }
        collector.push(&splat, &harmonics);
    }
    Ok(())
}
