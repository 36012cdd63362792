// The panel: look, clip, views, and what the keys do. Plain controls with labels, made of elements, never of text.

/** An element with attributes and children. */
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made && key !== "list") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** A number for people, with about four digits. */
function spoken(value) {
  return Number(value.toPrecision(4)).toLocaleString("en", { maximumSignificantDigits: 4, useGrouping: false });
}

let rows = 0;

/** A row with a label, a control, and its value. */
function row(label, control, output) {
  rows += 1;
  control.id = `control-${rows}`;
  const made = element("div", { className: "row" }, element("label", { htmlFor: control.id }, label), control);
  if (output) made.append(output);
  return made;
}

/** A slider; `said` tells its value for people, `set` is told while it moves, `end` when it has. */
function slider(label, [least, most, value], said, set, end) {
  const output = element("output");
  const control = element("input", { type: "range", min: least, max: most, step: "any", value });
  control.value = value;
  const tell = () => {
    output.textContent = said(Number(control.value));
    control.setAttribute("aria-valuetext", output.textContent);
  };
  control.addEventListener("input", () => {
    tell();
    set(Number(control.value));
  });
  // Steps by keys are a fiftieth, whatever the range.
  control.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -5, PageUp: 5 }[event.key];
    if (!way || event.ctrlKey || event.altKey) return;
    event.preventDefault();
    control.value = Number(control.value) + (way * (most - least)) / 50;
    control.dispatchEvent(new Event("input"));
    control.dispatchEvent(new Event("change"));
  });
  control.addEventListener("change", end);
  tell();
  const put = (next) => {
    control.value = next;
    tell();
  };
  return { made: row(label, control, output), put };
}

function choice(label, names, value, set) {
  const control = element("select", {}, ...names.map(([name, text]) => element("option", { value: name }, text)));
  control.value = value;
  control.addEventListener("change", () => set(control.value));
  return { made: row(label, control), put: (next) => { control.value = next; } };
}

function checkbox(label, value, set) {
  const control = element("input", { type: "checkbox", checked: value });
  control.addEventListener("change", () => {
    // What may not be changed stays.
    if (!set(control.checked)) control.checked = !control.checked;
  });
  rows += 1;
  control.id = `control-${rows}`;
  const made = element("div", { className: "check" }, control, element("label", { htmlFor: control.id }, label));
  return { made, put: (next) => { control.checked = next; } };
}

function button(text, act, attributes = {}) {
  const made = element("button", { type: "button", ...attributes }, text);
  made.addEventListener("click", act);
  return made;
}

