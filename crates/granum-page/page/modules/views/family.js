// @ts-check
// A family: what is asked, and the curves that it predicts.

import { announce, element, replace } from "../dom.js";
import { figure } from "../figure.js";
import { quantity, words } from "../numbers.js";
import { commandLines, scrolling, trouble } from "../parts.js";
import { data } from "../server.js";

/** @type {import("../main.js").View} */
export async function family(main, query, signal) {
  const of = { family: query.get("family") ?? undefined, along: query.get("along") ?? undefined, path: query.get("path") ?? undefined };
  const found = await data("family", of, signal);
  const answer = element("div", { "aria-live": "polite" });
  /** @type {Map<string, HTMLInputElement>} */
  const inputs = new Map();
  const field = (/** @type {any} */ property) => {
    const input = element("input", { type: "text", name: property.flag, autocomplete: "off", spellcheck: "false", value: query.get(property.flag) ?? "",
      placeholder: property.unit ? `e.g. ${example(property)}` : "" });
    inputs.set(property.flag, input);
    const range = property.range ? `the runs have ${quantity(property.range[0], property.unit)} to ${quantity(property.range[1], property.unit)}` : property.unit ? `with its unit, e.g. ${example(property)}` : "";
    return element("label", { class: "field" }, words(property.name), input, element("small", {}, range));
  };
  const predict = async (/** @type {Event} */ event) => {
    event.preventDefault();
    const given = Object.fromEntries([...inputs].map(([flag, input]) => [flag, input.value || undefined]));
    replace(answer, element("p", { class: "note" }, "Predicting …"));
    try {
      const predicted = await data("predict-family", { ...of, ...given }, signal);
      replace(answer, answered(predicted, signal));
      announce("The curves are predicted");
    } catch (error) {
      if (!signal.aborted) replace(answer, trouble(error));
    }
  };
  const title = `${found.family}, ${found.path}`;
  replace(main, element("h1", {}, title), element("p", { class: "subtitle" }, `${found.title} · fitted to ${found.runs} runs`),
    found.about.map((/** @type {string} */ text) => element("p", {}, text)),
    element("form", { onsubmit: predict, "aria-label": "What is known of the test" },
      element("h2", {}, "What is known of the test"),
      element("p", { class: "note" }, "Leave out what is not known: the answer is then for all grains of the family, or for a typical sample, and its intervals are wider."),
      element("div", { class: "form" }, found.properties.map(field)),
      element("button", { type: "submit", class: "main" }, "Predict")),
    answer, ranges(found.inputs),
    element("details", {}, element("summary", {}, "What it must not be used for"),
      element("ul", {}, found.limits.map((/** @type {string} */ text) => element("li", {}, text)))),
    commandLines(found.commands, "How good it is"));
  return title;
}

/** A value of a property. @param {{ flag: string, unit: string }} property */
function example({ flag, unit }) {
  return flag === "--youngs-modulus" ? "2 GPa" : { Pa: "100 kPa", m: "10 um", "J/m2": "0.02 J/m2" }[unit] ?? unit;
}

/**
 * @param {any} predicted
 * @param {AbortSignal} signal
 */
function answered(predicted, signal) {
  const input = (/** @type {any} */ one) => {
    const spread = one.deviation ? ` ± ${quantity(one.deviation, "", 2)}` : one.range ? ` (${quantity(one.range[0])} to ${quantity(one.range[1])})` : "";
    return element("li", {}, `${words(one.name)} = ${quantity(one.value, "", 3)}${spread}, ${one.source}`);
  };
  const caption = `Curves of a test with bands that should contain ${Math.round(100 * predicted.level)} % of the states of new samples.`;
  return [element("h2", {}, "The predicted curves"),
    ...predicted.warnings.map((/** @type {string} */ text) => element("p", { class: "callout bad" }, text)),
    figure(predicted.svg, predicted.title, caption, signal),
    element("details", {}, element("summary", {}, "What the answer is made of"), element("ul", {}, predicted.inputs.map(input))),
    element("details", {}, element("summary", {}, "The curves as a table"), table(predicted)),
    commandLines(predicted.commands)];
}

/** Rows of the table of curves. */
const ROWS = 25;

/** @param {any} predicted */
function table(predicted) {
  const curves = predicted.curves.filter((/** @type {any} */ curve) => !/_[\d.]+$/.test(curve.column));
  const step = Math.max(1, Math.ceil(predicted.points.length / ROWS));
  const rows = predicted.points.map((/** @type {any} */ point, /** @type {number} */ row) => ({ point, row }))
    .filter((/** @type {any} */ _, /** @type {number} */ row) => row % step === 0 || row === predicted.points.length - 1);
  const cells = (/** @type {number} */ row) => curves.map((/** @type {any} */ curve) =>
    element("td", {}, `${quantity(curve.mean[row], "", 3)} (${quantity(curve.lower[row], "", 3)} to ${quantity(curve.upper[row], "", 3)})`));
  return scrolling("The predicted curves as a table", element("table", {},
    element("caption", {}, "Mean, and the ends of the interval of 90 %"),
    element("thead", {}, element("tr", {}, element("th", { scope: "col", class: "word" }, words(predicted.coordinate)),
      curves.map((/** @type {any} */ curve) => element("th", { scope: "col" }, words(curve.column))))),
    element("tbody", {}, rows.map((/** @type {any} */ { point, row }) => element("tr", {}, element("th", { scope: "row", class: "word" }, quantity(point, "", 3)), cells(row))))));
}

/** @param {any[]} inputs */
function ranges(inputs) {
  const row = (/** @type {any} */ input) => element("tr", {},
    element("th", { scope: "row", class: "word" }, words(input.name)), element("td", { class: "word long" }, input.meaning),
    element("td", {}, `${quantity(input.range[0], "", 3)} to ${quantity(input.range[1], "", 3)}`));
  return element("details", {}, element("summary", {}, "Its inputs and their ranges"), scrolling("Inputs and their ranges", element("table", {},
    element("thead", {}, element("tr", {}, ["input", "what it is"].map(text => element("th", { scope: "col", class: "word" }, text)), element("th", { scope: "col" }, "range of the runs"))),
    element("tbody", {}, inputs.map(row)))));
}
