// The side a part is looked at from: where its skin bulges, whichever way its file is turned.
import assert from "node:assert/strict";
import test from "node:test";

import type { Mesh } from "../../../hmi/web/src/protocol";
import { extentOf, frontDirection } from "../../../hmi/web/src/scene/front_side";

/** A shell bulging to -y, turned by quarter turns about Z. */
function shell(quarterTurns: number): Mesh {
    const positions: number[] = [];
    const indices: number[] = [];
    const columns = 20;
    for (let i = 0; i <= columns; ++i)
        for (const z of [0, 0.5]) {
            const s = (2 * i) / columns - 1;
            let [x, y] = [0.85 * s, 0.4 * s ** 4];
            for (let turn = 0; turn < quarterTurns; ++turn) [x, y] = [-y, x];
            positions.push(x, y, z);
        }
    for (let i = 0; i < columns; ++i) indices.push(2 * i, 2 * i + 2, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 1);
    return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}

test("a shell is seen from its bulging side", () => {
    assert.deepEqual(frontDirection(shell(0)), [0, -1, 0]);
    assert.deepEqual(frontDirection(shell(1)), [1, 0, 0]);
    assert.deepEqual(frontDirection(shell(2)), [0, 1, 0]);
    assert.deepEqual(frontDirection(shell(3)), [-1, 0, 0]);
});

test("a flat, an empty and a one-point part have a front too", () => {
    const flat = { positions: new Float32Array([0, 0, 0, 2, 0, 0, 0, 0, 1]), indices: new Uint32Array([0, 1, 2]) };
    const empty = { positions: new Float32Array(), indices: new Uint32Array() };
    const point = { positions: new Float32Array([1, 1, 1]), indices: new Uint32Array() };
    for (const mesh of [flat, empty, point]) assert.equal(Math.hypot(...frontDirection(mesh)), 1);
    assert.deepEqual(extentOf(empty), { min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5] });
    assert.deepEqual(extentOf(flat), { min: [0, 0, 0], max: [2, 0, 1] });
});
