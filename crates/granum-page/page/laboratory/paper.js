// @ts-check
// The mappings of Antony, Zhou and Wang (2006): small runs are made here, the networks of a mapping learn from some of them, and answer beside the others.

import { announce, element, replace } from "../modules/dom.js";
import { figure } from "../modules/figure.js";
import { digits } from "../modules/numbers.js";
import { choice, table, trouble } from "../modules/parts.js";
import { compiled } from "./files.js";
import { Run } from "./run.js";

/** The runs from which networks learn, and those that they never see, by their seeds. */
const TRAINING = [1, 2, 3], UNSEEN = [4, 5];
/** What differs from the case of the paper, so that the runs take seconds and not hours. */
const SMALLER = { "grains.count": "200", "grains.material.youngs_modulus": "1 GPa", "shear.inertial_number": "1e-3" };
/** Steps of a slider from one end of its range to the other. */
const STEPS = 100;
/** What stands beside the networks, in the order of the table. */
const SCORED = /** @type {const} */ ([["networks", "networks of the mapping"], ["strain_only", "networks given the strain alone"], ["ridge", "ridge regression on the same sensors"],
  ["ridge_strain_only", "ridge regression on the strain alone"], ["mean_curve", "mean curve of the training runs"]]);

/** The calls of the module of the surrogates, in a worker. */
class Networks {
  /** @param {WebAssembly.Module} module */
  constructor(module) {
    this.module = module;
    this.asked = 0;
    /** @type {Map<number, { done: (answer: any) => void, failed: (error: Error) => void }>} */
    this.waiting = new Map();
    this.worker = new Worker(new URL("paper-worker.js", import.meta.url), { type: "module" });
    this.worker.addEventListener("message", ({ data }) => {
      const waits = this.waiting.get(data.of);
      this.waiting.delete(data.of);
      if (data.fault) waits?.failed(new Error(data.fault));
      else waits?.done(data.answer);
    });
    this.worker.addEventListener("error", event => { for (const waits of this.waiting.values()) waits.failed(new Error(event.message || "the worker has stopped")); });
  }

  /** @param {string} call @param {Record<string, unknown>} [more] @returns {Promise<any>} */
  ask(call, more = {}) {
    const of = ++this.asked;
    return new Promise((done, failed) => { this.waiting.set(of, { done, failed }); this.worker.postMessage({ of, module: this.module, call, more }); });
  }
}

/**
 * A section with the mappings, closed until it is opened.
 * @param {import("./main.js").Tools} tools
 */
export function mappings(tools) {
  const body = element("div", {});
  let opened = false;
  return element("details", { id: "mappings", ontoggle: () => { if (!opened) { opened = true; void open(tools, body); } } },
    element("summary", {}, "The mappings of Antony, Zhou and Wang (2006)"), body);
}

/**
 * @param {import("./main.js").Tools} tools
 * @param {HTMLElement} body
 */
async function open(tools, body) {
  replace(body, element("p", { class: "note" }, "Loading the networks …"));
  try {
    const networks = new Networks(await compiled(`surrogates.${tools.which}`));
    fill(tools, body, networks, (await networks.ask("mappings")).mappings);
  } catch (error) {
    replace(body, trouble(error));
  }
}

/**
 * @param {import("./main.js").Tools} tools
 * @param {HTMLElement} body
 * @param {Networks} networks
 * @param {{ name: string, formula: string, networks: { range: number[], hidden: number[] }[] }[]} known
 */
