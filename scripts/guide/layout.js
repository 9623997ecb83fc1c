// Answers what a reader would see cut on the page; `atDesk` says whether the window is that of a
// desk.
atDesk => {
    const main = document.querySelector("main");
    const named = e => {
        const text = e.textContent.trim().replace(/\s+/g, " ").slice(0, 50);
        return `<${e.tagName.toLowerCase()}> "${text}"`;
    };
    const found = [];
    for (const e of main.querySelectorAll(".katex-error")) {
        found.push(`TeX is wrong: ${e.title || named(e)}`);
    }
    for (const e of main.querySelectorAll("span.math:not(:has(.katex))")) {
        found.push(`not typeset: ${named(e)}`);
    }
    for (const font of document.fonts) {
        if (font.status !== "error") continue;
        found.push(`font ${font.family} ${font.weight} ${font.style} is not there`);
    }
    for (const e of main.querySelectorAll("img")) {
        if (e.naturalWidth === 0) found.push(`picture ${e.getAttribute("src")} is not drawn`);
    }
    if (atDesk) {
        for (const e of main.querySelectorAll("pre, pre code, .math.display, .table-wrapper")) {
            const over = e.scrollWidth - e.clientWidth;
            if (e.clientWidth > 0 && over > 0) found.push(`cut by ${over} px: ${named(e)}`);
        }
        for (const e of main.querySelectorAll("td")) {
            const text = document.createRange();
            text.selectNodeContents(e);
            const height = text.getBoundingClientRect().height;
            const lines = height / parseFloat(getComputedStyle(e).lineHeight);
            if (lines > 8 && e.clientWidth < 200) {
                found.push(`squeezed to ${e.clientWidth} px: ${named(e)}`);
            }
        }
    }
    const whole = [document.documentElement, ...document.querySelectorAll(".page, .content")];
    for (const e of whole) {
        const over = e.scrollWidth - e.clientWidth;
        const name = e.className || "html";
        if (over > 0) found.push(`the page is ${over} px wider than the screen (${name})`);
    }
    const right = main.getBoundingClientRect().right + 1;
    const hides = e => /auto|scroll|hidden/.test(getComputedStyle(e).overflowX);
    const scrolls = e => e !== main && (hides(e) || scrolls(e.parentElement));
    for (const e of main.querySelectorAll("p, li, h1, h2, h3, h4, img, code, a, .katex")) {
        if (e.getBoundingClientRect().right > right && !scrolls(e)) {
            found.push(`beyond the column: ${named(e)}`);
        }
    }
    return found;
}
