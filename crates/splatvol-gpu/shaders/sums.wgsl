// Sums: a pixel takes a field's sums on planes, and makes values of them.
//
// Most places are in the interior, where all weights lie on the lattice and coverage is one. A pixel keeps but a mark of the
// others, and looks at them again where it needs them: eight registers fewer.

// Beside the border; and where the tile has nothing.
const BESIDE: u32 = 1u;
const EMPTY: u32 = 2u;

fn is_interior(sheet: u32, offset: vec2<f32>) -> bool {
    let own = sheets[sheet];
    let from_middle = (vec3<f32>(own.cell) - frame.middle) + own.rest + offset.x * own.step_x + offset.y * own.step_y;
    return all(abs(from_middle) < frame.interior);
}

// Takes a plane's value and differences at a pixel.
fn enter(pixel: ptr<function, Pixel>, sheet: u32, point: u32, is_filled: bool) {
    var sum = 0.0;
    var missing = 0.0;
    var mark = EMPTY;
    var across = vec2(0.0);
    if is_filled {
        sum = values[point];
        missing = missing_at(point);
        mark = select(BESIDE, 0u, is_interior(sheet, (*pixel).offset));
        across = across_on(sheet, (*pixel).offset, point);
    }
    (*pixel).sums = vec4((*pixel).sums.yzw, sum);
    (*pixel).missing = vec4((*pixel).missing.yzw, missing);
    (*pixel).marks = ((*pixel).marks << 2u) | mark;
    (*pixel).across_before = (*pixel).across;
    (*pixel).across = (*pixel).across_last;
    (*pixel).across_last = across;
}

// Share of the weights that lies on the lattice, and coverage, on a marked plane.
fn share_and_coverage(mark: u32, sheet: u32, offset: vec2<f32>) -> vec2<f32> {
    if (mark & EMPTY) != 0u {
        // Outside of the volume there is no background either.
        return vec2(1.0, select(1.0, 0.0, frame.shows_background != 0u));
    }
    if (mark & BESIDE) == 0u {
        return vec2(1.0);
    }
    let place = place_on(sheet, offset);
    return vec2(share_at(place), coverage_at(place));
}

fn around(pixel: ptr<function, Pixel>, near: u32) -> Around {
    let offset = (*pixel).offset;
    let sums = sums_around(near, offset, (*pixel).sums);
    // Shares and coverage of the middle planes.
    var shares = vec2(1.0);
    var covered = vec2(1.0);
    let marks = ((*pixel).marks >> 2u) & 15u;
    if marks != 0u {
        for (var i = 0u; i < 2u; i++) {
            let own = share_and_coverage(marks >> (2u - 2u * i), near + i, offset);
            shares = vec2(shares.y, own.x);
            covered = vec2(covered.y, own.y);
        }
    }
    let per_share = 1.0 / max(shares.xxyy, vec4(0.15));
    let values = sums * per_share + frame.background;
    let is_untouched = sums.y == 0.0 && sums.z == 0.0;
    if !HAS_HOLES || all((*pixel).missing == vec4(0.0)) {
        return Around(values, values, covered, is_untouched);
    }
    let missing = missing_around(near, offset, (*pixel).missing) * per_share;
    let left = 1.0 - missing;
    return Around(
        values_beside(sums * per_share, missing) + frame.background,
        values - missing * frame.background,
        vec2(covered_by(covered.x, left.y), covered_by(covered.y, left.z)),
        is_untouched && missing.y == 0.0 && missing.z == 0.0,
    );
}