function fill(tools, body, networks, known) {
  let [mapping, neurons] = ["F3", "6"];
  /** @type {{ name: string, result: any }[]} */
  let made = [];
  const button = element("button", { type: "button", class: "main", id: "mapping-train", onclick: () => void train() }, "Make five runs and train");
  const status = element("p", { class: "note", role: "status", id: "mapping-status" }), answer = element("div", { id: "mapping-answer" });
  const size = known[2]?.networks.map(one => one.hidden.join(" and ")).join(", ") ?? "";
  replace(body,
    element("p", {}, "Six mappings between strain, stress ratio, fabric and the distribution of contact forces, each with three networks for ranges of the strain. No trained networks are shipped: the runs are made here, three to learn from and two that no network sees."),
    element("p", { class: "note" }, "The case is that of the paper with 200 grains, a modulus of 1 GPa and a shear at an inertial number of 1e-3, so that it takes seconds: such small samples scatter more than those of 5000 grains. granum reproduce makes the study as it was."),
    element("div", { class: "tools" },
      choice("Mapping", known.map(one => ({ value: one.name, text: one.formula })), mapping, value => { mapping = value; }),
      choice("Neurons in a hidden layer", [{ value: "6", text: "6: seconds" }, { value: "12", text: "12" }, { value: "0", text: `as in the paper (F3: ${size}): minutes` }], neurons, value => { neurons = value; }),
      button),
    status, answer);

  async function train() {
    button.disabled = true;
    try {
      if (made.length === 0) made = await runs(tools, text => { status.textContent = text; });
      button.textContent = "Train";
      status.textContent = "The networks learn …";
      const begun = performance.now();
      const trained = await networks.ask("train_mapping", { mapping, neurons: Number(neurons), training: made.slice(0, TRAINING.length), unseen: made.slice(TRAINING.length) });
      status.textContent = `Trained on ${trained.training_states} states of ${TRAINING.length} runs in ${digits((performance.now() - begun) / 1000, 2)} s.`;
      show(trained);
      announce("The networks are trained");
    } catch (error) {
      status.textContent = "";
      replace(answer, trouble(error));
    } finally {
      button.disabled = false;
    }
  }

  let gone = new AbortController();

  /** @param {any} trained */
  function show(trained) {
    gone.abort();
    gone = new AbortController();
    const { signal } = gone;
    const shown = SCORED.filter(([key]) => typeof trained.errors[key] === "number");
    const unseen = trained.runs.slice(TRAINING.length);
    const asked = { run: unseen[0], strain: 0, values: /** @type {Record<string, number>} */ ({}) };
    const place = element("div", { id: "mapping-state", "aria-live": "off" });
    let due = false;
    const soon = () => { if (!due) { due = true; requestAnimationFrame(() => { due = false; void state(); }); } };
    let drawn = new AbortController();
    signal.addEventListener("abort", () => drawn.abort());
    const state = async () => {
      try {
        const found = await networks.ask("ask_mapping", asked);
        if (signal.aborted) return;
        drawn.abort();
        drawn = new AbortController();
        const engine = await tools.surrogates();
        const warning = found.outside ? element("p", { class: "callout bad" }, "Outside of what these networks were trained with: they guess.") : null;
        const rows = /** @type {const} */ ([["networks of the mapping", "networks"], ["strain alone", "strain_only"], [`DEM, ${asked.run}`, "measured"]]);
        if (found.measured.length === 1) {
          replace(place, warning, element("ul", { class: "tiles" }, rows.map(([name, key]) => element("li", { class: "tile" }, element("b", {}, digits(found[key][0], 3)), element("span", {}, name)))));
        } else {
          const panels = [{ x: "force over its mean", y: "P(f)", curves: rows.map(([name, key]) => ({ name, points: found[key].map((/** @type {number} */ y, /** @type {number} */ k) => [trained.forces[k], y]) })) }];
          replace(place, warning, figure(engine.call("curves", { panels }).figure, "The distribution of contact forces", `At a deviator strain of ${digits(found.strain, 3)}, by network ${found.network} of three.`, drawn.signal));
        }
      } catch (error) {
        if (!signal.aborted) replace(place, trouble(error));
      }
    };
    /** @type {(() => void)[]} */
    const own = [];
    const slider = (/** @type {any} */ input) => {
      const strain = input.name === "deviator_strain";
      const [low, high] = input.range;
      const output = element("output", {}, "its own");
      const range = element("input", { type: "range", min: 0, max: STEPS, value: STEPS / 2, id: `mapping-${input.name}`, "aria-label": strain ? "deviator strain" : `${input.symbol} in the place of its own`, oninput: () => {
        const value = low + (Number(range.value) / STEPS) * (high - low);
        if (strain) asked.strain = value;
        else asked.values[input.name] = value;
        output.textContent = digits(value, 3);
        range.setAttribute("aria-valuetext", digits(value, 3));
        soon();
      } });
      if (strain) { asked.strain = (low + high) / 2; output.textContent = digits(asked.strain, 3); }
      else { range.setAttribute("aria-valuetext", "its own"); own.push(() => { delete asked.values[input.name]; output.textContent = "its own"; range.value = String(STEPS / 2); range.setAttribute("aria-valuetext", "its own"); }); }
      return element("div", { class: "slider" }, element("span", {}, strain ? "deviator strain" : `${input.symbol}, in the place of that of the run`), output, range);
    };
    const controls = trained.inputs.map(slider);
    replace(answer,
      element("h3", {}, "At a state"),
      element("div", { class: "tools" },
        choice("Sensors of", trained.runs.map((/** @type {string} */ name) => ({ value: name, text: unseen.includes(name) ? `${name}, unseen` : `${name}, learned` })), asked.run, value => { asked.run = value; soon(); }),
        own.length ? element("button", { type: "button", onclick: () => { own.forEach(back => back()); soon(); } }, "Its own sensors") : null),
      controls, place,
      element("h3", {}, "Over the whole of the unseen runs"),
      table("Relative error on the unseen runs", [
        { name: "answer", unit: "", is_number: false, values: shown.map(([, name]) => name) },
        { name: "relative RMSE", unit: "%", is_number: true, values: shown.map(([key]) => Math.round(1000 * trained.errors[key]) / 10) }]),
      element("p", {}, trained.summary),
      figure(trained.figure, `${trained.formula} over states of the discrete element method`, plain(trained.caption), signal));
    void state();
  }
}

