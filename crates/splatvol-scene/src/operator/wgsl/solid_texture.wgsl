// Solid textures. Operands: centre, and periods per length.

fn marble(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let p = (sample.position - operand(at).xyz) * operand(at).w;
    let turbulence = noise_octaves(p * 0.6, 5u, true);
    let across = dot(p, vec3(0.62, 0.35, 0.70)) + 1.3 * turbulence;
    let wave = 0.5 + 0.5 * sin(6.2831853 * (across - round(across)));
    (*appearance).color = mix(vec3(0.83, 0.81, 0.76), vec3(0.055, 0.065, 0.085), wave * wave * (wave * wave));
}

fn wood(sample: SheetSample, appearance: ptr<function, Appearance>, at: u32) {
    let block = (sample.position - operand(at).xyz) * operand(at).w;
    let p = 3.0 * vec3(block.x + 0.33 * block.z, block.y - 0.21 * block.z, block.z);
    let bend = 0.45 * noise_octaves(p * vec3(0.35, 0.35, 0.12), 3u, false);
    let ring = length(p.xy) + bend;
    let age = ring - floor(ring);
    let t = clamp((age - 0.93) / 0.07, 0.0, 1.0);
    let late = age * age * (1.0 - t * t * (3.0 - 2.0 * t));
    let grain = gradient_noise(p * vec3(14.0, 14.0, 0.9), 9u);
    let share = clamp(late + 0.12 * grain, 0.0, 1.0);
    (*appearance).color = mix(vec3(0.58, 0.32, 0.12), vec3(0.13, 0.045, 0.014), share);
}
