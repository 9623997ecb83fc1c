// A fleet of groups, driven as its file says: totals of the whole and of each group.
import { byId, line, put, show, table } from "./dom.js";
import { grouped, half, rough, rounded, tidy } from "./format.js";

// Drives the fleet of a file and shows its totals.
export async function driveFleet(engine, file, options) {
    const question = { ask: "run", study: file };
    const { answer } = await engine.ask(question, { ...options, aside: true });
    show(byId("fleet-section"), true);
    put(byId("fleet"), [
        line(
            `${file}: ${grouped(answer.trucks)} trucks, as the file says. Sliders and prices of ` +
                "this page do not apply to them.",
        ),
        totalsTable(answer),
        ...answer.replaceable.flatMap(electricLines),
    ]);
    return answer;
}

// Takes it away when its file goes.
export function forgetFleet(file) {
    if (!byId("fleet").textContent.startsWith(`${file}:`)) return;
    put(byId("fleet"), []);
    show(byId("fleet-section"), false);
}

function totalsTable({ totals, trucks, groups }) {
    const all = [{ group: "whole fleet", trucks, totals }, ...groups];
    const print = total => {
        if (!total) return "-";
        const { prediction95: ends } = total;
        return `${rounded(total.total)}${ends ? ` ±\u00a0${rough(half(ends))}` : ""}`;
    };
    const rows = totals.map(({ name, unit }) => [
        `${name}, ${unit}`,
        ...all.map(of => print(of.totals.find(total => total.name === name))),
    ]);
    const head = all.map(of => `${of.group}, ${grouped(of.trucks)} trucks`);
    return table("The year of the fleet and of its groups", ["", ...head], rows);
}

// How many trucks of a group a battery truck of another could be.
function electricLines({ group, vehicle_of: electric, arrivals }) {
    const counts = arrivals.map(({ share_of_trips: share, trucks, of }) => {
        const trips = share === 1 ? "all trips" : `${tidy(100 * share)} % of the trips`;
        return `${grouped(trucks)} of ${grouped(of)} where ${trips} have to arrive`;
    });
    if (counts.length === 0) return [];
    const words =
        `Trucks of “${group}” that can be electric, with the trucks and the charging of ` +
        `“${electric}”: ${counts.join(", ")}. Counted by energy alone, without queues at chargers.`;
    return [line(words)];
}
