// The defects as numbered red dots on the part; a new one pulses, the chosen one is ringed.
import { Group, type PerspectiveCamera, Vector3 } from "three";

import type { Mark } from "../protocol";
import { isStale } from "../situation";
import type { Changed, ScreenState } from "../store";
import { Label } from "./label";
import { palette } from "./palette";
import { matrixOf } from "./pose";
import type { SceneLayer } from "./scene_layer";

const pulseMs = 6000;
const pulsePeriodMs = 1200;
const leastDotPx = 18;
/** Dots float this far above the skin [m], so that the skin itself hides those on its far side only. */
const lift = 0.012;

/** Of the dot's height, by number of digits. */
const fontShares: Readonly<Record<number, number>> = { 1: 0.56, 2: 0.5, 3: 0.38, 4: 0.3 };

interface Dot {
    readonly mark: Mark;
    readonly key: string;
    readonly label: Label;
    readonly ring: Label;
    readonly place: Vector3;
    readonly normal: Vector3;
}

function drawDot(mark: Mark): (context: CanvasRenderingContext2D, size: number) => void {
    return (context, size) => {
        const middle = size / 2;
        const circle = (radius: number) => {
            context.beginPath();
            context.arc(middle, middle, radius * middle, 0, 2 * Math.PI);
        };
        const withdrawn = mark.state === "withdrawn";
        circle(0.97);
        context.fillStyle = withdrawn ? palette.withdrawn : palette.paper;
        context.fill();
        circle(0.82);
        context.fillStyle = withdrawn ? palette.paper : palette.defect;
        context.fill();
        context.fillStyle = withdrawn ? palette.ink : palette.paper;
        const text = String(mark.id);
        context.font = `700 ${Math.round(size * (fontShares[text.length] ?? 0.26))}px "Inter Variable", sans-serif`;
        context.textAlign = "center";
        context.textBaseline = "middle";
        context.fillText(text, middle, middle + size * 0.03);
        if (!withdrawn) return;
        context.strokeStyle = palette.withdrawn;
        context.lineWidth = size * 0.07;
        context.beginPath();
        context.moveTo(size * 0.2, size * 0.8);
        context.lineTo(size * 0.8, size * 0.2);
        context.stroke();
    };
}

function drawRing(context: CanvasRenderingContext2D, size: number): void {
    context.beginPath();
    context.arc(size / 2, size / 2, size * 0.44, 0, 2 * Math.PI);
    context.lineWidth = size * 0.05;
    context.strokeStyle = palette.paper;
    context.stroke();
    context.lineWidth = size * 0.03;
    context.strokeStyle = palette.defect;
    context.stroke();
}

export class MarksLayer implements SceneLayer {
    readonly object = new Group();
    private readonly dots = new Map<number, Dot>();
    private arrivals: ReadonlyMap<number, number> = new Map();
    private selected: number | null = null;
    private now = 0;
    private share: number;

    /** `frame` as in PartLayer; `dotShare` the dots' height as a share of the picture's. */
    constructor(
        private readonly frame: "part" | "world",
        private readonly camera: PerspectiveCamera,
        private readonly dotShare: number,
    ) {
        this.object.matrixAutoUpdate = false;
        this.share = dotShare;
    }

    update(state: ScreenState, changed: Changed): boolean {
        let drawn = false;
        if (changed.has("marks")) {
            this.rebuild(state.marks);
            drawn = true;
        }
        if (changed.has("arrivals") || changed.has("selectedMark")) {
            this.arrivals = state.arrivals;
            this.selected = state.selectedMark;
            drawn = true;
        }
        if (this.frame === "world") {
            const pose = isStale(state) ? null : (state.live?.frame?.part?.worldFromPart ?? null);
            drawn ||= this.object.visible !== (pose !== null);
            this.object.visible = pose !== null;
            if (pose !== null && changed.has("live")) {
                this.object.matrix.copy(matrixOf(pose));
                this.object.matrixWorldNeedsUpdate = true;
            }
        }
        return drawn;
    }

    animate(nowMs: number): boolean {
        this.now = nowMs;
        let moving = false;
        for (const dot of this.dots.values()) moving = this.dress(dot) || moving;
        return moving;
    }

    fit(heightPx: number): void {
        const share = Math.max(this.dotShare, leastDotPx / heightPx);
        if (share === this.share) return;
        this.share = share;
        for (const dot of this.dots.values()) this.dress(dot);
    }

    /** The mark whose dot is nearest to a point of the picture (-1 to 1 each way), within `reach` of its height. */
    at(x: number, y: number, aspect: number, reach: number): number | null {
        let best: number | null = null;
        let least = reach * 2;
        const spot = new Vector3();
        for (const dot of this.dots.values()) {
            if (!dot.label.sprite.visible || !this.faces(dot)) continue;
            spot.copy(dot.place).applyMatrix4(this.object.matrixWorld).project(this.camera);
            const distance = Math.hypot((spot.x - x) * aspect, spot.y - y);
            if (distance >= least) continue;
            least = distance;
            best = dot.mark.id;
        }
        return best;
    }

    dispose(): void {
        this.rebuild([]);
    }

    private rebuild(marks: readonly Mark[]): void {
        const wanted = new Map(marks.map((mark) => [mark.id, mark]));
        for (const [id, dot] of this.dots) {
            const mark = wanted.get(id);
            if (mark !== undefined && JSON.stringify(mark) === dot.key) continue;
            this.object.remove(dot.label.sprite, dot.ring.sprite);
            dot.label.dispose();
            dot.ring.dispose();
            this.dots.delete(id);
        }
        for (const mark of marks) {
            if (this.dots.has(mark.id)) continue;
            const normal = new Vector3(...mark.normal).normalize();
            const place = new Vector3(...mark.position).addScaledVector(normal, lift);
            const label = new Label(128, 128, drawDot(mark));
            const ring = new Label(256, 256, drawRing);
            label.sprite.position.copy(place);
            ring.sprite.position.copy(place);
            label.sprite.renderOrder = 20 + mark.id / 1e6;
            ring.sprite.renderOrder = 19;
            this.object.add(ring.sprite, label.sprite);
            const dot = { mark, key: JSON.stringify(mark), label, ring, place, normal };
            this.dots.set(mark.id, dot);
            this.dress(dot);
        }
    }

    /** Whether the dot's side of the skin looks at the viewer. */
    private faces(dot: Dot): boolean {
        const place = dot.place.clone().applyMatrix4(this.object.matrixWorld);
        const normal = dot.normal.clone().transformDirection(this.object.matrixWorld);
        return this.camera.position.clone().sub(place).dot(normal) > 0;
    }

    private dress(dot: Dot): boolean {
        const chosen = dot.mark.id === this.selected;
        const age = this.now - (this.arrivals.get(dot.mark.id) ?? -Infinity);
        const pulsing = age < pulseMs && dot.mark.state !== "withdrawn";
        const phase = pulsing ? (age % pulsePeriodMs) / pulsePeriodMs : 0;
        // What lies on the far side shows through faintly: known, but not here.
        dot.label.sprite.material.opacity = this.faces(dot) ? 1 : 0.25;
        dot.label.resize(this.share * (chosen ? 1.25 : 1), this.camera.fov);
        dot.ring.sprite.visible = chosen || pulsing;
        dot.ring.sprite.material.opacity = pulsing ? 1 - phase : 1;
        dot.ring.resize(this.share * (pulsing ? 1.2 + 2.4 * phase : 1.75), this.camera.fov);
        return pulsing;
    }
}
