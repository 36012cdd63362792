//! Small valid files of the formats of points and terrain, by name.
#![allow(
    unreachable_pub,
    clippy::unwrap_used,
    reason = "a module of tests; panics are how they fail"
)]

/// One file each.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    let pcd = "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n\
        POINTS 3\nDATA ";
    let floats: Vec<u8> = (0..12u8).flat_map(|i| f32::from(i).to_le_bytes()).collect();
    let lzf = [
        &50u32.to_le_bytes()[..],
        &48u32.to_le_bytes(),
        &[31],
        &floats[..32],
        &[15],
        &floats[32..],
    ]
    .concat();
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nend_header\n";
    let depth = "{\"depth_unit\": 0.5, \"intrinsics\": {\"fx\": 2, \"fy\": 2, \"cx\": 1, \"cy\": 1},\n\
        \"frame\": [{\"depth\": \"depth.npy\", \"world_from_camera\": [[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]]}]}";
    vec![
        (
            "ascii.pcd",
            format!("{pcd}ascii\n1 2 3 4\n5 6 7 8\n9 10 11 12\n").into_bytes(),
        ),
        ("binary.pcd", [pcd.as_bytes(), b"binary\n", &floats].concat()),
        (
            "compressed.pcd",
            [pcd.as_bytes(), b"binary_compressed\n", &lzf].concat(),
        ),
        ("binary.ply", [ply.as_bytes(), &floats].concat()),
        (
            "table.csv",
            b"x,y,z,r,g,b\n1,2,3,4,5,6\n7,8,9,10,11,12\n".to_vec(),
        ),
        ("table.heights", b"1 2 3\n4 5 6\n7 8 9\n".to_vec()),
        ("grid.tif", common_tiff()),
        ("frames.json", depth.as_bytes().to_vec()),
    ]
}

fn common_tiff() -> Vec<u8> {
    use tiff::encoder::{TiffEncoder, colortype};
    let mut bytes = std::io::Cursor::new(Vec::new());
    let heights: Vec<f32> = (0..12u8).map(f32::from).collect();
    TiffEncoder::new(&mut bytes)
        .unwrap()
        .write_image::<colortype::Gray32Float>(4, 3, &heights)
        .unwrap();
    bytes.into_inner()
}
