//! Writes .vti files in every coding.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// One way to write the same file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Style {
    pub(crate) place: &'static str,
    pub(crate) wide: bool,
    pub(crate) zlib: bool,
    pub(crate) big: bool,
}

impl Style {
    pub(crate) const PLAIN: Self = Self {
        place: "base64",
        wide: false,
        zlib: false,
        big: false,
    };

    pub(crate) fn all() -> Vec<Self> {
        let mut styles = Vec::new();
        for place in ["ascii", "base64", "appended-base64", "appended-raw"] {
            for bits in 0..8 {
                let [wide, zlib, big] = [1, 2, 4].map(|bit| bits & bit != 0);
                styles.push(Self {
                    place,
                    wide,
                    zlib,
                    big,
                });
            }
        }
        styles
    }

    pub(crate) fn words(self, values: &[usize]) -> Vec<u8> {
        let word = |&value: &usize| match (self.wide, self.big) {
            (false, false) => (value as u32).to_le_bytes().to_vec(),
            (false, true) => (value as u32).to_be_bytes().to_vec(),
            (true, false) => (value as u64).to_le_bytes().to_vec(),
            (true, true) => (value as u64).to_be_bytes().to_vec(),
        };
        values.iter().flat_map(word).collect()
    }

    /// Header and data of one array, in blocks of 64 bytes where compressed.
    pub(crate) fn parts(self, bytes: &[u8]) -> [Vec<u8>; 2] {
        if !self.zlib {
            return [self.words(&[bytes.len()]), bytes.to_vec()];
        }
        let blocks: Vec<Vec<u8>> = bytes.chunks(64).map(zlib).collect();
        let mut header = vec![blocks.len(), 64, bytes.len() % 64];
        header.extend(blocks.iter().map(Vec::len));
        [self.words(&header), blocks.concat()]
    }

    fn encoded(self, bytes: &[u8]) -> Vec<u8> {
        let [header, data] = self.parts(bytes);
        let base64 = |bytes: &[u8]| STANDARD.encode(bytes);
        match (self.place, self.zlib) {
            ("appended-raw", _) => [header, data].concat(),
            (_, true) => (base64(&header) + &base64(&data)).into_bytes(),
            (_, false) => base64(&[header, data].concat()).into_bytes(),
        }
    }
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A file under construction: arrays of point data, then of cell data.
pub(crate) struct File {
    style: Style,
    image: String,
    pub(crate) point: String,
    cell: String,
    pub(crate) appended: Vec<u8>,
}

impl File {
    pub(crate) fn new(style: Style, image: &str) -> Self {
        Self {
            style,
            image: image.to_owned(),
            point: String::new(),
            cell: String::new(),
            appended: Vec::new(),
        }
    }

    pub(crate) fn array(&mut self, attributes: &str, little: &[u8], width: usize, text: &str) -> String {
        let mut bytes = little.to_vec();
        if self.style.big {
            bytes.chunks_mut(width).for_each(<[u8]>::reverse);
        }
        let encoded = self.style.encoded(&bytes);
        match self.style.place {
            "ascii" => format!("<DataArray {attributes} format=\"ascii\">\n{text}\n</DataArray>\n"),
            "base64" => {
                let encoded = String::from_utf8(encoded).unwrap();
                format!("<DataArray {attributes} format=\"binary\">\n  {encoded}\n</DataArray>\n")
            }
            _ => {
                let offset = self.appended.len();
                self.appended.extend(encoded);
                format!("<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>\n")
            }
        }
    }

    pub(crate) fn point_i16(&mut self, attributes: &str, values: &[i16]) {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let array = self.array(&format!("type=\"Int16\" {attributes}"), &bytes, 2, &join(values));
        self.point.push_str(&array);
    }

    pub(crate) fn cell_u8(&mut self, attributes: &str, values: &[u8]) {
        let array = self.array(&format!("type=\"UInt8\" {attributes}"), values, 1, &join(values));
        self.cell.push_str(&array);
    }

    pub(crate) fn bytes(&self, point_attributes: &str) -> Vec<u8> {
        let style = self.style;
        let order = if style.big { "BigEndian" } else { "LittleEndian" };
        let header = if style.wide { "UInt64" } else { "UInt32" };
        let compressor = if style.zlib {
            " compressor=\"vtkZLibDataCompressor\""
        } else {
            ""
        };
        let Self {
            image, point, cell, ..
        } = self;
        let mut bytes = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{order}\" \
             header_type=\"{header}\"{compressor}>\n<ImageData {image}>\n<Piece>\n<PointData{point_attributes}>\n\
             {point}</PointData>\n<CellData>\n{cell}</CellData>\n</Piece>\n</ImageData>\n"
        )
        .into_bytes();
        if let Some(encoding) = style.place.strip_prefix("appended-") {
            bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").into_bytes());
            bytes.extend(&self.appended);
            bytes.extend(b"\n</AppendedData>\n");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }
}

fn join<T: ToString>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

pub(crate) const IMAGE: &str = "WholeExtent=\"0 4 0 3 0 2\" Origin=\"1 2 3\" Spacing=\"1 2 0.5\"";

/// 60 samples with no two equal bytes in a row.
pub(crate) fn values() -> Vec<i16> {
    (0..60).map(|i| (i * 517 - 9000) as i16).collect()
}

/// A file with an array before and after the wanted one.
pub(crate) fn file(style: Style) -> Vec<u8> {
    let mut file = File::new(style, IMAGE);
    let other: Vec<i16> = values().iter().map(|value| -value).collect();
    file.point_i16("Name=\"first\"", &other);
    file.point_i16("Name=\"second\"", &values());
    file.cell_u8("Name=\"third\"", &[7; 24]);
    file.bytes(" Scalars=\"second\"")
}
