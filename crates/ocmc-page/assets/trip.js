// One trip: speed and limit, altitude, gear, power and where the energy goes.
import { busy, byId, element, line, fault, isAbort, put, table } from "./dom.js";
import { fixed, grouped, percent, rounded } from "./format.js";
import { clearIn, draw, legend, steps } from "./plot.js";

const SYNC = "trip";

export function tripPanel(engine, current) {
    const place = byId("trip");
    const number = byId("trip-number");
    let control = null;
    let shown = false;

    async function ask() {
        const now = current();
        if (!now) return;
        const cycle = Math.min(Math.max(0, Math.round(Number(number.value) || 0)), now.trips - 1);
        number.value = String(cycle);
        control?.abort();
        control = new AbortController();
        const { signal } = control;
        busy(place, true);
        fault(byId("trip-fault"), "");
        try {
            const question = {
                ask: "trip",
                study: now.question.study,
                seed: now.question.plan.seed,
                cycle,
            };
            const { answer } = await engine.ask(question, { signal });
            if (!signal.aborted) render(answer.columns, cycle, now);
            shown = true;
        } catch (error) {
            if (isAbort(error)) return;
            clearIn(place);
            place.replaceChildren();
            fault(byId("trip-fault"), error.message);
        } finally {
            if (!signal.aborted) busy(place, false);
        }
    }

    function step(by) {
        number.value = String(Math.max(0, (Number(number.value) || 0) + by));
        ask();
    }

    byId("trip-form").addEventListener("submit", event => {
        event.preventDefault();
        ask();
    });
    byId("trip-before").addEventListener("click", () => step(-1));
    byId("trip-next").addEventListener("click", () => step(1));

    function render(columns, cycle, now) {
        clearIn(place);
        const { head, plots, energy } = picture(columns);
        const truck = now.perTruck
            ? `Trip ${(cycle % now.perTruck) + 1} of ` +
              `truck ${Math.floor(cycle / now.perTruck) + 1}: `
            : "";
        const boxes = plots.map(() => element("div", { class: "plot" }));
        const figures = plots.map((plot, k) =>
            element(
                "figure",
                {},
                element("h3", {}, plot.title),
                boxes[k],
                legend(plot.series),
                element("figcaption", {}, plot.words),
            ),
        );
        put(place, [line(truck + head), ...figures, energy]);
        for (const [k, plot] of plots.entries()) draw(boxes[k], plot);
    }

    return {
        // After a new answer: the same trip of it, where one was shown.
        changed() {
            const now = current();
            byId("trip-of").textContent = now ? `of ${grouped(now.trips)}, counted from 0` : "";
            number.max = now ? String(now.trips - 1) : "";
            if (shown && now) ask();
        },
        ask,
    };
}

function picture(columns) {
    const km = columns.position_m.map(position => position / 1000);
    const column = name => (columns[name]?.some(value => value !== null) ? columns[name] : null);
    const scale = (name, factor) =>
        column(name)?.map(value => (value === null ? null : factor * value));
    const common = { x: "km", sync: SYNC, xRange: () => [0, km.at(-1)] };
    const most = values =>
        values.reduce((high, value) => Math.max(high, value ?? -Infinity), -Infinity);
    const duration = columns.time_s.at(-1);
    const mean = (3.6 * columns.position_m.at(-1)) / duration;
    const head =
        `${rounded(km.at(-1))} km in ${fixed(duration / 3600, 2)} h, ` +
        `${fixed(mean, 1)} km/h in the mean.`;
    const plots = [];
    const add = (title, y, height, words, series, data, more = {}) =>
        plots.push({
            ...common,
            title,
            y,
            height,
            words,
            series,
            data: [km, ...data],
            ...more,
        });

    const speed = scale("speed_mps", 3.6);
    const limit = scale("limit_mps", 3.6);
    const speeds = [{ name: "speed", colour: "--bar" }];
    if (limit) speeds.unshift({ name: "limit", colour: "--mark", paths: steps, width: 1.2 });
    add(
        "Speed",
        "km/h",
        230,
        `Speed along the way, up to ${fixed(most(speed), 0)} km/h` +
            `${limit ? ", with the limit" : ""}.`,
        speeds,
        limit ? [limit, speed] : [speed],
        { yRange: (_, low, high) => [0, 1.05 * high] },
    );

    const altitude = climb(columns);
    if (altitude) {
        const low = altitude.reduce((a, b) => Math.min(a, b), Infinity);
        add(
            "Altitude",
            "m",
            150,
            `Altitude over that of the start, from ${fixed(low, 0)} to ` +
                `${fixed(most(altitude), 0)} m.`,
            [{ name: "altitude over the start", colour: "--bar", fill: "--band", down: true }],
            [altitude],
        );
    }
    const gear = column("gear");
    if (gear) {
        add(
            "Gear",
            "gear",
            130,
            `Gears up to ${most(gear)}.`,
            [{ name: "gear", colour: "--bar", paths: steps }],
            [gear],
            { yRange: (_, low, high) => [0, high + 1] },
        );
    }
    power(columns, column, add);
    const charge = scale("state_of_charge", 100);
    if (charge) {
        add(
            "Charge",
            "%",
            150,
            `State of charge from ${fixed(charge[0], 1)} to ${fixed(charge.at(-1), 1)} %.`,
            [{ name: "state of charge", colour: "--bar" }],
            [charge],
            { yRange: () => [0, 100] },
        );
    }
    return { head, plots, energy: energy(columns, column) };
}

