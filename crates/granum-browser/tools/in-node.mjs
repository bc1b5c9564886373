// in-node.mjs FOLDER [--exact] [CASE...]: compares the modules of a folder with the program's digests, in node.

import { readFile } from "node:fs/promises";
import { compare } from "./compare.mjs";

const [folder, ...more] = process.argv.slice(2);
const root = new URL("../../../", import.meta.url);
const load = name => readFile(`${folder}/${name}.wasm`).catch(() => null);
const different = await compare(path => readFile(new URL(path, root)), load, console.log, {
  exact: more.includes("--exact"),
  names: more.filter(name => !name.startsWith("--")),
});
process.exit(different ? 1 : 0);
