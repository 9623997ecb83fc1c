// What the planner keeps: files, and the command that answers the same.
import { byId, download, fault } from "./dom.js";

export const plainName = text =>
    text
        .trim()
        .toLowerCase()
        .replace(/[^\p{L}\p{N}]+/gu, "-")
        .replace(/^-+|-+$/g, "") || "my-fleet";

export function savePanel(engine, current, renamed) {
    const name = byId("name");
    name.addEventListener("input", () => renamed(plainName(name.value)));
    name.addEventListener("change", () => {
        name.value = plainName(name.value);
    });

    const files = [
        ["save-study", "study.toml", own => `${own}.toml`],
        ["save-xlsx", "fleet.xlsx", own => `${own}.xlsx`],
        ["save-report", "report.html", own => `${own}.html`],
    ];
    for (const [id, kind, file] of files) {
        const button = byId(id);
        button.hidden = engine.kind !== "native" && kind !== "study.toml";
        button.addEventListener("click", async () => {
            const now = current();
            if (!now) return;
            fault(byId("save-fault"), "");
            const words = button.textContent;
            button.disabled = true;
            button.textContent = `${words} …`;
            try {
                download(file(now.state.name), await engine.save(kind, now.question));
            } catch (error) {
                fault(byId("save-fault"), error.message);
            } finally {
                button.disabled = false;
                button.textContent = words;
            }
        });
    }

    byId("copy").addEventListener("click", async () => {
        const said = byId("copied");
        try {
            await navigator.clipboard.writeText(byId("command").textContent);
            said.textContent = "Copied";
        } catch {
            getSelection().selectAllChildren(byId("command"));
            said.textContent = "Selected: copy it by the keys of your system";
        }
        setTimeout(() => {
            said.textContent = "";
        }, 4000);
    });

    return {
        show(state, beside) {
            if (document.activeElement !== name) name.value = state.name;
            byId("command").textContent =
                `ocmc --study ${state.name}.toml --trucks ${state.trucks} --seed ${state.seed}`;
            byId("beside").textContent =
                beside.length > 0 ? `Put beside the study file: ${beside.join(", ")}` : "";
        },
    };
}
