// Nodes: the transfer function at equally spaced values (`splatvol_core::classification`).

// Per node: integrals of extinction and emission up to it; extinction and linear colour there.
@group(0) @binding(6) var<storage, read> nodes: array<vec4<f32>>;

const FIRST_NODE: f32 = -0.5;
const NODES_PER_VALUE: f32 = 2048.0;
const LAST_NODE_POSITION: f32 = 4095.99;

fn node_position(value: f32) -> f32 {
    return clamp((value - FIRST_NODE) * NODES_PER_VALUE, 0.0, LAST_NODE_POSITION);
}
