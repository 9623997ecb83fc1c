// The engine is the program that served the page; relative addresses carry its token.

// A newer question of a kind ends the older one of the same tab.
const TAB = [...crypto.getRandomValues(new Uint8Array(12))].map(byte => byte.toString(16)).join("");
const post = (address, body, tab = TAB, signal = undefined) =>
    reach(address, { method: "POST", body, signal, headers: { "X-Ocmc-Tab": tab } });

async function reasonOf(response) {
    const text = (await response.text()).trim();
    return new Error(text || `the program answers ${response.status}`);
}

async function reach(address, options) {
    try {
        return await fetch(address, options);
    } catch (error) {
        if (error?.name === "AbortError") throw error;
        throw new Error("the program does not answer: was `ocmc page` ended?");
    }
}

async function* pieces(response) {
    const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
    for (;;) {
        const { value, done } = await reader.read();
        if (done) return;
        yield value;
    }
}

// Messages of a streamed answer, one a line.
async function* messages(response) {
    let rest = "";
    for await (const piece of pieces(response)) {
        const whole = (rest + piece).split("\n");
        rest = whole.pop();
        for (const line of whole) if (line.trim()) yield JSON.parse(line);
    }
    if (rest.trim()) yield JSON.parse(rest);
}

// `aside`: the question does not end others of its kind, and they do not end it.
async function ask(question, { signal, onProgress, aside } = {}) {
    const tab = aside ? `${TAB}-aside` : TAB;
    const response = await post("ask", JSON.stringify(question), tab, signal);
    if (!response.ok) throw await reasonOf(response);
    for await (const message of messages(response)) {
        if (message.message === "progress") onProgress?.(message);
        else if (message.message === "answer") return message;
        else if (message.message === "refused") throw new Error(message.reason);
        else throw new Error("the work was ended before there was an answer");
    }
    throw new Error("the program ended before there was an answer");
}

async function file(method, name, body) {
    const response = await reach(`files/${encodeURIComponent(name)}`, { method, body });
    if (!response.ok) throw await reasonOf(response);
}

// The program ends when no page holds this open any more.
async function stay() {
    try {
        for await (const _ of pieces(await fetch("alive"))) continue;
    } catch {
        // what is asked next says so
    }
}

async function save(kind, question) {
    if (kind === "study.toml") {
        const { answer } = await ask({ ask: "study", study: question.study });
        return new Blob([answer.toml], { type: "application/toml" });
    }
    const response = await post(`save/${kind}`, JSON.stringify(question));
    if (!response.ok) throw await reasonOf(response);
    return response.blob();
}

export async function open() {
    stay();
    return {
        kind: "native",
        ask,
        putFile: (name, bytes) => file("PUT", name, bytes),
        removeFile: name => file("DELETE", name),
        save,
    };
}
