// @ts-check
// The families of tests whose surrogates come with the program.

import { element, replace } from "../dom.js";
import { to } from "../router.js";
import { data } from "../server.js";

/** @type {import("../main.js").View} */
export async function families(main, _query, signal) {
  const found = await data("families", {}, signal);
  const line = (/** @type {any} */ one) => element("li", { class: "tile" },
    element("a", { href: to("family", { family: one.family, along: one.path }) }, element("b", {}, `${one.family}, ${one.path}`)), element("span", {}, one.title));
  replace(main, element("h1", {}, "Families of tests"),
    element("p", {}, "Each predicts the curves of a whole test of grains that were never simulated, with intervals, from a surrogate that comes with granum."),
    element("ul", { class: "tiles" }, found.families.map(line)));
  return "Families";
}
