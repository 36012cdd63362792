// The player: begins, holds the state, and hears mouse, fingers and keys.

/** Most pixels of the picture on the page. */
const MOST_PIXELS = 1600000;
/** Degrees per picture height of a drag. */
const DEGREES = 180;
/** Least width of a cut, share of that of the data. */
const LEAST_WIDTH = 1 / 500;

const $ = (id) => document.getElementById(id);

function trouble(text) {
  $("trouble").textContent = text;
}

/** What the panel says of the picture; aloud, by screen readers, unless it is said of what only passes by. */
function say(text, isAloud = true) {
  $("status").textContent = isAloud ? text : "";
  $("passing").textContent = isAloud ? "" : text;
}

function copied(value) {
  return JSON.parse(JSON.stringify(value));
}

/** Keys of an item that can be changed beside its transfer function, and those of points only. */
function ownKeys({ opacity }) {
  return opacity === null ? { visible: true } : { visible: true, opacity };
}

/** The state of the page: the camera, the looks, the cut; and what is still to be told to the instances. */
class View {
  constructor(facts, notes) {
    this.facts = facts;
    const { camera, effects, size } = facts.document;
    const projection = camera.fov === undefined
      ? { orthographic: { height: camera.orthographic } }
      : { perspective: { fov_degrees: camera.fov } };
    this.first = { position: camera.position, target: camera.target, up: camera.up, projection };
    this.pose = this.first;
    this.documentSize = size.split("x").map(Number);
    // A look of values and gradients goes over those of values alone.
    this.hasCurves = !(effects && effects.regions);
    this.own = (effects && effects["clip-box"]) || null;
    const { min, max } = facts.bounds;
    this.whole = [0, 1, 2].flatMap((i) => [min[i], max[i]]);
    // Points and Gaussians have no values, and so no look to be changed.
    this.valued = facts.items.flatMap(({ values }, index) => (values ? [{ index, ...values }] : []));
    this.state = { looks: facts.items.map(() => ({})), items: facts.items.map(ownKeys), box: [...(this.own || this.whole)] };
    this.past = [copied(this.state)];
    this.at = 0;
    this.edits = new Map();
    this.looks = facts.items.map(({ values }) => values && values["transfer-function"]);
    for (const values of this.valued) {
      const { extremes, range } = values;
      values.span = [Math.min(extremes[0], range[0]), Math.max(extremes[1], range[1])];
      if (values.span[0] === values.span[1]) values.span[1] += 1;
    }
    facts.about = notes;
    this.trouble = trouble;
  }

  // What the frames ask.

  size() {
    const stage = $("stage");
    const scale = Math.min(window.devicePixelRatio || 1, Math.sqrt(MOST_PIXELS / (stage.clientWidth * stage.clientHeight || 1)));
    return [stage.clientWidth, stage.clientHeight].map((side) => Math.max(1, Math.round(side * scale)));
  }

  camera([width, height]) {
    return cameraKeys(this.pose, width / height, this.documentSize[0] / this.documentSize[1]);
  }

  /** Everything that was changed so far, for an instance that has the document as it was opened. */
  allEdits() {
    const waiting = new Map(this.edits);
    this.tellAll();
    const all = [...this.edits.values()];
    this.edits = waiting;
    return all;
  }

  takeEdits() {
    const edits = [...this.edits.values()];
    this.edits.clear();
    return edits;
  }

  edited({ document: now }) {
    trouble("");
    this.looks = now.item.map((item) => item["transfer-function"]);
    this.panel.curves(this.looks);
  }

  /** There is a picture on the canvas. */
  seen() {
    $("poster").hidden = true;
  }

  progress({ step, isFinal }, took) {
    $("badge").textContent = isFinal ? "final" : `draft 1/${STEPS[step].toFixed(1).replace(".0", "")}`;
    if (isFinal) say(`Final picture, ${this.size().join(" × ")} pixels, ${(took / 1000).toFixed(2)} s.`);
    else say("Draft", false);
  }

