//! Acquired data of every kind: each file renders with no option but its name, and the same data in other formats look
//! alike.

use std::path::{Path, PathBuf};

use splatvol_recorded::recorded;

use crate::orientation::psnr;
use crate::sandbox::{Sandbox, png};

/// Files that belong to another one, or do not describe their layout.
const COMPANIONS: [&str; 7] = [
    "HeadMRVolume.raw",
    "frogtissue.zraw",
    "neghip_64x64x64_uint8.raw",
    "tooth_103x94x161_uint8.raw",
    "dem.jpg",
    "jotunheimen-texture.jpg",
    "jotunheimen512.bin",
];

fn shared() -> Option<PathBuf> {
    recorded("")
}

/// Files and folders of data in a folder of the shared ones.
fn of(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).expect("it is a folder") {
        let path = entry.expect("it can be listed").path();
        match path.file_name().and_then(|name| name.to_str()) {
            Some("headsq") => found.push(path.join("quarter.nhdr")),
            Some("dicom_transfer_syntaxes" | "nifti_space") => found.extend(of(&path)),
            Some(name) if COMPANIONS.contains(&name) => {}
            _ => found.push(path),
        }
    }
    found.sort();
    found
}

fn picture(sandbox: &Sandbox, path: &Path, flags: &str) -> (u32, u32, Vec<u8>) {
    let command = format!("render {} {flags} -q -w -o a.png", path.display());
    sandbox.run(&command).succeeds();
    png(&sandbox.path("a.png"))
}

#[test]
fn every_file_renders_with_no_option_but_its_name() {
    let Some(data) = shared() else { return };
    let sandbox = Sandbox::new();
    let mut count = 0;
    for folder in ["volumes", "meshes", "points", "gaussians", "terrain"] {
        for path in of(&data.join(folder)) {
            let (_, _, codes) = picture(&sandbox, &path, "--size 48");
            let first = &codes[..3];
            let shown = codes.chunks_exact(3).filter(|code| *code != first).count();
            // Three Gaussians of a landscape are a few pixels.
            let least = if path.to_string_lossy().contains("3-points") {
                1
            } else {
                20
            };
            assert!(shown >= least, "{}: {shown} pixels", path.display());
            count += 1;
        }
    }
    println!("{count} files rendered");
    assert!(count >= 75, "{count}");
}

#[test]
fn headerless_files_render_with_their_layout() {
    let Some(data) = shared() else { return };
    let sandbox = Sandbox::new();
    for (name, layout) in [
        ("volumes/neghip_64x64x64_uint8.raw", "--dims 64x64x64 --type u8"),
        (
            "volumes/tooth_103x94x161_uint8.raw",
            "--dims 103x94x161 --type u8",
        ),
        ("terrain/jotunheimen512.bin", "--dims 512x512x1 --type u16"),
    ] {
        let (_, _, codes) = picture(&sandbox, &data.join(name), &format!("{layout} --size 48"));
        assert!(codes.chunks_exact(3).any(|code| *code != codes[..3]), "{name}");
    }
}

/// The same splats, quantised by three formats: 8 bits of colour and 8 of rotation are a level or two.
#[test]
fn the_same_gaussians_look_alike_from_every_format() {
    let Some(data) = shared() else { return };
    let sandbox = Sandbox::new();
    let of = |name: &str, camera: &str| {
        let path = data.join("gaussians").join(name);
        picture(&sandbox, &path, &format!("{camera} --size 256"))
    };
    let camera = "--camera-pos=1,-9,2 --camera-target=0,0,0 --camera-up=0,0,1 --camera-fov 40";
    let own = of("3-points-from-train.ply", camera);
    for name in ["3-points-from-train.splat", "3-points-from-train.spz"] {
        let figure = psnr(&of(name, camera), &own);
        println!("{name} against .ply: {figure:.1} dB");
        assert!(figure > 38.0, "{name}: {figure:.1}");
    }
    let camera = "--camera-pos=1.5,-5,2 --camera-target=0,0,1.6 --camera-up=0,0,1 --camera-fov 40";
    let figure = psnr(&of("biker.spz", camera), &of("biker.compressed.ply", camera));
    println!("biker.spz against biker.compressed.ply: {figure:.1} dB");
    assert!(figure > 38.0, "{figure:.1}");
}

/// Volumes whose files do not say which way is up: the one that stands on y is turned, the others stay as they are.
#[test]
fn volumes_stand_on_their_feet() {
    let Some(data) = shared() else { return };
    let sandbox = Sandbox::new();
    let bonsai = data.join("volumes/bonsai.vti");
    let own = picture(&sandbox, &bonsai, "--size 64");
    assert!(own == picture(&sandbox, &bonsai, "--size 64 --up y"));
    let said = |command: &str| sandbox.run(&format!("{command} {}", bonsai.display())).succeeds();
    let stored = said("info").stdout();
    assert!(stored.contains("orientation        RAS"), "{stored}");
    let reason = stored
        .lines()
        .find_map(|line| line.strip_prefix("transfer function"));
    let chosen = said("render -v -w --size 32 -o a.png").stderr();
    assert!(
        reason.is_some_and(|reason| chosen.contains(reason.trim())),
        "{chosen}"
    );
    for (name, layout) in [
        ("100_fiberform.tif", ""),
        ("LIDC2.vti", ""),
        ("carotid.vtk", ""),
        ("engine.vti", ""),
        ("headsq/quarter.nhdr", ""),
        ("hydrogen.vti", ""),
        ("HeadMRVolume.mhd", ""),
        ("ironProt.vtk", ""),
        ("mouse_brain_tiff", ""),
        ("neghip.slc", ""),
        ("neghip_64x64x64_uint8.raw", "--dims 64x64x64 --type u8"),
        ("ome_zarr_v2_blosc_lz4.zarr", ""),
        ("stent.npz", ""),
        ("tooth_103x94x161_uint8.raw", "--dims 103x94x161 --type u8"),
    ] {
        let path = data.join("volumes").join(name);
        let text = sandbox
            .run(&format!("info {} {layout}", path.display()))
            .succeeds()
            .stdout();
        let kept = "up                 z (the file does not say";
        assert!(text.contains(kept), "{name}: {text}");
    }
    let text = sandbox
        .run(&format!("info {}", data.join("volumes/LIDC2.mha").display()))
        .succeeds()
        .stdout();
    assert!(text.contains("up                 z (as the file says"), "{text}");
}

/// Scans that stand on y are shown upright.
#[test]
fn scans_stand_on_their_feet() {
    let Some(data) = shared() else { return };
    let sandbox = Sandbox::new();
    for (name, up) in [
        ("bunny.ply", "y"),
        ("beetle.ascii.ply", "y"),
        ("beetle.binary.ply", "y"),
        ("horse.ply", "z"),
        ("ankylosaurus_mesh.ply", "z"),
    ] {
        let path = data.join("points").join(name);
        let own = picture(&sandbox, &path, "--size 64");
        let named = picture(&sandbox, &path, &format!("--size 64 --up {up}"));
        assert!(own == named, "{name}");
    }
}
