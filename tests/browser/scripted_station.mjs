// A made-up cell to drive the screen through any state: a bumper-like shell, a standing worker, sensors, messages.
import { spawn } from "node:child_process";
import { createInterface } from "node:readline";

/** The real screen server behind a scripted station; `say` takes the commands of screen_relay.cpp. */
export async function startRelay(program, webRoot, port = 0) {
    const child = spawn(program, [webRoot, String(port)], { stdio: ["pipe", "pipe", "inherit"] });
    const lines = createInterface({ input: child.stdout });
    const address = await new Promise((resolve, reject) => {
        lines.once("line", resolve);
        child.once("exit", (code) => reject(new Error(`screen_relay ended with ${code}`)));
    });
    const ended = new Promise((resolve) => child.once("exit", resolve));
    return {
        address,
        say: (command) => child.stdin.write(`${JSON.stringify(command)}\n`),
        stop: async () => {
            child.stdin.end();
            await ended;
        },
    };
}

/** A thin shell 1.7 m wide, bulging to -y, Z up; part frame [m]. */
export function bumper() {
    const columns = 96;
    const rows = 28;
    const vertices = [];
    const triangles = [];
    for (let i = 0; i <= columns; ++i)
        for (let j = 0; j <= rows; ++j) {
            const s = (2 * i) / columns - 1;
            const t = j / rows;
            const bulge = 0.07 * Math.sin(Math.PI * Math.min(1, t * 1.15)) - (t > 0.42 && t < 0.5 ? 0.02 : 0);
            const grille = Math.abs(s) < 0.45 && t > 0.14 && t < 0.34 ? 0.05 : 0;
            const lamp = Math.hypot((Math.abs(s) - 0.72) * 1.7, (t - 0.24) * 0.9) < 0.09 ? 0.045 : 0;
            vertices.push(0.85 * Math.sin((s * Math.PI) / 2.25) / Math.sin(Math.PI / 2.25), 0.42 * Math.abs(s) ** 3 - bulge + grille + lamp, 0.52 * t - 0.26);
        }
    for (let i = 0; i < columns; ++i)
        for (let j = 0; j < rows; ++j) {
            const a = i * (rows + 1) + j;
            const b = a + rows + 1;
            triangles.push(a, b, b + 1, a, b + 1, a + 1);
        }
    const zone = (name, min, max) => ({ name, min, max });
    return {
        type: "bumper-front-a",
        serial: "0001",
        zones: [
            zone("upper left", [-0.9, -0.5, 0], [0, 0.6, 0.4]),
            zone("upper right", [0, -0.5, 0], [0.9, 0.6, 0.4]),
            zone("lower left", [-0.9, -0.5, -0.4], [0, 0.6, 0]),
            zone("lower right", [0, -0.5, -0.4], [0.9, 0.6, 0]),
        ],
        vertices: vertices.map((x) => Math.round(x * 1e5) / 1e5),
        triangles,
    };
}

/** Sensors "left" and "right" on the wall beyond the part, looking at the worker. */
export function rig() {
    const sensor = (name, x) => {
        const from = [x, 1.4, 2.1];
        const to = [0, -0.5, 0.9];
        const sub = from.map((c, i) => to[i] - c);
        const unit = (v) => v.map((c) => c / Math.hypot(...v));
        const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        const z = unit(sub);
        const right = unit(cross(z, [0, 0, 1]));
        const down = cross(z, right);
        const rotation = [right, down, z];
        const translation = rotation.map((row) => -(row[0] * from[0] + row[1] * from[1] + row[2] * from[2]));
        return { name, kind: "depth", width: 640, height: 480, fx: 575.8, fy: 575.8, cx: 319.5, cy: 239.5, rotation, translation };
    };
    return { sensors: [sensor("left", -1.5), sensor("right", 1.5)], cell: { min: [-2, -1.5, 0], max: [2, 1.5, 2.2] } };
}

