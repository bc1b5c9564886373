// Compares what the modules compute with the digests that the program keeps. It runs in node and in browsers.

import { CallFailed, Engine, kind } from "../../granum-page/page/laboratory/engine.mjs";

const CASES = "crates/granum/tests/end_to_end/sixteen_cases/";
const FAMILIES = "crates/granum/families/";

/** The files that one of the cases names. */
const FILES = [".obj", ".tif", "-sieve.csv", "-history.csv"].map(ending => `files-of-the-case${ending}`);

/** Bytes in base64. @param {Uint8Array} bytes */
const base64 = bytes => btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(""));

/** Lines of `digest  name` as a map from name to digest. */
const listed = text => new Map(text.trim().split("\n").map(line => line.split("  ").reverse()));

/** The run of a case in pieces until its end. */
function run(engine, text) {
  engine.call("begin", { case: text });
  let answer;
  do answer = engine.call("go_on", { milliseconds: 50 });
  while (answer.status === "running");
  if (answer.status !== "finished") throw new Error(`the run has ${answer.status}`);
}

/**
 * Compares runs, and where there is a second module predictions and trainings.
 * @param {(path: string) => Promise<Uint8Array>} bytes a file of the repository
 * @param {(name: string) => Promise<BufferSource | null>} load a module, by its name; null where it was not built
 * @param {(line: string) => void} say
 * @param {{ exact?: boolean, names?: string[] }} choices
 * @returns {Promise<number>} how many digests differ
 */
export async function compare(bytes, load, say, { exact = false, names = [] } = {}) {
  const read = async (/** @type {string} */ path) => new TextDecoder().decode(await bytes(path));
  const own = await kind(), module = exact ? "exact" : own;
  say(`this browser is given the module ${own}; compared is ${module}`);
  let different = 0;
  const judge = (name, digest, kept, seconds) => {
    const same = digest === kept;
    if (!same) different += 1;
    say(`${same ? "the same bits" : `DIFFERENT (${digest})`}  ${name}  ${seconds.toFixed(2)} s`);
  };
  const timed = async work => { const begun = performance.now(); const result = await work(); return [result, (performance.now() - begun) / 1e3]; };
  const kept = listed(await read(`${CASES}digests.txt`));
  const code = await load(`engine.${module}`);
  if (!code) throw new Error(`there is no module engine.${module}`);
  const compiled = await WebAssembly.compile(code);
  let result = null;
  const second = await load(`surrogates.${module}`), surrogates = second && (await Engine.from(second));
  const files = Object.fromEntries(await Promise.all(FILES.map(async name => [name, base64(await bytes(`${CASES}${name}`))])));
  surrogates?.call("files", { files });
  for (const name of names.length ? names : kept.keys()) {
    const engine = await Engine.from(compiled), own = await read(`${CASES}${name}.toml`), has = FILES.some(file => file.startsWith(name));
    if (has && !surrogates) { say(`without the module of the surrogates the files of ${name} are not read`); continue; }
    // The second module reads the files; the case then has their content.
    const text = has ? surrogates.call("with", { case: own, values: {} }).case : own;
    const [digest, seconds] = await timed(() => { run(engine, text); return engine.call("digest").digest; });
    judge(name, digest, kept.get(name), seconds);
    if (name === "drained-triaxial") result = engine.call("result");
  }
  try {
    (await Engine.from(compiled)).call("begin", { case: "[grains]\ncount = -1\n" });
    different += 1;
    say("DIFFERENT: a case with a mistake was taken");
  } catch (error) {
    if (!(error instanceof CallFailed) || error.places[0]?.line !== 2) throw error;
  }
  if (!surrogates || !result) return different;
  for (const [name, digest] of listed(await read("crates/granum-browser/tests/digests.txt"))) {
    const [found, seconds] = await timed(async () => {
      if (!name.endsWith(".json")) {
        return surrogates.call("digest_of_training", { method: name, result, input: "deviator_strain", output: "stress_ratio" }).digest;
      }
      surrogates.call("load_family", { name, text: await read(`${FAMILIES}${name}`) });
      return surrogates.call("digest_of_predictions", { name }).digest;
    });
    judge(name, found, digest, seconds);
  }
  return different;
}
