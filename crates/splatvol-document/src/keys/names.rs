//! Values that are names: what a key of the document, and the flag of the same name, can say.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use splatvol_scene::{
    Absorption, Classification, Compositing, GaussianMode, Gradient, KernelEdge, Occlusion, SheetContent,
    SheetPrecision, SheetValues, Stretch, Stuff, TablePrecision, View,
};

/// Defines names.
macro_rules! names {
    ($(#[$about:meta])* $name:ident {
        $($(#[$value_about:meta])* $value:ident $(= $text:literal)?,)*
    }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
        #[serde(rename_all = "kebab-case")]
        pub enum $name {
            $(
                $(#[$value_about])*
                $(#[serde(rename = $text)] #[cfg_attr(feature = "clap", value(name = $text))])?
                $value,
            )*
        }
    };
}

/// Defines names of the values of one of the scene's own types, and the conversions.
macro_rules! scene_names {
    ($(#[$about:meta])* $name:ident as $own:ident {
        $($(#[$value_about:meta])* $value:ident $(= $text:literal)? as $own_value:ident,)*
    }) => {
        names! {
            $(#[$about])*
            $name {
                $($(#[$value_about])* $value $(= $text)?,)*
            }
        }

        impl From<$name> for $own {
            fn from(name: $name) -> Self {
                match name {
                    $($name::$value => Self::$own_value,)*
                }
            }
        }

        impl From<$own> for $name {
            fn from(own: $own) -> Self {
                match own {
                    $($own::$own_value => Self::$value,)*
                }
            }
        }
    };
}

names! {
    /// Whole settings by name.
    PresetName {
        /// Closest to the exact integral (49 to 75 dB in the fields of docs/numerics.md), and slowest
        Best,
        /// Far faster than best, at 36 to 62 dB
        Balanced,
        /// Up to twice as fast as balanced, at 31 to 61 dB; steep edges can show bands
        Fast,
        /// As fast at half the resolution, for previews and motion; thin structures fade
        Draft,
        /// Whole splats one by one, anti-aliased (Swan et al. 1997)
        Swan1997 = "swan1997",
        /// As swan1997, with footprints within an error budget and motion blur (Mueller et al. 1998)
        Mueller1998 = "mueller1998",
        /// Elliptical Gaussians on slices of the grid (Zwicker et al. 2001)
        Ewa2001 = "ewa2001",
        /// FastSplats: footprints from tables, culling by a summed-area table (Huang et al. 2000)
        FastSplats2000 = "fastsplats2000",
    }
}

scene_names! {
    /// How sheets become a picture.
    CompositingName as Compositing {
        /// Thin sheets parallel to the picture, front to back
        ImageSheets as ImageSheets,
        /// Sum along the ray, as in a radiograph
        Xray as Xray,
        /// Largest value along the ray (maximum intensity projection)
        Mip as Mip,
        /// Smallest value along the ray
        Minip as MinimumIntensity,
        /// Mean value along the ray
        Mean as Mean,
        /// Whole footprints one by one, front to back (Westover 1989)
        PerSplat as PerSplat,
        /// Whole footprints one by one, back to front
        PerSplatBackToFront as PerSplatBackToFront,
        /// Whole footprints on slices of the grid (Westover 1990)
        AxisSheets as AxisSheets,
    }
}

scene_names! {
    /// Order of classification and splatting.
    ClassificationName as Classification {
        /// Colours are splatted
        Pre as Pre,
        /// Data are splatted; each sheet looks colours up
        Post as Post,
    }
}

names! {
    /// Low-pass filter in the picture.
    FilterName {
        /// Footprints as they are
        None,
        /// Every footprint is widened by the filter
        Ewa,
        /// Footprints narrower than the filter are widened to it
        Matched,
        /// Where voxels are less than a pixel apart, footprints are scaled up and thinned (Swan 1997)
        Swan,
        /// As swan, but the opacity is lowered, as in the paper
        SwanAlpha,
    }
}

names! {
    /// Anti-aliasing of edges.
    CoverageName {
        /// One sample per pixel
        Off,
        /// Several samples for pixels that differ from their neighbours
        Adaptive,
    }
}

scene_names! {
    /// Where the gradient that lights a sheet comes from.
    GradientName as Gradient {
        /// Derivatives of the footprints, splatted along with them
        Analytic as Analytic,
        /// Differences between the pixels of neighbouring sheets
        Differences as Differences,
    }
}

names! {
    /// Reconstruction kernels.
    KernelName {
        /// Smooth; the only one that can interpolate the data
        Gaussian,
        /// Piecewise cubic; the smallest
        CrawfisMax,
        /// Cubic B-spline of the distance, radius 2
        CubicBspline,
        /// Kaiser-Bessel window, or blob; the most even
        KaiserBessel,
    }
}

scene_names! {
    /// Contribution of a footprint to a sheet.
    SheetName as SheetContent {
        /// The kernel integrated over the sheet's depth
        Section as Section,
        /// The kernel's value on the sheet's plane
        Sample as Sample,
    }
}

names! {
    /// Which integrals of a kernel make up its footprint.
    AlignmentName {
        /// Sheets: at constant depth. Whole footprints: as affine
        Sheet,
        /// Along rays parallel to the one through the kernel's centre
        Affine,
        /// Along each pixel's own ray
        Exact,
        /// Along the viewing axis
        Grid,
        /// As discs across the ray through the centre, in perspective
        Ray,
        /// As exact, with kernels stretched across the ray through the centre
        RayIdeal,
        /// As ray before --alignment-switch, as grid behind it
        Switch,
        /// As affine where that is within --alignment-budget, as exact elsewhere
        Auto,
    }
}

scene_names! {
    /// How the swan filter stretches kernels.
    StretchName as Stretch {
        /// The whole kernel by what its centre needs
        Box as Box,
        /// Each depth by what it needs; needs --alignment exact
        Trapezoid as Trapezoid,
    }
}

scene_names! {
    /// The edge of a Gaussian kernel's footprint.
    KernelEdgeName as KernelEdge {
        /// Lowered to nothing, and the mass kept
        Smooth as Smooth,
        /// A step, as in zwicker2001
        Raw as Raw,
    }
}

scene_names! {
    /// The value of a pixel on a sheet of sections.
    SheetValuesName as SheetValues {
        /// Of the kernels that reach the pixel, however few
        Mean as Mean,
        /// What has no splat has the least value, as in huang2000
        Sum as Sum,
    }
}

scene_names! {
    /// Number format of a sheet's pixels.
    SheetPrecisionName as SheetPrecision {
        /// 8 bits, huang2000's for colours; with a picture of 8 bits
        U8 as U8,
        /// 16 bits, its for values; with a picture of 8 bits
        U16 as U16,
        /// Single precision, and so is the picture
        F32 as F32,
    }
}

scene_names! {
    /// How light is lost in material.
    AbsorptionName as Absorption {
        /// exp(-x)
        Exp as Exp,
        /// 1 - x, as in the papers
        Linear as Linear,
    }
}

scene_names! {
    /// How what is hidden is left out.
    OcclusionName as Occlusion {
        /// By counting unfinished pixels
        Auto as Auto,
        /// Nothing is left out
        None as None,
        /// By a summed-area table of the picture (FastSplats)
        Sat as Sat,
        /// By a convolution of the picture with a box as large as a splat
        Box as Box,
    }
}

names! {
    /// Meaning of the kernels.
    ReconstructionName {
        /// A volume
        Volume,
        /// Surfaces: kernels are flattened along the gradient
        Surface,
        /// Surfaces inside a volume: flattened where the gradient is steep
        Mixed,
    }
}

names! {
    /// How footprints become pixels.
    RasterizerName {
        /// The fastest for each footprint, without tables
        Auto,
        /// A table over the distance from the centre: a square root per pixel
        Linear1d = "linear-1d",
        /// A table over the squared distance: two additions per pixel; circles only
        Square1d = "square-1d",
        /// As square-1d, for ellipses
        Ellipse1d = "ellipse-1d",
        /// Squared distances from a table too; centres are rounded
        Rlut,
        /// Whole footprints drawn beforehand; centres and radii are rounded; circles only
        Blit2d = "blit-2d",
        /// As blit-2d up to --blit-radius, as square-1d above; circles
        Hybrid,
    }
}

scene_names! {
    /// Number formats of a table's entries.
    PrecisionName as TablePrecision {
        /// 8 bits
        U8 as U8,
        /// 16 bits
        U16 as U16,
        /// Single precision
        F32 as F32,
    }
}

scene_names! {
    /// How Gaussians are composited.
    GaussianModeName as GaussianMode {
        /// 3dgs for Gaussians alone or with points; volumetric with anything else
        Auto as Auto,
        /// As published: whole Gaussians, with points and meshes, sorted by their centres
        Published = "3dgs" as Published,
        /// In sheets, together with everything else: no popping, linear light
        Volumetric as Volumetric,
    }
}

names! {
    /// How motion is blurred.
    MotionBlurName {
        /// Not: the picture is of the middle of the shutter's time
        None,
        /// Footprints halved and drawn apart along their motion (Mueller 1998); too bright
        Capsule,
        /// Footprints integrated along their motion; hides as in the middle of the shutter's time
        Exact,
        /// The mean of several pictures: right for all scenes, and takes as long as all of them
        Subframes,
    }
}

scene_names! {
    /// Solid textures.
    TextureName as Stuff {
        /// White stone with dark veins
        Marble as Marble,
        /// Growth rings of a leaning trunk
        Wood as Wood,
    }
}

scene_names! {
    /// Sides to look from.
    ViewName as View {
        /// From the data's +y
        Front as Front,
        /// From its -y
        Back as Back,
        /// From its left: -x
        Left as Left,
        /// From its right: +x
        Right as Right,
        /// From its +z
        Top as Top,
        /// From its -z
        Bottom as Bottom,
        /// From above a corner
        Iso as Iso,
    }
}

names! {
    /// Subject of an automatic camera.
    #[derive(Default)]
    Fit {
        /// The voxels that are not transparent, without stray specks
        #[default]
        Visible,
        /// The whole grid
        Volume,
    }
}

names! {
    /// Axes of a file.
    UpAxis {
        /// Its +x
        X,
        /// Its +y
        Y,
        /// Its +z
        Z,
        /// Its -x
        MinusX = "-x",
        /// Its -y
        MinusY = "-y",
        /// Its -z
        MinusZ = "-z",
    }
}

impl UpAxis {
    /// The axis as the document and `--up` spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::MinusX => "-x",
            Self::MinusY => "-y",
            Self::MinusZ => "-z",
        }
    }
}

/// How alike two names must be for one to be suggested for the other, Jaro's measure, 0..1.
const ALIKE: f64 = 0.7;

/// The known name that was probably meant by a misspelt one.
pub fn nearest<Name: AsRef<str>>(name: &str, known: impl IntoIterator<Item = Name>) -> Option<Name> {
    let likeness = |known: &Name| strsim::jaro(known.as_ref(), name);
    known
        .into_iter()
        .filter(|known| likeness(known) > ALIKE)
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)))
}
