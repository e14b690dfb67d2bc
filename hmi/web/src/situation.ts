// What it all means to the person in front: the headline, the alarms, what is stale. Pure: state in, words out.
import type { Health, SensorHealth } from "./protocol";
import type { ScreenState } from "./store";

/** From calm to urgent; each has its own shape beside its colour. */
export type Severity = "normal" | "attention" | "fault";

export interface Headline {
    readonly severity: Severity;
    readonly title: string;
    readonly detail: string;
}

export interface Alarm {
    readonly severity: Severity;
    /** What is wrong. */
    readonly text: string;
    /** What to do about it. */
    readonly response: string;
}

const linkGraceMs = 1500;
const troubleShownMs = 30_000;

/** How long ago the last frame was new [ms]; null before the first. */
export function frameAge(state: ScreenState): number | null {
    return state.frameAt === null ? null : Math.max(0, state.now - state.frameAt);
}

export function sessionEnded(state: ScreenState): boolean {
    return state.live?.finished === true;
}

/** Whether what is drawn of the moment (pose, worker, ray) may no longer be believed. */
export function isStale(state: ScreenState): boolean {
    if (state.link === "lost") return true;
    const age = frameAge(state);
    return age === null || state.live === null || age > state.live.staleAfterMs;
}

export function seconds(ms: number): string {
    return ms < 60_000 ? `${Math.floor(ms / 1000)} s` : `${Math.floor(ms / 60_000)} min`;
}

function sentence(text: string): string {
    const trimmed = text.trim();
    if (trimmed === "") return "";
    const capital = trimmed.charAt(0).toUpperCase() + trimmed.slice(1);
    return /[.!?]$/.test(capital) ? capital : `${capital}.`;
}

function join(title: string, reason: string): string {
    return reason === "" ? title : `${title}: ${reason.replace(/\.$/, "")}`;
}

export function headline(state: ScreenState): Headline {
    if (state.link === "lost")
        return { severity: "fault", title: "No connection to the station", detail: "Trying again. What is shown may be old." };
    if (state.live === null)
        return { severity: "normal", title: "Starting", detail: "Waiting for the first word from the station." };
    if (sessionEnded(state) && isStale(state))
        return { severity: "normal", title: "End of the recording", detail: "Everything in it has been seen." };
    const frame = state.live.frame;
    const age = frameAge(state);
    if (frame === null || age === null)
        return { severity: "attention", title: "No picture yet", detail: "Waiting for the first frame of the sensors." };
    if (isStale(state))
        return { severity: "fault", title: `No frame for ${seconds(age)}`, detail: "Do not point now: nothing is seen." };
    const part = frame.part;
    const reason = part?.reason ?? "";
    switch (part?.state ?? "absent") {
        case "absent":
            return { severity: "attention", title: "No part", detail: sentence(reason) || "Bring the part into the cell." };
        case "searching":
            return { severity: "attention", title: "Part not locked: searching", detail: sentence(reason) || "Step back for a moment." };
        case "ambiguous":
            return { severity: "attention", title: "Part not locked: ambiguous", detail: sentence(reason) || "Turn or move the part a little." };
        case "lost":
            return { severity: "attention", title: "Part not locked: lost", detail: sentence(reason) || "Leave the part still for a moment." };
        case "tracking":
            break;
    }
    if (part?.atRest !== true)
        return { severity: "attention", title: "Part is moving", detail: "Marks are taken when it rests." };
    if (frame.pointing === null) return { severity: "normal", title: "Ready", detail: "Point at a defect and hold." };
    const arm = frame.pointing.arm === "left" ? "Left arm" : "Right arm";
    if (frame.pointing.hitPart === null)
        return { severity: "normal", title: "Pointing past the part", detail: `${arm} seen.` };
    return { severity: "normal", title: "Pointing", detail: `${arm} seen. Hold still to mark.` };
}

const sensorSeverities: Readonly<Record<string, Severity>> = {
    running: "normal",
    finished: "normal",
    starting: "attention",
    restarting: "attention",
};
const plcSeverities: Readonly<Record<string, Severity>> = { off: "normal", alive: "normal" };
const recordSeverities: Readonly<Record<string, Severity>> = {
    ready: "normal",
    writing: "normal",
    retrying: "attention",
};

/** A sensor that is neither well nor coming back is a fault, whatever its word. */
export function sensorSeverity(sensor: SensorHealth): Severity {
    return sensorSeverities[sensor.state] ?? "fault";
}

/** Without its PLC the station goes on: marks are kept and sent later. */
export function plcSeverity(plc: Health): Severity {
    return plcSeverities[plc.state] ?? "attention";
}

/** Without its record the station is of no use. */
export function recordSeverity(record: Health): Severity {
    return recordSeverities[record.state] ?? "fault";
}

/** All that is wrong besides what the headline says, most urgent first. */
export function alarms(state: ScreenState): readonly Alarm[] {
    const found: Alarm[] = [];
    if (state.misunderstood !== "")
        found.push({ severity: "attention", text: state.misunderstood, response: "Reload this page." });
    if (state.link !== "lost" && state.live !== null) {
        const record = recordSeverity(state.live.record);
        if (record !== "normal")
            found.push({
                severity: record,
                text: sentence(join(`Record ${state.live.record.state}`, state.live.record.reason)),
                response:
                    record === "fault" ? "No marks are kept. Call maintenance." : "Marks wait until it can be written.",
            });
        for (const sensor of state.live.sensors) {
            const severity = sensorSeverity(sensor);
            if (severity === "normal") continue;
            found.push({
                severity,
                text: sentence(join(`Sensor ${sensor.name} ${sensor.state}`, sensor.reason)),
                response: severity === "fault" ? "Check its cable and power." : "The station is bringing it back.",
            });
        }
        if (state.live.trouble !== "" && state.now - state.troubleAt < troubleShownMs)
            found.push({ severity: "attention", text: sentence(state.live.trouble), response: "See the station's log." });
        const plc = plcSeverity(state.live.plc);
        if (plc !== "normal")
            found.push({
                severity: plc,
                text: sentence(join(`PLC ${state.live.plc.state}`, state.live.plc.reason)),
                response: "Marks are kept and sent later.",
            });
    }
    const rank = { fault: 0, attention: 1, normal: 2 };
    return found.sort((a, b) => rank[a.severity] - rank[b.severity]);
}

/** Whether the connection has been away long enough to alarm anyone. */
export function linkIsLost(closedAt: number | null, now: number): boolean {
    return closedAt !== null && now - closedAt >= linkGraceMs;
}

/** Defects that count: all but the withdrawn. */
export function standingMarks(state: ScreenState): number {
    return state.marks.filter((mark) => mark.state !== "withdrawn").length;
}
