// @ts-check
// A study of surrogates, or a reproduction: the figures of its report, and its surrogates to ask.

import { element, replace } from "../dom.js";
import { to } from "../router.js";
import { data } from "../server.js";
import { showFigures } from "./run.js";

/** @type {import("../main.js").View} */
export async function study(main, query, signal) {
  const path = query.get("path") ?? "";
  const name = path.split("/").pop() || "Study";
  const figures = element("div", {}), models = element("div", {});
  replace(main, element("h1", {}, name), element("p", { class: "subtitle" }, path), models, figures);
  void showFigures(figures, [path], signal);
  try {
    const found = await data("surrogate", { path }, signal);
    const link = (/** @type {string} */ model) => element("li", {}, element("a", { href: to("surrogate", { path, model }) }, model));
    replace(models, element("h2", {}, "Its surrogates"),
      found.models.length > 0 ? element("ul", {}, found.models.map(link)) : element("p", { class: "note" }, found.note));
  } catch (error) {
    if (!signal.aborted) replace(models, element("p", { class: "note" }, error instanceof Error ? error.message : String(error)));
  }
  return name;
}
