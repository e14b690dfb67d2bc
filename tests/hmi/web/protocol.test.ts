// The edge of the page: what the station says comes through whole, what it should not say is named.
import assert from "node:assert/strict";
import test from "node:test";

import {
    decodeMesh,
    decodeVoxels,
    parseCell,
    parseLive,
    parseMarks,
    parsePart,
    parseState,
    ProtocolError,
} from "../../../hmi/web/src/protocol";
import { frameObject, identity, liveObject, markObject } from "./made_up";

function refused(use: () => unknown, sentence: RegExp): void {
    assert.throws(use, (error: unknown) => error instanceof ProtocolError && sentence.test(error.message));
}

function meshBytes(vertices: readonly number[], corners: readonly number[]): ArrayBuffer {
    const view = new DataView(new ArrayBuffer(8 + 4 * vertices.length + 4 * corners.length));
    view.setUint32(0, vertices.length / 3, true);
    vertices.forEach((value, i) => view.setFloat32(4 + 4 * i, value, true));
    view.setUint32(4 + 4 * vertices.length, corners.length / 3, true);
    corners.forEach((value, i) => view.setUint32(8 + 4 * vertices.length + 4 * i, value, true));
    return view.buffer;
}

function voxelBytes(cells: readonly number[], size: number, origin: readonly number[], timestamp: bigint): ArrayBuffer {
    const view = new DataView(new ArrayBuffer(32 + 2 * cells.length));
    [..."DXV1"].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
    view.setUint32(4, cells.length / 3, true);
    view.setFloat32(8, size, true);
    origin.forEach((value, i) => view.setFloat32(12 + 4 * i, value, true));
    view.setBigInt64(24, timestamp, true);
    cells.forEach((value, i) => view.setUint16(32 + 2 * i, value, true));
    return view.buffer;
}

test("a live message comes through whole", () => {
    const pointing = { arm: "left", origin: [0, 0, 1.4], direction: [0, 1, 0], hit_part: [0.3, 0.03, 0.12] };
    const live = parseLive(liveObject({ frame: frameObject(5, { pointing }) }));
    assert.equal(live.frame?.timestampUs, 5);
    assert.deepEqual(live.frame?.part?.worldFromPart, identity);
    assert.deepEqual(live.frame?.pointing?.hitPart, [0.3, 0.03, 0.12]);
    assert.equal(live.sensors[0]?.name, "left");
    assert.equal(live.staleAfterMs, 1000);
});

test("unknown things are null, not refused", () => {
    const live = parseLive(liveObject({ frame: null, progress: null }));
    assert.equal(live.frame, null);
    assert.equal(live.progress, null);
    const lost = frameObject(1, { part: { state: "lost", reason: "covered", rotation: null, translation: null } });
    assert.equal(parseLive(liveObject({ frame: lost })).frame?.part?.worldFromPart, null);
});

test("broken live messages are named", () => {
    const cases: readonly (readonly [unknown, RegExp])[] = [
        [null, /live message that is not an object/],
        [[], /live message that is not an object/],
        ["x", /live message that is not an object/],
        [liveObject({ frame: 3 }), /frame that is not an object/],
        [liveObject({ frame: frameObject(NaN) }), /timestamp_us that is not a number/],
        [liveObject({ frame: frameObject(1, { part: { state: "flying" } }) }), /unknown part state "flying"/],
        [liveObject({ frame: frameObject(1, { part: { state: "tracking" } }) }), /rotation that is not a list/],
        [liveObject({ frame: frameObject(1, { part: { ...identity, state: "tracking", rotation: [[1, 0, 0]] } }) }), /rotation without three rows/],
        [liveObject({ frame: frameObject(1, { part: { ...identity, state: "tracking", translation: [0, 0] } }) }), /translation without three numbers/],
        [liveObject({ frame: frameObject(1, { pointing: { origin: [0, 0, 0] } }) }), /direction that is not a list/],
        [liveObject({ frame: frameObject(1, { pointing: { origin: [0, 0, "0"], direction: [0, 0, 1] } }) }), /origin that is not a number/],
        [liveObject({ sensors: {} }), /sensors that is not a list/],
        [liveObject({ sensors: [4] }), /sensor that is not an object/],
        [liveObject({ plc: null }), /plc that is not an object/],
        [liveObject({ record: "open" }), /record that is not an object/],
        [liveObject({ stale_after_ms: null }), /stale_after_ms that is not a number/],
        [liveObject({ marks_total: "3" }), /marks_total that is not a number/],
    ];
    for (const [message, sentence] of cases) refused(() => parseLive(message), sentence);
});

