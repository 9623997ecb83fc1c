// Ties the panels together.
import { grow, showAnswer } from "./answer.js";
import { comparison } from "./compare.js";
import { byId, line, fault, isAbort, show } from "./dom.js";
import { costPanel } from "./cost.js";
import { doubtPanel } from "./doubt.js";
import { filesPanel } from "./files.js";
import { driveFleet, forgetFleet } from "./fleet.js";
import { grouped, rounded } from "./format.js";
import { live } from "./live.js";
import { rangePanel } from "./range.js";
import { savePanel } from "./save.js";
import {
    copy,
    counterpart,
    electric,
    electricTables,
    isElectric,
    ownStudy,
    start,
    studyOf,
    tripsAYear,
} from "./study.js";
import { tripPanel } from "./trip.js";
import { trucksPanel } from "./trucks.js";

export async function answerLoop(engine) {
    let state = start();
    let own = null;
    // the last whole answer, and that which was kept as A
    let whole = null;
    let kept = null;

    // Values of a study and truck, asked once.
    const known = new Map();
    const ownOf = async of => {
        const study = ownStudy(of);
        const name = JSON.stringify(study);
        if (!known.has(name)) {
            known.set(
                name,
                engine.ask({ ask: "study", study }).then(({ answer }) => ({
                    "study.description": answer.description,
                    ...answer.values,
                })),
            );
            known.get(name).catch(() => known.delete(name));
            if (known.size > 20) known.delete(known.keys().next().value);
        }
        return known.get(name);
    };

    const files = filesPanel(
        engine,
        {
            drop: byId("drop"),
            choose: byId("choose"),
            list: byId("files"),
            wrong: byId("files-fault"),
        },
        {
            changed: filesChanged,
            removed: fileRemoved,
            calibrate,
            fleet: (name, options) => driveFleet(engine, name, options),
            route: routeChanged,
        },
    );
    const trucks = trucksPanel({ trucks: byId("trucks"), prices: byId("prices") }, changed);
    const compared = comparison(engine);
    const current = () => whole;
    const trip = tripPanel(engine, current);
    const range = rangePanel(engine, current);
    const doubt = doubtPanel(engine, current);
    const cost = costPanel(engine, current);
    const save = savePanel(engine, current, name => {
        state.name = name;
        refresh();
    });

    const asking = live(engine, {
        ownOf: async of => {
            own = await ownOf(of);
            showInputs();
            return own;
        },
        begun() {
            compared.stop();
            grow(true);
            say("Driving …");
        },
        look(message, look, of) {
            fault(byId("answer-fault"), "");
            showAnswer(message, of.trucks, look);
            say(`First look: ${grouped(look.trips)} of ${grouped(look.of)} trips`);
        },
        progress({ done, total }) {
            byId("progress").hidden = false;
            byId("progress").value = total ? done / total : 0;
        },
        final,
        failed(reason) {
            say("No answer");
            grow(true);
            fault(byId("answer-fault"), reason);
        },
    });

    function say(text) {
        byId("state").textContent = text;
        byId("progress").hidden = true;
    }

    function refresh() {
        showInputs();
        asking.change(copy(state));
    }

    function showInputs() {
        trucks.show(state, own, files.files);
        const beside = Object.entries(state.routes)
            .filter(([, route]) => route.use)
            .map(([name]) => name);
        if (files.files.some(file => file.file === state.base)) beside.unshift(state.base);
        save.show(state, beside);
    }

    function changed(key, value) {
        if (key === "reset") {
            const { name, base, vehicle, extra, routes, trucks: count, tripsAWeek, prices } = state;
            state = {
                ...start(),
                name,
                base,
                vehicle,
                extra,
                routes,
                trucks: count,
                tripsAWeek,
                prices,
            };
        } else if (key === "price") state.prices = { ...state.prices, [value[0]]: value[1] };
        else if (key === "trucks") {
            if (value === null) return;
            state.trucks = value;
        } else {
            state[key] = value;
            // another truck or study has values of its own
            if (key === "base" || key === "vehicle") {
                Object.assign(state, { curbT: null, limiterKmh: null, extra: null });
            }
        }
        refresh();
    }

    function final(message, question, of, values) {
        fault(byId("answer-fault"), "");
        showAnswer(message, of.trucks, null);
        const perTruck = tripsAYear(of, values);
        const trips = of.trucks * perTruck;
        whole = {
            message,
            question,
            state: of,
            own: values,
            trips,
            perTruck,
            alone: studyOf(of, values, 1),
            drawn: Object.values(of.routes).some(route => route.use)
                ? studyOf({ ...of, routes: {}, lengthKm: null }, values, 1)
                : null,
        };
        const took = message.answer.wall_s ? `, in ${rounded(message.answer.wall_s)} s` : "";
        say(`All ${grouped(message.answer.cycles)} trips of ${grouped(of.trucks)} trucks${took}`);
        show(byId("range-section"), isElectric(values));
        range.forget();
        trip.changed();
        doubt.changed();
        cost.changed();
        buttons();
        if (kept) compared.show(kept, whole);
    }

    function buttons() {
        byId("keep").disabled = !whole;
        byId("electric").disabled = !whole || isElectric(whole.own);
        show(byId("back"), Boolean(kept));
        show(byId("forget"), Boolean(kept));
        byId("keep").textContent = kept ? "Keep this as A instead" : "Keep as A";
    }

    byId("keep").addEventListener("click", () => {
        kept = whole;
        buttons();
        compared.show(kept, whole);
    });
    byId("forget").addEventListener("click", () => {
        kept = null;
        compared.clear();
        buttons();
        byId("keep").focus();
    });
    byId("back").addEventListener("click", () => {
        state = copy(kept.state);
        own = kept.own;
        files.show(state);
        refresh();
    });
    byId("electric").addEventListener("click", async () => {
        try {
            const diesel = whole;
            const name = counterpart(diesel.state, diesel.own);
            const { answer } = await engine.ask({ ask: "study", study: name });
            kept = diesel;
            state = electric(diesel.state, electricTables(answer.values));
            buttons();
            refresh();
        } catch (error) {
            if (!isAbort(error)) fault(byId("compare-fault"), error.message);
        }
    });

    function filesChanged(list, fresh, gone) {
        known.clear();
        for (const file of list) {
            if (!file.route) continue;
            const route = state.routes[file.file];
            state.routes[file.file] = {
                use: route?.use ?? (fresh.includes(file.file) && file.kind === "route"),
                weight: route?.weight ?? 1,
                entry: file.route,
            };
        }
        const study = list.findLast(
            file => file.kind === "study" && !file.reason && fresh.includes(file.file),
        );
        if (study)
            Object.assign(state, {
                base: study.file,
                vehicle: "",
                extra: null,
                curbT: null,
                limiterKmh: null,
                // no study is its own base
                name: study.file === `${state.name}.toml` ? `${state.name}-2` : state.name,
            });
        files.show(state);
        if (list.length + gone > 0) refresh();
    }

    function fileRemoved(name) {
        forgetFleet(name);
        delete state.routes[name];
        if (state.base === name) state.base = start().base;
        if (kept && JSON.stringify(kept.question).includes(JSON.stringify(name))) {
            kept = null;
            compared.clear();
        }
        buttons();
    }

    function routeChanged(name, change) {
        state.routes = { ...state.routes, [name]: { ...state.routes[name], ...change } };
        refresh();
    }

    // Makes a study that takes what a table says, and goes on with it.
    async function calibrate(table, options) {
        const study = {
            study: { study: { name: state.base.replace(/\.toml$/, ""), base: state.base } },
        };
        const { answer } = await engine.ask({ ask: "calibrate-totals", study, table }, options);
        const name = `calibrated-${table.replace(/\.[^.]*$/, "").replace(/[^\w-]/g, "-")}.toml`;
        await engine.putFile(name, new TextEncoder().encode(answer.study_toml));
        files.tell(table, calibrationWords(answer, name));
    }

    // Text of a reload that loses something.
    addEventListener("beforeunload", event => {
        if (files.files.length > 0) event.preventDefault();
    });

    byId("where").textContent =
        engine.kind === "native"
            ? "Everything stays on this computer; a reload forgets what is set here."
            : "It runs in this tab, without a network, too: no file leaves it; " +
              "a reload forgets it.";
    if (engine.kind !== "native") {
        byId("choose-hint").textContent =
            "Routes and tracks (GPX, CSV), tables of trips (CSV; save a workbook's sheet so), " +
            "studies (TOML). Without files the study draws its own roads.";
    }
    buttons();
    refresh();
    // files that the program was given, or that lay on the page before
    try {
        await files.read();
    } catch (error) {
        fault(byId("files-fault"), error.message);
    }
}

function calibrationWords(answer, name) {
    const unit = answer.column === "consumption_kwh_per_km" ? "kWh/km" : "L/100 km";
    const { table, simulated, before, rows, left_out, trucks } = answer;
    return [
        line(
            `${grouped(rows)} trips${trucks ? ` of ${grouped(trucks)} trucks` : ""}, ` +
                `${grouped(left_out)} left out: the table takes ${rounded(table.mean)} ${unit}, ` +
                `the calibrated study ${rounded(simulated.mean)}, ` +
                `the study with the table's loads took ${rounded(before)}.`,
        ),
        line(`It is there as ${name}, and the trucks start from it.`, "soft"),
    ];
}
