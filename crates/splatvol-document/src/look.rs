//! The transfer function: as given, from a file, from names, or chosen from the data.

use std::path::Path;
use std::sync::Arc;

use splatvol_io::transfer_function::GRADIENT_OPACITY_LEFT_OUT;
use splatvol_scene::transfer_function::{AutomaticChoice, ValueKind};
use splatvol_scene::{
    Classification, ColorMap, ColorPoint, Compositing, GradientOpacityPoint, Item, OpacityPoint,
    TransferFunction, Volume,
};

use crate::input::{Input, Reading};
use crate::keys::{ItemKeys, Opacity};
use crate::{DocumentError, Listener, files, spelling};

/// Colour of a single surface, sRGB: ivory.
const SURFACE: [f64; 3] = [0.93, 0.89, 0.80];

/// A transfer function and what its choice implies.
#[derive(Debug, Clone)]
pub struct Look {
    /// Colours and opacities.
    pub transfer_function: TransferFunction,
    /// Preferences of the data.
    pub wishes: Wishes,
    /// Gradient opacity of the transfer function's file.
    pub gradient_opacity: Option<Vec<GradientOpacityPoint>>,
}

/// Preferences of the data that differ from the defaults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wishes {
    /// Order of classification and splatting.
    pub classification: Option<Classification>,
    /// Colours as they are, without light.
    pub unlit: bool,
    /// Gradients by differences, whatever the preset: meshes have no others.
    pub differences: bool,
    /// Values are names of kinds.
    pub labels: bool,
    /// There is nothing to classify, so it does not matter when.
    pub unclassified: bool,
}

