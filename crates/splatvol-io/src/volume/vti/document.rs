//! The XML part of a .vti file: its declarations, before any number is decoded.
//!
//! A file with raw appended data is neither XML nor text, so the header is cut off before `<AppendedData>` and
//! closed by hand; that element's own tag is parsed by itself. Document types and entities are refused by the
//! XML parser.

use std::borrow::Cow;
use std::rc::Rc;
use std::str::FromStr;

use glam::{DMat3, DVec3};
use roxmltree::{Document, Node};

use crate::IoError;
use crate::error::Context;
use crate::samples::{Endian, SampleType};
use crate::volume::vtk_array::{ArrayHead, Association, ImageGeometry};
use crate::xml;

const APPENDED: &[u8] = b"<AppendedData";

/// A .vti file cut into its header and its appended data.
pub(crate) struct Parts<'a> {
    /// A whole XML document, without the appended data's content.
    pub(crate) xml: Cow<'a, str>,
    /// The appended data after the underscore, to the end of the file.
    pub(crate) appended: Option<&'a [u8]>,
}

/// Cuts `bytes` before the content of `<AppendedData>`.
pub(crate) fn split<'a>(bytes: &'a [u8], context: &Context<'_>) -> Result<Parts<'a>, IoError> {
    let Some(tag) = find(bytes, APPENDED) else {
        return Ok(Parts {
            xml: String::from_utf8_lossy(bytes),
            appended: None,
        });
    };
    let content = tag
        + find(&bytes[tag..], b">")
            .ok_or_else(|| context.field("AppendedData", "", tag as u64, "a closed tag"))?
        + 1;
    let header = String::from_utf8_lossy(&bytes[..content - 1]);
    let xml = format!("{}/></VTKFile>", header.trim_end_matches('/'));
    let blanks = bytes[content..]
        .iter()
        .take_while(|byte| byte.is_ascii_whitespace())
        .count();
    let appended = bytes[content + blanks..].strip_prefix(b"_").ok_or_else(|| {
        let found = bytes[content + blanks..].first().copied().unwrap_or_default();
        let offset = (content + blanks) as u64;
        context.field(
            "AppendedData",
            char::from(found),
            offset,
            "content that starts with `_`",
        )
    })?;
    Ok(Parts {
        xml: Cow::Owned(xml),
        appended: Some(appended),
    })
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes.windows(pattern.len()).position(|window| window == pattern)
}

/// The document, without document type or entities.
pub(crate) fn parse<'a>(parts: &'a Parts<'_>, context: &Context<'_>) -> Result<Document<'a>, IoError> {
    xml::parse(&parts.xml, "XML", context)
}

/// Compression of the blocks of binary data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compressor {
    Zlib,
    /// Bare LZ4 blocks.
    Lz4,
}

/// Coding of binary data in this file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coding {
    pub(crate) endian: Endian,
    /// Bytes of each number in the header of a block of data: 4 or 8.
    pub(crate) header_word: usize,
    pub(crate) compressor: Option<Compressor>,
    /// True where the appended data are base64, false where they are raw.
    pub(crate) appended_base64: bool,
}

/// Location of an array's numbers.
pub(crate) enum Place<'a> {
    Ascii(Cow<'a, str>),
    Base64(Cow<'a, str>),
    /// Bytes (characters in base64) from the start of the appended data to the array, and to the next array.
    Appended {
        offset: u64,
        next: Option<u64>,
    },
}

/// The declarations of an `ImageData` file.
pub(crate) struct ImageFile<'a> {
    pub(crate) geometry: ImageGeometry,
    pub(crate) coding: Coding,
    pub(crate) arrays: Arrays<'a>,
}

impl<'a> ImageFile<'a> {
    pub(crate) fn from_xml(document: &'a Document<'a>, context: &Context<'_>) -> Result<Self, IoError> {
        let root = document.root_element();
        if !root.has_tag_name("VTKFile") {
            return Err(context.field("root element", root.tag_name().name(), None, "VTKFile"));
        }
        match root.attribute("type") {
            Some("ImageData") => (),
            other => {
                let found = other.unwrap_or("nothing");
                return Err(
                    context.unsupported(format!("VTK file of {found}; only ImageData is a regular volume"))
                );
            }
        }
        let image = only_child(root, "ImageData", context)?;
        let piece = only_child(image, "Piece", context)?;
        Ok(Self {
            geometry: geometry(image, piece, context)?,
            coding: coding(root, context)?,
            arrays: Arrays::of_piece(piece, offsets(document), context)?,
        })
    }
}

