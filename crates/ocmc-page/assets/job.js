// A press that asks something longer: its progress, and a way out of it.
import { element, fault, isAbort } from "./dom.js";

// `work(options)` asks with `signal` and `onProgress`; what it gives is shown by `done`.
export function job(words, work, done = () => {}) {
    const press = element("button", { type: "button" }, words);
    const bar = element("progress", { max: 1, value: 0, hidden: true });
    bar.setAttribute("aria-label", words);
    const cancel = element("button", { type: "button", hidden: true }, "Cancel");
    const wrong = element("div", { role: "alert" });
    let control = null;

    press.addEventListener("click", async () => {
        control?.abort();
        const own = (control = new AbortController());
        const { signal } = own;
        fault(wrong, "");
        press.disabled = true;
        bar.hidden = cancel.hidden = false;
        bar.removeAttribute("value");
        try {
            const onProgress = ({ done: now, total }) => {
                bar.value = total ? now / total : 0;
            };
            const answer = await work({ signal, onProgress });
            if (!signal.aborted) done(answer);
        } catch (error) {
            if (!isAbort(error) && !signal.aborted) fault(wrong, error.message);
        } finally {
            if (control === own) stop();
        }
    });
    cancel.addEventListener("click", () => {
        stop();
        press.focus();
    });

    function stop() {
        control?.abort();
        control = null;
        press.disabled = false;
        bar.hidden = cancel.hidden = true;
    }

    return {
        node: element("div", {}, element("div", { class: "buttons" }, press, bar, cancel), wrong),
        stop,
    };
}
