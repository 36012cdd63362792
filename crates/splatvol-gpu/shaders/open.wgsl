// Open: which pixels of a tile are not finished yet.

// 1 or 0 by point of the tile; 0 beyond its pixels.
var<workgroup> is_open: array<u32, POINTS>;

// A bit for each of a thread's points that is taken by an open pixel.
fn wanted_points(thread: u32) -> u32 {
    var wanted = 0u;
    for (var i = 0u; thread + i * 256u < POINTS; i++) {
        wanted |= u32(is_open_beside(thread + i * 256u)) << i;
    }
    return wanted;
}

// Whether a point's pixel or one beside it takes the point's value.
fn is_open_beside(point: u32) -> bool {
    let x = point % PITCH;
    let y = point / PITCH;
    var open = is_open[point];
    open |= is_open[point - min(x, 1u)] | is_open[point + u32(x + 1u < PITCH)];
    open |= is_open[point - PITCH * min(y, 1u)] | is_open[point + PITCH * u32(y + 1u < POINTS / PITCH)];
    return open != 0u;
}
