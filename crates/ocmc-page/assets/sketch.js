// Sketches of a road: its altitude along the way, and its way on the map.
const SVG = "http://www.w3.org/2000/svg";

function shape(name, attributes) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return made;
}

function picture(words, box, stretched, ...shapes) {
    const made = shape("svg", {
        viewBox: box,
        role: "img",
        "aria-label": words,
        preserveAspectRatio: stretched ? "none" : "xMidYMid meet",
    });
    made.append(...shapes);
    return made;
}

const ends = values => {
    let [low, high] = [Infinity, -Infinity];
    for (const value of values) {
        low = Math.min(low, value);
        high = Math.max(high, value);
    }
    return [low, high];
};

const points = pairs => pairs.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");

export function profileSketch({ position_m, altitude_m }, words) {
    const [low, high] = ends(altitude_m);
    const length = position_m.at(-1) || 1;
    const room = Math.max(high - low, 20);
    const way = position_m.map((x, k) => [
        (300 * x) / length,
        55 - (48 * (altitude_m[k] - low)) / room,
    ]);
    return picture(
        words,
        "0 0 300 60",
        true,
        shape("polygon", { class: "area", points: points([[0, 60], ...way, [300, 60]]) }),
        shape("polyline", { class: "way", points: points(way) }),
    );
}

export function mapSketch({ latitude_deg, longitude_deg }, words) {
    const [south, north] = ends(latitude_deg);
    const narrow = Math.cos((((south + north) / 2) * Math.PI) / 180);
    const [west, east] = ends(longitude_deg);
    const size = Math.max((east - west) * narrow, north - south) || 1;
    const at = k => [
        (100 * (longitude_deg[k] - west) * narrow) / size,
        (100 * (north - latitude_deg[k])) / size,
    ];
    const way = latitude_deg.map((_, k) => at(k));
    const [wide, high] = [(100 * (east - west) * narrow) / size, (100 * (north - south)) / size];
    const [x, y] = way[0];
    return picture(
        words,
        `-8 -8 ${(wide + 16).toFixed(1)} ${(high + 16).toFixed(1)}`,
        false,
        shape("polyline", { class: "way", points: points(way) }),
        shape("path", { class: "from", d: `M${x.toFixed(1)} ${y.toFixed(1)}h.01` }),
    );
}
