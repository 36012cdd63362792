// Colors: sums of extinction and emission.

alias Sums = vec4<f32>;

fn sums_of(payload: vec4<f32>) -> Sums {
    return payload;
}
