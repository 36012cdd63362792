// Values: sums of weights, and of values times these.

alias Sums = vec2<f32>;

fn sums_of(payload: vec4<f32>) -> Sums {
    return payload.xy;
}