/** What the keys do, which is also what is said about them. */
const KEYS = [
  ["Drag, arrow keys", "turn"],
  ["Ctrl+drag, Shift+← →", "roll"],
  ["Shift+drag, Alt+arrows", "shift"],
  ["Wheel, pinch, + −", "nearer, farther"],
  ["Home", "as it was"],
  ["1 2, 3 4, 7 8, 9", "front, back, right, left, top, bottom, oblique"],
  ["[ ]", "less, more opaque"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo (items, look and cut)"],
  ["P", "save the picture"],
];

/** The curve of opacities over a histogram. */
function drawCurve(canvas, facts, look) {
  const context = canvas.getContext("2d");
  const [width, height] = [canvas.width, canvas.height];
  const [low, high] = facts.span;
  const at = (value) => ((value - low) / (high - low)) * width;
  context.clearRect(0, 0, width, height);
  const most = Math.log1p(Math.max(...facts.histogram));
  const [least, largest] = facts.extremes;
  const bin = (largest - least) / facts.histogram.length;
  context.fillStyle = "#596273";
  facts.histogram.forEach((count, i) => {
    const [x0, x1] = [at(least + i * bin), at(least + (i + 1) * bin)];
    const tall = (Math.log1p(count) / most) * height;
    context.fillRect(x0, height - tall, Math.max(1, x1 - x0), tall);
  });
  context.strokeStyle = "#ffd166";
  context.lineWidth = 2;
  context.beginPath();
  const points = look.opacities.map((point) => [at(point.value), (1 - point.opacity) * (height - 4) + 2]);
  if (points.length > 0) {
    context.moveTo(0, points[0][1]);
    points.forEach(([x, y]) => context.lineTo(x, y));
    context.lineTo(width, points[points.length - 1][1]);
  }
  context.stroke();
  const colors = look.colors.map((point) => [at(point.value), point.rgb.map((c) => Math.round(255 * c)).join()]);
  const stripe = context.createLinearGradient(0, 0, width, 0);
  for (const [x, rgb] of colors) stripe.addColorStop(Math.min(1, Math.max(0, x / width)), `rgb(${rgb})`);
  context.fillStyle = stripe;
  context.fillRect(0, height - 8, width, 8);
}

/** The panel for a view: `view` has the state and is told of its changes. */
function buildPanel(view) {
  const panel = document.getElementById("controls");
  const parts = [];
  const views = [["Front", "front"], ["Back", "back"], ["Left", "left"], ["Right", "right"], ["Top", "top"], ["Bottom", "bottom"], ["Oblique", "iso"]];
  panel.append(element("h2", {}, "View"), element("div", { className: "buttons" },
    ...views.map(([text, name]) => button(text, () => view.look(name))),
    button("As it was", () => view.home())));
  if (view.facts.items.length > 1) {
    panel.append(element("h2", {}, "Items"));
    view.facts.items.forEach(({ name }, index) => {
      const shows = (visible) => view.setItem(index, "visible", visible) && (view.remember(), true);
      const shown = checkbox(name, true, shows);
      panel.append(shown.made);
      parts.push((now) => shown.put(now.items[index].visible));
    });
  }
  const curves = [];
  if (!view.hasCurves) panel.append(element("p", {}, "The look is one of values and gradients: it cannot be changed here."));
  (view.hasCurves ? view.valued : []).forEach((facts, order) => {
    const { index } = facts;
    panel.append(element("h2", {}, view.facts.items.length > 1 ? `Look of ${view.facts.items[index].name}` : "Look"));
    const curve = element("canvas", { id: order === 0 ? "curve" : `curve-${order}`, width: 288, height: 80, role: "img" });
    curve.setAttribute("aria-label", "Histogram of the values, with the curve of opacities");
    const state = () => view.state.looks[index];
    const set = (key) => (value) => view.setLook(index, key, value);
    const end = () => view.remember();
    const [low, high] = facts.span;
    const bound = (which) => (value) => {
      const range = [...(state().range || facts.range)];
      range[which] = value;
      // The ends cannot pass each other.
      range[1 - which] = which === 0 ? Math.max(range[1], value) : Math.min(range[0], value);
      view.setLook(index, "range", range);
    };
    const lower = slider("From", [low, high, facts.range[0]], spoken, bound(0), end);
    const upper = slider("To", [low, high, facts.range[1]], spoken, bound(1), end);
    const strength = slider("Opacity", [-4, 4, 0], (value) => `× ${spoken(2 ** value)}`,
      (value) => view.setLook(index, "strength", Math.abs(value) < 0.02 ? null : 2 ** value), end);
    const own = [["", "as it was"]];
    const maps = choice("Colours", [...own, ...view.facts["color-maps"].map((name) => [name, name])], "",
      (name) => { set("cmap")(name || null); end(); });
    const shapes = choice("Curve", [...own, ...view.facts["opacity-curves"].map((name) => [name, name])], "",
      (name) => { set("opacity")(name || null); end(); });
    panel.append(curve, ...[lower, upper, strength, maps, shapes].map(({ made }) => made));
    curves.push((looks) => drawCurve(curve, facts, looks[index]));
    parts.push((now) => {
      const look = now.looks[index];
      const range = look.range || facts.range;
      lower.put(range[0]);
      upper.put(range[1]);
      strength.put(look.strength ? Math.log2(look.strength) : 0);
      maps.put(look.cmap || "");
      shapes.put(look.opacity || "");
    });
  });
  view.facts.items.forEach(({ name, opacity }, index) => {
    if (opacity === null) return;
    panel.append(element("h2", {}, view.facts.items.length > 1 ? `Look of ${name}` : "Look"));
    const strength = slider("Opacity", [0, 1, opacity], spoken, (value) => view.setItem(index, "opacity", value), () => view.remember());
    panel.append(strength.made);
    parts.push((now) => strength.put(now.items[index].opacity));
  });
  panel.append(element("h2", {}, "Cut"));
  const { min, max } = view.facts.bounds;
  const unitOf = view.facts.items.map(({ unit }) => unit).find((unit) => unit) || "";
  ["x", "y", "z"].forEach((axis, i) => {
    const said = (value) => `${spoken(value)} ${unitOf}`.trim();
    ["from", "to"].forEach((which, end) => {
      const ends = [min[i], max[i], view.state.box[2 * i + end]];
      const made = slider(`${axis} ${which}`, ends, said, (value) => view.setBox(2 * i + end, value), () => view.remember());
      panel.append(made.made);
      parts.push((now) => made.put(now.box[2 * i + end]));
    });
  });
  const undo = button("Undo", () => view.step(-1));
  const redo = button("Redo", () => view.step(1));
  panel.append(element("h2", {}, "Changes"), element("div", { className: "buttons" }, undo, redo,
    button("All as it was", () => view.reset()), button("Save picture", () => view.save())));
  const keys = [...KEYS, ...(hasReaders() ? [["O, drop", "open files in place of these"]] : [])].flatMap(([key, does]) => [element("dt", {}, key), element("dd", {}, does)]);
  panel.append(element("details", {}, element("summary", {}, "Mouse, fingers and keys"), element("dl", { id: "keys" }, ...keys)),
    element("details", {}, element("summary", {}, "About this page"),
      element("ul", {}, ...view.facts.about.map((text) => element("li", {}, text)))));
  panel.hidden = false;
  return {
    /** Shows a state that was not made by the controls themselves. */
    put: (now) => parts.forEach((part) => part(now)),
    /** Shows the transfer functions. */
    curves: (looks) => curves.forEach((draw) => draw(looks)),
    /** Whether there is something to undo and to redo. */
    steps: (back, forth) => Object.assign(undo, { disabled: !back }) && Object.assign(redo, { disabled: !forth }),
  };
}
