// WebGPU: one more instance, in a worker, that draws what moves. Pages have it where it was built; browsers use it where they have a device.

/** What the worker does; `wasm_bindgen` are the bindings of the module. Messages are answered in their order. */
function workOnGpu() {
  let instance = null;
  let last = Promise.resolve();
  const answer = async ({ module, header, bytes }) => {
    const start = performance.now();
    if (module) {
      await wasm_bindgen({ module_or_path: module });
      instance = await wasm_bindgen.Instance.open();
      return { ready: true };
    }
    const said = await instance.answer(JSON.stringify(header), bytes || new Uint8Array(0));
    const answered = { header: JSON.parse(said.header), bytes: said.bytes, milliseconds: performance.now() - start };
    said.free();
    return answered;
  };
  onmessage = ({ data }) => {
    const next = last.then(() => answer(data));
    last = next.catch(() => {});
    next.then(
      (said) => postMessage(said, said.bytes ? [said.bytes.buffer] : []),
      (error) => postMessage({ failed: String(error.message || error) }),
    );
  };
}

/** Bindings and module, once they are unpacked. */
let webgpu = null;

/** Whether page and browser have what it takes. */
function mayHaveWebGpu() {
  return (webgpu !== null || $("webgpu").textContent !== "") && Boolean(navigator.gpu);
}

async function unpackedWebGpu() {
  const bindings = new TextDecoder().decode(await unpacked(bytesOf("webgpu-bindings")));
  return { bindings, module: await WebAssembly.compile(await unpacked(bytesOf("webgpu"))) };
}

/** An instance, or none: no module, no device, or one that the processor imitates unless that is `allowed`. */
async function startWebGpu(allowed) {
  if (!mayHaveWebGpu()) return null;
  const adapter = await navigator.gpu.requestAdapter({ powerPreference: "high-performance" });
  if (!adapter || (adapter.info && adapter.info.isFallbackAdapter && !allowed)) return null;
  webgpu = webgpu || unpackedWebGpu();
  const { bindings, module } = await webgpu;
  return inBlob(`"use strict";\n${bindings}\n(${workOnGpu})();\n`, (url) => inWorker(module, url));
}
