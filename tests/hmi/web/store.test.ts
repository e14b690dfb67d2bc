// The one store: who hears of what, which mark is new, when a frame is fresh.
import assert from "node:assert/strict";
import test from "node:test";

import { parseMarks } from "../../../hmi/web/src/protocol";
import { Store } from "../../../hmi/web/src/store";
import { frameObject, liveMessage, markObject } from "./made_up";

test("a watcher hears at once, then only of its own keys, until it stops", () => {
    const store = new Store();
    const heard: string[] = [];
    const stop = store.watch(["view", "sound"], (state, changed) => heard.push(`${[...changed].join()}:${state.view}`));
    store.update({ now: 5 });
    store.update({ view: "cell", now: 6 });
    store.update({ view: "cell" });
    stop();
    store.update({ view: "part" });
    assert.deepEqual(heard, ["view,sound:part", "view,now:cell"]);
});

test("a watcher may stop itself while it hears", () => {
    const store = new Store();
    let calls = 0;
    const stop = store.watch(["now"], () => {
        if (++calls === 2) stop();
    });
    for (let now = 1; now < 5; ++now) store.update({ now });
    assert.equal(calls, 2);
});

test("only another frame is a fresh frame", () => {
    const store = new Store();
    store.takeLive(liveMessage({ frame: frameObject(1) }), 100);
    assert.equal(store.state.frameAt, 100);
    store.takeLive(liveMessage({ frame: frameObject(1) }), 200);
    assert.equal(store.state.frameAt, 100);
    store.takeLive(liveMessage({ frame: frameObject(2) }), 300);
    assert.equal(store.state.frameAt, 300);
});

test("a message without a frame tells of the rest and leaves the frame to grow stale", () => {
    const store = new Store();
    store.takeLive(liveMessage({ frame: frameObject(1) }), 100);
    store.takeLive(liveMessage({ frame: null, plc: { state: "waiting", reason: "gone" } }), 200);
    assert.equal(store.state.live?.frame?.timestampUs, 1);
    assert.equal(store.state.live?.plc.state, "waiting");
    assert.equal(store.state.frameAt, 100);
});

test("marks that were there before us did not just arrive; later ones did, once", () => {
    const store = new Store();
    store.takeMarks(parseMarks([markObject(1), markObject(2)]), 10, true);
    assert.equal(store.state.arrivals.size, 0);
    store.takeMarks(parseMarks([markObject(1), markObject(2), markObject(3)]), 20, false);
    assert.deepEqual([...store.state.arrivals], [[3, 20]]);
    store.takeMarks(parseMarks([markObject(1), markObject(2), markObject(3)]), 30, false);
    assert.deepEqual([...store.state.arrivals], [[3, 20]]);
});

test("another part's marks replace the old ones, and a choice that is gone is dropped", () => {
    const store = new Store();
    store.takeMarks(parseMarks([markObject(1), markObject(2)]), 10, true);
    store.update({ selectedMark: 2 });
    store.takeMarks(parseMarks([markObject(2)]), 20, false);
    assert.equal(store.state.selectedMark, 2);
    store.takeMarks(parseMarks([]), 30, false);
    assert.equal(store.state.selectedMark, null);
    assert.equal(store.state.arrivals.size, 0);
});
