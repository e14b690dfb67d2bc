// Puts the page together: one store, one connection, the panels around the drawn picture.
import { Connection } from "./connection";
import { mountAlarms } from "./panels/alarms_panel";
import { mountHeadline } from "./panels/headline_panel";
import { mountHealth } from "./panels/health_panel";
import { mountMarks } from "./panels/marks_panel";
import { mountStage } from "./panels/stage_panel";
import { Sound } from "./sound";
import { Store } from "./store";

function place(id: string): HTMLElement {
    const found = document.getElementById(id);
    if (found === null) throw new Error(`The page has no element "${id}".`);
    return found;
}

// Numbers on the dots are drawn once into pictures: not before their typeface is there.
await document.fonts.load('700 16px "Inter Variable"', "0");

const store = new Store();
const sound = new Sound(store);
const unmount = [
    mountHeadline(place("headline"), store),
    mountAlarms(place("alarms"), store),
    mountStage(place("stage"), store, sound),
    mountMarks(place("marks"), store),
    mountHealth(place("health"), store),
];
const connection = new Connection(store);

window.addEventListener("pagehide", () => {
    connection.dispose();
    sound.dispose();
    for (const end of unmount) end();
});
