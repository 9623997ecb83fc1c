// The engine is the program that served the page; addresses are relative, so that they carry its token.

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

// Lines of a streamed answer.
async function* lines(response) {
    const decoder = new TextDecoder();
    const reader = response.body.getReader();
    let rest = "";
    for (;;) {
        const { value, done } = await reader.read();
        rest += done ? decoder.decode() : decoder.decode(value, { stream: true });
        const whole = rest.split("\n");
        rest = whole.pop();
        for (const line of whole) if (line.trim()) yield JSON.parse(line);
        if (done) break;
    }
    if (rest.trim()) yield JSON.parse(rest);
}

async function ask(question, { signal, onProgress } = {}) {
    const body = JSON.stringify(question);
    const response = await reach("ask", { method: "POST", body, signal });
    if (!response.ok) throw await reasonOf(response);
    for await (const message of lines(response)) {
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

async function save(kind, question) {
    const body = JSON.stringify(question);
    const response = await reach(`save/${kind}`, { method: "POST", body });
    if (!response.ok) throw await reasonOf(response);
    return response.blob();
}

// Holds a connection open for as long as the tab is there: `ocmc page` ends when none is left.
async function stay() {
    try {
        const reader = (await fetch("alive")).body.getReader();
        while (!(await reader.read()).done);
    } catch {
        // the program has ended: the next question says so
    }
}

export const open = async () => {
    stay();
    return engine;
};

const engine = {
    kind: "native",
    ask,
    putFile: (name, bytes) => file("PUT", name, bytes),
    removeFile: name => file("DELETE", name),
    save,
};
