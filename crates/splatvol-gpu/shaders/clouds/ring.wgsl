// Ring: the last planes of sums of a cloud, of a part of the picture.

struct Part {
    // Tiles along x, groups of a tile; first row of tiles, and first group.
    columns: u32,
    groups: u32,
    first_row: u32,
    first_group: u32,
    // Points of a row, and of a plane.
    pitch: u32,
    points: u32,
    unused_0: u32,
    unused_1: u32,
}

@group(0) @binding(11) var<uniform> part: Part;

const RING: u32 = 32u;
