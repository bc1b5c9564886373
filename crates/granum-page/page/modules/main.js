// @ts-check
// The page: it shows the view of the present address.

import { announce, element, replace } from "./dom.js";
import { trouble } from "./parts.js";
import { present } from "./router.js";
import { takeToken } from "./server.js";
import { calibration } from "./views/calibration.js";
import { campaign } from "./views/campaign.js";
import { compare } from "./views/compare.js";
import { families } from "./views/families.js";
import { family } from "./views/family.js";
import { list } from "./views/list.js";
import { run } from "./views/run.js";
import { study } from "./views/study.js";
import { surrogate } from "./views/surrogate.js";

/**
 * A view fills an element from a query. What it asks and repeats ends with the signal.
 * @typedef {(main: Element, query: URLSearchParams, signal: AbortSignal) => Promise<string>} View
 */

/** @type {Record<string, View>} */
const VIEWS = { list, run, compare, campaign, families, family, study, surrogate, calibration, reproduction: study };

/** The parts of the page to which a view belongs. @type {Record<string, string>} */
const PARTS = { families: "families", family: "families" };

let shown = new AbortController();

async function show() {
  shown.abort();
  shown = new AbortController();
  const { signal } = shown;
  const main = /** @type {HTMLElement} */ (document.getElementById("content"));
  const { name, query } = present();
  for (const link of document.querySelectorAll("nav a")) {
    const own = link instanceof HTMLElement && link.dataset["part"] === (PARTS[name] ?? "list");
    if (own) link.setAttribute("aria-current", "page"); else link.removeAttribute("aria-current");
  }
  main.setAttribute("aria-busy", "true");
  replace(main, element("p", { class: "note" }, "Reading …"));
  const view = VIEWS[name];
  try {
    if (!view) throw new Error(`There is no part ${name} of the page.`);
    const title = await view(main, query, signal);
    if (signal.aborted) return;
    document.title = `${title} – granum`;
    announce(title);
  } catch (error) {
    if (signal.aborted) return;
    document.title = "granum";
    replace(main, element("h1", {}, "This cannot be shown"), trouble(error), element("p", {}, element("a", { href: "#/" }, "To the folder")));
  }
  main.removeAttribute("aria-busy");
}

takeToken();
document.getElementById("skip")?.addEventListener("click", event => {
  // The address behind the hash is that of a view.
  event.preventDefault();
  document.getElementById("content")?.focus();
});
addEventListener("hashchange", () => {
  scrollTo(0, 0);
  document.getElementById("content")?.focus({ preventScroll: true });
  void show();
});
void show();
