// The engine in the notebook's page: it draws while the camera moves, and goes on where the kernel is busy. The kernel sends it
// with data that are made to fit, in pieces, and its own pictures take the place of these at rest. Where the browser has a device for
// WebGPU, the page asks for the GPU engine, too.

/** Engines that this page has, by their digests: every widget uses the same ones. */
const ENGINES = (globalThis.splatvolEngines ??= new Map());

/** Whether a device that the processor imitates is good enough: for tests only. */
const isImitationFine = () => globalThis.splatvolImitatedGpu === true;

/** Whether two cameras look alike. Directions that are up may be said in more than one way. */
function sameCamera(a, b) {
  const numbers = ({ position, target, fov, orthographic }) => [...position, ...target, fov ?? 0, orthographic ?? 0];
  const [x, y] = [numbers(a), numbers(b)];
  const reach = Math.max(...x.map(Math.abs), ...y.map(Math.abs));
  return x.every((value, i) => Math.abs(value - y[i]) <= 1e-9 * reach);
}

/** Pictures by the engine in the page, of a `picture` with a canvas, a camera and a size. */
class InPage {
  constructor(picture, send) {
    Object.assign(this, { picture, send, edits: [], keys: new Map(), scene: null, frames: null });
    Object.assign(this, { expected: null, isGpu: false, lengths: [0, 0], pieces: [] });
  }

  /** Takes what the kernel sends: first what is to come, then its bytes, piece by piece. */
  take(message, buffers) {
    if (message.edits) {
      this.follow(message.edits);
      return;
    }
    if (message.lengths) {
      Object.assign(this, { lengths: message.lengths, isGpu: !message.facts, pieces: [] });
      if (message.facts) this.expected = message.facts;
      return;
    }
    if (!this.expected) return;
    const piece = buffers[0];
    this.pieces.push(new Uint8Array(piece.buffer, piece.byteOffset, piece.byteLength));
    const arrived = this.pieces.reduce((sum, { length }) => sum + length, 0);
    if (arrived < this.lengths[0] + this.lengths[1]) return;
    const all = new Uint8Array(arrived);
    this.pieces.reduce((start, own) => (all.set(own, start), start + own.length), 0);
    this.pieces = [];
    const parts = [all.subarray(0, this.lengths[0]), all.subarray(this.lengths[0])];
    if (this.isGpu) {
      ENGINES.set(this.expected.gpu, gpuEngine(parts));
      this.quicken().catch(noWebGpu);
      return;
    }
    // Where it does not start, the kernel goes on alone.
    this.start(this.expected, parts).catch((error) => console.warn(`splatvol: no engine in this page: ${error.message || error}`));
  }

  async start(facts, [engine, packed]) {
    const { key, document, data } = facts;
    if (engine.length > 0) ENGINES.set(key, unpacked(engine).then((module) => WebAssembly.compile(module)));
    const [module, samples] = await Promise.all([ENGINES.get(key), unpacked(packed)]);
    const pool = await startPool(module, memberCount(samples.length));
    const open = { do: "open", document, data };
    const answers = await Promise.all(pool.members.map((member) => member.ask(open, samples)));
    if (answers[0].header.error) throw new Error(answers[0].header.error);
    // Another scene may be on its way by now.
    if (facts !== this.expected) {
      pool.members.forEach((member) => member.end());
      return;
    }
    this.distances = facts.distances;
    this.known = JSON.stringify(facts.edits);
    this.frames = new Frames(this.picture.canvas, pool, this);
    this.picture.canvas.dataset.workers = pool.workers;
    this.send({ kind: "draws", value: true });
    if (this.picture.hasMoved) this.frames.changed();
    else this.frames.replaced();
    this.keys.clear();
    const edits = () => [{ do: "edit", edits: [...this.keys].map(([path, value]) => ({ path, value })) }];
    this.scene = { open, samples, edits, gpu: () => ENGINES.get(facts.gpu) };
    await this.wantGpu().catch(noWebGpu);
  }

  /** Asks for the GPU engine, where there is one and a device; where the page has it, WebGPU draws from now on. */
  async wantGpu() {
    const { scene } = this;
    const { gpu } = this.expected;
    const has = gpu !== null && (await hasGpu(isImitationFine()));
    if (!has) Object.assign(scene, { open: null, samples: null });
    else if (ENGINES.has(gpu)) await this.quicken();
    else if (scene === this.scene) this.send({ kind: "gpu" });
  }

  async quicken() {
    const { frames, scene, picture } = this;
    const draws = frames !== null && (await quicken(frames, scene, isImitationFine()));
    if (frames !== null && frames === this.frames) picture.canvas.dataset.webgpu = draws;
  }

  /** Forgets the scene, and ends its instances: another scene is shown, or none any more. */
  end() {
    this.expected = null;
    if (!this.frames) return;
    this.frames.replaced();
    this.frames.end();
    Object.assign(this, { frames: null, scene: null });
    this.send({ kind: "draws", value: false });
    delete this.picture.canvas.dataset.workers;
    delete this.picture.canvas.dataset.webgpu;
  }

  changed() {
    if (this.frames) this.frames.changed();
  }

  /** What the document says, as the kernel knows it. */
  follow(edits) {
    const known = JSON.stringify(edits);
    if (known !== this.known) this.tell(edits);
    this.known = known;
  }

  /** Keys of the document that have changed. */
  tell(edits) {
    if (!this.frames) return;
    this.known = null;
    const looks = edits.map(({ path, value }) => {
      const item = /^item\[(\d+)\]\.transfer-function$/.exec(path);
      return { path, value: item && value ? { ...value, unit_distance: value.unit_distance ?? this.distances[item[1]] } : value };
    });
    this.edits.push({ do: "edit", edits: looks });
    for (const { path, value } of looks) {
      // What is said last goes last.
      this.keys.delete(path);
      this.keys.set(path, value);
    }
    this.frames.changed();
  }

  /** Whether the kernel's picture is to be shown. Its drafts are not, and none from where nobody looks any more. */
  wants(message) {
    if (!this.frames) return true;
    return message.final && (!message.camera || sameCamera(message.camera, this.picture.camera));
  }

  /** The kernel's picture is on the canvas. */
  replaced() {
    if (this.frames) this.frames.replaced();
  }

  // What the frames ask.

  size() {
    return this.picture.fullSize;
  }

  camera() {
    return this.picture.camera;
  }

  takeEdits() {
    return this.edits.splice(0);
  }

  edited() {}

  seen() {}

  progress({ step }) {
    this.picture.painted({ final: false, step });
  }

  trouble(text) {
    // The kernel says what is wrong with an edit; its picture comes all the same.
    console.warn(`splatvol: ${text}`);
  }
}
