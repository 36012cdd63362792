//! Data in fewer bits, or of a coarser level, until they fit.
//!
//! Tried in this order, until one fits: each level of detail, the finest first, as it is, then in 16, 12 and 8 bits per number; or
//! in the bits that are asked for.
//!
//! | data | a coarser level | bits |
//! |---|---|---|
//! | a volume | half the samples along each axis | of a sample; those of integers that have no more stay what they are |
//! | points | a quarter of the points, twice the radii | eight more for a coordinate; colours stay what they are |
//! | Gaussians | harmonics of one degree less | eight more for a coordinate |
//! | a mesh | none | eight more for a coordinate |
//!
//! Names of kinds (labels) are neither averaged nor rounded. Numbers of which some are missing stay 32-bit floats.

mod clouds;
mod volumes;

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use splatvol_document::{Held, HeldContent};
use splatvol_web::{ItemData, Precision, held};

use crate::PageError;

/// Coarsest level: an eighth of the samples along each axis.
const MOST_LEVELS: usize = 4;
/// Pieces in which data are compressed: it stops at the first that does not fit.
const PIECE: usize = 1 << 16;

/// Bits per number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(into = "u8")]
pub enum Bits {
    /// 256 values.
    Eight,
    /// 4096 values.
    Twelve,
    /// 65536 values.
    Sixteen,
    /// Numbers as they are: in 32 bits, most of them.
    Own,
}

impl From<Bits> for u8 {
    fn from(bits: Bits) -> Self {
        match bits {
            Bits::Eight => 8,
            Bits::Twelve => 12,
            Bits::Sixteen => 16,
            Bits::Own => 32,
        }
    }
}

impl Bits {
    /// From the most to the least.
    pub const ALL: [Self; 4] = [Self::Own, Self::Sixteen, Self::Twelve, Self::Eight];
    /// The same without numbers as they are: for pictures that others take the place of.
    pub const ROUNDED: [Self; 3] = [Self::Sixteen, Self::Twelve, Self::Eight];

    /// Largest code of rounded numbers.
    fn largest(self) -> u16 {
        u16::MAX >> 16u8.saturating_sub(u8::from(self))
    }

    fn bytes(self) -> usize {
        usize::from(u8::from(self).div_ceil(8))
    }

    /// Bits of the numbers of clouds.
    fn precision(self) -> Precision {
        if self == Self::Own {
            return Precision::OWN;
        }
        let rest = u32::from(u8::from(self));
        Precision {
            places: rest + 8,
            rest,
        }
    }
}

/// What is made to fit.
#[derive(Debug, Clone)]
pub struct Piece {
    /// The data.
    pub content: HeldContent,
    /// Whether values are names of kinds (labels).
    pub labels: bool,
}

/// Data that fit.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The data, as the page will have them.
    pub held: Vec<Option<Held>>,
    /// What the bytes are.
    pub data: Vec<ItemData>,
    /// All packed numbers, gzip.
    pub bytes: Vec<u8>,
    /// Most bits per number.
    pub bits: Bits,
    /// Levels of detail that were left out.
    pub level: usize,
    /// Whether every number is what it was.
    pub exact: bool,
}

/// An item's data in so many bits.
struct Coded {
    content: HeldContent,
    data: ItemData,
    bytes: Vec<u8>,
    /// Whether every number is what it was.
    exact: bool,
}

/// Makes data fit into so many bytes of gzip, in the first of the given bits that do.
///
/// # Errors
/// Data that do not fit, and labels whose numbers do not.
pub fn fit(pieces: &[Piece], bits: &[Bits], most: u64) -> Result<Fitted, PageError> {
    let labels = pieces.iter().any(|piece| piece.labels);
    let mut pieces = pieces.to_vec();
    for level in 0..MOST_LEVELS {
        if level > 0 && !coarsen(&mut pieces)? {
            break;
        }
        for &bits in bits {
            if let Some(fitted) = coded(&pieces, bits, most)? {
                return Ok(Fitted {
                    level,
                    exact: fitted.exact && level == 0,
                    ..fitted
                });
            }
        }
    }
    let why = match labels {
        true => "names of kinds cannot be averaged to a coarser level".to_owned(),
        false => format!(
            "the data do not fit even at the coarsest level in {} bits",
            bits.iter().copied().map(u8::from).min().unwrap_or_default()
        ),
    };
    Err(PageError::TooLarge {
        most,
        least: most + 1,
        why,
    })
}

