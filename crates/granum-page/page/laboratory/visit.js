// @ts-check
// A guided first visit in five steps. Each does something in the page itself: its panel stands beside what it speaks of.

import { announce, element, replace } from "../modules/dom.js";
import { figure } from "../modules/figure.js";
import { counted, digits, words } from "../modules/numbers.js";
import { commandLines, trouble } from "../modules/parts.js";
import { familyText } from "./files.js";

/** Under this name a browser remembers that the visit was offered. */
const REMEMBERED = "granum-visit";
/** The family that is asked, and what it is asked first: the middle of its ranges, but for these. */
const FAMILY = "sand/drained-triaxial.json";
const ASKED = { friction: 0.5, rolling_friction: 0.2, stress_over_modulus: 2e-5 };
/** Grains that hardly rub: friction is outside of the runs from which the surrogate has learned. */
const OUTSIDE = { ...ASKED, friction: 0.02 };
/** What the surrogate can be told of the ready case of long grains: all but their shape. */
const OF_LONG_GRAINS = { ...ASKED, rolling_friction: 0 };
/** The grains of a test of the visit: so few that it lasts seconds. */
const GRAINS = 200;
/** The same of grains of several spheres or with bonds. */
const FEWER = 150;
/** Where intervals are told, as a share of the curve. */
const TOLD = [0.1, 0.5, 1];

/**
 * @typedef {object} Laboratory what the visit uses of the page
 * @property {import("./main.js").Tools} tools
 * @property {HTMLElement} place where the visit is offered
 * @property {HTMLElement} test the section of the test
 * @property {HTMLElement} surrogate the section of the surrogate
 * @property {() => import("./run.js").Run | undefined} run the first run
 * @property {(text: string, grains: number, asked: { name: string, values: Record<string, number> } | null) => void} begin tests a case
 */

/** @typedef {{ title: string, at: (laboratory: Laboratory) => HTMLElement, text: string[], label: string, act: (laboratory: Laboratory, answer: HTMLElement, signal: AbortSignal) => Promise<void> }} Step */

/** Whether the visit was offered before; a browser that remembers nothing is offered it again. */
function remembered() {
  try {
    return localStorage.getItem(REMEMBERED) !== null;
  } catch {
    return false;
  }
}

function remember() {
  try {
    localStorage.setItem(REMEMBERED, "offered");
  } catch {
    // It is offered again.
  }
}

/** Waits until something holds, or until the signal ends the waiting. @param {() => boolean} holds @param {AbortSignal} signal */
const until = (holds, signal) => new Promise((/** @type {(held: boolean) => void} */ done) => {
  const look = () => { if (signal.aborted || holds()) done(!signal.aborted); else setTimeout(look, 100); };
  look();
});

/**
 * The text of a ready case.
 * @param {Laboratory} laboratory
 * @param {string} name
 */
function ready(laboratory, name) {
  const found = laboratory.tools.cases.cases.find(one => one.name === name);
  if (!found) throw new Error(`This page has no case ${name}.`);
  return found.text;
}

/**
 * Tests a ready case, and says how it ends.
 * @param {Laboratory} laboratory
 * @param {HTMLElement} answer
 * @param {AbortSignal} signal
 * @param {string} name
 * @param {number} grains
 */
async function tested(laboratory, answer, signal, name, grains) {
  const text = ready(laboratory, name);
  laboratory.begin(text, grains, null);
  replace(answer, element("p", {}, "The grains are placed and compressed first, which takes longest; then they are tested. You may go on meanwhile."));
  const run = laboratory.run();
  if (!run || !(await until(() => run.ended || run.rows.length > 1, signal))) return;
  const told = run.fault ? run.fault.message : `The test is under way: its curves grow below. At its end it has a digest, which is the same on every computer.`;
  replace(answer, element("p", {}, told));
  announce(told);
}

/**
 * The surrogate of the visit, loaded.
 * @param {Laboratory} laboratory
 */
async function surrogate(laboratory) {
  const [engine, text] = await Promise.all([laboratory.tools.surrogates(), familyText(FAMILY)]);
  return { engine, family: engine.call("load_family", { name: FAMILY, text }) };
}

