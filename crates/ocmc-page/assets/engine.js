// Gives the engine that answers: the program that served the page, or one in this tab.
export async function open() {
    const kind = document.querySelector('meta[name="ocmc-engine"]')?.content;
    const engine =
        kind === "native" ? await import("./engine-native.js") : await import("./engine-tab.js");
    return engine.open();
}
