// @ts-check
// The laboratory: a surrogate that answers at once, a case, and its test with grains and curves while it is computed.

import { announce, element, replace } from "../modules/dom.js";
import { figure } from "../modules/figure.js";
import { counted, words } from "../modules/numbers.js";
import { choice, rich, richTable, tiles, trouble, trust } from "../modules/parts.js";
import { show, stage } from "../modules/viewer.js";
import { caseOf } from "./address.js";
import { CallFailed, Engine, kind } from "./engine.mjs";
import { catalogue, compiled } from "./files.js";
import { handed } from "./handed.js";
import { mappings } from "./paper.js";
import { Run } from "./run.js";
import { sliders } from "./sliders.js";
import { offer } from "./visit.js";

/** Milliseconds between two drawings of the curves of a run under way. */
const CURVES_EVERY = 250;
/** The columns over which curves are drawn, the first that a test has. */
const ALONG = ["axial_strain", "deviator_strain", "shear_strain", "deviatoric_strain", "volumetric_strain"];
/** What is drawn over it, where a test has it. */
const SHOWN = [["stress_ratio", "von_mises_ratio"], ["volumetric_strain", "void_ratio"], ["coordination_number"], ["mean_stress"]];

const main = /** @type {HTMLElement} */ (document.getElementById("content"));

/** The case that is shown, its runs, and the surrogate beside it. */
const now = {
  /** @type {Run[]} */ runs: [],
  /** Complete runs of earlier tests, whose curves are drawn beside those of the present one. @type {Run[]} */ compared: [],
  /** How the case is called in legends. */ title: "",
  /** @type {{ name: string, values: Record<string, number> } | null} */ asked: null,
  /** @type {((next: unknown) => void) | null} */ update: null,
  /** @type {unknown} */ drawn: null,
  paints: 0,
  lastCurves: 0,
  drawing: false,
  presenting: false,
  /** The last figure of the curves. */ figure: "",
};

async function start() {
  replace(main, element("h1", {}, "A laboratory of grains"), element("p", { class: "note waits" }, "Loading the engine …"));
  const which = await kind();
  const [cases, module] = await Promise.all([catalogue(), compiled(`engine.${which}`)]);
  const engine = await Engine.from(module);
  /** @type {Promise<Engine> | null} */
  let second = null;
  const surrogates = () => (second ??= compiled(`surrogates.${which}`).then(code => Engine.from(code)));
  page({ which, cases, module, engine, surrogates });
}

/** @typedef {{ which: string, cases: import("./files.js").Catalogue, module: WebAssembly.Module, engine: Engine, surrogates: () => Promise<Engine> }} Tools */

