//! The transfer function: from a file, from names, or chosen from the data.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context;
use splatvol::transfer_function::ValueKind;
use splatvol::{
    Classification, ColorMap, ColorPoint, Compositing, Item, OpacityCurve, OpacityPoint, TransferFunction,
    Volume,
};
use splatvol_io::transfer_function::GRADIENT_OPACITY_LEFT_OUT;

use super::input::Input;
use crate::args::{GradientCurve, LookArgs};
use crate::failure::{During, Failure, Step};
use crate::terminal::Terminal;

/// Colour of a single surface, sRGB: ivory.
const SURFACE: [f64; 3] = [0.93, 0.89, 0.80];

/// A transfer function and what its choice implies.
pub(crate) struct Look {
    pub(crate) transfer_function: TransferFunction,
    pub(crate) wishes: Wishes,
    /// Gradient opacity of the transfer function's file.
    pub(crate) gradient_opacity: Option<GradientCurve>,
}

/// Preferences of the data that differ from the defaults.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wishes {
    pub(crate) classification: Option<Classification>,
    /// Colours as they are, without light.
    pub(crate) unlit: bool,
    /// Gradients by differences, whatever the preset: meshes have no others.
    pub(crate) differences: bool,
    /// Values are names of kinds.
    pub(crate) labels: bool,
    /// There is nothing to classify, so it does not matter when.
    pub(crate) unclassified: bool,
}

impl Look {
    /// A volume that looks so.
    pub(crate) fn item(self, volume: Arc<Volume>) -> Item {
        match self.wishes.labels {
            true => Item::labels(volume, self.transfer_function),
            false => Item::volume(volume, self.transfer_function),
        }
    }
}

impl From<TransferFunction> for Look {
    fn from(transfer_function: TransferFunction) -> Self {
        Self {
            transfer_function,
            wishes: Wishes::default(),
            gradient_opacity: None,
        }
    }
}

/// Resolves the flags for a volume that is composited in a certain way.
pub(crate) fn resolve(
    args: &LookArgs,
    input: &Input,
    compositing: Compositing,
    terminal: &Terminal,
) -> Result<Look, Failure> {
    let mut look = chosen(args, input, compositing, terminal)?;
    if args.unit_distance.is_some() {
        let old = look.transfer_function;
        look.transfer_function = TransferFunction::new(
            old.colors().to_vec(),
            old.opacities().to_vec(),
            args.unit_distance,
        )
        .during(Step::Usage)?;
    }
    Ok(look)
}

fn chosen(
    args: &LookArgs,
    input: &Input,
    compositing: Compositing,
    terminal: &Terminal,
) -> Result<Look, Failure> {
    let volume = &input.volume;
    let map = args
        .cmap
        .as_deref()
        .map(ColorMap::from_name)
        .transpose()
        .during(Step::Usage)?;
    if let Some(path) = &args.tf {
        let curve = splatvol_io::read_gradient_opacity(path).during(Step::Input)?;
        return Ok(Look {
            gradient_opacity: curve.map(GradientCurve),
            ..from_file(path, args.clim, volume.value_range(), terminal)?.into()
        });
    }
    let [low, high] = args.clim.unwrap_or(volume.value_range());
    if let Some(value) = args.iso {
        let width = ((high - low) / 50.0).max(f64::MIN_POSITIVE);
        let surface = TransferFunction::isosurface(value, width, SURFACE).during(Step::Usage)?;
        return match map {
            Some(map) => colored(&surface, map, [low, high]).map(Look::from),
            None => Ok(surface.into()),
        };
    }
    if args.opacity.is_none() && args.clim.is_none() {
        if compositing.shows_one_value() && map.is_none() {
            return TransferFunction::gray_ramp([low, high], 1.0)
                .during(Step::Usage)
                .map(Look::from);
        }
        if !compositing.shows_one_value() {
            return automatic(input, map, terminal);
        }
    }
    let curve = args.opacity.as_deref().unwrap_or("linear");
    let curve = OpacityCurve::from_name(curve).during(Step::Usage)?;
    let range = match args.clim {
        Some(range) => range,
        None if compositing.shows_one_value() => [low, high],
        None => TransferFunction::automatic(volume, None).1.range,
    };
    let map = match map {
        Some(map) => map,
        None => ColorMap::from_name("viridis").during(Step::Usage)?,
    };
    TransferFunction::from_map_and_opacity(range, map, curve, None)
        .during(Step::Usage)
        .map(Look::from)
}

