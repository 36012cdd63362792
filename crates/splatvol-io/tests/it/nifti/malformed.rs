//! Malformed input: an error that names the fault, or a listed warning.

use super::*;

#[test]
fn bad_fields_are_named() {
    type Edit = fn(&mut NiftiFile);
    let cases: [(Edit, &str); 24] = [
        (|file| file.dim[0] = 0, "dim[0]"),
        (|file| file.dim[0] = 200, "dim[0]"),
        (|file| file.dim[0] = -1, "dim[0]"),
        (|file| file.dim[2] = 0, "dim[2]"),
        (|file| file.dim[2] = -3, "dim[2]"),
        (|file| file.dim[2] = 32767, "need"),
        (|file| (file.wide, file.dim[1]) = (true, i64::MAX), "dim"),
        (
            |file| (file.wide, file.dim[0], file.dim[4]) = (true, 4, i64::MAX),
            "limit",
        ),
        (
            |file| (file.wide, file.dim[1], file.dim[2]) = (true, 65535, 65535),
            "need",
        ),
        (|file| file.datatype = 0, "datatype"),
        (|file| file.datatype = 3, "datatype"),
        (|file| file.datatype = 1536, "128-bit"),
        (|file| file.datatype = 1, "one bit"),
        (|file| file.vox_offset = Some(f64::NAN), "vox_offset"),
        (|file| file.vox_offset = Some(-8.0), "vox_offset"),
        (|file| file.vox_offset = Some(100.0), "vox_offset"),
        (|file| file.vox_offset = Some(360.5), "vox_offset"),
        (|file| file.vox_offset = Some(1e30), "vox_offset"),
        (|file| file.vox_offset = Some(100_000.0), "need"),
        (|file| file.pixdim[3] = f64::INFINITY, "pixdim[3]"),
        (
            |file| (file.scl_slope, file.scl_inter) = (1.0, f64::NAN),
            "scl_inter",
        ),
        (|file| file.set_sform(1, DMat3::ZERO, DVec3::ZERO), "spacing"),
        (|file| file.set_sform(1, DMat3::IDENTITY, DVec3::NAN), "srow_x"),
        (
            |file| (file.qform_code, file.quatern) = (1, [1.0, 1.0, 0.0]),
            "quatern",
        ),
    ];
    for (number, (edit, name)) in cases.into_iter().enumerate() {
        let error = edited(edit).unwrap_err().to_string();
        assert!(error.contains(name), "{number}, {name}: {error}");
    }
}

#[test]
fn what_is_not_nifti_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |bytes: &[u8]| read_bytes(folder.path(), "a.nii", bytes).unwrap_err().to_string();
    assert!(refused(b"").contains("header"));
    assert!(refused(b"This is a letter to the editor, renamed.").contains("sizeof_hdr"));
    let mut file = NiftiFile::new(&[2], 2).bytes(&[1, 2]);
    file[344..348].copy_from_slice(b"n+9\0");
    assert!(refused(&file).contains("magic"));
    file[344..348].fill(0);
    assert!(refused(&file).contains("Analyze"));
    // 377 bytes that ask for 18 GB, plain and compressed.
    let mut bomb = NiftiFile::new(&[32767, 32767, 17], 2).bytes(&[0; 25]);
    assert_eq!(bomb.len(), 377);
    assert!(matches!(read(&bomb), Err(IoError::Truncated { .. })));
    bomb.resize(10 << 20, 0);
    let bomb = read_bytes(folder.path(), "a.nii.gz", &gzip(&bomb));
    assert!(matches!(bomb, Err(IoError::Truncated { .. })), "{:?}", bomb.err());
}

#[test]
fn a_compressed_stream_may_have_members_padding_or_faults() {
    let folder = tempfile::tempdir().unwrap();
    let mut nifti = NiftiFile::new(&[2, 3, 4], 2);
    nifti.qform_code = 1;
    let file = nifti.bytes(&[7; 24]);
    let read = |bytes: &[u8]| read_bytes(folder.path(), "a.nii.gz", bytes);
    let members = [gzip(&file[..360]), gzip(&file[360..])].concat();
    assert_eq!(read(&members).unwrap().description.warnings, Vec::<String>::new());
    let padded = [&gzip(&file)[..], &[0; 100]].concat();
    assert_eq!(read(&padded).unwrap().description.warnings.len(), 1);
    let mut wrong = gzip(&file);
    let crc = wrong.len() - 8;
    wrong[crc] ^= 0x10;
    assert!(matches!(read(&wrong), Err(IoError::Corrupt { .. })));
}

#[test]
fn one_sample_more_is_a_warning_and_one_less_an_error() {
    let mut file = NiftiFile::new(&[2, 3, 4], 2);
    file.qform_code = 1;
    assert_eq!(read(&file.bytes(&[7; 25])).unwrap().description.warnings.len(), 1);
    assert!(matches!(
        read(&file.bytes(&[7; 23])),
        Err(IoError::Truncated { .. })
    ));
}

#[test]
fn no_cut_and_no_flipped_byte_does_harm() {
    for wide in [false, true] {
        let mut file = NiftiFile::new(&[2, 3, 4], 4);
        file.wide = wide;
        file.set_sform(1, DMat3::IDENTITY, DVec3::ONE);
        file.set_qform(1, DQuat::IDENTITY, DVec3::ONE, 1.0);
        let bytes = file.bytes(&(0..48).collect::<Vec<u8>>());
        truncations("a.nii", &bytes, bytes.len());
        let zipped = gzip(&bytes);
        truncations("a.nii.gz", &zipped, zipped.len());
        assert!(flips("a.nii", &bytes, 544) > 60);
        assert!(flips("a.nii.gz", &zipped, zipped.len()) > zipped.len());
    }
}

#[test]
fn the_message_tells_path_field_value_and_place() {
    let error = edited(|file| file.dim[0] = 200).unwrap_err().to_string();
    let (message, path) = error.split_once(", in ").unwrap();
    assert_eq!(
        message,
        "NIfTI header, field \"dim[0]\" = \"200\" (byte 40): expected 1 to 7 axes"
    );
    assert_eq!(Path::new(path).file_name().unwrap(), "a.nii");
}
