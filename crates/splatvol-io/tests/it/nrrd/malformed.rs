//! Malformed input: an error that names the fault, or a listed warning.

use super::*;

#[test]
fn bad_geometry_is_named() {
    for (fields, name) in [
        ("spacings: 1 1", "spacings"),
        ("kinds: domain domain domain\nspacings: 1 1 nan", "spacing"),
        ("spacings: 1 1 inf", "spacing"),
        ("spacings: 1 0 1", "spacing"),
        ("spacings: 1 1e-40 1", "spacing"),
        ("space: middle-earth", "space"),
        ("space: LPS\nspace dimension: 3", "space"),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0)",
            "space directions",
        ),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1) (1,1,1)",
            "space directions",
        ),
        (
            "space: LPS\nspace directions: (1,0) (0,1) (0,0)",
            "space directions",
        ),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,nan)",
            "space directions",
        ),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,1,0)",
            "direction",
        ),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1",
            "space directions",
        ),
        (
            "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2)",
            "space origin",
        ),
        ("spacings: 1 1 1\nspacings: 1 1 1", "spacings"),
        ("kinds: domain domain", "kinds"),
        ("byte skip: -2", "byte skip"),
        ("line skip: 99999999999", "skipped lines"),
    ] {
        let text = refused(read(&attached(
            &format!("type: uchar\nencoding: raw\n{fields}"),
            &[1; 12],
        )));
        assert!(text.contains(name), "{fields}: {text}");
    }
}

#[test]
#[cfg(unix)]
fn a_fifo_is_refused_instead_of_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let fifo = folder.path().join("a.raw");
    let made = std::process::Command::new("mkfifo").arg(&fifo).status();
    if !made.is_ok_and(|status| status.success()) {
        splatvol_recorded::skip("no mkfifo");
        return;
    }
    assert!(refused(read_volume(&fifo, &ReadOptions::default())).contains("not a regular file"));
    let header = header("type: uchar\nencoding: raw\ndata file: a.raw");
    let text = refused(read_bytes(folder.path(), "b.nhdr", header.as_bytes()));
    assert!(text.contains("a regular file"), "{text}");
}

#[test]
fn absurd_headers_are_refused_without_an_allocation() {
    for sizes in [
        "0 1 1",
        "-1 2 3",
        "1 1",
        "1 1 1 1",
        "99999999999999999999 1 1",
        "65535 65535 65535",
        "65536 1 1",
        "18446744073709551615 18446744073709551615 2",
        "3 2 x",
        "30 20 20",
    ] {
        for encoding in ["raw", "gzip", "ascii", "hex"] {
            let fields = format!("type: uchar\nencoding: {encoding}\ndimension: 3\nsizes: {sizes}");
            let error = read_fields(&fields, &gzip(&[0; 12])).unwrap_err();
            assert!(!matches!(error, IoError::Open { .. }), "{error}");
        }
    }
    for fields in [
        "type: uchar\nencoding: raw\nsizes: 1",
        "type: uchar\nencoding: raw\ndimension: 0\nsizes: ",
        "type: uchar\nencoding: raw\ndimension: 17\nsizes: 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1",
        "type: uchar\nencoding: raw\ndimension: 1000000000\nsizes: 1",
        "type: block\nencoding: raw\ndimension: 1\nsizes: 1",
        "type: colour\nencoding: raw\ndimension: 1\nsizes: 1",
        "type: uchar\nencoding: bzip2\ndimension: 1\nsizes: 1",
        "type: uchar\nencoding: rot13\ndimension: 1\nsizes: 1",
        "type: short\nencoding: raw\ndimension: 1\nsizes: 1",
        "type: short\nencoding: raw\nendian: middle\ndimension: 1\nsizes: 1",
        "no colon",
    ] {
        assert!(read_fields(fields, &[1; 4]).is_err(), "{fields}");
    }
    assert!(read(b"").is_err());
    assert!(read(b"NRRD0006\n").is_err());
    assert!(read(b"NRRD").is_err());
    assert!(read(b"some text that was renamed").is_err());
    let long_line = [b"NRRD0004\n# ".as_slice(), &[b'x'; 10 << 20]].concat();
    assert!(read(&long_line).is_err());
}

#[test]
fn no_cut_and_no_flipped_byte_does_harm() {
    let geometry = "spacings: 1 1 1";
    let raw = attached(
        &format!("type: short\nencoding: raw\nendian: little\n{geometry}"),
        &little(),
    );
    let zipped = attached(
        &format!("type: short\nencoding: gzip\nendian: big\n{geometry}"),
        &gzip(&little()),
    );
    let text = attached(
        &format!("type: short\nencoding: txt\n{geometry}"),
        VALUES.map(|v| v.to_string()).join(" ").as_bytes(),
    );
    for bytes in [&raw, &zipped, &text] {
        let header = bytes.len() - 24;
        // A missing last digit of text may go unnoticed; the number that it leaves is still valid.
        if bytes != &text {
            truncations("a.nrrd", bytes, bytes.len());
        }
        let refused = flips("a.nrrd", bytes, header);
        assert!(refused > header, "{refused}");
    }
    truncations(
        "a.nrrd",
        &text[..text.len() - 1]
            .iter()
            .copied()
            .chain(*b"8\n")
            .collect::<Vec<_>>(),
        text.len() - 6,
    );
}

#[test]
fn a_folder_and_an_unknown_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(read_volume(folder.path(), &ReadOptions::default()).is_err());
    assert!(read_volume(Path::new("/nonexistent/a.nrrd"), &ReadOptions::default()).is_err());
    assert!(refused(read_bytes(folder.path(), "a.xyz", b"what")).contains("known format"));
}
