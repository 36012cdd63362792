//! From the keys of an item to the item.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use splatvol_io::{DataKind, DataOptions, Description};
use splatvol_scene::{
    Compositing, GradientOpacityPoint, Grid, Item, LengthUnit, Mesh, PointLook, Rescale, Samples,
    TransferFunction2d, View, Volume,
};

use crate::effects::transfer_function_2d;
use crate::held::{Held, HeldContent};
use crate::input::{self, Input, Reading};
use crate::keys::{EffectKeys, ItemKeys, Opacity};
use crate::look::{self, Look, Wishes};
use crate::upright::{self, Up};
use crate::{DocumentError, ReadRules, files, meaning, spelling};

/// An item, and the wishes of its data.
pub(crate) struct Loaded {
    pub(crate) item: Item,
    /// Its keys, with what was chosen.
    pub(crate) keys: ItemKeys,
    pub(crate) wishes: Wishes,
    /// Side to look from unless asked otherwise.
    pub(crate) preferred: Option<View>,
    /// Files that it was read from.
    pub(crate) files: Vec<PathBuf>,
    /// Gradient opacity of its transfer function's file.
    pub(crate) gradient_opacity: Option<Vec<GradientOpacityPoint>>,
    /// Transfer function of value and gradient.
    pub(crate) tf2d: Option<TransferFunction2d>,
}

/// The context on which an item's look and place depend, besides its keys.
#[derive(Clone, Copy)]
pub(crate) struct Among<'a> {
    /// How the sheets are composited: an automatic look depends on it.
    pub(crate) compositing: Compositing,
    /// Whether there is nothing else in the scene.
    pub(crate) alone: bool,
    pub(crate) effects: &'a EffectKeys,
    pub(crate) reading: Reading<'a>,
}

/// Kind of an item's file, and its path.
///
/// # Errors
/// Files that cannot be read or are of no known kind.
pub fn kind(item: &ItemKeys, reading: Reading<'_>) -> Result<(DataKind, PathBuf), DocumentError> {
    let path = reading.locate(&item.file);
    let options = options(item, reading.rules)?;
    if item.file.starts_with("sample:") {
        return match options.kind.filter(|kind| *kind != DataKind::Volume) {
            Some(kind) => {
                let why = format!("= {}: a built-in sample is a volume", kind.name());
                Err(DocumentError::refused("item.kind", why).of_item(&item.file))
            }
            None => Ok((DataKind::Volume, path)),
        };
    }
    let kind = files::data_kind(&path, &options)?;
    Ok((kind, path))
}

/// Options for reading an item's file.
///
/// # Errors
/// Keys that do not make a kind or a layout, by name.
pub fn options(item: &ItemKeys, rules: ReadRules) -> Result<DataOptions, DocumentError> {
    let kind = item.kind.as_deref().map(spelling::kind).transpose();
    let kind =
        kind.map_err(|why| DocumentError::refused("item.kind", format!(": {why}")).of_item(&item.file))?;
    Ok(DataOptions {
        kind,
        read: input::options(item, rules)?,
        drape: item.drape.as_ref().map(PathBuf::from),
        posts: item.posts,
    })
}

/// An item, from its file or from the data that are held for it.
pub(crate) fn load(keys: &ItemKeys, held: Option<&Held>, among: Among<'_>) -> Result<Loaded, DocumentError> {
    keys.check_values()?;
    let place = keys.world_from_file()?;
    let held = match held {
        Some(held) => {
            meaning::check(keys, held.kind())?;
            held.clone()
        }
        None => Held::read(keys, among.reading)?,
    };
    match held.content() {
        HeldContent::Volume(stored) if held.kind() == DataKind::Volume => {
            volume(keys, place, (stored, &held), among)
        }
        _ => other(keys, place, &held, among),
    }
}

/// Whether the way up of an item is open: not if something else stands beside it, or it was given a place.
fn stands(keys: &ItemKeys, among: Among<'_>) -> bool {
    among.alone && keys.up.is_none() && !keys.is_placed()
}

/// A volume is turned before it gets a look: the choice of a transfer function depends on the axes in which it is
/// rendered.
fn volume(
    keys: &ItemKeys,
    place: DAffine3,
    (stored, held): (&Arc<Volume>, &Held),
    among: Among<'_>,
) -> Result<Loaded, DocumentError> {
    let mut input = input_of(Arc::clone(stored), held);
    let mut keys = keys.clone();
    if stands(&keys, among) {
        keys.up = Up::of(&input).said(&keys.file, among.reading.listener);
    }
    if let Some(axis) = keys.up {
        input.volume = held.turned(stored, axis)?;
    }
    let preferred = input.sample.and_then(|sample| sample.preferred_view());
    let files = input.description.files.clone();
    let (look, tf2d) = look_of(&keys, &input, among)?;
    let item = look.clone().item(input.volume).at(place);
    let loaded = Loaded::new(item, keys, files).looking(&look, tf2d);
    Ok(Loaded {
        wishes: look.wishes,
        preferred,
        ..loaded
    })
}

