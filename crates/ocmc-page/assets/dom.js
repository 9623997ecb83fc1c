// Makes elements: element("p", { class: "soft" }, "text", child).
export function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
        if (value === null || value === undefined || value === false) continue;
        if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
        else if (key in made && typeof value !== "string") made[key] = value;
        else made.setAttribute(key, value === true ? "" : value);
    }
    made.append(...children.filter(child => child !== null && child !== undefined));
    return made;
}

// A paragraph, of a class.
export const line = (text, kind) => element("p", { class: kind }, text);

export const byId = id => document.getElementById(id);

export const show = (node, is) => {
    node.hidden = !is;
};

// A table as of the program's report; `head` and `rows` are lists of cells.
export function table(caption, head, rows, words = []) {
    const side = (cell, k) => (k > 0 && !words.includes(k) ? {} : { class: "words" });
    const cells = (row, k) =>
        element(
            "tr",
            {},
            ...row.map((cell, column) =>
                column === 0
                    ? element("th", { scope: "row", class: "words" }, cell)
                    : element("td", side(cell, column), cell),
            ),
        );
    const heads = head.map((cell, k) => element("th", { scope: "col", ...side(cell, k) }, cell));
    const made = element(
        "table",
        { "aria-label": caption },
        element("thead", {}, element("tr", {}, ...heads)),
        element("tbody", {}, ...rows.map(cells)),
    );
    // keys move it sideways where it is wider than the screen
    const wide = element("div", { class: "wide", role: "group", tabindex: "0" }, made);
    wide.setAttribute("aria-label", caption);
    return element("div", {}, element("h3", {}, caption), wide);
}

// Says something to screen readers, once it has settled.
export function say(text) {
    const place = byId("said");
    if (place.textContent !== text) place.textContent = text;
}

// Puts nodes in a place. Those that stand there alike stay, and what replaces another one takes its
// focus and what was unfolded in it.
export function put(place, nodes) {
    const [old, made] = [[...place.children], nodes.filter(Boolean)];
    const focus = place.contains(document.activeElement) ? document.activeElement : null;
    const open = new Set([...place.querySelectorAll("details[open]")].map(nameOf));
    for (const details of made.flatMap(node => within(node, "details"))) {
        details.open = open.has(nameOf(details));
    }
    const stay = made.map((node, k) => (old[k]?.isEqualNode(node) ? old[k] : node));
    for (const node of old) if (!stay.includes(node)) node.remove();
    for (const [k, node] of stay.entries()) {
        if (place.children[k] !== node) place.insertBefore(node, place.children[k] ?? null);
    }
    if (focus && !focus.isConnected) {
        const twin = within(place, focus.localName).find(node => nameOf(node) === nameOf(focus));
        twin?.focus({ preventScroll: true });
    }
}

const within = (node, selector) => [
    ...(node.matches(selector) ? [node] : []),
    ...node.querySelectorAll(selector),
];

// What a control is known by when the page is drawn anew.
const nameOf = node =>
    node.id || node.getAttribute("aria-label") || node.closest("details")?.id || node.textContent;

// Says whether an answer is on its way to a place.
export const busy = (place, is) => place.setAttribute("aria-busy", String(is));

// What went wrong, in the engine's own words.
export function fault(place, reason) {
    place.replaceChildren(...(reason ? [element("p", { class: "warning" }, reason)] : []));
}

// Gives a file to the person.
export function download(name, blob) {
    const address = URL.createObjectURL(blob);
    const link = element("a", { href: address, download: name });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
}

export const isAbort = error => error?.name === "AbortError";