/** @param {Tools} tools */
function page(tools) {
  const { engine } = tools;
  const text = element("textarea", { id: "case", spellcheck: "false", autocomplete: "off", "aria-describedby": "mistakes", oninput: () => { now.asked = null; now.title = "own case"; checked(); } });
  const mistakes = element("ul", { class: "mistakes", id: "mistakes" });
  const summary = element("p", { class: "note" });
  const seeds = element("select", {}, ["1", "2", "4"].map(value => element("option", { value }, value)));
  const grains = element("input", { type: "number", min: 50, max: 5000, step: 50, value: 300 });
  const test = element("button", { type: "button", class: "main", onclick: () => void begin() }, "Test it");
  const area = element("div", { class: "waits" }, element("p", { class: "note" }, "No test yet. Press “Test it”: grains are placed, compressed, and tested along the path of the case."));

  /** Shows the mistakes of the text at their places. @returns {boolean} */
  function checked() {
    try {
      const found = files.reader().call("check", { case: text.value });
      replace(mistakes);
      replace(summary, `The case has ${counted(found.grains, "grain")}${found.pieces > found.grains ? ` of ${found.pieces} spheres` : ""} and ${counted(found.stages.length, "stage")}: ${found.stages.join(", ")}. Here it is tested with the number of grains above, from seed ${found.seed} on.`);
      test.disabled = false;
      return true;
    } catch (error) {
      if (!(error instanceof CallFailed)) throw error;
      const places = error.places.length ? error.places : [{ line: 0, column: 0, message: error.message, help: null, span: /** @type {[number, number]} */ ([0, 0]) }];
      replace(mistakes, places.map(place => element("li", {}, element("button", { type: "button", onclick: () => goTo(place.span) },
        place.line ? `Line ${place.line}: ${place.message}` : place.message, place.help ? ` (${place.help})` : ""))));
      replace(summary, counted(places.length, "mistake"));
      if (places.some(place => place.message.includes("files of the case"))) files.offer.setAttribute("open", "");
      test.disabled = true;
      return false;
    }
  }

  /** Puts the cursor there. The places are bytes, those of a text area units of UTF-16. @param {[number, number]} span */
  function goTo([from, to]) {
    const bytes = new TextEncoder().encode(text.value), units = (/** @type {number} */ end) => new TextDecoder().decode(bytes.subarray(0, end)).length;
    text.focus();
    text.setSelectionRange(units(from), units(to));
  }

  /** @param {string} name */
  function take(name) {
    const ready = tools.cases.cases.find(one => one.name === name);
    if (!ready) return;
    now.asked = null;
    now.title = name;
    text.value = ready.text;
    checked();
  }

  async function begin() {
    if (!checked()) return;
    now.runs.forEach(run => run.stop());
    now.update = null;
    now.drawn = null;
    const base = Number(files.reader().call("check", { case: text.value }).seed);
    const count = Number(seeds.value);
    const limit = Math.max(50, Math.min(5000, Number(grains.value) || 300));
    try {
      now.runs = Array.from({ length: count }, (_, k) => {
        const values = { "grains.count": String(limit), "preparation.seed": String(base + k) };
        return new Run(tools.module, files.reader().call("with", { case: text.value, values }).case, `${now.title}, seed ${base + k}`, () => paint(tools));
      });
    } catch (error) {
      replace(area, trouble(error));
      return;
    }
    frame(tools, area, restart);
    now.runs.forEach(run => run.tell("go"));
    announce("The test has begun");
  }
  const restart = () => void begin();

  const chosen = choice("Ready case", tools.cases.cases.map(one => ({ value: one.name, text: one.title })), "drained-dense", take);
  /** Puts a text into the place of the case; the choice shows the ready case that it is, if it is one. @param {string} found */
  const put = found => {
    text.value = found;
    const select = chosen.querySelector("select");
    now.title = tools.cases.cases.find(one => one.text === found)?.name ?? "own case";
    if (select) select.value = now.title === "own case" ? "" : now.title;
  };
  const visit = element("div", { id: "visit-place" }), addressed = element("div", { id: "addressed" });
  const surrogate = element("section", {}, element("h2", {}, "A surrogate answers at once"));
  const files = handed(tools, text, { changed: () => void checked(), open: (found, name) => {
    now.asked = null;
    put(found);
    if (now.title === "own case") now.title = name.replace(/\.toml$/i, "");
    checked();
  } });
  const shown = element("section", { "aria-label": "The test" }, element("h2", {}, "The test"), area);
  replace(main,
    element("h1", {}, "A laboratory of grains"),
    element("p", {}, "Choose a sand or a powder and see what a surrogate knows of its test, with intervals that should hold 90 % of new samples. Then test it: the grains move in this browser, with the bits of the program."),
    visit, surrogate,
    element("div", { class: "columns" },
      element("section", { "aria-label": "The case" }, element("h2", {}, "The case"), addressed,
        element("div", { class: "tools" },
          chosen,
          element("label", {}, "Grains", grains), element("label", {}, "Seeds at once", seeds)),
        element("label", { for: "case", class: "note" }, "Its text, which you may change"), text, element("div", { role: "alert" }, mistakes), summary, files.offer, test, element("div", { class: "tools", id: "compared" })),
      shown),
    mappings(tools),
    element("p", { class: "note" }, `granum ${engine.call("about").version}; products are added ${tools.which === "relaxed" ? "by an instruction that this browser rounds once" : "by an exact emulation, since this browser has no instruction that rounds once"}.`));
  take("drained-dense");
  const fromAddress = async () => {
    try {
      const found = await caseOf(location.hash, tools.cases.cases);
      if (!found) return replace(addressed);
      now.asked = null;
      put(found.text);
      replace(addressed, element("p", { class: "callout", role: "status" }, `The case of the address${found.name ? `, ${found.name},` : ""} is in its place. Press “Test it” to test it.`));
      if (checked()) test.focus({ preventScroll: true });
      addressed.scrollIntoView({ block: "start" });
    } catch (error) {
      replace(addressed, trouble(error));
    }
  };
  addEventListener("hashchange", () => void fromAddress());
  void fromAddress();
  sliders(surrogate, tools, (found, name, values) => {
    text.value = found;
    now.title = name.replace(/\.json$/, "");
    now.asked = { name, values };
    if (checked()) { text.scrollIntoView({ block: "nearest" }); void begin(); }
  });
  offer({ tools, place: visit, test: shown, surrogate, run: () => now.runs[0], begin: (found, count, asked) => {
    put(found);
    [grains.value, seeds.value, now.asked] = [String(count), "1", asked];
    void begin();
  } });
}

