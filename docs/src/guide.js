// Typesets the formulas that scripts/guide/formulas.py has marked. Without scripts their TeX stays readable.
for (const formula of document.querySelectorAll("span.math")) {
    katex.render(formula.textContent, formula, {
        displayMode: formula.classList.contains("display"),
        throwOnError: false,
    });
}

// mdBook's button for the table of contents is a label, whose state only a button may tell.
document.getElementById("mdbook-sidebar-toggle")?.setAttribute("role", "button");

// A number stays with its unit.
for (const cell of document.querySelectorAll("main td")) {
    if (cell.textContent.length <= 14) cell.style.whiteSpace = "nowrap";
}

// What scrolls is reached by the keyboard, too.
function reachable() {
    for (const part of document.querySelectorAll("main pre > code, main .table-wrapper, main figure, .math.display")) {
        if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
        else part.removeAttribute("tabindex");
    }
}
window.addEventListener("resize", reachable);

// A block or a table that is a little too wide for a desk is set a little smaller, instead of being cut.
document.fonts.ready.then(() => {
    if (window.innerWidth < 1000) {
        reachable();
        return;
    }
    for (const wide of document.querySelectorAll("main pre > code, main .table-wrapper")) {
        const share = (0.97 * wide.clientWidth) / wide.scrollWidth;
        const text = wide.querySelector("table") ?? wide;
        if (wide.scrollWidth > wide.clientWidth && share > 0.75) {
            text.style.fontSize = `${Math.floor(share * parseFloat(getComputedStyle(text).fontSize) * 20) / 20}px`;
        }
    }
    reachable();
});
