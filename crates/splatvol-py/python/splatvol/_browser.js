// The engine in the notebook's page: it draws while the camera moves, and goes on where the kernel is busy. The kernel sends it
// with data that are made to fit, in pieces, and its own pictures take the place of these at rest.

/** Engines that this page has, by their digests: every widget uses the same one. */
const ENGINES = (globalThis.splatvolEngines ??= new Map());

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
    Object.assign(this, { picture, send, edits: [], frames: null, expected: null, pieces: [] });
  }

  /** Takes what the kernel sends: first what is to come, then its bytes, piece by piece. */
  take(message, buffers) {
    if (message.edits) {
      this.follow(message.edits);
      return;
    }
    if (message.facts) {
      this.expected = message.facts;
      this.pieces = [];
      return;
    }
    if (!this.expected) return;
    const piece = buffers[0];
    this.pieces.push(new Uint8Array(piece.buffer, piece.byteOffset, piece.byteLength));
    const arrived = this.pieces.reduce((sum, { length }) => sum + length, 0);
    if (arrived < this.expected.engine + this.expected.samples) return;
    const all = new Uint8Array(arrived);
    this.pieces.reduce((start, own) => (all.set(own, start), start + own.length), 0);
    this.pieces = [];
    // Where it does not start, the kernel goes on alone.
    this.start(this.expected, all).catch((error) => console.warn(`splatvol: no engine in this page: ${error.message || error}`));
  }

  async start(facts, bytes) {
    const { key, engine, document, data } = facts;
    if (engine > 0) {
      ENGINES.set(key, unpacked(bytes.subarray(0, engine)).then((module) => WebAssembly.compile(module)));
    }
    const [module, samples] = await Promise.all([ENGINES.get(key), unpacked(bytes.subarray(engine))]);
    const pool = await startPool(module, memberCount(samples.length));
    const answers = await Promise.all(pool.members.map((member) => member.ask({ do: "open", document, data }, samples)));
    if (answers[0].header.error) throw new Error(answers[0].header.error);
    // Another scene may be on its way by now.
    if (facts !== this.expected) {
      pool.members.forEach((member) => member.end());
      return;
    }
    this.members = pool.members;
    this.distances = facts.distances;
    this.known = JSON.stringify(facts.edits);
    this.frames = new Frames(this.picture.canvas, pool, this);
    this.picture.canvas.dataset.workers = pool.workers;
    this.send({ kind: "draws", value: true });
    if (this.picture.hasMoved) this.frames.changed();
    else this.frames.replaced();
  }

  /** Forgets the scene, and ends its instances: another scene is shown, or none any more. */
  end() {
    this.expected = null;
    if (!this.frames) return;
    this.frames.replaced();
    this.frames = null;
    this.members.forEach((member) => member.end());
    this.send({ kind: "draws", value: false });
    delete this.picture.canvas.dataset.workers;
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
