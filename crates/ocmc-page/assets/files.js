// Files that were dropped: what was read of each, what is missing, and what it is used for.
import { element, line, fault } from "./dom.js";
import { grouped, rounded } from "./format.js";
import { job } from "./job.js";
import { mapSketch, profileSketch } from "./sketch.js";

const LARGEST = 64 << 20;

// A name without a folder, and without what file systems do not take.
const plain = name =>
    name
        .split(/[/\\]/)
        .pop()
        .replace(/[^\p{L}\p{N}._ -]/gu, "_") || "file";

// `on`: {changed(files), removed(name), calibrate(file, options), fleet(file, options),
// route(name, change)}.
export function filesPanel(engine, places, on) {
    const { drop, choose, list, wrong } = places;
    let known = [];
    const jobs = new Map();

    choose.addEventListener("change", async () => {
        await take([...choose.files]);
        choose.value = "";
    });
    // the window, so that a file beside the zone does not replace the page
    let inside = 0;
    addEventListener("dragover", event => event.preventDefault());
    addEventListener("dragenter", () => drop.classList.toggle("over", (inside += 1) > 0));
    addEventListener("dragleave", () => drop.classList.toggle("over", (inside -= 1) > 0));
    addEventListener("drop", event => {
        event.preventDefault();
        inside = 0;
        drop.classList.remove("over");
        take([...event.dataTransfer.files]);
    });

    async function take(files) {
        fault(wrong, "");
        try {
            for (const file of files) {
                if (file.size > LARGEST) throw new Error(`${file.name} is larger than 64 MB`);
                await engine.putFile(plain(file.name), new Uint8Array(await file.arrayBuffer()));
            }
            await read();
        } catch (error) {
            fault(wrong, error.message);
        }
    }

    async function read() {
        const { answer } = await engine.ask({ ask: "files" });
        const before = new Set(known.map(file => file.file));
        const gone = known.length;
        known = answer.files;
        on.changed(
            known,
            known.filter(file => !before.has(file.file)).map(file => file.file),
            gone,
        );
    }

    async function remove(name, button) {
        button.disabled = true;
        fault(wrong, "");
        try {
            on.removed(name);
            jobs.get(name)?.press.stop();
            jobs.delete(name);
            await engine.removeFile(name);
            await read();
            choose.focus();
        } catch (error) {
            button.disabled = false;
            fault(wrong, error.message);
        }
    }

    function card(file, state) {
        const title = element("h3", {}, file.file);
        const away = element(
            "button",
            { type: "button", class: "small", onclick: () => remove(file.file, away) },
            "Remove",
        );
        away.setAttribute("aria-label", `Remove ${file.file}`);
        const parts = [element("div", { class: "top" }, title, away), line(size(file), "soft")];
        const sketches = [
            file.profile && profileSketch(file.profile, `Altitude along ${file.file}`),
            file.map && mapSketch(file.map, `Way of ${file.file} on the map`),
        ].filter(Boolean);
        if (sketches.length) parts.push(element("div", { class: "sketches" }, ...sketches));
        if (file.reason) parts.push(line(file.reason, "warning"));
        const count = file.warnings.length;
        // the card has its name
        const told = text => text.replace(`\`${file.file}\`: `, "");
        if (count + file.told.length > 0) {
            const warned =
                count === 0 ? "" : count === 1 ? ", and a warning" : `, and ${count} warnings`;
            parts.push(
                element(
                    "details",
                    {},
                    element("summary", {}, `What was read${warned}`),
                    element("ul", {}, ...file.told.map(text => element("li", {}, told(text)))),
                    ...file.warnings.map(text => line(told(text), "warning soft")),
                ),
            );
        }
        if (file.route) parts.push(drive(file, state.routes[file.file]));
        if (file.kind === "totals" && !file.reason) parts.push(jobOf(file.file, calibration));
        if (file.kind === "fleet" && !file.reason) parts.push(jobOf(file.file, fleet));
        return element("article", { class: "file" }, ...parts);
    }

    function size(file) {
        const length = file.length_m ? `, ${rounded(file.length_m / 1000)} km` : "";
        const climb = file.climb_m ? `, climbs ${grouped(Math.round(file.climb_m))} m` : "";
        return `${file.words}${length}${climb}`;
    }

    function drive(file, route) {
        const use = element("input", {
            type: "checkbox",
            checked: route?.use ?? false,
            onchange: () => on.route(file.file, { use: use.checked }),
        });
        const weight = element("input", {
            type: "number",
            min: "1",
            step: "1",
            value: String(route?.weight ?? 1),
            inputmode: "decimal",
            oninput: () => {
                const value = Number(weight.value);
                if (value > 0) on.route(file.file, { weight: value });
            },
        });
        use.setAttribute("aria-label", `Drive it: ${file.file}`);
        weight.setAttribute("aria-label", `as often as, ${file.file}`);
        return element(
            "div",
            { class: "drive" },
            element("label", {}, use, "Drive it"),
            element("label", {}, "as often as", weight),
        );
    }

    // A job stays when the cards are made anew: it may be under way.
    function jobOf(name, make) {
        if (!jobs.has(name)) {
            const told = element("div", { role: "status" });
            const press = make(name, told);
            jobs.set(name, { told, press, node: element("div", {}, ...press.nodes, told) });
        }
        return jobs.get(name).node;
    }

    function calibration(name) {
        const press = job("Calibrate to this table", options => on.calibrate(name, options), read);
        const hint =
            "Half a minute: judged numbers of the study are moved until it takes what the table " +
            "says.";
        return { nodes: [press.node, line(hint, "soft")], stop: press.stop };
    }

    function fleet(name, told) {
        const done = () =>
            told.replaceChildren(element("a", { href: "#fleet-section" }, "To its totals"));
        const press = job("Drive this fleet", options => on.fleet(name, options), done);
        const hint = "All groups, with the trucks, trips and prices of the file.";
        return { nodes: [press.node, line(hint, "soft")], stop: press.stop };
    }

    return {
        get files() {
            return known;
        },
        read,
        // What a calibration has told, below its table.
        tell(name, nodes) {
            jobs.get(name)?.told.replaceChildren(...nodes);
        },
        show(state) {
            list.classList.toggle("many", known.length > 5);
            list.replaceChildren(...known.map(file => card(file, state)));
        },
    };
}
