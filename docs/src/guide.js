// Typesets the formulas that scripts/guide/formulas.py has marked. Without scripts their TeX stays readable.
for (const formula of document.querySelectorAll("span.math")) {
    katex.render(formula.textContent, formula, {
        displayMode: formula.classList.contains("display"),
        throwOnError: false,
    });
}
