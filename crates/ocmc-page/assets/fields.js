// Fields of the page: a slider with a number beside it, a number, a choice.
import { element } from "./dom.js";

let made = 0;

// A number with its unit, and a slider below it where `slide` is given.
// of: {label, unit, min, max, step, slide, hint, onChange(value or null)}.
export function numberField(of) {
    const id = `field-${(made += 1)}`;
    const number = element("input", {
        id,
        type: "number",
        min: String(of.min),
        max: of.most === undefined ? null : String(of.most),
        step: String(of.step),
        inputmode: "decimal",
        oninput: () => typed(number),
    });
    const hint = element("p", { class: "soft", id: `${id}-hint`, hidden: !of.hint }, of.hint ?? "");
    number.setAttribute("aria-describedby", hint.id);
    const slider =
        of.slide &&
        element("input", {
            type: "range",
            min: String(of.min),
            max: String(of.max),
            step: String(of.step),
            oninput: () => typed(slider),
        });
    slider?.setAttribute("aria-label", `${of.label}, ${of.unit}`);
    const unit = element("span", { class: "unit" }, of.unit);
    const node = element(
        "div",
        { class: "field" },
        element("label", { for: id }, of.label),
        element("span", { class: "number" }, number, unit),
        slider ?? null,
        hint,
    );

    function typed(from) {
        const value = from.value === "" ? null : Number(from.value);
        if (value !== null && !Number.isFinite(value)) return;
        const other = from === number ? slider : number;
        if (other && value !== null) other.value = from.value;
        of.onChange(value);
    }

    return {
        node,
        set(value) {
            if (document.activeElement !== number) number.value = value ?? "";
            if (slider && value !== null && document.activeElement !== slider) {
                if (value > Number(slider.max)) slider.max = String(value);
                slider.value = value;
            }
        },
        hint(text) {
            hint.textContent = text;
            hint.hidden = !text;
        },
        unit(text) {
            unit.textContent = text;
        },
        show(is) {
            node.hidden = !is;
        },
        enable(is) {
            number.disabled = !is;
            if (slider) slider.disabled = !is;
        },
    };
}

// One of several; `choices` are pairs of value and words.
export function choiceField(label, onChange) {
    const id = `field-${(made += 1)}`;
    const select = element("select", { id, onchange: () => onChange(select.value) });
    const hint = element("p", { class: "soft", id: `${id}-hint` });
    select.setAttribute("aria-describedby", hint.id);
    const node = element(
        "div",
        { class: "field" },
        element("label", { for: id }, label),
        select,
        hint,
    );
    let shown = "";
    return {
        node,
        set(groups, value) {
            // a list that is open stays so
            if (JSON.stringify(groups) !== shown) fill(groups);
            select.value = value;
        },
        hint(text) {
            hint.textContent = text;
        },
    };

    function fill(groups) {
        shown = JSON.stringify(groups);
        const options = groups
            .filter(([, choices]) => choices.length > 0)
            .map(([name, choices]) => {
                const all = choices.map(([of, words]) => element("option", { value: of }, words));
                return name ? element("optgroup", { label: name }, ...all) : all;
            });
        select.replaceChildren(...options.flat());
    }
}