/** @param {Laboratory} laboratory @param {HTMLElement} answer @param {AbortSignal} signal */
async function sensor(laboratory, answer, signal) {
  if (!laboratory.run()) laboratory.begin(ready(laboratory, "drained-dense"), GRAINS, null);
  replace(answer, element("p", {}, "Waiting for the first states of the test …"));
  const run = laboratory.run();
  if (!run || !(await until(() => run.ended || run.points("axial_strain", "coordination_number").length > 8, signal))) return;
  if (run.fault) throw new Error(run.fault.message);
  const points = run.points("axial_strain", "coordination_number"), ratio = run.points("axial_strain", "stress_ratio");
  const [first, last, strength] = [points[0], points[points.length - 1], ratio[ratio.length - 1]];
  if (!first || !last || !strength) throw new Error("This test has no coordination number over the axial strain. Begin the visit again, and start the test of its first step.");
  const engine = await laboratory.tools.surrogates();
  const panels = [{ x: "axial strain", y: "coordination number", curves: [{ name: run.name, points }] }];
  const told = `A grain touches ${digits(first[1], 3)} others on average in the sample, and ${digits(last[1], 3)} at an axial strain of ${digits(100 * last[0], 2)} %, where the stress ratio q/p is ${digits(strength[1], 3)}. No cell of a soil laboratory can count that.`;
  replace(answer, element("p", {}, told), figure(engine.call("curves", { panels }).figure, "The coordination number of the test", "Contacts of a grain, over the strain of the test so far.", signal));
  announce(told);
}

/** @param {Laboratory} laboratory @param {HTMLElement} answer */
async function knows(laboratory, answer) {
  replace(answer, element("p", {}, "Loading the surrogate …"));
  const select = laboratory.surrogate.querySelector("select");
  if (select) { select.value = FAMILY; select.dispatchEvent(new Event("change")); }
  const { engine, family } = await surrogate(laboratory);
  const begun = performance.now();
  const predicted = engine.call("predict", { name: FAMILY, values: ASKED });
  const took = Math.round(performance.now() - begun);
  const curve = curveOf(predicted, "stress_ratio");
  const rows = TOLD.map(share => {
    const k = Math.round(share * (predicted.points.length - 1));
    return element("li", {}, `at an axial strain of ${digits(100 * predicted.points[k], 2)} % the stress ratio q/p is ${digits(curve.mean[k], 3)}, and for nine of ten samples between ${digits(curve.lower[k], 3)} and ${digits(curve.upper[k], 3)}`);
  });
  replace(answer, element("p", {}, `It has learned from ${family.runs} tests and answers in ${took} ms, for a sand of friction ${ASKED.friction} and rolling friction ${ASKED.rolling_friction}:`),
    element("ul", {}, rows), element("p", {}, "Move its sliders below: the curves follow."));
  announce("The surrogate has answered");
}

/** @param {Laboratory} laboratory @param {HTMLElement} answer @param {AbortSignal} signal */
async function wrong(laboratory, answer, signal) {
  replace(answer, element("p", {}, "Asking the surrogate …"));
  const { engine } = await surrogate(laboratory);
  const [within, far, round] = [ASKED, OUTSIDE, OF_LONG_GRAINS].map(values => engine.call("predict", { name: FAMILY, values }));
  const half = (/** @type {any} */ one) => { const curve = curveOf(one, "stress_ratio"), k = curve.mean.length - 1; return digits((curve.upper[k] - curve.lower[k]) / 2, 2); };
  const outside = far.outside.map((/** @type {any} */ one) => `${words(one.name)} is ${digits(one.value, 2)}, and its runs have ${digits(one.range[0], 2)} to ${digits(one.range[1], 2)}`).join("; ");
  const said = [
    element("p", {}, `Asked outside of its runs, it says so: ${outside}. Its interval of the stress ratio at the end is ± ${half(far)} there, and ± ${half(within)} for the sand of the step before.`),
    element("p", {}, "But it is told nothing of the shape of grains. The test of long grains is under way below, over what it says of round ones with the same friction, which it does not flag."),
  ];
  replace(answer, said);
  // With the law of the family for rolling, which does nothing at a friction of zero: the test differs in shape alone.
  const values = { "contact.rolling": "elastic-plastic", "contact.rolling_friction": "0" };
  laboratory.begin(laboratory.tools.engine.call("with", { case: ready(laboratory, "long-grains"), values }).case, GRAINS, { name: FAMILY, values: OF_LONG_GRAINS });
  const run = laboratory.run();
  if (!run || !(await until(() => run.ended, signal))) return;
  if (run.fault) throw new Error(run.fault.message);
  const held = share(run.points("axial_strain", "stress_ratio"), round, "stress_ratio");
  const part = held.within / Math.max(1, held.of);
  const told = `Of ${counted(held.of, "state")} of the test of long grains, ${held.within} (${Math.round(100 * part)} %) have a stress ratio within the interval that should hold 90 %; at worst it is off by ${digits(held.worst, 2)}. ` +
    (part < 0.8 ? "So the surrogate is wrong here, and does not know it. " : "So shape mattered little here. ") +
    `A part of it is chance: ${GRAINS} grains scatter more than the 1000 of which the intervals speak. “Test it” with 1000 grains tells them apart.`;
  replace(answer, said, element("p", { class: "callout" }, told));
  announce(told);
}

