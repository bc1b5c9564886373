// @ts-check
// Several runs over each other.

import { element, replace } from "../dom.js";
import { counted } from "../numbers.js";
import { commandLines, table } from "../parts.js";
import { to } from "../router.js";
import { data } from "../server.js";
import { showFigures } from "./run.js";

/** @type {import("../main.js").View} */
export async function compare(main, query, signal) {
  const paths = query.getAll("path");
  const found = await data("compare", { path: paths }, signal);
  const figures = element("div", {});
  const address = (/** @type {number} */ row) => to("run", { path: found.paths[row] });
  const title = counted(found.paths.length, "run");
  replace(main, element("h1", {}, title), element("p", { class: "subtitle" }, "over each other"),
    table("The keys in which the runs differ, and their main results", found.columns, address), figures, commandLines(found.commands));
  void showFigures(figures, paths, signal);
  return title;
}