/**
 * The elements of a test that has begun.
 * @param {Tools} tools
 * @param {HTMLElement} area
 * @param {() => void} restart
 */
function frame(tools, area, restart) {
  const button = (/** @type {string} */ id, /** @type {string} */ label, /** @type {() => void} */ onclick) => element("button", { type: "button", id, onclick }, label);
  const each = (/** @type {"go" | "pause" | "piece"} */ what) => () => { now.runs.filter(run => !run.ended).forEach(run => run.tell(what)); paint(tools); };
  replace(area,
    element("div", { class: "tools" }, button("pause", "Pause", each("pause")), button("go", "Go on", each("go")), button("step", "One piece", each("piece")), button("again", "Begin again", restart), button("save", "Save the run", () => void keep())),
    element("ul", { id: "states", class: "checks" }), element("div", { id: "curves", "aria-live": "off" }), stage("The grains of the first run"),
    element("div", { id: "results" }));
}

/** @param {string} id */
const by = id => /** @type {HTMLElement} */ (document.getElementById(id));

/**
 * Shows what is new.
 * @param {Tools} tools
 */
function paint(tools) {
  if (!document.getElementById("states")) return;
  const goes = now.runs.some(run => run.goes), ended = now.runs.every(run => run.ended);
  /** @type {HTMLButtonElement} */ (by("pause")).disabled = !goes;
  /** @type {HTMLButtonElement} */ (by("go")).disabled = goes || ended;
  /** @type {HTMLButtonElement} */ (by("step")).disabled = ended;
  /** @type {HTMLButtonElement} */ (by("save")).disabled = ended;
  replace(by("states"), now.runs.map(run => element("li", { class: run.fault ? "missed" : run.digest ? "passed" : null }, line(run))));
  const first = now.runs[0];
  if (first?.view && first.view !== now.drawn) {
    now.drawn = first.view;
    if (now.update) now.update(first.view);
    else now.update = show(by("stage"), first.view);
    now.paints += 1;
    by("stage").dataset.pictures = String(now.paints);
  }
  if (ended) void curves(tools).then(() => results(tools)).catch(error => replace(by("results"), trouble(error)));
  else if (performance.now() - now.lastCurves > CURVES_EVERY) void curves(tools);
}

/** Gives the first run that is under way as a file, from which the program goes on. */
async function keep() {
  const first = now.runs.find(run => run.begun && !run.ended);
  const saved = first && (await first.ask("saved")).run;
  if (!saved) return announce("There is no run under way");
  save("saved-run.json", "application/json", saved);
  announce("The run is saved; granum resume saved-run.json --out run goes on with it");
}

/** Where a run is, in a line. @param {Run} run */
function line(run) {
  if (run.fault) return `${run.name}: ${run.fault.message}`;
  if (run.digest) return `${run.name}: complete after ${counted(run.answer.steps.test ?? 0, "step")} of the test, ${counted(run.rows.length, "state")}; digest ${run.digest.slice(0, 16)}…`;
  const progress = run.answer?.progress;
  if (!progress) return `${run.name}: the grains are placed`;
  const share = progress.fraction === null || progress.fraction === undefined ? "" : `, ${Math.round(100 * progress.fraction)} %`;
  const stage = progress.part ? `${progress.activity}, ${progress.part}` : progress.activity;
  return `${run.name}: ${stage}${share}, ${counted(progress.done, "step")}, ${counted(run.rows.length, "state")}${run.goes ? "" : "; it waits"}`;
}

