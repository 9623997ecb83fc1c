// What trucks drive, how many, and what they pay.
import { element } from "./dom.js";
import { choiceField, numberField } from "./fields.js";
import { centre, lawWords, moments } from "./laws.js";
import { tidy } from "./format.js";
import {
    BUILT_IN,
    PRICES,
    VEHICLES,
    currencyOf,
    hasFuelCell,
    mostPayloadKg,
    payloadOf,
    priceOf,
    tripsAWeek,
    tripsAYear,
} from "./study.js";

// Sliders: key of the state, words, unit, ends, step, and what the study itself says.
const SLIDERS = [
    [
        "curbT",
        "Mass without load",
        "t",
        2,
        30,
        0.1,
        (state, own) => own["vehicle.curb_mass_kg"] / 1000,
    ],
    ["payloadT", "Load, mean", "t", 0, 30, 0.1, (state, own) => payloadOf(state, own).meanT],
    ["payloadSdT", "Load, spread (SD)", "t", 0, 12, 0.1, (state, own) => payloadOf(state, own).sdT],
    ["rollingPercent", "Rolling resistance", "%", -40, 40, 1, () => 0],
    ["dragPercent", "Air drag", "%", -40, 40, 1, () => 0],
    [
        "limiterKmh",
        "Speed limiter",
        "km/h",
        60,
        110,
        1,
        (state, own) => 3.6 * own["vehicle.limiter_speed_mps"],
    ],
    [
        "lengthKm",
        "Length of a trip",
        "km",
        5,
        800,
        1,
        (state, own) => moments(own["mission.length_m"] ?? 1e5).mean / 1000,
    ],
    [
        "airC",
        "Outside, mean of the year",
        "°C",
        -10,
        30,
        0.5,
        (state, own) => own["weather.temperature.mean_k"] - 273.15,
    ],
];

// Makes the fields; `change(key, value)` is called for each change.
export function trucksPanel(places, change) {
    const base = choiceField("Study that it starts from", value => change("base", value));
    const vehicle = choiceField("Truck", value => change("vehicle", value));
    const trucks = numberField({
        label: "Number of trucks",
        unit: "trucks",
        min: 1,
        max: 200,
        step: 1,
        slide: true,
        onChange: value => change("trucks", value === null ? null : Math.max(1, Math.round(value))),
    });
    const trips = numberField({
        label: "Trips of a truck",
        unit: "a week",
        min: 0.5,
        step: 0.5,
        onChange: value => change("tripsAWeek", value !== null && value > 0 ? value : null),
    });
    const sliders = SLIDERS.map(([key, label, unit, min, max, step]) => [
        key,
        numberField({
            label,
            unit,
            min,
            max,
            step,
            slide: true,
            onChange: value => change(key, key.endsWith("Percent") ? (value ?? 0) : value),
        }),
    ]);
    const again = element(
        "button",
        { type: "button", class: "small", onclick: () => change("reset") },
        "As the study says",
    );
    places.trucks.replaceChildren(
        base.node,
        vehicle.node,
        trucks.node,
        trips.node,
        ...sliders.map(([, field]) => field.node),
        again,
    );

    const prices = PRICES.map(([key, label, unit, , step]) => [
        key,
        unit,
        numberField({
            label,
            unit,
            min: 0,
            step,
            onChange: value => change("price", [key, value]),
        }),
    ]);
    const hint = element("p", { class: "soft" });
    places.prices.replaceChildren(...prices.map(([, , field]) => field.node), hint);

    return {
        // Shows a state; `own` are the values of the study and truck that it starts from.
        show(state, own, files) {
            const dropped = files
                .filter(file => file.kind === "study")
                .map(file => [file.file, file.file]);
            base.set(
                [
                    ["Your files", dropped],
                    ["Built in", BUILT_IN.map(([name, words]) => [name, `${name}: ${words}`])],
                ],
                state.base,
            );
            vehicle.set(
                [
                    ["", [["", "that of the study"]]],
                    ["Built in", VEHICLES.map(([name, words]) => [name, `${name}: ${words}`])],
                ],
                state.vehicle,
            );
            vehicle.hint(
                state.extra
                    ? "With the chargers and the battery's heating of the electric study"
                    : "",
            );
            trucks.set(state.trucks);
            if (!own) return;
            base.hint(own["study.description"] ?? "");
            trips.set(tripsAWeek(state, own));
            trips.hint(`${tripsAYear(state, own)} trips of a truck a year`);
            const driven = Object.values(state.routes).some(route => route.use);
            for (const [k, [key, field]] of sliders.entries()) {
                const study = SLIDERS[k][6](state, own);
                const value = state[key] ?? study;
                field.show(Number.isFinite(value));
                if (Number.isFinite(value)) field.set(Number(value.toFixed(2)));
                if (key === "lengthKm") {
                    field.enable(!driven);
                    field.hint(driven ? "The routes say it" : "");
                }
            }
            const most = mostPayloadKg(state, own) / 1000;
            const field = name => sliders.find(([key]) => key === name)[1];
            const typed = state.payloadT !== null || state.payloadSdT !== null;
            field("payloadSdT").hint(
                typed
                    ? `A normal law from 0 to ${tidy(most, 4)} t`
                    : `The study's law: ${lawWords(own["mission.payload_kg"])}`,
            );
            const percents = { rollingPercent: "rolling_factor", dragPercent: "drag_area_m2" };
            for (const [name, key] of Object.entries(percents)) {
                const law = own[`vehicle.${key}`];
                if (law === undefined) continue;
                const value = tidy(centre(law) * (1 + state[name] / 100), 4);
                field(name).hint(
                    name === "dragPercent"
                        ? `CdA ${value} m², median of the trucks`
                        : `factor ${value} on the tyres' coefficients`,
                );
            }
            const currency = currencyOf(own);
            for (const [key, unit, field] of prices) {
                field.unit(unit.replace("EUR", currency));
                field.set(priceOf(state, own, key));
                field.show(key !== "hydrogen_per_kg" || hasFuelCell(own));
            }
            const given = Object.keys(own).some(key => key.startsWith("cost."));
            hint.textContent = given
                ? `Prices of the study, in ${currency}.`
                : "Examples: no price is built in, put yours. An empty field counts nothing.";
        },
    };
}
