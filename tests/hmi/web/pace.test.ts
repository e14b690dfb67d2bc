// Drawing stays below its share of the time, and never stops altogether.
import assert from "node:assert/strict";
import test from "node:test";

import { Pace } from "../../../hmi/web/src/scene/pace";

test("a costly picture is followed by a pause, a cheap one by hardly any", () => {
    const pace = new Pace(0.25, 500);
    assert.equal(pace.wait(0), 0);
    pace.drawn(0, 40);
    assert.equal(pace.wait(40), 120);
    assert.equal(pace.wait(100), 60);
    assert.equal(pace.wait(1000), 0);
    pace.drawn(1000, 1001);
    assert.equal(pace.wait(1001), 3);
});

test("however slow the machine, the picture comes", () => {
    const pace = new Pace(0.25, 500);
    pace.drawn(0, 10_000);
    assert.equal(pace.wait(10_000), 500);
});

test("over a long time the share is kept", () => {
    const pace = new Pace(0.3, 1000);
    let now = 0;
    let drawing = 0;
    for (let i = 0; i < 200; ++i) {
        now += pace.wait(now);
        const cost = 10 + (i % 7) * 9;
        pace.drawn(now, now + cost);
        now += cost;
        drawing += cost;
    }
    assert.ok(drawing / now < 0.31);
});
