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

/** Whether the browser has a device; one that the processor imitates counts only where that is `allowed`. */
async function hasGpu(allowed) {
  const adapter = navigator.gpu && (await navigator.gpu.requestAdapter({ powerPreference: "high-performance" }));
  return Boolean(adapter) && (allowed || !(adapter.info && adapter.info.isFallbackAdapter));
}

/** The engine of packed bindings and module. */
async function gpuEngine([bindings, module]) {
  return {
    bindings: new TextDecoder().decode(await unpacked(bindings)),
    module: await WebAssembly.compile(await unpacked(module)),
  };
}

/**
 * Drafts of `frames` by WebGPU; by an imitated device only if `force`d. Returns whether it draws them. `scene` has the message that
 * opened it, the `samples` of that, the promise of an engine (`gpu`), and all that has been edited since then (`edits`).
 */
async function quicken(frames, scene, force) {
  if (frames.fast) return true;
  if (!scene.open || !(await hasGpu(force))) return false;
  const { bindings, module } = await scene.gpu();
  const source = `"use strict";\n${bindings}\n(${workOnGpu})();\n`;
  const member = await inBlob(source, (url) => inWorker(module, url));
  try {
    await told(member, [scene.open], scene.samples);
    Object.assign(scene, { open: null, samples: null });
    if (!force && !(await isFaster(member, frames))) throw new Error("it is slower than the processor");
    // Something may be changed while it is told.
    for (let changes = -1; changes !== frames.changes; ) {
      changes = frames.changes;
      await told(member, scene.edits());
    }
    if (frames.isOver) throw new Error("something else is shown by now");
    frames.quickened(member);
    return true;
  } catch (error) {
    member.end();
    throw error;
  }
}

/** Tells a member to do something, one after the other. */
async function told(member, headers, bytes) {
  for (const header of headers) {
    const answer = await member.ask(header, bytes);
    if (answer.header.error) throw new Error(answer.header.error);
  }
}

/** Whether a member draws a small draft in less time than the others would. */
async function isFaster(member, frames) {
  const size = frames.view.size().map((side) => Math.max(1, Math.round(side / STEPS[FINEST])));
  const pixels = size[0] * size[1];
  // Of a picture that somebody else has drawn the others know no time.
  const cost = frames.cost || (await timed(frames.drafters[0], frames, size)) / pixels;
  return (await timed(member, frames, size)) < (cost * pixels) / frames.drafters.length;
}

/** Milliseconds that a member takes for a draft of what is shown: the second one, as the first one has to prepare. */
async function timed(member, frames, size) {
  let took = 0;
  for (const _time of [1, 2]) {
    const { header, milliseconds } = await member.ask({ do: "render", size, camera: frames.view.camera(size) });
    if (header.error) throw new Error(header.error);
    took = milliseconds;
  }
  return took;
}

/** Says in the console why there is no WebGPU: drafts come all the same. */
function noWebGpu(error) {
  console.warn(`splatvol: no WebGPU: ${error.message || error}`);
  return false;
}