  /** There is no picture of what should be shown. A draft of it stays one, where only the final picture has failed. */
  failed({ isFinal }) {
    const text = isFinal ? "Draft" : "Earlier picture";
    if (!isFinal) $("badge").textContent = text.toLowerCase();
    say(text, false);
  }

  /** Members were not told of changes: all of them are told again. */
  untold() {
    this.tellAll();
  }

  // Changes.

  turn(pose) {
    this.pose = pose;
    this.frames.changed();
  }

  home() {
    this.turn(this.first);
  }

  async look(name) {
    try {
      const { header } = await this.frames.members[0].ask({ do: "camera", camera: { view: name }, size: this.documentSize });
      if (header.error) trouble(header.error);
      else this.turn(header);
    } catch (error) {
      trouble(error.message || String(error));
    }
  }

  setLook(item, key, value) {
    const look = this.state.looks[item];
    if (value === null) delete look[key];
    else look[key] = value;
    this.tellLook(item);
    this.frames.changed();
  }

  tellLook(item) {
    this.edits.set(`look-${item}`, { do: "look", item, look: copied(this.state.looks[item]) });
  }

  /** Changes a key of an item, unless none would be left in the picture; returns whether it did. */
  setItem(item, key, value) {
    const { items } = this.state;
    if (key === "visible" && !value && items.every(({ visible }, index) => index === item || !visible)) return false;
    items[item][key] = value;
    this.tellItem(item);
    this.frames.changed();
    return true;
  }

  tellItem(item) {
    const edits = Object.entries(this.state.items[item]).map(([key, value]) => ({ path: `item[${item}].${key}`, value }));
    this.edits.set(`item-${item}`, { do: "edit", edits });
  }

  tellAll() {
    this.valued.forEach(({ index }) => this.tellLook(index));
    this.state.items.forEach((_, index) => this.tellItem(index));
    this.tellBox();
  }

  setBox(end, value) {
    const { box } = this.state;
    const [isLow, other] = [end % 2 === 0, end ^ 1];
    const [low, high] = isLow ? [this.whole[end], this.whole[other]] : [this.whole[other], this.whole[end]];
    // A box without a width is refused.
    const least = LEAST_WIDTH * (high - low);
    box[end] = isLow ? Math.min(value, high - least) : Math.max(value, low + least);
    box[other] = isLow ? Math.max(box[other], box[end] + least) : Math.min(box[other], box[end] - least);
    this.tellBox();
    this.frames.changed();
  }

  tellBox() {
    const { box } = this.state;
    const whole = !this.own && box.every((value, i) => value === this.whole[i]);
    this.edits.set("box", { do: "edit", edits: [{ path: "effects.clip-box", value: whole ? null : [...box] }] });
  }

  /** What was changed is one step back. */
  remember() {
    this.past.length = this.at + 1;
    this.past.push(copied(this.state));
    this.at += 1;
    this.panel.put(this.state);
    this.steps();
  }

  step(way) {
    if (!this.past[this.at + way]) return;
    this.at += way;
    this.restore(this.past[this.at]);
  }

  reset() {
    this.restore(this.past[0]);
    this.remember();
    this.home();
  }

  restore(state) {
    this.state = copied(state);
    this.tellAll();
    this.panel.put(this.state);
    this.steps();
    this.frames.changed();
  }

  steps() {
    this.panel.steps(this.at > 0, this.at < this.past.length - 1);
  }

  /** Less or more opaque, by a factor. */
  strengthen(factor) {
    if (!this.hasCurves || this.valued.length === 0) return;
    this.valued.forEach(({ index }) => {
      const look = this.state.looks[index];
      look.strength = Math.min(16, Math.max(1 / 16, (look.strength || 1) * factor));
      this.tellLook(index);
    });
    this.remember();
    this.frames.changed();
  }

  /** Saves the picture in the document's size, or says why there is none. */
  async save() {
    try {
      await this.download(await this.frames.picture(this.documentSize));
    } catch (error) {
      trouble(error.message || String(error));
    }
  }

