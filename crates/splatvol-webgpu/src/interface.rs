//! What JavaScript calls.

use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

/// Renders the scenes of [`crate::laws`]; a promise of their findings, JSON.
///
/// # Errors
/// No WebGPU, or a device that refuses something.
#[wasm_bindgen]
pub async fn laws() -> Result<String, JsValue> {
    let findings = crate::laws::findings().await;
    let json = findings.and_then(|findings| Ok(serde_json::to_string(&findings)?));
    json.map_err(|error| JsValue::from_str(&error.to_string()))
}
