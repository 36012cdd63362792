//! The metadata of an image or of an array: levels, axes, channels, and what a volume of it will be.

use splatvol_scene::LevelLayout;

use super::IoError;
use super::array::Array;
use super::folder::Folder;
use super::geometry;
use super::level::{ArrayLevel, Part};
use super::ome::{self, Image, Level};
use super::own::Own;
use crate::error::Context;
use crate::volume::{Description, Draft, ReadOptions, checked_dims};

/// An image and its arrays, or one array alone.
pub(super) struct Store {
    pub(super) folder: Folder,
    pub(super) arrays: Vec<Array>,
    image: Image,
    levels: Vec<Level>,
    own: Own,
    description: Description,
}

impl Store {
    /// Reads the metadata below a folder, and nothing else.
    pub(super) fn open(folder: &Folder, options: &ReadOptions) -> Result<Self, IoError> {
        let context = &Context::new("OME-Zarr", folder.path()).following(options);
        if let Some(array) = Array::open(folder)? {
            let level = Level {
                path: String::new(),
                scale: Vec::new(),
                translation: Vec::new(),
            };
            return Ok(Self {
                folder: folder.clone(),
                arrays: vec![array],
                image: Image::default(),
                levels: vec![level],
                own: Own::default(),
                description: Description::default(),
            });
        }
        let attributes = ome::attributes(folder)?.unwrap_or_default();
        let Some(image) = Image::new(&attributes, context)? else {
            return Self::open_series(folder, attributes.get("plate").is_some(), options, context);
        };
        let mut arrays = Vec::new();
        for level in &image.levels {
            arrays.push(open_level(folder, level, context)?);
        }
        let mut description = Description {
            levels: arrays
                .iter()
                .map(|array| geometry::spatial_sizes(array, &image))
                .collect(),
            is_labels: image.is_labels,
            ..Description::default()
        };
        if image.others > 0 {
            let warning = format!("the first of {} multi-scale images is read", image.others + 1);
            description.warnings.push(warning);
        }
        Ok(Self {
            folder: folder.clone(),
            own: Own::new(own_attributes(folder)?.as_ref(), context)?,
            levels: image.levels.clone(),
            arrays,
            image,
            description,
        })
    }

    /// A folder of several images, as bioformats2raw writes them: `0`, `1`, ...
    fn open_series(
        folder: &Folder,
        plate: bool,
        options: &ReadOptions,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        if plate {
            return Err(context.unsupported("a plate; name the folder of one of its images"));
        }
        let names = folder.series(context)?;
        let asked = |name: &&String| options.series.as_ref().is_none_or(|series| series == *name);
        let Some(name) = names.iter().find(asked) else {
            let what = match &options.series {
                Some(series) => format!(
                    "series \"{series}\" was asked for; to choose from: {}",
                    names.join(", ")
                ),
                None => "neither multiscales nor an array".to_owned(),
            };
            return Err(context.unsupported(what));
        };
        let inner = folder.join(name);
        inner.check_inside(folder, context)?;
        if Array::open(&inner)?.is_none()
            && ome::attributes(&inner)?.is_none_or(|value| value.get("multiscales").is_none())
        {
            return Err(context.unsupported(format!("neither multiscales nor an array, here and in {name}")));
        }
        let mut store = Self::open(&inner, options)?;
        if names.len() > 1 {
            if options.series.is_none() {
                let warning = format!("series {name} is read; to choose from: {}", names.join(", "));
                store.description.warnings.push(warning);
            }
            store.description.series = names;
        }
        Ok(store)
    }

    /// Refuses a level that is not there.
    pub(super) fn check_level(&self, options: &ReadOptions) -> Result<usize, IoError> {
        if options.level < self.levels.len() {
            return Ok(options.level);
        }
        let size = |(i, array): (usize, &Array)| {
            let [x, y, z] = geometry::spatial_sizes(array, &self.image);
            format!("{i}: {x} x {y} x {z}")
        };
        let list: Vec<String> = self.arrays.iter().enumerate().map(size).collect();
        let what = format!(
            "level {} was asked for; to choose from: {}",
            options.level,
            list.join(", ")
        );
        let context = Context::new("OME-Zarr", self.folder.path()).following(options);
        Err(context.unsupported(what))
    }

    /// All of a level's volume but its samples, and its part of the array.
    pub(super) fn draft(&self, level: usize, options: &ReadOptions) -> Result<(Draft, Part), IoError> {
        let (array, image) = (&self.arrays[level], &self.image);
        let context = &Context::new("Zarr array", array.folder.path()).following(options);
        let axes = geometry::axes(array, image);
        let mut description = self.description.clone();
        let (part, times) = geometry::part(array, (&axes, image), &mut description, options, context)?;
        description.format = match image.version.as_str() {
            "" => format!("Zarr {}", array.version),
            version => format!("OME-Zarr {version} (Zarr {})", array.version),
        };
        description.stored_type = array.stored_type();
        description.orientation = match (self.levels[level].scale.is_empty(), self.own.world_from_voxel) {
            (_, Some(_)) => "directions that splatvol kept beside OME's metadata".to_owned(),
            (true, None) => "no geometry in the file, spacing 1".to_owned(),
            (false, None) => {
                "scale and translation of OME; the file does not say how an object lies".to_owned()
            }
        };
        description.oriented = self.own.oriented;
        description.files = vec![array.folder.path().to_owned()];
        let sizes = geometry::spatial_sizes(array, image).map(|size| i64::try_from(size).unwrap_or(i64::MAX));
        let mut draft = Draft::new(checked_dims(&sizes, "shape", None, context)?, description);
        draft.set_times(times, options);
        geometry::place(&mut draft, &self.levels[level], &axes, &part.spatial);
        if let Some(world_from_finest) = self.own.world_from_voxel {
            let finest = geometry::spatial_sizes(&self.arrays[0], image);
            draft.world_from_voxel = world_from_finest * geometry::finest_from_level(finest, draft.dims);
        }
        draft.rescale = self.own.rescale;
        draft.grid(context)?;
        Ok((draft, part))
    }

    /// A level, read chunk by chunk.
    pub(super) fn level(
        &self,
        level: usize,
        (draft, part): (&Draft, Part),
        options: &ReadOptions,
    ) -> Result<ArrayLevel, IoError> {
        let array = self.arrays[level].clone();
        let layout = LevelLayout {
            grid: draft.grid(&Context::new("Zarr array", array.folder.path()))?,
            chunk: [1; 3],
            element: array.element(),
            rescale: draft.rescale,
            fill: 0.0,
        };
        Ok(ArrayLevel::new(array, part, layout, options.allow_outside))
    }
}

fn open_level(folder: &Folder, level: &Level, context: &Context<'_>) -> Result<Array, IoError> {
    let inner = folder.join(&level.path);
    inner.check_inside(folder, context)?;
    Array::open(&inner)?.ok_or_else(|| IoError::MissingDataFile {
        data: inner.path().to_owned(),
        path: folder.path().to_owned(),
    })
}

/// The attributes of a group, with those that are not OME's.
fn own_attributes(folder: &Folder) -> Result<Option<serde_json::Value>, IoError> {
    if let Some(attributes) = folder.json(".zattrs")? {
        return Ok(Some(attributes));
    }
    let metadata = folder.json("zarr.json")?;
    Ok(metadata.and_then(|metadata| metadata.get("attributes").cloned()))
}
