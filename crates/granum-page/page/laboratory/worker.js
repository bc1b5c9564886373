// @ts-check
// A run in a worker of its own: it goes on a piece at a time, and tells the page after each what is new.

import { CallFailed, Engine } from "./engine.mjs";

/** Time from one picture to the next, ms: thirty a second, and something for what comes between. */
const PICTURE = 29;
/** The least time of a piece, ms: so much of each picture is computed at least. */
const LEAST = 12;
/** The most forces of a picture of a run under way. */
const FORCES = 2500;

/** @type {Engine | null} */
let engine = null;
let goes = false;
let told = 0;
/** When the last piece of a run that goes on began, and how long it computed, ms; the rest of the time was for its picture and for the page. */
let begun = 0;
let computed = 0;

/** @param {Record<string, unknown>} message */
const tell = message => postMessage(message);

/** @param {unknown} error */
function failed(error) {
  goes = false;
  tell({ kind: "failed", message: error instanceof Error ? error.message : String(error), places: error instanceof CallFailed ? error.places : [] });
}

/** One piece, and what it has found. @param {boolean} shows */
function piece(shows) {
  if (!engine) return;
  const start = performance.now(), rest = begun > 0 ? start - begun - computed : 0;
  const answer = engine.call("go_on", { milliseconds: Math.max(LEAST, PICTURE - rest) });
  [begun, computed] = [start, performance.now() - start];
  const found = answer.states > told ? engine.call("states", { from: told }) : null;
  told = answer.states;
  const ended = answer.status !== "running";
  tell({ kind: "piece", answer, found, view: shows || ended ? engine.call("view", { strongest: FORCES }) : null,
    digest: ended ? engine.call("digest").digest : null });
  if (ended) goes = false;
}

function goOn() {
  if (!goes) return;
  try {
    piece(true);
  } catch (error) {
    failed(error);
  }
  // So that messages of the page come in between.
  if (goes) setTimeout(goOn);
}

addEventListener("message", async ({ data }) => {
  try {
    switch (data.kind) {
      case "begin":
        engine = await Engine.from(data.module);
        told = 0;
        tell({ kind: "begun", ...engine.call("begin", { case: data.case }), view: engine.call("view", { strongest: FORCES }) });
        break;
      case "go":
        if (!goes) { goes = true; begun = 0; goOn(); }
        break;
      case "pause":
        goes = false;
        break;
      case "piece":
        goes = false;
        begun = 0;
        piece(true);
        break;
      case "result":
        tell({ kind: "result", of: data.of, result: engine?.call("result", { assemblies: data.assemblies ?? false }) });
        break;
      case "saved":
        tell({ kind: "saved", of: data.of, run: engine?.call("saved").run });
        break;
      case "series":
        tell({ kind: "series", of: data.of, csv: engine?.call("series").csv });
        break;
    }
  } catch (error) {
    failed(error);
  }
});
