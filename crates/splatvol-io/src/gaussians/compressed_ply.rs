//! The compressed `.ply` of `PlayCanvas`: numbers relative to the bounds of chunks of 256 Gaussians.
//!
//! Element `chunk` has the bounds of means, of logarithms of scales, and in later versions of colours (else 0..1).
//! Element `vertex` has four words: `packed_position` and `packed_scale` (x in the upper 11 bits, y in 10, z in 11),
//! `packed_rotation` (upper 2 bits: which of w x y z is largest and left out; the others in 10 bits each, times
//! sqrt(2)), `packed_color` (red, green, blue, opacity from the upper byte). Element `sh`, if there is one, has
//! `f_rest_*` by colour in bytes, -4..4.

use std::path::Path;

use super::LoadedGaussians;
use super::collect::{Collector, Splat, harmonics_of_color, with_largest};
use super::frame::{self, RDF};
use crate::error::Context;
use crate::ply::{Header, Reader, Table};
use crate::source::Source;
use crate::{IoError, ReadOptions};

/// Gaussians per chunk.
const CHUNK: usize = 256;
const WORDS: [&str; 4] = [
    "packed_position",
    "packed_rotation",
    "packed_scale",
    "packed_color",
];

/// True if the vertices are packed words.
pub(super) fn is_compressed(header: &Header) -> bool {
    header
        .element("vertex")
        .is_some_and(|vertex| vertex.has("packed_position"))
}

/// Three numbers of 0..1, from 11, 10 and 11 bits.
fn unpack_11_10_11(word: u32) -> [f64; 3] {
    [
        f64::from(word >> 21) / 2047.0,
        f64::from((word >> 11) & 1023) / 1023.0,
        f64::from(word & 2047) / 2047.0,
    ]
}

/// Quaternion x y z w.
fn unpack_rotation(word: u32) -> [f64; 4] {
    let part = |shift: u32| (f64::from((word >> shift) & 1023) / 1023.0 - 0.5) * std::f64::consts::SQRT_2;
    let [w, x, y, z] = with_largest((word >> 30) as usize, [part(20), part(10), part(0)]);
    [x, y, z, w]
}

/// A harmonic of 0..255: the ends are those of -4..4, the others are the middles of their steps.
fn unpack_harmonic(byte: f64) -> f32 {
    let unit = match byte {
        0.0 => 0.0,
        255.0 => 1.0,
        _ => (byte + 0.5) / 256.0,
    };
    ((unit - 0.5) * 8.0) as f32
}

/// Bounds of three numbers in every chunk.
struct Bounds<'a> {
    min: [&'a [f64]; 3],
    max: [&'a [f64]; 3],
}

impl<'a> Bounds<'a> {
    fn new(chunks: &'a Table, names: [&str; 3]) -> Option<Self> {
        let columns = |end: &str| {
            let column = |name: &str| chunks.column(&format!("{end}_{name}"));
            Some([column(names[0])?, column(names[1])?, column(names[2])?])
        };
        Some(Self {
            min: columns("min")?,
            max: columns("max")?,
        })
    }

    fn at(&self, chunk: usize, unit: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.min[i][chunk] * (1.0 - unit[i]) + self.max[i][chunk] * unit[i])
    }
}

struct Chunks<'a> {
    means: Bounds<'a>,
    scales: Bounds<'a>,
    colors: Option<Bounds<'a>>,
}

impl Chunks<'_> {
    fn unpack(&self, index: usize, words: [u32; 4]) -> (Splat, [f32; 3]) {
        let chunk = index / CHUNK;
        let [position, rotation, scale, color] = words;
        let [red, green, blue, opacity] = color.to_be_bytes().map(|byte| f64::from(byte) / 255.0);
        let color = [red, green, blue];
        let splat = Splat {
            mean: self.means.at(chunk, unpack_11_10_11(position)),
            scale: self.scales.at(chunk, unpack_11_10_11(scale)).map(f64::exp),
            rotation: unpack_rotation(rotation),
            opacity,
        };
        let color = self
            .colors
            .as_ref()
            .map_or(color, |bounds| bounds.at(chunk, color));
        (splat, harmonics_of_color(color))
    }
}

/// Degree of the harmonics of the element `sh`.
fn degree(header: &Header, vertices: u64, context: &Context<'_>) -> Result<u32, IoError> {
    let Some(sh) = header.element("sh") else {
        return Ok(0);
    };
    if sh.count != vertices {
        let expected = format!("{vertices} rows, as many as vertices");
        return Err(context.field("element sh", sh.count, None, expected));
    }
    match sh.properties.len() {
        9 => Ok(1),
        24 => Ok(2),
        45 => Ok(3),
        other => Err(context.field("properties of element sh", other, None, "9, 24 or 45")),
    }
}

