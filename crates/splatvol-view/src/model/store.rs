//! Data of items in memory, by the keys by which they are read: a change of look or place reads nothing again.

use splatvol::{Grid, Mesh, Volume};
use splatvol_document::held::HeldContent;
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Document, DocumentError, Held, Reading};

/// Bins of a histogram.
const BINS: usize = 256;

/// What is known about the data of an item.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// What they are, for a person: `256 x 256 x 109 u8`; of a volume that is read in chunks also its overview's size, of which
    /// the values here are.
    pub summary: String,
    /// Range and histogram of the values, if they are a volume or a mesh.
    pub values: Option<Values>,
    /// What the file has to choose from.
    pub choices: Choices,
}

/// What a file has to choose from: channels and series by their names, and so on; few or none where there is no choice.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Choices {
    /// Names of channels.
    pub channels: Vec<String>,
    /// Number of time points.
    pub times: usize,
    /// Samples along x, y, z of every level of detail, the finest first.
    pub levels: Vec<[usize; 3]>,
    /// Descriptions of the series of a folder.
    pub series: Vec<String>,
}

/// The values of a volume or a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    /// Whether they are those of a grid, of which there are gradients.
    pub is_grid: bool,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Counts of equal bins over the range.
    pub histogram: Vec<u64>,
    /// World length to which opacities refer unless a transfer function says otherwise: the mean spacing.
    pub spacing: f64,
    /// Symbol of the unit of lengths, or empty.
    pub unit: &'static str,
}

/// The data, and what is known about them.
#[derive(Debug, Default)]
pub(super) struct Store {
    entries: Vec<(ItemKeys, Held, Facts)>,
}

impl Store {
    /// Reads whatever the document shows and is not here; forgets what it does not name.
    pub(super) fn read(&mut self, document: &Document, reading: Reading<'_>) -> Result<(), DocumentError> {
        let several = document.items.len() > 1;
        for (index, item) in document.items.iter().enumerate() {
            let keys = reading_keys(item);
            let known = self.entries.iter().any(|(of, ..)| *of == keys);
            if known || !item.is_visible() {
                continue;
            }
            let held = Held::read(item, reading).map_err(|error| match several {
                true => error.of_index(index),
                false => error,
            })?;
            let facts = facts(&held);
            self.entries.push((keys, held, facts));
        }
        let wanted: Vec<ItemKeys> = document.items.iter().map(reading_keys).collect();
        self.entries.retain(|(keys, ..)| wanted.contains(keys));
        Ok(())
    }

    /// The data of each item, where they are here.
    pub(super) fn held(&self, document: &Document) -> Vec<Option<Held>> {
        let of = |item| self.entry(item).map(|(_, held, _)| held.clone());
        document.items.iter().map(of).collect()
    }

    /// What is known about each item.
    pub(super) fn facts(&self, document: &Document) -> Vec<Option<Facts>> {
        let of = |item| self.entry(item).map(|(.., facts)| facts.clone());
        document.items.iter().map(of).collect()
    }

    /// The same without volumes that are read in chunks: whoever draws beside the window opens them again, with a budget and chunks
    /// of its own.
    pub(super) fn without_chunks(&self) -> Self {
        let is_whole = |held: &Held| match held.content() {
            HeldContent::Volume(volume) => volume.chunks().is_none(),
            _ => true,
        };
        let whole = self.entries.iter().filter(|(_, held, _)| is_whole(held));
        Self {
            entries: whole.cloned().collect(),
        }
    }

    fn entry(&self, item: &ItemKeys) -> Option<&(ItemKeys, Held, Facts)> {
        let keys = reading_keys(item);
        self.entries.iter().find(|(of, ..)| *of == keys)
    }
}

/// The keys that matter when an item is read.
pub(super) fn reading_keys(item: &ItemKeys) -> ItemKeys {
    ItemKeys {
        visible: None,
        up: None,
        scale: None,
        rotate: None,
        translate: None,
        tf: None,
        cmap: None,
        clim: None,
        opacity: None,
        iso: None,
        unit_distance: None,
        labels: None,
        color: None,
        radius: None,
        transfer_function: None,
        ..item.clone()
    }
}

fn facts(held: &Held) -> Facts {
    let (summary, values) = match held.content() {
        HeldContent::Volume(volume) => (of_volume(volume), Some(values(volume))),
        HeldContent::Mesh(mesh) => {
            let summary = format!("mesh of {} samples", mesh.positions().len());
            (summary, Some(values_of_mesh(mesh)))
        }
        HeldContent::Points(points) => (format!("{} points", points.positions().len()), None),
        HeldContent::Gaussians(gaussians) => (format!("{} Gaussians", gaussians.len()), None),
    };
    let description = held.description();
    let choices = Choices {
        channels: description.channels.clone(),
        times: description.times,
        levels: description.levels.clone(),
        series: description.series.clone(),
    };
    Facts {
        summary,
        values,
        choices,
    }
}

fn of_volume(volume: &Volume) -> String {
    let sides = |grid: &Grid| {
        let [x, y, z] = grid.dims();
        format!("{x} x {y} x {z}")
    };
    let own = format!("{} {}", sides(volume.finest_grid()), volume.samples().type_name());
    match volume.chunks() {
        Some(_) => format!("{own} in chunks, overview {}", sides(volume.grid())),
        None => own,
    }
}

fn values(volume: &Volume) -> Values {
    Values {
        is_grid: true,
        range: volume.value_range(),
        histogram: volume.histogram(BINS),
        spacing: volume.finest_grid().mean_spacing(),
        unit: volume.unit().symbol(),
    }
}

fn values_of_mesh(mesh: &Mesh) -> Values {
    Values {
        is_grid: false,
        range: mesh.value_range().map(f64::from),
        histogram: mesh.histogram(BINS),
        spacing: mesh.mean_spacing(),
        unit: "",
    }
}