/** @param {any} predicted @param {string} column */
const curveOf = (predicted, column) => predicted.curves.find((/** @type {any} */ one) => one.column === column);

/**
 * How many points of a curve lie within the interval of a prediction, and how far the farthest is from its mean.
 * @param {[number, number][]} points
 * @param {{ points: number[], curves: { column: string, mean: number[], lower: number[], upper: number[] }[] }} predicted
 * @param {string} column
 */
export function share(points, predicted, column) {
  const curve = predicted.curves.find(one => one.column === column), xs = predicted.points;
  let [within, of, worst] = [0, 0, 0];
  for (const [x, y] of points) {
    const k = xs.findIndex(one => one >= x);
    if (!curve || k < 1) continue;
    const [from, to] = [/** @type {number} */ (xs[k - 1]), /** @type {number} */ (xs[k])];
    const at = (/** @type {number[]} */ ys) => Number(ys[k - 1]) + ((x - from) / (to - from)) * (Number(ys[k]) - Number(ys[k - 1]));
    of += 1;
    if (y >= at(curve.lower) && y <= at(curve.upper)) within += 1;
    worst = Math.max(worst, Math.abs(y - at(curve.mean)));
  }
  return { within, of, worst };
}

/** @type {Step[]} */
const STEPS = [
  { title: "What a test is", at: laboratory => laboratory.test,
    text: ["Grains are put into a box without walls, pressed together, and then sheared slowly: here along the path of a drained triaxial test. Every contact of every grain is computed, and the forces between them add up to the stress of the sample.",
      "Colours show how hard grains are pressed. Turn the sample with the mouse or the arrow keys."],
    label: "Start a small test", act: (laboratory, answer, signal) => tested(laboratory, answer, signal, "drained-dense", GRAINS) },
  { title: "What a soft sensor is", at: laboratory => laboratory.test,
    text: ["An apparatus measures stress and strain at the ends of a sample. Inside of a computed one anything can be measured: such a quantity is a soft sensor. The coordination number, the mean number of contacts of a grain, is the simplest; others are the fabric, the share of contacts that slide, and the distribution of contact forces."],
    label: "Show the coordination number", act: sensor },
  { title: "What the surrogate knows", at: laboratory => laboratory.surrogate,
    text: ["A surrogate has learned from hundreds of such tests what follows from friction, stress and packing. It answers at once, and says how sure it is: a band should hold 90 % of the states of new samples."],
    label: "Ask the surrogate", act: knows },
  { title: "Where it is wrong", at: laboratory => laboratory.test,
    text: ["It knows the grains of its runs and no others. Here it is asked for grains much smoother than any of them, and then for grains of which it cannot be told what matters. The real test is made beside it: its line leaves the bands or stays in them while you look."],
    label: "Ask too much, and test it", act: wrong },
  { title: "What to do next", at: laboratory => laboratory.test,
    text: ["Grains need not be round, and they can be cemented. Two of the ready cases show that; take any of them, change its text, and press “Test it”. What is tested here has the same bits in the program, which is faster by several times and knows campaigns, studies and calibrations:"],
    label: "Test bedded grains", act: (laboratory, answer, signal) => tested(laboratory, answer, signal, "bedded-grains", FEWER) },
];

