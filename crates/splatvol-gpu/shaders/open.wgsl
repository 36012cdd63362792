// Open: which pixels of a tile are not finished yet.

// 1 or 0 by point of the tile; 0 beyond its pixels.
var<workgroup> is_open: array<u32, POINTS>;

// Whether a point's pixel or one beside it takes the point's value.
fn is_open_beside(point: u32) -> bool {
    let x = point % PITCH;
    let y = point / PITCH;
    var open = is_open[point];
    open |= is_open[point - min(x, 1u)] | is_open[point + u32(x + 1u < PITCH)];
    open |= is_open[point - PITCH * min(y, 1u)] | is_open[point + PITCH * u32(y + 1u < POINTS / PITCH)];
    return open != 0u;
}
