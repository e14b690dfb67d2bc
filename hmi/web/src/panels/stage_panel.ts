// Around the drawn picture: which view is large, back to the first look, sound, and the veil over what is stale.
import { Stage } from "../scene/stage";
import { headline, isStale, sessionEnded } from "../situation";
import type { Sound } from "../sound";
import type { Store, ViewName } from "../store";
import { element, say } from "./elements";

const viewNames: Readonly<Record<ViewName, string>> = { part: "Part", cell: "Cell" };

function button(label: string, onClick: () => void): HTMLButtonElement {
    const made = element("button", "tool", { type: "button" }, label);
    made.addEventListener("click", onClick);
    return made;
}

export function mountStage(root: HTMLElement, store: Store, sound: Sound): () => void {
    const inset = element("button", "inset", { type: "button" });
    const insetName = element("span", "inset-name");
    const veil = element("div", "veil", { "aria-hidden": "true" });
    inset.append(insetName);
    inset.addEventListener("click", () => store.update({ view: store.state.view === "part" ? "cell" : "part" }));

    let stage: Stage | null = null;
    const switches = (["part", "cell"] as const).map((view) => {
        const made = button(viewNames[view], () => store.update({ view }));
        made.dataset["view"] = view;
        return { view, made };
    });
    const soundSwitch = button("", () => void (store.state.sound === "on" ? sound.turnOff() : sound.turnOn()));
    soundSwitch.classList.add("sound");
    const tools = element(
        "div",
        "tools",
        {},
        element("div", "segments", { role: "group", "aria-label": "View" }, ...switches.map(({ made }) => made)),
        button("Reset view", () => stage?.goHome()),
        soundSwitch,
    );
    const brand = element("div", "brand", {}, element("img", "", { src: "icon.svg", alt: "" }), "Deixis");
    root.append(brand, inset, veil, tools);
    try {
        stage = new Stage(root, inset, store);
    } catch {
        root.append(element("p", "no-graphics", {}, "This browser draws no 3D picture (WebGL is off). Marks and states are still right."));
    }

    const unwatch = store.watch(["view", "sound", "live", "link", "now"], (state) => {
        for (const { view, made } of switches) made.setAttribute("aria-pressed", String(view === state.view));
        say(insetName, viewNames[state.view === "part" ? "cell" : "part"]);
        say(soundSwitch, state.sound === "on" ? "Sound on" : "Sound off");
        soundSwitch.setAttribute("aria-pressed", String(state.sound === "on"));
        const stale = isStale(state) && state.live !== null;
        root.classList.toggle("stale", stale && !sessionEnded(state));
        say(veil, stale ? headline(state).title : "");
    });
    return () => {
        unwatch();
        stage?.dispose();
    };
}
