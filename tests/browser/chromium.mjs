// Debian's Chromium without a window, its drawing done in software; what it complains of; and counting red pixels.
import { chromium } from "playwright-core";

/** A browser that reaches nothing but the page it is told to open. */
export function launch() {
    return chromium.launch({
        executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
        headless: true,
        args: [
            "--no-sandbox",
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--autoplay-policy=user-gesture-required",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--no-first-run",
        ],
    });
}

/** A page of this size, and the list that its complaints go to: console errors, exceptions, requests elsewhere. */
export async function openPage(browser, address, width = 1920, height = 1080) {
    const page = await browser.newPage({ viewport: { width, height } });
    const complaints = [];
    page.on("console", (message) => {
        if (["error", "warning"].includes(message.type())) complaints.push(message.text());
    });
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("request", (request) => {
        if (!request.url().startsWith(address)) complaints.push(`request to ${request.url()}`);
    });
    await page.goto(address);
    return { page, complaints };
}

/** One empty page a browser, free of our page's content policy, to take pictures apart in. */
const darkrooms = new WeakMap();

/** The defect-red pixels of a part of the page: how many, and where their middle is. */
export async function redPixels(page, clip) {
    const png = await page.screenshot({ clip });
    const browser = page.context().browser();
    if (!darkrooms.has(browser)) darkrooms.set(browser, browser.newPage());
    const darkroom = await darkrooms.get(browser);
    return darkroom.evaluate(async (base64) => {
        const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
        const image = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
        const canvas = new OffscreenCanvas(image.width, image.height);
        const context = canvas.getContext("2d");
        context.drawImage(image, 0, 0);
        const { data } = context.getImageData(0, 0, image.width, image.height);
        let count = 0;
        let x = 0;
        let y = 0;
        for (let i = 0; i < data.length; i += 4) {
            if (data[i] < 180 || data[i + 1] > 60 || data[i + 2] > 80) continue;
            ++count;
            x += (i / 4) % image.width;
            y += Math.floor(i / 4 / image.width);
        }
        return { count, x: x / count, y: y / count };
    }, png.toString("base64"));
}

/** The large picture without its inset and buttons: the upper part of the stage. */
export async function pictureArea(page) {
    const stage = await page.locator("#stage").boundingBox();
    const inset = await page.locator("#stage .inset").boundingBox();
    return { x: stage.x, y: stage.y, width: stage.width, height: inset.y - stage.y };
}

/** Asks again until the answer satisfies, at most `seconds`; then returns the last answer. */
export async function until(ask, satisfies, seconds = 20) {
    const end = Date.now() + seconds * 1000;
    for (;;) {
        const answer = await ask();
        if (satisfies(answer) || Date.now() > end) return answer;
        await new Promise((resolve) => setTimeout(resolve, 100));
    }
}
