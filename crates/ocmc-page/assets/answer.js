// The answer: totals of the fleet's year first, then where they come from and how trips are spread.
import { byId, element, line, put, say, show } from "./dom.js";
import { consumptionOf, countOf, grouped, label, rough, rounded, totalsOf } from "./format.js";
import { bars, clear, redraw } from "./plot.js";
import {
    arrivalLines,
    componentLines,
    consumptionLine,
    judgedLine,
    partTables,
    routesTable,
    statisticsTable,
} from "./tables.js";

const HEADLINE = [
    "fuel_l",
    "battery_energy_j",
    "hydrogen_kg",
    "methane_kg",
    "well_to_wheel_kg",
    "cost",
];

// Shows an answer. `look` is there where it is a part: {trips, of, scale}.
export function showAnswer(message, trucks, look) {
    const { answer, warnings } = message;
    const totals = totalsOf(answer.trucks, look?.scale ?? 1);
    const cards = byId("totals");
    cards.classList.toggle("first", Boolean(look));
    cards.replaceChildren(...totals.map(total => card(total, trucks, look)));
    byId("bar").textContent = "";
    byId("bar").append(
        ...totals
            .filter(({ key }) => HEADLINE.includes(key))
            .map(({ total, unit, key }) =>
                element(
                    "span",
                    {},
                    `${look ? "≈ " : ""}${look ? rough(total) : rounded(total)} ${unit}` +
                        (key === "well_to_wheel_kg" ? " CO2e" : ""),
                ),
            ),
    );
    const judged = judgedLine(answer);
    const means = look
        ? "± is what this first look leaves open; " +
          `the rest of the ${grouped(look.of)} trips follows.`
        : "Behind ± lies where another fleet of as many such trucks would lie: other drivers, " +
          "other weather, other loads of the same kind.";
    put(byId("judged"), [
        line(means, "soft"),
        element("p", { id: "consumption" }, consumptionLine(answer)),
        ...(answer.trucks?.currency
            ? [line("The cost is that of the centres of the prices.", "soft")]
            : []),
        ...arrivalLines(answer).map(text => line(text)),
        ...(answer.note ? [line(`Intervals: ${answer.note}.`, "soft")] : []),
        ...(judged ? [line(judged)] : []),
    ]);
    grow(Boolean(look), true);
    spread(answer, look);
    warned([...new Set(warnings)]);
    if (look) return;
    const cutShort = answer.outcomes.depleted > 0;
    const routes = routesTable(answer.routes);
    const byTruck = answer.trucks
        ? [
              statisticsTable(
                  `By truck: ${grouped(answer.trucks.trucks)} trucks, ` +
                      "totals over totals of each truck's year",
                  answer.trucks.truck_years,
                  cutShort,
              ),
              ...componentLines(answer).map(text => line(text, "soft")),
          ]
        : [];
    put(byId("parts"), [routes, ...byTruck]);
    put(byId("tables"), [
        element(
            "details",
            { id: "all-trips" },
            element("summary", {}, "All quantities of the trips, by road type"),
            statisticsTable(
                "Trips: mean of the fleet, the rest counts each trip once",
                answer.statistics,
                cutShort,
            ),
            ...partTables(answer.parts),
        ),
    ]);
    const spoken = totals.map(
        ({ name, total, unit, half }) =>
            `${name} ${rounded(total)}` +
            `${half === null ? "" : ` plus or minus ${rough(half)}`} ${unit}`,
    );
    say(`${grouped(answer.cycles)} trips driven: ${spoken.join(", ")}`);
}

function card({ name, unit, total, half, key }, trucks, look) {
    const print = look ? rough : rounded;
    const of =
        trucks > 1 && !["distance_m", "duration_s"].includes(key)
            ? `${rough(total / trucks)} ${unit} a truck`
            : "";
    return element(
        "div",
        { "data-total": key },
        name,
        element("b", {}, `${print(total)} ${unit}`),
        element("span", { class: "soft" }, half === null ? "" : `± ${rough(half)} ${unit}`),
        element("span", { class: "soft" }, of),
    );
}

// Makes clear that what stands there is no longer what was asked; behind a first look all but the
// totals.
export function grow(old, isLook = false) {
    for (const name of ["totals", "bar"]) byId(name).classList.toggle("old", old && !isLook);
    for (const name of ["parts", "tables", "compare", "trip", "doubt", "cost"]) {
        byId(name).classList.toggle("old", old);
    }
}

function warned(warnings) {
    const place = byId("warnings");
    if (warnings.length === 0) return put(place, []);
    const lines = warnings.map(text => line(text, "warning soft"));
    const name = warnings.length === 1 ? "A warning" : `${warnings.length} warnings`;
    put(place, [
        element("details", { id: "all-warnings" }, element("summary", {}, name), ...lines),
    ]);
}

// The headline stays in sight at the foot of the window while the totals are out of it.
new IntersectionObserver(([{ isIntersecting }]) => {
    byId("bar").classList.toggle("up", !isIntersecting);
}).observe(byId("totals"));

// A histogram where the answer has one, else the curve through its quantiles.
function spread(answer, look) {
    const figure = byId("spread");
    const column = consumptionOf(answer.statistics);
    const own = column && answer.statistics[column];
    const place = figure.querySelector(".plot");
    if (!own || (look && look.trips < 50)) {
        if (!own) {
            clear(place);
            show(figure, false);
        }
        return;
    }
    show(figure, true);
    const [unit, factor] = label(column);
    const words =
        `Of the trips, 5 % take less than ${rounded(factor * own.p5)} ${unit}, half of them ` +
        "less than " +
        `${rounded(factor * own.p50)}, and 5 % more than ${rounded(factor * own.p95)}.`;
    const outside = own.histogram ? own.histogram.below + own.histogram.above : 0;
    const left =
        outside > 0 ? ` Outside of the bars: ${countOf(outside, "trip")}.` : "";
    figure.querySelector("figcaption").textContent = words + left;
    redraw(
        place,
        own.histogram
            ? histogram(own.histogram, factor, unit, words)
            : ogive(own, factor, unit, words),
    );
}

function histogram({ edges, counts, below, above }, factor, unit, words) {
    const all = counts.reduce((sum, count) => sum + count, 0) + below + above || 1;
    return {
        data: [
            edges.slice(0, -1).map(edge => factor * edge),
            counts.map(count => (100 * count) / all),
        ],
        series: [{ name: "trips", colour: "--bar", fill: "--band", paths: bars, width: 1 }],
        x: unit,
        y: "% of trips",
        words,
        height: 200,
        quiet: true,
        xRange: () => [factor * edges[0], factor * edges.at(-1)],
        yRange: (_, low, high) => [0, 1.05 * high],
    };
}

function ogive(own, factor, unit, words) {
    const known = [
        ["p5", 5],
        ["p25", 25],
        ["p50", 50],
        ["p75", 75],
        ["p95", 95],
        ["p99", 99],
    ].filter(([name]) => own[name] !== null);
    return {
        data: [known.map(([name]) => factor * own[name]), known.map(([, share]) => share)],
        series: [{ name: "trips", colour: "--bar", width: 2 }],
        x: unit,
        y: "% of trips below",
        words,
        height: 200,
        yRange: () => [0, 100],
    };
}
