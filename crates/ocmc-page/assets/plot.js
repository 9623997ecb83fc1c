// Plots: uPlot in the colours of the page, as wide as their place, with words for screen readers.
import uPlot from "./vendor/uPlot.esm.js";

const colour = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const FONT = "12px system-ui, sans-serif";
const dark = matchMedia("(prefers-color-scheme: dark)");
const drawn = new Map();

const resize = new ResizeObserver(entries => {
    for (const { target } of entries) {
        const plot = drawn.get(target)?.plot;
        const width = Math.floor(target.clientWidth);
        if (plot && width > 0 && width !== plot.width) plot.setSize({ width, height: plot.height });
    }
});

dark.addEventListener("change", () => {
    for (const [place, { of }] of [...drawn]) draw(place, of);
});

export const bars = () => uPlot.paths.bars({ size: [0.94, Infinity], align: 1 });
export const steps = () => uPlot.paths.stepped({ align: 1 });

function axis(name, unit, side, values) {
    return {
        stroke: colour("--soft"),
        font: FONT,
        labelFont: FONT,
        label: unit,
        labelSize: 18,
        grid: { stroke: colour("--line"), width: 1 },
        ticks: { stroke: colour("--line"), width: 1 },
        size: side === 3 ? 52 : 34,
        side,
        scale: name,
        values,
    };
}

// Draws, in place of what was drawn there.
// `of`: {data, series: [{name, colour, fill, down, dash, paths, width}],
// x, y (names with units), height, words, range, sync}.
export function draw(place, of) {
    clear(place);
    const series = of.series.map(one => ({
        label: one.name,
        stroke: colour(one.colour),
        width: one.width ?? 1.5,
        dash: one.dash,
        fill: one.fill && colour(one.fill),
        fillTo: one.down ? (_, k, low) => low : undefined,
        paths: one.paths?.(),
        points: { show: false },
        spanGaps: false,
    }));
    // of the newest numbers
    const range = side => of[side] && ((...ends) => (drawn.get(place)?.of ?? of)[side](...ends));
    const options = {
        width: Math.max(200, Math.floor(place.clientWidth)),
        height: of.height ?? 220,
        legend: { show: false },
        cursor: {
            drag: { x: true, y: false },
            points: { show: !of.quiet },
            sync: of.sync && { key: of.sync },
        },
        scales: { x: { time: false, range: range("xRange") }, y: { range: range("yRange") } },
        axes: [axis("x", of.x, 2, of.xValues), axis("y", of.y, 3, of.yValues)],
        series: [{}, ...series],
        padding: [10, 14, 0, 0],
        hooks: { setCursor: [plot => of.onCursor?.(plot.cursor.idx)] },
    };
    place.setAttribute("role", "img");
    place.setAttribute("aria-label", of.words);
    const plot = new uPlot(options, of.data, place);
    drawn.set(place, { plot, of });
    resize.observe(place);
}

// New numbers for the same lines, without making the plot anew.
export function redraw(place, of) {
    const known = drawn.get(place);
    const same =
        known &&
        known.of.series.length === of.series.length &&
        known.of.x === of.x &&
        known.of.y === of.y;
    if (!same) return draw(place, of);
    known.of = of;
    place.setAttribute("aria-label", of.words);
    known.plot.setData(of.data);
}

export function clear(place) {
    const known = drawn.get(place);
    if (!known) return;
    resize.unobserve(place);
    known.plot.destroy();
    drawn.delete(place);
    place.replaceChildren();
}

// Takes away the plots below a node before it goes.
export function clearIn(node) {
    for (const place of [...drawn.keys()]) if (node.contains(place)) clear(place);
}

// The lines of a plot and their names.
export function legend(series) {
    const made = document.createElement("div");
    made.className = "legend";
    for (const one of series) {
        const line = document.createElement("i");
        line.style.background = `var(${one.colour})`;
        const name = document.createElement("span");
        name.append(line, one.name);
        made.append(name);
    }
    return made;
}
