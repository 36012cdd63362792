//! What JavaScript calls.

use wasm_bindgen::prelude::{JsValue, wasm_bindgen};

use crate::Session;

/// An instance of the GPU engine.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Instance(Session);

/// An answer: its header, JSON, and bytes.
#[wasm_bindgen(getter_with_clone)]
#[derive(Debug)]
pub struct Said {
    /// What it says.
    pub header: String,
    /// Pixels, where there are any.
    pub bytes: Vec<u8>,
}

#[wasm_bindgen]
impl Instance {
    /// An instance without a document, on the device that the browser prefers.
    ///
    /// # Errors
    /// No WebGPU, or a device that lacks what the engine needs.
    pub async fn open() -> Result<Self, JsValue> {
        let session = Session::open().await;
        Ok(Self(
            session.map_err(|error| JsValue::from_str(&error.to_string()))?,
        ))
    }

    /// Answers a message. Only one at a time: the next one after the promise has been kept.
    pub async fn answer(&mut self, header: String, bytes: Vec<u8>) -> Said {
        let answer = self.0.answer(&header, &bytes).await;
        Said {
            header: answer.header,
            bytes: answer.bytes,
        }
    }
}

/// Renders the scenes of [`crate::laws`]; a promise of their findings, JSON.
///
/// # Errors
/// No WebGPU, or a device that refuses something.
#[cfg(feature = "laws")]
#[wasm_bindgen]
pub async fn laws() -> Result<String, JsValue> {
    let findings = crate::laws::findings().await;
    let json = findings.and_then(|findings| Ok(serde_json::to_string(&findings)?));
    json.map_err(|error| JsValue::from_str(&error.to_string()))
}
