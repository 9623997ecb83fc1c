// What the fleet's year costs, item by item.
import { byId, element, line, table } from "./dom.js";
import { fixed, rounded } from "./format.js";
import { job } from "./job.js";

export function costPanel(engine, current) {
    const told = element("div", { role: "status" });
    const press = job(
        "What it costs, by item",
        options => {
            const { question, trips } = current();
            const plan = { cycles: trips, seed: question.plan.seed };
            return engine.ask({ ask: "cost", study: question.study, plan }, options);
        },
        ({ answer }) => told.replaceChildren(...words(answer)),
    );
    const place = byId("cost");

    return {
        changed() {
            press.stop();
            told.replaceChildren();
            const { trucks } = current().message.answer;
            place.replaceChildren(...(trucks?.currency ? [press.node, told] : []));
        },
    };
}

function words({ currency, items, total, km_per_trip }) {
    const number = value => (value === null || value === undefined ? "-" : rounded(value));
    const rows = [...items, total].map(of => [
        of.item.replaceAll("_", " "),
        number(of.all_trips),
        number(of.per_km),
        number(of.per_tkm),
    ]);
    return [
        table(`${currency}, of all trips of the year`, ["", "fleet", "km", "tkm"], rows),
        line(`A trip has ${fixed(km_per_trip, 1)} km in the mean.`, "soft"),
    ];
}
