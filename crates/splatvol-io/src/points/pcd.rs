//! PCD, the Point Cloud Library's format (versions .5 to .7): text, binary, or binary compressed by LZF.
//!
//! Fields come in any order and type. Colours are three fields, or one packed as `0xaarrggbb` in four bytes, which may
//! be declared to be a float. NaN marks a missing point of an organised cloud. The viewpoint says where the scanner
//! stood; points are in the world already and stay where they are.

mod header;
mod lzf;

use std::path::Path;

use glam::DVec3;

use super::LoadedPoints;
use super::columns::{ALPHA, RED, ROLES, Row, X, columns_of_roles};
use super::gather::{ColorKind, Gather};
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError, ReadOptions};
pub(super) use header::is_header;
use header::{Data, Field, Header};

/// Reads a PCD file.
///
/// # Errors
/// A malformed header, no field x, y or z, or data that differ from what the header describes.
pub fn read(path: &Path, options: &ReadOptions) -> Result<LoadedPoints, IoError> {
    let context = &Context::new("PCD", path);
    let bytes = read_file(path, context)?;
    let header = Header::parse(&bytes, context)?;
    let columns = Columns::new(&header, context)?;
    let mut gather = Gather::new(columns.present(), options);
    gather.check_count(header.points, context)?;
    let mut description = describe(&header, path);
    let data = &bytes[header.length..];
    match header.data {
        Data::Ascii => read_text(data, &header, &columns, &mut gather, context)?,
        Data::Binary => {
            let used = header.byte_count(context)?;
            let rows = data
                .get(..used)
                .ok_or_else(|| context.truncated("points", used as u64, data.len() as u64))?;
            for row in rows.chunks_exact(header.stride) {
                gather.push(&columns.row(|field| field.decode(&row[field.place..])));
            }
            if data.len() > used {
                description
                    .warnings
                    .push("there are more data than the header declares".to_owned());
            }
        }
        Data::Compressed => {
            let planes = lzf::data(data, header.byte_count(context)?, context)?;
            let count = header.points as usize;
            for index in 0..count {
                gather.push(&columns.row(|field| {
                    // Fields follow each other, each with the values of all points.
                    field.decode(&planes[field.place * count + index * field.size * field.count..])
                }));
            }
        }
    }
    let mut loaded = gather.finish(columns.kind, description, context)?;
    loaded.viewpoint = header.viewpoint.map(DVec3::from_array);
    Ok(loaded)
}

/// Fields by role.
struct Columns<'a> {
    roles: [Option<&'a Field>; ROLES],
    /// Colour in one field, and whether it has an alpha.
    packed: Option<(Field, bool)>,
    kind: ColorKind,
}

impl<'a> Columns<'a> {
    fn new(header: &'a Header, context: &Context<'_>) -> Result<Self, IoError> {
        let fields = &header.fields;
        let found = columns_of_roles(fields.iter().map(|field| field.name.as_str()));
        if found[X..X + 3].iter().any(Option::is_none) {
            let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            return Err(context.field("FIELDS", names.join(" "), None, "x, y and z among them"));
        }
        let roles = found.map(|column| column.map(|column| &fields[column]));
        let packed = ["rgb", "rgba"].iter().find_map(|name| {
            let field = fields
                .iter()
                .find(|field| field.name.eq_ignore_ascii_case(name) && field.size == 4)?;
            let mut field = field.clone();
            if header.data != Data::Ascii {
                // The bits of a float count, not its value: it may be NaN.
                field.kind = 'U';
            }
            Some((field, *name == "rgba"))
        });
        let kind = match roles[RED] {
            Some(field) if field.kind == 'F' && packed.is_none() => ColorKind::Float,
            _ => ColorKind::Integer,
        };
        Ok(Self { roles, packed, kind })
    }

    fn present(&self) -> [bool; ROLES] {
        let mut present = self.roles.map(|field| field.is_some());
        if let Some((_, alpha)) = &self.packed {
            present[RED..RED + 3].fill(true);
            present[ALPHA] = *alpha;
        }
        present
    }

    fn row(&self, value: impl Fn(&Field) -> Option<f64>) -> Row {
        let mut row = self.roles.map(|field| field.and_then(&value).unwrap_or(f64::NAN));
        if let Some((field, _)) = &self.packed {
            let bits = value(field).map_or(0, |value| match field.kind {
                'F' => (value as f32).to_bits(),
                _ => value as i64 as u32,
            });
            let [alpha, red, green, blue] = bits.to_be_bytes().map(f64::from);
            row[RED..=ALPHA].copy_from_slice(&[red, green, blue, alpha]);
        }
        row
    }
}

fn read_text(
    data: &[u8],
    header: &Header,
    columns: &Columns<'_>,
    gather: &mut Gather,
    context: &Context<'_>,
) -> Result<(), IoError> {
    // Every number takes a digit and a separator, but the last.
    let least = header
        .points
        .saturating_mul(2 * header.width as u64)
        .saturating_sub(1);
    if least > data.len() as u64 {
        return Err(context.truncated("points", least, data.len() as u64));
    }
    let lines = data
        .split(|&byte| byte == b'\n')
        .filter(|line| !line.trim_ascii().is_empty());
    let mut count = 0;
    for line in lines {
        let offset = (line.as_ptr() as usize - data.as_ptr() as usize + header.length) as u64;
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_whitespace().collect();
        if words.len() != header.width || count == header.points {
            let expected = format!("{} points of {} numbers each", header.points, header.width);
            return Err(context.field(format!("point {count}"), text, offset, expected));
        }
        let wanted = columns
            .roles
            .iter()
            .flatten()
            .copied()
            .chain(columns.packed.as_ref().map(|(field, _)| field));
        for field in wanted {
            if field.parse(words[field.column]).is_none() {
                let name = format!("point {count}, {}", field.name);
                return Err(context.field(name, words[field.column], offset, "a number"));
            }
        }
        gather.push(&columns.row(|field| field.parse(words[field.column])));
        count += 1;
    }
    if count < header.points {
        return Err(context.field(
            "POINTS",
            header.points,
            None,
            format!("{count}, as many as there are lines"),
        ));
    }
    Ok(())
}

fn describe(header: &Header, path: &Path) -> Description {
    let fields: Vec<String> = header
        .fields
        .iter()
        .map(|f| format!("{} {}{}", f.name, f.kind, f.size * 8))
        .collect();
    let viewpoint = match header.viewpoint {
        Some([x, y, z]) => format!("viewpoint {x} {y} {z}"),
        None => String::new(),
    };
    Description {
        format: format!("PCD {}", header.version),
        stored_type: format!("{}, {}", header.data.name(), fields.join(", ")),
        orientation: viewpoint,
        files: vec![path.to_owned()],
        ..Description::default()
    }
}
