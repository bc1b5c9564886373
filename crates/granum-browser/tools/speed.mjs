// The time of a step of a test in a browser; `in-browsers.mjs FOLDER --speed` prints it, and the case, for a run of the program beside it.

import { Engine, kind } from "../../granum-page/page/laboratory/engine.mjs";

const testOf = (grains, strain) => `grains.count = ${grains}
preparation.solid_fraction = "none"
preparation.unbalanced_force = 0.01
shear.deviator_strain = ${strain}
shear.inertial_number = 0.003
recording.states = 20
`;

/** Microseconds a step of tests of 300 and of 2000 grains, from the second piece of the test on. */
export async function speed(_, load, say) {
  const module = await kind();
  for (const [grains, strain] of [[300, 0.15], [2000, 0.03]]) {
    const engine = await Engine.from(await load(`engine.${module}`)), text = testOf(grains, strain);
    engine.call("begin", { case: text });
    let answer, milliseconds = 0, before = 0;
    do {
      const begun = performance.now();
      answer = engine.call("go_on", { milliseconds: 200 });
      const steps = answer.steps.test ?? 0;
      if (before) milliseconds += performance.now() - begun; else before = steps;
    } while (answer.status === "running");
    const steps = answer.steps.test - before;
    say(`${module}, ${grains} grains: ${((1e3 * milliseconds) / steps).toFixed(1)} microseconds a step over ${steps} steps of ${JSON.stringify(text)}`);
  }
  return 0;
}
