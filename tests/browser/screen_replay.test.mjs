// The real thing: `deixis station` plays a simulated session, and a browser sees the defects appear on the part.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { test } from "node:test";

import { launch, openPage, pictureArea, redPixels, until } from "./chromium.mjs";

const program = process.env.DEIXIS;
const session = process.env.DEIXIS_SESSION;
const webRoot = process.env.DEIXIS_WEB;
const picture = process.env.SCREEN_PICTURE; // where to keep the last look at someone pointing, when wanted

/** Starts the station on the session, on any free port, with a fresh record; resolves with the screen's address. */
async function startStation(folder) {
    const settings = join(folder, "settings.toml");
    await writeFile(settings, `[screen]\nweb_root = ${JSON.stringify(webRoot)}\n`);
    const child = spawn(
        program,
        ["station", session, "--settings", settings, "--screen-port", "0", "--database", join(folder, "record.db")],
        { stdio: ["ignore", "pipe", "inherit"] },
    );
    const ended = new Promise((resolve) => child.once("exit", resolve));
    const address = await new Promise((resolve, reject) => {
        createInterface({ input: child.stdout }).on("line", (line) => {
            if (line.startsWith("SCREEN ")) resolve(line.slice(7).trim());
        });
        child.once("exit", (code) => reject(new Error(`the station ended with ${code} before its screen was up`)));
    });
    return {
        address,
        stop: async () => {
            child.kill("SIGTERM");
            return ended;
        },
    };
}

test("during a replay a red dot appears on the part", { timeout: 600_000 }, async (t) => {
    const folder = await mkdtemp(join(tmpdir(), "screen."));
    const station = await startStation(folder);
    const browser = await launch();
    t.after(async () => {
        await browser.close();
        await station.stop();
        await rm(folder, { recursive: true });
    });
    const { page, complaints } = await openPage(browser, station.address);

    await page.locator('[data-tile="Source"]', { hasText: "replay" }).waitFor();
    const area = await pictureArea(page);
    assert.equal(await page.getByTestId("count").innerText(), "0");
    assert.equal((await redPixels(page, area)).count, 0, "no dot before the first mark");

    await page.locator("#headline h1", { hasText: /^Pointing/ }).waitFor({ timeout: 300_000 });
    await page.locator("[data-mark]").first().waitFor({ timeout: 300_000 });
    const marks = await (await fetch(`${station.address}/api/marks`)).json();
    assert.ok(marks.length >= 1);
    const dot = await until(() => redPixels(page, area), ({ count }) => count > 300);
    assert.ok(dot.count > 300, `${dot.count} red pixels on the part`);

    const title = () => page.locator("#headline h1").innerText();
    const ended = async () => {
        const now = await title();
        if (picture !== undefined && now === "Pointing") await page.screenshot({ path: picture });
        return now;
    };
    assert.equal(await until(ended, (now) => now === "End of the recording", 300), "End of the recording");
    const all = await (await fetch(`${station.address}/api/marks`)).json();
    const shown = await until(() => page.locator("[data-mark]").count(), (count) => count === all.length);
    assert.equal(shown, all.length, "every mark of the record is in the list");
    assert.equal(await page.getByTestId("count").innerText(), String(all.length));
    assert.deepEqual(complaints, []);
});
