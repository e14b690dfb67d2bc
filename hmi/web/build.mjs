// Bundles the page into --out FOLDER, or with --tests the unit tests of tests/hmi/web, for node's own test runner.
import { build } from "esbuild";
import { cp, mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const option = (name, fallback) => {
    const at = process.argv.indexOf(name);
    return at < 0 ? fallback : process.argv[at + 1];
};
const tests = process.argv.includes("--tests");
const out = option("--out", join(here, "node_modules", ".cache", tests ? "tests" : "web"));

const common = { absWorkingDir: here, bundle: true, target: "es2022", logLevel: "warning" };
await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });

if (tests) {
    const folder = join(here, "..", "..", "tests", "hmi", "web");
    const names = (await readdir(folder)).filter((name) => name.endsWith(".test.ts"));
    await build({
        ...common,
        entryPoints: names.map((name) => join(folder, name)),
        outdir: out,
        platform: "node",
        format: "esm",
        outExtension: { ".js": ".mjs" },
    });
} else {
    await build({
        ...common,
        entryPoints: ["src/main.ts", "src/style.css"],
        outdir: out,
        format: "esm",
        minify: true,
        legalComments: "none",
        loader: { ".woff2": "file" },
        assetNames: "[name]-[hash]",
    });
    for (const name of ["index.html", "icon.svg"]) await cp(join(here, "src", name), join(out, name));
    // What we pass on with the bundle, with the words under which we may.
    const notices = [];
    for (const name of ["three", "@fontsource-variable/inter"])
        notices.push(`${name}\n\n${await readFile(join(here, "node_modules", name, "LICENSE"), "utf8")}`);
    await writeFile(join(out, "licences.txt"), notices.join("\n----\n\n"));
}