/// Reads a compressed `.ply`.
///
/// # Errors
/// Missing elements or properties, chunks that do not fit the vertices, rows cut short.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<LoadedGaussians, IoError> {
    let context = &Context::new("compressed PLY", path);
    let mut reader = Reader::new(Source::open(path)?, *context)?;
    let header = reader.header().clone();
    let (Some(vertex), Some(chunk)) = (header.element("vertex"), header.element("chunk")) else {
        return Err(context.field("element", "(absent)", None, "elements \"chunk\" and \"vertex\""));
    };
    if chunk.count != vertex.count.div_ceil(CHUNK as u64) {
        let expected = format!(
            "{}, for {} vertices",
            vertex.count.div_ceil(CHUNK as u64),
            vertex.count
        );
        return Err(context.field("element chunk", chunk.count, None, expected));
    }
    let degree = degree(&header, vertex.count, context)?;
    let mut collector = Collector::new(vertex.count, degree, options, context)?;
    collector.description.format = "compressed PLY (3-D Gaussians)".to_owned();
    collector.description.stored_type = format!("{}, {} chunks", header.encoding.name(), chunk.count);
    collector.description.orientation = frame::describe(RDF);

    let named = |names: [&str; 3]| names.map(|n| [format!("min_{n}"), format!("max_{n}")]).concat();
    let mut columns = named(["x", "y", "z"]);
    columns.extend(named(["scale_x", "scale_y", "scale_z"]));
    if chunk.has("min_r") {
        columns.extend(named(["r", "g", "b"]));
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let table = reader.table("chunk", &columns)?;
    let bounds = |names| {
        Bounds::new(&table, names)
            .ok_or_else(|| context.field("element chunk", "(absent)", None, "minima and maxima"))
    };
    let chunks = Chunks {
        means: bounds(["x", "y", "z"])?,
        scales: bounds(["scale_x", "scale_y", "scale_z"])?,
        colors: chunk.has("min_r").then(|| bounds(["r", "g", "b"])).transpose()?,
    };

    let mut packed: Vec<[u32; 4]> = Vec::new();
    reader.rows("vertex", &WORDS, |_, row| {
        packed.push(std::array::from_fn(|i| row[i] as u32));
        Ok(())
    })?;
    if degree == 0 {
        for (index, words) in packed.iter().enumerate() {
            let (splat, color) = chunks.unpack(index, *words);
            collector.push(&splat, &[color]);
        }
    } else {
        read_with_harmonics(&mut reader, &packed, &chunks, &mut collector)?;
    }
    match reader.excess()? {
        0 => {}
        excess => collector.warn(format!("{excess} bytes follow the last element")),
    }
    collector.finish(frame::world_from_local(RDF), context)
}

fn read_with_harmonics(
    reader: &mut Reader<'_>,
    packed: &[[u32; 4]],
    chunks: &Chunks<'_>,
    collector: &mut Collector,
) -> Result<(), IoError> {
    let rest = super::harmonics::harmonics_count(collector.degree()) - 1;
    let names: Vec<String> = (0..3 * rest).map(|i| format!("f_rest_{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut harmonics = vec![[0.0; 3]; rest + 1];
    reader.rows("sh", &names, |index, row| {
        let index = index as usize;
        let (splat, color) = chunks.unpack(index, packed[index]);
        harmonics[0] = color;
        for (k, triple) in harmonics[1..].iter_mut().enumerate() {
            *triple = std::array::from_fn(|c| unpack_harmonic(row[c * rest + k]));
        }
        collector.push(&splat, &harmonics);
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_unpack_to_the_ends_of_their_ranges() {
        assert_eq!(unpack_11_10_11(u32::MAX), [1.0; 3]);
        assert_eq!(unpack_11_10_11(2047), [0.0, 0.0, 1.0]);
        assert_eq!(unpack_11_10_11(1023 << 11), [0.0, 1.0, 0.0]);
        for largest in 0..4u32 {
            // 512 / 1023 is nearest to zero.
            let rotation = unpack_rotation((largest << 30) | (512 << 20) | (512 << 10) | 512);
            let place = [3, 0, 1, 2][largest as usize];
            assert!((rotation[place] - 1.0).abs() < 1e-5, "{rotation:?}");
        }
        assert_eq!((unpack_harmonic(0.0), unpack_harmonic(255.0)), (-4.0, 4.0));
        assert!((unpack_harmonic(128.0)).abs() < 0.02);
    }
}
