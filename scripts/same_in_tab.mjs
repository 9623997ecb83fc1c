// The checks of scripts/same-in-tab, which says how to call it.

import { execFileSync, spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { extname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { Worker } from "node:worker_threads";

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    built: { type: "string" },
    cycles: { type: "string", default: "200" },
    studies: { type: "string" },
    time: { type: "boolean", default: false },
    chromium: { type: "string" },
  },
});
const folder = resolve(options.built);
const program = resolve(positionals[0]);
const cycles = Number(options.cycles);
const beside = (name) => import(pathToFileURL(join(folder, name)).href);
const { run } = await beside("wasi.js");
const { open } = await beside("engine-tab.js");
const bytes = readFileSync(join(folder, "engine.wasm"));
let failed = 0;

const listed = () => {
  const lines = execFileSync(program, ["study", "list"], { encoding: "utf8" }).trim().split("\n");
  return lines.map((line) => line.split(" ")[0]).filter((name) => name !== "");
};
const studies = options.studies ? options.studies.split(",") : listed();

/** SHA-256 of a table, column by column: numbers as little-endian values, other cells as text. */
function hash(csv) {
  const rows = csv.trimEnd().split("\n");
  const hasTexts = csv.includes('"');
  const hashed = createHash("sha256");
  if (hasTexts) return hashed.update(csv).digest("hex");
  const cells = rows.map((row) => row.split(","));
  for (let k = 0; k < cells[0].length; k++) {
    hashed.update(cells[0][k]);
    for (const row of cells.slice(1)) {
      const number = row[k] === "" ? NaN : Number(row[k]);
      const isText = row[k] !== "" && Number.isNaN(number);
      const value = Buffer.alloc(8);
      value.writeDoubleLE(number);
      hashed.update(isText ? row[k] : value);
    }
  }
  return hashed.digest("hex");
}

const question = (study, plan = { cycles }) => ({ ask: "run", study, plan });
const part = ["drive", "0", String(cycles), "driven"];