/// Offsets of all arrays of a file in its appended data, in order.
pub(crate) fn offsets(document: &Document<'_>) -> Rc<[u64]> {
    let elements = document.descendants();
    let mut offsets: Vec<u64> = elements
        .filter_map(|node| node.attribute("offset")?.parse().ok())
        .collect();
    offsets.sort_unstable();
    offsets.into()
}

/// The attributes of one piece.
pub(crate) struct Arrays<'a> {
    pub(crate) heads: Vec<ArrayHead>,
    /// The element of each head.
    elements: Vec<Node<'a, 'a>>,
    offsets: Rc<[u64]>,
}

impl<'a> Arrays<'a> {
    /// The arrays that a piece declares; `offsets` are those of the whole file.
    pub(crate) fn of_piece(
        piece: Node<'a, 'a>,
        offsets: Rc<[u64]>,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let mut arrays = Self {
            heads: Vec::new(),
            elements: Vec::new(),
            offsets,
        };
        for (tag, association) in [("PointData", Association::Point), ("CellData", Association::Cell)] {
            for data in piece.children().filter(|node| node.has_tag_name(tag)) {
                arrays.add(data, association, context)?;
            }
        }
        Ok(arrays)
    }

    fn add(
        &mut self,
        data: Node<'a, 'a>,
        association: Association,
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        for element in data.children().filter(Node::is_element) {
            let name = element.attribute("Name").unwrap_or_default();
            let components = match element.attribute("NumberOfComponents") {
                None => 1,
                Some(text) => text
                    .trim()
                    .parse()
                    .ok()
                    .filter(|n| (1..=1 << 16).contains(n))
                    .ok_or_else(|| {
                        context.field(
                            "NumberOfComponents",
                            text,
                            None,
                            format!("1 to 65536 for `{name}`"),
                        )
                    })?,
            };
            let type_name = element.attribute("type").unwrap_or("no type");
            self.heads.push(ArrayHead {
                association,
                name: name.to_owned(),
                components,
                type_name: type_name.to_owned(),
                sample_type: sample_type(type_name).filter(|_| element.has_tag_name("DataArray")),
                active: data.attribute("Scalars").is_some_and(|active| active == name),
                is_id: ["GlobalIds", "PedigreeIds"]
                    .iter()
                    .any(|ids| data.attribute(*ids) == Some(name)),
            });
            self.elements.push(element);
        }
        Ok(())
    }

    /// The element of array `index` in the document.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn range(&self, index: usize) -> std::ops::Range<usize> {
        self.elements[index].range()
    }

    /// Location of the numbers of array `index`.
    pub(crate) fn place(&self, index: usize, context: &Context<'_>) -> Result<Place<'a>, IoError> {
        self.place_of(self.elements[index], context)
    }

    /// Location of the numbers of a `DataArray`.
    pub(crate) fn place_of(
        &self,
        element: Node<'a, 'a>,
        context: &Context<'_>,
    ) -> Result<Place<'a>, IoError> {
        match element.attribute("format").unwrap_or("ascii") {
            "ascii" => Ok(Place::Ascii(text(element))),
            "binary" => Ok(Place::Base64(text(element))),
            "appended" => {
                let declared = element.attribute("offset").unwrap_or("nothing");
                let offset = declared
                    .trim()
                    .parse()
                    .map_err(|_| context.field("offset", declared, None, "a number of bytes"))?;
                let after = self.offsets.partition_point(|&other| other <= offset);
                let next = self.offsets.get(after).copied();
                Ok(Place::Appended { offset, next })
            }
            other => Err(context.unsupported(format!("DataArray format `{other}`"))),
        }
    }
}

/// Text of an element, without that of its children.
fn text<'a>(element: Node<'a, 'a>) -> Cow<'a, str> {
    let mut parts = element
        .children()
        .filter_map(|child| child.text().filter(|_| child.is_text()));
    let first = parts.next().unwrap_or_default();
    parts.fold(Cow::Borrowed(first), |joined, part| {
        match part.trim().is_empty() {
            true => joined,
            false => Cow::Owned(format!("{joined} {part}")),
        }
    })
}

pub(crate) fn only_child<'a>(
    parent: Node<'a, 'a>,
    tag: &str,
    context: &Context<'_>,
) -> Result<Node<'a, 'a>, IoError> {
    let mut found = parent.children().filter(|node| node.has_tag_name(tag));
    let child = found
        .next()
        .ok_or_else(|| context.field(tag, "", None, format!("an element <{tag}>")))?;
    match found.count() {
        0 => Ok(child),
        more => Err(context.unsupported(format!("{} <{tag}> elements; one is read", more + 1))),
    }
}

