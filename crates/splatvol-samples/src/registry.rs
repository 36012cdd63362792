//! The samples by name: what each is, how large by default, and how to make it.

use glam::{DMat3, DVec3};
use splatvol_scene::{Classification, Grid, LengthUnit, Rescale, Samples, TransferFunction, View, Volume};

use crate::{SampleError, head, signals, terrain, textures, tomato, transfer, tubes};

/// A built-in sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Sample {
    /// CT-like head phantom, Hounsfield units, RAS+.
    Head,
    /// Standard test of reconstruction filters.
    MarschnerLobb,
    /// Checkered slice (swan1997, figure 7).
    CheckerSheet,
    /// Checkered tube (mueller1998, figure 5).
    Tunnel,
    /// Striped thin slab (zwicker2001, figure 8).
    Zebra,
    /// Nested noisy shells.
    Shells,
    /// `1 - (r/R)^2`.
    Ball,
    /// Linear ramp along x.
    Slab,
    /// Landscape under a satellite photograph (mueller1998, figure 6).
    Terrain,
    /// Many thin bent tubes.
    Microtubules,
    /// Branching nerve cell in voxels 1:1:5.
    Nerve,
    /// Fruit with chambers and seeds.
    Tomato,
}

/// Size of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleSize {
    /// Samples along the longest axis; the others keep the default's proportions.
    Longest(usize),
    /// Samples along x, y, z.
    Dims([usize; 3]),
}

impl Sample {
    /// All samples, for listings.
    pub const ALL: [Self; 12] = [
        Self::Head,
        Self::MarschnerLobb,
        Self::CheckerSheet,
        Self::Tunnel,
        Self::Zebra,
        Self::Shells,
        Self::Ball,
        Self::Slab,
        Self::Terrain,
        Self::Microtubules,
        Self::Nerve,
        Self::Tomato,
    ];

    /// Largest number of samples that is generated.
    pub const MAX_SAMPLES: usize = 1 << 31;

    /// The sample of a name.
    ///
    /// # Errors
    /// An unknown name; the error lists the names and suggests the most similar one.
    pub fn from_name(name: &str) -> Result<Self, SampleError> {
        Self::ALL
            .into_iter()
            .find(|sample| sample.name() == name)
            .ok_or_else(|| SampleError::UnknownName {
                name: name.to_owned(),
                nearest: nearest_name(name),
                known: Self::ALL.map(Self::name).join(", "),
            })
    }

