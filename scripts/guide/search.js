// What the guide's search answers: the addresses of the first hits for each question, as JSON.
//
//     node search.js BOOK HITS QUESTION...
"use strict";

const { readdirSync, readFileSync } = require("node:fs");
const { join } = require("node:path");
const vm = require("node:vm");

const [book, hits, ...questions] = process.argv.slice(2);
const made = (name) => {
  const file = readdirSync(book).find((entry) => entry.startsWith(name) && entry.endsWith(".js"));
  return readFileSync(join(book, file), "utf8");
};

const tab = vm.createContext({ console: { log() {}, warn() {} } });
tab.window = tab;
tab.search = {};
vm.runInContext(made("elasticlunr"), tab);
vm.runInContext(made("searchindex"), tab);
const { index, doc_urls, search_options } = tab.search;
const asked = tab.elasticlunr.Index.load(index);
const answers = questions.map((question) =>
  asked
    .search(question, search_options)
    .slice(0, Number(hits))
    .map((hit) => doc_urls[hit.ref]),
);
console.log(JSON.stringify(answers));
