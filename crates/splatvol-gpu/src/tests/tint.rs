//! Tint: the compiler of WGSL in Chromium takes every shader and every entry point, within WebGPU's default limits.
//!
//! naga, with which wgpu compiles, takes barriers where invocations may part ways; Tint does not, and the browsers with it.

use std::fmt::Write as _;
use std::time::Duration;

use splatvol_testing::chromium::{Served, posted};

use super::layout::{every_shader, valid, variants};

/// Longest time for all shaders.
const PATIENCE: Duration = Duration::from_secs(120);
/// Compiles all modules and their entry points, and says how many, or what was refused.
const SCRIPT: &str = r"
(async () => {
    const adapter = await navigator.gpu?.requestAdapter();
    if (!adapter) return 'no adapter';
    const device = await adapter.requestDevice();
    const refused = [];
    let compiled = 0;
    for (const { code, entries, constants } of shaders) {
        const module = device.createShaderModule({ code });
        const { messages } = await module.getCompilationInfo();
        refused.push(...messages.map((said) => `${entries}: line ${said.lineNum}: ${said.message}`));
        for (const entryPoint of messages.length ? [] : entries) {
            const pipeline = { layout: 'auto', compute: { module, entryPoint, constants } };
            await device.createComputePipelineAsync(pipeline)
                .then(() => { compiled += 1; }, (error) => refused.push(`${entryPoint}: ${error.message}`));
        }
    }
    return refused.length ? refused.join('\n') : `compiled ${compiled}`;
})().catch(String).then((said) => fetch('/', { method: 'POST', body: said }));
";

/// A page that compiles shaders, the first also to programs of their entry points; and the number of these.
fn page(shaders: &[String], variants: &[String]) -> (String, usize) {
    let mut count = 0;
    let mut list = String::new();
    for text in variants {
        writeln!(list, "{{ code: {text:?}, entries: [], constants: {{}} }},").unwrap();
    }
    for text in shaders {
        let module = valid(text);
        let entries: Vec<_> = module.entry_points.iter().map(|entry| &entry.name).collect();
        let open = module.overrides.iter().filter(|(_, own)| own.init.is_none());
        let constants: String = open
            .filter_map(|(_, own)| Some(format!("{}: 1,", own.name.as_ref()?)))
            .collect();
        count += entries.len();
        // Rust's literals of text and of lists are JavaScript's.
        writeln!(
            list,
            "{{ code: {text:?}, entries: {entries:?}, constants: {{{constants}}} }},"
        )
        .unwrap();
    }
    let page =
        format!("<!doctype html><meta charset='utf-8'><script>const shaders = [{list}];{SCRIPT}</script>");
    (page, count)
}

#[test]
fn browsers_compile_every_shader() {
    let (page, count) = page(&every_shader(), &variants());
    match posted(&[Served::page(&page)], PATIENCE) {
        Some(said) => assert_eq!(said, format!("compiled {count}")),
        None => splatvol_recorded::skip("Chromium is not installed (Debian: chromium)"),
    }
}
