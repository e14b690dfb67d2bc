// The pointing ray from the fingertip to the skin, and the cursor where it hits; nothing when the arm is not seen.
import { CylinderGeometry, SphereGeometry, Group, Matrix4, Mesh, MeshBasicMaterial, type PerspectiveCamera, Quaternion, Vector3 } from "three";

import { isStale } from "../situation";
import type { ScreenState } from "../store";
import { Label } from "./label";
import { palette } from "./palette";
import { matrixOf } from "./pose";
import type { SceneLayer } from "./scene_layer";

const missLength = 2.5; // how far a ray that hits nothing is drawn [m]
const up = new Vector3(0, 1, 0);

function drawCursor(context: CanvasRenderingContext2D, size: number): void {
    const middle = size / 2;
    const stroke = (width: number, style: string) => {
        context.lineWidth = size * width;
        context.strokeStyle = style;
        context.beginPath();
        context.arc(middle, middle, size * 0.3, 0, 2 * Math.PI);
        for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
            context.moveTo(middle + dx * size * 0.2, middle + dy * size * 0.2);
            context.lineTo(middle + dx * size * 0.45, middle + dy * size * 0.45);
        }
        context.stroke();
    };
    stroke(0.1, palette.paper);
    stroke(0.045, palette.ink);
}

export class PointingLayer implements SceneLayer {
    readonly object = new Group();
    private readonly geometry = new CylinderGeometry(1, 1, 1, 12);
    private readonly tipGeometry = new SphereGeometry(1, 16, 12);
    private readonly material = new MeshBasicMaterial({ color: palette.pointer, transparent: true, opacity: 0.8 });
    private readonly ray: Mesh;
    private readonly tip: Mesh;
    private readonly cursor = new Label(128, 128, drawCursor);

    /** `frame` as in PartLayer. */
    constructor(
        private readonly frame: "part" | "world",
        private readonly camera: PerspectiveCamera,
        private readonly radius: number,
        private readonly cursorShare: number,
    ) {
        this.ray = new Mesh(this.geometry, this.material);
        this.cursor.sprite.renderOrder = 30;
        this.tip = new Mesh(this.tipGeometry, this.material);
        this.tip.scale.setScalar(radius * 2.2);
        this.object.add(this.ray, this.tip, this.cursor.sprite);
        this.object.visible = false;
    }

    update(state: ScreenState): boolean {
        const was = this.object.visible;
        this.object.visible = this.place(state);
        return this.object.visible || was;
    }

    dispose(): void {
        this.geometry.dispose();
        this.tipGeometry.dispose();
        this.material.dispose();
        this.cursor.dispose();
    }

    private place(state: ScreenState): boolean {
        const frame = state.live?.frame ?? null;
        const pointing = frame?.pointing ?? null;
        if (pointing === null || isStale(state)) return false;
        const pose = frame?.part?.worldFromPart ?? null;
        const worldFromPart = pose === null ? null : matrixOf(pose);
        if (this.frame === "part" && worldFromPart === null) return false;

        const origin = new Vector3(...pointing.origin);
        const hit =
            pointing.hitPart === null || worldFromPart === null
                ? null
                : new Vector3(...pointing.hitPart).applyMatrix4(worldFromPart);
        const end = hit ?? origin.clone().addScaledVector(new Vector3(...pointing.direction), missLength);
        if (this.frame === "part" && worldFromPart !== null) {
            const partFromWorld = new Matrix4().copy(worldFromPart).invert();
            origin.applyMatrix4(partFromWorld);
            end.applyMatrix4(partFromWorld);
        }
        const along = end.clone().sub(origin);
        const length = Math.max(along.length(), 1e-3);
        this.ray.position.copy(origin).addScaledVector(along, 0.5);
        this.ray.quaternion.copy(new Quaternion().setFromUnitVectors(up, along.divideScalar(length)));
        this.tip.position.copy(origin);
        this.ray.scale.set(this.radius, length, this.radius);
        this.cursor.sprite.visible = hit !== null;
        this.cursor.sprite.position.copy(end);
        this.cursor.resize(this.cursorShare, this.camera.fov);
        return true;
    }
}
