// Poses of the protocol as matrices of the renderer.
import { Matrix4 } from "three";

import type { Pose } from "../protocol";

export function matrixOf(bFromA: Pose): Matrix4 {
    const [r0, r1, r2] = bFromA.rotation;
    const t = bFromA.translation;
    // prettier-ignore
    return new Matrix4().set(
        r0[0], r0[1], r0[2], t[0],
        r1[0], r1[1], r1[2], t[1],
        r2[0], r2[1], r2[2], t[2],
        0, 0, 0, 1);
}