// Altitude over that of the start, from the slope under the truck.
function climb({ grade, position_m }) {
    if (!grade) return null;
    let [altitude, before] = [0, 0];
    return position_m.map((position, k) => {
        altitude += (grade[k] ?? 0) * (position - before);
        before = position;
        return altitude;
    });
}

// What is taken out of the store and what drives the wheels, in kW, mean of each row.
function power(columns, column, add) {
    const { time_s: time } = columns;
    // what a row adds, over the time since the row before
    const over = name => {
        const added = column(name);
        return added?.map((value, k) => {
            const took = time[k] - (time[k - 1] ?? 0);
            return value === null || !(took > 0) ? null : value / took / 1000;
        });
    };
    const wheels = over("wheel_energy_added_j");
    const engine = over("crankshaft_work_added_j");
    const battery = column("battery_power_w")?.map(value => (value === null ? null : value / 1000));
    const series = [];
    const data = [];
    const put = (name, colour, values) => {
        if (!values) return;
        series.push({ name, colour, width: 1.2 });
        data.push(values);
    };
    put("engine, at the crankshaft", "--mark", engine);
    put("battery, at its terminals", "--mark", battery);
    put("wheels", "--bar", wheels);
    if (series.length > 0) {
        add(
            "Power",
            "kW",
            190,
            `Power of ${series.map(one => one.name).join(" and ")}.`,
            series,
            data,
        );
    }
}

const LOSSES = [
    ["fuel_cell_input_added_j", "hydrogen"],
    ["battery_energy_added_j", "out of the battery's store"],
    ["crankshaft_work_added_j", "work at the crankshaft"],
    ["wheel_energy_added_j", "traction at the wheels"],
    ["drag_energy_added_j", "air drag"],
    ["rolling_energy_added_j", "rolling"],
    ["potential_added_j", "climb less descent"],
    ["service_brake_energy_added_j", "service brakes"],
    ["engine_brake_energy_added_j", "engine brake"],
    ["regenerated_energy_added_j", "given back by braking"],
    ["auxiliary_energy_added_j", "auxiliaries"],
    ["transmission_loss_added_j", "gearbox and axle"],
    ["clutch_loss_added_j", "clutch"],
    ["shift_loss_added_j", "shifts"],
    ["motor_loss_added_j", "motor"],
    ["battery_loss_added_j", "battery, inside"],
    ["charging_loss_added_j", "charging on the way"],
];

// Sums over the rows; none where rows were left out when the trip was thinned.
function energy(columns, column) {
    const sum = name => column(name)?.reduce((all, value) => all + (value ?? 0), 0);
    const way = sum("distance_added_m");
    if (!way || Math.abs(way / columns.position_m.at(-1) - 1) > 0.005) return null;
    const wheels = sum("wheel_energy_added_j");
    const rows = LOSSES.filter(([name]) => sum(name)).map(([name, words]) => {
        const own = sum(name);
        return [words, rounded(own / 3.6e6), wheels > 0 ? percent(own / wheels) : "-"];
    });
    const fuel = sum("fuel_added_kg");
    if (fuel > 0) rows.unshift(["fuel, in kg", rounded(fuel), "-"]);
    return element(
        "div",
        {},
        table("Where the energy goes", ["", "kWh", "% of traction"], rows),
        line(
            "Traction is what drives the wheels; what braking gives back is not taken off.",
            "soft",
        ),
    );
}
