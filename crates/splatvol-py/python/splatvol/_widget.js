// The widget's front end: shows frames, turns the camera, edits the look. The kernel renders, and the engine in the page while
// something moves, where the kernel has sent it.

const SVG = "http://www.w3.org/2000/svg";
// The editor, in its own units: place for the histogram and the points, then for the colours.
const WIDTH = 340;
const CURVE = 92;
const PAD = 8;
const STRIP = 14;

const add = (a, b, s = 1) => a.map((x, i) => x + s * b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/** A vector turned around a unit axis (Rodrigues). */
function turned(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(v.map((x) => x * c), cross(axis, v), s), axis, dot(axis, v) * (1 - c));
}

/** The camera around its target: radians to its right, and upwards; it never passes over the poles. */
function orbit(camera, azimuth, elevation) {
  const axis = unit(camera.up);
  let back = turned(add(camera.position, camera.target, -1), axis, azimuth);
  const polar = Math.acos(clamp(dot(unit(back), axis), -1, 1));
  const right = unit(cross(axis, back));
  // Turning around `right` by a positive angle raises the angle to the axis.
  back = turned(back, right, clamp(polar - elevation, 0.03, Math.PI - 0.03) - polar);
  return { ...camera, position: add(camera.target, back) };
}

/** The picture's height in world lengths, at the target. */
function heightAt(camera) {
  const distance = Math.hypot(...add(camera.position, camera.target, -1));
  return camera.orthographic ?? 2 * distance * Math.tan((camera.fov * Math.PI) / 360);
}

/** The camera moved across its view, by shares of the picture's height. */
function pan(camera, x, y) {
  const back = unit(add(camera.position, camera.target, -1));
  const right = unit(cross(camera.up, back));
  const height = heightAt(camera);
  const move = add(right.map((r) => -r * x * height), cross(back, right), y * height);
  return { ...camera, position: add(camera.position, move), target: add(camera.target, move) };
}

function zoom(camera, factor) {
  if (camera.orthographic !== undefined) return { ...camera, orthographic: camera.orthographic / factor };
  const half = Math.tan((camera.fov * Math.PI) / 360) / factor;
  // Wider views are another, slower, way of rendering.
  return { ...camera, fov: clamp((360 / Math.PI) * Math.atan(half), 0.2, 60) };
}

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function shape(parent, name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return parent.appendChild(made);
}

function menu(label, entries, chosen, change) {
  const select = element("select", { "aria-label": label });
  for (const [value, text] of entries) select.append(element("option", { value }, text));
  select.value = chosen;
  select.addEventListener("change", () => change(select.value));
  return element("label", {}, `${label} `, select);
}

/** Calls with the last arguments, some forty times a second at most: a kernel takes a while for each message. */
function paced(call) {
  let last = null;
  let called = 0;
  const tick = (now) => {
    if (now - called < 24) return requestAnimationFrame(tick);
    called = now;
    const given = last;
    last = null;
    call(...given);
  };
  return (...args) => {
    const waits = last !== null;
    last = args;
    if (!waits) requestAnimationFrame(tick);
  };
}

/** The picture: an image that listens to mouse and keys. */
class Picture {
  constructor(send) {
    this.canvas = element("canvas", { tabindex: 0, role: "application", class: "splatvol-picture" });
    this.canvas.setAttribute(
      "aria-label",
      "Rendered volume. Arrows turn, shift and arrows move, plus and minus zoom, r resets.",
    );
    this.context = this.canvas.getContext("2d");
    this.camera = null;
    // Size of the kernel's pictures at rest, and whether the camera was moved here.
    this.fullSize = [1, 1];
    this.hasMoved = false;
    this.send = send;
    this.inPage = new InPage(this, send);
    this.sendCamera = paced(() => send({ kind: "camera", camera: this.camera }));
    this.listen();
  }

  size([width, height]) {
    this.fullSize = [width, height];
    if (this.canvas.width === width && this.canvas.height === height) return;
    [this.canvas.width, this.canvas.height] = [width, height];
  }

