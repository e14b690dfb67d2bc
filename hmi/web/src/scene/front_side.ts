// Where to look at a part from: the outside of its skin. Numbers only.
import type { Mesh, Vector } from "../protocol";

export interface Extent {
    readonly min: Vector;
    readonly max: Vector;
}

/** Bounds of a mesh; a cube of a metre around the origin when it has no vertex. */
export function extentOf(mesh: Mesh): Extent {
    const min: [number, number, number] = [Infinity, Infinity, Infinity];
    const max: [number, number, number] = [-Infinity, -Infinity, -Infinity];
    mesh.positions.forEach((value, i) => {
        const axis = (i % 3) as 0 | 1 | 2;
        min[axis] = Math.min(min[axis], value);
        max[axis] = Math.max(max[axis], value);
    });
    return mesh.positions.length === 0 ? { min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5] } : { min, max };
}

/**
 * Unit vector from the part towards someone in front of it: along its shorter horizontal axis (Z is up in the part
 * frame), to the side that bulges. A shell such as a bumper has most of its skin there, so the centre of its area
 * lies on that side of the middle of its bounds. A part without such a side is seen from -y or -x.
 */
export function frontDirection(mesh: Mesh): Vector {
    const { min, max } = extentOf(mesh);
    const axis = max[0] - min[0] < max[1] - min[1] ? 0 : 1;
    let area = 0;
    let moment = 0;
    const at = (corner: number, k: number) => mesh.positions[3 * corner + k] ?? 0;
    for (let t = 0; t + 2 < mesh.indices.length; t += 3) {
        const a = mesh.indices[t] ?? 0;
        const b = mesh.indices[t + 1] ?? 0;
        const c = mesh.indices[t + 2] ?? 0;
        const u = [0, 1, 2].map((k) => at(b, k) - at(a, k)) as [number, number, number];
        const v = [0, 1, 2].map((k) => at(c, k) - at(a, k)) as [number, number, number];
        const size = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
        area += size;
        moment += (size * (at(a, axis) + at(b, axis) + at(c, axis))) / 3;
    }
    const depth = max[axis] - min[axis];
    const bulge = area > 0 && depth > 0 ? (moment / area - (min[axis] + max[axis]) / 2) / depth : 0;
    const sign = bulge > 0.02 ? 1 : -1;
    return axis === 0 ? [sign, 0, 0] : [0, sign, 0];
}
