// @ts-check
// The files beside the page, the only ones that it loads.

/** @typedef {{ cases: { name: string, title: string, text: string }[], families: { file: string, title: string }[] }} Catalogue */

/** @param {string} path */
async function file(path) {
  const answer = await fetch(new URL(`../${path}`, import.meta.url));
  if (!answer.ok) throw new Error(`The file ${path} of this page cannot be loaded (${answer.status}).`);
  return answer;
}

/** The ready cases and the families. @returns {Promise<Catalogue>} */
export const catalogue = async () => (await file("catalogue.json")).json();

/**
 * A module of WebAssembly.
 * @param {string} name
 */
export const compiled = async name => WebAssembly.compile(await (await file(`${name}.wasm`)).arrayBuffer());

/**
 * The text of a fitted family.
 * @param {string} path
 */
export const familyText = async path => (await file(`families/${path}`)).text();