/** Draws the curves so far, with the prediction where a surrogate was asked. @param {Tools} tools */
async function curves(tools) {
  const shown = now.runs.filter(run => run.rows.length > 1);
  if (now.drawing || shown.length === 0) return;
  now.drawing = true;
  now.lastCurves = performance.now();
  try {
    const surrogates = await tools.surrogates();
    const place = by("curves"), gone = new AbortController();
    /** @type {any} */ (place).gone?.abort();
    /** @type {any} */ (place).gone = gone;
    if (now.asked && shown[0]) {
      const { result } = await shown[0].ask("result");
      const { figure: svg, extrapolated } = surrogates.call("predict", { ...now.asked, result });
      now.figure = svg;
      replace(place, figure(svg, "The test over its prediction", `${shown[0].name} in black over what the surrogate predicts${extrapolated ? "; these inputs are outside of its runs" : ""}; bands hold 90 % of new samples.`, gone.signal));
      return;
    }
    const columns = /** @type {Run} */ (shown[0]).columns, has = (/** @type {string} */ name) => columns.some(column => column.name === name);
    const x = ALONG.find(name => has(name) && moves(shown, name)) ?? "state";
    const unit = (/** @type {string} */ name) => columns.find(column => column.name === name)?.unit ?? "";
    const drawn = [...now.compared.filter(run => !shown.includes(run)), ...shown];
    const panels = SHOWN.flatMap(names => names.find(name => has(name) && name !== x) ?? []).map(y => ({
      x: words(x), y: words(y), x_unit: unit(x), y_unit: unit(y), curves: drawn.map(run => ({ name: run.name, points: run.points(x, y) })).filter(curve => curve.points.length > 1),
    }));
    now.figure = surrogates.call("curves", { panels }).figure;
    replace(place, figure(now.figure, "Curves of the test", "Compression is positive; strains are logarithmic.", gone.signal));
  } catch (error) {
    replace(by("curves"), trouble(error));
  } finally {
    now.drawing = false;
  }
}

/** True if a column changes in a run. @param {Run[]} runs @param {string} name */
function moves(runs, name) {
  return runs.some(run => { const values = run.points("state", name).map(point => point[1]); return Math.max(...values) - Math.min(...values) > 1e-6; });
}

/** What the report of the first run says first, and what is offered, once all runs have ended. @param {Tools} tools */
async function results(tools) {
  const first = now.runs.find(run => run.digest);
  const place = document.getElementById("results");
  if (!first || !place || place.childElementCount || now.presenting) return;
  now.presenting = true;
  const [{ result }, surrogates] = await Promise.all([first.ask("result"), tools.surrogates()]).finally(() => { now.presenting = false; });
  /** @type {import("../modules/parts.js").Presented} */
  const found = surrogates.call("presented", { result, name: first.name });
  // A test that has begun meanwhile has its own place.
  if (!place.isConnected) return;
  const report = async () => {
    const { result } = await first.ask("result", { assemblies: true });
    save("report.html", "text/html", surrogates.call("report", { result, name: first.name }).html);
  };
  const button = (/** @type {string} */ label, /** @type {() => unknown} */ onclick) => element("button", { type: "button", onclick }, label);
  replace(place,
    element("h3", {}, `What ${first.name} has shown`),
    found.unfinished && element("p", { class: "callout" }, rich(found.unfinished)),
    tiles(found.tiles), trust(found),
    found.strength && element("details", {}, element("summary", {}, "Strength at a glance"), richTable(found.strength)),
    element("p", {}, `Its digest is ${first.digest}: granum run case.toml and granum digest give the same on any machine.`),
    element("div", { class: "tools" },
      button("Case", () => save("case.toml", "application/toml", first.text)),
      button("Series (CSV)", async () => save("series.csv", "text/csv", (await first.ask("series")).csv)),
      button("Figure (SVG)", () => save("curves.svg", "image/svg+xml", now.figure)),
      button("Report (HTML)", () => void report()),
      button("Compare with the next test", () => compare(now.runs.filter(run => run.digest)))));
  announce("The test is complete");
}

/** Draws the curves of complete runs beside those of the tests to come, until they are taken away. @param {Run[]} runs */
function compare(runs) {
  now.compared.push(...runs.filter(run => !now.compared.includes(run)));
  listCompared();
  announce(`${counted(now.compared.length, "run")} will be drawn beside the next tests`);
}

/** The runs that are compared, each with a button that takes it away. */
function listCompared() {
  const away = (/** @type {Run} */ run) => { now.compared = now.compared.filter(one => one !== run); listCompared(); };
  replace(by("compared"), now.compared.length ? element("p", { class: "note" }, "Drawn beside the next tests:") : "",
    now.compared.map(run => element("button", { type: "button", onclick: () => away(run), "aria-label": `Take away ${run.name}` }, `${run.name} ×`)));
}

/** Gives a file to the reader. @param {string} name @param {string} type @param {string} content */
function save(name, type, content) {
  const address = URL.createObjectURL(new Blob([content], { type }));
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

start().catch(error => replace(main, element("h1", {}, "A laboratory of grains"), trouble(error)));
