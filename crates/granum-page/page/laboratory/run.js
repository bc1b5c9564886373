// @ts-check
// A run as the page sees it: a worker, and what it has told so far.

/** @typedef {{ name: string, unit: string }} Column */
/** @typedef {{ message: string, places: import("./engine.mjs").Place[] }} Fault */

export class Run {
  /**
   * @param {WebAssembly.Module} module
   * @param {string} text the case
   * @param {string} name
   * @param {() => void} changed is called when there is something new
   */
  constructor(module, text, name, changed) {
    this.name = name;
    this.text = text;
    this.changed = changed;
    /** @type {Column[]} */
    this.columns = [];
    /** Numbers; what is not known is null, what is infinite a word. @type {(number | "inf" | "-inf" | null)[][]} */
    this.rows = [];
    /** @type {any} */
    this.answer = null;
    /** @type {any} */
    this.view = null;
    /** @type {string | null} */
    this.digest = null;
    /** @type {Fault | null} */
    this.fault = null;
    this.begun = false;
    this.goes = false;
    this.asked = 0;
    /** @type {Map<number, (answer: any) => void>} */
    this.waiting = new Map();
    this.worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.worker.addEventListener("message", event => this.hear(event.data));
    this.worker.addEventListener("error", event => this.hear({ kind: "failed", message: event.message || "the worker has stopped", places: [] }));
    this.worker.postMessage({ kind: "begin", module, case: text });
  }

  /** @param {any} told */
  hear(told) {
    if (told.kind === "begun") { this.begun = true; this.view = told.view; this.warnings = told.warnings; }
    if (told.kind === "failed") { this.fault = told; this.goes = false; }
    if (told.kind === "piece") {
      this.answer = told.answer;
      if (told.found) { this.columns = told.found.columns; this.rows.push(...told.found.rows); }
      if (told.view) this.view = told.view;
      if (told.digest) { this.digest = told.digest; this.goes = false; }
    }
    if (told.of !== undefined) { this.waiting.get(told.of)?.(told); this.waiting.delete(told.of); }
    this.changed();
  }

  /** @param {"go" | "pause" | "piece"} kind */
  tell(kind) {
    this.goes = kind === "go";
    this.worker.postMessage({ kind });
  }

  /**
   * Asks for a `result`, the `series`, or the run as it is `saved`.
   * @param {"result" | "series" | "saved"} kind
   * @param {Record<string, unknown>} [more]
   * @returns {Promise<any>}
   */
  ask(kind, more = {}) {
    const of = ++this.asked;
    return new Promise(done => { this.waiting.set(of, done); this.worker.postMessage({ kind, of, ...more }); });
  }

  /** True when nothing more is to come. */
  get ended() {
    return this.digest !== null || this.fault !== null;
  }

  /**
   * The points of one column over another.
   * @param {string} x
   * @param {string} y
   * @returns {[number, number][]}
   */
  points(x, y) {
    const at = (/** @type {string} */ name) => this.columns.findIndex(column => column.name === name);
    const [a, b] = [at(x), at(y)];
    if (a < 0 || b < 0) return [];
    const points = this.rows.map(row => [row[a], row[b]]);
    return /** @type {[number, number][]} */ (points.filter(point => point.every(Number.isFinite)));
  }

  /** Ends the worker. */
  stop() {
    this.worker.terminate();
  }
}
