// The tables of a run as the terminal prints them, cell by cell.
import { table } from "./dom.js";
import {
    consumptionOf,
    countOf,
    decimals,
    fixed,
    grouped,
    half,
    label,
    percent,
    rounded,
    short,
    tidy,
    twoDigits,
} from "./format.js";

const QUANTILES = ["p5", "p25", "p50", "p75", "p95", "p99"];
// Letters of a column of numbers on a terminal of 80.
const NARROW = 6;

const exists = value => value !== null && value !== undefined;

function digitsOf(statistic, factor) {
    const scale = statistic.mean ?? statistic.p50 ?? 0;
    const numbers = [...QUANTILES.map(name => statistic[name]), statistic.sd].filter(exists);
    for (let digits = decimals(factor * scale); digits > 0; digits -= 1) {
        if (numbers.every(number => fixed(factor * number, digits).length <= NARROW)) return digits;
    }
    return 0;
}

function cells(column, statistic) {
    const [name, factor] = label(column);
    const digits = digitsOf(statistic, factor);
    const print = value => (exists(value) ? fixed(factor * value, digits) : "-");
    const interval = print(statistic.ci95 ? half(statistic.ci95) : null);
    const mean = `${print(statistic.mean)} ± ${interval}`;
    return [
        name,
        mean,
        print(statistic.sd),
        ...QUANTILES.map(quantile => print(statistic[quantile])),
    ];
}

export function statisticsTable(caption, statistics, cutShort) {
    const rows = Object.entries(statistics)
        .filter(
            ([column, of]) =>
                (exists(of.mean) || exists(of.p50)) &&
                (cutShort || column !== "whole_trip_kwh_per_km"),
        )
        .map(([column, of]) => cells(column, of));
    const head = ["", "mean ± 95 %", "SD", ...QUANTILES.map(name => name.toUpperCase())];
    return table(caption, head, rows);
}

const AXES = { road_type: "By road type", event_kind: "By event kind" };
const TAKEN = [
    ["fuel", "fuel_kg", "consumption_l_per_100km"],
    ["electricity", "battery_energy_j", "consumption_kwh_per_km"],
    ["hydrogen", "hydrogen_kg", "consumption_hydrogen_kg_per_100km"],
    ["methane", "methane_kg", "consumption_methane_kg_per_100km"],
];

const fileName = path => path?.split(/[/\\]/).pop();

export function routesTable(routes) {
    const column = routes?.length && consumptionOf(routes[0].statistics);
    if (!column) return null;
    const [unit, factor] = label(column);
    const number = (value, scale, digits) => (exists(value) ? fixed(scale * value, digits) : "-");
    const rows = routes.map(route => {
        const own = route.statistics[column] ?? {};
        const mean = name => route.statistics[name]?.mean;
        return [
            fileName(route.file) ?? `route ${route.route_id}`,
            grouped(route.cycles),
            number(route.distance_m / route.cycles, 1e-3, 1),
            number(own.mean, factor, 2),
            number(own.ci95 && half(own.ci95), factor, 2),
            number(own.p5, factor, 2),
            number(own.p95, factor, 2),
            number(mean("mean_speed_mps"), 3.6, 1),
            number(mean("duration_s"), 1 / 3600, 2),
        ];
    });
    return table("By route", ["", "trips", "km", unit, "± 95 %", "P5", "P95", "km/h", "h"], rows);
}

export function partTables(parts) {
    return Object.entries(AXES)
        .map(([by, caption]) => {
            const own = (parts ?? []).filter(part => part.by === by && part.distance_m > 0);
            if (own.length === 0) return null;
            const taken = TAKEN.filter(([, amount]) => exists(own[0][amount]));
            const share = (part, key) => {
                const whole = own.reduce((sum, one) => sum + (one[key] ?? 0), 0);
                return whole === 0 ? "-" : percent((part[key] ?? 0) / whole);
            };
            const head = [
                "",
                "way %",
                "time %",
                "traction %",
                ...taken.flatMap(([name, , column]) => [`${name} %`, label(column)[0]]),
                "km/h",
            ];
            const rows = own.map(part => [
                part.part,
                share(part, "distance_m"),
                share(part, "duration_s"),
                share(part, "wheel_energy_j"),
                ...taken.flatMap(([, amount, column]) => [
                    share(part, amount),
                    exists(part[column]) ? fixed(part[column], 2) : "-",
                ]),
                part.duration_s > 0 ? fixed((3.6 * part.distance_m) / part.duration_s, 1) : "-",
            ]);
            return table(caption, head, rows);
        })
        .filter(Boolean);
}

