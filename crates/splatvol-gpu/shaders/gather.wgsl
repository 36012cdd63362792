// Gather: an interval's material is kept beside that of other layers, to be composited together;
// `splatvol_cpu::sheets::canvas`.

// Intervals of a part of the picture, pixel by pixel: colour times opacity, and transmittance; then opacity and depth.
@group(0) @binding(8) var<storage, read_write> gathered: array<vec4<f32>>;

// Opacity below which the logarithm's digits would be lost in its division.
const THIN_OPACITY: f32 = 0.02;
const LN_2: f32 = 0.6931472;

fn ink_at(index: u32) -> Ink {
    return Ink(vec3(0.0), colors[index].a, 0.0);
}

// Optical depth per opacity.
fn depth_per_opacity(through: f32, opacity: f32) -> f32 {
    if opacity < THIN_OPACITY {
        return opacity * (opacity / 3.0 + 0.5) + 1.0;
    }
    return -LN_2 * log2(max(through, 1.2e-38)) / opacity;
}

// Adds material to an interval of a pixel: extinctions add up, and both attenuate the emission of each.
fn add_material(at: u32, own: Ink) {
    let opacity = 1.0 - own.transmittance;
    let other = gathered[at];
    let others = gathered[at + 1u];
    if others.x <= 0.0 {
        gathered[at] = vec4(own.color, own.transmittance);
        gathered[at + 1u] = vec4(opacity, own.depth_sum / opacity, 0.0, 0.0);
        return;
    }
    let both = others.x + opacity * other.a;
    let per_other = depth_per_opacity(other.a, others.x);
    let per_own = depth_per_opacity(own.transmittance, opacity);
    let seen = both / (others.x * per_other + opacity * per_own);
    let depth = (others.y * others.x + own.depth_sum) / (others.x + opacity);
    gathered[at] = vec4((other.rgb * per_other + own.color * per_own) * seen, other.a * own.transmittance);
    gathered[at + 1u] = vec4(both, depth, 0.0, 0.0);
}

// Material with a share of its extinction: `T^s`, in the same colour.
fn thinned(own: Ink, share: f32) -> Ink {
    let opacity = 1.0 - own.transmittance;
    var less = 1.0 - exp2(log2(max(own.transmittance, 1.2e-38)) * share);
    if opacity < THIN_OPACITY {
        let series = opacity * ((1.0 - share) * (2.0 - share) / 6.0) + 0.5 * (1.0 - share);
        less = (series * opacity + 1.0) * opacity * share;
    }
    let ratio = less / max(opacity, 1.2e-38);
    return Ink(own.color * ratio, 1.0 - less, own.depth_sum * ratio);
}

fn show(pixel: ptr<function, Pixel>, near: u32) {
    let left = (*pixel).ink.transmittance;
    if left < frame.termination {
        return;
    }
    // As if nothing were in front of it.
    (*pixel).ink = Ink(vec3(0.0), 1.0, 0.0);
    shade(pixel, near);
    let share = clamp(frame.share + f32(near) * frame.share_step, 0.0, 1.0);
    var own = (*pixel).ink;
    if share < 1.0 {
        own = thinned(own, share);
    }
    (*pixel).ink = Ink(vec3(0.0), left, 0.0);
    if own.transmittance < 1.0 {
        let place = vec2<u32>((*pixel).offset + frame.principal) - vec2(0u, frame.first_tile_row * TILE_HEIGHT);
        let interval = u32(i32(near) + frame.gather_offset);
        add_material(2u * (interval * frame.band_pixels + place.y * frame.size.x + place.x), own);
    }
}

fn finish(index: u32, ink: Ink) {}