pub(crate) fn sample_type(name: &str) -> Option<SampleType> {
    Some(match name {
        "Int8" => SampleType::I8,
        "UInt8" => SampleType::U8,
        "Int16" => SampleType::I16,
        "UInt16" => SampleType::U16,
        "Int32" => SampleType::I32,
        "UInt32" => SampleType::U32,
        "Int64" => SampleType::I64,
        "UInt64" => SampleType::U64,
        "Float32" => SampleType::F32,
        "Float64" => SampleType::F64,
        _ => return None,
    })
}

pub(crate) fn coding(root: Node, context: &Context<'_>) -> Result<Coding, IoError> {
    let appended = root.children().find(|node| node.has_tag_name("AppendedData"));
    Ok(Coding {
        endian: match root.attribute("byte_order") {
            Some("LittleEndian") => Endian::Little,
            Some("BigEndian") => Endian::Big,
            other => {
                let expected = "LittleEndian or BigEndian";
                return Err(context.field("byte_order", other.unwrap_or_default(), None, expected));
            }
        },
        header_word: match root.attribute("header_type").unwrap_or("UInt32") {
            "UInt32" => 4,
            "UInt64" => 8,
            other => return Err(context.unsupported(format!("header_type `{other}`"))),
        },
        compressor: match root.attribute("compressor").unwrap_or_default() {
            "" => None,
            "vtkZLibDataCompressor" => Some(Compressor::Zlib),
            "vtkLZ4DataCompressor" => Some(Compressor::Lz4),
            other => {
                let known = "vtkZLibDataCompressor and vtkLZ4DataCompressor are read";
                return Err(context.unsupported(format!("compressor `{other}`; {known}")));
            }
        },
        appended_base64: match appended
            .and_then(|node| node.attribute("encoding"))
            .unwrap_or("base64")
        {
            "base64" => true,
            "raw" => false,
            other => return Err(context.unsupported(format!("AppendedData encoding `{other}`"))),
        },
    })
}

fn geometry(image: Node, piece: Node, context: &Context<'_>) -> Result<ImageGeometry, IoError> {
    let extent = extent(image, "WholeExtent", context)?;
    let of_piece = extent_of_piece(piece, extent, context)?;
    if of_piece != extent {
        return Err(context.unsupported(format!(
            "a piece of extent {of_piece:?} in a whole extent of {extent:?}; only whole images are read"
        )));
    }
    let direction = numbers(image, "Direction", context)?;
    Ok(ImageGeometry {
        extent,
        origin: numbers(image, "Origin", context)?.map_or(DVec3::ZERO, DVec3::from_array),
        spacing: numbers(image, "Spacing", context)?.map_or(DVec3::ONE, DVec3::from_array),
        // Row by row in the file.
        direction: direction.map_or(DMat3::IDENTITY, |rows| DMat3::from_cols_array(&rows).transpose()),
    })
}

fn extent_of_piece(
    piece: Node,
    whole: [[i64; 2]; 3],
    context: &Context<'_>,
) -> Result<[[i64; 2]; 3], IoError> {
    match piece.has_attribute("Extent") {
        true => extent(piece, "Extent", context),
        false => Ok(whole),
    }
}

pub(crate) fn extent(node: Node, field: &str, context: &Context<'_>) -> Result<[[i64; 2]; 3], IoError> {
    let ends: [i64; 6] =
        numbers(node, field, context)?.ok_or_else(|| context.field(field, "", None, "six whole numbers"))?;
    let extent = [[ends[0], ends[1]], [ends[2], ends[3]], [ends[4], ends[5]]];
    if extent.iter().any(|[first, last]| first > last) {
        return Err(context.field(field, format!("{ends:?}"), None, "first <= last on each axis"));
    }
    Ok(extent)
}

/// `N` numbers of an attribute; none where it is absent.
fn numbers<T: FromStr, const N: usize>(
    node: Node,
    field: &str,
    context: &Context<'_>,
) -> Result<Option<[T; N]>, IoError> {
    let Some(text) = node.attribute(field) else {
        return Ok(None);
    };
    let parsed: Result<Vec<T>, _> = text.split_whitespace().map(str::parse).collect();
    let numbers = parsed.ok().and_then(|numbers| numbers.try_into().ok());
    match numbers {
        Some(numbers) => Ok(Some(numbers)),
        None => Err(context.field(field, text, None, format!("{N} numbers"))),
    }
}
