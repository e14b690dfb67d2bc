// The part's outer skin with its feature edges; in the cell view at its tracked pose, and only while tracked.
import {
    BufferAttribute,
    BufferGeometry,
    DoubleSide,
    EdgesGeometry,
    Group,
    LineBasicMaterial,
    LineSegments,
    Mesh as DrawnMesh,
    MeshStandardMaterial,
} from "three";
import { mergeVertices, toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";

import type { Mesh } from "../protocol";
import { isStale } from "../situation";
import type { Changed, ScreenState } from "../store";
import { longLines } from "./long_lines";
import { palette } from "./palette";
import { matrixOf } from "./pose";
import type { SceneLayer } from "./scene_layer";

const creaseRadians = (50 * Math.PI) / 180;
const edgeDegrees = 40;
const leastLine = 0.1; // shorter lines are the mesh's own, not the part's [m]

export class PartLayer implements SceneLayer {
    readonly object = new Group();
    private readonly skinMaterial = new MeshStandardMaterial({
        color: palette.part,
        roughness: 0.5,
        metalness: 0.05,
        side: DoubleSide,
        // Edges and dots lie on the skin and must win against it.
        polygonOffset: true,
        polygonOffsetFactor: 1,
        polygonOffsetUnits: 1,
    });
    private readonly edgeMaterial = new LineBasicMaterial({ color: palette.partEdges, transparent: true, opacity: 0.55 });
    private skin: DrawnMesh | null = null;
    private edges: LineSegments | null = null;

    /** `frame` "part": always at the origin; "world": at its pose. */
    constructor(private readonly frame: "part" | "world") {
        this.object.matrixAutoUpdate = false;
    }

    update(state: ScreenState, changed: Changed): boolean {
        let drawn = false;
        if (changed.has("mesh")) {
            this.build(state.mesh);
            drawn = true;
        }
        const part = state.live?.frame?.part ?? null;
        const locked = part?.state === "tracking" && !isStale(state);
        const color = locked ? palette.part : palette.partUnlocked;
        if (this.frame === "part" && this.skinMaterial.color.getHex() !== color) {
            this.skinMaterial.color.setHex(color);
            drawn = true;
        }
        if (this.frame === "world") {
            const pose = locked ? (part?.worldFromPart ?? null) : null;
            drawn ||= this.object.visible !== (pose !== null);
            this.object.visible = pose !== null;
            if (pose !== null && changed.has("live")) {
                this.object.matrix.copy(matrixOf(pose));
                this.object.matrixWorldNeedsUpdate = true;
                drawn = true;
            }
        }
        return drawn;
    }

    dispose(): void {
        this.build(null);
        this.skinMaterial.dispose();
        this.edgeMaterial.dispose();
    }

    private build(mesh: Mesh | null): void {
        for (const old of [this.skin, this.edges]) {
            if (old === null) continue;
            this.object.remove(old);
            old.geometry.dispose();
        }
        this.skin = this.edges = null;
        if (mesh === null) return;
        const raw = new BufferGeometry();
        raw.setAttribute("position", new BufferAttribute(mesh.positions, 3));
        raw.setIndex(new BufferAttribute(mesh.indices, 1));
        // CAD files repeat a vertex for every face: first make it one surface, then crease it where it is sharp.
        const welded = mergeVertices(raw, 1e-5);
        const sharp = new EdgesGeometry(welded, edgeDegrees);
        const lines = longLines(sharp.getAttribute("position").array as Float32Array, leastLine);
        sharp.dispose();
        const drawn = new BufferGeometry();
        drawn.setAttribute("position", new BufferAttribute(lines, 3));
        this.edges = new LineSegments(drawn, this.edgeMaterial);
        this.skin = new DrawnMesh(toCreasedNormals(welded, creaseRadians), this.skinMaterial);
        welded.dispose();
        raw.dispose();
        this.object.add(this.skin, this.edges);
    }
}