/// Makes all data one level coarser; says whether any of them can be. Where kinds have names, none can.
fn coarsen(pieces: &mut [Piece]) -> Result<bool, PageError> {
    if pieces.iter().any(|piece| piece.labels) {
        return Ok(false);
    }
    let mut any = false;
    for piece in pieces {
        let coarser = match &piece.content {
            HeldContent::Volume(volume) => Some(HeldContent::Volume(volumes::half(volume)?)),
            HeldContent::Points(points) => Some(HeldContent::Points(clouds::quarter(points)?)),
            HeldContent::Gaussians(gaussians) => {
                clouds::of_lower_degree(gaussians)?.map(HeldContent::Gaussians)
            }
            HeldContent::Mesh(_) => None,
        };
        if let Some(content) = coarser {
            piece.content = content;
            any = true;
        }
    }
    Ok(any)
}

/// Codes and compresses data; `None` if that takes more bytes.
fn coded(pieces: &[Piece], bits: Bits, most: u64) -> Result<Option<Fitted>, PageError> {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    let mut fitted = Fitted {
        held: Vec::new(),
        data: Vec::new(),
        bytes: Vec::new(),
        bits,
        level: 0,
        exact: true,
    };
    for piece in pieces {
        let coded = code(piece, bits)?;
        for part in coded.bytes.chunks(PIECE) {
            gzip.write_all(part)?;
            if gzip.get_ref().len() as u64 > most {
                return Ok(None);
            }
        }
        fitted.held.push(Some(held(coded.content)));
        fitted.data.push(coded.data);
        fitted.exact &= coded.exact;
    }
    fitted.bytes = gzip.finish()?;
    Ok((fitted.bytes.len() as u64 <= most).then_some(fitted))
}

