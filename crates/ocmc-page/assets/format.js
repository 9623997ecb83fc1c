// Numbers as the program prints them on a terminal: to the same last digit.

// Rounds to decimals; ties go to the even digit, as they do there.
export function fixed(number, digits) {
    const text = number.toFixed(digits);
    return isTie(number, digits) ? evenOf(number, digits, text) : text;
}

function isTie(number, digits) {
    // all digits of a double lie within these
    const exact = Math.abs(number) < 1e21 ? number.toFixed(Math.min(100, digits + 60)) : "";
    const rest = exact.slice(exact.indexOf(".") + 1 + digits);
    return /^50*$/.test(rest);
}

function evenOf(number, digits, text) {
    if (Number(text.at(-1)) % 2 === 0) return text;
    const towardsZero = number.toFixed(digits + 1);
    return towardsZero.slice(0, digits === 0 ? -2 : -1);
}

export function grouped(number) {
    return String(Math.trunc(number)).replace(/\B(?=(\d{3})+$)/g, ",");
}

export const countOf = (number, thing) => `${grouped(number)} ${thing}${number === 1 ? "" : "s"}`;

// A share in per cent, to a tenth.
export function percent(share) {
    const text = fixed(100 * share, 1);
    return text === "-0.0" ? "0.0" : text;
}

// Decimals with which a number has about four digits.
export function decimals(number) {
    const size = Math.abs(number);
    if (size >= 1000 || !Number.isFinite(size)) return 0;
    return size >= 100 ? 1 : size >= 10 ? 2 : size >= 1 ? 3 : 4;
}

// About four digits, with commas from a thousand on.
export function rounded(number) {
    if (Math.abs(number) >= 1000) {
        return (number < 0 ? "-" : "") + grouped(Math.round(Math.abs(number)));
    }
    return fixed(number, decimals(number));
}

// Three digits.
export function rough(number) {
    if (!Number.isFinite(number)) return "-";
    if (number === 0) return "0";
    const power = Math.floor(Math.log10(Math.abs(number)));
    const unit = 10 ** (power - 2);
    const digits =
        power > 2 ? unit * Number(fixed(number / unit, 0)) : Number(fixed(number, 2 - power));
    return digits >= 100 ? grouped(digits) : String(digits);
}

// Hundredths, whole numbers from a hundred on.
export const short = number => (number < 100 ? fixed(number, 2) : grouped(number));

export function twoDigits(number) {
    const digits = number > 0 ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(number)))) : 1;
    return fixed(number, digits);
}

// Decimals that show half the width of an interval with two digits.
export function decimalsFor(half) {
    const known = half > 0 && Number.isFinite(half);
    return known ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(half)))) : 3;
}

export const signed = (number, digits) => (number < 0 ? "" : "+") + fixed(number, digits);

export const half = ([low, high]) => (high - low) / 2;

// What quantities are called, and the factor to the unit in which people read them.
const LABELS = {
    consumption_l_per_100km: ["L/100 km", 1],
    consumption_l_per_100tkm: ["L/100 tkm", 1],
    consumption_kwh_per_km: ["kWh/km", 1],
    consumption_kwh_per_tkm: ["kWh/tkm", 1],
    consumption_hydrogen_kg_per_100km: ["kg H2/100 km", 1],
    consumption_hydrogen_kg_per_100tkm: ["kg H2/100 tkm", 1],
    consumption_methane_kg_per_100km: ["kg CH4/100 km", 1],
    consumption_methane_kg_per_100tkm: ["kg CH4/100 tkm", 1],
    consumption_all_kwh_per_km: ["all kWh/km", 1],
    whole_trip_kwh_per_km: ["whole kWh/km", 1],
    wheel_kwh_per_km: ["traction kWh/km", 1],
    co2_g_per_km: ["g CO2/km", 1],
    grid_co2_g_per_km: ["grid g CO2e/km", 1],
    well_to_wheel_g_per_km: ["WTW g CO2e/km", 1],
    well_to_wheel_g_per_tkm: ["WTW g CO2e/tkm", 1],
    mean_speed_mps: ["speed, km/h", 3.6],
    duration_s: ["duration, h", 1 / 3600],
    stops_per_km: ["stops per km", 1],
};

export const label = column => LABELS[column] ?? [column, 1];

const CONSUMPTIONS = [
    "consumption_l_per_100km",
    "consumption_kwh_per_km",
    "consumption_hydrogen_kg_per_100km",
    "consumption_methane_kg_per_100km",
    "wheel_kwh_per_km",
];

// The consumption that a fleet is judged by.
export function consumptionOf(statistics) {
    return CONSUMPTIONS.find(
        column =>
            statistics?.[column] &&
            statistics[column].p50 !== null &&
            statistics[column].p50 !== undefined,
    );
}

// Totals of a fleet's year: key, name, unit, factor to it.
const TOTALS = [
    ["fuel_l", "fuel", "L", 1],
    ["battery_energy_j", "electricity", "MWh", 1 / 3.6e9],
    ["hydrogen_kg", "hydrogen", "kg", 1],
    ["methane_kg", "methane", "kg", 1],
    ["co2_kg", "CO2", "t", 1e-3],
    ["well_to_wheel_kg", "WTW CO2e", "t", 1e-3],
    ["cost", "cost", null, 1],
    ["distance_m", "distance", "km", 1e-3],
    ["duration_s", "time", "h", 1 / 3600],
];

// Totals that a fleet has, in the units of people; `scale` where a part of its year was driven.
export function totalsOf(trucks, scale = 1) {
    if (!trucks) return [];
    return TOTALS.filter(([key]) => trucks.fleet_year[key]).map(([key, name, unit, factor]) => {
        const { total, prediction95 } = trucks.fleet_year[key];
        return {
            key,
            name,
            unit: unit ?? trucks.currency ?? "",
            total: factor * total * scale,
            half: prediction95 && half(prediction95.map(end => factor * end)) * scale,
        };
    });
}

// Place of a total among all.
export const placeOf = key => TOTALS.findIndex(([known]) => known === key);

// A number for the inputs of the page: no digits of binary fractions.
export const tidy = (number, digits = 6) => Number(number.toPrecision(digits));