  move(camera) {
    this.camera = camera;
    this.hasMoved = true;
    this.sendCamera();
    this.inPage.changed();
  }

  /** The camera as somebody else has placed it. */
  place(camera) {
    const moves = this.camera && !sameCamera(camera, this.camera);
    this.camera = camera;
    if (moves) this.inPage.changed();
  }

  async draw(message, bytes) {
    if (!this.inPage.wants(message)) return;
    const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    // It may be that the camera has moved meanwhile.
    if (!this.inPage.wants(message)) return image.close();
    const { width, height } = this.canvas;
    if (message.final) this.size([message.width, message.height]);
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.context.drawImage(image, 0, 0, message.final ? message.width : width, message.final ? message.height : height);
    image.close();
    if (message.final) this.inPage.replaced();
    this.canvas.dataset.frame = message.number;
    this.canvas.dataset.rendered = `${message.width}x${message.height}`;
    this.painted(message);
  }

  /** Says what is shown: those who watch, and tests, read it here. */
  painted(message) {
    this.canvas.dataset.final = message.final;
    this.canvas.dispatchEvent(new CustomEvent("splatvol-frame", { bubbles: true, detail: message }));
  }

  listen() {
    const canvas = this.canvas;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (!this.camera || event.button > 1) return;
      canvas.setPointerCapture(event.pointerId);
      canvas.focus({ preventScroll: true });
      last = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const height = canvas.clientHeight || 1;
      const [x, y] = [(event.clientX - last[0]) / height, (event.clientY - last[1]) / height];
      last = [event.clientX, event.clientY];
      const pans = event.shiftKey || event.buttons === 4;
      this.move(pans ? pan(this.camera, x, y) : orbit(this.camera, -Math.PI * x, Math.PI * y));
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (last = null));
    canvas.addEventListener("dblclick", () => this.send({ kind: "home" }));
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (!this.camera) return;
        event.preventDefault();
        const lines = event.deltaMode === 0 ? event.deltaY : event.deltaY * 16;
        this.move(zoom(this.camera, Math.exp(-0.0015 * clamp(lines, -400, 400))));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (!this.camera || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key in arrows) {
      const [x, y] = arrows[event.key];
      const step = Math.PI / 36;
      this.move(event.shiftKey ? pan(this.camera, 0.05 * x, 0.05 * y) : orbit(this.camera, -step * x, step * y));
    } else if (event.key === "+" || event.key === "=") this.move(zoom(this.camera, 1.1));
    else if (event.key === "-") this.move(zoom(this.camera, 1 / 1.1));
    else if (event.key === "r") this.send({ kind: "home" });
    else return;
    // The notebook has commands of its own by these keys.
    event.preventDefault();
    event.stopPropagation();
  }
}

/** The transfer function of one item, over the histogram of its values. */
class Editor {
  constructor(item, changed) {
    this.look = item.look;
    [this.low, this.high] = item.range[1] > item.range[0] ? item.range : [item.range[0], item.range[0] + 1];
    this.changed = changed;
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("viewBox", `0 0 ${WIDTH} ${CURVE + STRIP + 3 * PAD}`);
    this.svg.setAttribute("class", "splatvol-editor");
    this.svg.setAttribute("role", "group");
    this.svg.setAttribute("aria-label", "Opacity of values. Double click adds a point, right click removes it.");
    this.histogram(item.histogram);
    this.id = `splatvol-${Math.random().toString(36).slice(2)}`;
    this.gradient = shape(shape(this.svg, "defs", {}), "linearGradient", { id: this.id });
    const strip = { x: PAD, y: CURVE + PAD, width: WIDTH - 2 * PAD, height: STRIP, fill: `url(#${this.id})` };
    shape(this.svg, "rect", strip);
    this.line = shape(this.svg, "path", { class: "splatvol-curve" });
    this.marks = shape(this.svg, "g", {});
    this.svg.addEventListener("dblclick", (event) => this.insert(event));
    this.svg.addEventListener("contextmenu", (event) => event.preventDefault());
    this.draw();
  }

