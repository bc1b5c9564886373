// @ts-check
// The elements that the viewer of grains fills, under the names that it knows.

import { element } from "./dom.js";

/**
 * A canvas with its panel.
 * @param {string} title
 */
export function stage(title) {
  const box = (/** @type {string} */ id, /** @type {string} */ text, checked = false) =>
    element("label", {}, element("input", { type: "checkbox", id, checked }), text);
  const slider = (/** @type {string} */ id, /** @type {number} */ min, /** @type {number} */ value) =>
    element("label", {}, id, element("input", { type: "range", id, min, max: 1, step: 0.01, value }));
  const label = `${title}: turn with the mouse or the arrow keys, nearer and farther with the wheel or plus and minus`;
  return element("div", { id: "stage" },
    element("canvas", { id: "view", tabindex: "0", role: "img", "aria-label": label }),
    element("div", { id: "panel" },
      box("grains", "grains", true), slider("opacity", 0, 0.25), slider("size", 0.1, 1), slider("cut", 0, 0),
      box("forces", "forces", true), box("chains", "force chains alone"), box("bonds", "bonds", true), box("cracks", "cracks", true),
      element("div", { class: "scale" }, element("div", { id: "scale" }),
        element("div", { id: "ends" }, element("span", { id: "low" }), element("span", { id: "name" }), element("span", { id: "high" }))),
      element("p", { id: "note" })));
}
