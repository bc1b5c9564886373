// @ts-check
// A surrogate of one's own: a row of inputs, its prediction, and the curves along an input.

import { announce, element, replace } from "../dom.js";
import { figure } from "../figure.js";
import { quantity, words } from "../numbers.js";
import { choice, commandLines, scrolling, trouble } from "../parts.js";
import { to } from "../router.js";
import { data } from "../server.js";

/** @type {import("../main.js").View} */
export async function surrogate(main, query, signal) {
  const of = { path: query.get("path") ?? "", model: query.get("model") ?? undefined };
  const found = await data("surrogate", of, signal);
  const answer = element("div", {});
  /** @type {Map<string, HTMLInputElement | HTMLSelectElement>} */
  const inputs = new Map();
  const field = (/** @type {any} */ input) => {
    const middle = input.range ? Number((0.5 * (input.range[0] + input.range[1])).toPrecision(4)) : "";
    const box = element("input", { type: "number", step: "any", required: true, value: middle });
    inputs.set(input.name, box);
    const range = input.range ? `${quantity(input.range[0], input.unit)} to ${quantity(input.range[1], input.unit)}` : "the range is not known";
    return element("label", { class: "field" }, input.unit ? `${words(input.name)} (${input.unit})` : words(input.name), box, element("small", {}, range));
  };
  const word = (/** @type {any} */ category) => {
    const select = element("select", {}, category.words.map((/** @type {string} */ text) => element("option", { value: text }, text)));
    inputs.set(category.name, select);
    return element("label", { class: "field" }, words(category.name), select);
  };
  const ranged = found.inputs.filter((/** @type {any} */ input) => input.range);
  let along = found.has_memory ? undefined : ranged[0]?.name;
  const predict = async (/** @type {Event | undefined} */ event = undefined) => {
    event?.preventDefault();
    const set = Object.fromEntries([...inputs].map(([name, input]) => [`set.${name}`, input.value]));
    try {
      const predicted = await data("predict", { ...of, ...set, along }, signal);
      replace(answer, answered(predicted, signal));
      announce("Predicted");
    } catch (error) {
      if (!signal.aborted) replace(answer, trouble(error));
    }
  };
  const title = found.model ?? of.path.split("/").pop() ?? "Surrogate";
  replace(main, element("h1", {}, title), element("p", { class: "subtitle" }, `${found.method} · ${of.path}`),
    found.models.length > 1 && element("div", { class: "tools" }, choice("Surrogate", found.models.map((/** @type {string} */ value) => ({ value, text: value })), found.model,
      model => { location.hash = to("surrogate", { path: of.path, model }); })),
    element("form", { onsubmit: predict, "aria-label": "Inputs" }, element("h2", {}, "Inputs"),
      element("div", { class: "form" }, found.inputs.map(field), found.words.map(word)),
      element("div", { class: "tools" },
        along && choice("Curves along", ranged.map((/** @type {any} */ input) => ({ value: input.name, text: words(input.name) })), along, name => { along = name; void predict(); }),
        element("button", { type: "submit", class: "main" }, "Predict"))),
    answer);
  return title;
}

/**
 * @param {any} predicted
 * @param {AbortSignal} signal
 */
function answered(predicted, signal) {
  const row = (/** @type {any} */ output) => element("tr", {}, element("th", { scope: "row", class: "word" }, words(output.name)),
    element("td", {}, quantity(output.mean, output.unit)),
    element("td", {}, output.lower === null ? "–" : `${quantity(output.lower, output.unit)} to ${quantity(output.upper, output.unit)}`));
  const heads = ["output", "mean", "interval of 90 %"].map((text, k) => element("th", { scope: "col", class: k === 0 ? "word" : null }, text));
  return [element("h2", {}, "The prediction"),
    ...predicted.warnings.map((/** @type {string} */ text) => element("p", { class: "callout bad" }, text)),
    scrolling("The prediction", element("table", {}, element("thead", {}, element("tr", {}, heads)), element("tbody", {}, predicted.outputs.map(row)))),
    predicted.svg ? figure(predicted.svg, predicted.title, "The other inputs have the values above. The band should contain 90 % of the states of unseen runs.", signal) : null,
    commandLines(predicted.commands)];
}
