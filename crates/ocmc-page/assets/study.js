// What the planner has said, as the keys of a study file; what was left as it was is not written.
import { moments, scaled } from "./laws.js";
import { tidy } from "./format.js";

export const BUILT_IN = [
    ["field-truck", "mixed roads, 100 km, mixed loads"],
    ["regional", "regional delivery, 100 km"],
    ["long-haul", "long haul, 300 km, mostly motorways"],
    ["urban-delivery", "towns, 40 km, a stop every two km"],
    ["battery-truck", "as field-truck, battery-electric"],
    ["electric-regional", "rounds of 200 km, charged in the depot"],
    ["electric-long-haul", "500 km, charged on the way"],
    ["fuel-cell-truck", "as field-truck, fuel cell"],
];

export const VEHICLES = [
    ["tractor-40t", "tractor and trailer, 40 t, diesel"],
    ["tractor-electric-40t", "tractor and trailer, 40 t, battery of 540 kWh"],
    ["tractor-fuel-cell-40t", "tractor and trailer, 40 t, fuel cell"],
    ["tractor-40t-vecto", "VECTO's generic tractor of 2016"],
    ["rigid-12t", "rigid truck, 12 t, diesel"],
    ["van-3500kg", "van, 3.5 t"],
    ["city-bus-12m", "city bus, 12 m, diesel"],
    ["city-bus-electric-12m", "city bus, 12 m, battery"],
    ["coach-12m", "coach, 12 m, diesel"],
];

export const WEEKS = 52;
const DEFAULT_TRIPS_A_WEEK = 5;

// Prices: key of [cost], words, unit, example, and of what trucks it is asked.
export const PRICES = [
    ["fuel_per_l", "Fuel", "EUR/L", 1.45, 0.01],
    ["depot_charging_per_kwh", "Electricity, depot", "EUR/kWh", 0.24, 0.01],
    ["public_charging_per_kwh", "Electricity, on the way", "EUR/kWh", 0.49, 0.01],
    ["hydrogen_per_kg", "Hydrogen", "EUR/kg", 9, 0.1],
    ["toll_per_km", "Toll", "EUR/km", 0, 0.01],
    ["driver_per_h", "Driver", "EUR/h", 31, 1],
];

// A state in which nothing was changed. Null stands for what the study itself says.
export const start = () => ({
    name: "my-fleet",
    base: "regional",
    vehicle: "",
    extra: null,
    routes: {},
    trucks: 40,
    tripsAWeek: null,
    curbT: null,
    payloadT: null,
    payloadSdT: null,
    rollingPercent: 0,
    dragPercent: 0,
    limiterKmh: null,
    lengthKm: null,
    airC: null,
    prices: {},
    seed: 1,
});

export const copy = state => structuredClone(state);

// The study whose values the sliders start from: base, vehicle and what goes with it.
export function ownStudy(state) {
    const keys = { study: { name: state.name, base: state.base } };
    if (state.vehicle) keys.vehicle = { base: state.vehicle };
    return { study: merge(keys, state.extra ?? {}) };
}

export function tripsAYear(state, own) {
    const given = own["fleet.trips_per_truck"];
    if (state.tripsAWeek === null && given) return given;
    return Math.max(2, Math.round(WEEKS * (state.tripsAWeek ?? DEFAULT_TRIPS_A_WEEK)));
}

export const tripsAWeek = (state, own) =>
    tidy(state.tripsAWeek ?? tripsAYear(state, own) / WEEKS, 3);

// What a price is: typed, of the study, or an example. An empty field is null.
export function priceOf(state, own, key) {
    if (key in state.prices) return state.prices[key];
    if (key === "toll_per_km") return own["cost.toll"] ? null : 0;
    const given = own[`cost.${key}`];
    if (given !== undefined) return moments(given).mean;
    return hasCost(own) ? null : PRICES.find(price => price[0] === key)[3];
}

export const hasCost = own => Object.keys(own).some(key => key.startsWith("cost."));

export const currencyOf = own => own["cost.currency"] ?? "EUR";

// Payload that the law allows.
export function mostPayloadKg(state, own) {
    const curb = state.curbT === null ? own["vehicle.curb_mass_kg"] : 1000 * state.curbT;
    const limit = own["vehicle.gross_mass_limit_kg"];
    return limit && typeof curb === "number" ? Math.max(0, limit - curb) : 100000;
}

export function payloadOf(state, own) {
    const { mean, sd } = moments(own["mission.payload_kg"] ?? 0);
    return { meanT: state.payloadT ?? mean / 1000, sdT: state.payloadSdT ?? sd / 1000 };
}

function mission(state, own) {
    const made = {};
    if (state.payloadT !== null || state.payloadSdT !== null) {
        const { meanT, sdT } = payloadOf(state, own);
        const upper = mostPayloadKg(state, own);
        const [mean, sd] = [tidy(1000 * meanT), tidy(1000 * sdT)];
        made.payload_kg = sd > 0 ? { distribution: "normal", mean, sd, lower: 0, upper } : mean;
    }
    const routes = Object.values(state.routes).filter(route => route.use && route.entry);
    if (routes.length > 0) {
        made.routes = routes.map(({ entry, weight }) => ({ ...entry, weight }));
    } else if (state.lengthKm !== null) made.length_m = tidy(1000 * state.lengthKm);
    return made;
}

