// Sums: a pixel takes a field's sums on planes, and makes values of them.

// Takes a plane's value and differences at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    var sum = 0.0;
    var missing = 0.0;
    var share = 1.0;
    // Outside of the volume there is no background either.
    var coverage = select(1.0, 0.0, frame.shows_background != 0u);
    var across = vec2(0.0);
    if is_filled {
        sum = values[point];
        missing = missing_at(point);
        let place = place_on(sheet, (*pixel).offset);
        share = share_at(place);
        coverage = coverage_at(place);
        across = across_on(sheet, place, point);
    }
    (*pixel).sums = vec4((*pixel).sums.yzw, sum);
    (*pixel).missing = vec4((*pixel).missing.yzw, missing);
    (*pixel).shares = vec4((*pixel).shares.yzw, share);
    (*pixel).coverage = vec4((*pixel).coverage.yzw, coverage);
    (*pixel).across_before = (*pixel).across;
    (*pixel).across = (*pixel).across_last;
    (*pixel).across_last = across;
}

fn around(pixel: ptr<function, Pixel>, near: u32) -> Around {
    let sums = sums_around(near, (*pixel).offset, (*pixel).sums);
    let per_share = 1.0 / max((*pixel).shares.yyzz, vec4(0.15));
    let values = sums * per_share + frame.background;
    let covered = (*pixel).coverage.yz;
    let is_untouched = sums.y == 0.0 && sums.z == 0.0;
    if !HAS_HOLES || all((*pixel).missing == vec4(0.0)) {
        return Around(values, values, covered, is_untouched);
    }
    let missing = missing_around(near, (*pixel).offset, (*pixel).missing) * per_share;
    let left = 1.0 - missing;
    return Around(
        values_beside(sums * per_share, missing) + frame.background,
        values - missing * frame.background,
        vec2(covered_by(covered.x, left.y), covered_by(covered.y, left.z)),
        is_untouched && missing.y == 0.0 && missing.z == 0.0,
    );
}
