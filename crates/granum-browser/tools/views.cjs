// What laboratory.cjs asks of the guided visit, of the view of the paper's mappings and of cases in addresses, each at 1280 and 390 pixels.

const fs = require("fs"), zlib = require("zlib");

const WIDTHS = [1280, 390];
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

/** No violations of axe, and nothing wider than the window. */
async function looked(page, name, { expect, shots, width }) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  expect(wide <= width, `no scrolling sideways: ${name} at ${width} pixels`);
  await page.evaluate(axe);
  const found = await page.evaluate(() => globalThis.axe.run().then(result => result.violations.map(one => `${one.id}: ${one.nodes[0]?.html.slice(0, 120)}`)));
  expect(found.length === 0, `axe: ${name} at ${width} pixels ${found.join("; ")}`);
  await page.screenshot({ path: `${shots}/${name}-${width}.png`, fullPage: true });
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

/** All, or one by its name. @param {{ browser: any, url: string, expect: Function, watch: Function, shots: string }} all @param {string} [only] */
async function views(all, only) {
  for (const view of [visit, mappings]) if (!only || only === "views" || only === view.name) await view(all);
}

module.exports = { views };
