// Messages as the station would send them, for the tests of the page's logic.
import { parseLive, type LiveMessage } from "../../../hmi/web/src/protocol";

export const identity = { rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], translation: [0, 0, 0.9] };

/** The JSON object of a live message where all is well; `changes` replace its members. */
export function liveObject(changes: Readonly<Record<string, unknown>> = {}): Record<string, unknown> {
    return {
        frame: frameObject(33333),
        sensors: [{ name: "left", state: "running", reason: "", frames: 1, dropped: 0, restarts: 0, age_ms: 3 }],
        plc: { state: "alive", reason: "" },
        record: { state: "ready", reason: "" },
        session: "demo",
        progress: 0.5,
        finished: false,
        trouble: "",
        stale_after_ms: 1000,
        marks_total: 0,
        ...changes,
    };
}

export function frameObject(timestampUs: number, changes: Readonly<Record<string, unknown>> = {}): Record<string, unknown> {
    return {
        timestamp_us: timestampUs,
        part: { state: "tracking", ...identity, at_rest: true, fitness: 0.9, reason: "" },
        pointing: null,
        ...changes,
    };
}

export function liveMessage(changes: Readonly<Record<string, unknown>> = {}): LiveMessage {
    return parseLive(liveObject(changes));
}

export function markObject(id: number, changes: Readonly<Record<string, unknown>> = {}): Record<string, unknown> {
    return {
        id,
        position_part: [0.3, 0, 0.1],
        normal_part: [0, -1, 0],
        zone: "upper left",
        arm: "right",
        time: "2026-01-05T09:30:07Z",
        confidence: 0.9,
        state: "open",
        touch: false,
        ...changes,
    };
}