impl Look {
    /// A volume with this look.
    pub fn item(self, volume: Arc<Volume>) -> Item {
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

/// The look of a volume, or of the values of a mesh, that is composited in a certain way.
///
/// # Errors
/// Unknown names, files that cannot be read, invalid curves.
pub fn resolve(
    keys: &ItemKeys,
    input: &Input,
    compositing: Compositing,
    reading: Reading<'_>,
) -> Result<Look, DocumentError> {
    let mut look = match &keys.transfer_function {
        Some(known) => Look::from(known.clone()),
        None => chosen(keys, input, compositing, reading)?,
    };
    if let (Some(_), None) = (keys.unit_distance, &keys.transfer_function) {
        let old = look.transfer_function;
        let (colors, opacities) = (old.colors().to_vec(), old.opacities().to_vec());
        look.transfer_function = TransferFunction::new(colors, opacities, keys.unit_distance)?;
    }
    if let Some(labels) = keys.labels.or(input.description.is_labels.then_some(true)) {
        look.wishes.labels = labels;
        // Names of kinds have no values between them: each is coloured before it is spread.
        let first = Some(Classification::Pre).filter(|_| labels);
        look.wishes.classification = first.or(look.wishes.classification);
    }
    Ok(look)
}

fn chosen(
    keys: &ItemKeys,
    input: &Input,
    compositing: Compositing,
    reading: Reading<'_>,
) -> Result<Look, DocumentError> {
    let volume = &input.volume;
    let map = named(keys, "cmap", keys.cmap.as_deref(), spelling::color_map)?;
    if let Some(path) = &keys.tf {
        let path = reading.locate(path);
        return Ok(Look {
            gradient_opacity: files::read_gradient_opacity(&path)?,
            ..from_file(&path, keys, volume.value_range(), reading.listener)?.into()
        });
    }
    let [low, high] = keys.clim.unwrap_or(volume.value_range());
    if let Some(value) = keys.iso {
        let surface =
            TransferFunction::isosurface(value, surface_width(value, [low, high], volume), SURFACE)?;
        return match map {
            Some(map) => colored(&surface, map, [low, high]).map(Look::from),
            None => Ok(surface.into()),
        };
    }
    let curve = match &keys.opacity {
        Some(Opacity::Curve(name)) => Some(name.as_str()),
        _ => None,
    };
    if curve.is_none() && keys.clim.is_none() {
        let own = map.is_none()
            && input.mesh.is_none()
            && input.sample.is_none()
            && !keys.labels.unwrap_or(input.description.is_labels);
        if let Some(look) = own
            .then(|| TransferFunction::automatic_projection(volume, compositing))
            .flatten()
        {
            return Ok(look.into());
        }
        if compositing.shows_one_value() && map.is_none() {
            return Ok(TransferFunction::gray_ramp([low, high], 1.0)?.into());
        }
        if !compositing.shows_one_value() {
            return automatic(keys, input, map, reading.listener);
        }
    }
    let curve = named(
        keys,
        "opacity",
        Some(curve.unwrap_or("linear")),
        spelling::opacity_curve,
    )?;
    let range = match keys.clim {
        Some(range) => range,
        None if compositing.shows_one_value() => [low, high],
        None => of_values(keys, volume, None).1.range,
    };
    let map = match map {
        Some(map) => map,
        None => ColorMap::from_name("viridis")?,
    };
    let curve = curve.ok_or_else(|| DocumentError::usage("no opacity curve"))?;
    Ok(TransferFunction::from_map_and_opacity(range, map, curve, None)?.into())
}

/// Looks up the name in a key of an item.
fn named<T>(
    keys: &ItemKeys,
    key: &str,
    name: Option<&str>,
    known: fn(&str) -> Result<T, String>,
) -> Result<Option<T>, DocumentError> {
    let found = name.map(known).transpose();
    found.map_err(|why| {
        let name = name.unwrap_or_default();
        DocumentError::refused(&format!("item.{key}"), format!("{name:?}: {why}")).of_item(&keys.file)
    })
}

/// A file's transfer function. `clim` is the range that its 0..1 stands for, or to which its ends are moved if it has
/// data values.
fn from_file(
    path: &Path,
    keys: &ItemKeys,
    value_range: [f64; 2],
    listener: &dyn Listener,
) -> Result<TransferFunction, DocumentError> {
    let read = |range| files::read_transfer_function(path, range);
    let (own, warnings) = read(value_range)?;
    // Gradient opacity is read separately.
    for warning in warnings.into_iter().filter(|w| w != GRADIENT_OPACITY_LEFT_OUT) {
        listener.warn(&format!("{}: {warning}", path.display()));
    }
    let Some(range) = keys.clim else {
        return Ok(own);
    };
    // A file without data values of its own spans whatever range it is read for.
    let relative = read([2.0, 3.0])?.0 != read([4.0, 6.0])?.0;
    let stretched = match relative {
        true => moved(&read([0.0, 1.0])?.0, [0.0, 1.0], range),
        false => moved(&own, span(&own), range),
    };
    stretched.map_err(|error| DocumentError::refused("item.clim", format!(": {error}")).of_item(&keys.file))
}

/// The look of a sample, or one that suits the data.
fn automatic(
    keys: &ItemKeys,
    input: &Input,
    map: Option<ColorMap>,
    listener: &dyn Listener,
) -> Result<Look, DocumentError> {
    if let (Some(sample), None) = (input.sample, map) {
        let wishes = Wishes {
            classification: Some(sample.preferred_classification()),
            unlit: !sample.is_lit(),
            ..Wishes::default()
        };
        return Ok(Look {
            wishes,
            ..sample.default_transfer_function()?.into()
        });
    }
    let (transfer_function, choice) = match &input.mesh {
        Some(mesh) => TransferFunction::automatic_mesh(mesh, map)?,
        None => of_values(keys, &input.volume, map),
    };
    listener.detail(&format!("transfer function: {}", choice.reason));
    let wishes = Wishes {
        classification: Some(choice.classification),
        labels: choice.kind == ValueKind::Labels,
        ..Wishes::default()
    };
    Ok(Look {
        wishes,
        ..transfer_function.into()
    })
}

/// The automatic choice for a volume, whose values are no labels if the keys say so.
fn of_values(keys: &ItemKeys, volume: &Volume, map: Option<ColorMap>) -> (TransferFunction, AutomaticChoice) {
    match keys.labels {
        Some(false) => TransferFunction::automatic_continuous(volume, map),
        _ => TransferFunction::automatic(volume, map),
    }
}

/// Width of the ramp of opacity around a surface's value: a share of the range, but no more than the distance to the
/// background, which a wider ramp would show.
fn surface_width(value: f64, [low, high]: [f64; 2], volume: &Volume) -> f64 {
    let wide = (high - low) / 50.0;
    let apart = (value - TransferFunction::background_of(volume)).abs();
    let width = if apart > 0.0 { wide.min(apart) } else { wide };
    width.max(f64::MIN_POSITIVE)
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
fn moved(old: &TransferFunction, from: [f64; 2], to: [f64; 2]) -> Result<TransferFunction, String> {
    if from[0] >= from[1] {
        return Err("the transfer function has a single value and cannot be stretched".to_owned());
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
        .map_err(|error| error.to_string())
}

/// The opacities of `old` under the colours of `map` over `range`.
fn colored(
    old: &TransferFunction,
    map: ColorMap,
    range: [f64; 2],
) -> Result<TransferFunction, DocumentError> {
    let colors = map.points(range, ColorMap::DEFAULT_POINTS);
    Ok(TransferFunction::new(
        colors,
        old.opacities().to_vec(),
        old.unit_distance,
    )?)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;
    use splatvol_io::Description;
    use splatvol_scene::{Association, Grid, LengthUnit, Mesh, MeshField, Rescale, Samples, Topology};

    use super::*;
    use crate::{ReadRules, Silent};

    #[test]
    fn labels_are_classified_first_whatever_colours_they_are_given() {
        let grid = Grid::centred([2, 1, 1], [1.0; 3]).unwrap();
        let samples = Samples::U8(vec![1, 9].into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let input = Input {
            volume: Arc::new(volume),
            description: Description::default(),
            sample: None,
            mesh: None,
        };
        let reading = Reading {
            rules: ReadRules::default(),
            folder: None,
            listener: &Silent,
        };
        let colors = vec![
            ColorPoint::new(1.0, [1.0, 0.0, 0.0]),
            ColorPoint::new(9.0, [0.0, 0.0, 1.0]),
        ];
        let opacities = vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, 1.0)];
        let given = TransferFunction::new(colors, opacities, None).unwrap();
        let classified = |labels: Option<bool>| {
            let keys = ItemKeys {
                labels,
                transfer_function: Some(given.clone()),
                ..ItemKeys::of_file("a.nrrd")
            };
            let look = resolve(&keys, &input, Compositing::default(), reading).unwrap();
            look.wishes.classification
        };
        assert_eq!(classified(Some(true)), Some(Classification::Pre));
        assert_eq!(classified(Some(false)), None);
        assert_eq!(classified(None), None);
    }

    #[test]
    fn surfaces_near_the_background_do_not_show_it() {
        // A bright ball in the dark.
        let value = |i: i32| {
            let [x, y, z] = [i % 16, i / 16 % 16, i / 256].map(|at| at - 8);
            if x * x + y * y + z * z < 25 { 1000 } else { 5 }
        };
        let grid = Grid::centred([16; 3], [1.0; 3]).unwrap();
        let samples = Samples::U16((0..4096).map(|i| value(i) as u16).collect::<Vec<_>>().into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let ramp = |iso: f64| {
            let width = surface_width(iso, volume.value_range(), &volume);
            [iso - 0.5 * width, iso + 0.5 * width]
        };
        assert_eq!(ramp(9.0), [7.0, 11.0]);
        assert_eq!(ramp(1.0), [-1.0, 3.0]);
        let far = 995.0 / 100.0;
        assert_eq!(ramp(500.0), [500.0 - far, 500.0 + far]);
        assert!(surface_width(5.0, volume.value_range(), &volume) > 0.0);
    }

    #[test]
    fn values_that_are_no_labels_are_a_continuous_field() {
        let data = (0..4096).map(|i| u8::from(i % 16 > 5) * 3);
        let grid = Grid::centred([16; 3], [1.0; 3]).unwrap();
        let samples = Samples::U8(data.collect::<Vec<u8>>().into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let input = Input {
            volume: Arc::new(volume),
            description: Description::default(),
            sample: None,
            mesh: None,
        };
        let look = |labels| {
            let keys = ItemKeys {
                labels,
                ..ItemKeys::of_file("a.nrrd")
            };
            automatic(&keys, &input, None, &Silent).unwrap()
        };
        assert!(look(None).wishes.labels);
        let continuous = look(Some(false));
        assert!(!continuous.wishes.labels);
        assert_ne!(continuous.transfer_function, look(None).transfer_function);
    }

    #[test]
    fn meshes_that_are_plates_show_their_body() {
        // Twenty by twenty by two points; one half of the values is low.
        let values: Vec<f32> = (0..800)
            .map(|i| if i % 20 < 10 { 0.0 } else { 0.37 * i as f32 })
            .collect();
        let grid = Grid::centred([800, 1, 1], [1.0; 3]).unwrap();
        let samples = Samples::F32(values.clone().into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let field = MeshField {
            name: "strain".to_owned(),
            association: Association::Point,
            values,
        };
        let places = (0..800).map(|i| [i % 20, i / 20 % 20, i / 400].map(|at| at as f32));
        let positions = places.map(|[x, y, z]| [x, y, 0.1 * z]).collect();
        let blocks = Topology::Structured(vec![[20, 20, 2]]);
        let mesh = Mesh::new(positions, blocks, Vec::new(), field, DAffine3::IDENTITY).unwrap();
        let mut input = Input {
            volume: Arc::new(volume),
            description: Description::default(),
            sample: None,
            mesh: None,
        };
        let opacity = |input: &Input| {
            let look = automatic(&ItemKeys::default(), input, None, &Silent).unwrap();
            look.transfer_function.opacity(0.0)
        };
        assert_eq!(opacity(&input), 0.0);
        input.mesh = Some(Arc::new(mesh));
        assert!(opacity(&input) > 0.9);
    }
}