/// A file's transfer function. `clim` is what its 0..1 stand for, or where its ends are moved to if it has data values.
fn from_file(
    path: &Path,
    clim: Option<[f64; 2]>,
    value_range: [f64; 2],
    terminal: &Terminal,
) -> Result<TransferFunction, Failure> {
    let read = |range| splatvol_io::read_transfer_function(path, range).during(Step::Input);
    let (own, warnings) = read(value_range)?;
    // Gradient opacity is read besides.
    for warning in warnings.into_iter().filter(|w| w != GRADIENT_OPACITY_LEFT_OUT) {
        terminal.warn(format!("{}: {warning}", path.display()));
    }
    let Some(range) = clim else {
        return Ok(own);
    };
    // A file without data values of its own spans whatever range it is read for.
    let relative = read([2.0, 3.0])?.0 != read([4.0, 6.0])?.0;
    if relative {
        moved(&read([0.0, 1.0])?.0, [0.0, 1.0], range)
    } else {
        moved(&own, span(&own), range)
    }
}

/// The look of a sample, or one that suits the data.
fn automatic(input: &Input, map: Option<ColorMap>, terminal: &Terminal) -> Result<Look, Failure> {
    if let (Some(sample), None) = (input.sample, map) {
        let transfer_function = sample.default_transfer_function().during(Step::Render)?;
        return Ok(Look {
            transfer_function,
            wishes: Wishes {
                classification: Some(sample.preferred_classification()),
                unlit: !sample.is_lit(),
                ..Wishes::default()
            },
            gradient_opacity: None,
        });
    }
    let (transfer_function, choice) = TransferFunction::automatic(&input.volume, map);
    terminal.detail(format!("transfer function: {}", choice.reason));
    Ok(Look {
        transfer_function,
        wishes: Wishes {
            classification: Some(choice.classification),
            labels: choice.kind == ValueKind::Labels,
            ..Wishes::default()
        },
        gradient_opacity: None,
    })
}

/// Smallest and largest value of any point.
fn span(transfer_function: &TransferFunction) -> [f64; 2] {
    let colors = transfer_function.colors().iter().map(|point| point.value);
    let opacities = transfer_function.opacities().iter().map(|point| point.value);
    colors
        .chain(opacities)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
}

/// The curves, moved so that the values `from` become `to`.
fn moved(old: &TransferFunction, from: [f64; 2], to: [f64; 2]) -> Result<TransferFunction, Failure> {
    if from[0] >= from[1] {
        return Err(Failure::usage(
            "--clim: the transfer function has a single value and cannot be stretched",
        ));
    }
    let move_value = |value: f64| to[0] + (value - from[0]) / (from[1] - from[0]) * (to[1] - to[0]);
    let colors = old.colors().iter().map(|&point| ColorPoint {
        value: move_value(point.value),
        ..point
    });
    let opacities = old.opacities().iter().map(|&point| OpacityPoint {
        value: move_value(point.value),
        ..point
    });
    TransferFunction::new(colors.collect(), opacities.collect(), old.unit_distance)
        .context("--clim")
        .during(Step::Usage)
}

/// The opacities of `old` under the colours of `map` over `range`.
fn colored(old: &TransferFunction, map: ColorMap, range: [f64; 2]) -> Result<TransferFunction, Failure> {
    let colors = map.points(range, ColorMap::DEFAULT_POINTS);
    TransferFunction::new(colors, old.opacities().to_vec(), old.unit_distance).during(Step::Usage)
}
