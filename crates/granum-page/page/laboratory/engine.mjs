// @ts-check
// The module of WebAssembly: which of the two a browser gets, and how it is called.

/** A module that adds a product in one instruction of relaxed SIMD, and says whether the browser rounds it once. */
function probe() {
  const body = [
    0x00, // no locals
    0x20, 0x00, 0xfd, 0x14, 0x20, 0x00, 0xfd, 0x14, // x, x in both lanes
    0x20, 0x00, 0x20, 0x00, 0xa2, 0x9a, 0xfd, 0x14, // -(x x)
    0xfd, 0x87, 0x02, // f64x2.relaxed_madd
    0xfd, 0x21, 0x00, 0x44, 0, 0, 0, 0, 0, 0, 0, 0, 0x62, 0x0b, // is not zero
  ];
  return new Uint8Array([
    0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00,
    0x01, 0x06, 0x01, 0x60, 0x01, 0x7c, 0x01, 0x7f, // f64 to i32
    0x03, 0x02, 0x01, 0x00,
    0x07, 0x09, 0x01, 0x05, 0x66, 0x75, 0x73, 0x65, 0x64, 0x00, 0x00, // "fused"
    0x0a, body.length + 2, 0x01, body.length, ...body,
  ]);
}

/**
 * Whether this browser has relaxed SIMD and fuses multiplication and addition in it.
 * @returns {Promise<boolean>}
 */
export async function fuses() {
  const bytes = probe();
  if (!WebAssembly.validate(bytes)) return false;
  const { instance } = await WebAssembly.instantiate(bytes);
  const fused = /** @type {(x: number) => number} */ (instance.exports.fused);
  return fused(1 + 2 ** -30) !== 0;
}

/**
 * The module for this browser: `relaxed` where it fuses, else `exact`.
 * @returns {Promise<"relaxed" | "exact">}
 */
export const kind = async () => ((await fuses()) ? "relaxed" : "exact");

/** Why a call failed: the message, and the places in the text of a case. */
export class CallFailed extends Error {
  /** @param {{ message: string, places?: Place[] }} error */
  constructor(error) {
    super(error.message);
    this.name = "CallFailed";
    /** @type {Place[]} */
    this.places = error.places ?? [];
  }
}

/** @typedef {{ line: number, column: number, message: string, help: string | null, span: [number, number] }} Place */
/** @typedef {{ message(length: number): number, call(): number, answer(): number, memory: WebAssembly.Memory }} Exports */

/** One instance of the module, with one run at most. */
export class Engine {
  /** @param {Exports} exports */
  constructor(exports) {
    this.exports = exports;
    /** Why it has stopped for good; empty while it works. */
    this.stopped = "";
  }

  /**
   * @param {BufferSource | WebAssembly.Module} source
   * @returns {Promise<Engine>}
   */
  static async from(source) {
    /** @type {{ engine?: Engine }} */
    const made = {};
    const imports = {
      page: {
        milliseconds: () => performance.now(),
        /** @param {number} place @param {number} length */
        panicked: (place, length) => {
          const engine = made.engine;
          if (engine) engine.stopped ||= new TextDecoder().decode(new Uint8Array(engine.exports.memory.buffer, place, length));
        },
      },
    };
    const module = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(source);
    const instance = await WebAssembly.instantiate(module, imports);
    made.engine = new Engine(/** @type {Exports} */ (/** @type {unknown} */ (instance.exports)));
    return made.engine;
  }

  /** A fault of granum, after which the module cannot go on. */
  end() {
    return new Error(`This is a fault of granum, and its module has stopped: ${this.stopped}. Load the page again, and please report it.`);
  }

  /**
   * Carries out a call with its arguments.
   * @param {string} name
   * @param {Record<string, unknown>} [more]
   * @returns {any}
   */
  call(name, more = {}) {
    if (this.stopped) throw this.end();
    const message = new TextEncoder().encode(JSON.stringify({ ...more, call: name }));
    const place = this.exports.message(message.length);
    new Uint8Array(this.exports.memory.buffer, place, message.length).set(message);
    let length = 0;
    try {
      length = this.exports.call();
    } catch (error) {
      this.stopped ||= String(error);
      throw this.end();
    }
    const text = new TextDecoder().decode(new Uint8Array(this.exports.memory.buffer, this.exports.answer(), length));
    const answer = JSON.parse(text);
    if (answer && answer.error) throw new CallFailed(answer.error);
    return answer;
  }
}
