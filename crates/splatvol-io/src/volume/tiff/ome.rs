//! OME-XML in a TIFF's description: sizes, order of dimensions, physical sizes, and which page holds which plane
//! (`TiffData`; <https://docs.openmicroscopy.org/ome-model/latest/ome-tiff/specification.html>).

use std::path::{Path, PathBuf};

use crate::tiff_pages::tag;
use glam::DVec3;
use roxmltree::Node;
use splatvol_scene::LengthUnit;

use super::description::{Layout, OWN_FILE, Place};
use crate::IoError;
use crate::error::Context;
use crate::files;
use crate::source::{companion, read_file};
use crate::tiff_pages::Pages;
use crate::volume::{ReadOptions, length_unit};
use crate::xml;

/// A plane named several times lies where it is named last; a file that names all of them again and again is no image.
const MOST_TIMES_NAMED: usize = 16;
/// Bytes of text that name a plane at least, where planes lie in other files.
const LEAST_TEXT: usize = 8;
/// Maximum number of images that are listed.
const SHOWN: usize = 50;

pub(super) fn layout(
    text: &str,
    count: usize,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Layout, IoError> {
    let text = text.trim_end_matches('\0');
    match metadata_file(text, context)? {
        Some(name) => {
            let path = companion(&name, "OME-XML MetadataFile", None, context)?;
            layout_of(&description_of(&path, context)?, count, options, context)
        }
        None => layout_of(text, count, options, context),
    }
}

/// The file that holds the description, where this one holds pixels only.
fn metadata_file(text: &str, context: &Context<'_>) -> Result<Option<String>, IoError> {
    let document = xml::parse(text, "OME-XML", context)?;
    let mut children = document.root_element().children();
    let only = children.find(|node| node.tag_name().name() == "BinaryOnly");
    Ok(only
        .and_then(|node| node.attribute("MetadataFile"))
        .map(str::to_owned))
}

/// The text of a companion file, or of the first page of another TIFF.
fn description_of(path: &Path, context: &Context<'_>) -> Result<String, IoError> {
    let bytes = read_file(path, context)?;
    let text = match String::from_utf8(bytes) {
        Ok(text) if text.trim_start().starts_with(['<', '\u{feff}']) => Some(text),
        _ => Pages::open(path, context)?.text(tag::IMAGE_DESCRIPTION, context),
    };
    text.ok_or_else(|| {
        let expected = "a file of OME-XML, or a TIFF that holds it";
        context.field("OME-XML MetadataFile", path.display(), None, expected)
    })
}

fn layout_of(
    text: &str,
    count: usize,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Layout, IoError> {
    let document = xml::parse(text.trim_start_matches('\u{feff}'), "OME-XML", context)?;
    let named = |node: &Node<'_, '_>, name: &str| node.is_element() && node.tag_name().name() == name;
    let images: Vec<Node<'_, '_>> = document
        .root_element()
        .children()
        .filter(|node| named(node, "Image"))
        .collect();
    let series: Vec<String> = images
        .iter()
        .take(SHOWN)
        .enumerate()
        .map(|(i, image)| format!("{i}: {}", image.attribute("Name").unwrap_or("without a name")))
        .collect();
    let asked = |(i, image): &(usize, &Node<'_, '_>)| {
        options.series.as_ref().is_none_or(|name| {
            *name == i.to_string() || [image.attribute("Name"), image.attribute("ID")].contains(&Some(name))
        })
    };
    let Some((index, image)) = images.iter().enumerate().find(asked) else {
        let asked = options.series.as_deref().unwrap_or("0");
        let what = format!(
            "image \"{asked}\" was asked for; to choose from: {}",
            series.join(", ")
        );
        return Err(context.unsupported(what));
    };
    let pixels = image.children().find(|node| named(node, "Pixels"));
    let pixels =
        pixels.ok_or_else(|| context.field("OME-XML Pixels", "", None, "this element, which is missing"))?;
    let pixels = OmePixels {
        pixels,
        most_planes: count.max(text.len() / LEAST_TEXT),
        context,
    };
    let mut layout = pixels.layout(count, images.len() == 1)?;
    if images.len() > 1 {
        layout.series = series;
        if options.series.is_none() {
            let warning = format!("image {index} of {} is read", images.len());
            layout.warnings.push(warning);
        }
    }
    Ok(layout)
}

struct OmePixels<'x, 'c> {
    pixels: Node<'x, 'x>,
    /// Planes that the pages of this file, or the names of others, justify.
    most_planes: usize,
    context: &'c Context<'c>,
}

impl OmePixels<'_, '_> {
    fn size(&self, name: &str) -> Result<usize, IoError> {
        let value = self.pixels.attribute(name).unwrap_or("1");
        let size = value.parse().ok().filter(|&size: &usize| size > 0);
        size.ok_or_else(|| self.context.field(name, value, None, "a positive number"))
    }

    fn children(&self, name: &str) -> impl Iterator<Item = Node<'_, '_>> {
        self.pixels
            .children()
            .filter(move |node| node.tag_name().name() == name)
    }

    fn layout(&self, count: usize, alone: bool) -> Result<Layout, IoError> {
        let samples = self
            .children("Channel")
            .filter_map(|channel| channel.attribute("SamplesPerPixel"));
        let samples: usize = samples
            .filter_map(|samples| samples.parse().ok())
            .next()
            .unwrap_or(1);
        let (slices, times) = (self.size("SizeZ")?, self.size("SizeT")?);
        let channels = (self.size("SizeC")? / samples.max(1)).max(1);
        let total = slices
            .checked_mul(times)
            .and_then(|product| product.checked_mul(channels));
        let total = total.filter(|&total| total <= self.most_planes).ok_or_else(|| {
            let shown = format!("{slices} x {channels} x {times}");
            let expected = format!("slices, channels and times for the {count} pages of this file");
            self.context
                .field("OME-XML SizeZ, SizeC, SizeT", shown, None, expected)
        })?;
        let mut layout = Layout::plain(1);
        layout.format = "OME-TIFF";
        layout.orientation = "spacing of OME; the file does not say how an object lies";
        (layout.slices, layout.times) = (slices, times);
        let names: Vec<Option<&str>> = self
            .children("Channel")
            .map(|channel| channel.attribute("Name"))
            .collect();
        let name = |i: usize| {
            let name = names.get(i).copied().flatten();
            name.map_or_else(|| format!("channel {i}"), str::to_owned)
        };
        layout.channels = (0..channels).map(name).collect();
        (layout.pages, layout.files) = self.pages([slices, channels, times], total, count, alone)?;
        self.calibrate(&mut layout)?;
        Ok(layout)
    }

    /// Page of every plane, slices fastest, then channels; and the other files that hold some.
    fn pages(
        &self,
        sizes: [usize; 3],
        total: usize,
        count: usize,
        alone: bool,
    ) -> Result<(Vec<Place>, Vec<PathBuf>), IoError> {
        let order = self.pixels.attribute("DimensionOrder").unwrap_or("XYZCT");
        let axes: Vec<usize> = order.chars().filter_map(|axis| "ZCT".find(axis)).collect();
        let mut sorted = axes.clone();
        sorted.sort_unstable();
        if sorted != [0, 1, 2] {
            return Err(self
                .context
                .field("DimensionOrder", order, None, "an order such as XYZCT"));
        }
        // Number of a plane in the file's order from its slice, channel and time, and back to ours.
        let strides = {
            let mut strides = [0; 3];
            let mut stride = 1;
            for &axis in &axes {
                strides[axis] = stride;
                stride *= sizes[axis];
            }
            strides
        };
        let ours = |plane: usize| {
            let at = [0, 1, 2].map(|axis| plane / strides[axis] % sizes[axis]);
            at[0] + sizes[0] * (at[1] + sizes[1] * at[2])
        };
        let mut pages = vec![None; total];
        let mut others = Vec::new();
        let mut named = 0;
        for data in self.children("TiffData") {
            let number = |name: &str| data.attribute(name).and_then(|value| value.parse::<usize>().ok());
            let file = self.file(&data, &mut others)?;
            let first = ["FirstZ", "FirstC", "FirstT"].map(|name| number(name).unwrap_or(0));
            let start: usize = (0..3).map(|axis| first[axis].min(total) * strides[axis]).sum();
            // Without a page, planes follow each other from the first; with one, it is one plane.
            let planes = number("PlaneCount").unwrap_or(match number("IFD") {
                Some(_) => 1,
                None => total,
            });
            let page = number("IFD").unwrap_or(0);
            let planes = planes.min(total.saturating_sub(start));
            named += planes;
            if named > MOST_TIMES_NAMED.saturating_mul(total) {
                let expected = format!("each of {total} planes once");
                let found = format!("{named} planes and more");
                return Err(self.context.field("OME-XML TiffData", found, None, expected));
            }
            for offset in 0..planes {
                let page = page.saturating_add(offset);
                pages[ours(start + offset)] = Some(Place { file, page });
            }
        }
        if alone && pages.iter().all(Option::is_none) {
            (0..total).for_each(|plane| pages[ours(plane)] = Some(Place::own(plane)));
        }
        let known: Option<Vec<Place>> = pages.into_iter().collect();
        let here = |place: &Place| place.file != OWN_FILE || place.page < count;
        let known = known.filter(|pages| pages.iter().all(here));
        let known = known.map(|pages| (pages, others));
        known.ok_or_else(|| {
            let expected = format!("one of the {count} pages for each of {total} planes");
            self.context.field("OME-XML TiffData", "", None, expected)
        })
    }

    /// Index of the file that holds planes; other files than this one are added to `others`.
    ///
    /// A file that was renamed since still holds all planes; one that does not is recognised by its pages.
    fn file(&self, data: &Node<'_, '_>, others: &mut Vec<PathBuf>) -> Result<usize, IoError> {
        let own = self.context.path.file_name().map(|name| name.to_string_lossy());
        let named = data.children().find_map(|node| node.attribute("FileName"));
        let other = named.filter(|name| {
            own.as_deref() != Some(name) && files::exists(&self.context.path.with_file_name(name))
        });
        let Some(name) = other else {
            return Ok(OWN_FILE);
        };
        let path = companion(name, "OME-XML FileName", None, self.context)?;
        let known = others.iter().rposition(|other| *other == path);
        Ok(1 + known.unwrap_or_else(|| {
            others.push(path);
            others.len() - 1
        }))
    }

    fn calibrate(&self, layout: &mut Layout) -> Result<(), IoError> {
        let mut units = Vec::new();
        let mut spacing = [None; 3];
        for (axis, name) in ["PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"]
            .into_iter()
            .enumerate()
        {
            let Some(value) = self.pixels.attribute(name) else {
                continue;
            };
            let size = value
                .parse()
                .ok()
                .filter(|size: &f64| size.is_finite() && *size > 0.0);
            let bad = || self.context.field(name, value, None, "a positive number");
            spacing[axis] = Some(size.ok_or_else(bad)?);
            let unit = self.pixels.attribute(&*format!("{name}Unit")).unwrap_or("µm");
            units.push(unit.to_owned());
        }
        let x = spacing[0].unwrap_or(1.0);
        layout.spacing = DVec3::new(x, spacing[1].unwrap_or(x), spacing[2].unwrap_or(x));
        layout.unit = match units.first() {
            Some(unit) if units.iter().all(|other| other == unit) => {
                length_unit(unit).unwrap_or(LengthUnit::Unknown)
            }
            Some(_) => {
                layout
                    .warnings
                    .push(format!("sizes are in different units: {}", units.join(", ")));
                LengthUnit::Unknown
            }
            None => LengthUnit::Unknown,
        };
        Ok(())
    }
}
