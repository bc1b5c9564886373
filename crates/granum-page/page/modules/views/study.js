// @ts-check
// A study of surrogates, or a reproduction: its surrogates with their scores, and the figures of its report.

import { element, replace } from "../dom.js";
import { digits } from "../numbers.js";
import { commandLines, scrolling } from "../parts.js";
import { to } from "../router.js";
import { data } from "../server.js";
import { showFigures } from "./run.js";

/** @type {import("../main.js").View} */
export async function study(main, query, signal) {
  const path = query.get("path") ?? "";
  const found = await data("study", { path }, signal);
  const name = path.split("/").pop() || "Study";
  const figures = element("div", {});
  replace(main, element("h1", {}, name), element("p", { class: "subtitle" }, [path, found.holds].filter(Boolean).join(" · ")),
    found.next && element("p", { class: "note" }, `Next: ${found.next}`),
    element("h2", {}, "Its surrogates"),
    found.models.length > 0 ? scores(path, found) : element("p", {}, found.note ?? "It has none that are asked by their columns."),
    figures, commandLines(found.commands));
  void showFigures(figures, [path], signal);
  return name;
}

/** A share in percent. @param {number | null} share */
function percent(share) {
  return share === null ? "–" : `${digits(100 * share, 3)}\u202f%`;
}

/**
 * @param {string} path
 * @param {any} found
 */
function scores(path, found) {
  const row = (/** @type {any} */ one) => element("tr", {},
    element("th", { scope: "row", class: "word" }, found.models.includes(one.name) ? element("a", { href: to("surrogate", { path, model: one.name }) }, one.name) : one.name),
    element("td", { class: "word" }, one.method),
    [one.training, one.held_out, one.unseen, one.coverage].map(share => element("td", {}, percent(share))));
  const heads = ["surrogate", "method", "training states", "held-out states", "unseen runs", "within their intervals"];
  const caption = "Error: root mean square of the errors over that of the values. The name of a surrogate leads to its predictions.";
  return scrolling("Surrogates with their scores", element("table", {}, element("caption", {}, caption),
    element("thead", {}, element("tr", {}, heads.map((text, k) => element("th", { scope: "col", class: k < 2 ? "word" : null }, text)))),
    element("tbody", {}, found.scores.map(row))));
}
