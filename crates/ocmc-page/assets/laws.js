// Laws from which values are drawn: a number, or an object with a `distribution`.

// Parameters that scale with the values of a law.
const SCALES = ["mean", "sd", "lower", "upper", "median", "scale"];

// The law of `factor` times its values.
export function scaled(law, factor) {
    if (typeof law === "number") return tidy(law * factor);
    const made = { ...law };
    for (const key of SCALES) if (typeof law[key] === "number") made[key] = tidy(law[key] * factor);
    if (law.components) made.components = law.components.map(part => scaled(part, factor));
    if (law.values) made.values = law.values.map(value => tidy(value * factor));
    return made;
}

const tidy = number => Number(number.toPrecision(12));

// Mean and standard deviation, ends of truncated laws left aside.
export function moments(law) {
    if (typeof law === "number") return { mean: law, sd: 0 };
    switch (law?.distribution) {
        case "normal":
            return { mean: law.mean, sd: law.sd };
        case "log_normal": {
            const mean = law.median * Math.exp(law.log_sd ** 2 / 2);
            return { mean, sd: mean * Math.sqrt(Math.exp(law.log_sd ** 2) - 1) };
        }
        case "uniform":
            return {
                mean: (law.lower + law.upper) / 2,
                sd: (law.upper - law.lower) / Math.sqrt(12),
            };
        case "exponential":
            return { mean: law.mean, sd: law.mean };
        case "gamma":
            return { mean: law.mean, sd: law.mean / Math.sqrt(law.shape) };
        case "beta": {
            const { alpha, beta, scale } = law;
            const sum = alpha + beta;
            const sd = (scale * Math.sqrt((alpha * beta) / (sum + 1))) / sum;
            return { mean: (scale * alpha) / sum, sd };
        }
        case "mixture":
            return mixed(law.weights, law.components.map(moments));
        case "empirical": {
            const parts = law.values.map(moments);
            return mixed(law.weights ?? parts.map(() => 1), parts);
        }
        default:
            return { mean: law?.mean ?? null, sd: null };
    }
}

function mixed(weights, parts) {
    const all = weights.reduce((sum, weight) => sum + weight, 0);
    const over = of => parts.reduce((sum, part, k) => sum + (weights[k] / all) * of(part), 0);
    const mean = over(part => part.mean);
    const square = over(part => part.sd ** 2 + part.mean ** 2);
    return { mean, sd: Math.sqrt(Math.max(0, square - mean ** 2)) };
}

// The number that a slider shows of a law.
export const centre = law => (typeof law === "number" ? law : (law?.median ?? moments(law).mean));

// A law in a few words.
export function lawWords(law) {
    if (law === null || law === undefined) return "none";
    if (Array.isArray(law)) return law.length > 4 ? `${law.length} numbers` : `[${law.join(", ")}]`;
    if (typeof law !== "object") return String(law);
    const { distribution, ...numbers } = law;
    if (law.components) return `a mixture of ${law.components.length} laws`;
    if (!distribution) return `a table of ${Object.keys(law).length} keys`;
    const told = Object.entries(numbers).filter(([, value]) => typeof value === "number");
    return [distribution, ...told.map(([key, value]) => `${key} ${value}`)].join(", ");
}
