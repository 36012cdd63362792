// The engine: instances of the module in workers, or one in the page where workers are blocked.

/**
 * An instance: a message in, an answer out, by a function of the module. Its source also runs in workers, so it uses nothing from
 * outside.
 */
function instance(answered = "splatvol_answer", imports = {}) {
  let exports = null;
  return {
    async start(module) {
      exports = (await WebAssembly.instantiate(module, imports)).exports;
    },
    memory: () => new Uint8Array(exports.memory.buffer),
    ask(header, bytes) {
      const text = new TextEncoder().encode(JSON.stringify(header));
      const extra = bytes || new Uint8Array(0);
      const place = exports.splatvol_message(text.length, extra.length) >>> 0;
      const message = new Uint8Array(exports.memory.buffer, place, text.length + extra.length);
      message.set(text);
      message.set(extra, text.length);
      const answer = exports[answered]() >>> 0;
      const memory = exports.memory.buffer;
      const view = new DataView(memory);
      const [said, pixels] = [view.getUint32(answer, true), view.getUint32(answer + 4, true)];
      return {
        header: JSON.parse(new TextDecoder().decode(new Uint8Array(memory, answer + 8, said))),
        bytes: new Uint8Array(memory, answer + 8 + said, pixels).slice(),
      };
    },
  };
}

/** What a worker does: `instance` is `make`. */
function work(make) {
  const own = make();
  onmessage = async ({ data }) => {
    const start = performance.now();
    try {
      if (data.module) {
        await own.start(data.module);
        postMessage({ ready: true });
      } else {
        const { header, bytes } = own.ask(data.header, data.bytes);
        postMessage({ header, bytes, milliseconds: performance.now() - start }, [bytes.buffer]);
      }
    } catch (error) {
      postMessage({ failed: String(error) });
    }
  };
}

/** Longest time until a worker answers that it has started, milliseconds: a worker that is blocked may never say so. */
const PATIENCE = 10000;

/** Memory that instances may take together, bytes, and what one takes per byte of data. */
const MEMORY = 1.5e9;
const PER_BYTE = 8;

/** Instances that are started: as many as there are processors and memory for. */
function memberCount(bytes) {
  const fit = Math.floor(MEMORY / (PER_BYTE * bytes + 5e7));
  return Math.max(1, Math.min(navigator.hardwareConcurrency || 2, 8, fit));
}

/** A member of the pool in a worker. Messages are answered in their order. */
function inWorker(module, url) {
  return new Promise((resolve, reject) => {
    const worker = new Worker(url);
    const waiting = [];
    const member = {
      ask: (header, bytes) =>
        new Promise((answered, failed) => {
          waiting.push({ answered, failed });
          worker.postMessage({ header, bytes });
        }),
      end: () => worker.terminate(),
    };
    const timer = setTimeout(() => reject(new Error("the worker does not answer")), PATIENCE);
    worker.onerror = (event) => {
      clearTimeout(timer);
      event.preventDefault();
      reject(new Error(event.message || "workers are blocked"));
      waiting.splice(0).forEach(({ failed }) => failed(new Error(event.message || "the worker stopped")));
    };
    worker.onmessage = ({ data }) => {
      clearTimeout(timer);
      if (data.ready) {
        resolve(member);
      } else if (data.progress !== undefined) {
        member.progress(data.progress);
      } else if (waiting.length === 0) {
        reject(new Error(data.failed));
      } else if (data.failed) {
        waiting.shift().failed(new Error(data.failed));
      } else {
        waiting.shift().answered(data);
      }
    };
    worker.postMessage({ module });
  });
}

/** The only member, in the page. It waits for the next frame first, so that the page is painted between messages. */
async function inPage(module) {
  const own = instance();
  await own.start(module);
  let last = Promise.resolve();
  const answer = async (header, bytes) => {
    await new Promise((resolve) => setTimeout(resolve));
    const start = performance.now();
    return { ...own.ask(header, bytes), milliseconds: performance.now() - start };
  };
  return {
    end() {},
    ask: (header, bytes) => {
      const next = last.then(() => answer(header, bytes));
      last = next.catch(() => {});
      return next;
    },
  };
}

/** Starts so many instances in workers, or one in the page if workers are blocked. */
async function startPool(module, count) {
  const source = `"use strict";\n${instance}\n(${work})(instance);\n`;
  try {
    const members = await inBlob(source, (url) => Promise.all(Array.from({ length: count }, () => inWorker(module, url))));
    return { members, workers: count, module };
  } catch (_blocked) {
    return { members: [await inPage(module)], workers: 0, module };
  }
}

/** What is made of the address of a script, which is there meanwhile. */
async function inBlob(source, make) {
  const url = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
  try {
    return await make(url);
  } finally {
    URL.revokeObjectURL(url);
  }
}

/** The bytes of base64 in an element, which is emptied. */
function bytesOf(id) {
  const element = document.getElementById(id);
  const text = element.textContent;
  element.textContent = "";
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const bytes = new Uint8Array(Math.floor((text.length * 3) / 4));
  let length = 0;
  // In pieces of whole bytes: one string of all of them would take several times their memory.
  for (let start = 0; start < text.length; start += 1 << 16) {
    const piece = atob(text.slice(start, start + (1 << 16)));
    for (let i = 0; i < piece.length; i += 1) bytes[length + i] = piece.charCodeAt(i);
    length += piece.length;
  }
  return bytes.subarray(0, length);
}

/** What gzip holds. */
async function unpacked(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
