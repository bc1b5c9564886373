// @ts-check
// The networks of a mapping in a worker of their own: training takes seconds, in which the page goes on.

import { CallFailed, Engine } from "./engine.mjs";

/** @type {Engine | null} */
let engine = null;

addEventListener("message", async ({ data }) => {
  try {
    engine ??= await Engine.from(data.module);
    postMessage({ of: data.of, answer: engine.call(data.call, data.more) });
  } catch (error) {
    postMessage({ of: data.of, fault: error instanceof CallFailed || error instanceof Error ? error.message : String(error) });
  }
});
