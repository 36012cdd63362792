// Batch: splats of a tile's list in workgroup memory. Each part of the tile has a bit for those that may show there, so that its
// pixels see no other: most splats are smaller than a tile.

const BATCH: u32 = 256u;
const WORDS: u32 = BATCH / 32u;
// Parts of a tile, 8 by 4 pixels: as many as devices run together at least.
const PART: vec2<u32> = vec2(8u, 4u);
const PARTS: u32 = 8u;

var<workgroup> batch: array<Splat, BATCH>;
// For each part of the tile, a bit for each splat of a batch that may show there.
var<workgroup> marks: array<atomic<u32>, PARTS * WORDS>;
// 2^x, for x from -126 to 126: `splatvol_core::exponential`, the short polynomial.
fn exp2_quick(x: f32) -> f32 {
    let n = round(x);
    let r = x - n;
    let p = (((9.582853e-3 * r + 5.5906425e-2) * r + 2.402410e-1) * r + 6.931242e-1) * r + 1.0;
    return p * bitcast<f32>(u32(i32(n) + 127) << 23u);
}

// Distances along x and y from a splat's centre beyond which its exponent has fallen by more than this, rounded up. Along its
// ridge the exponent is `(yy - xy^2 / 4 xx) dy^2`.
fn reach_of(splat: Splat, height: f32) -> vec2<f32> {
    let conic = vec2(splat.conic_xx_xy.x, splat.conic_yy);
    let mixed = 0.25 * splat.conic_xx_xy.y * splat.conic_xx_xy.y;
    let fall = mixed / conic.yx - conic;
    let squared = height / fall;
    return select(vec2(3e38), sqrt(max(squared, vec2(0.0))) * 1.001 + 0.01, fall > vec2(0.0));
}

// The place of a part in its tile, pixels.
fn corner_of(part: u32) -> vec2<u32> {
    return vec2(part % 2u, part / 2u) * PART;
}

// Brings a splat to a place of the batch, and marks the parts of the tile in which it may show: where its exponent has fallen by
// no more than `height`.
fn bring(splat: Splat, height: f32, place: u32, tile_corner: vec2<u32>) {
    batch[place] = splat;
    let reach = reach_of(splat, height);
    // In pixels from the middle of the tile's first one.
    let centre = splat.centre - vec2<f32>(tile_corner) - 0.5;
    for (var part = 0u; part < PARTS; part++) {
        let first = vec2<f32>(corner_of(part));
        let last = first + vec2<f32>(PART - 1u);
        if all(centre - reach <= last) && all(centre + reach >= first) {
            atomicOr(&marks[part * WORDS + place / 32u], 1u << (place % 32u));
        }
    }
}
