// What the station says, checked at the edge: JSON and bytes in, typed values or one sentence out.

export type Vector = readonly [number, number, number];
/** Rows of a rotation matrix. */
export type Rotation = readonly [Vector, Vector, Vector];

/** b_from_a: p_b = rotation * p_a + translation [m]. */
export interface Pose {
    readonly rotation: Rotation;
    readonly translation: Vector;
}

export type PartState = "absent" | "searching" | "ambiguous" | "tracking" | "lost";

export interface PartEstimate {
    readonly state: PartState;
    /** Only with "tracking". */
    readonly worldFromPart: Pose | null;
    readonly atRest: boolean;
    readonly reason: string;
}

export interface Pointing {
    readonly arm: string;
    /** World frame. */
    readonly origin: Vector;
    readonly direction: Vector;
    /** Part frame; null while the ray misses the part. */
    readonly hitPart: Vector | null;
}

export interface Frame {
    readonly timestampUs: number;
    readonly part: PartEstimate | null;
    readonly pointing: Pointing | null;
}

export interface SensorHealth {
    readonly name: string;
    readonly state: string;
    readonly reason: string;
    readonly frames: number;
    readonly dropped: number;
    readonly restarts: number;
}

export interface Health {
    readonly state: string;
    readonly reason: string;
}

export interface LiveMessage {
    readonly frame: Frame | null;
    readonly sensors: readonly SensorHealth[];
    readonly plc: Health;
    readonly record: Health;
    readonly session: string;
    /** 0 to 1 of a replay; null when live. */
    readonly progress: number | null;
    /** The replay has come to its end. */
    readonly finished: boolean;
    /** The newest thing that went wrong, such as a mark that could not be recorded; empty when nothing did. */
    readonly trouble: string;
    readonly staleAfterMs: number;
    readonly marksTotal: number;
}

export type MarkState = "open" | "confirmed" | "withdrawn";

export interface Mark {
    readonly id: number;
    readonly position: Vector;
    readonly normal: Vector;
    readonly zone: string;
    readonly arm: string;
    readonly time: string;
    readonly confidence: number;
    readonly state: MarkState;
    readonly touch: boolean;
}

export interface Zone {
    readonly name: string;
    readonly min: Vector;
    readonly max: Vector;
}

export interface Part {
    readonly type: string;
    readonly serial: string;
    readonly zones: readonly Zone[];
    readonly meshTag: string;
}

export interface Mesh {
    /** x, y, z a vertex, part frame [m]. */
    readonly positions: Float32Array;
    /** Three corners a triangle. */
    readonly indices: Uint32Array;
}

export interface SensorView {
    readonly name: string;
    readonly width: number;
    readonly height: number;
    readonly fx: number;
    readonly fy: number;
    readonly cx: number;
    readonly cy: number;
    readonly cameraFromWorld: Pose;
}

export interface Cell {
    readonly sensors: readonly SensorView[];
    readonly box: { readonly min: Vector; readonly max: Vector } | null;
}

export interface Voxels {
    readonly timestampUs: number;
    /** Edge length [m]. */
    readonly size: number;
    /** x, y, z of each centre, world frame [m]. */
    readonly centres: Float32Array;
}

/** What the station said cannot be used; the message is one sentence for a person. */
export class ProtocolError extends Error {}

type Fields = Readonly<Record<string, unknown>>;

function fieldsOf(value: unknown, name: string): Fields {
    if (typeof value !== "object" || value === null || Array.isArray(value))
        throw new ProtocolError(`The station sent ${name} that is not an object.`);
    return value as Fields;
}

function listOf(value: unknown, name: string): readonly unknown[] {
    if (!Array.isArray(value)) throw new ProtocolError(`The station sent ${name} that is not a list.`);
    return value;
}

function numberOf(value: unknown, name: string): number {
    if (typeof value !== "number" || !Number.isFinite(value))
        throw new ProtocolError(`The station sent ${name} that is not a number.`);
    return value;
}

function textOf(value: unknown): string {
    return typeof value === "string" ? value : "";
}

