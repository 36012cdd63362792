// Classes: sums of classified voxels on a plane, extinction and lit emission; `splatvol_cpu::sheets::compose` in gather form.
// Their weights are those of all voxels around, also of those beyond the lattice, which hold nothing.

fn sums_at(place: Place) -> vec4<f32> {
    let slot = slot_of(place.cell);
    if !slot.exists {
        return vec4(0.0);
    }
    let x = weights(place.within.x);
    let y = weights(place.within.y);
    let z = weights(place.within.z);
    let sums = vec4(
        sum_of_slot(slot, 0, x, y, z),
        sum_of_slot(slot, 1, x, y, z),
        sum_of_slot(slot, 2, x, y, z),
        sum_of_slot(slot, 3, x, y, z),
    );
    return sums / (x.sum * y.sum * z.sum);
}

const LAG: u32 = 2u;
// Planes without material are all alike.
const LEAD: u32 = 0u;

// A pixel on its way through the planes.
struct Pixel {
    // On the last four planes.
    before: vec4<f32>,
    near: vec4<f32>,
    far: vec4<f32>,
    after: vec4<f32>,
    // From the principal point, pixels.
    offset: vec2<f32>,
    ink: Ink,
}

fn fresh(offset: vec2<f32>, ink: Ink) -> Pixel {
    let nothing = vec4(0.0);
    return Pixel(nothing, nothing, nothing, nothing, offset, ink);
}

// Pixels need no neighbours.
fn exchange(sheet: u32, plane: u32, corner: vec2<u32>, thread: vec2<u32>, is_filled: bool) {}

// Takes a plane's sums at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    (*pixel).before = (*pixel).near;
    (*pixel).near = (*pixel).far;
    (*pixel).far = (*pixel).after;
    (*pixel).after = vec4(0.0);
    if is_filled {
        (*pixel).after = sums_on(sheet, (*pixel).offset);
    }
}
