// The engine in the tab itself: workers that run `engine.wasm`. Nothing leaves the browser.
//
// Cycles of a question are driven by all workers, each a part of them; the first worker then
// answers of their records. The answer has the bits of one worker's. Workers share no memory, so
// any static host will do.

/** Most workers: each takes some ten MB, and its share of the cycles is small by then. */
const MOST_WORKERS = 16;

/** Questions that are soon answered: a worker of their own, so that they wait for no long one. */
const SOON = ["files", "study", "trip"];

/**
 * Opens the engine.
 *
 * `wasm` is the address of the engine, `workers` how many there are, and `newWorker` makes one.
 */
export async function open({
  wasm = new URL("engine.wasm", import.meta.url),
  workers = Math.min(navigator.hardwareConcurrency || 2, MOST_WORKERS),
  newWorker = () => new Worker(new URL("tab-worker.js", import.meta.url), { type: "module" }),
} = {}) {
  const module = wasm instanceof WebAssembly.Module ? wasm : await compiled(wasm);
  const files = new Map();
  const desks = Array.from({ length: workers + 1 }, () => new Desk(newWorker, module, files));
  // questions are answered one after the other: each takes all workers of its pool
  const soon = { pool: desks.slice(0, 1), last: Promise.resolve() };
  const long = { pool: desks.slice(1), last: Promise.resolve() };

  function ask(question, { signal, onProgress } = {}) {
    const queue = SOON.includes(question.ask) ? soon : long;
    const asked = queue.last.then(() => answered(queue.pool, question, signal, onProgress));
    queue.last = asked.catch(() => undefined);
    return asked;
  }

  async function putFile(name, bytes) {
    files.set(name, new Uint8Array(bytes));
    for (const desk of desks) desk.send({ put: name, bytes: files.get(name) });
  }

  async function removeFile(name) {
    files.delete(name);
    for (const desk of desks) desk.send({ remove: name });
  }

  async function save(kind, question) {
    if (kind !== "study.toml") {
      const how = "run `ocmc page`, or the command that this page shows";
      throw new Error(`${kind} is made by the program: ${how}`);
    }
    const { answer } = await ask({ ask: "study", study: question.study });
    return new Blob([answer.toml], { type: "application/toml" });
  }

  return { kind: "tab", ask, putFile, removeFile, save };
}

/** The compiled engine, compiled while it comes where the host says what it is. */
async function compiled(address) {
  const response = await fetch(address);
  if (!response.ok) throw new Error(`${address}: ${response.status} ${response.statusText}`);
  const isNamed = response.headers.get("content-type") === "application/wasm";
  return isNamed
    ? WebAssembly.compileStreaming(response)
    : WebAssembly.compile(await response.arrayBuffer());
}

/** Answers a question by all workers. */
async function answered(pool, question, signal, onProgress) {
  const stopped = () => new DOMException("the question was taken back", "AbortError");
  if (signal?.aborted) throw stopped();
  const stop = () => pool.forEach((desk) => desk.stop(stopped()));
  signal?.addEventListener("abort", stop, { once: true });
  try {
    return await together(pool, question, onProgress);
  } catch (error) {
    // where one part fails, the others are of no use
    for (const desk of pool) desk.stop(error);
    throw error;
  } finally {
    signal?.removeEventListener("abort", stop);
  }
}

async function together(pool, question, onProgress) {
  const [first] = pool;
  const begin = performance.now();
  const parts = await partsOf(pool, question);
  if (parts.length === 0) return reply(await first.run([], question, onProgress));
  const sum = (numbers) => numbers.reduce((all, one) => all + one, 0);
  const done = parts.map(() => 0);
  const drive = ({ first_cycle, cycles }, k) => {
    const look = (progress) => {
      done[k] = progress.done;
      const total = (progress.total / cycles) * sum(parts.map((part) => part.cycles));
      onProgress?.({ ...progress, done: sum(done), total });
    };
    const args = ["drive", String(first_cycle), String(cycles), `.driven-${k}`];
    return pool[k].run(args, question, look);
  };
  const driven = (await Promise.all(parts.map(drive))).flatMap(({ made }) => made);
  const names = driven.map(([name]) => name);
  const answered = await first.run(["answer", ...names], question, onProgress, new Map(driven));
  // the worker that answers has not seen the others drive
  const { answer } = answered;
  if ("wall_s" in answer) answer.wall_s = (performance.now() - begin) / 1000;
  return reply(answered);
}

/** Parts of a question for all workers; none where it is not shared. */
async function partsOf(pool, question) {
  if (pool.length === 1 || !["run", "compare"].includes(question.ask)) return [];
  return (await pool[0].run(["parts", String(pool.length)], question)).parts;
}

const reply = ({ warnings, of, answer }) => ({ warnings, of, answer });

/** A worker, and what it is asked. */
class Desk {
  constructor(newWorker, module, files) {
    this.newWorker = newWorker;
    this.module = module;
    this.files = files;
    this.begun = undefined;
    this.start();
  }

  start() {
    this.worker = this.newWorker();
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.onerror = (error) => this.end("failed", new Error(error.message));
    this.send({ module: this.module });
    for (const [name, bytes] of this.files) this.send({ put: name, bytes });
  }

  send(message) {
    this.worker.postMessage(message);
  }

  /** Runs a command; gives its last message, with the files that it has made. */
  run(args, question, onProgress, extra) {
    return new Promise((resolve, failed) => {
      this.begun = { resolve, failed, onProgress, last: undefined };
      this.send({ args, question, extra });
    });
  }

  take({ line, made, failed }) {
    if (!this.begun) return;
    if (failed !== undefined) {
      this.end("failed", new Error(failed));
    } else if (made) {
      const { last } = this.begun;
      if (last?.message === "refused") this.end("failed", new Error(last.reason));
      else this.end("resolve", { ...last, made });
    } else {
      const message = JSON.parse(line);
      if (message.message === "progress") this.begun.onProgress?.(message);
      else this.begun.last = message;
    }
  }

  end(how, value) {
    const { begun } = this;
    this.begun = undefined;
    begun?.[how](value);
  }

  /** Takes its question from the worker, which is replaced by a new one. */
  stop(reason) {
    if (!this.begun) return;
    this.worker.terminate();
    this.start();
    this.end("failed", reason);
  }
}
