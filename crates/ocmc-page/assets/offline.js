// Lets the page of the tab open without a network: what comes from the network is kept, and what
// does not come is taken from there. It needs no version: with a network the newest files count.
const KEPT = "ocmc-page";
const NAME = /"((?:\.\/)?[\w./-]+\.(?:js|css|svg|wasm))"/g;
const HAS_NAMES = /html|javascript/;

// Keeps a file of the page, and those that it names.
async function keep(cache, address, seen) {
    if (seen.has(address)) return;
    seen.add(address);
    const response = await fetch(address);
    if (!response.ok) return;
    await cache.put(address, response.clone());
    if (!HAS_NAMES.test(response.headers.get("content-type"))) return;
    const names = [...(await response.text()).matchAll(NAME)].map(([, name]) => name);
    await Promise.all(names.map(name => keep(cache, new URL(name, address).href, seen)));
}

async function answered(request) {
    const cache = await caches.open(KEPT);
    try {
        const response = await fetch(request);
        if (response.ok) await cache.put(request, response.clone());
        return response;
    } catch (error) {
        const kept = await cache.match(request);
        if (kept) return kept;
        if (request.mode === "navigate") return cache.match(self.registration.scope);
        throw error;
    }
}

self.addEventListener("install", event => {
    self.skipWaiting();
    const all = async () => keep(await caches.open(KEPT), self.registration.scope, new Set());
    event.waitUntil(all());
});

self.addEventListener("activate", event => event.waitUntil(self.clients.claim()));

self.addEventListener("fetch", event => {
    const { method, url } = event.request;
    const isOwn = method === "GET" && url.startsWith(self.registration.scope);
    if (isOwn) event.respondWith(answered(event.request));
});