function vehicle(state, own) {
    const made = state.vehicle ? { base: state.vehicle } : {};
    if (state.curbT !== null) made.curb_mass_kg = tidy(1000 * state.curbT);
    const factors = { drag_area_m2: state.dragPercent, rolling_factor: state.rollingPercent };
    for (const [key, change] of Object.entries(factors)) {
        const law = own[`vehicle.${key}`];
        if (change !== 0 && law !== undefined) made[key] = scaled(law, 1 + change / 100);
    }
    if (state.limiterKmh !== null) made.limiter_speed_mps = tidy(state.limiterKmh / 3.6, 12);
    return made;
}

function cost(state, own) {
    const given = hasCost(own);
    const made = {};
    for (const [key] of PRICES) {
        const typed = key in state.prices;
        const price = priceOf(state, own, key);
        if (price === null || (given && !typed)) continue;
        if (key === "hydrogen_per_kg" && !typed && !hasFuelCell(own)) continue;
        if (key !== "toll_per_km") made[key] = price;
        else if (price > 0) made.toll = [{ toll_per_km: price }];
        else if (typed && own["cost.toll"]) made.toll = [];
    }
    if (Object.keys(made).length === 0) return made;
    if (!own["cost.charging_efficiency"]) {
        const meters = own["charging.efficiency"] ?? own["emissions.charging_efficiency"];
        if (
            made.depot_charging_per_kwh !== undefined ||
            made.public_charging_per_kwh !== undefined
        ) {
            made.charging_efficiency = meters ?? 0.94;
        }
    }
    if (!own["cost.currency"]) made.currency = "EUR";
    return made;
}

// The keys of the study; `own` are the values of `ownStudy`.
export function studyOf(state, own, trips = tripsAYear(state, own)) {
    const keys = { study: { name: state.name, base: state.base } };
    const add = (name, made) => {
        if (Object.keys(made).length > 0) keys[name] = made;
    };
    add("mission", mission(state, own));
    add("vehicle", vehicle(state, own));
    if (state.airC !== null) {
        keys.weather = { temperature: { mean_k: tidy(state.airC + 273.15, 12) } };
    }
    add("cost", cost(state, own));
    if (trips !== own["fleet.trips_per_truck"]) keys.fleet = { trips_per_truck: trips };
    return { study: merge(structuredClone(state.extra ?? {}), keys) };
}

// The question whose answer is that of the command.
export const runQuestion = (state, own) => ({
    ask: "run",
    study: studyOf(state, own),
    trucks: state.trucks,
    plan: { seed: state.seed },
});

// A part of the fleet's year that is soon driven, and the factor from its totals to the year's.
export function lookQuestion(state, own, wanted) {
    const trips = tripsAYear(state, own);
    const trucks = Math.min(state.trucks, 30, Math.ceil(wanted / 2));
    const each = Math.min(trips, Math.max(2, Math.round(wanted / trucks)));
    const question = {
        ask: "run",
        study: studyOf(state, own, each),
        trucks,
        plan: { seed: state.seed },
    };
    return { question, trips: each * trucks, scale: (state.trucks * trips) / (trucks * each) };
}

// Lays `over` over `under`; laws and lists are taken whole.
export function merge(under, over) {
    const made = { ...under };
    const isTable = value =>
        value && typeof value === "object" && !Array.isArray(value) && !value.distribution;
    for (const [key, value] of Object.entries(over)) {
        made[key] = isTable(value) && isTable(made[key]) ? merge(made[key], value) : value;
    }
    return made;
}

// The electric counterpart of a study, whose chargers and battery an electric fleet takes.
export function counterpart(state, own) {
    const far = moments(own["mission.length_m"] ?? 1e5).mean > 250e3;
    const driven = Object.values(state.routes).some(route => route.use);
    return far && !driven ? "electric-long-haul" : "electric-regional";
}

// Tables of that study which an electric fleet on another mission needs, from its flat values.
const ELECTRIC = /^(charging|rest|vehicle\.powertrain\.battery_electric\.battery\.thermal)\b/;

export function electricTables(values) {
    const made = {};
    for (const [key, value] of Object.entries(values)) {
        if (!ELECTRIC.test(key) || value === null) continue;
        const path = key.split(".");
        const last = path.pop();
        const place = path.reduce((table, name) => (table[name] ??= {}), made);
        place[last] = value;
    }
    return made;
}

export const isElectric = own =>
    Object.keys(own).some(key => key.startsWith("vehicle.powertrain.battery_electric."));

export const hasFuelCell = own =>
    Object.keys(own).some(key => key.startsWith("vehicle.powertrain.fuel_cell."));

// The same fleet with battery trucks on its mission.
export function electric(state, tables) {
    return { ...copy(state), vehicle: "tractor-electric-40t", extra: tables, curbT: null };
}