  x(value) {
    return PAD + clamp((value - this.low) / (this.high - this.low), 0, 1) * (WIDTH - 2 * PAD);
  }

  // Opacities of a voxel are small where a volume is thin: the cube root makes room for them.
  y(opacity) {
    return CURVE - Math.cbrt(opacity) * (CURVE - PAD);
  }

  /** Value and opacity at a place of the screen. */
  at(event) {
    const box = this.svg.getBoundingClientRect();
    const scale = WIDTH / box.width;
    const share = ((event.clientX - box.left) * scale - PAD) / (WIDTH - 2 * PAD);
    const height = (CURVE - (event.clientY - box.top) * scale) / (CURVE - PAD);
    return [this.low + clamp(share, 0, 1) * (this.high - this.low), clamp(height, 0, 1) ** 3];
  }

  histogram(heights) {
    const step = (WIDTH - 2 * PAD) / Math.max(heights.length, 1);
    const bars = heights.map((h, i) => `L${PAD + i * step} ${CURVE - h * (CURVE - PAD)}h${step}`).join("");
    shape(this.svg, "path", { class: "splatvol-histogram", d: `M${PAD} ${CURVE}${bars}V${CURVE}Z` });
  }

  draw() {
    const { colors, opacities } = this.look;
    this.gradient.replaceChildren();
    for (const { value, rgb } of colors) {
      const offset = clamp((value - this.low) / (this.high - this.low), 0, 1);
      const color = `rgb(${rgb.map((c) => Math.round(255 * c)).join(" ")})`;
      shape(this.gradient, "stop", { offset, "stop-color": color });
    }
    const ends = [[PAD, opacities[0]], ...opacities.map((p) => [this.x(p.value), p]), [WIDTH - PAD, opacities.at(-1)]];
    this.line.setAttribute("d", ends.map(([x, p], i) => `${i ? "L" : "M"}${x} ${this.y(p.opacity)}`).join(""));
    this.marks.replaceChildren();
    opacities.forEach((point, index) => this.point(point, index));
    this.end(0);
    this.end(colors.length - 1);
  }

  point(point, index) {
    const circle = shape(this.marks, "circle", { cx: this.x(point.value), cy: this.y(point.opacity), r: 5 });
    const label = `Opacity ${point.opacity.toPrecision(3)} at ${point.value.toPrecision(4)}`;
    for (const [key, value] of [["tabindex", 0], ["role", "slider"], ["aria-label", label], ["aria-valuemin", 0]])
      circle.setAttribute(key, value);
    circle.setAttribute("aria-valuemax", 1);
    circle.setAttribute("aria-valuenow", point.opacity);
    shape(circle, "title", {}).textContent = label;
    this.drag(circle, (value, opacity) => this.set(index, value, opacity));
    circle.addEventListener("contextmenu", () => this.remove(index));
    circle.addEventListener("keydown", (event) => {
      const step = (this.high - this.low) / 100;
      const root = Math.cbrt(point.opacity);
      const moves = {
        ArrowLeft: [point.value - step, point.opacity],
        ArrowRight: [point.value + step, point.opacity],
        ArrowUp: [point.value, Math.min(root + 0.02, 1) ** 3],
        ArrowDown: [point.value, Math.max(root - 0.02, 0) ** 3],
      };
      if (event.key in moves) this.set(index, ...moves[event.key]);
      else if (event.key === "Delete" || event.key === "Backspace") this.remove(index);
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.marks.querySelectorAll("circle")[Math.min(index, this.look.opacities.length - 1)].focus();
    });
  }

