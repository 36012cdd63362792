// Frames: drafts while something changes, then finer passes, then the final picture, tile by tile. A server, where the page comes
// from one, makes the final picture, and all of them where the page has no instances of its own. A faster member, where there is one
// (`webgpu.js`), makes the drafts, in the picture's own resolution if it can.
//
// A picture is divided among the members of the pool by shares. Nothing can stop an instance, so the final picture is asked for
// in more shares than there are members, each of which takes about PIECE, and no more of them once something changes.

/** Pixels of the final picture per pixel of a draft and axis. */
const STEPS = [1, Math.SQRT2, 2, 2 * Math.SQRT2, 4, 4 * Math.SQRT2];
/** Longest and shortest time of a draft that is as fine as it should be, milliseconds. */
const DRAFT = [18, 45];
/** Longest time of a share, milliseconds. */
const PIECE = 90;
/** Most shares of a picture for each member. */
const MOST_PIECES = 8;
/** Time without a change after which finer passes begin, milliseconds. */
const REST = 80;

/** Step of the finest drafts, unless a faster member makes them. */
const FINEST = 2;

/** One picture, in shares. `done` gets each tile, `ended` is told when all are there. */
class Job {
  constructor(size, { step, isFinal }, crew, pieces) {
    Object.assign(this, { size, step, isFinal, crew, count: crew.length * pieces, next: 0, open: 0, given: 0, started: performance.now() });
  }
}

class Frames {
  /** `view` tells the size of the picture, the camera's keys for it, and the edits to be made before the next one. */
  constructor(canvas, pool, view) {
    const { members, server } = pool;
    Object.assign(this, { canvas, view, server });
    this.drafters = members.length > 0 ? members : [server];
    this.finishers = server ? [server] : this.drafters;
    this.members = [...new Set([...this.drafters, ...this.finishers])];
    this.idle = [...this.members];
    this.context = canvas.getContext("2d", { alpha: true });
    this.draft = document.createElement("canvas");
    this.step = FINEST + 1;
    this.finest = FINEST;
    this.fast = null;
    this.changes = 0;
    this.shown = -1;
    this.job = null;
    this.timer = 0;
    this.held = false;
    this.isOver = false;
    // What each member is still told, why it did not hear some of it, and the last picture that failed: its changes, the member, why.
    this.telling = new Map();
    this.unheard = new Map();
    this.failure = null;
    // Milliseconds per pixel of the last final picture, one member working.
    this.cost = 0;
    this.listeners = [];
  }

  /** Something has changed: a draft as soon as the instances are free, then finer passes. */
  changed() {
    this.changes += 1;
    clearTimeout(this.timer);
    // A picture on the server is stopped; it is none of the drafts that have to be seen.
    if (this.server && this.job && this.job.isFinal) this.server.stop();
    this.pump();
  }

  /** A faster member makes the drafts from now on; final pictures are still those of the others. */
  quickened(member) {
    Object.assign(this, { fast: member, slow: this.drafters, drafters: [member], finest: 0, step: 0 });
    this.members.push(member);
    this.idle.push(member);
  }

  /** The faster member has failed, or may be slower after all: the others make the drafts again. */
  slowed() {
    const { fast } = this;
    Object.assign(this, { fast: null, drafters: this.slow, finest: FINEST, step: FINEST + 1 });
    this.members = this.members.filter((member) => member !== fast);
    this.idle = this.idle.filter((member) => member !== fast);
    fast.end();
    if (this.job && this.job.crew.includes(fast)) this.job = null;
    if (!this.final) this.changed();
  }

  /** Waits for the final picture of what is shown, or says why there is none. */
  settled() {
    return new Promise((resolve, reject) => {
      this.listeners.push({ resolve, reject });
      if (this.hasFailed()) this.toldOf(this.failure.error);
      else if (!this.job && this.shown === this.changes && this.final) this.told();
    });
  }

  /** Whether there is no picture of what should be shown now, until something changes. */
  hasFailed() {
    return this.failure !== null && this.failure.changes === this.changes;
  }

