// @ts-check
// What is in the folder.

import { announce, element, replace } from "../dom.js";
import { counted, quantity } from "../numbers.js";
import { choice, commandLines, pages, scrolling, state, trouble } from "../parts.js";
import { remember, to } from "../router.js";
import { data } from "../server.js";

/** Rows at a time. */
const STEP = 100;
/** Most runs that are laid over each other. */
const MOST = 100;
/** The words for kinds. @type {Record<string, [string, string]>} */
const KINDS = {
  run: ["run", "runs"], campaign: ["campaign", "campaigns"], study: ["study", "studies"], surrogate: ["surrogate", "surrogates"],
  family: ["fitted family", "fitted families"], calibration: ["calibration", "calibrations"], reproduction: ["reproduction", "reproductions"],
};
/** How often a list with something that runs is read again, ms. */
const AGAIN = 5000;

/** The runs that are chosen, also those on other pages of the list. @type {Set<string>} */
const chosen = new Set();

/** @type {import("../main.js").View} */
export async function list(main, query, signal) {
  const asked = {
    kind: query.get("kind") ?? "", filter: query.get("filter") ?? "", order: query.get("order") ?? "newest", from: Number(query.get("from") ?? 0),
  };
  const first = await data("folder", { ...asked, count: STEP }, signal);
  const where = document.getElementById("where");
  if (where) where.textContent = `${first.folder} · ${first.version}`;
  const rows = element("div", {}), tools = element("div", {});
  const compare = element("button", { type: "button", class: "main", onclick: () => { location.hash = to("compare", { path: [...chosen] }); } });
  const none = element("button", { type: "button", onclick: () => { chosen.clear(); for (const box of rows.querySelectorAll("input")) box.checked = false; tell(); } }, "Choose none");
  const tell = () => {
    const count = chosen.size;
    compare.textContent = count < 2 ? "Compare the chosen runs" : `Compare ${count} runs`;
    compare.disabled = count < 2 || count > MOST;
    none.hidden = count === 0;
  };
  const choose = (/** @type {string} */ path, /** @type {boolean} */ on) => { if (on) chosen.add(path); else chosen.delete(path); tell(); };
  let seen = "";
  const put = (/** @type {any} */ found) => {
    // What has not changed stays, so that the focus does.
    if (JSON.stringify(found.rows) === seen) return;
    seen = JSON.stringify(found.rows);
    const shown = found.rows.length;
    replace(rows,
      found.is_cut && element("p", { class: "callout" }, "The folder holds more than is searched; serve a folder within it to see the rest."),
      shown === 0 ? element("p", {}, nothing(asked)) : table(found.rows, choose),
      pages({ from: found.from, shown, total: found.total, step: STEP }, from => { void again({ from }); }));
  };
  const again = async (/** @type {Partial<typeof asked>} */ change) => {
    Object.assign(asked, { from: 0 }, change);
    remember({ ...asked, from: asked.from || undefined, order: asked.order === "newest" ? undefined : asked.order });
    try {
      const found = await data("folder", { ...asked, count: STEP }, signal);
      put(found);
      announce(counted(found.total, "row"));
    } catch (error) {
      if (!signal.aborted) replace(rows, trouble(error));
    }
  };
  const all = Object.values(first.counts).reduce((/** @type {number} */ sum, /** @type {any} */ count) => sum + count, 0);
  const kinds = Object.entries(first.counts).filter(([, count]) => Number(count) > 0)
    .map(([value, count]) => ({ value, text: `${KINDS[value]?.[1] ?? value} (${count})` }));
  const filter = element("input", { type: "search", value: asked.filter, autocomplete: "off", oninput: () => later(() => again({ filter: filter.value })) });
  replace(tools, element("div", { class: "tools" },
    choice("Kind", [{ value: "", text: `all (${all})` }, ...kinds], asked.kind, kind => { void again({ kind }); }),
    element("label", {}, "Name contains", filter),
    choice("Order", [{ value: "newest", text: "newest first" }, { value: "name", text: "by name" }], asked.order, order => { void again({ order }); }),
    compare, none));
  tell();
  put(first);
  replace(main, element("h1", {}, "What is in the folder"), element("p", { class: "subtitle" }, first.folder), tools, rows,
    commandLines([{ what: "The results of all of its runs in a table", command: first.command }]));
  const timer = setInterval(async () => {
    if (document.hidden || !seen.includes('"running"')) return;
    try { put(await data("folder", { ...asked, count: STEP }, signal)); } catch { /* It is asked again. */ }
  }, AGAIN);
  signal.addEventListener("abort", () => clearInterval(timer));
  return "Folder";
}

/** @param {{ kind: string, filter: string }} asked */
function nothing(asked) {
  if (asked.kind || asked.filter) return "Nothing in the folder is of that kind and name.";
  return "The folder holds nothing that granum has written. Start a run in it, for example: granum init case.toml, then granum run case.toml.";
}

/** @type {number | undefined} */
let waiting;

/** Does something when nothing has been typed for a moment. @param {() => unknown} work */
function later(work) {
  clearTimeout(waiting);
  waiting = setTimeout(work, 250);
}

/**
 * @param {any[]} rows
 * @param {(path: string, on: boolean) => void} choose
 */
function table(rows, choose) {
  const head = ["Compare", "Name", "Kind", "State", "Grains", "Result", "Changed"];
  const kinds = ["choice", "word", "word", "word", "optional", "optional", "optional"];
  const row = (/** @type {any} */ found) => {
    const isTest = found.kind === "run" && found.what === "test";
    const box = isTest && element("input", { type: "checkbox", checked: chosen.has(found.path), "aria-label": `Choose ${found.path} to compare` });
    if (box) box.addEventListener("change", () => choose(found.path, box.checked));
    const measure = found.measure ? `${found.measure.name} ${quantity(found.measure.value, found.measure.unit, 3)}` : "";
    const missed = found.checks_failed ? ` ${counted(found.checks_failed, "check")} not passed` : "";
    const time = found.modified ? new Date(1000 * found.modified) : null;
    return element("tr", {},
      element("td", { class: "choice" }, box),
      element("th", { scope: "row", class: "word long" }, element("a", { href: to(found.kind, { path: found.path }) }, found.path || "this folder")),
      element("td", { class: "word" }, found.kind === "run" ? found.what ?? "run" : KINDS[found.kind]?.[0] ?? found.kind),
      element("td", { class: "word" }, found.status ? state(found.status) : null, missed && element("span", { class: "note optional" }, missed)),
      element("td", { class: "optional" }, found.grains ? String(found.grains) : ""),
      element("td", { class: "optional" }, measure),
      element("td", { class: "optional" }, time && element("time", { datetime: time.toISOString() }, time.toLocaleString([], { dateStyle: "short", timeStyle: "short" }))));
  };
  const heads = head.map((text, k) => element("th", { scope: "col", class: kinds[k] }, element("span", {}, text)));
  return scrolling("What is in the folder", element("table", {},
    element("thead", {}, element("tr", {}, heads)), element("tbody", {}, rows.map(row))));
}