  /** A handle of the colours' range: it stretches them all. */
  end(index) {
    const x = this.x(this.look.colors[index].value);
    const y = CURVE + PAD + STRIP;
    const d = `M${x} ${y - 4}l6 10h-12Z`;
    const handle = shape(this.marks, "path", { d, class: "splatvol-handle", tabindex: 0, role: "slider" });
    const value = this.look.colors[index].value;
    const label = `${index ? "Upper" : "Lower"} end of the colours`;
    handle.setAttribute("aria-label", label);
    handle.setAttribute("aria-valuenow", value);
    shape(handle, "title", {}).textContent = `${label}: ${value.toPrecision(4)}`;
    this.drag(handle, (value) => this.stretch(index, value));
    handle.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      this.stretch(index, value + (step * (this.high - this.low)) / 100);
      event.preventDefault();
      event.stopPropagation();
      this.marks.querySelectorAll("path")[index ? 1 : 0].focus();
    });
  }

  drag(mark, move) {
    mark.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      // The marks are drawn anew with every move, so the editor, which stays, follows the pointer.
      this.svg.setPointerCapture(event.pointerId);
      const follow = (event) => move(...this.at(event));
      const end = () => {
        this.svg.removeEventListener("pointermove", follow);
        this.svg.removeEventListener("pointerup", end);
        this.svg.removeEventListener("pointercancel", end);
      };
      this.svg.addEventListener("pointermove", follow);
      this.svg.addEventListener("pointerup", end);
      this.svg.addEventListener("pointercancel", end);
    });
  }

  set(index, value, opacity) {
    const points = this.look.opacities;
    const low = points[index - 1]?.value ?? this.low;
    const high = points[index + 1]?.value ?? this.high;
    points[index] = { ...points[index], value: clamp(value, Math.min(low, high), Math.max(low, high)), opacity };
    this.edited();
  }

  remove(index) {
    if (this.look.opacities.length < 3) return;
    this.look.opacities.splice(index, 1);
    this.edited();
  }

  insert(event) {
    if (event.target.tagName === "circle") return;
    const [value, opacity] = this.at(event);
    const after = this.look.opacities.findIndex((point) => point.value > value);
    this.look.opacities.splice(after < 0 ? this.look.opacities.length : after, 0, { value, opacity });
    this.edited();
  }

  stretch(index, value) {
    const colors = this.look.colors;
    const [low, high] = [colors[0].value, colors.at(-1).value];
    const least = (this.high - this.low) / 200;
    const [from, to] = index ? [low, Math.max(value, low + least)] : [Math.min(value, high - least), high];
    const share = (point) => (high > low ? (point.value - low) / (high - low) : 0);
    this.look.colors = colors.map((point) => ({ ...point, value: from + share(point) * (to - from) }));
    this.edited();
  }

  edited() {
    this.draw();
    this.changed(this.look);
  }
}

/** Sliders of the box that is kept. */
function clipBox(state, send, inPage) {
  const [low, high] = state.bounds;
  const axes = ["x", "y", "z"];
  const given = state.clip ?? axes.flatMap((_, i) => [low[i], high[i]]);
  const rows = axes.map((axis, i) => {
    const span = high[i] - low[i] || 1;
    const slider = (end) => {
      const value = Math.round((1000 * (given[2 * i + end] - low[i])) / span);
      const label = `Clip ${axis} ${end ? "above" : "below"}`;
      return element("input", { type: "range", min: 0, max: 1000, value: clamp(value, 0, 1000), "aria-label": label });
    };
    return [slider(0), slider(1)];
  });
  const changed = paced(() => {
    const shares = rows.flat().map((slider) => slider.value / 1000);
    const isWhole = shares.every((share, i) => share === i % 2);
    const place = (share, i) => low[i >> 1] + share * (high[i >> 1] - low[i >> 1]);
    const box = isWhole ? null : shares.map(place);
    inPage.tell([{ path: "effects.clip-box", value: box }]);
    send({ kind: "clip", box });
  });
  const box = element("details", { class: "splatvol-clip" }, element("summary", {}, "Clip"));
  rows.forEach(([from, to], i) => {
    // The two sides do not pass each other, and leave a little between them.
    from.addEventListener("input", () => (from.value = Math.min(from.value, to.value - 10), changed()));
    to.addEventListener("input", () => (to.value = Math.max(to.value, +from.value + 10), changed()));
    box.append(element("div", {}, element("span", {}, axes[i]), from, to));
  });
  return box;
}

