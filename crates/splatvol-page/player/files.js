// Files of the reader's own: those that are dropped on the page or chosen are read here, in a worker, and take the place of what is
// shown. Nothing is sent anywhere. Pages have this where they were made with the readers of files.

/** What the worker does: `make` makes an instance of the readers, a new one for each message, so that none is left broken. */
function workOnFiles(make) {
  /** Milliseconds between two words about the progress. */
  const PAUSE = 100;
  let module = null;
  const read = async (header, files) => {
    const whole = files.reduce((sum, { size }) => sum + size, 0);
    const reader = new FileReaderSync();
    let [done, last] = [0, performance.now()];
    const fill = (file, position, address, length) => {
      try {
        const bytes = new Uint8Array(reader.readAsArrayBuffer(files[file].slice(position, position + length)));
        if (bytes.length !== length) return 0;
        own.memory().set(bytes, address >>> 0);
        done += length;
        if (performance.now() - last > PAUSE) {
          last = performance.now();
          postMessage({ progress: Math.min(1, done / whole) });
        }
        return 1;
      } catch (_unreadable) {
        return 0;
      }
    };
    const own = make("splatvol_read", { page: { read_file: fill } });
    await own.start(module);
    return own.ask(header);
  };
  onmessage = async ({ data }) => {
    try {
      if (data.module) {
        module = data.module;
        postMessage({ ready: true });
      } else {
        const { header, bytes } = await read(data.header, data.bytes);
        postMessage({ header, bytes }, [bytes.buffer]);
      }
    } catch (error) {
      postMessage({ failed: String(error.message || error) });
    }
  };
}

function hasReaders() {
  return $("readers").textContent !== "" || readers !== null;
}

/** The worker that reads files: started once. */
let readers = null;

async function startReaders() {
  const module = await WebAssembly.compile(await unpacked(bytesOf("readers")));
  const source = `"use strict";\n${instance}\n(${workOnFiles})(instance);\n`;
  return inBlob(source, (url) => inWorker(module, url));
}

/** Reads files, each with its path, in a way that keys say; says what share of their bytes has been read. */
async function readFiles(files, keys, told) {
  readers = readers || startReaders();
  const member = await readers;
  member.progress = told;
  const header = { files: files.map(({ path, file }) => ({ path, length: file.size })), keys };
  const { header: read, bytes } = await member.ask(header, files.map(({ file }) => file));
  if (read.error) throw new Error(read.error);
  return { read, bytes };
}

/** The files of what was dropped, folders with all that is in them. Of pages from disk Chromium reads folders by handles only. */
async function dropped(transfer) {
  // All has to be asked for before the first wait.
  const items = [...transfer.items].filter((item) => item.kind === "file").map((item) => ({
    file: item.getAsFile(),
    entry: item.webkitGetAsEntry && item.webkitGetAsEntry(),
    handle: item.getAsFileSystemHandle && item.getAsFileSystemHandle(),
  }));
  const files = [];
  for (const { file, entry, handle } of items) {
    if (!entry || entry.isFile) files.push({ path: file.name, file });
    else if (handle) await collectHandle(await handle, "", files);
    else await collectEntry(entry, files);
  }
  return files;
}

async function collectHandle(handle, folder, files) {
  const path = `${folder}${handle.name}`;
  if (handle.kind === "file") {
    files.push({ path, file: await handle.getFile() });
    return;
  }
  for await (const inside of handle.values()) await collectHandle(inside, `${path}/`, files);
}

async function collectEntry(entry, files) {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
    files.push({ path: entry.fullPath.replace(/^\/+/, ""), file });
    return;
  }
  const reader = entry.createReader();
  // It gives some of them at a time.
  for (;;) {
    const some = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return;
    for (const inside of some) await collectEntry(inside, files);
  }
}

/** What files may leave open: a key of items, its label, an example, and what is made of the text. */
const READING = [
  ["component", "Component", "0", Number],
  ["array", "Array", "name", String],
  ["channel", "Channel", "0", Number],
  ["time", "Time point", "0", Number],
  ["level", "Level", "0", Number],
  ["series", "Series", "number", String],
  ["dims", "Raw: size", "256x256x128", numbers],
  ["type", "Raw: type", "u8, i16, f32", String],
  ["spacing", "Raw: spacing", "1, 1, 2.5", numbers],
  ["endian", "Raw: order", "little, big", String],
  ["offset", "Raw: offset", "0", Number],
];

