// Read: sums on a cloud's planes, from its ring.

@group(0) @binding(2) var<storage, read> ring: array<Sums>;

// Place of a pixel in a plane of the ring; `offset` in pixels from the principal point.
fn point_of(offset: vec2<f32>) -> u32 {
    // A point lies before the picture, and the middle of pixels half a pixel behind their corner.
    let at = vec2<u32>(offset + frame.principal + 1.0);
    return (at.y - part.first_row * EDGE) * part.pitch + at.x;
}

fn sums_at_point(sheet: u32, point: u32) -> Sums {
    return ring[sheet % RING * part.points + point];
}

// Pixels read their neighbours from the ring.
fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: vec2<u32>, is_filled: bool) {}
