//! The CPU engine: tiles, sheets, SIMD splatting, shading and compositing.