  async download(image) {
    const canvas = element("canvas", { width: image.width, height: image.height });
    canvas.getContext("2d").putImageData(image, 0, 0);
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
    const url = URL.createObjectURL(blob);
    element("a", { href: url, download: `${document.title.replace(/[^\w.-]+/g, "-") || "picture"}.png` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
  }
}

/** Mouse, pen and fingers on the picture. */
function hearPointers(canvas, shown) {
  const down = new Map();
  const middle = () => {
    const all = [...down.values()];
    const centre = [0, 1].map((i) => all.reduce((sum, point) => sum + point[i], 0) / all.length);
    const [a, b] = [all[0], all[1] || all[0]];
    return { centre, reach: Math.hypot(a[0] - b[0], a[1] - b[1]), angle: Math.atan2(b[1] - a[1], b[0] - a[0]) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, [event.clientX, event.clientY]);
  });
  const up = (event) => down.delete(event.pointerId);
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) return;
    const before = middle();
    down.set(event.pointerId, [event.clientX, event.clientY]);
    const now = middle();
    const height = canvas.clientHeight || 1;
    const [x, y] = [0, 1].map((i) => (now.centre[i] - before.centre[i]) / height);
    if (down.size > 1) {
      let pose = panned(shown.view.pose, x, y);
      if (before.reach > 0 && now.reach > 0) pose = zoomed(pose, now.reach / before.reach);
      let twist = (now.angle - before.angle) / RADIANS;
      twist -= 360 * Math.round(twist / 360);
      shown.view.turn(orbited(pose, 0, 0, -twist));
    } else if (event.shiftKey || event.buttons === 4) {
      shown.view.turn(panned(shown.view.pose, x, y));
    } else if (event.ctrlKey) {
      shown.view.turn(orbited(shown.view.pose, 0, 0, -DEGREES * x));
    } else if (event.buttons === 2) {
      shown.view.turn(zoomed(shown.view.pose, 2 ** (-2 * y)));
    } else {
      shown.view.turn(orbited(shown.view.pose, -DEGREES * x, DEGREES * y));
    }
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : 1;
    shown.view.turn(zoomed(shown.view.pose, 2 ** (-event.deltaY * lines / 400)));
  }, { passive: false });
}

/** Keys on the picture. Arrows do what a drag in their direction does. */
function hearKeys(canvas, shown) {
  const step = 7.5;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  const views = { 1: "front", 2: "back", 3: "right", 4: "left", 7: "top", 8: "bottom", 9: "iso" };
  canvas.addEventListener("keydown", (event) => {
    const { key } = event;
    const arrow = arrows[key];
    const act = () => {
      if (arrow && event.altKey) return shown.view.turn(panned(shown.view.pose, arrow[0] / 20, -arrow[1] / 20));
      if (arrow && event.shiftKey) return shown.view.turn(orbited(shown.view.pose, 0, 0, -step * arrow[0]));
      if (arrow) return shown.view.turn(orbited(shown.view.pose, -step * arrow[0], -step * arrow[1]));
      if (key === "+" || key === "=") return shown.view.turn(zoomed(shown.view.pose, 1.15));
      if (key === "-" || key === "−") return shown.view.turn(zoomed(shown.view.pose, 1 / 1.15));
      if (key === "Home" || key === "Enter") return shown.view.home();
      if (key === "[" || key === "]") return shown.view.strengthen(key === "]" ? 1.25 : 0.8);
      if (key.toLowerCase() === "p" && !event.ctrlKey && !event.metaKey) return shown.view.save();
      if (views[key] && !event.ctrlKey && !event.metaKey && !event.altKey) return shown.view.look(views[key]);
      return null;
    };
    if (act() !== null) event.preventDefault();
  });
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    event.preventDefault();
    shown.view.step(event.shiftKey ? 1 : -1);
  });
}

