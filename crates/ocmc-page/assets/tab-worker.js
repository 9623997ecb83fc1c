// A worker of the tab: it runs the engine, one command after the other.
//
// It takes `{module}` first, then `{put, bytes}`, `{remove}` and `{args, question, extra}`; it
// gives `{line}` for each line of output, and `{made}` or `{failed}` at the end. `extra` are files
// of this command alone, by name; `made` are those that it has written.

import { run } from "./wasi.js";

let module;
const files = new Map();

self.onmessage = ({ data }) => {
  if (data.module) module = data.module;
  else if (data.put !== undefined) files.set(data.put, data.bytes);
  else if (data.remove !== undefined) files.delete(data.remove);
  else command(data);
};

function command({ args, question, extra }) {
  const given = new Map([...files, ...(extra ?? [])]);
  const here = new Map(given);
  try {
    run(module, {
      args: ["ocmc-tab", ...args],
      stdin: new TextEncoder().encode(JSON.stringify(question)),
      files: here,
      onLine: (line) => self.postMessage({ line }),
    });
    self.postMessage({ made: [...here].filter(([name]) => !given.has(name)) });
  } catch (error) {
    self.postMessage({ failed: error.message });
  }
}
