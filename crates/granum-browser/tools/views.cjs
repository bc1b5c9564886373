// What laboratory.cjs asks of the guided visit, of the view of the paper's mappings, of cases in addresses and of the files that a case names, each at 1280 and 390 pixels.

const fs = require("fs"), path = require("path"), zlib = require("zlib");

const WIDTHS = [1280, 390];
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

/** No violations of axe in light and in dark colours, and nothing wider than the window. */
async function looked(page, name, { expect, shots, width }) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  expect(wide <= width, `no scrolling sideways: ${name} at ${width} pixels`);
  await page.evaluate(axe);
  for (const colorScheme of ["dark", "light"]) {
    await page.emulateMedia({ colorScheme });
    const found = await page.evaluate(() => globalThis.axe.run().then(result => result.violations.map(one => `${one.id}: ${one.nodes[0]?.html.slice(0, 120)}`)));
    expect(found.length === 0, `axe: ${name} at ${width} pixels, ${colorScheme} ${found.join("; ")}`);
    await page.screenshot({ path: `${shots}/${name}-${width}-${colorScheme}.png`, fullPage: true });
  }
}

/** Tabs to an element, as a hand on the keyboard would. */
async function tabTo(page, id) {
  for (let k = 0; k < 60; k++) {
    if (await page.evaluate(id => document.activeElement?.id === id, id)) return;
    await page.keyboard.press("Tab");
  }
  throw new Error(`the keyboard does not come to #${id}`);
}

const press = async (page, id) => { await tabTo(page, id); await page.keyboard.press("Enter"); };
const focused = page => page.evaluate(() => document.activeElement?.id);

/** The five steps of the visit, by keyboard alone. */
async function visit({ browser, url, expect, watch, shots }) {
  for (const width of WIDTHS) {
    const context = await browser.newContext({ viewport: { width, height: 900 } });
    const page = await context.newPage();
    watch(page);
    const where = { expect, shots, width };
    await page.goto(`${url}laboratory/`);
    await page.waitForSelector("#visit-later", { timeout: 60_000 });
    expect((await focused(page)) !== "visit-begin", `the visit is offered and does not take the focus, at ${width} pixels`);
    await looked(page, "visit-offered", where);
    await press(page, "visit-begin");
    for (let step = 1; step <= 5; step++) {
      expect((await focused(page)) === "visit-title", `step ${step} has the focus, at ${width} pixels`);
      expect((await page.textContent("#visit-title")).startsWith(`${step} of 5`), `step ${step} is shown`);
      await press(page, "visit-act");
      await page.waitForSelector(`#visit[data-done="${step}"]`, { timeout: 240_000 });
      const said = await page.textContent(".visit-answer");
      expect(!(await page.$("#visit .callout.bad")) && said.length > 40, `step ${step} does something: ${said.slice(0, 110)}`);
      if (step === 1) expect(Number(await page.getAttribute("#stage", "data-pictures")) > 0, "step 1 shows grains");
      if (step === 2) expect(Boolean(await page.$("#visit img")), "step 2 shows the curve of a sensor");
      if (step === 3) expect(/between/.test(said) && Boolean(await page.$(".slider")), "step 3 shows intervals and sliders");
      if (step === 4) await page.waitForSelector("#curves img[alt*=prediction]", { timeout: 30_000 });
      if (step === 4) expect(/friction is 0.02/.test(said) && / %\) have a stress ratio within/.test(said) && /is wrong here/.test(said), "step 4 says what is outside, and compares with a test");
      if (step === 5) {
        await press(page, "visit-bonds");
        await page.waitForFunction(() => document.getElementById("visit").dataset.done === undefined);
        await page.waitForSelector('#visit[data-done="5"]', { timeout: 240_000 });
        expect((await page.inputValue("#case")).includes("[[bond]]"), "step 5 tests bonds");
      }
      await looked(page, `visit-${step}`, where);
      if (step < 5) await press(page, "visit-next");
    }
    await page.keyboard.press("Escape");
    expect(!(await page.$("#visit")) && (await focused(page)) === "visit-begin", "Escape ends the visit, and the focus is where it began");
    await page.reload();
    await page.waitForSelector("#visit-begin", { timeout: 60_000 });
    expect(!(await page.$("#visit-later")), "a browser that had the visit is not asked again");
    await context.close();
  }
}

