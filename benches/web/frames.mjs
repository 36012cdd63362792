// Times the engine for browsers outside of one, by Node.js: whole pictures, and the slower of two shares.
//
//   node benches/web/frames.mjs ENGINE READERS FILE [KEYS] [EDGE]
//
// ENGINE and READERS are the modules that `cargo xtask web` builds, as they are or in gzip (crates/splatvol-page/engine); KEYS are
// those of a scene as JSON: '{"effects": {"classification": "pre"}}'. Least of nine, milliseconds, runs of all kinds in turn.

import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { gunzipSync } from "node:zlib";

const ROUNDS = 9;

function module(path) {
  const bytes = readFileSync(path);
  return new WebAssembly.Module(bytes[0] === 0x1f ? gunzipSync(bytes) : bytes);
}

/** An instance, which answers a header and bytes. */
function instance(module, answered, imports = {}) {
  const { exports } = new WebAssembly.Instance(module, imports);
  const ask = (header, bytes = new Uint8Array(0)) => {
    const text = new TextEncoder().encode(JSON.stringify(header));
    const place = exports.splatvol_message(text.length, bytes.length) >>> 0;
    const message = new Uint8Array(exports.memory.buffer, place, text.length + bytes.length);
    message.set(text);
    message.set(bytes, text.length);
    const answer = exports[answered]() >>> 0;
    const [said, length] = new Uint32Array(exports.memory.buffer.slice(answer, answer + 8));
    const own = Buffer.from(exports.memory.buffer, answer + 8, said + length);
    const found = JSON.parse(own.toString("utf8", 0, said));
    if (found.error) throw new Error(found.error);
    return { found, bytes: Uint8Array.from(own.subarray(said)) };
  };
  return { ask, memory: exports.memory };
}

/** A file's items, as the engine opens them. */
function read(readers, path) {
  const file = readFileSync(path);
  const fill = (_, position, address, length) => {
    new Uint8Array(own.memory.buffer, address >>> 0, length).set(file.subarray(position, position + length));
    return 1;
  };
  const own = instance(readers, "splatvol_read", { page: { read_file: fill } });
  return own.ask({ files: [{ path: basename(path), length: file.length }], keys: {} });
}

const [engine, readers, path, keys = "{}", edge = "512"] = process.argv.slice(2);
if (path === undefined) {
  console.error("usage: node benches/web/frames.mjs ENGINE READERS FILE [KEYS] [EDGE]");
  process.exit(2);
}
const { found, bytes } = read(module(readers), path);
const document = { ...JSON.parse(keys), item: found.items.map(({ name }) => ({ file: name })) };
const open = {
  do: "open",
  document,
  data: found.items.map(({ data }) => data),
  described: found.items.map(({ described }) => described),
};
const { ask } = instance(module(engine), "splatvol_answer");
ask(open, bytes);
const size = [Number(edge), Number(edge)];
const shares = [[0, 1], [0, 2], [1, 2]];
const least = shares.map(() => Infinity);
for (let round = 0; round <= ROUNDS; ++round) {
  for (const [i, share] of shares.entries()) {
    const start = performance.now();
    ask({ do: "render", size, camera: null, share });
    // The first round derives what later ones keep.
    if (round > 0) least[i] = Math.min(least[i], performance.now() - start);
  }
}
const [whole, half] = [least[0], Math.max(least[1], least[2])];
console.log(`${basename(path)}: ${whole.toFixed(1)} ms, of two shares ${half.toFixed(1)} ms: ${(whole / half).toFixed(2)} times faster`);