/** Instances with the data of the page, and what they say of these. */
async function startInstances(page) {
  say("Unpacking the data.");
  const [module, samples] = await Promise.all([
    unpacked(bytesOf("engine")).then((bytes) => WebAssembly.compile(bytes)),
    unpacked(bytesOf("samples")),
  ]);
  say("Preparing the picture.");
  return openData(module, { document: page.document, data: page.data }, samples);
}

/** The GPU engine of this page, which is unpacked once; there only where the browser may have a device. */
const webgpu = {
  unpacking: null,
  isThere: () => Boolean(navigator.gpu) && (webgpu.unpacking !== null || $("webgpu").textContent !== ""),
  engine() {
    webgpu.unpacking = webgpu.unpacking || gpuEngine(["webgpu-bindings", "webgpu"].map(bytesOf));
    return webgpu.unpacking;
  },
};

/** Instances with data, and what they say of these. */
async function openData(module, message, samples) {
  const pool = await startPool(module, memberCount(samples.length));
  const open = { do: "open", ...message };
  const answers = await Promise.all(pool.members.map((member) => member.ask(open, samples)));
  const facts = answers[0].header;
  if (facts.error) {
    pool.members.forEach((member) => member.end());
    throw new Error(facts.error);
  }
  return { pool, facts, scene: webgpu.isThere() ? { open, samples, gpu: webgpu.engine } : {} };
}

/** What the page shows: first what it was made for, then what is opened in it. */
class Shown {
  constructor(opened, notes) {
    // Files are opened one after the other.
    this.opening = Promise.resolve();
    this.begin(opened, notes);
  }

  begin({ pool, facts, scene }, notes) {
    const view = new View(facts, notes);
    const frames = new Frames($("view"), pool, view);
    view.frames = frames;
    view.panel = buildPanel(view);
    view.panel.curves(view.looks);
    view.steps();
    Object.assign(this, { view, frames, pool, scene: { ...scene, edits: () => view.allEdits() } });
    frames.changed();
    frames.settled().then(() => this.quicken(false)).catch(noWebGpu);
  }

  /** Drafts by WebGPU, once the first picture is final; by an imitated device only if `force`d. */
  quicken(force) {
    return quicken(this.frames, this.scene, force);
  }

  /** Opens files, once those of before are opened. */
  open(files) {
    if (!hasReaders()) throw new Error("this page has no readers of files");
    this.opening = this.opening.then(files).then((list) => openFiles(this, list)).catch((error) => trouble(String(error)));
  }

  /** Shows something else. */
  show(opened, title, notes) {
    this.frames.end();
    document.title = title;
    document.querySelector("h1").textContent = title;
    $("view").setAttribute("aria-label", `Picture of ${title}, rendered by splatvol`);
    $("controls").replaceChildren();
    this.begin(opened, notes);
  }
}

async function main() {
  const page = JSON.parse($("facts").textContent);
  const shown = new Shown(await (page.served ? startServed(page) : startInstances(page)), page.notes);
  hearPointers($("view"), shown);
  hearKeys($("view"), shown);
  if (hasReaders()) hearFiles(shown);
  new ResizeObserver(() => shown.frames.changed()).observe($("stage"));
  return shown;
}

const started = main().catch((error) => {
  trouble(`This browser cannot show it: ${error.message || error}. The picture above stays as it was made.`);
  say("");
  throw error;
});

/**
 * For scripts: the picture of any size as it would be shown, when the page shows it finally, and by how many workers; whether
 * WebGPU makes the drafts, even if its device is imitated, and what it draws. `open` opens files: a list of `{ path, file }`, where the
 * page has readers.
 */
window.splatvol = {
  picture: async (width, height) => (await started).frames.picture([width, height]),
  quicken: async () => (await started).quicken(true),
  draft: async (width, height) => {
    const { frames } = await started;
    return frames.picture([width, height], frames.drafters);
  },
  settled: async () => {
    const shown = await started;
    await shown.opening;
    return shown.frames.settled();
  },
  open: async (files) => {
    const shown = await started;
    shown.open(() => files);
    return shown.opening;
  },
  workers: async () => (await started).pool.workers,
  view: async () => copied((await started).view.pose),
};