/** Records of the program; none where the study takes no such number of cycles. */
function native(study) {
  const parent = mkdtempSync(join(tmpdir(), "ocmc-"));
  try {
    const out = join(parent, "run");
    const args = ["--study", study, "--cycles", String(cycles), "--format", "csv", "--out", out];
    execFileSync(program, [...args, "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
    return readFileSync(join(out, "records.csv"), "utf8");
  } finally {
    rmSync(parent, { recursive: true });
  }
}

/** The last line of a command. */
function command(args, asked, files) {
  const stdin = new TextEncoder().encode(JSON.stringify(asked));
  let last;
  const onLine = (line) => (last = line);
  run(new WebAssembly.Module(bytes), { args: ["ocmc-tab", ...args], stdin, files, onLine });
  return last;
}

function inNode(study) {
  const files = new Map();
  const last = command(part, question(study), files);
  if (!files.has("driven.0.csv")) throw new Error(last);
  return new TextDecoder().decode(files.get("driven.0.csv"));
}

function check(what, isSame) {
  console.log(`${isSame ? "same" : "NOT THE SAME"}: ${what}`);
  if (!isSame) failed += 1;
}

/** A worker of node with the face of a browser's. */
function newWorker() {
  const source = `
    const { parentPort, workerData } = require("node:worker_threads");
    globalThis.self = { postMessage: (message) => parentPort.postMessage(message) };
    import(workerData).then(() => parentPort.on("message", (data) => self.onmessage({ data })));`;
  const address = pathToFileURL(join(folder, "tab-worker.js")).href;
  const worker = new Worker(source, { eval: true, workerData: address });
  const face = {
    postMessage: (message) => worker.postMessage(message),
    terminate: () => worker.terminate(),
  };
  worker.on("message", (data) => face.onmessage({ data }));
  worker.on("error", (error) => face.onerror(error));
  return face;
}

const engine = (workers, module = new WebAssembly.Module(bytes)) =>
  open({ wasm: module, workers, newWorker });

/** An answer without what depends on the machine. */
const essence = ({ warnings, of, answer, reason }) =>
  JSON.stringify({ warnings, of, answer, reason }, (key, value) =>
    ["wall_s", "ended_at", "threads"].includes(key) ? undefined : value,
  );

/** Questions of each kind, one of them on a route that is a file. */
function questions() {
  const short = (study, ...set) => ({ study, set: ["mission.length_m=8000", ...set] });
  const [field, battery] = [short("field-truck"), short("battery-truck")];
  const priced = short("field-truck", 'cost.currency="EUR"', "cost.fuel_per_l=1.2");
  const plan = { cycles: 60 };
  const routed = {
    study: { name: "routed", base: "field-truck" },
    mission: { routes: [{ file: "route.gpx", weight: 1, draw: ["limits"] }] },
  };
  return [
    { ask: "run", study: field, precision: "5 %" },
    { ask: "run", study: { study: routed }, plan },
    { ask: "run", study: "nothing" },
    { ask: "compare", studies: [field, short("field-truck", "mission.payload_kg=20000")], plan },
    { ask: "sweep", study: field, points: ["mission.payload_kg=0,20000"], plan },
    { ask: "sensitivity", study: field, plan: { cycles: 64 } },
    { ask: "doubt", study: short("battery-truck"), plan: { cycles: 16 } },
    { ask: "cost", study: priced, plan },
    { ask: "range", study: battery, plan: { cycles: 16 } },
    { ask: "bound", study: field, plan: { cycles: 10 } },
  ];
}

/** A track over a hill, as a receiver writes it. */
function track() {
  const point = (k) =>
    `<trkpt lat="${48 + 0.0009 * k}" lon="11.5"><ele>${500 + 30 * Math.sin(k / 15)}</ele></trkpt>`;
  const points = Array.from({ length: 80 }, (_, k) => point(k)).join("\n");
  return `<?xml version="1.0"?><gpx version="1.1"><trk><trkseg>${points}</trkseg></trk></gpx>`;
}

function checkAnswers() {
  const parent = mkdtempSync(join(tmpdir(), "ocmc-"));
  try {
    writeFileSync(join(parent, "route.gpx"), track());
    for (const asked of questions()) {
      const input = JSON.stringify(asked);
      const said = spawnSync(program, ["ask", "--quiet"], { cwd: parent, input, encoding: "utf8" });
      const files = new Map([["route.gpx", new TextEncoder().encode(track())]]);
      const texts = [said.stdout.trim(), command([], asked, files)];
      const [a, b] = texts.map((text) => JSON.parse(text));
      const isSame = essence(a) === essence(b);
      check(`${asked.ask}, ${b.reason?.split("\n")[0] ?? "an answer"}`, isSame);
    }
  } finally {
    rmSync(parent, { recursive: true });
  }
}

async function checkWorkers() {
  const [one, three] = [await engine(1), await engine(3)];
  const runs = ["field-truck", "electric-long-haul"].map((study) => question(study, {}));
  const compared = ["field-truck", "field-truck-loaded"];
  for (const asked of [...runs, { ask: "compare", studies: compared, plan: { cycles: 100 } }]) {
    const [a, b] = [await one.ask(asked), await three.ask(asked)].map(essence);
    check(`answer of three workers, ${asked.ask} ${asked.study ?? compared}`, a === b);
  }
  const controller = new AbortController();
  const many = question("field-truck", { cycles: 100000 });
  const asked = three.ask(many, { signal: controller.signal });
  setTimeout(() => controller.abort(), 300);
  const begin = performance.now();
  const name = await asked.then(() => "answer", (error) => error.name);
  check("a question that is taken back", name === "AbortError" && performance.now() - begin < 2000);
  const after = await three.ask(question("field-truck", { cycles: 40 }));
  check("the question after it", after.answer.cycles === 40);
  const mine = '[study]\nname = "mine"\nbase = "regional"\n';
  await three.putFile("mine.toml", new TextEncoder().encode(mine));
  const { answer } = await three.ask(question("mine.toml", { cycles: 40 }));
  check("a study of a file", answer.study === "mine");
  await three.removeFile("mine.toml");
  const again = three.ask(question("mine.toml", { cycles: 40 }));
  const gone = await again.catch((error) => error.message);
  check("a file that is gone", typeof gone === "string" && gone.includes("mine.toml"));
}

/** What serves the folder, as any static host does. */
function host() {
  const types = { ".js": "text/javascript", ".wasm": "application/wasm", ".html": "text/html" };
  const server = createServer((request, response) => {
    const name = request.url.slice(1) || "index.html";
    const type = types[extname(name)] ?? "text/plain";
    try {
      const content = name === "index.html" ? "<!doctype html>" : readFileSync(join(folder, name));
      response.writeHead(200, { "content-type": type }).end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready(server)));
}

async function browser() {
  const { chromium } = createRequire(import.meta.url)("playwright-core");
  const server = await host();
  const launched = await chromium.launch({
    executablePath: options.chromium,
    args: ["--no-sandbox"],
  });
  const address = `http://127.0.0.1:${server.address().port}/`;
  const page = async () => {
    const opened = await launched.newPage();
    await opened.goto(address);
    return opened;
  };
  const close = async () => {
    await launched.close();
    server.close();
  };
  return { page, close };
}

/** Records of a study, driven in a page. */
const inPage = (page, study) =>
  page.evaluate(
    async ([args, question]) => {
      const module = await WebAssembly.compileStreaming(fetch("engine.wasm"));
      const worker = new Worker("tab-worker.js", { type: "module" });
      const made = new Promise((resolve, reject) => {
        let last;
        worker.onmessage = ({ data }) => {
          if (data.line) last = data.line;
          else if (data.made?.length) resolve(new TextDecoder().decode(data.made[0][1]));
          else reject(new Error(data.failed ?? last));
        };
      });
      worker.postMessage({ module });
      worker.postMessage({ args, question });
      return made.finally(() => worker.terminate());
    },
    [part, question(study)],
  );

/** Seconds of questions, each asked of an engine that is opened for `times` of them. */
async function seconds(workers, cycles, times) {
  const { open } = await import("./engine-tab.js");
  const begin = performance.now();
  const engine = await open({ workers });
  const taken = [];
  for (let k = 0; k < times; k++) {
    const from = k === 0 ? begin : performance.now();
    await engine.ask({ ask: "run", study: "field-truck", plan: { cycles } });
    taken.push((performance.now() - from) / 1000);
  }
  return taken;
}

async function secondsInNode(workers, cycles, times) {
  const begin = performance.now();
  const opened = await engine(workers);
  const taken = [];
  for (let k = 0; k < times; k++) {
    const from = k === 0 ? begin : performance.now();
    await opened.ask(question("field-truck", { cycles }));
    taken.push((performance.now() - from) / 1000);
  }
  return taken;
}

async function time(where, secondsOf) {
  for (const [workers, cycles, times] of [[1, 1000, 4], [2, 1000, 4], [1, 100, 2]]) {
    const taken = (await secondsOf(workers, cycles, times)).map((s) => s.toFixed(2)).join(", ");
    const told = `${where}, ${workers} worker(s), ${cycles} cycles of 100 km`;
    console.log(`${told}, cold first: ${taken} s`);
  }
}

const inBrowser = options.chromium ? await browser() : undefined;
const page = await inBrowser?.page();
for (const study of studies) {
  let wanted;
  try {
    wanted = hash(native(study));
  } catch (error) {
    console.log(`skipped: ${study}: ${String(error.stderr ?? error).trim().split("\n")[0]}`);
    continue;
  }
  check(`${study}, ${cycles} cycles in node: ${wanted}`, hash(inNode(study)) === wanted);
  if (page) check(`${study}, in Chromium`, hash(await inPage(page, study)) === wanted);
}
checkAnswers();
await checkWorkers();
if (options.time) {
  const args = ["--cycles", "1000", "--threads", "1", "--quiet", "--json"];
  const { wall_s } = JSON.parse(execFileSync(program, args, { encoding: "utf8" }));
  console.log(`program, 1 thread, 1000 cycles of 100 km: ${wall_s.toFixed(2)} s`);
  await time("node", secondsInNode);
  const inNewPage = async (...args) =>
    (await inBrowser.page()).evaluate(`(${seconds})(...${JSON.stringify(args)})`);
  if (inBrowser) await time("Chromium", inNewPage);
}
await inBrowser?.close();
process.exit(failed === 0 ? 0 : 1);