function vectorOf(value: unknown, name: string): Vector {
    const items = listOf(value, name);
    if (items.length !== 3) throw new ProtocolError(`The station sent ${name} without three numbers.`);
    return [numberOf(items[0], name), numberOf(items[1], name), numberOf(items[2], name)];
}

function poseOf(value: Fields, name: string): Pose {
    const rows = listOf(value["rotation"], `${name}.rotation`);
    if (rows.length !== 3) throw new ProtocolError(`The station sent ${name}.rotation without three rows.`);
    return {
        rotation: [
            vectorOf(rows[0], `${name}.rotation`),
            vectorOf(rows[1], `${name}.rotation`),
            vectorOf(rows[2], `${name}.rotation`),
        ],
        translation: vectorOf(value["translation"], `${name}.translation`),
    };
}

const partStates: readonly string[] = ["absent", "searching", "ambiguous", "tracking", "lost"];

function partOf(value: unknown): PartEstimate | null {
    if (value === null || value === undefined) return null;
    const part = fieldsOf(value, "frame.part");
    const state = textOf(part["state"]);
    if (!partStates.includes(state)) throw new ProtocolError(`The station sent an unknown part state "${state}".`);
    return {
        state: state as PartState,
        worldFromPart: state === "tracking" ? poseOf(part, "frame.part") : null,
        atRest: part["at_rest"] === true,
        reason: textOf(part["reason"]),
    };
}

function pointingOf(value: unknown): Pointing | null {
    if (value === null || value === undefined) return null;
    const pointing = fieldsOf(value, "frame.pointing");
    const hit = pointing["hit_part"];
    return {
        arm: textOf(pointing["arm"]),
        origin: vectorOf(pointing["origin"], "frame.pointing.origin"),
        direction: vectorOf(pointing["direction"], "frame.pointing.direction"),
        hitPart: hit === null || hit === undefined ? null : vectorOf(hit, "frame.pointing.hit_part"),
    };
}

function frameOf(value: unknown): Frame | null {
    if (value === null || value === undefined) return null;
    const frame = fieldsOf(value, "frame");
    return {
        timestampUs: numberOf(frame["timestamp_us"], "frame.timestamp_us"),
        part: partOf(frame["part"]),
        pointing: pointingOf(frame["pointing"]),
    };
}

function healthOf(value: unknown, name: string): Health {
    const health = fieldsOf(value, name);
    return { state: textOf(health["state"]), reason: textOf(health["reason"]) };
}

/** The counters are for people: a missing one is shown as 0, not refused. */
function countOf(value: unknown): number {
    return typeof value === "number" && Number.isFinite(value) ? value : 0;
}

export function parseLive(value: unknown): LiveMessage {
    const live = fieldsOf(value, "a live message");
    const progress = live["progress"];
    return {
        frame: frameOf(live["frame"]),
        sensors: listOf(live["sensors"], "sensors").map((entry) => {
            const sensor = fieldsOf(entry, "a sensor");
            return {
                name: textOf(sensor["name"]),
                state: textOf(sensor["state"]),
                reason: textOf(sensor["reason"]),
                frames: countOf(sensor["frames"]),
                dropped: countOf(sensor["dropped"]),
                restarts: countOf(sensor["restarts"]),
            };
        }),
        plc: healthOf(live["plc"], "plc"),
        record: healthOf(live["record"], "record"),
        session: textOf(live["session"]),
        progress: typeof progress === "number" ? Math.min(1, Math.max(0, progress)) : null,
        finished: live["finished"] === true,
        trouble: textOf(live["trouble"]),
        staleAfterMs: numberOf(live["stale_after_ms"], "stale_after_ms"),
        marksTotal: numberOf(live["marks_total"], "marks_total"),
    };
}

/** `/api/state`: the last live message with its age, or null before the first. */
export function parseState(value: unknown): { readonly ageMs: number; readonly live: LiveMessage } | null {
    const state = fieldsOf(value, "a state");
    if (state["live"] === null) return null;
    return { ageMs: numberOf(state["age_ms"], "age_ms"), live: parseLive(state["live"]) };
}

