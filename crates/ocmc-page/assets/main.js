// The page: what the planner says goes into one state, and each change of it asks the engine.
import { answerLoop } from "./planner.js";
import { byId, fault } from "./dom.js";
import { open } from "./engine.js";

try {
    await answerLoop(await open());
} catch (error) {
    byId("state").textContent = "";
    fault(byId("broken"), `The engine does not start: ${error.message}`);
}
