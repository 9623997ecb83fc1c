// A against B: both on the same trips, with what differs between them.
import { busy, byId, element, line, fault, isAbort, put, table } from "./dom.js";
import {
    decimalsFor,
    fixed,
    grouped,
    half,
    label,
    placeOf,
    rough,
    rounded,
    signed,
    totalsOf,
    percent,
} from "./format.js";
import { lawWords } from "./laws.js";
import { studyOf } from "./study.js";

const PAIRS = 1000;
const COLUMN = "well_to_wheel_g_per_km";

// Keeps one question of two parts in flight: a newer one ends it.
export function comparison(engine) {
    let control = null;
    const place = byId("compare");

    function stop() {
        control?.abort();
        control = null;
        busy(place, false);
    }

    // a and b: {state, own, message}
    async function show(a, b) {
        stop();
        control = new AbortController();
        const { signal } = control;
        busy(place, true);
        fault(byId("compare-fault"), "");
        render(place, a, b, null);
        try {
            const pair = [
                { ...studyOf(a.state, a.own, 1), name: "A" },
                { ...studyOf(b.state, b.own, 1), name: "B" },
            ];
            const plan = { cycles: PAIRS, seed: a.state.seed };
            const question = { ask: "compare", studies: pair, plan };
            const first = await engine.ask(question, { signal });
            if (signal.aborted) return;
            render(place, a, b, [first.answer]);
            const second = await engine.ask({ ...question, column: COLUMN }, { signal });
            if (!signal.aborted) render(place, a, b, [first.answer, second.answer]);
        } catch (error) {
            if (!isAbort(error) && !signal.aborted) fault(byId("compare-fault"), error.message);
        } finally {
            if (!signal.aborted) busy(place, false);
        }
    }

    return {
        show,
        clear() {
            stop();
            fault(byId("compare-fault"), "");
            put(place, []);
        },
        stop,
    };
}

function render(place, a, b, answers) {
    const same = answers && answers[0].differing_keys.length === 0;
    const parts = [totalsTable(a, b)];
    if (!answers) parts.push(...before(place));
    else if (same) parts.push(line("A and B are the same: change something."));
    else {
        parts.push(pairsTable(answers), ...remarks(answers));
        parts.push(differences(answers[0].differing_keys));
    }
    put(place, parts);
}

// What stands there of the comparison before, until the new one comes.
function before(place) {
    const old = [...place.children].slice(1).map(node => node.cloneNode(true));
    for (const node of old) node.classList.add("old");
    return old.length > 0 ? old : [line("Both drive the same trips …", "soft")];
}

// Totals of both, as each was printed by itself.
function totalsTable(a, b) {
    const [of, with_] = [a, b].map(({ message }) => totalsOf(message.answer.trucks));
    const find = (totals, key) => totals.find(total => total.key === key);
    const keys = [...new Set([...of, ...with_].map(({ key }) => key))];
    keys.sort((one, other) => placeOf(one) - placeOf(other));
    const print = total =>
        total
            ? `${rounded(total.total)}${total.half === null ? "" : ` ±\u00a0${rough(total.half)}`}`
            : "-";
    const rows = keys.map(key => {
        const [left, right] = [find(of, key), find(with_, key)];
        const { name, unit } = left ?? right;
        const text = left && right ? changeText(left.total, right.total) : "-";
        return [`${name}, ${unit}`, print(left), print(right), text];
    });
    return table("The year of both fleets", ["", "A", "B", "B − A"], rows);
}

function changeText(a, b) {
    const change = b - a;
    // another rounding of the same
    if (Math.abs(change) <= 1e-5 * Math.abs(a)) return "0";
    const share = a === 0 ? "" : ` (${signed((100 * change) / a, 1)} %)`;
    return `${change < 0 ? "" : "+"}${rounded(change)}${share}`;
}

// A difference with half its interval, and its share of A.
function pairText(difference, width, a) {
    const digits = width === null ? 4 : decimalsFor(width);
    const interval = width === null ? "" : ` ±\u00a0${fixed(width, digits)}`;
    const share = a ? ` (${signed((100 * difference) / a, 2)}\u00a0%)` : "";
    return signed(difference, digits) + interval + share;
}

// Paired differences: the interval is that of the difference.
function pairsTable(answers) {
    const rows = answers
        .filter(({ difference }) => difference !== null && difference !== undefined)
        .map(answer => {
            const [name, factor] = label(answer.column);
            const better = answer.adjusted ?? answer;
            const width = better.ci95 ? factor * half(better.ci95) : null;
            const lower = answer.share_a_lower ?? null;
            const b = lower === null ? "-" : percent(1 - lower - (answer.share_equal ?? 0));
            return [
                name,
                rounded(factor * answer.a),
                rounded(factor * answer.b),
                pairText(factor * better.difference, width, factor * answer.a),
                b,
            ];
        });
    const cost = answers[0].cost;
    if (cost) {
        const { a, b, difference, difference_ci95 } = cost.per_km;
        const width = difference_ci95 ? half(difference_ci95) : null;
        const lower = 1 - (cost.share_of_trips_a_cheaper ?? 0);
        rows.push([
            `${cost.currency}/km`,
            rounded(a),
            rounded(b),
            pairText(difference, width, a),
            percent(lower),
        ]);
    }
    return table(
        `On the same ${grouped(answers[0].pairs)} trips, each with a truck of its own`,
        ["", "A", "B", "B − A ±\u00a095\u00a0%", "B lower, % of trips"],
        rows,
    );
}

function remarks(answers) {
    const [first] = answers;
    const lines = [];
    const judged = first.judged?.plus_minus;
    if (judged !== null && judged !== undefined) {
        const [name, factor] = label(first.column);
        const digits = decimalsFor(factor * judged);
        lines.push(
            `± ${fixed(factor * judged, digits)} ${name} of that difference from the ` +
                `${first.judged.moved.length} judged numbers that matter most.`,
        );
    }
    if (first.a_failed > 0)
        lines.push(`${grouped(first.a_failed)} trips of A were not completed, and are left out.`);
    if (first.b_failed > 0)
        lines.push(`${grouped(first.b_failed)} trips of B were not completed, and are left out.`);
    return lines.map(text => line(text));
}

// A key that may be broken behind its dots.
function keyText(key) {
    const parts = key.split(/(?<=[._])/);
    return element("code", {}, ...parts.flatMap(part => [part, element("wbr")]));
}

function differences(keys) {
    const brief = value => lawWords(value);
    const rows = keys.map(({ key, a, b, ratio }) => {
        const change =
            ratio === null || ratio === undefined ? "" : `${signed(100 * (ratio - 1), 1)}\u00a0%`;
        return [keyText(key), brief(a), brief(b), change];
    });
    const most = 8;
    const head = ["key", "A", "B", ""];
    const shown = table("What differs, most first", head, rows.slice(0, most), [1, 2]);
    if (rows.length <= most) return shown;
    const rest = table("And the rest", head, rows.slice(most), [1, 2]);
    return element(
        "div",
        {},
        shown,
        element(
            "details",
            { id: "less-different" },
            element("summary", {}, `${rows.length - most} more`),
            rest,
        ),
    );
}
