//! The laws on this machine's device, and in a headless Chromium, whose WebGPU imitates one.

#[path = "../../splatvol-page/sources.rs"]
#[expect(dead_code, reason = "names of modules that are built elsewhere")]
mod sources;

use std::path::Path;
use std::time::Duration;

use serde_json::Value;
use splatvol_gpu::{GpuConfig, GpuEngine, GpuError};
use splatvol_testing::chromium::{Served, posted};

/// Longest time for all scenes: one thread renders them, twice, and imitates the device.
const PATIENCE: Duration = Duration::from_secs(240);
/// Posts the findings, or what went wrong.
const PAGE: &str = "<!doctype html><meta charset='utf-8'><script type='module'>
import init, { laws } from './splatvol_webgpu.js';
init({ module_or_path: './splatvol_webgpu_bg.wasm' }).then(() => laws()).catch(String).then((said) => fetch('/', { method: 'POST', body: said }));
</script>";

#[test]
fn pictures_keep_the_laws() {
    if let Err(error @ GpuError::NoAdapter { .. }) = GpuEngine::new(&GpuConfig::default()) {
        splatvol_recorded::skip(&error.to_string());
        return;
    }
    let findings = pollster::block_on(splatvol_webgpu::laws::findings()).unwrap();
    for finding in &findings {
        println!("{finding:?}");
    }
    assert!(findings.iter().all(|finding| finding.holds));
}

#[test]
fn browsers_keep_the_laws() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let module = root.join(sources::LAWS);
    let read = |name: &str| std::fs::read(module.join(name));
    let built = std::fs::read_to_string(module.join("sources.txt")).ok();
    if built.is_none() || built != sources::digest(&root, sources::WEBGPU) {
        splatvol_recorded::skip(
            "the module with the laws was not built of these sources (cargo xtask-webgpu --dev)",
        );
        return;
    }
    let (script, wasm) = (
        read("splatvol_webgpu.js").unwrap(),
        read("splatvol_webgpu_bg.wasm").unwrap(),
    );
    let files = [
        Served::page(PAGE),
        Served {
            path: "/splatvol_webgpu.js",
            content_type: "text/javascript",
            bytes: &script,
        },
        Served {
            path: "/splatvol_webgpu_bg.wasm",
            content_type: "application/wasm",
            bytes: &wasm,
        },
    ];
    let Some(said) = posted(&files, PATIENCE) else {
        splatvol_recorded::skip("Chromium is not installed (Debian: chromium)");
        return;
    };
    let findings: Vec<Value> = serde_json::from_str(&said).unwrap_or_else(|_| panic!("{said}"));
    for finding in &findings {
        println!("{finding}");
    }
    assert!(findings.len() >= 10 && findings.iter().all(|finding| finding["holds"] == true));
}
