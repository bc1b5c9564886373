// @ts-check
// One run: what it is, how far it is, its figures, its checks, its case.

import { announce, element, replace } from "../dom.js";
import { figure } from "../figure.js";
import { grains } from "../grains.js";
import { counted, duration, quantity, words } from "../numbers.js";
import { commandLines, rich, richTable, scrolling, state, tiles, trouble, trust } from "../parts.js";
import { data } from "../server.js";

/** How often a run that is under way is asked, ms. */
const AGAIN = 2000;

/** @type {import("../main.js").View} */
export async function run(main, query, signal) {
  const path = query.get("path") ?? "";
  const found = await data("run", { path }, signal);
  const progress = element("div", {}), figures = element("div", {});
  put(progress, found.progress);
  replace(main,
    element("h1", {}, found.name),
    element("p", { class: "subtitle" }, [found.what, counted(found.grains, "grain"), `granum ${found.granum_version}`, found.engine === "granum" ? "" : `by ${found.engine}`,
      `${duration(found.seconds)} of work`].filter(Boolean).join(" · ")),
    progress, found.next && element("p", { class: "note" }, `${sentence(found.holds)}. Next: ${found.next}`),
    found.presented && presented(found.presented), measures(found.measures), theCase(found),
    found.snapshots.length > 0 && grains(path, found.snapshots, signal),
    figures, commandLines(found.commands));
  void showFigures(figures, [path], signal);
  if (found.progress.at_work) follow(path, progress, figures, found.progress, signal, () => { void run(main, query, signal); });
  return found.name;
}

/** @param {string} text */
function sentence(text) {
  return text ? text.charAt(0).toUpperCase() + text.slice(1) : "A run";
}

/**
 * @param {Element} place
 * @param {any} progress
 */
function put(place, progress) {
  const share = typeof progress.share === "number" ? progress.share : null;
  const strain = progress.deviator_strain_end !== null && progress.deviator_strain !== null
    ? `deviator strain ${quantity(progress.deviator_strain, "", 3)} of ${quantity(progress.deviator_strain_end, "", 3)}` : "";
  const parts = [progress.phase, strain, progress.states > 0 ? `${counted(progress.states, "state")} recorded` : ""].filter(Boolean).join(", ");
  replace(place, element("p", {}, state(progress.status), parts ? ` ${parts}` : ""),
    progress.status !== "finished" && share !== null && element("progress", { max: 1, value: share, "aria-label": "Share of the test that is done" }, `${Math.round(100 * share)} %`));
}

/**
 * Asks a run that is under way, and draws it again when it has recorded more.
 * @param {string} path
 * @param {Element} place
 * @param {Element} figures
 * @param {any} before
 * @param {AbortSignal} signal
 * @param {() => void} ended what is done when it has ended, and has checks and results
 */
function follow(path, place, figures, before, signal, ended) {
  let last = before;
  const timer = setInterval(async () => {
    if (document.hidden) return;
    try {
      const now = await data("progress", { path }, signal);
      put(place, now);
      if (!now.at_work) {
        clearInterval(timer);
        announce(`The run is ${now.status}`);
        ended();
        return;
      }
      if (now.states !== last.states) void showFigures(figures, [path], signal);
      last = now;
    } catch (error) {
      if (!signal.aborted) { clearInterval(timer); place.append(trouble(error)); }
    }
  }, AGAIN);
  signal.addEventListener("abort", () => clearInterval(timer));
}

/**
 * The figures of the report of runs, campaigns and studies. Those that are there stay until the new ones are.
 * @param {Element} place
 * @param {string[]} paths
 * @param {AbortSignal} signal
 */
export async function showFigures(place, paths, signal) {
  if (place.childElementCount === 0) replace(place, element("p", { class: "note" }, "Drawing the figures …"));
  try {
    const found = await data("figures", { path: paths }, signal);
    const figures = found.figures.map((/** @type {any} */ { svg, title, caption }) => figure(svg, title, caption, signal));
    if (figures.length === 0 && found.remarks.length === 0) {
      replace(place);
      return;
    }
    replace(place, element("h2", {}, "Figures"),
      found.remarks.map((/** @type {string} */ remark) => element("p", { class: "callout" }, remark)),
      element("div", { class: "figures" }, figures));
  } catch (error) {
    if (!signal.aborted) replace(place, element("h2", {}, "Figures"), element("p", { class: "callout" }, error instanceof Error ? error.message : String(error)));
  }
}

/** What its report says first. @param {import("../parts.js").Presented} found */
function presented(found) {
  return [found.unfinished && element("p", { class: "callout" }, rich(found.unfinished)), tiles(found.tiles), trust(found),
    found.strength && element("details", {}, element("summary", {}, "Strength at a glance"), richTable(found.strength)),
    found.signs.length > 0 && element("details", {}, element("summary", {}, "Signs and symbols"), element("p", {}, rich(found.signs)))];
}

/** @param {any[]} measures */
function measures(measures) {
  if (measures.length === 0) return null;
  const row = (/** @type {any} */ measure) =>
    element("tr", {}, element("th", { scope: "row", class: "word" }, words(measure.name)), element("td", {}, quantity(measure.value, measure.unit)));
  return element("details", {}, element("summary", {}, `All ${measures.length} measures`), scrolling("All measures", element("table", {},
    element("thead", {}, element("tr", {}, element("th", { scope: "col", class: "word" }, "measure"), element("th", { scope: "col" }, "value"))),
    element("tbody", {}, measures.map(row)))));
}

/** @param {any} found */
function theCase(found) {
  const columns = found.columns ? found.columns.map((/** @type {any} */ column) => column.unit ? `${column.name} (${column.unit})` : column.name).join(", ") : "";
  return element("details", {}, element("summary", {}, "The case, its digest, and the recorded columns"),
    element("p", {}, "Digest of the case: ", element("code", {}, found.case_digest)),
    found.notes.map((/** @type {string} */ note) => element("p", { class: "note" }, note)),
    columns && element("p", {}, "Recorded: ", columns),
    element("pre", { tabindex: "0", role: "region", "aria-label": "The case" }, found.case));
}
