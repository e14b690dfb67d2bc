// Feature lines stay, crumbs go, whatever the order and direction of their segments.
import assert from "node:assert/strict";
import test from "node:test";

import { longLines } from "../../../hmi/web/src/scene/long_lines";

test("a line of short pieces is one line", () => {
    const pieces = [
        [0, 0, 0, 0.04, 0, 0],
        [0.12, 0, 0, 0.08, 0, 0],
        [0.04, 0, 0, 0.08, 0, 0],
    ];
    const crumb = [1, 1, 1, 1.05, 1, 1];
    const kept = longLines(new Float32Array([...pieces.flat(), ...crumb]), 0.1);
    assert.deepEqual([...kept], [...new Float32Array(pieces.flat())]);
});

test("nothing in, nothing out; a closed ring counts all around", () => {
    assert.equal(longLines(new Float32Array(), 0.1).length, 0);
    const ring: number[] = [];
    const point = (i: number) => [0.02 * Math.cos((i * Math.PI) / 8), 0.02 * Math.sin((i * Math.PI) / 8), 0];
    for (let i = 0; i < 16; ++i) ring.push(...point(i), ...point(i + 1));
    assert.equal(longLines(new Float32Array(ring), 0.12).length, ring.length);
    assert.equal(longLines(new Float32Array(ring), 0.13).length, 0);
});
