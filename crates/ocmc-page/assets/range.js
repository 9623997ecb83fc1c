// How far a battery comes: the share of trips that arrive, by their length.
import { byId, element, line, table } from "./dom.js";
import { fixed, grouped } from "./format.js";
import { job } from "./job.js";
import { clearIn, draw } from "./plot.js";

const TRIPS = 1000;
const exists = value => value !== null && value !== undefined;

export function rangePanel(engine, current) {
    const place = byId("range");
    const press = job(
        "Drive until empty",
        async options => {
            const { alone, drawn, question } = current();
            const plan = { cycles: TRIPS, seed: question.plan.seed };
            const ask = async study =>
                (await engine.ask({ ask: "range", study, plan }, options)).answer;
            const answers = [await ask(alone)];
            // routes end before the battery does
            if (drawn && answers[0].depleted === 0) answers.push(await ask(drawn));
            return answers;
        },
        render,
    );
    byId("range-press").append(press.node);

    function render(answers) {
        clearIn(place);
        place.replaceChildren();
        const [first, drawn] = answers;
        if (first.depleted === 0) {
            const lowest = exists(first.lowest_charge)
                ? ` The lowest charge of one is ${fixed(100 * first.lowest_charge, 1)} %.`
                : "";
            place.append(line(`All ${grouped(first.trips)} trips arrive.${lowest}`, "lead"));
            if (drawn)
                place.append(
                    line(
                        "Your routes end before the battery does. On roads that the " +
                            "study draws:",
                    ),
                );
        }
        if ((drawn ?? first).depleted > 0) curve(drawn ?? first);
    }

    function curve(answer) {
        const km = value => (exists(value) ? fixed(value / 1000, 0) : "-");
        const groups = [
            ["all", answer],
            ...[...(answer.by_season ?? []), ...(answer.by_payload ?? [])].map(of => [
                of.group,
                of,
            ]),
        ];
        const head = [
            "",
            "trips",
            ...answer.arriving.map(({ share }) => `${fixed(100 * share, 0)} %`),
        ];
        const rows = groups.map(([name, of]) => [
            name,
            grouped(of.trips),
            ...of.arriving.map(one => km(one.range_m)),
        ]);
        const box = element("div", { class: "plot" });
        const { curve: shares } = answer;
        const at = share => km(answer.arriving.find(one => one.share === share)?.range_m);
        const words =
            `95 % of the trips arrive up to ${at(0.95)} km, ` + `half of them up to ${at(0.5)} km.`;
        place.append(
            line(words, "lead"),
            element(
                "figure",
                {},
                box,
                element(
                    "figcaption",
                    {},
                    "From the charge at departure to the lowest charge that the study allows; " +
                        "dashed: 95 % interval of the " +
                        "chance of trips, not of how right the study is.",
                ),
            ),
            table("Longest trip, in km, with which so many of the trucks arrive", head, rows),
        );
        const column = k => shares.map(({ ci95 }) => 100 * ci95[k]);
        draw(box, {
            data: [
                shares.map(({ distance_m }) => distance_m / 1000),
                column(0),
                column(1),
                shares.map(({ share }) => 100 * share),
            ],
            series: [
                { name: "low", colour: "--band", dash: [4, 3], width: 1.2 },
                { name: "high", colour: "--band", dash: [4, 3], width: 1.2 },
                { name: "trips that arrive", colour: "--bar", width: 2 },
            ],
            x: "km",
            y: "% of trips that arrive",
            words,
            height: 220,
            yRange: () => [0, 100],
        });
    }

    return {
        // What stands there belongs to another fleet now.
        forget() {
            press.stop();
            clearIn(place);
            place.replaceChildren();
        },
    };
}