export const partPose = { rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], translation: [0, 0.2, 0.95] };

/** Voxel centres [m] of a worker at (x, y) whose arm reaches to `hand`, on a grid of `size`. */
export function worker(x, y, hand, size = 0.03) {
    const bones = [
        [[x, y, 1.66], [x, y, 1.72], 0.1],
        [[x, y, 0.95], [x, y, 1.42], 0.155],
        [[x - 0.17, y, 1.42], [x + 0.17, y, 1.42], 0.075],
        [[x - 0.1, y, 0.92], [x - 0.11, y, 0.08], 0.075],
        [[x + 0.1, y, 0.92], [x + 0.11, y, 0.08], 0.075],
        [[x - 0.11, y, 0.05], [x - 0.11, y + 0.16, 0.04], 0.05],
        [[x + 0.11, y, 0.05], [x + 0.11, y + 0.16, 0.04], 0.05],
        [[x - 0.21, y, 1.4], [x - 0.25, y, 0.9], 0.05],
        [[x + 0.2, y, 1.4], hand, 0.047],
    ];
    const inside = new Map();
    for (const [a, b, radius] of bones) {
        const steps = Math.ceil(Math.hypot(...a.map((c, i) => b[i] - c)) / (size / 2)) + 1;
        for (let s = 0; s <= steps; ++s) {
            const p = a.map((c, i) => c + ((b[i] - c) * s) / steps);
            const reach = Math.ceil(radius / size);
            const cell = p.map((c) => Math.round(c / size));
            for (let i = -reach; i <= reach; ++i)
                for (let j = -reach; j <= reach; ++j)
                    for (let k = -reach; k <= reach; ++k) {
                        const q = [cell[0] + i, cell[1] + j, cell[2] + k];
                        if (q[2] < 0 || Math.hypot(...q.map((c, n) => c * size - p[n])) > radius) continue;
                        inside.set(q.join(), q);
                    }
        }
    }
    return [...inside.values()].flatMap((q) => q.map((c) => Math.round(c * size * 1e4) / 1e4));
}

const healthySensor = (name) => ({ name, state: "running", reason: "", frames: 4321, dropped: 0, restarts: 0, age_ms: 12 });

/** A live message of a station where all is well; `changes` replace its members. */
export function live(timestampUs, changes = {}) {
    return {
        frame: {
            timestamp_us: timestampUs,
            part: { state: "tracking", ...partPose, at_rest: true, fitness: 0.93, reason: "" },
            joints: null,
            pose_energy: null,
            pointing: null,
            marks: [],
            stage_ms: { total: 14.3 },
        },
        sensors: [healthySensor("left"), healthySensor("right")],
        plc: { state: "alive", reason: "" },
        record: { state: "ready", reason: "" },
        session: "demo",
        progress: 0.4,
        finished: false,
        trouble: "",
        stale_after_ms: 1000,
        marks_total: 0,
        ...changes,
    };
}

/** A mark as /api/marks tells it. */
export function mark(id, position, changes = {}) {
    const upper = position[2] >= 0;
    return {
        id,
        position_part: position,
        normal_part: [0, -1, 0],
        zone: `${upper ? "upper" : "lower"} ${position[0] < 0 ? "left" : "right"}`,
        arm: position[0] < 0 ? "left" : "right",
        time: new Date(Date.UTC(2026, 0, 5, 9, 30, 7 * id)).toISOString(),
        confidence: 0.97 - 0.03 * id,
        state: "open",
        touch: false,
        ...changes,
    };
}

/** A pointing ray from `origin` (world) to a spot of the part (part frame), part at `partPose`. */
export function pointing(origin, hitPart, arm = "right") {
    const hit = hitPart.map((c, i) => c + partPose.translation[i]);
    const along = hit.map((c, i) => c - origin[i]);
    return { arm, origin, direction: along.map((c) => c / Math.hypot(...along)), hit_part: hitPart };
}
