// The bottom line: every sensor, the PLC, the record and the session, each in a word.
import { isStale, plcSeverity, recordSeverity, sensorSeverity, type Severity } from "../situation";
import type { ScreenState, Store } from "../store";
import { element, Glyph, say } from "./elements";

interface Tile {
    readonly name: string;
    readonly severity: Severity;
    readonly word: string;
    readonly fact: string;
}

function tilesOf(state: ScreenState): readonly Tile[] {
    const live = state.live;
    if (live === null) return [];
    const sensors = live.sensors.map((sensor) => ({
        name: `Sensor ${sensor.name}`,
        severity: sensorSeverity(sensor),
        word: sensor.state,
        fact:
            `${sensor.frames.toLocaleString("en-GB")} frames` +
            (sensor.dropped > 0 ? `, ${sensor.dropped} dropped` : "") +
            (sensor.restarts > 0 ? `, ${sensor.restarts} restarts` : ""),
    }));
    const source =
        live.progress === null
            ? { word: "live", fact: "" }
            : { word: "replay", fact: `${live.session} \u00b7 ${Math.round(live.progress * 100)} %` };
    return [
        ...sensors,
        { name: "PLC", severity: plcSeverity(live.plc), word: live.plc.state, fact: live.plc.reason },
        { name: "Record", severity: recordSeverity(live.record), word: live.record.state, fact: live.record.reason },
        { name: "Source", severity: "normal", ...source },
    ];
}

class TileView {
    readonly element: HTMLElement;
    private readonly sign = new Glyph();
    private readonly name = element("span", "name");
    private readonly word = element("span", "word");
    private readonly fact = element("span", "fact");

    constructor() {
        this.element = element("div", "tile", {}, this.sign.element, element("div", "words", {}, this.name, this.word), this.fact);
    }

    show(tile: Tile, stale: boolean): void {
        this.element.className = `tile ${tile.severity}`;
        this.element.dataset["tile"] = tile.name;
        this.sign.show(tile.severity);
        say(this.name, tile.name);
        say(this.word, stale ? `was ${tile.word}` : tile.word);
        say(this.fact, tile.fact);
        this.element.title = tile.fact;
    }
}

export function mountHealth(root: HTMLElement, store: Store): () => void {
    let views: TileView[] = [];
    return store.watch(["live", "link", "now"], (state) => {
        const tiles = tilesOf(state);
        if (tiles.length !== views.length) {
            views = tiles.map(() => new TileView());
            root.replaceChildren(...views.map((view) => view.element));
        }
        // Without a link nobody knows; without frames the sensors' own words are still fresh.
        const unknown = state.link === "lost" && isStale(state);
        root.classList.toggle("stale", unknown);
        tiles.forEach((tile, i) => views[i]?.show(tile, unknown));
    });
}
