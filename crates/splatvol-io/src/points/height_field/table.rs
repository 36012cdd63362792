//! Heights as text: one row per line, separated by commas, semicolons or white space. Words such as `nan` are gaps.

use std::path::Path;

use glam::DVec2;

use super::{HeightField, RowOrder};
use crate::error::Context;
use crate::source::read_file;
use crate::{Description, IoError};

pub(super) fn read(path: &Path, order: RowOrder) -> Result<(HeightField, Description), IoError> {
    let context = &Context::new("table of heights", path);
    let bytes = read_file(path, context)?;
    let mut heights = Vec::new();
    let mut width = 0;
    let mut rows = 0;
    for line in bytes.split(|&byte| byte == b'\n') {
        let offset = (line.as_ptr() as usize - bytes.as_ptr() as usize) as u64;
        let text = String::from_utf8_lossy(line);
        let text = text.trim();
        if text.is_empty() {
            continue;
        }
        let before = heights.len();
        for word in text
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|word| !word.is_empty())
        {
            let height: f64 = word
                .parse()
                .map_err(|_| context.field(format!("row {rows}"), word, offset, "a height"))?;
            heights.push(height);
        }
        let found = heights.len() - before;
        if rows == 0 {
            width = found;
        } else if found != width {
            let expected = format!("{width}, as many as in row 0");
            return Err(context.field(format!("heights of row {rows}"), found, offset, expected));
        }
        rows += 1;
    }
    if width < 2 || rows < 2 {
        return Err(context.field(
            "dims",
            format!("{width} x {rows}"),
            None,
            "at least 2 x 2 heights",
        ));
    }
    let mut field = HeightField {
        dims: [width, rows],
        heights,
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
        height_scale: 1.0,
        measured: false,
    };
    field.south_first(order);
    let first = if order == RowOrder::SouthFirst {
        "south"
    } else {
        "north"
    };
    let description = Description {
        format: "table of heights".to_owned(),
        stored_type: "text".to_owned(),
        orientation: format!("the first row is the {first}; no geometry in the file, spacing 1"),
        files: vec![path.to_owned()],
        ..Description::default()
    };
    Ok((field, description))
}
