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

/** Reads files, each with its path; says what share of their bytes has been read. */
async function readFiles(files, told) {
  readers = readers || startReaders();
  const member = await readers;
  member.progress = told;
  const header = { files: files.map(({ path, file }) => ({ path, length: file.size })) };
  const { header: read, bytes } = await member.ask(header, files.map(({ file }) => file));
  if (read.error) throw new Error(read.error);
  return { read, bytes };
}

/** The files of what was dropped, folders with all that is in them. */
async function dropped(transfer) {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
  const files = [];
  const collect = async (entry) => {
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
      for (const inside of some) await collect(inside);
    }
  };
  for (const entry of entries) await collect(entry);
  return files;
}

/** Opens files in place of what is shown; says why not where they cannot be read, and leaves what is shown. */
async function openFiles(shown, files) {
  if (files.length === 0) return;
  const name = files.length === 1 ? files[0].file.name : `${files.length} files`;
  const status = (text) => { $("status").textContent = text; };
  const before = $("status").textContent;
  trouble("");
  status(`Reading ${name}.`);
  try {
    const { read, bytes } = await readFiles(files, (share) => status(`Reading ${name}: ${Math.round(100 * share)} %.`));
    status("Preparing the picture.");
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
    status(before);
    trouble(error.message || String(error));
  }
}

/** Hears of files: buttons in the panel, and what is dropped on the page. */
function hearFiles(shown) {
  const chooser = (attributes) => {
    const input = element("input", { type: "file", hidden: true, multiple: true, ...attributes });
    input.addEventListener("change", () => {
      const files = [...input.files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
      input.value = "";
      shown.open(() => files);
    });
    return input;
  };
  const [files, folder] = [chooser({ id: "files" }), chooser({ webkitdirectory: true })];
  $("open").append(files, folder,
    button("Open files…", () => files.click()), button("Open folder…", () => folder.click()));
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
    shown.open(() => list);
  });
  document.addEventListener("keydown", (event) => {
    const isO = event.key.toLowerCase() === "o" && !event.ctrlKey && !event.metaKey && !event.altKey;
    if (isO && !event.target.closest("input, select")) files.click();
  });
}
