// @ts-check
// What a calibration found.

import { element, replace } from "../dom.js";
import { figure } from "../figure.js";
import { quantity, words } from "../numbers.js";
import { commandLines, scrolling } from "../parts.js";
import { data, figure as drawn } from "../server.js";

/** @type {import("../main.js").View} */
export async function calibration(main, query, signal) {
  const path = query.get("path") ?? "";
  const found = await data("calibration", { path }, signal);
  const name = path.split("/").pop() || "Calibration";
  const against = found.against_the_posterior ?? [];
  const figures = await Promise.all((found.figures ?? []).map(async (/** @type {string} */ file) =>
    figure(await drawn("calibration-figure", { path, name: file }, signal), words(file.replace(/\.svg$/, "").replaceAll("-", " ")), "", signal)));
  const remarks = (found.remarks ?? []).filter((/** @type {string} */ text) => !against.includes(text));
  replace(main, element("h1", {}, name), element("p", { class: "subtitle" }, [path, `tests ${(found.tests ?? []).join(", ")}`, found.found_by].filter(Boolean).join(" · ")),
    against.map((/** @type {string} */ text) => element("p", { class: "callout bad" }, text)),
    element("h2", {}, "The posterior"), parameters(found.parameters ?? []),
    remarks.map((/** @type {string} */ text) => element("p", { class: "note" }, text)),
    figures.length > 0 && element("h2", {}, "Figures"), element("div", { class: "figures" }, figures), commandLines(found.commands ?? []));
  return name;
}

/** @param {any[]} parameters */
function parameters(parameters) {
  const heads = ["parameter", "mean", "standard deviation", "5 %", "median", "95 %"];
  const row = (/** @type {any} */ one) => element("tr", {}, element("th", { scope: "row", class: "word" }, words(one.name)),
    ["mean", "standard_deviation", "quantile_5", "median", "quantile_95"].map(key => element("td", {}, quantity(one[key], one.unit ?? ""))));
  return scrolling("The posterior", element("table", {},
    element("thead", {}, element("tr", {}, heads.map((text, k) => element("th", { scope: "col", class: k === 0 ? "word" : null }, text)))),
    element("tbody", {}, parameters.map(row))));
}
