// The sensors where they hang, with their view; one that is not well is amber, dashed and named so.
import { BufferGeometry, Float32BufferAttribute, Group, LineBasicMaterial, LineDashedMaterial, LineSegments, Matrix4, type PerspectiveCamera } from "three";

import type { SensorView } from "../protocol";
import { isStale, sensorSeverity } from "../situation";
import type { Changed, ScreenState } from "../store";
import { Label } from "./label";
import { palette } from "./palette";
import { matrixOf } from "./pose";
import type { SceneLayer } from "./scene_layer";

const leastLabelPx = 22;
const depth = 0.45; // how far the drawn view reaches [m]

function outline(sensor: SensorView): BufferGeometry {
    const corner = (u: number, v: number): [number, number, number] => [
        (depth * (u - sensor.cx)) / sensor.fx,
        (depth * (v - sensor.cy)) / sensor.fy,
        depth,
    ];
    const corners = [
        corner(0, 0),
        corner(sensor.width - 1, 0),
        corner(sensor.width - 1, sensor.height - 1),
        corner(0, sensor.height - 1),
    ];
    const points: number[] = [];
    corners.forEach((from, i) => {
        const to = corners[(i + 1) % 4] ?? from;
        points.push(0, 0, 0, ...from, ...from, ...to);
    });
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
    return geometry;
}

export class SensorsLayer implements SceneLayer {
    readonly object = new Group();
    private readonly wellMaterial = new LineBasicMaterial({ color: palette.sensor, transparent: true, opacity: 0.8 });
    private readonly illMaterial = new LineDashedMaterial({ color: palette.sensorAbnormal, dashSize: 0.04, gapSize: 0.03 });
    private labels: Label[] = [];
    private drawnKey = "";
    private share: number;

    constructor(
        private readonly camera: PerspectiveCamera,
        private readonly labelShare: number,
    ) {
        this.share = labelShare;
    }

    update(state: ScreenState, changed: Changed): boolean {
        if (!changed.has("cell") && !changed.has("live") && !changed.has("now")) return false;
        const sensors = state.cell?.sensors ?? [];
        const ill = sensors.map((sensor) => {
            const health = state.live?.sensors.find((candidate) => candidate.name === sensor.name);
            return health !== undefined && !isStale(state) && sensorSeverity(health) !== "normal";
        });
        const key = JSON.stringify([sensors, ill]);
        if (key === this.drawnKey) return false;
        this.drawnKey = key;
        this.clear();
        sensors.forEach((sensor, i) => this.add(sensor, ill[i] === true));
        return true;
    }

    fit(heightPx: number): void {
        const share = Math.max(this.labelShare, leastLabelPx / heightPx);
        if (share === this.share) return;
        this.share = share;
        for (const label of this.labels) label.resize(share, this.camera.fov);
    }

    dispose(): void {
        this.clear();
        this.wellMaterial.dispose();
        this.illMaterial.dispose();
    }

    private add(sensor: SensorView, ill: boolean): void {
        const worldFromCamera = new Matrix4().copy(matrixOf(sensor.cameraFromWorld)).invert();
        const lines = new LineSegments(outline(sensor), ill ? this.illMaterial : this.wellMaterial);
        if (ill) lines.computeLineDistances();
        lines.applyMatrix4(worldFromCamera);
        const label = new Label(320, 64, (context, width, height) => {
            context.font = `600 ${height * 0.6}px "Inter Variable", sans-serif`;
            context.textAlign = "center";
            context.textBaseline = "middle";
            context.lineJoin = "round";
            context.lineWidth = height * 0.2;
            context.strokeStyle = "rgba(255, 255, 255, 0.85)";
            const text = ill ? `${sensor.name} \u26a0` : sensor.name;
            context.strokeText(text, width / 2, height / 2);
            context.fillStyle = ill ? "#8a3f04" : palette.ink;
            context.fillText(text, width / 2, height / 2);
        });
        label.sprite.position.setFromMatrixPosition(worldFromCamera);
        label.sprite.center.set(0.5, -0.35);
        label.resize(this.share, this.camera.fov);
        this.labels.push(label);
        this.object.add(lines, label.sprite);
    }

    private clear(): void {
        for (const child of [...this.object.children]) {
            this.object.remove(child);
            if (child instanceof LineSegments) (child.geometry as BufferGeometry).dispose();
        }
        for (const label of this.labels) label.dispose();
        this.labels = [];
    }
}