    /// Name, as in `sample:NAME`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::MarschnerLobb => "marschner-lobb",
            Self::CheckerSheet => "checker-sheet",
            Self::Tunnel => "tunnel",
            Self::Zebra => "zebra",
            Self::Shells => "shells",
            Self::Ball => "ball",
            Self::Slab => "slab",
            Self::Terrain => "terrain",
            Self::Microtubules => "microtubules",
            Self::Nerve => "nerve",
            Self::Tomato => "tomato",
        }
    }

    /// Description, in one line.
    pub fn description(self) -> &'static str {
        match self {
            Self::Head => "CT-like head phantom in Hounsfield units (RAS+, 1 mm)",
            Self::MarschnerLobb => "standard test of reconstruction filters (f32)",
            Self::CheckerSheet => "one slice of 10-voxel squares (swan1997, figure 7)",
            Self::Tunnel => "checkered tube to look through (mueller1998, figure 5)",
            Self::Zebra => "thin striped slab with anisotropic voxels (zwicker2001, figure 8)",
            Self::Shells => "three nested noisy shells, the benchmark volume",
            Self::Ball => "1 - (r/R)^2, exact in closed form (f32)",
            Self::Slab => "linear ramp along x, exact in closed form (f32)",
            Self::Terrain => "landscape in the colours of a satellite photograph (mueller1998, figure 6)",
            Self::Microtubules => "many thin bent tubes, as under a microscope",
            Self::Nerve => "branching nerve cell in voxels of 1:1:5",
            Self::Tomato => "soft fruit with chambers and seeds, semi-transparent",
        }
    }

    /// Samples along x, y, z if no size is given.
    pub fn default_dims(self) -> [usize; 3] {
        match self {
            Self::Head | Self::Shells => [256; 3],
            Self::MarschnerLobb => [41; 3],
            Self::CheckerSheet => [498, 398, 1],
            Self::Tunnel => [160, 160, 300],
            Self::Zebra => [1024, 512, 3],
            Self::Ball => [64; 3],
            Self::Slab => [64, 32, 32],
            Self::Terrain => [512, 512, 103],
            Self::Microtubules => [420, 468, 62],
            Self::Nerve => [512, 512, 76],
            Self::Tomato => [256; 3],
        }
    }

    /// Generates the volume.
    ///
    /// # Errors
    /// A size of 0, above [`Grid::MAX_DIM`] along an axis, or of more than [`Sample::MAX_SAMPLES`] samples.
    pub fn generate(self, size: Option<SampleSize>) -> Result<Volume, SampleError> {
        let dims = self.dims(size)?;
        let samples = match self {
            Self::Head => Samples::I16(head::head(dims).into()),
            Self::MarschnerLobb => Samples::F32(signals::marschner_lobb(dims).into()),
            Self::CheckerSheet => Samples::U8(textures::checker_sheet(dims).into()),
            Self::Tunnel => Samples::U8(textures::tunnel(dims).into()),
            Self::Zebra => Samples::U8(textures::zebra(dims).into()),
            Self::Shells => Samples::U8(textures::shells(dims).into()),
            Self::Ball => Samples::F32(signals::ball(dims).into()),
            Self::Slab => Samples::F32(signals::slab(dims).into()),
            Self::Terrain => Samples::U8(terrain::terrain(dims).into()),
            Self::Microtubules => Samples::U8(tubes::microtubules(dims).into()),
            Self::Nerve => Samples::U8(tubes::nerve(dims).into()),
            Self::Tomato => Samples::U8(tomato::tomato(dims).into()),
        };
        let unit = match self {
            Self::Head => LengthUnit::Millimetre,
            _ => LengthUnit::Unknown,
        };
        Ok(Volume::new(self.grid(dims)?, samples, Rescale::default(), unit)?)
    }

    /// A transfer function that shows the sample's characteristic structures.
    pub fn default_transfer_function(self) -> Result<TransferFunction, SampleError> {
        Ok(transfer::transfer_function(self)?)
    }

    /// Classification in the paper that the sample comes from. With splatted colours, the dark squares' value, which
    /// lies between light squares and air, makes no dark rim, and palettes mix as colours, not as entries.
    pub fn preferred_classification(self) -> Classification {
        match self {
            Self::CheckerSheet | Self::Tunnel | Self::Zebra | Self::Terrain => Classification::Pre,
            _ => Classification::Post,
        }
    }

    /// Whether lighting is meaningful: a photograph has its light already, and its palette no slopes.
    pub fn is_lit(self) -> bool {
        self != Self::Terrain
    }

    /// The direction to look from, if it matters.
    pub fn preferred_view(self) -> Option<View> {
        match self {
            Self::Head | Self::Shells | Self::Terrain | Self::Tomato => Some(View::Iso),
            Self::CheckerSheet | Self::Zebra | Self::Microtubules | Self::Nerve => Some(View::Top),
            Self::Tunnel => Some(View::Bottom),
            Self::MarschnerLobb => Some(View::Top),
            Self::Ball | Self::Slab => None,
        }
    }

    fn dims(self, size: Option<SampleSize>) -> Result<[usize; 3], SampleError> {
        let default = self.default_dims();
        let dims = match size {
            None => default,
            Some(SampleSize::Dims(dims)) => dims,
            Some(SampleSize::Longest(longest)) => {
                let most = default.into_iter().max().unwrap_or(1) as f64;
                default.map(|n| match longest {
                    0 => 0,
                    _ => ((n as f64 * longest as f64 / most).round() as usize).max(n.min(3)),
                })
            }
        };
        let count = dims.iter().try_fold(1usize, |count, &n| count.checked_mul(n));
        let fits = dims.iter().all(|n| (1..=Grid::MAX_DIM).contains(n))
            && count.is_some_and(|count| count <= Self::MAX_SAMPLES);
        if fits {
            Ok(dims)
        } else {
            Err(SampleError::InvalidSize {
                name: self.name(),
                size: dims.map(|n| n.to_string()).join("x"),
                expected: "1 to 65535 along each axis, at most 2^31 samples",
            })
        }
    }

    fn grid(self, dims: [usize; 3]) -> Result<Grid, SampleError> {
        if self == Self::Head {
            let (origin, spacing) = head::placement(dims);
            return Ok(Grid::new(dims, origin, spacing, DMat3::IDENTITY)?);
        }
        let spacing = match self {
            // A square texture of twice as many samples along x as along y.
            Self::Zebra => DVec3::new(1.0, 2.0, 1.0),
            Self::Nerve => DVec3::from_array(tubes::NERVE_SPACING),
            _ => DVec3::ONE,
        };
        Ok(Grid::centred(dims, spacing)?)
    }
}

/// Generates the sample called `name`, at its default size or another.
///
/// # Errors
/// An unknown name or a size that is not allowed.
pub fn sample(name: &str, size: Option<SampleSize>) -> Result<Volume, SampleError> {
    Sample::from_name(name)?.generate(size)
}

/// The known name with the fewest edits from `name`, if it is at most half its length away.
fn nearest_name(name: &str) -> Option<&'static str> {
    let distance = |known: &str| edits(name.as_bytes(), known.as_bytes());
    Sample::ALL
        .map(Sample::name)
        .into_iter()
        .map(|known| (distance(known), known))
        .min()
        .filter(|&(edits, known)| 2 * edits <= known.len())
        .map(|(_, known)| known)
}

/// Levenshtein distance.
fn edits(a: &[u8], b: &[u8]) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_names_get_a_suggestion_and_the_list() {
        let text = sample("marchner-lob", None).unwrap_err().to_string();
        assert!(
            text.contains("did you mean \"marschner-lobb\"") && text.contains("zebra"),
            "{text}"
        );
        let text = sample("qqqqqqqqqqqqqqqq", None).unwrap_err().to_string();
        assert!(!text.contains("did you mean"), "{text}");
        assert_eq!(edits(b"kitten", b"sitting"), 3);
    }

    #[test]
    fn sizes_keep_proportions_and_nonsense_is_refused() {
        let dims = |sample: Sample, size| sample.dims(Some(size));
        assert_eq!(
            dims(Sample::Tunnel, SampleSize::Longest(30)).unwrap(),
            [16, 16, 30]
        );
        assert_eq!(dims(Sample::Zebra, SampleSize::Longest(64)).unwrap(), [64, 32, 3]);
        assert_eq!(
            dims(Sample::CheckerSheet, SampleSize::Longest(50)).unwrap(),
            [50, 40, 1]
        );
        assert!(dims(Sample::Head, SampleSize::Longest(0)).is_err());
        assert!(dims(Sample::Head, SampleSize::Longest(usize::MAX)).is_err());
        assert!(dims(Sample::Ball, SampleSize::Dims([4096, 4096, 4096])).is_err());
    }
}
