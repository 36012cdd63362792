// Material: intervals between planes are classified, lit by differences and composited;
// `splatvol_cpu::sheets::shade_batch`, line by line, for one pixel.

// Optical depth from which an interval is cut in halves.
const THICK: f32 = 0.02;
// Optical depth of an interval of the densest material from which thin intervals are cut, too.
const DENSE: f32 = 0.1;

// Composites the interval between planes `near` and `near + 1`.
fn shade(pixel: ptr<function, Pixel>, near: u32) {
    let own = around(pixel, near);
    if (*pixel).ink.transmittance < frame.termination || (own.is_untouched && frame.shows_background == 0u) {
        return;
    }
    let values = own.values;
    let ends = values.yz;
    let low = min(ends.x, ends.y);
    let high = max(ends.x, ends.y);
    let middle = 0.5 * (ends.x + ends.y) + 0.0625 * ((ends.y - values.x) - (values.w - ends.x));
    if max(high, middle) < frame.hull.x || min(low, middle) > frame.hull.y {
        return;
    }
    let covered_near = own.coverage.x;
    let covered_far = own.coverage.y;
    let covered = 0.5 * (covered_near + covered_far);
    let ray = (*pixel).offset * frame.per_pixel;
    let length = sqrt(dot(ray, ray) + 1.0) * frame.spacing;
    let near_class = classify(ends.x);
    let far_class = classify(ends.y);
    let whole = segment(ends, near_class, far_class);
    let optical_depth = whole.extinction * covered * length;
    let bulges = middle > high || middle < low;
    let middle_matters = bulges && (frame.densest * frame.spacing > DENSE || optical_depth == 0.0);
    var opacities = vec2(0.0);
    var places = vec2(whole.place);
    var shown = vec2(whole.value);
    var through = exp2(-LOG2_E * optical_depth);
    opacities.x = 1.0 - through;
    if optical_depth > THICK || middle_matters {
        let middle_class = classify(middle);
        let front = segment(vec2(ends.x, middle), near_class, middle_class);
        let back = segment(vec2(middle, ends.y), middle_class, far_class);
        let depths = vec2(front.extinction * (covered_near + covered), back.extinction * (covered + covered_far)) * 0.25 * length;
        let through_halves = exp2(max(-LOG2_E * depths, vec2(LEAST_EXPONENT)));
        through = through_halves.x * through_halves.y;
        opacities = vec2(1.0 - through_halves.x, through_halves.x * (1.0 - through_halves.y));
        var halves = vec2(front.place, back.place);
        shown = vec2(front.value, back.value);
        if is_eye(near) {
            halves *= vec2(visible_place(depths.x, through_halves.x), visible_place(depths.y, through_halves.y)) * 2.0;
            shown = mix(vec2(ends.x, middle), vec2(middle, ends.y), halves);
        }
        places = 0.5 * halves + vec2(0.0, 0.5);
    }
    let opacity = 1.0 - through;
    if opacity <= 0.0 {
        return;
    }
    var color = color_of(shown.x) * opacities.x;
    var behind = 0.0;
    if opacities.y > 0.0 {
        color += color_of(shown.y) * opacities.y;
        behind = opacities.y / (opacities.x + opacities.y);
    }
    let place = mix(places.x, places.y, behind);
    if frame.lit != 0u {
        let sharpness = sharpness_of(near);
        var light = phong(gradient_at(pixel, own.whole, places.x, sharpness));
        if opacities.y > 0.0 {
            light = mix(light, phong(gradient_at(pixel, own.whole, places.y, sharpness)), behind);
        }
        color = color * light.x + light.y * opacity;
    }
    let before = (*pixel).ink.transmittance;
    (*pixel).ink.color += before * color;
    (*pixel).ink.depth_sum += before * opacity * (place * frame.spacing + sheets[near].depth);
    (*pixel).ink.transmittance = before * through;
}
