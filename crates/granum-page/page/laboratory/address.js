// @ts-check
// A case in the address of the page: `#case=NAME` is a ready case, `#text=…` a text, deflated and in base64 of addresses. It is put into the text of the case
// and read there as what a hand has typed; nothing of it is executed, and no test begins by itself.

/** The longest text that an address may hold, in bytes. */
const MOST = 65_536;

/**
 * The case that a fragment of an address holds, or null without one.
 * @param {string} fragment
 * @param {{ name: string, text: string }[]} ready
 * @returns {Promise<{ name: string | null, text: string } | null>}
 */
export async function caseOf(fragment, ready) {
  const [, key, value] = /^#(case|text)=(.*)$/s.exec(fragment) ?? [];
  if (key === undefined || value === undefined) return null;
  if (key === "case") {
    const found = ready.find(one => one.name === value);
    if (!found) throw new Error("The address names a case that is not among the ready cases of this page.");
    return found;
  }
  try {
    return { name: null, text: await unpacked(value) };
  } catch {
    throw new Error("The address should hold a case, but its text cannot be read: it is damaged, cut short or too long.");
  }
}

/** @param {string} packed */
async function unpacked(packed) {
  const letters = atob(packed.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, letter => letter.charCodeAt(0));
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  // Piece by piece, so that a small text that becomes a huge one is refused before it does.
  const pieces = [];
  let length = 0;
  for (let piece = await reader.read(); !piece.done; piece = await reader.read()) {
    length += piece.value.length;
    if (length > MOST) { await reader.cancel(); throw new Error("too long"); }
    pieces.push(piece.value);
  }
  return new TextDecoder("utf-8", { fatal: true }).decode(await new Blob(pieces).arrayBuffer());
}