  /** A finished picture of what is shown now was made by somebody else, and is on the canvas. */
  replaced() {
    clearTimeout(this.timer);
    this.job = null;
    this.shown = this.changes;
    this.final = true;
    this.failure = null;
    this.told();
  }

  /** Ends all members: others show something else. */
  end() {
    clearTimeout(this.timer);
    Object.assign(this, { held: true, isOver: true, job: null });
    this.members.forEach((member) => member.end());
  }

  told() {
    this.listeners.splice(0).forEach(({ resolve }) => resolve());
  }

  toldOf(error) {
    this.listeners.splice(0).forEach(({ reject }) => reject(error));
  }

  /** Starts a draft if one is due, and all that draw it are free. */
  pump() {
    if (this.held || this.shown === this.changes || this.hasFailed()) return;
    if (this.drafters.some((member) => !this.idle.includes(member))) return;
    this.begin(this.step, false);
  }

  /** Starts a picture. */
  begin(step, isFinal) {
    const full = this.view.size();
    const size = full.map((side) => Math.max(1, Math.round(side / STEPS[step])));
    const crew = isFinal ? this.finishers : this.drafters;
    const predicted = (this.cost * size[0] * size[1]) / crew.length;
    const pieces = isFinal ? Math.min(MOST_PIECES, Math.max(2, Math.ceil(predicted / PIECE))) : 1;
    const job = new Job(size, { step, isFinal }, crew, pieces);
    job.changes = this.changes;
    job.camera = this.view.camera(size);
    if (isFinal) this.fit(full, true);
    else Object.assign(this.draft, { width: size[0], height: size[1] });
    job.context = isFinal ? this.context : this.draft.getContext("2d");
    this.final = false;
    this.job = job;
    this.tell();
    crew.filter((member) => this.idle.includes(member)).forEach((member) => this.give(member));
  }

  /** The canvas in its size; what it shows is kept, enlarged. */
  fit([width, height], keep) {
    const { canvas } = this;
    if (canvas.width === width && canvas.height === height) return;
    let old = null;
    if (keep && canvas.width > 0) {
      old = document.createElement("canvas");
      Object.assign(old, { width: canvas.width, height: canvas.height });
      old.getContext("2d").drawImage(canvas, 0, 0);
    }
    Object.assign(canvas, { width, height });
    if (old) this.context.drawImage(old, 0, 0, width, height);
  }

  /** Tells all members of what was changed. */
  tell() {
    const edits = this.view.takeEdits();
    if (edits.length > 0) this.unheard.clear();
    for (const edit of edits) this.members.forEach((member) => this.edit(member, edit));
  }

  /** Tells a member of a change. What it does not hear is told again, with the next picture; until then it makes none. */
  edit(member, edit) {
    const told = member.ask(edit).then(({ header }) => {
      if (header.error) this.view.trouble(header.error);
      else if (member === this.members[0]) this.view.edited(header);
    }).catch((error) => {
      this.unheard.set(member, error);
      this.view.trouble(error.message || String(error));
      if (this.view.untold) this.view.untold();
    });
    this.telling.set(member, Promise.all([this.telling.get(member), told]));
  }

  /** Asks a member, which has heard of all changes, for a share of a picture. */
  async rendered(member, asked) {
    const answer = await member.ask({ do: "render", ...asked });
    await this.telling.get(member);
    const missed = this.unheard.get(member);
    this.unheard.delete(member);
    if (missed) throw missed;
    if (answer.header.error) throw new Error(answer.header.error);
    return answer;
  }

