//! Stacks that are read slice by slice.

use std::path::Path;

use splatvol_io::{Loaded, ReadOptions, open_volume};
use splatvol_scene::chunks::copy_box;
use splatvol_scene::{ChunkBuffer, VoxelBox};

/// The volume as it is read slice by slice must be that in memory.
pub fn assert_opens(path: &Path, options: &ReadOptions, loaded: &Loaded) {
    let opened = open_volume(path, options).unwrap().unwrap();
    assert!(!opened.is_divided);
    assert_eq!(opened.description, loaded.description);
    let layout = &opened.source.levels()[0];
    assert_eq!(&layout.grid, loaded.volume.grid());
    let mut buffer = ChunkBuffer::default();
    let [nx, ny, nz] = layout.grid.dims();
    // From the last slice to the first, and all at once.
    let slices = (0..nz).rev().map(|z| VoxelBox {
        first: [0, 0, z],
        size: [nx, ny, 1],
    });
    let whole = VoxelBox::whole(&layout.grid);
    for region in slices.chain([whole]) {
        let mut found = layout.element.filled(0, 0.0);
        let mut expected = layout.element.filled(region.len(), 0.0);
        opened
            .source
            .read_region(0, region, &mut found, &mut buffer)
            .unwrap();
        assert!(copy_box(loaded.volume.samples(), whole, &mut expected, region));
        assert_eq!(found, expected, "{region:?}");
    }
}