/** Menus, editor and sliders, of a state that the kernel sent. */
function controls(state, chosen, { send, inPage }, again) {
  const panel = [];
  const look = state.items[chosen]?.look;
  if (state.items.length > 1) {
    const names = state.items.map((item, i) => [i, item.name]);
    panel.push(menu("Item", names, chosen, (value) => again(+value)));
  }
  const row = element("div", { class: "splatvol-row" });
  row.append(menu("Show", state.kinds, state.compositing, (value) => send({ kind: "compositing", value })));
  if (look) {
    const sendLook = paced((edited) => send({ kind: "look", item: chosen, look: edited }));
    const changed = (edited) => {
      inPage.tell([{ path: `item[${chosen}].transfer-function`, value: edited }]);
      sendLook(edited);
    };
    const maps = [["", "as chosen"], ...state.maps.map((name) => [name, name])];
    row.append(menu("Colours", maps, state.items[chosen].map, (name) => name && send({ kind: "cmap", item: chosen, name })));
    panel.push(new Editor(state.items[chosen], changed).svg);
  }
  const reset = element("button", { type: "button", title: "The look that was chosen at first" }, "Reset look");
  reset.addEventListener("click", () => send({ kind: "reset" }));
  row.append(reset);
  panel.push(row, clipBox(state, send, inPage));
  return panel;
}

/** The output with the still that a notebook keeps beside the widget: it is hidden while the widget lives. */
function stillOutput(el, tail) {
  const cell = el.closest(".jp-OutputArea, .output, .cell_container, .jp-Cell") ?? document;
  const image = [...cell.querySelectorAll("img")].find((img) => tail && img.src.trimEnd().endsWith(tail));
  return image?.closest(".jp-OutputArea-child, .output_area, .output_container") ?? image;
}

function render({ model, el }) {
  const view = Math.random().toString(36).slice(2);
  const send = (message) => model.send({ ...message, view });
  const picture = new Picture(send);
  const panel = element("div", { class: "splatvol-panel" });
  const problem = element("div", { role: "alert", class: "splatvol-error", hidden: "" });
  el.classList.add("splatvol-widget");
  el.append(picture.canvas, panel, problem);
  let still = null;
  let chosen = 0;
  let isClipOpen = false;

  function build(state) {
    const again = (item) => ((chosen = item), build(state));
    isClipOpen = panel.querySelector("details")?.open ?? isClipOpen;
    panel.replaceChildren(...controls(state, Math.min(chosen, state.items.length - 1), picture, again));
    panel.querySelector("details").open = isClipOpen;
  }

  const hear = {
    state(state) {
      picture.size(state.size);
      picture.place(state.camera);
      picture.inPage.follow(state.edits);
      build(state);
      still = stillOutput(el, state.still) ?? still;
      if (still) still.style.display = "none";
    },
    camera(message) {
      if (message.view !== view) picture.place(message.camera);
    },
    async frame(message, buffers) {
      try {
        await picture.draw(message, buffers[0]);
        problem.hidden = true;
      } finally {
        // A picture that cannot be drawn is done with, too.
        send({ kind: "shown", number: message.number });
      }
    },
    browser(message, buffers) {
      if (message.end) picture.inPage.end();
      else if (message.view === view) picture.inPage.take(message, buffers);
    },
    error(message) {
      problem.textContent = message.text;
      problem.hidden = false;
    },
  };
  const listen = (message, buffers) => hear[message.kind]?.(message, buffers);
  model.on("msg:custom", listen);
  send({ kind: "ready", engines: [...ENGINES.keys()] });
  return () => {
    model.off("msg:custom", listen);
    picture.inPage.end();
    send({ kind: "gone" });
    if (still) still.style.display = "";
  };
}

export default { render };
