// The page in every situation a shift can bring, behind the real server with a scripted station.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launch, openPage, pictureArea, redPixels, until } from "./chromium.mjs";
import { bumper, live, mark, pointing, rig, startRelay, worker } from "./scripted_station.mjs";

const relayProgram = process.env.SCREEN_RELAY;
const webRoot = process.env.DEIXIS_WEB;
const hand = [0.35, -0.62, 1.22];
let browser;

before(async () => {
    browser = await launch();
});
after(async () => {
    await browser?.close();
});

/** A station that says `state.changes` ten times a second, a page that watches it, and the end of both. */
async function watching(t, { size = [1920, 1080], marks = [], changes = {} } = {}) {
    const relay = await startRelay(relayProgram, webRoot);
    const state = { changes, marks, running: true, timestampUs: 0 };
    const say = () => {
        if (!state.running) return;
        state.timestampUs += 100_000;
        const { frame = {}, ...rest } = state.changes;
        const message = live(state.timestampUs, { marks_total: state.marks.length, ...rest });
        message.frame = frame === null ? null : { ...message.frame, ...frame };
        relay.say({
            live: message,
            ...(frame === null ? {} : { voxels: worker(0.05, -1.05, hand), voxel_size: 0.03, timestamp_us: state.timestampUs }),
        });
    };
    relay.say({ part: bumper(), rig: rig(), marks });
    const timer = setInterval(say, 100);
    const { page, complaints } = await openPage(browser, relay.address, ...size);
    const setMarks = (next) => {
        state.marks = next;
        relay.say({ marks: next });
    };
    t.after(async () => {
        clearInterval(timer);
        await page.close();
        await relay.stop();
    });
    await page.locator("#health .tile").first().waitFor();
    return { relay, page, complaints, state, setMarks };
}

const title = (page) => page.locator("#headline h1").innerText();
const severity = (page) => page.locator("#headline").getAttribute("data-severity");

async function expectTitle(page, wanted, wantedSeverity) {
    assert.equal(await until(() => title(page), (text) => text === wanted), wanted);
    assert.equal(await severity(page), wantedSeverity);
}

test("a mark appears as a red dot on the part, in the list and in the count", async (t) => {
    const { page, complaints, setMarks } = await watching(t);
    await expectTitle(page, "Ready", "normal");
    await page.waitForFunction(() => document.querySelector("#stage canvas") !== null);
    assert.equal((await redPixels(page, await pictureArea(page))).count, 0);

    setMarks([mark(1, [0.47, 0, 0.1])]);
    await page.locator('[data-mark="1"]').waitFor();
    assert.equal(await page.getByTestId("count").innerText(), "1");
    assert.match(await page.locator('[data-mark="1"]').innerText(), /upper right[\s\S]*open[\s\S]*x 470 {2}y 0 {2}z 100 mm/);
    assert.match((await page.locator('[data-mark="1"]').getAttribute("class")) ?? "", /\bnew\b/);

    const area = await pictureArea(page);
    const dot = await until(() => redPixels(page, area), ({ count }) => count > 300);
    assert.ok(dot.count > 300, `${dot.count} red pixels`);
    assert.ok(dot.x > area.width * 0.6, "a spot on the right of the part is drawn on its right");
    assert.deepEqual(complaints, []);
});

test("marks that were there before are no news; withdrawn ones are grey and do not count", async (t) => {
    const marks = [mark(1, [-0.5, 0, 0.1]), mark(2, [0.3, -0.02, 0.1], { state: "withdrawn" })];
    const { page } = await watching(t, { marks });
    await page.locator('[data-mark="2"]').waitFor();
    assert.equal(await page.getByTestId("count").innerText(), "1");
    assert.equal(await page.locator(".mark.new").count(), 0);
    const area = await pictureArea(page);
    const dots = await until(() => redPixels(page, area), ({ count }) => count > 300);
    assert.ok(dots.x < area.width / 2, "only the mark on the left is red");
});

test("choosing a row marks its dot, tapping the dot chooses the row", async (t) => {
    const { page } = await watching(t, { marks: [mark(1, [0.3, -0.02, 0.1])] });
    const row = page.locator('[data-mark="1"]');
    const area = await pictureArea(page);
    const dot = await until(() => redPixels(page, area), ({ count }) => count > 300);
    await page.mouse.click(area.x + dot.x, area.y + dot.y);
    assert.equal(await until(() => row.getAttribute("aria-pressed"), (value) => value === "true"), "true");
    assert.ok((await until(() => redPixels(page, area), ({ count }) => count > dot.count)).count > dot.count);
    await row.click();
    assert.equal(await row.getAttribute("aria-pressed"), "false");
});

test("the part's state is said in words", async (t) => {
    const { page, state } = await watching(t);
    const unlocked = (word, reason = "") => ({ frame: { part: { state: word, rotation: null, translation: null, at_rest: false, reason } } });
    state.changes = unlocked("ambiguous", "only the middle of the part is seen");
    await expectTitle(page, "Part not locked: ambiguous", "attention");
    assert.equal(await page.locator("#headline .detail").innerText(), "Only the middle of the part is seen.");
    state.changes = unlocked("lost");
    await expectTitle(page, "Part not locked: lost", "attention");
    state.changes = unlocked("absent");
    await expectTitle(page, "No part", "attention");
    state.changes = { frame: { pointing: pointing(hand, [0.3, -0.02, 0.1]) } };
    await expectTitle(page, "Pointing", "normal");
});