export function parseMarks(value: unknown): readonly Mark[] {
    return listOf(value, "the marks").map((entry) => {
        const mark = fieldsOf(entry, "a mark");
        const state = textOf(mark["state"]);
        if (state !== "open" && state !== "confirmed" && state !== "withdrawn")
            throw new ProtocolError(`The station sent an unknown mark state "${state}".`);
        return {
            id: numberOf(mark["id"], "a mark's id"),
            position: vectorOf(mark["position_part"], "a mark's position_part"),
            normal: vectorOf(mark["normal_part"], "a mark's normal_part"),
            zone: textOf(mark["zone"]),
            arm: textOf(mark["arm"]),
            time: textOf(mark["time"]),
            confidence: countOf(mark["confidence"]),
            state,
            touch: mark["touch"] === true,
        };
    });
}

export function parsePart(value: unknown): Part {
    const part = fieldsOf(value, "the part");
    return {
        type: textOf(part["type"]),
        serial: textOf(part["serial"]),
        zones: listOf(part["zones"], "the zones").map((entry) => {
            const zone = fieldsOf(entry, "a zone");
            return {
                name: textOf(zone["name"]),
                min: vectorOf(zone["min"], "a zone's min"),
                max: vectorOf(zone["max"], "a zone's max"),
            };
        }),
        meshTag: textOf(part["mesh_etag"]),
    };
}

export function parseCell(value: unknown): Cell {
    const cell = fieldsOf(value, "the cell");
    const box = cell["cell"];
    return {
        sensors: listOf(cell["sensors"], "the cell's sensors").map((entry) => {
            const sensor = fieldsOf(entry, "a sensor");
            const number = (key: string) => numberOf(sensor[key], `a sensor's ${key}`);
            return {
                name: textOf(sensor["name"]),
                width: number("width"),
                height: number("height"),
                fx: number("fx"),
                fy: number("fy"),
                cx: number("cx"),
                cy: number("cy"),
                cameraFromWorld: poseOf(sensor, "a sensor"),
            };
        }),
        box:
            box === null || box === undefined
                ? null
                : {
                      min: vectorOf(fieldsOf(box, "the cell's box")["min"], "the cell's min"),
                      max: vectorOf(fieldsOf(box, "the cell's box")["max"], "the cell's max"),
                  },
    };
}

/** u32 vertex count, f32 x, y, z a vertex, u32 triangle count, u32 a, b, c a triangle; little-endian. */
export function decodeMesh(bytes: ArrayBuffer): Mesh {
    const broken = () => new ProtocolError("The station sent a part mesh that does not hold what it announces.");
    const view = new DataView(bytes);
    if (bytes.byteLength < 8) throw broken();
    const vertexCount = view.getUint32(0, true);
    const afterVertices = 4 + 12 * vertexCount;
    if (afterVertices + 4 > bytes.byteLength) throw broken();
    const triangleCount = view.getUint32(afterVertices, true);
    if (afterVertices + 4 + 12 * triangleCount !== bytes.byteLength) throw broken();
    const positions = new Float32Array(bytes.slice(4, afterVertices));
    const indices = new Uint32Array(bytes.slice(afterVertices + 4));
    for (const index of indices) if (index >= vertexCount) throw broken();
    return { positions, indices };
}

/** "DXV1", u32 count, f32 size, f32 x, y, z of the origin, i64 timestamp, u16 i, j, k a voxel; little-endian. */
export function decodeVoxels(bytes: ArrayBuffer): Voxels {
    const broken = () => new ProtocolError("The station sent voxels that do not hold what they announce.");
    const view = new DataView(bytes);
    if (bytes.byteLength < 32 || view.getUint32(0, false) !== 0x44585631) throw broken();
    const count = view.getUint32(4, true);
    if (bytes.byteLength !== 32 + 6 * count) throw broken();
    const size = view.getFloat32(8, true);
    const centres = new Float32Array(3 * count);
    for (let axis = 0; axis < 3; ++axis) {
        const origin = view.getFloat32(12 + 4 * axis, true);
        for (let i = 0; i < count; ++i)
            centres[3 * i + axis] = origin + size * view.getUint16(32 + 6 * i + 2 * axis, true);
    }
    return { timestampUs: Number(view.getBigInt64(24, true)), size, centres };
}