/** A caption without the marks by which granum sets symbols. @param {string} text */
const plain = text => text.replaceAll("*", "").replace(/_\{([^}]*)\}/g, "_$1");

/**
 * The results of the runs, as many at once as the computer has processors.
 * @param {import("./main.js").Tools} tools
 * @param {(text: string) => void} tell
 */
async function runs(tools, tell) {
  const ready = tools.cases.cases.find(one => one.name === "paper");
  if (!ready) throw new Error("This page has no case paper.");
  const seeds = [...TRAINING, ...UNSEEN], left = [...seeds];
  /** @type {Map<number, any>} */
  const results = new Map();
  const told = new Map(seeds.map(seed => [seed, ""]));
  const one = async () => {
    for (let seed = left.shift(); seed !== undefined; seed = left.shift()) {
      const name = `seed ${seed}`, values = { ...SMALLER, "preparation.seed": String(seed) };
      /** @type {() => void} */
      let changed = () => {};
      const run = new Run(tools.module, tools.engine.call("with", { case: ready.text, values }).case, name, () => changed());
      try {
        await new Promise((/** @type {(value?: unknown) => void} */ done) => {
          changed = () => {
            const progress = run.answer?.progress;
            told.set(Number(seed), run.digest ? "complete" : progress ? `${progress.activity} ${Math.round(100 * (progress.fraction ?? 0))} %` : "grains are placed");
            tell([...told].filter(([, text]) => text).map(([which, text]) => `seed ${which}: ${text}`).join("; "));
            if (run.ended) { changed = () => {}; done(); }
          };
          run.tell("go");
        });
        if (run.fault) throw new Error(`${name}: ${run.fault.message}`);
        results.set(seed, (await run.ask("result", { assemblies: false })).result);
      } finally {
        run.stop();
      }
    }
  };
  await Promise.all(Array.from({ length: Math.max(1, Math.min(seeds.length, navigator.hardwareConcurrency || 2)) }, one));
  return seeds.map(seed => ({ name: `seed ${seed}`, result: results.get(seed) }));
}
