// Gives the engine that answers: the program that served the page, or one in this tab.
export async function open() {
    const kind = document.querySelector('meta[name="ocmc-engine"]')?.content;
    if (kind === "native") return (await import("./engine-native.js")).open();
    const engine = await (await import("./engine-tab.js")).open();
    navigator.serviceWorker?.register("offline.js").catch(() => {});
    return engine;
}
