//! Tests of the rows of a PLY file.

use super::*;

const TEXT: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement face 2\n\
    property list uchar int vertex_indices\nproperty uchar flags\nelement vertex 3\nproperty float z\n\
    property double x\nproperty list uint8 float32 more\nproperty int16 y\nend_header\n\
    3 0 1 2 7\n0 9\n1.5 2.5 0 -3\n4 5e-1 2 8 9 -6 7 8\n1 0 -9\n";

fn context() -> Context<'static> {
    Context::new("PLY", Path::new("a.ply"))
}

fn reader(bytes: &[u8]) -> Result<Reader<'_>, IoError> {
    Reader::new(Source::from_bytes(bytes), context())
}

fn binary(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let header = TEXT
        .split_once("end_header\n")
        .unwrap()
        .0
        .replace("ascii", &format!("binary_{name}_endian"));
    let mut bytes = [header.as_bytes(), b"end_header\n"].concat();
    let mut put = |little: &[u8]| {
        let mut number = little.to_vec();
        if big {
            number.reverse();
        }
        bytes.extend(number);
    };
    put(&[3]);
    for vertex in [0i32, 1, 2] {
        put(&vertex.to_le_bytes());
    }
    put(&[7]);
    put(&[0]);
    put(&[9]);
    for (z, x, more, y) in [
        (1.5f32, 2.5f64, &[][..], -3i16),
        (4.0, 0.5, &[8f32, 9.0], -6),
        (7.0, 8.0, &[0.0], -9),
    ] {
        put(&z.to_le_bytes());
        put(&x.to_le_bytes());
        put(&[more.len() as u8]);
        more.iter().for_each(|m| put(&m.to_le_bytes()));
        put(&y.to_le_bytes());
    }
    bytes
}

#[test]
fn all_encodings_give_the_wanted_columns_in_any_order() {
    for bytes in [
        TEXT.as_bytes().to_vec(),
        TEXT.replace('\n', "\r\n").into_bytes(),
        TEXT.replace('\n', "\r").into_bytes(),
        binary(false),
        binary(true),
    ] {
        let mut reader = reader(&bytes).unwrap();
        assert_eq!(reader.header().comments, ["made by hand"]);
        assert_eq!(reader.header().element("face").unwrap().count, 2);
        let vertex = reader.header().element("vertex").unwrap();
        assert!(vertex.has("x") && !vertex.has("more") && vertex.scalar("y") == Some(Scalar::I16));
        let table = reader.table("vertex", &["x", "y", "z"]).unwrap();
        assert_eq!(table.column("x").unwrap(), [2.5, 0.5, 8.0]);
        assert_eq!(table.column("y").unwrap(), [-3.0, -6.0, -9.0]);
        assert_eq!(table.column("z").unwrap(), [1.5, 4.0, 7.0]);
        assert_eq!(reader.excess().unwrap(), 0);
    }
}

#[test]
fn rows_of_one_length_are_read_in_chunks() {
    let count = 20_000u32;
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {count}\nproperty uint a\n\
                 property char b\nelement empty 99999999999\nend_header\n"
    )
    .into_bytes();
    for a in 0..count {
        bytes.extend(a.to_be_bytes());
        bytes.push((a % 251) as u8);
    }
    let table = reader(&bytes).unwrap().table("vertex", &["b", "a"]).unwrap();
    for a in 0..count {
        assert_eq!(table.column("a").unwrap()[a as usize], f64::from(a));
        assert_eq!(
            table.column("b").unwrap()[a as usize],
            f64::from((a % 251) as u8 as i8)
        );
    }
    bytes.push(0);
    let mut longer = reader(&bytes).unwrap();
    longer.rows("vertex", &[], |_, _| Ok(())).unwrap();
    assert_eq!(longer.finish().unwrap(), Rest::Excess);
}

#[test]
fn what_is_wrong_is_named() {
    let refused = |from: &str, to: &str, words: &str| {
        let text = TEXT.replacen(from, to, 1);
        assert_ne!(text, TEXT);
        let error = reader(text.as_bytes())
            .and_then(|mut r| r.table("vertex", &["x", "y"]))
            .unwrap_err()
            .to_string();
        assert!(error.contains(words) && error.ends_with("in a.ply"), "{error}");
    };
    refused("ply\n", "plz\n", "first line");
    refused("format ascii 1.0\n", "", "format");
    refused("ascii", "ascii8", "(byte 4)");
    refused("float z", "half z", "property");
    refused("face 2", "face -2", "element");
    refused("element face 2\n", "", "an element before it");
    refused("vertex 3", "vertex 99999999999999999", "rows of an element need");
    refused("face 2", "face 18446744073709551615", "rows of an element need");
    refused("end_header\n", "", "header line");
    refused("double x", "double w", "\"x\"");
    refused("5e-1", "5e-1k", "\"x\" = \"5e-1k\"");
    refused("3 0 1 2 7", "-3 0 1 2 7", "a number of type U8");
    for length in 0..TEXT.len() - 1 {
        let result = reader(&TEXT.as_bytes()[..length]).and_then(|mut r| r.table("vertex", &["x"]));
        assert!(result.is_err() || length + 3 > TEXT.len(), "{length}");
    }
    let whole = binary(true);
    for length in 0..whole.len() {
        let result = reader(&whole[..length]).and_then(|mut r| r.table("vertex", &["x"]));
        assert!(result.is_err(), "{length}");
    }
}