// How the consumption of trips is shared out between trucks and their trips.
export function componentLines(answer) {
    const { trucks, statistics } = answer;
    const column = consumptionOf(statistics);
    if (!trucks?.components || !column) return [];
    const [name, factor] = label(column);
    const { between_sd, within_sd, share_of_trips, share_of_means } = trucks.components;
    const sd = value => short(factor * value);
    const of = table => (exists(table?.[column]?.sd) ? sd(table[column].sd) : "-");
    const whole = share => `${fixed(100 * share, 0)} %`;
    return [
        `${name}: SD ${sd(between_sd)} between trucks, ${sd(within_sd)} between trips of a truck.`,
        `Trucks are ${whole(share_of_trips)} of the variance of trips, and ` +
            `${whole(share_of_means)} of that ` +
            "of a truck's mean.",
        `SD of truck-months ${of(trucks.truck_months)}, of truck-years ${of(trucks.truck_years)}.`,
    ];
}

// What the mean owes to judged numbers.
export function judgedLine(answer) {
    const { judged } = answer;
    const column = consumptionOf(answer.statistics);
    if (!judged || !column) return "";
    const [unit, factor] = label(column);
    if (exists(judged.plus_minus) && judged.stored) {
        const { largest, is_same } = judged.stored;
        const shares = largest
            .slice(0, 3)
            .map(({ name, share }) => `${name.replaceAll("_", " ")} ${fixed(100 * share, 0)} %`);
        return (
            `${is_same ? "" : "About "}± ${twoDigits(factor * judged.plus_minus)} ${unit} ` +
            "from numbers that were " +
            `judged, not measured (${shares.join(", ")}, …). That is not in the ± above.`
        );
    }
    if (judged.entries === 0) {
        return "± unknown from judged numbers: the study does not say which they are.";
    }
    return `± unknown from ${grouped(judged.entries)} numbers that were judged, not measured.`;
}

// The consumption, as it is printed and adjusted for what was drawn.
export function consumptionLine(answer) {
    const column = consumptionOf(answer.statistics);
    const own = column && answer.statistics[column];
    if (!own || !exists(own.mean)) return "";
    const [name, factor] = label(column);
    const digits = digitsOf(own, factor);
    const print = value => fixed(factor * value, digits);
    const plain = own.ci95 ? `${print(own.mean)} ± ${print(half(own.ci95))}` : print(own.mean);
    if (!own.adjusted) return `${name}: ${plain}`;
    return (
        `${name}: ${print(own.adjusted.mean)} ± ${print(half(own.adjusted.ci95))} ` +
        "adjusted for what was drawn, " +
        `${plain} plain.`
    );
}

// Trucks of which the trips arrive, and what was not completed.
export function arrivalLines(answer) {
    const lines = [];
    for (const [k, of] of (answer.truck_arrivals ?? []).entries()) {
        const [low, high] = of.ci95.map(end => fixed(100 * end, 0));
        const trips =
            k === 0
                ? "Trucks of which all trips arrive"
                : `Trucks of which ${tidy(100 * of.share_of_trips)} % of the trips arrive`;
        lines.push(
            `${trips}: ${grouped(of.trucks)} of ${grouped(of.of)} ` +
                `(${low} to ${high} % of such trucks)`,
        );
    }
    const failed = Object.entries(answer.outcomes).filter(
        ([name, count]) => name !== "completed" && count > 0,
    );
    if (failed.length > 0) {
        const count = failed.reduce((sum, [, of]) => sum + of, 0);
        const reasons = failed
            .map(([name, of]) => `${grouped(of)} ${name.replaceAll("_", " ")}`)
            .join(", ");
        lines.push(
            `Not completed: ${countOf(count, "trip")} of ${grouped(answer.cycles)} ` +
                `(${fixed((100 * count) / answer.cycles, 2)} %): ${reasons}.`,
        );
    }
    if (answer.payloads_cut > 0) {
        lines.push(
            `${percent(answer.payloads_cut / answer.cycles)} % of the loads were cut ` +
                "at the legal gross mass.",
        );
    }
    return lines;
}

export const amount = ({ total, unit, half: width }, rough) =>
    `${rounded(total)}${exists(width) ? ` ± ${rough(width)}` : ""} ${unit}`;