test("no frame: it says for how long, greys the picture, and takes back worker and ray", async (t) => {
    const { page, state } = await watching(t, { marks: [mark(1, [0.3, -0.02, 0.1])] });
    await expectTitle(page, "Ready", "normal");
    state.changes = { frame: null };
    await expectTitle(page, "No frame for 2 s", "fault");
    assert.match((await page.locator("#stage").getAttribute("class")) ?? "", /stale/);
    assert.match(await page.locator("#stage .veil").innerText(), /^No frame for \d s$/);
    assert.equal((await redPixels(page, await pictureArea(page))).count, 0);
    state.changes = {};
    await expectTitle(page, "Ready", "normal");
    assert.equal(await page.locator("#stage.stale").count(), 0);
});

test("what fails is an alarm with its reason and what to do", async (t) => {
    const { page, state } = await watching(t);
    assert.equal(await page.locator(".alarm").count(), 0);
    const sensor = (name, word, reason) => ({ name, state: word, reason, frames: 9, dropped: 0, restarts: 1, age_ms: null });
    state.changes = {
        sensors: [sensor("left", "running", ""), sensor("right", "missing", "no device")],
        plc: { state: "waiting", reason: "nobody is connected" },
    };
    await page.locator(".alarm").nth(1).waitFor();
    assert.deepEqual(await page.locator(".alarm").allInnerTexts().then((all) => all.map((text) => text.replace(/\s+/g, " "))), [
        "Sensor right missing: no device. Check its cable and power.",
        "PLC waiting: nobody is connected. Marks are kept and sent later.",
    ]);
    assert.equal(await page.locator('[data-tile="Sensor right"]').getAttribute("class"), "tile fault");
    state.changes = {};
    await until(() => page.locator(".alarm").count(), (count) => count === 0);
    assert.equal(await page.locator(".alarm").count(), 0);
});

test("a station that goes away is noticed, and one that comes back is found", async (t) => {
    const { relay, page, state } = await watching(t);
    await expectTitle(page, "Ready", "normal");
    const port = new URL(relay.address).port;
    state.running = false;
    await relay.stop();
    await expectTitle(page, "No connection to the station", "fault");
    assert.match(await page.locator("#health .tile").first().innerText(), /was running/);

    const again = await startRelay(relayProgram, webRoot, port);
    let timestampUs = 0;
    const timer = setInterval(() => again.say({ live: live((timestampUs += 100_000)) }), 100);
    try {
        await expectTitle(page, "Ready", "normal");
    } finally {
        clearInterval(timer);
        await again.stop();
    }
});

test("sound needs a touch, then says so", async (t) => {
    const { page } = await watching(t);
    const sound = page.locator(".sound");
    assert.equal(await sound.innerText(), "Sound off");
    await sound.click();
    assert.equal(await until(() => sound.innerText(), (text) => text === "Sound on"), "Sound on");
    await sound.click();
    assert.equal(await until(() => sound.innerText(), (text) => text === "Sound off"), "Sound off");
});

test("both views can be large, and orbiting is undone by reset", async (t) => {
    const { page, complaints } = await watching(t, { marks: [mark(1, [0.3, -0.02, 0.1])], changes: { frame: { pointing: pointing(hand, [0.3, -0.02, 0.1]) } } });
    const area = await pictureArea(page);
    const before = await until(() => redPixels(page, area), ({ count }) => count > 300);
    await page.mouse.move(area.x + 300, area.y + 200);
    await page.mouse.down();
    await page.mouse.move(area.x + 360, area.y + 210, { steps: 4 });
    await page.mouse.up();
    const turned = await until(() => redPixels(page, area), ({ x }) => Math.abs(x - before.x) > 20);
    assert.ok(Math.abs(turned.x - before.x) > 20, "the picture turned");
    await page.getByText("Reset view").click();
    const back = await until(() => redPixels(page, area), ({ x }) => Math.abs(x - before.x) < 3);
    assert.ok(Math.abs(back.x - before.x) < 3, "and turned back");
    await page.locator('[data-view="cell"]').click();
    assert.equal(await page.locator(".inset-name").innerText(), "Part");
    await page.locator(".inset").click();
    assert.equal(await page.locator(".inset-name").innerText(), "Cell");
    assert.deepEqual(complaints, []);
});

for (const size of [[1920, 1080], [1280, 800]])
    test(`at ${size.join(" x ")} everything fits, and every control is large enough for a glove`, async (t) => {
        const { page } = await watching(t, { size, marks: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12].map((id) => mark(id, [0.05 * id, 0, 0.1])) });
        await page.locator('[data-mark="12"]').waitFor();
        const overflow = await page.evaluate(() => [document.documentElement.scrollWidth - innerWidth, document.documentElement.scrollHeight - innerHeight]);
        assert.deepEqual(overflow, [0, 0]);
        const tiny = await page.locator("button").evaluateAll((all) =>
            all.map((made) => made.getBoundingClientRect()).filter((box) => box.width < 44 || box.height < 44).length);
        assert.equal(tiny, 0);
        const list = await page.locator("#marks .list").evaluate((made) => made.scrollHeight > made.clientHeight);
        assert.equal(list, true, "a long list scrolls inside its panel");
        for (const selector of ["#headline", "#stage", "#marks", "#health"]) {
            const box = await page.locator(selector).boundingBox();
            assert.ok(box.x >= 0 && box.y >= 0 && box.x + box.width <= size[0] + 1 && box.y + box.height <= size[1] + 1, selector);
        }
    });