function numbers(text) {
  return text.split(/[x×,\s]+/).filter(Boolean).map(Number);
}

/** Fields for what files leave open; `again` reads the files once more. */
function readingFields(again) {
  const fields = READING.map(([key, label, placeholder, parse]) => {
    const control = element("input", { type: "text", placeholder, autocomplete: "off", spellcheck: false });
    return { key, label, control, parse, made: row(label, control) };
  });
  const form = element("form", {}, ...fields.map(({ made }) => made), element("div", { className: "buttons" }, button("Read again", again)));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    again();
  });
  const details = element("details", {}, element("summary", {}, "How files are read"),
    element("p", {}, "Where a file leaves something open, or has more than one picture needs."), form);
  return {
    details,
    /** The keys of fields that are filled. */
    keys: () => Object.fromEntries(fields.flatMap(({ key, label, control, parse }) => {
      const text = control.value.trim();
      if (text === "") return [];
      const value = parse(text);
      if ([value].flat().some(Number.isNaN)) throw new Error(`${label}: ${text}: expected a number`);
      return [[key, value]];
    })),
  };
}

/** Errors of what can be said in the fields. */
const OPEN = /component|array|channel|series|layout|dims|type/i;

/** Opens files in place of what is shown; says why not where they cannot be read, and leaves what is shown. */
async function openFiles(shown, files) {
  if (files.length === 0) return;
  const name = files.length === 1 ? files[0].file.name : `${files.length} files`;
  const before = $("status").textContent;
  trouble("");
  say(`Reading ${name}.`);
  try {
    const { read, bytes } = await readFiles(files, shown.reading.keys(), (share) => say(`Reading ${name}: ${Math.round(100 * share)} %.`));
    say("Preparing the picture.");
    const { items, warnings } = read;
    const message = {
      document: { item: items.map((item) => ({ file: item.name })) },
      data: items.map(({ data }) => data),
      described: items.map(({ described }) => described),
    };
    const opened = await openData(shown.pool.module, message, bytes);
    const title = items.map((item) => item.name).join(", ");
    const kept = items.map((item) => `${item.name}: ${item.size}, as in its file (${item.described.format}).`);
    shown.show(opened, title, [...kept, ...warnings, "The files were read in this page: nothing was sent anywhere."]);
  } catch (error) {
    say(before);
    if (OPEN.test(error.message)) shown.reading.details.open = true;
    trouble(error.message || String(error));
  }
}

/** Hears of files: buttons in the panel, and what is dropped on the page. */
function hearFiles(shown) {
  let last = [];
  const open = (files) => shown.open(async () => {
    last = await files;
    return last;
  });
  shown.reading = readingFields(() => open(last));
  const chooser = (attributes) => {
    const input = element("input", { type: "file", hidden: true, multiple: true, ...attributes });
    input.addEventListener("change", () => {
      const files = [...input.files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
      input.value = "";
      open(files);
    });
    return input;
  };
  const [files, folder] = [chooser({ id: "files" }), chooser({ webkitdirectory: true })];
  $("open").append(files, folder,
    button("Open files…", () => files.click()), button("Open folder…", () => folder.click()), shown.reading.details);
  $("open").hidden = false;
  const isFiles = (event) => [...event.dataTransfer.types].includes("Files");
  const mark = (event, on) => {
    if (!isFiles(event)) return;
    event.preventDefault();
    document.body.classList.toggle("dropping", on);
  };
  document.addEventListener("dragover", (event) => mark(event, true));
  document.addEventListener("dragleave", (event) => mark(event, false));
  document.addEventListener("drop", (event) => {
    mark(event, false);
    // What is dropped is known only now.
    const list = dropped(event.dataTransfer);
    open(list);
  });
  document.addEventListener("keydown", (event) => {
    const isO = event.key.toLowerCase() === "o" && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (isO && !event.target.closest("input, select")) files.click();
  });
}
