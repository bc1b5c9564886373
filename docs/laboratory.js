// Adds "Open in the laboratory" to every example that is a whole case and to every ready case of the book, where the laboratory is published beside it.

(() => {
  /** Where the laboratory's folder is, seen from that of the book: `scripts/page` puts the book into a folder of it. */
  const PAGE = "../";
  /** What makes an example a whole case: its grains and its test. */
  const GRAINS = /^\s*\[+grains/m, TEST = /^\s*(\[shear\]|\[\[stage\]\])/m;

  const page = new URL((typeof path_to_root === "string" ? path_to_root : "") + PAGE, document.baseURI);

  /** A text as an address can hold it: deflated, in letters that need no escape. */
  async function packed(text) {
    const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    return btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
  }

  function button(fragment, what) {
    const link = document.createElement("a");
    link.href = new URL(`laboratory/#${fragment}`, page).href;
    link.className = "laboratory";
    link.textContent = "Open in the laboratory";
    link.setAttribute("aria-label", `Open in the laboratory: ${what}`);
    const line = document.createElement("p");
    line.append(link);
    return line;
  }

  async function add() {
    if (!page.protocol.startsWith("http")) return;
    const answer = await fetch(new URL("catalogue.json", page));
    if (!answer.ok) return;
    const ready = new Set((await answer.json()).cases.map(one => one.name));
    for (const code of document.querySelectorAll("main p > code")) {
      const name = /^granum init --case ([\w-]+)$/.exec(code.textContent)?.[1];
      if (name && ready.has(name) && code.parentElement.textContent.trim() === code.textContent) code.parentElement.after(button(`case=${name}`, `the ready case ${name}`));
    }
    if (typeof CompressionStream !== "function") return;
    let number = 0;
    for (const code of document.querySelectorAll("main pre > code.language-toml")) {
      const text = code.textContent;
      if (GRAINS.test(text) && TEST.test(text)) code.closest("pre").after(button(`text=${await packed(text)}`, `example ${++number} of this page`));
    }
  }

  // A book without the laboratory beside it stays as it is.
  add().catch(() => {});
})();