/// Codes an item's data.
fn code(piece: &Piece, bits: Bits) -> Result<Coded, PageError> {
    if let HeldContent::Volume(volume) = &piece.content {
        return volumes::code(volume, bits, piece.labels);
    }
    let (data, bytes) = ItemData::pack(&piece.content, bits.precision());
    let content: HeldContent = data.unpack(&mut &bytes[..])?.into();
    Ok(Coded {
        exact: clouds::are_equal(&content, &piece.content),
        content,
        data,
        bytes,
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, Vec3};
    use splatvol::volume::Samples;
    use splatvol::{Grid, LengthUnit, PointAttributes, Points, Rescale, Volume};

    use super::*;

    /// What is fitted: one volume.
    fn of(volume: &Arc<Volume>, labels: bool) -> [Piece; 1] {
        let content = HeldContent::Volume(Arc::clone(volume));
        [Piece { content, labels }]
    }

    /// The volume that was fitted.
    fn fitted_volume(fitted: &Fitted) -> &Arc<Volume> {
        match fitted.held[0].as_ref().map(Held::content) {
            Some(HeldContent::Volume(volume)) => volume,
            other => panic!("{other:?} is no volume"),
        }
    }

    /// The type of its samples.
    fn sample_type(fitted: &Fitted) -> &str {
        match &fitted.data[0] {
            ItemData::Volume(data) => &data.sample_type,
            other => panic!("{other:?} is no volume"),
        }
    }

    fn volume(samples: Samples) -> Arc<Volume> {
        let grid = Grid::centred([8, 8, 4], [1.0; 3]).unwrap();
        Arc::new(Volume::new(grid, samples, Rescale::default(), LengthUnit::Millimetre).unwrap())
    }

    /// Largest difference of the values of volumes on one grid, data units.
    fn largest_error(a: &Volume, b: &Volume) -> f64 {
        let errors = (0..a.samples().len()).map(|i| (a.value(i) - b.value(i)).abs());
        errors.fold(0.0, f64::max)
    }

    fn waves() -> Vec<f32> {
        (0..256).map(|i| (i as f32 * 0.37).sin() * 100.0).collect()
    }

    #[test]
    fn what_fits_stays_as_it_is() {
        let ramp = Samples::I16((0..256).map(|i| i * 100 - 9000).collect::<Vec<_>>().into());
        for (samples, bits) in [
            (Samples::U8(vec![7; 256].into()), &Bits::ALL[..]),
            (Samples::F32(waves().into()), &Bits::ALL),
            (ramp, &Bits::ROUNDED),
        ] {
            let volume = volume(samples);
            let fitted = fit(&of(&volume, false), bits, 1 << 20).unwrap();
            assert!(fitted.exact && fitted.level == 0 && fitted.bits == bits[0]);
            assert!(Arc::ptr_eq(fitted_volume(&fitted), &volume));
        }
    }

    #[test]
    fn floats_are_rounded_by_half_a_step_at_most() {
        let volume = volume(Samples::F32(waves().into()));
        let [low, high] = volume.value_range();
        for bits in Bits::ROUNDED {
            let fitted = fit(&of(&volume, false), &[bits], 1 << 20).unwrap();
            let step = (high - low) / f64::from(bits.largest());
            let error = largest_error(&volume, fitted_volume(&fitted));
            assert!(
                error <= 0.5001 * step && error > 0.05 * step,
                "{bits:?}: {error} of {step}"
            );
            assert!(!fitted.exact && sample_type(&fitted) == if bits == Bits::Eight { "u8" } else { "u16" });
        }
    }

    #[test]
    fn less_room_means_fewer_bits_then_coarser_levels_then_an_error() {
        let volume = of(&volume(Samples::F32(waves().into())), false);
        let rung = |most: u64| {
            fit(&volume, &Bits::ALL, most)
                .map(|fitted| (fitted.level, fitted.bits, fitted.bytes.len() as u64))
        };
        let mut most = 1 << 20;
        let mut rungs = Vec::new();
        while let Ok((level, bits, bytes)) = rung(most) {
            assert!(bytes <= most);
            rungs.push((level, std::cmp::Reverse(bits)));
            most = bytes - 1;
        }
        assert!(rungs.is_sorted() && rungs.len() > 4, "{rungs:?}");
        assert_eq!(rungs[0], (0, std::cmp::Reverse(Bits::Own)));
        assert!(rung(most).unwrap_err().to_string().contains("do not fit"));
    }

    #[test]
    fn missing_samples_stay_missing() {
        let mut values: Vec<f64> = waves().into_iter().map(f64::from).collect();
        values[9] = f64::NAN;
        let fitted = fit(
            &of(&volume(Samples::F64(values.into())), false),
            &[Bits::Eight],
            1 << 20,
        )
        .unwrap();
        assert_eq!(sample_type(&fitted), "f32");
        assert_eq!(fitted_volume(&fitted).statistics().non_finite, 1);
    }

    #[test]
    fn labels_are_neither_rounded_nor_averaged() {
        let ids: Vec<f32> = (0..256).map(|i| (i * 37 % 250) as f32 + 3.0).collect();
        let labels = volume(Samples::F32(ids.into()));
        let fitted = fit(&of(&labels, true), &[Bits::Eight], 1 << 20).unwrap();
        assert_eq!(largest_error(&labels, fitted_volume(&fitted)), 0.0);
        assert!(
            fit(&of(&labels, true), &[Bits::Eight], 20)
                .unwrap_err()
                .to_string()
                .contains("averaged")
        );
        let wide = volume(Samples::F32(
            (0..256).map(|i| (i * 2) as f32).collect::<Vec<_>>().into(),
        ));
        let refused = fit(&of(&wide, true), &[Bits::Eight], 1 << 20).unwrap_err();
        assert!(refused.to_string().contains("whole numbers"), "{refused}");
    }

    #[test]
    fn a_constant_has_no_steps() {
        let fitted = fit(
            &of(&volume(Samples::F32(vec![2.5; 256].into())), false),
            &Bits::ALL,
            1 << 20,
        )
        .unwrap();
        assert_eq!(fitted_volume(&fitted).value_range(), [2.5; 2]);
    }

    #[test]
    fn clouds_lose_bits_then_points_and_stay_exact_where_they_can() {
        let directions: Vec<[f32; 3]> = (0..3000u32)
            .map(|i| Vec3::new((i as f32).sin(), (i as f32 * 0.37).cos(), i as f32 / 3000.0).normalize())
            .map(|direction| direction.to_array())
            .collect();
        let attributes = PointAttributes {
            colors: (0..3000u32).map(|i| [i as u8, 3, (i / 9) as u8, 255]).collect(),
            normals: directions.clone(),
            radii: vec![0.01; 3000],
        };
        let points = Points::new(directions, attributes, DAffine3::IDENTITY).unwrap();
        let piece = |points: &Points| Piece {
            content: HeldContent::Points(Arc::new(points.clone())),
            labels: false,
        };
        let cloud = [piece(&points)];
        let counted = |fitted: &Fitted| match fitted.held[0].as_ref().map(Held::content) {
            Some(HeldContent::Points(points)) => points.len(),
            other => panic!("{other:?} are no points"),
        };
        let mut most = 1 << 20;
        let mut rungs = Vec::new();
        while let Ok(fitted) = fit(&cloud, &Bits::ALL, most) {
            assert_eq!(fitted.exact, fitted.bits == Bits::Own && fitted.level == 0);
            rungs.push((fitted.level, counted(&fitted), u8::from(fitted.bits)));
            most = fitted.bytes.len() as u64 - 1;
        }
        assert!(
            rungs.starts_with(&[(0, 3000, 32), (0, 3000, 16), (0, 3000, 12), (0, 3000, 8)]),
            "{rungs:?}"
        );
        assert!(
            rungs.last().unwrap().0 == 3 && rungs.last().unwrap().1 < 80,
            "{rungs:?}"
        );

        // Places on a lattice of their bits.
        let lattice = (0..256)
            .map(|i| [i as f32 / 256.0, 1.0, (255 - i) as f32])
            .collect();
        let lattice = Points::new(lattice, PointAttributes::default(), DAffine3::IDENTITY).unwrap();
        assert!(fit(&[piece(&lattice)], &Bits::ROUNDED, 1 << 20).unwrap().exact);
    }
}
