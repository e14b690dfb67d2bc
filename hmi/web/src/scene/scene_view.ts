// One way of looking: a scene with its layers, a camera that frames it, and orbit by hand.
import { AmbientLight, Box3, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Vector3, type WebGLRenderer } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Changed, ScreenState } from "../store";
import type { SceneLayer } from "./scene_layer";

/** What other things hide of a picture, from its edges [pixel]. */
export interface Covered {
    readonly left: number;
    readonly bottom: number;
}

export class SceneView {
    readonly camera = new PerspectiveCamera(30, 1, 0.05, 60);
    private readonly scene = new Scene();
    private readonly controls: OrbitControls;
    private readonly layers: SceneLayer[] = [];
    private home: { bounds: Box3; towards: Vector3; margin: number } | null = null;
    private touched = false;
    private shape = "";
    private freeWidth = 1; // shares of the picture that nothing covers
    private freeHeight = 1;

    constructor(canvas: HTMLCanvasElement, onMove: () => void) {
        this.camera.up.set(0, 0, 1);
        this.controls = new OrbitControls(this.camera, canvas);
        this.controls.enabled = false;
        this.controls.enableDamping = false;
        this.controls.zoomSpeed = 0.8;
        this.controls.addEventListener("change", onMove);
        this.controls.addEventListener("start", () => {
            this.touched = true;
        });
        // The sun goes with the viewer, so that a part is as well lit from every side.
        const sun = new DirectionalLight(0xffffff, 1.7);
        sun.position.set(-0.6, 1.2, 1);
        this.camera.add(sun);
        this.scene.add(this.camera, new HemisphereLight(0xffffff, 0xb4bcc2, 1.5), new AmbientLight(0xffffff, 0.35));
    }

    add(layer: SceneLayer): void {
        this.layers.push(layer);
        this.scene.add(layer.object);
    }

    set active(active: boolean) {
        this.controls.enabled = active;
    }

    /**
     * Frames `bounds`, seen from the direction `towards` (from the middle to the viewer) and from `margin` times the
     * distance at which all of it is just in the picture; a hand on it keeps its view.
     */
    frame(bounds: Box3, towards: Vector3, margin: number): void {
        this.home = { bounds, towards, margin };
        if (!this.touched) this.goHome();
    }

    goHome(): void {
        this.touched = false;
        if (this.home === null) return;
        const { bounds, towards, margin } = this.home;
        const middle = bounds.getCenter(new Vector3());
        const direction = towards.clone().normalize();
        const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
        const above = new Vector3().crossVectors(direction, right);
        const halfHeight = Math.tan((this.camera.fov * Math.PI) / 360);
        const halfWidth = halfHeight * this.camera.aspect;
        let distance = 0;
        for (let corner = 0; corner < 8; ++corner) {
            const p = new Vector3(
                corner & 1 ? bounds.max.x : bounds.min.x,
                corner & 2 ? bounds.max.y : bounds.min.y,
                corner & 4 ? bounds.max.z : bounds.min.z,
            ).sub(middle);
            const near = p.dot(direction);
            distance = Math.max(
                distance,
                near + Math.abs(p.dot(right)) / (halfWidth * this.freeWidth),
                near + Math.abs(p.dot(above)) / (halfHeight * this.freeHeight),
            );
        }
        this.camera.position.copy(middle).addScaledVector(direction, distance * margin);
        this.controls.target.copy(middle);
        this.controls.minDistance = distance * 0.15;
        this.controls.maxDistance = distance * 3;
        this.controls.update();
    }

    update(state: ScreenState, changed: Changed): boolean {
        let drawn = false;
        for (const layer of this.layers) drawn = layer.update(state, changed) || drawn;
        return drawn;
    }

    animate(nowMs: number): boolean {
        let moving = false;
        for (const layer of this.layers) moving = (layer.animate?.(nowMs) ?? false) || moving;
        return moving;
    }

    /** Draws `width` x `height` pixels; the home view stands in the middle of what `covered` leaves free. */
    render(renderer: WebGLRenderer, width: number, height: number, covered: Covered): void {
        const shape = `${width} ${height} ${covered.left} ${covered.bottom}`;
        if (shape !== this.shape) {
            this.shape = shape;
            this.freeWidth = 1 - covered.left / width;
            this.freeHeight = 1 - covered.bottom / height;
            this.camera.aspect = width / height;
            this.camera.setViewOffset(width, height, -covered.left / 2, covered.bottom / 2, width, height);
            if (!this.touched) this.goHome();
        }
        for (const layer of this.layers) layer.fit?.(height);
        renderer.render(this.scene, this.camera);
    }

    dispose(): void {
        this.controls.dispose();
        for (const layer of this.layers) {
            this.scene.remove(layer.object);
            layer.dispose();
        }
    }
}
