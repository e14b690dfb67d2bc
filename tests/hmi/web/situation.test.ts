// What the screen says in which situation: the words a worker reads, and never a calm word over a blind station.
import assert from "node:assert/strict";
import test from "node:test";

import { parseMarks } from "../../../hmi/web/src/protocol";
import { alarms, headline, isStale, linkIsLost, seconds, sessionEnded, standingMarks } from "../../../hmi/web/src/situation";
import { emptyState, Store, type ScreenState } from "../../../hmi/web/src/store";
import { frameObject, identity, liveMessage, markObject } from "./made_up";

function seen(changes: Readonly<Record<string, unknown>> = {}, age = 0): ScreenState {
    const store = new Store({ ...emptyState, link: "open" });
    store.takeLive(liveMessage(changes), 1000);
    store.update({ now: 1000 + age });
    return store.state;
}

function withPart(part: unknown, pointing: unknown = null): ScreenState {
    return seen({ frame: frameObject(1, { part, pointing }) });
}

const hit = { arm: "left", origin: [0, -1, 1.4], direction: [0, 1, 0], hit_part: [0, 0, 0] };

test("the headline of each situation", () => {
    const tracking = { state: "tracking", ...identity, at_rest: true };
    const cases: readonly (readonly [ScreenState, string, string])[] = [
        [emptyState, "normal", "Starting"],
        [{ ...seen(), link: "lost" }, "fault", "No connection to the station"],
        [seen({ frame: null }), "attention", "No picture yet"],
        [seen({}, 3100), "fault", "No frame for 3 s"],
        [withPart(null), "attention", "No part"],
        [withPart({ state: "absent" }), "attention", "No part"],
        [withPart({ state: "searching" }), "attention", "Part not locked: searching"],
        [withPart({ state: "ambiguous" }), "attention", "Part not locked: ambiguous"],
        [withPart({ state: "lost" }), "attention", "Part not locked: lost"],
        [withPart({ ...tracking, at_rest: false }), "attention", "Part is moving"],
        [withPart(tracking), "normal", "Ready"],
        [withPart(tracking, hit), "normal", "Pointing"],
        [withPart(tracking, { ...hit, hit_part: null }), "normal", "Pointing past the part"],
        [seen({ finished: true }, 5000), "normal", "End of the recording"],
    ];
    for (const [state, severity, title] of cases) {
        const line = headline(state);
        assert.deepEqual([line.severity, line.title], [severity, title]);
        assert.match(line.detail, /^[A-Z].*\.$/);
    }
});

test("the station's own reason is what the worker reads", () => {
    const state = withPart({ state: "ambiguous", reason: "only the middle is seen" });
    assert.equal(headline(state).detail, "Only the middle is seen.");
});

test("nothing calm is said over stale or missing frames", () => {
    for (const age of [1001, 5000, 100_000]) {
        assert.equal(isStale(seen({}, age)), true);
        assert.equal(headline(seen({}, age)).severity, "fault");
    }
    assert.equal(isStale(seen({}, 999)), false);
    assert.equal(isStale(emptyState), true);
    assert.equal(isStale({ ...seen(), link: "lost" }), true);
});

test("the end of a recording is not an alarm, its middle is", () => {
    assert.equal(sessionEnded(seen({ finished: true })), true);
    assert.equal(sessionEnded(seen({ progress: 1 })), false);
    assert.equal(sessionEnded(emptyState), false);
});

test("alarms name what is wrong, why, and what to do, most urgent first", () => {
    const sensor = (name: string, state: string, reason = "") => ({ name, state, reason, frames: 0, dropped: 0, restarts: 0 });
    const state = seen({
        sensors: [sensor("left", "restarting", "its process ended"), sensor("right", "missing", "no device")],
        plc: { state: "waiting", reason: "nobody is connected" },
        record: { state: "failed", reason: "disk full" },
    });
    assert.deepEqual(
        alarms(state).map((alarm) => [alarm.severity, alarm.text]),
        [
            ["fault", "Record failed: disk full."],
            ["fault", "Sensor right missing: no device."],
            ["attention", "Sensor left restarting: its process ended."],
            ["attention", "PLC waiting: nobody is connected."],
        ],
    );
    for (const alarm of alarms(state)) assert.match(alarm.response, /\.$/);
});

test("all well is silent, and so is a recording that has been read", () => {
    assert.deepEqual(alarms(seen()), []);
    const finished = { name: "left", state: "finished", reason: "", frames: 900, dropped: 0, restarts: 0 };
    assert.deepEqual(alarms(seen({ sensors: [finished] })), []);
});

test("a word nobody told us is never calm", () => {
    const odd = { name: "left", state: "purring", reason: "", frames: 0, dropped: 0, restarts: 0 };
    assert.equal(alarms(seen({ sensors: [odd] }))[0]?.severity, "fault");
    assert.equal(alarms(seen({ record: { state: "purring", reason: "" } }))[0]?.severity, "fault");
    assert.equal(alarms(seen({ plc: { state: "purring", reason: "" } }))[0]?.severity, "attention");
});

test("a trouble is told for half a minute", () => {
    const trouble = "mark 3 could not be recorded: disk full";
    assert.deepEqual(
        alarms(seen({ trouble }, 29_000)).map((alarm) => alarm.text),
        ["Mark 3 could not be recorded: disk full."],
    );
    assert.deepEqual(alarms(seen({ trouble }, 31_000)), []);
});

test("a record that waits for its disk is less than one that is lost", () => {
    const severity = (state: string) => alarms(seen({ record: { state, reason: "disk full" } }))[0]?.severity;
    assert.deepEqual([severity("ready"), severity("writing"), severity("retrying"), severity("failed")], [undefined, undefined, "attention", "fault"]);
});

test("without a connection only that is said: the rest is unknown", () => {
    assert.deepEqual(alarms({ ...seen({ record: { state: "failed", reason: "" } }), link: "lost" }), []);
});

test("a short break of the connection alarms nobody", () => {
    assert.equal(linkIsLost(null, 1e9), false);
    assert.equal(linkIsLost(1000, 2000), false);
    assert.equal(linkIsLost(1000, 2500), true);
});

test("withdrawn marks do not count, times are short", () => {
    const marks = parseMarks([markObject(1), markObject(2, { state: "withdrawn" }), markObject(3, { state: "confirmed" })]);
    assert.equal(standingMarks({ ...emptyState, marks }), 2);
    assert.deepEqual([seconds(999), seconds(3100), seconds(61_000)], ["0 s", "3 s", "1 min"]);
});
