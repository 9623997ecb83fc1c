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
