// Field: a pixel's values of a mesh on four planes, with differences across; `splatvol_cpu::sheets::cloud::field`.

// Takes a plane's value, the weight that it lacks, and differences at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    var value = 0.0;
    var missing = 1.0;
    var across = vec2(0.0);
    if is_filled {
        let at = point_of((*pixel).offset);
        let sums = sums_at_point(sheet, at);
        value = value_of(sums);
        missing = max(1.0 - sums.x, 0.0);
        across = 0.5 * sheets[sheet].scale * vec2(
            value_of(sums_at_point(sheet, at + 1u)) - value_of(sums_at_point(sheet, at - 1u)),
            value_of(sums_at_point(sheet, at + part.pitch)) - value_of(sums_at_point(sheet, at - part.pitch)),
        );
    }
    (*pixel).sums = vec4((*pixel).sums.yzw, value);
    (*pixel).missing = vec4((*pixel).missing.yzw, missing);
    (*pixel).across_before = (*pixel).across;
    (*pixel).across = (*pixel).across_last;
    (*pixel).across_last = across;
}

fn around(pixel: ptr<function, Pixel>, near: u32) -> Around {
    let left = 1.0 - (*pixel).missing;
    let values = continued((*pixel).sums, left);
    return Around(values, values, left.yz, left.y <= 0.0 && left.z <= 0.0);
}
