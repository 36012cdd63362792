//! Zarr at addresses: servers that are slow, busy, broken or foreign. The samples are those of the folder, or an error names the chunk.

use std::path::{Path, PathBuf};

use crate::common::images::{chunks, image};
use splatvol_io::{OmeVersion, Opened, ReadOptions, open_volume, state_of_files};
use splatvol_scene::chunks::{Budget, CachedSource};
use splatvol_scene::{ChunkBuffer, ChunkSource, Samples, VoxelBox};
use splatvol_testing::server::{Fault, Server, serve};

/// The address of the image in a folder that is served, and the server.
fn serve_image(folder: &Path, fault: Fault) -> (String, Server) {
    let server = serve(folder.to_owned(), fault);
    (format!("{}/a.ome.zarr", server.address), server)
}

fn open(path: &Path) -> Opened {
    open_volume(path, &ReadOptions::default()).unwrap().unwrap()
}

#[test]
fn servers_have_the_samples_of_their_folders_whatever_goes_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for (version, faults) in [
        (OmeVersion::V04, &[Fault::Nothing][..]),
        (
            OmeVersion::V05,
            &[
                Fault::Nothing,
                Fault::Busy,
                Fault::Cut,
                Fault::Slow,
                Fault::Secretive,
            ],
        ),
    ] {
        let local = open(&image(folder.path(), version));
        let expected = chunks(&*local.source).unwrap();
        for &fault in faults {
            let (address, server) = serve_image(folder.path(), fault);
            let remote = open(Path::new(&address));
            assert_eq!(remote.source.identity().name, address);
            assert!(
                chunks(&*remote.source).unwrap() == expected,
                "{fault:?} {version:?}"
            );
            assert!(server.requests() > 10, "{fault:?}");
        }
    }
}

#[test]
fn what_a_server_refuses_is_named_by_chunk() {
    let folder = tempfile::tempdir().unwrap();
    image(folder.path(), OmeVersion::V05);
    for (fault, expected) in [(Fault::Denied, "403"), (Fault::NoRanges, "ange")] {
        let (address, _) = serve_image(folder.path(), fault);
        let remote = open(Path::new(&address));
        let error = chunks(&*remote.source).unwrap_err().to_string();
        assert!(error.contains("level 0, chunk 0,0,0, key c/0/0/0"), "{error}");
        assert!(error.contains(expected), "{error}");
    }
    let (address, _) = serve_image(&folder.path().join("nothing"), Fault::Nothing);
    let error = open_volume(Path::new(&address), &ReadOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("neither multiscales nor an array"),
        "{error}"
    );
}

#[test]
fn the_state_of_a_store_is_that_of_its_metadata() {
    let folder = tempfile::tempdir().unwrap();
    let path = image(folder.path(), OmeVersion::V05);
    let (address, _) = serve_image(folder.path(), Fault::Nothing);
    let state = || state_of_files(&[PathBuf::from(&address)]).unwrap();
    let before = state();
    assert_eq!(before, state());
    let metadata = path.join("zarr.json");
    let text = std::fs::read_to_string(&metadata).unwrap();
    std::fs::write(&metadata, text + " ").unwrap();
    assert_ne!(before, state());
}

#[test]
fn chunks_of_a_region_are_asked_for_together() {
    let folder = tempfile::tempdir().unwrap();
    for version in [OmeVersion::V05, OmeVersion::V04] {
        let local = open(&image(folder.path(), version));
        let (address, server) = serve_image(folder.path(), Fault::Slow);
        let remote = open(Path::new(&address)).source;
        let memory = Budget::new(1 << 20).try_reserve(1 << 20).unwrap();
        let cached = CachedSource::new(remote, memory);
        let read = |source: &dyn ChunkSource| {
            let mut samples = Samples::U16(Vec::new().into());
            let region = VoxelBox::whole(&source.levels()[0].grid);
            source
                .read_region(0, region, &mut samples, &mut ChunkBuffer::default())
                .unwrap();
            samples
        };
        assert!(read(&cached) == read(&*local.source));
        let most = server.most_at_once();
        assert!((4..=32).contains(&most), "{most} requests at once");
        // No chunk was fetched twice, or for nothing.
        let before = server.requests();
        read(&cached);
        assert_eq!(server.requests(), before);
        assert_eq!(
            cached.take_counts().reads,
            cached.levels()[0].counts().iter().product::<usize>() as u64
        );
    }
}

#[test]
fn what_keeps_a_server_from_answering_is_said() {
    // Nothing listens on the first port.
    let error = open_volume(
        Path::new("http://127.0.0.1:1/a.ome.zarr"),
        &ReadOptions::default(),
    )
    .unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("refused") && text.contains("http://127.0.0.1:1/a.ome.zarr"),
        "{text}"
    );
}