test("the state before the first live message is null", () => {
    assert.equal(parseState({ age_ms: null, live: null }), null);
    assert.equal(parseState({ age_ms: 40, live: liveObject() })?.ageMs, 40);
    refused(() => parseState({ age_ms: null, live: liveObject() }), /age_ms that is not a number/);
});

test("marks", () => {
    const marks = parseMarks([markObject(7), markObject(8, { state: "withdrawn", touch: true })]);
    assert.deepEqual(marks.map((mark) => [mark.id, mark.state, mark.touch]), [[7, "open", false], [8, "withdrawn", true]]);
    refused(() => parseMarks({}), /marks that is not a list/);
    refused(() => parseMarks([markObject(1, { state: "maybe" })]), /unknown mark state "maybe"/);
    refused(() => parseMarks([markObject(1, { position_part: [1, 2] })]), /position_part without three numbers/);
    refused(() => parseMarks([markObject(1, { id: "1" })]), /id that is not a number/);
});

test("part and cell", () => {
    const part = parsePart({ type: "a", serial: "1", mesh_etag: '"x"', zones: [{ name: "z", min: [0, 0, 0], max: [1, 1, 1] }] });
    assert.deepEqual(part.zones[0]?.max, [1, 1, 1]);
    refused(() => parsePart({ type: "a", zones: 5 }), /zones that is not a list/);
    const sensor = { name: "left", width: 640, height: 480, fx: 1, fy: 1, cx: 1, cy: 1, ...identity };
    assert.equal(parseCell({ sensors: [sensor], cell: null }).box, null);
    assert.deepEqual(parseCell({ sensors: [], cell: { min: [0, 0, 0], max: [1, 2, 3] } }).box?.max, [1, 2, 3]);
    refused(() => parseCell({ sensors: [{ ...sensor, fx: null }], cell: null }), /sensor's fx that is not a number/);
});

test("a mesh comes through whole", () => {
    const mesh = decodeMesh(meshBytes([0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2]));
    assert.deepEqual([...mesh.positions], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
    assert.deepEqual([...mesh.indices], [0, 1, 2]);
    assert.equal(decodeMesh(meshBytes([], [])).positions.length, 0);
});

test("every cut of a mesh is refused, and so is a corner beyond its vertices", () => {
    const whole = meshBytes([0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 1, 2]);
    for (let size = 0; size < whole.byteLength; ++size)
        refused(() => decodeMesh(whole.slice(0, size)), /mesh that does not hold what it announces/);
    refused(() => decodeMesh(meshBytes([0, 0, 0], [0, 0, 1])), /mesh that does not hold/);
});

test("voxels stand where they were", () => {
    const voxels = decodeVoxels(voxelBytes([0, 0, 0, 2, 3, 65535], 0.5, [-1, 0, 2], 123456789012n));
    assert.equal(voxels.timestampUs, 123456789012);
    assert.equal(voxels.size, 0.5);
    assert.deepEqual([...voxels.centres], [-1, 0, 2, 0, 1.5, 2 + 0.5 * 65535]);
});

test("every cut of a voxel message is refused, and so is another kind of message", () => {
    const whole = voxelBytes([1, 2, 3, 4, 5, 6], 0.03, [0, 0, 0], 1n);
    for (let size = 0; size < whole.byteLength; ++size)
        refused(() => decodeVoxels(whole.slice(0, size)), /voxels that do not hold what they announce/);
    new DataView(whole).setUint8(3, "2".charCodeAt(0));
    refused(() => decodeVoxels(whole), /voxels that do not hold/);
});