/**
 * Offers the visit: with a sentence where it is new, else as a button alone.
 * @param {Laboratory} laboratory
 */
export function offer(laboratory) {
  const begin = element("button", { type: "button", id: "visit-begin", onclick: () => visit(laboratory, begin) }, "Guided visit in five steps");
  if (remembered()) return replace(laboratory.place, begin);
  const later = () => { remember(); replace(laboratory.place, begin); begin.focus(); };
  begin.className = "main";
  replace(laboratory.place, element("div", { class: "callout" },
    element("p", {}, "New here? Five steps show what a test is, what a soft sensor is, what a surrogate knows, where it is wrong, and what to do next. Nothing else waits for it."),
    element("div", { class: "tools" }, begin, element("button", { type: "button", id: "visit-later", onclick: later }, "Not now"))));
}

/**
 * The visit, from its first step on.
 * @param {Laboratory} laboratory
 * @param {HTMLButtonElement} begin to which the focus returns
 */
function visit(laboratory, begin) {
  remember();
  document.getElementById("visit")?.remove();
  begin.className = "";
  replace(laboratory.place, begin);
  const panel = element("section", { id: "visit", class: "visit", "aria-labelledby": "visit-title", onkeydown: (/** @type {KeyboardEvent} */ event) => { if (event.key === "Escape") end(); } });
  let gone = new AbortController();
  const end = () => { gone.abort(); panel.remove(); begin.focus(); begin.scrollIntoView({ block: "nearest" }); announce("The visit has ended"); };

  /** @param {number} number from 0 */
  function show(number) {
    const step = STEPS[number];
    if (!step) return end();
    gone.abort();
    gone = new AbortController();
    const { signal } = gone;
    const title = element("h3", { id: "visit-title", tabindex: "-1" }, `${number + 1} of ${STEPS.length}: ${step.title}`);
    const answer = element("div", { class: "visit-answer" });
    const carry = (/** @type {Step["act"]} */ act) => async () => {
      delete panel.dataset.done;
      try {
        await act(laboratory, answer, signal);
      } catch (error) {
        if (!signal.aborted) replace(answer, trouble(error));
      }
      if (!signal.aborted) panel.dataset.done = String(number + 1);
    };
    const button = (/** @type {string} */ label, /** @type {() => unknown} */ onclick, /** @type {Record<string, unknown>} */ more = {}) => element("button", { type: "button", onclick, ...more }, label);
    const last = number === STEPS.length - 1;
    delete panel.dataset.done;
    replace(panel, title, step.text.map(text => element("p", {}, text)), last ? next() : null,
      element("div", { class: "tools" }, button(step.label, carry(step.act), { class: "main", id: "visit-act" }),
        last ? button("Break bonds", carry((of, place, ends) => tested(of, place, ends, "cemented-sand", FEWER)), { id: "visit-bonds" }) : null),
      answer,
      element("div", { class: "tools" }, button("Back", () => show(number - 1), { disabled: number === 0, id: "visit-back" }),
        last ? null : button("Next step", () => show(number + 1), { id: "visit-next" }), button("End the visit", end, { id: "visit-end" })));
    const place = step.at(laboratory), heading = place.querySelector("h2");
    if (heading) heading.after(panel);
    else place.prepend(panel);
    title.focus({ preventScroll: true });
    panel.scrollIntoView({ block: "start" });
  }
  show(0);
}

/** What the program does with the same case. */
function next() {
  return commandLines([
    { what: "The same test, with the digest of this page", command: "granum init --case drained-dense && granum run drained-dense.toml" },
    { what: "The surrogate, with its intervals and a test beside it", command: "granum predict --family sand --friction 0.5 --rolling-friction 0.2 --pressure \"100 kPa\" --check" },
    { what: "All sensors, with their meanings", command: "granum measure --list" },
  ], "In the program");
}