/** The mappings of the paper: runs are made, networks learn, and a slider asks them; at both widths. */
async function mappings({ browser, url, expect, watch, shots }) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
  const page = await context.newPage();
  watch(page);
  await page.goto(`${url}laboratory/`);
  await page.waitForSelector("#mappings summary", { timeout: 60_000 });
  await page.focus("#mappings summary");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#mapping-train", { timeout: 60_000 });
  await press(page, "mapping-train");
  await page.waitForSelector("#mapping-answer table, #mapping-answer .bad", { timeout: 400_000 });
  expect(!(await page.$("#mapping-answer .bad")), "the networks of a mapping learn from runs of the page");
  const words = await page.textContent("#mapping-answer table");
  console.log(await page.textContent("#mapping-status"), words);
  expect(["networks of the mapping", "strain alone", "mean curve"].every(name => words.includes(name)), "the networks stand beside what knows the strain alone");
  await page.waitForSelector("#mapping-state .tile");
  const tiles = () => page.$$eval("#mapping-state .tile b", all => all.map(one => one.textContent));
  const before = await tiles();
  await page.focus("#mapping-deviator_fabric");
  for (let k = 0; k < 8; k++) await page.keyboard.press("ArrowRight");
  await page.waitForTimeout(800);
  const after = await tiles();
  expect(after[0] !== before[0], `another fabric has another answer: ${before[0]}, ${after[0]}`);
  expect(after[1] === before[1] && after[2] === before[2], "the answer of the strain alone and the state of the run stay");
  for (const width of WIDTHS) {
    await page.setViewportSize({ width, height: 900 });
    await page.waitForTimeout(500);
    await looked(page, "mappings", { expect, shots, width });
  }
  await context.close();
}

/** A case as an address holds it. */
const packed = text => zlib.deflateRawSync(text).toString("base64url");

/** Cases in addresses, good and broken, and the buttons of the book that make such addresses. */
async function cases({ browser, url, folder, expect, watch, shots }) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
  const page = await context.newPage();
  watch(page);
  const opened = async fragment => {
    await page.goto("about:blank");
    await page.goto(`${url}laboratory/#${fragment}`);
    await page.waitForSelector("#addressed > *", { timeout: 60_000 });
    return { said: await page.textContent("#addressed"), text: await page.inputValue("#case"), mistakes: await page.textContent("#mistakes"), bad: Boolean(await page.$("#addressed .bad")) };
  };
  const ready = JSON.parse(fs.readFileSync(`${folder}/catalogue.json`, "utf8")).cases.find(one => one.name === "simple-shear").text;
  let found = await opened("case=simple-shear");
  const shown = () => page.$eval("section[aria-label='The case'] select", select => select.value);
  expect(found.text === ready && !found.bad && (await shown()) === "simple-shear" && !(await page.$("#states")), "an address opens a ready case, and no test begins by itself");
  const own = "# Größe\n[grains]\ncount = 120\n[shear]\ndeviator_strain = 0.1\n";
  found = await opened(`text=${packed(own)}`);
  expect(found.text === own && (await shown()) === "" && found.mistakes === "", "an address opens a text");
  found = await opened(`text=${packed("[grains]\ncount = 100\ndiametre = '1 mm'\n<img src=x onerror=alert(1)>")}`);
  expect(/Line \d/.test(found.mistakes) && !(await page.$("main img")), "a broken case in an address has the program's errors, and its text is text");
  for (const [what, fragment] of [["cut short", `text=${packed(own).slice(0, 20)}`], ["no base64", "text=%%%"], ["far too long", `text=${packed("#".repeat(5_000_000))}`], ["a name that is none", "case=%3Cscript%3E"]]) {
    found = await opened(fragment);
    expect(found.bad && found.text.startsWith("# Drained"), `an address that is ${what} is refused: ${found.said.slice(0, 60)}`);
  }
  for (const width of WIDTHS) {
    await page.setViewportSize({ width, height: 900 });
    await opened("case=simple-shear");
    await looked(page, "address", { expect, shots, width });
  }
  if (fs.existsSync(`${folder}/book/gallery.html`)) {
    await page.setViewportSize({ width: 1280, height: 900 });
    await page.goto(`${url}book/gallery.html`);
    await page.waitForSelector("a.laboratory", { timeout: 30_000 });
    const names = await page.$$eval("a.laboratory", all => all.map(one => one.hash.slice(6)));
    expect(names.length >= 15 && names.includes("long-grains"), `the book has buttons for ${names.length} ready cases`);
    await page.screenshot({ path: `${shots}/book-gallery.png` });
    await page.click("a.laboratory[href$='case=long-grains']");
    await page.waitForSelector("#addressed .callout", { timeout: 60_000 });
    expect((await page.inputValue("#case")).includes("capsule"), "a button of the book opens its case in the laboratory");
    let examples = 0;
    for (const chapter of ["tutorial", "theory/shapes"]) {
      await page.goto(`${url}book/${chapter}.html`);
      await page.waitForSelector("pre + p > a.laboratory", { timeout: 30_000 });
      const all = await page.$$eval("pre + p > a.laboratory", all => all.map(one => [one.hash.slice(1), one.closest("p").previousElementSibling.querySelector("code").textContent]));
      for (const [fragment, text] of all) {
        found = await opened(fragment);
        examples += 1;
        expect(found.text.trim() === text.trim() && found.mistakes === "" && !found.bad, `example ${examples} of the book, in ${chapter}, opens with its text and without a mistake`);
      }
    }
    expect(examples >= 3, `the book has ${examples} examples that are whole cases`);
    await page.route("**/catalogue.json", route => route.fulfill({ status: 404, body: "" }));
    page.removeAllListeners("console");
    await page.goto(`${url}book/gallery.html`);
    await page.waitForTimeout(1000);
    expect((await page.$$("a.laboratory")).length === 0, "a book without the laboratory beside it has no buttons");
  } else console.log("without mdbook there is no book: its buttons are not tried");
  await context.close();
}

