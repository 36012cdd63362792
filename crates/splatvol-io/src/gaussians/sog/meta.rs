//! Contents of `meta.json`.

use serde_json::Value;

use crate::IoError;
use crate::error::Context;
use crate::json::Node;

/// Mapping from bytes to numbers.
pub(super) enum Numbers {
    /// Version 2: one of 256 numbers.
    Codebook(Vec<f64>),
    /// Version 1: ends of the range of every channel.
    Bounds { min: Vec<f64>, max: Vec<f64> },
}

impl Numbers {
    /// The number that a byte of a channel stands for; channels have been counted, codebooks have 256 entries.
    pub(super) fn at(&self, channel: usize, byte: u8) -> f64 {
        match self {
            Self::Codebook(numbers) => numbers[usize::from(byte)],
            Self::Bounds { min, max } => {
                min[channel] + (max[channel] - min[channel]) * f64::from(byte) / 255.0
            }
        }
    }

    fn parse(node: &Node<'_>, channels: usize) -> Result<Self, IoError> {
        if let Some(codebook) = node.get("codebook") {
            let mut numbers = numbers(&codebook, 1)?;
            if numbers.len() > 256 {
                return Err(codebook.error("at most 256 numbers"));
            }
            let last = numbers[numbers.len() - 1];
            numbers.resize(256, last);
            return Ok(Self::Codebook(numbers));
        }
        Ok(Self::Bounds {
            min: numbers(&node.require("mins")?, channels)?,
            max: numbers(&node.require("maxs")?, channels)?,
        })
    }
}

/// Means: two pictures and the bounds of their logarithms.
pub(super) struct Means {
    pub(super) min: Vec<f64>,
    pub(super) max: Vec<f64>,
    pub(super) files: [String; 2],
}

/// A picture and the mapping of its bytes to numbers.
pub(super) struct Layer {
    pub(super) numbers: Numbers,
    pub(super) file: String,
}

/// Harmonics above degree 0.
pub(super) struct Harmonics {
    pub(super) numbers: Numbers,
    pub(super) bands: Option<u32>,
    pub(super) count: Option<usize>,
    pub(super) centroids: String,
    pub(super) labels: String,
}

/// The whole document.
pub(super) struct Meta {
    pub(super) version: u32,
    pub(super) count: usize,
    pub(super) antialiased: bool,
    pub(super) means: Means,
    pub(super) scales: Layer,
    pub(super) quats: String,
    pub(super) colors: Layer,
    pub(super) harmonics: Option<Harmonics>,
}

impl Meta {
    pub(super) fn parse(document: &Value, context: &Context<'_>) -> Result<Self, IoError> {
        let root = Node::root(document, context);
        let version = match root.get("version") {
            None => 1,
            Some(node) if node.number()? == 2.0 => 2,
            Some(node) => return Err(node.error("2, or no version")),
        };
        let means = root.require("means")?;
        let count = match root.get("count") {
            Some(count) => whole(&count)?,
            None => {
                let shape = means.require("shape")?;
                let sizes = shape.items()?;
                whole(sizes.first().ok_or_else(|| shape.error("a count"))?)?
            }
        };
        let layer = |name: &str, channels| {
            let node = root.require(name)?;
            Ok::<_, IoError>(Layer {
                numbers: Numbers::parse(&node, channels)?,
                file: file(&node, 0)?,
            })
        };
        Ok(Self {
            version,
            count,
            antialiased: root.get("antialias").is_some_and(|node| node.is_true()),
            scales: layer("scales", 3)?,
            quats: file(&root.require("quats")?, 0)?,
            colors: layer("sh0", 4)?,
            harmonics: root
                .get("shN")
                .map(|node| harmonics(&node))
                .transpose()?
                .flatten(),
            means: Means {
                min: numbers(&means.require("mins")?, 3)?,
                max: numbers(&means.require("maxs")?, 3)?,
                files: [file(&means, 0)?, file(&means, 1)?],
            },
        })
    }
}

fn harmonics(node: &Node<'_>) -> Result<Option<Harmonics>, IoError> {
    let bands = node.get("bands").map(|bands| whole(&bands)).transpose()?;
    if bands == Some(0) {
        return Ok(None);
    }
    Ok(Some(Harmonics {
        numbers: Numbers::parse(node, 1)?,
        bands: bands.map(|bands| bands.min(4) as u32),
        count: node.get("count").map(|count| whole(&count)).transpose()?,
        centroids: file(node, 0)?,
        labels: file(node, 1)?,
    }))
}

/// A whole number above zero.
fn whole(node: &Node<'_>) -> Result<usize, IoError> {
    let number = node.number()?;
    if number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX) {
        Ok(number as usize)
    } else {
        Err(node.error("a whole number"))
    }
}

/// An array of at least `at_least` finite numbers; a single number counts as an array.
fn numbers(node: &Node<'_>, at_least: usize) -> Result<Vec<f64>, IoError> {
    if at_least == 1
        && let Ok(number) = node.number()
    {
        return Ok(vec![number]);
    }
    let numbers: Vec<f64> = node.items()?.iter().map(Node::number).collect::<Result<_, _>>()?;
    if numbers.len() < at_least {
        return Err(node.error(&format!("at least {at_least} numbers")));
    }
    Ok(numbers)
}

fn file(node: &Node<'_>, index: usize) -> Result<String, IoError> {
    let files = node.require("files")?;
    let items = files.items()?;
    let name = items.get(index).and_then(Node::text);
    name.map(str::to_owned)
        .ok_or_else(|| files.error(&format!("at least {} names of files", index + 1)))
}
