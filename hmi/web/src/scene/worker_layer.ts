// The worker as the station sees him now: his voxels as cubes. Gone as soon as they are not of this moment.
import { BoxGeometry, InstancedMesh, MeshLambertMaterial, Group } from "three";

import type { Voxels } from "../protocol";
import { isStale } from "../situation";
import type { Changed, ScreenState } from "../store";
import { palette } from "./palette";
import type { SceneLayer } from "./scene_layer";

/** The binary message follows its frame at once; older than this they are of another moment. */
const sameMomentUs = 300_000;
const gap = 0.9; // cube edge as a share of the voxel's, so that single voxels can be told apart

export class WorkerLayer implements SceneLayer {
    readonly object = new Group();
    private readonly geometry = new BoxGeometry(1, 1, 1);
    private readonly material = new MeshLambertMaterial({ color: palette.worker });
    private cubes: InstancedMesh | null = null;

    update(state: ScreenState, changed: Changed): boolean {
        const was = this.object.visible;
        const frame = state.live?.frame ?? null;
        const current =
            state.voxels !== null &&
            frame !== null &&
            !isStale(state) &&
            Math.abs(frame.timestampUs - state.voxels.timestampUs) <= sameMomentUs;
        this.object.visible = current;
        if (changed.has("voxels") && state.voxels !== null) this.fill(state.voxels);
        return was !== current || (current && changed.has("voxels"));
    }

    dispose(): void {
        this.cubes?.dispose();
        this.geometry.dispose();
        this.material.dispose();
    }

    private fill(voxels: Voxels): void {
        const count = voxels.centres.length / 3;
        if (this.cubes === null || this.cubes.instanceMatrix.count < count) {
            if (this.cubes !== null) {
                this.object.remove(this.cubes);
                this.cubes.dispose();
            }
            this.cubes = new InstancedMesh(this.geometry, this.material, Math.max(4096, Math.ceil(count * 1.5)));
            this.cubes.frustumCulled = false;
            this.object.add(this.cubes);
        }
        const matrices = this.cubes.instanceMatrix.array;
        const edge = voxels.size * gap;
        for (let i = 0; i < count; ++i) {
            const at = 16 * i;
            matrices[at] = matrices[at + 5] = matrices[at + 10] = edge;
            matrices[at + 12] = voxels.centres[3 * i] ?? 0;
            matrices[at + 13] = voxels.centres[3 * i + 1] ?? 0;
            matrices[at + 14] = voxels.centres[3 * i + 2] ?? 0;
            matrices[at + 15] = 1;
        }
        this.cubes.count = count;
        this.cubes.instanceMatrix.needsUpdate = true;
    }
}