  /** Gives an instance the next share of the picture. */
  async give(member) {
    const { job } = this;
    const isDue = job && job.crew.includes(member) && job.next < job.count;
    if (!isDue || (job.isFinal && job.changes !== this.changes)) return this.pump();
    const share = [job.next, job.count];
    job.next += 1;
    job.open += 1;
    this.idle = this.idle.filter((other) => other !== member);
    try {
      const { header, bytes, milliseconds } = await this.rendered(member, { size: job.size, camera: job.camera, share });
      job.given += milliseconds;
      // What is finished although something has changed is no part of the next picture.
      if (job === this.job) this.draw(job, header.tiles, bytes);
    } catch (error) {
      if (member === this.fast) {
        console.warn(`splatvol: no WebGPU: ${error.message || error}`);
        return this.slowed();
      }
      // What is incomplete is never shown.
      if (job === this.job) this.job = null;
      if (error.name !== "AbortError") this.failed(job, member, error);
    }
    job.open -= 1;
    if (!this.members.includes(member)) return null;
    this.idle.push(member);
    if (job === this.job && job.next >= job.count && job.open === 0) this.ended(job);
    return this.give(member);
  }

  /** A picture has failed: what is on the canvas stays until something is changed. */
  failed(job, member, error) {
    this.failure = { changes: job.changes, member, error };
    this.view.trouble(error.message || String(error));
    if (!this.hasFailed()) return;
    this.final = false;
    if (this.view.failed) this.view.failed(job);
    this.toldOf(error);
  }

  draw(job, tiles, bytes) {
    let start = 0;
    for (const [x0, y0, x1, y1] of tiles) {
      const length = 4 * (x1 - x0) * (y1 - y0);
      const pixels = new Uint8ClampedArray(bytes.buffer, bytes.byteOffset + start, length);
      job.context.putImageData(new ImageData(pixels, x1 - x0, y1 - y0), x0, y0);
      start += length;
    }
  }

  /** A picture is complete: shows it, and goes on with a finer one. */
  ended(job) {
    const took = performance.now() - job.started;
    this.job = null;
    if (this.failure && job.crew.includes(this.failure.member)) {
      this.failure = null;
      this.view.trouble("");
    }
    if (!job.isFinal) {
      this.fit(this.view.size(), true);
      const { width, height } = this.canvas;
      this.context.imageSmoothingQuality = "high";
      this.context.clearRect(0, 0, width, height);
      this.context.drawImage(this.draft, 0, 0, width, height);
    }
    this.canvas.hidden = false;
    this.view.seen();
    if (!job.crew.includes(this.fast)) this.cost = job.given / (job.size[0] * job.size[1]);
    if (!job.isFinal) this.adapt(job, took);
    if (job.changes !== this.changes) return;
    this.shown = job.changes;
    this.final = job.isFinal;
    this.view.progress(job, took);
    if (this.final) {
      this.told();
      return;
    }
    const finer = job.step > this.finest ? [this.finest, false] : [0, true];
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.shown === this.changes && !this.job && !this.held) this.begin(...finer);
    }, job.step === this.step ? REST : 0);
  }

  /** Drafts become coarser where they take long, and finer where they do not. */
  adapt(job, took) {
    if (job.step !== this.step) return;
    if (took > DRAFT[1] && this.step < STEPS.length - 1) this.step += 1;
    if (took < DRAFT[0] && this.step > this.finest) this.step -= 1;
  }

  /** A whole picture of a size, RGBA, by all that make final ones, or by others, whatever the page shows. */
  async picture(size, crew = this.finishers) {
    while (this.held) await new Promise((resolve) => setTimeout(resolve, 20));
    this.held = true;
    try {
      while (this.idle.length < this.members.length) await new Promise((resolve) => setTimeout(resolve, 5));
      this.tell();
      const pixels = new Uint8ClampedArray(4 * size[0] * size[1]);
      const camera = this.view.camera(size);
      const count = crew.length;
      await Promise.all(crew.map(async (member, index) => {
        const { header, bytes } = await this.rendered(member, { size, camera, share: [index, count] });
        let start = 0;
        for (const [x0, y0, x1, y1] of header.tiles) {
          for (let y = y0; y < y1; y += 1) {
            const row = bytes.subarray(start, start + 4 * (x1 - x0));
            pixels.set(row, 4 * (y * size[0] + x0));
            start += row.length;
          }
        }
      }));
      return new ImageData(pixels, size[0], size[1]);
    } finally {
      this.held = false;
      if (this.final) this.pump();
      else this.changed();
    }
  }
}
