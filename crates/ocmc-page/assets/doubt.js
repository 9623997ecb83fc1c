// What the mean owes to numbers that nobody measured: both ends of each are driven.
import { byId, element, line, table } from "./dom.js";
import { fixed, label, signed, twoDigits } from "./format.js";
import { job } from "./job.js";

const CYCLES = 200;
const MOST = 8;

export function doubtPanel(engine, current) {
    const told = element("div", { role: "status" });
    const press = job(
        "Find out how much",
        async options => {
            const { question, alone } = current();
            const plan = { cycles: CYCLES, seed: question.plan.seed };
            return engine.ask({ ask: "doubt", study: alone, plan }, options);
        },
        ({ answer }) => told.replaceChildren(...words(answer)),
    );
    const place = byId("doubt");

    return {
        changed() {
            press.stop();
            told.replaceChildren();
            const { judged } = current().message.answer;
            const unknown =
                judged?.entries > 0 && (judged.plus_minus === null || !judged.stored?.is_same);
            place.replaceChildren(...(unknown ? [press.node, told] : []));
        },
    };
}

function words(answer) {
    const [unit, factor] = label(answer.column);
    const mean = factor * answer.together.mean;
    const end = side => (side ? signed(factor * side.mean.by, 2) : "-");
    const share = of =>
        of.share === null || of.share === undefined ? "-" : `${fixed(100 * of.share, 0)} %`;
    const rows = answer.numbers
        .slice(0, MOST)
        .map(of => [of.name.replaceAll("_", " "), end(of.low), end(of.high), share(of)]);
    return [
        line(
            `± ${twoDigits(mean)} ${unit} from ${answer.numbers.length} numbers that were ` +
                "judged, not measured. That is not in the ± of the totals: your own data in " +
                "their place would take it away.",
        ),
        table(
            `What a judged number does to the mean, in ${unit}, the most first`,
            ["", "at its low end", "at its high end", "share"],
            rows,
        ),
    ];
}
