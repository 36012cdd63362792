//! Small valid files of the formats of volumes, by name.
#![allow(
    unreachable_pub,
    clippy::unwrap_used,
    reason = "a module of tests; panics are how they fail"
)]

use glam::{DMat3, DQuat, DVec3};

use super::dicom_file;
use super::gzip;
use super::nifti_file::NiftiFile;

/// One file each; all have at most 24 samples.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    let shorts: Vec<u8> = (0..48).collect();
    let nrrd = |encoding: &str, data: &[u8]| {
        let header = format!(
            "NRRD0005\n# c\ntype: short\ndimension: 4\nspace: left-posterior-superior\nsizes: 1 3 2 4\n\
             space directions: none (1,0,0) (0,2,0.5) (0,-0.5,2)\nkinds: vector domain domain domain\n\
             endian: big\nencoding: {encoding}\nspace origin: (1,2,3)\nbyte skip: 0\nline skip: 0\n\
             space units: \"mm\" \"mm\" \"mm\"\n\n"
        );
        [header.as_bytes(), data].concat()
    };
    let text = b"1 2 3 4 5 6 7 8 9 10 11 12 -1 -2 -3 -4 -5 -6 -7 -8 -9 -10 -11 -12";
    let mha = "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementByteOrderMSB = False\n\
               TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 1 1 1.5\nHeaderSize = 0\n\
               ElementNumberOfChannels = 1\nDimSize = 3 2 4\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    let mut nifti = NiftiFile::new(&[3, 2, 4], 4);
    nifti.set_sform(1, DMat3::IDENTITY, DVec3::ONE);
    nifti.set_qform(1, DQuat::IDENTITY, DVec3::ONE, 1.0);
    let nifti_1 = nifti.bytes(&shorts);
    nifti.wide = true;
    nifti.big = true;
    let nifti_2 = nifti.bytes(&shorts);
    let vti = "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
               header_type=\"UInt64\">\n<ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 2\">\n\
               <Piece Extent=\"0 2 0 1 0 1\"><PointData Scalars=\"a\"><DataArray type=\"Float32\" Name=\"a\" \
               format=\"ascii\">1 2 3 4 5 6 7 8 9 10 11 12</DataArray></PointData></Piece></ImageData></VTKFile>\n";
    let appended = "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\">\n\
               <ImageData WholeExtent=\"0 2 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 2\"><Piece Extent=\"0 2 0 1 0 1\">\
               <PointData Scalars=\"a\"><DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/>\
               </PointData></Piece></ImageData><AppendedData encoding=\"raw\">_\x0c\x00\x00\x00123456789abc</AppendedData>\
               </VTKFile>\n";
    let vtk = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\n\
               SPACING 1 1 2\nPOINT_DATA 12\nSCALARS a float 1\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8 9 10 11 12\n";
    let numpy = "{'descr': '<i2', 'fortran_order': False, 'shape': (4, 2, 3), }";
    let numpy = format!("{numpy:<117}\n");
    let numpy = [
        b"\x93NUMPY\x01\x00",
        &(numpy.len() as u16).to_le_bytes()[..],
        numpy.as_bytes(),
        &shorts,
    ]
    .concat();
    let words = [1, 2, 3, 4, 5, 6];
    let dicom = |syntax| dicom_file::DicomFile::slice(syntax, [1.0, 2.0, 3.0], 1, &words).bytes();
    let mut tiff = Vec::new();
    let mut encoder = tiff::encoder::TiffEncoder::new(std::io::Cursor::new(&mut tiff))
        .unwrap()
        .with_compression(tiff::encoder::Compression::Lzw);
    for _ in 0..3 {
        encoder
            .write_image::<tiff::encoder::colortype::Gray16>(3, 2, &words)
            .unwrap();
    }
    let mut mgh = Vec::new();
    for number in [1, 3, 2, 4, 1, 4, 0] {
        mgh.extend(i32::to_be_bytes(number));
    }
    mgh.extend([0, 1]);
    for number in [
        1.0, 1.0, 2.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0,
    ] {
        mgh.extend(f32::to_be_bytes(number));
    }
    mgh.resize(284, 0);
    mgh.extend(&shorts);
    let slc = b"11111\n3 2 2 8\n1.0 1.0 2.0\n1 6 0 1\n1 1 X...6 X\x83abc\x03d8 X\x01a\x85edcba";
    vec![
        ("explicit.dcm", dicom(dicom_file::EXPLICIT)),
        ("implicit.dcm", dicom(dicom_file::IMPLICIT)),
        ("pages.tif", tiff),
        ("plain.mgh", mgh.clone()),
        ("packed.mgz", gzip(&mgh)),
        ("runs.slc", slc.to_vec()),
        ("raw.nrrd", nrrd("raw", &shorts)),
        ("gzip.nrrd", nrrd("gzip", &gzip(&shorts))),
        ("text.nrrd", nrrd("ascii", text)),
        ("hex.nrrd", nrrd("hex", "0a".repeat(48).as_bytes())),
        ("local.mha", [mha.as_bytes(), &shorts].concat()),
        ("one.nii", nifti_1.clone()),
        ("one.nii.gz", gzip(&nifti_1)),
        ("two.nii", nifti_2),
        ("ascii.vti", vti.as_bytes().to_vec()),
        ("appended.vti", appended.as_bytes().to_vec()),
        ("ascii.vtk", vtk.as_bytes().to_vec()),
        ("shorts.npy", numpy),
    ]
}
