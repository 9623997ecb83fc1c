// How far a battery comes: the share of trips that arrive, by their length.
import { byId, element, fault, isAbort, table } from "./dom.js";
import { fixed, grouped, percent } from "./format.js";
import { clearIn, draw } from "./plot.js";

const TRIPS = 1000;

export function rangePanel(engine, current) {
    const place = byId("range");
    const bar = byId("range-progress");
    let control = null;

    byId("ask-range").addEventListener("click", async () => {
        const now = current();
        if (!now) return;
        control?.abort();
        control = new AbortController();
        const { signal } = control;
        fault(byId("range-fault"), "");
        bar.hidden = false;
        bar.value = 0;
        try {
            const onProgress = ({ done, total }) => { bar.value = total ? done / total : 0; };
            const question = { ask: "range", study: now.alone, plan: { cycles: TRIPS, seed: now.question.plan.seed } };
            const { answer } = await engine.ask(question, { signal, onProgress });
            if (!signal.aborted) render(answer);
        } catch (error) {
            if (!isAbort(error) && !signal.aborted) fault(byId("range-fault"), error.message);
        } finally {
            if (!signal.aborted) bar.hidden = true;
        }
    });

    function render(answer) {
        clearIn(place);
        const km = value => (value === null || value === undefined ? "-" : fixed(value / 1000, 0));
        const groups = [["all", answer], ...(answer.by_season ?? []).map(of => [of.group, of]),
            ...(answer.by_payload ?? []).map(of => [of.group, of])];
        const head = ["", "trips", ...answer.arriving.map(({ share }) => `${fixed(100 * share, 0)} %`)];
        const rows = groups.map(([name, of]) => [name, grouped(of.trips), ...of.arriving.map(one => km(one.range_m))]);
        const box = element("div", { class: "plot" });
        const curve = answer.curve;
        const at = share => km(answer.arriving.find(one => one.share === share)?.range_m);
        const words = `95 % of the trips arrive up to ${at(0.95)} km, half of them up to ${at(0.5)} km.`;
        place.replaceChildren(
            element("p", { class: "lead" }, words),
            element("figure", {}, box, element("figcaption", {},
                "From the charge at departure to the lowest charge that the study allows; dashed: 95 % interval of the "
                + "chance of trips, not of how right the study is.")),
            table("Longest trip, in km, with which so many of the trucks arrive", head, rows),
        );
        const column = k => curve.map(({ ci95 }) => 100 * ci95[k]);
        draw(box, {
            data: [curve.map(({ distance_m }) => distance_m / 1000), column(0), column(1),
                curve.map(({ share }) => 100 * share)],
            series: [{ name: "low", colour: "--band", dash: [4, 3], width: 1.2 },
                { name: "high", colour: "--band", dash: [4, 3], width: 1.2 },
                { name: "trips that arrive", colour: "--bar", width: 2 }],
            x: "km", y: "% of trips that arrive", words, height: 220, yRange: () => [0, 100],
        });
    }

    return {
        // What stands there belongs to another fleet now.
        forget() {
            control?.abort();
            bar.hidden = true;
            clearIn(place);
            place.replaceChildren();
        },
    };
}