const KEPT = path.join(__dirname, "../../granum/tests/end_to_end/sixteen_cases");

/** A case that names a mesh, an image, a sieve curve and a history: its files are handed over, and its test has the digest of the program. */
async function files({ browser, url, expect, watch, shots }) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
  const page = await context.newPage();
  watch(page);
  await page.goto(`${url}laboratory/`);
  await page.waitForSelector("#handed summary", { timeout: 60_000 });
  const mistakes = () => page.textContent("#mistakes");
  const input = "#handed input[multiple]", named = ["files-of-the-case.obj", "files-of-the-case.tif", "files-of-the-case-sieve.csv", "files-of-the-case-history.csv"];
  await page.setInputFiles(input, [{ name: "own.toml", mimeType: "", buffer: fs.readFileSync(`${KEPT}/files-of-the-case.toml`) }]);
  await page.waitForFunction(() => document.getElementById("case").value.includes("files-of-the-case"));
  expect((await mistakes()).includes("add it to the files of the case") && (await page.isVisible(input)), `a file that is missing is asked for: ${(await mistakes()).slice(0, 130)}`);
  await page.setInputFiles(input, named.slice(0, 3).map(name => `${KEPT}/${name}`));
  await page.waitForFunction(() => document.querySelectorAll("#files li").length === 3, null, { timeout: 60_000 });
  expect(/files-of-the-case-history.csv/.test(await mistakes()) && !/(obj|tif|sieve.csv)" cannot/.test(await mistakes()), `what is still missing is named: ${(await mistakes()).slice(0, 200)}`);
  await page.setInputFiles(input, [{ name: named[3], mimeType: "", buffer: Buffer.from("xx_strain,yy_strain\n0,0\n0,stone\n") }]);
  await page.waitForFunction(() => /stone/.test(document.getElementById("mistakes").textContent), null, { timeout: 30_000 });
  expect(/Line 3/.test(await mistakes()), "a mistake in a file is told with its line");
  await page.setInputFiles(input, `${KEPT}/${named[3]}`);
  await page.waitForFunction(() => document.getElementById("mistakes").textContent === "", null, { timeout: 30_000 });
  for (const width of WIDTHS) {
    await page.setViewportSize({ width, height: 900 });
    await looked(page, "files", { expect, shots, width });
  }
  await page.fill("input[type=number]", "50");
  await page.click("section[aria-label='The case'] button.main");
  await page.waitForSelector("#results button", { timeout: 240_000 });
  const kept = fs.readFileSync(`${KEPT}/digests.txt`, "utf8").split("\n").find(line => line.endsWith("  files-of-the-case")).split("  ")[0];
  expect((await page.textContent("#results")).includes(kept), "its test has the digest of the program");
  await page.setViewportSize({ width: 1280, height: 900 });
  await looked(page, "result", { expect, shots, width: 1280 });
  await page.click(`#files button[aria-label='Take away ${named[0]}']`);
  await page.waitForFunction(() => document.getElementById("mistakes").textContent !== "", null, { timeout: 30_000 });
  expect((await mistakes()).includes("files-of-the-case.obj"), "a file that was taken away is missed again");
  // A folder of images, of a name with a blank.
  const folder = fs.mkdtempSync(path.join(require("os").tmpdir(), "granum files ")), scan = path.join(folder, "my scan");
  fs.mkdirSync(scan);
  for (const k of [1, 2, 10]) fs.copyFileSync(`${KEPT}/files-of-the-case.tif`, path.join(scan, `slice_${k}.tif`));
  await page.setInputFiles("#handed input[webkitdirectory]", scan);
  await page.waitForFunction(() => document.querySelectorAll("#files li").length === 6, null, { timeout: 30_000 });
  await page.fill("#case", "[grains]\ncount = 60\n[grains.shape]\nkind = \"voxels\"\nfile = \"my scan\"\npieces = 4\nspacing_z = 0.4\n");
  // Each image is a stack of its own, so that its grain is there three times.
  expect(/has the label 1 in 3 separate parts/.test(await mistakes()), `the images of a folder are read: ${await mistakes()}`);
  fs.rmSync(folder, { recursive: true });
  await context.close();
}

/** All, or one by its name. @param {{ browser: any, url: string, folder: string, expect: Function, watch: Function, shots: string }} all @param {string} [only] */
async function views(all, only) {
  for (const view of [files, cases, mappings, visit]) if (!only || only === "views" || only === view.name) await view(all);
}

module.exports = { views };
