//! Files that must be refused, quickly and with the field named.

use crate::common::vti_file::{File, Style, file};
use crate::common::{flips, read_bytes, truncations};

/// A plain file with `from` replaced.
fn changed(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(file(Style {
        place: "appended-base64",
        ..Style::PLAIN
    }))
    .unwrap();
    assert!(text.contains(from), "{from} is not in the file");
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn malformed_headers_name_the_field() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        ("0 4 0 3 0 2", "0 4 3 0 0 2", "WholeExtent"),
        ("0 4 0 3 0 2", "0 4 0 3 0", "WholeExtent"),
        ("0 4 0 3 0 2", "0 4 0 3 0 99999999999999999999", "WholeExtent"),
        (
            "0 4 0 3 0 2",
            "-9223372036854775808 9223372036854775807 0 3 0 2",
            "extent",
        ),
        ("0 4 0 3 0 2", "0 65534 0 65534 0 65534", "needed"),
        ("0 4 0 3 0 2", "0 4 0 3 0 3", "bytes of data"),
        ("WholeExtent", "Extent", "WholeExtent"),
        ("Spacing=\"1 2 0.5\"", "Spacing=\"1 NaN 0.5\"", "spacing"),
        ("Spacing=\"1 2 0.5\"", "Spacing=\"1 0 0.5\"", "spacing"),
        ("Spacing=\"1 2 0.5\"", "Spacing=\"1 1e40 0.5\"", "spacing"),
        ("Origin=\"1 2 3\"", "Origin=\"1 inf 3\"", "origin"),
        ("Origin=\"1 2 3\"", "Origin=\"1 2\"", "Origin"),
        ("Origin=\"1 2 3\"", "Direction=\"1 1 0 0 0 0 0 0 1\"", "direction"),
        ("<Piece>", "<Piece Extent=\"0 4 0 3 0 1\">", "piece of extent"),
        ("<Piece>", "<Piece/><Piece>", "2 <Piece> elements"),
        (
            "<PointData Scalars=\"second\">",
            "<PointData Scalars=\"second\" a='&x;'>",
            "XML",
        ),
        (
            "byte_order=\"LittleEndian\"",
            "byte_order=\"Middle\"",
            "byte_order",
        ),
        ("header_type=\"UInt32\"", "header_type=\"UInt16\"", "header_type"),
        (
            "header_type=\"UInt32\"",
            "header_type=\"UInt64\"",
            "bytes of data",
        ),
        (
            "header_type=\"UInt32\"",
            "compressor=\"vtkLZMADataCompressor\"",
            "vtkLZMADataCompressor",
        ),
        (
            "header_type=\"UInt32\"",
            "compressor=\"vtkZLibDataCompressor\"",
            "compressed blocks",
        ),
        (
            "type=\"ImageData\"",
            "type=\"UnstructuredGrid\"",
            "UnstructuredGrid",
        ),
        ("encoding=\"base64\"", "encoding=\"hex\"", "hex"),
        (" _", " x_", "AppendedData"),
        ("offset=\"168\"", "offset=\"99999999\"", "offset"),
        ("offset=\"168\"", "offset=\"18446744073709551615\"", "offset"),
        ("offset=\"168\"", "offset=\"-1\"", "offset"),
        ("offset=\"168\"", "", "offset"),
        (
            "format=\"appended\" offset=\"168\"",
            "format=\"inline\"",
            "inline",
        ),
        (
            "format=\"appended\" offset=\"168\"",
            "format=\"ascii\"",
            "numbers",
        ),
        (
            "format=\"appended\" offset=\"168\"",
            "format=\"binary\"",
            "header of the data",
        ),
        (
            "Name=\"second\"",
            "Name=\"second\" NumberOfComponents=\"0\"",
            "NumberOfComponents",
        ),
        (
            "Name=\"second\"",
            "Name=\"second\" NumberOfComponents=\"4294967296\"",
            "NumberOfComponents",
        ),
        (
            "Name=\"second\"",
            "Name=\"second\" NumberOfComponents=\"2\"",
            "not a scalar",
        ),
        (
            "type=\"Int16\" Name=\"second\"",
            "type=\"String\" Name=\"second\"",
            "numeric",
        ),
    ];
    for (from, to, field) in cases {
        let error = read_bytes(folder.path(), "a.vti", &changed(from, to));
        let text = error.expect_err(to).to_string();
        assert!(text.contains(field), "{to}: {text}");
    }
}

#[test]
fn entities_and_deep_nesting_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let dtd =
        "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile type=\"ImageData\">&b;</VTKFile>";
    let text = read_bytes(folder.path(), "a.vti", dtd.as_bytes())
        .unwrap_err()
        .to_string();
    assert!(text.contains("DTD"), "{text}");
    let deep = format!("<VTKFile>{}", "<a>".repeat(200_000));
    assert!(read_bytes(folder.path(), "a.vti", deep.as_bytes()).is_err());
    for bad in ["", "<VTKFile", "<VTKFile/>", "not xml", "<AppendedData"] {
        assert!(
            read_bytes(folder.path(), "a.vti", bad.as_bytes()).is_err(),
            "{bad}"
        );
    }
}

#[test]
fn lies_about_blocks_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let style = Style {
        place: "appended-raw",
        zlib: true,
        ..Style::PLAIN
    };
    let mut file = File::new(style, "WholeExtent=\"0 9 0 9 0 0\"");
    file.point_i16("Name=\"a\"", &[5; 100]);
    let (good, data) = (file.bytes(""), file.appended.clone());
    assert!(read_bytes(folder.path(), "a.vti", &good).is_ok());
    let length = data.len() - 16 - 12;
    // Blocks, block size, size of the last block, compressed lengths.
    let lies: [&[usize]; 9] = [
        &[0, 64, 8, 14],
        &[u32::MAX as usize, 64, 8],
        &[3, 64, 8, 14, 14, 14, 14],
        &[4, 63, 11, 14, 14, 14, 14],
        &[4, 64, 65, 14, 14, 14, 14],
        &[4, 64, 8, u32::MAX as usize, 14, 14, 14],
        &[4, 64, 8, 0, 0, 0, 0],
        &[1, 200, 0, length],
        &[2, 100, 100, 14, 14],
    ];
    for lie in lies {
        file.appended = [style.words(lie), data[28..].to_vec()].concat();
        assert!(
            read_bytes(folder.path(), "a.vti", &file.bytes("")).is_err(),
            "{lie:?}"
        );
    }
}

#[test]
fn truncated_and_damaged_files_never_panic() {
    let styles = [
        ("ascii", false),
        ("base64", true),
        ("appended-base64", false),
        ("appended-raw", true),
    ];
    for (place, zlib) in styles {
        let bytes = file(Style {
            place,
            zlib,
            ..Style::PLAIN
        });
        truncations("a.vti", &bytes, 300);
        assert!(flips("a.vti", &bytes, 500) > 100);
    }
}
