// @ts-check
// What a family predicts, as its inputs are moved.

import { announce, element, replace } from "../modules/dom.js";
import { figure } from "../modules/figure.js";
import { digits, words } from "../modules/numbers.js";
import { choice, trouble } from "../modules/parts.js";
import { familyText } from "./files.js";

/** Steps of a slider from one end of its range to the other. */
const STEPS = 100;

/**
 * Fills a section with the families, their sliders and curves.
 * @param {HTMLElement} section
 * @param {import("./main.js").Tools} tools
 * @param {(text: string, name: string, values: Record<string, number>) => void} test is given the case of what is shown
 */
export function sliders(section, tools, test) {
  const title = element("h2", {}, "A surrogate answers at once");
  const controls = element("div", {}), answer = element("div", {});
  const none = { value: "", text: "choose one" };
  const chosen = choice("Family of tests", [none, ...tools.cases.families.map(family => ({ value: family.file, text: family.title }))], "", file => void load(file));
  replace(section, title, element("div", { class: "tools" }, chosen), element("div", { class: "columns" }, controls, answer));

  /** @param {string} file */
  async function load(file) {
    if (!file) return replace(controls), replace(answer);
    replace(answer, element("p", { class: "note" }, "Loading the surrogate …"));
    try {
      const [engine, text] = await Promise.all([tools.surrogates(), familyText(file)]);
      fill(engine, file, engine.call("load_family", { name: file, text }));
      announce("The surrogate is loaded");
    } catch (error) {
      replace(controls);
      replace(answer, trouble(error));
    }
  }

  /**
   * @param {import("./engine.mjs").Engine} engine
   * @param {string} file
   * @param {any} family
   */
  function fill(engine, file, family) {
    /** @type {Record<string, number>} */
    const values = {};
    let due = false;
    let gone = new AbortController();
    const soon = () => { if (!due) { due = true; requestAnimationFrame(() => { due = false; predict(); }); } };
    const predict = () => {
      const begun = performance.now();
      const predicted = engine.call("predict", { name: file, values });
      const took = performance.now() - begun;
      gone.abort();
      gone = new AbortController();
      const outside = predicted.outside.map((/** @type {any} */ one) => words(one.name)).join(", ");
      replace(answer, figure(predicted.figure, "The predicted curves", `Fitted to ${family.runs} runs; bands hold 90 % of the states of new samples. Answered in ${Math.round(took)} ms.${predicted.extrapolated ? ` Outside of its runs${outside ? `: ${outside}` : ""}.` : ""}`, gone.signal));
      answer.dataset.milliseconds = String(took);
    };
    const slider = (/** @type {any} */ input) => {
      const [low, high] = input.range, at = (/** @type {number} */ share) => low + share * (high - low);
      values[input.name] = at(0.5);
      const output = element("output", {}, digits(at(0.5), 3));
      const range = element("input", { type: "range", min: 0, max: STEPS, value: STEPS / 2, "aria-label": `${words(input.name)}: ${input.meaning}`, oninput: () => {
        const value = at(Number(range.value) / STEPS);
        values[input.name] = value;
        output.textContent = digits(value, 3);
        range.setAttribute("aria-valuetext", digits(value, 3));
        soon();
      } });
      return element("div", { class: "slider" }, element("span", {}, input.meaning), output, range);
    };
    const begin = () => {
      const ready = tools.cases.cases.find(one => one.name === family.case);
      try {
        test(engine.call("case_of", { name: file, values, ready: ready?.text ?? "" }).case, file, { ...values });
      } catch (error) {
        replace(answer, trouble(error));
      }
    };
    replace(controls, element("p", { class: "note" }, `${family.title}. What is not asked for has a typical value, which widens the intervals.`),
      family.inputs.filter((/** @type {any} */ input) => input.required).map(slider),
      element("button", { type: "button", class: "main", onclick: begin }, "Test it"),
      element("details", {}, element("summary", {}, "What it must not be used for"), element("ul", {}, family.limits.map((/** @type {string} */ limit) => element("li", {}, limit)))));
    predict();
  }
}
