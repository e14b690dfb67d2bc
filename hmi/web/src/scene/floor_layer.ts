// The cell's floor with a metre grid, for scale.
import { BufferGeometry, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PlaneGeometry } from "three";

import type { Changed, ScreenState } from "../store";
import { palette } from "./palette";
import type { SceneLayer } from "./scene_layer";

const spacing = 0.5; // [m]

export class FloorLayer implements SceneLayer {
    readonly object = new Group();
    private readonly ground = new MeshBasicMaterial({ color: palette.floor });
    private readonly lines = new LineBasicMaterial({ color: palette.floorLines });
    private drawn: readonly (Mesh | LineSegments)[] = [];

    update(state: ScreenState, changed: Changed): boolean {
        if (!changed.has("cell")) return false;
        this.clear();
        const box = state.cell?.box ?? { min: [-2, -1.5, 0] as const, max: [2, 1.5, 2.2] as const };
        const width = box.max[0] - box.min[0];
        const depth = box.max[1] - box.min[1];
        const plane = new Mesh(new PlaneGeometry(width, depth), this.ground);
        plane.position.set(box.min[0] + width / 2, box.min[1] + depth / 2, -0.004);
        const points: number[] = [];
        for (let i = 0; i <= Math.round(width / spacing); ++i) {
            const x = box.min[0] + (i * width) / Math.round(width / spacing);
            points.push(x, box.min[1], 0, x, box.max[1], 0);
        }
        for (let i = 0; i <= Math.round(depth / spacing); ++i) {
            const y = box.min[1] + (i * depth) / Math.round(depth / spacing);
            points.push(box.min[0], y, 0, box.max[0], y, 0);
        }
        const grid = new BufferGeometry();
        grid.setAttribute("position", new Float32BufferAttribute(points, 3));
        this.drawn = [plane, new LineSegments(grid, this.lines)];
        this.object.add(...this.drawn);
        return true;
    }

    dispose(): void {
        this.clear();
        this.ground.dispose();
        this.lines.dispose();
    }

    private clear(): void {
        for (const old of this.drawn) {
            this.object.remove(old);
            (old.geometry as BufferGeometry).dispose();
        }
        this.drawn = [];
    }
}