fn input_of(volume: Arc<Volume>, held: &Held) -> Input {
    Input {
        volume,
        description: held.description().clone(),
        sample: held.sample(),
        mesh: None,
    }
}

fn other(keys: &ItemKeys, place: DAffine3, held: &Held, among: Among<'_>) -> Result<Loaded, DocumentError> {
    let mut keys = keys.clone();
    let description = held.description();
    let mut frame = DAffine3::IDENTITY;
    let mut known_look = None;
    let item = match held.content() {
        HeldContent::Points(points) => {
            if held.kind() == DataKind::Points && stands(&keys, among) {
                keys.up = Up::of_points(points, description).said(&keys.file, among.reading.listener);
            }
            Item::points(Arc::clone(points), point_look(&keys))
        }
        HeldContent::Gaussians(gaussians) => {
            frame = gaussians.world_from_local().inverse();
            Item::gaussians(Arc::clone(gaussians))
        }
        HeldContent::Mesh(mesh) => {
            let input = values_of(mesh, description.clone())?;
            let (look, _) = known_look.insert(look_of(&keys, &input, among)?);
            Item::mesh(Arc::clone(mesh), look.transfer_function.clone())
        }
        HeldContent::Volume(volume) => {
            let input = input_of(Arc::clone(volume), held);
            let (look, _) = known_look.insert(look_of(&keys, &input, among)?);
            look.clone().item(input.volume)
        }
    };
    let up = keys
        .up
        .map_or(DAffine3::IDENTITY, |axis| upright::rotation(axis) * frame);
    let loaded = Loaded::new(item.at(place * up), keys, description.files.clone());
    Ok(match known_look {
        Some((look, tf2d)) => loaded.looking(&look, tf2d),
        None => loaded,
    })
}

impl Loaded {
    fn new(item: Item, keys: ItemKeys, files: Vec<PathBuf>) -> Self {
        Self {
            item,
            keys,
            files,
            wishes: Wishes::default(),
            preferred: None,
            gradient_opacity: None,
            tf2d: None,
        }
    }

    /// With a look that was chosen or given.
    fn looking(self, look: &Look, tf2d: Option<TransferFunction2d>) -> Self {
        Self {
            keys: ItemKeys {
                transfer_function: Some(look.transfer_function.clone()),
                ..self.keys
            },
            gradient_opacity: look.gradient_opacity.clone(),
            tf2d,
            ..self
        }
    }
}

fn point_look(keys: &ItemKeys) -> PointLook {
    let default = PointLook::default();
    PointLook {
        color: keys.color.unwrap_or(default.color),
        opacity: match keys.opacity {
            Some(Opacity::Share(share)) => share,
            _ => default.opacity,
        },
        radius: keys.radius,
    }
}

/// The look of values, and the transfer function of value and gradient whose marginal it is.
fn look_of(
    keys: &ItemKeys,
    input: &Input,
    among: Among<'_>,
) -> Result<(Look, Option<TransferFunction2d>), DocumentError> {
    let spacing = input.volume.grid().mean_spacing();
    let tf2d = match among.alone {
        true => transfer_function_2d(among.effects, keys, spacing, among.reading)?,
        false => None,
    };
    let look = match &tf2d {
        Some(function) => Look::from(function.marginal()?),
        None => look::resolve(keys, input, among.compositing, among.reading)?,
    };
    Ok((look, tf2d))
}

/// Largest number of samples of a row.
const ROW: usize = 32_768;

/// A mesh's values as rows of samples, from which a transfer function is chosen.
fn values_of(mesh: &Arc<Mesh>, description: Description) -> Result<Input, DocumentError> {
    let mut values = mesh.field().values.clone();
    // Rows of a grid have a longest length; missing samples in the last one do not count.
    let width = values.len().clamp(1, ROW);
    let rows = values.len().div_ceil(width);
    values.resize(rows * width, f32::NAN);
    let grid = Grid::centred([width, rows, 1], DVec3::ONE)?;
    let samples = Samples::F32(values.into());
    let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown)?;
    Ok(Input {
        volume: Arc::new(volume),
        description,
        sample: None,
        mesh: Some(Arc::clone(mesh)),
    })
}
