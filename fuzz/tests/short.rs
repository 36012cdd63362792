//! Every target for a number of inputs that takes seconds: the same ones each time.
#![allow(clippy::unwrap_used, reason = "panics are how tests fail")]

use std::process::Command;

fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_splatvol-fuzz"))
}

/// Fails with the program's output where it finds anything.
fn run(target: &str) {
    let folder = tempfile::tempdir().unwrap();
    let mut fuzz = program();
    fuzz.args([target, "--quick", "--findings"]).arg(folder.path());
    let output = fuzz.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(said.contains("1 targets, 0 findings"));
}

macro_rules! targets {
    ($($test:ident $name:literal)*) => {
        $(#[test]
        fn $test() {
            run($name);
        })*

        #[test]
        fn every_target_has_a_test() {
            let listed = program().arg("--list").output().unwrap().stdout;
            let listed = String::from_utf8(listed).unwrap();
            assert_eq!(listed.lines().collect::<Vec<_>>(), [$($name),*]);
        }
    };
}

targets! {
    nrrd "nrrd"
    metaimage "metaimage"
    nifti "nifti"
    mgh "mgh"
    vti "vti"
    legacy_vtk "legacy-vtk"
    npy "npy"
    dicom "dicom"
    ome_zarr "ome-zarr"
    tiff "tiff"
    slices "slices"
    slc "slc"
    raw "raw"
    legacy_mesh "legacy-mesh"
    vtk_xml_mesh "vtk-xml-mesh"
    plot3d "plot3d"
    ply "ply"
    pcd "pcd"
    las "las"
    text_points "text-points"
    heights "heights"
    dem "dem"
    geotiff "geotiff"
    depth_images "depth-images"
    gaussian_ply "gaussian-ply"
    splat "splat"
    ksplat "ksplat"
    spz "spz"
    sog "sog"
    gltf "gltf"
    transfer_function "transfer-function"
    transfer_function_2d "transfer-function-2d"
    camera_path "camera-path"
    scene "scene"
    picture "picture"
}
