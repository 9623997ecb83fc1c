// Keeps the answer up with the planner: a first look while a slider moves, then all trips.
import { isAbort } from "./dom.js";
import { lookQuestion, runQuestion, tripsAYear } from "./study.js";

// Trips of the first looks; a later one only where the whole is much longer.
const FIRST = 60;
const FEW = 20;
const SECOND = 1000;
// How long a change has to stand before all trips are driven, and a look may take, in ms.
const SETTLED = 250;
const LONGEST_LOOK = 1500;
// A first look that takes longer twice is slow here: it then has few trips, in ms.
const SLOW = 800;

const wait = (ms, signal) =>
    new Promise((done, failed) => {
        const timer = setTimeout(done, ms);
        signal.addEventListener(
            "abort",
            () => {
                clearTimeout(timer);
                failed(new DOMException("", "AbortError"));
            },
            { once: true },
        );
    });

// `on`: {ownOf(state) -> promise of values, begun(), look(message, look, state), progress(message),
// final(message, question, state, own), failed(reason)}
export function live(engine, on) {
    let newest = null;
    let looking = null;
    let driving = null;
    let slow = 0;

    function change(state) {
        newest = state;
        driving?.abort();
        driving = null;
        on.begun();
        if (!looking) next();
        else if (performance.now() - looking.since > longest()) looking.control.abort();
    }

    const longest = () => (slow < 2 ? LONGEST_LOOK : 4 * LONGEST_LOOK);

    // One look at a time: while it is on its way newer changes wait, the last of them counts.
    async function next() {
        while (newest) {
            const state = newest;
            newest = null;
            looking = { since: performance.now(), control: new AbortController() };
            try {
                const own = await on.ownOf(state);
                const asked = performance.now();
                const trips = slow < 2 ? FIRST : FEW;
                const look = await ask(state, own, trips, looking.control.signal);
                if (look) on.look(...look);
                if (slow < 2) slow = performance.now() - asked > SLOW ? slow + 1 : 0;
                if (!newest) drive(state, own);
            } catch (error) {
                if (isAbort(error)) slow += 1;
                if (!isAbort(error) && !newest) on.failed(error.message);
            }
        }
        looking = null;
    }

    async function ask(state, own, wanted, signal) {
        const { question, trips, scale } = lookQuestion(state, own, wanted);
        const of = state.trucks * tripsAYear(state, own);
        if (trips * 2 > of) return null;
        return [await engine.ask(question, { signal }), { trips, of, scale }, state];
    }

    async function drive(state, own) {
        const control = new AbortController();
        driving = control;
        const { signal } = control;
        try {
            await wait(SETTLED, signal);
            if (state.trucks * tripsAYear(state, own) > 4 * SECOND) {
                const look = await ask(state, own, SECOND, signal);
                if (look && !signal.aborted) on.look(...look);
            }
            const question = runQuestion(state, own);
            const onProgress = message => signal.aborted || on.progress(message);
            const message = await engine.ask(question, { signal, onProgress });
            if (!signal.aborted) on.final(message, question, state, own);
        } catch (error) {
            if (!isAbort(error) && !signal.aborted) on.failed(error.message);
        } finally {
            if (driving === control) driving = null;
        }
    }

    return {
        change,
        get busy() {
            return Boolean(looking || driving);
        },
    };
}
