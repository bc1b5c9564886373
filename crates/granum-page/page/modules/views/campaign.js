// @ts-check
// A campaign: how far it is, its map, its runs.

import { element, replace } from "../dom.js";
import { map } from "../figure.js";
import { counted, quantity, words } from "../numbers.js";
import { choice, commandLines, pages, scrolling, state, table, trouble } from "../parts.js";
import { remember, to } from "../router.js";
import { data } from "../server.js";
import { showFigures } from "./run.js";

/** Runs at a time. */
const STEP = 100;
/** How often a campaign that is under way is asked, ms. */
const AGAIN = 5000;
/** What a map shows at first, as far as the runs have it. */
const USUAL = ["peak_friction_angle", "peak_stress_ratio", "peak_von_mises_ratio", "solid_fraction"];

/** @type {import("../main.js").View} */
export async function campaign(main, query, signal) {
  const path = query.get("path") ?? "";
  const found = await data("campaign", { path, count: STEP }, signal);
  const name = path.split("/").pop() || "Campaign";
  const counts = element("div", {}), theMap = element("div", {}), runs = element("div", {}), figures = element("div", {});
  let last = found;
  const put = (/** @type {any} */ now) => {
    last = now;
    const each = Object.entries(now.counts).map(([word, count]) => element("li", { class: "tile" }, element("b", {}, String(count)), element("span", {}, word)));
    replace(counts, element("p", {}, state(now.at_work ? "running" : now.is_done ? "finished" : "not at work"), ` ${counted(now.total, "run")}`),
      element("ul", { class: "tiles" }, each));
    replace(runs, rows(now), pages({ from: now.from, shown: now.runs.length, total: now.total, step: STEP }, from => { void again(from); }));
  };
  const again = async (/** @type {number} */ from) => {
    try { put(await data("campaign", { path, from, count: STEP }, signal)); } catch (error) { if (!signal.aborted) replace(runs, trouble(error)); }
  };
  put(found);
  replace(main, element("h1", {}, name), element("p", { class: "subtitle" }, path), counts, found.next && element("p", { class: "note" }, `Next: ${found.next}`),
    theMap, element("h2", {}, "Runs"), runs, figures,
    element("details", {}, element("summary", {}, "The plan"), element("pre", { tabindex: "0", role: "region", "aria-label": "The plan" }, found.plan)),
    commandLines(found.commands));
  void showMap(theMap, path, query, signal);
  if (Object.keys(found.counts).some(word => word.startsWith("f"))) {
    const details = element("details", {}, element("summary", {}, "The figures of its report"), figures);
    runs.after(details);
    details.addEventListener("toggle", () => { if (details.open && figures.childElementCount === 0) void showFigures(figures, [path], signal); });
  }
  if (found.at_work) {
    const timer = setInterval(async () => {
      if (document.hidden) return;
      await again(last.from);
      if (!last.at_work) clearInterval(timer);
    }, AGAIN);
    signal.addEventListener("abort", () => clearInterval(timer));
  }
  return name;
}

/**
 * @param {Element} place
 * @param {string} path
 * @param {URLSearchParams} query
 * @param {AbortSignal} signal
 */
async function showMap(place, path, query, signal) {
  const title = element("h2", {}, "Map");
  replace(place, title, element("p", { class: "note" }, "Reading the runs …"));
  /** @type {{ name: string, unit: string, is_number: boolean, kind: string }[]} */
  let quantities = [];
  try {
    quantities = (await data("quantities", { path }, signal)).quantities;
  } catch (error) {
    if (!signal.aborted) replace(place, title, trouble(error));
    return;
  }
  const numbers = quantities.filter(quantity => quantity.is_number);
  if (quantities.length < 2 || numbers.length === 0) {
    replace(place, title, element("p", {}, "There is nothing to draw before runs are finished."));
    return;
  }
  const known = (/** @type {string | null} */ name) => quantities.find(quantity => quantity.name === name)?.name;
  const usual = USUAL.find(name => known(name)) ?? numbers[0]?.name ?? "";
  const asked = {
    x: known(query.get("x")) ?? quantities.find(quantity => quantity.kind === "key" && quantity.name !== "preparation.seed")?.name ?? quantities[0]?.name ?? "",
    y: known(query.get("y")) ?? usual,
  };
  const sheet = element("div", {});
  const options = (/** @type {typeof quantities} */ of) => of.map(({ name, unit }) => ({ value: name, text: unit ? `${words(name)} (${unit})` : words(name) }));
  const draw = async () => {
    try {
      const found = await data("map", { path, ...asked }, signal);
      replace(sheet, map(found.svg, found.title, found.caption, found.points, path => to("run", { path }), signal),
        element("details", {}, element("summary", {}, "The same as a table"), table(found.title, found.columns)));
    } catch (error) {
      if (!signal.aborted) replace(sheet, trouble(error));
    }
  };
  const changed = (/** @type {Partial<typeof asked>} */ change) => { Object.assign(asked, change); remember({ path, ...asked }); void draw(); };
  replace(place, title, element("div", { class: "tools" },
    choice("Vertical", options(quantities), asked.y, y => changed({ y })),
    choice("Horizontal", options(quantities), asked.x, x => changed({ x }))), sheet);
  await draw();
}

/** @param {any} found */
function rows(found) {
  const variables = found.variables;
  const value = (/** @type {any} */ run, /** @type {any} */ variable) => {
    const own = run.values[variable.name];
    return typeof own === "string" ? own : quantity(own, variable.unit);
  };
  const row = (/** @type {any} */ run) => element("tr", {},
    element("th", { scope: "row", class: "word" }, run.path === null ? run.name : element("a", { href: to("run", { path: run.path }) }, run.name)),
    element("td", { class: "word" }, state(run.state)),
    variables.map((/** @type {any} */ variable) => element("td", {}, value(run, variable))),
    element("td", { class: "word long" }, words(run.reason)));
  const heads = variables.map((/** @type {any} */ variable) => element("th", { scope: "col" }, words(variable.name)));
  return scrolling("Runs of the campaign", element("table", {},
    element("thead", {}, element("tr", {}, element("th", { scope: "col", class: "word" }, "Run"), element("th", { scope: "col", class: "word" }, "State"), heads,
      element("th", { scope: "col", class: "word" }, "Remarks"))),
    element("tbody", {}, found.runs.map(row))));
}
